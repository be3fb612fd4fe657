//! Settings that may not be meant in three dimensions, and refusals there before they cost minutes.

use std::fmt::Write;

use fdem_model::{AnyPrepared, Preflight, Prepared, prepare_any};

const STONE: &str =
    "[[material]]\nname = \"stone\"\ndensity = 2500\nyoungs_modulus = 10e9\npoissons_ratio = 0.2\n";

/// A model of one body, with this file.
fn any(general: &str, body: &str, file: &str) -> Result<AnyPrepared, String> {
    let text = format!(
        "[model]\nend_time = 1e-3\n{general}\n[[body]]\nname = \"b\"\nmaterial = \"stone\"\n{body}\n{STONE}"
    );
    prepare_any(&text, "m.toml", &mut |_| Ok(file.as_bytes().to_vec()), None)
        .map_err(|errors| errors.to_string())
}

fn space(general: &str, body: &str, file: &str) -> Prepared<3, 4> {
    match any(general, body, file) {
        Ok(AnyPrepared::Space(prepared)) => *prepared,
        Ok(AnyPrepared::Plane(_)) => panic!("it is flat"),
        Err(errors) => panic!("{errors}"),
    }
}

/// Cubes with edges of `width` at these places, as an STL file.
fn cubes(width: f64, places: &[[f64; 3]]) -> String {
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut text = "solid cubes\n".to_owned();
    for place in places {
        for triangle in quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]) {
            text += "facet normal 0 0 0\nouter loop\n";
            for k in triangle {
                let corner = [k & 1, k >> 1 & 1, k >> 2];
                let [x, y, z] = [0, 1, 2].map(|axis| place[axis] + width * f64::from(corner[axis]));
                text.push_str(&["vertex ", &format!("{x} {y} {z}"), "\n"].concat());
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid cubes\n"
}

#[test]
fn a_surface_of_parts_that_do_not_touch_is_warned_of() {
    let body = "surface = \"a.stl\"\nmesh_size = 0.5";
    let one = space("", body, &cubes(1.0, &[[0.0; 3]]));
    assert_eq!(one.warnings, Vec::<String>::new());
    let two = space("", body, &cubes(1.0, &[[0.0; 3], [3.0, 0.0, 0.0]]));
    let told = "[[body]] \"b\": its mesh falls into 2 pieces that have no node in common";
    assert!(two.warnings.len() == 1 && two.warnings[0].starts_with(told), "{:?}", two.warnings);
}

/// Cubes with edges of 1 of six tetrahedra each, whose corners are these, as a Gmsh file. Equal corners are
/// one node if `merged`.
fn cubes_msh(places: &[[f64; 3]], merged: bool) -> String {
    let (mut nodes, mut elements): (Vec<[f64; 3]>, Vec<[usize; 4]>) = (Vec::new(), Vec::new());
    for place in places {
        let numbers: Vec<usize> = (0..8)
            .map(|k| {
                let corner = [0, 1, 2].map(|axis| place[axis] + f64::from(k >> axis & 1));
                let known = nodes.iter().position(|node| merged && *node == corner);
                known.unwrap_or_else(|| {
                    nodes.push(corner);
                    nodes.len() - 1
                })
            })
            .collect();
        // Along the diagonal from corner 0 to corner 7.
        for [a, b] in [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]] {
            elements.push([0, a, b, 7].map(|k| numbers[k] + 1));
        }
    }
    let line = |numbers: Vec<String>| numbers.join(" ");
    let lines = |lines: Vec<String>| lines.join("\n");
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{}\n$EndNodes\n$Elements\n{}\n{}\n$EndElements\n",
        nodes.len(),
        lines(
            (1..)
                .zip(&nodes)
                .map(|(k, node)| format!("{k} {}", line(node.map(|x| x.to_string()).into())))
                .collect()
        ),
        elements.len(),
        lines(
            (1..)
                .zip(&elements)
                .map(|(k, nodes)| format!("{k} 4 2 1 1 {}", line(nodes.map(|k| k.to_string()).into())))
                .collect()
        )
    )
}

