//! Some joints, for machines with a memory of their own.

use crate::accelerator::{JointMemories, JointPatch};
use crate::joints::Joints;
use crate::lists::once_each;
use crate::topology::{NONE, Topology};

impl<const D: usize> Joints<D> {
    /// The joints on the facets of some elements, ascending.
    pub(crate) fn of_elements<const N: usize>(
        &self,
        elements: &[u32],
        topology: &Topology<D, N>,
    ) -> Vec<u32> {
        let facets = elements.iter().flat_map(|&element| topology.facet_of[element as usize]);
        let joints = facets.filter(|&facet| facet != NONE).map(|facet| self.of_facet[facet as usize]);
        let mut joints: Vec<u32> = joints.filter(|&joint| joint != NONE).collect();
        once_each(&mut joints);
        joints
    }

    /// The nodes of some joints, and the elements whose stress they read, ascending.
    pub(crate) fn beside(&self, joints: &[u32]) -> [Vec<u32>; 2] {
        let all = || joints.iter().map(|&joint| &self.all[joint as usize]);
        let mut nodes: Vec<u32> = all().flat_map(|joint| joint.nodes).flatten().collect();
        let mut elements: Vec<u32> = all().filter_map(|joint| joint.beside).flatten().collect();
        once_each(&mut nodes);
        once_each(&mut elements);
        [nodes, elements]
    }

    /// Takes the present state of some joints over.
    pub(crate) fn take_some(&mut self, joints: &[u32], memories: JointMemories<D>) {
        self.take_memories(joints.iter().map(|&joint| joint as usize), memories);
    }

    /// Changes of joints, and of the open ends at some corners. `thickness`: that of the solid, m.
    pub(crate) fn patch(&self, joints: Vec<u32>, corners: Vec<u32>, thickness: f64) -> JointPatch<D> {
        let mut columns = self.columns_of(&joints, thickness);
        columns.at_corner = corners.iter().map(|&corner| self.at_corner[corner as usize]).collect();
        let memories = self.memories_of(joints.iter().map(|&joint| joint as usize));
        JointPatch { count: self.all.len(), joints, columns, memories, corners }
    }
}
