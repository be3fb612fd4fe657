//! Joints between elements: which edges may part, when they do, and what holds them until they are broken.
//!
//! A joint acts between the two nodes at either end of its edge, each end for half of it (Newton-Cotes). As long as the two nodes at an end are one, that end cannot open
//! and is left out: an edge that reaches its strength within whole material opens when a second one at the same vertex does, which is how cracks begin and end.
//!
//! A joint that is put in under load (adaptive insertion) begins with the traction that the two elements carry, so that nothing is released.

use serde::{Deserialize, Serialize};

use crate::cohesive::{Law, Memory, reaches};
use crate::error::ModelError;
use crate::model::{Insertion, Model, Strength};
use crate::potential::{Point, dot, minus};
use crate::random;
use crate::solid::{Solid, height, triangle_of};
use crate::team::Team;
use crate::topology::{Edge, NONE, Topology};

/// Sliding of a broken joint over its length at which it begins to leave the two elements to contact, and at which it is done.
const FADE: [f64; 2] = [0.1, 0.3];

/// What becomes of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum State {
    /// Elastic or softening.
    Holding,
    /// Presses and rubs only.
    Broken,
    /// Has left the two elements to contact.
    Gone,
}

/// An edge that may part.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Joint {
    pub(crate) edge: u32,
    pub(crate) state: State,
    #[serde(skip, default = "Joint::no_law")]
    pub(crate) law: Law,
    /// Of the undeformed edge.
    #[serde(skip)]
    pub(crate) length: f64,
    pub(crate) ends: [Memory; 2],
    /// The nodes at an end are two.
    pub(crate) open: [bool; 2],
    /// On side 0 at each end; side 1 has the opposite.
    pub(crate) forces: [Point; 2],
    /// Mean opening and sliding.
    pub(crate) opening: [f64; 2],
    /// Share that has been left to contact.
    pub(crate) faded: f64,
    /// When it broke.
    pub(crate) time: f64,
    /// Shares of opening and sliding in the damage when it broke.
    pub(crate) modes: [f64; 2],
}

impl Joint {
    fn no_law() -> Law {
        Law { penalty: 0.0, tensile: 0.0, cohesion: 0.0, friction: 0.0, critical: [1.0; 2] }
    }

    /// The mean of its ends.
    pub(crate) fn damage(&self) -> f64 {
        if self.state == State::Holding {
            0.5 * self.ends.iter().map(|end| end.damage(&self.law)).sum::<f64>()
        } else {
            1.0
        }
    }
}

/// All joints of a model, there or to come.
#[derive(Debug)]
pub(crate) struct Joints {
    pub(crate) all: Vec<Joint>,
    /// The joint of each edge, or [`NONE`].
    pub(crate) of_edge: Vec<u32>,
    /// What may break each edge: a number among `strengths`, or [`NONE`].
    class: Vec<u32>,
    strengths: Vec<Strength>,
    /// Factor of the strengths of each edge; empty for 1.
    factors: Vec<f64>,
    /// Whether an edge of a vertex has a joint.
    pub(crate) at_vertex: Vec<bool>,
    insertion: Insertion,
    pub(crate) broken: usize,
}

/// What a pass over the joints found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parting {
    /// Work of the joints since the last pass.
    pub(crate) work: f64,
    /// Joints that broke.
    pub(crate) broken: Vec<u32>,
}

impl Joints {
    /// Classes and scatter of all edges; no joints yet.
    pub(crate) fn new(model: &Model, topology: &Topology) -> Self {
        let mesh = &model.mesh;
        let mut strengths: Vec<Strength> = Vec::new();
        let class: Vec<u32> = topology
            .edges
            .iter()
            .map(|edge| {
                let [a, b] = edge.elements().map(|element| mesh.materials[element as usize]);
                let Some(strength) = strength_between(model, a, b) else { return NONE };
                let known = strengths.iter().position(|other| *other == strength);
                known.unwrap_or_else(|| {
                    strengths.push(strength);
                    strengths.len() - 1
                }) as u32
            })
            .collect();
        let scattered = strengths.iter().any(|strength| strength.weibull_modulus.is_some());
        let factor = |(edge, &class): (usize, &u32)| {
            let strength = strengths.get(class as usize)?;
            Some(random::weibull(strength.seed, edge as u64, strength.weibull_modulus?))
        };
        let factors = if scattered {
            class.iter().enumerate().map(|pair| factor(pair).unwrap_or(1.0)).collect()
        } else {
            Vec::new()
        };
        Self {
            all: Vec::new(),
            of_edge: vec![NONE; topology.edges.len()],
            class,
            strengths,
            factors,
            at_vertex: vec![false; topology.vertex_count()],
            insertion: model.fracture.insertion,
            broken: 0,
        }
    }

