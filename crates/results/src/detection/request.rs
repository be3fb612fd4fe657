//! Elements and options of a detection.

use fdem_contact::{Elements, Engine, Error, Filter, PeriodicCouple};

use crate::detection::device::DeviceSearch;
use crate::network::{Sizes, Space};

/// Elements and options of a detection.
#[derive(Clone, Copy, Debug)]
pub struct DetectionRequest<'a> {
    /// Sizes of the elements.
    pub sizes: Sizes<'a>,
    /// Largest gap that counts as contact, in the unit of the centres.
    pub tolerance: f64,
    /// Body of each element. Elements of the same body form no couple.
    pub bodies: Option<&'a [u32]>,
    /// The engine; `None` to choose one.
    pub engine: Option<Engine>,
    /// A device that searches in place of the processor.
    pub device: Option<&'a dyn DeviceSearch>,
    /// Number of threads; 0 is one per processor.
    pub threads: usize,
    /// Whether the couples are kept; otherwise only their statistics are.
    pub keep: bool,
}

impl<'a> DetectionRequest<'a> {
    /// Returns the elements. Points with cut-offs by pairs touch up to the largest one.
    ///
    /// # Errors
    /// The reason for which the library refuses them.
    pub fn elements<'b, const D: usize>(&self, centres: &'b [[f64; D]]) -> Result<Elements<'b, f64, D>, Error>
    where
        'a: 'b,
    {
        let elements = match self.sizes {
            Sizes::Each(radii) => Elements::spheres_with_radii(centres, radii),
            Sizes::All(radius) => Elements::spheres(centres, radius),
            Sizes::Cutoff(cutoff) => Elements::points(centres, cutoff),
            Sizes::Pairs(cutoffs) => Elements::points(centres, cutoffs.largest()),
        }?
        .with_tolerance(self.tolerance)?;
        let filter = match (self.sizes, self.bodies) {
            (Sizes::Pairs(cutoffs), Some(bodies)) => cutoffs.filter().with_bodies(bodies),
            (Sizes::Pairs(cutoffs), None) => cutoffs.filter(),
            (_, Some(bodies)) => Filter::bodies(bodies),
            (_, None) => return Ok(elements),
        };
        elements.with_filter(filter)
    }

    /// Whether two elements that touch as [`Self::elements`] are a couple: points may be farther apart than
    /// the cut-off of their types, with the tolerance.
    #[inline]
    pub(crate) fn keeps<const D: usize>(&self, space: &Space<'_, D>, couple: PeriodicCouple<D>) -> bool {
        let Sizes::Pairs(cutoffs) = self.sizes else { return true };
        match cutoffs.of(couple.i, couple.j) {
            None => false,
            // The search has compared these.
            Some(cutoff) if cutoff == cutoffs.largest() => true,
            Some(cutoff) => {
                let reach = cutoff + self.tolerance;
                space.distance_squared(couple) <= reach * reach
            }
        }
    }
}
