//! Spheres and walls: tables that are right, and mistakes with their lines.

use fdem_model::{AnyPrepared, Prepared, prepare_any};
use fdem_results::CoarseGrid;
use fdem_simulation::grains::{BoxServo, ForceLaw, GrainModel, WallShape};
use fdem_simulation::{Probe, TouchingSide};

/// A model of spheres that is right.
const HEAP: &str = r#"[model]
end_time = 1e-3
gravity = [0, 0, -9.81]

[[grains]]
name = "sand"
material = "glass"
count = 50
radius = [0.01, 0.02]
within = { min = [0, 0, 0], max = [0.4, 0.4, 0.4] }

[[wall]]
name = "floor"
material = "steel"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }

[[material]]
name = "glass"
density = 2500
youngs_modulus = 60e9
poissons_ratio = 0.2
friction = 0.4
restitution = 0.9
rolling_friction = 0.02

[[material]]
name = "steel"
density = 7800
youngs_modulus = 210e9
poissons_ratio = 0.3
friction = 0.3
restitution = 0.6
"#;

/// The same with discs.
const DISCS: &str = r#"[model]
end_time = 1e-3
thickness = 0.5

[[grains]]
name = "discs"
material = "glass"
fraction = 0.5
radius = 0.02
within = { disc = { centre = [0, 0], radius = 0.3 } }
spin = 90

[[wall]]
name = "drum"
material = "glass"
circle = { centre = [0, 0], radius = 0.3 }
rotation = { through = [0, 0], speed = 180 }

[[material]]
name = "glass"
density = 2500
youngs_modulus = 60e9
poissons_ratio = 0.2
restitution = 0.9
"#;

fn cube_stl(sides: usize) -> String {
    let corner = |k: usize| format!("vertex {} {} {}", k & 1, k >> 1 & 1, k >> 2 & 1);
    let all = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = all[..sides].iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let facet = |[a, b, c]: [usize; 3]| {
        format!(
            "facet normal 0 0 0\nouter loop\n{}\n{}\n{}\nendloop\nendfacet\n",
            corner(a),
            corner(b),
            corner(c)
        )
    };
    format!("solid cube\n{}endsolid cube\n", triangles.map(facet).collect::<String>())
}

fn any(text: &str) -> Result<AnyPrepared, String> {
    let mut load = |name: &str| match name {
        "cube.stl" => Ok(cube_stl(6).into_bytes()),
        "open.stl" => Ok(cube_stl(5).into_bytes()),
        "none.stl" => Ok(b"solid none\nendsolid none\n".to_vec()),
        "balls.csv" => Ok(b"x,y,z,radius\n10,10,10,5\n30,10,10,6\n".to_vec()),
        "flat.csv" => Ok(b"x,y,radius\n0,0,1\n".to_vec()),
        _ => Err("there is none".to_owned()),
    };
    prepare_any(text, "m.toml", &mut load, None).map_err(|errors| errors.to_string())
}

#[track_caller]
fn space(text: &str) -> Prepared<3, 4> {
    match any(text) {
        Ok(AnyPrepared::Space(prepared)) => *prepared,
        Ok(AnyPrepared::Plane(_)) => panic!("it is flat"),
        Err(errors) => panic!("{errors}"),
    }
}

#[track_caller]
fn grains(text: &str) -> GrainModel {
    match any(text) {
        Ok(AnyPrepared::Space(prepared)) => prepared.model.grains.unwrap(),
        Ok(AnyPrepared::Plane(prepared)) => prepared.model.grains.unwrap(),
        Err(errors) => panic!("{errors}"),
    }
}

/// Checks that the model is refused at the line of `at`, with these words.
#[track_caller]
fn refused(text: &str, at: &str, words: &[&str]) {
    let line = text.lines().position(|line| line.starts_with(at)).expect("the line is there") + 1;
    let errors = any(text).expect_err("there is a mistake");
    let is_right = |error: &&str| {
        error.starts_with(&format!("m.toml:{line}: ")) && words.iter().all(|words| error.contains(words))
    };
    assert!(errors.lines().any(|error| is_right(&error)), "{at} at line {line}: {words:?} in\n{errors}");
}

fn heap(from: &str, to: &str) -> String {
    assert!(HEAP.contains(from), "{from}");
    HEAP.replacen(from, to, 1)
}

