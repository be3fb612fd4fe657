//! The experiments of Munjiza & Andrews 1998 with [`Nbs`]: is the time of a detection linear in N, and
//! independent of the packing density?
//!
//! # Source
//! A. Munjiza, K.R.F. Andrews, "NBS contact detection algorithm for bodies of similar size", Int. J. Numer.
//! Meth. Engng 43 (1998) 131-149; A. Munjiza, "The Combined Finite-Discrete Element Method", Wiley 2004, pp.
//! 112-117. The third dimension and N above 90,000 are our additions.

use std::error::Error;
use std::hint::black_box;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use fdem_bench::picture::{self, Axis, Curve, Panel};
use fdem_bench::{Packing, Rounds, Table, Task, Times, grouped, machine, significant, times};
use fdem_contact::{Couple, Elements, Nbs, Observer, Search};

const USAGE: &str = "\
usage: paper [--quick] [--out DIR]

  --quick    small sizes: checks the couple counts in seconds; writes nothing unless --out is given
  --out DIR  folder of the pictures; docs of this workspace if not given
";

/// Number of detections in one published time.
const DETECTIONS: u32 = 10;

/// Published for [`PUBLISHED_N`] discs on a 133 MHz R4600: at most 6 s, the end of the axis of Fig. 3.47.
const PUBLISHED_SECONDS: f64 = 6.0;
const PUBLISHED_N: usize = 90_000;

/// The experiments to run, and the folder for the pictures.
struct Plan {
    sizes: Vec<usize>,
    flat_sizes: [usize; 2],
    spacings: Vec<f64>,
    rounds: Rounds,
    out: Option<PathBuf>,
}

impl Plan {
    fn full() -> Self {
        Self {
            sizes: (4..=13).map(half_decade).collect(),
            flat_sizes: [10_000, 100_000],
            spacings: vec![1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0],
            rounds: Rounds { count: 9, runs: DETECTIONS, fill: Duration::from_millis(5) },
            out: Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")),
        }
    }

    fn quick() -> Self {
        Self {
            sizes: (4..=8).map(half_decade).collect(),
            flat_sizes: [100, 1_000],
            spacings: vec![1.0, 2.0, 200.0],
            rounds: Rounds { count: 5, runs: DETECTIONS, fill: Duration::from_micros(200) },
            out: None,
        }
    }

    fn from_arguments(arguments: &[String]) -> Option<Self> {
        let quick = arguments.iter().any(|argument| argument == "--quick");
        let mut plan = if quick { Self::quick() } else { Self::full() };
        let mut rest = arguments.iter().filter(|argument| *argument != "--quick");
        while let Some(argument) = rest.next() {
            if argument != "--out" {
                return None;
            }
            plan.out = Some(PathBuf::from(rest.next()?));
        }
        Some(plan)
    }
}

