//! Contacts of meshed bodies.
//!
//! | section | compared with |
//! |---|---|
//! | elements | all pairs through the narrow phase, for every engine, on threads, with and without self-contact |
//! | bodies | labelled images of the same squares and cubes; areas of outlines by `geo`; boxes by formula |
//! | degenerate | the expected result or error |
//! | spheres | all spheres against all triangles; the planes of a box |
//! | grains | the Voronoi cells of a disc that were meshed, and an image of the same disc |

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::collections::{BTreeMap, BTreeSet};

use fdem_contact::discretised::{
    BodyContact, DiscretisedError, ElementContact, MeshElement, MeshSearch, MeshView, body_contacts, contacts,
};
use fdem_contact::image::{self, Neighbourhood, Spacing};
use fdem_contact::narrow::{
    Contact, Measure, Sphere, Tetrahedron, Triangle, sphere_mesh, tetrahedron_tetrahedron, triangle_triangle,
    triangle_triangle_2d,
};
use fdem_contact::{Engine, Error};
use geo::{Area, BooleanOps, Coord, LineString, Polygon};

use crate::random::SplitMix64;

const ENGINES: [Option<Engine>; 5] =
    [None, Some(Engine::Direct), Some(Engine::Nbs), Some(Engine::Rows), Some(Engine::Multilevel)];

/// Arrays of a mesh.
#[derive(Clone)]
struct Parts<const D: usize, const N: usize> {
    points: Vec<[f64; D]>,
    elements: Vec<[u32; N]>,
    bodies: Vec<u32>,
}

impl<const D: usize, const N: usize> Parts<D, N>
where
    [[f64; D]; N]: MeshElement<D>,
{
    fn mesh(&self) -> MeshView<'_, D, N> {
        MeshView::new(&self.points, &self.elements, &self.bodies).unwrap()
    }

    fn found(&self) -> (Vec<ElementContact<D>>, Vec<BodyContact<D>>) {
        let found = contacts(&self.mesh()).unwrap();
        let bodies = body_contacts(&self.mesh(), &found).unwrap();
        (found, bodies)
    }

    /// `elements` elements with corners on a lattice, crowded in a cube; every tenth names a node twice.
    fn random(rng: &mut SplitMix64, elements: usize, bodies: usize) -> Self {
        let side = 6.0 * (elements as f64).powf(1.0 / D as f64) * 0.3;
        let mut parts = Self { points: Vec::new(), elements: Vec::new(), bodies: Vec::new() };
        for element in 0..elements {
            let centre: [f64; D] = std::array::from_fn(|_| (rng.unit() * side).floor());
            let first = parts.points.len() as u32;
            let mut nodes: [u32; N] = std::array::from_fn(|k| first + k as u32);
            parts.points.extend((0..N).map(|_| centre.map(|x| x + rng.index(4) as f64)));
            if element % 10 == 0 {
                nodes[N - 1] = nodes[0];
            }
            if element % 3 == 0 && element > 0 {
                // Takes a node of another element.
                nodes[0] = rng.index(first as usize) as u32;
                let near = parts.points[nodes[0] as usize];
                for &node in &nodes[1..] {
                    if node >= first {
                        parts.points[node as usize] = near.map(|x| x + rng.index(5) as f64 - 2.0);
                    }
                }
            }
            parts.elements.push(nodes);
            parts.bodies.push(rng.index(bodies) as u32 * 7);
        }
        parts
    }
}

// ---------------------------------------------------------------- elements

/// The narrow phase of two elements.
fn narrow_2d(a: [[f64; 2]; 3], b: [[f64; 2]; 3]) -> Contact<2> {
    triangle_triangle_2d(&Triangle::new(a).unwrap(), &Triangle::new(b).unwrap(), &mut Vec::new())
}

