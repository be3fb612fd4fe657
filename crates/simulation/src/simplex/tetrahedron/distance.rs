//! The distance of two tetrahedra that do not overlap. Twin: `crates/gpu/kernels/contact.h`.

use crate::simplex::Tetrahedron;
use crate::simplex::tetrahedron::numbering::{EDGES, FACES};
use crate::vector::{Point, cross3, dot, minus};

/// Distance of two tetrahedra that do not overlap, m. The points of both that are nearest to each other are
/// either on an edge of each, or one is a corner and the other is inside a face.
pub(super) fn between(a: &Tetrahedron, b: &Tetrahedron) -> f64 {
    let edges = |shape: &Tetrahedron| EDGES.map(|[from, to]| [shape[from], minus(shape[to], shape[from])]);
    let (of_a, of_b) = (edges(a), edges(b));
    let mut least = f64::INFINITY;
    for one in &of_a {
        for other in &of_b {
            least = least.min(between_edges(one, other));
        }
    }
    least.min(above_faces(a, b)).min(above_faces(b, a)).sqrt()
}

/// Square of the distance of two edges, each given by its beginning and its direction, m².
#[inline]
fn between_edges([p, u]: &[Point<3>; 2], [q, v]: &[Point<3>; 2]) -> f64 {
    let from = minus(*p, *q);
    let (uu, vv, uv) = (dot(*u, *u), dot(*v, *v), dot(*u, *v));
    let (along_u, along_v) = (dot(*u, from), dot(*v, from));
    let squared = uu * vv - uv * uv;
    // The nearest point of the line, then of the edge. Any point will do for parallel edges.
    let s = if squared > 1e-12 * uu * vv { (uv * along_v - vv * along_u) / squared } else { 0.0 };
    let t = ((uv * s.clamp(0.0, 1.0) + along_v) / vv).clamp(0.0, 1.0);
    let s = ((uv * t - along_u) / uu).clamp(0.0, 1.0);
    let apart: Point<3> = std::array::from_fn(|axis| from[axis] + s * u[axis] - t * v[axis]);
    dot(apart, apart)
}

/// Square of the least distance of a corner of one tetrahedron from a face of the other inside of which it
/// has its foot, m²; infinite if no corner has such a face.
fn above_faces(corners: &Tetrahedron, faces: &Tetrahedron) -> f64 {
    let mut least = f64::INFINITY;
    for face in FACES {
        let [a, b, c] = face.map(|corner| faces[corner]);
        let (ab, ac) = (minus(b, a), minus(c, a));
        let normal = cross3(ab, ac);
        let squared = dot(normal, normal);
        for corner in corners {
            let from = minus(*corner, a);
            // Corners below a face count as well: two that overlap by less than rounding are near each other.
            let height = dot(from, normal);
            if height * height >= least * squared {
                continue;
            }
            let (second, third) = (dot(cross3(from, ac), normal), dot(cross3(ab, from), normal));
            if second >= 0.0 && third >= 0.0 && second + third <= squared {
                least = height * height / squared;
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;
    use crate::vector::length;

    /// A point of a tetrahedron with random weights, most of them near its boundary.
    fn point(shape: &Tetrahedron, seed: u64, k: u64) -> Point<3> {
        let weights = [0, 1, 2, 3].map(|corner| uniform(seed, 4 * k + corner).powi(4));
        let sum: f64 = weights.iter().sum();
        std::array::from_fn(|axis| {
            (0..4).map(|corner| weights[corner] * shape[corner][axis]).sum::<f64>() / sum
        })
    }

    /// No two points are nearer, and some are nearly as near.
    #[test]
    fn it_is_the_least_distance_of_their_points() {
        for seed in 0..100 {
            let shape = |which: u64, shift: f64| -> Tetrahedron {
                let corner = |k: u64| {
                    std::array::from_fn(|axis| {
                        uniform(100 * seed + which, 3 * k + axis as u64) + if axis == 0 { shift } else { 0.0 }
                    })
                };
                let corners = [0, 1, 2, 3].map(corner);
                let [a, b, c, d] = corners;
                if dot(minus(b, a), cross3(minus(c, a), minus(d, a))) > 0.0 { corners } else { [a, c, b, d] }
            };
            let (a, b) = (shape(0, 0.0), shape(1, 1.1));
            let told = between(&a, &b);
            let of_b: Vec<Point<3>> = (0..300).map(|k| point(&b, 2, k)).collect();
            let nearest = (0..300)
                .map(|k| point(&a, 1, k))
                .flat_map(|p| of_b.iter().map(move |q| length(minus(p, *q))))
                .fold(f64::INFINITY, f64::min);
            assert!(told <= nearest && nearest < told + 0.15, "{told} {nearest}");
        }
    }

    #[test]
    fn corners_edges_and_faces() {
        let one = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let turned = |shift: Point<3>| {
            one.map(|corner| std::array::from_fn(|axis| shift[axis] - [1.0, -1.0, -1.0][axis] * corner[axis]))
        };
        let mirrored = |shift: Point<3>| {
            let [a, b, c, d] = turned(shift);
            [a, c, b, d]
        };
        // Corner and corner, and two parallel faces.
        assert_eq!(between(&one, &mirrored([-0.5, 0.0, 0.0])), 0.5);
        let moved = one.map(|[x, y, z]| [x, y, z + 3.0]);
        assert_eq!(between(&one, &moved), 2.0);
        // A corner above the inside of a face.
        let above = [[0.5, 0.5, 0.25], [0.5, 1.5, 0.5], [1.5, 0.5, 0.5], [0.5, 0.5, 1.5]];
        let [a, b, c, d] = above;
        let expected = (0.5 + 0.5 + 0.25 - 1.0) / 3.0_f64.sqrt();
        assert!((between(&one, &[a, c, b, d]) - expected).abs() < 1e-15);
    }
}
