//! A plane crack that is driven by a constant rate (Khristianovic, Geertsma and de Klerk), along a straight
//! line.
//!
//! Half of a plate, from the source to the right. The crack may grow along y = 0. Its masses are scaled, so
//! that waves are some 20 times as fast as the crack, and not a million times.

use std::f64::consts::PI;

use fdem_simulation::{FluidOptions, Insertion, Model, Plane, Schedule, Simulation};
use rayon::prelude::*;

use super::models::{
    MODULUS, POISSON, YOUNG, injected, line_in_plate, mean, of_toughness, rate, rock_of_scaled_mass, water,
};
use crate::cavity::open;
use crate::models::{advance_to, edges_where, moved, nodes_where, start, text};
use crate::rocks::prepared;
use crate::{Outcome, Size};

/// Rate of injection into both wings, m³/s per m, time of injection, s, and the crack at the beginning, m.
const RATE: f64 = 1e-4;
const TIME: f64 = 10.0;
const NOTCH: f64 = 0.4;

/// Half of the plate, m: ten lengths of the crack.
const HALF: f64 = 43.0;

/// Masses over the real ones.
const SCALE: f64 = 1e5;

/// Bounds of length, opening and pressure without leak-off.
const BOUNDS: Front = [0.03, 0.03, 0.05];

/// Samples in the middle third of the time.
const SAMPLES: u32 = 31;

/// A fluid and a rock.
struct Pair {
    /// Pa √m.
    toughness: f64,
    /// Length of the zone of softening, `K²/f²`, m.
    zone: f64,
    /// Pa s.
    viscosity: f64,
    /// Pressure of empty cells, Pa.
    lowest: f64,
    /// Carter's coefficient of each face, m/√s.
    leak_off: f64,
    /// Place at which the line ends, m.
    near: f64,
}

/// Length, opening at the source and pressure there.
type Front = [f64; 3];

/// `l = (E' Q t/(2 √π K))^(2/3)`, `p = K/√(π l)`, `w0 = 4 p l/E'`: a uniform pressure at which the stress
/// intensity is the toughness, in an ellipse of the volume `2 π p l²/E' = Q t`.
fn of_toughness_alone(toughness: f64, time: f64) -> Front {
    let length = (MODULUS * RATE * time / (2.0 * PI.sqrt() * toughness)).powf(2.0 / 3.0);
    let pressure = toughness / (PI * length).sqrt();
    [length, 4.0 * pressure * length / MODULUS, pressure]
}

/// `l = 0.616 (E' Q³ t⁴/μ')^(1/6)`, `w0² = 2.1 (μ' Q/E')^(1/2) l`, `p0 = 0.62 (μ' Q E')^(1/2)/w0` with
/// `μ' = 12 μ`, without toughness.
fn of_viscosity_alone(viscosity: f64, time: f64) -> Front {
    let mu = 12.0 * viscosity;
    let length = 0.616 * (MODULUS * RATE.powi(3) * time.powi(4) / mu).powf(1.0 / 6.0);
    let opening = (2.1 * (mu * RATE / MODULUS).sqrt() * length).sqrt();
    [length, opening, 0.62 * (mu * RATE * MODULUS).sqrt() / opening]
}

/// A fluid of low viscosity: the dimensionless toughness `K'/(E'³ μ' Q)^(1/4)` is 7.2.
fn low_viscosity(cell: f64) -> Pair {
    Pair { toughness: 1e6, zone: 4.0 * cell, viscosity: 1e-6, lowest: 0.0, leak_off: 0.0, near: 5.2 }
}

pub(crate) fn toughness(size: Size) -> Result<Vec<Outcome>, String> {
    let cell = size.choose(0.05, 0.025);
    let pair = low_viscosity(cell);
    driven(&pair, cell, BOUNDS, &|time| of_toughness_alone(pair.toughness, time))
}

/// The dimensionless toughness `K'/(E'³ μ' Q)^(1/4)` is 0.38.
pub(crate) fn viscosity(size: Size) -> Result<Vec<Outcome>, String> {
    let cell = size.choose(0.05, 0.025);
    let pair =
        Pair { toughness: 3e5, zone: 4.0 * cell, viscosity: 1e-3, lowest: -2e6, leak_off: 0.0, near: 4.2 };
    driven(&pair, cell, BOUNDS, &|time| of_viscosity_alone(pair.viscosity, time))
}

/// With leak-off. In the toughness regime a crack of the half-length `l` holds `2 √π K l^(3/2)/E'`, and both
/// faces of both wings leak. The length of each time follows from the balance of the volume, by bisection.
pub(crate) fn leak_off(size: Size) -> Result<Vec<Outcome>, String> {
    let cell = size.choose(0.08, 0.025);
    let pair = Pair { leak_off: LEAK_OFF, ..low_viscosity(cell) };
    let lengths = lengths_with_leak_off(pair.toughness);
    driven(&pair, cell, [0.03, 0.05, 0.05], &|time| {
        let place = (time / TIME * LEVELS as f64).min(LEVELS as f64);
        let (low, part) = (place.floor() as usize, place.fract());
        let length = lengths[low] + part * (lengths[(low + 1).min(LEVELS)] - lengths[low]);
        let pressure = pair.toughness / (PI * length).sqrt();
        [length, 4.0 * pressure * length / MODULUS, pressure]
    })
}

