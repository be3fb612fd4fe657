//! The contact mask as data: the half of the neighbouring cells that a cell is compared with.

/// The two sets of list heads that an axis keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// Elements of the central list of the axis above: A\[0\], B\[0\] in the book.
    Central = 0,
    /// Elements of every other list that the mask reaches, merged into one set: A\[1\], B\[1\] in the book,
    /// (3.78) and (3.79).
    Neighbours = 1,
}

/// The lists along one axis that a central list `i` is compared with, besides itself: their set and their
/// offset from `i`.
///
/// This rule, applied axis by axis from the last to the first, gives the half mask in any number of
/// dimensions. [`Set::Neighbours`] merges everything that is not central, so no axis needs more than these
/// four lists:
/// ```text
/// Neighbours   x  x  x
/// Central      x  o  .        o: the central list itself
///             -1  0 +1
/// ```
/// On the last axis there is no axis above, its [`Set::Neighbours`] is empty, and the rule is "the row
/// below": step 4 of the 2D and of the 3D procedure. On the first axis it is the mask of cells, Fig. 3.45 and
/// (3.73).
pub const CONTACT_MASK: [(Set, i32); 4] =
    [(Set::Central, -1), (Set::Neighbours, -1), (Set::Neighbours, 0), (Set::Neighbours, 1)];

/// The contact mask as a list of cells: the offsets of the `(3^D - 1)/2` cells that a central cell is
/// compared with, besides itself.
///
/// There are 4 cells in 2D (Fig. 3.45, p. 109), 13 in 3D (3.73) and 40 in 4D. No search uses this list. It
/// illustrates [`CONTACT_MASK`], and tests compare the two. Offsets are in the order x, y, z, …
///
/// # Example
/// ```
/// let cells = fdem_contact::mask_cells::<2>();
/// assert_eq!(cells.len(), 4);
/// for cell in [[-1, 0], [-1, -1], [0, -1], [1, -1]] {
///     assert!(cells.contains(&cell));
/// }
/// ```
pub fn mask_cells<const D: usize>() -> Vec<[i32; D]> {
    // Follows the sets down the axes: the offsets of the elements on central lists and of those on merged
    // lists.
    let mut central = vec![[0; D]];
    let mut neighbours: Vec<[i32; D]> = Vec::new();
    for axis in (0..D).rev() {
        let shifted = |cells: &[[i32; D]], offset: i32| -> Vec<[i32; D]> {
            cells
                .iter()
                .map(|cell| {
                    let mut cell = *cell;
                    cell[axis] = offset;
                    cell
                })
                .collect()
        };
        let merged = CONTACT_MASK
            .iter()
            .flat_map(|&(set, offset)| match set {
                Set::Central => shifted(&central, offset),
                Set::Neighbours => shifted(&neighbours, offset),
            })
            .collect();
        central = shifted(&central, 0);
        neighbours = merged;
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each couple of neighbouring cells is compared from exactly one side.
    fn is_exactly_one_half<const D: usize>() {
        let cells = mask_cells::<D>();
        assert_eq!(cells.len(), (3_usize.pow(D as u32) - 1) / 2);
        for cell in &cells {
            assert!(cell.iter().all(|offset| (-1..=1).contains(offset)));
            assert_eq!(cells.iter().filter(|other| *other == cell).count(), 1);
            assert!(!cells.contains(&cell.map(|offset| -offset)));
        }
    }

    #[test]
    fn the_mask_is_half_of_the_neighbours_in_any_dimension() {
        is_exactly_one_half::<1>();
        is_exactly_one_half::<2>();
        is_exactly_one_half::<3>();
        is_exactly_one_half::<4>();
        is_exactly_one_half::<6>();
    }

    /// (3.73), p. 121: nine cells of the layer below, three of the row below, one to the left.
    #[test]
    fn the_mask_in_3d_is_the_published_one() {
        let mut expected = vec![[-1, 0, 0]];
        for x in -1..=1 {
            expected.push([x, -1, 0]);
            for y in -1..=1 {
                expected.push([x, y, -1]);
            }
        }
        let mut cells = mask_cells::<3>();
        cells.sort_unstable();
        expected.sort_unstable();
        assert_eq!(cells, expected);
    }
}
