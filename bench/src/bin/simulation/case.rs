//! One body of one size: times, memory, and shares of the parts of a step.

use std::error::Error;
use std::fmt::{self, Write as _};
use std::process::Command;
use std::time::{Duration, Instant};

use fdem_bench::bodies::Body;
use fdem_simulation::{Element, Mesh, Model, Simd, Simulation, Timings};

/// Lower bound on the duration of one timing, in seconds.
const FILL: f64 = 0.5;

/// Steps before any timing: fragments press each other evenly after the first few.
const SETTLE: u64 = 40;

/// Begins the names of the runs on slower vector instructions.
const ON: &str = "on:";

/// A body, and the way it is timed.
pub(crate) struct Case {
    body: Body,
    elements: usize,
    threads: usize,
    rounds: usize,
    external: Vec<(String, String)>,
}

/// The result, printed as `key value` pairs in one line.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) elements: usize,
    /// Mean number of contacts in the time that was measured.
    pub(crate) contacts: f64,
    pub(crate) detections: u64,
    pub(crate) broken: usize,
    /// Peak memory in bytes per element, without what the process held before.
    pub(crate) memory: f64,
    /// Median time of one step in seconds: on one thread, on several, and of other programs.
    pub(crate) seconds: Vec<(String, f64)>,
    /// Shares of bulk, joints, detection, contact and integration, on one thread.
    pub(crate) shares: [f64; 5],
}

impl Case {
    pub(crate) fn from_arguments(arguments: &[String]) -> Option<Self> {
        let [name, elements, threads, rounds, external @ ..] = arguments else { return None };
        let split =
            |text: &String| text.split_once('=').map(|(name, command)| (name.to_owned(), command.to_owned()));
        Some(Self {
            body: super::body(name)?,
            elements: elements.parse().ok()?,
            threads: threads.parse().ok()?,
            rounds: rounds.parse().ok()?,
            external: external.iter().map(split).collect::<Option<_>>()?,
        })
    }

    pub(crate) fn run(&self) -> Result<Outcome, Box<dyn Error>> {
        match self.body {
            Body::Plane(body) => self.measure(|elements| body.model(elements)),
            Body::Space(body) => self.measure(|elements| body.model(elements)),
        }
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
        let before = resident("VmRSS")?;
        let mut one = Simulation::new(model(self.elements), 1)?;
        let elements = one.model().mesh.elements.len();
        // Runs until detection has its memory and fragments have met.
        let steps = self.warm(&mut one)?;
        let memory = (resident("VmHWM")? - before) / elements as f64;
        let mut many = Simulation::new(model(self.elements), self.threads)?;
        many.advance(one.steps())?;
        let mut slower = Vec::new();
        if elements <= super::LARGEST {
            for simd in Simd::available().into_iter().filter(|&simd| simd != Simd::best()) {
                let mut run = Simulation::new(model(self.elements), 1)?;
                run.set_simd(simd);
                run.advance(one.steps())?;
                slower.push(run);
            }
        }
        let mesh = std::env::temp_dir().join(format!("fdem-bench-{}.msh", std::process::id()));
        if !self.external.is_empty() {
            std::fs::write(&mesh, gmsh(&one.model().mesh))?;
        }
        let start = one.timings();
        let mut contacts = Vec::with_capacity(self.rounds);
        let mut samples = vec![Vec::new(); 2 + self.external.len()];
        let mut on = vec![Vec::new(); slower.len()];
        for _ in 0..self.rounds {
            let runs = [&mut one, &mut many].into_iter().chain(&mut slower);
            for (run, samples) in runs.zip(samples[..2].iter_mut().chain(&mut on)) {
                let clock = Instant::now();
                run.advance(steps)?;
                samples.push(clock.elapsed().as_secs_f64() / steps as f64);
            }
            contacts.push(one.counts().contacts as f64);
            for ((name, command), samples) in self.external.iter().zip(&mut samples[2..]) {
                samples.push(outside(name, command, &mesh, steps)?);
            }
        }
        let _ = std::fs::remove_file(&mesh);
        let a = one.snapshot();
        let differs = |other: &Simulation<D, N>| {
            let b = other.snapshot();
            a.positions != b.positions || a.velocities != b.velocities || a.cracks != b.cracks
        };
        if differs(&many) {
            return Err(format!("{} threads give another result than one", self.threads).into());
        }
        if let Some(run) = slower.iter().find(|run| differs(run)) {
            return Err(format!("{} gives another result than {}", run.simd(), one.simd()).into());
        }
        let names = ["one", "many"]
            .map(str::to_owned)
            .into_iter()
            .chain(self.external.iter().map(|(name, _)| name.clone()))
            .chain(slower.iter().map(|run| format!("{ON}{}", run.simd())));
        let counts = one.counts();
        Ok(Outcome {
            elements,
            contacts: contacts.iter().sum::<f64>() / self.rounds as f64,
            detections: counts.detections,
            broken: counts.broken,
            memory,
            seconds: names.zip(samples.into_iter().chain(on).map(median)).collect(),
            shares: shares(&start, &one.timings()),
        })
    }

