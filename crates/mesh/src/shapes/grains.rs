//! Bodies of grains.

mod cell;

use std::collections::BTreeMap;

use fdem_scenes::random::Random;

use super::hull::number_faces;
use crate::tetrahedra::vector::{Point, cross, distance, dot, length, minus, plus, times};
use crate::tetrahedra::{MeshError, OUTSIDE, Surface};
pub(super) use cell::{Behind, Cell};

/// Rounds in which seeds of grains move to the centres of their grains.
const ROUNDS: usize = 12;

/// Length of edges between grains over the cube root of the mean volume of a grain, below which they are
/// contracted. Halved where that would fold a surface.
const SHORT: f64 = 0.2;

/// Attempts with halved lengths.
const ATTEMPTS: usize = 6;

/// Distance over the size of the body below which points are one.
pub(super) const SAME: f64 = 1e-9;

/// Cuts a convex body into grains: the regions `0..count` of one surface, whose meshes share nodes.
///
/// The grains are the Voronoi cells of points that move to the centres of their cells. Short edges are
/// contracted, as they would need tiny elements. The faces of the body keep their numbers and names; each
/// face between two grains has a new number.
///
/// Angles of a mesh are good if it has about four elements across a grain. With fewer, some are as small as
/// 4°: contracted faces meet at sharp angles.
///
/// # Cost
/// Time grows with the square of `count`: about 0.5 s for 500 grains.
///
/// # Errors
/// [`MeshError::NotConvex`]; [`MeshError::Empty`] if `count` is 0; errors of [`Surface::check`].
///
/// # Source
/// Q. Du, V. Faber, M. Gunzburger, "Centroidal Voronoi tessellations", SIAM Review 41 (1999); R. Quey, P. R.
/// Dawson, F. Barbe, "Large-scale 3D random polycrystals for the finite element method", Comput. Methods
/// Appl. Mech. Engng 200 (2011), for the contraction of short edges.
pub fn grains(body: &Surface, count: usize, seed: u64) -> Result<Surface, MeshError> {
    body.check()?;
    if count == 0 {
        return Err(MeshError::Empty);
    }
    let whole = convex(body)?;
    let size = whole.reach(whole.points[0]);
    let seeds = spread(&whole, count, ROUNDS, seed);
    let cells: Vec<Cell> = (0..count).map(|grain| cell_of(&whole, &seeds, grain)).collect();
    let mean = libm::cbrt(cells.iter().map(Cell::volume).sum::<f64>() / count as f64);
    let complex = Complex::new(body, &whole, &cells, SAME * size);
    with_lengths(SHORT * mean, &|short| complex.contracted(short))
}

