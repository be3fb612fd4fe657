//! Sharp edges and corners of closed surfaces.

use std::collections::BTreeMap;

use super::surface::{INNER, Surface};
use super::vector::{Point, cross, dot, length, minus, normal, times, unit};

/// An edge of a closed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpEdge {
    /// Angle between the two facets, measured inside of the body, degrees.
    pub angle: f64,
    /// The ends.
    pub ends: [[f64; 3]; 2],
}

/// The edge of a closed surface with the smallest angle inside; `None` if no edge has two facets.
///
/// # Shapes
/// `facets`: corners `[m]`, counter-clockwise seen from outside.
pub fn sharpest_edge(nodes: &[[f64; 3]], facets: &[[u32; 3]]) -> Option<SharpEdge> {
    let corners = |facet: usize| facets[facet].map(|node| nodes[node as usize]);
    let mut sharpest: Option<SharpEdge> = None;
    for (one, other, ends) in neighbours(facets) {
        let opposite = facets[other].into_iter().find(|node| !ends.contains(node));
        let Some(opposite) = opposite.map(|node| nodes[node as usize]) else { continue };
        let angle = angle(corners(one), corners(other), opposite);
        if sharpest.is_none_or(|sharpest| angle < sharpest.angle) {
            sharpest = Some(SharpEdge { angle, ends: ends.map(|node| nodes[node as usize]) });
        }
    }
    sharpest
}

/// A corner of a flat face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpCorner {
    /// Angle of the face there, degrees.
    pub angle: f64,
    /// The corner.
    pub place: [f64; 3],
}

/// Sine of the largest angle between facets of one plane.
const FLAT: f64 = 1e-6;

/// The corner of a flat face with the smallest angle; `None` without facets. Neighbours in one plane are of
/// one face.
///
/// # Shapes
/// `facets`: corners `[m]`, of a closed surface.
pub fn sharpest_corner(nodes: &[[f64; 3]], facets: &[[u32; 3]]) -> Option<SharpCorner> {
    let corners = |facet: usize| facets[facet].map(|node| nodes[node as usize]);
    let normals: Vec<Point> = (0..facets.len())
        .map(|facet| {
            let [a, b, c] = corners(facet);
            unit(normal(a, b, c))
        })
        .collect();
    let mut parent: Vec<usize> = (0..facets.len()).collect();
    let root = |parent: &mut Vec<usize>, mut facet: usize| {
        while parent[facet] != facet {
            parent[facet] = parent[parent[facet]];
            facet = parent[facet];
        }
        facet
    };
    for (one, other, _) in neighbours(facets) {
        let (m, n) = (normals[one], normals[other]);
        if dot(m, n) > 0.0 && length(cross(m, n)) < FLAT {
            let (one, other) = (root(&mut parent, one), root(&mut parent, other));
            parent[one.max(other)] = one.min(other);
        }
    }
    let mut angles: BTreeMap<(usize, u32), f64> = BTreeMap::new();
    for (number, facet) in facets.iter().enumerate() {
        let (face, p) = (root(&mut parent, number), corners(number));
        for k in 0..3 {
            let (u, v) = (minus(p[(k + 1) % 3], p[k]), minus(p[(k + 2) % 3], p[k]));
            let angle = libm::atan2(length(cross(u, v)), dot(u, v)).to_degrees();
            *angles.entry((face, facet[k])).or_default() += angle;
        }
    }
    let sharpest = angles.into_iter().min_by(|one, other| one.1.total_cmp(&other.1));
    sharpest.map(|((_, node), angle)| SharpCorner { angle, place: nodes[node as usize] })
}

/// The two facets at each edge, and its ends.
fn neighbours(facets: &[[u32; 3]]) -> Vec<(usize, usize, [u32; 2])> {
    let mut edges: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * facets.len());
    for (number, facet) in facets.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], number));
        }
    }
    edges.sort_unstable();
    let pairs = edges.chunk_by(|one, other| one.0 == other.0).filter_map(|pair| {
        let &[(ends, one), (_, other)] = pair else { return None };
        Some((one, other, ends))
    });
    pairs.collect()
}

