//! Parameters, arithmetic and units in model files.

use fdem_model::{AnyPrepared, prepare_any};

use crate::{read, right};

const PLAIN: &str = r#"
[model]
end_time = 0.001
plane = "strain"
thickness = 0.025
gravity = [0, -9.81]
time_step = "auto"

[[body]]
name = "disc"
material = "rock"
disc = { centre = [0, 0.05], radius = 0.05 }
mesh_size = 0.01
seed = 3
angle = 30

[[body]]
name = "floor"
material = "rock"
polygon = { points = [[-0.1, -0.02], [0.1, -0.02], [0.1, 0], [-0.1, 0]], holes = [{ centre = [0, -0.01], radius = 0.004 }] }
mesh_size = 0.005

[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
friction = 0.5
tensile_strength = 5e6
cohesion = 15e6
friction_angle = 35
fracture_energy_i = 60
fracture_energy_ii = 120

[[boundary]]
name = "push"
body = "disc"
velocity = ["free", -0.05]
table = [[0, 0], [0.0005, 1]]

[[boundary]]
name = "hold"
body = "floor"
side = "bottom"
fixed = "xy"
"#;

const WRITTEN: &str = r#"
[parameters]
height = "2*radius"
radius = "50 mm"
size = "radius/5"
E = "30 GPa"
ft = 5e6
half = "1/2"

[model]
end_time = "1 ms"
plane = "strain"
thickness = "2.5 cm"
gravity = [0, "-9.81 m/s^2"]
time_step = "auto"

[[body]]
name = "disc"
material = "rock"
disc = { centre = ["0", "height*half"], radius = "radius" }
mesh_size = "size"
seed = "1 + 2"
angle = "10 deg + 20"

[[body]]
name = "floor"
material = "rock"
polygon = { points = [["-height", "-20 mm"], ["height", "-20 mm"], ["height", 0], ["-height", "0 m"]], holes = [{ centre = [0, "-10 mm"], radius = "4 mm" }] }
mesh_size = "size/2"

[[material]]
name = "rock"
density = "2.7 g/cm^3"
youngs_modulus = "E"
poissons_ratio = "0.25"
friction = "half"
tensile_strength = "ft"
cohesion = "3*ft"
friction_angle = "35 deg"
fracture_energy_i = "60 J/m^2"
fracture_energy_ii = "120 N/m"

[[boundary]]
name = "push"
body = "disc"
velocity = ["free", "-5 cm/s"]
table = [[0, 0], ["0.5 ms", 1]]

[[boundary]]
name = "hold"
body = "floor"
side = "bottom"
fixed = "xy"
"#;

#[test]
fn a_model_with_parameters_and_units_is_the_plain_one() {
    let (plain, written) = (right(PLAIN), right(WRITTEN));
    assert_eq!(written.hash, plain.hash);
    assert_eq!(written.end_time, plain.end_time);
    assert_eq!(written.warnings, plain.warnings);
}

#[test]
fn a_model_in_space_takes_expressions_as_well() {
    let plain = r#"
        [model]
        end_time = 1e-3
        [initial]
        velocity = { block = [0, 0, -2] }
        stress = [0, 0, -1e6, 0, 0, 0]
        [[body]]
        name = "block"
        material = "rock"
        box = { min = [0, 0, 0], max = [0.1, 0.1, 0.2] }
        mesh_size = 0.05
        [[material]]
        name = "rock"
        density = 2700
        youngs_modulus = 50e9
        poissons_ratio = 0.25
    "#;
    let written = plain
        .replace("[model]", "[parameters]\nedge = \"100 mm\"\n[model]")
        .replace("[0, 0, -2]", "[0, 0, \"-2 m/s\"]")
        .replace("-1e6", "\"-1 MPa\"")
        .replace("[0.1, 0.1, 0.2]", "[\"edge\", \"edge\", \"2*edge\"]")
        .replace("mesh_size = 0.05", "mesh_size = \"edge/2\"");
    let hash = |text: &str| match prepare_any(text, "m.toml", &mut |_| Err(String::new()), None).unwrap() {
        AnyPrepared::Space(prepared) => prepared.hash,
        AnyPrepared::Plane(_) => panic!("it is in three dimensions"),
    };
    assert_eq!(hash(&written), hash(plain));
}

/// One fault, at these bytes of the text, which says all of these.
#[track_caller]
fn refused(from: &str, to: &str, at: &str, parts: &[&str]) {
    assert_eq!(WRITTEN.matches(from).count(), 1, "{from}");
    let text = WRITTEN.replace(from, to);
    let errors = read(&text).unwrap_err();
    assert_eq!(errors.faults.len(), 1, "{errors}");
    assert_eq!(&text[errors.faults[0].span.clone().unwrap()], at, "{errors}");
    for part in parts {
        assert!(errors.to_string().contains(part), "{part:?} is not in\n{errors}");
    }
}

#[test]
fn wrong_values_are_told_at_their_place() {
    for (from, to, at, parts) in [
        ("\"2.7 g/cm^3\"", "\"25 mm\"", "\"25 mm\"", ["\"25 mm\" is a length, but density is in kg/m³", ""]),
        (
            "\"2.7 g/cm^3\"",
            "\"radius\"",
            "\"radius\"",
            ["\"radius\" is a length, but density is in kg/m³", ""],
        ),
        ("friction = \"half\"", "friction = \"1 m\"", "\"1 m\"", ["friction is a number without a unit", ""]),
        (
            "[\"0.5 ms\", 1]",
            "[\"0.5 ms\", \"1 s\"]",
            "\"1 s\"",
            ["a time, but table is a number without", ""],
        ),
        ("[\"0.5 ms\", 1]", "[\"0.5 m\", 1]", "\"0.5 m\"", ["a length, but table is in s", ""]),
        ("\"35 deg\"", "\"35 mm\"", "\"35 mm\"", ["friction_angle is in deg", ""]),
        (
            "mesh_size = \"size\"",
            "mesh_size = \"2*raduis\"",
            "raduis",
            ["there is no parameter \"raduis\"", "did you mean \"radius\"?"],
        ),
        ("mesh_size = \"size\"", "mesh_size = \"2 Mm\"", "Mm", ["\"Mm\" is no unit", "did you mean \"mm\"?"]),
        (
            "mesh_size = \"size\"",
            "mesh_size = \"size*\"",
            "\"size*\"",
            ["it ends where a value is expected", ""],
        ),
        ("mesh_size = \"size\"", "mesh_size = \"-size\"", "\"-size\"", ["\"mesh_size\" is -0.01", "above 0"]),
        ("\"1 + 2\"", "\"1/2\"", "\"1/2\"", ["\"1/2\" is 0.5, but seed is a whole number", ""]),
        ("\"1 + 2\"", "\"3 m\"", "\"3 m\"", ["seed is a number without a unit", ""]),
        ("poissons_ratio = \"0.25\"", "poissons_ratio = \"0,25\"", ",", ["a decimal point, not a comma", ""]),
        (
            "radius = \"50 mm\"",
            "radius = \"height/2\"",
            "height",
            ["in a circle: ", "height -> radius -> height"],
        ),
        (
            "half = \"1/2\"",
            "half = \"1/0\"",
            "/",
            ["\"1/0\" has no value: the quotient is not a finite number", ""],
        ),
        ("half = \"1/2\"", "half = true", "true", ["\"half\" is true or false", ""]),
        (
            "half = \"1/2\"",
            "half = \"1/2\"\nmm = 3",
            "mm",
            ["\"mm\" is a unit and cannot be a parameter", "mm_1"],
        ),
        ("half = \"1/2\"", "half = \"1/2\"\na-b = 3", "a-b", ["\"a-b\" cannot be a parameter", ""]),
        ("time_step = \"auto\"", "time_step = \"autom\"", "\"autom\"", ["did you mean \"auto\"?", ""]),
        ("\"free\"", "\"fre\"", "\"fre\"", ["did you mean \"free\"?", ""]),
        ("time_step = \"auto\"", "time_step = \"2 mm\"", "\"2 mm\"", ["a length, but time_step is in s", ""]),
    ] {
        refused(from, to, at, &parts);
    }
}

#[test]
fn a_chain_of_parameters_has_an_end() {
    let chain = |count: usize| {
        let lines: Vec<String> = (0..count).map(|k| format!("p{k} = \"p{}\"\n", k + 1)).collect();
        let lines = lines.concat();
        PLAIN
            .replacen("[model]", &format!("[parameters]\n{lines}p{count} = 0.05\n[model]"), 1)
            .replace("radius = 0.05", "radius = \"p0\"")
    };
    assert_eq!(right(&chain(50)).hash, right(PLAIN).hash);
    let errors = read(&chain(10_000)).unwrap_err().to_string();
    assert!(errors.contains("more than 100 parameters need each other in a chain"), "{errors}");
}

#[test]
fn words_and_names_stay_text() {
    let text = PLAIN
        .replacen("[model]", "[parameters]\nauto = 1\nrock = 2\nside = \"auto + rock\"\n[model]", 1)
        .replacen("end_time = 0.001", "end_time = 0.001\ntitle = \"2*3\"", 1);
    let prepared = right(&text);
    assert_eq!(prepared.hash, right(PLAIN).hash);
    assert_eq!(prepared.title, "2*3");
    // `auto` and `rock` are used by `side`, which nothing uses.
    assert_eq!(prepared.warnings[0], "the parameter \"side\" is not used");
    assert_eq!(prepared.warnings[1..], right(PLAIN).warnings);
}

#[test]
fn texts_with_escapes_and_other_quotes_are_expressions_too() {
    for radius in ["'50 mm'", "\"\"\"50 mm\"\"\"", "\"\\u0035\\u0030 mm\"", "\"\t50\\tmm \""] {
        let text = PLAIN.replace("radius = 0.05 }", &format!("radius = {radius} }}"));
        assert_eq!(right(&text).hash, right(PLAIN).hash, "{radius}");
        let wrong = text.replace("mm", "mmm");
        let errors = read(&wrong).unwrap_err();
        assert_eq!(errors.faults.len(), 1, "{errors}");
        let at = &wrong[errors.faults[0].span.clone().unwrap()];
        assert!(at == radius.replace("mm", "mmm") || at == "mmm", "{at}");
    }
}

/// Arbitrary bytes in the places of values never make the reader panic.
#[test]
fn no_text_makes_the_reader_panic() {
    const PIECES: [&str; 24] = [
        "radius", "2", "*", "/", " mm", "(", ")", "^", "\\u0000", "é", "岩", "GPa", "-", ",", "sqrt(", "\\n",
        "%", "°", "auto", "=", "[", "'", "\\\"", "1e400",
    ];
    let mut state = 1_u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as usize) % below
    };
    for _ in 0..80 {
        let value: String = (0..next(8)).map(|_| PIECES[next(PIECES.len())]).collect();
        for key in ["density = \"2.7 g/cm^3\"", "seed = \"1 + 2\"", "half = \"1/2\"", "time_step = \"auto\""]
        {
            let name = key.split(' ').next().unwrap();
            let text = WRITTEN
                .replace(key, &format!("{name} = \"{value}\""))
                .replace("mesh_size = \"size\"", "mesh_size = \"0\"");
            if let Err(errors) = read(&text) {
                assert!(!errors.render(fdem_model::Drawing::Plain).is_empty());
            }
        }
    }
}

