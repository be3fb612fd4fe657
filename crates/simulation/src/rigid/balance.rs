//! The stress of a body that stops being rigid: the static one of the forces on it.
//!
//! The forces and the inertia of the rigid body are in equilibrium. The displacements that they would give by
//! Hooke's law are the solution of `K u = f`, found by conjugate gradients; their stresses become the initial
//! stress of the elements. So no node moves, the forces of contacts stay, and the body deforms from where it
//! is without a wave.

use crate::laws::AnyLaw;
use crate::model::Model;
use crate::rigid::{RigidBody, RigidMotion, add_point_mass};
use crate::rotation::{inverse, lifted, lowered, matrix_of};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::solid::batch::forces_of;
use crate::vector::{
    Matrix, Point, add, applied, cholesky, cross3, dot, matrix, minus, plus, product, transposed,
};

/// Residual over the forces at which the solution is good enough: far below the error of a mesh.
const GOOD: f64 = 1e-9;

/// Most iterations for each node. The residual of a mesh without slivers needs fewer than its nodes.
const ITERATIONS: usize = 20;

/// Pairs of axes of the components of a symmetric tensor: those of the diagonal first.
fn pairs<const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..D).map(|i| (i, i)).chain((0..D).flat_map(|i| (i + 1..D).map(move |k| (i, k))))
}

/// Hooke's law of a material.
struct Hooke {
    /// Stress, Pa, over the strain in components: see [`pairs`].
    stiffness: Matrix<6>,
}

impl Hooke {
    /// The law for small strains of a law, from the energy that it stores under a stress.
    fn of<const D: usize, const N: usize>(law: &AnyLaw<D>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let stored = |parts: [usize; 2]| {
            let mut stress = [[0.0; D]; D];
            for (i, k) in parts.iter().filter_map(|&part| pairs::<D>().nth(part)) {
                stress[i][k] += 1.0;
                stress[k][i] = stress[i][k];
            }
            law.stored::<N>(&stress)
        };
        let none = usize::MAX;
        let count = D * (D + 1) / 2;
        // The compliance S of the energy sᵀ S s / 2. The components that the plane does not have are apart.
        let scale = stored([0, none]);
        let compliance: Matrix<6> = matrix(|i, k| match (i, k) {
            _ if i == k && i >= count => scale,
            _ if i >= count || k >= count => 0.0,
            _ if i == k => 2.0 * stored([i, none]),
            _ => stored([i, k]) - stored([i, none]) - stored([k, none]),
        });
        Self { stiffness: inverse_of(&compliance) }
    }

    /// The stress of a gradient of displacements.
    fn stress<const D: usize>(&self, gradient: &Matrix<D>) -> Matrix<D> {
        let mut strain = [0.0; 6];
        for (part, (i, k)) in strain.iter_mut().zip(pairs::<D>()) {
            *part = if i == k { gradient[i][i] } else { gradient[i][k] + gradient[k][i] };
        }
        let parts = applied(&self.stiffness, strain);
        let mut stress = [[0.0; D]; D];
        for (part, (i, k)) in parts.into_iter().zip(pairs::<D>()) {
            (stress[i][k], stress[k][i]) = (part, part);
        }
        stress
    }
}

/// The inverse of a positive matrix.
fn inverse_of(a: &Matrix<6>) -> Matrix<6> {
    let lower = cholesky(a);
    let mut columns = [[0.0; 6]; 6];
    for (c, column) in columns.iter_mut().enumerate() {
        for i in 0..6 {
            let known: f64 = (0..i).map(|k| lower[i][k] * column[k]).sum();
            column[i] = (f64::from(u8::from(i == c)) - known) / lower[i][i];
        }
        for i in (0..6).rev() {
            let known: f64 = (i + 1..6).map(|k| lower[k][i] * column[k]).sum();
            column[i] = (column[i] - known) / lower[i][i];
        }
    }
    columns
}

/// A body with Hooke's law.
struct Elastic<'a, const D: usize, const N: usize> {
    solid: &'a Solid<D, N>,
    /// The nodes of each element among those of the body.
    corners: Vec<[usize; N]>,
    elements: &'a [u32],
    /// The law of each element among `laws`.
    law_of: Vec<usize>,
    laws: Vec<Hooke>,
    /// Places of the nodes in the undeformed body, m, and their masses, kg.
    places: Vec<Point<D>>,
    masses: Vec<f64>,
}

