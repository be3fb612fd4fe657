//! Fluid in cracks: its constants, apertures of joint sets, and the stages in which it is there.

use fdem_simulation::fluid::{ApertureLaw, Connection, FlowModel, Fluid, Scheme, StateEquation};
use fdem_simulation::{FluidOptions, WetFrom};

use crate::stages::acting;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, ConnectionWord, ModelFile, SchemeWord, WetFromWord};

/// Keys of joint sets that are for a fluid.
const OF_SETS: [&str; 5] =
    ["aperture", "residual_aperture", "max_aperture", "reference_stress", "roughness_factor"];

/// Bulk modulus of water, Pa.
const BULK_MODULUS: f64 = 2.2e9;

/// Checks the fluid before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let table = Table::one("fluid");
    let Some(fluid) = &file.fluid else {
        without(file, document, faults);
        return;
    };
    check_state(fluid, document, faults);
    acting::check_from_stage(file, table, fluid.from_stage.as_deref(), document, faults);
    if file.body.is_empty() {
        faults.push(
            Fault::at(document.extent(table), "a model without bodies has no cracks for a fluid")
                .label("take it out"),
        );
    }
    let mut apertures = vec![("[fluid]".to_owned(), table, aperture(fluid))];
    for (index, set) in file.joint_set.iter().enumerate() {
        let title = format!("[[joint_set]] \"{}\"", set.name);
        apertures.push((title, Table::of("joint_set", index), aperture_of_set(fluid, set)));
    }
    for (title, table, law) in apertures {
        for (key, value) in [("residual_aperture", law.residual), ("aperture", law.initial)] {
            // An entry for each table that has one of the two keys.
            let given = [key, "max_aperture"].into_iter().find(|key| document.has(table, key));
            if let Some(given) = given.filter(|_| value > law.largest) {
                faults.push(
                    Fault::at(
                        document.value(table, given),
                        format!(
                            "{title}: its {key} of {value} m is above its max_aperture of {} m",
                            law.largest
                        ),
                    )
                    .label("above the largest"),
                );
            }
        }
    }
}

/// Reports keys that need a fluid.
fn without(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let help = "add a table [fluid], such as [fluid] with viscosity = \"1 cP\", or take it out";
    for (index, injection) in file.injection.iter().enumerate() {
        faults.push(
            Fault::at(
                document.key(Table::of("injection", index), "name"),
                format!("[[injection]] \"{}\": there is no fluid", injection.name),
            )
            .label("no [fluid]")
            .help(help),
        );
    }
    for (index, set) in file.joint_set.iter().enumerate() {
        let table = Table::of("joint_set", index);
        for key in OF_SETS.into_iter().filter(|key| document.has(table, key)) {
            faults.push(
                Fault::at(
                    document.key(table, key),
                    format!("[[joint_set]] \"{}\": \"{key}\" is for a fluid", set.name),
                )
                .label("no [fluid]")
                .help(help),
            );
        }
    }
}

/// Checks the constants of a liquid or a gas.
fn check_state(fluid: &file::Fluid, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let table = Table::one("fluid");
    if fluid.gas_exponent.is_some() {
        for key in ["density", "reference_pressure"].into_iter().filter(|key| !document.has(table, key)) {
            faults.push(
                Fault::at(document.key(table, "gas_exponent"), format!("[fluid]: a gas needs a {key}"))
                    .label(format!("needs {key}"))
                    .help("a gas has the density at the reference_pressure, such as 1.2 kg/m³ at 1 bar"),
            );
        }
        for key in ["bulk_modulus", "cavitation_pressure"].into_iter().filter(|key| document.has(table, key))
        {
            faults.push(
                Fault::at(document.key(table, key), format!("[fluid]: \"{key}\" is for a liquid"))
                    .label("take it out, or gas_exponent"),
            );
        }
        if fluid.reference_pressure.is_some_and(|pressure| pressure <= 0.0) {
            faults.push(
                Fault::at(
                    document.value(table, "reference_pressure"),
                    "[fluid]: the reference_pressure of a gas is above 0: pressures of a gas are absolute",
                )
                .label("not above 0"),
            );
        }
    } else if let StateEquation::Liquid { reference_pressure, bulk_modulus, cavitation_pressure, .. } =
        state(fluid)
    {
        let key = ["cavitation_pressure", "reference_pressure", "bulk_modulus"];
        let given = key.into_iter().find(|key| document.has(table, key));
        if let Some(key) = given.filter(|_| (cavitation_pressure - reference_pressure).abs() > bulk_modulus) {
            faults.push(
                Fault::at(
                    document.value(table, key),
                    "[fluid]: the cavitation_pressure and the reference_pressure are further apart than the bulk_modulus",
                )
                .label("look at its unit"),
            );
        }
    }
    let lowest = state(fluid).lowest_pressure();
    if fluid.initial_pressure.is_some_and(|pressure| pressure < lowest) {
        faults.push(
            Fault::at(
                document.value(table, "initial_pressure"),
                format!(
                    "[fluid]: the initial_pressure is below the lowest pressure of the fluid, {lowest} Pa"
                ),
            )
            .label("too low"),
        );
    }
}

