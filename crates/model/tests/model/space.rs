//! Models in three dimensions: their shapes, groups, boundaries and mistakes.

use fdem_mesh::Corners;
use fdem_model::{AnyPrepared, Prepared, prepare_any};
use fdem_simulation::{Load, Simulation, Target};

const STONE: &str = r#"
[[material]]
name = "stone"
density = 2500
youngs_modulus = 10e9
poissons_ratio = 0.2
"#;

fn any(text: &str) -> Result<AnyPrepared, String> {
    let mut load = |name: &str| match name {
        "two.msh" => Ok(TWO_TETRAHEDRA.as_bytes().to_vec()),
        "two.vtu" => Ok(vtu([[0, 1, 2, 3], [1, 2, 3, 4]], 10, [0.0, 0.0, 1.0]).into_bytes()),
        "cube.stl" => Ok(cube_stl(true).into_bytes()),
        "open.stl" => Ok(cube_stl(false).into_bytes()),
        _ => Err("there is none".to_owned()),
    };
    prepare_any(text, "m.toml", &mut load, None).map_err(|errors| errors.to_string())
}

fn space(bodies: &str) -> Prepared<3, 4> {
    match any(&format!("[model]\nend_time = 1e-3\n{bodies}\n{STONE}")) {
        Ok(AnyPrepared::Space(prepared)) => *prepared,
        Ok(AnyPrepared::Plane(_)) => panic!("it is flat"),
        Err(errors) => panic!("{errors}"),
    }
}

fn wrong(bodies: &str) -> String {
    any(&format!("[model]\nend_time = 1e-3\n{bodies}\n{STONE}")).expect_err("there is a mistake")
}

fn body(shape: &str) -> String {
    format!("[[body]]\nname = \"b\"\nmaterial = \"stone\"\n{shape}\n")
}

fn volume(prepared: &Prepared<3, 4>) -> f64 {
    let mesh = &prepared.model.mesh;
    mesh.elements.iter().map(|nodes| nodes.map(|node| mesh.nodes[node as usize]).measure()).sum()
}

/// Two tetrahedra with a common face, of which the first is a group, and a face of the second.
const TWO_TETRAHEDRA: &str = "$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 3 \"slope\"
3 1 \"one\"
3 2 \"other\"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
3
1 4 2 1 1 1 2 3 4
2 4 2 2 2 2 3 4 5
3 2 2 3 3 2 3 5
$EndElements
";

/// Two elements with a common facet as a VTU file: the origin, points at 1 along x and y, and `last`.
fn vtu<const N: usize>(elements: [[u32; N]; 2], kind: u32, last: [f64; 3]) -> String {
    let mut points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], last];
    if N == 4 {
        points.push([1.0, 1.0, 1.0]);
    }
    let numbers = |all: Vec<String>| all.join(" ");
    let array = |attributes: &str, data: String| {
        format!("<DataArray {attributes} format=\"ascii\">\n{data}\n</DataArray>\n")
    };
    let coordinates = numbers(points.iter().flatten().map(f64::to_string).collect());
    let corners = numbers(elements.iter().flatten().map(u32::to_string).collect());
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"2\">\n<Points>\n{}</Points>\n<Cells>\n{}{}{}</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
        points.len(),
        array("type=\"Float64\" NumberOfComponents=\"3\"", coordinates),
        array("type=\"Int32\" Name=\"connectivity\"", corners),
        array("type=\"Int32\" Name=\"offsets\"", format!("{N} {}", 2 * N)),
        array("type=\"UInt8\" Name=\"types\"", format!("{kind} {kind}"))
    )
}

