//! Meshes of tetrahedra, from surface to elements:
//! - every mesh covers its body exactly, and facets match;
//! - angles over shapes, sizes and seeds;
//! - sizes from place to place;
//! - the same mesh for a seed, near and far from the origin;
//! - regions that share facets, and grains;
//! - input that cannot be meshed.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use fdem_mesh::shapes::{
    Prism, cuboid, cylinder, extrusion, grains, grains_of_sphere, hull, onto_sphere, sphere, tube,
};
use fdem_mesh::tetrahedra::{
    MeshError, OUTSIDE, Surface, Tetrahedra, graded, moved, sharpest_corner, sharpest_edge, tetrahedra,
};
use fdem_mesh::{Grading, Place, Refinement};
use fdem_scenes::random::Random;

type Point = [f64; 3];

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

const FACETS: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

fn corners(mesh: &Tetrahedra, element: usize) -> [Point; 4] {
    mesh.elements[element].map(|node| mesh.nodes[node as usize])
}

/// Smallest and largest angle between facets, degrees.
fn angles(mesh: &Tetrahedra) -> [f64; 2] {
    let (mut least, mut most) = (180.0_f64, 0.0_f64);
    for element in 0..mesh.elements.len() {
        let p = corners(mesh, element);
        let normals = FACETS.map(|[a, b, c]| {
            let n = cross(minus(p[b], p[a]), minus(p[c], p[a]));
            n.map(|x| x / length(n))
        });
        for i in 0..4 {
            for j in 0..i {
                let angle = (-dot(normals[i], normals[j])).clamp(-1.0, 1.0).acos().to_degrees();
                (least, most) = (least.min(angle), most.max(angle));
            }
        }
    }
    [least, most]
}

fn mean_edge(mesh: &Tetrahedra) -> f64 {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for element in &mesh.elements {
        for i in 0..4 {
            for j in 0..i {
                edges.push([element[i].min(element[j]), element[i].max(element[j])]);
            }
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let sum: f64 = edges
        .iter()
        .map(|edge| length(minus(mesh.nodes[edge[0] as usize], mesh.nodes[edge[1] as usize])))
        .sum();
    sum / edges.len() as f64
}

fn volume_of(surface: &Surface, region: u32) -> f64 {
    let origin = surface.nodes[0];
    let facets = surface.facets.iter().zip(&surface.sides);
    let sum = facets.map(|(facet, sides)| {
        let sign = f64::from(sides[0] == region) - f64::from(sides[1] == region);
        let [a, b, c] = facet.map(|node| minus(surface.nodes[node as usize], origin));
        sign * dot(a, cross(b, c)) / 6.0
    });
    sum.sum()
}

/// Meshes a surface, and checks all that holds for every mesh.
fn meshed(surface: &Surface, size: f64, seed: u64) -> Tetrahedra {
    let mesh = tetrahedra(surface, &|_| size, seed).unwrap();
    check(surface, &mesh);
    mesh
}

fn check(surface: &Surface, mesh: &Tetrahedra) {
    let mut regions = mesh.regions.clone();
    regions.sort_unstable();
    regions.dedup();
    for region in regions {
        let volumes =
            (0..mesh.elements.len()).filter(|&element| mesh.regions[element] == region).map(|element| {
                let [a, b, c, d] = corners(mesh, element);
                let volume = dot(minus(b, a), cross(minus(c, a), minus(d, a))) / 6.0;
                assert!(volume > 0.0);
                volume
            });
        let volume = volume_of(surface, region);
        // Coordinates far from the origin are rounded.
        let far = surface.nodes.iter().flatten().fold(0.0_f64, |far, x| far.max(x.abs()));
        let near = 1e-12 * (volume + far * volume.powf(2.0 / 3.0));
        assert!((volumes.sum::<f64>() - volume).abs() < near);
    }
    // Each facet of an element is met once from each side, or is listed, as seen from outside or from the
    // higher region.
    let key = |mut facet: [u32; 3]| {
        facet.sort_unstable();
        facet
    };
    let mut facets: Vec<([u32; 3], u32, [u32; 3])> = Vec::new();
    for (element, &region) in mesh.elements.iter().zip(&mesh.regions) {
        for facet in FACETS.map(|places| places.map(|k| element[k])) {
            facets.push((key(facet), region, facet));
        }
    }
    facets.sort_unstable();
    let mut listed = Vec::new();
    for group in facets.chunk_by(|one, other| one.0 == other.0) {
        assert!(group.len() <= 2);
        if group.len() == 1 || group[0].1 != group[1].1 {
            listed.push(group[0].2);
        }
    }
    let turned = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    let mut expected: Vec<[u32; 3]> = listed.into_iter().map(turned).collect();
    let mut found: Vec<[u32; 3]> = mesh.facets.iter().copied().map(turned).collect();
    expected.sort_unstable();
    found.sort_unstable();
    assert_eq!(expected, found);
    assert_eq!(mesh.faces.len(), mesh.facets.len());
    assert_eq!(mesh.regions.len(), mesh.elements.len());
    // All nodes are used.
    let mut used = vec![false; mesh.nodes.len()];
    mesh.elements.iter().flatten().for_each(|&node| used[node as usize] = true);
    assert!(used.into_iter().all(|used| used));
}

const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// Built-in shapes of a size of about 1.
fn shapes(size: f64, seed: u64) -> Vec<Surface> {
    let ell = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.4], [0.4, 0.4], [0.4, 1.0], [0.0, 1.0]];
    let window = vec![[0.3, 0.3], [0.7, 0.35], [0.6, 0.7]];
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let icosahedron: Vec<Point> = (0..12)
        .map(|k| {
            let (x, y) = (0.25 * [1.0, -1.0][k & 1], 0.25 * [golden, -golden][k >> 1 & 1]);
            [[x, y, 0.0], [0.0, x, y], [y, 0.0, x]][k >> 2]
        })
        .collect();
    vec![
        cuboid([0.0; 3], [1.0; 3]).unwrap(),
        cuboid([0.0; 3], [1.0, 0.6, 0.3]).unwrap(),
        sphere([0.3, 0.2, 0.1], 0.5, &|_| size, seed).unwrap(),
        cylinder([0.0; 3], [0.0, 0.0, 1.0], 0.25, &|_| size, seed).unwrap(),
        cylinder([0.0; 3], [0.3, 0.5, 1.0], 0.3, &|_| size, seed).unwrap(),
        tube([0.0; 3], [1.0, 0.0, 0.0], 0.25, 0.5, &|_| size, seed).unwrap(),
        extrusion(&[ell], 0.0, 0.5).unwrap(),
        extrusion(&[SQUARE.to_vec(), window], -0.2, 0.2).unwrap(),
        hull(&icosahedron).unwrap(),
    ]
}

