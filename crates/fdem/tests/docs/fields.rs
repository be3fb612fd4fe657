//! The page of the book that lists every field of the results, from the table from which files, pictures and
//! pages take them.

use std::fmt::Write;

use fdem::results::{Place, QUANTITIES, Quantity, Span};

/// Places in the order of the page: heading, and the things that have a value there.
const PLACES: [(&str, Place, &str); 7] = [
    ("Elements", Place::Element, "Values of an element."),
    (
        "Nodes",
        Place::Node,
        "Values of a node. Pictures colour an element by the mean over its nodes, of a vector by its magnitude.",
    ),
    (
        "Joints",
        Place::Joint,
        "Values of a joint that softens or is broken. Files for ParaView have the two kinds apart.",
    ),
    (
        "Contacts",
        Place::Contact,
        "Values of a couple of elements that press each other, at the beginning of the last step.",
    ),
    (
        "Spheres",
        Place::Sphere,
        "Values of a sphere or a disc. Pictures colour it by the magnitude of a vector.",
    ),
    (
        "Contacts of spheres",
        Place::SphereContact,
        "Values of a contact of a sphere with another one, a wall or a body.",
    ),
    ("Walls", Place::Wall, "Values of a wall."),
];

/// The page, in Markdown.
pub(crate) fn page() -> String {
    let mut page = String::from(
        "# Fields\n\n\
         A field has one name, unit and sign in [files for ParaView](results.md#paraview), pictures,\n\
         the report, [model files](keys.md#field) and [Python](python.md). In the last column, *files* are\n\
         those for ParaView, and *drawn* fields colour pictures, the animation and the report. In Python,\n\
         `run.field(\"von_mises\")` is the array of any field, and `fdem.fields()` is this table. A test\n\
         writes this page from the table in the program, so it is always that of this version.\n",
    );
    for (heading, place, text) in PLACES {
        write!(page, "\n## {heading}\n\n{text}\n\n| key | | unit | values | |\n|---|---|---|---|---|\n")
            .unwrap();
        let rows = || QUANTITIES.iter().filter(|row| row.place == place);
        rows().for_each(|row| line(&mut page, row));
        let defined: Vec<&Quantity> = rows().filter(|row| !row.definition.is_empty()).collect();
        if !defined.is_empty() {
            page.push('\n');
        }
        for row in defined {
            item(&mut page, &format!("- `{}`: {}", row.key, row.definition));
        }
    }
    page
}

/// Adds an item of a list, in lines of at most 110 columns.
fn item(page: &mut String, text: &str) {
    let mut columns = 0;
    for word in text.split(' ') {
        let width = word.chars().count();
        if columns > 0 && columns + 1 + width > 110 {
            page.push_str("\n ");
            columns = 1;
        }
        if columns > 0 {
            page.push(' ');
        }
        page.push_str(word);
        columns += width + 1;
    }
    page.push('\n');
}

fn line(page: &mut String, row: &Quantity) {
    let mut about = row.about[..1].to_uppercase() + &row.about[1..];
    if !row.components.is_empty() {
        write!(about, " ({})", row.components.join(", ")).unwrap();
    }
    if !row.sign.is_empty() {
        write!(about, "; {}", row.sign).unwrap();
    }
    if let Some(dimensions) = row.dimensions {
        write!(about, "; in {} dimensions", if dimensions == 2 { "two" } else { "three" }).unwrap();
    }
    let values = match row.span {
        Span::NotNegative => "0 and above".to_owned(),
        Span::Between(low, high) => format!("{low} to {high}"),
        _ => String::new(),
    };
    let seen = match [row.in_files, row.is_drawn()] {
        [true, true] => "files, drawn",
        [true, false] => "files",
        [false, true] => "drawn",
        [false, false] => "",
    };
    writeln!(page, "| `{}` | {about} | {} | {values} | {seen} |", row.key, row.unit).unwrap();
}
