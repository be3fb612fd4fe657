//! Mass scaling, and advice for quasi-static runs.

use fdem_model::Preflight;

use crate::{SMALL, read, right};

/// The small model with a corner a millimetre from its neighbour, pulled at its top, with these keys of
/// `[model]`.
fn sliver(keys: &str) -> String {
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let polygon = "polygon = { points = [[0, 0], [1, 0], [1, 0.5], [0.501, 0.5], [0.5, 0.5], [0, 0.5]] }\nmesh_size = 0.05\n";
    let (_, end) = rest.split_once("mesh_size = 0.1\n").unwrap();
    let start = start.replace("end_time = 1e-3", &format!("end_time = 4e-3\n{keys}"));
    format!("{start}{polygon}{end}{BOUNDARIES}")
}

const BOUNDARIES: &str = r#"
[[boundary]]
name = "base"
side = "bottom"
fixed = "xy"
[[boundary]]
name = "top"
side = "top"
traction = [0, 1e6]
ramp = 3e-3
"#;

/// The time step, s, without mass scaling.
fn step() -> f64 {
    Preflight::of(&right(&sliver(""))).unwrap().step
}

#[test]
fn a_sliver_gets_mass_and_the_step_is_the_one_that_was_asked_for() {
    let asked = 2.0 * step();
    let prepared = right(&sliver(&format!("mass_scaling = {{ time_step = {asked:e} }}")));
    let scaled = prepared.mass_scaling.clone().unwrap();
    assert!(scaled.elements > 0 && scaled.elements < 20, "{scaled:?}");
    assert!(scaled.share() > 0.0 && scaled.share() < 0.05, "{scaled:?}");
    assert!((scaled.step_without / step() - 1.0).abs() < 1e-12, "{scaled:?}");
    assert!((scaled.true_mass / (2700.0 * 0.5) - 1.0).abs() < 1e-9, "{scaled:?}");
    let preflight = Preflight::of(&prepared).unwrap();
    assert_eq!(preflight.step, asked);
    assert!(preflight.critical.step >= asked / 0.8, "{preflight}");
    assert!(!preflight.warnings.iter().any(|warning| warning.contains("time step")), "{preflight}");
    assert!(preflight.to_string().contains("\nmass scaling     "), "{preflight}");
    // The hash is that of another model.
    assert_ne!(prepared.hash, right(&sliver("")).hash);
}

#[test]
fn mass_scaling_that_is_too_much_or_twice_is_refused() {
    let refused = |keys: &str| read(&sliver(keys)).unwrap_err().to_string();
    let told = refused("mass_scaling = { time_step = \"40 us\", added_mass = 0.05 }");
    for part in
        ["% more mass; \"added_mass\" allows 5 %", "s are possible within this bound", "of \"block\" at ["]
    {
        assert!(told.contains(part), "{part:?} is not in\n{told}");
    }
    let told = refused("time_step = 1e-7\nmass_scaling = { time_step = 1e-6 }");
    assert!(told.contains("\"mass_scaling\" has the time step of the run"), "{told}");
    assert!(refused("mass_scaling = { added_mass = 0.1 }").contains("time_step"));
    assert!(refused("mass_scaling = { time_step = 0 }").contains("above 0"));
    assert!(refused("mass_scaling = { time_step = 1e-6, added_mass = 0 }").contains("above 0"));
    assert!(refused("mass_scaling = { time_step = 1e-6, kinetic_energy = -1 }").contains("above 0"));
}

#[test]
fn the_longest_step_that_is_told_is_possible() {
    let told = read(&sliver("mass_scaling = { time_step = \"40 us\" }")).unwrap_err().to_string();
    let (start, _) = told.split_once(" s are possible").unwrap();
    let longest: f64 = start.rsplit(' ').next().unwrap().parse().unwrap();
    let scaled = right(&sliver(&format!("mass_scaling = {{ time_step = {longest} }}"))).mass_scaling.unwrap();
    assert!(scaled.share() < 0.1 && longest > 2.0 * step(), "{longest} {scaled:?}");
}

