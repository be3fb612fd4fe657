//! Tests of the table of fields.

use std::collections::BTreeSet;

use fdem_simulation::{Bedding, Element, Forces, MaterialLaw, Snapshot, Strength};

use crate::fields::colours::NO_VALUE;
use crate::fields::field::SPHERE_SCALES;
use crate::fields::state::{Instant, State};
use crate::fields::table::SHOWN;
use crate::fields::{Field, LiquidIn, Place, QUANTITIES, QuantityValues, Range, Span};
use crate::run::frame::Frame;

/// A snapshot of a triangle, with this stress.
pub(super) fn triangle(stress: [f64; 6]) -> Snapshot {
    Snapshot {
        positions: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        displacements: vec![[0.0; 2]; 3],
        velocities: vec![[3.0, 0.0], [0.0, 6.0], [0.0, 6.0]],
        elements: vec![[0, 1, 2]],
        stresses: vec![stress],
        damage: vec![0.25],
        bodies: vec![0],
        materials: vec![0],
        fragments: vec![0],
        ..Snapshot::default()
    }
}

#[test]
fn every_row_says_all_that_its_readers_need() {
    let mut keys = BTreeSet::new();
    for row in QUANTITIES {
        assert!(!row.name.is_empty() && !row.about.is_empty(), "{}", row.key);
        assert!(!row.about.ends_with('.') && row.definition.is_empty() | row.definition.ends_with('.'));
        // A reader must know the meaning of the sign of a number.
        assert_eq!(
            row.sign.is_empty(),
            matches!(row.span, Span::NotNegative | Span::Between(..)),
            "{}",
            row.key
        );
        let plain = |c: char| c.is_ascii_lowercase() || c == '_';
        assert!(!row.key.is_empty() && row.key.chars().all(plain), "{:?}", row.key);
        for dimensions in (2..=3).filter(|&dimensions| row.exists_in(dimensions)) {
            assert!(keys.insert((row.place.word(), row.key, dimensions)), "{} occurs twice", row.key);
        }
    }
}

#[test]
fn the_fields_that_are_drawn_are_in_menus_and_those_in_menus_are_drawn() {
    let drawn: BTreeSet<&str> = QUANTITIES.iter().filter(|row| row.is_drawn()).map(|row| row.key).collect();
    assert_eq!(BTreeSet::from(SHOWN), drawn);
    assert_eq!(Field::ALL.map(Field::key), SHOWN);
    // A drawn field of bodies is one number of an element or a node, or a vector of nodes.
    let of_spheres = [Place::Sphere, Place::SphereContact];
    for row in QUANTITIES.iter().filter(|row| row.is_drawn() && !of_spheres.contains(&row.place)) {
        let is_number = row.place == Place::Element && row.components.is_empty();
        assert!(is_number || row.place == Place::Node, "{}", row.key);
    }
}

/// Frames have the arrays of these fields of spheres, in this order.
#[test]
fn fields_of_spheres_with_a_scale_are_in_frames() {
    let scales: Vec<Field> = Field::ALL
        .into_iter()
        .filter(|field| field.of_spheres().is_some() && field.is_continuous())
        .collect();
    assert_eq!(BTreeSet::from(SPHERE_SCALES), scales.into_iter().collect());
    for field in SPHERE_SCALES {
        let row = field.of_spheres().unwrap();
        assert_eq!(row.unit, field.unit(), "{}", field.key());
    }
    assert_eq!(Field::VON_MISES.among([0, 3]), Field::VELOCITY);
    assert_eq!(Field::VON_MISES.among([1, 3]), Field::VON_MISES);
    assert_eq!(Field::GROUP.among([0, 3]), Field::GROUP);
}

#[test]
fn model_files_call_fields_by_their_keys() {
    for field in Field::ALL {
        assert_eq!(serde_json::json!(field), field.key());
        assert_eq!(serde_json::from_value::<Field>(serde_json::json!(field)).unwrap(), field);
    }
    let error = serde_json::from_str::<Field>("\"heat\"").unwrap_err().to_string();
    assert!(
        error.starts_with("unknown variant `heat`, expected one of `max_principal`, `min_principal`"),
        "{error}"
    );
    assert_eq!(Field::named("heat"), None);
}

#[test]
fn a_vector_of_nodes_is_drawn_by_the_magnitude_of_its_mean() {
    let snapshot = triangle([0.0; 6]);
    let state = Instant::of(&snapshot);
    assert_eq!(Field::VELOCITY.values(&state), [17.0_f64.sqrt()]);
    assert_eq!(Field::DAMAGE.values(&state), [0.25]);
}

