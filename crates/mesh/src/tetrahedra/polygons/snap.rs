//! Moves of planes and corners that keep small gaps out of the mesh.

use super::error::SNAP;
use super::sheet::Sheet;
use super::warp::RoundNodes;
use crate::grading::Grading;
use crate::tetrahedra::skin::FlatFaces;
use crate::tetrahedra::surface::Surface;
use crate::tetrahedra::vector::{Point, cross, distance, dot, length, minus, normal, plus, times, unit};

/// Sine of the angle up to which a piece that is near another becomes one with it.
const TILT: f64 = 0.35;

/// Flat faces and polygons while they are moved.
pub(super) struct Snapping<'a> {
    pub(super) faces: Vec<Sheet>,
    /// Whether each face is a part of a round one.
    round: Vec<bool>,
    /// Without triangles where there is nothing left of a polygon.
    pub(super) polygons: Vec<Sheet>,
    /// The plane of each polygon: the number of a face, or the number of faces plus that of a polygon.
    planes: Vec<usize>,
    size: &'a Grading<3>,
    /// Distance of points that are the same.
    same: f64,
    /// The box around the body.
    bounds: [Point; 2],
    /// Edges of the surface, and segments that sheets have in common.
    segments: Vec<[Point; 2]>,
    /// Corners of the surface, and crossings of segments with polygons.
    vertices: Vec<Point>,
}

/// The flat faces of a surface.
pub(super) fn sheets_of(surface: &Surface, of: &FlatFaces) -> Vec<Sheet> {
    let mut triangles = vec![Vec::new(); of.count];
    for (facet, &face) in of.of_facet.iter().enumerate() {
        triangles[face as usize].push(surface.corners(facet));
    }
    triangles.into_iter().map(Sheet::of_face).collect()
}

impl<'a> Snapping<'a> {
    pub(super) fn new(
        surface: &Surface,
        of: &FlatFaces,
        polygons: Vec<Sheet>,
        size: &'a Grading<3>,
        same: f64,
    ) -> Self {
        let faces = sheets_of(surface, of);
        // Nodes of round faces can go to where polygons are.
        let nodes = RoundNodes::new(surface, of);
        let mut used: Vec<u32> = of.edges.iter().flatten().copied().collect();
        used.retain(|&node| nodes.is_fixed(node));
        used.sort_unstable();
        used.dedup();
        let at = |node: u32| surface.nodes[node as usize];
        Self {
            planes: (0..polygons.len()).map(|number| faces.len() + number).collect(),
            faces,
            polygons,
            size,
            same,
            bounds: crate::bounds(surface.nodes.iter().copied()),
            segments: of
                .edges
                .iter()
                .filter(|ends| ends.iter().any(|&end| nodes.is_fixed(end)))
                .map(|ends| ends.map(at))
                .collect(),
            round: of.round.clone(),
            vertices: used.into_iter().map(at).collect(),
        }
    }

    fn reach(&self, point: Point) -> f64 {
        SNAP * self.size.at(point)
    }

    /// Makes planes one that nearly coincide, and moves others to the corners and crossings that they nearly
    /// pass: large polygons first, and small ones to them.
    pub(super) fn planes(&mut self) {
        let area =
            |sheet: &Sheet| -> f64 { sheet.triangles.iter().map(|&[a, b, c]| length(normal(a, b, c))).sum() };
        let mut order: Vec<usize> = (0..self.polygons.len()).collect();
        order.retain(|&number| !self.polygons[number].triangles.is_empty());
        order.sort_by(|&a, &b| area(&self.polygons[b]).total_cmp(&area(&self.polygons[a])).then(a.cmp(&b)));
        let mut done: Vec<usize> = Vec::new();
        for number in order {
            match self.same_plane(number, &done) {
                Some(plane) => self.onto(number, plane),
                None => self.shift(number),
            }
            let sheet = &self.polygons[number];
            let [low, high] = self.bounds;
            let is_within = |point: Point| {
                (0..3)
                    .all(|axis| point[axis] >= low[axis] - self.same && point[axis] <= high[axis] + self.same)
            };
            let crossings = self.segments.iter().filter_map(|&ends| self.crossing(sheet, ends));
            let crossings: Vec<Point> = crossings.filter(|&point| is_within(point)).collect();
            let others = self.faces.iter().chain(done.iter().map(|&other| &self.polygons[other]));
            let segments: Vec<[Point; 2]> = others.flat_map(|other| sheet.meet(other, self.same)).collect();
            self.vertices.extend(crossings);
            self.segments.extend(segments);
            done.push(number);
        }
    }

