//! Contacts between elements: detection of couples, and their forces.
//!
//! Only elements near a free surface can touch elements to which they are not connected. A vertex is free if
//! an outer edge or a broken joint ends there. Elements within two rings around the free vertices
//! are *watched*: contact detection gets their boxes, with a buffer. When a crack reaches an element that is
//! not watched, the watched elements are determined again.
//!
//! The detection gets new boxes only when elements may have moved by a part of the buffer. Couples whose
//! boxes are near stay only if their elements are nearer than the buffer: in three dimensions a few of a
//! hundred. A couple that does not touch is skipped until nodes may have travelled half of its gap. All these
//! bounds add up the distance of the fastest node in each step, so that no contact is found too late.

mod couple;
mod forces;
mod grips;
mod law;

use fdem_contact::{Buffered, Couple as Pair, Detector, Elements as Boxes, prefetch};
use serde::{Deserialize, Serialize};

use crate::contacts::couple::{AHEAD, Couple, couple, near, separate};
use crate::contacts::forces::{ChunkForces, ContactPass, points};
pub(crate) use crate::contacts::grips::Grip;
use crate::contacts::grips::{Histories, Works};
use crate::contacts::law::{ContactLaw, laws};
pub(crate) use crate::contacts::law::{penalty_and_friction, stiffness};
use crate::error::{ModelError, Stop};
use crate::faces::Faces;
use crate::forces::ContactForce;
use crate::joints::{JointState, Joints};
use crate::model::Model;
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::{Solid, corners_of};
use crate::sum::{Grains, Pile, Sum};
use crate::team::{CHUNK, Team};
use crate::topology::{NONE, Topology};
use crate::vector::{Point, minus};

/// Number of chunks of couples for each thread whose forces are computed together. Meanwhile, those of the
/// round before are added to the forces of elements. The memory for the forces of couples does not grow
/// beyond two rounds.
const ROUND: usize = 16;

/// Share of the buffer for the motion of elements between two updates of their boxes.
const SLACK: f64 = 0.25;

/// State of the contacts in a saved run.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "Grip<D, N>: Serialize", deserialize = "Grip<D, N>: Deserialize<'de>"))]
pub(crate) struct SavedContacts<const D: usize = 2, const N: usize = 3> {
    /// Couples that touch, ascending, with their history of friction and damping.
    pub(crate) grips: Vec<([u32; 2], Grip<D, N>)>,
    /// See [`Contacts`].
    pub(crate) parted: Vec<[u32; 2]>,
    pub(crate) bared: Vec<u32>,
}

/// Couples of elements that may touch, and their detection.
#[derive(Clone, Debug)]
pub(crate) struct Contacts<const D: usize = 2, const N: usize = 3> {
    options: Vec<ContactLaw>,
    /// Joint sets of the facets of each element; empty without joint sets.
    joint_facets: Vec<[u32; N]>,
    materials: usize,
    /// Whether each vertex is free: on an outer facet or a broken joint.
    pub(crate) free: Vec<bool>,
    /// Group of each corner among those of its vertex, by the code of its first corner: elements of one group
    /// are connected there.
    pub(crate) groups: Vec<u32>,
    /// Whether each element is bare: whether one of its vertices is free. Only bare elements touch others.
    bare: Vec<bool>,
    /// Whether each element is watched.
    pub(crate) watched: Vec<bool>,
    list: Vec<u32>,
    search: Buffered<f64, D>,
    /// Gap up to which couples are chosen among the candidates, m.
    buffer: f64,
    /// After each update of the search, all couples with a smaller gap than this are among the candidates, m.
    slack: f64,
    /// Upper bound of the distance that nodes have travelled in all steps so far, m, its value at the last
    /// update of the search, and when couples were chosen.
    travel: f64,
    looked: f64,
    chosen: f64,
    /// Couples that may touch in the present state of the joints, ascending.
    couples: Vec<Couple>,
    /// For each chunk of couples, the histories of the couples that touch.
    histories: Vec<Histories<D, N>>,
    /// Forces of the couples of two rounds. They are not kept.
    pressed: [Vec<ChunkForces<D, N>>; 2],
    /// Pairs of elements that separated in the last step, at a vertex or along a facet, and elements that
    /// became bare in it. Their overlap must not count immediately.
    pub(crate) parted: Vec<[u32; 2]>,
    pub(crate) bared: Vec<u32>,
    /// Whether an element at a free vertex is not watched yet.
    pub(crate) unwatched: bool,
    pub(crate) detections: u64,
}

