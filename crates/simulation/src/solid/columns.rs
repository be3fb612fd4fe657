//! The columns of a solid, as other files read and write them.

use fdem_contact::prefetch;

use crate::lanes::LANES;
use crate::model::Model;
use crate::share::Share;
use crate::solid::batch::Deformed;
use crate::solid::watch::Watch;
use crate::solid::{Constants, Node, Solid, SolidElement};
use crate::vector::{Matrix, Point, add, minus};

/// Nodes.
impl<const D: usize, const N: usize> Solid<D, N> {
    /// Number of nodes.
    #[inline]
    pub(crate) fn node_count(&self) -> usize {
        self.constants.len()
    }

    /// Position of a node relative to the origin, m.
    #[inline]
    pub(crate) fn position(&self, node: usize) -> Point<D> {
        self.positions[node]
    }

    /// Velocity of a node half a step before its position, m/s.
    #[inline]
    pub(crate) fn velocity(&self, node: usize) -> Point<D> {
        self.velocities[node]
    }

    /// Position and velocity of a node.
    #[inline]
    pub(crate) fn node(&self, node: usize) -> Node<D> {
        Node { position: self.positions[node], velocity: self.velocities[node] }
    }

    /// Prefetches the position and the velocity of a node.
    #[inline]
    pub(crate) fn prefetch_node(&self, node: usize) {
        prefetch(&self.positions[node]);
        prefetch(&self.velocities[node]);
    }

    /// Properties of a node that its motion does not change.
    #[inline]
    pub(crate) fn constants(&self, node: usize) -> &Constants {
        &self.constants[node]
    }

    /// The node of the mesh that a node belongs to.
    #[inline]
    pub(crate) fn vertex(&self, node: usize) -> u32 {
        self.constants[node].vertex
    }

    /// Prescribed motion of a node: an index of the holds of the loads, or [`NONE`](crate::topology::NONE).
    #[inline]
    pub(crate) fn hold(&self, node: usize) -> u32 {
        self.constants[node].hold
    }

    /// Mass of a node by the densities of its elements, kg: that of its weight.
    #[inline]
    pub(crate) fn true_mass(&self, node: usize) -> f64 {
        self.true_masses.get(node).copied().unwrap_or(self.constants[node].mass)
    }

    /// The corners of elements that share a node, ascending.
    #[inline]
    pub(crate) fn corners(&self, node: usize) -> &[u32] {
        self.corners.of(node)
    }

    /// Displacement of a node, m.
    pub(crate) fn displacement(&self, node: usize, model: &Model<D, N>) -> Point<D> {
        let vertex = self.vertex(node) as usize;
        minus(self.positions[node], minus(model.mesh.nodes[vertex], self.origin))
    }

    /// Converts a position to the model's coordinates, m.
    pub(crate) fn place(&self, position: Point<D>) -> Point<D> {
        std::array::from_fn(|axis| position[axis] + self.origin[axis])
    }

    /// Sets the position of a node relative to the origin, m.
    #[cfg(test)]
    pub(crate) fn set_position(&mut self, node: usize, position: Point<D>) {
        self.positions[node] = position;
    }

    /// Sets the velocity of a node, m/s.
    pub(crate) fn set_velocity(&mut self, node: usize, velocity: Point<D>) {
        self.velocities[node] = velocity;
    }

    /// Sets the position and the velocity of a node.
    #[inline]
    pub(crate) fn set_node(&mut self, node: usize, to: Node<D>) {
        (self.positions[node], self.velocities[node]) = (to.position, to.velocity);
    }

    /// Sets the prescribed motion of a node.
    pub(crate) fn set_hold(&mut self, node: usize, hold: u32) {
        self.constants[node].hold = hold;
    }

    /// Calls `work` with the positions and velocities of all nodes apart from the other columns.
    pub(crate) fn with_motion<R>(
        &mut self,
        work: impl FnOnce(&Self, &mut [Point<D>], &mut [Point<D>]) -> R,
    ) -> R {
        let (mut positions, mut velocities) =
            (std::mem::take(&mut self.positions), std::mem::take(&mut self.velocities));
        let result = work(self, &mut positions, &mut velocities);
        (self.positions, self.velocities) = (positions, velocities);
        result
    }
}

/// Elements and their corners. Corner `N e + k` is the `k`-th corner of element `e`.
impl<const D: usize, const N: usize> Solid<D, N> {
    /// Number of elements.
    #[inline]
    pub(crate) fn element_count(&self) -> usize {
        self.elements.len()
    }

    /// Properties of an element.
    #[inline]
    pub(crate) fn element(&self, element: usize) -> &SolidElement {
        &self.elements[element]
    }

    /// Prefetches the properties of an element, and the numbers of its nodes.
    #[inline]
    pub(crate) fn prefetch_element(&self, element: usize) {
        prefetch(&self.corners.of_corner[element]);
        prefetch(&self.elements[element]);
    }

