//! Advice on tests of specimens: the rate of loading, elements in the process zone, and the compliance of
//! joints. The rates and excesses are those of the table in the book.

use fdem_model::{AnyPrepared, Preflight, prepare_any};
use fdem_simulation::Simulation;

use crate::right;

const ROCK: &str = "[[material]]\nname = \"rock\"\ndensity = 2700\nyoungs_modulus = 30e9\npoissons_ratio = 0.3\n\
                    tensile_strength = 1e6\ncohesion = 4e6\nfriction_angle = 45\nfracture_energy_i = 3\n\
                    fracture_energy_ii = 30\n";

/// Two boundaries that move against each other, or apart where the velocity is negative.
fn moved(body: [&str; 2], velocity: f64) -> String {
    let boundary = |name: &str, body: &str, velocity: f64| {
        format!(
            "[[boundary]]\nname = \"{name}\"\nbody = \"{body}\"\nside = \"{name}\"\nvelocity = [\"free\", {velocity}]\nramp = 5e-5\n"
        )
    };
    boundary("top", body[0], -velocity) + &boundary("bottom", body[1], velocity)
}

fn block(velocity: f64) -> String {
    let body = "[model]\nplane = \"stress\"\nend_time = 1e-4\n[[body]]\nname = \"block\"\nmaterial = \"rock\"\n\
                rectangle = { min = [-0.025, -0.05], max = [0.025, 0.05] }\nmesh_size = 4e-3\n";
    format!("{body}{ROCK}{}", moved(["block"; 2], velocity))
}

fn brazilian(velocity: f64) -> String {
    let platen = |name: &str, low: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"steel\"\nrectangle = {{ min = [-0.012, {low}], max = [0.012, {}] }}\nmesh_size = 3e-3\n",
            low + 0.006
        )
    };
    let disc = "[model]\nplane = \"stress\"\nend_time = 1e-4\n[[body]]\nname = \"disc\"\nmaterial = \"rock\"\n\
                disc = { centre = [0, 0], radius = 0.025 }\nmesh_size = 2e-3\n";
    let steel =
        "[[material]]\nname = \"steel\"\ndensity = 7800\nyoungs_modulus = 200e9\npoissons_ratio = 0.3\n";
    let (upper, lower) = (platen("upper", 0.025), platen("lower", -0.031));
    format!("{disc}{upper}{lower}{ROCK}{steel}{}", moved(["upper", "lower"], velocity))
}

#[test]
fn loading_is_too_fast_where_tests_become_stronger_by_more_than_a_twentieth() {
    let warned = |text: &str| -> Option<String> {
        right(text).warnings.into_iter().find(|warning| warning.contains("by inertia"))
    };
    // Measured: 2 % at 0.02 m/s, 10 % at 0.05 m/s, 51 % at 0.2 m/s.
    assert_eq!(warned(&brazilian(0.02)), None);
    let told = warned(&brazilian(0.2)).unwrap();
    assert!(told.contains("about 49 % above") && told.contains("take at most 0.03 m/s"), "{told}");
    assert!(warned(&brazilian(0.05)).is_some());
    // Measured in compression: 2 % at 0.1 m/s, 7 % at 0.2 m/s.
    assert_eq!(warned(&block(0.1)), None);
    let told = warned(&block(0.2)).unwrap();
    assert!(told.contains("about 7 % above") && told.contains("take at most 0.16 m/s"), "{told}");
    // Measured in tension: 1 % at 0.05 m/s, 10 % at 0.2 m/s.
    assert_eq!(warned(&block(-0.05)), None);
    assert!(warned(&block(-0.2)).unwrap().contains("about 10 % above"));
}

