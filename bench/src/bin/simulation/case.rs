//! One body of one size: everything that is timed takes a fixed number of steps, in turns.

use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use fdem_bench::bodies::Body;
use fdem_contact::Simd;
use fdem_simulation::{Element, Mesh, Model, Simulation, Timings};

use crate::before::{self, Before, Turn};
use crate::levels;
use crate::outcome::{Outcome, Program};

/// Beyond this number of elements other programs are left out, because they take minutes to start.
pub(crate) const LARGEST: usize = 200_000;

/// Steps before any timing: fragments press each other evenly after the first few.
const SETTLE: u64 = 40;

/// A body, and the way it is timed.
pub(crate) struct Case {
    body: Body,
    elements: usize,
    /// The vector instructions; `None` for the best that the processor has.
    level: Option<Simd>,
    /// Steps of one timing.
    steps: u64,
    /// Compared with one thread if there are more.
    threads: usize,
    rounds: usize,
    /// Another binary of this program, of an earlier version.
    before: Option<PathBuf>,
    /// Names and commands of other programs.
    external: Vec<(String, String)>,
}

impl Case {
    pub(crate) fn from_arguments(arguments: &[String]) -> Option<Self> {
        let [name, elements, level, steps, threads, rounds, before, external @ ..] = arguments else {
            return None;
        };
        let split =
            |text: &String| text.split_once('=').map(|(name, command)| (name.to_owned(), command.to_owned()));
        Some(Self {
            threads: threads.parse().ok()?,
            rounds: rounds.parse().ok()?,
            before: Some(PathBuf::from(before)).filter(|path| !path.as_os_str().is_empty()),
            external: external.iter().map(split).collect::<Option<_>>()?,
            ..Self::of_turns(&[name, elements, level, steps].map(Clone::clone))?
        })
    }

    /// A case that takes a turn at each request.
    pub(crate) fn of_turns(arguments: &[String]) -> Option<Self> {
        let [name, elements, level, steps] = arguments else { return None };
        Some(Self {
            body: body(name)?,
            elements: elements.parse().ok()?,
            level: levels::named(level),
            steps: steps.parse().ok()?,
            threads: 1,
            rounds: 1,
            before: None,
            external: Vec::new(),
        })
    }

    pub(crate) fn run(&self) -> Result<Outcome, Box<dyn Error>> {
        match self.body {
            Body::Plane(body) => self.measure(|elements| body.model(elements)),
            Body::Space(body) => self.measure(|elements| body.model(elements)),
        }
    }

    /// Takes turns for a later version that is compared with this one.
    pub(crate) fn answer(&self) -> Result<(), Box<dyn Error>> {
        match self.body {
            Body::Plane(body) => self.turns(body.model(self.elements)),
            Body::Space(body) => self.turns(body.model(self.elements)),
        }
    }

    fn turns<const D: usize, const N: usize>(&self, model: Model<D, N>) -> Result<(), Box<dyn Error>>
    where
        [[f64; D]; N]: Element<D, N>,
    {
        let mut run = self.ready(model, 1, self.level)?;
        before::answer(|| {
            let seconds = timed(&mut run, self.steps)?;
            Ok(Turn { seconds, contacts: run.counts().contacts as f64 })
        })
    }

    /// Runs the same model in turns, so that a temporary slowdown of the machine affects all runs.
    fn measure<const D: usize, const N: usize>(
        &self,
        model: impl Fn(usize) -> Model<D, N>,
    ) -> Result<Outcome, Box<dyn Error>>
    where
        [[f64; D]; N]: Element<D, N>,
    {
        // A first small run, so that the memory of the program itself is not counted.
        Simulation::new(model(200), 1)?.advance(100)?;
        let held = resident("VmRSS")?;
        let mut one = self.ready(model(self.elements), 1, self.level)?;
        let elements = one.model().mesh.elements.len();
        let memory = (resident("VmHWM")? - held) / elements as f64;
        let mut others = Vec::new();
        if self.threads > 1 {
            others.push((Program::Many, self.ready(model(self.elements), self.threads, self.level)?));
        }
        if elements <= LARGEST {
            for level in levels::others(self.level) {
                let run = self.ready(model(self.elements), 1, Some(level))?;
                others.push((Program::On(level.to_string()), run));
            }
        }
        let mesh = std::env::temp_dir().join(format!("fdem-bench-{}.msh", std::process::id()));
        if !self.external.is_empty() {
            std::fs::write(&mesh, gmsh(&one.model().mesh))?;
        }
        let [size, pace] = [self.elements.to_string(), self.steps.to_string()];
        let case = [self.body.name(), &size, self.level.map_or("", Simd::name), &pace];
        let mut earlier = self.before.as_ref().map(|program| Before::start(program, case)).transpose()?;
        let start = one.timings();
        let steps = self.steps;
        let mut contacts = [0.0; 2];
        let programs = [Program::One].into_iter().chain(earlier.iter().map(|_| Program::Before));
        let programs = programs.chain(others.iter().map(|(program, _)| program.clone()));
        let programs = programs.chain(self.external.iter().map(|(name, _)| Program::Other(name.clone())));
        let mut seconds: Vec<(Program, Vec<f64>)> = programs.map(|program| (program, Vec::new())).collect();
        for _ in 0..self.rounds {
            let mut round = vec![timed(&mut one, steps)?];
            contacts[0] += one.counts().contacts as f64 / self.rounds as f64;
            if let Some(earlier) = &mut earlier {
                let turn = earlier.turn()?;
                contacts[1] += turn.contacts / self.rounds as f64;
                round.push(turn.seconds);
            }
            for (_, run) in &mut others {
                round.push(timed(run, steps)?);
            }
            for (name, command) in &self.external {
                round.push(outside(name, command, &mesh, steps)?);
            }
            for ((_, samples), taken) in seconds.iter_mut().zip(round) {
                samples.push(taken / steps as f64);
            }
        }
        let _ = std::fs::remove_file(&mesh);
        let a = one.snapshot();
        for (program, run) in &others {
            let b = run.snapshot();
            if a.positions != b.positions || a.velocities != b.velocities || a.cracks != b.cracks {
                return Err(format!("{program}: another result than on one thread").into());
            }
        }
        let counts = one.counts();
        Ok(Outcome {
            elements,
            steps,
            contacts,
            detections: counts.detections,
            broken: counts.broken,
            memory,
            shares: shares(&start, &one.timings()),
            seconds,
        })
    }

