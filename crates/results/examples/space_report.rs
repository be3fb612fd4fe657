//! The page of a run in three dimensions: a plate of rock on its rim, which a block strikes and breaks. For a
//! look at the page, and for the tests in browsers.
//!
//! `cargo run --release -p fdem-results --example space_report -- FOLDER [CELLS [FRAMES [MOST_INSIDE]]]`
//!
//! The plate has `CELLS` by `CELLS` cells of 12 tetrahedra. With `FRAMES` 0 there is no run: the page has one
//! frame of a bent cube of `CELLS`³ cells.

use std::error::Error;
use std::f64::consts::PI;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use fdem_results::{
    ElementMasses, Field, Fragments, History, HistoryWriter, MOST_INSIDE, Names, Range, Row, Shell, Show,
    SpaceFrame, SpacePictures, SpaceReport, SpaceView, plots,
};
use fdem_simulation::{
    Boundary, FractureOptions, Load, Material, MaterialLaw, Mesh, Model, Schedule, Simulation, Snapshot,
    Strength, Target, TimeOptions,
};
use serde_json::json;

/// Duration of the run, s.
const END: f64 = 3e-4;
/// Sides and thickness of the plate, m.
const PLATE: [f64; 3] = [0.2, 0.2, 0.03];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(arguments.first().ok_or("a folder is needed")?);
    let number = |k: usize, usual: usize| arguments.get(k).map_or(Ok(usual), |text| text.parse());
    let (cells, count, most) = (number(1, 8)?, number(2, 30)?, number(3, MOST_INSIDE)?);
    fs::create_dir_all(&folder)?;
    let start = Instant::now();
    let took = |what: &str| eprintln!("{:8.3} s  {what}", start.elapsed().as_secs_f64());
    if count == 0 {
        return still(&folder, cells, most);
    }

    let model = struck_plate(cells);
    let shell = Shell::new(&model.mesh, &[]);
    let elements = model.mesh.elements.len().to_string();
    let masses = ElementMasses::of(&model)?;
    let mut run = Simulation::new(model, 1)?;
    let mut history = HistoryWriter::new(Vec::new(), 3, &[])?;
    let mut frames = Vec::new();
    for k in 0..count {
        let until = END * k as f64 / (count - 1).max(1) as f64;
        while run.time() < until {
            run.advance(10)?;
            let (step, time, energies) = (run.steps(), run.time(), run.energies());
            let broken = run.counts().broken as u64;
            history.row(&Row {
                step,
                time,
                energies,
                broken,
                lengths: run.crack_lengths(),
                ..Row::default()
            })?;
        }
        let snapshot = run.snapshot();
        frames.push(SpaceFrame::with_inside(&snapshot, &shell, most)?);
        if k == 0 || k + 1 == count {
            fs::write(folder.join(format!("expected_{k:04}.json")), expected(&snapshot).to_string())?;
        }
    }
    took("run and frames");
    let plots = plots(&History::read(history.get_mut())?);
    let names = Names {
        bodies: ["plate", "block"].map(String::from).to_vec(),
        materials: ["rock", "steel"].map(String::from).to_vec(),
    };
    let facts = [("model", "examples/space_report.rs"), ("elements", elements.as_str())];
    let field = Field::MAX_PRINCIPAL;
    let title = "A plate that a block strikes";
    let (range, view) = (Range::of_space(&frames, field), SpaceView::of(&frames));
    let pictures = SpacePictures { title, field, range, view, show: Show::Solid, cut: None };
    let preview = frames.last().map(|last| pictures.png(last, None)).transpose()?;
    let fragments = Fragments::of(&run.snapshot(), &masses)?;
    let report = SpaceReport {
        title,
        facts: &facts,
        plots: &plots,
        frames: &frames,
        fragments: &fragments,
        field,
        names: &names,
    };
    fs::write(folder.join("report.html"), report.html(preview.as_deref())?)?;
    took("page");
    Ok(())
}

