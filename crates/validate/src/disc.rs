//! A disc that strikes a plane obliquely, and one that rolls or slides down an incline.
//!
//! A disc with the radius R has the moment of inertia m R²/2. While it slides, the friction µ N slows it and
//! turns it: in an impact that changes the normal velocity by Δv, its tangential velocity changes by µ Δv,
//! and that of its rim about its middle by twice as much. Down an incline it rolls with 2/3 g sin θ while tan
//! θ is below 3 µ; above it slides with g (sin θ − µ cos θ), and its rim turns ever faster, by 2 µ g cos θ.

use fdem_simulation::{ContactOptions, Material, Model, Schedule, Simulation};

use super::models::{advance, advance_to, disc, granite, moved, rectangle, start, together, turned};
use super::{Outcome, Size};

/// m.
const RADIUS: f64 = 0.1;

/// m/s².
const GRAVITY: f64 = 9.81;

/// A disc over a plane that is held as a whole.
struct Disc {
    run: Simulation,
    /// Number of its first node.
    first: u32,
}

impl Disc {
    /// A disc of `rings` rings just above a plane from `left` to `right`, in a model that `complete`
    /// completes.
    fn new(rings: usize, [left, right]: [f64; 2], complete: impl FnOnce(&mut Model)) -> Result<Self, String> {
        let edge = RADIUS / rings as f64;
        let cells = ((right - left) / edge).round() as usize;
        let plane = rectangle([left, -edge], [right, 0.0], [cells, 1]);
        let held = (0..plane.nodes.len() as u32).collect();
        let first = plane.nodes.len() as u32;
        // A node is its lowest point: on an edge the force would act beside the middle.
        let body = turned(&disc(RADIUS, rings), 0.0, [0.0, (1.0 + 1e-6) * RADIUS]);
        let mesh = together(&[plane, body]);
        let mut model = Model {
            mesh,
            boundaries: vec![moved("plane", held, [Some(0.0); 2], Schedule::Constant)],
            ..Model::default()
        };
        complete(&mut model);
        Ok(Self { run: start(model)?, first })
    }

    /// Mean velocity, and the velocity of the rim about the middle, clockwise: from momentum and angular
    /// momentum.
    fn motion(&self) -> ([f64; 2], f64) {
        let snapshot = self.run.snapshot();
        let mesh = &self.run.model().mesh;
        let own = mesh.elements.iter().zip(&snapshot.elements).filter(|(nodes, _)| nodes[0] >= self.first);
        let (mut all, mut place, mut velocity) = (0.0, [0.0; 2], [0.0; 2]);
        let mut corners = Vec::new();
        for (nodes, now) in own {
            let [a, b, c] = nodes.map(|node| mesh.nodes[node as usize]);
            let mass = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            for &node in now {
                let (x, v) = (snapshot.positions[node as usize], snapshot.velocities[node as usize]);
                all += mass;
                for axis in 0..2 {
                    place[axis] += mass * x[axis];
                    velocity[axis] += mass * v[axis];
                }
                corners.push((mass, x, v));
            }
        }
        let (place, velocity) = (place.map(|x| x / all), velocity.map(|v| v / all));
        let (mut spin, mut inertia) = (0.0, 0.0);
        for (mass, x, v) in corners {
            let (x, v) = ([x[0] - place[0], x[1] - place[1]], [v[0] - velocity[0], v[1] - velocity[1]]);
            spin += mass * (x[0] * v[1] - x[1] * v[0]);
            inertia += mass * (x[0] * x[0] + x[1] * x[1]);
        }
        (velocity, -RADIUS * spin / inertia)
    }
}

