//! The outer surface of all bodies, as spheres touch it: outer facets, and both sides of broken joints.
//!
//! Facets hang together by points. Corners of elements share a point as long as unbroken joints, or no
//! joints, connect their elements at the vertex. Where joints soften, the nodes of these corners are slightly
//! apart. The point is then in the middle of them, and they share its force, so that neither a force nor a
//! moment is lost.
//!
//! Each rank knows the whole surface. It finds and moves the points whose nodes it owns, and gets the others
//! from their owners in each step.

use fdem_distributed::wire;

use crate::action::Scene;
use crate::peers::{Peers, all};
use crate::rotation::lifted;
use crate::simplex::Simplex;
use crate::topology::{NONE, corners_of_facet, place_in_element};
use crate::vector::{Point, add};

/// The surface, with the motion of its corners.
#[derive(Debug, Default)]
pub(super) struct BodySurface<const D: usize> {
    /// Numbers of nodes and of broken joints for which the lists below hold.
    found_for: Option<[usize; 2]>,
    /// Velocities of nodes one step before that of now, m/s, by the codes of corners: of an earlier run, or
    /// of all ranks before elements were given to ranks again.
    earlier: Vec<(u32, Point<D>)>,
    /// Codes of the corners on the surface that this rank owns, ascending, and these corners.
    codes: Vec<u32>,
    corners: Vec<u32>,
    /// Velocity of the node of each of these corners one step before that of now, m/s.
    before: Vec<Point<D>>,
    /// Where the nodes of each point that this rank owns begin in `nodes`.
    first: Vec<u32>,
    /// The nodes of these points, each by the place in `corners` of one of its corners.
    nodes: Vec<u32>,
    /// Places in `points` of the points of each rank.
    of_ranks: Vec<Vec<u32>>,
    /// For each point, its place among those that this rank owns, or [`NONE`].
    own: Vec<u32>,
    /// Points of each facet: see [`fdem_grains::Surface::facets`].
    pub(super) facets: Vec<[u32; 3]>,
    /// Number of the material of each facet, and of its body.
    pub(super) materials: Vec<u32>,
    pub(super) bodies: Vec<u32>,
    /// Positions, m, and velocities, m/s, of the points.
    pub(super) points: Vec<[f64; 3]>,
    pub(super) velocities: Vec<[f64; 3]>,
}

/// A side: codes of its corners, and the numbers of its material and of its body.
type Side<const D: usize> = ([u32; D], [u32; 2]);

/// The part of the surface that one rank finds.
struct SurfacePart<const D: usize> {
    /// Sides whose first corner it owns, with their codes.
    sides: Vec<(u32, Side<D>)>,
    /// Codes of the corners that it owns, ascending, and of their points: of the first corner there.
    corners: Vec<(u32, u32)>,
    /// Codes of its points, ascending.
    points: Vec<u32>,
}

wire!([const D: usize] SurfacePart<D> { sides, corners, points });

/// The motion of the points of one rank.
struct PointsMotion {
    /// Whether its lists do not hold any more.
    is_stale: bool,
    /// Position, m, and velocity, m/s, of each.
    points: Vec<[f64; 6]>,
}

wire!([] PointsMotion { is_stale, points });

impl<const D: usize> BodySurface<D> {
    /// Brings the surface to the present positions of the nodes. All ranks call it together.
    pub(super) fn update<const N: usize>(&mut self, scene: &Scene<'_, D, N>, peers: &dyn Peers<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let now = [scene.solid().node_count(), scene.joints().faces.broken.len()];
        let is_stale = self.found_for != Some(now);
        let points = if is_stale { Vec::new() } else { self.own_motion(scene) };
        let mut motion = all(peers, PointsMotion { is_stale, points });
        if motion.iter().any(|of_rank| of_rank.is_stale) {
            self.find(scene, peers);
            self.found_for = Some(now);
            motion = all(peers, PointsMotion { is_stale: false, points: self.own_motion(scene) });
        }
        for (places, of_rank) in self.of_ranks.iter().zip(motion) {
            for (&place, [x, y, z, u, v, w]) in places.iter().zip(of_rank.points) {
                self.points[place as usize] = [x, y, z];
                self.velocities[place as usize] = [u, v, w];
            }
        }
        for (before, &corner) in self.before.iter_mut().zip(&self.corners) {
            *before = scene.solid().velocity_at(corner);
        }
    }

    /// Positions and velocities of the points that this rank owns.
    fn own_motion<const N: usize>(&self, scene: &Scene<'_, D, N>) -> Vec<[f64; 6]>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let solid = scene.solid();
        let motion = |ends: &[u32]| {
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
            let ([x, y, z], [u, v, w]) = (lifted(solid.place(position)), lifted(velocity));
            [x, y, z, u, v, w]
        };
        self.first.windows(2).map(motion).collect()
    }

