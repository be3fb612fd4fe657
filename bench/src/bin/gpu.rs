//! Compares and times searches for contacts, and steps of simulations, on a graphics processor and on all
//! processors of the machine.
//!
//! It fails without a graphics processor, and if a couple or a state differs.

use std::error::Error;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use fdem_bench::bodies::Space;
use fdem_bench::{Rounds, Table, Task, grouped, machine, times};
use fdem_contact::{Elements, Rows, Search};
use fdem_gpu::{Cuda, DeviceRows, DeviceSolid};
use fdem_simulation::Simulation;

const USAGE: &str = "\
usage: gpu [--device N] [--elements N,M] [--bodies N,M] [--write FILE]

  --device N       0 if not given
  --elements N,M   spheres of searches: 1000000,10000000 if not given
  --bodies N,M     elements of simulations: 100000,1000000 if not given
  --write FILE     also writes the report there
";

/// Times taken of each search and of each simulation.
const ROUNDS: usize = 8;

/// Steps of one time with 100,000 elements.
const STEPS: u64 = 200;

struct Settings {
    device: usize,
    elements: Vec<usize>,
    bodies: Vec<usize>,
    write: Option<PathBuf>,
}

impl Settings {
    fn from_arguments(mut arguments: impl Iterator<Item = String>) -> Option<Self> {
        let mut settings = Self {
            device: 0,
            elements: vec![1_000_000, 10_000_000],
            bodies: vec![100_000, 1_000_000],
            write: None,
        };
        let numbers = |text: &str| text.split(',').map(|n| n.parse().ok()).collect::<Option<Vec<usize>>>();
        while let Some(argument) = arguments.next() {
            let value = arguments.next()?;
            match argument.as_str() {
                "--device" => settings.device = value.parse().ok()?,
                "--elements" => settings.elements = numbers(&value)?,
                "--bodies" => settings.bodies = numbers(&value)?,
                "--write" => settings.write = Some(PathBuf::from(value)),
                _ => return None,
            }
        }
        Some(settings)
    }
}

