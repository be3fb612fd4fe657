//! Bars of tetrahedra: waves, rest under a pressure, two rods that meet.

use fdem_simulation::{ContactOptions, Load, Material, Model, Schedule};

use super::bodies::{
    Body, Point, Run, advance, advance_to, centroid, cuboid, faces_where, force, jittered, loaded,
    mean_motion, on_box, start,
};
use crate::models::{DENSITY, granite, moved, nodes_where, together};
use crate::{Outcome, Size};

/// Waves in a bar in uniaxial strain: `c = √(M/ρ)` with the P-wave modulus
/// `M = E (1 - ν)/((1 + ν)(1 - 2 ν))`. Behind the front the particles have the velocity `v` of the end, so
/// that the momentum `ρ c v` per time and area is the stress (Graff, 2.1.3).
pub(crate) fn waves(size: Size) -> Result<Vec<Outcome>, String> {
    let across = size.choose(2, 4);
    let (width, long, speed) = (0.008, 0.4, 0.1);
    let [e, nu, density] = [60e9, 0.25, 2650.0];
    let modulus = e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
    let c = f64::sqrt(modulus / density);
    let max = [width, width, long];
    let cells = [across, across, 50 * across];
    let by = 0.12 * width / across as f64;
    let mesh = jittered(&cuboid([0.0; 3], max, cells), by, 1, |place| {
        let sides = on_box([0.0; 3], max)(place);
        let station = [0.25, 0.75].iter().any(|share| (place[2] - share * long).abs() < 1e-9);
        [sides[0], sides[1], sides[2] || station]
    });
    let sides = |axis: usize| nodes_where(&mesh, |p: Point| p[axis] < 1e-9 || p[axis] > width - 1e-9);
    let at = |share: f64| nodes_where(&mesh, |p: Point| (p[2] - share * long).abs() < 1e-9);
    let pulse = vec![[0.0, 0.0], [4e-6, 1.0], [16e-6, 1.0], [20e-6, 0.0]];
    let still = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(0.0));
    let stations = [at(0.25), at(0.75)];
    let model = Model {
        boundaries: vec![
            moved("end", at(0.0), [None, None, Some(speed)], Schedule::Table(pulse)),
            moved("sides along x", sides(0), still(0), Schedule::Constant),
            moved("sides along y", sides(1), still(1), Schedule::Constant),
        ],
        mesh,
        materials: vec![Material { youngs_modulus: e, poissons_ratio: nu, density, ..granite() }],
        ..Model::default()
    };
    let mut run = start(model)?;
    let (mut plateau, mut count) = (0.0, 0);
    while run.time() < 15e-6 {
        advance(&mut run, 1)?;
        if run.time() > 7e-6 {
            plateau += force(&run, 0)?[2];
            count += 1;
        }
    }
    // The time at which half of the pulse's displacement has passed a station.
    let passed = 0.5 * speed * 16e-6;
    let first = passes(&mut run, &stations[0], passed)?;
    let second = passes(&mut run, &stations[1], passed)?;
    advance_to(&mut run, first + 25e-6)?;
    let moved = mean_motion(&run, &stations[0])[0][2];
    let expected = density * c * speed * width * width;
    Ok(vec![
        Outcome::relative(
            "speed of the wave in uniaxial strain",
            c,
            0.5 * long / (second - first),
            0.005,
            "m/s",
        ),
        Outcome::relative("force at the end", expected, plateau / f64::from(count), 0.005, "N"),
        Outcome::relative("displacement by the pulse", speed * 16e-6, moved, 0.002, "m"),
        Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-9, ""),
    ])
}

/// Time, s, at which nodes have moved so far along z, interpolated between two steps.
fn passes(run: &mut Run, nodes: &[u32], goal: f64) -> Result<f64, String> {
    let mut before = mean_motion(run, nodes)[0][2];
    if before >= goal {
        return Err("the wave passed before its time".to_owned());
    }
    while run.time() < 2e-4 {
        advance(run, 1)?;
        let after = mean_motion(run, nodes)[0][2];
        if after >= goal {
            return Ok(run.time() - (after - goal) / (after - before) * run.time_step());
        }
        before = after;
    }
    Err("the wave never arrives".to_owned())
}

