//! The result of a model file: boundaries, materials, initial state, histories, warnings, preflight.

use std::fmt::Write;

use fdem_model::{
    AnyPrepared, Bound, Checkpoint, Preflight, Prepared, PreparedUntil, Quantity, Rehearsal, Rehearsed,
    prepare_any,
};
use fdem_results::Field;
use fdem_simulation::{Load, Schedule, Simulation, Target};

use crate::{SMALL, read, right};

fn with(more: &str) -> String {
    format!("{SMALL}\n{more}")
}

/// A body spins about its centroid, in degrees per second.
#[test]
fn a_body_begins_with_its_spin() {
    let body = "name = \"a\"\nmaterial = \"m\"\nmesh_size = 1\nrigid = true\n";
    let material = "[[material]]\nname = \"m\"\ndensity = 2700\nyoungs_modulus = 1e9\npoissons_ratio = 0.2\n";
    let model = |shape: &str| format!("[model]\nend_time = 1\n[[body]]\n{body}{shape}\n{material}");
    let plane = "rectangle = { min = [1, 2], max = [3, 3] }\nvelocity = [7, 0]\nspin = \"2 rad/s\"";
    let prepared = right(&model(plane));
    for (node, [u, v]) in prepared.model.mesh.nodes.iter().zip(&prepared.model.velocities) {
        let [x, y] = [node[0] - 2.0, node[1] - 2.5];
        assert!((u - 7.0 + 2.0 * y).abs() < 1e-12 && (v - 2.0 * x).abs() < 1e-12, "{node:?}");
    }
    assert_eq!(prepared.model.rigid, [0]);
    let space = "box = { min = [1, 2, 3], max = [3, 3, 4] }\nspin = [180, 0, 90]";
    let prepared = prepare_any(&model(space), "a.toml", &mut |_| Err("no files".into()), None).unwrap();
    let AnyPrepared::Space(prepared) = prepared else { panic!("a box is in space") };
    let pi = std::f64::consts::PI;
    for (node, velocity) in prepared.model.mesh.nodes.iter().zip(&prepared.model.velocities) {
        let [x, y, z] = [node[0] - 2.0, node[1] - 2.5, node[2] - 3.5];
        let expected = [-0.5 * pi * y, 0.5 * pi * x - pi * z, pi * y];
        assert!((0..3).all(|k| (velocity[k] - expected[k]).abs() < 1e-9), "{node:?} {velocity:?}");
    }
}

/// A rotation is an angular velocity about an axis through a point, in degrees per second or another unit.
#[test]
fn a_boundary_turns_bodies_about_an_axis() {
    let material = "[[material]]\nname = \"m\"\ndensity = 2700\nyoungs_modulus = 1e9\npoissons_ratio = 0.2\n";
    let model = |shape: &str, rotation: &str| {
        format!(
            "[model]\nend_time = 1\n[[body]]\nname = \"a\"\nmaterial = \"m\"\nmesh_size = 1\nrigid = true\n{shape}\n\
             {material}[[boundary]]\nname = \"drive\"\nbody = \"a\"\nrotation = {rotation}\n"
        )
    };
    let plane = "rectangle = { min = [0, 0], max = [2, 1] }";
    let cube = "box = { min = [0, 0, 0], max = [2, 1, 1] }";
    let prepared = right(&model(plane, "{ through = [1, \"50 cm\"], speed = \"-2 rad/s\" }"));
    // Rigid bodies take no more mass, so that there is no advice on it.
    let driven = model(plane, "").replace("rotation = ", "velocity = [1, 0]");
    assert!(Preflight::of(&right(&driven)).unwrap().steps > 0);
    let Load::Rotation { spin, through } = prepared.model.boundaries[0].load else { panic!("a rotation") };
    assert!((spin[2] + 2.0).abs() < 1e-12 && through == [1.0, 0.5], "{spin:?} {through:?}");
    let read_any = |text: &str| prepare_any(text, "a.toml", &mut |_| Err("no files".into()), None);
    let turned = model(cube, "{ through = [0, 0, 1], axis = [0, 3, 4], speed = 180 }");
    let AnyPrepared::Space(prepared) = read_any(&turned).unwrap() else { panic!("a box is in space") };
    let Load::Rotation { spin, .. } = prepared.model.boundaries[0].load else { panic!("a rotation") };
    let expected = [0.0, 0.6, 0.8].map(|x| x * std::f64::consts::PI);
    assert!((0..3).all(|k| (spin[k] - expected[k]).abs() < 1e-12), "{spin:?}");
    for (shape, rotation, message) in [
        (plane, "{ through = [1, 1], axis = [0, 0, 1], speed = 1 }", "a flat body turns about z"),
        (plane, "{ through = [1, 1, 1], speed = 1 }", "rotation.through"),
        (cube, "{ through = [1, 1, 1], speed = 1 }", "has an \"axis\""),
        (cube, "{ through = [1, 1, 1], axis = [0, 0, 0], speed = 1 }", "has no direction"),
        (cube, "{ through = [1, 1, 1], axis = [0, 0, 1] }", "speed"),
    ] {
        let Err(errors) = read_any(&model(shape, rotation)) else { panic!("{rotation} is taken") };
        assert!(errors.to_string().contains(message), "{message}: {errors}");
    }
}

