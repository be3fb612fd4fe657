//! Networks of lines, such as joints in rock, that become edges of the mesh of a domain.
//!
//! Lines are cut where they cross each other and the loops of the domain, and parts outside are left out.
//! Parts that would give elements much smaller than the mesh size are snapped: points nearer to each other
//! than a share of the mesh size become one, and a line that passes a point at less than that distance goes
//! through it. Lines that nearly coincide therefore become one line, and lines that end near a loop, or near
//! another line, end on it.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;

use super::outline::{Domain, Inside, Point, distance, twice_area};
use crate::bounds;
use crate::grading::Grading;

/// Distance over mesh size up to which points and lines are snapped to each other.
pub const SNAP: f64 = 0.35;

/// Distance of an end of a line from the domain, over the width of the domain, from which only the part of
/// the line that is near counts: with its end the line would have too few digits.
const FAR: f64 = 1e6;

/// Rounds of cutting and snapping.
const ROUNDS: usize = 50;

/// A line that is in a domain already.
const GIVEN: u32 = u32::MAX;

/// Lines that cannot be cut and snapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangled {
    /// Numbers of two lines that are too close to each other.
    pub lines: [usize; 2],
    /// The place.
    pub place: Point,
}

impl fmt::Display for Tangled {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([a, b], place) = (self.lines, self.place);
        write!(out, "lines {a} and {b} are too close to each other for the mesh size near {place:?}")
    }
}

impl Error for Tangled {}

/// Adds lines, by their two ends, to those of a domain, and their ends on loops to the loops. Returns for
/// each line of the domain the number of the line that it is a part of, if it is one of these: where two
/// coincide, that of the first.
///
/// # Units
/// `size` is in the unit of the coordinates.
///
/// # Cost
/// Mostly the comparison of lines that overlap along x.
///
/// # Errors
/// [`Tangled`].
///
/// # Example
/// ```
/// use fdem_mesh::Grading;
/// use fdem_mesh::triangles::{add_lines, outline::Domain, triangles};
///
/// let square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// let mut domain = Domain { loops: vec![square], lines: Vec::new() };
/// let size = Grading::even(0.1);
/// // From outside to inside: half of it is in the square.
/// let parts = add_lines(&mut domain, &[[[-0.5, 0.5], [0.5, 0.5]]], &size)?;
/// assert_eq!((domain.lines.len(), parts), (1, vec![Some(0)]));
/// let mesh = triangles(&domain, &size, 1)?;
/// assert_eq!(mesh.lines.len(), 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn add_lines(
    domain: &mut Domain,
    lines: &[[Point; 2]],
    size: &Grading<2>,
) -> Result<Vec<Option<usize>>, Tangled> {
    let mut network = Network::new(domain, size);
    for &ends in &std::mem::take(&mut domain.lines) {
        network.add(ends, GIVEN);
    }
    let around = domain.bounds();
    for (number, &ends) in (0..).zip(lines) {
        if let Some(ends) = near(ends, around) {
            network.add(ends, number);
        }
    }
    network.leave_outside();
    for round in 0.. {
        let before = network.changes;
        network.cut();
        network.join();
        let done = network.changes == before;
        if done {
            break;
        }
        if round == ROUNDS {
            let place = network.last;
            return Err(Tangled { lines: network.nearest_two(place), place });
        }
    }
    network.leave_outside();
    Ok(network.hand_over(domain))
}

/// A part of a line, by its vertices.
#[derive(Clone, Copy, Debug)]
struct Part {
    ends: [usize; 2],
    line: u32,
}

/// Parts of lines between vertices, and edges of loops.
struct Network<'a> {
    size: &'a Grading<2>,
    inside: Inside,
    vertices: Vec<Point>,
    /// Number of vertices that are corners of loops, and stay where they are.
    corners: usize,
    /// The loop of each edge, and its ends.
    edges: Vec<(usize, [usize; 2])>,
    parts: Vec<Part>,
    /// Number of changes so far, and the place of the last.
    changes: usize,
    last: Point,
}