/// A page of one frame, without a run: a cube of many elements that is bent, with a stress from a formula.
fn still(folder: &std::path::Path, cells: usize, most: usize) -> Result<(), Box<dyn Error>> {
    let mesh = cuboid([0.0; 3], [1.0; 3], [cells; 3]);
    let count = mesh.elements.len();
    let bent = |[x, y, z]: &[f64; 3]| [0.0, 0.1 * (PI * x).sin(), 0.05 * (PI * y).sin() * z];
    let displacements: Vec<[f64; 3]> = mesh.nodes.iter().map(bent).collect();
    let moved = mesh.nodes.iter().zip(&displacements).map(|(x, u)| [0, 1, 2].map(|axis| x[axis] + u[axis]));
    let stress = |element: &[u32; 4]| {
        let [x, y, z] = mesh.nodes[element[0] as usize];
        [1e6 * (4.0 * PI * x).sin(), 1e6 * (3.0 * PI * y).cos(), 0.0, 1e6 * z, 0.0, 0.0]
    };
    let snapshot = Snapshot {
        positions: moved.collect(),
        velocities: displacements.clone(),
        displacements,
        elements: mesh.elements.clone(),
        stresses: mesh.elements.iter().map(stress).collect(),
        damage: vec![0.0; count],
        bodies: mesh.bodies.clone(),
        materials: mesh.materials.clone(),
        fragments: vec![0; count],
        ..Snapshot::default()
    };
    let start = Instant::now();
    let took = |what: &str| eprintln!("{:8.3} s  {what}", start.elapsed().as_secs_f64());
    let shell = Shell::new(&mesh, &[]);
    took("shell");
    let frames = [SpaceFrame::with_inside(&snapshot, &shell, most)?];
    took("frame");
    let (field, names) = (Field::VON_MISES, Names::default());
    let report = SpaceReport {
        title: "A bent cube",
        facts: &[],
        plots: &[],
        frames: &frames,
        fragments: &Fragments::default(),
        field,
        names: &names,
    };
    fs::write(folder.join("report.html"), report.html(None)?)?;
    took("page");
    Ok(())
}

