//! Fluid in cracks: its values in the model, the places of injections, stages, and refusals.

use std::fmt::Write;

use fdem_model::{AnyPrepared, Entered, Prepared, prepare_any};
use fdem_simulation::fluid::{Connection, Drive, Scheme, StateEquation};
use fdem_simulation::{Schedule, WetFrom};

use crate::{read, right};

/// A plate with a round hole, an open joint and a closed one, and more tables.
fn plate(more: &str) -> String {
    format!(
        r#"[model]
end_time = 1e-3
plane = "strain"
thickness = 2
gravity = [0, -10]
[[body]]
name = "plate"
material = "rock"
rectangle = {{ min = [0, 0], max = [1, 0.5], holes = [{{ centre = [0.25, 0.25], radius = 0.1 }}] }}
mesh_size = 0.05
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
[[joint_set]]
name = "crack"
lines = [[0.6, 0.25, 0.9, 0.25]]
friction_angle = 30
open = true
aperture = "0.1 mm"
reference_stress = "10 MPa"
[[joint_set]]
name = "closed"
lines = [[0.6, 0.1, 0.9, 0.1]]
friction_angle = 30
[[boundary]]
name = "mud"
group = "holes"
pressure = 1e5
[[boundary]]
name = "left"
side = "left"
fixed = "x"
{more}
"#
    )
}

fn with_injection(keys: &str) -> String {
    plate(&format!("[fluid]\n[[injection]]\nname = \"pump\"\n{keys}"))
}

#[test]
fn keys_of_the_fluid_are_those_of_the_model() {
    let text = plate(
        r#"[fluid]
viscosity = "2 cP"
density = 900
bulk_modulus = "1 GPa"
cavitation_pressure = -1e5
wet_from = "break"
scheme = "explicit"
connection = "cavities"
steps = 3
leak_off = "1e-5 m/s^0.5"
initial_pressure = "1 bar"
residual_aperture = "2 um"
max_aperture = "5 mm"
roughness_factor = 0.8
"#,
    );
    let fluid = right(&text).model.fluid.unwrap();
    assert_eq!(fluid.flow.fluid.viscosity, 2e-3);
    let (density, reference_pressure, bulk_modulus, cavitation_pressure) = (900.0, 0.0, 1e9, -1e5);
    let liquid = StateEquation::Liquid { density, reference_pressure, bulk_modulus, cavitation_pressure };
    assert_eq!(fluid.flow.fluid.state, liquid);
    assert_eq!((fluid.flow.gravity, fluid.flow.thickness), ([0.0, -10.0], 2.0));
    assert_eq!((fluid.flow.scheme, fluid.flow.connection), (Scheme::Explicit, Connection::Cavities));
    assert_eq!((fluid.wet_from, fluid.steps, fluid.leak_off), (WetFrom::Break, 3, 1e-5));
    assert_eq!((fluid.initial_pressure, fluid.aperture.residual), (Some(1e5), 2e-6));
    let [crack, closed] = fluid.set_apertures[..] else { panic!("two sets") };
    assert_eq!((crack.initial, crack.reference_stress, crack.largest), (1e-4, Some(1e7), 5e-3));
    assert_eq!(closed, fluid.aperture);
    let gas = "[fluid]\ngas_exponent = 1.4\ndensity = 1.2\nreference_pressure = 1e5";
    let state = right(&plate(gas)).model.fluid.unwrap().flow.fluid.state;
    assert_eq!(state, StateEquation::Gas { density: 1.2, reference_pressure: 1e5, exponent: 1.4 });
}

/// The facets of the injection, sorted.
fn facets(prepared: &Prepared) -> Vec<[u32; 2]> {
    let mut facets = prepared.model.fluid.as_ref().unwrap().sources[0].facets.clone();
    facets.sort_unstable();
    facets
}

