//! The deformation of elements, a batch of them side by side: see `lanes.rs`.

use crate::lanes::{
    Available, LANES, Lanes, Tensors, compiled_for_vectors, rows, set_rows, set_tensor, tensor,
};
use crate::laws::ElementLaw;
use crate::simplex::Simplex;
use crate::solid::viscous::viscous_stress;
use crate::solid::watch::{Watch, find_moved, upper};
use crate::vector::{Matrix, Point, contraction, matrix, product, product_transposed, symmetric, transposed};

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
    pub(crate) const EMPTY: Self = Self { gradients: [[Lanes::ZERO; D]; D], volume: Lanes::all(1.0) };
}

/// Results of the deformation of a batch that are kept.
#[derive(Clone, Debug)]
pub(crate) struct Deformed<const D: usize> {
    /// Cauchy stress, Pa. It is symmetric; entries below the diagonal are not used.
    stress: Tensors<D>,
    /// Strain energy, J.
    pub(crate) energy: Lanes,
    /// The states in which facets were checked, where joints are inserted.
    pub(crate) watch: Option<Box<Watch<D>>>,
}

impl<const D: usize> Deformed<D> {
    pub(crate) const NONE: Self = Self { stress: [[Lanes::ZERO; D]; D], energy: Lanes::ZERO, watch: None };

    #[inline(always)]
    pub(crate) fn stress(&self, lane: usize) -> Matrix<D> {
        upper(&self.stress, lane)
    }

    /// Compares the present states with those that were noted, if any were. `edges`: as those of
    /// [`BatchInputs`].
    pub(super) fn find_moved(&mut self, available: Available, edges: &Tensors<D>) {
        if let Some(watch) = &mut self.watch {
            find_moved(available, edges, &self.stress, watch);
        }
    }