/// A cube as an STL file; with all of its triangles, or without the last.
fn cube_stl(closed: bool) -> String {
    let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|x| x.to_string()).join(" ");
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut text = "solid cube\n".to_owned();
    let all = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    for triangle in all.take(if closed { 12 } else { 11 }) {
        text += "facet normal 0 0 0\nouter loop\n";
        for k in triangle {
            text += "vertex ";
            text += &corner(k);
            text += "\n";
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid cube\n"
}

#[test]
fn shapes_have_their_volume_and_good_angles() {
    let round = 0.06;
    for (shape, expected, tolerance) in [
        ("box = { min = [0, 0, 0], max = [1, 2, 3] }\nmesh_size = 0.4", 6.0, 1e-12),
        (
            "polyhedron = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.1, 0.1, 0.1]] }\nmesh_size = 0.2",
            1.0 / 6.0,
            1e-12,
        ),
        ("surface = \"cube.stl\"\nmesh_size = 0.3", 1.0, 1e-12),
        (
            "extrusion = { outline = { rectangle = { min = [0, 0], max = [2, 1], holes = [[[0.5, 0.25], [1.5, 0.25], [1.5, 0.75], [0.5, 0.75]]] } }, to = 0.5 }\nmesh_size = 0.2",
            0.75,
            1e-12,
        ),
        (
            "cylinder = { from = [0, 0, 0], to = [0, 0, 2], radius = 0.5 }\nmesh_size = 0.2",
            0.25 * std::f64::consts::PI * 2.0,
            round,
        ),
        (
            "tube = { from = [1, 0, 0], to = [1, 1, 0], radius = 0.5, inner_radius = 0.25 }\nmesh_size = 0.12",
            0.1875 * std::f64::consts::PI,
            round,
        ),
        (
            "sphere = { centre = [0, 0, 5], radius = 1 }\nmesh_size = 0.35",
            4.0 / 3.0 * std::f64::consts::PI,
            round,
        ),
    ] {
        let prepared = space(&body(shape));
        let found = volume(&prepared);
        assert!((found / expected - 1.0).abs() <= tolerance, "{shape}: {found} instead of {expected}");
        assert!(prepared.quality.smallest_angle[0] > 8.0, "{shape}: {:?}", prepared.quality);
        assert_eq!(prepared.warnings, Vec::<String>::new(), "{shape}");
    }
}

#[test]
fn a_seed_gives_one_mesh_and_another_seed_another() {
    let sphere = |seed: u32| {
        space(&body(&format!("sphere = {{ radius = 1 }}\nmesh_size = 0.4\nseed = {seed}"))).model.mesh
    };
    assert_eq!(sphere(3), sphere(3));
    assert_ne!(sphere(3), sphere(4));
}

#[test]
fn faces_are_groups_and_sides_are_along_the_axes() {
    let prepared = space(&format!(
        "{}{}",
        body("box = { min = [0, 0, 0], max = [1, 2, 3] }\nmesh_size = 0.5"),
        "
[[boundary]]
name = \"below\"
side = \"bottom\"
fixed = \"z\"
[[boundary]]
name = \"behind\"
side = \"back\"
velocity = [\"free\", 0.5, \"free\"]
[[boundary]]
name = \"roof\"
group = \"top\"
pressure = 1e5
[[boundary]]
name = \"corner\"
box = [0.9, 1.9, 2.9, 1.1, 2.1, 3.1]
force = [1, 2, 3]
"
    ));
    let model = &prepared.model;
    let nodes = |k: usize| {
        let Target::Nodes(nodes) = &model.boundaries[k].target else { panic!("it acts on nodes") };
        nodes.iter().map(|&node| model.mesh.nodes[node as usize]).collect::<Vec<_>>()
    };
    assert!(nodes(0).len() > 4 && nodes(0).iter().all(|node| node[2] == 0.0));
    assert!(nodes(1).len() > 4 && nodes(1).iter().all(|node| node[1] == 2.0));
    assert_eq!(nodes(3), [[1.0, 2.0, 3.0]]);
    assert_eq!(model.boundaries[1].load, Load::Velocity([None, Some(0.5), None]));
    let Target::Facets(facets) = &model.boundaries[2].target else { panic!("it acts on faces") };
    let area: f64 = facets
        .iter()
        .map(|facet| <[[f64; 3]; 4]>::facet_measure(&facet.map(|node| model.mesh.nodes[node as usize])))
        .sum();
    assert!((area - 2.0).abs() < 1e-12, "{area}");
    assert!(facets.as_flattened().iter().all(|&node| model.mesh.nodes[node as usize][2] == 3.0));
    Simulation::new(model.clone(), 1).expect("it can run");
}

#[test]
fn a_body_is_turned_about_an_axis_and_moved() {
    let prepared = space(&body(
        "box = { min = [0, 0, 0], max = [2, 1, 1] }\nmesh_size = 1\naxis = [0, 2, 0]\nangle = 90\ntranslate = [10, 20, 30]\nvelocity = [1, 2, 3]",
    ));
    let nodes = &prepared.model.mesh.nodes;
    for (axis, [low, high]) in [[10.5, 11.5], [20.0, 21.0], [29.5, 31.5]].into_iter().enumerate() {
        let along = || nodes.iter().map(|node| node[axis]);
        let found = [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)];
        assert!((found[0] - low).abs() < 1e-12 && (found[1] - high).abs() < 1e-12, "{axis}: {found:?}");
    }
    // A turn about y brings the end at greatest x to least z.
    assert!(prepared.model.velocities.iter().all(|velocity| *velocity == [1.0, 2.0, 3.0]));
}

#[test]
fn a_mesh_from_a_file_tells_the_dimensions_and_has_groups() {
    let prepared = space(&format!(
        "{}\n[[boundary]]\nname = \"slope\"\ngroup = \"slope\"\npressure = 1e5\n[[boundary]]\nname = \"held\"\ngroup = \"one\"\nfixed = \"z\"",
        body("mesh = \"two.msh\"")
    ));
    assert_eq!(prepared.model.mesh.elements.len(), 2);
    let Target::Facets(facets) = &prepared.model.boundaries[0].target else { panic!("it acts on faces") };
    assert_eq!(facets.len(), 1);
    let Target::Nodes(nodes) = &prepared.model.boundaries[1].target else { panic!("it acts on nodes") };
    assert_eq!(nodes.len(), 4);
    Simulation::new(prepared.model.clone(), 1).expect("it can run");
    let taken = space(&body("mesh = \"two.msh\"\nonly = [\"other\"]"));
    assert_eq!(taken.model.mesh.elements.len(), 1);
}

#[test]
fn a_vtu_file_is_a_body() {
    let prepared = space(&body("mesh = \"two.vtu\""));
    assert_eq!(prepared.model.mesh.elements.len(), 2);
    assert_eq!(prepared.model.mesh.nodes.len(), 5, "the two hold together");
    assert!((volume(&prepared) - 0.5).abs() < 1e-12);
}

#[test]
fn a_flat_vtu_file_is_a_body_too() {
    let file = vtu([[0, 1, 2], [1, 3, 2]], 5, [1.0, 1.0, 0.0]);
    let text = format!("[model]\nend_time = 1\n{}\n{STONE}", body("mesh = \"flat.vtu\""));
    let prepared = prepare_any(&text, "m.toml", &mut |_| Ok(file.clone().into_bytes()), None);
    let Ok(AnyPrepared::Plane(prepared)) = prepared else { panic!("it is a flat body") };
    let mesh = &prepared.model.mesh;
    let area: f64 =
        mesh.elements.iter().map(|nodes| nodes.map(|node| mesh.nodes[node as usize]).measure()).sum();
    assert_eq!((mesh.nodes.len(), area), (4, 1.0));
}

#[test]
fn the_sharp_edge_that_makes_angles_poor_is_named() {
    let wedge = |height: f64| {
        space(&body(&format!(
            "polyhedron = {{ points = [[0, 0, 0], [1, 0, 0], [1, 0, {height}], [0, 1, 0], [1, 1, 0], [1, 1, {height}]] }}\nmesh_size = 0.2"
        )))
        .warnings
    };
    let [warning] = &wedge(0.1)[..] else { panic!("it has one warning") };
    assert!(warning.contains("\"b\" has an edge of 5.7 degrees from [0, "), "{warning}");
    assert_eq!(wedge(0.5), Vec::<String>::new());
}

#[test]
fn the_sharp_corner_of_a_face_that_makes_angles_poor_is_named() {
    let prepared = space(&body(
        "polyhedron = { points = [[0.522, 0.965, 0.087], [0.429, 0.428, 0.799], [0.439, 0.878, 0.492], [0.413, 0.421, 0.781], [0.113, 0.217, 0.403], [0.957, 0.834, 0.85]] }\nmesh_size = 0.3",
    ));
    let [warning, fine] = &prepared.warnings[..] else { panic!("{:?}", prepared.warnings) };
    assert!(fine.contains("times shorter than theirs"), "{fine}");
    assert!(warning.contains("\"b\" has a face that ends in an angle of 0."), "{warning}");
}

#[test]
fn what_is_wrong_in_space_is_told_at_its_key() {
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.5";
    for (bodies, expected) in [
        (
            format!("{}{}", body(cube), "[[boundary]]\nname = \"f\"\nforce = [1, 2]\n"),
            "\"force\" has 2 numbers, where a model in 3 dimensions has 3",
        ),
        (
            body("box = { min = [0, 0, 0], max = [1, 0, 1] }\nmesh_size = 0.5"),
            "m.toml:6: [[body]] \"b\": the box has no volume: along y its max of 0 is not above its min of 0",
        ),
        (
            body("extrusion = { outline = { disc = { radius = 1 } }, from = 1, to = 0 }\nmesh_size = 0.5"),
            "its \"to\" of 0 is not above its \"from\" of 1",
        ),
        (
            body(
                "extrusion = { outline = { rectangle = { min = [0, 0], max = [1, 0] } }, to = 1 }\nmesh_size = 0.5",
            ),
            "the rectangle has no area",
        ),
        (
            body(
                "extrusion = { outline = { polygon = { points = [[0, 0], [1, 0], [2, 0]] } }, to = 1 }\nmesh_size = 0.5",
            ),
            "the polygon has no area",
        ),
        (
            body(
                "tube = { from = [0, 0, 0], to = [0, 0, 1], radius = 1, inner_radius = 2 }\nmesh_size = 0.5",
            ),
            "its inner radius is not below its radius",
        ),
        (
            body("cylinder = { from = [1, 0, 0], to = [1, 0, 0], radius = 1 }\nmesh_size = 0.5"),
            "\"from\" and \"to\" are the same point",
        ),
        (
            body(
                "polyhedron = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1e-9]] }\nmesh_size = 0.1",
            ),
            "m thick in the mean, and a mesh size of 0.1 m would make flat elements",
        ),
        (
            format!(
                "{}{}",
                body(cube),
                body("disc = { radius = 1 }\nmesh_size = 0.5").replace("\"b\"", "\"c\"")
            ),
            "a disc is no body in 3 dimensions",
        ),
        (body("surface = \"open.stl\"\nmesh_size = 0.5"), "m.toml:6"),
        (body("mesh = \"cube.stl\"\naxis = [0, 0, 1]\nvelocity = [0, 0, 1]"), "m.toml:"),
        (body("sphere = { radius = 1 }\nmesh_size = 0.001"), "the most are"),
        (body("sphere = { radius = -1 }\nmesh_size = 0.1"), "radius"),
        (
            body("polyhedron = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]] }\nmesh_size = 0.1"),
            "the body has no volume",
        ),
        (format!("{}{}", body(cube), "[initial]\nstress = [1, 2, 3]\n"), "write [xx, yy, zz, xy, yz, xz]"),
        (body(&format!("{cube}\naxis = [0, 0, 0]")), "\"axis\" has no direction"),
        (
            format!(
                "{}{}",
                body(cube),
                "[[material]]\nname = \"m\"\ndensity = 1000\nyoungs_modulus = 1e9\npoissons_ratio = 0.5\n"
            ),
            "in three dimensions Poisson's ratio is below 0.5",
        ),
        (
            format!(
                "{}{}{}",
                body(cube),
                "[[boundary]]\nname = \"f\"\nside = \"top\"\nfixed = \"xyz\"\n",
                "[[boundary]]\nname = \"g\"\nside = \"front\"\nvelocity = [\"free\", \"free\", 1]\nramp = 1e-4\n"
            ),
            "\"g\" and \"f\" both prescribe how node",
        ),
        (format!("thickness = 0.1\n{}", body(cube)), "\"thickness\" is for models in two dimensions"),
        (format!("plane = \"strain\"\n{}", body(cube)), "\"plane\" is for models in two dimensions"),
    ] {
        let found = wrong(&bodies);
        assert!(found.contains(expected), "{expected:?} is not in\n{found}");
        assert!(found.contains("m.toml:"), "{found}");
    }
    let flat = "[[body]]\nname = \"b\"\nmaterial = \"stone\"\ndisc = { radius = 1 }\nmesh_size = 0.5\n[[boundary]]\nname = \"f\"\nside = \"front\"\nfixed = \"xz\"\n";
    let found = wrong(flat);
    assert!(
        found.contains("a flat body has no front") && found.contains("cannot be held along z"),
        "{found}"
    );
    let empty = any("[model]\ndimensions = 3\nend_time = 1\n[[body]]\nname = \"b\"\nmaterial = \"stone\"\n");
    assert!(empty.is_err_and(|errors| errors.contains("box, cylinder")));
}

/// Elements between them would use up all memory.
#[test]
fn corners_that_differ_by_rounding_are_refused() {
    let told = "are nearer to each other than a billionth of the shape";
    for shape in [
        "polyhedron = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1e-17]] }",
        "polyhedron = { points = [[1, 0, 0], [6.123e-17, 1, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1]] }",
        "extrusion = { outline = { polygon = { points = [[0, 0], [6e-17, 0], [1, 0], [0, 1]] } }, to = 1 }",
        "extrusion = { outline = { polygon = { points = [[0, 0], [1, 0], [0, 1], [0, 1e-10]] } }, to = 1 }",
    ] {
        let errors = wrong(&body(&format!("{shape}\nmesh_size = 0.4")));
        assert!(errors.contains(told) && errors.lines().count() == 1, "{errors}");
    }
    let near = "polyhedron = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0.01, 0.98]] }";
    space(&body(&format!("{near}\nmesh_size = 0.4")));
}

/// One mistake in a body, or a file that cannot be read, does not make a model flat: there would be errors
/// where nothing is wrong.
#[test]
fn a_mistake_in_a_body_leaves_its_dimensions() {
    let rest = "[[boundary]]\nname = \"f\"\nside = \"bottom\"\nfixed = \"xyz\"\n";
    for (shape, expected) in [
        ("box = { min = [0, 0, 0], max = [1, 1, 1] }\nmeshsize = 0.5", "no key \"meshsize\""),
        ("box = { min = [0, 0], max = [1, 1, 1] }\nmesh_size = 0.5", "\"min\" is a list of 2"),
        ("mesh = \"two.msh\"\nmeshsize = 0.5", "no key \"meshsize\""),
        ("mesh = \"none.msh\"", "cannot read none.msh"),
        ("", "has no shape"),
        (
            "voronoi = { outline = { sphere = { radius = 1 } }, grains = \"many\" }\nmesh_size = 0.5",
            "\"many\" has no value",
        ),
        ("mesh = \"cube.stl\"", "is meshed with surface ="),
        ("mesh = \"cube.stl\"\nmesh_size = 0.5", "is meshed with surface ="),
    ] {
        let errors = wrong(&format!("{}{rest}", body(shape)));
        assert!(errors.contains(expected) && errors.matches("m.toml:").count() == 1, "{errors}");
    }
}

/// Initial stress and its gradient grow with depth, and gravity is along z.
/// σ₁ has a trend and a plunge, σ₂ a rake about it.
#[test]
fn a_stress_in_space_is_given_by_its_principal_values() {
    let stress = |keys: &str| {
        let principal = format!("sigma1 = -30, sigma2 = -20, sigma3 = -10, {keys}");
        let text = format!(
            "[model]\nend_time = 1\ngravity = \"none\"\n[initial]\nprincipal = {{ {principal} }}\n{}{STONE}",
            body("box = { min = [0, 0, 0], max = [1, 1, 2] }\nmesh_size = 0.5")
        );
        match any(&text) {
            Ok(AnyPrepared::Space(prepared)) => prepared.model.stresses[0],
            Ok(_) => panic!("it has three dimensions"),
            Err(why) => panic!("{why}"),
        }
    };
    let along = |stress: [[f64; 3]; 3], direction: [f64; 3]| -> f64 {
        (0..3).map(|i| (0..3).map(|j| stress[i][j] * direction[i] * direction[j]).sum::<f64>()).sum()
    };
    let axes = |stress| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| along(stress, axis));
    for (keys, wanted) in [
        ("trend = 90, plunge = 0", [-30.0, -20.0, -10.0]),
        ("trend = 0, plunge = 0", [-20.0, -30.0, -10.0]),
        ("trend = 0, plunge = 90", [-20.0, -10.0, -30.0]),
        ("trend = 90, plunge = 0, rake = 90", [-30.0, -10.0, -20.0]),
    ] {
        let found = axes(stress(keys));
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{keys}: {found:?}");
    }
    // 30 degrees from north to east, 40 degrees down.
    let found = stress("trend = 30, plunge = 40, rake = -25");
    let (level, down) = (40_f64.to_radians().cos(), 40_f64.to_radians().sin());
    let first = [0.5 * level, 0.75_f64.sqrt() * level, -down];
    assert!((along(found, first) + 30.0).abs() < 1e-12);
    assert!((axes(found).iter().sum::<f64>() + 60.0).abs() < 1e-12);
    // σ₂, turned back by 25 degrees, is horizontal.
    let (sin, cos) = (-25_f64).to_radians().sin_cos();
    let across = [0.75_f64.sqrt(), -0.5, 0.0];
    let steep = [-0.5 * down, -(0.75_f64.sqrt()) * down, -level];
    let second = std::array::from_fn(|k| cos * across[k] + sin * steep[k]);
    assert!((along(found, second) + 20.0).abs() < 1e-12);
}

