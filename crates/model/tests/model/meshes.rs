//! Shapes, sizes, angles, grains, packings, mesh files.

use std::f64::consts::PI;

use crate::{SMALL, right};

const SHAPES: [(&str, &str, f64); 9] = [
    ("rectangle", "rectangle = { min = [0, 0], max = [2, 1] }\nmesh_size = 0.03", 2.0),
    ("slanted", "rectangle = { min = [0, 0], max = [2, 1] }\nangle = 33\nmesh_size = 0.03", 2.0),
    ("disc", "disc = { centre = [3, -1], radius = 1 }\nmesh_size = 0.04", PI),
    ("ring", "ring = { radius = 1, inner_radius = 0.5 }\nmesh_size = 0.03", 0.75 * PI),
    (
        "polygon",
        "polygon = { points = [[0, 0], [2, 0], [1.2, 0.8], [2, 2], [0, 1.5]] }\nmesh_size = 0.04",
        2.7,
    ),
    (
        "hole",
        "rectangle = { min = [0, 0], max = [2, 2], holes = [{ centre = [1, 1], radius = 0.3 }, [[0.2, 0.2], [0.4, 0.2], [0.3, 0.5]]] }\nmesh_size = 0.05",
        3.687_257,
    ),
    (
        "notch",
        "polygon = { points = [[0, 0], [0.95, 0], [0.95, 0.4], [1.05, 0.4], [1.05, 0], [2, 0], [2, 1], [0, 1]] }\nmesh_size = 0.03",
        1.96,
    ),
    (
        "grains",
        "voronoi = { outline = { rectangle = { min = [0, 0], max = [2, 1] } }, grains = 40 }\nmesh_size = 0.04",
        2.0,
    ),
    (
        "grains of a disc",
        "voronoi = { outline = { disc = { radius = 1 } }, grains = 40 }\nmesh_size = 0.05",
        PI,
    ),
];

fn with_shape(shape: &str) -> String {
    let (start, rest) = SMALL.split_once("rectangle").unwrap();
    let (_, end) = rest.split_once("mesh_size = 0.1\n").unwrap();
    format!("{start}{shape}\n{end}")
}

/// Twice the area of a triangle.
fn twice_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}

#[test]
fn shapes_are_filled_by_triangles_of_good_angles_and_the_size_that_was_asked_for() {
    for (name, shape, area) in SHAPES {
        let prepared = right(&with_shape(shape));
        let mesh = &prepared.model.mesh;
        let areas = mesh.elements.iter().map(|nodes| twice_area(nodes.map(|node| mesh.nodes[node as usize])));
        assert!(areas.clone().all(|area| area > 0.0), "{name}: all are counter-clockwise");
        let sum = areas.sum::<f64>() / 2.0;
        assert!((sum - area).abs() < 3e-3 * area, "{name}: {sum}");
        let size: f64 = shape.split("mesh_size = ").nth(1).unwrap().parse().unwrap();
        let quality = &prepared.quality;
        let mean = quality.edges[1] / size;
        assert!((0.95..1.05).contains(&mean), "{name}: the mean edge is {mean} of the size");
        assert!(quality.smallest_angle[0] > 25.0, "{name}: {quality:?}");
        assert!(quality.smallest_angle[1] > 48.0, "{name}: {quality:?}");
        assert!(quality.regular < 0.01, "{name}: {quality:?}");
    }
}

#[test]
fn a_large_mesh_is_as_good_and_the_same_seed_gives_the_same() {
    let text = with_shape("rectangle = { min = [0, 0], max = [1, 1] }\nmesh_size = 0.005");
    let prepared = right(&text);
    let quality = &prepared.quality;
    assert!((90_000..97_000).contains(&quality.elements), "{quality:?}");
    assert!(quality.below_25 < 1e-3 && quality.smallest_angle[0] > 20.0, "{quality:?}");
    let coarse = text.replace("0.005", "0.02");
    let mesh = right(&coarse).model.mesh;
    assert_eq!(right(&coarse).model.mesh, mesh);
    assert_ne!(right(&coarse.replace("mesh_size", "seed = 2\nmesh_size")).model.mesh.nodes, mesh.nodes);
}