/// A pressure over time cannot be written as a value: `t` is the tonne there.
#[test]
fn a_value_that_depends_on_the_time_is_told_how_to_be_written() {
    let load =
        |value: &str| PLAIN.replace("velocity = [\"free\", -0.05]\n", &format!("pressure = {value}\n"));
    let told = |text: &str| read(text).map(|prepared| prepared.hash).unwrap_err().to_string();
    let help = "t is the tonne here";
    let wrong = told(&load("\"10*exp(-t/1ms) MPa\""));
    assert!(
        wrong.contains("has no value") && wrong.contains(help) && wrong.contains("expression = "),
        "{wrong}"
    );
    assert!(told(&load("\"exp(- t)\"")).contains(help));
    for other in ["\"exp(5 t)\"", "\"exp(2 ft)\"", "\"exp(1 s)\""] {
        let wrong = told(&load(other));
        assert!(wrong.contains("has no value") && !wrong.contains(help), "{wrong}");
    }
}

/// A file in place of a table is written under another key.
#[test]
fn a_file_of_a_table_is_told_its_key() {
    let table = "table = [[0, 0], [0.0005, 1]]";
    let text = PLAIN.replace(table, "table = \"p.csv\"");
    let told = read(&text).map(|prepared| prepared.hash).unwrap_err().to_string();
    assert!(told.contains("\"table\" is text") && told.contains("is table_file = \"p.csv\""), "{told}");
    let text = PLAIN.replace(table, "table_file = \"p.csv\"");
    let mut file = |name: &str| {
        assert_eq!(name, "p.csv");
        Ok(b"time,value\n0,0\n0.0005,1\n".to_vec())
    };
    let prepared =
        prepare_any(&text, "m.toml", &mut file, None).map_err(|errors| errors.to_string()).unwrap();
    let AnyPrepared::Plane(prepared) = prepared else { panic!("of triangles") };
    assert_eq!(prepared.model.boundaries[0].schedule, right(PLAIN).model.boundaries[0].schedule);
}

#[test]
fn revolutions_are_angles() {
    let spin = |speed: &str| {
        let boundary = format!(
            "[[boundary]]\nname = \"drum\"\nbody = \"floor\"\nside = \"top\"\nrotation = {{ through = [0, 0], speed = {speed} }}\n"
        );
        let fdem_simulation::Load::Rotation { spin, .. } =
            right(&format!("{PLAIN}{boundary}")).model.boundaries[2].load
        else {
            panic!("no rotation");
        };
        spin
    };
    for same in ["\"15 rpm\"", "\"0.25 rev/s\"", "\"(1/4) rev/s\"", "\"90 deg/s\""] {
        assert_eq!(spin(same), spin("90"), "{same}");
    }
    let wrong = read(&PLAIN.replace("angle = 30", "angle = \"30 rpm\"")).unwrap_err().to_string();
    assert!(wrong.contains("\"30 rpm\" is an angular velocity, but angle is in deg"), "{wrong}");
}
