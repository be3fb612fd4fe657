//! A crack in shear under pressure that chooses its path along the edges of an unstructured mesh, and the
//! same crack on a straight line.

use fdem_simulation::{Boundary, Load, Model, Schedule, Simulation, Target};
use rayon::prelude::*;

use super::models::{advance, along_slit, edges_where, rectangle, slit, start};
use super::rocks::prepared;
use super::{Outcome, Size};

/// Width and half of the height of the block, and length of its notch, m. The notch is closed and slides.
const WIDTH: f64 = 0.048;
const HALF: f64 = 0.032;
const NOTCH: f64 = 0.016;
/// Pa.
const MODULUS: f64 = 30e9;
const COHESION: f64 = 7.5e6;
/// Angle of internal friction, degrees.
const FRICTION: f64 = 30.0;
/// Length of the process zone, `E G_II/c²`, m.
const ZONE: f64 = 0.012;
/// Pressure on all sides, Pa, and the time in which it is put on, s.
const PRESSURE: f64 = 10e6;
const RAMP: f64 = 2e-4;
/// Growth of the shear stress, Pa/s.
const RATE: f64 = 2e10;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let seeds: Vec<u32> = size.choose(1..=2, 1..=8).collect();
    let straight = sheared(straight()?)?;
    let mut outcomes = Vec::new();
    for &elements in size.choose(&[6][..], &[6, 12]) {
        let crack = |seed: &u32| sheared(free(elements, *seed)?);
        let cracks = seeds.par_iter().map(crack).collect::<Result<Vec<HalfBroken>, String>>()?;
        let mean = |of: fn(&HalfBroken) -> f64| cracks.iter().map(of).sum::<f64>() / cracks.len() as f64;
        let case = |what: &str| format!("{what}, {elements} elements");
        outcomes.extend([
            Outcome::absolute(
                case("shear stress over that of the straight crack"),
                1.0,
                mean(|crack| crack.stress) / straight.stress,
                0.5,
                "",
            ),
            Outcome::absolute(
                case("work against the joints over that of the straight crack"),
                1.0,
                mean(|crack| crack.work) / straight.work,
                0.8,
                "",
            ),
        ]);
    }
    Ok(outcomes)
}

/// A block whose ligament is broken to one half.
struct HalfBroken {
    /// Shear stress on the sides, Pa.
    stress: f64,
    /// Work done against the joints, with the friction in them, J for a thickness of 1 m.
    work: f64,
}

/// Shears a block until one half of its ligament is broken.
fn sheared(model: Model) -> Result<HalfBroken, String> {
    let mut run: Simulation = start(model)?;
    while run.crack_lengths().iter().sum::<f64>() < 0.5 * (WIDTH - NOTCH) {
        advance(&mut run, 20)?;
        if run.time() > 10.0 * RAMP {
            return Err("the block does not fail".to_owned());
        }
    }
    Ok(HalfBroken { stress: RATE * (run.time() - RAMP), work: run.energies().cohesive })
}

/// The block of an unstructured mesh, whose crack is free.
fn free(elements: u32, seed: u32) -> Result<Model, String> {
    // The pressure closes the mouth of the notch.
    let mouth = 1e-6;
    let mut model = prepared(&format!(
        r#"
[model]
plane = "stress"
gravity = "none"
end_time = 1
[[body]]
name = "block"
material = "rock"
polygon = {{ points = [[0, -{HALF}], [{WIDTH}, -{HALF}], [{WIDTH}, {HALF}], [0, {HALF}], [0, {mouth}], [{NOTCH}, 0], [0, -{mouth}]] }}
mesh_size = {mesh_size}
seed = {seed}
[[material]]
name = "rock"
density = 2700
youngs_modulus = {MODULUS}
poissons_ratio = 0.2
damping = 0.1
friction = 0.2
tensile_strength = {tensile}
cohesion = {COHESION}
friction_angle = {FRICTION}
fracture_energy_i = {opening}
fracture_energy_ii = {sliding}
"#,
        mesh_size = ZONE / f64::from(elements),
        tensile = COHESION / 3.0,
        opening = ZONE * (COHESION / 3.0).powi(2) / MODULUS,
        sliding = ZONE * COHESION.powi(2) / MODULUS,
    ))?;
    load(&mut model);
    Ok(model)
}

/// The block of a structured mesh, with a slit, that can break along the line of the slit only.
fn straight() -> Result<Model, String> {
    let mesh_size = ZONE / 6.0;
    let cells = |length: f64| (length / mesh_size).round() as usize;
    let whole = rectangle([0.0, -HALF], [WIDTH, HALF], [cells(WIDTH), 2 * cells(HALF)]);
    let mut model = along_slit(free(3, 1)?, slit(&whole, NOTCH));
    load(&mut model);
    Ok(model)
}

/// Loads the sides with a pressure, then with a growing shear stress τ and, along the notch, a pressure 2 τ
/// tan φ: then the plane of the notch is the one that Mohr and Coulomb let fail.
fn load(model: &mut Model) {
    let mesh = &model.mesh;
    let along = 2.0 * FRICTION.to_radians().tan();
    let sides: [(&str, [f64; 2], f64); 4] = [
        ("bottom", [0.0, -1.0], HALF),
        ("top", [0.0, 1.0], HALF),
        ("left", [-1.0, 0.0], 0.0),
        ("right", [1.0, 0.0], WIDTH),
    ];
    let boundaries = sides.iter().flat_map(|&(name, [u, v], distance)| {
        let edges = edges_where(mesh, |[x, y]| (u * x + v * y - distance).abs() < 1e-9);
        let traction = |what: &str, traction: [f64; 2], schedule: Schedule| Boundary {
            name: format!("{what}, {name}"),
            target: Target::Facets(edges.clone()),
            load: Load::Traction(traction),
            schedule,
        };
        [
            traction("pressure", [-PRESSURE * u, -PRESSURE * v], Schedule::Ramp(RAMP)),
            traction("shear", [v - along * u, u], Schedule::Table(vec![[RAMP, 0.0], [RAMP + 1.0, RATE]])),
        ]
    });
    model.boundaries = boundaries.collect();
}
