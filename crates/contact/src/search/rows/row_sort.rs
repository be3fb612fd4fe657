//! Sorting one row along its long axis, in cache.

use crate::grid::nearest_integer;
use crate::real::Real;

/// Memory for one row, kept between rows.
#[derive(Clone, Debug)]
pub(crate) struct RowSort<T> {
    /// Coordinate along the long axis and place before the sort.
    order: Vec<(T, u32)>,
    bins: Vec<u32>,
    points: Vec<T>,
    ids: Vec<u32>,
    radii: Vec<T>,
}

/// Rows this short are sorted by insertion alone.
const SHORT: usize = 16;

/// Insertion sort is quick while elements move over a few others on average; beyond, another sort takes over.
const MAX_MOVES_PER_ELEMENT: usize = 8;

impl<T> Default for RowSort<T> {
    fn default() -> Self {
        Self { order: Vec::new(), bins: Vec::new(), points: Vec::new(), ids: Vec::new(), radii: Vec::new() }
    }
}

impl<T: Real> RowSort<T> {
    /// Sorts one row by the coordinate `long`, then by place; and turns points into one block of coordinates per axis.
    ///
    /// # Shapes
    /// `coordinates`: `n` points of `D` coordinates before, `D` blocks of `n` coordinates after. `ids`: `n`. `radii`: `n` or none.
    pub(crate) fn sort<const D: usize>(
        &mut self,
        long: usize,
        coordinates: &mut [T],
        ids: &mut [u32],
        radii: &mut [T],
    ) {
        let n = ids.len();
        if n == 1 {
            return;
        }
        self.points.clear();
        self.points.extend_from_slice(coordinates);
        self.ids.clear();
        self.ids.extend_from_slice(ids);
        self.find_order::<D>(long);

        for (k, &(_, from)) in self.order.iter().enumerate() {
            let point = &self.points[D * from as usize..][..D];
            for axis in 0..D {
                coordinates[axis * n + k] = point[axis];
            }
            ids[k] = self.ids[from as usize];
        }
        if !radii.is_empty() {
            self.radii.clear();
            self.radii.extend_from_slice(radii);
            for (radius, &(_, from)) in radii.iter_mut().zip(&self.order) {
                *radius = self.radii[from as usize];
            }
        }
    }

    /// Bins of equal width first, so that every element is near its place; then insertion.
    fn find_order<const D: usize>(&mut self, long: usize) {
        let n = self.ids.len();
        let along = self.points.iter().skip(long).step_by(D).copied();
        self.order.clear();
        if n <= SHORT {
            self.order.extend(along.zip(0..));
        } else {
            let (min, max) = along.clone().fold((self.points[long], self.points[long]), |(min, max), x| {
                (if x < min { x } else { min }, if x > max { x } else { max })
            });
            // Near its place is enough, whatever the rounding: insertion does the rest.
            let scale = (n - 1) as f64 / (max - min).to_f64();
            let bin = |x: T| (nearest_integer((x - min).to_f64() * scale) as usize).min(n - 1);
            self.bins.clear();
            self.bins.resize(n, 0);
            for x in along.clone() {
                self.bins[bin(x)] += 1;
            }
            let mut start = 0;
            for count in &mut self.bins {
                start += std::mem::replace(count, start);
            }
            self.order.resize(n, (T::ZERO, 0));
            for (x, from) in along.zip(0..) {
                let place = &mut self.bins[bin(x)];
                self.order[*place as usize] = (x, from);
                *place += 1;
            }
        }
        insert(&mut self.order);
    }

    pub(crate) fn bytes(&self) -> usize {
        let integers = self.bins.capacity() + self.ids.capacity();
        self.order.capacity() * size_of::<(T, u32)>()
            + (self.points.capacity() + self.radii.capacity()) * size_of::<T>()
            + integers * size_of::<u32>()
    }
}

/// A stable sort by coordinate of what is nearly sorted, and has equal coordinates in order of place.
fn insert<T: Real>(order: &mut [(T, u32)]) {
    let mut moves = MAX_MOVES_PER_ELEMENT * order.len();
    for k in 1..order.len() {
        let moving = order[k];
        let mut to = k;
        while to > 0 && order[to - 1].0 > moving.0 {
            order[to] = order[to - 1];
            to -= 1;
        }
        order[to] = moving;
        if k - to > moves {
            order.sort_unstable_by(|a, b| {
                a.0.partial_cmp(&b.0).unwrap_or(std::cmp::Ordering::Equal).then(a.1.cmp(&b.1))
            });
            return;
        }
        moves -= k - to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(xs: &[f64]) -> Vec<u32> {
        let mut coordinates: Vec<f64> = xs.iter().flat_map(|&x| [-x, x]).collect();
        let mut ids: Vec<u32> = (0..xs.len() as u32).collect();
        let mut radii: Vec<f64> = xs.iter().map(|x| 10.0 * x).collect();
        RowSort::default().sort::<2>(1, &mut coordinates, &mut ids, &mut radii);
        for (k, &id) in ids.iter().enumerate() {
            let x = xs[id as usize];
            assert_eq!((coordinates[k], coordinates[xs.len() + k], radii[k]), (-x, x, 10.0 * x));
        }
        ids
    }

    fn is_stable_sort(xs: &[f64]) {
        let mut expected: Vec<u32> = (0..xs.len() as u32).collect();
        expected.sort_by(|&a, &b| xs[a as usize].partial_cmp(&xs[b as usize]).unwrap());
        assert_eq!(sorted(xs), expected);
    }

    #[test]
    fn any_distribution_is_sorted_and_ties_keep_their_order() {
        let scattered = |n: u32| (0..n).map(|k| f64::from(k.wrapping_mul(2_654_435_761) >> 8));
        for n in [2, 3, 16, 17, 100, 5000] {
            is_stable_sort(&scattered(n).collect::<Vec<_>>());
            is_stable_sort(&scattered(n).map(|x| x % 7.0).collect::<Vec<_>>());
            is_stable_sort(&vec![1.5; n as usize]);
            // All but one in a single bin, in reverse.
            is_stable_sort(&(0..n).map(|k| if k == 3 { 1e12 } else { f64::from(n - k) }).collect::<Vec<_>>());
            is_stable_sort(&(0..n).map(|k| f64::from(k) * 5e-324).collect::<Vec<_>>());
            is_stable_sort(&(0..n).map(|k| if k % 2 == 0 { 0.0 } else { -0.0 }).collect::<Vec<_>>());
        }
    }
}
