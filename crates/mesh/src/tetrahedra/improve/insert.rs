//! New points on edges, and points that go.

use fdem_scenes::random::Random;

use super::body::{BORDER, Body, MOST_AROUND};
use super::moves;
use crate::tetrahedra::delaunay::NONE;
use crate::tetrahedra::vector::{plus, times};

/// Splits an edge of a tetrahedron by a point that is then moved to the best place, if that makes the worst
/// better.
pub(super) fn split(body: &mut Body, t: usize, random: &mut Random) -> bool {
    let corners = body.corners[t];
    for [i, j] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
        let (a, b) = (corners[i], corners[j]);
        let Some(ring) = body.ring(t, a, b) else { continue };
        if ring.ends.is_some() || ring.around.len() > MOST_AROUND / 4 {
            continue;
        }
        let worst = |body: &Body, all: &[u32]| {
            all.iter().map(|&t| body.quality(t as usize)).fold(f64::INFINITY, f64::min)
        };
        let before = worst(body, &ring.around);
        let old: Vec<[u32; 4]> = ring.around.iter().map(|&t| body.corners[t as usize]).collect();
        let node = body.points.len() as u32;
        let middle = times(plus(body.points[a as usize], body.points[b as usize]), 0.5);
        body.points.push(middle);
        body.bound.push(NONE);
        body.at.push(NONE);
        let new: Vec<[u32; 4]> = old
            .iter()
            .flat_map(|corners| {
                [a, b].map(|end| corners.map(|corner| if corner == end { node } else { corner }))
            })
            .collect();
        let places = body.replace(&ring.around, &new, BORDER);
        moves::relocate(body, node, random);
        if worst(body, &places) > before + 1e-3 {
            return true;
        }
        body.replace(&places, &old, BORDER);
        body.points.pop();
        body.bound.pop();
        body.at.pop();
        if !body.is_used(t) || body.corners[t] != corners {
            return false;
        }
    }
    false
}

/// Removes a point inside: all its tetrahedra that stay get a neighbour in its place, if that makes the worst
/// better.
pub(super) fn contract(body: &mut Body, node: u32) -> bool {
    if body.bound[node as usize] != NONE {
        return false;
    }
    let mut star = Vec::new();
    body.star(node, &mut star);
    if star.len() > MOST_AROUND {
        return false;
    }
    let worst = star.iter().map(|&t| body.quality(t as usize)).fold(f64::INFINITY, f64::min);
    let mut around: Vec<u32> = star.iter().flat_map(|&t| body.corners[t as usize]).collect();
    around.sort_unstable();
    around.dedup();
    for &other in around.iter().filter(|&&other| other != node) {
        let kept = star.iter().map(|&t| body.corners[t as usize]).filter(|corners| !corners.contains(&other));
        let new: Vec<[u32; 4]> =
            kept.map(|corners| corners.map(|corner| if corner == node { other } else { corner })).collect();
        if new.iter().all(|&corners| body.quality_of(corners) > worst) {
            body.replace(&star, &new, BORDER);
            body.forget(node);
            return true;
        }
    }
    false
}
