//! The page of the book that lists the library of materials.

use std::fmt::Write;

use fdem::model::{LibraryMaterial, library};

/// Columns of the table: heading, key, and the unit of the heading in units of the key.
const COLUMNS: [(&str, &str, f64); 9] = [
    ("density, kg/m³", "density", 1.0),
    ("Young's modulus, GPa", "youngs_modulus", 1e9),
    ("Poisson's ratio", "poissons_ratio", 1.0),
    ("friction", "friction", 1.0),
    ("tensile strength, MPa", "tensile_strength", 1e6),
    ("cohesion, MPa", "cohesion", 1e6),
    ("friction angle, °", "friction_angle", 1.0),
    ("fracture energy I, J/m²", "fracture_energy_i", 1.0),
    ("fracture energy II, J/m²", "fracture_energy_ii", 1.0),
];

/// The page, in Markdown.
pub(crate) fn page() -> String {
    let mut page = String::from(
        "# Materials\n\n\
         A `[[material]]` may take its figures from the library:\n\n\
         ```toml\n[[material]]\nname = \"rock\"\nlibrary = \"granite\"\nfriction = 0.5        # a key of the table overrides the library\n```\n\n\
         The library gives all keys that the table does not give. The model, its hash and its results are the same as with the keys written out. `fdem check` lists the keys that come\n\
         from the library, `fdem materials` lists it, and `fdem materials granite` prints one material as a table of a model file, which you can change. The same key works in Python:\n\
         `material=[{\"name\": \"rock\", \"library\": \"granite\"}]`.\n\n\
         A material with strengths breaks. For a body that must not break, write `density`, `youngs_modulus` and `poissons_ratio` yourself. The figures are for a first model, and for\n\
         comparisons: strengths of one kind of rock scatter by a factor of two and more, and a model of a test needs the strengths of its specimens. Elements must resolve the characteristic\n\
         length *EG*/*f*² of a material, which is a third of a millimetre in glass and half a metre in concrete; see [how far you can trust a crack](trust.md).\n\n\
         A test writes this page from the file of the library, so it always fits this version.\n\n",
    );
    let headings: Vec<&str> = COLUMNS.iter().map(|(heading, _, _)| *heading).collect();
    writeln!(page, "| `library` | {} |\n|---|{}", headings.join(" | "), "---:|".repeat(COLUMNS.len()))
        .unwrap();
    for material in library() {
        let cell = |(_, key, unit): &(&str, &str, f64)| {
            material.value(key).map_or("–".to_owned(), |value| fdem::io::numbers::brief(value / unit))
        };
        let cells: Vec<String> = COLUMNS.iter().map(cell).collect();
        writeln!(page, "| `{}` | {} |", material.name, cells.join(" | ")).unwrap();
    }
    page.push_str(
        "\nFracture energies of mode I are *K*²(1-ν²)/*E* of a published fracture toughness *K*, unless the source gives the energy itself. Energies of mode II are assumed to be five times as large:\n\
         measurements scatter from equal to more than ten times. Where a source gives the strength in compression, the cohesion is that of a Mohr-Coulomb material\n\
         of this strength and friction angle. \"Typical\" figures lie within the published range and belong to no single rock.\n\n\
         | `library` | | source |\n|---|---|---|\n",
    );
    for LibraryMaterial { name, about, source, .. } in library() {
        writeln!(page, "| `{name}` | {about} | {source}. |").unwrap();
    }
    page
}
