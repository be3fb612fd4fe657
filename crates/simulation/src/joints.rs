//! Joints between elements: which facets can separate, when they do, and the tractions that joints carry
//! until they are broken.
//!
//! A joint acts at its D ends, the vertices of its facet, each of which represents a part of 1/D of the facet
//! (Newton-Cotes integration). The force at an end acts between the node on one side and the node on the
//! other. While both sides share one node, that end cannot open and has no force. A facet that reaches its
//! strength within whole material therefore opens only when others at the same vertex reach theirs: this is
//! how cracks begin and end.
//!
//! A joint that is inserted under load begins with the traction that acts there, so that the insertion
//! releases no stress. This holds for adaptive insertion (`joints/insertion.rs`), and for intrinsic joints
//! under initial stress. The energy balance counts the elastic energy of the latter from the beginning.

mod batch;
mod check;
mod cut;
pub(crate) mod due;
mod failing;
mod fan;
mod flat;
mod insertion;
mod joint;
mod pass;
mod patch;
mod plane;
pub(crate) mod saved;
pub(crate) mod single;
mod slack;
mod start;
mod strength;
mod tips;

use serde::{Deserialize, Serialize};

use crate::cohesive::{JointLaw, JointPlane, TooLittle};
use crate::error::ModelError;
use crate::faces::{BrokenSides, Faces};
use crate::forces::ContactForce;
use crate::joints::batch::Link;
use crate::joints::cut::{Cut, InsertionData};
pub(crate) use crate::joints::joint::{Joint, JointAxes, JointState};
use crate::joints::pass::JointChunk;
use crate::joints::slack::Checked;
pub(crate) use crate::joints::strength::penalty;
use crate::joints::strength::{directed_strength, measure_of, strength_on};
use crate::model::{Insertion, Model, Strength};
use crate::random;
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::Sum;
use crate::team::Team;
use crate::topology::{Facet, NONE, Topology};
use crate::vector::{Point, add, dot, length, minus};

/// When and how a joint broke.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Break {
    joint: u32,
    time: f64,
    /// Damage by opening and by sliding.
    pub(crate) modes: [f64; 2],
}

/// A vertex whose nodes were split, with the tractions with which ends of joints begin there, by their
/// facets.
pub(crate) type VertexSplit<const D: usize> = (u32, Vec<(u32, [f64; D])>);

/// All joints of a model, and the strengths of facets that may still get one.
#[derive(Clone, Debug)]
pub(crate) struct Joints<const D: usize = 2> {
    pub(crate) all: Vec<Joint<D>>,
    /// The data of each joint that most steps need.
    links: Vec<Link<D>>,
    /// Force of each joint on its side 0, at each end, N; side 1 has the opposite.
    forces: Vec<[Point<D>; D]>,
    /// Elastic energy, J, with which joints were inserted since the last [`Joints::take_inserted`].
    inserted: Sum,
    /// Joints that broke, ascending by their numbers.
    breaks: Vec<Break>,
    /// Outer facets, and facets of broken joints.
    pub(crate) faces: Faces<D>,
    /// Open ends of joints of the facets at each corner, as 2 D × number + 2 × end + side; or [`NONE`]. Empty
    /// if no facet can break.
    at_corner: Vec<[u32; D]>,
    /// The joint of each facet, or [`NONE`].
    pub(crate) of_facet: Vec<u32>,
    /// Strength of each facet, as an index of `strengths`; [`NONE`] if the facet cannot break.
    class: Vec<u32>,
    strengths: Vec<Strength>,
    /// Strength of each facet, where it depends on the direction of the facet; empty if none does.
    directed: Vec<Option<Strength>>,
    /// Whether each strength is that of an interface.
    of_interface: Vec<bool>,
    /// The joint set of each strength, or [`NONE`].
    sets: Vec<u32>,
    /// Whether each joint set is open from the beginning.
    open_sets: Vec<bool>,
    /// Factor of the strength of each facet; empty if all factors are 1.
    factors: Vec<f64>,
    /// Whether any facet at each vertex has a joint.
    pub(crate) at_vertex: Vec<bool>,
    insertion: Insertion,
    /// Where whole material can part at a free surface or at a crack; empty if joints are not inserted.
    tips: Vec<Tip<D>>,
    /// The last check of each facet, and the slack of the tip at each vertex, Pa, infinite without one. These
    /// lists and the next are empty if joints are not inserted.
    checked: Vec<Checked>,
    tip_slack: Vec<f64>,
    /// Whether each facet is checked in every step, and why: 0 for no.
    restless: Vec<u8>,
    /// Whether the facets of each element are checked in this step.
    awake: Vec<bool>,
    /// Number of steps in which anything was checked.
    checks: u64,
    /// The elements on which contacts and loads acted in the last step.
    pressed: Vec<u32>,
}

