//! Ghosts: elements that a rank sends to others, so that one rank finds each couple.
//!
//! Two elements that touch belong to ranks of which one gets a copy of the other's element, a ghost. The
//! larger element is sent, so that a large one among small ones does not attract all of them. Sizes are
//! compared by [levels](Set::level); elements of one level are sent by one of the two ranks.
//!
//! A rank informs the others where its elements are: it cuts them, level by level and along the curve, into
//! groups of neighbours, and sends the box around each group. Elements come in runs along the curve, so
//! groups need no sorting, except where elements crowd. An element goes to the ranks that have a group of its
//! level or a lower one whose box it overlaps.

use fdem_contact::{DEFAULT_MAX_IMAGES, Elements, Error, PeriodicBox, Real};

use super::elements::{Arrived, ElementSet, ElementsView, ShapeKind};
use crate::communicator::{Communicator, Message};
use crate::curve::Curve;
use crate::wire;
use crate::wire::{bytes_of, put_all, take_all, value_of};

/// About the number of groups into which a rank cuts its elements. Each level adds at most one more, and
/// crowded places can double the number.
pub(crate) const GROUPS: usize = 256;

/// Elements of one rank and of one level that are near each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GhostGroup<const D: usize> {
    level: u16,
    /// The box around the elements, extended so that it overlaps those that touch them.
    low: [f64; D],
    high: [f64; D],
}

wire!([const D: usize] GhostGroup<D> { level, low, high });

impl<const D: usize> GhostGroup<D> {
    /// A group without elements.
    fn empty(level: u16) -> Self {
        Self { level, low: [f64::INFINITY; D], high: [f64::NEG_INFINITY; D] }
    }

    /// Extends the box to another one.
    fn include(&mut self, other: &Self) {
        for axis in 0..D {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    /// Extends the box to an element.
    #[inline]
    fn add<T: Real>(&mut self, elements: &Elements<'_, T, D>, place: usize) {
        for axis in 0..D {
            let [low, high] = elements.span(place, axis);
            self.low[axis] = if low < self.low[axis] { low } else { self.low[axis] };
            self.high[axis] = if high > self.high[axis] { high } else { self.high[axis] };
        }
    }
}

/// The groups of a rank.
pub(crate) struct GhostGroups<const D: usize> {
    boxes: Vec<GhostGroup<D>>,
    /// The group of each element.
    of: Vec<u32>,
}

/// An element that is sent, with the number of edges by which it is displaced from its place in the box.
type SentElement<const D: usize> = (u32, [i32; D]);

/// Chooses the one of two ranks that gets ghosts from the other, for elements of one level. The choice
/// alternates, so that ghosts are spread evenly.
pub(crate) fn keeper(a: usize, b: usize) -> usize {
    if (a + b).is_multiple_of(2) { a.min(b) } else { a.max(b) }
}

/// Displacements of elements by the periodic box, and the rounding that is allowed for.
#[derive(Clone, Copy)]
pub(crate) struct Lattice<'a, T, const D: usize> {
    pub(crate) cell: &'a PeriodicBox<T, D>,
    edges: [[f64; D]; D],
    /// Upper bound on the magnitude of all coordinates of all ranks, and on the distance of elements that
    /// touch.
    magnitude: f64,
    reach: f64,
}

impl<'a, T: Real, const D: usize> Lattice<'a, T, D> {
    /// Checks that the box is not so thin that rounding is comparable to its size. The same on all ranks.
    pub(crate) fn new(cell: &'a PeriodicBox<T, D>, magnitude: f64, reach: f64) -> Result<Self, Error> {
        let lattice = Self { cell, edges: cell.edges().map(|edge| edge.map(T::to_f64)), magnitude, reach };
        for edge in (0..D).filter(|&edge| cell.periodic()[edge]) {
            let rounding = lattice.rounding(&[1; D]) / cell.heights()[edge];
            if rounding.is_nan() || rounding > FRACTION / 4.0 {
                return Err(Error::UnresolvedBox { edge, rounding });
            }
        }
        Ok(lattice)
    }

    fn offset(&self, shift: &[i32; D]) -> [f64; D] {
        std::array::from_fn(|axis| (0..D).map(|edge| f64::from(shift[edge]) * self.edges[edge][axis]).sum())
    }