#[test]
fn initial_stress_is_a_tensor_that_changes_with_height() {
    let text = format!(
        "[model]\nend_time = 1\ngravity = [0, 0, -9.81]\n[initial]\nstress = [-1e6, -2e6, -3e6, 1e5, 2e5, 3e5]\nstress_gradient = [0, 0, 24525, 0, 0, 0]\n{}{STONE}",
        body("box = { min = [0, 0, 0], max = [1, 1, 2] }\nmesh_size = 0.5")
    );
    let Ok(AnyPrepared::Space(prepared)) = any(&text) else { panic!("it is right") };
    let model = &prepared.model;
    assert_eq!(model.gravity, [0.0, 0.0, -9.81]);
    for (nodes, stress) in model.mesh.elements.iter().zip(&model.stresses) {
        let height = nodes.iter().map(|&node| model.mesh.nodes[node as usize][2]).sum::<f64>() / 4.0;
        assert!((stress[2][2] - (-3e6 + 24525.0 * height)).abs() < 1e-6);
        assert_eq!([stress[0][1], stress[1][2], stress[0][2]], [1e5, 2e5, 3e5]);
        assert_eq!([stress[1][0], stress[2][1], stress[2][0]], [1e5, 2e5, 3e5]);
    }
}

/// The warnings of a model whose table `[model]` has these keys.
fn warned(keys: &str, more: &str) -> Vec<String> {
    match any(&format!("[model]\nend_time = 1e-3\n{keys}\n{more}\n{STONE}")) {
        Ok(AnyPrepared::Space(prepared)) => prepared.warnings,
        Ok(AnyPrepared::Plane(_)) => panic!("it is flat"),
        Err(errors) => panic!("{errors}"),
    }
}

