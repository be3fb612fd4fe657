//! Pages and pictures of spheres and discs that fall among walls, without a run: for a look at them, and for
//! the tests in browsers.
//!
//! `cargo run --release -p fdem-results --example sphere_report -- FOLDER [SIDE [FRAMES [flat]]]`
//!
//! There are `SIDE`³ spheres above a block of tetrahedra in a box with a hopper, or, with `flat`, `SIDE`²
//! discs above two triangles. Their positions are those of a formula. `expected.json` has the spheres of the
//! last frame.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fdem_results::{
    Field, Fragments, Frame, FrameView, Names, Outlines, Pictures, Range, Report, Shell, Show, SpaceFrame,
    SpacePictures, SpaceReport, SpaceView,
};
use fdem_simulation::grains::{GrainContact, GrainPartner, SphereColumns, Wall, WallShape};
use fdem_simulation::{Mesh, Snapshot};
use serde_json::json;

/// Largest radius of a sphere, m. Neighbours of this radius overlap a little.
const RADIUS: f64 = 0.0107;
/// Distance of the middles of neighbours, m.
const APART: f64 = 0.02;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(arguments.first().ok_or("a folder is needed")?);
    let number = |k: usize, usual: usize| arguments.get(k).map_or(Ok(usual), |text| text.parse());
    let (side, count) = (number(1, 8)?, number(2, 4)?);
    let is_flat = arguments.get(3).is_some_and(|word| word == "flat");
    fs::create_dir_all(&folder)?;
    let start = Instant::now();
    if is_flat {
        flat(&folder, side, count)?;
    } else {
        space(&folder, side, count)?;
    }
    eprintln!("{:8.3} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// A number from 0 to 1 that looks random.
fn noise(seed: usize) -> f64 {
    let mixed = (seed as u64 ^ 0x9e37_79b9).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ mixed >> 29).wrapping_mul(0x94d0_49bb_1331_11eb);
    (mixed >> 40) as f64 / f64::from(1_u32 << 24)
}

/// Spheres in layers, the share of a fall done.
fn spheres(layers: [usize; 3], share: f64) -> SphereColumns {
    let [columns, rows, heights] = layers;
    let mut found = SphereColumns::default();
    for k in 0..columns * rows * heights {
        let [i, j, l] = [k % columns, k / columns % rows, k / columns / rows];
        let away = |seed: usize, x: usize| (x as f64 + 0.5 + 0.06 * (noise(seed) - 0.5)) * APART;
        let height = away(7 * k + 2, l) + 0.4 * APART * (1.0 - share) * l as f64;
        let is_flat = rows == 1;
        found.numbers.push(k as u32);
        let [y, z] = if is_flat { [height, 0.0] } else { [away(7 * k + 1, j), height] };
        found.positions.push([away(7 * k, i), y, z]);
        found.radii.push(RADIUS * (1.0 - 0.15 * noise(7 * k + 4)));
        let speed = -2.0 * (1.0 - share) * noise(7 * k + 3) - 0.3 * noise(7 * k + 5);
        let [y, z] = if is_flat { [speed, 0.0] } else { [0.0, speed] };
        found.velocities.push([0.1 * noise(7 * k + 6), y, z]);
        found.spins.push([0.0, 0.0, 40.0 * noise(7 * k + 5)]);
        found.masses.push(1e-3 * noise(7 * k + 4));
        found.materials.push(u32::from(k % 5 == 0));
        found.groups.push(u32::from(l >= heights / 2));
    }
    found.group_names = vec!["sand".to_owned(), "gravel".to_owned()];
    found.discs = (rows == 1).then_some(0.01);
    touching(&mut found, layers);
    let forces = found.contacts.iter().fold(vec![[0.0; 3]; found.positions.len()], |mut forces, contact| {
        for (sum, part) in forces[contact.sphere as usize].iter_mut().zip(contact.force) {
            *sum += part;
        }
        forces
    });
    found.forces = forces;
    found
}

