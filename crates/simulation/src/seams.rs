//! Contacts of surfaces that touch at the beginning under initial stress.
//!
//! The potentials of contacts (`simplex/triangle/potential.rs`) are zero where two surfaces just touch. A *seam* carries the initial stress across such surfaces. It acts at two
//! Gauss points on the common part of two outer edges, with the normal traction `p₀` and the tangential traction `τ₀` of the stress of the two elements (the
//! mean stress if the two differ). The edges need not match: two Gauss points integrate the linear shape functions exactly, so that each node gets exactly the
//! force that balances a uniform stress. Bodies under matching stress stay at rest.
//!
//! Let `g` be the opening and `k` the stiffness of the contact potential of the two elements. A seam stores, per area,
//!
//! ```text
//! ψ = p₀²/(2 k) - p₀ g    g ≤ 0,        p = -∂ψ/∂g = p₀
//! ψ = (p₀ - k g)²/(2 k)   0 < g < p₀/k  p = p₀ - k g
//! ψ = 0                   p₀/k ≤ g      p = 0
//! ```
//! When bodies approach, the contact potential acts in addition to `p₀`. When they separate, the traction falls as in a contact that began with an overlap of
//! `p₀/k`. Forces are the exact gradient of `ψ`, including the rotation of the edges, so that energy and angular momentum are conserved. The tangential
//! traction follows Coulomb's law, `|τ| ≤ µ p`, with a spring before it slips, as in contacts.
//!
//! A seam joins two points of the surfaces. As their distance grows from 0.1 to 0.3 of the shorter edge, the seam fades and hands over to the contact
//! potential. The energy that the faded share had stored counts as dissipated by friction. The faded share does not come back.

use fdem_contact::{Couple as Pair, Detector, Elements as Boxes, Search};
use serde::{Deserialize, Serialize};

use crate::contacts;
use crate::error::ModelError;
use crate::model::Model;
use crate::simplex::Simplex;
use crate::solid::{Solid, corners_of};
use crate::team::Team;
use crate::topology::Topology;
use crate::vector::{Matrix, Point, applied, dot, length, matrix, minus};

/// Edges touch if they are nearer than this share of the shorter edge.
const TOUCH: f64 = 1e-6;

/// Common parts of edges that are shorter than this share of the shorter edge are attributed to rounding.
const ROUNDING: f64 = 1e-9;

/// The tractions on the two sides of a surface count as different if their difference exceeds this share of their mean.
const UNLIKE: f64 = 0.05;

/// Distance of the two points of a seam, over the shorter edge, at which the seam begins to fade, and at which it has faded completely.
const FADE: [f64; 2] = [0.1, 0.3];

/// Upper limit of tangential over normal stiffness: the critical time step allows for this much.
const TANGENTIAL: f64 = 0.5;

/// Surfaces that touch at the beginning under initial stress, and the problems found there. Checks a model before a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InitialContacts {
    /// Length of the surfaces that carry initial stress, m.
    pub length: f64,
    /// First two elements between which the initial stress is tensile: a contact cannot carry tension.
    pub pulled: Option<[u32; 2]>,
    /// First two elements between which the initial shear exceeds friction: they slip at once.
    pub slipping: Option<[u32; 2]>,
    /// First two elements with different initial tractions on their common surface. The surface begins with the mean, so that they are not in equilibrium.
    pub unlike: Option<[u32; 2]>,
}

impl InitialContacts {
    /// Initial contacts of a model; none without initial stress.
    ///
    /// # Errors
    /// An error that says why the model cannot be simulated.
    pub fn of(model: &Model) -> Result<Self, ModelError> {
        crate::checks::check(model)?;
        Ok(Seams::new(model, &Topology::of(&model.mesh)?, &Solid::new(model))?.found)
    }
}

/// Constants of a point of a seam.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// Corners of both edges, each in the direction of its element.
    corners: [[u32; 2]; 2],
    /// Weights of these corners at the point.
    shares: [[f64; 2]; 2],
    /// Area that the point stands for, m².
    area: f64,
    /// Length of the shorter edge, m.
    reach: f64,
    /// Opening and sliding at the beginning, m, by rounding of the mesh.
    gap: [f64; 2],
    /// Initial normal traction `p₀`, Pa.
    pressure: f64,
    /// Normal and tangential stiffness, Pa/m.
    stiffness: [f64; 2],
    /// Coefficient of friction.
    friction: f64,
}