/// A box of unit base from this height on, one high.
fn cube(name: &str, bottom: f64) -> String {
    let top = bottom + 1.0;
    body(&format!("box = {{ min = [0, 0, {bottom}], max = [1, 1, {top}] }}\nmesh_size = 0.5"))
        .replace("\"b\"", &format!("\"{name}\""))
}

#[test]
fn bodies_that_overlap_are_warned_of() {
    let two = |bottom: f64| warned("", &(cube("a", 0.0) + &cube("c", bottom)));
    let told = two(0.9);
    let [warning] = &told[..] else { panic!("{told:?}") };
    // Couples of elements that overlap by less than 1e-4 of their volume do not count.
    assert!(warning.starts_with("\"a\" and \"c\" overlap by 0.09998"), "{warning}");
    assert!(
        warning.contains(" m³ at the beginning, in ")
            && warning.contains(" couples of elements, most of all elements "),
        "{warning}"
    );
    assert!(
        warning.contains(" m³: they will be driven apart at once; [contact] initial_overlap = "),
        "{warning}"
    );
    assert_eq!(two(1.0), Vec::<String>::new());
}

#[test]
fn the_model_says_how_bodies_that_overlap_begin() {
    let at = |contact: &str, bottom: f64| {
        let bodies = cube("a", 0.0) + &cube("c", bottom);
        any(&format!("[model]\nend_time = 1e-3\n{contact}\n{bodies}\n{STONE}"))
    };
    let two = |contact: &str| at(contact, 0.9);
    let refused = two("[contact]\ninitial_overlap = \"error\"\n").expect_err("they overlap");
    for part in ["\"a\" and \"c\" overlap by 0.09998", "near [", "take \"ignore\""] {
        assert!(refused.contains(part), "{refused}");
    }
    assert!(at("[contact]\ninitial_overlap = \"error\"\n", 1.0).is_ok());
    let of = |contact: &str| match two(contact) {
        Ok(AnyPrepared::Space(prepared)) => prepared,
        _ => panic!("it is in space"),
    };
    let ignored = of("[contact]\ninitial_overlap = \"ignore\"\n");
    assert!(ignored.warnings.iter().any(|warning| warning.contains("this overlap gives no force")));
    let relaxing = of("[contact]\ninitial_overlap = \"relax\"\noverlap_time = 1e-4\n");
    assert!(relaxing.warnings.iter().any(|warning| warning.contains("pressed apart slowly")));
    let blow = |time: &str| {
        let prepared = of(&format!("[contact]\ninitial_overlap = \"relax\"\n{time}"));
        let warnings = fdem_model::Preflight::of(&*prepared).unwrap().warnings;
        warnings.into_iter().find(|warning| warning.contains("as a blow does"))
    };
    let warning = blow("overlap_time = 1e-6\n").unwrap_or_default();
    assert!(warning.starts_with("[contact] overlap_time is 1e-6 s, and a wave takes "), "{warning}");
    assert_eq!(blow("overlap_time = 1\n"), None);
    let Err(idle) = two("[contact]\noverlap_time = 1e-4\n") else { panic!("the time is of no use") };
    assert!(idle.contains("only an initial overlap that relaxes takes a time"), "{idle}");
    // A body that appears later overlaps from then on.
    let stages =
        "[[stage]]\nname = \"one\"\nduration = 5e-4\n[[stage]]\nname = \"two\"\nactivate = [\"c\"]\n";
    let warning = of(stages).warnings.into_iter().find(|warning| warning.contains("overlap by"));
    let warning = warning.unwrap_or_default();
    assert!(warning.contains(" m³ at the beginning of stage \"two\", in "), "{warning}");
}

