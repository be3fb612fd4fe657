//! Surfaces with fewer facets.

use fdem_mesh::tetrahedra::{Surface, tetrahedra};
use fdem_mesh::{Coarsened, shapes};

type Triangle = [[f64; 3]; 3];

/// Angle of edges between faces, degrees.
const CREASE: f64 = 30.0;

fn surface(triangles: &[Triangle]) -> Surface {
    let surface = Surface::from_triangles(triangles, CREASE).expect("triangles");
    surface.check().expect("a closed surface");
    surface
}

fn coarse(surface: &Surface, size: f64, tolerance: f64) -> Coarsened {
    let coarse = surface.coarsened(&|_| size, tolerance).expect("fewer facets");
    coarse.surface.check().expect("a closed surface");
    assert!(coarse.distance <= tolerance, "{}", coarse.distance);
    coarse
}

fn places(surface: &Surface) -> impl Iterator<Item = Triangle> {
    surface.facets.iter().map(|corners| corners.map(|node| surface.nodes[node as usize]))
}

fn volume(surface: &Surface) -> f64 {
    let six = |[a, b, c]: Triangle| -> f64 {
        (0..3).map(|k| a[k] * (b[(k + 1) % 3] * c[(k + 2) % 3] - b[(k + 2) % 3] * c[(k + 1) % 3])).sum()
    };
    places(surface).map(six).sum::<f64>() / 6.0
}

/// A box from the origin, of `counts` squares along each axis, each of two triangles.
fn block(lengths: [f64; 3], counts: [usize; 3]) -> Vec<Triangle> {
    let mut all = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (side, level) in [(0, 0.0), (1, lengths[axis])] {
            let at = |i: usize, j: usize| {
                let mut point = [0.0; 3];
                point[axis] = level;
                point[u] = lengths[u] * i as f64 / counts[u] as f64;
                point[v] = lengths[v] * j as f64 / counts[v] as f64;
                point
            };
            for i in 0..counts[u] {
                for j in 0..counts[v] {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let two = if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    all.extend(two);
                }
            }
        }
    }
    all
}

#[test]
fn a_fine_cube_becomes_as_coarse_as_its_size() {
    let fine = surface(&block([1.0; 3], [16; 3]));
    let coarse = coarse(&fine, 0.5, 1e-6);
    assert_eq!(fine.facets.len(), 3072);
    assert!(coarse.surface.facets.len() < 150, "{}", coarse.surface.facets.len());
    assert!((volume(&coarse.surface) - 1.0).abs() < 1e-12);
    assert!(coarse.distance < 1e-12, "{}", coarse.distance);
    // Its faces are those of a cube, and it has its corners.
    let faces = coarse.surface.faces.iter().collect::<std::collections::BTreeSet<_>>().len();
    assert_eq!(faces, 6);
    let corners = coarse.surface.nodes.iter().filter(|node| node.iter().all(|x| *x == 0.0 || *x == 1.0));
    assert_eq!(corners.count(), 8);
    // Facets as large as the size, or larger, stay.
    assert!(surface(&block([1.0; 3], [1; 3])).coarsened(&|_| 0.5, 0.1).is_none());
}

#[test]
fn a_sphere_keeps_its_volume_within_the_tolerance() {
    let size = 0.05;
    let fine = shapes::sphere([0.0; 3], 1.0, &|_| size, 1).expect("a sphere");
    let (area, before) = (4.0 * std::f64::consts::PI, volume(&fine));
    let mut facets = fine.facets.len();
    for tolerance in [0.003, 0.01, 0.05] {
        let coarse = coarse(&fine, 0.4, tolerance);
        let lost = before - volume(&coarse.surface);
        assert!(lost > 0.0 && lost < area * tolerance, "{tolerance}: {lost}");
        assert!(coarse.distance > 0.3 * tolerance, "{tolerance}: {}", coarse.distance);
        assert!(coarse.surface.facets.len() < facets, "{tolerance}: {}", coarse.surface.facets.len());
        facets = coarse.surface.facets.len();
        let again = self::coarse(&fine, 0.4, tolerance);
        assert_eq!(again.surface, coarse.surface);
    }
    assert!(facets < fine.facets.len() / 8, "{facets} of {}", fine.facets.len());
}

#[test]
fn a_thin_plate_stays_a_plate() {
    // Thinner than the tolerance: its two sides must not meet.
    let fine = surface(&block([1.0, 1.0, 0.02], [20, 20, 1]));
    let coarse = coarse(&fine, 0.3, 0.05);
    assert!((volume(&coarse.surface) - 0.02).abs() < 1e-12, "{}", volume(&coarse.surface));
    assert!(coarse.surface.facets.len() < fine.facets.len() / 4, "{}", coarse.surface.facets.len());
}

/// A fold inside of a face: its edge moves although no node is far off.
#[test]
fn a_ridge_is_within_the_tolerance() {
    // A cube whose top is a ridge of 10 degrees, below the angle of edges between faces.
    let height = 0.5 * f64::to_radians(10.0).tan();
    let raised: Vec<Triangle> = block([1.0; 3], [8; 3])
        .into_iter()
        .map(|triangle| triangle.map(|[x, y, z]| [x, y, z * (1.0 + height * (1.0 - (2.0 * x - 1.0).abs()))]))
        .collect();
    let fine = surface(&raised);
    let coarse = coarse(&fine, 0.8, 0.01);
    assert!((volume(&coarse.surface) - volume(&fine)).abs() < 0.02, "{}", volume(&coarse.surface));
    let top = |surface: &Surface| surface.nodes.iter().map(|node| node[2]).fold(0.0, f64::max);
    assert!(top(&coarse.surface) > 1.0 + height - 0.01, "{}", top(&coarse.surface));
}

/// One small patch makes the elements of a whole cube fine.
#[test]
fn a_fine_patch_costs_nothing() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let ring = [[0.4999, 0.4999], [0.5001, 0.4999], [0.5001, 0.5001], [0.4999, 0.5001]];
    let mut triangles: Vec<Triangle> = block([1.0; 3], [1; 3]);
    triangles.retain(|triangle| triangle.iter().any(|corner| corner[2] < 1.0));
    let on_top = |[x, y]: [f64; 2]| [x, y, 1.0];
    for k in 0..4 {
        let [a, b] = [k, (k + 1) % 4];
        triangles.push([corners[a], corners[b], ring[b]].map(on_top));
        triangles.push([corners[a], ring[b], ring[a]].map(on_top));
        triangles.push([ring[a], ring[b], [0.5, 0.5]].map(on_top));
    }
    let coarse = coarse(&surface(&triangles), 0.3, 1e-3);
    assert_eq!(coarse.surface.facets.len(), 14);
    let shortest = |surface: &Surface| {
        let mesh = tetrahedra(surface, &|_| 0.3, 1).expect("a mesh");
        let corners = mesh.elements.iter().map(|nodes| nodes.map(|node| mesh.nodes[node as usize]));
        corners.flat_map(|corners| fdem_mesh::edges(&corners)).fold(f64::INFINITY, f64::min)
    };
    assert!(shortest(&coarse.surface) > 0.05, "{}", shortest(&coarse.surface));
}
