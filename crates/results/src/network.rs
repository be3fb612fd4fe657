//! Contact networks: elements and their couples, as they are analysed, drawn and written.
//!
//! ```text
//! Space (centres, box) ─┐
//! Sizes ────────────────┼─> Network ──> distances, overlaps, branch vectors
//! Couples ──────────────┘
//! ```

use std::any::Any;

use fdem_contact::{Couple, PeriodicBox, PeriodicCouple};

use crate::arrays::each;
pub use crate::pair_cutoffs::PairCutoffs;

/// The sizes of the elements.
///
/// # Units
/// The length unit of the centres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sizes<'a> {
    /// A radius for each element.
    Each(&'a [f64]),
    /// One radius for all.
    All(f64),
    /// Points, two of which touch if they are not farther apart than this.
    Cutoff(f64),
    /// Points, two of which touch if they are not farther apart than the cut-off of their types.
    Pairs(&'a PairCutoffs),
}

impl Sizes<'_> {
    /// Distance at which two elements touch, rounded as the search rounds it; negative if they never touch.
    ///
    /// # Panics
    /// If an element of the couple has no radius.
    #[inline]
    pub fn contact_distance(&self, couple: Couple) -> f64 {
        match *self {
            Self::Each(radii) => radii[couple.i as usize] + radii[couple.j as usize],
            Self::All(radius) => radius + radius,
            Self::Cutoff(cutoff) => cutoff,
            Self::Pairs(cutoffs) => cutoffs.of(couple.i, couple.j).unwrap_or(f64::NEG_INFINITY),
        }
    }

    /// Radius of an element; for a point, half the largest distance at which it may touch another.
    ///
    /// # Panics
    /// If the element has no radius.
    pub fn radius(&self, index: usize) -> f64 {
        match *self {
            Self::Each(radii) => radii[index],
            Self::All(radius) => radius,
            Self::Cutoff(cutoff) => cutoff / 2.0,
            Self::Pairs(cutoffs) => cutoffs.largest() / 2.0,
        }
    }

    /// The largest distance at which two points touch; `None` for elements that have radii.
    pub fn cutoff(&self) -> Option<f64> {
        match *self {
            Self::Each(_) | Self::All(_) => None,
            Self::Cutoff(cutoff) => Some(cutoff),
            Self::Pairs(cutoffs) => Some(cutoffs.largest()),
        }
    }

    /// Whether the elements are points.
    pub fn are_points(&self) -> bool {
        self.cutoff().is_some()
    }
}

/// Positions of the elements, in open space or in a periodic box.
#[derive(Clone, Copy, Debug)]
pub struct Space<'a, const D: usize> {
    /// Centres of the elements, inside or outside of the box.
    pub centres: &'a [[f64; D]],
    /// The periodic box.
    pub cell: Option<PeriodicBox<f64, D>>,
}

