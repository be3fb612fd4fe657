//! Steps of elastic bodies on a device are those of the simulation, to the bit.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]
#![allow(clippy::needless_range_loop, reason = "an axis is a place in several rows")]

use fdem_gpu::{DeviceSolid, Host, HostBuild, SolidColumns, SolidStep};
use fdem_scenes::random::Random;
use fdem_simulation::{Element, Material, MaterialLaw, Mesh, Model, Simulation, TimeOptions};

/// A grid of cells whose inner nodes are off their places, each of the simplices along the ways through it,
/// and two materials by turns.
fn grid<const D: usize, const N: usize>(cells: usize) -> Mesh<D, N> {
    let side = cells + 1;
    let mut random = Random::new(3);
    let nodes: Vec<[f64; D]> = (0..side.pow(D as u32))
        .map(|k| {
            std::array::from_fn(|axis| {
                let at = k / side.pow(axis as u32) % side;
                let off = if at > 0 && at < cells { 0.15 * random.between(-1.0, 1.0) } else { 0.0 };
                (at as f64 + off) / cells as f64
            })
        })
        .collect();
    let ways: &[(&[usize], bool)] = match D {
        2 => &[(&[0, 1], false), (&[1, 0], true)],
        _ => &[
            (&[0, 1, 2], false),
            (&[1, 2, 0], false),
            (&[2, 0, 1], false),
            (&[0, 2, 1], true),
            (&[1, 0, 2], true),
            (&[2, 1, 0], true),
        ],
    };
    let mut elements = Vec::new();
    for cell in 0..cells.pow(D as u32) {
        let corner: usize =
            (0..D).map(|axis| cell / cells.pow(axis as u32) % cells * side.pow(axis as u32)).sum();
        for (way, is_odd) in ways {
            let mut element = [corner as u32; N];
            let mut at = corner;
            for (place, &axis) in way.iter().enumerate() {
                at += side.pow(axis as u32);
                element[place + 1] = at as u32;
            }
            if *is_odd {
                element.swap(0, 1);
            }
            elements.push(element);
        }
    }
    let count = elements.len();
    let materials = (0..count as u32).map(|k| k % 2).collect();
    Mesh { nodes, elements, bodies: vec![0; count], materials }
}

fn model<const D: usize, const N: usize>(damping: f64, gravity: [f64; D]) -> Model<D, N> {
    let mesh = grid::<D, N>(if D == 2 { 20 } else { 8 });
    let mut random = Random::new(11);
    let velocities =
        mesh.nodes.iter().map(|_| std::array::from_fn(|_| 3.0 * random.between(-1.0, 1.0))).collect();
    let material = |youngs_modulus: f64, poissons_ratio: f64| Material {
        name: format!("{youngs_modulus}"),
        density: 2000.0,
        youngs_modulus,
        poissons_ratio,
        law: MaterialLaw::NeoHookean,
        damping,
        strength: None,
        friction: 0.5,
    };
    Model {
        mesh,
        materials: vec![material(2e6, 0.2), material(5e6, 0.3)],
        velocities,
        gravity,
        time: TimeOptions { local_damping: if damping > 0.0 { 0.1 } else { 0.0 }, ..TimeOptions::default() },
        ..Model::default()
    }
}

fn minus<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn dot<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (1..D).fold(a[0] * b[0], |sum, axis| sum + a[axis] * b[axis])
}

fn cross([a, b, c]: [f64; 3], [d, e, f]: [f64; 3]) -> [f64; 3] {
    [b * f - c * e, c * d - a * f, a * e - b * d]
}

/// Numbers of an element in the simulation: the inverse of its edges, its volume, its least height.
trait Shape<const D: usize> {
    fn of(&self) -> ([[f64; D]; D], f64, f64);
}

impl Shape<2> for [[f64; 2]; 3] {
    fn of(&self) -> ([[f64; 2]; 2], f64, f64) {
        let [p, q] = [minus(self[1], self[0]), minus(self[2], self[0])];
        let double = p[0] * q[1] - p[1] * q[0];
        // Columns are the edges.
        let determinant = p[0] * q[1] - q[0] * p[1];
        let inverse = [[q[1] / determinant, -q[0] / determinant], [-p[1] / determinant, p[0] / determinant]];
        let height = |facet: usize| {
            let [a, b, c] = [facet, (facet + 1) % 3, (facet + 2) % 3].map(|k| self[k]);
            let (edge, other) = (minus(b, a), minus(c, a));
            (edge[0] * other[1] - edge[1] * other[0]) / dot(edge, edge).sqrt()
        };
        (inverse, 0.5 * double, (0..3).map(height).fold(f64::INFINITY, f64::min))
    }
}

