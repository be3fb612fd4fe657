//! Contacts between elements: which couples there are, and what they do to each other.
//!
//! Only elements near a free surface can touch another that they do not hang together with. Those within two rings of elements around a vertex that an outer edge or
//! a broken joint touches are *watched*: their boxes go to the detection, with a buffer, and when a crack comes to an element that is not watched, the set is made anew.

use fdem_contact::{Buffered, Couple as Pair, Detector, Elements as Boxes, Engine};
use serde::{Deserialize, Serialize};

use crate::error::{ModelError, Stop};
use crate::joints::{Joints, State};
use crate::model::Model;
use crate::potential::{Interaction, Point, Triangle, area_coordinates, cross, dot, interaction, minus};
use crate::solid::{Solid, height, triangle_of};
use crate::team::Team;
use crate::topology::{NONE, Topology};

/// Two elements that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Couple {
    pub(crate) elements: [u32; 2],
    /// The joint between the two, if there was one.
    joint: u32,
    /// On the corners of both: of potential, damping and friction.
    forces: [[Point; 3]; 2],
    pub(crate) grip: Grip,
    /// Has hung together until now, and may overlap already.
    born: bool,
    pub(crate) touches: bool,
    pub(crate) deep: bool,
    /// Since the last pass.
    works: Works,
}

/// Energy of a contact, and works since the last pass.
#[derive(Clone, Copy, Debug, Default)]
struct Works {
    energy: f64,
    friction: f64,
    damping: f64,
    handed_over: f64,
}

/// What a contact remembers of friction and damping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Grip {
    /// Friction on the first element.
    pub(crate) friction: Point,
    /// Damping on the first element.
    damping: Point,
    /// Shares of the corners in both: where it acted.
    shares: [[f64; 3]; 2],
    /// Potential energy that does not count: see [`count_from`].
    spared: f64,
}

impl Couple {
    fn new(elements: [u32; 2], joint: u32) -> Self {
        let grip = Grip::default();
        Self {
            elements,
            joint,
            forces: [[[0.0; 2]; 3]; 2],
            grip,
            born: false,
            touches: false,
            deep: false,
            works: Works::default(),
        }
    }
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
    boxes: [Vec<[f64; 2]>; 2],
    search: Buffered<f64, 2>,
    /// All couples of boxes at the last detection, without those that can never touch.
    candidates: Vec<[u32; 2]>,
    /// Those that may touch as joints are now, ascending.
    pub(crate) couples: Vec<Couple>,
    /// For each watched element its couples, as twice their number and 1 for the second of the two.
    entries: Vec<u32>,
    /// Joints have broken since the couples were chosen.
    outdated: bool,
    /// An element on a free surface is not watched.
    unwatched: bool,
    pub(crate) detections: u64,
}

