//! Numbers with a dimension.

use crate::text::values::units::{Dimension, Unit};

/// A number in SI units, angles in degrees, and its dimension.
///
/// The number is `value · 10^tens`. The power of ten is kept apart until the end, so that `"25 mm"` is the
/// same number to the last bit as 0.025, and `"2.7 g/cm^3"` as 2700.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Amount {
    value: f64,
    tens: i32,
    /// `None` for plain numbers, which fit any dimension.
    dimension: Option<Dimension>,
}

/// Dimensions that do not fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mismatch {
    Two(Dimension, Dimension),
    One(Dimension),
}

impl Amount {
    /// A number without a unit, which fits any dimension.
    pub(crate) fn plain(value: f64) -> Self {
        Self { value, tens: 0, dimension: None }
    }

    /// A number that has no dimension.
    pub(crate) fn ratio(value: f64) -> Self {
        Self { value, tens: 0, dimension: Some(Dimension::NONE) }
    }

    /// An angle.
    pub(crate) fn degrees(value: f64) -> Self {
        Self { value, tens: 0, dimension: Some(Dimension::ANGLE) }
    }

    /// A power of one unit.
    pub(crate) fn unit(unit: Unit, power: i32) -> Self {
        let dimension = Dimension(unit.dimension.0.map(|steps| steps.saturating_mul(power)));
        let value = integer_power(unit.factor, power);
        Self { value, tens: unit.tens.saturating_mul(power), dimension: Some(dimension) }
    }

    /// A number in a power of a unit, which has a dimension from then on: 7 % is no length.
    pub(crate) fn in_units(self, unit: Unit, power: i32) -> Self {
        let product = self.times(Self::unit(unit, power));
        Self { dimension: product.dimension.or(Some(Dimension::NONE)), ..product }
    }

    /// The number in SI units, angles in degrees.
    pub(crate) fn number(self) -> f64 {
        if self.tens == 0 || !self.value.is_finite() {
            return self.value;
        }
        // The shortest decimal number of a float that was read is the one that was written.
        let decimal = format!("{:e}", self.value);
        let (digits, exponent) = decimal.split_once('e').unwrap_or((&decimal, "0"));
        let exponent = exponent.parse::<i32>().unwrap_or(0).saturating_add(self.tens);
        format!("{digits}e{exponent}").parse().unwrap_or(f64::NAN)
    }

    /// The dimension; `None` if the number fits any.
    pub(crate) fn dimension(self) -> Option<Dimension> {
        self.dimension
    }

    pub(crate) fn negative(self) -> Self {
        Self { value: -self.value, ..self }
    }

    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            tens: self.tens.saturating_add(other.tens),
            dimension: both(self.dimension, other.dimension, Dimension::times),
        }
    }

    pub(crate) fn over(self, other: Self) -> Self {
        Self {
            value: self.value / other.value,
            tens: self.tens.saturating_sub(other.tens),
            dimension: both(self.dimension, other.dimension, Dimension::over),
        }
    }

    /// # Errors
    /// Two dimensions that differ.
    pub(crate) fn plus(self, other: Self) -> Result<Self, Mismatch> {
        let dimension = self.common(other)?;
        if self.tens == other.tens {
            return Ok(Self { value: self.value + other.value, tens: self.tens, dimension });
        }
        Ok(Self { value: self.number() + other.number(), tens: 0, dimension })
    }

    /// The smaller of two.
    ///
    /// # Errors
    /// Two dimensions that differ.
    pub(crate) fn least(self, other: Self) -> Result<Self, Mismatch> {
        let dimension = self.common(other)?;
        let least = if other.number() < self.number() { other } else { self };
        Ok(Self { dimension, ..least })
    }

    /// # Errors
    /// An exponent with a dimension, and powers whose dimension would have odd exponents.
    pub(crate) fn power(self, exponent: Self) -> Result<Self, Mismatch> {
        let exponent = exponent.pure()?;
        let dimension = match self.dimension {
            None => None,
            Some(of) => Some(of.power(exponent).ok_or(Mismatch::One(of))?),
        };
        if exponent.fract() == 0.0 && exponent.abs() <= 64.0 {
            let power = exponent as i32;
            let value = integer_power(self.value, power);
            return Ok(Self { value, tens: self.tens.saturating_mul(power), dimension });
        }
        let number = self.number();
        let value = if exponent == 0.5 { number.sqrt() } else { libm::pow(number, exponent) };
        Ok(Self { value, tens: 0, dimension })
    }

    /// The number, if it has no dimension.
    pub(crate) fn pure(self) -> Result<f64, Mismatch> {
        match self.dimension {
            None | Some(Dimension::NONE) => Ok(self.number()),
            Some(other) => Err(Mismatch::One(other)),
        }
    }

    /// The number as an angle, degrees.
    pub(crate) fn angle(self) -> Result<f64, Mismatch> {
        match self.dimension {
            Some(Dimension::ANGLE) => Ok(self.number()),
            _ => self.pure(),
        }
    }

    /// The dimension of two numbers that are added or compared.
    fn common(self, other: Self) -> Result<Option<Dimension>, Mismatch> {
        match (self.dimension, other.dimension) {
            (Some(one), Some(two)) if one != two => Err(Mismatch::Two(one, two)),
            (one, two) => Ok(one.or(two)),
        }
    }
}

/// The dimension of a product: plain numbers do not change it, and plain numbers stay plain among themselves
/// and with a ratio, so that `9.81*sin(30)` is plain as 9.81 is.
fn both(
    one: Option<Dimension>,
    other: Option<Dimension>,
    join: fn(Dimension, Dimension) -> Dimension,
) -> Option<Dimension> {
    match (one, other) {
        (None, None | Some(Dimension::NONE)) | (Some(Dimension::NONE), None) => None,
        _ => Some(join(one.unwrap_or(Dimension::NONE), other.unwrap_or(Dimension::NONE))),
    }
}

/// A whole power by products, which are the same on every platform.
fn integer_power(base: f64, power: i32) -> f64 {
    let product = (0..power.unsigned_abs()).fold(1.0, |product, _| product * base);
    if power < 0 { 1.0 / product } else { product }
}
