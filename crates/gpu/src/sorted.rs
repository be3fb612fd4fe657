//! Elements that are sorted into rows on a device.

use bytemuck::Pod;
use fdem_contact::{FilterNumbers, Real, RowCells};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{
    Address, CellHeadArguments, Cells, GatherArguments, GatherWordArguments, Kernel, KeyArguments,
    RankArguments, SetArguments, StartArguments,
};
use crate::primitives::{Sort, Sums, launch};

/// Bits that a key may have for row and place together.
const KEY_BITS: u32 = 64;

/// Elements in the order of [`RowCells`].
pub(crate) struct SortedRows<M, T, const N: usize> {
    given_points: Array<M, T>,
    given_radii: Array<M, T>,
    given_labels: Array<M, u32>,
    pub(crate) sort: Sort<M>,
    crowded: Array<M, u32>,
    coordinates: Array<M, T>,
    radii: Array<M, T>,
    labels: [Array<M, u32>; 3],
    matrix: Array<M, u32>,
    /// Where rows begin, and later how many partners each element has.
    counts: Array<M, u32>,
    cell_heads: Array<M, u32>,
    pub(crate) sums: Sums<M>,
    row_of: Array<M, u32>,
    starts: Array<M, u32>,
    rows: Array<M, u64>,
    set: SetArguments,
    /// Matrix of the groups that see each other, and words of its rows; 0 without one.
    pub(crate) groups: (Address, u64),
    pub(crate) row_count: usize,
}

/// Where the points of some elements are on a device, and their radii; 0 for one radius.
#[derive(Clone, Copy)]
pub(crate) struct Places {
    pub(crate) points: Address,
    pub(crate) radii: Address,
    pub(crate) count: usize,
}

impl<M, T: Real + Pod, const N: usize> SortedRows<M, T, N> {
    pub(crate) const SINGLE: u32 = if T::IS_F64 { 0 } else { 1 };

    pub(crate) const fn new() -> Self {
        let set = SetArguments { coordinates: 0, radii: 0, ids: 0, labels: [0; 3], count: 0 };
        Self {
            given_points: Array::new(),
            given_radii: Array::new(),
            given_labels: Array::new(),
            sort: Sort::new(),
            crowded: Array::new(),
            coordinates: Array::new(),
            radii: Array::new(),
            labels: [const { Array::new() }; 3],
            matrix: Array::new(),
            counts: Array::new(),
            cell_heads: Array::new(),
            sums: Sums::new(),
            row_of: Array::new(),
            starts: Array::new(),
            rows: Array::new(),
            set,
            groups: (0, 0),
            row_count: 0,
        }
    }

    /// Copies elements to the device.
    pub(crate) fn give(
        &mut self,
        device: &impl Device<Memory = M>,
        points: &[[T; N]],
        radii: &[T],
    ) -> Result<Places, GpuError> {
        let count = points.len();
        let points = self.given_points.write(device, points.as_flattened())?;
        let radii = if radii.is_empty() { 0 } else { self.given_radii.write(device, radii)? };
        Ok(Places { points, radii, count })
    }

    /// The elements in their order. Their numbers are there until something else is sorted.
    pub(crate) fn set(&self) -> SetArguments {
        self.set
    }

    /// The number of partners of each element, once they are counted.
    pub(crate) fn counts(&self, device: &impl Device<Memory = M>) -> Address {
        self.counts.address(device)
    }

    /// The row of each element, where each row begins, and the cells of each row.
    pub(crate) fn rows(&self, device: &impl Device<Memory = M>) -> [Address; 3] {
        [self.row_of.address(device), self.starts.address(device), self.rows.address(device)]
    }

    /// Sorts elements, and finds their rows.
    pub(crate) fn build(
        &mut self,
        device: &impl Device<Memory = M>,
        places: Places,
        row_cells: &RowCells<N>,
    ) -> Result<(), GpuError> {
        let (cells, n) = (cells_of(row_cells), places.count);
        self.sort_elements(device, places, row_cells)?;
        let ids = self.sort.arrays(device).1;
        let (dimensions, count, single) = (N as u32, n as u64, Self::SINGLE);
        let coordinates = self.coordinates.resize(device, N * n)?;
        let sorted_radii = if places.radii == 0 { 0 } else { self.radii.resize(device, n)? };
        self.set = SetArguments { coordinates, radii: sorted_radii, ids, labels: [0; 3], count };
        self.groups = (0, 0);
        let heads = self.counts.resize(device, n)?;
        let arguments = GatherArguments {
            points: places.points,
            radii: places.radii,
            ids,
            coordinates,
            sorted_radii,
            heads,
            cells,
            count,
            dimensions,
            single,
        };
        launch(device, Kernel::RowGather, n, &arguments)?;

        let before = self.sums.add_up(device, heads, n)?;
        self.row_count = self.sums.total(device, n)? as usize;
        let arguments = StartArguments {
            coordinates,
            heads,
            before,
            row_of: self.row_of.resize(device, n)?,
            starts: self.starts.resize(device, self.row_count + 1)?,
            rows: self.rows.resize(device, 2 * self.row_count)?,
            cells,
            count,
            dimensions,
            single,
        };
        launch(device, Kernel::RowStarts, n, &arguments)
    }

