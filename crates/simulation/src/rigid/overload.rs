//! The load of a rigid body as a share of its strength: see [`UntilOverloaded`](crate::UntilOverloaded).

use crate::exposure::exposure;
use crate::model::Model;
use crate::rigid::{RigidBody, RigidMotion};
use crate::rotation::matrix_of;
use crate::simplex::Simplex;
use crate::solid::{Solid, corners_of};
use crate::topology::{NONE, Topology};
use crate::vector::{Matrix, Point, add, dot, length, matrix, minus, product, transposed};

impl<const D: usize, const N: usize> Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The load of a rigid body under the forces of the last step and its rotation, as a share of its
    /// strength.
    pub(crate) fn overload(&self, body: usize, model: &Model<D, N>, topology: &Topology<D, N>) -> f64 {
        let (body, motion) = (&self.rigid.all[body], &self.rigid.motions[body]);
        let mut moments = inertia_moments(body, motion);
        let mut load = 0.0_f64;
        for &element in &body.elements {
            let mut push = [0.0; D];
            for corner in (0..N as u32).map(|k| element * N as u32 + k) {
                let force = self.force(corner);
                if force == [0.0; D] {
                    continue;
                }
                add(&mut push, force, 1.0);
                let arm = minus(self.position_at(corner), motion.centre);
                for (row, x) in moments.iter_mut().zip(arm) {
                    add(row, force, x / 2.0);
                }
            }
            if push != [0.0; D] {
                load = load.max(pressure_share(model, topology, element as usize, push));
            }
        }
        // The mean stress: moments about the centre of mass over the volume.
        let stress = matrix(|i, k| (moments[i][k] + moments[k][i]) / body.volume);
        // In the middle of a disc between two opposite forces, the tension is half of the mean compression,
        // and nearly so in a ball; the mean stress has none of it.
        let [_, radius] = <[[f64; D]; N]>::circle(&stress);
        let strengths =
            body.materials.iter().filter_map(|&material| model.materials[material as usize].strength);
        strengths
            .map(|strength| exposure::<D, N>(&strength, &stress).max(radius / strength.tensile))
            .fold(load, f64::max)
    }
}

/// The force on an element, N, over the area of its outer facets, as a share of the strength in compression,
/// `2 c cos φ / (1 - sin φ)`.
fn pressure_share<const D: usize, const N: usize>(
    model: &Model<D, N>,
    topology: &Topology<D, N>,
    element: usize,
    force: Point<D>,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let Some(strength) = model.materials[model.mesh.materials[element] as usize].strength else { return 0.0 };
    let shape = corners_of(&model.mesh, element);
    let outer = (0..N).filter(|&k| topology.facet_of[element][k] == NONE);
    let area = outer.map(|k| {
        let facet = <[[f64; D]; N]>::FACETS[k].map(|corner| shape[corner]);
        <[[f64; D]; N]>::facet_measure(&facet) * model.thickness
    });
    let area: f64 = area.sum();
    // cos φ / (1 - sin φ) = tan φ + 1 / cos φ
    let slope = strength.friction;
    let compressive = 2.0 * strength.cohesion * (slope + (1.0 + slope * slope).sqrt());
    if area > 0.0 { length(force) / (area * compressive) } else { 0.0 }
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
