//! The lists of the C-grid: bodies enter at their minimum, leave at their maximum, and are spread axis by
//! axis down to cells.

use crate::couple::Couple;
use crate::elements::{Bounds, Elements, Shape};
use crate::error::Error;
use crate::filter::Filter;
use crate::geometry::Geometry;
use crate::lists::NONE;
use crate::memory::reserve;
use crate::real::Real;
use crate::search::cgrid::levels::MOST_AXES;
use crate::search::cgrid::spans::Spans;
use crate::stop::Stop;

/// A body on the lists along one axis.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// "In": the slab in which it enters.
    enters: u32,
    /// "Out": the last slab in which it is.
    leaves: u32,
    /// Its place in the order of a list, given by the slabs on the axes below.
    order: u32,
    /// The next body on the list.
    next: u32,
}

/// The number of a body and the cell in which it enters, for sorting.
#[derive(Clone, Copy, Debug)]
struct Key {
    cell: u64,
    body: u32,
}

/// Counts of the operations of one level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counted {
    pub(super) entries: u64,
    pub(super) tests: u64,
}

/// The bodies of a level and the finer bodies that may touch them, with the memory for their lists.
#[derive(Clone, Debug)]
pub(super) struct Bodies<T, const D: usize> {
    /// The numbers of the elements; in the order of the lists once they are sorted.
    numbers: Vec<u32>,
    unsorted: Vec<u32>,
    points: Vec<[T; D]>,
    far_points: Vec<[T; D]>,
    radii: Vec<T>,
    /// One array of places for each axis.
    places: Vec<Vec<Place>>,
    sorted_places: Vec<Place>,
    /// Bits of each body: one for every axis but the first, set in the slab in which the body enters, and
    /// [`OWN`].
    entered: Vec<u32>,
    keys: Vec<Key>,
    sorted_keys: Vec<Key>,
    /// The cells along one axis in which bodies enter.
    slabs: Vec<u64>,
}

/// Marks a body of this level, as opposed to a finer level. The first axis needs no bit, so its bit is free.
const OWN: u32 = 1;

/// Number of axes whose bits separate the lists of a cell: there is one list for each combination of these
/// bits and [`OWN`].
const TOLD_APART: usize = 4;
const LISTS: usize = 1 << (1 + TOLD_APART);

/// The origin of the cells and the number of cells per unit length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells<const D: usize> {
    pub(super) origin: [f64; D],
    pub(super) inverse: f64,
}

impl<const D: usize> Cells<D> {
    /// The cell of a coordinate. The couples depend only on this: the cell does not descend while the
    /// coordinate ascends. Each operation below preserves that.
    #[inline]
    fn of(&self, axis: usize, x: f64) -> u64 {
        ((x - self.origin[axis]) * self.inverse) as u64
    }
}

impl<T: Real, const D: usize> Bodies<T, D> {
    const AXES: usize = if D < MOST_AXES { D } else { MOST_AXES };

    pub(super) fn new() -> Self {
        Self {
            numbers: Vec::new(),
            unsorted: Vec::new(),
            points: Vec::new(),
            far_points: Vec::new(),
            radii: Vec::new(),
            places: vec![Vec::new(); Self::AXES],
            sorted_places: Vec::new(),
            entered: Vec::new(),
            keys: Vec::new(),
            sorted_keys: Vec::new(),
            slabs: Vec::new(),
        }
    }

    /// Reserves memory for `bodies` bodies.
    pub(super) fn reserve(&mut self, elements: &Elements<'_, T, D>, bodies: usize) -> Result<(), Error> {
        fn exactly<V>(values: &mut Vec<V>, count: usize) -> Result<(), Error> {
            values.clear();
            reserve(values, count)
        }
        let [far, radii] = Self::extra(elements);
        exactly(&mut self.numbers, bodies)?;
        exactly(&mut self.unsorted, bodies)?;
        exactly(&mut self.points, bodies)?;
        exactly(&mut self.far_points, far * bodies)?;
        exactly(&mut self.radii, radii * bodies)?;
        self.places.iter_mut().try_for_each(|places| exactly(places, bodies))?;
        exactly(&mut self.sorted_places, bodies)?;
        exactly(&mut self.entered, bodies)?;
        exactly(&mut self.keys, bodies)?;
        exactly(&mut self.sorted_keys, bodies)?;
        exactly(&mut self.slabs, bodies)
    }

    /// 1 or 0: whether bodies have far points, and whether they have radii.
    fn extra(elements: &Elements<'_, T, D>) -> [usize; 2] {
        match elements.shape {
            Shape::Equal(_) => [0, 0],
            Shape::Spheres(_) => [0, 1],
            Shape::Boxes(_) => [1, 0],
        }
    }

