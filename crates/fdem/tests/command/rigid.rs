//! Rigid bodies in model files.

use crate::Bench;

/// Rigid polyhedra that fall on a rigid floor; one spins.
const RIGID: &str = r#"
[model]
end_time = 0.02
[[body]]
name = "floor"
material = "rock"
box = { min = [0, 0, -0.1], max = [1, 1, 0] }
mesh_size = 0.5
rigid = true
[[body]]
name = "heap"
material = "rock"
packing = { shape = "polyhedron", count = 12, radius = [0.08, 0.12], within = { min = [0.2, 0.2, 0.01], max = [0.8, 0.8, 0.6] } }
mesh_size = 0.12
rigid = true
velocity = [0, 0, -3]
spin = [0, 1000, 0]
[[material]]
name = "rock"
density = 2700
youngs_modulus = 1e8
poissons_ratio = 0.2
friction = 0.4
[[boundary]]
name = "ground"
body = "floor"
fixed = "xyz"
[contact]
damping = 0.3
[output]
frames = 2
checkpoint_steps = 200
"#;

#[test]
fn rigid_bodies_run_resume_and_are_refused_where_they_cannot_be() {
    let bench = Bench::new();
    bench.write("heap.toml", RIGID);
    bench.run(&["check", "heap.toml"]).succeeds();
    bench.run(&["run", "heap.toml", "-o", "whole", "-q", "--threads", "1"]).succeeds();
    let whole = bench.json("whole/run.json");
    assert!(whole["energies"]["error"].as_f64().unwrap().abs() < 1e-3, "{whole}");
    assert!(whole["energies"]["friction"].as_f64().unwrap() > 0.0, "they have touched: {whole}");
    assert_eq!(whole["energies"]["strain"], 0.0);
    bench.run(&["run", "heap.toml", "-o", "cut", "-q", "--set", "model.end_time=0.01"]).succeeds();
    bench.run(&["resume", "cut", "-q", "--threads", "2", "--end-time", "0.02"]).succeeds();
    assert_eq!(bench.json("cut/run.json")["state_hash"], whole["state_hash"]);

    let hinge = "body = \"floor\"\nbox = [-0.1, -0.1, -0.2, 0.1, 0.1, 0.1]\nfixed";
    bench.write("hinge.toml", RIGID.replace("body = \"floor\"\nfixed", hinge));
    bench.run(&["check", "hinge.toml"]).refused_with(&[
        "hinge.toml:25:1",
        "leaves the rigid body \"floor\" a rotation",
        "hold the whole body",
    ]);
    // Faces that part, and in the second of two stages alone.
    let apart = "[[boundary]]\nname = \"side\"\nbody = \"floor\"\nside = \"top\"\nvelocity = [1, 0, 0]\n";
    let bottom = RIGID.replace("body = \"floor\"\nfixed", "body = \"floor\"\nside = \"bottom\"\nfixed");
    bench.write("apart.toml", format!("{bottom}{apart}"));
    bench.run(&["check", "apart.toml"]).refused_with(&[
        "apart.toml:35:1",
        "boundaries \"ground\" and \"side\" move the rigid body \"floor\"",
    ]);
    let stages = "stages = [\"late\"]\n[[stage]]\nname = \"early\"\nduration = 0.01\n[[stage]]\nname = \"late\"\nduration = 0.01\n";
    bench.write("late.toml", format!("{bottom}{apart}{stages}"));
    bench.run(&["check", "late.toml"]).refused_with(&["late.toml:35:1", "stage \"late\": boundaries"]);
    bench.write("flat.toml", RIGID.replace("spin = [0, 1000, 0]", "spin = 20"));
    bench.run(&["check", "flat.toml"]).refused_with(&["spin", "write [x, y, z]"]);
}