/// 100, 316, 1,000, … for 4, 5, 6, …
fn half_decade(halves: i32) -> usize {
    10_f64.powf(f64::from(halves) / 2.0).round() as usize
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(plan) = Plan::from_arguments(&arguments) else {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    };
    match run(&plan, &mut std::io::stdout()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("paper: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(plan: &Plan, out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    if let Some(folder) = &plan.out {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    writeln!(out, "{}", machine(&[1]))?;
    writeln!(
        out,
        "{DETECTIONS} detections from raw coordinates, their validation included. Times are medians"
    )?;
    writeln!(out, "of {} rounds; \"best\" is the fastest round. All couples are as many", plan.rounds.count)?;
    writeln!(out, "as the closed forms say.")?;
    let linear = linear(plan, out)?;
    published(plan, out)?;
    let flat = flat(plan, out)?;
    if let Some(folder) = &plan.out {
        picture::write(&folder.join("nbs-linear.svg"), &linear)?;
        picture::write(&folder.join("nbs-flat.svg"), &flat)?;
    }
    Ok(())
}

/// Example I: time against N for the dense packing.
fn linear(plan: &Plan, out: &mut impl Write) -> Result<Vec<Panel>, Box<dyn Error>> {
    let mut cases = Vec::new();
    for &n in &plan.sizes {
        cases.push(Case::new::<2>(Packing::A, n, 1.0)?);
        cases.push(Case::new::<3>(Packing::A, n, 1.0)?);
    }
    let results = measure(cases, plan.rounds)?;
    let (mut totals, mut shares) = (Vec::new(), Vec::new());
    for (colour, dimension) in [2, 3].into_iter().enumerate() {
        let results: Vec<_> = results.iter().filter(|result| result.scene.dimension == dimension).collect();
        writeln!(out, "\n## Packing A, {dimension}D\n")?;
        let per_body = "µs per body and detection";
        let mut table =
            Table::new(&["N", "total for 10 [ms]", per_body, "best", "couples", "candidates per body"]);
        for result in &results {
            table.row([
                grouped(result.scene.n as u64),
                significant(1e3 * result.total()),
                significant(result.median()),
                significant(result.best()),
                grouped(result.scene.couples),
                format!("{:.2}", result.scene.candidates),
            ]);
        }
        writeln!(out, "{table}\nµs per body, largest / smallest:")?;
        writeln!(out, "- median: {}", Spread::of(&results, Measured::median).sentence())?;
        writeln!(out, "- best: {}", Spread::of(&results, Measured::best).sentence())?;

        let curve = |y: fn(&Measured) -> f64| Curve {
            name: format!("{dimension}D"),
            colour,
            hollow: false,
            points: results.iter().map(|result| (result.scene.n as f64, y(result))).collect(),
        };
        totals.push(curve(Measured::total));
        shares.push(curve(Measured::median));
    }
    let decades: Vec<f64> = (0..10).map(|k| 10_f64.powi(k)).collect();
    let x = Axis::within("number of bodies N", &decades, xs(&totals));
    let y = per_body_axis(ys(&shares));
    totals.push(Curve {
        name: "at most 6 s (2D, 1998)".to_owned(),
        colour: 0,
        hollow: true,
        points: vec![(PUBLISHED_N as f64, PUBLISHED_SECONDS)],
    });
    let title = format!("Munjiza-NBS, packing A: {DETECTIONS} detections");
    let total = Axis::covering("total time [s]", 10.0, 1.0, ys(&totals));
    Ok(vec![
        Panel { title, x: x.clone(), y: total, curves: totals },
        Panel { title: "the same per body (grid lines: factor 2)".to_owned(), x, y, curves: shares },
    ])
}

/// The only number that can be read off the published curves, next to ours.
fn published(plan: &Plan, out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let cases = vec![Case::new::<2>(Packing::A, PUBLISHED_N, 1.0)?];
    writeln!(out, "\n## Packing A, 2D, N = {}: published and here\n", grouped(PUBLISHED_N as u64))?;
    let mut table = Table::new(&["machine", "total for 10 [ms]", "µs per body and detection"]);
    let per_body = 1e6 * PUBLISHED_SECONDS / f64::from(DETECTIONS) / PUBLISHED_N as f64;
    table.row([
        "R4600, 133 MHz (1998), at most".to_owned(),
        format!("{:.0}", 1e3 * PUBLISHED_SECONDS),
        significant(per_body),
    ]);
    for result in measure(cases, plan.rounds)? {
        table.row(["here".to_owned(), significant(1e3 * result.total()), significant(result.median())]);
    }
    write!(out, "{table}")?;
    Ok(())
}

/// Examples II to IV: time against the spacing.
fn flat(plan: &Plan, out: &mut impl Write) -> Result<Vec<Panel>, Box<dyn Error>> {
    let packings = [Packing::B, Packing::C, Packing::D];
    let mut cases = Vec::new();
    for &spacing in &plan.spacings {
        for n in plan.flat_sizes {
            for packing in packings {
                cases.push(Case::new::<2>(packing, n, spacing)?);
                cases.push(Case::new::<3>(packing, n, spacing)?);
            }
        }
    }
    let results = measure(cases, plan.rounds)?;
    let mut panels = Vec::new();
    let x = Axis::within("spacing S/D", &plan.spacings, plan.spacings.iter().copied());
    let y = per_body_axis(results.iter().map(Measured::median));
    for dimension in [2, 3] {
        let mut curves = Vec::new();
        for n in plan.flat_sizes {
            let columns = packings.map(|packing| {
                let wanted = |r: &&Measured| {
                    (r.scene.dimension, r.scene.n, r.scene.packing) == (dimension, n, packing)
                };
                results.iter().filter(wanted).collect::<Vec<_>>()
            });
            let size = grouped(n as u64);
            writeln!(
                out,
                "\n## {dimension}D, N = {size}: µs per body and detection (candidates per body)\n"
            )?;
            write_flat(&plan.spacings, packings, &columns, out)?;
            let hollow = n == plan.flat_sizes[0];
            for (colour, (packing, column)) in packings.iter().zip(&columns).enumerate() {
                curves.push(Curve {
                    name: if hollow { String::new() } else { format!("packing {packing:?}") },
                    colour,
                    hollow,
                    points: column.iter().map(|result| (result.scene.spacing, result.median())).collect(),
                });
            }
        }
        let [hollow, filled] = plan.flat_sizes.map(|n| grouped(n as u64));
        let title = format!("{dimension}D, N = {filled}; hollow: N = {hollow}");
        panels.push(Panel { title, x: x.clone(), y: y.clone(), curves });
    }
    Ok(panels)
}

/// Writes one table of times and one of their spreads, with a column per packing and a row per spacing.
fn write_flat(
    spacings: &[f64],
    packings: [Packing; 3],
    columns: &[Vec<&Measured>; 3],
    out: &mut impl Write,
) -> std::io::Result<()> {
    let mut times = Table::new(&["S/D", "packing B", "packing C", "packing D"]);
    for (row, spacing) in spacings.iter().enumerate() {
        let cell = |column: &Vec<&Measured>| {
            format!("{} ({:.2})", significant(column[row].median()), column[row].scene.candidates)
        };
        times.row(std::iter::once(spacing.to_string()).chain(columns.iter().map(cell)));
    }
    writeln!(out, "{times}")?;

    let headings = ["largest / smallest", "median", "best", "from S/D = 2: median", "best"];
    let mut spreads = Table::new(&headings);
    for (packing, column) in packings.iter().zip(columns) {
        let sparse: Vec<_> = column.iter().copied().filter(|result| result.scene.spacing >= 2.0).collect();
        let ratio = |results: &[&Measured], y| format!("{:.2}", Spread::of(results, y).ratio());
        spreads.row([
            format!("packing {packing:?}"),
            ratio(column, Measured::median),
            ratio(column, Measured::best),
            ratio(&sparse, Measured::median),
            ratio(&sparse, Measured::best),
        ]);
    }
    write!(out, "{spreads}")
}

/// An axis with grid lines a factor of 2 apart.
fn per_body_axis(values: impl Iterator<Item = f64>) -> Axis {
    Axis::covering("time per body and detection [µs]", 2.0, 0.01, values)
}

fn xs(curves: &[Curve]) -> impl Iterator<Item = f64> {
    curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.0))
}