#[test]
fn angles_are_good_over_shapes_sizes_and_seeds() {
    // A mesh of the smaller size has 15 times as many angles.
    let seeds = if std::env::var_os("FDEM_THOROUGH").is_some() { [20, 20] } else { [20, 4] };
    for (size, seeds) in [0.25, 0.1].into_iter().zip(seeds) {
        for seed in 0..seeds {
            for (number, surface) in shapes(size, seed).iter().enumerate() {
                let mesh = meshed(surface, size, seed);
                let [least, most] = angles(&mesh);
                assert!(
                    least > 12.0 && most < 165.0,
                    "shape {number}, size {size}, seed {seed}: {least} {most}"
                );
            }
        }
    }
}

#[test]
fn coarse_meshes_are_good_too() {
    for seed in 0..20 {
        for (number, surface) in shapes(10.0, seed).iter().enumerate() {
            let [least, most] = angles(&meshed(surface, 10.0, seed));
            assert!(least > 8.0 && most < 165.0, "shape {number}, seed {seed}: {least} {most}");
        }
    }
}

#[test]
fn the_mean_edge_is_the_size() {
    for seed in 0..3 {
        for (number, surface) in shapes(0.08, seed).iter().enumerate() {
            let ratio = mean_edge(&meshed(surface, 0.08, seed)) / 0.08;
            assert!((ratio - 1.0).abs() < 0.1, "shape {number}, seed {seed}: {ratio}");
        }
    }
}

#[test]
fn edges_have_no_preferred_direction() {
    let mesh = meshed(&cuboid([0.0; 3], [1.0; 3]).unwrap(), 0.05, 1);
    let mut moment = [[0.0; 3]; 3];
    let mut count = 0.0;
    for element in 0..mesh.elements.len() {
        let [a, b, _, _] = corners(&mesh, element);
        let inside = a.iter().chain(&b).all(|x| (0.1..0.9).contains(x));
        let edge = minus(b, a);
        let span = length(edge);
        for i in 0..3 {
            for j in 0..3 {
                moment[i][j] += if inside { edge[i] * edge[j] / (span * span) } else { 0.0 };
            }
        }
        count += f64::from(u8::from(inside));
    }
    for (i, row) in moment.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let even = if i == j { 1.0 / 3.0 } else { 0.0 };
            assert!((value / count - even).abs() < 0.01, "{moment:?} of {count}");
        }
    }
}

#[test]
fn flat_faces_are_exact() {
    let (low, high) = ([0.1, -0.3, 7.7], [1.2, 0.9, 8.3]);
    let surface = cuboid(low, high).unwrap();
    let mesh = meshed(&surface, 0.2, 3);
    for (facet, &face) in mesh.facets.iter().zip(&mesh.faces) {
        let (axis, plane) = [(0, low), (0, high), (1, low), (1, high), (2, low), (2, high)][face as usize];
        assert!(facet.iter().all(|&node| mesh.nodes[node as usize][axis] == plane[axis]));
    }
    assert_eq!(surface.names, ["left", "right", "front", "back", "bottom", "top"]);
}

