//! The surface of bodies that spheres touch.

/// The outer surface of bodies at the time of the spheres: triangles in space, segments in the plane.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Its points, m; with discs z is 0. Facets that hang together have common points.
    pub points: &'a [[f64; 3]],
    /// Their velocities, m/s.
    pub velocities: &'a [[f64; 3]],
    /// Facets by their points, counter-clockwise seen from outside. With discs two points, in the order in
    /// which the body is on their left, and the second once more.
    pub facets: &'a [[u32; 3]],
    /// Number of the material of each facet.
    pub materials: &'a [u32],
}
