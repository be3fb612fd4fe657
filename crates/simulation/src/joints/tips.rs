//! Facets that fail at a tip. A tip is a vertex on a free surface or at a crack, where the traction at the
//! node is higher than in the elements around it.
//!
//! A check of a tip finds its slack, as that of a facet does (`joints/failing.rs`). A tip with little slack,
//! or where joints act, whose forces are not in the stress, is *restless*: it is checked in every step. Such
//! a check looks at the *contenders* only, the few facets that may decide. The slack until another facet may
//! is that of the elements around the tip.

use crate::cohesive::use_of;
use crate::joints::check::CheckBatch;
use crate::joints::cut::{Cut, InsertionData};
use crate::joints::failing::{AGAIN, CheckResult, is_restless, lower};
use crate::joints::fan::Fan;
use crate::joints::slack::{Checked, Held, Limits, SUSPECT};
use crate::joints::{Joints, Tip};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::NONE;
use crate::vector::{Point, dot};

/// The facets at a tip that a check looks at, and memory to use again.
struct Near<const D: usize> {
    /// Each facet, and whether it connects elements at the vertex alone.
    facets: Vec<(u32, bool)>,
    checked: Vec<Checked>,
    batch: CheckBatch<D>,
}

impl<const D: usize> Near<D> {
    /// The facets that connect elements alone, or those that do only together with others.
    fn of_kind(&self, kind: bool) -> impl Iterator<Item = (u32, &Checked)> {
        let all = self.facets.iter().zip(&self.checked);
        all.filter(move |((_, alone), _)| *alone == kind).map(|((facet, _), checked)| (*facet, checked))
    }
}

/// Slacks of a tip, Pa.
struct TipSlack {
    /// Until a facet fails that decides now.
    fails: f64,
    /// Until each facet decides; `None` for those that do now.
    decides: Vec<(u32, Option<f64>)>,
}

