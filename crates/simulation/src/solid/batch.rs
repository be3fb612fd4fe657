//! The deformation of elements, a batch of them side by side.
//!
//! [`strain_one`] is the definition: the stress and the forces of one element of a batch. Its only branch is on what is the same for a whole batch, so that the compiler makes vectors of
//! the loop over a batch: one for each set of instructions, chosen at run time. All of them do the same operations on each element, so that the bits are the same.

#![allow(unsafe_code, reason = "functions that are compiled for vector instructions")]
#![allow(clippy::inline_always, reason = "what a batch calls must be compiled for the same instructions")]

use fdem_contact::Simd;

use crate::elastic::viscous_stress;
use crate::simplex::Simplex;
use crate::vector::{Matrix, Point, contraction, matrix, product, product_transposed, symmetric, transposed};

/// Number of elements in a batch: two vectors of the widest kind.
pub(crate) const LANES: usize = 16;

/// A number of each element of a batch.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes([f64; LANES]);

impl Lanes {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }
}

/// A tensor of each element of a batch.
pub(crate) type Tensors<const D: usize> = [[Lanes; D]; D];

/// The tensor of one element.
#[inline(always)]
pub(crate) fn tensor<const D: usize>(of: &Tensors<D>, lane: usize) -> Matrix<D> {
    matrix(|i, k| of[i][k].get(lane))
}

#[inline(always)]
pub(crate) fn set_tensor<const D: usize>(of: &mut Tensors<D>, lane: usize, value: &Matrix<D>) {
    for i in 0..D {
        for k in 0..D {
            of[i][k].set(lane, value[i][k]);
        }
    }
}

/// The undeformed elements of a batch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Undeformed<const D: usize> {
    /// Inverses of the matrices whose columns are the edges from corner 0, 1/m.
    pub(crate) gradients: Tensors<D>,
    /// Volumes, m³: in two dimensions areas times thickness.
    pub(crate) volume: Lanes,
}

impl<const D: usize> Undeformed<D> {
    /// Elements of volume 1 without a shape.
    pub(crate) const EMPTY: Self = Self { gradients: [[Lanes::ZERO; D]; D], volume: Lanes([1.0; LANES]) };
}

/// Results of the deformation of a batch that are kept.
#[derive(Clone, Debug)]
pub(crate) struct Deformed<const D: usize> {
    /// Cauchy stress, Pa. It is symmetric; what is below the diagonal is not used.
    stress: Tensors<D>,
    /// Strain energy, J.
    pub(crate) energy: Lanes,
}

impl<const D: usize> Deformed<D> {
    pub(crate) const NONE: Self = Self { stress: [[Lanes::ZERO; D]; D], energy: Lanes::ZERO };

    #[inline(always)]
    pub(crate) fn stress(&self, lane: usize) -> Matrix<D> {
        matrix(|i, k| self.stress[i.min(k)][i.max(k)].get(lane))
    }

    #[inline(always)]
    pub(crate) fn set_stress(&mut self, lane: usize, stress: &Matrix<D>) {
        for i in 0..D {
            for k in i..D {
                self.stress[i][k].set(lane, stress[i][k]);
            }
        }
    }
}

/// What the deformation of a batch depends on besides, in this step.
#[derive(Clone, Debug)]
pub(crate) struct Given<const D: usize> {
    /// Matrices whose columns are the edges from corner 0, m.
    pub(crate) edges: Tensors<D>,
    /// Moduli, Pa.
    pub(crate) shear: Lanes,
    pub(crate) bulk: Lanes,
    /// Initial stress (second Piola-Kirchhoff), Pa, and the energy that it has stored, J/m³; not read without initial stress.
    pub(crate) initial: Tensors<D>,
    pub(crate) stored: Lanes,
    /// Differences of velocities from that of corner 0, m/s, and viscosities, Pa s; not read without viscosity.
    pub(crate) rates: Tensors<D>,
    pub(crate) viscosity: Lanes,
}

