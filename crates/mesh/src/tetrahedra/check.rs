//! Whether numbers and surfaces can be meshed.

use super::delaunay::in_line;
use super::error::MeshError;
use super::predicates::side;
use super::surface::{INNER, Surface};
use super::vector::{Point, cross, dot, minus};
use crate::corners::sorted;

/// Largest coordinate: the fifth power of a length still is a number.
const FARTHEST: f64 = 1e60;

/// Checks that all coordinates are numbers, and not too large.
pub(crate) fn finite(points: &[Point]) -> Result<(), MeshError> {
    match points.iter().position(|point| !point.iter().all(|x| x.abs() <= FARTHEST)) {
        Some(node) => Err(MeshError::NotFinite { node }),
        None => Ok(()),
    }
}

/// Checks that a length is positive.
pub(crate) fn positive(length: f64) -> Result<(), MeshError> {
    if length > 0.0 && length.is_finite() { Ok(()) } else { Err(MeshError::Length { length }) }
}

impl Surface {
    /// Checks that the surface is closed around each region, has its outside outside, and does not cross
    /// itself.
    ///
    /// # Cost
    /// Facets are compared with those whose boxes touch theirs: about 1 µs for each of a good surface.
    ///
    /// # Errors
    /// All of [`MeshError`] that concern surfaces.
    pub fn check(&self) -> Result<(), MeshError> {
        let count = self.facets.len();
        if count == 0 {
            return Err(MeshError::Empty);
        }
        if self.faces.len() != count || self.sides.len() != count {
            return Err(MeshError::Lengths {
                facets: count,
                faces: self.faces.len(),
                sides: self.sides.len(),
            });
        }
        finite(&self.nodes)?;
        for facet in 0..count {
            let nodes = self.facets[facet];
            if nodes.iter().any(|&node| node as usize >= self.nodes.len()) {
                return Err(MeshError::NoSuchNode { facet });
            }
            let [a, b, c] = self.corners(facet);
            if in_line(a, b, c) {
                return Err(MeshError::Degenerate { facet, place: a });
            }
            let [behind, before] = self.sides[facet];
            if (behind == before) != (behind == INNER) {
                return Err(MeshError::Sides { place: a });
            }
        }
        let mut regions: Vec<u32> =
            self.sides.iter().flatten().copied().filter(|&region| region < INNER).collect();
        regions.sort_unstable();
        regions.dedup();
        self.has_none_twice()?;
        self.is_closed()?;
        match self.is_right_side_out(&regions) {
            // A surface that is twisted through itself may enclose nothing because of that.
            Err(inverted) => self.crosses_nothing().and(Err(inverted)),
            Ok(()) => self.crosses_nothing(),
        }
    }