    /// The average number of elements per occupied cell, for elements that were sorted by these cells last.
    pub(crate) fn load(
        &mut self,
        device: &impl Device<Memory = M>,
        row_cells: &RowCells<N>,
    ) -> Result<f64, GpuError> {
        let n = self.set.count as usize;
        let cell_heads = self.cell_heads.resize(device, n)?;
        let arguments = CellHeadArguments {
            coordinates: self.set.coordinates,
            heads: self.counts.address(device),
            cell_heads,
            cells: cells_of(row_cells),
            count: n as u64,
            single: Self::SINGLE,
            unused: 0,
        };
        launch(device, Kernel::CellHeads, n, &arguments)?;
        self.sums.add_up(device, cell_heads, n)?;
        Ok(n as f64 / self.sums.total(device, n)? as f64)
    }

    /// Copies the numbers of a filter to the device, and brings them into order.
    pub(crate) fn label(
        &mut self,
        device: &impl Device<Memory = M>,
        numbers: &FilterNumbers<'_>,
    ) -> Result<(), GpuError> {
        let (n, ids) = (self.set.count as usize, self.set.ids);
        for (kind, given) in [numbers.bodies, numbers.firsts, numbers.seconds].into_iter().enumerate() {
            if given.is_empty() {
                continue;
            }
            let words = self.given_labels.write(device, given)?;
            let sorted = self.labels[kind].resize(device, n)?;
            launch(
                device,
                Kernel::GatherWords,
                n,
                &GatherWordArguments { words, ids, sorted, count: n as u64 },
            )?;
            self.set.labels[kind] = sorted;
        }
        Ok(())
    }

    /// The same, with the matrix of groups.
    pub(crate) fn filter(
        &mut self,
        device: &impl Device<Memory = M>,
        numbers: &FilterNumbers<'_>,
    ) -> Result<(), GpuError> {
        self.label(device, numbers)?;
        if !numbers.matrix.is_empty() {
            self.groups = (self.matrix.write(device, numbers.matrix)?, numbers.words as u64);
        }
        Ok(())
    }

    /// A radius for each of the elements, which have but one.
    pub(crate) fn one_radius(
        &mut self,
        device: &impl Device<Memory = M>,
        radius: T,
    ) -> Result<Address, GpuError> {
        self.radii.write(device, &vec![radius; self.set.count as usize])
    }

    /// Sorts the numbers of the elements by row, along the row, then by number.
    fn sort_elements(
        &mut self,
        device: &impl Device<Memory = M>,
        places: Places,
        cells: &RowCells<N>,
    ) -> Result<(), GpuError> {
        let n = places.count;
        let [long, others @ ..] = &cells.axes[..] else { return Ok(()) };
        let (keys, ids) = self.sort.resize(device, n)?;
        let arguments = KeyArguments {
            points: places.points,
            keys,
            ids,
            cells: cells_of(cells),
            kind: 0,
            first: 1,
            place_bits: bits(4 * cells.cells[*long] + 4),
            dimensions: N as u32,
            second: cells.cells[others[0]],
            count: n as u64,
            single: Self::SINGLE,
            unused: 0,
        };
        let row_bits = others.iter().map(|&axis| bits(cells.cells[axis])).sum::<u32>();
        if row_bits + arguments.place_bits <= KEY_BITS {
            launch(device, Kernel::RowKeys, n, &arguments)?;
            self.sort.sort(device, n, row_bits + arguments.place_bits)?;
            let crowded = self.crowded.write(device, &[0])?;
            let (keys, ids) = self.sort.arrays(device);
            let ranks = RankArguments {
                points: places.points,
                keys,
                ids,
                ranked: self.sort.other_ids(device),
                crowded,
                count: n as u64,
                dimensions: N as u32,
                axis: *long as u32,
                single: Self::SINGLE,
                unused: 0,
            };
            launch(device, Kernel::RowRanks, n, &ranks)?;
            let mut is_crowded = [0];
            self.crowded.read(device, 0, &mut is_crowded)?;
            if is_crowded == [0] {
                self.sort.take_other_ids();
                return Ok(());
            }
        }
        // By all digits of each number, from the least important one on.
        for (kind, &axis) in (1..).zip(&cells.axes) {
            let (keys, ids) = self.sort.arrays(device);
            let arguments = KeyArguments { keys, ids, kind, first: u32::from(kind == 1), ..arguments };
            launch(device, Kernel::RowKeys, n, &arguments)?;
            self.sort.sort(device, n, if kind == 1 { 64 } else { bits(cells.cells[axis]) })?;
        }
        Ok(())
    }
}

pub(crate) fn cells_of<const N: usize>(cells: &RowCells<N>) -> Cells {
    let (mut origin, mut axes) = ([0.0; 3], [0; 3]);
    origin[..N].copy_from_slice(&cells.origin);
    axes.iter_mut().zip(&cells.axes).for_each(|(to, &axis)| *to = axis as u32);
    Cells { origin, inverse: cells.inverse, axes, unused: 0 }
}

/// Bits that the numbers below `count` have.
pub(crate) fn bits(count: u64) -> u32 {
    u64::BITS - count.saturating_sub(1).leading_zeros()
}
