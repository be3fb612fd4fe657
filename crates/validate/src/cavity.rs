//! A pressure in a crack, and a gas in a hole.

use std::f64::consts::PI;

use fdem_simulation::{
    Boundary, CavityState, Element, JointSet, Load, Material, Mesh, Model, Plane, Schedule, Simulation,
    Strength, Target, TimeOptions,
};

use crate::models::{granite, moved, nodes_where, rectangle};
use crate::{Outcome, Size};

/// Half of the length of the crack and of the width of the block, m.
const LENGTH: f64 = 0.1;
const HALF: f64 = 2.0;

/// Pa.
const PRESSURE: f64 = 1e6;

const POISSON: f64 = 0.25;

/// A set of joints that are open and without friction.
pub(crate) fn open() -> JointSet {
    JointSet {
        name: "crack".to_owned(),
        strength: Strength {
            tensile: 0.0,
            cohesion: 0.0,
            friction: 0.0,
            energy_i: 0.0,
            energy_ii: 0.0,
            weibull_modulus: None,
            seed: 0,
        },
        residual_friction: 0.0,
        dilation: 0.0,
        dilation_slip: None,
        normal_stiffness: None,
        shear_stiffness: None,
        open: true,
    }
}

/// A pressure in the cracks that are connected with a facet.
pub(crate) fn pressure_at<const D: usize>(facet: [u32; D]) -> Boundary<D> {
    Boundary {
        name: "fluid".to_owned(),
        target: Target::Facets(vec![facet]),
        load: Load::Cavity { pressure: PRESSURE, gas: None },
        schedule: Schedule::Constant,
    }
}

/// Places from 0 to `far`: `cells` equal cells up to `near`, and then larger and larger ones.
pub(crate) fn graded(near: f64, far: f64, cells: usize, growth: f64) -> Vec<f64> {
    let mut places: Vec<f64> = (0..=cells).map(|k| near * k as f64 / cells as f64).collect();
    let (mut cell, mut last) = (near / cells as f64, near);
    while last < far {
        cell *= growth;
        last += cell;
        places.push(last);
    }
    let stretch = (far - near) / (last - near);
    places[cells + 1..].iter_mut().for_each(|place| *place = near + (*place - near) * stretch);
    places
}

/// The same places on both sides of 0.
pub(crate) fn mirrored(places: &[f64]) -> Vec<f64> {
    places.iter().skip(1).rev().map(|place| -place).chain(places.iter().copied()).collect()
}

/// Runs until forces are in equilibrium, and returns the cavity.
pub(crate) fn settled<const D: usize, const N: usize>(
    run: &mut Simulation<D, N>,
) -> Result<CavityState, String>
where
    [[f64; D]; N]: Element<D, N>,
{
    for _ in 0..400 {
        run.advance(200).map_err(|stop| stop.to_string())?;
        if run.imbalance() < 1e-4 {
            return run.cavity(0).ok_or_else(|| "there is no cavity".to_owned());
        }
    }
    Err(format!("it does not come to rest: imbalance {}", run.imbalance()))
}

/// The value on elements without size, from those of two meshes of which the second has elements of half the
/// size. A mesh of triangles or tetrahedra makes a crack too short by a share of the size of its elements.
pub(crate) fn extrapolated([coarse, fine]: [f64; 2]) -> f64 {
    2.0 * fine - coarse
}

/// A crack of the length `2 l` under the pressure `p` opens by `4 p √(l² - x²)/E'`, in plane strain with
/// `E' = E/(1 - ν²)`: an ellipse of the area `2 π p l²/E'`.
pub(crate) fn line(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose(8, 16);
    let modulus = granite().youngs_modulus / (1.0 - POISSON * POISSON);
    let (mut volumes, mut openings) = ([0.0; 2], [0.0; 2]);
    let mut outcomes = Vec::new();
    for (place, cells) in [cells, 2 * cells].into_iter().enumerate() {
        let mut run = Simulation::new(plate(cells), 1).map_err(|error| error.to_string())?;
        let state = settled(&mut run)?;
        let inner = |x: f64| x < 0.5 * LENGTH + 1e-9;
        let cracks = run.snapshot().cracks;
        let inner: f64 = cracks
            .iter()
            .filter(|crack| crack.corners.iter().all(|corner| inner(corner[0])))
            .map(|crack| crack.measure * crack.opening)
            .sum();
        (volumes[place], openings[place]) = (2.0 * state.volume, inner / (0.5 * LENGTH));
        // The balance has the work of a step at the next one.
        let work = state.work;
        run.advance(1).map_err(|stop| stop.to_string())?;
        if place == 1 {
            outcomes.extend([
                Outcome::relative("work, as p dV", PRESSURE * state.volume, work, 1e-9, "J"),
                Outcome::relative("external work of the balance", work, run.energies().external, 1e-6, "J"),
                Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-3, ""),
            ]);
        }
    }
    let half = 0.5_f64;
    let mean = (half * (1.0 - half * half).sqrt() + half.asin()) / (2.0 * half);
    let expected = 4.0 * PRESSURE * LENGTH / modulus * mean;
    outcomes.splice(
        0..0,
        [
            Outcome::relative(
                "area of the open crack",
                2.0 * PI * PRESSURE * LENGTH * LENGTH / modulus,
                extrapolated(volumes),
                0.02,
                "m²",
            ),
            Outcome::relative("mean opening of its inner half", expected, extrapolated(openings), 0.02, "m"),
        ],
    );
    Ok(outcomes)
}

