//! Meshes of triangles: they are conforming, have good angles, and elements of the requested size.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use fdem_mesh::triangles::outline::{Domain, area, circle};
use fdem_mesh::triangles::{INSIDE, OutlineError, Triangles, triangles};
use fdem_mesh::{Corners, Grading, Place, Refinement};

type Point = [f64; 2];

fn square() -> Vec<Point> {
    vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
}

fn domain(loops: Vec<Vec<Point>>) -> Domain {
    Domain { loops, lines: Vec::new() }
}

fn near(place: Place<2>, size: f64, reach: f64) -> Grading<2> {
    Grading { size: 0.1, near: vec![Refinement { place, size, reach }] }
}

fn corners(mesh: &Triangles, element: usize) -> [Point; 3] {
    mesh.elements[element].map(|node| mesh.nodes[node as usize])
}

fn middle(corners: &[Point; 3]) -> Point {
    [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0)
}

fn edges(corners: &[Point; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 3]);
        (ax - bx).hypot(ay - by)
    })
}

/// Checks that a mesh fills its domain and that every edge belongs to two elements or is part of the outline.
fn check(domain: &Domain, mesh: &Triangles) {
    let sum: f64 = (0..mesh.elements.len()).map(|element| corners(mesh, element).measure()).sum();
    assert!((sum / domain.area() - 1.0).abs() < 1e-9, "{sum}");
    let mut directed: Vec<[u32; 2]> =
        mesh.elements.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    directed.sort_unstable();
    assert!(directed.windows(2).all(|pair| pair[0] != pair[1]));
    for &[a, b] in &directed {
        if directed.binary_search(&[b, a]).is_err() {
            assert!([a, b].iter().all(|&node| mesh.loops[node as usize] != INSIDE));
        }
    }
}

fn least_angle(mesh: &Triangles) -> f64 {
    let angles = (0..mesh.elements.len()).flat_map(|element| corners(mesh, element).angles());
    angles.fold(180.0, f64::min)
}

fn gradings() -> Vec<Grading<2>> {
    vec![
        near(Place::Point([0.5, 0.4]), 0.004, 0.0),
        near(Place::Point([0.0, 0.0]), 0.005, 0.02),
        near(Place::Line(vec![[0.2, 0.2], [0.7, 0.45], [0.6, 0.8]]), 0.01, 0.0),
        near(Place::Line(vec![[0.3, 0.0], [0.6, 0.0]]), 0.005, 0.01),
        near(Place::Box([[0.6, 0.6], [1.0, 0.8]]), 0.01, 0.0),
        near(Place::Box([[0.0, 1.0], [1.0, 1.0]]), 0.01, 0.03),
    ]
}

#[test]
fn elements_are_as_large_as_the_grading_says_and_grow_slowly() {
    for (number, grading) in gradings().iter().enumerate() {
        let domain = domain(vec![square(), circle([0.25, 0.7], 0.1, grading)]);
        for seed in 0..3 {
            let mesh = triangles(&domain, grading, seed).unwrap();
            check(&domain, &mesh);
            let least = least_angle(&mesh);
            assert!(least > 15.0, "grading {number}, seed {seed}: {least}");
            let (mut sum, mut count) = (0.0, 0.0);
            for element in 0..mesh.elements.len() {
                let corners = corners(&mesh, element);
                let size = grading.at(middle(&corners));
                for edge in edges(&corners) {
                    assert!(edge < 2.0 * size, "grading {number}, seed {seed}: {edge} of {size}");
                    sum += edge / size;
                    count += 1.0;
                }
            }
            assert!((sum / count - 1.0).abs() < 0.15, "grading {number}, seed {seed}: {}", sum / count);
        }
    }
}

