//! The arrangement: segments that are cut by each other, and the triangles between them.

use std::collections::{BTreeMap, BTreeSet};

use super::error::{LEAST, PolygonError, SHARP};
use super::sheet::{Sheet, triangulate};
use crate::grading::Grading;
use crate::tetrahedra::plane::Point2;
use crate::tetrahedra::sharpest::beside_inner;
use crate::tetrahedra::skin::FlatFaces;
use crate::tetrahedra::surface::{INNER, OUTSIDE, Surface};
use crate::tetrahedra::vector::{Point, cross, distance, dot, length, minus, plus, times};

/// Rounds of cutting.
const ROUNDS: usize = 8;

/// Points that are the same have one number.
struct Vertices {
    points: Vec<Point>,
    same: f64,
    cells: BTreeMap<[i64; 3], Vec<u32>>,
}

impl Vertices {
    /// The nodes of a surface, which keep their numbers.
    fn new(nodes: &[Point], same: f64) -> Self {
        let mut vertices = Self { points: Vec::new(), same, cells: BTreeMap::new() };
        for &node in nodes {
            vertices.push(node);
        }
        vertices
    }

    fn cell(&self, point: Point) -> [i64; 3] {
        point.map(|x| (x / (4.0 * self.same)).floor() as i64)
    }

    fn push(&mut self, point: Point) -> u32 {
        let number = self.points.len() as u32;
        self.points.push(point);
        self.cells.entry(self.cell(point)).or_default().push(number);
        number
    }

    /// The number of a point.
    fn number(&mut self, point: Point) -> u32 {
        let [x, y, z] = self.cell(point);
        let gap = |other: u32| distance(self.points[other as usize], point);
        let mut nearest: Option<u32> = None;
        for dx in -1..=1 {
            for dy in -1..=1 {
                for &other in (-1..=1).filter_map(|dz| self.cells.get(&[x + dx, y + dy, z + dz])).flatten() {
                    if gap(other) < self.same && nearest.is_none_or(|nearest| gap(other) < gap(nearest)) {
                        nearest = Some(other);
                    }
                }
            }
        }
        nearest.unwrap_or_else(|| self.push(point))
    }

    fn at(&self, number: u32) -> Point {
        self.points[number as usize]
    }
}

/// Triangles in one plane, by their vertices, and which of their edges are segments.
struct Layer {
    triangles: Vec<[u32; 3]>,
    segments: BTreeSet<[u32; 2]>,
}

/// Surface and polygons, cut by each other.
pub(super) struct Arrangement<'a> {
    before: &'a Surface,
    of: &'a FlatFaces,
    faces: Vec<Sheet>,
    polygons: Vec<Sheet>,
    size: &'a Grading<3>,
    vertices: Vertices,
    /// Ends in ascending order.
    segments: Vec<[u32; 2]>,
    /// Whether each flat face has to be triangulated again.
    touched: Vec<bool>,
}

impl<'a> Arrangement<'a> {
    /// Collects all segments, and cuts them.
    pub(super) fn new(
        before: &'a Surface,
        of: &'a FlatFaces,
        faces: Vec<Sheet>,
        polygons: Vec<Sheet>,
        size: &'a Grading<3>,
        same: f64,
    ) -> Self {
        let touched = vec![false; faces.len()];
        let vertices = Vertices::new(&before.nodes, same);
        let mut new = Self { before, of, faces, polygons, size, vertices, segments: Vec::new(), touched };
        let mut segments: Vec<[u32; 2]> = of.edges.clone();
        for number in 0..new.polygons.len() {
            let sheet = &new.polygons[number];
            if sheet.triangles.is_empty() {
                continue;
            }
            let count = sheet.corners.len();
            let mut all: Vec<[Point; 2]> =
                (0..count).map(|k| [sheet.corners[k], sheet.corners[(k + 1) % count]]).collect();
            for (face, other) in new.faces.iter().enumerate() {
                let common = sheet.meet(other, same);
                new.touched[face] |= !common.is_empty();
                all.extend(common);
            }
            all.extend(new.polygons[..number].iter().flat_map(|other| sheet.meet(other, same)));
            for [a, b] in all {
                segments.push([new.vertices.number(a), new.vertices.number(b)]);
            }
        }
        new.segments = unique(segments);
        for _ in 0..ROUNDS {
            if !new.cut() {
                break;
            }
        }
        let nodes = before.nodes.len();
        let added = &new.vertices.points[nodes..];
        for (face, touched) in new.faces.iter().zip(&mut new.touched) {
            let is_on =
                |&point: &Point| face.height(point).abs() < 4.0 * same && face.contains(point, 4.0 * same);
            *touched = *touched || added.iter().any(is_on);
        }
        new
    }

