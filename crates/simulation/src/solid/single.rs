//! The deformation of elements one by one, as other devices compute it: for tests that compare the two.

use crate::accelerator::FlatBedding;
use crate::lanes::{Available, LANES, set_tensor, tensor};
use crate::laws::{Bedded, ElementLaw};
use crate::moduli::Moduli;
use crate::simplex::Simplex;
use crate::solid::batch::{BatchInputs, BatchResults, Deformed, History, Undeformed, strain};
use crate::vector::{Matrix, Point};

/// An element in a step. Tensors by rows.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ElementState<const D: usize> {
    /// Inverse of the matrix whose columns are the edges from corner 0 of the undeformed element, 1/m.
    pub gradients: [[f64; D]; D],
    /// The matrix whose columns are the edges from corner 0, m.
    pub edges: [[f64; D]; D],
    /// Differences of velocities from that of corner 0, m/s.
    pub rates: [[f64; D]; D],
    /// Initial stress (second Piola-Kirchhoff), Pa.
    pub initial: [[f64; D]; D],
    /// Viscous stress (first Piola-Kirchhoff) of the step before, Pa.
    pub viscous: [[f64; D]; D],
    /// Volume of the undeformed element, m³.
    pub volume: f64,
    /// Pa s.
    pub viscosity: f64,
    /// Energy that the initial stress has stored, J/m³.
    pub stored: f64,
    /// Moduli of shear and bulk, Pa.
    pub shear: f64,
    /// See `shear`.
    pub bulk: f64,
    /// The bedding of its material.
    pub bedding: FlatBedding<D>,
}

/// Results of an element in a step.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ElementForces<const D: usize, const N: usize> {
    /// Forces on the corners, N.
    pub forces: [[f64; D]; N],
    /// Cauchy stress, Pa; entries below the diagonal are not used.
    pub stress: [[f64; D]; D],
    /// Viscous stress (first Piola-Kirchhoff), Pa; 0 without viscosity.
    pub viscous: [[f64; D]; D],
    /// Strain energy, J.
    pub energy: f64,
    /// Deformed over undeformed volume.
    pub ratio: f64,
    /// Power of the last viscous stress and of the new one together, W/m³; 0 without viscosity.
    pub power: f64,
    /// Present normal of the bedding; 0 without bedding.
    pub normal: [f64; D],
}

/// Deforms triangles with the neo-Hookean law. `kinds`: with initial stress, with viscosity, with bedding.
pub fn deform_triangles(elements: &[ElementState<2>], kinds: [bool; 3]) -> Vec<ElementForces<2, 3>> {
    deform(elements, kinds)
}

/// Deforms tetrahedra with the neo-Hookean law. `kinds`: with initial stress, with viscosity, with bedding.
pub fn deform_tetrahedra(elements: &[ElementState<3>], kinds: [bool; 3]) -> Vec<ElementForces<3, 4>> {
    deform(elements, kinds)
}

fn deform<const D: usize, const N: usize>(
    elements: &[ElementState<D>],
    [has_initial, is_viscous, is_bedded]: [bool; 3],
) -> Vec<ElementForces<D, N>>
where
    [[f64; D]; N]: Simplex<D, N>,
    Moduli: ElementLaw<D, N>,
{
    let kinds = [has_initial, is_viscous];
    if is_bedded {
        return deform_with(elements, kinds, |of| Bedded::of_flat([of.shear, of.bulk], &of.bedding));
    }
    deform_with(elements, kinds, |of| Moduli { shear: of.shear, bulk: of.bulk, wave: 0.0, out_of_plane: 0.0 })
}

/// [`deform`] with the laws of elements.
fn deform_with<const D: usize, const N: usize, L: ElementLaw<D, N>>(
    elements: &[ElementState<D>],
    kinds: [bool; 2],
    law: impl Fn(&ElementState<D>) -> L,
) -> Vec<ElementForces<D, N>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let batch = match kinds {
        [false, false] => strain::<D, N, false, false, L>,
        [false, true] => strain::<D, N, false, true, L>,
        [true, false] => strain::<D, N, true, false, L>,
        [true, true] => strain::<D, N, true, true, L>,
    };
    let mut all = Vec::with_capacity(elements.len());
    for elements in elements.chunks(LANES) {
        let (mut undeformed, mut given) = (Undeformed::EMPTY, BatchInputs::NONE);
        let (mut deformed, mut history) = (Deformed::NONE, History::new(L::MEMORY));
        let mut results = BatchResults::<D, N>::NONE;
        let mut constants = law(&elements[0]).constants();
        for (lane, of) in elements.iter().enumerate() {
            set_tensor(&mut undeformed.gradients, lane, &of.gradients);
            undeformed.volume.set(lane, of.volume);
            set_tensor(&mut given.edges, lane, &of.edges);
            set_tensor(&mut given.initial, lane, &of.initial);
            given.stored.set(lane, of.stored);
            set_tensor(&mut given.rates, lane, &of.rates);
            given.viscosity.set(lane, of.viscosity);
            set_tensor(&mut history.viscous, lane, &of.viscous);
            law(of).set(&mut constants, lane);
        }
        batch(Available::best(), &undeformed, &given, &constants, &mut deformed, &mut history, &mut results);
        for lane in 0..elements.len() {
            let viscous: Matrix<D> = if kinds[1] { tensor(&history.viscous, lane) } else { [[0.0; D]; D] };
            let forces: [Point<D>; N] = results.forces(lane);
            all.push(ElementForces {
                forces,
                stress: deformed.stress(lane),
                viscous,
                energy: deformed.energy.get(lane),
                ratio: results.ratio.get(lane),
                power: results.power.get(lane),
                normal: std::array::from_fn(|axis| history.memory.get(axis).map_or(0.0, |of| of.get(lane))),
            });
        }
    }
    all
}
