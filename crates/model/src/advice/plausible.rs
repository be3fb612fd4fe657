//! Keys and numbers of a model file that are allowed, but probably not meant.

use fdem_io::numbers::brief;
use fdem_mesh::bounds;
use fdem_simulation::{LoadEffect, LoadSummary, Material, Model};

use crate::advice::deforming;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{Body, Boundary, Component, ModelFile, PieceShape, Stage};

/// A place in the text of a model, in bytes.
type Span = std::ops::Range<usize>;

/// A quantity with the values that solids have, and the unit that is mistaken for the right one: its name,
/// and its size in that unit.
struct Range {
    key: &'static str,
    unit: &'static str,
    least: f64,
    most: f64,
    mistaken: [(&'static str, f64); 2],
}

/// Values of real solids, from gels to diamond, from aerated concrete to osmium.
const RANGES: [Range; 6] = [
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
    Range { key: "cohesion", unit: "Pa", least: 0.0, most: 1e11, mistaken: [("MPa", 1e6), ("kPa", 1e3)] },
    Range {
        key: "fracture_energy_i",
        unit: "J/m²",
        least: 0.0,
        most: 1e9,
        mistaken: [("N/m", 1.0), ("N/mm", 1e3)],
    },
    Range {
        key: "fracture_energy_ii",
        unit: "J/m²",
        least: 0.0,
        most: 1e9,
        mistaken: [("N/m", 1.0), ("N/mm", 1e3)],
    },
];

/// Coefficient of friction beyond which it is hardly meant.
const ROUGH: f64 = 10.0;

/// Gravity beyond which it is hardly meant, even in a centrifuge, m/s².
const HEAVY: f64 = 5000.0;

/// Numbers of materials that look as if they were in other units, and gravity that does.
pub(crate) fn units<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>) {
    for material in &model.materials {
        // An unbreakable material has an energy that no number of a file comes near to.
        let strength = material.strength.filter(|strength| strength.energy_i < 1e3 * material.youngs_modulus);
        for range in &RANGES {
            let value = match range.key {
                "youngs_modulus" => Some(material.youngs_modulus),
                "density" => Some(material.density),
                "cohesion" => strength.map(|strength| strength.cohesion),
                "fracture_energy_i" => strength.map(|strength| strength.energy_i),
                "fracture_energy_ii" => strength.map(|strength| strength.energy_ii),
                _ => strength.map(|strength| strength.tensile),
            };
            warnings.extend(value.and_then(|value| question(material, range, value)));
        }
        if material.friction > ROUGH {
            warnings.push(format!(
                "[[material]] \"{}\": friction = {} is much: coefficients of friction are mostly below 1",
                material.name,
                brief(material.friction)
            ));
        }
    }
    for interface in model.interfaces.iter().filter(|interface| interface.friction > ROUGH) {
        // An interface without a friction has the friction of a material, which is reported above.
        let names = interface.materials.map(|number| &model.materials[number as usize]);
        if names.iter().all(|material| material.friction != interface.friction) {
            warnings.push(format!(
                "[[interface]] of \"{}\" and \"{}\": friction = {} is much: coefficients of friction are mostly below 1",
                names[0].name,
                names[1].name,
                brief(interface.friction)
            ));
        }
    }
    let gravity = model.gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
    if gravity > HEAVY {
        warnings.push(format!(
            "[model] gravity = [{}] m/s² is {} times that of the earth: are the units m/s²?",
            model.gravity.map(brief).join(", "),
            brief((gravity / 9.81).round())
        ));
    }
    if model.gravity[D - 1] > 0.0 {
        warnings.push(format!(
            "[model] gravity = [{}] m/s² acts upwards, along +{}: write a negative number for down",
            model.gravity.map(brief).join(", "),
            if D > 2 { "z" } else { "y" }
        ));
    }
}

/// Loads and stresses beyond all that the materials carry.
pub(crate) fn loads<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>) {
    let stiffest = model.materials.iter().map(Material::stiffest_modulus).fold(0.0, f64::max);
    let [low, high] = bounds(model.mesh.nodes.iter().copied());
    let width = (0..D).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let (section, product) = if D == 2 {
        (width * model.thickness, "width of the model times its thickness")
    } else {
        (width * width, "width of the model squared")
    };
    let length = |vector: &[f64]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    let deforms = deforming::nodes(model);
    for boundary in &model.boundaries {
        let title = format!("[[boundary]] \"{}\"", boundary.name);
        let LoadSummary { key, effect, components, .. } = boundary.load.summary();
        let size = length(&components);
        let stress = match effect {
            LoadEffect::Force => size / section,
            LoadEffect::Stress => size,
            LoadEffect::Velocity | LoadEffect::Displacement | LoadEffect::Support => continue,
        };
        // A rigid body has no stress.
        let on_stress = || boundary.target.nodes().iter().any(|&node| deforms[node as usize]);
        if stress > stiffest && on_stress() {
            let over =
                if effect == LoadEffect::Force { format!(" over the {product}") } else { String::new() };
            warnings.push(format!(
                "{title}: its {key}{over} is {} Pa, above the largest Young's modulus, {} Pa: no body carries that",
                brief(stress),
                brief(stiffest)
            ));
        }
    }
    let most = model.stresses.iter().flatten().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    if most > stiffest {
        warnings.push(format!(
            "[initial] stress is up to {} Pa, above the largest Young's modulus, {} Pa: no body carries that",
            brief(most),
            brief(stiffest)
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

/// Keys that change nothing, with a warning; parts of the model that have no effect, which are faults unless
/// they are `optional`. `is_in_model`: whether a place is in the model file itself. Included files may have
/// materials for other models.
pub(crate) fn without_effect<const D: usize, const N: usize>(
    file: &ModelFile,
    (document, is_in_model): (&Document<'_>, &dyn Fn(&Span) -> bool),
    model: &Model<D, N>,
    warnings: &mut Vec<String>,
    faults: &mut Vec<Fault>,
) {
    for (index, body) in file.body.iter().enumerate() {
        for key in idle_keys(body, D) {
            if document.has(Table::of("body", index), key) {
                warnings.push(format!("[[body]] \"{}\": {key} changes nothing here", body.name));
            }
        }
    }
    warnings.extend(idle_seeds(file, document));
    for (index, boundary) in file.boundary.iter().enumerate() {
        warnings.extend(idle(boundary).map(|what| format!("[[boundary]] \"{}\": {what}", boundary.name)));
        let free = |components: &Option<Vec<Component>>| {
            components
                .as_ref()
                .is_some_and(|components| components.iter().all(|component| component.prescribed().is_none()))
        };
        let prescribed = [("velocity", &boundary.velocity), ("displacement", &boundary.displacement)];
        if let Some((key, _)) = prescribed.into_iter().find(|(_, components)| free(components)) {
            let span = document.value(Table::of("boundary", index), key);
            let message = format!("[[boundary]] \"{}\" does nothing: all components are free", boundary.name);
            faults.push(Fault::at(span, message).label("prescribe at least one"));
        }
    }
    let spare = "remove it, or set optional = true";
    let of_spheres = |name: &str| {
        file.grains.iter().any(|of| of.material == name)
            || file.insertion.iter().any(|of| of.material == name)
            || file.wall.iter().any(|of| of.material == name)
    };
    for (index, material) in file.material.iter().enumerate() {
        let in_a_stage = |stage: &Stage| stage.materials.values().any(|name| *name == material.name);
        let span = document.value(Table::of("material", index), "name");
        if material.optional
            || model.mesh.materials.contains(&(index as u32))
            || file.stage.iter().any(in_a_stage)
            || of_spheres(&material.name)
            || !is_in_model(&span)
        {
            continue;
        }
        let message = format!("[[material]] \"{}\" is that of no element", material.name);
        faults.push(Fault::at(span, message).label("not used").help(spare));
    }
}

/// Seeds of strengths that do not scatter.
fn idle_seeds(file: &ModelFile, document: &Document<'_>) -> Vec<String> {
    let has_seed = |table: &'static str, index: usize| document.has(Table::of(table, index), "weibull_seed");
    let of_materials = file
        .material
        .iter()
        .enumerate()
        .filter(|(index, material)| material.weibull_modulus.is_none() && has_seed("material", *index));
    let of_interfaces =
        file.interface.iter().enumerate().filter(|(index, interface)| {
            interface.weibull_modulus.is_none() && has_seed("interface", *index)
        });
    let titles = of_materials.map(|(_, material)| format!("[[material]] \"{}\"", material.name));
    let titles = titles.chain(of_interfaces.map(|(_, interface)| {
        let [one, other] = &interface.materials;
        format!("[[interface]] of \"{one}\" and \"{other}\"")
    }));
    titles.map(|title| format!("{title}: weibull_seed changes nothing without weibull_modulus")).collect()
}

/// Keys that have no effect on a body of this kind.
fn idle_keys(body: &Body, dimensions: usize) -> Vec<&'static str> {
    let mut keys = Vec::new();
    if body.angle == 0.0 {
        keys.push("axis");
    }
    if dimensions == 3 {
        keys.push("voronoi.rounds");
    }
    if body.mesh.is_some() {
        keys.push("seed");
    }
    let has_file = body.packing.as_ref().is_some_and(|packing| {
        packing.file.is_some() || packing.copies_of.as_ref().is_some_and(|of| of.surface.is_some())
    });
    if body.mesh.is_none() && body.surface.is_none() && !has_file {
        keys.push("scale");
    }
    let copied = body.packing.as_ref().and_then(|packing| packing.copies_of.as_ref());
    if body.surface.is_none() && copied.is_none_or(|of| of.surface.is_none()) {
        keys.push("close_holes");
    }
    if body.surface.is_none() {
        keys.push("surface_tolerance");
    }
    if let Some(packing) = &body.packing {
        let has_corners = matches!(packing.shape, Some(PieceShape::Polygon | PieceShape::Polyhedron));
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
    if let (Some(key), true) = (scheduled, boundary.fixed.is_some()) {
        return Some(format!("{key} changes nothing where the body is fixed"));
    }
    if let (Some(key), true) = (scheduled, boundary.absorbing) {
        return Some(format!("{key} changes nothing where waves are absorbed"));
    }
    None
}
