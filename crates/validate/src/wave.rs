//! Waves in bars: speed, reflection at a free end, contact time and stress of two bars.

use fdem_simulation::{ContactOptions, Material, Model, Schedule, Simulation, Strength};

use super::models::{
    DENSITY, advance, advance_to, centroid, granite, mean_velocity, moved, nodes_where, rectangle, rock,
    start, together, turned,
};
use super::{Outcome, Size};

/// Wave speed √(E/ρ) of granite, m/s.
fn speed() -> f64 {
    f64::sqrt(granite().youngs_modulus / DENSITY)
}

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose(200, 400);
    let whole = piston(cells, None)?;
    let unbroken = Strength { tensile: 50e6, cohesion: 100e6, energy_i: 500.0, energy_ii: 2000.0, ..rock() };
    let breakable = piston(cells, Some(unbroken))?;
    let mut outcomes = vec![
        Outcome::relative("speed of the wave", speed(), whole.speed, 0.01, "m/s"),
        Outcome::relative("speed in a bar that could break", speed(), breakable.speed, 0.005, "m/s"),
        Outcome::absolute("joints put in", 0.0, breakable.joints as f64, 0.0, ""),
        Outcome::relative("velocity of the free end", 2.0, whole.free_end, 0.01, "m/s"),
        Outcome::absolute("error of the energy balance", 0.0, whole.balance, 1e-9, ""),
    ];
    outcomes.extend(two_bars(size.choose(100, 200))?);
    Ok(outcomes)
}

struct Pushed {
    speed: f64,
    free_end: f64,
    balance: f64,
    joints: usize,
}

/// A bar of 1 m that is pushed at its left end, at 1 m/s after a short ramp.
fn piston(cells: usize, strength: Option<Strength>) -> Result<Pushed, String> {
    let ramp = 4e-5;
    let mesh = rectangle([0.0, 0.0], [1.0, 4.0 / cells as f64], [cells, 4]);
    let at = |place: f64| nodes_where(&mesh, |[x, _]| (x - place).abs() < 1e-9);
    let (left, stations, right) = (at(0.0), [at(0.25), at(0.75)], at(1.0));
    let model = Model {
        mesh,
        materials: vec![Material { strength, ..granite() }],
        boundaries: vec![moved("piston", left, [Some(1.0), None], Schedule::Ramp(ramp))],
        ..Model::default()
    };
    let mut run = start(model)?;
    // Times at which the middle of the ramp passes the stations.
    let first = passes(&mut run, &stations[0], 0.5)?;
    let second = passes(&mut run, &stations[1], 0.5)?;
    // Times between which the wave returns from the free end.
    let (from, to) = (1.0 / speed() + 1.5 * ramp, 1.3 / speed() + 1.5 * ramp);
    advance_to(&mut run, from)?;
    let (mut sum, mut steps) = (0.0, 0);
    while run.time() < to {
        advance(&mut run, 1)?;
        sum += mean_velocity(&run, &right)[0];
        steps += 1;
    }
    Ok(Pushed {
        speed: 0.5 / (second - first),
        free_end: sum / f64::from(steps),
        balance: run.energies().error(),
        joints: run.counts().joints,
    })
}

/// Time at which nodes reach a velocity along x, s, interpolated between two steps.
fn passes(run: &mut Simulation, nodes: &[u32], velocity: f64) -> Result<f64, String> {
    let mut before = mean_velocity(run, nodes)[0];
    while run.time() < 2.0 / speed() {
        advance(run, 1)?;
        let after = mean_velocity(run, nodes)[0];
        if after >= velocity {
            return Ok(run.time() - (after - velocity) / (after - before) * run.time_step());
        }
        before = after;
    }
    Err("the wave never arrives".to_owned())
}

/// Two bars that meet at 10 m/s: contact time, and stress behind the wave.
fn two_bars(cells: usize) -> Result<[Outcome; 2], String> {
    let (length, meeting) = (0.5, 10.0);
    let height = 4.0 * length / cells as f64;
    let left = rectangle([0.0, 0.0], [length, height], [cells, 4]);
    let right = turned(&left, 0.0, [length + 1e-7, 0.0]);
    let half = [0.5 * meeting, 0.0];
    let velocities = [vec![half; left.nodes.len()], vec![half.map(|v| -v); right.nodes.len()]].concat();
    // Elements of the left bar behind the first wave and before the reflected one, at the time when the wave
    // reaches the end.
    let inside: Vec<usize> = (0..left.elements.len())
        .filter(|&element| (0.6 * length..0.8 * length).contains(&centroid(&left, element)[0]))
        .collect();
    let model = Model {
        mesh: together(&[left, right]),
        velocities,
        materials: vec![granite()],
        contact: ContactOptions { penalty: 10.0, ..ContactOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    while run.counts().contacts == 0 {
        advance(&mut run, 1)?;
        if run.time() > 1e-6 {
            return Err("the bars do not meet".to_owned());
        }
    }
    let (began, transit) = (run.time(), length / speed());
    let (mut ended, mut stress) = (began, None);
    while run.time() < began + 3.0 * transit {
        advance(&mut run, 1)?;
        if run.counts().contacts > 0 {
            ended = run.time();
        }
        if stress.is_none() && run.time() >= began + transit {
            let stresses = run.snapshot().stresses;
            stress = Some(inside.iter().map(|&e| stresses[e][0]).sum::<f64>() / inside.len() as f64);
        }
    }
    let expected = -0.5 * DENSITY * speed() * meeting;
    Ok([
        Outcome::relative("time in contact of two bars", 2.0 * transit, ended - began, 0.02, "s"),
        Outcome::relative("stress in two bars", expected, stress.unwrap_or(f64::NAN), 0.02, "Pa"),
    ])
}