/// No node hangs on an edge, no element lies on another: each edge inside is of two elements, and V - E + F
/// is 1 less the holes.
#[test]
fn meshes_have_the_topology_of_their_outlines() {
    for (name, shape, holes) in
        [(SHAPES[3].0, SHAPES[3].1, 1), (SHAPES[5].0, SHAPES[5].1, 2), (SHAPES[7].0, SHAPES[7].1, 0)]
    {
        let mesh = right(&with_shape(shape)).model.mesh;
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for &[a, b, c] in &mesh.elements {
            edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
        }
        edges.sort_unstable();
        assert!(edges.windows(3).all(|three| three[0] != three[2]), "{name}: an edge of three elements");
        edges.dedup();
        assert_eq!(mesh.nodes.len() + mesh.elements.len() + holes, edges.len() + 1, "{name}");
    }
}

fn root(part: &mut [usize], mut at: usize) -> usize {
    while part[at] != at {
        part[at] = part[part[at]];
        at = part[at];
    }
    at
}

#[test]
fn grains_have_about_one_size_and_neighbours_of_several_materials_differ() {
    let more = "[[material]]\nname = \"NAME\"\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = 0\n";
    let grains = "voronoi = { outline = { rectangle = { min = [0, 0], max = [2, 1] } }, grains = 40, materials = [\"rock\", \"b\", \"c\", \"d\"] }\nmesh_size = 0.04";
    let text =
        ["b", "c", "d"].iter().fold(with_shape(grains), |text, name| text + &more.replace("NAME", name));
    let mesh = right(&text).model.mesh;
    // Parts of one material that are connected: grains, and the few pairs that four colours in turn cannot
    // part.
    let mut part: Vec<usize> = (0..mesh.elements.len()).collect();
    let mut edges: Vec<([u32; 2], usize)> = Vec::new();
    for (element, &[a, b, c]) in mesh.elements.iter().enumerate() {
        edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| ([a.min(b), a.max(b)], element)));
    }
    edges.sort_unstable();
    for pair in edges.windows(2) {
        let [a, b] = [pair[0].1, pair[1].1];
        if pair[0].0 == pair[1].0 && mesh.materials[a] == mesh.materials[b] {
            let (a, b) = (root(&mut part, a), root(&mut part, b));
            part[a] = b;
        }
    }
    let mut areas = std::collections::BTreeMap::<usize, f64>::new();
    for element in 0..part.len() {
        let area = twice_area(mesh.elements[element].map(|node| mesh.nodes[node as usize])) / 2.0;
        *areas.entry(root(&mut part, element)).or_default() += area;
    }
    assert!((36..=40).contains(&areas.len()), "{} grains", areas.len());
    assert!(areas.values().all(|area| (0.02..0.16).contains(area)), "of 0.05 in the mean: {areas:?}");
}

#[test]
fn pieces_of_a_packing_are_bodies_of_their_own_that_do_not_overlap() {
    for shape in ["disc", "polygon"] {
        let packing = format!(
            "packing = {{ shape = \"{shape}\", count = 30, radius = [0.05, 0.1], within = {{ min = [0, 0], max = [2, 1.5] }}, gap = 0.01 }}\nmesh_size = 0.03"
        );
        let prepared = right(&with_shape(&packing));
        assert_eq!(prepared.bodies.len(), 30);
        assert_eq!(prepared.bodies[6].name, "block-7");
        assert!(prepared.warnings.is_empty(), "{:?}", prepared.warnings);
        let mesh = &prepared.model.mesh;
        assert!(mesh.nodes.iter().all(|&[x, y]| (0.01..=1.99).contains(&x) && (0.01..=1.49).contains(&y)));
        let again = right(&with_shape(&packing));
        assert_eq!(again.hash, prepared.hash);
    }
}

#[test]
fn a_packing_comes_from_a_file_too() {
    let text = with_shape("packing = { file = \"discs.csv\" }\nmesh_size = 0.1");
    let mut load = |name: &str| {
        if name == "discs.csv" { Ok(b"x,y,radius\n0,0,0.5\n1,0,0.4\n".to_vec()) } else { Err(String::new()) }
    };
    let prepared = fdem_model::prepare(&text, "model.toml", &mut load).unwrap();
    let names: Vec<_> = prepared.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["block-1", "block-2"]);
}

