//! Convex hulls.

use super::round::hull_of;
use crate::tetrahedra::delaunay::Delaunay;
use crate::tetrahedra::order;
use crate::tetrahedra::vector::{cross, dot, length, normal, unit};
use crate::tetrahedra::{MeshError, OUTSIDE, Surface, finite};

/// The convex polyhedron around points. Points inside are left out; facets of one plane make one face,
/// without a name.
///
/// # Errors
/// [`MeshError::NotFinite`]; [`MeshError::Flat`] if all points are in a plane.
pub fn hull(points: &[[f64; 3]]) -> Result<Surface, MeshError> {
    finite(points)?;
    let order = order::rounds(&order::along_curve(points));
    let mesh = Delaunay::new(points, &order).ok_or(MeshError::Flat)?;
    let mut facets: Vec<[u32; 3]> = hull_of(&mesh).collect();
    facets.sort_unstable();
    let mut used: Vec<u32> = facets.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    for node in facets.iter_mut().flatten() {
        *node = used.binary_search(node).unwrap_or(0) as u32;
    }
    let nodes = used.iter().map(|&node| points[node as usize]).collect();
    let count = facets.len();
    let mut surface =
        Surface { nodes, facets, faces: vec![0; count], sides: vec![[0, OUTSIDE]; count], names: Vec::new() };
    number_faces(&mut surface, 1e-9);
    Ok(surface)
}

/// Gives facets one face that are neighbours with an angle between them whose sine is below `sine`.
pub(super) fn number_faces(surface: &mut Surface, sine: f64) {
    let mut edges: Vec<([u32; 2], usize)> = Vec::new();
    for (number, facet) in surface.facets.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], number));
        }
    }
    edges.sort_unstable();
    let normals: Vec<[f64; 3]> = (0..surface.facets.len())
        .map(|facet| {
            let [a, b, c] = surface.corners(facet);
            unit(normal(a, b, c))
        })
        .collect();
    let mut neighbours = vec![Vec::new(); surface.facets.len()];
    for pair in edges.chunk_by(|one, other| one.0 == other.0) {
        if let &[(_, one), (_, other)] = pair {
            let (m, n) = (normals[one], normals[other]);
            if dot(m, n) > 0.0 && length(cross(m, n)) <= sine {
                neighbours[one].push(other);
                neighbours[other].push(one);
            }
        }
    }
    let mut faces = vec![u32::MAX; surface.facets.len()];
    let mut next = 0;
    for first in 0..faces.len() {
        if faces[first] == u32::MAX {
            let mut open = vec![first];
            faces[first] = next;
            while let Some(facet) = open.pop() {
                for &other in &neighbours[facet] {
                    if faces[other] == u32::MAX {
                        faces[other] = next;
                        open.push(other);
                    }
                }
            }
            next += 1;
        }
    }
    surface.faces = faces;
}
