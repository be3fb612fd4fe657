//! Breakdown of a borehole: the largest pressure of a fluid that is pumped into a hole.
//!
//! A round plate with a hole in the ground. The larger stress is along x, so that cracks grow along y = 0,
//! which may break. Stresses of the ground are there from the beginning, and the outer arc
//! stands still.

use std::f64::consts::{FRAC_PI_2, PI};

use fdem_simulation::fluid::{Connection, Drive, Schedule as FluidSchedule};
use fdem_simulation::{MassScaling, Model, Plane, Schedule, TimeOptions};

use super::models::{injected, of_toughness, rock_of_scaled_mass, round_plate, water};
use crate::cavity::graded;
use crate::models::{advance, edges_where, moved, nodes_where, start, text};
use crate::{Outcome, Size};

/// Radius of the hole and of the plate, and size of the elements on the line beside the hole, m.
const HOLE: f64 = 0.1;
const OUTER: f64 = 1.2;

/// Tensile strength, Pa.
const TENSILE: f64 = 5e6;

/// Elements in the zone of softening, `K²/f²`.
const ELEMENTS: f64 = 10.0;

/// Length of the line on each side of the hole, m. On a longer one the pressure would fall.
const LINE: f64 = 0.3 * HOLE;

/// Time until the ground is at rest, and time of pumping at most, s.
const REST: f64 = 1e-3;
const PUMPING: f64 = 4e-3;

/// Time step, s.
const STEP: f64 = 1e-6;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let cell = HOLE * size.choose(0.01, 0.005);
    // Joints that are broken when cracks have run through most of the line.
    let through = (1.6 * LINE / cell) as usize;
    let mut outcomes = Vec::new();
    // The stress along the crack and that across it.
    for [along, across] in [[3.5e6, 3.5e6], [6e6, 4e6]] {
        let expected = 3.0 * across - along + TENSILE;
        let mut model = plate(cell, [along, across], expected);
        // Nothing depends on waves until the crack runs away.
        model.mass_factors = MassScaling::of(&model).map_err(text)?.factors(STEP);
        let mut run = start(model)?;
        let steps = ((REST + 1.5 * PUMPING) / run.time_step()) as u64 / 50;
        let mut most = 0.0;
        for _ in 0..steps {
            advance(&mut run, 50)?;
            let pressure = run.fluid().ok_or("there is no fluid")?.injection(0).map_err(text)?.pressure;
            most = f64::max(most, pressure);
            if run.counts().broken >= through {
                break;
            }
        }
        let name = format!("largest pressure, {} and {} MPa", along / 1e6, across / 1e6);
        outcomes.push(Outcome::relative(name, expected, most, 0.05, "Pa"));
        let broken = f64::from(run.counts().broken >= through);
        outcomes.push(Outcome::absolute("whether cracks have run through the line", 1.0, broken, 0.0, ""));
    }
    Ok(outcomes)
}

fn plate(cell: f64, [along, across]: [f64; 2], expected: f64) -> Model {
    let radii = graded(LINE, OUTER - HOLE, (LINE / cell).round() as usize, 1.15);
    let radii: Vec<f64> = radii.iter().map(|place| HOLE + place).collect();
    // From the right to the top, and the same in the other quarters.
    let quarter = graded(8.0 * cell / HOLE, FRAC_PI_2, 8, 1.15);
    let rest = quarter.len() - 1;
    let mut angles = quarter.clone();
    angles.extend(quarter[..rest].iter().rev().map(|angle| PI - angle));
    angles.extend(quarter[1..].iter().map(|angle| PI + angle));
    angles.extend(quarter[1..rest].iter().rev().map(|angle| 2.0 * PI - angle));
    let (mesh, wall) = round_plate(&radii, &angles);
    let line = edges_where(&mesh, |[x, y]| y == 0.0 && x.abs() < HOLE + LINE + 1e-9);
    let outer = nodes_where(&mesh, |[x, y]| x.hypot(y) > OUTER - 1e-9);
    // The hole grows by less than a tenth of the volume that the fluid shrinks by.
    let rate = 1.2 * PI * HOLE * HOLE * (expected - across) / 2.2e9 / PUMPING;
    let drive = Drive::Rate(FluidSchedule::table(vec![0.0, REST, 1.1 * REST], vec![0.0, 0.0, rate]));
    let mut fluid = injected(water(1e-3, 0.0), 1e-7, wall, drive);
    // One pressure in the hole and in its cracks: they grow too fast here for a fluid that resists.
    fluid.flow.connection = Connection::Cavities;
    fluid.sources[0].initial_pressure = Some(f64::midpoint(along, across));
    let toughness = TENSILE * (ELEMENTS * cell).sqrt();
    let mut model = Model {
        boundaries: vec![moved("ground", outer, [Some(0.0), Some(0.0)], Schedule::Constant)],
        stresses: vec![[[-along, 0.0], [0.0, -across]]; mesh.elements.len()],
        mesh,
        materials: vec![rock_of_scaled_mass(1.0)],
        joint_sets: vec![of_toughness(toughness, TENSILE)],
        plane: Plane::Strain,
        time: TimeOptions { local_damping: 0.3, ..TimeOptions::default() },
        fluid: Some(fluid),
        ..Model::default()
    };
    model.fracture.joint_penalty = 10.0;
    model.add_joints(0, &line);
    model
}
