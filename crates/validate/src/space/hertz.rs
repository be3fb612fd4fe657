//! Hertz contact: an elastic sphere pressed on an elastic block, without friction.
//!
//! With `1/E* = 2 (1 - ν²)/E` for two equal materials, the radius `R` and the approach `δ` of far points, the
//! load is `P = 4/3 E* √R δ^1.5`, the radius of the contact `a = √(R δ)` and the greatest pressure
//! `p₀ = 3 P/(2 π a²)` (Johnson, 4.2).
//!
//! The theory is that of two half spaces, so the model is the quarter of a region of five contact radii of
//! each. The outer faces are moved as the half space moves there, far from the contact: as under a point load
//! (Johnson, 3.4), at the depth `z` and the distances `r` from the axis and `s` from the contact
//!
//! ```text
//! u_r = P (1 + ν)/(2 π E) (r z/s³ - (1 - 2 ν) r/(s (s + z))),    u_z = P (1 + ν)/(2 π E) (z²/s³ + 2 (1 - ν)/s).
//! ```
//!
//! The pressure of Hertz differs from a point load by its second moment, `2 a²/5`: a share of the order
//! of 1.6 % of these displacements, which are a tenth of the approach at most. That is 0.2 % of the approach.
//! The sphere is a paraboloid: `a` is 0.005 of `R`.
//!
//! Two errors are known. Linear triangles below the paraboloid are on average `h²/(6 R)` above it, where `h`
//! is the length of a cell: with `n` cells over the radius of the contact the approach is too small by its
//! share `1/(6 n²)`, the load by `1/(4 n²)`, 1 % with five cells. Elements of constant strain are too stiff,
//! by a share of the order `1/n²` too. The bound of 3 % holds for both from five cells.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use fdem_simulation::{
    Boundary, ContactOptions, CriticalStep, Load, Material, Model, Schedule, Target, TimeOptions,
};

use super::bodies::{
    Body, Point, advance, cross, cuboid, force, jittered, length, mapped, minus, on_box, one_body, start,
    volume,
};
use crate::models::{granite, moved, nodes_where, together};
use crate::{Outcome, Size};

/// Radius of the sphere and of the contact, m.
const RADIUS: f64 = 0.2;
const CONTACT: f64 = 0.001;

/// Half of the width, and the depth, of the region of each body, m.
const REGION: f64 = 5.0 * CONTACT;

const POISSON: f64 = 0.25;

/// Penalty of the contact. The two bodies overlap by 0.5 % of the approach or less.
const PENALTY: f64 = 2.0;

/// E*, Pa.
fn modulus() -> f64 {
    granite().youngs_modulus / (2.0 * (1.0 - POISSON * POISSON))
}

/// Bound of the errors of the radius and of the pressure, times the square of the number of cells over the
/// radius. With five and with eight cells their errors are between 1.0 and 1.5 over that square: a contact of
/// so few elements is blurred by a share of an element.
const BLUR: f64 = 2.0;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let approach = CONTACT * CONTACT / RADIUS;
    let load = load(approach);
    let greatest = 1.5 * load / (PI * CONTACT * CONTACT);
    let sizes: &[usize] = size.choose(&[5], &[5, 8]);
    for &cells in sizes {
        let pressed = press(approach, cells)?;
        let blur = BLUR / (cells * cells) as f64;
        let name = |what: &str| format!("{what}, {cells} cells over the radius");
        outcomes.extend([
            Outcome::relative(name("load"), load, pressed.load, 0.03, "N"),
            Outcome::relative(
                name("load on the block over that on the sphere"),
                1.0,
                pressed.ratio,
                0.02,
                "",
            ),
            Outcome::relative(name("radius of the contact"), CONTACT, pressed.radius, blur, "m"),
            Outcome::relative(name("greatest pressure"), greatest, pressed.greatest, blur, "Pa"),
        ]);
    }
    Ok(outcomes)
}

/// Load at an approach, N.
fn load(approach: f64) -> f64 {
    4.0 / 3.0 * modulus() * RADIUS.sqrt() * approach.powf(1.5)
}

struct Pressed {
    /// N, on the whole sphere.
    load: f64,
    /// Load on the block over that on the sphere.
    ratio: f64,
    /// m.
    radius: f64,
    /// Pa.
    greatest: f64,
}

