//! Laws of the material: how the stress and the energy of an element follow from its deformation.
//!
//! A law implements [`ElementLaw`] in a file of its own beside `laws/neo_hookean.rs`. Here is the list of all
//! laws: a variant of [`MaterialLaw`] with the constants that a model gives, a variant of [`AnyLaw`] with
//! their form for elements, and an arm of [`with_law`]. `solid.rs` makes batches of elements by their law, so
//! that each law has a kernel of its own.
//!
//! An element under initial stress `S` (second Piola-Kirchhoff) has the energy
//!
//! ```text
//! U = σ:C⁻¹:σ / 2 + S:E + W,    E = (FᵀF - 1)/2,    σ = S at the beginning.
//! ```
//! Its gradient is `P = F S + ∂W/∂F`: the initial stress, which turns with the element, and the stress of the
//! deformation. The first term of `U` is the energy that the stress stored by Hooke's law before the run.
//! With this term, `U` is `(ε₀ + E):C:(ε₀ + E) / 2` to second order in the strains, with `ε₀ = C⁻¹:σ`. It is
//! positive, and 0 where the element has lost all of its stress.

mod element_law;
mod neo_hookean;
#[cfg(test)]
pub(crate) mod tests;
mod transversely_isotropic;

use serde::{Deserialize, Serialize};

pub(crate) use crate::laws::element_law::{ElementLaw, Refusal};
pub(crate) use crate::laws::transversely_isotropic::Bedded;
pub use crate::laws::transversely_isotropic::Bedding;
use crate::moduli::{Moduli, Plane};
use crate::simplex::Simplex;
use crate::strength::Strength;
use crate::vector::{Matrix, Point};

/// The law of a material: how the stress in an element follows from its deformation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum MaterialLaw {
    /// Isotropic elasticity: the neo-Hookean energy of Young's modulus and Poisson's ratio.
    #[default]
    NeoHookean,
    /// Transversely isotropic elasticity: Young's modulus and Poisson's ratio are those in the plane of the
    /// bedding.
    TransverselyIsotropic(Bedding),
}

impl MaterialLaw {
    /// The law in elements of a material with this Young's modulus, Pa, and Poisson's ratio.
    pub(crate) fn in_elements<const D: usize, const N: usize>(
        &self,
        youngs_modulus: f64,
        poissons_ratio: f64,
        plane: Plane,
    ) -> AnyLaw<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        match self {
            Self::NeoHookean => {
                AnyLaw::NeoHookean(<[[f64; D]; N]>::moduli(youngs_modulus, poissons_ratio, plane))
            }
            Self::TransverselyIsotropic(bedding) => {
                let plate = <[[f64; D]; N]>::is_plate(plane);
                AnyLaw::Bedded(bedding.in_elements(youngs_modulus, poissons_ratio, plate))
            }
        }
    }

    /// Checks the constants, of which Young's modulus is positive.
    pub(crate) fn check<const D: usize, const N: usize>(
        &self,
        youngs_modulus: f64,
        poissons_ratio: f64,
        plane: Plane,
    ) -> Result<(), Refusal>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        match self {
            Self::NeoHookean => neo_hookean::check::<D, N>(poissons_ratio, plane),
            Self::TransverselyIsotropic(bedding) => bedding.check(D, youngs_modulus, poissons_ratio),
        }
    }

    /// Young's modulus, Pa, in the stiffest direction; `youngs_modulus`: that of the material.
    pub(crate) fn stiffest_modulus(&self, youngs_modulus: f64) -> f64 {
        match self {
            Self::NeoHookean => youngs_modulus,
            Self::TransverselyIsotropic(bedding) => youngs_modulus.max(bedding.youngs_modulus),
        }
    }

    /// Poisson's ratio of the isotropic material that is nearest to this one.
    pub(crate) fn mean_poissons_ratio(&self, youngs_modulus: f64, poissons_ratio: f64) -> f64 {
        match self {
            Self::NeoHookean => poissons_ratio,
            Self::TransverselyIsotropic(bedding) => {
                bedding.mean_poissons_ratio(youngs_modulus, poissons_ratio)
            }
        }
    }

    /// The least shear modulus of all planes, Pa.
    pub(crate) fn least_shear_modulus(&self, youngs_modulus: f64, poissons_ratio: f64) -> f64 {
        let own = youngs_modulus / (2.0 * (1.0 + poissons_ratio));
        match self {
            Self::NeoHookean => own,
            Self::TransverselyIsotropic(bedding) => own.min(bedding.shear_modulus),
        }
    }

    /// Whether strengths depend on the direction of a facet.
    pub(crate) fn has_directions(&self) -> bool {
        match self {
            Self::NeoHookean => false,
            Self::TransverselyIsotropic(bedding) => bedding.strength.is_some(),
        }
    }

    /// Strength of a facet with this normal of unit length in the undeformed body; `strength`: that of the
    /// material.
    pub(crate) fn strength_on<const D: usize>(&self, strength: Strength, normal: Point<D>) -> Strength {
        match self {
            Self::NeoHookean => strength,
            Self::TransverselyIsotropic(bedding) => bedding.strength_on(strength, normal),
        }
    }
}

