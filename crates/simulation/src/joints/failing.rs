//! Facets that fail: their traction has reached their strength.
//!
//! A facet is checked when the state of one of its elements has changed by so much since the last check that
//! it may fail now ([`Watch`](crate::solid::watch::Watch)). Elements are *awake* then. A check finds the
//! slack of the facet, the change of stress up to which it cannot fail. An element sleeps while its stress
//! has changed by less than half of the least slack of its facets, and of the tips at its vertices. The
//! stress of the element on the other side of a facet may change at the same time. If that one could change
//! by more than the slack before it wakes, it is woken for the next step.
//!
//! Facets with little slack are *restless*: they are checked in every step, and wake nothing.
//!
//! So the facets that fail, and when, do not depend on which elements sleep.

use crate::joints::Joints;
use crate::joints::check::CheckBatch;
use crate::joints::cut::InsertionData;
use crate::joints::plane::{breaks, mean_stress, plane_near, side};
use crate::joints::slack::{Checked, Limits, MOST_SQUEEZED};
use crate::lanes::LANES;
use crate::model::{Model, Strength};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::solid::batch::Deformed;
use crate::team::Team;
use crate::topology::{NONE, Topology};
use crate::vector::{contraction, product};

/// Why a facet is restless: for itself, or because a tip is that needs its check.
const ALONE: u8 = 1;
const AT_TIP: u8 = 2;

/// Number of steps after which restless tips look for their slack again, which takes longer than to see
/// whether they fail.
pub(super) const AGAIN: u64 = 64;

/// Share of its strength up to which the slack of a facet is taken for none.
const RESTLESS: f64 = 1.0 / 24.0;

/// The findings of a pass over facets or tips.
#[derive(Default)]
pub(super) struct CheckResult {
    /// Facets that fail.
    pub(super) failing: Vec<u32>,
    /// Elements that are to be awake in the next step.
    pub(super) wake: Vec<u32>,
    /// The slack of each tip that was looked at, by its vertex, Pa.
    pub(super) tips: Vec<(u32, f64)>,
}

/// The facets that fail, and the elements that were woken for the next step, both with repetitions.
#[derive(Default)]
pub(crate) struct FoundFacets {
    pub(crate) failing: Vec<u32>,
    pub(crate) woken: Vec<u32>,
}

/// Whether a facet or a tip with this slack, Pa, is checked in every step, because its elements would wake
/// for it in most steps. An element that wakes is checked with all of its facets and tips.
pub(super) fn is_restless(slack: f64, strength: &Strength) -> bool {
    let least = RESTLESS * strength.tensile.min(strength.cohesion);
    slack <= least || slack.is_nan()
}

/// The lower of two slacks. One that is not a number counts as none.
pub(super) fn lower(one: f64, other: f64) -> f64 {
    if other >= one { one } else { other }
}

impl<const D: usize> Joints<D> {
    /// Whether joints may be inserted during the run.
    pub(crate) fn inserts(&self) -> bool {
        !self.checked.is_empty()
    }

    /// Returns the facets, ascending, whose traction has reached their strength. `pressed`: the elements on
    /// which contacts and loads act in this step.
    pub(crate) fn failing<const N: usize>(
        &mut self,
        solid: &mut Solid<D, N>,
        pressed: Vec<u32>,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Vec<u32>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        solid.begin_watch();
        if !self.find_awake(solid, pressed, team) {
            return Vec::new();
        }
        let state = InsertionData { solid, model, topology };
        let (mut checked, mut restless) =
            (std::mem::take(&mut self.checked), std::mem::take(&mut self.restless));
        let mut found = team.change_both(&mut checked, &mut restless, |first, checked, restless| {
            self.check_facets(|place| (first + place) as u32, checked, restless, state)
        });
        (self.checked, self.restless) = (checked, restless);
        let mut tips = std::mem::take(&mut self.tips);
        let at_tips = team.change_lanes::<1, _, _>(&mut tips, |_, tips| self.check_tips(tips, state));
        self.tips = tips;
        found.extend(at_tips);
        let note = |joints: &Self, solid: &mut Solid<D, N>| joints.note_states(solid, topology, team);
        let FoundFacets { mut failing, .. } = self.take_found(found, solid, note);
        team.sort(&mut failing);
        failing.dedup();
        failing
    }

