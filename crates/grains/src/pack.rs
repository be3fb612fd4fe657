//! Packings: spheres of given sizes at random places of a region, without overlap.
//!
//! Sparse ones are inserted one after the other. Dense ones are inserted smaller than they are, get their
//! sizes, and push each other apart. The result is a function of the request alone: it has the same bits on
//! any number of threads and on every machine.

pub(crate) mod closed;
pub(crate) mod insert;
pub(crate) mod region;
pub(crate) mod relax;
pub(crate) mod sizes;

use std::fmt;
use std::sync::Arc;

use crate::pack::insert::{Wanted, insert};
use crate::pack::region::PackRegion;
use crate::pack::relax::{MARGIN, Relaxing};
use crate::pack::sizes::{SphereSizes, measure};
use crate::vector::Vector;

/// Spheres of a packing at most.
const MOST: f64 = 2e7;

/// Solid fraction up to which spheres, and discs, are inserted as they are; others are inserted with this
/// fraction, and then grow.
const SPARSE: [f64; 2] = [0.25, 0.4];

/// Solid fraction from which no random packing is tried.
const DENSEST: [f64; 2] = [0.8, 0.95];

/// Steps in which spheres push each other apart at most.
const STEPS: u32 = 4000;

/// Times that jammed spheres are shaken at most.
const SHAKES: u64 = 12;

/// Steps of one sphere in all shakes together, at most.
const WORK: f64 = 8e8;

/// Largest way of a sphere along an axis in a shake, over its radius.
const SHAKEN: f64 = 0.15;

/// To find the fraction that can be reached, spheres shrink by this factor, and push for some steps more.
const SHRINK: f64 = 0.99;
const SHRINKS: i32 = 20;
const STEPS_SHRUNK: u32 = 300;

/// The number of spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PackAmount {
    /// This many.
    Count(usize),
    /// As many as fill this share of the region.
    Fraction(f64),
}

/// The spheres that a packing is to have.
#[derive(Clone, Debug)]
pub struct PackRequest<'a> {
    /// Where they are.
    pub region: PackRegion,
    /// Whether they are discs in the plane z = 0.
    pub discs: bool,
    /// How large they are.
    pub sizes: SphereSizes,
    /// How many they are.
    pub amount: PackAmount,
    /// Least distance of two spheres, and of spheres and sides of the region, m.
    pub gap: f64,
    /// Another seed gives another packing.
    pub seed: u64,
    /// Spheres that are there: centres and radii, m.
    pub others: &'a [([f64; 3], f64)],
}

/// Spheres in their places.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    /// Centres, m.
    pub positions: Vec<[f64; 3]>,
    /// m.
    pub radii: Vec<f64>,
    /// Their volume, or area, over that of the region.
    pub fraction: f64,
}

/// Reasons why there is no such packing.
#[derive(Clone, Debug, PartialEq)]
pub enum PackError {
    /// The sizes are impossible.
    Sizes(String),
    /// The region has no volume.
    NoRegion,
    /// There is not even one sphere.
    Empty,
    /// More spheres than are possible.
    TooMany {
        /// About this number of spheres.
        count: f64,
    },
    /// The largest sphere has no room in the region.
    TooLarge {
        /// Radius of that sphere, m.
        radius: f64,
    },
    /// They would fill more of the region than they can.
    TooDense {
        /// The solid fraction that they would have.
        fraction: f64,
        /// The fraction of slightly smaller spheres that was reached; 0 if not even that was found.
        reached: f64,
    },
    /// The search for overlaps failed.
    Search(String),
}

impl fmt::Display for PackError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sizes(why) | Self::Search(why) => out.write_str(why),
            Self::NoRegion => out.write_str("its region is empty"),
            Self::Empty => out.write_str("not even one sphere fits its amount"),
            Self::TooMany { count } => {
                write!(out, "it would have about {count:.2e} spheres, and may have {MOST:.0e}")
            }
            Self::TooLarge { radius } => {
                write!(out, "a sphere of radius {radius} m has no room in its region")
            }
            Self::TooDense { fraction, reached } if *reached > 0.0 => {
                write!(out, "a solid fraction of {fraction:.3} cannot be reached: {reached:.3} was reached")
            }
            Self::TooDense { fraction, .. } => {
                write!(out, "a solid fraction of {fraction:.3} cannot be reached")
            }
        }
    }
}

impl std::error::Error for PackError {}

/// Packs spheres on `threads` threads; 0 stands for one per processor.
///
/// # Cost
/// 100,000 spheres take seconds at solid fractions up to 0.6.
///
/// # Errors
/// The reason why there is no such packing.
///
/// # Example
/// ```
/// use fdem_grains::{PackAmount, PackRegion, PackRequest, SphereSizes, pack};
///
/// let packed = pack(
///     PackRequest {
///         region: PackRegion::Box { low: [0.0; 3], high: [0.1; 3] },
///         discs: false,
///         sizes: SphereSizes::Uniform([0.004, 0.006]),
///         amount: PackAmount::Fraction(0.5),
///         gap: 0.0,
///         seed: 1,
///         others: &[],
///     },
///     1,
/// )?;
/// assert!((packed.fraction - 0.5).abs() < 0.01);
/// # Ok::<(), fdem_grains::PackError>(())
/// ```
pub fn pack(mut request: PackRequest<'_>, threads: usize) -> Result<Packed, PackError> {
    let discs = request.discs;
    if let Some(why) = request.sizes.fault() {
        return Err(PackError::Sizes(why));
    }
    let room = request.region.measure(discs);
    if !(room > 0.0 && room.is_finite()) {
        return Err(PackError::NoRegion);
    }
    let count = count_of(&request, room)?;
    let mut radii = request.sizes.draw(count, discs, request.seed);
    // The largest find room first.
    radii.sort_by(|a, b| b.total_cmp(a));
    let fraction = radii.iter().map(|&radius| measure(radius, discs)).sum::<f64>() / room;
    let plane = usize::from(discs);
    if fraction > DENSEST[plane] {
        return Err(PackError::TooDense { fraction, reached: 0.0 });
    }
    let largest = radii.first().copied().unwrap_or(0.0);
    if !request.region.has_room(largest + request.gap, discs) {
        return Err(PackError::TooLarge { radius: largest });
    }
    request.region.prepared(1.01 * (largest * (1.0 + MARGIN) + request.gap));
    let root = |x: f64| if discs { x.sqrt() } else { libm::cbrt(x) };
    let share = root(SPARSE[plane] / fraction).min(1.0);
    let wanted = Wanted {
        region: &request.region,
        discs,
        radii: &radii,
        share,
        gap: request.gap,
        seed: request.seed,
        others: request.others,
    };
    let (mut positions, has_room) = insert(&wanted);
    order_in_space(&mut positions, &mut radii, request.region.bounds());
    if share == 1.0 && has_room {
        return Ok(Packed { positions, radii, fraction });
    }
    relaxed(&request, positions, radii, fraction, threads)
}