/// State of a point of a seam.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hold {
    /// Sliding, and sliding at which the tangential spring is relaxed, m.
    sliding: f64,
    slip: f64,
    /// Present tangential traction, Pa.
    traction: f64,
    /// Share that has been handed over to contact, 0 to 1.
    faded: f64,
}

/// All seams of a model.
#[derive(Debug, Default)]
pub(crate) struct Seams {
    places: Vec<Place>,
    holds: Vec<Hold>,
    /// Forces on the corners of both edges in the last step, N.
    forces: Vec<[[Point; 2]; 2]>,
    found: InitialContacts,
}

/// Energy and work of seams, J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pressing {
    /// Energy stored in the potential.
    pub(crate) energy: f64,
    /// Work against friction, and energy of the shares that have faded, since the last pass.
    pub(crate) friction: f64,
}

impl Seams {
    /// The seams of a model; none without initial stress.
    pub(crate) fn new(model: &Model, topology: &Topology, solid: &Solid) -> Result<Self, ModelError> {
        let mut seams = Self::default();
        if model.stresses.is_empty() {
            return Ok(seams);
        }
        let position = |corner: u32| solid.at_corner(corner).position;
        let edges: Vec<[u32; 2]> = topology.surface().collect();
        for touching in near(&edges, |edge| edge.map(position))? {
            seams.join(model, touching, position);
        }
        Ok(seams)
    }

    /// Adds the two points of a seam if two outer edges touch and the stress presses them together.
    fn join(&mut self, model: &Model, corners: [[u32; 2]; 2], position: impl Fn(u32) -> Point) {
        let ends = corners.map(|edge| edge.map(&position));
        let lengths = ends.map(|[a, b]| length(minus(b, a)));
        let reach = lengths[0].min(lengths[1]);
        let tangent = minus(ends[0][1], ends[0][0]).map(|x| x / lengths[0]);
        let normal = [tangent[1], -tangent[0]];
        // The other edge runs in the opposite direction on the line of the first.
        let from = ends[1].map(|end| minus(end, ends[0][0]));
        let [start, end] = from.map(|from| dot(from, tangent));
        let off = from.map(|from| dot(from, normal).abs()).into_iter().fold(0.0, f64::max);
        let common = [end.max(0.0), start.min(lengths[0])];
        if off > TOUCH * reach || start <= end || common[1] - common[0] <= ROUNDING * reach {
            return;
        }
        let elements = corners.map(|edge| edge[0] / 3);
        let [one, other] = elements.map(|element| model.stresses[element as usize]);
        let on = |stress: Matrix| applied(&stress, normal);
        let difference = minus(on(one), on(other));
        let traction = on(matrix(|i, k| 0.5 * (one[i][k] + other[i][k])));
        if length(difference) > UNLIKE * length(traction) {
            self.found.unlike.get_or_insert(elements);
        }
        let (pressure, shear) = (-dot(traction, normal), dot(traction, tangent));
        if pressure <= 0.0 {
            if pressure < 0.0 {
                self.found.pulled.get_or_insert(elements);
            }
            return;
        }
        let materials = elements.map(|element| model.mesh.materials[element as usize]);
        let [penalty, friction] = contacts::penalty_and_friction(model, materials);
        // φ grows by 3 over the height of each of the two triangles.
        let slope =
            |edge: [u32; 2]| 3.0 / corners_of(&model.mesh, edge[0] as usize / 3).height(edge[0] as usize % 3);
        let stiffness = penalty * (slope(corners[0]) + slope(corners[1]));
        let tangential = model.contact.tangential_stiffness.min(TANGENTIAL) * stiffness;
        let limit = friction * pressure;
        let held = if tangential > 0.0 { shear.clamp(-limit, limit) } else { 0.0 };
        // Smaller differences come from rounding.
        if (held - shear).abs() > ROUNDING * pressure {
            self.found.slipping.get_or_insert(elements);
        }
        let long = common[1] - common[0];
        self.found.length += long;
        for at in [0.5 - 0.5 / 3.0_f64.sqrt(), 0.5 + 0.5 / 3.0_f64.sqrt()] {
            let along = common[0] + at * long;
            let shares = [along / lengths[0], (start - along) / (start - end)];
            let mut place = Place {
                corners,
                shares: shares.map(|share| [1.0 - share, share]),
                area: 0.5 * long * model.thickness,
                reach,
                gap: [0.0; 2],
                pressure,
                stiffness: [stiffness, tangential],
                friction,
            };
            place.gap = place.frame(ends).gap;
            let slip = if tangential > 0.0 { -held / tangential } else { 0.0 };
            self.holds.push(Hold { slip, traction: held, ..Hold::default() });
            self.places.push(place);
            self.forces.push([[[0.0; 2]; 2]; 2]);
        }
    }

