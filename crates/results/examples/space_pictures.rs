//! Pictures of bodies of tetrahedra, without a display: a cube, a ball, a cut, and a prism that a simulation
//! crushes, with its cracks and an animation.
//!
//! `cargo run --release -p fdem-results --example space_pictures -- FOLDER [CELLS [WIDTH]]`
//!
//! The prism has `CELLS` cells of 6 tetrahedra along its shorter sides. `WIDTH` of the pictures, pixels: 900
//! by default.

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use fdem_results::{Cut, Field, Range, Shell, Show, SpaceAnimation, SpaceFrame, SpacePictures, SpaceView};
use fdem_simulation::{
    Boundary, FractureOptions, Load, Material, MaterialLaw, Mesh, Model, Schedule, Simulation, Snapshot,
    Strength, Target, TimeOptions,
};

/// Sides of the prism, m.
const PRISM: [f64; 3] = [0.05, 0.05, 0.1];
/// Duration of the run, s, and the number of its frames.
const END: f64 = 4e-4;
const FRAMES: usize = 25;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(arguments.first().ok_or("a folder is needed")?);
    let cells: usize = arguments.get(1).map_or(Ok(5), |text| text.parse())?;
    let width: Option<u32> = arguments.get(2).map(|text| text.parse()).transpose()?;
    fs::create_dir_all(&folder)?;
    let start = Instant::now();
    let took = |what: &str| eprintln!("{:8.3} s  {what}", start.elapsed().as_secs_f64());
    let write = |name: &str, pictures: &SpacePictures<'_>, frame: &SpaceFrame| {
        fs::write(folder.join(format!("{name}.png")), pictures.png(frame, width)?)?;
        took(name);
        Ok::<(), Box<dyn Error>>(())
    };

    let cube = cuboid([-0.5; 3], [0.5; 3], [4; 3]);
    let ball = Mesh { nodes: cube_of(24).nodes.into_iter().map(rounded).collect(), ..cube_of(24) };
    for (name, title, mesh) in [("cube", "A cube", cube), ("ball", "A ball", ball)] {
        let frames = [SpaceFrame::new(&still(&mesh), &Shell::new(&mesh, &[]))?];
        let field = Field::MAX_PRINCIPAL;
        let view = SpaceView::of(&frames);
        let pictures = SpacePictures {
            title,
            field,
            range: Range::of_space(&frames, field),
            view,
            show: Show::Solid,
            cut: None,
        };
        write(name, &pictures, &frames[0])?;
        let field = Field::VELOCITY;
        let aslant = Cut { normal: [0.3, -1.0, 0.4], offset: 0.05 };
        for (cut, name) in [(Cut::across(1, 0.0), format!("{name}_cut")), (aslant, format!("{name}_aslant"))]
        {
            let range = Range::of_space(&frames, field);
            write(&name, &SpacePictures { cut: Some(cut), field, range, ..pictures }, &frames[0])?;
        }
    }

    let model = crushed_prism(cells);
    let shell = Shell::new(&model.mesh, &[]);
    let mut run = Simulation::new(model, 2)?;
    let mut frames = Vec::new();
    for k in 0..FRAMES {
        while run.time() < END * k as f64 / (FRAMES - 1) as f64 {
            run.advance(10)?;
        }
        frames.push(SpaceFrame::new(&run.snapshot(), &shell)?);
    }
    took("run");
    let (field, view) = (Field::MIN_PRINCIPAL, SpaceView::of(&frames));
    let pictures = SpacePictures {
        title: "A prism that is crushed",
        field,
        range: Range::of_space(&frames, field),
        view,
        show: Show::Solid,
        cut: None,
    };
    let last = &frames[FRAMES - 1];
    write("prism_start", &pictures, &frames[2])?;
    write("prism", &pictures, last)?;
    write("prism_cracks", &SpacePictures { show: Show::Cracks, ..pictures }, last)?;
    let field = Field::VELOCITY;
    let speeds = SpacePictures { field, range: Range::of_space(&frames, field), ..pictures };
    write("prism_cut", &SpacePictures { cut: Some(Cut::across(1, 0.0)), ..speeds }, last)?;
    write("prism_below", &SpacePictures { view: view.seen_from(-60.0, -20.0), ..speeds }, last)?;
    write("prism_bodies", &SpacePictures { field: Field::BODY, ..pictures }, last)?;
    fs::write(folder.join("prism.svg"), pictures.svg(last)?)?;
    for (name, pictures) in
        [("prism", pictures), ("prism_cracks", SpacePictures { show: Show::Cracks, ..pictures })]
    {
        let mut animation = SpaceAnimation::new(pictures, width, 8);
        for frame in &frames {
            animation.push(frame)?;
        }
        fs::write(folder.join(format!("{name}.gif")), animation.finish()?)?;
        took("animation");
    }
    Ok(())
}

