//! The loss of stiffness of a body that has joints on all facets from the beginning.
//!
//! A joint with the stiffness k opens and slides by T/k under the traction T. Under a uniform stress σ along
//! an axis, the joints of a volume V add the strain
//!
//! ```text
//! ε = σ Σ A (n·e)²/k / V
//! ```
//! with their areas A and normals n. The stiffness is k = p E/h, with h the mean height of the two elements
//! over the facet. An element of the volume v has A h = D v for each of its D + 1 facets, so that Σ A h is
//! D (D + 1) V/2, and the mean of (n·e)² over all directions is 1/D. The body is softer by
//!
//! ```text
//! E'/E'_body = 1 + (D + 1) E'/(2 p E)
//! ```
//! with E' = E in space and in plane stress, and E/(1 - ν²) in plane strain. Neither the size of elements nor
//! the modulus matters, because the stiffness of joints follows both. A test compares this with runs.

use fdem_simulation::{Insertion, Model, Plane};

use crate::advice::deforming;

/// Share by which intrinsic joints lower the modulus of the bodies of a model, at most of all materials;
/// `None` if there are no joints on all facets.
pub(crate) fn softer<const D: usize, const N: usize>(model: &Model<D, N>) -> Option<f64> {
    if model.fracture.insertion != Insertion::Intrinsic {
        return None;
    }
    let all = model.materials.iter().zip(deforming::materials(model));
    let breaks = all.filter(|(material, deforms)| *deforms && material.strength.is_some());
    let of = |poissons_ratio: f64| {
        let stiffer = match model.plane {
            Plane::Strain if D == 2 => 1.0 / (1.0 - poissons_ratio * poissons_ratio),
            _ => 1.0,
        };
        let added = (D + 1) as f64 * stiffer / (2.0 * model.fracture.joint_penalty);
        added / (1.0 + added)
    };
    breaks.map(|(material, _)| of(material.poissons_ratio)).reduce(f64::max)
}
