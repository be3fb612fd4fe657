//! The common part of two faces, and forces because a face turns.

use crate::simplex::tetrahedron::piece::{ConvexPiece, CutTriangle, FacePoint, share_of};
use crate::vector::{Matrix, Point, add, cross3, dot, length, minus, unit};

/// Barycentric coordinates on a face of points on its plane.
struct FaceCoordinates {
    origin: Point<3>,
    /// Gradients of the coordinates along the face.
    gradients: [Point<3>; 3],
}

impl FaceCoordinates {
    fn of([a, b, c]: &[Point<3>; 3]) -> Self {
        let (e, f) = (minus(*b, *a), minus(*c, *a));
        let normal = cross3(e, f);
        let squared = dot(normal, normal);
        let one = cross3(f, normal).map(|x| x / squared);
        let two = cross3(normal, e).map(|x| x / squared);
        let zero = std::array::from_fn(|axis| -one[axis] - two[axis]);
        Self { origin: *a, gradients: [zero, one, two] }
    }

    fn at(&self, point: Point<3>) -> [f64; 3] {
        let from = minus(point, self.origin);
        let [one, two] = [1, 2].map(|k| dot(self.gradients[k], from));
        [1.0 - one - two, one, two]
    }
}

/// Three Gauss points in each triangle of a fan over the common part of two faces that face each other.
pub(super) fn common(
    one: &[Point<3>; 3],
    other: &[Point<3>; 3],
    touch: f64,
    least: f64,
) -> Vec<([[f64; 3]; 2], f64)> {
    let [normal, other_normal] =
        [one, other].map(|face| cross3(minus(face[1], face[0]), minus(face[2], face[0])));
    let across = unit(normal);
    let off = other.iter().map(|corner| dot(minus(*corner, one[0]), across).abs()).fold(0.0, f64::max);
    if off > touch || dot(normal, other_normal) >= 0.0 {
        return Vec::new();
    }
    let coordinates = [FaceCoordinates::of(one), FaceCoordinates::of(other)];
    // The part of the other face that is in the first.
    let corners = other.map(|corner| coordinates[0].at(corner));
    let mut pieces = CutTriangle::of(&corners.map(|[a, b, c]| [a, b, c, 0.0]));
    let piece = (0..3).fold(ConvexPiece::WHOLE, |piece, k| pieces.cut(&piece, |values| values[k]));
    let corners: Vec<&FacePoint> = pieces.corners(&piece).collect();
    let area = 0.5 * length(other_normal);
    let mut points = Vec::new();
    for pair in corners.windows(2).skip(1) {
        let triangle = [corners[0], pair[0], pair[1]];
        let share = share_of(triangle);
        let triangle = triangle.map(FacePoint::coordinates);
        // A triangle thinner than this is one of rounding.
        if share * area <= least * least {
            continue;
        }
        for k in 0..3 {
            let weights: [f64; 3] = std::array::from_fn(|l| if k == l { 2.0 / 3.0 } else { 1.0 / 6.0 });
            let on_other: [f64; 3] =
                std::array::from_fn(|i| (0..3).map(|corner| weights[corner] * triangle[corner][i]).sum());
            let mut point = [0.0; 3];
            for (corner, weight) in other.iter().zip(on_other) {
                add(&mut point, *corner, weight);
            }
            points.push(([coordinates[0].at(point), on_other], share * area / 3.0));
        }
    }
    points
}

/// Forces on the vertices of a face because its axes turn with it.
///
/// The normal turns by `−Σ ∇β (n·u)`, the directions along the face by the same towards the normal, and about
/// it as the edge from vertex 0 to vertex 1, which is along the first of them.
pub(super) fn turning(
    face: &[Point<3>; 3],
    axes: &Matrix<3>,
    gap: &[f64; 3],
    pressure: f64,
    traction: &[f64; 3],
    area: f64,
) -> [Point<3>; 3] {
    let gradients = FaceCoordinates::of(face).gradients;
    let mut forces = [[0.0; 3]; 3];
    for (force, gradient) in forces.iter_mut().zip(gradients) {
        for k in 1..3 {
            let moment = (pressure * gap[k] + traction[k] * gap[0]) * dot(axes[k], gradient);
            add(force, axes[0], -area * moment);
        }
    }
    let spin = area * (traction[1] * gap[2] - traction[2] * gap[1]) / length(minus(face[1], face[0]));
    add(&mut forces[0], axes[2], spin);
    add(&mut forces[1], axes[2], -spin);
    forces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;
    use crate::simplex::Simplex;
    use crate::simplex::Tetrahedron;

    /// The points of the common part of two faces in one plane have its area and its centroid, from both
    /// faces.
    #[test]
    fn the_common_part_of_two_faces() {
        let one = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        // From the other side: the square of edge 1 at the corner of the first, cut by its diagonal.
        let other = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let points = common(&one, &other, 1e-9, 1e-9);
        let area: f64 = points.iter().map(|(_, area)| area).sum();
        assert!((area - 0.5).abs() < 1e-15);
        for (shares, _) in &points {
            let [a, b]: [Point<3>; 2] = [(&one, shares[0]), (&other, shares[1])].map(|(face, shares)| {
                let mut point = [0.0; 3];
                face.iter().zip(shares).for_each(|(corner, share)| add(&mut point, *corner, share));
                point
            });
            assert!(length(minus(a, b)) < 1e-15);
        }
        assert!(common(&one, &one, 1e-9, 1e-9).is_empty(), "they look the same way");
        let far = other.map(|[x, y, _]| [x, y, 0.1]);
        assert!(common(&one, &far, 1e-9, 1e-9).is_empty());
        let beside = other.map(|[x, y, z]| [x + 2.0, y, z]);
        assert!(common(&one, &beside, 1e-9, 1e-9).is_empty());
    }

    /// The forces are the gradient of the energy of a pressure along the normal and a traction against the
    /// directions of a face, on a point that does not move.
    #[test]
    fn turning_is_a_gradient() {
        for seed in 0..50 {
            let any =
                |k: u64| -> Point<3> { std::array::from_fn(|axis| uniform(seed, 3 * k + axis as u64) - 0.5) };
            let face = [any(0), any(1), any(2)];
            let (apart, traction, pressure) = (any(3), [0.0, any(4)[1], any(4)[2]], 0.7);
            let gap_of =
                |face: &[Point<3>; 3]| Tetrahedron::axes(face).map(unit).map(|axis| dot(apart, axis));
            let energy = |face: &[Point<3>; 3]| {
                let gap = gap_of(face);
                -pressure * gap[0] + traction[1] * gap[1] + traction[2] * gap[2]
            };
            let axes = Tetrahedron::axes(&face).map(unit);
            let forces = turning(&face, &axes, &gap_of(&face), pressure, &traction, 1.0);
            for corner in 0..3 {
                for axis in 0..3 {
                    let h = 1e-6;
                    let at = |step: f64| {
                        let mut moved = face;
                        moved[corner][axis] += step;
                        energy(&moved)
                    };
                    let slope = (at(h) - at(-h)) / (2.0 * h);
                    let bound = 1e-6 / Tetrahedron::facet_measure(&face);
                    assert!((forces[corner][axis] + slope).abs() < bound, "{seed}: {forces:?} {slope}");
                }
            }
        }
    }
}
