//! The triangles of a surface, at the size of the mesh.
//!
//! Facets of one face that meet in one plane are a patch. Edges between patches are cut into pieces of the
//! given size, then each patch is meshed again in its plane. The skin covers exactly the surface that was
//! given.

use fdem_scenes::random::Random;

use super::delaunay::NONE;
use super::plane::{Plane, Point2};
use super::sizes::Sizes;
use super::surface::Surface;
use super::vector::{Point, circle, cross, distance, dot, length, minus, normal, plus, times, unit};
use crate::grading::stations;

/// Sine of the largest angle between facets of one plane.
const FLAT: f64 = 1e-9;

/// Facets of one face in one plane.
pub(crate) struct Patch {
    pub(crate) face: u32,
    pub(crate) sides: [u32; 2],
    /// Two directions in the plane.
    pub(crate) axes: [Point; 2],
}

/// Triangles that cover a surface.
pub(crate) struct Skin {
    /// The points of the surface come first.
    pub(crate) points: Vec<Point>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Patch of each triangle.
    pub(crate) of: Vec<u32>,
    pub(crate) patches: Vec<Patch>,
    /// The patch of a point inside one; [`NONE`] for points on edges between patches.
    pub(crate) inside: Vec<u32>,
}

/// An edge of facets.
struct Edge {
    ends: [u32; 2],
    /// First point inside the edge, and their number.
    first: u32,
    count: u32,
    /// Whether it is on a curved face: edges of its triangles differ in length anyway, so only long ones are
    /// cut.
    curved: bool,
    /// Whether it has more than two facets: two of them may be of one patch.
    shared: bool,
}

impl Skin {
    /// Meshes the faces of a surface.
    pub(crate) fn new(surface: &Surface, sizes: &Sizes<'_>, seed: u64) -> Self {
        let (of_facet, mut borders) = patches(surface);
        let mut points = surface.nodes.clone();
        for edge in &mut borders {
            edge.first = points.len() as u32;
            divide(&mut points, edge, sizes);
            edge.count = points.len() as u32 - edge.first;
        }
        let mut by_patch: Vec<(u32, u32)> = of_facet.iter().copied().zip(0..).collect();
        by_patch.sort_unstable();
        let fixed = points.len();
        let mut skin = Self {
            points,
            triangles: Vec::new(),
            of: Vec::new(),
            patches: Vec::new(),
            inside: vec![NONE; fixed],
        };
        for facets in by_patch.chunk_by(|one, other| one.0 == other.0) {
            skin.add_patch(surface, facets, &borders, sizes, seed);
        }
        skin
    }

    /// Meshes the facets of one patch.
    fn add_patch(
        &mut self,
        surface: &Surface,
        facets: &[(u32, u32)],
        borders: &[Edge],
        sizes: &Sizes<'_>,
        seed: u64,
    ) {
        let number = self.patches.len() as u32;
        let one = facets[0].1 as usize;
        let axes = axes_of(surface.corners(one));
        let mut triangles = Vec::new();
        for &(_, facet) in facets {
            cut(surface.facets[facet as usize], borders, &mut triangles);
        }
        let mut walls = walls(surface, facets, borders);
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        for corner in triangles.iter_mut().flatten().chain(walls.iter_mut().flatten()) {
            *corner = used.binary_search(corner).unwrap_or(0) as u32;
        }
        let origin = self.points[used[0] as usize];
        let flat: Vec<Point2> = used
            .iter()
            .map(|&point| axes.map(|axis| dot(axis, minus(self.points[point as usize], origin))))
            .collect();
        let fixed = flat.len();
        let place = |[x, y]: Point2| plus(origin, plus(times(axes[0], x), times(axes[1], y)));
        let mut plane = Plane::with_walls(flat, triangles, 0.0, &walls);
        // A facet of a curved face none of whose edges was cut is as small as its neighbours require.
        if fixed > 3 || is_large(surface.corners(one), sizes) {
            plane.fill(
                fixed,
                &|point| sizes.at(place(point)),
                &mut Random::with_stream(seed, u64::from(number)),
            );
        }
        let first = self.points.len() as u32;
        self.points.extend(plane.points[fixed..].iter().map(|&point| place(point)));
        self.inside.resize(self.points.len(), number);
        let global = |local: u32| match used.get(local as usize) {
            Some(&known) => known,
            None => first + local - fixed as u32,
        };
        self.triangles.extend(plane.triangles.iter().map(|triangle| triangle.map(global)));
        self.of.resize(self.triangles.len(), number);
        self.patches.push(Patch { face: surface.faces[one], sides: surface.sides[one], axes });
    }