#[test]
fn sides_boxes_and_groups_become_nodes_and_edges_counter_clockwise() {
    let prepared = right(&with(
        r#"
[[boundary]]
name = "ground"
side = "bottom"
fixed = "xy"

[[boundary]]
name = "push"
side = "right"
traction = [-1e6, 0]
ramp = 1e-4

[[boundary]]
name = "around"
group = "outer"
absorbing = true

[[boundary]]
name = "corner"
box = [-0.01, 0.49, 0.01, 0.51]
force = [3, 4]
table = [[0, 0], [1e-3, 2]]

[[boundary]]
name = "roller"
body = "block"
velocity = ["free", 0]
"#,
    ));
    let mesh = &prepared.model.mesh;
    let at = |node: u32| mesh.nodes[node as usize];
    let [ground, push, around, corner, roller] = &prepared.model.boundaries[..] else { panic!() };

    let Target::Nodes(nodes) = &ground.target else { panic!() };
    assert_eq!(nodes.len(), 11);
    assert!(nodes.iter().all(|&node| at(node)[1] == 0.0));
    assert_eq!(
        (ground.load, &ground.schedule),
        (Load::Velocity([Some(0.0), Some(0.0)]), &Schedule::Constant)
    );

    let Target::Facets(edges) = &push.target else { panic!() };
    assert_eq!(edges.len(), 5);
    for &[a, b] in edges {
        assert_eq!([at(a)[0], at(b)[0]], [1.0, 1.0]);
        assert!(
            at(b)[1] > at(a)[1],
            "counter-clockwise, so that the outward normal (dy, -dx) points to the right"
        );
    }
    assert_eq!((push.load, &push.schedule), (Load::Traction([-1e6, 0.0]), &Schedule::Ramp(1e-4)));

    let Target::Facets(edges) = &around.target else { panic!() };
    let length: f64 = edges.iter().map(|&[a, b]| (at(a)[0] - at(b)[0]).hypot(at(a)[1] - at(b)[1])).sum();
    assert!((length - 3.0).abs() < 1e-12);
    let enclosed: f64 = edges.iter().map(|&[a, b]| at(a)[0] * at(b)[1] - at(b)[0] * at(a)[1]).sum();
    assert!((enclosed / 2.0 - 0.5).abs() < 1e-12, "all run the same way round");

    let Target::Nodes(nodes) = &corner.target else { panic!() };
    assert_eq!(nodes.iter().map(|&node| at(node)).collect::<Vec<_>>(), [[0.0, 0.5]]);
    assert_eq!(corner.schedule, Schedule::Table(vec![[0.0, 0.0], [1e-3, 2.0]]));

    let Target::Nodes(nodes) = &roller.target else { panic!() };
    assert_eq!(nodes.len(), mesh.nodes.len(), "a body without a place is all of it");
    assert_eq!(roller.load, Load::Velocity([None, Some(0.0)]));
}

#[test]
fn pressure_in_a_hole_acts_on_the_hole_alone() {
    let text = with("[[boundary]]\nname = \"p\"\ngroup = \"holes\"\npressure = 5\n")
        .replace("max = [1.0, 0.5]", "max = [1.0, 0.5], holes = [{ centre = [0.5, 0.25], radius = 0.1 }]")
        .replace("mesh_size = 0.1", "mesh_size = 0.04");
    let prepared = right(&text);
    let Target::Facets(edges) = &prepared.model.boundaries[0].target else { panic!() };
    assert_eq!(edges.len(), 16);
    for &[a, b] in edges {
        let [a, b] = [a, b].map(|node| prepared.model.mesh.nodes[node as usize]);
        assert!(((a[0] - 0.5).hypot(a[1] - 0.25) - 0.1).abs() < 1e-12);
        let normal = [b[1] - a[1], a[0] - b[0]];
        assert!(
            normal[0] * (a[0] - 0.5) + normal[1] * (a[1] - 0.25) < 0.0,
            "outward of the body is into the hole"
        );
    }
}