    /// Checks that no two facets have the same corners.
    fn has_none_twice(&self) -> Result<(), MeshError> {
        let mut facets: Vec<([u32; 3], usize)> =
            self.facets.iter().enumerate().map(|(number, &facet)| (sorted(facet), number)).collect();
        facets.sort_unstable();
        match facets.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => Err(MeshError::Twice {
                facets: [pair[0].1, pair[1].1],
                place: self.nodes[pair[0].0[0] as usize],
            }),
            None => Ok(()),
        }
    }

    /// Checks that around each region, every edge of a facet is run through there and back.
    fn is_closed(&self) -> Result<(), MeshError> {
        // Region, ends, whether it runs from the higher to the lower, facet.
        let mut edges: Vec<(u32, [u32; 2], bool, u32)> = Vec::with_capacity(3 * self.facets.len());
        for (number, (facet, sides)) in (0..).zip(self.facets.iter().zip(&self.sides)) {
            for k in 0..3 {
                let (a, b) = (facet[k], facet[(k + 1) % 3]);
                let ends = [a.min(b), a.max(b)];
                edges.push((sides[0], ends, a > b, number));
                edges.push((sides[1], ends, a < b, number));
            }
        }
        edges.sort_unstable();
        for group in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            let (region, [a, b], _, facet) = group[0];
            if region >= INNER {
                continue;
            }
            let back = group.iter().filter(|edge| edge.2).count();
            if 2 * back != group.len() {
                let [p, q] = [a, b].map(|node| self.nodes[node as usize]);
                let place = [0, 1, 2].map(|axis| 0.5 * (p[axis] + q[axis]));
                let facet = facet as usize;
                return Err(if group.len() % 2 == 0 {
                    MeshError::Orientation { facet, place }
                } else {
                    MeshError::Open { facet, place }
                });
            }
        }
        Ok(())
    }

    /// Checks that each region has a positive volume.
    fn is_right_side_out(&self, regions: &[u32]) -> Result<(), MeshError> {
        let mut volumes = vec![0.0; regions.len()];
        let origin = self.nodes[0];
        for (facet, sides) in self.sides.iter().enumerate() {
            let [a, b, c] = self.corners(facet).map(|corner| minus(corner, origin));
            let volume = dot(a, cross(b, c)) / 6.0;
            for (region, sign) in [(sides[0], 1.0), (sides[1], -1.0)] {
                if let Ok(place) = regions.binary_search(&region) {
                    volumes[place] += sign * volume;
                }
            }
        }
        match volumes.iter().position(|&volume| volume.is_nan() || volume <= 0.0) {
            Some(place) => Err(MeshError::Inverted { region: regions[place] }),
            None => Ok(()),
        }
    }

    /// Checks that facets meet in common nodes and edges only.
    fn crosses_nothing(&self) -> Result<(), MeshError> {
        let boxes: Vec<[Point; 2]> = (0..self.facets.len())
            .map(|facet| {
                let (low, high) = super::vector::bounds(&self.corners(facet));
                [low, high]
            })
            .collect();
        // Boxes in order of their lower ends along x, in columns along y that are as wide as boxes are.
        let [wide, low] = self.columns(&boxes);
        let column = |y: f64| ((y - low) / wide).floor() as i64;
        let mut entries: Vec<(i64, u32)> = Vec::new();
        for (number, [least, most]) in (0..).zip(&boxes) {
            entries.extend((column(least[1])..=column(most[1])).map(|column| (column, number)));
        }
        entries.sort_by(|one, other| {
            let x = |entry: &(i64, u32)| boxes[entry.1 as usize][0][0];
            one.0.cmp(&other.0).then(x(one).total_cmp(&x(other))).then(one.1.cmp(&other.1))
        });
        for group in entries.chunk_by(|one, other| one.0 == other.0) {
            for (place, &(column_of, one)) in group.iter().enumerate() {
                let [least, most] = boxes[one as usize];
                for &(_, other) in &group[place + 1..] {
                    let [from, to] = boxes[other as usize];
                    if from[0] > most[0] {
                        break;
                    }
                    // A couple is looked at in one of its columns only.
                    let first = column(least[1].max(from[1]));
                    if first == column_of
                        && (1..3).all(|axis| least[axis] <= to[axis] && from[axis] <= most[axis])
                        && self.cross(one as usize, other as usize)
                    {
                        let [a, b, c] = self.corners(one as usize);
                        let place = [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
                        let facets = [one.min(other) as usize, one.max(other) as usize];
                        return Err(MeshError::Crossing { facets, place });
                    }
                }
            }
        }
        Ok(())
    }

    /// Width of the columns, and where the first starts.
    fn columns(&self, boxes: &[[Point; 2]]) -> [f64; 2] {
        let (low, high) = super::vector::bounds(&self.nodes);
        let mean = boxes.iter().map(|[low, high]| high[1] - low[1]).sum::<f64>() / boxes.len() as f64;
        let span = high[1] - low[1];
        [(2.0 * mean).max(span / 1e4).max(f64::MIN_POSITIVE), low[1]]
    }

    /// Whether two facets have a point in common that is on no common node or edge.
    fn cross(&self, one: usize, other: usize) -> bool {
        let (f, g) = (self.facets[one], self.facets[other]);
        let common: Vec<u32> = f.iter().copied().filter(|node| g.contains(node)).collect();
        let at = |node: u32| self.nodes[node as usize];
        match common[..] {
            [] => {
                let meets = |edges: [u32; 3], facet: [u32; 3]| {
                    (0..3).any(|k| meet([edges[k], edges[(k + 1) % 3]].map(at), facet.map(at)))
                };
                meets(f, g) || meets(g, f)
            }
            [node] => {
                let opposite = |facet: [u32; 3]| {
                    let place = facet.iter().position(|&corner| corner == node).unwrap_or(0);
                    [facet[(place + 1) % 3], facet[(place + 2) % 3]].map(at)
                };
                meet(opposite(f), g.map(at)) || meet(opposite(g), f.map(at))
            }
            [a, b] => {
                let apex = |facet: [u32; 3]| facet.into_iter().find(|corner| !common.contains(corner));
                let (Some(c), Some(d)) = (apex(f), apex(g)) else { return true };
                // In one plane, on the same side of their edge.
                side(at(a), at(b), at(c), at(d)) == 0.0
                    && !opposite_in_plane([at(a), at(b), at(c)], at(a), at(b), at(c), at(d))
            }
            _ => true,
        }
    }
}

