//! Bonds: joint sets between bodies.

use fdem_model::{AnyPrepared, ModelErrors, Prepared, prepare_any};
use fdem_simulation::Simulation;

const BLOCKS: &str = r#"[model]
end_time = 1e-3

[[body]]
name = "lower"
material = "rock"
rectangle = { min = [0, 0], max = [0.1, 0.05] }
mesh_size = 0.0125

[[body]]
name = "upper"
material = "rock"
rectangle = { min = [0, 0.05], max = [0.1, 0.1] }
mesh_size = 0.0125

[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0
damping = 0.5
friction = 0.577

[[joint_set]]
name = "mortar"
between = ["lower", "upper"]
friction_angle = 30
tensile_strength = 1e6
cohesion = 3e6
fracture_energy_i = 1
fracture_energy_ii = 5

[[boundary]]
name = "down"
body = "lower"
side = "bottom"
velocity = ["free", -0.004]
ramp = 2e-4

[[boundary]]
name = "up"
body = "upper"
side = "top"
velocity = ["free", 0.004]
ramp = 2e-4

[[history]]
name = "corner"
node = [0.1, 0.05]
body = "upper"
"#;

const WALL: &str = r#"[model]
end_time = 1e-3

[[body]]
name = "bricks"
material = "rock"
rectangle = { min = [0, 0], max = [0.4, 0.2] }
repeat = [3, 2]
spacing = [0.4, 0.4]
mesh_size = 0.1

[[body]]
name = "others"
material = "rock"
rectangle = { min = [0.2, 0.2], max = [0.6, 0.4] }
repeat = [3, 2]
spacing = [0.4, 0.4]
mesh_size = 0.1

[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.2

[[joint_set]]
name = "beds"
between = ["bricks", "others"]
friction_angle = 30

[[joint_set]]
name = "heads"
between = ["bricks", "bricks"]
friction_angle = 30
"#;

/// One tetrahedron on each side of the face z = 0.
fn tetrahedron(height: &str, order: &str) -> Vec<u8> {
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 {height}\n$EndNodes\n$Elements\n1\n1 4 2 1 1 {order}\n$EndElements\n"
    )
    .into_bytes()
}

fn read(text: &str) -> Result<AnyPrepared, ModelErrors> {
    let load = &mut |name: &str| match name {
        "above.msh" => Ok(tetrahedron("1", "1 2 3 4")),
        "below.msh" => Ok(tetrahedron("-1", "1 3 2 4")),
        _ => Err("there is no such file".to_owned()),
    };
    prepare_any(text, "model.toml", load, None)
}

fn flat(text: &str) -> Prepared {
    match read(text) {
        Ok(AnyPrepared::Plane(prepared)) => *prepared,
        Ok(AnyPrepared::Space(_)) => panic!("a flat model"),
        Err(errors) => panic!("{errors}"),
    }
}

/// Two blocks under tension hold as the mortar does, and then come apart along it.
#[test]
fn bonded_blocks_part_at_the_strength_of_the_bond() {
    let prepared = flat(BLOCKS);
    let mortar = &prepared.joint_sets[0];
    assert_eq!((mortar.joints, mortar.facets), (1, 8));
    assert!((mortar.length.unwrap_or_default() - 0.1).abs() < 1e-12, "{mortar:?}");
    // Nine nodes are common. They stay in the range of the lower block.
    let count: usize = prepared.bodies.iter().map(|body| body.nodes.len()).sum();
    assert_eq!(count, prepared.model.mesh.nodes.len());
    let on_bond = prepared.model.mesh.nodes.iter().filter(|node| (node[1] - 0.05).abs() < 1e-9).count();
    assert_eq!(on_bond, 9);
    let mut run = Simulation::new(prepared.model, 1).expect("a model");
    assert_eq!(run.fragments().iter().max(), Some(&0));
    let mut peak = 0.0_f64;
    while run.time() < 3e-3 {
        run.advance(5).expect("steps");
        peak = peak.max(run.force(1).expect("a boundary")[1]);
    }
    assert!((peak / 1e5 - 1.0).abs() < 0.05, "{peak}");
    assert_eq!(run.fragments().iter().max(), Some(&1));
    assert!(run.energies().error().abs() < 1e-4, "{:?}", run.energies());
}

/// Bricks in a bond: each rests on two of the row below, and copies of a body have joints with each other.
#[test]
fn bricks_of_a_wall_are_bonded_to_their_neighbours() {
    let prepared = flat(WALL);
    let [beds, heads] = &prepared.joint_sets[..] else { panic!("two sets") };
    // Three rows of joints with five contacts of 0.2 m each, with two edges; two joints in each of the two
    // rows of bricks, of 0.2 m.
    assert_eq!((beds.joints, beds.facets), (15, 30));
    assert!((beds.length.unwrap_or_default() - 3.0).abs() < 1e-9, "{beds:?}");
    assert_eq!((heads.joints, heads.facets), (4, 8));
    // Each facet is one of two elements, also where two bricks without a bond meet on a third one.
    let of_sets = prepared.model.joint_facets.iter().flatten().filter(|set| **set != u32::MAX).count();
    assert_eq!(of_sets, 2 * (30 + 8));
    let run = Simulation::new(prepared.model, 1).expect("a model");
    assert_eq!(run.fragments().iter().max(), Some(&0));
}

#[test]
fn bodies_with_a_common_face_are_bonded_in_space() {
    let text = r#"[model]
end_time = 1e-3
[[body]]
name = "above"
material = "rock"
mesh = "above.msh"
[[body]]
name = "below"
material = "rock"
mesh = "below.msh"
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.2
[[joint_set]]
name = "glue"
between = ["below", "above"]
friction_angle = 30
"#;
    let Ok(AnyPrepared::Space(prepared)) = read(text) else { panic!("a model in three dimensions") };
    assert_eq!(prepared.model.mesh.nodes.len(), 5);
    assert_eq!((prepared.joint_sets[0].facets, prepared.joint_sets[0].area), (1, Some(0.5)));
    let run = Simulation::new(prepared.model, 1).expect("a model");
    assert_eq!(run.fragments(), [0, 0]);
}

/// Motions of one body do not reach through a bond: a block that is drawn off along the bond slips with its
/// friction, and one that is lifted off meets no force.
#[test]
fn boundaries_of_one_body_do_not_move_the_other() {
    let weak = BLOCKS
        .replace(
            "tensile_strength = 1e6\ncohesion = 3e6\nfracture_energy_i = 1\nfracture_energy_ii = 5\n",
            "",
        )
        .replace("side = \"bottom\"\nvelocity = [\"free\", -0.004]\nramp = 2e-4", "fixed = \"xy\"");
    let pull = weak.replace("side = \"top\"\nvelocity = [\"free\", 0.004]", "velocity = [0, 0.01]");
    let prepared = flat(&pull);
    assert!(
        prepared.warnings.iter().any(|warning| warning.contains("leaves out 9 nodes")),
        "{:?}",
        prepared.warnings
    );
    let mut run = Simulation::new(prepared.model, 1).expect("a model");
    while run.time() < 1e-3 {
        run.advance(20).expect("steps");
    }
    // Less than a thousandth of the energy that strains the blocks as much.
    let force = run.force(1).expect("a boundary")[1];
    assert!(force.abs() < 1e3, "{force}");

    let shear = weak.replace("velocity = [\"free\", 0.004]", "velocity = [0.05, \"free\"]")
        + "\n[[boundary]]\nname = \"weight\"\nbody = \"upper\"\nside = \"top\"\npressure = 1e6\nramp = 2e-4\n";
    let mut run = Simulation::new(flat(&shear.replace("end_time = 1e-3", "end_time = 5e-3")).model, 1)
        .expect("a model");
    let (mut sum, mut count) = (0.0, 0.0);
    while run.time() < 5e-3 {
        run.advance(20).expect("steps");
        if run.time() > 3e-3 {
            (sum, count) = (sum + run.force(1).expect("a boundary")[0], count + 1.0);
        }
    }
    let expected = 1e6 * 0.1 * 30.0_f64.to_radians().tan();
    assert!((sum / count / expected - 1.0).abs() < 0.05, "{} {expected}", sum / count);
}

#[test]
fn bonds_that_make_no_sense_are_refused() {
    for (from, to, parts) in [
        (
            "max = [0.1, 0.1] }\nmesh_size = 0.0125",
            "max = [0.1, 0.1] }\nmesh_size = 0.01",
            &["do not fit together", "\"lower\"", "same mesh_size"][..],
        ),
        ("min = [0, 0.05]", "min = [0, 0.06]", &["do not lie on each other"]),
        (
            "mesh_size = 0.0125\n\n[[material]]",
            "mesh_size = 0.0125\nvelocity = [0, 1]\n\n[[material]]",
            &["different velocities"],
        ),
        (
            "[[history]]",
            "[[stage]]\nname = \"one\"\nduration = 1e-4\n[[stage]]\nname = \"two\"\nactivate = [\"upper\"]\n[[history]]",
            &["do not appear in the same stage"],
        ),
        ("friction_angle = 30", "friction_angle = 30\ndilation_angle = 40", &["dilation angle is above"]),
        ("friction_angle = 30", "friction_angle = 30\ndilation_slip = 1", &["goes with a dilation_angle"]),
        (
            "between = [\"lower\", \"upper\"]",
            "between = [\"lower\", \"uper\"]",
            &["there is no body \"uper\"", "upper"],
        ),
        ("between = [\"lower\", \"upper\"]", "between = [\"lower\"]", &["between"]),
        (
            "between = [\"lower\", \"upper\"]",
            "between = [\"lower\", \"upper\"]\ndip = 3\nspacing = 1",
            &["given twice"],
        ),
        (
            "between = [\"lower\", \"upper\"]",
            "between = [\"lower\", \"upper\"]\nbodies = [\"upper\"]",
            &["names the bodies"],
        ),
    ] {
        assert!(BLOCKS.contains(from), "{from}");
        let message = match read(&BLOCKS.replacen(from, to, 1)) {
            Ok(_) => panic!("{to} is refused"),
            Err(errors) => errors.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
        };
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in\n{message}");
        }
    }
}

/// A pattern means every body whose name fits it.
#[test]
fn bodies_are_bonded_by_a_pattern() {
    let length = |between: &str| {
        let text = BLOCKS.replace("[\"lower\", \"upper\"]", between);
        flat(&text).joint_sets[0].length
    };
    assert_eq!(length("[\"*er\", \"*er\"]"), length("[\"lower\", \"upper\"]"));
    let text = BLOCKS.replace("[\"lower\", \"upper\"]", "[\"lower\", \"u*x\"]");
    let told = read(&text).unwrap_err().to_string();
    assert!(told.contains("there is no body \"u*x\""), "{told}");
}
