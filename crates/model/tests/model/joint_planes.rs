//! Joint sets in three dimensions: their polygons in the mesh, blocks that slide, and refusals.

use fdem_model::{AnyPrepared, ModelErrors, Prepared, prepare_any};
use fdem_simulation::{Boundary, Load, Model, Schedule, Simulation, Target};

const CUBE: &str = r#"[model]
end_time = 1e-3

[[body]]
name = "block"
material = "rock"
box = { min = [0, 0, 0], max = [1, 1, 1] }
mesh_size = 0.25

[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
"#;

const SET: &str = "\n[[joint_set]]\nname = \"bedding\"\nfriction_angle = 30\n";

fn read(text: &str) -> Result<Prepared<3, 4>, ModelErrors> {
    let load = &mut |name: &str| match name {
        "network.csv" => Ok(b"0,0,0.25,1,0,0.25,1,1,0.25,0,1,0.25\n".to_vec()),
        _ => Err("there is no such file".to_owned()),
    };
    match prepare_any(text, "model.toml", load, None)? {
        AnyPrepared::Space(prepared) => Ok(*prepared),
        AnyPrepared::Plane(_) => panic!("a model in three dimensions"),
    }
}

#[track_caller]
fn right(text: &str) -> Prepared<3, 4> {
    read(text).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The faces that are of a set, with their corners.
fn faces(prepared: &Prepared<3, 4>, set: u32) -> Vec<[[f64; 3]; 3]> {
    const FACETS: [[usize; 3]; 4] = <[[f64; 3]; 4] as fdem_mesh::Corners<3, 4>>::FACETS;
    let model = &prepared.model;
    let mut found = Vec::new();
    for (nodes, sets) in model.mesh.elements.iter().zip(&model.joint_facets) {
        for k in (0..4).filter(|&k| sets[k] == set) {
            let mut facet = FACETS[k].map(|corner| nodes[corner]);
            facet.sort_unstable();
            found.push(facet);
        }
    }
    found.sort_unstable();
    assert!(found.chunks(2).all(|pair| pair[0] == pair[1]), "both elements know the set of their face");
    found.dedup();
    found.iter().map(|facet| facet.map(|node| model.mesh.nodes[node as usize])).collect()
}

#[test]
fn polygons_of_a_list_a_file_and_statistics_are_faces_of_the_mesh() {
    for (keys, area, joints) in [
        ("polygons = [[-1, -1, 0.4, 2, -1, 0.4, 2, 2, 0.4, -1, 2, 0.4]]", 1.0, 1),
        ("polygons = [[0.2, 0.2, 0.4, 0.8, 0.2, 0.4, 0.5, 0.9, 0.4]]", 0.21, 1),
        ("file = \"network.csv\"", 1.0, 1),
        ("dip = 0\ndip_direction = 0\nspacing = 0.4\norigin = [0, 0, 0.3]", 2.0, 2),
        // Upright joints that strike along y.
        ("dip = 90\ndip_direction = 90\nspacing = 0.4\norigin = [0.3, 0, 0]", 2.0, 2),
    ] {
        let prepared = right(&format!("{CUBE}{SET}{keys}\n"));
        let found = &prepared.joint_sets[0];
        assert!((found.area.unwrap() - area).abs() < 1e-9, "{keys}: {found:?}");
        assert_eq!((found.joints, found.facets), (joints, faces(&prepared, 0).len()), "{keys}");
        assert_eq!(found.length, None);
    }
}

/// A polygon near a face is moved onto it, and is no joint.
#[test]
fn polygons_that_are_left_out_are_counted() {
    let keys = |near: f64| {
        let small = format!("[0.2, 0.2, {near}, 0.8, 0.2, {near}, 0.5, 0.9, {near}]");
        format!("polygons = [[-1, -1, 0.4, 2, -1, 0.4, 2, 2, 0.4, -1, 2, 0.4], {small}]\n")
    };
    // One polygon is in the cube, or near its top, on its top, or outside of it.
    for (near, polygons) in [(0.7, [2, 0]), (0.98, [2, 1]), (1.0, [1, 0]), (1.5, [1, 0])] {
        let prepared = right(&format!("{CUBE}{SET}{}", keys(near)));
        let found = &prepared.joint_sets[0];
        assert_eq!(found.polygons, Some(polygons), "{near}");
        let text = found.to_string();
        let expected =
            "1 of 2 polygons is left out: nearer than 0.35 of mesh_size to a face or another polygon";
        assert_eq!(text.contains(expected), polygons[1] > 0, "{near}: {text}");
    }
}

/// The normal of a joint that dips at 30 degrees to the east points up and to the east.
#[test]
fn dip_and_dip_direction_follow_the_convention() {
    for (direction, to) in
        [(0.0, [0.0, 1.0]), (90.0, [1.0, 0.0]), (225.0, [-0.5_f64.sqrt(), -0.5_f64.sqrt()])]
    {
        let keys = format!("dip = 30\ndip_direction = {direction}\nspacing = 5\norigin = [0.5, 0.5, 0.5]\n");
        // Fine enough that no corner is near the plane.
        let prepared = right(&format!("{}{SET}{keys}", CUBE.replacen("0.25", "0.15", 1)));
        let normal = [0.5 * to[0], 0.5 * to[1], 0.75_f64.sqrt()];
        let faces = faces(&prepared, 0);
        assert!(faces.len() > 10);
        for point in faces.iter().flatten() {
            let height: f64 = (0..3).map(|axis| normal[axis] * (point[axis] - 0.5)).sum();
            assert!(height.abs() < 1e-9, "{direction}: {point:?}");
        }
    }
}

/// The mean area of joints in a volume is persistence over spacing times the volume, and a seed gives the
/// same joints.
#[test]
fn statistical_sets_have_their_persistence_and_seed() {
    let keys = "dip = 40\ndip_direction = 120\nspacing = 0.3\npersistence = 0.5\ntrace_length = 0.3\n\
                dip_deviation = 5\ndip_direction_deviation = 5\nspacing_deviation = 0.03\ntrace_deviation = 0.05\n";
    let areas: Vec<f64> = (1..=8)
        .map(|seed| {
            let prepared = right(&format!("{CUBE}{SET}{keys}seed = {seed}\n"));
            prepared.joint_sets[0].area.unwrap()
        })
        .collect();
    let mean = areas.iter().sum::<f64>() / 8.0;
    assert!((mean / (0.5 / 0.3) - 1.0).abs() < 0.15, "{areas:?}");
    assert!(areas.windows(2).all(|pair| pair[0] != pair[1]), "{areas:?}");
    let [one, again] = [(); 2].map(|()| right(&format!("{CUBE}{SET}{keys}")).hash);
    assert_eq!(one, again);
}

#[test]
fn a_body_that_is_turned_and_moved_has_its_joints_where_they_are_asked_for() {
    let moved =
        CUBE.replacen("mesh_size", "angle = 20\naxis = [1, 2, 3]\ntranslate = [3, 4, 5]\nmesh_size", 1);
    let prepared =
        right(&format!("{moved}{SET}dip = 0\ndip_direction = 0\nspacing = 9\norigin = [0, 0, 5.5]\n"));
    let faces = faces(&prepared, 0);
    assert!(faces.len() > 10 && faces.iter().flatten().all(|point| (point[2] - 5.5).abs() < 1e-9));
}

#[test]
fn an_open_joint_parts_a_cube_and_a_closed_one_does_not() {
    for (keys, fragments) in [("open = true\n", 2), ("", 1)] {
        let prepared = right(&format!(
            "{CUBE}{SET}{keys}dip = 0\ndip_direction = 0\nspacing = 9\norigin = [0, 0, 0.4]\n"
        ));
        let mut run = Simulation::new(prepared.model, 1).unwrap();
        run.advance(2).unwrap();
        let mut found = run.fragments();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), fragments, "{keys}");
    }
}

