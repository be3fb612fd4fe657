//! Models that include files, and bodies that are repeated.

use std::collections::BTreeMap;

use fdem_model::{AnyPrepared, Drawing, ModelErrors, prepare_any, with_end_time};

const MATERIALS: &str = "[parameters]\nE = \"30 GPa\"\nunused = 1\n\n[[material]]\nname = \"rock\"\ndensity = 2700\n\
    youngs_modulus = \"E\"\npoissons_ratio = 0.25\n";
const BODY: &str = "[[body]]\nname = \"block\"\nmaterial = \"rock\"\nrectangle = { min = [0, 0], max = [1.0, 0.5] }\nmesh_size = 0.25\n";

/// Reads a model with files beside it.
fn read(text: &str, files: &[(&str, &str)]) -> Result<AnyPrepared, ModelErrors> {
    let files: BTreeMap<&str, &str> = files.iter().copied().collect();
    let mut load = |name: &str| match files.get(name) {
        Some(text) => Ok(text.as_bytes().to_vec()),
        None => Err("there is no such file".to_owned()),
    };
    prepare_any(text, "folder/model.toml", &mut load, None)
}

#[track_caller]
fn plane(text: &str, files: &[(&str, &str)]) -> fdem_model::Prepared {
    match read(text, files).unwrap_or_else(|errors| panic!("{errors}")) {
        AnyPrepared::Plane(prepared) => *prepared,
        AnyPrepared::Space(_) => panic!("it is flat"),
    }
}

#[test]
fn a_model_with_included_files_is_the_one_written_out() {
    let whole = plane(&format!("[model]\nend_time = 1\nthickness = 2\n{BODY}{MATERIALS}"), &[]);
    assert_eq!(whole.warnings, ["the parameter \"unused\" is not used"]);
    let main = format!("include = \"lib/rocks.toml\"\n[model]\nend_time = 1\n{BODY}");
    let general = "include = [\"../materials.toml\", \"more.toml\"]\n[model]\nend_time = 5\nthickness = 2\n";
    let files = [
        ("lib/rocks.toml", general),
        ("materials.toml", MATERIALS),
        ("lib/more.toml", "include = \"../materials.toml\"\n"),
    ];
    let parts = plane(&main, &files);
    assert_eq!(parts.hash, whole.hash);
    // The including file wins, and parameters of included files may be for other models.
    assert_eq!((parts.end_time, parts.warnings), (1.0, Vec::new()));
    let softer = plane(&main.replace("[model]", "[parameters]\nE = 1e9\n[model]"), &files);
    assert_eq!(softer.model.materials[0].youngs_modulus, 1e9);
}

#[test]
fn paths_in_an_included_file_are_relative_to_it() {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let body = "[[body]]\nname = \"a\"\nmaterial = \"rock\"\nmesh = \"mesh.obj\"\n";
    let main = format!("include = \"parts/body.toml\"\n[model]\nend_time = 1\n{MATERIALS}");
    let prepared = plane(&main, &[("parts/body.toml", body), ("parts/mesh.obj", mesh)]);
    assert_eq!(prepared.quality.elements, 1);
}

#[test]
fn faults_name_the_file_that_has_them() {
    let main = format!("include = \"materials.toml\"\n[model]\nend_time = 1\n{BODY}");
    let wrong = |materials: &str| read(&main, &[("materials.toml", materials)]).map(|_| ()).unwrap_err();
    for (from, to, line, part) in [
        ("2700", "-2700", 7, "\"density\" is -2700"),
        ("\"E\"", "\"2 m\"", 8, "\"2 m\" is a length, but youngs_modulus is in Pa"),
        ("density", "densty", 7, "did you mean \"density\"?"),
        ("\"30 GPa\"", "\"30 Gpa\"", 2, "\"Gpa\" is no unit"),
        ("= 0.25", "= = 0.25", 9, "this is not TOML"),
    ] {
        let errors = wrong(&MATERIALS.replace(from, to));
        assert_eq!(errors.faults.len(), 1, "{errors}");
        assert!(errors.to_string().starts_with(&format!("folder/materials.toml:{line}: ")), "{errors}");
        assert!(errors.to_string().contains(part), "{errors}");
        let drawn = errors.render(Drawing::Plain);
        assert!(drawn.contains(&format!("--> folder/materials.toml:{line}:")), "{drawn}");
        assert_eq!(errors.file(&errors.faults[0]), "folder/materials.toml");
    }
    let errors =
        read(&main.replace("end_time", "endtime"), &[("materials.toml", MATERIALS)]).map(|_| ()).unwrap_err();
    assert!(errors.to_string().starts_with("folder/model.toml:3: "), "{errors}");
}

