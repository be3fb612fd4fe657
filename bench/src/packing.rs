//! The packings of the book, and the number of touching couples in each.

use fdem_scenes::{Error, book};

/// The packings of the four examples: discs and spheres of diameter 1 on a square or cubic grid.
///
/// # Source
/// A. Munjiza, "The Combined Finite-Discrete Element Method", Wiley 2004, pp. 112-117.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// Dense: neighbours touch along every axis. The spacing has no effect.
    A,
    /// The spacing along x, two diameters along the other axes.
    B,
    /// The spacing along every axis.
    C,
    /// One diameter and the spacing alternate along x; two diameters along the other axes.
    D,
}

impl Packing {
    /// Centres of `n` elements; `spacing` (S/D in the book) is in diameters.
    ///
    /// # Errors
    /// The errors of [`fdem_scenes::book`].
    pub fn centres<const D: usize>(self, n: usize, spacing: f64) -> Result<Vec<[f64; D]>, Error> {
        let cloud = match self {
            Self::A => book::packing_a::<D>(n),
            Self::B => book::packing_b::<D>(n, spacing),
            Self::C => book::packing_c::<D>(n, spacing),
            Self::D => book::packing_d::<D>(n, spacing),
        };
        cloud.map(|cloud| cloud.centres)
    }

    /// The number of touching couples in closed form; `spacing` is at least 1.
    ///
    /// A full grid of k elements per axis has `D k^(D-1) (k - 1)` couples in packing A.
    pub fn couples<const D: usize>(self, n: usize, spacing: f64) -> u64 {
        let side = side::<D>(n);
        let apart = spacing > 1.0;
        let couples = match self {
            Self::A => (0..D).map(|axis| neighbours(n, side, axis)).sum(),
            Self::B | Self::C if apart => 0,
            Self::C => (0..D).map(|axis| neighbours(n, side, axis)).sum(),
            Self::D if apart => n / side * (side / 2) + n % side / 2,
            Self::B | Self::D => neighbours(n, side, 0),
        };
        couples as u64
    }
}

/// Number of elements of a grid that have a next one along `axis`. The grid is filled in order, the first
/// axis fastest.
///
/// Along an axis with stride s the grid consists of blocks of `s * side` elements. In a full block all but
/// the last s have a next one; in an incomplete block, those that are at least s before its end.
fn neighbours(n: usize, side: usize, axis: usize) -> usize {
    let stride = side.pow(axis as u32);
    let block = stride * side;
    n / block * (block - stride) + (n % block).saturating_sub(stride)
}

/// Smallest k of at least 1 with `k^D >= n`.
fn side<const D: usize>(n: usize) -> usize {
    let mut side = 1_usize;
    while side.pow(D as u32) < n {
        side += 1;
    }
    side
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdem_contact::{Direct, Elements, Search};

    fn agrees<const D: usize>() {
        for n in [1, 2, 3, 7, 8, 9, 26, 27, 28, 63, 64, 65, 99, 100, 101, 216, 217, 300] {
            for packing in [Packing::A, Packing::B, Packing::C, Packing::D] {
                for spacing in [1.0, 1.5, 2.0, 20.0] {
                    let centres = packing.centres::<D>(n, spacing).unwrap();
                    let counted = Direct.count(&Elements::points(&centres, 1.0).unwrap()).unwrap();
                    assert_eq!(
                        packing.couples::<D>(n, spacing),
                        counted,
                        "{packing:?}, {n}, {spacing}, {D}D"
                    );
                }
            }
        }
    }

    #[test]
    fn closed_forms_agree_with_all_against_all() {
        agrees::<1>();
        agrees::<2>();
        agrees::<3>();
    }

    #[test]
    fn full_grids_of_packing_a() {
        assert_eq!(Packing::A.couples::<2>(90_000, 1.0), 2 * 300 * 299);
        assert_eq!(Packing::A.couples::<3>(1_000_000, 1.0), 3 * 10_000 * 99);
    }
}
