//! `fdem materials` lists the library of materials.

use std::fmt::Write;

use fdem_io::numbers::brief;

use crate::command::args::MaterialsArguments;
use crate::command::failure::Failure;
use crate::command::output::print;
use fdem_model::{LibraryMaterial, library};

/// Columns of the list: heading, key, and the unit of the heading in units of the key.
const COLUMNS: [(&str, &str, f64); 9] = [
    ("kg/m³", "density", 1.0),
    ("E GPa", "youngs_modulus", 1e9),
    ("nu", "poissons_ratio", 1.0),
    ("friction", "friction", 1.0),
    ("tension MPa", "tensile_strength", 1e6),
    ("cohesion MPa", "cohesion", 1e6),
    ("angle °", "friction_angle", 1.0),
    ("GI J/m²", "fracture_energy_i", 1.0),
    ("GII J/m²", "fracture_energy_ii", 1.0),
];

pub(crate) fn run(arguments: &MaterialsArguments) -> Result<(), Failure> {
    match library().iter().find(|material| arguments.name.as_ref() == Some(&material.name)) {
        Some(material) => print(&material.toml()),
        None => print(&list(library())),
    }
}

/// The figures as a table, and the sources below it.
fn list(materials: &[LibraryMaterial]) -> String {
    let mut rows = vec![COLUMNS.map(|(heading, _, _)| heading.to_owned())];
    rows.extend(materials.iter().map(|material| {
        COLUMNS.map(|(_, key, unit)| material.value(key).map_or("-".to_owned(), |value| brief(value / unit)))
    }));
    let widths: Vec<usize> = (0..COLUMNS.len())
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    let names = ["material"].into_iter().chain(materials.iter().map(|material| material.name.as_str()));
    let mut text = String::new();
    for (name, row) in names.zip(&rows) {
        // Writing to a string does not fail.
        let _ = write!(text, "{name:10}");
        for (cell, width) in row.iter().zip(&widths) {
            let _ = write!(text, "  {cell:>width$}");
        }
        text.push('\n');
    }
    for LibraryMaterial { name, about, source, .. } in materials {
        let _ = write!(text, "\n{name}: {about}. {source}.\n");
    }
    text
}
