//! A sphere against a mesh; each face, edge and vertex counts once.

use std::collections::BTreeMap;

use super::contact::Contact;
use super::error::ShapeError;
use super::shapes::{Sphere, Triangle};
use super::sphere::{Feature, sphere_triangle};
use super::vector::distance_squared;

/// A contact of a sphere with a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshContact {
    /// The triangle of the mesh that has the contact; if there are several, the one with the smallest number.
    pub triangle: u32,
    /// The feature of that triangle.
    pub feature: Feature,
    /// The contact; never a gap.
    pub contact: Contact<3>,
}

/// Contacts whose points are closer than this times the radius are joined. This joins contacts that rounding
/// of the vertices has split: two triangles that should be in one plane may have a fold of 1e-16 between
/// them, and a sphere above the fold then touches both.
const SAME_POINT: f64 = 1e-9;

/// The contacts of a sphere with a mesh of triangles, in ascending order of triangles. No face, edge or
/// vertex counts twice.
///
/// A contact is a point of the mesh where the distance to the centre has a local minimum. Therefore a contact
/// at an edge counts once, and only if no triangle with that edge comes closer; likewise at a vertex. A
/// sphere on a flat wall has one contact at any position; in a corner it has one contact with each wall.
/// Triangles are neighbours if they have vertices with equal coordinates, so the mesh may be indexed or not.
///
/// # Shapes
/// `mesh` `[n]` holds all triangles. `candidates` `[k]` holds at least the numbers of those whose boxes the
/// sphere touches, each at least once. `contacts` is cleared, then filled. If `candidates` lacks a triangle
/// that the sphere touches, a contact may be returned that this triangle would have removed.
///
/// # Cost
/// Time proportional to `k log k`.
///
/// # Errors
/// [`ShapeError::UnknownTriangle`].
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Feature, MeshContact, Sphere, Triangle, sphere_mesh};
///
/// let (a, b, c, d) = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
/// let floor = [Triangle::new([a, b, c])?, Triangle::new([a, c, d])?];
/// let mut contacts = Vec::new();
/// sphere_mesh(&Sphere::new([0.5, 0.5, 0.9], 1.0)?, &floor, &[0, 1], &mut contacts)?;
/// assert!(matches!(contacts[..], [MeshContact { triangle: 0, feature: Feature::Edge(2), .. }]));
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn sphere_mesh(
    sphere: &Sphere<3>,
    mesh: &[Triangle<3>],
    candidates: &[u32],
    contacts: &mut Vec<MeshContact>,
) -> Result<(), ShapeError> {
    contacts.clear();
    for &triangle in candidates {
        let Some(shape) = mesh.get(triangle as usize) else {
            return Err(ShapeError::UnknownTriangle { triangle, triangles: mesh.len() });
        };
        let (contact, feature) = sphere_triangle(sphere, shape);
        if contact.touches() {
            contacts.push(MeshContact { triangle, feature, contact });
        }
    }
    contacts.sort_by_key(|c| c.triangle);
    contacts.dedup_by_key(|c| c.triangle);

    // The closest triangle at every vertex and edge; among equally close ones the first, since only a smaller
    // distance replaces it.
    let squared = |c: &MeshContact| distance_squared(c.contact.point, sphere.centre);
    let mut vertices = BTreeMap::new();
    let mut edges = BTreeMap::new();
    for hit in contacts.iter() {
        let (place, shape) = ((squared(hit), hit.triangle), &mesh[hit.triangle as usize]);
        for k in 0..3 {
            closer(&mut vertices, vertex(shape, k), place);
            closer(&mut edges, edge(shape, k), place);
        }
    }
    contacts.retain(|hit| {
        let shape = &mesh[hit.triangle as usize];
        let closest = match hit.feature {
            Feature::Face => return true,
            Feature::Edge(k) => edges.get(&edge(shape, k)),
            Feature::Vertex(k) => vertices.get(&vertex(shape, k)),
        };
        closest.is_some_and(|&(_, triangle)| triangle == hit.triangle)
    });
    join(contacts, SAME_POINT * sphere.radius);
    Ok(())
}

type Point = [u64; 3];

/// A vertex as a key; both zeros are equal.
fn vertex(triangle: &Triangle<3>, k: u8) -> Point {
    triangle.vertices[usize::from(k)].map(|x| (x + 0.0).to_bits())
}

