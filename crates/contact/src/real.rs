//! The two float types of the library.

use std::fmt::{Debug, Display};
use std::ops::{Add, Mul, Sub};

use crate::simd::task::Kernels;

/// A coordinate type: `f32` or `f64`, and no other.
///
/// The type of the input decides contact. Cells are counted in `f64` for both types, so `f32` coordinates are
/// mapped to cells without an extra rounding.
pub trait Real:
    Kernels
    + Copy
    + PartialOrd
    + Debug
    + Display
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + 'static
{
    /// Whether the type is `f64`.
    #[doc(hidden)]
    const IS_F64: bool;

    /// Zero.
    const ZERO: Self;

    /// One half: a point with cut-off `c` is a sphere of radius `c / 2`.
    const HALF: Self;

    /// Largest magnitude of a coordinate, radius or tolerance: `2^500` for `f64`, `2^60` for `f32`.
    ///
    /// Beyond it the squares of the contact test overflow, and a couple could be lost without an error.
    const MAX_MAGNITUDE: Self;

    /// A length below which squares underflow to zero, so that two elements count as coincident:
    /// `2^-500` for `f64`, `2^-60` for `f32`, with room to spare. Cells are never smaller.
    const MIN_RESOLVED: f64;

    /// The distance from 1 to the next larger number of this type.
    const EPSILON: f64;

    /// The exact value as `f64`.
    fn to_f64(self) -> f64;

    /// The smallest value of this type that is at least `x`; `x` must not exceed [`Real::MAX_MAGNITUDE`] by
    /// more than a small factor.
    fn at_least(x: f64) -> Self;

    /// The value of this type nearest to `x`, ties to even: exact for `f64`.
    fn nearest(x: f64) -> Self;

    /// Whether the value is neither NaN nor infinite.
    fn is_finite(self) -> bool;

    /// The same values, if the type is `f64`.
    #[doc(hidden)]
    fn as_f64(values: &[Self]) -> Option<&[f64]>;
}

macro_rules! impl_real {
    ($type:ty, $exponent:literal, $is_f64:literal, $values:ident => $as_f64:expr) => {
        impl Real for $type {
            const IS_F64: bool = $is_f64;
            const ZERO: Self = 0.0;
            const HALF: Self = 0.5;
            const MAX_MAGNITUDE: Self = power_of_two($exponent) as $type;
            const MIN_RESOLVED: f64 = 1.0 / power_of_two($exponent);
            const EPSILON: f64 = <$type>::EPSILON as f64;

            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            fn at_least(x: f64) -> Self {
                let rounded = x as $type;
                if rounded.to_f64() < x { rounded.next_up() } else { rounded }
            }

            fn nearest(x: f64) -> Self {
                x as $type
            }

            fn is_finite(self) -> bool {
                <$type>::is_finite(self)
            }

            fn as_f64($values: &[Self]) -> Option<&[f64]> {
                $as_f64
            }
        }
    };
}

impl_real!(f32, 60, false, _values => None);
impl_real!(f64, 500, true, values => Some(values));

const fn power_of_two(exponent: u64) -> f64 {
    f64::from_bits((1023 + exponent) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn magnitudes_are_the_documented_powers() {
        assert_eq!(f64::MAX_MAGNITUDE, 2.0_f64.powi(500));
        assert_eq!(f32::MAX_MAGNITUDE, 2.0_f32.powi(60));
        assert_eq!(f64::MIN_RESOLVED, 2.0_f64.powi(-500));
        assert_eq!(f32::MIN_RESOLVED, 2.0_f64.powi(-60));
    }

    #[test]
    fn at_least_rounds_up() {
        assert_eq!(f32::at_least(0.1), 0.1_f32, "0.1 is below its nearest f32");
        assert_eq!(f32::at_least(0.3_f32.to_f64() + 1e-12), 0.3_f32.next_up());
        assert_eq!(f64::at_least(0.1), 0.1);
    }

    /// The sum of `D` squared differences and the squared contact distance stay finite for the largest
    /// magnitudes.
    #[test]
    fn squares_at_the_limit_are_finite() {
        let difference = 2.0 * f32::MAX_MAGNITUDE;
        let reach = 3.0 * f32::MAX_MAGNITUDE;
        assert!((0..16).fold(0.0, |sum, _| sum + difference * difference).is_finite());
        assert!((reach * reach).is_finite());
    }
}
