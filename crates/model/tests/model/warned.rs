//! Settings that may not be meant: units, keys without effect, interfaces, slivers, meshes that fall apart,
//! members that bend.

use fdem_model::{Preflight, prepare};

use crate::{SMALL, right};

/// The small model with more tables.
fn with(more: &str) -> String {
    format!("{SMALL}\n{more}")
}

/// The small model with a mesh from a file.
fn from_file(file: &'static str) -> Vec<String> {
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let text = format!("{start}mesh = \"a.obj\"\n{}", rest.split_once("mesh_size = 0.1\n").unwrap().1);
    prepare(&text, "m", &mut |_| Ok(file.as_bytes().to_vec())).unwrap().warnings
}

#[track_caller]
fn warned(text: &str, part: &str) {
    let warnings = right(text).warnings;
    assert!(warnings.iter().any(|warning| warning.contains(part)), "{part:?} is not in {warnings:?}");
}

#[track_caller]
fn refused(text: &str, part: &str) {
    let errors = prepare(text, "m", &mut |_| Err("no files".into())).unwrap_err().to_string();
    assert!(errors.contains(part), "{part:?} is not in\n{errors}");
}

const STRENGTH: &str = "tensile_strength = 10e6\ncohesion = 30e6\nfriction_angle = 30\nfracture_energy_i = 100\nfracture_energy_ii = 100\n";

#[test]
fn numbers_in_other_units_are_asked_about() {
    warned(
        &SMALL.replace("30e9", "30"),
        "youngs_modulus = 30 Pa is little for a solid: if GPa are meant, write 3e10",
    );
    warned(&SMALL.replace("30e9", "210e3"), "if MPa are meant, write 2.1e11");
    warned(
        &SMALL.replace("2700", "2.7"),
        "density = 2.7 kg/m³ is little for a solid: if g/cm³ are meant, write 2.7e3",
    );
    let strength = STRENGTH.replace("10e6", "10");
    warned(
        &format!("{SMALL}{strength}"),
        "tensile_strength = 10 Pa is little for a solid: if MPa are meant, write 1e7",
    );
    warned(&SMALL.replace("end_time", "gravity = [0, -9810]\nend_time"), "1000 times that of the earth");
}

#[test]
fn a_mesh_size_above_the_width_of_a_body_is_told() {
    let with_size = |size: &str| SMALL.replace("mesh_size = 0.1", &format!("mesh_size = {size}"));
    for (size, times) in [("1.05", "2.1"), ("500", "1000")] {
        warned(
            &with_size(size),
            &format!("[[body]] \"block\": mesh_size = {size} m is {times} times its smallest width, 0.5 m"),
        );
    }
    let about_size = |text: &str| right(text).warnings.iter().any(|warning| warning.contains("mesh_size"));
    for text in [
        with_size("0.9"),
        with_size("5\nrefine = [{ point = [0, 0], size = 0.1, reach = 1 }]"),
        with(
            "[[body]]\nname = \"p\"\nmaterial = \"rock\"\nmesh_size = 0.3\npacking = { count = 5, radius = [0.1, 0.2], within = { min = [2, 0], max = [4, 2] } }",
        ),
    ] {
        assert!(!about_size(&text), "{text}");
    }
}

#[test]
fn keys_without_effect_are_told() {
    let boundary = |keys: &str| with(&format!("[[boundary]]\nname = \"b\"\nside = \"left\"\n{keys}\n"));
    for (text, part) in [
        (
            boundary("fixed = \"x\"\nramp = 1"),
            "[[boundary]] \"b\": ramp changes nothing where the body is fixed",
        ),
        (boundary("fixed = \"x\"\ntable = [[0, 1]]"), "\"b\": table changes nothing where the body is fixed"),
        (boundary("absorbing = true\nramp = 1"), "\"b\": ramp changes nothing where waves are absorbed"),
        (
            with(
                "[[body]]\nname = \"p\"\nmaterial = \"rock\"\nmesh_size = 0.1\npacking = { count = 2, radius = [0.1, 0.2], corners = [3, 4], within = { min = [2, 0], max = [4, 2] } }",
            ),
            "[[body]] \"p\": packing.corners changes nothing here",
        ),
    ] {
        warned(&text, part);
    }
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let text =
        format!("{start}mesh = \"a.obj\"\nseed = 3\n{}", rest.split_once("mesh_size = 0.1\n").unwrap().1);
    let prepared =
        prepare(&text, "m", &mut |_| Ok(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec())).unwrap();
    assert_eq!(prepared.warnings, ["[[body]] \"block\": seed changes nothing here"]);
}

