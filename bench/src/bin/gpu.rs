//! Compares and times searches for contacts on a graphics processor and on all processors of the machine.
//!
//! It fails without a graphics processor, and if a couple differs.

use std::error::Error;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use fdem_bench::{Rounds, Table, Task, grouped, machine, times};
use fdem_contact::{Elements, Rows, Search};
use fdem_gpu::{Cuda, DeviceRows};

const USAGE: &str = "\
usage: gpu [--device N] [--elements N,M] [--write FILE]

  --device N       0 if not given
  --elements N,M   1000000,10000000 if not given
  --write FILE     also writes the report there
";

/// Times taken of each search.
const ROUNDS: usize = 8;

struct Settings {
    device: usize,
    elements: Vec<usize>,
    write: Option<PathBuf>,
}

impl Settings {
    fn from_arguments(mut arguments: impl Iterator<Item = String>) -> Option<Self> {
        let mut settings = Self { device: 0, elements: vec![1_000_000, 10_000_000], write: None };
        while let Some(argument) = arguments.next() {
            let value = arguments.next()?;
            match argument.as_str() {
                "--device" => settings.device = value.parse().ok()?,
                "--elements" => {
                    settings.elements = value.split(',').map(|n| n.parse().ok()).collect::<Option<_>>()?;
                }
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
    let device = Cuda::new(settings.device)?;
    let info = device.info();
    let mut table = Table::new(&[
        "spheres",
        "couples",
        "processors: list, ms",
        "device: list, ms",
        "device: count, ms",
        "ratio of lists",
    ]);
    for &n in &settings.elements {
        let gas = fdem_scenes::peers::gas(n, 1)?;
        let elements = Elements::spheres_with_radii(&gas.centres, &gas.radii)?;
        let mut rows = Rows::new().with_threads(0)?;
        let mut on_device = DeviceRows::new(&device);
        let (mut ours, mut found) = (Vec::new(), Vec::new());
        rows.couples(&elements, &mut ours)?;
        on_device.couples(&elements, &mut found)?;
        if found != ours {
            return Err(format!("{n} spheres: the couples of the device differ").into());
        }
        let mut counting = DeviceRows::new(&device);
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
            format!("{:.1}", on_host.median / list.median),
        ]);
    }
    let text = format!(
        "# Graphics processors\n\n{}\n\nDevice: {}, {} GiB. Gas of spheres of one radius. The couples of the device \
         are those of the processors, in their order. Medians of {ROUNDS} rounds by turns, with the copies of spheres \
         and couples.\n\n{table}",
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
