//! A device that computes nothing and counts the memory that is asked for: the memory of a run before it.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use fdem_simulation::{Accelerator, Element, ModelError, Simulation};

use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::Kernel;
use crate::solid::DeviceSolid;

/// The memory that a run takes on a device when it is put there, bytes. No device is needed: the run is
/// handed over to one that only counts, by the code that hands it over to a graphics processor. It is on the
/// processor after that.
///
/// Small lists that steps make, such as those of loaded nodes, are not in it, nor is the memory of the
/// driver.
///
/// # Errors
/// [`ModelError::OnDevice`] for runs that no device computes, as
/// [`put_on`](fdem_simulation::Simulation::put_on) has it.
pub fn memory_of<const D: usize, const N: usize>(run: &mut Simulation<D, N>) -> Result<usize, ModelError>
where
    [[f64; D]; N]: Element<D, N>,
    DeviceSolid<Tally, D, N>: Accelerator<D, N>,
{
    let tally = Tally::default();
    run.put_on(Box::new(DeviceSolid::new(Arc::new(tally.clone()))))?;
    let bytes = tally.bytes();
    run.take_back();
    Ok(bytes)
}

/// A device that has no memory and computes nothing. It counts the bytes that are allocated and not yet
/// freed.
#[derive(Clone, Debug, Default)]
pub struct Tally(Arc<AtomicUsize>);

impl Tally {
    /// Bytes that are allocated now.
    pub fn bytes(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }
}

/// Memory that is counted, and not there.
#[derive(Debug)]
pub struct TallyMemory {
    bytes: usize,
    tally: Arc<AtomicUsize>,
}

impl Drop for TallyMemory {
    fn drop(&mut self) {
        self.tally.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Device for Tally {
    type Memory = TallyMemory;

    fn allocate(&self, bytes: usize) -> Result<TallyMemory, GpuError> {
        self.0.fetch_add(bytes, Ordering::Relaxed);
        Ok(TallyMemory { bytes, tally: Arc::clone(&self.0) })
    }

    fn address(&self, _: &TallyMemory) -> u64 {
        0
    }

    fn bytes(&self, memory: &TallyMemory) -> usize {
        memory.bytes
    }

    fn write(&self, _: &mut TallyMemory, _: &[u8]) -> Result<(), GpuError> {
        Ok(())
    }

    fn read(&self, _: &TallyMemory, _: usize, bytes: &mut [u8]) -> Result<(), GpuError> {
        bytes.fill(0);
        Ok(())
    }

    fn launch(&self, _: Kernel, _: u32, _: &[u64]) -> Result<(), GpuError> {
        Ok(())
    }
}
