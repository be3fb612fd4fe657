//! Bedded rock: waves along and across the bedding, and the strength in compression over its dip.

use fdem_simulation::{Bedding, Element, Material, MaterialLaw, Mesh, Model, Plane, Schedule, Simulation};

use super::compression::{Rock, SOFT, crush};
use super::models::{granite, moved, nodes_where, rectangle};
use super::space::bodies::cuboid;
use super::{Outcome, Size};

/// A shale: E, E', ν, ν' and G'.
const SHALE: [f64; 5] = [40e9, 18e9, 0.2, 0.15, 7e9];

/// Shale whose bedding has this normal.
fn shale(normal: [f64; 3]) -> Material {
    let [along, across, nu, nu_across, shear_modulus] = SHALE;
    let law = MaterialLaw::TransverselyIsotropic(Bedding {
        normal,
        youngs_modulus: across,
        poissons_ratio: nu_across,
        shear_modulus,
        strength: None,
    });
    Material { youngs_modulus: along, poissons_ratio: nu, law, ..granite() }
}

/// Length of a column, and the places between which a wave is timed, m.
const LONG: f64 = 1.0;
const STATIONS: [f64; 2] = [0.2, 0.7];

/// Speed of a plane wave along x, m/s, whose nodes move along one axis only.
fn speed<const D: usize, const N: usize>(
    mesh: Mesh<D, N>,
    material: Material,
    axis: usize,
    about: f64,
) -> Result<f64, String>
where
    [[f64; D]; N]: Element<D, N>,
{
    let at = |place: f64| nodes_where(&mesh, |point: [f64; D]| (point[0] - place).abs() < 1e-9);
    let (front, stations) = (at(0.0), STATIONS.map(at));
    let inside = nodes_where(&mesh, |point: [f64; D]| point[0] > 1e-9);
    let others = std::array::from_fn(|k| (k != axis).then_some(0.0));
    let pushed = std::array::from_fn(|k| Some(f64::from(u8::from(k == axis))));
    // A ramp over a fifth of the column, which the mesh hardly slows down.
    let ramp = 0.2 * LONG / about;
    let model = Model {
        boundaries: vec![
            moved("front", front, pushed, Schedule::Ramp(ramp)),
            moved("others", inside, others, Schedule::Constant),
        ],
        mesh,
        materials: vec![material],
        plane: Plane::Strain,
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).map_err(|error| error.to_string())?;
    let mut passed = Vec::new();
    let mean = |run: &Simulation<D, N>, nodes: &[u32]| {
        let velocities = nodes.iter().filter_map(|&node| run.node(node)).map(|(_, velocity)| velocity[axis]);
        velocities.sum::<f64>() / nodes.len() as f64
    };
    let mut before = 0.0;
    while passed.len() < 2 {
        run.advance(1).map_err(|error| error.to_string())?;
        let after = mean(&run, &stations[passed.len()]);
        if after >= 0.5 {
            passed.push(run.time() - (after - 0.5) / (after - before) * run.time_step());
            before = 0.0;
        } else {
            before = after;
        }
        if run.time() > 2.0 * LONG / about {
            return Err("the wave never arrives".to_owned());
        }
    }
    Ok((STATIONS[1] - STATIONS[0]) / (passed[1] - passed[0]))
}

/// Speeds of plane waves of pressure and of shear, along the bedding and across it, in the plane and in
/// space.
pub(super) fn waves(size: Size) -> Result<Vec<Outcome>, String> {
    let [e, across, nu, nu_across, shear] = SHALE;
    let density = granite().density;
    // Components of the stiffness: 1 and 2 along the bedding, 3 across it.
    let rest = 1.0 - nu - 2.0 * nu_across * nu_across * e / across;
    let c33 = across * (1.0 - nu) / rest;
    let c11 = e * (1.0 - nu_across * nu_across * e / across) / ((1.0 + nu) * rest);
    let c66 = e / (2.0 * (1.0 + nu));
    let cells = size.choose(100, 200);
    let width = 2.0 * LONG / cells as f64;
    let mut outcomes = Vec::new();
    let of = |modulus: f64| f64::sqrt(modulus / density);
    let flat = || rectangle([0.0; 2], [LONG, width], [cells, 2]);
    for (name, normal, axis, modulus) in [
        ("P along the bedding", [0.0, 1.0, 0.0], 0, c11),
        ("P across the bedding", [1.0, 0.0, 0.0], 0, c33),
        ("S along the bedding", [0.0, 1.0, 0.0], 1, shear),
        ("S across the bedding", [1.0, 0.0, 0.0], 1, shear),
    ] {
        let found = speed(flat(), shale(normal), axis, of(modulus))?;
        outcomes.push(Outcome::relative(format!("{name}, plane strain"), of(modulus), found, 0.005, "m/s"));
    }
    let solid = || cuboid([0.0; 3], [LONG, width, width], [cells, 2, 2]);
    for (name, normal, axis, modulus) in [
        ("P along the bedding", [0.0, 0.0, 1.0], 0, c11),
        ("P across the bedding", [1.0, 0.0, 0.0], 0, c33),
        ("S along the bedding, moving across it", [0.0, 0.0, 1.0], 2, shear),
        ("S along the bedding, moving along it", [0.0, 0.0, 1.0], 1, c66),
        ("S across the bedding", [1.0, 0.0, 0.0], 1, shear),
    ] {
        let found = speed(solid(), shale(normal), axis, of(modulus))?;
        outcomes.push(Outcome::relative(format!("{name}, space"), of(modulus), found, 0.005, "m/s"));
    }
    Ok(outcomes)
}

