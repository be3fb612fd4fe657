//! Surfaces from loose triangles.

use std::collections::BTreeMap;

use super::hull::number_faces;
use crate::tetrahedra::{MeshError, OUTSIDE, Surface, finite};

impl Surface {
    /// The surface of loose triangles, as in STL files: counter-clockwise seen from outside.
    ///
    /// Equal points become one node; triangles with two equal corners are left out. Neighbours with an angle
    /// of less than `angle` degrees between their normals are of one face. Whether the surface is closed and
    /// does not cross itself is found out when it is meshed, or by [`Surface::check`].
    ///
    /// # Errors
    /// [`MeshError::NotFinite`] with the number of the corner, three for each triangle; [`MeshError::Empty`].
    pub fn from_triangles(triangles: &[[[f64; 3]; 3]], angle: f64) -> Result<Self, MeshError> {
        finite(triangles.as_flattened())?;
        let mut surface = Self::default();
        let mut known: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        for triangle in triangles {
            let facet = triangle.map(|point| {
                // Adding 0 makes −0 the same as 0.
                let point = point.map(|x| x + 0.0);
                *known.entry(point.map(f64::to_bits)).or_insert_with(|| {
                    surface.nodes.push(point);
                    surface.nodes.len() as u32 - 1
                })
            });
            if facet[0] != facet[1] && facet[1] != facet[2] && facet[2] != facet[0] {
                surface.facets.push(facet);
            }
        }
        if surface.facets.is_empty() {
            return Err(MeshError::Empty);
        }
        surface.sides = vec![[0, OUTSIDE]; surface.facets.len()];
        number_faces(&mut surface, libm::sin(angle.clamp(0.0, 90.0).to_radians()));
        Ok(surface)
    }
}