impl<'a, const D: usize, const N: usize> Elastic<'a, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn new(solid: &'a Solid<D, N>, body: &'a RigidBody<D>, model: &Model<D, N>) -> Self {
        let mesh = &model.mesh;
        let of_mesh = |&element: &u32| mesh.elements[element as usize];
        let mut nodes: Vec<u32> = body.elements.iter().flat_map(of_mesh).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let place_of = |node: u32| nodes.partition_point(|&other| other < node);
        let corners: Vec<[usize; N]> =
            body.elements.iter().map(|element| of_mesh(element).map(place_of)).collect();
        let (mut materials, mut law_of) = (Vec::new(), Vec::new());
        let mut masses = vec![0.0; nodes.len()];
        for (&element, corners) in body.elements.iter().zip(&corners) {
            let of = solid.element(element as usize);
            let density = model.materials[of.material as usize].density;
            for &node in corners {
                masses[node] += density * of.volume / N as f64;
            }
            let known = materials.iter().position(|&(material, _)| material == of.material);
            law_of.push(known.unwrap_or(materials.len()));
            if known.is_none() {
                materials.push((of.material, Hooke::of::<D, N>(solid.law(element as usize))));
            }
        }
        Self {
            solid,
            corners,
            elements: &body.elements,
            law_of,
            laws: materials.into_iter().map(|(_, law)| law).collect(),
            places: nodes.iter().map(|&node| mesh.nodes[node as usize]).collect(),
            masses,
        }
    }

    /// The stress of each element with some displacements of the nodes, Pa, and the forces that hold them, N.
    fn pulled(&self, displacements: &[Point<D>]) -> (Vec<Matrix<D>>, Vec<Point<D>>) {
        let mut forces = vec![[0.0; D]; displacements.len()];
        let stresses =
            self.corners.iter().zip(self.elements).zip(&self.law_of).map(|((corners, &element), &law)| {
                let gradients = self.solid.inverse_edges(element as usize);
                let edges = <[[f64; D]; N]>::edges(&corners.map(|node| displacements[node]));
                let stress = self.laws[law].stress(&product(&edges, &gradients));
                let volume = self.solid.element(element as usize).volume;
                let on: [Point<D>; N] = forces_of(&stress, &gradients, volume);
                for (&node, force) in corners.iter().zip(on) {
                    add(&mut forces[node], force, -1.0);
                }
                stress
            });
        let stresses = stresses.collect();
        (stresses, forces)
    }

    /// The forces on the nodes and the inertia of the rigid body with them, N, in the undeformed body.
    fn loads(&self, motion: &RigidMotion<D>) -> Vec<Point<D>> {
        let back = transposed(&matrix_of(motion.orientation));
        let mut loads = vec![[0.0; D]; self.places.len()];
        for (corners, &element) in self.corners.iter().zip(self.elements) {
            for (k, &node) in (0..).zip(corners) {
                let force = lifted(self.solid.force(element * N as u32 + k));
                add(&mut loads[node], lowered(applied(&back, force)), 1.0);
            }
        }
        let mass: f64 = self.masses.iter().sum();
        let (mut centre, mut force) = ([0.0; D], [0.0; D]);
        for ((place, of_node), load) in self.places.iter().zip(&self.masses).zip(&loads) {
            add(&mut centre, *place, of_node / mass);
            add(&mut force, *load, 1.0);
        }
        let (mut moment, mut inertia) = ([0.0; 3], [[0.0; 3]; 3]);
        for ((place, of_node), load) in self.places.iter().zip(&self.masses).zip(&loads) {
            let arm = lifted(minus(*place, centre));
            add(&mut moment, cross3(arm, lifted(*load)), 1.0);
            add_point_mass(&mut inertia, *of_node, arm);
        }
        let turning = applied(&inverse(&inertia), moment);
        let spin = applied(&back, motion.spin);
        for ((place, of_node), load) in self.places.iter().zip(&self.masses).zip(&mut loads) {
            let arm = lifted(minus(*place, centre));
            let turning = plus(cross3(turning, arm), cross3(spin, cross3(spin, arm)));
            let acceleration = plus(lowered(turning), force.map(|x| x / mass));
            add(load, acceleration, -of_node);
        }
        loads
    }

    /// The stiffness of each node, by which residuals are divided, N/m.
    fn weights(&self) -> Vec<f64> {
        let mut weights = vec![0.0; self.places.len()];
        for ((corners, &element), &law) in self.corners.iter().zip(self.elements).zip(&self.law_of) {
            let stiffness = self.laws[law].stiffness[0][0] * self.solid.element(element as usize).volume;
            let gradients = self.solid.inverse_edges(element as usize);
            let square: f64 = gradients.as_flattened().iter().map(|x| x * x).sum();
            for &node in corners {
                weights[node] += stiffness * square;
            }
        }
        weights
    }

    /// The stresses under some forces on the nodes that are in equilibrium, Pa.
    fn solve(&self, loads: Vec<Point<D>>) -> Vec<Matrix<D>> {
        let sum = |a: &[Point<D>], b: &[Point<D>]| a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum::<f64>();
        let weights = self.weights();
        let over = |forces: &[Point<D>]| -> Vec<Point<D>> {
            forces.iter().zip(&weights).map(|(force, weight)| force.map(|x| x / weight)).collect()
        };
        let bound = GOOD * GOOD * sum(&loads, &loads);
        let mut displacements = vec![[0.0; D]; loads.len()];
        let mut residual = loads;
        let mut direction = over(&residual);
        let mut size = sum(&residual, &direction);
        for _ in 0..ITERATIONS * residual.len() {
            if sum(&residual, &residual) <= bound || size <= 0.0 {
                break;
            }
            let (_, pulled) = self.pulled(&direction);
            let step = size / sum(&direction, &pulled);
            for k in 0..residual.len() {
                add(&mut displacements[k], direction[k], step);
                add(&mut residual[k], pulled[k], -step);
            }
            let next = over(&residual);
            let next_size = sum(&residual, &next);
            for (direction, next) in direction.iter_mut().zip(next) {
                *direction = plus(next, direction.map(|x| x * next_size / size));
            }
            size = next_size;
        }
        self.pulled(&displacements).0
    }
}

impl<const D: usize, const N: usize> Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The static stress of each element of a rigid body under the forces of the last step, Pa, in the
    /// undeformed body.
    pub(crate) fn balanced_stresses(&self, body: usize, model: &Model<D, N>) -> Vec<(u32, Matrix<D>)> {
        let of = &self.rigid.all[body];
        let elastic = Elastic::new(self, of, model);
        let loads = elastic.loads(&self.rigid.motions[body]);
        of.elements.iter().copied().zip(elastic.solve(loads)).collect()
    }
}
