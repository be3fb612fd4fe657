//! Checks `[[wall]]` before anything is meshed.

use crate::bodies::materials;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{ModelFile, Side, Wall};

/// Checks all walls.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, dimensions: u8, faults: &mut Vec<Fault>) {
    for (index, wall) in file.wall.iter().enumerate() {
        let table = Table::of("wall", index);
        if let Err(help) = materials::number(file, &wall.material) {
            faults.push(materials::unknown(document.value(table, "material"), &wall.material, help));
        }
        let title = format!("[[wall]] \"{}\"", wall.name);
        shape(wall, &title, (document, table), dimensions, faults);
        keys(wall, &title, (document, table), faults);
        servo(wall, &title, (document, table), faults);
    }
}

/// The wall has one shape, which fits the dimensions and has an extent.
fn shape(
    wall: &Wall,
    title: &str,
    (document, table): (&Document<'_>, Table),
    dimensions: u8,
    faults: &mut Vec<Fault>,
) {
    let possible = if dimensions == 2 {
        "plane, circle, box, corners"
    } else {
        "plane, tube, cone, disc, box, corners, mesh"
    };
    let key = match wall.shapes()[..] {
        [(key, of)] if of == 0 || of == dimensions => key,
        [(key, _)] => {
            faults.push(
                Fault::at(
                    document.key(table, key),
                    format!("{title}: a {key} is no wall in {dimensions} dimensions"),
                )
                .label("not in this model")
                .help(format!("in {dimensions} dimensions a wall is one of {possible}")),
            );
            return;
        }
        [] => {
            faults.push(
                Fault::at(document.key(table, "name"), format!("{title} has no shape"))
                    .label("this wall")
                    .help(format!("give it one of {possible}")),
            );
            return;
        }
        [(first, _), (second, _), ..] => {
            faults.push(
                Fault::at(
                    document.key(table, second),
                    format!("{title} has two shapes, {first} and {second}"),
                )
                .label("a second shape")
                .help("a wall has one shape; write a second [[wall]]"),
            );
            return;
        }
    };
    if let Some(why) = without_extent(wall, dimensions) {
        faults.push(Fault::at(document.value(table, key), format!("{title}: {why}")).label("this shape"));
    }
    for (place, side) in wall.block.iter().flat_map(|of| of.open.iter().enumerate()) {
        if dimensions == 2 && matches!(side, Side::Front | Side::Back) {
            let span = document.entry(table, "box.open", place);
            faults.push(
                Fault::at(span, "a flat box has no front and no back")
                    .label("not in two dimensions")
                    .help("its sides are left, right, bottom and top"),
            );
        }
    }
}

/// Says why a shape has no extent.
fn without_extent(wall: &Wall, dimensions: u8) -> Option<&'static str> {
    let is_none = |direction: &[f64]| direction.iter().all(|x| *x == 0.0);
    if wall.plane.as_ref().is_some_and(|of| is_none(&of.normal.0)) {
        return Some("its normal has no direction");
    }
    if wall.disc.as_ref().is_some_and(|of| is_none(&of.normal)) {
        return Some("its normal has no direction");
    }
    if wall.tube.as_ref().is_some_and(|of| of.from == of.to) {
        return Some("its axis has no length");
    }
    if let Some(cone) = &wall.cone {
        if cone.from == cone.to {
            return Some("its axis has no length");
        }
        if cone.radii.iter().any(|radius| *radius < 0.0) || is_none(&cone.radii) {
            return Some("its radii are at least 0, and one of them is above 0");
        }
    }
    if let Some(of) = &wall.block {
        if of.min.0.iter().zip(&of.max.0).any(|(min, max)| max <= min) {
            return Some("each component of max has to be above that of min");
        }
        let sides = 2 * usize::from(dimensions);
        let is_open = |side: &Side| of.open.contains(side);
        let all = [Side::Left, Side::Right, Side::Bottom, Side::Top, Side::Front, Side::Back];
        if all[..sides].iter().all(is_open) {
            return Some("all of its sides are open");
        }
    }
    if wall.corners.as_ref().is_some_and(|corners| dimensions == 3 && corners.len() < 3) {
        return Some("a polygon has three corners or more");
    }
    None
}