/// Cracks that choose their path along the edges of unstructured meshes, in the toughness regime. A pressure
/// along the crack, in the ground, keeps it about straight.
pub(crate) fn free(size: Size) -> Result<Vec<Outcome>, String> {
    let cell = size.choose(0.1, 0.06);
    let pair = low_viscosity(cell);
    let fronts = |seed: u32| {
        let run = start(free_plate(&pair, cell, seed)?)?;
        sampled(run, &|time| of_toughness_alone(pair.toughness, time)).map(|(_, ratios)| ratios)
    };
    // All together, so that no thread waits.
    let all = (1..=size.choose(2, 5)).into_par_iter().map(fronts).collect::<Result<Vec<Front>, String>>()?;
    let [length, opening, pressure] =
        [0, 1, 2].map(|k| mean(&all.iter().map(|ratios| ratios[k]).collect::<Vec<_>>()));
    // Of two coarse meshes.
    let bound = size.choose(0.12, 0.08);
    Ok(vec![
        Outcome::relative("length over that of the theory, mean of the meshes", 1.0, length, bound, ""),
        Outcome::relative("opening at the source, so", 1.0, opening, bound, ""),
        Outcome::relative("pressure at the source, so", 1.0, pressure, bound, ""),
    ])
}

fn free_plate(pair: &Pair, cell: f64, seed: u32) -> Result<Model, String> {
    let energy_i = pair.toughness * pair.toughness / MODULUS;
    let tensile = pair.toughness / pair.zone.sqrt();
    let mut model = prepared(&format!(
        r#"
[model]
plane = "strain"
gravity = "none"
end_time = 1
[[body]]
name = "plate"
material = "rock"
rectangle = {{ min = [0, -{HALF}], max = [{HALF}, {HALF}] }}
mesh_size = 4
seed = {seed}
refine = [{{ box = [0, -0.4, {near}, 0.4], size = {cell}, reach = 0.3 }}]
[[material]]
name = "rock"
density = 2700
youngs_modulus = {YOUNG}
poissons_ratio = {POISSON}
damping = 0.1
friction = 0.5
tensile_strength = {tensile}
cohesion = {cohesion}
friction_angle = 30
fracture_energy_i = {energy_i}
fracture_energy_ii = {energy_ii}
[[joint_set]]
name = "notch"
lines = [[0, 0, {NOTCH}, 0]]
friction_angle = 0
open = true
"#,
        near = pair.near,
        cohesion = 10.0 * tensile,
        energy_ii = 20.0 * energy_i,
    ))?;
    let [left, right] =
        [|x: f64| x < 1e-9, |x: f64| x > HALF - 1e-9].map(|at| nodes_where(&model.mesh, |[x, _]| at(x)));
    let sides = [left, right].concat();
    let on_notch = edges_where(&model.mesh, |[x, y]| y.abs() < 1e-9 && x < NOTCH + 1e-9);
    let at = |edge: &[u32; 2]| edge.map(|node| model.mesh.nodes[node as usize][0]).iter().sum::<f64>();
    let source = on_notch.into_iter().min_by(|a, b| at(a).total_cmp(&at(b)));
    let source = source.ok_or("there is no notch")?;
    let fluid = injected(water(pair.viscosity, pair.lowest), 1e-7, vec![source], rate(0.5 * RATE));
    model.materials[0].density *= SCALE;
    model.boundaries = vec![moved("sides", sides, [Some(0.0), None], Schedule::Constant)];
    model.stresses = vec![[[-ALONG, 0.0], [0.0, 0.0]]; model.mesh.elements.len()];
    model.fracture.insertion = Insertion::Adaptive;
    model.fluid = Some(fluid);
    Ok(model)
}

/// Pressure of the ground along a free crack, Pa.
const ALONG: f64 = 2e6;

/// Carter's coefficient of one face, m/√s: some 40 % of the volume has leaked off after 10 s.
const LEAK_OFF: f64 = 1e-5;

/// Number of times at which the length is known.
const LEVELS: usize = 2000;

