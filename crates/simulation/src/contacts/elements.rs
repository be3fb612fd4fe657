//! Contacts between elements: the pair of bodies that deform with themselves.
//!
//! The force of a couple is the gradient of the potentials of its elements, and friction and damping. Couples
//! are computed in batches.

pub(super) mod grips;
mod relation;
pub(super) mod single;

use std::ops::Range;

use fdem_contact::prefetch;

use crate::accelerator::FlatContact;
use crate::bodies::Bodies;
use crate::contacts::elements::grips::{ContactInputs, Grip, Grips, grip_of};
use crate::contacts::elements::relation::{couple, distance};
use crate::contacts::law::{ContactLaw, ContactLaws};
use crate::contacts::pair::{AHEAD, BatchWorks, Couple, Overlap, Pair, PairPass};
use crate::contacts::places::Histories;
use crate::contacts::surface::Surface;
use crate::joints::Joints;
use crate::lanes::{LANES, Lanes, compiled_for_vectors, larger, row, rows, set_row, set_rows, smaller};
use crate::simplex::interactions::interactions;
use crate::simplex::{Interactions, Shapes, Simplex, gap, parted};
use crate::solid::Solid;
use crate::topology::{NONE, Topology};
use crate::vector::Point;

/// Number of batches whose potentials are computed together.
const GROUP: usize = 4;

/// The pair of elements with elements. Between two there may be a joint: its number, or [`NONE`].
#[derive(Clone, Debug)]
pub(crate) struct ElementPair<const D: usize, const N: usize>;

impl<const D: usize, const N: usize> Pair for ElementPair<D, N> {
    type Between = u32;
    type Histories = Grips<D, N>;
    type Forces = Interactions<D, N>;

    const NO_FORCES: Interactions<D, N> = Interactions::NONE;
    const COST: u64 = 60;
}

/// Elements, and all that their contacts depend on.
pub(super) struct ElementPass<'a, const D: usize, const N: usize> {
    pub(super) solid: &'a Solid<D, N>,
    pub(super) joints: &'a Joints<D>,
    pub(super) topology: &'a Topology<D, N>,
    pub(super) surface: &'a Surface,
    pub(super) laws: &'a ContactLaws<N>,
}

