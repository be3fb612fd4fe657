//! Uniaxial tension of a strip: strength, fracture energy, one crack.

use fdem_simulation::{
    CriticalOpening, FractureOptions, Insertion, Interface, Material, Model, Schedule, Strength,
};

use super::models::{
    advance, advance_to, centroid, force, granite, moved, nodes_where, rectangle, rock, start,
};
use super::{Outcome, Size};

/// m.
const WIDTH: f64 = 0.01;
const HEIGHT: f64 = 0.04;

/// Speeds, m/s: up to the peak, so slow that both ends carry the same load, and afterwards.
const SPEEDS: [f64; 2] = [4e-4, 2e-3];

/// Displacement at the first speed, m: the peak is over then.
const SOFTENING: f64 = 1.8e-6;

/// Fracture energy, J/m²: so large that the strip softens slowly.
const ENERGY: f64 = 3.0;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose([2, 8], [4, 16]);
    let mut outcomes = Vec::new();
    let exact = CriticalOpening::Exact;
    for (name, insertion) in [("adaptive", Insertion::Adaptive), ("intrinsic", Insertion::Intrinsic)] {
        let Torn { peak, energy, crack, balance } = tear(cells, insertion, exact)?;
        outcomes.extend([
            Outcome::relative(format!("peak of the traction, {name}"), rock().tensile, peak, 0.005, "Pa"),
            Outcome::relative(format!("energy of the crack, {name}"), ENERGY, energy, 0.01, "J/m²"),
            Outcome::relative(format!("length of the crack, {name}"), WIDTH, crack, 1e-9, "m"),
            Outcome::absolute(format!("error of the energy balance, {name}"), 0.0, balance, 1e-3, ""),
        ]);
    }
    let Torn { energy, .. } = tear(cells, Insertion::Adaptive, CriticalOpening::Customary)?;
    // Three times the area below the softening curve.
    let expected = 1.158_922 * ENERGY;
    outcomes.push(Outcome::relative("energy of the crack, customary 3 G/f", expected, energy, 0.01, "J/m²"));
    Ok(outcomes)
}

struct Torn {
    /// Pa.
    peak: f64,
    /// J/m².
    energy: f64,
    /// m; not a number if any of it did not open.
    crack: f64,
    /// A share.
    balance: f64,
}

fn tear(cells: [usize; 2], insertion: Insertion, critical_opening: CriticalOpening) -> Result<Torn, String> {
    let mut mesh = rectangle([0.0, 0.0], [WIDTH, HEIGHT], cells);
    // The joints between the two halves are a little weaker than the rest, so that the place of the crack is
    // known.
    for element in 0..mesh.elements.len() {
        mesh.materials[element] = u32::from(centroid(&mesh, element)[1] > 0.5 * HEIGHT);
    }
    let strength = Strength { energy_i: ENERGY, ..rock() };
    let stronger = Strength { tensile: 1.05 * strength.tensile, ..strength };
    let half = Material { youngs_modulus: 30e9, damping: 0.2, strength: Some(stronger), ..granite() };
    let peak = SOFTENING / SPEEDS[0];
    let speeds = Schedule::Table(vec![[peak, SPEEDS[0]], [1.05 * peak, SPEEDS[1]]]);
    let bottom = nodes_where(&mesh, |[_, y]| y < 1e-9);
    let top = nodes_where(&mesh, |[_, y]| y > HEIGHT - 1e-9);
    let model = Model {
        velocities: mesh.nodes.iter().map(|[_, y]| [0.0, SPEEDS[0] * y / HEIGHT]).collect(),
        mesh,
        materials: vec![half.clone(), half],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.0,
            penalty: None,
            strength: Some(strength),
        }],
        boundaries: vec![
            moved("bottom", bottom, [None, Some(0.0)], Schedule::Constant),
            moved("top", top, [None, Some(1.0)], speeds),
        ],
        fracture: FractureOptions { insertion, joint_penalty: 20.0, critical_opening },
        ..Model::default()
    };
    let mut run = start(model)?;
    let mut peak = 0.0_f64;
    while run.counts().broken < cells[0] {
        advance(&mut run, 1)?;
        peak = peak.max(force(&run, 1)?[1] / WIDTH);
        if run.time() > 0.1 {
            return Err("the strip does not break".to_owned());
        }
    }
    let end = 1.2 * run.time();
    advance_to(&mut run, end)?;
    let [opened, slid, both] = run.crack_lengths();
    let energies = run.energies();
    Ok(Torn {
        peak,
        energy: energies.cohesive / WIDTH,
        crack: if slid + both == 0.0 { opened } else { f64::NAN },
        balance: energies.error(),
    })
}
