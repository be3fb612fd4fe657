//! Meshes, materials and steps that several cases use.

use std::fmt::Display;

use fdem_simulation::{
    Boundary, Interface, Load, Material, MaterialLaw, Mesh, Model, Schedule, Simulation, Strength, Target,
};

/// Density of all materials here, kg/m³.
pub(super) const DENSITY: f64 = 2700.0;

/// Granite with ν = 0, without strength limit and friction.
pub(super) fn granite() -> Material {
    Material {
        name: "granite".to_owned(),
        density: DENSITY,
        youngs_modulus: 50e9,
        poissons_ratio: 0.0,
        law: MaterialLaw::NeoHookean,
        damping: 0.0,
        strength: None,
        friction: 0.0,
    }
}

/// Strength of a rock that breaks at a tension of 10⁶ Pa.
pub(super) fn rock() -> Strength {
    Strength {
        tensile: 1e6,
        cohesion: 3e6,
        friction: 0.3,
        energy_i: 10.0,
        energy_ii: 50.0,
        weibull_modulus: None,
        seed: 0,
    }
}

/// A rectangle of `nx` by `ny` cells, each of two elements whose common edge alternates.
pub(super) fn rectangle(min: [f64; 2], max: [f64; 2], [nx, ny]: [usize; 2]) -> Mesh {
    let node = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    let along = |axis: usize, k: usize, n: usize| min[axis] + (max[axis] - min[axis]) * k as f64 / n as f64;
    let nodes = (0..=ny).flat_map(|j| (0..=nx).map(move |i| [along(0, i, nx), along(1, j, ny)])).collect();
    let mut elements = Vec::new();
    for j in 0..ny {
        for i in 0..nx {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            if (i + j) % 2 == 0 {
                elements.extend([[a, b, c], [a, c, d]]);
            } else {
                elements.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    one_body(nodes, elements)
}

/// A disc about the origin, of rings of elements around a point: 6 times their number squared in all.
pub(super) fn disc(radius: f64, rings: usize) -> Mesh {
    let mut nodes = vec![[0.0; 2]];
    let mut elements = Vec::new();
    let first = |ring: usize| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) };
    for ring in 1..=rings {
        for k in 0..6 * ring {
            let angle = std::f64::consts::TAU * k as f64 / (6 * ring) as f64;
            let r = radius * ring as f64 / rings as f64;
            nodes.push([r * angle.cos(), r * angle.sin()]);
        }
        let outer = |k: usize| (first(ring) + k % (6 * ring)) as u32;
        let inner = |k: usize| (first(ring - 1) + k % (6 * (ring - 1)).max(1)) as u32;
        for sector in 0..6 {
            for k in 0..ring {
                let (o, i) = (sector * ring + k, sector * (ring - 1) + k);
                elements.push([outer(o), outer(o + 1), inner(i)]);
                if k + 1 < ring {
                    elements.push([inner(i), outer(o + 1), inner(i + 1)]);
                }
            }
        }
    }
    one_body(nodes, elements)
}

/// A mesh of one body and one material.
pub(super) fn one_body(nodes: Vec<[f64; 2]>, elements: Vec<[u32; 3]>) -> Mesh {
    let count = elements.len();
    Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] }
}

/// Several meshes as bodies of one.
pub(super) fn together<const D: usize, const N: usize>(parts: &[Mesh<D, N>]) -> Mesh<D, N> {
    let mut all = Mesh::default();
    for (body, part) in parts.iter().enumerate() {
        let first = all.nodes.len() as u32;
        all.nodes.extend(&part.nodes);
        all.elements.extend(part.elements.iter().map(|nodes| nodes.map(|node| node + first)));
        all.bodies.extend(part.elements.iter().map(|_| body as u32));
        all.materials.extend(&part.materials);
    }
    all
}

/// The mesh turned about the origin, then moved.
pub(super) fn turned(mesh: &Mesh, angle: f64, shift: [f64; 2]) -> Mesh {
    let turn = |node: [f64; 2]| {
        let [x, y] = rotated(node, angle);
        [x + shift[0], y + shift[1]]
    };
    Mesh { nodes: mesh.nodes.iter().map(|&node| turn(node)).collect(), ..mesh.clone() }
}

/// The slope of the straight line nearest to points, and its value at 0.
pub(super) fn line(x: &[f64], y: &[f64]) -> [f64; 2] {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (across, up) = (mean(x), mean(y));
    let both: f64 = x.iter().zip(y).map(|(x, y)| (x - across) * (y - up)).sum();
    let slope = both / x.iter().map(|x| (x - across) * (x - across)).sum::<f64>();
    [slope, up - slope * across]
}

/// A vector turned by an angle.
pub(super) fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Numbers of the nodes where `at` holds.
pub(super) fn nodes_where<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    at: impl Fn([f64; D]) -> bool,
) -> Vec<u32> {
    (0..mesh.nodes.len() as u32).filter(|&node| at(mesh.nodes[node as usize])).collect()
}