#[test]
fn nodes_of_round_faces_are_on_them() {
    let ball = meshed(&sphere([1.0, 2.0, 3.0], 0.5, &|_| 0.15, 1).unwrap(), 0.15, 1);
    for &node in ball.facets.iter().flatten() {
        assert!((length(minus(ball.nodes[node as usize], [1.0, 2.0, 3.0])) - 0.5).abs() < 1e-12);
    }
    let surface = cylinder([0.0; 3], [0.0, 0.0, 2.0], 0.5, &|_| 0.15, 1).unwrap();
    let mesh = meshed(&surface, 0.15, 1);
    for (facet, &face) in mesh.facets.iter().zip(&mesh.faces) {
        for [x, y, z] in facet.map(|node| mesh.nodes[node as usize]) {
            match face {
                0 => assert_eq!(z, 0.0),
                1 => assert_eq!(z, 2.0),
                _ => assert!((x.hypot(y) - 0.5).abs() < 1e-12),
            }
        }
    }
}

#[test]
fn sizes_may_differ_by_a_factor_of_20() {
    let size = |[x, y, z]: Point| (0.01 + 0.4 * (x * x + y * y + z * z).sqrt()).min(0.2);
    let limited = |place: Point| (0.01 + 0.3 * length(place)).min(0.2);
    for (number, surface) in [
        cuboid([0.0; 3], [1.0; 3]).unwrap(),
        cuboid([-0.5; 3], [0.5; 3]).unwrap(),
        cylinder([0.0; 3], [0.0, 0.0, 1.0], 0.3, &limited, 1).unwrap(),
        sphere([0.0, 0.0, 0.5], 0.5, &limited, 1).unwrap(),
    ]
    .iter()
    .enumerate()
    {
        for seed in 0..3 {
            let mesh = tetrahedra(surface, &size, seed).unwrap();
            check(surface, &mesh);
            let [least, most] = angles(&mesh);
            assert!(least > 12.0 && most < 165.0, "shape {number}, seed {seed}: {least} {most}");
            let mut ratio = [0.0; 2];
            for element in 0..mesh.elements.len() {
                let p = corners(&mesh, element);
                let middle = [0, 1, 2].map(|k| 0.25 * (p[0][k] + p[1][k] + p[2][k] + p[3][k]));
                for i in 0..4 {
                    for j in 0..i {
                        ratio[0] += length(minus(p[i], p[j])) / limited(middle);
                        ratio[1] += 1.0;
                    }
                }
            }
            assert!((ratio[0] / ratio[1] - 1.0).abs() < 0.15, "shape {number}: {}", ratio[0] / ratio[1]);
        }
    }
}

/// Boxes with a place near which elements are smaller, some far smaller than the grid of sizes is wide.
#[test]
fn elements_are_small_near_places() {
    let near = |place, size, reach| Grading { size: 0.2, near: vec![Refinement { place, size, reach }] };
    for (number, grading) in [
        near(Place::Point([0.31, 0.42, 0.53]), 0.004, 0.0),
        near(Place::Point([1.0, 1.0, 0.0]), 0.002, 0.0),
        near(Place::Line(vec![[0.0, 0.5, 1.0], [1.0, 0.5, 1.0]]), 0.03, 0.0),
        near(Place::Box([[0.3, 0.3, 0.0], [0.6, 0.6, 0.0]]), 0.03, 0.02),
    ]
    .iter()
    .enumerate()
    {
        let surface = cuboid([0.0; 3], [1.0; 3]).unwrap();
        let mesh = graded(&surface, grading, 1).unwrap();
        check(&surface, &mesh);
        let [least, most] = angles(&mesh);
        assert!(least > 8.0 && most < 165.0, "place {number}: {least} {most}");
        let (mut sum, mut count) = (0.0, 0.0);
        for element in 0..mesh.elements.len() {
            let p = corners(&mesh, element);
            let size = grading.at([0, 1, 2].map(|k| 0.25 * (p[0][k] + p[1][k] + p[2][k] + p[3][k])));
            for (i, j) in (0..4).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let edge = length(minus(p[i], p[j]));
                assert!(edge < 2.5 * size, "place {number}: {edge} of {size}");
                sum += edge / size;
                count += 1.0;
            }
        }
        assert!((sum / count - 1.0).abs() < 0.2, "place {number}: {}", sum / count);
        assert!(graded(&surface, grading, 1).unwrap() == mesh);
    }
    let fine = near(Place::Box([[0.0; 3], [1.0; 3]]), 1e-4, 0.0);
    let surface = cuboid([0.0; 3], [1.0; 3]).unwrap();
    assert!(matches!(graded(&surface, &fine, 1), Err(MeshError::TooMany { .. })));
}

