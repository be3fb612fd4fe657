//! Forces between two elements in contact.
//!
//! Couples are computed in batches. Couples that did not touch and that no facet parts now get a place among
//! the histories; then the forces of all couples with a place are computed: the gradient of their potentials,
//! and friction and damping.

use std::ops::Range;

use crate::contacts::couple::{AHEAD, Couple, skipped_until};
use crate::contacts::grips::{ContactInputs, Grip, Histories, Works, grip_of};
use crate::contacts::law::ContactLaw;
use crate::joint_sets::common_set;
use crate::joints::Joints;
use crate::lanes::{LANES, Lanes, compiled_for_vectors, larger, row, rows, set_row, set_rows, smaller};
use crate::simplex::{Interactions, Shapes, Simplex, gap, parted};
use crate::solid::Solid;
use crate::team::CHUNK;
use crate::vector::Point;

/// Number of batches whose potentials are computed together.
const GROUP: usize = 4;

/// Forces of a chunk of couples.
#[derive(Clone, Debug)]
pub(super) struct ChunkForces<const D: usize, const N: usize> {
    /// Forces of potential, friction and damping, in batches. Each couple has the place of its history.
    found: Vec<Interactions<D, N>>,
    /// The numbers of [`Works`] of each couple, in the same places.
    works: Vec<[Lanes; 4]>,
    /// Couples of the chunk that have separated in this pass, ascending, with the works of their last forces.
    pub(super) separated: Vec<(u32, Works)>,
}

impl<const D: usize, const N: usize> Default for ChunkForces<D, N> {
    fn default() -> Self {
        Self { found: Vec::new(), works: Vec::new(), separated: Vec::new() }
    }
}

impl<const D: usize, const N: usize> ChunkForces<D, N> {
    /// Adds the forces of the couple in a place to those of its elements, N. Returns its works, and whether
    /// one element reaches the centroid of the other.
    #[inline]
    pub(super) fn add_to(
        &self,
        forces: &mut [[Point<D>; N]],
        elements: [u32; 2],
        place: u16,
    ) -> (Works, bool) {
        let (batch, lane) = (place as usize / LANES, place as usize % LANES);
        let found = &self.found[batch];
        for (element, more) in elements.into_iter().zip(&found.forces) {
            for (sum, more) in forces[element as usize].iter_mut().zip(more) {
                for axis in 0..D {
                    sum[axis] += more[axis].get(lane);
                }
            }
        }
        (Works::of(&self.works[batch], lane), found.deep.get(lane) > 0.0)
    }
}

/// The state on which the forces of all couples depend in this pass.
pub(super) struct ContactPass<'a, const D: usize, const N: usize> {
    pub(super) solid: &'a Solid<D, N>,
    pub(super) joints: &'a Joints<D>,
    /// Parameters of the contacts of each pair of materials, and the number of materials.
    pub(super) laws: &'a [ContactLaw],
    pub(super) materials: usize,
    /// Joint sets of the facets of each element; empty without joint sets.
    pub(super) joint_facets: &'a [[u32; N]],
    /// Whether each element is bare.
    pub(super) bare: &'a [bool],
    /// Time step, s.
    pub(super) step: f64,
    /// Distance that nodes have travelled since the beginning, m.
    pub(super) travel: f64,
}

