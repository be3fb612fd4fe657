//! Wider cells where rows would hold few elements.

use crate::elements::Elements;
use crate::grid::Grid;
use crate::real::Real;

/// With fewer elements than this the search takes less time than the estimate is worth.
const FEW: usize = 2048;

/// Number of elements per cell as wide as the reach from which on wider cells do not pay.
const DENSE: f64 = 0.3;

/// Number of elements per reach along a row that wider cells are to have.
const ENOUGH: f64 = 2.5;

/// Largest factor by which cells are wider.
const WIDEST: f64 = 8.0;

/// Edge of the cells that are sampled, in cells as wide as the reach.
const EDGE: f64 = 8.0;

/// One element in this number is sampled, up to [`MOST`].
const ONE_IN: usize = 16;

const MOST: usize = 4096;

/// The grid of a search over `elements`.
///
/// Cells need not be wider than the reach. But if there are few elements, most rows hold one or two, and to
/// find their neighbour rows takes longer than to compare elements. Wider cells give fewer rows with more
/// elements. The density where the elements are, which may be in clusters, is estimated from pairs of a
/// sample that share a cell.
pub(crate) fn grid<T: Real, const D: usize>(elements: &Elements<'_, T, D>) -> Grid<D> {
    let (_, step) = sample_of(elements.len());
    grid_of(Grid::unbounded(elements), elements.len(), |k, axis| elements.anchor(k * step, axis))
}

/// The same for `n` elements, by the cells as wide as their reach and the elements of their
/// [sample](sample_of).
pub(crate) fn grid_of<const D: usize>(
    grid: Grid<D>,
    n: usize,
    anchor: impl Fn(usize, usize) -> f64,
) -> Grid<D> {
    let cells = grid.cells().iter().map(|&cells| cells as f64).product::<f64>();
    if D == 1 || n < FEW || n as f64 >= DENSE * cells {
        return grid;
    }
    let density = density(n, &grid, anchor).max(n as f64 / cells);
    if density >= DENSE {
        return grid;
    }
    // Products only, so that the result is the same on every machine.
    let enough = |factor: f64| (1..D).fold(density, |density, _| density * factor) >= ENOUGH;
    let mut factor = 1.0;
    while factor < WIDEST && !enough(factor) {
        factor += 0.5;
    }
    grid.wider(factor)
}

/// The size of a sample of `n` elements, and the difference of the numbers of its elements, from 0 on. Few
/// elements have none.
pub(crate) fn sample_of(n: usize) -> (usize, usize) {
    if n < FEW {
        return (0, 0);
    }
    let sample = (n / ONE_IN).min(MOST);
    (sample, n / sample)
}

/// Mean number of elements per cell of `grid` where the elements are.
fn density<const D: usize>(n: usize, grid: &Grid<D>, anchor: impl Fn(usize, usize) -> f64) -> f64 {
    let (sample, _) = sample_of(n);
    let mut keys: Vec<u64> = (0..sample)
        .map(|k| {
            (0..D).fold(0, |key: u64, axis| {
                let cell = (grid.quotient(axis, anchor(k, axis)) / EDGE) as u64;
                (key ^ cell).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29)
            })
        })
        .collect();
    keys.sort_unstable();
    let pairs: f64 = keys.chunk_by(u64::eq).map(|equal| (equal.len() * (equal.len() - 1)) as f64).sum();
    let others = pairs / (sample * (sample - 1)) as f64 * n as f64;
    (0..D).fold(others, |density, _| density / EDGE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Couple, Nbs, Rows, Search, Simd};

    /// `clusters` clusters of `each` points, each `width` wide; the cut-off is 1.
    fn clusters(clusters: usize, each: usize, width: f64) -> Vec<[f64; 3]> {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut points = Vec::new();
        for _ in 0..clusters {
            let centre: [f64; 3] = std::array::from_fn(|_| random() * 2000.0);
            points.extend((0..each).map(|_| centre.map(|x| x + random() * width)));
        }
        points
    }

    /// The width of the cells relative to the reach, and the couples, which are those of `Nbs`.
    fn widened(points: &[[f64; 3]]) -> f64 {
        let elements = Elements::points(points, 1.0).unwrap();
        let couples = |search: &mut dyn FnMut(&mut Vec<Couple>)| {
            let mut couples = Vec::new();
            search(&mut couples);
            couples.sort_unstable();
            couples
        };
        let expected = couples(&mut |to| Nbs::new().couples(&elements, to).unwrap());
        assert!(!expected.is_empty());
        for simd in Simd::available() {
            let mut rows = Rows::new().with_simd(simd).unwrap();
            assert_eq!(couples(&mut |to| rows.couples(&elements, to).unwrap()), expected, "{simd}");
        }
        grid(&elements).cell_size() / Grid::unbounded(&elements).cell_size()
    }

    #[test]
    fn cells_are_wider_where_rows_would_hold_few_elements() {
        assert_eq!(widened(&clusters(1, 8000, 12.0)), 1.0, "dense");
        assert_eq!(widened(&clusters(8, 1000, 6.0)), 1.0, "dense clusters");
        let mut thrown = clusters(1, 8000, 12.0);
        thrown[77] = [1e6; 3];
        assert_eq!(widened(&thrown), 1.0, "one element far away");
        assert!(widened(&clusters(8, 1000, 18.0)) > 2.0, "clusters");
        assert!(widened(&clusters(1, 8000, 60.0)) > 3.0, "few elements everywhere");
        assert_eq!(widened(&clusters(1, 1000, 60.0)), 1.0, "too few to look");
    }
}
