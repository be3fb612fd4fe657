//! Files of lines or polygons: CSV, GeoJSON and DXF.

use serde_json::Value;

use crate::joints::dxf::{Entity, entities};
use crate::joints::geojson::geometries;

/// Functions that turn the contents of a file into shapes of one form.
pub(crate) struct ShapeForm<T> {
    /// The shape of the numbers of a row; `None` if they are none.
    pub(crate) row: fn(&[f64]) -> Option<T>,
    /// Description of a row, for messages.
    pub(crate) row_is: &'static str,
    /// The shape of an entity of a DXF file; `None` for another entity.
    pub(crate) entity: fn(&Entity<'_>) -> Option<T>,
    /// Adds the shapes of a geometry of a GeoJSON file by its type and its coordinates.
    pub(crate) geometry: fn(&str, &Value, &mut Vec<T>) -> Result<(), String>,
}

/// The shapes of a file, by the extension of its name.
///
/// # Errors
/// A message about a file that is not of such shapes.
pub(crate) fn read<T>(bytes: &[u8], name: &str, form: &ShapeForm<T>) -> Result<Vec<T>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| format!("{name} is not a text file"))?;
    let extension = name.rsplit_once('.').map_or("", |(_, end)| end).to_lowercase();
    let shapes = match extension.as_str() {
        "dxf" => entities(text).map(|all| all.iter().filter_map(form.entity).collect()),
        "json" | "geojson" => {
            let value = serde_json::from_str(text).map_err(|error| format!("{name} is not JSON: {error}"))?;
            let mut shapes = Vec::new();
            geometries(&value, &mut |kind, coordinates| (form.geometry)(kind, coordinates, &mut shapes))
                .map(|()| shapes)
        }
        _ => rows(text, form.row, form.row_is),
    };
    shapes.map_err(|why| format!("{name}: {why}"))
}

/// One shape a row, which `of` makes of its numbers. A first row of words is a heading. `form`: description
/// of a row, for messages.
pub(crate) fn rows<T>(text: &str, of: impl Fn(&[f64]) -> Option<T>, form: &str) -> Result<Vec<T>, String> {
    let mut found = Vec::new();
    for (number, row) in (1..).zip(text.lines()) {
        let row = row.split('#').next().unwrap_or_default().trim();
        if row.is_empty() {
            continue;
        }
        let cells =
            row.split(|c: char| ",;".contains(c) || c.is_whitespace()).filter(|cell| !cell.is_empty());
        let numbers: Result<Vec<f64>, _> = cells.map(str::parse).collect();
        match numbers.ok().and_then(|numbers| of(&numbers)) {
            Some(one) => found.push(one),
            None if number == 1 && row.chars().any(char::is_alphabetic) => {}
            None => return Err(format!("row {number} is not {form}: {row:.60}")),
        }
    }
    Ok(found)
}

/// Checks that there are shapes, and that all of their coordinates are numbers. `many`: name of several.
pub(crate) fn check<'a>(
    name: &str,
    many: &str,
    is_empty: bool,
    coordinates: impl IntoIterator<Item = &'a f64>,
) -> Result<(), String> {
    if is_empty {
        return Err(format!("{name} has no {many}"));
    }
    match coordinates.into_iter().find(|number| !number.is_finite()) {
        Some(number) => Err(format!("{name} has the coordinate {number}")),
        None => Ok(()),
    }
}
