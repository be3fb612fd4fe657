//! Meshes and materials that several tests use.

use fdem_simulation::{Boundary, Load, Material, MaterialLaw, Mesh, Schedule, Simulation, Strength, Target};

/// Granite, which does not break.
pub(crate) fn granite() -> Material {
    Material {
        name: "granite".to_owned(),
        density: 2700.0,
        youngs_modulus: 50e9,
        poissons_ratio: 0.0,
        law: MaterialLaw::NeoHookean,
        damping: 0.0,
        strength: None,
        friction: 0.0,
    }
}

/// The rock of the Brazilian disc.
pub(crate) fn rock() -> Strength {
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

/// A rectangle of `nx` by `ny` cells, each split into two elements along alternating diagonals.
pub(crate) fn rectangle(min: [f64; 2], max: [f64; 2], nx: usize, ny: usize) -> Mesh {
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
    let count = elements.len();
    Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] }
}

/// One mesh of several, each as a separate body.
pub(crate) fn together<const D: usize, const N: usize>(parts: &[Mesh<D, N>]) -> Mesh<D, N> {
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

/// The mesh turned about the origin and then moved by `shift`.
pub(crate) fn turned(mesh: &Mesh, angle: f64, shift: [f64; 2]) -> Mesh {
    let (sin, cos) = angle.sin_cos();
    let turn = |[x, y]: [f64; 2]| [cos * x - sin * y + shift[0], sin * x + cos * y + shift[1]];
    Mesh { nodes: mesh.nodes.iter().map(|&node| turn(node)).collect(), ..mesh.clone() }
}

/// Numbers of the nodes at whose positions `at` is true.
pub(crate) fn nodes_where(mesh: &Mesh, at: impl Fn([f64; 2]) -> bool) -> Vec<u32> {
    (0..mesh.nodes.len() as u32).filter(|&node| at(mesh.nodes[node as usize])).collect()
}

/// A boundary that moves nodes with a velocity, m/s, along the axes that have one.
pub(crate) fn held<const D: usize>(
    name: &str,
    nodes: Vec<u32>,
    velocity: [Option<f64>; D],
    schedule: Schedule,
) -> Boundary<D> {
    Boundary { name: name.to_owned(), target: Target::Nodes(nodes), load: Load::Velocity(velocity), schedule }
}

/// A boundary that holds the nodes at y = 0.
pub(crate) fn floor(mesh: &Mesh) -> Boundary {
    held("floor", nodes_where(mesh, |[_, y]| y == 0.0), [Some(0.0); 2], Schedule::Constant)
}

/// Linear momentum and angular momentum about the origin.
pub(crate) fn momentum(run: &Simulation) -> [f64; 3] {
    let snapshot = run.snapshot();
    let mesh = &run.model().mesh;
    let mut sum = [0.0; 3];
    for (element, nodes) in snapshot.elements.iter().enumerate() {
        let [a, b, c] = mesh.elements[element].map(|node| mesh.nodes[node as usize]);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        let density = run.model().materials[mesh.materials[element] as usize].density;
        let mass = density * area * run.model().thickness / 3.0;
        for &node in nodes {
            let ([x, y], [u, v]) = (snapshot.positions[node as usize], snapshot.velocities[node as usize]);
            sum[0] += mass * u;
            sum[1] += mass * v;
            sum[2] += mass * (x * v - y * u);
        }
    }
    sum
}