#[test]
fn spheres_alone_are_a_model() {
    let prepared = space(HEAP);
    assert!(prepared.model.mesh.nodes.is_empty());
    let spheres = prepared.spheres.unwrap();
    assert_eq!((spheres.groups[0].count, spheres.groups[0].name.as_str()), (50, "sand"));
    assert!(spheres.groups[0].mass > 0.0 && spheres.groups[0].fraction.is_some());
    let model = prepared.model.grains.unwrap();
    assert_eq!(model.spheres.positions.len(), 50);
    assert!(model.spheres.radii.iter().all(|radius| (0.01..=0.02).contains(radius)));
    assert_eq!((model.gravity, model.discs), ([0.0, 0.0, -9.81], None));
    assert_eq!(model.groups, ["sand"]);
    assert_eq!(model.walls[0].shape, WallShape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] });
    assert_eq!((model.walls[0].material, model.law), (1, ForceLaw::HertzMindlin));
    // Of two materials the lesser values.
    let of = |pair| model.surfaces.iter().find(|of| of.materials == pair).unwrap();
    let mixed = of([0, 1]);
    assert_eq!((mixed.restitution, mixed.friction, mixed.rolling_friction), (0.6, 0.3, 0.0));
    let own = of([0, 0]);
    assert_eq!((own.restitution, own.rolling_friction, own.rolling_damping), (0.9, 0.02, 0.3));
    assert_eq!(model.surfaces.len(), 3);
}

#[test]
fn discs_alone_are_a_model_in_two_dimensions() {
    let model = grains(DISCS);
    assert_eq!(model.discs, Some(0.5));
    let inside = |at: &[f64; 3]| at[2] == 0.0 && at[0].hypot(at[1]) <= 0.28 + 1e-12;
    assert!(model.spheres.positions.iter().all(inside));
    assert_eq!(model.spheres.positions.len(), 112);
    assert_eq!(model.spheres.spins[0], [0.0, 0.0, std::f64::consts::FRAC_PI_2]);
    assert_eq!(model.walls[0].rotation.unwrap().spin, [0.0, 0.0, std::f64::consts::PI]);
    assert!(matches!(model.walls[0].shape, WallShape::Tube { radius: 0.3, .. }));
    // Along the third axis a box has the thickness of the discs.
    let domain = "\n[domain]\nbox = [-1, -2, 1, 2]\nperiodic = [\"x\"]\n";
    let domain = grains(&format!("{DISCS}{domain}")).domain.expect("a box");
    assert_eq!([domain.low, domain.high], [[-1.0, -2.0, -0.25], [1.0, 2.0, 0.25]]);
    assert_eq!(domain.periodic, [true, false, false]);
}

#[test]
fn spheres_stand_beside_bodies() {
    let block = "[[body]]\nname = \"block\"\nmaterial = \"steel\"\nmesh_size = 0.2\n\
                 box = { min = [0, 0, 1], max = [0.4, 0.4, 1.4] }\n";
    let prepared = space(&format!("{HEAP}{block}"));
    assert_eq!(prepared.bodies.len(), 1);
    assert_eq!(prepared.model.grains.unwrap().materials.len(), 2);
    let deep = format!("{HEAP}{}", block.replace("[0, 0, 1]", "[0.05, 0.05, 0.05]"));
    refused(&deep, "name = \"sand\"", &["of [[grains]] \"sand\"", "is inside of the body \"block\""]);
}

#[test]
fn flat_bodies_keep_discs_out() {
    let block = "[[body]]\nname = \"block\"\nmaterial = \"glass\"\nmesh_size = 0.1\n\
                 rectangle = { min = [1, 1], max = [2, 2] }\n";
    assert_eq!(grains(&format!("{DISCS}{block}")).spheres.positions.len(), 112);
    let deep = format!("{DISCS}{}", block.replace("[1, 1]", "[0, 0]"));
    refused(&deep, "name = \"discs\"", &["inside of the body \"block\""]);
}

