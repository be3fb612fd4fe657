//! Histories of probes: their values, and refusals.

use fdem_model::Quantity;
use fdem_simulation::Probe;

use crate::{SMALL, read, right};

/// The small model with a second block on the first, and histories.
fn with(histories: &str) -> String {
    format!(
        "{SMALL}\n[[body]]\nname = \"upper\"\nmaterial = \"rock\"\nrectangle = {{ min = [0, 0.5], max = [0.5, 1.0] }}\nmesh_size = 0.1\n{histories}"
    )
}

#[test]
fn probes_are_of_the_elements_and_bodies_that_are_named() {
    let prepared = right(&with(
        r#"
[[history]]
name = "point"
stress = [0.31, 0.22]
[[history]]
name = "energies"
energy = true
[[history]]
name = "all"
strain = "mean"
[[history]]
name = "core"
stress = "mean"
body = "upper"
box = [0.1, 0.0, 0.4, 0.9]
[[history]]
name = "speed"
velocity = [0.31, 0.22]
[[history]]
name = "drift"
velocity = "mean"
body = "upper"
[[history]]
name = "gauge"
gauge = [[0.1, 0.25], [0.9, 0.25]]
[[history]]
name = "between"
contact_force = ["upper", "block"]
[[history]]
name = "outline"
reaction = "outer"
body = "upper"
"#,
    ));
    let mesh = &prepared.model.mesh;
    let quantities: Vec<_> = prepared.histories.iter().map(|history| history.quantity).collect();
    let expected = [Quantity::Probe(0), Quantity::Energy].into_iter().chain((1..8).map(Quantity::Probe));
    assert_eq!(quantities, expected.collect::<Vec<_>>());
    let [
        Probe::Stress(at),
        Probe::Strain(all),
        Probe::Stress(core),
        Probe::PointVelocity(point),
        Probe::Velocity(upper),
        Probe::Gauge { ends, span },
        Probe::ContactForce(bodies),
        Probe::Reaction(nodes),
    ] = &prepared.probes[..]
    else {
        panic!("{:?}", prepared.probes)
    };
    assert_eq!(*at, [point.element]);
    let place: Vec<f64> = (0..2)
        .map(|axis| {
            let corners = mesh.elements[point.element as usize];
            corners
                .iter()
                .zip(point.weights)
                .map(|(&node, weight)| weight * mesh.nodes[node as usize][axis])
                .sum()
        })
        .collect();
    assert!((place[0] - 0.31).abs() < 1e-12 && (place[1] - 0.22).abs() < 1e-12, "{place:?}");
    assert_eq!(all.len(), mesh.elements.len());
    assert_eq!(*upper, prepared.bodies[1].elements.clone().collect::<Vec<_>>());
    assert!(
        core.len() > 10 && core.len() < upper.len() && core.iter().all(|element| upper.contains(element))
    );
    assert!(ends[0].element != ends[1].element);
    assert!((span[0] - 0.8).abs() < 1e-15 && span[1] == 0.0);
    assert_eq!(*bodies, [vec![1], vec![0]]);
    assert!(nodes.is_sorted() && nodes.iter().all(|node| prepared.bodies[1].nodes.contains(node)));
}