/// How elements of two materials touch.
#[derive(Clone, Copy, Debug)]
struct Law {
    /// Pa times thickness.
    penalty: f64,
    friction: f64,
    /// N/m.
    tangential: f64,
    /// Share of critical.
    damping: f64,
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
        let search = Detector::new(Engine::Auto)
            .with_threads(threads)
            .and_then(|detector| Buffered::with_search(detector, model.contact.buffer * mean_edge(model)))
            .map_err(|error| ModelError::Threads { message: error.to_string() })?;
        let mut contacts = Self {
            options,
            materials,
            free: topology.outer_vertices(),
            groups: vec![0; topology.vertices.len()],
            watched: vec![false; model.mesh.triangles.len()],
            list: Vec::new(),
            boxes: [Vec::new(), Vec::new()],
            search,
            candidates: Vec::new(),
            couples: Vec::new(),
            entries: Vec::new(),
            outdated: true,
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
                self.group(vertex, topology, |edge| {
                    joints
                        .all
                        .get(joints.of_edge[edge as usize] as usize)
                        .is_none_or(|joint| joint.state == State::Holding)
                });
                self.free[vertex as usize] = true;
                self.unwatched |=
                    topology.corners_of(vertex).iter().any(|&corner| !self.watched[corner as usize / 3]);
            }
            self.outdated = true;
        }
    }

    /// Finds the couples, again if need be.
    pub(crate) fn detect(
        &mut self,
        solid: &mut Solid,
        joints: &Joints,
        topology: &Topology,
        team: &Team,
    ) -> Result<(), Stop> {
        if self.unwatched {
            self.watch(topology);
            self.unwatched = false;
        }
        let list = &self.list;
        let [min, max] = &mut self.boxes;
        let bounds = |element: u32| {
            let [a, b, c] = solid.triangle(element);
            let least = |axis: usize| a[axis].min(b[axis]).min(c[axis]);
            let most = |axis: usize| a[axis].max(b[axis]).max(c[axis]);
            ([least(0), least(1)], [most(0), most(1)])
        };
        min.resize(list.len(), [0.0; 2]);
        max.resize(list.len(), [0.0; 2]);
        team.change_both(min, max, |first, least, most| {
            for (k, (least, most)) in least.iter_mut().zip(most).enumerate() {
                (*least, *most) = bounds(list[first + k]);
            }
        });
        let update = self.search.update(&Boxes::boxes(min, max)?)?;
        if update.redetected() {
            self.detections += 1;
            self.candidates.clear();
            self.candidates.extend(
                update
                    .candidates()
                    .iter()
                    .map(|&Pair { i, j }| [list[i as usize], list[j as usize]])
                    .filter(|&pair| may_ever_touch(pair, joints, topology)),
            );
            self.candidates.sort_unstable();
            self.outdated = true;
        }
        if self.outdated {
            self.choose(solid, joints, topology);
            self.outdated = false;
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
        let all = self.couples.iter();
        Saved {
            watched: self.watched.clone(),
            grips: all
                .clone()
                .filter(|couple| couple.touches)
                .map(|couple| (couple.elements, couple.grip))
                .collect(),
            apart: all.filter(|couple| !couple.touches).map(|couple| couple.elements).collect(),
        }
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
        let touching = saved.grips.into_iter().map(|(elements, grip)| Couple {
            grip,
            touches: true,
            ..Couple::new(elements, NONE)
        });
        self.couples =
            touching.chain(saved.apart.into_iter().map(|elements| Couple::new(elements, NONE))).collect();
        self.couples.sort_unstable_by_key(|couple| couple.elements);
        Ok(())
    }

    /// The candidates that may touch now; those that did keep what they remember.
    fn choose(&mut self, solid: &mut Solid, joints: &Joints, topology: &Topology) {
        let mut before = std::mem::take(&mut self.couples).into_iter().peekable();
        for &elements in &self.candidates {
            let mut born = false;
            let joint = match relation(elements, topology) {
                Relation::Apart => NONE,
                Relation::Edge(edge) => {
                    let joint = joints.of_edge[edge as usize];
                    if joints.all.get(joint as usize).is_none_or(|joint| joint.state == State::Holding) {
                        continue;
                    }
                    joint
                }
                Relation::Vertex(corners) => {
                    if self.groups[corners[0] as usize] == self.groups[corners[1] as usize] {
                        continue;
                    }
                    born = true;
                    NONE
                }
            };
            while before.next_if(|couple| couple.elements < elements).is_some() {}
            self.couples.push(match before.next_if(|couple| couple.elements == elements) {
                Some(known) => Couple { joint, forces: [[[0.0; 2]; 3]; 2], ..known },
                None => Couple { born, ..Couple::new(elements, joint) },
            });
        }
        // Couples side by side for each element, in their order.
        for element in &mut solid.elements {
            element.contacts = [0; 2];
        }
        for couple in &self.couples {
            for element in couple.elements {
                solid.elements[element as usize].contacts[1] += 1;
            }
        }
        let mut total = 0;
        for &element in &self.list {
            let [first, end] = &mut solid.elements[element as usize].contacts;
            let count = *end;
            (*first, *end) = (total, total);
            total += count;
        }
        self.entries.clear();
        self.entries.resize(total as usize, 0);
        for (number, couple) in self.couples.iter().enumerate() {
            for (side, element) in couple.elements.into_iter().enumerate() {
                let end = &mut solid.elements[element as usize].contacts[1];
                self.entries[*end as usize] = (2 * number + side) as u32;
                *end += 1;
            }
        }
    }

    /// Forces of all couples.
    pub(crate) fn press(&mut self, solid: &Solid, joints: &Joints, step: f64, team: &Team) -> Touching {
        let (options, materials) = (&self.options, self.materials);
        team.change(&mut self.couples, |_, chunk| {
            for couple in chunk {
                let pair = couple.elements.map(|element| &solid.elements[element as usize]);
                let law = &options[pair[0].material as usize * materials + pair[1].material as usize];
                let joint = joints.all.get(couple.joint as usize);
                let share = joint.map_or([1.0, 0.0], |joint| [joint.faded, joint.fading]);
                couple.works = press(couple, solid, law, share, step);
            }
        });
        // One after the other: chunks would depend on how many couples there are that do not touch, which a run that was resumed may have other ones of.
        let mut all = Touching::default();
        for couple in &self.couples {
            all.energy += couple.works.energy;
            all.friction += couple.works.friction;
            all.damping += couple.works.damping;
            all.handed_over += couple.works.handed_over;
            if couple.touches {
                all.count += 1;
                all.deep = all.deep.or(couple.deep.then_some(couple.elements[0]));
            }
        }
        all
    }

    /// The force of the contacts on a corner of an element.
    #[inline]
    pub(crate) fn add_force(&self, [first, end]: [u32; 2], corner: usize, force: &mut Point) {
        for &entry in &self.entries[first as usize..end as usize] {
            let couple = &self.couples[entry as usize / 2];
            if couple.touches {
                let [x, y] = couple.forces[entry as usize % 2][corner];
                force[0] += x;
                force[1] += y;
            }
        }
    }
}