#[test]
fn spheres_come_from_places_and_files() {
    let at = heap(
        "count = 50\nradius = [0.01, 0.02]\nwithin = { min = [0, 0, 0], max = [0.4, 0.4, 0.4] }",
        "at = [[0, 0, 1], [0, 0, 2]]\nradius = 0.1\nvelocity = [1, 2, 3]\nspin = [0, 0, 180]\nfixed = true",
    );
    let model = grains(&at);
    assert_eq!(model.spheres.positions, [[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]]);
    assert_eq!((model.spheres.radii[1], model.spheres.held[1]), (0.1, true));
    assert_eq!(model.spheres.velocities[0], [1.0, 2.0, 3.0]);
    assert_eq!(model.spheres.spins[0], [0.0, 0.0, std::f64::consts::PI]);
    let file = heap(
        "count = 50\nradius = [0.01, 0.02]\nwithin = { min = [0, 0, 0], max = [0.4, 0.4, 0.4] }",
        "file = \"balls.csv\"\nscale = \"1 mm\"\ntranslate = [1, 0, 0]",
    );
    let model = grains(&file);
    assert_eq!(model.spheres.positions, [[1.01, 0.01, 0.01], [1.03, 0.01, 0.01]]);
    assert_eq!(model.spheres.radii, [0.005, 0.006]);
    refused(&file.replace("balls.csv", "flat.csv"), "file = ", &["flat.csv", "has no z"]);
    refused(&file.replace("balls.csv", "other.csv"), "file = ", &["cannot read other.csv"]);
}

#[test]
fn spheres_fill_closed_surfaces() {
    let inside = heap("{ min = [0, 0, 0], max = [0.4, 0.4, 0.4] }", "{ surface = \"cube.stl\" }");
    let inside = inside.replace("count = 50", "fraction = 0.45").replace("[0.01, 0.02]", "0.08");
    let model = grains(&inside);
    assert_eq!(model.spheres.positions.len(), 210);
    let is_in = |at: &[f64; 3]| at.iter().all(|x| (0.08..=0.92).contains(x));
    assert!(model.spheres.positions.iter().all(is_in));
    refused(&inside.replace("cube.stl", "open.stl"), "within = ", &["open.stl is no closed surface"]);
}

#[test]
fn radii_of_all_distributions_have_units() {
    let with = |radius: &str| grains(&heap("[0.01, 0.02]", radius)).spheres.radii;
    let range = |radii: &[f64]| radii.iter().fold([1.0_f64, 0.0], |[a, b], &r| [a.min(r), b.max(r)]);
    assert_eq!(range(&with("\"10 mm\"")), [0.01; 2]);
    let [least, most] = range(&with("[\"10 mm\", \"20 mm\"]"));
    assert!(least >= 0.01 && most <= 0.02 && most > 0.019, "{least} {most}");
    let [least, most] = range(&with("{ mean = \"15 mm\", deviation = \"1 mm\" }"));
    assert!(least >= 0.012 && most <= 0.018 && most > 0.0165, "{least} {most}");
    let [least, most] = range(&with("[[\"10 mm\", 0], [\"20 mm\", \"100 %\"]]"));
    assert!((0.01..0.011).contains(&least) && most <= 0.02, "{least} {most}");
}