/// Half of a plate with a crack in its middle. The crack's length has this number of elements on each side.
fn plate(cells: usize) -> Model {
    let across = graded(LENGTH, HALF, cells, 1.12);
    let up = mirrored(&graded(0.5 * LENGTH, HALF, cells / 2, 1.12));
    let counts = [across.len() - 1, up.len() - 1];
    let even = rectangle([0.0; 2], counts.map(|count| count as f64), counts);
    let nodes = even.nodes.iter().map(|[i, j]| [across[i.round() as usize], up[j.round() as usize]]);
    let mesh = Mesh { nodes: nodes.collect(), ..even };
    let cracked = |[x, y]: [f64; 2]| y.abs() < 1e-9 && x < LENGTH + 1e-9;
    let edges = crate::models::edges_where(&mesh, cracked);
    let mut model = Model {
        boundaries: vec![
            pressure_at(edges[0]),
            moved("symmetry", nodes_where(&mesh, |[x, _]| x < 1e-9), [Some(0.0), None], Schedule::Constant),
        ],
        mesh,
        materials: vec![Material { poissons_ratio: POISSON, ..granite() }],
        joint_sets: vec![open()],
        plane: Plane::Strain,
        time: TimeOptions { dynamic_relaxation: true, ..TimeOptions::default() },
        ..Model::default()
    };
    model.add_joints(0, &edges);
    model
}

/// A gas in the square hole of a square plate. As the plate swings, its pressure times the power γ of its
/// volume stays constant, and so does the sum of its energy and that of the plate.
pub(crate) fn gas(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose(12, 24);
    let exponent = 1.4;
    let mesh = rectangle([-0.3; 2], [0.3; 2], [cells; 2]);
    let hole = |[x, y]: [f64; 2]| x.abs() < 0.1 && y.abs() < 0.1;
    let keep: Vec<bool> =
        (0..mesh.elements.len()).map(|element| !hole(crate::models::centroid(&mesh, element))).collect();
    let whole = Model { mesh, materials: vec![granite()], ..Model::default() };
    let mut model = whole.keeping(&keep).map_err(|error| error.to_string())?.model;
    let reversed = |[a, b]: [u32; 2], all: &[[u32; 2]]| all.contains(&[b, a]);
    let edges = crate::models::edges_where(&model.mesh, |[x, y]| x.abs().max(y.abs()) < 0.1 + 1e-9);
    let edges: Vec<[u32; 2]> = edges.iter().copied().filter(|&edge| !reversed(edge, &edges)).collect();
    let pressure = 400.0 * PRESSURE;
    model.boundaries = vec![Boundary {
        load: Load::Cavity { pressure, gas: Some(exponent) },
        target: Target::Facets(edges),
        ..pressure_at([0, 1])
    }];
    let mut run = Simulation::new(model, 1).map_err(|error| error.to_string())?;
    let first = run.cavity(0).ok_or("there is no cavity")?;
    let mut volume = first.volume;
    let mut worst = 1.0_f64;
    // The largest volume, and the work until then: it hardly changes within a step there.
    let (mut most, mut work) = (volume, 0.0);
    for _ in 0..size.choose(500, 2000) {
        run.advance(1).map_err(|stop| stop.to_string())?;
        let now = run.cavity(0).ok_or("there is no cavity")?;
        // The pressure of a step is that of the volume before it.
        let found = now.pressure * volume.powf(exponent);
        let ratio = found / (pressure * first.volume.powf(exponent));
        if (ratio - 1.0).abs() > (worst - 1.0).abs() {
            worst = ratio;
        }
        volume = now.volume;
        if volume > most {
            (most, work) = (volume, now.work);
        }
    }
    let lost =
        pressure * first.volume / (exponent - 1.0) * (1.0 - (first.volume / most).powf(exponent - 1.0));
    Ok(vec![
        Outcome::relative("volume of the hole", 0.04, first.volume, 1e-14, "m²"),
        Outcome::absolute("whether the pressure opens it", 1.0, f64::from(most > first.volume), 0.0, ""),
        Outcome::relative("p V^γ, where it differs most", 1.0, worst, 1e-12, ""),
        Outcome::relative("work of the gas over its loss of energy", 1.0, work / lost, 0.01, ""),
        Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-3, ""),
    ])
}
