//! Where a run is computed: on the threads of the processor, or on a device.

use crate::accelerator::Accelerator;
use crate::error::{ModelError, Stop};
use crate::machine::list::Machines;
use crate::machine::on_device::OnDevice;
use crate::simulation::run::Simulation;

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Machines<D, N>,
{
    /// Puts the run on a device, which computes the elements, joints, contacts, supports and the motion of
    /// the nodes from the next step on; the processor computes all else. Results are the same to the last
    /// bit. A step copies the positions of elements that can touch where couples of these are searched, and
    /// all columns where more than 1 % of the facets fail. Where fewer fail, or joints begin to soften or
    /// break, it copies the values around these.
    ///
    /// # Errors
    /// [`ModelError::OnDevice`] if the device has too little memory or fails, and for a part of a run on many
    /// ranks. The run stays where it is then.
    pub fn put_on(&mut self, device: Box<dyn Accelerator<D, N>>) -> Result<(), ModelError> {
        let refused = |why: &str| Err(ModelError::OnDevice { why: why.to_owned() });
        let columns = self.machine.columns();
        if self.part.is_some() {
            return refused("a device computes whole runs only, and no part of one");
        }
        let holds = self.actions.prescribed.on_device(&self.model, &columns.solid);
        let machine = OnDevice::new(device, columns.clone(), holds, self.team.clone());
        match machine {
            Ok(machine) => self.machine = Box::new(machine),
            Err(error) => return refused(&error.to_string()),
        }
        Ok(())
    }

    /// Continues with a run that has the state of this one, such as that of the next stage. The times and the
    /// number of detections count from the beginning of this one, and a law of the caller for spheres stays.
    /// A run on a device stays there, in the memory that this one has taken.
    ///
    /// # Errors
    /// The errors of [`Self::put_on`] if this run is on a device; the new one is on the processor then.
    pub fn replace(&mut self, mut with: Self) -> Result<(), ModelError> {
        with.go_on(self.timings(), self.counts().detections);
        with.actions.spheres.keep_law(&mut self.actions.spheres);
        self.stand_in(with)
    }

    /// Continues as another run, which is on the processor, where this one is.
    pub(super) fn stand_in(&mut self, with: Self) -> Result<(), ModelError> {
        let before = std::mem::replace(self, with);
        before.machine.into_device().map_or(Ok(()), |device| self.put_on(device))
    }

    /// Reads all values of a run from its device, so that functions that look at them do not read any.
    /// Nothing without a device.
    ///
    /// # Errors
    /// [`Stop::Device`] if the device has failed.
    pub fn settle(&self) -> Result<(), Stop> {
        self.machine.columns();
        self.check_device()
    }

    /// Whether the device of the run, if it has one, has computed all steps and returned all values that have
    /// been read so far.
    ///
    /// # Errors
    /// [`Stop::Device`] if it has failed. Values that have been read since the last step are not those of the
    /// run then.
    pub fn check_device(&self) -> Result<(), Stop> {
        self.machine.check()
    }

    /// Takes the run back from a device to the threads of the processor.
    pub fn take_back(&mut self) {
        let columns = self.machine.columns().clone();
        self.machine = <[[f64; D]; N]>::machine(columns, &self.team);
    }
}
