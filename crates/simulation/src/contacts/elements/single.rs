//! The law of contacts, couple by couple, as other devices compute it: for tests that compare the two.

use crate::accelerator::{FlatContact, FlatGrip};
use crate::contacts::elements::distances_of;
use crate::contacts::elements::grips::{ContactInputs, Grip, Grips, grip_of};
use crate::contacts::law::ContactLaw;
use crate::contacts::places::HistoryBatch;
use crate::lanes::{Available, LANES, Lanes, row, rows, set_rows};
use crate::simplex::interactions::interactions;
use crate::simplex::{Interactions, Simplex};
use crate::vector::Point;

/// Two elements that may touch, and all that their laws find.
#[derive(Clone, Copy, Debug)]
pub struct ContactCase<const D: usize, const N: usize> {
    /// The corners of both, m.
    pub shapes: [[[f64; D]; N]; 2],
    /// Velocities of the corners, m/s.
    pub velocities: [[[f64; D]; N]; 2],
    /// The law of the contact.
    pub law: FlatContact,
    /// See [`CoupleStates::overlaps`](crate::CoupleStates::overlaps).
    pub overlap: u8,
    /// The history of the contact, which the pass changes.
    pub grip: FlatGrip<D>,
    /// Forces on the corners, N: a result, as are all that follow.
    pub forces: [[[f64; D]; N]; 2],
    /// The integral of both potentials over the overlap, and 1 if one element has sunk too deep into the
    /// other, else 0.
    pub energy: [f64; 2],
    /// Energy, J, works against friction and damping, energy that was handed over, and energy that has
    /// relaxed.
    pub works: [f64; 5],
    /// Lower bounds of the distance, m: negative if the elements may overlap, and that of elements that do
    /// not.
    pub distances: [f64; 2],
}

impl<const D: usize, const N: usize> Grip<D, N> {
    /// This history as a plain record.
    pub(crate) fn flat(&self) -> FlatGrip<D> {
        let Self { friction, damping, shares, credited_energy, way, push } = *self;
        FlatGrip { friction, damping, shares, credited_energy, way, push }
    }

    /// The history of a plain record.
    pub(crate) fn of_flat(flat: &FlatGrip<D>) -> Self {
        let FlatGrip { friction, damping, shares, credited_energy, way, push } = *flat;
        Self { friction, damping, shares, credited_energy, way, push }
    }
}

/// Computes the contacts of triangles, and updates their histories. `step`: time step, s; `still_ignored`:
/// see [`Press`](crate::Press).
pub fn press_triangles(cases: &mut [ContactCase<2, 3>], step: f64, still_ignored: f64) {
    press_cases(cases, step, still_ignored);
}

/// The same for tetrahedra.
pub fn press_tetrahedra(cases: &mut [ContactCase<3, 4>], step: f64, still_ignored: f64) {
    press_cases(cases, step, still_ignored);
}

fn press_cases<const D: usize, const N: usize>(cases: &mut [ContactCase<D, N>], step: f64, still_ignored: f64)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let available = Available::best();
    let mut scratch = Default::default();
    for cases in cases.chunks_mut(LANES) {
        let mut shapes = [[[Lanes::ZERO; D]; N]; 2];
        let mut given = ContactInputs::new(step, still_ignored);
        let (mut grips, mut found, mut works) = (Grips::NONE, Interactions::NONE, [Lanes::ZERO; 5]);
        let laws: Vec<ContactLaw> = cases.iter().map(|case| contact_law(&case.law)).collect();
        for (lane, case) in cases.iter().enumerate() {
            for side in 0..2 {
                set_rows(&mut shapes[side], lane, &case.shapes[side]);
                set_rows(&mut given.velocities[side], lane, &case.velocities[side]);
                given.masses[side].set(lane, case.law.masses[side]);
            }
            given.length.set(lane, case.law.length);
            given.set_law(lane, lane, &laws);
            given.weight.set(lane, case.law.weight);
            given.fading.set(lane, case.law.fading);
            given.initial.set(lane, f64::from(case.overlap));
            grips.set(lane, &Grip::of_flat(&case.grip));
        }
        let mut distances = Lanes::ZERO;
        distances_of::<D, N>(available, &shapes, &mut distances);
        interactions(
            available,
            std::slice::from_ref(&shapes),
            &mut scratch,
            std::slice::from_mut(&mut found),
        );
        grip_of::<D, N>(available, &shapes, &given, &mut found, &mut grips, &mut works);
        for (lane, case) in cases.iter_mut().enumerate() {
            case.forces = [0, 1].map(|side| rows::<D, N>(&found.forces[side], lane));
            case.energy = [found.energy(lane), found.deep.get(lane)];
            case.works = row(&works, lane);
            case.grip = grips.get(lane).flat();
            let [a, b]: [[Point<D>; N]; 2] = case.shapes;
            case.distances = [distances.get(lane), a.distance(&b, 0.0)];
        }
    }
}

/// The part of the law that is one of two materials.
fn contact_law(flat: &FlatContact) -> ContactLaw {
    let FlatContact { penalty, friction, tangential, damping, .. } = *flat;
    ContactLaw { penalty, friction, tangential, damping }
}
