//! Spheres that come in during a run and boxes that remove them; clumps.

use std::f64::consts::{FRAC_PI_2, PI};

use fdem_model::{AnyPrepared, Preflight, Prepared, prepare_any};
use fdem_simulation::grains::{ClumpInertia, GrainModel};

/// A model without spheres at the beginning that is right.
const RAIN: &str = r#"[model]
end_time = 0.1
gravity = [0, 0, -9.81]

[[insertion]]
name = "rain"
material = "glass"
count = 200
rate = 1000
from = "10 ms"
radius = [0.01, 0.02]
within = { min = [0, 0, 0.5], max = [0.4, 0.4, "60 cm"] }
velocity = [0, 0, -1]
spin = [0, 0, 180]
seed = 4

[[delete]]
name = "hole"
within = { min = [0, 0, 0], max = [0.1, 0.1, 0.1] }
from = 0.02
until = "30 ms"

[[wall]]
name = "floor"
material = "glass"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }

[[material]]
name = "glass"
density = 2500
youngs_modulus = 60e9
poissons_ratio = 0.2
restitution = 0.9
"#;

/// The same with discs.
const FLAT_RAIN: &str = r#"[model]
end_time = 0.1
thickness = 0.5

[[insertion]]
name = "rain"
material = "glass"
mass = 400
radius = 0.02
within = { min = [0, 0], max = [1, 1] }
spin = 90

[[delete]]
name = "hole"
within = { min = [0, 0], max = [0.1, 0.1] }

[[material]]
name = "glass"
density = 2500
youngs_modulus = 60e9
poissons_ratio = 0.2
restitution = 0.9
"#;

/// Clumps of two spheres.
const PAIRS: &str = r#"[model]
end_time = 1e-3

[[grains]]
name = "pairs"
material = "glass"
count = 40
clump = [{ at = [0, 0, 0], radius = 0.01 }, { at = [0.012, 0, 0], radius = "8 mm" }]
within = { min = [0, 0, 0], max = [0.3, 0.3, 0.3] }
velocity = [1, 0, 0]
spin = [0, 0, 180]

[[material]]
name = "glass"
density = 2500
youngs_modulus = 60e9
poissons_ratio = 0.2
restitution = 0.9
"#;

fn any(text: &str) -> Result<AnyPrepared, String> {
    let mut load = |_: &str| Err("there is none".to_owned());
    prepare_any(text, "m.toml", &mut load, None).map_err(|errors| errors.to_string())
}

#[track_caller]
fn space(text: &str) -> Prepared<3, 4> {
    match any(text) {
        Ok(AnyPrepared::Space(prepared)) => *prepared,
        Ok(AnyPrepared::Plane(_)) => panic!("it is flat"),
        Err(errors) => panic!("{errors}"),
    }
}

#[track_caller]
fn grains(text: &str) -> GrainModel {
    match any(text) {
        Ok(AnyPrepared::Space(prepared)) => prepared.model.grains.unwrap(),
        Ok(AnyPrepared::Plane(prepared)) => prepared.model.grains.unwrap(),
        Err(errors) => panic!("{errors}"),
    }
}

/// Checks that the model is refused at the line of `at`, with these words.
#[track_caller]
fn refused(text: &str, at: &str, words: &[&str]) {
    let line = text.lines().position(|line| line.starts_with(at)).expect("the line is there") + 1;
    let errors = any(text).expect_err("there is a mistake");
    let is_right = |error: &&str| {
        error.starts_with(&format!("m.toml:{line}: ")) && words.iter().all(|words| error.contains(words))
    };
    assert!(errors.lines().any(|error| is_right(&error)), "{at} at line {line}: {words:?} in\n{errors}");
}

fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn spheres_to_come_are_a_model() {
    let prepared = space(RAIN);
    assert_eq!(prepared.warnings, Vec::<String>::new());
    let model = prepared.model.grains.as_ref().unwrap();
    assert!(model.spheres.positions.is_empty());
    let of = &model.insertions[0];
    assert_eq!((of.name.as_str(), of.radii.len(), of.from, of.rate), ("rain", 200, 0.01, 1000.0));
    assert_eq!(of.region, [[0.0, 0.0, 0.5], [0.4, 0.4, 0.6]]);
    assert!(of.radii.iter().all(|radius| (0.01..=0.02).contains(radius)));
    assert_eq!((of.velocity, of.spin, of.seed), ([0.0, 0.0, -1.0], [0.0, 0.0, PI], 4));
    assert_eq!((of.material, of.group, model.groups.as_slice()), (0, 0, &["rain".to_owned()][..]));
    let hole = &model.removals[0];
    assert_eq!((hole.name.as_str(), hole.times), ("hole", [0.02, 0.03]));
    assert_eq!(hole.region, [[0.0; 3], [0.1; 3]]);
    let coming = &prepared.spheres.as_ref().unwrap().insertions[0];
    assert_eq!((coming.count, coming.by_end, coming.rate), (200, 91, Some(1000.0)));
    let mass: f64 = of.radii.iter().map(|radius| 2500.0 * 4.0 / 3.0 * PI * radius.powi(3)).sum();
    assert!((coming.mass / mass - 1.0).abs() < 1e-12);
}

#[test]
fn a_check_counts_the_spheres_to_come() {
    let prepared = space(RAIN);
    let flight = Preflight::of(&prepared).unwrap();
    assert_eq!((flight.spheres, flight.spheres_to_come), (0, 91));
    let words = flight.to_string();
    for line in [
        "grains           0 spheres, 91 to come, 1 wall",
        "rain: 200 to come from 0.01 s, 1000 a second, 91 by end_time, radii 0.01",
        "hole: removes spheres from 0.02 s until 0.03 s",
        "a sphere of rain, to come",
    ] {
        assert!(words.contains(line), "{line} in\n{words}");
    }
    let more = Preflight::of(&space(&changed(RAIN, "count = 200", "count = 200000"))).unwrap();
    assert!(more.memory > flight.memory + 1e8, "{} {}", more.memory, flight.memory);
    let all = space(&changed(&changed(RAIN, "rate = 1000\n", ""), "until = \"30 ms\"", ""));
    let words = Preflight::of(&all).unwrap().to_string();
    assert!(words.contains("rain: 200 to come from 0.01 s, all at once, radii"), "{words}");
    assert!(words.lines().any(|line| line.trim() == "hole: removes spheres from 0.02 s"), "{words}");
}

#[test]
fn discs_come_by_their_mass() {
    let model = grains(FLAT_RAIN);
    let of = &model.insertions[0];
    // 400 kg of discs of 0.5 m · 2500 kg/m³ · π 0.02² m².
    assert_eq!((of.radii.len(), of.rate), (255, f64::INFINITY));
    assert_eq!((of.spin, of.region[1], model.discs), ([0.0, 0.0, FRAC_PI_2], [1.0, 1.0, 0.0], Some(0.5)));
    assert_eq!(model.removals[0].times, [0.0, f64::INFINITY]);
    let at_rate = grains(&changed(FLAT_RAIN, "mass = 400", "mass = 400\nmass_rate = \"40 kg/s\""));
    let of_one = 2500.0 * 0.5 * PI * 0.02 * 0.02;
    assert!((at_rate.insertions[0].rate * of_one / 40.0 - 1.0).abs() < 1e-12);
}

#[test]
fn groups_of_spheres_to_come_follow_those_of_the_others() {
    let more = "[[grains]]\nname = \"bed\"\nmaterial = \"glass\"\nat = [[0.2, 0.2, 0.02]]\nradius = 0.02\n\n";
    let model = grains(&changed(RAIN, "[[wall]]", &format!("{more}[[wall]]")));
    assert_eq!(
        (model.groups.as_slice(), model.insertions[0].group),
        (&["bed", "rain"].map(String::from)[..], 1)
    );
    let own = space(&changed(RAIN, "[[wall]]", "[[history]]\nname = \"h\"\ngrains = true\n\n[[wall]]"));
    assert_eq!(own.probes.len(), 1);
}