#[test]
fn neighbours_are_of_similar_size() {
    for grading in gradings() {
        let mesh = triangles(&domain(vec![square()]), &grading, 1).unwrap();
        let size = |element: u32| edges(&corners(&mesh, element as usize)).iter().sum::<f64>();
        let mut sides: Vec<([u32; 2], u32)> = Vec::new();
        for (number, &[a, b, c]) in (0..).zip(&mesh.elements) {
            sides.extend([[a, b], [b, c], [c, a]].map(|[a, b]| ([a.min(b), a.max(b)], number)));
        }
        sides.sort_unstable();
        for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let ratio = size(pair[0].1) / size(pair[1].1);
            assert!((0.4..2.5).contains(&ratio), "{ratio}");
        }
    }
}

#[test]
fn a_seed_gives_one_mesh_wherever_the_body_lies() {
    let grading = near(Place::Point([0.5, 0.4]), 0.01, 0.0);
    let mesh = triangles(&domain(vec![square()]), &grading, 3).unwrap();
    assert_eq!(mesh, triangles(&domain(vec![square()]), &grading, 3).unwrap());
    assert_ne!(mesh, triangles(&domain(vec![square()]), &grading, 4).unwrap());
    // Far from 0 the mesher works about the middle of the body: the size has to move with it.
    let far = [3e5, -7e5];
    let moved = square().into_iter().map(|[x, y]| [x + far[0], y + far[1]]).collect();
    let distant = Grading {
        size: 0.1,
        near: vec![Refinement { place: Place::Point([3e5 + 0.5, 0.4 - 7e5]), ..grading.near[0].clone() }],
    };
    let count = triangles(&domain(vec![moved]), &distant, 3).unwrap().elements.len() as f64;
    assert!((count / mesh.elements.len() as f64 - 1.0).abs() < 0.05);
}

#[test]
fn circles_are_cut_by_the_size_on_them() {
    let grading = near(Place::Point([1.0, 0.0]), 0.001, 0.0);
    let points = circle([0.0; 2], 1.0, &grading);
    assert!((area(&points) - std::f64::consts::PI).abs() < 0.01);
    for k in 0..points.len() {
        let ([ax, ay], [bx, by]) = (points[k], points[(k + 1) % points.len()]);
        let size = grading.at([0.5 * (ax + bx), 0.5 * (ay + by)]);
        let ratio = (ax - bx).hypot(ay - by) / size;
        assert!((0.8..1.25).contains(&ratio), "{ratio}");
    }
    for farthest in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
        assert!(points.contains(&farthest));
    }
}

#[test]
fn errors_tell_what_is_wrong() {
    let even = Grading::even(0.1);
    let error = |loops: Vec<Vec<Point>>| triangles(&domain(loops), &even, 1).unwrap_err();
    let hole = |x: f64| vec![[x, 0.4], [x + 0.1, 0.4], [x, 0.5]];
    assert!(matches!(error(vec![square(), hole(1.5)]), OutlineError::HoleOutside { hole: 1, .. }));
    let around = vec![[0.2, 0.2], [0.9, 0.2], [0.2, 0.9]];
    assert_eq!(error(vec![square(), around, hole(0.3)]), OutlineError::HoleInHole { hole: 2, around: 1 });
    let bow = vec![[0.0, 0.0], [1.0, 0.9], [1.0, 0.0], [0.0, 1.0]];
    assert!(matches!(error(vec![bow]), OutlineError::Crossing { .. }));
    assert!(matches!(error(vec![vec![[0.0, 0.0]; 3]]), OutlineError::Twice { .. }));
    let tiny = vec![[0.0, 0.0], [1e-100, 0.0], [0.0, 1e-100]];
    assert_eq!(error(vec![tiny]).to_string(), "coordinates of the outline: a number is nearly 0, but not 0");
    let fine = near(Place::Box([[0.0; 2], [1.0; 2]]), 1e-5, 0.0);
    assert!(matches!(
        triangles(&domain(vec![square()]), &fine, 1),
        Err(OutlineError::TooMany { elements }) if elements > 1e9
    ));
}