#[test]
fn materials_angles_and_interfaces_are_converted() {
    let prepared = right(&with(
        r#"
[[material]]
name = "weak"
optional = true
density = 2000
youngs_modulus = 1e9
poissons_ratio = 0.2
friction = 0.6
tensile_strength = 1e6
cohesion = 3e6
friction_angle = 45
fracture_energy_i = 1000
fracture_energy_ii = 2000
weibull_modulus = 8

[[interface]]
materials = ["weak", "rock"]
penalty = 5e9

[fracture]
insertion = "intrinsic"
critical_opening = "customary"
"#,
    ));
    let strength = prepared.model.materials[1].strength.unwrap();
    assert!((strength.friction - 1.0).abs() < 1e-15, "the tangent of 45 degrees");
    assert_eq!((strength.weibull_modulus, strength.seed), (Some(8.0), 1));
    assert_eq!(prepared.model.materials[0].strength, None);
    let interface = &prepared.model.interfaces[0];
    assert_eq!((interface.materials, interface.friction, interface.penalty), ([0, 1], 0.0, Some(5e9)));
    assert_eq!(prepared.model.fracture.insertion, fdem_simulation::Insertion::Intrinsic);
    assert_eq!(prepared.model.fracture.critical_opening, fdem_simulation::CriticalOpening::Customary);
}

#[test]
fn what_is_left_out_has_its_default() {
    let prepared = right(SMALL);
    let model = &prepared.model;
    assert_eq!((model.gravity, model.thickness), ([0.0, 0.0], 1.0));
    assert_eq!(model.time, fdem_simulation::TimeOptions::default());
    assert_eq!(model.contact, fdem_simulation::ContactOptions::default());
    assert_eq!(model.fracture, fdem_simulation::FractureOptions::default());
    assert!(model.velocities.is_empty() && model.stresses.is_empty());
    let output = &prepared.output;
    assert_eq!((output.interval, output.history_interval), (1e-3 / 50.0, 1e-3 / 1000.0));
    assert_eq!(output.fields, [Field::MAX_PRINCIPAL, Field::VELOCITY, Field::DAMAGE]);
    assert_eq!((output.animate, output.checkpoint), (None, Checkpoint::Seconds(60.0)));
}

#[test]
fn velocities_stresses_and_histories_are_of_nodes_and_elements() {
    let prepared = right(&with(
        r#"
[[body]]
name = "ball"
material = "rock"
disc = { centre = [0.5, 1.0], radius = 0.2 }
mesh_size = 0.1

[initial]
velocity = { ball = [0, -3] }
stress = [-1e6, -2e6, 0]

[[boundary]]
name = "ground"
body = "block"
side = "bottom"
fixed = "xy"

[[history]]
name = "tip"
node = [0.5, 0.75]
body = "ball"
interval = 1e-8

[[history]]
name = "support"
force = "ground"

[[history]]
name = "cracks"
crack_length = true

[output]
animate = "velocity"
interval = 1e-4
checkpoint_steps = 100
"#,
    ));
    let ball = &prepared.bodies[1];
    let model = &prepared.model;
    for (node, velocity) in (0..).zip(&model.velocities) {
        let expected = if ball.nodes.contains(&node) { [0.0, -3.0] } else { [0.0, 0.0] };
        assert_eq!(*velocity, expected);
    }
    assert_eq!(model.stresses, vec![[[-1e6, 0.0], [0.0, -2e6]]; model.mesh.elements.len()]);
    assert!(ball.elements.clone().all(|element| model.mesh.bodies[element as usize] == 1));
    let quantities: Vec<_> = prepared.histories.iter().map(|history| history.quantity).collect();
    let [Quantity::Node(tip), Quantity::Force(0), Quantity::CrackLength] = quantities[..] else { panic!() };
    // The lowest point of the disc, which is a node.
    assert_eq!(model.mesh.nodes[tip as usize], [0.5, 0.8]);
    assert_eq!(prepared.output.history_interval, 1e-8);
    assert_eq!(prepared.output.animate, Some(Field::VELOCITY));
    assert_eq!(prepared.output.checkpoint, Checkpoint::Steps(100));
}

#[test]
fn equal_models_have_equal_hashes_and_others_have_not() {
    let hash = |text: &str| right(text).hash;
    assert_eq!(hash(SMALL), hash(&SMALL.replace("[model]", "# a comment\n[model]")));
    assert_eq!(hash(SMALL).len(), 64);
    for (from, to) in [("2700", "2701"), ("mesh_size = 0.1", "mesh_size = 0.1\nseed = 2")] {
        assert_ne!(hash(SMALL), hash(&SMALL.replace(from, to)), "{to}");
    }
}