#[test]
fn values_of_a_program_are_those_of_the_snapshot() {
    let snapshot = triangle([5e6, -3e6, 1e6, 0.0, 0.0, 0.0]);
    let row =
        |place: Place, key: &str| QUANTITIES.iter().find(|row| row.place == place && row.key == key).unwrap();
    let values = |place, key| row(place, key).values_of(&snapshot, &Forces::default()).unwrap();
    assert_eq!(values(Place::Element, "principal_stress"), QuantityValues::Real(vec![5e6, -3e6]));
    assert_eq!(values(Place::Element, "material"), QuantityValues::Whole(vec![0]));
    assert_eq!(values(Place::Node, "reaction"), QuantityValues::Real(vec![0.0; 9]));
    assert_eq!(values(Place::Joint, "mode"), QuantityValues::Whole(Vec::new()));
    let mut short = snapshot.clone();
    short.damage.clear();
    let error = row(Place::Element, "damage").values_of(&short, &Forces::default()).unwrap_err();
    assert_eq!(error.to_string(), "the snapshot has 0 values of damage, where 1 are needed");
}

/// Tensile strength 4e6 Pa, cohesion 10e6 Pa, and a friction angle with the tangent 3/4: √(1 + tan²φ) is 5/4,
/// and the strength in compression is 40e6 Pa.
const ROCK: Strength = Strength {
    tensile: 4e6,
    cohesion: 10e6,
    friction: 0.75,
    energy_i: 1.0,
    energy_ii: 1.0,
    weibull_modulus: None,
    seed: 0,
};

/// Largest shear stress and distance to failure of the first element.
fn found<const D: usize, const N: usize>(snapshot: &Snapshot<D, N>) -> [f64; 2]
where
    [[f64; D]; N]: Element<D, N>,
{
    let state = Instant::of(snapshot);
    ["max_shear", "distance_to_failure"].map(|key| Field::named(key).unwrap().values(&state)[0])
}

#[test]
fn shear_and_distance_to_failure_of_the_plane_are_those_in_the_plane() {
    for (stress, expected) in [
        // Nothing, and uniaxial compression at half of the strength.
        ([0.0; 6], [0.0, 1.0]),
        ([0.0, -20e6, 0.0, 0.0, 0.0, 0.0], [10e6, 0.5]),
        // Tension beyond the cut-off.
        ([6e6, 0.0, 0.0, 0.0, 0.0, 0.0], [3e6, -0.5]),
        // Pure shear: σ₁ is 2 MPa, half of the tensile strength.
        ([0.0, 0.0, 0.0, 2e6, 0.0, 0.0], [2e6, 0.5]),
        // Plane strain: the stress out of the plane is the largest of all, and does not count.
        ([-6e6, -34e6, 30e6, 0.0, 0.0, 0.0], [14e6, 0.75]),
        // Equal pressure never fails.
        ([-50e6, -50e6, -20e6, 0.0, 0.0, 0.0], [0.0, 1.0]),
    ] {
        let snapshot = Snapshot { strengths: vec![Some(ROCK)], ..triangle(stress) };
        assert_eq!(found(&snapshot), expected, "{stress:?}");
    }
}

#[test]
fn shear_and_distance_to_failure_in_space_are_those_of_the_largest_circle() {
    for (stress, expected) in [
        ([0.0, -8e6, -20e6, 0.0, 0.0, 0.0], [10e6, 0.5]),
        ([-6e6, -34e6, -20e6, 0.0, 0.0, 0.0], [14e6, 0.75]),
        ([0.0, 0.0, 0.0, 0.0, 2e6, 0.0], [2e6, 0.5]),
    ] {
        let snapshot = Snapshot::<3, 4> {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            displacements: vec![[0.0; 3]; 4],
            velocities: vec![[0.0; 3]; 4],
            elements: vec![[0, 1, 2, 3]],
            stresses: vec![stress],
            damage: vec![0.0],
            bodies: vec![0],
            materials: vec![0],
            fragments: vec![0],
            strengths: vec![Some(ROCK)],
            ..Snapshot::default()
        };
        for (found, expected) in found(&snapshot).into_iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{stress:?}: {found}");
        }
    }
}

