//! Our searches and their rivals side by side, on the same points in the same run.
//!
//! A rival is a Cargo feature of this package, or a program of its own that is given with `--external`. Before anything is timed, its
//! couples are compared with ours, of a program their number. Then all take turns, so that a machine that slows down for a while slows
//! all of them.

use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use fdem_bench::bars::{self, Bar, Bars};
use fdem_bench::peers::sets::{self, CUTOFF, SETS, Scene, Set};
use fdem_bench::peers::{self, Command, External, Kind, Peer, Peers, Threads};
use fdem_bench::{Table, Times, Turn, grouped, machine, significant, turns};
use fdem_contact::{Couple, Elements, Rows, Search, Simd};

const USAGE: &str = "\
usage: peers [--sets A,B,...] [--engines A,B,...] [--external NAME=COMMAND]... [--simd LEVEL] [--threads N,M,...]
             [--rounds N] [--budget SECONDS] [--patience SECONDS] [--counts N,M,...] [--quick] [--out FILE]

  --sets      of gas100k, gas1m, dense1m, sparse1m, outlier1m, gas2d1m; all if not given
  --engines   of rows, rows-avx2, rows-cold, nbs: ours; the first is what the others are compared with
  --external  a rival that is a program, see external/README.md; may be repeated
  --simd      portable, neon, avx2 or avx512 for rows; the best of this processor if not given
  --threads   for all that can, one table for each number; all is one for each processor; 1 if not given
  --rounds    times taken of each search, 5 if not given
  --budget    a search whose times of one set add up to more, 3 s if not given, takes no further round
  --patience  a search that would take longer than this, 15 s if not given, is left out
  --counts    points of the gas that rows counts, to show the time per element; 1000000,10000000 if not given, 0 for none
  --quick     10,000 points: compares the couples, takes no times, writes nothing unless --out is given
  --out       Markdown with the tables, and the plot beside it as SVG; RESULTS.md of this package if not given
";

const QUICK: usize = 10_000;
/// Share of the pairs that a program may find too many or too few: `f32` rounds those that are about the cut-off apart.
const ROUNDED: f64 = 1e-5;
/// Beside the times of a search whose number of pairs differs within that.
const MARK: &str = "\u{2020}";

/// What to run, and where the results go.
struct Plan {
    sets: Vec<&'static Set>,
    engines: Vec<Kind>,
    external: Vec<Command>,
    simd: Simd,
    threads: Vec<usize>,
    rounds: usize,
    budget: f64,
    patience: f64,
    counts: Vec<usize>,
    quick: bool,
    out: Option<PathBuf>,
}

impl Plan {
    fn from_arguments(arguments: &[String]) -> Option<Self> {
        let mut plan = Self {
            sets: SETS.iter().collect(),
            engines: Kind::available(),
            external: Vec::new(),
            simd: Simd::best(),
            threads: vec![1],
            rounds: 5,
            budget: 3.0,
            patience: 15.0,
            counts: vec![1_000_000, 10_000_000],
            quick: false,
            out: None,
        };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            if argument == "--quick" {
                plan.quick = true;
                continue;
            }
            let value = rest.next()?;
            match argument.as_str() {
                "--sets" => plan.sets = listed(value, |name| SETS.iter().find(|set| set.name == name))?,
                "--engines" => {
                    plan.engines =
                        listed(value, |name| Kind::ALL.into_iter().find(|kind| kind.name() == name))?;
                }
                "--external" => plan.external.push(Command::parse(value)?),
                "--simd" => {
                    let levels = [Simd::Portable, Simd::Neon, Simd::Avx2, Simd::Avx512];
                    plan.simd = levels.into_iter().find(|level| level.name() == value)?;
                }
                "--threads" => {
                    plan.threads = listed(value, |number| match number {
                        "all" => std::thread::available_parallelism().ok().map(usize::from),
                        _ => number.parse().ok().filter(|&threads| threads > 0),
                    })?;
                }
                "--rounds" => plan.rounds = value.parse().ok().filter(|&rounds| rounds > 0)?,
                "--budget" => plan.budget = value.parse().ok().filter(|&seconds| seconds > 0.0)?,
                "--patience" => {
                    plan.patience = value.parse().ok().filter(|seconds| (0.001..1e6).contains(seconds))?;
                }
                "--counts" if value == "0" => plan.counts.clear(),
                "--counts" => plan.counts = listed(value, |n| n.parse().ok().filter(|&n| n > 0))?,
                "--out" => plan.out = Some(PathBuf::from(value)),
                _ => return None,
            }
        }
        if plan.out.is_none() && !plan.quick {
            plan.out = Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("RESULTS.md"));
        }
        Some(plan)
    }
}