#[test]
fn physical_groups_of_a_mesh_file_are_materials_bodies_and_boundaries() {
    let file = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"foot\"\n2 5 \"left\"\n2 9 \"right\"\n$EndPhysicalNames\n\
        $Nodes\n6\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 2 0 0\n6 2 1 0\n$EndNodes\n$Elements\n6\n1 1 2 1 1 1 2\n2 1 2 1 1 2 5\n\
        3 2 2 5 1 1 2 3\n4 2 2 5 1 1 4 3\n5 2 2 9 2 2 5 6\n6 2 2 9 2 2 6 3\n$EndElements\n";
    let keys = "mesh = \"two.msh\"\ngroups = { right = \"soft\" }\n[[boundary]]\nname = \"foot\"\ngroup = \"foot\"\npressure = 1\n\
        [[boundary]]\nname = \"half\"\ngroup = \"left\"\nfixed = \"x\"\n\
        [[material]]\nname = \"soft\"\noptional = true\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = 0";
    let read =
        |text: &str| fdem_model::prepare(text, "model.toml", &mut |_| Ok(file.as_bytes().to_vec())).unwrap();
    let prepared = read(&with_shape(keys));
    let mesh = &prepared.model.mesh;
    // "soft" comes before "rock" in this file.
    assert_eq!(mesh.materials, [1, 1, 0, 0]);
    assert_eq!(mesh.nodes.len(), 6, "the halves hold together");
    assert!(
        mesh.elements.iter().all(|nodes| twice_area(nodes.map(|node| mesh.nodes[node as usize])) > 0.0),
        "one was turned"
    );
    let fdem_simulation::Target::Facets(foot) = &prepared.model.boundaries[0].target else { panic!() };
    let ends = foot.iter().map(|edge| edge.map(|node| mesh.nodes[node as usize])).collect::<Vec<_>>();
    assert_eq!(ends, [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [2.0, 0.0]]]);
    let fdem_simulation::Target::Nodes(half) = &prepared.model.boundaries[1].target else { panic!() };
    assert_eq!(half.len(), 4);
    let only = read(&with_shape(&keys.replace("groups = { right = \"soft\" }", "only = [\"left\"]")));
    assert_eq!((only.model.mesh.elements.len(), only.model.mesh.nodes.len()), (2, 4));
}

/// Abaqus has a set of nodes and a set of elements of one name.
#[test]
fn a_set_of_nodes_holds_its_nodes_alone() {
    let file = |more: &str| {
        format!(
            "*Node\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n*Element, type=CPS3\n1, 1, 2, 3\n2, 1, 3, 4\n{more}"
        )
    };
    let read = |more: &str| {
        let keys = "mesh = \"a.inp\"\n[[boundary]]\nname = \"hold\"\ngroup = \"Set-1\"\nfixed = \"xy\"\n";
        let file = file(more);
        fdem_model::prepare(&with_shape(keys), "model.toml", &mut |_| Ok(file.clone().into_bytes()))
    };
    let both = read("*Nset, nset=Set-1\n1, 2\n*Elset, elset=Set-1\n1\n").unwrap();
    let fdem_simulation::Target::Nodes(held) = &both.model.boundaries[0].target else { panic!() };
    let places = held.iter().map(|&node| both.model.mesh.nodes[node as usize]).collect::<Vec<_>>();
    assert_eq!(places, [[0.0, 0.0], [1.0, 0.0]]);
    let errors = read("*Elset, elset=Set-1\n1\n*Elset, elset=rest\n1\n").unwrap_err().to_string();
    assert!(errors.contains("a group \"rest\", and elements in no group"), "{errors}");
}

#[test]
fn a_mesh_file_has_a_unit() {
    let file = "*Node\n1, 0, 0\n2, 500, 0\n3, 0, 250\n*Element, type=CPS3\n1, 1, 2, 3\n";
    let read = |keys: &str| {
        let text = with_shape(&format!("mesh = \"a.inp\"\n{keys}"));
        fdem_model::prepare(&text, "model.toml", &mut |_| Ok(file.as_bytes().to_vec()))
    };
    for scale in ["\"1 mm\"", "\"mm\"", "0.001"] {
        let mesh = read(&format!("scale = {scale}\n")).unwrap().model.mesh;
        assert_eq!(mesh.nodes, [[0.0, 0.0], [0.5, 0.0], [0.0, 0.25]], "{scale}");
    }
    assert_eq!(read("").unwrap().model.mesh.nodes[1], [500.0, 0.0]);
    for wrong in ["scale = 0", "scale = -1", "scale = \"1 s\""] {
        assert!(read(wrong).unwrap_err().to_string().contains("scale"), "{wrong}");
    }
}

