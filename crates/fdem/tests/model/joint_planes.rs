//! Joint sets in three dimensions: their polygons in the mesh, blocks that slide, and what is refused.

use fdem::model::{AnyPrepared, Prepared, prepare_any};
use fdem_simulation::Simulation;

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

fn read(text: &str) -> Result<Prepared<3, 4>, fdem::model::ModelErrors> {
    let load = &mut |name: &str| match name {
        "network.csv" => Ok(b"0,0,0.25,1,0,0.25,1,1,0.25,0,1,0.25\n".to_vec()),
        _ => Err("there is no such file".to_owned()),
    };
    prepare_any(text, "model.toml", load, None).map(|prepared| match prepared {
        AnyPrepared::Space(prepared) => prepared,
        AnyPrepared::Plane(_) => panic!("a model in three dimensions"),
    })
}

#[track_caller]
fn right(text: &str) -> Prepared<3, 4> {
    read(text).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The faces that are of a set, with their corners.
fn faces(prepared: &Prepared<3, 4>, set: u32) -> Vec<[[f64; 3]; 3]> {
    const FACETS: [[usize; 3]; 4] = <[[f64; 3]; 4] as fdem_mesh::Simplex<3, 4>>::FACETS;
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

/// The normal of a joint that dips at 30 degrees to the east points up and to the east.
#[test]
fn dip_and_dip_direction_follow_the_convention() {
    for (direction, to) in
        [(0.0, [0.0, 1.0]), (90.0, [1.0, 0.0]), (225.0, [-0.5_f64.sqrt(), -0.5_f64.sqrt()])]
    {
        let keys = format!("dip = 30\ndip_direction = {direction}\nspacing = 5\norigin = [0.5, 0.5, 0.5]\n");
        let prepared = right(&format!("{CUBE}{SET}{keys}"));
        let normal = [0.5 * to[0], 0.5 * to[1], 0.75_f64.sqrt()];
        let faces = faces(&prepared, 0);
        assert!(faces.len() > 10);
        for point in faces.iter().flatten() {
            let height: f64 = (0..3).map(|axis| normal[axis] * (point[axis] - 0.5)).sum();
            assert!(height.abs() < 1e-9, "{direction}: {point:?}");
        }
    }
}