    /// Energy that tangential springs have stored at the beginning, J.
    pub(crate) fn stored(&self) -> f64 {
        let stored = |(place, hold): (&Place, &Hold)| {
            if hold.traction == 0.0 {
                return 0.0;
            }
            place.area * hold.traction * hold.traction / (2.0 * place.stiffness[1])
        };
        self.places.iter().zip(&self.holds).map(stored).sum()
    }

    /// Force on each corner at the beginning, N; empty without seams.
    pub(crate) fn initial_forces(&self, solid: &Solid) -> Vec<Point> {
        if self.places.is_empty() {
            return Vec::new();
        }
        let mut forces = vec![[0.0; 2]; 3 * solid.elements.len()];
        for (place, hold) in self.places.iter().zip(&self.holds) {
            let ends = place.corners.map(|edge| edge.map(|corner| solid.at_corner(corner).position));
            place.add(place.forces(&place.frame(ends), place.pressure, hold.traction), |corner, [x, y]| {
                forces[corner as usize][0] += x;
                forces[corner as usize][1] += y;
            });
        }
        forces
    }

    /// Adds the forces of all seams to the corners of elements.
    pub(crate) fn press(&mut self, solid: &mut Solid, team: &Team) -> Pressing {
        let Self { places, holds, forces, .. } = self;
        let on = &*solid;
        let found = team.change_both(holds, forces, |first, holds, forces| {
            let mut sum = Pressing::default();
            for (k, (hold, forces)) in holds.iter_mut().zip(forces).enumerate() {
                let place = &places[first + k];
                let ends = place.corners.map(|edge| edge.map(|corner| on.at_corner(corner).position));
                let (now, pressing) = place.press(hold, ends);
                *forces = now;
                sum.energy += pressing.energy;
                sum.friction += pressing.friction;
            }
            sum
        });
        for (place, forces) in places.iter().zip(forces) {
            place.add(*forces, |corner, [x, y]| {
                let force = &mut solid.strained[corner as usize / 3].forces[corner as usize % 3];
                force[0] += x;
                force[1] += y;
            });
        }
        found.into_iter().fold(Pressing::default(), |sum, chunk| Pressing {
            energy: sum.energy + chunk.energy,
            friction: sum.friction + chunk.friction,
        })
    }

    pub(crate) fn save(&self) -> Vec<Hold> {
        self.holds.clone()
    }

    /// Restores the saved seams.
    pub(crate) fn restore(&mut self, saved: Vec<Hold>) -> Result<(), ModelError> {
        let (found, expected) = (saved.len(), self.holds.len());
        if found != expected {
            return Err(ModelError::Length { what: "contacts under initial stress", found, expected });
        }
        self.holds = saved;
        Ok(())
    }
}

/// Positions of the two points of a seam, in the frame of the first edge.
struct Frame {
    tangent: Point,
    normal: Point,
    /// Length of the first edge, m.
    long: f64,
    /// From the point on the first edge to that on the second.
    apart: Point,
    /// `apart` along the normal and along the tangent.
    gap: [f64; 2],
}

impl Place {
    #[inline]
    fn frame(&self, ends: [[Point; 2]; 2]) -> Frame {
        let along = minus(ends[0][1], ends[0][0]);
        let long = length(along);
        let tangent = along.map(|x| x / long);
        let normal = [tangent[1], -tangent[0]];
        let [a, b] = [0, 1].map(|side| -> Point {
            let ([one, other], [p, q]) = (ends[side], self.shares[side]);
            std::array::from_fn(|axis| p * one[axis] + q * other[axis])
        });
        let apart = minus(b, a);
        Frame { tangent, normal, long, apart, gap: [dot(apart, normal), dot(apart, tangent)] }
    }

