//! Elements of a rank: those that the caller gives, and those that are sent around.

use std::ops::Range;

use fdem_contact::{Elements, Error, PeriodicBox, Real};

use super::runs::Runs;
use crate::communicator::Message;
use crate::wire::{part, put_all, put_points, take_all, take_points};

/// The elements that a rank gives to a search.
///
/// # Shapes
/// `centres`, `min`, `max`: `[n]` points `[T; D]`; `radii`: `[n]`. Each rank has its own `n`, which may be 0.
///
/// # Units
/// One length unit for everything.
#[derive(Clone, Copy, Debug)]
pub enum Shapes<'a, T, const D: usize> {
    /// Spheres (discs in 2D) of one radius, the same on all ranks.
    Equal {
        /// Centres of the elements.
        centres: &'a [[T; D]],
        /// Radius of the elements.
        radius: T,
    },
    /// Spheres (discs in 2D), each with its own radius.
    Spheres {
        /// Centres of the elements.
        centres: &'a [[T; D]],
        /// Radii of the elements.
        radii: &'a [T],
    },
    /// Axis-aligned boxes.
    Boxes {
        /// Minimum corners of the elements.
        min: &'a [[T; D]],
        /// Maximum corners of the elements.
        max: &'a [[T; D]],
    },
}

impl<'a, T: Real, const D: usize> Shapes<'a, T, D> {
    /// Centres or minimum corners.
    pub(crate) fn points(&self) -> &'a [[T; D]] {
        match self {
            Self::Equal { centres, .. } | Self::Spheres { centres, .. } => centres,
            Self::Boxes { min, .. } => min,
        }
    }

    /// These elements with their ids.
    pub(crate) fn view(&self, ids: &'a [u32], tolerance: T) -> ElementsView<'a, T, D> {
        let (radii, far_points): (&[T], &[[T; D]]) = match *self {
            Self::Equal { .. } => (&[], &[]),
            Self::Spheres { radii, .. } => (radii, &[]),
            Self::Boxes { max, .. } => (&[], max),
        };
        ElementsView {
            kind: self.kind(),
            tolerance,
            ids,
            points: self.points(),
            radii,
            far_points,
            periods: &[],
        }
    }

    pub(crate) fn kind(&self) -> ShapeKind<T> {
        match self {
            Self::Equal { radius, .. } => ShapeKind::Equal(*radius),
            Self::Spheres { .. } => ShapeKind::Spheres,
            Self::Boxes { .. } => ShapeKind::Boxes,
        }
    }

    /// The elements as the library of detection takes them. Checks every number.
    pub(crate) fn elements(&self, tolerance: T) -> Result<Elements<'a, T, D>, Error> {
        match *self {
            Self::Equal { centres, radius } => Elements::spheres(centres, radius),
            Self::Spheres { centres, radii } => Elements::spheres_with_radii(centres, radii),
            Self::Boxes { min, max } => Elements::boxes(min, max),
        }?
        .with_tolerance(tolerance)
    }
}

/// A kind of element, with the properties that all its elements share.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ShapeKind<T> {
    Equal(T),
    Spheres,
    Boxes,
}

impl<T> ShapeKind<T> {
    /// Number of bytes of an element in a message.
    pub(crate) fn bytes<const D: usize>(&self, is_periodic: bool) -> usize {
        let floats = match self {
            Self::Equal(_) => D,
            Self::Spheres => D + 1,
            Self::Boxes => 2 * D,
        };
        4 + 8 * floats + if is_periodic { 4 * D } else { 0 }
    }
}

/// Elements that the caller has given, or those of a [`ElementSet`], whose fields these are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ElementsView<'a, T, const D: usize> {
    pub(crate) kind: ShapeKind<T>,
    pub(crate) tolerance: T,
    pub(crate) ids: &'a [u32],
    pub(crate) points: &'a [[T; D]],
    pub(crate) radii: &'a [T],
    pub(crate) far_points: &'a [[T; D]],
    pub(crate) periods: &'a [[i32; D]],
}

