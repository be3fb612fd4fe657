//! Uses of the strengths of facets, a batch of them side by side: see `lanes.rs`.

use crate::cohesive::{use_of, use_of_both};
use crate::joints::plane::{mean_stress, side, traction};
use crate::lanes::{
    Available, LANES, Lanes, Rows, Tensors, compiled_for_vectors, rows, set_rows, set_tensor, tensor,
};
use crate::model::Strength;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::Facet;
use crate::vector::{applied, dot, minus};

/// Facets whose uses are computed together.
pub(super) struct UseBatch<const D: usize> {
    /// Number of facets.
    count: usize,
    /// The place of each in a list.
    places: [usize; LANES],
    /// Present positions of their corners, m.
    corners: Rows<D, D>,
    /// Mean stresses of their two elements, Pa.
    stress: Tensors<D>,
    /// Strengths, Pa, and the tangent of the friction angle.
    tensile: Lanes,
    cohesion: Lanes,
    friction: Lanes,
    uses: Lanes,
}

impl<const D: usize> UseBatch<D> {
    pub(super) const EMPTY: Self = Self {
        count: 0,
        places: [0; LANES],
        corners: [[Lanes::ZERO; D]; D],
        stress: [[Lanes::ZERO; D]; D],
        tensile: Lanes::all(1.0),
        cohesion: Lanes::all(1.0),
        friction: Lanes::ZERO,
        uses: Lanes::ZERO,
    };

    /// Takes a facet with this strength. Computes the batch if it is full.
    pub(super) fn push<const N: usize>(
        &mut self,
        place: usize,
        strength: &Strength,
        facet: &Facet<D>,
        solid: &Solid<D, N>,
        uses: &mut [f64],
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        // A facet without one of its strengths has a use of infinity.
        if strength.tensile == 0.0 || strength.cohesion == 0.0 {
            uses[place] = use_of(strength, traction(solid, facet));
            return;
        }
        let lane = self.count;
        self.places[lane] = place;
        set_rows(&mut self.corners, lane, &side(solid, facet));
        set_tensor(&mut self.stress, lane, &mean_stress(solid, facet));
        self.tensile.set(lane, strength.tensile);
        self.cohesion.set(lane, strength.cohesion);
        self.friction.set(lane, strength.friction);
        self.count += 1;
        if self.count == LANES {
            self.write(solid.available, uses);
        }
    }

    /// Computes the uses of all facets that it holds, and writes each at its place.
    pub(super) fn write<const N: usize>(&mut self, available: Available, uses: &mut [f64])
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        uses_of::<D, N>(available, self);
        for lane in 0..self.count {
            uses[self.places[lane]] = self.uses.get(lane);
        }
        self.count = 0;
    }
}

/// The use of the strength of one facet: that of [`use_of`], without directions along the facet.
#[inline(always)]
fn use_one<const D: usize, const N: usize>(lane: usize, batch: &mut UseBatch<D>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let normal = <[[f64; D]; N]>::facet_normal(&rows(&batch.corners, lane));
    let (whole, squared) = (applied(&tensor(&batch.stress, lane), normal), dot(normal, normal));
    let across = dot(whole, normal) / squared;
    let along = minus(whole, normal.map(|x| across * x));
    let along = (dot(along, along) / squared).sqrt();
    let strengths = [batch.tensile.get(lane), batch.cohesion.get(lane)];
    batch.uses.set(lane, use_of_both(strengths, batch.friction.get(lane), [across, along]));
}

compiled_for_vectors!(fn uses_of = use_all<const D: usize, const N: usize>(batch: &mut UseBatch<D>) where [[f64; D]; N]: Simplex<D, N>);

#[inline(always)]
fn use_all<const D: usize, const N: usize>(batch: &mut UseBatch<D>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        use_one::<D, N>(lane, batch);
    }
}