fn narrow_surface(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> Contact<3> {
    triangle_triangle(&Triangle::new(a).unwrap(), &Triangle::new(b).unwrap())
}

fn narrow_solid(a: [[f64; 3]; 4], b: [[f64; 3]; 4]) -> Contact<3> {
    tetrahedron_tetrahedron(&Tetrahedron::new(a).unwrap(), &Tetrahedron::new(b).unwrap())
}

/// Contacts of all pairs of elements, with self-contact.
fn all_pairs<const D: usize, const N: usize>(
    parts: &Parts<D, N>,
    narrow: fn([[f64; D]; N], [[f64; D]; N]) -> Contact<D>,
) -> Vec<ElementContact<D>> {
    let vertices = |k: usize| parts.elements[k].map(|node| parts.points[node as usize]);
    let mut found = Vec::new();
    for j in 0..parts.elements.len() {
        for i in 0..j {
            let common = parts.elements[i].iter().any(|node| parts.elements[j].contains(node));
            if parts.bodies[i] == parts.bodies[j] && common {
                continue;
            }
            let contact = narrow(vertices(i), vertices(j));
            if contact.touches() {
                found.push(ElementContact { i: i as u32, j: j as u32, contact });
            }
        }
    }
    found.sort_by_key(|c| (c.i, c.j));
    found
}

fn equal_to_all_pairs<const D: usize, const N: usize>(
    seed: u64,
    narrow: fn([[f64; D]; N], [[f64; D]; N]) -> Contact<D>,
) where
    [[f64; D]; N]: MeshElement<D>,
{
    let mut rng = SplitMix64(seed);
    let mut contacts_of_one_body = 0;
    let many = if crate::thorough() { (700, 40) } else { (300, 20) };
    for (elements, bodies) in [(2, 2), (30, 3), (150, 150), many] {
        let parts = Parts::<D, N>::random(&mut rng, elements, bodies);
        let all = all_pairs(&parts, narrow);
        let are_of_one = |c: &ElementContact<D>| parts.bodies[c.i as usize] == parts.bodies[c.j as usize];
        contacts_of_one_body += all.iter().filter(|c| are_of_one(c)).count();
        for self_contact in [false, true] {
            let mut expected = all.clone();
            expected.retain(|c| self_contact || !are_of_one(c));
            assert!(elements < 100 || expected.len() > elements / 4, "{} of {elements}", expected.len());
            for engine in ENGINES {
                for threads in [1, 3] {
                    let mut search = MeshSearch::new()
                        .with_engine(engine)
                        .with_threads(threads)
                        .unwrap()
                        .with_self_contact(self_contact);
                    let mut found = Vec::new();
                    search.contacts(&parts.mesh(), &mut found).unwrap();
                    assert!(found == expected, "{engine:?} {threads} {elements}");
                }
            }
            // A check knows nothing of engines and threads, so one is enough.
            let search = MeshSearch::new().with_self_contact(self_contact);
            assert_eq!(search.verify(&parts.mesh(), &expected, 20, 1), Ok(elements.min(20)));
            // Without the last contact, the check compares nearly all pairs before it knows: few elements.
            let left_out = if elements < 200 { expected.len().saturating_sub(1) } else { 0 };
            let mut less = expected;
            if !less.is_empty() {
                less.remove(left_out);
                assert!(search.verify(&parts.mesh(), &less, elements, 1).is_err());
            }
        }
    }
    assert!(contacts_of_one_body > 10, "{contacts_of_one_body}");
}

#[test]
fn triangles_in_2d_equal_all_pairs() {
    equal_to_all_pairs(1, narrow_2d);
}

#[test]
fn surfaces_equal_all_pairs() {
    equal_to_all_pairs(2, narrow_surface);
}

#[test]
fn tetrahedra_equal_all_pairs() {
    equal_to_all_pairs(3, narrow_solid);
}

/// Renumbering elements, nodes and bodies, or moving them, does not change the contacts: the coordinates are
/// whole numbers.
fn unchanged_by_names_and_places<const D: usize, const N: usize>(seed: u64)
where
    [[f64; D]; N]: MeshElement<D>,
{
    let mut rng = SplitMix64(seed);
    let parts = Parts::<D, N>::random(&mut rng, 400, 25);
    let (found, bodies) = parts.found();
    let mut order: Vec<usize> = (0..parts.elements.len()).collect();
    for k in (1..order.len()).rev() {
        order.swap(k, rng.index(k + 1));
    }
    let renamed = |body: u32| 1000 - body;
    let shift = 1024.0;
    let other = Parts::<D, N> {
        points: parts.points.iter().rev().map(|p| p.map(|x| x - shift)).collect(),
        elements: order
            .iter()
            .map(|&k| parts.elements[k].map(|node| parts.points.len() as u32 - 1 - node))
            .collect(),
        bodies: order.iter().map(|&k| renamed(parts.bodies[k])).collect(),
    };
    let (others, other_bodies) = other.found();
    let couples: BTreeSet<_> = found.iter().map(|c| (c.i, c.j)).collect();
    let named = others.iter().map(|c| {
        let [a, b] = [c.i, c.j].map(|k| order[k as usize] as u32);
        (a.min(b), a.max(b))
    });
    assert!(!couples.is_empty());
    assert_eq!(named.collect::<BTreeSet<_>>(), couples);
    assert_eq!(others.len(), couples.len());

    let by_names: BTreeMap<_, _> =
        other_bodies.iter().map(|c| ([renamed(c.bodies[1]), renamed(c.bodies[0])], c)).collect();
    assert_eq!(by_names.len(), bodies.len());
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + a.abs());
    for contact in &bodies {
        let moved = by_names[&contact.bodies];
        assert_eq!(moved.couples, contact.couples);
        assert!(near(moved.overlap, contact.overlap) && near(moved.shared, contact.shared));
        // An overlap of one rounding step may be 0 elsewhere; then points have equal weights.
        if contact.overlap > 1e-9 {
            assert!((0..D).all(|k| near(moved.point[k] + shift, contact.point[k])), "{contact:?} {moved:?}");
        }
    }
}

