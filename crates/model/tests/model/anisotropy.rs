//! Bedding of materials: its constants and directions, and refusals.

use fdem_model::{AnyPrepared, prepare_any};
use fdem_simulation::{Bedding, MaterialLaw};

use crate::{SMALL, read, right};

const STRONG: &str = "tensile_strength = 9e6\ncohesion = 25e6\nfriction_angle = 35\nfracture_energy_i = 500\n\
                      fracture_energy_ii = 2500\n";
const ELASTIC: &str = "youngs_modulus = 18e9, poissons_ratio = 0.15, shear_modulus = 7e9";

/// The small model with these keys of its material and of the bedding.
fn with(material: &str, bedding: &str) -> String {
    SMALL.replacen("density", &format!("anisotropy = {{ {bedding} }}\n{material}density"), 1)
}

fn bedding(law: &MaterialLaw) -> Bedding {
    let MaterialLaw::TransverselyIsotropic(bedding) = law else { panic!("{law:?}") };
    *bedding
}

#[test]
fn bedding_has_the_constants_and_the_direction_of_the_file() {
    let model = right(&with("", &format!("{ELASTIC}, dip = 30"))).model;
    let Bedding { normal, youngs_modulus, poissons_ratio, shear_modulus, strength } =
        bedding(&model.materials[0].law);
    assert_eq!([youngs_modulus, poissons_ratio, shear_modulus], [18e9, 0.15, 7e9]);
    assert!((normal[0] + 0.5).abs() < 1e-12 && (normal[1] - 0.75_f64.sqrt()).abs() < 1e-12, "{normal:?}");
    assert_eq!((normal[2], strength), (0.0, None));
    let strong = "tensile_strength = 3e6, cohesion = 8e6, fracture_energy_i = 200";
    let model = right(&with(STRONG, &format!("{ELASTIC}, dip = 30, {strong}"))).model;
    let strength = bedding(&model.materials[0].law).strength.unwrap();
    let found = [strength.tensile, strength.cohesion, strength.energy_i, strength.energy_ii];
    assert_eq!(found, [3e6, 8e6, 200.0, 2500.0]);
}

/// Elements have to resolve the crack whose process zone is the shortest.
#[test]
fn advice_on_elements_is_for_the_shortest_process_zone() {
    let weak = ", tensile_strength = 3e6, cohesion = 8e6, fracture_energy_i = 10";
    for (strength, zone) in [("", "0.111111"), (weak, "0.02")] {
        let warnings = right(&with(STRONG, &format!("{ELASTIC}, dip = 30{strength}"))).warnings;
        let part = format!("fracture process zone (E' G/f² = {zone} m");
        assert!(warnings.iter().any(|warning| warning.contains(&part)), "{part:?} is not in {warnings:?}");
    }
    let brittle = ", tensile_strength = 3e6, cohesion = 1e6";
    let warnings = right(&with(STRONG, &format!("{ELASTIC}, dip = 30{brittle}"))).warnings;
    let part = "cannot carry its tensile strength of 3e6 Pa on its bedding";
    assert!(warnings.iter().any(|warning| warning.contains(part)), "{warnings:?}");
}

#[test]
fn bedding_in_space_dips_in_a_direction() {
    let space = with("", &format!("{ELASTIC}, dip = 30, dip_direction = 90")).replacen(
        "rectangle = { min = [0, 0], max = [1.0, 0.5] }",
        "box = { min = [0, 0, 0], max = [1, 1, 1] }",
        1,
    );
    let mut load = |name: &str| Err(name.to_owned());
    let AnyPrepared::Space(prepared) = prepare_any(&space, "model.toml", &mut load, None).unwrap() else {
        panic!("the model is in space")
    };
    let normal = bedding(&prepared.model.materials[0].law).normal;
    // It falls towards x, so its normal leans that way.
    for (found, expected) in normal.into_iter().zip([0.5, 0.0, 0.75_f64.sqrt()]) {
        assert!((found - expected).abs() < 1e-12, "{normal:?}");
    }
}

#[test]
fn constants_without_a_positive_energy_are_refused_with_the_condition() {
    let text = with("", &format!("{}, dip = 0", ELASTIC.replace("0.15", "0.9")));
    let errors = read(&text).unwrap_err().to_string();
    for part in
        ["negative energy: 1 - ν - 2 ν'² E/E'", "above 0", "poissons_ratio across the bedding is below"]
    {
        assert!(errors.contains(part), "{errors}");
    }
}

#[test]
fn wrong_keys_of_the_bedding_are_named() {
    for (material, keys, part) in [
        ("", "dip = 30, dip_direction = 20", "in two dimensions the bedding has a dip and no direction"),
        ("", "dip = 30, cohesion = 1e6", "the bedding has a strength, and the material has none"),
        (STRONG, "dip = 30, cohesion = 1e6", "the strength of the bedding lacks tensile_strength"),
        (STRONG, "dip = 30, fracture_energy_i = 5", "the strength of the bedding lacks tensile_strength"),
        ("", "dip = 95", "\"dip\""),
        ("", "angle = 3, dip = 2", "has no key \"angle\""),
        ("", "dip_direction = 3", "lacks the key \"dip\""),
    ] {
        let errors = read(&with(material, &format!("{ELASTIC}, {keys}"))).unwrap_err().to_string();
        assert!(errors.contains(part), "{part:?} is not in\n{errors}");
    }
}