/// A bar under a pressure on its end, at rest: it shortens by `p L/E` and its support carries `p A`, and its
/// sides move out by `ν p/E`.
pub(crate) fn rest(size: Size) -> Result<Vec<Outcome>, String> {
    let across = size.choose(2, 4);
    let (width, long, pressure) = (0.02, 0.04, 5e6);
    let [e, nu] = [50e9, 0.25];
    let max = [width, width, long];
    let cells = [across, across, 2 * across];
    let mesh =
        jittered(&cuboid([0.0; 3], max, cells), 0.15 * width / across as f64, 2, on_box([0.0; 3], max));
    let at = |axis: usize, place: f64| nodes_where(&mesh, |p: Point| (p[axis] - place).abs() < 1e-9);
    let still = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(0.0));
    let faces = faces_where(&mesh, |p| p[2] > long - 1e-9);
    let (top, side) = (at(2, long), at(0, width));
    let model = Model {
        boundaries: vec![
            moved("bottom", at(2, 0.0), still(2), Schedule::Constant),
            moved("x", at(0, 0.0), still(0), Schedule::Constant),
            moved("y", at(1, 0.0), still(1), Schedule::Constant),
            loaded("top", faces, Load::Pressure(pressure), Schedule::Ramp(2e-4)),
        ],
        mesh,
        materials: vec![Material { youngs_modulus: e, poissons_ratio: nu, damping: 0.3, ..granite() }],
        ..Model::default()
    };
    let mut run = start(model)?;
    advance_to(&mut run, 1.2e-3)?;
    let strain = pressure / e;
    // The pressure acts on the deformed end, wider by 2 ν p/E; both values are right to the square of the
    // strain.
    Ok(vec![
        Outcome::relative("shortening", strain * long, -mean_motion(&run, &top)[0][2], 5e-4, "m"),
        Outcome::relative("growth across", nu * strain * width, mean_motion(&run, &side)[0][0], 5e-4, "m"),
        Outcome::relative("force of the support", pressure * width * width, force(&run, 0)?[2], 5e-4, "N"),
    ])
}

/// Two equal rods that meet: the wave of the impact returns from the free ends after `2 L/c`, and its stress
/// is `ρ c v/2` (Graff, 2.4; ν = 0).
pub(crate) fn meeting(size: Size) -> Result<Vec<Outcome>, String> {
    let across = size.choose(2, 3);
    let (long, meeting) = (0.2, 10.0);
    let width = long / size.choose(30.0, 50.0);
    let c = f64::sqrt(granite().youngs_modulus / DENSITY);
    let cells = [across, across, (long / width) as usize * across];
    let rod = |seed: u64, from: f64| -> Body {
        let (min, max) = ([0.0, 0.0, from], [width, width, from + long]);
        jittered(&cuboid(min, max, cells), 0.12 * width / across as f64, seed, on_box(min, max))
    };
    let (one, other) = (rod(1, 0.0), rod(2, long + 1e-7));
    let velocities = [
        vec![[0.0, 0.0, 0.5 * meeting]; one.nodes.len()],
        vec![[0.0, 0.0, -0.5 * meeting]; other.nodes.len()],
    ];
    let whole: Vec<u32> = (0..one.nodes.len() as u32).collect();
    let inside: Vec<usize> = (0..one.elements.len())
        .filter(|&element| (0.6 * long..0.8 * long).contains(&centroid(&one, element)[2]))
        .collect();
    let model = Model {
        mesh: together(&[one, other]),
        velocities: velocities.concat(),
        materials: vec![granite()],
        contact: ContactOptions { penalty: 10.0, ..ContactOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    while run.counts().contacts == 0 {
        advance(&mut run, 1)?;
        if run.time() > 1e-6 {
            return Err("the rods do not meet".to_owned());
        }
    }
    let (began, transit) = (run.time(), long / c);
    let (mut ended, mut stress) = (began, f64::NAN);
    while run.time() < began + 3.0 * transit {
        advance(&mut run, 1)?;
        if run.counts().contacts > 0 {
            ended = run.time();
        }
        if stress.is_nan() && run.time() >= began + transit {
            let stresses = run.snapshot().stresses;
            stress = inside.iter().map(|&e| stresses[e][2]).sum::<f64>() / inside.len() as f64;
        }
    }
    let parting = mean_motion(&run, &whole)[1][2];
    Ok(vec![
        Outcome::relative("time in contact of two rods", 2.0 * transit, ended - began, 0.02, "s"),
        Outcome::relative("stress in two rods", -0.5 * DENSITY * c * meeting, stress, 0.02, "Pa"),
        Outcome::relative("velocity after the contact", -0.5 * meeting, parting, 0.05, "m/s"),
        Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-3, ""),
    ])
}