impl<const D: usize, const N: usize> PairPass<D> for ElementPass<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    type Pair = ElementPair<D, N>;
    type One = Solid<D, N>;
    type Other = Solid<D, N>;
    /// Forces on the corners of elements, N.
    type Target = [[Point<D>; N]];
    type Work = Work<D, N>;

    const ALIKE: bool = true;
    const GROUP: usize = GROUP;

    #[inline]
    fn one(&self) -> &Solid<D, N> {
        self.solid
    }

    #[inline]
    fn other(&self) -> &Solid<D, N> {
        self.solid
    }

    fn searched(&self) -> [&[u32]; 2] {
        [&self.surface.list, &[]]
    }

    fn couple(&self, elements: [u32; 2]) -> Option<Couple<u32>> {
        let Self { joints, topology, surface, .. } = self;
        if self.solid.rigid.joins(elements) {
            return None;
        }
        let parted = surface.parted.binary_search(&elements).is_ok();
        couple(elements, parted, &surface.groups, joints, topology)
    }

    fn distance(&self, couple: &Couple<u32>, most: f64) -> Option<f64> {
        if couple.between != NONE {
            // The joint says when their contact begins.
            return None;
        }
        let [a, b] = couple.parts.map(|element| self.solid.shape(element));
        distance(&a, &b, most)
    }

    #[inline]
    fn may_begin(&self, elements: [u32; 2]) -> bool {
        elements.iter().all(|&element| self.surface.bare[element as usize])
    }

    #[inline]
    fn acts(&self, couple: &mut Couple<u32>) -> bool {
        if self.credits(couple) {
            couple.initial_overlap = couple.initial_overlap.max(Overlap::Credited);
        }
        self.weight(couple)[0] > 0.0
    }

    fn work(&self, step: f64) -> Work<D, N> {
        Work::new(step, self.laws.still_ignored(step))
    }

    fn distances(
        &self,
        couples: &[Couple<u32>],
        near: &[usize],
        work: &mut Work<D, N>,
        distances: &mut Lanes,
    ) {
        let shapes = &mut work.near;
        for (lane, &number) in near.iter().take(LANES).enumerate() {
            let next = |ahead: usize| near.get(lane + ahead).map(|&next| &couples[next]);
            self.prefetch_elements(next);
            for (shape, element) in shapes.iter_mut().zip(couples[number].parts) {
                set_rows(shape, lane, &self.solid.shape(element));
            }
        }
        distances_of::<D, N>(self.solid.available, shapes, distances);
    }

    fn press(
        &self,
        couples: &[Couple<u32>],
        histories: &mut Histories<Grips<D, N>>,
        batches: Range<usize>,
        found: &mut [Interactions<D, N>],
        works: &mut [BatchWorks],
        work: &mut Work<D, N>,
    ) {
        let available = self.solid.available;
        let Work { shapes, given, scratch, .. } = work;
        let shapes = &mut shapes[..batches.len()];
        for (batch, (shapes, given)) in batches.clone().zip(shapes.iter_mut().zip(&mut *given)) {
            for lane in 0..LANES {
                let place = batch * LANES + lane;
                self.prefetch_elements(|ahead| histories.couple(place + ahead).map(|next| &couples[next]));
                match histories.couple(place) {
                    Some(couple) => self.gather(&couples[couple], lane, shapes, given),
                    // A lane without a couple costs nothing.
                    None => shapes.iter_mut().for_each(|shape| set_rows(shape, lane, &[[0.0; D]; N])),
                }
            }
        }
        interactions(available, shapes, scratch, found);
        let of_batches = shapes.iter().zip(given).zip(&mut histories.batches[batches]);
        for (((shapes, given), grips), (found, works)) in of_batches.zip(found.iter_mut().zip(works)) {
            grip_of::<D, N>(available, shapes, given, found, grips, works);
        }
    }

    #[inline]
    fn overlaps(found: &Interactions<D, N>, lane: usize) -> bool {
        found.energy(lane) > 0.0
    }

    /// They touch, or are apart with an edge of each nearest to the other.
    fn distance_in(&self, work: &Work<D, N>, batch: usize, lane: usize) -> f64 {
        let [a, b] = [0, 1].map(|side| rows(&work.shapes[batch][side], lane));
        a.distance(&b, 0.0)
    }

    fn last_works(&self, elements: [u32; 2], grip: &Grip<D, N>, step: f64) -> [f64; 2] {
        grip.last_works(self.solid, elements, step)
    }

    #[inline]
    fn add(
        found: &Interactions<D, N>,
        lane: usize,
        elements: [u32; 2],
        target: &mut [[Point<D>; N]],
    ) -> bool {
        for (element, more) in elements.into_iter().zip(&found.forces) {
            for (sum, more) in target[element as usize].iter_mut().zip(more) {
                for axis in 0..D {
                    sum[axis] += more[axis].get(lane);
                }
            }
        }
        found.deep.get(lane) > 0.0
    }

    /// The first element is often that of the couple before.
    #[inline]
    fn prefetch([_, element]: [u32; 2], target: &[[Point<D>; N]]) {
        prefetch(&target[element as usize]);
    }

    fn force(grip: &Grip<D, N>) -> [Point<D>; 2] {
        [grip.push, grip.friction]
    }

    /// The middle of the boundary in contact, or of the corners of two elements that do not overlap any more.
    fn points(&self, couples: &[[u32; 2]]) -> Vec<Point<D>> {
        let solid = self.solid;
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
            interactions(
                solid.available,
                std::slice::from_ref(&shapes),
                &mut scratch,
                std::slice::from_mut(&mut found),
            );
            points.extend((0..couples.len()).map(|lane| {
                if distances.get(lane) < 0.0 && found.energy(lane) > 0.0 {
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
}

impl<const D: usize, const N: usize> ElementPass<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Couples of the elements that have separated.
    pub(super) fn parted(&self) -> impl Iterator<Item = Couple<u32>> {
        let acts = |pair: &&[u32; 2]| pair.iter().any(|&element| self.solid.acts(element));
        self.surface.parted.iter().filter(acts).filter_map(|&pair| self.couple(pair))
    }

    /// Prefetches the data of the couples ahead: the numbers of the nodes, and then the nodes. The first
    /// element is often that of the couple before.
    #[inline]
    fn prefetch_elements<'a>(&self, ahead: impl Fn(usize) -> Option<&'a Couple<u32>>) {
        if let Some(Couple { parts: [_, next], .. }) = ahead(2 * AHEAD) {
            self.solid.prefetch_element(*next as usize);
        }
        if let Some(Couple { parts: [_, next], .. }) = ahead(AHEAD) {
            for node in self.solid.nodes_of(*next) {
                self.solid.prefetch_node(node as usize);
            }
        }
    }

    /// Whether forces of a couple begin at zero with its present overlap: a detached joint did not press its
    /// elements apart.
    #[inline]
    pub(super) fn credits(&self, couple: &Couple<u32>) -> bool {
        let joint = self.joints.all.get(couple.between as usize);
        joint.is_some_and(|joint| joint.fading > 0.0 && joint.detached != [false; D])
    }

    /// Whether two elements that do not touch may begin to.
    pub(super) fn begins(&self, elements: [u32; 2]) -> bool {
        self.may_begin(elements)
    }

    /// The law of a couple as a plain record.
    pub(super) fn flat_law(&self, couple: &Couple<u32>) -> FlatContact {
        let pair = couple.parts.map(|element| self.solid.properties(element));
        let number = self.laws.number(couple.parts, pair.map(|part| part.material));
        let ContactLaw { penalty, friction, tangential, damping } = self.laws.all[number];
        let [weight, fading] = self.weight(couple);
        FlatContact {
            penalty,
            friction,
            tangential,
            damping,
            masses: pair.map(|part| part.mass),
            length: smaller(pair[0].length, pair[1].length),
            weight,
            fading,
        }
    }

    /// Puts the input of the forces of a couple into a lane.
    #[inline]
    fn gather(
        &self,
        couple: &Couple<u32>,
        lane: usize,
        shapes: &mut Shapes<D, N>,
        given: &mut ContactInputs<D, N>,
    ) {
        let solid = self.solid;
        for side in 0..2 {
            let nodes = solid.nodes_of(couple.parts[side]);
            for corner in 0..N {
                let node = nodes[corner] as usize;
                set_row(&mut shapes[side][corner], lane, &solid.position(node));
                set_row(&mut given.velocities[side][corner], lane, &solid.velocity(node));
            }
        }
        let pair = couple.parts.map(|element| solid.properties(element));
        for side in 0..2 {
            given.masses[side].set(lane, pair[side].mass);
        }
        given.length.set(lane, smaller(pair[0].length, pair[1].length));
        let number = self.laws.number(couple.parts, pair.map(|part| part.material));
        given.set_law(lane, number, &self.laws.all);
        let [weight, fading] = self.weight(couple);
        given.weight.set(lane, weight);
        given.fading.set(lane, fading);
        given.initial.set(lane, f64::from(couple.initial_overlap as u8));
    }

    /// Share of the forces of a couple that acts, while a joint between its elements carries the rest, and
    /// the increase of this share in the last step.
    #[inline]
    fn weight(&self, couple: &Couple<u32>) -> [f64; 2] {
        let joint = self.joints.all.get(couple.between as usize);
        joint.map_or([1.0, 0.0], |joint| [joint.faded, joint.fading])
    }
}

/// Memory for a group of couples.
pub(super) struct Work<const D: usize, const N: usize>
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
    fn new(step: f64, still_ignored: f64) -> Self {
        Self {
            near: [[[Lanes::ZERO; D]; N]; 2],
            shapes: [[[[Lanes::ZERO; D]; N]; 2]; GROUP],
            given: std::array::from_fn(|_| ContactInputs::new(step, still_ignored)),
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