#[test]
fn a_seed_gives_one_mesh_on_any_thread() {
    let make = |seed| {
        let surface = tube([0.0; 3], [0.2, 0.1, 1.0], 0.2, 0.4, &|_| 0.1, seed).unwrap();
        tetrahedra(&surface, &|_| 0.1, seed).unwrap()
    };
    let first = make(5);
    let threads: Vec<_> = (0..2).map(|_| std::thread::spawn(move || make(5))).collect();
    for thread in threads {
        assert!(thread.join().unwrap() == first);
    }
    assert!(make(6) != first);
    // The bits, in one number (FNV-1a): a platform or a change that gives another mesh is noticed.
    let bits = first.nodes.iter().flatten().map(|x| x.to_bits());
    let bits = bits.chain(first.elements.iter().flatten().map(|&node| u64::from(node)));
    let hash = bits.fold(0xcbf2_9ce4_8422_2325_u64, |hash, bits| (hash ^ bits).wrapping_mul(0x100_0000_01b3));
    assert_eq!(hash, 0x539d_1654_0cc3_bfbd, "{hash:#x}");
}

#[test]
fn the_place_of_a_body_does_not_matter() {
    let near = meshed(&cuboid([0.0; 3], [1.0; 3]).unwrap(), 0.2, 1);
    let far = meshed(&cuboid([1e6; 3], [1e6 + 1.0; 3]).unwrap(), 0.2, 1);
    assert_eq!(near.elements, far.elements);
    for tiny in [1e-60, 1e60] {
        let other = meshed(&cuboid([0.0; 3], [tiny; 3]).unwrap(), 0.2 * tiny, 1);
        assert_eq!(
            other.elements.len(),
            tetrahedra(&cuboid([0.0; 3], [1.0; 3]).unwrap(), &|_| 0.2, 1).unwrap().elements.len()
        );
    }
}

/// Boxes in a row along x, each with its region.
fn row(count: u32) -> Surface {
    let mut surface = Surface::default();
    for x in 0..=count {
        for k in 0..4 {
            surface.nodes.push([f64::from(x), f64::from(k & 1), f64::from(k >> 1)]);
        }
    }
    let mut push = |[a, b, c, d]: [u32; 4], sides: [u32; 2], face: u32| {
        surface.facets.extend([[a, b, c], [a, c, d]]);
        surface.sides.extend([sides; 2]);
        surface.faces.extend([face; 2]);
    };
    for x in 0..=count {
        let before = if x == 0 { OUTSIDE } else { x - 1 };
        let n = 4 * x;
        push([n, n + 1, n + 3, n + 2], [before, if x == count { OUTSIDE } else { x }], x);
    }
    for x in 0..count {
        let n = 4 * x;
        for [i, j] in [[0, 1], [1, 3], [3, 2], [2, 0]] {
            push([n + i, n + j, n + 4 + j, n + 4 + i], [x, OUTSIDE], 100);
        }
    }
    surface
}

#[test]
fn regions_share_nodes_and_facets() {
    let surface = row(3);
    let mesh = meshed(&surface, 0.3, 1);
    let [least, most] = angles(&mesh);
    assert!(least > 12.0 && most < 165.0, "{least} {most}");
    for face in 1..3 {
        let area: f64 = (0..mesh.facets.len())
            .filter(|&facet| mesh.faces[facet] == face)
            .map(|facet| {
                let [a, b, c] = mesh.facets[facet].map(|node| mesh.nodes[node as usize]);
                assert!([a, b, c].iter().all(|point| point[0] == f64::from(face)));
                0.5 * cross(minus(b, a), minus(c, a))[0]
            })
            .sum();
        // Seen from the region of the higher number, which is on the right.
        assert!((area - 1.0).abs() < 1e-12);
    }
}

#[test]
fn grains_fill_a_body() {
    let body = cuboid([0.0; 3], [1.0, 1.0, 2.0]).unwrap();
    for seed in 0..5 {
        let surface = grains(&body, 12, seed).unwrap();
        let sum: f64 = (0..12).map(|region| volume_of(&surface, region)).sum();
        assert!((sum - 2.0).abs() < 1e-12);
        assert_eq!(surface.names, body.names);
        let mesh = meshed(&surface, 0.15, seed);
        let [least, most] = angles(&mesh);
        assert!(least > 8.0 && most < 168.0, "seed {seed}: {least} {most}");
        assert_eq!(mesh.regions.iter().max(), Some(&11));
        // Faces of the body keep their numbers.
        let top = (0..mesh.facets.len()).filter(|&facet| mesh.faces[facet] == 5);
        assert!(top.flat_map(|facet| mesh.facets[facet]).all(|node| mesh.nodes[node as usize][2] == 2.0));
    }
    let one = grains(&body, 1, 1).unwrap();
    assert!((volume_of(&one, 0) - 2.0).abs() < 1e-12);
    assert_eq!(grains(&body, 0, 1), Err(MeshError::Empty));
    let ell = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.4], [0.4, 0.4], [0.4, 1.0], [0.0, 1.0]];
    let ell = extrusion(&[ell], 0.0, 1.0).unwrap();
    assert!(matches!(grains(&ell, 5, 1), Err(MeshError::NotConvex { .. })));
}

