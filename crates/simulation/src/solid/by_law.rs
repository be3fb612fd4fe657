//! Batches of elements by their laws.
//!
//! A batch has elements with successive numbers, and most batches have elements of one law: its kernel
//! computes them all. A batch with elements of several laws is computed once by each of their kernels, and
//! every element takes the result of its own.

use crate::lanes::{Available, LANES};
use crate::laws::{AnyLaw, ElementLaw, with_law};
use crate::simplex::Simplex;
use crate::solid::batch::{BatchInputs, BatchResults, Deformed, History, Undeformed, strain};

/// A batch of elements, before its deformation.
#[derive(Clone, Copy)]
pub(super) struct ElementBatch<'a, const D: usize> {
    pub(super) available: Available,
    pub(super) undeformed: &'a Undeformed<D>,
    pub(super) given: &'a BatchInputs<D>,
    /// Number of its elements.
    pub(super) count: usize,
    /// Whether all of them have the same material.
    pub(super) alike: bool,
}

impl<const D: usize> ElementBatch<'_, D> {
    /// Computes the elements. `law_of`: the law of each of them.
    #[inline]
    pub(super) fn deform<'l, const N: usize, const INITIAL: bool, const VISCOUS: bool>(
        self,
        law_of: impl Fn(usize) -> &'l AnyLaw<D>,
        deformed: &mut Deformed<D>,
        history: &mut History<D>,
        results: &mut BatchResults<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if self.alike {
            with_law!(law_of(0), law => {
                let constants = ElementLaw::<D, N>::constants(law);
                self.strain::<N, INITIAL, VISCOUS, _>(law, &constants, deformed, history, results);
            });
            return;
        }
        let mut done = [false; LANES];
        for first in 0..self.count {
            if !done[first] {
                with_law!(law_of(first), law => {
                    self.deform_own::<N, INITIAL, VISCOUS, _>(law, &law_of, &mut done, deformed, history, results);
                });
            }
        }
    }

    /// Computes the elements that have a law of this type, and marks them as `done`.
    fn deform_own<'l, const N: usize, const INITIAL: bool, const VISCOUS: bool, L: ElementLaw<D, N>>(
        self,
        law: &L,
        law_of: &impl Fn(usize) -> &'l AnyLaw<D>,
        done: &mut [bool; LANES],
        deformed: &mut Deformed<D>,
        history: &mut History<D>,
        results: &mut BatchResults<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut constants = law.constants();
        let mut own = [false; LANES];
        for lane in 0..self.count {
            if let Some(law) = law_of(lane).as_one::<L>() {
                law.set(&mut constants, lane);
                own[lane] = true;
            }
        }
        if own[..self.count].iter().all(|own| *own) {
            *done = own;
            return self.strain::<N, INITIAL, VISCOUS, L>(law, &constants, deformed, history, results);
        }
        let (mut others, mut of_others, mut other_results) =
            (deformed.clone(), history.clone(), results.clone());
        self.strain::<N, INITIAL, VISCOUS, L>(
            law,
            &constants,
            &mut others,
            &mut of_others,
            &mut other_results,
        );
        for lane in (0..self.count).filter(|&lane| own[lane]) {
            done[lane] = true;
            deformed.take_lane(&others, lane);
            history.take_lane(&of_others, lane);
            results.take_lane(&other_results, lane);
        }
    }

    /// Computes all elements with the law of this type.
    #[inline]
    fn strain<const N: usize, const INITIAL: bool, const VISCOUS: bool, L: ElementLaw<D, N>>(
        self,
        _: &L,
        constants: &L::Constants,
        deformed: &mut Deformed<D>,
        history: &mut History<D>,
        results: &mut BatchResults<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Self { available, undeformed, given, .. } = self;
        strain::<D, N, INITIAL, VISCOUS, L>(
            available, undeformed, given, constants, deformed, history, results,
        );
    }
}
