//! Fragments: masses and sizes of known bodies, a strip that breaks in two, in two and three dimensions.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use std::f64::consts::PI;

use fdem_mesh::Corners;
use fdem_results::{
    ElementMasses, Field, Fragments, Names, Report, SnapshotError, SpaceReport, fragment_sizes,
};
use fdem_simulation::{Element, Interface, Material, MaterialLaw, Mesh, Model, Simulation, Strength};

const DENSITY: f64 = 2500.0;
const THICKNESS: f64 = 0.1;

fn material(name: &str, strength: Option<Strength>) -> Material {
    Material {
        name: name.to_owned(),
        density: DENSITY,
        youngs_modulus: 1e9,
        poissons_ratio: 0.2,
        law: MaterialLaw::NeoHookean,
        damping: 0.0,
        strength,
        friction: 0.3,
    }
}

fn weak() -> Strength {
    Strength {
        tensile: 1e3,
        cohesion: 1e3,
        friction: 0.0,
        energy_i: 0.01,
        energy_ii: 0.01,
        weibull_modulus: None,
        seed: 0,
    }
}

/// Adds a body: a row of squares or cubes along x with nodes in common, each divided into simplices along the
/// paths from its lowest to its highest corner. Cells left of `middle` have material 0, the others
/// material 1.
fn add_row<const D: usize, const N: usize>(
    mesh: &mut Mesh<D, N>,
    origin: f64,
    side: f64,
    cells: usize,
    middle: f64,
) where
    [[f64; D]; N]: Corners<D, N>,
{
    let body = mesh.bodies.last().map_or(0, |last| last + 1);
    let first = mesh.nodes.len();
    let section = 1 << (D - 1);
    for layer in 0..=cells {
        for corner in 0..section {
            mesh.nodes.push(std::array::from_fn(|axis| match axis {
                0 => origin + side * layer as f64,
                axis => side * f64::from((corner >> (axis - 1)) & 1),
            }));
        }
    }
    let orders: Vec<Vec<usize>> =
        if D == 2 { vec![vec![0, 1], vec![1, 0]] } else { (0..6).map(|k| permutation(k).to_vec()).collect() };
    for cell in 0..cells {
        for order in &orders {
            let mut at = [0; D];
            let mut nodes = vec![first + section as usize * cell];
            for &axis in order {
                at[axis] = 1;
                let corner: usize = (1..D).map(|axis| at[axis] << (axis - 1)).sum();
                nodes.push(first + section as usize * (cell + at[0]) + corner);
            }
            let mut element: [u32; N] = std::array::from_fn(|k| nodes[k] as u32);
            if element.map(|node| mesh.nodes[node as usize]).measure() < 0.0 {
                element.swap(0, 1);
            }
            mesh.elements.push(element);
            mesh.bodies.push(body);
            mesh.materials.push(u32::from(origin + side * (cell as f64 + 0.5) > middle));
        }
    }
}

/// The orders of three axes.
fn permutation(k: usize) -> [usize; 3] {
    [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]][k]
}

/// Area of a square or volume of a cube.
fn power<const D: usize>(side: f64) -> f64 {
    [side; D].iter().product()
}

