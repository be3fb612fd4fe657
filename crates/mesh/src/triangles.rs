//! Unstructured meshes of triangles, of even or graded size and good angles.
//!
//! Outlines and lines are cut into pieces by the size; the inside is filled with points that keep a distance
//! from each other (Poisson discs); all is triangulated by Delaunay's rule under the constraint of the
//! outlines; then each point inside moves to the centroid of the triangles around it, and all is triangulated
//! again, several times. Directions of edges are random, as cracks along edges need it, and the same seed
//! gives the same mesh.
//!
//! # Sources
//! R. Bridson, "Fast Poisson disk sampling in arbitrary dimensions", SIGGRAPH 2007; Q. Du, V. Faber, M.
//! Gunzburger, "Centroidal Voronoi tessellations", SIAM Review 41 (1999), for the idea of the smoothing.

use std::collections::BTreeMap;

use fdem_scenes::random::Random;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

mod error;
mod grains;
mod mesh;
mod network;
pub mod outline;
mod within;

pub use error::OutlineError;
pub use grains::{Grains, colours};
pub use mesh::Triangles;
pub use network::{SNAP, Tangled, add_lines};
pub use within::lengths_inside;

use outline::{Domain, Inside, Point, distance, twice_area};

use crate::curve::place;
use crate::grading::{Grading, stations};
use crate::{MOST_ELEMENTS, bounds};

/// Represents the loop of nodes inside.
pub const INSIDE: u32 = u32::MAX;

/// Largest number of elements.
const MOST: f64 = MOST_ELEMENTS as f64;

/// Distance of points over the requested edge, so that the mean edge has the requested length.
const SPACING: f64 = 0.71;

/// Attempts to find a place beside a point before it is given up.
const ATTEMPTS: usize = 16;

/// Rounds of smoothing.
const ROUNDS: usize = 8;

/// Meshes a domain with edges as long as `size` says.
///
/// # Units
/// `size` is in the unit of the coordinates.
///
/// # Cost
/// Time in proportion to the number of elements, most of it for nine triangulations.
///
/// # Errors
/// [`OutlineError`]: outlines that cross or touch themselves, and sizes that give no element or too many.
pub fn triangles(domain: &Domain, size: &Grading<2>, seed: u64) -> Result<Triangles, OutlineError> {
    let length: f64 = domain.loops.iter().map(|corners| outline::length(corners)).sum();
    let per_square = 4.0 / 3.0_f64.sqrt();
    let mut expected = domain.area() / size.size / size.size / (3.0_f64.sqrt() / 4.0) + length / size.size;
    let within = domain.bounds();
    expected += size.near.iter().map(|near| per_square * near.cubes(within)).sum::<f64>();
    if !(expected.is_finite() && expected <= MOST) {
        return Err(OutlineError::TooMany { elements: expected });
    }
    holes_are_inside(domain)?;
    let origin = domain.middle_if_far();
    let domain = &domain.relative_to(origin);
    let size = &size.relative_to(origin);
    let mut frame = OutlineFrame::new(domain, origin, size)?;
    let fixed = frame.nodes.len();
    let inside = Inside::new(&domain.loops);
    fill(&mut frame.nodes, domain, &inside, size, seed)?;
    let mut elements = triangulate(&frame)?;
    for _ in 0..ROUNDS {
        smooth(&mut frame.nodes, fixed, &elements, &inside, size);
        elements = triangulate(&frame)?;
    }
    if elements.is_empty() {
        return Err(OutlineError::NoArea);
    }
    frame.loops.resize(frame.nodes.len(), INSIDE);
    let numbers = renumber(&mut frame.nodes, &mut frame.loops, &mut elements);
    let number = |node: u32| Some(numbers[node as usize]).filter(|&number| number != INSIDE);
    let lines = frame.lines.iter().zip(&frame.line_of);
    let (lines, line_of) =
        lines.filter_map(|(&[a, b], &line)| Some(([number(a)?, number(b)?], line))).unzip();
    let nodes = frame.nodes.iter().map(|&node| frame.place(node)).collect();
    Ok(Triangles { nodes, elements, loops: frame.loops, lines, line_of })
}

