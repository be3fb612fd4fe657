//! Every kind of error: the line, the key or value in question, and the suggestion.

use fdem_model::{Drawing, ModelErrors, prepare};

use crate::{SMALL, read, right};

/// The model with one piece of text replaced.
#[track_caller]
fn changed(from: &str, to: &str) -> String {
    assert_eq!(SMALL.matches(from).count(), 1, "{from}");
    SMALL.replace(from, to)
}

/// Refused with one error, which points at `at` in the line that has it and says all of `parts`, in the list
/// and in the drawing.
#[track_caller]
fn refused(text: &str, at: &str, parts: &[&str]) {
    let errors = read(text).unwrap_err();
    assert_eq!(errors.faults.len(), 1, "{errors}");
    told(text, &errors, at, parts);
}

#[track_caller]
fn told(text: &str, errors: &ModelErrors, at: &str, parts: &[&str]) {
    let spot =
        errors.faults.iter().find(|fault| fault.span.as_ref().is_some_and(|span| text[span.clone()] == *at));
    let spots: Vec<_> =
        errors.faults.iter().map(|fault| fault.span.clone().map(|span| &text[span])).collect();
    let Some(fault) = spot else { panic!("nothing points at {at:?}, but {spots:?}:\n{errors}") };
    let start = fault.span.as_ref().unwrap().start;
    let line = text[..start].lines().count().max(1) + usize::from(text[..start].ends_with('\n'));
    assert_eq!(errors.line(fault), Some(line));
    let drawn = errors.render(Drawing::Plain);
    let list = errors.to_string();
    assert!(list.contains(&format!("model.toml:{line}: ")), "{list}");
    assert!(drawn.contains(&format!("--> model.toml:{line}:")), "the drawing has file and line:\n{drawn}");
    assert!(
        drawn.contains('^') && !drawn.contains(['━', '│', '╭', '\u{1b}']),
        "a pointer, in ASCII:\n{drawn}"
    );
    let source = text.lines().nth(line - 1).unwrap();
    // Long lines are cut around the place.
    let shown = if source.len() < 100 { source.trim() } else { at };
    assert!(drawn.contains(shown), "the drawing has the line:\n{drawn}");
    for part in parts {
        assert!(list.contains(part), "{part:?} is not in\n{list}");
        // Long messages are broken into lines.
        let unbroken: String = drawn.replace('\n', " ").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(unbroken.contains(part), "{part:?} is not in\n{drawn}");
    }
}

#[test]
fn the_small_model_is_right() {
    let prepared = right(SMALL);
    assert_eq!(prepared.warnings, Vec::<String>::new());
}

#[test]
fn an_unknown_key_is_pointed_at_with_the_nearest_one() {
    for (from, to, key, meant) in [
        ("density", "densty", "densty", "did you mean \"density\"?"),
        ("youngs_modulus", "E", "E", "did you mean \"youngs_modulus\"?"),
        ("mesh_size", "mesh_sise", "mesh_sise", "did you mean \"mesh_size\"?"),
        ("end_time", "endtime", "endtime", "did you mean \"end_time\"?"),
        ("max =", "maxx =", "maxx", "did you mean \"max\"?"),
    ] {
        let text = changed(from, to);
        refused(&text, key, &[&format!("has no key \"{key}\""), meant]);
    }
}

#[test]
fn a_key_of_another_table_is_said_to_be_one() {
    let text = changed("end_time = 1e-3", "end_time = 1e-3\njoint_penalty = 5");
    refused(&text, "joint_penalty", &["[model] has no key \"joint_penalty\"", "it is a key of [fracture]"]);
}

#[test]
fn an_unknown_table_is_pointed_at_with_the_nearest_one() {
    let text = format!("{SMALL}\n[[bondary]]\nname = \"a\"\n");
    refused(&text, "bondary", &["the file has no key \"bondary\"", "did you mean \"boundary\"?"]);
}

#[test]
fn a_missing_key_is_named_at_its_table() {
    let text = changed("density = 2700\n", "");
    refused(&text, "[[material]]", &["[[material]] \"rock\" lacks the key \"density\" (Density, kg/m³)"]);
    let text = changed("[model]\nend_time = 1e-3\n", "");
    let errors = read(&text).unwrap_err();
    assert!(errors.to_string().contains("the file lacks the key \"model\""), "{errors}");
}