    /// Takes one element from another batch.
    pub(super) fn take_lane(&mut self, from: &Self, lane: usize) {
        self.set_stress(lane, &from.stress(lane));
        self.energy.set(lane, from.energy.get(lane));
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

/// Values that the elements of a batch keep from step to step.
#[derive(Clone, Debug)]
pub(crate) struct History<const D: usize> {
    /// Viscous parts of the stresses (first Piola-Kirchhoff), Pa.
    pub(crate) viscous: Tensors<D>,
    /// Energy that has been dissipated so far, J.
    pub(crate) dissipated: Lanes,
    /// The memories of their laws.
    pub(crate) memory: Box<[Lanes]>,
}

impl<const D: usize> History<D> {
    /// The history of a batch at the beginning, with a memory of `length` values.
    pub(crate) fn new(length: usize) -> Self {
        Self {
            viscous: [[Lanes::ZERO; D]; D],
            dissipated: Lanes::ZERO,
            memory: vec![Lanes::ZERO; length].into_boxed_slice(),
        }
    }

    /// Sets the memory of an element.
    pub(super) fn set_memory(&mut self, lane: usize, values: &[f64]) {
        for (to, value) in self.memory.iter_mut().zip(values) {
            to.set(lane, *value);
        }
    }

    /// Takes one element from another batch.
    pub(super) fn take_lane(&mut self, from: &Self, lane: usize) {
        set_tensor(&mut self.viscous, lane, &tensor(&from.viscous, lane));
        self.dissipated.set(lane, from.dissipated.get(lane));
        for (to, from) in self.memory.iter_mut().zip(&from.memory) {
            to.set(lane, from.get(lane));
        }
    }
}

/// Further input of the deformation of a batch in this step.
#[derive(Clone, Debug)]
pub(crate) struct BatchInputs<const D: usize> {
    /// Matrices whose columns are the edges from corner 0, m.
    pub(crate) edges: Tensors<D>,
    /// Initial stress (second Piola-Kirchhoff), Pa, and the energy that it has stored, J/m³; not read without
    /// initial stress.
    pub(crate) initial: Tensors<D>,
    pub(crate) stored: Lanes,
    /// Differences of velocities from that of corner 0, m/s, and viscosities, Pa s; not read without
    /// viscosity.
    pub(crate) rates: Tensors<D>,
    pub(crate) viscosity: Lanes,
}

impl<const D: usize> BatchInputs<D> {
    pub(crate) const NONE: Self = Self {
        edges: [[Lanes::ZERO; D]; D],
        initial: [[Lanes::ZERO; D]; D],
        stored: Lanes::ZERO,
        rates: [[Lanes::ZERO; D]; D],
        viscosity: Lanes::ZERO,
    };
}

/// Results of the deformation of a batch that are used immediately.
#[derive(Clone, Debug)]
pub(crate) struct BatchResults<const D: usize, const N: usize> {
    /// Forces on the corners, N.
    forces: [[Lanes; D]; N],
    /// Deformed over undeformed volume.
    pub(crate) ratio: Lanes,
    /// Power of the last viscous stress and of the new one together, over the volume, W/m³; not written
    /// without viscosity.
    pub(crate) power: Lanes,
    /// Energy that a law has dissipated over the undeformed volume, J/m³; not written by a law that does not.
    pub(crate) dissipated: Lanes,
    /// The measure of strain of [`ElementLaw::SMALL`].
    strain: Lanes,
}

impl<const D: usize, const N: usize> BatchResults<D, N> {
    pub(crate) const NONE: Self = Self {
        forces: [[Lanes::ZERO; D]; N],
        ratio: Lanes::ZERO,
        power: Lanes::ZERO,
        dissipated: Lanes::ZERO,
        strain: Lanes::ZERO,
    };

    /// Takes one element from another batch.
    pub(super) fn take_lane(&mut self, from: &Self, lane: usize) {
        set_rows(&mut self.forces, lane, &rows(&from.forces, lane));
        let Self { ratio, power, dissipated, strain, .. } = self;
        for (to, from) in [
            (ratio, &from.ratio),
            (power, &from.power),
            (dissipated, &from.dissipated),
            (strain, &from.strain),
        ] {
            to.set(lane, from.get(lane));
        }
    }

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

/// Computes one element of a batch: for small strains, or once more for `ANY` strain. Twin: `deform` in
/// `crates/gpu/kernels/laws.h`.
#[inline(always)]
fn strain_one<
    const D: usize,
    const N: usize,
    const INITIAL: bool,
    const VISCOUS: bool,
    const ANY: bool,
    L: ElementLaw<D, N>,
>(
    lane: usize,
    undeformed: &Undeformed<D>,
    given: &BatchInputs<D>,
    constants: &L::Constants,
    deformed: &mut Deformed<D>,
    history: &mut History<D>,
    results: &mut BatchResults<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let gradients = tensor(&undeformed.gradients, lane);
    let volume = undeformed.volume.get(lane);
    let gradient = product(&tensor(&given.edges, lane), &gradients);
    let j = <[[f64; D]; N]>::determinant(&gradient);
    let response = if ANY {
        L::stress(constants, &mut history.memory, lane, &gradient, j)
    } else {
        let response = L::stress_of_small(constants, &mut history.memory, lane, &gradient, j);
        results.strain.set(lane, response.strain);
        response
    };
    if L::DISSIPATES {
        results.dissipated.set(lane, response.dissipated);
    }
    let (mut stress, mut energy) = (response.stress, response.energy);
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
        // Of a large strain it is known already, and the stress of the step before is no longer there.
        if !ANY {
            let rate = product(&tensor(&given.rates, lane), &gradients);
            let before = tensor(&history.viscous, lane);
            let now = viscous_stress::<D, N>(given.viscosity.get(lane), &gradient, j, &rate);
            results.power.set(lane, contraction(&before, &rate) + contraction(&now, &rate));
            set_tensor(&mut history.viscous, lane, &now);
        }
        let now = tensor(&history.viscous, lane);
        stress = matrix(|i, k| stress[i][k] + now[i][k]);
    }
    results.ratio.set(lane, j);
    deformed.energy.set(lane, energy * volume);
    let cauchy = symmetric(&product_transposed(&stress, &gradient));
    let over = 1.0 / j;
    deformed.set_stress(lane, &cauchy.map(|row| row.map(|x| x * over)));
    let forces: [Point<D>; N] = forces_of(&stress, &gradients, volume);
    for corner in 0..N {
        for axis in 0..D {
            results.forces[corner][axis].set(lane, forces[corner][axis]);
        }
    }
}

/// Computes a batch.
#[inline(always)]
fn strain_all<const D: usize, const N: usize, const INITIAL: bool, const VISCOUS: bool, L: ElementLaw<D, N>>(
    undeformed: &Undeformed<D>,
    given: &BatchInputs<D>,
    constants: &L::Constants,
    deformed: &mut Deformed<D>,
    history: &mut History<D>,
    results: &mut BatchResults<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        strain_one::<D, N, INITIAL, VISCOUS, false, L>(
            lane, undeformed, given, constants, deformed, history, results,
        );
    }
}

compiled_for_vectors!(fn vectors = strain_all<
    const D: usize, const N: usize, const INITIAL: bool, const VISCOUS: bool; L
>(
    undeformed: &Undeformed<D>,
    given: &BatchInputs<D>,
    constants: &L::Constants,
    deformed: &mut Deformed<D>,
    history: &mut History<D>,
    results: &mut BatchResults<D, N>
) where [[f64; D]; N]: Simplex<D, N>, L: ElementLaw<D, N>);

/// Computes the elements of a batch, all of which have the same law.
#[inline]
pub(super) fn strain<
    const D: usize,
    const N: usize,
    const INITIAL: bool,
    const VISCOUS: bool,
    L: ElementLaw<D, N>,
>(
    available: Available,
    undeformed: &Undeformed<D>,
    given: &BatchInputs<D>,
    constants: &L::Constants,
    deformed: &mut Deformed<D>,
    history: &mut History<D>,
    results: &mut BatchResults<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    vectors::<D, N, INITIAL, VISCOUS, L>(available, undeformed, given, constants, deformed, history, results);
    for lane in 0..LANES {
        if results.strain.get(lane) >= L::SMALL {
            strain_one::<D, N, INITIAL, VISCOUS, true, L>(
                lane, undeformed, given, constants, deformed, history, results,
            );
        }
    }
}