/// The equation of state. A gas has its keys.
pub(crate) fn state(fluid: &file::Fluid) -> StateEquation {
    let density = fluid.density.unwrap_or(Fluid::WATER.state.reference_density());
    let reference_pressure = fluid.reference_pressure.unwrap_or(0.0);
    match fluid.gas_exponent {
        Some(exponent) => StateEquation::Gas { density, reference_pressure, exponent },
        None => StateEquation::Liquid {
            density,
            reference_pressure,
            bulk_modulus: fluid.bulk_modulus.unwrap_or(BULK_MODULUS),
            cavitation_pressure: fluid.cavitation_pressure.unwrap_or(0.0),
        },
    }
}

/// The law of new cracks.
fn aperture(fluid: &file::Fluid) -> ApertureLaw {
    ApertureLaw {
        initial: fluid.aperture,
        factor: fluid.roughness_factor,
        residual: fluid.residual_aperture,
        largest: fluid.max_aperture,
        reference_stress: fluid.reference_stress,
    }
}

/// The law of a joint set.
pub(crate) fn aperture_of_set(fluid: &file::Fluid, set: &file::JointSet) -> ApertureLaw {
    let ApertureLaw { initial, factor, residual, largest, reference_stress } = aperture(fluid);
    ApertureLaw {
        initial: set.aperture.unwrap_or(initial),
        factor: set.roughness_factor.unwrap_or(factor),
        residual: set.residual_aperture.unwrap_or(residual),
        largest: set.max_aperture.unwrap_or(largest),
        reference_stress: set.reference_stress.or(reference_stress),
    }
}

/// The fluid of a model, without its sources; `None` if it has none.
pub(crate) fn options<const D: usize>(file: &ModelFile, gravity: [f64; D]) -> Option<FluidOptions<D>> {
    let fluid = file.fluid.as_ref()?;
    let flow = FlowModel {
        gravity,
        thickness: file.model.thickness,
        scheme: match fluid.scheme {
            SchemeWord::Implicit => Scheme::Implicit,
            SchemeWord::Explicit => Scheme::Explicit,
        },
        connection: match fluid.connection {
            ConnectionWord::Network => Connection::CubicLaw,
            ConnectionWord::Cavities => Connection::Cavities,
        },
        ..FlowModel::new(Fluid { viscosity: fluid.viscosity, state: state(fluid) })
    };
    Some(FluidOptions {
        wet_from: match fluid.wet_from {
            WetFromWord::Insertion => WetFrom::Insertion,
            WetFromWord::Break => WetFrom::Break,
        },
        steps: fluid.steps,
        aperture: aperture(fluid),
        set_apertures: file.joint_set.iter().map(|set| aperture_of_set(fluid, set)).collect(),
        leak_off: fluid.leak_off,
        initial_pressure: fluid.initial_pressure,
        ..FluidOptions::new(flow, Vec::new())
    })
}

/// The number of the stage from which on there is fluid; `None` if no stage has the name.
pub(crate) fn first_stage(file: &ModelFile) -> Option<usize> {
    acting::first_stage(file, file.fluid.as_ref()?.from_stage.as_deref())
}

/// Whether each injection pumps in a stage, by its number; `None` if there is no fluid.
pub(crate) fn pumps(file: &ModelFile, stage: usize) -> Option<Vec<bool>> {
    acting::act(file, first_stage(file), stage, file.injection.iter().map(|of| of.stages.as_deref()))
}
