//! Contacts of surfaces that touch at the beginning under initial stress.
//!
//! The potentials of contacts (`simplex`) are zero where two surfaces just touch. A *seam* carries the
//! initial stress across such surfaces. It acts at Gauss points on the common part of two outer facets, with
//! the normal traction `p₀` and the tangential traction `τ₀` of the stress of the two elements (the mean
//! stress if the two differ). The facets need not match: Gauss points integrate the linear shape functions
//! exactly, so that each node gets exactly the force that balances a uniform stress. Bodies under matching
//! stress stay at rest.
//!
//! Let `g` be the opening and `k` the stiffness of the contact potential of the two elements. A seam stores,
//! per area,
//!
//! ```text
//! ψ = p₀²/(2 k) - p₀ g    g ≤ 0,        p = -∂ψ/∂g = p₀
//! ψ = (p₀ - k g)²/(2 k)   0 < g < p₀/k  p = p₀ - k g
//! ψ = 0                   p₀/k ≤ g      p = 0
//! ```
//! When bodies approach, the contact potential acts in addition to `p₀`. When they separate, the traction
//! falls as in a contact that began with an overlap of `p₀/k`. Forces are the exact gradient of `ψ`,
//! including the rotation of the facets, so that energy and angular momentum are conserved. The tangential
//! traction follows Coulomb's law, `|τ| ≤ µ p`, with a spring before it slips, as in contacts.
//!
//! A seam joins two points of the surfaces. As their distance grows from 0.1 to 0.3 of the shorter facet, the
//! seam fades and hands over to the contact potential. The energy that the faded share had stored counts as
//! dissipated by friction. The faded share does not come back.

use fdem_contact::{Couple as Pair, Detector, Elements as Boxes, Search};
use fdem_distributed::wire;

use crate::action::{Acting, Action, Record, Scene};
use crate::compiled::compiled;
use crate::contacts;
use crate::energy::{Account, Ledger};
use crate::error::ModelError;
use crate::faces::Faces;
use crate::model::{Model, Schedule};
use crate::simplex::Simplex;
use crate::solid::{Solid, corners_of};
use crate::topology::{Topology, corners_of_facet, place_in_element};
use crate::vector::{Matrix, Point, add, along, applied, at_most, dot, length, matrix, minus, plus, unit};

/// Facets touch if they are nearer than this share of the shorter one.
const TOUCH: f64 = 1e-6;

/// Smaller differences, over the shorter facet or over the pressure, come from rounding.
const ROUNDING: f64 = 1e-9;

/// The tractions on the two sides of a surface count as different if their difference exceeds this share of
/// their mean.
const UNLIKE: f64 = 0.05;

/// Distance of the two points of a seam, over the shorter facet, at which the seam begins to fade, and at
/// which it has faded completely.
pub(crate) const FADE: [f64; 2] = [0.1, 0.3];

/// Upper limit of tangential over normal stiffness: the critical time step allows for this much.
const TANGENTIAL: f64 = 0.5;

/// Surfaces that touch at the beginning under initial stress, and the problems found there. Checks a model
/// before a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InitialContacts {
    /// Length, m, or area, m², of the surfaces that carry initial stress.
    pub length: f64,
    /// First two elements between which the initial stress is tensile: a contact cannot carry tension.
    pub pulled: Option<[u32; 2]>,
    /// First two elements between which the initial shear exceeds friction: they slip immediately.
    pub slipping: Option<[u32; 2]>,
    /// The two elements whose initial tractions on their common surface differ most, and the difference, Pa.
    /// The surface begins with the mean, so that they are not in equilibrium.
    pub unlike: Option<([u32; 2], f64)>,
}

impl InitialContacts {
    /// Initial contacts of a model; none without initial stress.
    ///
    /// # Errors
    /// An error that says why the model cannot be simulated.
    pub fn of<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        compiled!((model: reference [Model<2, 3>, Model<3, 4>])
            -> [Result<InitialContacts, ModelError>, Result<InitialContacts, ModelError>] = InitialContacts::of_model)
    }

    fn of_model<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        crate::checks::check(model)?;
        let faces = Faces::new(&Topology::of(&model.mesh)?);
        Ok(Seams::new(model, &faces, &Solid::new(model))?.found)
    }
}