/// A cube of edge 2 around the origin.
fn cube_of(cells: usize) -> Mesh<3, 4> {
    cuboid([-1.0; 3], [1.0; 3], [cells; 3])
}

/// Moves a point of a cube to a ball: cubes inside the cube become spheres.
fn rounded([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (longest, length) = (x.abs().max(y.abs()).max(z.abs()), (x * x + y * y + z * z).sqrt());
    if length > 0.0 { [x, y, z].map(|x| 0.5 * x * longest / length) } else { [0.0; 3] }
}

/// A body at rest, with a stress and a velocity that depend on the place.
fn still(mesh: &Mesh<3, 4>) -> Snapshot<3, 4> {
    let count = mesh.elements.len();
    let stress = |element: &[u32; 4]| {
        let [x, y, z] = mesh.nodes[element[0] as usize];
        [1e6 * (x + z), 0.0, 1e6 * y * z, 0.0, 0.0, 0.0]
    };
    Snapshot {
        positions: mesh.nodes.clone(),
        displacements: vec![[0.0; 3]; mesh.nodes.len()],
        velocities: mesh.nodes.iter().map(|[x, y, z]| [-y, *x, 0.5 * z]).collect(),
        elements: mesh.elements.clone(),
        stresses: mesh.elements.iter().map(stress).collect(),
        damage: vec![0.0; count],
        bodies: mesh.bodies.clone(),
        materials: mesh.materials.clone(),
        fragments: vec![0; count],
        ..Snapshot::default()
    }
}

/// A prism whose ends approach each other.
fn crushed_prism(cells: usize) -> Model<3, 4> {
    let [x, y, z] = PRISM;
    let mesh = cuboid([-x / 2.0, -y / 2.0, 0.0], [x / 2.0, y / 2.0, z], [cells, cells, 2 * cells]);
    let at = |height: f64| -> Vec<u32> {
        (0..).zip(&mesh.nodes).filter(|(_, node)| (node[2] - height).abs() < 1e-9).map(|(k, _)| k).collect()
    };
    let moved = |name: &str, height: f64, speed: f64| Boundary {
        name: name.to_owned(),
        target: Target::Nodes(at(height)),
        load: Load::Velocity([Some(0.0), Some(0.0), Some(speed)]),
        schedule: Schedule::Ramp(5e-5),
    };
    let strength = Strength {
        tensile: 4e6,
        cohesion: 25e6,
        friction: 0.6,
        energy_i: 20.0,
        energy_ii: 100.0,
        weibull_modulus: Some(8.0),
        seed: 1,
    };
    let rock = Material {
        name: "rock".to_owned(),
        density: 2600.0,
        youngs_modulus: 20e9,
        poissons_ratio: 0.25,
        law: MaterialLaw::NeoHookean,
        damping: 0.1,
        strength: Some(strength),
        friction: 0.5,
    };
    Model {
        boundaries: vec![moved("bottom", 0.0, 0.0), moved("top", z, -4.0)],
        velocities: vec![[0.0; 3]; mesh.nodes.len()],
        mesh,
        materials: vec![rock],
        fracture: FractureOptions { joint_penalty: 50.0, ..FractureOptions::default() },
        time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// A box of `cells` cells along each axis, each of six tetrahedra around its diagonal.
fn cuboid(min: [f64; 3], max: [f64; 3], cells: [usize; 3]) -> Mesh<3, 4> {
    let number = |at: [usize; 3]| ((at[2] * (cells[1] + 1) + at[1]) * (cells[0] + 1) + at[0]) as u32;
    let mut mesh = Mesh::default();
    for k in 0..=cells[2] {
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let share = [i, j, k].map(|k| k as f64);
                let along =
                    |axis: usize| min[axis] + share[axis] / cells[axis] as f64 * (max[axis] - min[axis]);
                mesh.nodes.push([0, 1, 2].map(along));
            }
        }
    }
    for cell in 0..cells.iter().product() {
        let cell = [cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]];
        for (order, odd) in [
            ([0, 1, 2], false),
            ([1, 2, 0], false),
            ([2, 0, 1], false),
            ([0, 2, 1], true),
            ([1, 0, 2], true),
            ([2, 1, 0], true),
        ] {
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
    mesh.materials = vec![0; mesh.elements.len()];
    mesh
}
