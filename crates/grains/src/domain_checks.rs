//! Checks of the box of a model.

use crate::error::GrainError;
use crate::model::{GrainModel, within};

impl GrainModel {
    /// Checks the numbers of the box and of its servo.
    pub(crate) fn check_box(&self) -> Result<(), GrainError> {
        let Some(domain) = &self.domain else { return Ok(()) };
        for (axis, (low, high)) in domain.low.into_iter().zip(domain.high).enumerate() {
            let place = || format!("the box along {}", ["x", "y", "z"][axis]);
            within(place, "lower side", low, low.is_finite(), "finite")?;
            within(
                place,
                "upper side",
                high,
                high.is_finite() && high > low,
                "finite, above the lower side",
            )?;
        }
        let from = domain.strain_from;
        within(|| "the box".to_owned(), "time of strain rates", from, from >= 0.0, "at least 0")?;
        let Some(servo) = &domain.servo else { return Ok(()) };
        let place = || "the servo of the box".to_owned();
        within(place, "largest rate", servo.largest_rate, servo.largest_rate > 0.0, "above 0")?;
        for axis in 0..3 {
            let Some(pressure) = servo.pressures[axis] else { continue };
            let place = || format!("the servo of the box along {}", ["x", "y", "z"][axis]);
            let range = "at least 0, along an axis that repeats and has no strain rate at the beginning";
            let is_free = domain.periodic[axis] && (domain.strain_rates[axis] == 0.0 || from > 0.0);
            within(place, "pressure", pressure, pressure >= 0.0 && is_free, range)?;
        }
        Ok(())
    }
}
