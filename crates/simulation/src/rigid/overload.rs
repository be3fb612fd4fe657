//! How near the strength of a rigid body the forces on it are: see
//! [`UntilOverloaded`](crate::UntilOverloaded).

use crate::exposure::exposure;
use crate::model::{Model, Strength};
use crate::rigid::{RigidBody, RigidMotion};
use crate::rotation::matrix_of;
use crate::simplex::Simplex;
use crate::solid::{Solid, corners_of};
use crate::topology::{NONE, Topology};
use crate::vector::{Matrix, add, dot, length, matrix, minus, product, transposed};

impl<const D: usize, const N: usize> Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The load of a rigid body under the forces of the last step, as a share of its strength.
    pub(crate) fn overload(&self, body: usize, model: &Model<D, N>, topology: &Topology<D, N>) -> f64 {
        let (body, motion) = (&self.rigid.all[body], &self.rigid.motions[body]);
        let stress = self.mean_stress_of(body, motion);
        // In the middle of a disc between two opposite forces, the tension is half of the mean compression,
        // and nearly so in a ball; the mean stress has none of it.
        let [_, radius] = <[[f64; D]; N]>::circle(&stress);
        let strengths = self.strengths_of(body, model);
        let of_stress = strengths
            .iter()
            .map(|strength| exposure::<D, N>(strength, &stress).max(radius / strength.tensile))
            .fold(0.0, f64::max);
        self.contact_share(body, model, topology).max(of_stress)
    }

    /// Mean stress of a rigid body under the forces on its corners and its inertia, Pa: their moments about
    /// its centre of mass over its volume.
    fn mean_stress_of(&self, body: &RigidBody<D>, motion: &RigidMotion<D>) -> Matrix<D> {
        let (mut moments, mut volume) = (inertia_moments(body, motion), 0.0);
        for &element in &body.elements {
            volume += self.element(element as usize).volume;
            for corner in (0..N as u32).map(|k| element * N as u32 + k) {
                let force = self.force(corner);
                let arm = minus(self.position_at(corner), motion.centre);
                for (row, x) in moments.iter_mut().zip(arm) {
                    add(row, force, x / 2.0);
                }
            }
        }
        matrix(|i, k| (moments[i][k] + moments[k][i]) / volume)
    }

    /// The strengths of the materials of a body, each once.
    fn strengths_of(&self, body: &RigidBody<D>, model: &Model<D, N>) -> Vec<Strength> {
        let mut materials: Vec<u32> =
            body.elements.iter().map(|&element| self.element(element as usize).material).collect();
        materials.sort_unstable();
        materials.dedup();
        materials.into_iter().filter_map(|material| model.materials[material as usize].strength).collect()
    }

    /// The largest force on an element over the area of its outer facets, as a share of the strength in
    /// compression, `2 c cos φ / (1 - sin φ)`.
    fn contact_share(&self, body: &RigidBody<D>, model: &Model<D, N>, topology: &Topology<D, N>) -> f64 {
        let share = |&element: &u32| {
            let mut force = [0.0; D];
            (0..N as u32).for_each(|k| add(&mut force, self.force(element * N as u32 + k), 1.0));
            let material = self.element(element as usize).material;
            let strength = model.materials[material as usize].strength?;
            if force == [0.0; D] {
                return None;
            }
            let shape = corners_of(&model.mesh, element as usize);
            let outer = (0..N).filter(|&k| topology.facet_of[element as usize][k] == NONE);
            let area = outer.map(|k| {
                let facet = <[[f64; D]; N]>::FACETS[k].map(|corner| shape[corner]);
                <[[f64; D]; N]>::facet_measure(&facet) * model.thickness
            });
            let area: f64 = area.sum();
            // cos φ / (1 - sin φ) = tan φ + 1 / cos φ
            let slope = strength.friction;
            let compressive = 2.0 * strength.cohesion * (slope + (1.0 + slope * slope).sqrt());
            (area > 0.0).then(|| length(force) / (area * compressive))
        };
        body.elements.iter().filter_map(share).fold(0.0, f64::max)
    }
}

/// Half of the moments of the inertia of a body about its centre of mass, N m: none unless it turns. With
/// the angular velocity ω, the mass at the arm x pulls with `-ω × (ω × x)`.
fn inertia_moments<const D: usize>(body: &RigidBody<D>, motion: &RigidMotion<D>) -> Matrix<D> {
    let turn = matrix_of(motion.orientation);
    let spread = product(&product(&turn, &body.spread()), &transposed(&turn));
    let spin = motion.spin;
    let pull: Matrix<3> = matrix(|i, k| f64::from(u8::from(i == k)) * dot(spin, spin) - spin[i] * spin[k]);
    let whole = product(&spread, &pull);
    matrix(|i, k| 0.5 * whole[i][k])
}