#[test]
fn what_may_not_be_meant_is_warned_of() {
    let warned = |text: &str, part: &str| {
        let warnings = right(text).warnings;
        assert!(warnings.iter().any(|warning| warning.contains(part)), "{part:?} is not in {warnings:?}");
    };
    let side = |name: &str, side: &str, load: &str| {
        format!("\n[[boundary]]\nname = \"{name}\"\nside = \"{side}\"\n{load}\n")
    };
    let moved = side("top", "top", "velocity = [\"free\", -0.1]\nramp = 1e-4");
    warned(
        &with(&side("top", "top", "velocity = [\"free\", -0.1]")),
        "\"top\": its velocity is there at once",
    );
    warned(
        &with(&side("top", "top", "displacement = [0, 1e-3]\ntable = [[0, 1]]")),
        "its displacement is there at once",
    );
    assert!(right(&with(&moved)).warnings.is_empty());
    warned(
        &with(&(moved.clone() + &side("ground", "bottom", "fixed = \"xy\""))),
        "\"ground\" is fixed along y while \"top\" moves: the two sides are not loaded alike; move both, with -0.05 and 0.05",
    );
    let both = moved.clone() + &side("ground", "bottom", "velocity = [\"free\", 0.1]\nramp = 1e-4");
    assert!(right(&with(&both)).warnings.is_empty());
    warned(
        &with(
            "[contact]\npenalty = 0.1\n[[body]]\nname = \"b\"\nmaterial = \"rock\"\ndisc = { centre = [5, 5], radius = 1 }\nmesh_size = 0.5",
        ),
        "sink into each other",
    );
    warned(
        &with(
            "[[body]]\nname = \"b\"\nmaterial = \"rock\"\ndisc = { centre = [0.5, 0.5], radius = 0.2 }\nmesh_size = 0.1",
        ),
        "\"block\" and \"b\" overlap by 0.06 m²",
    );
    let strong = "tensile_strength = 10e6\ncohesion = 30e6\nfriction_angle = 30\nfracture_energy_i = 100\nfracture_energy_ii = 100\n";
    let brittle = format!("{SMALL}{strong}");
    // E G/f² = 30e9 x 100 / 1e14 = 30 mm.
    warned(&brittle, "larger than a third of its fracture process zone (E' G/f² = 0.03 m");
    assert!(right(&brittle.replace("mesh_size = 0.1", "mesh_size = 0.008")).warnings.is_empty());
    warned(&with("[[history]]\nname = \"far\"\nnode = [9, 9]"), "the nearest node to [9.0, 9.0]");
}

/// The two bodies have a node at one place. The values of the removed one would be lost.
#[test]
fn a_history_at_the_wall_of_an_excavation_is_of_the_body_that_stays() {
    let body = |name: &str, from: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"rock\"\nmesh_size = 0.5\nrectangle = {{ min = [{from}, 0], max = [{}, 1] }}\n",
            from + 1.0
        )
    };
    let stages =
        "[[stage]]\nname = \"rest\"\nduration = 1e-4\n[[stage]]\nname = \"cut\"\nexcavate = [\"core\"]\n";
    let bodies = format!("{}{}", body("core", 3.0), body("wall", 2.0));
    let at = |x: f64, more: &str| {
        let history = format!("[[history]]\nname = \"wall\"\nnode = [{x}, 0]\n{more}");
        right(&format!("{SMALL}{bodies}{stages}{history}"))
    };
    let lost =
        |prepared: &Prepared| prepared.warnings.iter().any(|text| text.contains("is removed by a stage"));
    assert!(!lost(&at(3.0, "")));
    assert!(lost(&at(4.0, "")));
    assert!(!lost(&at(4.0, "body = \"core\"")));
}

#[test]
fn gravity_that_acts_at_once_is_warned_of_where_something_rests() {
    let sudden = |text: &str| {
        let told = right(text).warnings;
        assert!(told.iter().all(|warning| warning.starts_with("gravity ")), "{told:?}");
        told.into_iter().find(|warning| warning.starts_with("gravity acts at once"))
    };
    let falling = SMALL.replace("[model]", "[model]\ngravity = [0, -9.81]");
    let weak = "tensile_strength = 1e5\ncohesion = 3e5\nfriction_angle = 30\nfracture_energy_i = 100\nfracture_energy_ii = 100\n";
    let held = "[[boundary]]\nname = \"ground\"\nside = \"bottom\"\nfixed = \"xy\"\n";
    // Nothing holds the body, or its weight does not matter, or it is all held.
    assert_eq!(sudden(&falling), None);
    assert_eq!(sudden(&format!("{falling}{held}")), None);
    let all = held.replace("side = \"bottom\"\n", "");
    assert_eq!(sudden(&format!("{falling}{weak}{all}")), None);
    // 20 passages of a wave through 0.5 m.
    let warning = sudden(&format!("{falling}{weak}{held}")).unwrap();
    assert!(
        warning.contains("twice its static stress") && warning.contains("gravity_ramp = 0.003 in"),
        "{warning}"
    );
    // A second body on the first, and one that is above it.
    for (bottom, rests) in [("0.5", true), ("0.500000001", true), ("0.51", false)] {
        let block = "[[body]]\nname = \"top\"\nmaterial = \"rock\"\nmesh_size = 0.1\n";
        let block = format!("{block}rectangle = {{ min = [0.1, {bottom}], max = [0.4, 0.8] }}\n");
        let two = format!("{falling}{held}body = \"block\"\n{block}");
        assert_eq!(sudden(&two).is_some(), rests, "{bottom}");
        let ramped = two.replace("[model]", "[model]\ngravity_ramp = 0.01");
        assert_eq!(right(&ramped).model.gravity_schedule, Schedule::Ramp(0.01));
        assert_eq!(sudden(&ramped), None);
    }
}

