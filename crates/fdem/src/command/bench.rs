//! `fdem bench` reads a packing, times the engines in turn and prints a table.

use std::fmt::{self, Write as _};
use std::hint::black_box;
use std::io::{self, Write};
use std::num::NonZero;
use std::time::{Duration, Instant};

use fdem_contact::{CGrid, Couple, Direct, Elements, Engine, Error, Multilevel, Nbs, Rows, Search, Simd};
use fdem_io::{Centres, Packing};
use serde::Serialize;

use fdem_results::detection::DetectionRequest;

use crate::command::args::{BenchArguments, Contestant};
use crate::command::device::{self, KeptSearch};
use crate::command::device_name::DeviceName;
use crate::command::failure::Failure;
use crate::command::input::{self, Input, refusal, refused, sizes};
use crate::command::output::{Output, refuse_to_overwrite};
use crate::command::progress::Progress;
use crate::command::summary::grouped;

/// Most elements for which the engine direct is timed by default. With more, a run takes seconds.
const MOST_FOR_DIRECT: usize = 50_000;

pub(crate) fn run(arguments: &BenchArguments) -> Result<(), Failure> {
    refuse_to_overwrite(&[("the input", Some(&arguments.input.file)), ("--json", arguments.json.as_ref())])?;
    let mut json = arguments.json.as_deref().map(|path| Output::open(Some(path))).transpose()?;
    let mut table = Output::open(None)?;
    if arguments.input.cutoff.as_ref().is_some_and(|cutoff| cutoff.pairs().is_some()) {
        return Err(Failure::Unusable(
            "--cutoff by pairs of types is for fdem contacts: engines search with one cut-off, the largest"
                .to_owned(),
        ));
    }
    let input = input::read(&arguments.input, &Progress::new(false))?;
    let name = &input.name;
    let report = match &input.packing.centres {
        Centres::Two(centres) => measure(arguments, &input, centres),
        Centres::Three(centres) => measure(arguments, &input, centres),
    }?;
    table.write(|out| write!(out, "{report}"))?;
    report.check(name)?;
    if let Some(mut json) = json.take() {
        json.write(|out| {
            serde_json::to_writer_pretty(&mut *out, &report.rows)?;
            out.write_all(b"\n")
        })?;
        json.commit()?;
    }
    Ok(())
}

fn measure<const D: usize>(
    arguments: &BenchArguments,
    input: &Input,
    centres: &[[f64; D]],
) -> Result<Report, Failure> {
    let Input { name, packing, .. } = input;
    let request = DetectionRequest {
        sizes: sizes(&arguments.input, input)?,
        bodies: None,
        tolerance: arguments.input.tolerance,
        engine: None,
        device: None,
        threads: 1,
        keep: true,
    };
    // Elements that no engine accepts are an error, not a row of the table.
    let elements = request.elements(centres).map_err(|error| refused(name, packing, &error))?;
    let mut contenders = contenders(arguments, &elements)?;
    if let DeviceName::Gpu(number) = arguments.device {
        let search = device::search(number).map_err(|why| device::unusable(&why))?;
        let contender = Contender {
            search: AnySearch::Device { number, search },
            simd: None,
            threads: 0,
            elements: elements.len(),
            result: Ok(0),
            times: Vec::with_capacity(arguments.repeat),
        };
        contenders.insert(0, contender);
    }

    // There is no progress bar, because its thread would be measured too. All engines write into the same
    // list, so that they find the same memory allocated.
    let mut couples = Vec::new();
    for run in 0..=arguments.repeat {
        for contender in &mut contenders {
            contender.run(centres, &request, &mut couples, run > 0);
        }
    }
    Ok(Report { rows: contenders.into_iter().map(|contender| contender.row(packing)).collect() })
}