    fn ends(&self, [a, b]: [u32; 2]) -> [Point; 2] {
        [self.vertices.at(a), self.vertices.at(b)]
    }

    /// Cuts segments where they cross each other or pass a vertex. Returns whether there was anything to cut.
    fn cut(&mut self) -> bool {
        let margin = self.vertices.same;
        let boxes: Vec<[Point; 2]> =
            self.segments.iter().map(|&segment| crate::bounds(self.ends(segment).into_iter())).collect();
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        order.sort_by(|&a, &b| boxes[a][0][0].total_cmp(&boxes[b][0][0]).then(a.cmp(&b)));
        let mut cuts: Vec<Vec<(f64, u32)>> = vec![Vec::new(); boxes.len()];
        for (place, &one) in order.iter().enumerate() {
            for &other in &order[place + 1..] {
                if boxes[other][0][0] > boxes[one][1][0] + margin {
                    break;
                }
                let apart = (1..3).any(|axis| {
                    boxes[other][0][axis] > boxes[one][1][axis] + margin
                        || boxes[one][0][axis] > boxes[other][1][axis] + margin
                });
                if !apart {
                    self.compare([one.min(other), one.max(other)], &mut cuts);
                }
            }
        }
        if cuts.iter().all(Vec::is_empty) {
            return false;
        }
        let mut new = Vec::with_capacity(self.segments.len());
        for (&[a, b], cuts) in self.segments.iter().zip(&mut cuts) {
            cuts.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
            let chain = std::iter::once(a).chain(cuts.iter().map(|(_, vertex)| *vertex)).chain([b]);
            let chain: Vec<u32> = chain.collect();
            new.extend(chain.windows(2).map(|pair| [pair[0], pair[1]]));
        }
        self.segments = unique(new);
        true
    }

    /// Notes where two segments cut each other.
    fn compare(&mut self, numbers: [usize; 2], cuts: &mut [Vec<(f64, u32)>]) {
        let ids = numbers.map(|number| self.segments[number]);
        let same = self.vertices.same;
        let mut near = false;
        for side in 0..2 {
            let [a, b] = self.ends(ids[side]);
            let along = minus(b, a);
            for end in ids[1 - side].into_iter().filter(|end| !ids[side].contains(end)) {
                let point = self.vertices.at(end);
                let t = dot(minus(point, a), along) / dot(along, along);
                if t > 0.0 && t < 1.0 && distance(point, plus(a, times(along, t))) < same {
                    cuts[numbers[side]].push((t, end));
                    near = true;
                }
            }
        }
        if near || ids[0].iter().any(|end| ids[1].contains(end)) {
            return;
        }
        let ([a, b], [c, d]) = (self.ends(ids[0]), self.ends(ids[1]));
        let (u, v, w) = (minus(b, a), minus(d, c), minus(c, a));
        let n = cross(u, v);
        let square = dot(n, n);
        if square <= 1e-14 * dot(u, u) * dot(v, v) {
            return;
        }
        let (t, s) = (dot(cross(w, v), n) / square, dot(cross(w, u), n) / square);
        let inside = 0.0..=1.0;
        if !inside.contains(&t) || !inside.contains(&s) {
            return;
        }
        let (p, q) = (plus(a, times(u, t)), plus(c, times(v, s)));
        if distance(p, q) < same {
            let vertex = self.vertices.number(p);
            for (side, place) in [(0, t), (1, s)] {
                if !ids[side].contains(&vertex) {
                    cuts[numbers[side]].push((place, vertex));
                }
            }
        }
    }