/// The entries of a list separated by commas; none if one of them is not known.
fn listed<T>(list: &str, find: impl Fn(&str) -> Option<T>) -> Option<Vec<T>> {
    list.split(',').map(find).collect()
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(plan) = Plan::from_arguments(&arguments) else {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    };
    match run(&plan) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("peers: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(plan: &Plan) -> Result<(), Box<dyn Error>> {
    let pools: Vec<Threads> =
        plan.threads.iter().map(|&count| Threads::new(count)).collect::<Result<_, _>>()?;
    let mut called = Vec::new();
    let mut outcomes = Vec::new();
    for &set in &plan.sets {
        match set.scene {
            Scene::Space(scene) => {
                let points = Points::new(plan, set, scene)?;
                for threads in &pools {
                    outcomes.push(compare(
                        plan,
                        set,
                        &points,
                        threads,
                        peers::rivals_3d(threads),
                        &mut called,
                    )?);
                }
            }
            Scene::Plane(scene) => {
                let points = Points::new(plan, set, scene)?;
                for threads in &pools {
                    outcomes.push(compare(
                        plan,
                        set,
                        &points,
                        threads,
                        peers::rivals_2d(threads),
                        &mut called,
                    )?);
                }
            }
        }
    }
    let counted = if plan.quick { Vec::new() } else { count(plan)? };
    let report = report(plan, &called, &outcomes, &counted)?;
    print(&report)?;
    if let Some(file) = &plan.out {
        let plot = file.with_extension("svg");
        let name = plot.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let linked = if plan.quick { report } else { report + &format!("\n![Times]({name})\n") };
        std::fs::write(file, linked).map_err(|error| format!("{}: {error}", file.display()))?;
        if !plan.quick {
            bars::write(&plot, &outcomes.iter().map(Outcome::bars).collect::<Vec<_>>())?;
        }
    }
    match outcomes.iter().flat_map(|outcome| &outcome.searches).filter(|search| search.wrong).count() {
        0 => Ok(()),
        wrong => Err(format!("{wrong} searches disagree with ours, see above").into()),
    }
}

fn print(report: &str) -> std::io::Result<()> {
    use std::io::Write;
    std::io::stdout().write_all(report.as_bytes())
}

/// The points of a set, and two smaller sets of the kind.
struct Points<const D: usize> {
    all: Vec<[f64; D]>,
    smaller: Vec<Vec<[f64; D]>>,
    file: Option<PointFile>,
}

impl<const D: usize> Points<D> {
    fn new(
        plan: &Plan,
        set: &Set,
        scene: fn(usize) -> Result<Vec<[f64; D]>, fdem_scenes::Error>,
    ) -> Result<Self, Box<dyn Error>> {
        let all = scene(if plan.quick { QUICK } else { set.n })?;
        let smaller = if plan.quick { Vec::new() } else { vec![scene(set.n / 100)?, scene(set.n / 10)?] };
        let file = (!plan.external.is_empty()).then(|| PointFile::new(&all)).transpose()?;
        Ok(Self { all, smaller, file })
    }
}

/// Points as little-endian `f64` in a file of their own, removed when dropped.
struct PointFile(PathBuf);

impl PointFile {
    fn new<const D: usize>(points: &[[f64; D]]) -> std::io::Result<Self> {
        let file = Self(std::env::temp_dir().join(format!("fdem-peers-{}.f64", std::process::id())));
        let bytes: Vec<u8> = points.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(&file.0, bytes)?;
        Ok(file)
    }
}

impl Drop for PointFile {
    fn drop(&mut self) {
        // If it is gone already, that is what is wanted.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A search and how it was called.
#[derive(PartialEq)]
struct Called {
    name: String,
    version: String,
    how: String,
}

/// What came out for one set and one number of threads.
struct Outcome {
    set: &'static Set,
    threads: usize,
    n: usize,
    couples: usize,
    searches: Vec<Searched>,
}

struct Searched {
    name: String,
    ours: bool,
    /// The times, or why there are none.
    times: Result<Option<Times>, String>,
    /// Pairs, where a program found a few more or fewer than ours.
    rounded: Option<u64>,
    /// Whether it found other couples than ours.
    wrong: bool,
    /// Bytes that it keeps, if known.
    bytes: Option<usize>,
}

impl Outcome {
    fn search(&self, name: &str) -> Option<&Searched> {
        self.searches.iter().find(|search| search.name == name)
    }

    fn times(&self, name: &str) -> Option<Times> {
        self.search(name)?.times.as_ref().ok().copied().flatten()
    }

    /// The times of what all are compared with.
    fn ours(&self) -> Option<Times> {
        self.times(&self.searches.first()?.name)
    }

    /// The rival with the least median.
    fn fastest_rival(&self) -> Option<(&str, Times)> {
        let rivals = self.searches.iter().filter(|search| !search.ours);
        rivals
            .filter_map(|search| Some((search.name.as_str(), self.times(&search.name)?)))
            .min_by(|a, b| a.1.median.total_cmp(&b.1.median))
    }

    fn bars(&self) -> Bars {
        let mut bars: Vec<Bar> = Vec::new();
        for search in &self.searches {
            if let (Ok(Some(times)), Some(ours)) = (&search.times, self.ours()) {
                bars.push(Bar {
                    name: search.name.clone(),
                    value: 1e3 * times.median,
                    remark: format!("ms, {}x", significant(times.median / ours.median)),
                    bold: search.ours,
                });
            }
        }
        bars.sort_by(|a, b| a.value.total_cmp(&b.value));
        Bars { title: format!("{}; {}", self.set.title, threads(self.threads)), bars }
    }
}

fn threads(count: usize) -> String {
    format!("{count} thread{}", if count == 1 { "" } else { "s" })
}

/// A search that takes turns.
enum Rival<const D: usize> {
    Inside(Box<dyn Peer<D>>),
    Program(External),
}

/// Compares the couples of all searches with those of the first, then times those that agree.
fn compare<const D: usize>(
    plan: &Plan,
    set: &'static Set,
    points: &Points<D>,
    threads: &Threads,
    rivals: Peers<D>,
    called: &mut Vec<Called>,
) -> Result<Outcome, Box<dyn Error>> {
    eprintln!("{}, threads: {}", set.name, threads.count());
    let mut outcome =
        Outcome { set, threads: threads.count(), n: points.all.len(), couples: 0, searches: Vec::new() };
    let mut note = |name: &str, (version, how): (String, String)| {
        let call = Called { name: name.to_owned(), version, how };
        if !called.contains(&call) {
            called.push(call);
        }
    };
    let mut agreeing = Vec::new();
    let mut reference = Vec::new();
    let mut found = Vec::new();
    let ours = peers::ours(&plan.engines, plan.simd, threads.count())?;
    for (number, mut search) in ours.into_iter().chain(rivals).enumerate() {
        note(search.name(), (search.version(), search.how()));
        // The first is what the others are compared with, however long it takes.
        let smaller = if number == 0 { &[] } else { &points.smaller[..] };
        let answer = forecast(search.as_mut(), smaller, &mut found)
            .and_then(|seconds| {
                let fits = seconds <= plan.patience;
                fits.then_some(()).ok_or_else(|| format!("would take about {} s", significant(seconds)))
            })
            .and_then(|()| search.couples(&points.all, CUTOFF, &mut found));
        let differing = answer.map(|()| {
            if number == 0 {
                reference.clone_from(&found);
                outcome.couples = reference.len();
            }
            differing(&mut reference, &mut found)
        });
        if let (0, Err(reason)) = (number, &differing) {
            return Err(format!("{}: {}: {reason}", set.name, search.name()).into());
        }
        let of = grouped(reference.len() as u64);
        outcome.searches.push(Searched {
            name: search.name().to_owned(),
            ours: number < plan.engines.len(),
            wrong: differing.as_ref().is_ok_and(|&couples| couples > 0),
            rounded: None,
            bytes: search.bytes(),
            times: differing.and_then(|couples| match couples {
                0 => Ok(None),
                _ => Err(format!("differs in {} of {of} couples", grouped(couples as u64))),
            }),
        });
        agreeing.push(Some(Rival::Inside(search)));
    }
    drop((reference, found));
    for command in points.file.iter().flat_map(|_| &plan.external) {
        let (searched, program) = ask(plan, command, points, &outcome);
        if let Some(program) = &program {
            note(&command.name, program.about.clone());
        }
        outcome.searches.push(searched);
        agreeing.push(program.map(Rival::Program));
    }
    for search in &outcome.searches {
        eprintln!("  {}: {}", search.name, search.times.as_ref().err().map_or("agrees", String::as_str));
    }
    if !plan.quick {
        take_times(plan, &points.all, agreeing, &mut outcome.searches);
    }
    Ok(outcome)
}

/// Starts a program and compares the number of its pairs.
fn ask<const D: usize>(
    plan: &Plan,
    command: &Command,
    points: &Points<D>,
    outcome: &Outcome,
) -> (Searched, Option<External>) {
    let mut searched = Searched {
        name: command.name.clone(),
        ours: false,
        times: Ok(None),
        rounded: None,
        wrong: false,
        bytes: None,
    };
    let file = points.file.as_ref().map_or(Path::new(""), |file| &file.0);
    let patience = Duration::from_secs_f64(plan.patience);
    let started = External::start(command, (file, D), CUTOFF, outcome.threads, patience);
    let answer = started.and_then(|mut program| Ok((program.round()?, program)));
    match answer {
        Err(reason) => {
            searched.times = Err(reason);
            (searched, None)
        }
        Ok((answer, program)) => {
            let apart = answer.pairs.abs_diff(outcome.couples as u64);
            searched.wrong = apart as f64 > ROUNDED * outcome.couples as f64;
            searched.rounded = (apart > 0).then_some(answer.pairs);
            if searched.wrong {
                let (found, of) = (grouped(answer.pairs), grouped(outcome.couples as u64));
                searched.times = Err(format!("finds {found} couples instead of {of}"));
            }
            (searched, Some(program))
        }
    }
}

/// Seconds that a search will take for ten times as many points as in the larger of two sets, if it goes on as between
/// these; 0 without sets.
fn forecast<const D: usize>(
    search: &mut dyn Peer<D>,
    smaller: &[Vec<[f64; D]>],
    found: &mut Vec<Couple>,
) -> Result<f64, String> {
    let mut seconds = Vec::new();
    for points in smaller {
        let start = Instant::now();
        search.couples(points, CUTOFF, found)?;
        seconds.push(start.elapsed().as_secs_f64().max(1e-5));
    }
    Ok(if let [first, second] = seconds[..] { second * (second / first).max(1.0) } else { 0.0 })
}

/// Couples that are in only one of two lists in any order; lists that differ are sorted.
fn differing(a: &mut [Couple], b: &mut [Couple]) -> usize {
    // Sums over scrambled couples: sorting tens of millions for each search would take most of the run.
    if a.len() == b.len() && scrambled(a) == scrambled(b) {
        return 0;
    }
    a.sort_unstable();
    b.sort_unstable();
    let (mut i, mut j, mut common) = (0, 0, 0);
    while i < a.len() && j < b.len() {
        common += usize::from(a[i] == b[j]);
        let (next_i, next_j) = (a[i] <= b[j], b[j] <= a[i]);
        i += usize::from(next_i);
        j += usize::from(next_j);
    }
    a.len() + b.len() - 2 * common
}

/// A sum over the couples that does not depend on their order.
fn scrambled(couples: &[Couple]) -> u64 {
    let scramble = |couple: &Couple| {
        let mut bits = u64::from(couple.i) << 32 | u64::from(couple.j);
        for _ in 0..2 {
            bits = (bits ^ bits >> 29).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        }
        bits ^ bits >> 32
    };
    couples.iter().map(scramble).fold(0, u64::wrapping_add)
}

/// Times the searches that agree, in turns, each with its own memory.
fn take_times<const D: usize>(
    plan: &Plan,
    points: &[[f64; D]],
    mut searches: Vec<Option<Rival<D>>>,
    outcomes: &mut [Searched],
) {
    let (mut tasks, mut timed) = (Vec::new(), Vec::new());
    for (search, outcome) in searches.iter_mut().zip(outcomes) {
        let (Some(search), Ok(_)) = (search, &outcome.times) else { continue };
        let task: Turn<'_, String> = match search {
            Rival::Program(program) => Box::new(|| program.round().map(|answer| answer.seconds)),
            Rival::Inside(search) => {
                let mut couples = Vec::new();
                Box::new(move || {
                    let start = Instant::now();
                    search.couples(black_box(points), CUTOFF, &mut couples)?;
                    black_box(&couples);
                    Ok(start.elapsed().as_secs_f64())
                })
            }
        };
        tasks.push(task);
        timed.push(outcome);
    }
    for (outcome, times) in timed.into_iter().zip(turns(&mut tasks, plan.rounds, plan.budget)) {
        outcome.times = times.map(Some);
    }
}

/// What `Rows` took to count the couples of so many points.
struct Counted {
    n: usize,
    couples: u64,
    bytes: usize,
    /// For each number of threads.
    times: Vec<Times>,
}

/// Counts the couples of the gas with `Rows`, all numbers of points and threads in turns.
fn count(plan: &Plan) -> Result<Vec<Counted>, Box<dyn Error>> {
    let sets: Vec<_> = plan.counts.iter().map(|&n| sets::gas(n)).collect::<Result<_, _>>()?;
    let mut counted = Vec::new();
    for points in &sets {
        eprintln!("counting {}", points.len());
        let mut rows = Rows::new().with_simd(plan.simd)?;
        let couples = rows.count(&Elements::points(points, CUTOFF)?)?;
        counted.push(Counted { n: points.len(), couples, bytes: rows.bytes(), times: Vec::new() });
    }
    let mut tasks = Vec::new();
    for (points, counted) in sets.iter().zip(&counted) {
        for &threads in &plan.threads {
            let mut rows = Rows::new().with_simd(plan.simd)?.with_threads(threads)?;
            let expected = counted.couples;
            let task: Turn<'_, String> = Box::new(move || {
                let start = Instant::now();
                let elements =
                    Elements::points(black_box(points), CUTOFF).map_err(|error| error.to_string())?;
                let found = rows.count(&elements).map_err(|error| error.to_string())?;
                let seconds = start.elapsed().as_secs_f64();
                if found == expected {
                    Ok(seconds)
                } else {
                    Err(format!("{found} couples instead of {expected}"))
                }
            });
            tasks.push(task);
        }
    }
    let times = turns(&mut tasks, plan.rounds, f64::INFINITY).into_iter().collect::<Result<Vec<_>, _>>()?;
    drop(tasks);
    for (counted, times) in counted.iter_mut().zip(times.chunks(plan.threads.len())) {
        counted.times = times.to_vec();
    }
    Ok(counted)
}

