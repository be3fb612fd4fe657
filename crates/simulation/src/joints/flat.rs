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
        let kinds: Vec<JointKind> = self.links.iter().map(|link| kind_of(link.case)).collect();
        let law = |(joint, kind): (&Joint<D>, &JointKind)| flat_law(joint, *kind, thickness);
        JointColumns {
            counted: self.all.iter().map(|joint| joint.counted).collect(),
            broken: self.all.iter().map(|joint| joint.state == JointState::Broken).collect(),
            open: self.all.iter().map(|joint| joint.open).collect(),
            nodes: self.all.iter().map(|joint| joint.nodes).collect(),
            laws: self.all.iter().zip(&kinds).map(law).collect(),
            at_corner: self.at_corner.clone(),
            kinds,
        }
    }

    /// The values that phases change.
    pub(crate) fn flat_memories(&self) -> JointMemories<D> {
        let end = |&Memory { damages, stiffness, origin, rubbed }: &Memory<D>| EndMemory {
            damages,
            stiffness,
            origin,
            rubbed,
        };
        JointMemories {
            ends: self.all.iter().map(|joint| joint.ends.each_ref().map(end)).collect(),
            forces: self.forces.clone(),
        }
    }

    /// Takes these values over.
    pub(crate) fn take_flat(&mut self, memories: JointMemories<D>) {
        for (joint, ends) in self.all.iter_mut().zip(memories.ends) {
            joint.ends = ends.map(|EndMemory { damages, stiffness, origin, rubbed }| Memory {
                damages,
                stiffness,
                origin,
                rubbed,
            });
            // The damage may have grown.
            joint.left = [0.0; D];
        }
        self.forces = memories.forces;
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
