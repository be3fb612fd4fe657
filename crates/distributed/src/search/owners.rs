//! Sending each element to the rank that owns its part of the domain.

use std::ops::Range;

use fdem_contact::Real;

use super::elements::{Kind, Set, View};
use crate::communicator::{Communicator, Message};
use crate::curve::{Coarse, Curve};
use crate::division::Division;
use crate::wire::{Reader, Writer};

/// Elements in a cell, on the rank with the most elements, if they are spread evenly and there may be so many cells.
const IN_CELL: usize = 16;

/// Elements of a rank after all have been sent to their owners.
pub(crate) struct Owned<T, const D: usize> {
    /// In no order.
    pub(crate) set: Set<T, D>,
    /// The curve along which the domain is divided.
    pub(crate) curve: Coarse<D>,
    /// The cells along the curve that the rank owns, the first and the last one perhaps in part.
    pub(crate) cells: Range<usize>,
    /// Upper bounds on the magnitude of all coordinates, and on the distance of elements that touch. The same on all ranks.
    pub(crate) limits: [f64; 2],
}

/// Sends elements to their owners. Collective.
pub(crate) fn distribute<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    given: View<'_, T, D>,
    is_periodic: bool,
) -> Owned<T, D> {
    let (curve, limits) = survey(communicator, &given);
    let (division, cells) = divide(communicator, &given, &curve);

    // Places by owner, with a counting sort.
    let mut ends = vec![0; communicator.size() + 1];
    for part in division.parts() {
        ends[part.owner + 1] += part.count;
    }
    for rank in 0..communicator.size() {
        ends[rank + 1] += ends[rank];
    }
    let starts = ends.clone();
    let mut places = vec![0_u32; given.len()];
    for ((place, &cell), point) in (0..).zip(&cells).zip(given.points) {
        let part = division.part(cell as usize, || curve.key(point.map(T::to_f64)));
        let end = &mut ends[division.parts()[part].owner];
        places[*end] = place;
        *end += 1;
    }
    drop(cells);
    let of_rank = |rank: usize| &places[starts[rank]..starts[rank + 1]];

    let own = communicator.rank();
    let others = (0..communicator.size()).filter(|&rank| rank != own && !of_rank(rank).is_empty());
    let messages = others.map(|rank| {
        let sent = of_rank(rank);
        let mut out = Writer::default();
        out.bytes.reserve_exact(8 + sent.len() * given.bytes());
        out.u64(sent.len() as u64);
        given.write(sent.iter().copied(), &mut out);
        Message { rank, bytes: out.bytes }
    });
    let received = communicator.exchange(messages.collect());
    let mut from: Vec<Reader<'_>> = received.iter().map(|message| Reader::new(&message.bytes)).collect();
    let counts: Vec<usize> = from.iter_mut().map(|from| from.u64() as usize).collect();
    let mut set = Set::new(given.kind, given.tolerance);
    set.reserve(of_rank(own).len() + counts.iter().sum::<usize>(), is_periodic);
    set.append_picked(given, of_rank(own));
    for (mut from, count) in from.into_iter().zip(counts) {
        set.read(count, is_periodic, &mut from);
    }
    let mut own_parts = division.parts().iter().filter(|part| part.owner == own);
    let first = own_parts.next().map_or(0, |part| part.cell);
    let cells = first..own_parts.last().map_or(first, |part| part.cell) + 1;
    Owned { set, curve, cells, limits }
}

/// The curve through the elements of all ranks, and the limits of [`Owned`]. Collective.
fn survey<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    given: &View<'_, T, D>,
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
    let different = if matches!(given.kind, Kind::Equal(_)) { given.len().min(1) } else { given.len() };
    extremes.push((0..different).fold(0.0, |most: f64, place| most.max(given.reach(place))));
    extremes.push(given.len() as f64);
    communicator.all_max(&mut extremes);
    let max = std::array::from_fn(|axis| extremes[axis]);
    let min = std::array::from_fn(|axis| -extremes[D + axis]);
    let curve = Curve::new(min, max).coarse(extremes[2 * D + 2] as usize / IN_CELL);
    (curve, [extremes[2 * D], extremes[2 * D + 1]])
}

/// Divides the elements, and returns the place along the curve of the cell of each. Collective.
fn divide<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    given: &View<'_, T, D>,
    curve: &Coarse<D>,
) -> (Division, Vec<u32>) {
    let point = |point: &[T; D]| point.map(T::to_f64);
    let cells: Vec<u32> = given.points.iter().map(|at| curve.place(point(at))).collect();
    let mut counts = vec![0; curve.len()];
    for &cell in &cells {
        counts[cell as usize] += 1;
    }
    let division = Division::new(communicator, &counts, curve.shift(), |is_marked| {
        let marked = cells.iter().zip(given.points).filter(|(cell, _)| is_marked[**cell as usize]);
        marked.map(|(_, at)| curve.key(point(at))).collect()
    });
    (division, cells)
}
