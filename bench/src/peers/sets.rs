//! The sets of points that the searches are compared on.

use fdem_scenes::{Error, Sizes};

/// Distance at which two points are a couple, in all sets.
pub const CUTOFF: f64 = 1.0;
const SEED: u64 = 1;
/// Where the outlier is, in cut-offs along each axis.
const FAR: f64 = 1e6;

/// How a set is made, for any number of points.
pub enum Scene {
    /// In 3D.
    Space(fn(usize) -> Result<Vec<[f64; 3]>, Error>),
    /// In 2D.
    Plane(fn(usize) -> Result<Vec<[f64; 2]>, Error>),
}

/// A set of points.
pub struct Set {
    /// On the command line and in the tables.
    pub name: &'static str,
    /// In a few words.
    pub title: &'static str,
    /// Points.
    pub n: usize,
    /// How it is made.
    pub scene: Scene,
}

/// All of them.
pub const SETS: [Set; 6] = [
    Set { name: "gas100k", title: "gas, 12 neighbours, 100,000", n: 100_000, scene: Scene::Space(gas) },
    Set { name: "gas1m", title: "gas, 12 neighbours, 1,000,000", n: 1_000_000, scene: Scene::Space(gas) },
    Set {
        name: "dense1m",
        title: "dense, 80 neighbours, 1,000,000",
        n: 1_000_000,
        scene: Scene::Space(|n| Ok(fdem_scenes::peers::dense(n, SEED)?.centres)),
    },
    Set {
        name: "sparse1m",
        title: "1,000 clusters of 1,000, 1e5 wide",
        n: 1_000_000,
        scene: Scene::Space(|n| Ok(fdem_scenes::peers::sparse(n, SEED)?.centres)),
    },
    Set {
        name: "outlier1m",
        title: "gas 1,000,000, one point 1e6 away",
        n: 1_000_000,
        scene: Scene::Space(|n| {
            let mut points = gas(n)?;
            points[n / 2] = [FAR; 3];
            Ok(points)
        }),
    },
    Set {
        name: "gas2d1m",
        title: "2D: gas, 12 neighbours, 1,000,000",
        n: 1_000_000,
        scene: Scene::Plane(|n| Ok(fdem_scenes::gas(n, SEED, 12.0, Sizes::Equal { radius: 0.5 })?.centres)),
    },
];

/// `n` points in 3D with 12 neighbours each.
///
/// # Errors
/// Those of [`fdem_scenes::peers::gas`].
pub fn gas(n: usize) -> Result<Vec<[f64; 3]>, Error> {
    Ok(fdem_scenes::peers::gas(n, SEED)?.centres)
}