    /// Runs until the pace is known; returns the number of steps that fill a sample.
    fn warm<const D: usize, const N: usize>(&self, run: &mut Simulation<D, N>) -> Result<u64, Box<dyn Error>>
    where
        [[f64; D]; N]: Element<D, N>,
    {
        run.advance(SETTLE)?;
        let mut steps = 1;
        loop {
            let clock = Instant::now();
            run.advance(steps)?;
            let seconds = clock.elapsed().as_secs_f64();
            if seconds >= 0.2 * FILL || self.rounds == 1 {
                return Ok(((FILL / seconds * steps as f64) as u64).max(2));
            }
            steps *= 2;
        }
    }
}

/// The time of one step of another program, in seconds. It is given the mesh and the number of steps, and prints the seconds for all of
/// them.
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
        Some(seconds) => Ok(seconds / steps as f64),
        None => Err(format!("{name}: {}", String::from_utf8_lossy(&output.stderr).trim()).into()),
    }
}

impl Outcome {
    /// Element-steps per second of the program with this number.
    pub(crate) fn rate(&self, program: usize) -> f64 {
        self.elements as f64 / self.seconds[program].1
    }

    /// Names and element-steps per second of other programs.
    pub(crate) fn others(&self) -> impl Iterator<Item = (&str, f64)> {
        let rest = self.seconds[2..].iter().filter(|(name, _)| !name.starts_with(ON));
        rest.map(|(name, seconds)| (name.as_str(), self.elements as f64 / seconds))
    }

    /// Names and element-steps per second of the vector instructions that were compared with the best, on one thread.
    pub(crate) fn slower(&self) -> impl Iterator<Item = (&str, f64)> {
        self.seconds
            .iter()
            .filter_map(|(name, seconds)| Some((name.strip_prefix(ON)?, self.elements as f64 / seconds)))
    }

    /// Parses the line that [`fmt::Display`] writes.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let mut words = text.split_whitespace();
        let mut outcome = Self {
            elements: words.next()?.parse().ok()?,
            contacts: words.next()?.parse().ok()?,
            detections: words.next()?.parse().ok()?,
            broken: words.next()?.parse().ok()?,
            memory: words.next()?.parse().ok()?,
            seconds: Vec::new(),
            shares: [0.0; 5],
        };
        for share in &mut outcome.shares {
            *share = words.next()?.parse().ok()?;
        }
        while let Some(name) = words.next() {
            outcome.seconds.push((name.to_owned(), words.next()?.parse().ok()?));
        }
        (outcome.seconds.len() >= 2).then_some(outcome)
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{} {} {} {} {}",
            self.elements, self.contacts, self.detections, self.broken, self.memory
        )?;
        for share in self.shares {
            write!(out, " {share}")?;
        }
        for (name, seconds) in &self.seconds {
            write!(out, " {name} {seconds}")?;
        }
        Ok(())
    }
}

fn median(mut samples: Vec<f64>) -> f64 {
    samples.sort_unstable_by(f64::total_cmp);
    f64::midpoint(samples[(samples.len() - 1) / 2], samples[samples.len() / 2])
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