/// Edges of elements, both of whose nodes are where `at` holds.
pub(super) fn edges_where(mesh: &Mesh, at: impl Fn([f64; 2]) -> bool) -> Vec<[u32; 2]> {
    let edges = mesh.elements.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.filter(|edge| edge.iter().all(|&node| at(mesh.nodes[node as usize]))).collect()
}

/// Separates a mesh along y = 0 from the left to `tip`, m. Elements above that line become material 1.
pub(super) fn slit(mesh: &Mesh, tip: f64) -> Mesh {
    let mut mesh = mesh.clone();
    for node in nodes_where(&mesh, |[x, y]| y.abs() < 1e-9 && x < tip - 1e-9) {
        let copy = mesh.nodes.len() as u32;
        mesh.nodes.push(mesh.nodes[node as usize]);
        for element in 0..mesh.elements.len() {
            if centroid(&mesh, element)[1] > 0.0 {
                let corners = &mut mesh.elements[element];
                *corners = corners.map(|corner| if corner == node { copy } else { corner });
            }
        }
    }
    for element in 0..mesh.elements.len() {
        mesh.materials[element] = u32::from(centroid(&mesh, element)[1] > 0.0);
    }
    mesh
}

/// The model with another mesh, a [`slit`] one, that can break along the line of the slit only, with the
/// strength of its first material.
pub(super) fn along_slit(model: Model, mesh: Mesh) -> Model {
    let rock = &model.materials[0];
    let half = Material { strength: None, ..rock.clone() };
    let joints =
        Interface { materials: [0, 1], friction: rock.friction, penalty: None, strength: rock.strength };
    Model { mesh, materials: vec![half.clone(), half], interfaces: vec![joints], ..model }
}

/// Centroid of an undeformed element.
pub(super) fn centroid(mesh: &Mesh, element: usize) -> [f64; 2] {
    let corners = mesh.elements[element].map(|node| mesh.nodes[node as usize]);
    std::array::from_fn(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0)
}

/// Nodes that move with a velocity times a schedule.
pub(super) fn moved<const D: usize>(
    name: &str,
    nodes: Vec<u32>,
    velocity: [Option<f64>; D],
    schedule: Schedule,
) -> Boundary<D> {
    Boundary { name: name.to_owned(), target: Target::Nodes(nodes), load: Load::Velocity(velocity), schedule }
}

/// A run on one thread, at its beginning.
pub(super) fn start(model: Model) -> Result<Simulation, String> {
    Simulation::new(model, 1).map_err(text)
}

/// Advances a run by `steps` steps.
pub(super) fn advance(run: &mut Simulation, steps: u64) -> Result<(), String> {
    run.advance(steps).map_err(text)
}

/// Advances a run to a time, s.
pub(super) fn advance_to(run: &mut Simulation, time: f64) -> Result<(), String> {
    let steps = ((time - run.time()) / run.time_step()).ceil().max(0.0) as u64;
    advance(run, steps)
}

/// Force of a boundary on the bodies, N.
pub(super) fn force(run: &Simulation, boundary: usize) -> Result<[f64; 2], String> {
    run.force(boundary).ok_or_else(|| format!("there is no boundary {boundary}"))
}

/// Mean load along an axis between the first two boundaries over the next 20 steps, N: half of the force of
/// the second less that of the first. Single steps are disturbed by stress waves.
pub(super) fn mean_load(run: &mut Simulation, axis: usize) -> Result<f64, String> {
    let (mut sum, steps) = (0.0, 20);
    for _ in 0..steps {
        advance(run, 1)?;
        sum += 0.5 * (force(run, 1)?[axis] - force(run, 0)?[axis]);
    }
    Ok(sum / f64::from(steps))
}

/// Mean velocity of nodes of the mesh, m/s.
pub(super) fn mean_velocity(run: &Simulation, nodes: &[u32]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for (_, [u, v]) in nodes.iter().filter_map(|&node| run.node(node)) {
        sum = [sum[0] + u, sum[1] + v];
    }
    sum.map(|x| x / nodes.len() as f64)
}

/// Linear momentum and angular momentum about the origin.
pub(super) fn momentum(run: &Simulation) -> [f64; 3] {
    let snapshot = run.snapshot();
    let model = run.model();
    let mesh = &model.mesh;
    let mut sum = [0.0; 3];
    for (element, nodes) in snapshot.elements.iter().enumerate() {
        let [a, b, c] = mesh.elements[element].map(|node| mesh.nodes[node as usize]);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        let density = model.materials[mesh.materials[element] as usize].density;
        let mass = density * area * model.thickness / 3.0;
        for &node in nodes {
            let ([x, y], [u, v]) = (snapshot.positions[node as usize], snapshot.velocities[node as usize]);
            sum[0] += mass * u;
            sum[1] += mass * v;
            sum[2] += mass * (x * v - y * u);
        }
    }
    sum
}

/// A number of meshes in words.
pub(super) fn meshes(count: usize) -> String {
    if count == 1 { "1 mesh".to_owned() } else { format!("{count} meshes") }
}

/// The number that is farther from zero. NaN counts as farthest.
pub(super) fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a.abs() >= b.abs() { a } else { b }
}

pub(super) fn text(error: impl Display) -> String {
    error.to_string()
}
