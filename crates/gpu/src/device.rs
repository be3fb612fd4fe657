//! The door to a device: its memory and its kernels.

use crate::error::GpuError;
use crate::kernels::Kernel;

/// A device with a memory of its own, whose kernels run one after the other.
pub trait Device {
    /// Some memory of the device, which is free again when this is dropped.
    type Memory: Send;

    /// Takes memory. Its content is unspecified.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Driver`].
    fn allocate(&self, bytes: usize) -> Result<Self::Memory, GpuError>;

    /// The address by which kernels know the memory.
    fn address(&self, memory: &Self::Memory) -> u64;

    /// Bytes that the memory has.
    fn bytes(&self, memory: &Self::Memory) -> usize;

    /// Copies bytes to the beginning of the memory.
    ///
    /// # Errors
    /// [`GpuError::Driver`].
    ///
    /// # Panics
    /// If the memory is shorter.
    fn write(&self, to: &mut Self::Memory, bytes: &[u8]) -> Result<(), GpuError>;

    /// Copies bytes from a place of the memory, once all kernels before are done.
    ///
    /// # Errors
    /// [`GpuError::Driver`].
    ///
    /// # Panics
    /// If the memory ends before.
    fn read(&self, from: &Self::Memory, offset: usize, bytes: &mut [u8]) -> Result<(), GpuError>;

    /// Starts a kernel on a number of blocks. The arguments are one structure, in words of eight bytes.
    ///
    /// # Errors
    /// [`GpuError::Driver`].
    fn launch(&self, kernel: Kernel, blocks: u32, arguments: &[u64]) -> Result<(), GpuError>;
}
