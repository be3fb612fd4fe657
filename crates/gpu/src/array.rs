//! Arrays in the memory of a device.

use std::marker::PhantomData;

use bytemuck::Pod;

use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::Address;

/// Numbers in the memory of a device; the memory grows and stays.
pub(crate) struct Array<M, T> {
    memory: Option<M>,
    /// Numbers for which there is room.
    room: usize,
    of: PhantomData<T>,
}

impl<M, T: Pod> Array<M, T> {
    pub(crate) const fn new() -> Self {
        Self { memory: None, room: 0, of: PhantomData }
    }

    /// Makes room for some numbers, whose values are lost if there was less. Returns where they are.
    pub(crate) fn resize(
        &mut self,
        device: &impl Device<Memory = M>,
        count: usize,
    ) -> Result<Address, GpuError> {
        if self.memory.is_none() || count > self.room {
            // The old memory is free before the new one is taken.
            (self.memory, self.room) = (None, 0);
            let bytes = count.max(1).checked_mul(size_of::<T>());
            let bytes = bytes.ok_or(GpuError::OutOfMemory { bytes: usize::MAX })?;
            self.memory = Some(device.allocate(bytes)?);
            self.room = count;
        }
        Ok(self.address(device))
    }

    /// Makes room for more numbers, and for a quarter more than that. Returns the former memory and its room,
    /// if there was less, so that its numbers can be copied.
    pub(crate) fn extend(
        &mut self,
        device: &impl Device<Memory = M>,
        count: usize,
    ) -> Result<Option<(M, usize)>, GpuError> {
        if self.memory.is_some() && count <= self.room {
            return Ok(None);
        }
        let mut larger = Self::new();
        larger.resize(device, count + count / 4)?;
        let former = std::mem::replace(self, larger);
        Ok(former.memory.map(|memory| (memory, former.room)))
    }

    /// Where the numbers are; 0 if there are none.
    pub(crate) fn address(&self, device: &impl Device<Memory = M>) -> Address {
        self.memory.as_ref().map_or(0, |memory| device.address(memory))
    }

    /// The memory; `None` if there are no numbers.
    pub(crate) fn memory(&self) -> Option<&M> {
        self.memory.as_ref()
    }

    /// The memory, which somebody else frees.
    pub(crate) fn into_memory(self) -> Option<M> {
        self.memory
    }

    /// Copies numbers to the device.
    pub(crate) fn write(
        &mut self,
        device: &impl Device<Memory = M>,
        numbers: &[T],
    ) -> Result<Address, GpuError> {
        let address = self.resize(device, numbers.len())?;
        if let Some(memory) = self.memory.as_mut().filter(|_| !numbers.is_empty()) {
            device.write(memory, bytemuck::cast_slice(numbers))?;
        }
        Ok(address)
    }

    /// Copies numbers to the device; none leave no array, whose address is 0.
    pub(crate) fn write_some(
        &mut self,
        device: &impl Device<Memory = M>,
        numbers: &[T],
    ) -> Result<(), GpuError> {
        if numbers.is_empty() {
            *self = Self::new();
            return Ok(());
        }
        self.write(device, numbers).map(|_| ())
    }

    /// Copies numbers from a place of the array.
    pub(crate) fn read(
        &self,
        device: &impl Device<Memory = M>,
        first: usize,
        numbers: &mut [T],
    ) -> Result<(), GpuError> {
        if numbers.is_empty() {
            return Ok(());
        }
        let memory = self.memory.as_ref().filter(|_| first + numbers.len() <= self.room);
        let memory = memory.expect("the array has these numbers");
        device.read(memory, first * size_of::<T>(), bytemuck::cast_slice_mut(numbers))
    }

    /// The first numbers of the array.
    pub(crate) fn to_vec(&self, device: &impl Device<Memory = M>, count: usize) -> Result<Vec<T>, GpuError> {
        let mut numbers = Vec::new();
        let bytes = count.saturating_mul(size_of::<T>());
        numbers.try_reserve_exact(count).map_err(|_| GpuError::OutOfMemory { bytes })?;
        numbers.resize(count, T::zeroed());
        self.read(device, 0, &mut numbers)?;
        Ok(numbers)
    }
}
