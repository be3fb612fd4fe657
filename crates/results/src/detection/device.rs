//! The door to a device that searches in place of the processor.

use std::fmt::Debug;

use fdem_contact::{Couple, Elements, Error};

/// A device that searches in place of the processor, such as a graphics processor.
pub trait DeviceSearch: Debug + Sync {
    /// The couples of elements in the plane.
    ///
    /// # Errors
    /// [`Error::Device`].
    fn plane(&self, elements: &Elements<'_, f64, 2>) -> Result<Vec<Couple>, Error>;

    /// The couples of elements in space.
    ///
    /// # Errors
    /// [`Error::Device`].
    fn space(&self, elements: &Elements<'_, f64, 3>) -> Result<Vec<Couple>, Error>;
}