/// Everything as Markdown.
fn report(
    plan: &Plan,
    called: &[Called],
    outcomes: &[Outcome],
    counted: &[Counted],
) -> Result<String, std::fmt::Error> {
    let first = plan.engines[0].name();
    let mut text = String::from("# Rows and its peers\n\n");
    writeln!(text, "{}; {}.\n", machine(&plan.threads), flags())?;
    writeln!(
        text,
        "From raw `f64` coordinates in memory to all couples at most the cut-off apart as pairs of
numbers in memory, the structure included. The couples of every search were compared with those
of `{first}` first, by number and a sum over them; of a program by number."
    )?;
    let one = |threads: usize| outcomes.iter().filter(move |outcome| outcome.threads == threads);
    let mut sets = Table::new(&["set", "what", "points", "couples"]);
    for outcome in one(plan.threads[0]) {
        sets.row([
            outcome.set.name.to_owned(),
            outcome.set.title.to_owned(),
            grouped(outcome.n as u64),
            grouped(outcome.couples as u64),
        ]);
    }
    write!(text, "\n{sets}")?;
    if !plan.quick {
        writeln!(
            text,
            "\nMedian of {} rounds in turns, of fewer where a search took more than {} s for them; what takes less than 0.3 s runs once
uncounted before each. In brackets: times that of `{first}`.",
            plan.rounds, plan.budget
        )?;
        if outcomes.iter().flat_map(|outcome| &outcome.searches).any(|search| search.rounded.is_some()) {
            writeln!(
                text,
                "{MARK} computes in `f32` and finds a few pairs more or fewer, at most {ROUNDED:e} of them; see the end."
            )?;
        }
        for &count in &plan.threads {
            let outcomes: Vec<&Outcome> = one(count).collect();
            writeln!(text, "\n## {}: median [ms]\n", threads(count))?;
            write!(text, "{}", matrix(called, &outcomes, |times| times.median))?;
            writeln!(text, "\n## {}: `{first}` and the fastest peer, medians\n", threads(count))?;
            write!(text, "{}", fastest(&outcomes))?;
            writeln!(text, "\n## {}: best round [ms]\n", threads(count))?;
            write!(text, "{}", matrix(called, &outcomes, |times| times.best))?;
        }
        if plan.threads.len() > 1 {
            writeln!(text, "\n## `{first}`: times as fast as on {}\n", threads(plan.threads[0]))?;
            write!(text, "{}", speedup(plan, outcomes))?;
        }
        writeln!(text, "\n## Memory of `rows`, beyond points and couples\n")?;
        write!(text, "{}", memory(outcomes))?;
        if !counted.is_empty() {
            writeln!(text, "\n## Counting: the gas with 12 neighbours, `rows`, {}\n", plan.simd.name())?;
            writeln!(text, "In brackets: times that of the first line.\n")?;
            write!(text, "{}", counts(plan, counted))?;
        }
    }
    writeln!(text, "\n## How they were called\n")?;
    let mut how = Table::new(&["search", "version", "how"]);
    for call in called {
        how.row([call.name.clone(), call.version.clone(), call.how.clone()]);
    }
    write!(text, "{how}")?;
    let mut remarks = String::new();
    for outcome in outcomes {
        for search in &outcome.searches {
            let begin = format!("- {}, {}, {}", outcome.set.name, threads(outcome.threads), search.name);
            if let Err(reason) = &search.times {
                writeln!(remarks, "{begin}: left out: {reason}")?;
            } else if let Some(pairs) = search.rounded {
                writeln!(
                    remarks,
                    "{begin}{MARK}: {} pairs, ours {}",
                    grouped(pairs),
                    grouped(outcome.couples as u64)
                )?;
            }
        }
    }
    if !remarks.is_empty() {
        write!(text, "\n## Left out, or other pairs\n\n{remarks}")?;
    }
    Ok(text)
}