#[test]
fn names_and_places_do_not_matter() {
    unchanged_by_names_and_places::<2, 3>(4);
    unchanged_by_names_and_places::<3, 3>(5);
    unchanged_by_names_and_places::<3, 4>(6);
}

// ---------------------------------------------------------------- bodies

/// The squares of a labelled image, two triangles each.
fn squares(labels: &[u16], [rows, columns]: [usize; 2]) -> Parts<2, 3> {
    let node = |row: usize, column: usize| (row * (columns + 1) + column) as u32;
    let mut parts = Parts { points: Vec::new(), elements: Vec::new(), bodies: Vec::new() };
    for row in 0..=rows {
        parts.points.extend((0..=columns).map(|column| [column as f64 - 0.5, row as f64 - 0.5]));
    }
    for (at, &label) in labels.iter().enumerate().filter(|(_, label)| **label != 0) {
        let (row, column) = (at / columns, at % columns);
        let [a, b] = [node(row, column), node(row, column + 1)];
        let [d, c] = [node(row + 1, column), node(row + 1, column + 1)];
        parts.elements.extend([[a, b, c], [a, c, d]]);
        parts.bodies.extend([u32::from(label); 2]);
    }
    parts
}

/// The cubes of a labelled image, six tetrahedra each, around the diagonal from the first corner to the last,
/// so that faces of neighbours match.
fn cubes(labels: &[u16], [planes, rows, columns]: [usize; 3]) -> Parts<3, 4> {
    let node = |[x, y, z]: [usize; 3]| ((z * (rows + 1) + y) * (columns + 1) + x) as u32;
    let mut parts = Parts { points: Vec::new(), elements: Vec::new(), bodies: Vec::new() };
    for z in 0..=planes {
        for y in 0..=rows {
            parts.points.extend((0..=columns).map(|x| [x, y, z].map(|x| x as f64 - 0.5)));
        }
    }
    for (at, &label) in labels.iter().enumerate().filter(|(_, label)| **label != 0) {
        let corner = [at % columns, at / columns % rows, at / columns / rows];
        for axes in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut place = corner;
            let mut nodes = [node(place); 4];
            for (k, axis) in axes.into_iter().enumerate() {
                place[axis] += 1;
                nodes[k + 1] = node(place);
            }
            parts.elements.push(nodes);
            parts.bodies.push(u32::from(label));
        }
    }
    parts
}

/// The contacts of the mesh of an image equal those of the image: pairs with squares (cubes) at vertices,
/// faces, centroids, normals.
fn equals_image<const D: usize, const N: usize>(labels: &[u16], shape: [usize; D], parts: &Parts<D, N>)
where
    [[f64; D]; N]: MeshElement<D>,
{
    let (_, bodies) = parts.found();
    let at_vertices = image::contacts(labels, shape, Neighbourhood::Vertex).unwrap();
    let expected: Vec<_> = at_vertices.iter().map(|c| c.labels().map(u32::from)).collect();
    assert_eq!(bodies.iter().map(|c| c.bodies).collect::<Vec<_>>(), expected);
    let at_faces = image::contacts(labels, shape, Neighbourhood::Face).unwrap();
    assert!(at_faces.len() > 10 && at_faces.len() < at_vertices.len());
    let of_faces: Vec<_> = bodies.iter().filter(|c| c.shared > 0.0).collect();
    assert_eq!(of_faces.len(), at_faces.len());
    for (found, expected) in of_faces.into_iter().zip(&at_faces) {
        assert_eq!(found.overlap, 0.0);
        assert_eq!(found.shared, expected.faces() as f64);
        let mut centroid = expected.centroid(&Spacing::UNIT);
        let mut normal = expected.normal(&Spacing::UNIT);
        centroid.reverse();
        normal.reverse();
        for k in 0..D {
            assert!((found.point[k] - centroid[k]).abs() < 1e-12, "{found:?} {centroid:?}");
            assert!((found.normal[k] - normal[k]).abs() < 1e-12, "{found:?} {normal:?}");
        }
    }
}