#[test]
fn an_injection_is_in_a_hole_or_at_the_nearest_facet_of_a_joint() {
    let in_hole = right(&with_injection("at = [0.3, 0.2]\nrate = 1e-3"));
    assert!(facets(&in_hole).len() > 8);
    for keys in ["group = \"holes\"", "group = \"hole-1\"", "boundary = \"mud\""] {
        assert_eq!(facets(&right(&with_injection(keys))), facets(&in_hole), "{keys}");
    }
    let on_joint = right(&with_injection("at = [0.72, 0.251]\npressure = 1e6"));
    let [edge] = facets(&on_joint)[..] else { panic!("one edge") };
    let [a, b] = edge.map(|node| on_joint.model.mesh.nodes[node as usize]);
    assert!(a[1] == 0.25 && b[1] == 0.25 && (a[0] - 0.72) * (b[0] - 0.72) <= 0.0, "{a:?} {b:?}");
    // A closed set with an aperture takes fluid, too.
    let closed = "aperture = 1e-4\n[[boundary]]\nname = \"mud\"";
    let conducting = with_injection("at = [0.72, 0.1]").replace("[[boundary]]\nname = \"mud\"", closed);
    let [edge] = facets(&right(&conducting))[..] else { panic!("one edge") };
    assert_eq!(edge.map(|node| right(&conducting).model.mesh.nodes[node as usize][1]), [0.1; 2]);
}

#[test]
fn rates_and_pressures_follow_their_schedules() {
    let drive = |keys: &str| {
        right(&with_injection(&format!("at = [0.25, 0.25]\n{keys}"))).model.fluid.unwrap().sources[0]
            .drive
            .clone()
    };
    let Some(Drive::Rate(rate)) = drive("rate = \"2 cm^3/s\"\ntable = [[0, 0], [1e-4, 1], [2e-4, -1]]")
    else {
        panic!("a rate")
    };
    assert_eq!([0.0, 5e-5, 1e-4, 1.0].map(|time| rate.at(time)), [0.0, 1e-6, 2e-6, -2e-6]);
    let Some(Drive::Pressure(pressure)) = drive("pressure = \"4 MPa\"\nramp = 1e-4") else {
        panic!("a pressure")
    };
    for time in [0.0, 1.3e-5, 5e-5, 1e-4, 1.0] {
        let expected = 4e6 * Schedule::Ramp(1e-4).factor(time);
        assert!((pressure.at(time) - expected).abs() < 4e6 * 2e-4, "{time}");
    }
    assert_eq!(drive(""), None);
}

#[test]
fn an_injection_in_space_is_on_a_face_of_a_joint() {
    let text = r#"[model]
end_time = 1e-3
[[body]]
name = "ball"
material = "rock"
tube = { from = [0, 0, 0], to = [0, 0, 1], radius = 0.5, inner_radius = 0.25 }
mesh_size = 0.2
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
[fluid]
[[injection]]
name = "pump"
group = "outer"
"#;
    let found = prepare_any(text, "model.toml", &mut |_| Err(String::new()), None).unwrap_err().to_string();
    assert!(found.contains("do not enclose a hole") || found.contains("no body has a group"), "{found}");
    let joint = text.replace("group = \"outer\"", "at = [0.36, 0.01, 0.5]").replace(
        "[fluid]",
        "[[joint_set]]\nname = \"crack\"\npolygons = [[0.2, -0.2, 0.5, 0.6, -0.2, 0.5, 0.6, 0.2, 0.5, 0.2, 0.2, 0.5]]\nfriction_angle = 30\nopen = true\n[fluid]",
    );
    let prepared = prepare_any(&joint, "model.toml", &mut |_| Err(String::new()), None).unwrap();
    let AnyPrepared::Space(prepared) = prepared else { panic!("in space") };
    let [face] = prepared.model.fluid.unwrap().sources[0].facets[..] else { panic!("one face") };
    let heights = face.map(|node| prepared.model.mesh.nodes[node as usize][2]);
    assert!(heights.iter().all(|z| (z - 0.5).abs() < 0.1 && (z - heights[0]).abs() < 1e-9), "{heights:?}");
}

