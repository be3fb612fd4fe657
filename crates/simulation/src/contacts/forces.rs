//! Forces between two elements in contact: potential, friction, damping.

use serde::{Deserialize, Serialize};

use crate::contacts::{Couple, skipped_until};
use crate::forces::ContactForce;
use crate::model::Model;
use crate::simplex::{Interaction, Simplex};
use crate::solid::Solid;
use crate::vector::{Point, add, at_most, dot, length, minus};

/// Forces and history of two elements in contact.
#[derive(Debug)]
pub(super) struct Contact<const D: usize, const N: usize> {
    /// Forces of potential, damping and friction on the corners of both elements, N.
    pub(super) forces: [[Point<D>; N]; 2],
    pub(super) grip: Grip<D, N>,
    /// Energy, and works since the last pass.
    pub(super) works: Works,
    /// Whether the two overlap. False in the one pass after they have separated.
    pub(super) touches: bool,
    pub(super) deep: bool,
}

impl<const D: usize, const N: usize> Default for Contact<D, N> {
    fn default() -> Self {
        Self {
            forces: [[[0.0; D]; N]; 2],
            grip: Grip::default(),
            works: Works::default(),
            touches: false,
            deep: false,
        }
    }
}

impl<const D: usize, const N: usize> Contact<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Force on the first of the two elements, at the point where they overlap now.
    pub(super) fn force(&self, elements: [u32; 2], solid: &Solid<D, N>) -> ContactForce<D> {
        let sum = total(&self.forces[0]);
        let [a, b] = elements.map(|element| solid.shape(element));
        let point = a.interaction(&b).map_or_else(
            // They have separated in this step.
            |_| {
                std::array::from_fn(|axis| {
                    a.iter().chain(&b).map(|corner| corner[axis]).sum::<f64>() / (2 * N) as f64
                })
            },
            |interaction| interaction.point,
        );
        let tangential = self.grip.friction;
        ContactForce { elements, point, normal: minus(sum, tangential), tangential }
    }
}

/// Energy of a contact, and works since the last pass, J.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Works {
    pub(super) energy: f64,
    pub(super) friction: f64,
    pub(super) damping: f64,
    pub(super) handed_over: f64,
}

/// History of friction and damping of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [f64; N]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [f64; N]: Deserialize<'de>"
))]
pub(super) struct Grip<const D: usize, const N: usize> {
    /// Friction on the first element, N.
    friction: Point<D>,
    /// Damping on the first element, N.
    damping: Point<D>,
    /// Barycentric coordinates, in both elements, of the point where the force acted.
    shares: [[f64; N]; 2],
    /// Initial potential energy, J, which is not counted: see [`count_from`].
    credited_energy: f64,
}

impl<const D: usize, const N: usize> Default for Grip<D, N> {
    fn default() -> Self {
        Self { friction: [0.0; D], damping: [0.0; D], shares: [[0.0; N]; 2], credited_energy: 0.0 }
    }
}

/// Contact parameters of two materials.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    /// Penalty times thickness: N/m in two dimensions, Pa in three.
    penalty: f64,
    friction: f64,
    /// Tangential stiffness, likewise.
    tangential: f64,
    /// Share of critical damping.
    damping: f64,
}

/// Parameters of contacts between two materials.
pub(super) fn law<const D: usize, const N: usize>(model: &Model<D, N>, a: u32, b: u32) -> Law {
    let interface = model.interface(a, b);
    let [one, two] = [a, b].map(|material| &model.materials[material as usize]);
    let penalty = interface
        .and_then(|interface| interface.penalty)
        .unwrap_or(model.contact.penalty * one.youngs_modulus.min(two.youngs_modulus))
        * model.thickness;
    let friction = interface.map_or(one.friction.min(two.friction), |interface| interface.friction);
    Law {
        penalty,
        friction,
        tangential: model.contact.tangential_stiffness * penalty,
        damping: model.contact.damping,
    }
}

/// Penalty of contacts between two materials, Pa, and their coefficient of friction.
pub(crate) fn penalty_and_friction<const D: usize, const N: usize>(
    model: &Model<D, N>,
    [a, b]: [u32; 2],
) -> [f64; 2] {
    let law = law(model, a, b);
    [law.penalty / model.thickness, law.friction]
}

