//! Sharp edges of closed surfaces.

use super::vector::{Point, dot, minus, normal, unit};
use super::{OUTSIDE, Surface};

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
    let mut edges: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * facets.len());
    for (number, facet) in facets.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], number));
        }
    }
    edges.sort_unstable();
    let corners = |facet: usize| facets[facet].map(|node| nodes[node as usize]);
    let mut sharpest: Option<SharpEdge> = None;
    for pair in edges.chunk_by(|one, other| one.0 == other.0) {
        let &[(ends, one), (_, other)] = pair else { continue };
        let opposite = facets[other].into_iter().find(|node| !ends.contains(node));
        let Some(opposite) = opposite.map(|node| nodes[node as usize]) else { continue };
        let angle = angle(corners(one), corners(other), opposite);
        if sharpest.is_none_or(|sharpest| angle < sharpest.angle) {
            sharpest = Some(SharpEdge { angle, ends: ends.map(|node| nodes[node as usize]) });
        }
    }
    sharpest
}

/// The angle inside between two facets, degrees. `opposite` is the corner of the second that the first has not.
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
    let all = regions.into_iter().filter(|&region| region != OUTSIDE).filter_map(of);
    all.min_by(|one, other| one.angle.total_cmp(&other.angle))
}

#[cfg(test)]
mod tests {
    use super::*;

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
