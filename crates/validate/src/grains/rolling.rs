//! A sphere that slides, rolls or twists on a plane, horizontal or not.

use fdem_grains::{GrainModel, GrainRun, Surfaces};

use super::models::{GRAVITY, advance_to, hertz_depth, mass, material, on_plane, reduced_modulus, start};
use crate::outcome::{Outcome, Size};

/// m.
const RADIUS: f64 = 0.05;

/// Steps from one look at a sphere to the next.
const STRIDE: u64 = 10;

/// A sphere that rests on a plane, which is inclined towards +x by an angle, degrees, at the overlap of its
/// weight. `velocity`: along x, m/s. It rolls if `rolls`, or else slides without turning.
fn model(degrees: f64, velocity: f64, rolls: bool, surfaces: Surfaces) -> GrainModel {
    let of = material(1e9, 0.3, 2500.0);
    let spin = if rolls { velocity / RADIUS } else { 0.0 };
    let mut model = on_plane(RADIUS, [velocity, 0.0, 0.0], [0.0, spin, 0.0], [of, of]);
    let (sin, cos) = libm::sincos(degrees.to_radians());
    model.gravity = [GRAVITY * sin, 0.0, -GRAVITY * cos];
    model.surfaces[0] = surfaces;
    let weight = mass(RADIUS, of) * GRAVITY * cos;
    model.spheres.positions[0][2] -= hertz_depth(weight, reduced_modulus([of, of]), RADIUS);
    model.step = Some(2e-5);
    model
}

/// Distance between the centre of the sphere and the plane, m: the arm of friction.
fn arm(model: &GrainModel) -> f64 {
    model.spheres.positions[0][2]
}

/// Surfaces with a restitution of 0.2 and two coefficients of friction: of sliding and of rolling.
fn surfaces(friction: f64, rolling_friction: f64) -> Surfaces {
    Surfaces {
        friction,
        rolling_friction,
        rolling_damping: 0.3,
        restitution: 0.2,
        ..Surfaces::smooth([0, 1])
    }
}

/// A sphere rolls to rest, and stays. It begins faster than 1 m/s, so that its spring against rolling has
/// yielded when it has that speed.
pub(crate) fn to_rest(_: Size) -> Result<Vec<Outcome>, String> {
    let slowing = 5.0 / 7.0 * 0.1 * GRAVITY;
    let mut run = start(model(0.0, 1.05, true, surfaces(0.5, 0.1)))?;
    let [from, begin] = slowed_to(&mut run, 1.0)?;
    let [_, end] = slowed_to(&mut run, 0.0)?;
    advance_to(&mut run, end + 1.0)?;
    let stopped = run.position(0)[0];
    advance_to(&mut run, end + 11.0)?;
    Ok(vec![
        Outcome::relative("time", 1.0 / slowing, end - begin, 2e-3, "s"),
        Outcome::relative("distance", 0.5 / slowing, stopped - from, 2e-3, "m"),
        Outcome::absolute("drift in 10 s at rest", 0.0, run.position(0)[0] - stopped, 1e-9, "m"),
    ])
}

/// Runs until the sphere has slowed down to a speed, m/s. Returns its place, m, and the time, s.
fn slowed_to(run: &mut GrainRun, speed: f64) -> Result<[f64; 2], String> {
    while run.velocity(0)[0] > speed {
        run.advance(STRIDE).map_err(|error| error.to_string())?;
        if run.time() > 3.0 {
            return Err(format!("the sphere does not slow down to {speed} m/s"));
        }
    }
    Ok([run.position(0)[0], run.time()])
}

/// A sphere on a slope: rests, rolls or slides.
pub(crate) fn on_a_slope(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    // Friction, rolling friction, and the tangents of slopes around the lower of the two.
    for (friction, resistance) in [(0.5, 0.1), (0.08, 0.1)] {
        let least = f64::min(friction, resistance);
        for share in size.choose(vec![0.97, 1.03], vec![0.9, 0.97, 0.99, 1.01, 1.03, 1.1]) {
            let run = at_slope(share * least, surfaces(friction, resistance))?;
            let quantity = format!("tangent {:.4}, friction {friction}, rolling {resistance}", share * least);
            if share < 1.0 {
                outcomes.push(Outcome::absolute(format!("speed: {quantity}"), 0.0, run[1], 1e-9, "m/s"));
            } else {
                let (sin, cos) = libm::sincos(libm::atan(share * least));
                let arm = arm(&model(0.0, 0.0, false, surfaces(friction, resistance))) / RADIUS;
                let expected = if friction < resistance {
                    GRAVITY * (sin - friction * cos)
                } else {
                    GRAVITY * (sin - resistance / arm * cos) / (1.0 + 0.4 / (arm * arm))
                };
                outcomes.push(Outcome::relative(
                    format!("acceleration: {quantity}"),
                    expected,
                    run[0],
                    1e-3,
                    "m/s²",
                ));
            }
        }
    }
    let slope = |degrees: f64| libm::tan(degrees.to_radians());
    for (degrees, friction) in [(20.0, 0.5), (20.0, 0.05)] {
        let (sin, cos) = libm::sincos(f64::to_radians(degrees));
        let [acceleration, _, turning] = at_slope(slope(degrees), surfaces(friction, 0.0))?;
        let arm = arm(&model(degrees, 0.0, false, surfaces(friction, 0.0))) / RADIUS;
        let slips = slope(degrees) > 3.5 * friction;
        let [expected, turns] = if slips {
            [GRAVITY * (sin - friction * cos), 2.5 * friction * GRAVITY * cos * arm]
        } else {
            let rolling = GRAVITY * sin / (1.0 + 0.4 / (arm * arm));
            [rolling, rolling / arm]
        };
        let of =
            format!("{degrees} degrees, friction {friction}, {}", if slips { "slipping" } else { "rolling" });
        outcomes.push(Outcome::relative(format!("acceleration: {of}"), expected, acceleration, 1e-3, "m/s²"));
        outcomes.push(Outcome::relative(
            format!("acceleration of the rim about the centre: {of}"),
            turns,
            RADIUS * turning,
            1e-3,
            "m/s²",
        ));
    }
    Ok(outcomes)
}