#[test]
fn parts_of_a_mesh_that_overlap_are_warned_of_with_two_elements() {
    let warnings =
        |second: [f64; 3]| space("", "mesh = \"a.msh\"", &cubes_msh(&[[0.0; 3], second], false)).warnings;
    let found = warnings([0.75, 0.25, 0.25]);
    let told = found.iter().find(|told| told.contains("overlap")).unwrap();
    for part in
        ["[[body]] \"b\": parts of its mesh that share no nodes overlap by 0.140625 m³", "elements ", " and "]
    {
        assert!(told.contains(part), "{part} is not in {told}");
    }
    // Side by side they only touch.
    let found = warnings([1.0, 0.0, 0.0]);
    assert!(found.len() == 1 && !found[0].contains("overlap"), "{found:?}");
}

#[test]
fn parts_of_a_mesh_that_share_only_an_edge_or_a_node_are_warned_of() {
    let warnings =
        |second: [f64; 3]| space("", "mesh = \"a.msh\"", &cubes_msh(&[[0.0; 3], second], true)).warnings;
    for (second, at) in [([1.0, 1.0, 0.0], "[1, 1, 0]"), ([1.0; 3], "[1, 1, 1]")] {
        let told = format!(
            "[[body]] \"b\": its mesh has 2 parts of which some share only nodes or edges, as at {at}: elements hold together at common faces only"
        );
        let found = warnings(second);
        assert!(found.len() == 1 && found[0].starts_with(&told), "{found:?}");
    }
    assert_eq!(warnings([1.0, 0.0, 0.0]), Vec::<String>::new());
}

#[test]
fn a_surface_that_gives_too_many_elements_is_refused_at_its_mesh_size() {
    let refused = |width: f64, size: f64, more: &str| {
        let body = format!("surface = \"a.stl\"\nmesh_size = {size}\n{more}");
        any("", &body, &cubes(width, &[[0.0; 3]])).unwrap_err()
    };
    let fine = refused(1.0, 1.0 / 200.0, "");
    for part in [
        "m.toml:8:",
        "a mesh size of 0.005 m gives about 8e7 elements; the most are 20,000,000",
        "take a larger mesh_size",
    ] {
        assert!(fine.contains(part), "{part} is not in {fine}");
    }
    assert!(!fine.contains("millimetres"), "{fine}");
    assert!(refused(100.0, 0.005, "").contains("100 x 100 x 100 m wide, 20000 times its mesh_size"));
    let coarse = refused(100.0, 0.005, "fine = true");
    for part in ["about 8e13 elements", "the body is 100 m wide, 20000 times mesh_size", "scale = \"1 mm\""] {
        assert!(coarse.contains(part), "{part} is not in {coarse}");
    }
}

#[test]
fn a_boundary_on_one_node_of_a_body_is_warned_of() {
    let boundary = |place: &str, load: &str| format!("[[boundary]]\nname = \"foot\"\n{place}\n{load}");
    let warnings = |body: &str, boundary: &str| space("", &format!("{body}\n{boundary}"), "").warnings;
    let sphere = "sphere = { radius = 1 }\nmesh_size = 0.4";
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.4";
    for (load, what) in [
        ("fixed = \"xyz\"", "holds"),
        ("force = [0, 0, 1]", "loads"),
        ("velocity = [0, 0, 1]\nramp = 1e-3", "moves"),
    ] {
        let found = warnings(sphere, &boundary("side = \"bottom\"", load));
        let told = format!("[[boundary]] \"foot\" {what} one node alone of the ");
        assert!(found.len() == 1 && found[0].starts_with(&told), "{load}: {found:?}");
        assert_eq!(warnings(cube, &boundary("side = \"bottom\"", load)), Vec::<String>::new());
    }
    let corner = boundary("box = [-0.1, -0.1, -0.1, 0.1, 0.1, 0.1]", "fixed = \"xyz\"");
    assert!(warnings(cube, &corner)[0].contains("holds one node alone"));
}

