//! Packings in three dimensions, and copies of a shape in both.

use fdem_mesh::Corners;
use fdem_model::{AnyPrepared, Prepared, prepare_any};

const STONE: &str =
    "[[material]]\nname = \"stone\"\ndensity = 2500\nyoungs_modulus = 10e9\npoissons_ratio = 0.2\n";

fn any(packing: &str, size: f64) -> Result<AnyPrepared, String> {
    let text = format!(
        "[model]\nend_time = 1e-3\n[[body]]\nname = \"heap\"\nmaterial = \"stone\"\nmesh_size = {size}\npacking = {packing}\n{STONE}"
    );
    let mut load = |name: &str| match name {
        "balls.csv" => Ok(b"x,y,z,radius\n0,0,0,0.5\n1,0,0,0.4\n0,0,2,0.3\n".to_vec()),
        "discs.csv" => Ok(b"x,y,radius\n0,0,0.5\n1,0,0.4\n".to_vec()),
        _ => Err("there is none".to_owned()),
    };
    prepare_any(&text, "m.toml", &mut load, None).map_err(|errors| errors.to_string())
}

fn space(packing: &str, size: f64) -> Prepared<3, 4> {
    match any(packing, size) {
        Ok(AnyPrepared::Space(prepared)) => *prepared,
        Ok(AnyPrepared::Plane(_)) => panic!("it is flat"),
        Err(errors) => panic!("{errors}"),
    }
}

fn plane(packing: &str, size: f64) -> Prepared {
    match any(packing, size) {
        Ok(AnyPrepared::Plane(prepared)) => *prepared,
        Ok(AnyPrepared::Space(_)) => panic!("it is not flat"),
        Err(errors) => panic!("{errors}"),
    }
}

fn wrong(packing: &str, told: &str) {
    let errors = any(packing, 0.1).expect_err(packing);
    assert!(errors.contains(told), "{errors}");
}

/// The nodes of each body.
fn nodes<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Vec<&[[f64; D]]> {
    let range = |body: &fdem_model::PreparedBody| body.nodes.start as usize..body.nodes.end as usize;
    prepared.bodies.iter().map(|body| &prepared.model.mesh.nodes[range(body)]).collect()
}

/// Area or volume of each body.
fn measures<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Vec<f64>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let mesh = &prepared.model.mesh;
    let mut measures = vec![0.0; prepared.bodies.len()];
    for (element, &body) in mesh.elements.iter().zip(&mesh.bodies) {
        measures[body as usize] += element.map(|node| mesh.nodes[node as usize]).measure();
    }
    measures
}

fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// The least distance between nodes of two bodies.
fn nearest<const D: usize>(bodies: &[&[[f64; D]]]) -> f64 {
    let mut least = f64::INFINITY;
    for (number, one) in bodies.iter().enumerate() {
        for other in &bodies[number + 1..] {
            for a in *one {
                least = other.iter().map(|b| distance(a, b)).fold(least, f64::min);
            }
        }
    }
    least
}

#[test]
fn spheres_and_polyhedra_at_random_places_lie_in_the_box_and_do_not_overlap() {
    for (shape, groups) in [("", 30), ("shape = \"polyhedron\", corners = [6, 9], ", 5 * 30)] {
        let packing = format!(
            "{{ {shape}count = 30, radius = [0.05, 0.1], within = {{ min = [0, 0, 0], max = [1, 1, 0.5] }}, gap = 0.01 }}"
        );
        let prepared = space(&packing, 0.06);
        assert_eq!((prepared.bodies.len(), prepared.bodies[6].name.as_str()), (30, "heap-7"));
        assert!(prepared.warnings.is_empty(), "{:?}", prepared.warnings);
        assert!(prepared.groups.len() >= groups, "{}", prepared.groups.len());
        let bodies = nodes(&prepared);
        assert!(nearest(&bodies) >= 0.01 - 1e-12);
        for [x, y, z] in &prepared.model.mesh.nodes {
            assert!((0.01..=0.99).contains(x) && (0.01..=0.99).contains(y) && (0.01..=0.49).contains(z));
        }
        let widest = bodies.iter().map(|nodes| {
            nodes.iter().flat_map(|a| nodes.iter().map(move |b| distance(a, b))).fold(0.0, f64::max)
        });
        assert!(widest.into_iter().all(|widest| (0.08..0.2 + 1e-12).contains(&widest)));
        assert!(prepared.quality.smallest_angle[0] > 8.0, "{:?}", prepared.quality);
        assert_eq!(space(&packing, 0.06).hash, prepared.hash);
        let other = space(&packing.replace("gap", "seed = 2, gap"), 0.06);
        assert_ne!(other.hash, prepared.hash);
    }
}

