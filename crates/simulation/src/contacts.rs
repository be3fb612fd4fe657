//! Contacts between elements: which couples there are, and what they do to each other.
//!
//! Only elements near a free surface can touch another that they do not hang together with. Those within two rings of elements around a vertex that an outer edge or
//! a broken joint touches are *watched*: their boxes go to the detection, with a buffer, and when a crack comes to an element that is not watched, the set is made anew.
//! The search looks only when something may have come as far as a part of the buffer, and a couple that does not touch sleeps until nodes may have come half as far as the two
//! are apart. Both bounds add up the speed of the fastest node, so that no contact is late.

mod forces;

use fdem_contact::{Buffered, Couple as Pair, Detector, Elements as Boxes, Engine};
use serde::{Deserialize, Serialize};

use crate::contacts::forces::{Contact, Grip, Law, law, press};
pub(crate) use crate::contacts::forces::{penalty_and_friction, stiffness};
use crate::error::{ModelError, Stop};
use crate::forces::ContactForce;
use crate::joints::{Joints, State};
use crate::model::Model;
use crate::potential::{Point, cross, length, minus};
use crate::solid::{Solid, triangle_of};
use crate::team::Team;
use crate::topology::{NONE, Topology};

/// Part of the buffer that is kept for the steps in which nobody looks where the elements are.
const SLACK: f64 = 0.25;

/// Two elements that may touch.
#[derive(Debug)]
pub(crate) struct Couple {
    elements: [u32; 2],
    /// The joint between the two, if there was one.
    joint: u32,
    /// Has hung together until now, and may overlap already.
    born: bool,
    /// The two do not touch before nodes have travelled as far, m.
    apart_until: f64,
    /// Most couples do not touch.
    contact: Option<Box<Contact>>,
}

/// What contacts have of a run, to be saved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Saved {
    watched: Vec<bool>,
    /// Couples that touch, and what they remember.
    grips: Vec<([u32; 2], Grip)>,
    /// Couples that could touch but do not.
    apart: Vec<[u32; 2]>,
}

/// Elements that may touch, and how they are found.
#[derive(Debug)]
pub(crate) struct Contacts {
    options: Vec<Law>,
    materials: usize,
    /// Whether a vertex is on a free surface.
    free: Vec<bool>,
    /// Place of each corner's group among those of its vertex: elements of one group hang together there.
    groups: Vec<u32>,
    /// Whether an element is watched.
    pub(crate) watched: Vec<bool>,
    list: Vec<u32>,
    search: Buffered<f64, 2>,
    /// All couples with a smaller gap are among the candidates whenever the search has looked, m.
    slack: f64,
    /// How far a node may have come in all steps so far, m, and what this was when the search looked last.
    travel: f64,
    looked: f64,
    /// Those that may touch as joints are now, ascending.
    couples: Vec<Couple>,
    /// Of each element the couples, as twice their number and 1 for the second of the two: the slices between `first` of it and of the next one.
    entries: Vec<u32>,
    first: Vec<u32>,
    /// Elements that have come apart since the couples were listed: at a vertex, or along an edge.
    parted: Vec<[u32; 2]>,
    /// An element on a free surface is not watched.
    unwatched: bool,
    pub(crate) detections: u64,
}

/// What a pass over the couples found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Touching {
    /// Stored in the potentials.
    pub(crate) energy: f64,
    /// Work against friction since the last pass.
    pub(crate) friction: f64,
    /// Dissipated by damping since the last pass.
    pub(crate) damping: f64,
    /// Energy of potentials that joints have handed over since the last pass.
    pub(crate) handed_over: f64,
    /// Couples that overlap.
    pub(crate) count: usize,
    /// The first element that is penetrated to its centroid.
    pub(crate) deep: Option<u32>,
}

impl Contacts {
    pub(crate) fn new(model: &Model, topology: &Topology, threads: usize) -> Result<Self, ModelError> {
        let materials = model.materials.len();
        let options = (0..materials * materials)
            .map(|k| law(model, (k / materials) as u32, (k % materials) as u32))
            .collect();
        let buffer = model.contact.buffer * mean_edge(model);
        let slack = SLACK * buffer;
        let search = Detector::new(Engine::Auto)
            .with_threads(threads)
            .and_then(|detector| Buffered::with_search(detector, buffer - slack))
            .map_err(|error| ModelError::Threads { message: error.to_string() })?;
        let mut contacts = Self {
            options,
            materials,
            free: topology.outer_vertices(),
            groups: vec![0; topology.vertices.len()],
            watched: vec![false; model.mesh.triangles.len()],
            list: Vec::new(),
            search,
            slack,
            travel: 0.0,
            looked: f64::NEG_INFINITY,
            couples: Vec::new(),
            entries: Vec::new(),
            first: vec![0; model.mesh.triangles.len() + 1],
            parted: Vec::new(),
            unwatched: true,
            detections: 0,
        };
        for vertex in 0..topology.vertex_count() as u32 {
            contacts.group(vertex, topology, |_| true);
        }
        Ok(contacts)
    }

