//! Keys and numbers of a model file that are allowed, and yet are probably not what is meant.

use fdem_io::numbers::brief;
use fdem_simulation::{Material, Model};

use crate::model::document::{Document, Table};
use crate::model::file::{Body, Boundary, Component, ModelFile, Piece};

/// A quantity with the values that solids have, and the unit that is mistaken for the right one: its name, and its size in that unit.
struct Range {
    key: &'static str,
    unit: &'static str,
    least: f64,
    most: f64,
    mistaken: [(&'static str, f64); 2],
}

/// Values of real solids, from gels to diamond, from aerated concrete to osmium.
const RANGES: [Range; 3] = [
    Range {
        key: "youngs_modulus",
        unit: "Pa",
        least: 1e6,
        most: 2e12,
        mistaken: [("GPa", 1e9), ("MPa", 1e6)],
    },
    Range {
        key: "density",
        unit: "kg/m³",
        least: 50.0,
        most: 25_000.0,
        mistaken: [("g/cm³", 1e3), ("t/mm³", 1e12)],
    },
    Range {
        key: "tensile_strength",
        unit: "Pa",
        least: 500.0,
        most: 2e10,
        mistaken: [("MPa", 1e6), ("kPa", 1e3)],
    },
];

/// Gravity beyond which it is hardly meant, even in a centrifuge, m/s².
const HEAVY: f64 = 5000.0;

/// Numbers of materials that look as if they were in other units, and gravity that does.
pub(crate) fn units<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>) {
    for material in &model.materials {
        for range in &RANGES {
            let value = match range.key {
                "youngs_modulus" => Some(material.youngs_modulus),
                "density" => Some(material.density),
                _ => material.strength.map(|strength| strength.tensile),
            };
            warnings.extend(value.and_then(|value| question(material, range, value)));
        }
    }
    let gravity = model.gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
    if gravity > HEAVY {
        warnings.push(format!(
            "[model] gravity = [{}] m/s² is {} times that of the earth: are the units m/s²?",
            model.gravity.map(brief).join(", "),
            (gravity / 9.81).round()
        ));
    }
}

fn question(material: &Material, range: &Range, value: f64) -> Option<String> {
    let Range { key, unit, least, most, mistaken } = range;
    if (*least..=*most).contains(&value) {
        return None;
    }
    let what = if value < *least { "little" } else { "much" };
    let meant = mistaken.iter().find(|(_, factor)| (*least..=*most).contains(&(value * factor)));
    let meant = meant.map_or_else(String::new, |(unit, factor)| {
        format!(": if {unit} are meant, write {:e}", value * factor)
    });
    Some(format!(
        "[[material]] \"{}\": {key} = {} {unit} is {what} for a solid{meant}",
        material.name,
        brief(value)
    ))
}

/// Keys that change nothing.
pub(crate) fn without_effect<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    model: &Model<D, N>,
    warnings: &mut Vec<String>,
) {
    for (index, body) in file.body.iter().enumerate() {
        for key in idle_keys(body) {
            if document.has(Table::of("body", index), key) {
                warnings.push(format!("[[body]] \"{}\": {key} changes nothing here", body.name));
            }
        }
    }
    for boundary in &file.boundary {
        warnings.extend(idle(boundary).map(|what| format!("[[boundary]] \"{}\": {what}", boundary.name)));
    }
    for (number, material) in (0..).zip(&file.material) {
        if !model.mesh.materials.contains(&number) {
            warnings.push(format!("[[material]] \"{}\" is that of no element", material.name));
        }
    }
}

/// Keys that have no effect on a body of this kind.
fn idle_keys(body: &Body) -> Vec<&'static str> {
    let mut keys = Vec::new();
    if body.mesh.is_some() {
        keys.push("seed");
    }
    if let Some(packing) = &body.packing {
        let has_corners = matches!(packing.shape, Some(Piece::Polygon | Piece::Polyhedron));
        if !has_corners {
            keys.push("packing.corners");
        }
        if packing.file.is_some() {
            keys.push("packing.gap");
            if !has_corners && packing.copies_of.is_none() {
                keys.push("packing.seed");
            }
        }
    }
    keys
}

/// Describes a part of a boundary that has no effect, if there is one.
fn idle(boundary: &Boundary) -> Option<String> {
    let scheduled = match (&boundary.ramp, &boundary.table) {
        (Some(_), _) => Some("ramp"),
        (None, Some(_)) => Some("table"),
        (None, None) => None,
    };
    let free = |components: &Option<Vec<Component>>| {
        components
            .as_ref()
            .is_some_and(|components| components.iter().all(|component| component.prescribed().is_none()))
    };
    if let (Some(key), true) = (scheduled, boundary.fixed.is_some()) {
        return Some(format!("{key} changes nothing where the body is fixed"));
    }
    if let (Some(key), true) = (scheduled, boundary.absorbing) {
        return Some(format!("{key} changes nothing where waves are absorbed"));
    }
    if free(&boundary.velocity) || free(&boundary.displacement) {
        return Some("all components are free, so that it does nothing".to_owned());
    }
    None
}
