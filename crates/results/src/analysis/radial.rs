//! The radial distribution function.

use std::ops::Range;
use std::sync::atomic::AtomicU64;
use std::sync::{Mutex, PoisonError};

use fdem_contact::{Elements, PeriodicCouple, PeriodicSearch, Rows};
use serde::Serialize;

use crate::analysis::domain_frame::DomainFrame;
use crate::analysis::error::AnalysisError;
use crate::analysis::packing::ball;
use crate::analysis::parts::Team;
use crate::analysis::placed::{Inside, Placed};
use crate::arrays::each;
use crate::network::{Network, Space, unshifted};

/// Options of the radial distribution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadialOptions {
    /// Largest distance; by default 3 mean diameters, or less in a small domain.
    pub r_max: Option<f64>,
    /// Number of bins of equal width; by default 150.
    pub bins: Option<usize>,
}

/// Radial distribution function `g(r)`: number of pairs of centres at a distance `r`, over the number
/// expected for uniformly random centres.
///
/// `g_k = counts_k / (references * density * V_k)`, where `V_k` is the area or volume of the shell of bin
/// `k`. Along periodic axes every element is a reference and all images count, also an element's own; in a
/// box that is periodic along all axes, the density is the number of elements over the volume of the box, and
/// the result is exact for any distance. Along other axes, the references are the centres at least `r_max`
/// from the faces of the box around all centres, so that all shells are inside, and the density is that of
/// the references.
///
/// For independent random centres in a periodic box, the mean of `g` is `1 - 1/n`.
///
/// # Units
/// Lengths in the unit of the centres.
///
/// # Source
/// M.P. Allen, D.J. Tildesley, "Computer Simulation of Liquids" (1987), section 2.6.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Radial {
    /// Largest distance.
    pub r_max: f64,
    /// Distance in the middle of each bin.
    pub r: Vec<f64>,
    /// Value of the function in each bin.
    pub g: Vec<f64>,
    /// Number of centres in the shell of a reference, summed over all references. A bin includes its lower
    /// limit; the last bin also includes `r_max`.
    pub counts: Vec<u64>,
    /// Number of reference elements.
    pub references: u64,
    /// Number of centres per area or volume.
    pub density: f64,
}

const DEFAULT_BINS: usize = 150;
const MOST_BINS: usize = 1_000_000;

/// Returns the distribution of a network on all threads, or the reason why it cannot be given.
pub(crate) fn of_network<const D: usize>(
    network: &Network<'_, D>,
    options: RadialOptions,
) -> Result<Result<Radial, String>, AnalysisError> {
    let handled = AtomicU64::new(0);
    distribution(&Placed::of(network, Team::new(0, &handled)), options)
}

/// Returns the distribution, or the reason why it cannot be given.
pub(crate) fn distribution<const D: usize>(
    placed: &Placed<'_, D>,
    options: RadialOptions,
) -> Result<Result<Radial, String>, AnalysisError> {
    let refused = |problem: String| Err(AnalysisError::Radial { problem });
    let bins = options.bins.unwrap_or(DEFAULT_BINS);
    if bins == 0 || bins > MOST_BINS {
        return refused(format!("{bins} bins are not between 1 and {MOST_BINS}"));
    }
    if let Some(r_max) = options.r_max.filter(|r_max| !(*r_max > 0.0 && r_max.is_finite())) {
        return refused(format!("the largest distance {r_max} is not above 0"));
    }
    let network = placed.network;
    let n = network.space.centres.len();
    if n == 0 {
        return Ok(Err("there are no elements".to_owned()));
    }
    let mut frame = placed.frame.clone();
    around_centres(&mut frame, network);
    let r_max = options.r_max.unwrap_or_else(|| usual_distance(&frame, network));
    if r_max <= 0.0 {
        return Ok(Err("the elements, or the box around their centres, have no width".to_owned()));
    }

    let inner: [[f64; 2]; D] = each(|axis| {
        let [low, high] = frame.domain[axis];
        if frame.periods[axis].is_some() { [low, high] } else { [low + r_max, high - r_max] }
    });
    // The lower limit is included and the upper one is not, so that equidistant layers have the right
    // density.
    let is_reference: Vec<_> = (0..n)
        .map(|element| {
            let x = frame.coordinates(network, element);
            (0..D).all(|axis| {
                frame.periods[axis].is_some() || (inner[axis][0] <= x[axis] && x[axis] < inner[axis][1])
            })
        })
        .collect();
    let references = is_reference.iter().filter(|&&reference| reference).count() as u64;
    if references == 0 {
        let problem = format!("no centre is {r_max} away from all faces of the box around the centres");
        return if options.r_max.is_some() { refused(problem) } else { Ok(Err(problem)) };
    }
    let density = references as f64 / frame.measure(&inner);

    let counts = count(placed, r_max, bins, &is_reference)?;
    let width = r_max / bins as f64;
    let shell = |k: usize| {
        let (low, high) = (k as f64 * width, (k + 1) as f64 * width);
        ball::<D>(high) - ball::<D>(low)
    };
    let expected = |k: usize| references as f64 * density * shell(k);
    Ok(Ok(Radial {
        r_max,
        r: (0..bins).map(|k| (k as f64 + 0.5) * width).collect(),
        g: counts.iter().enumerate().map(|(k, &count)| count as f64 / expected(k)).collect(),
        counts,
        references,
        density,
    }))
}

