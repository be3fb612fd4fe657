//! Values of a model that are set from outside.

use fdem_model::{Setting, with_values};

const MODEL: &str = "[parameters]\nE = 1e9\n[model]\nend_time = 1 # long\ngravity = [0, -9.81]\n\
    [[material]]\nname = \"rock\"\ndensity = 2700\n[[material]]\nname = \"rock.wet\"\ndensity = 2800\n\
    [[body]]\nname = \"a\"\nrectangle = { min = [0, 0], max = [1, 2] }\n[[interface]]\nmaterials = [\"rock\", \"rock\"]\nfriction = 0.1\n";

fn set(text: &str, sets: &[(&str, &str)]) -> Result<String, String> {
    let sets: Vec<(String, Setting)> =
        sets.iter().map(|(name, value)| ((*name).to_owned(), Setting::parse(value))).collect();
    let mut load = |name: &str| match name {
        "lib.toml" => Ok(
            b"[parameters]\nnu = 0.25\n[[material]]\nname = \"ice\"\ndensity = 917\n[contact]\npenalty = 3\n"
                .to_vec(),
        ),
        _ => Err("there is no such file".to_owned()),
    };
    with_values(text, &mut load, &sets)
}

#[test]
fn values_replace_those_of_the_file_and_nothing_else_changes() {
    for (name, value, from, to) in [
        ("E", "30 GPa", "E = 1e9", "E = \"30 GPa\""),
        ("E", "3", "E = 1e9", "E = 3"),
        ("E", "0", "E = 1e9", "E = 0"),
        ("E", "-0.0", "E = 1e9", "E = -0.0"),
        ("E", "9007199254740993", "E = 1e9", "E = 9007199254740993"),
        ("E", "-9223372036854775808", "E = 1e9", "E = -9223372036854775808"),
        ("parameters.E", "3", "E = 1e9", "E = 3"),
        ("E", "0.5", "E = 1e9", "E = 0.5"),
        ("model.end_time", "1e-3", "end_time = 1 #", "end_time = 0.001 #"),
        ("model.gravity.1", "-1", "-9.81", "-1"),
        ("model.gravity", "none", "[0, -9.81]", "\"none\""),
        ("material.rock.density", "1", "density = 2700", "density = 1"),
        ("material.rock.wet.density", "1", "density = 2800", "density = 1"),
        ("material.2.density", "1", "density = 2800", "density = 1"),
        ("body.a.rectangle.max.0", "5", "max = [1, 2]", "max = [5, 2]"),
        ("interface.1.friction", "0.2", "friction = 0.1", "friction = 0.2"),
        (
            "material.rock.friction",
            "0.2",
            "[[material]]\nname = \"rock\"\n",
            "[[material]]\nfriction = 0.2\nname = \"rock\"\n",
        ),
        (
            "fracture.insertion",
            "intrinsic",
            "friction = 0.1\n",
            "friction = 0.1\n\n[fracture]\ninsertion = \"intrinsic\"\n",
        ),
        ("model.safety", "0.5", "[model]\n", "[model]\nsafety = 0.5\n"),
    ] {
        assert_eq!(set(MODEL, &[(name, value)]).unwrap(), MODEL.replacen(from, to, 1), "{name}");
    }
    let both = set(MODEL, &[("E", "2"), ("E", "3"), ("model.end_time", "4")]).unwrap();
    assert_eq!(both, MODEL.replace("E = 1e9", "E = 3").replace("end_time = 1 ", "end_time = 4 "));
}

#[test]
fn values_of_included_files_are_set_where_that_is_possible() {
    let text = format!("include = \"lib.toml\"\n{MODEL}");
    assert_eq!(
        set(&text, &[("nu", "0.3")]).unwrap(),
        text.replace("[parameters]\n", "[parameters]\nnu = 0.3\n")
    );
    let none = "include = \"lib.toml\"\n[model]\nend_time = 1\n";
    assert_eq!(set(none, &[("nu", "0.3")]).unwrap(), format!("{none}\n[parameters]\nnu = 0.3\n"));
    let error = set(&text, &[("material.ice.density", "1")]).unwrap_err();
    assert!(error.contains("it is in an included file: use a parameter there"), "{error}");
    assert_eq!(set(&text, &[("contact.penalty", "4")]).unwrap(), format!("{text}\n[contact]\npenalty = 4\n"));
}

#[test]
fn names_that_a_model_does_not_have_are_told() {
    for (name, parts) in [
        ("e", &["no parameter \"e\"", "did you mean \"E\"?"][..]),
        ("xyz", &["no parameter \"xyz\"", "there is E"]),
        ("mode.end_time", &["there is no table \"mode\"", "did you mean \"model\"?"]),
        ("material.rok.density", &["no [[material]] has that name", "did you mean \"rock\"?"]),
        ("material.rock", &["no [[material]] has that name and a key"]),
        ("material.7.density", &["no [[material]] has that name"]),
        ("model.initial.speed", &["\"model.initial.speed\" is not in the model: write it there first"]),
        ("body.a.rectangle", &["\"body.a.rectangle\" is a table of the model: set one of its keys"]),
        ("body.a.rectangle.holes", &["write it there first"]),
        ("parameters.e", &["no parameter \"e\"", "did you mean \"E\"?"]),
    ] {
        let error = set(MODEL, &[(name, "1")]).unwrap_err();
        assert!(parts.iter().all(|part| error.contains(part)), "{name}: {error}");
    }
    // A list was once taken for a word.
    for (name, part) in [
        ("model.gravity", "to a list: set its entries one by one, as in model.gravity.1=0"),
        ("initial.stress", "to a list: write the list into the model, and set its entries"),
    ] {
        let error = set(MODEL, &[(name, "[0, -9]")]).unwrap_err();
        assert!(error.contains(part), "{error}");
    }
    // The checks of the model report text that is not TOML.
    assert_eq!(set("a = \n", &[("b", "1")]).unwrap(), "a = \n");
}

/// A value can be read back from its text.
#[test]
fn a_setting_is_what_is_shown_of_it() {
    for text in
        ["0", "1", "9007199254740993", "-2.5", "1e-300", "8 MPa", "true", "intrinsic", "2*radius", "nan"]
    {
        let setting = Setting::parse(text);
        assert_eq!(Setting::parse(&setting.to_string()), setting, "{text}");
    }
    assert_eq!(Setting::parse("8 MPa").number(), Some(8e6));
    assert_eq!(
        (Setting::parse("2*radius").number(), Setting::parse("nan")),
        (None, Setting::Text("nan".into()))
    );
}