    pub(super) fn bytes(&self) -> usize {
        (self.numbers.capacity() + self.unsorted.capacity() + self.entered.capacity()) * size_of::<u32>()
            + (self.points.capacity() + self.far_points.capacity()) * size_of::<[T; D]>()
            + self.radii.capacity() * size_of::<T>()
            + (self.places.iter().map(Vec::capacity).sum::<usize>() + self.sorted_places.capacity())
                * size_of::<Place>()
            + (self.keys.capacity() + self.sorted_keys.capacity()) * size_of::<Key>()
            + self.slabs.capacity() * size_of::<u64>()
    }

    /// [`Bodies::bytes`] after [`Bodies::reserve`] in new memory.
    pub(super) fn expected_bytes(elements: &Elements<'_, T, D>, bodies: usize) -> usize {
        let [far, radii] = Self::extra(elements);
        let each = 3 * size_of::<u32>()
            + (1 + far) * size_of::<[T; D]>()
            + radii * size_of::<T>()
            + (Self::AXES + 1) * size_of::<Place>()
            + 2 * size_of::<Key>()
            + size_of::<u64>();
        bodies * each
    }

    /// Takes in bodies in ascending order, each with whether it belongs to this level.
    pub(super) fn fill(&mut self, bodies: impl Iterator<Item = (u32, bool)>) {
        self.unsorted.clear();
        self.entered.clear();
        for (number, own) in bodies {
            self.unsorted.push(number);
            self.entered.push(if own { OWN } else { 0 });
        }
    }

    /// Sorts the bodies by the cells in which they enter: by the last axis, then by the axis before, and so
    /// on, then by number.
    ///
    /// There is one stable pass per axis, the first axis first. The cells of an axis are numbered from 0.
    /// Cells in which nothing enters get no number, because no couple is reported there.
    pub(super) fn sort(&mut self, spans: Spans<'_, '_, T, D>, cells: &Cells<D>) {
        let Self { unsorted, keys, sorted_keys, slabs, places, .. } = self;
        keys.clear();
        keys.extend((0..unsorted.len() as u32).map(|body| Key { cell: 0, body }));
        for set in places.iter_mut() {
            set.clear();
            set.resize(unsorted.len(), Place::default());
        }
        for axis in 0..Self::AXES {
            let ends =
                |key: &Key| spans.span(unsorted[key.body as usize] as usize, axis).map(|x| cells.of(axis, x));
            for key in keys.iter_mut() {
                key.cell = ends(key)[0];
            }
            sort_keys(keys, sorted_keys);
            slabs.clear();
            for (order, key) in (0..).zip(keys.iter()) {
                if slabs.last() != Some(&key.cell) {
                    slabs.push(key.cell);
                }
                places[axis][key.body as usize].enters = slabs.len() as u32 - 1;
                if axis + 1 < Self::AXES {
                    places[axis + 1][key.body as usize].order = order;
                }
            }
            for key in keys.iter() {
                let place = &mut places[axis][key.body as usize];
                place.leaves = last_up_to(slabs, place.enters, ends(key)[1]);
            }
        }
        self.arrange(spans.elements());
    }

    /// Puts the data of the bodies into their order.
    fn arrange(&mut self, elements: &Elements<'_, T, D>) {
        let order = || self.keys.iter().map(|key| key.body as usize);
        for set in &mut self.places {
            self.sorted_places.clear();
            self.sorted_places.extend(order().map(|body| set[body]));
            std::mem::swap(set, &mut self.sorted_places);
        }
        self.numbers.clear();
        self.numbers.extend(order().map(|body| self.entered[body]));
        self.entered.copy_from_slice(&self.numbers);
        self.numbers.clear();
        self.numbers.extend(order().map(|body| self.unsorted[body]));

        let (points, far_points, radii): (_, &[_], &[_]) = match elements.shape {
            Shape::Equal(equal) => (equal.points(), &[], &[]),
            Shape::Spheres(spheres) => (spheres.points(), &[], spheres.radii()),
            Shape::Boxes(boxes) => (boxes.points(), boxes.far_points(), &[]),
        };
        let numbers = || self.numbers.iter().map(|&number| number as usize);
        self.points.clear();
        self.points.extend(numbers().map(|number| points[number]));
        self.far_points.clear();
        self.radii.clear();
        if !far_points.is_empty() {
            self.far_points.extend(numbers().map(|number| far_points[number]));
        }
        if !radii.is_empty() {
            self.radii.extend(numbers().map(|number| radii[number]));
        }
    }