#[test]
fn a_regular_mesh_under_fracture_is_warned_of() {
    let mut mesh = String::new();
    for row in 0..5 {
        for column in 0..5 {
            writeln!(mesh, "v {column} {row} 0").unwrap();
        }
    }
    for row in 0..4 {
        for column in 0..4 {
            let corner = row * 5 + column + 1;
            writeln!(mesh, "f {corner} {} {}", corner + 1, corner + 6).unwrap();
            writeln!(mesh, "f {corner} {} {}", corner + 6, corner + 5).unwrap();
        }
    }
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let text = format!("{start}mesh = \"grid.obj\"\n{}", rest.split_once("mesh_size = 0.1\n").unwrap().1);
    let breakable = format!(
        "{text}tensile_strength = 1e3\ncohesion = 3e6\nfriction_angle = 30\nfracture_energy_i = 100\nfracture_energy_ii = 100\n"
    );
    let warnings =
        |text: &str| fdem_model::prepare(text, "m", &mut |_| Ok(mesh.clone().into_bytes())).unwrap().warnings;
    assert!(warnings(&text).is_empty(), "{:?}", warnings(&text));
    assert!(warnings(&breakable)[0].starts_with("100 % of the elements have the angles of a regular mesh"));
}

/// [`SMALL`] with a strength, and lines behind it.
fn breakable(cohesion: &str, more: &str) -> String {
    format!(
        "{SMALL}tensile_strength = 1e6\ncohesion = {cohesion}\nfriction_angle = 30\nfracture_energy_i = 1e3\nfracture_energy_ii = 1e3\n{more}"
    )
}

#[test]
fn a_tension_that_shears_first_and_soft_joints_are_warned_of() {
    let warnings = |text: &str| right(text).warnings.join("\n");
    assert_eq!(warnings(&breakable("3e6", "")), "");
    // c / tan 30° is 0.866 MPa.
    assert!(warnings(&breakable("5e5", "")).contains("cannot carry its tensile strength of"));
    let soft = breakable("3e6", "[fracture]\njoint_penalty = 0.01\n");
    assert!(warnings(&soft).contains("joint_penalty = 0.01: joints are softer"));
}

#[test]
fn words_of_the_literature_and_moduli_out_of_range_are_answered() {
    for (text, parts) in [
        (
            breakable("3e6", "[fracture]\ninsertion = \"extrinsic\"\n"),
            ["insertion", "did you mean \"adaptive\"?"],
        ),
        (breakable("3e6", "weibull_modulus = 1e-3\n"), ["weibull_modulus", "at least 1"]),
    ] {
        let errors = fdem_model::prepare(&text, "m", &mut |_| Err(String::new())).unwrap_err().to_string();
        assert!(parts.iter().all(|part| errors.contains(part)), "{errors}");
    }
}

#[test]
fn the_preflight_knows_steps_and_time() {
    let prepared = right(SMALL);
    let preflight = Preflight::of(&prepared).unwrap();
    let height = prepared.quality.smallest_height;
    // A wave takes longer through the smallest element.
    let wave = height / (30e9_f64 / 2700.0).sqrt();
    assert!((0.1..1.0).contains(&(preflight.critical.step / wave)), "{} {wave}", preflight.critical.step);
    assert_eq!(preflight.step, 0.8 * preflight.critical.step);
    assert_eq!(preflight.steps, (1e-3 / preflight.step).ceil() as u64);
    let text = preflight.to_string();
    for part in [
        "bodies           1: block",
        "elements, ",
        "critical step    ",
        "run time         about ",
        "memory           about ",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let unstable = right(&SMALL.replace("[model]", "[model]\ntime_step = 1e-3"));
    let preflight = Preflight::of(&unstable).unwrap();
    assert!(preflight.warnings[0].contains("the run will not be stable"), "{:?}", preflight.warnings);
}

#[test]
fn an_initial_stress_may_change_with_height() {
    let prepared = right(&with("[initial]\nstress = [-1e6, -2e6, 0.5e6]\nstress_gradient = [1e4, 3e4, 0]\n"));
    let (mesh, stresses) = (&prepared.model.mesh, &prepared.model.stresses);
    assert_eq!(stresses.len(), mesh.elements.len());
    for (nodes, stress) in mesh.elements.iter().zip(stresses) {
        let y = nodes.iter().map(|&node| mesh.nodes[node as usize][1]).sum::<f64>() / 3.0;
        let expected = [[-1e6 + 1e4 * y, 0.5e6], [0.5e6, -2e6 + 3e4 * y]];
        for (found, expected) in stress.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((found - expected).abs() < 1e-3, "{stress:?} at {y}");
        }
    }
    assert!(right(SMALL).model.stresses.is_empty());
}

