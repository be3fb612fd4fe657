//! Pressures in holes and cracks, and schedules of loads: their values in the model, and refusals.

use fdem_model::{Quantity, prepare};
use fdem_simulation::{Load, Probe, Schedule, Target};

use crate::{read, right};

/// A plate with a round hole, and an open joint beside it.
fn plate(boundary: &str) -> String {
    format!(
        r#"[model]
end_time = 1e-3
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
[[boundary]]
name = "charge"
{boundary}
"#
    )
}

#[test]
fn a_cavity_is_the_hole_or_the_open_joint_at_a_point() {
    let in_hole = right(&plate("at = [0.3, 0.2]\npressure = 1e6\ncavity = true\ngas_exponent = 1.4"));
    let by_group = right(&plate("group = \"holes\"\npressure = 1e6\ncavity = true"));
    let boundary = &in_hole.model.boundaries[0];
    assert_eq!(boundary.load, Load::Cavity { pressure: 1e6, gas: Some(1.4) });
    assert_eq!(by_group.model.boundaries[0].load, Load::Cavity { pressure: 1e6, gas: None });
    let sorted = |target: &Target| {
        let mut facets = target.facets().to_vec();
        facets.sort_unstable();
        facets
    };
    assert_eq!(sorted(&boundary.target), sorted(&by_group.model.boundaries[0].target));
    let on_joint = right(&plate("at = [0.72, 0.251]\npressure = 1e6\ncavity = true"));
    let [edge] = on_joint.model.boundaries[0].target.facets() else { panic!("one edge of the joint") };
    let [a, b] = edge.map(|node| on_joint.model.mesh.nodes[node as usize]);
    assert!(a[1] == 0.25 && b[1] == 0.25 && (a[0] - 0.72) * (b[0] - 0.72) <= 0.0, "{a:?} {b:?}");
}

#[test]
fn a_cavity_has_columns_in_the_history() {
    let text = plate("at = [0.25, 0.25]\npressure = 1e6\ncavity = true");
    let prepared = right(&format!("{text}[[history]]\nname = \"gas\"\ncavity = \"charge\"\n"));
    assert_eq!(prepared.histories[0].quantity, Quantity::Probe(0));
    assert_eq!(prepared.probes[0], Probe::Cavity("charge".to_owned()));
    let errors = read(&format!("{text}[[history]]\nname = \"gas\"\ncavity = \"charg\"\n")).unwrap_err();
    let message = errors.to_string();
    assert!(message.contains("there is no cavity \"charg\"") && message.contains("charge"), "{message}");
}

#[test]
fn cavities_that_are_none_are_refused() {
    for (keys, message) in [
        ("at = [0.5, 0.4]\npressure = 1e6\ncavity = true", "a cavity is in a hole or on an open joint"),
        ("at = [0.25, 0.25]\npressure = 1e6", "\"at\" is for a cavity"),
        ("side = \"left\"\npressure = 1e6\ngas_exponent = 1.4", "\"gas_exponent\" is for a cavity"),
        ("side = \"left\"\nfixed = \"x\"\ncavity = true", "a cavity has no pressure"),
        (
            "at = [0.25, 0.25]\nside = \"left\"\npressure = 1e6\ncavity = true",
            "is in two places, side and at",
        ),
        ("at = [0.25, 0.25, 0]\npressure = 1e6\ncavity = true", "\"at\" has 3 numbers"),
        (
            "side = \"left\"\npressure = 1e6\ncavity = true\ngas_exponent = 1.4",
            "a gas begins in a closed hole",
        ),
        (
            "at = [0.25, 0.25]\npressure = 1e6\ncavity = true\ngas_exponent = 1.4\nramp = 1e-4",
            "a gas has no \"ramp\"",
        ),
        ("at = [0.25, 0.25]\npressure = 1e6\ncavity = true\ngas_exponent = 1", "gas_exponent"),
        (
            "at = [0.25, 0.25]\npressure = -1e6\ncavity = true\ngas_exponent = 1.4",
            "the pressure of a gas is not negative",
        ),
    ] {
        let found = read(&plate(keys)).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(message), "{keys}\n{found}");
    }
}

#[test]
fn loads_follow_files_and_expressions_of_the_time() {
    let text = |keys: &str| plate(&format!("side = \"left\"\npressure = 2e6\n{keys}"));
    let file = |content: &'static str| {
        let mut load = move |name: &str| {
            if name == "p.csv" { Ok(content.as_bytes().to_vec()) } else { Err("no file".to_owned()) }
        };
        prepare(&text("table_file = \"p.csv\""), "model.toml", &mut load)
    };
    let schedule = |prepared: fdem_model::Prepared| prepared.model.boundaries[0].schedule.clone();
    let read_in = file("time,factor\n0,0\n1e-4,1\n# end\n2e-4,0.5\n").unwrap();
    assert_eq!(schedule(read_in), Schedule::Table(vec![[0.0, 0.0], [1e-4, 1.0], [2e-4, 0.5]]));
    for (content, message) in [
        ("0,0\n0,1\n", "the times do not ascend"),
        ("", "p.csv has no rows"),
        ("0,0\nx,1\n", "row 2 is not a time and a factor"),
    ] {
        let found = file(content).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(message), "{found}");
    }
    // The times have no unit, or all of them have one.
    for expression in ["exp(-t/2e-4)", "exp(-t/0.2ms)", "exp(-t/(200 us))", "1*exp(-t*5 kHz)"] {
        let falling = schedule(right(&text(&format!("expression = \"{expression}\""))));
        for time in [0.0_f64, 1.1e-5, 3e-4, 1e-3] {
            assert!((falling.factor(time) - (-time / 2e-4).exp()).abs() < 1e-6, "{expression} {time}");
        }
    }
    for (keys, message) in [
        ("expression = \"exp(-x)\"", "\"x\" is not the time t"),
        ("expression = \"1/t\"", "not a finite number"),
        (
            "expression = \"exp(-t/1ms) + t/1e-3\"",
            "all its times have a unit, as in \"exp(-t/1ms)\", or none",
        ),
        ("expression = \"2 MPa*exp(-t/1e-3)\"", "it is a stress, and a factor is a number without a unit"),
        ("table_file = \"none.csv\"", "cannot read none.csv"),
        ("ramp = 1e-4\nexpression = \"t\"", "has both ramp and expression"),
    ] {
        let found = read(&text(keys)).map(|_| ()).unwrap_err().to_string();
        assert!(found.contains(message), "{keys}\n{found}");
    }
}