/// The engines to time, in the order of the table.
fn contenders<const D: usize>(
    arguments: &BenchArguments,
    elements: &Elements<'_, f64, D>,
) -> Result<Vec<Contender<D>>, Failure> {
    let count = elements.len();
    let mut engines = arguments.engines.clone().unwrap_or_else(|| {
        let mut engines = vec![Contestant::Rows, Contestant::Nbs];
        if Multilevel::new().levels(elements).len() > 1 {
            engines.insert(1, Contestant::Multilevel);
        }
        if count <= MOST_FOR_DIRECT {
            engines.push(Contestant::Direct);
            return engines;
        }
        // Nothing can be done if even this message cannot be printed.
        let _ = writeln!(
            io::stderr(),
            "direct is left out: comparing all pairs of {} elements takes long. --engines rows,nbs,direct includes it",
            grouped(count as u64)
        );
        engines
    });
    let mut seen = Vec::new();
    engines.retain(|engine| {
        !seen.contains(engine) && {
            seen.push(*engine);
            true
        }
    });
    let mut contenders = Vec::new();
    for engine in engines {
        let mut add = |search, simd, threads| {
            contenders.push(Contender {
                search,
                simd,
                threads,
                elements: count,
                result: Ok(0),
                times: Vec::with_capacity(arguments.repeat),
            });
        };
        match engine {
            Contestant::Rows => {
                let simd = arguments.simd.into();
                let rows = Rows::new().with_simd(simd).map_err(|error| unusable("--simd", &error))?;
                for threads in arguments.threads.iter().copied().map(threads_of) {
                    let rows = rows.clone().with_threads(threads);
                    let rows = rows.map_err(|error| unusable("--threads", &error))?;
                    add(AnySearch::Rows(Box::new(rows)), Some(simd), threads);
                }
            }
            Contestant::Multilevel => {
                let simd = arguments.simd.into();
                let levels = Multilevel::new().with_simd(simd).map_err(|error| unusable("--simd", &error))?;
                for threads in arguments.threads.iter().copied().map(threads_of) {
                    let levels = levels.clone().with_threads(threads);
                    let levels = levels.map_err(|error| unusable("--threads", &error))?;
                    add(AnySearch::Multilevel(Box::new(levels)), Some(simd), threads);
                }
            }
            Contestant::CGrid => add(AnySearch::CGrid(Box::default()), None, 1),
            Contestant::Nbs => add(AnySearch::Nbs(Nbs::new()), None, 1),
            Contestant::Direct => add(AnySearch::Direct, None, 1),
        }
    }
    Ok(contenders)
}

/// Returns the number of threads; 0 means one per processor.
fn threads_of(threads: usize) -> usize {
    if threads > 0 { threads } else { std::thread::available_parallelism().map_or(1, NonZero::get) }
}

fn unusable(option: &str, error: &Error) -> Failure {
    Failure::Unusable(format!("{option}: {error}"))
}

/// An engine that is timed: a row of the table.
struct Contender<const D: usize> {
    search: AnySearch<D>,
    simd: Option<Simd>,
    /// 0 on a device.
    threads: usize,
    elements: usize,
    /// Couples of the latest run, or the reason why there is none.
    result: Result<usize, Error>,
    times: Vec<Duration>,
}

enum AnySearch<const D: usize> {
    Rows(Box<Rows<f64, D>>),
    Multilevel(Box<Multilevel<f64, D>>),
    CGrid(Box<CGrid<f64, D>>),
    Nbs(Nbs<D>),
    Direct,
    Device { number: usize, search: KeptSearch<D> },
}

impl<const D: usize> Contender<D> {
    /// Runs one detection, unless the engine has refused an earlier one. Its time is recorded if `counts`,
    /// which is false for warm-ups.
    fn run(
        &mut self,
        centres: &[[f64; D]],
        request: &DetectionRequest<'_>,
        couples: &mut Vec<Couple>,
        counts: bool,
    ) {
        if self.result.is_err() {
            return;
        }
        let start = Instant::now();
        self.result = self.search.couples(centres, request, couples);
        let time = start.elapsed();
        if counts {
            self.times.push(time);
        }
    }

