//! Grains of spheres.
//!
//! Planes between grains cut a sphere in circles, so grains are met at the sphere by arcs. These are cut into
//! chords as long as the size says, and each grain's part of the sphere is meshed between them. The faces
//! between grains stay flat up to their chords, and nothing has to be moved to the sphere.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use fdem_scenes::random::Random;

use crate::grading::stations;
use crate::shapes::cuboid::cuboid;
use crate::shapes::extrusion::{ears, join, no_crossing, twice_area};
use crate::shapes::grains::{
    Behind, Cell, SAME, cell_of, contract, convex, cut, leave_out_unused, merge, spread, with_lengths,
};
use crate::shapes::round::{sphere, square_axes};
use crate::tetrahedra::plane::{Plane, Point2};
use crate::tetrahedra::vector::{Point, cross, dot, length, minus, normal, plus, times, unit};
use crate::tetrahedra::{MeshError, OUTSIDE, Size, Surface, Tetrahedra};

/// Rounds in which seeds move to the centres of their grains, and length of edges over the cube root of the
/// mean volume of a grain, below which they are contracted. Both are larger than in bodies with flat faces:
/// with 12 rounds and 0.2, the least angle of six first meshes of 100 grains was between 3.8° and 5.7°. With
/// these it is above 8° in 29 of 30, and 6.3° in one.
const ROUNDS: usize = 60;
const SHORT: f64 = 0.42;

/// Longest pieces of arcs over the cube root of the mean volume of a grain, and their largest angle.
const PIECE: f64 = 0.5;
const WIDE: f64 = 1.0;

/// Pieces of arcs over the length below which edges are contracted, at least.
const KEPT: f64 = 1.1;

/// Distance from the sphere over its radius up to which nodes are on it.
const ROUNDING: f64 = 1e-12;

/// Size of the facets of the polyhedron in which seeds are spread over the radius.
const COARSE: f64 = 0.3;

/// Cuts a sphere into grains: the regions `0..count` of one surface, whose meshes share nodes.
///
/// The grains are made as by [`grains`](crate::shapes::grains()). All nodes of the outer surface are on the
/// sphere. Face 0 is the `surface`, and each face between two grains has another number.
///
/// Angles of a mesh are good if it has two or more elements across a grain: 9° or more in 550 spheres of 2 to
/// 70 grains with four elements across one.
///
/// # Cost
/// Time grows with the square of `count`: about 0.7 s for 100 grains, 1 s for 150.
///
/// # Errors
/// [`MeshError::NotFinite`], [`MeshError::Length`], [`MeshError::Size`], [`MeshError::TooMany`];
/// [`MeshError::Empty`] if `count` is 0; errors of [`Surface::check`].
pub fn grains_of_sphere(
    centre: [f64; 3],
    radius: f64,
    count: usize,
    size: &Size<'_>,
    seed: u64,
) -> Result<Surface, MeshError> {
    if count == 0 {
        return Err(MeshError::Empty);
    }
    // Checks all but the grains.
    let smooth = sphere(centre, radius, size, seed)?;
    if count == 1 {
        return Ok(smooth);
    }
    let whole = convex(&sphere([0.0; 3], 1.0, &|_| COARSE, seed)?)?;
    let seeds = spread(&whole, count, ROUNDS, seed);
    let around = convex(&cuboid([-1.5; 3], [1.5; 3])?)?;
    let cells: Vec<Cell> = (0..count).map(|grain| cell_of(&around, &seeds, grain)).collect();
    let mean = libm::cbrt(4.0 / 3.0 * PI / count as f64);
    let most = (PIECE * mean).min(WIDE);
    let size = |place: Point| (size(plus(centre, times(place, radius))) / radius).min(most);
    with_lengths(SHORT * mean, &|short| {
        let mut surface = Parts::new(&cells, most, short).surface(short, &size, seed)?;
        for node in &mut surface.nodes {
            *node = plus(centre, times(*node, radius));
        }
        Ok(surface)
    })
}

/// Moves nodes of the outer surface onto a sphere: those that cut its facets.
///
/// `mesh` is that of [`grains_of_sphere`].
pub fn onto_sphere(mesh: &mut Tetrahedra, centre: [f64; 3], radius: f64) {
    let Tetrahedra { nodes, facets, faces, .. } = mesh;
    for facet in facets.iter().zip(faces).filter(|(_, face)| **face == 0).map(|(facet, _)| facet) {
        for &node in facet {
            let node = &mut nodes[node as usize];
            let off = minus(*node, centre);
            // Nodes that are on it but for rounding stay.
            if length(off) < (1.0 - ROUNDING) * radius {
                *node = plus(centre, times(off, radius / length(off)));
            }
        }
    }
}