/// A row per search and a column per set.
fn matrix(called: &[Called], outcomes: &[&Outcome], of: fn(Times) -> f64) -> Table {
    let mut headings = vec!["search"];
    headings.extend(outcomes.iter().map(|outcome| outcome.set.name));
    let mut table = Table::new(&headings);
    let mut names: Vec<&str> = Vec::new();
    for call in called {
        if !names.contains(&call.name.as_str()) {
            names.push(&call.name);
        }
    }
    for name in names {
        let cell = |outcome: &&Outcome| match (outcome.times(name), outcome.ours()) {
            (Some(times), Some(ours)) => {
                let mark = if outcome.search(name).is_some_and(|search| search.rounded.is_some()) {
                    MARK
                } else {
                    ""
                };
                format!("{}{mark} ({})", significant(1e3 * of(times)), significant(of(times) / of(ours)))
            }
            _ => "-".to_owned(),
        };
        table.row(std::iter::once(name.to_owned()).chain(outcomes.iter().map(cell)));
    }
    table
}

/// What the fastest rival takes, relative to ours.
fn fastest(outcomes: &[&Outcome]) -> Table {
    let avx2 = Kind::RowsAvx2.name();
    let mut table = Table::new(&[
        "set",
        "ours [ms]",
        "ns per element",
        "ns per couple",
        "fastest peer",
        "its time [ms]",
        "times ours",
        &format!("times {avx2}"),
        &format!("{avx2}, ns per couple"),
    ]);
    for outcome in outcomes {
        let Some(ours) = outcome.ours() else { continue };
        let rival = outcome.fastest_rival();
        let limited = outcome.times(avx2);
        let shown = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), significant);
        let per_couple = |times: Times| 1e9 * times.median / outcome.couples.max(1) as f64;
        table.row([
            outcome.set.name.to_owned(),
            significant(1e3 * ours.median),
            significant(1e9 * ours.median / outcome.n as f64),
            significant(per_couple(ours)),
            rival.map_or("-", |(name, _)| name).to_owned(),
            shown(rival.map(|(_, times)| 1e3 * times.median)),
            shown(rival.map(|(_, times)| times.median / ours.median)),
            shown(rival.zip(limited).map(|((_, times), limited)| times.median / limited.median)),
            shown(limited.map(per_couple)),
        ]);
    }
    table
}