    /// Normal traction, Pa, and potential energy per area, J/m², at an opening.
    #[inline]
    fn potential(&self, opening: f64) -> [f64; 2] {
        let (most, stiffness) = (self.pressure, self.stiffness[0]);
        if opening <= 0.0 {
            return [most, most * (0.5 * most / stiffness - opening)];
        }
        let pressure = (most - stiffness * opening).max(0.0);
        [pressure, 0.5 * pressure * pressure / stiffness]
    }

    /// Forces on the corners of both edges from the normal and the tangential traction. They follow from the gradients of opening and sliding, which turn with
    /// the first edge.
    #[inline]
    fn forces(&self, frame: &Frame, pressure: f64, traction: f64) -> [[Point; 2]; 2] {
        let Frame { tangent, normal, long, gap, .. } = frame;
        let moment = (pressure * gap[1] + traction * gap[0]) * self.area / long;
        let mut forces = [[[0.0; 2]; 2]; 2];
        for axis in 0..2 {
            let force = self.area * (pressure * normal[axis] - traction * tangent[axis]);
            for end in 0..2 {
                let turn = if end == 0 { moment } else { -moment };
                forces[0][end][axis] = turn * normal[axis] - self.shares[0][end] * force;
                forces[1][end][axis] = self.shares[1][end] * force;
            }
        }
        forces
    }

    /// Updates a point. Returns its forces, and its energy and the work against friction since the last pass.
    #[inline]
    fn press(&self, hold: &mut Hold, ends: [[Point; 2]; 2]) -> ([[Point; 2]; 2], Pressing) {
        if hold.faded >= 1.0 {
            return Default::default();
        }
        let frame = self.frame(ends);
        let [opening, sliding] = [0, 1].map(|k| frame.gap[k] - self.gap[k]);
        let [pressure, potential] = self.potential(opening);
        let far = (length(frame.apart) / self.reach - FADE[0]) / (FADE[1] - FADE[0]);
        let fading = (far.clamp(0.0, 1.0) - hold.faded).max(0.0);
        hold.faded += fading;
        let weight = 1.0 - hold.faded;
        let trial = self.stiffness[1] * (sliding - hold.slip);
        let limit = self.friction * pressure;
        let held = trial.clamp(-limit, limit);
        if held != trial {
            hold.slip = sliding - held / self.stiffness[1];
        }
        let traction = weight * held;
        let slid = 0.5 * (hold.traction + traction) * (sliding - hold.sliding);
        (hold.sliding, hold.traction) = (sliding, traction);
        let pressing = Pressing {
            energy: self.area * weight * potential,
            friction: self.area * (slid + fading * potential),
        };
        (self.forces(&frame, weight * pressure, traction), pressing)
    }

    /// Calls `add` with each corner and the force on it.
    #[inline]
    fn add(&self, forces: [[Point; 2]; 2], mut add: impl FnMut(u32, Point)) {
        for (corners, forces) in self.corners.into_iter().zip(forces) {
            for (corner, force) in corners.into_iter().zip(forces) {
                add(corner, force);
            }
        }
    }
}