/// A quarter of the region of a half space below z = 0: even cells in a cube around the contact, and beyond
/// three blocks, one on each face of the cube, whose cells grow with the distance.
fn region(cells: usize, seed: u64) -> Body {
    let cell = CONTACT / cells as f64;
    let within = inner(cells);
    let cube = within as f64 * cell;
    let middle = cuboid([0.0; 3], [cube; 3], [within; 3]);
    // Along the first axis outwards.
    let block = mapped(&cuboid([0.0; 3], [1.0; 3], [rings(cells), within, within]), |[i, j, k]| {
        let far = cube * (REGION / cube).powf(i);
        [far, far * j, far * k]
    });
    let mut parts = vec![middle];
    parts.extend((0..3).map(|turn| mapped(&block, |[x, y, z]| [[x, y, z], [z, x, y], [y, z, x]][turn])));
    let mut nodes: Vec<Point> = Vec::new();
    let mut known = BTreeMap::new();
    let mut elements = Vec::new();
    for part in &parts {
        let numbers: Vec<u32> = part
            .nodes
            .iter()
            .map(|&[x, y, z]| {
                *known.entry([x, y, z].map(|x| (1e4 * x / cell).round() as i64)).or_insert_with(|| {
                    nodes.push([x, y, -z]);
                    nodes.len() as u32 - 1
                })
            })
            .collect();
        elements.extend(part.elements.iter().map(|corners| corners.map(|node| numbers[node as usize])));
    }
    let mesh = one_body(nodes, elements);
    jittered(&mesh, 0.12 * cell, seed, on_box([0.0, 0.0, -REGION], [REGION, REGION, 0.0]))
}

/// Cells along an edge of the cube around the contact: even, so that the faces of its elements are those of
/// the blocks.
fn inner(cells: usize) -> usize {
    2 * (0.6 * cells as f64).ceil() as usize
}

/// Cells from the cube to the end of the region: about as long as wide.
fn rings(cells: usize) -> usize {
    let within = inner(cells) as f64;
    (within * (REGION * cells as f64 / (within * CONTACT)).ln()).ceil() as usize
}

/// Displacement of a half space below z = 0 under a load on it, at the origin.
fn displacement(load: f64, [x, y, z]: Point) -> Point {
    let (r, depth) = (x.hypot(y), -z);
    let s = r.hypot(depth);
    let scale = load * (1.0 + POISSON) / (2.0 * PI * granite().youngs_modulus);
    let out = scale * (depth / s.powi(3) - (1.0 - 2.0 * POISSON) / (s * (s + depth)));
    [out * x, out * y, -scale * (depth * depth / s.powi(3) + 2.0 * (1.0 - POISSON) / s)]
}

fn press(approach: f64, cells: usize) -> Result<Pressed, String> {
    let halves = [region(cells, 1), region(cells, 2)];
    let gap = 1e-3 * approach;
    let load = load(approach);
    // Where the outer nodes go.
    let mut goals: Vec<(u32, [Option<f64>; 3])> = Vec::new();
    let mut first = 0;
    for (half, mesh) in halves.iter().enumerate() {
        for (node, &place) in (first..).zip(&mesh.nodes) {
            let [x, y, z] = place;
            if x.max(y).max(-z) > REGION * (1.0 - 1e-9) {
                let [u, v, w] = displacement(load, place);
                // The sphere is the mirror image of a half space and moves down.
                let w = if half == 0 { w } else { -w - approach - gap };
                goals.push((node, [(x > 1e-9).then_some(u), (y > 1e-9).then_some(v), Some(w)]));
            }
        }
        first += mesh.nodes.len() as u32;
    }
    let [block, other] = halves;
    let sphere = mapped(&other, |[x, y, z]| [x, y, gap - z + (x * x + y * y) / (2.0 * RADIUS)]);
    let sphere = one_body(sphere.nodes, sphere.elements);
    let count = block.nodes.len() as u32;
    let surface = pressed_faces(&block);
    let mut mesh = together(&[block, sphere]);
    // Only the state of rest counts: large elements are made so light that their time step is that of the
    // small ones.
    let sizes: Vec<f64> =
        mesh.elements.iter().map(|nodes| height(nodes.map(|node| mesh.nodes[node as usize]))).collect();
    let least = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    for (material, size) in mesh.materials.iter_mut().zip(sizes) {
        *material = (2.0 * (size / least).log2()) as u32;
    }
    let classes = mesh.materials.iter().copied().max().unwrap_or(0);
    let materials = (0..=classes).map(|class| Material {
        name: format!("size {class}"),
        density: 1000.0 * 0.5_f64.powi(class.cast_signed()),
        poissons_ratio: POISSON,
        damping: 0.2,
        ..granite()
    });
    let on = |axis: usize| nodes_where(&mesh, |p: Point| p[axis].abs() < 1e-12);
    let still = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(0.0));
    let mut boundaries = vec![
        moved("x", on(0), still(0), Schedule::Constant),
        moved("y", on(1), still(1), Schedule::Constant),
    ];
    boundaries.extend(goals.iter().map(|&(node, goal)| Boundary {
        name: format!("node {node}"),
        target: Target::Nodes(vec![node]),
        load: Load::Displacement(goal),
        schedule: Schedule::Constant,
    }));
    let mut model = Model {
        mesh,
        materials: materials.collect(),
        boundaries,
        contact: ContactOptions { penalty: PENALTY, ..ContactOptions::default() },
        time: TimeOptions { local_damping: 0.6, ..TimeOptions::default() },
        ..Model::default()
    };
    let step = model.time.safety * CriticalStep::of(&model).map_err(|error| error.to_string())?.step;
    model.time.step = Some(step);
    // A wave passes a cell in some ten steps, because the contact is stiff.
    let steps = 180 * (inner(cells) + rings(cells)) as u64;
    let time = 0.6 * steps as f64 * step;
    // The approach becomes slower and slower: a sudden stop would ring.
    let slowing: Vec<[f64; 2]> = (0..=50)
        .map(|k| {
            let share = f64::from(k) / 50.0;
            [time * share, 1.0 - (1.0 - share).powi(3)]
        })
        .collect();
    for boundary in &mut model.boundaries[2..] {
        boundary.schedule = Schedule::Table(slowing.clone());
    }
    // The sphere moves as a whole from the beginning.
    let falling = [0.0, 0.0, -3.0 * (approach + gap) / time];
    let moving = |node: u32| if node < count { [0.0; 3] } else { falling };
    model.velocities = (0..model.mesh.nodes.len() as u32).map(moving).collect();
    let mut run = start(model)?;
    // Means over the swing that is left.
    advance(&mut run, steps - steps / 4)?;
    let (mut loads, samples) = ([0.0; 2], 25);
    for _ in 0..samples {
        advance(&mut run, steps / 4 / samples)?;
        for (boundary, (node, _)) in (2..).zip(&goals) {
            loads[usize::from(*node >= count)] += force(&run, boundary)?[2] / samples as f64;
        }
    }
    let [radius, greatest] = profile(&run.snapshot().stresses, &surface);
    // The model is a quarter.
    Ok(Pressed { load: 4.0 * -loads[1], ratio: -loads[0] / loads[1], radius, greatest })
}

