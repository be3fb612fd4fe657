//! Surfaces of pairs of materials, for contacts of spheres.

use std::collections::BTreeSet;

use fdem_simulation::Material;
use fdem_simulation::grains::{GrainMaterial, Surfaces};

use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{Interface, ModelFile};

/// Damping of rolling, if there is rolling friction and an interface does not say otherwise.
const ROLLING_DAMPING: f64 = 0.3;

/// Materials of spheres and walls: those of bodies, number by number.
pub(crate) fn materials(materials: &[Material]) -> Vec<GrainMaterial> {
    let of = |material: &Material| GrainMaterial {
        density: material.density,
        youngs_modulus: material.youngs_modulus,
        poissons_ratio: material.poissons_ratio,
    };
    materials.iter().map(of).collect()
}

/// The surfaces of all pairs of materials. Reports pairs that may touch without a coefficient of restitution.
pub(crate) fn surfaces(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) -> Vec<Surfaces> {
    let mut surfaces = Vec::new();
    let (of_spheres, of_partners) = touching(file);
    let may_touch = |one: &str, other: &str| of_spheres.contains(one) && of_partners.contains(other);
    for (second, b) in file.material.iter().enumerate() {
        for (first, a) in file.material[..=second].iter().enumerate() {
            let interface = file.interface.iter().find(|interface| {
                let [one, other] = &interface.materials;
                (*one == a.name && *other == b.name) || (*one == b.name && *other == a.name)
            });
            let of = |value: fn(&Interface) -> Option<f64>| interface.and_then(value);
            let lesser = match (a.restitution, b.restitution) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (one, other) => one.or(other),
            };
            let restitution = of(|interface| interface.restitution).or(lesser);
            if restitution.is_none() && (may_touch(&a.name, &b.name) || may_touch(&b.name, &a.name)) {
                faults.push(unknown(file, document, [first, second]));
            }
            let rolling = of(|interface| interface.rolling_friction)
                .unwrap_or_else(|| a.rolling_friction.min(b.rolling_friction));
            let damping = if rolling > 0.0 { ROLLING_DAMPING } else { 0.0 };
            surfaces.push(Surfaces {
                materials: [first as u32, second as u32],
                restitution: restitution.unwrap_or(1.0),
                friction: of(|interface| interface.friction).unwrap_or_else(|| a.friction.min(b.friction)),
                rolling_friction: rolling,
                rolling_damping: of(|interface| interface.rolling_damping).unwrap_or(damping),
                twisting_friction: of(|interface| interface.twisting_friction).unwrap_or(0.0),
                adhesion: of(|interface| interface.adhesion).unwrap_or(0.0),
            });
        }
    }
    surfaces
}

/// Keys of contacts of spheres that change nothing.
pub(crate) fn without_effect(file: &ModelFile, surfaces: &[Surfaces]) -> Vec<String> {
    let (of_spheres, of_partners) = touching(file);
    let mut warnings = Vec::new();
    for (number, material) in (0..).zip(&file.material) {
        let name = material.name.as_str();
        let rolls = |of: &Surfaces| {
            let [a, b] = of.materials.map(|of| file.material[of as usize].name.as_str());
            let is_of_spheres = of_spheres.contains(a) || of_spheres.contains(b);
            of.materials.contains(&number) && is_of_spheres && of.rolling_friction > 0.0
        };
        if material.rolling_friction > 0.0 && of_partners.contains(name) && !surfaces.iter().any(rolls) {
            warnings.push(format!(
                "[[material]] \"{name}\": rolling_friction changes nothing: spheres that touch it have less, and the lesser one counts"
            ));
        }
    }
    for interface in &file.interface {
        let keys = [
            ("restitution", interface.restitution.is_some()),
            ("rolling_friction", interface.rolling_friction.is_some()),
            ("rolling_damping", interface.rolling_damping.is_some()),
            ("twisting_friction", interface.twisting_friction.is_some()),
            ("adhesion", interface.adhesion.is_some()),
        ];
        let [one, other] = interface.materials.each_ref().map(String::as_str);
        let Some((key, _)) = keys.into_iter().find(|(_, given)| *given) else { continue };
        if !of_spheres.contains(one) && !of_spheres.contains(other) {
            warnings.push(format!(
                "[[interface]] of \"{one}\" and \"{other}\": {key} changes nothing: no spheres are of these materials"
            ));
        }
    }
    warnings
}

/// Names of the materials of spheres, and of all that spheres may touch.
fn touching(file: &ModelFile) -> (BTreeSet<&str>, BTreeSet<&str>) {
    let mut of_spheres: BTreeSet<&str> = file.grains.iter().map(|grains| grains.material.as_str()).collect();
    of_spheres.extend(file.insertion.iter().map(|insertion| insertion.material.as_str()));
    let mut of_partners = of_spheres.clone();
    of_partners.extend(file.wall.iter().map(|wall| wall.material.as_str()));
    for body in &file.body {
        of_partners.insert(&body.material);
        of_partners.extend(body.groups.values().map(String::as_str));
        of_partners.extend(body.voronoi.iter().flat_map(|of| of.materials.iter().map(String::as_str)));
    }
    let later = file.stage.iter().flat_map(|stage| stage.materials.values());
    of_partners.extend(later.map(String::as_str));
    (of_spheres, of_partners)
}

/// The fault of two materials that may touch, and of which nothing says how they rebound.
fn unknown(file: &ModelFile, document: &Document<'_>, [first, second]: [usize; 2]) -> Fault {
    let [a, b] = [first, second].map(|of| file.material[of].name.as_str());
    let message = if first == second {
        format!("[[material]] \"{a}\": spheres of it may touch each other, and it has no restitution")
    } else {
        format!("[[material]] \"{b}\": spheres may touch it with \"{a}\", and neither has a restitution")
    };
    let help = if first == second {
        "write its coefficient of restitution, such as restitution = 0.5".to_owned()
    } else {
        format!(
            "write restitution = 0.5 into one of them, or [[interface]] with materials = [\"{a}\", \"{b}\"] and restitution = 0.5"
        )
    };
    Fault::at(document.value(Table::of("material", second), "name"), message)
        .label("needs restitution")
        .help(help)
}