/// Pairs of edges whose boxes touch, ascending. Each edge is given by the number of its first corner.
fn near(edges: &[[u32; 2]], ends: impl Fn([u32; 2]) -> [Point; 2]) -> Result<Vec<[[u32; 2]; 2]>, ModelError> {
    let [mut min, mut max] = [Vec::with_capacity(edges.len()), Vec::with_capacity(edges.len())];
    let mut shortest = f64::INFINITY;
    for &edge in edges {
        let [a, b] = ends(edge);
        min.push([a[0].min(b[0]), a[1].min(b[1])]);
        max.push([a[0].max(b[0]), a[1].max(b[1])]);
        shortest = shortest.min(length(minus(b, a)));
    }
    let mut pairs: Vec<Pair> = Vec::new();
    Boxes::boxes(&min, &max)
        .and_then(|boxes| boxes.with_tolerance(TOUCH * shortest))
        .and_then(|boxes| Detector::new().couples(&boxes, &mut pairs))
        .map_err(|error| ModelError::Detection { message: error.to_string() })?;
    pairs.sort_unstable();
    Ok(pairs.into_iter().map(|Pair { i, j }| [i, j].map(|k| edges[k as usize])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::cross;

    /// A point of a seam between two edges of different lengths.
    fn place() -> (Place, [[Point; 2]; 2]) {
        let place = Place {
            corners: [[0, 1], [3, 4]],
            shares: [[0.7, 0.3], [0.4, 0.6]],
            area: 0.5,
            reach: 1.0,
            gap: [0.0; 2],
            pressure: 2.0,
            stiffness: [100.0, 40.0],
            friction: 0.5,
        };
        (place, [[[0.0, 0.0], [1.0, 0.2]], [[1.1, 0.1], [-0.2, 0.03]]])
    }

    #[test]
    fn forces_are_the_gradient_of_the_energy() {
        let (place, ends) = place();
        let openings = [-0.05, -0.01, 0.005, 0.015, 0.03];
        for opening in openings {
            let ends = shifted(&place, ends, opening);
            let frame = place.frame(ends);
            assert!((frame.gap[0] - opening).abs() < 1e-12);
            let forces = place.forces(&frame, place.potential(frame.gap[0])[0], 0.0);
            let energy = |ends| place.area * place.potential(place.frame(ends).gap[0])[1];
            check(forces, ends, energy);
            // Work against a constant tangential traction.
            let forces = place.forces(&frame, 0.0, 1.5);
            check(forces, ends, |ends| place.area * 1.5 * place.frame(ends).gap[1]);
            let torque: f64 = (0..4).map(|k| cross(ends[k / 2][k % 2], forces[k / 2][k % 2])).sum();
            assert!(torque.abs() < 1e-14, "{torque}");
        }
    }

    /// Moves the second edge along the normal until the gap is `opening`.
    fn shifted(place: &Place, mut ends: [[Point; 2]; 2], opening: f64) -> [[Point; 2]; 2] {
        let frame = place.frame(ends);
        for end in &mut ends[1] {
            for axis in 0..2 {
                end[axis] += (opening - frame.gap[0]) * frame.normal[axis];
            }
        }
        ends
    }

    fn check(forces: [[Point; 2]; 2], ends: [[Point; 2]; 2], energy: impl Fn([[Point; 2]; 2]) -> f64) {
        for k in 0..8 {
            let (side, end, axis, h) = (k / 4, k / 2 % 2, k % 2, 1e-7);
            let at = |sign: f64| {
                let mut moved = ends;
                moved[side][end][axis] += sign * h;
                energy(moved)
            };
            let slope = (at(1.0) - at(-1.0)) / (2.0 * h);
            assert!((forces[side][end][axis] + slope).abs() < 1e-6, "{k}: {forces:?} {slope}");
        }
    }

    /// A seam that slides far fades completely. The dissipated energy equals the work done on it and the energy that it had stored.
    #[test]
    fn what_slides_away_is_accounted_for() {
        let (place, ends) = place();
        let mut ends = shifted(&place, ends, 0.005);
        let frame = place.frame(ends);
        let mut place = Place { gap: [0.0, frame.gap[1]], ..place };
        place.reach = 0.5;
        let mut hold = Hold::default();
        let (mut forces, mut pressing) = place.press(&mut hold, ends);
        let (begin, steps) = (pressing.energy, 40_000);
        let (mut work, mut friction) = (0.0, 0.0);
        let step = frame.tangent.map(|t| 0.4 * t / f64::from(steps));
        for _ in 0..steps {
            for end in &mut ends[1] {
                *end = [end[0] + step[0], end[1] + step[1]];
            }
            let before = forces;
            (forces, pressing) = place.press(&mut hold, ends);
            friction += pressing.friction;
            for end in 0..2 {
                work -= 0.5 * (dot(before[1][end], step) + dot(forces[1][end], step));
            }
        }
        assert_eq!((hold.faded, pressing.energy), (1.0, 0.0));
        assert!(work > 0.0 && (work + begin - friction).abs() < 1e-6 * begin, "{work} {begin} {friction}");
    }
}
