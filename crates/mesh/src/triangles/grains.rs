//! Voronoi grains: lines inside an outline that become edges of the mesh, and the grain of each element.

use std::collections::BTreeMap;

use fdem_scenes::random::Random;
use spade::handles::VoronoiVertex;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::error::OutlineError;
use super::mesh::Triangles;
use super::outline::{Domain, Inside, Point, distance, twice_area};
use crate::{Corners, facets_of, sorted};

/// Length over mesh size below which lines are removed, because they would give elements as small.
const SHORTEST: f64 = 0.6;

/// Sample points per grain by which points move to the middles of their cells.
const SAMPLES: f64 = 60.0;

/// Area of the bounding box of an outline over its own, at most.
const THINNEST: f64 = 1000.0;

/// Comparisons of boundaries of grains with edges of outlines, at most.
const COMPARISONS: usize = 5_000_000_000;

/// The points around which grains grow.
pub struct Grains {
    centres: Vec<Point>,
}

/// A point that knows its number.
#[derive(Clone, Copy)]
struct Seed {
    position: Point2<f64>,
    number: u32,
}

impl HasPosition for Seed {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

impl Grains {
    /// Random points inside of `domain`, moved `rounds` times to the middles of their cells.
    ///
    /// # Errors
    /// [`OutlineError`] about outlines without room for the grains.
    pub fn new(domain: &Domain, count: usize, seed: u64, rounds: u32) -> Result<Self, OutlineError> {
        let corners: usize = domain.loops.iter().map(Vec::len).sum();
        if count.saturating_mul(corners) > COMPARISONS {
            return Err(OutlineError::TooManyGrains { grains: count, edges: corners });
        }
        let inside = Inside::new(&domain.loops);
        let [low, high] = domain.bounds();
        let filled = domain.area() / (high[0] - low[0]) / (high[1] - low[1]);
        if filled.is_nan() || filled * THINNEST < 1.0 {
            return Err(OutlineError::TooThin);
        }
        let mut random = Random::with_stream(seed, 1);
        let mut centres = Vec::with_capacity(count);
        let mut left = 1000 * count as u64 + 1_000_000;
        while centres.len() < count {
            let point = [0, 1].map(|axis| random.between(low[axis], high[axis]));
            if inside.contains(point) {
                centres.push(point);
            }
            left -= 1;
            if left == 0 {
                return Err(OutlineError::NoRoom);
            }
        }
        let mut grains = Self { centres };
        for _ in 0..rounds {
            grains.even_out(domain, &inside)?;
        }
        Ok(grains)
    }

    fn triangulation(&self) -> Result<DelaunayTriangulation<Seed>, OutlineError> {
        let seeds =
            (0..).zip(&self.centres).map(|(number, &[x, y])| Seed { position: Point2::new(x, y), number });
        DelaunayTriangulation::bulk_load(seeds.collect())
            .map_err(|error| OutlineError::coordinates("grains", error))
    }

    /// Moves each centre to the mean of the points of a lattice that are nearest to it.
    fn even_out(&mut self, domain: &Domain, inside: &Inside) -> Result<(), OutlineError> {
        let [low, high] = domain.bounds();
        let pitch = (domain.area() / (SAMPLES * self.centres.len() as f64)).sqrt();
        let [columns, rows] = [0, 1].map(|axis| ((high[axis] - low[axis]) / pitch) as usize);
        let triangulation = self.triangulation()?;
        let mut sums = vec![[0.0; 3]; self.centres.len()];
        for row in 0..=rows {
            for column in 0..=columns {
                let point = [low[0] + (column as f64 + 0.5) * pitch, low[1] + (row as f64 + 0.5) * pitch];
                if !inside.contains(point) {
                    continue;
                }
                if let Some(nearest) = triangulation.nearest_neighbor(Point2::new(point[0], point[1])) {
                    let sum = &mut sums[nearest.data().number as usize];
                    sum[0] += 1.0;
                    sum[1] += point[0];
                    sum[2] += point[1];
                }
            }
        }
        for (centre, [weight, x, y]) in self.centres.iter_mut().zip(sums) {
            if weight > 0.0 {
                *centre = [x / weight, y / weight];
            }
        }
        Ok(())
    }

    /// Adds the boundaries of grains to the lines of `domain`, and their ends to its loops.
    ///
    /// # Errors
    /// [`OutlineError::Coordinates`].
    pub fn cut(&self, domain: &mut Domain, size: f64) -> Result<(), OutlineError> {
        let mut net = Net::default();
        net.clip(&self.edges(domain)?, domain);
        net.contract(SHORTEST * size, domain);
        net.hand_over(domain);
        Ok(())
    }