/// A plate whose rim is held from below, and a turned block that falls on its middle.
fn struck_plate(cells: usize) -> Model<3, 4> {
    let [x, y, z] = PLATE;
    let plate = cuboid([-x / 2.0, -y / 2.0, -z], [x / 2.0, y / 2.0, 0.0], [cells, cells, 2]);
    let mut block = cuboid([-0.03; 3], [0.03; 3], [3; 3]);
    for node in &mut block.nodes {
        *node = turned(*node);
    }
    let lowest = block.nodes.iter().map(|node| node[2]).fold(f64::INFINITY, f64::min);
    for node in &mut block.nodes {
        *node = [node[0] + 0.015, node[1] - 0.01, node[2] - lowest + 1e-4];
    }
    let rim = |[u, v, w]: &[f64; 3]| *w < -z + 1e-9 && (u.abs() > 0.499 * x || v.abs() > 0.499 * y);
    let held = (0..).zip(&plate.nodes).filter(|(_, node)| rim(node)).map(|(k, _): (u32, _)| k).collect();
    let velocities = [vec![[0.0; 3]; plate.nodes.len()], vec![[0.0, 0.0, -15.0]; block.nodes.len()]].concat();

    let strength = Strength {
        tensile: 5e6,
        cohesion: 15e6,
        friction: 0.6,
        energy_i: 40.0,
        energy_ii: 200.0,
        weibull_modulus: Some(6.0),
        seed: 3,
    };
    let rock = Material {
        name: "rock".to_owned(),
        density: 2600.0,
        youngs_modulus: 30e9,
        poissons_ratio: 0.2,
        law: MaterialLaw::NeoHookean,
        damping: 0.05,
        strength: Some(strength),
        friction: 0.5,
    };
    let steel = Material {
        name: "steel".to_owned(),
        density: 7800.0,
        youngs_modulus: 100e9,
        strength: None,
        ..rock.clone()
    };
    Model {
        mesh: together(plate, &block),
        velocities,
        materials: vec![rock, steel],
        gravity: [0.0, 0.0, -9.81],
        boundaries: vec![Boundary {
            name: "rim".to_owned(),
            target: Target::Nodes(held),
            load: Load::Velocity([None, None, Some(0.0)]),
            schedule: Schedule::Constant,
        }],
        fracture: FractureOptions { joint_penalty: 20.0, ..FractureOptions::default() },
        time: TimeOptions { safety: 0.8, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// A point turned about the x axis and then about the z axis.
fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    let ((s, c), (t, u)) = (0.5_f64.sin_cos(), 0.4_f64.sin_cos());
    let [y, z] = [c * y - s * z, s * y + c * z];
    [u * x - t * y, t * x + u * y, z]
}

/// Two bodies in one mesh, with different materials.
fn together(mut one: Mesh<3, 4>, other: &Mesh<3, 4>) -> Mesh<3, 4> {
    let first = one.nodes.len() as u32;
    one.nodes.extend(&other.nodes);
    one.elements.extend(other.elements.iter().map(|nodes| nodes.map(|node| node + first)));
    one.bodies.extend(other.bodies.iter().map(|_| 1));
    one.materials.extend(other.materials.iter().map(|_| 1));
    one
}

/// A box of `cells` cells along each axis, each of six tetrahedra around its diagonal. Nodes inside are moved
/// a little, so that cracks are not straight.
fn cuboid(min: [f64; 3], max: [f64; 3], cells: [usize; 3]) -> Mesh<3, 4> {
    const ORDERS: [([usize; 3], bool); 6] = [
        ([0, 1, 2], false),
        ([1, 2, 0], false),
        ([2, 0, 1], false),
        ([0, 2, 1], true),
        ([1, 0, 2], true),
        ([2, 1, 0], true),
    ];
    let size = cells.map(|count| count + 1);
    let number = |at: [usize; 3]| ((at[2] * size[1] + at[1]) * size[0] + at[0]) as u32;
    let mut mesh = Mesh::default();
    for k in 0..size.iter().product() {
        let at = [k % size[0], k / size[0] % size[1], k / size[0] / size[1]];
        mesh.nodes.push([0, 1, 2].map(|axis| {
            let inner = at[axis] > 0 && at[axis] < cells[axis];
            let moved = if inner { 0.3 * ((k * (7 + 5 * axis)) as f64 * 0.618).fract() - 0.15 } else { 0.0 };
            min[axis] + (at[axis] as f64 + moved) / cells[axis] as f64 * (max[axis] - min[axis])
        }));
    }
    for k in 0..cells.iter().product() {
        let cell = [k % cells[0], k / cells[0] % cells[1], k / cells[0] / cells[1]];
        for (order, odd) in ORDERS {
            let mut at = cell;
            let mut element = [number(at); 4];
            for (corner, axis) in (1..).zip(order) {
                at[axis] += 1;
                element[corner] = number(at);
            }
            if odd {
                element.swap(0, 1);
            }
            mesh.elements.push(element);
        }
    }
    mesh.bodies = vec![0; mesh.elements.len()];
    mesh.materials = mesh.bodies.clone();
    mesh
}

/// The numbers of a snapshot, for the tests.
fn expected(snapshot: &Snapshot<3, 4>) -> serde_json::Value {
    let cracks = snapshot.cracks.iter().map(|crack| {
        json!({
            "corners": crack.corners,
            "elements": crack.elements,
            "mode": crack.mode as i32,
            "opening": crack.opening,
            "time": crack.time,
            "area": crack.measure,
        })
    });
    let principal: Vec<[f64; 2]> =
        (0..snapshot.elements.len()).map(|element| snapshot.principal_stresses(element)).collect();
    json!({
        "time": snapshot.time,
        "step": snapshot.step,
        "positions": snapshot.positions,
        "displacements": snapshot.displacements,
        "velocities": snapshot.velocities,
        "elements": snapshot.elements,
        "stresses": snapshot.stresses,
        "principal": principal,
        "damage": snapshot.damage,
        "bodies": snapshot.bodies,
        "materials": snapshot.materials,
        "fragments": snapshot.fragments,
        "cracks": cracks.collect::<Vec<_>>(),
    })
}