/// Results of a pass over the couples. Energies and works in J.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touching {
    /// Energy stored in the potentials, if requested.
    pub(crate) energy: Option<Sum>,
    /// Work against friction since the last pass.
    pub(crate) friction: Sum,
    /// Energy dissipated by damping since the last pass.
    pub(crate) damping: Sum,
    /// Potential energy that appeared because joints handed over to contact since the last pass.
    pub(crate) handed_over: Sum,
    /// Number of couples that overlap.
    pub(crate) count: usize,
    /// The elements of the first couple in which one element reaches the centroid of the other.
    pub(crate) deep: Option<[u32; 2]>,
}

impl Touching {
    /// Takes the works of a round of couples, and adds their forces to those of their elements. One by one:
    /// sums of chunks would depend on the couples that do not touch, and a resumed run may have others.
    fn take<const D: usize, const N: usize>(
        &mut self,
        couples: &[Couple],
        pressed: &[ChunkForces<D, N>],
        (share, grains): (&Share, Grains),
        forces: &mut [[Point<D>; N]],
    ) {
        for (couples, pressed) in couples.chunks(CHUNK).zip(pressed) {
            let mut piles = [Pile::default(); 3];
            let mut add = |sums: &mut Self, works: &Works| {
                if let Some(energy) = &mut sums.energy {
                    energy.add(works.energy);
                }
                let works = [works.friction, works.damping, works.handed_over];
                piles.iter_mut().zip(works).for_each(|(pile, work)| pile.add(work, grains));
            };
            let mut separated = pressed.separated.iter().peekable();
            for (number, couple) in (0..).zip(couples) {
                if let Some(next) = couples.get(number as usize + 2 * AHEAD) {
                    prefetch(&forces[next.elements[1] as usize]);
                }
                let counted = share.element(couple.elements[0]);
                if let Some((_, works)) = separated.next_if(|(couple, _)| *couple == number)
                    && counted
                {
                    add(self, works);
                }
                if couple.touches {
                    let (works, deep) = pressed.add_to(forces, couple.elements, couple.slot);
                    if counted {
                        add(self, &works);
                        self.count += 1;
                        self.deep = self.deep.or(deep.then_some(couple.elements));
                    }
                }
            }
            let sums = [&mut self.friction, &mut self.damping, &mut self.handed_over];
            sums.into_iter().zip(piles).for_each(|(sum, pile)| sum.add_pile(pile));
        }
    }
}

