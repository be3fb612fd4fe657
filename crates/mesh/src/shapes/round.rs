//! Cylinders, tubes and spheres.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use fdem_scenes::random::Random;

use crate::tetrahedra::delaunay::{Delaunay, FACETS, GHOST};
use crate::tetrahedra::order;
use crate::tetrahedra::plane::Plane;
use crate::tetrahedra::vector::{
    Point, circle, cross, distance, dot, in_ball, length, minus, plus, times, unit,
};
use crate::tetrahedra::{FLAT, MOST, MeshError, OUTSIDE, Size, Surface, finite, positive};

/// Fewest edges around a circle.
const FEWEST: usize = 8;

/// A cylinder between the centres of its two ends.
///
/// The ends are polygons with corners on the circle; the mantle's facets have their corners on the mantle.
/// Faces: `bottom` (around `from`), `top`, `mantle`.
///
/// # Errors
/// [`MeshError::NotFinite`], [`MeshError::Length`], [`MeshError::Size`], [`MeshError::TooMany`].
pub fn cylinder(
    from: [f64; 3],
    to: [f64; 3],
    radius: f64,
    size: &Size<'_>,
    seed: u64,
) -> Result<Surface, MeshError> {
    let axis = Axis::new(from, to)?;
    positive(radius)?;
    let mut surface =
        Surface { names: ["bottom", "top", "mantle"].map(str::to_owned).to_vec(), ..Surface::default() };
    let [low, high] = mantle(&mut surface, &axis, radius, size, &mut Random::new(seed), 2)?;
    for (face, rim) in [(0, low), (1, high)] {
        for k in 1..rim.len() - 1 {
            let facet = [rim[0], rim[k], rim[k + 1]];
            push(&mut surface, if face == 0 { [facet[0], facet[2], facet[1]] } else { facet }, face);
        }
    }
    Ok(surface)
}

/// A cylinder with a hole along its axis.
///
/// Faces: `bottom` (around `from`), `top`, `mantle`, `inner mantle`.
///
/// # Errors
/// As [`cylinder`]; [`MeshError::Length`] if `inner` is not less than `outer`; [`MeshError::Thin`] if the
/// size is above 12 times the thickness of the wall.
pub fn tube(
    from: [f64; 3],
    to: [f64; 3],
    inner: f64,
    outer: f64,
    size: &Size<'_>,
    seed: u64,
) -> Result<Surface, MeshError> {
    let axis = Axis::new(from, to)?;
    positive(inner)?;
    positive(outer)?;
    positive(outer - inner)?;
    let names = ["bottom", "top", "mantle", "inner mantle"].map(str::to_owned).to_vec();
    let mut surface = Surface { names, ..Surface::default() };
    let mut random = Random::new(seed);
    let wall = outer - inner;
    let middle = times(plus(from, to), 0.5);
    let largest = size(middle).min(distance(from, to)).min(TAU * outer);
    if largest > FLAT * wall {
        return Err(MeshError::Thin { region: 0, thickness: wall, size: largest });
    }
    // Edges are no longer than the wall is thick.
    let thin = move |place: Point| at_most(size(place), 1.2 * wall);
    let outside = mantle(&mut surface, &axis, outer, &thin, &mut random, 2)?;
    let first = surface.facets.len();
    let inside = mantle(&mut surface, &axis, inner, &thin, &mut random, 3)?;
    for facet in &mut surface.facets[first..] {
        facet.swap(1, 2);
    }
    for (face, (outside, inside)) in (0..).zip(outside.iter().zip(&inside)) {
        let [angles, others] = [outside, inside].map(|rim| {
            rim.iter().map(|&node| axis.angle(surface.nodes[node as usize])).collect::<Vec<f64>>()
        });
        for facet in zip(&others, &angles) {
            let facet = facet.map(|k| if k < inside.len() { inside[k] } else { outside[k - inside.len()] });
            push(&mut surface, if face == 0 { facet } else { [facet[0], facet[2], facet[1]] }, face);
        }
    }
    Ok(surface)
}

fn push(surface: &mut Surface, facet: [u32; 3], face: u32) {
    surface.facets.push(facet);
    surface.faces.push(face);
    surface.sides.push([0, OUTSIDE]);
}

/// The axis of a cylinder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) from: Point,
    pub(super) to: Point,
    /// Two directions across.
    across: [Point; 2],
}

