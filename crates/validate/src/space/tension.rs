//! A prism that is pulled apart.

use fdem_simulation::{FractureOptions, Insertion, Interface, Material, Model, Schedule, Strength};

use super::bodies::{
    Body, Point, Run, Turn, advance, advance_to, centroid, cuboid, dot, force, jittered, mean_motion, minus,
    on_box, start, turned,
};
use crate::models::{granite, moved, nodes_where, rock};
use crate::{Outcome, Size};

const WIDTH: f64 = 0.02;
const HEIGHT: f64 = 0.04;

/// Tensile strength, Pa.
const STRENGTH: f64 = 1e6;

/// Fracture energy, J/m².
const ENERGY: f64 = 3.0;

/// Opening at which the joints are broken, m: `G/(0.3863 f)`.
const BROKEN: f64 = ENERGY / (0.386_307 * STRENGTH);

/// Speeds at which the ends part, m/s: until after the peak, and afterwards.
const SPEEDS: [f64; 2] = [0.002, 0.04];

/// Joints on one plane, which lies at an angle to the axes of space, and so does the pull; jittered meshes.
/// The traction peaks at the strength and the crack dissipates the fracture energy times its area, to one
/// percent, whether the joints are there from the beginning or are inserted. A prism that may break
/// everywhere has a rough crack: its strength and energy are checked within wide bounds.
pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let fine = size.choose(2, 4);
    for (name, insertion) in [("adaptive", Insertion::Adaptive), ("intrinsic", Insertion::Intrinsic)] {
        let angles: &[f64] = match insertion {
            Insertion::Adaptive => &[0.0, 17.0, 45.0],
            Insertion::Intrinsic => size.choose(&[17.0], &[0.0, 17.0, 45.0]),
        };
        for &degrees in angles {
            let torn = tear(fine, 1, degrees, insertion, false)?;
            let case = |what: &str| format!("{what}, plane at {degrees}°, {name}");
            outcomes.extend([
                Outcome::relative(case("peak"), STRENGTH, torn.peak, 0.01, "Pa"),
                Outcome::relative(case("energy of the crack"), ENERGY, torn.energy, 0.01, "J/m²"),
                Outcome::absolute(case("error of the energy balance"), 0.0, torn.balance, 1e-3, ""),
            ]);
        }
    }
    let seeds = size.choose(1..=2, 1..=5);
    let count = seeds.clone().count() as f64;
    let mut found = Vec::new();
    for seed in seeds {
        found.push(tear(size.choose(3, 5), seed, 17.0, Insertion::Adaptive, true)?);
    }
    // Mean of the values, and their standard deviation over it.
    let statistics = |values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        [mean, (squares / (count - 1.0)).sqrt() / mean]
    };
    let peak = statistics(found.iter().map(|torn| torn.peak).collect());
    let energy = statistics(found.iter().map(|torn| torn.energy).collect());
    outcomes.extend([
        Outcome::relative(format!("free meshes: mean peak of {count}"), STRENGTH, peak[0], 0.1, "Pa"),
        Outcome::absolute("free meshes: scatter of the peak", 0.0, peak[1], 0.05, ""),
        Outcome::relative("free meshes: mean energy over the projected area", ENERGY, energy[0], 0.4, "J/m²"),
        Outcome::absolute("free meshes: scatter of the energy", 0.0, energy[1], 0.2, ""),
    ]);
    Ok(outcomes)
}

struct TornBar {
    /// Pa.
    peak: f64,
    /// J/m².
    energy: f64,
    /// A share.
    balance: f64,
}

fn mesh(fine: usize, seed: u64, free: bool) -> Body {
    let max = [WIDTH, WIDTH, HEIGHT];
    let mesh = cuboid([0.0; 3], max, [fine, fine, 2 * fine]);
    let middle = 0.5 * HEIGHT;
    jittered(&mesh, 0.15 * WIDTH / fine as f64, seed, |place| {
        let [x, y, z] = on_box([0.0; 3], max)(place);
        [x, y, z || (!free && (place[2] - middle).abs() < 1e-9)]
    })
}

fn tear(fine: usize, seed: u64, degrees: f64, insertion: Insertion, free: bool) -> Result<TornBar, String> {
    let mut straight = mesh(fine, seed, free);
    let middle = 0.5 * HEIGHT;
    for element in 0..straight.elements.len() {
        let z = centroid(&straight, element)[2];
        // The ends of a prism that may break everywhere do not.
        let other = if free { (z - middle).abs() > 0.35 * HEIGHT } else { z > middle };
        straight.materials[element] = u32::from(other);
    }
    let [bottom, top] = [0.0, HEIGHT].map(|at| nodes_where(&straight, |p: Point| (p[2] - at).abs() < 1e-9));
    let turn = Turn::about([2.0, -1.0, 2.0], degrees.to_radians());
    let pull = turn.of([0.0, 0.0, 1.0]);
    let strength = Strength { energy_i: ENERGY, ..rock() };
    let half = Material { youngs_modulus: 30e9, damping: 0.2, ..granite() };
    let peak = 1.5 * STRENGTH / half.youngs_modulus * HEIGHT / SPEEDS[0];
    let speeds = Schedule::Table(vec![[peak, 1.0], [1.1 * peak, SPEEDS[1] / SPEEDS[0]]]);
    let breaks = Material { strength: Some(strength), ..half.clone() };
    let velocities =
        straight.nodes.iter().map(|place| pull.map(|n| SPEEDS[0] * n * place[2] / HEIGHT)).collect();
    let model = Model {
        mesh: turned(&straight, &turn, [0.0; 3]),
        velocities,
        materials: vec![if free { breaks } else { half.clone() }, half],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.0,
            penalty: None,
            strength: Some(if free {
                Strength { tensile: 1e8, cohesion: 1e8, energy_i: 1e6, energy_ii: 1e6, ..strength }
            } else {
                strength
            }),
        }],
        boundaries: vec![
            moved("bottom", bottom.clone(), [Some(0.0); 3], Schedule::Constant),
            moved("top", top.clone(), pull.map(|n| Some(SPEEDS[0] * n)), speeds),
        ],
        fracture: FractureOptions { insertion, joint_penalty: 20.0, ..FractureOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    let mut peak = 0.0_f64;
    let opened = |run: &Run| dot(mean_motion(run, &top)[0], pull);
    let far = if free { 3.0 } else { 1.2 };
    while opened(&run) < far * BROKEN {
        advance(&mut run, 1)?;
        let pulled = 0.5 * dot(minus(force(&run, 1)?, force(&run, 0)?), pull);
        peak = peak.max(pulled / (WIDTH * WIDTH));
        if run.time() > 0.02 {
            return Err("the prism does not break".to_owned());
        }
    }
    let end = 1.1 * run.time();
    advance_to(&mut run, end)?;
    if !free && run.counts().joints > 0 {
        return Err("not all joints are broken".to_owned());
    }
    let energies = run.energies();
    Ok(TornBar { peak, energy: energies.cohesive / (WIDTH * WIDTH), balance: energies.error() })
}