/// Discs that strike a plane at 1 m/s across it, and so fast along it that they slide all the time.
pub(super) fn oblique_impact(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let cases: &[(f64, f64)] = size.choose(&[(0.1, 1.0)], &[(0.1, 1.0), (0.2, 2.0), (0.3, 4.0)]);
    for &(friction, along) in cases {
        let rings = size.choose(8, 16);
        let mut disc = Disc::new(rings, [-RADIUS, 2.0 * RADIUS], |model| {
            let plane = |node: &[f64; 2]| node[1] <= 0.0;
            let velocity = |node| if plane(node) { [0.0; 2] } else { [along, -1.0] };
            model.velocities = model.mesh.nodes.iter().map(velocity).collect();
            model.materials = vec![Material { poissons_ratio: 0.2, friction, ..granite() }];
        })?;
        let (mut met, mut apart) = (false, 0);
        while apart < 50 {
            advance(&mut disc.run, 1)?;
            let touches = disc.run.counts().contacts > 0;
            met |= touches;
            apart = if met && !touches { apart + 1 } else { 0 };
            if disc.run.steps() > 100_000 {
                return Err("the disc does not meet the plane, or does not part from it".to_owned());
            }
        }
        let ([u, v], rim) = disc.motion();
        let name = |what: &str| format!("{what}, µ = {friction}, {along} m/s along the plane");
        outcomes.push(Outcome::relative(
            name("change of the tangential velocity over the normal"),
            friction,
            (along - u) / (v + 1.0),
            0.02,
            "",
        ));
        outcomes.push(Outcome::relative(
            name("velocity of the rim after"),
            2.0 * (along - u),
            rim,
            0.02,
            "m/s",
        ));
        let error = disc.run.energies().error();
        outcomes.push(Outcome::absolute(name("error of the energy balance"), 0.0, error, 1e-3, ""));
    }
    Ok(outcomes)
}

/// Discs on an incline: one rolls, one slides.
pub(super) fn on_an_incline(size: Size) -> Result<Vec<Outcome>, String> {
    let friction = 0.2;
    let mut outcomes = Vec::new();
    let angles: &[(f64, bool)] =
        size.choose(&[(15.0, true), (45.0, false)], &[(10.0, true), (25.0, true), (45.0, false)]);
    for &(degrees, rolls) in angles {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let [along, rim] = if rolls {
            [2.0 / 3.0 * GRAVITY * sin; 2]
        } else {
            [GRAVITY * (sin - friction * cos), 2.0 * friction * GRAVITY * cos]
        };
        let found = accelerations(degrees, friction, size)?;
        let name =
            |what: &str| format!("{what} at {degrees}°, where it {}", if rolls { "rolls" } else { "slides" });
        for (what, expected, found) in
            [("acceleration", along, found[0]), ("acceleration of the rim", rim, found[1])]
        {
            outcomes.push(Outcome::relative(name(what), expected, found, 0.02, "m/s²"));
        }
    }
    Ok(outcomes)
}

/// Slopes of the mean velocity along the plane and of that of the rim about the middle, m/s².
fn accelerations(degrees: f64, friction: f64, size: Size) -> Result<[f64; 2], String> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let ramp = 0.05;
    let mut disc = Disc::new(size.choose(10, 20), [-RADIUS, 1.0], |model| {
        // So soft that the contact is wider than an edge: the polygon acts as a disc.
        model.materials =
            vec![Material { youngs_modulus: 2e6, friction, damping: 0.2, poissons_ratio: 0.2, ..granite() }];
        model.contact =
            ContactOptions { penalty: 2.0, tangential_stiffness: 1.0, ..ContactOptions::default() };
        model.gravity = [GRAVITY * sin, -GRAVITY * cos];
        model.gravity_schedule = Schedule::Ramp(ramp);
    })?;
    advance_to(&mut disc.run, 2.0 * ramp)?;
    let mut points = Vec::new();
    while disc.run.time() < 0.4 {
        advance(&mut disc.run, 50)?;
        let ([u, _], rim) = disc.motion();
        points.push([disc.run.time(), u, rim]);
    }
    let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64;
    let time = mean(0);
    Ok([1, 2].map(|k| {
        let middle = mean(k);
        let (mut both, mut one) = (0.0, 0.0);
        for point in &points {
            both += (point[0] - time) * (point[k] - middle);
            one += (point[0] - time) * (point[0] - time);
        }
        both / one
    }))
}