impl Axis {
    pub(super) fn new(from: Point, to: Point) -> Result<Self, MeshError> {
        finite(&[from, to])?;
        let along = minus(to, from);
        positive(length(along))?;
        // Along the axes of coordinates, exactly, if the cylinder is.
        Ok(Self { from, to, across: square_axes(along) })
    }

    /// A point at an angle and at a part of the length.
    pub(super) fn place(&self, radius: f64, angle: f64, part: f64) -> Point {
        let centre = [0, 1, 2].map(|k| {
            if part >= 1.0 { self.to[k] } else { self.from[k] + part * (self.to[k] - self.from[k]) }
        });
        let (sine, cosine) = libm::sincos(angle);
        let [u, v] = self.across;
        plus(centre, plus(times(u, radius * cosine), times(v, radius * sine)))
    }

    /// The angle of a point, in turns of 2π.
    pub(super) fn angle(&self, point: Point) -> f64 {
        let [x, y] = self.across.map(|axis| dot(axis, minus(point, self.from)));
        let angle = libm::atan2(y, x);
        if angle < 0.0 { angle + TAU } else { angle }
    }
}

/// Two directions of length 1, square to each other and to a vector: seen from its tip, the second is
/// counter-clockwise of the first.
pub(super) fn square_axes(along: Point) -> [Point; 2] {
    let least = (0..3).fold(0, |least, k| if along[k].abs() < along[least].abs() { k } else { least });
    let mut one = [0.0; 3];
    one[least] = 1.0;
    let one = unit(minus(one, times(along, dot(one, along) / dot(along, along))));
    [one, cross(unit(along), one)]
}

/// Adds the mantle of a cylinder, seen from outside. Returns the nodes of both rims, in order of their
/// angles.
fn mantle(
    surface: &mut Surface,
    axis: &Axis,
    radius: f64,
    size: &Size<'_>,
    random: &mut Random,
    face: u32,
) -> Result<[Vec<u32>; 2], MeshError> {
    let around = TAU * radius;
    let long = distance(axis.from, axis.to);
    let limited = |place: Point| at_most(size(place), around / FEWEST as f64);
    let rims = [
        ring(&|angle| limited(axis.place(radius, angle, 0.0)), radius)?,
        ring(&|angle| limited(axis.place(radius, angle, 1.0)), radius)?,
    ];
    // Rows of few points between the rims keep all triangles narrow: a triangle around half of the cylinder
    // has no place in the plane.
    let rows = (long / (around / FEWEST as f64)).round().max(1.0);
    // At least four elements are at a facet in the end.
    let elements = 4.0 * 2.0 * FEWEST as f64 * rows;
    if elements > MOST as f64 {
        return Err(MeshError::Slender { radius, length: long, elements });
    }
    let rows = rows as usize;
    let mut rings: Vec<(f64, Vec<f64>)> = vec![(0.0, rims[0].clone())];
    for row in 1..rows {
        let (phase, shift) = (random.uniform(), random.between(-0.2, 0.2));
        let angles = (0..FEWEST).map(|k| (k as f64 + phase) * TAU / FEWEST as f64).collect();
        rings.push(((row as f64 + shift) / rows as f64, angles));
    }
    rings.push((1.0, rims[1].clone()));
    // The rims come first.
    let counts: Vec<usize> = rings.iter().map(|(_, angles)| angles.len()).collect();
    let fixed = counts[0] + counts[rows];
    let mut first = vec![0; rows + 1];
    first[rows] = counts[0];
    for row in 1..rows {
        first[row] = if row == 1 { fixed } else { first[row - 1] + counts[row - 1] };
    }
    let mut points = vec![[0.0; 2]; counts.iter().sum()];
    for (row, (part, angles)) in rings.iter().enumerate() {
        for (k, angle) in angles.iter().enumerate() {
            points[first[row] + k] = [angle * radius, part * long];
        }
    }
    let mut triangles = Vec::new();
    for row in 0..rows {
        let (below, above) = (&rings[row].1, &rings[row + 1].1);
        triangles.extend(zip(below, above).into_iter().map(|facet| {
            facet.map(|k| {
                let global = if k < below.len() { first[row] + k } else { first[row + 1] + k - below.len() };
                global as u32
            })
        }));
    }
    let mut plane = Plane::new(points, triangles, around);
    plane.fill(fixed, &|[x, y]| limited(axis.place(radius, x / radius, y / long)), random);
    let start = surface.nodes.len() as u32;
    for (k, &[x, y]) in plane.points.iter().enumerate() {
        let part = if k < counts[0] {
            0.0
        } else if k < fixed {
            1.0
        } else {
            y / long
        };
        surface.nodes.push(axis.place(radius, x / radius, part));
    }
    for triangle in plane.triangles {
        push(surface, triangle.map(|node| node + start), face);
    }
    let rim = |first: usize, count: usize| (first..first + count).map(|k| k as u32 + start).collect();
    Ok([rim(0, counts[0]), rim(counts[0], counts[rows])])
}

