//! A model that is ready to run, as the warnings look at it.

use fdem_mesh::Quality;
use fdem_simulation::Model;

use crate::prepared::PreparedBody;
use crate::shapes::placed::Placed;
use crate::text::file::ModelFile;

/// A model that is ready to run, with its bodies.
pub(crate) struct Ready<'a, const D: usize, const N: usize> {
    pub(crate) file: &'a ModelFile,
    pub(crate) model: &'a Model<D, N>,
    pub(crate) placed: &'a [Placed<D, N>],
    pub(crate) bodies: &'a [PreparedBody],
    /// Sizes and shapes of the elements of bodies that deform.
    pub(crate) quality: &'a Quality,
}
