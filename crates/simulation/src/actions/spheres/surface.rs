//! The outer surface of all bodies, as spheres touch it: outer facets, and both sides of broken joints.
//!
//! Facets hang together by points. Corners of elements share a point as long as unbroken joints, or no
//! joints, connect their elements at the vertex. Where joints soften, the nodes of these corners are slightly
//! apart. The point is then in the middle of them, and they share its force, so that neither a force nor a
//! moment is lost.

use crate::action::Scene;
use crate::rotation::lifted;
use crate::simplex::Simplex;
use crate::vector::{Point, add};

/// The surface, with the motion of its corners.
#[derive(Debug, Default)]
pub(super) struct BodySurface<const D: usize> {
    /// Numbers of nodes and of broken joints for which the lists below hold.
    found_for: Option<[usize; 2]>,
    /// Corners of elements on the surface, ascending.
    corners: Vec<u32>,
    /// Velocity of the node of each corner one step before that of now, m/s.
    before: Vec<Point<D>>,
    /// Points of each facet: see [`fdem_grains::Surface::facets`].
    pub(super) facets: Vec<[u32; 3]>,
    /// Number of the material of each facet.
    pub(super) materials: Vec<u32>,
    /// Where the nodes of each point begin in `nodes`.
    first: Vec<u32>,
    /// The nodes of all points, each by the place in `corners` of one of its corners.
    nodes: Vec<u32>,
    /// Positions, m, and velocities, m/s, of the points.
    pub(super) points: Vec<[f64; 3]>,
    pub(super) velocities: Vec<[f64; 3]>,
}

impl<const D: usize> BodySurface<D> {
    /// Brings the surface to the present positions of the nodes.
    pub(super) fn update<const N: usize>(&mut self, scene: &Scene<'_, D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (solid, joints) = (scene.solid(), scene.joints());
        let now = [solid.node_count(), joints.faces.broken.len()];
        if self.found_for != Some(now) {
            self.find(scene);
            self.found_for = Some(now);
        }
        self.points.clear();
        self.velocities.clear();
        for ends in self.first.windows(2) {
            let nodes = &self.nodes[ends[0] as usize..ends[1] as usize];
            let share = 1.0 / nodes.len() as f64;
            let (mut position, mut velocity) = ([0.0; D], [0.0; D]);
            for &node in nodes {
                let (corner, before) = (self.corners[node as usize], self.before[node as usize]);
                add(&mut position, solid.position_at(corner), share);
                // The velocity of a node is half a step behind its position. It continues as in the last
                // step.
                add(&mut velocity, solid.velocity_at(corner), 1.5 * share);
                add(&mut velocity, before, -0.5 * share);
            }
            self.points.push(lifted(solid.place(position)));
            self.velocities.push(lifted(velocity));
        }
        for (before, &corner) in self.before.iter_mut().zip(&self.corners) {
            *before = solid.velocity_at(corner);
        }
    }

    /// The corners whose nodes make up a point, one for each node. The nodes share the force on the point in
    /// equal parts.
    pub(super) fn corners_of(&self, point: u32) -> impl ExactSizeIterator<Item = u32> + '_ {
        let [begin, end] = [point, point + 1].map(|k| self.first[k as usize] as usize);
        self.nodes[begin..end].iter().map(|&node| self.corners[node as usize])
    }

    /// The corners on the surface, ascending, with the velocities of their nodes one step earlier.
    pub(super) fn motion(&self) -> impl Iterator<Item = (u32, Point<D>)> + '_ {
        self.corners.iter().copied().zip(self.before.iter().copied())
    }

    /// Sets the values that [`BodySurface::motion`] has returned in the run that is continued.
    pub(super) fn set_motion(&mut self, motion: impl Iterator<Item = (u32, Point<D>)>) {
        (self.corners, self.before) = motion.unzip();
    }

    /// Finds the facets and points anew.
    fn find<const N: usize>(&mut self, scene: &Scene<'_, D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (solid, joints, topology) = (scene.solid(), scene.joints(), scene.topology);
        let mut broken = joints.faces.broken.clone();
        broken.sort_unstable();
        // Both sides of a facet list their corners as they go around the first one.
        let of_broken = broken.iter().flat_map(|&facet| {
            let [one, mut other] = topology.facets[facet as usize].corners;
            other.reverse();
            [one, other]
        });
        let sides: Vec<[u32; D]> = joints.faces.outer.iter().copied().chain(of_broken).collect();
        let mut corners: Vec<u32> = sides.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        let before = |&corner: &u32| match self.corners.binary_search(&corner) {
            Ok(place) => self.before[place],
            Err(_) => solid.velocity_at(corner),
        };
        self.before = corners.iter().map(before).collect();
        // The first corner of the group to which each corner belongs, and the corner.
        let mut vertices: Vec<u32> =
            corners.iter().map(|&corner| topology.vertices[corner as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let (mut groups, mut members) = (Vec::new(), Vec::with_capacity(corners.len()));
        for vertex in vertices {
            topology.groups(vertex, |facet| joints.holds(facet), &mut groups);
            let all = topology.corners_of(vertex);
            for (&corner, &group) in all.iter().zip(&groups) {
                if let Ok(place) = corners.binary_search(&corner) {
                    members.push((all[group as usize], place as u32));
                }
            }
        }
        members.sort_unstable();
        self.first = Vec::new();
        self.nodes.clear();
        let mut point_of = vec![0; corners.len()];
        for group in members.chunk_by(|a, b| a.0 == b.0) {
            let begin = self.nodes.len();
            for &(_, place) in group {
                point_of[place as usize] = self.first.len() as u32;
                let node = |place: u32| solid.node_at(corners[place as usize]);
                if self.nodes[begin..].iter().all(|&other| node(other) != node(place)) {
                    self.nodes.push(place);
                }
            }
            self.first.push(begin as u32);
        }
        self.first.push(self.nodes.len() as u32);
        let point = |corner: u32| corners.binary_search(&corner).map_or(0, |place| point_of[place]);
        // In the plane the second point counts as the third, too.
        self.facets = sides.iter().map(|side| [0, 1, D - 1].map(|k| point(side[k]))).collect();
        let material = |side: &[u32; D]| solid.element(side[0] as usize / N).material;
        self.materials = sides.iter().map(material).collect();
        self.corners = corners;
    }
}
