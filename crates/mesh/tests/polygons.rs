//! Polygons in bodies become facets of meshes:
//! - facets lie on their polygons, their areas sum up to those that are clipped to the body;
//! - blocks between polygons, and polygons that end inside;
//! - what nearly coincides becomes one;
//! - many polygons at random: every mesh is right, or there is an error;
//! - what is refused.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::collections::BTreeMap;

use fdem_mesh::shapes::{cuboid, extrusion, hull};
use fdem_mesh::tetrahedra::{PolygonError, Surface, Tetrahedra, add_polygons, graded};
use fdem_mesh::{Grading, Simplex, facets_of, sorted};
use fdem_scenes::random::Random;

type Point = [f64; 3];

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn plus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn times(a: Point, factor: f64) -> Point {
    a.map(|x| factor * x)
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: Point) -> Point {
    times(a, 1.0 / dot(a, a).sqrt())
}

/// A polygon of `count` corners around a centre, across a normal.
fn disc(centre: Point, normal: Point, radius: f64, count: usize) -> Vec<Point> {
    let normal = unit(normal);
    let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap();
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let u = unit(cross(normal, axis));
    let v = cross(normal, u);
    (0..count)
        .map(|k| {
            let (sine, cosine) = (std::f64::consts::TAU * (k as f64 + 0.5) / count as f64).sin_cos();
            plus(centre, plus(times(u, radius * cosine), times(v, radius * sine)))
        })
        .collect()
}

/// A square that is far larger than the bodies here.
fn plane(through: Point, normal: Point) -> Vec<Point> {
    disc(through, normal, 9.0, 4)
}

fn area([a, b, c]: [Point; 3]) -> f64 {
    let n = cross(minus(b, a), minus(c, a));
    0.5 * dot(n, n).sqrt()
}

fn volume(surface: &Surface) -> f64 {
    let facets = surface.facets.iter().zip(&surface.sides).filter(|(_, sides)| sides[0] != sides[1]);
    facets
        .map(|(facet, _)| {
            let [a, b, c] = facet.map(|node| surface.nodes[node as usize]);
            dot(a, cross(b, c)) / 6.0
        })
        .sum()
}

/// What is measured of a mesh.
struct Found {
    mesh: Tetrahedra,
    /// Smallest angle between facets, degrees.
    angle: f64,
    /// Area of the facets of each polygon.
    areas: Vec<f64>,
    /// Largest distance of one of their corners from the plane of its polygon.
    off: f64,
    /// Shortest edge.
    shortest: f64,
}

impl Found {
    /// Number of parts that the polygons cut off from each other, with their volumes.
    fn blocks(&self) -> Vec<f64> {
        let mesh = &self.mesh;
        let mut walls: Vec<[u32; 3]> = mesh.inner.iter().copied().map(sorted).collect();
        walls.sort_unstable();
        let mut sides: BTreeMap<[u32; 3], Vec<usize>> = BTreeMap::new();
        for (number, element) in mesh.elements.iter().enumerate() {
            for facet in facets_of::<3, 4>(element).map(sorted) {
                sides.entry(facet).or_default().push(number);
            }
        }
        let mut parent: Vec<usize> = (0..mesh.elements.len()).collect();
        fn root(parent: &mut [usize], mut at: usize) -> usize {
            while parent[at] != at {
                parent[at] = parent[parent[at]];
                at = parent[at];
            }
            at
        }
        for (facet, sides) in &sides {
            if sides.len() == 2 && walls.binary_search(facet).is_err() {
                let (a, b) = (root(&mut parent, sides[0]), root(&mut parent, sides[1]));
                parent[a.max(b)] = a.min(b);
            }
        }
        let mut volumes: BTreeMap<usize, f64> = BTreeMap::new();
        for (number, element) in mesh.elements.iter().enumerate() {
            let of = root(&mut parent, number);
            *volumes.entry(of).or_default() += element.map(|node| mesh.nodes[node as usize]).measure();
        }
        let mut volumes: Vec<f64> = volumes.into_values().collect();
        volumes.sort_by(f64::total_cmp);
        volumes
    }
}

