//! Packings and worked figures of the book.
//!
//! Diameters are 1, so `spacing` is the book's `S/D`. Grids are square or cubic: `k` elements per axis with
//! the smallest `k^D >= n`, filled row by row, `x` fastest. Along the additional axes of 3D the packings
//! continue as along `y`.
//!
//! # Source
//! A. Munjiza, "The Combined Finite-Discrete Element Method", Wiley 2004, chapter 3.

use crate::cloud::Cloud;
use crate::error::{Error, positive};
use crate::lattice::{fill, lattice, side};
use crate::sizes::Sizes;

/// Packing A: a dense grid, neighbours touch.
///
/// # Errors
/// [`Error::OutOfMemory`].
///
/// # Source
/// Example I, Fig. 3.47, p. 113.
pub fn packing_a<const D: usize>(n: usize) -> Result<Cloud<D>, Error> {
    lattice(n, 1.0, 0.5)
}

/// Packing B: `spacing` apart in `x`, two diameters apart in `y` (and `z`).
///
/// # Errors
/// [`Error::OutOfRange`] if `spacing` is not positive, or the packing would be infinitely wide;
/// [`Error::OutOfMemory`].
///
/// # Source
/// Example II, Figs 3.48 and 3.49, p. 113.
pub fn packing_b<const D: usize>(n: usize, spacing: f64) -> Result<Cloud<D>, Error> {
    packing(n, spacing, |axis, i| if axis == 0 { i * spacing } else { 2.0 * i })
}

/// Packing C: `spacing` apart along every axis.
///
/// # Errors
/// [`Error::OutOfRange`] if `spacing` is not positive, or the packing would be infinitely wide;
/// [`Error::OutOfMemory`].
///
/// # Source
/// Example III, Figs 3.50 and 3.51, pp. 113 and 116.
pub fn packing_c<const D: usize>(n: usize, spacing: f64) -> Result<Cloud<D>, Error> {
    packing(n, spacing, |_, i| i * spacing)
}

/// Packing D: distances of one diameter and of `spacing` alternate in `x`; two diameters apart in `y` (and
/// `z`).
///
/// # Errors
/// [`Error::OutOfRange`] if `spacing` is not positive, or the packing would be infinitely wide;
/// [`Error::OutOfMemory`].
///
/// # Source
/// Example IV, Figs 3.52 and 3.53, pp. 116 and 117.
///
/// # Example
/// ```
/// let cloud = fdem_scenes::book::packing_d::<2>(16, 5.0)?;
/// let row: Vec<f64> = cloud.centres[..4].iter().map(|c| c[0]).collect();
/// assert_eq!(row, [0.0, 1.0, 6.0, 7.0]);
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
pub fn packing_d<const D: usize>(n: usize, spacing: f64) -> Result<Cloud<D>, Error> {
    packing(n, spacing, |axis, i| {
        let gaps = (0.5 * i).floor();
        if axis == 0 { (i - gaps) + gaps * spacing } else { 2.0 * i }
    })
}

fn packing<const D: usize>(
    n: usize,
    spacing: f64,
    coordinate: impl Fn(usize, f64) -> f64,
) -> Result<Cloud<D>, Error> {
    positive("spacing", spacing)?;
    positive("edge of the packing", side::<D>(n) as f64 * (spacing + 1.0) + 1.0)?;
    let centres = fill::<D>(n, |cell| std::array::from_fn(|axis| coordinate(axis, cell[axis] as f64)))?;
    Ok(Cloud { centres, radii: Sizes::Equal { radius: 0.5 }.radii(n, 0)? })
}

/// Cells of the ten-body example: `[i_x, i_y]` of bodies 1 to 10, counted from 1, in a domain of 10 by 10
/// cells.
///
/// Rows are printed as the y-lists of Fig. 3.41; columns of bodies 1, 4, 7 and 10 are stated on p. 108.
/// Bodies 2, 3, 5, 6 and 8 have the columns of the eight-body example with the same placement (Figs 3.21
/// and 3.22, p. 95). Body 9 is drawn in row 6 beside body 3, in column 3 or 4; the drawing does not show
/// which. Here it is in **column 3**, which is our choice: column 4 would add the couples 4-9 and 6-9.
///
/// # Source
/// Figs 3.40 to 3.44, pp. 103-108.
pub const fn ten_body_cells() -> [[u32; 2]; 10] {
    [[4, 7], [5, 8], [4, 6], [5, 7], [4, 5], [5, 6], [3, 7], [6, 6], [3, 6], [4, 7]]
}

/// The ten-body example as discs of diameter 1, each in the middle of its cell; cells have edge 1 and start
/// at 0.
///
/// Bodies 1 and 10 share a cell and coincide. Body `b` of the book is element `b − 1`.
///
/// # Example
/// ```
/// assert_eq!(fdem_scenes::book::ten_bodies().centres[1], [4.5, 7.5]);
/// ```
pub fn ten_bodies() -> Cloud<2> {
    let centres = ten_body_cells().map(|cell| cell.map(|i| f64::from(i) - 0.5));
    Cloud { centres: centres.to_vec(), radii: vec![0.5; centres.len()] }
}