/// Cohesion of the bedding over that across it; the same for tensile strengths and fracture energies.
const WEAKER: f64 = 0.4;

/// Strength in compression, Pa, of a block whose bedding dips by an angle: that of the plane on which it is
/// least,
///
/// ```text
/// UCS(β) = min over ψ of c(|ψ − β|)/(sin ψ cos ψ − tan φ cos² ψ)
/// ```
/// with the dip ψ of the plane, and a cohesion `c` that grows linearly with its angle to the bedding.
/// Jaeger's plane of weakness is the case of a `c` that jumps: there the shoulders are level.
fn least_strength(rock: &Rock, dip: f64) -> f64 {
    let planes = (-899..900).map(|k| 0.1 * f64::from(k));
    let strength = |plane: f64| {
        let angle = (plane - dip).abs();
        let share = angle.min(180.0 - angle) / 90.0;
        let cohesion = rock.cohesion * (WEAKER + share * (1.0 - WEAKER));
        let (sin, cos) = plane.abs().to_radians().sin_cos();
        let driven = sin * cos - rock.friction * cos * cos;
        if driven > 0.0 { cohesion / driven } else { f64::INFINITY }
    };
    planes.map(strength).fold(f64::INFINITY, f64::min)
}

/// Compression of blocks whose bedding dips by 0 to 90 degrees.
pub(super) fn compression(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh_size = size.choose(3e-3, 2e-3);
    let seeds = size.choose(1..=1, 1..=4);
    let step = size.choose(30, 15);
    let [opening, sliding] = SOFT.energies.map(|energy| WEAKER * energy);
    let shear = SOFT.youngs_modulus / (2.0 * (1.0 + SOFT.poissons_ratio));
    let (mut outcomes, mut found, mut balance) = (Vec::new(), Vec::new(), 0.0_f64);
    for dip in (0..=90).step_by(step) {
        let mut sum = 0.0;
        for seed in seeds.clone() {
            let bedding = format!(
                "anisotropy = {{ youngs_modulus = {}, poissons_ratio = {}, shear_modulus = {}, dip = {dip}, \
                 tensile_strength = {}, cohesion = {}, fracture_energy_i = {opening}, fracture_energy_ii = {sliding} }}",
                0.5 * SOFT.youngs_modulus,
                0.6 * SOFT.poissons_ratio,
                0.6 * shear,
                WEAKER * SOFT.tensile_strength,
                WEAKER * SOFT.cohesion,
            );
            let crushed = crush(&SOFT, &bedding, mesh_size, seed, 0.0)?;
            sum += crushed.strength;
            balance = balance.max(crushed.balance.abs());
        }
        let mean = sum / seeds.clone().count() as f64;
        let expected = least_strength(&SOFT, f64::from(dip));
        let name = format!("strength with bedding at {dip}°");
        outcomes.push(Outcome::relative(name, expected, mean, 0.15, "Pa"));
        found.push(mean);
    }
    let least = found.iter().copied().fold(f64::INFINITY, f64::min);
    let shoulder = found[0].min(found[found.len() - 1]);
    // The place of the least strength is between the shoulders.
    let place = found.iter().position(|strength| *strength == least).unwrap_or(0) * step;
    outcomes.push(Outcome::absolute("dip of the least strength", 60.0, place as f64, 15.0, "°"));
    let expected =
        [0.0, 90.0].map(|dip| least_strength(&SOFT, dip)).into_iter().fold(f64::INFINITY, f64::min)
            / least_strength(&SOFT, 60.0);
    outcomes.push(Outcome::relative(
        "lower shoulder over the least strength",
        expected,
        shoulder / least,
        0.15,
        "",
    ));
    outcomes.push(Outcome::absolute("error of the energy balance", 0.0, balance, 1e-2, ""));
    Ok(outcomes)
}
