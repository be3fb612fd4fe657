//! Contact detection by sorted rows on a device.

mod lists;

use bytemuck::Pod;
use fdem_contact::{Couple, Elements, Error, Real, Rows, RowsInput, Search};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{
    Cells, GatherArguments, Kernel, KeyArguments, NeighbourArguments, PairArguments, RankArguments,
    StartArguments,
};
use crate::primitives::{Sort, Sums, launch};

/// Bits that a key may have for row and place together.
const KEY_BITS: u32 = 64;

/// Searches for contacts on a device: the couples of [`Rows`], in its order.
///
/// Spheres of one radius or of many, and points, in the plane and in space, in `f64` and `f32`. The order is
/// defined at [`RowsInput`]. It depends neither on the device nor on the number of its threads.
///
/// # Cost
/// Time and memory proportional to the number of elements for similar sizes, whatever the domain. Memory of
/// the device for each element in space: 24 bytes for the points that come, 24 for their copy by rows, 24 for
/// two lists of keys and numbers, 12 for sums and counts, at most 40 for its row, 16 for two radii if there
/// are many; and 8 for each couple of a list.
///
/// # Example
/// ```text
/// let device = Cuda::new(0)?;
/// let mut search = DeviceRows::new(&device);
/// search.couples(&Elements::points(&centres, 1.0)?, &mut couples)?;
/// ```
pub struct DeviceRows<'d, D: Device, T, const N: usize> {
    device: &'d D,
    points: Array<D::Memory, T>,
    radii: Array<D::Memory, T>,
    sort: Sort<D::Memory>,
    crowded: Array<D::Memory, u32>,
    coordinates: Array<D::Memory, T>,
    sorted_radii: Array<D::Memory, T>,
    /// Where rows begin, and later how many partners each element has.
    counts: Array<D::Memory, u32>,
    sums: Sums<D::Memory>,
    row_of: Array<D::Memory, u32>,
    starts: Array<D::Memory, u32>,
    rows: Array<D::Memory, u64>,
    neighbours: Array<D::Memory, u32>,
    couples: Array<D::Memory, [u32; 2]>,
    /// Rows of neighbours, their entries and distances.
    row_starts: Array<D::Memory, u64>,
    entries: Array<D::Memory, u32>,
    distances: Array<D::Memory, T>,
}

impl<'d, D: Device, T: Real + Pod, const N: usize> DeviceRows<'d, D, T, N> {
    const SINGLE: u32 = if T::IS_F64 { 0 } else { 1 };

    /// A search that holds no memory yet.
    pub fn new(device: &'d D) -> Self {
        Self {
            device,
            points: Array::new(),
            radii: Array::new(),
            sort: Sort::new(),
            crowded: Array::new(),
            coordinates: Array::new(),
            sorted_radii: Array::new(),
            counts: Array::new(),
            sums: Sums::new(),
            row_of: Array::new(),
            starts: Array::new(),
            rows: Array::new(),
            neighbours: Array::new(),
            couples: Array::new(),
            row_starts: Array::new(),
            entries: Array::new(),
            distances: Array::new(),
        }
    }

    /// The couples as pairs of numbers, the smaller one first.
    fn list(&mut self, elements: &Elements<'_, T, N>) -> Result<Vec<[u32; 2]>, GpuError> {
        let Some(input) = input(elements)? else { return Ok(Vec::new()) };
        let total = self.listed(&input)?;
        self.couples.to_vec(self.device, total)
    }

    /// Writes the couples on the device. Returns how many there are.
    fn listed(&mut self, input: &RowsInput<'_, T, N>) -> Result<usize, GpuError> {
        let (arguments, total) = self.counted(input)?;
        let total = usize::try_from(total).map_err(|_| GpuError::OutOfMemory { bytes: usize::MAX })?;
        let couples = self.couples.resize(self.device, total)?;
        let count = input.points.len();
        launch(self.device, Self::pair_kernels()[1], count, &PairArguments { couples, ..arguments })?;
        Ok(total)
    }

    /// Sorts the elements and counts the partners of each. Returns the arguments for a list, and the number
    /// of couples.
    fn counted(&mut self, input: &RowsInput<'_, T, N>) -> Result<(PairArguments, u64), GpuError> {
        let (device, n) = (self.device, input.points.len());
        let points = self.points.write(device, input.points.as_flattened())?;
        let radii = if input.radii.is_empty() { 0 } else { self.radii.write(device, input.radii)? };
        let cells = cells_of(input);
        self.sort_elements(input, points, cells)?;
        let ids = self.sort.arrays(device).1;
        let (dimensions, count) = (N as u32, n as u64);

        let coordinates = self.coordinates.resize(device, N * n)?;
        let sorted_radii = if radii == 0 { 0 } else { self.sorted_radii.resize(device, n)? };
        let heads = self.counts.resize(device, n)?;
        let arguments = GatherArguments {
            points,
            radii,
            ids,
            coordinates,
            sorted_radii,
            heads,
            cells,
            count,
            dimensions,
            single: Self::SINGLE,
        };
        launch(device, Kernel::RowGather, n, &arguments)?;

        let before = self.sums.add_up(device, heads, n)?;
        let row_count = self.sums.total(device, n)? as usize;
        let row_of = self.row_of.resize(device, n)?;
        let starts = self.starts.resize(device, row_count + 1)?;
        let rows = self.rows.resize(device, 2 * row_count)?;
        let arguments = StartArguments {
            coordinates,
            heads,
            before,
            row_of,
            starts,
            rows,
            cells,
            count,
            dimensions,
            single: Self::SINGLE,
        };
        launch(device, Kernel::RowStarts, n, &arguments)?;

        let mask = if N == 2 { 1 } else { 4 };
        let all = row_count * mask as usize;
        let neighbours = self.neighbours.resize(device, all)?;
        let arguments = NeighbourArguments { rows, neighbours, count: row_count as u64, mask, unused: 0 };
        launch(device, Kernel::RowNeighbours, all, &arguments)?;

        let mut arguments = PairArguments {
            coordinates,
            radii: sorted_radii,
            ids,
            row_of,
            starts,
            neighbours,
            counts: heads,
            before: 0,
            couples: 0,
            count,
            reach: input.reach.to_f64(),
            reach_squared: input.reach_squared.to_f64(),
            tolerance: input.tolerance.to_f64(),
            mask,
            axis: input.axes[0] as u32,
        };
        launch(device, Self::pair_kernels()[0], n, &arguments)?;
        arguments.before = self.sums.add_up(device, heads, n)?;
        Ok((arguments, self.sums.total(device, n)?))
    }

