//! Checks of facets where a device finds the elements that are awake (`joints/failing.rs`): lists in place of
//! passes over all facets, so that the host reads the values of few elements, and none in most steps.

use crate::joints::Joints;
use crate::joints::cut::InsertionData;
use crate::joints::failing::{AGAIN, FoundFacets};
use crate::joints::slack::Checked;
use crate::lanes::LANES;
use crate::lists::once_each;
use crate::model::Model;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::team::Team;
use crate::topology::{NONE, Topology};

/// The elements that were awake in the last check, and the restless facets, ascending.
#[derive(Debug, Default)]
pub(crate) struct CheckLists {
    awake: Vec<u32>,
    restless: Vec<u32>,
}

/// The elements and facets of a check, ascending.
#[derive(Debug)]
pub(crate) struct Due {
    /// Elements that are awake.
    awake: Vec<u32>,
    facets: Vec<u32>,
    /// Elements whose values the check reads.
    pub(crate) around: Vec<u32>,
}

impl<const D: usize> Joints<D> {
    /// Begins to list the elements and facets to check.
    pub(crate) fn begin_lists(&mut self) -> CheckLists {
        self.awake.fill(false);
        let all = (0..).zip(&self.restless).filter(|(_, restless)| **restless > 0);
        CheckLists { awake: Vec::new(), restless: all.map(|(facet, _)| facet).collect() }
    }

    /// The elements and facets to check in this step, if there are any. `awake`: the elements that a device
    /// has found; `pressed`: those on which contacts and loads act.
    pub(crate) fn due<const N: usize>(
        &mut self,
        lists: &mut CheckLists,
        mut awake: Vec<u32>,
        pressed: Vec<u32>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Option<Due>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        awake.extend(pressed.iter().chain(&self.pressed));
        self.pressed = pressed;
        once_each(&mut awake);
        for element in lists.awake.drain(..) {
            self.awake[element as usize] = false;
        }
        let contends = self.tips.iter().any(|tip| !tip.contenders.is_empty());
        if awake.is_empty() && lists.restless.is_empty() && !contends {
            return None;
        }
        for &element in &awake {
            self.awake[element as usize] = true;
        }
        lists.awake.clone_from(&awake);
        let of_awake = awake.iter().flat_map(|&element| topology.facet_of[element as usize]);
        let mut facets: Vec<u32> =
            of_awake.filter(|&facet| facet != NONE).chain(lists.restless.drain(..)).collect();
        once_each(&mut facets);
        let mut around = awake.clone();
        around.extend(facets.iter().flat_map(|&facet| topology.facets[facet as usize].elements()));
        let elements = |vertex: u32| topology.corners_of(vertex).iter().map(|corner| corner / N as u32);
        around.extend(team.list(self.tips.len(), |range| {
            let tips = self.tips[range].iter();
            let due = tips.filter(|tip| {
                !tip.contenders.is_empty() || elements(tip.vertex).any(|element| self.is_awake(element))
            });
            due.flat_map(|tip| elements(tip.vertex)).collect()
        }));
        once_each(&mut around);
        Some(Due { awake, facets, around })
    }

    /// Checks these facets, and the tips at the elements that are awake. Returns the facets that fail,
    /// ascending, as [`Joints::failing`] does, and the elements whose noted states have changed.
    pub(crate) fn failing_among<const N: usize>(
        &mut self,
        due: Due,
        lists: &mut CheckLists,
        solid: &mut Solid<D, N>,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> [Vec<u32>; 2]
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Due { awake, facets, .. } = due;
        let state = InsertionData { solid, model, topology };
        let pieces = team.look(facets.len(), |range| {
            let here = &facets[range];
            let mut checked: Vec<Checked> = here.iter().map(|&facet| self.checked[facet as usize]).collect();
            let mut restless: Vec<u8> = here.iter().map(|&facet| self.restless[facet as usize]).collect();
            let found = self.check_facets(|place| here[place], &mut checked, &mut restless, state);
            (checked, restless, found)
        });
        let (mut found, mut next) = (Vec::new(), facets.iter());
        for (checked, restless, here) in pieces {
            for (of_facet, facet) in checked.into_iter().zip(restless).zip(next.by_ref()) {
                (self.checked[*facet as usize], self.restless[*facet as usize]) = of_facet;
            }
            found.push(here);
        }
        let mut tips = std::mem::take(&mut self.tips);
        found.extend(team.change_lanes::<1, _, _>(&mut tips, |_, tips| self.check_tips(tips, state)));
        self.tips = tips;
        let marks = self.checks.is_multiple_of(AGAIN);
        let FoundFacets { mut failing, woken } = self.take_found(found, solid, |joints, solid| {
            solid.with_deformed(|solid, deformed| {
                for &element in &awake {
                    let element = element as usize;
                    joints.note_state(element, solid, &mut deformed[element / LANES], topology);
                }
            });
        });
        lists.restless.extend(facets.iter().filter(|&&facet| self.restless[facet as usize] > 0));
        if marks {
            lists.restless.extend(self.tips.iter().flat_map(|tip| &tip.contenders));
            once_each(&mut lists.restless);
        }
        once_each(&mut failing);
        let mut noted = awake;
        noted.extend(woken);
        once_each(&mut noted);
        [failing, noted]
    }
}
