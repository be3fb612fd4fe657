//! Flow between rigid walls: the network alone.

use std::f64::consts::PI;

use fdem_simulation::fluid::{
    ApertureLaw, Cell, Drive, FlowModel, Fluid, Network, Schedule, Shape, Source, StateEquation,
};

use crate::models::text;
use crate::{Outcome, Size};

/// Pa s.
const VISCOSITY: f64 = 1e-3;

/// Cells between rigid walls.
struct Cells<const D: usize> {
    cells: Vec<Cell<D>>,
    shapes: Vec<Shape<D>>,
}

impl<const D: usize> Cells<D> {
    fn new() -> Self {
        Self { cells: Vec::new(), shapes: Vec::new() }
    }

    /// Adds a cell between these numbers of corners, at these places, with this opening, m.
    fn add(&mut self, corners: [u32; D], places: [[f64; D]; D], opening: f64) {
        let law = ApertureLaw { residual: 1e-9, ..ApertureLaw::default() };
        let key = self.cells.len() as u64;
        self.cells.push(Cell { key, corners, law, leak_off: 0.0, initial_pressure: None });
        self.shapes.push(Shape { corners: places, opening, compression: 0.0, compliance: 0.0, is_wet: true });
    }

    fn network(&self, bulk_modulus: f64, sources: Vec<Source>) -> Result<Network<D>, String> {
        let (density, reference_pressure, cavitation_pressure) = (1000.0, 0.0, 0.0);
        let state = StateEquation::Liquid { density, reference_pressure, bulk_modulus, cavitation_pressure };
        let fluid = Fluid { viscosity: VISCOSITY, state };
        Network::new(FlowModel::new(fluid), sources, &self.cells, &self.shapes).map_err(text)
    }
}

/// A straight chain of cells with these openings.
fn chain(length: f64, openings: &[f64]) -> Cells<2> {
    let mut all = Cells::new();
    for (k, opening) in (0..).zip(openings) {
        all.add([k, k + 1], [k, k + 1].map(|k| [length * f64::from(k), 0.0]), *opening);
    }
    all
}

/// A source at some cells.
fn source(key: u64, cells: Vec<u64>, drive: Drive) -> Source {
    Source { key, cells, volume: 0.0, drive: Some(drive), initial_pressure: None }
}

fn held(key: u64, cell: u64, pressure: f64) -> Source {
    source(key, vec![cell], Drive::Pressure(Schedule::constant(pressure)))
}

/// A bulk modulus at which densities are the same to rounding, Pa, and a step after which flow is steady, s.
const STIFF: f64 = 1e22;
const LONG: f64 = 1e9;

/// `Q = a³ b Δp/(12 μ L)`; cells in series: their resistances `12 μ L/a³` add up; cells that cross: their
/// corner has the mean of the pressures by conductances.
pub(crate) fn steady(_: Size) -> Result<Vec<Outcome>, String> {
    let (length, wide, narrow) = (0.02, 2e-4, 5e-5);
    let resistance = |length: f64, opening: f64| 12.0 * VISCOSITY * length / opening.powi(3);
    let mut even = chain(length, &[wide; 21]).network(STIFF, vec![held(1, 0, 3e6), held(2, 20, 1e6)])?;
    even.advance(LONG).map_err(text)?;
    let flow = even.injection(1).map_err(text)?.rate;
    let expected = 2e6 / resistance(20.0 * length, wide);
    let mut outcomes = vec![Outcome::relative("flow through a chain", expected, flow, 1e-10, "m²/s")];
    let errors = (0..).zip(even.pressures()).map(|(k, found)| found / (3e6 - 1e5 * f64::from(k)) - 1.0);
    let worst = errors.fold(0.0, |most: f64, error| most.max(error.abs()));
    outcomes.push(Outcome::absolute("largest error of its pressures", 0.0, worst, 1e-10, ""));

    let openings: Vec<f64> = (0..10).map(|k| if k < 5 { wide } else { narrow }).collect();
    let mut series = chain(length, &openings).network(STIFF, vec![held(1, 0, 2e6), held(2, 9, 0.0)])?;
    series.advance(LONG).map_err(text)?;
    let expected = 2e6 / (resistance(4.5 * length, wide) + resistance(4.5 * length, narrow));
    let flow = series.injection(1).map_err(text)?.rate;
    outcomes.push(Outcome::relative("flow through two apertures", expected, flow, 1e-10, "m²/s"));

    let ends = [[1.0, 0.0], [0.0, 0.5], [-0.7, 0.0], [0.0, -0.9]];
    let openings = [1e-4, 2e-4, 1.5e-4, 3e-4];
    let pressures = [4e6, 1e6, 2e6, 5e5];
    let mut crossing = Cells::new();
    for k in 0..4_u32 {
        crossing.add([100, k], [[0.0; 2], ends[k as usize]], openings[k as usize]);
        crossing.cells[k as usize].initial_pressure = Some(1e6);
    }
    let sources = (0..4).map(|k| held(k, k, pressures[k as usize])).collect();
    let mut crossing = crossing.network(STIFF, sources)?;
    crossing.advance(LONG).map_err(text)?;
    let conductance = |k: usize| 1.0 / resistance(0.5 * f64::hypot(ends[k][0], ends[k][1]), openings[k]);
    let sum = |value: &dyn Fn(usize) -> f64| (0..4).map(value).sum::<f64>();
    let corner = sum(&|k| conductance(k) * pressures[k]) / sum(&conductance);
    let mut total = 0.0;
    for (k, pressure) in pressures.iter().enumerate() {
        let flow = crossing.injection(k as u64).map_err(text)?.rate;
        let expected = conductance(k) * (pressure - corner);
        total += flow;
        let name = format!("flow into branch {} of a crossing", k + 1);
        outcomes.push(Outcome::relative(name, expected, flow, 1e-10, "m²/s"));
    }
    outcomes.push(Outcome::absolute("sum of these flows", 0.0, total, 1e-10 * conductance(3) * 4e6, "m²/s"));
    Ok(outcomes)
}

