//! The forces between one sphere and a surface of facets.
//!
//! The memory of a contact belongs to the sphere. It continues where the direction of the contact is closest
//! to that of the step before, and not by the number of a facet, so that surfaces may be numbered anew and
//! break. Where two minima exchange their order, so that the other of them pays the pass between them
//! ([`sheets`](crate::sheets)), the springs of the contact go over with the force.
//!
//! When a body breaks below a sphere, the sphere touches the new edge at once, with an overlap that it has
//! not made by its motion. Such a contact begins without force: its overlap counts from there on.

use serde::{Deserialize, Serialize};

use crate::columns::{GrainContact, GrainPartner};
use crate::error::GrainError;
use crate::facet::{Closest, FacetRotation};
use crate::law::{ContactHistory, Meeting, PairLaw};
use crate::run::balls::Ball;
use crate::run::laws::Laws;
use crate::servo::Answer;
use crate::sheets::{Facets, Minimum, Sheets};
use crate::vector::{Vector, across, cross, dot, length, minus, plus, times};
use crate::wall::Wall;

/// The memory of the contact of a sphere with a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct FacetHistory {
    /// From the surface to the sphere in the last step.
    normal: Vector,
    /// Where they touched, m.
    place: Vector,
    /// Force of the contact, N, and of the pass that was taken off it.
    own: f64,
    pass: f64,
    /// Energy of the springs, J, and of a contact that only pulls.
    springs: f64,
    pull: f64,
    /// Overlap that does not count, m.
    relief: f64,
    contact: ContactHistory,
}

/// How a surface moves.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SurfaceMotion<'a> {
    /// As a wall that is in its place.
    Wall(&'a Wall),
    /// Velocity of each point, m/s.
    Points(&'a [Vector]),
}

/// A contact of a sphere with a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetContact {
    pub(crate) sphere: u32,
    pub(crate) facet: u32,
    /// m.
    pub(crate) place: Vector,
    /// Force on the sphere, N, and its part along the normal.
    pub(crate) force: Vector,
    pub(crate) normal: f64,
    /// m.
    pub(crate) overlap: f64,
}

/// Results of the contacts of some spheres.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touches {
    pub(crate) contacts: Vec<FacetContact>,
    /// Points of the surface, the spheres and the forces on the points, N; only for the points of bodies.
    pub(crate) on_points: Vec<(u32, u32, Vector)>,
    /// Sums over the contacts of one sphere.
    pub(crate) totals: SurfaceTotals,
}

/// Sums over contacts with a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SurfaceTotals {
    /// Force on the surface, N, and moment about the origin, N m.
    pub(crate) force: Vector,
    pub(crate) moment: Vector,
    /// Energy in the contacts, J, and dissipated in the step.
    pub(crate) elastic: f64,
    pub(crate) dissipated: f64,
    /// Work of dashpots and friction against the motion in the step, J. The energy that springs take up or
    /// lose is the rest of that dissipated.
    pub(crate) against: f64,
    /// Work on the surface in the step, J.
    pub(crate) work: f64,
    /// Stiffness and dashpots of the contacts along the direction of the servo.
    pub(crate) answer: Answer,
}

/// Everything but the sphere that its contacts with a surface depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Encounter<'a> {
    pub(crate) facets: Facets<'a>,
    pub(crate) motion: SurfaceMotion<'a>,
    /// Number of the material of each facet; one for all if it has one entry.
    pub(crate) materials: &'a [u32],
    pub(crate) laws: &'a Laws,
    /// Moment of inertia of spheres over mass and square of the radius.
    pub(crate) share: f64,
    /// Direction of the servo.
    pub(crate) direction: Option<Vector>,
    /// Whether contacts that begin with an overlap begin without force.
    pub(crate) relieves: bool,
    /// s.
    pub(crate) step: f64,
}

/// Memory that is used again for each sphere.
#[derive(Clone, Debug, Default)]
pub(crate) struct FacetScratch {
    pub(crate) sheets: Sheets,
    pairs: Vec<(f64, u32, u32)>,
    partners: Vec<Option<u32>>,
    is_taken: Vec<bool>,
    /// Force of the pass of each minimum, N, and the force that each history has lost.
    passes: Vec<f64>,
    lost: Vec<f64>,
    next: Vec<FacetHistory>,
}