#[test]
fn squares_and_cubes_touch_as_in_images() {
    let mut rng = SplitMix64(7);
    let images = if crate::thorough() { 3 } else { 1 };
    for _ in 0..images {
        let labels: Vec<u16> = (0..12 * 15).map(|_| rng.index(30) as u16).collect();
        equals_image(&labels, [12, 15], &squares(&labels, [12, 15]));
        let labels: Vec<u16> = (0..5 * 6 * 7).map(|_| rng.index(60).saturating_sub(20) as u16).collect();
        equals_image(&labels, [5, 6, 7], &cubes(&labels, [5, 6, 7]));
    }
}

/// A box of cubes of edge 1 from the origin as one body.
fn block(sizes: [usize; 3], body: u16) -> Parts<3, 4> {
    let [x, y, z] = sizes;
    cubes(&vec![body; x * y * z], [z, y, x])
}

fn together<const D: usize, const N: usize>(
    mut a: Parts<D, N>,
    b: &Parts<D, N>,
    by: [f64; D],
) -> Parts<D, N> {
    let first = a.points.len() as u32;
    a.points.extend(b.points.iter().map(|p| std::array::from_fn::<_, D, _>(|k| p[k] + by[k])));
    a.elements.extend(b.elements.iter().map(|nodes| nodes.map(|node| node + first)));
    a.bodies.extend(&b.bodies);
    a
}

#[test]
fn the_volume_of_overlapping_blocks_is_a_product() {
    let (sizes, other) = ([4, 3, 2], [3, 3, 3]);
    for by in [[2.25, 1.5, 0.75], [-1.125, 0.25, -2.5], [3.0, 2.5, 1.0]] {
        let parts = together(block(sizes, 2), &block(other, 1), by);
        let (_, bodies) = parts.found();
        let mut volume = 1.0;
        let mut centre = [0.0; 3];
        for k in 0..3 {
            let low = by[k].max(0.0);
            let high = (by[k] + other[k] as f64).min(sizes[k] as f64);
            volume *= high - low;
            centre[k] = 0.5 * (low + high) - 0.5;
        }
        let [contact] = bodies[..] else { panic!("{bodies:?}") };
        assert!((contact.overlap - volume).abs() < 1e-11 * volume, "{} {volume}", contact.overlap);
        assert!((0..3).all(|k| (contact.point[k] - centre[k]).abs() < 1e-11), "{contact:?} {centre:?}");
    }
    // Blocks side by side with separate nodes.
    let (_, bodies) = together(block(sizes, 1), &block(other, 2), [4.0, 0.0, 0.0]).found();
    assert_eq!((bodies[0].overlap, bodies[0].shared, bodies[0].normal), (0.0, 6.0, [1.0, 0.0, 0.0]));
}

// ---------------------------------------------------------------- degenerate

#[test]
fn nothing_and_one_element_have_no_contacts() {
    assert_eq!(contacts(&MeshView::<2, 3>::new(&[], &[], &[]).unwrap()).unwrap(), []);
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let one = MeshView::new(&points, &[[0, 1, 2, 3]], &[9]).unwrap();
    assert_eq!(contacts(&one).unwrap(), []);
    assert_eq!(body_contacts(&one, &[]).unwrap(), []);
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let error = MeshView::new(&points, &[[0, 1, 2], [0, 3, 2]], &[0, 1]).unwrap_err();
    assert_eq!(error, DiscretisedError::UnknownNode { element: 1, node: 3, nodes: 3 });
    let error = MeshView::new(&points, &[[0, 1, 2]], &[0, 1]).unwrap_err();
    assert_eq!(error, DiscretisedError::Bodies { elements: 1, found: 2 });
    for bad in [f64::NAN, f64::NEG_INFINITY, 1e-200, 1e200] {
        let error = MeshView::new(&[[0.0, 0.0], [1.0, bad]], &[[0, 0, 1]], &[0]).unwrap_err();
        assert!(matches!(error, DiscretisedError::Coordinate { node: 1, axis: 1, .. }), "{error}");
        assert!(error.to_string().starts_with("node 1, axis 1: "), "{error}");
    }
    let error = MeshSearch::<2>::new().with_threads(100_000).unwrap_err();
    assert!(matches!(error, DiscretisedError::Search(Error::NoThreads { .. })), "{error}");
}