#[test]
fn wrong_probes_are_told_with_their_place() {
    for (keys, at, parts) in [
        ("stress = [3, 0.2]", "[3, 0.2]", ["outside of all bodies", "nearest body is \"block\""]),
        ("stress = [0.2, 0.2]\nbody = \"upper\"", "[0.2, 0.2]", ["outside of the body", "\"upper\""]),
        ("stress = [1, 2, 3]", "[1, 2, 3]", ["\"stress\" has 3 numbers", "write [x, y]"]),
        ("stress = \"max\"", "\"max\"", ["stress", ""]),
        ("stress = \"mean\"\nbody = \"uper\"", "\"uper\"", ["no body \"uper\"", "did you mean \"upper\"?"]),
        ("strain = \"mean\"\nbox = [0, 0, 1]", "[0, 0, 1]", ["3", ""]),
        ("strain = \"mean\"\nbox = [0, 0, -1, 1]", "[0, 0, -1, 1]", ["inside out", "[xmin, ymin"]),
        ("strain = \"mean\"\nbox = [5, 5, 6, 6]", "[5, 5, 6, 6]", ["no element has its centroid", "larger"]),
        ("node = [0, 0]\nbox = [0, 0, 1, 1]", "box", ["\"box\" goes with", ""]),
        ("contact_force = [\"uper\", \"block\"]", "\"uper\"", ["no body \"uper\"", "did you mean"]),
        ("contact_force = [\"block\", \"block\"]", "[\"block\", \"block\"]", ["on both sides", ""]),
        ("contact_force = [\"block\", \"upper\"]\nbody = \"block\"", "body", ["\"body\" goes with", ""]),
        ("gauge = [[0.1, 0.1], [0.1, 0.1]]", "[[0.1, 0.1], [0.1, 0.1]]", ["the same", ""]),
        (
            "gauge = [[0.1, 0.1], [0.1, 0.1, 0.2]]",
            "[[0.1, 0.1], [0.1, 0.1, 0.2]]",
            ["3 numbers", "[[x, y], [x, y]]"],
        ),
        (
            "gauge = [[0.1, 0.1], [0.1, 8]]",
            "[[0.1, 0.1], [0.1, 8]]",
            ["outside of all bodies", "nearest body is \"upper\""],
        ),
        ("reaction = \"outr\"", "\"outr\"", ["no body here has a group \"outr\"", "did you mean \"outer\"?"]),
        ("stress = \"mean\"\nstrain = \"mean\"", "name", ["is of one quantity", "gauge"]),
    ] {
        let text = with(&format!("[[history]]\nname = \"h\"\n{keys}\n"));
        let errors = read(&text).unwrap_err();
        let list = errors.to_string();
        let spots: Vec<_> =
            errors.faults.iter().filter_map(|fault| fault.span.clone()).map(|span| &text[span]).collect();
        assert!(errors.faults.len() == 1 && spots == [at], "{keys}: {spots:?}\n{list}");
        for part in parts {
            assert!(list.contains(part), "{keys}: {part:?} is not in\n{list}");
        }
    }
}

#[test]
fn curves_are_of_columns_that_there_are() {
    let histories = "[[history]]\nname = \"axial\"\ngauge = [[0.1, 0.25], [0.9, 0.25]]\n[[history]]\nname = \"push\"\ncontact_force = [\"upper\", \"block\"]\n";
    let curve = |keys: &str| with(&format!("{histories}[[curve]]\nname = \"c\"\n{keys}\n"));
    let prepared = right(&curve("x = \"axial strain\"\ny = \"push fy [N]\"\narea = 0.5"));
    let found = &prepared.curves[0];
    assert_eq!(
        (found.x.as_str(), found.y.as_str(), found.area),
        ("axial strain [m/m]", "push fy [N]", Some(0.5))
    );
    for (keys, at, parts) in [
        (
            "x = \"axal strain\"\ny = \"time\"",
            "\"axal strain\"",
            ["no column", "did you mean \"axial strain\"?"],
        ),
        // The columns of the history that is named first.
        (
            "x = \"time\"\ny = \"push displacement\"",
            "\"push displacement\"",
            ["no column", "there is push fx, push fy"],
        ),
        ("x = \"time\"\ny = \"axial strain\"\narea = 2", "area", ["divides a column in [N]", "axial strain"]),
        ("x = \"time\"\ny = \"push fy\"\nlength = 2", "length", ["divides a column in [m]", "time"]),
    ] {
        let text = curve(keys);
        let errors = read(&text).unwrap_err();
        let list = errors.to_string();
        let spots: Vec<_> =
            errors.faults.iter().filter_map(|fault| fault.span.clone()).map(|span| &text[span]).collect();
        assert!(errors.faults.len() == 1 && spots == [at], "{keys}: {spots:?}\n{list}");
        assert!(parts.iter().all(|part| list.contains(part)), "{keys}: {list}");
    }
}

/// A model with a joint set, and a history of this joint set.
fn with_joints(history: &str) -> String {
    with(&format!(
        "[[joint_set]]\nname = \"fault\"\nlines = [[0, 0.25, 1, 0.25]]\nfriction_angle = 30\n[[history]]\nname = \"h\"\n{history}\n"
    ))
}

#[test]
fn a_joint_set_is_a_probe() {
    let prepared = right(&with_joints("joint_set = \"fault\""));
    assert_eq!(prepared.probes, [Probe::JointSet("fault".to_owned())]);
    let names = fdem_model::columns(&prepared.histories, &prepared.probes);
    assert_eq!(names, ["h opening [m]", "h slip [m]", "h normal_stress [Pa]", "h shear_stress [Pa]"]);
    for (history, part) in [
        ("joint_set = \"falt\"", "there is no joint set \"falt\""),
        ("joint_set = \"falt\"", "did you mean \"fault\"?"),
        ("joint_set = \"fault\"\nbody = \"block\"", "\"body\" goes with"),
        ("joint_set = \"fault\"\nstress = \"mean\"", "is of one quantity"),
    ] {
        let errors = read(&with_joints(history)).unwrap_err().to_string();
        assert!(errors.contains(part), "{history}: {part:?} is not in\n{errors}");
    }
}