impl<'a> Network<'a> {
    fn new(domain: &Domain, size: &'a Grading<2>) -> Self {
        let vertices: Vec<Point> = domain.loops.iter().flatten().copied().collect();
        let mut edges = Vec::with_capacity(vertices.len());
        let mut first = 0;
        for (number, corners) in domain.loops.iter().enumerate() {
            let count = corners.len();
            edges.extend((0..count).map(|k| (number, [first + k, first + (k + 1) % count])));
            first += count;
        }
        Self {
            size,
            inside: Inside::new(&domain.loops),
            corners: vertices.len(),
            vertices,
            edges,
            parts: Vec::new(),
            changes: 0,
            last: [0.0; 2],
        }
    }

    fn add(&mut self, ends: [Point; 2], line: u32) {
        let first = self.vertices.len();
        self.vertices.extend(ends);
        self.parts.push(Part { ends: [first, first + 1], line });
    }

    fn at(&self, [a, b]: [usize; 2]) -> [Point; 2] {
        [self.vertices[a], self.vertices[b]]
    }

    fn reach(&self, point: Point) -> f64 {
        SNAP * self.size.at(point)
    }

    fn note(&mut self, place: Point) {
        self.changes += 1;
        self.last = place;
    }

    /// Removes the parts outside of the loops, after all are cut at the loops.
    fn leave_outside(&mut self) {
        let mut parts = Vec::with_capacity(self.parts.len());
        for part in std::mem::take(&mut self.parts) {
            let [a, b] = self.at(part.ends);
            let mut cuts: Vec<f64> = self
                .edges
                .iter()
                .filter(|(_, edge)| !edge.iter().any(|end| part.ends.contains(end)))
                .filter_map(|(_, edge)| crossing([a, b], self.at(*edge)).map(|(t, _)| t))
                .collect();
            cuts.push(1.0);
            cuts.sort_by(f64::total_cmp);
            let (mut last, mut from) = (0.0, part.ends[0]);
            for t in cuts {
                let to = if t == 1.0 { part.ends[1] } else { self.vertices.len() };
                if to == self.vertices.len() {
                    self.vertices.push(along(a, b, t));
                }
                if self.inside.contains(along(a, b, f64::midpoint(last, t))) {
                    parts.push(Part { ends: [from, to], line: part.line });
                }
                (last, from) = (t, to);
            }
        }
        self.parts = parts;
    }