    /// Calls `visit` with all couples of two bodies of this level, or of one body of this level and one of a
    /// finer level.
    pub(super) fn search(
        &mut self,
        elements: &Elements<'_, T, D>,
        stop: &Stop,
        visit: &mut dyn FnMut(Couple),
    ) -> Result<Counted, Error> {
        let Self { numbers, points, far_points, radii, places, entered, .. } = self;
        let bounds = elements.bounds();
        let bounds = Bounds { min: bounds.min, max: bounds.max };
        let sorted = elements.at(points, far_points, radii, bounds, None)?;
        let lists = (places.as_mut_slice(), entered.as_mut_slice());
        let filter = elements.filter();
        match (sorted.shape, filter) {
            (Shape::Equal(geometry), None) => pass(geometry, numbers, lists, stop, visit),
            (Shape::Spheres(geometry), None) => pass(geometry, numbers, lists, stop, visit),
            (Shape::Boxes(geometry), None) => pass(geometry, numbers, lists, stop, visit),
            (Shape::Equal(geometry), Some(filter)) => {
                pass(Seen { geometry, filter, numbers }, numbers, lists, stop, visit)
            }
            (Shape::Spheres(geometry), Some(filter)) => {
                pass(Seen { geometry, filter, numbers }, numbers, lists, stop, visit)
            }
            (Shape::Boxes(geometry), Some(filter)) => {
                pass(Seen { geometry, filter, numbers }, numbers, lists, stop, visit)
            }
        }
    }
}

/// The last of `slabs`, which are ascending cells, that is at most `cell`. Searches from `first`, which is at
/// most `cell`, in steps that double.
fn last_up_to(slabs: &[u64], first: u32, cell: u64) -> u32 {
    let (mut low, mut leap) = (first as usize, 1);
    while low + leap < slabs.len() && slabs[low + leap] <= cell {
        low += leap;
        leap *= 2;
    }
    let high = slabs.len().min(low + leap);
    (low + slabs[low + 1..high].partition_point(|&other| other <= cell)) as u32
}

/// Sorts by cell, digit by digit; the order of equal cells is kept.
fn sort_keys(keys: &mut Vec<Key>, other: &mut Vec<Key>) {
    const DIGITS: usize = 1 << 11;
    let most = keys.iter().fold(0, |most, key| most | key.cell);
    if keys.is_sorted_by_key(|key| key.cell) {
        return;
    }
    // With few keys, large digits would leave most counts empty.
    let bits = if keys.len() < DIGITS { 6 } else { DIGITS.ilog2() };
    let mut starts = [0_u32; DIGITS];
    for shift in (0..u64::BITS - most.leading_zeros()).step_by(bits as usize) {
        let starts = &mut starts[..1 << bits];
        let digit = |key: &Key| (key.cell >> shift) as usize & ((1 << bits) - 1);
        starts.fill(0);
        for key in keys.iter() {
            starts[digit(key)] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            (*start, sum) = (sum, sum + *start);
        }
        other.clear();
        other.resize(keys.len(), Key { cell: 0, body: 0 });
        for key in keys.iter() {
            let start = &mut starts[digit(key)];
            other[*start as usize] = *key;
            *start += 1;
        }
        std::mem::swap(keys, other);
    }
}

/// The geometry and the filter of sorted bodies; the filter needs the numbers of their elements.
#[derive(Clone, Copy)]
struct Seen<'a, G> {
    geometry: G,
    filter: Filter<'a>,
    numbers: &'a [u32],
}

impl<G: Geometry> Geometry for Seen<'_, G> {
    fn len(self) -> usize {
        self.geometry.len()
    }

    fn anchor(self, index: usize, axis: usize) -> f64 {
        self.geometry.anchor(index, axis)
    }

    #[inline]
    fn touch(self, i: usize, j: usize) -> bool {
        self.geometry.touch(i, j) && self.filter.admits(self.numbers[i] as usize, self.numbers[j] as usize)
    }
}

fn pass(
    geometry: impl Geometry,
    numbers: &[u32],
    (places, entered): (&mut [Vec<Place>], &mut [u32]),
    stop: &Stop,
    visit: &mut dyn FnMut(Couple),
) -> Result<Counted, Error> {
    let axes = places.len();
    let first = if numbers.is_empty() { NONE } else { 0 };
    let mut pass = CgridPass { geometry, numbers, places, entered, stop, visit, counted: Counted::default() };
    pass.spread(axes - 1, first)?;
    Ok(pass.counted)
}