/// A vertex on a free surface or at a joint, with the facets there that can get a joint.
#[derive(Clone, Debug)]
struct Tip<const D: usize> {
    vertex: u32,
    /// Joints that alone connect elements at the vertex: all of them in two dimensions.
    alone: Box<[u32]>,
    /// Joints that connect elements only together with others.
    together: Box<[u32]>,
    /// Cuts that the last steps have looked at, by the facets that give their planes; `None` where all facets
    /// along the plane cannot part.
    cuts: Vec<(u32, Option<Cut<D>>)>,
    /// Facets to check in every step, in the order of the lists above; see `joints/tips.rs`.
    contenders: Vec<u32>,
}

impl<const D: usize> Tip<D> {
    /// Its facets, first those that connect elements alone.
    fn facets(&self) -> impl Iterator<Item = u32> {
        self.alone.iter().chain(&self.together).copied()
    }

    /// The cut along the plane of a facet: one that is known, or a new one.
    fn cut<const N: usize>(
        &mut self,
        facet: u32,
        state: InsertionData<'_, D, N>,
        new: impl FnOnce() -> Option<Cut<D>>,
    ) -> Option<&Cut<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        // Where this rank splits a vertex, its tip is a new one. Other ranks may split it, too.
        let alone = state.solid.share().is_whole();
        let holds = |(of, cut): &(u32, Option<Cut<D>>)| {
            *of == facet && (alone || cut.as_ref().is_none_or(|cut| cut.holds(state)))
        };
        let known = self.cuts.iter().position(holds);
        let place = known.unwrap_or_else(|| {
            let Self { alone, contenders, cuts, .. } = self;
            cuts.retain(|(of, _)| *of != facet && (alone.contains(of) || contenders.contains(of)));
            cuts.push((facet, new()));
            cuts.len() - 1
        });
        self.cuts[place].1.as_ref()
    }
}

/// The results of a pass over all joints.
#[derive(Debug)]
pub(crate) struct Pulling {
    /// The joints that broke, ascending.
    pub(crate) broken: Vec<u32>,
    /// Work done against all joints since the last pass, J.
    pub(crate) work: Sum,
    /// Elastic energy of the joints that are counted, J, if it is asked for.
    pub(crate) elastic: Option<Sum>,
}

