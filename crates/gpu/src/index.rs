//! Two sets of elements on a device.

use bytemuck::Pod;
use fdem_contact::{CrossCouple, CrossInput, Elements, Error, IndexInput, Real};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Kernel, PairArguments, TwoSetArguments};
use crate::primitives::launch;
use crate::rows::check_dimensions;
use crate::sorted::{SortedRows, cells_of};

/// Elements on a device that are sorted once and searched many times: the couples of
/// [`Index::couples_with`](fdem_contact::Index::couples_with), in its order, which [`CrossInput`] defines.
///
/// # Cost
/// The cost of [`DeviceRows`](crate::DeviceRows), for each of the two sets. If sizes say little about
/// density, the elements of the index are sorted up to six times.
///
/// # Example
/// ```text
/// let mut index = DeviceIndex::new(&device);
/// index.build(&Elements::spheres(&wall, 0.5)?)?;
/// index.couples_with(&Elements::spheres(&grains, 0.5)?, &mut couples)?;
/// ```
pub struct DeviceIndex<'d, D: Device, T, const N: usize> {
    device: &'d D,
    state: IndexState<T, N>,
    fixed: SortedRows<D::Memory, T, N>,
    moving: SortedRows<D::Memory, T, N>,
    couples: Array<D::Memory, [u32; 2]>,
}

/// Whether there is an index, and its numbers.
enum IndexState<T, const N: usize> {
    NotBuilt,
    Empty,
    Built(IndexInput<T, N>),
}

impl<'d, D: Device, T: Real + Pod, const N: usize> DeviceIndex<'d, D, T, N> {
    /// An index that is not built yet, and holds no memory.
    pub fn new(device: &'d D) -> Self {
        Self {
            device,
            state: IndexState::NotBuilt,
            fixed: SortedRows::new(),
            moving: SortedRows::new(),
            couples: Array::new(),
        }
    }

    /// Copies the elements to the device and sorts them. Earlier elements are replaced.
    ///
    /// # Errors
    /// [`Error::Device`] with the words of a [`GpuError`]: [`GpuError::Unsupported`] for boxes, and other
    /// than two or three dimensions; [`GpuError::OutOfMemory`]; [`GpuError::Driver`]. The index is then not
    /// built.
    pub fn build(&mut self, elements: &Elements<'_, T, N>) -> Result<(), Error> {
        self.state = IndexState::NotBuilt;
        check_dimensions(N)?;
        if elements.is_empty() {
            self.state = IndexState::Empty;
            return Ok(());
        }
        let (device, fixed) = (self.device, &mut self.fixed);
        let mut places = None;
        let input = IndexInput::new(elements, |cells, points, radii| {
            let places = match places {
                Some(places) => places,
                None => *places.insert(fixed.give(device, points, radii)?),
            };
            fixed.build(device, places, &cells)?;
            Ok::<_, Error>(fixed.load(device, &cells)?)
        })?;
        let input = input.ok_or(GpuError::Unsupported { what: "boxes" })?;
        if let Some(filter) = elements.filter() {
            self.fixed.filter(device, &filter.numbers())?;
        }
        self.state = IndexState::Built(input);
        Ok(())
    }

    /// Writes the couples of `elements` with those of the index into `couples`, which is cleared first.
    ///
    /// # Errors
    /// [`Error::IndexNotBuilt`], [`Error::UnlikeShapes`], [`Error::UnlikeFilters`], and [`Error::Device`] as
    /// [`Self::build`] has it. `couples` is empty then.
    pub fn couples_with(
        &mut self,
        elements: &Elements<'_, T, N>,
        couples: &mut Vec<CrossCouple>,
    ) -> Result<(), Error> {
        couples.clear();
        let Some(input) = self.input(elements)? else { return Ok(()) };
        let (mut arguments, count) = self.counted(&input)?;
        let count = usize::try_from(count).map_err(|_| GpuError::OutOfMemory { bytes: usize::MAX })?;
        arguments.pairs.couples = self.couples.resize(self.device, count)?;
        launch(self.device, kernels::<T, N>()[1], input.points.len(), &arguments)?;
        let found = self.couples.to_vec(self.device, count)?;
        couples.extend(found.into_iter().map(|[i, j]| CrossCouple { i, j }));
        Ok(())
    }

    /// The number of couples of [`Self::couples_with`].
    ///
    /// # Errors
    /// The errors of [`Self::couples_with`].
    pub fn count_with(&mut self, elements: &Elements<'_, T, N>) -> Result<u64, Error> {
        let Some(input) = self.input(elements)? else { return Ok(0) };
        Ok(self.counted(&input)?.1)
    }

    /// The input of a search; `None` if one of the sets is empty.
    fn input<'a>(&self, elements: &Elements<'a, T, N>) -> Result<Option<CrossInput<'a, T, N>>, Error> {
        match &self.state {
            IndexState::NotBuilt => Err(Error::IndexNotBuilt),
            IndexState::Empty => Ok(None),
            IndexState::Built(input) => input.with(elements),
        }
    }

    /// Sorts the elements and counts the partners of each. Returns the arguments for a list, and the number
    /// of couples.
    fn counted(&mut self, input: &CrossInput<'_, T, N>) -> Result<(TwoSetArguments, u64), GpuError> {
        let device = self.device;
        let places = self.moving.give(device, input.points, input.radii)?;
        self.moving.build(device, places, &input.cells)?;
        if let Some(filter) = input.filter {
            self.moving.label(device, &filter.numbers())?;
        }
        let (mut own, mut other) = (self.moving.set(), self.fixed.set());
        match input.radius {
            [Some(_), Some(_)] => (own.radii, other.radii) = (0, 0),
            [Some(radius), None] => own.radii = self.moving.one_radius(device, radius)?,
            [None, Some(radius)] => other.radii = self.fixed.one_radius(device, radius)?,
            [None, None] => {}
        }
        let counts = self.moving.counts(device);
        let (matrix, words) = self.fixed.groups;
        let pairs = PairArguments {
            own,
            other,
            matrix,
            words,
            counts,
            before: 0,
            couples: 0,
            reach: input.reach.to_f64(),
            reach_squared: input.reach_squared.to_f64(),
            tolerance: input.tolerance.to_f64(),
            axis: input.index.axes[0] as u64,
        };
        let mut last = [0.0; 3];
        last.iter_mut().zip(input.index.cells).for_each(|(last, cells)| *last = (cells - 1) as f64);
        let [_, starts, rows] = self.fixed.rows(device);
        let row_count = self.fixed.row_count as u64;
        let cells = cells_of(&input.index);
        let mut arguments = TwoSetArguments { pairs, starts, rows, row_count, cells, last };
        let n = places.count;
        launch(device, kernels::<T, N>()[0], n, &arguments)?;
        arguments.pairs.before = self.moving.sums.add_up(device, counts, n)?;
        Ok((arguments, self.moving.sums.total(device, n)?))
    }
}

/// The kernels that count couples and list them.
fn kernels<T: Real, const N: usize>() -> [Kernel; 2] {
    match (N, T::IS_F64) {
        (2, true) => [Kernel::CountCrosses2, Kernel::ListCrosses2],
        (2, false) => [Kernel::CountCrosses2Single, Kernel::ListCrosses2Single],
        (_, true) => [Kernel::CountCrosses3, Kernel::ListCrosses3],
        (_, false) => [Kernel::CountCrosses3Single, Kernel::ListCrosses3Single],
    }
}
