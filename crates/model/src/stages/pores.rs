//! Liquid in pores: its constants, the pores of materials, and the stages in which they have it.

use std::collections::{BTreeMap, BTreeSet};

use fdem_mesh::{Mesh, sorted};
use fdem_simulation::fluid::{Drive, FluidError, PoreLiquid, PorousMaterial, Schedule};
use fdem_simulation::{Model, Plane, PoreOptions, PoreSurface, Target};

use crate::bodies::dimensions::Dimensions;
use crate::bodies::materials;
use crate::stages::acting;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, Gravity, MaterialPores, ModelFile, Permeability};

/// Viscosity, Pa s, density, kg/m³, and bulk modulus, Pa, of water at 20 °C.
const WATER: [f64; 3] = [1e-3, 998.0, 2.2e9];

/// Checks the pores before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, dimensions: u8, faults: &mut Vec<Fault>) {
    let table = Table::one("pores");
    let Some(pores) = &file.pores else {
        without(file, document, faults);
        return;
    };
    if file.body.is_empty() {
        faults.push(
            Fault::at(document.extent(table), "a model without bodies has no pores").label("take it out"),
        );
        return;
    }
    if dimensions == 2 && file.model.plane == Plane::Stress {
        let span = document.value_if_any(Table::one("model"), "plane").unwrap_or(document.extent(table));
        faults.push(
            Fault::at(span, "[pores]: the change of the volume of pores is not known in plane stress")
                .label("plane stress")
                .help("write plane = \"strain\" in [model]"),
        );
    }
    check_begin(file, pores, document, faults);
    check_cracks(file, document, faults);
    let is_used = |name: &String| {
        materials::is_first(file, name)
            || file.stage.iter().any(|stage| stage.materials.values().any(|material| material == name))
    };
    if !file.material.iter().any(|material| material.pores.is_some() && is_used(&material.name)) {
        faults.push(
            Fault::at(document.extent(table), "[pores]: no body has a material with \"pores\"")
                .label("a liquid without pores")
                .help(
                    "give a [[material]] pores = { permeability = 1e-15, biot = 0.8, biot_modulus = \"8 GPa\" }",
                ),
        );
    }
    for (index, material) in file.material.iter().enumerate() {
        let Some(of_material) = &material.pores else { continue };
        let found = if dimensions == 3 {
            wrong_pores::<3, 4>(file, material, of_material)
        } else {
            wrong_pores::<2, 3>(file, material, of_material)
        };
        for (key, message, help) in found {
            let span = document.value(Table::of("material", index), &format!("pores.{key}"));
            let message = format!("[[material]] \"{}\": {message}", material.name);
            faults.push(Fault::at(span, message).label("of these pores").maybe_help(help));
        }
    }
}

/// Reports keys that need a liquid.
fn without(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let help = "add a table [pores], or take it out";
    for (index, material) in file.material.iter().enumerate().filter(|(_, of)| of.pores.is_some()) {
        let message = format!("[[material]] \"{}\": \"pores\" need a liquid", material.name);
        let span = document.key(Table::of("material", index), "pores");
        faults.push(Fault::at(span, message).label("no [pores]").help(help));
    }
    for (index, surface) in file.pore_surface.iter().enumerate() {
        let message = format!("[[pore_surface]] \"{}\": there is no liquid in pores", surface.name);
        let span = document.key(Table::of("pore_surface", index), "name");
        faults.push(Fault::at(span, message).label("no [pores]").help(help));
    }
}

/// Checks the pressure at the beginning, and the stage in which pores begin to have their liquid.
fn check_begin(file: &ModelFile, pores: &file::Pores, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let table = Table::one("pores");
    acting::check_from_stage(file, table, pores.from_stage.as_deref(), document, faults);
    if pores.water_level.is_none() {
        return;
    }
    if pores.initial_pressure.is_some() {
        let message = "[pores] has both initial_pressure and water_level";
        faults.push(Fault::at(document.key(table, "water_level"), message).label("take one of them"));
    }
    let has_weight =
        matches!(&file.model.gravity, Gravity::Vector(gravity) if gravity.0.iter().any(|of| *of != 0.0));
    if !has_weight {
        let message = "[pores]: a \"water_level\" needs gravity";
        faults.push(
            Fault::at(document.key(table, "water_level"), message)
                .label("no gravity")
                .help("write gravity = [0, -9.81] in [model], in three dimensions [0, 0, -9.81]"),
        );
    }
}