    /// Bounds, relative to the elements around it, the error of the rounded position of an image, and the
    /// error of the comparison.
    ///
    /// A displacement is a sum of `D` products and a coordinate, in `f64`, and is rounded to `T`: its error
    /// is at most `D + 2` units in the last place of the sum of magnitudes. Either of two elements is
    /// displaced, and before that both are wrapped. The comparison adds `D + 8` units of the reach, as
    /// [`Elements::span`] explains. Eight times as much covers all of it.
    pub(crate) fn rounding(&self, shift: &[i32; D]) -> f64 {
        let displaced: f64 = (0..D)
            .map(|edge| {
                let longest = self.edges[edge].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                f64::from(shift[edge].unsigned_abs()) * longest
            })
            .sum();
        let units = 8.0 * (D + 8) as f64 * T::EPSILON;
        units * (self.magnitude + displaced + self.reach) + T::MIN_RESOLVED
    }

    /// Calls `visit` with every shift that may bring box `a` to overlap box `b`, except no shift at all.
    ///
    /// # Errors
    /// The number of shifts that were to be tried, if there are too many.
    fn shifts(
        &self,
        a: &GhostGroup<D>,
        b: &GhostGroup<D>,
        mut visit: impl FnMut([i32; D]),
    ) -> Result<(), f64> {
        let (dual, periodic) = (self.cell.dual(), self.cell.periodic());
        let mut ends = [[0_i64; 2]; D];
        for edge in (0..D).filter(|&edge| periodic[edge]) {
            let (mut low, mut high) = (-FRACTION, FRACTION);
            for (axis, factor) in dual[edge].iter().enumerate() {
                let products = [b.low[axis] - a.high[axis], b.high[axis] - a.low[axis]].map(|x| x * factor);
                low += products[0].min(products[1]);
                high += products[0].max(products[1]);
            }
            ends[edge] = [low.ceil() as i64, high.floor() as i64];
            if ends[edge][0] > ends[edge][1] {
                return Ok(());
            }
        }
        let count: f64 = ends.iter().map(|[low, high]| (high - low) as f64 + 1.0).product();
        if count > DEFAULT_MAX_IMAGES as f64 {
            return Err(count);
        }
        let mut shift = ends.map(|[low, _]| low);
        loop {
            let number = shift.map(|n| n as i32);
            if number != [0; D] && overlap(a, b, &self.offset(&number), self.rounding(&number)) {
                visit(number);
            }
            // Counts like an odometer: the last edge changes fastest.
            let Some(edge) = (0..D).rev().find(|&edge| shift[edge] < ends[edge][1]) else { return Ok(()) };
            shift[edge] += 1;
            for later in edge + 1..D {
                shift[later] = ends[later][0];
            }
        }
    }
}

/// Part of a period by which shifts are looked for beyond the exact limits; rounding is less.
const FRACTION: f64 = 1e-3;

/// Whether group `a`, displaced, overlaps group `b` or is nearer than `gap` along every axis.
fn overlap<const D: usize>(a: &GhostGroup<D>, b: &GhostGroup<D>, offset: &[f64; D], gap: f64) -> bool {
    (0..D).all(|axis| {
        a.low[axis] + offset[axis] <= b.high[axis] + gap && b.low[axis] <= a.high[axis] + offset[axis] + gap
    })
}

/// A group with this number of times the mean number of elements is cut.
const CROWDED: usize = 4;

impl<const D: usize> GhostGroups<D> {
    /// Cuts elements into groups: level by level, consecutive runs of elements. `ends` are those of the runs.
    /// Crowded groups are cut along the curve.
    pub(crate) fn new<T: Real>(
        elements: &Elements<'_, T, D>,
        view: ElementsView<'_, T, D>,
        ends: &[usize],
        curve: Curve<D>,
    ) -> Self {
        let n = view.len();
        let length = n.div_ceil(GROUPS);
        let distinct = if matches!(view.kind, ShapeKind::Equal(_)) { n.min(1) } else { n };
        let mut levels: Vec<u16> = (0..distinct).map(|place| view.level(place)).collect();
        levels.sort_unstable();
        levels.dedup();
        let mut boxes: Vec<GhostGroup<D>> = Vec::new();
        let mut counts: Vec<usize> = Vec::new();
        let mut of = Vec::with_capacity(n);
        // The last group of each level, if it has room.
        let mut open: Vec<Option<usize>> = vec![None; levels.len()];
        let mut start = 0;
        for &end in ends {
            for group in &mut open {
                *group = group.filter(|group| counts[*group] < length);
            }
            for place in start..end {
                let level = if levels.len() == 1 { Ok(0) } else { levels.binary_search(&view.level(place)) };
                let level = level.unwrap_or_default();
                let group = *open[level].get_or_insert_with(|| {
                    boxes.push(GhostGroup::empty(levels[level]));
                    counts.push(0);
                    boxes.len() - 1
                });
                boxes[group].add(elements, place);
                counts[group] += 1;
                of.push(group as u32);
            }
            start = end;
        }
        let mut groups = Self { boxes, of };
        if counts.iter().any(|&count| count > CROWDED * length) {
            let key = |place: usize| curve.key(view.points[place].map(T::to_f64));
            groups.cut(elements, |group| counts[group] > CROWDED * length, key, length);
        }
        groups
    }