/// Adds the contacts of neighbours that overlap, and those of the lowest spheres with wall 0.
fn touching(found: &mut SphereColumns, [columns, rows, heights]: [usize; 3]) {
    let up = if rows > 1 { 2 } else { 1 };
    for k in 0..found.positions.len() {
        let [i, j, l] = [k % columns, k / columns % rows, k / columns / rows];
        let next = [(i + 1 < columns, 1), (j + 1 < rows, columns), (l + 1 < heights, columns * rows)];
        for (_, step) in next.into_iter().filter(|(is_there, _)| *is_there) {
            let (from, to) = (found.positions[k], found.positions[k + step]);
            let along = [0, 1, 2].map(|axis| to[axis] - from[axis]);
            let distance = along.iter().map(|x| x * x).sum::<f64>().sqrt();
            let overlap = found.radii[k] + found.radii[k + step] - distance;
            if overlap > 0.0 {
                let normal = 1e5 * overlap * (0.2 + noise(k + step) * noise(3 * k + step) * 4.0);
                found.contacts.push(GrainContact {
                    sphere: k as u32,
                    other: GrainPartner::Sphere((k + step) as u32),
                    place: [0, 1, 2].map(|axis| 0.5 * (from[axis] + to[axis])),
                    force: along.map(|x| -normal * x / distance),
                    normal,
                    overlap,
                });
            }
        }
    }
    for k in 0..columns * rows {
        let mut place = found.positions[k];
        let overlap = found.radii[k] - place[up];
        place[up] = 0.0;
        if overlap > 0.0 {
            let mut force = [0.0; 3];
            force[up] = 2e5 * overlap;
            let (sphere, other) = (k as u32, GrainPartner::Wall(0));
            found.contacts.push(GrainContact { sphere, other, place, force, normal: force[up], overlap });
        }
    }
}

fn wall(name: &str, shape: WallShape) -> Wall {
    Wall { name: name.to_owned(), shape, ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0) }
}

fn plane(name: &str, point: [f64; 3], normal: [f64; 3]) -> Wall {
    wall(name, WallShape::Plane { point, normal })
}

/// The last spheres as the tests expect them.
fn expected(spheres: &SphereColumns) -> String {
    json!({
        "numbers": spheres.numbers,
        "positions": spheres.positions,
        "radii": spheres.radii,
        "velocities": spheres.velocities,
        "groups": spheres.groups,
        "contacts": spheres.contacts.len(),
    })
    .to_string()
}

fn space(folder: &Path, side: usize, count: usize) -> Result<(), Box<dyn Error>> {
    let wide = APART * side as f64;
    let mesh = block([0.1 * wide, 0.1 * wide, -0.5 * wide], [0.9 * wide, 0.9 * wide, -0.2 * wide]);
    let shell = Shell::new(&mesh, &[]);
    let mut snapshots = Vec::new();
    for k in 0..count {
        let share = (k + 1) as f64 / count as f64;
        let mut spheres = spheres([side; 3], share);
        spheres.walls = vec![
            plane("floor", [0.0; 3], [0.0, 0.0, 1.0]),
            plane("left", [0.0; 3], [1.0, 0.0, 0.0]),
            plane("right", [wide; 3], [-1.0, 0.0, 0.0]),
            plane("front", [0.0; 3], [0.0, 1.0, 0.0]),
            plane("back", [wide; 3], [0.0, -1.0, 0.0]),
            wall(
                "hopper",
                WallShape::Cone {
                    axis: [[0.5 * wide, 0.5 * wide, 1.35 * wide], [0.5 * wide, 0.5 * wide, 1.6 * wide]],
                    radii: [0.2 * wide, 0.6 * wide],
                },
            ),
        ];
        spheres.wall_forces = vec![[0.0, 0.0, -5.0]; 6];
        let snapshot = Snapshot { step: 100 * k as u64, time: 0.1 * share, spheres, ..Snapshot::default() };
        snapshots.push(Snapshot {
            positions: mesh.nodes.clone(),
            displacements: vec![[0.0; 3]; mesh.nodes.len()],
            velocities: vec![[0.0, 0.0, 0.5]; mesh.nodes.len()],
            elements: mesh.elements.clone(),
            stresses: vec![[-1e5, 0.0, 0.0, 0.0, 0.0, 0.0]; mesh.elements.len()],
            damage: vec![0.0; mesh.elements.len()],
            bodies: mesh.bodies.clone(),
            materials: mesh.materials.clone(),
            fragments: vec![0; mesh.elements.len()],
            ..snapshot
        });
    }
    let start = Instant::now();
    let frames: Vec<SpaceFrame> =
        snapshots.iter().map(|snapshot| SpaceFrame::new(snapshot, &shell)).collect::<Result<_, _>>()?;
    eprintln!("{:8.3} s  {count} frames", start.elapsed().as_secs_f64());
    let names =
        Names { bodies: vec!["block".to_owned()], materials: vec!["quartz".to_owned(), "steel".to_owned()] };
    let title = "Spheres in a box";
    let last = frames.last().ok_or("at least one frame is needed")?;
    let mut preview = Vec::new();
    for field in [Field::VELOCITY, Field::GROUP, Field::FORCE_CHAINS, Field::VON_MISES] {
        let (range, view) = (Range::of_space(&frames, field), SpaceView::of(&frames));
        let pictures = SpacePictures { title, field, range, view, show: Show::Solid, cut: None };
        let start = Instant::now();
        let png = pictures.png(last, None)?;
        eprintln!("{:8.3} s  picture of {}", start.elapsed().as_secs_f64(), field.key());
        fs::write(folder.join(format!("{}.png", field.key())), &png)?;
        if field == Field::VELOCITY {
            preview = png;
        }
    }
    let report = SpaceReport {
        title,
        facts: &[("model", "examples/sphere_report.rs")],
        plots: &[],
        frames: &frames,
        fragments: &Fragments::default(),
        field: Field::VELOCITY,
        names: &names,
    };
    fs::write(folder.join("report.html"), report.html(Some(&preview))?)?;
    let last = snapshots.last().ok_or("at least one frame is needed")?;
    fs::write(folder.join("expected.json"), expected(&last.spheres))?;
    Ok(())
}