/// A strip of two materials, whose halves fly apart and break where they meet.
fn breaking_strip<const D: usize, const N: usize>()
where
    [[f64; D]; N]: Element<D, N> + Corners<D, N>,
{
    const SIDE: f64 = 0.25;
    let mut mesh = Mesh::default();
    add_row(&mut mesh, -3.0 * SIDE, SIDE, 6, 0.0);
    let velocity = |node: &[f64; D]| {
        let mut velocity = [0.0; D];
        velocity[0] = if node[0].abs() < 1e-9 { 0.0 } else { node[0].signum() };
        velocity
    };
    let model = Model {
        velocities: mesh.nodes.iter().map(velocity).collect(),
        mesh,
        materials: vec![material("left", None), material("right", None)],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.3,
            penalty: None,
            strength: Some(weak()),
        }],
        thickness: if D == 2 { THICKNESS } else { 1.0 },
        ..Model::default()
    };
    let masses = ElementMasses::of(&model).unwrap();
    let mut run = Simulation::new(model, 1).unwrap();
    let before = Fragments::of(&run.snapshot(), &masses).unwrap();
    assert_eq!((before.count().number, before.count().largest), (1, 1.0));
    assert_eq!(fragment_sizes(&before.sizes()), None, "one fragment has no distribution");

    let broken = if D == 2 { 1 } else { 2 };
    while run.counts().broken < broken && run.steps() < 5000 {
        run.advance(10).unwrap();
    }
    assert_eq!(run.counts().broken, broken);
    let fragments = Fragments::of(&run.snapshot(), &masses).unwrap();
    assert_eq!(masses.count(&run.fragments()), fragments.count());
    let [one, other] = fragments.all() else { panic!("{:?}", fragments.all()) };
    assert!((fragments.count().largest - 0.5).abs() < 1e-12);
    let measure = 3.0 * power::<D>(SIDE);
    let mass = DENSITY * measure * if D == 2 { THICKNESS } else { 1.0 };
    for half in [one, other] {
        assert_eq!(half.elements as usize, run.model().mesh.elements.len() / 2);
        assert!((half.mass / mass - 1.0).abs() < 1e-12 && (half.measure / measure - 1.0).abs() < 1e-12);
        assert!(half.velocity[0] * half.centre[0] > 0.0, "{half:?} flies away from the other");
        assert!((half.centre[0].abs() / (1.5 * SIDE) - 1.0).abs() < 0.02, "{half:?}");
        assert!((half.size[0] / (3.0 * SIDE) - 1.0).abs() < 0.02 && (half.size[1] / SIDE - 1.0).abs() < 0.02);
        let sizes = fragments.sizes();
        assert!((sizes.size(0.5).unwrap() / half.diameter - 1.0).abs() < 1e-12);
    }
    // Nodes belong to one fragment each, so that no energy is counted twice or left out.
    let snapshot = run.snapshot();
    let mut lumped = vec![0.0; snapshot.positions.len()];
    for (element, corners) in snapshot.elements.iter().enumerate() {
        let of_element = run.model().mesh.elements[element].map(|node| run.model().mesh.nodes[node as usize]);
        let share = of_element.measure() * mass / measure / N as f64;
        for &node in corners {
            lumped[node as usize] += share;
        }
    }
    let square = |velocity: &[f64; D]| velocity.iter().map(|v| v * v).sum::<f64>();
    let kinetic: f64 = lumped.iter().zip(&snapshot.velocities).map(|(m, v)| 0.5 * m * square(v)).sum();
    let found: f64 = fragments.all().iter().map(|fragment| fragment.kinetic).sum();
    assert!((found / kinetic - 1.0).abs() < 1e-12 && kinetic > 0.1 * mass, "{found} {kinetic}");
}

#[test]
fn a_strip_that_breaks_in_two_gives_two_equal_fragments() {
    breaking_strip::<2, 3>();
}

#[test]
fn a_beam_that_breaks_in_two_gives_two_equal_fragments() {
    breaking_strip::<3, 4>();
}

/// Squares or cubes with sides of 1, 2 and 3 m, from left to right.
fn three<const D: usize, const N: usize>(materials: Vec<Material>, middle: f64) -> Model<D, N>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let mut mesh = Mesh::default();
    for (origin, side) in [(0.0, 1.0), (2.0, 2.0), (5.0, 3.0)] {
        add_row(&mut mesh, origin, side, 1, middle);
    }
    Model { mesh, materials, thickness: if D == 2 { THICKNESS } else { 1.0 }, ..Model::default() }
}

fn fragments_of<const D: usize, const N: usize>(model: Model<D, N>) -> Fragments<D>
where
    [[f64; D]; N]: Element<D, N> + Corners<D, N>,
{
    let masses = ElementMasses::of(&model).unwrap();
    Fragments::of(&Simulation::new(model, 1).unwrap().snapshot(), &masses).unwrap()
}

