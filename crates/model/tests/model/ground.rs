//! Ground whose surface is not where the bodies end, and ground in plane stress.

use fdem_model::{AnyPrepared, prepare_any};

use crate::{read, right};

/// A block of 60 m by 45 m, held at its base and at its sides.
const BLOCK: &str = r#"
[model]
plane = "strain"
gravity = [0, -9.81]
end_time = 0.05
[[body]]
name = "g"
material = "rock"
rectangle = { min = [0, 0], max = [60, 45] }
mesh_size = 5
[[material]]
name = "rock"
density = 2600
youngs_modulus = 5e9
poissons_ratio = 0.25
[initial]
ground = { k0 = 0.5, surface = 45 }
[[boundary]]
name = "base"
side = "bottom"
fixed = "xy"
[[boundary]]
name = "sides"
sides = ["left", "right"]
fixed = "x"
"#;

fn with_surface(level: &str) -> String {
    BLOCK.replace("surface = 45", &format!("surface = {level}"))
}

fn about_surface(text: &str) -> Vec<String> {
    let warnings = right(text).warnings.into_iter();
    warnings.filter(|warning| warning.starts_with("[initial] ground")).collect()
}

#[test]
fn ground_above_a_free_top_is_a_warning() {
    let found = about_surface(&with_surface("300"));
    assert_eq!(found.len(), 1, "{found:?}");
    let start = "[initial] ground: \"g\" ends at 45 m with a free top, 255 m below the surface: 6.50";
    assert!(found[0].starts_with(start), "{}", found[0]);
    assert!(found[0].ends_with("write surface = 45, or load or hold its top"), "{}", found[0]);
    // The upper corners are in "sides", which hold them along x alone.
    let top =
        |load: &str| format!("{}[[boundary]]\nname = \"top\"\nside = \"top\"\n{load}\n", with_surface("300"));
    for load in ["pressure = 6.5e6", "traction = [0, -6.5e6]", "fixed = \"xy\"", "absorbing = true"] {
        assert_eq!(about_surface(&top(load)), [""; 0], "{load}");
    }
    assert_eq!(about_surface(&top("fixed = \"x\"")).len(), 1);
    // Half of the top is loaded.
    let half = "[[boundary]]\nname = \"half\"\nbox = [0, 44.9, 30, 45.1]\npressure = 6.5e6\n";
    assert_eq!(about_surface(&(with_surface("300") + half)).len(), 1);
    // A point is the highest place.
    let gable = with_surface("300").replace(
        "rectangle = { min = [0, 0], max = [60, 45] }",
        "polygon = { points = [[0, 0], [60, 0], [60, 30], [30, 45], [0, 30]] }",
    );
    assert_eq!(about_surface(&gable).len(), 1);
}

#[test]
fn ground_in_space_has_the_same_warnings() {
    let text = BLOCK
        .replace("plane = \"strain\"\n", "")
        .replace("[0, -9.81]", "[0, 0, -9.81]")
        .replace(
            "rectangle = { min = [0, 0], max = [60, 45] }",
            "box = { min = [0, 0, 0], max = [60, 60, 45] }",
        )
        .replace("mesh_size = 5", "mesh_size = 20")
        .replace("fixed = \"xy\"", "fixed = \"xyz\"");
    for (level, part) in [
        ("300", "\"g\" ends at 45 m with a free top, 255 m below the surface"),
        ("45", ""),
        ("10", "\"g\" reaches 45 m, above the surface at 10 m"),
    ] {
        let text = text.replace("surface = 45", &format!("surface = {level}"));
        let prepared = prepare_any(&text, "m.toml", &mut |_| Err("no files".to_owned()), None);
        let Ok(AnyPrepared::Space(prepared)) = prepared else { panic!("a model in space") };
        let found: Vec<&String> =
            prepared.warnings.iter().filter(|warning| warning.starts_with("[initial] ground")).collect();
        assert_eq!(found.len(), usize::from(!part.is_empty()), "{found:?}");
        assert!(found.iter().all(|warning| warning.contains(part)), "{found:?}");
    }
}

#[test]
fn weight_above_the_surface_is_a_warning() {
    let found = about_surface(&with_surface("10"));
    assert_eq!(found.len(), 1, "{found:?}");
    let start = "[initial] ground: \"g\" reaches 45 m, above the surface at 10 m: 7";
    assert!(found[0].starts_with(start), "{}", found[0]);
    assert!(found[0].contains("write surface = 45"), "{}", found[0]);
}

/// A surface at the highest level is right for flat tops, slopes and excavations; a hill may stand above it,
/// and a body that rests on it has no stress.
#[test]
fn slopes_hills_and_bodies_on_the_ground_are_no_warning() {
    let rectangle = "rectangle = { min = [0, 0], max = [60, 45] }";
    let polygon = |points: &str| BLOCK.replace(rectangle, &format!("polygon = {{ points = {points} }}"));
    let slope = polygon("[[0, 0], [60, 0], [60, 20], [35, 20], [25, 45], [0, 45]]");
    let hill = polygon("[[0, 0], [60, 0], [60, 45], [40, 45], [30, 50], [20, 45], [0, 45]]");
    let second = |table: &str| {
        BLOCK.replace(
            "[[material]]",
            &format!("[[body]]\nname = \"s\"\nmaterial = \"rock\"\n{table}\nmesh_size = 5\n[[material]]"),
        )
    };
    let house = second("rectangle = { min = [20, 45], max = [30, 65] }");
    let bench = second("rectangle = { min = [60, 0], max = [80, 20] }");
    for text in [BLOCK, &with_surface("45.2"), &slope, &hill, &house, &bench] {
        assert_eq!(about_surface(text), [""; 0], "{text}");
    }
}

#[test]
fn ground_needs_plane_strain() {
    for plane in ["plane = \"stress\"\n", ""] {
        let errors = read(&BLOCK.replace("plane = \"strain\"\n", plane)).unwrap_err().to_string();
        assert!(errors.contains("\"ground\" has a stress across the plane"), "{errors}");
        assert!(errors.contains("write plane = \"strain\" in [model]"), "{errors}");
    }
}

#[test]
fn another_density_and_horizontal_tension_are_warnings() {
    let with = |keys: &str| about_surface(&BLOCK.replace("k0 = 0.5", keys));
    let found = with("k0 = 0.5, density = 1500");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("its density is 1500 kg/m³, but that of \"g\" is 2600 kg/m³"), "{found:?}");
    assert_eq!(with("k0 = 0.5, density = 2400"), [""; 0]);
    let found = with("k0 = -0.5");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("k0 is below 0"), "{found:?}");
}
