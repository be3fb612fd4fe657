use crate::common::*;
use crate::joint_sets::{halves, open};
use fdem_simulation::*;

fn square() -> Model {
    Model { mesh: rectangle([0.0; 2], [1.0; 2], 2, 2), materials: vec![granite()], ..Model::default() }
}

fn held(target: Target, load: Load) -> Boundary {
    Boundary { name: "jaw".to_owned(), target, load, schedule: Schedule::Constant }
}

/// Message with which a changed model is refused; "accepted" if it is not.
fn refusal(change: impl FnOnce(&mut Model)) -> String {
    let mut model = square();
    change(&mut model);
    match Simulation::new(model, 1) {
        Ok(_) => "accepted".to_owned(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn models_that_cannot_be_say_why() {
    assert_eq!(refusal(|_| ()), "accepted");
    assert_eq!(refusal(|m| m.mesh.elements.clear()), "the model has no elements and no spheres");
    assert_eq!(
        refusal(|m| m.materials[0].density = -1.0),
        "material 'granite': density is -1, it must be positive"
    );
    assert_eq!(
        refusal(|m| m.materials[0].youngs_modulus = f64::NAN),
        "material 'granite': Young's modulus is NaN, it must be positive"
    );
    assert!(refusal(|m| m.materials[0].poissons_ratio = 0.7).contains("at most 0.5"));
    assert!(
        refusal(|m| (m.plane, m.materials[0].poissons_ratio) = (Plane::Strain, 0.5)).contains("below 0.5")
    );
    assert!(refusal(|m| m.contact.buffer = 1e300).starts_with("contact detection: buffer"));
    assert_eq!(refusal(|m| m.mesh.elements[3][1] = 77), "element 3: there is no node 77");
    assert_eq!(refusal(|m| m.mesh.materials[2] = 5), "element 2: there is no material 5");
    assert_eq!(
        refusal(|m| m.mesh.nodes[4][1] = f64::INFINITY),
        "node 4: a coordinate is inf, it must be a finite number"
    );
    assert!(refusal(|m| m.mesh.elements[1].swap(0, 1)).starts_with("element 1 has an area, or volume, of -"));
    assert_eq!(refusal(|m| m.mesh.nodes.push([3.0; 2])), "node 9 belongs to no element");
    assert!(refusal(|m| m.mesh.bodies[7] = 1).contains("bodies share no nodes"));
    assert_eq!(refusal(|m| m.velocities = vec![[0.0; 2]; 3]), "3 initial velocities for 9");
    assert_eq!(refusal(|m| m.thickness = 0.0), "the model: thickness is 0, it must be positive");
    assert!(refusal(|m| m.time.safety = 1.5).contains("safety is 1.5"));
    let brittle = Strength { energy_i: 1e-9, ..rock() };
    let message = refusal(|m| {
        m.materials[0].strength = Some(brittle);
        m.fracture.insertion = Insertion::Intrinsic;
    });
    assert!(message.contains("store more than the fracture energy of opening"), "{message}");
    assert!(message.contains("fracture_energy_i must be above "), "{message}");
    assert!(!message.contains("above 0 J"), "{message}");
    let message = refusal(|m| {
        m.materials[0].strength = Some(Strength { cohesion: 1e30, ..rock() });
        m.fracture.insertion = Insertion::Intrinsic;
    });
    assert!(message.contains("e47 J/m²"), "no number has dozens of digits: {message}");
}

#[test]
fn shares_of_an_energy_are_not_written_as_nothing() {
    let stop = Stop::Energy { element: 0, step: 100, error: -2e-9, bound: 1e-12 }.to_string();
    assert!(stop.contains("off by -2.0e-7 %, more than 1.0e-10 %"), "{stop}");
    let stop = Stop::Energy { element: 0, step: 100, error: 0.0612, bound: 0.05 }.to_string();
    assert!(stop.contains("off by 6.12 %, more than 5.00 %"), "{stop}");
}

/// The key, the formula and the least value are those of the mode that has too little energy.
#[test]
fn too_small_an_energy_of_a_joint_set_names_the_key_and_the_least_value() {
    let none = Strength { tensile: 0.0, cohesion: 0.0, energy_i: 0.0, energy_ii: 0.0, ..rock() };
    let of = |strength: Strength| {
        let stiffness = Some(1e9);
        let set = JointSet { strength, normal_stiffness: stiffness, shear_stiffness: stiffness, ..open(0.5) };
        Simulation::new(halves(set, 0.1, 4), 1).err().map(|error| error.to_string()).unwrap_or_default()
    };
    let message = of(Strength { cohesion: 1e6, energy_ii: 400.0, ..none });
    assert!(message.contains("fracture energy of sliding"), "{message}");
    assert!(
        message.contains("fracture_energy_ii must be above cohesion²/(2 shear_stiffness) = 500 J/m²"),
        "{message}"
    );
    let message = of(Strength { tensile: 1e3, energy_i: 1e-4, ..none });
    assert!(
        message
            .contains("fracture_energy_i must be above tensile_strength²/(2 normal_stiffness) = 0.0005 J/m²"),
        "{message}"
    );
}

#[test]
fn boundaries_that_cannot_be_say_why() {
    let nodes = || Target::Nodes(vec![0, 1]);
    let push = Load::Velocity([Some(1.0), None]);
    assert_eq!(refusal(|m| m.boundaries = vec![held(nodes(), push)]), "accepted");
    assert_eq!(
        refusal(|m| m.boundaries = vec![held(Target::Nodes(vec![9]), push)]),
        "boundary 'jaw': there is no node 9"
    );
    assert_eq!(
        refusal(|m| m.boundaries = vec![held(nodes(), Load::Pressure(1.0))]),
        "boundary 'jaw' needs edges"
    );
    assert_eq!(
        refusal(|m| m.boundaries = vec![held(Target::Nodes(Vec::new()), push)]),
        "boundary 'jaw' needs nodes"
    );
    let inner = Target::Facets(vec![[0, 4]]);
    assert_eq!(
        refusal(|m| m.boundaries = vec![held(inner, Load::Pressure(1.0))]),
        "boundary 'jaw': no element has an outer edge from node 0 to node 4"
    );
    let twice = refusal(|m| m.boundaries = vec![held(nodes(), push), held(nodes(), push)]);
    assert_eq!(twice, "node 0 is moved along x by boundaries 'jaw' and 'jaw'");
    // Two boundaries may both fix a node at a corner.
    let fixed = Load::Velocity([Some(0.0), Some(0.0)]);
    assert_eq!(refusal(|m| m.boundaries = vec![held(nodes(), fixed), held(nodes(), fixed)]), "accepted");
    let table = |rows: Vec<[f64; 2]>| Boundary { schedule: Schedule::Table(rows), ..held(nodes(), push) };
    assert!(refusal(|m| m.boundaries = vec![table(Vec::new())]).contains("at least 1"));
    assert!(refusal(|m| m.boundaries = vec![table(vec![[0.0, 1.0], [0.0, 2.0]])]).contains("later than"));
}
