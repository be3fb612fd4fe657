//! Polygons in bodies become facets of meshes:
//! - facets lie on their polygons, their areas sum up to those that are clipped to the body;
//! - blocks between polygons, and polygons that end inside;
//! - polygons that nearly coincide become one, and so do polygons that nearly meet;
//! - round bodies;
//! - many polygons at random: every mesh is right, or there is an error;
//! - refused polygons.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use std::collections::BTreeMap;

use fdem_mesh::shapes::{cuboid, cylinder, extrusion, hull, sphere, tube};
use fdem_mesh::tetrahedra::{PolygonError, Surface, Tetrahedra, add_polygons, graded};
use fdem_mesh::{Corners, Grading, facets_of, sorted};
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

/// The first of those that are joined with one.
fn root(parent: &mut [usize], mut at: usize) -> usize {
    while parent[at] != at {
        parent[at] = parent[parent[at]];
        at = parent[at];
    }
    at
}

/// The measured properties of a mesh.
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
    Ok(Found { mesh, angle, areas, off, shortest })
}

fn cube() -> Surface {
    cuboid([0.0; 3], [1.0; 3]).unwrap()
}

/// Area of the part of a convex polygon that is in the cube from 0 to 1.
fn clipped(polygon: &[Point]) -> f64 {
    let mut corners = polygon.to_vec();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let inside = |p: Point| if sign > 0.0 { p[axis] } else { 1.0 - p[axis] };
            let mut kept = Vec::new();
            for k in 0..corners.len() {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                let (h, g) = (inside(a), inside(b));
                if h >= 0.0 {
                    kept.push(a);
                }
                if (h >= 0.0) != (g >= 0.0) {
                    kept.push(plus(a, times(minus(b, a), h / (h - g))));
                }
            }
            corners = kept;
        }
    }
    (1..corners.len().saturating_sub(1)).map(|k| area([corners[0], corners[k], corners[k + 1]])).sum()
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
        assert!(found.angle > 12.0 && found.shortest > 0.3 * 0.12, "{} {}", found.angle, found.shortest);
    }
}

#[test]
fn oblique_sets_cut_all_edges_of_a_cube() {
    let normals = [[0.2, 0.1, 1.0], [1.0, 0.3, -0.4], [-0.3, 1.0, 0.2]];
    let polygons: Vec<Vec<Point>> = normals
        .iter()
        .flat_map(|&normal| [0.25, 0.55, 0.85].map(|x| plane(times([1.0; 3], x), normal)))
        .collect();
    for seed in 0..5 {
        let found = meshed(&cube(), &polygons, 0.1, seed).unwrap();
        assert!(found.angle > 5.0 && found.shortest > 0.03 * 0.1, "{} {}", found.angle, found.shortest);
        assert!(found.off < 0.7 * 0.1, "{}", found.off);
        for (area, polygon) in found.areas.iter().zip(&polygons) {
            assert!((area / clipped(polygon) - 1.0).abs() < 0.1, "{area} {}", clipped(polygon));
        }
        assert!(found.blocks().len() > 55, "{}", found.blocks().len());
    }
}

#[test]
fn polygons_that_end_inside_have_their_clipped_area_and_cut_nothing_off() {
    for (number, polygon) in [
        disc([0.5; 3], [0.3, 0.2, 1.0], 0.3, 8),
        disc([0.5, 0.5, 0.45], [0.0, 0.0, 1.0], 0.33, 6),
        // Through the sides, an edge, and a corner of the cube.
        disc([1.0, 0.5, 0.5], [0.1, -0.3, 1.0], 0.35, 8),
        disc([0.9, 1.0, 0.5], [0.2, 0.3, 1.0], 0.4, 5),
        disc([0.95, 0.9, 0.95], [1.0, 0.9, 1.1], 0.5, 8),
    ]
    .into_iter()
    .enumerate()
    {
        let expected = clipped(&polygon);
        let found = meshed(&cube(), &[polygon], 0.1, 1).unwrap();
        assert!((found.areas[0] / expected - 1.0).abs() < 0.06, "{number}: {} {expected}", found.areas[0]);
        assert!(number > 2 || (found.areas[0] / expected - 1.0).abs() < 1e-9, "{number}: {}", found.areas[0]);
        assert_eq!(found.blocks().len(), if number == 4 { 2 } else { 1 }, "{number}");
        assert!(found.angle > 8.0, "{number}: {}", found.angle);
    }
}