    /// The corners whose nodes make up a point, one for each node; none if another rank owns it. The nodes
    /// share the force on the point in equal parts.
    pub(super) fn corners_of(&self, point: u32) -> impl ExactSizeIterator<Item = u32> + '_ {
        let nodes = match self.own[point as usize] {
            NONE => &[],
            own => &self.nodes[self.first[own as usize] as usize..self.first[own as usize + 1] as usize],
        };
        nodes.iter().map(|&node| self.corners[node as usize])
    }

    /// Codes of the corners on the surface that this rank owns, ascending, with the velocities of their nodes
    /// one step earlier.
    pub(super) fn motion(&self) -> Vec<(u32, Point<D>)> {
        if self.found_for.is_none() {
            return self.earlier.clone();
        }
        self.codes.iter().copied().zip(self.before.iter().copied()).collect()
    }

    /// A surface that is yet to be found, with the values of [`BodySurface::motion`] of the run that is
    /// continued, or of all ranks.
    pub(super) fn with_motion(mut motion: Vec<(u32, Point<D>)>) -> Self {
        motion.sort_unstable_by_key(|(code, _)| *code);
        Self { earlier: motion, ..Self::default() }
    }

    /// Finds the facets and points anew.
    fn find<const N: usize>(&mut self, scene: &Scene<'_, D, N>, peers: &dyn Peers<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let part = self.find_own(scene);
        let parts = all(peers, part);
        let mut points: Vec<(u32, [usize; 2])> = Vec::new();
        for (rank, part) in parts.iter().enumerate() {
            points.extend(part.points.iter().enumerate().map(|(own, &code)| (code, [rank, own])));
        }
        points.sort_unstable();
        self.of_ranks = parts.iter().map(|part| vec![0; part.points.len()]).collect();
        self.own = vec![NONE; points.len()];
        let here = peers.rank();
        for (place, &(_, [rank, own])) in points.iter().enumerate() {
            self.of_ranks[rank][own] = place as u32;
            if rank == here {
                self.own[place] = own as u32;
            }
        }
        let mut corners: Vec<(u32, u32)> = parts.iter().flat_map(|part| &part.corners).copied().collect();
        corners.sort_unstable();
        let mut sides: Vec<_> = parts.iter().flat_map(|part| &part.sides).copied().collect();
        sides.sort_unstable();
        let point = |corner: u32| {
            let known = corners.binary_search_by_key(&corner, |(code, _)| *code);
            let code = known.map_or(NONE, |place| corners[place].1);
            points.binary_search_by_key(&code, |(code, _)| *code).unwrap_or_default() as u32
        };
        // In the plane the second point counts as the third, too.
        self.facets = sides.iter().map(|(_, (side, _))| [0, 1, D - 1].map(|k| point(side[k]))).collect();
        self.materials = sides.iter().map(|(_, (_, [material, _]))| *material).collect();
        self.bodies = sides.iter().map(|(_, (_, [_, body]))| *body).collect();
        self.points = vec![[0.0; 3]; points.len()];
        self.velocities = vec![[0.0; 3]; points.len()];
    }

    /// Finds the corners and points that this rank owns.
    fn find_own<const N: usize>(&mut self, scene: &Scene<'_, D, N>) -> SurfacePart<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (solid, joints, topology) = (scene.solid(), scene.joints(), scene.topology);
        let owns = |corner: &u32| solid.share().corner(*corner);
        let sides = bare_sides(scene);
        let mut corners: Vec<u32> = sides.iter().flatten().copied().filter(owns).collect();
        corners.sort_unstable();
        corners.dedup();
        let codes: Vec<u32> = corners.iter().map(|&corner| topology.code_of_corner(corner)).collect();
        let known = if self.found_for.is_some() { self.motion() } else { std::mem::take(&mut self.earlier) };
        let before = |(&code, &corner): (&u32, &u32)| match known.binary_search_by_key(&code, |of| of.0) {
            Ok(place) => known[place].1,
            Err(_) => solid.velocity_at(corner),
        };
        self.before = codes.iter().zip(&corners).map(before).collect();
        // The first corner of the group to which each corner belongs, and the corner. A rank that owns a
        // group has all of its corners.
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
        (self.first, self.corners, self.codes) = (Vec::new(), corners, codes);
        self.nodes.clear();
        let mut part = SurfacePart { sides: Vec::new(), corners: Vec::new(), points: Vec::new() };
        for group in members.chunk_by(|a, b| a.0 == b.0) {
            let (begin, code) = (self.nodes.len(), topology.code_of_corner(group[0].0));
            for &(_, place) in group {
                part.corners.push((self.codes[place as usize], code));
                let node = |place: u32| solid.node_at(self.corners[place as usize]);
                if self.nodes[begin..].iter().all(|&other| node(other) != node(place)) {
                    self.nodes.push(place);
                }
            }
            self.first.push(begin as u32);
            part.points.push(code);
        }
        self.first.push(self.nodes.len() as u32);
        part.sides.extend(sides.iter().filter(|side| owns(&side[0])).map(|side| {
            let element = side[0] as usize / N;
            let kinds = [solid.element(element).material, scene.model.mesh.bodies[element]];
            (topology.code_of_side(side), (side.map(|corner| topology.code_of_corner(corner)), kinds))
        }));
        part
    }
}

/// The sides on the surface of which this rank owns a corner, each by its corners as its element has them.
fn bare_sides<const D: usize, const N: usize>(scene: &Scene<'_, D, N>) -> Vec<[u32; D]>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (solid, faces, topology) = (scene.solid(), &scene.joints().faces, scene.topology);
    let broken = faces.broken.iter().flat_map(|&facet| {
        topology.facets[facet as usize]
            .corners
            .map(|side| corners_of_facet::<D, N>(side[0] as usize / N, place_in_element::<D, N>(&side)))
    });
    // A facet without an element on its other side, where a rank has all elements that act: a broken joint
    // whose sides are on different ranks.
    let elements = if topology.is_whole() { 0..0 } else { 0..solid.element_count() };
    let separated = elements.flat_map(|element| {
        let is_separated =
            move |k: &usize| topology.facet_of[element][*k] == NONE && !topology.is_outer(element, *k);
        (0..N).filter(is_separated).map(move |k| corners_of_facet::<D, N>(element, k))
    });
    let all = faces.outer.iter().copied().chain(broken).chain(separated);
    all.filter(|side| side.iter().any(|&corner| solid.share().corner(corner))).collect()
}