#[test]
fn sets_of_an_abaqus_file_are_materials_and_places_of_boundaries() {
    let file = "*Node\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n5, 0, 2\n*Element, type=CPS4, elset=all\n1, 1, 2, 3, 4\n\
        *Element, type=CPS3, elset=all\n2, 4, 3, 5\n*Elset, elset=upper\n2\n*Nset, nset=base\n1, 2\n\
        *Surface, name=roof\n2, S2\n";
    let keys = "mesh = \"a.inp\"\ngroups = { upper = \"soft\" }\n[[boundary]]\nname = \"hold\"\ngroup = \"base\"\nfixed = \"xy\"\n\
        [[boundary]]\nname = \"push\"\ngroup = \"roof\"\npressure = 1\n\
        [[material]]\nname = \"soft\"\noptional = true\ndensity = 1\nyoungs_modulus = 1\npoissons_ratio = 0";
    let read =
        |text: &str| fdem_model::prepare(text, "model.toml", &mut |_| Ok(file.as_bytes().to_vec())).unwrap();
    let prepared = read(&with_shape(keys));
    let mesh = &prepared.model.mesh;
    assert_eq!(mesh.materials, [1, 1, 0]);
    let fdem_simulation::Target::Nodes(base) = &prepared.model.boundaries[0].target else { panic!() };
    let places = base.iter().map(|&node| mesh.nodes[node as usize]).collect::<Vec<_>>();
    assert_eq!(places, [[0.0, 0.0], [1.0, 0.0]]);
    let fdem_simulation::Target::Facets(roof) = &prepared.model.boundaries[1].target else { panic!() };
    let ends = roof.iter().map(|edge| edge.map(|node| mesh.nodes[node as usize])).collect::<Vec<_>>();
    assert_eq!(ends, [[[1.0, 1.0], [0.0, 2.0]]]);
    assert_eq!(
        prepared.about_files,
        [
            "a.inp: groups are element sets",
            "  all: 3 triangles",
            "  base: 2 nodes",
            "  roof: 1 line",
            "  upper: 1 triangle",
            "  1 quadrilateral is cut into triangles"
        ]
    );
    let only = keys.replace("groups = { upper = \"soft\" }", "only = [\"upper\"]");
    let only = only.replace("group = \"base\"", "side = \"bottom\"");
    assert_eq!(read(&with_shape(&only)).model.mesh.elements.len(), 1);
}

/// A line of two edges inside a square, and one on its border, which is no joint.
const FRACTURE: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 2 \"fracture\"\n2 1 \"rock\"\n$EndPhysicalNames\n\
    $Nodes\n9\n1 0 0 0\n2 1 0 0\n3 2 0 0\n4 0 1 0\n5 1 1 0\n6 2 1 0\n7 0 2 0\n8 1 2 0\n9 2 2 0\n$EndNodes\n$Elements\n11\n\
    1 1 2 2 1 4 5\n2 1 2 2 1 5 6\n11 1 2 2 1 1 2\n3 2 2 1 1 1 2 5\n4 2 2 1 1 1 5 4\n5 2 2 1 1 2 3 6\n6 2 2 1 1 2 6 5\n\
    7 2 2 1 1 4 5 8\n8 2 2 1 1 4 8 7\n9 2 2 1 1 5 6 9\n10 2 2 1 1 5 9 8\n$EndElements\n";

#[test]
fn a_group_of_edges_inside_a_mesh_file_is_a_joint_set() {
    let text = |keys: &str| {
        with_shape(&format!("mesh = \"a.msh\"\n[[joint_set]]\nname = \"f\"\nfriction_angle = 30\n{keys}"))
    };
    let mut load = |_: &str| Ok(FRACTURE.as_bytes().to_vec());
    let prepared = fdem_model::prepare(&text("group = \"fracture\""), "model.toml", &mut load).unwrap();
    let set = &prepared.joint_sets[0];
    assert_eq!((set.joints, set.facets, set.length), (1, 2, Some(2.0)));
    for (keys, part) in [
        ("group = \"fractur\"", "no body has a group \"fractur\""),
        ("group = \"fractur\"\nbodies = [\"block\"]", "has no group \"fractur\""),
        ("group = \"rock\"", "the group \"rock\" has no edge between two elements"),
        ("lines = [[0, 1, 2, 1]]", "all bodies have meshes from files"),
        ("group = \"fracture\"\ndip = 3\nspacing = 1", "by dip and group"),
    ] {
        let told = fdem_model::prepare(&text(keys), "model.toml", &mut load).unwrap_err().to_string();
        let told = told.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ");
        assert!(told.contains(part), "{told}");
    }
}

/// Three grains of two triangles each, in one row; the first two are also a set.
const GRAINS: &str = "*Node\n1,0,0\n2,1,0\n3,2,0\n4,3,0\n5,0,1\n6,1,1\n7,2,1\n8,3,1\n\
    *Element, type=CPE3\n1,1,2,6\n2,1,6,5\n3,2,3,7\n4,2,7,6\n5,3,4,8\n6,3,8,7\n\
    *Elset, elset=poly1\n1,2\n*Elset, elset=poly2\n3,4\n*Elset, elset=poly3\n5,6\n*Elset, elset=left\n1,2,3,4\n";