#[test]
fn gravity_that_acts_at_once_is_warned_of_where_a_body_rests_on_another() {
    let ground = "[[boundary]]\nname = \"g\"\nbody = \"a\"\nside = \"bottom\"\nfixed = \"xyz\"\n";
    let two = |bottom: f64, keys: &str| {
        let bodies = cube("a", 0.0) + &cube("c", bottom) + ground;
        warned(&format!("gravity = [0, 0, -9.81]\n{keys}"), &bodies)
    };
    for bottom in [1.0, 1.000_000_001] {
        let told = two(bottom, "");
        // 20 passages of a wave of 2000 m/s through 2 m.
        let [warning] = &told[..] else { panic!("{told:?}") };
        assert!(warning.starts_with("gravity acts at once") && warning.contains("= 0.02 in"), "{warning}");
    }
    assert_eq!(two(1.1, ""), Vec::<String>::new());
    assert_eq!(two(1.0, "gravity_ramp = 0.02"), Vec::<String>::new());
}

#[test]
fn initial_stress_out_of_equilibrium_is_warned_of() {
    let absorbing = "[[boundary]]\nname = \"g\"\nside = \"bottom\"\nabsorbing = true\n";
    let heavy = |initial: &str| {
        warned("gravity = [0, 0, -10]", &format!("{}{absorbing}[initial]\n{initial}\n", cube("a", 0.0)))
    };
    let told = heavy("");
    // The nodes on the boundary carry some of the weight.
    assert!(told.iter().any(|told| told.contains("100 % of its weight is not carried")), "{told:?}");
    // Density 2500 kg/m³ and 10 m/s²; no stress at the top.
    let balanced = "stress = [0, 0, -25000, 0, 0, 0]\nstress_gradient = [0, 0, 25000, 0, 0, 0]";
    assert_eq!(heavy(balanced), Vec::<String>::new());

    let two = cube("a", 0.0) + &cube("c", 1.0);
    let pulled = warned("", &format!("{two}[initial]\nstress = [0, 0, 1e6, 0, 0, 0]\n"));
    assert!(pulled.iter().any(|told| told.contains("it pulls them apart")), "{pulled:?}");
    let weak = "tensile_strength = 5e5\ncohesion = 3e6\nfriction_angle = 30\nfracture_energy_i = 1e4\nfracture_energy_ii = 1e4\n";
    let strength = format!("{}[initial]\nstress = [0, 0, 1e6, 0, 2e3, 0]\n{STONE}{weak}", cube("a", 0.0));
    let Ok(AnyPrepared::Space(prepared)) = any(&format!("[model]\nend_time = 1e-3\n{strength}")) else {
        panic!("it is right")
    };
    let told = prepared.warnings.join("\n");
    assert!(told.contains("does not bear [0, 0, 1e6, 0, 2000, 0] Pa in every direction"), "{told}");
}

