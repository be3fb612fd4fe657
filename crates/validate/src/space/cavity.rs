//! A pressure in a penny-shaped crack, at rest.

use std::f64::consts::PI;

use fdem_simulation::{Material, Model, Schedule, Simulation, TimeOptions};

use super::bodies::{Point, faces_where, lattice, mapped};
use crate::cavity::{extrapolated, graded, mirrored, open, pressure_at, settled};
use crate::models::{granite, moved, nodes_where};
use crate::{Outcome, Size};

/// Radius of the crack and half of the width of the block, m.
const RADIUS: f64 = 0.1;
const HALF: f64 = 0.6;

/// Pa: that of [`pressure_at`].
const PRESSURE: f64 = 1e6;

const POISSON: f64 = 0.25;

/// A crack of the radius `a` under the pressure `p` opens by `8 (1 - ν²) p √(a² - r²)/(π E)`: its volume is
/// `16 (1 - ν²) p a³/(3 E)`. A quarter of the block.
pub(crate) fn penny(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose(4, 8);
    let modulus = granite().youngs_modulus / (1.0 - POISSON * POISSON);
    let (mut volumes, mut openings) = ([0.0; 2], [0.0; 2]);
    let mut error = 0.0;
    for (place, cells) in [cells, 2 * cells].into_iter().enumerate() {
        let mut run = Simulation::new(block(cells), 0).map_err(|error| error.to_string())?;
        let state = settled(&mut run)?;
        volumes[place] = 4.0 * state.volume;
        let inner = |corner: &Point| corner[0].hypot(corner[1]) < 0.5 * RADIUS * (1.0 + 1e-3);
        let (mut area, mut open) = (0.0, 0.0);
        for crack in run.snapshot().cracks.iter().filter(|crack| crack.corners.iter().all(inner)) {
            area += crack.measure;
            open += crack.measure * crack.opening;
        }
        openings[place] = open / area;
        error = run.energies().error();
    }
    // The mean of √(a² - r²) within half of the radius.
    let mean = 2.0 / 3.0 * (1.0 - 0.75_f64.powf(1.5)) / 0.25;
    Ok(vec![
        Outcome::relative(
            "volume of the open crack",
            16.0 * PRESSURE * RADIUS.powi(3) / (3.0 * modulus),
            extrapolated(volumes),
            0.02,
            "m³",
        ),
        Outcome::relative(
            "mean opening within half of its radius",
            8.0 * PRESSURE * RADIUS / (PI * modulus) * mean,
            extrapolated(openings),
            0.02,
            "m",
        ),
        Outcome::absolute("error of the energy balance", 0.0, error, 1e-3, ""),
    ])
}

/// A quarter of the block. Squares around the crack are made round, and the crack's front is on nodes.
fn block(cells: usize) -> Model<3, 4> {
    let across = graded(RADIUS, HALF, cells, 1.3);
    let up = mirrored(&graded(0.5 * RADIUS, HALF, cells / 2, 1.3));
    let mesh = mapped(&lattice(&[across.clone(), across, up]), |[x, y, z]| {
        let side = x.max(y);
        let round = side / x.hypot(y).max(1e-12);
        let share = ((HALF - side) / (HALF - RADIUS)).min(1.0);
        let factor = 1.0 + share * (round - 1.0);
        if side == 0.0 { [0.0, 0.0, z] } else { [factor * x, factor * y, z] }
    });
    let cracked = |p: Point| p[2].abs() < 1e-9 && p[0].hypot(p[1]) < RADIUS * (1.0 + 1e-6);
    let faces = faces_where(&mesh, cracked);
    let on = |axis: usize| nodes_where(&mesh, |p: Point| p[axis].abs() < 1e-9);
    let still = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(0.0));
    let mut model = Model {
        boundaries: vec![
            pressure_at(faces[0]),
            moved("x", on(0), still(0), Schedule::Constant),
            moved("y", on(1), still(1), Schedule::Constant),
        ],
        mesh,
        materials: vec![Material { poissons_ratio: POISSON, ..granite() }],
        joint_sets: vec![open()],
        time: TimeOptions { dynamic_relaxation: true, ..TimeOptions::default() },
        ..Model::default()
    };
    model.add_joints(0, &faces);
    model
}