/// A row per number of threads and a column per set.
fn speedup(plan: &Plan, outcomes: &[Outcome]) -> Table {
    let mut headings = vec!["threads"];
    headings.extend(plan.sets.iter().map(|set| set.name));
    let mut table = Table::new(&headings);
    for &count in &plan.threads[1..] {
        let ours = |set: &Set, threads: usize| {
            let of = |outcome: &&Outcome| outcome.set.name == set.name && outcome.threads == threads;
            Some(outcomes.iter().find(of)?.ours()?.median)
        };
        let cell = |set: &&Set| match (ours(set, plan.threads[0]), ours(set, count)) {
            (Some(one), Some(many)) => significant(one / many),
            _ => "-".to_owned(),
        };
        table.row(std::iter::once(count.to_string()).chain(plan.sets.iter().map(cell)));
    }
    table
}

/// Bytes per element.
fn memory(outcomes: &[Outcome]) -> Table {
    let mut table = Table::new(&["set", "threads", "bytes", "bytes per element"]);
    for outcome in outcomes {
        if let Some(bytes) = outcome.search(Kind::Rows.name()).and_then(|search| search.bytes) {
            table.row([
                outcome.set.name.to_owned(),
                outcome.threads.to_string(),
                grouped(bytes as u64),
                format!("{:.1}", bytes as f64 / outcome.n as f64),
            ]);
        }
    }
    table
}

