//! Tetrahedra.

use super::contact::{Contact, Measure};
use super::exact::{orient3d, orient3d_value};
use super::segment::closest as closest_of_segments;
use super::shapes::{Tetrahedron, Triangle};
use super::sphere::foot;
use super::triangle::{edge_touches_sides, triangle_triangle, triangles_touch};
use super::vector::{add, cross, distance_squared, dot, middle, neg, scale, sub, unit, x_axis};

/// The vertices of the face opposite to each vertex. Seen from outside of a tetrahedron of positive volume,
/// they turn left.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The ends of each edge.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

impl Tetrahedron {
    /// Whether the closed tetrahedra have a point in common, decided exactly.
    pub fn touches(&self, other: &Self) -> bool {
        touch(&Sides::new(self, other), &Sides::new(other, self))
    }
}

/// Two tetrahedra: gap or volume.
///
/// Whether they touch is decided exactly. The volume is exactly 0 if the plane of a face separates them. The
/// point is the centroid of the common volume. If that is 0, it is the centroid of the common area of faces,
/// or else of the common length of edges, or else the common point. For a gap it is the middle between the
/// closest points. The normal of a touch is the direction of the smallest translation that separates the two,
/// among the normals of the faces and the directions perpendicular to two edges (x if there is none). The
/// normal of a gap is the direction of the gap.
///
/// # Units
/// The gap has the unit of the coordinates, the volume its cube. Let `l` be the largest difference of
/// coordinates between their vertices. The error of the volume is at most `1e-12 l³`; that of the gap is 64
/// rounding steps of the largest coordinate. If the volume is no larger than its error, the point is
/// inaccurate but within the bounding boxes of both.
///
/// # Cost
/// One tetrahedron is cut at the four faces of the other into tetrahedra, at most 81 and usually about ten.
/// No polyhedron is built, so rounding cannot make one inconsistent.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Measure, Tetrahedron, tetrahedron_tetrahedron};
///
/// let a = Tetrahedron::new([[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]])?;
/// let b = Tetrahedron::new([[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 0.0, 2.0]])?;
/// let contact = tetrahedron_tetrahedron(&a, &b);
/// assert!(matches!(contact.measure, Measure::Volume(volume) if (volume - 1.0 / 6.0).abs() < 1e-15));
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn tetrahedron_tetrahedron(a: &Tetrahedron, b: &Tetrahedron) -> Contact<3> {
    let (of_a, of_b) = (Sides::new(a, b), Sides::new(b, a));
    let (p, q) = (&of_a.vertices, &of_b.vertices);
    if !touch(&of_a, &of_b) {
        let (from, to) = closest(p, q);
        return Contact {
            point: middle(from, to),
            normal: unit(sub(to, from)).unwrap_or_else(|| normal_of_least_move(p, q)),
            measure: Measure::Gap(distance_squared(from, to).sqrt()),
        };
    }
    let normal = normal_of_least_move(p, q);
    if of_a.solid && of_b.solid {
        let origin = q[0];
        let corner = |k: usize| Corner { x: sub(p[k], origin), d: of_b.of_other.map(|face| face[k]) };
        let mut overlap = Overlap { volume: 0.0, moment: [0.0; 3] };
        overlap.add([corner(0), corner(1), corner(2), corner(3)], 0);
        if overlap.volume > 0.0 {
            let centroid = add(origin, scale(overlap.moment, 1.0 / overlap.volume));
            // If the volume is dominated by rounding, its computed centroid can be anywhere.
            let point = std::array::from_fn(|axis| {
                let (low_p, high_p) = bounds(p.map(|x| x[axis]));
                let (low_q, high_q) = bounds(q.map(|x| x[axis]));
                centroid[axis].max(low_p.max(low_q)).min(high_p.min(high_q))
            });
            return Contact { point, normal, measure: Measure::Volume(overlap.volume) };
        }
    }
    Contact { point: point_of_touch(&of_a, &of_b), normal, measure: Measure::Volume(0.0) }
}