/// A cube of 27 cubes without the one in its middle, as a mesh file.
fn hollow_cube() -> String {
    let mut text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n64\n".to_owned();
    for node in 0..64 {
        writeln!(text, "{} {} {} {}", node + 1, node % 4, node / 4 % 4, node / 16).unwrap();
    }
    let mut elements = Vec::new();
    for cell in (0..27).filter(|cell| *cell != 13) {
        let first = cell % 3 + 4 * (cell / 3 % 3) + 16 * (cell / 9) + 1;
        // Six tetrahedra around the diagonal, one for each order of the axes.
        for [a, b, c] in [[1, 4, 16], [1, 16, 4], [4, 1, 16], [4, 16, 1], [16, 1, 4], [16, 4, 1]] {
            elements.push([first, first + a, first + a + b, first + a + b + c]);
        }
    }
    writeln!(text, "$EndNodes\n$Elements\n{}", elements.len()).unwrap();
    for (number, [a, b, c, d]) in elements.into_iter().enumerate() {
        writeln!(text, "{} 4 2 1 1 {a} {b} {c} {d}", number + 1).unwrap();
    }
    text + "$EndElements\n"
}

#[test]
fn an_injection_in_space_is_in_a_cavity() {
    let text = |place: &str| {
        format!(
            "[model]\nend_time = 1e-3\n[[body]]\nname = \"cube\"\nmaterial = \"rock\"\nmesh = \"cube.msh\"\n\
             [[material]]\nname = \"rock\"\ndensity = 2700\nyoungs_modulus = 30e9\npoissons_ratio = 0.25\n\
             [[boundary]]\nname = \"inside\"\nbox = [0.9, 0.9, 0.9, 2.1, 2.1, 2.1]\npressure = 1\n\
             [[boundary]]\nname = \"outside\"\npressure = 1\nside = \"left\"\n\
             [fluid]\n[[injection]]\nname = \"pump\"\n{place}\n"
        )
    };
    let faces = |place: &str| {
        let mut load = |_: &str| Ok(hollow_cube().into_bytes());
        let prepared =
            prepare_any(&text(place), "model.toml", &mut load, None).map_err(|wrong| wrong.to_string())?;
        let AnyPrepared::Space(prepared) = prepared else { panic!("in space") };
        let mut faces = prepared.model.fluid.unwrap().sources[0].facets.clone();
        faces.sort_unstable();
        Ok::<_, String>(faces)
    };
    let inside = faces("boundary = \"inside\"").unwrap();
    assert_eq!(inside.len(), 12);
    assert_eq!(faces("at = [1.5, 1.4, 1.6]").unwrap(), inside);
    let error = faces("boundary = \"outside\"").unwrap_err();
    assert!(error.contains("do not enclose a hole"), "{error}");
}

/// Fluid begins in the second of three stages, and is pumped there alone.
#[test]
fn stages_have_their_fluid_and_their_injections() {
    let stages = "[[stage]]\nname = \"dry\"\nduration = 1e-4\n[[stage]]\nname = \"pump\"\nduration = 1e-4\n\
                  [[stage]]\nname = \"shut in\"\n";
    let text = plate(&format!(
        "{stages}[fluid]\nfrom_stage = \"pump\"\n[[injection]]\nname = \"well\"\nat = [0.25, 0.25]\nrate = 1e-3\n\
         stages = [\"pump\"]\ntable = [[0, 1], [5e-5, 2]]\n"
    ));
    let prepared = right(&text);
    let entered = |begun: &[u64]| Entered { begun: begun.to_vec(), ..Entered::alone(begun.len() - 1) };
    let fluid = |begun: &[u64]| prepared.at(&entered(begun), 1e-6).unwrap().prepared.model.fluid;
    assert!(fluid(&[0]).is_none());
    let Some(Drive::Rate(rate)) = fluid(&[0, 70]).unwrap().sources[0].drive.clone() else { panic!("a rate") };
    assert_eq!([7e-5, 1.2e-4].map(|time| rate.at(time)), [1e-3, 2e-3]);
    let last = fluid(&[0, 70, 170]).unwrap();
    assert!(last.sources[0].drive.is_none() && last.sources[0].facets.len() == facets(&prepared).len());
    assert!(prepared.in_stages().is_ok());
}