impl<const D: usize, const N: usize> ContactPass<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Computes the forces of a chunk of couples.
    pub(super) fn press(
        &self,
        couples: &mut [Couple],
        histories: &mut Histories<D, N>,
        pressed: &mut ChunkForces<D, N>,
    ) {
        pressed.separated.clear();
        // Mostly, bodies do not touch anywhere near.
        if couples.iter().all(|couple| couple.apart_until > self.travel) {
            return;
        }
        let mut work = Work::<D, N>::new(self.step);
        self.look(couples, &mut work.near, histories, &mut pressed.separated);
        let batches = histories.batches.len();
        pressed.found.resize(batches, Interactions::NONE);
        pressed.works.resize(batches, [Lanes::ZERO; 4]);
        for first in (0..batches).step_by(GROUP) {
            self.press_group(first..batches.min(first + GROUP), &mut work, couples, histories, pressed);
        }
        histories.trim();
        pressed.separated.sort_unstable_by_key(|(couple, _)| *couple);
    }

    /// Gives a place to the couples that did not touch and that no facet parts now.
    fn look(
        &self,
        couples: &mut [Couple],
        shapes: &mut Shapes<D, N>,
        histories: &mut Histories<D, N>,
        separated: &mut Vec<(u32, Works)>,
    ) {
        let (mut near, mut count) = ([0_usize; CHUNK], 0);
        for (number, couple) in couples.iter_mut().enumerate() {
            if couple.apart_until > self.travel {
                continue;
            }
            if !couple.touches && couple.elements.iter().any(|&element| !self.bare[element as usize]) {
                continue;
            }
            // A detached joint did not press its elements apart: their present overlap must not count
            // immediately.
            let joint = self.joints.all.get(couple.joint as usize);
            couple.initial_overlap |=
                joint.is_some_and(|joint| joint.fading > 0.0 && joint.detached != [false; D]);
            if self.weight(couple)[0] <= 0.0 {
                // While the joint carries the whole load, the gap says nothing about when contact begins: the
                // couple must not be skipped.
                if couple.touches {
                    let works = self.last_works(couple, histories);
                    separated.push((number as u32, works));
                    histories.free(couple.slot);
                }
                self.part(couple, 0.0);
            } else if !couple.touches {
                near[count] = number;
                count += 1;
            }
        }
        let near = &near[..count];
        let mut distances = Lanes::ZERO;
        for (first, numbers) in (0..).step_by(LANES).zip(near.chunks(LANES)) {
            for (lane, &number) in numbers.iter().enumerate() {
                let next = |ahead: usize| near.get(first + lane + ahead).map(|&next| &couples[next]);
                self.prefetch(next);
                for (shape, element) in shapes.iter_mut().zip(couples[number].elements) {
                    set_rows(shape, lane, &self.solid.shape(element));
                }
            }
            distances_of::<D, N>(self.solid.available, shapes, &mut distances);
            for (lane, &number) in numbers.iter().enumerate() {
                let (couple, distance) = (&mut couples[number], distances.get(lane));
                if distance >= 0.0 {
                    self.part(couple, distance);
                } else {
                    couple.touches = true;
                    couple.slot = histories.give(number, &Grip::NONE);
                }
            }
        }
    }

    /// Works of the last forces of a couple that touched, in the second half of their step.
    fn last_works(&self, couple: &Couple, histories: &Histories<D, N>) -> Works {
        let nodes = couple.elements.map(|element| self.solid.nodes_of(element));
        let velocities = nodes.map(|nodes| nodes.map(|node| self.solid.velocity(node as usize)));
        let [friction, damping] = histories.get(couple.slot).second_half(&velocities, self.step);
        Works { friction, damping, ..Works::default() }
    }

    /// Notes that the elements of a couple are at least this far apart, m.
    fn part(&self, couple: &mut Couple, distance: f64) {
        couple.initial_overlap = false;
        couple.touches = false;
        couple.apart_until = skipped_until(self.travel, distance);
    }

    /// Computes the forces of some batches of couples that have a place.
    fn press_group(
        &self,
        group: Range<usize>,
        work: &mut Work<D, N>,
        couples: &mut [Couple],
        histories: &mut Histories<D, N>,
        pressed: &mut ChunkForces<D, N>,
    ) {
        let available = self.solid.available;
        let Work { shapes, given, scratch, .. } = work;
        let shapes = &mut shapes[..group.len()];
        for (batch, (shapes, given)) in group.clone().zip(shapes.iter_mut().zip(&mut *given)) {
            for lane in 0..LANES {
                let place = batch * LANES + lane;
                self.prefetch(|ahead| histories.couple(place + ahead).map(|next| &couples[next]));
                match histories.couple(place) {
                    Some(couple) => self.gather(&couples[couple], lane, shapes, given),
                    // A lane without a couple costs nothing.
                    None => shapes.iter_mut().for_each(|shape| set_rows(shape, lane, &[[0.0; D]; N])),
                }
            }
        }
        let ChunkForces { found, works, separated } = pressed;
        <[[f64; D]; N]>::interactions(available, shapes, scratch, &mut found[group.clone()]);
        for (batch, (shapes, given)) in group.zip(shapes.iter().zip(given)) {
            let (found, works) = (&mut found[batch], &mut works[batch]);
            grip_of::<D, N>(available, shapes, given, found, &mut histories.batches[batch], works);
            for lane in 0..LANES {
                let Some(number) = histories.couple(batch * LANES + lane) else { continue };
                let couple = &mut couples[number];
                if found.energy.get(lane) > 0.0 {
                    couple.initial_overlap = false;
                    continue;
                }
                // They touch, or are apart with an edge of each nearest to the other.
                let [a, b] = [0, 1].map(|side| rows(&shapes[side], lane));
                let Works { friction, damping, .. } = Works::of(works, lane);
                separated.push((number as u32, Works { friction, damping, ..Works::default() }));
                histories.free(couple.slot);
                self.part(couple, a.distance(&b, 0.0));
            }
        }
    }

    /// Prefetches the data of the couples ahead: the numbers of the nodes, and then the nodes. The first
    /// element is often that of the couple before.
    #[inline]
    fn prefetch<'a>(&self, ahead: impl Fn(usize) -> Option<&'a Couple>) {
        if let Some(Couple { elements: [_, next], .. }) = ahead(2 * AHEAD) {
            self.solid.prefetch_element(*next as usize);
        }
        if let Some(Couple { elements: [_, next], .. }) = ahead(AHEAD) {
            for node in self.solid.nodes_of(*next) {
                self.solid.prefetch_node(node as usize);
            }
        }
    }

    /// Puts the input of the forces of a couple into a lane.
    #[inline]
    fn gather(
        &self,
        couple: &Couple,
        lane: usize,
        shapes: &mut Shapes<D, N>,
        given: &mut ContactInputs<D, N>,
    ) {
        let solid = self.solid;
        for side in 0..2 {
            let nodes = solid.nodes_of(couple.elements[side]);
            for corner in 0..N {
                let node = nodes[corner] as usize;
                set_row(&mut shapes[side][corner], lane, &solid.position(node));
                set_row(&mut given.velocities[side][corner], lane, &solid.velocity(node));
            }
        }
        let pair = couple.elements.map(|element| solid.element(element as usize));
        for side in 0..2 {
            given.masses[side].set(lane, pair[side].mass);
        }
        given.length.set(lane, smaller(pair[0].length, pair[1].length));
        let [one, other] = pair.map(|element| element.material as usize);
        let set = common_set(self.joint_facets, couple.elements).map_or(0, |set| set as usize + 1);
        given.set_law(lane, (set * self.materials + one) * self.materials + other, self.laws);
        let [weight, fading] = self.weight(couple);
        given.weight.set(lane, weight);
        given.fading.set(lane, fading);
        given.initial.set(lane, f64::from(u8::from(couple.initial_overlap)));
    }

    /// Share of the forces of a couple that acts, while a joint between its elements carries the rest, and
    /// the increase of this share in the last step.
    #[inline]
    fn weight(&self, couple: &Couple) -> [f64; 2] {
        let joint = self.joints.all.get(couple.joint as usize);
        joint.map_or([1.0, 0.0], |joint| [joint.faded, joint.fading])
    }
}