#[test]
fn grains_of_a_mesh_file_are_joined_by_a_pattern() {
    let text = |between: &str| {
        with_shape(&format!(
            "mesh = \"a.inp\"\n[[joint_set]]\nname = \"grains\"\nfriction_angle = 30\nbetween = {between}"
        ))
    };
    let mut load = |_: &str| Ok(GRAINS.as_bytes().to_vec());
    for (between, facets, length) in [
        (r#"["poly*", "poly*"]"#, 2, 2.0),
        (r#"["poly1", "poly*"]"#, 1, 1.0),
        (r#"["left", "poly3"]"#, 1, 1.0),
        (r#"["p*1", "poly2"]"#, 1, 1.0),
    ] {
        let prepared = fdem_model::prepare(&text(between), "model.toml", &mut load).unwrap();
        let set = &prepared.joint_sets[0];
        assert_eq!((set.facets, set.length), (facets, Some(length)), "{between}");
    }
    for (between, part) in [
        (r#"["poly*", "cell*"]"#, "there is no body and no group of elements \"cell*\""),
        (r#"["poly1", "poly3"]"#, "has no joint in any body"),
        (r#"["left", "poly1"]"#, "has no joint in any body"),
    ] {
        let told = fdem_model::prepare(&text(between), "model.toml", &mut load).unwrap_err().to_string();
        let told = told.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ");
        assert!(told.contains(part), "{told}");
    }
}

/// Two squares with nodes of their own along their common side, and a cohesive element between them.
const GLUED: &str = "*Node\n1,0,0\n2,1,0\n3,1,1\n4,0,1\n5,1,1\n6,0,1\n7,1,2\n8,0,2\n\
    *Element, type=CPE3, elset=rock\n1,1,2,3\n2,1,3,4\n3,6,5,7\n4,6,7,8\n\
    *Element, type=COH2D4, elset=glue\n5,4,3,5,6\n";

#[test]
fn cohesive_elements_of_a_mesh_file_are_a_joint_set() {
    let mut load = |_: &str| Ok(GLUED.as_bytes().to_vec());
    let text =
        with_shape("mesh = \"a.inp\"\n[[joint_set]]\nname = \"glue\"\nfriction_angle = 30\ngroup = \"glue\"");
    let prepared = fdem_model::prepare(&text, "model.toml", &mut load).unwrap();
    let set = &prepared.joint_sets[0];
    assert_eq!((set.joints, set.facets, set.length), (1, 1, Some(1.0)));
    let about = &prepared.about_files;
    assert!(about.iter().any(|line| line == "  glue: 1 line"), "{about:?}");
}

#[test]
fn bodies_are_turned_about_their_middle_and_then_moved() {
    let text = with_shape(
        "rectangle = { min = [0, 0], max = [2, 1] }\nangle = 90\ntranslate = [10, 0]\nmesh_size = 0.25",
    );
    let nodes = right(&text).model.mesh.nodes;
    let extent = |axis: usize| {
        let values = nodes.iter().map(|node| node[axis]);
        [values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max)]
    };
    for (found, expected) in extent(0).into_iter().chain(extent(1)).zip([10.5, 11.5, -0.5, 1.5]) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

/// Coordinates have fewer digits far from 0; shapes of elements have to keep theirs.
#[test]
fn a_body_far_away_has_the_mesh_of_one_that_is_near() {
    let disc = |x: &str| {
        right(&with_shape(&format!("disc = {{ centre = [{x}, 0], radius = 0.025 }}\nmesh_size = 0.001")))
            .model
            .mesh
    };
    let (near, far) = (disc("0"), disc("1e5"));
    assert_eq!(near.elements, far.elements);
    for (a, b) in near.nodes.iter().zip(&far.nodes) {
        let apart = [b[0] - 1e5 - a[0], b[1] - a[1]];
        assert!(apart[0].hypot(apart[1]) < 3e-11, "{a:?} {b:?}");
    }
    let crossing =
        "polygon = { points = [[100000, 0], [100001, 1], [100001, 0], [100000, 1]] }\nmesh_size = 0.1";
    let told = crate::read(&with_shape(crossing)).unwrap_err().to_string();
    assert!(told.contains("from [100000.0, 0.0] to [100001.0, 1.0]"), "{told}");
}
