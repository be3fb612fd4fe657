//! Tetrahedra that collide without friction and damping: their energy and momenta are the same before and
//! after.

use std::f64::consts::{PI, TAU};

use fdem_simulation::{Boundary, ContactOptions, Load, Material, Model, Schedule, Target, TimeOptions};

use super::bodies::{
    Body, Point, Random, Turn, advance, change, dot, length, mapped, mean_motion, momentum, one_body, plus,
    start, turned, volume_of,
};
use crate::impact::Met;
use crate::models::{granite, together, worse};
use crate::{Outcome, Size};

/// Penalty of a contact that is much softer than the bodies, which therefore hardly vibrate.
const SOFT: f64 = 1e-4;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let mut momentum = 0.0;
    for (kind, name) in ["vertex on face", "edge on edge", "face on face"].into_iter().enumerate() {
        let count = size.choose(8, 500);
        let (mut total, mut kinetic) = (0.0, 0.0);
        for number in 0..count {
            let hard = random_blow(kind, number, ContactOptions::default().penalty, 0.05)?;
            let soft = random_blow(kind, number, SOFT, 0.4)?;
            total = worse(hard.energy(), total);
            kinetic = worse(soft.kinetic(), kinetic);
            momentum = [hard.momentum, soft.momentum].into_iter().fold(momentum, |most, m| worse(m, most));
        }
        let name = |what: &str| format!("{name}: {what}, worst of {count}");
        outcomes.push(Outcome::relative(name("energy after over before"), 1.0, 1.0 + total, 1e-4, ""));
        outcomes.push(Outcome::relative(name("kinetic energy, soft contact"), 1.0, 1.0 + kinetic, 1e-3, ""));
    }
    outcomes.push(Outcome::absolute("largest change of a momentum", 0.0, momentum, 1e-11, ""));
    outcomes.extend(of_the_book()?);
    Ok(outcomes)
}

/// The regular tetrahedron with edges of 1 m, its centre at the origin and a face downwards.
fn regular() -> Body {
    let root = f64::sqrt;
    let corners = [
        [-0.5, -root(3.0) / 6.0, 0.0],
        [0.5, -root(3.0) / 6.0, 0.0],
        [0.0, root(3.0) / 3.0, 0.0],
        [0.0, 0.0, root(2.0 / 3.0)],
    ];
    let centre = root(2.0 / 3.0) / 4.0;
    one_body(corners.map(|[x, y, z]| [x, y, z - centre]).to_vec(), vec![[0, 1, 2, 3]])
}

/// Two tetrahedra that meet as `kind` says: a vertex and a face, two edges, or two faces, each a little off
/// centre and aslant, all turned at random.
fn random_blow(kind: usize, number: u32, penalty: f64, safety: f64) -> Result<Met, String> {
    let random = &mut Random(1000 * kind as u64 + u64::from(number));
    let body = regular();
    let shaken = |body: &Body, random: &mut Random| {
        mapped(body, |place| place.map(|x| x + random.between(-0.08, 0.08)))
    };
    let flip = Turn::about([1.0, 0.0, 0.0], PI);
    // An edge down: the tetrahedron turned by half of the angle that the faces leave, about the edge.
    let edge = Turn::about([1.0, 0.0, 0.0], -0.5 * (PI - f64::acos(1.0 / 3.0)));
    let [below, above] = match kind {
        0 => [turned(&body, &flip, [0.0; 3]), turned(&body, &flip, [0.0; 3])],
        1 => [turned(&turned(&body, &edge, [0.0; 3]), &flip, [0.0; 3]), turned(&body, &edge, [0.0; 3])],
        _ => [turned(&body, &flip, [0.0; 3]), body],
    };
    let [below, above] = [below, above].map(|body| shaken(&body, random));
    // Turned about the line on which they meet.
    let above = turned(&above, &Turn::about([0.0, 0.0, 1.0], random.between(0.0, TAU)), [0.0; 3]);
    let end =
        |body: &Body, sign: f64| body.nodes.iter().map(|p| sign * p[2]).fold(f64::NEG_INFINITY, f64::max);
    let gap = end(&below, 1.0) + end(&above, -1.0) + 0.02;
    let shift = [random.between(-0.1, 0.1), random.between(-0.1, 0.1), gap];
    let turn = Turn::any(random);
    let above = turned(&mapped(&above, |place| plus(place, shift)), &turn, [0.0; 3]);
    let below = turned(&below, &turn, [0.0; 3]);
    let velocity = turn.of([random.between(-0.2, 0.2), random.between(-0.2, 0.2), -1.0].map(|x| 5.0 * x));
    let material = Material { poissons_ratio: 0.2, ..granite() };
    collide(&[below, above], velocity, material, penalty, safety)
}