/// The angle inside between two facets, degrees. `opposite` is the corner of the second that the first has
/// not.
fn angle([a, b, c]: [Point; 3], [d, e, f]: [Point; 3], opposite: Point) -> f64 {
    let (one, other) = (unit(normal(a, b, c)), unit(normal(d, e, f)));
    let turn = dot(one, other).clamp(-1.0, 1.0).acos().to_degrees();
    if dot(one, minus(opposite, a)) <= 0.0 { 180.0 - turn } else { 180.0 + turn }
}

/// The edge of any region of a surface with the smallest angle.
pub(super) fn of_surface(surface: &Surface) -> Option<SharpEdge> {
    let mut regions: Vec<u32> = surface.sides.iter().flatten().copied().collect();
    regions.sort_unstable();
    regions.dedup();
    let of = |region: u32| {
        let around = surface.facets.iter().zip(&surface.sides).filter_map(|(&[a, b, c], sides)| {
            if sides[0] == region { Some([a, b, c]) } else { (sides[1] == region).then_some([a, c, b]) }
        });
        sharpest_edge(&surface.nodes, &around.collect::<Vec<_>>())
    };
    let all =
        regions.into_iter().filter(|&region| region < INNER).filter_map(of).chain(beside_inner(surface));
    all.min_by(|one, other| one.angle.total_cmp(&other.angle))
}

/// The edge of a facet inside of a region with the smallest angle to another facet.
pub(super) fn beside_inner(surface: &Surface) -> Option<SharpEdge> {
    if surface.sides.iter().all(|sides| sides[0] != INNER) {
        return None;
    }
    let mut edges: Vec<([u32; 2], usize, u32)> = Vec::with_capacity(3 * surface.facets.len());
    for (number, facet) in surface.facets.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], number, facet[(k + 2) % 3]));
        }
    }
    edges.sort_unstable();
    let at = |node: u32| surface.nodes[node as usize];
    let mut sharpest: Option<SharpEdge> = None;
    for group in edges.chunk_by(|one, other| one.0 == other.0) {
        let [a, b] = group[0].0.map(at);
        let along = unit(minus(b, a));
        let away = |apex: u32| {
            let off = minus(at(apex), a);
            minus(off, times(along, dot(off, along)))
        };
        for (place, &(_, one, apex)) in group.iter().enumerate() {
            for &(_, other, opposite) in &group[place + 1..] {
                if [one, other].iter().all(|&facet| surface.sides[facet][0] != INNER) {
                    continue;
                }
                let (u, v) = (away(apex), away(opposite));
                let angle = libm::atan2(length(cross(u, v)), dot(u, v)).to_degrees();
                if sharpest.is_none_or(|sharpest| angle < sharpest.angle) {
                    sharpest = Some(SharpEdge { angle, ends: [a, b] });
                }
            }
        }
    }
    sharpest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sharp_corner_of_a_flat_face_is_found() {
        // Its sides are cut into triangles with small angles, which are no angles of the body.
        let cube = crate::shapes::cuboid([0.0; 3], [1.0, 1.0, 0.01]).unwrap();
        let corner = sharpest_corner(&cube.nodes, &cube.facets).unwrap();
        assert!((corner.angle - 90.0).abs() < 1e-9, "{corner:?}");
        let tip = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.02, 0.0], [0.9, 0.3, 0.3]];
        let body = crate::shapes::hull(&tip).unwrap();
        let corner = sharpest_corner(&body.nodes, &body.facets).unwrap();
        assert!((corner.angle - 0.02_f64.atan().to_degrees()).abs() < 1e-9, "{corner:?}");
        assert_eq!(corner.place, [0.0; 3]);
    }

    #[test]
    fn the_sharp_edge_of_a_wedge_is_found() {
        // A prism over a triangle with 30 degrees at the origin.
        let slope = 30.0_f64.to_radians().tan();
        let nodes: Vec<Point> = (0..2)
            .flat_map(|z| [[0.0, 0.0], [1.0, 0.0], [1.0, slope]].map(|[x, y]| [x, y, f64::from(z)]))
            .collect();
        let facets = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
        let edge = sharpest_edge(&nodes, &facets).unwrap();
        assert!((edge.angle - 30.0).abs() < 1e-9, "{edge:?}");
        assert_eq!(edge.ends, [[0.0; 3], [0.0, 0.0, 1.0]]);
        // Seen from inside, the body is around the prism: its sharp edges are blunt there.
        let inside_out = facets.map(|[a, b, c]| [a, c, b]);
        assert!(sharpest_edge(&nodes, &inside_out).unwrap().angle > 179.0);
    }
}