    /// Groups the corners of a vertex by the edges that hold.
    fn group(&mut self, vertex: u32, topology: &Topology, holds: impl Fn(u32) -> bool) {
        let mut groups = Vec::new();
        topology.groups(vertex, holds, &mut groups);
        for (&corner, group) in topology.corners_of(vertex).iter().zip(groups) {
            self.groups[corner as usize] = group;
        }
    }

    /// Notes joints that broke: their elements may touch.
    pub(crate) fn part(&mut self, broken: &[u32], joints: &Joints, topology: &Topology) {
        for &joint in broken {
            let edge = &topology.edges[joints.all[joint as usize].edge as usize];
            for corner in edge.corners[0] {
                let vertex = topology.vertices[corner as usize];
                let corners = topology.corners_of(vertex);
                let before: Vec<u32> = corners.iter().map(|&corner| self.groups[corner as usize]).collect();
                self.group(vertex, topology, |edge| {
                    joints
                        .all
                        .get(joints.of_edge[edge as usize] as usize)
                        .is_none_or(|joint| joint.state == State::Holding)
                });
                self.free[vertex as usize] = true;
                self.unwatched |= corners.iter().any(|&corner| !self.watched[corner as usize / 3]);
                for (k, &one) in corners.iter().enumerate() {
                    for (l, &other) in corners.iter().enumerate().skip(k + 1) {
                        let [a, b] = [one, other].map(|corner| self.groups[corner as usize]);
                        if before[k] == before[l] && a != b {
                            self.parted.push([one / 3, other / 3]);
                        }
                    }
                }
            }
            self.parted.push(edge.elements());
        }
    }

    /// Finds the couples, again if need be.
    pub(crate) fn detect(
        &mut self,
        solid: &Solid,
        joints: &Joints,
        topology: &Topology,
        team: &Team,
    ) -> Result<(), Stop> {
        if self.unwatched {
            self.watch(topology);
            self.unwatched = false;
            self.looked = f64::NEG_INFINITY;
        }
        // Both of a couple may have come this far.
        if 2.0 * (self.travel - self.looked) > self.slack {
            self.look(solid, joints, topology, team)?;
            self.looked = self.travel;
        }
        self.add_parted(joints, topology);
        Ok(())
    }

    /// Notes that no node has moved farther than this in a step, m.
    pub(crate) fn note_motion(&mut self, distance: f64) {
        self.travel += distance;
    }

    /// Shows the boxes of all watched elements to the search.
    fn look(&mut self, solid: &Solid, joints: &Joints, topology: &Topology, team: &Team) -> Result<(), Stop> {
        let list = &self.list;
        let bounds = |element: u32| {
            let [a, b, c] = solid.triangle(element);
            let least = |axis: usize| a[axis].min(b[axis]).min(c[axis]);
            let most = |axis: usize| a[axis].max(b[axis]).max(c[axis]);
            ([least(0), least(1)], [most(0), most(1)])
        };
        let [mut min, mut max] = [vec![[0.0; 2]; list.len()], vec![[0.0; 2]; list.len()]];
        team.change_both(&mut min, &mut max, |first, least, most| {
            for (k, (least, most)) in least.iter_mut().zip(most).enumerate() {
                (*least, *most) = bounds(list[first + k]);
            }
        });
        let update = self.search.update(&Boxes::boxes(&min, &max)?.with_tolerance(self.slack)?)?;
        if update.redetected() {
            self.detections += 1;
            let (groups, candidates) = (&self.groups, update.candidates());
            let found = team.look(candidates.len(), |range| {
                let elements = |&Pair { i, j }: &Pair| [list[i as usize], list[j as usize]];
                let all = candidates[range].iter().map(elements);
                all.filter_map(|pair| couple(pair, groups, joints, topology)).collect::<Vec<_>>()
            });
            let mut couples = Vec::with_capacity(found.iter().map(Vec::len).sum());
            couples.extend(found.into_iter().flatten());
            self.choose(couples);
        }
        Ok(())
    }