/// Elements of one rank on their way into a [`ElementSet`]: the parts of a message.
pub(crate) struct Arrived<'a> {
    is_periodic: bool,
    ids: &'a [u8],
    points: &'a [u8],
    radii: &'a [u8],
    far_points: &'a [u8],
    periods: &'a [u8],
}

impl<'a> Arrived<'a> {
    /// Splits a message with the given number of elements.
    pub(crate) fn new<T, const D: usize>(
        mut bytes: &'a [u8],
        count: usize,
        kind: &ShapeKind<T>,
        is_periodic: bool,
    ) -> Self {
        let bytes = &mut bytes;
        Self {
            is_periodic,
            ids: part(bytes, 4 * count),
            points: part(bytes, 8 * D * count),
            radii: part(bytes, if matches!(kind, ShapeKind::Spheres) { 8 * count } else { 0 }),
            far_points: part(bytes, if matches!(kind, ShapeKind::Boxes) { 8 * D * count } else { 0 }),
            periods: bytes,
        }
    }

    /// The end of the message, after all elements have been read.
    pub(crate) fn rest(self) -> &'a [u8] {
        self.periods
    }
}

/// A set has room for one ghost per this number of elements, before memory is moved.
const GHOST_ROOM: usize = 8;

/// Elements that a rank owns or has been sent. Positions are those inside the periodic box, if there is one.
///
/// # Shapes
/// `ids`, `points`: `[n]`. `radii`: `[n]`, or empty unless spheres have radii. `far_points`: `[n]`, or empty
/// unless the elements are boxes. `periods`: `[n]`, or empty without a periodic box.
#[derive(Clone, Debug)]
pub(crate) struct ElementSet<T, const D: usize> {
    pub(crate) kind: ShapeKind<T>,
    pub(crate) tolerance: T,
    pub(crate) ids: Vec<u32>,
    pub(crate) points: Vec<[T; D]>,
    pub(crate) radii: Vec<T>,
    pub(crate) far_points: Vec<[T; D]>,
    /// Number of periods by which each element was outside of the box.
    pub(crate) periods: Vec<[i32; D]>,
}

/// The destinations of the elements of each run: messages for elements of other ranks, and a set for elements
/// of this rank.
struct Rooms<'a> {
    runs: &'a Runs,
    own: usize,
    /// Places in the set where this rank's elements start in each of its runs.
    starts: &'a [usize],
    /// Messages to all ranks, as far as nothing has been written; empty for this rank.
    messages: Vec<&'a mut [u8]>,
}

impl Rooms<'_> {
    /// Writes the values of all elements, behind the contents of the messages. `kept` are the values in the
    /// set.
    fn scatter<V: Copy, const B: usize, const N: usize>(
        &mut self,
        values: &[V],
        kept: &mut [V],
        bytes: impl Fn(V) -> [[u8; B]; N],
    ) {
        if values.is_empty() {
            return;
        }
        let Self { runs, own, starts, messages } = self;
        let mut rooms = Vec::with_capacity(runs.counts.len());
        for (rank, message) in messages.iter_mut().enumerate() {
            let counts = runs.counts[runs.of_rank(rank)].iter();
            rooms.extend(counts.map(|count| message.split_off_mut(..count * B * N).unwrap_or_default()));
        }
        let own_runs = runs.of_rank(*own);
        let (mut rest, mut end) = (kept, 0);
        let mut kept: Vec<&mut [V]> = Vec::with_capacity(own_runs.len());
        for (&start, &count) in starts.iter().zip(&runs.counts[own_runs.clone()]) {
            rest = std::mem::take(&mut rest).split_at_mut(start - end).1;
            kept.push(rest.split_off_mut(..count).unwrap_or_default());
            end = start + count;
        }
        for (&value, &run) in values.iter().zip(&runs.of) {
            let run = run as usize;
            if let Some(room) = rooms[run].split_off_mut(..B * N) {
                room.copy_from_slice(bytes(value).as_flattened());
            } else if let Some(place) = kept[run - own_runs.start].split_off_first_mut() {
                *place = value;
            }
        }
    }
}