/// Layers of the nine-body example in 3D: `i_z` of bodies 1 to 9, counted from 1, in a domain of 10 layers.
///
/// # Source
/// Fig. 3.58, p. 122, whose z-lists are 5; 9, 8, 6, 3; 7, 4, 1; and 2 for layers 5 to 8.
pub const fn nine_body_layers() -> [u32; 9] {
    [7, 8, 6, 7, 5, 6, 7, 6, 6]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heads and successors of singly connected lists filled in ascending order; −1 is "none".
    fn lists(keys: &[u32]) -> ([i32; 10], Vec<i32>) {
        let (mut head, mut next) = ([-1; 10], Vec::new());
        for (body, &key) in (1..).zip(keys) {
            next.push(head[key as usize - 1]);
            head[key as usize - 1] = body;
        }
        (head, next)
    }

    #[test]
    fn ten_bodies_give_the_printed_lists() {
        let cells = ten_body_cells();
        let (head, next) = lists(&cells.map(|cell| cell[1]));
        assert_eq!(head, [-1, -1, -1, -1, 5, 9, 10, 2, -1, -1]);
        assert_eq!(next, [-1, -1, -1, 1, -1, 3, 4, 6, 8, 7]);
        // Row 7 from its head down: 10, 7, 4, 1; the x-lists of Fig. 3.44.
        let row: Vec<u32> = [10, 7, 4, 1].map(|body| cells[body - 1][0]).to_vec();
        assert_eq!(row, [4, 3, 5, 4]);
    }

    #[test]
    fn ten_bodies_give_the_twenty_five_couples() {
        let cells = ten_body_cells();
        let mut couples = Vec::new();
        for i in 0..10 {
            for j in i + 1..10 {
                if (0..2).all(|axis| cells[i][axis].abs_diff(cells[j][axis]) <= 1) {
                    couples.push(format!("{}-{}", i + 1, j + 1));
                }
            }
        }
        assert_eq!(
            couples.join(" "),
            "1-2 1-3 1-4 1-6 1-7 1-9 1-10 2-4 2-10 3-4 3-5 3-6 3-7 3-9 3-10 4-6 4-8 4-10 5-6 5-9 6-8 6-10 7-9 \
             7-10 9-10"
        );
    }

    #[test]
    fn ten_bodies_stand_in_their_cells() {
        let cloud = ten_bodies();
        for (centre, cell) in cloud.centres.iter().zip(ten_body_cells()) {
            assert_eq!(centre.map(|x| 1 + x as u32), cell);
            assert!(centre.iter().all(|x| x.fract() == 0.5));
        }
        assert_eq!(cloud.radii, [0.5; 10]);
    }

    #[test]
    fn nine_bodies_give_the_printed_layers() {
        let (head, next) = lists(&nine_body_layers());
        assert_eq!(head, [-1, -1, -1, -1, 5, 9, 7, 2, -1, -1]);
        assert_eq!(next, [-1, -1, -1, 1, -1, 3, 4, 6, 8]);
    }

    /// Coordinates along each axis, first element of the grid first.
    fn axes<const D: usize>(cloud: &Cloud<D>, side: usize) -> Vec<Vec<f64>> {
        (0..D)
            .map(|axis| (0..side).map(|i| cloud.centres[i * side.pow(axis as u32)][axis]).collect())
            .collect()
    }

    #[test]
    fn packings_have_their_spacings() {
        let (dense, doubled) = (vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 2.0, 4.0, 6.0]);
        let (wide, turns) = (vec![0.0, 7.5, 15.0, 22.5], vec![0.0, 1.0, 8.5, 9.5]);
        assert_eq!(axes(&packing_a::<2>(16).unwrap(), 4), [dense.clone(), dense]);
        assert_eq!(
            axes(&packing_b::<3>(64, 7.5).unwrap(), 4),
            [wide.clone(), doubled.clone(), doubled.clone()]
        );
        assert_eq!(axes(&packing_c::<3>(64, 7.5).unwrap(), 4), [wide.clone(), wide.clone(), wide]);
        assert_eq!(
            axes(&packing_d::<3>(64, 7.5).unwrap(), 4),
            [turns.clone(), doubled.clone(), doubled.clone()]
        );
        assert_eq!(axes(&packing_d::<2>(16, 7.5).unwrap(), 4), [turns, doubled]);
    }

    #[test]
    fn packings_fill_incomplete_rows_and_refuse_bad_spacings() {
        assert!(packing_a::<3>(0).unwrap().is_empty() && packing_d::<2>(0, 2.0).unwrap().is_empty());
        assert_eq!(packing_b::<2>(7, 3.0).unwrap().centres[6], [0.0, 4.0]);
        assert_eq!(packing_c::<2>(1, 3.0).unwrap().centres, [[0.0, 0.0]]);
        for spacing in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e308] {
            assert!(packing_b::<2>(100, spacing).is_err(), "{spacing}");
            assert!(packing_c::<2>(100, spacing).is_err(), "{spacing}");
            assert!(packing_d::<3>(100, spacing).is_err(), "{spacing}");
        }
    }
}
