//! Traction-separation law of the joint between two elements.
//!
//! Combined single and smeared crack model (book, ch. 7): elastic up to the strength, then softening by z(D)
//! (7.12). In the book opening and sliding soften separately. Then a joint at an angle to a crack, which
//! opens and slides together, holds more and costs more than one across it, and a crack along the edges of an
//! unstructured mesh costs up to half more than its fracture energy. Here a joint softens as a whole.
//!
//! # The bond
//! A joint that opens has a traction along the vector of its opening `g` and sliding `s`. With ω the angle
//! between that vector and the normal of the plane that the joint represents, its own or one near it
//! (`joints/plane.rs`), its strength and the energy of its unit of area are
//!
//! ```text
//! 1/S² = cos²ω/f_t² + sin²ω/c²,    G = G_I cos ω + G_II sin⁸ω,
//! ```
//! and its traction is S z(D), with D the length of the vector beyond the elastic range over the value at
//! which G is dissipated. For a vector at an angle to the joint the energy is that of the area across the
//! vector: such a joint is a piece of the staircase that represents a crack across the vector. The exponent
//! keeps this up to some 45°; beyond, sliding takes over. A bond unloads towards the origin, and its
//! stiffness only ever falls, so that it dissipates energy on every path.
//!
//! # Pressure
//! In compression only sliding loads the bond, and friction adds to it. A whole joint holds `c + σₙ tan φ`;
//! one that softens has the bond, `z(D) c`, and beside it a spring of friction, at most `σₙ tan φ`, with the
//! stiffness that the bond has lost. Sliding without opening therefore peaks at c + σₙ tan φ and ends at σₙ
//! tan φ. Compression does not break a joint, and a broken joint still transmits pressure and friction.
//!
//! # Joint sets
//! A joint of a set may have a shear stiffness `k_s` other than its normal stiffness `k_n`, and a residual
//! friction. With `r = √(k_s/k_n)`, the law above is that of the sliding `r s` and of the tangential traction
//! `τ/r`, whose product is the same work: with this change of variables the stiffness is `k_n` in all
//! directions, and strengths and energies are as given. The coefficient of friction falls from its peak to
//! the residual one by z(D).
//!
//! # Sources
//! A. Munjiza, The Combined Finite-Discrete Element Method (2004), ch. 7, for the softening; P. P. Camanho,
//! C. G. Dávila, M. F. de Moura, J. Compos. Mater. 37 (2003) 1415-1438, for one damage of a vector with a
//! strength and an energy for each of its directions; G. Alfano, E. Sacco, Int. J. Numer. Meth. Eng. 68
//! (2006) 542-582, for friction beside a bond.

mod curve;
mod law;
mod memory;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use curve::dissipated_at;
pub(crate) use law::{JointLaw, JointPlane, TooLittle, across, use_of, use_of_both};
pub(crate) use memory::Memory;