    /// Ends of Voronoi edges, each with the number of its vertex.
    fn edges(&self, domain: &Domain) -> Result<Vec<[(usize, Point); 2]>, OutlineError> {
        let [low, high] = domain.bounds();
        let middle = [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]));
        let far = 20.0 * distance(low, high);
        // Points far away close the cells at the outline. The boundaries of their cells are far outside.
        let mut seeds: Vec<Point> = self.centres.clone();
        for [x, y] in [
            [1.0, 0.1],
            [0.7, 0.8],
            [0.0, 1.0],
            [-0.8, 0.7],
            [-1.0, -0.1],
            [-0.7, -0.8],
            [0.0, -1.0],
            [0.8, -0.7],
        ] {
            seeds.push([middle[0] + far * x, middle[1] + far * y]);
        }
        let triangulation = Self { centres: seeds }.triangulation()?;
        let mut edges = Vec::new();
        for edge in triangulation.undirected_voronoi_edges() {
            let ends = edge.vertices().map(|vertex| match vertex {
                VoronoiVertex::Inner(face) => {
                    let at = face.circumcenter();
                    Some((face.fix().index(), [at.x, at.y]))
                }
                VoronoiVertex::Outer(_) => None,
            });
            if let [Some(a), Some(b)] = ends {
                edges.push([a, b]);
            }
        }
        Ok(edges)
    }

    /// The grain of each element: parts of the mesh between lines, by the centre that is nearest to the
    /// middle of their largest element.
    ///
    /// # Errors
    /// [`OutlineError::Coordinates`].
    pub fn of_elements(&self, mesh: &Triangles) -> Result<Vec<u32>, OutlineError> {
        let triangulation = self.triangulation()?;
        let part = parts(mesh);
        let mut largest: BTreeMap<u32, (f64, Point)> = BTreeMap::new();
        for (&part, triangle) in part.iter().zip(&mesh.elements) {
            let [a, b, c] = triangle.map(|node| mesh.nodes[node as usize]);
            let area = twice_area(a, b, c);
            let entry = largest.entry(part).or_insert((0.0, a));
            if area > entry.0 {
                *entry = (area, [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0));
            }
        }
        let grain = |point: Point| {
            triangulation
                .nearest_neighbor(Point2::new(point[0], point[1]))
                .map_or(0, |vertex| vertex.data().number)
        };
        let grains: BTreeMap<u32, u32> =
            largest.into_iter().map(|(part, (_, point))| (part, grain(point))).collect();
        Ok(part.iter().map(|part| grains[part]).collect())
    }
}

/// One of the given number of colours for each grain, so that neighbours have different ones where that is
/// possible, and each colour occurs about equally often.
pub fn colours<const D: usize, const N: usize>(
    elements: &[[u32; N]],
    grains: &[u32],
    colours: usize,
) -> Vec<u32>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let count = grains.iter().max().map_or(0, |&last| last as usize + 1);
    let mut facets: Vec<([u32; D], u32)> = Vec::with_capacity(N * elements.len());
    for (number, element) in (0..).zip(elements) {
        facets.extend(facets_of(element).map(|facet| (sorted(facet), number)));
    }
    facets.sort_unstable();
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); count];
    for pair in facets.windows(2) {
        let [a, b] = [pair[0].1, pair[1].1].map(|element| grains[element as usize]);
        if pair[0].0 == pair[1].0 && a != b {
            neighbours[a as usize].push(b);
            neighbours[b as usize].push(a);
        }
    }
    let mut taken: Vec<Option<u32>> = vec![None; count];
    let mut used = vec![0_usize; colours];
    for grain in 0..count {
        let mut clashes = vec![0_usize; colours];
        for &neighbour in &neighbours[grain] {
            if let Some(colour) = taken[neighbour as usize] {
                clashes[colour as usize] += 1;
            }
        }
        let best = (0..colours).min_by_key(|&colour| (clashes[colour], used[colour])).unwrap_or(0);
        used[best] += 1;
        taken[grain] = Some(best as u32);
    }
    taken.into_iter().map(|colour| colour.unwrap_or(0)).collect()
}

/// The edges of all elements, each with its element, sorted.
fn sorted_edges(mesh: &Triangles) -> Vec<([u32; 2], u32)> {
    let mut edges = Vec::with_capacity(3 * mesh.elements.len());
    for (element, &[a, b, c]) in (0..).zip(&mesh.elements) {
        edges.extend([[a, b], [b, c], [c, a]].map(|edge| (ordered(edge), element)));
    }
    edges.sort_unstable();
    edges
}

