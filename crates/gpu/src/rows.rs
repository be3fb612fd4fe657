//! Contact detection by sorted rows on a device.

mod lists;
pub(crate) mod placed;

use bytemuck::Pod;
use fdem_contact::{Couple, Elements, Error, Real, Rows, RowsInput, Search};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Extremes, Kernel, NeighbourArguments, OneSetArguments, PairArguments};
use crate::primitives::launch;
use crate::sorted::{Places, SortedRows};

/// Searches for contacts on a device: the couples of [`Rows`], in its order.
///
/// Spheres of one radius or of many, and points, in the plane and in space, in `f64` and `f32`, with or
/// without a filter. The order is defined at [`RowsInput`]. It depends neither on the device nor on the
/// number of its threads.
///
/// In a periodic box, [`PeriodicSearch::couples_by`](fdem_contact::PeriodicSearch::couples_by) searches with
/// it; images are made on the processor.
///
/// # Cost
/// Time and memory proportional to the number of elements for similar sizes, whatever the domain. Memory of
/// the device for each element in space and in `f64`: 24 bytes for the points that come, 24 for their copy by
/// rows, 24 for two lists of keys and numbers, 12 for sums and counts, at most 40 for its row, 16 for two
/// radii if there are many, at most 16 for a filter; and 8 for each couple of a list.
///
/// # Example
/// ```text
/// let device = Cuda::new(0)?;
/// let mut search = DeviceRows::new(&device);
/// search.couples(&Elements::points(&centres, 1.0)?, &mut couples)?;
/// ```
pub struct DeviceRows<'d, D: Device, T, const N: usize> {
    device: &'d D,
    elements: SortedRows<D::Memory, T, N>,
    neighbours: Array<D::Memory, u32>,
    couples: Array<D::Memory, [u32; 2]>,
    /// Rows of neighbours, their entries and distances.
    row_starts: Array<D::Memory, u64>,
    entries: Array<D::Memory, u32>,
    distances: Array<D::Memory, T>,
    /// Extremes and a sample of elements that were on the device.
    extremes: Array<D::Memory, Extremes>,
    sample: Array<D::Memory, T>,
}

impl<'d, D: Device, T: Real + Pod, const N: usize> DeviceRows<'d, D, T, N> {
    /// A search that holds no memory yet.
    pub fn new(device: &'d D) -> Self {
        Self {
            device,
            elements: SortedRows::new(),
            neighbours: Array::new(),
            couples: Array::new(),
            row_starts: Array::new(),
            entries: Array::new(),
            distances: Array::new(),
            extremes: Array::new(),
            sample: Array::new(),
        }
    }

    /// The couples as pairs of numbers, the smaller one first.
    fn list(&mut self, elements: &Elements<'_, T, N>) -> Result<Vec<[u32; 2]>, GpuError> {
        let Some(input) = input(elements)? else { return Ok(Vec::new()) };
        let places = self.elements.give(self.device, input.points, input.radii)?;
        let total = self.listed(places, &input)?;
        self.couples.to_vec(self.device, total)
    }

    /// Writes the couples on the device. Returns their number.
    fn listed(&mut self, places: Places, input: &RowsInput<'_, T, N>) -> Result<usize, GpuError> {
        let (mut arguments, couples) = self.counted(places, input)?;
        let total = usize::try_from(couples).map_err(|_| GpuError::OutOfMemory { bytes: usize::MAX })?;
        arguments.pairs.couples = self.couples.resize(self.device, total)?;
        launch(self.device, kernels::<T, N>()[1], places.count, &arguments)?;
        Ok(total)
    }

    /// Sorts the elements and counts the partners of each. Returns the arguments for a list, and the number
    /// of couples.
    fn counted(
        &mut self,
        places: Places,
        input: &RowsInput<'_, T, N>,
    ) -> Result<(OneSetArguments, u64), GpuError> {
        self.elements.build(self.device, places, &input.cells)?;
        let (device, n) = (self.device, places.count);
        if let Some(filter) = input.filter {
            self.elements.filter(device, &filter.numbers())?;
        }
        let (matrix, words) = self.elements.groups;
        let mask = if N == 2 { 1 } else { 4 };
        let row_count = self.elements.row_count;
        let all = row_count * mask as usize;
        let neighbours = self.neighbours.resize(device, all)?;
        let [row_of, starts, rows] = self.elements.rows(device);
        let arguments = NeighbourArguments { rows, neighbours, count: row_count as u64, mask, unused: 0 };
        launch(device, Kernel::RowNeighbours, all, &arguments)?;

        let own = self.elements.set();
        let counts = self.elements.counts(device);
        let pairs = PairArguments {
            own,
            other: own,
            matrix,
            words,
            counts,
            before: 0,
            couples: 0,
            reach: input.reach.to_f64(),
            reach_squared: input.reach_squared.to_f64(),
            tolerance: input.tolerance.to_f64(),
            axis: input.cells.axes[0] as u64,
        };
        let mut arguments = OneSetArguments { pairs, row_of, starts, neighbours, mask: u64::from(mask) };
        launch(device, kernels::<T, N>()[0], n, &arguments)?;
        arguments.pairs.before = self.elements.sums.add_up(device, counts, n)?;
        Ok((arguments, self.elements.sums.total(device, n)?))
    }
}

/// The kernels that count couples and list them.
fn kernels<T: Real, const N: usize>() -> [Kernel; 2] {
    match (N, T::IS_F64) {
        (2, true) => [Kernel::CountPairs2, Kernel::ListPairs2],
        (2, false) => [Kernel::CountPairs2Single, Kernel::ListPairs2Single],
        (_, true) => [Kernel::CountPairs3, Kernel::ListPairs3],
        (_, false) => [Kernel::CountPairs3Single, Kernel::ListPairs3Single],
    }
}

/// Its errors are [`Error::Device`] with the words of a [`GpuError`]: [`GpuError::Unsupported`] for boxes,
/// and other than two or three dimensions; [`GpuError::OutOfMemory`]; [`GpuError::Driver`].
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
        let Some(input) = input(elements)? else { return Ok(0) };
        let places = self.elements.give(self.device, input.points, input.radii)?;
        Ok(self.counted(places, &input)?.1)
    }
}

/// Refuses dimensions that no kernel has.
pub(crate) fn check_dimensions(dimensions: usize) -> Result<(), GpuError> {
    if matches!(dimensions, 2 | 3) {
        return Ok(());
    }
    Err(GpuError::Unsupported { what: "other than two or three dimensions" })
}

/// The input of a search; `None` for no elements.
fn input<'a, T: Real, const N: usize>(
    elements: &Elements<'a, T, N>,
) -> Result<Option<RowsInput<'a, T, N>>, GpuError> {
    if elements.is_empty() {
        return Ok(None);
    }
    check_dimensions(N)?;
    Rows::new().input(elements).map(Some).ok_or(GpuError::Unsupported { what: "boxes" })
}
