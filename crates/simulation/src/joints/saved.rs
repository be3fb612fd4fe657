//! Joints apart from their lists: in a saved run, on the way to another rank, and as results show them.

use fdem_distributed::wire;
use serde::{Deserialize, Serialize};

use crate::error::ModelError;
use crate::joints::joint::Joint;
use crate::joints::{Break, Joints};
use crate::model::Model;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::team::Team;
use crate::topology::Topology;
use crate::vector::Point;

/// State of the joints in a saved run.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "Joint<D>: Serialize, [[f64; D]; D]: Serialize",
    deserialize = "Joint<D>: Deserialize<'de>, [[f64; D]; D]: Deserialize<'de>"
))]
pub(crate) struct SavedJoints<const D: usize = 2> {
    joints: Vec<Joint<D>>,
    forces: Vec<[Point<D>; D]>,
    breaks: Vec<Break>,
}

/// A joint with its data in other lists, for another rank. Its facet is a code.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovingJoint<const D: usize> {
    pub(crate) joint: Joint<D>,
    forces: [Point<D>; D],
    /// Time and modes of its failure.
    broken: Option<(f64, [f64; 2])>,
    /// Length of the undeformed edge, m, or area of the undeformed face, m².
    pub(crate) measure: f64,
    /// Codes of its corners on side 0 and on side 1.
    pub(crate) corners: [[u32; D]; 2],
}

wire!([const D: usize] MovingJoint<D> { joint, forces, broken, measure, corners });

/// A joint as results show it.
#[derive(Clone, Copy)]
pub(crate) struct JointView<'a, const D: usize> {
    pub(crate) joint: &'a Joint<D>,
    /// Numbers of its two elements.
    pub(crate) elements: [u32; 2],
    /// Time and modes of its failure.
    pub(crate) broken: Option<(f64, [f64; 2])>,
    /// Length of the undeformed edge, m, or area of the undeformed face, m².
    pub(crate) measure: f64,
}

impl<const D: usize> MovingJoint<D> {
    /// Looks up its nodes. `node_at`: the node of a corner, by its code.
    pub(crate) fn find_nodes(&mut self, node_at: impl Fn(u32) -> u32) {
        let corners = self.corners;
        self.joint.nodes = std::array::from_fn(|end| corners.map(|side| node_at(side[end])));
    }

    /// The joint in another mesh; `None` if one of its elements is not there. `number`: the number there of
    /// an element here.
    pub(crate) fn renumbered<const N: usize>(mut self, number: impl Fn(u32) -> Option<u32>) -> Option<Self> {
        let code = |code: u32| Some(number(code / N as u32)? * N as u32 + code % N as u32);
        self.joint.facet = code(self.joint.facet)?;
        for corner in self.corners.as_flattened_mut() {
            *corner = code(*corner)?;
        }
        Some(self)
    }

    /// The joint as results show it.
    pub(crate) fn seen<const N: usize>(&self) -> JointView<'_, D> {
        JointView {
            joint: &self.joint,
            elements: self.corners.map(|side| side[0] / N as u32),
            broken: self.broken,
            measure: self.measure,
        }
    }

    /// If the run has broken it, its modes, and its length or area.
    pub(crate) fn failed(&self) -> Option<([f64; 2], f64)> {
        self.broken.filter(|_| !self.joint.open_from_start).map(|(_, modes)| (modes, self.measure))
    }
}

impl<const D: usize> SavedJoints<D> {
    /// Joints in the order of their facets.
    pub(crate) fn of(mut all: Vec<MovingJoint<D>>) -> Self {
        all.sort_unstable_by_key(|moving| moving.joint.facet);
        let broken = |(joint, moving): (u32, &MovingJoint<D>)| {
            moving.broken.map(|(time, modes)| Break { joint, time, modes })
        };
        Self {
            joints: all.iter().map(|moving| moving.joint).collect(),
            forces: all.iter().map(|moving| moving.forces).collect(),
            breaks: (0..).zip(&all).filter_map(broken).collect(),
        }
    }
}

impl<const D: usize> Joints<D> {
    /// A joint for another rank.
    pub(crate) fn moving<const N: usize>(&self, number: u32, topology: &Topology<D, N>) -> MovingJoint<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut joint = self.all[number as usize];
        let measure = joint.measure;
        let sides = topology.facets[joint.facet as usize].corners;
        let corners = sides.map(|side| side.map(|corner| topology.code_of_corner(corner)));
        joint.facet = topology.code(joint.facet);
        MovingJoint {
            joint,
            forces: self.forces[number as usize],
            broken: self.break_of(number),
            measure,
            corners,
        }
    }

    /// A joint as results show it.
    pub(crate) fn seen<const N: usize>(&self, number: u32, topology: &Topology<D, N>) -> JointView<'_, D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let joint = &self.all[number as usize];
        let elements = topology.facets[joint.facet as usize].elements();
        JointView { joint, elements, broken: self.break_of(number), measure: joint.measure }
    }

    /// The joints for a saved run, in the order of their facets.
    pub(crate) fn save<const N: usize>(&self, topology: &Topology<D, N>) -> SavedJoints<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        SavedJoints::of(self.in_order().into_iter().map(|number| self.moving(number, topology)).collect())
    }

    /// Restores the saved joints.
    pub(crate) fn restore<const N: usize>(
        &mut self,
        saved: SavedJoints<D>,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        solid: &Solid<D, N>,
    ) -> Result<(), ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let missing = |what, index| ModelError::Missing { what, index, place: "the saved joints".to_owned() };
        let count = saved.joints.len();
        if saved.forces.len() != count {
            let found = saved.forces.len();
            return Err(ModelError::Length { what: "forces of joints", found, expected: count });
        }
        if let Some(broken) = saved.breaks.iter().find(|broken| broken.joint as usize >= count) {
            return Err(missing("joint", broken.joint));
        }
        self.all.clear();
        self.links.clear();
        self.forces.clear();
        for joint in &saved.joints {
            let facet = topology.facet_with(joint.facet).ok_or_else(|| missing("facet", joint.facet))?;
            let law = self.law(facet, model, topology)?.ok_or_else(|| missing("facet", joint.facet))?;
            let joint = self.joint(facet, law, joint.plane, model, topology, solid.share());
            self.put(joint, topology, model.thickness);
        }
        for (own, joint) in self.all.iter_mut().zip(saved.joints) {
            *own = own.restored(joint);
        }
        for number in 0..self.all.len() {
            let open = self.all[number].open;
            for end in (0..D).filter(|&end| open[end]) {
                self.connect(number, end, topology);
            }
        }
        if self.inserts() {
            let joined: Vec<u32> =
                (0..self.at_vertex.len() as u32).filter(|&vertex| self.at_vertex[vertex as usize]).collect();
            self.find_tips(&joined, topology, solid.share(), &Team::ALONE);
        }
        self.find_nodes(topology, solid);
        (self.forces, self.breaks) = (saved.forces, saved.breaks);
        self.faces.broken = self.breaks().map(|(_, joint, _)| joint.facet).collect();
        Ok(())
    }
}