/// Radius of the contact, m, and greatest pressure, Pa, from the stresses of the block's elements at the
/// contact. The mean of r² over the pressure of Hertz is 2 a²/5, and p² = p₀² - (p₀/a)² r², where p₀ follows
/// by least squares. The edge of the contact is left out of these, because the pressure changes much within
/// an element there.
fn profile(stresses: &[[f64; 6]], surface: &[(usize, f64, f64)]) -> [f64; 2] {
    let (mut sum, mut moment) = (0.0, 0.0);
    let [mut w, mut wx, mut wy, mut wxx, mut wxy] = [0.0; 5];
    for &(element, area, square) in surface {
        let pressure = -stresses[element][2].min(0.0);
        sum += pressure * area;
        moment += pressure * area * square;
        if square < (0.8 * CONTACT).powi(2) {
            let (x, y) = (square, pressure * pressure);
            w += area;
            wx += area * x;
            wy += area * y;
            wxx += area * x * x;
            wxy += area * x * y;
        }
    }
    let slope = (w * wxy - wx * wy) / (w * wxx - wx * wx);
    [(2.5 * moment / sum).sqrt(), ((wy - slope * wx) / w).sqrt()]
}

/// Least height of a tetrahedron.
fn height(corners: [Point; 4]) -> f64 {
    let [a, b, c, d] = corners;
    let faces = [[a, b, c], [a, b, d], [a, c, d], [b, c, d]];
    let area = |[a, b, c]: [Point; 3]| 0.5 * length(cross(minus(b, a), minus(c, a)));
    3.0 * volume(corners).abs() / faces.map(area).into_iter().fold(0.0, f64::max)
}

/// Elements with a face on z = 0, near the contact, with the area of that face and the square of its distance
/// from the axis.
fn pressed_faces(block: &Body) -> Vec<(usize, f64, f64)> {
    let mut found = Vec::new();
    for (element, nodes) in block.elements.iter().enumerate() {
        let top: Vec<Point> =
            nodes.iter().map(|&node| block.nodes[node as usize]).filter(|p| p[2] > -1e-12).collect();
        if let [a, b, c] = top[..] {
            let area = 0.5 * length(cross(minus(b, a), minus(c, a)));
            let middle = [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
            let square = middle[0] * middle[0] + middle[1] * middle[1];
            if square < (1.3 * CONTACT).powi(2) {
                found.push((element, area, square));
            }
        }
    }
    found
}
