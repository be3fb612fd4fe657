//! A hopper that empties: a cone under a tube. It flows faster than through a hole in a flat bottom, for
//! which Beverloo, Leniger and van de Velde (1961) found 0.58 ρ √g (D - 1.4 d)^2.5, with the density ρ of the
//! packing.

use fdem_grains::{GrainModel, Wall, WallShape};

use super::models::{GRAVITY, RADIUS, advance_to, mass, settled, start, tube_of_spheres};
use crate::outcome::{Outcome, Size};

/// Radii of the tube and of the orifice over the radius of the spheres.
const ACROSS: f64 = 10.0;
const ORIFICE: f64 = 6.0;

/// Share of the spheres that have left at the two times between which the flow is measured.
const SHARES: [f64; 2] = [0.15, 0.55];

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let model = filled(size.choose(8.0, 30.0))?;
    let step = model.safe_step();
    let (rate, fine) = (flow(&model, step)?, flow(&model, 0.5 * step)?);
    let sphere = mass(RADIUS, model.materials[0]);
    let density = 0.6 * model.materials[0].density;
    let width = 2.0 * RADIUS * (ORIFICE - 1.4);
    let beverloo = 0.58 * density * (GRAVITY * width.powi(5)).sqrt() / sphere;
    Ok(vec![
        Outcome::relative("spheres a second, two steps", fine, rate, 0.1, "1/s"),
        Outcome::relative("spheres a second, over those of a flat bottom", 1.3, rate / beverloo, 0.3, ""),
    ])
}

/// A hopper that is filled up to about `high` radii of the spheres above its cone, without its lid.
fn filled(high: f64) -> Result<GrainModel, String> {
    let mut model = tube_of_spheres(ACROSS, high, [0.5, 0.3]);
    // The cone is inclined by 60 degrees.
    let rise = RADIUS * (ACROSS - ORIFICE) * 3.0_f64.sqrt();
    model.spheres.positions.iter_mut().for_each(|place| place[2] += rise);
    model.walls.push(Wall {
        shape: WallShape::Cone {
            axis: [[0.0; 3], [0.0, 0.0, rise]],
            radii: [ORIFICE * RADIUS, ACROSS * RADIUS],
        },
        ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 1)
    });
    let run = settled(&model)?;
    model.spheres.positions = (0..model.spheres.radii.len()).map(|k| run.position(k)).collect();
    model.walls.remove(0);
    Ok(model)
}

/// Spheres that leave a hopper, 1/s.
fn flow(model: &GrainModel, step: f64) -> Result<f64, String> {
    let mut run = start(GrainModel { step: Some(step), ..model.clone() })?;
    let count = model.spheres.radii.len();
    let mut times = Vec::new();
    for share in SHARES {
        let wanted = (share * count as f64) as usize;
        let mut left = 0;
        while left < wanted {
            let end = run.time() + 2e-3;
            advance_to(&mut run, end)?;
            left = (0..count).filter(|&k| run.position(k)[2] < 0.0).count();
            if run.time() > 5.0 {
                return Err(format!("only {left} of {count} spheres have left the hopper"));
            }
        }
        times.push((run.time(), left as f64));
    }
    Ok((times[1].1 - times[0].1) / (times[1].0 - times[0].0))
}