#[test]
fn mass_scaling_warns_where_it_does_nothing_and_where_waves_count() {
    let warnings = |text: &str| right(text).warnings.join("\n");
    let little = format!("mass_scaling = {{ time_step = {:e} }}", 0.5 * step());
    assert!(warnings(&sliver(&little)).contains("mass_scaling adds no mass: steps of "));
    let keys = format!("mass_scaling = {{ time_step = {:e} }}", 2.0 * step());
    let waves = sliver(&keys).replace("fixed = \"xy\"", "absorbing = true");
    assert!(warnings(&waves).contains("\"base\" absorbs waves, and mass scaling is for quasi-static runs"));
    let thrown = sliver(&keys).replace("material = \"rock\"\n", "material = \"rock\"\nvelocity = [0, -5]\n");
    assert!(warnings(&thrown).contains("begins with a velocity, and mass scaling is for quasi-static runs"));
}

/// A cut through the model leaves nodes with fewer elements, which need more mass than before.
#[test]
fn all_stages_bear_the_step() {
    let stages = "[[stage]]\nname = \"all\"\nduration = 1e-4\n[[stage]]\nname = \"cut\"\nexcavate_boxes = [[0.45, 0.4, 0.55, 0.48]]\n";
    let text = format!("{}{stages}", sliver(&format!("mass_scaling = {{ time_step = {:e} }}", 2.0 * step())));
    let prepared = right(&text);
    assert_eq!(Preflight::of(&prepared).unwrap().step, 2.0 * step());
    let whole = right(&sliver(&format!("mass_scaling = {{ time_step = {:e} }}", 2.0 * step())));
    let both = prepared.model.mass_factors.iter().zip(&whole.model.mass_factors);
    assert!(both.clone().all(|(staged, one)| staged >= one));
}

#[test]
fn advice_names_a_step_that_is_possible() {
    let advice = |text: &str| {
        let warnings = Preflight::of(&right(text)).unwrap().warnings;
        warnings.into_iter().find(|warning| warning.contains("few elements alone set the time step"))
    };
    let told = advice(&sliver("local_damping = 0.7")).unwrap();
    let (_, rest) = told.split_once("mass_scaling = { time_step = ").unwrap();
    let longer: f64 = rest.split(' ').next().unwrap().parse().unwrap();
    let scaled = right(&sliver(&format!("mass_scaling = {{ time_step = {longer} }}"))).mass_scaling.unwrap();
    assert!(scaled.share() <= 0.011 && longer >= 1.5 * step(), "{told} {scaled:?}");
    // Waves count, or there is nothing to gain.
    assert_eq!(advice(&sliver("").replace("fixed = \"xy\"", "absorbing = true")), None);
    assert_eq!(advice(&format!("{SMALL}{BOUNDARIES}")), None);
}

#[test]
fn loads_that_come_too_fast_are_told_with_a_ramp() {
    let warnings = |text: &str| right(text).warnings.join("\n");
    let model = format!("{SMALL}{BOUNDARIES}");
    assert_eq!(warnings(&model), "");
    // A wave goes through 1 m in 0.3 ms.
    let told = warnings(&model.replace("ramp = 3e-3\n", ""));
    for part in [
        "\"top\": its traction is there at once",
        "write ramp = 0.006, which is 20 passages",
        "local_damping = 0.7",
    ] {
        assert!(told.contains(part), "{part:?} is not in\n{told}");
    }
    let told = warnings(&model.replace("ramp = 3e-3", "ramp = 0.6e-3"));
    assert!(told.contains("its traction is there after 2 passages of a wave"), "{told}");
    // A pulse is deliberate, and damping brings an unbroken body to rest.
    assert_eq!(warnings(&model.replace("ramp = 3e-3", "table = [[0, 0], [1e-5, 1], [2e-5, 0]]")), "");
    let damped = model.replace("[model]", "[model]\nlocal_damping = 0.7");
    assert_eq!(warnings(&damped.replace("ramp = 3e-3\n", "")), "");
    // Without a support there is no state of rest.
    let free = model.replace("ramp = 3e-3\n", "").replace("fixed = \"xy\"", "traction = [0, -1e6]");
    assert_eq!(warnings(&free), "");
}