#[test]
fn loose_triangles_become_a_surface_with_faces() {
    let cube = cuboid([0.0; 3], [1.0; 3]).unwrap();
    let triangles: Vec<[Point; 3]> =
        cube.facets.iter().map(|facet| facet.map(|node| cube.nodes[node as usize])).collect();
    let surface = Surface::from_triangles(&triangles, 30.0).unwrap();
    assert_eq!((surface.nodes.len(), surface.faces.iter().max()), (8, Some(&5)));
    meshed(&surface, 0.3, 1);
    let round = cylinder([0.0; 3], [0.0, 0.0, 1.0], 0.5, &|_| 0.2, 1).unwrap();
    let triangles: Vec<[Point; 3]> =
        round.facets.iter().map(|facet| facet.map(|node| round.nodes[node as usize])).collect();
    let surface = Surface::from_triangles(&triangles, 60.0).unwrap();
    assert_eq!(surface.faces.iter().max(), Some(&2));
    meshed(&surface, 0.2, 1);
}

#[test]
fn bodies_may_have_voids() {
    let mut surface = cuboid([0.0; 3], [1.0; 3]).unwrap();
    let inner = cuboid([0.4; 3], [0.6; 3]).unwrap();
    surface.nodes.extend(inner.nodes);
    surface.facets.extend(inner.facets.iter().map(|&[a, b, c]| [a + 8, c + 8, b + 8]));
    surface.faces.extend(inner.faces.iter().map(|face| face + 6));
    surface.sides.extend(inner.sides);
    let mesh = meshed(&surface, 0.15, 1);
    assert!(angles(&mesh)[0] > 12.0);
}

#[test]
fn bad_surfaces_are_refused_with_the_reason() {
    let cube = cuboid([0.0; 3], [1.0; 3]).unwrap();
    let error = |change: fn(&mut Surface)| {
        let mut surface = cube.clone();
        change(&mut surface);
        tetrahedra(&surface, &|_| 0.3, 1).unwrap_err()
    };
    assert!(matches!(error(|s| *s = Surface::default()), MeshError::Empty));
    assert!(matches!(error(|s| s.nodes[3][1] = f64::NAN), MeshError::NotFinite { node: 3 }));
    assert!(matches!(error(|s| s.facets[4][1] = 99), MeshError::NoSuchNode { facet: 4 }));
    assert!(matches!(error(|s| s.facets[4][1] = s.facets[4][0]), MeshError::Degenerate { facet: 4, .. }));
    assert!(matches!(error(|s| s.faces.clear()), MeshError::Lengths { .. }));
    let open = |s: &mut Surface| {
        s.facets.pop();
        s.faces.pop();
        s.sides.pop();
    };
    assert!(matches!(error(open), MeshError::Open { .. }));
    assert!(matches!(error(|s| s.facets[0].swap(0, 1)), MeshError::Orientation { .. }));
    let inverted = |s: &mut Surface| s.facets.iter_mut().for_each(|facet| facet.swap(0, 1));
    assert!(matches!(error(inverted), MeshError::Inverted { region: 0 }));
    // A corner pushed through the opposite face.
    assert!(matches!(error(|s| s.nodes[0] = [2.0, 0.5, 0.4]), MeshError::Crossing { .. }));
    // Twisted through itself: the volumes of its two halves cancel each other.
    let twisted = |s: &mut Surface| {
        for node in s.nodes.iter_mut().filter(|node| node[2] == 1.0) {
            *node = [1.0 - node[0], 1.0 - node[1], 1.0];
        }
    };
    assert!(matches!(error(twisted), MeshError::Crossing { .. }));
    let twice = |s: &mut Surface| {
        s.facets.push(s.facets[3]);
        s.faces.push(0);
        s.sides.push(s.sides[3]);
    };
    assert!(matches!(error(twice), MeshError::Twice { facets: [3, 12], .. }));
    assert!(matches!(error(|s| s.sides[2] = [0, 0]), MeshError::Sides { .. }));
    let flat = |s: &mut Surface| s.nodes.iter_mut().for_each(|node| node[2] = 0.0);
    assert!(matches!(error(flat), MeshError::Degenerate { .. } | MeshError::Inverted { .. }));
    assert!(!error(flat).to_string().is_empty());
}

