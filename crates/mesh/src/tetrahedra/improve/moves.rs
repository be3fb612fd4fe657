//! Moves of single points.

use fdem_scenes::random::Random;

use super::body::{Body, FIXED, MOST_AROUND};
use crate::tetrahedra::delaunay::NONE;
use crate::tetrahedra::vector::{Point, cross, dot, in_ball, length, minus, plus, times, unit};

/// Steps, over the mean distance of the neighbours: each is tried until it no longer helps.
const STEPS: [f64; 6] = [0.3, 0.15, 0.08, 0.04, 0.02, 0.01];

/// Directions tried at each step, and how often a step may help.
const DIRECTIONS: usize = 8;

/// Moves a point to where the worst of the tetrahedra around it is better. Points in a face stay in its
/// plane.
pub(super) fn relocate(body: &mut Body, node: u32, random: &mut Random) -> bool {
    let bound = body.bound[node as usize];
    if bound == FIXED {
        return false;
    }
    let mut star = Vec::new();
    body.star(node, &mut star);
    if star.len() > MOST_AROUND {
        return false;
    }
    // The corners of each, with the moving one last: an even permutation, so the volume stays positive.
    let others: Vec<[Point; 3]> = star
        .iter()
        .map(|&t| {
            let corners = body.corners[t as usize];
            let place = corners.iter().position(|&corner| corner == node).unwrap_or(0);
            [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]][place].map(|k| body.points[corners[k] as usize])
        })
        .collect();
    let worst = |place: Point, least: f64| {
        let mut worst = f64::INFINITY;
        for (number, &[a, b, c]) in others.iter().enumerate() {
            let quality = super::quality::quality(a, b, c, place);
            if quality < worst {
                worst = quality;
                if worst <= least {
                    return (worst, number);
                }
            }
        }
        (worst, 0)
    };
    let start = body.points[node as usize];
    let (first, _) = worst(start, f64::NEG_INFINITY);
    let far = others.iter().map(|&[a, _, _]| length(minus(a, start))).sum::<f64>() / others.len() as f64;
    let axes = (bound != NONE).then(|| body.axes[bound as usize]);
    let (mut place, mut best) = (start, first);
    for step in STEPS {
        for _ in 0..3 {
            let before = best;
            for attempt in 0..DIRECTIONS {
                let mut direction = if attempt == 0 { away(&others, place) } else { in_ball(random) };
                if let Some([u, v]) = axes {
                    direction = plus(times(u, dot(u, direction)), times(v, dot(v, direction)));
                }
                let tried = plus(place, times(unit(direction), step * far));
                let (quality, _) = worst(tried, best);
                if quality > best {
                    (place, best) = (tried, quality);
                }
            }
            if best <= before {
                break;
            }
        }
    }
    // Tiny gains are not worth another pass.
    if best < first + 1e-4 {
        return false;
    }
    body.points[node as usize] = place;
    true
}

/// Away from the facet opposite the point in the worst tetrahedron.
fn away(others: &[[Point; 3]], place: Point) -> Point {
    let mut worst = (f64::INFINITY, [0.0; 3]);
    for &[a, b, c] in others {
        let quality = super::quality::quality(a, b, c, place);
        if quality < worst.0 {
            worst = (quality, cross(minus(b, a), minus(c, a)));
        }
    }
    worst.1
}