#[test]
fn walls_of_all_shapes() {
    let with = |shape: &str| {
        let text = heap("plane = { point = [0, 0, 0], normal = [0, 0, 1] }", shape);
        grains(&text).walls.remove(0)
    };
    let triangles = |shape: &str| match with(shape).shape {
        WallShape::Mesh { triangles } => triangles.len(),
        _ => panic!("no mesh"),
    };
    let tube = with("tube = { from = [0.2, 0.2, 0], to = [0.2, 0.2, 1], radius = 0.5 }");
    assert!(matches!(tube.shape, WallShape::Tube { radius: 0.5, .. }));
    let cone = with("cone = { from = [0.2, 0.2, -1], to = [0.2, 0.2, 1], radii = [0.1, 2] }");
    assert!(matches!(cone.shape, WallShape::Cone { radii: [0.1, 2.0], .. }));
    let disc = "disc = { centre = [0, 0, -0.1], normal = [0, 0, 2], radius = 0.5 }\n\
                servo = { direction = [0, 0, 3], pressure = 100, speed = 0.1 }";
    let servo = with(disc).servo.unwrap();
    assert!((servo.force - 25.0 * std::f64::consts::PI).abs() < 1e-12, "{}", servo.force);
    assert_eq!(triangles("box = { min = [0, 0, 0], max = [0.4, 0.4, 0.4] }"), 12);
    assert_eq!(triangles("box = { min = [0, 0, 0], max = [0.4, 0.4, 0.4], open = [\"top\", \"front\"] }"), 8);
    assert_eq!(triangles("corners = [[0, 0, -1], [1, 0, -1], [1, 1, -1], [0, 1, -1]]"), 2);
    assert_eq!(triangles("mesh = \"cube.stl\"\ntranslate = [0, 0, -1]"), 12);
    let moved = with(
        "corners = [[0, 0, -1], [1, 0, -1], [1, 1, -1]]\nvelocity = [0, 0, 1]\n\
                      displacement = [0, 0, 2]\ntable = [[0, 0], [1, 0.5]]\n\
                      rotation = { through = [1, 0, 0], axis = [0, 0, 5], speed = 180 }",
    );
    assert_eq!(moved.path, [(0.0, [0.0; 3]), (1.0, [0.0, 0.0, 1.0])]);
    assert_eq!((moved.velocity, moved.rotation.unwrap().through), ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
}

#[test]
fn mistakes_in_grains_have_their_lines() {
    for (from, to, at, words) in [
        ("count = 50", "count = 50\nfraction = 0.2", "fraction", &["has both count and fraction"][..]),
        ("count = 50\n", "", "name = \"sand\"", &["has no spheres", "count, fraction, at, file"]),
        ("radius = [0.01, 0.02]\n", "", "count", &["lacks the key \"radius\""]),
        ("radius = [0.01, 0.02]", "radius = [0.02, 0.01]", "radius", &["the least radius is above 0"]),
        ("radius = [0.01, 0.02]", "radius = [[0.01, 0], [0.02, 0.5]]", "radius", &["the last share"]),
        ("radius = [0.01, 0.02]", "radius = { mean = 0.01, deviation = 0.004 }", "radius", &["3 deviations"]),
        (
            "radius = [0.01, 0.02]",
            "radius = { mean = 0.01, deviaton = 0.001 }",
            "radius",
            &["did you mean \"deviation\"?"],
        ),
        ("material = \"glass\"", "material = \"glas\"", "material", &["did you mean \"glass\"?"]),
        ("count = 50", "cuont = 50", "cuont", &["did you mean \"count\"?"]),
        (
            "count = 50",
            "count = 50\nstages = [\"first\"]",
            "stages",
            &["spheres and walls are there in all stages"],
        ),
        ("max = [0.4, 0.4, 0.4]", "max = [0.4, 0.4]", "within", &["has 2 numbers", "3 dimensions"]),
        ("max = [0.4, 0.4, 0.4]", "max = [0.4, 0.4, 0]", "within", &["each component of max"]),
        ("within = {", "spin = 5\nwithin = {", "spin", &["\"spin\" of spheres in 3 dimensions", "[x, y, z]"]),
        ("count = 50", "count = 5000", "count", &["solid fraction", "cannot be reached"]),
        ("count = 50", "fraction = 0.7", "fraction", &["cannot be reached: 0.", "was reached"]),
        ("max = [0.4, 0.4, 0.4]", "max = [0.4, 0.4, 0.03]", "radius", &["has no room in its region"]),
        (
            "[0, 0, 0], max",
            "[0, 0, -0.2], max",
            "name = \"sand\"",
            &["is on the wrong side of [[wall]] \"floor\""],
        ),
        (
            "restitution = 0.9\n",
            "",
            "name = \"glass\"",
            &["spheres of it may touch each other", "restitution"],
        ),
        (
            "count = 50\nradius = [0.01, 0.02]\nwithin",
            "at = [[0, 0, 1], [0, 0, 1.1]]\nradius = 0.1\n#",
            "name = \"sand\"",
            &[
                "sphere 0 of [[grains]] \"sand\", at [0, 0, 1] m,",
                "overlaps sphere 1",
                "100 % of the smaller radius",
            ],
        ),
        ("name = \"sand\"", "name = \"sand\\u0007\"", "name = \"sand", &["is not one line of text"]),
    ] {
        refused(&heap(from, to), at, words);
    }
    refused(
        DISCS.replace("radius = 0.02\nwithin = { disc", "radius = 0.02\nwithin = { ball").as_str(),
        "within",
        &["ball"],
    );
    let two = heap(
        "[[wall]]",
        "[[grains]]\nname = \"sand\"\nmaterial = \"glass\"\nat = [[9, 9, 9]]\nradius = 1\n\n[[wall]]",
    );
    assert!(any(&two).unwrap_err().contains("there is a [[grains]] \"sand\" already"));
    let none = &HEAP[HEAP.find("[[material]]").unwrap()..];
    let none = format!("[model]\nend_time = 1\n{none}");
    assert!(any(&none).unwrap_err().contains("lacks the key \"body\""));
}

#[test]
fn mistakes_in_walls_have_their_lines() {
    let plane = "plane = { point = [0, 0, 0], normal = [0, 0, 1] }";
    for (to, at, words) in [
        ("", "name = \"floor\"", &["has no shape", "plane, tube, cone"][..]),
        ("plane = { point = [0, 0, 0], normal = [0, 0, 0] }", "plane", &["its normal has no direction"]),
        ("circle = { radius = 1 }", "circle", &["a circle is no wall in 3 dimensions"]),
        (
            "plane = { point = [0, 0, 0], normal = [0, 0, 1] }\nmesh = \"cube.stl\"",
            "mesh",
            &["two shapes, plane and mesh"],
        ),
        ("mesh = \"none.stl\"", "mesh", &["none.stl"]),
        ("mesh = \"lost.stl\"", "mesh", &["cannot read lost.stl"]),
        ("corners = [[0, 0, -1], [1, 0, -1]]", "corners", &["three corners or more"]),
        ("corners = [[0, 0, -1], [1, 0, -1], [1, 1, -1], [0, 1, -2]]", "corners", &["not in one plane"]),
        ("corners = [[0, 0, -1], [1, 0, -1], [0.1, 0.1, -1], [0, 1, -1]]", "corners", &["not convex"]),
        ("tube = { from = [0, 0, 0], to = [0, 0, 0], radius = 1 }", "tube", &["its axis has no length"]),
        ("cone = { from = [0, 0, 0], to = [0, 0, 1], radii = [0, 0] }", "cone", &["one of them is above 0"]),
        ("box = { min = [0, 0, 0], max = [1, 1, 0] }", "box", &["each component of max"]),
        ("plane = { point = [0, 0], normal = [0, 0, 1] }", "plane", &["has 2 numbers"]),
        (
            "plane = { point = [0, 0, 0], normal = [0, 0, 1] }\ndisplacement = [0, 0, 1]",
            "displacement",
            &["goes with table"],
        ),
        (
            "plane = { point = [0, 0, 0], normal = [0, 0, 1] }\ndisplacement = [0, 0, 1]\ntable = [[1, 0], [0, 1]]",
            "table",
            &["do not ascend"],
        ),
        ("plane = { point = [0, 0, 0], normal = [0, 0, 1] }\nscale = 2", "scale", &["goes with mesh"]),
        (
            "plane = { point = [0, 0, 0], normal = [0, 0, 1] }\nrotation = { through = [0, 0, 0], speed = 5 }",
            "rotation",
            &["has an \"axis\""],
        ),
        (
            "plane = { point = [0, 0, 0], normal = [0, 0, 1] }\nservo = { direction = [0, 0, 1], speed = 1 }",
            "servo",
            &["lacks a force"],
        ),
        (
            "plane = { point = [0, 0, 0], normal = [0, 0, 1] }\nservo = { direction = [0, 0, 1], speed = 1, pressure = 5 }",
            "servo",
            &["a wall that has an area"],
        ),
        (
            "plane = { point = [0, 0, 0], normal = [0, 0, 1] }\nservo = { direction = [0, 0, 0], speed = 1, force = 5 }",
            "servo",
            &["no direction"],
        ),
    ] {
        refused(&heap(plane, to), at, words);
    }
    let unknown = heap("material = \"steel\"", "material = \"stel\"");
    refused(&unknown, "material = \"stel\"", &["did you mean \"steel\"?"]);
}

#[test]
fn laws_and_domains() {
    let hooke = format!("{HEAP}[spheres]\nlaw = \"hooke\"\nstiffness = 1e5\n");
    assert_eq!(grains(&hooke).law, ForceLaw::Hooke { normal: 1e5, tangential: 2.0 / 7.0 });
    refused(&hooke.replace("stiffness = 1e5\n", ""), "law", &["needs a stiffness"]);
    refused(&hooke.replace("hooke", "hertz"), "stiffness", &["goes with law = \"hooke\""]);
    refused(&hooke.replace("hooke", "hoke"), "law", &["did you mean \"hooke\"?"]);
    let sticky = "[[interface]]\nmaterials = [\"steel\", \"glass\"]\nadhesion = 0.05\nrestitution = 0.1\ntwisting_friction = 0.2\n";
    let model = grains(&format!("{HEAP}{sticky}"));
    let surfaces = model.surfaces.iter().find(|of| of.materials == [0, 1]).unwrap();
    assert_eq!((surfaces.adhesion, surfaces.restitution, surfaces.twisting_friction), (0.05, 0.1, 0.2));
    refused(&format!("{hooke}{sticky}"), "adhesion", &["goes with law = \"hertz\""]);

    let domain = format!(
        "{HEAP}[domain]\nbox = [0, 0, 0, 1, 1, 2]\nperiodic = [\"x\", \"y\"]\nstrain_rate = [0.1, 0, 0]\noutside = \"delete\"\n"
    );
    let of = grains(&domain).domain.unwrap();
    assert_eq!((of.low, of.high, of.periodic), ([0.0; 3], [1.0, 1.0, 2.0], [true, true, false]));
    assert_eq!(of.strain_rates, [0.1, 0.0, 0.0]);
    refused(&domain.replace("[0.1, 0, 0]", "[0.1, 0, 1]"), "strain_rate", &["does not repeat along z"]);
    refused(&domain.replace("1, 1, 2]", "1, -1, 2]"), "box", &["inside out"]);
    let low = domain.replace("[0, 0, 0, 1, 1, 2]", "[0, 0, 0, 1, 1, 0.2]");
    refused(&low, "name = \"sand\"", &["is outside of the box of [domain]"]);
    let servo = domain.replace(
        "outside = \"delete\"",
        "strain_from = \"20 ms\"\nservo = { x = \"1 kPa\", y = 500, rate = 2 }",
    );
    let of = grains(&servo).domain.unwrap();
    let kept = BoxServo { pressures: [Some(1000.0), Some(500.0), None], largest_rate: 2.0 };
    assert_eq!((of.servo, of.strain_from), (Some(kept), 0.02));
    refused(&servo.replace("y = 500", "z = 500"), "servo", &["does not repeat along z"]);
    refused(&servo.replace("y = 500", "y = -1"), "servo", &["at least 0"]);
    refused(&servo.replace("x = \"1 kPa\", y = 500, ", ""), "servo", &["has no pressure"]);
    refused(&servo.replace("strain_from = \"20 ms\"\n", ""), "servo", &["at the same time", "strain_from"]);
    let body = "[[body]]\nname = \"b\"\nmaterial = \"steel\"\nmesh_size = 0.5\nbox = { min = [5, 5, 5], max = [6, 6, 6] }\n";
    refused(&format!("{domain}{body}"), "periodic", &["spheres without bodies"]);
}

#[test]
fn keys_without_effect_are_warned_of() {
    let rolling = heap("rolling_friction = 0.02\n", "");
    let rolling = rolling.replace("restitution = 0.6", "restitution = 0.6\nrolling_friction = 0.1");
    let idle = "[[interface]]\nmaterials = [\"steel\", \"steel\"]\nrestitution = 0.1\n";
    let warnings = space(&format!("{rolling}{idle}")).warnings.join("\n");
    assert!(warnings.contains("[[material]] \"steel\": rolling_friction changes nothing"), "{warnings}");
    assert!(warnings.contains("\"steel\" and \"steel\": restitution changes nothing"), "{warnings}");
    assert_eq!(space(HEAP).warnings, Vec::<String>::new());
}

#[test]
fn insertions_that_their_boxes_cannot_hold_are_warned_of() {
    let rain = "[[insertion]]\nname = \"rain\"\nmaterial = \"glass\"\ncount = 200\nradius = 0.01\n\
                within = { min = [0, 0, 0.6], max = [0.1, 0.1, 0.7] }\n";
    let warnings = |text: &str| space(text).warnings.join("\n");
    let full = warnings(&format!("{HEAP}{rain}"));
    assert!(full.contains("[[insertion]] \"rain\": the spheres have 84 % of the volume"), "{full}");
    assert_eq!(warnings(&format!("{HEAP}{rain}rate = 1000\n")), "");
    assert_eq!(warnings(&format!("{HEAP}{}", rain.replace("200", "100"))), "");
}

#[test]
fn histories_of_walls_and_spheres() {
    let text = format!(
        "{HEAP}[[history]]\nname = \"w\"\nwall = \"floor\"\n\n[[history]]\nname = \"g\"\ngrains = true\nbox = [0, 0, 0, 1, 1, 1]\n"
    );
    let prepared = space(&text);
    assert_eq!(
        prepared.probes,
        [Probe::Wall { wall: 0 }, Probe::Spheres { region: Some([[0.0; 3], [1.0; 3]]) }]
    );
    refused(&text.replace("wall = \"floor\"", "wall = \"flor\""), "wall = ", &["did you mean \"floor\"?"]);
}

#[test]
fn histories_of_the_force_between_spheres_and_bodies() {
    let body = "[[body]]\nname = \"block\"\nmaterial = \"steel\"\nmesh_size = 0.2\n\
                box = { min = [1, 0, 0], max = [1.2, 0.2, 0.2] }\n";
    let rain = "[[insertion]]\nname = \"rain\"\nmaterial = \"glass\"\ncount = 2\nradius = 0.01\n\
                within = { min = [0, 0, 0.6], max = [0.1, 0.1, 0.7] }\n";
    let history =
        |names: &str| format!("{HEAP}{body}{rain}[[history]]\nname = \"f\"\ncontact_force = {names}\n");
    let [sand, rain, block] = [
        TouchingSide::Spheres("sand".to_owned()),
        TouchingSide::Spheres("rain".to_owned()),
        TouchingSide::Bodies(vec![0]),
    ];
    let probes = |names: &str| space(&history(names)).probes;
    assert_eq!(probes(r#"["sand", "block"]"#), [Probe::ForceOfSpheres([sand.clone(), block.clone()])]);
    assert_eq!(probes(r#"["block", "sand"]"#), [Probe::ForceOfSpheres([block, sand.clone()])]);
    assert_eq!(probes(r#"["rain", "sand"]"#), [Probe::ForceOfSpheres([rain, sand])]);
    refused(
        &history(r#"["sond", "block"]"#),
        "contact_force",
        &["no body \"sond\", and no spheres", "\"sand\"?"],
    );
    refused(&history(r#"["sand", "sand"]"#), "contact_force", &["on both sides"]);
    refused(&history(r#"["sand", "floor"]"#), "contact_force", &["history wall = \"floor\""]);
    for (name, at) in [("block", "\"sand\""), ("sand", "\"block\"")] {
        let both = history(r#"["sand", "rain"]"#).replacen(at, &format!("\"{name}\""), 1);
        refused(&both, "name", &[&format!("there is a [[body]] \"{name}\" already"), "different names"]);
    }
    let both = history(r#"["sand", "block"]"#).replace("\"rain\"", "\"block\"");
    assert!(any(&both).unwrap_err().contains("there is a [[body]] \"block\" already"));
}

#[test]
fn a_grid_of_a_continuum_is_checked() {
    let output = |keys: &str| format!("{HEAP}[output]\ncoarse = {{ {keys} }}\n");
    let text = output("spacing = \"5 mm\", width = 0.01, box = [0, 0, 0, 1, 1, 2]");
    let region = Some([[0.0; 3], [1.0, 1.0, 2.0]]);
    assert_eq!(space(&text).output.coarse, Some(CoarseGrid { spacing: 0.005, width: 0.01, region }));
    refused(&text.replace("\"5 mm\"", "1e-4"), "coarse", &["more than 50,000,000 points"]);
    refused(&text.replace("1, 1, 2]", "1, 2]"), "coarse", &["6"]);
    refused(&text.replace("1, 1, 2]", "1, -1, 2]"), "coarse", &["inside out"]);
    refused(&text.replace(", width = 0.01", ""), "coarse", &["width"]);
    let without =
        format!("{}[output]\ncoarse = {{ spacing = 1, width = 1, box = [0, 0, 1, 1] }}\n", super::SMALL);
    refused(&without, "coarse", &["is for spheres"]);
}

#[test]
fn tables_of_spheres_need_spheres() {
    let text = super::SMALL.to_owned();
    refused(&format!("{text}[spheres]\nlaw = \"hertz\"\n"), "[spheres]", &["there are no [[grains]]"]);
    let wall = "[[wall]]\nname = \"w\"\nmaterial = \"rock\"\nplane = { point = [0, 0], normal = [0, 1] }\n";
    refused(&format!("{text}{wall}"), "[[wall]]", &["there are no [[grains]]"]);
}