#[test]
fn files_that_cannot_be_included_are_told() {
    let main = "include = \"a.toml\"\n[model]\nend_time = 1\n";
    let whole = format!("{main}{BODY}{MATERIALS}");
    for (files, part) in [
        (vec![], "folder/model.toml:1: cannot include a.toml: there is no such file"),
        (
            vec![("a.toml", "include = \"a.toml\"")],
            "folder/a.toml:1: files include each other in a circle: a.toml -> a.toml",
        ),
        (
            vec![("a.toml", "\ninclude = \"b.toml\""), ("b.toml", "include = [\"x/../a.toml\"]")],
            "folder/b.toml:1: files include each other in a circle: a.toml -> b.toml -> a.toml",
        ),
        (
            vec![("a.toml", "include = \"model.toml\""), ("model.toml", whole.as_str())],
            "the model -> a.toml -> model.toml",
        ),
        (vec![("a.toml", "[body]\nname = 1")], "\"body\" is a table in one file and a list in another"),
        (vec![("a.toml", "include = 3")], "folder/a.toml:1: \"include\" is no text in quotes"),
    ] {
        let errors = read(&whole, &files).map(|_| ()).unwrap_err();
        assert!(errors.to_string().contains(part), "{part:?} is not in\n{errors}");
    }
    let many: Vec<(String, String)> =
        (0..50).map(|k| (format!("f{k}.toml"), format!("include = \"f{}.toml\"", k + 1))).collect();
    let mut files: Vec<(&str, &str)> =
        many.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    files.push(("a.toml", "include = \"f0.toml\""));
    let errors = read(&whole, &files).map(|_| ()).unwrap_err().to_string();
    assert!(errors.contains("more than 20 files include each other in a chain"), "{errors}");
}

#[test]
fn the_end_time_of_a_model_with_included_files_can_change() {
    let included = [("a.toml", "[model]\nend_time = 1\n")];
    for (head, expected) in [
        (
            "include = \"a.toml\"\n[model]\nthickness = 2\n",
            "include = \"a.toml\"\n[model]\nend_time = 0.5\nthickness = 2\n",
        ),
        ("include = \"a.toml\"\n[model] # one\n", "include = \"a.toml\"\n[model] # one\nend_time = 0.5\n"),
        (
            "include = \"a.toml\"\n[model]\nend_time = \"2 s\"\n",
            "include = \"a.toml\"\n[model]\nend_time = 0.5\n",
        ),
    ] {
        let text = format!("{head}{BODY}{MATERIALS}");
        let changed = with_end_time(&text, 0.5).unwrap();
        assert!(changed.starts_with(expected), "{changed}");
        assert_eq!(plane(&changed, &included).end_time, 0.5);
    }
    let text = format!("include = \"a.toml\"\n{BODY}{MATERIALS}");
    assert_eq!(plane(&with_end_time(&text, 0.5).unwrap(), &included).end_time, 0.5);
}

