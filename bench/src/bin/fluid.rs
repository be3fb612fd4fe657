//! Steps of the flow in cracks and in pores, with rising numbers of cells and of vertices: seconds for a
//! step, and for each of them.
//!
//! A chain in the plane and a square sheet of triangles in space, both full, into which a pump in the middle
//! begins to inject; a step solves some linear systems. The analysis, after new cells have opened, is timed
//! on its own. Pores are those of a square of triangles and of a cube of tetrahedra, into which a well in the
//! middle injects; the analysis, the factors and a step that has them are timed apart.

#![allow(clippy::print_stdout, reason = "a program for the terminal")]

use std::error::Error;
use std::fmt::Write;
use std::time::Instant;

use fdem_bench::{Table, grouped, machine, significant};
use fdem_fluid::{
    ApertureLaw, Cell, Drive, FlowModel, Fluid, FluidError, Network, PoreBoundary, PoreLiquid, PorousElement,
    PorousMaterial, PorousMatrix, Schedule, Shape, Source,
};

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
    let mut text = format!("# Flow in cracks and in pores\n\n{about}\n\n{}\n", machine(&[1]));
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
    add_pores(&mut text, is_quick)?;
    match arguments.iter().position(|argument| argument == "--write").and_then(|at| arguments.get(at + 1)) {
        Some(file) => std::fs::write(file, text)?,
        None => print!("{text}"),
    }
    Ok(())
}

/// Adds the tables of pores.
fn add_pores(text: &mut String, is_quick: bool) -> Result<(), Box<dyn Error>> {
    let headings = [
        "vertices",
        "elements",
        "entries of the factor",
        "analysis [s]",
        "factors [s]",
        "step [s]",
        "per vertex [ns]",
    ];
    let sizes: &[u32] = if is_quick { &[10] } else { &[31, 99, 316, 999] };
    let mut table = Table::new(&headings);
    for &size in sizes {
        table.row(row_of(&time_square(size)?));
    }
    let about = "A well in the middle injects; the factors serve as long as the length of the step stays.";
    write!(text, "\n## Pores of a square of triangles\n\n{about}\n\n{table}")?;
    let sizes: &[u32] = if is_quick { &[4] } else { &[9, 20, 31, 45] };
    let mut table = Table::new(&headings);
    for &size in sizes {
        table.row(row_of(&time_cube(size)?));
    }
    write!(text, "\n## Pores of a cube of tetrahedra\n\n{table}")?;
    Ok(())
}

/// Times of pores of a size, in seconds.
struct PoreTimes {
    vertices: usize,
    elements: usize,
    /// Entries of the factor.
    fill: usize,
    analysis: f64,
    factors: f64,
    step: f64,
}

fn row_of(times: &PoreTimes) -> [String; 7] {
    [
        grouped(times.vertices as u64),
        grouped(times.elements as u64),
        grouped(times.fill as u64),
        significant(times.analysis),
        significant(times.factors),
        significant(times.step),
        significant(1e9 * times.step / times.vertices as f64),
    ]
}

/// A square of this number of squares along a side, each of two triangles.
fn time_square(side: u32) -> Result<PoreTimes, FluidError> {
    let count = side + 1;
    let places: Vec<[f64; 2]> =
        (0..count * count).map(|k| [k % count, k / count].map(|at| LENGTH * f64::from(at))).collect();
    let squares = (0..side).flat_map(|row| (0..side).map(move |column| row * count + column));
    let elements = squares.flat_map(|a| [[a, a + 1, a + count + 1], [a, a + count + 1, a + count]]);
    time_pores(&places, elements.collect())
}

/// A cube of this number of cubes along a side, each of six tetrahedra.
fn time_cube(side: u32) -> Result<PoreTimes, FluidError> {
    let count = side + 1;
    let steps = [1, count, count * count];
    let places: Vec<[f64; 3]> = (0..count.pow(3))
        .map(|k| [k % count, k / count % count, k / (count * count)].map(|at| LENGTH * f64::from(at)))
        .collect();
    let first =
        |k: u32| [k % side, k / side % side, k / (side * side)].iter().zip(steps).map(|(a, s)| a * s).sum();
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let elements = (0..side.pow(3)).flat_map(|k| {
        let a: u32 = first(k);
        orders.map(|[x, y, z]| [a, a + steps[x], a + steps[x] + steps[y], a + steps[x] + steps[y] + steps[z]])
    });
    time_pores(&places, elements.collect())
}

fn time_pores<const D: usize, const N: usize>(
    places: &[[f64; D]],
    elements: Vec<[u32; N]>,
) -> Result<PoreTimes, FluidError> {
    let elements: Vec<PorousElement<N>> =
        elements.into_iter().map(|vertices| PorousElement { vertices, material: 0 }).collect();
    let material = PorousMaterial::isotropic(1e-15, 0.8, 1e-10);
    let drive = Drive::Rate(Schedule::constant(1e-9));
    let middle = places.len() as u32 / 2;
    let well = PoreBoundary { key: 0, vertices: vec![middle], factors: vec![1.0], drive };
    let mut times = PoreTimes {
        vertices: places.len(),
        elements: elements.len(),
        fill: 0,
        analysis: 0.0,
        factors: 0.0,
        step: f64::INFINITY,
    };
    let begin = Instant::now();
    let mut matrix =
        PorousMatrix::new(&PoreLiquid::WATER, 1.0, places, elements, vec![material], vec![well], &[])?;
    times.analysis = begin.elapsed().as_secs_f64();
    times.fill = matrix.entries()[1];
    let begin = Instant::now();
    matrix.advance(1e-3)?;
    times.factors = begin.elapsed().as_secs_f64();
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        matrix.advance(1e-3)?;
        times.step = times.step.min(begin.elapsed().as_secs_f64());
    }
    Ok(times)
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