impl<'a, const D: usize> Space<'a, D> {
    /// The same space, if its dimension is `E`.
    pub(crate) fn of_dimension<const E: usize>(&self) -> Option<Space<'a, E>> {
        let cell = *(&self.cell as &dyn Any).downcast_ref()?;
        Some(Space { centres: self.centres.as_flattened().as_chunks().0, cell })
    }

    /// Distance of the first element of a couple to the image of the second, between the points that the
    /// library compares, so that couples that touch by its comparison overlap by at least zero.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    #[inline]
    pub fn distance(&self, couple: PeriodicCouple<D>) -> f64 {
        self.distance_squared(couple).sqrt()
    }

    /// The square of [`Self::distance`], which the library compares.
    #[inline]
    pub(crate) fn distance_squared(&self, couple: PeriodicCouple<D>) -> f64 {
        let [a, b] = self.ends(couple);
        // Every couple comes here: `zip` would be a call in a crate of several units (see `arrays.rs`).
        let mut square = 0.0;
        for axis in 0..D {
            square += (a[axis] - b[axis]) * (a[axis] - b[axis]);
        }
        square
    }

    /// Vector from the first element of a couple to the image of the second.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    #[inline]
    pub fn branch(&self, couple: PeriodicCouple<D>) -> [f64; D] {
        let [a, b] = self.ends(couple);
        each(|axis| b[axis] - a[axis])
    }

    /// Position of the first element of a couple, wrapped into the box if there is one, and of the image of
    /// the second that touches it there.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    #[inline]
    pub fn ends(&self, couple: PeriodicCouple<D>) -> [[f64; D]; 2] {
        match &self.cell {
            None => [self.centres[couple.i as usize], self.centres[couple.j as usize]],
            Some(cell) => self.ends_in(cell, couple),
        }
    }

    /// [`Self::ends`] in a periodic box.
    fn ends_in(&self, cell: &PeriodicBox<f64, D>, couple: PeriodicCouple<D>) -> [[f64; D]; 2] {
        let PeriodicCouple { i, j, shift } = couple;
        let ((a, of_a), (b, of_b)) = (self.wrapped(cell, i), self.wrapped(cell, j));
        let shift = each(|edge| shift[edge] - of_a[edge] + of_b[edge]);
        [a, cell.displaced(&b, &shift)]
    }

    /// Overlap of the elements of a couple: the distance at which they touch minus their distance. Negative
    /// for a gap within the tolerance.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    #[inline]
    pub fn overlap(&self, sizes: Sizes<'_>, couple: PeriodicCouple<D>) -> f64 {
        sizes.contact_distance(Couple { i: couple.i, j: couple.j }) - self.distance(couple)
    }

    /// Position of the centre in the box, and the number of periods by which it was outside.
    ///
    /// # Panics
    /// If the element has no centre that a search would have taken.
    pub fn wrapped(&self, cell: &PeriodicBox<f64, D>, element: u32) -> ([f64; D], [i32; D]) {
        cell.wrap(self.centres[element as usize]).expect("elements that were searched can be wrapped")
    }
}

/// Couples, with shifts if the box is periodic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Couples<const D: usize> {
    /// Couples in open space.
    Plain(Vec<Couple>),
    /// Couples in a periodic box.
    Periodic(Vec<PeriodicCouple<D>>),
}

impl<const D: usize> Couples<D> {
    /// Number of couples.
    pub fn len(&self) -> usize {
        match self {
            Self::Plain(couples) => couples.len(),
            Self::Periodic(couples) => couples.len(),
        }
    }

    /// Whether there are no couples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The couple at a place in the list; its shift is 0 in open space.
    ///
    /// # Panics
    /// If the list is shorter.
    #[inline]
    pub fn get(&self, k: usize) -> PeriodicCouple<D> {
        match self {
            Self::Plain(couples) => unshifted(couples[k]),
            Self::Periodic(couples) => couples[k],
        }
    }

    /// All couples in order; their shift is 0 in open space.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = PeriodicCouple<D>> + '_ {
        (0..self.len()).map(|k| self.get(k))
    }
}

/// A couple with a shift of 0.
#[inline]
pub fn unshifted<const D: usize>(Couple { i, j }: Couple) -> PeriodicCouple<D> {
    PeriodicCouple { i, j, shift: [0; D] }
}

/// A packing and its couples.
///
/// # Shapes
/// Couples contain indices of `space.centres`; [`Sizes::Each`] has one radius for each centre. There is one
/// force for each couple.
#[derive(Clone, Copy, Debug)]
pub struct Network<'a, const D: usize> {
    /// Positions of the elements.
    pub space: Space<'a, D>,
    /// Sizes of the elements.
    pub sizes: Sizes<'a>,
    /// Couples that touch: `i < j`, or `i` and the image of `j` by its shift.
    pub couples: &'a Couples<D>,
    /// The force on `i` by `j` of each couple, if the forces are known.
    pub forces: Option<&'a [[f64; D]]>,
}