#[test]
fn what_an_initial_stress_does_not_balance_is_said() {
    let gravity = |stress: &str| {
        let text = SMALL.replace("end_time = 1e-3", "end_time = 1e-3\ngravity = [0, -9.81]");
        format!("{text}\n[[boundary]]\nname = \"below\"\nside = \"bottom\"\nabsorbing = true\n{stress}")
    };
    let told = |text: &str, what: &str| right(text).warnings.iter().any(|warning| warning.contains(what));
    assert!(told(&gravity(""), "is not carried by an initial stress"));
    let carried = "[initial]\nstress = [0, -13243.5, 0]\nstress_gradient = [0, 26487, 0]\n";
    assert!(!told(&gravity(carried), "is not carried by an initial stress"));

    let touching = |stress: &str| {
        let second = "[[body]]\nname = \"lid\"\nmaterial = \"rock\"\nrectangle = { min = [0, 0.5], max = [1.0, 0.7] }\nmesh_size = 0.08\n";
        format!("{SMALL}\n{second}\n[initial]\nstress = {stress}\n")
    };
    assert!(told(&touching("[0, 1e6, 0]"), "\"block\" and \"lid\" touch, and it pulls them apart"));
    assert!(told(&touching("[0, -1e6, 0.5e6]"), "more than friction holds"));
    assert!(!right(&touching("[0, -1e6, 0]")).warnings.iter().any(|warning| warning.contains("[initial]")));
}

#[test]
fn a_boundary_acts_on_several_sides() {
    let sides = |keys: &str| {
        let boundary = format!("[[boundary]]\nname = \"b\"\n{keys}\n");
        right(&with(&boundary)).model.boundaries[0].target.clone()
    };
    let count = |target: &Target<2>| match target {
        Target::Nodes(nodes) => nodes.len(),
        Target::Facets(edges) => edges.len(),
        Target::Held(..) => panic!("no node is held"),
    };
    // Along the bottom are 10 edges, along the left 5, with a corner that counts once.
    assert_eq!(count(&sides("sides = [\"bottom\", \"left\"]\nfixed = \"xy\"")), 16);
    assert_eq!(count(&sides("sides = [\"left\", \"right\"]\npressure = 1e6")), 10);
    assert_eq!(count(&sides("sides = [\"left\"]\npressure = 1e6")), 5);
    let refused = |keys: &str| {
        let boundary = format!("[[boundary]]\nname = \"b\"\nfixed = \"x\"\n{keys}\n");
        read(&with(&boundary)).unwrap_err().to_string()
    };
    let both = refused("side = \"left\"\nsides = [\"right\"]");
    assert!(both.contains("is in two places, side and sides"), "{both}");
    let flat = refused("sides = [\"left\", \"back\"]");
    assert!(flat.contains("a flat body has no front and no back"), "{flat}");
    assert!(!refused("sides = []").is_empty());
}

#[test]
fn a_stress_is_given_by_its_principal_values() {
    let stress =
        |keys: &str| right(&with(&format!("[initial]\nprincipal = {{ {keys} }}\n"))).model.stresses[0];
    let near = |found: [[f64; 2]; 2], wanted: [f64; 3]| {
        let found = [found[0][0], found[1][1], found[0][1], found[1][0]];
        let wanted = [wanted[0], wanted[1], wanted[2], wanted[2]];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1.0), "{found:?} and {wanted:?}");
    };
    near(stress("sigma1 = -10e6, sigma3 = -4e6, angle = 0"), [-10e6, -4e6, 0.0]);
    near(stress("sigma1 = -10e6, sigma3 = -4e6, angle = 90"), [-4e6, -10e6, 0.0]);
    // Compression along a line that rises to the right pushes the upper side to the left, down.
    near(stress("sigma1 = \"-10 MPa\", sigma3 = 2e6, angle = \"45 deg\""), [-4e6, -4e6, -6e6]);
    let refused = |keys: &str| read(&with(&format!("[initial]\n{keys}\n"))).unwrap_err().to_string();
    for (keys, part) in [
        ("principal = { sigma1 = 10e6, sigma3 = 4e6, angle = 0 }", "are not in their order"),
        ("principal = { sigma1 = -10e6, sigma3 = -4e6 }", "needs angle"),
        ("principal = { sigma1 = -10e6, sigma3 = -4e6, angle = 0, trend = 3 }", "has no \"trend\""),
        (
            "stress = [0, 0, 0]\nprincipal = { sigma1 = -10e6, sigma3 = -4e6, angle = 0 }",
            "both stress and principal",
        ),
    ] {
        assert!(refused(keys).contains(part), "{}", refused(keys));
    }
}

