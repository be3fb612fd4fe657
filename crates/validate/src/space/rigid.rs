//! Rigid bodies: a free one that tumbles, some at rest or sliding on a plane, and pairs that collide.

use std::f64::consts::PI;

use fdem_simulation::{ContactOptions, Material, Model, Schedule, TimeOptions};

use super::bodies::{
    Body, Point, Random, Run, Turn, advance, advance_to, change, cross, cuboid, dot, length, mapped,
    mean_motion, minus, momentum, plus, start, turned, volume_of,
};
use super::rotation::axis_of;
use crate::models::{DENSITY, granite, moved, nodes_where, together, worse};
use crate::{Outcome, Size};

/// m/s².
const GRAVITY: f64 = 9.81;

/// Sides of the body that tumbles, m: its moments of inertia about x, y and z ascend.
const SIDES: Point = [0.3, 0.2, 0.1];

/// The free asymmetric top, spinning nearly about its middle axis, turns over again and again.
///
/// Landau and Lifshitz, Mechanics (1976), 37: the spin about the middle axis has the period
///
/// ```text
/// T = 4 K(k) √(I₁ I₂ I₃ / ((I₃ - I₂)(M² - 2 E I₁))),   k² = (I₂ - I₁)(2 E I₃ - M²) / ((I₃ - I₂)(M² - 2 E I₁))
/// ```
/// where `M² > 2 E I₂`; otherwise with the first and the third axis exchanged.
pub(crate) fn tumbles(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh = mapped(&cuboid([0.0; 3], SIDES, [1, 1, 1]), |p| minus(p, SIDES.map(|side| 0.5 * side)));
    let spin = [0.01, 1.0, 0.01];
    let velocities = mesh.nodes.iter().map(|&node| cross(spin, node)).collect();
    let step = 2e-3;
    let time = TimeOptions { step: Some(step), ..TimeOptions::default() };
    let materials = vec![granite()];
    let mut run = start(Model { mesh, velocities, materials, time, rigid: vec![0], ..Model::default() })?;
    let mass = DENSITY * SIDES.iter().product::<f64>();
    let inertia: Point = std::array::from_fn(|k| {
        let [a, b] = [SIDES[(k + 1) % 3], SIDES[(k + 2) % 3]];
        mass / 12.0 * (a * a + b * b)
    });
    let twice = (0..3).map(|k| inertia[k] * spin[k] * spin[k]).sum::<f64>();
    let moment: Point = std::array::from_fn(|k| inertia[k] * spin[k]);
    let period = period(inertia, twice, dot(moment, moment));
    // The middle axis is across the momentum where the spin about it changes its sign.
    let mut crossings: Vec<f64> = Vec::new();
    let (mut before, mut drift) = (1.0, 0.0);
    let wanted = size.choose(3, 21);
    while crossings.len() < wanted && run.time() < 20.0 * f64::from(size.choose(1, 10)) * period {
        advance(&mut run, 10)?;
        drift = worse(2.0 * run.energies().kinetic / twice - 1.0, drift);
        let now = dot(axis_of(&run, 0.5 * SIDES[1]), moment) / length(moment);
        if now * before < 0.0 {
            crossings.push(run.time() - 10.0 * step * now / (now - before));
        }
        before = now;
    }
    let found = match crossings[..] {
        [first, .., last] => 2.0 * (last - first) / (crossings.len() - 1) as f64,
        _ => f64::NAN,
    };
    Ok(vec![
        Outcome::relative("period of the spin about the middle axis", period, found, 1e-3, "s"),
        Outcome::absolute("largest change of the kinetic energy", 0.0, drift, 1e-6, ""),
    ])
}

/// The period of the spin about the middle axis, with twice the energy and the square of the momentum.
fn period([one, two, three]: Point, twice: f64, square: f64) -> f64 {
    let [first, last] = if square > twice * two { [one, three] } else { [three, one] };
    let below = (last - two) * (square - twice * first);
    let modulus = (two - first) * (twice * last - square) / below;
    // The complete elliptic integral by the arithmetic-geometric mean.
    let (mut a, mut b) = (1.0, (1.0 - modulus).sqrt());
    for _ in 0..30 {
        (a, b) = (f64::midpoint(a, b), f64::sqrt(a * b));
    }
    4.0 * (0.5 * PI / a) * (one * two * three / below).sqrt()
}

