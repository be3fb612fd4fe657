//! Our searches and their rivals side by side, on the same points in the same run.
//!
//! A rival is a Cargo feature of this package. Before anything is timed, its couples are compared one by one with
//! ours. Then all take turns, so that a machine that slows down for a while slows all of them.

use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use fdem_bench::bars::{self, Bar, Bars};
use fdem_bench::peers::{self, Kind, Peer, Peers};
use fdem_bench::{Rounds, Table, Task, Times, grouped, machine, significant, times};
use fdem_contact::{Couple, Simd};
use fdem_scenes::Sizes;

const USAGE: &str = "\
usage: peers [--sets A,B,...] [--engines A,B,...] [--simd LEVEL] [--threads 1|all] [--repeat N]
             [--patience SECONDS] [--quick] [--out FILE]

  --sets      of gas100k, gas1m, dense1m, sparse1m, outlier1m, gas2d1m; all if not given
  --engines   of rows, rows-cold, nbs: ours; the first is what the others are compared with
  --simd      portable, neon, avx2 or avx512 for rows; the best of this processor if not given
  --threads   for the rivals that can; 1 if not given
  --repeat    times taken of each search, 7 if not given
  --patience  a search that would take longer than this, 30 s if not given, is left out
  --quick     10,000 points: compares the couples, takes no times, writes nothing unless --out is given
  --out       Markdown with the table, and the plot beside it as SVG; RESULTS.md of this package if not given
";

/// Distance at which two points are a couple, in all sets.
const CUTOFF: f64 = 1.0;
const SEED: u64 = 1;
/// Where the outlier is, in cut-offs along each axis.
const FAR: f64 = 1e6;
const QUICK: usize = 10_000;

/// How a set is made, for any number of points.
enum Scene {
    Space(fn(usize) -> Result<Vec<[f64; 3]>, fdem_scenes::Error>),
    Plane(fn(usize) -> Result<Vec<[f64; 2]>, fdem_scenes::Error>),
}

struct Set {
    name: &'static str,
    title: &'static str,
    n: usize,
    scene: Scene,
}

const SETS: [Set; 6] = [
    Set { name: "gas100k", title: "gas, 12 neighbours, 100,000", n: 100_000, scene: Scene::Space(gas) },
    Set { name: "gas1m", title: "gas, 12 neighbours, 1,000,000", n: 1_000_000, scene: Scene::Space(gas) },
    Set {
        name: "dense1m",
        title: "dense, 80 neighbours, 1,000,000",
        n: 1_000_000,
        scene: Scene::Space(|n| Ok(fdem_scenes::peers::dense(n, SEED)?.centres)),
    },
    Set {
        name: "sparse1m",
        title: "1,000 clusters of 1,000, 1e5 wide",
        n: 1_000_000,
        scene: Scene::Space(|n| Ok(fdem_scenes::peers::sparse(n, SEED)?.centres)),
    },
    Set {
        name: "outlier1m",
        title: "gas 1,000,000, one point 1e6 away",
        n: 1_000_000,
        scene: Scene::Space(|n| {
            let mut points = gas(n)?;
            points[n / 2] = [FAR; 3];
            Ok(points)
        }),
    },
    Set {
        name: "gas2d1m",
        title: "2D: gas, 12 neighbours, 1,000,000",
        n: 1_000_000,
        scene: Scene::Plane(|n| Ok(fdem_scenes::gas(n, SEED, 12.0, Sizes::Equal { radius: 0.5 })?.centres)),
    },
];

fn gas(n: usize) -> Result<Vec<[f64; 3]>, fdem_scenes::Error> {
    Ok(fdem_scenes::peers::gas(n, SEED)?.centres)
}

/// What to run, and where the results go.
struct Plan {
    sets: Vec<&'static Set>,
    engines: Vec<Kind>,
    simd: Simd,
    threads: usize,
    repeat: usize,
    patience: f64,
    quick: bool,
    out: Option<PathBuf>,
}