fn ordered([a, b]: [u32; 2]) -> [u32; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// Finds the parts of the mesh between lines. Each element gets the smallest number of an element of its
/// part.
fn parts(mesh: &Triangles) -> Vec<u32> {
    let mut lines: Vec<_> = mesh.lines.iter().map(|&edge| ordered(edge)).collect();
    lines.sort_unstable();
    let edges = sorted_edges(mesh);
    let mut part: Vec<u32> = (0..mesh.elements.len() as u32).collect();
    for pair in edges.windows(2) {
        if pair[0].0 == pair[1].0 && lines.binary_search(&pair[0].0).is_err() {
            let (a, b) = (root(&mut part, pair[0].1), root(&mut part, pair[1].1));
            part[a.max(b) as usize] = a.min(b);
        }
    }
    (0..part.len() as u32).map(|element| root(&mut part, element)).collect()
}

/// The root of a tree of numbers, whose path is shortened.
fn root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}

/// Freedom of a vertex of the net of lines.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
enum Freedom {
    /// Anywhere.
    Free,
    /// Along an edge of a loop: number of the loop, of the edge, and how far along it, 0 to 1.
    OnLoop(usize, usize, f64),
    /// Nowhere: it is a corner of a loop.
    Corner,
}

/// Lines between vertices.
#[derive(Default)]
struct Net {
    vertices: Vec<(Point, Freedom)>,
    lines: Vec<[u32; 2]>,
}

impl Net {
    /// Takes the parts of the edges that are inside.
    fn clip(&mut self, edges: &[[(usize, Point); 2]], domain: &Domain) {
        let inside = Inside::new(&domain.loops);
        let mut known: BTreeMap<usize, u32> = BTreeMap::new();
        for &[(first, a), (second, b)] in edges {
            let mut cuts = crossings(a, b, domain);
            cuts.sort_by(|one, other| one.0.total_cmp(&other.0));
            let mut last = (0.0, None);
            for (t, place) in cuts.into_iter().map(|(t, place)| (t, Some(place))).chain([(1.0, None)]) {
                let middle = along(a, b, f64::midpoint(last.0, t));
                if inside.contains(middle) {
                    let mut vertex = |t: f64, place: Option<Freedom>, number: usize, end: Point| match place {
                        Some(place) => self.add(along(a, b, t), place),
                        None => *known.entry(number).or_insert_with(|| {
                            self.vertices.push((end, Freedom::Free));
                            self.vertices.len() as u32 - 1
                        }),
                    };
                    let from = vertex(last.0, last.1, first, a);
                    let to = vertex(t, place, second, b);
                    self.lines.push([from, to]);
                }
                last = (t, place);
            }
        }
    }

    fn add(&mut self, point: Point, freedom: Freedom) -> u32 {
        self.vertices.push((point, freedom));
        self.vertices.len() as u32 - 1
    }

    /// Joins vertices that are nearer to each other, or to a corner, than `shortest`.
    fn contract(&mut self, shortest: f64, domain: &Domain) {
        for vertex in &mut self.vertices {
            if vertex.1 == Freedom::Free
                && let Some(place) = onto_outline(vertex.0, shortest, domain)
            {
                *vertex = place;
            }
            if let Freedom::OnLoop(number, edge, _) = vertex.1 {
                let corners = &domain.loops[number];
                let ends = [corners[edge], corners[(edge + 1) % corners.len()]];
                let nearest = if distance(vertex.0, ends[0]) <= distance(vertex.0, ends[1]) {
                    ends[0]
                } else {
                    ends[1]
                };
                if distance(vertex.0, nearest) < shortest {
                    *vertex = (nearest, Freedom::Corner);
                }
            }
        }
        let mut parent: Vec<u32> = (0..self.vertices.len() as u32).collect();
        for &[a, b] in &self.lines {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            let (one, other) = (self.vertices[a as usize], self.vertices[b as usize]);
            if a == b || distance(one.0, other.0) >= shortest {
                continue;
            }
            // The one that is less free stays where it is; two of the outline stay two.
            let (keep, drop) = match (one.1, other.1) {
                (Freedom::Free, Freedom::Free) => {
                    self.vertices[a as usize].0 = along(one.0, other.0, 0.5);
                    (a, b)
                }
                (Freedom::Free, _) => (b, a),
                (_, Freedom::Free) => (a, b),
                _ => continue,
            };
            parent[drop as usize] = keep;
        }
        self.join_on_loops(shortest, &mut parent);
        for line in &mut self.lines {
            *line = line.map(|vertex| root(&mut parent, vertex));
        }
    }

