//! The processor as a device: the text of the kernels, compiled for it.

#![allow(unsafe_code, reason = "kernels are functions in C++")]

use std::cell::Cell;
use std::ffi::c_void;

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

/// Defines where the kernels of a build are.
macro_rules! builds {
    ($($kernel:ident: $ascending:ident, $descending:ident, $contracted:ident;)*) => {
        unsafe extern "C" {
            $(
                fn $ascending(blocks: u32, arguments: *const c_void);
                fn $descending(blocks: u32, arguments: *const c_void);
                fn $contracted(blocks: u32, arguments: *const c_void);
            )*
        }

        fn kernel_of(build: HostBuild, kernel: Kernel) -> HostKernel {
            match kernel {
                $(
                    Kernel::$kernel => match build {
                        HostBuild::Ascending => $ascending,
                        HostBuild::Descending => $descending,
                        HostBuild::Contracted => $contracted,
                    },
                )*
            }
        }
    };
}

builds! {
    ScanBlocks: ascending_scan_blocks, descending_scan_blocks, contracted_scan_blocks;
    ScanSums: ascending_scan_sums, descending_scan_sums, contracted_scan_sums;
    Scan: ascending_scan, descending_scan, contracted_scan;
    SortCount: ascending_sort_count, descending_sort_count, contracted_sort_count;
    SortMove: ascending_sort_move, descending_sort_move, contracted_sort_move;
    RowKeys: ascending_row_keys, descending_row_keys, contracted_row_keys;
    RowRanks: ascending_row_ranks, descending_row_ranks, contracted_row_ranks;
    RowGather: ascending_row_gather, descending_row_gather, contracted_row_gather;
    RowStarts: ascending_row_starts, descending_row_starts, contracted_row_starts;
    RowNeighbours: ascending_row_neighbours, descending_row_neighbours, contracted_row_neighbours;
    CountPairs2: ascending_count_pairs_2, descending_count_pairs_2, contracted_count_pairs_2;
    CountPairs3: ascending_count_pairs_3, descending_count_pairs_3, contracted_count_pairs_3;
    ListPairs2: ascending_list_pairs_2, descending_list_pairs_2, contracted_list_pairs_2;
    ListPairs3: ascending_list_pairs_3, descending_list_pairs_3, contracted_list_pairs_3;
    DeformTriangles: ascending_deform_triangles, descending_deform_triangles, contracted_deform_triangles;
    DeformTetrahedra: ascending_deform_tetrahedra, descending_deform_tetrahedra, contracted_deform_tetrahedra;
    SolidDeform2: ascending_solid_deform_2, descending_solid_deform_2, contracted_solid_deform_2;
    SolidDeform3: ascending_solid_deform_3, descending_solid_deform_3, contracted_solid_deform_3;
    SolidMove2: ascending_solid_move_2, descending_solid_move_2, contracted_solid_move_2;
    SolidMove3: ascending_solid_move_3, descending_solid_move_3, contracted_solid_move_3;
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

    fn launch(&self, kernel: Kernel, blocks: u32, arguments: &[u8]) -> Result<(), GpuError> {
        // Aligned as the structures of C++ are.
        let mut aligned = vec![0_u64; arguments.len().div_ceil(8)];
        bytemuck::cast_slice_mut::<_, u8>(&mut aligned)[..arguments.len()].copy_from_slice(arguments);
        // SAFETY: callers of this crate give each kernel its arguments, whose addresses are those of arrays
        // that they hold, and no other thread has these.
        unsafe { kernel_of(self.0, kernel)(blocks, aligned.as_ptr().cast()) };
        Ok(())
    }
}
