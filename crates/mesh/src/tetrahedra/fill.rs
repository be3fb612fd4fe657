//! Points inside, and how they are moved until the tetrahedra are even.
//!
//! # Sources
//! J. R. Shewchuk, "Tetrahedral mesh generation by Delaunay refinement", `SoCG` 1998, for points in the
//! middle of spheres that are too large; L. Chen, J. Xu, "Optimal Delaunay triangulations", J. Comput. Math.
//! 22 (2004), and P. Alliez, D. Cohen-Steiner, M. Yvinec, M. Desbrun, "Variational tetrahedral meshing",
//! SIGGRAPH 2005, for the moves: each point goes to the mean of the centres of the spheres around it; J. R.
//! Shewchuk, "General-dimensional constrained Delaunay and constrained regular triangulations, I", Discrete
//! Comput. Geom. 39 (2008), for tetrahedra that locked facets part.

use std::collections::VecDeque;

use fdem_scenes::random::Random;

use super::delaunay::{Delaunay, FACETS};
use super::error::MeshError;
use super::recover::{self, Hits};
use super::sizes::Sizes;
use super::skin::Skin;
use super::surface::OUTSIDE;
use super::vector::{Point, circle, cross, dot, in_ball, length, minus, normal, plus, sphere, times};
use super::{order, regions};
use crate::mesh::MOST_ELEMENTS as MOST;

/// A sphere is too large if its radius is above this times the size; chosen such that the mean edge is the
/// size.
const COARSE: f64 = 0.78;

/// Largest distance of a new point from the centre of its sphere, over the radius.
const JITTER: f64 = 0.2;

/// Rounds of moves.
const ROUNDS: usize = 6;

/// Longest move of a round, over the size.
const STEP: f64 = 0.4;

/// Inserts points into spheres that are too large, first found first. None takes away a facet of the skin,
/// nor lies in the sphere over one.
pub(crate) fn fill(
    mesh: &mut Delaunay,
    points: &mut Vec<Point>,
    sizes: &Sizes<'_>,
    seed: u64,
) -> Result<(), MeshError> {
    let mut random = Random::with_stream(seed, u64::MAX);
    let is_large = |mesh: &Delaunay, points: &[Point], t: usize| {
        if !mesh.is_used(t) || mesh.regions[t] == OUTSIDE {
            return None;
        }
        let [a, b, c, d] = mesh.corners[t].map(|corner| points[corner as usize]);
        let (centre, square) = sphere(a, b, c, d)?;
        let largest = COARSE * sizes.at(centre);
        (square > largest * largest).then_some((centre, square))
    };
    let mut open: VecDeque<u32> =
        (0..mesh.corners.len() as u32).filter(|&t| is_large(mesh, points, t as usize).is_some()).collect();
    while let Some(t) = open.pop_front() {
        let Some((centre, square)) = is_large(mesh, points, t as usize) else { continue };
        let point = plus(centre, times(in_ball(&mut random), JITTER * square.sqrt()));
        let vertex = points.len() as u32;
        // The centre of a flat tetrahedron may be rounded to a point outside of its sphere.
        if !mesh.takes(points, t as usize, point, vertex) {
            continue;
        }
        if !mesh.find_gap_inside(points, point, vertex, t)
            || mesh.locked_around().any(|facet| encroaches(facet.map(|k| points[k as usize]), point))
        {
            continue;
        }
        points.push(point);
        mesh.fill_gap(vertex);
        open.extend(mesh.made.iter().copied().filter(|&t| is_large(mesh, points, t as usize).is_some()));
        if mesh.corners.len() > MOST {
            return Err(MeshError::TooMany { elements: mesh.corners.len() as f64 });
        }
    }
    Ok(())
}

/// Whether a point is in the smallest sphere around a facet, or behind the facet (in front, counter-clockwise
/// seen from outside).
fn encroaches([a, b, c]: [Point; 3], point: Point) -> bool {
    let Some((centre, square)) = circle(a, b, c) else { return true };
    let offset = minus(point, centre);
    dot(offset, offset) < square || dot(offset, normal(a, b, c)) > 0.0
}