fn known_sizes<const D: usize, const N: usize>(measure_to_diameter: fn(f64) -> f64)
where
    [[f64; D]; N]: Element<D, N> + Corners<D, N>,
{
    let model = three::<D, N>(vec![material("rock", Some(weak()))], f64::INFINITY);
    let fragments = fragments_of(model);
    let thick = if D == 2 { THICKNESS } else { 1.0 };
    let measures = [3.0_f64, 2.0, 1.0].map(power::<D>);
    assert_eq!(fragments.all().len(), 3);
    for ((fragment, measure), body) in fragments.all().iter().zip(measures).zip([2, 1, 0]) {
        assert_eq!((fragment.body, fragment.number), (body, body), "the heaviest is the first");
        assert!((fragment.measure / measure - 1.0).abs() < 1e-12);
        assert!((fragment.mass / (measure * thick * DENSITY) - 1.0).abs() < 1e-12);
        assert!((fragment.diameter / measure_to_diameter(measure) - 1.0).abs() < 1e-12);
        let side = f64::from(body + 1);
        assert!(fragment.size.iter().all(|size| (size - side).abs() < 1e-12), "{fragment:?}");
        assert!(fragment.centre[1..].iter().all(|at| (at - side / 2.0).abs() < 1e-12), "{fragment:?}");
        assert_eq!((fragment.velocity, fragment.kinetic), ([0.0; D], 0.0));
    }
    let all: f64 = measures.iter().sum();
    let sum: f64 = fragments.all().iter().map(|fragment| fragment.mass).sum();
    assert!((sum / (all * thick * DENSITY) - 1.0).abs() < 1e-12, "the masses sum to the whole");
    assert!((fragments.count().largest - measures[0] / all).abs() < 1e-12);

    let sizes = fragments.sizes();
    assert!(sizes.sizes().is_sorted() && sizes.shares().is_sorted());
    assert_eq!((sizes.shares()[0], *sizes.shares().last().unwrap()), (0.0, 1.0));
    // Half of the mass lies between the two larger ones.
    let [low, high] = [measures[1] + measures[2], all].map(|sum| sum / all);
    let [small, large] = [measures[1], measures[0]].map(measure_to_diameter);
    let expected = small + (0.5 - low) / (high - low) * (large - small);
    assert!((sizes.size(0.5).unwrap() - expected).abs() < 1e-12);
    let plot = fragment_sizes(&sizes).unwrap();
    assert!(plot.svg.contains("equivalent diameter (m)") && !plot.svg.contains("NaN"));
    assert!(plot.png(None).is_ok());
}

#[test]
fn sizes_of_squares_and_cubes_are_known() {
    known_sizes::<2, 3>(|area| (4.0 * area / PI).sqrt());
    known_sizes::<3, 4>(|volume| (6.0 * volume / PI).cbrt());
}

#[test]
fn the_table_has_a_line_for_each_fragment() {
    let names =
        Names { bodies: ["small", "a, \"b\"", "large"].map(String::from).to_vec(), materials: Vec::new() };
    let table = fragments_of(three::<2, 3>(vec![material("rock", None)], f64::INFINITY)).csv(&names);
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 4);
    assert_eq!(
        lines[0],
        "fragment,body,counted,elements,mass,area,diameter,x,y,vx,vy,kinetic,size_x,size_y,body_name"
    );
    assert!(lines[1].starts_with("2,2,1,2,2250,9,3.385137501286538,6.5,1.5,0,0,0,3,3,large"), "{}", lines[1]);
    assert!(lines[2].ends_with(",2,2,\"a, \"\"b\"\"\""), "{}", lines[2]);
    let table = fragments_of(three::<3, 4>(vec![material("rock", None)], f64::INFINITY)).csv(&names);
    let head = "fragment,body,counted,elements,mass,volume,diameter,x,y,z,vx,vy,vz,kinetic,size_x,size_y,size_z,body_name";
    assert_eq!(table.lines().next(), Some(head));
    assert!(table.lines().all(|line| line.contains("\"\"") || line.split(',').count() == 18), "{table}");
}

