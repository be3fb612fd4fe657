//! Factors `L D Lᵀ` of a sparse symmetric matrix.

use crate::ordering::{Graph, order};

const NONE: u32 = u32::MAX;

/// A sparse symmetric matrix with positive pivots: its order of elimination, its factors, and solutions.
///
/// Row `k` of `L` is found from the rows above it, by one sparse triangular solve in the order of the
/// elimination tree. All operations are plain multiplications, subtractions and divisions of `f64` in one
/// order, so that their bits are the same on all processors.
///
/// # Source
/// T. A. Davis, "Algorithm 849: a concise sparse Cholesky factorization package", ACM Trans. Math. Softw. 31
/// (2005) 587-591: the up-looking method, of which this is an implementation. J. W. H. Liu, "The role of
/// elimination trees in sparse factorization", SIAM J. Matrix Anal. Appl. 11 (1990) 134-172.
#[derive(Clone, Debug)]
pub(crate) struct Ldl {
    /// The unknown at each place of the elimination.
    order: Vec<u32>,
    /// Entries above the diagonal of each column, in the order of elimination: their rows, and the places of
    /// their values in the caller's list.
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<u32>,
    /// The elimination tree.
    parent: Vec<u32>,
    /// Columns of `L` below the diagonal.
    l_starts: Vec<usize>,
    l_rows: Vec<u32>,
    l_values: Vec<f64>,
    diagonal: Vec<f64>,
}

impl Ldl {
    /// Prepares the factors of matrices with entries at the given places: pairs of different unknowns, each
    /// once.
    pub(crate) fn of(unknowns: usize, entries: &[[u32; 2]]) -> Self {
        let order = order(&Graph::of(unknowns, entries.iter().copied()));
        let mut place = vec![0_u32; unknowns];
        order.iter().enumerate().for_each(|(k, &unknown)| place[unknown as usize] = k as u32);
        let mut upper: Vec<(u32, u32, u32)> = entries
            .iter()
            .enumerate()
            .map(|(value, [a, b])| {
                let [a, b] = [place[*a as usize], place[*b as usize]];
                (a.max(b), a.min(b), value as u32)
            })
            .collect();
        upper.sort_unstable();
        let starts = (0..=unknowns).map(|k| upper.partition_point(|of| (of.0 as usize) < k)).collect();
        let (rows, values) = upper.iter().map(|&(_, row, value)| (row, value)).unzip();
        let mut new = Self {
            order,
            starts,
            rows,
            values,
            parent: vec![NONE; unknowns],
            l_starts: Vec::new(),
            l_rows: Vec::new(),
            l_values: Vec::new(),
            diagonal: vec![0.0; unknowns],
        };
        new.analyse();
        new
    }

    /// Number of entries of `L` below its diagonal.
    pub(crate) fn fill(&self) -> usize {
        self.l_values.len()
    }

    /// The elimination tree, and the lengths of the columns of `L`: walks from each entry of a row of the
    /// matrix towards the root meet the entries of that row of `L`.
    fn analyse(&mut self) {
        let unknowns = self.order.len();
        let mut seen = vec![NONE; unknowns];
        let mut lengths = vec![0_usize; unknowns];
        for k in 0..unknowns as u32 {
            seen[k as usize] = k;
            for &row in &self.rows[self.starts[k as usize]..self.starts[k as usize + 1]] {
                let mut at = row as usize;
                while seen[at] != k {
                    if self.parent[at] == NONE {
                        self.parent[at] = k;
                    }
                    lengths[at] += 1;
                    seen[at] = k;
                    at = self.parent[at] as usize;
                }
            }
        }
        let sums = lengths.iter().scan(0, |sum, &length| {
            *sum += length;
            Some(*sum)
        });
        self.l_starts = std::iter::once(0).chain(sums).collect();
        let fill = self.l_starts[unknowns];
        self.l_rows = vec![0; fill];
        self.l_values = vec![0.0; fill];
    }

    /// Computes the factors of the matrix with these values on its diagonal and at its entries. `sums`: those
    /// of its rows, zero or positive, for a matrix whose entries are zero or negative; `None` for another
    /// positive definite one.
    ///
    /// With `sums` a pivot is at least the sum of its row at its elimination, which is a sum of positive
    /// numbers. So that of a stiff fluid in a closed part, whose storage is less than the rounding of its
    /// links, is not lost.
    ///
    /// # Errors
    /// The unknown whose pivot is not positive and finite.
    pub(crate) fn factor(
        &mut self,
        diagonal: &[f64],
        entries: &[f64],
        sums: Option<&[f64]>,
    ) -> Result<(), usize> {
        let unknowns = self.order.len();
        let mut ends = self.l_starts[..unknowns].to_vec();
        let mut seen = vec![NONE; unknowns];
        let mut row = vec![0.0; unknowns];
        // Of rows as they are when they are eliminated.
        let mut row_sums = vec![0.0; unknowns];
        // The places of the entries of a row of `L`, each after those on which it depends.
        let mut places = vec![0_u32; unknowns];
        for k in 0..unknowns {
            let mut first = unknowns;
            seen[k] = k as u32;
            for entry in self.starts[k]..self.starts[k + 1] {
                let mut at = self.rows[entry] as usize;
                row[at] += entries[self.values[entry] as usize];
                let mut length = 0;
                while seen[at] != k as u32 {
                    places[length] = at as u32;
                    length += 1;
                    seen[at] = k as u32;
                    at = self.parent[at] as usize;
                }
                // The walk goes in front of those before, which end where it has ended.
                places.copy_within(..length, first - length);
                first -= length;
            }
            let unknown = self.order[k] as usize;
            let (mut pivot, mut sum) = (diagonal[unknown], sums.map_or(0.0, |sums| sums[unknown]));
            for &place in &places[first..] {
                let at = place as usize;
                let value = std::mem::take(&mut row[at]);
                // Rows of cells that are not full have zeros only.
                if value != 0.0 {
                    let column = self.l_starts[at]..ends[at];
                    for (&below, l) in self.l_rows[column.clone()].iter().zip(&self.l_values[column]) {
                        row[below as usize] -= l * value;
                    }
                }
                let l = value / self.diagonal[at];
                pivot -= l * value;
                sum -= l * row_sums[at];
                self.l_rows[ends[at]] = k as u32;
                self.l_values[ends[at]] = l;
                ends[at] += 1;
            }
            // The last row of a part has nothing but its pivot.
            let is_finite = pivot.is_finite();
            if sums.is_some() {
                pivot = if self.parent[k] == NONE { sum } else { pivot.max(sum) };
            }
            if !(is_finite && pivot > 0.0) {
                return Err(unknown);
            }
            row_sums[k] = sum;
            self.diagonal[k] = pivot;
        }
        Ok(())
    }