    /// Whether an edge may ever part.
    pub(crate) fn may_part(&self, edge: u32) -> bool {
        self.class[edge as usize] != NONE
    }

    fn strength(&self, edge: u32) -> Option<Strength> {
        let strength = self.strengths.get(self.class[edge as usize] as usize)?;
        let factor = self.factors.get(edge as usize).copied().unwrap_or(1.0);
        Some(Strength {
            tensile: strength.tensile * factor,
            cohesion: strength.cohesion * factor,
            ..*strength
        })
    }

    /// The law of an edge that may part.
    pub(crate) fn law(
        &self,
        edge: u32,
        model: &Model,
        topology: &Topology,
    ) -> Result<Option<Law>, ModelError> {
        let Some(strength) = self.strength(edge) else { return Ok(None) };
        let sides = &topology.edges[edge as usize];
        let penalty = penalty(model, sides);
        let elastic = self.insertion == Insertion::Intrinsic;
        let law = Law::new(&strength, penalty, model.fracture.critical_opening, elastic);
        law.map(Some).ok_or_else(|| {
            let element = sides.elements()[0];
            let material = &model.materials[model.mesh.materials[element as usize] as usize].name;
            let least = 0.5 * strength.tensile * strength.tensile / penalty;
            ModelError::FractureEnergy { material: material.clone(), element, least }
        })
    }

    /// Puts joints on all edges that may part, whole and without load.
    pub(crate) fn everywhere(&mut self, model: &Model, topology: &Topology) -> Result<(), ModelError> {
        for edge in 0..topology.edges.len() as u32 {
            if let Some(law) = self.law(edge, model, topology)? {
                self.put(edge, law, topology, model);
            }
        }
        Ok(())
    }

    fn put(&mut self, edge: u32, law: Law, topology: &Topology, model: &Model) {
        self.of_edge[edge as usize] = self.all.len() as u32;
        let vertices =
            topology.edges[edge as usize].corners[0].map(|corner| topology.vertices[corner as usize]);
        for vertex in vertices {
            self.at_vertex[vertex as usize] = true;
        }
        self.all.push(Joint {
            edge,
            state: State::Holding,
            law,
            length: length(model, vertices),
            ends: [Memory::default(); 2],
            open: [false; 2],
            forces: [[0.0; 2]; 2],
            opening: [0.0; 2],
            faded: 0.0,
            time: f64::NAN,
            modes: [0.0; 2],
        });
    }

    /// Joints as they were saved.
    pub(crate) fn restore(
        &mut self,
        saved: &[Joint],
        model: &Model,
        topology: &Topology,
    ) -> Result<(), ModelError> {
        self.all.clear();
        for joint in saved {
            if joint.edge as usize >= topology.edges.len() {
                return Err(ModelError::Missing {
                    what: "edge",
                    index: joint.edge,
                    place: "joints".to_owned(),
                });
            }
            let Some(law) = self.law(joint.edge, model, topology)? else { continue };
            self.put(joint.edge, law, topology, model);
            if let Some(last) = self.all.last_mut() {
                *last = Joint { law: last.law, length: last.length, ..*joint };
            }
        }
        self.broken = self.all.iter().filter(|joint| joint.state != State::Holding).count();
        Ok(())
    }