/// Runs two bodies, the second of them moving, until they have met and parted.
fn collide(
    bodies: &[Body; 2],
    velocity: Point,
    material: Material,
    penalty: f64,
    safety: f64,
) -> Result<Met, String> {
    let counts = bodies.each_ref().map(|body| body.nodes.len());
    let mass = material.density * volume_of(&bodies[1]);
    let model = Model {
        velocities: [vec![[0.0; 3]; counts[0]], vec![velocity; counts[1]]].concat(),
        mesh: together(bodies),
        materials: vec![material],
        contact: ContactOptions { penalty, ..ContactOptions::default() },
        time: TimeOptions { safety, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    advance(&mut run, 1)?;
    let (before, momenta) = (run.energies(), momentum(&run));
    if run.counts().contacts > 0 {
        return Err("the bodies touch at the beginning".to_owned());
    }
    let (mut met, mut apart) = (false, 0);
    while apart < 400 {
        advance(&mut run, 1)?;
        let touches = run.counts().contacts > 0;
        met |= touches;
        apart = if met && !touches { apart + 1 } else { 0 };
        if run.penetrated().is_some() {
            return Err("one body is inside the other".to_owned());
        }
        if run.steps() > 1_000_000 {
            return Err("the bodies do not meet, or do not part".to_owned());
        }
    }
    let scale = mass * length(velocity);
    let momentum = change(&momenta, &momentum(&run), scale, 1.0);
    Ok(Met { before, after: run.energies(), momentum })
}

/// The tests of the book: equal tetrahedra with three edges of 2 m at right angles, with `E` = 1e11 Pa, `ν` =
/// 0, 1500 kg/m³, so that each weighs 2000 kg. One that flies at 550 m/s against one that is held (`T-C1`) or
/// free (`T-C2`), and one at 500 m/s between two that are held (`T-C3`). With a low penalty they go through
/// each other.
fn of_the_book() -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    for (name, held, speed, penalties) in [
        ("T-C1", [true, false], 550.0, [1e5, 1e7, 1e9, 1e11]),
        ("T-C2", [false, false], 550.0, [1e5, 1e7, 1e9, 1e11]),
        ("T-C3", [true, true], 500.0, [1e4, 1e7, 1e9, 1e11]),
    ] {
        let (mut worst, mut moved) = (0.0, 0.0);
        for penalty in penalties {
            let [energy, momentum, through] = book(held, speed, penalty)?;
            // A full overlap stores a fraction of the penalty times a volume of 1.33 m³; 3e8 J come.
            if (through > 0.0) != (penalty < 1e8) && !held[1] {
                return Err(format!("{name}: wrong way with a penalty of {penalty} Pa"));
            }
            worst = worse(energy, worst);
            moved = worse(momentum, moved);
        }
        let name = |what: &str| format!("{name}: {what}, worst of 4 penalties");
        outcomes.push(Outcome::absolute(name("change of the energy"), 0.0, worst, 1e-4, ""));
        if name("").contains("T-C2") {
            outcomes.push(Outcome::absolute(name("change of a momentum"), 0.0, moved, 1e-11, ""));
        }
    }
    Ok(outcomes)
}

/// Largest changes of the energy and of the momenta, over those of the beginning, and a number that is
/// positive if the flying body went through the other. `held`: whether the body below is held, and whether
/// another one above is.
fn book(held: [bool; 2], speed: f64, penalty: f64) -> Result<[f64; 3], String> {
    let corners = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]];
    let below = one_body(corners.to_vec(), vec![[0, 1, 2, 3]]);
    // Its right angle downwards, over the slanted face of the other.
    let mirrored = |at: Point| {
        let nodes = corners.map(|corner| std::array::from_fn(|axis| at[axis] - corner[axis])).to_vec();
        one_body(nodes, vec![[0, 1, 2, 3]])
    };
    let away = 0.9;
    let above = mirrored([2.0 / 3.0 + away + 0.67; 3]);
    let velocity = [-speed / f64::sqrt(3.0); 3];
    let mut bodies = vec![below, above];
    let mut fixed: Vec<u32> = if held[0] { (0..4).collect() } else { Vec::new() };
    if held[1] {
        let above = mapped(&bodies[0], |place| plus(place, [2.6; 3]));
        bodies.push(above);
        fixed.extend(8..12);
    }
    let material = Material { density: 1500.0, youngs_modulus: 100e9, ..granite() };
    let mass = 2000.0;
    let mut velocities = vec![[0.0; 3]; 4 * bodies.len()];
    velocities[4..8].fill(velocity);
    let boundaries = if fixed.is_empty() {
        Vec::new()
    } else {
        vec![Boundary {
            name: "held".to_owned(),
            target: Target::Nodes(fixed),
            load: Load::Velocity([Some(0.0); 3]),
            schedule: Schedule::Constant,
        }]
    };
    let model = Model {
        velocities,
        mesh: together(&bodies),
        materials: vec![material.clone()],
        boundaries,
        contact: ContactOptions { penalty: penalty / material.youngs_modulus, ..ContactOptions::default() },
        time: TimeOptions { safety: 0.02, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    advance(&mut run, 1)?;
    let (first, momenta) = (0.5 * mass * speed * speed, momentum(&run));
    let end = if held[1] { 40e-3 } else { 12e-3 };
    let (mut energy, mut touched) = (0.0, false);
    while run.time() < end {
        advance(&mut run, 50)?;
        touched |= run.counts().contacts > 0;
        let now = run.energies();
        energy = worse((now.kinetic + now.strain + now.contact) / first - 1.0, energy);
    }
    if !touched {
        return Err("the tetrahedra of the book do not meet".to_owned());
    }
    let [_, after] = mean_motion(&run, &[4, 5, 6, 7]);
    let through = dot(after, velocity) - if held[0] { 0.0 } else { 0.5 * speed * speed };
    Ok([energy, change(&momenta, &momentum(&run), mass * speed, 2.0), through])
}