#[test]
fn coincident_bodies_overlap_in_pairs() {
    let one = squares(&[1, 1, 0, 1], [2, 2]);
    let mut parts = one.clone();
    for body in 2..=40 {
        let copy = Parts { bodies: vec![body; one.bodies.len()], ..one.clone() };
        parts = together(parts, &copy, [0.0; 2]);
    }
    let (_, bodies) = parts.found();
    assert_eq!(bodies.len(), 40 * 39 / 2);
    for contact in bodies {
        assert!((contact.overlap - 3.0).abs() < 1e-12, "{contact:?}");
        assert_eq!(contact.shared, 8.0, "all around");
    }
}

#[test]
fn elements_without_area_touch_as_what_they_are() {
    let points = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [1.0, 1.0], [9.0, 9.0], [8.0, 9.0]];
    // A triangle, a point in it, a segment that leaves it, and a segment outside.
    let elements = [[0, 1, 2], [3, 3, 3], [3, 4, 3], [4, 5, 5]];
    let mesh = MeshView::new(&points, &elements, &[0, 1, 2, 3]).unwrap();
    let found = contacts(&mesh).unwrap();
    let couples: Vec<_> = found.iter().map(|c| (c.i, c.j)).collect();
    assert_eq!(couples, [(0, 1), (0, 2), (1, 2), (2, 3)]);
    assert!(found.iter().all(|c| c.contact.measure == Measure::Area(0.0)));
    let bodies = body_contacts(&mesh, &found).unwrap();
    assert_eq!(bodies[0].point, [1.0, 1.0]);
    assert!(bodies.iter().all(|c| (c.couples, c.overlap, c.shared) == (1, 0.0, 0.0)));
    // A triangle, given as a tetrahedron that names a node twice, on the face of another tetrahedron.
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mesh = MeshView::new(&points, &[[0, 1, 2, 3], [0, 1, 2, 2]], &[0, 1]).unwrap();
    let found = contacts(&mesh).unwrap();
    assert_eq!((found.len(), found[0].contact.measure), (1, Measure::Volume(0.0)));
}

// ---------------------------------------------------------------- spheres

/// The faces of a cube of edge 1, each of 2 n² triangles; every two opposite faces are a body.
fn walls(n: usize) -> Parts<3, 3> {
    let mut parts = Parts { points: Vec::new(), elements: Vec::new(), bodies: Vec::new() };
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let first = parts.points.len();
            for a in 0..=n {
                for b in 0..=n {
                    let mut point = [side; 3];
                    point[(axis + 1) % 3] = a as f64 / n as f64;
                    point[(axis + 2) % 3] = b as f64 / n as f64;
                    parts.points.push(point);
                }
            }
            for a in 0..n {
                for b in 0..n {
                    let node = |a: usize, b: usize| (first + a * (n + 1) + b) as u32;
                    let [p, q, r, s] = [node(a, b), node(a + 1, b), node(a + 1, b + 1), node(a, b + 1)];
                    parts.elements.extend([[p, q, r], [p, r, s]]);
                    parts.bodies.extend([axis as u32; 2]);
                }
            }
        }
    }
    parts
}

#[test]
fn spheres_touch_each_wall_once() {
    let mut rng = SplitMix64(8);
    let walls = walls(6);
    // Positions inside and outside, many of them exactly at a wall or at an edge of it.
    let grid = |rng: &mut SplitMix64| (rng.index(29) as f64 - 2.0) / 24.0;
    let centres: Vec<[f64; 3]> = (0..3000)
        .map(|k| std::array::from_fn(|_| if k % 2 == 0 { grid(&mut rng) } else { rng.unit() }))
        .collect();
    let radii: Vec<f64> =
        (0..3000).map(|k| if k % 7 == 0 { 1.0 / 12.0 } else { 0.15 * rng.unit() }).collect();
    let mesh = walls.mesh();
    let shapes: Vec<_> = (0..mesh.len()).map(|k| Triangle::new(mesh.vertices(k)).unwrap()).collect();
    let mut expected = Vec::new();
    for (sphere, (&centre, &radius)) in centres.iter().zip(&radii).enumerate() {
        let ball = Sphere::new(centre, radius).unwrap();
        let mut of_planes = 0;
        for body in 0..3_u32 {
            let candidates: Vec<u32> =
                (0..mesh.len() as u32).filter(|&k| walls.bodies[k as usize] == body).collect();
            let mut found = Vec::new();
            sphere_mesh(&ball, &shapes, &candidates, &mut found).unwrap();
            of_planes += found.len();
            expected.extend(found.into_iter().map(|contact| (sphere as u32, body, contact)));
        }
        // Inside the box each plane in reach is touched once, regardless of its triangles.
        if sphere % 2 == 1 {
            let planes =
                centre.iter().flat_map(|&x| [x, 1.0 - x]).filter(|&distance| distance <= radius).count();
            assert_eq!(of_planes, planes, "{centre:?} {radius}");
        }
    }
    assert!(expected.len() > 1000, "{}", expected.len());
    let mut all = Vec::new();
    for engine in ENGINES {
        for threads in [1, 3] {
            let mut search = MeshSearch::new().with_engine(engine).with_threads(threads).unwrap();
            let mut found = Vec::new();
            search.sphere_contacts(&centres, &radii, &mesh, &mut found).unwrap();
            let listed: Vec<_> = found.iter().map(|c| (c.sphere, c.body, c.contact)).collect();
            assert!(listed == expected, "{engine:?} {threads}");
            all = found;
        }
    }
    // The check knows nothing of engines and threads, and all of them found the same.
    let checked = MeshSearch::verify_spheres(&centres, &radii, &mesh, &all, 50, 1).unwrap();
    assert_eq!(checked, Ok(50));
    all.pop();
    assert!(MeshSearch::verify_spheres(&centres, &radii, &mesh, &all, 3000, 1).unwrap().is_err());
}

