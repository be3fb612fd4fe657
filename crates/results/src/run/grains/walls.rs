//! Walls as triangles, where they are. Walls without ends are cut off around the spheres and bodies.

use std::collections::BTreeMap;

use fdem_simulation::grains::{SphereColumns, WallShape};

use crate::arrays::each;

/// A point or a vector.
type Vector = [f64; 3];

/// The least and the greatest coordinate on each axis.
pub(crate) type Bounds = [[f64; 2]; 3];

/// Bounds of nothing.
pub(crate) const EMPTY: Bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 3];

/// Sides of a tube, a cone and a disc.
const SIDES: usize = 48;

/// Sides from one line along a tube or a cone to the next.
const LINES: usize = 12;

/// A triangle of a wall. In the plane it is a segment, and its third corner is its second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WallTriangle {
    /// Corners, m.
    pub(crate) corners: [Vector; 3],
    /// The wall.
    pub(crate) wall: u32,
    /// Bits of its edges from corner `k` to corner `k + 1` that are lines: its ends, and where it has an
    /// angle.
    pub(crate) lines: u8,
}

/// Returns the bounds that contain both.
pub(crate) fn union(one: Bounds, other: Bounds) -> Bounds {
    each(|axis| [one[axis][0].min(other[axis][0]), one[axis][1].max(other[axis][1])])
}

/// Whether bounds contain a point.
pub(crate) fn is_somewhere(bounds: &Bounds) -> bool {
    bounds.iter().all(|[low, high]| low <= high && low.is_finite() && high.is_finite())
}

/// Returns the bounds of points.
pub(crate) fn bounds_of(points: impl IntoIterator<Item = Vector>) -> Bounds {
    points.into_iter().fold(EMPTY, |bounds, point| union(bounds, point.map(|x| [x, x])))
}

/// Returns the walls as triangles. `around`: the bounds of spheres and bodies. Planes reach as far as these
/// bounds and the other planes near them, so that the walls of a box meet.
pub(crate) fn triangles(spheres: &SphereColumns, around: Bounds) -> Vec<WallTriangle> {
    let flat = spheres.discs.is_some();
    let region = region(spheres, around);
    let mut triangles = Vec::new();
    for (number, wall) in (0..).zip(&spheres.walls) {
        let mut sheet = WallSheet { wall: number, flat, region, triangles: &mut triangles };
        match &wall.shape {
            WallShape::Plane { point, normal } => sheet.plane(*point, *normal),
            WallShape::Tube { axis, radius } => {
                let along = unit(minus(axis[1], axis[0]));
                let [low, high] = sheet.reach(axis[0], along);
                let ends = [low, high].map(|at| plus(axis[0], times(at, along)));
                sheet.cone(ends, [*radius; 2]);
            }
            WallShape::Cone { axis, radii } => sheet.cone(*axis, *radii),
            WallShape::Disc { centre, normal, radius } => sheet.disc(*centre, *normal, *radius),
            WallShape::Mesh { triangles } => sheet.mesh(triangles),
        }
    }
    triangles.retain(|triangle| triangle.corners.as_flattened().iter().all(|x| x.is_finite()));
    triangles
}

/// Returns the bounds with the points of planes nearest to their middle, where these are near.
fn region(spheres: &SphereColumns, around: Bounds) -> Bounds {
    let around = if is_somewhere(&around) { around } else { [[-0.5, 0.5]; 3] };
    let middle = around.map(|[low, high]| 0.5 * (low + high));
    let size = length(around.map(|[low, high]| high - low));
    let mut region = around;
    for wall in &spheres.walls {
        let WallShape::Plane { point, normal } = wall.shape else { continue };
        let normal = unit(normal);
        let distance = dot(minus(middle, point), normal);
        if distance.abs() <= 1.5 * size {
            let foot = plus(middle, times(-distance, normal));
            region = union(region, foot.map(|x| [x, x]));
        }
    }
    region
}

/// The triangles of a wall.
struct WallSheet<'a> {
    wall: u32,
    flat: bool,
    region: Bounds,
    triangles: &'a mut Vec<WallTriangle>,
}

