//! Short edges for a skewed lattice.

use crate::error::Error;
use crate::narrow::exact::sum_of_products;
use crate::periodic::cell::{MAX_PERIODS, PeriodicBox, norm};
use crate::real::Real;

/// A box is skewed if short edges lower the number of images of a large reach by more than this factor.
///
/// Sheared boxes of simulations and primitive cells of crystals stay far below it; their couples and the
/// order of these are those of the given edges.
const SKEWED: f64 = 32.0;

/// Largest number of given edges in a short edge.
const MAX_COMBINED: f64 = 16_777_216.0;

/// Steps after which the reduction ends. Each step shortens an edge; a tilt of 10^6 takes fewer than 10.
const MAX_STEPS: usize = 256;

/// A step has to shorten the square of an edge by this share, so that rounding cannot go round in circles.
const SHORTER: f64 = 1.0 - 1e-9;

/// The same lattice by short edges, each an integer combination of the given ones.
///
/// Edges that are not periodic are replaced by their parts orthogonal to the periodic ones: nothing repeats
/// along them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReducedBox<T, const D: usize> {
    /// The box with short edges, from the same origin. Each component is the exact combination, rounded once.
    pub cell: PeriodicBox<T, D>,
    /// Short edge `a` is the sum of `combination[a][b]` times the given edge `b`.
    combination: [[i32; D]; D],
}

impl<T: Real, const D: usize> ReducedBox<T, D> {
    /// A number of short edges as numbers of given edges. Exact if the result fits `i32`.
    #[inline]
    pub fn shift(&self, short: &[i32; D]) -> [i32; D] {
        std::array::from_fn(|b| {
            (0..D).fold(0_i32, |sum, a| sum.wrapping_add(short[a].wrapping_mul(self.combination[a][b])))
        })
    }

    /// The shift of a couple of a search in the short edges, as given edges.
    ///
    /// The shift between an element and its own image has the sign of [`PeriodicCouple`]'s.
    ///
    /// [`PeriodicCouple`]: crate::PeriodicCouple
    #[inline]
    pub fn shift_of_couple(&self, [i, j]: [u32; 2], short: &[i32; D]) -> [i32; D] {
        let shift = self.shift(short);
        if i == j && shift < [0; D] { shift.map(i32::wrapping_neg) } else { shift }
    }

    /// Checks that the shifts of couples with images at these short edges fit their integers. Both elements
    /// are at most 2^28 given edges outside.
    ///
    /// # Errors
    /// [`Error::ShiftTooLarge`].
    pub fn check_shifts(&self, of_images: &[[i32; D]]) -> Result<(), Error> {
        let most = |b: usize| (0..D).map(|a| f64::from(self.combination[a][b]).abs()).sum::<f64>();
        let most = (0..D).map(most).fold(0.0, f64::max);
        let largest = of_images.iter().flatten().map(|edges| edges.unsigned_abs()).max().unwrap_or(0);
        // Wrapped points are inside the short edges, and so at most one of each outside the given edges.
        let edges = (f64::from(largest) + 2.0) * most;
        if edges > 2.0 * MAX_PERIODS {
            return Err(Error::ShiftTooLarge { edges, limit: 2.0 * MAX_PERIODS });
        }
        Ok(())
    }
}

