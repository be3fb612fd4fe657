//! Models that would take more memory or time than there is: refused before anything is cut, in few words.

use std::time::{Duration, Instant};

use fdem_model::{Drawing, Preflight, prepare_within};

use crate::{SMALL, read, right};

/// The small model with another shape.
fn with_shape(shape: &str) -> String {
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let (_, end) = rest.split_once("mesh_size = 0.1\n").unwrap();
    format!("{start}{shape}\n{end}")
}

/// Refused with `part` in the message, and with no number of hundreds of digits.
#[track_caller]
fn refused(text: &str, part: &str) {
    let errors = read(text).map(|prepared| prepared.quality).unwrap_err();
    let told = errors.to_string();
    assert!(told.contains(part), "{part:?} is not in\n{told}");
    let mut digits = 0;
    for c in told.chars() {
        digits = if c.is_ascii_digit() { digits + 1 } else { 0 };
        assert!(digits <= 20, "{told}");
    }
    assert!(errors.render(Drawing::Plain).len() < 5000);
}

#[test]
fn sizes_that_have_no_room_are_refused_before_anything_is_cut() {
    refused(&SMALL.replace("mesh_size = 0.1", "mesh_size = 1e-308"), "more elements than can be counted");
    refused(&SMALL.replace("mesh_size = 0.1", "mesh_size = 1e-150"), "a mesh size of 1e-150 m gives about");
    for shape in [
        "rectangle = { min = [0, 0], max = [1, 1], holes = [{ centre = [0, 0], radius = 1e25 }] }\nmesh_size = 0.1",
        "disc = { radius = 1e29 }\nmesh_size = 0.1",
        "ring = { radius = 1e30, inner_radius = 1e29 }\nmesh_size = 1",
        "voronoi = { outline = { polygon = { points = [[0, 0], [1, 0], [1, 1e18], [0, 1e18]] } }, grains = 50 }\nfine = true\nmesh_size = 0.1",
        "packing = { count = 1000, radius = [1e28, 1e29], within = { min = [0, 0], max = [1, 1] } }\nmesh_size = 0.1",
        "packing = { count = 1000000, radius = [0.9, 1], within = { min = [0, 0], max = [1e4, 1e4] } }\nmesh_size = 0.1",
    ] {
        refused(&with_shape(shape), "a mesh size of ");
    }
}

#[test]
fn outlines_that_fill_little_of_their_box_take_no_memory_for_the_rest() {
    let thin = "ring = { radius = 50, inner_radius = 49.99 }\nfine = true\nmesh_size = 0.01";
    let elements = right(&with_shape(thin)).quality.elements;
    assert!((60_000..120_000).contains(&elements), "{elements}");
    let spire = "voronoi = { outline = { polygon = { points = [[0, 0], [1e-6, 0], [100, 100]] } }, grains = 50 }\nfine = true\nmesh_size = 0.1";
    refused(&with_shape(spire), "the outline is too thin for grains");
    let needle = spire.replace("[100, 100]", "[1e18, 1e18]").replace("mesh_size = 0.1", "mesh_size = 1e15");
    refused(&with_shape(&needle), "are nearer to each other than a billionth of the shape");
    // Edges that go from the bottom to the top are in all rows in which points are looked up.
    let comb: Vec<String> = (0..4000).map(|k| format!("[{}, {}]", k, k % 2)).collect();
    let comb = format!(
        "polygon = {{ points = [{}, [4000, 3], [-1, 3]] }}\nfine = true\nmesh_size = 1",
        comb.join(", ")
    );
    assert!(right(&with_shape(&comb)).quality.elements > 4000);
}

#[test]
fn packings_that_have_no_room_are_refused_at_once() {
    let discs = "packing = { count = 500000, radius = [0.1, 0.2], within = { min = [0, 0], max = [100, 100] } }\nmesh_size = 0.2";
    refused(&with_shape(discs), "500000 discs cover 3.66519 times the rectangle");
}

#[test]
fn many_bodies_in_one_place_are_refused() {
    let body = &SMALL[SMALL.find("[[body]]").unwrap()..SMALL.find("[[material]]").unwrap()];
    let copies: String = (1..1000).map(|k| body.replace("\"block\"", &format!("\"block {k}\""))).collect();
    refused(&format!("{SMALL}{copies}"), "bodies lie in each other: more than ");
    // Meshes from files are known once they are read.
    let triangle = |k: u32| {
        let [a, b, c] = [3 * k + 1, 3 * k + 2, 3 * k + 3];
        format!("v {k} 0 0\nv {} 0 0\nv {k} 30 0\nf {a} {b} {c}\n", k + 1)
    };
    let obj: String = (0..30).map(triangle).collect();
    let file =
        body.replace("rectangle = { min = [0, 0], max = [1.0, 0.5] }\nmesh_size = 0.1", "mesh = \"a.obj\"");
    let copies: String = (0..2000).map(|k| file.replace("\"block\"", &format!("\"file {k}\""))).collect();
    let text = format!("{SMALL}{copies}");
    let errors = fdem_model::prepare(&text, "m", &mut |_| Ok(obj.clone().into_bytes())).unwrap_err();
    assert!(errors.to_string().contains("bodies lie in each other"), "{errors}");
}

