//! Elements that may touch: their connection, and their distance.

use crate::contacts::pair::{Couple, Overlap};
use crate::joints::{JointState, Joints};
use crate::lanes::larger;
use crate::simplex::{Simplex, apart, gap};
use crate::topology::{NONE, Topology};
use crate::vector::{Point, dot, length};

/// The part of the undeformed mesh that two elements share.
enum Relation {
    Apart,
    /// Vertices: the corners of each element at the first of them.
    Vertex([u32; 2]),
    /// A facet.
    Facet(u32),
}

fn relation<const D: usize, const N: usize>([a, b]: [u32; 2], topology: &Topology<D, N>) -> Relation {
    let facets = |element: u32| topology.facet_of[element as usize];
    if let Some(facet) = facets(a).into_iter().find(|&facet| facet != NONE && facets(b).contains(&facet)) {
        return Relation::Facet(facet);
    }
    let corners = |element: u32| N as u32 * element..N as u32 * (element + 1);
    for p in corners(a) {
        for q in corners(b) {
            if topology.vertices[p as usize] == topology.vertices[q as usize] {
                return Relation::Vertex([p, q]);
            }
        }
    }
    Relation::Apart
}

/// A new couple of two elements, with the joint between them or [`NONE`]; `None` if they cannot touch in the
/// present state of the joints. `parted`: whether they have separated in the last step.
pub(super) fn couple<const D: usize, const N: usize>(
    elements: [u32; 2],
    parted: bool,
    groups: &[u32],
    joints: &Joints<D>,
    topology: &Topology<D, N>,
) -> Option<Couple<u32>> {
    let overlap = |credited: bool| if credited { Overlap::Credited } else { Overlap::Counts };
    match relation(elements, topology) {
        Relation::Apart => Some(Couple::new(elements, NONE, Overlap::Counts)),
        Relation::Facet(facet) => {
            let joint = joints.of_facet[facet as usize];
            let broken =
                joints.all.get(joint as usize).is_some_and(|joint| joint.state != JointState::Holding);
            let left = || joints.all[joint as usize].detached != [false; D];
            broken.then(|| Couple::new(elements, joint, overlap(parted && left())))
        }
        Relation::Vertex([a, b]) => {
            let connected = groups[a as usize] == groups[b as usize];
            (!connected).then(|| Couple::new(elements, NONE, overlap(parted)))
        }
    }
}

/// A lower bound of the distance of two elements, m; `None` if no facet parts them: they overlap, or are near
/// each other. The bound need not be sharp beyond `most`.
pub(super) fn distance<const D: usize, const N: usize>(
    a: &[Point<D>; N],
    b: &[Point<D>; N],
    most: f64,
) -> Option<f64>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let bound = larger(gap(a, b), gap_between_middles(a, b));
    if bound > most {
        return Some(bound);
    }
    let apart = apart(a, b);
    if apart < 0.0 {
        return None;
    }
    let bound = larger(bound, apart);
    Some(if bound > most { bound } else { a.distance(b, bound) })
}

/// Gap, m, between two elements along the line between their centroids; negative if there is none.
#[inline]
fn gap_between_middles<const D: usize, const N: usize>(a: &[Point<D>; N], b: &[Point<D>; N]) -> f64 {
    let line: Point<D> = std::array::from_fn(|axis| {
        b.iter().map(|corner| corner[axis]).sum::<f64>() - a.iter().map(|corner| corner[axis]).sum::<f64>()
    });
    let least = b.iter().map(|corner| dot(*corner, line)).fold(f64::INFINITY, f64::min);
    let most = a.iter().map(|corner| dot(*corner, line)).fold(f64::NEG_INFINITY, f64::max);
    (least - most) / length(line)
}