/// A wall of copies is that of the bodies written one by one.
#[test]
fn a_repeated_body_is_its_copies() {
    let body = |name: &str, x: f64, y: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"rock\"\nrectangle = {{ min = [0, 0], max = [1.0, 0.5] }}\nmesh_size = 0.25\ntranslate = [{x}, {y}]\n"
        )
    };
    let head = format!("[model]\nend_time = 1\n{MATERIALS}");
    let one = |keys: &str| format!("{head}{BODY}{keys}");
    let written: String = (0..3)
        .flat_map(|i| (0..2).map(move |j| (i, j)))
        .map(|(i, j)| body(&format!("block-{}-{}", i + 1, j + 1), f64::from(i), 0.75 * f64::from(j)))
        .collect();
    let copies = plane(&one("repeat = [3, 2]\nspacing = [1, \"75 cm\"]\n"), &[]);
    let written = plane(&format!("{head}{written}"), &[]);
    assert_eq!(copies.hash, written.hash);
    let names: Vec<&str> = copies.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["block-1-1", "block-1-2", "block-2-1", "block-2-2", "block-3-1", "block-3-2"]);
    // Without a spacing the copies touch.
    let touching = plane(&one("repeat = [3, 1]\n"), &[]);
    assert_eq!(touching.model.mesh.nodes.iter().map(|node| node[0]).fold(0.0, f64::max), 3.0);
    // The name means all copies, and that of one copy this one.
    let boundary = |body: &str| {
        let text = one(&format!(
            "repeat = [3, 2]\nspacing = [2, 1]\n[[boundary]]\nname = \"b\"\nbody = \"{body}\"\nfixed = \"xy\"\n"
        ));
        read(&text, &[]).map(|prepared| match prepared {
            AnyPrepared::Plane(prepared) => prepared.model.boundaries[0].target.nodes().len(),
            AnyPrepared::Space(_) => 0,
        })
    };
    assert_eq!(boundary("block").unwrap(), copies.model.mesh.nodes.len());
    assert_eq!(6 * boundary("block-3-2").unwrap(), copies.model.mesh.nodes.len());
    assert!(boundary("block-4-1").unwrap_err().to_string().contains("block-4-1"));
    for key in
        ["excavate = [\"block-4-1\"]", "activate = [\"block-4-1\"]", "materials = { block-4-1 = \"rock\" }"]
    {
        let stages = "[[stage]]\nname = \"rest\"\nduration = 1e-4\n[[stage]]\nname = \"cut\"\n";
        let text = one(&format!("repeat = [3, 2]\nspacing = [2, 1]\n{stages}{key}\n"));
        let told = read(&text, &[]).map(|_| ()).unwrap_err().to_string();
        assert!(told.contains("there is no body \"block-4-1\""), "{told}");
        assert!(told.contains("the bodies of this table are \"block-1-1\" to \"block-3-2\""), "{told}");
    }
    for (keys, part) in [
        ("repeat = [3]\n", "\"repeat\" is a list of 1"),
        ("repeat = [3, 0]\n", "\"repeat\" is 0: it has to be at least 1"),
        ("repeat = [3, 1, 1]\n", "repeat"),
        ("repeat = [1000000, 1000000]\n", "at most 1,000,000 are possible"),
        ("spacing = [1, 1]\n", "\"spacing\" goes with \"repeat\""),
        ("repeat = [2, 2]\nspacing = [1, 1, 1]\n", "spacing"),
    ] {
        let errors = read(&one(keys), &[]).map(|_| ()).unwrap_err().to_string();
        assert!(errors.contains(part), "{part:?} is not in\n{errors}");
    }
}

#[test]
fn a_repeated_body_in_space_is_its_copies() {
    let text = format!(
        "[model]\nend_time = 1\n{MATERIALS}[[body]]\nname = \"brick\"\nmaterial = \"rock\"\nbox = {{ min = [0, 0, 0], max = [0.2, 0.1, 0.1] }}\n\
         mesh_size = 0.1\nrepeat = [2, 1, 3]\n"
    );
    let AnyPrepared::Space(prepared) = read(&text, &[]).unwrap() else { panic!("it is in space") };
    let names: Vec<&str> = prepared.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(
        names,
        ["brick-1-1-1", "brick-1-1-2", "brick-1-1-3", "brick-2-1-1", "brick-2-1-2", "brick-2-1-3"]
    );
    let most = |axis: usize| prepared.model.mesh.nodes.iter().map(|node| node[axis]).fold(0.0, f64::max);
    assert!((most(0) - 0.4).abs() < 1e-12 && (most(2) - 0.3).abs() < 1e-12);
}
