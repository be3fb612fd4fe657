//! The surface of bodies that spheres touch.

use crate::error::GrainError;

/// The outer surface of bodies at the time of the spheres: triangles in space, segments in the plane.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Points of the surface, m; with discs z is 0. Facets that hang together have common points.
    pub points: &'a [[f64; 3]],
    /// Velocities of the points, m/s.
    pub velocities: &'a [[f64; 3]],
    /// Facets by their points, counter-clockwise seen from outside. With discs two points, in the order in
    /// which the body is on their left, and the second once more.
    pub facets: &'a [[u32; 3]],
    /// Number of the material of each facet.
    pub materials: &'a [u32],
}

impl Surface<'_> {
    /// Checks that the lists fit each other.
    pub(crate) fn check(&self, materials: usize) -> Result<(), GrainError> {
        let [points, facets] = [self.points.len(), self.facets.len()];
        for (what, found, expected) in [
            ("velocities of points of the surface", self.velocities.len(), points),
            ("materials of facets of the surface", self.materials.len(), facets),
        ] {
            if found != expected {
                return Err(GrainError::Length { what, found, expected });
            }
        }
        for (facet, (corners, &material)) in self.facets.iter().zip(self.materials).enumerate() {
            let place = || format!("facet {facet} of the surface");
            if let Some(&point) = corners.iter().find(|&&point| point as usize >= points) {
                return Err(GrainError::Point { place: place(), point });
            }
            if material as usize >= materials {
                return Err(GrainError::Material { place: place(), material });
            }
        }
        Ok(())
    }
}