impl<const D: usize> Joints<D> {
    /// Checks the tips with an element that is awake, and the restless ones.
    pub(super) fn check_tips<const N: usize>(
        &self,
        tips: &mut [Tip<D>],
        state: InsertionData<'_, D, N>,
    ) -> CheckResult
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let mut found = CheckResult::default();
        let mut near = Near { facets: Vec::new(), checked: Vec::new(), batch: CheckBatch::EMPTY };
        for tip in tips {
            let corners = topology.corners_of(tip.vertex);
            let elements = || corners.iter().map(|corner| corner / N as u32);
            let awake = elements().any(|element| self.is_awake(element));
            if tip.contenders.is_empty() && !awake {
                continue;
            }
            // The force that moves a held node is unknown here. There the mean traction of the elements
            // decides.
            if solid.hold_at(corners[0]) != NONE {
                found.tips.push((tip.vertex, f64::INFINITY));
                continue;
            }
            let all = awake || self.checks.is_multiple_of(AGAIN);
            self.find_near(tip, all, &mut near, state);
            let slack = self.check_tip(tip, &near, all, state, &mut found.failing);
            if all {
                let slack = self.settle(tip, &slack);
                found.tips.push((tip.vertex, slack));
                found.wake.extend(elements().filter(|&element| self.is_to_wake(element, slack, solid)));
            }
        }
        found
    }

    /// Finds the contenders of a tip; none if it has slack. Returns the slack for the elements around it.
    fn settle(&self, tip: &mut Tip<D>, slack: &TipSlack) -> f64 {
        let strength = tip.facets().next().and_then(|facet| self.strength(facet));
        let is_low = |slack: f64| strength.is_none_or(|strength| is_restless(slack, &strength));
        let others = || slack.decides.iter().filter_map(|(_, slack)| *slack);
        tip.contenders.clear();
        if !is_low(slack.fails) && !others().any(is_low) {
            return others().fold(slack.fails, lower);
        }
        let contends = |(_, slack): &&(u32, Option<f64>)| slack.is_none_or(is_low);
        tip.contenders.extend(slack.decides.iter().filter(contends).map(|(facet, _)| facet));
        others().filter(|&slack| !is_low(slack)).fold(f64::INFINITY, lower)
    }

    /// The checks of all facets at a tip, or of the contenders.
    fn find_near<const N: usize>(
        &self,
        tip: &Tip<D>,
        all: bool,
        near: &mut Near<D>,
        state: InsertionData<'_, D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let Near { facets, checked, batch } = near;
        facets.clear();
        if all {
            facets.extend(tip.alone.iter().map(|&facet| (facet, true)));
            facets.extend(tip.together.iter().map(|&facet| (facet, false)));
        } else {
            facets.extend(tip.contenders.iter().map(|&facet| (facet, tip.alone.contains(&facet))));
        }
        checked.clear();
        checked.extend(facets.iter().map(|(facet, _)| self.checked[*facet as usize]));
        for (place, &(facet, _)) in facets.iter().enumerate() {
            let sides = &topology.facets[facet as usize];
            if self.is_fresh(facet, sides.elements()) {
                continue;
            }
            if let Some(strength) = self.strength(facet) {
                batch.push(place, &strength, sides, solid, checked);
            }
        }
        batch.write::<N>(solid.available, checked);
    }

    /// Adds the failing facets at a tip: those where the traction that holds their two sides together at the
    /// vertex reaches the strength. `all`: whether `near` has all facets there; else the slack means nothing.
    fn check_tip<const N: usize>(
        &self,
        tip: &mut Tip<D>,
        near: &Near<D>,
        all: bool,
        state: InsertionData<'_, D, N>,
        failing: &mut Vec<u32>,
    ) -> TipSlack
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let vertex = tip.vertex;
        let steady = all && self.is_steady(state.topology.corners_of(vertex));
        let mut slack = TipSlack { fails: f64::INFINITY, decides: Vec::new() };
        for (facet, checked) in near.of_kind(true) {
            if checked.used < SUSPECT {
                if all {
                    slack.decides.push((facet, Some(self.until_suspect(facet, checked))));
                }
                continue;
            }
            let cut =
                tip.cut(facet, state, || Some(Fan::new(vertex, &[facet], self, state).cut(facet, &[facet])));
            let fails = cut.map(|cut| self.check_along(cut, vertex, checked, steady, state, failing));
            slack.fails = lower(slack.fails, fails.unwrap_or(f64::INFINITY));
            slack.decides.push((facet, None));
        }
        let together = || near.of_kind(false);
        let suspect = together().filter(|(_, checked)| checked.used >= SUSPECT);
        let most = suspect.reduce(|most, next| if next.1.used > most.1.used { next } else { most });
        if let Some((facet, checked)) = most {
            let cut = tip.cut(facet, state, || Fan::new(vertex, &[], self, state).cut_along(facet));
            let fails = cut.map(|cut| self.check_along(cut, vertex, checked, steady, state, failing));
            slack.fails = lower(slack.fails, fails.unwrap_or(f64::INFINITY));
        }
        if all {
            slack.decides.extend(together().map(|(facet, checked)| match most {
                Some((own, _)) if own == facet => (facet, None),
                Some(most) => (facet, Some(self.until_overtaken(most, (facet, checked)))),
                None => (facet, Some(self.until_suspect(facet, checked))),
            }));
        }
        slack
    }

    /// Whether no joint acts on these corners.
    fn is_steady(&self, corners: &[u32]) -> bool {
        corners.iter().all(|&corner| self.at_corner[corner as usize] == [NONE; D])
    }

    /// The slack until the use of a facet reaches [`SUSPECT`], Pa.
    fn until_suspect(&self, facet: u32, checked: &Checked) -> f64 {
        self.limits(facet).map_or(0.0, |limits| checked.until_suspect(&limits))
    }

    /// The slack until the second facet is used more than the first, Pa.
    fn until_overtaken(&self, first: (u32, &Checked), second: (u32, &Checked)) -> f64 {
        match [first.0, second.0].map(|facet| self.limits(facet)) {
            [Some(one), Some(other)] => first.1.until_overtaken(&one, second.1, &other),
            _ => 0.0,
        }
    }

    /// Force of elements, contacts and joints on a corner, N.
    pub(super) fn force_on<const N: usize>(&self, corner: u32, solid: &Solid<D, N>) -> Point<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut total = solid.force(corner);
        self.add_force(corner, &mut total);
        total
    }

    /// Adds the facets of a cut to those that fail if the traction at the vertex does that holds its two
    /// sides together. `checked`: the check of the facet that gives its plane. Returns the slack, Pa, if it
    /// is asked for, or 0.
    fn check_along<const N: usize>(
        &self,
        cut: &Cut<D>,
        vertex: u32,
        checked: &Checked,
        with_slack: bool,
        state: InsertionData<'_, D, N>,
        failing: &mut Vec<u32>,
    ) -> f64
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let pull = cut.held(vertex, |corner| self.force_on(corner, state.solid), state);
        let traction = pull.axes.map(|axis| dot(pull.traction, axis));
        let Some(strength) = self.strength(cut.facet) else { return 0.0 };
        let used = use_of(&strength, traction);
        if self.fails(used, checked, cut.facet, state) {
            failing.extend(&cut.facets);
            return 0.0;
        }
        let Some(limits) = Limits::of(&strength).filter(|_| with_slack) else { return 0.0 };
        let along = <[[f64; D]; N]>::sliding(&traction).abs();
        let [follows, turned] = cut.sensitivity(vertex, &pull, state);
        Held { used, traction: [traction[0], along], follows, turned }.slack(checked, &limits)
    }
}
