//! Extruded outlines.

use robust::{Coord, orient2d};

use crate::tetrahedra::plane::Point2;
use crate::tetrahedra::{MeshError, OUTSIDE, Surface, finite, positive};
use crate::triangles::holes_are_inside;
use crate::triangles::outline::Domain;

/// An outline in the plane of x and y with holes, from the height `bottom` to `top`.
///
/// The first loop is the outline, the others are holes; each in either direction. Faces: `bottom`, `top`,
/// then one for each edge of each loop in order, without names.
///
/// # Cost
/// The outline is cut into triangles ear by ear: time grows with the square of its corners.
///
/// # Errors
/// [`MeshError::NotFinite`], [`MeshError::Length`]; [`MeshError::Empty`] without loops of three corners;
/// [`MeshError::Outline`] if it crosses or touches itself; [`MeshError::Hole`] for holes beyond the outline
/// or in each other.
pub fn extrusion(loops: &[Vec<[f64; 2]>], bottom: f64, top: f64) -> Result<Surface, MeshError> {
    positive(top - bottom)?;
    let corners: Vec<Point2> = loops.iter().flatten().copied().collect();
    finite(&corners.iter().map(|&[x, y]| [x, y, bottom]).collect::<Vec<_>>())?;
    if loops.is_empty() || loops.iter().any(|corners| corners.len() < 3) {
        return Err(MeshError::Empty);
    }
    let count = corners.len() as u32;
    let mut first = 0;
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for (number, corners_of) in loops.iter().enumerate() {
        let mut ring: Vec<u32> = (first..first + corners_of.len() as u32).collect();
        first += corners_of.len() as u32;
        // The outline is counter-clockwise, holes are clockwise.
        if (twice_area(&corners, &ring) > 0.0) != (number == 0) {
            ring.reverse();
        }
        rings.push(ring);
    }
    no_crossing(&corners, &rings)?;
    holes_are_inside(&Domain { loops: loops.to_vec(), lines: Vec::new() }).map_err(MeshError::Hole)?;
    let mut surface = Surface { names: ["bottom", "top"].map(str::to_owned).to_vec(), ..Surface::default() };
    for z in [bottom, top] {
        surface.nodes.extend(corners.iter().map(|&[x, y]| [x, y, z]));
    }
    let mut push = |facet: [u32; 3], face: u32| {
        surface.facets.push(facet);
        surface.faces.push(face);
        surface.sides.push([0, OUTSIDE]);
    };
    let mut face = 2;
    for ring in &rings {
        for (k, &a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            push([a, b, count + b], face);
            push([a, count + b, count + a], face);
            face += 1;
        }
    }
    for [a, b, c] in ears(&corners, join(&corners, rings)?)? {
        push([a, c, b], 0);
        push([count + a, count + b, count + c], 1);
    }
    Ok(surface)
}

fn side(a: Point2, b: Point2, c: Point2) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}

pub(super) fn twice_area(corners: &[Point2], ring: &[u32]) -> f64 {
    let at = |k: usize| corners[ring[k % ring.len()] as usize];
    let origin = at(0);
    let from = |[x, y]: Point2| [x - origin[0], y - origin[1]];
    (0..ring.len())
        .map(|k| {
            let ([ax, ay], [bx, by]) = (from(at(k)), from(at(k + 1)));
            ax * by - bx * ay
        })
        .sum()
}

/// Whether two edges have a point in common.
fn touch([a, b]: [Point2; 2], [c, d]: [Point2; 2]) -> bool {
    let within = |axis: usize| {
        a[axis].min(b[axis]) <= c[axis].max(d[axis]) && c[axis].min(d[axis]) <= a[axis].max(b[axis])
    };
    let opposite = |p: f64, q: f64| !(p > 0.0 && q > 0.0 || p < 0.0 && q < 0.0);
    within(0) && within(1) && opposite(side(a, b, c), side(a, b, d)) && opposite(side(c, d, a), side(c, d, b))
}

/// All edges of rings, from corner to corner.
fn edges(rings: &[Vec<u32>]) -> Vec<[u32; 2]> {
    rings.iter().flat_map(|ring| (0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()]])).collect()
}

/// Checks that edges meet in their common ends only.
pub(super) fn no_crossing(corners: &[Point2], rings: &[Vec<u32>]) -> Result<(), MeshError> {
    let at = |edge: [u32; 2]| edge.map(|corner| corners[corner as usize]);
    let edges = edges(rings);
    for (number, &[a, b]) in edges.iter().enumerate() {
        let [p, q] = at([a, b]);
        let error = MeshError::Outline { place: p };
        if p == q {
            return Err(error);
        }
        for &[c, d] in &edges[number + 1..] {
            let [r, s] = at([c, d]);
            let wrong = if b == c {
                // Neighbours: the second must not run back along the first.
                side(p, q, s) == 0.0 && (p[0] - q[0]) * (s[0] - q[0]) + (p[1] - q[1]) * (s[1] - q[1]) > 0.0
            } else if a == d {
                side(r, p, q) == 0.0 && (r[0] - p[0]) * (q[0] - p[0]) + (r[1] - p[1]) * (q[1] - p[1]) > 0.0
            } else {
                touch([p, q], [r, s])
            };
            if wrong {
                return Err(error);
            }
        }
    }
    Ok(())
}