/// Moves the points inside, and makes Delaunay's tetrahedra of them, several times. `bare` is the
/// triangulation of the skin alone.
pub(crate) fn smooth(
    mut mesh: Delaunay,
    bare: &Delaunay,
    skin: &Skin,
    points: &mut [Point],
    sizes: &Sizes<'_>,
) -> Result<(Delaunay, Hits), MeshError> {
    let order = order::rounds(&order::along_curve(points));
    for _ in 0..ROUNDS {
        let mut moved = targets(&mesh, skin.points.len(), points, sizes);
        drop(mesh);
        mesh = triangulate(&mut moved, points, bare, skin, &order)?;
        points.copy_from_slice(&moved);
    }
    let (hits, _) = recover::lock(&mut mesh, skin);
    Ok((mesh, hits))
}

/// Where each point should go: its first `fixed` stay.
fn targets(mesh: &Delaunay, fixed: usize, points: &[Point], sizes: &Sizes<'_>) -> Vec<Point> {
    let mut sums = vec![[0.0; 4]; points.len()];
    let mut near: Vec<(u32, [u32; 3])> = Vec::new();
    for (t, corners) in mesh.corners.iter().enumerate() {
        if !mesh.is_used(t) || mesh.regions[t] == OUTSIDE {
            continue;
        }
        let [a, b, c, d] = corners.map(|corner| points[corner as usize]);
        let (u, v, w) = (minus(b, a), minus(c, a), minus(d, a));
        let volume = dot(u, cross(v, w));
        let third = plus(a, times(plus(plus(u, v), w), 0.25));
        let size = sizes.at(third);
        let mut centre = third;
        if let Some((middle, square)) = sphere(a, b, c, d) {
            // Centres far outside of flat tetrahedra would pull points out.
            let limit = (size / square.sqrt()).min(1.0);
            centre = plus(third, times(minus(middle, third), limit));
        }
        let weight = volume / (size * size * size);
        for &corner in corners {
            let sum = &mut sums[corner as usize];
            for axis in 0..3 {
                sum[axis] += weight * centre[axis];
            }
            sum[3] += weight;
        }
        for place in (0..4).filter(|place| mesh.locked[t] >> place & 1 == 1) {
            near.push((corners[place], FACETS[place].map(|k| corners[k])));
        }
    }
    let mut targets = points.to_vec();
    for (number, (target, [x, y, z, weight])) in targets.iter_mut().zip(sums).enumerate().skip(fixed) {
        if weight > 0.0 {
            let shift = minus(times([x, y, z], 1.0 / weight), points[number]);
            let far = length(shift);
            let most = STEP * sizes.at(points[number]);
            *target = plus(points[number], times(shift, (most / far).min(1.0)));
        }
    }
    for (apex, facet) in near {
        let at = apex as usize;
        if at >= fixed && encroaches(facet.map(|k| points[k as usize]), targets[at]) {
            targets[at] = points[at];
        }
    }
    targets
}

/// Delaunay's tetrahedra of moved points. Where these lack triangles of the skin, the points are inserted
/// into the tetrahedra of the `bare` skin instead; those for which there is no room go back to where they
/// were `before`, or are left out.
fn triangulate(
    moved: &mut [Point],
    before: &[Point],
    bare: &Delaunay,
    skin: &Skin,
    order: &[u32],
) -> Result<Delaunay, MeshError> {
    let mut mesh = Delaunay::new(moved, order).ok_or(MeshError::Flat)?;
    let (hits, missing) = recover::lock(&mut mesh, skin);
    if missing.is_empty() {
        regions::classify(&mut mesh, skin, &hits)?;
        return Ok(mesh);
    }
    let mut mesh = bare.clone();
    for &vertex in order.iter().filter(|&&vertex| vertex as usize >= skin.points.len()) {
        let at = vertex as usize;
        if !mesh.insert_inside(moved, vertex) {
            moved[at] = before[at];
            mesh.insert_inside(moved, vertex);
        }
    }
    Ok(mesh)
}