#[test]
fn tetrahedra_that_are_turned_are_counted() {
    let mesh = |elements: &str| {
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 3 \"slope\"\n3 1 \"all\"\n$EndPhysicalNames\n\
             $Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n$Elements\n{elements}$EndElements\n"
        )
    };
    let warnings = |elements: &str| space("", "mesh = \"a.msh\"", &mesh(elements)).warnings;
    let right = "7 4 2 1 1 1 2 3 4\n8 4 2 1 1 2 3 4 5\n";
    assert_eq!(warnings(&format!("3\n{right}9 2 2 3 3 2 3 5\n")), Vec::<String>::new());
    let found = warnings("2\n7 4 2 1 1 1 2 3 4\n8 4 2 1 1 3 2 4 5\n");
    assert_eq!(
        found,
        [
            "[[body]] \"b\": a.msh: 1 of its 2 tetrahedra have a negative volume, the first is element 8: their nodes are taken in the other order"
        ]
    );
    // A triangle between nodes of the mesh that is a face of no tetrahedron, and two.
    let found = warnings(&format!("3\n{right}9 2 2 3 3 1 2 5\n"));
    assert_eq!(
        found,
        [
            "[[body]] \"b\": a.msh: element 9 (triangle of the group \"slope\") belongs to no tetrahedron: boundaries do not act on it"
        ]
    );
    let found = warnings(&format!("5\n{right}9 2 2 3 3 2 3 5\n10 2 2 3 3 1 2 5\n11 2 2 3 3 1 3 5\n"));
    assert_eq!(
        found,
        [
            "[[body]] \"b\": a.msh: 2 triangles belong to no tetrahedron, the first is element 10 of the group \"slope\": boundaries do not act on them"
        ]
    );
}

#[test]
fn memory_is_that_of_the_frames_that_a_run_has() {
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.5\n";
    let preflight = |interval: &str| {
        Preflight::of(&space("", &format!("{cube}[output]\ninterval = {interval}"), "")).unwrap()
    };
    // A frame each step, and a thousand frames per step.
    let each = preflight("1e-6");
    let more = preflight("1e-12");
    assert!(each.steps < 1000, "{}", each.steps);
    assert_eq!(each.memory, more.memory);
}

#[test]
fn a_time_step_above_the_critical_one_is_warned_of() {
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.5\n";
    let preflight = Preflight::of(&space("time_step = 1e-3", cube, "")).unwrap();
    assert!(preflight.warnings.iter().any(|told| told.contains("the run will not be stable")));
}

#[test]
fn messages_in_three_dimensions_have_its_words() {
    let refused = |general: &str, body: &str| any(general, body, "").unwrap_err();
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1] }\nmesh_size = 0.5\n";
    let told = refused("gravity_ramp = 1", cube);
    assert!(told.contains("[0, 0, -9.81]"), "{told}");
    let told = refused("", &format!("{cube}[[history]]\nname = \"h\""));
    assert!(told.contains("node = [x, y] or [x, y, z]"), "{told}");
    let told = refused("", "polyhedron = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0]] }\nmesh_size = 0.5");
    assert!(told.contains("a polyhedron has four corners or more") && !told.contains("polygon"), "{told}");
    let told = refused("", &format!("{cube}[[boundary]]\nname = \"b\"\nside = \"under\"\nfixed = \"z\""));
    assert_eq!(told.matches("\"left\", \"right\"").count(), 1, "{told}");
    let grains =
        |of: &str| refused("", &format!("voronoi = {{ outline = {{ {of} }}, grains = 5 }}\nmesh_size = 0.2"));
    let told = grains("tube = { from = [0, 0, 0], to = [0, 0, 1], radius = 1, inner_radius = 0.5 }");
    assert!(
        told.contains("its keys are")
            && ["box", "polyhedron", "cylinder", "sphere"].iter().all(|key| told.contains(key)),
        "{told}"
    );
    let told = grains("box = { min = [0, 0, 0], max = [1, 1, 1] }, sphere = { radius = 1 }");
    assert!(told.contains("an outline is one shape, and this has two"), "{told}");
    let told = refused("", "sphere = { centre = [1e16, 0, 0], radius = 1 }\nmesh_size = 0.5");
    assert!(told.contains("m.toml:7: [[body]] \"b\" is 2 m wide and 1e16 m from the origin"), "{told}");
    let told = refused(
        "",
        "extrusion = { outline = { rectangle = { min = [0, 0], max = [1, 1], holes = [{ centre = [3, 3], radius = 0.1 }] } }, from = 0, to = 1 }\nmesh_size = 0.5",
    );
    assert!(told.contains("hole 1 is not inside the outline"), "{told}");
    let told = grains("cylinder = { from = [0, 0, 1], to = [0, 0, 1], radius = 1 }");
    assert!(told.contains("it has no length"), "{told}");
}

