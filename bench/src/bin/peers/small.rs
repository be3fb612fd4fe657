//! Small sets, where the cost of a search apart from its elements counts.

use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

use fdem_bench::peers::sets::{Made, SETS, Scene};
use fdem_bench::peers::{self, EngineKind, Peers, Threads};
use fdem_bench::{machine, significant};

use crate::plan::Plan;

const SIZES: [usize; 7] = [10, 30, 100, 300, 1_000, 3_000, 10_000];

/// Times taken of each search, in turns.
const ROUNDS: usize = 25;

/// A search runs so often that one time covers at least this, in seconds.
const FILL: f64 = 1e-3;

/// Compares on gases of few points, and returns tables in Markdown.
pub(crate) fn small(plan: &Plan) -> Result<String, Box<dyn Error>> {
    let threads = Threads::new(1)?;
    let mut report = format!(
        "# Small sets\n\n{}; {}.\n\nGas with 12 neighbours in `f64`, from coordinates to the list of couples, on one thread; memory is reused where a \
         search allows it. Medians of {ROUNDS} rounds in turns, each of at least {} ms; the quartiles in % of the median; in brackets \
         times that of ours. All find the same couples.\n",
        machine(&[1]),
        plan.simd.name(),
        significant(FILL * 1e3),
    );
    for set in SETS.iter().filter(|set| ["gas1m", "gas2d1m"].contains(&set.name)) {
        match set.scene {
            Scene::Space(scene) => {
                table(plan, "In space", scene, || peers::rivals_3d(&threads), &mut report)?;
            }
            Scene::Plane(scene) => {
                table(plan, "In the plane", scene, || peers::rivals_2d(&threads), &mut report)?;
            }
        }
    }
    Ok(report)
}

fn table<const D: usize>(
    plan: &Plan,
    title: &str,
    scene: fn(usize) -> Result<Made<D>, fdem_scenes::Error>,
    rivals: impl Fn() -> Peers<D>,
    report: &mut String,
) -> Result<(), Box<dyn Error>> {
    let mut is_first = true;
    for n in SIZES {
        let made = scene(n)?;
        let mut searches = peers::ours::<D>(&[EngineKind::Auto], plan.simd, 1)?;
        searches.extend(rivals());
        let mut couples = Vec::new();
        let mut expected = None;
        let mut runs = Vec::new();
        for search in &mut searches {
            search.couples(made.bodies(), &mut couples)?;
            if *expected.get_or_insert(couples.len()) != couples.len() {
                return Err(format!("{n} points: {} finds {} couples", search.name(), couples.len()).into());
            }
            let start = Instant::now();
            search.couples(made.bodies(), &mut couples)?;
            runs.push((FILL / start.elapsed().as_secs_f64().max(1e-9)) as usize + 1);
        }
        let mut samples = vec![Vec::new(); searches.len()];
        for _ in 0..ROUNDS {
            for ((search, samples), &runs) in searches.iter_mut().zip(&mut samples).zip(&runs) {
                let start = Instant::now();
                for _ in 0..runs {
                    search.couples(black_box(made.bodies()), &mut couples)?;
                    black_box(&couples);
                }
                samples.push(start.elapsed().as_secs_f64() / runs as f64);
            }
        }
        if std::mem::take(&mut is_first) {
            let names: Vec<_> = searches.iter().map(|search| format!("{} [µs]", search.name())).collect();
            writeln!(report, "\n## {title}\n\n| points | couples | {} |", names.join(" | "))?;
            writeln!(report, "|{}", "--:|".repeat(searches.len() + 2))?;
        }
        let mut ours = None;
        write!(report, "| {n} | {} |", expected.unwrap_or(0))?;
        for mut samples in samples {
            samples.sort_unstable_by(f64::total_cmp);
            let at = |quarter: usize| samples[(samples.len() - 1) * quarter / 4];
            let median = at(2);
            let percent = |x: f64| 100.0 * (x / median - 1.0);
            let times = median / *ours.get_or_insert(median);
            let (low, high) = (percent(at(1)), percent(at(3)));
            write!(report, " {} ({times:.2}; {low:.0} to +{high:.0} %) |", significant(median * 1e6))?;
        }
        writeln!(report)?;
        eprintln!("{title}, {n}");
    }
    Ok(())
}