/// A sphere from rest on a slope with a tangent: its acceleration, m/s², its last speed, m/s, and its angular
/// acceleration, rad/s².
fn at_slope(tangent: f64, surfaces: Surfaces) -> Result<[f64; 3], String> {
    let degrees = libm::atan(tangent).to_degrees();
    let mut run = start(model(degrees, 0.0, false, surfaces))?;
    let speeds = |run: &GrainRun| [run.velocity(0)[0], run.spin(0)[1], run.time()];
    advance_to(&mut run, 1.0)?;
    let before = speeds(&run);
    advance_to(&mut run, 2.0)?;
    let after = speeds(&run);
    let time = after[2] - before[2];
    Ok([(after[0] - before[0]) / time, after[0], (after[1] - before[1]) / time])
}

/// A sphere that slides at first and rolls in the end.
pub(crate) fn slide_to_roll(_: Size) -> Result<Vec<Outcome>, String> {
    let model = model(0.0, 2.0, false, surfaces(0.2, 0.0));
    let arm = arm(&model);
    let mut run = start(model)?;
    while run.velocity(0)[0] - arm * run.spin(0)[1] > 1e-6 {
        run.advance(STRIDE).map_err(|error| error.to_string())?;
        if run.time() > 1.0 {
            return Err("the sphere does not roll".to_owned());
        }
    }
    let (speed, slowing) = (2.0, 0.2 * GRAVITY);
    let time = speed / (slowing * (1.0 + 2.5 * (arm / RADIUS).powi(2)));
    Ok(vec![
        Outcome::relative("time until it rolls", time, run.time(), 1e-3, "s"),
        Outcome::relative("speed then", speed - slowing * time, run.velocity(0)[0], 1e-3, "m/s"),
        Outcome::relative(
            "distance until it rolls",
            time * (speed - 0.5 * slowing * time),
            run.position(0)[0],
            1e-3,
            "m",
        ),
    ])
}

/// A sphere that spins about the normal comes to rest, and stays.
pub(crate) fn twisting(_: Size) -> Result<Vec<Outcome>, String> {
    const FRICTION: f64 = 0.05;
    const SPIN: f64 = 10.0;
    let surfaces = Surfaces { twisting_friction: FRICTION, ..surfaces(0.5, 0.0) };
    let mut model = model(0.0, 0.0, false, surfaces);
    // It begins faster, so that its spring has yielded when it has the speed.
    model.spheres.spins[0] = [0.0, 0.0, 1.05 * SPIN];
    let mut run = start(model)?;
    let mut spins = Vec::new();
    while run.time() < 1.5 {
        spins.push([run.time(), run.spin(0)[2]]);
        run.advance(STRIDE).map_err(|error| error.to_string())?;
    }
    let [begin, end] = [SPIN, 0.0].map(|spin| crossing(&spins, spin));
    let [angle, turned] = [[begin, end], [end + 0.5, 1.5]].map(|times| angle(&spins, times));
    let slowing = 2.5 * FRICTION * GRAVITY / RADIUS;
    let [x, y, _] = run.position(0);
    Ok(vec![
        Outcome::relative("time", SPIN / slowing, end - begin, 1e-3, "s"),
        Outcome::relative("angle", 0.5 * SPIN * SPIN / slowing, angle, 2e-3, ""),
        Outcome::absolute("angle in the second half of a second after", 0.0, turned, 1e-9, ""),
        Outcome::absolute("way aside", 0.0, x.hypot(y), 1e-12, "m"),
    ])
}

/// The time, s, at which a falling rate falls below a value. `rates`: times and rates.
fn crossing(rates: &[[f64; 2]], value: f64) -> f64 {
    let pair = rates.windows(2).find(|pair| pair[1][1] <= value);
    pair.map_or(f64::NAN, |pair| {
        let [[from, before], [to, after]] = [pair[0], pair[1]];
        from + (to - from) * (before - value) / (before - after)
    })
}

/// The integral of a rate over the samples in an interval of time, s. `rates`: times and rates.
fn angle(rates: &[[f64; 2]], [from, to]: [f64; 2]) -> f64 {
    let inside = rates.windows(2).filter(|pair| pair[0][0] >= from && pair[1][0] <= to);
    inside.map(|pair| 0.5 * (pair[1][0] - pair[0][0]) * (pair[0][1] + pair[1][1])).sum()
}
