//! Cuts quadrilaterals and polygons into triangles, and solids into tetrahedra.
//!
//! A quadrilateral is cut along the diagonal through its smallest node. A solid is cut into the tetrahedra
//! between its smallest node and the triangles of those faces that do not have it. The faces that have it are
//! then cut along the diagonals through it, because it is their smallest node too. So the cut of a face
//! depends on its nodes alone, and two solids that share a face agree on it.
//!
//! # Source
//! J. Dompierre, P. Labbé, M.-G. Vallet, R. Camarero, "How to subdivide pyramids, prisms, and hexahedra into
//! tetrahedra", 8th International Meshing Roundtable (1999): the rule of the smallest node.

use crate::mesh::shape::Shape;

/// The triangles of a face of three or four nodes.
pub(crate) fn halves(face: &[u32]) -> Vec<[u32; 3]> {
    match *face {
        [a, b, c] => vec![[a, b, c]],
        [a, b, c, d] if a.min(c) < b.min(d) => vec![[a, b, c], [a, c, d]],
        [a, b, c, d] => vec![[b, c, d], [b, d, a]],
        _ => Vec::new(),
    }
}

/// The tetrahedra of a solid with these nodes, of the orientation that the solid has; `None` if it is folded
/// or has no volume.
pub(crate) fn tetrahedra(shape: Shape, nodes: &[u32], points: &[[f64; 3]]) -> Option<Vec<[u32; 4]>> {
    let least = *nodes.iter().min()?;
    let faces = shape.faces().iter().map(|face| face.iter().map(|&at| nodes[at]).collect::<Vec<u32>>());
    let opposite = faces.filter(|face| !face.contains(&least));
    let cut: Vec<[u32; 4]> =
        opposite.flat_map(|face| halves(&face)).map(|[a, b, c]| [a, b, c, least]).collect();
    let corners: Vec<[f64; 3]> = nodes.iter().map(|&node| points[node as usize]).collect();
    let (low, size) = extent(&corners);
    let volume = |tetrahedron: &[u32; 4]| {
        let [a, b, c, d] = tetrahedron.map(|node| scaled(points[node as usize], low, size));
        dot(cross(minus(b, a), minus(c, a)), minus(d, a))
    };
    let volumes: Vec<f64> = cut.iter().map(volume).collect();
    let is_whole = volumes.iter().all(|&v| v > 0.0) || volumes.iter().all(|&v| v < 0.0);
    is_whole.then_some(cut)
}

/// The corners of two triangles that form a quadrilateral and have the same orientation, with the diagonal
/// through its smallest node if that is possible; `None` if neither diagonal gives such triangles.
///
/// In a plane, both have the same orientation exactly if the diagonal is inside.
pub(crate) fn quadrilateral(nodes: [u32; 4], points: &[[f64; 3]]) -> Option<[[u32; 3]; 2]> {
    let corners = nodes.map(|node| points[node as usize]);
    let (low, size) = extent(&corners);
    let scaled = corners.map(|corner| scaled(corner, low, size));
    let area = |[a, b, c]: [usize; 3]| cross(minus(scaled[b], scaled[a]), minus(scaled[c], scaled[a]));
    let mut cuts = [[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]];
    if nodes[1].min(nodes[3]) < nodes[0].min(nodes[2]) {
        cuts.reverse();
    }
    let cut = cuts.into_iter().find(|[first, second]| dot(area(*first), area(*second)) > 0.0)?;
    Some(cut.map(|half| half.map(|corner| nodes[corner])))
}

/// Largest angle between the normals of two halves, degrees, up to which a quadrilateral that cannot be cut
/// is folded. Above it, its corners are nearly in one plane, and it crosses itself.
const MOST_FOLDED: f64 = 165.0;

