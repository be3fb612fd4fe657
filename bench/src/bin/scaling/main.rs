//! Predicts how runs on many ranks scale: counts the elements and messages of the ranks of a real mesh,
//! measures the cost of an element, and puts both into a model of weak and strong scaling.
//!
//! Nothing runs on many ranks here. Counts are exact (`fdem_simulation::Forecast`), times of elements are
//! measured on one core, and the network is assumed.

mod estimate;
mod pattern;
mod report;

use std::error::Error;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use fdem_bench::bodies::MeshedCube;
use fdem_simulation::Network;

use estimate::Estimate;
use pattern::Pattern;

const USAGE: &str = "\
usage: scaling [--quick] [--elements N] [--ranks P,Q] [--timed N] [--rounds N] [--write FILE]

  --quick        6,000 elements on 2 and 8 ranks, one round: shows that all of it runs
  --elements N   elements of the mesh that is divided; about 2,000,000 if not given
  --ranks P,Q    numbers of ranks; 10,100,1000 if not given
  --timed N      elements of the mesh whose steps are timed; about 100,000 if not given
  --rounds N     9 if not given
  --write FILE   writes the output to a file, too
";

struct Plan {
    elements: usize,
    ranks: Vec<usize>,
    timed: usize,
    rounds: usize,
    /// Element-steps of one timing, elastic and joined.
    work: [f64; 2],
    write: Option<PathBuf>,
}

impl Plan {
    fn from_arguments(arguments: impl Iterator<Item = String>) -> Option<Self> {
        let mut plan = Self {
            elements: 2_000_000,
            ranks: vec![10, 100, 1000],
            timed: 100_000,
            rounds: 9,
            work: [14e6, 2e6],
            write: None,
        };
        let mut rest = arguments;
        while let Some(argument) = rest.next() {
            match argument.as_str() {
                "--quick" => {
                    (plan.elements, plan.timed, plan.rounds) = (6_000, 3_000, 1);
                    (plan.ranks, plan.work) = (vec![2, 8], [1e4, 1e4]);
                }
                "--elements" => plan.elements = rest.next()?.parse().ok()?,
                "--ranks" => {
                    let ranks = rest.next()?;
                    plan.ranks = ranks.split(',').map(|n| n.parse().ok()).collect::<Option<_>>()?;
                }
                "--timed" => plan.timed = rest.next()?.parse().ok()?,
                "--rounds" => plan.rounds = rest.next()?.parse().ok().filter(|&rounds| rounds > 0)?,
                "--write" => plan.write = Some(PathBuf::from(rest.next()?)),
                _ => return None,
            }
        }
        plan.ranks.sort_unstable();
        (!plan.ranks.is_empty()).then_some(plan)
    }
}

fn main() -> ExitCode {
    let Some(plan) = Plan::from_arguments(std::env::args().skip(1)) else {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    };
    match run(&plan) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("scaling: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(plan: &Plan) -> Result<(), Box<dyn Error>> {
    // Before the large mesh: afterwards the memory is scattered.
    let small = MeshedCube::new(plan.timed)?;
    let mut seconds = [0.0; 2];
    for (joined, seconds) in [false, true].into_iter().zip(&mut seconds) {
        *seconds = pattern::seconds(small.model(joined), plan.work[usize::from(joined)], plan.rounds)?;
        eprintln!("{}: {:.1} ns for an element in a step", report::name(joined), 1e9 * *seconds);
    }
    let timed = small.model(false).mesh.elements.len();
    drop(small);
    let cube = MeshedCube::new(plan.elements)?;
    let mut patterns = Vec::new();
    for joined in [false, true] {
        let found = Pattern::of(cube.model(joined), &plan.ranks)?;
        eprintln!("{}: {} elements divided", report::name(joined), found.elements);
        patterns.push(found);
    }
    let network = Network::default();
    let estimates: Vec<Estimate> = patterns
        .iter()
        .zip(seconds)
        .map(|(pattern, seconds)| Estimate::of(pattern.last(), seconds, network))
        .collect();
    let text = report::report(&patterns, &estimates, timed, plan.rounds);
    std::io::stdout().write_all(text.as_bytes())?;
    if let Some(file) = &plan.write {
        std::fs::write(file, text).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    Ok(())
}