impl Shape<3> for [[f64; 3]; 4] {
    fn of(&self) -> ([[f64; 3]; 3], f64, f64) {
        let [a, b, c, d] = *self;
        let [p, q, r] = [minus(b, a), minus(c, a), minus(d, a)];
        let edges: [[f64; 3]; 3] = std::array::from_fn(|axis| [p[axis], q[axis], r[axis]]);
        let cofactor = [cross(edges[1], edges[2]), cross(edges[2], edges[0]), cross(edges[0], edges[1])];
        let determinant = dot(edges[0], cofactor[0]);
        let inverse = std::array::from_fn(|i| std::array::from_fn(|k| cofactor[k][i] / determinant));
        let volume = dot(p, cross(q, r)) / 6.0;
        let height = |face: [usize; 3]| {
            let [p, q, r] = face.map(|corner| self[corner]);
            let normal = cross(minus(q, p), minus(r, p));
            6.0 * volume / dot(normal, normal).sqrt()
        };
        // Rounded as in `simplex/tetrahedron.rs`, whose order of the corners this is.
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        (inverse, volume, faces.map(height).into_iter().fold(f64::INFINITY, f64::min))
    }
}

/// The columns of a model as the simulation makes them.
fn columns<const D: usize, const N: usize>(model: &Model<D, N>) -> SolidColumns<D, N>
where
    [[f64; D]; N]: Shape<D>,
{
    let Model { mesh, materials, .. } = model;
    let mut columns = SolidColumns {
        positions: mesh.nodes.clone(),
        velocities: model.velocities.clone(),
        masses: vec![0.0; mesh.nodes.len()],
        elements: mesh.elements.clone(),
        materials: mesh.materials.clone(),
        ..SolidColumns::default()
    };
    for (corners, &material) in mesh.elements.iter().zip(&mesh.materials) {
        let of = &materials[material as usize];
        let (gradients, measure, height) = corners.map(|node| mesh.nodes[node as usize]).of();
        let volume = measure * model.thickness;
        columns.gradients.push(gradients);
        columns.volumes.push(volume);
        if of.damping > 0.0 {
            let viscosity = 0.5 * of.damping * (of.youngs_modulus * of.density).sqrt();
            columns.viscosities.push(viscosity * height);
        }
        for node in corners {
            columns.masses[*node as usize] += of.density * volume / N as f64;
        }
    }
    columns.moduli = materials.iter().map(|of| moduli::<D>(of.youngs_modulus, of.poissons_ratio)).collect();
    columns
}

/// Moduli of shear and bulk: of plane stress, or of space.
fn moduli<const D: usize>(e: f64, nu: f64) -> [f64; 2] {
    let bulk = if D == 2 { e / (2.0 * (1.0 - nu)) } else { e / (3.0 * (1.0 - 2.0 * nu)) };
    [e / (2.0 * (1.0 + nu)), bulk]
}

fn bits<const D: usize>(values: &[[f64; D]]) -> Vec<u64> {
    values.iter().flatten().map(|x| x.to_bits()).collect()
}

/// Runs a model on both and compares positions and velocities.
fn same<const D: usize, const N: usize>(damping: f64, gravity: [f64; D])
where
    [[f64; D]; N]: Shape<D> + Element<D, N>,
{
    let model = model::<D, N>(damping, gravity);
    let columns = columns(&model);
    let mut simulation = Simulation::new(model, 1).unwrap();
    let of = SolidStep {
        step: simulation.time_step(),
        gravity,
        local_damping: if damping > 0.0 { 0.1 } else { 0.0 },
    };
    let hosts = [HostBuild::Ascending, HostBuild::Descending, HostBuild::Contracted].map(Host);
    let mut solids = hosts.each_ref().map(|host| DeviceSolid::new(host, &columns).unwrap());
    for steps in [1, 2, 200] {
        simulation.advance(steps).unwrap();
        let snapshot = simulation.snapshot();
        for (solid, host) in solids.iter_mut().zip(&hosts) {
            assert_eq!(solid.advance(steps, of), Ok(true));
            let [positions, velocities] = solid.motion().unwrap();
            let same = bits(&positions) == bits(&snapshot.positions)
                && bits(&velocities) == bits(&snapshot.velocities);
            // A sum that is not rounded may be the same in the first steps.
            let is_fused = host.0 == HostBuild::Contracted;
            assert!(if is_fused { !same || steps <= 2 } else { same }, "{host:?}, {steps} steps");
        }
    }
    let moved = simulation.snapshot().displacements;
    // Without viscosity by a tenth of a cell: strains for which a cube root is needed.
    let least = if damping > 0.0 { 1e-3 } else { 0.01 };
    assert!(moved.iter().flatten().any(|x| x.abs() > least), "it hardly moves");
}

#[test]
fn elastic_triangles_move_as_in_the_simulation() {
    same::<2, 3>(0.0, [0.0, -9.81]);
}

#[test]
fn elastic_tetrahedra_move_as_in_the_simulation() {
    same::<3, 4>(0.0, [0.0, 0.0, -9.81]);
}

#[test]
fn viscous_triangles_move_as_in_the_simulation() {
    same::<2, 3>(0.2, [1.0, 0.0]);
}

#[test]
fn viscous_tetrahedra_move_as_in_the_simulation() {
    same::<3, 4>(0.2, [0.0, 1.0, 0.0]);
}