/// Joins holes to the outline by edges that are run through there and back.
pub(super) fn join(corners: &[Point2], mut rings: Vec<Vec<u32>>) -> Result<Vec<u32>, MeshError> {
    let at = |corner: u32| corners[corner as usize];
    let all = edges(&rings);
    let mut outline = rings.remove(0);
    let right = |ring: &[u32]| ring.iter().map(|&corner| at(corner)[0]).fold(f64::NEG_INFINITY, f64::max);
    // Holes on the right come first: each then sees the outline or one that is joined already.
    rings.sort_by(|one, other| right(other).total_cmp(&right(one)));
    let mut bridges: Vec<[u32; 2]> = Vec::new();
    for hole in rings {
        let start =
            (0..hole.len()).fold(0, |best, k| if at(hole[k])[0] > at(hole[best])[0] { k } else { best });
        let from = at(hole[start]);
        let square = |corner: u32| {
            let [dx, dy] = [0, 1].map(|axis| at(corner)[axis] - from[axis]);
            dx * dx + dy * dy
        };
        let mut places: Vec<usize> = (0..outline.len()).collect();
        places.sort_by(|&i, &j| square(outline[i]).total_cmp(&square(outline[j])).then(i.cmp(&j)));
        let sees = |place: usize| {
            let (end, count) = (outline[place], outline.len());
            let (before, after) =
                (at(outline[(place + count - 1) % count]), at(outline[(place + 1) % count]));
            // The bridge leaves the outline to the inside: between the edges there.
            let (one, other) = (side(before, at(end), from) > 0.0, side(at(end), after, from) > 0.0);
            let inside = if side(before, at(end), after) > 0.0 { one && other } else { one || other };
            inside
                && all.iter().chain(&bridges).all(|&[c, d]| {
                    let other = |end: u32| at(if c == end { d } else { c });
                    match ([c, d].contains(&hole[start]), [c, d].contains(&end)) {
                        (true, true) => true,
                        (true, false) => !on(from, at(end), other(hole[start])),
                        (false, true) => !on(at(end), from, other(end)),
                        (false, false) => !touch([from, at(end)], [at(c), at(d)]),
                    }
                })
        };
        let place =
            places.into_iter().find(|&place| sees(place)).ok_or(MeshError::Outline { place: from })?;
        bridges.push([hole[start], outline[place]]);
        let way = hole[start..].iter().chain(&hole[..=start]).copied();
        let back = outline[place];
        let new: Vec<u32> = way.chain([back]).collect();
        let rest = outline.split_off(place + 1);
        outline.extend(new);
        outline.extend(rest);
    }
    Ok(outline)
}

/// Whether `point` is on the ray from `from` through `to`.
fn on(from: Point2, to: Point2, point: Point2) -> bool {
    side(from, to, point) == 0.0
        && (to[0] - from[0]) * (point[0] - from[0]) + (to[1] - from[1]) * (point[1] - from[1]) > 0.0
}

/// Cuts a polygon into triangles, ear by ear.
///
/// # Source
/// G. H. Meisters, "Polygons have ears", Amer. Math. Monthly 82 (1975).
pub(super) fn ears(corners: &[Point2], mut ring: Vec<u32>) -> Result<Vec<[u32; 3]>, MeshError> {
    let at = |corner: u32| corners[corner as usize];
    let mut triangles = Vec::new();
    let mut start = 0;
    while ring.len() > 3 {
        let count = ring.len();
        let is_ear = |k: usize| {
            let around = [ring[(k + count - 1) % count], ring[k], ring[(k + 1) % count]];
            let [a, b, c] = around.map(at);
            side(a, b, c) > 0.0
                && ring.iter().filter(|corner| !around.contains(corner)).all(|&corner| {
                    let p = at(corner);
                    side(a, b, p) < 0.0 || side(b, c, p) < 0.0 || side(c, a, p) < 0.0
                })
        };
        let ear = (0..count).map(|k| (start + k) % count).find(|&k| is_ear(k));
        let Some(k) = ear else { return Err(MeshError::Outline { place: at(ring[0]) }) };
        triangles.push([ring[(k + count - 1) % count], ring[k], ring[(k + 1) % count]]);
        ring.remove(k);
        start = k;
    }
    let last = [ring[0], ring[1], ring[2]];
    if side(at(last[0]), at(last[1]), at(last[2])) <= 0.0 {
        return Err(MeshError::Outline { place: at(last[0]) });
    }
    triangles.push(last);
    Ok(triangles)
}