/// Tension across the bedding meets its strength, along it that of the material; both turn with an element.
#[test]
fn distance_to_failure_in_bedded_rock_is_that_of_the_weakest_plane() {
    let weak = Strength { tensile: 1e6, cohesion: 2.5e6, ..ROCK };
    let bedding = Bedding {
        normal: [0.0, 2.0, 0.0],
        youngs_modulus: 1e9,
        poissons_ratio: 0.2,
        shear_modulus: 1e9,
        strength: Some(weak),
    };
    let laws = vec![MaterialLaw::TransverselyIsotropic(bedding)];
    let bedded = |stress| Snapshot { strengths: vec![Some(ROCK)], laws: laws.clone(), ..triangle(stress) };
    let near = |snapshot: &Snapshot, expected: f64| {
        let [_, distance] = found(snapshot);
        assert!((distance - expected).abs() < 1e-6, "{distance} {expected}");
    };
    near(&bedded([0.0, 0.5e6, 0.0, 0.0, 0.0, 0.0]), 0.5);
    near(&bedded([0.0, 1.5e6, 0.0, 0.0, 0.0, 0.0]), -0.5);
    // Along the bedding: the plane across it carries four times as much, and no other plane less.
    let along = bedded([0.5e6, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert!((0.5..0.875).contains(&found(&along)[1]), "{:?}", found(&along));
    // Turned by a right angle, the bedding is across x.
    let mut turned = along;
    for (position, displacement) in turned.positions.iter_mut().zip(&mut turned.displacements) {
        let before: [f64; 2] = std::array::from_fn(|axis| position[axis] - displacement[axis]);
        *position = [-before[1], before[0]];
        *displacement = std::array::from_fn(|axis| position[axis] - before[axis]);
    }
    near(&turned, 0.5);
}

#[test]
fn without_a_strength_there_is_no_distance_to_failure() {
    let field = Field::named("distance_to_failure").unwrap();
    let stress = [0.0, -20e6, 0.0, 0.0, 0.0, 0.0];
    for strengths in [vec![None], Vec::new()] {
        let [shear, distance] = found(&Snapshot { strengths, ..triangle(stress) });
        assert!(shear == 10e6 && distance.is_nan());
    }
    // A frame keeps both, and the colours are the same in all runs.
    let with = Snapshot { strengths: vec![Some(ROCK)], ..triangle(stress) };
    let frames = [with, triangle(stress)].map(|snapshot| Frame::new(&snapshot).unwrap());
    let range = Range::of(&frames, field);
    assert_eq!(range, Range { low: 0.0, high: 1.0 });
    let values = frames.map(|frame| frame.open().unwrap().values[field.scale().unwrap()][0]);
    assert_eq!(values[0], 0.5);
    assert_eq!(field.colour(values[1], range), NO_VALUE);
    // The nearer to failure, the darker.
    let light =
        |value: f64| field.colour(value, range).iter().map(|&channel| u32::from(channel)).sum::<u32>();
    assert!(light(-2.0) == light(0.0) && light(0.0) < light(0.5) && light(0.5) < light(1.0));
}

/// Pictures show the mean over the nodes of an element, with its sign, and no value where a node has none.
#[test]
fn pressures_in_pores_are_those_of_nodes_with_pores() {
    let row = QUANTITIES.iter().find(|row| row.key == "pore_pressure").unwrap();
    let with = |pressures: Option<Vec<Option<f64>>>| Snapshot {
        positions: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
        displacements: vec![[0.0; 2]; 4],
        velocities: vec![[0.0; 2]; 4],
        elements: vec![[0, 1, 2], [1, 3, 2]],
        stresses: vec![[0.0; 6]; 2],
        damage: vec![0.0; 2],
        bodies: vec![0; 2],
        materials: vec![0; 2],
        fragments: vec![0; 2],
        pore_pressures: pressures,
        ..Snapshot::default()
    };
    let snapshot = with(Some(vec![Some(3e6), Some(-1e6), Some(-5e6), None]));
    let QuantityValues::Real(values) = row.values_of(&snapshot, &Forces::default()).unwrap() else {
        panic!("numbers")
    };
    assert_eq!(values[..3], [3e6, -1e6, -5e6]);
    assert!(values[3].is_nan());
    let field = Field::named("pore_pressure").unwrap();
    let [both, none] = field.values(&Instant::of(&snapshot))[..] else { panic!("two elements") };
    assert!(both == -1e6 && none.is_nan());
    let frame = Frame::new(&snapshot).unwrap();
    assert_eq!(Range::of([&frame], field), Range { low: -1e6, high: 1e6 });
    assert_eq!(field.colour(none, Range::of([&frame], field)), NO_VALUE);
    assert_eq!(
        field.description(),
        "The pressure of the liquid in pores; not a number where there are none, compression positive, Pa."
    );
    let short = with(Some(vec![Some(0.0); 3]));
    let error = row.values_of(&short, &Forces::default()).unwrap_err().to_string();
    assert_eq!(error, "the snapshot has 3 pressures in pores, where 4 are needed");
    // Files of a model without pores do not have it.
    let state = Instant::of(&short);
    assert!(state.has_liquid(LiquidIn::Pores) && !Instant::of(&with(None)).has_liquid(LiquidIn::Pores));
}