#[test]
fn a_wrong_type_is_told_with_what_is_expected() {
    for (from, to, at, parts) in [
        ("density = 2700", "density = true", "true", ["\"density\" is true or false, not a number", ""]),
        ("name = \"block\"", "name = 3", "3", ["\"name\" is a number, not text in quotes", ""]),
        ("min = [0, 0]", "min = [0, 0, 0]", "[0, 0, 0]", ["\"min\" is a list of 3, not a list of 2", ""]),
        ("min = [0, 0]", "min = 0", "0", ["\"min\" is a number, not a list of 2", ""]),
    ] {
        refused(&changed(from, to), at, &parts);
    }
}

#[test]
fn a_decimal_comma_is_seen_in_all_its_forms() {
    refused(&changed("0.25", "0,25"), "0,25", &["a decimal comma: 0,25", "write 0.25"]);
    refused(&changed("0.25", "\"0,25\""), ",", &["\"0,25\" has no value", "a decimal point, not a comma"]);
    let text = changed("max = [1.0, 0.5]", "max = [1,0, 0,5]");
    refused(&text, "[1,0, 0,5]", &["a list of 4, not a list of 2", "decimal point"]);
}

#[test]
fn a_ramp_of_gravity_without_gravity_is_refused() {
    let text = changed("end_time", "gravity_ramp = 0.1\nend_time");
    refused(&text, "gravity_ramp", &["\"gravity_ramp\" goes with gravity", "write gravity = [0, -9.81]"]);
    let text = changed("end_time", "gravity = [0, -9.81]\ngravity_ramp = 0\nend_time");
    refused(&text, "0", &["\"gravity_ramp\""]);
}

#[test]
fn words_that_do_not_exist_are_told_with_those_that_do() {
    let text = changed("end_time", "plane = \"stres\"\nend_time");
    refused(&text, "\"stres\"", &["it is \"stress\" or \"strain\"", "did you mean \"stress\"?"]);
    let text = changed("end_time", "time_step = \"automatic\"\nend_time");
    refused(&text, "\"automatic\"", &["\"time_step\" cannot be \"automatic\"", "did you mean \"auto\"?"]);
    let text = changed("end_time", "gravity = 9.81\nend_time");
    refused(&text, "9.81", &["\"gravity\" is a number, not a list of 2 or 3, each a number, or \"none\""]);
}

#[test]
fn numbers_out_of_range_are_told_with_the_range() {
    for (from, to, at, part) in [
        ("density = 2700", "density = -2700", "-2700", "\"density\" is -2700: it has to be above 0"),
        ("poissons_ratio = 0.25", "poissons_ratio = 0.6", "0.6", "it has to be at most 0.5"),
        ("mesh_size = 0.1", "mesh_size = 0", "0", "\"mesh_size\" is 0: it has to be above 0"),
        ("end_time = 1e-3", "end_time = inf", "inf", "\"end_time\" is not a finite number"),
        ("end_time = 1e-3", "end_time = nan", "nan", "\"end_time\" is not a finite number"),
        ("end_time = 1e-3", "end_time = 1\nsafety = 1.5", "1.5", "\"safety\" is 1.5: it has to be at most 1"),
    ] {
        refused(&changed(from, to), at, &[part]);
    }
    let text = changed("end_time", "plane = \"strain\"\nend_time").replace("= 0.25", "= 0.5");
    refused(&text, "0.5", &["in plane strain and in three dimensions Poisson's ratio is below 0.5"]);
}

#[test]
fn what_is_no_toml_is_pointed_at() {
    refused(&changed("\"block\"", "block"), "block", &["text goes in quotes: name = \"block\""]);
    let errors = read(&changed("[model]", "[model")).unwrap_err();
    assert!(errors.to_string().starts_with("model.toml:1: this is not TOML"), "{errors}");
    let errors = read(&changed("density = 2700", "density: 2700")).unwrap_err();
    assert!(errors.to_string().contains("an equals sign"), "{errors}");
    let errors = read(&changed("density = 2700", "density = 2700\ndensity = 2800")).unwrap_err();
    assert!(errors.to_string().contains("model.toml:13: "), "{errors}");
    assert!(read("").unwrap_err().to_string().contains("lacks the key \"model\""));
    // The parser replaces a value that it cannot read by 0; that is not a second error.
    let errors = read(&changed("density = 2700", "density = = 2700")).unwrap_err();
    assert_eq!(errors.to_string().matches("model.toml:").count(), 1, "{errors}");
}