/// A model with rigid bodies: one alone, copies of one, and one that turns about an axis.
fn with_rigid(history: &str) -> String {
    let body = |name: &str, more: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"rock\"\nrigid = true\nmesh_size = 0.1\nrectangle = {more}\n"
        )
    };
    with(
        &[
            body("jaw", "{ min = [2, 0], max = [2.2, 0.5] }"),
            body("wall", "{ min = [3, 0], max = [3.2, 0.5] }\nrepeat = [2, 1]\nspacing = [0.3, 0]"),
            "[[boundary]]\nname = \"drive\"\nbody = \"jaw\"\nrotation = { through = [2, 0], speed = 90 }\n"
                .to_owned(),
            format!("[[history]]\nname = \"h\"\n{history}\n"),
        ]
        .concat(),
    )
}

#[test]
fn the_motion_of_a_rigid_body_is_a_probe_and_the_torque_of_a_boundary_a_column() {
    let prepared = right(&with_rigid("motion = \"jaw\""));
    assert_eq!(prepared.probes, [Probe::RigidBody(2)]);
    let names = fdem_model::columns(&prepared.histories, &prepared.probes);
    assert_eq!(names, ["h ux [m]", "h uy [m]", "h vx [m/s]", "h vy [m/s]", "h rz [rad]", "h wz [rad/s]"]);
    let last = right(&with_rigid("motion = \"wall-2-1\""));
    assert_eq!(last.probes, [Probe::RigidBody(4)]);
    let turned = right(&with_rigid("force = \"drive\""));
    let place = turned.model.boundaries.iter().position(|boundary| boundary.name == "drive").unwrap();
    assert_eq!(turned.histories[0].quantity, Quantity::Torque(place, [0.0, 0.0, 1.0]));
    let names = fdem_model::columns(&turned.histories, &turned.probes);
    assert_eq!(names, ["h fx [N]", "h fy [N]", "h ux [m]", "h uy [m]", "h torque [N m]"]);
    for (history, parts) in [
        ("motion = \"jw\"", ["there is no body \"jw\"", "did you mean \"jaw\"?"]),
        ("motion = \"block\"", ["the body \"block\" is not rigid", "rigid = true"]),
        ("motion = \"wall\"", ["\"wall\" is several bodies", "\"wall-1-1\""]),
        ("motion = \"jaw\"\nbody = \"jaw\"", ["\"body\" goes with", ""]),
        ("motion = \"jaw\"\nstress = \"mean\"", ["is of one quantity", "motion = "]),
    ] {
        let errors = read(&with_rigid(history)).unwrap_err().to_string();
        assert!(parts.iter().all(|part| errors.contains(part)), "{history}: {parts:?} in\n{errors}");
    }
}

#[test]
fn curves_with_softening_joints_and_lateral_strains() {
    let histories = "[[history]]\nname = \"a\"\ngauge = [[0.1, 0.25], [0.9, 0.25]]\n[[history]]\nname = \"l\"\ngauge = [[0.5, 0.1], [0.5, 0.4]]\n[[history]]\nname = \"push\"\ncontact_force = [\"upper\", \"block\"]\n[[history]]\nname = \"c\"\nsoftening = true\n";
    let curve =
        |keys: &str| with(&format!("{histories}[[curve]]\nname = \"test\"\ny = \"push fy\"\n{keys}\n"));
    let prepared =
        right(&curve("x = \"a strain\"\nsoftening = \"c softening_length\"\nlateral = [\"l strain\"]"));
    assert_eq!(prepared.probes[3], Probe::Softening);
    let found = &prepared.curves[0];
    assert_eq!(found.softening.as_deref(), Some("c softening_length [m]"));
    assert_eq!(found.lateral, ["l strain [m/m]"]);
    for (keys, part) in [
        ("x = \"a strain\"\nlateral = [\"push fx\"]", "\"lateral\" is strains, and \"push fx [N]\" is none"),
        ("x = \"time\"\nlateral = [\"l strain\"]", "\"lateral\" goes with a strain"),
        ("x = \"a strain\"\nlateral = [\"l strain\", \"a strain\"]", "has 1 lateral strains, not 2"),
        ("x = \"a strain\"\nsoftening = \"c damaged_length\"", "\"c damaged_length [m]\" is none"),
        ("x = \"a strain\"\nsoftening = \"c soft\"", "no column \"c soft\""),
    ] {
        let errors = read(&curve(keys)).unwrap_err();
        let list = errors.to_string();
        assert!(errors.faults.len() == 1 && list.contains(part), "{keys}: {part:?} is not in\n{list}");
    }
}