/// A tetrahedron, oriented to positive volume if it has any, and the sides of its faces on which the vertices
/// of another are.
struct Sides {
    vertices: [[f64; 3]; 4],
    /// Whether the tetrahedron has a volume.
    solid: bool,
    /// For each face and each vertex of the other: a number with the exact sign, positive inside, in
    /// proportion to the distance from the face.
    of_other: [[f64; 4]; 4],
}

impl Sides {
    fn new(own: &Tetrahedron, other: &Tetrahedron) -> Self {
        let mut vertices = own.vertices;
        let volume = orient3d(vertices[0], vertices[1], vertices[2], vertices[3]);
        if volume < 0.0 {
            vertices.swap(0, 1);
        }
        let mut of_other = other.vertices;
        if orient3d(of_other[0], of_other[1], of_other[2], of_other[3]) < 0.0 {
            of_other.swap(0, 1);
        }
        let values = FACES
            .map(|[a, b, c]| of_other.map(|d| -orient3d_value(vertices[a], vertices[b], vertices[c], d)));
        Self { vertices, solid: volume != 0.0, of_other: values }
    }

    fn face(&self, k: usize) -> [[f64; 3]; 3] {
        FACES[k].map(|v| self.vertices[v])
    }

    fn holds(&self, vertex: usize) -> bool {
        self.solid && self.of_other.iter().all(|face| face[vertex] >= 0.0)
    }
}

fn touch(a: &Sides, b: &Sides) -> bool {
    for own in [a, b] {
        if own.solid && own.of_other.iter().any(|face| face.iter().all(|&d| d < 0.0)) {
            return false;
        }
    }
    if [a, b].iter().any(|own| (0..4).any(|vertex| own.holds(vertex))) {
        return true;
    }
    if a.solid && b.solid {
        // No vertex of one is in the other. Therefore, if they touch, an edge of one passes through a face of
        // the other.
        return [(a, b), (b, a)].into_iter().any(|(own, other)| {
            (0..4).any(|k| {
                let (face, sides) = (other.face(k), other.of_other[k]);
                EDGES.iter().any(|&[i, j]| {
                    edge_touches_sides([own.vertices[i], own.vertices[j]], [sides[i], sides[j]], &face)
                })
            })
        });
    }
    // A tetrahedron without volume is the union of its faces.
    (0..4).any(|k| (0..4).any(|l| triangles_touch(&a.face(k), &b.face(l))))
}

/// A vertex of a piece: its position, and the sides of the four faces of the other tetrahedron on which it
/// is.
#[derive(Clone, Copy)]
struct Corner {
    x: [f64; 3],
    d: [f64; 4],
}

impl Corner {
    /// The point where the edge from a corner inside of a face to a corner outside crosses it.
    fn cut(inside: &Self, outside: &Self, face: usize) -> Self {
        let t = inside.d[face] / (inside.d[face] - outside.d[face]);
        let mut d = [0.0; 4];
        for (k, d) in d.iter_mut().enumerate() {
            *d = if k == face { 0.0 } else { inside.d[k] + t * (outside.d[k] - inside.d[k]) };
        }
        Self { x: std::array::from_fn(|k| inside.x[k] + t * (outside.x[k] - inside.x[k])), d }
    }
}

struct Overlap {
    volume: f64,
    moment: [f64; 3],
}