#[test]
fn bad_spheres_are_refused_by_name() {
    let walls = walls(1);
    let mut search = MeshSearch::new();
    let mut found = Vec::new();
    let error = search.sphere_contacts(&[[0.0; 3]], &[], &walls.mesh(), &mut found).unwrap_err();
    assert_eq!(error, DiscretisedError::Radii { spheres: 1, found: 0 });
    let error = search
        .sphere_contacts(&[[0.0; 3], [0.0, f64::NAN, 0.0]], &[1.0; 2], &walls.mesh(), &mut found)
        .unwrap_err();
    assert!(matches!(error, DiscretisedError::Sphere { index: 1, .. }), "{error}");
    search.sphere_contacts(&[], &[], &walls.mesh(), &mut found).unwrap();
    assert_eq!(found, []);
    let none = MeshView::new(&[], &[], &[]).unwrap();
    search.sphere_contacts(&[[0.0; 3]], &[1.0], &none, &mut found).unwrap();
    assert_eq!(found, []);
}

// ---------------------------------------------------------------- grains

/// A disc of 96 sides, cut into the Voronoi cells of seeds in it.
struct Disc {
    seeds: Vec<[f64; 2]>,
    /// The corners of each cell, and its neighbour on the side that starts there: a cell, or `seeds` plus the
    /// number of the side of the disc.
    cells: Vec<Vec<([f64; 2], usize)>>,
}

const SIDES: usize = 96;