/// Checks that every hole is inside the outline and none is in another hole.
pub(crate) fn holes_are_inside(domain: &Domain) -> Result<(), OutlineError> {
    let Some((outer, holes)) = domain.loops.split_first() else { return Ok(()) };
    let outline = Inside::new(std::slice::from_ref(outer));
    for (number, hole) in holes.iter().enumerate() {
        if let Some(corner) = hole.iter().find(|&&corner| !outline.contains(corner)) {
            return Err(OutlineError::HoleOutside { hole: number + 1, place: *corner });
        }
    }
    let boxes: Vec<[Point; 2]> = holes.iter().map(|hole| bounds(hole.iter().copied())).collect();
    let beyond = |[low, high]: [Point; 2], [least, most]: [Point; 2]| {
        (0..2).any(|axis| low[axis] < least[axis] || high[axis] > most[axis])
    };
    for (other, around) in holes.iter().enumerate() {
        let mut around_is_inside = None;
        for (number, hole) in holes.iter().enumerate().filter(|(number, _)| *number != other) {
            if beyond(boxes[number], boxes[other]) {
                continue;
            }
            let inside = around_is_inside.get_or_insert_with(|| Inside::new(std::slice::from_ref(around)));
            if hole.iter().all(|&corner| inside.contains(corner)) {
                return Err(OutlineError::HoleInHole { hole: number + 1, around: other + 1 });
            }
        }
    }
    Ok(())
}

/// Points on outlines and lines, and the edges between them.
struct OutlineFrame {
    /// Origin of the coordinates of the nodes, in coordinates of the model.
    origin: Point,
    nodes: Vec<Point>,
    loops: Vec<u32>,
    /// Edges of outlines and lines.
    edges: Vec<[usize; 2]>,
    /// Edges of lines.
    lines: Vec<[u32; 2]>,
    /// The line of each.
    line_of: Vec<u32>,
}

impl OutlineFrame {
    fn new(domain: &Domain, origin: Point, size: &Grading<2>) -> Result<Self, OutlineError> {
        let mut frame = Self {
            origin,
            nodes: Vec::new(),
            loops: Vec::new(),
            edges: Vec::new(),
            lines: Vec::new(),
            line_of: Vec::new(),
        };
        let mut known: BTreeMap<[u64; 2], usize> = BTreeMap::new();
        let key = |point: Point| point.map(|x| (x + 0.0).to_bits());
        for (number, corners) in (0..).zip(&domain.loops) {
            for &corner in corners {
                if known.insert(key(corner), frame.nodes.len()).is_some() {
                    return Err(OutlineError::Twice { place: frame.place(corner) });
                }
                frame.push(corner, number);
            }
        }
        let mut first = 0;
        for (number, corners) in (0..).zip(&domain.loops) {
            for k in 0..corners.len() {
                frame.divide(first + k, first + (k + 1) % corners.len(), number, size);
            }
            first += corners.len();
        }
        for (number, &[a, b]) in (0..).zip(&domain.lines) {
            let mut end = |point: Point| {
                *known.entry(key(point)).or_insert_with(|| {
                    frame.push(point, INSIDE);
                    frame.nodes.len() - 1
                })
            };
            let (a, b) = (end(a), end(b));
            let before = frame.edges.len();
            frame.divide(a, b, INSIDE, size);
            let lines = frame.edges[before..].iter().map(|&[a, b]| [a as u32, b as u32]);
            frame.lines.extend(lines);
            frame.line_of.resize(frame.lines.len(), number);
        }
        Ok(frame)
    }

    /// A point in the coordinates of the model.
    fn place(&self, point: Point) -> Point {
        [0, 1].map(|axis| point[axis] + self.origin[axis])
    }

    fn push(&mut self, point: Point, number: u32) {
        self.nodes.push(point);
        self.loops.push(number);
    }

    /// Cuts the line between two nodes into pieces; equal ones if the size is even.
    fn divide(&mut self, a: usize, b: usize, number: u32, size: &Grading<2>) {
        let (from, to) = (self.nodes[a], self.nodes[b]);
        // Points on a line along an axis have exactly its coordinate.
        let at = |t: f64| [0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis]));
        let round = |pieces: f64| pieces.round().clamp(1.0, MOST) as usize;
        let span = distance(from, to);
        let places: Vec<f64> = if size.near.is_empty() {
            let pieces = round(span / size.size);
            (1..pieces).map(|piece| piece as f64 / pieces as f64).collect()
        } else {
            stations(span, &|t| size.at(at(t)), &round)
        };
        let mut last = a;
        for t in places {
            let next = self.nodes.len();
            self.push(at(t), number);
            self.edges.push([last, next]);
            last = next;
        }
        self.edges.push([last, b]);
    }
}