#[test]
fn several_errors_are_told_at_once_in_the_order_of_the_file() {
    let text = changed("density", "densty").replace("mesh_size = 0.1", "mesh_size = -1");
    let errors = read(&text).unwrap_err();
    let lines: Vec<_> = errors.faults.iter().map(|fault| errors.line(fault).unwrap()).collect();
    assert_eq!(lines, [8, 12], "{errors}");
    assert_eq!(errors.render(Drawing::Plain).matches("--> model.toml:").count(), 2);
}

/// Unknown keys, unknown names, shapes, files and places of boundaries: all in one round, and nothing that
/// only follows from another fault.
#[test]
fn faults_of_every_kind_are_told_in_one_round() {
    let text = r#"
[model]
end_time = 1
tittle = "many faults"

[[body]]
name = "good"
material = "rock"
disc = { radius = 1 }
mesh_size = 0.3

[[body]]
name = "bow"
material = "rock"
polygon = { points = [[0, 0], [1, 1], [1, 0], [0, 1]] }
mesh_size = 0.1

[[body]]
name = "odd"
material = "soil"
disc = { radus = 1 }
mesh_size = 0.1

[[body]]
name = "from file"
material = "rock"
mesh = "gone.msh"

[[material]]
name = "rock"
densty = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25

[[boundary]]
name = "a"
body = "good"
group = "holes"
pressure = 1

[[boundary]]
name = "b"
body = "bow"
side = "left"
fixed = "x"

[[boundary]]
name = "c"
body = "bad"
fixed = "x"
"#;
    let errors = read(text).unwrap_err();
    for (at, part) in [
        ("tittle", "[model] has no key \"tittle\""),
        ("[[0, 0], [1, 1], [1, 0], [0, 1]]", "the outline crosses itself"),
        ("\"soil\"", "there is no material \"soil\""),
        ("radus", "has no key \"radus\""),
        ("\"gone.msh\"", "cannot read gone.msh"),
        ("densty", "[[material]] \"rock\" has no key \"densty\""),
        ("\"holes\"", "no body here has a group \"holes\""),
        ("\"bad\"", "there is no body \"bad\""),
    ] {
        told(text, &errors, at, &[part]);
    }
    assert_eq!(errors.faults.len(), 8, "{errors}");
}

#[test]
fn lines_that_are_no_toml_do_not_hide_unknown_keys_in_others() {
    let text = changed("\"block\"", "block").replace("density", "densty");
    let errors = read(&text).unwrap_err();
    told(&text, &errors, "block", &["text goes in quotes"]);
    told(&text, &errors, "densty", &["did you mean \"density\"?"]);
    assert_eq!(errors.faults.len(), 2, "{errors}");
}

#[test]
fn names_that_are_not_there_are_told_with_the_nearest() {
    refused(
        &changed("material = \"rock\"", "material = \"rok\""),
        "\"rok\"",
        &["there is no material \"rok\"", "did you mean \"rock\"?"],
    );
    let boundary = "\n[[boundary]]\nname = \"ground\"\nbody = \"block\"\nside = \"bottom\"\nfixed = \"xy\"\n";
    let text = format!("{SMALL}{boundary}");
    right(&text);
    refused(
        &text.replace("body = \"block\"", "body = \"blok\""),
        "\"blok\"",
        &["there is no body \"blok\"", "did you mean \"block\"?"],
    );
    refused(
        &text.replace("side = \"bottom\"", "group = \"outher\""),
        "\"outher\"",
        &["no body here has a group \"outher\"", "did you mean \"outer\"?"],
    );
    refused(
        &text.replace("side = \"bottom\"", "side = \"below\""),
        "\"below\"",
        &["it is \"left\", \"right\", \"top\", \"bottom\", \"front\" or \"back\""],
    );
    refused(
        &format!("{text}\n[[history]]\nname = \"load\"\nforce = \"grund\"\n"),
        "\"grund\"",
        &["there is no boundary \"grund\"", "did you mean \"ground\"?"],
    );
    refused(
        &format!("{SMALL}\n[output]\nfragments = [\"block\", \"blok\"]\n"),
        "\"blok\"",
        &["there is no body \"blok\"", "did you mean \"block\"?"],
    );
    refused(
        &format!("{SMALL}\n[initial]\nvelocity = {{ blok = [0, 1] }}\n"),
        "blok",
        &["there is no body \"blok\"", "did you mean \"block\"?"],
    );
    refused(
        &format!("{SMALL}\n[[interface]]\nmaterials = [\"rock\", \"rocc\"]\n"),
        "\"rocc\"",
        &["there is no material \"rocc\"", "did you mean \"rock\"?"],
    );
}

