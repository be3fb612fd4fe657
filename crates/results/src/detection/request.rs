//! Elements and options of a detection.

use fdem_contact::{Elements, Engine, Error, Filter};

use crate::network::Sizes;

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
    /// Number of threads; 0 is one per processor.
    pub threads: usize,
    /// Whether the couples are kept; otherwise only their statistics are.
    pub keep: bool,
}

impl<'a> DetectionRequest<'a> {
    /// Returns the elements.
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
        }?
        .with_tolerance(self.tolerance)?;
        match self.bodies {
            Some(bodies) => elements.with_filter(Filter::bodies(bodies)),
            None => Ok(elements),
        }
    }
}
