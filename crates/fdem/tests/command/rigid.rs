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

/// A drum that its boundary turns ever faster, and a block that flies and spins.
const TURNING: &str = r#"
[model]
end_time = 0.02
time_step = 1e-5
[[body]]
name = "drum"
material = "steel"
rectangle = { min = [-0.1, -0.1], max = [0.1, 0.1] }
mesh_size = 0.1
rigid = true
[[body]]
name = "block"
material = "steel"
rectangle = { min = [1, 0], max = [1.2, 0.1] }
mesh_size = 0.1
rigid = true
velocity = [1, -2]
spin = "-30 rad/s"
[[material]]
name = "steel"
density = 8000
youngs_modulus = 1e8
poissons_ratio = 0.3
[[boundary]]
name = "drive"
body = "drum"
side = "left"
rotation = { through = [0, 0], speed = "1000 rad/s" }
table = [[0, 0], [0.02, 1]]
[[history]]
name = "drum"
motion = "drum"
[[history]]
name = "block"
motion = "block"
[[history]]
name = "drive"
force = "drive"
[output]
frames = 2
checkpoint_steps = 200
history_interval = 1e-3
"#;

#[test]
fn histories_have_the_motion_of_rigid_bodies_and_the_torque_of_a_rotation() {
    let bench = Bench::new();
    bench.write("turning.toml", TURNING);
    bench.run(&["run", "turning.toml", "-o", "whole", "-q", "--threads", "1"]).succeeds();
    let history = bench.columns("whole/history.csv");
    let time = &history["time"];
    let near = |column: &str, expected: &dyn Fn(f64) -> f64, within: f64| {
        let found = &history[column];
        assert_eq!(found.len(), 21, "{column}");
        for (found, time) in found.iter().zip(time) {
            assert!((found - expected(*time)).abs() < within, "{column} at {time} s: {found}");
        }
    };
    // 10 rad, more than a turn and a half.
    near("drum rz [rad]", &|time| 2.5e4 * time * time, 1e-9);
    near("drum ux [m]", &|_| 0.0, 1e-12);
    near("block ux [m]", &|time| time, 1e-12);
    near("block vy [m/s]", &|_| -2.0, 1e-12);
    near("block rz [rad]", &|time| -30.0 * time, 1e-10);
    near("block wz [rad/s]", &|_| -30.0, 1e-10);
    // In the first step, of half an increment, the moment is half as large.
    let inertia = 8000.0 * 0.04 * 0.08 / 12.0;
    let moment = 5e4 * inertia;
    let torque = &history["drive torque [N m]"];
    assert!((torque[0] / moment - 0.5).abs() < 1e-9, "{torque:?} {moment}");
    assert!(torque[1..].iter().all(|found| (found / moment - 1.0).abs() < 1e-9), "{torque:?} {moment}");
    bench.run(&["run", "turning.toml", "-o", "cut", "-q", "--set", "model.end_time=0.01"]).succeeds();
    bench.run(&["resume", "cut", "-q", "--threads", "2", "--end-time", "0.02"]).succeeds();
    assert_eq!(bench.read("cut/history.csv"), bench.read("whole/history.csv"));
    // Columns of a curve.
    let curve = "[[curve]]\nname = \"work\"\nx = \"drum rz\"\ny = \"drive torque\"\n";
    bench.write("curve.toml", format!("{TURNING}{curve}"));
    bench.run(&["check", "curve.toml"]).succeeds();
}
