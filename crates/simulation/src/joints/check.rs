//! Checks of facets, a batch of them side by side: see `lanes.rs`.

use crate::cohesive::{use_of, use_of_both};
use crate::joints::plane::{mean_stress, side, traction};
use crate::joints::slack::{Checked, Limits, flatness};
use crate::lanes::{
    Available, LANES, Lanes, Rows, Tensors, compiled_for_vectors, rows, set_rows, set_tensor, tensor,
};
use crate::model::Strength;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::Facet;
use crate::vector::{applied, contraction, dot, minus};

/// Facets that are checked together.
pub(super) struct CheckBatch<const D: usize> {
    /// Number of facets.
    count: usize,
    /// The place of each in a list.
    places: [usize; LANES],
    /// Present positions of their corners, m.
    corners: Rows<D, D>,
    /// Mean stresses of their two elements, Pa.
    stress: Tensors<D>,
    /// Tensile strength and cohesion, Pa, the tangent of the friction angle, and [`flatness`].
    strengths: [Lanes; 4],
    uses: Lanes,
    traction: [Lanes; 2],
    circle: [Lanes; 2],
    slack: Lanes,
}

impl<const D: usize> CheckBatch<D> {
    pub(super) const EMPTY: Self = Self {
        count: 0,
        places: [0; LANES],
        corners: [[Lanes::ZERO; D]; D],
        stress: [[Lanes::ZERO; D]; D],
        strengths: [Lanes::all(1.0), Lanes::all(1.0), Lanes::ZERO, Lanes::ZERO],
        uses: Lanes::ZERO,
        traction: [Lanes::ZERO; 2],
        circle: [Lanes::ZERO; 2],
        slack: Lanes::ZERO,
    };

    /// Takes a facet with this strength. Computes the batch if it is full.
    pub(super) fn push<const N: usize>(
        &mut self,
        place: usize,
        strength: &Strength,
        facet: &Facet<D>,
        solid: &Solid<D, N>,
        checked: &mut [Checked],
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        // A facet without one of its strengths has a use of infinity, and no slack.
        if strength.tensile == 0.0 || strength.cohesion == 0.0 {
            let used = use_of(strength, traction(solid, facet));
            checked[place] = Checked { used, slack: 0.0, ..Checked::NEVER };
            return;
        }
        let lane = self.count;
        self.places[lane] = place;
        set_rows(&mut self.corners, lane, &side(solid, facet));
        set_tensor(&mut self.stress, lane, &mean_stress(solid, facet));
        let Strength { tensile, cohesion, friction, .. } = *strength;
        let numbers = [tensile, cohesion, friction, flatness(strength)];
        for (lanes, number) in self.strengths.iter_mut().zip(numbers) {
            lanes.set(lane, number);
        }
        self.count += 1;
        if self.count == LANES {
            self.write(solid.available, checked);
        }
    }

    /// Checks all facets that it holds, and writes each result at its place.
    pub(super) fn write<const N: usize>(&mut self, available: Available, checked: &mut [Checked])
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if self.count > 0 {
            checks_of::<D, N>(available, self);
        }
        for lane in 0..self.count {
            checked[self.places[lane]] = Checked {
                used: self.uses.get(lane),
                traction: self.traction.each_ref().map(|lanes| lanes.get(lane)),
                circle: self.circle.each_ref().map(|lanes| lanes.get(lane)),
                slack: self.slack.get(lane),
            };
        }
        self.count = 0;
    }
}

/// Checks one facet. The use is that of [`use_of`], without directions along the facet.
#[inline(always)]
fn check_one<const D: usize, const N: usize>(lane: usize, batch: &mut CheckBatch<D>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (normal, stress) =
        (<[[f64; D]; N]>::facet_normal(&rows(&batch.corners, lane)), tensor(&batch.stress, lane));
    let (whole, squared) = (applied(&stress, normal), dot(normal, normal));
    let across = dot(whole, normal) / squared;
    let along = minus(whole, normal.map(|x| across * x));
    let along = (dot(along, along) / squared).sqrt();
    let [tensile, cohesion, friction, flatness] = batch.strengths.each_ref().map(|lanes| lanes.get(lane));
    batch.uses.set(lane, use_of_both([tensile, cohesion], friction, [across, along]));
    let circle = <[[f64; D]; N]>::circle_close(&stress);
    let limits = Limits::new([tensile, cohesion, friction, flatness]);
    batch.slack.set(lane, limits.slack([across, along], circle, contraction(&stress, &stress).sqrt()));
    for k in 0..2 {
        batch.traction[k].set(lane, [across, along][k]);
        batch.circle[k].set(lane, circle[k]);
    }
}

compiled_for_vectors!(fn checks_of = check_all<const D: usize, const N: usize>(batch: &mut CheckBatch<D>) where [[f64; D]; N]: Simplex<D, N>);

#[inline(always)]
fn check_all<const D: usize, const N: usize>(batch: &mut CheckBatch<D>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        check_one::<D, N>(lane, batch);
    }
}