fn main() -> ExitCode {
    let Some(settings) = Settings::from_arguments(std::env::args().skip(1)) else {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    };
    match run(&settings) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("gpu: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(settings: &Settings) -> Result<(), Box<dyn Error>> {
    let device = fdem_gpu::opened(settings.device)?;
    let info = device.info();
    let searches = searches(settings, &device)?;
    let steps = steps(settings, &device)?;
    let text = format!(
        "# Graphics processors\n\n{}\n\nDevice: {}, {} GiB. Targets are for an NVIDIA H200. Rewritten by `just gpu`, which \
         also compares the results of the examples.\n\n## Searches\n\nGas of spheres of one radius. The couples of the \
         device are those of the processors, in their order. Medians of {ROUNDS} rounds by turns, with the copies of \
         spheres and couples; the targets are for arrays that are on the device.\n\n{searches}\n## Steps\n\nElement-steps \
         per second. The state after all steps is that of the processors, to the bit.\n\n{steps}",
        machine(&[0]),
        info.name,
        info.memory >> 30
    );
    std::io::stdout().write_all(text.as_bytes())?;
    if let Some(file) = &settings.write {
        std::fs::write(file, text).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    Ok(())
}

/// Searches on the device and on the processors, which must agree.
fn searches(settings: &Settings, device: &Cuda) -> Result<Table, Box<dyn Error>> {
    let mut table = Table::new(&[
        "spheres",
        "couples",
        "processors: list, ms",
        "device: list, ms",
        "device: count, ms",
        "target, ms",
        "ratio of lists",
    ]);
    for &n in &settings.elements {
        let gas = fdem_scenes::peers::gas(n, 1)?;
        let elements = Elements::spheres_with_radii(&gas.centres, &gas.radii)?;
        let mut rows = Rows::new().with_threads(0)?;
        let mut on_device = DeviceRows::new(device);
        let (mut ours, mut found) = (Vec::new(), Vec::new());
        rows.couples(&elements, &mut ours)?;
        on_device.couples(&elements, &mut found)?;
        if found != ours {
            return Err(format!("{n} spheres: the couples of the device differ").into());
        }
        let mut counting = DeviceRows::new(device);
        let mut tasks: [Task<'_, fdem_contact::Error>; 3] = [
            Box::new(|| rows.couples(&elements, &mut ours)),
            Box::new(|| on_device.couples(&elements, &mut found)),
            Box::new(|| counting.count(&elements).map(|_| ())),
        ];
        let rounds = Rounds { count: ROUNDS, runs: 1, fill: Duration::from_millis(100) };
        let [on_host, list, count] = times(&mut tasks, rounds)?.try_into().expect("three tasks");
        drop(tasks);
        table.row([
            grouped(n as u64),
            grouped(ours.len() as u64),
            format!("{:.2}", 1e3 * on_host.median),
            format!("{:.2}", 1e3 * list.median),
            format!("{:.2}", 1e3 * count.median),
            target(&SEARCHES, n),
            format!("{:.1}", on_host.median / list.median),
        ]);
    }
    Ok(table)
}

/// Targets on an NVIDIA H200: of searches by their spheres, ms, and of steps by their elements, in
/// element-steps per second.
const SEARCHES: [(usize, &str); 3] = [(1_000_000, "0.25"), (10_000_000, "2"), (100_000_000, "20")];
const ELASTIC: [(usize, &str); 3] = [(100_000, "5.5 G"), (1_000_000, "7 G"), (10_000_000, "8 G")];

/// The target for the nearest size, on a scale of ratios.
fn target(of: &[(usize, &str)], n: usize) -> String {
    let far = |size: usize| (n as f64 / size as f64).ln().abs();
    let nearest = of.iter().min_by(|a, b| far(a.0).total_cmp(&far(b.0)));
    nearest
        .filter(|(size, _)| far(*size) < 0.7)
        .map_or_else(|| "-".to_owned(), |(_, text)| (*text).to_owned())
}

/// Steps on the device and on the processors, which must agree.
fn steps(settings: &Settings, device: &Arc<Cuda>) -> Result<Table, Box<dyn Error>> {
    let mut table = Table::new(&[
        "body",
        "elements",
        "processors, M",
        "device, M",
        "target",
        "ratio",
        "device, bytes an element",
    ]);
    for (body, name) in
        [(Space::Cube, "elastic"), (Space::CubeJoined, "joint on every face"), (Space::Debris, "debris")]
    {
        for &n in &settings.bodies {
            let model = body.model(n);
            let n = model.mesh.elements.len();
            let mut ours = Simulation::new(model.clone(), 0)?;
            let mut theirs = Simulation::new(model, 0)?;
            let bytes = fdem_gpu::memory_of(&mut theirs)? as f64 / n as f64;
            theirs.put_on(Box::new(DeviceSolid::new(Arc::clone(device))))?;
            let count = (STEPS * 100_000 / n as u64).clamp(4, STEPS);
            let mut speeds = [(&mut ours, 0.0_f64), (&mut theirs, 0.0)];
            for round in 0..=ROUNDS {
                for (run, best) in &mut speeds {
                    let start = Instant::now();
                    run.advance(count)?;
                    // The first round starts threads and makes room.
                    if round > 0 {
                        *best = best.max(count as f64 * n as f64 / start.elapsed().as_secs_f64());
                    }
                }
            }
            let [on_host, on_device] = speeds.map(|(_, best)| best);
            if ours.snapshot() != theirs.snapshot() || ours.energies() != theirs.energies() {
                return Err(format!("{name}, {n} elements: the state of the device differs").into());
            }
            let target = match body {
                Space::Cube => target(&ELASTIC, n),
                Space::CubeJoined => "0.8 G".to_owned(),
                _ => "40 M".to_owned(),
            };
            table.row([
                name.to_owned(),
                grouped(n as u64),
                format!("{:.1}", 1e-6 * on_host),
                format!("{:.1}", 1e-6 * on_device),
                target,
                format!("{:.1}", on_device / on_host),
                format!("{bytes:.0}"),
            ]);
        }
    }
    Ok(table)
}