    /// Replaces the right side by the solution.
    pub(crate) fn solve(&self, side: &mut [f64]) {
        let mut x: Vec<f64> = self.order.iter().map(|&unknown| side[unknown as usize]).collect();
        for k in 0..x.len() {
            let value = x[k];
            for at in self.l_starts[k]..self.l_starts[k + 1] {
                x[self.l_rows[at] as usize] -= self.l_values[at] * value;
            }
        }
        x.iter_mut().zip(&self.diagonal).for_each(|(x, pivot)| *x /= pivot);
        for k in (0..x.len()).rev() {
            let column = self.l_starts[k]..self.l_starts[k + 1];
            let rows = self.l_rows[column.clone()].iter().map(|&row| x[row as usize]);
            x[k] = rows.zip(&self.l_values[column]).fold(x[k], |sum, (x, l)| sum - l * x);
        }
        self.order.iter().zip(x).for_each(|(&unknown, x)| side[unknown as usize] = x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of a square grid, with a hub.
    fn grid(k: u32) -> (usize, Vec<[u32; 2]>) {
        let mut entries = Vec::new();
        for at in 0..k * k {
            entries.extend((at % k + 1 < k).then_some([at, at + 1]));
            entries.extend((at / k + 1 < k).then_some([at, at + k]));
            entries.extend((at % 7 == 0).then_some([at, k * k]));
        }
        ((k * k + 1) as usize, entries)
    }

    #[test]
    fn solutions_have_their_right_sides() {
        let (unknowns, entries) = grid(20);
        let values: Vec<f64> = (0..entries.len()).map(|k| -1.0 - (k * 37 % 11) as f64).collect();
        let mut diagonal = vec![1e-3; unknowns];
        for ([a, b], value) in entries.iter().zip(&values) {
            diagonal[*a as usize] -= value;
            diagonal[*b as usize] -= value;
        }
        let mut ldl = Ldl::of(unknowns, &entries);
        ldl.factor(&diagonal, &values, Some(&vec![1e-3; unknowns])).expect("positive pivots");
        let side: Vec<f64> = (0..unknowns).map(|k| (k * 29 % 17) as f64).collect();
        let mut x = side.clone();
        ldl.solve(&mut x);
        let mut product: Vec<f64> = x.iter().zip(&diagonal).map(|(x, d)| x * d).collect();
        for ([a, b], value) in entries.iter().zip(&values) {
            product[*a as usize] += value * x[*b as usize];
            product[*b as usize] += value * x[*a as usize];
        }
        for (product, side) in product.iter().zip(&side) {
            assert!((product - side).abs() < 1e-6, "{product} {side}");
        }
        diagonal[34] = f64::NAN;
        assert_eq!(ldl.factor(&diagonal, &values, Some(&vec![1e-3; unknowns])), Err(34));
    }

    /// With links of 1 and a storage of 1e-20 in each unknown, the mean of the solution is that of the right
    /// side over the storage.
    #[test]
    fn storage_below_the_rounding_of_links_is_kept() {
        let (unknowns, mut entries) = grid(20);
        entries.retain(|[_, b]| *b != 400);
        let unknowns = unknowns - 1;
        let mut diagonal = vec![1e-20; unknowns];
        entries.iter().flatten().for_each(|end| diagonal[*end as usize] += 1.0);
        let mut ldl = Ldl::of(unknowns, &entries);
        ldl.factor(&diagonal, &vec![-1.0; entries.len()], Some(&vec![1e-20; unknowns]))
            .expect("positive pivots");
        let mut x = vec![0.0; unknowns];
        x[7] = 1.0;
        ldl.solve(&mut x);
        let mean = x.iter().sum::<f64>() / unknowns as f64;
        assert!((mean * 1e-20 * unknowns as f64 - 1.0).abs() < 1e-6, "{mean:e}");
    }

    /// A chain has no fill; a square grid of n unknowns has about 31/4 n log2 n at most (George 1973).
    #[test]
    fn fill_is_that_of_nested_dissection() {
        let chain: Vec<[u32; 2]> = (0..999).map(|k| [k, k + 1]).collect();
        assert!(Ldl::of(1000, &chain).fill() < 3 * 1000);
        let (unknowns, mut entries) = grid(64);
        entries.retain(|[_, b]| *b != 64 * 64);
        let bound = 31.0 / 4.0 * unknowns as f64 * 12.0;
        let fill = Ldl::of(unknowns - 1, &entries).fill();
        assert!((fill as f64) < bound, "{fill}");
    }
}