/// The stiffness is that of the ladder: 12 % with 4 cells through the member where Poisson's ratio is 0.3,
/// which have edges of 1.25 cells.
#[test]
fn members_with_few_elements_through_them_are_warned_of() {
    let held = "[[boundary]]\nname = \"h\"\nside = \"left\"\nfixed = \"xyz\"\n";
    let bar =
        |size: &str| body(&format!("box = {{ min = [0, 0, 0], max = [8, 1, 1] }}\nmesh_size = {size}\n"));
    let told = warned("", &(bar("0.3") + held));
    let [warning] = &told[..] else { panic!("{told:?}") };
    assert!(
        warning.contains("through its thickness of 0.986 m: if it bends, it is about 12 % too stiff"),
        "{warning}"
    );
    let turned = bar("0.3") + "axis = [1, 1, 1]\nangle = 40\n";
    let told = warned("", &(turned + &held.replace("left", "right")));
    // The side of a box that is turned is a corner.
    assert!(told.len() == 2 && told[1].contains("holds one node alone"), "{told:?}");
    assert!(told[0].contains("% too stiff"), "{told:?}");
    // Nothing bends it; it is short; it is held along its whole length.
    assert_eq!(warned("", &bar("0.3")), Vec::<String>::new());
    assert_eq!(warned("", &(cube("a", 0.0) + held)), Vec::<String>::new());
    assert_eq!(warned("", &(bar("0.3") + &held.replace("left", "bottom"))), Vec::<String>::new());
}