/// Nanoseconds per element.
fn counts(plan: &Plan, counted: &[Counted]) -> Table {
    let titles: Vec<String> =
        plan.threads.iter().map(|&count| format!("{} [ns per element]", threads(count))).collect();
    let mut headings = vec!["points", "couples", "bytes per element"];
    headings.extend(titles.iter().map(String::as_str));
    let mut table = Table::new(&headings);
    for line in counted {
        let per_element = |line: &Counted, index: usize| 1e9 * line.times[index].median / line.n as f64;
        let cells = (0..plan.threads.len()).map(|index| {
            let (here, first) = (per_element(line, index), per_element(&counted[0], index));
            format!("{} ({})", significant(here), significant(here / first))
        });
        let begin = [
            grouped(line.n as u64),
            grouped(line.couples),
            format!("{:.1}", line.bytes as f64 / line.n as f64),
        ];
        table.row(begin.into_iter().chain(cells));
    }
    table
}

/// How this program was compiled.
fn flags() -> String {
    let mut wide = Vec::new();
    if cfg!(target_feature = "avx2") {
        wide.push("avx2");
    }
    if cfg!(target_feature = "avx512f") {
        wide.push("avx512f");
    }
    let profile = "release: opt-level 3, thin LTO, 1 codegen unit";
    if wide.is_empty() {
        format!("{profile}, no target-cpu")
    } else {
        format!("{profile}, compiled for {}", wide.join(" and "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn couples_in_only_one_list_are_counted() {
        let couples = |js: &[u32]| js.iter().map(|&j| Couple::new(0, j)).collect::<Vec<_>>();
        let apart = |a: &[u32], b: &[u32]| differing(&mut couples(a), &mut couples(b));
        assert_eq!(apart(&[1, 2, 3], &[3, 1, 2]), 0);
        assert_eq!(apart(&[1, 3, 5], &[3, 2]), 3);
        assert_eq!(apart(&[1, 3, 5], &[1, 5, 4]), 2);
        assert_eq!(apart(&[], &[2, 3]), 2);
    }

    #[test]
    fn arguments() {
        let plan = |line: &str| Plan::from_arguments(&line.split(' ').map(str::to_owned).collect::<Vec<_>>());
        let some = plan("--quick --sets gas1m,gas2d1m --engines nbs --threads 1,3 --counts 0 --external a=b")
            .unwrap();
        assert_eq!((some.sets.len(), some.engines, some.out), (2, vec![Kind::Nbs], None));
        assert_eq!((some.threads, some.counts, some.external.len()), (vec![1, 3], vec![], 1));
        for wrong in
            ["--sets gas", "--rounds 0", "--simd", "--speed 3", "--threads 0", "--external a", "--counts x"]
        {
            assert!(plan(wrong).is_none(), "{wrong}");
        }
    }
}
