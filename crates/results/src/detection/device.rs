//! The door to a device that searches in place of the processor.

use std::fmt::Debug;

use fdem_contact::{Couple, Elements, Error, PeriodicBox, PeriodicCouple, PeriodicSearch, Search};

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

/// A kind of search that a device has in the plane and in space.
pub trait SearchOfDevice: Debug + Sync {
    /// The search in D dimensions.
    type In<'d, const D: usize>: Search<f64, D>
    where
        Self: 'd;

    /// A new search.
    fn search<const D: usize>(&self) -> Self::In<'_, D>;
}

impl<S: SearchOfDevice> DeviceSearch for S {
    fn plane(&self, elements: &Elements<'_, f64, 2>) -> Result<Vec<Couple>, Error> {
        open(self, elements)
    }

    fn space(&self, elements: &Elements<'_, f64, 3>) -> Result<Vec<Couple>, Error> {
        open(self, elements)
    }

    fn plane_in_box(
        &self,
        elements: &Elements<'_, f64, 2>,
        cell: &PeriodicBox<f64, 2>,
        images: PeriodicSearch<f64, 2>,
    ) -> Result<Vec<PeriodicCouple<2>>, Error> {
        in_box(self, elements, cell, images)
    }

    fn space_in_box(
        &self,
        elements: &Elements<'_, f64, 3>,
        cell: &PeriodicBox<f64, 3>,
        images: PeriodicSearch<f64, 3>,
    ) -> Result<Vec<PeriodicCouple<3>>, Error> {
        in_box(self, elements, cell, images)
    }
}

fn open<const D: usize>(
    device: &impl SearchOfDevice,
    elements: &Elements<'_, f64, D>,
) -> Result<Vec<Couple>, Error> {
    let mut couples = Vec::new();
    device.search().couples(elements, &mut couples).map(|()| couples)
}

fn in_box<const D: usize>(
    device: &impl SearchOfDevice,
    elements: &Elements<'_, f64, D>,
    cell: &PeriodicBox<f64, D>,
    mut images: PeriodicSearch<f64, D>,
) -> Result<Vec<PeriodicCouple<D>>, Error> {
    let mut couples = Vec::new();
    images.couples_by(&mut device.search(), elements, cell, &mut couples).map(|()| couples)
}