/// Memory for a group of couples.
struct Work<const D: usize, const N: usize>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Shapes of couples that did not touch, and of those of the group.
    near: Shapes<D, N>,
    shapes: [Shapes<D, N>; GROUP],
    given: [ContactInputs<D, N>; GROUP],
    scratch: <[[f64; D]; N] as Simplex<D, N>>::Scratch,
}

impl<const D: usize, const N: usize> Work<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn new(step: f64) -> Self {
        Self {
            near: [[[Lanes::ZERO; D]; N]; 2],
            shapes: [[[[Lanes::ZERO; D]; N]; 2]; GROUP],
            given: std::array::from_fn(|_| ContactInputs::new(step)),
            scratch: Default::default(),
        }
    }
}

/// Lower bounds of the distances of a batch of couples.
#[inline(always)]
fn all_distances<const D: usize, const N: usize>(shapes: &Shapes<D, N>, distances: &mut Lanes)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        distances.set(lane, gap(&rows(&shapes[0], lane), &rows(&shapes[1], lane)));
    }
    for side in 0..2 {
        for lane in 0..LANES {
            let parted = parted::<D, N>(&rows(&shapes[side], lane), &rows(&shapes[1 - side], lane));
            distances.set(lane, larger(distances.get(lane), parted));
        }
    }
}

compiled_for_vectors!(fn distances_of = all_distances<const D: usize, const N: usize>(shapes: &Shapes<D, N>, distances: &mut Lanes)
    where [[f64; D]; N]: Simplex<D, N>);

/// Points where the forces of couples act: the middle of their boundary in contact, or of their corners if
/// they do not overlap any more.
pub(super) fn points<const D: usize, const N: usize>(
    couples: &[[u32; 2]],
    solid: &Solid<D, N>,
) -> Vec<Point<D>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut points = Vec::with_capacity(couples.len());
    let (mut shapes, mut found) = ([[[Lanes::ZERO; D]; N]; 2], Interactions::NONE);
    let (mut distances, mut scratch) = (Lanes::ZERO, Default::default());
    for couples in couples.chunks(LANES) {
        for (lane, elements) in couples.iter().enumerate() {
            for (shape, element) in shapes.iter_mut().zip(elements) {
                set_rows(shape, lane, &solid.shape(*element));
            }
        }
        distances_of::<D, N>(solid.available, &shapes, &mut distances);
        <[[f64; D]; N]>::interactions(
            solid.available,
            std::slice::from_ref(&shapes),
            &mut scratch,
            std::slice::from_mut(&mut found),
        );
        points.extend((0..couples.len()).map(|lane| {
            if distances.get(lane) < 0.0 && found.energy.get(lane) > 0.0 {
                return row(&found.point, lane);
            }
            let corners: [[Point<D>; N]; 2] = [0, 1].map(|side| rows(&shapes[side], lane));
            std::array::from_fn(|axis| {
                corners.as_flattened().iter().map(|corner| corner[axis]).sum::<f64>() / (2 * N) as f64
            })
        }));
    }
    points
}