/// Checks that the fluid in cracks goes with the liquid in pores.
fn check_cracks(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let (table, Some(fluid)) = (Table::one("fluid"), &file.fluid) else { return };
    if fluid.leak_off != 0.0 {
        let message = "[fluid]: with [pores], fluid in cracks flows into the pores, and \"leak_off\" would take it twice";
        let span = document.value(table, "leak_off");
        faults.push(Fault::at(span, message).label("not with [pores]").help("take it out"));
    }
    if fluid.gas_exponent.is_some() {
        let message =
            "[fluid]: a gas in cracks does not go with the liquid of [pores], with which it would mix";
        let span = document.value(table, "gas_exponent");
        faults.push(Fault::at(span, message).label("a gas").help("take [pores] out, or gas_exponent"));
    }
}

/// A fault of the pores of a material: its key, a message, and advice.
type PoreFault = (&'static str, String, Option<String>);

/// The faults of the pores of a material.
fn wrong_pores<const D: usize, const N: usize>(
    file: &ModelFile,
    material: &file::Material,
    pores: &MaterialPores,
) -> Vec<PoreFault>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let fault = |key, message: &str| vec![(key, message.to_owned(), None)];
    let is_positive = |tensor: [[f64; D]; D]| (0..D).all(|axis| tensor[axis][axis] > 0.0);
    match tensor::<D, N>(&pores.permeability) {
        None => {
            let forms =
                if D == 2 { "[x, y] or [xx, yy, xy]" } else { "[x, y, z] or [xx, yy, zz, xy, yz, xz]" };
            let message = format!("a permeability in {D} dimensions is one number, {forms}");
            return fault("permeability", &message);
        }
        Some(tensor) if !is_positive(tensor) => {
            let mut faults = fault("permeability", "a permeability is above 0 in all directions");
            faults[0].2 = Some("a material without \"pores\" is one through which nothing flows".to_owned());
            return faults;
        }
        Some(_) => {}
    }
    match (pores.biot_modulus, pores.porosity) {
        (Some(_), Some(_)) => return fault("porosity", "its pores have both biot_modulus and porosity"),
        (None, None) => return fault("permeability", "its pores lack biot_modulus or porosity"),
        (Some(_), None) if pores.grain_modulus.is_some() => {
            return fault("grain_modulus", "\"grain_modulus\" goes with porosity, and not with biot_modulus");
        }
        (None, Some(porosity)) if porosity > pores.biot => {
            let message = format!("its porosity of {porosity} is above its biot of {}", pores.biot);
            return fault("porosity", &message);
        }
        _ => {}
    }
    if pores.porosity.is_some()
        && pores.biot < 1.0
        && pores.grain_modulus.is_none()
        && material.anisotropy.is_some()
    {
        return fault("porosity", "pores of a material with anisotropy and a porosity need a grain_modulus");
    }
    let Some(found) = porous::<D, N>(file, material) else { return Vec::new() };
    match found.check("pores") {
        Ok(()) => Vec::new(),
        Err(FluidError::OutOfRange { what: "storage", .. }) => {
            fault("porosity", "its pores store no liquid: their compressibility is not above 0")
        }
        Err(error) => fault("permeability", &error.to_string()),
    }
}

/// The permeability, m²; `None` if it has another number of components.
fn tensor<const D: usize, const N: usize>(permeability: &Permeability) -> Option<[[f64; D]; D]>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let along = |values: [f64; D]| {
        std::array::from_fn(|row| std::array::from_fn(|k| if k == row { values[row] } else { 0.0 }))
    };
    match permeability {
        Permeability::Isotropic(value) => Some(along([*value; D])),
        Permeability::Tensor(values) if values.len() == D => values[..].try_into().ok().map(along),
        Permeability::Tensor(values) if values.len() == D * (D + 1) / 2 => {
            Some(<[[f64; D]; N]>::stress(values))
        }
        Permeability::Tensor(_) => None,
    }
}