#[test]
fn mistakes_in_insertions_have_their_lines() {
    let box_ = "within = { min = [0, 0, 0.5], max = [0.4, 0.4, \"60 cm\"] }";
    for (from, to, at, words) in [
        (
            "count = 200\n",
            "",
            "name = \"rain\"",
            &["[[insertion]] \"rain\" has no spheres", "count, mass"][..],
        ),
        ("count = 200", "count = 200\nmass = 1", "mass", &["has both count and mass"]),
        ("rate = 1000", "rate = 1000\nmass_rate = 1", "mass_rate", &["has both rate and mass_rate"]),
        ("rate = 1000", "rate = 0", "rate", &["above 0"]),
        ("rate = 1000", "rate = \"3 m\"", "rate", &["m"]),
        ("from = \"10 ms\"", "from = -1", "from", &["at least 0"]),
        ("count = 200", "cuont = 200", "cuont", &["did you mean \"count\"?"]),
        ("count = 200", "count = 200\nstage = \"a\"", "stage", &["write from = …"]),
        ("material = \"glass\"", "material = \"glas\"", "material", &["did you mean \"glass\"?"]),
        ("radius = [0.01, 0.02]\n", "", "[[insertion]]", &["lacks the key \"radius\""]),
        ("radius = [0.01, 0.02]", "radius = [0.02, 0.01]", "radius", &["the least radius is above 0"]),
        ("radius = [0.01, 0.02]", "radius = [[0.01, 0], [0.02, 0.5]]", "radius", &["the last share"]),
        ("radius = [0.01, 0.02]", "radius = 0.06", "radius", &["radius 0.06 m has no room in its region"]),
        (box_, "", "[[insertion]]", &["lacks the key \"within\""]),
        (box_, "within = { ball = { centre = [0, 0, 0], radius = 1 } }", "within", &["this region is a box"]),
        (box_, "within = { surface = \"a.stl\" }", "within", &["this region is a box"]),
        (box_, "within = { min = [0, 0, 0.5] }", "within", &["lacks the key \"max\""]),
        (
            box_,
            "within = { min = [0, 0, 0], max = [0.4, 0.4] }",
            "within",
            &["has 2 numbers", "3 dimensions"],
        ),
        ("\"60 cm\"] }", "0.4] }", "within", &["each component of max"]),
        ("velocity = [0, 0, -1]", "velocity = [0, -1]", "velocity", &["has 2 numbers"]),
        ("spin = [0, 0, 180]", "spin = 5", "spin", &["\"spin\" of spheres in 3 dimensions"]),
        (
            box_,
            "within = { min = [0, 0, -1], max = [1, 1, -0.5] }",
            "within",
            &["find no place beside [[wall]] \"floor\""],
        ),
        (
            "[[wall]]",
            "[domain]\nbox = [0, 0, 0, 0.3, 0.4, 1]\n\n[[wall]]",
            "within",
            &["[[insertion]] \"rain\"", "out of the box of the [domain]"],
        ),
        (
            "[[wall]]",
            "[domain]\nbox = [0, 0, 0, 1, 1, 1]\nperiodic = [\"x\"]\nstrain_rate = [1, 0, 0]\n\n[[wall]]",
            "within",
            &["while the [domain] has a strain_rate"],
        ),
        ("count = 200", "mass = 1e-9", "mass", &["one sphere has more mass than that"]),
        ("count = 200", "mass = 1e9", "mass", &["about 2", "may have 2e7"]),
        ("restitution = 0.9\n", "", "name = \"glass\"", &["spheres of it may touch each other"]),
    ] {
        refused(&changed(RAIN, from, to), at, words);
    }
    let again = &RAIN[RAIN.find("[[insertion]]").unwrap()..RAIN.find("[[delete]]").unwrap()];
    let twice = any(&format!("{RAIN}\n{again}")).unwrap_err();
    assert!(twice.contains("there is a [[insertion]] \"rain\" already"), "{twice}");
    let body = "[[body]]\nname = \"block\"\nmaterial = \"glass\"\nmesh_size = 0.2\n\
                box = { min = [0.1, 0.1, 0.4], max = [0.3, 0.3, 0.7] }\n";
    refused(&format!("{RAIN}{body}"), "within", &["reaches into the body \"block\""]);
    let late = space(&changed(RAIN, "from = \"10 ms\"", "from = 2"));
    assert!(
        late.warnings.join("\n").contains("[[insertion]] \"rain\" brings no sphere"),
        "{:?}",
        late.warnings
    );
}