fn ys(curves: &[Curve]) -> impl Iterator<Item = f64> {
    curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1))
}

/// A packing whose couples have been checked.
#[derive(Clone, Copy)]
struct Scene {
    packing: Packing,
    dimension: usize,
    n: usize,
    spacing: f64,
    couples: u64,
    /// Number of couples per body that took the exact contact test.
    candidates: f64,
}

/// A scene that is ready to be searched, with the task of one detection.
struct Case {
    scene: Scene,
    task: Task<'static, fdem_contact::Error>,
}

impl Case {
    fn new<const D: usize>(packing: Packing, n: usize, spacing: f64) -> Result<Self, Box<dyn Error>> {
        let centres = packing.centres::<D>(n, spacing)?;
        let mut nbs = Nbs::<D>::new();
        let mut counter = Counter::default();
        let mut couples = 0;
        nbs.observe(&Elements::points(&centres, 1.0)?, &mut counter, |_| couples += 1)?;
        let counted = nbs.count(&Elements::points(&centres, 1.0)?)?;
        let expected = packing.couples::<D>(n, spacing);
        if [couples, counted] != [expected; 2] {
            let scene = format!("packing {packing:?}, {D}D, N = {n}, S/D = {spacing}");
            return Err(format!("{scene}: {couples} and {counted} couples instead of {expected}").into());
        }
        let candidates = counter.candidates as f64 / n as f64;
        let detection = move || {
            let elements = Elements::points(black_box(&centres), 1.0)?;
            black_box(nbs.count(&elements)?);
            Ok(())
        };
        let scene = Scene { packing, dimension: D, n, spacing, couples, candidates };
        Ok(Self { scene, task: Box::new(detection) })
    }
}

#[derive(Default)]
struct Counter {
    candidates: u64,
}

impl<const D: usize> Observer<D> for Counter {
    fn candidate(&mut self, _: Couple) {
        self.candidates += 1;
    }
}

/// A scene and the times of one detection in it.
struct Measured {
    scene: Scene,
    times: Times,
}

impl Measured {
    /// Time of the published number of detections, in seconds.
    fn total(&self) -> f64 {
        self.times.median * f64::from(DETECTIONS)
    }

    /// Median time per body and detection, in microseconds.
    fn median(&self) -> f64 {
        1e6 * self.times.median / self.scene.n as f64
    }

    /// Time per body and detection in the fastest round, in microseconds.
    fn best(&self) -> f64 {
        1e6 * self.times.best / self.scene.n as f64
    }
}

/// Times all cases in turns.
fn measure(cases: Vec<Case>, rounds: Rounds) -> Result<Vec<Measured>, fdem_contact::Error> {
    let (scenes, mut tasks): (Vec<_>, Vec<_>) = cases.into_iter().map(|case| (case.scene, case.task)).unzip();
    let times = times(&mut tasks, rounds)?;
    Ok(scenes.into_iter().zip(times).map(|(scene, times)| Measured { scene, times }).collect())
}

/// The smallest and the largest time per body, each with its N.
struct Spread {
    smallest: (f64, usize),
    largest: (f64, usize),
}

impl Spread {
    fn of(results: &[&Measured], y: fn(&Measured) -> f64) -> Self {
        let mut spread = Self { smallest: (f64::INFINITY, 0), largest: (0.0, 0) };
        for result in results {
            let (value, n) = (y(result), result.scene.n);
            if value < spread.smallest.0 {
                spread.smallest = (value, n);
            }
            if value > spread.largest.0 {
                spread.largest = (value, n);
            }
        }
        spread
    }

    fn ratio(&self) -> f64 {
        self.largest.0 / self.smallest.0
    }

    fn sentence(&self) -> String {
        let ratio = self.ratio();
        let verdict = if ratio <= 2.0 { "within a factor of 2" } else { "NOT within a factor of 2" };
        let [largest, smallest] = [self.largest.1, self.smallest.1].map(|n| grouped(n as u64));
        format!("{ratio:.2}, {verdict}; largest at N = {largest}, smallest at N = {smallest}")
    }
}
