//! A round crack that is driven by a constant rate, on a plane.
//!
//! A quarter of a block around the source, on both sides of the plane z = 0. Masses are scaled, as in
//! `kgd.rs`.

use std::f64::consts::PI;

use fdem_simulation::{Crack, Model, Schedule};

use super::models::{MODULUS, injected, mean, of_toughness, rate, rock_of_scaled_mass, water};
use crate::cavity::{graded, mirrored, open};
use crate::models::{moved, nodes_where, text};
use crate::space::bodies::{Point, Run, advance_to, faces_where, lattice, start};
use crate::{Outcome, Size};

/// Rate of injection into the whole crack, m³/s, and time of injection, s.
const RATE: f64 = 0.0265;
const TIME: f64 = 10.0;

/// Masses over the real ones.
const SCALE: f64 = 2e4;

/// Half of the block, m.
const HALF: f64 = 56.0;

/// Samples in the middle third of the time.
const SAMPLES: u32 = 31;

/// A fluid and a rock.
struct PennyCrack {
    /// Pa √m.
    toughness: f64,
    /// Length of the zone of softening, `K²/f²`, m.
    zone: f64,
    /// Pa s.
    viscosity: f64,
    /// Pressure of empty cells, Pa.
    lowest: f64,
    /// Side of the square within which the plane may break, m.
    near: f64,
}

/// Radius, opening at the source, and pressure.
type Round = [f64; 3];

/// Size of the elements on the plane, m.
fn cell_of(size: Size) -> f64 {
    size.choose(1.2, 0.6)
}

/// With `K' = 4 √(2/π) K`: `R = 0.8546 (E'² Q² t²/K'²)^(1/5)`, `w0 = 0.6537 (K'⁴ Q t/E'⁴)^(1/5)`,
/// `p = 0.3004 (K'⁶/(E' Q t))^(1/5)`.
fn of_toughness_alone(toughness: f64, time: f64) -> Round {
    let k = 4.0 * (2.0 / PI).sqrt() * toughness;
    let volume = RATE * time;
    [
        0.8546 * (MODULUS * volume / k).powf(0.4),
        0.6537 * (k.powi(4) * volume / MODULUS.powi(4)).powf(0.2),
        0.3004 * (k.powi(6) / (MODULUS * volume)).powf(0.2),
    ]
}

/// With `μ' = 12 μ`: `R = 0.6955 (E' Q³ t⁴/μ')^(1/9)`, `w0 = 1.1977 (μ'² Q³ t/E'²)^(1/9)`. The pressure at
/// `x = r/R` is `(E'² μ'/t)^(1/3)` times the value of [`profile`]: infinite at the source.
fn of_viscosity_alone(viscosity: f64, time: f64) -> Round {
    let mu = 12.0 * viscosity;
    [
        0.6955 * (MODULUS * RATE.powi(3) * time.powi(4) / mu).powf(1.0 / 9.0),
        1.1977 * (mu * mu * RATE.powi(3) * time / (MODULUS * MODULUS)).powf(1.0 / 9.0),
        (MODULUS * MODULUS * mu / time).cbrt(),
    ]
}

fn profile(x: f64) -> f64 {
    0.3581 * (2.479 - 2.0 / (3.0 * (1.0 - x).cbrt())) - 0.09269 * ((0.5 * x).ln() + 1.0)
}

pub(crate) fn toughness(size: Size) -> Result<Vec<Outcome>, String> {
    let cell = cell_of(size);
    let pair = PennyCrack { toughness: 3e6, zone: 3.0 * cell, viscosity: 1e-6, lowest: 0.0, near: 14.4 };
    driven(&pair, size, &|time| of_toughness_alone(pair.toughness, time), &|_| 1.0)
}

pub(crate) fn viscosity(size: Size) -> Result<Vec<Outcome>, String> {
    let cell = cell_of(size);
    let pair = PennyCrack { toughness: 6e5, zone: 4.0 * cell, viscosity: 1e-3, lowest: -1.1e6, near: 14.4 };
    driven(&pair, size, &|time| of_viscosity_alone(pair.viscosity, time), &profile)
}