/// Angles around a circle, at distances as long as the size says, from 0 on.
fn ring(size: &dyn Fn(f64) -> f64, radius: f64) -> Result<Vec<f64>, MeshError> {
    const STEPS: usize = 4096;
    let mut sums = vec![0.0];
    for step in 0..STEPS {
        let here = size((step as f64 + 0.5) * TAU / STEPS as f64);
        if here.is_nan() || here <= 0.0 {
            return Err(MeshError::Length { length: here });
        }
        sums.push(sums[step] + radius * TAU / STEPS as f64 / here);
    }
    // Rounding does not add an edge.
    let count = (sums[STEPS] - 1e-9).ceil().max(FEWEST as f64);
    if count > MOST as f64 {
        return Err(MeshError::TooMany { elements: count });
    }
    let count = count as usize;
    let mut step = 0;
    let angles = (0..count).map(|k| {
        let wanted = sums[STEPS] * k as f64 / count as f64;
        while step + 1 < STEPS && sums[step + 1] <= wanted {
            step += 1;
        }
        (step as f64 + (wanted - sums[step]) / (sums[step + 1] - sums[step])) * TAU / STEPS as f64
    });
    Ok(angles.collect())
}

/// Triangles between two rings of angles in order, counter-clockwise if the second is above the first:
/// numbers of the second follow those of the first.
fn zip(below: &[f64], above: &[f64]) -> Vec<[usize; 3]> {
    let (n, m) = (below.len(), above.len());
    // Angle of a point, counted on over the turns.
    let angle = |ring: &[f64], k: usize| ring[k % ring.len()] + TAU * (k / ring.len()) as f64;
    // The point above that is nearest to the first below.
    let turn = |difference: f64| (difference - TAU * (difference / TAU).round()).abs();
    let start =
        (0..m).min_by(|&i, &j| turn(above[i] - below[0]).total_cmp(&turn(above[j] - below[0]))).unwrap_or(0);
    let shift = TAU * ((above[start] - below[0]) / TAU).round();
    let (mut i, mut j) = (0, start);
    let mut triangles = Vec::with_capacity(n + m);
    while i < n || j < start + m {
        let (next, other) = (angle(below, i + 1), angle(above, j + 1) - shift);
        if j == start + m || (i < n && next <= other) {
            triangles.push([i % n, (i + 1) % n, n + j % m]);
            i += 1;
        } else {
            triangles.push([i % n, n + (j + 1) % m, n + j % m]);
            j += 1;
        }
    }
    triangles
}

/// The smaller of two numbers; NaN if the size is NaN.
fn at_most(size: f64, most: f64) -> f64 {
    if size > most { most } else { size }
}

/// A sphere: all nodes are on it.
///
/// Points are spread over the sphere, moved until the triangles are even, and joined by their convex hull.
/// Face: `surface`.
///
/// # Errors
/// [`MeshError::NotFinite`], [`MeshError::Length`], [`MeshError::Size`], [`MeshError::TooMany`].
pub fn sphere(centre: [f64; 3], radius: f64, size: &Size<'_>, seed: u64) -> Result<Surface, MeshError> {
    finite(&[centre])?;
    positive(radius)?;
    let mut random = Random::new(seed);
    // In units of the radius. No edge is longer than those of an icosahedron.
    let at = |direction: Point| at_most(size(plus(centre, times(direction, radius))) / radius, 1.0);
    let mut points = start(&mut random);
    if let Some(&point) = points[1..].iter().find(|&&point| at(point).is_nan() || at(point) <= 0.0) {
        return Err(MeshError::Size { place: plus(centre, times(point, radius)) });
    }
    let least = points[1..].iter().map(|&point| at(point)).fold(f64::INFINITY, f64::min);
    if 15.0 / least / least > MOST as f64 {
        return Err(MeshError::TooMany { elements: 15.0 / least / least });
    }
    let mut mesh =
        Delaunay::new(&points, &(0..points.len() as u32).collect::<Vec<_>>()).ok_or(MeshError::Flat)?;
    refine(&mut mesh, &mut points, &at, &mut random)?;
    let order = order::rounds(&order::along_curve(&points));
    let mut order: Vec<u32> = order.into_iter().filter(|&node| node != 0).collect();
    order.insert(0, 0);
    for _ in 0..8 {
        spread(&mesh, &mut points, &at);
        mesh = Delaunay::new(&points, &order).ok_or(MeshError::Flat)?;
    }
    let facets: Vec<[u32; 3]> = hull_of(&mesh).map(|facet| facet.map(|node| node - 1)).collect();
    let count = facets.len();
    let nodes = points[1..].iter().map(|&point| plus(centre, times(point, radius))).collect();
    let names = vec!["surface".to_owned()];
    Ok(Surface { nodes, facets, faces: vec![0; count], sides: vec![[0, OUTSIDE]; count], names })
}

