//! Sending each element to the rank that owns its part of the domain.

use fdem_contact::Real;

use super::elements::{Arrived, ElementSet, ElementsView, ShapeKind};
use super::ghosts::GROUPS;
use super::runs::Runs;
use crate::communicator::Communicator;
use crate::curve::{Coarse, Curve};
use crate::division::Division;

/// Elements in a cell, on the rank with the most elements, if they are spread evenly and the number of cells
/// is not limited.
const IN_CELL: usize = 16;

/// Number of runs of all ranks together, unless each rank has [`GROUPS`]. Each has a place in memory that is
/// written to.
const RUNS: usize = 1 << 11;

/// Elements of a rank after all have been sent to their owners.
pub(crate) struct Owned<T, const D: usize> {
    /// Run by run.
    pub(crate) set: ElementSet<T, D>,
    /// The ends of the runs: elements of consecutive cells along the curve, in no order inside the run.
    pub(crate) ends: Vec<usize>,
    pub(crate) curve: Curve<D>,
    /// Upper bounds on the magnitude of all coordinates, and on the distance of elements that touch. The same
    /// on all ranks.
    pub(crate) limits: [f64; 2],
}

/// Sends elements to their owners. Collective.
pub(crate) fn distribute<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    given: ElementsView<'_, T, D>,
    is_periodic: bool,
) -> Owned<T, D> {
    let (curve, limits) = survey(communicator, &given);
    let runs = divide(communicator, &given, &curve);
    let (arriving, ends) = runs.announce(communicator);
    let mut set =
        ElementSet::blank(given.kind, given.tolerance, ends.last().copied().unwrap_or(0), is_periodic);
    let messages = given.scatter(&runs, communicator.rank(), &arriving[0].starts, &mut set);
    drop(runs);
    let received = communicator.exchange(messages);
    for (message, arriving) in received.iter().zip(&arriving[1..]) {
        let mut from =
            Arrived::new::<T, D>(&message.bytes, arriving.counts.iter().sum(), &given.kind, is_periodic);
        for (&start, &count) in arriving.starts.iter().zip(&arriving.counts) {
            set.place(start..start + count, &mut from);
        }
    }
    Owned { set, ends, curve: curve.finest(), limits }
}

/// The curve through the elements of all ranks, and the limits of [`Owned`]. Collective.
fn survey<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    given: &ElementsView<'_, T, D>,
) -> (Coarse<D>, [f64; 2]) {
    let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for point in given.points {
        for axis in 0..D {
            let x = point[axis].to_f64();
            low[axis] = if x < low[axis] { x } else { low[axis] };
            high[axis] = if x > high[axis] { x } else { high[axis] };
        }
    }
    let mut extremes: Vec<f64> = high.into_iter().chain(low.map(|x| -x)).collect();
    let far = given.far_points.iter().flatten().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
    extremes.push(extremes.iter().fold(far, |most, x| most.max(*x)));
    // Equal elements have equal reaches.
    let different = if matches!(given.kind, ShapeKind::Equal(_)) { given.len().min(1) } else { given.len() };
    extremes.push((0..different).fold(0.0, |most: f64, place| most.max(given.reach(place))));
    extremes.push(given.len() as f64);
    communicator.all_max(&mut extremes);
    let max = std::array::from_fn(|axis| extremes[axis]);
    let min = std::array::from_fn(|axis| -extremes[D + axis]);
    let curve = Curve::new(min, max).coarse(extremes[2 * D + 2] as usize / IN_CELL);
    (curve, [extremes[2 * D], extremes[2 * D + 1]])
}

/// Divides the elements among the ranks and into runs. Collective.
fn divide<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    given: &ElementsView<'_, T, D>,
    curve: &Coarse<D>,
) -> Runs {
    let point = |point: &[T; D]| point.map(T::to_f64);
    let mut of: Vec<u32> = given.points.iter().map(|at| curve.place(point(at))).collect();
    let mut counts = vec![0; curve.len()];
    for &cell in &of {
        counts[cell as usize] += 1;
    }
    let division = Division::new(communicator, &counts, curve.shift(), |is_marked| {
        let marked = of.iter().zip(given.points).filter(|(cell, _)| is_marked[**cell as usize]);
        marked.map(|(_, at)| curve.key(point(at))).collect()
    });

    // Each rank has at most `GROUPS` runs of equally many cells.
    let mut parts = division.parts();
    let (mut run_of_part, mut counts, mut firsts) = (Vec::with_capacity(parts.len()), Vec::new(), Vec::new());
    for rank in 0..communicator.size() {
        let first = counts.len();
        firsts.push(first);
        let count = parts.partition_point(|part| part.owner == rank);
        let runs = count.min((RUNS / communicator.size()).max(GROUPS));
        counts.resize(first + runs, 0);
        for (k, part) in parts.split_off(..count).unwrap_or_default().iter().enumerate() {
            let run = first + k * runs / count;
            counts[run] += part.count;
            run_of_part.push(run as u32);
        }
    }
    firsts.push(counts.len());
    for (cell, at) in of.iter_mut().zip(given.points) {
        *cell = run_of_part[division.part(*cell as usize, || curve.key(point(at)))];
    }
    Runs { of, counts, firsts }
}