/// The part of a face between two grains that is in the sphere.
struct Face {
    /// Corners counter-clockwise seen from before, each with whether the edge to the next is a chord of the
    /// sphere.
    corners: Vec<(u32, bool)>,
    /// The grains behind and before.
    grains: [u32; 2],
}

/// The faces between grains in the sphere of radius 1 around the origin.
struct Parts {
    points: Vec<Point>,
    /// Empty for points inside, one number for points on the sphere.
    on: Vec<Vec<u32>>,
    faces: Vec<Face>,
}

impl Parts {
    /// Cuts the faces of cells by the sphere. Arcs have pieces no longer than `most`, and so long that they
    /// are not contracted.
    fn new(cells: &[Cell], most: f64, short: f64) -> Self {
        let all: Vec<Point> = cells.iter().flat_map(|cell| cell.points.iter().copied()).collect();
        let (points, numbers) = merge(&all, SAME);
        let mut new = Self { on: vec![Vec::new(); points.len()], points, faces: Vec::new() };
        let mut known = BTreeMap::new();
        let mut first = 0;
        for (grain, cell) in (0..).zip(cells) {
            for (behind, polygon) in &cell.faces {
                let Behind::Grain(other) = *behind else { continue };
                if grain < other {
                    let mut corners: Vec<u32> =
                        polygon.iter().map(|&node| numbers[first + node as usize]).collect();
                    corners.dedup();
                    if corners.len() > 1 && corners.first() == corners.last() {
                        corners.pop();
                    }
                    new.add_face(&corners, [grain, other], &mut known, most, short);
                }
            }
            first += cell.points.len();
        }
        new
    }

    fn add_point(&mut self, point: Point) -> u32 {
        self.points.push(unit(point));
        self.on.push(vec![0]);
        self.points.len() as u32 - 1
    }

    /// The part of an edge that is in the sphere.
    fn inside(&mut self, [a, b]: [u32; 2]) -> Option<[u32; 2]> {
        let [p, q] = [a, b].map(|end| self.points[end as usize]);
        let along = minus(q, p);
        let (square, half) = (dot(along, along), dot(p, along));
        let root = half * half - square * (dot(p, p) - 1.0);
        if root <= 0.0 {
            return None;
        }
        let [enters, leaves] = [-1.0, 1.0].map(|sign| (sign * root.sqrt() - half) / square);
        if enters >= 1.0 || leaves <= 0.0 {
            return None;
        }
        let from = if dot(p, p) < 1.0 { a } else { self.add_point(plus(p, times(along, enters))) };
        let to = if dot(q, q) < 1.0 { b } else { self.add_point(plus(p, times(along, leaves))) };
        Some([from, to])
    }

    fn add_face(
        &mut self,
        polygon: &[u32],
        grains: [u32; 2],
        known: &mut BTreeMap<[u32; 2], Option<[u32; 2]>>,
        most: f64,
        short: f64,
    ) {
        let mut pieces = Vec::new();
        for (k, &a) in polygon.iter().enumerate() {
            let b = polygon[(k + 1) % polygon.len()];
            let ends = [a.min(b), a.max(b)];
            let piece = match known.get(&ends) {
                Some(&piece) => piece,
                None => *known.entry(ends).or_insert(self.inside(ends)),
            };
            pieces.extend(piece.map(|[from, to]| if a < b { [from, to] } else { [to, from] }));
        }
        let at = |node: u32| self.points[node as usize];
        let Some(circle) = Circle::of(polygon.iter().map(|&node| at(node))) else { return };
        let mut corners = Vec::new();
        if pieces.is_empty() {
            let within = (0..polygon.len()).all(|k| {
                let [a, b] = [polygon[k], polygon[(k + 1) % polygon.len()]].map(at);
                dot(circle.normal, cross(minus(b, a), minus(circle.centre, a))) > 0.0
            });
            if !within {
                return;
            }
            let start = plus(circle.centre, times(circle.across(), circle.radius));
            let node = self.add_point(start);
            corners.push((node, true));
            self.add_arc(&mut corners, &circle, start, TAU, most, short);
        }
        for (k, &[from, to]) in pieces.iter().enumerate() {
            corners.push((from, false));
            let next = pieces[(k + 1) % pieces.len()][0];
            if to != next {
                corners.push((to, true));
                let [start, end] = [to, next].map(|node| self.points[node as usize]);
                self.add_arc(&mut corners, &circle, start, circle.angle(start, end), most, short);
            }
        }
        self.faces.push(Face { corners, grains });
    }

