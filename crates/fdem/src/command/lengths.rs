//! Numbers and lengths as options give them.

use std::str::FromStr;

/// Reads a finite number of at least zero.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value < 0.0 { Err(format!("'{text}' is negative")) } else { Ok(value) }
}

/// Reads a finite number.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    match f64::from_str(text) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("'{text}' is not a finite number")),
        Err(_) if text.contains(',') => Err(format!("'{text}' has a decimal comma: use a point")),
        Err(_) => Err(format!("'{text}' is not a number")),
    }
}