    fn row(mut self, packing: &Packing) -> EngineRow {
        self.times.sort_unstable();
        let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
        let (engine, bytes, device) = match &self.search {
            AnySearch::Rows(rows) => (Engine::Rows, Some(rows.bytes()), None),
            AnySearch::Multilevel(levels) => (Engine::Multilevel, Some(levels.bytes()), None),
            AnySearch::CGrid(cgrid) => (Engine::CGrid, Some(cgrid.bytes()), None),
            AnySearch::Nbs(nbs) => (Engine::Nbs, Some(nbs.integers() * size_of::<u32>()), None),
            AnySearch::Direct => (Engine::Direct, Some(0), None),
            AnySearch::Device { number, .. } => (Engine::Rows, None, Some(format!("gpu:{number}"))),
        };
        let ran = self.result.is_ok();
        EngineRow {
            engine: engine.name(),
            simd: self.simd.map(Simd::name),
            device,
            threads: self.threads,
            elements: self.elements,
            couples: self.result.as_ref().ok().copied(),
            median_ms: median(&self.times).filter(|_| ran).map(milliseconds),
            best_ms: self.times.first().copied().filter(|_| ran).map(milliseconds),
            bytes_per_element: bytes
                .filter(|_| ran && self.elements > 0)
                .map(|bytes| bytes as f64 / self.elements as f64),
            refused: self.result.err().map(|error| refusal(packing, &error)),
        }
    }
}

impl<const D: usize> AnySearch<D> {
    /// Runs the detection that is timed, including the checks of the elements. Returns the number of couples.
    fn couples(
        &mut self,
        centres: &[[f64; D]],
        request: &DetectionRequest<'_>,
        couples: &mut Vec<Couple>,
    ) -> Result<usize, Error> {
        let elements = request.elements(centres)?;
        match self {
            Self::Rows(rows) => rows.couples(&elements, couples),
            Self::Multilevel(levels) => levels.couples(&elements, couples),
            Self::CGrid(cgrid) => cgrid.couples(&elements, couples),
            Self::Nbs(nbs) => nbs.couples(&elements, couples),
            Self::Direct => Direct.couples(&elements, couples),
            Self::Device { search, .. } => search(&elements, couples),
        }?;
        Ok(black_box(couples).len())
    }
}

/// Median of ascending times; the mean of the middle two if their number is even.
fn median(times: &[Duration]) -> Option<Duration> {
    let upper = times.get(times.len() / 2)?;
    let lower = times[(times.len() - 1) / 2];
    Some((lower + *upper) / 2)
}

/// Measurements of one engine. Missing values are `null` in JSON.
#[derive(Debug, Serialize)]
struct EngineRow {
    engine: &'static str,
    simd: Option<&'static str>,
    /// The graphics processor; left out on the processor.
    #[serde(skip_serializing_if = "Option::is_none")]
    device: Option<String>,
    /// Number of threads; 0 on a graphics processor.
    threads: usize,
    elements: usize,
    couples: Option<usize>,
    median_ms: Option<f64>,
    best_ms: Option<f64>,
    /// Memory that the engine holds, without the coordinates and the couples.
    bytes_per_element: Option<f64>,
    /// Why the engine did not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
}

/// The table that is written to standard output.
struct Report {
    rows: Vec<EngineRow>,
}

impl Report {
    /// Checks that all engines that ran found the same number of couples.
    fn check(&self, name: &str) -> Result<(), Failure> {
        let mut found = self.rows.iter().filter_map(|row| Some((row.engine, row.couples?)));
        let Some((first, couples)) = found.next() else { return Ok(()) };
        found.find(|&(_, others)| others != couples).map_or(Ok(()), |(engine, others)| {
            Err(Failure::Wrong(format!(
                "{name}: {first} found {couples} couples, {engine} found {others}. This is a bug in fdem: please report \
                 it with the file"
            )))
        })
    }

    fn cells(&self, row: &EngineRow) -> [String; 10] {
        let direct = self.rows.iter().find(|row| row.engine == Engine::Direct.name());
        let direct = direct.and_then(|row| row.median_ms);
        let number =
            |x: Option<f64>, digits: usize| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}"));
        let nanoseconds_per = |count: usize| Some(row.median_ms? * 1e6 / count as f64).filter(|_| count > 0);
        let [median, best] = if row.refused.is_some() {
            ["refused".to_owned(), "-".to_owned()]
        } else {
            [number(row.median_ms, 3), number(row.best_ms, 3)]
        };
        [
            row.engine.to_owned(),
            row.device.as_deref().or(row.simd).unwrap_or("-").to_owned(),
            if row.device.is_some() { "-".to_owned() } else { row.threads.to_string() },
            median,
            best,
            number(nanoseconds_per(row.elements), 1),
            number(row.couples.and_then(nanoseconds_per), 1),
            row.couples.map_or_else(|| "-".to_owned(), |couples| grouped(couples as u64)),
            number(row.bytes_per_element, 1),
            number(direct.and_then(|direct| Some(direct / row.median_ms?)), 1),
        ]
    }
}