/// The middle, and the corners of an icosahedron that is turned at random.
fn start(random: &mut Random) -> Vec<Point> {
    let (one, other) = (unit(in_ball(random)), in_ball(random));
    let two = unit(cross(one, other));
    let axes = [one, two, cross(one, two)];
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut points = vec![[0.0; 3]];
    for axis in 0..3 {
        for (x, y) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
            let sum = plus(times(axes[axis], x), times(axes[(axis + 1) % 3], y));
            points.push(unit(sum));
        }
    }
    points
}

/// The facets of the convex hull, counter-clockwise seen from outside.
pub(crate) fn hull_of(mesh: &Delaunay) -> impl Iterator<Item = [u32; 3]> {
    mesh.corners.iter().enumerate().filter(|&(t, _)| mesh.is_used(t)).filter_map(|(_, corners)| {
        let ghost = corners.iter().position(|&corner| corner == GHOST)?;
        // Seen from the solid, the facet of the ghost is the other way round.
        let [a, b, c] = FACETS[ghost].map(|k| corners[k]);
        Some([a, c, b])
    })
}

/// Inserts points above facets that are too large, first found first.
fn refine(
    mesh: &mut Delaunay,
    points: &mut Vec<Point>,
    size: &dyn Fn(Point) -> f64,
    random: &mut Random,
) -> Result<(), MeshError> {
    const COARSE: f64 = 0.72;
    let large = |mesh: &Delaunay, points: &[Point], t: usize| {
        let ghost = mesh.corners[t].iter().position(|&corner| corner == GHOST)?;
        let [a, b, c] = FACETS[ghost].map(|k| points[mesh.corners[t][k] as usize]);
        let (centre, square) = circle(a, b, c)?;
        let limit = COARSE * size(unit(centre));
        (square > limit * limit).then_some((centre, square))
    };
    let mut open: VecDeque<u32> = (0..mesh.corners.len() as u32).collect();
    while let Some(t) = open.pop_front() {
        if !mesh.is_used(t as usize) {
            continue;
        }
        let Some((centre, square)) = large(mesh, points, t as usize) else { continue };
        let point = unit(plus(centre, times(in_ball(random), 0.2 * square.sqrt())));
        let vertex = points.len() as u32;
        if !mesh.takes(points, t as usize, point, vertex) {
            continue;
        }
        mesh.find_gap(points, point, vertex, t, false);
        points.push(point);
        mesh.fill_gap(vertex);
        open.extend(&mesh.made);
        if points.len() > MOST {
            return Err(MeshError::TooMany { elements: points.len() as f64 });
        }
    }
    Ok(())
}

/// Moves each point to the mean of the centres of the circles around it, weighted by area over the square of
/// the size there.
fn spread(mesh: &Delaunay, points: &mut [Point], size: &dyn Fn(Point) -> f64) {
    let mut sums = vec![[0.0; 3]; points.len()];
    for facet in hull_of(mesh) {
        let [a, b, c] = facet.map(|node| points[node as usize]);
        let Some((centre, _)) = circle(a, b, c) else { continue };
        let local = size(unit(centre));
        let weight = length(cross(minus(b, a), minus(c, a))) / (local * local);
        for node in facet {
            sums[node as usize] = plus(sums[node as usize], times(unit(centre), weight));
        }
    }
    for (point, sum) in points.iter_mut().zip(sums).skip(1) {
        *point = unit(sum);
    }
}
