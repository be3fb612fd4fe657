//! Forces between two elements in contact: potential, friction, damping.

use serde::{Deserialize, Serialize};

use crate::contacts::Couple;
use crate::forces::ContactForce;
use crate::model::Model;
use crate::simplex::triangle::Triangle;
use crate::simplex::{Interaction, Simplex};
use crate::solid::Solid;
use crate::vector::{Point, dot, length, minus};

/// Forces and history of two elements in contact.
#[derive(Debug, Default)]
pub(super) struct Contact {
    /// Forces of potential, damping and friction on the corners of both elements, N.
    pub(super) forces: [[Point; 3]; 2],
    pub(super) grip: Grip,
    /// Energy, and works since the last pass.
    pub(super) works: Works,
    /// Whether the two overlap. False in the one pass after they have separated.
    pub(super) touches: bool,
    pub(super) deep: bool,
}

impl Contact {
    /// Force on the first of the two elements, at the point where they overlap now.
    pub(super) fn force(&self, elements: [u32; 2], solid: &Solid) -> ContactForce {
        let sum = self.forces[0].iter().fold([0.0; 2], |sum, force| [sum[0] + force[0], sum[1] + force[1]]);
        let [a, b] = elements.map(|element| solid.shape(element));
        let point = a.interaction(&b).map_or_else(
            // They have separated in this step.
            |_| [0, 1].map(|axis| a.iter().chain(&b).map(|corner| corner[axis]).sum::<f64>() / 6.0),
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Grip {
    /// Friction on the first element, N.
    friction: Point,
    /// Damping on the first element, N.
    damping: Point,
    /// Area coordinates, in both elements, of the point where the force acted.
    shares: [[f64; 3]; 2],
    /// Initial potential energy, J, which is not counted: see [`count_from`].
    credited_energy: f64,
}

/// Contact parameters of two materials.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    /// Penalty times thickness, N/m.
    penalty: f64,
    friction: f64,
    /// Tangential stiffness, N/m.
    tangential: f64,
    /// Share of critical damping.
    damping: f64,
}

/// Parameters of contacts between two materials.
pub(super) fn law(model: &Model, a: u32, b: u32) -> Law {
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
pub(crate) fn penalty_and_friction(model: &Model, [a, b]: [u32; 2]) -> [f64; 2] {
    let law = law(model, a, b);
    [law.penalty / model.thickness, law.friction]
}

/// Upper bound of the stiffness, N/m, that a contact over edge `k` of an element of this material has at either end of the edge.
pub(crate) fn stiffness(model: &Model, triangle: &Triangle, k: usize, material: u32) -> f64 {
    let penalty = (0..model.materials.len() as u32)
        .map(|other| law(model, material, other).penalty)
        .fold(0.0_f64, f64::max);
    let edge = minus(triangle[(k + 1) % 3], triangle[k]);
    // φ grows by 3 over the height. Half of the pressure on the edge goes to each end. Each of the two elements presses the other: factor 2.
    let normal = 3.0 * penalty / triangle.height(k) * 0.5 * length(edge);
    2.0 * normal.max(model.contact.tangential_stiffness * penalty)
}

/// Computes the forces of one couple. `weight`: share of the forces that acts, while a joint between the two carries the rest; `fading`: increase of this share
/// in the last step. `step` in s, `travel` in m.
pub(super) fn press(
    couple: &mut Couple,
    solid: &Solid,
    law: &Law,
    [weight, fading]: [f64; 2],
    step: f64,
    travel: f64,
) {
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
                // Both elements may move, each by half of the distance. The factor is slightly below 0.5 because `travel` is rounded.
                couple.apart_until = travel + 0.499 * distance;
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
    for force in forces.iter_mut().flatten().flatten() {
        *force *= scale;
    }
    sum.energy += weight * energy;
    sum.handed_over += fading * energy;
    let mut grip = Grip { credited_energy, ..Grip::default() };
    if law.friction > 0.0 || law.damping > 0.0 {
        grip.shares = [a.coordinates(point), b.coordinates(point)];
        let push = forces[0].iter().fold([0.0; 2], |sum, force| [sum[0] + force[0], sum[1] + force[1]]);
        let size = length(push);
        if size > 0.0 {
            let normal = [push[0] / size, push[1] / size];
            let tangent = [-normal[1], normal[0]];
            let rate = relative_velocity(couple.elements, &grip.shares, solid);
            let mut pressed = size;
            if law.damping > 0.0 {
                let [m, n] = couple.elements.map(|element| mass(solid, element));
                let critical = 2.0 * (law.penalty * m * n / (m + n)).sqrt();
                // At most the force that presses the two apart, so that they do not stick.
                let damping = (-law.damping * weight * critical * dot(rate, normal)).clamp(-size, size);
                grip.damping = normal.map(|n| damping * n);
                pressed += damping;
            }
            if law.friction > 0.0 {
                let limit = law.friction * pressed;
                let held = before.map_or(0.0, |before| dot(before.friction, tangent));
                let trial = held - weight * law.tangential * step * dot(rate, tangent);
                let friction = trial.clamp(-limit, limit);
                grip.friction = tangent.map(|t| friction * t);
            }
            sum.friction -= 0.5 * step * dot(grip.friction, rate);
            sum.damping -= 0.5 * step * dot(grip.damping, rate);
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                for corner in 0..3 {
                    let share = sign * grip.shares[side][corner];
                    for axis in 0..2 {
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

/// Velocity, m/s, of the first element relative to the second, at the points with these area coordinates.
fn relative_velocity(elements: [u32; 2], shares: &[[f64; 3]; 2], solid: &Solid) -> Point {
    let mut rate = [0.0; 2];
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        for corner in 0..3 {
            let node = solid.nodes_of(elements[side])[corner];
            let velocity = solid.nodes[node as usize].velocity;
            for axis in 0..2 {
                rate[axis] += sign * shares[side][corner] * velocity[axis];
            }
        }
    }
    rate
}

/// Mean mass of the three nodes of an element, kg.
fn mass(solid: &Solid, element: u32) -> f64 {
    solid.nodes_of(element).iter().map(|&node| solid.constants[node as usize].mass / 3.0).sum()
}

/// Gap, m, between the boxes of two triangles along the axis on which they are farthest apart; negative if the boxes overlap.
#[inline]
fn gap(a: &Triangle, b: &Triangle) -> f64 {
    let along = |axis: usize| {
        let [a, b] = [a, b].map(|t| {
            let [p, q, r] = [t[0][axis], t[1][axis], t[2][axis]];
            [p.min(q).min(r), p.max(q).max(r)]
        });
        (a[0] - b[1]).max(b[0] - a[1])
    };
    along(0).max(along(1))
}