    /// The corners of a triangle.
    pub(crate) fn corners(&self, triangle: usize) -> [Point; 3] {
        self.triangles[triangle].map(|corner| self.points[corner as usize])
    }
}

/// The pieces of edges that have facets of this patch on both sides and another facet besides: sorted, by
/// their ends in ascending order.
fn walls(surface: &Surface, facets: &[(u32, u32)], borders: &[Edge]) -> Vec<[u32; 2]> {
    let mut edges = Vec::new();
    for &(_, facet) in facets {
        let facet = surface.facets[facet as usize];
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            let place = borders.binary_search_by_key(&[a.min(b), a.max(b)], |edge| edge.ends);
            edges.extend(place.ok().filter(|&place| borders[place].shared));
        }
    }
    edges.sort_unstable();
    let mut walls = Vec::new();
    for twice in edges.windows(2).filter(|pair| pair[0] == pair[1]) {
        let edge = &borders[twice[0]];
        let [a, b] = edge.ends;
        let on = edge.first..edge.first + edge.count;
        let chain: Vec<u32> = std::iter::once(a).chain(on).chain([b]).collect();
        walls.extend(chain.windows(2).map(|pair| [pair[0].min(pair[1]), pair[0].max(pair[1])]));
    }
    walls.sort_unstable();
    walls
}

/// Whether the circle around a facet is too large for the size.
fn is_large(corners: [Point; 3], sizes: &Sizes<'_>) -> bool {
    let size = sizes.at(times(plus(plus(corners[0], corners[1]), corners[2]), 1.0 / 3.0));
    circle(corners[0], corners[1], corners[2]).is_some_and(|(_, square)| square > size * size)
}

/// Two directions of length 1 in the plane of a triangle: counter-clockwise seen from the tip of its normal.
/// Along the axes, exactly, if the plane is.
pub(super) fn axes_of([a, b, c]: [Point; 3]) -> [Point; 2] {
    let normal = unit(normal(a, b, c));
    for axis in 0..3 {
        if normal[(axis + 1) % 3] == 0.0 && normal[(axis + 2) % 3] == 0.0 {
            let mut axes = [[0.0; 3]; 2];
            axes[0][(axis + 1) % 3] = 1.0;
            axes[1][(axis + 2) % 3] = if normal[axis] > 0.0 { 1.0 } else { -1.0 };
            return axes;
        }
    }
    let along = unit(minus(b, a));
    [along, unit(cross(normal, along))]
}

/// The patch of each facet, and the edges between patches in order of their ends.
fn patches(surface: &Surface) -> (Vec<u32>, Vec<Edge>) {
    let count = surface.facets.len();
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * count);
    for (number, facet) in (0..).zip(&surface.facets) {
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], number));
        }
    }
    edges.sort_unstable();
    let mut parent: Vec<u32> = (0..count as u32).collect();
    let mut borders = Vec::new();
    for group in edges.chunk_by(|one, other| one.0 == other.0) {
        let mut curved = false;
        if let &[(_, one), (_, other)] = group {
            if is_smooth(surface, one as usize, other as usize) {
                let (one, other) = (root(&mut parent, one), root(&mut parent, other));
                parent[one.max(other) as usize] = one.min(other);
                continue;
            }
            curved = surface.faces[one as usize] == surface.faces[other as usize];
        }
        borders.push(Edge { ends: group[0].0, first: 0, count: 0, curved, shared: group.len() > 2 });
    }
    let roots = (0..count as u32).map(|facet| root(&mut parent, facet)).collect();
    (roots, borders)
}

/// The flat faces of a surface.
pub(super) struct FlatFaces {
    /// Flat face of each facet.
    pub(super) of_facet: Vec<u32>,
    /// Number of flat faces.
    pub(super) count: usize,
    /// Whether each is a part of a round face.
    pub(super) round: Vec<bool>,
    /// Ends of the edges between them.
    pub(super) edges: Vec<[u32; 2]>,
}

/// The facets of one face in one plane are a flat face; they are numbered in the order of their first facets.
pub(super) fn flat_faces(surface: &Surface) -> FlatFaces {
    let (mut of_facet, borders) = patches(surface);
    let mut roots = of_facet.clone();
    roots.sort_unstable();
    roots.dedup();
    for of in &mut of_facet {
        *of = roots.binary_search(of).unwrap_or(0) as u32;
    }
    let mut round = vec![false; roots.len()];
    for (facet, of) in surface.facets.iter().zip(&of_facet) {
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            let place = borders.binary_search_by_key(&[a.min(b), a.max(b)], |edge| edge.ends);
            round[*of as usize] |= place.is_ok_and(|place| borders[place].curved);
        }
    }
    let edges = borders.into_iter().map(|edge| edge.ends).collect();
    FlatFaces { of_facet, count: roots.len(), round, edges }
}

