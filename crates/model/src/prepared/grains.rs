//! Spheres and walls of a model that is ready to run.

use std::fmt;

use fdem_io::numbers::{brief, grouped};
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
    /// Name of the table.
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

/// `sand: 5,000, radii 0.001 to 0.002 m, solid fraction 0.55, 1.2 kg`.
impl fmt::Display for SphereGroup {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {}", self.name, grouped(self.count as u64))?;
        match self.radii {
            [least, most] if least == most => write!(out, ", radius {} m", brief(least))?,
            [least, most] => write!(out, ", radii {} to {} m", brief(least), brief(most))?,
        }
        if let Some(fraction) = self.fraction {
            write!(out, ", solid fraction {}", brief((1e3 * fraction).round() / 1e3))?;
        }
        write!(out, ", {} kg", brief(self.mass))
    }
}
