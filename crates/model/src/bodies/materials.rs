//! Materials and interfaces: names, ranges, strengths.

use fdem_io::numbers::brief;
use fdem_simulation::{Bedding, Interface, Material, MaterialLaw, Plane, Strength};

use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, suggestion};
use crate::text::file::ModelFile;

/// The five keys that a strength needs.
pub(crate) const STRENGTH: [&str; 5] =
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
        if strain && material.poissons_ratio >= 0.5 && material.anisotropy.is_none() {
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
        let name = format!("[[material]] \"{}\"", material.name);
        let mut strength = keys.strength(&name, table, document, faults);
        if material.unbreakable {
            if let Some(given) = keys.given() {
                faults.push(
                    Fault::at(
                        document.key(table, given),
                        format!("{name} is unbreakable and has a strength"),
                    )
                    .label("a strength")
                    .help("take the keys of the strength out, or unbreakable"),
                );
            }
            strength = replaces(file, &material.name).then(|| unreachable(material.youngs_modulus));
        }
        let law = law(material, dimensions, strength, (table, document), faults);
        materials.push(Material {
            name: material.name.clone(),
            density: material.density,
            youngs_modulus: material.youngs_modulus,
            poissons_ratio: material.poissons_ratio,
            law,
            damping: material.damping,
            strength,
            friction: material.friction,
        });
    }
    materials
}

/// Whether a material replaces others in a stage, and no body has it from the beginning.
fn replaces(file: &ModelFile, name: &str) -> bool {
    let later = file.stage.iter().flat_map(|stage| stage.materials.values()).any(|material| material == name);
    later && !is_first(file, name)
}

/// Whether a body has the material from the beginning.
pub(crate) fn is_first(file: &ModelFile, name: &str) -> bool {
    let of_grains = |body: &crate::file::Body| {
        body.voronoi.as_ref().is_some_and(|grains| grains.materials.iter().any(|material| material == name))
    };
    file.body.iter().any(|body| body.material == name || of_grains(body))
}

/// A strength that nothing reaches, for joints that an unbreakable material takes over from one that breaks.
/// `e`: Young's modulus, Pa. The energy is above that of any joint up to its strength, which for elements of
/// the size h and a penalty p is e h/(2 p).
fn unreachable(e: f64) -> Strength {
    let energy = 1e4 * e;
    Strength {
        tensile: e,
        cohesion: e,
        friction: 1.0,
        energy_i: energy,
        energy_ii: energy,
        weibull_modulus: None,
        seed: 0,
    }
}

/// The law of a material. `across`: strength of the material, which is that across the bedding if it has one.
fn law(
    material: &crate::file::Material,
    dimensions: u8,
    across: Option<Strength>,
    (table, document): (Table, &Document<'_>),
    faults: &mut Vec<Fault>,
) -> MaterialLaw {
    let Some(anisotropy) = &material.anisotropy else { return MaterialLaw::NeoHookean };
    let (dip, tensile_strength, cohesion) =
        (anisotropy.dip, anisotropy.tensile_strength, anisotropy.cohesion);
    let place = |key: &str| format!("anisotropy.{key}");
    let [sin, cos] = [libm::sin(dip.to_radians()), libm::cos(dip.to_radians())];
    let mut fault = |key: &str, text: String, label: &str| {
        faults.push(Fault::at(document.value(table, &place(key)), text).label(label));
    };
    let normal = if dimensions == 3 {
        if dip < 0.0 {
            fault("dip", "in three dimensions the dip is 0 to 90 degrees".to_owned(), "out of range");
        }
        let direction = anisotropy.dip_direction.unwrap_or(0.0).to_radians();
        [sin * libm::sin(direction), sin * libm::cos(direction), cos]
    } else {
        if anisotropy.dip_direction.is_some() {
            let text = "in two dimensions the bedding has a dip and no direction".to_owned();
            fault("dip_direction", text, "three dimensions only");
        }
        [-sin, cos, 0.0]
    };
    let given = [
        ("tensile_strength", tensile_strength),
        ("cohesion", cohesion),
        ("fracture_energy_i", anisotropy.fracture_energy_i),
        ("fracture_energy_ii", anisotropy.fracture_energy_ii),
    ];
    let first = given.iter().find(|(_, value)| value.is_some());
    let strength = match (across, tensile_strength, cohesion) {
        (Some(across), Some(tensile), Some(cohesion)) => Some(Strength {
            tensile,
            cohesion,
            energy_i: anisotropy.fracture_energy_i.unwrap_or(across.energy_i),
            energy_ii: anisotropy.fracture_energy_ii.unwrap_or(across.energy_ii),
            ..across
        }),
        (Some(_), ..) => {
            if let Some((key, _)) = first {
                let lacks = if tensile_strength.is_none() { "tensile_strength" } else { "cohesion" };
                fault(key, format!("the strength of the bedding lacks {lacks}"), "is not complete");
            }
            None
        }
        (None, ..) => {
            if let Some((key, _)) = first {
                let text = "the bedding has a strength, and the material has none".to_owned();
                fault(key, text, "needs the strength across the bedding");
            }
            None
        }
    };
    let bedding = Bedding {
        normal,
        youngs_modulus: anisotropy.youngs_modulus,
        poissons_ratio: anisotropy.poissons_ratio,
        shear_modulus: anisotropy.shear_modulus,
        strength,
    };
    let along = [material.youngs_modulus, material.poissons_ratio];
    faults.extend(unstable(&bedding, along, document.value(table, &place("poissons_ratio"))));
    MaterialLaw::TransverselyIsotropic(bedding)
}

/// The fault of constants with which some deformation has a negative energy. `[e, nu]`: those along the
/// bedding; `span`: the place of Poisson's ratio across it.
fn unstable(bedding: &Bedding, [e, nu]: [f64; 2], span: std::ops::Range<usize>) -> Option<Fault> {
    let stability = bedding.stability(e, nu);
    let most = (0.5 * (1.0 - nu) * bedding.youngs_modulus / e).sqrt();
    (stability <= 0.0).then(|| {
        let text = format!(
            "some deformations would have a negative energy: 1 - ν - 2 ν'² E/E' is {}, and has to be above 0",
            brief(stability)
        );
        Fault::at(span, text)
            .label("too large")
            .help(format!("with these moduli, poissons_ratio across the bedding is below {}", brief(most)))
    })
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

/// Returns the number of a material, or advice if this name does not exist.
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
    /// The first key that is given.
    fn given(&self) -> Option<&'static str> {
        let first = STRENGTH.iter().zip(self.values).find_map(|(key, value)| value.map(|_| *key));
        first.or(self.weibull_modulus.map(|_| "weibull_modulus"))
    }

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
        if let Some(given) = self.given() {
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