/// A block of rock that moves against a fixed base, and breaks.
const CRUSHED: &str = r#"
[model]
end_time = 3e-5
[[body]]
name = "block"
material = "rock"
mesh_size = 0.004
refine = [{ point = [0.05, 0.05], size = 0.002 }]
rectangle = { min = [0, 0], max = [0.1, 0.1] }
velocity = [0, -40]
[[boundary]]
name = "base"
body = "block"
side = "bottom"
fixed = "y"
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.2
tensile_strength = 3e6
cohesion = 9e6
friction_angle = 30
fracture_energy_i = 5
fracture_energy_ii = 20
"#;

#[test]
fn a_rehearsal_has_a_coarse_mesh_and_gives_the_cost_of_breaking() {
    let of = |factor: Option<f64>| {
        let load = &mut |_: &str| Err("no files".to_owned());
        let prepared = match factor {
            Some(factor) => fdem_model::prepare_coarse(CRUSHED, "crushed.toml", load, factor),
            None => fdem_model::prepare_any(CRUSHED, "crushed.toml", load, None),
        };
        match prepared {
            Ok(AnyPrepared::Plane(prepared)) => prepared,
            _ => panic!("a model in the plane"),
        }
    };
    let (fine, coarse) = (of(None), of(Some(2.0)));
    let share = coarse.quality.elements as f64 / fine.quality.elements as f64;
    assert!((0.2..0.35).contains(&share), "{share}");
    let mut preflight = Preflight::of(&fine).unwrap();
    assert!(!preflight.to_string().contains("rehearsal"));

    // Such a short run is not rehearsed, a long one is, and one that does not break is not.
    preflight.seconds_whole = 0.2;
    assert_eq!(Rehearsal::factor(&fine, &preflight), None);
    preflight.seconds_whole = 100.0;
    assert!(Rehearsal::factor(&fine, &preflight).is_some_and(|factor| (1.5..3.0).contains(&factor)));
    let mut strong = fine.clone();
    strong.model.materials[0].strength = None;
    let mut whole = preflight.clone();
    whole.breaks = false;
    assert_eq!(Rehearsal::factor(&strong, &whole), None);
    // Contacts of rigid bodies come later.
    strong.model.rigid = vec![0];
    assert!(Rehearsal::factor(&strong, &whole).is_some());

    // The bodies get the size of the model.
    let boxes = Rehearsal::boxes(&fine);
    let mut smaller = coarse.clone();
    smaller.model.mesh.nodes.iter_mut().for_each(|node| node[1] *= 0.9);
    assert_ne!(Rehearsal::boxes(&smaller), boxes);
    Rehearsal::fit(&mut smaller, &boxes);
    for (fit, body) in
        Rehearsal::boxes(&smaller).iter().flatten().flatten().zip(boxes.iter().flatten().flatten())
    {
        assert!((fit - body).abs() < 1e-15 || fit == body, "{fit} {body}");
    }

    let counts = [coarse.quality.elements, fine.quality.elements];
    let begun = || Simulation::new(coarse.model.clone(), 1).unwrap();
    let steps = (coarse.end_time / begun().time_step()).ceil() as u64;
    // Goes to the end, or to half of it.
    let rehearsed = |end: u64| {
        let mut run = begun();
        Rehearsal::of(counts, steps, coarse.end_time, |limit| {
            run.advance(limit.min(end) - run.steps()).ok()?;
            Some((run.steps(), run.steps() == end))
        })
    };
    let rehearsal = rehearsed(steps).expect("it runs");
    assert_eq!((rehearsal.elements, rehearsal.share, rehearsal.ended), (counts[0], 1.0, None));
    assert!(rehearsal.more > 0.0, "{rehearsal:?}");
    preflight.rehearse(&rehearsal);
    let more = rehearsal.more * (fine.quality.elements as u64 * preflight.steps) as f64;
    assert!((preflight.seconds / (100.0 + more) - 1.0).abs() < 1e-12, "{preflight:?}");
    let line = format!(
        "by a rehearsal with {} elements to end_time; 1 min 40 s if nothing breaks",
        rehearsal.elements
    );
    assert!(preflight.to_string().contains(&line), "{preflight}");

    // A condition ends the run at half of its time.
    let rehearsal = rehearsed(steps / 2).expect("it runs");
    let ended = rehearsal.ended.expect("before the end time");
    assert!((ended / coarse.end_time - 0.5).abs() < 1e-2, "{rehearsal:?}");
    preflight.rehearse(&rehearsal);
    let more = rehearsal.more * fine.quality.elements as f64 * preflight.steps as f64;
    let end = preflight.steps as f64 * preflight.step;
    assert!((preflight.seconds / ((100.0 + more) * ended / end) - 1.0).abs() < 1e-12, "{preflight:?}");
    let text = preflight.to_string();
    assert!(
        text.contains(" elements that ended at about ") && text.contains("1 min 40 s to end_time if"),
        "{text}"
    );

    // It was to be rehearsed, and could not be.
    (preflight.rehearsal, preflight.seconds) = (Some(Rehearsed::Failed), 200.0);
    assert!(preflight.to_string().contains("so it is not known how much breaks"), "{preflight}");

    // Steps are longer and joints fewer where the mesh is coarse.
    let until = |column: &str| {
        let bound = Bound::Above(1000.0);
        let mut coarse = coarse.clone();
        coarse.until = Some(PreparedUntil { column: column.to_owned(), place: 0, bound });
        Rehearsal::scale_counts(&mut coarse, 4 * counts[0]);
        coarse.until.map(|until| until.bound)
    };
    assert_eq!(until("step"), Some(Bound::Above(500.0)));
    assert_eq!(until("broken_joints"), Some(Bound::Above(500.0)));
    assert_eq!(until("crack_length"), Some(Bound::Above(1000.0)));

    // A mesh that is not coarser is of no use.
    assert_eq!(Rehearsal::of([counts[1]; 2], steps, 1.0, |_| unreachable!()), None);
}