/// Meshes a body with polygons in it, and checks all that holds for every mesh.
fn meshed(surface: &Surface, polygons: &[Vec<Point>], size: f64, seed: u64) -> Result<Found, PolygonError> {
    let size = Grading::even(size);
    let mut cut = surface.clone();
    let first = add_polygons(&mut cut, polygons, &size)?;
    let mesh = graded(&cut, &size, seed).unwrap();
    let corners = |nodes: &[u32; 4]| nodes.map(|node| mesh.nodes[node as usize]);
    let mut sum = 0.0;
    let (mut angle, mut shortest) = (180.0_f64, f64::INFINITY);
    let mut sides: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    for element in &mesh.elements {
        let corners = corners(element);
        assert!(corners.measure() > 0.0);
        sum += corners.measure();
        angle = corners.angles().into_iter().fold(angle, f64::min);
        for i in 0..4 {
            for j in 0..i {
                let edge = minus(corners[i], corners[j]);
                shortest = shortest.min(dot(edge, edge).sqrt());
            }
        }
        for facet in facets_of::<3, 4>(element).map(sorted) {
            *sides.entry(facet).or_default() += 1;
        }
    }
    assert!((sum / volume(&cut) - 1.0).abs() < 1e-9, "{sum} {}", volume(&cut));
    // Nodes of round faces are moved a little.
    assert!((sum / volume(surface) - 1.0).abs() < 0.02, "{sum} {}", volume(surface));
    // Facets of two elements, but for those of the outside.
    let outer = mesh.facets.iter().copied().map(sorted).collect::<Vec<_>>();
    assert_eq!(sides.values().filter(|&&count| count == 1).count(), outer.len());
    assert!(outer.iter().all(|facet| sides[facet] == 1));
    let (mut areas, mut off) = (vec![0.0; polygons.len()], 0.0_f64);
    let mut twice = mesh.inner.iter().copied().map(sorted).collect::<Vec<_>>();
    twice.sort_unstable();
    twice.dedup();
    assert_eq!(twice.len(), mesh.inner.len());
    for (facet, face) in mesh.inner.iter().zip(&mesh.inner_faces) {
        assert_eq!(sides[&sorted(*facet)], 2, "between two elements");
        let polygon = (face - first) as usize;
        let corners = facet.map(|node| mesh.nodes[node as usize]);
        areas[polygon] += area(corners);
        let [a, b, c] = [0, 1, 2].map(|k| polygons[polygon][k]);
        let normal = unit(cross(minus(b, a), minus(c, a)));
        off = corners.iter().map(|&corner| dot(normal, minus(corner, a)).abs()).fold(off, f64::max);
    }
    Ok(Found { angle, areas, off, shortest, mesh })
}

fn cube() -> Surface {
    cuboid([0.0; 3], [1.0; 3]).unwrap()
}

#[test]
fn three_sets_cut_a_cube_into_blocks() {
    for seed in 0..5 {
        let mut polygons = Vec::new();
        for axis in 0..3 {
            for place in [0.3, 0.62] {
                let mut normal = [0.0; 3];
                normal[axis] = 1.0;
                polygons.push(plane(times([1.0; 3], place), normal));
            }
        }
        let found = meshed(&cube(), &polygons, 0.12, seed).unwrap();
        assert!(found.off < 1e-12 && found.areas.iter().all(|area| (area - 1.0).abs() < 1e-9));
        let blocks = found.blocks();
        assert_eq!(blocks.len(), 27);
        assert!((blocks[0] - 0.3_f64.powi(3)).abs() < 1e-9, "{blocks:?}");
        println!("orthogonal {seed}: {} {} {}", found.angle, found.shortest, found.mesh.elements.len());
        assert!(found.angle > 10.0, "{}", found.angle);
    }
}

#[test]
fn oblique_sets() {
    for seed in 0..5 {
        let normals = [[0.2, 0.1, 1.0], [1.0, 0.3, -0.4], [-0.3, 1.0, 0.2]];
        let mut polygons = Vec::new();
        for normal in normals {
            for place in [0.25, 0.55, 0.85] {
                polygons.push(plane(times([1.0; 3], place), normal));
            }
        }
        let found = meshed(&cube(), &polygons, 0.1, seed).unwrap();
        println!(
            "oblique {seed}: {} {} {} {} {}",
            found.angle,
            found.shortest,
            found.mesh.elements.len(),
            found.off,
            found.blocks().len()
        );
    }
}

#[test]
fn random_discs() {
    let mut random = Random::new(7);
    let (mut refused, mut all) = (0, 0);
    for round in 0..40 {
        let count = 2 + round % 14;
        let polygons: Vec<Vec<Point>> = (0..count)
            .map(|_| {
                let mut number = || random.between(-1.0, 1.0);
                let centre = [number(), number(), number()].map(|x| 0.5 + 0.6 * x);
                let normal = [number(), number(), number()];
                disc(centre, normal, 0.45 + 0.2 * number(), 8)
            })
            .collect();
        all += 1;
        match meshed(&cube(), &polygons, 0.1, round as u64) {
            Ok(found) => println!(
                "{count}: {:.1} {:.4} {} off {:.3}",
                found.angle,
                found.shortest,
                found.mesh.elements.len(),
                found.off
            ),
            Err(error) => {
                refused += 1;
                println!("{count}: {error}")
            }
        }
    }
    println!("refused {refused} of {all}");
}
