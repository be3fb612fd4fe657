//! The library of materials.

use fdem_model::{AnyPrepared, ModelErrors, Preflight, library, prepare_any};

const PLANE: &str = "[model]\nend_time = 1e-6\n[[body]]\nname = \"block\"\nmaterial = \"rock\"\nmesh_size = 2e-5\n\
    rectangle = { min = [0, 0], max = [8e-5, 4e-5] }\n";
const SPACE: &str = "[model]\nend_time = 1e-6\n[[body]]\nname = \"block\"\nmaterial = \"rock\"\nmesh_size = 2e-5\n\
    box = { min = [0, 0, 0], max = [4e-5, 4e-5, 4e-5] }\n";

fn prepared(body: &str, material: &str) -> Result<AnyPrepared, ModelErrors> {
    let text = format!("{body}[[material]]\nname = \"rock\"\n{material}");
    prepare_any(&text, "model.toml", &mut |_| Err("no files".to_owned()), None)
}

#[track_caller]
fn hash(body: &str, material: &str) -> (String, Vec<String>, Preflight) {
    match prepared(body, material).unwrap_or_else(|errors| panic!("{errors}")) {
        AnyPrepared::Plane(found) => {
            let preflight = Preflight::of(&found).unwrap();
            (found.hash, found.warnings, preflight)
        }
        AnyPrepared::Space(found) => {
            let preflight = Preflight::of(&found).unwrap();
            (found.hash, found.warnings, preflight)
        }
    }
}

/// A material of the library is the one with its keys written out, without warnings, in two dimensions and in
/// three.
#[test]
fn a_material_of_the_library_is_the_one_written_out() {
    for material in library() {
        let lines: Vec<String> = material
            .keys
            .iter()
            .map(|(key, value)| {
                format!(
                    "{key} = {value:?}
"
                )
            })
            .collect();
        let written = lines.concat();
        for body in [PLANE, SPACE] {
            let (whole, _, _) = hash(body, &written);
            let (short, warnings, _) = hash(body, &format!("library = \"{}\"\n", material.name));
            assert_eq!(short, whole, "{}", material.name);
            assert!(warnings.is_empty(), "{}: {warnings:?}", material.name);
        }
    }
}

/// The figures of each material are complete and fit each other.
#[test]
fn the_figures_are_plausible() {
    for material in library() {
        let name = &material.name;
        assert!(!material.about.is_empty() && material.source.len() > 20, "{name} has no source");
        let key = |key: &str| material.value(key);
        let [Some(density), Some(modulus), Some(ratio), Some(friction)] =
            ["density", "youngs_modulus", "poissons_ratio", "friction"].map(key)
        else {
            panic!("{name} lacks a key")
        };
        assert!((900.0..8000.0).contains(&density) && (0.1..0.4).contains(&ratio), "{name}");
        assert!((0.05..1.0).contains(&friction), "{name}");
        let five =
            ["tensile_strength", "cohesion", "friction_angle", "fracture_energy_i", "fracture_energy_ii"];
        let [Some(tensile), Some(cohesion), Some(angle), Some(one), Some(two)] = five.map(key) else {
            assert_eq!(five.map(key), [None; 5], "{name} has some keys of strength");
            continue;
        };
        // The characteristic length is a third of a millimetre in glass and half a metre in concrete.
        let length = modulus * one / (tensile * tensile);
        let is_glass = name == "glass";
        assert!((if is_glass { 1e-4..1e-3 } else { 4e-3..0.7 }).contains(&length), "{name}: {length} m");
        let compressive = 2.0 * cohesion * (45.0 + angle / 2.0).to_radians().tan();
        assert!((6.0..25.0).contains(&(compressive / tensile)), "{name}: {compressive} Pa");
        assert_eq!(two, 5.0 * one, "{name}");
    }
    assert!(library().len() >= 10);
}

#[test]
fn keys_of_the_table_win() {
    let (changed, _, preflight) =
        hash(PLANE, "library = \"granite\"\ndensity = \"2.7 g/cm^3\"\ncohesion = 1e7\n");
    let (plain, _, _) = hash(PLANE, "library = \"granite\"\n");
    assert_ne!(changed, plain);
    let AnyPrepared::Plane(found) =
        prepared(PLANE, "cohesion = 1e7\ndensity = 2700\nlibrary = \"granite\"\n").unwrap()
    else {
        panic!("it is flat")
    };
    let rock = &found.model.materials[0];
    assert_eq!((rock.density, rock.strength.unwrap().cohesion, rock.youngs_modulus), (2700.0, 1e7, 60e9));
    assert_eq!(found.hash, changed);
    let text = preflight.to_string();
    let line = "library          \"rock\" is granite: fracture_energy_i, fracture_energy_ii, friction, friction_angle, \
        poissons_ratio, tensile_strength, youngs_modulus; the file gives cohesion, density\n";
    assert!(text.contains(line), "{text}");
}

#[test]
fn an_unknown_material_is_told_with_the_nearest_and_all() {
    for (name, near) in [("granit", Some("granite")), ("Sandstone", Some("sandstone")), ("cheese", None)] {
        let errors = prepared(PLANE, &format!("library = \"{name}\"\n")).unwrap_err();
        assert_eq!(errors.faults.len(), 1, "{errors}");
        let text = errors.to_string();
        assert!(text.starts_with("model.toml:10: \"library\" cannot be"), "{text}");
        assert!(library().iter().all(|material| text.contains(&format!("\"{}\"", material.name))), "{text}");
        match near {
            Some(near) => assert!(text.ends_with(&format!("did you mean \"{near}\"?")), "{text}"),
            None => assert!(!text.contains("did you mean"), "{text}"),
        }
    }
    let errors = prepared(PLANE, "library = 3\n").unwrap_err();
    assert_eq!(errors.faults.len(), 1, "{errors}");
    assert!(errors.to_string().contains("\"library\" is a number"), "{errors}");
    // The keys of the table itself are checked as usual.
    let errors = prepared(PLANE, "library = \"granite\"\ndensity = -1\n").unwrap_err();
    assert!(errors.to_string().contains("model.toml:11: \"density\" is -1"), "{errors}");
    // Without a library the keys must be there.
    let errors = prepared(PLANE, "density = 2700\n").unwrap_err();
    assert!(errors.to_string().contains("lacks the key \"youngs_modulus\""), "{errors}");
}

/// The schema for editors requires the library or the keys.
#[test]
fn the_schema_asks_for_one_of_both() {
    let schema = fdem_model::schema();
    let material = &schema["$defs"]["Material"];
    assert_eq!(material["required"], serde_json::json!(["name"]));
    let needed = serde_json::json!(["density", "youngs_modulus", "poissons_ratio"]);
    assert_eq!(material["anyOf"], serde_json::json!([{ "required": ["library"] }, { "required": needed }]));
    assert_eq!(material["properties"]["library"]["enum"].as_array().unwrap().len(), library().len());
}

/// An unbreakable material has no strengths from the library, and none of its own.
#[test]
fn an_unbreakable_material_has_no_strengths() {
    let material = prepared(PLANE, "library = \"granite\"\nunbreakable = true\n").unwrap();
    let AnyPrepared::Plane(flat) = material else { panic!("it has two dimensions") };
    assert_eq!(flat.model.materials[0].strength, None);
    let errors = prepared(PLANE, "library = \"granite\"\nunbreakable = true\ncohesion = 3e6\n").unwrap_err();
    assert!(errors.to_string().contains("is unbreakable and has a strength"), "{errors}");
}