/// One detection in progress.
struct CgridPass<'s, G> {
    geometry: G,
    numbers: &'s [u32],
    places: &'s mut [Vec<Place>],
    entered: &'s mut [u32],
    stop: &'s Stop,
    /// A trait object, so that the code is compiled once: couples are few compared with tests.
    visit: &'s mut dyn FnMut(Couple),
    counted: Counted,
}

impl<G: Geometry> CgridPass<'_, G> {
    /// The sub-divider: spreads the list of a slab of the axis above over the slabs of `axis`, one after the
    /// other, and each of these over the axis below.
    ///
    /// `first` is the first body of the list, which is in the order in which bodies enter along `axis`. The
    /// list of `axis` holds the bodies of one slab. From slab to slab bodies enter and leave, and the list
    /// keeps the order of the axis below.
    fn spread(&mut self, axis: usize, first: u32) -> Result<(), Error> {
        if axis == 0 {
            return self.cells(first);
        }
        let bit = 1 << axis;
        // At least one of two bodies must have entered here, and likewise on each axis above, and one must
        // belong to this level.
        let needed = ((1_u32 << self.places.len()) - bit) | OWN;
        let (mut head, mut entering) = (NONE, first);
        while entering != NONE {
            let slab = self.places[axis][entering as usize].enters;
            let (mut old, mut last, mut met) = (head, NONE, 0);
            loop {
                while old != NONE && self.places[axis][old as usize].leaves < slab {
                    old = self.places[axis][old as usize].next;
                }
                let enters = entering != NONE && self.places[axis][entering as usize].enters == slab;
                let order = |body: u32| self.places[axis][body as usize].order;
                let body = if enters && (old == NONE || order(entering) < order(old)) {
                    let body = entering;
                    self.entered[body as usize] |= bit;
                    entering = self.after(axis + 1, body);
                    body
                } else if old != NONE {
                    let body = old;
                    self.entered[body as usize] &= !bit;
                    old = self.places[axis][body as usize].next;
                    body
                } else {
                    break;
                };
                met |= self.entered[body as usize];
                if last == NONE {
                    head = body;
                } else {
                    self.places[axis][last as usize].next = body;
                }
                last = body;
                self.counted.entries += 1;
            }
            // At least one body has entered.
            self.places[axis][last as usize].next = NONE;
            if met & needed == needed {
                self.spread(axis - 1, head)?;
            }
        }
        Ok(())
    }

    /// The next body on a list of `axis`; above the last axis, the next body in order.
    #[inline]
    fn after(&self, axis: usize, body: u32) -> u32 {
        if axis < self.places.len() {
            self.places[axis][body as usize].next
        } else if (body as usize) + 1 < self.numbers.len() {
            body + 1
        } else {
            NONE
        }
    }

    /// Handles the first axis, whose slabs are cells: each body that enters is compared with those that are
    /// in the cell.
    ///
    /// Two bodies are compared where, on every axis, one of them enters while the other is present: in the
    /// cell of the larger of their minimum corners, and in no other.
    fn cells(&mut self, first: u32) -> Result<(), Error> {
        let all = (1_u32 << self.places.len()) - 1;
        let mut heads = [NONE; LISTS];
        let lists = LISTS.min(1 << self.places.len());
        let mut body = first;
        while body != NONE {
            self.stop.go_on()?;
            let entered = self.entered[body as usize];
            let needed = all & !entered;
            let own = (entered as usize) & (lists - 1);
            for (list, head) in heads[..lists].iter_mut().enumerate() {
                if *head != NONE && (list as u32 & needed) == needed & (LISTS as u32 - 1) {
                    self.compare(body, needed, head);
                }
            }
            self.places[0][body as usize].next = heads[own];
            heads[own] = body;
            self.counted.entries += 1;
            body = self.after(1, body);
        }
        Ok(())
    }

    /// Compares a body with those on a list that have entered on the axes on which it has not. Takes bodies
    /// off the list that have left the cell.
    #[inline]
    fn compare(&mut self, body: u32, needed: u32, head: &mut u32) {
        let cell = self.places[0][body as usize].enters;
        let (mut last, mut other) = (NONE, *head);
        while other != NONE {
            let Place { leaves, next, .. } = self.places[0][other as usize];
            if leaves < cell {
                if last == NONE {
                    *head = next;
                } else {
                    self.places[0][last as usize].next = next;
                }
            } else {
                last = other;
                if self.entered[other as usize] & needed == needed {
                    self.counted.tests += 1;
                    if self.geometry.touch(body as usize, other as usize) {
                        let [body, other] = [body, other].map(|body| self.numbers[body as usize]);
                        (self.visit)(Couple::new(body, other));
                    }
                }
            }
            other = next;
        }
    }
}