/// A platen is no fragment. Without a body that can break, all bodies are.
#[test]
fn bodies_that_cannot_break_do_not_count() {
    let materials = vec![material("rock", Some(weak())), material("steel", None)];
    let fragments = fragments_of(three::<2, 3>(materials.clone(), 4.5));
    assert_eq!(fragments.all().iter().map(|one| one.counted).collect::<Vec<_>>(), [false, true, true]);
    assert_eq!((fragments.count().number, fragments.count().largest), (2, 0.8));
    assert!((fragments.sizes().size(1.0).unwrap() - (16.0 / PI).sqrt()).abs() < 1e-12);
    let model = three::<2, 3>(materials.clone(), 4.5);
    let chosen = ElementMasses::of(&model).unwrap().counting(&[2, 9]);
    let count = chosen.count(&Simulation::new(model, 1).unwrap().fragments());
    assert_eq!((count.number, count.largest), (1, 1.0));
    let whole = vec![materials[1].clone(), materials[1].clone()];
    assert_eq!(fragments_of(three::<2, 3>(whole, 4.5)).count().number, 3);
}

#[test]
fn a_snapshot_of_another_model_is_refused() {
    let model = three::<2, 3>(vec![material("rock", None)], f64::INFINITY);
    let masses = ElementMasses::of(&model).unwrap();
    let mut snapshot = Simulation::new(model.clone(), 1).unwrap().snapshot();
    let mut short = Mesh::default();
    add_row(&mut short, 0.0, 1.0, 1, f64::INFINITY);
    let few = ElementMasses::of(&Model { mesh: short, ..model.clone() }).unwrap();
    let length = |name, found, expected| Err(SnapshotError::Length { name, found, expected });
    assert_eq!(Fragments::of(&snapshot, &few), length("masses", 2, 6));
    snapshot.fragments.pop();
    assert_eq!(Fragments::of(&snapshot, &masses), length("fragments", 5, 6));
    let without = Model { materials: Vec::new(), ..model };
    let missing = SnapshotError::Material { element: 0, material: 0, materials: 0 };
    assert_eq!(ElementMasses::of(&without), Err(missing));
}

#[test]
fn the_page_has_the_heaviest_fragments() {
    let names =
        Names { bodies: ["small", "</td><b>", "large"].map(String::from).to_vec(), ..Names::default() };
    let rock = || vec![material("rock", None)];
    let flat = fragments_of(three::<2, 3>(rock(), f64::INFINITY));
    let report = Report {
        title: "squares",
        facts: &[],
        plots: &[],
        frames: &[],
        fragments: &flat,
        field: Field::DAMAGE,
        names: &names,
    };
    let page = report.html().unwrap();
    assert!(page.contains(
        "The 3 fragments at the end, the heaviest first. The diameter is that of a disc of the same area."
    ));
    assert!(page.contains("<tr><td>2</td><td>large</td><td>2</td><td>2250</td><td>64.2857</td><td>9</td><td>3.38514</td><td>0</td></tr>"));
    assert!(page.contains("<td>&lt;/td&gt;&lt;b&gt;</td>"), "names from outside are text");
    let none = Report { fragments: &Fragments::default(), ..report }.html().unwrap();
    assert!(!none.contains("fragments-table"));

    let space = fragments_of(three::<3, 4>(rock(), f64::INFINITY));
    let report = SpaceReport {
        title: "cubes",
        facts: &[],
        plots: &[],
        frames: &[],
        fragments: &space,
        field: Field::DAMAGE,
        names: &names,
    };
    let page = report.html(None).unwrap();
    assert!(page.contains("sphere of the same volume") && page.contains("<td>75</td><td>27</td>"), "{page}");

    // Bodies that cannot break do not count beside those that can.
    let materials = vec![material("rock", Some(weak())), material("steel", None)];
    let fragments = fragments_of(three::<2, 3>(materials, 4.5));
    let report = Report {
        title: "squares",
        facts: &[],
        plots: &[],
        frames: &[],
        fragments: &fragments,
        field: Field::DAMAGE,
        names: &names,
    };
    assert!(report.html().unwrap().contains("The 2 fragments at the end"));
}
