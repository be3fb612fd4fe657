//! The deformation of elements one by one, as other devices compute it: for tests that compare the two.

use crate::lanes::{Available, LANES, Lanes, set_row, set_tensor, tensor};
use crate::laws::ElementLaw;
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
}

/// Deforms triangles with the neo-Hookean law. `kinds`: with initial stress, with viscosity.
pub fn deform_triangles(elements: &[ElementState<2>], kinds: [bool; 2]) -> Vec<ElementForces<2, 3>> {
    deform(elements, kinds)
}

/// Deforms tetrahedra with the neo-Hookean law. `kinds`: with initial stress, with viscosity.
pub fn deform_tetrahedra(elements: &[ElementState<3>], kinds: [bool; 2]) -> Vec<ElementForces<3, 4>> {
    deform(elements, kinds)
}

fn deform<const D: usize, const N: usize>(
    elements: &[ElementState<D>],
    kinds: [bool; 2],
) -> Vec<ElementForces<D, N>>
where
    [[f64; D]; N]: Simplex<D, N>,
    Moduli: ElementLaw<D, N, Constants = [Lanes; 2]>,
{
    let batch = match kinds {
        [false, false] => strain::<D, N, false, false, Moduli>,
        [false, true] => strain::<D, N, false, true, Moduli>,
        [true, false] => strain::<D, N, true, false, Moduli>,
        [true, true] => strain::<D, N, true, true, Moduli>,
    };
    let mut all = Vec::with_capacity(elements.len());
    for elements in elements.chunks(LANES) {
        let (mut undeformed, mut given) = (Undeformed::EMPTY, BatchInputs::NONE);
        let (mut deformed, mut history) = (Deformed::NONE, History::new(0));
        let mut results = BatchResults::<D, N>::NONE;
        let mut moduli = [Lanes::all(1.0); 2];
        for (lane, of) in elements.iter().enumerate() {
            set_tensor(&mut undeformed.gradients, lane, &of.gradients);
            undeformed.volume.set(lane, of.volume);
            set_tensor(&mut given.edges, lane, &of.edges);
            set_tensor(&mut given.initial, lane, &of.initial);
            given.stored.set(lane, of.stored);
            set_tensor(&mut given.rates, lane, &of.rates);
            given.viscosity.set(lane, of.viscosity);
            set_tensor(&mut history.viscous, lane, &of.viscous);
            set_row(&mut moduli, lane, &[of.shear, of.bulk]);
        }
        batch(Available::best(), &undeformed, &given, &moduli, &mut deformed, &mut history, &mut results);
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
            });
        }
    }
    all
}