/// Constants of a point of a seam.
#[derive(Clone, Copy, Debug)]
struct Place<const D: usize> {
    /// Corners of both facets, each as its element has them.
    corners: [[u32; D]; 2],
    /// Weights of these corners at the point.
    shares: [[f64; D]; 2],
    /// Area that the point represents, m².
    area: f64,
    /// Length of the shorter facet, m.
    reach: f64,
    /// Opening and sliding at the beginning, m, by rounding of the mesh.
    gap: [f64; D],
    /// Initial normal traction `p₀`, Pa.
    pressure: f64,
    /// Normal and tangential stiffness, Pa/m.
    stiffness: [f64; 2],
    /// Coefficient of friction.
    friction: f64,
}

/// State of a point of a seam. Vectors are along the surface, with a first component across it of 0.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SeamState<const D: usize = 2> {
    /// Sliding, and sliding at which the tangential spring is relaxed, m.
    sliding: [f64; D],
    slip: [f64; D],
    /// Present tangential traction, Pa.
    traction: [f64; D],
    /// Share that has been handed over to contact, 0 to 1.
    faded: f64,
    /// Work against friction so far, energy that the tangential spring had stored at the beginning, and
    /// energy of the share that has faded, J.
    friction: f64,
}

wire!([const D: usize] SeamState<D> { sliding, slip, traction, faded, friction });

impl<const D: usize> Default for SeamState<D> {
    fn default() -> Self {
        Self { sliding: [0.0; D], slip: [0.0; D], traction: [0.0; D], faded: 0.0, friction: 0.0 }
    }
}

/// All seams of a model.
#[derive(Debug, Default)]
pub(crate) struct Seams<const D: usize = 2> {
    places: Vec<Place<D>>,
    holds: Vec<SeamState<D>>,
    /// Results of the last step.
    pressed: Vec<PointForces<D>>,
    /// Points that this rank counts, whose other element is elsewhere: they have no force any more.
    loose: Vec<(Record, SeamState<D>)>,
    found: InitialContacts,
}

/// Result of a point of a seam in a step.
#[derive(Clone, Copy, Debug)]
struct PointForces<const D: usize> {
    /// Forces on the corners of both facets, N.
    forces: [[Point<D>; D]; 2],
    /// Energy stored in the potential, J.
    energy: f64,
}

impl<const D: usize> PointForces<D> {
    const NONE: Self = Self { forces: [[[0.0; D]; D]; 2], energy: 0.0 };
}

impl<const D: usize> Seams<D> {
    /// The seams of a model; none without initial stress.
    pub(crate) fn new<const N: usize>(
        model: &Model<D, N>,
        faces: &Faces<D>,
        solid: &Solid<D, N>,
    ) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut seams = Self::default();
        if model.stresses.is_empty() {
            return Ok(seams);
        }
        let position = |corner: u32| solid.position_at(corner);
        for touching in near::<D, N>(&faces.outer, |facet| facet.map(position))? {
            seams.join(model, touching, position);
        }
        Ok(seams)
    }

    /// Adds the points of a seam if two outer facets touch and the stress presses them together.
    fn join<const N: usize>(
        &mut self,
        model: &Model<D, N>,
        corners: [[u32; D]; 2],
        position: impl Fn(u32) -> Point<D>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let ends = corners.map(|facet| facet.map(&position));
        let lengths = ends.map(|facet| length_of::<D, N>(&facet));
        let reach = lengths[0].min(lengths[1]);
        let common = <[[f64; D]; N]>::common(&ends[0], &ends[1], TOUCH * reach, ROUNDING * reach);
        if common.is_empty() {
            return;
        }
        let axes = <[[f64; D]; N]>::axes(&ends[0]).map(unit);
        let elements = corners.map(|facet| facet[0] / N as u32);
        let [one, other] = elements.map(|element| model.stresses[element as usize]);
        let on = |stress: Matrix<D>| applied(&stress, axes[0]);
        let difference = minus(on(one), on(other));
        let traction = on(matrix(|i, k| 0.5 * (one[i][k] + other[i][k])));
        let difference = length(difference);
        if difference > UNLIKE * length(traction)
            && self.found.unlike.is_none_or(|(_, most)| difference > most)
        {
            self.found.unlike = Some((elements, difference));
        }
        let (pressure, shear) = (-dot(traction, axes[0]), along(axes.map(|axis| dot(traction, axis))));
        if pressure <= 0.0 {
            if pressure < 0.0 {
                self.found.pulled.get_or_insert(elements);
            }
            return;
        }
        let materials = elements.map(|element| model.mesh.materials[element as usize]);
        let [penalty, friction] = contacts::penalty_and_friction(model, materials);
        // φ grows by N over the height of each of the two elements.
        let slope = |facet: [u32; D]| {
            let shape = corners_of(&model.mesh, facet[0] as usize / N);
            N as f64 / shape.height(place_in_element::<D, N>(&facet))
        };
        let stiffness = penalty * (slope(corners[0]) + slope(corners[1]));
        let tangential = model.contact.tangential_stiffness.min(TANGENTIAL) * stiffness;
        let held = if tangential > 0.0 { at_most(shear, friction * pressure) } else { [0.0; D] };
        if length(minus(held, shear)) > ROUNDING * pressure {
            self.found.slipping.get_or_insert(elements);
        }
        for (shares, measure) in common {
            self.found.length += measure;
            let mut place = Place {
                corners,
                shares,
                area: measure * model.thickness,
                reach,
                gap: [0.0; D],
                pressure,
                stiffness: [stiffness, tangential],
                friction,
            };
            place.gap = place.frame::<N>(ends).gap;
            let slip = if tangential > 0.0 { held.map(|traction| -traction / tangential) } else { [0.0; D] };
            let squared = place.area * dot(held, held);
            let friction = if squared == 0.0 { 0.0 } else { squared / (2.0 * tangential) };
            self.holds.push(SeamState { slip, traction: held, friction, ..SeamState::default() });
            self.places.push(place);
            self.pressed.push(PointForces::NONE);
        }
    }

    /// The two elements at each point, and the force on the first of them in the last step, N.
    pub(crate) fn pushes<const N: usize>(&self) -> impl Iterator<Item = ([u32; 2], Point<D>)> {
        self.places.iter().zip(&self.pressed).map(|(place, pressed)| {
            let force = pressed.forces[0].into_iter().fold([0.0; D], plus);
            (place.corners.map(|side| side[0] / N as u32), force)
        })
    }

    /// The place of a point among all of them, by the codes of its two sides and its number there.
    fn place<const N: usize>(&self, record: &Record, topology: &Topology<D, N>) -> Option<usize>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let corners = |code: u32| {
            let element = topology.element(code / N as u32)?;
            Some(corners_of_facet::<D, N>(element as usize, code as usize % N))
        };
        let [Some(one), Some(other)] = record.codes.map(corners) else { return None };
        let first = self.places.partition_point(|at| at.corners < [one, other]);
        let place = first + record.place as usize;
        self.places.get(place).is_some_and(|at| at.corners == [one, other]).then_some(place)
    }
}

