//! Numbers so large or so small that no run is possible with them, refused at their key.

use fdem_io::numbers::brief;
use fdem_simulation::{CriticalStep, Element};

use crate::advice::preflight;
use crate::prepared::Prepared;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{ModelFile, TimeStep};

/// Error of the energy balance, as a share of the energy exchanged, that the rounding of forces makes in some
/// thousand steps.
const ROUNDING: f64 = 1e-12;

/// A number is suspect if it makes the time step this many times shorter than usual numbers do.
const MUCH: f64 = 1e3;

/// The largest usual multiples of Young's modulus in penalties of contacts and of joints.
const CONTACT: f64 = 10.0;
const JOINT: f64 = 100.0;

/// The largest Young's modulus, Pa, and the least density, kg/m³, of solids.
const STIFF: f64 = 2e12;
const LIGHT: f64 = 50.0;

/// Checks numbers before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let bound = file.model.energy_bound;
    if bound > 0.0 && bound < ROUNDING {
        let message = format!(
            "energy_bound = {} is below the rounding of energies, {ROUNDING:e}: any run would stop at the first check of its balance",
            brief(bound)
        );
        let fault = Fault::at(document.value(Table::one("model"), "energy_bound"), message);
        faults.push(fault.label("too small").help("a share of 0.01 to 0.1 is usual"));
    }
}

/// A number, its key, and how many times shorter it makes the time step than usual ones.
struct Suspect {
    times: f64,
    table: Table,
    key: &'static str,
    title: String,
    help: &'static str,
}

/// Refuses a model with more steps than can be counted, or with a time step that is never stable, at the
/// number that is the cause. Other causes are reported when the run is prepared.
pub(crate) fn steps<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    prepared: &Prepared<D, N>,
) -> Result<(), Fault>
where
    [[f64; D]; N]: Element<D, N>,
{
    let fault = |suspect: Suspect, why: String| {
        let span = document.value(suspect.table, suspect.key);
        Fault::at(span, format!("{}: {why}", suspect.title)).label("the cause").help(suspect.help)
    };
    if let TimeStep::Seconds(step) = file.model.time_step
        && let Some(why) = preflight::uncountable(prepared.end_time, step)
    {
        let title = format!("time_step = {} s", brief(step));
        let help = "take it out, or make it longer";
        let table = Table::one("model");
        return Err(fault(Suspect { times: 0.0, table, key: "time_step", title, help }, why));
    }
    let of_edges = prepared.quality.edges[1];
    let worst = suspects(file, of_edges).into_iter().max_by(|a, b| a.times.total_cmp(&b.times));
    let Some(worst) = worst.filter(|suspect| suspect.times > MUCH) else { return Ok(()) };
    // A model that cannot be simulated is reported by its preflight.
    let Ok(critical) = CriticalStep::of(&prepared.model) else { return Ok(()) };
    match preflight::steps(prepared, critical.step) {
        Ok(_) => Ok(()),
        Err(why) => Err(fault(worst, why)),
    }
}

/// Numbers on which the time step depends. `edge`: mean edge of the elements, m.
fn suspects(file: &ModelFile, edge: f64) -> Vec<Suspect> {
    let mut all = Vec::new();
    let mut add = |times: f64, table: Table, key: &'static str, title: String, help: &'static str| {
        all.push(Suspect { times, table, key, title, help });
    };
    let penalty = "a penalty is a multiple of Young's modulus: 1 to 10 is usual";
    let contact = file.contact.penalty;
    let title = format!("[contact] penalty = {}", brief(contact));
    add((contact / CONTACT).sqrt(), Table::one("contact"), "penalty", title, penalty);
    let title = format!("[contact] damping = {}", brief(file.contact.damping));
    let damping = "damping is a share of critical damping: at most 1 is usual";
    add(2.0 * file.contact.damping, Table::one("contact"), "damping", title, damping);
    let joint = file.fracture.joint_penalty;
    let title = format!("[fracture] joint_penalty = {}", brief(joint));
    let help = "a penalty is a multiple of Young's modulus: 10 to 100 is usual";
    add((joint / JOINT).sqrt(), Table::one("fracture"), "joint_penalty", title, help);
    let mut stiffest = 0.0_f64;
    for (index, material) in file.material.iter().enumerate() {
        let (table, name) = (Table::of("material", index), &material.name);
        let (modulus, density) = (material.youngs_modulus, material.density);
        stiffest = stiffest.max(modulus);
        let title = |key: &str, value: f64| format!("[[material]] \"{name}\": {key} = {}", brief(value));
        let title_of_modulus = title("youngs_modulus", modulus);
        add((modulus / STIFF).sqrt(), table, "youngs_modulus", title_of_modulus, "moduli are in Pa");
        let title_of_density = title("density", density);
        add((LIGHT / density).sqrt(), table, "density", title_of_density, "densities are in kg/m³");
        add(2.0 * material.damping, table, "damping", title("damping", material.damping), damping);
    }
    for (index, interface) in file.interface.iter().enumerate() {
        let (Some(own), [one, other]) = (interface.penalty, &interface.materials) else { continue };
        let title = format!("[[interface]] of \"{one}\" and \"{other}\": penalty = {} Pa", brief(own));
        let help = "here it is a modulus, Pa: 1 to 10 times that of the bodies is usual";
        add((own / (CONTACT * stiffest)).sqrt(), Table::of("interface", index), "penalty", title, help);
    }
    for (index, set) in file.joint_set.iter().enumerate() {
        for (key, stiffness) in
            [("normal_stiffness", set.normal_stiffness), ("shear_stiffness", set.shear_stiffness)]
        {
            let Some(own) = stiffness else { continue };
            let title = format!("[[joint_set]] \"{}\": {key} = {} Pa/m", set.name, brief(own));
            let times = (own * edge / (JOINT * stiffest)).sqrt();
            let help = "a stiffness is in Pa/m: that of rock joints is 1e9 to 1e12";
            add(times, Table::of("joint_set", index), key, title, help);
        }
    }
    all
}