impl<const D: usize, const N: usize> Contacts<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// `edge`: mean length of the edges of the whole model, m.
    pub(crate) fn new(
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        faces: &Faces<D>,
        edge: f64,
        team: &Team,
    ) -> Result<Self, ModelError> {
        let materials = model.materials.len();
        let buffer = model.contact.buffer * edge;
        let slack = SLACK * buffer;
        let detector = team.pool().map_or_else(Detector::new, |pool| Detector::new().on_pool(pool));
        let search = Buffered::with_search(detector, buffer - slack)
            .map_err(|error| ModelError::Detection { message: error.to_string() })?;
        let mut contacts = Self {
            options: laws(model),
            joint_facets: model.joint_facets.clone(),
            materials,
            free: faces.vertices(topology),
            groups: vec![0; topology.vertices.len()],
            bare: vec![false; model.mesh.elements.len()],
            watched: vec![false; model.mesh.elements.len()],
            list: Vec::new(),
            search,
            buffer,
            slack,
            travel: 0.0,
            looked: f64::NEG_INFINITY,
            chosen: f64::NEG_INFINITY,
            couples: Vec::new(),
            histories: Vec::new(),
            pressed: std::array::from_fn(|_| {
                (0..ROUND * team.threads()).map(|_| ChunkForces::default()).collect()
            }),
            parted: Vec::new(),
            bared: Vec::new(),
            unwatched: true,
            detections: 0,
        };
        for vertex in 0..topology.vertex_count() as u32 {
            for (corner, group) in group(vertex, topology, |_| true) {
                contacts.groups[corner as usize] = group;
            }
        }
        contacts.bare_all(topology);
        Ok(contacts)
    }

    /// Memory of the properties of elements, bytes; without couples and without the search.
    pub(crate) fn bytes(&self) -> usize {
        let Self { joint_facets, free, groups, bare, watched, list, .. } = self;
        size_of_val(&**joint_facets)
            + size_of_val(&**free)
            + size_of_val(&**groups)
            + size_of_val(&**bare)
            + size_of_val(&**watched)
            + size_of_val(&**list)
    }

    /// Marks the elements at a free vertex as bare.
    fn bare_at(&mut self, vertex: u32, topology: &Topology<D, N>) {
        for &corner in topology.corners_of(vertex) {
            let element = corner as usize / N;
            if !self.bare[element] {
                self.bare[element] = true;
                self.bared.push(element as u32);
            }
        }
    }

    /// Marks the elements at all free vertices as bare, as they have been for long.
    fn bare_all(&mut self, topology: &Topology<D, N>) {
        for vertex in 0..self.free.len() as u32 {
            if self.free[vertex as usize] {
                self.bare_at(vertex, topology);
            }
        }
        self.bared.clear();
    }

    /// Registers joints that broke: their elements may touch from the next step on. Returns the vertices at
    /// which they are, ascending.
    pub(crate) fn part(
        &mut self,
        broken: &[u32],
        joints: &Joints<D>,
        topology: &Topology<D, N>,
        share: &Share,
    ) -> Vec<u32> {
        let mut vertices = Vec::new();
        for &joint in broken {
            let facet = &topology.facets[joints.all[joint as usize].facet as usize];
            vertices.extend(facet.corners[0].map(|corner| topology.vertices[corner as usize]));
            self.parted.push(facet.elements());
        }
        vertices.sort_unstable();
        vertices.dedup();
        for &vertex in &vertices {
            let groups = group(vertex, topology, |facet| joints.holds(facet));
            let owned: Vec<_> = groups.into_iter().filter(|(corner, _)| share.corner(*corner)).collect();
            self.divide(vertex, &owned, topology);
        }
        self.list_parted();
        vertices
    }

    /// Sets the groups of some corners of a vertex, which is free from now on.
    pub(crate) fn divide(&mut self, vertex: u32, groups: &[(u32, u32)], topology: &Topology<D, N>) {
        self.free[vertex as usize] = true;
        self.bare_at(vertex, topology);
        let corners = topology.corners_of(vertex);
        self.unwatched |= corners.iter().any(|&corner| !self.watched[corner as usize / N]);
        for (k, &(one, group)) in groups.iter().enumerate() {
            for &(other, another) in &groups[k + 1..] {
                if self.groups[one as usize] == self.groups[other as usize] && group != another {
                    self.parted.push([one / N as u32, other / N as u32]);
                }
            }
        }
        for &(corner, group) in groups {
            self.groups[corner as usize] = group;
        }
    }

    /// Orders the lists of elements that have separated or become bare.
    pub(crate) fn list_parted(&mut self) {
        self.parted.sort_unstable();
        // Elements that share a facet are listed for the facet and for all of its vertices.
        self.parted.dedup();
        self.bared.sort_unstable();
        self.bared.dedup();
    }

    /// Updates the couples as far as motion and broken joints require.
    pub(crate) fn detect(
        &mut self,
        solid: &Solid<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Result<(), Stop> {
        self.watch_bare(joints, topology);
        // Both elements of a couple may have travelled this far.
        if 2.0 * (self.travel - self.looked) > self.slack {
            self.look(solid, joints, topology, team)?;
            self.looked = self.travel;
        }
        self.add_parted(joints, topology, solid.share());
        self.add_bared();
        Ok(())
    }

    /// Watches all bare elements, and those beside them.
    pub(crate) fn watch_bare(&mut self, joints: &Joints<D>, topology: &Topology<D, N>) {
        if self.unwatched {
            self.watch(joints, topology);
            self.unwatched = false;
            self.looked = f64::NEG_INFINITY;
        }
    }

    /// Adds the distance of the fastest node in a step, m.
    pub(crate) fn note_motion(&mut self, distance: f64) {
        self.travel += distance;
    }

    /// Updates the search with the boxes of all watched elements.
    fn look(
        &mut self,
        solid: &Solid<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Result<(), Stop> {
        let list = &self.list;
        let bounds = |element: u32| {
            let [first, rest @ ..] = &solid.shape(element)[..] else { return ([0.0; D], [0.0; D]) };
            let (mut least, mut most) = (*first, *first);
            for corner in rest {
                for axis in 0..D {
                    least[axis] = least[axis].min(corner[axis]);
                    most[axis] = most[axis].max(corner[axis]);
                }
            }
            (least, most)
        };
        let [mut min, mut max] = [vec![[0.0; D]; list.len()], vec![[0.0; D]; list.len()]];
        team.change_both(&mut min, &mut max, |first, least, most| {
            for (k, (least, most)) in least.iter_mut().zip(most).enumerate() {
                (*least, *most) = bounds(list[first + k]);
            }
        });
        let update = self.search.update(&Boxes::boxes(&min, &max)?.with_tolerance(self.slack)?)?;
        self.detections += u64::from(update.redetected());
        // Couples that were not chosen must not touch before the next update.
        if update.redetected() || 2.0 * (self.travel - self.chosen) + self.slack > self.buffer {
            let (groups, candidates) = (&self.groups, update.candidates());
            let (travel, buffer) = (self.travel, self.buffer);
            let parted = &self.parted;
            let found = team.look(candidates.len(), |range| {
                let elements = |&Pair { i, j }: &Pair| [list[i as usize], list[j as usize]];
                let all = candidates[range].iter().map(elements);
                let acting = all.filter(|pair| pair.iter().any(|&element| solid.share().acts(element)));
                let couples = acting.filter_map(|pair| {
                    let is_new = parted.binary_search(&pair).is_ok();
                    couple(pair, is_new, groups, joints, topology)
                });
                couples.filter_map(|couple| near(couple, solid, travel, buffer)).collect::<Vec<_>>()
            });
            self.chosen = self.travel;
            let mut couples = Vec::with_capacity(found.iter().map(Vec::len).sum());
            couples.extend(found.into_iter().flatten());
            self.choose(couples);
        }
        Ok(())
    }

    /// Watches the elements at free vertices, and those beside them that can break: cracks reach these next.
    fn watch(&mut self, joints: &Joints<D>, topology: &Topology<D, N>) {
        let may_part = |element: usize| {
            topology.facet_of[element].iter().any(|&facet| facet != NONE && joints.may_part(facet))
        };
        let mut near = self.free.clone();
        for ring in 0..2 {
            let mut next = near.clone();
            for (element, watched) in self.watched.iter_mut().enumerate() {
                let vertices = &topology.vertices[N * element..N * element + N];
                let is_near = vertices.iter().any(|&vertex| near[vertex as usize]);
                if is_near && (ring == 0 || may_part(element)) {
                    *watched = true;
                    for &vertex in vertices {
                        next[vertex as usize] = true;
                    }
                }
            }
            near = next;
        }
        self.list_watched();
    }

    /// Lists the watched elements, ascending.
    fn list_watched(&mut self) {
        self.list.clear();
        self.list.extend((0..self.watched.len() as u32).filter(|&element| self.watched[element as usize]));
    }

    /// State of the contacts for a saved run.
    pub(crate) fn save(&self) -> SavedContacts<D, N> {
        // Couples that do not touch have no history. They are found again.
        SavedContacts {
            grips: self.touching().collect(),
            parted: self.parted.clone(),
            bared: self.bared.clone(),
        }
    }

    /// Restores the saved contacts. The joints must be restored before.
    pub(crate) fn restore(
        &mut self,
        saved: SavedContacts<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
    ) {
        let broken: Vec<u32> = (0..joints.all.len() as u32)
            .filter(|&joint| joints.all[joint as usize].state != JointState::Holding)
            .collect();
        self.part(&broken, joints, topology, &Share::default());
        self.restore_couples(saved);
    }

    /// Sets the groups of all corners, and which vertices are free.
    pub(crate) fn set_known(&mut self, groups: Vec<u32>, free: Vec<bool>, topology: &Topology<D, N>) {
        (self.groups, self.free) = (groups, free);
        self.bare_all(topology);
    }

    /// Restores the couples that touch, and the elements that have separated.
    pub(crate) fn restore_couples(&mut self, saved: SavedContacts<D, N>) {
        (self.parted, self.bared) = (saved.parted, saved.bared);
        self.list_parted();
        self.unwatched = true;
        let mut saved = saved.grips;
        saved.sort_unstable_by_key(|(elements, _)| *elements);
        self.couples =
            saved.iter().map(|&(elements, _)| Couple { touches: true, ..separate(elements) }).collect();
        self.group_grips(saved.into_iter().map(|(_, grip)| grip));
    }

    /// Forgets the forces of the last step: a resumed run has none before its first step.
    pub(crate) fn without_forces(saved: SavedContacts<D, N>) -> SavedContacts<D, N> {
        let grips = saved.grips.into_iter().map(|(elements, grip)| (elements, grip.without_push()));
        SavedContacts { grips: grips.collect(), ..saved }
    }

    /// The couples that touch, with their histories.
    pub(crate) fn touching(&self) -> impl Iterator<Item = ([u32; 2], Grip<D, N>)> {
        let chunks = self.couples.chunks(CHUNK).zip(&self.histories);
        chunks.flat_map(|(couples, histories)| {
            let touching = couples.iter().filter(|couple| couple.touches);
            touching.map(|couple| (couple.elements, histories.get(couple.slot)))
        })
    }

    /// The couples that touch, with the force on the first element of each, N.
    pub(crate) fn pushes(&self) -> impl Iterator<Item = ([u32; 2], Point<D>)> {
        self.touching().map(|(elements, grip)| (elements, grip.push))
    }

    /// Distributes the histories of the couples that touch, in their order, among the chunks of couples.
    fn group_grips(&mut self, grips: impl IntoIterator<Item = Grip<D, N>>) {
        let mut grips = grips.into_iter();
        let group = |couples: &mut [Couple]| {
            let count = couples.iter().filter(|couple| couple.touches).count();
            let mut histories = Histories::with_capacity(count);
            let touching = couples.iter_mut().enumerate().filter(|(_, couple)| couple.touches);
            for ((number, couple), grip) in touching.zip(&mut grips) {
                couple.slot = histories.give(number, &grip);
            }
            histories
        };
        self.histories = self.couples.chunks_mut(CHUNK).map(group).collect();
    }

    /// Replaces the couples by those that may touch now. Couples that were there before keep their history.
    fn choose(&mut self, mut couples: Vec<Couple>) {
        couples.sort_unstable_by_key(|couple| couple.elements);
        let grips: Vec<_> = self.touching().map(|(_, grip)| grip).collect();
        let mut grips = grips.into_iter();
        let before = std::mem::take(&mut self.couples);
        let mut before = before.into_iter().map(|known| {
            let grip = if known.touches { grips.next() } else { None };
            (known, grip)
        });
        let mut known = before.next();
        let mut kept = Vec::new();
        for couple in &mut couples {
            while known.as_ref().is_some_and(|(known, _)| known.elements < couple.elements) {
                known = before.next();
            }
            if let Some((known, grip)) = &known
                && known.elements == couple.elements
            {
                // The distance found now may be larger than the one found then.
                let apart_until = if !known.touches && !known.initial_overlap {
                    known.apart_until.max(couple.apart_until)
                } else {
                    known.apart_until
                };
                *couple = Couple { joint: couple.joint, apart_until, ..known.clone() };
                kept.extend(*grip);
            }
        }
        self.couples = couples;
        self.group_grips(kept);
    }

    /// Adds couples of elements that have separated.
    fn add_parted(&mut self, joints: &Joints<D>, topology: &Topology<D, N>, share: &Share) {
        let mut parted = std::mem::take(&mut self.parted);
        parted.retain(|pair| pair.iter().any(|&element| share.acts(element)));
        parted.retain(|pair| self.couples.binary_search_by_key(pair, |couple| couple.elements).is_err());
        let new = parted.into_iter().filter_map(|pair| couple(pair, true, &self.groups, joints, topology));
        let new: Vec<Couple> = new.collect();
        if !new.is_empty() {
            let grips: Vec<_> = self.touching().map(|(_, grip)| grip).collect();
            self.couples.extend(new);
            // A stable sort of two ascending runs is one merge.
            self.couples.sort_by_key(|couple| couple.elements);
            self.group_grips(grips);
        }
    }

    /// Notes the couples of elements that have become bare.
    fn add_bared(&mut self) {
        let bared = std::mem::take(&mut self.bared);
        if bared.is_empty() {
            return;
        }
        // Couples that are known to be apart do not overlap.
        let travel = self.travel;
        let near = |couple: &&mut Couple| !couple.touches && couple.apart_until <= travel;
        for couple in self.couples.iter_mut().filter(near) {
            couple.initial_overlap |=
                couple.elements.iter().any(|element| bared.binary_search(element).is_ok());
        }
    }

    /// Computes the forces of all couples, and adds them to those of their elements. `energy`: whether to
    /// compute the energy of the potentials.
    pub(crate) fn press(
        &mut self,
        solid: &mut Solid<D, N>,
        joints: &Joints<D>,
        step: f64,
        energy: bool,
        team: &Team,
    ) -> Touching {
        let mut all = Touching { energy: energy.then(Sum::default), ..Touching::default() };
        let Self {
            options: laws, materials, joint_facets, travel, bare, couples, histories, pressed, ..
        } = self;
        solid.with_forces(|solid, forces| {
            let pass = ContactPass {
                solid,
                joints,
                laws,
                materials: *materials,
                joint_facets,
                bare,
                step,
                travel: *travel,
            };
            let counting = (solid.share(), solid.grains);
            let [last, next] = pressed;
            let (round, mut done) = (next.len(), &[][..]);
            let rounds = couples.chunks_mut(round * CHUNK).zip(histories.chunks_mut(round));
            for (couples, histories) in rounds {
                team.both(
                    || all.take(done, last, counting, forces),
                    || {
                        team.change_chunks(couples, histories, next, |couples, histories, pressed| {
                            pass.press(couples, histories, pressed);
                        });
                    },
                );
                done = couples;
                std::mem::swap(last, next);
            }
            all.take(done, last, counting, forces);
        });
        all
    }

    /// Forces of the couples that touch, at the points where their elements overlap now.
    pub(crate) fn forces(&self, solid: &Solid<D, N>) -> Vec<ContactForce<D>> {
        let couples: Vec<[u32; 2]> = self.touching().map(|(elements, _)| elements).collect();
        let points = points(&couples, solid);
        let forces = self.touching().zip(points).map(|((elements, grip), point)| {
            let tangential = grip.friction;
            ContactForce { elements, point, normal: minus(grip.push, tangential), tangential }
        });
        forces.collect()
    }
}

/// Groups the corners of a vertex: elements are connected by the facets that `holds` accepts. Returns each
/// corner with the code of the first corner of its group.
fn group<const D: usize, const N: usize>(
    vertex: u32,
    topology: &Topology<D, N>,
    holds: impl Fn(u32) -> bool,
) -> Vec<(u32, u32)>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (corners, mut groups) = (topology.corners_of(vertex), Vec::new());
    topology.groups(vertex, holds, &mut groups);
    let label = |group: u32| topology.code_of_corner(corners[group as usize]);
    corners.iter().zip(groups).map(|(&corner, group)| (corner, label(group))).collect()
}

/// Lengths of the facets of all elements, as edges, m.
pub(crate) fn edges<const D: usize, const N: usize>(model: &Model<D, N>) -> impl Iterator<Item = f64>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    (0..model.mesh.elements.len()).flat_map(|element| {
        let corners = corners_of(&model.mesh, element);
        debug_assert!(corners.measure() > 0.0);
        <[[f64; D]; N]>::FACETS.map(|facet| {
            let measure = <[[f64; D]; N]>::facet_measure(&facet.map(|corner| corners[corner]));
            <[[f64; D]; N]>::facet_length(measure)
        })
    })
}

/// Mean length of the facets of all elements, as edges, m.
pub(crate) fn mean_edge<const D: usize, const N: usize>(model: &Model<D, N>) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    edges(model).sum::<f64>() / (N * model.mesh.elements.len().max(1)) as f64
}