#[test]
fn copies_of_a_box_fill_a_cylinder_each_turned_another_way() {
    let within = "within = { cylinder = { from = [0, 0, 0], to = [1, 1, 1], radius = 0.4 } }";
    let copies = "copies_of = { box = { min = [5, 5, 5], max = [5.1, 5.2, 5.3] } }";
    let prepared = space(&format!("{{ {copies}, count = 6, {within} }}"), 0.1);
    let bodies = nodes(&prepared);
    assert_eq!(bodies.len(), 6);
    assert!(prepared.warnings.is_empty(), "{:?}", prepared.warnings);
    for volume in measures(&prepared) {
        assert!((volume - 0.006).abs() < 1e-12, "{volume}");
    }
    let along = 1.0 / 3.0_f64.sqrt();
    let mut highest = Vec::new();
    for nodes in &bodies {
        for node in *nodes {
            let far = along * node.iter().sum::<f64>();
            assert!((0.0..=3.0_f64.sqrt()).contains(&far), "{node:?}");
            let across = distance(node, &[far * along; 3]);
            assert!(across < 0.4, "{node:?}");
        }
        let heights = nodes.iter().map(|node| node[2]);
        highest
            .push(heights.clone().fold(f64::NEG_INFINITY, f64::max) - heights.fold(f64::INFINITY, f64::min));
    }
    highest.sort_by(f64::total_cmp);
    assert!(highest.windows(2).all(|pair| pair[1] - pair[0] > 1e-3), "turned alike: {highest:?}");
    let fronts = prepared.groups.iter().filter(|group| group.name == "front").count();
    assert_eq!(fronts, 6);
}

#[test]
fn copies_have_the_radius_that_the_packing_gives_them() {
    // A cylinder as long as wide has half the square root of 2 of its length as radius of the sphere around
    // it.
    let copies = "copies_of = { cylinder = { from = [0, 0, 0], to = [0, 0, 2], radius = 1 } }";
    let within = "within = { min = [0, 0, 0], max = [1, 1, 1] }";
    let radius = 0.2_f64;
    let prepared =
        space(&format!("{{ {copies}, count = 3, radius = [{radius}, {radius}], {within} }}"), 0.05);
    for nodes in nodes(&prepared) {
        let widest = nodes.iter().flat_map(|a| nodes.iter().map(move |b| distance(a, b))).fold(0.0, f64::max);
        assert!((0.98 * 2.0 * radius..2.0 * radius + 1e-12).contains(&widest), "{widest}");
    }
    let whole = std::f64::consts::PI * 2.0 * (radius / 2.0_f64.sqrt()).powi(3);
    for volume in measures(&prepared) {
        assert!((0.9 * whole..whole).contains(&volume), "{volume} of {whole}");
    }
}

