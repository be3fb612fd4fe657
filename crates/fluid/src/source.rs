//! Sources: places where fluid is injected, at a rate or at a pressure.

use serde::{Deserialize, Serialize};

use crate::error::{FluidError, check};

/// A quantity that may change with the time: piecewise linear, and constant before its first and after its
/// last time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    times: Vec<f64>,
    values: Vec<f64>,
}

impl Schedule {
    /// The same value at all times.
    pub fn constant(value: f64) -> Self {
        Self { times: vec![0.0], values: vec![value] }
    }

    /// A table: times in s, which rise strictly, and as many values. [`Network::new`](crate::Network::new)
    /// refuses others.
    pub fn table(times: Vec<f64>, values: Vec<f64>) -> Self {
        Self { times, values }
    }

    /// The same with a time that begins at `start`, s.
    #[must_use]
    pub fn later(self, start: f64) -> Self {
        Self { times: self.times.into_iter().map(|time| time + start).collect(), values: self.values }
    }

    /// The value at a time.
    pub fn at(&self, time: f64) -> f64 {
        let after = self.times.partition_point(|&of| of <= time);
        if after == 0 || after == self.times.len() {
            return self.values[after.saturating_sub(1)];
        }
        let ([t0, t1], [v0, v1]) =
            ([self.times[after - 1], self.times[after]], [self.values[after - 1], self.values[after]]);
        v0 + (v1 - v0) * ((time - t0) / (t1 - t0))
    }

    /// The integral over the time, exact for lines.
    pub fn integral(&self, from: f64, to: f64) -> f64 {
        let inside = self.times.iter().copied().filter(|&time| time > from && time < to);
        let mut last = from;
        let mut sum = 0.0;
        for time in inside.chain([to]) {
            sum += (time - last) * 0.5 * (self.at(last) + self.at(time));
            last = time;
        }
        sum
    }

    fn check(&self, place: &str, what: &'static str, lowest: f64) -> Result<(), FluidError> {
        let (found, expected) = (self.values.len(), self.times.len());
        if found != expected || expected == 0 {
            return Err(FluidError::Length { what: "values of a table", found, expected: expected.max(1) });
        }
        for (k, &time) in self.times.iter().enumerate() {
            let rises = k == 0 || time > self.times[k - 1];
            check(rises, place, "time of the table", time, "later than the one before")?;
        }
        let range = "finite, and a pressure at least the lowest one of the fluid";
        self.values.iter().try_for_each(|&value| check(value >= lowest, place, what, value, range))
    }
}

/// The quantity that a source prescribes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    /// Volume that flows in, m³/s at the reference density, exactly integrated over a step. Fluid is taken
    /// out if it is negative, as far as there is some: [`Balance::missed`](crate::Balance::missed).
    Rate(Schedule),
    /// Pressure, Pa: its value at the end of a step.
    Pressure(Schedule),
}

impl Drive {
    /// The same with a time that begins at `start`, s.
    #[must_use]
    pub fn later(self, start: f64) -> Self {
        match self {
            Self::Rate(rate) => Self::Rate(rate.later(start)),
            Self::Pressure(pressure) => Self::Pressure(pressure.later(start)),
        }
    }

    /// `lowest`: the least pressure, Pa.
    pub(crate) fn check(&self, place: &str, lowest: f64) -> Result<(), FluidError> {
        match self {
            Self::Rate(rate) => rate.check(place, "rate", f64::NEG_INFINITY),
            Self::Pressure(pressure) => pressure.check(place, "pressure", lowest),
        }
    }
}

/// A place where fluid enters: a borehole, or some cells. Its volume and its wet cells have one pressure.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Identity of the source: no other one has it.
    pub key: u64,
    /// Keys of its cells.
    pub cells: Vec<u64>,
    /// Volume of its own, m³, such as that of a borehole; zero for none.
    pub volume: f64,
    /// The quantity that it prescribes; `None` for a volume that is only connected with its cells.
    pub drive: Option<Drive>,
    /// Pressure in its volume at the beginning, Pa; `None` if it is empty.
    pub initial_pressure: Option<f64>,
}

impl Source {
    pub(crate) fn check(&self, lowest: f64) -> Result<(), FluidError> {
        let place = format!("source {}", self.key);
        check(self.volume >= 0.0, &place, "volume", self.volume, "zero or positive")?;
        if let Some(pressure) = self.initial_pressure {
            let range = "at least the lowest one of the fluid";
            check(pressure >= lowest, &place, "initial pressure", pressure, range)?;
        }
        if self.cells.is_empty() && self.volume == 0.0 {
            return Err(FluidError::NoPlace { source: self.key });
        }
        self.drive.as_ref().map_or(Ok(()), |drive| drive.check(&place, lowest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_and_its_integral_exact() {
        let table = Schedule::table(vec![1.0, 2.0, 4.0], vec![0.0, 6.0, 2.0]);
        assert_eq!([0.0, 1.5, 2.0, 3.0, 9.0].map(|time| table.at(time)), [0.0, 3.0, 6.0, 4.0, 2.0]);
        // 0 + (3 + 8) + 2 until 5 s.
        assert_eq!(table.integral(0.0, 5.0), 13.0);
        assert_eq!(table.integral(1.0, 1.5) + table.integral(1.5, 3.0), table.integral(0.0, 3.0));
        assert_eq!(table.clone().later(2.0).at(3.5), table.at(1.5));
        assert_eq!(Schedule::constant(3.0).integral(1.0, 3.0), 6.0);
    }
}
