//! Pressure on the bottom of a silo, which walls with friction relieve (Janssen 1895).
//!
//! The bottom bears the share (1 - exp(-x))/x of the weight, with x = 4 K µ h/D for a height h, a diameter D,
//! a friction µ of the walls and a ratio K of the pressures across and along the axis. The bottom sinks
//! slowly, so that the friction of the walls acts upwards everywhere.

use super::models::{GRAVITY, RADIUS, mass, settled, start, tube_of_spheres};
use crate::outcome::{Outcome, Size};

/// Radius of the tube over that of the spheres.
const ACROSS: f64 = 6.0;

/// Friction of the walls.
const FRICTION: f64 = 0.4;

/// Speed of the bottom, m/s, and the time for which it sinks, s: by nearly two spheres.
const SINKING: f64 = 0.02;
const TIME: f64 = 0.45;

/// Ratio of the pressures, and how far it may be from it: as measured, between the active limit of a bed, a
/// third, and somewhat more than 1, to which walls with friction raise it.
const RATIO: f64 = 0.9;
const RATIO_BOUND: f64 = 0.3;

/// Height, over the diameter, of the bed from which the ratio is found.
const MEASURED: f64 = 2.0;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let [smooth, _] = bottom(1.0, 0.0)?;
    let [load, height] = bottom(MEASURED, FRICTION)?;
    let ratio = exponent(load) / (4.0 * FRICTION * height);
    let mut outcomes = vec![
        Outcome::relative("load on the bottom over the weight, smooth walls", 1.0, smooth, 1e-2, ""),
        Outcome::absolute(
            format!("pressure across over that along, height {MEASURED} D"),
            RATIO,
            ratio,
            RATIO_BOUND,
            "",
        ),
    ];
    for high in size.choose(vec![1.0], vec![1.0, 3.0, 4.0]) {
        let [share, height] = bottom(high, FRICTION)?;
        let x = 4.0 * ratio * FRICTION * height;
        outcomes.push(Outcome::relative(
            format!("load on the bottom over the weight, height {high} D, with this ratio"),
            (1.0 - libm::exp(-x)) / x,
            share,
            0.15,
            "",
        ));
    }
    Ok(outcomes)
}

/// Fills a silo up to about `high` diameters, and lowers its bottom. Returns the mean load on the bottom over
/// the weight after a third of the time, and the height over the diameter.
fn bottom(high: f64, friction: f64) -> Result<[f64; 2], String> {
    let mut model = tube_of_spheres(ACROSS, 2.0 * ACROSS * high, [0.5, friction]);
    let filled = settled(&model)?;
    let count = model.spheres.radii.len();
    model.spheres.positions = (0..count).map(|k| filled.position(k)).collect();
    model.walls[0].velocity = [0.0, 0.0, -SINKING];
    let weight: f64 =
        model.spheres.radii.iter().map(|&radius| mass(radius, model.materials[0]) * GRAVITY).sum();
    let centre = model.spheres.positions.iter().map(|of| of[2]).sum::<f64>() / count as f64;
    let mut run = start(model)?;
    let (mut load, mut steps) = (0.0, 0.0);
    while run.time() < TIME {
        // The walls' loads of some steps are enough for a mean.
        run.advance(10).map_err(|error| error.to_string())?;
        if run.time() > TIME / 3.0 {
            load -= run.wall_force(0)[2];
            steps += 1.0;
        }
    }
    // The tube has the diameter 2 ACROSS RADIUS, and the bed twice the height of its centre.
    Ok([load / steps / weight, centre / (ACROSS * RADIUS)])
}

/// The x whose share (1 - exp(-x))/x is given.
fn exponent(share: f64) -> f64 {
    let (mut low, mut high) = (1e-9, 100.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if (1.0 - libm::exp(-middle)) / middle > share {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