/// The complementary error function, by its integral with Simpson's rule.
fn erfc(x: f64) -> f64 {
    let steps = 2000;
    let h = x / f64::from(steps);
    let weight = |k: u32| if k == 0 || k == steps { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
    let sum: f64 = (0..=steps).map(|k| weight(k) * (-(h * f64::from(k)).powi(2)).exp()).sum();
    1.0 - 2.0 / PI.sqrt() * sum * h / 3.0
}

/// Largest error of the pressure after a step of it at one end, over that step: `p = p0 erfc(x/(2 √(D t)))`
/// with `D = K a²/(12 μ)`, at a depth `√(D t)` of 0.2 m, in cells of 1/`cells` of a length of 1 m.
fn error_of_transient(cells: u32, steps: u32) -> Result<f64, String> {
    let (opening, modulus, pressure) = (1e-5, 2.2e9, 1e3);
    let diffusivity = modulus * opening * opening / (12.0 * VISCOSITY);
    let time = 0.2 * 0.2 / diffusivity;
    let h = 1.0 / f64::from(cells);
    let mut all = chain(h, &vec![opening; (cells * 16 / 10) as usize]);
    all.cells.iter_mut().for_each(|cell| cell.initial_pressure = Some(0.0));
    let mut network = all.network(modulus, vec![held(1, 0, pressure)])?;
    for _ in 0..steps {
        network.advance(time / f64::from(steps)).map_err(text)?;
    }
    let error = |(k, found): (usize, f64)| {
        (found / pressure - erfc(h * k as f64 / (2.0 * (diffusivity * time).sqrt()))).abs()
    };
    Ok(network.pressures().into_iter().enumerate().map(error).fold(0.0, f64::max))
}

/// A step of the pressure, a front at a constant rate, and flow from a point.
pub(crate) fn transient(size: Size) -> Result<Vec<Outcome>, String> {
    let steps = size.choose(200, 800);
    let mut outcomes = vec![Outcome::absolute(
        "p0 erfc(x/√(4 D t)), 100 cells",
        0.0,
        error_of_transient(100, steps)?,
        0.01,
        "",
    )];
    let [coarse, fine] = [50, 100].map(|steps| error_of_transient(200, steps));
    outcomes.push(Outcome::absolute(
        "order of its error in the step",
        1.0,
        (coarse? / fine?).log2(),
        0.2,
        "",
    ));
    let [coarse, fine] = [(20, 40), (40, 160)].map(|(cells, steps)| error_of_transient(cells, steps));
    outcomes.push(Outcome::absolute(
        "order of its error in the cell",
        2.0,
        (coarse? / fine?).log2(),
        0.3,
        "",
    ));

    let (opening, flow, length, time) = (1e-4, 1e-5, 0.01, 5.0);
    let rate = source(1, vec![0], Drive::Rate(Schedule::constant(flow)));
    let mut network = chain(length, &[opening; 100]).network(2e9, vec![rate])?;
    for _ in 0..50 {
        network.advance(time / 50.0).map_err(text)?;
    }
    let front = length * network.saturations().iter().sum::<f64>();
    outcomes.push(Outcome::absolute(
        "front Q t/a of a filling crack",
        flow * time / opening,
        front,
        length,
        "m",
    ));
    outcomes.push(radial()?);
    Ok(outcomes)
}

/// `p(r) - p(R) = 6 μ Q ln(R/r)/(π a³)`, in triangles between circles.
fn radial() -> Result<Outcome, String> {
    let (around, rings, opening, rate) = (48_u32, 24_u32, 1e-4, 1e-6);
    let angle = 2.0 * PI / f64::from(around);
    let place = |number: u32| {
        let [ring, k] = [number / around, number % around].map(f64::from);
        let (radius, at) = (0.01 * (1.0 + 0.866 * angle).powf(ring), angle * (k + 0.5 * ring));
        [radius * at.cos(), radius * at.sin(), 0.0]
    };
    let mut all = Cells::new();
    for (ring, k) in (0..rings).flat_map(|ring| (0..around).map(move |k| (ring, k))) {
        let vertex = |ring: u32, k: u32| ring * around + k % around;
        let [a, b] = [vertex(ring, k), vertex(ring, k + 1)];
        let [above, before] = [vertex(ring + 1, k), vertex(ring + 1, k + around - 1)];
        for corners in [[a, b, above], [a, above, before]] {
            all.add(corners, corners.map(place), opening);
        }
    }
    let per_ring = u64::from(2 * around);
    let outer = u64::from(rings - 1) * per_ring;
    let inflow = source(1, (0..per_ring).collect(), Drive::Rate(Schedule::constant(rate)));
    let outflow = source(2, (outer..outer + per_ring).collect(), Drive::Pressure(Schedule::constant(1e5)));
    let mut network = all.network(STIFF, vec![inflow, outflow])?;
    network.advance(LONG).map_err(text)?;
    let pressures = network.pressures();
    // Means over a ring: of the pressure, and of the logarithm of the radius.
    let means = |ring: u64| {
        let cells = ring * per_ring..(ring + 1) * per_ring;
        let logarithm = |k: u64| {
            let corners = all.shapes[k as usize].corners;
            let [x, y] = [0, 1].map(|axis| corners.iter().map(|at| at[axis]).sum::<f64>() / 3.0);
            x.hypot(y).ln()
        };
        [
            cells.clone().map(|k| pressures[k as usize]).sum::<f64>() / per_ring as f64,
            cells.map(logarithm).sum::<f64>() / per_ring as f64,
        ]
    };
    let [[near, r], [far, outer_r]] = [4, 19].map(means);
    let expected = 6.0 * VISCOSITY * rate * (outer_r - r) / (PI * opening.powi(3));
    Ok(Outcome::relative("fall of the pressure of a radial flow", expected, near - far, 0.02, "Pa"))
}

/// `4 A C √(t - t_c)` of each cell, through both of its faces.
pub(crate) fn leak_off(_: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    for steps in [1, 7, 200] {
        let mut all = chain(0.1, &[1e-4; 6]);
        let coefficient = |k: usize| 1e-6 * (1.0 + k as f64);
        for (k, cell) in all.cells.iter_mut().enumerate() {
            (cell.leak_off, cell.initial_pressure) = (coefficient(k), Some(1e6));
        }
        let mut network = all.network(2e9, vec![held(1, 0, 1e6)])?;
        for _ in 0..steps {
            network.advance(100.0 / f64::from(steps)).map_err(text)?;
        }
        let expected: f64 = (0..6).map(|k| 4.0 * 0.1 * coefficient(k) * 10.0).sum();
        let balance = network.balance();
        let name = format!("volume that has leaked in {steps} steps");
        outcomes.push(Outcome::relative(name, expected, balance.leaked / 1000.0, 1e-10, "m²"));
        let error = balance.error() / (balance.initial + balance.injected);
        outcomes.push(Outcome::absolute("error of the mass, over all that came in", 0.0, error, 1e-12, ""));
    }
    Ok(outcomes)
}
