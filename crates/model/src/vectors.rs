//! Vectors, boxes and stresses of a model file have the number of components that its dimensions require.

use std::fmt::Write;

use crate::grains::checks;
use crate::output::{coarse, probes};
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, Gravity, ModelFile, Side};

/// Finds vectors, boxes and stresses whose number of components is not that of the model.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, dimensions: u8, faults: &mut Vec<Fault>) {
    let d = usize::from(dimensions);
    let mut vectors: Vec<(Table, String, usize, usize)> = Vec::new();
    let general = Table::one("model");
    if let Gravity::Vector(gravity) = &file.model.gravity {
        vectors.push((general, "gravity".to_owned(), gravity.0.len(), d));
    }
    for key in ["plane", "thickness"].into_iter().filter(|key| d == 3 && document.has(general, key)) {
        faults.push(
            Fault::at(document.key(general, key), format!("\"{key}\" is for models in two dimensions"))
                .label("take it out"),
        );
    }
    vectors.extend(checks::lengths(file, d));
    for (index, wall) in file.wall.iter().enumerate() {
        faults.extend(wrong_axis(wall.rotation.as_ref(), d, document, Table::of("wall", index)));
    }
    let initial = Table::one("initial");
    for (name, velocity) in &file.initial.velocity {
        vectors.push((initial, format!("velocity.{name}"), velocity.0.len(), d));
    }
    let components = d * (d + 1) / 2;
    for (key, stress) in
        [("stress", &file.initial.stress), ("stress_gradient", &file.initial.stress_gradient)]
    {
        vectors.extend(stress.as_ref().map(|stress| (initial, key.to_owned(), stress.len(), components)));
    }
    for (index, body) in file.body.iter().enumerate() {
        let table = Table::of("body", index);
        let within = body.packing.as_ref().and_then(|packing| packing.within.as_ref());
        for (key, vector) in [
            ("translate", body.translate.as_ref()),
            ("velocity", body.velocity.as_ref()),
            ("spacing", body.spacing.as_ref()),
            ("packing.within.min", within.and_then(|within| within.min.as_ref())),
            ("packing.within.max", within.and_then(|within| within.max.as_ref())),
        ] {
            vectors.extend(vector.map(|vector| (table, key.to_owned(), vector.0.len(), d)));
        }
        vectors.extend(body.repeat.as_ref().map(|repeat| (table, "repeat".to_owned(), repeat.len(), d)));
        if let Some(spin) = body.spin
            && matches!(spin, file::Spin::Plane(_)) != (d == 2)
        {
            let help = if d == 2 {
                "write one number: degrees per second, counter-clockwise"
            } else {
                "write [x, y, z]: the axis, as long as the degrees per second about it"
            };
            let fault =
                Fault::at(document.value(table, "spin"), format!("\"spin\" of a body in {d} dimensions"));
            faults.push(fault.label("is not of this form").help(help));
        }
        if body.axis.is_some() && d == 2 {
            faults.push(
                Fault::at(document.key(table, "axis"), "\"axis\" is for models in three dimensions")
                    .label("take it out"),
            );
        }
        if body.axis == Some([0.0; 3]) {
            faults.push(
                Fault::at(document.value(table, "axis"), "\"axis\" has no direction").label("all zeros"),
            );
        }
    }
    for (index, boundary) in file.boundary.iter().enumerate() {
        let table = Table::of("boundary", index);
        let lengths = [
            ("box", boundary.limits.as_ref().map(Vec::len), 2 * d),
            ("velocity", boundary.velocity.as_ref().map(Vec::len), d),
            ("displacement", boundary.displacement.as_ref().map(Vec::len), d),
            ("force", boundary.force.as_ref().map(|force| force.0.len()), d),
            ("traction", boundary.traction.as_ref().map(|traction| traction.0.len()), d),
            ("at", boundary.at.as_ref().map(|at| at.0.len()), d),
            ("rotation.through", boundary.rotation.as_ref().map(|rotation| rotation.through.0.len()), d),
        ];
        for (key, found, wanted) in lengths {
            vectors.extend(found.map(|found| (table, key.to_owned(), found, wanted)));
        }
        faults.extend(wrong_axis(boundary.rotation.as_ref(), d, document, table));
        flat_boundary(boundary, d, (document, table), faults);
    }
    for (index, injection) in file.injection.iter().enumerate() {
        let at = injection.at.as_ref().map(|at| at.0.len());
        vectors.extend(at.map(|found| (Table::of("injection", index), "at".to_owned(), found, d)));
    }
    vectors.extend(of_surfaces(file, document, d, faults));
    vectors.extend(
        coarse::length(file, d).map(|(table, key, found, wanted)| (table, key.to_owned(), found, wanted)),
    );
    for (index, history) in file.history.iter().enumerate() {
        let node = history.node.as_ref().map(|node| node.0.len());
        vectors.extend(node.map(|found| (Table::of("history", index), "node".to_owned(), found, d)));
        for (key, found, wanted) in probes::lengths(history, d) {
            vectors.push((Table::of("history", index), key.to_owned(), found, wanted));
        }
    }
    for (table, key, found, wanted) in vectors.into_iter().filter(|(_, _, found, wanted)| found != wanted) {
        faults.push(wrong_length(file, document, dimensions, (table, &key), [found, wanted]));
    }
}

