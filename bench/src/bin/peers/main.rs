//! Compares our searches with other libraries, on the same bodies in the same run.
//!
//! A peer is a Cargo feature of this package, or a program given with `--external`. Before anything is timed,
//! the couples of each library, or the number of pairs of each program, are compared with ours. Then all are
//! timed in turns, so that a temporary slowdown of the machine affects all of them.

mod plan;
mod compare;
mod count;
mod moving;
mod outcome;
mod report;
mod small;

use std::error::Error;
use std::fmt::Write as _;
use std::process::ExitCode;

use fdem_bench::peers::sets::{Scene, Set};
use fdem_bench::peers::{self, Peers, Threads};
use fdem_bench::{bars, picture};

use compare::{Scenes, compare};
use count::count;
use outcome::{Called, Outcome};
use plan::{Plan, USAGE};
use report::report;

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

/// Compares on one set, with each number of threads.
fn on_all<const D: usize>(
    plan: &Plan,
    set: &'static Set,
    scenes: &Scenes<D>,
    pools: &[Threads],
    rivals: impl Fn(&Threads) -> Peers<D>,
    called: &mut Vec<Called>,
) -> Result<Vec<Outcome>, Box<dyn Error>> {
    pools.iter().map(|threads| compare(plan, set, scenes, threads, rivals(threads), called)).collect()
}

fn run(plan: &Plan) -> Result<(), Box<dyn Error>> {
    if plan.small || plan.moving {
        let report = if plan.small { small::small(plan)? } else { moving::moving(plan)? };
        print(&report)?;
        if let Some(file) = &plan.out {
            std::fs::write(file, report).map_err(|error| format!("{}: {error}", file.display()))?;
        }
        return Ok(());
    }
    let pools: Vec<Threads> =
        plan.threads.iter().map(|&count| Threads::new(count)).collect::<Result<_, _>>()?;
    let mut called = Vec::new();
    let mut outcomes = Vec::new();
    for &set in &plan.sets {
        let more = match set.scene {
            Scene::Space(scene) => {
                on_all(plan, set, &Scenes::new(plan, set, scene)?, &pools, peers::rivals_3d, &mut called)
            }
            Scene::Plane(scene) => {
                on_all(plan, set, &Scenes::new(plan, set, scene)?, &pools, peers::rivals_2d, &mut called)
            }
        };
        outcomes.extend(more?);
    }
    let counted = if plan.quick { Vec::new() } else { count(plan)? };
    let report = report(plan, &called, &outcomes, &counted)?;
    print(&report)?;
    if let Some(file) = &plan.out {
        let plot = file.with_extension("svg");
        let name = plot.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let ratios = report::by_ratio(&outcomes, plan.threads[0]).filter(|_| !plan.quick);
        let ratio_plot = plot.with_file_name(format!("{}-ratio.svg", name.trim_end_matches(".svg")));
        let mut linked = report;
        if !plan.quick {
            writeln!(linked, "\n![Times]({name})")?;
        }
        if let Some(panel) = ratios {
            picture::write(&ratio_plot, &[panel])?;
            let name = ratio_plot.file_name().unwrap_or_default().to_string_lossy();
            writeln!(linked, "\n![Time against the ratio of sizes]({name})")?;
        }
        std::fs::write(file, linked).map_err(|error| format!("{}: {error}", file.display()))?;
        if !plan.quick {
            bars::write(&plot, &outcomes.iter().map(report::bars).collect::<Vec<_>>())?;
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