impl<const D: usize, const N: usize> Action<D, N> for Seams<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn act(&mut self, acting: &mut Acting<'_, D, N>) {
        let Self { places, holds, pressed, .. } = self;
        if places.is_empty() {
            return;
        }
        let on = acting.solid();
        acting.scene.team.change_both(holds, pressed, |first, holds, pressed| {
            for (k, (hold, pressed)) in holds.iter_mut().zip(pressed).enumerate() {
                let place = &places[first + k];
                let ends = place.corners.map(|facet| facet.map(|corner| on.position_at(corner)));
                *pressed = place.press::<N>(hold, ends);
            }
        });
        for (place, pressed) in places.iter().zip(pressed) {
            place.give(pressed.forces, |corner, force| {
                acting.add_force(corner, force);
            });
        }
    }

    fn initial_forces(&self, scene: &Scene<'_, D, N>, _schedules: &[Schedule]) -> Vec<Point<D>> {
        if self.places.is_empty() {
            return Vec::new();
        }
        let mut forces = vec![[0.0; D]; N * scene.solid().element_count()];
        for (place, hold) in self.places.iter().zip(&self.holds) {
            let ends = place.corners.map(|facet| facet.map(|corner| scene.solid().position_at(corner)));
            let frame = place.frame::<N>(ends);
            place.give(place.forces::<N>(&frame, place.pressure, hold.traction), |corner, force| {
                add(&mut forces[corner as usize], force, 1.0);
            });
        }
        forces
    }

    fn add_energies(&self, scene: &Scene<'_, D, N>, ledger: &mut Ledger) {
        let share = scene.machine.share();
        let counted = || {
            (0..self.places.len())
                .filter(|&k| share.is_whole() || share.element(self.places[k].corners[0][0] / N as u32))
        };
        ledger.add(Account::Contact, &counted().map(|k| self.pressed[k].energy).collect());
        ledger.add(Account::Friction, &counted().map(|k| self.holds[k].friction).collect());
        ledger.add(Account::Friction, &self.loose.iter().map(|(_, hold)| hold.friction).collect());
    }

    fn records(&self, scene: &Scene<'_, D, N>) -> Vec<Record> {
        let (solid, topology) = (scene.solid(), scene.topology);
        let all = self.places.iter().zip(&self.holds).enumerate();
        let counted = all.filter(|(_, (place, _))| solid.share().element(place.corners[0][0] / N as u32));
        let points = counted.map(|(k, (place, hold))| {
            let first = self.places.partition_point(|other| other.corners < place.corners);
            Record::new(place.corners.map(|side| topology.code_of_side(&side)), (k - first) as u32, hold)
        });
        points.chain(self.loose.iter().map(|(record, _)| record.clone())).collect()
    }

    fn take(&mut self, record: &Record, scene: &Scene<'_, D, N>) -> bool {
        let Some(hold) = record.value(&SeamState::default()) else { return false };
        if let Some(place) = self.place(record, scene.topology) {
            self.holds[place] = hold;
            return true;
        }
        let own = scene.topology.element(record.codes[0] / N as u32);
        let counted =
            !scene.solid().share().is_whole() && own.is_some_and(|own| scene.solid().share().element(own));
        if counted {
            self.loose.push((record.clone(), hold));
        }
        counted
    }
}

