//! The processor as a device: the text of the kernels, compiled for it.

#![allow(unsafe_code, reason = "kernels are functions in C++")]

use std::cell::Cell;
use std::ffi::{CString, c_char, c_void};

use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::Kernel;

/// A build of the kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HostBuild {
    /// The threads of a block run in the order of their numbers.
    Ascending,
    /// The threads of a block run in the opposite order.
    Descending,
    /// A product and a sum round once. This must not happen, and tests see that they would find it.
    Contracted,
}

/// The processor, which runs all threads one after the other.
#[derive(Clone, Copy, Debug)]
pub struct Host(pub HostBuild);

/// A kernel for the processor: number of blocks, arguments.
type HostKernel = unsafe extern "C" fn(u32, *const c_void);

unsafe extern "C" {
    fn ascending_kernel(name: *const c_char) -> Option<HostKernel>;
    fn descending_kernel(name: *const c_char) -> Option<HostKernel>;
    fn contracted_kernel(name: *const c_char) -> Option<HostKernel>;
}

impl Device for Host {
    /// In numbers of eight bytes, so that all types are aligned. Cells, because kernels know them by address.
    type Memory = Box<[Cell<u64>]>;

    fn allocate(&self, bytes: usize) -> Result<Self::Memory, GpuError> {
        let mut memory = Vec::new();
        memory.try_reserve_exact(bytes.div_ceil(8)).map_err(|_| GpuError::OutOfMemory { bytes })?;
        // Not zero: a kernel that reads a number before one is written is to be found.
        memory.resize_with(bytes.div_ceil(8), || Cell::new(0xA5A5_A5A5_A5A5_A5A5));
        Ok(memory.into_boxed_slice())
    }

    fn address(&self, memory: &Self::Memory) -> u64 {
        memory.as_ptr() as u64
    }

    fn bytes(&self, memory: &Self::Memory) -> usize {
        size_of_val(&**memory)
    }

    fn write(&self, to: &mut Self::Memory, bytes: &[u8]) -> Result<(), GpuError> {
        for (cell, bytes) in to[..bytes.len().div_ceil(8)].iter().zip(bytes.chunks(8)) {
            let mut word = cell.get().to_ne_bytes();
            word[..bytes.len()].copy_from_slice(bytes);
            cell.set(u64::from_ne_bytes(word));
        }
        Ok(())
    }

    fn read(&self, from: &Self::Memory, offset: usize, bytes: &mut [u8]) -> Result<(), GpuError> {
        for (place, byte) in (offset..).zip(bytes) {
            *byte = from[place / 8].get().to_ne_bytes()[place % 8];
        }
        Ok(())
    }

    fn launch(&self, kernel: Kernel, blocks: u32, arguments: &[u64]) -> Result<(), GpuError> {
        let find = match self.0 {
            HostBuild::Ascending => ascending_kernel,
            HostBuild::Descending => descending_kernel,
            HostBuild::Contracted => contracted_kernel,
        };
        let name = CString::new(kernel.name()).expect("no name of a kernel has a zero");
        // SAFETY: the name ends with a zero.
        let function = unsafe { find(name.as_ptr()) }.expect("every kernel is in every build");
        // SAFETY: callers of this crate give each kernel its arguments, whose addresses are those of arrays
        // that they hold, and no other thread has these.
        unsafe { function(blocks, arguments.as_ptr().cast()) };
        Ok(())
    }
}