#[test]
fn a_body_has_one_shape_and_a_size() {
    refused(
        &changed("mesh_size = 0.1", "mesh_size = 0.1\ndisc = { radius = 1 }"),
        "disc",
        &["has two shapes, rectangle and disc"],
    );
    refused(&changed("mesh_size = 0.1\n", ""), "rectangle", &["lacks the key \"mesh_size\""]);
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let text = format!("{start}{}", rest.split_once('\n').unwrap().1);
    refused(&text, "name", &["\"block\" has no shape"]);
    refused(
        &changed("max = [1.0, 0.5]", "max = [-1.0, 0.5]"),
        "{ min = [0, 0], max = [-1.0, 0.5] }",
        &["the rectangle has no area"],
    );
    let polygon = |points: &str| {
        let (start, rest) = SMALL.split_once("rectangle").unwrap();
        format!("{start}polygon = {{ points = {points} }}\n{}", rest.split_once('\n').unwrap().1)
    };
    for (points, parts) in [
        (
            "[[0, 0], [2, 0], [0, 1.5], [1.9, 1.4]]",
            [
                "the outline crosses itself: the line from [2.0, 0.0] to [0.0, 1.5] cuts the one from [1.9, 1.4] to [0.0, 0.0]",
                "a bowtie is two bodies",
            ],
        ),
        // A bowtie of two equal halves has no area; the message is not about that.
        (
            "[[0, 0], [1, 1], [1, 0], [0, 1]]",
            ["the outline crosses itself", "in their order around the outline"],
        ),
        (
            "[[0, 0], [1, 0]]",
            [
                "\"points\" is a list of 2: it has to have at least 3 entries",
                "a polygon has three corners or more",
            ],
        ),
        (
            "[[0, 0], [1, 0], [0, 1], [6e-17, 0]]",
            [
                "the points [6e-17, 0.0] and [0.0, 0.0] are nearer to each other than a billionth of the shape",
                "they differ by rounding: make them one",
            ],
        ),
        (
            "[[0, 0], [1, 0], [0, 1], [0, 0]]",
            [
                "the last point is the first again, [0.0, 0.0]",
                "outlines close by themselves: take the last point out",
            ],
        ),
        (
            "[[0, 0], [1, 0], [1, 0], [0, 1]]",
            ["points 2 and 3 are the same, [1.0, 0.0]", "take one of them out"],
        ),
    ] {
        refused(&polygon(points), points, &parts);
    }
    let holes = "{ min = [0, 0], max = [1.0, 0.5], holes = [{ centre = [0.4, 0.25], radius = 0.1 }, { centre = [0.5, 0.25], radius = 0.1 }] }";
    let text = changed("{ min = [0, 0], max = [1.0, 0.5] }", holes);
    refused(&text, holes, &["the outline crosses or touches itself"]);
    let grains = "voronoi = { outline = { rectangle = { min = [0, 0], max = [1.0, 0.5] } }, grains = 5000 }";
    let text = changed("rectangle = { min = [0, 0], max = [1.0, 0.5] }", grains);
    refused(
        &text,
        grains.split_once("= ").unwrap().1,
        &["the grains are too small for the mesh", "below the mesh size of 0.1 m"],
    );
    refused(&polygon("[[0, 0], [1, 0], [2, 0]]"), "[[0, 0], [1, 0], [2, 0]]", &["the polygon has no area"]);
    refused(&changed("mesh_size = 0.1", "mesh_size = 1e-6"), "1e-6", &["a mesh size of 1e-6 m gives about"]);
}

