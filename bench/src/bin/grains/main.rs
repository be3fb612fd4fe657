//! Measures the speed of spheres in sphere-steps per second: a chute with Hooke's law, as in the benchmark of
//! LAMMPS, and a tube in which spheres settle; with Hooke's law and with that of Hertz and Mindlin.

mod case;
mod exchange;

use std::error::Error;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use case::{Law, Place};
use fdem_bench::{Table, Times, Turn, grouped, machine, turns};
use fdem_contact::Simd;
use fdem_grains::{GrainRun, Spheres};

const USAGE: &str = "\
usage: grains [--case chute|tube] [--law hooke|hertz] [--spheres N] [--steps N] [--rounds N] [--threads N,M]
              [--simd LEVEL,LEVEL] [--from FILE] [--prepare FILE] [--seconds] [--quick]

  --case NAME      chute if not given
  --law NAME       hooke if not given
  --spheres N      32000 in the chute, 30000 in the tube
  --steps N        steps of a round; 1000 if not given
  --rounds N       5 if not given
  --threads N,M    1 if not given
  --simd LEVELS    all that this processor has if not given: portable, neon, avx2, avx512
  --from FILE      spheres to begin with, from --prepare; otherwise they are prepared first, for about a minute
  --prepare FILE   writes these spheres as a data file of LAMMPS, and ends
  --seconds        prints the seconds of the processor in a round alone
  --quick          1,000 spheres, 10 steps, one round: shows that all runs
";

/// Steps that are not timed: contacts have their history after them.
const UNCOUNTED: u64 = 200;

/// The case to run, and how.
struct Plan {
    place: Place,
    law: Law,
    spheres: Option<usize>,
    steps: u64,
    rounds: usize,
    threads: Vec<usize>,
    levels: Vec<Simd>,
    from: Option<PathBuf>,
    prepare: Option<PathBuf>,
    seconds: bool,
}

impl Plan {
    fn from_arguments(arguments: &[String]) -> Option<Self> {
        let mut plan = Self {
            place: Place::Chute,
            law: Law::Hooke,
            spheres: None,
            steps: 1000,
            rounds: 5,
            threads: vec![1],
            levels: Simd::available(),
            from: None,
            prepare: None,
            seconds: false,
        };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            match argument.as_str() {
                "--case" => plan.place = Place::named(rest.next()?)?,
                "--law" => plan.law = Law::named(rest.next()?)?,
                "--spheres" => plan.spheres = Some(rest.next()?.parse().ok().filter(|&n| n > 0)?),
                "--steps" => plan.steps = rest.next()?.parse().ok().filter(|&steps| steps > 0)?,
                "--rounds" => plan.rounds = rest.next()?.parse().ok().filter(|&rounds| rounds > 0)?,
                "--threads" => {
                    plan.threads = rest.next()?.split(',').map(|n| n.parse().ok()).collect::<Option<_>>()?;
                }
                "--simd" => plan.levels = rest.next()?.split(',').map(level).collect::<Option<_>>()?,
                "--from" => plan.from = Some(PathBuf::from(rest.next()?)),
                "--prepare" => plan.prepare = Some(PathBuf::from(rest.next()?)),
                "--seconds" => plan.seconds = true,
                "--quick" => (plan.spheres, plan.steps, plan.rounds) = (Some(1000), 10, 1),
                _ => return None,
            }
        }
        Some(plan)
    }

    /// The spheres with which the runs begin.
    fn spheres(&self) -> Result<Spheres, Box<dyn Error>> {
        match &self.from {
            Some(path) => exchange::read(path),
            None => case::prepared(self.place, self.spheres.unwrap_or(self.place.usual())),
        }
    }
}

/// Instructions of this name, if the processor has them.
fn level(name: &str) -> Option<Simd> {
    Simd::available().into_iter().find(|level| level.name() == name)
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(plan) = Plan::from_arguments(&arguments) else {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    };
    match measure(&plan) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("grains: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Seconds that processors have worked for this process, where the system says so: on a machine that is not
/// quiet they count for one thread.
fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Behind the name in parentheses; in hundredths of a second.
    let mut words = text.rsplit(')').next()?.split_whitespace().skip(11);
    let [user, system]: [f64; 2] = [words.next()?.parse().ok()?, words.next()?.parse().ok()?];
    Some(0.01 * (user + system))
}

/// Times of the runs, which take turns.
fn time(plan: &Plan, runs: &mut [GrainRun]) -> Result<Vec<Times>, Box<dyn Error>> {
    let begin = Instant::now();
    let clock = || {
        let worked = if plan.seconds { processor_seconds() } else { None };
        worked.unwrap_or_else(|| begin.elapsed().as_secs_f64())
    };
    let mut tasks: Vec<Turn<'_, Box<dyn Error>>> = Vec::new();
    for run in runs {
        tasks.push(Box::new(|| {
            let start = clock();
            run.advance(plan.steps)?;
            Ok(clock() - start)
        }));
    }
    turns(&mut tasks, plan.rounds, f64::INFINITY).into_iter().collect()
}

fn measure(plan: &Plan) -> Result<(), Box<dyn Error>> {
    let spheres = plan.spheres()?;
    if let Some(path) = &plan.prepare {
        return exchange::write(path, plan.place, &spheres);
    }
    let count = spheres.positions.len();
    let ways: Vec<(Simd, usize)> = plan
        .levels
        .iter()
        .flat_map(|&level| plan.threads.iter().map(move |&threads| (level, threads)))
        .collect();
    let mut runs = Vec::new();
    for &(level, threads) in &ways {
        let model = case::model(plan.place, plan.law, spheres.clone(), count);
        let mut run = GrainRun::new(model, threads)?.with_simd(level);
        run.advance(UNCOUNTED)?;
        runs.push(run);
    }
    let times = time(plan, &mut runs)?;
    let mut out = std::io::stdout();
    if plan.seconds {
        for time in times {
            writeln!(out, "{}", time.median)?;
        }
        return Ok(());
    }
    writeln!(out, "{}\n", machine(&plan.threads))?;
    let contacts = runs[0].contacts().len() as f64 / count as f64;
    writeln!(
        out,
        "{}, {}: {} spheres, {contacts:.2} contacts for each, {} steps in a round\n",
        plan.place.name(),
        plan.law.name(),
        grouped(count as u64),
        plan.steps
    )?;
    let mut table = Table::new(&["instructions", "threads", "M sphere-steps/s", "best"]);
    for (time, (level, threads)) in times.iter().zip(&ways) {
        let speed = |seconds: f64| format!("{:.2}", 1e-6 * plan.steps as f64 * count as f64 / seconds);
        table.row([level.name().to_owned(), threads.to_string(), speed(time.median), speed(time.best)]);
    }
    writeln!(out, "{table}")?;
    let same = |run: &GrainRun| run.steps() != runs[0].steps() || run.state() == runs[0].state();
    if !runs.iter().all(same) {
        return Err("results depend on instructions or threads".into());
    }
    Ok(())
}