impl Overlap {
    /// Adds the part of a piece that is inside of this face and those after it.
    fn add(&mut self, piece: [Corner; 4], face: usize) {
        if face == 4 {
            let [a, b, c, d] = piece.map(|corner| corner.x);
            let volume = (dot(sub(b, a), cross(sub(c, a), sub(d, a))) / 6.0).abs();
            self.volume += volume;
            self.moment = add(self.moment, scale(add(add(a, b), add(c, d)), 0.25 * volume));
            return;
        }
        let mut sorted = piece;
        let mut inside = 0;
        for k in 0..4 {
            if sorted[k].d[face] > 0.0 {
                sorted.swap(inside, k);
                inside += 1;
            }
        }
        let [a, b, c, d] = sorted;
        let cut = |inside: &Corner, outside: &Corner| Corner::cut(inside, outside, face);
        match inside {
            0 => {}
            1 => self.add([a, cut(&a, &b), cut(&a, &c), cut(&a, &d)], face + 1),
            2 => self.add_prism([a, cut(&a, &c), cut(&a, &d)], [b, cut(&b, &c), cut(&b, &d)], face + 1),
            3 => self.add_prism([a, b, c], [cut(&a, &d), cut(&b, &d), cut(&c, &d)], face + 1),
            _ => self.add(piece, face + 1),
        }
    }

    fn add_prism(&mut self, [a, b, c]: [Corner; 3], [d, e, f]: [Corner; 3], face: usize) {
        for piece in [[a, b, c, f], [a, b, e, f], [a, d, e, f]] {
            self.add(piece, face);
        }
    }
}

fn bounds(x: [f64; 4]) -> (f64, f64) {
    x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
}

/// The normal from `p` to `q` of the smallest translation that separates them.
fn normal_of_least_move(p: &[[f64; 3]; 4], q: &[[f64; 3]; 4]) -> [f64; 3] {
    let faces =
        [p, q].into_iter().flat_map(|t| FACES.map(|[a, b, c]| cross(sub(t[b], t[a]), sub(t[c], t[a]))));
    let crossed = EDGES.into_iter().flat_map(|[a, b]| {
        let u = sub(p[b], p[a]);
        EDGES.map(|[c, d]| cross(u, sub(q[d], q[c])))
    });
    let mut best = (f64::NEG_INFINITY, x_axis());
    for axis in faces.chain(crossed) {
        let Some(n) = unit(axis) else { continue };
        let range = |t: &[[f64; 3]; 4]| bounds(t.map(|x| dot(n, sub(x, p[0]))));
        let ((low_p, high_p), (low_q, high_q)) = (range(p), range(q));
        for (separation, normal) in [(low_q - high_p, n), (low_p - high_q, neg(n))] {
            if separation > best.0 {
                best = (separation, normal);
            }
        }
    }
    best.1
}

/// The closest points of two separate tetrahedra: a vertex of one and a point of a face of the other, or
/// points of two edges.
fn closest(p: &[[f64; 3]; 4], q: &[[f64; 3]; 4]) -> ([f64; 3], [f64; 3]) {
    let mut best = (p[0], q[0]);
    let mut least = f64::INFINITY;
    let mut consider = |pair: ([f64; 3], [f64; 3]), squared: f64| {
        if squared < least {
            (best, least) = (pair, squared);
        }
    };
    for face in FACES {
        for &c in p {
            let foot = foot(c, &face.map(|v| q[v]));
            consider((c, foot.point), foot.squared);
        }
        for &c in q {
            let foot = foot(c, &face.map(|v| p[v]));
            consider((foot.point, c), foot.squared);
        }
    }
    for [a, b] in EDGES {
        for [c, d] in EDGES {
            let pair = closest_of_segments([p[a], p[b]], [q[c], q[d]]);
            consider(pair, distance_squared(pair.0, pair.1));
        }
    }
    best
}