#[test]
fn a_boundary_has_one_load_and_is_somewhere() {
    let with = |keys: &str| format!("{SMALL}\n[[boundary]]\nname = \"side\"\n{keys}\n");
    refused(&with("side = \"left\""), "name", &["[[boundary]] \"side\" does nothing"]);
    refused(&with("fixed = \"x\"\nforce = [1, 2]"), "force", &["has two loads, fixed and force"]);
    refused(
        &with("fixed = \"x\"\nside = \"left\"\nbox = [0, 0, 1, 1]"),
        "box",
        &["is in two places, side and box"],
    );
    refused(&with("force = [1, 0]\nramp = 1\ntable = [[0, 1]]"), "table", &["has both ramp and table"]);
    refused(
        &with("force = [1, 0]\ntable = [[0, 1], [0, 2]]"),
        "[[0, 1], [0, 2]]",
        &["the times of its table do not ascend"],
    );
    refused(
        &with("fixed = \"x\"\nbox = [5, 5, 6, 6]"),
        "[5, 5, 6, 6]",
        &["is in a place where there is no node"],
    );
    refused(&with("fixed = \"x\"\nbox = [1, 0, 0, 1]"), "[1, 0, 0, 1]", &["its box is turned inside out"]);
    refused(
        &with("pressure = 1\nbox = [0.4, 0.1, 0.6, 0.3]"),
        "[0.4, 0.1, 0.6, 0.3]",
        &["there is no edge of an outline"],
    );
    refused(&with("velocity = [\"fre\", 0]"), "\"fre\"", &["did you mean \"free\"?"]);
}

#[test]
fn a_traction_on_a_side_of_a_turned_body_has_help() {
    let text = SMALL.replace("mesh_size = 0.1\n", "mesh_size = 0.1\nangle = 30\n");
    let text = text + "[[boundary]]\nname = \"load\"\nside = \"top\"\ntraction = [0, -1]\n";
    let errors = read(&text).unwrap_err().to_string();
    assert!(
        errors
            .contains("there is no edge of an outline; a side is where the box around the turned body ends"),
        "{errors}"
    );
}

#[test]
fn names_have_no_control_characters() {
    let errors = read(&SMALL.replace("name = \"rock\"", "name = \"ro\\u001bck\"")).unwrap_err().to_string();
    assert!(
        errors.contains("the name of the [[material]] \"ro\\u{1b}ck\" is not one line of text"),
        "{errors}"
    );
}

#[test]
fn names_come_once() {
    let again = &SMALL[SMALL.find("[[material]]").unwrap()..];
    let text = format!("{SMALL}\n{again}");
    let errors = read(&text).unwrap_err();
    assert_eq!(
        errors.to_string(),
        "model.toml:17: there is a [[material]] \"rock\" already; names come once"
    );
}

#[test]
fn a_strength_is_complete_or_not_there() {
    let text = changed("poissons_ratio", "tensile_strength = 1e6\ncohesion = 3e6\npoissons_ratio");
    refused(
        &text,
        "tensile_strength",
        &["has a strength that is not complete", "add friction_angle, fracture_energy_i, fracture_energy_ii"],
    );
}

#[test]
fn histories_and_output_are_of_one_kind() {
    refused(
        &format!("{SMALL}\n[[history]]\nname = \"a\"\n"),
        "name",
        &["[[history]] \"a\" is of one quantity"],
    );
    refused(
        &format!("{SMALL}\n[output]\nframes = 5\ninterval = 1e-4\n"),
        "frames",
        &["[output] has both interval and frames"],
    );
    refused(
        &format!("{SMALL}\n[output]\nfields = [\"velocty\"]\n"),
        "\"velocty\"",
        &["did you mean \"velocity\"?"],
    );
    refused(
        &format!("{SMALL}\n[output]\nframes = 2.5\n"),
        "2.5",
        &["not a whole number", "without a decimal point"],
    );
    refused(&format!("{SMALL}\n[[output]]\nframes = 2\n"), "[[output]]", &["[output], with one bracket"]);
}