/// Upper bound of the stiffness, N/m, that a contact over facet `k` of an element of this material has at each vertex of the facet.
pub(crate) fn stiffness<const D: usize, const N: usize>(
    model: &Model<D, N>,
    corners: &[Point<D>; N],
    k: usize,
    material: u32,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let penalty = (0..model.materials.len() as u32)
        .map(|other| law(model, material, other).penalty)
        .fold(0.0_f64, f64::max);
    let measure = <[[f64; D]; N]>::facet_measure(&<[[f64; D]; N]>::FACETS[k].map(|corner| corners[corner]));
    // φ grows by N over the height. A part of 1/D of the pressure on the facet goes to each vertex. Each of the two elements presses the other: factor 2.
    let normal = N as f64 * penalty / corners.height(k) * (1.0 / D as f64) * measure;
    let length = <[[f64; D]; N]>::contact_length(corners.measure());
    2.0 * normal.max(model.contact.tangential_stiffness * penalty * length)
}

/// Computes the forces of one couple. `weight`: share of the forces that acts, while a joint between the two carries the rest; `fading`: increase of this share
/// in the last step. `step` in s, `travel` in m.
pub(super) fn press<const D: usize, const N: usize>(
    couple: &mut Couple<D, N>,
    solid: &Solid<D, N>,
    law: &Law,
    [weight, fading]: [f64; 2],
    step: f64,
    travel: f64,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let [a, b] = couple.elements.map(|element| solid.shape(element));
    let gap = gap(&a, &b);
    // While the joint carries the whole load, the gap says nothing about when contact begins: the couple must not be skipped.
    let found = match (weight > 0.0, gap < 0.0) {
        (true, true) => a.interaction(&b),
        (true, false) => Err(gap),
        (false, _) => Err(0.0),
    };
    let initial_overlap = std::mem::take(&mut couple.initial_overlap);
    // Work of the last friction and damping in the second half of their step.
    let mut sum = Works::default();
    let before = couple.contact.as_ref().filter(|contact| contact.touches).map(|contact| contact.grip);
    if let Some(before) = &before {
        let rate = relative_velocity(couple.elements, &before.shares, solid);
        sum.friction -= 0.5 * step * dot(before.friction, rate);
        sum.damping -= 0.5 * step * dot(before.damping, rate);
    }
    let Interaction { mut forces, energy, point, deep } = match found {
        Ok(interaction) => interaction,
        Err(distance) => {
            // Keeps the contact for one more pass, so that this work is counted.
            couple.contact = before.map(|_| Box::new(Contact { works: sum, ..Contact::default() }));
            if couple.contact.is_none() {
                couple.apart_until = skipped_until(travel, distance);
            }
            return;
        }
    };
    let potential = law.penalty * energy;
    let credited_energy = match &before {
        _ if initial_overlap => potential,
        Some(before) => before.credited_energy.min(potential),
        None => 0.0,
    };
    let (energy, slope) = count_from(credited_energy, potential);
    let scale = law.penalty * weight * slope;
    for force in forces.as_flattened_mut().as_flattened_mut() {
        *force *= scale;
    }
    sum.energy += weight * energy;
    sum.handed_over += fading * energy;
    let mut grip = Grip { credited_energy, ..Grip::default() };
    if law.friction > 0.0 || law.damping > 0.0 {
        grip.shares = [a.coordinates(point), b.coordinates(point)];
        let push = total(&forces[0]);
        let size = length(push);
        if size > 0.0 {
            let axes = <[[f64; D]; N]>::axes_around(push.map(|x| x / size));
            let normal = axes[0];
            let volume = couple.elements.map(|element| solid.elements[element as usize].volume);
            let length = <[[f64; D]; N]>::contact_length(volume[0].min(volume[1]));
            let rate = relative_velocity(couple.elements, &grip.shares, solid);
            let mut pressed = size;
            if law.damping > 0.0 {
                let [m, n] = couple.elements.map(|element| mass(solid, element));
                let critical = 2.0 * (law.penalty * length * m * n / (m + n)).sqrt();
                // At most the force that presses the two apart, so that they do not stick.
                let damping = (-law.damping * weight * critical * dot(rate, normal)).clamp(-size, size);
                grip.damping = normal.map(|n| damping * n);
                pressed += damping;
            }
            if law.friction > 0.0 {
                // In the directions along the surface, as these are now.
                let slip = weight * law.tangential * length * step;
                let mut trial = [0.0; D];
                for k in 1..D {
                    let held = before.map_or(0.0, |before| dot(before.friction, axes[k]));
                    trial[k] = held - slip * dot(rate, axes[k]);
                }
                let held = at_most(trial, law.friction * pressed);
                for k in 1..D {
                    add(&mut grip.friction, axes[k], held[k]);
                }
            }
            sum.friction -= 0.5 * step * dot(grip.friction, rate);
            sum.damping -= 0.5 * step * dot(grip.damping, rate);
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                for corner in 0..N {
                    let share = sign * grip.shares[side][corner];
                    for axis in 0..D {
                        forces[side][corner][axis] += share * (grip.friction[axis] + grip.damping[axis]);
                    }
                }
            }
        }
    }
    let contact = couple.contact.get_or_insert_default();
    **contact = Contact { forces, grip, works: sum, touches: true, deep };
}