#[test]
fn elements_resolve_the_zone_of_shear_where_something_presses() {
    let told = |text: &str| right(text).warnings.join("\n");
    let shear = "a third of its fracture process zone in shear (E' G_II/c² = 0.0056";
    // 30e9 x 3/16e12 = 5.6 mm, a third is 1.9 mm; in tension the zone has 90 mm.
    let brittle =
        |velocity: f64| block(velocity).replace("fracture_energy_ii = 30\n", "fracture_energy_ii = 3\n");
    let pressed = told(&brittle(0.05));
    assert!(pressed.contains(shear) && pressed.contains("take elements of 0.001875 m"), "{pressed}");
    assert!(!told(&brittle(-0.05)).contains("process zone"));
    assert!(!told(&block(0.05)).contains("process zone"));
    // A core of granite, in space: E' G_II/c² = 64e9 x 225/(35e6)² = 11.8 mm.
    let core = "[model]\nend_time = 1e-4\n[[body]]\nname = \"core\"\nmaterial = \"granite\"\n\
                cylinder = { from = [0, 0, 0], to = [0, 0, 0.1], radius = 0.025 }\nmesh_size = 7e-3\n\
                [[material]]\nname = \"granite\"\nlibrary = \"granite\"\n\
                [[boundary]]\nname = \"top\"\nside = \"top\"\nvelocity = [\"free\", \"free\", -0.25]\nramp = 2e-4\n\
                [[boundary]]\nname = \"bottom\"\nside = \"bottom\"\nvelocity = [\"free\", \"free\", 0.25]\nramp = 2e-4\n";
    let AnyPrepared::Space(core) =
        prepare_any(core, "core.toml", &mut |name| Err(name.to_owned()), None).unwrap()
    else {
        panic!("a cylinder is in space");
    };
    let told = core.warnings.join("\n");
    assert!(told.contains("process zone in shear (E' G_II/c² = 0.01175"), "{told}");
    assert!(
        told.contains("strength in compression will depend on the mesh; take elements of 0.0039"),
        "{told}"
    );
}

#[test]
fn a_field_gets_advice_that_can_be_followed() {
    let field = block(-0.001)
        .replace("min = [-0.025, -0.05], max = [0.025, 0.05]", "min = [0, 0], max = [40, 40]")
        .replace("mesh_size = 4e-3", "mesh_size = 1");
    let told = right(&field).warnings.join("\n");
    // The zone has 90 mm, and elements of 30 mm would be 33 times as small.
    assert!(told.contains("E' G/f² = 0.09 m") && !told.contains("; take elements of"), "{told}");
    let after = told.split("multiply fracture_energy_i by ").nth(1).unwrap();
    let factor: f64 = after.split(' ').next().unwrap().parse().unwrap();
    assert!((25.0..45.0).contains(&factor), "{told}");
    assert!(told.contains("read the strength of the run as an upper bound"), "{told}");
    // The advice, followed: no warning.
    let scaled = field.replace("fracture_energy_i = 3\n", &format!("fracture_energy_i = {}\n", 3.0 * factor));
    assert!(!right(&scaled).warnings.join("\n").contains("process zone"));
}

/// A block with joints on all edges is stretched slowly, and its modulus is compared with the message of the
/// check: 3 % less at a penalty of 50, 13 % at 10.
#[test]
fn joints_make_a_body_softer_as_the_check_says() {
    for (penalty, said) in [(50.0, "softer by 2.9 %"), (10.0, "softer by 13.0 %")] {
        let text = block(-1e-3)
            .replace(
                "[[body]]",
                &format!("[fracture]\ninsertion = \"intrinsic\"\njoint_penalty = {penalty}\n[[body]]"),
            )
            .replace("poissons_ratio = 0.3\n", "poissons_ratio = 0.3\ndamping = 0.1\n")
            .replace("mesh_size = 4e-3", "mesh_size = 2.5e-3");
        let prepared = right(&text);
        let check = Preflight::of(&prepared).unwrap();
        assert!(check.to_string().contains(said), "{check}");
        let mut run = Simulation::new(prepared.model, 1).unwrap();
        while run.time() < 1.6e-4 {
            run.advance(100).unwrap();
        }
        // The mean over some periods of the waves that are left.
        let (mut stress, mut strain) = (0.0, 0.0);
        let snapshot = |run: &Simulation| run.snapshot();
        let shape = snapshot(&run);
        let at = |y: f64| {
            let near =
                |node: &usize| ((shape.positions[*node][1] - shape.displacements[*node][1]) - y).abs() < 1e-9;
            (0..shape.positions.len()).find(near).unwrap()
        };
        let ends = [at(-0.05), at(0.05)];
        while run.time() < 4e-4 {
            run.advance(20).unwrap();
            let moved = ends.map(|node| snapshot(&run).displacements[node][1]);
            strain += (moved[1] - moved[0]) / 0.1;
            stress += (run.force(0).unwrap()[1] - run.force(1).unwrap()[1]) / 2.0 / 0.05;
        }
        let modulus: f64 = stress / strain;
        let lost = 1.0 - modulus / 30e9;
        let expected = check.softer_by_joints.unwrap();
        assert!((lost / expected - 1.0).abs() < 0.15, "penalty {penalty}: {lost} instead of {expected}");
    }
}