/// The two axes on which a triangle has its largest shadow.
fn shadow([a, b, c]: [Point; 3]) -> [usize; 2] {
    let n = super::vector::normal(a, b, c).map(f64::abs);
    if n[0] >= n[1] && n[0] >= n[2] {
        [1, 2]
    } else if n[1] >= n[2] {
        [2, 0]
    } else {
        [0, 1]
    }
}

fn turn(axes: [usize; 2], a: Point, b: Point, c: Point) -> f64 {
    let [a, b, c] = [a, b, c].map(|point| robust::Coord { x: point[axes[0]], y: point[axes[1]] });
    robust::orient2d(a, b, c)
}

/// Whether two points in the plane of a triangle are on different sides of a line in it.
fn opposite_in_plane(plane: [Point; 3], a: Point, b: Point, c: Point, d: Point) -> bool {
    let axes = shadow(plane);
    (turn(axes, a, b, c) > 0.0) != (turn(axes, a, b, d) > 0.0)
}

/// Whether an edge and a triangle have a point in common.
fn meet([p, q]: [Point; 2], [a, b, c]: [Point; 3]) -> bool {
    let (one, other) = (side(a, b, c, p), side(a, b, c, q));
    if one > 0.0 && other > 0.0 || one < 0.0 && other < 0.0 {
        return false;
    }
    if one == 0.0 && other == 0.0 {
        return meet_in_plane([p, q], [a, b, c]);
    }
    let turns = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
    turns.iter().all(|&turn| turn >= 0.0) || turns.iter().all(|&turn| turn <= 0.0)
}

/// Whether an edge and a triangle in one plane have a point in common.
fn meet_in_plane([p, q]: [Point; 2], [a, b, c]: [Point; 3]) -> bool {
    let axes = shadow([a, b, c]);
    let sign = turn(axes, a, b, c).signum();
    let inside = |point: Point| {
        [[a, b], [b, c], [c, a]].iter().all(|&[from, to]| sign * turn(axes, from, to, point) >= 0.0)
    };
    let touch = |[r, s]: [Point; 2]| {
        let opposite = |x: f64, y: f64| !(x > 0.0 && y > 0.0 || x < 0.0 && y < 0.0);
        let within = axes.iter().all(|&axis| {
            p[axis].min(q[axis]) <= r[axis].max(s[axis]) && r[axis].min(s[axis]) <= p[axis].max(q[axis])
        });
        within
            && opposite(turn(axes, p, q, r), turn(axes, p, q, s))
            && opposite(turn(axes, r, s, p), turn(axes, r, s, q))
    };
    inside(p) || inside(q) || [[a, b], [b, c], [c, a]].into_iter().any(touch)
}
