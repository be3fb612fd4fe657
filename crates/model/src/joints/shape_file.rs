//! Files of lines or polygons: CSV, GeoJSON and DXF.

use std::collections::BTreeMap;
use std::fmt::Display;

use fdem_io::numbers::{brief, grouped};
use serde_json::Value;

use crate::joints::dxf::{DxfDrawing, Entity, drawing};
use crate::joints::geojson::geometries;

/// Functions that turn the contents of a file into shapes of one form.
pub(crate) struct ShapeForm<T> {
    /// The shape of the numbers of a row; `None` if they are none.
    pub(crate) row: fn(&[f64]) -> Option<T>,
    /// Whether a shape has two places that differ.
    pub(crate) extends: fn(&T) -> bool,
    /// Description of a shape that does not extend, for messages.
    pub(crate) empty: &'static str,
    /// Description of a row, for messages.
    pub(crate) row_is: &'static str,
    /// First letters of the names of its columns, over and over.
    pub(crate) columns: &'static [&'static str],
    /// The shape of an entity of a DXF file; `None` for another entity.
    pub(crate) entity: fn(&Entity<'_>) -> Option<T>,
    /// The entities that are shapes, for messages.
    pub(crate) entities: &'static str,
    /// Kinds of entities that have such shapes and cannot be read.
    pub(crate) refused: &'static [&'static str],
    /// The coordinates of a shape.
    pub(crate) coordinates: fn(&mut T) -> &mut [f64],
    /// The geometries of a GeoJSON file that are shapes, for messages.
    pub(crate) geometries: &'static str,
    /// Adds the shapes of a geometry of a GeoJSON file by its type and its coordinates.
    pub(crate) geometry: fn(&str, &Value, &mut Vec<T>) -> Result<(), String>,
}

/// The shapes of a file.
pub(crate) struct Shapes<T> {
    pub(crate) all: Vec<T>,
    /// Length of the unit of the file that was taken, m.
    pub(crate) scale: f64,
    /// Notes on how the file was read.
    pub(crate) notes: Vec<String>,
}

/// The shapes of a file, by the extension of its name. `scale`: length of the unit of the file, m, if the
/// model says it; else the unit of a DXF file, and metres in others.
///
/// # Errors
/// A message about a file that is not of such shapes.
pub(crate) fn read<T>(
    bytes: &[u8],
    name: &str,
    scale: Option<f64>,
    form: &ShapeForm<T>,
) -> Result<Shapes<T>, String> {
    let extension = name.rsplit_once('.').map_or("", |(_, end)| end).to_lowercase();
    let in_file = |why: String| format!("{name}: {why}");
    if extension == "dxf" {
        // Names of layers may be in another encoding.
        let text = String::from_utf8_lossy(bytes);
        let mut shapes = of_drawing(&drawing(&text).map_err(in_file)?, scale, form).map_err(in_file)?;
        shapes.notes.iter_mut().for_each(|note| *note = format!("{name}: {note}"));
        return Ok(shapes);
    }
    let text = std::str::from_utf8(bytes).map_err(|_| format!("{name} is not a text file"))?;
    let shapes = match extension.as_str() {
        "json" | "geojson" => {
            let value = serde_json::from_str(text).map_err(|error| format!("{name} is not JSON: {error}"))?;
            of_geojson(&value, form)
        }
        _ => shapes_of_rows(text, form).map(|all| Shapes { all, scale: 1.0, notes: Vec::new() }),
    };
    let mut shapes = shapes.map_err(in_file)?;
    shapes.notes.iter_mut().for_each(|note| *note = format!("{name}: {note}"));
    shapes.scale = scale.unwrap_or(1.0);
    scaled(&mut shapes.all, shapes.scale, form);
    Ok(shapes)
}

/// The shapes of a GeoJSON file, without its points.
fn of_geojson<T>(value: &Value, form: &ShapeForm<T>) -> Result<Shapes<T>, String> {
    let (mut shapes, mut number) = (Vec::new(), 0);
    let mut add = |kind: &str, coordinates: &Value| {
        let before = shapes.len();
        number += 1;
        (form.geometry)(kind, coordinates, &mut shapes)
            .map_err(|why| format!("{why}; take it out of the file, or into one of its own"))?;
        if shapes[before..].iter().all(form.extends) {
            return Ok(());
        }
        Err(format!("geometry {number}, a {kind}, {}", form.empty))
    };
    let unused = geometries(value, &mut add)?;
    let notes: Vec<String> = not_used(&unused, form.geometries).into_iter().collect();
    match notes.first() {
        Some(note) if shapes.is_empty() => Err(note.clone()),
        _ => Ok(Shapes { all: shapes, scale: 1.0, notes }),
    }
}

/// A note on parts of a file that are not used, by their kinds; `None` if all are. `used`: kinds that are.
fn not_used(unused: &BTreeMap<impl Display, u64>, used: &str) -> Option<String> {
    let kinds: Vec<String> =
        unused.iter().map(|(kind, count)| format!("{} {kind}", grouped(*count))).collect();
    (!kinds.is_empty()).then(|| format!("not used: {}; {used} are", kinds.join(", ")))
}