    /// Makes vertices that are near to each other one, and puts vertices near a loop on it.
    fn join(&mut self) {
        let mut used = vec![false; self.vertices.len()];
        for &end in self.parts.iter().flat_map(|part| &part.ends) {
            used[end] = true;
        }
        for &end in self.edges.iter().flat_map(|(_, ends)| ends) {
            used[end] = true;
        }
        let mut on_loop = vec![false; self.vertices.len()];
        for &end in self.edges.iter().flat_map(|(_, ends)| ends) {
            on_loop[end] = true;
        }
        // Corners first, then points on loops: these stay.
        let mut order: Vec<usize> = (0..self.vertices.len()).filter(|&vertex| used[vertex]).collect();
        order.sort_by_key(|&vertex| (vertex >= self.corners, !on_loop[vertex], vertex));
        let mut cells: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
        let width = self.size.size * SNAP;
        let cell = |point: Point| point.map(|x| (x / width).floor() as i64);
        let mut now: Vec<usize> = (0..self.vertices.len()).collect();
        for vertex in order {
            let point = self.vertices[vertex];
            let [column, row] = cell(point);
            let reach = self.reach(point);
            let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [column + dx, row + dy]));
            let near = around.filter_map(|cell| cells.get(&cell)).flatten().copied();
            let gap = |other: usize| distance(point, self.vertices[other]);
            let nearest = near.min_by(|&a, &b| gap(a).total_cmp(&gap(b)).then(a.cmp(&b)));
            match nearest.filter(|&other| vertex >= self.corners && gap(other) < reach) {
                Some(other) => {
                    now[vertex] = other;
                    self.note(point);
                }
                None => cells.entry([column, row]).or_default().push(vertex),
            }
        }
        for part in &mut self.parts {
            part.ends = part.ends.map(|end| now[end]);
        }
        for (_, ends) in &mut self.edges {
            *ends = ends.map(|end| now[end]);
        }
        self.edges.retain(|(_, [a, b])| a != b);
        self.once_each();
    }

    /// Removes parts without length, and all but the first of those between the same vertices, or along a
    /// loop.
    fn once_each(&mut self) {
        let ordered = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
        let mut edges: Vec<[usize; 2]> = self.edges.iter().map(|(_, ends)| ordered(*ends)).collect();
        edges.sort_unstable();
        self.parts
            .retain(|part| part.ends[0] != part.ends[1] && edges.binary_search(&ordered(part.ends)).is_err());
        self.parts.sort_by_key(|part| (ordered(part.ends), part.line));
        self.parts.dedup_by_key(|part| ordered(part.ends));
    }

    /// Cuts parts and edges of loops where they cross each other, and where they pass a vertex.
    fn cut(&mut self) {
        let edges = self.edges.len();
        let all: Vec<[usize; 2]> =
            self.edges.iter().map(|(_, ends)| *ends).chain(self.parts.iter().map(|part| part.ends)).collect();
        // Cuts of each of them: the place along it, and the vertex.
        let mut cuts: Vec<Vec<(f64, usize)>> = vec![Vec::new(); all.len()];
        let margin = SNAP * self.size.size;
        let box_of = |ends: [usize; 2], vertices: &[Point]| bounds(ends.iter().map(|&end| vertices[end]));
        let boxes: Vec<[Point; 2]> = all.iter().map(|&ends| box_of(ends, &self.vertices)).collect();
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by(|&a, &b| boxes[a][0][0].total_cmp(&boxes[b][0][0]).then(a.cmp(&b)));
        for (place, &one) in order.iter().enumerate() {
            for &other in &order[place + 1..] {
                if boxes[other][0][0] > boxes[one][1][0] + margin {
                    break;
                }
                let apart = boxes[other][0][1] > boxes[one][1][1] + margin
                    || boxes[one][0][1] > boxes[other][1][1] + margin;
                if apart || (one < edges && other < edges) {
                    continue;
                }
                let (first, second) = (one.min(other), one.max(other));
                self.compare([first, second], [all[first], all[second]], first < edges, &mut cuts);
            }
        }
        if cuts.iter().all(Vec::is_empty) {
            return;
        }
        let mut parts = Vec::with_capacity(self.parts.len());
        let mut loops = Vec::with_capacity(self.edges.len());
        for (number, cuts) in cuts.iter_mut().enumerate() {
            cuts.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let chain = std::iter::once(all[number][0]).chain(cuts.iter().map(|(_, vertex)| *vertex));
            let mut chain: Vec<usize> = chain.chain([all[number][1]]).collect();
            chain.dedup();
            for pair in chain.windows(2) {
                let ends = [pair[0], pair[1]];
                if number < edges {
                    loops.push((self.edges[number].0, ends));
                } else {
                    parts.push(Part { ends, line: self.parts[number - edges].line });
                }
            }
        }
        (self.edges, self.parts) = (loops, parts);
        self.once_each();
    }

    /// Notes where two of them cut each other. `on_loop`: whether the first is an edge of a loop, which stays
    /// straight.
    fn compare(
        &mut self,
        numbers: [usize; 2],
        ends: [[usize; 2]; 2],
        on_loop: bool,
        cuts: &mut [Vec<(f64, usize)>],
    ) {
        if ends[0].iter().all(|end| ends[1].contains(end)) {
            return;
        }
        let mut near = false;
        for side in 0..2 {
            let [a, b] = self.at(ends[side]);
            for end in ends[1 - side].into_iter().filter(|end| !ends[side].contains(end)) {
                let point = self.vertices[end];
                let (t, foot) = foot(point, a, b);
                let reach = self.reach(point);
                // Points near an end are joined with it.
                let beside = distance(point, a) < reach || distance(point, b) < reach;
                if distance(point, foot) >= reach || beside || t <= 0.0 || t >= 1.0 {
                    continue;
                }
                near = true;
                if side == 0 && on_loop {
                    // Its corners stay, and others are moved to it.
                    if end < self.corners {
                        continue;
                    }
                    self.vertices[end] = foot;
                }
                cuts[numbers[side]].push((t, end));
                self.note(point);
            }
        }
        let share = ends[0].iter().any(|end| ends[1].contains(end));
        if near || share {
            return;
        }
        let [one, other] = ends.map(|ends| self.at(ends));
        if let Some((t, u)) = crossing(one, other) {
            let point = along(one[0], one[1], t);
            self.vertices.push(point);
            let vertex = self.vertices.len() - 1;
            cuts[numbers[0]].push((t, vertex));
            cuts[numbers[1]].push((u, vertex));
            self.note(point);
        }
    }

    /// Two lines nearest to a place.
    fn nearest_two(&self, place: Point) -> [usize; 2] {
        let gap = |part: &Part| {
            let [a, b] = self.at(part.ends);
            distance(place, foot(place, a, b).1)
        };
        let mut parts: Vec<&Part> = self.parts.iter().filter(|part| part.line != GIVEN).collect();
        parts.sort_by(|a, b| gap(a).total_cmp(&gap(b)));
        let first = parts.first().map_or(0, |part| part.line);
        let second = parts.iter().map(|part| part.line).find(|&line| line != first).unwrap_or(first);
        [first as usize, second as usize]
    }

    /// Gives the loops and the lines to the domain.
    fn hand_over(mut self, domain: &mut Domain) -> Vec<Option<usize>> {
        for (number, corners) in domain.loops.iter_mut().enumerate() {
            let chain = self.edges.iter().filter(|(of, _)| *of == number);
            *corners = chain.map(|(_, ends)| self.vertices[ends[0]]).collect();
        }
        self.once_each();
        self.parts.sort_by_key(|part| (part.line, part.ends));
        domain.lines = self.parts.iter().map(|part| self.at(part.ends)).collect();
        self.parts.iter().map(|part| (part.line != GIVEN).then_some(part.line as usize)).collect()
    }
}