    /// Joins neighbours along an outline.
    fn join_on_loops(&mut self, shortest: f64, parent: &mut [u32]) {
        let mut places: Vec<(usize, usize, f64, u32)> = Vec::new();
        let mut corners: BTreeMap<[u64; 2], u32> = BTreeMap::new();
        for vertex in 0..self.vertices.len() as u32 {
            if root(parent, vertex) != vertex {
                continue;
            }
            let (point, freedom) = self.vertices[vertex as usize];
            match freedom {
                Freedom::OnLoop(number, edge, t) => places.push((number, edge, t, vertex)),
                Freedom::Corner => {
                    let first = *corners.entry(point.map(f64::to_bits)).or_insert(vertex);
                    parent[vertex as usize] = first;
                }
                Freedom::Free => {}
            }
        }
        places.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
        let mut last: Option<(usize, usize, u32)> = None;
        for (number, edge, _, vertex) in places {
            if let Some((_, _, before)) = last.filter(|&(n, e, _)| (n, e) == (number, edge)) {
                let near =
                    distance(self.vertices[before as usize].0, self.vertices[vertex as usize].0) < shortest;
                if near {
                    parent[vertex as usize] = before;
                    continue;
                }
            }
            last = Some((number, edge, vertex));
        }
    }

    /// Gives the lines to the domain, and the parts on an edge of a loop to that loop.
    fn hand_over(mut self, domain: &mut Domain) {
        for line in &mut self.lines {
            line.sort_unstable();
        }
        self.lines.sort_unstable();
        self.lines.dedup();
        self.lines.retain(|[a, b]| a != b);
        let mut added: Vec<(usize, usize, f64, u32)> = Vec::new();
        for &vertex in self.lines.iter().flatten() {
            if let Freedom::OnLoop(number, edge, t) = self.vertices[vertex as usize].1 {
                added.push((number, edge, t, vertex));
            }
        }
        // From the last to the first, so that the places before do not change.
        added.sort_by(|a, b| (b.0, b.1).cmp(&(a.0, a.1)).then(b.2.total_cmp(&a.2)).then(a.3.cmp(&b.3)));
        added.dedup();
        for (number, edge, _, vertex) in added {
            domain.loops[number].insert(edge + 1, self.vertices[vertex as usize].0);
        }
        // A line between two neighbours on the outline is an edge of it.
        let outline: Vec<[Point; 2]> = domain
            .loops
            .iter()
            .flat_map(|corners| (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]))
            .collect();
        let along_outline =
            |[a, b]: [Point; 2]| outline.iter().any(|&[p, q]| [p, q] == [a, b] || [q, p] == [a, b]);
        let lines = self.lines.iter().map(|line| line.map(|vertex| self.vertices[vertex as usize].0));
        domain.lines.extend(lines.filter(|&line| !along_outline(line)));
    }
}

/// The place on an outline that is nearest to a point, if it is nearer than `reach`.
fn onto_outline(point: Point, reach: f64, domain: &Domain) -> Option<(Point, Freedom)> {
    let mut nearest: Option<(f64, Point, Freedom)> = None;
    for (number, corners) in domain.loops.iter().enumerate() {
        for (edge, &p) in corners.iter().enumerate() {
            let q = corners[(edge + 1) % corners.len()];
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            let t = ((point[0] - p[0]) * dx + (point[1] - p[1]) * dy) / (dx * dx + dy * dy);
            let t = t.clamp(0.0, 1.0);
            let foot = along(p, q, t);
            let gap = distance(point, foot);
            if gap < nearest.map_or(reach, |(least, ..)| least) {
                nearest = Some((gap, foot, Freedom::OnLoop(number, edge, t)));
            }
        }
    }
    nearest.map(|(_, foot, freedom)| (foot, freedom))
}

fn along(a: Point, b: Point, t: f64) -> Point {
    [0, 1].map(|axis| a[axis] * (1.0 - t) + b[axis] * t)
}

/// Crossings of the line from `a` to `b` with edges of loops: the position along the line, and the place on
/// the edge.
fn crossings(a: Point, b: Point, domain: &Domain) -> Vec<(f64, Freedom)> {
    let mut found = Vec::new();
    for (number, corners) in domain.loops.iter().enumerate() {
        for (edge, &p) in corners.iter().enumerate() {
            let q = corners[(edge + 1) % corners.len()];
            let (side_a, side_b) = (twice_area(p, q, a), twice_area(p, q, b));
            let (side_p, side_q) = (twice_area(a, b, p), twice_area(a, b, q));
            if (side_a > 0.0) != (side_b > 0.0) && (side_p > 0.0) != (side_q > 0.0) {
                let t = side_a / (side_a - side_b);
                found.push((t, Freedom::OnLoop(number, edge, side_p / (side_p - side_q))));
            }
        }
    }
    found
}