const HEADER: [&str; 10] = [
    "engine",
    "simd",
    "threads",
    "median ms",
    "best ms",
    "ns/element",
    "ns/couple",
    "couples",
    "bytes/element",
    "direct = 1",
];

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = vec![HEADER.map(str::to_owned)];
        lines.extend(self.rows.iter().map(|row| self.cells(row)));
        for line in &lines {
            let mut text = String::new();
            for (column, cell) in line.iter().enumerate() {
                let width = lines.iter().map(|line| line[column].len()).max().unwrap_or(0);
                // Names are aligned to the left, numbers to the right.
                if column < 2 {
                    write!(text, "{cell:<width$}  ")?;
                } else {
                    write!(text, "{cell:>width$}  ")?;
                }
            }
            writeln!(out, "{}", text.trim_end())?;
        }
        for row in &self.rows {
            if let Some(why) = &row.refused {
                writeln!(out, "{} refused: {why}", row.engine)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(engine: &'static str, couples: Option<usize>, median_ms: Option<f64>) -> EngineRow {
        let refused = couples.is_none().then(|| "too wide".to_owned());
        let bytes_per_element = couples.map(|_| 12.0);
        EngineRow {
            engine,
            simd: None,
            device: None,
            threads: 1,
            elements: 1000,
            couples,
            median_ms,
            best_ms: median_ms,
            bytes_per_element,
            refused,
        }
    }

    #[test]
    fn the_median_is_in_the_middle() {
        let times = |times: &[u64]| times.iter().copied().map(Duration::from_millis).collect::<Vec<_>>();
        assert_eq!(median(&[]), None);
        assert_eq!(median(&times(&[3])), Some(Duration::from_millis(3)));
        assert_eq!(median(&times(&[1, 2, 9])), Some(Duration::from_millis(2)));
        assert_eq!(median(&times(&[1, 2, 4, 9])), Some(Duration::from_millis(3)));
    }

    #[test]
    fn the_table_has_what_was_measured() {
        let rows = vec![
            row("rows", Some(500), Some(0.5)),
            row("nbs", None, None),
            row("direct", Some(500), Some(2.0)),
        ];
        assert_eq!(
            Report { rows }.to_string(),
            "\
engine  simd  threads  median ms  best ms  ns/element  ns/couple  couples  bytes/element  direct = 1
rows    -           1      0.500    0.500       500.0     1000.0      500           12.0         4.0
nbs     -           1    refused        -           -          -        -              -           -
direct  -           1      2.000    2.000      2000.0     4000.0      500           12.0         1.0
nbs refused: too wide
"
        );
    }

    #[test]
    fn a_device_has_its_name_and_no_threads() {
        let of_device = EngineRow {
            device: Some("gpu:1".to_owned()),
            threads: 0,
            bytes_per_element: None,
            ..row("rows", Some(500), Some(0.25))
        };
        let rows = vec![of_device, row("direct", Some(500), Some(2.0))];
        assert_eq!(
            Report { rows }.to_string(),
            "\
engine  simd   threads  median ms  best ms  ns/element  ns/couple  couples  bytes/element  direct = 1
rows    gpu:1        -      0.250    0.250       250.0      500.0      500              -         8.0
direct  -            1      2.000    2.000      2000.0     4000.0      500           12.0         1.0
"
        );
    }

    #[test]
    fn engines_that_differ_are_wrong_and_refusals_are_not() {
        let same =
            vec![row("rows", Some(3), Some(1.0)), row("nbs", None, None), row("direct", Some(3), Some(1.0))];
        assert!(Report { rows: same }.check("a.csv").is_ok());
        let different = vec![row("rows", Some(3), Some(1.0)), row("nbs", Some(4), Some(1.0))];
        let failure = Report { rows: different }.check("a.csv").unwrap_err();
        assert!(
            matches!(&failure, Failure::Wrong(text) if text.contains("rows found 3") && text.contains("nbs found 4"))
        );
    }
}