#[test]
fn a_polygon_need_not_be_convex() {
    let ell = [[0.2, 0.2], [0.8, 0.2], [0.8, 0.45], [0.5, 0.45], [0.5, 0.8], [0.2, 0.8]];
    let found = meshed(&cube(), &[ell.map(|[x, y]| [x, y, 0.4]).to_vec()], 0.1, 1).unwrap();
    assert!((found.areas[0] - 0.255).abs() < 1e-9, "{}", found.areas[0]);
}

#[test]
fn what_ends_near_another_polygon_or_a_face_ends_on_it() {
    let level = plane([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]);
    // Upright, from 0.03 above the level one to 0.03 below the top: it cuts the upper half in two.
    let upright = vec![[-1.0, 0.4, 0.53], [2.0, 0.4, 0.53], [2.0, 0.4, 0.97], [-1.0, 0.4, 0.97]];
    let found = meshed(&cube(), &[level, upright], 0.1, 1).unwrap();
    assert!((found.areas[1] - 0.5).abs() < 1e-9 && (found.areas[0] - 1.0).abs() < 1e-9, "{:?}", found.areas);
    let blocks = found.blocks();
    assert_eq!(blocks.len(), 3);
    assert!((blocks[0] - 0.2).abs() < 1e-9 && (blocks[2] - 0.5).abs() < 1e-9, "{blocks:?}");
}

#[test]
fn what_nearly_coincides_is_one() {
    let level = |z: f64| plane([0.0, 0.0, z], [0.0, 0.0, 1.0]);
    let found = meshed(&cube(), &[level(0.5), level(0.52), disc([0.5; 3], [0.02, 0.0, 1.0], 0.3, 8)], 0.1, 1)
        .unwrap();
    assert!((found.areas[0] - 1.0).abs() < 1e-9 && found.areas[1..] == [0.0, 0.0], "{:?}", found.areas);
    // A polygon on a face or beside the body makes no joint: the surface stays unchanged.
    for z in [0.98, 0.0, 1.5] {
        let mut surface = cube();
        add_polygons(&mut surface, &[level(z)], &Grading::even(0.1)).unwrap();
        assert_eq!(surface, cube());
    }
    // A plane that passes three corners of the cube at 0.01 goes through one of them, at least.
    let found = meshed(&cube(), &[plane([0.99, 0.0, 0.0], [1.0, 1.0, 1.0])], 0.2, 1).unwrap();
    assert!(found.shortest > 0.3 * 0.2, "{}", found.shortest);
}

#[test]
fn a_plane_along_a_face_of_a_body_with_a_notch_goes_on_inside() {
    let ell = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.4], [0.4, 0.4], [0.4, 1.0], [0.0, 1.0]];
    let body = extrusion(&[ell], 0.0, 0.5).unwrap();
    let found = meshed(&body, &[plane([0.4, 0.0, 0.0], [1.0, 0.0, 0.0])], 0.1, 1).unwrap();
    assert!((found.areas[0] - 0.2).abs() < 1e-9, "{}", found.areas[0]);
    assert_eq!(found.blocks().len(), 2);
}

#[test]
fn round_bodies_are_cut_along_planes() {
    for seed in 0..4 {
        for (number, normal) in [[0.0, 0.0, 1.0], [0.3, 0.1, 1.0], [1.0, 0.2, 0.6]].into_iter().enumerate() {
            let bodies = [
                cylinder([0.0; 3], [0.0, 0.0, 1.0], 0.3, &|_| 0.1, seed).unwrap(),
                sphere([0.0, 0.0, 0.5], 0.5, &|_| 0.1, seed).unwrap(),
                tube([0.0; 3], [0.0, 0.0, 1.0], 0.2, 0.4, &|_| 0.1, seed).unwrap(),
            ];
            for (shape, body) in bodies.iter().enumerate() {
                let found = meshed(body, &[plane([0.0, 0.0, 0.47], normal)], 0.1, seed).unwrap();
                assert!(
                    found.off < 0.035 && found.angle > 8.0,
                    "{shape} {number}: {} {}",
                    found.off,
                    found.angle
                );
                let blocks = found.blocks();
                assert_eq!(blocks.len(), 2, "{shape} {number}");
                if number == 0 {
                    let expected = std::f64::consts::PI * [0.09, 0.25 - 0.03 * 0.03, 0.12][shape];
                    assert!(
                        (found.areas[0] / expected - 1.0).abs() < 0.04,
                        "{shape}: {} {expected}",
                        found.areas[0]
                    );
                }
            }
        }
    }
}