    /// Cuts crowded groups into groups of this length.
    fn cut<T: Real>(
        &mut self,
        elements: &Elements<'_, T, D>,
        is_crowded: impl Fn(usize) -> bool,
        key: impl Fn(usize) -> u64,
        length: usize,
    ) {
        let inside = self.of.iter().enumerate().filter(|(_, group)| is_crowded(**group as usize));
        let mut crowded: Vec<(u32, u64, usize)> =
            inside.map(|(place, &group)| (group, key(place), place)).collect();
        crowded.sort_unstable();
        for of_group in crowded.chunk_by(|a, b| a.0 == b.0) {
            let first = of_group[0].0;
            let level = self.boxes[first as usize].level;
            for (number, part) in of_group.chunks(length).enumerate() {
                let mut smaller = GhostGroup::empty(level);
                let group = if number == 0 { first } else { self.boxes.len() as u32 };
                for &(_, _, place) in part {
                    smaller.add(elements, place);
                    self.of[place] = group;
                }
                if number == 0 {
                    self.boxes[first as usize] = smaller;
                } else {
                    self.boxes.push(smaller);
                }
            }
        }
    }

    /// The places of the elements of each group that is chosen; no places for others.
    fn places(&self, is_chosen: &[bool]) -> Vec<Vec<u32>> {
        let mut places = vec![Vec::new(); self.boxes.len()];
        for (place, &group) in (0..).zip(&self.of) {
            if is_chosen[group as usize] {
                places[group as usize].push(place);
            }
        }
        places
    }
}

/// Ghosts that a rank has got.
pub(crate) struct Ghosts<T, const D: usize> {
    /// At their places inside the box, not displaced.
    pub(crate) set: ElementSet<T, D>,
    pub(crate) shifts: Vec<[i32; D]>,
    /// The rank that owns each.
    pub(crate) owners: Vec<u32>,
}

/// Exchanges the groups of all ranks, and finds the elements that this rank sends to each. Collective, if it
/// succeeds on all ranks.
pub(crate) fn choose<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    elements: &Elements<'_, T, D>,
    groups: &GhostGroups<D>,
    lattice: Option<&Lattice<'_, T, D>>,
) -> Result<Vec<(usize, Vec<SentElement<D>>)>, Error> {
    let everywhere = communicator.all_gather(&bytes_of(&groups.boxes));
    let everywhere: Vec<Vec<GhostGroup<D>>> = everywhere.iter().map(|bytes| value_of(bytes)).collect();

    let own = communicator.rank();
    // Whether elements of a group go to another rank if they overlap one of its groups.
    let takes = |rank: usize, group: &GhostGroup<D>, other: &GhostGroup<D>| {
        group.level > other.level
            || (group.level == other.level && (rank == own || keeper(rank, own) == rank))
    };
    let touches = |group: &GhostGroup<D>, rank: usize, theirs: &[GhostGroup<D>]| {
        let is_near =
            |other: &GhostGroup<D>| takes(rank, group, other) && overlap(group, other, &[0.0; D], 0.0);
        rank != own && theirs.iter().any(is_near)
    };
    let is_near = groups.boxes.iter().map(|group| {
        let mut all = everywhere.iter().enumerate();
        lattice.is_some() || all.any(|(rank, theirs)| touches(group, rank, theirs))
    });
    let places = groups.places(&is_near.collect::<Vec<bool>>());

    let mut all = Vec::new();
    let mut images = 0;
    for (rank, theirs) in everywhere.iter().enumerate() {
        if rank == own && lattice.is_none() {
            continue;
        }
        let mut sent = Vec::new();
        let with_places = groups.boxes.iter().zip(&places).filter(|(_, places)| !places.is_empty());
        for (group, of_group) in with_places {
            // The shift, and the group of the other rank that the elements may overlap with it.
            let mut near: Vec<([i32; D], usize)> = Vec::new();
            for (number, other) in theirs.iter().enumerate() {
                if !takes(rank, group, other) {
                    continue;
                }
                if rank != own && overlap(group, other, &[0.0; D], 0.0) {
                    near.push(([0; D], number));
                }
                if let Some(lattice) = lattice {
                    lattice.shifts(group, other, |shift| near.push((shift, number))).map_err(too_many)?;
                }
                if near.len() > DEFAULT_MAX_IMAGES {
                    return Err(too_many(near.len() as f64));
                }
            }
            near.sort_unstable();
            for same_shift in near.chunk_by(|a, b| a.0 == b.0) {
                let (shift, before) = (same_shift[0].0, sent.len());
                let (offset, gap) = match lattice {
                    Some(lattice) if shift != [0; D] => (lattice.offset(&shift), lattice.rounding(&shift)),
                    _ => ([0.0; D], 0.0),
                };
                // The box around all groups that may be touched, which most elements miss.
                let mut around = GhostGroup::empty(group.level);
                for &(_, other) in same_shift {
                    around.include(&theirs[other]);
                }
                for &place in of_group {
                    let mut element = GhostGroup::empty(group.level);
                    element.add(elements, place as usize);
                    if overlap(&element, &around, &offset, gap)
                        && same_shift
                            .iter()
                            .any(|&(_, other)| overlap(&element, &theirs[other], &offset, gap))
                    {
                        sent.push((place, shift));
                    }
                }
                if shift != [0; D] {
                    images += sent.len() - before;
                }
                if images > DEFAULT_MAX_IMAGES {
                    return Err(too_many(images as f64));
                }
            }
        }
        if !sent.is_empty() {
            all.push((rank, sent));
        }
    }
    Ok(all)
}

