//! Steps of the flow in cracks, with rising numbers of cells: seconds for a step, and for each cell.
//!
//! A chain in the plane and a square sheet of triangles in space, both full, into which a pump in the middle
//! begins to inject; a step solves some linear systems. The analysis, after new cells have opened, is timed
//! on its own.

#![allow(clippy::print_stdout, reason = "a program for the terminal")]

use std::error::Error;
use std::fmt::Write;
use std::time::Instant;

use fdem_bench::{Table, grouped, machine, significant};
use fdem_fluid::{ApertureLaw, Cell, Drive, FlowModel, Fluid, FluidError, Network, Schedule, Shape, Source};

/// Rounds of each size; the fastest counts.
const ROUNDS: usize = 5;

/// Length of a cell, m.
const LENGTH: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_quick = arguments.iter().any(|argument| argument == "--quick");
    let sizes: &[u32] = if is_quick { &[100] } else { &[1_000, 10_000, 100_000, 1_000_000] };
    let headings = ["cells", "links", "systems", "step [s]", "per cell and system [ns]", "analysis [s]"];
    let about = "Seconds of the first step of a pump in the middle of cells that are full, the fastest of five rounds.";
    let mut text = format!("# Flow in cracks\n\n{about}\n\n{}\n", machine(&[1]));
    for (title, time) in [
        ("A chain in the plane", time_chain as fn(u32) -> Result<Times, FluidError>),
        ("A sheet in space", time_sheet),
    ] {
        let mut table = Table::new(&headings);
        for &size in sizes {
            let times = time(size)?;
            let per_cell = times.step / (times.cells as f64 * f64::from(times.systems.max(1)));
            table.row([
                grouped(times.cells as u64),
                grouped(times.links as u64),
                times.systems.to_string(),
                significant(times.step),
                significant(1e9 * per_cell),
                significant(times.analysis),
            ]);
        }
        write!(text, "\n## {title}\n\n{table}")?;
    }
    match arguments.iter().position(|argument| argument == "--write").and_then(|at| arguments.get(at + 1)) {
        Some(file) => std::fs::write(file, text)?,
        None => print!("{text}"),
    }
    Ok(())
}

/// Times of a size, in seconds.
struct Times {
    cells: usize,
    links: usize,
    /// Linear systems of a step.
    systems: u32,
    step: f64,
    analysis: f64,
}

fn time_chain(count: u32) -> Result<Times, FluidError> {
    let place = |k: u32| [LENGTH * f64::from(k), 0.0];
    let cells: Vec<[u32; 2]> = (0..count).map(|k| [k, k + 1]).collect();
    time(&cells, place)
}

fn time_sheet(count: u32) -> Result<Times, FluidError> {
    let side = (0.5 * f64::from(count)).sqrt() as u32;
    let place = |k: u32| {
        let [row, column] = [k / (side + 1), k % (side + 1)].map(f64::from);
        [LENGTH * (column + 0.5 * row), LENGTH * 0.75_f64.sqrt() * row, 0.0]
    };
    let vertex = |row: u32, column: u32| row * (side + 1) + column;
    let squares = (0..side).flat_map(|row| (0..side).map(move |column| (row, column)));
    let cells = squares.flat_map(|(row, column)| {
        let [a, b] = [vertex(row, column), vertex(row, column + 1)];
        let [c, d] = [vertex(row + 1, column), vertex(row + 1, column + 1)];
        [[a, b, c], [b, d, c]]
    });
    time(&cells.collect::<Vec<_>>(), place)
}

fn time<const D: usize>(corners: &[[u32; D]], place: impl Fn(u32) -> [f64; D]) -> Result<Times, FluidError> {
    let law = ApertureLaw::default();
    let cells: Vec<Cell<D>> = (0_u64..)
        .zip(corners)
        .map(|(key, corners)| Cell {
            key,
            corners: *corners,
            law,
            leak_off: 0.0,
            initial_pressure: Some(1e5),
        })
        .collect();
    let shapes: Vec<Shape<D>> = corners
        .iter()
        .map(|corners| Shape {
            corners: corners.map(&place),
            opening: 1e-4,
            compression: 0.0,
            compliance: 0.0,
            is_wet: true,
        })
        .collect();
    let drive = Some(Drive::Rate(Schedule::constant(1e-6)));
    let middle = vec![cells.len() as u64 / 2];
    let pump = Source { key: 0, cells: middle, volume: 0.0, drive, initial_pressure: None };
    let start = Network::new(FlowModel::new(Fluid::WATER), vec![pump], &cells, &shapes)?;
    let mut times =
        Times { cells: cells.len(), links: 0, systems: 0, step: f64::INFINITY, analysis: f64::INFINITY };
    for _ in 0..ROUNDS {
        let mut network = start.clone();
        let begin = Instant::now();
        network.renew(&cells, &shapes)?;
        times.analysis = times.analysis.min(begin.elapsed().as_secs_f64());
        let begin = Instant::now();
        network.update(&shapes)?;
        times.systems = network.advance(1e-3)?.solutions;
        times.step = times.step.min(begin.elapsed().as_secs_f64());
        times.links = network.flows().len();
    }
    Ok(times)
}
