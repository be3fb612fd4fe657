//! Lines inside domains become edges of the mesh.

#![allow(clippy::expect_used, reason = "a failed expectation is a failed test")]

use fdem_mesh::triangles::outline::{Domain, Point, distance};
use fdem_mesh::triangles::{Triangles, add_lines, triangles};
use fdem_mesh::{Corners, Grading, Mesh, Quality};
use fdem_scenes::random::Random;

fn square() -> Domain {
    Domain { loops: vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]], lines: Vec::new() }
}

/// The mesh of a domain with lines, the length of the edges along each line, and the smallest angle in
/// degrees.
fn meshed(mut domain: Domain, lines: &[[Point; 2]], size: f64) -> (Triangles, Vec<f64>, f64) {
    let size = Grading::even(size);
    let area = domain.area();
    let parts = add_lines(&mut domain, lines, &size).expect("lines");
    let mesh = triangles(&domain, &size, 1).expect("a mesh");
    let mut lengths = vec![0.0; lines.len()];
    for (&[a, b], &line) in mesh.lines.iter().zip(&mesh.line_of) {
        let [p, q] = [a, b].map(|node| mesh.nodes[node as usize]);
        lengths[parts[line as usize].expect("no other lines")] += distance(p, q);
        let beside = |t: &&[u32; 3]| t.contains(&a) && t.contains(&b);
        assert!(mesh.elements.iter().filter(beside).count() == 2, "an edge between two triangles");
    }
    let count = mesh.elements.len();
    let whole = Mesh {
        nodes: mesh.nodes.clone(),
        elements: mesh.elements.clone(),
        bodies: vec![0; count],
        materials: vec![0; count],
    };
    let quality = Quality::of(&whole);
    let of = |t: &[u32; 3]| t.map(|node| mesh.nodes[node as usize]).measure();
    assert!((mesh.elements.iter().map(of).sum::<f64>() / area - 1.0).abs() < 1e-9);
    (mesh, lengths, quality.smallest_angle[0])
}

#[test]
fn lines_that_end_inside_cross_and_leave_the_domain() {
    let lines = [
        [[0.2, 0.5], [0.8, 0.5]],
        [[0.5, -1.0], [0.5, 2.0]],
        [[0.3, 0.2], [0.7, 0.8]],
        [[0.0, 0.3], [0.25, 0.3]],
        [[2.0, 0.0], [3.0, 0.0]],
    ];
    let (_, lengths, angle) = meshed(square(), &lines, 0.05);
    for (found, right) in lengths.iter().zip([0.6, 1.0, 0.4_f64.hypot(0.6), 0.25, 0.0]) {
        assert!((found - right).abs() < 1e-9, "{lengths:?}");
    }
    assert!(angle > 18.0, "{angle}");
}

#[test]
fn lines_that_nearly_coincide_become_one() {
    let lines = [[[0.1, 0.5], [0.9, 0.5]], [[0.2, 0.503], [0.8, 0.495]], [[0.1, 0.001], [0.9, 0.004]]];
    let (_, lengths, angle) = meshed(square(), &lines, 0.05);
    // Lines along the outline become part of the outline.
    assert!((lengths[0] - 0.8).abs() < 1e-3 && lengths[1..] == [0.0, 0.0], "{lengths:?}");
    assert!(angle > 18.0, "{angle}");
}

#[test]
fn lines_that_end_near_others_and_near_the_outline_end_on_them() {
    let lines = [[[0.1, 0.5], [0.9, 0.5]], [[0.5, 0.51], [0.5, 0.9951]], [[0.005, 0.2], [0.4, 0.2]]];
    let (mesh, lengths, angle) = meshed(square(), &lines, 0.05);
    assert!((lengths[1] - 0.5).abs() < 0.02 && (lengths[2] - 0.4).abs() < 1e-9, "{lengths:?}");
    let has = |point: Point| mesh.nodes.iter().any(|&node| distance(node, point) < 1e-12);
    assert!(has([0.5, 1.0]) && has([0.0, 0.2]));
    assert!(angle > 15.0, "{angle}");
}

#[test]
fn a_small_angle_stays_that_of_the_lines() {
    let lines = [[[0.1, 0.5], [0.9, 0.5]], [[0.1, 0.43], [0.9, 0.57]]];
    let (_, lengths, angle) = meshed(square(), &lines, 0.04);
    assert!((lengths[1] - 0.8_f64.hypot(0.14)).abs() < 1e-3, "{lengths:?}");
    assert!(angle > 8.0, "{angle}");
}

/// Random networks in a square with a hole: all have a mesh, and their clipped lengths apart from snapping.
#[test]
fn random_networks_have_meshes() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut domain = square();
        domain.loops.push(vec![[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.6]]);
        let mut point = || [random.between(-0.2, 1.2), random.between(-0.2, 1.2)];
        let lines: Vec<[Point; 2]> = (0..30).map(|_| [point(), point()]).collect();
        let (_, lengths, angle) = meshed(domain, &lines, 0.03);
        assert!(lengths.iter().sum::<f64>() > 5.0);
        assert!(angle > 0.5, "seed {seed}: {angle}");
    }
}