/// Keys that go together are there together.
fn keys(wall: &Wall, title: &str, (document, table): (&Document<'_>, Table), faults: &mut Vec<Fault>) {
    let goes_with = |key: &str, other: &str| {
        Fault::at(document.key(table, key), format!("{title}: \"{key}\" goes with {other}"))
            .label(format!("without {other}"))
    };
    for (key, is_given) in [("scale", wall.scale.is_some()), ("translate", wall.translate.is_some())] {
        if is_given && wall.mesh.is_none() {
            faults.push(goes_with(key, "mesh"));
        }
    }
    match (&wall.displacement, &wall.table) {
        (Some(_), None) => faults.push(
            goes_with("displacement", "table")
                .help("a table of factors over time, such as table = [[0, 0], [0.1, 1]]"),
        ),
        (None, Some(_)) => faults.push(goes_with("table", "displacement")),
        _ => {}
    }
    if wall.table.as_ref().is_some_and(|table| !table.is_sorted_by(|a, b| a[0] < b[0])) {
        faults.push(
            Fault::at(
                document.value(table, "table"),
                format!("{title}: the times of its table do not ascend"),
            )
            .label("out of order"),
        );
    }
}

/// A servo has a direction, and one of force and pressure, which goes with walls that have an area.
fn servo(wall: &Wall, title: &str, (document, table): (&Document<'_>, Table), faults: &mut Vec<Fault>) {
    let Some(servo) = &wall.servo else { return };
    if servo.direction.0.iter().all(|x| *x == 0.0) {
        faults.push(
            Fault::at(
                document.value(table, "servo.direction"),
                format!("{title}: its servo has no direction"),
            )
            .label("all zeros"),
        );
    }
    match (servo.force, servo.pressure) {
        (Some(_), None) => {}
        (None, Some(_)) => {
            if wall.disc.is_none() && wall.mesh.is_none() && wall.corners.is_none() {
                let message = format!("{title}: a pressure goes with a wall that has an area");
                faults.push(
                    Fault::at(document.key(table, "servo.pressure"), message)
                        .label("not of this shape")
                        .help("write force, N, or make the wall a disc, a mesh or corners"),
                );
            }
        }
        (None, None) => faults.push(
            Fault::at(document.key(table, "servo"), format!("{title}: its servo lacks a force"))
                .label("needs force or pressure"),
        ),
        (Some(_), Some(_)) => faults.push(
            Fault::at(
                document.key(table, "servo.pressure"),
                format!("{title}: its servo has both force and pressure"),
            )
            .label("take one of them"),
        ),
    }
}

/// Keys of walls with lists of coordinates: their tables, the number of their components, and the number that
/// a model in `d` dimensions has.
pub(crate) fn lengths(file: &ModelFile, d: usize) -> Vec<(Table, String, usize, usize)> {
    let mut lengths = Vec::new();
    for (index, wall) in file.wall.iter().enumerate() {
        let table = Table::of("wall", index);
        let wrong = wall.corners.iter().flatten().find(|point| point.0.len() != d);
        for (key, vector) in [
            ("corners", wrong),
            ("plane.point", wall.plane.as_ref().map(|of| &of.point)),
            ("plane.normal", wall.plane.as_ref().map(|of| &of.normal)),
            ("box.min", wall.block.as_ref().map(|of| &of.min)),
            ("box.max", wall.block.as_ref().map(|of| &of.max)),
            ("translate", wall.translate.as_ref()),
            ("velocity", wall.velocity.as_ref()),
            ("displacement", wall.displacement.as_ref()),
            ("rotation.through", wall.rotation.as_ref().map(|of| &of.through)),
            ("servo.direction", wall.servo.as_ref().map(|of| &of.direction)),
        ] {
            lengths.extend(vector.map(|vector| (table, key.to_owned(), vector.0.len(), d)));
        }
    }
    lengths
}