    /// Adds the points inside an arc.
    fn add_arc(
        &mut self,
        corners: &mut Vec<(u32, bool)>,
        circle: &Circle,
        start: Point,
        angle: f64,
        most: f64,
        short: f64,
    ) {
        let long = angle * circle.radius;
        let wanted = (long / most).max(angle / WIDE).ceil().max(2.0);
        let kept = if short > 0.0 { (long / (KEPT * short)).floor() } else { wanted };
        let pieces = wanted.min(kept).max((angle / 1.5).ceil()).max(1.0) as usize;
        for piece in 1..pieces {
            let node = self.add_point(circle.turned(start, angle * piece as f64 / pieces as f64));
            corners.push((node, true));
        }
    }

    /// The surface of all grains, after short edges are contracted.
    fn surface(&self, short: f64, size: &Size<'_>, seed: u64) -> Result<Surface, MeshError> {
        let outlines: Vec<Vec<u32>> =
            self.faces.iter().map(|face| face.corners.iter().map(|corner| corner.0).collect()).collect();
        let middle =
            |place: Point, of: u32| if self.on[of as usize].is_empty() { place } else { unit(place) };
        let (points, to) =
            contract(&self.points, &self.on, outlines.iter().map(|outline| &outline[..]), short, &middle);
        let mut surface = Surface { nodes: points, names: vec!["surface".to_owned()], ..Surface::default() };
        // Points on each chord, from the lower number to the higher, and the chords around the parts of the
        // sphere.
        let mut chords: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        let mut rims: BTreeMap<u32, BTreeMap<u32, u32>> = BTreeMap::new();
        for (number, face) in (1..).zip(&self.faces) {
            let count = face.corners.len();
            let edges: Vec<([u32; 2], bool)> = (0..count)
                .map(|k| {
                    let ends = [face.corners[k].0, face.corners[(k + 1) % count].0];
                    (ends.map(|node| to[node as usize]), face.corners[k].1)
                })
                .filter(|([a, b], _)| a != b)
                .collect();
            let Some(&([first, _], _)) = edges.first() else { continue };
            let degenerate = MeshError::Degenerate { facet: 0, place: surface.nodes[first as usize] };
            if edges.len() < 3 {
                // The remaining part of a chord would be between two parts of the sphere.
                if edges.iter().any(|edge| edge.1) {
                    return Err(degenerate);
                }
                continue;
            }
            let mut triangles = cut(&surface.nodes, edges.iter().map(|edge| edge.0[0]).collect())?;
            for &([a, b], _) in edges.iter().filter(|edge| edge.1) {
                for (grain, [from, to]) in [(face.grains[0], [b, a]), (face.grains[1], [a, b])] {
                    if rims.entry(grain).or_default().insert(from, to).is_some() {
                        return Err(degenerate);
                    }
                }
                let on =
                    divide(&mut surface.nodes, &mut triangles, [a, b], size).ok_or(degenerate.clone())?;
                if chords.insert([a.min(b), a.max(b)], on).is_some() {
                    return Err(degenerate);
                }
            }
            for facet in triangles {
                surface.facets.push(facet);
                surface.sides.push(face.grains);
                surface.faces.push(number);
            }
        }
        for (grain, rim) in rims {
            let mut random = Random::with_stream(seed, u64::from(grain));
            add_part(&mut surface, grain, rings(rim, &chords), size, &mut random)?;
        }
        leave_out_unused(&mut surface);
        Ok(surface)
    }
}

/// Replaces the triangle at a chord by triangles up to points on the sphere in its plane. Returns these
/// points, from the lower end to the higher.
fn divide(
    nodes: &mut Vec<Point>,
    triangles: &mut Vec<[u32; 3]>,
    [a, b]: [u32; 2],
    size: &Size<'_>,
) -> Option<Vec<u32>> {
    let (t, apex) = triangles.iter().enumerate().find_map(|(t, corners)| {
        let k = (0..3).find(|&k| corners[k] == a && corners[(k + 1) % 3] == b)?;
        Some((t, corners[(k + 2) % 3]))
    })?;
    let [start, end, tip] = [a, b, apex].map(|node| nodes[node as usize]);
    let circle = Circle::of([start, end, tip].into_iter())?;
    let angle = circle.angle(start, end);
    if angle > FRAC_PI_2 {
        return None;
    }
    let at = |part: f64| circle.turned(start, part * angle);
    let round = |pieces: f64| pieces.round().max(1.0) as usize;
    let parts = stations(angle * circle.radius, &|part| size(at(part)), &round);
    let mut on = Vec::with_capacity(parts.len());
    for part in parts {
        on.push(nodes.len() as u32);
        nodes.push(unit(at(part)));
    }
    triangles.swap_remove(t);
    let ends = std::iter::once(a).chain(on.iter().copied()).zip(on.iter().copied().chain([b]));
    triangles.extend(ends.map(|(from, to)| [from, to, apex]));
    if a > b {
        on.reverse();
    }
    Some(on)
}