/// One shape a row.
///
/// # Errors
/// Names the row.
fn shapes_of_rows<T>(text: &str, form: &ShapeForm<T>) -> Result<Vec<T>, String> {
    let shape = |(row, shape): (usize, T)| {
        if (form.extends)(&shape) { Ok(shape) } else { Err(format!("row {row} {}", form.empty)) }
    };
    rows(text, form.row, (form.row_is, form.columns, "m"))?.into_iter().map(shape).collect()
}

fn scaled<T>(shapes: &mut [T], scale: f64, form: &ShapeForm<T>) {
    shapes.iter_mut().flat_map(form.coordinates).for_each(|x| *x *= scale);
}

/// The shapes of a drawing.
///
/// # Errors
/// An entity that has lines or faces and cannot be read; a unit that is not known.
fn of_drawing<T>(
    drawing: &DxfDrawing<'_>,
    scale: Option<f64>,
    form: &ShapeForm<T>,
) -> Result<Shapes<T>, String> {
    let (mut shapes, mut notes) = (Vec::new(), Vec::new());
    let mut unused: BTreeMap<String, u64> = BTreeMap::new();
    for entity in &drawing.entities {
        if form.refused.contains(&entity.kind) {
            return Err(format!(
                "it has {}, which is not read: turn it into {} in the drawing program (explode it)",
                entity.kind, form.entities
            ));
        }
        match (form.entity)(entity) {
            Some(shape) if (form.extends)(&shape) => shapes.push(shape),
            Some(_) => *unused.entry(format!("{} that {}", entity.kind, form.empty)).or_default() += 1,
            None => *unused.entry(entity.kind.to_owned()).or_default() += 1,
        }
    }
    notes.extend(not_used(&unused, form.entities));
    let scale = match scale {
        Some(scale) => scale,
        None => match drawing.unit()? {
            None => 1.0,
            Some((name, length)) => {
                if length != 1.0 {
                    notes.push(format!(
                        "its unit is {name} ($INSUNITS), so that 1 of it is {} m; if it is not, say scale",
                        brief(length)
                    ));
                }
                length
            }
        },
    };
    scaled(&mut shapes, scale, form);
    Ok(Shapes { all: shapes, scale, notes })
}

/// One shape a row, which `of` makes of its numbers, with the number of the row. A first row of words is a
/// heading, which has to name these columns in this unit. `form`: description of a row, for messages; first
/// letters of the names of its columns, over and over; unit.
pub(crate) fn rows<T>(
    text: &str,
    of: impl Fn(&[f64]) -> Option<T>,
    (form, columns, unit): (&str, &[&str], &str),
) -> Result<Vec<(usize, T)>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut found = Vec::new();
    for (number, row) in (1..).zip(text.lines()) {
        let row = row.split('#').next().unwrap_or_default().trim();
        if row.is_empty() {
            continue;
        }
        // Between semicolons, and where every word has one, a comma is a decimal one.
        let has_decimal_comma = |word: &str| {
            let (whole, fraction) = word.split_once(',').unwrap_or_default();
            [whole.trim_start_matches(['-', '+']), fraction]
                .iter()
                .all(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()))
        };
        let mut words = row.split(|c: char| c == ';' || c.is_whitespace()).filter(|word| !word.is_empty());
        let is_separated = row.contains(';') || words.clone().count() > 1;
        let decimal =
            if row.contains(';') { words.any(has_decimal_comma) } else { words.all(has_decimal_comma) };
        if is_separated && decimal {
            return Err(format!(
                "row {number} has decimal commas, or two kinds of separators: write decimal points, or one separator: {row:.60}"
            ));
        }
        let cells =
            row.split(|c: char| ",;".contains(c) || c.is_whitespace()).filter(|cell| !cell.is_empty());
        let numbers: Result<Vec<f64>, _> = cells.map(str::parse).collect();
        match numbers.ok().and_then(|numbers| of(&numbers)) {
            Some(one) => found.push((number, one)),
            None if number == 1 && row.chars().any(char::is_alphabetic) => check_heading(row, columns, unit)?,
            None => return Err(format!("row {number} is not {form}: {row:.60}")),
        }
    }
    Ok(found)
}

/// Checks that a heading has the columns in their order, and no other unit.
fn check_heading(row: &str, columns: &[&str], unit: &str) -> Result<(), String> {
    let expected = || columns.iter().cycle();
    let cells =
        row.split([',', ';', '\t']).map(|cell| cell.trim_matches(|c: char| c == '"' || c.is_whitespace()));
    for (cell, column) in cells.zip(expected()) {
        let name = cell.to_lowercase();
        if !name.starts_with(column) {
            return Err(format!("row 1 has the column \"{cell:.40}\" in the place of {column}"));
        }
        let given =
            name.split_once(['[', '(']).map(|(_, rest)| rest.trim_end_matches([']', ')']).trim().to_owned());
        if let Some(given) = given.filter(|given| given != unit && !matches!(given.as_str(), "" | "-" | "1"))
        {
            return Err(format!("row 1 has the unit {given:.20}: numbers are in {unit}"));
        }
    }
    Ok(())
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
