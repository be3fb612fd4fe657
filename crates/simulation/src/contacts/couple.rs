//! Couples of elements that may touch, and when they cannot.

use crate::joints::{JointState, Joints};
use crate::lanes::larger;
use crate::simplex::{Simplex, apart, gap};
use crate::solid::Solid;
use crate::topology::{NONE, Topology};
use crate::vector::{Point, dot, length};

/// Number of couples between one whose forces are computed and the one whose nodes are prefetched; twice as
/// far ahead, the numbers of the nodes are.
pub(super) const AHEAD: usize = 6;

/// Two elements that may touch.
#[derive(Clone, Debug)]
pub(crate) struct Couple {
    pub(super) elements: [u32; 2],
    /// The joint between the two, or [`NONE`].
    pub(super) joint: u32,
    /// Whether the two may overlap already, because they have separated now or become bare now. Cleared when
    /// their forces are computed for the first time.
    pub(super) initial_overlap: bool,
    /// Whether the two overlap. Then they have a history, at this place in the [`Histories`] of their chunk.
    pub(super) touches: bool,
    pub(super) slot: u16,
    /// The two cannot touch before nodes have travelled this distance since the beginning, m.
    pub(super) apart_until: f64,
}

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

/// A couple of two elements that were never connected.
pub(super) fn separate(elements: [u32; 2]) -> Couple {
    Couple { elements, joint: NONE, initial_overlap: false, touches: false, slot: 0, apart_until: 0.0 }
}

/// A new couple of two elements; `None` if they cannot touch in the present state of the joints. `parted`:
/// whether they have separated in the last step.
pub(super) fn couple<const D: usize, const N: usize>(
    elements: [u32; 2],
    parted: bool,
    groups: &[u32],
    joints: &Joints<D>,
    topology: &Topology<D, N>,
) -> Option<Couple> {
    let couple = separate(elements);
    match relation(elements, topology) {
        Relation::Apart => Some(couple),
        Relation::Facet(facet) => {
            let joint = joints.of_facet[facet as usize];
            let broken =
                joints.all.get(joint as usize).is_some_and(|joint| joint.state != JointState::Holding);
            let left = || joints.all[joint as usize].detached != [false; D];
            broken.then(|| Couple { joint, initial_overlap: parted && left(), ..couple })
        }
        Relation::Vertex([a, b]) => {
            let connected = groups[a as usize] == groups[b as usize];
            (!connected).then_some(Couple { initial_overlap: parted, ..couple })
        }
    }
}

/// The couple, if its elements are not farther apart than this, m. A couple with a joint stays: the joint
/// says when its contact begins.
pub(super) fn near<const D: usize, const N: usize>(
    couple: Couple,
    solid: &Solid<D, N>,
    travel: f64,
    most: f64,
) -> Option<Couple>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    if couple.joint != NONE {
        return Some(couple);
    }
    let [a, b] = couple.elements.map(|element| solid.shape(element));
    let Some(distance) = distance(&a, &b, most) else { return Some(couple) };
    let apart_until = skipped_until(travel, distance);
    (distance <= most).then_some(Couple { initial_overlap: false, apart_until, ..couple })
}

/// The distance, m, that nodes may travel before two elements can touch that are this far apart.
pub(super) fn skipped_until(travel: f64, distance: f64) -> f64 {
    // Both elements may move, each by half of the distance. The factor is slightly below 0.5 because `travel`
    // is rounded.
    travel + 0.499 * distance
}

/// A lower bound of the distance of two elements, m; `None` if no facet parts them: they overlap, or are near
/// each other. The bound need not be sharp beyond `most`.
fn distance<const D: usize, const N: usize>(a: &[Point<D>; N], b: &[Point<D>; N], most: f64) -> Option<f64>
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
