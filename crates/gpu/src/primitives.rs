//! Sums and sorts on a device.

use bytemuck::{Pod, bytes_of, cast_slice};
use fdem_simulation::{DeviceSum, SUM_PARTS};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{
    Address, DIGIT_BITS, ExactSumArguments, Kernel, SCANNED, SORTED, ScanArguments, SortArguments, THREADS,
};

/// Starts a kernel with one thread for each of `count` numbers.
pub(crate) fn launch(
    device: &impl Device,
    kernel: Kernel,
    count: usize,
    arguments: &impl Pod,
) -> Result<(), GpuError> {
    launch_blocks(device, kernel, count.div_ceil(THREADS), arguments)
}

/// Starts a kernel on a number of blocks.
pub(crate) fn launch_blocks(
    device: &impl Device,
    kernel: Kernel,
    blocks: usize,
    arguments: &impl Pod,
) -> Result<(), GpuError> {
    if blocks == 0 {
        return Ok(());
    }
    // Structures of arguments have addresses, so they consist of whole words.
    device.launch(kernel, blocks as u32, cast_slice(bytes_of(arguments)))
}

/// Blocks that add up a row of numbers exactly.
pub(crate) fn pieces(count: usize) -> usize {
    count.div_ceil(THREADS).clamp(1, 256)
}

/// Adds up rows of numbers exactly, and writes the parts of the sums of all [`pieces`] of each.
pub(crate) fn add_up(
    device: &impl Device,
    parts: Address,
    rows: usize,
    [numbers, count]: [u64; 2],
) -> Result<(), GpuError> {
    let pieces = pieces(count as usize);
    let arguments = ExactSumArguments { numbers, parts, count, pieces: pieces as u32, unused: 0 };
    launch_blocks(device, Kernel::ExactSums, rows * pieces, &arguments)
}

/// The sums of rows whose pieces have these parts; successive rows belong to one sum.
pub(crate) fn sums_of<const SUMS: usize>(parts: &[u64]) -> [DeviceSum; SUMS] {
    let mut sums = [[0; SUM_PARTS]; SUMS];
    for (sum, pieces) in sums.iter_mut().zip(parts.chunks(parts.len() / SUMS)) {
        for piece in pieces.chunks(SUM_PARTS) {
            sum.iter_mut().zip(piece).for_each(|(sum, part)| *sum += part.cast_signed());
        }
    }
    sums
}

/// Blocks that add up this count of numbers.
fn blocks_of_sums(count: usize) -> usize {
    count.div_ceil(THREADS * SCANNED)
}

/// Sums of all numbers before each.
pub(crate) struct Sums<M> {
    sums: Array<M, u64>,
    before: Array<M, u64>,
}

impl<M> Sums<M> {
    pub(crate) const fn new() -> Self {
        Self { sums: Array::new(), before: Array::new() }
    }

    /// Adds up numbers. Returns where the sums of those before each are.
    pub(crate) fn add_up(
        &mut self,
        device: &impl Device<Memory = M>,
        numbers: Address,
        count: usize,
    ) -> Result<Address, GpuError> {
        let blocks = blocks_of_sums(count);
        let arguments = ScanArguments {
            numbers,
            sums: self.sums.resize(device, blocks + 1)?,
            before: self.before.resize(device, count)?,
            count: count as u64,
            blocks: blocks as u64,
        };
        for (kernel, blocks) in [(Kernel::ScanBlocks, blocks), (Kernel::ScanSums, 1), (Kernel::Scan, blocks)]
        {
            launch_blocks(device, kernel, blocks, &arguments)?;
        }
        Ok(arguments.before)
    }

    /// The sum of all numbers that were added up.
    pub(crate) fn total(&self, device: &impl Device<Memory = M>, count: usize) -> Result<u64, GpuError> {
        let mut total = [0];
        self.sums.read(device, blocks_of_sums(count), &mut total)?;
        Ok(total[0])
    }
}

/// Keys and the numbers of the elements that have them, in two places: a pass of a sort moves them from one
/// to the other.
pub(crate) struct Sort<M> {
    keys: [Array<M, u64>; 2],
    ids: [Array<M, u32>; 2],
    counts: Array<M, u32>,
    sums: Sums<M>,
    /// In which of the two places they are.
    now: usize,
}

impl<M> Sort<M> {
    pub(crate) const fn new() -> Self {
        Self {
            keys: [Array::new(), Array::new()],
            ids: [Array::new(), Array::new()],
            counts: Array::new(),
            sums: Sums::new(),
            now: 0,
        }
    }

    /// Makes room. Returns where keys and numbers are.
    pub(crate) fn resize(
        &mut self,
        device: &impl Device<Memory = M>,
        count: usize,
    ) -> Result<(Address, Address), GpuError> {
        for place in 0..2 {
            self.keys[place].resize(device, count)?;
            self.ids[place].resize(device, count)?;
        }
        Ok(self.arrays(device))
    }

    /// Where keys and numbers are.
    pub(crate) fn arrays(&self, device: &impl Device<Memory = M>) -> (Address, Address) {
        (self.keys[self.now].address(device), self.ids[self.now].address(device))
    }

    /// Where numbers may be written that are to take the place of those that are sorted.
    pub(crate) fn other_ids(&self, device: &impl Device<Memory = M>) -> Address {
        self.ids[1 - self.now].address(device)
    }

    /// Takes the numbers at [`Self::other_ids`].
    pub(crate) fn take_other_ids(&mut self) {
        self.ids.swap(0, 1);
    }

    /// Sorts by the lowest bits of the keys. Equal keys stay in their order.
    pub(crate) fn sort(
        &mut self,
        device: &impl Device<Memory = M>,
        count: usize,
        bits: u32,
    ) -> Result<(), GpuError> {
        let blocks = count.div_ceil(THREADS * SORTED);
        let all = blocks << DIGIT_BITS;
        for shift in (0..bits).step_by(DIGIT_BITS as usize) {
            let [(keys, ids), (sorted_keys, sorted_ids)] = [self.now, 1 - self.now]
                .map(|place| (self.keys[place].address(device), self.ids[place].address(device)));
            let counts = self.counts.resize(device, all)?;
            let mut arguments = SortArguments {
                keys,
                ids,
                sorted_keys,
                sorted_ids,
                counts,
                before: 0,
                count: count as u64,
                blocks: blocks as u32,
                shift,
            };
            launch_blocks(device, Kernel::SortCount, blocks, &arguments)?;
            arguments.before = self.sums.add_up(device, counts, all)?;
            launch_blocks(device, Kernel::SortMove, blocks, &arguments)?;
            self.now = 1 - self.now;
        }
        Ok(())
    }
}
