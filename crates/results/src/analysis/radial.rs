//! The radial distribution function.

use fdem_contact::{Detector, Elements, PeriodicSearch, Search};
use serde::Serialize;

use crate::analysis::error::AnalysisError;
use crate::analysis::packing::{DomainFrame, ball};
use crate::arrays::each;
use crate::network::{Network, unshifted};

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

/// Returns the distribution, or the reason why it cannot be given.
pub(crate) fn distribution<const D: usize>(
    network: &Network<'_, D>,
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
    let n = network.space.centres.len();
    if n == 0 {
        return Ok(Err("there are no elements".to_owned()));
    }
    let mut frame = DomainFrame::of(network);
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

    let counts = count(network, r_max, bins, &is_reference)?;
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
    network: &Network<'_, D>,
    r_max: f64,
    bins: usize,
    is_reference: &[bool],
) -> Result<Vec<u64>, AnalysisError> {
    let space = network.space;
    let points = Elements::points(space.centres, r_max).map_err(AnalysisError::Search)?;
    let mut counts = vec![0_u64; bins];
    let mut add = |couple: fdem_contact::PeriodicCouple<D>| {
        let [i, j] = [couple.i as usize, couple.j as usize];
        let place = space.distance(couple) / r_max * bins as f64;
        counts[(place as usize).min(bins - 1)] += u64::from(is_reference[i]) + u64::from(is_reference[j]);
    };
    match &space.cell {
        None => Detector::new().for_each(&points, |couple| add(unshifted(couple))),
        Some(cell) => PeriodicSearch::new().for_each(&points, cell, add),
    }
    .map_err(AnalysisError::Search)?;
    Ok(counts)
}
