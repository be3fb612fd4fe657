//! Numbers and names in the delimited text of results.

/// Appends a comma and a number in its shortest form that reads back as the same number.
pub(super) fn push_number(line: &mut String, number: f64) {
    use std::fmt::Write;
    // Very small and very large numbers have an exponent. Writing to a string does not fail.
    let plain = number == 0.0 || (1e-4..1e16).contains(&number.abs());
    let _ = if plain { write!(line, ",{number}") } else { write!(line, ",{number:e}") };
}

/// Quotes a name for delimited text if necessary.
pub(super) fn quoted(name: &str) -> String {
    // Line breaks in a name would break the line of names.
    let name: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if name.contains([',', '"']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name }
}
