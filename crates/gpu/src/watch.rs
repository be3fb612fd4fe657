//! Elements of a simulation on a device whose facets may fail.

use fdem_simulation::NotedState;

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Address, Kernel, MarkedArguments, WatchArguments};
use crate::patch::{Columns, Rows};
use crate::primitives::{Sums, launch};

/// Marks of places, and the list of those that are marked.
pub(crate) struct MarkedList<M> {
    sums: Sums<M>,
    list: Array<M, u32>,
}

impl<M> MarkedList<M> {
    pub(crate) const fn new() -> Self {
        Self { sums: Sums::new(), list: Array::new() }
    }

    /// The places whose marks are 1, ascending.
    pub(crate) fn of(
        &mut self,
        device: &impl Device<Memory = M>,
        marks: Address,
        count: usize,
    ) -> Result<Vec<u32>, GpuError> {
        let before = self.sums.add_up(device, marks, count)?;
        let marked = self.sums.total(device, count)? as usize;
        let list = self.list.resize(device, marked)?;
        let arguments = MarkedArguments { marks, before, list, count: count as u64 };
        launch(device, Kernel::ListMarked, count, &arguments)?;
        self.list.to_vec(device, marked)
    }
}

/// The noted states of all elements, and the present ones.
pub(crate) struct DeviceWatch<M, const D: usize> {
    noted: Array<M, f32>,
    limits: Array<M, f64>,
    moved: Array<M, f64>,
    awake: Array<M, u32>,
    list: MarkedList<M>,
}

impl<M, const D: usize> DeviceWatch<M, D> {
    pub(crate) const fn new() -> Self {
        Self {
            noted: Array::new(),
            limits: Array::new(),
            moved: Array::new(),
            awake: Array::new(),
            list: MarkedList::new(),
        }
    }

    /// Whether no state was noted yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.noted.memory().is_none()
    }

    /// `any_awake`: where it is noted that an element is awake.
    pub(crate) fn arguments(&self, device: &impl Device<Memory = M>, any_awake: Address) -> WatchArguments {
        WatchArguments {
            noted: self.noted.address(device),
            limits: self.limits.address(device),
            moved: self.moved.address(device),
            awake: self.awake.address(device),
            any_awake,
        }
    }

    /// Takes over the states of the chosen elements, or of all elements, `count`, if none was noted yet.
    pub(crate) fn note(
        &mut self,
        device: &impl Device<Memory = M>,
        rows: &mut Rows<M>,
        states: &[NotedState<D>],
        count: usize,
    ) -> Result<(), GpuError> {
        let upper = |stress: [[f32; D]; D]| (0..D).flat_map(move |i| (i..D).map(move |k| stress[i][k]));
        let numbers = |of: &NotedState<D>| upper(of.stress).chain(of.edges.into_iter().flatten());
        let noted: Vec<f32> = states.iter().flat_map(numbers).collect();
        let limits: Vec<[f64; 2]> = states.iter().map(|of| [of.shift, of.reach]).collect();
        if self.is_empty() {
            // All elements.
            self.noted.write(device, &noted)?;
            self.limits.write(device, limits.as_flattened())?;
            self.moved.write(device, &vec![0.0; count])?;
            self.awake.resize(device, count)?;
            return Ok(());
        }
        rows.write(device, &self.noted, Columns::ONE, &noted)?;
        rows.write(device, &self.limits, Columns::ONE, limits.as_flattened())
    }

    /// The elements, ascending, that were awake in the last deformation, out of `count`.
    pub(crate) fn awake(
        &mut self,
        device: &impl Device<Memory = M>,
        count: usize,
    ) -> Result<Vec<u32>, GpuError> {
        self.list.of(device, self.awake.address(device), count)
    }

    /// The squares of the changes of stress of the chosen elements.
    pub(crate) fn moved(
        &self,
        device: &impl Device<Memory = M>,
        rows: &mut Rows<M>,
        moved: &mut [f64],
    ) -> Result<(), GpuError> {
        rows.read(device, &self.moved, Columns::ONE, moved)
    }
}