/// Nodes of a mesh at places.
fn nodes(model: &Model<3, 4>, is_there: impl Fn([f64; 3]) -> bool) -> Target<3> {
    let nodes = (0..).zip(&model.mesh.nodes);
    Target::Nodes(nodes.filter(|(_, node)| is_there(**node)).map(|(number, _)| number).collect())
}

fn boundary(name: &str, target: Target<3>, velocity: [Option<f64>; 3], schedule: Schedule) -> Boundary<3> {
    Boundary { name: name.to_owned(), target, load: Load::Velocity(velocity), schedule }
}

/// Peak of the shear traction, and its mean at the end, Pa, of a plate with a joint through it, flat so that
/// it does not tilt. `pressure`: on it, Pa; `energy`: fracture energy of its joint in sliding, J/m²; `end`:
/// time of the run, s.
fn sheared(pressure: f64, energy: f64, end: f64) -> [f64; 2] {
    let plate = CUBE.replacen("max = [1, 1, 1]", "max = [0.16, 0.06, 0.02]", 1).replacen("0.25", "0.02", 1);
    let law = format!(
        "cohesion = 1e6\nfracture_energy_ii = {energy}\nresidual_friction_angle = 25\nnormal_stiffness = 4e11\nshear_stiffness = 1e11\n"
    );
    let load =
        format!("[[boundary]]\nname = \"pressure\"\nside = \"top\"\npressure = {pressure}\nramp = 3e-4\n");
    let keys = "polygons = [[0, 0, 0.01, 0.16, 0, 0.01, 0.16, 0.06, 0.01, 0, 0.06, 0.01]]\n";
    let mut model = right(&format!("{plate}{SET}{law}{keys}{load}")).model;
    model.materials[0].damping = 0.3;
    model.time.local_damping = 0.5;
    let below = nodes(&model, |[_, _, z]| z < 0.0099);
    let above = nodes(&model, |[_, _, z]| z > 0.0101);
    model.boundaries.push(boundary("below", below, [Some(0.0); 3], Schedule::Constant));
    let table = Schedule::Table(vec![[6e-4, 0.0], [1.2e-3, 1.0]]);
    model.boundaries.push(boundary("above", above, [Some(0.08), None, None], table));
    let mut run = Simulation::new(model, 1).unwrap();
    let (mut peak, mut last) = (0.0_f64, [0.0; 2]);
    while run.time() < end {
        run.advance(10).unwrap();
        // The boundary that holds the lower part.
        let traction = run.force(1).unwrap()[0].abs() / 0.0096;
        peak = peak.max(traction);
        if run.time() > 0.9 * end {
            last = [last[0] + traction, last[1] + 1.0];
        }
    }
    [peak, last[0] / last[1]]
}