/// A cube on a plane: at rest it sinks in by the weight over the stiffness of flush faces, and does not turn;
/// on a slope it rests or slides as Coulomb says.
pub(crate) fn on_a_plane(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let side = 0.1;
    // Stiff, so that the depth is small against the elements.
    let stiff = Material { youngs_modulus: 5e9, ..granite() };
    let penalty = ContactOptions::default().penalty * stiff.youngs_modulus;
    let mut run = cube_on_plane(side, [0.0, 0.0, -GRAVITY], stiff, 0.7)?;
    advance_to(&mut run, size.choose(0.005, 0.05))?;
    let top = top_of(&run);
    let [moved, _] = mean_motion(&run, &top);
    // The potential grows over the height of an element by 4 times the penalty, in both bodies.
    let height = side;
    let sunk = DENSITY * side.powi(3) * GRAVITY / (penalty * side * side * 4.0 * (2.0 / height));
    outcomes.push(Outcome::relative("depth of a cube at rest", sunk, -moved[2], 1e-6, "m"));
    let turned = length([moved[0], moved[1], 0.0]) / side;
    outcomes.push(Outcome::absolute("its turn and its way aside", 0.0, turned, 1e-12, ""));
    let friction = 0.4;
    for degrees in size.choose(&[20.0, 30.0, -30.0][..], &[15.0, 21.0, 25.0, 30.0, -30.0, 45.0][..]) {
        let (sin, cos) = f64::to_radians(*degrees).sin_cos();
        let material = Material { friction, ..soft() };
        let mut run = cube_on_plane(side, [GRAVITY * sin, 0.0, -GRAVITY * cos], material, 0.0)?;
        advance_to(&mut run, 0.02)?;
        let nodes = top_of(&run);
        let ([_, first], from) = (mean_motion(&run, &nodes), run.time());
        advance_to(&mut run, 0.1)?;
        let [_, last] = mean_motion(&run, &nodes);
        let found = (last[0] - first[0]) / (run.time() - from);
        let slides = GRAVITY * (sin.abs() - friction * cos) * sin.signum();
        let expected = if sin.abs() > friction * cos { slides } else { 0.0 };
        let name = format!("acceleration at {degrees}°");
        outcomes.push(Outcome::absolute(name, expected, found, 1e-3 * GRAVITY, "m/s²"));
    }
    Ok(outcomes)
}

fn soft() -> Material {
    Material { youngs_modulus: 1e8, ..granite() }
}

/// A cube on a rigid plane that is held.
fn cube_on_plane(side: f64, gravity: Point, material: Material, local_damping: f64) -> Result<Run, String> {
    // Elements as high as those of the cube.
    let plane = cuboid([-5.0 * side, -side, -side], [8.0 * side, 2.0 * side, 0.0], [13, 3, 1]);
    let cube = cuboid([0.0; 3], [side; 3], [1, 1, 1]);
    let held = (0..plane.nodes.len() as u32).collect();
    start(Model {
        mesh: together(&[plane, cube]),
        materials: vec![material],
        boundaries: vec![moved("plane", held, [Some(0.0); 3], Schedule::Constant)],
        gravity,
        rigid: vec![0, 1],
        contact: ContactOptions { damping: 0.3, ..ContactOptions::default() },
        time: TimeOptions { local_damping, ..TimeOptions::default() },
        ..Model::default()
    })
}

/// Nodes of the top of the cube.
fn top_of(run: &Run) -> Vec<u32> {
    nodes_where(&run.model().mesh, |p: Point| p[2] > 0.0)
}

/// Cubes that meet in any orientation, without friction and damping, keep their energy and their momenta.
pub(crate) fn collisions(size: Size) -> Result<Vec<Outcome>, String> {
    let count: u32 = size.choose(10, 500);
    let (mut energy, mut of_momenta) = (0.0, 0.0);
    for number in 0..count {
        let random = &mut Random(u64::from(number) + 1);
        let cube = cuboid([-0.05; 3], [0.05; 3], [1, 1, 1]);
        let bodies: [Body; 2] = [-0.09, 0.09].map(|x| {
            let turn = Turn::any(random);
            turned(&cube, &turn, [x, random.between(-0.03, 0.03), random.between(-0.03, 0.03)])
        });
        let speed = 5.0;
        let spins = [0, 1].map(|_| [0; 3].map(|_| random.between(-20.0, 20.0)));
        let mut velocities = Vec::new();
        for (k, body) in bodies.iter().enumerate() {
            let count = body.nodes.len() as f64;
            let middle = body.nodes.iter().fold([0.0; 3], |sum, &p| plus(sum, p)).map(|x| x / count);
            let way = [if k == 0 { speed } else { -speed }, 0.0, 0.0];
            velocities.extend(body.nodes.iter().map(|&p| plus(way, cross(spins[k], minus(p, middle)))));
        }
        let mut run = start(Model {
            mesh: together(&bodies),
            velocities,
            materials: vec![soft()],
            rigid: vec![0, 1],
            time: TimeOptions { safety: 0.1, ..TimeOptions::default() },
            ..Model::default()
        })?;
        advance(&mut run, 1)?;
        let (before, kinetic) = (momentum(&run), run.energies().kinetic);
        advance_to(&mut run, 0.03)?;
        let scale = (2.0 * kinetic * volume_of(&run.model().mesh) * DENSITY).sqrt();
        energy = worse(run.energies().balance() / kinetic, energy);
        let linear = change(&[before[0], [0.0; 3]], &[momentum(&run)[0], [0.0; 3]], scale, 0.1);
        of_momenta = worse(linear, of_momenta);
        let [_, velocity] = mean_motion(&run, &nodes_where(&run.model().mesh, |p: Point| p[0] < 0.0));
        if (velocity[0] - speed).abs() < 1e-3 * speed {
            return Err("two cubes have not met".to_owned());
        }
    }
    Ok(vec![
        Outcome::absolute(format!("change of the energy, worst of {count} blows"), 0.0, energy, 1e-4, ""),
        Outcome::absolute("largest change of the momentum", 0.0, of_momenta, 1e-11, ""),
    ])
}