/// Viscosity, Pa s, density, kg/m³, and bulk modulus, Pa, of the liquid.
fn liquid(file: &ModelFile) -> [f64; 3] {
    let given = |of: &file::Pores| [of.viscosity, of.density, of.bulk_modulus];
    let own = file.pores.as_ref().map_or([None; 3], given);
    let of_cracks = |of: &file::Fluid| [Some(of.viscosity), of.density, of.bulk_modulus];
    let other = file.fluid.as_ref().map_or([None; 3], of_cracks);
    [0, 1, 2].map(|k| own[k].or(other[k]).unwrap_or(WATER[k]))
}

/// The pores of a material; `None` if it has none, or if their permeability is wrong.
fn porous<const D: usize, const N: usize>(
    file: &ModelFile,
    material: &file::Material,
) -> Option<PorousMaterial<D>>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let pores = material.pores.as_ref()?;
    let storage = pores.biot_modulus.map_or_else(
        || {
            let bulk = material.youngs_modulus / (3.0 - 6.0 * material.poissons_ratio);
            // Rigid grains for a coefficient of 1.
            let grains = pores.grain_modulus.unwrap_or(bulk / (1.0 - pores.biot));
            let [.., of_liquid] = liquid(file);
            PorousMaterial::<D>::storage_of(pores.porosity.unwrap_or(0.0), pores.biot, of_liquid, grains)
        },
        f64::recip,
    );
    Some(PorousMaterial { permeability: tensor::<D, N>(&pores.permeability)?, biot: pores.biot, storage })
}

/// The liquid and the pores of a model, without their surfaces; `None` if the file has none.
pub(crate) fn options<const D: usize, const N: usize>(
    file: &ModelFile,
    mesh: &Mesh<D, N>,
    gravity: [f64; D],
) -> Option<PoreOptions<D>>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let pores = file.pores.as_ref()?;
    let [viscosity, density, _] = liquid(file);
    let size = gravity.iter().map(|of| of * of).sum::<f64>().sqrt();
    let height = |place: &[f64; D]| -(0..D).map(|axis| gravity[axis] * place[axis]).sum::<f64>() / size;
    let pressure = |place: &[f64; D]| match pores.water_level {
        Some(level) => density * size * (level - height(place)),
        None => pores.initial_pressure.unwrap_or(0.0),
    };
    let materials = file.material.iter().map(|material| porous::<D, N>(file, material)).collect();
    Some(PoreOptions {
        initial_pressures: mesh.nodes.iter().map(pressure).collect(),
        steps: pores.steps,
        ..PoreOptions::new(PoreLiquid { viscosity, density, gravity }, materials)
    })
}

/// The number of the stage from which on pores have their liquid; `None` if no stage has the name.
pub(crate) fn first_stage(file: &ModelFile) -> Option<usize> {
    acting::first_stage(file, file.pores.as_ref()?.from_stage.as_deref())
}

/// The pores of a model that has their liquid from the beginning.
pub(crate) fn at_first<'a, const D: usize>(
    file: &ModelFile,
    pores: Option<&'a PoreOptions<D>>,
) -> Option<&'a PoreOptions<D>> {
    pores.filter(|_| first_stage(file) == Some(0))
}

/// `α p` of an element with these nodes at the beginning, Pa; 0 without pores.
pub(crate) fn push<const D: usize, const N: usize>(
    pores: Option<&PoreOptions<D>>,
    nodes: &[u32; N],
    material: u32,
) -> f64 {
    pores.map_or(0.0, |pores| pores.first_push(nodes, material))
}