#[test]
fn flat_shapes_are_copied_too() {
    let within = "within = { min = [0, 0], max = [4, 4] }";
    let bar =
        "{ rectangle = { min = [0, 0], max = [1, 0.2], holes = [{ centre = [0.5, 0.1], radius = 0.05 }] } }";
    let prepared = plane(&format!("{{ copies_of = {bar}, count = 5, {within}, gap = 0.05 }}"), 0.05);
    assert_eq!(prepared.bodies.len(), 5);
    let hole = std::f64::consts::PI * 0.05 * 0.05;
    assert!(measures(&prepared).iter().all(|area| (area - 0.2 + hole).abs() < 0.2 * hole));
    assert!(nearest(&nodes(&prepared)) > 0.05);
    assert!(prepared.warnings.is_empty(), "{:?}", prepared.warnings);
    let ring = "{ ring = { radius = 1, inner_radius = 0.5 } }";
    let prepared = plane(&format!("{{ copies_of = {ring}, count = 4, radius = [0.3, 0.5], {within} }}"), 0.1);
    for (area, nodes) in measures(&prepared).into_iter().zip(nodes(&prepared)) {
        let low = nodes.iter().map(|node| node[0]).fold(f64::INFINITY, f64::min);
        let high = nodes.iter().map(|node| node[0]).fold(f64::NEG_INFINITY, f64::max);
        let full = 0.75 * std::f64::consts::PI * (0.5 * (high - low)).powi(2);
        assert!((0.85 * full..full).contains(&area), "{area} of {full}");
    }
}

#[test]
fn a_file_with_z_is_a_packing_of_spheres() {
    let prepared = space("{ file = \"balls.csv\" }", 0.2);
    let tops = nodes(&prepared)
        .into_iter()
        .map(|nodes| nodes.iter().map(|node| distance(node, &[0.0, 0.0, 2.0])).fold(f64::INFINITY, f64::min));
    let tops: Vec<f64> = tops.collect();
    assert_eq!(tops.len(), 3);
    assert!(tops[2] < 0.2 && tops[0] > 1.4, "{tops:?}");
    wrong(
        "{ file = \"balls.csv\", shape = \"disc\" }",
        "balls.csv has z: a packing of discs has x, y and radius",
    );
    wrong("{ file = \"discs.csv\", shape = \"sphere\" }", "discs.csv has no z: a packing of spheres");
}

/// A packing in millimetres is not taken as one in metres, and the model has the notes of `fdem contacts`.
#[test]
fn the_file_of_a_packing_has_a_unit_and_notes() {
    let read = |file: &str, keys: &str| {
        let text = format!(
            "[model]\nend_time = 1e-3\n[[body]]\nname = \"heap\"\nmaterial = \"stone\"\nmesh_size = 0.2\npacking = {{ file = \"a.csv\" }}\n{keys}{STONE}"
        );
        let prepared = prepare_any(&text, "m.toml", &mut |_| Ok(file.as_bytes().to_vec()), None);
        prepared.map_err(|errors| errors.to_string())
    };
    let area = |file: &str, keys: &str| match read(file, keys) {
        Ok(AnyPrepared::Plane(prepared)) => (measures(&prepared)[0], prepared.warnings),
        Ok(AnyPrepared::Space(_)) => panic!("it is not flat"),
        Err(errors) => panic!("{errors}"),
    };
    let discs = "x,y,radius\n0,0,500\n2000,0,400\n";
    let with_unit = discs.replace("x,y,radius", "x [mm],y [mm],radius [mm]");
    for (file, keys) in [(discs, "scale = \"1 mm\"\n"), (&with_unit, ""), (&with_unit, "scale = 0.001\n")] {
        let (area, warnings) = area(file, keys);
        assert!((0.7..0.786).contains(&area), "{keys}: {area}");
        let noted = warnings.iter().any(|warning| warning.contains("in mm, which is taken as 0.001 m"));
        assert_eq!(noted, keys.is_empty(), "{warnings:?}");
        assert!(!warnings.iter().any(|warning| warning.contains("scale changes nothing")), "{warnings:?}");
    }
    let (_, warnings) = area("x,y,zz,radius\n0,0,1,0.5\n2,0,1,0.4\n", "");
    assert!(warnings.iter().any(|warning| warning.contains("a.csv: column zz is not used")), "{warnings:?}");
    let (_, warnings) = area("##PERIODIC:: 9 9 0.5\n1 1 0.1 0.5\n3 1 0.1 0.5\n", "");
    for part in ["a.csv: read in 2D", "its periodic box is not used"] {
        assert!(warnings.iter().any(|warning| warning.contains(part)), "{part}: {warnings:?}");
    }
    let errors = read(&with_unit.replace("mm", "furlong"), "").err().unwrap_or_default();
    assert!(errors.contains("in furlong, which is no length known here"), "{errors}");
}