/// Bodies that are rigid until they are overloaded, and those that cannot be.
#[test]
fn bodies_may_be_rigid_until_they_are_overloaded() {
    let rock = CRUSHED.replace("fixed = \"y\"", "pressure = 1e5");
    let with = |body: &str, more: &str| rock.replacen("mesh_size", &format!("{body}\nmesh_size"), 1) + more;
    let until = "rigid = \"until_overloaded\"";
    let prepared = right(&with(&format!("{until}\noverload = 0.4"), ""));
    assert_eq!(prepared.model.rigid, [0]);
    let [of] = prepared.model.until_overloaded[..] else { panic!("{:?}", prepared.model.until_overloaded) };
    assert_eq!((of.body, of.share), (0, 0.4));
    assert_eq!(right(&with(until, "")).model.until_overloaded[0].share, 0.03);
    assert!(right(&with("rigid = true", "")).model.until_overloaded.is_empty());
    for (body, more, message) in [
        ("overload = 0.4", "", "overload has no effect"),
        ("rigid = true\noverload = 0.4", "", "overload has no effect"),
        (until, "[fracture]\ninsertion = \"intrinsic\"\n", "joints are on all facets"),
        (until, "[initial]\nstress = [-1e5, -1e5, 0]\n", "the model begins with a stress"),
    ] {
        let errors = read(&with(body, more)).expect_err("refused").to_string();
        assert!(errors.contains(message), "{errors}");
    }
    let fixed = read(&CRUSHED.replacen("mesh_size", &format!("{until}\nmesh_size"), 1)).expect_err("refused");
    assert!(fixed.to_string().contains("a boundary holds or moves it"), "{fixed}");
}

/// A box takes a rigid body out as a whole, or not at all.
#[test]
fn a_box_that_cuts_a_rigid_body_is_refused() {
    let stages = |limits: &str| {
        let stages = format!(
            "[[stage]]\nname = \"one\"\nduration = 1e-5\n[[stage]]\nname = \"two\"\nexcavate_boxes = [{limits}]\n"
        );
        let rest = "[[body]]\nname = \"rest\"\nmaterial = \"rock\"\nmesh_size = 0.05\nrectangle = { min = [1, 1], max = [1.1, 1.1] }\n";
        let rigid = CRUSHED.replacen("mesh_size", "rigid = true\nmesh_size", 1);
        format!("{rigid}{rest}{stages}")
    };
    let cut = read(&stages("[0, 0, 0.05, 0.1]")).expect_err("refused").to_string();
    assert!(cut.contains("[[stage]] \"two\": this box cuts the rigid body \"block\""), "{cut}");
    right(&stages("[-1, -1, 0.5, 0.5]"));
}

#[test]
fn rigid_bodies_cannot_be_bonded() {
    let rigid = CRUSHED
        .replacen("mesh_size", "rigid = true\nmesh_size", 1)
        .replace("fixed = \"y\"", "pressure = 1e5");
    let more = "[[body]]\nname = \"lid\"\nmaterial = \"rock\"\nmesh_size = 0.05\nrectangle = { min = [0, 0.1], max = [0.1, 0.2] }\n\
        [[joint_set]]\nname = \"glue\"\nbetween = [\"block\", \"lid\"]\ntensile_strength = 1e6\ncohesion = 1e6\n\
        friction_angle = 30\nfracture_energy_i = 5\nfracture_energy_ii = 20\n";
    let refused = read(&format!("{rigid}{more}")).expect_err("refused").to_string();
    assert!(
        refused.contains("[[joint_set]] \"glue\": the rigid body \"block\" cannot be bonded"),
        "{refused}"
    );
}