fn root(parent: &mut [u32], facet: u32) -> u32 {
    let mut at = facet;
    while parent[at as usize] != at {
        parent[at as usize] = parent[parent[at as usize] as usize];
        at = parent[at as usize];
    }
    at
}

/// Whether two neighbours are of one patch.
fn is_smooth(surface: &Surface, one: usize, other: usize) -> bool {
    let [m, n] = [one, other].map(|facet| {
        let [a, b, c] = surface.corners(facet);
        unit(normal(a, b, c))
    });
    surface.faces[one] == surface.faces[other]
        && surface.sides[one] == surface.sides[other]
        && dot(m, n) > 0.0
        && length(cross(m, n)) < FLAT
}

/// Limits the sizes near edges of the surface that are shorter.
pub(crate) fn limit(surface: &Surface, sizes: &mut Sizes<'_>, low: Point, high: Point) {
    let (_, borders) = patches(surface);
    let mut limits = Vec::new();
    let mut sums = vec![[0.0; 2]; surface.nodes.len()];
    for edge in borders {
        let [from, to] = edge.ends.map(|end| surface.nodes[end as usize]);
        let span = distance(from, to);
        let middle = times(plus(from, to), 0.5);
        if span < SHORT * sizes.at(middle) {
            limits.push((middle, span / SHORT));
        }
        for end in edge.ends.into_iter().filter(|_| edge.curved) {
            sums[end as usize][0] += span;
            sums[end as usize][1] += 1.0;
        }
    }
    // Facets of curved faces are not made larger: where most edges are short, so is the size.
    for (&node, [sum, count]) in surface.nodes.iter().zip(sums) {
        if count > 2.0 && sum < FINE * count * sizes.at(node) {
            limits.push((node, sum / count));
        }
    }
    sizes.lower(&limits, low, high);
}

/// Length of an edge over the size, below which the size is reduced.
const SHORT: f64 = 0.5;

/// Mean length of the edges at a node of a curved face over the size, below which the size is reduced.
const FINE: f64 = 0.8;

/// Length of an edge on a curved face over the size, up to which it is not cut.
const LONG: f64 = 1.9;

/// Adds the points that cut an edge into pieces as long as the size says.
fn divide(points: &mut Vec<Point>, edge: &Edge, sizes: &Sizes<'_>) {
    let [from, to] = edge.ends.map(|end| points[end as usize]);
    let span = distance(from, to);
    let along = minus(to, from);
    let at = |t: f64| plus(from, times(along, t));
    let round = |edges: f64| {
        let pieces = if edge.curved && edges < LONG { 1.0 } else { edges.round() };
        pieces.max(1.0) as usize
    };
    if let Sizes::Even(size) = sizes {
        let pieces = round(span / size);
        points.extend((1..pieces).map(|piece| at(piece as f64 / pieces as f64)));
        return;
    }
    points.extend(stations(span, &|t| sizes.at(at(t)), &round).into_iter().map(at));
}

/// Adds the triangles of a facet whose edges are cut.
fn cut(facet: [u32; 3], borders: &[Edge], triangles: &mut Vec<[u32; 3]>) {
    let first = triangles.len();
    triangles.push(facet);
    for k in 0..3 {
        let (a, b) = (facet[k], facet[(k + 1) % 3]);
        let Ok(place) = borders.binary_search_by_key(&[a.min(b), a.max(b)], |edge| edge.ends) else {
            continue;
        };
        let edge = &borders[place];
        if edge.count == 0 {
            continue;
        }
        // The triangle with the edge from a to b becomes a fan.
        let with = (first..triangles.len()).find_map(|t| {
            let corner = (0..3).find(|&k| triangles[t][k] == a && triangles[t][(k + 1) % 3] == b)?;
            Some((t, triangles[t][(corner + 2) % 3]))
        });
        let Some((t, apex)) = with else { continue };
        triangles.swap_remove(t);
        let mut on: Vec<u32> = (edge.first..edge.first + edge.count).collect();
        if a > b {
            on.reverse();
        }
        let ends = std::iter::once(a).chain(on.iter().copied()).zip(on.iter().copied().chain([b]));
        triangles.extend(ends.map(|(from, to)| [from, to, apex]));
    }
}