    /// A run whose detection has its memory and whose fragments press each other.
    fn ready<const D: usize, const N: usize>(
        &self,
        model: Model<D, N>,
        threads: usize,
        level: Option<Simd>,
    ) -> Result<Simulation<D, N>, Box<dyn Error>>
    where
        [[f64; D]; N]: Element<D, N>,
    {
        let mut run = Simulation::new(model, threads)?;
        levels::choose(&mut run, level);
        run.advance(SETTLE + self.steps / 4)?;
        Ok(run)
    }
}

/// Seconds for the given number of steps.
fn timed<const D: usize, const N: usize>(
    run: &mut Simulation<D, N>,
    steps: u64,
) -> Result<f64, Box<dyn Error>>
where
    [[f64; D]; N]: Element<D, N>,
{
    let clock = Instant::now();
    run.advance(steps)?;
    Ok(clock.elapsed().as_secs_f64())
}

/// The time of another program, in seconds. It is given the mesh and the number of steps, and prints the
/// seconds for all of them.
fn outside(name: &str, command: &str, mesh: &std::path::Path, steps: u64) -> Result<f64, Box<dyn Error>> {
    let mut words = command.split_whitespace();
    let output = Command::new(words.next().ok_or("an empty command")?)
        .args(words)
        .arg(mesh)
        .arg(steps.to_string())
        .output()
        .map_err(|error| format!("{name}: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let seconds = text.split_whitespace().last().and_then(|word| word.parse::<f64>().ok());
    match seconds.filter(|_| output.status.success()) {
        Some(seconds) => Ok(seconds),
        None => Err(format!("{name}: {}", String::from_utf8_lossy(&output.stderr).trim()).into()),
    }
}

/// The shares of the time between two readings.
fn shares(start: &Timings, end: &Timings) -> [f64; 5] {
    let parts = |timings: &Timings| {
        [timings.bulk, timings.joints, timings.detection, timings.contact, timings.integration]
    };
    let spent: Vec<f64> = parts(start)
        .into_iter()
        .zip(parts(end))
        .map(|(a, b): (Duration, Duration)| b.saturating_sub(a).as_secs_f64())
        .collect();
    let all = spent.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    std::array::from_fn(|part| spent[part] / all)
}

/// Memory of this process in bytes, as reported by Linux.
fn resident(key: &str) -> Result<f64, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))
        .ok_or("no memory is told here")?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse()?;
    Ok(1024.0 * kilobytes)
}

/// The mesh as a Gmsh file, version 2.2.
fn gmsh<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> String {
    // The numbers of triangles and tetrahedra in the format.
    let kind = if D == 2 { 2 } else { 4 };
    let mut text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n{D} 1 \"body\"\n$EndPhysicalNames\n$Nodes\n{}\n",
        mesh.nodes.len()
    );
    for (number, node) in mesh.nodes.iter().enumerate() {
        let [x, y, z] = std::array::from_fn(|axis| node.get(axis).copied().unwrap_or(0.0));
        let _ = writeln!(text, "{} {x} {y} {z}", number + 1);
    }
    let _ = write!(text, "$EndNodes\n$Elements\n{}\n", mesh.elements.len());
    for (number, nodes) in mesh.elements.iter().enumerate() {
        let _ = write!(text, "{} {kind} 2 1 1", number + 1);
        for node in nodes {
            let _ = write!(text, " {}", node + 1);
        }
        text.push('\n');
    }
    text.push_str("$EndElements\n");
    text
}

/// The body of this name.
pub(crate) fn body(name: &str) -> Option<Body> {
    Body::all().find(|body| body.name() == name)
}