/// The rings of chords around a part of the sphere, with all their points.
fn rings(mut rim: BTreeMap<u32, u32>, chords: &BTreeMap<[u32; 2], Vec<u32>>) -> Vec<Vec<u32>> {
    let mut rings = Vec::new();
    while let Some((mut a, mut b)) = rim.pop_first() {
        let mut ring = Vec::new();
        loop {
            ring.push(a);
            let on = chords.get(&[a.min(b), a.max(b)]).map_or(&[][..], |on| on);
            if a < b {
                ring.extend(on);
            } else {
                ring.extend(on.iter().rev());
            }
            let Some(next) = rim.remove(&b) else { break };
            (a, b) = (b, next);
        }
        rings.push(ring);
    }
    rings
}

/// Meshes the part of the sphere that belongs to a grain, between its rings, in a plane on which angles are
/// those on the sphere.
fn add_part(
    surface: &mut Surface,
    grain: u32,
    mut rings: Vec<Vec<u32>>,
    size: &Size<'_>,
    random: &mut Random,
) -> Result<(), MeshError> {
    let used: Vec<u32> = rings.iter().flatten().copied().collect();
    let middle = middle_of(&surface.nodes, &rings);
    let axes = square_axes(middle);
    let mut flat: Vec<Point2> = Vec::with_capacity(used.len());
    for &node in &used {
        let point = surface.nodes[node as usize];
        let far = 1.0 + dot(point, middle);
        flat.push(axes.map(|axis| 2.0 * dot(axis, point) / far));
    }
    for (number, node) in (0..).zip(rings.iter_mut().flatten()) {
        *node = number;
    }
    // The outer ring first.
    rings.sort_by(|one, other| twice_area(&flat, other).total_cmp(&twice_area(&flat, one)));
    if rings.iter().skip(1).any(|ring| twice_area(&flat, ring) > 0.0) {
        return Err(MeshError::Sides { place: middle });
    }
    no_crossing(&flat, &rings)?;
    let triangles = ears(&flat, join(&flat, rings)?)?;
    let fixed = flat.len();
    let place = |[x, y]: Point2| {
        let square = x * x + y * y;
        let across = plus(times(axes[0], 4.0 * x), times(axes[1], 4.0 * y));
        times(plus(across, times(middle, 4.0 - square)), 1.0 / (4.0 + square))
    };
    let mut plane = Plane::new(flat, triangles, 0.0);
    plane.fill(fixed, &|[x, y]| size(place([x, y])) * (1.0 + 0.25 * (x * x + y * y)), random);
    let start = surface.nodes.len() as u32;
    surface.nodes.extend(plane.points[fixed..].iter().map(|&point| unit(place(point))));
    for triangle in plane.triangles {
        let corners = triangle.map(|k| used.get(k as usize).copied().unwrap_or(start + k - fixed as u32));
        surface.facets.push(corners);
        surface.sides.push([grain, OUTSIDE]);
        surface.faces.push(0);
    }
    Ok(())
}

/// The direction of the area between rings.
fn middle_of(nodes: &[Point], rings: &[Vec<u32>]) -> Point {
    let area = |ring: &Vec<u32>| {
        let corner = |k: usize| nodes[ring[k % ring.len()] as usize];
        (0..ring.len()).map(|k| cross(corner(k), corner(k + 1))).fold([0.0; 3], plus)
    };
    unit(rings.iter().map(area).fold([0.0; 3], plus))
}

/// The circle in which a plane cuts the sphere.
struct Circle {
    normal: Point,
    centre: Point,
    radius: f64,
}

impl Circle {
    /// The circle in the plane of a polygon; `None` if the plane does not cut the sphere.
    fn of(polygon: impl Iterator<Item = Point>) -> Option<Self> {
        let corners: Vec<Point> = polygon.collect();
        let sum = corners.windows(2).skip(1).map(|pair| normal(corners[0], pair[0], pair[1]));
        let normal = unit(sum.fold([0.0; 3], plus));
        let height = dot(normal, corners.first().copied()?);
        (height.abs() < 1.0).then(|| Self {
            normal,
            centre: times(normal, height),
            radius: (1.0 - height * height).sqrt(),
        })
    }

    /// A direction in the plane.
    fn across(&self) -> Point {
        square_axes(self.normal)[0]
    }

    /// The angle from a point to another, counter-clockwise, from 0 to 2π.
    fn angle(&self, from: Point, to: Point) -> f64 {
        let (u, v) = (minus(from, self.centre), minus(to, self.centre));
        let angle = libm::atan2(dot(self.normal, cross(u, v)), dot(u, v));
        if angle < 0.0 { angle + TAU } else { angle }
    }

    /// A point, turned.
    fn turned(&self, point: Point, angle: f64) -> Point {
        let off = minus(point, self.centre);
        let (sine, cosine) = libm::sincos(angle);
        plus(self.centre, plus(times(off, cosine), times(cross(self.normal, off), sine)))
    }
}