#[test]
fn parts_without_effect_are_refused_unless_they_are_optional() {
    let boundary = |keys: &str| with(&format!("[[boundary]]\nname = \"b\"\nside = \"left\"\n{keys}\n"));
    for key in ["velocity", "displacement"] {
        refused(
            &boundary(&format!("{key} = [\"free\", \"free\"]")),
            "[[boundary]] \"b\" does nothing: all components are free",
        );
    }
    let spare = "[[material]]\nname = \"spare\"\ndensity = 1000\nyoungs_modulus = 1e9\npoissons_ratio = 0\n";
    refused(&with(spare), "[[material]] \"spare\" is that of no element");
    right(&with(&format!("{spare}optional = true\n")));
    let far = "[[joint_set]]\nname = \"far\"\nlines = [[9, 9, 10, 10]]\nfriction_angle = 30\n";
    refused(&with(far), "[[joint_set]] \"far\" has no joint in any body");
    right(&with(&format!("{far}optional = true\n")));
    // A file of materials is included by several models.
    let including = format!("include = [\"rocks.toml\"]\n{SMALL}");
    prepare(&including, "m", &mut |_| Ok(spare.as_bytes().to_vec())).unwrap();
}

#[test]
fn a_strength_between_materials_that_no_edge_separates_is_refused() {
    let mortar = "[[body]]\nname = \"other\"\nmaterial = \"mortar\"\nrectangle = { min = [1, 0], max = [2, 0.5] }\nmesh_size = 0.1\n\
        [[material]]\nname = \"mortar\"\ndensity = 2000\nyoungs_modulus = 5e9\npoissons_ratio = 0.2\n";
    let between = |a: &str, b: &str| format!("[[interface]]\nmaterials = [\"{a}\", \"{b}\"]\n{STRENGTH}");
    let apart = with(&format!("{mortar}{}", between("rock", "mortar")));
    refused(
        &apart,
        "[[interface]] of \"rock\" and \"mortar\" has a strength, but no edge of the mesh lies between the two",
    );
    right(&format!("{apart}\noptional = true"));
    warned(
        &with(&between("rock", "rock")),
        "[[interface]] of \"rock\" with itself: its strength is that of all ",
    );
    let grains = "voronoi = { outline = { rectangle = { min = [0, 0], max = [1, 0.5] } }, grains = 10, materials = [\"rock\", \"mortar\"] }";
    let text =
        with(&format!("{}{}", &mortar[mortar.find("[[material]]").unwrap()..], between("rock", "mortar")))
            .replace("rectangle = { min = [0, 0], max = [1.0, 0.5] }", grains);
    assert_eq!(right(&text).warnings, Vec::<String>::new());
}

#[test]
fn joints_without_strength_need_no_fracture_energy() {
    let other = "[[material]]\nname = \"b\"\noptional = true\ndensity = 2000\nyoungs_modulus = 5e9\npoissons_ratio = 0.2\n";
    let with_keys = |keys: &str| {
        with(&format!("{other}[[interface]]\nmaterials = [\"rock\", \"b\"]\noptional = true\n{keys}\n"))
    };
    let open = right(&with_keys("tensile_strength = 0\ncohesion = 0\nfriction_angle = 45"));
    let strength = open.model.interfaces[0].strength.unwrap();
    assert_eq!(
        (strength.tensile, strength.cohesion, strength.energy_i, strength.energy_ii),
        (0.0, 0.0, 0.0, 0.0)
    );
    let told = |keys: &str| crate::read(&with_keys(keys)).unwrap_err().to_string();
    let lacks = told("tensile_strength = 0\ncohesion = 1e6\nfriction_angle = 45");
    assert!(lacks.contains("add fracture_energy_ii, or"), "{lacks}");
    let none = told(
        "tensile_strength = 1\ncohesion = 1\nfriction_angle = 45\nfracture_energy_i = 0\nfracture_energy_ii = 1",
    );
    assert!(
        none.contains("\"fracture_energy_i\" is 0: it has to be above 0 where the strength is"),
        "{none}"
    );
    let text = format!("{SMALL}{}", STRENGTH.replace("tensile_strength = 10e6", "tensile_strength = 0"));
    let material = crate::read(&text).unwrap_err().to_string();
    assert!(
        material.contains("\"tensile_strength\" is 0: it has to be above 0"),
        "materials have a strength or none: {material}"
    );
}