#[test]
fn plates_much_thinner_than_the_size_are_refused() {
    for thickness in [7e-3, 1e-3, 1e-9] {
        let plate = cuboid([0.0; 3], [1.0, 1.0, thickness]).unwrap();
        let error = tetrahedra(&plate, &|_| 0.1, 1).unwrap_err();
        assert!(
            matches!(error, MeshError::Thin { thickness: found, .. } if (found / thickness - 1.0).abs() < 0.02),
            "{error}"
        );
        assert!(matches!(tetrahedra(&plate, &|_| thickness * 1e-3, 1), Err(MeshError::TooMany { .. })));
    }
    for thickness in [0.03, 0.01] {
        let [least, _] = angles(&meshed(&cuboid([0.0; 3], [1.0, 1.0, thickness]).unwrap(), 0.1, 1));
        assert!(least > 8.0, "{thickness}: {least}");
    }
}

/// A sphere of `rings` rings of triangles between circles of latitude. Each quadrilateral is flat only up to
/// rounding, and all its points are on one sphere.
fn globe(rings: usize, a_face_each: bool) -> Surface {
    use std::f64::consts::PI;
    let sectors = 2 * rings;
    let mut nodes = vec![[0.0, 0.0, 1.0]];
    for ring in 1..rings {
        let (sine, cosine) = (PI * ring as f64 / rings as f64).sin_cos();
        nodes.extend((0..sectors).map(|sector| {
            let (y, x) = (2.0 * PI * sector as f64 / sectors as f64).sin_cos();
            [sine * x, sine * y, cosine]
        }));
    }
    nodes.push([0.0, 0.0, -1.0]);
    let at = |ring: usize, sector: usize| match ring {
        0 => 0,
        _ if ring == rings => nodes.len() as u32 - 1,
        _ => (1 + (ring - 1) * sectors + sector % sectors) as u32,
    };
    let mut facets = Vec::new();
    for ring in 0..rings {
        for sector in 0..sectors {
            let [a, b] = [at(ring, sector), at(ring + 1, sector)];
            let [c, d] = [at(ring + 1, sector + 1), at(ring, sector + 1)];
            if ring > 0 {
                facets.push([a, c, d]);
            }
            if ring + 1 < rings {
                facets.push([a, b, c]);
            }
        }
    }
    let count = facets.len() as u32;
    Surface {
        nodes,
        faces: if a_face_each { (0..count).collect() } else { vec![0; facets.len()] },
        sides: vec![[0, OUTSIDE]; facets.len()],
        facets,
        names: Vec::new(),
    }
}

/// Delaunay's tetrahedra of these points have flat ones outside, in whose spheres all points inside are:
/// before locked facets were walls, no point was inserted, and the angles were below 2°.
#[test]
fn surfaces_of_many_points_on_one_sphere_have_good_angles() {
    for (rings, a_face_each) in [(15, false), (15, true), (21, false), (21, true)] {
        let globe = globe(rings, a_face_each);
        let mesh = meshed(&globe, 0.3, 1);
        check(&globe, &mesh);
        let [least, _] = angles(&mesh);
        assert!(least > 8.0, "{rings}, {a_face_each}: {least}");
    }
}

/// The edges of long faces are flipped until all are Delaunay's, however many flips that takes.
#[test]
fn a_rod_may_be_thousands_of_times_as_long_as_wide() {
    let rod = cuboid([0.0; 3], [3000.0, 1.0, 1.0]).unwrap();
    let mesh = meshed(&rod, 1.0, 1);
    assert_eq!(mesh.elements.len(), 18_000, "six for each cube");
}

#[test]
fn tubes_with_thin_walls_or_a_hair_as_hole_are_refused() {
    let tube = |inner, size: f64| tube([0.0; 3], [0.0, 0.0, 1.0], inner, 0.5, &move |_| size, 1);
    let thin = tube(0.499, 0.1).unwrap_err();
    assert!(
        matches!(thin, MeshError::Thin { thickness, size, .. } if (thickness - 1e-3).abs() < 1e-9 && size == 0.1)
    );
    assert!(tube(0.49, 0.1).is_ok());
    let hair = tube(1e-6, 0.1).unwrap_err();
    assert!(matches!(hair, MeshError::Slender { radius: 1e-6, length: 1.0, .. }), "{hair}");
    assert!(tube(1e-3, 0.1).is_ok());
}