impl<const D: usize> Joints<D> {
    /// Finds the strength of each facet, with its scatter. Inserts no joints yet.
    pub(crate) fn new<const N: usize>(model: &Model<D, N>, topology: &Topology<D, N>, share: &Share) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mesh = &model.mesh;
        let (mut strengths, mut of_interface, mut sets) = (Vec::new(), Vec::new(), Vec::new());
        let directed = if model.materials.iter().any(|material| material.law.has_directions()) {
            let of = |facet: &Facet<D>| directed_strength(model, topology, facet);
            topology.facets.iter().map(of).collect()
        } else {
            Vec::new()
        };
        let class: Vec<u32> = topology
            .facets
            .iter()
            .map(|facet| {
                let Some((strength, interface, set)) = strength_on(model, facet) else { return NONE };
                let mut known = strengths.iter().zip(&of_interface).zip(&sets);
                let alike = |((other, at), of): ((&Strength, &bool), &u32)| {
                    *other == strength && *at == interface && *of == set
                };
                known.position(alike).unwrap_or_else(|| {
                    strengths.push(strength);
                    of_interface.push(interface);
                    sets.push(set);
                    strengths.len() - 1
                }) as u32
            })
            .collect();
        let scattered = strengths.iter().any(|strength| strength.weibull_modulus.is_some());
        let factor = |(facet, &class): (usize, &u32)| {
            let strength = strengths.get(class as usize)?;
            Some(random::weibull(
                strength.seed,
                topology.code(facet as u32).into(),
                strength.weibull_modulus?,
            ))
        };
        let factors = if scattered {
            class.iter().enumerate().map(|pair| factor(pair).unwrap_or(1.0)).collect()
        } else {
            Vec::new()
        };
        // Joints of sets are never inserted: they are there.
        let of_classes = strengths.iter().zip(&sets).filter(|(_, set)| **set == NONE);
        let inserts = model.fracture.insertion == Insertion::Adaptive
            && (of_classes.count() > 0 || directed.iter().flatten().next().is_some());
        let mut joints = Self {
            tips: Vec::new(),
            all: Vec::new(),
            links: Vec::new(),
            forces: Vec::new(),
            inserted: Sum::default(),
            breaks: Vec::new(),
            faces: Faces::new(topology),
            at_corner: if strengths.is_empty() {
                Vec::new()
            } else {
                vec![[NONE; D]; topology.vertices.len()]
            },
            of_facet: vec![NONE; topology.facets.len()],
            class,
            strengths,
            directed,
            of_interface,
            sets,
            open_sets: model.joint_sets.iter().map(|set| set.open).collect(),
            factors,
            at_vertex: vec![false; topology.vertex_count()],
            insertion: model.fracture.insertion,
            checked: Vec::new(),
            tip_slack: Vec::new(),
            restless: Vec::new(),
            awake: Vec::new(),
            checks: 0,
            pressed: Vec::new(),
        };
        if inserts {
            joints.checked = vec![Checked::NEVER; topology.facets.len()];
            joints.restless = vec![0; topology.facets.len()];
            joints.tip_slack = vec![f64::INFINITY; topology.vertex_count()];
            joints.awake = vec![false; mesh.elements.len()];
            let outer = joints.faces.vertices(topology);
            let outer: Vec<u32> = (0..outer.len() as u32).filter(|&vertex| outer[vertex as usize]).collect();
            joints.find_tips(&outer, topology, share, &Team::ALONE);
        }
        joints
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { all, links, forces, breaks, at_corner, of_facet, class, factors, .. } = self;
        let Self { at_vertex, tips, directed, checked, tip_slack, restless, awake, pressed, .. } = self;
        let of_tip = |tip: &Tip<D>| {
            let cuts: usize = tip.cuts.iter().filter_map(|(_, cut)| cut.as_ref()).map(Cut::bytes).sum();
            let lists = [&*tip.alone, &tip.together, &tip.contenders].map(size_of_val);
            size_of::<Tip<D>>() + lists.iter().sum::<usize>() + cuts
        };
        size_of_val(&**all)
            + size_of_val(&**links)
            + size_of_val(&**forces)
            + size_of_val(&**breaks)
            + self.faces.bytes()
            + size_of_val(&**at_corner)
            + size_of_val(&**of_facet)
            + size_of_val(&**class)
            + size_of_val(&**directed)
            + size_of_val(&**factors)
            + size_of_val(&**at_vertex)
            + tips.iter().map(of_tip).sum::<usize>()
            + size_of_val(&**checked)
            + size_of_val(&**tip_slack)
            + size_of_val(&**restless)
            + size_of_val(&**awake)
            + size_of_val(&**pressed)
    }

    /// Whether a facet can ever get a joint.
    pub(crate) fn may_part(&self, facet: u32) -> bool {
        self.class[facet as usize] != NONE
    }

    fn strength(&self, facet: u32) -> Option<Strength> {
        let of_class = self.strengths.get(self.class[facet as usize] as usize)?;
        let strength = self.directed.get(facet as usize).and_then(Option::as_ref).unwrap_or(of_class);
        let factor = self.factors.get(facet as usize).copied().unwrap_or(1.0);
        Some(Strength {
            tensile: strength.tensile * factor,
            cohesion: strength.cohesion * factor,
            ..*strength
        })
    }

    /// The law of a joint on a facet; `None` if the facet cannot break.
    pub(crate) fn law<const N: usize>(
        &self,
        facet: u32,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
    ) -> Result<Option<JointLaw<D>>, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Some(strength) = self.strength(facet) else { return Ok(None) };
        let sides = &topology.facets[facet as usize];
        let penalty = penalty(model, sides);
        let elastic = self.insertion == Insertion::Intrinsic;
        let length = <[[f64; D]; N]>::facet_length(measure_of(model, topology, sides));
        if let Some(set) = self.set(facet).and_then(|set| model.joint_sets.get(set as usize)) {
            let law = JointLaw::of_set(set, set.stiffness(penalty), model.fracture.critical_opening, length);
            return law.map(Some).map_err(|TooLittle { least, sliding }| {
                let element = topology.number(sides.elements()[0]);
                ModelError::SetEnergy { set: set.name.clone(), element, least, sliding }
            });
        }
        let law = JointLaw::new(&strength, penalty, model.fracture.critical_opening, elastic, length);
        law.map(Some).map_err(|TooLittle { least, sliding }| {
            let element = sides.elements()[0];
            let material = &model.materials[model.mesh.materials[element as usize] as usize].name;
            ModelError::FractureEnergy { material: material.clone(), element, least, sliding }
        })
    }

    /// A joint on a facet that nothing has loaded yet.
    fn joint<const N: usize>(
        &self,
        facet: u32,
        law: JointLaw<D>,
        plane: JointPlane<D>,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        share: &Share,
    ) -> Joint<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let sides = &topology.facets[facet as usize];
        let measure = measure_of(model, topology, sides);
        let length = <[[f64; D]; N]>::facet_length(measure);
        let mut joint = Joint::new(facet, law, plane, [measure, length]);
        joint.counted = share.corner(sides.corners[0][0]);
        if self.insertion == Insertion::Intrinsic && self.strength_of_planes(facet).is_some() {
            joint.beside = Some(sides.elements());
        }
        joint.open_from_start = self.set(facet).is_some_and(|set| self.open_sets[set as usize]);
        joint
    }

    fn put<const N: usize>(&mut self, joint: Joint<D>, topology: &Topology<D, N>, thickness: f64)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let facet = joint.facet;
        self.of_facet[facet as usize] = self.all.len() as u32;
        let sides = &topology.facets[facet as usize];
        for corner in sides.corners[0] {
            self.at_vertex[topology.vertices[corner as usize] as usize] = true;
        }
        self.forces.push([[0.0; D]; D]);
        self.links.push(Link::of(&joint, thickness));
        self.all.push(joint);
    }

    /// Makes room for more joints.
    fn reserve(&mut self, more: usize) {
        self.all.reserve(more);
        self.links.reserve(more);
        self.forces.reserve(more);
    }

    /// Lets the force at an end of a joint act on the corners of its elements. Ends that are closed have no
    /// force, and most ends in a body near its strength are.
    fn connect<const N: usize>(&mut self, number: usize, end: usize, topology: &Topology<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let facet = self.all[number].facet;
        for (side, corners) in topology.facets[facet as usize].corners.into_iter().enumerate() {
            let corner = corners[end];
            let at = topology.facets_at(corner);
            for slot in (0..D).filter(|&slot| at[slot] == facet) {
                self.at_corner[corner as usize][slot] = (2 * (D * number + end) + side) as u32;
            }
        }
    }

    /// Looks up the nodes of all joints again.
    pub(crate) fn find_nodes<const N: usize>(&mut self, topology: &Topology<D, N>, solid: &Solid<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        for (joint, link) in self.all.iter_mut().zip(&mut self.links) {
            joint.find_nodes(&topology.facets[joint.facet as usize], solid);
            *link = Link::of(joint, solid.thickness);
        }
    }

    /// Whether the two elements at a facet may still act on each other there: by the mesh, or by a joint.
    pub(crate) fn acts(&self, facet: u32) -> bool {
        self.links.get(self.of_facet[facet as usize] as usize).is_none_or(|link| !link.is_gone())
    }

    /// Numbers of joints: broken by the run, of open sets, and without a bond.
    pub(crate) fn broken(&self) -> [usize; 3] {
        let broken = self.breaks().filter(|(_, joint, _)| !joint.open_from_start).count();
        let open = self.all.iter().filter(|joint| joint.open_from_start).count();
        [broken, open, self.breaks.len()]
    }

    /// Joints without a bond, those of open sets too: the number of each, and when and how it broke.
    pub(crate) fn breaks(&self) -> impl Iterator<Item = (u32, &Joint<D>, &Break)> {
        self.breaks.iter().map(|broken| (broken.joint, &self.all[broken.joint as usize], broken))
    }

    /// Broken joints, and those of open sets, with the names that are the same on all ranks. A joint at the
    /// end of an open set never breaks, because its sides have one node there.
    pub(crate) fn broken_sides<const N: usize>(
        &self,
        topology: &Topology<D, N>,
    ) -> impl Iterator<Item = BrokenSides<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let open = self.all.iter().filter(|joint| joint.open_from_start).map(|joint| joint.facet);
        let all = self.faces.broken.iter().copied().chain(open);
        all.map(|facet| BrokenSides::of(&topology.facets[facet as usize], topology))
    }

    /// When and how a joint broke, if it did.
    pub(crate) fn break_of(&self, joint: u32) -> Option<(f64, [f64; 2])> {
        let place = self.breaks.binary_search_by_key(&joint, |broken| broken.joint).ok()?;
        self.breaks.get(place).map(|broken| (broken.time, broken.modes))
    }

    /// The numbers of all joints, in the order of their facets. Memory has them in the order in which they
    /// were inserted.
    pub(crate) fn in_order(&self) -> Vec<u32> {
        self.of_facet.iter().copied().filter(|&joint| joint != NONE).collect()
    }

    /// Updates all joints and their forces from the positions of the nodes. `energies`: whether to compute
    /// their elastic energy.
    pub(crate) fn pull<const N: usize>(
        &mut self,
        solid: &Solid<D, N>,
        step: f64,
        time: f64,
        energies: bool,
        team: &Team,
    ) -> Pulling
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Self { all, links, forces, .. } = self;
        let found =
            team.change_batches::<1, _, _, _, _>(all, links, forces, |first, joints, links, forces| {
                let found = JointChunk { joints, links, forces, solid, step, time }.pull();
                (first, found)
            });
        let (mut breaks, mut work) = (Vec::new(), Sum::default());
        for (first, found) in found {
            breaks.extend(found.broken.into_iter().map(|(place, modes)| (first + place, modes)));
            work.add_pile(found.work);
        }
        let broken = self.note_breaks(breaks, time);
        let elastic = energies.then(|| self.elastic(solid, team));
        Pulling { broken, work, elastic }
    }

    /// Notes the joints that broke at a time, s, with the modes of their damage. Returns their numbers.
    fn note_breaks(&mut self, found: Vec<(usize, [f64; 2])>, time: f64) -> Vec<u32> {
        let of = |(joint, modes): (usize, [f64; 2])| Break { joint: joint as u32, time, modes };
        let breaks: Vec<Break> = found.into_iter().map(of).collect();
        let broken = breaks.iter().map(|broken| broken.joint).collect();
        if !breaks.is_empty() {
            let facet = |broken: &Break| self.all[broken.joint as usize].facet;
            self.faces.broken.extend(breaks.iter().map(facet));
            self.breaks.extend(breaks);
            self.breaks.sort_unstable_by_key(|broken| broken.joint);
        }
        broken
    }

    /// Adds the force of the joints on a corner of an element.
    #[inline]
    pub(crate) fn add_force(&self, corner: u32, force: &mut Point<D>) {
        let Some(codes) = self.at_corner.get(corner as usize) else { return };
        for &code in codes {
            if code == NONE {
                continue;
            }
            let pull = self.forces.as_flattened()[code as usize / 2];
            add(force, pull, if code % 2 == 0 { 1.0 } else { -1.0 });
        }
    }

    /// Whether the two elements at a facet are connected there: by the mesh, or by a joint that holds.
    pub(crate) fn holds(&self, facet: u32) -> bool {
        self.all
            .get(self.of_facet[facet as usize] as usize)
            .is_none_or(|joint| joint.state == JointState::Holding)
    }

    /// Forces of the broken joints that this rank counts and that still press their two elements.
    pub(crate) fn pressing<const N: usize>(
        &self,
        solid: &Solid<D, N>,
        topology: &Topology<D, N>,
    ) -> Vec<ContactForce<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut pressing = Vec::new();
        for (joint, forces) in self.all.iter().zip(&self.forces) {
            if !joint.counted || joint.state != JointState::Broken || *forces == [[0.0; D]; D] {
                continue;
            }
            let frame = JointAxes::new::<N>(joint, solid);
            let (mut sum, mut whole, mut moment) = ([0.0; D], 0.0, [0.0; D]);
            for ([a, b], force) in frame.ends.into_iter().zip(forces) {
                let weight = length(*force);
                let middle = std::array::from_fn(|axis| f64::midpoint(a[axis], b[axis]));
                add(&mut sum, *force, 1.0);
                add(&mut moment, middle, weight);
                whole += weight;
            }
            let across = dot(sum, frame.axes[0]);
            let normal = frame.axes[0].map(|n| across * n);
            // Side 0 is the element with the lower number.
            pressing.push(ContactForce {
                elements: topology.facets[joint.facet as usize].elements(),
                point: moment.map(|x| x / whole),
                normal,
                tangential: minus(sum, normal),
            });
        }
        pressing
    }

    /// Elastic energy, J, that the initial stress has stored in intrinsic joints. Valid only before any joint
    /// has opened or slid.
    pub(crate) fn stored<const N: usize>(&self, solid: &Solid<D, N>) -> Sum {
        let of_joint = |joint: &Joint<D>| -> f64 {
            let part = joint.measure / D as f64 * solid.thickness;
            joint.ends.iter().map(|end| part * end.stored(&joint.law)).sum()
        };
        self.all.iter().map(of_joint).collect()
    }

    /// Elastic energy, J, of the joints that this rank counts, at the positions of the last pass.
    pub(crate) fn elastic<const N: usize>(&self, solid: &Solid<D, N>, team: &Team) -> Sum
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let chunks = team.look(self.all.len(), |range| {
            let counted = self.all[range].iter().filter(|joint| joint.counted);
            counted.map(|joint| joint.elastic(solid)).collect::<Sum>()
        });
        let mut all = Sum::default();
        for chunk in &chunks {
            all.add_sum(chunk);
        }
        all
    }

    /// [`Joints::elastic`] of some joints.
    pub(crate) fn elastic_of<const N: usize>(&self, joints: &[u32], solid: &Solid<D, N>) -> Sum
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let some = joints.iter().map(|&joint| &self.all[joint as usize]);
        some.filter(|joint| joint.counted).map(|joint| joint.elastic(solid)).collect()
    }

    /// Elastic energy, J, that joints had when they were inserted, since the last call: they take over the
    /// traction that acts, so that their energy is in no work.
    pub(crate) fn take_inserted(&mut self) -> Sum {
        std::mem::take(&mut self.inserted)
    }

    /// Adds the force of the joints on a corner of an element before anything has moved.
    pub(crate) fn add_initial_force<const N: usize>(
        &self,
        corner: u32,
        solid: &Solid<D, N>,
        force: &mut Point<D>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let codes = self.at_corner.get(corner as usize).into_iter().flatten();
        for &code in codes.filter(|&&code| code != NONE) {
            let joint = &self.all[code as usize / (2 * D)];
            let (frame, mut memory) = (JointAxes::new::<N>(joint, solid), joint.ends[code as usize / 2 % D]);
            let traction = memory.traction(&joint.law, [0.0; D]);
            let area = joint.measure / D as f64 * solid.thickness;
            add(force, frame.vector(traction), if code % 2 == 0 { area } else { -area });
        }
    }
}