impl Plan {
    fn from_arguments(arguments: &[String]) -> Option<Self> {
        let mut plan = Self {
            sets: SETS.iter().collect(),
            engines: Kind::ALL.to_vec(),
            simd: Simd::best(),
            threads: 1,
            repeat: 7,
            patience: 30.0,
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
                "--simd" => {
                    let levels = [Simd::Portable, Simd::Neon, Simd::Avx2, Simd::Avx512];
                    plan.simd = levels.into_iter().find(|level| level.name() == value)?;
                }
                "--threads" if value == "all" => {
                    plan.threads = std::thread::available_parallelism().ok()?.get();
                }
                "--threads" => plan.threads = value.parse().ok().filter(|&threads| threads > 0)?,
                "--repeat" => plan.repeat = value.parse().ok().filter(|&repeat| repeat > 0)?,
                "--patience" => plan.patience = value.parse().ok().filter(|&seconds| seconds > 0.0)?,
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
    peers::use_threads(plan.threads)?;
    let mut called = Vec::new();
    let mut outcomes = Vec::new();
    for &set in &plan.sets {
        eprintln!("{}", set.name);
        let outcome = match set.scene {
            Scene::Space(scene) => {
                let mut searches = peers::ours(&plan.engines, plan.simd)?;
                searches.extend(peers::rivals_3d(plan.threads));
                compare(plan, set, scene, searches, &mut called)?
            }
            Scene::Plane(scene) => {
                let mut searches = peers::ours(&plan.engines, plan.simd)?;
                searches.extend(peers::rivals_2d(plan.threads));
                compare(plan, set, scene, searches, &mut called)?
            }
        };
        outcomes.push(outcome);
    }
    let report = report(plan, &called, &outcomes)?;
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

/// A search and how it was called.
#[derive(PartialEq)]
struct Called {
    name: &'static str,
    version: String,
    how: String,
}

/// What came out for one set.
struct Outcome {
    set: &'static Set,
    n: usize,
    couples: usize,
    searches: Vec<Searched>,
}

struct Searched {
    name: &'static str,
    /// The times, or why there are none.
    times: Result<Option<Times>, String>,
    /// Whether it found other couples than ours.
    wrong: bool,
}

impl Outcome {
    fn median(&self, name: &str) -> Option<Times> {
        self.searches.iter().find(|search| search.name == name)?.times.as_ref().ok().copied().flatten()
    }

    fn bars(&self) -> Bars {
        let ours = self.searches.first().and_then(|search| self.median(search.name));
        let mut bars: Vec<Bar> = Vec::new();
        for search in &self.searches {
            if let (Ok(Some(times)), Some(ours)) = (&search.times, ours) {
                bars.push(Bar {
                    name: search.name.to_owned(),
                    value: 1e3 * times.median,
                    remark: format!("ms, {}x", significant(times.median / ours.median)),
                    bold: Kind::ALL.iter().any(|kind| kind.name() == search.name),
                });
            }
        }
        bars.sort_by(|a, b| a.value.total_cmp(&b.value));
        Bars { title: self.set.title.to_owned(), bars }
    }
}

/// Compares the couples of all searches with those of the first, then times those that agree.
fn compare<const D: usize>(
    plan: &Plan,
    set: &'static Set,
    scene: fn(usize) -> Result<Vec<[f64; D]>, fdem_scenes::Error>,
    mut searches: Peers<D>,
    called: &mut Vec<Called>,
) -> Result<Outcome, Box<dyn Error>> {
    let n = if plan.quick { QUICK } else { set.n };
    let points = scene(n)?;
    let smaller = if plan.quick { Vec::new() } else { vec![scene(n / 100)?, scene(n / 10)?] };
    let mut reference = Vec::new();
    let mut found = Vec::new();
    let mut outcome = Outcome { set, n, couples: 0, searches: Vec::new() };
    for (number, search) in searches.iter_mut().enumerate() {
        let call = Called { name: search.name(), version: search.version(), how: search.how() };
        if !called.contains(&call) {
            called.push(call);
        }
        let mut searched = Searched { name: search.name(), times: Ok(None), wrong: false };
        // The first is what the others are compared with, however long it takes.
        let smaller = if number == 0 { &[] } else { &smaller[..] };
        let answer = forecast(search.as_mut(), smaller, &mut found)
            .and_then(|seconds| {
                let fits = seconds <= plan.patience;
                fits.then_some(()).ok_or_else(|| format!("would take about {} s", significant(seconds)))
            })
            .and_then(|()| search.couples(&points, CUTOFF, &mut found));
        match answer {
            Err(reason) if number == 0 => {
                return Err(format!("{}: {}: {reason}", set.name, search.name()).into());
            }
            Err(reason) => searched.times = Err(reason),
            Ok(()) => {
                found.sort_unstable();
                if number == 0 {
                    reference.clone_from(&found);
                }
                let differing = differing(&reference, &found);
                if differing > 0 {
                    searched.wrong = true;
                    let (differ, of) = (grouped(differing as u64), grouped(reference.len() as u64));
                    searched.times = Err(format!("differs in {differ} of {of} couples"));
                }
            }
        }
        eprintln!("  {}: {}", searched.name, searched.times.as_ref().err().map_or("agrees", String::as_str));
        outcome.searches.push(searched);
    }
    outcome.couples = reference.len();
    drop((reference, found));
    if !plan.quick {
        take_times(plan, &points, &mut searches, &mut outcome.searches)?;
    }
    Ok(outcome)
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

/// Couples that are in only one of two ascending lists.
fn differing(a: &[Couple], b: &[Couple]) -> usize {
    let (mut i, mut j, mut common) = (0, 0, 0);
    while i < a.len() && j < b.len() {
        common += usize::from(a[i] == b[j]);
        let (next_i, next_j) = (a[i] <= b[j], b[j] <= a[i]);
        i += usize::from(next_i);
        j += usize::from(next_j);
    }
    a.len() + b.len() - 2 * common
}

/// Times the searches that agree, in turns, each with its own memory.
fn take_times<const D: usize>(
    plan: &Plan,
    points: &[[f64; D]],
    searches: &mut Peers<D>,
    outcomes: &mut [Searched],
) -> Result<(), String> {
    let (mut tasks, mut timed) = (Vec::new(), Vec::new());
    for (search, outcome) in searches.iter_mut().zip(outcomes) {
        if outcome.times.is_ok() {
            let mut couples = Vec::new();
            let task: Task<'_, String> = Box::new(move || {
                search.couples(black_box(points), CUTOFF, &mut couples)?;
                black_box(&couples);
                Ok(())
            });
            tasks.push(task);
            timed.push(outcome);
        }
    }
    let rounds = Rounds { count: plan.repeat, runs: 1, fill: Duration::ZERO };
    for (outcome, times) in timed.into_iter().zip(times(&mut tasks, rounds)?) {
        outcome.times = Ok(Some(times));
    }
    Ok(())
}

/// Everything as Markdown.
fn report(plan: &Plan, called: &[Called], outcomes: &[Outcome]) -> Result<String, std::fmt::Error> {
    let mut text = String::from("# Rows and its peers\n\n");
    writeln!(text, "{}; {}.\n", machine(plan.threads), flags())?;
    writeln!(
        text,
        "From raw `f64` coordinates in memory to all couples at most the cut-off apart as pairs of"
    )?;
    writeln!(
        text,
        "numbers in memory, the structure included. The couples of every search were compared one by one"
    )?;
    writeln!(text, "with those of `{}` first.\n", plan.engines[0].name())?;
    let mut sets = Table::new(&["set", "what", "points", "couples"]);
    for outcome in outcomes {
        sets.row([
            outcome.set.name.to_owned(),
            outcome.set.title.to_owned(),
            grouped(outcome.n as u64),
            grouped(outcome.couples as u64),
        ]);
    }
    write!(text, "{sets}")?;
    if !plan.quick {
        let rounds = format!("{} rounds in turns, each after a run that does not count", plan.repeat);
        writeln!(
            text,
            "\n## Median of {rounds} [ms]\n\nIn brackets: times the median of `{}`.\n",
            plan.engines[0].name()
        )?;
        write!(text, "{}", matrix(called, outcomes, |times| times.median))?;
        writeln!(text, "\n## Best round [ms]\n")?;
        write!(text, "{}", matrix(called, outcomes, |times| times.best))?;
    }
    writeln!(text, "\n## How they were called\n")?;
    let mut how = Table::new(&["search", "version", "how"]);
    for call in called {
        how.row([call.name.to_owned(), call.version.clone(), call.how.clone()]);
    }
    write!(text, "{how}")?;
    let mut reasons = String::new();
    for outcome in outcomes {
        for search in &outcome.searches {
            if let Err(reason) = &search.times {
                writeln!(reasons, "- {}, {}: {reason}", outcome.set.name, search.name)?;
            }
        }
    }
    if !reasons.is_empty() {
        write!(text, "\n## Left out\n\n{reasons}")?;
    }
    Ok(text)
}

/// A row per search and a column per set.
fn matrix(called: &[Called], outcomes: &[Outcome], of: fn(Times) -> f64) -> Table {
    let mut headings = vec!["search"];
    headings.extend(outcomes.iter().map(|outcome| outcome.set.name));
    let mut table = Table::new(&headings);
    for call in called {
        let cell = |outcome: &Outcome| {
            let ours = outcome.searches.first().and_then(|search| outcome.median(search.name));
            match (outcome.median(call.name), ours) {
                (Some(times), Some(ours)) => {
                    format!("{} ({})", significant(1e3 * of(times)), significant(of(times) / of(ours)))
                }
                _ => "-".to_owned(),
            }
        };
        table.row(std::iter::once(call.name.to_owned()).chain(outcomes.iter().map(cell)));
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
        assert_eq!(differing(&couples(&[1, 2, 3]), &couples(&[1, 2, 3])), 0);
        assert_eq!(differing(&couples(&[1, 3, 5]), &couples(&[2, 3])), 3);
        assert_eq!(differing(&[], &couples(&[2, 3])), 2);
    }

    #[test]
    fn arguments() {
        let words = |line: &str| line.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let plan = Plan::from_arguments(&words("--quick --sets gas1m,gas2d1m --engines nbs")).unwrap();
        assert_eq!((plan.sets.len(), plan.engines, plan.out), (2, vec![Kind::Nbs], None));
        for wrong in ["--sets gas", "--repeat 0", "--simd", "--speed 3"] {
            assert!(Plan::from_arguments(&words(wrong)).is_none(), "{wrong}");
        }
    }
}
