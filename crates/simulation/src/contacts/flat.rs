//! Couples of elements as plain lists, for machines with a memory of their own.

use crate::accelerator::{CoupleColumns, CoupleStates, Press};
use crate::contacts::Contacts;
use crate::contacts::elements::ElementPass;
use crate::contacts::elements::grips::{Grip, Grips};
use crate::contacts::pair::Overlap;
use crate::contacts::places::HistoryBatch;
use crate::joints::Joints;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::Grains;
use crate::topology::Topology;

impl<const D: usize, const N: usize> Contacts<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Whether there are couples.
    pub(crate) fn has_couples(&self) -> bool {
        !self.elements.all().is_empty()
    }

    /// The elements of the couple in a place.
    pub(crate) fn elements_of(&self, place: usize) -> [u32; 2] {
        self.elements.all()[place].parts
    }

    /// The elements of the couples for which this is true, with repetitions.
    pub(crate) fn elements_where(&self, touches: &[bool]) -> Vec<u32> {
        let all = self.elements.all().iter().zip(touches);
        all.filter(|(_, touches)| **touches).flat_map(|(couple, _)| couple.parts).collect()
    }

    /// All couples, and the values of them that phases change.
    pub(crate) fn flat(
        &self,
        solid: &Solid<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
    ) -> (CoupleColumns, CoupleStates<D>) {
        let Self { laws, surface, elements, .. } = self;
        let pass = ElementPass { solid, joints, topology, surface, laws };
        let couples = elements.all();
        let mut touching = elements.touching();
        let grip = |touches: bool| {
            let known = if touches { touching.next() } else { None };
            known.map_or(Grips::<D, N>::NEW, |(_, grip)| grip).flat()
        };
        let columns = CoupleColumns {
            elements: couples.iter().map(|couple| couple.parts).collect(),
            laws: couples.iter().map(|couple| pass.flat_law(couple)).collect(),
            may_begin: couples.iter().map(|couple| pass.begins(couple.parts)).collect(),
            credits: couples.iter().map(|couple| pass.credits(couple)).collect(),
        };
        let states = CoupleStates {
            touches: couples.iter().map(|couple| couple.touches).collect(),
            overlaps: couples.iter().map(|couple| couple.initial_overlap as u8).collect(),
            apart_until: couples.iter().map(|couple| couple.apart_until).collect(),
            grips: couples.iter().map(|couple| couple.touches).map(grip).collect(),
        };
        (columns, states)
    }

    /// Takes values that phases have changed.
    pub(crate) fn take_flat(&mut self, states: &CoupleStates<D>) {
        let CoupleStates { touches, overlaps, apart_until, grips } = states;
        let touching = touches.iter().zip(grips).filter(|(touches, _)| **touches);
        self.elements.change(
            |place, couple| {
                couple.touches = touches[place];
                couple.initial_overlap = Overlap::of_number(overlaps[place]);
                couple.apart_until = apart_until[place];
            },
            touching.map(|(_, grip)| Grip::of_flat(grip)),
        );
    }

    /// Everything else that the forces of a step depend on. `step`: time step, s; `grains`: of the works that
    /// are added up; `energy`: whether to compute the energy of the contacts.
    pub(crate) fn flat_press(&self, step: f64, grains: Grains, energy: bool) -> Press {
        Press {
            step,
            travel: self.elements.travel(),
            still_ignored: self.laws.still_ignored(step),
            grains: grains.shifts(),
            energy,
        }
    }
}
