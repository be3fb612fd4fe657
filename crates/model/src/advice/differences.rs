//! The advice that differs between models in two and in three dimensions.

use fdem_contact::discretised::MeshElement;

use crate::advice::ready::Ready;
use crate::advice::{connected, locking, warnings};
use crate::bodies::dimensions::Dimensions;
use crate::shapes::placed::Placed;

/// Warnings that differ between the dimensions.
pub(crate) trait Advised<const D: usize, const N: usize>: Dimensions<D, N> + MeshElement<D> {
    /// Warnings of settings that are possible, but probably not meant.
    fn warnings(prepared: &Ready<'_, D, N>) -> Vec<String>;
}

/// Elements of which models are made: triangles in the plane, and tetrahedra in space.
pub trait Modelled<const D: usize, const N: usize>: Advised<D, N> {}

impl<const D: usize, const N: usize, E: Advised<D, N>> Modelled<D, N> for E {}

impl Advised<2, 3> for [[f64; 2]; 3] {
    fn warnings(ready: &Ready<'_, 2, 3>) -> Vec<String> {
        let mut warnings = Vec::new();
        for body in ready.placed.iter().filter(|body| ready.file.body[body.table].mesh.is_some()) {
            connected::warnings(&body.name, &body.piece, &mut warnings);
        }
        locking::warnings(ready.model, ready.placed, &mut warnings);
        warnings.extend(warnings::of_plane(ready));
        warnings
    }
}

impl Advised<3, 4> for [[f64; 3]; 4] {
    fn warnings(ready: &Ready<'_, 3, 4>) -> Vec<String> {
        let mut warnings = Vec::new();
        let has_file = |body: &&Placed<3, 4>| {
            let of = &ready.file.body[body.table];
            of.mesh.is_some() || of.surface.is_some()
        };
        for body in ready.placed.iter().filter(has_file) {
            connected::warnings_in_space(&body.name, &body.piece, &mut warnings);
        }
        locking::warnings_in_space(ready.model, ready.placed, &mut warnings);
        warnings.extend(warnings::of_space(ready));
        warnings
    }
}
