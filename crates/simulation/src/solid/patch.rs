//! Some nodes and elements, for machines with a memory of their own.

use crate::accelerator::{BY_HOST, ElementValues, HeldNode, NotedState, SolidPatch};
use crate::lanes::LANES;
use crate::lists::once_each;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::NONE;
use crate::vector::Point;

impl<const D: usize, const N: usize> Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The nodes of some elements, ascending.
    pub(crate) fn nodes_of_all(&self, elements: &[u32]) -> Vec<u32> {
        let mut nodes: Vec<u32> = elements.iter().flat_map(|&element| self.nodes_of(element)).collect();
        once_each(&mut nodes);
        nodes
    }

    /// Takes the present values of some elements over.
    pub(crate) fn take_elements(&mut self, elements: &[u32], values: &ElementValues<D, N>) {
        for ((&element, stress), forces) in elements.iter().zip(&values.stresses).zip(&values.forces) {
            let element = element as usize;
            self.deformed[element / LANES].set_stress(element % LANES, stress);
            self.forces[element] = *forces;
        }
        for (&element, normal) in elements.iter().zip(&values.normals) {
            self.histories[element as usize / LANES].set_memory(element as usize % LANES, normal);
        }
    }

    /// Takes the changes of the states of some elements over: see [`ElementValues::moved`].
    pub(crate) fn take_moved(&mut self, elements: &[u32], moved: &[f64]) {
        for (&element, moved) in elements.iter().zip(moved) {
            if let Some(watch) = &mut self.deformed[element as usize / LANES].watch {
                watch.set_moved(element as usize % LANES, *moved);
            }
        }
    }

    /// Takes the present positions and velocities of some nodes over.
    pub(crate) fn take_nodes(&mut self, nodes: &[u32], [positions, velocities]: &[Vec<Point<D>>; 2]) {
        for ((&node, position), velocity) in nodes.iter().zip(positions).zip(velocities) {
            (self.positions[node as usize], self.velocities[node as usize]) = (*position, *velocity);
        }
    }

    /// Takes the present positions of some nodes over.
    pub(crate) fn take_positions(&mut self, nodes: &[u32], positions: &[Point<D>]) {
        for (&node, position) in nodes.iter().zip(positions) {
            self.positions[node as usize] = *position;
        }
    }

    /// The present positions and velocities of some nodes.
    pub(crate) fn motion_of(&self, nodes: &[u32]) -> [Vec<Point<D>>; 2] {
        [&self.positions, &self.velocities]
            .map(|column| nodes.iter().map(|&node| column[node as usize]).collect())
    }

    /// The noted states of some elements, if any are.
    pub(crate) fn noted(&self, elements: &[u32]) -> Vec<NotedState<D>> {
        let of = |&element: &u32| {
            let watch = self.deformed[element as usize / LANES].watch.as_ref();
            watch.map(|watch| watch.noted(element as usize % LANES))
        };
        elements.iter().filter_map(of).collect()
    }

    /// Changes of the nodes of some corners, all corners of some vertices. `before`: number of nodes before;
    /// `holds`: the motions that boundaries prescribe, by their numbers; `held`: the nodes of these motions,
    /// ascending, each with the number of its motion, to which new ones are added.
    pub(crate) fn patch(
        &self,
        corners: &[u32],
        before: usize,
        holds: &[HeldNode<D>],
        held: &mut Vec<[u32; 2]>,
    ) -> SolidPatch<D, N> {
        let mut nodes: Vec<u32> = corners.iter().map(|&corner| self.node_at(corner)).collect();
        let mut elements: Vec<u32> = corners.iter().map(|corner| corner / N as u32).collect();
        once_each(&mut nodes);
        once_each(&mut elements);
        let mut added = Vec::new();
        let is_new = |node: &&u32| **node as usize >= before && !self.rigid.has_node(**node as usize);
        for &node in nodes.iter().filter(is_new) {
            let hold = self.hold(node as usize);
            if let Some(of_hold) = holds.get(hold as usize) {
                held.push([node, hold]);
                added.push(HeldNode { node, ..*of_hold });
            }
        }
        let place = |node: &u32| match held.binary_search_by_key(node, |of| of[0]) {
            Ok(place) => place as u32,
            Err(_) if self.rigid.has_node(*node as usize) => BY_HOST,
            Err(_) => NONE,
        };
        let all = || nodes.iter().map(|&node| node as usize);
        let true_mass = |node: usize| self.true_masses.get(node).copied();
        SolidPatch {
            node_count: self.node_count(),
            masses: all().map(|node| self.constants[node].mass).collect(),
            true_masses: all().filter_map(true_mass).collect(),
            places: nodes.iter().map(place).collect(),
            ranges: all().map(|node| self.corners.range(node)).collect(),
            corners: all().flat_map(|node| self.corners(node)).copied().collect(),
            positions: all().map(|node| self.positions[node]).collect(),
            velocities: all().map(|node| self.velocities[node]).collect(),
            held: added,
            of_elements: elements.iter().map(|&element| self.nodes_of(element)).collect(),
            elements,
            nodes,
        }
    }
}