/// A line, or its part near bounds if an end is far from them; `None` if no part of that is near.
fn near([a, b]: [Point; 2], [low, high]: [Point; 2]) -> Option<[Point; 2]> {
    let width = distance(low, high);
    let is_far =
        |end: Point| (0..2).any(|axis| (end[axis] - low[axis]).max(high[axis] - end[axis]) > FAR * width);
    if !is_far(a) && !is_far(b) {
        return Some([a, b]);
    }
    let mut ends = [a, b];
    for (axis, other) in [(0, 1), (1, 0)] {
        for (bound, side) in [(low[axis] - width, 1.0), (high[axis] + width, -1.0)] {
            let out = ends.map(|end| side * (end[axis] - bound) < 0.0);
            let (outer, inner) = match out {
                [true, true] => return None,
                [true, false] => (0, 1),
                [false, true] => (1, 0),
                [false, false] => continue,
            };
            // By the slope, because a place from 0 to 1 along a long line has too few digits.
            let [from, to] = [ends[inner], ends[outer]];
            let slope = (to[other] - from[other]) / (to[axis] - from[axis]);
            ends[outer][axis] = bound;
            ends[outer][other] = from[other] + slope * (bound - from[axis]);
        }
    }
    Some(ends)
}

/// The place along a line that is nearest to a point, 0 to 1, and the point there.
fn foot(point: Point, a: Point, b: Point) -> (f64, Point) {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 { ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / square } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    (t, along(a, b, t))
}

/// Where two lines cross each other, as places along both, 0 to 1.
pub(super) fn crossing([a, b]: [Point; 2], [p, q]: [Point; 2]) -> Option<(f64, f64)> {
    let (side_a, side_b) = (twice_area(p, q, a), twice_area(p, q, b));
    let (side_p, side_q) = (twice_area(a, b, p), twice_area(a, b, q));
    let cross = (side_a > 0.0) != (side_b > 0.0) && (side_p > 0.0) != (side_q > 0.0);
    cross.then(|| (side_a / (side_a - side_b), side_p / (side_p - side_q)))
}

/// The point of a line at a place along it. Points on a line along an axis have exactly its coordinate.
pub(super) fn along(a: Point, b: Point, t: f64) -> Point {
    [0, 1].map(|axis| a[axis] + t * (b[axis] - a[axis]))
}