#[test]
fn mistakes_in_boxes_that_delete_have_their_lines() {
    let box_ = "within = { min = [0, 0, 0], max = [0.1, 0.1, 0.1] }";
    for (from, to, at, words) in [
        (
            "until = \"30 ms\"",
            "until = 0.01",
            "until",
            &["[[delete]] \"hole\" ends at 0.01 s", "removes nothing"][..],
        ),
        ("from = 0.02\n", "fron = 0.02\n", "fron", &["did you mean \"from\"?"]),
        ("from = 0.02\n", "stages = []\n", "stages", &["write from = … and until = …"]),
        (
            box_,
            "within = { min = [0, 0, 0], max = [0.1, 0.1, 0] }",
            "within = { min = [0, 0, 0]",
            &["each component of max"],
        ),
        (
            box_,
            "within = { disc = { centre = [0, 0], radius = 1 } }",
            "within = { disc",
            &["this region is a box"],
        ),
        (
            box_,
            "within = { min = [0, 0], max = [0.1, 0.1] }",
            "within = { min = [0, 0], ",
            &["has 2 numbers"],
        ),
    ] {
        refused(&changed(RAIN, from, to), at, words);
    }
    let again = "[[delete]]\nname = \"hole\"\nwithin = { min = [0, 0, 0], max = [1, 1, 1] }\n";
    assert!(any(&format!("{RAIN}\n{again}")).unwrap_err().contains("there is a [[delete]] \"hole\" already"));
    let late = space(&changed(&changed(RAIN, "from = 0.02", "from = 2"), "until = \"30 ms\"", ""));
    assert!(late.warnings.join("\n").contains("[[delete]] \"hole\" removes nothing"), "{:?}", late.warnings);
    let alone =
        format!("{}[[delete]]\nname = \"a\"\nwithin = {{ min = [0, 0], max = [1, 1] }}\n", super::SMALL);
    refused(&alone, "[[delete]]", &["there are no [[grains]]"]);
}

#[test]
fn clumps_are_packed_without_overlaps() {
    let prepared = space(PAIRS);
    assert_eq!(prepared.warnings, Vec::<String>::new());
    let group = &prepared.spheres.as_ref().unwrap().groups[0];
    assert_eq!((group.count, group.clumps), (80, 40));
    let model = prepared.model.grains.as_ref().unwrap();
    assert_eq!((model.clumps.len(), model.spheres.positions.len()), (40, 80));
    assert_eq!(model.clumps[7].spheres, [14, 15]);
    assert_eq!((model.clumps[7].velocity, model.clumps[7].spin), ([1.0, 0.0, 0.0], [0.0, 0.0, PI]));
    assert!(model.spheres.velocities.iter().chain(&model.spheres.spins).all(|of| *of == [0.0; 3]));
    let mut turned = 0;
    for clump in &model.clumps {
        let [one, two] = [0, 1].map(|k| model.spheres.positions[clump.spheres[k] as usize]);
        let apart = [0, 1, 2].map(|k| two[k] - one[k]);
        let length = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((length - 0.012).abs() < 1e-15);
        turned += usize::from(apart[0] < 0.0);
        let centres = [one, two];
        let expected = ClumpInertia::of_spheres(&centres, &[0.01, 0.008], 2500.0);
        let found = clump.inertia.unwrap();
        assert!((found.mass / expected.mass - 1.0).abs() < 1e-4);
        let size = expected.moments[0][0] + expected.moments[1][1] + expected.moments[2][2];
        for i in 0..3 {
            assert!((found.centre[i] - expected.centre[i]).abs() < 1e-6);
            for k in 0..3 {
                assert!((found.moments[i][k] - expected.moments[i][k]).abs() < 1e-4 * size);
            }
        }
        let is_in = |k: usize| [one, two][k].iter().all(|x| (0.008..=0.292).contains(x));
        assert!(is_in(0) && is_in(1));
    }
    assert!((8..32).contains(&turned), "{turned}");
    let flight = Preflight::of(&prepared).unwrap().to_string();
    assert!(flight.contains("pairs: 80 in 40 clumps, radii 0.008 to 0.01 m"), "{flight}");
}