/// Mass of the water on each unit of area of ground with a surface at this height, kg/m²: up to the level of
/// the water.
pub(crate) fn standing<const D: usize>(
    file: &ModelFile,
    pores: Option<&PoreOptions<D>>,
    surface: f64,
) -> f64 {
    let level = file.pores.as_ref().and_then(|pores| pores.water_level);
    pores.zip(level).map_or(0.0, |(pores, level)| pores.liquid.density * (level - surface).max(0.0))
}

/// Whether each surface acts in a stage, by its number; `None` if pores have no liquid there.
pub(crate) fn act(file: &ModelFile, stage: usize) -> Option<Vec<bool>> {
    acting::act(file, first_stage(file), stage, file.pore_surface.iter().map(|of| of.stages.as_deref()))
}

/// A sealed surface: it keeps its column in the history.
pub(crate) fn sealed() -> Drive {
    Drive::Rate(Schedule::constant(0.0))
}

/// Leaves to each surface of a model the facets that are outer ones of elements with pores, and nodes of
/// these elements, and to each node one prescribed pressure, that of the first surface. Surfaces of which
/// nothing is left are taken out; returns their names.
pub(crate) fn settle<const D: usize, const N: usize>(model: &mut Model<D, N>) -> Vec<String> {
    let Some(pores) = &mut model.pores else { return Vec::new() };
    let materials = &pores.materials;
    let has_pores = |element: usize| {
        let material = model.mesh.materials[element] as usize;
        materials.get(material).is_some_and(Option::is_some)
    };
    let mut taken: BTreeSet<u32> = BTreeSet::new();
    let (mut kept, mut lost): (Vec<PoreSurface<D>>, Vec<String>) = (Vec::new(), Vec::new());
    for mut surface in std::mem::take(&mut pores.surfaces) {
        match &mut surface.target {
            Target::Nodes(nodes) => keep_nodes(&model.mesh, has_pores, nodes),
            Target::Facets(facets) | Target::Held(facets, _) => keep_outer(&model.mesh, has_pores, facets),
        }
        if matches!(surface.drive, Drive::Pressure(_)) {
            let mut nodes = surface.target.nodes();
            let count = nodes.len();
            nodes.retain(|node| taken.insert(*node));
            if nodes.len() < count {
                surface.target = Target::Nodes(nodes);
            }
        }
        if surface.target.nodes().is_empty() {
            lost.push(surface.name);
        } else {
            kept.push(surface);
        }
    }
    pores.surfaces = kept;
    lost
}

/// Keeps the nodes of elements with pores.
fn keep_nodes<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    has_pores: impl Fn(usize) -> bool,
    nodes: &mut Vec<u32>,
) {
    let wanted: BTreeSet<u32> = nodes.iter().copied().collect();
    let of_pores = (0..mesh.elements.len()).filter(|element| has_pores(*element));
    let found: BTreeSet<u32> =
        of_pores.flat_map(|element| mesh.elements[element]).filter(|node| wanted.contains(node)).collect();
    nodes.retain(|node| found.contains(node));
}

/// Keeps the facets of one element alone that has pores.
pub(crate) fn keep_outer<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    has_pores: impl Fn(usize) -> bool,
    facets: &mut Vec<[u32; D]>,
) {
    let mut is_near = vec![false; mesh.nodes.len()];
    for node in facets.as_flattened() {
        is_near[*node as usize] = true;
    }
    let is_near = |facet: &[u32; D]| facet.iter().all(|node| is_near[*node as usize]);
    // The number of elements of each facet, and of those with pores.
    let mut counts: BTreeMap<[u32; D], [u32; 2]> =
        facets.iter().map(|facet| (sorted(*facet), [0; 2])).collect();
    for (element, nodes) in mesh.elements.iter().enumerate() {
        // Each facet is without one of the corners.
        let without = |one: usize| std::array::from_fn(|k| nodes[if k < one { k } else { k + 1 }]);
        for facet in (0..N).map(without).filter(is_near) {
            if let Some([all, with_pores]) = counts.get_mut(&sorted(facet)) {
                *all += 1;
                *with_pores += u32::from(has_pores(element));
            }
        }
    }
    facets.retain(|facet| counts.get(&sorted(*facet)) == Some(&[1; 2]));
}