/// A plate that is held at one edge bends, however wide it is; one that lies on its face does not.
#[test]
fn a_plate_with_few_elements_through_it_is_told_to_be_too_stiff() {
    let warned = |held: &str, load: &str| {
        let body = format!(
            "box = {{ min = [0, 0, 0], max = [1, 1, 0.05] }}\nmesh_size = 0.1\n[[boundary]]\nname = \"held\"\nbody = \"b\"\nside = \"{held}\"\nfixed = \"xyz\"\n[[boundary]]\nname = \"load\"\nbody = \"b\"\nside = \"{load}\"\npressure = 1e3\nramp = 1e-3"
        );
        space("", &body, "").warnings.iter().any(|warning| warning.contains("too stiff"))
    };
    assert!(warned("left", "top"));
    assert!(!warned("bottom", "top"));
}

#[test]
fn keys_without_effect_in_three_dimensions_are_told() {
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1] }";
    let turned = space("", &format!("{cube}\nmesh_size = 0.5\naxis = [1, 0, 0]"), "");
    assert_eq!(turned.warnings, ["[[body]] \"b\": axis changes nothing here"]);
    let grains = format!("voronoi = {{ outline = {{ {cube} }}, grains = 4, rounds = 9 }}\nmesh_size = 0.2");
    let warnings = space("", &grains, "").warnings;
    let told = "[[body]] \"b\": voronoi.rounds changes nothing here";
    assert!(warnings.iter().any(|warning| warning == told), "{warnings:?}");
}

#[test]
fn grains_that_are_too_thin_for_the_size_are_named() {
    let grains =
        "voronoi = { outline = { box = { min = [0, 0, 0], max = [1, 1, 1] } }, grains = 400 }\nmesh_size = 5";
    let error = any("dimensions = 3", grains, "").map(|_| ()).unwrap_err();
    assert!(error.contains("a grain is") && error.contains("fewer grains"), "{error}");
}

/// An extrusion of a sphere has no mesh, and so no distance from the origin.
#[test]
fn a_shape_that_cannot_be_has_one_error() {
    let body = "extrusion = { outline = { sphere = { radius = 1 } }, to = 1 }\nmesh_size = 0.5";
    let error = any("", body, "").map(|_| ()).unwrap_err();
    assert!(error.lines().count() == 1 && !error.contains("inf"), "{error}");
}

/// A scan with a hole is refused, or closed on request.
#[test]
fn holes_of_a_surface_are_closed_on_request() {
    let whole = cubes(1.0, &[[0.0; 3]]);
    let first = whole.find("facet").unwrap()..whole.find("endfacet").unwrap() + "endfacet\n".len();
    let open = whole.replacen(&whole[first], "", 1);
    let body = "surface = \"a.stl\"\nmesh_size = 0.5";
    let refused = any("", body, &open).unwrap_err();
    assert!(
        refused.contains("close_holes closes holes up to a width: its hole, the widest 1 m"),
        "{refused}"
    );
    // A hole that is wider than asked stays.
    let refused = any("", &format!("{body}\nclose_holes = 0.9"), &open).unwrap_err();
    assert!(refused.contains("the widest 1 m") && refused.contains("facet"), "{refused}");
    let prepared = space("", &format!("{body}\nclose_holes = 1.5"), &open);
    let volume: f64 = prepared
        .model
        .mesh
        .elements
        .iter()
        .map(|nodes| fdem_mesh::Corners::measure(&nodes.map(|node| prepared.model.mesh.nodes[node as usize])))
        .sum();
    assert!((volume - 1.0).abs() < 1e-9, "{volume}");
    let note = "[[body]] \"b\": a.stl: 1 hole of its surface closed, the widest 1 m";
    assert!(prepared.warnings.iter().any(|warning| warning == note), "{:?}", prepared.warnings);
}

/// A closed surface whose normals point inward is turned around, with a word.
#[test]
fn a_surface_that_points_inward_is_turned_around() {
    let inward: String = cubes(1.0, &[[0.0; 3]])
        .split_inclusive("endfacet\n")
        .map(|facet| {
            let mut lines: Vec<&str> = facet.split_inclusive('\n').collect();
            let corners: Vec<usize> =
                (0..lines.len()).filter(|&line| lines[line].contains("vertex")).collect();
            if let [_, b, c] = corners[..] {
                lines.swap(b, c);
            }
            lines.concat()
        })
        .collect();
    let prepared = space("", "surface = \"a.stl\"\nmesh_size = 0.5", &inward);
    let mesh = &prepared.model.mesh;
    let corners = |nodes: &[u32; 4]| nodes.map(|node| mesh.nodes[node as usize]);
    let volume: f64 = mesh.elements.iter().map(|nodes| fdem_mesh::Corners::measure(&corners(nodes))).sum();
    assert!((volume - 1.0).abs() < 1e-9, "{volume}");
    let note =
        "[[body]] \"b\": a.stl: the triangles of its surface pointed inward: all of them are turned around";
    assert!(prepared.warnings.iter().any(|warning| warning == note), "{:?}", prepared.warnings);
    // One triangle that points elsewhere is refused, and the message says the way out.
    let first = inward.find("facet").unwrap()..inward.find("endfacet").unwrap() + "endfacet\n".len();
    let whole = cubes(1.0, &[[0.0; 3]]);
    let mixed = whole.replacen(&whole[first.clone()], &inward[first], 1);
    let refused = any("", "surface = \"a.stl\"\nmesh_size = 0.5", &mixed).unwrap_err();
    assert!(refused.contains("turn the normals of all triangles outward"), "{refused}");
}