/// Shrinks the domain to the box around the centres, along axes that are not periodic.
fn around_centres<const D: usize>(frame: &mut DomainFrame<D>, network: &Network<'_, D>) {
    for axis in (0..D).filter(|&axis| frame.periods[axis].is_none()) {
        let places =
            (0..network.space.centres.len()).map(|element| frame.coordinates(network, element)[axis]);
        frame.domain[axis] =
            places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    }
}

/// Default largest distance: three mean diameters, but at most half of a periodic box and a quarter of an
/// open domain.
fn usual_distance<const D: usize>(frame: &DomainFrame<D>, network: &Network<'_, D>) -> f64 {
    let n = network.space.centres.len();
    let mean = (0..n).fold(0.0, |sum, element| sum + network.sizes.radius(element)) / n as f64;
    let mut r_max = 6.0 * mean;
    for axis in 0..D {
        let [low, high] = frame.domain[axis];
        r_max = match (frame.periods[axis], &network.space.cell) {
            (Some(_), Some(cell)) => r_max.min(cell.heights()[axis] / 2.0),
            _ => r_max.min((high - low) / 4.0),
        };
    }
    r_max
}

/// Counts the centres around references by distance.
fn count<const D: usize>(
    placed: &Placed<'_, D>,
    r_max: f64,
    bins: usize,
    is_reference: &[bool],
) -> Result<Vec<u64>, AnalysisError> {
    let team = &placed.team;
    let order = by_place(placed, r_max);
    let centres: Vec<_> = order.iter().map(|&element| placed.network.space.centres[element]).collect();
    let references: Vec<_> = order.iter().map(|&element| u32::from(is_reference[element])).collect();
    let space = Space { centres: &centres, cell: placed.network.space.cell };
    let points = Elements::points(space.centres, r_max).map_err(AnalysisError::Search)?;

    let tables = Tables { each: (0..team.threads()).map(|_| Mutex::new(vec![0; bins])).collect() };
    let add = |waiting: &mut Vec<Pair>, couple: PeriodicCouple<D>, distance: f64| {
        let place = distance / r_max * bins as f64;
        let references = references[couple.i as usize] + references[couple.j as usize];
        waiting.push(Pair { bin: (place as u32).min(bins as u32 - 1), references });
        if waiting.len() == WAITING {
            tables.take(waiting);
            team.count(WAITING);
        }
    };
    let rest = match &space.cell {
        None => {
            let mut rows = Rows::new().with_threads(team.threads()).map_err(AnalysisError::Search)?;
            rows.fold(&points, Vec::new, |waiting, couple| {
                let couple = unshifted(couple);
                add(waiting, couple, space.distance(couple));
            })
        }
        Some(cell) => {
            let inside = Inside::of(space, cell, team);
            let search = PeriodicSearch::new().with_threads(team.threads());
            search.map_err(AnalysisError::Search)?.fold(&points, cell, Vec::new, |waiting, couple| {
                add(waiting, couple, inside.distance(couple));
            })
        }
    };
    rest.map_err(AnalysisError::Search)?.iter_mut().for_each(|waiting| tables.take(waiting));
    Ok(tables.sum(bins))
}

/// The elements in the order of the cells that they are in, so that elements that are near in space are near
/// in memory. A search over many pairs would otherwise wait for memory most of the time.
fn by_place<const D: usize>(placed: &Placed<'_, D>, cell: f64) -> Vec<usize> {
    /// Bits of the number of a cell along an axis.
    const BITS: u32 = 21;
    let centres = placed.network.space.centres;
    let mut low = [f64::INFINITY; D];
    for centre in centres {
        for axis in 0..D {
            low[axis] = low[axis].min(centre[axis]);
        }
    }
    let part = |range: Range<usize>| {
        let mut keys = Vec::with_capacity(range.len());
        for element in range {
            let mut key = 0_u64;
            for axis in (0..D).rev() {
                let cell = ((centres[element][axis] - low[axis]) / cell) as u64;
                key = key << BITS | cell.min((1 << BITS) - 1);
            }
            keys.push((key, element));
        }
        keys
    };
    let mut keys = placed.team.parts(centres.len(), part).concat();
    keys.sort_unstable();
    keys.into_iter().map(|(_, element)| element).collect()
}

/// Number of pairs that a part of the search collects before it counts them.
const WAITING: usize = 2048;

/// A pair of centres: its bin, and how many of the two are references.
struct Pair {
    bin: u32,
    references: u32,
}

/// Tables of counts, one for each thread. Whole numbers are added in them, so that it does not matter which
/// thread counts a pair in which table.
struct Tables {
    each: Vec<Mutex<Vec<u64>>>,
}

impl Tables {
    /// Counts the pairs, which are removed, in a table that no other thread uses.
    fn take(&self, pairs: &mut Vec<Pair>) {
        let free = self.each.iter().find_map(|table| table.try_lock().ok());
        // There may be more threads than tables if the caller is a thread of a pool.
        let mut table = free.unwrap_or_else(|| self.each[0].lock().unwrap_or_else(PoisonError::into_inner));
        for pair in pairs.drain(..) {
            table[pair.bin as usize] += u64::from(pair.references);
        }
    }

    fn sum(self, bins: usize) -> Vec<u64> {
        let mut counts = vec![0; bins];
        for table in self.each {
            let table = table.into_inner().unwrap_or_else(PoisonError::into_inner);
            counts.iter_mut().zip(table).for_each(|(count, more)| *count += more);
        }
        counts
    }
}