    /// A face or an earlier polygon that a polygon nearly coincides with, as the number of its plane.
    fn same_plane(&self, number: usize, done: &[usize]) -> Option<usize> {
        let sheet = &self.polygons[number];
        let margin = SNAP * self.size.size;
        let is_same = |other: &Sheet| {
            sheet.is_near(other, margin)
                && sheet.angle(other)[0] < TILT
                && sheet.corners.iter().all(|&corner| other.height(corner).abs() < self.reach(corner))
        };
        let face = (0..self.faces.len()).find(|&face| !self.round[face] && is_same(&self.faces[face]));
        face.or_else(|| {
            done.iter().find(|&&other| is_same(&self.polygons[other])).map(|&other| self.planes[other])
        })
    }

    /// Puts a polygon into a plane.
    fn onto(&mut self, number: usize, plane: usize) {
        let of = match plane.checked_sub(self.faces.len()) {
            Some(polygon) => &self.polygons[polygon],
            None => &self.faces[plane],
        };
        let (origin, unit_normal, axes) = (of.origin, of.normal, of.axes);
        let sheet = &mut self.polygons[number];
        (sheet.origin, sheet.normal, sheet.axes) = (origin, unit_normal, axes);
        sheet.flatten();
        self.planes[number] = plane;
    }

    /// Moves a polygon along its normal such that no corner or crossing is near its plane but those in it.
    fn shift(&mut self, number: usize) {
        let sheet = &self.polygons[number];
        let near = |&vertex: &Point| {
            let (height, reach) = (sheet.height(vertex), self.reach(vertex));
            (height.abs() < 2.0 * reach && sheet.contains(vertex, reach)).then_some((height, reach))
        };
        let near: Vec<(f64, f64)> = self.vertices.iter().filter_map(near).collect();
        // The smallest gap that is left, in reaches.
        let gap = |by: f64| {
            let gaps = near.iter().map(|(height, reach)| ((height - by).abs(), reach));
            gaps.filter(|(gap, _)| *gap > self.same).map(|(gap, reach)| gap / reach).fold(1.0, f64::min)
        };
        // Through one of them, or between two.
        let mut heights: Vec<f64> =
            near.iter().filter(|(height, reach)| height.abs() < *reach).map(|(height, _)| *height).collect();
        heights.sort_by(f64::total_cmp);
        let between: Vec<f64> = heights.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect();
        let mut best = (gap(0.0), 0.0);
        for by in heights.into_iter().chain(between) {
            let found = gap(by);
            if best.0 < 1.0 && (found, -by.abs()) > (best.0, -f64::abs(best.1)) {
                best = (found, by);
            }
        }
        if best.1.abs() > 0.0 {
            let sheet = &mut self.polygons[number];
            let by = times(sheet.normal, best.1);
            sheet.origin = plus(sheet.origin, by);
            sheet.corners.iter_mut().for_each(|corner| *corner = plus(*corner, by));
            sheet.flatten();
        }
    }

    /// Where a segment cuts a sheet, or nearly passes it in its plane.
    fn crossing(&self, sheet: &Sheet, [a, b]: [Point; 2]) -> Option<Point> {
        let (h, g) = (sheet.height(a), sheet.height(b));
        if (h > 0.0) == (g > 0.0) && h.abs() > self.same && g.abs() > self.same {
            return None;
        }
        let step = h - g;
        let t = if step.abs() > self.same { (h / step).clamp(0.0, 1.0) } else { return None };
        let point = plus(a, times(minus(b, a), t));
        sheet.contains(point, self.reach(point)).then_some(point)
    }