    /// The kernels that count couples and list them.
    fn pair_kernels() -> [Kernel; 2] {
        match (N, T::IS_F64) {
            (2, true) => [Kernel::CountPairs2, Kernel::ListPairs2],
            (2, false) => [Kernel::CountPairs2Single, Kernel::ListPairs2Single],
            (_, true) => [Kernel::CountPairs3, Kernel::ListPairs3],
            (_, false) => [Kernel::CountPairs3Single, Kernel::ListPairs3Single],
        }
    }

    /// Sorts the numbers of the elements by row, along the row, then by number.
    fn sort_elements(
        &mut self,
        input: &RowsInput<'_, T, N>,
        points: u64,
        cells: Cells,
    ) -> Result<(), GpuError> {
        let (device, n) = (self.device, input.points.len());
        let [long, others @ ..] = &input.axes[..] else { return Ok(()) };
        let (keys, ids) = self.sort.resize(device, n)?;
        let arguments = KeyArguments {
            points,
            keys,
            ids,
            cells,
            kind: 0,
            first: 1,
            place_bits: bits(4 * input.cells[*long] + 4),
            dimensions: N as u32,
            second: input.cells[others[0]],
            count: n as u64,
            single: Self::SINGLE,
            unused: 0,
        };
        let row_bits = others.iter().map(|&axis| bits(input.cells[axis])).sum::<u32>();
        if row_bits + arguments.place_bits <= KEY_BITS {
            launch(device, Kernel::RowKeys, n, &arguments)?;
            self.sort.sort(device, n, row_bits + arguments.place_bits)?;
            let crowded = self.crowded.write(device, &[0])?;
            let (keys, ids) = self.sort.arrays(device);
            let ranks = RankArguments {
                points,
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
        for (kind, &axis) in (1..).zip(&input.axes) {
            let (keys, ids) = self.sort.arrays(device);
            let arguments = KeyArguments { keys, ids, kind, first: u32::from(kind == 1), ..arguments };
            launch(device, Kernel::RowKeys, n, &arguments)?;
            self.sort.sort(device, n, if kind == 1 { 64 } else { bits(input.cells[axis]) })?;
        }
        Ok(())
    }
}

/// Its errors are [`Error::Device`] with the words of a [`GpuError`]: [`GpuError::Unsupported`] for boxes,
/// filters, and other than two or three dimensions; [`GpuError::OutOfMemory`]; [`GpuError::Driver`].
impl<D: Device, T: Real + Pod, const N: usize> Search<T, N> for DeviceRows<'_, D, T, N> {
    fn for_each(
        &mut self,
        elements: &Elements<'_, T, N>,
        mut visit: impl FnMut(Couple),
    ) -> Result<(), Error> {
        self.list(elements)?.into_iter().for_each(|[i, j]| visit(Couple { i, j }));
        Ok(())
    }

    fn count(&mut self, elements: &Elements<'_, T, N>) -> Result<u64, Error> {
        match input(elements)? {
            Some(input) => Ok(self.counted(&input)?.1),
            None => Ok(0),
        }
    }
}

/// The input of a search; `None` for no elements.
fn input<'a, T: Real, const N: usize>(
    elements: &Elements<'a, T, N>,
) -> Result<Option<RowsInput<'a, T, N>>, GpuError> {
    if elements.is_empty() {
        return Ok(None);
    }
    if N != 2 && N != 3 {
        return Err(GpuError::Unsupported { what: "other than two or three dimensions" });
    }
    let input = Rows::new().input(elements);
    input
        .map(Some)
        .ok_or(GpuError::Unsupported { what: "boxes, and no elements with bodies, groups or masks" })
}

fn cells_of<T, const N: usize>(input: &RowsInput<'_, T, N>) -> Cells {
    let (mut origin, mut axes) = ([0.0; 3], [0; 3]);
    origin[..N].copy_from_slice(&input.origin);
    axes.iter_mut().zip(&input.axes).for_each(|(to, &axis)| *to = axis as u32);
    Cells { origin, inverse: input.inverse, axes, unused: 0 }
}

/// Bits that the numbers below `count` have.
fn bits(count: u64) -> u32 {
    u64::BITS - count.saturating_sub(1).leading_zeros()
}