/// The contact point if there is no common volume: the centroid of the common area of faces, or else of the
/// common length, or else a common point; or a vertex inside the other.
fn point_of_touch(a: &Sides, b: &Sides) -> [f64; 3] {
    let origin = a.vertices[0];
    // Weights and weighted sums of areas, lengths and points.
    let mut sums = [(0.0, [0.0; 3]); 3];
    let mut include = |kind: usize, weight: f64, x: [f64; 3]| {
        let (total, sum) = sums[kind];
        sums[kind] = (total + weight, add(sum, scale(sub(x, origin), weight)));
    };
    for k in 0..4 {
        for l in 0..4 {
            let contact =
                triangle_triangle(&Triangle { vertices: a.face(k) }, &Triangle { vertices: b.face(l) });
            match contact.measure {
                Measure::Area(area) if area > 0.0 => include(0, area, contact.point),
                Measure::Length(length) if length > 0.0 => include(1, length, contact.point),
                Measure::Gap(_) => {}
                _ => include(2, 1.0, contact.point),
            }
        }
    }
    for (own, other) in [(a, b), (b, a)] {
        for vertex in 0..4 {
            if own.holds(vertex) {
                include(2, 1.0, other.vertices[vertex]);
            }
        }
    }
    let found = sums.into_iter().find(|&(weight, _)| weight > 0.0);
    found.map_or(origin, |(weight, sum)| add(origin, scale(sum, 1.0 / weight)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron(vertices: [[f64; 3]; 4]) -> Tetrahedron {
        Tetrahedron::new(vertices).unwrap()
    }

    const CORNER: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn identical_and_mirrored_tetrahedra_have_all_their_volume_in_common() {
        let a = tetrahedron(CORNER);
        let mirrored = tetrahedron([CORNER[1], CORNER[0], CORNER[2], CORNER[3]]);
        for b in [a, mirrored] {
            let contact = tetrahedron_tetrahedron(&a, &b);
            let Measure::Volume(volume) = contact.measure else { panic!("{contact:?}") };
            assert!((volume - 1.0 / 6.0).abs() < 1e-16, "{volume}");
            assert!(contact.point.iter().all(|x| (x - 0.25).abs() < 1e-15), "{:?}", contact.point);
        }
    }

    #[test]
    fn a_shared_face_edge_or_vertex_is_a_touch_without_volume() {
        let a = tetrahedron(CORNER);
        let face = tetrahedron([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]);
        let edge = tetrahedron([[0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]);
        let vertex = tetrahedron([[0.0; 3], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]);
        let third = 1.0 / 3.0;
        for (b, point) in [(face, [third, third, 0.0]), (edge, [0.5, 0.0, 0.0]), (vertex, [0.0; 3])] {
            let contact = tetrahedron_tetrahedron(&a, &b);
            assert_eq!(contact.measure, Measure::Volume(0.0));
            assert!(distance_squared(contact.point, point) < 1e-30, "{:?}", contact.point);
        }
        assert_eq!(tetrahedron_tetrahedron(&a, &face).normal, [0.0, 0.0, -1.0]);
    }

    #[test]
    fn tetrahedra_without_volume_touch_as_what_they_span() {
        let a = tetrahedron(CORNER);
        let flat = tetrahedron([[-1.0, -1.0, 0.25], [1.0, -1.0, 0.25], [1.0, 1.0, 0.25], [-1.0, 1.0, 0.25]]);
        let line = tetrahedron([[-1.0, 0.25, 0.25], [1.0, 0.25, 0.25], [0.0, 0.25, 0.25], [0.5, 0.25, 0.25]]);
        let inside = tetrahedron([[0.25; 3]; 4]);
        for (p, q) in
            [(a, flat), (a, line), (a, inside), (flat, line), (flat, inside), (line, inside), (flat, flat)]
        {
            for contact in [tetrahedron_tetrahedron(&p, &q), tetrahedron_tetrahedron(&q, &p)] {
                assert_eq!(contact.measure, Measure::Volume(0.0), "{p:?} {q:?}");
                assert!((dot(contact.normal, contact.normal) - 1.0).abs() < 1e-15);
            }
        }
        let apart = tetrahedron([[3.0, 0.0, 0.0]; 4]);
        for other in [a, flat, line, inside] {
            assert!(!other.touches(&apart));
        }
        assert_eq!(tetrahedron_tetrahedron(&a, &apart).measure, Measure::Gap(2.0));
    }
}