/// The nodes of the mantle are on the cylinder, the grains fill it, and angles are good.
#[test]
fn grains_of_a_cylinder_are_round_outside() {
    let (from, to, radius): (Point, Point, f64) = ([0.1, 0.0, 0.0], [0.14, 0.03, 0.12], 0.04);
    for seed in 0..2 {
        let size = [0.007, 0.01][seed as usize % 2];
        let prism = Prism::of_cylinder(from, to, radius).unwrap();
        let surface = grains(&prism.surface(), 12, seed).unwrap();
        let mesh = moved(&surface, &Grading::even(size), seed, &|mesh| prism.round(mesh)).unwrap();
        let [least, most] = angles(&mesh);
        assert!(least > 8.0 && most < 172.0, "seed {seed}: {least} to {most}");
        let along = minus(to, from);
        let mut area = 0.0;
        for (facet, &face) in mesh.facets.iter().zip(&mesh.faces) {
            if face != 2 {
                continue;
            }
            let points = facet.map(|node| mesh.nodes[node as usize]);
            for point in points {
                let off = cross(minus(point, from), along);
                assert!((length(off) / length(along) - radius).abs() < 1e-12);
            }
            area += 0.5 * length(cross(minus(points[1], points[0]), minus(points[2], points[0])));
        }
        let exact = std::f64::consts::TAU * radius * length(along);
        assert!((0.97..1.0).contains(&(area / exact)), "{}", area / exact);
        let volume: f64 = (0..mesh.elements.len())
            .map(|element| {
                let [a, b, c, d] = corners(&mesh, element);
                let six = dot(minus(b, a), cross(minus(c, a), minus(d, a)));
                assert!(six > 0.0);
                six / 6.0
            })
            .sum();
        let exact = std::f64::consts::PI * radius * radius * length(along);
        assert!((0.95..1.0).contains(&(volume / exact)), "{}", volume / exact);
        let mut found = mesh.regions.clone();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found, (0..12).collect::<Vec<u32>>());
    }
}

/// All nodes outside are on the sphere, the grains fill it and share their faces, and angles are good.
#[test]
fn grains_of_a_sphere_are_round_outside() {
    let (centre, radius): (Point, f64) = ([0.1, 0.2, -0.3], 0.04);
    let exact = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    for (seed, count) in (0..).zip([2, 5, 12, 60]) {
        let mean = (exact / f64::from(count)).cbrt();
        for across in [2.0, 4.0] {
            let size = mean / across;
            let surface = grains_of_sphere(centre, radius, count as usize, &|_| size, seed).unwrap();
            let to = |mesh: &mut Tetrahedra| onto_sphere(mesh, centre, radius);
            let mesh = moved(&surface, &Grading::even(size), seed, &to).unwrap();
            let [least, most] = angles(&mesh);
            assert!(least > 8.0 && most < 172.0, "{count} grains, size {size}: {least} to {most}");
            let mut vector = [0.0; 3];
            for facet in (0..mesh.facets.len()).filter(|&facet| mesh.faces[facet] == 0) {
                let points = mesh.facets[facet].map(|node| mesh.nodes[node as usize]);
                for point in points {
                    assert!((length(minus(point, centre)) / radius - 1.0).abs() < 1e-12);
                }
                let area = cross(minus(points[1], points[0]), minus(points[2], points[0]));
                vector = [0, 1, 2].map(|k| vector[k] + area[k]);
            }
            assert!(length(vector) < 1e-12 * radius * radius, "the outer surface is closed");
            let mut volumes = vec![0.0; count as usize];
            for element in 0..mesh.elements.len() {
                let [a, b, c, d] = corners(&mesh, element);
                let six = dot(minus(b, a), cross(minus(c, a), minus(d, a)));
                assert!(six > 0.0);
                volumes[mesh.regions[element] as usize] += six / 6.0;
            }
            assert!(
                volumes.iter().all(|volume| (0.3..3.0).contains(&(volume / mean.powi(3)))),
                "{volumes:?}"
            );
            let whole = volumes.iter().sum::<f64>() / exact;
            // Chords are below the sphere by the square of the size over eight times the radius.
            let least = 1.0 - 0.45 * (size / radius) * (size / radius);
            assert!((least..1.0).contains(&whole), "{count} grains, size {size}: {whole}");
        }
    }
    let one = grains_of_sphere(centre, radius, 1, &|_| 0.01, 1).unwrap();
    assert_eq!(one, sphere(centre, radius, &|_| 0.01, 1).unwrap());
    assert_eq!(grains_of_sphere(centre, radius, 0, &|_| 0.01, 1), Err(MeshError::Empty));
    assert!(grains_of_sphere(centre, -1.0, 5, &|_| 0.01, 1).is_err());
    assert!(grains_of_sphere(centre, radius, 5, &|_| f64::NAN, 1).is_err());
}

/// Elements are smaller near places in grains of spheres too.
#[test]
fn grains_of_a_sphere_may_have_sizes_that_differ() {
    let near = vec![Refinement { place: Place::Point([0.0, 0.0, 0.5]), size: 0.01, reach: 0.0 }];
    let grading = Grading { size: 0.1, near };
    let surface = grains_of_sphere([0.0; 3], 0.5, 8, &|place| grading.at(place), 1).unwrap();
    let mesh = moved(&surface, &grading, 1, &|mesh| onto_sphere(mesh, [0.0; 3], 0.5)).unwrap();
    let [least, most] = angles(&mesh);
    assert!(least > 8.0 && most < 172.0, "{least} to {most}");
}