impl<T: Real, const D: usize> ElementsView<'_, T, D> {
    pub(crate) fn len(&self) -> usize {
        self.ids.len()
    }

    /// Writes the elements at these places, whose number the reader knows.
    pub(crate) fn write(&self, places: impl Iterator<Item = u32> + Clone, out: &mut Vec<u8>) {
        let at = |place: u32| place as usize;
        put_all(places.clone().map(|place| self.ids[at(place)]), out);
        put_points(places.clone().map(|place| self.points[at(place)]), out);
        if !self.radii.is_empty() {
            put_all(places.clone().map(|place| self.radii[at(place)].to_f64()), out);
        }
        if !self.far_points.is_empty() {
            put_points(places.clone().map(|place| self.far_points[at(place)]), out);
        }
        if !self.periods.is_empty() {
            put_all(places.map(|place| self.periods[at(place)]), out);
        }
    }

    /// Puts the elements that rank `own`, this one, keeps into a set, and returns messages with the others,
    /// run by run. `starts` are the places in the set where they start in each run. [`Arrived`] reads a
    /// message.
    pub(crate) fn scatter(
        &self,
        runs: &Runs,
        own: usize,
        starts: &[usize],
        set: &mut ElementSet<T, D>,
    ) -> Vec<Message> {
        let ranks = 0..runs.firsts.len() - 1;
        let of_each = self.kind.bytes::<D>(!self.periods.is_empty());
        let empty = ranks.map(|rank| {
            let count: usize = runs.counts[runs.of_rank(rank)].iter().sum();
            Message { rank, bytes: vec![0; if rank == own { 0 } else { count * of_each }] }
        });
        let mut messages: Vec<Message> = empty.collect();
        let in_messages = messages.iter_mut().map(|message| &mut message.bytes[..]).collect();
        let mut rooms = Rooms { runs, own, starts, messages: in_messages };
        let axes = |point: [T; D]| point.map(|x| x.to_f64().to_le_bytes());
        rooms.scatter(self.ids, &mut set.ids, |id| [id.to_le_bytes()]);
        rooms.scatter(self.points, &mut set.points, axes);
        rooms.scatter(self.radii, &mut set.radii, |radius| [radius.to_f64().to_le_bytes()]);
        rooms.scatter(self.far_points, &mut set.far_points, axes);
        rooms.scatter(self.periods, &mut set.periods, |periods| periods.map(i32::to_le_bytes));
        messages.retain(|message| !message.bytes.is_empty());
        messages
    }

    /// Class of similar sizes: the binary exponent of the largest distance at which an element touches
    /// another one of its size.
    ///
    /// It is a function of the element alone, so that all ranks agree on it.
    pub(crate) fn level(&self, place: usize) -> u16 {
        (self.reach(place).to_bits() >> 52) as u16
    }

    /// The largest distance at which an element touches another one of its size, up to rounding.
    pub(crate) fn reach(&self, place: usize) -> f64 {
        let size = match self.kind {
            ShapeKind::Equal(radius) => 2.0 * radius.to_f64(),
            ShapeKind::Spheres => 2.0 * self.radii[place].to_f64(),
            ShapeKind::Boxes => (0..D).fold(0.0, |most: f64, axis| {
                most.max(self.far_points[place][axis].to_f64() - self.points[place][axis].to_f64())
            }),
        };
        size + self.tolerance.to_f64()
    }
}

impl<T: Real, const D: usize> ElementSet<T, D> {
    pub(crate) fn new(kind: ShapeKind<T>, tolerance: T) -> Self {
        Self {
            kind,
            tolerance,
            ids: Vec::new(),
            points: Vec::new(),
            radii: Vec::new(),
            far_points: Vec::new(),
            periods: Vec::new(),
        }
    }