fn flat(folder: &Path, side: usize, count: usize) -> Result<(), Box<dyn Error>> {
    let wide = APART * side as f64;
    let mut snapshots = Vec::new();
    for k in 0..count {
        let share = (k + 1) as f64 / count as f64;
        let mut spheres = spheres([side, 1, side], share);
        let slope = [[wide, 0.0, 0.0], [1.3 * wide, 0.4 * wide, 0.0], [1.3 * wide, 0.4 * wide, 0.0]];
        spheres.walls = vec![
            plane("floor", [0.0; 3], [0.0, 1.0, 0.0]),
            plane("left", [0.0; 3], [1.0, 0.0, 0.0]),
            wall("slope", WallShape::Mesh { triangles: vec![slope] }),
        ];
        spheres.wall_forces = vec![[0.0, -5.0, 0.0]; 3];
        snapshots.push(Snapshot {
            step: 100 * k as u64,
            time: 0.1 * share,
            positions: vec![
                [0.0, -0.3 * wide],
                [wide, -0.3 * wide],
                [wide, -0.05 * wide],
                [0.0, -0.05 * wide],
            ],
            displacements: vec![[0.0; 2]; 4],
            velocities: vec![[0.0, 0.5]; 4],
            elements: vec![[0, 1, 2], [0, 2, 3]],
            stresses: vec![[1e5, 0.0, 0.0, 0.0, 0.0, 0.0]; 2],
            damage: vec![0.0; 2],
            bodies: vec![0; 2],
            materials: vec![0; 2],
            fragments: vec![0; 2],
            spheres,
            ..Snapshot::default()
        });
    }
    let mesh = Mesh {
        nodes: snapshots[0].positions.clone(),
        elements: snapshots[0].elements.clone(),
        bodies: vec![0; 2],
        materials: vec![0; 2],
    };
    let outlines = Outlines::new(&mesh, &[]);
    let frames: Vec<Frame> =
        snapshots.iter().map(|snapshot| Frame::outlined(snapshot, &outlines)).collect::<Result<_, _>>()?;
    let names =
        Names { bodies: vec!["block".to_owned()], materials: vec!["quartz".to_owned(), "steel".to_owned()] };
    let (title, view) = ("Discs on a floor", FrameView::of(&frames));
    let last = frames.last().ok_or("at least one frame is needed")?;
    for field in [Field::VELOCITY, Field::GROUP, Field::FORCE_CHAINS, Field::VON_MISES] {
        let pictures = Pictures { title, field, range: Range::of(&frames, field), view };
        fs::write(folder.join(format!("{}.png", field.key())), pictures.png(last, None)?)?;
        fs::write(folder.join(format!("{}.svg", field.key())), pictures.svg(last)?)?;
    }
    let report = Report {
        title,
        facts: &[("model", "examples/sphere_report.rs")],
        plots: &[],
        frames: &frames,
        fragments: &Fragments::default(),
        field: Field::VELOCITY,
        names: &names,
    };
    fs::write(folder.join("report.html"), report.html()?)?;
    let last = snapshots.last().ok_or("at least one frame is needed")?;
    fs::write(folder.join("expected.json"), expected(&last.spheres))?;
    Ok(())
}

/// A block of six tetrahedra.
fn block(low: [f64; 3], high: [f64; 3]) -> Mesh<3, 4> {
    let node = |bits: usize| [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];
    let element = |(k, order): (usize, [usize; 3])| {
        let mut element = [0_u32; 4];
        for (corner, axis) in (1..).zip(order) {
            element[corner] = element[corner - 1] | 1 << axis;
        }
        if k > 2 {
            element.swap(0, 1);
        }
        element
    };
    let elements: Vec<[u32; 4]> = orders.into_iter().enumerate().map(element).collect();
    Mesh { nodes: (0..8).map(node).collect(), bodies: vec![0; 6], materials: vec![1; 6], elements }
}
