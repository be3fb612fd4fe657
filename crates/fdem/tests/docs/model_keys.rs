//! The page of the book that lists every key of a model file, from the schema that checks such files.

use std::fmt::Write;

use serde_json::{Map, Value};

/// Tables of the file in the usual order; below each the tables in its keys.
const ORDER: [(&str, &[&str]); 24] = [
    ("model", &["mass_scaling"]),
    (
        "body",
        &[
            "Rectangle",
            "Disc",
            "Ring",
            "Polygon",
            "Box",
            "Cylinder",
            "Tube",
            "Sphere",
            "Polyhedron",
            "Extrusion",
            "Voronoi",
            "Outline",
            "Packing",
            "copies_of",
            "Region",
            "Refine",
        ],
    ),
    ("grains", &["grains_within", "round_region", "normal_radius", "clump_sphere"]),
    ("insertion", &["box_within"]),
    ("delete", &[]),
    ("wall", &["wall_plane", "wall_tube", "wall_circle", "wall_cone", "wall_disc", "wall_box", "wall_servo"]),
    ("spheres", &[]),
    ("domain", &["domain_servo"]),
    ("material", &["Anisotropy", "material_pores"]),
    ("interface", &[]),
    ("joint_set", &[]),
    ("boundary", &["Rotation", "servo"]),
    ("fluid", &[]),
    ("injection", &[]),
    ("pores", &[]),
    ("pore_surface", &[]),
    ("stage", &["until"]),
    ("initial", &["Principal", "Ground"]),
    ("contact", &[]),
    ("fracture", &[]),
    ("output", &["acoustic_emission", "coarse", "Field"]),
    ("history", &[]),
    ("curve", &[]),
    ("parameters", &[]),
];

/// The page, in Markdown.
pub(crate) fn page(schema: &Value) -> String {
    let mut page = String::from(
        "# Every key\n\n\
         Units are SI, angles in degrees. A number may also be an [expression](parameters.md) in quotes, with another unit. Keys in **bold** are required. A test writes this page from the schema that model files are checked against\n\
         (`fdem check --schema`), so it always fits this version.\n",
    );
    let top = schema["properties"].as_object().unwrap();
    // `include` is not a table: it comes before them.
    assert_eq!(top.len(), ORDER.len() + 1, "a table of the file is not on the page");
    write!(page, "\n## `include`\n\n{}\n", description(&top["include"])).unwrap();
    let mut shown = 0;
    for (name, inner) in ORDER {
        let property = &top[name];
        let (heading, target) = match property.get("items") {
            Some(items) => (format!("[[{name}]]"), items),
            None => (format!("[{name}]"), property),
        };
        let table = resolved(schema, target);
        write!(page, "\n## `{heading}`\n\n{}\n\n", text(table, property)).unwrap();
        if table.get("properties").is_some() {
            keys(&mut page, schema, table);
            shown += 1;
        }
        for name in inner {
            let table = &schema["$defs"][*name];
            write!(page, "\n### {}\n\n{}\n\n", heading_of(name), description(table)).unwrap();
            match table.get("oneOf").and_then(Value::as_array) {
                Some(words) => choices(&mut page, words),
                None => keys(&mut page, schema, table),
            }
            shown += usize::from(table.get("properties").is_some());
        }
    }
    let tables = schema["$defs"].as_object().unwrap().values();
    assert_eq!(
        shown,
        tables.filter(|table| table.get("properties").is_some()).count(),
        "a table is not on the page"
    );
    page
}

/// A word in small letters, in backticks.
fn heading_of(name: &str) -> String {
    format!("`{}`", name.to_lowercase())
}

/// Description of a table, or else of its key.
fn text(table: &Value, property: &Value) -> String {
    if table.get("description").is_some() { description(table) } else { description(property) }
}

/// On one line, as a cell of a table may have it.
fn description(value: &Value) -> String {
    value["description"].as_str().unwrap().replace('\n', " ").replace('|', "\\|")
}