/// Square of the greatest difference between the directions of a contact in two steps.
const TURN: f64 = 0.25;

/// Steps of motion that a contact has made at most when it begins, and a share of the radius besides.
const SUDDEN: f64 = 4.0;
const ROUNDING: f64 = 1e-6;

/// Share of the radius within which a contact stays when the centre of its sphere passes through the surface.
const THROUGH: f64 = 0.25;

impl Encounter<'_> {
    /// The law of a sphere and a facet.
    fn law(&self, ball: &Ball, facet: u32) -> Result<&PairLaw, GrainError> {
        let material =
            if self.materials.len() == 1 { self.materials[0] } else { self.materials[facet as usize] };
        self.laws.of([ball.material, material])
    }

    /// The force, N, and the moment about its centre, N m, on a sphere. `near`: all facets that it may touch.
    ///
    /// # Errors
    /// [`GrainError::UnknownSurfaces`] if two materials touch that have no law.
    pub(crate) fn press(
        &self,
        ball: &Ball,
        near: &[u32],
        histories: &mut Vec<FacetHistory>,
        scratch: &mut FacetScratch,
        touches: &mut Touches,
    ) -> Result<[Vector; 2], GrainError> {
        let reach = ball.radius + self.laws.reach(ball.radius);
        scratch.sheets.find(ball.position, reach, near, &self.facets);
        let through = Self::pressed_through(ball, &scratch.sheets, histories);
        // Those that stay take theirs back.
        for of in histories.iter() {
            touches.totals.dissipated += of.springs + of.pull;
        }
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        if let Some(minimum) = through {
            scratch.sheets.minima.clear();
            scratch.sheets.minima.push(minimum);
        }
        if scratch.sheets.minima.is_empty() {
            histories.clear();
            return Ok([force, moment]);
        }
        scratch.passes.clear();
        for minimum in &scratch.sheets.minima {
            let overlap = minimum.pass.as_ref().map(|pass| ball.radius - pass.distance);
            scratch.passes.push(self.law(ball, minimum.facet)?.pass_force(overlap, ball.radius));
        }
        scratch.continue_histories(histories);
        scratch.next.clear();
        for (minimum, partner) in scratch.sheets.minima.iter().zip(&scratch.partners) {
            let mut old = partner.map_or_else(FacetHistory::default, |k| histories[k as usize]);
            let law = self.law(ball, minimum.facet)?;
            let overlap = minimum.overlap(ball, through.is_some());
            if partner.is_none() && minimum.pass.is_none() && self.relieves && self.is_sudden(ball, minimum) {
                old.relief = overlap;
            }
            old.relief = old.relief.min(overlap.max(0.0));
            let counting = overlap - old.relief;
            if law.touches(counting, ball.radius, &old.contact) {
                let (own, history) = self.touch(ball, minimum, (law, counting), old, touches);
                force = plus(force, own[0]);
                moment = plus(moment, own[1]);
                scratch.next.push(history);
            } else if old.relief > 0.0 {
                let relief = old.relief;
                let Closest { normal, place, .. } = minimum.at;
                scratch.next.push(FacetHistory { normal, place, relief, ..FacetHistory::default() });
            }
        }
        histories.clone_from(&scratch.next);
        Ok([force, moment])
    }

    /// Whether an overlap is greater than the motion of the last steps has made it.
    fn is_sudden(&self, ball: &Ball, minimum: &Minimum) -> bool {
        let velocity = match self.motion {
            SurfaceMotion::Wall(wall) => wall.velocity_at(minimum.at.place),
            SurfaceMotion::Points(of) => minimum.at.mean(|p| of[p as usize]),
        };
        let made = SUDDEN * self.step * length(minus(ball.velocity, velocity));
        ball.radius - minimum.at.distance > made + ROUNDING * ball.radius
    }

    /// The closest point of the surface, with its direction turned round, if the centre of the sphere has
    /// passed through the surface there.
    fn pressed_through(ball: &Ball, sheets: &Sheets, histories: &[FacetHistory]) -> Option<Minimum> {
        let (mut at, facet) = sheets.closest?;
        let is_through = |of: &FacetHistory| {
            dot(of.normal, at.normal) < 0.0 && length(minus(of.place, at.place)) < THROUGH * ball.radius
        };
        if !histories.iter().any(is_through) {
            return None;
        }
        at.normal = times(-1.0, at.normal);
        Some(Minimum { at, facet, pass: None })
    }

    /// Force and moment of one contact on the sphere, and its continued history.
    fn touch(
        &self,
        ball: &Ball,
        minimum: &Minimum,
        (law, overlap): (&PairLaw, f64),
        mut history: FacetHistory,
        touches: &mut Touches,
    ) -> ([Vector; 2], FacetHistory) {
        let at = &minimum.at;
        let arm = minus(at.place, ball.position);
        let rotation = FacetRotation::new(self.facets.corners[minimum.facet as usize], self.facets.points);
        let (velocity, spin) = match self.motion {
            SurfaceMotion::Wall(wall) => (wall.velocity_at(at.place), wall.spin()),
            SurfaceMotion::Points(of) => (at.mean(|p| of[p as usize]), rotation.spin(of)),
        };
        let meeting = Meeting {
            normal: at.normal,
            overlap,
            radius: ball.radius,
            mass: ball.mass,
            inertias: [(self.share + 1.0) * ball.mass * ball.radius * ball.radius, f64::INFINITY],
            velocity: minus(plus(ball.velocity, cross(ball.spin, arm)), velocity),
            spins: [ball.spin, spin],
        };
        let pass = minimum.pass.as_ref().map(|pass| ball.radius - pass.distance - history.relief);
        let reduced = law.push_reduced(&meeting, pass, &mut history.contact, self.step);
        let push = reduced.push;
        let springs = law.spring_energy(ball.radius, &history.contact);
        let along = law.energy_reduced(overlap, pass, ball.radius);
        touches.totals.elastic += springs + along;
        let friction =
            dot(across(push.force, at.normal), meeting.velocity) + dot(push.moment, minus(ball.spin, spin));
        let against = self.step * (reduced.dashpot - friction);
        touches.totals.against += against;
        touches.totals.dissipated += against - springs - history.pull;
        let mut force = push.force;
        self.react(ball, at, push.force, touches);
        if let Some(pass) = minimum.pass.as_ref().filter(|_| reduced.pass != 0.0) {
            let pull = times(-reduced.pass, pass.normal);
            force = plus(force, pull);
            self.react(ball, pass, pull, touches);
        }
        self.react_moment(ball, &rotation, push.moment, touches);
        if let Some(direction) = self.direction {
            touches.totals.answer.add(reduced.answer, dot(at.normal, direction));
        }
        touches.contacts.push(FacetContact {
            sphere: ball.number,
            facet: minimum.facet,
            place: at.place,
            force,
            normal: dot(force, at.normal),
            overlap,
        });
        let moment = plus(cross(arm, across(push.force, at.normal)), push.moment);
        let history = FacetHistory {
            normal: at.normal,
            place: at.place,
            own: reduced.own,
            pass: reduced.pass,
            springs,
            pull: if overlap < 0.0 { along } else { 0.0 },
            ..history
        };
        ([force, moment], history)
    }

    /// Puts the opposite of a force on the sphere, N, on the surface.
    fn react(&self, ball: &Ball, at: &Closest, force: Vector, touches: &mut Touches) {
        let back = times(-1.0, force);
        touches.totals.force = plus(touches.totals.force, back);
        touches.totals.moment = plus(touches.totals.moment, cross(at.place, back));
        match self.motion {
            SurfaceMotion::Wall(wall) => {
                touches.totals.work += self.step * dot(back, wall.velocity_at(at.place));
            }
            SurfaceMotion::Points(velocities) => {
                for (corner, weight) in at.corners.into_iter().zip(at.weights) {
                    if weight != 0.0 {
                        let part = times(weight, back);
                        touches.on_points.push((corner, ball.number, part));
                        touches.totals.work += self.step * dot(part, velocities[corner as usize]);
                    }
                }
            }
        }
    }

    /// Puts the opposite of a moment on the sphere, N m, on the surface.
    fn react_moment(&self, ball: &Ball, rotation: &FacetRotation, moment: Vector, touches: &mut Touches) {
        if moment == [0.0; 3] {
            return;
        }
        let back = times(-1.0, moment);
        touches.totals.moment = plus(touches.totals.moment, back);
        match self.motion {
            SurfaceMotion::Wall(wall) => touches.totals.work += self.step * dot(back, wall.spin()),
            SurfaceMotion::Points(velocities) => {
                for (corner, part) in rotation.forces(back) {
                    touches.on_points.push((corner, ball.number, part));
                    touches.totals.work += self.step * dot(part, velocities[corner as usize]);
                }
            }
        }
    }
}