#[test]
fn a_sliver_is_named_with_its_place_and_what_the_run_takes_without_it() {
    assert_eq!(Preflight::of(&right(SMALL)).unwrap().warnings, Vec::<String>::new());
    // A corner of a polygon that is a millimetre from its neighbour.
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let polygon = "polygon = { points = [[0, 0], [1, 0], [1, 0.5], [0.501, 0.5], [0.5, 0.5], [0, 0.5]] }\nmesh_size = 0.05\n";
    let text = format!("{start}{polygon}{}", rest.split_once("mesh_size = 0.1\n").unwrap().1);
    let preflight = Preflight::of(&right(&text)).unwrap();
    let warning = preflight.warnings.iter().find(|warning| warning.contains("is a sliver")).unwrap();
    for part in ["at [0.", "the time step", "without, the run would take about "] {
        assert!(warning.contains(part), "{warning}");
    }
}

#[test]
fn meshes_that_fall_apart_are_told_with_the_number_of_pieces() {
    let whole = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
    assert_eq!(from_file(whole), Vec::<String>::new());
    let unmerged = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0\nv 1 1 0\nf 1 2 3\nf 5 6 4\n";
    let told = from_file(unmerged).join("\n");
    assert!(
        told.contains(
            "[[body]] \"block\": its mesh falls into 2 pieces; nodes in the place of another: 2, as at ["
        ),
        "{told}"
    );
    let hanging = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0\nf 1 2 3\nf 1 5 4\nf 5 3 4\n";
    let told = from_file(hanging).join("\n");
    assert!(
        told.contains("its mesh is open inside; nodes on edges of other elements: 1, as at [0.5, 0.5]"),
        "{told}"
    );
    let apart = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\nf 4 5 6\n";
    let told = from_file(apart).join("\n");
    assert!(told.contains("its mesh falls into 2 pieces that have no node in common"), "{told}");
}

#[test]
fn loads_and_speeds_beyond_what_materials_carry_are_warned_of() {
    let boundary = |load: &str| with(&format!("[[boundary]]\nname = \"b\"\nside = \"left\"\n{load}\n"));
    for (text, part) in [
        (
            boundary("pressure = 1e20"),
            "\"b\": its pressure is 1e20 Pa, above the largest Young's modulus, 3e10 Pa",
        ),
        (boundary("traction = [1e20, 0]"), "\"b\": its traction is 1e20 Pa"),
        (
            boundary("force = [1e20, 0]"),
            "\"b\": its force over the width of the model times its thickness is 1e20 Pa",
        ),
        (
            boundary("velocity = [1e6, 0]\nramp = 1"),
            "\"b\" moves at 1e6 m/s: a run stops where a node is faster",
        ),
        (with("[initial]\nstress = [1e20, 0, 0]"), "[initial] stress is up to 1e20 Pa"),
        (SMALL.replace("0.25", "0.25\nfriction = 1e20"), "friction = 1e20 is much"),
        (
            with("[[interface]]\nmaterials = [\"rock\", \"rock\"]\nfriction = 1e20"),
            "[[interface]] of \"rock\" and \"rock\": friction = 1e20 is much",
        ),
        (format!("{SMALL}{}", STRENGTH.replace("30e6", "1e20")), "cohesion = 1e20 Pa is much for a solid"),
        (
            format!("{SMALL}{}", STRENGTH.replace("energy_ii = 100", "energy_ii = 1e20")),
            "fracture_energy_ii = 1e20 J/m² is much for a solid",
        ),
    ] {
        warned(&text, part);
    }
}

#[test]
fn times_that_are_shorter_than_a_step_are_warned_of() {
    let warnings = |text: &str| Preflight::of(&right(text)).unwrap().warnings;
    for (tables, part) in [
        ("[output]\ninterval = 1e-12", "[output] interval gives one result every 1e-12 s, but a step takes"),
        ("[output]\nframes = 1000000", "[output] frames gives one result every 1e-9 s"),
        ("[output]\nhistory_interval = 1e-12", "[output] history_interval gives"),
        (
            "[[history]]\nname = \"h\"\nenergy = true\ninterval = 1e-12",
            "[[history]] \"h\": interval gives one result",
        ),
    ] {
        let found = warnings(&with(tables));
        assert!(found.len() == 1 && found[0].starts_with(part), "{found:?}");
    }
    let found = warnings(&SMALL.replace("end_time = 1e-3", "end_time = 1e-6\ntime_step = 2e-6"));
    assert!(found.iter().any(|told| told.contains("2e-6 s is longer than end_time = 1e-6 s")), "{found:?}");
    let found = warnings(&SMALL.replace("end_time = 1e-3", "end_time = 1e-3\ntime_step = 1e-18"));
    assert!(found.iter().any(|told| told.contains("the run would take")), "{found:?}");
    // The defaults give many results for few steps, without a warning.
    assert_eq!(warnings(&SMALL.replace("end_time = 1e-3", "end_time = 1e-5")), Vec::<String>::new());
}