/// The vectors and boxes of surfaces of pores. Reports sides that flat bodies do not have.
fn of_surfaces(
    file: &ModelFile,
    document: &Document<'_>,
    d: usize,
    faults: &mut Vec<Fault>,
) -> Vec<(Table, String, usize, usize)> {
    let mut vectors = Vec::new();
    for (index, surface) in file.pore_surface.iter().enumerate() {
        let table = Table::of("pore_surface", index);
        for (key, found, wanted) in [
            ("box", surface.limits.as_ref().map(Vec::len), 2 * d),
            ("at", surface.at.as_ref().map(|at| at.0.len()), d),
        ] {
            vectors.extend(found.map(|found| (table, key.to_owned(), found, wanted)));
        }
        faults.extend(flat_sides(surface.all_sides(), surface.side.is_some(), d, (document, table)));
    }
    vectors
}

/// The fault of sides that a flat body does not have. `is_one`: they are the value of `side`.
fn flat_sides(
    mut sides: impl Iterator<Item = Side>,
    is_one: bool,
    d: usize,
    (document, table): (&Document<'_>, Table),
) -> Option<Fault> {
    let is_deep = d == 2 && sides.any(|side| matches!(side, Side::Front | Side::Back));
    let key = if is_one { "side" } else { "sides" };
    is_deep.then(|| {
        Fault::at(document.value(table, key), "a flat body has no front and no back")
            .label("not in two dimensions")
            .help("its sides are left, right, bottom and top")
    })
}

/// The faults of a boundary in two dimensions that needs a third one.
fn flat_boundary(
    boundary: &file::Boundary,
    d: usize,
    (document, table): (&Document<'_>, Table),
    faults: &mut Vec<Fault>,
) {
    if d != 2 {
        return;
    }
    faults.extend(flat_sides(boundary.all_sides(), boundary.side.is_some(), d, (document, table)));
    if boundary.fixed.is_some_and(|fixed| fixed.axes()[2]) {
        faults.push(
            Fault::at(document.value(table, "fixed"), "a flat body cannot be held along z")
                .label("not in two dimensions")
                .help("take \"x\", \"y\" or \"xy\""),
        );
    }
}

/// The fault of a rotation whose axis does not fit the dimensions.
fn wrong_axis(
    rotation: Option<&file::Rotation>,
    d: usize,
    document: &Document<'_>,
    table: Table,
) -> Option<Fault> {
    let message = match rotation?.axis {
        Some(_) if d == 2 => "a flat body turns about z: \"axis\" is for three dimensions",
        None if d == 3 => "a rotation in three dimensions has an \"axis\"",
        Some(axis) if axis == [0.0; 3] => "\"axis\" has no direction",
        _ => return None,
    };
    let help = if d == 2 {
        "write rotation = { through = [x, y], speed = degrees per second }"
    } else {
        "write rotation = { through = [x, y, z], axis = [x, y, z], speed = degrees per second }"
    };
    Some(Fault::at(document.value(table, "rotation"), message).label("here").help(help))
}

/// The error of a key whose number of entries fits other dimensions.
fn wrong_length(
    file: &ModelFile,
    document: &Document<'_>,
    dimensions: u8,
    (table, key): (Table, &str),
    [found, wanted]: [usize; 2],
) -> Fault {
    let body = table.index.filter(|_| key.starts_with("packing")).map(|index| &file.body[index]);
    let shape = body.and_then(|body| body.packing.as_ref()?.shape);
    let is_list = ["grains", "wall"].contains(&table.name);
    let mut message = String::new();
    // Writing to a string does not fail.
    let _ = write!(
        message,
        "\"{key}\" has {found} numbers, where a model in {dimensions} dimensions has {wanted}"
    );
    Fault::at(document.value(table, key), message).label(format!("{found} numbers")).help(match shape {
        Some(file::PieceShape::Disc) => "discs are flat: write [x, y], or take shape = \"sphere\"".to_owned(),
        Some(file::PieceShape::Polygon) => {
            "polygons are flat: write [x, y], or take shape = \"polyhedron\"".to_owned()
        }
        Some(file::PieceShape::Sphere | file::PieceShape::Polyhedron) | None => {
            form(if table.name == "history" && key == "stress" { "point" } else { key }, dimensions, is_list)
        }
    })
}

/// How a key is written. `is_list`: a list of points.
fn form(key: &str, dimensions: u8, is_list: bool) -> String {
    let components = match (key, dimensions) {
        ("at" | "corners", 2) if is_list => "[[x, y], …]",
        ("at" | "corners", _) if is_list => "[[x, y, z], …]",
        ("box", 2) => "[xmin, ymin, xmax, ymax]",
        ("box", _) => "[xmin, ymin, zmin, xmax, ymax, zmax]",
        ("gauge", 2) => "[[x, y], [x, y]]",
        ("gauge", _) => "[[x, y, z], [x, y, z]]",
        ("stress" | "stress_gradient", 2) => "[xx, yy, xy]",
        ("stress" | "stress_gradient", _) => "[xx, yy, zz, xy, yz, xz]",
        (_, 2) => "[x, y]",
        _ => "[x, y, z]",
    };
    format!("write {components}, or give [model] the dimensions that are meant")
}
