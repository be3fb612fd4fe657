//! Elements and the couples among them: what is analysed, drawn and written.
//!
//! ```text
//! Space (centres, box) ─┐
//! Sizes ────────────────┼─> Network ──> distances, overlaps, branch vectors
//! Couples ──────────────┘
//! ```

use fdem_contact::{Couple, PeriodicBox, PeriodicCouple};

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
    /// Points, which touch up to this distance.
    Cutoff(f64),
}

impl Sizes<'_> {
    /// Distance at which two elements touch, rounded as the search rounds it.
    ///
    /// # Panics
    /// If an element of the couple has no radius.
    pub fn contact_distance(&self, couple: Couple) -> f64 {
        match *self {
            Self::Each(radii) => radii[couple.i as usize] + radii[couple.j as usize],
            Self::All(radius) => radius + radius,
            Self::Cutoff(cutoff) => cutoff,
        }
    }

    /// Radius of one element; of a point half the distance at which it touches another.
    ///
    /// # Panics
    /// If the element has no radius.
    pub fn radius(&self, index: usize) -> f64 {
        match *self {
            Self::Each(radii) => radii[index],
            Self::All(radius) => radius,
            Self::Cutoff(cutoff) => cutoff / 2.0,
        }
    }
}

/// Where the elements are, in a box that repeats or without one.
#[derive(Clone, Copy, Debug)]
pub struct Space<'a, const D: usize> {
    /// Centres of the elements, in the box or not.
    pub centres: &'a [[f64; D]],
    /// The box that repeats.
    pub cell: Option<PeriodicBox<f64, D>>,
}

impl<const D: usize> Space<'_, D> {
    /// Distance of the first element of a couple to the image of the second, between the points that the library compares, so that
    /// couples that touch by its comparison overlap by at least zero.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    pub fn distance(&self, couple: PeriodicCouple<D>) -> f64 {
        let [a, b] = self.ends(couple);
        a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b)).sqrt()
    }

    /// From the first element of a couple to the image of the second.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    pub fn branch(&self, couple: PeriodicCouple<D>) -> [f64; D] {
        let [a, b] = self.ends(couple);
        std::array::from_fn(|axis| b[axis] - a[axis])
    }

    /// The first element of a couple, wrapped into the box if there is one, and the image of the second that touches it there.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    pub fn ends(&self, couple: PeriodicCouple<D>) -> [[f64; D]; 2] {
        let PeriodicCouple { i, j, shift } = couple;
        let Some(cell) = &self.cell else { return [i, j].map(|k| self.centres[k as usize]) };
        let [(a, of_a), (b, of_b)] = [i, j].map(|k| self.wrapped(cell, k));
        let shift = std::array::from_fn(|edge| shift[edge] - of_a[edge] + of_b[edge]);
        [a, cell.displaced(&b, &shift)]
    }

    /// How far the elements of a couple overlap: the distance at which they touch less their distance. Negative for a gap within a tolerance.
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    pub fn overlap(&self, sizes: Sizes<'_>, couple: PeriodicCouple<D>) -> f64 {
        sizes.contact_distance(Couple { i: couple.i, j: couple.j }) - self.distance(couple)
    }

    /// The centre in the box, and the periods that it was away from there.
    pub(crate) fn wrapped(&self, cell: &PeriodicBox<f64, D>, element: u32) -> ([f64; D], [i32; D]) {
        cell.wrap(self.centres[element as usize]).expect("elements that were searched can be wrapped")
    }
}

/// Couples with a shift only where there are any.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Couples<const D: usize> {
    /// Of elements in open space.
    Plain(Vec<Couple>),
    /// Of elements in a box that repeats.
    Periodic(Vec<PeriodicCouple<D>>),
}

impl<const D: usize> Couples<D> {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Plain(couples) => couples.len(),
            Self::Periodic(couples) => couples.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One of them, by its place in the order; of open space with a shift of 0.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn get(&self, k: usize) -> PeriodicCouple<D> {
        match self {
            Self::Plain(couples) => unshifted(couples[k]),
            Self::Periodic(couples) => couples[k],
        }
    }

    /// All of them in their order; those of open space with a shift of 0.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = PeriodicCouple<D>> + '_ {
        (0..self.len()).map(|k| self.get(k))
    }
}

/// The same with a shift of 0.
pub(crate) fn unshifted<const D: usize>(Couple { i, j }: Couple) -> PeriodicCouple<D> {
    PeriodicCouple { i, j, shift: [0; D] }
}

/// A packing and its couples.
///
/// # Shapes
/// Couples name elements by their place in `space.centres`; [`Sizes::Each`] has as many radii.
#[derive(Clone, Copy, Debug)]
pub struct Network<'a, const D: usize> {
    /// Where the elements are.
    pub space: Space<'a, D>,
    /// How large they are.
    pub sizes: Sizes<'a>,
    /// Which of them touch: `i < j`, or the image of `j` by its shift.
    pub couples: &'a Couples<D>,
}

impl<const D: usize> Network<'_, D> {
    /// As [`Space::overlap`].
    ///
    /// # Panics
    /// If the couple was not found among these elements.
    pub fn overlap(&self, couple: PeriodicCouple<D>) -> f64 {
        self.space.overlap(self.sizes, couple)
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
            let network = Network { space, sizes: Sizes::Each(pair), couples: &couples };
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