fn edge(triangle: &Triangle<3>, k: u8) -> [Point; 2] {
    let mut ends = [vertex(triangle, k), vertex(triangle, (k + 1) % 3)];
    ends.sort_unstable();
    ends
}

fn closer<K: Ord>(closest: &mut BTreeMap<K, (f64, u32)>, key: K, place: (f64, u32)) {
    let best = closest.entry(key).or_insert(place);
    if place.0 < best.0 {
        *best = place;
    }
}

/// Keeps one of several contacts whose points are within a distance of each other: that of the first
/// triangle.
fn join(contacts: &mut Vec<MeshContact>, within: f64) {
    let mut order: Vec<usize> = (0..contacts.len()).collect();
    order.sort_by(|&i, &j| contacts[i].contact.point[0].total_cmp(&contacts[j].contact.point[0]));
    let mut dropped = vec![false; contacts.len()];
    for (k, &i) in order.iter().enumerate() {
        let p = contacts[i].contact.point;
        for &j in &order[k + 1..] {
            let q = contacts[j].contact.point;
            if q[0] - p[0] > within {
                break;
            }
            if !dropped[i] && !dropped[j] && distance_squared(p, q) <= within * within {
                dropped[i.max(j)] = true;
            }
        }
    }
    let mut dropped = dropped.into_iter();
    contacts.retain(|_| dropped.next() == Some(false));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One unit square of two triangles per cell of a square, at a height that depends on x.
    fn strip(cells: i32, height: impl Fn(f64) -> f64) -> Vec<Triangle<3>> {
        let at = |x: i32, y: i32| [f64::from(x), f64::from(y), height(f64::from(x))];
        let mut mesh = Vec::new();
        for x in -cells..cells {
            for y in -cells..cells {
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                mesh.push(Triangle::new([a, b, c]).unwrap());
                mesh.push(Triangle::new([d, a, c]).unwrap());
            }
        }
        mesh
    }

    fn contacts(centre: [f64; 3], radius: f64, mesh: &[Triangle<3>]) -> Vec<MeshContact> {
        let all: Vec<u32> = (0..mesh.len() as u32).collect();
        let mut contacts = Vec::new();
        sphere_mesh(&Sphere::new(centre, radius).unwrap(), mesh, &all, &mut contacts).unwrap();
        contacts
    }

    #[test]
    fn a_sphere_on_a_flat_wall_has_one_contact_wherever_it_stands() {
        let flat = strip(4, |_| 0.0);
        let tilted = strip(4, |x| 0.3 * x);
        for step in 0..=40 {
            for other in 0..=40 {
                let (x, y) = (f64::from(step) / 40.0, f64::from(other) / 40.0);
                assert_eq!(contacts([x, y, 1.4], 1.5, &flat).len(), 1, "{x} {y}");
                assert_eq!(contacts([x, y, 0.3 * x + 1.4], 1.5, &tilted).len(), 1, "tilted, {x} {y}");
            }
        }
    }

    #[test]
    fn a_ridge_is_one_contact_and_a_valley_two() {
        let ridge = strip(3, |x| -x.abs());
        let valley = strip(3, f64::abs);
        for y in [0.0, 0.25, 0.5] {
            assert_eq!(contacts([0.0, y, 0.9], 1.0, &ridge).len(), 1, "{y}");
            assert_eq!(contacts([0.0, y, 1.0], 1.0, &valley).len(), 2, "{y}");
        }
    }

    #[test]
    fn the_tip_of_a_pyramid_is_one_contact_at_the_first_triangle() {
        let corners = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]];
        let mesh: Vec<_> = (0..4)
            .map(|k| Triangle::new([corners[k], corners[(k + 1) % 4], [0.0, -0.0, 1.0]]).unwrap())
            .collect();
        let found = contacts([0.0, 0.0, 1.5], 1.0, &mesh);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].triangle, found[0].feature), (0, Feature::Vertex(2)));
    }

    #[test]
    fn repeated_candidates_and_repeated_triangles_are_one_contact() {
        let triangle = Triangle::new([[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]).unwrap();
        let mut found = Vec::new();
        let ball = Sphere::new([1.0, 1.0, 0.5], 1.0).unwrap();
        sphere_mesh(&ball, &[triangle, triangle], &[1, 0, 1, 0], &mut found).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].triangle, 0);
        let error = sphere_mesh(&ball, &[triangle], &[0, 7], &mut found).unwrap_err();
        assert_eq!(error, ShapeError::UnknownTriangle { triangle: 7, triangles: 1 });
    }
}
