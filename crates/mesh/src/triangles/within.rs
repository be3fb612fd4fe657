//! The parts of lines that lie in a domain.

use super::network::{along, crossing};
use super::outline::{Domain, Inside, Point, distance};

/// Distance from a loop over the length of a line, up to which the line lies along the loop.
const ALONG: f64 = 1e-9;

/// Lengths of the parts of lines, by their two ends, that lie inside of the loops of a domain.
///
/// `with_loops`: whether a part along a loop counts.
///
/// # Shapes
/// A length for each line.
///
/// # Cost
/// Each line is compared with each edge of the loops.
///
/// # Example
/// ```
/// use fdem_mesh::triangles::{lengths_inside, outline::Domain};
///
/// let square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// let domain = Domain { loops: vec![square], lines: Vec::new() };
/// let lines = [[[-0.5, 0.5], [0.5, 0.5]], [[0.0, 1.0], [1.0, 1.0]]];
/// assert_eq!(lengths_inside(&domain, &lines, false), [0.5, 0.0]);
/// assert_eq!(lengths_inside(&domain, &lines, true), [0.5, 1.0]);
/// ```
pub fn lengths_inside(domain: &Domain, lines: &[[Point; 2]], with_loops: bool) -> Vec<f64> {
    let inside = Inside::new(&domain.loops);
    let edges: Vec<[Point; 2]> = domain
        .loops
        .iter()
        .flat_map(|corners| (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]))
        .collect();
    let length = |&[a, b]: &[Point; 2]| {
        let long = distance(a, b);
        // A line along an edge is cut where the edge ends.
        let mut cuts = vec![0.0, 1.0];
        for &edge in &edges {
            cuts.extend(crossing([a, b], edge).map(|(t, _)| t));
            cuts.extend(
                edge.iter().filter(|&&end| gap(end, [a, b]) <= ALONG * long).map(|&end| share(end, [a, b])),
            );
        }
        cuts.sort_by(f64::total_cmp);
        let parts = cuts.windows(2).filter(|pair| {
            let middle = along(a, b, f64::midpoint(pair[0], pair[1]));
            if edges.iter().any(|&edge| gap(middle, edge) <= ALONG * long) {
                with_loops
            } else {
                inside.contains(middle)
            }
        });
        long * parts.map(|pair| pair[1] - pair[0]).sum::<f64>()
    };
    lines.iter().map(length).collect()
}

/// The place along a line that is nearest to a point, from 0 to 1.
fn share(point: Point, [a, b]: [Point; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let square = dx * dx + dy * dy;
    let t = (point[0] - a[0]) * dx + (point[1] - a[1]) * dy;
    if square > 0.0 { (t / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// Distance of a point from a line.
fn gap(point: Point, line: [Point; 2]) -> f64 {
    distance(point, along(line[0], line[1], share(point, line)))
}