/// Positions of the two points of a seam, in the frame of the first facet.
struct PointPositions<const D: usize> {
    /// The first facet.
    facet: [Point<D>; D],
    /// Unit vectors: its outward normal, and directions along it.
    axes: Matrix<D>,
    /// From the point on the first facet to that on the second.
    apart: Point<D>,
    /// Components of `apart` along the axes.
    gap: [f64; D],
}

impl<const D: usize> Place<D> {
    #[inline]
    fn frame<const N: usize>(&self, ends: [[Point<D>; D]; 2]) -> PointPositions<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let axes = <[[f64; D]; N]>::axes(&ends[0]).map(unit);
        let [a, b] = [0, 1].map(|side| -> Point<D> {
            let (ends, shares) = (ends[side], self.shares[side]);
            std::array::from_fn(|axis| dot(shares, ends.map(|end| end[axis])))
        });
        let apart = minus(b, a);
        PointPositions { facet: ends[0], axes, apart, gap: axes.map(|axis| dot(apart, axis)) }
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

    /// Forces on the corners of both facets from the normal and the tangential traction. They follow from the
    /// gradients of opening and sliding, which turn with the first facet.
    #[inline]
    fn forces<const N: usize>(
        &self,
        frame: &PointPositions<D>,
        pressure: f64,
        traction: [f64; D],
    ) -> [[Point<D>; D]; 2]
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let PointPositions { facet, axes, gap, .. } = frame;
        let turning = <[[f64; D]; N]>::turning(facet, axes, gap, pressure, &traction, self.area);
        let mut forces = [[[0.0; D]; D]; 2];
        for axis in 0..D {
            let mut force = pressure * axes[0][axis];
            for k in 1..D {
                force -= traction[k] * axes[k][axis];
            }
            force *= self.area;
            for end in 0..D {
                forces[0][end][axis] = turning[end][axis] - self.shares[0][end] * force;
                forces[1][end][axis] = self.shares[1][end] * force;
            }
        }
        forces
    }

    /// Updates a point. Returns its forces and its energy.
    #[inline]
    fn press<const N: usize>(&self, hold: &mut SeamState<D>, ends: [[Point<D>; D]; 2]) -> PointForces<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if hold.faded >= 1.0 {
            return PointForces::NONE;
        }
        let frame = self.frame::<N>(ends);
        let since = minus(frame.gap, self.gap);
        let sliding = along(since);
        let [pressure, potential] = self.potential(since[0]);
        let far = (length(frame.apart) / self.reach - FADE[0]) / (FADE[1] - FADE[0]);
        let fading = (far.clamp(0.0, 1.0) - hold.faded).max(0.0);
        hold.faded += fading;
        let weight = 1.0 - hold.faded;
        let trial = minus(sliding, hold.slip).map(|sliding| self.stiffness[1] * sliding);
        let held = at_most(trial, self.friction * pressure);
        if held != trial {
            hold.slip = minus(sliding, held.map(|traction| traction / self.stiffness[1]));
        }
        let traction = held.map(|traction| weight * traction);
        let slid = dot(plus(hold.traction, traction).map(|sum| 0.5 * sum), minus(sliding, hold.sliding));
        (hold.sliding, hold.traction) = (sliding, traction);
        hold.friction += self.area * (slid + fading * potential);
        PointForces {
            forces: self.forces::<N>(&frame, weight * pressure, traction),
            energy: self.area * weight * potential,
        }
    }

    /// Gives each corner the force on it.
    #[inline]
    fn give(&self, forces: [[Point<D>; D]; 2], mut give: impl FnMut(u32, Point<D>)) {
        for (corners, forces) in self.corners.into_iter().zip(forces) {
            for (corner, force) in corners.into_iter().zip(forces) {
                give(corner, force);
            }
        }
    }
}

