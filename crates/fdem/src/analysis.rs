//! What a contact network says: coordination, rattlers, directions, clusters, overlaps, packing fraction, radial distribution.
//!
//! ```text
//! Network ── analyse ──> Analysis
//!                          ├─ coordination, without_rattlers    contacts of an element
//!                          ├─ directions, fabric                where contacts point
//!                          ├─ clusters                          what hangs together, and from face to face
//!                          ├─ overlaps                          how deep, how far apart
//!                          ├─ packing                           how much of the space is filled
//!                          └─ radial                            how far centres are from each other
//! ```
//!
//! All sums run over the couples in their order: the result does not depend on threads. Contacts with walls are not in the network: elements
//! that rest on a wall have fewer contacts here than in the experiment.

mod clusters;
mod coordination;
mod directions;
mod fabric;
mod overlaps;
mod packing;
pub(crate) mod radial;
mod volumes;

use std::fmt;

use serde::Serialize;

pub use clusters::{ClusterSize, Clusters, Percolation};
pub use coordination::{Coordination, Frictionless, WithoutRattlers};
pub use directions::Directions;
pub use fabric::Fabric;
pub use overlaps::{Histogram, Overlaps, Spread};
pub use packing::PackingFraction;
pub use radial::Radial;
pub use volumes::{disc_in_rectangle, sphere_in_box};

use crate::network::Network;

/// What to analyse, and how.
///
/// # Units
/// Lengths in the unit of the centres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options<const D: usize> {
    /// Elements with fewer contacts are rattlers. Unless given it is chosen from the data ([`WithoutRattlers`]): `D + 1`, the fewest that hold an element without
    /// friction, or 2, the fewest that hold one with friction.
    pub min_contacts: Option<u32>,
    /// Where the packing fraction is measured, `[min, max]` of each axis. Unless given: as far as the box repeats, and the domain shrunk by the largest
    /// diameter on both sides along the other axes.
    pub inner: Option<[[f64; 2]; D]>,
    /// The radial distribution; [`RadialOptions::default`] is 3 mean diameters in 150 bins.
    pub radial: RadialOptions,
}

/// How the radial distribution is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadialOptions {
    /// The largest distance.
    pub r_max: Option<f64>,
    /// Bins of equal width.
    pub bins: Option<usize>,
}

/// What [`analyse`] finds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Analysis {
    /// Contacts of the elements.
    pub coordination: Coordination,
    /// The same after rattlers were removed repeatedly until none was left.
    pub without_rattlers: WithoutRattlers,
    /// Where contacts point.
    pub directions: Directions,
    /// Where they point on the whole; `None` without a contact that has a direction.
    pub fabric: Option<Fabric>,
    /// What hangs together.
    pub clusters: Clusters,
    /// How deep elements overlap, and how far they are apart where a tolerance makes couples of them.
    pub overlaps: Overlaps,
    /// How much of the space is filled; `None` for points.
    pub packing: Option<PackingFraction>,
    /// Why `packing` is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_packing: Option<String>,
    /// How far centres are from each other.
    pub radial: Option<Radial>,
    /// Why `radial` is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_radial: Option<String>,
}

/// Why a network cannot be analysed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnalysisError {
    /// The network is neither flat nor in space.
    Dimensions {
        /// How many it has.
        dimensions: usize,
    },
    /// The inner region is empty, or not of numbers.
    Region {
        /// The axis.
        axis: usize,
        /// Its limits.
        limits: [f64; 2],
    },
    /// The inner region has limits along the axes, and the box that repeats is sheared.
    ShearedBox,
    /// The largest distance, or the number of bins, cannot be.
    Radial {
        /// What is wrong.
        problem: String,
    },
    /// The search for the radial distribution was refused.
    Search(fdem_contact::Error),
}

impl fmt::Display for AnalysisError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dimensions { dimensions } => {
                write!(out, "networks in 2D and 3D are analysed, not in {dimensions}D")
            }
            Self::Region { axis, limits: [min, max] } => {
                write!(out, "the inner region is empty along axis {axis}: from {min} to {max}")
            }
            Self::ShearedBox => out.write_str(
                "an inner region has edges along the axes, and cannot be measured in a sheared box",
            ),
            Self::Radial { problem } => write!(out, "the radial distribution: {problem}"),
            Self::Search(error) => write!(out, "the radial distribution: {error}"),
        }
    }
}

impl std::error::Error for AnalysisError {}

/// Analyses a network.
///
/// # Cost
/// Linear in the couples, some 100 ns each, and one search for the pairs of centres within the largest distance of the radial distribution: some 150 per element
/// by default in a dense packing in 3D. Memory: some 50 bytes per element.
///
/// # Errors
/// [`AnalysisError`]. What has no meaning for the network, such as the packing fraction of points, is `None` and says why.
///
/// # Panics
/// If the couples are not of these elements.
///
/// # Source
/// The parts name theirs.
///
/// # Example
/// ```
/// use fdem::analysis::{Options, analyse};
/// use fdem::contact::{Engine, Elements, PeriodicBox, PeriodicSearch};
/// use fdem::network::{Couples, Network, Sizes, Space};
///
/// // One sphere in a cube that repeats: the simple cubic lattice.
/// let centres = [[0.5, 0.5, 0.5]];
/// let cell = PeriodicBox::orthogonal([0.0; 3], [1.0; 3], [true; 3])?;
/// let mut couples = Vec::new();
/// PeriodicSearch::new(Engine::Auto).couples(&Elements::spheres(&centres, 0.5)?, &cell, &mut couples)?;
/// let couples = Couples::Periodic(couples);
/// let space = Space { centres: &centres, cell: Some(cell) };
/// let analysis = analyse(&Network { space, sizes: Sizes::All(0.5), couples: &couples }, &Options::default())?;
/// assert_eq!(analysis.coordination.mean, 6.0);
/// assert!((analysis.packing.unwrap().fraction - std::f64::consts::PI / 6.0).abs() < 1e-15);
/// assert!(analysis.fabric.unwrap().anisotropy < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn analyse<const D: usize>(
    network: &Network<'_, D>,
    options: &Options<D>,
) -> Result<Analysis, AnalysisError> {
    if !(2..=3).contains(&D) {
        return Err(AnalysisError::Dimensions { dimensions: D });
    }
    let coordination = Coordination::of(network);
    let (packing, no_packing) = told(packing::fraction(network, options.inner)?);
    let (radial, no_radial) = told(radial::distribution(network, options.radial)?);
    Ok(Analysis {
        without_rattlers: WithoutRattlers::of(network, &coordination, options.min_contacts),
        coordination,
        directions: Directions::of(network),
        fabric: Fabric::of(network),
        clusters: Clusters::of(network),
        overlaps: Overlaps::of(network),
        packing,
        no_packing,
        radial,
        no_radial,
    })
}

/// What was found, or why nothing was.
fn told<T>(found: Result<T, String>) -> (Option<T>, Option<String>) {
    match found {
        Ok(found) => (Some(found), None),
        Err(reason) => (None, Some(reason)),
    }
}