/// The angle, degrees, by which a quadrilateral that cannot be cut is folded along one of its diagonals;
/// `None` if it is nearly flat, or one of its halves has no area.
pub(crate) fn fold(nodes: [u32; 4], points: &[[f64; 3]]) -> Option<u32> {
    let corners = nodes.map(|node| points[node as usize]);
    let (low, size) = extent(&corners);
    let [a, b, c, d] = corners.map(|corner| scaled(corner, low, size));
    let normal = |a, b, c| cross(minus(b, a), minus(c, a));
    let between = |[p, q]: [[f64; 3]; 2]| (dot(p, q) / (dot(p, p) * dot(q, q)).sqrt()).acos().to_degrees();
    let angles = [[normal(a, b, c), normal(a, c, d)], [normal(b, c, d), normal(b, d, a)]].map(between);
    let least = angles.into_iter().filter(|angle| angle.is_finite()).reduce(f64::min)?;
    (least <= MOST_FOLDED).then_some(least.round() as u32)
}

/// The triangles of a polygon, which need not be convex; `None` if it crosses itself or has no area.
pub(crate) fn polygon(nodes: &[u32], points: &[[f64; 3]]) -> Option<Vec<[u32; 3]>> {
    let corners: Vec<[f64; 3]> = nodes.iter().map(|&node| points[node as usize]).collect();
    let (low, size) = extent(&corners);
    let corners: Vec<[f64; 3]> = corners.iter().map(|&corner| scaled(corner, low, size)).collect();
    let next = corners.iter().cycle().skip(1);
    let normal = corners.iter().zip(next).fold([0.0; 3], |sum, (&a, &b)| {
        let of_edge = cross(a, b);
        [0, 1, 2].map(|axis| sum[axis] + of_edge[axis])
    });
    // Twice the area seen along the normal, positive if counter-clockwise.
    let area = |a: usize, b: usize, c: usize| {
        dot(cross(minus(corners[b], corners[a]), minus(corners[c], corners[a])), normal)
    };
    let mut left: Vec<usize> = (0..nodes.len()).collect();
    let mut cut = Vec::with_capacity(nodes.len() - 2);
    while left.len() > 2 {
        let count = left.len();
        let ear = (0..count).find(|&at| {
            let [a, b, c] = [left[(at + count - 1) % count], left[at], left[(at + 1) % count]];
            let covers = |&p: &usize| {
                ![a, b, c].contains(&p)
                    && area(a, b, p) >= 0.0
                    && area(b, c, p) >= 0.0
                    && area(c, a, p) >= 0.0
            };
            area(a, b, c) > 0.0 && !left.iter().any(covers)
        })?;
        let [a, b, c] = [left[(ear + count - 1) % count], left[ear], left[(ear + 1) % count]];
        cut.push([a, b, c].map(|corner| nodes[corner]));
        left.remove(ear);
    }
    Some(cut)
}

