//! Adhesion of soft spheres, by the law of Johnson, Kendall and Roberts.
//!
//! With the reduced radius `R` and modulus `E` and the work of adhesion `w`:
//!
//! | | radius `a` of the contact | overlap | force |
//! |---|---|---|---|
//! | first contact | `a³ = 2 π w R²/E` | 0 | `-4/3 π w R` |
//! | without force | `a³ = 9/2 π w R²/E` | `a²/(3 R)` | 0 |
//! | largest pull | | | `-3/2 π w R` |
//! | parting | `a³ = π w R²/(8 E)` | `-3 a²/R` | `-5/6 π w R` |

use std::f64::consts::PI;

use fdem_grains::{GrainModel, GrainRun, Spheres, Surfaces};

use super::models::{material, start};
use crate::outcome::{Outcome, Size};

/// Reduced radius, m, and modulus, Pa, and the work of adhesion, J/m².
const RADIUS: f64 = 1e-3;
const MODULUS: f64 = 1e8;
const WORK: f64 = 0.05;

/// Overlap of a step, m.
const STEP: f64 = 2e-11;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let share = size.choose(1.0, 0.1);
    let pull_off = 1.5 * PI * WORK * RADIUS;
    let last = libm::cbrt(PI * WORK * RADIUS * RADIUS / (8.0 * MODULUS));
    let free = libm::cbrt(4.5 * PI * WORK * RADIUS * RADIUS / MODULUS);

    let mut nearing = led(-1.0, 2e-8, share)?;
    let mut jump = [0.0; 2];
    while jump == [0.0; 2] {
        jump = next(&mut nearing)?.unwrap_or_default();
        if nearing.steps() > 1_000_000 {
            return Err("the spheres do not touch".to_owned());
        }
    }

    let mut leaving = led(1.0, -3e-7, share)?;
    let mut states = Vec::new();
    while let Some(state) = next(&mut leaving)? {
        states.push(state);
    }
    let Some(parting) = states.last() else { return Err("the spheres do not stick".to_owned()) };
    let most = states.iter().map(|[_, force]| -force).fold(0.0, f64::max);
    let zero = states.iter().find(|[_, force]| *force <= 0.0).map_or(0.0, |[overlap, _]| *overlap);
    // The slope of the force is infinite where they part, so that this pull has a wide bound.
    Ok(vec![
        Outcome::absolute("overlap at which they jump into contact", 0.0, jump[0], 2.0 * STEP, "m"),
        Outcome::relative("pull after that", 8.0 / 9.0 * pull_off, -jump[1], 1e-3, "N"),
        Outcome::relative("largest pull", pull_off, most, 1e-5, "N"),
        Outcome::relative("overlap without force", free * free / (3.0 * RADIUS), zero, 1e-3, "m"),
        Outcome::relative(
            "radius of the contact without force",
            free,
            (3.0 * RADIUS * zero).sqrt(),
            1e-3,
            "m",
        ),
        Outcome::relative("overlap at which they part", -3.0 * last * last / RADIUS, parting[0], 1e-3, "m"),
        Outcome::relative("pull at which they part", 5.0 / 9.0 * pull_off, -parting[1], 2e-2, "N"),
    ])
}

/// Two spheres at a gap, m, negative for an overlap, of which one is led away from the other, or with the
/// sign -1 towards it, by a share of [`STEP`] each step.
fn led(sign: f64, gap: f64, share: f64) -> Result<GrainRun, String> {
    let step = 1e-6;
    start(GrainModel {
        spheres: Spheres {
            positions: vec![[0.0; 3], [4.0 * RADIUS + gap, 0.0, 0.0]],
            radii: vec![2.0 * RADIUS; 2],
            velocities: vec![[0.0; 3], [sign * share * STEP / step, 0.0, 0.0]],
            held: vec![true; 2],
            ..Spheres::default()
        },
        // Of two equal materials with Poisson's ratio 0.
        materials: vec![material(2.0 * MODULUS, 0.0, 1000.0)],
        surfaces: vec![Surfaces { adhesion: WORK, ..Surfaces::smooth([0, 0]) }],
        step: Some(step),
        ..GrainModel::default()
    })
}

/// Overlap, m, and force, N, of the two after a step; `None` if they do not touch.
fn next(run: &mut GrainRun) -> Result<Option<[f64; 2]>, String> {
    run.advance(1).map_err(|error| error.to_string())?;
    Ok(run.contacts().first().map(|contact| [contact.overlap, contact.normal]))
}