/// Angles are good, or those of the sharp edges of the body, unless it is too thin for the size or a face of
/// it ends in an angle below 1°: such a face is flat up to its ends.
#[test]
fn random_hulls_have_angles_as_good_as_their_edges_and_corners() {
    let (mut thin, mut narrow) = (0, 0);
    for seed in (0..80).chain([227]) {
        let mut random = Random::new(seed);
        let points: Vec<Point> = (0..4 + random.below(8)).map(|_| [0; 3].map(|_| random.uniform())).collect();
        let surface = hull(&points).unwrap();
        if let Err(error) = tetrahedra(&surface, &|_| 0.3, seed) {
            assert!(matches!(error, MeshError::Thin { .. }), "seed {seed}: {error}");
            thin += 1;
            continue;
        }
        let edge = sharpest_edge(&surface.nodes, &surface.facets).unwrap();
        let corner = sharpest_corner(&surface.nodes, &surface.facets).unwrap();
        let [least, _] = angles(&meshed(&surface, 0.3, seed));
        if corner.angle < 1.0 {
            narrow += 1;
        }
        let wanted = if corner.angle < 1.0 { 3.0 } else { 8.0_f64.min(edge.angle) };
        assert!(least > 0.99 * wanted, "seed {seed}: {least} of {edge:?}, {corner:?}");
    }
    assert!(thin < 16 && narrow == 3, "{thin} {narrow}");
}

#[test]
fn touching_bodies_are_refused() {
    let mut surface = cuboid([0.0; 3], [1.0; 3]).unwrap();
    let other = cuboid([1.0, 0.2, 0.2], [2.0, 0.8, 0.8]).unwrap();
    surface.nodes.extend(other.nodes);
    surface.facets.extend(other.facets.iter().map(|facet| facet.map(|node| node + 8)));
    surface.faces.extend(other.faces);
    surface.sides.extend(other.sides.iter().map(|_| [1, OUTSIDE]));
    assert!(matches!(surface.check(), Err(MeshError::Crossing { .. })));
}

#[test]
fn bad_sizes_and_shapes_are_refused() {
    let cube = cuboid([0.0; 3], [1.0; 3]).unwrap();
    for size in [0.0, -1.0, f64::NAN] {
        assert!(matches!(tetrahedra(&cube, &|_| size, 1), Err(MeshError::Size { .. })));
        assert!(sphere([0.0; 3], 1.0, &|_| size, 1).is_err());
        assert!(cuboid([0.0; 3], [1.0, 1.0, 1e200]).is_err());
        assert!(cylinder([0.0; 3], [1.0; 3], 1.0, &|_| size, 1).is_err());
        assert!(cylinder([0.0; 3], [1.0; 3], size, &|_| 1.0, 1).is_err());
    }
    assert!(
        matches!(tetrahedra(&cube, &|_| 1e-4, 1), Err(MeshError::TooMany { elements }) if elements > 1e12)
    );
    assert!(matches!(sphere([0.0; 3], 1.0, &|_| 1e-5, 1), Err(MeshError::TooMany { .. })));
    assert_eq!(cuboid([0.0; 3], [1.0, 1.0, 0.0]), Err(MeshError::Flat));
    assert_eq!(hull(&[[0.0; 3]; 10]), Err(MeshError::Flat));
    assert!(cylinder([1.0; 3], [1.0; 3], 1.0, &|_| 1.0, 1).is_err());
    assert!(tube([0.0; 3], [1.0; 3], 2.0, 1.0, &|_| 1.0, 1).is_err());
    assert_eq!(extrusion(&[], 0.0, 1.0), Err(MeshError::Empty));
    let bow = vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    assert!(matches!(extrusion(&[bow], 0.0, 1.0), Err(MeshError::Outline { .. })));
    let crossing = vec![[0.5, 0.5], [1.5, 0.5], [0.6, 0.8]];
    assert!(matches!(extrusion(&[SQUARE.to_vec(), crossing], 0.0, 1.0), Err(MeshError::Outline { .. })));
    let inside = vec![[0.2, 0.2], [0.8, 0.2], [0.2, 0.8]];
    let nested = vec![[0.25, 0.25], [0.3, 0.25], [0.25, 0.3]];
    let told = |loops: &[Vec<[f64; 2]>]| extrusion(loops, 0.0, 1.0).unwrap_err().to_string();
    assert_eq!(told(&[SQUARE.to_vec(), inside, nested]), "hole 2 is in hole 1");
    let beyond = vec![[2.25, 0.25], [2.5, 0.25], [2.25, 0.5]];
    assert_eq!(told(&[SQUARE.to_vec(), beyond]), "hole 1 is not inside the outline: [2.25, 0.25] is beyond");
}
