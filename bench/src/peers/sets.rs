//! The sets of bodies on which the searches are compared.

use fdem_scenes::{Boxes, Cloud, Error, Sizes};

use super::{Bodies, EngineKind};

/// Distance at which two points are a couple, in all sets of points.
pub const CUTOFF: f64 = 1.0;
const SEED: u64 = 1;
/// Position of the outlier, in cut-offs along each axis.
const FAR: f64 = 1e6;

/// The generator of a set, for any number of bodies.
pub enum Scene {
    /// A generator in 3D.
    Space(fn(usize) -> Result<Made<3>, Error>),
    /// A generator in 2D.
    Plane(fn(usize) -> Result<Made<2>, Error>),
}

/// The bodies of a set.
pub enum Made<const D: usize> {
    /// Points with the cut-off [`CUTOFF`].
    Points(Vec<[f64; D]>),
    /// Spheres of unlike sizes.
    Spheres(Cloud<D>),
    /// Boxes.
    Boxes(Boxes<D>),
}

impl<const D: usize> Made<D> {
    /// The bodies as a view for searches.
    #[must_use]
    pub fn bodies(&self) -> Bodies<'_, D> {
        match self {
            Self::Points(points) => Bodies::Points { points, cutoff: CUTOFF },
            Self::Spheres(cloud) => Bodies::Spheres { centres: &cloud.centres, radii: &cloud.radii },
            Self::Boxes(boxes) => Bodies::Boxes { min: &boxes.min, max: &boxes.max },
        }
    }
}

/// The kinds of bodies, each with its own table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Points with one cut-off.
    Points,
    /// Spheres of unlike sizes.
    Unlike,
    /// Boxes.
    Boxes,
}

impl Group {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Points, Self::Unlike, Self::Boxes];

    /// The name in headings.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Unlike => "unlike sizes",
            Self::Boxes => "boxes",
        }
    }

    /// The kinds of our searches that take part by default.
    #[must_use]
    pub const fn kinds(self) -> &'static [EngineKind] {
        match self {
            Self::Points => &EngineKind::OF_POINTS,
            Self::Unlike | Self::Boxes => &EngineKind::OF_UNLIKE,
        }
    }
}

/// A set of bodies.
pub struct Set {
    /// The name on the command line and in the tables.
    pub name: &'static str,
    /// A short title.
    pub title: &'static str,
    /// Number of bodies.
    pub n: usize,
    /// The table that contains it.
    pub group: Group,
    /// The ratio of the largest to the smallest size, for sets that vary it.
    pub ratio: Option<f64>,
    /// The generator.
    pub scene: Scene,
}

const MILLION: usize = 1_000_000;

const fn points(name: &'static str, title: &'static str, n: usize, scene: Scene) -> Set {
    Set { name, title, n, group: Group::Points, ratio: None, scene }
}

const fn unlike(name: &'static str, title: &'static str, n: usize, scene: Scene) -> Set {
    Set { name, title, n, group: Group::Unlike, ratio: None, scene }
}

macro_rules! ratio {
    ($name:literal, $ratio:literal, $written:literal) => {
        Set {
            name: $name,
            title: concat!("power law, radii 1 to ", $written, ", 4 neighbours"),
            n: MILLION,
            group: Group::Unlike,
            ratio: Some($ratio),
            scene: Scene::Space(|n| Ok(Made::Spheres(fdem_scenes::peers::unlike(n, SEED, $ratio)?))),
        }
    };
}

/// All sets.
pub const SETS: [Set; 15] = [
    points("gas100k", "gas, 12 neighbours, 100,000", 100_000, Scene::Space(|n| Ok(Made::Points(gas(n)?)))),
    points("gas1m", "gas, 12 neighbours, 1,000,000", MILLION, Scene::Space(|n| Ok(Made::Points(gas(n)?)))),
    points(
        "dense1m",
        "dense, 80 neighbours, 1,000,000",
        MILLION,
        Scene::Space(|n| Ok(Made::Points(fdem_scenes::peers::dense(n, SEED)?.centres))),
    ),
    points(
        "sparse1m",
        "1,000 clusters of 1,000, 1e5 wide",
        MILLION,
        Scene::Space(|n| Ok(Made::Points(fdem_scenes::peers::sparse(n, SEED)?.centres))),
    ),
    points(
        "outlier1m",
        "gas 1,000,000, one point 1e6 away",
        MILLION,
        Scene::Space(|n| {
            let mut points = gas(n)?;
            points[n / 2] = [FAR; 3];
            Ok(Made::Points(points))
        }),
    ),
    points(
        "gas2d1m",
        "2D: gas, 12 neighbours, 1,000,000",
        MILLION,
        Scene::Plane(|n| {
            Ok(Made::Points(fdem_scenes::gas(n, SEED, 12.0, Sizes::Equal { radius: 0.5 })?.centres))
        }),
    ),
    unlike(
        "poly400k",
        "power law, radii 1 to 50, 400,000",
        400_000,
        Scene::Space(|n| Ok(Made::Spheres(fdem_scenes::peers::poly(n, SEED)?))),
    ),
    unlike(
        "logn1m",
        "lognormal, sigma 0.25, 1,000,000",
        MILLION,
        Scene::Space(|n| Ok(Made::Spheres(fdem_scenes::peers::lognormal(n, SEED)?))),
    ),
    ratio!("ratio1", 1.0, "1"),
    ratio!("ratio3", 3.0, "3"),
    ratio!("ratio10", 10.0, "10"),
    ratio!("ratio30", 30.0, "30"),
    ratio!("ratio100", 100.0, "100"),
    ratio!("ratio1000", 1000.0, "1000"),
    Set {
        name: "boxes1m",
        title: "boxes, aspect 1 to 100, 1,000,000",
        n: MILLION,
        group: Group::Boxes,
        ratio: None,
        scene: Scene::Space(|n| Ok(Made::Boxes(fdem_scenes::peers::boxes(n, SEED)?))),
    },
];

/// `n` points in 3D with 12 neighbours each.
///
/// # Errors
/// The errors of [`fdem_scenes::peers::gas`].
pub fn gas(n: usize) -> Result<Vec<[f64; 3]>, Error> {
    Ok(fdem_scenes::peers::gas(n, SEED)?.centres)
}