#[test]
fn gravity_upwards_is_asked_about() {
    let with_gravity = |y: &str| SMALL.replace("end_time", &format!("gravity = [0, {y}]\nend_time"));
    warned(
        &with_gravity("9.81"),
        "gravity = [0, 9.81] m/s² acts upwards, along +y: write a negative number for down",
    );
    let warnings = right(&with_gravity("-9.81")).warnings;
    assert!(!warnings.iter().any(|warning| warning.contains("upwards")), "{warnings:?}");
}

#[test]
fn a_servo_that_moves_away_from_its_target_is_a_warning() {
    let servo = |velocity: &str, column: &str| {
        with(&format!(
            "[[boundary]]\nname = \"top\"\nside = \"top\"\nvelocity = [\"free\", {velocity}]\nservo = {{ column = \"{column}\", target = -2e5 }}\n\
             [[history]]\nname = \"top\"\nforce = \"top\"\n"
        ))
    };
    warned(
        &servo("1e-9", "top fy"),
        "[[boundary]] \"top\": its servo moves away from its target: the velocity along y is 1e-9 m/s, and -200000 of top fy [N] needs the other sign",
    );
    for text in [servo("-1e-9", "top fy"), servo("1e-9", "top fx")] {
        let warnings = right(&text).warnings;
        assert!(!warnings.iter().any(|warning| warning.contains("moves away")), "{warnings:?}");
    }
}

/// A model of a rigid block with everything that is a warning where a body deforms.
const RIGID: &str = r#"[model]
end_time = 1e-3
plane = "strain"
gravity = [0, -9.81]

[[body]]
name = "jaw"
material = "rock"
polygon = { points = [[0, 0], [3, 0], [3, 0.05], [0.01, 0.05], [0, 0.1]] }
mesh_size = 0.25

[[body]]
name = "floor"
material = "rock"
rectangle = { min = [-1, -1], max = [4, -0.5] }
mesh_size = 0.3