fn resolved<'a>(schema: &'a Value, value: &'a Value) -> &'a Value {
    // A table that may be missing is one of itself and nothing.
    let value = value.get("anyOf").map_or(value, |choices| &choices[0]);
    match value.get("$ref").and_then(Value::as_str) {
        Some(path) => &schema["$defs"][path.rsplit('/').next().unwrap()],
        None => value,
    }
}

fn keys(page: &mut String, schema: &Value, table: &Value) {
    let needed = table.get("required").and_then(Value::as_array);
    let properties: &Map<String, Value> = table["properties"].as_object().unwrap();
    page.push_str("| key | value | |\n|---|---|---|\n");
    let is_needed = |key: &str| needed.is_some_and(|keys| keys.iter().any(|needed| needed == key));
    // Required keys first.
    for first in [true, false] {
        for (key, property) in properties.iter().filter(|(key, _)| is_needed(key) == first) {
            let key = if first { format!("**`{key}`**") } else { format!("`{key}`") };
            writeln!(page, "| {key} | {} | {} |", kind(schema, property), description(property)).unwrap();
        }
    }
}

fn choices(page: &mut String, words: &[Value]) {
    page.push_str("| word | |\n|---|---|\n");
    for word in words {
        writeln!(page, "| `{}` | {} |", word["const"], description(word)).unwrap();
    }
}

/// The possible values, in words.
fn kind(schema: &Value, property: &Value) -> String {
    let parts = ["anyOf", "oneOf"].iter().find_map(|name| property.get(*name).and_then(Value::as_array));
    if let Some(parts) = parts {
        let words: Vec<String> =
            parts.iter().filter(|part| part["type"] != "null").map(|part| kind(schema, part)).collect();
        return words.join(" or ");
    }
    if let Some(word) = property.get("const") {
        return format!("`{word}`");
    }
    if let Some(path) = property.get("$ref").and_then(Value::as_str) {
        let name = path.rsplit('/').next().unwrap();
        let table = &schema["$defs"][name];
        return match () {
            () if table.get("properties").is_some() => {
                format!("a [{}](#{})", heading_of(name), name.to_lowercase())
            }
            () if name == "Field" => "a [`field`](#field)".to_owned(),
            () => kind(schema, table),
        };
    }
    let range = range(property);
    match type_of(property) {
        "number" => format!("number{}{range}", unit(property)),
        "integer" => format!("whole number{range}"),
        "boolean" => "`true` or `false`".to_owned(),
        "string" => "text".to_owned(),
        "object" => "a table of names".to_owned(),
        "array" => {
            let item = kind(schema, &property["items"]);
            match property.get("maxItems").and_then(Value::as_u64) {
                Some(count) => format!("[{}]", vec![item; count as usize].join(", ")),
                None => format!("list of {item}"),
            }
        }
        other => panic!("the page has no word for {other}"),
    }
}

/// The unit of a number, if it has one.
fn unit(property: &Value) -> String {
    match property.get("x-unit").and_then(Value::as_str) {
        None | Some("1") => String::new(),
        Some("deg") => " in degrees".to_owned(),
        Some(unit) => format!(" in {unit}"),
    }
}

fn type_of(property: &Value) -> &str {
    match &property["type"] {
        Value::Array(types) => types.iter().filter_map(Value::as_str).find(|name| *name != "null").unwrap(),
        name => name.as_str().unwrap(),
    }
}

fn range(property: &Value) -> String {
    let limits = [
        ("exclusiveMinimum", "above"),
        ("minimum", "at least"),
        ("exclusiveMaximum", "below"),
        ("maximum", "at most"),
    ];
    let words: Vec<String> = limits
        .iter()
        .filter_map(|(name, word)| property.get(*name).map(|limit| format!("{word} {limit}")))
        .collect();
    if words.is_empty() { String::new() } else { format!(", {}", words.join(", ")) }
}