fn too_many(images: f64) -> Error {
    Error::TooManyImages { images, limit: DEFAULT_MAX_IMAGES }
}

/// Sends the chosen elements, and receives the ghosts of this rank. Collective.
pub(crate) fn exchange<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    set: &ElementSet<T, D>,
    chosen: Vec<(usize, Vec<SentElement<D>>)>,
    is_periodic: bool,
) -> Ghosts<T, D> {
    let messages = chosen.into_iter().map(|(rank, sent)| {
        let mut bytes = Vec::new();
        set.view().write(sent.iter().map(|(place, _)| *place), &mut bytes);
        if is_periodic {
            put_all(sent.iter().map(|(_, shift)| *shift), &mut bytes);
        }
        Message { rank, bytes }
    });
    let messages = messages.collect();
    let mut ghosts =
        Ghosts { set: ElementSet::new(set.kind, set.tolerance), shifts: Vec::new(), owners: Vec::new() };
    // An element and its shift.
    let of_each = set.kind.bytes::<D>(is_periodic) + if is_periodic { size_of::<[i32; D]>() } else { 0 };
    let received = communicator.exchange(messages);
    let count = |message: &Message| message.bytes.len() / of_each;
    ghosts.set = ElementSet::blank(set.kind, set.tolerance, received.iter().map(count).sum(), is_periodic);
    for message in &received {
        let (start, count) = (ghosts.shifts.len(), count(message));
        let mut from = Arrived::new::<T, D>(&message.bytes, count, &set.kind, is_periodic);
        ghosts.set.place(start..start + count, &mut from);
        if is_periodic {
            ghosts.shifts.extend(take_all::<[i32; D]>(&mut from.rest(), count));
        } else {
            ghosts.shifts.resize(start + count, [0; D]);
        }
        ghosts.owners.resize(start + count, message.rank as u32);
    }
    ghosts
}