    /// Moves corners of polygons, within their planes, to the crossings and lines that they are near, and
    /// bends edges to the crossings that they pass.
    pub(super) fn corners(&mut self) {
        for number in 0..self.polygons.len() {
            if self.polygons[number].triangles.is_empty() {
                continue;
            }
            let sheet = &self.polygons[number];
            let on_plane =
                self.vertices.iter().copied().filter(|&vertex| sheet.height(vertex).abs() < self.same);
            let vertices: Vec<Point> = on_plane.collect();
            let corners: Vec<Point> =
                sheet.corners.iter().map(|&corner| self.corner(number, corner, &vertices)).collect();
            let mut bent = Vec::with_capacity(corners.len());
            for k in 0..corners.len() {
                bent.push(corners[k]);
                bent.extend(self.bends([corners[k], corners[(k + 1) % corners.len()]], &vertices));
            }
            let sheet = &mut self.polygons[number];
            sheet.corners = bent;
            if !sheet.flatten() {
                continue;
            }
            // Its corners and the crossings of its edges count for others.
            let sheet = &self.polygons[number];
            let mut new = sheet.corners.clone();
            let count = sheet.corners.len();
            let others = (0..self.polygons.len()).filter(|&other| self.planes[other] != self.planes[number]);
            for other in
                others.map(|other| &self.polygons[other]).filter(|other| sheet.is_near(other, self.same))
            {
                let edges = (0..count).map(|k| [sheet.corners[k], sheet.corners[(k + 1) % count]]);
                new.extend(edges.filter_map(|ends| self.crossing(other, ends)));
            }
            self.vertices.extend(new);
        }
    }

    /// Where a corner of a polygon should be.
    fn corner(&self, number: usize, corner: Point, vertices: &[Point]) -> Point {
        let reach = self.reach(corner);
        let nearest = vertices.iter().min_by(|&&a, &&b| distance(a, corner).total_cmp(&distance(b, corner)));
        if let Some(&vertex) = nearest.filter(|&&vertex| distance(vertex, corner) < reach) {
            return vertex;
        }
        let sheet = &self.polygons[number];
        let mut lines: Vec<(f64, Point, &Sheet)> = Vec::new();
        let polygons = (0..self.polygons.len()).filter(|&other| self.planes[other] != self.planes[number]);
        for other in self.faces.iter().chain(polygons.map(|other| &self.polygons[other])) {
            let sine = sheet.angle(other)[0];
            let height = other.height(corner);
            if other.triangles.is_empty() || height.abs() >= reach * sine {
                continue;
            }
            let across = minus(other.normal, times(sheet.normal, dot(sheet.normal, other.normal)));
            let foot = minus(corner, times(across, height / (sine * sine)));
            if other.contains(foot, reach) {
                lines.push((distance(corner, foot), foot, other));
            }
        }
        lines.sort_by(|one, other| one.0.total_cmp(&other.0));
        let Some(&(_, foot, first)) = lines.first() else { return corner };
        let along = unit(cross(sheet.normal, first.normal));
        for (_, _, second) in &lines[1..] {
            let slope = dot(along, second.normal);
            let t = -second.height(foot) / slope;
            if t.abs() < 1.5 * reach {
                return plus(foot, times(along, t));
            }
        }
        foot
    }

    /// Vertices to which an edge is bent, in their order along it.
    fn bends(&self, [a, b]: [Point; 2], vertices: &[Point]) -> Vec<Point> {
        let along = minus(b, a);
        let square = dot(along, along);
        let mut found: Vec<(f64, Point)> = Vec::new();
        for &vertex in vertices {
            let t = dot(minus(vertex, a), along) / square;
            let reach = self.reach(vertex);
            let gap = distance(vertex, plus(a, times(along, t)));
            let is_free = |end: Point| distance(vertex, end) > reach;
            if t > 0.0 && t < 1.0 && gap < reach && gap > self.same && is_free(a) && is_free(b) {
                found.push((t, vertex));
            }
        }
        found.sort_by(|one, other| one.0.total_cmp(&other.0));
        found.dedup_by(|one, other| distance(one.1, other.1) < self.same);
        found.into_iter().map(|(_, vertex)| vertex).collect()
    }
}
