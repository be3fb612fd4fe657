//! Neighbour lists: the couples in compressed sparse rows, with distances.

use bytemuck::Pod;
use fdem_contact::{Csr, Elements, Error, Real};

use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Kernel, ListEntryArguments, ListKeyArguments, ListStartArguments};
use crate::primitives::launch;
use crate::rows::{DeviceRows, input};
use crate::sorted::{SortedRows, bits};

impl<D: Device, T: Real + Pod, const N: usize> DeviceRows<'_, D, T, N> {
    /// The neighbours of each element that have a larger number, ascending, and their distances: the arrays
    /// of [`Csr::fill_half_with`] with the root of [`Elements::distance_squared`], to the bit.
    ///
    /// # Cost
    /// Two lists of 12 bytes for each entry on the device, and the entries: 4 bytes and a distance.
    ///
    /// # Errors
    /// [`Error::Device`], as a search for couples returns it.
    pub fn find_half(&mut self, elements: &Elements<'_, T, N>) -> Result<Csr<T>, Error> {
        Ok(self.neighbours(elements, 1)?)
    }

    /// The same with each couple in both of its rows, as [`Csr::fill_full_with`] has them.
    ///
    /// # Errors
    /// [`Error::Device`], as a search for couples returns it.
    pub fn find_full(&mut self, elements: &Elements<'_, T, N>) -> Result<Csr<T>, Error> {
        Ok(self.neighbours(elements, 2)?)
    }

    /// The rows with a number of entries for each couple.
    fn neighbours(&mut self, elements: &Elements<'_, T, N>, each: usize) -> Result<Csr<T>, GpuError> {
        let (device, n) = (self.device, elements.len());
        let none = || Csr::from_arrays(vec![0; n + 1], Vec::new(), Vec::new());
        let Some(input) = input(elements)? else { return Ok(none()) };
        let places = self.elements.give(device, input.points, input.radii)?;
        let couple_count = self.listed(places, &input)?;
        if couple_count == 0 {
            return Ok(none());
        }
        let entries = couple_count.checked_mul(each).ok_or(GpuError::OutOfMemory { bytes: usize::MAX })?;
        let bits = bits(n as u64);
        let (keys, ids) = self.elements.sort.resize(device, entries)?;
        let couples = self.couples.address(device);
        let (couple_count, count) = (couple_count as u64, entries as u64);
        let arguments = ListKeyArguments { couples, keys, ids, couple_count, count, bits, unused: 0 };
        launch(device, Kernel::ListKeys, entries, &arguments)?;
        self.elements.sort.sort(device, entries, 2 * bits)?;

        let keys = self.elements.sort.arrays(device).0;
        let starts = self.row_starts.resize(device, n + 1)?;
        let arguments =
            ListStartArguments { keys, starts, entries: count, count: n as u64 + 1, bits, unused: 0 };
        launch(device, Kernel::ListStarts, n + 1, &arguments)?;
        let arguments = ListEntryArguments {
            keys,
            points: places.points,
            neighbours: self.entries.resize(device, entries)?,
            distances: self.distances.resize(device, entries)?,
            count,
            bits,
            dimensions: N as u32,
            single: SortedRows::<D::Memory, T, N>::SINGLE,
            unused: 0,
        };
        launch(device, Kernel::ListEntries, entries, &arguments)?;
        let offsets = self.row_starts.to_vec(device, n + 1)?.into_iter().map(|start| start as usize);
        Ok(Csr::from_arrays(
            offsets.collect(),
            self.entries.to_vec(device, entries)?,
            self.distances.to_vec(device, entries)?,
        ))
    }
}
