//! Removes flat and thin tetrahedra.
//!
//! The worst tetrahedra come first. For each, the mesher tries to flip edges and facets, move its corners,
//! split an edge or remove a corner, if that makes the smallest angle of all changed tetrahedra larger. The
//! smallest angle of the mesh only grows.
//!
//! # Sources
//! L. A. Freitag, C. Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing", Int. J.
//! Numer. Meth. Engng 40 (1997); B. M. Klingner, J. R. Shewchuk, "Aggressive tetrahedral mesh improvement",
//! Proc. 16th Int. Meshing Roundtable (2007), for the order of the attempts and the measure, the smallest
//! sine of the angles between facets, which is small for angles near 0° and near 180°.

pub(crate) mod body;
mod flips;
mod insert;
mod moves;
pub(crate) mod quality;

use fdem_scenes::random::Random;

use super::delaunay::NONE;
use body::Body;

/// Sines below which tetrahedra are improved: that of 22°, for most; 18° before points are inserted or
/// removed.
const ENOUGH: f64 = 0.375;
const POOR: f64 = 0.309;

/// Most passes over the tetrahedra.
const PASSES: usize = 12;

/// Improves all that is below [`ENOUGH`], until a pass changes little.
pub(crate) fn improve(body: &mut Body, seed: u64) {
    let mut random = Random::with_stream(seed, u64::MAX - 1);
    for pass in 0..PASSES {
        let mut bad: Vec<(f64, u32)> = (0..body.corners.len())
            .filter(|&t| body.is_used(t))
            .map(|t| (body.quality(t), t as u32))
            .filter(|&(quality, _)| quality < ENOUGH)
            .collect();
        bad.sort_unstable_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        let mut changed = 0;
        for &(quality, t) in &bad {
            let t = t as usize;
            // Another attempt may have changed it.
            if !body.is_used(t) || body.quality(t) != quality {
                continue;
            }
            changed += usize::from(attempt(body, t, quality, pass, &mut random));
        }
        if changed == 0 && pass > 2 {
            break;
        }
    }
}

/// Makes the surroundings of a tetrahedron better, if it can.
fn attempt(body: &mut Body, t: usize, quality: f64, pass: usize, random: &mut Random) -> bool {
    if flips::flip(body, t) {
        return true;
    }
    let corners = body.corners[t];
    let mut moved = false;
    for corner in corners {
        moved |= moves::relocate(body, corner, random);
        if body.quality(t) >= ENOUGH {
            return true;
        }
    }
    if pass < 2 || quality >= POOR || moved {
        return moved;
    }
    for corner in corners {
        if body.at[corner as usize] != NONE && insert::contract(body, corner) {
            return true;
        }
    }
    insert::split(body, t, random)
}