    /// Present nodes of an element.
    #[inline]
    pub(crate) fn nodes_of(&self, element: u32) -> [u32; N] {
        self.corners.of_corner[element as usize]
    }

    /// Present positions of the corners of an element.
    #[inline]
    pub(crate) fn shape(&self, element: u32) -> [Point<D>; N] {
        self.nodes_of(element).map(|node| self.positions[node as usize])
    }

    /// Present node of a corner.
    #[inline]
    pub(crate) fn node_at(&self, corner: u32) -> u32 {
        self.corners.node_at(corner)
    }

    /// Position of the node of a corner, m.
    #[inline]
    pub(crate) fn position_at(&self, corner: u32) -> Point<D> {
        self.positions[self.node_at(corner) as usize]
    }

    /// Velocity of the node of a corner, m/s.
    #[inline]
    pub(crate) fn velocity_at(&self, corner: u32) -> Point<D> {
        self.velocities[self.node_at(corner) as usize]
    }

    /// Prescribed motion of the node of a corner: an index of the holds of the loads, or
    /// [`NONE`](crate::topology::NONE).
    pub(crate) fn hold_at(&self, corner: u32) -> u32 {
        self.hold(self.node_at(corner) as usize)
    }

    /// Force of the deformation, of contacts and of loads on a corner of an element, N.
    #[inline]
    pub(crate) fn force(&self, corner: u32) -> Point<D> {
        self.forces.as_flattened()[corner as usize]
    }

    /// Adds a force, N, on a corner of an element.
    #[inline]
    pub(crate) fn add_force(&mut self, corner: u32, force: Point<D>) {
        add(&mut self.forces.as_flattened_mut()[corner as usize], force, 1.0);
    }

    /// Calls `work` with the forces on the corners of each element, N, apart from the other columns.
    pub(crate) fn with_forces<R>(&mut self, work: impl FnOnce(&Self, &mut [[Point<D>; N]]) -> R) -> R {
        let mut forces = std::mem::take(&mut self.forces);
        let result = work(self, &mut forces);
        self.forces = forces;
        result
    }

    /// Calls `work` with the results of the deformation, in batches, apart from the other columns.
    pub(crate) fn with_deformed<R>(&mut self, work: impl FnOnce(&Self, &mut [Deformed<D>]) -> R) -> R {
        let mut deformed = std::mem::take(&mut self.deformed);
        let result = work(self, &mut deformed);
        self.deformed = deformed;
        result
    }

    /// Cauchy stress of an element in the last pass, Pa.
    #[inline]
    pub(crate) fn stress(&self, element: usize) -> Matrix<D> {
        self.deformed[element / LANES].stress(element % LANES)
    }

    /// Strain energy of an element in the last pass, J.
    #[inline]
    pub(crate) fn energy(&self, element: usize) -> f64 {
        self.deformed[element / LANES].energy.get(element % LANES)
    }
}

/// Elements whose facets are to be checked again: see `solid/watch.rs`.
impl<const D: usize, const N: usize> Solid<D, N> {
    /// Begins to watch the states of all elements, if it has not begun yet. All elements are awake then.
    pub(crate) fn begin_watch(&mut self) {
        for batch in self.deformed.iter_mut().filter(|batch| batch.watch.is_none()) {
            batch.watch = Some(Box::new(Watch::NONE));
        }
    }

    /// Whether the facets of an element of a batch may have to be checked.
    #[inline]
    pub(crate) fn any_awake(&self, batch: usize) -> bool {
        self.deformed[batch].watch.as_ref().is_none_or(|watch| watch.any_awake())
    }

    /// Whether the facets of an element are to be checked.
    #[inline]
    pub(crate) fn is_awake(&self, element: usize) -> bool {
        let watch = self.deformed[element / LANES].watch.as_ref();
        watch.is_none_or(|watch| watch.is_awake(element % LANES))
    }

    /// Lets the facets of an element be checked in the next step.
    pub(crate) fn wake(&mut self, element: u32) {
        if let Some(watch) = &mut self.deformed[element as usize / LANES].watch {
            watch.wake(element as usize % LANES);
        }
    }

    /// The largest change of the stress of an element from now on, Pa, before its facets are checked again.
    pub(crate) fn room(&self, element: u32) -> f64 {
        let watch = self.deformed[element as usize / LANES].watch.as_ref();
        watch.map_or(0.0, |watch| watch.room(element as usize % LANES))
    }
}

/// The corners and nodes that belong to this rank.
impl<const D: usize, const N: usize> Solid<D, N> {
    /// The share of this rank.
    #[inline]
    pub(crate) fn share(&self) -> &Share {
        &self.share
    }

    /// Sets the share of this rank.
    pub(crate) fn set_share(&mut self, share: Share) {
        self.share = share;
    }

    /// Sets the code of the first corner of a node of another rank.
    pub(crate) fn set_code(&mut self, node: usize, code: u32) {
        self.share.codes[node] = code;
    }
}