impl<const D: usize> Given<D> {
    pub(crate) const NONE: Self = Self {
        edges: [[Lanes::ZERO; D]; D],
        shear: Lanes::ZERO,
        bulk: Lanes::ZERO,
        initial: [[Lanes::ZERO; D]; D],
        stored: Lanes::ZERO,
        rates: [[Lanes::ZERO; D]; D],
        viscosity: Lanes::ZERO,
    };
}

/// Results of the deformation of a batch that are used at once.
#[derive(Clone, Debug)]
pub(crate) struct Told<const D: usize, const N: usize> {
    /// Forces on the corners, N.
    forces: [[Lanes; D]; N],
    /// Deformed over undeformed volume.
    pub(crate) ratio: Lanes,
    /// Power of the last viscous stress and of the new one together, over the volume, W/m³; not written without viscosity.
    pub(crate) power: Lanes,
    /// The measure of strain of [`Simplex::stress_of_small`].
    strain: Lanes,
}

impl<const D: usize, const N: usize> Told<D, N> {
    pub(crate) const NONE: Self =
        Self { forces: [[Lanes::ZERO; D]; N], ratio: Lanes::ZERO, power: Lanes::ZERO, strain: Lanes::ZERO };

    /// Forces on the corners of an element, N.
    #[inline]
    pub(crate) fn forces(&self, lane: usize) -> [Point<D>; N] {
        std::array::from_fn(|corner| std::array::from_fn(|axis| self.forces[corner][axis].get(lane)))
    }
}

/// Forces on the corners of an element of a stress (first Piola-Kirchhoff), N.
#[inline(always)]
pub(crate) fn forces_of<const D: usize, const N: usize>(
    stress: &Matrix<D>,
    gradients: &Matrix<D>,
    volume: f64,
) -> [Point<D>; N] {
    let on = product_transposed(stress, gradients).map(|row| row.map(|f| -volume * f));
    let mut forces = [[0.0; D]; N];
    for axis in 0..D {
        forces[0][axis] = -on[axis][0];
        forces[1][axis] = on[axis][0];
        for k in 1..D {
            forces[0][axis] -= on[axis][k];
            forces[k + 1][axis] = on[axis][k];
        }
    }
    forces
}

/// Computes one element of a batch. `ANY` strain, or only small ones.
#[inline(always)]
fn strain_one<const D: usize, const N: usize, const INITIAL: bool, const VISCOUS: bool, const ANY: bool>(
    lane: usize,
    undeformed: &Undeformed<D>,
    given: &Given<D>,
    deformed: &mut Deformed<D>,
    viscous: &mut Tensors<D>,
    told: &mut Told<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let gradients = tensor(&undeformed.gradients, lane);
    let volume = undeformed.volume.get(lane);
    let gradient = product(&tensor(&given.edges, lane), &gradients);
    let j = <[[f64; D]; N]>::determinant(&gradient);
    let moduli = [given.shear.get(lane), given.bulk.get(lane)];
    let (mut stress, mut energy) = if ANY {
        <[[f64; D]; N]>::stress(moduli, &gradient, j)
    } else {
        let (stress, energy, strain) = <[[f64; D]; N]>::stress_of_small(moduli, &gradient, j);
        told.strain.set(lane, strain);
        (stress, energy)
    };
    if INITIAL {
        let initial = tensor(&given.initial, lane);
        let first = product(&gradient, &initial);
        stress = matrix(|i, k| stress[i][k] + first[i][k]);
        let across = transposed(&gradient);
        let mut strain = product_transposed(&across, &across);
        for axis in 0..D {
            strain[axis][axis] -= 1.0;
        }
        energy += given.stored.get(lane) + 0.5 * contraction(&initial, &strain);
    }
    if VISCOUS {
        let rate = product(&tensor(&given.rates, lane), &gradients);
        let viscosity = given.viscosity.get(lane);
        let before = tensor(viscous, lane);
        let now = viscous_stress::<D, N>(viscosity, &gradient, j, &rate);
        told.power.set(lane, contraction(&before, &rate) + contraction(&now, &rate));
        // In one material there may be none.
        set_tensor(viscous, lane, &matrix(|i, k| if viscosity > 0.0 { now[i][k] } else { before[i][k] }));
        stress = matrix(|i, k| if viscosity > 0.0 { stress[i][k] + now[i][k] } else { stress[i][k] });
    }
    told.ratio.set(lane, j);
    deformed.energy.set(lane, energy * volume);
    let cauchy = symmetric(&product_transposed(&stress, &gradient));
    deformed.set_stress(lane, &cauchy.map(|row| row.map(|x| x / j)));
    let forces: [Point<D>; N] = forces_of(&stress, &gradients, volume);
    for corner in 0..N {
        for axis in 0..D {
            told.forces[corner][axis].set(lane, forces[corner][axis]);
        }
    }
}

