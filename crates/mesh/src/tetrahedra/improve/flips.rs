//! Flips: other tetrahedra of the same points.
//!
//! # Sources
//! L. A. Freitag, C. Ollivier-Gooch (see [`super`]); G. T. Klincsek, "Minimal triangulations of polygonal
//! domains", Ann. Discrete Math. 9 (1980), for the best triangles of a ring.

use super::body::{BORDER, Body, Ring};

/// Longest ring around an edge that is removed.
const LONGEST: usize = 8;

/// Removes one of the edges or facets of a tetrahedron, if that makes the worst of all that change better.
pub(super) fn flip(body: &mut Body, t: usize) -> bool {
    let corners = body.corners[t];
    for [i, j] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
        if remove_edge(body, t, corners[i], corners[j]) {
            return true;
        }
    }
    (0..4).any(|place| remove_facet(body, t, place))
}

/// Replaces the tetrahedra around an edge by others without it.
fn remove_edge(body: &mut Body, t: usize, a: u32, b: u32) -> bool {
    let Some(Ring { around, nodes, ends }) = body.ring(t, a, b) else { return false };
    let count = nodes.len();
    if !(3..=LONGEST).contains(&count) {
        return false;
    }
    // On the surface, both facets have to be of one plane.
    let border = match ends {
        Some([one, other]) if one != other => return false,
        Some([patch, _]) => BORDER + patch,
        None => BORDER,
    };
    let worst = around.iter().map(|&t| body.quality(t as usize)).fold(f64::INFINITY, f64::min);
    // The best of the worst of the triangles between nodes i and j, and the third node of the triangle at
    // their edge.
    let mut best = [[f64::INFINITY; LONGEST]; LONGEST];
    let mut third = [[0; LONGEST]; LONGEST];
    for span in 2..count {
        for i in 0..count - span {
            let j = i + span;
            best[i][j] = f64::NEG_INFINITY;
            for k in i + 1..j {
                let known = best[i][k].min(best[k][j]);
                if known <= worst || known <= best[i][j] {
                    continue;
                }
                let above = body.quality_of([nodes[i], nodes[k], nodes[j], b]);
                if above <= worst || above <= best[i][j] {
                    continue;
                }
                let all = known.min(above).min(body.quality_of([nodes[i], nodes[j], nodes[k], a]));
                if all > best[i][j] {
                    best[i][j] = all;
                    third[i][j] = k;
                }
            }
        }
    }
    if best[0][count - 1] <= worst {
        return false;
    }
    let mut new = Vec::with_capacity(2 * count);
    let mut open = vec![[0, count - 1]];
    while let Some([i, j]) = open.pop() {
        if j > i + 1 {
            let k = third[i][j];
            new.push([nodes[i], nodes[k], nodes[j], b]);
            new.push([nodes[i], nodes[j], nodes[k], a]);
            open.extend([[i, k], [k, j]]);
        }
    }
    body.replace(&around, &new, border);
    true
}

/// Replaces two neighbours by three tetrahedra around a new edge.
fn remove_facet(body: &mut Body, t: usize, place: usize) -> bool {
    let Some((u, opposite)) = body.beyond(t, place) else { return false };
    let corners = body.corners[t];
    let (a, b) = (corners[place], body.corners[u][opposite]);
    let worst = body.quality(t).min(body.quality(u));
    // In place of each of the other corners, the new one takes its place.
    let mut new = [[0; 4]; 3];
    for (new, k) in new.iter_mut().zip((0..4).filter(|&k| k != place)) {
        *new = corners;
        new[k] = b;
        if body.quality_of(*new) <= worst {
            return false;
        }
    }
    debug_assert!(new.iter().all(|corners| corners.contains(&a)));
    body.replace(&[t as u32, u as u32], &new, BORDER);
    true
}
