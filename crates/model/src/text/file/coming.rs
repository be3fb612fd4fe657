//! `[[insertion]]` and `[[delete]]`: spheres that come in during a run, and boxes that remove them.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::grains::GrainRadius;
use crate::text::file::vector::{Spin, Vector};

/// Spheres, in two dimensions discs, of one material that come in during the run at random places of a box:
/// `count` of them or a `mass`, one after the other at a `rate` or all at once. Each comes in where it
/// touches nothing; one that finds no room waits, and those after it wait, too.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereInsertion {
    /// Name of these spheres.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of their material.
    pub material: String,
    /// Number of spheres that come in, all together.
    #[serde(default)]
    #[schemars(range(min = 1, max = 20_000_000))]
    pub count: Option<usize>,
    /// Instead of `count`: mass of the spheres that come in, all together, kg. It is met as well as whole
    /// spheres can.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "kg"))]
    pub mass: Option<f64>,
    /// Spheres in a second, 1/s. Default: all come in at once.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1/s"))]
    pub rate: Option<f64>,
    /// Instead of `rate`: mass in a second, kg/s, as the mean over all of these spheres.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "kg/s"))]
    pub mass_rate: Option<f64>,
    /// Time at which the first one comes in, s. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "s"))]
    pub from: f64,
    /// Box in which the spheres come in as a whole.
    pub within: BoxRegion,
    /// Radius, m: a number; [least, most], all equally frequent; { mean = …, deviation = … }, a normal
    /// distribution, cut off at 3 deviations from the mean; or a grading curve [[radius, share], …], with the
    /// share of the mass of all smaller spheres, which is linear between the entries and ends with 1.
    pub radius: GrainRadius,
    /// Velocity [x, y] or [x, y, z] with which they come in, m/s. Default: rest.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m/s"))]
    pub velocity: Option<Vector>,
    /// Angular velocity with which they come in, degrees per second: a number in two dimensions,
    /// counter-clockwise; [x, y, z] in three, about that axis. Default: none.
    #[serde(default)]
    #[schemars(extend("x-unit" = "deg/s"))]
    pub spin: Option<Spin>,
    /// Seed of places and radii: another seed gives other ones. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
}

/// A box in which spheres are removed: those whose centre is in it. A clump is removed as a whole
/// when the centre of one of its spheres is in it.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereRemoval {
    /// Name of the box.
    #[schemars(length(min = 1))]
    pub name: String,
    /// The box.
    pub within: BoxRegion,
    /// Time from which it removes spheres, s. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "s"))]
    pub from: f64,
    /// Time until which it removes spheres, s. Default: the end of the run.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "s"))]
    pub until: Option<f64>,
}

/// A box along the axes, in two dimensions a rectangle.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "box_within")]
pub struct BoxRegion {
    /// Least corner [x, y] or [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub min: Vector,
    /// Greatest corner [x, y] or [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub max: Vector,
}

impl BoxRegion {
    /// Number of its dimensions: 2 or 3.
    pub(crate) fn dimensions(&self) -> u8 {
        if self.min.0.len() == 3 { 3 } else { 2 }
    }

    /// Whether it has no inside.
    pub(crate) fn is_flat(&self) -> bool {
        self.min.0.iter().zip(&self.max.0).any(|(min, max)| max <= min)
    }
}

fn seed() -> u64 {
    1
}
