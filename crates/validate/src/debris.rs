//! Debris: a block that breaks in a box that is shaken, and whose fragments strike each other and the walls
//! again and again.
//!
//! Elements that a joint held together touch as soon as it breaks, often deeply, and the load of the joint
//! passes to the contact. If the contact counted an initial overlap, or if the joint released while it
//! pressed, each transition would create or destroy energy, and a million of them would heat the debris until
//! it explodes.
//!
//! The rest is the error of the integration in time: the scheme keeps an energy that differs from the true
//! one by a share of the order `(ω Δt)²`. That difference depends on the state alone, so it does not grow
//! with the number of transitions. It was found to be in proportion to the strain energy of the fragments,
//! and to the square of the step.

use fdem_simulation::{
    Boundary, Element, FractureOptions, Insertion, Material, Mesh, Model, Schedule, Simulation, Strength,
    TimeOptions,
};

use super::models::{granite, moved, one_body, rectangle, rock, rotated, together, turned, worse};
use super::{Outcome, Size};

/// Width of a cell of the block, m.
pub(super) const CELL: f64 = 0.01;

/// Speed of the block at the beginning, m/s.
pub(super) const SPEED: f64 = 30.0;

/// Amplitude of the acceleration of the box, m/s².
const SHAKING: f64 = 4e4;

/// Periods of the shaking. The box rests afterwards.
const PERIODS: u32 = 1000;

/// Steps after which a run with too few transitions is given up.
const MOST_STEPS: u64 = 10_000_000;

/// A kind of joints, friction, the share of the critical time step, and the transitions that it has to pass.
pub(super) struct DebrisKind {
    pub(super) name: &'static str,
    pub(super) insertion: Insertion,
    pub(super) friction: f64,
    pub(super) safety: f64,
    pub(super) transitions: usize,
}

/// The kinds of a ladder. `most`: transitions of the first one at full size.
pub(super) fn kinds(size: Size, most: usize, safety: f64) -> Vec<DebrisKind> {
    let kind = |name, insertion, friction, share: usize| DebrisKind {
        name,
        insertion,
        friction,
        safety,
        transitions: size.choose(2000, most / share),
    };
    let mut kinds =
        vec![kind("adaptive", Insertion::Adaptive, 0.0, 1), kind("intrinsic", Insertion::Intrinsic, 0.0, 10)];
    if size == Size::Full {
        kinds.push(kind("adaptive, friction 0.4", Insertion::Adaptive, 0.4, 10));
    }
    kinds
}

/// The model of a block in a box with the inner width `inner`, m. The box is the first body.
pub(super) fn model<const D: usize, const N: usize>(
    kind: &DebrisKind,
    bodies: &[Mesh<D, N>; 2],
    inner: f64,
    velocity: impl Fn([f64; D]) -> [f64; D],
    shaken: [f64; D],
) -> Model<D, N> {
    let count = bodies[0].nodes.len();
    let velocities =
        [vec![[0.0; D]; count], bodies[1].nodes.iter().map(|&place| velocity(place)).collect()].concat();
    let held: Boundary<D> = moved("box", (0..count as u32).collect(), [Some(0.0); D], Schedule::Constant);
    let mut mesh = together(bodies);
    mesh.materials.clone_from(&mesh.bodies);
    // In the frame of the box its shaking is a weight that changes its sign.
    let period = 2.0 * inner / SPEED;
    let row = |k: u32| {
        let turns = f64::from(k) / 16.0;
        [period * turns, (std::f64::consts::TAU * turns).sin()]
    };
    let strength = Strength { tensile: 1e6, cohesion: 2e6, energy_i: 0.3, energy_ii: 1.0, ..rock() };
    let wall = Material { youngs_modulus: 3e9, friction: kind.friction, ..granite() };
    Model {
        materials: vec![wall.clone(), Material { poissons_ratio: 0.2, strength: Some(strength), ..wall }],
        boundaries: vec![held],
        gravity: shaken.map(|x| x * SHAKING),
        gravity_schedule: Schedule::Table((0..=16 * PERIODS).map(row).collect()),
        velocities,
        mesh,
        fracture: FractureOptions {
            insertion: kind.insertion,
            joint_penalty: 20.0,
            ..FractureOptions::default()
        },
        time: TimeOptions { safety: kind.safety, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// Shakes a model until its transitions are counted. A transition is a joint that breaks, or a couple of
/// elements that begins or ceases to touch. In one step the same number of couples may begin as cease: only
/// the difference is counted, so that there are more transitions than reported. The sum of all energies stays
/// equal to its initial value plus the work of shaking, to 1e-4 of the most energy that was in the system:
/// kinetic, stored, and turned into heat by friction, which the shaking supplies continuously.
pub(super) fn shaken<const D: usize, const N: usize>(
    kind: &DebrisKind,
    model: Model<D, N>,
) -> Result<Outcome, String>
where
    [[f64; D]; N]: Element<D, N>,
{
    let mut run = Simulation::new(model, 1).map_err(|error| error.to_string())?;
    let (mut transitions, mut touching, mut broken) = (0, 0, 0);
    let (mut most, mut error) = (0.0_f64, 0.0);
    while transitions < kind.transitions {
        run.advance(1).map_err(|error| error.to_string())?;
        let counts = run.counts();
        transitions += counts.contacts.abs_diff(touching) + (counts.broken - broken);
        (touching, broken) = (counts.contacts, counts.broken);
        if run.steps() % 20 == 0 {
            let energies = run.energies();
            most = most.max(energies.kinetic + energies.strain + energies.contact + energies.friction);
            error = worse(energies.balance(), error);
        }
        if run.steps() > MOST_STEPS {
            return Err(format!("only {transitions} transitions"));
        }
    }
    if broken < 40 {
        return Err(format!("only {broken} joints broke"));
    }
    let name = format!("energy error after {broken} joints broke, {transitions} transitions, {}", kind.name);
    Ok(Outcome::absolute(name, 0.0, error / most, 1e-4, ""))
}

/// A square of triangles.
pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose(4, 6);
    let half = 0.5 * CELL * cells as f64;
    let block = turned(&rectangle([-half; 2], [half; 2], [cells; 2]), 0.3, [0.0; 2]);
    // Room for the turned block.
    let inner = 2.8 * half;
    let walls = frame(inner);
    let spin = SPEED / inner;
    let velocity = |place: [f64; 2]| {
        let [x, y] = rotated(place, std::f64::consts::FRAC_PI_2);
        [0.8 * SPEED + spin * x, -0.6 * SPEED + spin * y]
    };
    let bodies = [walls, block];
    kinds(size, 200_000, 0.05)
        .iter()
        .map(|kind| shaken(kind, model(kind, &bodies, inner, velocity, [0.6, 0.8])))
        .collect()
}

/// A hollow square with walls of one cell.
fn frame(inner: f64) -> Mesh {
    let all = rectangle([-1.5 * inner; 2], [1.5 * inner; 2], [3; 2]);
    let walls =
        all.elements.iter().enumerate().filter(|&(element, _)| {
            super::models::centroid(&all, element).iter().any(|x| x.abs() > 0.5 * inner)
        });
    one_body(all.nodes.clone(), walls.map(|(_, corners)| *corners).collect())
}