impl<T: Real, const D: usize> PeriodicBox<T, D> {
    /// The same lattice by short edges, if the edges of this box are skewed; `None` if they are short enough.
    ///
    /// A box counts as skewed if its short edges lower the product of `1 / height` over the periodic edges to
    /// less than a 32nd: in a cubic lattice, from a tilt of 32 edges on. [`PeriodicSearch`] and all other
    /// searches in a periodic box use the short edges of such a box, and give shifts in the given ones.
    /// Short edges take at most 2^24 of each given one; a lattice that needs more is reduced in part or not.
    ///
    /// # Source
    /// Greedy reduction, which in two and three dimensions ends with edges of smallest length: P.Q. Nguyen,
    /// D. Stehlé, "Low-dimensional lattice basis reduction revisited", ACM Trans. Algorithms 5 (2009) 46.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::PeriodicBox;
    ///
    /// let skewed = PeriodicBox::triclinic([0.0, 0.0], [[4.0, 0.0], [4000.0, 4.0]], [true, true])?;
    /// let reduced = skewed.reduced().unwrap();
    /// assert_eq!(reduced.cell.edges(), [[4.0, 0.0], [0.0, 4.0]]);
    /// assert_eq!(reduced.shift(&[0, 1]), [-1000, 1]);
    /// assert_eq!(reduced.cell.reduced(), None);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    ///
    /// [`PeriodicSearch`]: crate::PeriodicSearch
    #[doc(alias = "Minkowski reduction")]
    #[doc(alias = "Niggli cell")]
    pub fn reduced(&self) -> Option<ReducedBox<T, D>> {
        let periodic = self.periodic();
        let given = self.edges().map(|edge| edge.map(T::to_f64));
        let repeating: Vec<usize> = (0..D).filter(|&edge| periodic[edge]).collect();
        // No basis of a lattice has a smaller product than 1 of lengths and inverse heights.
        let longest = |edge: usize| norm(&given[edge]) * norm(&self.dual()[edge]);
        if repeating.iter().map(|&edge| longest(edge)).product::<f64>() <= SKEWED {
            return None;
        }

        let mut lattice = Lattice::new(given);
        lattice.reduce(&repeating)?;
        let mut edges = lattice.edges;
        let mut directions: Vec<[f64; D]> = Vec::new();
        for &edge in &repeating {
            directions.extend(orthogonal(edges[edge], &directions));
        }
        for edge in (0..D).filter(|&edge| !periodic[edge]) {
            let direction = orthogonal(given[edge], &directions)?;
            let length = norm(&given[edge]);
            edges[edge] = direction.map(|x| x * length);
            directions.push(direction);
        }
        let edges = edges.map(|edge| edge.map(T::nearest));
        let cell = Self::triclinic(self.origin(), edges, periodic).ok()?;
        let images = |cell: &Self| repeating.iter().map(|&edge| norm(&cell.dual()[edge])).product::<f64>();
        if images(self) <= SKEWED * images(&cell) {
            return None;
        }
        Some(ReducedBox { cell, combination: lattice.combination.map(|row| row.map(|n| n as i32)) })
    }
}

/// The unit vector along the part of `vector` that is orthogonal to orthonormal `directions`; `None` if there
/// is no such part.
fn orthogonal<const D: usize>(vector: [f64; D], directions: &[[f64; D]]) -> Option<[f64; D]> {
    let length = norm(&vector);
    let mut rest = vector.map(|x| x / length);
    for _ in 0..2 {
        for direction in directions {
            let along = dot(&rest, direction);
            rest = std::array::from_fn(|axis| rest[axis] - along * direction[axis]);
        }
        let height = norm(&rest);
        if height.is_nan() || height <= 0.0 {
            return None;
        }
        rest = rest.map(|x| x / height);
    }
    Some(rest)
}

/// Edges that are being shortened, and the given edges in each of them.
struct Lattice<const D: usize> {
    given: [[f64; D]; D],
    edges: [[f64; D]; D],
    /// Whole numbers.
    combination: [[f64; D]; D],
}

impl<const D: usize> Lattice<D> {
    fn new(given: [[f64; D]; D]) -> Self {
        let one = |a: usize| std::array::from_fn(|b| if a == b { 1.0 } else { 0.0 });
        Self { given, edges: given, combination: std::array::from_fn(one) }
    }

    /// Shortens the `repeating` edges until none can be shortened by whole numbers of the others, or only
    /// with too many given edges. `None` if this takes too many steps.
    fn reduce(&mut self, repeating: &[usize]) -> Option<()> {
        for _ in 0..MAX_STEPS {
            let mut is_shorter = false;
            // The longest edge is shortened by the others; ties go by number.
            let mut order = repeating.to_vec();
            order.sort_by(|&a, &b| self.square(b).total_cmp(&self.square(a)).then(a.cmp(&b)));
            for (place, &edge) in order.iter().enumerate() {
                is_shorter = self.shorten(edge, &order[place + 1..]);
                if is_shorter {
                    break;
                }
            }
            if !is_shorter {
                return Some(());
            }
        }
        None
    }

    fn square(&self, edge: usize) -> f64 {
        dot(&self.edges[edge], &self.edges[edge])
    }

    /// Replaces `edge` by its shortest sum with whole numbers of the `others`, at most two and no longer than
    /// it, the longer one first. Returns whether it became shorter.
    fn shorten(&mut self, edge: usize, others: &[usize]) -> bool {
        let near = match *others {
            [] => return false,
            [other] => [(other, self.projection(edge, other)), (other, 0.0)],
            [longer, shorter, ..] => {
                // Coordinates of the projection on the plane of both: two equations in the products.
                let (aa, bb) = (self.square(longer), self.square(shorter));
                let product = |a: usize, b: usize| dot(&self.edges[a], &self.edges[b]);
                let (ab, ea, eb) = (product(longer, shorter), product(edge, longer), product(edge, shorter));
                let determinant = aa * bb - ab * ab;
                if determinant.is_nan() || determinant <= 1e-9 * aa * bb {
                    // Nearly parallel: they are shortened first.
                    return false;
                }
                [(longer, (ea * bb - eb * ab) / determinant), (shorter, (eb * aa - ea * ab) / determinant)]
            }
        };
        let limit = SHORTER * self.square(edge);
        let mut best: Option<([f64; D], [f64; D], f64)> = None;
        for first in around(near[0].1) {
            for second in around(near[1].1) {
                let mut combination = self.combination[edge];
                for (b, n) in combination.iter_mut().enumerate() {
                    *n -= first * self.combination[near[0].0][b] + second * self.combination[near[1].0][b];
                }
                if combination.iter().any(|n| n.abs() > MAX_COMBINED) {
                    continue;
                }
                let sum = combined(&combination, &self.given);
                let square = dot(&sum, &sum);
                if square < best.map_or(limit, |(_, _, square)| square) {
                    best = Some((combination, sum, square));
                }
            }
        }
        if let Some((combination, sum, _)) = best {
            (self.combination[edge], self.edges[edge]) = (combination, sum);
        }
        best.is_some()
    }