#[test]
fn boundaries_that_are_too_fast_for_a_slow_test_get_a_velocity() {
    let strong = "tensile_strength = 10e6\ncohesion = 30e6\nfriction_angle = 30\nfracture_energy_i = 1e5\nfracture_energy_ii = 1e5\n";
    let moved = |speed: f64| {
        let boundaries = BOUNDARIES.replace("traction = [0, 1e6]", &format!("velocity = [0, {speed}]"));
        right(&format!("{SMALL}{strong}{boundaries}")).warnings.join("\n")
    };
    // The stress of a wave is 9 MPa s/m times the velocity, and each side has half of it.
    let told = moved(5.0);
    assert!(
        told.contains("\"top\" moves at 5 m/s") && told.contains("is 2.25 of the tensile strength"),
        "{told}"
    );
    assert!(told.contains("about 12 % above") && told.contains("take at most 2.2 m/s"), "{told}");
    assert!(!moved(1.0).contains("the stress of its wave"));
}

#[test]
fn dynamic_relaxation_of_a_body_that_flies_is_warned_of() {
    let flies = SMALL.replace("[[body]]", "[[body]]\nvelocity = [3, 0]");
    let warned = "a body begins with a velocity, and dynamic relaxation";
    let told = |text: &str| right(text).warnings.join("\n");
    assert!(!told(&flies).contains(warned));
    let relaxed = flies.replacen("[model]", "[model]\ndynamic_relaxation = true", 1);
    assert!(relaxed != flies && told(&relaxed).contains(warned), "{}", told(&relaxed));
}

#[test]
fn stages_that_are_to_reach_an_equilibrium_are_told_to_be_damped() {
    let stage = "[[stage]]\nname = \"rest\"\nequilibrium = 1e-4\n";
    let model = format!("{SMALL}{BOUNDARIES}{stage}");
    let told = right(&model).warnings.join("\n");
    assert!(told.contains("[[stage]] \"rest\" ends at an equilibrium, and without damping"), "{told}");
    assert_eq!(right(&format!("{model}local_damping = 0.7\n")).warnings, Vec::<String>::new());
    assert_eq!(right(&format!("{model}dynamic_relaxation = true\n")).warnings, Vec::<String>::new());
    let viscous = model.replace("density = ", "damping = 0.3\ndensity = ");
    assert!(!right(&viscous).warnings.join("\n").contains("ends at an equilibrium"));
    // Ground at rest is in equilibrium from the beginning.
    let ground = format!("{SMALL}{BOUNDARIES}[initial]\nstress = [-1e3, 0, 0]\n{stage}");
    assert!(!right(&ground).warnings.join("\n").contains("ends at an equilibrium"));
}

/// A rigid block below one of a soft material that deforms.
const ON_RIGID: &str = r#"
[model]
end_time = 0.02
[[body]]
name = "a"
material = "rock"
rectangle = { min = [0, 0], max = [1, 1] }
mesh_size = 0.2
rigid = true
[[body]]
name = "b"
material = "soft"
rectangle = { min = [0, 1], max = [1, 2] }
mesh_size = 0.2
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.2
[[material]]
name = "soft"
density = 2700
youngs_modulus = 1e6
poissons_ratio = 0.2
"#;

/// Added mass makes no contact of a rigid body slower: such a step was called stable and not stable.
#[test]
fn a_step_that_is_too_long_for_rigid_bodies_is_refused() {
    let scaled = |step: &str| {
        let keys = format!("mass_scaling = {{ time_step = {step}, added_mass = 1000 }}\nend_time");
        ON_RIGID.replace("end_time", &keys)
    };
    let refused = read(&scaled("1e-4")).unwrap_err().to_string();
    for part in ["model.toml:3:", "too long for the contacts of rigid bodies", "take at most 9.4e-6 s"] {
        assert!(refused.contains(part), "{part} is not in\n{refused}");
    }
    let warnings = Preflight::of(&right(&scaled("9e-6"))).unwrap().warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("mass_scaling adds no mass"), "{warnings:?}");
}