/// Forces of one couple, of which a share counts; and how much more than in the last step.
fn press(couple: &mut Couple, solid: &Solid, law: &Law, [weight, fading]: [f64; 2], step: f64) -> Works {
    let mut sum = Works::default();
    let [a, b] = couple.elements.map(|element| solid.triangle(element));
    let found = if weight > 0.0 && boxes_meet(&a, &b) { interaction(&a, &b) } else { None };
    // What the last friction did in the second half of its step.
    let before = couple.grip;
    if couple.touches {
        let rate = relative_velocity(couple.elements, &before.shares, solid);
        sum.friction -= 0.5 * step * dot(before.friction, rate);
        sum.damping -= 0.5 * step * dot(before.damping, rate);
    }
    let Some(Interaction { mut forces, energy, point, deep }) = found else {
        (couple.touches, couple.born, couple.deep) = (false, false, false);
        couple.grip = Grip::default();
        return sum;
    };
    let potential = law.penalty * energy;
    let spared = if couple.born { potential } else { before.spared.min(potential) };
    couple.born = false;
    let (energy, slope) = count_from(spared, potential);
    let scale = law.penalty * weight * slope;
    for force in forces.iter_mut().flatten().flatten() {
        *force *= scale;
    }
    sum.energy += weight * energy;
    sum.handed_over += fading * energy;
    couple.deep = deep;
    let mut grip = Grip { spared, ..Grip::default() };
    if law.friction > 0.0 || law.damping > 0.0 {
        grip.shares = [area_coordinates(&a, point), area_coordinates(&b, point)];
        let push = forces[0].iter().fold([0.0; 2], |sum, force| [sum[0] + force[0], sum[1] + force[1]]);
        let size = push[0].hypot(push[1]);
        if size > 0.0 {
            let normal = [push[0] / size, push[1] / size];
            let tangent = [-normal[1], normal[0]];
            let rate = relative_velocity(couple.elements, &grip.shares, solid);
            let mut pressed = size;
            if law.damping > 0.0 {
                let [m, n] = couple.elements.map(|element| mass(solid, element));
                let critical = 2.0 * (law.penalty * m * n / (m + n)).sqrt();
                // Never more than what presses the two apart, so that nothing sticks.
                let damping = (-law.damping * weight * critical * dot(rate, normal)).clamp(-size, size);
                grip.damping = normal.map(|n| damping * n);
                pressed += damping;
            }
            if law.friction > 0.0 {
                let limit = law.friction * pressed;
                let held = if couple.touches { dot(before.friction, tangent) } else { 0.0 };
                let trial = held - weight * law.tangential * step * dot(rate, tangent);
                let friction = trial.clamp(-limit, limit);
                grip.friction = tangent.map(|t| friction * t);
            }
            sum.friction -= 0.5 * step * dot(grip.friction, rate);
            sum.damping -= 0.5 * step * dot(grip.damping, rate);
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                for corner in 0..3 {
                    let share = sign * grip.shares[side][corner];
                    for axis in 0..2 {
                        forces[side][corner][axis] += share * (grip.friction[axis] + grip.damping[axis]);
                    }
                }
            }
        }
    }
    couple.grip = grip;
    couple.touches = true;
    couple.forces = forces;
    sum
}

