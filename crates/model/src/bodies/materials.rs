//! Materials and interfaces: names, ranges, strengths.

use fdem_simulation::{Interface, Material, MaterialLaw, Plane, Strength};

use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, suggestion};
use crate::text::file::ModelFile;

/// The five keys that a strength needs.
const STRENGTH: [&str; 5] =
    ["tensile_strength", "cohesion", "friction_angle", "fracture_energy_i", "fracture_energy_ii"];

/// The materials in the order of the file.
pub(crate) fn materials(
    file: &ModelFile,
    document: &Document<'_>,
    dimensions: u8,
    faults: &mut Vec<Fault>,
) -> Vec<Material> {
    let strain = dimensions == 3 || matches!(file.model.plane, Plane::Strain);
    let mut materials = Vec::with_capacity(file.material.len());
    for (index, material) in file.material.iter().enumerate() {
        let table = Table::of("material", index);
        if strain && material.poissons_ratio >= 0.5 {
            faults.push(
                Fault::at(
                    document.value(table, "poissons_ratio"),
                    "in plane strain and in three dimensions Poisson's ratio is below 0.5",
                )
                .label("out of range"),
            );
        }
        let keys = Keys {
            values: [
                material.tensile_strength,
                material.cohesion,
                material.friction_angle,
                material.fracture_energy_i,
                material.fracture_energy_ii,
            ],
            weibull_modulus: material.weibull_modulus,
            seed: material.weibull_seed,
        };
        materials.push(Material {
            name: material.name.clone(),
            density: material.density,
            youngs_modulus: material.youngs_modulus,
            poissons_ratio: material.poissons_ratio,
            law: MaterialLaw::NeoHookean,
            damping: material.damping,
            strength: keys.strength(&format!("[[material]] \"{}\"", material.name), table, document, faults),
            friction: material.friction,
        });
    }
    materials
}

/// The interfaces; each pair once.
pub(crate) fn interfaces(
    file: &ModelFile,
    document: &Document<'_>,
    faults: &mut Vec<Fault>,
) -> Vec<Interface> {
    let mut interfaces: Vec<Interface> = Vec::new();
    for (index, interface) in file.interface.iter().enumerate() {
        let table = Table::of("interface", index);
        let known = faults.len();
        let mut materials = [0, 0];
        for (place, name) in interface.materials.iter().enumerate() {
            match number(file, name) {
                Ok(number) => materials[place] = number,
                Err(help) => faults.push(unknown(document.entry(table, "materials", place), name, help)),
            }
        }
        let keys = Keys {
            values: [
                interface.tensile_strength,
                interface.cohesion,
                interface.friction_angle,
                interface.fracture_energy_i,
                interface.fracture_energy_ii,
            ],
            weibull_modulus: interface.weibull_modulus,
            seed: interface.weibull_seed,
        };
        let strength = keys.strength("[[interface]]", table, document, faults);
        if faults.len() > known {
            continue;
        }
        materials.sort_unstable();
        if interfaces.iter().any(|other| other.materials == materials) {
            faults.push(
                Fault::at(
                    document.value(table, "materials"),
                    "there is an [[interface]] of these two already",
                )
                .label("again"),
            );
            continue;
        }
        let lesser =
            materials.map(|m| file.material[m as usize].friction).into_iter().fold(f64::INFINITY, f64::min);
        interfaces.push(Interface {
            materials,
            friction: interface.friction.unwrap_or(lesser),
            penalty: interface.penalty,
            strength,
        });
    }
    interfaces
}

/// Returns the number of a material, or advice if there is none of this name.
pub(crate) fn number(file: &ModelFile, name: &str) -> Result<u32, String> {
    let place = file.material.iter().position(|material| material.name == name);
    place.map(|place| place as u32).ok_or_else(|| {
        let names: Vec<&str> = file.material.iter().map(|material| material.name.as_str()).collect();
        suggestion(name, &names, "[[material]]")
    })
}

/// The fault of a name that no material has.
pub(crate) fn unknown(span: std::ops::Range<usize>, name: &str, help: String) -> Fault {
    Fault::at(span, format!("there is no material \"{name}\"")).label("unknown material").help(help)
}

/// The keys of the strength of a table.
struct Keys {
    /// Values of the keys [`STRENGTH`].
    values: [Option<f64>; 5],
    weibull_modulus: Option<f64>,
    seed: u64,
}

impl Keys {
    /// The strength, if its keys are complete; none, if none is given.
    fn strength(
        &self,
        name: &str,
        table: Table,
        document: &Document<'_>,
        faults: &mut Vec<Fault>,
    ) -> Option<Strength> {
        let [tensile, cohesion, angle, energy_i, energy_ii] = self.values;
        // A strength of 0, which the schema allows for interfaces only, needs no fracture energy.
        let energy = |strength: Option<f64>, energy: Option<f64>| {
            energy.or(strength.filter(|strength| *strength == 0.0))
        };
        let (energy_i, energy_ii) = (energy(tensile, energy_i), energy(cohesion, energy_ii));
        for (key, strength, energy) in
            [("fracture_energy_i", tensile, energy_i), ("fracture_energy_ii", cohesion, energy_ii)]
        {
            if strength.is_some_and(|strength| strength > 0.0) && energy == Some(0.0) {
                faults.push(
                    Fault::at(
                        document.value(table, key),
                        format!("\"{key}\" is 0: it has to be above 0 where the strength is"),
                    )
                    .label("out of range"),
                );
            }
        }
        if let (Some(tensile), Some(cohesion), Some(angle), Some(energy_i), Some(energy_ii)) =
            (tensile, cohesion, angle, energy_i, energy_ii)
        {
            return Some(Strength {
                tensile,
                cohesion,
                friction: libm::tan(angle.to_radians()),
                energy_i,
                energy_ii,
                weibull_modulus: self.weibull_modulus,
                seed: self.seed,
            });
        }
        let values = [tensile, cohesion, angle, energy_i, energy_ii];
        let has = |wanted: bool| {
            let keys = STRENGTH.iter().zip(values).filter(move |(_, value)| value.is_some() == wanted);
            keys.map(|(key, _)| *key).collect::<Vec<_>>()
        };
        let given = has(true).first().copied().or(self.weibull_modulus.map(|_| "weibull_modulus"));
        if let Some(given) = given {
            let lacks = has(false).join(", ");
            faults.push(
                Fault::at(document.key(table, given), format!("{name} has a strength that is not complete"))
                    .label(format!("needs {lacks}"))
                    .help(format!("add {lacks}, or take {given} out: then it does not break")),
            );
        }
        None
    }
}
