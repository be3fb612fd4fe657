//! The interactions of couples of elements: forces and energies of the potentials of both.
//!
//! The energy of a potential follows from the flux of a field that is singular in the centroid of its
//! element, out of the facets of the other element (`triangle/potential.rs`, `tetrahedron/potential.rs`).
//! Where a facet passes near the centroid, this flux is nearly 0/0: its error is rounding over the distance.
//! So the other element is moved aside, along the normal of the facet, to both sides, where the flux is well
//! known, and the mean of the two energies is taken. Its gradient is continuous, so the error of the mean
//! goes with the square of that way. A field that is not singular would not vanish on the boundary. Where
//! facets of both elements lie in one plane, as at the sides of blocks that stand on each other, rounding
//! would then decide whether this plane counts once, twice or not at all. Twin:
//! `crates/gpu/kernels/contact.h`.

use crate::lanes::{Available, LANES, Lanes, rows, set_rows};
use crate::simplex::{Interactions, Shapes, Simplex};
use crate::vector::{Point, add, dot, length, minus, unit};

#[cfg(test)]
use crate::lanes::row;
#[cfg(test)]
use crate::simplex::apart;

/// By which share of the distance of the boundary the other element is moved.
const ASIDE: f64 = 3e-5;

/// Computes the interactions of couples of elements in batches, for a penalty of 1 and a thickness of 1.
pub(crate) fn interactions<const D: usize, const N: usize>(
    available: Available,
    shapes: &[Shapes<D, N>],
    scratch: &mut <[[f64; D]; N] as Simplex<D, N>>::Scratch,
    found: &mut [Interactions<D, N>],
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    <[[f64; D]; N]>::usual_interactions(available, shapes, scratch, found);
    for (shapes, found) in shapes.iter().zip(found) {
        add_energies(available, shapes, scratch, found);
    }
}

/// Adds the energies that are missing in a batch, and the forces that follow from them.
fn add_energies<const D: usize, const N: usize>(
    available: Available,
    shapes: &Shapes<D, N>,
    scratch: &mut <[[f64; D]; N] as Simplex<D, N>>::Scratch,
    found: &mut Interactions<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    for side in 0..2 {
        for lane in 0..LANES {
            let facets = found.passing[side].get(lane) as u32;
            if facets != 0 {
                let [own, other] = [side, 1 - side].map(|of| rows::<D, N>(&shapes[of], lane));
                let energy = energy_of(available, side, &own, &other, facets, scratch);
                let inverse = <[[f64; D]; N]>::inverse_edges(&own);
                let gradients = std::array::from_fn(|corner| {
                    std::array::from_fn(|axis| match corner {
                        0 => -inverse.iter().map(|row| row[axis]).sum::<f64>(),
                        _ => inverse[corner - 1][axis],
                    })
                });
                found.set_energy(lane, side, &gradients, energy);
            }
        }
    }
}

/// The energy of the potential of an element, which is on this side of its couple. `facets`: those of the
/// other one that pass near its centroid, as bits.
fn energy_of<const D: usize, const N: usize>(
    available: Available,
    side: usize,
    own: &[Point<D>; N],
    other: &[Point<D>; N],
    facets: u32,
    scratch: &mut <[[f64; D]; N] as Simplex<D, N>>::Scratch,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let normals = (0..N).filter(|facet| facets >> facet & 1 == 1).map(|facet| {
        let corners = <[[f64; D]; N]>::FACETS[facet].map(|corner| other[corner]);
        unit(<[[f64; D]; N]>::facet_normal(&corners))
    });
    // Away from all of them, where several meet near the centroid.
    let mut normal = [0.0; D];
    for one in normals {
        let opposite = length(normal) > 0.0 && dot(normal, one) < -0.99 * length(normal);
        add(&mut normal, one, if opposite { 0.0 } else { 1.0 });
    }
    let normal = unit(normal);
    let mut centroid = [0.0; D];
    for &corner in own {
        add(&mut centroid, corner, 1.0 / N as f64);
    }
    let far = own.iter().map(|&corner| dot(minus(corner, centroid), normal).abs()).fold(0.0, f64::max);
    let (mut aside, mut found) = (ASIDE, Interactions::NONE);
    loop {
        let mut shapes = [[[Lanes::ZERO; D]; N]; 2];
        for lane in 0..2 {
            let way = aside * far * [1.0, -1.0][lane];
            let moved = other.map(|corner| std::array::from_fn(|axis| corner[axis] + way * normal[axis]));
            set_rows(&mut shapes[side], lane, own);
            set_rows(&mut shapes[1 - side], lane, &moved);
        }
        let (shapes, beside) = (std::slice::from_ref(&shapes), std::slice::from_mut(&mut found));
        <[[f64; D]; N]>::usual_interactions(available, shapes, scratch, beside);
        // Another facet may pass near the centroid there.
        if [0, 1].iter().all(|&lane| found.passing[side].get(lane) == 0.0) || aside > 0.1 {
            return 0.5 * (found.energies[side].get(0) + found.energies[side].get(1));
        }
        aside *= 2.0;
    }
}

/// Forces and energy of two elements that overlap.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interaction<const D: usize = 2, const N: usize = 3> {
    pub(crate) forces: [[Point<D>; N]; 2],
    pub(crate) energy: f64,
    pub(crate) point: Point<D>,
    pub(crate) deep: bool,
}

/// The interaction of two elements; if they do not overlap, a lower bound of their distance.
#[cfg(test)]
pub(crate) fn interaction<const D: usize, const N: usize>(
    a: &[Point<D>; N],
    b: &[Point<D>; N],
) -> Result<Interaction<D, N>, f64>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let apart = apart(a, b);
    if apart >= 0.0 {
        return Err(apart);
    }
    let mut shapes = [[[Lanes::ZERO; D]; N]; 2];
    for (of, shape) in shapes.iter_mut().zip([a, b]) {
        for lane in 0..LANES {
            set_rows(of, lane, shape);
        }
    }
    let mut found = [Interactions::NONE];
    interactions(Available::best(), &[shapes], &mut Default::default(), &mut found);
    let energy = found[0].energy(0);
    if energy <= 0.0 {
        return Err(a.distance(b, 0.0));
    }
    Ok(Interaction {
        forces: [0, 1].map(|side| rows(&found[0].forces[side], 0)),
        energy,
        point: row(&found[0].point, 0),
        deep: found[0].deep.get(0) > 0.0,
    })
}