    /// Elements within two rings of a free surface.
    fn watch(&mut self, topology: &Topology) {
        let mut near = self.free.clone();
        for _ in 0..2 {
            let mut next = near.clone();
            for (element, watched) in self.watched.iter_mut().enumerate() {
                let vertices = &topology.vertices[3 * element..3 * element + 3];
                if vertices.iter().any(|&vertex| near[vertex as usize]) {
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

    /// The list of the elements that are watched, ascending.
    fn list_watched(&mut self) {
        self.list.clear();
        self.list.extend((0..self.watched.len() as u32).filter(|&element| self.watched[element as usize]));
    }

    /// What is saved of contacts.
    pub(crate) fn save(&self) -> Saved {
        let (mut grips, mut apart) = (Vec::new(), Vec::new());
        for couple in &self.couples {
            match &couple.contact {
                Some(contact) if contact.touches => grips.push((couple.elements, contact.grip)),
                _ => apart.push(couple.elements),
            }
        }
        Saved { watched: self.watched.clone(), grips, apart }
    }

    /// Contacts as they were saved. Joints are restored already.
    pub(crate) fn restore(
        &mut self,
        saved: Saved,
        joints: &Joints,
        topology: &Topology,
    ) -> Result<(), ModelError> {
        let (found, expected) = (saved.watched.len(), self.watched.len());
        if found != expected {
            return Err(ModelError::Length { what: "watched elements", found, expected });
        }
        let broken: Vec<u32> = (0..joints.all.len() as u32)
            .filter(|&joint| joints.all[joint as usize].state != State::Holding)
            .collect();
        self.part(&broken, joints, topology);
        self.watched = saved.watched;
        self.list_watched();
        self.unwatched = self.list.is_empty();
        let couple = |elements, contact| Couple { contact, ..apart(elements) };
        self.couples = saved.apart.into_iter().map(|elements| couple(elements, None)).collect();
        self.couples.extend(saved.grips.into_iter().map(|(elements, grip)| {
            let contact = Contact { grip, touches: true, ..Contact::default() };
            couple(elements, Some(Box::new(contact)))
        }));
        self.couples.sort_unstable_by_key(|couple| couple.elements);
        Ok(())
    }

    /// Takes these couples, which may touch now; those that did keep what they remember.
    fn choose(&mut self, mut couples: Vec<Couple>) {
        couples.sort_unstable_by_key(|couple| couple.elements);
        let mut before = std::mem::take(&mut self.couples).into_iter().peekable();
        for couple in &mut couples {
            while before.next_if(|known| known.elements < couple.elements).is_some() {}
            if let Some(known) = before.next_if(|known| known.elements == couple.elements) {
                *couple = Couple { joint: couple.joint, ..known };
            }
        }
        self.couples = couples;
        self.parted.clear();
        self.list_couples();
    }

    /// Adds what may touch since elements have come apart.
    fn add_parted(&mut self, joints: &Joints, topology: &Topology) {
        let mut parted = std::mem::take(&mut self.parted);
        parted.retain(|pair| self.couples.binary_search_by_key(pair, |couple| couple.elements).is_err());
        parted.sort_unstable();
        // Two that share an edge were found at both of its ends.
        parted.dedup();
        let new = parted.into_iter().filter_map(|pair| couple(pair, &self.groups, joints, topology));
        let count = self.couples.len();
        self.couples.extend(new);
        if self.couples.len() > count {
            // Stable sorting of two ascending runs is one merge.
            self.couples.sort_by_key(|couple| couple.elements);
            self.list_couples();
        }
    }

    /// The couples of each element, side by side in their order.
    fn list_couples(&mut self) {
        // Counted, then put in.
        let first = &mut self.first;
        first.fill(0);
        for element in self.couples.iter().flat_map(|couple| couple.elements) {
            first[element as usize + 1] += 1;
        }
        for element in 1..first.len() {
            first[element] += first[element - 1];
        }
        self.entries.resize(2 * self.couples.len(), 0);
        for (number, couple) in self.couples.iter().enumerate() {
            for (side, element) in couple.elements.into_iter().enumerate() {
                let next = &mut first[element as usize];
                self.entries[*next as usize] = (2 * number + side) as u32;
                *next += 1;
            }
        }
        // Each stands at the end of its slice now, where the next one begins.
        first.rotate_right(1);
        first[0] = 0;
    }

    /// Forces of all couples.
    pub(crate) fn press(&mut self, solid: &Solid, joints: &Joints, step: f64, team: &Team) -> Touching {
        let (options, materials, travel) = (&self.options, self.materials, self.travel);
        team.change(&mut self.couples, |_, couples| {
            for couple in couples {
                if couple.apart_until > travel {
                    continue;
                }
                let pair = couple.elements.map(|element| &solid.elements[element as usize]);
                let law = &options[pair[0].material as usize * materials + pair[1].material as usize];
                let joint = joints.all.get(couple.joint as usize);
                // What overlaps behind a joint that has gone astray was never pressed by it.
                couple.born |= joint.is_some_and(|joint| joint.fading > 0.0 && joint.astray != [false; 2]);
                let share = joint.map_or([1.0, 0.0], |joint| [joint.faded, joint.fading]);
                press(couple, solid, law, share, step, travel);
            }
        });
        // One after the other: chunks would depend on how many couples there are that do not touch, which a run that was resumed may have other ones of.
        let mut all = Touching::default();
        for couple in &self.couples {
            let Some(contact) = &couple.contact else { continue };
            all.energy += contact.works.energy;
            all.friction += contact.works.friction;
            all.damping += contact.works.damping;
            all.handed_over += contact.works.handed_over;
            all.count += usize::from(contact.touches);
            all.deep = all.deep.or(contact.deep.then_some(couple.elements[0]));
        }
        all
    }

    /// Forces of the couples that touch.
    pub(crate) fn forces(&self, solid: &Solid) -> Vec<ContactForce> {
        let touching = |couple: &Couple| {
            let contact = couple.contact.as_ref().filter(|contact| contact.touches)?;
            Some(contact.force(couple.elements, solid))
        };
        self.couples.iter().filter_map(touching).collect()
    }

    /// The force of the contacts on a corner of an element.
    #[inline]
    pub(crate) fn add_force(&self, corner: u32, force: &mut Point) {
        let element = corner as usize / 3;
        for &entry in &self.entries[self.first[element] as usize..self.first[element + 1] as usize] {
            if let Some(contact) = &self.couples[entry as usize / 2].contact {
                let [x, y] = contact.forces[entry as usize % 2][corner as usize % 3];
                force[0] += x;
                force[1] += y;
            }
        }
    }
}

/// How two elements lie in the undeformed mesh.
enum Relation {
    Apart,
    /// A vertex in common: a corner of each there.
    Vertex([u32; 2]),
    /// An edge in common.
    Edge(u32),
}

fn relation([a, b]: [u32; 2], topology: &Topology) -> Relation {
    let edges = |element: u32| topology.edge_of[element as usize];
    if let Some(edge) = edges(a).into_iter().find(|&edge| edge != NONE && edges(b).contains(&edge)) {
        return Relation::Edge(edge);
    }
    let corners = |element: u32| 3 * element..3 * element + 3;
    for p in corners(a) {
        for q in corners(b) {
            if topology.vertices[p as usize] == topology.vertices[q as usize] {
                return Relation::Vertex([p, q]);
            }
        }
    }
    Relation::Apart
}

/// A couple of two elements that were never together.
fn apart(elements: [u32; 2]) -> Couple {
    Couple { elements, joint: NONE, born: false, apart_until: 0.0, contact: None }
}

/// A new couple of two elements, if they may touch as joints are now.
fn couple(elements: [u32; 2], groups: &[u32], joints: &Joints, topology: &Topology) -> Option<Couple> {
    let couple = apart(elements);
    match relation(elements, topology) {
        Relation::Apart => Some(couple),
        Relation::Edge(edge) => {
            let joint = joints.of_edge[edge as usize];
            let broken = joints.all.get(joint as usize).is_some_and(|joint| joint.state != State::Holding);
            broken.then_some(Couple { joint, ..couple })
        }
        Relation::Vertex([a, b]) => {
            let parted = groups[a as usize] != groups[b as usize];
            parted.then_some(Couple { born: true, ..couple })
        }
    }
}

/// Of all edges of elements.
pub(crate) fn mean_edge(model: &Model) -> f64 {
    let mesh = &model.mesh;
    let mut sum = 0.0;
    for element in 0..mesh.triangles.len() {
        let triangle = triangle_of(mesh, element);
        for k in 0..3 {
            let edge = minus(triangle[(k + 1) % 3], triangle[k]);
            sum += length(edge);
        }
        debug_assert!(cross(minus(triangle[1], triangle[0]), minus(triangle[2], triangle[0])) > 0.0);
    }
    sum / (3 * mesh.triangles.len().max(1)) as f64
}