/// The first surface that can be meshed, of those made with a length below which edges are contracted, with
/// half of it, and so on.
pub(super) fn with_lengths(
    short: f64,
    make: &dyn Fn(f64) -> Result<Surface, MeshError>,
) -> Result<Surface, MeshError> {
    let mut last = MeshError::Empty;
    let halved = (0..ATTEMPTS).scan(short, |short, _| {
        let now = *short;
        *short *= 0.5;
        Some(now)
    });
    for short in halved.chain([0.0]) {
        match make(short).and_then(|surface| surface.check().map(|()| surface)) {
            Ok(surface) => return Ok(surface),
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Points of a body after the given number of moves to the centres of their Voronoi cells.
pub(super) fn spread(whole: &Cell, count: usize, rounds: usize, seed: u64) -> Vec<Point> {
    let mut random = Random::new(seed);
    let mut seeds = Vec::with_capacity(count);
    let (low, high) = crate::tetrahedra::bounds(&whole.points);
    while seeds.len() < count {
        let point = [0, 1, 2].map(|axis| random.between(low[axis], high[axis]));
        if whole.contains(point) {
            seeds.push(point);
        }
    }
    for _ in 0..rounds {
        seeds = (0..count).map(|grain| cell_of(whole, &seeds, grain).centre()).collect();
    }
    seeds
}

/// A convex body with one polygon for all facets in a plane; facets of a polygon are of one face.
pub(super) fn convex(body: &Surface) -> Result<Cell, MeshError> {
    let size = distance_across(&body.nodes);
    for facet in 0..body.facets.len() {
        let [a, b, c] = body.corners(facet);
        let normal = cross(minus(b, a), minus(c, a));
        let above = SAME * size * length(normal);
        if body.nodes.iter().any(|&node| dot(normal, minus(node, a)) > above) {
            return Err(MeshError::NotConvex { facet });
        }
    }
    let mut planes = body.clone();
    number_faces(&mut planes, SAME);
    let count = planes.faces.iter().max().map_or(0, |most| most + 1);
    let mut edges: Vec<(u32, [u32; 2])> = Vec::new();
    for (facet, &plane) in planes.facets.iter().zip(&planes.faces) {
        edges.extend((0..3).map(|k| (plane, [facet[k], facet[(k + 1) % 3]])));
    }
    edges.sort_unstable();
    let mut faces = Vec::new();
    for plane in 0..count {
        // Edges of the plane that are not run through in the other direction are its outline.
        let outline: BTreeMap<u32, u32> = edges
            .iter()
            .filter(|&&(of, [a, b])| of == plane && edges.binary_search(&(plane, [b, a])).is_err())
            .map(|&(_, [a, b])| (a, b))
            .collect();
        let Some((&first, _)) = outline.iter().next() else { continue };
        let mut polygon = vec![first];
        while let Some(&node) = polygon.last().and_then(|last| outline.get(last)) {
            if node == first || polygon.len() > outline.len() {
                break;
            }
            polygon.push(node);
        }
        faces.push((Behind::Body(plane), polygon));
    }
    Ok(Cell { points: body.nodes.clone(), faces })
}

fn distance_across(points: &[Point]) -> f64 {
    let (low, high) = crate::tetrahedra::bounds(points);
    distance(low, high)
}

/// The Voronoi cell of a seed.
pub(super) fn cell_of(whole: &Cell, seeds: &[Point], grain: usize) -> Cell {
    let here = seeds[grain];
    let mut others: Vec<(f64, usize)> = (0..seeds.len())
        .filter(|&other| other != grain)
        .map(|other| (distance(here, seeds[other]), other))
        .collect();
    others.sort_unstable_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    let mut cell = whole.clone();
    for (far, other) in others {
        // Seeds twice as far away as the farthest corner cut nothing.
        if far > 2.0 * cell.reach(here) {
            break;
        }
        let middle = times(plus(here, seeds[other]), 0.5);
        cell.cut(minus(seeds[other], here), middle, Behind::Grain(other as u32));
    }
    cell
}

/// Polygons between grains and on the body, with common corners.
struct Complex {
    points: Vec<Point>,
    /// Planes of the body that each point is in.
    on: Vec<Vec<u32>>,
    /// Corners counter-clockwise seen from before, the regions behind and before, and the face.
    polygons: Vec<(Vec<u32>, [u32; 2], u32)>,
    names: Vec<String>,
}

impl Complex {
    fn new(body: &Surface, whole: &Cell, cells: &[Cell], same: f64) -> Self {
        let all: Vec<Point> = cells.iter().flat_map(|cell| cell.points.iter().copied()).collect();
        let (points, numbers) = merge(&all, same);
        let mut on = vec![Vec::new(); points.len()];
        let mut planes = body.clone();
        number_faces(&mut planes, SAME);
        let mut face_of = vec![0; whole.faces.len()];
        for (&plane, &face) in planes.faces.iter().zip(&body.faces) {
            face_of[plane as usize] = face;
        }
        let mut next = body.faces.iter().max().map_or(0, |most| most + 1);
        let mut polygons = Vec::new();
        let mut first = 0;
        for (grain, cell) in (0..).zip(cells) {
            for (behind, polygon) in &cell.faces {
                let corners: Vec<u32> = polygon.iter().map(|&node| numbers[first + node as usize]).collect();
                match *behind {
                    Behind::Body(plane) => {
                        for &corner in &corners {
                            on[corner as usize].push(plane);
                        }
                        polygons.push((corners, [grain, OUTSIDE], face_of[plane as usize]));
                    }
                    Behind::Grain(other) if grain < other => {
                        polygons.push((corners, [grain, other], next));
                        next += 1;
                    }
                    Behind::Grain(_) => {}
                }
            }
            first += cell.points.len();
        }
        for planes in &mut on {
            planes.sort_unstable();
            planes.dedup();
        }
        Self { points, on, polygons, names: body.names.clone() }
    }

    /// The surface whose edges shorter than a length are contracted, shortest first. Corners, edges and faces
    /// of the body stay where they are.
    fn contracted(&self, short: f64) -> Result<Surface, MeshError> {
        let outlines = self.polygons.iter().map(|(corners, _, _)| &corners[..]);
        let (points, to) = contract(&self.points, &self.on, outlines, short, &|middle, _| middle);
        let mut surface = Surface { nodes: points, names: self.names.clone(), ..Surface::default() };
        for (corners, sides, face) in &self.polygons {
            let mut polygon: Vec<u32> = corners.iter().map(|&corner| to[corner as usize]).collect();
            polygon.dedup();
            while polygon.len() > 1 && polygon.first() == polygon.last() {
                polygon.pop();
            }
            if polygon.len() < 3 {
                continue;
            }
            for facet in cut(&surface.nodes, polygon)? {
                surface.facets.push(facet);
                surface.sides.push(*sides);
                surface.faces.push(*face);
            }
        }
        leave_out_unused(&mut surface);
        Ok(surface)
    }
}

/// Contracts edges of polygons that are shorter than a length, shortest first. Returns where points are now,
/// and which point each has become.
///
/// A point becomes one that is in all of its planes. If two points are in the same planes, `middle` has the
/// place between them, and one of them.
pub(super) fn contract<'a>(
    points: &[Point],
    on: &[Vec<u32>],
    polygons: impl Iterator<Item = &'a [u32]>,
    short: f64,
    middle: &dyn Fn(Point, u32) -> Point,
) -> (Vec<Point>, Vec<u32>) {
    let mut to: Vec<u32> = (0..points.len() as u32).collect();
    let (mut points, mut on) = (points.to_vec(), on.to_vec());
    let root = |to: &[u32], mut node: u32| {
        while to[node as usize] != node {
            node = to[node as usize];
        }
        node
    };
    let mut edges: Vec<(f64, u32, u32)> = Vec::new();
    for corners in polygons {
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            let span = distance(points[a as usize], points[b as usize]);
            if span < short {
                edges.push((span, a.min(b), a.max(b)));
            }
        }
    }
    edges.sort_unstable_by(|one, other| {
        one.0.total_cmp(&other.0).then((one.1, one.2).cmp(&(other.1, other.2)))
    });
    for (_, a, b) in edges {
        let (a, b) = (root(&to, a), root(&to, b));
        if a == b || distance(points[a as usize], points[b as usize]) >= short {
            continue;
        }
        let within =
            |one: u32, other: u32| on[one as usize].iter().all(|plane| on[other as usize].contains(plane));
        let (kept, gone) = match (within(a, b), within(b, a)) {
            (true, true) => {
                points[a as usize] = middle(times(plus(points[a as usize], points[b as usize]), 0.5), a);
                (a, b)
            }
            (true, false) => (b, a),
            (false, true) => (a, b),
            (false, false) => continue,
        };
        to[gone as usize] = kept;
        on[gone as usize].clear();
    }
    let to = (0..points.len() as u32).map(|node| root(&to, node)).collect();
    (points, to)
}

/// Leaves out nodes without facets.
pub(super) fn leave_out_unused(surface: &mut Surface) {
    let mut used: Vec<u32> = surface.facets.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    for node in surface.facets.iter_mut().flatten() {
        *node = used.binary_search(node).unwrap_or(0) as u32;
    }
    surface.nodes = used.iter().map(|&node| surface.nodes[node as usize]).collect();
}

/// Cuts a polygon that is nearly flat and nearly convex into triangles, ear by ear: that with the largest
/// smallest angle first.
pub(super) fn cut(points: &[Point], mut polygon: Vec<u32>) -> Result<Vec<[u32; 3]>, MeshError> {
    let at = |node: u32| points[node as usize];
    let origin = at(polygon[0]);
    let normal = (0..polygon.len())
        .map(|k| cross(minus(at(polygon[k]), origin), minus(at(polygon[(k + 1) % polygon.len()]), origin)))
        .fold([0.0; 3], plus);
    // Sine of the smallest angle; negative if the ear is turned over.
    let angle = |[a, b, c]: [u32; 3]| {
        let (u, v, w) = (minus(at(b), at(a)), minus(at(c), at(b)), minus(at(a), at(c)));
        let area = dot(cross(u, v), normal) / length(normal);
        let [u, v, w] = [u, v, w].map(length);
        area / (u * v).max(v * w).max(w * u)
    };
    let mut triangles = Vec::new();
    while polygon.len() >= 3 {
        let count = polygon.len();
        let ear = |k: usize| [polygon[(k + count - 1) % count], polygon[k], polygon[(k + 1) % count]];
        // The last triangle but one decides about the last too.
        let value = |k: usize| {
            let rest = (count == 4).then(|| ear((k + 2) % count));
            angle(ear(k)).min(rest.map_or(f64::INFINITY, &angle))
        };
        let best = (0..count).fold(0, |best, k| if value(k) > value(best) { k } else { best });
        if value(best).is_nan() || value(best) <= 1e-6 {
            return Err(MeshError::Degenerate { facet: triangles.len(), place: origin });
        }
        triangles.push(ear(best));
        polygon.remove(best);
        if count == 3 {
            break;
        }
    }
    Ok(triangles)
}

/// Points of which none are nearer to each other than `same`, and which of them each point is.
pub(super) fn merge(all: &[Point], same: f64) -> (Vec<Point>, Vec<u32>) {
    let mut order: Vec<u32> = (0..all.len() as u32).collect();
    order.sort_unstable_by(|&one, &other| {
        all[one as usize][0].total_cmp(&all[other as usize][0]).then(one.cmp(&other))
    });
    let mut points: Vec<Point> = Vec::new();
    let mut numbers = vec![0; all.len()];
    for &node in &order {
        let point = all[node as usize];
        let near = points.iter().enumerate().rev().take_while(|(_, known)| point[0] - known[0] <= 2.0 * same);
        let found =
            near.into_iter().find(|(_, known)| distance(**known, point) <= same).map(|(number, _)| number);
        numbers[node as usize] = found.unwrap_or(points.len()) as u32;
        if found.is_none() {
            points.push(point);
        }
    }
    (points, numbers)
}
