//! Analysis of contact networks: coordination, rattlers, directions, clusters, overlaps, packing fraction,
//! radial distribution.
//!
//! ```text
//! Network ── analyse ──> Analysis
//!                          ├─ coordination, without_rattlers    contacts per element
//!                          ├─ directions, fabric                directions of contacts
//!                          ├─ clusters                          connected elements, percolation
//!                          ├─ overlaps                          overlaps and gaps
//!                          ├─ forces                            mean force, stress, strong couples
//!                          ├─ packing                           filled fraction of the space
//!                          ├─ voids                             local void ratios, sizes of pores
//!                          └─ radial                            distances between centres
//! ```
//!
//! All sums run over parts of the couples of a fixed length and then over the parts, each in their order, so
//! that the result does not depend on the number of threads. The network does not include contacts with
//! walls: elements that rest on a wall have fewer contacts here than in the experiment.

mod around;
mod clusters;
mod coordination;
mod directions;
mod domain_frame;
mod error;
mod fabric;
mod forces;
mod overlaps;
mod packing;
mod parts;
mod placed;
mod polytope;
pub(crate) mod radial;
mod voids;
mod volumes;

use std::any::Any;
use std::sync::atomic::AtomicU64;

use fdem_contact::Couple;
use serde::Serialize;

pub use clusters::{ClusterSize, Clusters, Percolation};
pub use coordination::{Coordination, Frictionless, WithoutRattlers};
pub use directions::Directions;
pub use error::AnalysisError;
pub use fabric::Fabric;
pub use forces::Forces;
pub use overlaps::{Histogram, Overlaps, Spread};
pub use packing::PackingFraction;
pub use radial::{Radial, RadialOptions};
pub use voids::Voids;
pub use volumes::{disc_in_rectangle, sphere_in_box};

use crate::analysis::directions::DirectionCounts;
use crate::analysis::fabric::FabricSum;
use crate::analysis::packing::{LensSum, Region};
use crate::analysis::parts::Team;
use crate::analysis::placed::{Placed, distance};
use crate::arrays::each;
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
    /// Whether the voids are measured, which takes some 20 µs for each element.
    pub voids: bool,
    /// Number of threads; 0 is one per processor. The result does not depend on it.
    pub threads: usize,
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
    /// Forces and the stress that follows from them; `None` without forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forces: Option<Forces>,
    /// Packing fraction; `None` for points, for example.
    pub packing: Option<PackingFraction>,
    /// Why `packing` is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_packing: Option<String>,
    /// Local void ratios and sizes of pores; `None` unless they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voids: Option<Voids>,
    /// Why `voids` is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_voids: Option<String>,
    /// Radial distribution of the centres.
    pub radial: Option<Radial>,
    /// Why `radial` is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_radial: Option<String>,
}

/// Analyses a network.
///
/// # Cost
/// Linear in the couples, some 100 ns each on one thread, and one search for the pairs of centres within the
/// largest distance of the radial distribution, by default some 150 pairs per element in a dense packing in
/// 3D. Memory: some 100 bytes per element and 16 per couple.
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
/// let analysis = analyse(&Network { space, sizes: Sizes::All(0.5), couples: &couples, forces: None }, &Options::default())?;
/// assert_eq!(analysis.coordination.mean, 6.0);
/// assert!((analysis.packing.unwrap().fraction - std::f64::consts::PI / 6.0).abs() < 1e-15);
/// assert!(analysis.fabric.unwrap().anisotropy < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn analyse<const D: usize>(
    network: &Network<'_, D>,
    options: &Options<D>,
) -> Result<Analysis, AnalysisError> {
    analyse_counted(network, options, &AtomicU64::new(0))
}

