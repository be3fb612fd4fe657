//! The door to a device that searches in place of the processor.

use std::fmt::Debug;

use fdem_contact::{Couple, Elements, Error, PeriodicBox, PeriodicCouple, PeriodicSearch};

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

    /// The couples of elements in a periodic box in the plane. `images` makes the images on the processor.
    ///
    /// # Errors
    /// [`Error::Device`], and those of a periodic box.
    fn plane_in_box(
        &self,
        elements: &Elements<'_, f64, 2>,
        cell: &PeriodicBox<f64, 2>,
        images: PeriodicSearch<f64, 2>,
    ) -> Result<Vec<PeriodicCouple<2>>, Error>;

    /// The couples of elements in a periodic box in space. `images` makes the images on the processor.
    ///
    /// # Errors
    /// [`Error::Device`], and those of a periodic box.
    fn space_in_box(
        &self,
        elements: &Elements<'_, f64, 3>,
        cell: &PeriodicBox<f64, 3>,
        images: PeriodicSearch<f64, 3>,
    ) -> Result<Vec<PeriodicCouple<3>>, Error>;
}
