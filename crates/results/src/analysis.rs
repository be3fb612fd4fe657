//! Analysis of contact networks: coordination, rattlers, directions, clusters, overlaps, packing fraction,
//! radial distribution.
//!
//! ```text
//! Network ── analyse ──> Analysis
//!                          ├─ coordination, without_rattlers    contacts per element
//!                          ├─ directions, fabric                directions of contacts
//!                          ├─ clusters                          connected elements, percolation
//!                          ├─ overlaps                          overlaps and gaps
//!                          ├─ packing                           filled fraction of the space
//!                          └─ radial                            distances between centres
//! ```
//!
//! All sums run over the couples in their order, so that the result does not depend on threads. The network
//! does not include contacts with walls: elements that rest on a wall have fewer contacts here than in the
//! experiment.

mod clusters;
mod coordination;
mod directions;
mod error;
mod fabric;
mod overlaps;
mod packing;
pub(crate) mod radial;
mod volumes;

use serde::Serialize;

pub use clusters::{ClusterSize, Clusters, Percolation};
pub use coordination::{Coordination, Frictionless, WithoutRattlers};
pub use directions::Directions;
pub use error::AnalysisError;
pub use fabric::Fabric;
pub use overlaps::{Histogram, Overlaps, Spread};
pub use packing::PackingFraction;
pub use radial::{Radial, RadialOptions};
pub use volumes::{disc_in_rectangle, sphere_in_box};

use crate::network::Network;

/// Options of an analysis.
///
/// # Units
/// Lengths in the unit of the centres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options<const D: usize> {
    /// Elements with fewer contacts are rattlers. By default the number is chosen from the data
    /// ([`WithoutRattlers`]): `D + 1`, the fewest contacts that hold an element without friction, or 2, the
    /// fewest that hold one with friction.
    pub min_contacts: Option<u32>,
    /// Region in which the packing fraction is measured, `[min, max]` of each axis. By default the whole box
    /// along periodic axes, and along the other axes the domain shrunk by the largest diameter on both sides.
    pub inner: Option<[[f64; 2]; D]>,
    /// Options of the radial distribution.
    pub radial: RadialOptions,
}

/// Result of [`analyse`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Analysis {
    /// Contacts of the elements.
    pub coordination: Coordination,
    /// Contacts of the elements after rattlers are removed repeatedly until none is left.
    pub without_rattlers: WithoutRattlers,
    /// Directions of the contacts.
    pub directions: Directions,
    /// Fabric tensor; `None` if no contact has a direction.
    pub fabric: Option<Fabric>,
    /// Connected components and percolation.
    pub clusters: Clusters,
    /// Overlaps of the couples, and gaps between those within the tolerance.
    pub overlaps: Overlaps,
    /// Packing fraction; `None` for points, for example.
    pub packing: Option<PackingFraction>,
    /// Why `packing` is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_packing: Option<String>,
    /// Radial distribution of the centres.
    pub radial: Option<Radial>,
    /// Why `radial` is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_radial: Option<String>,
}

/// Analyses a network.
///
/// # Cost
/// Linear in the couples, some 100 ns each, and one search for the pairs of centres within the largest
/// distance of the radial distribution, by default some 150 pairs per element in a dense packing in 3D.
/// Memory: some 50 bytes per element.
///
/// # Errors
/// [`AnalysisError`]. A result that has no meaning for the network, such as the packing fraction of points,
/// is no error: it is `None`, with a reason.
///
/// # Panics
/// If the couples were not found among these elements.
///
/// # Source
/// See the types of the results.
///
/// # Example
/// ```
/// use fdem_results::analysis::{Options, analyse};
/// use fdem_contact::{Engine, Elements, PeriodicBox, PeriodicSearch};
/// use fdem_results::network::{Couples, Network, Sizes, Space};
///
/// // One sphere in a periodic cube: the simple cubic lattice.
/// let centres = [[0.5, 0.5, 0.5]];
/// let cell = PeriodicBox::orthogonal([0.0; 3], [1.0; 3], [true; 3])?;
/// let mut couples = Vec::new();
/// PeriodicSearch::new().couples(&Elements::spheres(&centres, 0.5)?, &cell, &mut couples)?;
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

/// Splits a result into its value and the reason why it is missing.
fn told<T>(found: Result<T, String>) -> (Option<T>, Option<String>) {
    match found {
        Ok(found) => (Some(found), None),
        Err(reason) => (None, Some(reason)),
    }
}
