//! The pressure of a fluid on the walls of a crack and of a hole, at rest.

use std::f64::consts::{FRAC_PI_2, PI};

use fdem_simulation::fluid::{Drive, Schedule as FluidSchedule};
use fdem_simulation::{Boundary, Load, Model, Plane, Schedule, Simulation, Target, TimeOptions};

use super::models::{
    MODULUS, POISSON, YOUNG, injected, line_in_plate, rock_of_scaled_mass, round_plate, water,
};
use crate::cavity::{extrapolated, open};
use crate::models::{advance, moved, nodes_where, start, text};
use crate::{Outcome, Size};

/// Pa.
const PRESSURE: f64 = 1e6;

/// Half of the length of the crack, and half of the plate, m.
const LENGTH: f64 = 0.1;
const HALF: f64 = 2.0;

fn pressure(value: f64) -> Drive {
    Drive::Pressure(FluidSchedule::constant(value))
}

/// Runs until forces are in equilibrium.
fn settle(run: &mut Simulation) -> Result<(), String> {
    for _ in 0..400 {
        advance(run, 200)?;
        if run.imbalance() < 1e-4 {
            return Ok(());
        }
    }
    Err(format!("it does not come to rest: imbalance {}", run.imbalance()))
}

/// A crack of the length `2 l` under the pressure `p` opens by `4 p √(l² - x²)/E'`: an area of `2 π p l²/E'`.
/// A mesh of triangles makes a crack too short by a share of the size of its elements.
pub(crate) fn line(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose(8, 16);
    let mut volumes = [0.0; 2];
    let mut outcomes = Vec::new();
    for (place, cells) in [cells, 2 * cells].into_iter().enumerate() {
        let (mesh, edges) = line_in_plate(LENGTH / cells as f64, cells / 2, LENGTH, HALF);
        let first = edges.iter().copied().filter(|edge| mesh.nodes[edge[0] as usize][0] < 1e-9).collect();
        let fluid = injected(water(1e-12, 0.0), 1e-7, first, pressure(PRESSURE));
        let middle = nodes_where(&mesh, |[x, _]| x < 1e-9);
        let mut model = Model {
            boundaries: vec![moved("symmetry", middle, [Some(0.0), None], Schedule::Constant)],
            mesh,
            materials: vec![rock_of_scaled_mass(1.0)],
            joint_sets: vec![open()],
            plane: Plane::Strain,
            time: TimeOptions { dynamic_relaxation: true, ..TimeOptions::default() },
            fluid: Some(fluid),
            ..Model::default()
        };
        model.add_joints(0, &edges);
        let mut run = start(model)?;
        settle(&mut run)?;
        let area: f64 = run.snapshot().cracks.iter().map(|crack| crack.measure * crack.opening).sum();
        volumes[place] = 2.0 * area;
        if place == 1 {
            outcomes.extend([
                Outcome::relative(
                    "work of the pressure",
                    PRESSURE * area,
                    run.energies().external,
                    0.01,
                    "J",
                ),
                Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-3, ""),
            ]);
        }
    }
    let expected = 2.0 * PI * PRESSURE * LENGTH * LENGTH / MODULUS;
    outcomes
        .insert(0, Outcome::relative("area of the open crack", expected, extrapolated(volumes), 0.02, "m²"));
    Ok(outcomes)
}

/// Radius of a hole and of the plate around it, m.
const HOLE: f64 = 0.1;
const OUTER: f64 = 2.0;

/// A round plate with a hole, in plane strain: under the pressure `p` in the hole and `q` on the
/// outside, the hole grows by `a (1 + ν)/E` times `((1 - 2 ν) (p a² - q b²) + (p - q) b²)/(b² - a²)` (Lamé).
/// With `p = q`, as in ground whose stress is the pressure, it has the size that it has in a whole plate.
pub(crate) fn hole(size: Size) -> Result<Vec<Outcome>, String> {
    let around = size.choose(24, 48);
    let mut outcomes = Vec::new();
    for [inside, outside] in [[PRESSURE, 0.0], [PRESSURE, PRESSURE]] {
        let (model, nodes) = plate(around, inside, outside);
        let mut run = start(model)?;
        settle(&mut run)?;
        let growth = nodes.iter().filter_map(|&node| {
            let place = run.model().mesh.nodes[node as usize];
            run.node(node).map(|(moved, _)| (moved[0] * place[0] + moved[1] * place[1]) / HOLE)
        });
        let growth = growth.sum::<f64>() / nodes.len() as f64;
        let [a, b] = [HOLE * HOLE, OUTER * OUTER];
        let expected = HOLE * (1.0 + POISSON) / YOUNG
            * ((1.0 - 2.0 * POISSON) * (inside * a - outside * b) + (inside - outside) * b)
            / (b - a);
        let name =
            if outside == 0.0 { "growth of the hole" } else { "growth under the pressure of the ground" };
        outcomes.push(Outcome::relative(name, expected, growth, 0.01, "m"));
        if outside == 0.0 {
            outcomes.push(Outcome::absolute(
                "whether pressure makes it larger",
                1.0,
                f64::from(growth > 0.0),
                0.0,
                "",
            ));
        }
        let fluid = run.fluid().ok_or("there is no fluid")?;
        let found = fluid.injection(0).map_err(text)?.pressure;
        outcomes.push(Outcome::relative("pressure in the hole", inside, found, 1e-12, "Pa"));
    }
    Ok(outcomes)
}

/// The plate with this number of elements around a quarter of the hole, and the nodes of the hole.
fn plate(around: usize, inside: f64, outside: f64) -> (Model, Vec<u32>) {
    let angle = FRAC_PI_2 / around as f64;
    let rows = ((OUTER / HOLE).ln() / angle).round() as usize;
    let ratio = (OUTER / HOLE).powf(1.0 / rows as f64);
    let radii: Vec<f64> = (0..=rows).map(|row| HOLE * ratio.powf(row as f64)).collect();
    let angles: Vec<f64> = (0..4 * around).map(|k| angle * k as f64).collect();
    let (mesh, wall) = round_plate(&radii, &angles);
    let hole = wall.iter().map(|edge| edge[1]).collect();
    let last = |[a, b]: [u32; 2]| [b + rows as u32, a + rows as u32];
    let ground = Boundary {
        name: "ground".to_owned(),
        target: Target::Facets(wall.iter().copied().map(last).collect()),
        load: Load::Pressure(outside),
        schedule: Schedule::Constant,
    };
    let on = |axis: usize| nodes_where(&mesh, |p| p[axis] == 0.0);
    let boundaries = vec![
        moved("x", on(0), [Some(0.0), None], Schedule::Constant),
        moved("y", on(1), [None, Some(0.0)], Schedule::Constant),
        ground,
    ];
    let mut fluid = injected(water(1e-3, 0.0), 1e-7, wall, pressure(inside));
    fluid.sources[0].initial_pressure = Some(0.0);
    let model = Model {
        boundaries,
        mesh,
        materials: vec![rock_of_scaled_mass(1.0)],
        plane: Plane::Strain,
        time: TimeOptions { dynamic_relaxation: true, ..TimeOptions::default() },
        fluid: Some(fluid),
        ..Model::default()
    };
    (model, hole)
}
