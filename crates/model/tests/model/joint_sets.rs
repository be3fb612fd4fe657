//! Joint sets: their lines in the mesh, their laws, and refusals.

use fdem_model::prepare;

use crate::{SMALL, read, right};

const SET: &str = "\n[[joint_set]]\nname = \"bedding\"\nfriction_angle = 30\n";

fn with(more: &str) -> String {
    format!("{SMALL}{SET}{more}")
}

/// The edges that are of a set, with their ends.
fn edges(prepared: &fdem_model::Prepared, set: u32) -> Vec<[[f64; 2]; 2]> {
    let model = &prepared.model;
    let mut found = Vec::new();
    for (nodes, sets) in model.mesh.elements.iter().zip(&model.joint_facets) {
        for k in (0..3).filter(|&k| sets[k] == set) {
            let [a, b] = [nodes[k], nodes[(k + 1) % 3]];
            found.push([a.min(b), a.max(b)]);
        }
    }
    found.sort_unstable();
    assert!(found.chunks(2).all(|pair| pair[0] == pair[1]), "both elements know the set of their edge");
    found.dedup();
    found.iter().map(|edge| edge.map(|node| model.mesh.nodes[node as usize])).collect()
}

fn length(edges: &[[[f64; 2]; 2]]) -> f64 {
    edges.iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
}

#[test]
fn lines_of_a_list_are_edges_with_their_clipped_length() {
    // From outside across the block, and a polyline that ends inside.
    let prepared = right(&with("lines = [[-1, 0.25, 2, 0.25], [0.3, 0.1, 0.5, 0.4, 0.8, 0.4]]\n"));
    let edges = edges(&prepared, 0);
    let expected = 1.0 + 0.2_f64.hypot(0.3) + 0.3;
    assert!((length(&edges) - expected).abs() < 1e-9, "{}", length(&edges));
    let joints = &prepared.joint_sets[0];
    assert_eq!((joints.name.as_str(), joints.joints, joints.facets), ("bedding", 3, edges.len()));
    assert!((joints.length.unwrap() - expected).abs() < 1e-9);
    let set = &prepared.model.joint_sets[0];
    let tangent = 30.0_f64.to_radians().tan();
    assert!(
        (set.strength.friction - tangent).abs() < 1e-12 && set.residual_friction == set.strength.friction
    );
    assert_eq!([set.strength.cohesion, set.strength.tensile], [0.0; 2]);
}

/// A line nearer to an outline than 0.35 of the mesh size cannot be an edge: the warning names its length.
#[test]
fn lines_near_an_outline_vanish_with_a_warning() {
    let warned = |lines: &str| -> Option<String> {
        let warnings = right(&with(&format!("lines = [{lines}]\n"))).warnings;
        warnings.into_iter().find(|warning| warning.contains("vanish"))
    };
    let across = "[0, 0.25, 1, 0.25]";
    assert_eq!(warned(across), None);
    let near = warned(&format!("{across}, [0.2, 0.001, 0.8, 0.001]")).unwrap();
    for part in ["\"bedding\": 1 line vanishes", "0.6 of 1.6 m in the bodies"] {
        assert!(near.contains(part), "{near}");
    }
    let along = warned(&format!("{across}, [0, 0, 0.5, 0]")).unwrap();
    assert!(along.contains("1 line vanishes") && along.contains("0.5 of 1.5 m"), "{along}");
    let twice = warned(&format!("{across}, [-1, 0.25, 0.5, 0.25], [0, 9, 1, 9]")).unwrap();
    assert!(twice.contains("1 line vanishes") && twice.contains("0.5 of 1.5 m"), "{twice}");
}

#[test]
fn a_body_that_is_turned_and_moved_has_its_joints_where_they_are_asked_for() {
    let moved = SMALL.replacen("mesh_size", "angle = 20\ntranslate = [3, 4]\nmesh_size", 1);
    let prepared = right(&format!("{moved}{SET}lines = [[0, 4.25, 9, 4.25]]\n"));
    let edges = edges(&prepared, 0);
    assert!(length(&edges) > 0.9);
    assert!(edges.iter().flatten().all(|end| (end[1] - 4.25).abs() < 1e-9), "{edges:?}");
}