    /// Takes the findings of a check over. `note`: notes the states of the elements that are awake.
    pub(super) fn take_found<const N: usize>(
        &mut self,
        found: Vec<CheckResult>,
        solid: &mut Solid<D, N>,
        note: impl FnOnce(&Self, &mut Solid<D, N>),
    ) -> FoundFacets {
        self.mark_contenders();
        self.checks += 1;
        for &(vertex, slack) in found.iter().flat_map(|found| &found.tips) {
            self.tip_slack[vertex as usize] = slack;
        }
        note(self, solid);
        let mut all = FoundFacets::default();
        for CheckResult { failing, wake, .. } in found {
            all.failing.extend(failing);
            all.woken.extend(wake);
        }
        all.woken.iter().for_each(|&element| solid.wake(element));
        all
    }

    /// Finds the elements that are awake. Returns whether any is.
    fn find_awake<const N: usize>(&mut self, solid: &Solid<D, N>, pressed: Vec<u32>, team: &Team) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let restless = self.tips.iter().any(|tip| !tip.contenders.is_empty())
            || self.restless.iter().any(|&restless| restless > 0);
        let any = team.change_lanes::<1, _, _>(&mut self.awake, |first, awake| {
            let mut any = false;
            for (batch, awake) in (first / LANES..).zip(awake.chunks_mut(LANES)) {
                if !solid.any_awake(batch) {
                    awake.fill(false);
                    continue;
                }
                for (element, awake) in (batch * LANES..).zip(awake) {
                    *awake = solid.is_awake(element);
                    any |= *awake;
                }
            }
            any
        });
        // Forces of contacts and loads are not in the stress.
        for &element in pressed.iter().chain(&self.pressed) {
            self.awake[element as usize] = true;
        }
        let pressed_before = std::mem::replace(&mut self.pressed, pressed);
        restless || any.contains(&true) || !pressed_before.is_empty() || !self.pressed.is_empty()
    }

    pub(super) fn is_awake(&self, element: u32) -> bool {
        self.awake[element as usize]
    }

    fn any_awake(&self, elements: [u32; 2]) -> bool {
        elements.into_iter().any(|element| self.is_awake(element))
    }

    /// Whether a facet may still get a joint.
    fn may_fail(&self, facet: u32) -> bool {
        self.of_facet[facet as usize] == NONE && self.may_part(facet) && self.set(facet).is_none()
    }

    /// Checks the facets with an element that is awake, and the restless ones. `number`: the number of the
    /// facet at each place.
    pub(super) fn check_facets<const N: usize>(
        &self,
        number: impl Fn(usize) -> u32,
        checked: &mut [Checked],
        restless: &mut [u8],
        state: InsertionData<'_, D, N>,
    ) -> CheckResult
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let (mut batch, mut places) = (CheckBatch::EMPTY, Vec::new());
        for place in 0..checked.len() {
            let facet = number(place);
            let sides = &topology.facets[facet as usize];
            if restless[place] == 0 && !self.any_awake(sides.elements()) {
                continue;
            }
            if let Some(strength) = self.strength(facet).filter(|_| self.may_fail(facet)) {
                places.push((place, strength));
                batch.push(place, &strength, sides, solid, checked);
            } else {
                (checked[place], restless[place]) = (Checked::NEVER, 0);
            }
        }
        batch.write::<N>(solid.available, checked);
        let mut found = CheckResult::default();
        for (place, strength) in places {
            let (facet, checked) = (number(place), &checked[place]);
            let may_fail = checked.slack <= 0.0 || checked.slack.is_nan();
            if may_fail && self.fails(checked.used, checked, facet, state) {
                found.failing.push(facet);
            }
            if is_restless(checked.slack, &strength) {
                restless[place] |= ALONE;
                continue;
            }
            restless[place] &= !ALONE;
            let elements = topology.facets[facet as usize].elements().into_iter();
            found.wake.extend(elements.filter(|&element| self.is_to_wake(element, checked.slack, solid)));
        }
        found
    }

    /// Whether an element sleeps that may change by more than this slack, Pa, before it wakes.
    pub(super) fn is_to_wake<const N: usize>(&self, element: u32, slack: f64, solid: &Solid<D, N>) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        !self.is_awake(element) && (solid.room(element) > slack || slack.is_nan())
    }

    pub(super) fn limits(&self, facet: u32) -> Option<Limits> {
        self.strength(facet).and_then(|strength| Limits::of(&strength))
    }

    /// Whether a use of the strength of a facet breaks it or a plane near it. `checked`: the check by the
    /// mean stress of its two elements.
    pub(super) fn fails<const N: usize>(
        &self,
        used: f64,
        checked: &Checked,
        facet: u32,
        state: InsertionData<'_, D, N>,
    ) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let most = || match self.limits(facet) {
            Some(limits) => limits.most_used(checked) / checked.used,
            None => f64::INFINITY,
        };
        breaks(used, most, || self.excess(facet, state))
    }

    /// Use of the strength on a plane near a facet over that on the facet, at least 1.
    fn excess<const N: usize>(&self, facet: u32, state: InsertionData<'_, D, N>) -> f64
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let sides = &topology.facets[facet as usize];
        self.strength_of_planes(facet).map_or(1.0, |strength| {
            plane_near::<D, N>(&side(solid, sides), &mean_stress(solid, sides), &strength).excess
        })
    }

    /// Marks the facets that restless tips need.
    fn mark_contenders(&mut self) {
        if !self.checks.is_multiple_of(AGAIN) {
            return;
        }
        self.restless.iter_mut().for_each(|restless| *restless &= !AT_TIP);
        for facet in self.tips.iter().flat_map(|tip| &tip.contenders) {
            self.restless[*facet as usize] |= AT_TIP;
        }
    }

    /// Whether the check of a facet is of this step.
    pub(super) fn is_fresh(&self, facet: u32, elements: [u32; 2]) -> bool {
        self.restless[facet as usize] > 0 || self.any_awake(elements)
    }

    /// Notes the states of the elements that are awake: all of their facets and tips have been checked.
    fn note_states<const N: usize>(&self, solid: &mut Solid<D, N>, topology: &Topology<D, N>, team: &Team)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        solid.with_deformed(|solid, deformed| {
            team.change_lanes::<LANES, _, _>(deformed, |first, chunk| {
                for (batch, deformed) in (first..).zip(chunk) {
                    let numbers = batch * LANES..((batch + 1) * LANES).min(solid.element_count());
                    for number in numbers.filter(|&number| self.awake[number]) {
                        self.note_state(number, solid, deformed, topology);
                    }
                }
            });
        });
    }

    /// Notes the state of an element.
    pub(super) fn note_state<const N: usize>(
        &self,
        number: usize,
        solid: &Solid<D, N>,
        deformed: &mut Deformed<D>,
        topology: &Topology<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let facets = topology.facet_of[number].iter().filter(|&&facet| facet != NONE);
        let vertices = &topology.vertices[N * number..N * (number + 1)];
        let facets = facets.filter(|&&facet| self.restless[facet as usize] & ALONE == 0);
        let slacks = facets.map(|&facet| self.checked[facet as usize].slack);
        let at_tips = vertices.iter().map(|&vertex| self.tip_slack[vertex as usize]);
        let least = slacks.chain(at_tips).fold(f64::INFINITY, lower);
        let lane = number % LANES;
        let edges = <[[f64; D]; N]>::edges(&solid.shape(number as u32));
        let inverse = solid.inverse_edges(number);
        let gradient = product(&edges, &inverse);
        let cofactor = <[[f64; D]; N]>::cofactor(&gradient);
        let squeezed =
            contraction(&cofactor, &cofactor).sqrt() / <[[f64; D]; N]>::determinant(&gradient).abs();
        let reach = if least > 0.0 && squeezed < MOST_SQUEEZED { 0.5 * least } else { 0.0 };
        let stress = deformed.stress(lane);
        if let Some(watch) = &mut deformed.watch {
            watch.note(lane, &stress, &edges, &inverse, reach);
        }
    }
}
