//! Spheres and walls of a model that is ready to run.

use std::fmt;

use fdem_io::numbers::{brief, grouped};
use serde::Serialize;

/// The spheres and walls, for messages before a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PreparedSpheres {
    /// The spheres of each `[[grains]]` table.
    pub groups: Vec<SphereGroup>,
    /// The spheres of each `[[insertion]]` table.
    pub insertions: Vec<ComingSpheres>,
    /// The boxes of the `[[delete]]` tables.
    pub removals: Vec<PreparedRemoval>,
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
    /// Number of clumps that they form; 0 of single spheres.
    #[serde(skip_serializing_if = "is_zero")]
    pub clumps: usize,
    /// Smallest and largest radius, m.
    pub radii: [f64; 2],
    /// Mass, kg.
    pub mass: f64,
    /// Share of their region that they fill; `None` without a region.
    pub fraction: Option<f64>,
}

/// The spheres of a table that come in during the run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComingSpheres {
    /// Name of the table.
    pub name: String,
    /// Number of spheres.
    pub count: usize,
    /// Smallest and largest radius, m.
    pub radii: [f64; 2],
    /// Mass, kg.
    pub mass: f64,
    /// Time at which the first one comes in, s.
    pub from: f64,
    /// Spheres in a second, 1/s; `None` for all at once.
    pub rate: Option<f64>,
    /// Number of spheres that come in until the end time of the run, if there is room.
    pub by_end: usize,
}

/// A box in which spheres are removed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreparedRemoval {
    /// Name of the table.
    pub name: String,
    /// Time from which it removes spheres, s.
    pub from: f64,
    /// Time until which it does so, s; `None` for the end of the run.
    pub until: Option<f64>,
}

/// Whether a count is left out of the JSON.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
pub(crate) fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// `radius 0.01 m`, or `radii 0.001 to 0.002 m`.
fn in_words([least, most]: [f64; 2]) -> String {
    if least == most {
        format!("radius {} m", brief(least))
    } else {
        format!("radii {} to {} m", brief(least), brief(most))
    }
}

/// `sand: 5,000, radii 0.001 to 0.002 m, solid fraction 0.55, 1.2 kg`.
impl fmt::Display for SphereGroup {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {}", self.name, grouped(self.count as u64))?;
        if self.clumps > 0 {
            let plural = if self.clumps == 1 { "" } else { "s" };
            write!(out, " in {} clump{plural}", grouped(self.clumps as u64))?;
        }
        write!(out, ", {}", in_words(self.radii))?;
        if let Some(fraction) = self.fraction {
            write!(out, ", solid fraction {}", brief((1e3 * fraction).round() / 1e3))?;
        }
        write!(out, ", {} kg", brief(self.mass))
    }
}

/// `rain: 500 to come from 0.1 s, 1000 a second, 300 by end_time, radius 0.01 m, 5.2 kg`.
impl fmt::Display for ComingSpheres {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = grouped(self.count as u64);
        write!(out, "{}: {count} to come from {} s", self.name, brief(self.from))?;
        match self.rate {
            Some(rate) => write!(out, ", {} a second", brief(rate))?,
            None => out.write_str(", all at once")?,
        }
        if self.by_end < self.count {
            write!(out, ", {} by end_time", grouped(self.by_end as u64))?;
        }
        write!(out, ", {}, {} kg", in_words(self.radii), brief(self.mass))
    }
}

/// `hole: removes spheres from 0.1 s until 0.2 s`.
impl fmt::Display for PreparedRemoval {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: removes spheres from {} s", self.name, brief(self.from))?;
        self.until.map_or(Ok(()), |until| write!(out, " until {} s", brief(until)))
    }
}
