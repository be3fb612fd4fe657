//! Four heaps of fragments that collide: the energy after the collision equals the energy before.

use fdem_simulation::{ContactOptions, Material, Mesh, Model, TimeOptions};

use super::models::{advance, disc, granite, momentum, one_body, start, together, turned, worse};
use super::{Outcome, Size};

/// Distance from fragment to fragment, m.
const CELL: f64 = 0.1;

/// Speed of a heap along either axis, m/s.
const SPEED: f64 = 10.0;

/// Penalty of the contacts. They are softer than the fragments, which therefore hardly vibrate.
const PENALTY: f64 = 1e-2;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let side = size.choose(3, 6);
    let mut fragments = Vec::new();
    let mut velocities = Vec::new();
    for (heap, [right, up]) in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].into_iter().enumerate() {
        // Each heap has another speed.
        let speed = SPEED * (1.0 + 0.1 * heap as f64);
        for i in 0..side {
            for j in 0..side {
                let number = fragments.len();
                let from_middle = |k: usize| CELL * (0.55 + k as f64);
                let place = [right * from_middle(i), up * from_middle(j) + 0.1 * CELL * right];
                let fragment = turned(&fragment(number), 0.7 * number as f64, place);
                velocities.extend(vec![[-right * speed, -up * SPEED]; fragment.nodes.len()]);
                fragments.push(fragment);
            }
        }
    }
    let model = Model {
        mesh: together(&fragments),
        velocities,
        materials: vec![Material { poissons_ratio: 0.2, ..granite() }],
        contact: ContactOptions { penalty: PENALTY, ..ContactOptions::default() },
        time: TimeOptions { safety: 0.1, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    advance(&mut run, 1)?;
    let (before, momenta) = (run.energies(), momentum(&run));
    if run.counts().contacts > 0 {
        return Err("fragments touch at the beginning".to_owned());
    }
    // The fragments are apart if none has touched another while the fastest travelled two cells.
    let quiet = 2.0 * CELL / SPEED;
    let (mut most, mut last) = (0, 0.0);
    while most == 0 || run.time() < last + quiet {
        advance(&mut run, 1)?;
        let contacts = run.counts().contacts;
        if contacts > 0 {
            last = run.time();
            most = most.max(contacts);
        }
        if run.penetrated().is_some() {
            return Err("a fragment is inside another".to_owned());
        }
        if run.time() > 1.0 {
            return Err("the heaps do not meet, or do not part".to_owned());
        }
    }
    let (energies, after) = (run.energies(), momentum(&run));
    let total = (energies.kinetic + energies.strain + energies.contact) / before.kinetic;
    // The momenta of the heaps nearly cancel: a change is compared with the sum over all fragments.
    let all = (2.0 * before.kinetic * mass(&run.model().mesh)).sqrt();
    let change = (0..3).fold(0.0, |change, k| worse((after[k] - momenta[k]) / all, change));
    Ok(vec![
        Outcome::relative(
            format!("energy after over before, {} fragments", fragments.len()),
            1.0,
            total,
            1e-3,
            "",
        ),
        Outcome::relative("kinetic energy", 1.0, energies.kinetic / before.kinetic, 1e-3, ""),
        Outcome::absolute("largest change of a momentum", 0.0, change, 1e-11, ""),
    ])
}

/// A triangle, a square or a hexagon, in turn.
fn fragment(number: usize) -> Mesh {
    let radius = 0.45 * CELL;
    let corner = |k: usize, n: usize| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
        [radius * cos, radius * sin]
    };
    match number % 3 {
        0 => one_body((0..3).map(|k| corner(k, 3)).collect(), vec![[0, 1, 2]]),
        1 => one_body((0..4).map(|k| corner(k, 4)).collect(), vec![[0, 1, 2], [0, 2, 3]]),
        _ => disc(radius, 1),
    }
}

/// Mass of a mesh, kg.
fn mass(mesh: &Mesh) -> f64 {
    let area = |nodes: &[u32; 3]| {
        let [a, b, c] = nodes.map(|node| mesh.nodes[node as usize]);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    };
    super::models::DENSITY * mesh.elements.iter().map(area).sum::<f64>()
}
