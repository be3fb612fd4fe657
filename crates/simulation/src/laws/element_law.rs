//! The law of a material as elements ask for it.

use crate::lanes::Lanes;
use crate::vector::{Matrix, Point};

/// The answer of a law to the deformation of an element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response<const D: usize> {
    /// First Piola-Kirchhoff stress, Pa.
    pub(crate) stress: Matrix<D>,
    /// Stored energy per undeformed volume, J/m³.
    pub(crate) energy: f64,
    /// Energy dissipated in this step per undeformed volume, J/m³. It is read only if the law
    /// [dissipates](ElementLaw::DISSIPATES).
    pub(crate) dissipated: f64,
    /// The measure of strain of [`ElementLaw::SMALL`].
    pub(crate) strain: f64,
}

/// A constant of a material that its law refuses.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refusal {
    /// Name of the constant.
    pub(crate) what: &'static str,
    pub(crate) value: f64,
    /// Values that are allowed.
    pub(crate) range: &'static str,
}

/// The law of one material, with its constants in the plane or in space.
///
/// The stress is a function of the deformation gradient and of the memory of the element. It has to be the
/// gradient of the stored energy while the memory does not change, and may not depend on the rotation of the
/// element: then the balance of energy holds. A law works on batches of elements (`lanes.rs`): the functions
/// that [`stress_of_small`](Self::stress_of_small) calls are `#[inline(always)]`, and have no branch that
/// depends on the element.
pub(crate) trait ElementLaw<const D: usize, const N: usize>: Copy + Send + Sync + 'static {
    /// Constants of the elements of a batch.
    type Constants: Clone;

    /// Number of values that an element keeps from step to step: its memory, which is saved, and moves
    /// between ranks with the element.
    const MEMORY: usize = 0;
    /// Whether energy is dissipated. It belongs to the term of damping in the balance.
    const DISSIPATES: bool = false;
    /// The measure of strain from which an element is computed again by [`stress`](Self::stress). Infinite
    /// for a law with memory, which changes once a step.
    const SMALL: f64 = f64::INFINITY;

    /// The constants of this law in every lane of a batch.
    fn constants(&self) -> Self::Constants;

    /// Sets the constants of one lane of a batch.
    fn set(&self, constants: &mut Self::Constants, lane: usize);

    /// The response to a deformation gradient without a branch. `j` is the determinant of `f`. `memory` has
    /// [`Self::MEMORY`] values of each element of the batch.
    fn stress_of_small(
        constants: &Self::Constants,
        memory: &mut [Lanes],
        lane: usize,
        f: &Matrix<D>,
        j: f64,
    ) -> Response<D>;

    /// The response to any deformation gradient with a positive determinant.
    #[inline]
    fn stress(
        constants: &Self::Constants,
        memory: &mut [Lanes],
        lane: usize,
        f: &Matrix<D>,
        j: f64,
    ) -> Response<D> {
        Self::stress_of_small(constants, memory, lane, f, j)
    }

    /// Sets the memory of an undeformed element, [`Self::MEMORY`] values.
    fn begin(&self, _memory: &mut [f64]) {}

    /// Energy density, J/m³, that an initial stress has stored by Hooke's law: `σ:C⁻¹:σ / 2`.
    fn stored(&self, stress: &Matrix<D>) -> f64;

    /// Stress out of the plane, Pa, that belongs to this Cauchy stress in the plane. Not read in space.
    fn out_of_plane(&self, stress: &Matrix<D>, memory: &[f64]) -> f64;

    /// Square of the highest angular frequency of a free element, 1/s²: the largest ratio of its stiffness to
    /// its lumped mass, or a bound above it.
    fn highest_square(&self, shape: &[Point<D>; N], density: f64) -> f64;

    /// Moduli of the compressional and of the shear wave that travel along a direction of unit length, Pa:
    /// density times the square of the speed.
    fn wave_moduli(&self, direction: Point<D>) -> [f64; 2];
}