    /// The surface with the polygons in it, whose faces are numbered from `first`; `None` if none is inside.
    /// Also returns the places that are too close or too sharp to be meshed.
    pub(super) fn surface(self, first: u32) -> (Option<Surface>, Vec<PolygonError>) {
        let mut faults = Vec::new();
        let surface = self.put_together(first, &mut faults);
        (surface, faults)
    }

    fn put_together(&self, first: u32, faults: &mut Vec<PolygonError>) -> Option<Surface> {
        let mut inner: Vec<([u32; 3], u32)> = Vec::new();
        let mut open: Vec<usize> = (0..self.polygons.len()).collect();
        open.retain(|&number| !self.polygons[number].triangles.is_empty());
        while let Some(&number) = open.first() {
            let one = &self.polygons[number];
            // Polygons that were moved into one plane have one normal and one origin.
            let is_same = |other: &usize| {
                let other = &self.polygons[*other];
                other.normal == one.normal && other.origin == one.origin
            };
            let (group, rest): (Vec<usize>, Vec<usize>) = open.iter().partition(|other| is_same(other));
            self.add_plane(&group, &mut inner, faults);
            open = rest;
        }
        if inner.is_empty() {
            return None;
        }
        let mut new = Surface { names: self.before.names.clone(), ..Surface::default() };
        let mut push = |facet: [u32; 3], face: u32, sides: [u32; 2]| {
            new.facets.push(facet);
            new.faces.push(face);
            new.sides.push(sides);
        };
        for (facet, &of) in self.of.of_facet.iter().enumerate() {
            if !self.touched[of as usize] {
                push(self.before.facets[facet], self.before.faces[facet], self.before.sides[facet]);
            }
        }
        for face in (0..self.faces.len()).filter(|&face| self.touched[face]) {
            let Some(layer) = self.layer(&[&self.faces[face]], faults) else { continue };
            let kept = layer
                .triangles
                .iter()
                .filter(|&&triangle| self.faces[face].contains(self.middle(triangle), 0.0));
            let kept: Vec<[u32; 3]> = kept.copied().collect();
            self.check(&kept, &layer.segments, faults);
            let Some(facet) = self.of.of_facet.iter().position(|&of| of as usize == face) else { continue };
            for triangle in kept {
                push(triangle, self.before.faces[facet], self.before.sides[facet]);
            }
        }
        for &(triangle, polygon) in &inner {
            push(triangle, first + polygon, [INNER; 2]);
        }
        self.number(&mut new);
        if let Some(edge) = beside_inner(&new).filter(|edge| edge.angle < SHARP) {
            let place = times(plus(edge.ends[0], edge.ends[1]), 0.5);
            faults.push(PolygonError::Sharp { polygons: self.nearest_two(place), angle: edge.angle, place });
        }
        Some(new)
    }

    /// Gives the nodes that are used their numbers: those of the surface keep theirs.
    fn number(&self, new: &mut Surface) {
        let nodes = self.before.nodes.len();
        let mut used: Vec<u32> =
            new.facets.iter().flatten().copied().filter(|&node| node as usize >= nodes).collect();
        used.sort_unstable();
        used.dedup();
        new.nodes.clone_from(&self.before.nodes);
        new.nodes.extend(used.iter().map(|&vertex| self.vertices.at(vertex)));
        for node in new.facets.iter_mut().flatten() {
            if let Ok(place) = used.binary_search(node) {
                *node = (nodes + place) as u32;
            }
        }
    }

    fn middle(&self, triangle: [u32; 3]) -> Point {
        let [a, b, c] = triangle.map(|vertex| self.vertices.at(vertex));
        times(plus(plus(a, b), c), 1.0 / 3.0)
    }