impl FacetContact {
    /// The contact for results.
    pub(crate) fn named(&self, other: GrainPartner) -> GrainContact {
        let Self { sphere, place, force, normal, overlap, .. } = *self;
        GrainContact { sphere, other, place, force, normal, overlap }
    }
}

impl SurfaceTotals {
    pub(crate) fn add(&mut self, other: &Self) {
        self.force = plus(self.force, other.force);
        self.moment = plus(self.moment, other.moment);
        self.elastic += other.elastic;
        self.dissipated += other.dissipated;
        self.against += other.against;
        self.work += other.work;
        self.answer.add(other.answer, 1.0);
    }
}

impl Minimum {
    fn overlap(&self, ball: &Ball, is_through: bool) -> f64 {
        if is_through { ball.radius + self.at.distance } else { ball.radius - self.at.distance }
    }
}

impl FacetScratch {
    /// Finds the history of each minimum, and hands springs over from contacts that have lost force to a pass
    /// to those that need not bear it any more. `passes`: force of the pass of each minimum, N.
    fn continue_histories(&mut self, histories: &mut [FacetHistory]) {
        self.match_minima(histories);
        let Self { partners, is_taken, passes, lost, .. } = self;
        // Histories without a minimum have lost all.
        lost.clear();
        lost.extend(histories.iter().zip(&*is_taken).map(|(of, taken)| if *taken { 0.0 } else { of.own }));
        let mut gained = 0.0;
        for (partner, pass) in partners.iter().zip(&*passes) {
            if let Some(k) = *partner {
                let old = &histories[k as usize];
                // A contact that sticks may pull.
                lost[k as usize] = (pass - old.pass).clamp(0.0, old.own.max(0.0));
                gained += (old.pass - pass).max(0.0);
            }
        }
        let total: f64 = lost.iter().sum();
        if total == 0.0 || gained == 0.0 {
            return;
        }
        let share = (gained / total).min(1.0);
        let mut pool = ContactHistory::default();
        for (of, lost) in histories.iter_mut().zip(&*lost) {
            if of.own > 0.0 {
                of.contact.hand_over(share * lost / of.own, &mut pool);
            }
        }
        for (partner, pass) in partners.iter().zip(&*passes) {
            if let Some(k) = *partner {
                let old = &mut histories[k as usize];
                old.contact.take_over((old.pass - pass).max(0.0) / gained, &pool);
            }
        }
    }

    /// Finds the history of each minimum: that with the closest direction.
    fn match_minima(&mut self, histories: &[FacetHistory]) {
        let Self { sheets, pairs, partners, is_taken, .. } = self;
        pairs.clear();
        for (i, minimum) in sheets.minima.iter().enumerate() {
            for (k, old) in histories.iter().enumerate() {
                let turned = minus(minimum.at.normal, old.normal);
                let square = dot(turned, turned);
                if square < TURN {
                    pairs.push((square, i as u32, k as u32));
                }
            }
        }
        pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        partners.clear();
        partners.resize(sheets.minima.len(), None);
        is_taken.clear();
        is_taken.resize(histories.len(), false);
        for &(_, i, k) in &*pairs {
            if partners[i as usize].is_none() && !is_taken[k as usize] {
                partners[i as usize] = Some(k);
                is_taken[k as usize] = true;
            }
        }
    }
}