/// The lengths at the times `k TIME/LEVELS`.
fn lengths_with_leak_off(toughness: f64) -> Vec<f64> {
    let at = |level: usize| TIME * level as f64 / LEVELS as f64;
    let stored = |length: f64| 2.0 * PI.sqrt() * toughness * length.powf(1.5) / MODULUS;
    let mut lengths = vec![0.0];
    for level in 1..=LEVELS {
        // Each piece counts from the middle of the time in which it has become wet.
        let leaked_before: f64 = (1..level)
            .map(|k| {
                let since = at(level) - 0.5 * (at(k) + at(k - 1));
                8.0 * LEAK_OFF * (lengths[k] - lengths[k - 1]) * since.sqrt()
            })
            .sum();
        let leaks = |length: f64| {
            let since = 0.5 * (at(level) - at(level - 1));
            leaked_before + 8.0 * LEAK_OFF * (length - lengths[level - 1]) * since.sqrt()
        };
        let (mut low, mut high) = (lengths[level - 1], lengths[level - 1] + HALF);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if stored(middle) + leaks(middle) < RATE * at(level) { low = middle } else { high = middle }
        }
        lengths.push(low);
    }
    lengths
}

/// `bounds`: of length, opening and pressure.
fn driven(
    pair: &Pair,
    cell: f64,
    bounds: Front,
    theory: &dyn Fn(f64) -> Front,
) -> Result<Vec<Outcome>, String> {
    let (run, [length, opening, pressure]) = sampled(start(plate(pair, cell))?, theory)?;
    let fluid = run.fluid().ok_or("there is no fluid")?;
    let volume = fluid.injection(0).map_err(text)?.injected;
    let balance = fluid.balance();
    Ok(vec![
        Outcome::relative("length over that of the theory", 1.0, length, bounds[0], ""),
        Outcome::relative("opening at the source, so", 1.0, opening, bounds[1], ""),
        Outcome::relative("pressure at the source, so", 1.0, pressure, bounds[2], ""),
        Outcome::relative("volume injected into one wing", 0.5 * RATE * run.time(), volume, 1e-9, "m²"),
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

/// The run at its end, and its values over those of a theory: means over the middle third of the time.
fn sampled(mut run: Simulation, theory: &dyn Fn(f64) -> Front) -> Result<(Simulation, Front), String> {
    let mut ratios: [Vec<f64>; 3] = Default::default();
    for sample in 0..SAMPLES {
        advance_to(&mut run, TIME * (1.0 + f64::from(sample) / f64::from(SAMPLES - 1)) / 3.0)?;
        let (found, expected) = (front(&run)?, theory(run.time()));
        for (k, ratios) in ratios.iter_mut().enumerate() {
            ratios.push(found[k] / expected[k]);
        }
    }
    advance_to(&mut run, TIME)?;
    Ok((run, ratios.map(|ratios| mean(&ratios))))
}

/// The crack's length counts the shares of their fracture energy that joints have dissipated: so a zone of
/// softening counts as the crack without one that has taken as much energy. Of an edge aslant the projection
/// on the line counts.
fn front(run: &Simulation) -> Result<Front, String> {
    let cracks = run.snapshot().cracks;
    let length = cracks.iter().map(|crack| {
        let [a, b] = crack.corners.map(|corner| corner[0]);
        (a - b).abs() * if crack.open_from_start { 1.0 } else { crack.dissipated }
    });
    let first = cracks.iter().find(|crack| crack.corners.iter().any(|corner| corner[0].abs() < 1e-6));
    let source = run.fluid().and_then(|fluid| fluid.injection(0).ok()).ok_or("there is no source")?;
    Ok([length.sum(), first.ok_or("there is no crack")?.opening, source.pressure])
}

/// A coarse crack in the toughness regime, with this share of the rate. A pull on the plate opens its notch
/// without fluid.
pub(super) fn coarse(share: f64) -> Model {
    let mut model = plate(&low_viscosity(0.2), 0.2);
    if let Some(fluid) = &mut model.fluid {
        fluid.sources[0].drive = Some(rate(0.5 * share * RATE));
    }
    let top = nodes_where(&model.mesh, |[_, y]| y > HALF - 1e-9);
    model.boundaries.push(moved("top", top, [None, Some(1e-6)], Schedule::Constant));
    model
}

fn plate(pair: &Pair, cell: f64) -> Model {
    let (mesh, edges) = line_in_plate(cell, 3, pair.near, HALF);
    let notch = edges.partition_point(|edge| mesh.nodes[edge[1] as usize][0] < NOTCH + 1e-9);
    let middle = nodes_where(&mesh, |[x, _]| x < 1e-9);
    let fluid = injected(water(pair.viscosity, pair.lowest), 1e-7, vec![edges[0]], rate(0.5 * RATE));
    let mut model = Model {
        boundaries: vec![moved("symmetry", middle, [Some(0.0), None], Schedule::Constant)],
        mesh,
        materials: vec![rock_of_scaled_mass(SCALE)],
        joint_sets: vec![open(), of_toughness(pair.toughness, pair.toughness / pair.zone.sqrt())],
        plane: Plane::Strain,
        fluid: Some(FluidOptions { leak_off: pair.leak_off, ..fluid }),
        ..Model::default()
    };
    model.fracture.joint_penalty = 10.0;
    model.add_joints(0, &edges[..notch]);
    model.add_joints(1, &edges[notch..]);
    model
}