/// Lower corner and size of the bounding box, both halved so that neither overflows.
fn extent(corners: &[[f64; 3]]) -> ([f64; 3], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in corners {
        for axis in 0..3 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    let size = (0..3).map(|axis| high[axis] / 2.0 - low[axis] / 2.0).fold(0.0, f64::max);
    (low, size)
}

/// A corner in a box of size 1, so that products neither overflow nor underflow: orientations do not depend
/// on the size.
fn scaled(corner: [f64; 3], low: [f64; 3], size: f64) -> [f64; 3] {
    [0, 1, 2].map(|axis| (corner[axis] / 2.0 - low[axis] / 2.0) / size)
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

fn cross(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

fn dot(p: [f64; 3], q: [f64; 3]) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrilaterals_are_cut_along_a_diagonal_inside() {
        let flat = |corners: [[f64; 2]; 4]| quadrilateral([0, 1, 2, 3], &corners.map(|[x, y]| [x, y, 0.0]));
        let (first, second) = (Some([[0, 1, 2], [0, 2, 3]]), Some([[1, 2, 3], [1, 3, 0]]));
        assert_eq!(flat([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), first);
        // A dart with its tip at the first corner, then at the second.
        assert_eq!(flat([[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]]), first);
        assert_eq!(flat([[2.0, 1.0], [0.0, 0.0], [2.0, -1.0], [1.0, 0.0]]), second);
        // A bow tie, and corners on a line.
        assert_eq!(flat([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), None);
        assert_eq!(flat([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]), None);
        assert_eq!(flat([[7.0, 7.0]; 4]), None);
        for size in [1e-300, 1e300] {
            assert_eq!(flat([[-size, -size], [size, -size], [size, size], [-size, size]]), first, "{size}");
        }
    }

    #[test]
    fn polygons_are_cut_into_their_area() {
        let cut = |corners: &[[f64; 2]]| {
            let points: Vec<[f64; 3]> = corners.iter().map(|&[x, y]| [x, 2.0, y]).collect();
            let nodes: Vec<u32> = (0..points.len() as u32).collect();
            let triangles = polygon(&nodes, &points)?;
            let area = |[a, b, c]: [u32; 3]| {
                let [a, b, c] = [a, b, c].map(|node| corners[node as usize]);
                0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
            };
            assert!(triangles.iter().all(|&triangle| area(triangle) > 0.0), "{triangles:?}");
            Some((triangles.len(), triangles.into_iter().map(area).sum::<f64>()))
        };
        // An L, a square with a corner on an edge, and a star that crosses itself.
        let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        assert_eq!(cut(&l), Some((4, 3.0)));
        assert_eq!(cut(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]), Some((3, 4.0)));
        assert_eq!(cut(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [-1.0, 1.0]]), None);
        assert_eq!(cut(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]]), None);
    }

    /// For every order of the smallest nodes: the tetrahedra fill the solid, and each of its faces is cut as
    /// its nodes alone say.
    #[test]
    fn solids_are_cut_so_that_neighbours_agree() {
        let cube = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [0.0, 1.0, 1.0],
        ];
        let of = |corners: &[usize]| corners.iter().map(|&corner| cube[corner]).collect::<Vec<_>>();
        for (shape, corners, six_volumes, count) in [
            (Shape::Hexahedron, of(&[0, 1, 2, 3, 4, 5, 6, 7]), 6.0, 6),
            (Shape::Wedge, of(&[0, 1, 3, 4, 5, 7]), 3.0, 3),
            (Shape::Pyramid, of(&[0, 1, 2, 3, 4]), 2.0, 2),
        ] {
            let n = corners.len();
            let mut orders = vec![(0..n as u32).collect::<Vec<u32>>()];
            for at in 0..n {
                let swapped = orders.iter().flat_map(|order| (at..n).map(move |to| (order.clone(), to)));
                orders = swapped
                    .map(|(mut order, to)| {
                        order.swap(at, to);
                        order
                    })
                    .collect();
            }
            for nodes in orders {
                let mut points = vec![[0.0; 3]; n];
                for (&node, &corner) in nodes.iter().zip(&corners) {
                    points[node as usize] = corner;
                }
                let cut = tetrahedra(shape, &nodes, &points).expect("a whole solid");
                let volume = |tetrahedron: &[u32; 4]| {
                    let [a, b, c, d] = tetrahedron.map(|node| points[node as usize]);
                    dot(cross(minus(b, a), minus(c, a)), minus(d, a))
                };
                assert_eq!((cut.len(), cut.iter().map(volume).sum::<f64>()), (count, six_volumes));
                assert!(cut.iter().all(|one| volume(one) > 0.0), "{shape:?} {nodes:?}");
                let sorted = |mut face: [u32; 3]| {
                    face.sort_unstable();
                    face
                };
                let facets =
                    cut.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, b, d], [a, c, d], [b, c, d]]);
                let mut facets: Vec<[u32; 3]> = facets.map(sorted).collect();
                facets.sort_unstable();
                let outer: Vec<[u32; 3]> = facets
                    .chunk_by(|a, b| a == b)
                    .filter(|alike| alike.len() == 1)
                    .map(|one| one[0])
                    .collect();
                let faces =
                    shape.faces().iter().map(|face| face.iter().map(|&at| nodes[at]).collect::<Vec<_>>());
                let mut expected: Vec<[u32; 3]> = faces.flat_map(|face| halves(&face)).map(sorted).collect();
                expected.sort_unstable();
                assert_eq!(outer, expected, "{shape:?} {nodes:?}");
            }
        }
    }
}