    /// Triangulates the plane of sheets between all segments in it; `None` where they are tangled.
    fn layer(&self, sheets: &[&Sheet], faults: &mut Vec<PolygonError>) -> Option<Layer> {
        let (one, margin) = (sheets[0], 4.0 * self.vertices.same);
        let [low, high] = crate::bounds(sheets.iter().flat_map(|sheet| sheet.bounds));
        let is_on = |vertex: u32| {
            let point = self.vertices.at(vertex);
            one.height(point).abs() < margin
                && (0..3).all(|axis| point[axis] >= low[axis] - margin && point[axis] <= high[axis] + margin)
        };
        let segments: Vec<[u32; 2]> =
            self.segments.iter().copied().filter(|ends| ends.iter().all(|&end| is_on(end))).collect();
        // Other vertices in the plane are corners that touch it.
        let ends = self.segments.iter().flatten().copied();
        let mut used: Vec<u32> = ends.filter(|&vertex| is_on(vertex)).collect();
        used.sort_unstable();
        used.dedup();
        let points: Vec<Point2> = used.iter().map(|&vertex| one.flat(self.vertices.at(vertex))).collect();
        let local = |vertex: u32| used.binary_search(&vertex).unwrap_or(0);
        let edges: Vec<[usize; 2]> = segments.iter().map(|ends| ends.map(local)).collect();
        let Some(triangles) = triangulate(&points, &edges) else {
            let place = one.triangles.first().map_or(one.origin, |triangle| triangle[0]);
            faults.push(PolygonError::Close { polygons: self.nearest_two(place), place });
            return None;
        };
        // Between the hull and segments along it, rounding leaves triangles without height.
        let is_flat = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
            let edges = [[a, b], [b, c], [c, a]].map(|[a, b]| [b[0] - a[0], b[1] - a[1]]);
            let longest = edges.iter().map(|edge| edge[0].hypot(edge[1])).fold(0.0, f64::max);
            edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0] < margin * longest
        };
        let triangles = triangles.into_iter().filter(|triangle| !is_flat(triangle));
        let global = |triangle: [u32; 3]| triangle.map(|vertex| used[vertex as usize]);
        Some(Layer { triangles: triangles.map(global).collect(), segments: segments.into_iter().collect() })
    }

    /// Adds the triangles of the polygons of one plane that are inside of the body, with the numbers of their
    /// polygons.
    fn add_plane(&self, group: &[usize], inner: &mut Vec<([u32; 3], u32)>, faults: &mut Vec<PolygonError>) {
        let sheets: Vec<&Sheet> = group.iter().map(|&number| &self.polygons[number]).collect();
        let Some(layer) = self.layer(&sheets, faults) else { return };
        let margin = 4.0 * self.vertices.same;
        let mut kept: Vec<([u32; 3], u32)> = Vec::new();
        for &triangle in &layer.triangles {
            let middle = self.middle(triangle);
            let of = group.iter().find(|&&number| self.polygons[number].contains(middle, 0.0));
            let on_face = |face: &Sheet| face.height(middle).abs() < margin && face.contains(middle, margin);
            if let Some(&polygon) = of.filter(|_| !self.faces.iter().any(on_face)) {
                kept.push((triangle, polygon as u32));
            }
        }
        let mut inside = Vec::new();
        for part in parts(&kept, &layer.segments) {
            let area = |number: usize| {
                let [a, b, c] = kept[number].0.map(|vertex| self.vertices.at(vertex));
                length(cross(minus(b, a), minus(c, a)))
            };
            let largest = part.iter().copied().max_by(|&one, &other| area(one).total_cmp(&area(other)));
            if largest.is_some_and(|largest| self.is_inside(self.middle(kept[largest].0))) {
                inside.extend(part.into_iter().map(|number| kept[number]));
            }
        }
        let triangles: Vec<[u32; 3]> = inside.iter().map(|(triangle, _)| *triangle).collect();
        self.check(&triangles, &layer.segments, faults);
        inner.extend(inside);
    }

    /// Whether a point is inside of the body: facets are seen from it under the angle of the whole sphere.
    fn is_inside(&self, point: Point) -> bool {
        let mut sum = 0.0;
        for (facet, sides) in self.before.sides.iter().enumerate() {
            let sign = f64::from(sides[1] == OUTSIDE) - f64::from(sides[0] == OUTSIDE);
            if sign != 0.0 {
                let [a, b, c] = self.before.corners(facet).map(|corner| minus(corner, point));
                let (x, y, z) = (length(a), length(b), length(c));
                let below = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y;
                sum += sign * libm::atan2(dot(a, cross(b, c)), below);
            }
        }
        // Half of the solid angle each: 2 π inside, 0 outside.
        sum > std::f64::consts::PI
    }

    /// Finds edges, gaps and angles between segments that are too small.
    fn check(&self, triangles: &[[u32; 3]], segments: &BTreeSet<[u32; 2]>, faults: &mut Vec<PolygonError>) {
        let nodes = self.before.nodes.len() as u32;
        for triangle in triangles {
            // Small features of the body itself are left to the mesher.
            if triangle.iter().all(|&vertex| vertex < nodes) {
                continue;
            }
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|step| triangle[(k + step) % 3]);
                let is_segment = |a: u32, b: u32| segments.contains(&[a.min(b), a.max(b)]);
                if !is_segment(a, b) {
                    continue;
                }
                let [p, q, r] = [a, b, c].map(|vertex| self.vertices.at(vertex));
                let least = LEAST * self.size.at(p);
                let (along, off) = (minus(q, p), minus(r, p));
                let (span, t) = (length(along), dot(off, along) / dot(along, along));
                let gap = distance(off, times(along, t));
                if (span < least && a.max(b) >= nodes) || ((0.0..=1.0).contains(&t) && gap < least) {
                    faults.push(PolygonError::Close { polygons: self.nearest_two(p), place: p });
                    continue;
                }
                let angle = libm::atan2(gap, dot(off, along) / span).to_degrees();
                if is_segment(a, c) && angle < SHARP {
                    faults.push(PolygonError::Sharp { polygons: self.nearest_two(p), angle, place: p });
                }
            }
        }
    }

    /// The two polygons nearest to a place: the same twice if only one is near.
    fn nearest_two(&self, place: Point) -> [usize; 2] {
        let reach = self.size.at(place);
        let mut near: Vec<(f64, usize)> = Vec::new();
        for (number, sheet) in self.polygons.iter().enumerate() {
            let gap = sheet.height(place).abs();
            if gap < reach && sheet.contains(place, reach) {
                near.push((gap, number));
            }
        }
        near.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        // A polygon that is far beside the closest pair is not its cause: the surface is.
        let first = near.first().map_or(0, |(_, number)| *number);
        let second = near.get(1).filter(|(gap, _)| *gap < LEAST * reach).map_or(first, |(_, number)| *number);
        [first, second]
    }
}

/// Segments with their ends in ascending order, each once.
fn unique(segments: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    let mut new: Vec<[u32; 2]> =
        segments.into_iter().filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    new.sort_unstable();
    new.dedup();
    new
}

/// Triangles of one polygon that no segment parts.
fn parts(triangles: &[([u32; 3], u32)], segments: &BTreeSet<[u32; 2]>) -> Vec<Vec<usize>> {
    let mut edges: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * triangles.len());
    for (number, (triangle, _)) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], number));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![Vec::new(); triangles.len()];
    for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (one, other) = (pair[0].1, pair[1].1);
        if !segments.contains(&pair[0].0) && triangles[one].1 == triangles[other].1 {
            neighbours[one].push(other);
            neighbours[other].push(one);
        }
    }
    let mut known = vec![false; triangles.len()];
    let mut parts = Vec::new();
    for first in 0..triangles.len() {
        if known[first] {
            continue;
        }
        known[first] = true;
        let mut part = vec![first];
        let mut next = 0;
        while let Some(&number) = part.get(next) {
            next += 1;
            for &other in &neighbours[number] {
                if !known[other] {
                    known[other] = true;
                    part.push(other);
                }
            }
        }
        parts.push(part);
    }
    parts
}