/// The ladder measures the figures of this warning.
#[test]
fn a_nearly_incompressible_material_is_told_to_lock() {
    let cube = body("box = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.5");
    let warned = |nu: &str| {
        let text = format!("[model]\nend_time = 1\n{cube}{}", STONE.replace("poissons_ratio = 0.2", nu));
        let Ok(AnyPrepared::Space(prepared)) = any(&text) else { panic!("it is right") };
        prepared.warnings.join("\n")
    };
    assert_eq!(warned("poissons_ratio = 0.45"), "");
    let said = warned("poissons_ratio = 0.49");
    assert!(
        said.contains("elements lock") && said.contains("up to 15 %") && said.contains("up to 4 %"),
        "{said}"
    );
    assert!(warned("poissons_ratio = 0.4999").contains("more than 24 %"));
}

/// Grains share nodes, have their materials, and fill the outline.
#[test]
fn grains_fill_their_outline() {
    let prepared = space(&format!(
        "{}{}",
        body(
            "voronoi = { outline = { box = { min = [0, 0, 0], max = [1, 1, 1] } }, grains = 6, materials = [\"stone\", \"other\"] }\nmesh_size = 0.2"
        ),
        STONE.replace("\"stone\"", "\"other\"")
    ));
    assert!((volume(&prepared) - 1.0).abs() < 1e-12);
    let mut grains = prepared.grains.clone();
    grains.sort_unstable();
    grains.dedup();
    assert_eq!(grains, [0, 1, 2, 3, 4, 5]);
    let materials = &prepared.model.mesh.materials;
    assert!(materials.contains(&0) && materials.contains(&1));
    for (grain, material) in prepared.grains.iter().zip(materials) {
        let first = prepared.grains.iter().position(|other| other == grain).expect("it is there");
        assert_eq!(*material, materials[first], "a grain has one material");
    }
    let of = "voronoi = { outline = { cylinder = { from = [0, 0, 0], to = [0, 0, 2], radius = 0.5 } }, grains = 6 }\nmesh_size = 0.15";
    let prepared = space(&body(of));
    // The mantle is a polygon with corners on the circle.
    let exact = 0.5 * std::f64::consts::PI;
    assert!((0.97..1.0).contains(&(volume(&prepared) / exact)), "{}", volume(&prepared) / exact);
    let prepared = space(&body(
        "voronoi = { outline = { sphere = { centre = [1, 2, 3], radius = 0.5 } }, grains = 8 }\nmesh_size = 0.12",
    ));
    let exact = std::f64::consts::PI / 6.0;
    assert!((0.97..1.0).contains(&(volume(&prepared) / exact)), "{}", volume(&prepared) / exact);
    let mut grains = prepared.grains.clone();
    grains.sort_unstable();
    grains.dedup();
    assert_eq!(grains, [0, 1, 2, 3, 4, 5, 6, 7]);
    let cube = body("box = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.5").replace("\"b\"", "\"c\"");
    let flat = body("voronoi = { outline = { disc = { radius = 1 } }, grains = 3 }\nmesh_size = 0.2");
    let found = wrong(&format!("{cube}{flat}"));
    assert!(
        found
            .contains("an outline of grains in three dimensions is one of box, polyhedron, cylinder, sphere"),
        "{found}"
    );
}