/// Every mesh of random discs is right, or there is an error; most of them are meshed.
#[test]
fn random_discs_are_meshed_or_refused() {
    let mut random = Random::new(7);
    let (mut refused, mut cut) = (0, 0);
    let tip = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 1.0, 0.1], [0.3, 0.3, 1.0], [1.0, 1.0, 0.9]];
    let bodies = [cube(), hull(&tip).unwrap()];
    for round in 0..28 {
        let polygons: Vec<Vec<Point>> = (0..2 + round % 14)
            .map(|_| {
                let mut number = || random.between(-1.0, 1.0);
                let centre = [number(), number(), number()].map(|x| 0.5 + 0.6 * x);
                let normal = [number(), number(), number()];
                disc(centre, normal, 0.45 + 0.2 * number(), 8)
            })
            .collect();
        match meshed(&bodies[round % 2], &polygons, 0.15, round as u64) {
            Ok(found) => {
                // A plane is moved to another place, and then to a corner.
                assert!(
                    found.angle > 0.5 && found.off < 0.7 * 0.15,
                    "{round}: {} {}",
                    found.angle,
                    found.off
                );
                cut += usize::from(found.areas.iter().sum::<f64>() > 0.0);
            }
            Err(PolygonError::Close { .. } | PolygonError::Sharp { .. }) => refused += 1,
            Err(error) => panic!("{error}"),
        }
    }
    assert!(refused <= 3 && cut >= 23, "{refused} {cut}");
}

#[test]
fn the_same_polygons_and_seed_give_the_same_mesh() {
    let polygons = [plane([0.5; 3], [0.2, 0.1, 1.0]), disc([0.5, 0.4, 0.7], [1.0, 0.3, 0.2], 0.3, 8)];
    let one = meshed(&cube(), &polygons, 0.15, 3).unwrap().mesh;
    assert_eq!(one, meshed(&cube(), &polygons, 0.15, 3).unwrap().mesh);
    assert_ne!(one, meshed(&cube(), &polygons, 0.15, 4).unwrap().mesh);
}

#[test]
fn wrong_polygons_are_refused() {
    let level = plane([0.5; 3], [0.0, 0.0, 1.0]);
    let refused = |polygons: &[Vec<Point>]| {
        let mut surface = cube();
        let error = add_polygons(&mut surface, polygons, &Grading::even(0.1)).unwrap_err();
        assert_eq!(surface, cube(), "it stays what it was");
        error
    };
    let bent = vec![[0.2, 0.2, 0.5], [0.8, 0.2, 0.5], [0.8, 0.8, 0.6], [0.2, 0.8, 0.5]];
    assert!(
        matches!(refused(&[level.clone(), bent]), PolygonError::NotFlat { polygon: 1, distance } if distance > 0.02)
    );
    let line = vec![[0.2, 0.2, 0.5], [0.5, 0.2, 0.5], [0.8, 0.2, 0.5]];
    assert_eq!(refused(&[line]), PolygonError::NoArea { polygon: 0 });
    assert_eq!(refused(&[level.clone(), Vec::new()]), PolygonError::NoArea { polygon: 1 });
    let bow = vec![[0.2, 0.2, 0.5], [0.8, 0.8, 0.5], [0.8, 0.2, 0.5], [0.1, 0.7, 0.5]];
    assert_eq!(refused(&[bow]), PolygonError::Crossed { polygon: 0 });
    let far = vec![[0.2, 0.2, f64::NAN], [0.5, 0.2, 0.5], [0.8, 0.2, 0.5]];
    assert_eq!(refused(&[far]), PolygonError::NotFinite { polygon: 0 });
    // Through one line, at an angle of 2.8 degrees: moves of two planes by 0.35 of the size do not bring it
    // out of the cube.
    let tilted = plane([0.5; 3], [2.8_f64.to_radians().tan(), 0.0, 1.0]);
    let error = add_polygons(&mut cube(), &[level, tilted], &Grading::even(0.02)).unwrap_err();
    assert!(
        matches!(error, PolygonError::Sharp { polygons: [0, 1] | [1, 0], angle, .. } if angle < 2.9),
        "{error}"
    );
    assert!(error.to_string().contains("below 3"), "{error}");
}