#[test]
fn mesh_files_are_refused_with_their_name_and_element() {
    let with = |keys: &str| {
        let (start, rest) = SMALL.split_once("rectangle").unwrap();
        format!("{start}{keys}\n{}", rest.split_once("mesh_size = 0.1\n").unwrap().1)
    };
    let refused = |keys: &str, bytes: &'static [u8], at: &str, parts: &[&str]| {
        let text = with(keys);
        let errors = prepare(&text, "model.toml", &mut |_| Ok(bytes.to_vec())).unwrap_err();
        told(&text, &errors, at, parts);
    };
    let squares = include_bytes!("../../../../examples/squares.msh");
    refused(
        "mesh = \"a.msh\"\nonly = [\"lef\"]",
        squares,
        "[\"lef\"]",
        &["no surface group \"lef\"", "did you mean \"left\"?"],
    );
    refused(
        "mesh = \"a.msh\"\ngroups = { rigt = \"rock\" }",
        squares,
        "rigt",
        &["no surface group \"rigt\"", "did you mean \"right\"? there is left, right"],
    );
    refused("mesh = \"a.msh\"\ngroups = { nope = \"rock\" }", squares, "nope", &["there is left, right"]);
    refused(
        "mesh = \"a.obj\"",
        b"v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n",
        "\"a.obj\"",
        &["a.obj: node 2 of the file has the coordinate 1e300: coordinates are in metres"],
    );
    refused(
        "mesh = \"a.obj\"",
        b"v 1e15 0 0\nv 1.000000000000001e15 0 0\nv 1e15 1 0\nf 1 2 3\n",
        "\"a.obj\"",
        &["[[body]] \"block\" is 1 m wide and 1e15 m from the origin: coordinates there have too few digits"],
    );
    refused("mesh = \"a.msh\"\nmesh_size = 1", squares, "mesh_size", &["not for meshes from files"]);
    let overlapping = b"*Node\n1, 0, 0\n2, 1, 0\n3, 1, 1\n*Element, type=CPS3, elset=all\n1, 1, 2, 3\n*Elset, elset=upper\n1\n";
    refused(
        "mesh = \"a.inp\"\ngroups = { all = \"rock\", upper = \"soft\" }\n[[material]]\nname = \"soft\"\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = 0",
        overlapping,
        "upper",
        &["a.inp: element 1 (triangle) is in the groups \"all\" and \"upper\", which have two materials"],
    );
    refused(
        "mesh = \"a.geo\"\nmesh_size = 1",
        b"// Merge \"b.step\";\nMerge \"a.step\";\n",
        "\"a.geo\"",
        &["a.geo:2: Merge takes another file, which Gmsh does not see here"],
    );
    let flat = b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    refused("mesh = \"a.obj\"", flat, "\"a.obj\"", &["a.obj: element 0 (triangle) has no area"]);
    let steep = b"v 0 0 0\nv 1 0 0\nv 2 0 1\nf 1 2 3\n";
    refused("mesh = \"a.obj\"", steep, "\"a.obj\"", &["a.obj has triangles and no tetrahedra", "surface ="]);
    let raised = b"v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n";
    refused("mesh = \"a.obj\"", raised, "\"a.obj\"", &["a.obj is not flat"]);
    let twice = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.5 2 0\nf 1 2 3\nf 1 2 4\n";
    refused("mesh = \"a.obj\"", twice, "\"a.obj\"", &["elements lie on top of each other"]);
    refused("mesh = \"a.obj\"", b"f 1 2 9\n", "\"a.obj\"", &["a.obj:1: element 0 (triangle) names node 1"]);
    let text = with("mesh = \"gone.msh\"");
    let errors = read(&text).unwrap_err();
    told(&text, &errors, "\"gone.msh\"", &["cannot read gone.msh: there is no such file"]);
}

#[test]
fn packings_that_find_no_room_say_how_far_they_came() {
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let packing = "{ count = 50, radius = [0.1, 0.2], within = { min = [0, 0], max = [1, 1] } }";
    let text = format!("{start}packing = {packing}\n{}", rest.split_once('\n').unwrap().1);
    refused(&text, packing, &["50 discs cover 3.66519 times the rectangle", "take fewer or smaller ones"]);
    let fewer = |text: &str| text.replace("count = 50", "count = 12");
    refused(&fewer(&text), &fewer(packing), &["of 12 found room", "take fewer or smaller ones"]);
    let text = text.replace("count = 50, ", "");
    refused(
        &text,
        &packing.replace("count = 50, ", ""),
        &["a packing has a file, or count, radius and within"],
    );
}

#[test]
fn no_text_makes_it_panic() {
    let characters: Vec<char> = SMALL.chars().collect();
    for cut in (0..characters.len()).step_by(7) {
        let _ = read(&characters[..cut].iter().collect::<String>());
        let mut changed = characters.clone();
        for odd in ['"', '[', '=', '-', '\u{85}', '9', '\n'] {
            changed[cut] = odd;
            if let Err(errors) = read(&changed.iter().collect::<String>()) {
                assert!(!errors.render(Drawing::Plain).is_empty());
            }
        }
    }
}