/// [`analyse`] that counts in `handled` the couples, pairs and elements that it has handled, those of each
/// pass, for a display of its progress.
///
/// # Errors
/// The errors of [`analyse`].
///
/// # Panics
/// Where [`analyse`] panics.
pub fn analyse_counted<const D: usize>(
    network: &Network<'_, D>,
    options: &Options<D>,
    handled: &AtomicU64,
) -> Result<Analysis, AnalysisError> {
    // Functions without parameters are compiled here and not where they are called: that crate may not be
    // optimised.
    fn plane(
        network: &Network<'_, 2>,
        options: &Options<2>,
        handled: &AtomicU64,
    ) -> Result<Analysis, AnalysisError> {
        analyse_in(network, options, handled)
    }

    fn space(
        network: &Network<'_, 3>,
        options: &Options<3>,
        handled: &AtomicU64,
    ) -> Result<Analysis, AnalysisError> {
        analyse_in(network, options, handled)
    }

    let options = options as &dyn Any;
    if let (Some(network), Some(options)) = (network.of_dimension(), options.downcast_ref()) {
        return plane(&network, options, handled);
    }
    if let (Some(network), Some(options)) = (network.of_dimension(), options.downcast_ref()) {
        return space(&network, options, handled);
    }
    Err(AnalysisError::Dimensions { dimensions: D })
}

fn analyse_in<const D: usize>(
    network: &Network<'_, D>,
    options: &Options<D>,
    handled: &AtomicU64,
) -> Result<Analysis, AnalysisError> {
    let placed = &Placed::of(network, Team::new(options.threads, handled));
    let region = Region::of(placed, options.inner)?;
    let parts = of_couples(placed, region.as_ref().ok());
    let lenses = parts.iter().map(|part| part.lenses);
    let (voids, no_voids) = match &region {
        _ if !options.voids => (None, None),
        Err(reason) => (None, Some(reason.clone())),
        Ok(region) => told(voids::voids(placed, region)?),
    };
    let (packing, no_packing) = told(region.and_then(|region| region.fraction(&placed.team, lenses)));
    let (radial, no_radial) = told(radial::distribution(placed, options.radial)?);
    // These two go from element to element, each on one thread.
    let ((coordination, without_rattlers), clusters) = placed.team.both(
        || {
            let coordination = Coordination::of(network);
            let without_rattlers = WithoutRattlers::of(network, &coordination, options.min_contacts);
            (coordination, without_rattlers)
        },
        || Clusters::of(placed),
    );
    let overlaps: Vec<_> = parts.iter().map(|part| part.overlaps.as_slice()).collect();
    Ok(Analysis {
        coordination,
        without_rattlers,
        directions: Directions::of::<D>(parts.iter().map(|part| &part.directions)),
        fabric: Fabric::of(parts.iter().map(|part| &part.fabric)),
        clusters,
        overlaps: Overlaps::of(network, &overlaps),
        forces: Forces::of(placed),
        packing,
        no_packing,
        voids,
        no_voids,
        radial,
        no_radial,
    })
}

/// Sums over a part of the couples.
struct OfCouples<const D: usize> {
    directions: DirectionCounts,
    fabric: FabricSum<D>,
    overlaps: Vec<f64>,
    lenses: LensSum,
}

/// The sums over each part of the couples. All are made in one pass, because most of its time is that of
/// getting the centres from memory.
fn of_couples<const D: usize>(placed: &Placed<'_, D>, region: Option<&Region<'_, D>>) -> Vec<OfCouples<D>> {
    let sizes = placed.network.sizes;
    placed.fold(
        || OfCouples {
            directions: DirectionCounts::new::<D>(),
            fabric: FabricSum::NONE,
            overlaps: Vec::new(),
            lenses: LensSum::default(),
        },
        |part, couple| {
            let [a, b] = placed.ends(couple);
            let normal = directions::unit(each(|axis| b[axis] - a[axis]));
            part.directions.add(normal);
            part.fabric.add(normal);
            let distance = distance([a, b]);
            part.overlaps.push(sizes.contact_distance(Couple { i: couple.i, j: couple.j }) - distance);
            if let Some(region) = region {
                let radii = [sizes.radius(couple.i as usize), sizes.radius(couple.j as usize)];
                region.add(&mut part.lenses, radii, [a, b], distance);
            }
        },
    )
}

/// Splits a result into its value and the reason why it is missing.
fn told<T>(found: Result<T, String>) -> (Option<T>, Option<String>) {
    match found {
        Ok(found) => (Some(found), None),
        Err(reason) => (None, Some(reason)),
    }
}