#[test]
fn injections_that_are_nowhere_are_refused() {
    for (keys, message) in [
        ("at = [0.45, 0.4]", "joint_set]] \"crack\" at"),
        ("at = [0.72, 0.1]", "\"closed\", which is closed: give the set an aperture"),
        ("at = [0.3, 0.2, 0]", "\"at\" has 3 numbers"),
        ("at = [0.72, 0.25]\ninitial_pressure = 1", "\"initial_pressure\" is that of a hole"),
        ("group = \"hole-2\"", "no body has a group \"hole-2\""),
        ("group = \"outer\"", "do not enclose a hole"),
        ("boundary = \"left\"", "no boundary \"left\" with a load on edges or faces"),
        ("rate = 1", "[[injection]] \"pump\" has no place"),
        ("at = [0.25, 0.25]\ngroup = \"holes\"", "in two places, at and group"),
        ("at = [0.25, 0.25]\nrate = 1\npressure = 1", "has both rate and pressure"),
        ("at = [0.25, 0.25]\nramp = 1", "it has none"),
        ("at = [0.25, 0.25]\npressure = -1e6", "below the lowest one of the fluid"),
        (
            "at = [0.25, 0.25]\npressure = 1e6\ntable = [[0, 1], [0, 2]]",
            "the times of its table do not ascend",
        ),
        ("at = [0.25, 0.25]\npressure = 1e6\ntable_file = \"no.csv\"", "cannot read no.csv"),
        ("at = [0.25, 0.25]\nstages = [\"one\"]", "there is no stage \"one\""),
        ("at = [0.25, 0.25]\nrate = \"1 m/s\"", "rate is in m³/s"),
    ] {
        let found = read(&with_injection(keys)).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(message) && found.contains("model.toml:"), "{keys}\n{found}");
    }
}

#[test]
fn bad_fluid_is_refused_with_its_key() {
    for (fluid, message) in [
        ("[fluid]\nviscosity = 0", "viscosity"),
        ("[fluid]\nsteps = 0", "steps"),
        ("[fluid]\nroughness_factor = 1.5", "roughness_factor"),
        ("[fluid]\naperture = -1e-6", "aperture"),
        ("[fluid]\nviscosty = 1", "did you mean \"viscosity\"?"),
        ("[fluid]\nscheme = \"euler\"", "implicit"),
        ("[fluid]\ngas_exponent = 1.4\ndensity = 1.2", "a gas needs a reference_pressure"),
        ("[fluid]\ngas_exponent = 1.4\ndensity = 1\nreference_pressure = 0", "is above 0"),
        (
            "[fluid]\ngas_exponent = 1.4\ndensity = 1\nreference_pressure = 1\nbulk_modulus = 1",
            "is for a liquid",
        ),
        ("[fluid]\nbulk_modulus = 2.2\nreference_pressure = 1e5", "further apart than the bulk_modulus"),
        ("[fluid]\ninitial_pressure = -1", "below the lowest pressure of the fluid"),
        ("[fluid]\nmax_aperture = 1e-5", "aperture of 0.0001 m is above its max_aperture"),
        ("[fluid]\nresidual_aperture = 2", "residual_aperture of 2 m is above its max_aperture"),
        ("[fluid]\nfrom_stage = \"two\"", "there is no stage \"two\""),
        ("[[injection]]\nname = \"pump\"\nat = [0.25, 0.25]", "there is no fluid"),
        ("", "[[joint_set]] \"crack\": \"aperture\" is for a fluid"),
    ] {
        let found = read(&plate(fluid)).map(|_| ()).unwrap_err();
        assert!(found.to_string().contains(message), "{fluid}\n{found}");
        assert!(found.faults.iter().all(|fault| fault.span.is_some()), "{found}");
    }
}

#[test]
fn columns_of_the_history_have_one_name_each() {
    let injection = "[[injection]]\nname = \"pump\"\nat = [0.25, 0.25]\n";
    let history = "[[history]]\nname = \"pump\"\nenergy = true\n";
    for (more, message) in [
        (format!("{injection}{history}"), "there is a [[history]] \"pump\""),
        (injection.replace("pump", "fluid"), "cannot have the name \"fluid\""),
        (format!("{injection}{injection}"), "there is a [[injection]] \"pump\" already"),
        (history.replace("pump", "fluid"), "cannot have the name \"fluid\""),
    ] {
        let found = read(&plate(&format!("[fluid]\n{more}"))).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(message), "{more}\n{found}");
    }
}