#[test]
fn bodies_of_a_packing_do_not_share_a_name_with_another() {
    let grains = "\n[[body]]\nname = \"grain\"\nmaterial = \"rock\"\npacking = { count = 2, radius = [0.02, 0.03], within = { min = [2, 0], max = [2.3, 0.3] } }\nmesh_size = 0.02\n";
    let text = format!("{}{grains}", SMALL.replace("\"block\"", "\"grain-2\""));
    let errors = read(&text).unwrap_err();
    assert!(errors.to_string().contains("there is a body \"grain-2\" already"), "{errors}");
}

#[test]
fn holes_beyond_the_outline_or_in_one_another_are_refused() {
    for (holes, what) in [
        ("{ centre = [3, 1], radius = 0.05 }", "hole 1 is not inside the outline"),
        ("{ centre = [0.5, 0.25], radius = 2 }", "hole 1 is not inside the outline"),
        ("{ centre = [0, 0.25], radius = 0.1 }", "hole 1 is not inside the outline"),
        (
            "{ centre = [0.5, 0.25], radius = 0.2 }, { centre = [0.5, 0.25], radius = 0.05 }",
            "hole 2 is in hole 1",
        ),
    ] {
        let text = changed("max = [1.0, 0.5] }", &format!("max = [1.0, 0.5], holes = [{holes}] }}"));
        let errors = read(&text).unwrap_err();
        assert!(errors.to_string().contains(what), "{holes}: {errors}");
    }
}

#[test]
fn a_node_that_two_boundaries_move_is_refused() {
    let boundary =
        |name: &str, load: &str| format!("\n[[boundary]]\nname = \"{name}\"\nside = \"top\"\n{load}\n");
    let moved = boundary("upper", "velocity = [\"free\", -0.1]\nramp = 1e-4");
    for load in
        ["velocity = [0, -0.2]\nramp = 1e-4", "fixed = \"y\"", "displacement = [\"free\", 0]\nramp = 1e-4"]
    {
        let text = format!("{SMALL}{moved}{}", boundary("also", load));
        refused(
            &text,
            "\"also\"",
            &["\"also\" and \"upper\" both prescribe how node", "moves along y", "\"free\""],
        );
    }
    let apart = format!("{SMALL}{moved}{}", boundary("also", "fixed = \"x\""));
    assert!(read(&apart).is_ok());
    let still =
        format!("{SMALL}{}{}", boundary("upper", "fixed = \"xy\""), boundary("also", "fixed = \"y\""));
    assert!(read(&still).is_ok());
}

#[test]
fn numbers_beyond_all_solids_are_refused_at_their_place() {
    for (from, to) in [
        ("2700", "1e300"),
        ("30e9", "1e31"),
        ("max = [1.0,", "max = [1e300,"),
        ("0.25", "0.25\nfriction = 1e40"),
        ("end_time", "gravity = [0, -1e300]\nend_time"),
    ] {
        let number =
            to.split(['[', ' ', ',', ']']).find(|word| word.contains("e3") || word.contains("e4")).unwrap();
        refused(&changed(from, to), number, &[number, "numbers are in SI units and from -1e30 to 1e30"]);
    }
    let damped = changed("0.25", "0.25\ndamping = 1e20");
    refused(&damped, "1e20", &["\"damping\" is 1e20: it has to be at most 1000"]);
}

#[test]
fn bodies_too_far_from_the_origin_for_their_shape_are_refused() {
    let moved = changed("mesh_size = 0.1", "mesh_size = 0.1\ntranslate = [1e16, 0]");
    refused(&moved, "[1e16, 0]", &["\"block\" is 1 m wide", "from the origin", "put the origin nearer"]);
    let shape = "disc = { centre = [0, 1e17], radius = 0.5 }";
    let text = changed("rectangle = { min = [0, 0], max = [1.0, 0.5] }", shape);
    refused(&text, &shape[7..], &["too few digits for its shape"]);
    right(&changed("mesh_size = 0.1", "mesh_size = 0.1\ntranslate = [1e9, 0]"));
}

#[test]
fn words_in_the_place_of_numbers_are_told_with_what_is_expected() {
    let boundary =
        |keys: &str| format!("{SMALL}\n[[boundary]]\nname = \"b\"\nside = \"left\"\nramp = 1\n{keys}\n");
    refused(
        &boundary("velocity = [0, \"fre\"]"),
        "\"fre\"",
        &["\"velocity\" cannot be \"fre\": it is a number or \"free\"", "did you mean \"free\"?"],
    );
    refused(
        &changed("end_time", "gravity = \"down\"\nend_time"),
        "\"down\"",
        &["\"gravity\" cannot be \"down\": it is a list of 2 or 3, each a number, or \"none\""],
    );
}

