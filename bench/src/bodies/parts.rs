//! Parts of the models: rock, and fragments that press each other.

use fdem_simulation::{
    Boundary, FractureOptions, Insertion, Load, Material, MaterialLaw, Mesh, Model, Schedule, Strength,
    Target,
};

/// Edge of a square that is split into two triangles, and of a cube that is split into six tetrahedra, m.
pub(super) const CELL: f64 = 1e-3;

/// Rate at which fragments and the box around them shrink, 1/s. Fragments would fly apart in a box of
/// constant size: their first impact throws them back.
pub(super) const RATE: f64 = 20.0;

/// A model of rock.
pub(super) fn of_rock<const D: usize, const N: usize>(
    mesh: Mesh<D, N>,
    velocities: Vec<[f64; D]>,
    breaks: bool,
    insertion: Insertion,
) -> Model<D, N> {
    let strength = Strength {
        tensile: 5e6,
        cohesion: 15e6,
        friction: 0.6,
        energy_i: 100.0,
        energy_ii: 500.0,
        weibull_modulus: None,
        seed: 0,
    };
    let rock = Material {
        name: "rock".to_owned(),
        density: 2700.0,
        youngs_modulus: 30e9,
        poissons_ratio: 0.25,
        law: MaterialLaw::NeoHookean,
        damping: 0.0,
        strength: breaks.then_some(strength),
        friction: 0.4,
    };
    Model {
        mesh,
        materials: vec![rock],
        velocities,
        fracture: FractureOptions { insertion, ..FractureOptions::default() },
        ..Model::default()
    }
}

/// Fragments in layers like bricks in a wall, so close that all touch their neighbours from the beginning.
/// They shrink together with a box around them: nothing at the outside moves across its walls.
///
/// `count`: fragments along each axis. `shift`: moves a fragment in this place, as a share of its width, so
/// that nodes do not meet nodes.
pub(super) fn pressed<const D: usize, const N: usize>(
    fragment: &Mesh<D, N>,
    count: usize,
    shift: impl Fn([usize; D]) -> [f64; D],
) -> (Mesh<D, N>, Vec<[f64; D]>, Vec<Boundary<D>>) {
    let width = fragment.nodes.iter().map(|node| node[0]).fold(0.0, f64::max);
    let spacing = width * (1.0 - 1e-6);
    let mut parts = Vec::new();
    let mut walls = vec![[Vec::new(), Vec::new()]; D];
    for number in 0..count.pow(D as u32) {
        let place: [usize; D] = std::array::from_fn(|axis| number / count.pow(axis as u32) % count);
        let shift = shift(place);
        let by = std::array::from_fn(|axis| (place[axis] as f64 + shift[axis]) * spacing);
        for (axis, [low, high]) in walls.iter_mut().enumerate() {
            for (at, node) in fragment.nodes.iter().zip((number * fragment.nodes.len()) as u32..) {
                if place[axis] == 0 && at[axis] == 0.0 {
                    low.push(node);
                } else if place[axis] == count - 1 && at[axis] == width {
                    high.push(node);
                }
            }
        }
        parts.push(moved(fragment, by));
    }
    let mesh = together(&parts);
    let middle = 0.5 * count as f64 * spacing;
    let velocities = mesh.nodes.iter().map(|node| node.map(|x| RATE * (middle - x))).collect();
    let wall = |axis: usize, nodes: Vec<u32>, speed: f64| {
        let mut velocity = [None; D];
        velocity[axis] = Some(speed);
        Boundary {
            name: format!("wall across axis {axis}"),
            target: Target::Nodes(nodes),
            load: Load::Velocity(velocity),
            schedule: Schedule::Constant,
        }
    };
    let pair = |(axis, [low, high]): (usize, [Vec<u32>; 2])| {
        [wall(axis, low, RATE * middle), wall(axis, high, -RATE * middle)]
    };
    (mesh, velocities, walls.into_iter().enumerate().flat_map(pair).collect())
}

/// Damps fragments that press each other. The first contact sets their surfaces swinging. Damping ends that
/// within some steps, and they press each other from then on.
pub(super) fn calm<const D: usize, const N: usize>(mut model: Model<D, N>) -> Model<D, N> {
    model.contact.damping = 1.0;
    for material in &mut model.materials {
        material.damping = 0.5;
    }
    model
}

pub(super) fn moved<const D: usize, const N: usize>(mesh: &Mesh<D, N>, by: [f64; D]) -> Mesh<D, N> {
    let place = |node: &[f64; D]| std::array::from_fn(|axis| node[axis] + by[axis]);
    Mesh { nodes: mesh.nodes.iter().map(place).collect(), ..mesh.clone() }
}

/// Joins several meshes into one.
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