/// Fills the inside with points that keep a distance from each other and from those that are there.
fn fill(
    nodes: &mut Vec<Point>,
    domain: &Domain,
    inside: &Inside,
    size: &Grading<2>,
    seed: u64,
) -> Result<(), OutlineError> {
    let apart = |point: Point| SPACING * size.at(point);
    let mut cells = Cells::new(domain, size)?;
    for (node, &point) in (0..).zip(nodes.iter()) {
        cells.insert(node, point, apart(point));
    }
    let mut random = Random::new(seed);
    let mut active: Vec<u32> = (0..nodes.len() as u32).collect();
    while !active.is_empty() {
        let place = random.below(active.len() as u64) as usize;
        let from = nodes[active[place] as usize];
        let least = apart(from);
        let found = (0..ATTEMPTS).find_map(|_| {
            let [dx, dy] = ring(&mut random);
            let point = [from[0] + least * dx, from[1] + least * dy];
            (inside.contains(point) && cells.is_free(nodes, point, apart(point))).then_some(point)
        });
        match found {
            Some(point) => {
                cells.insert(nodes.len() as u32, point, apart(point));
                active.push(nodes.len() as u32);
                nodes.push(point);
            }
            None => {
                active.swap_remove(place);
            }
        }
    }
    Ok(())
}

/// A point between the circles of radius 1 and 2; no sine is needed, which differs from platform to platform.
fn ring(random: &mut Random) -> Point {
    loop {
        let [x, y] = [random.between(-2.0, 2.0), random.between(-2.0, 2.0)];
        if (1.0..=4.0).contains(&(x * x + y * y)) {
            return [x, y];
        }
    }
}

/// Singly connected lists of points by square cells, on one grid for each doubling of the distance that the
/// points keep.
///
/// As that distance grows slowly from place to place, points that may be too near to each other are on one
/// grid or on two that follow each other.
struct Cells {
    levels: Vec<Level>,
    /// The distance from which points are on the second grid; each grid after it begins at twice the
    /// distance.
    second: f64,
    next: Vec<u32>,
}

/// A grid of square cells.
struct Level {
    origin: Point,
    per_length: f64,
    columns: usize,
    rows: usize,
    head: Heads,
}

/// The first point of each cell.
enum Heads {
    /// One for each cell.
    All(Vec<u32>),
    /// One for each cell with a point: for outlines that fill little of their bounding box.
    Some(BTreeMap<usize, u32>),
}

/// Cells of a grid for which memory is taken whether or not they have a point.
const CELLS: f64 = 2e7;

impl Cells {
    fn new(domain: &Domain, size: &Grading<2>) -> Result<Self, OutlineError> {
        let (least, most) = (SPACING * size.least(), SPACING * size.size);
        let mut levels = vec![Level::new(domain, if least < most { 2.0 * least } else { least })?];
        let mut first = 2.0 * least;
        while first <= most {
            levels.push(Level::new(domain, 2.0 * first)?);
            first *= 2.0;
        }
        Ok(Self { levels, second: 2.0 * least, next: Vec::new() })
    }

    /// The grid of points that keep this distance.
    fn level(&self, apart: f64) -> usize {
        let (mut level, mut first) = (0, self.second);
        while apart >= first && level + 1 < self.levels.len() {
            (level, first) = (level + 1, 2.0 * first);
        }
        level
    }

    /// Adds a node that keeps the distance `apart`. Nodes have to come in order.
    fn insert(&mut self, node: u32, point: Point, apart: f64) {
        let level = self.level(apart);
        let level = &mut self.levels[level];
        let [column, row] = level.cell(point);
        let cell = row * level.columns + column;
        let head = match &mut level.head {
            Heads::All(heads) => &mut heads[cell],
            Heads::Some(heads) => heads.entry(cell).or_insert(INSIDE),
        };
        self.next.push(*head);
        *head = node;
    }