impl WallSheet<'_> {
    fn add(&mut self, corners: [Vector; 3], lines: u8) {
        self.triangles.push(WallTriangle { corners, wall: self.wall, lines });
    }

    fn segment(&mut self, [a, b]: [Vector; 2]) {
        self.add([a, b, b], 1);
    }

    /// Returns the least and the greatest distance of the region from a point along a direction.
    fn reach(&self, from: Vector, along: Vector) -> [f64; 2] {
        (0..8).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], bits| {
            let corner = each(|axis| self.region[axis][bits >> axis & 1]);
            let at = dot(minus(corner, from), along);
            [low.min(at), high.max(at)]
        })
    }

    fn plane(&mut self, point: Vector, normal: Vector) {
        let normal = unit(normal);
        if self.flat {
            let along = [-normal[1], normal[0], 0.0];
            let ends = self.reach(point, along).map(|at| plus(point, times(at, along)));
            return self.segment(ends);
        }
        let axes = across(normal);
        let [u, v] = axes.map(|axis| self.reach(point, axis));
        let corner = |x: f64, y: f64| plus(point, plus(times(x, axes[0]), times(y, axes[1])));
        let [a, b, c, d] = [corner(u[0], v[0]), corner(u[1], v[0]), corner(u[1], v[1]), corner(u[0], v[1])];
        self.add([a, b, c], 0b011);
        self.add([a, c, d], 0b110);
    }

    /// A cone between two points of its axis, or a tube.
    fn cone(&mut self, [from, to]: [Vector; 2], radii: [f64; 2]) {
        let along = unit(minus(to, from));
        if self.flat && along[2].abs() < 0.5 {
            let side = [-along[1], along[0], 0.0];
            for sign in [1.0, -1.0] {
                let ends = [0, 1].map(|end| plus([from, to][end], times(sign * radii[end], side)));
                self.segment(ends);
            }
            return;
        }
        let rings = [0, 1].map(|end| ring([from, to][end], along, radii[end]));
        if self.flat {
            return self.round(&rings[0]);
        }
        for k in 0..SIDES {
            let next = (k + 1) % SIDES;
            let [a, b, c, d] = [rings[0][k], rings[0][next], rings[1][next], rings[1][k]];
            let line = if k % LINES == 0 { 0b100 } else { 0 };
            // Where a radius is 0, one of them has no area.
            if radii[0] > 0.0 {
                self.add([a, b, c], 0b001);
            }
            if radii[1] > 0.0 {
                self.add([a, c, d], 0b010 | line);
            }
        }
    }

    /// A circle of the plane.
    fn round(&mut self, ring: &[Vector; SIDES]) {
        for k in 0..SIDES {
            self.segment([ring[k], ring[(k + 1) % SIDES]]);
        }
    }

    fn disc(&mut self, centre: Vector, normal: Vector, radius: f64) {
        let normal = unit(normal);
        if self.flat {
            let side = times(radius, [-normal[1], normal[0], 0.0]);
            return self.segment([minus(centre, side), plus(centre, side)]);
        }
        let ring = ring(centre, normal, radius);
        for k in 0..SIDES {
            self.add([centre, ring[k], ring[(k + 1) % SIDES]], 0b010);
        }
    }

    fn mesh(&mut self, triangles: &[[Vector; 3]]) {
        if self.flat {
            for &[a, b, _] in triangles {
                self.segment([a, b]);
            }
            return;
        }
        let lines = angular(triangles);
        for (&corners, lines) in triangles.iter().zip(lines) {
            self.add(corners, lines);
        }
    }
}

/// Returns the bits of the edges of triangles that have no neighbour, or an angle of more than 25 degrees.
fn angular(triangles: &[[Vector; 3]]) -> Vec<u8> {
    // The cosine of the angle.
    const FLAT: f64 = 0.906;
    let key = |point: Vector| point.map(|x| (x + 0.0).to_bits());
    let normals: Vec<Vector> =
        triangles.iter().map(|&[a, b, c]| unit(cross(minus(b, a), minus(c, a)))).collect();
    // Triangles and edges with the same ends.
    let mut edges: BTreeMap<[[u64; 3]; 2], Vec<(usize, usize)>> = BTreeMap::new();
    for (triangle, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (key(corners[k]), key(corners[(k + 1) % 3]));
            edges.entry([a.min(b), a.max(b)]).or_default().push((triangle, k));
        }
    }
    let mut lines = vec![0; triangles.len()];
    for sharing in edges.values() {
        // Neighbours may have opposite orientations.
        let flat = sharing.len() == 2 && dot(normals[sharing[0].0], normals[sharing[1].0]).abs() > FLAT;
        if !flat {
            for &(triangle, k) in sharing {
                lines[triangle] |= 1 << k;
            }
        }
    }
    lines
}

/// Points on a circle about an axis of unit length.
fn ring(centre: Vector, axis: Vector, radius: f64) -> [Vector; SIDES] {
    let [u, v] = across(axis);
    each(|k| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / SIDES as f64);
        plus(centre, plus(times(radius * cos, u), times(radius * sin, v)))
    })
}

/// Two directions across a unit vector, along the axes where it is along one.
fn across(normal: Vector) -> [Vector; 2] {
    let largest = (0..3).fold(0, |most, k| if normal[k].abs() > normal[most].abs() { k } else { most });
    let start: Vector = each(|k| f64::from(u8::from(k == (largest + 1) % 3)));
    let u = unit(minus(start, times(dot(start, normal), normal)));
    [u, cross(normal, u)]
}

fn plus(a: Vector, b: Vector) -> Vector {
    each(|k| a[k] + b[k])
}

fn minus(a: Vector, b: Vector) -> Vector {
    each(|k| a[k] - b[k])
}