#[test]
fn packings_in_space_that_cannot_be_are_refused() {
    let within = "within = { min = [0, 0, 0], max = [1, 1, 1] }";
    let cylinder = "within = { cylinder = { from = [0, 0, 0], to = [0, 0, 1], radius = 0.5 } }";
    let boxes = "copies_of = { box = { min = [0, 0, 0], max = [0.2, 0.2, 0.2] } }";
    for (packing, told) in [
        (format!("count = 300, radius = [0.1, 0.1], {within}"), "300 spheres fill 1.25664 times the box"),
        (
            format!("count = 120, radius = [0.1, 0.1], {within}"),
            "of 120 found room: take fewer or smaller ones, or a larger box",
        ),
        (
            format!("count = 1, radius = [0.45, 0.45], gap = 0.1, {cylinder}"),
            "only 0 of 1 found room: take fewer or smaller ones, or a larger cylinder",
        ),
        (
            format!("count = 2, radius = [0.1, 0.1], shape = \"disc\", {within}"),
            "\"packing.within.min\" has 3 numbers",
        ),
        (
            format!("count = 2, shape = \"sphere\", {boxes}, {within}"),
            "a packing has a shape or copies_of, not both",
        ),
        (
            format!(
                "count = 2, radius = [0.1, 0.1], copies_of = {{ ring = {{ radius = 1, inner_radius = 0.5 }} }}, {within}"
            ),
            "\"packing.within.min\" has 3 numbers",
        ),
        (
            format!("count = 2, copies_of = {{ surface = \"none.stl\" }}, {within}"),
            "cannot read none.stl: there is none",
        ),
        (
            format!(
                "count = 2, copies_of = {{ tube = {{ from = [0, 0, 0], to = [0, 0, 1], radius = 1, inner_radius = 2 }} }}, {within}"
            ),
            "the tube has no wall",
        ),
        (
            format!("count = 2, copies_of = {{}}, {within}"),
            "copies are those of one of box, cylinder, tube, polyhedron, surface, extrusion",
        ),
        (
            format!("shape = \"polyhedron\", corners = [3, 5], count = 2, radius = [0.1, 0.1], {within}"),
            "a polyhedron has 4 corners or more",
        ),
        (format!("count = 2, {within}"), "a packing has a file, or count, radius and within"),
        (
            "count = 2, radius = [0.1, 0.1], within = { min = [0, 0, 1], max = [1, 1, 1] }".to_owned(),
            "the box has no volume",
        ),
        (
            "count = 2, radius = [0.1, 0.1], within = { min = [0, 0, 1] }".to_owned(),
            "the region of a packing has min and max, or a cylinder",
        ),
    ] {
        wrong(&format!("{{ {packing} }}"), told);
    }
}

#[test]
fn copies_of_a_file_read_it_once() {
    let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|facet: [usize; 3]| {
        let corners = facet.map(|k| format!("vertex {}\n", corners[k])).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    });
    let stl = format!("solid stone\n{}endsolid stone\n", facets.concat());
    let text = format!(
        "[model]\nend_time = 1e-3\n[[body]]\nname = \"heap\"\nmaterial = \"stone\"\nmesh_size = 0.1\npacking = {{ copies_of = {{ surface = \"stone.stl\" }}, count = 4, radius = [0.1, 0.2], within = {{ min = [0, 0, 0], max = [1, 1, 1] }} }}\n{STONE}"
    );
    let mut reads = 0;
    let mut load = |_: &str| {
        reads += 1;
        Ok(stl.as_bytes().to_vec())
    };
    // A run keeps its input files, in order: each read is a file in its folder.
    let AnyPrepared::Space(prepared) = prepare_any(&text, "m.toml", &mut load, None).unwrap() else {
        panic!("it is flat")
    };
    assert_eq!((prepared.bodies.len(), reads), (4, 1));
}