    /// Whether no node is nearer than `apart`, which is the distance that a node at the point has to keep.
    fn is_free(&self, nodes: &[Point], point: Point, apart: f64) -> bool {
        let level = self.level(apart);
        let near = level.saturating_sub(1)..=(level + 1).min(self.levels.len() - 1);
        self.levels[near].iter().all(|level| level.is_free(nodes, &self.next, point, apart))
    }
}

impl Level {
    /// A grid of cells with this edge.
    fn new(domain: &Domain, edge: f64) -> Result<Self, OutlineError> {
        let [low, high] = domain.bounds();
        let [columns, rows] = [0, 1].map(|axis| ((high[axis] - low[axis]) / edge).floor() + 1.0);
        let cells = columns * rows;
        // Beyond, cells have no numbers that are exact.
        if cells.is_nan() || cells > 2.0_f64.powi(52) {
            return Err(OutlineError::SizeTooSmall);
        }
        let (columns, rows) = (columns as usize, rows as usize);
        let head = if cells <= CELLS {
            Heads::All(vec![INSIDE; columns * rows])
        } else {
            Heads::Some(BTreeMap::new())
        };
        Ok(Self { origin: low, per_length: 1.0 / edge, columns, rows, head })
    }

    /// The first point of a cell, or [`INSIDE`].
    fn head(&self, cell: usize) -> u32 {
        match &self.head {
            Heads::All(heads) => heads[cell],
            Heads::Some(heads) => heads.get(&cell).copied().unwrap_or(INSIDE),
        }
    }

    fn cell(&self, [x, y]: Point) -> [usize; 2] {
        let column = ((x - self.origin[0]) * self.per_length) as usize;
        let row = ((y - self.origin[1]) * self.per_length) as usize;
        [column.min(self.columns - 1), row.min(self.rows - 1)]
    }

    fn is_free(&self, nodes: &[Point], next: &[u32], point: Point, least: f64) -> bool {
        let [column, row] = self.cell(point);
        // Cells within the distance: one in each direction, or two of the next finer grid.
        let reach = (least * self.per_length - 1e-9).ceil().max(1.0) as usize;
        for row in row.saturating_sub(reach)..=(row + reach).min(self.rows - 1) {
            for column in column.saturating_sub(reach)..=(column + reach).min(self.columns - 1) {
                let mut node = self.head(row * self.columns + column);
                while node != INSIDE {
                    let [x, y] = nodes[node as usize];
                    let (dx, dy) = (x - point[0], y - point[1]);
                    if dx * dx + dy * dy < least * least {
                        return false;
                    }
                    node = next[node as usize];
                }
            }
        }
        true
    }
}

/// The triangles inside, counter-clockwise.
fn triangulate(frame: &OutlineFrame) -> Result<Vec<[u32; 3]>, OutlineError> {
    let points: Vec<_> = frame.nodes.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    let count = points.len();
    let mut crossing = None;
    let triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(
        points,
        frame.edges.clone(),
        |[a, _]| crossing = crossing.or(Some(a)),
    )
    .map_err(|error| OutlineError::coordinates("the outline", error))?;
    if triangulation.num_vertices() != count {
        return Err(OutlineError::Coincide);
    }
    if let Some(node) = crossing {
        return Err(OutlineError::Crossing { place: frame.place(frame.nodes[node]) });
    }
    Ok(faces_inside(&triangulation, &frame.lines))
}