    /// Puts joints on the edges whose traction has reached their strength, and parts the nodes that nothing holds together any more. Returns the vertices at which
    /// there are new joints.
    pub(crate) fn insert(
        &mut self,
        solid: &mut Solid,
        model: &Model,
        topology: &Topology,
        team: &Team,
    ) -> Vec<u32> {
        if self.insertion == Insertion::Intrinsic || self.strengths.is_empty() {
            return Vec::new();
        }
        let failing: Vec<u32> = team
            .look(topology.edges.len(), |range| {
                let fails = |edge: &u32| {
                    self.of_edge[*edge as usize] == NONE
                        && self.strength(*edge).is_some_and(|strength| {
                            reaches(&strength, traction(solid, &topology.edges[*edge as usize]))
                        })
                };
                (range.start as u32..range.end as u32).filter(fails).collect::<Vec<u32>>()
            })
            .concat();
        let mut vertices = Vec::new();
        for edge in failing {
            // Checked for all edges when the model was.
            if let Ok(Some(law)) = self.law(edge, model, topology) {
                self.put(edge, law, topology, model);
                let corners = topology.edges[edge as usize].corners[0];
                vertices.extend(corners.map(|corner| topology.vertices[corner as usize]));
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        for &vertex in &vertices {
            self.part(vertex, solid, model, topology);
        }
        vertices
    }

    /// Gives the groups of elements that joints separate at a vertex a node each, and joints whose ends come free the traction that acts there.
    pub(crate) fn part(&mut self, vertex: u32, solid: &mut Solid, model: &Model, topology: &Topology) {
        let corners = topology.corners_of(vertex);
        let mut groups = Vec::new();
        topology.groups(vertex, |edge| self.of_edge[edge as usize] == NONE, &mut groups);
        let Solid { nodes, corners: lists, .. } = solid;
        let mut all = Vec::new();
        let split = lists.split(corners, &groups, |old, new| {
            let copy = nodes[old as usize];
            nodes.push(copy);
            all.extend([old, new]);
        });
        if split {
            for &corner in corners {
                let node = solid.corners.of_corner[corner as usize];
                solid.elements[corner as usize / 3].nodes[corner as usize % 3] = node;
            }
            for node in all {
                solid.weigh(node, model);
            }
        }
        for &corner in corners {
            for edge in topology.edges_at(corner) {
                self.open(edge, vertex, solid, topology);
            }
        }
    }

    /// Notes that the nodes at an end of a joint are two now.
    fn open(&mut self, edge: u32, vertex: u32, solid: &Solid, topology: &Topology) {
        if edge == NONE {
            return;
        }
        let Some(joint) = self.all.get_mut(self.of_edge[edge as usize] as usize) else { return };
        let sides = &topology.edges[edge as usize];
        let end = usize::from(topology.vertices[sides.corners[0][0] as usize] != vertex);
        let [a, b] = sides.corners.map(|side| solid.corners.of_corner[side[end] as usize]);
        if joint.open[end] || a == b {
            return;
        }
        joint.open[end] = true;
        if self.insertion == Insertion::Adaptive {
            joint.ends[end] = Memory::under(&joint.law, traction(solid, sides));
        }
    }

    /// Tractions and forces of all joints, from where the nodes are.
    pub(crate) fn pull(
        &mut self,
        solid: &Solid,
        topology: &Topology,
        step: f64,
        time: f64,
        team: &Team,
    ) -> Parting {
        let found = team.change(&mut self.all, |first, chunk| {
            let mut sum = Parting::default();
            for (k, joint) in chunk.iter_mut().enumerate() {
                if joint.state == State::Gone {
                    continue;
                }
                let holding = joint.state == State::Holding;
                sum.work += pull(joint, solid, &topology.edges[joint.edge as usize], step);
                if holding && joint.state == State::Broken {
                    joint.time = time;
                    sum.broken.push((first + k) as u32);
                }
            }
            sum
        });
        let mut all = Parting::default();
        for chunk in found {
            all.work += chunk.work;
            all.broken.extend(chunk.broken);
        }
        self.broken += all.broken.len();
        all
    }

    /// The force of the joints on a corner of an element.
    #[inline]
    pub(crate) fn add_force(&self, corner: u32, topology: &Topology, force: &mut Point) {
        let (element, k) = (corner as usize / 3, corner as usize % 3);
        let edges = &topology.edge_of[element];
        // The corner is the start of one edge of its element and the end of the one before.
        for (edge, at_start) in [(edges[k], true), (edges[(k + 2) % 3], false)] {
            if edge == NONE {
                continue;
            }
            let Some(joint) = self.all.get(self.of_edge[edge as usize] as usize) else { continue };
            let first = topology.edges[edge as usize].corners[0][0] as usize / 3 == element;
            let pull = joint.forces[usize::from(first != at_start)];
            let sign = if first { 1.0 } else { -1.0 };
            force[0] += sign * pull[0];
            force[1] += sign * pull[1];
        }
    }
}

/// Forces of one joint; the work since the last time.
fn pull(joint: &mut Joint, solid: &Solid, edge: &Edge, step: f64) -> f64 {
    let at = |side: usize, end: usize| solid.at_corner(edge.corners[side][end]);
    let ends = [0, 1].map(|end| [at(0, end), at(1, end)]);
    // Half way between the two edges, seen from side 0: its outward normal is to the right.
    let middle =
        ends.map(|[a, b]| [0.5 * (a.position[0] + b.position[0]), 0.5 * (a.position[1] + b.position[1])]);
    let along = minus(middle[1], middle[0]);
    let long = along[0].hypot(along[1]);
    let tangent = [along[0] / long, along[1] / long];
    let normal = [tangent[1], -tangent[0]];
    let half = 0.5 * joint.length * solid.thickness;
    let mut work = 0.0;
    let mut mean = [0.0; 2];
    let mut least = f64::INFINITY;
    let mut whole = false;
    for (end, [a, b]) in ends.into_iter().enumerate() {
        if !joint.open[end] {
            whole = true;
            continue;
        }
        let gap = minus(b.position, a.position);
        let rate = minus(b.velocity, a.velocity);
        let (opening, sliding) = (dot(gap, normal), dot(gap, tangent));
        let [pressure, shear] = joint.ends[end].traction(&joint.law, opening, sliding);
        let share = half * (1.0 - joint.faded);
        let force: Point =
            std::array::from_fn(|axis| share * (pressure * normal[axis] + shear * tangent[axis]));
        // What the last force did in the second half of its step, and this one in the first half.
        work += 0.5 * step * (dot(joint.forces[end], rate) + dot(force, rate));
        joint.forces[end] = force;
        mean[0] += 0.5 * opening;
        mean[1] += 0.5 * sliding;
        least = least.min(opening);
    }
    joint.opening = mean;
    match joint.state {
        State::Holding if !whole && joint.ends.iter().all(|memory| memory.damage(&joint.law) >= 1.0) => {
            joint.state = State::Broken;
            joint.modes = joint
                .ends
                .map(|memory| memory.modes(&joint.law))
                .into_iter()
                .fold([0.0; 2], |sum, modes| [sum[0] + 0.5 * modes[0], sum[1] + 0.5 * modes[1]]);
        }
        State::Broken => {
            let slid = (mean[1].abs() / joint.length - FADE[0]) / (FADE[1] - FADE[0]);
            joint.faded = joint.faded.max(slid.clamp(0.0, 1.0));
            // Open, neither a joint nor a contact acts.
            if least >= 0.0 || joint.faded >= 1.0 {
                joint.faded = 1.0;
                joint.forces = [[0.0; 2]; 2];
                joint.state = State::Gone;
            }
        }
        _ => {}
    }
    work
}

/// Normal (tension positive) and tangential traction across an edge: the mean of the two elements.
fn traction(solid: &Solid, edge: &Edge) -> [f64; 2] {
    let [a, b] = edge.corners[0].map(|corner| solid.at_corner(corner).position);
    let along = minus(b, a);
    let squared = dot(along, along);
    let [one, two] = edge.elements().map(|element| solid.elements[element as usize].stress);
    let [xx, yy, xy]: [f64; 3] = std::array::from_fn(|i| 0.5 * (one[i] + two[i]));
    // With tangent t and outward normal n = (t_y, -t_x).
    let [x, y] = along;
    let normal = (xx * y * y - 2.0 * xy * x * y + yy * x * x) / squared;
    let tangential = ((xx - yy) * x * y + xy * (y * y - x * x)) / squared;
    [normal, tangential]
}

/// Penalty of the joint on an edge, Pa/m.
pub(crate) fn penalty(model: &Model, edge: &Edge) -> f64 {
    let elements = edge.elements();
    let modulus =
        |element: u32| model.materials[model.mesh.materials[element as usize] as usize].youngs_modulus;
    let heights = [edge.corners[0][0], edge.corners[1][1]]
        .map(|corner| height(&triangle_of(&model.mesh, corner as usize / 3), corner as usize % 3));
    let modulus = modulus(elements[0]).min(modulus(elements[1]));
    model.fracture.joint_penalty * modulus / (0.5 * (heights[0] + heights[1]))
}

fn length(model: &Model, vertices: [u32; 2]) -> f64 {
    let [a, b] = vertices.map(|vertex| model.mesh.nodes[vertex as usize]);
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// What may break between two materials: what an interface says, or the weaker of the two.
fn strength_between(model: &Model, a: u32, b: u32) -> Option<Strength> {
    let interface = model
        .interfaces
        .iter()
        .find(|interface| interface.materials == [a, b] || interface.materials == [b, a]);
    if let Some(strength) = interface.and_then(|interface| interface.strength) {
        return Some(strength);
    }
    match [a, b].map(|material| model.materials[material as usize].strength) {
        [Some(one), Some(two)] => Some(if two.tensile < one.tensile { two } else { one }),
        [one, two] => one.or(two),
    }
}