#[test]
fn lines_of_a_file_and_of_statistics() {
    let text = with("file = \"network.csv\"\n");
    let mut load = |name: &str| {
        if name == "network.csv" { Ok(b"0,0.25,1,0.25\n".to_vec()) } else { Err("none".to_owned()) }
    };
    let prepared = prepare(&text, "model.toml", &mut load).unwrap();
    assert!((length(&edges(&prepared, 0)) - 1.0).abs() < 1e-9);
    let prepared = right(&with("dip = 0\nspacing = 0.2\norigin = [0, 0.05]\n"));
    assert!((length(&edges(&prepared, 0)) - 3.0).abs() < 1e-9);
}

#[test]
fn what_is_wrong_with_a_set_is_told() {
    for (keys, part) in [
        ("", "has no joints"),
        ("lines = [[0, 0, 1, 1]]\ndip = 3\nspacing = 0.3\n", "given twice, by lines and dip"),
        ("lines = [[0, 0, 1]]\n", "line 1 is not [x1, y1, x2, y2"),
        ("lines = [[0, 0, 1, 1]]\nseed = 3\n", "statistical sets"),
        ("polygons = [[0, 0, 0, 1, 0, 0, 0, 1, 0]]\n", "\"polygons\" is for models in three dimensions"),
        (
            "dip = 3\ndip_direction = 3\nspacing = 0.3\n",
            "\"dip_direction\" is for models in three dimensions",
        ),
        ("dip = 3\nspacing = 0.3\norigin = [0, 0, 0]\n", "\"origin\" has 3 numbers"),
        ("dip = 3\n", "needs a spacing"),
        ("dip = 3\nspacing = 1e-3\n", "below the mesh_size"),
        ("dip = 3\nspacing = 0.3\npersistence = 0.5\n", "trace_length"),
        ("dip = 3\nspacing = 0.3\ntrace_length = 0.5\n", "persistence of 1"),
        ("file = \"no.csv\"\n", "cannot read no.csv"),
        ("lines = [[0, 0, 1, 1]]\nbodies = [\"blok\"]\n", "there is no body \"blok\""),
        ("lines = [[0, 0, 1, 1]]\ncohesion = 1e5\n", "needs a fracture_energy_ii"),
        ("lines = [[0, 0, 1, 1]]\nfracture_energy_i = 3\n", "take it out"),
        (
            "lines = [[0, 0, 1, 1]]\nopen = true\ncohesion = 1e5\nfracture_energy_ii = 3\n",
            "open joints have no cohesion",
        ),
        ("lines = [[0, 0, 1, 1]]\nresidual_friction_angle = 40\n", "residual friction angle"),
        ("lines = [[0, 0, 1, 1]]\nswelling = 4\n", "unknown key"),
    ] {
        let text = with(keys);
        let errors = read(&text).unwrap_err();
        let drawn = format!("{errors}{}", errors.render(fdem_model::Drawing::Plain));
        assert!(drawn.contains(part), "{keys}: {drawn}");
    }
    let errors = read(&with("lines = [[50, 50, 60, 60]]\n")).unwrap_err().to_string();
    assert!(errors.contains("\"bedding\" has no joint"), "{errors}");
}

/// Lines with ends far away are cut near the body. They had no end where their places were beyond the whole
/// numbers.
#[test]
fn joints_whose_ends_are_far_away_are_those_in_the_body() {
    let of = |more: &str| length(&edges(&right(&with(more)), 0));
    let through = "lines = [[-3, 0.25, 4, 0.25]]\n";
    assert!((of(through) - 1.0).abs() < 1e-9);
    for far in ["[-1e20, 0.25, 1e20, 0.25]", "[-1, 0.25, 1e29, 0.25]", "[-1e12, 0.25, 1e12, 0.25]"] {
        assert!((of(&format!("lines = [{far}]\n")) - 1.0).abs() < 1e-9, "{far}");
    }
    let one = of("dip = 0\nspacing = 50\norigin = [0, 0.25]\n");
    assert!((one - 1.0).abs() < 1e-9, "{one}");
    for spacing in ["1e9", "1e20", "1e29"] {
        let found = of(&format!("dip = 0\nspacing = {spacing}\norigin = [0, 0.25]\n"));
        assert!((found - one).abs() < 1e-9, "{spacing}: {found}");
    }
    // Beyond the body, and parallel to one of its sides.
    let beside = right(&with("lines = [[-1e20, 7, 1e20, 7], [-1, 0.25, 2, 0.25]]\n"));
    assert!((length(&edges(&beside, 0)) - 1.0).abs() < 1e-9);
}