/// What counts of a potential energy, and its derivative, if `spared` was there before the two elements could touch.
///
/// Elements that hung together until a joint at their vertex broke overlap by what that joint has slid. To count this overlap at once would give them energy from
/// nothing. `(U - U₀)² / U` begins without energy and without force and soon is `U`; what they give up of the overlap is spared no longer.
fn count_from(spared: f64, potential: f64) -> (f64, f64) {
    if potential <= spared {
        return (0.0, 0.0);
    }
    let share = spared / potential;
    (potential * (1.0 - share) * (1.0 - share), 1.0 - share * share)
}

/// Of the first element against the second, where these shares of their corners are.
fn relative_velocity(elements: [u32; 2], shares: &[[f64; 3]; 2], solid: &Solid) -> Point {
    let mut rate = [0.0; 2];
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        for corner in 0..3 {
            let node = solid.elements[elements[side] as usize].nodes[corner];
            let velocity = solid.nodes[node as usize].velocity;
            for axis in 0..2 {
                rate[axis] += sign * shares[side][corner] * velocity[axis];
            }
        }
    }
    rate
}

/// Of the nodes of an element, without what others share of them.
fn mass(solid: &Solid, element: u32) -> f64 {
    solid.elements[element as usize].nodes.iter().map(|&node| solid.nodes[node as usize].mass / 3.0).sum()
}

#[inline]
fn boxes_meet(a: &Triangle, b: &Triangle) -> bool {
    (0..2).all(|axis| {
        let [a, b] = [a, b].map(|t| {
            let [p, q, r] = [t[0][axis], t[1][axis], t[2][axis]];
            [p.min(q).min(r), p.max(q).max(r)]
        });
        a[0] < b[1] && b[0] < a[1]
    })
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

/// Elements with a common edge that cannot part never do; others may.
fn may_ever_touch(pair: [u32; 2], joints: &Joints, topology: &Topology) -> bool {
    match relation(pair, topology) {
        Relation::Edge(edge) => joints.may_part(edge),
        Relation::Vertex(_) | Relation::Apart => true,
    }
}

fn law(model: &Model, a: u32, b: u32) -> Law {
    let interface = model.interface(a, b);
    let [one, two] = [a, b].map(|material| &model.materials[material as usize]);
    let penalty = interface
        .and_then(|interface| interface.penalty)
        .unwrap_or(model.contact.penalty * one.youngs_modulus.min(two.youngs_modulus))
        * model.thickness;
    let friction = interface.map_or(one.friction.min(two.friction), |interface| interface.friction);
    Law {
        penalty,
        friction,
        tangential: model.contact.tangential_stiffness * penalty,
        damping: model.contact.damping,
    }
}

/// Stiffness of a contact over an edge of an element of this material at either of its ends, N/m: an upper bound.
pub(crate) fn stiffness(model: &Model, triangle: &Triangle, k: usize, material: u32) -> f64 {
    let penalty = (0..model.materials.len() as u32)
        .map(|other| law(model, material, other).penalty)
        .fold(0.0_f64, f64::max);
    let edge = minus(triangle[(k + 1) % 3], triangle[k]);
    // φ grows by 3 over the height; half of the edge's pressure goes to an end; each of the two presses the other.
    let normal = 3.0 * penalty / height(triangle, k) * 0.5 * edge[0].hypot(edge[1]);
    2.0 * normal.max(model.contact.tangential_stiffness * penalty)
}

/// Of all edges of elements.
pub(crate) fn mean_edge(model: &Model) -> f64 {
    let mesh = &model.mesh;
    let mut sum = 0.0;
    for element in 0..mesh.triangles.len() {
        let triangle = triangle_of(mesh, element);
        for k in 0..3 {
            let edge = minus(triangle[(k + 1) % 3], triangle[k]);
            sum += edge[0].hypot(edge[1]);
        }
        debug_assert!(cross(minus(triangle[1], triangle[0]), minus(triangle[2], triangle[0])) > 0.0);
    }
    sum / (3 * mesh.triangles.len().max(1)) as f64
}