impl<'a, const D: usize> Network<'a, D> {
    /// The same network, if its dimension is `E`.
    pub(crate) fn of_dimension<const E: usize>(&self) -> Option<Network<'a, E>> {
        let couples = (self.couples as &'a dyn Any).downcast_ref()?;
        let forces = self.forces.map(|forces| forces.as_flattened().as_chunks().0);
        Some(Network { space: self.space.of_dimension()?, sizes: self.sizes, couples, forces })
    }

    /// Overlap of a couple, as [`Space::overlap`] defines it.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    #[inline]
    pub fn overlap(&self, couple: PeriodicCouple<D>) -> f64 {
        self.space.overlap(self.sizes, couple)
    }

    /// The magnitude of the force of each couple, if the forces are known.
    pub fn magnitudes(&self) -> Option<Vec<f64>> {
        Some(self.forces?.iter().map(magnitude).collect())
    }
}

/// The length of a force. It does not overflow if the length does not.
pub(crate) fn magnitude<const D: usize>(force: &[f64; D]) -> f64 {
    force.iter().fold(0.0_f64, |length, component| length.hypot(*component))
}

/// Distances and overlaps of the couples of a network, by functions that are compiled in this crate.
#[derive(Clone, Copy, Debug)]
pub enum Measures<'a> {
    /// In two dimensions.
    Plane(Network<'a, 2>),
    /// In three dimensions.
    Space(Network<'a, 3>),
}

impl<'a> Measures<'a> {
    /// The measures of a network; `None` in other numbers of dimensions.
    pub fn of<const D: usize>(network: &Network<'a, D>) -> Option<Self> {
        match D {
            2 => network.of_dimension().map(Self::Plane),
            3 => network.of_dimension().map(Self::Space),
            _ => None,
        }
    }

    /// Distance of a couple, by its place in the list: see [`Space::distance`].
    ///
    /// # Panics
    /// If the list is shorter.
    pub fn distance(&self, k: usize) -> f64 {
        match self {
            Self::Plane(network) => network.space.distance(network.couples.get(k)),
            Self::Space(network) => network.space.distance(network.couples.get(k)),
        }
    }

    /// Overlap of a couple, by its place in the list: see [`Space::overlap`].
    ///
    /// # Panics
    /// If the list is shorter.
    pub fn overlap(&self, k: usize) -> f64 {
        match self {
            Self::Plane(network) => network.overlap(network.couples.get(k)),
            Self::Space(network) => network.overlap(network.couples.get(k)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdem_contact::Elements;

    /// Elements that touch by the library's comparison never have a negative overlap.
    #[test]
    fn touching_couples_overlap_by_at_least_zero() {
        let radii: Vec<f64> = (1..2000).map(|k| 0.1 + 1.0 / f64::from(k)).collect();
        let couples = Couples::Plain(vec![Couple::new(0, 1)]);
        for pair in radii.windows(2) {
            let reach = pair[0] + pair[1];
            let centres = [[0.0, 0.0], [reach * 0.6, reach * 0.8]];
            let space = Space { centres: &centres, cell: None };
            let network = Network { space, sizes: Sizes::Each(pair), couples: &couples, forces: None };
            if Elements::spheres_with_radii(&centres, pair).unwrap().touch(0, 1) {
                assert!(couples.iter().all(|couple| network.overlap(couple) >= 0.0), "{pair:?}");
            }
        }
    }

    #[test]
    fn a_branch_reaches_through_the_face_of_a_box() {
        let cell = PeriodicBox::orthogonal([0.0, 0.0], [4.0, 4.0], [true, false]).unwrap();
        let centres = [[0.5, 1.0], [7.75, 1.0]];
        let space = Space { centres: &centres, cell: Some(cell) };
        let couple = PeriodicCouple { i: 0, j: 1, shift: [-2, 0] };
        assert_eq!(space.ends(couple), [[0.5, 1.0], [-0.25, 1.0]]);
        assert_eq!(space.branch(couple), [-0.75, 0.0]);
        assert_eq!(space.distance(couple), 0.75);
    }
}