/// Length of a facet, as an edge, m.
fn length_of<const D: usize, const N: usize>(facet: &[Point<D>; D]) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    <[[f64; D]; N]>::facet_length(<[[f64; D]; N]>::facet_measure(facet))
}

/// Pairs of facets whose boxes touch, ascending, by their corners.
fn near<const D: usize, const N: usize>(
    facets: &[[u32; D]],
    ends: impl Fn([u32; D]) -> [Point<D>; D],
) -> Result<Vec<[[u32; D]; 2]>, ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let [mut min, mut max]: [Vec<Point<D>>; 2] = [0, 1].map(|_| Vec::with_capacity(facets.len()));
    let mut longest: f64 = 0.0;
    for &facet in facets {
        let ends = ends(facet);
        let along = |axis: usize| ends.iter().map(move |end| end[axis]);
        min.push(std::array::from_fn(|axis| along(axis).fold(f64::INFINITY, f64::min)));
        max.push(std::array::from_fn(|axis| along(axis).fold(f64::NEG_INFINITY, f64::max)));
        longest = longest.max(length_of::<D, N>(&ends));
    }
    let mut pairs: Vec<Pair> = Vec::new();
    Boxes::boxes(&min, &max)
        // Enough for all: the facets themselves decide.
        .and_then(|boxes| boxes.with_tolerance(TOUCH * longest))
        .and_then(|boxes| Detector::new().couples(&boxes, &mut pairs))
        .map_err(|error| ModelError::Detection { message: error.to_string() })?;
    pairs.sort_unstable();
    Ok(pairs.into_iter().map(|Pair { i, j }| [i, j].map(|k| facets[k as usize])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::cross;

    /// A point of a seam between two edges of different lengths.
    fn place() -> (Place<2>, [[Point; 2]; 2]) {
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
            let frame = place.frame::<3>(ends);
            assert!((frame.gap[0] - opening).abs() < 1e-12);
            let forces = place.forces::<3>(&frame, place.potential(frame.gap[0])[0], [0.0; 2]);
            let energy = |ends| place.area * place.potential(place.frame::<3>(ends).gap[0])[1];
            check(forces, ends, energy);
            // Work against a constant tangential traction.
            let forces = place.forces::<3>(&frame, 0.0, [0.0, 1.5]);
            check(forces, ends, |ends| place.area * 1.5 * place.frame::<3>(ends).gap[1]);
            let torque: f64 = (0..4).map(|k| cross(ends[k / 2][k % 2], forces[k / 2][k % 2])).sum();
            assert!(torque.abs() < 1e-14, "{torque}");
        }
    }

    /// Moves the second edge along the normal until the gap is `opening`.
    fn shifted(place: &Place<2>, mut ends: [[Point; 2]; 2], opening: f64) -> [[Point; 2]; 2] {
        let frame = place.frame::<3>(ends);
        for end in &mut ends[1] {
            for axis in 0..2 {
                end[axis] += (opening - frame.gap[0]) * frame.axes[0][axis];
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

    /// A seam that slides far fades completely. The dissipated energy equals the work done on it and the
    /// energy that it had stored.
    #[test]
    fn what_slides_away_is_accounted_for() {
        let (place, ends) = place();
        let mut ends = shifted(&place, ends, 0.005);
        let frame = place.frame::<3>(ends);
        let mut place = Place { gap: [0.0, frame.gap[1]], ..place };
        place.reach = 0.5;
        let mut hold = SeamState::default();
        let mut pressed = place.press::<3>(&mut hold, ends);
        let (begin, steps) = (pressed.energy, 40_000);
        let mut work = 0.0;
        let step = frame.axes[1].map(|t| 0.4 * t / f64::from(steps));
        for _ in 0..steps {
            for end in &mut ends[1] {
                *end = [end[0] + step[0], end[1] + step[1]];
            }
            let before = pressed.forces;
            pressed = place.press::<3>(&mut hold, ends);
            for end in 0..2 {
                work -= 0.5 * (dot(before[1][end], step) + dot(pressed.forces[1][end], step));
            }
        }
        let friction = hold.friction;
        assert_eq!((hold.faded, pressed.energy), (1.0, 0.0));
        assert!(work > 0.0 && (work + begin - friction).abs() < 1e-6 * begin, "{work} {begin} {friction}");
    }
}