/// Counted part of the potential energy `U`, J, and its derivative by `U`, if the energy `U₀` (`credited_energy`) was there before the two elements could touch.
///
/// Elements that were connected until a joint at their vertex broke overlap by the sliding of that joint. Counting this overlap at once would create energy.
/// `(U - U₀)² / U` begins without energy and without force, and its ratio to `U` tends to 1. When `U` falls below `U₀`, the caller lowers `U₀` to `U`.
fn count_from(credited_energy: f64, potential: f64) -> (f64, f64) {
    if potential <= credited_energy {
        return (0.0, 0.0);
    }
    let share = credited_energy / potential;
    (potential * (1.0 - share) * (1.0 - share), 1.0 - share * share)
}

/// Velocity, m/s, of the first element relative to the second, at the points with these barycentric coordinates.
fn relative_velocity<const D: usize, const N: usize>(
    elements: [u32; 2],
    shares: &[[f64; N]; 2],
    solid: &Solid<D, N>,
) -> Point<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut rate = [0.0; D];
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        for (node, share) in solid.nodes_of(elements[side]).into_iter().zip(shares[side]) {
            let velocity = solid.nodes[node as usize].velocity;
            for axis in 0..D {
                rate[axis] += sign * share * velocity[axis];
            }
        }
    }
    rate
}

/// Mean mass of the nodes of an element, kg.
fn mass<const D: usize, const N: usize>(solid: &Solid<D, N>, element: u32) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    solid.nodes_of(element).iter().map(|&node| solid.constants[node as usize].mass / N as f64).sum()
}

/// Sum of forces.
fn total<const D: usize>(forces: &[Point<D>]) -> Point<D> {
    forces.iter().fold([0.0; D], |sum, force| std::array::from_fn(|axis| sum[axis] + force[axis]))
}

/// A lower bound of the distance of two elements, m; `None` if they overlap. The bound need not be sharp beyond `most`.
pub(super) fn distance<const D: usize, const N: usize>(
    a: &[Point<D>; N],
    b: &[Point<D>; N],
    most: f64,
) -> Option<f64>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let apart = gap(a, b).max(gap_between_middles(a, b));
    if apart > most {
        return Some(apart);
    }
    let told = a.interaction(b).err()?.max(apart);
    Some(if told > most { told } else { a.distance(b, told) })
}

/// Gap, m, between two elements along the line between their centroids; negative if there is none.
#[inline]
fn gap_between_middles<const D: usize, const N: usize>(a: &[Point<D>; N], b: &[Point<D>; N]) -> f64 {
    let line: Point<D> = std::array::from_fn(|axis| {
        b.iter().map(|corner| corner[axis]).sum::<f64>() - a.iter().map(|corner| corner[axis]).sum::<f64>()
    });
    let least = b.iter().map(|corner| dot(*corner, line)).fold(f64::INFINITY, f64::min);
    let most = a.iter().map(|corner| dot(*corner, line)).fold(f64::NEG_INFINITY, f64::max);
    (least - most) / length(line)
}

/// Gap, m, between the boxes of two elements along the axis on which they are farthest apart; negative if the boxes overlap.
#[inline]
fn gap<const D: usize, const N: usize>(a: &[Point<D>; N], b: &[Point<D>; N]) -> f64 {
    let along = |axis: usize| {
        let [a, b] = [a, b].map(|corners| {
            corners[1..].iter().fold([corners[0][axis]; 2], |[low, high], corner| {
                [low.min(corner[axis]), high.max(corner[axis])]
            })
        });
        (a[0] - b[1]).max(b[0] - a[1])
    };
    (1..D).fold(along(0), |most, axis| most.max(along(axis)))
}