/// The triangles that are parted from the outside by an odd number of outlines: found from triangle to
/// triangle, so that no rounding decides.
fn faces_inside(
    triangulation: &ConstrainedDelaunayTriangulation<Point2<f64>>,
    lines: &[[u32; 2]],
) -> Vec<[u32; 3]> {
    let mut sorted: Vec<[u32; 2]> = lines.iter().map(|&[a, b]| if a < b { [a, b] } else { [b, a] }).collect();
    sorted.sort_unstable();
    let mut inside: Vec<Option<bool>> = vec![None; triangulation.num_all_faces()];
    let mut open = Vec::new();
    for face in triangulation.inner_faces() {
        for edge in face.adjacent_edges() {
            if edge.rev().face().is_outer() && inside[face.fix().index()].is_none() {
                inside[face.fix().index()] = Some(edge.is_constraint_edge());
                open.push(face.fix());
            }
        }
    }
    while let Some(face) = open.pop() {
        let here = inside[face.index()] == Some(true);
        for edge in triangulation.face(face).adjacent_edges() {
            let Some(next) = edge.rev().face().as_inner() else { continue };
            if inside[next.fix().index()].is_none() {
                let [a, b] = edge.vertices().map(|node| node.fix().index() as u32);
                let outline =
                    edge.is_constraint_edge() && sorted.binary_search(&[a.min(b), a.max(b)]).is_err();
                inside[next.fix().index()] = Some(here != outline);
                open.push(next.fix());
            }
        }
    }
    let kept = triangulation.inner_faces().filter(|face| inside[face.fix().index()] == Some(true));
    kept.map(|face| face.vertices().map(|node| node.fix().index() as u32)).collect()
}

/// Moves each node that is not fixed to the centroid of the area that its triangles cover: where the size
/// varies, with a weight that falls with its fourth power, which keeps small elements small (Du, Faber and
/// Gunzburger, section 6).
fn smooth(nodes: &mut [Point], fixed: usize, elements: &[[u32; 3]], inside: &Inside, size: &Grading<2>) {
    let even = size.near.is_empty();
    let mut sums = vec![[0.0; 3]; nodes.len()];
    for &triangle in elements {
        let [a, b, c] = triangle.map(|node| nodes[node as usize]);
        let mut weight = twice_area(a, b, c);
        if !even {
            let middle = [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
            weight *= (size.size / size.at(middle)).powi(4);
        }
        for node in triangle {
            let sum = &mut sums[node as usize];
            sum[0] += weight;
            sum[1] += weight * (a[0] + b[0] + c[0]) / 3.0;
            sum[2] += weight * (a[1] + b[1] + c[1]) / 3.0;
        }
    }
    for (node, [weight, x, y]) in nodes.iter_mut().zip(sums).skip(fixed) {
        let moved = [x / weight, y / weight];
        if weight > 0.0 && inside.contains(moved) {
            *node = moved;
        }
    }
}

/// Removes nodes without triangles, and numbers nodes and triangles along Hilbert's curve: neighbours in the
/// body are near in memory. Returns the new number of each node, [`INSIDE`] for removed nodes.
fn renumber(nodes: &mut Vec<Point>, loops: &mut Vec<u32>, elements: &mut [[u32; 3]]) -> Vec<u32> {
    let mut used = vec![false; nodes.len()];
    for &node in elements.iter().flatten() {
        used[node as usize] = true;
    }
    let curve = Curve::around(nodes);
    let mut order: Vec<u32> = (0..nodes.len() as u32).filter(|&node| used[node as usize]).collect();
    order.sort_by_cached_key(|&node| curve.place(nodes[node as usize]));
    let mut numbers = vec![INSIDE; nodes.len()];
    for (number, &node) in (0..).zip(&order) {
        numbers[node as usize] = number;
    }
    elements.sort_by_cached_key(|triangle| {
        let corners = triangle.map(|node| nodes[node as usize]);
        curve.place([0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0))
    });
    for node in elements.iter_mut().flatten() {
        *node = numbers[*node as usize];
    }
    *nodes = order.iter().map(|&node| nodes[node as usize]).collect();
    *loops = order.iter().map(|&node| loops[node as usize]).collect();
    numbers
}

/// Hilbert's curve through a square around points.
struct Curve {
    origin: Point,
    per_length: f64,
}

impl Curve {
    /// Bits of a coordinate: 65,536 squares along an edge.
    const BITS: u32 = 16;

    fn around(points: &[Point]) -> Self {
        let bound = |axis: usize, of: fn(f64, f64) -> f64, from: f64| {
            points.iter().map(|point| point[axis]).fold(from, of)
        };
        let origin = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY));
        let size = [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY) - origin[axis]);
        Self { origin, per_length: f64::from(u16::MAX) / size[0].max(size[1]) }
    }

    /// Position of a point along the curve.
    fn place(&self, point: Point) -> u64 {
        let [x, y] = [0, 1].map(|axis| ((point[axis] - self.origin[axis]) * self.per_length) as u32);
        place([x, y], Self::BITS)
    }
}