impl Disc {
    fn cut(seeds: Vec<[f64; 2]>) -> Self {
        let corner = |k: usize| {
            let angle = k as f64 / SIDES as f64 * std::f64::consts::TAU;
            [angle.cos(), angle.sin()]
        };
        let cell = |&seed: &[f64; 2]| {
            let mut cell: Vec<_> = (0..SIDES).map(|k| (corner(k), seeds.len() + k)).collect();
            for (other, &at) in seeds.iter().enumerate().filter(|(_, at)| **at != seed) {
                // The point is nearer to the seed than to the other one: the sign of the distance from the
                // bisector.
                let (u, v) = (at[0] - seed[0], at[1] - seed[1]);
                let (x, y) = (0.5 * (at[0] + seed[0]), 0.5 * (at[1] + seed[1]));
                let side = |p: [f64; 2]| u * (p[0] - x) + v * (p[1] - y);
                let mut cut = Vec::new();
                for (k, &(p, label)) in cell.iter().enumerate() {
                    let q = cell[(k + 1) % cell.len()].0;
                    let (from, to) = (side(p), side(q));
                    let t = from / (from - to);
                    let between = [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
                    match (from < 0.0, to < 0.0) {
                        (true, true) => cut.push((p, label)),
                        (true, false) => cut.extend([(p, label), (between, other)]),
                        (false, true) => cut.push((between, label)),
                        (false, false) => {}
                    }
                }
                cell = cut;
            }
            cell
        };
        let cells = seeds.iter().map(cell).collect();
        Self { seeds, cells }
    }

    /// Moves seeds to the centroids of their cells several times, which gives cells of similar sizes without
    /// short sides.
    fn relaxed(rng: &mut SplitMix64, grains: usize) -> Self {
        let mut seeds = Vec::new();
        while seeds.len() < grains {
            let p = [2.0 * rng.unit() - 1.0, 2.0 * rng.unit() - 1.0];
            if p[0] * p[0] + p[1] * p[1] < 0.99 {
                seeds.push(p);
            }
        }
        for _ in 0..30 {
            let outlines = Self::cut(seeds).cells;
            seeds =
                outlines.iter().map(|cell| centroid(&cell.iter().map(|c| c.0).collect::<Vec<_>>())).collect();
        }
        Self::cut(seeds)
    }

    /// The pairs of cells with a common side, and its length.
    fn adjacency(&self) -> BTreeMap<[u32; 2], f64> {
        let mut pairs = BTreeMap::new();
        for (i, cell) in self.cells.iter().enumerate() {
            for (k, &(p, j)) in cell.iter().enumerate() {
                if i < j && j < self.seeds.len() {
                    let q = cell[(k + 1) % cell.len()].0;
                    pairs.insert([i as u32, j as u32], (p[0] - q[0]).hypot(p[1] - q[1]));
                }
            }
        }
        pairs
    }

    /// The length of the shortest boundary of any cell with another cell or with the outside.
    fn shortest(&self) -> f64 {
        let mut lengths = BTreeMap::new();
        for (i, cell) in self.cells.iter().enumerate() {
            for (k, &(p, j)) in cell.iter().enumerate() {
                let q = cell[(k + 1) % cell.len()].0;
                *lengths.entry((i, j.min(self.seeds.len()))).or_insert(0.0) +=
                    (p[0] - q[0]).hypot(p[1] - q[1]);
            }
        }
        lengths.into_values().fold(f64::INFINITY, f64::min)
    }

    /// Meshes each cell as a fan of triangles around its seed. A corner is identified by the three cells, or
    /// sides of the disc, that meet there, so cells share their nodes. Elements are shuffled.
    fn mesh(&self, rng: &mut SplitMix64) -> Parts<2, 3> {
        let mut parts = Parts { points: self.seeds.clone(), elements: Vec::new(), bodies: Vec::new() };
        let mut nodes = BTreeMap::new();
        for (i, cell) in self.cells.iter().enumerate() {
            let corners: Vec<u32> = (0..cell.len())
                .map(|k| {
                    let mut meet = [i, cell[k].1, cell[(k + cell.len() - 1) % cell.len()].1];
                    meet.sort_unstable();
                    *nodes.entry(meet).or_insert_with(|| {
                        parts.points.push(cell[k].0);
                        parts.points.len() as u32 - 1
                    })
                })
                .collect();
            for k in 0..corners.len() {
                let at = rng.index(parts.elements.len() + 1);
                parts.elements.insert(at, [i as u32, corners[k], corners[(k + 1) % corners.len()]]);
                parts.bodies.insert(at, i as u32);
            }
        }
        parts
    }

    /// The disc as an image of `pixels` times `pixels`: the number of the nearest seed, from 1, or 0 outside.
    fn image(&self, pixels: usize) -> Vec<u16> {
        let apothem = (std::f64::consts::PI / SIDES as f64).cos();
        let normals: Vec<[f64; 2]> = (0..SIDES)
            .map(|k| {
                let angle = (k as f64 + 0.5) / SIDES as f64 * std::f64::consts::TAU;
                [angle.cos(), angle.sin()]
            })
            .collect();
        let place = |k: usize| (k as f64 + 0.5) / pixels as f64 * 2.0 - 1.0;
        let label = |at: usize| {
            let p = [place(at % pixels), place(at / pixels)];
            let near = p[0] * p[0] + p[1] * p[1] < apothem * apothem;
            let inside = near || normals.iter().all(|n| p[0] * n[0] + p[1] * n[1] <= apothem);
            if !inside {
                return 0;
            }
            let distance = |seed: [f64; 2]| (seed[0] - p[0]).powi(2) + (seed[1] - p[1]).powi(2);
            let nearest = (0..self.seeds.len())
                .min_by(|&a, &b| distance(self.seeds[a]).total_cmp(&distance(self.seeds[b])))
                .unwrap();
            nearest as u16 + 1
        };
        (0..pixels * pixels).map(label).collect()
    }
}

fn centroid(outline: &[[f64; 2]]) -> [f64; 2] {
    let (mut area, mut sum) = (0.0, [0.0; 2]);
    for (k, p) in outline.iter().enumerate() {
        let q = outline[(k + 1) % outline.len()];
        let cross = p[0] * q[1] - p[1] * q[0];
        area += cross;
        sum = [sum[0] + cross * (p[0] + q[0]), sum[1] + cross * (p[1] + q[1])];
    }
    sum.map(|x| x / (3.0 * area))
}

/// Wherever three grains meet at a corner, every two of them share a side as well, so here "touch" and "share
/// a length" mean the same. In the image, boundaries shorter than a few pixels can be missed, so discs with
/// such boundaries are skipped.
#[test]
fn grains_of_a_disc_touch_as_the_cells_and_as_in_its_image() {
    let mut rng = SplitMix64(9);
    for (grains, pixels) in [(12, 400), (40, 800), (90, 1200)] {
        let pixel = 2.0 / pixels as f64;
        let disc = std::iter::repeat_with(|| Disc::relaxed(&mut rng, grains))
            .take(200)
            .find(|disc| disc.shortest() > 3.0 * pixel)
            .expect("one of 200 discs has no short sides");
        let adjacency = disc.adjacency();
        let expected: Vec<_> = adjacency.keys().copied().collect();
        assert!(expected.len() > 2 * grains, "about three neighbours for two grains");

        let (found, bodies) = disc.mesh(&mut rng).found();
        assert_eq!(bodies.iter().map(|c| c.bodies).collect::<Vec<_>>(), expected, "of the mesh");
        assert!(found.len() > expected.len(), "elements meet at corners too");
        for (contact, length) in bodies.iter().zip(adjacency.values()) {
            assert_eq!(contact.overlap, 0.0, "meshed conformingly");
            assert!((contact.shared - length).abs() < 1e-12, "{contact:?} {length}");
            let [a, b] = contact.bodies.map(|body| disc.seeds[body as usize]);
            // A side of Voronoi cells is perpendicular to the line between their seeds.
            let distance = (b[0] - a[0]).hypot(b[1] - a[1]);
            for k in 0..2 {
                assert!((contact.normal[k] - (b[k] - a[k]) / distance).abs() < 1e-9, "{contact:?}");
            }
        }

        let image = image::contacts(&disc.image(pixels), [pixels; 2], Neighbourhood::Face).unwrap();
        let labels: Vec<_> = image.iter().map(|c| c.labels().map(|label| u32::from(label) - 1)).collect();
        assert_eq!(labels, expected, "of the image");
    }
}

/// At a corner where four grains meet, opposite grains touch but share nothing.
#[test]
fn opposite_grains_at_a_corner_share_no_length() {
    let (_, bodies) = squares(&[1, 2, 3, 4], [2, 2]).found();
    let shared: Vec<_> = bodies.iter().map(|c| (c.bodies, c.shared)).collect();
    assert_eq!(
        shared,
        [([1, 2], 1.0), ([1, 3], 1.0), ([1, 4], 0.0), ([2, 3], 0.0), ([2, 4], 1.0), ([3, 4], 1.0)]
    );
}

/// Two overlapping discs of grains: the common area of every two grains equals that of their outlines, by
/// `geo`.
#[test]
fn overlapping_grains_have_the_area_of_their_outlines() {
    let mut rng = SplitMix64(10);
    let (one, two) = (Disc::relaxed(&mut rng, 40), Disc::relaxed(&mut rng, 50));
    let by = [0.3, -0.2];
    let mut above = two.mesh(&mut rng);
    above.bodies.iter_mut().for_each(|body| *body += 40);
    let (_, bodies) = together(one.mesh(&mut rng), &above, by).found();
    let outline = |cell: &[([f64; 2], usize)], by: [f64; 2]| {
        let ring: Vec<Coord> = cell.iter().map(|(p, _)| Coord { x: p[0] + by[0], y: p[1] + by[1] }).collect();
        Polygon::new(LineString::from(ring), Vec::new())
    };
    let found: BTreeMap<_, _> = bodies.iter().map(|c| (c.bodies, c.overlap)).collect();
    let (mut pairs, mut total) = (0, 0.0);
    for (i, cell) in one.cells.iter().enumerate() {
        for (j, other) in two.cells.iter().enumerate() {
            let area = outline(cell, [0.0; 2]).intersection(&outline(other, by)).unsigned_area();
            let overlap = found.get(&[i as u32, 40 + j as u32]).copied().unwrap_or(0.0);
            // `geo` rounds coordinates to a grid of integers.
            assert!((area - overlap).abs() < 1e-7, "{i} {j}: {area} {overlap}");
            pairs += usize::from(overlap > 1e-6);
            total += overlap;
        }
    }
    assert!(pairs > 100 && total > 2.0, "{pairs} {total}");
}