/// Direct shear under three pressures: cohesion and friction from the line through the peaks. The joint is
/// tough, so that all of it reaches its strength together.
#[test]
fn direct_shear_gives_cohesion_and_friction() {
    let pressures = [1e6, 2e6, 4e6];
    let peaks = pressures.map(|pressure| sheared(pressure, 400.0, 2.2e-3)[0]);
    let mean = |values: [f64; 3]| values.iter().sum::<f64>() / 3.0;
    let (x, y) = (mean(pressures), mean(peaks));
    let products = (0..3).map(|k| (pressures[k] - x) * (peaks[k] - y)).sum::<f64>();
    let slope = products / pressures.iter().map(|pressure| (pressure - x).powi(2)).sum::<f64>();
    let cohesion = y - slope * x;
    assert!((cohesion / 1e6 - 1.0).abs() < 0.02, "{cohesion} {peaks:?}");
    assert!((slope / 30.0_f64.to_radians().tan() - 1.0).abs() < 0.02, "{slope} {peaks:?}");
}

/// After it has slid, a joint has its residual friction; one that is brittle fails from its edges, below the
/// sum of cohesion and friction.
#[test]
fn direct_shear_of_a_brittle_joint_leaves_residual_friction() {
    let [peak, residual] = sheared(2e6, 80.0, 4e-3);
    let strength = 1e6 + 2e6 * 30.0_f64.to_radians().tan();
    assert!((0.9..1.0).contains(&(peak / strength)), "{peak} {strength}");
    let expected = 2e6 * 25.0_f64.to_radians().tan();
    assert!((residual / expected - 1.0).abs() < 0.02, "{residual} {expected}");
}