    fn projection(&self, edge: usize, on: usize) -> f64 {
        dot(&self.edges[edge], &self.edges[on]) / self.square(on)
    }
}

/// The whole number nearest to `x` and its neighbours; 0 alone for 0.
fn around(x: f64) -> impl Iterator<Item = f64> + Clone {
    let nearest = x.round();
    [0.0, -1.0, 1.0].into_iter().take(if x == 0.0 { 1 } else { 3 }).map(move |step| nearest + step)
}

/// The combination of the given edges: an exact sum, rounded at the end.
fn combined<const D: usize>(combination: &[f64; D], given: &[[f64; D]; D]) -> [f64; D] {
    std::array::from_fn(|axis| sum_of_products((0..D).map(|b| (combination[b], given[b][axis]))))
}

fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|axis| a[axis] * b[axis]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows of `combination` applied to `edges`.
    fn skewed(edges: [[f64; 3]; 3], combination: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        combination.map(|row| combined(&row, &edges))
    }

    fn reduced(edges: [[f64; 3]; 3], periodic: [bool; 3]) -> Option<ReducedBox<f64, 3>> {
        PeriodicBox::triclinic([1.0, 2.0, 3.0], edges, periodic).unwrap().reduced()
    }

    #[test]
    fn short_edges_are_left_as_they_are() {
        let tall = 0.75_f64.sqrt();
        for edges in [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1e6]],
            [[1.0, 0.0, 0.0], [0.5, tall, 0.0], [0.0, 0.0, 1.0]],
            [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]],
            [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]],
        ] {
            assert_eq!(reduced(edges, [true; 3]), None, "{edges:?}");
        }
    }

    #[test]
    fn a_skewed_cubic_lattice_becomes_a_cube_again() {
        let cube = [[6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]];
        for m in [5.0, 50.0, 1000.0, 4000.0] {
            let edges = skewed(cube, [[1.0, 0.0, 0.0], [m, 1.0, 0.0], [(m / 2.0).floor(), m, 1.0]]);
            let found = reduced(edges, [true; 3]).unwrap();
            assert_eq!(found.cell.heights(), [6.0; 3], "tilt {m}");
            assert_eq!(found.cell.origin(), [1.0, 2.0, 3.0]);
            // A shift by short edges displaces as the same shift by given edges.
            let short = [3, -2, 5];
            let whole: [f64; 3] = found.shift(&short).map(f64::from);
            assert_eq!(combined(&short.map(f64::from), &found.cell.edges()), combined(&whole, &edges));
        }
    }

    #[test]
    fn three_edges_that_nearly_cancel_are_reduced_together() {
        // Each pair has an angle of 120 degrees and is reduced; the sum of all three is short.
        let edges = [[2.0, 0.0, 0.01], [-1.0, 1.75, 0.01], [-1.0, -1.75, 0.01]];
        let found = reduced(edges, [true; 3]).unwrap();
        let heights = found.cell.heights();
        assert!(heights.iter().all(|height| *height > 0.029), "{heights:?}");
    }

    #[test]
    fn edges_that_do_not_repeat_are_only_turned() {
        let edges = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [4000.0, 0.0, 8.0]];
        let found = reduced(edges, [true, true, false]).unwrap();
        assert_eq!(found.cell.heights()[..2], [4.0, 4.0]);
        assert_eq!(found.shift(&[1, 2, 0]), [1, 2, 0]);
        assert_eq!(found.cell.edges()[..2], edges[..2]);
    }

    #[test]
    fn a_lattice_beyond_the_integers_of_shifts_is_left_as_it_is() {
        assert_eq!(reduced([[1.0, 0.0, 0.0], [3e7, 1.0, 0.0], [0.0, 0.0, 1.0]], [true; 3]), None);
    }
}
