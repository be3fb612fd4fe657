//! The columns of joints as plain lists, for machines with a memory of their own.

use crate::accelerator::{EndMemory, FlatLaw, JointColumns, JointKind, JointMemories};
use crate::cohesive::{Memory, across};
use crate::joints::batch::JointCase;
use crate::joints::joint::{Joint, JointState};
use crate::joints::pass::{JointChunk, PassResult};
use crate::joints::{Joints, Pulling};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::Sum;
use crate::team::CHUNK;

impl<const D: usize> Joints<D> {
    /// The columns that the device does not change. `thickness`: that of the solid, m.
    pub(crate) fn flat(&self, thickness: f64) -> JointColumns<D> {
        let all: Vec<u32> = (0..self.all.len() as u32).collect();
        JointColumns { at_corner: self.at_corner.clone(), ..self.columns_of(&all, thickness) }
    }

    /// The columns of some joints, without those of corners.
    pub(super) fn columns_of(&self, joints: &[u32], thickness: f64) -> JointColumns<D> {
        let of = || joints.iter().map(|&joint| &self.all[joint as usize]);
        let kind = |&joint: &u32| kind_of(self.links[joint as usize].case);
        let kinds: Vec<JointKind> = joints.iter().map(kind).collect();
        let law = |(joint, kind): (&Joint<D>, &JointKind)| flat_law(joint, *kind, thickness);
        JointColumns {
            counted: of().map(|joint| joint.counted).collect(),
            broken: of().map(|joint| joint.state == JointState::Broken).collect(),
            open: of().map(|joint| joint.open).collect(),
            nodes: of().map(|joint| joint.nodes).collect(),
            laws: of().zip(&kinds).map(law).collect(),
            at_corner: Vec::new(),
            kinds,
        }
    }

    /// The values that phases change.
    pub(crate) fn flat_memories(&self) -> JointMemories<D> {
        self.memories_of(0..self.all.len())
    }

    /// The values of some joints that phases change.
    pub(super) fn memories_of(&self, joints: impl Iterator<Item = usize> + Clone) -> JointMemories<D> {
        let end = |&Memory { damages, stiffness, origin, rubbed }: &Memory<D>| EndMemory {
            damages,
            stiffness,
            origin,
            rubbed,
        };
        JointMemories {
            ends: joints.clone().map(|joint| self.all[joint].ends.each_ref().map(end)).collect(),
            forces: joints.map(|joint| self.forces[joint]).collect(),
        }
    }

    /// Takes these values over.
    pub(crate) fn take_flat(&mut self, memories: JointMemories<D>) {
        self.take_memories(0..self.all.len(), memories);
    }

    /// Takes the values of some joints over.
    pub(super) fn take_memories(&mut self, joints: impl Iterator<Item = usize>, memories: JointMemories<D>) {
        for ((number, ends), forces) in joints.zip(memories.ends).zip(memories.forces) {
            let joint = &mut self.all[number];
            joint.ends = ends.map(|EndMemory { damages, stiffness, origin, rubbed }| Memory {
                damages,
                stiffness,
                origin,
                rubbed,
            });
            // The damage may have grown.
            joint.left = [0.0; D];
            self.forces[number] = forces;
        }
    }

    /// Computes some joints, ascending, one by one.
    pub(crate) fn pull_some<const N: usize>(
        &mut self,
        joints: &[u32],
        solid: &Solid<D, N>,
        step: f64,
        time: f64,
    ) -> Pulling
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Self { all, links, forces, .. } = self;
        let mut chunk = JointChunk { joints: all, links, forces, solid, step, time };
        let (mut breaks, mut work) = (Vec::new(), Sum::default());
        for joints in joints.chunks(CHUNK) {
            let mut result = PassResult::default();
            for &joint in joints {
                chunk.pull_one(joint as usize, &mut result);
            }
            breaks.extend(result.broken);
            work.add_pile(result.work);
        }
        Pulling { broken: self.note_breaks(breaks, time), work, elastic: None }
    }
}

/// The kind of a joint on a device.
fn kind_of(case: JointCase) -> JointKind {
    match case {
        JointCase::AtRest | JointCase::Whole => JointKind::Whole,
        JointCase::Softening => JointKind::Softening,
        JointCase::Any => JointKind::Alone,
        JointCase::Closed | JointCase::Gone => JointKind::Idle,
    }
}

/// The law of a joint on a device.
fn flat_law<const D: usize>(joint: &Joint<D>, kind: JointKind, thickness: f64) -> FlatLaw<D> {
    let law = &joint.law;
    // As in batches, whole joints have the plane of the facet.
    let (normal, cohesion) = match kind {
        JointKind::Whole => (across(), law.least_pressed()),
        _ => (law.normal, law.cohesion),
    };
    FlatLaw {
        normal,
        penalty: law.penalty,
        tensile: law.tensile,
        cohesion,
        friction: law.friction,
        critical: law.critical,
        share: joint.share(thickness),
        length: joint.length,
        faded: joint.faded,
    }
}