/// Computes a batch.
#[inline(always)]
fn strain_all<const D: usize, const N: usize, const INITIAL: bool, const VISCOUS: bool>(
    undeformed: &Undeformed<D>,
    given: &Given<D>,
    deformed: &mut Deformed<D>,
    viscous: &mut Tensors<D>,
    told: &mut Told<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        strain_one::<D, N, INITIAL, VISCOUS, false>(lane, undeformed, given, deformed, viscous, told);
    }
}

/// Defines [`strain_all`] for a set of instructions.
#[allow(unused_macros, reason = "only processors with such a set use it")]
macro_rules! compiled_for {
    ($features:literal, $name:ident) => {
        /// [`strain_all`], compiled for these instructions.
        #[target_feature(enable = $features)]
        fn $name<const D: usize, const N: usize, const INITIAL: bool, const VISCOUS: bool>(
            undeformed: &Undeformed<D>,
            given: &Given<D>,
            deformed: &mut Deformed<D>,
            viscous: &mut Tensors<D>,
            told: &mut Told<D, N>,
        ) where
            [[f64; D]; N]: Simplex<D, N>,
        {
            strain_all::<D, N, INITIAL, VISCOUS>(undeformed, given, deformed, viscous, told);
        }
    };
}

#[cfg(target_arch = "x86_64")]
compiled_for!("avx2", avx2);
#[cfg(target_arch = "x86_64")]
compiled_for!("avx512f,avx512vl", avx512);

/// Computes the elements of a batch. `simd`: a set of instructions that the processor has, see [`Simd::available`].
#[inline]
pub(crate) fn strain<const D: usize, const N: usize, const INITIAL: bool, const VISCOUS: bool>(
    simd: Available,
    undeformed: &Undeformed<D>,
    given: &Given<D>,
    deformed: &mut Deformed<D>,
    viscous: &mut Tensors<D>,
    told: &mut Told<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    match simd.0 {
        // SAFETY: this processor has the instructions, or there were no `Available`.
        #[cfg(target_arch = "x86_64")]
        Simd::Avx512 => unsafe {
            avx512::<D, N, INITIAL, VISCOUS>(undeformed, given, deformed, viscous, told)
        },
        // SAFETY: likewise.
        #[cfg(target_arch = "x86_64")]
        Simd::Avx2 => unsafe { avx2::<D, N, INITIAL, VISCOUS>(undeformed, given, deformed, viscous, told) },
        _ => strain_all::<D, N, INITIAL, VISCOUS>(undeformed, given, deformed, viscous, told),
    }
    for lane in 0..LANES {
        if told.strain.get(lane) >= <[[f64; D]; N]>::SMALL {
            strain_one::<D, N, INITIAL, VISCOUS, true>(lane, undeformed, given, deformed, viscous, told);
        }
    }
}

/// A set of vector instructions that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Available(Simd);

impl Available {
    /// This set, if the processor has it.
    pub(crate) fn new(simd: Simd) -> Option<Self> {
        simd.is_available().then_some(Self(simd))
    }

    /// The fastest.
    pub(crate) fn best() -> Self {
        Self(Simd::best())
    }
}