    /// Copies the caller's elements, wrapped into the box. They have been checked. Errors name elements by
    /// their place.
    pub(crate) fn wrapped(
        ids: &[u32],
        shapes: &Shapes<'_, T, D>,
        tolerance: T,
        cell: &PeriodicBox<T, D>,
    ) -> Result<Self, Error> {
        let mut set = Self::new(shapes.kind(), tolerance);
        set.ids = ids.to_vec();
        set.points = shapes.points().to_vec();
        match shapes {
            Shapes::Equal { .. } => {}
            Shapes::Spheres { radii, .. } => set.radii = radii.to_vec(),
            Shapes::Boxes { max, .. } => set.far_points = max.to_vec(),
        }
        set.periods.reserve_exact(set.points.len());
        for (index, point) in set.points.iter_mut().enumerate() {
            let Some((inside, periods)) = cell.wrap(*point) else { return Err(too_far(cell, index, point)) };
            *point = inside;
            if let Some(far) = set.far_points.get_mut(index).filter(|_| periods != [0; D]) {
                *far = cell.displaced(far, &periods.map(|n| -n));
            }
            set.periods.push(periods);
        }
        Ok(set)
    }

    pub(crate) fn len(&self) -> usize {
        self.ids.len()
    }

    pub(crate) fn view(&self) -> ElementsView<'_, T, D> {
        ElementsView {
            kind: self.kind,
            tolerance: self.tolerance,
            ids: &self.ids,
            points: &self.points,
            radii: &self.radii,
            far_points: &self.far_points,
            periods: &self.periods,
        }
    }

    /// A set of the given number of elements, whose numbers are zeros, with room for some ghosts.
    pub(crate) fn blank(kind: ShapeKind<T>, tolerance: T, count: usize, is_periodic: bool) -> Self {
        /// Zeros come from the system without being written.
        fn zeros<V: Clone>(zero: V, count: usize) -> Vec<V> {
            let mut values = vec![zero; count + count / GHOST_ROOM];
            values.truncate(count);
            values
        }
        let count_if = |is_there: bool| if is_there { count } else { 0 };
        Self {
            kind,
            tolerance,
            ids: zeros(0, count),
            points: zeros([T::ZERO; D], count),
            radii: zeros(T::ZERO, count_if(matches!(kind, ShapeKind::Spheres))),
            far_points: zeros([T::ZERO; D], count_if(matches!(kind, ShapeKind::Boxes))),
            periods: zeros([0; D], count_if(is_periodic)),
        }
    }

    /// Replaces elements by the next ones of a message.
    pub(crate) fn place(&mut self, places: Range<usize>, from: &mut Arrived<'_>) {
        fn put<V>(places: Option<&mut [V]>, values: impl Iterator<Item = V>) {
            places.unwrap_or_default().iter_mut().zip(values).for_each(|(place, value)| *place = value);
        }
        let count = places.len();
        put(self.ids.get_mut(places.clone()), take_all::<u32>(&mut from.ids, count));
        put(self.points.get_mut(places.clone()), take_points::<T, D>(&mut from.points, count));
        match self.kind {
            ShapeKind::Equal(_) => {}
            ShapeKind::Spheres => {
                let radii = take_all::<f64>(&mut from.radii, count).map(T::nearest);
                put(self.radii.get_mut(places.clone()), radii);
            }
            ShapeKind::Boxes => {
                put(
                    self.far_points.get_mut(places.clone()),
                    take_points::<T, D>(&mut from.far_points, count),
                );
            }
        }
        if from.is_periodic {
            put(self.periods.get_mut(places), take_all::<[i32; D]>(&mut from.periods, count));
        }
    }

    /// The elements as the library of detection takes them.
    pub(crate) fn elements(&self) -> Result<Elements<'_, T, D>, Error> {
        match self.kind {
            ShapeKind::Equal(radius) => Elements::spheres(&self.points, radius),
            ShapeKind::Spheres => Elements::spheres_with_radii(&self.points, &self.radii),
            ShapeKind::Boxes => Elements::boxes(&self.points, &self.far_points),
        }?
        .with_tolerance(self.tolerance)
    }

    /// Level of an element: see [`ElementsView::level`].
    #[inline]
    pub(crate) fn level(&self, place: usize) -> u16 {
        self.view().level(place)
    }

    /// Appends elements of the same kind.
    pub(crate) fn append(&mut self, others: &Self) {
        self.ids.extend_from_slice(&others.ids);
        self.points.extend_from_slice(&others.points);
        self.radii.extend_from_slice(&others.radii);
        self.far_points.extend_from_slice(&others.far_points);
        self.periods.extend_from_slice(&others.periods);
    }

    /// Gives each sphere its own radius, so that some can be widened.
    pub(crate) fn with_radii(&mut self) {
        if let ShapeKind::Equal(radius) = self.kind {
            self.radii = vec![radius; self.len()];
            self.kind = ShapeKind::Spheres;
        }
    }

    /// Displaces an element by edges of the box, and widens it on all sides.
    pub(crate) fn displace(&mut self, place: usize, cell: &PeriodicBox<T, D>, shift: &[i32; D], by: f64) {
        self.points[place] = cell.displaced(&self.points[place], shift);
        match self.kind {
            ShapeKind::Equal(_) => {}
            ShapeKind::Spheres => self.radii[place] = T::at_least(self.radii[place].to_f64() + by),
            ShapeKind::Boxes => {
                let far = cell.displaced(&self.far_points[place], shift);
                self.far_points[place] = far.map(|x| T::at_least(x.to_f64() + by));
                let near = self.points[place];
                self.points[place] = near.map(|x| T::ZERO - T::at_least(by - x.to_f64()));
            }
        }
    }

    /// Whether element `i` touches the image of element `j` that is displaced by `shift`, by the comparison
    /// of [`PeriodicSearch`](fdem_contact::PeriodicSearch).
    pub(crate) fn touches_image(
        &self,
        i: usize,
        j: (&Self, usize),
        cell: &PeriodicBox<T, D>,
        shift: &[i32; D],
    ) -> bool {
        let (others, j) = j;
        let points = [self.points[i], cell.displaced(&others.points[j], shift)];
        let elements = match self.kind {
            ShapeKind::Equal(radius) => Elements::spheres(&points, radius).and_then(|pair| self.touch(pair)),
            ShapeKind::Spheres => {
                let radii = [self.radii[i], others.radii[j]];
                Elements::spheres_with_radii(&points, &radii).and_then(|pair| self.touch(pair))
            }
            ShapeKind::Boxes => {
                let far = [self.far_points[i], cell.displaced(&others.far_points[j], shift)];
                Elements::boxes(&points, &far).and_then(|pair| self.touch(pair))
            }
        };
        // The numbers have been checked, and an image that is too far away for squares was refused with its
        // ghost.
        elements.unwrap_or(false)
    }

    fn touch(&self, pair: Elements<'_, T, D>) -> Result<bool, Error> {
        Ok(pair.with_tolerance(self.tolerance)?.touch(0, 1))
    }
}

/// The error of a point that cannot be wrapped.
fn too_far<T: Real, const D: usize>(cell: &PeriodicBox<T, D>, index: usize, point: &[T; D]) -> Error {
    const LIMIT: f64 = 268_435_456.0;
    let fractions = cell.fractions(point);
    let is_near = |edge: usize| fractions[edge].abs() <= LIMIT;
    let is_far = |edge: &usize| cell.periodic()[*edge] && !is_near(*edge);
    let edge = (0..D).find(is_far).unwrap_or_default();
    Error::TooFarFromBox { index, edge, periods: fractions[edge], limit: LIMIT }
}
