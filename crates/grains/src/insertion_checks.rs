//! The spheres of a model that come in, and the boxes that remove them: whether they are possible.

use crate::error::GrainError;
use crate::model::{GrainModel, within};

impl GrainModel {
    /// Checks all insertions and removals.
    ///
    /// # Errors
    /// The first number that is wrong.
    pub(crate) fn check_insertions(&self) -> Result<(), GrainError> {
        for (number, of) in self.insertions.iter().enumerate() {
            let name = || {
                if of.name.is_empty() {
                    format!("insertion {number}")
                } else {
                    format!("insertion {}", of.name)
                }
            };
            if of.material as usize >= self.materials.len() {
                return Err(GrainError::Material { place: name(), material: of.material });
            }
            within(name, "time of its beginning", of.from, true, "a number")?;
            // All spheres come at once at an infinite rate.
            let rate = if of.rate == f64::INFINITY { f64::MAX } else { of.rate };
            within(name, "rate", rate, rate > 0.0, "above 0")?;
            for &x in of.region.iter().flatten().chain(&of.velocity).chain(&of.spin) {
                within(name, "a coordinate", x, true, "a number")?;
            }
            for &radius in &of.radii {
                within(name, "radius", radius, radius > 0.0, "above 0")?;
            }
            let largest = of.radii.iter().copied().fold(0.0, f64::max);
            let axes = if self.discs.is_some() { 2 } else { 3 };
            for axis in 0..axes {
                let extent = of.region[1][axis] - of.region[0][axis];
                let range = "at least the diameter of its largest sphere";
                within(name, "extent of its region", extent, extent >= 2.0 * largest, range)?;
            }
        }
        for (number, of) in self.removals.iter().enumerate() {
            let name = || {
                if of.name.is_empty() { format!("removal {number}") } else { format!("removal {}", of.name) }
            };
            let [low, high] = of.region;
            for axis in 0..3 {
                let extent = high[axis] - low[axis];
                let is_right = low[axis] <= high[axis];
                let extent = if extent == f64::INFINITY { f64::MAX } else { extent };
                within(name, "extent of its region", extent, is_right, "at least 0")?;
            }
            let lasts = of.times[1] - of.times[0];
            let lasts = if lasts == f64::INFINITY { f64::MAX } else { lasts };
            within(name, "duration", lasts, lasts >= 0.0, "at least 0")?;
        }
        Ok(())
    }
}