/// A cube of 1 m, with a fine patch of this width in the middle of its top, as an OBJ file.
fn cube_with_patch(patch: f64, squares: usize) -> String {
    let mut text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n".to_owned();
    let at = |k: usize| 0.5 + patch * (k as f64 / squares as f64 - 0.5);
    for (y, x) in (0..=squares).flat_map(|y| (0..=squares).map(move |x| (y, x))) {
        writeln!(text, "v {} {} 1", at(x), at(y)).unwrap();
    }
    text += "f 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let corner = |x: usize, y: usize| 9 + x + (squares + 1) * y;
    for (y, x) in (0..squares).flat_map(|y| (0..squares).map(move |x| (y, x))) {
        let [a, b, c, d] = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]].map(|[x, y]| corner(x, y));
        writeln!(text, "f {a} {b} {c} {d}").unwrap();
    }
    // Fans around the patch, from the corners of the cube.
    for k in 0..squares {
        let last = squares - k;
        let sides = [
            (5, [k, 0], [k + 1, 0]),
            (6, [squares, k], [squares, k + 1]),
            (7, [last, squares], [last - 1, squares]),
            (8, [0, last], [0, last - 1]),
        ];
        for (outer, [x, y], [u, v]) in sides {
            writeln!(text, "f {outer} {} {}", corner(u, v), corner(x, y)).unwrap();
        }
    }
    let ends = [[squares, 0], [squares, squares], [0, squares], [0, 0]].map(|[x, y]| corner(x, y));
    for ([a, b], end) in [[5, 6], [6, 7], [7, 8], [8, 5]].into_iter().zip(ends) {
        writeln!(text, "f {a} {b} {end}").unwrap();
    }
    text
}

/// Facets of a scan are made as large as the mesh, and the time step with them.
#[test]
fn fine_facets_of_a_surface_become_larger_on_request() {
    let step = |file: &str, end: &str, keys: &str| {
        let prepared = space("", &format!("surface = \"a.{end}\"\nmesh_size = 0.3{keys}"), file);
        let run = fdem_simulation::Simulation::new(prepared.model, 1).expect("a model");
        (run.time_step(), prepared.warnings)
    };
    let (plain, _) = step(&cubes(1.0, &[[0.0; 3]]), "stl", "");
    let patched = cube_with_patch(1e-4, 4);
    let (fine, warnings) = step(&patched, "obj", "");
    assert!(warnings.iter().any(|warning| warning.contains("surface_tolerance")), "{warnings:?}");
    let (coarse, warnings) = step(&patched, "obj", "\nsurface_tolerance = 1e-3");
    assert!(fine < 1e-2 * plain && coarse > 0.5 * plain, "{fine} {coarse} {plain}");
    let note = "[[body]] \"b\": a.obj: coarsened 62 facets to 14, at most ";
    assert!(warnings.iter().any(|warning| warning.starts_with(note)), "{warnings:?}");
}

/// A surface has its facets in the mesh: a patch of fine ones makes all of the run slow.
#[test]
fn a_fine_patch_of_a_surface_has_a_warning_with_its_cost() {
    let warned = |file: &str| {
        let prepared = space("", "surface = \"a.obj\"\nmesh_size = 0.3", file);
        prepared.warnings.into_iter().find(|warning| warning.contains("facets of its surface"))
    };
    let warning = warned(&cube_with_patch(1e-3, 4)).unwrap();
    for part in
        ["half of the elements of the body \"b\"", "times shorter than theirs", "below a tenth of mesh_size"]
    {
        assert!(warning.contains(part), "{warning}");
    }
    assert_eq!(warned(&cube_with_patch(0.4, 2)), None);
}
