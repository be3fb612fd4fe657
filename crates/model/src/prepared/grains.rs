//! Spheres and walls of a model that is ready to run.

use serde::Serialize;

/// The spheres and walls, for messages before a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PreparedSpheres {
    /// The spheres of each `[[grains]]` table.
    pub groups: Vec<SphereGroup>,
    /// Names of the walls.
    pub walls: Vec<String>,
    /// Whether they are discs.
    pub discs: bool,
}

/// The spheres of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SphereGroup {
    /// Its name.
    pub name: String,
    /// Number of spheres.
    pub count: usize,
    /// Smallest and largest radius, m.
    pub radii: [f64; 2],
    /// Mass, kg.
    pub mass: f64,
    /// Share of their region that they fill; `None` without a region.
    pub fraction: Option<f64>,
}
