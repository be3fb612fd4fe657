//! Cut-offs by pairs of types: how far apart two points may be depends on the types of both.

use fdem_contact::{Error, Filter, GroupMatrix};

/// The cut-off of each pair of points, by the types of the two.
///
/// Types that no cut-off names are one group, because a file may have as many types as points.
#[derive(Clone, Debug, PartialEq)]
pub struct PairCutoffs {
    /// The group of each point. The last group has the types without a cut-off.
    groups: Vec<u32>,
    /// The groups that have a cut-off.
    matrix: GroupMatrix,
    /// The cut-off of each two groups, row by row; below any distance if they have none.
    table: Vec<f64>,
    largest: f64,
}

impl PairCutoffs {
    /// The cut-offs of points with these types, in the length unit of the points. Two types in `cutoffs` are
    /// a pair in either order, and the last entry of a pair counts.
    ///
    /// # Shapes
    /// `types`: `n` numbers for `n` points, any.
    ///
    /// # Cost
    /// 4 bytes for each point, and 8 for each two types in `cutoffs`.
    ///
    /// # Errors
    /// [`Error::InvalidCutoff`] for a cut-off that is negative or not finite, [`Error::OutOfMemory`].
    ///
    /// # Example
    /// ```
    /// use fdem_results::network::PairCutoffs;
    ///
    /// let (hydrogen, carbon) = (0, 1);
    /// let cutoffs = PairCutoffs::new(&[hydrogen, carbon, carbon], &[([hydrogen, carbon], 1.3)])?;
    /// assert_eq!(cutoffs.of(1, 0), Some(1.3));
    /// assert_eq!(cutoffs.of(1, 2), None);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn new(types: &[u32], cutoffs: &[([u32; 2], f64)]) -> Result<Self, Error> {
        if let Some((_, value)) = cutoffs.iter().find(|(_, cutoff)| !(cutoff.is_finite() && *cutoff >= 0.0)) {
            return Err(Error::InvalidCutoff { value: *value, limit: f64::MAX });
        }
        let mut named: Vec<u32> = cutoffs.iter().flat_map(|(pair, _)| *pair).collect();
        named.sort_unstable();
        named.dedup();
        let group = |of: u32| named.binary_search(&of).map_or(named.len(), |group| group) as u32;
        let count = named.len() + 1;
        let (mut matrix, mut table) = (GroupMatrix::none(count)?, vec![f64::NEG_INFINITY; count * count]);
        for &(pair, cutoff) in cutoffs {
            let [a, b] = pair.map(group);
            matrix.set(a, b, true)?;
            for (row, column) in [(a, b), (b, a)] {
                table[row as usize * count + column as usize] = cutoff;
            }
        }
        let largest = table.iter().copied().fold(0.0, f64::max);
        Ok(Self { groups: types.iter().map(|&of| group(of)).collect(), matrix, table, largest })
    }

    /// The cut-off of two points; `None` if their types have none.
    ///
    /// # Panics
    /// If there are no such points.
    #[inline]
    pub fn of(&self, i: u32, j: u32) -> Option<f64> {
        let [a, b] = [i, j].map(|point| self.groups[point as usize] as usize);
        let cutoff = self.table[a * self.matrix.groups() + b];
        (cutoff >= 0.0).then_some(cutoff)
    }

    /// The largest cut-off; 0 if there is none.
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// A filter that leaves the pairs that have a cut-off.
    pub fn filter(&self) -> Filter<'_> {
        Filter::groups(&self.groups, &self.matrix)
    }

    /// The cut-offs of some of the points, in this order.
    pub(crate) fn among(&self, points: &[u32]) -> Self {
        let groups = points.iter().map(|&point| self.groups[point as usize]).collect();
        Self { groups, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_without_a_cutoff_are_one_group() {
        let cutoffs = PairCutoffs::new(&[7, 1, 9, 7], &[([9, 7], 2.0), ([7, 7], 0.0)]).unwrap();
        assert_eq!(cutoffs.groups, [0, 2, 1, 0]);
        let of = |i, j| [cutoffs.of(i, j), cutoffs.of(j, i)];
        assert_eq!(of(0, 2), [Some(2.0); 2]);
        assert_eq!(of(0, 3), [Some(0.0); 2]);
        assert_eq!(of(2, 2), [None; 2]);
        assert_eq!(of(0, 1), [None; 2]);
        assert_eq!(of(1, 1), [None; 2]);
        assert_eq!(cutoffs.largest(), 2.0);
        let among = cutoffs.among(&[2, 3]);
        assert_eq!([among.of(0, 1), among.of(1, 1), among.of(0, 0)], [Some(2.0), Some(0.0), None]);
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(PairCutoffs::new(&[0], &[([0, 0], wrong)]), Err(Error::InvalidCutoff { .. })));
        }
    }
}