fn driven(
    pair: &PennyCrack,
    size: Size,
    theory: &dyn Fn(f64) -> Round,
    profile: &dyn Fn(f64) -> f64,
) -> Result<Vec<Outcome>, String> {
    let mut run = start(block(pair, cell_of(size)))?;
    let mut ratios: [Vec<f64>; 3] = Default::default();
    for sample in 0..SAMPLES {
        advance_to(&mut run, TIME * (1.0 + f64::from(sample) / f64::from(SAMPLES - 1)) / 3.0)?;
        let expected = theory(run.time());
        let found = front(&run, expected[0], profile)?;
        for (k, ratios) in ratios.iter_mut().enumerate() {
            ratios.push(found[k] / expected[k]);
        }
    }
    advance_to(&mut run, TIME)?;
    let fluid = run.fluid().ok_or("there is no fluid")?;
    let volume = fluid.injection(0).map_err(text)?.injected;
    let balance = fluid.balance();
    // A mesh of tetrahedra makes the crack too short by a share of the size of its elements.
    let bounds = size.choose([0.08, 0.06, 0.1], [0.03, 0.03, 0.05]);
    let [radius, opening, pressure] = ratios.map(|ratios| mean(&ratios));
    Ok(vec![
        Outcome::relative("radius over that of the theory", 1.0, radius, bounds[0], ""),
        Outcome::relative("opening at the source, so", 1.0, opening, bounds[1], ""),
        Outcome::relative("mean pressure from 0.3 to 0.7 of the radius, so", 1.0, pressure, bounds[2], ""),
        Outcome::relative("volume injected into the quarter", 0.25 * RATE * run.time(), volume, 1e-9, "m³"),
        Outcome::absolute(
            "error of the mass over that injected",
            0.0,
            balance.error() / balance.injected,
            1e-12,
            "",
        ),
        Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-3, ""),
    ])
}

/// The radius of the circle with the area that the shares of dissipated fracture energy make up. The pressure
/// is the mean from 0.3 to 0.7 of the `radius` of the theory, of each over the value of `profile`.
fn front(run: &Run, radius: f64, profile: &dyn Fn(f64) -> f64) -> Result<Round, String> {
    let cracks = run.snapshot().cracks;
    let area =
        cracks.iter().map(|crack| crack.measure * if crack.open_from_start { 1.0 } else { crack.dissipated });
    let at = |crack: &Crack<3>| {
        let centre: [f64; 2] =
            std::array::from_fn(|axis| crack.corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        centre[0].hypot(centre[1])
    };
    let nearest = cracks.iter().min_by(|a, b| at(a).total_cmp(&at(b))).ok_or("there is no crack")?;
    let network = run.fluid().ok_or("there is no fluid")?;
    let pressures = network.pressures();
    let (mut sum, mut weight) = (0.0, 0.0);
    for (elements, pressure) in run.fluid_joints().iter().zip(pressures) {
        let Some(crack) = cracks.iter().find(|crack| crack.elements == *elements) else { continue };
        let x = at(crack) / radius;
        if 0.3 < x && x < 0.7 {
            sum += crack.measure * pressure / profile(x);
            weight += crack.measure;
        }
    }
    Ok([(4.0 * area.sum::<f64>() / PI).sqrt(), nearest.opening, sum / weight])
}

fn block(pair: &PennyCrack, cell: f64) -> Model<3, 4> {
    let across = graded(pair.near, HALF, (pair.near / cell).round() as usize, 1.35);
    let up = mirrored(&graded(2.0 * cell, HALF, 2, 1.35));
    let mesh = lattice(&[across.clone(), across, up]);
    // Faces of the elements above the plane.
    let plane = faces_where(&mesh, |p: Point| p[2].abs() < 1e-9 && p[0].max(p[1]) < pair.near + 1e-9);
    let rising = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|node| mesh.nodes[node as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0.0
    };
    let plane: Vec<[u32; 3]> = plane.into_iter().filter(rising).collect();
    let notch = 2.5 * cell;
    let is_open = |face: &[u32; 3]| {
        let centre: [f64; 2] = std::array::from_fn(|axis| {
            face.iter().map(|node| mesh.nodes[*node as usize][axis]).sum::<f64>() / 3.0
        });
        centre[0].hypot(centre[1]) < notch
    };
    let (opened, others): (Vec<_>, Vec<_>) = plane.into_iter().partition(is_open);
    let at_axis = |face: &[u32; 3]| {
        face.iter().any(|node| {
            let [x, y, _] = mesh.nodes[*node as usize];
            x.hypot(y) < 1e-9
        })
    };
    let first: Vec<[u32; 3]> = opened.iter().copied().filter(at_axis).collect();
    let on = |axis: usize| nodes_where(&mesh, |p: Point| p[axis].abs() < 1e-9);
    let still = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(0.0));
    let fluid = injected(water(pair.viscosity, pair.lowest), 1e-7, first, rate(0.25 * RATE));
    let mut model = Model {
        boundaries: vec![
            moved("x", on(0), still(0), Schedule::Constant),
            moved("y", on(1), still(1), Schedule::Constant),
        ],
        mesh,
        materials: vec![rock_of_scaled_mass(SCALE)],
        joint_sets: vec![open(), of_toughness(pair.toughness, pair.toughness / pair.zone.sqrt())],
        fluid: Some(fluid),
        ..Model::default()
    };
    model.fracture.joint_penalty = 10.0;
    model.add_joints(0, &opened);
    model.add_joints(1, &others);
    model
}
