//! The errors in parameters of a scene, and the checks.

use std::fmt;

/// The reason why a scene was not generated.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A parameter, or a length that follows from the parameters, lies outside its range.
    OutOfRange {
        /// The parameter or length.
        what: &'static str,
        /// The value.
        value: f64,
        /// The allowed range.
        limit: &'static str,
    },
    /// The smallest radius exceeds the largest.
    MinAboveMax {
        /// Smallest radius.
        min: f64,
        /// Largest radius.
        max: f64,
    },
    /// Something does not fit into its space.
    TooNarrow {
        /// The thing that does not fit.
        what: &'static str,
        /// The length that it needs.
        required: f64,
        /// The available length.
        room: f64,
    },
    /// There is no memory for the arrays.
    OutOfMemory {
        /// Number of entries of the array that was refused.
        n: usize,
    },
    /// A dropped disc found no position of rest without overlapping another disc.
    NoRest {
        /// The disc, in the order of dropping.
        index: usize,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::OutOfRange { what, value, limit } => write!(f, "{what} is {value}; it must be {limit}"),
            Self::MinAboveMax { min, max } => {
                write!(f, "the smallest radius {min} exceeds the largest radius {max}")
            }
            Self::TooNarrow { what, required, room } => {
                write!(f, "{what} needs {required} and has only {room} of room")
            }
            Self::OutOfMemory { n } => write!(f, "no memory for an array of {n} entries"),
            Self::NoRest { index } => write!(f, "disc {index} found no place to rest"),
        }
    }
}

impl std::error::Error for Error {}

/// Returns `value` if it is positive and finite.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::OutOfRange { what, value, limit: "positive and finite" })
    }
}

/// Returns `value` if it is zero or positive, and finite.
pub(crate) fn not_negative(what: &'static str, value: f64) -> Result<f64, Error> {
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::OutOfRange { what, value, limit: "zero or positive, and finite" })
    }
}

/// An empty array with room for `n` entries.
pub(crate) fn reserved<T>(n: usize) -> Result<Vec<T>, Error> {
    let mut array = Vec::new();
    array.try_reserve_exact(n).map_err(|_| Error::OutOfMemory { n })?;
    Ok(array)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_refuse_what_they_should() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(positive("x", value).is_err(), "{value}");
        }
        for value in [-1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(not_negative("x", value).is_err(), "{value}");
        }
        assert_eq!(positive("x", 1e-300), Ok(1e-300));
        assert_eq!(not_negative("x", 0.0), Ok(0.0));
        assert_eq!(reserved::<f64>(usize::MAX), Err(Error::OutOfMemory { n: usize::MAX }));
    }

    #[test]
    fn message_names_parameter_value_and_limit() {
        let error = positive("spacing", -2.5).unwrap_err();
        assert_eq!(error.to_string(), "spacing is -2.5; it must be positive and finite");
    }
}