/// The cause of too many elements is the number of copies.
#[test]
fn too_many_copies_are_not_a_mesh_size() {
    let with = |repeat: &str| {
        let text = SMALL.replace("mesh_size = 0.1\n", &format!("mesh_size = 0.1\nrepeat = {repeat}\n"));
        read(&text).unwrap_err()
    };
    let errors = with("[1000000, 1000000]");
    assert_eq!(errors.faults.len(), 1, "{errors}");
    assert!(errors.to_string().contains("\"repeat\" asks for 1,000,000,000,000 bodies"), "{errors}");
    let errors = with("[1000, 1000]");
    assert_eq!(errors.faults.len(), 1, "{errors}");
    assert!(
        errors.to_string().contains("[[body]] \"block\", 1000000 times: a mesh size of 0.1 m gives"),
        "{errors}"
    );
    assert!(errors.to_string().contains("repeat it fewer times"), "{errors}");
}

#[test]
fn thousands_of_equal_names_are_one_short_error() {
    let body = &SMALL[SMALL.find("[[body]]").unwrap()..SMALL.find("[[material]]").unwrap()];
    let text = format!("{SMALL}{}", body.repeat(4000));
    let errors = read(&text).unwrap_err();
    let told = errors.to_string();
    assert!(told.contains("there is a [[body]] \"block\" already, and 3,999 times more"), "{told}");
    assert!(told.len() < 1000 && errors.render(Drawing::Plain).len() < 2000, "{told}");
}

#[test]
fn many_errors_are_counted_after_the_first_of_them() {
    let boundary = "\n[[boundary]]\nname = \"NAME\"\nbody = \"blok\"\nfixd = \"xy\"\n";
    let all: String = (0..500).map(|k| boundary.replace("NAME", &k.to_string())).collect();
    let errors = read(&format!("{SMALL}{all}")).unwrap_err();
    assert!(errors.faults.len() >= 500);
    let (list, drawn) = (errors.to_string(), errors.render(Drawing::Plain));
    assert!(list.lines().count() == 26 && list.contains(" more"), "{list}");
    assert!(drawn.len() < 20_000 && drawn.contains(" more"), "{drawn}");
}

#[test]
fn a_line_of_a_megabyte_is_not_drawn() {
    let points: Vec<String> = (0..50_000).map(|k| format!("[{k}, 0]")).collect();
    let shape = format!("polygon = {{ points = [{}] }}\nmesh_size = 0.1", points.join(", "));
    let errors = read(&with_shape(&shape)).unwrap_err();
    let drawn = errors.render(Drawing::Plain);
    assert!(drawn.len() < 3000 && drawn.contains("--> model.toml:7:22\n"), "{drawn}");
}

#[test]
fn meshes_that_need_more_memory_than_there_is_are_refused() {
    let text = SMALL.replace("mesh_size = 0.1", "mesh_size = 0.001");
    let mut load = |_: &str| Err("there are no files".to_owned());
    let errors = prepare_within(&text, "m", &mut load, Some(5e8)).unwrap_err();
    assert!(errors.to_string().contains("of memory, and 500 MB are free"), "{errors}");
    assert!(prepare_within(SMALL, "m", &mut load, Some(5e8)).is_ok());
}

/// A time step far above the critical one is refused before a step is taken: its first step would spread the
/// bodies, and the search for contacts, over the whole memory.
#[test]
fn a_time_step_without_sense_is_refused() {
    let of = |step: &str| {
        let text = SMALL.replacen("[model]\n", &format!("[model]\ntime_step = {step}\n"), 1);
        Preflight::of(&right(&text)).map(|preflight| preflight.warnings)
    };
    let refused = of("1e9").unwrap_err();
    assert!(refused.contains("its time step of 1e9 s") && refused.contains("the critical one"), "{refused}");
    // A run with one that is not stable stops, and says where.
    let warned = of("1e-4").unwrap();
    assert!(warned.iter().any(|warning| warning.contains("above the critical one")), "{warned:?}");
}

/// Values are refused before a body is meshed that takes long.
#[test]
fn wrong_values_are_told_before_large_bodies_are_meshed() {
    let corners = "[[0, 0, 0], [0.04, 0, 0], [0, 0.04, 0], [0, 0, 1]]";
    let shape = format!(
        "voronoi = {{ outline = {{ polyhedron = {{ points = {corners} }} }}, grains = 20, materials = [\"rock\"] }}\nmesh_size = 0.004"
    );
    let text = format!(
        "[model]\nend_time = 1e-4\n[[body]]\nname = \"ball\"\nmaterial = \"rock\"\n{shape}\n[[material]]\nname = \"rock\"\ndensity = 2600\nyoungs_modulus = 50e9\npoissons_ratio = 0.25\nfriction = -1\n"
    );
    let start = Instant::now();
    refused(&text, "\"friction\" is -1");
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    // The estimate of its elements is also that of a polyhedron that is too large.
    refused(&text.replace("mesh_size = 0.004", "mesh_size = 1e-5"), "a mesh size of 1e-5 m gives about");
}