#[test]
fn a_second_shape_of_an_outline_is_told() {
    let shape = "voronoi = { outline = { disc = { radius = 1 }, rectangle = { min = [0, 0], max = [1, 1] } }, grains = 5 }";
    let text = changed("rectangle = { min = [0, 0], max = [1.0, 0.5] }", shape);
    let errors = read(&text).unwrap_err().to_string();
    assert!(errors.contains("an outline is one shape, and this has two, rectangle and disc"), "{errors}");
    let discs = "packing = { shape = \"disc\", count = 2, radius = [0.1, 0.1], within = { min = [0, 0, 0], max = [1, 1, 1] } }";
    let text = changed("rectangle = { min = [0, 0], max = [1.0, 0.5] }", discs);
    let errors = read(&text).unwrap_err().to_string();
    assert!(errors.contains("discs are flat: write [x, y], or take shape = \"sphere\""), "{errors}");
}

/// The text of a model with a shape, in the place of the rectangle of the small one.
#[track_caller]
fn with_shape(shape: &str) -> String {
    let line = SMALL.lines().find(|line| line.starts_with("rectangle")).unwrap();
    SMALL.replace(line, shape)
}

#[test]
fn a_list_in_the_place_of_a_table_is_answered_with_its_form() {
    let points = "[[0, 0], [1, 0], [1, 0.5]]";
    let text = with_shape(&format!("polygon = {points}"));
    refused(&text, points, &["\"polygon\" is a list, not a table", "write polygon = { points = […] }"]);
    let text = with_shape("rectangle = [0, 0, 1, 0.5]");
    refused(&text, "[0, 0, 1, 0.5]", &["write rectangle = { min = […], max = […] }"]);
    let text = with_shape("disc = 0.5");
    refused(&text, "0.5", &["\"disc\" is a number", "write disc = { radius = … }"]);
    let text = with_shape("rectangle = [{ min = [0, 0], max = [1, 0.5] }]");
    refused(&text, "[{ min = [0, 0], max = [1, 0.5] }]", &["this table comes once: rectangle = { … }"]);
}

#[test]
fn a_key_beside_the_table_that_has_it_is_said_to_belong_into_it() {
    let holes = "holes = [{ centre = [0.5, 0.25], radius = 0.1 }]";
    let line = SMALL.lines().find(|line| line.starts_with("rectangle")).unwrap();
    let text = SMALL.replace(line, &format!("{line}\n{holes}"));
    refused(&text, "holes", &["has no key \"holes\"", "write rectangle = { …, holes = … }"]);
}

#[test]
fn a_switch_in_the_place_of_a_table_is_answered_with_the_table() {
    let text = format!("{SMALL}\n[output]\nacoustic_emission = true\n");
    refused(
        &text,
        "true",
        &["\"acoustic_emission\" is true or false", "acoustic_emission = {} has the defaults"],
    );
}

/// Boundaries of a file whose bodies cannot be read are not blamed for having no place.
#[test]
fn a_body_with_one_bracket_is_the_only_error() {
    let text = changed("[[body]]", "[body]")
        + "\n[[boundary]]\nname = \"base\"\nside = \"bottom\"\nfixed = \"xy\"\n";
    refused(&text, "[body]", &["\"body\" is a table, not a list", "two brackets: [[body]]"]);
}

/// Other keys of `[model]` count, and a table that needs a key without a value is not blamed.
#[test]
fn a_wrong_value_of_the_model_brings_no_errors_elsewhere() {
    let rest = "\n[initial]\nground = { k0 = 0.5, surface = 0.5 }\n\
                [[boundary]]\nname = \"base\"\nside = \"bottom\"\nfixed = \"xy\"\n\
                [[boundary]]\nname = \"sides\"\nsides = [\"left\", \"right\"]\nfixed = \"x\"\n";
    let right_one =
        changed("end_time = 1e-3", "plane = \"strain\"\ngravity = [0, -9.81]\nend_time = 1e-3") + rest;
    right(&right_one);
    let text = right_one.replace("end_time = 1e-3", "end_time = \"5 hours\"");
    refused(&text, "hours", &["\"hours\" is no unit"]);
    let text = right_one.replace("-9.81]", "\"-9.81 m/h\"]");
    refused(&text, "h", &["there is no parameter \"h\""]);
}
