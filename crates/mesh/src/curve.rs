//! Hilbert's curve through a grid of cells: cells that follow each other are neighbours.

/// Position along Hilbert's curve of a cell in a grid of `2^bits` cells along each axis.
///
/// # Shapes
/// `cell`: `D` coordinates below `2^bits`; `bits` times `D` is at most 64. The result is below `2^(bits D)`,
/// and each cell has its own.
///
/// # Source
/// J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707 (2004).
///
/// # Example
/// ```
/// let along = [[0, 0], [0, 1], [1, 1], [1, 0]].map(|cell| fdem_mesh::curve::place(cell, 1));
/// assert_eq!(along, [0, 1, 2, 3]);
/// ```
#[inline]
pub fn place<const D: usize>(cell: [u32; D], bits: u32) -> u64 {
    let mut x = cell;
    // Without branches: the bits of a cell are random, and a processor would guess wrong half of the time.
    for bit in (1..bits).rev() {
        let mask = (1 << bit) - 1;
        for axis in 0..D {
            let set = 0_u32.wrapping_sub(x[axis] >> bit & 1);
            let swap = (x[0] ^ x[axis]) & mask & !set;
            x[0] ^= swap | (mask & set);
            x[axis] ^= swap;
        }
    }
    for axis in 1..D {
        x[axis] ^= x[axis - 1];
    }
    let mut flip = 0;
    for bit in (1..bits).rev() {
        flip ^= ((1 << bit) - 1) & 0_u32.wrapping_sub(x[D - 1] >> bit & 1);
    }
    let mut key = 0;
    if D <= 3 {
        let kept = if bits < 32 { (1 << bits) - 1 } else { u32::MAX };
        for coordinate in x {
            key = key << 1 | spread::<D>((coordinate ^ flip) & kept);
        }
        return key;
    }
    for bit in (0..bits).rev() {
        for coordinate in x {
            key = key << 1 | u64::from((coordinate ^ flip) >> bit & 1);
        }
    }
    key
}

/// The bits of a number, each at `D` times its place, for `D` up to 3 and 21 bits in three dimensions.
#[inline]
fn spread<const D: usize>(number: u32) -> u64 {
    let mut x = u64::from(number);
    if D == 2 {
        x = (x | x << 16) & 0x0000_ffff_0000_ffff;
        x = (x | x << 8) & 0x00ff_00ff_00ff_00ff;
        x = (x | x << 4) & 0x0f0f_0f0f_0f0f_0f0f;
        x = (x | x << 2) & 0x3333_3333_3333_3333;
        x = (x | x << 1) & 0x5555_5555_5555_5555;
    } else if D == 3 {
        x = (x | x << 32) & 0x001f_0000_0000_ffff;
        x = (x | x << 16) & 0x001f_0000_ff00_00ff;
        x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
        x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
        x = (x | x << 2) & 0x1249_2492_4924_9249;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every cell has its own position, and cells that follow each other share a face.
    fn is_a_curve<const D: usize>(bits: u32) {
        let side = 1_usize << bits;
        let cells = (0..side.pow(D as u32)).map(|number| {
            std::array::from_fn::<u32, D, _>(|axis| (number / side.pow(axis as u32) % side) as u32)
        });
        let mut along: Vec<(u64, [u32; D])> = cells.map(|cell| (place(cell, bits), cell)).collect();
        along.sort_unstable();
        assert!(along.iter().map(|(key, _)| *key).eq(0..along.len() as u64));
        for pair in along.windows(2) {
            let steps = (0..D).map(|axis| pair[0].1[axis].abs_diff(pair[1].1[axis])).sum::<u32>();
            assert_eq!(steps, 1, "{pair:?}");
        }
    }

    #[test]
    fn cells_that_follow_each_other_are_neighbours() {
        is_a_curve::<1>(4);
        is_a_curve::<2>(1);
        is_a_curve::<2>(5);
        is_a_curve::<3>(4);
        is_a_curve::<4>(2);
    }

    #[test]
    fn the_last_cell_of_a_fine_grid_has_a_position() {
        assert!(place([u32::MAX; 2], 32) > 0);
        assert!(place([(1 << 21) - 1; 3], 21) < 1 << 63);
    }
}
