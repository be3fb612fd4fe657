//! Distances of elements from the states in which their facets were last checked.
//!
//! Whether a facet fails depends on the stress and the shape of the elements beside it. A check finds by how
//! much both may change before it has to be repeated: [`Watch::note`]. Until then a step compares the present
//! state with the noted one, which is far less work than the check.

use crate::accelerator::NotedState;
use crate::lanes::{LANES, Lanes, Tensors, compiled_for_vectors, tensor};
use crate::vector::{Matrix, contraction, matrix};

/// Change of the deformation gradient up to which a shape counts as the noted one. Slacks allow for it.
pub(crate) const TURN: f64 = 1.0 / 65536.0;

/// Twice the largest relative error of a number that is noted.
const ROUNDING: f64 = 1.2e-7;

/// A number of each element of a batch. Noted states need few digits, and a step reads all of them.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Noted([f32; LANES]);

impl Noted {
    const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    fn get(&self, lane: usize) -> f64 {
        f64::from(self.0[lane])
    }

    fn set(&mut self, lane: usize, value: f64) {
        self.0[lane] = value as f32;
    }
}

/// The noted states of a batch of elements.
#[derive(Clone, Debug)]
pub(crate) struct Watch<const D: usize> {
    /// Cauchy stress, Pa, of which entries below the diagonal are not used, and the matrix of the edges from
    /// corner 0, m.
    stress: [[Noted; D]; D],
    edges: [[Noted; D]; D],
    /// Square of the change of that matrix that changes the deformation gradient by at most [`TURN`], m².
    shift: Lanes,
    /// Change of stress that is not yet enough to check the facets again, Pa.
    reach: Lanes,
    /// Square of the present change of stress, Pa²; infinite if the edges have changed by more than they may.
    moved: Lanes,
    /// Number of elements that are awake, those without a place in the mesh too.
    awake: u64,
}

impl<const D: usize> Watch<D> {
    /// States that nothing has noted yet: all facets are to be checked.
    pub(crate) const NONE: Self = Self {
        stress: [[Noted::ZERO; D]; D],
        edges: [[Noted::ZERO; D]; D],
        shift: Lanes::ZERO,
        reach: Lanes::ZERO,
        moved: Lanes::ZERO,
        awake: LANES as u64,
    };

    /// Whether an element of the batch may be awake.
    #[inline]
    pub(crate) fn any_awake(&self) -> bool {
        self.awake > 0
    }

    /// Whether the facets of an element are to be checked. A change that is not a number says yes.
    #[inline]
    pub(crate) fn is_awake(&self, lane: usize) -> bool {
        let reach = self.reach.get(lane);
        !matches!(self.moved.get(lane).partial_cmp(&(reach * reach)), Some(std::cmp::Ordering::Less))
    }

    /// Lets the facets of an element be checked in the next step.
    pub(crate) fn wake(&mut self, lane: usize) {
        self.reach.set(lane, 0.0);
        self.awake += 1;
    }

    /// The largest change of the stress of an element from now on, Pa, before its facets are checked again.
    pub(crate) fn room(&self, lane: usize) -> f64 {
        self.reach.get(lane) + self.moved.get(lane).sqrt()
    }

    /// Notes the state of an element whose facets have been checked. `inverse`: the inverse of the matrix of
    /// its undeformed edges, 1/m; `reach`: change of stress before they are checked again, Pa.
    pub(crate) fn note(
        &mut self,
        lane: usize,
        stress: &Matrix<D>,
        edges: &Matrix<D>,
        inverse: &Matrix<D>,
        reach: f64,
    ) {
        for i in 0..D {
            for k in 0..D {
                self.edges[i][k].set(lane, edges[i][k]);
                self.stress[i.min(k)][i.max(k)].set(lane, stress[i.min(k)][i.max(k)]);
            }
        }
        let norm = |of: &Matrix<D>| contraction(of, of).sqrt();
        // The numbers that are noted are not exactly those of the check.
        let shift = TURN / norm(inverse) - ROUNDING * norm(edges);
        self.shift.set(lane, if shift > 0.0 { shift * shift } else { 0.0 });
        let reach = reach - ROUNDING * norm(stress);
        self.reach.set(lane, if reach > 0.0 { reach } else { 0.0 });
    }
}

impl<const D: usize> Watch<D> {
    /// The noted state of an element, for a device.
    pub(crate) fn noted(&self, lane: usize) -> NotedState<D> {
        let of = |noted: &[[Noted; D]; D]| noted.each_ref().map(|row| row.each_ref().map(|of| of.0[lane]));
        let (shift, reach) = (self.shift.get(lane), self.reach.get(lane));
        NotedState { stress: of(&self.stress), edges: of(&self.edges), shift, reach }
    }

    /// Sets the square of the present change of stress that a device has found, Pa².
    pub(crate) fn set_moved(&mut self, lane: usize, moved: f64) {
        self.moved.set(lane, moved);
    }
}

compiled_for_vectors!(pub(super) fn find_moved = all_moved<const D: usize>(
    edges: &Tensors<D>,
    stress: &Tensors<D>,
    watch: &mut Watch<D>
));

/// Compares the present states of a batch with the noted ones. `edges`: matrices of the edges from corner 0,
/// m; `stress`: Cauchy stresses, Pa, of which only the upper halves are read. Twin: `find_moved` in
/// `crates/gpu/kernels/watch.h`.
#[inline(always)]
fn all_moved<const D: usize>(edges: &Tensors<D>, stress: &Tensors<D>, watch: &mut Watch<D>) {
    let mut awake = 0;
    for lane in 0..LANES {
        let noted = matrix(|i, k| watch.edges[i][k].get(lane));
        let shifted = square_of_difference(&tensor(edges, lane), &noted);
        let noted = matrix(|i, k| watch.stress[i.min(k)][i.max(k)].get(lane));
        let moved = square_of_difference(&upper(stress, lane), &noted);
        let allowed = if shifted < watch.shift.get(lane) { moved } else { f64::INFINITY };
        watch.moved.set(lane, allowed);
        let reach = watch.reach.get(lane);
        awake += 1 - u64::from(allowed < reach * reach);
    }
    watch.awake = awake;
}

/// A symmetric tensor of one member, from its upper half.
#[inline(always)]
pub(super) fn upper<const D: usize>(of: &Tensors<D>, lane: usize) -> Matrix<D> {
    matrix(|i, k| of[i.min(k)][i.max(k)].get(lane))
}

#[inline(always)]
fn square_of_difference<const D: usize>(one: &Matrix<D>, other: &Matrix<D>) -> f64 {
    let difference: Matrix<D> = matrix(|i, k| one[i][k] - other[i][k]);
    contraction(&difference, &difference)
}