#[test]
fn clumps_have_the_radius_of_their_volume() {
    let large = changed(PAIRS, "count = 40", "fraction = 0.2\nradius = 0.02");
    let prepared = space(&large);
    let group = &prepared.spheres.as_ref().unwrap().groups[0];
    let model = prepared.model.grains.as_ref().unwrap();
    // 0.2 · 0.3³ m³ over 4/3 π 0.02³ m³.
    assert_eq!(model.clumps.len(), 161);
    let mass = 2500.0 * 4.0 / 3.0 * PI * 0.02_f64.powi(3);
    assert!((model.clumps[3].inertia.unwrap().mass / mass - 1.0).abs() < 1e-9);
    assert!((group.mass / (161.0 * mass) - 1.0).abs() < 1e-9);
    assert!((group.fraction.unwrap() - 0.2).abs() < 1e-3);
    assert!((model.spheres.radii[0] / model.spheres.radii[1] - 1.25).abs() < 1e-12);
    refused(
        &large.replace("fraction = 0.2", "fraction = 0.5"),
        "fraction",
        &["a solid fraction of 0.5", "cannot be reached", "packed by the spheres around them"],
    );
    refused(
        &large.replace("radius = 0.02\n", "radius = 0.12\n"),
        "radius",
        &["has no room", "the sphere around a clump"],
    );
}

#[test]
fn clumps_stand_at_places() {
    let at = changed(
        PAIRS,
        "count = 40\n",
        "at = [[0, 0, 0], [1, 2, 3]]\norientation = [0, 0, \"0.25 rev\"]\nfixed = true\n",
    );
    let at = changed(&at, "within = { min = [0, 0, 0], max = [0.3, 0.3, 0.3] }", "");
    let model = grains(&at);
    assert_eq!(model.spheres.positions[2], [1.0, 2.0, 3.0]);
    let end = model.spheres.positions[3];
    assert!((end[0] - 1.0).abs() < 1e-15 && (end[1] - 2.012).abs() < 1e-15 && end[2] == 3.0, "{end:?}");
    assert_eq!((model.spheres.radii[3], model.spheres.held[3]), (0.008, true));
    let near = at.replace("[1, 2, 3]", "[0.001, 0, 0]");
    refused(&near, "name = \"pairs\"", &["overlaps sphere"]);
    let flat = "clump = [{ at = [0, 0], radius = 0.01 }, { at = [0.01, 0], radius = 0.01 }]\norientation = 90\n\
                velocity = [0, 1]\nspin = 90\n#";
    let flat = changed(&at, "clump", flat).replace("[[0, 0, 0], [1, 2, 3]]", "[[0, 0], [1, 2]]");
    let flat =
        flat.replace("orientation = [0", "#").replace("\nvelocity = [1", "\n#").replace("\nspin = [0", "\n#");
    let model = grains(&flat);
    assert!((model.spheres.positions[3][1] - 2.01).abs() < 1e-15, "{:?}", model.spheres.positions);
    let expected = ClumpInertia::of_discs(&[[0.0; 3], [0.0, 0.01, 0.0]], &[0.01; 2], 2500.0, 1.0);
    assert!((model.clumps[0].inertia.unwrap().mass / expected.mass - 1.0).abs() < 1e-5);
}

#[test]
fn mistakes_in_clumps_have_their_lines() {
    for (from, to, at, words) in [
        ("count = 40", "count = 40\norientation = \"randon\"", "orientation", &["orientation"][..]),
        (
            "count = 40",
            "count = 40\norientation = 90",
            "orientation",
            &["of clumps in 3 dimensions", "[x, y, z]"],
        ),
        ("clump = [", "orientation = \"random\"\n# [", "orientation", &["goes with clump"]),
        ("clump = [{ at = [0, 0, 0]", "clump = [{ at = [0, 0]", "clump", &["has 2 numbers"]),
        ("radius = 0.01 }", "radius = 0 }", "clump", &["above 0"]),
        ("radius = 0.01 }", "radus = 0.01 }", "clump", &["did you mean \"radius\"?"]),
        ("count = 40", "file = \"a.csv\"", "clump", &["\"clump\" does not go with file"]),
        ("clump = [{", "clump = [] # [{", "clump", &["clump"]),
        (
            "[[material]]",
            "[domain]\nbox = [0, 0, 0, 1, 1, 1]\nperiodic = [\"x\"]\nstrain_rate = [1, 0, 0]\n\n[[material]]",
            "clump",
            &["clumps cannot follow a [domain] with a strain_rate"],
        ),
    ] {
        refused(&changed(PAIRS, from, to), at, words);
    }
    let apart = space(&changed(PAIRS, "[0.012, 0, 0]", "[0.02, 0, 0]"));
    let warnings = apart.warnings.join("\n");
    assert!(
        warnings.contains("[[grains]] \"pairs\": the spheres of its clump do not all touch"),
        "{warnings}"
    );
}