fn times(factor: f64, a: Vector) -> Vector {
    a.map(|x| factor * x)
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// Returns a vector of unit length. That of 0 is not finite.
fn unit(a: Vector) -> Vector {
    times(1.0 / length(a), a)
}

#[cfg(test)]
mod tests {
    use fdem_simulation::grains::Wall;

    use super::*;

    fn walls(shapes: Vec<WallShape>, discs: Option<f64>) -> Vec<WallTriangle> {
        let wall = |shape| Wall { shape, ..Wall::plane([0.0; 3], [1.0; 3], 0) };
        let spheres = SphereColumns {
            walls: shapes.into_iter().map(wall).collect(),
            discs,
            ..SphereColumns::default()
        };
        triangles(&spheres, [[0.2, 0.8], [0.2, 0.8], [0.1, 0.5]])
    }

    fn area(triangles: &[WallTriangle]) -> f64 {
        triangles
            .iter()
            .map(|&WallTriangle { corners: [a, b, c], .. }| 0.5 * length(cross(minus(b, a), minus(c, a))))
            .sum()
    }

    /// The walls of a box without a lid: they meet at its edges, and end with the spheres above.
    #[test]
    fn planes_of_a_box_meet() {
        let planes: Vec<WallShape> = [
            ([0.0; 3], [0.0, 0.0, 2.0]),
            ([0.0; 3], [1.0, 0.0, 0.0]),
            ([1.0; 3], [-1.0, 0.0, 0.0]),
            ([0.0; 3], [0.0, 1.0, 0.0]),
            ([1.0; 3], [0.0, -1.0, 0.0]),
        ]
        .into_iter()
        .map(|(point, normal)| WallShape::Plane { point, normal })
        .collect();
        let found = walls(planes, None);
        assert_eq!(found.len(), 10);
        assert_eq!(
            bounds_of(found.iter().flat_map(|triangle| triangle.corners)),
            [[0.0, 1.0], [0.0, 1.0], [0.0, 0.5]]
        );
        assert!((area(&found) - (1.0 + 4.0 * 0.5)).abs() < 1e-12, "{}", area(&found));
    }

    #[test]
    fn round_walls_have_their_areas() {
        let tube = WallShape::Tube { axis: [[0.5, 0.5, 9.0], [0.5, 0.5, 8.0]], radius: 0.5 };
        let cone = WallShape::Cone { axis: [[0.0; 3], [0.0, 3.0, 0.0]], radii: [0.0, 4.0] };
        let disc = WallShape::Disc { centre: [0.0; 3], normal: [0.0, 3.0, 0.0], radius: 2.0 };
        let pi = std::f64::consts::PI;
        for (shape, expected) in [(tube, pi * 0.4), (cone, pi * 4.0 * 5.0), (disc, pi * 4.0)] {
            let found = area(&walls(vec![shape.clone()], None));
            assert!((found / expected - 1.0).abs() < 4e-3, "{shape:?}: {found} {expected}");
        }
    }

    #[test]
    fn meshes_have_lines_where_they_have_angles_and_ends() {
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let up = [0.0, 0.0, 1.0];
        let found = walls(vec![WallShape::Mesh { triangles: vec![[a, b, c], [c, d, a], [a, b, up]] }], None);
        // The diagonal has none; the edge from a to b has an angle.
        let lines: Vec<u8> = found.iter().map(|triangle| triangle.lines).collect();
        assert_eq!(lines, [0b011, 0b011, 0b111]);
    }

    #[test]
    fn walls_of_the_plane_are_segments() {
        let plane = WallShape::Plane { point: [0.0; 3], normal: [0.0, 1.0, 0.0] };
        let mesh = WallShape::Mesh { triangles: vec![[[0.0; 3], [2.0, 2.0, 0.0], [2.0, 2.0, 0.0]]] };
        let tube = WallShape::Tube { axis: [[0.0; 3], [0.0, 0.0, 1.0]], radius: 3.0 };
        let found = walls(vec![plane, mesh, tube], Some(1.0));
        assert_eq!(found.len(), 2 + SIDES);
        assert!(
            found.iter().all(|triangle| triangle.corners[1] == triangle.corners[2] && triangle.lines == 1)
        );
        let ends = found[0].corners.map(|corner| corner[0]);
        assert!(ends.contains(&0.2) && ends.contains(&0.8) && found[0].corners.iter().all(|at| at[1] == 0.0));
    }

    #[test]
    fn a_plane_far_away_is_drawn_where_it_is_and_widens_nothing() {
        let far = WallShape::Plane { point: [0.0, 0.0, -50.0], normal: [0.0, 0.0, 1.0] };
        let found = walls(vec![far], None);
        let bounds = bounds_of(found.iter().flat_map(|triangle| triangle.corners));
        assert_eq!(bounds, [[0.2, 0.8], [0.2, 0.8], [-50.0, -50.0]]);
    }
}