/// A wedge between two joints at right angles, symmetric about the vertical, slides along their line where
/// the tangent of the slope is above that of the friction angle over the sine of half of the angle between
/// them, with the acceleration of a rigid body.
///
/// # Source
/// E. Hoek, J. W. Bray, "Rock slope engineering" (1981), wedge failure: FS = tan φ / (tan ψ sin(ξ/2)) of a
/// symmetric wedge with friction only.
#[test]
fn a_wedge_slides_above_the_slope_of_its_friction() {
    let friction = 0.5_f64;
    let angle = friction.atan().to_degrees();
    let critical = friction / std::f64::consts::FRAC_1_SQRT_2;
    let set = format!(
        "\n[[joint_set]]\nname = \"wedge\"\nfriction_angle = {angle}\npolygons = [[0.5, -1, 0.3, 0.5, 2, 0.3, 2, 2, 1.8, 2, -1, 1.8], [0.5, -1, 0.3, 0.5, 2, 0.3, -1, 2, 1.8, -1, -1, 1.8]]\n"
    );
    for slope in [0.9 * critical, 1.2 * critical] {
        let mut model = right(&format!("{CUBE}{set}")).model;
        let (sine, cosine) = slope.atan().sin_cos();
        let gravity = 4000.0;
        model.gravity = [0.0, gravity * sine, -gravity * cosine];
        model.gravity_schedule = Schedule::Ramp(4e-4);
        model.materials[0].damping = 0.3;
        let floor = |[x, _, z]: [f64; 3]| z - 0.3 - (x - 0.5_f64).abs();
        let held = nodes(&model, |node| floor(node) < -1e-6);
        model.boundaries.push(boundary("rock", held, [Some(0.0); 3], Schedule::Constant));
        let mut run = Simulation::new(model, 1).unwrap();
        let mut to = |time: f64| {
            while run.time() < time {
                run.advance(20).unwrap();
            }
            let snapshot = run.snapshot();
            let (mut sum, mut count) = (0.0, 0.0);
            for (position, velocity) in snapshot.positions.iter().zip(&snapshot.velocities) {
                if floor(*position) > 0.1 {
                    (sum, count) = (sum + velocity[1], count + 1.0);
                }
            }
            [run.time(), sum / count]
        };
        let [from, first] = to(1.5e-3);
        let [until, last] = to(5e-3);
        if slope > critical {
            let expected = gravity * (sine - critical * cosine);
            let found = (last - first) / (until - from);
            assert!((found / expected - 1.0).abs() < 0.08, "{found} {expected}");
        } else {
            assert!(last.abs() < 2e-3 * gravity * sine * until, "{last}");
        }
    }
}

#[test]
fn what_is_wrong_with_a_set_is_told() {
    let level = "polygons = [[-1, -1, 0.4, 2, -1, 0.4, 2, 2, 0.4, -1, 2, 0.4]]\n";
    for (keys, part) in [
        ("", "give it one of polygons, file, dip, group and between"),
        ("lines = [[0, 0, 1, 1]]\n", "\"lines\" is for models in two dimensions"),
        ("polygons = [[0, 0, 0, 1, 1, 1]]\n", "polygon 1 is not [x1, y1, z1"),
        ("polygons = [[0, 0, 0, 1, 0, 0, 2, 0, 0]]\n", "has no area"),
        ("polygons = [[0, 0, 0.4, 1, 0, 0.4, 1, 1, 0.6, 0, 1, 0.4]]\n", "\"bedding\" is not flat"),
        ("dip = 30\nspacing = 0.4\n", "needs a dip_direction"),
        ("dip = -30\ndip_direction = 10\nspacing = 0.4\n", "0 to 90 degrees"),
        ("dip = 30\ndip_direction = 10\nspacing = 0.4\norigin = [0, 0]\n", "\"origin\" has 2 numbers"),
        (
            "dip = 30\ndip_direction = 10\nspacing = 0.4\npersistence = 0.9\ntrace_length = 0.4\n",
            "at most 0.8, or 1",
        ),
        ("file = \"no.csv\"\n", "cannot read no.csv"),
    ] {
        let errors = read(&format!("{CUBE}{SET}{keys}")).unwrap_err();
        let drawn = format!("{errors}{}", errors.render(fdem_model::Drawing::Plain));
        assert!(drawn.contains(part), "{keys}: {drawn}");
    }
    let fine = CUBE.replacen("0.25", "0.02", 1);
    let tilted = "[[joint_set]]\nname = \"fault\"\nfriction_angle = 30\npolygons = [[-1, -1, 0.34, 2, -1, 0.46, 2, 2, 0.46, -1, 2, 0.34]]\n";
    let errors = read(&format!("{fine}{SET}{level}{tilted}")).unwrap_err().to_string();
    assert!(
        errors.contains("\"bedding\"") && errors.contains("\"fault\"") && errors.contains("2.3 degrees"),
        "{errors}"
    );
    let grains = CUBE.replacen(
        "box = { min = [0, 0, 0], max = [1, 1, 1] }",
        "voronoi = { outline = { box = { min = [0, 0, 0], max = [1, 1, 1] } }, grains = 4 }",
        1,
    );
    let errors = read(&format!("{grains}{SET}{level}")).unwrap_err().to_string();
    assert!(errors.contains("has grains"), "{errors}");
    let errors = read(&format!("{CUBE}{SET}{}", level.replace("0.4", "7"))).unwrap_err().to_string();
    assert!(errors.contains("\"bedding\" has no joint"), "{errors}");
}