/// The law of a material in the plane or in space, with the constants that elements need.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnyLaw<const D: usize> {
    NeoHookean(Moduli),
    Bedded(Bedded<D>),
}

/// Does something with the law of its own type that [`AnyLaw`] has.
macro_rules! with_law {
    ($any:expr, $law:ident => $result:expr) => {
        match $any {
            $crate::laws::AnyLaw::NeoHookean($law) => $result,
            $crate::laws::AnyLaw::Bedded($law) => $result,
        }
    };
}
pub(crate) use with_law;

impl<const D: usize> AnyLaw<D> {
    /// The law, if it is one of this type.
    #[inline]
    pub(crate) fn as_one<L: 'static>(&self) -> Option<&L> {
        with_law!(self, law => (law as &dyn std::any::Any).downcast_ref())
    }

    /// Number of values that an element keeps.
    pub(crate) fn memory<const N: usize>(&self) -> usize
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        fn of<const D: usize, const N: usize, L: ElementLaw<D, N>>(_: &L) -> usize {
            L::MEMORY
        }
        with_law!(self, law => of::<D, N, _>(law))
    }

    /// Whether energy is dissipated.
    pub(crate) fn dissipates<const N: usize>(&self) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        fn of<const D: usize, const N: usize, L: ElementLaw<D, N>>(_: &L) -> bool {
            L::DISSIPATES
        }
        with_law!(self, law => of::<D, N, _>(law))
    }

    /// See [`ElementLaw::begin`].
    pub(crate) fn begin<const N: usize>(&self, memory: &mut [f64])
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        with_law!(self, law => ElementLaw::<D, N>::begin(law, memory));
    }

    /// See [`ElementLaw::stored`].
    pub(crate) fn stored<const N: usize>(&self, stress: &Matrix<D>) -> f64
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        with_law!(self, law => ElementLaw::<D, N>::stored(law, stress))
    }

    /// A Cauchy stress as the components `[xx, yy, zz, xy, yz, xz]`, Pa.
    pub(crate) fn in_tensor<const N: usize>(&self, stress: &Matrix<D>, memory: &[f64]) -> [f64; 6]
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let out_of_plane = with_law!(self, law => ElementLaw::<D, N>::out_of_plane(law, stress, memory));
        <[[f64; D]; N]>::in_tensor(stress, out_of_plane)
    }

    /// See [`ElementLaw::highest_square`].
    pub(crate) fn highest_square<const N: usize>(&self, shape: &[Point<D>; N], density: f64) -> f64
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        with_law!(self, law => ElementLaw::<D, N>::highest_square(law, shape, density))
    }

    /// See [`ElementLaw::wave_moduli`].
    pub(crate) fn wave_moduli<const N: usize>(&self, direction: Point<D>) -> [f64; 2]
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        with_law!(self, law => ElementLaw::<D, N>::wave_moduli(law, direction))
    }
}