/// The number of spheres.
fn count_of(request: &PackRequest<'_>, room: f64) -> Result<usize, PackError> {
    let count = match request.amount {
        PackAmount::Count(count) => count as f64,
        PackAmount::Fraction(fraction) => {
            (fraction * room / request.sizes.mean_measure(request.discs)).round()
        }
    };
    if count > MOST {
        return Err(PackError::TooMany { count });
    }
    if count < 1.0 {
        return Err(PackError::Empty);
    }
    Ok(count as usize)
}

/// Lets spheres push each other apart. If they find no room, finds the fraction for which they would.
fn relaxed(
    request: &PackRequest<'_>,
    mut positions: Vec<Vector>,
    mut radii: Vec<f64>,
    fraction: f64,
    threads: usize,
) -> Result<Packed, PackError> {
    let free = radii.len();
    let others = near_region(request);
    positions.extend(others.iter().map(|other| other.0));
    radii.extend(others.iter().map(|other| other.1));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = Arc::new(pool.map_err(|error| PackError::Search(error.to_string()))?);
    let mut relaxing = Relaxing {
        region: &request.region,
        discs: request.discs,
        positions,
        radii,
        free,
        gap: request.gap,
        pool,
    };
    let mut is_free = relaxing.relax(STEPS).map_err(PackError::Search)?;
    // Large packings are given up sooner: the work is bounded.
    let shakes = ((WORK / free as f64) as u64 / u64::from(STEPS)).clamp(1, SHAKES);
    for shake in 0..shakes {
        if is_free {
            break;
        }
        relaxing.shake(SHAKEN, request.seed, shake);
        is_free = relaxing.relax(STEPS).map_err(PackError::Search)?;
    }
    if is_free && is_inside(request, &relaxing) {
        relaxing.positions.truncate(free);
        relaxing.radii.truncate(free);
        return Ok(Packed { positions: relaxing.positions, radii: relaxing.radii, fraction });
    }
    let mut reached = 0.0;
    for times in 1..=SHRINKS {
        relaxing.radii[..free].iter_mut().for_each(|radius| *radius *= SHRINK);
        if relaxing.relax(STEPS_SHRUNK).map_err(PackError::Search)? && is_inside(request, &relaxing) {
            reached = fraction * SHRINK.powi(if request.discs { 2 } else { 3 } * times);
            break;
        }
    }
    Err(PackError::TooDense { fraction, reached })
}

/// Numbers spheres along a curve through space (Morton 1966), so that neighbours have near numbers: searches
/// are twice as fast then.
fn order_in_space(positions: &mut Vec<Vector>, radii: &mut Vec<f64>, [low, high]: [Vector; 2]) {
    let wide = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let code = |at: Vector| {
        let cells =
            [0, 1, 2].map(|axis| (((at[axis] - low[axis]) / wide * 1023.0).max(0.0) as u64).min(1023));
        let bit = |place: u64| {
            (0..3).map(|axis| (cells[axis] >> place & 1) << (3 * place + axis as u64)).sum::<u64>()
        };
        (0..10).map(bit).sum::<u64>()
    };
    let mut order: Vec<(u64, usize)> =
        positions.iter().enumerate().map(|(number, &at)| (code(at), number)).collect();
    order.sort_unstable();
    *positions = order.iter().map(|&(_, number)| positions[number]).collect();
    *radii = order.iter().map(|&(_, number)| radii[number]).collect();
}

/// The spheres that are there and that spheres in the region could touch.
fn near_region(request: &PackRequest<'_>) -> Vec<(Vector, f64)> {
    let [low, high] = request.region.bounds();
    let is_near = |(centre, radius): &&(Vector, f64)| {
        (0..3).all(|axis| {
            let reach = (1.0 + 4.0 * MARGIN) * radius + request.gap;
            centre[axis] + reach >= low[axis] && centre[axis] - reach <= high[axis]
        })
    };
    request.others.iter().filter(is_near).copied().collect()
}

/// Whether the spheres are in the region: inside a surface, they might have been pushed through it.
fn is_inside(request: &PackRequest<'_>, relaxing: &Relaxing<'_>) -> bool {
    let mut spheres = relaxing.positions[..relaxing.free].iter().zip(&relaxing.radii);
    let rounding = 1.0 - 1e-9;
    spheres.all(|(&point, radius)| {
        request.region.contains(point, rounding * (radius + request.gap), request.discs)
    })
}