/// A wrong unit gives a mesh size far below the width of the body.
#[test]
fn a_mesh_size_far_below_the_width_of_a_body_has_to_be_meant() {
    let with = |body: &str| {
        format!(
            "[model]\nend_time = 1e-6\n[[body]]\nname = \"bar\"\nmaterial = \"rock\"\n{body}\n[[material]]\nname = \"rock\"\n\
             density = 2500\nyoungs_modulus = 1e10\npoissons_ratio = 0.2\n"
        )
    };
    let cube = "v 0 0 0\nv 300 0 0\nv 300 300 0\nv 0 300 0\nv 0 0 300\nv 300 0 300\nv 300 300 300\nv 0 300 300\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let mut seen = Vec::new();
    let mut prepared = |text: &str| {
        seen.clear();
        let mut loads = 0;
        let mut load = |_: &str| {
            loads += 1;
            Ok(cube.as_bytes().to_vec())
        };
        let mut watch = |boxes: &[fdem_model::BodyBox]| seen.extend(boxes.iter().map(ToString::to_string));
        let prepared = fdem_model::prepare_any_with(text, "m.toml", &mut load, None, &mut watch);
        (prepared.map(|_| ()).map_err(|errors| errors.to_string()), seen.clone(), loads)
    };
    let bar = "rectangle = { min = [0, 0], max = [1, 0.002] }\nmesh_size = 0.001";
    let (refused, seen, _) = prepared(&with(bar));
    let message = refused.unwrap_err();
    for part in ["\"bar\" is 1 x 0.002 m wide, 1000 times its mesh_size of 0.001 m", "fine = true"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!message.contains("scale"), "{message}");
    assert_eq!(seen, ["bar: 1 x 0.002 m, from [0, 0], mesh_size 0.001 m"]);
    assert_eq!(prepared(&with(&format!("{bar}\nfine = true"))).0, Ok(()));
    let surface = "surface = \"cube.obj\"\nmesh_size = 0.1";
    let (refused, ..) = prepared(&with(surface));
    let message = refused.unwrap_err();
    assert!(
        message.contains("is 300 x 300 x 300 m wide, 3000 times") && message.contains("say scale"),
        "{message}"
    );
    let (right, seen, loads) = prepared(&with(&format!("{surface}\nscale = \"1 mm\"")));
    assert_eq!((right, loads), (Ok(()), 1), "the file is read once");
    assert_eq!(seen, ["bar: 0.3 x 0.3 x 0.3 m, from [0, 0, 0], mesh_size 0.1 m"]);
}

#[test]
fn numbers_with_which_no_run_ends_are_refused_at_their_line() {
    let refused = |text: &str, parts: &[&str]| {
        let told = read(text).unwrap_err().to_string();
        for part in parts {
            assert!(told.contains(part), "{part} is not in\n{told}");
        }
    };
    let breaks = SMALL.to_owned()
        + "tensile_strength = 10e6\ncohesion = 30e6\nfriction_angle = 30\nfracture_energy_i = 100\nfracture_energy_ii = 100\n";
    let endless = "the run would take ";
    for (text, place, title) in [
        (format!("{SMALL}[contact]\npenalty = 1e30\n"), "model.toml:16:", "[contact] penalty = 1e30: "),
        (
            format!("{breaks}[fracture]\njoint_penalty = 1e30\n"),
            "model.toml:21:",
            "[fracture] joint_penalty = 1e30: ",
        ),
        (SMALL.replace("2700", "1e-30"), "model.toml:12:", "[[material]] \"rock\": density = 1e-30: "),
        (SMALL.replace("end_time", "time_step = 1e-30\nend_time"), "model.toml:2:", "time_step = 1e-30 s: "),
    ] {
        refused(&text, &[place, title, endless]);
    }
    let short = SMALL.replace("end_time", "time_step = 1e-6\nend_time");
    let part = "[contact] penalty = 1e30: its time step of 1e-6 s is ";
    refused(
        &format!("{short}[contact]\npenalty = 1e30\n"),
        &["model.toml:17:", part, "times the critical one"],
    );
    // A penalty that is much, and with which a run ends.
    right(&format!("{SMALL}[contact]\npenalty = 1e9\n"));
}

#[test]
fn a_bound_of_the_energy_balance_below_rounding_is_refused() {
    let told = read(&SMALL.replace("end_time", "energy_bound = 1e-30\nend_time")).unwrap_err().to_string();
    for part in
        ["model.toml:2:", "energy_bound = 1e-30 is below the rounding of energies, 1e-12", "0.01 to 0.1"]
    {
        assert!(told.contains(part), "{part} is not in\n{told}");
    }
}