[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.49
tensile_strength = 30e6
cohesion = 10e6
friction_angle = 30
fracture_energy_i = 1
fracture_energy_ii = 1

[[boundary]]
name = "push"
body = "jaw"
side = "top"
velocity = [0, -50]

[[boundary]]
name = "load"
body = "jaw"
side = "right"
traction = [1e12, 0]

[[boundary]]
name = "hold"
body = "floor"
side = "bottom"
fixed = "xy"

[contact]
penalty = 0.1

[fracture]
joint_penalty = 0.5
"#;

#[test]
fn warnings_of_stress_are_not_about_rigid_bodies() {
    let told = right(RIGID).warnings.join("\n");
    for part in [
        "fracture process zone",
        "is there at once",
        "one node alone",
        "its traction is",
        "elements lock",
        "elements through its thickness",
        "cannot carry its tensile strength",
        "softer where they touch",
        "joints are softer",
        "the two sides are not loaded alike",
        "by inertia",
        "times its smallest width",
    ] {
        assert!(told.contains(part), "{part} is not in\n{told}");
    }
    // A rigid body is moved as a whole: one node would be a hinge.
    let rigid = RIGID.replace("\nmaterial = ", "\nrigid = true\nmaterial = ").replace("side = \"top\"\n", "");
    assert_eq!(right(&rigid).warnings, Vec::<String>::new());
    assert_eq!(Preflight::of(&right(&rigid)).unwrap().warnings, Vec::<String>::new());
}

#[test]
fn the_worst_angle_is_that_of_a_body_that_deforms() {
    // A tip of a few degrees.
    let tip = "[[body]]\nname = \"tip\"\nmaterial = \"rock\"\npolygon = { points = [[2, 0], [3, 0], [3, 0.05]] }\nmesh_size = 0.1\n";
    warned(&with(tip), "degrees: its stress is poor");
    assert_eq!(right(&with(&format!("{tip}rigid = true\n"))).warnings, Vec::<String>::new());
}

#[test]
fn a_seed_of_a_strength_that_does_not_scatter_is_a_warning() {
    let text = format!("{SMALL}{STRENGTH}weibull_seed = 3\n");
    warned(&text, "[[material]] \"rock\": weibull_seed changes nothing without weibull_modulus");
    let scatters = right(&format!("{text}weibull_modulus = 10\n")).warnings;
    assert!(!scatters.iter().any(|told| told.contains("weibull")), "{scatters:?}");
    let text = format!(
        "{SMALL}{STRENGTH}[[interface]]\nmaterials = [\"rock\", \"rock\"]\n{STRENGTH}weibull_seed = 3\n"
    );
    warned(&text, "[[interface]] of \"rock\" and \"rock\": weibull_seed changes nothing");
}

#[test]
fn speeds_at_which_a_run_stops_are_refused_at_their_line() {
    let boundary = |keys: &str| with(&format!("[[boundary]]\nname = \"b\"\nside = \"left\"\n{keys}\n"));
    let turns = |speed: &str| boundary(&format!("rotation = {{ through = [0, 0], speed = {speed} }}"));
    let limit =
        "a run stops where a node is faster than 10 times the speed of waves in the bodies, 33333.3 m/s";
    for (text, parts) in [
        (turns("1e9"), ["m:19:", "[[boundary]] \"b\" moves at 8.72665e6 m/s"]),
        (boundary("velocity = [0, 4e4]"), ["m:19:", "[[boundary]] \"b\" moves at 40000 m/s"]),
        (
            boundary("velocity = [1, 0]\ntable = [[0, 0], [5e-4, 4e4], [1e-3, 0]]"),
            ["m:19:", "moves at 40000 m/s"],
        ),
        (
            boundary("displacement = [100, 0]\nramp = 1e-6"),
            ["m:19:", "[[boundary]] \"b\" moves at 1.5708e8 m/s"],
        ),
        (boundary("displacement = [100, 0]\ntable = [[0, 0], [1e-3, 1]]"), ["m:19:", "moves at 100000 m/s"]),
        (
            with("[initial]\nvelocity = { block = [1e6, 0] }"),
            ["m:17:", "[[body]] \"block\" moves at 1e6 m/s"],
        ),
        (SMALL.replace("mesh_size", "velocity = [1e6, 0]\nmesh_size"), ["m:8:", "moves at 1e6 m/s"]),
        (SMALL.replace("mesh_size", "velocity = [1, 0]\nspin = 1e9\nmesh_size"), ["m:9:", "moves at 9.7"]),
    ] {
        for part in parts.into_iter().chain([limit]) {
            refused(&text, part);
        }
    }
    // It comes to this speed after the end of the run.
    warned(&boundary("rotation = { through = [0, 0], speed = 1e9 }\nramp = 10"), "moves at 8.72665e6 m/s");
    right(&turns("1e6"));
}

#[test]
fn extreme_numbers_give_short_warnings() {
    let push = "[[boundary]]\nname = \"push\"\nside = \"top\"\nvelocity = [0, -0.5]\nramp = 1e-4\n\
        [[boundary]]\nname = \"load\"\nside = \"right\"\ntraction = [1e5, 0]\n\
        [[boundary]]\nname = \"hold\"\nside = \"bottom\"\nfixed = \"xy\"\n";
    let text = format!("{SMALL}{STRENGTH}{push}").replace("end_time", "gravity = [0, -9.81]\nend_time");
    for (key, value) in [
        ("fracture_energy_i = 100", "1e-300"),
        ("fracture_energy_ii = 100", "1e-300"),
        ("cohesion = 30e6", "1e-300"),
        ("tensile_strength = 10e6", "1e-300"),
        ("youngs_modulus = 30e9", "1e-300"),
        ("density = 2700", "1e12"),
    ] {
        let (name, _) = key.split_once(" = ").unwrap();
        let mut text = text.replace(key, &format!("{name} = {value}"));
        if name == "youngs_modulus" {
            // Any speed would be too high.
            text = text.replace("velocity = [0, -0.5]", "traction = [0, -1e5]");
        }
        let warnings = right(&text).warnings;
        assert!(!warnings.is_empty());
        for warning in warnings {
            let is_long = warning.split(|c: char| !c.is_ascii_digit()).any(|digits| digits.len() > 9);
            let is_odd = ["inf ", "NaN", "e153"].iter().any(|part| warning.contains(part));
            assert!(!is_long && !is_odd, "{key}, {value}: {warning}");
        }
    }
    refused(&text.replace("density = 2700", "density = 1e-300"), "density = 1e-300: the run would take");
}
