//! Measures the speed of a simulation step in element-steps per second, for bodies and numbers of elements,
//! on one thread and on several.
//!
//! Each case runs in its own process, which reports its memory. The limits of the machine are measured too.

mod before;
mod case;
mod levels;
mod limits;
mod outcome;
mod report;

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use case::{Case, LARGEST, body};
use fdem_bench::bodies::{Body, Plane, Space};
use fdem_contact::Simd;
use outcome::Outcome;
use report::Setting;

const USAGE: &str = "\
usage: simulation [--quick] [--bodies NAMES] [--elements N,M] [--threads N] [--rounds N] [--simd LEVEL]
                  [--before PROGRAM] [--external NAME=COMMAND]... [--external-joints NAME=COMMAND]...
                  [--external-space NAME=COMMAND]... [--external-space-joints NAME=COMMAND]... [--write FILE]

  --quick                  1,000 elements, one round: shows that all runs
  --bodies NAMES           some of bar,disc,joined,adaptive,intrinsic,heap,near,softening,breaking,blown,
                           cube,cube-adaptive,cube-joined,debris,cube-near,cube-softening,cube-breaking,cube-blown
  --elements N,M           10000,100000,1000000 if not given
  --threads N              to compare with one thread; 2 if not given; 1 for no comparison
  --rounds N               5 if not given
  --simd LEVEL             vector instructions: portable, neon, avx2 or avx512; the best of this processor if not given
  --before PROGRAM         this program of an earlier version, see README.md: takes turns with this one
  --external NAME=COMMAND  a program that simulates the bar and the disc as well, see README.md; may be repeated
  --external-joints NAME=COMMAND
                           one that simulates the disc with joints on every edge
  --external-space NAME=COMMAND, --external-space-joints NAME=COMMAND
                           likewise for the cube of tetrahedra
  --write FILE             writes the output to a file, too
";

/// The cases to run.
struct Plan {
    bodies: Vec<Body>,
    elements: Vec<usize>,
    threads: usize,
    rounds: usize,
    /// Steps of one timing, if not those of the body.
    steps: Option<u64>,
    /// The vector instructions; `None` for the best that the processor has.
    level: Option<Simd>,
    /// This program of an earlier version.
    before: Option<PathBuf>,
    /// `NAME=COMMAND` of programs: for bodies in the plane, and for those in space.
    external: [External; 2],
    write: Option<PathBuf>,
}

/// `NAME=COMMAND` of programs.
#[derive(Default)]
struct External {
    /// Programs for bodies without joints.
    whole: Vec<String>,
    /// Programs for bodies with joints on every facet.
    joined: Vec<String>,
}

impl Plan {
    fn from_arguments(arguments: &[String]) -> Option<Self> {
        let mut plan = Self {
            bodies: Body::all().collect(),
            elements: vec![10_000, 100_000, 1_000_000],
            threads: 2,
            rounds: 5,
            steps: None,
            level: None,
            before: None,
            external: Default::default(),
            write: None,
        };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            match argument.as_str() {
                "--quick" => (plan.elements, plan.rounds, plan.steps) = (vec![1_000], 1, Some(4)),
                "--bodies" => plan.bodies = rest.next()?.split(',').map(body).collect::<Option<_>>()?,
                "--elements" => {
                    plan.elements = rest.next()?.split(',').map(|n| n.parse().ok()).collect::<Option<_>>()?;
                }
                "--threads" => plan.threads = rest.next()?.parse().ok().filter(|&threads| threads > 0)?,
                "--rounds" => plan.rounds = rest.next()?.parse().ok().filter(|&rounds| rounds > 0)?,
                "--simd" => plan.level = Some(levels::named(rest.next()?)?),
                "--before" => plan.before = Some(PathBuf::from(rest.next()?)),
                "--external" => plan.external[0].whole.push(rest.next()?.clone()),
                "--external-joints" => plan.external[0].joined.push(rest.next()?.clone()),
                "--external-space" => plan.external[1].whole.push(rest.next()?.clone()),
                "--external-space-joints" => plan.external[1].joined.push(rest.next()?.clone()),
                "--write" => plan.write = Some(PathBuf::from(rest.next()?)),
                _ => return None,
            }
        }
        Some(plan)
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.split_first() {
        // A case that this program started itself.
        Some((task, rest)) if task == "case" => alone(rest),
        // A case that a later version of this program started.
        Some((task, rest)) if task == "turns" => turns(rest),
        _ => {
            let Some(plan) = Plan::from_arguments(&arguments) else {
                eprint!("{USAGE}");
                return ExitCode::from(2);
            };
            compare(&plan)
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("simulation: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs one case in this process and prints its result to standard output.
fn alone(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let case =
        Case::from_arguments(arguments).ok_or("case: a body, a number of elements, and how it is timed")?;
    writeln!(std::io::stdout(), "{}", case.run()?)?;
    Ok(())
}

/// Runs one case in this process, a few steps at each request of the later version.
fn turns(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    Case::of_turns(arguments).ok_or("turns: a body, and numbers of elements and steps")?.answer()
}

fn compare(plan: &Plan) -> Result<(), Box<dyn Error>> {
    let own = std::env::current_exe()?;
    let limits = limits::measure(plan.threads)?;
    let mut outcomes = Vec::new();
    for &elements in &plan.elements {
        for &body in &plan.bodies {
            let [size, threads, rounds] =
                [elements, plan.threads, plan.rounds].map(|number| number.to_string());
            let steps = plan.steps.unwrap_or(body.steps(elements)).to_string();
            let level = plan.level.map_or("", Simd::name);
            let before = plan.before.as_deref().unwrap_or(Path::new(""));
            let external = match body {
                _ if elements > LARGEST => &[][..],
                Body::Plane(Plane::Bar | Plane::Disc) => &plan.external[0].whole,
                Body::Plane(Plane::Joined) => &plan.external[0].joined,
                Body::Space(Space::Cube) => &plan.external[1].whole,
                Body::Space(Space::CubeJoined) => &plan.external[1].joined,
                _ => &[],
            };
            let output = Command::new(&own)
                .args(["case", body.name(), &size, level, &steps, &threads, &rounds])
                .arg(before)
                .args(external)
                .output()?;
            let text = String::from_utf8(output.stdout)?;
            let outcome = Outcome::read(&text).filter(|_| output.status.success()).ok_or_else(|| {
                format!(
                    "{} with {elements} elements: {}",
                    body.name(),
                    String::from_utf8_lossy(&output.stderr).trim()
                )
            })?;
            eprintln!(
                "{:9} {elements:9} elements: {:.2} million element-steps per second",
                body.name(),
                outcome.one() / 1e6
            );
            outcomes.push((body, outcome));
        }
    }
    let setting = Setting { threads: plan.threads, rounds: plan.rounds, level: plan.level };
    let report = report::report(&setting, &limits, &outcomes);
    std::io::stdout().write_all(report.as_bytes())?;
    if let Some(file) = &plan.write {
        std::fs::write(file, report).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    Ok(())
}
