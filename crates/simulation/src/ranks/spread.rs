//! Division of a run among ranks: nodes go to ranks along Hilbert's curve, and each rank gets the elements
//! that act on its nodes, and those near them.

use std::collections::{BTreeMap, BTreeSet};

use fdem_contact::{Couple, Detector, Elements as Boxes, Search};
use fdem_distributed::curve::{Curve, owner, splitters};
use fdem_distributed::wire::{Wire, bytes_of, value_of};
use fdem_distributed::{Communicator, Message};

use crate::actions::seams;
use crate::lists::once_each;
use crate::ranks::links::{Links, Neighbour};
use crate::ranks::piece::{CommonData, ElementPiece, Lookup, RunPieces};
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::vector::Point;

/// Distance over the mean edge up to which a rank knows the elements near its own. They are looked for again
/// when nodes may have travelled half of it.
const REACH: f64 = 0.5;

/// Number of boxes with which a rank describes the places of its elements.
const BOXES: usize = 128;

/// Elements that a rank sends at a time.
const ROUND: usize = 1 << 15;

/// Share by which the busiest rank may have more than the mean before nodes are divided again.
const IMBALANCE: f64 = 0.1;

/// Weights of an element and of a joint: about the time that each takes. A couple that touches has a weight
/// in the same unit, `COST`.
const WEIGHTS: [u64; 2] = [12, 6];

/// The division of space among the ranks.
#[derive(Clone, Debug)]
pub(super) struct Division<const D: usize> {
    curve: Curve<D>,
    splitters: Vec<u64>,
}

/// The distance up to which a rank knows the elements near its own, m.
pub(super) fn reach<const D: usize, const N: usize>(frame: &CommonData<D, N>, stressed: bool) -> f64 {
    let reach = REACH * frame.edge;
    // Points of a seam act until they are this far apart.
    if stressed { reach.max(seams::FADE[1] * frame.longest) } else { reach }
}

/// Corners of a vertex that belong together: they have one owner.
pub(super) struct CornerUnit {
    pub(super) corners: Vec<u32>,
    pub(super) key: u64,
    pub(super) weight: u64,
}

/// The corners that this rank owns, in units: elements at a vertex between which a joint may still act.
pub(super) fn units<const D: usize, const N: usize>(
    run: &Simulation<D, N>,
    curve: &Curve<D>,
) -> Vec<CornerUnit>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (topology, share) = (&run.topology, run.solid().share());
    let mut weights = vec![WEIGHTS[0]; run.solid().element_count()];
    for joint in &run.joints().all {
        for element in topology.facets[joint.facet as usize].elements() {
            weights[element as usize] += WEIGHTS[1] / 2;
        }
    }
    for (elements, cost) in run.contacts().costs() {
        for element in elements {
            weights[element as usize] += cost / 2;
        }
    }
    let mut units = Vec::new();
    let mut groups = Vec::new();
    for vertex in 0..topology.vertex_count() as u32 {
        let corners = topology.corners_of(vertex);
        if !corners.iter().any(|&corner| share.corner(corner)) {
            continue;
        }
        topology.groups(vertex, |facet| run.joints().acts(facet), &mut groups);
        let (corners, groups) = share.owned(corners, &groups);
        for leader in (0..corners.len()).filter(|&place| groups[place] as usize == place) {
            let of = (0..corners.len()).filter(|&place| groups[place] as usize == leader);
            let corners: Vec<u32> = of.map(|place| corners[place]).collect();
            let weight = corners.iter().map(|&corner| weights[corner as usize / N]).sum();
            // A rigid body has one owner.
            let rigid = run.solid().rigid.of_element(corners[0] / N as u32);
            let place = rigid.map_or_else(
                || run.solid().position_at(corners[0]),
                |body| run.solid().rigid.motions[body as usize].centre,
            );
            units.push(CornerUnit { key: curve.key(place), corners, weight });
        }
    }
    units
}

/// The largest coordinates of owned nodes, and the smallest with the other sign, so that the largest of
/// several ranks hold for all of their nodes.
pub(super) fn ends<const D: usize, const N: usize>(run: &Simulation<D, N>) -> Vec<f64>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut ends = vec![f64::MIN; 2 * D];
    let owned = (0..run.solid().node_count()).filter(|&node| run.solid().share().node(node));
    for node in owned.map(|node| run.solid().position(node)) {
        for axis in 0..D {
            ends[axis] = ends[axis].max(node[axis]);
            ends[D + axis] = ends[D + axis].max(-node[axis]);
        }
    }
    ends
}

/// The curve through the box with these [`ends`].
pub(super) fn curve_within<const D: usize>(ends: &[f64]) -> Curve<D> {
    Curve::new(std::array::from_fn(|axis| -ends[D + axis]), std::array::from_fn(|axis| ends[axis]))
}

/// Divides space among the ranks again if the work is not even. Returns the new owner of each corner of this
/// rank.
fn divide<const D: usize, const N: usize>(
    run: Option<&Simulation<D, N>>,
    division: &mut Option<Division<D>>,
    communicator: &dyn Communicator,
) -> Vec<(u32, u32)>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let owners = |units: &[CornerUnit], splitters: &[u64]| {
        let of = |unit: &CornerUnit| owner(splitters, unit.key);
        units.iter().map(of).collect::<Vec<_>>()
    };
    let assigned = |units: Vec<CornerUnit>, owners: Vec<usize>| {
        let of = |(unit, owner): (CornerUnit, usize)| {
            unit.corners.into_iter().map(move |corner| (corner, owner as u32))
        };
        units.into_iter().zip(owners).flat_map(of).collect()
    };
    if let Some(known) = division {
        let units = run.map_or_else(Vec::new, |run| units(run, &known.curve));
        let owners = owners(&units, &known.splitters);
        let mut weights = vec![0_i64; communicator.size()];
        for (unit, &owner) in units.iter().zip(&owners) {
            weights[owner] += unit.weight.cast_signed();
        }
        communicator.all_sum(&mut weights);
        let (most, mean) = (
            weights.iter().max().copied().unwrap_or_default(),
            weights.iter().sum::<i64>() as f64 / weights.len() as f64,
        );
        if most as f64 <= (1.0 + IMBALANCE) * mean {
            return assigned(units, owners);
        }
    }
    let mut ends = run.map_or_else(|| vec![f64::MIN; 2 * D], ends);
    communicator.all_max(&mut ends);
    let curve = curve_within(&ends);
    let units = run.map_or_else(Vec::new, |run| units(run, &curve));
    let keys: Vec<u64> = units.iter().map(|unit| unit.key).collect();
    let weights: Vec<u64> = units.iter().map(|unit| unit.weight).collect();
    let splitters = splitters(communicator, &keys, &weights);
    let owners = owners(&units, &splitters);
    *division = Some(Division { curve, splitters });
    assigned(units, owners)
}

/// Sends values to ranks, those for this rank without a message. Returns the received values, with the ranks
/// that sent them.
fn exchange<T: Wire + Default>(
    communicator: &dyn Communicator,
    values: BTreeMap<usize, T>,
) -> Vec<(usize, T)> {
    let message = |(rank, value): (usize, T)| Message { rank, bytes: bytes_of(&value) };
    let heard = communicator.exchange(values.into_iter().map(message).collect());
    heard.into_iter().map(|message| (message.rank, value_of(&message.bytes))).collect()
}

/// Gives every rank its part of a run. `run`: the part that this rank has had, or the whole run; `None` if it
/// has had nothing.
pub(super) fn spread<'c, const D: usize, const N: usize>(
    run: Option<&Simulation<D, N>>,
    links: Option<&Links<'c>>,
    division: &mut Option<Division<D>>,
    frame: &CommonData<D, N>,
    communicator: &'c dyn Communicator,
) -> (RunPieces<D, N>, Neighbourhood)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let rank = communicator.rank();
    let owned = divide(run, division, communicator);
    let mut pieces = send_to_owners(run, links, owned, communicator);
    let stressed = !frame.model.stresses.is_empty() || pieces.elements.iter().any(ElementPiece::is_stressed);
    let hidden = find_near(&mut pieces, reach(frame, stressed), communicator);
    let lent = send_to_borrowers(&mut pieces, rank, communicator);
    (pieces, Neighbourhood { hidden, lent, reach: reach(frame, stressed) })
}

/// Neighbourhoods that [`spread`] has found besides the pieces.
pub(super) struct Neighbourhood {
    /// Numbers of the elements counted here that are near those of other ranks, which do not know them
    /// because they are not watched.
    hidden: BTreeSet<u32>,
    /// Codes of the corners that each other rank has too.
    lent: BTreeMap<usize, Vec<u32>>,
    reach: f64,
}

impl Neighbourhood {
    /// Makes the messages of a part.
    pub(super) fn links<'c, const D: usize, const N: usize>(
        mut self,
        run: &Simulation<D, N>,
        communicator: &'c dyn Communicator,
    ) -> Links<'c>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let rank = communicator.rank();
        let mut borrowed = BTreeMap::<usize, Vec<u32>>::new();
        if let Some(part) = &run.part {
            for (corner, &owner) in (0..).zip(&part.owners) {
                if owner as usize != rank {
                    borrowed.entry(owner as usize).or_default().push(corner);
                }
            }
        }
        let topology = &run.topology;
        let is_hidden = |element: usize| self.hidden.contains(&topology.number(element as u32));
        let hidden = (0..run.solid().element_count()).map(is_hidden).collect();
        let ranks: Vec<usize> =
            borrowed.keys().chain(self.lent.keys()).copied().collect::<BTreeSet<_>>().into_iter().collect();
        let neighbour = |rank: usize| {
            let lent = self.lent.remove(&rank).unwrap_or_default();
            let lent = lent.into_iter().filter_map(|code| topology.corner(code)).collect();
            Neighbour::new(rank, lent, borrowed.remove(&rank).unwrap_or_default())
        };
        let neighbours = ranks.into_iter().map(neighbour).collect();
        Links::new(communicator, neighbours, hidden, self.reach, run.solid())
    }
}

/// Sends all that is counted here to the ranks that own corners of it.
fn send_to_owners<const D: usize, const N: usize>(
    run: Option<&Simulation<D, N>>,
    links: Option<&Links<'_>>,
    owned: Vec<(u32, u32)>,
    communicator: &dyn Communicator,
) -> RunPieces<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut owners = Vec::new();
    if let Some(run) = run {
        owners = vec![0; N * run.solid().element_count()];
        for (corner, owner) in owned {
            owners[corner as usize] = owner;
        }
        if let Some(links) = links {
            links.tell_owners(&mut owners);
        }
    }
    let elements = send_elements(run, &owners, communicator);
    let mut own = send_between(run, &owners, communicator);
    own.elements = elements;
    own
}

/// Sends the elements, some at a time, so that their messages take little memory. Returns those of this rank.
fn send_elements<const D: usize, const N: usize>(
    run: Option<&Simulation<D, N>>,
    owners: &[u32],
    communicator: &dyn Communicator,
) -> Vec<ElementPiece<D, N>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let rank = communicator.rank() as u32;
    let known = run.map(|run| (run.counted(), Lookup::new(run)));
    let rounds = known.as_ref().map_or(0, |(counted, _)| counted.len().div_ceil(ROUND));
    let mut most = [rounds as f64];
    communicator.all_max(&mut most);
    let mut own = Vec::new();
    for round in 0..most[0] as usize {
        let mut to = BTreeMap::<usize, Vec<u8>>::new();
        if let Some((counted, lookup)) = &known {
            for &element in counted.iter().skip(round * ROUND).take(ROUND) {
                let piece = lookup.piece(element, owners);
                for other in piece.owners().filter(|&other| other != rank) {
                    piece.put(to.entry(other as usize).or_default());
                }
                if piece.owners().any(|owner| owner == rank) {
                    own.push(piece);
                }
            }
        }
        let messages = to.into_iter().map(|(rank, bytes)| Message { rank, bytes }).collect();
        for message in communicator.exchange(messages) {
            let mut bytes = &message.bytes[..];
            while !bytes.is_empty() {
                own.push(ElementPiece::take(&mut bytes));
            }
        }
    }
    own
}

/// Sends joints, couples, the memory of actions, and the elements that came apart in the last step. Returns
/// those of this rank.
fn send_between<const D: usize, const N: usize>(
    run: Option<&Simulation<D, N>>,
    owners: &[u32],
    communicator: &dyn Communicator,
) -> RunPieces<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut to = BTreeMap::<usize, RunPieces<D, N>>::new();
    if let Some(run) = run {
        let topology = &run.topology;
        let ranks_of = |number: u32| -> Vec<u32> {
            let Some(element) = topology.element(number) else { return Vec::new() };
            let corners = element as usize * N..(element as usize + 1) * N;
            let mut ranks = owners[corners].to_vec();
            once_each(&mut ranks);
            ranks
        };
        let of_both = |elements: [u32; 2]| {
            let mut ranks = elements.map(ranks_of).concat();
            once_each(&mut ranks);
            ranks
        };
        for moving in run.own_joints() {
            let code = first_corner::<D, N>(moving.joint.facet);
            if let Some(corner) = topology.corner(code) {
                to.entry(owners[corner as usize] as usize).or_default().joints.push(moving);
            }
        }
        for record in run.own_records() {
            for rank in of_both(record.codes.map(|code| code / N as u32)) {
                to.entry(rank as usize).or_default().records.push(record.clone());
            }
        }
        for (rank, contacts) in run.own_contacts().distributed(ranks_of) {
            to.entry(rank).or_default().contacts = contacts;
        }
    }
    let mut own = to.remove(&communicator.rank()).unwrap_or_default();
    for (_, more) in exchange(communicator, to) {
        own.add(more);
    }
    own
}

/// Code of the first corner of a facet, by whose owner its joint is counted.
fn first_corner<const D: usize, const N: usize>(facet: u32) -> u32
where
    [[f64; D]; N]: Simplex<D, N>,
{
    facet / N as u32 * N as u32 + <[[f64; D]; N]>::FACETS[facet as usize % N][0] as u32
}

fn around<const D: usize>(boxes: impl IntoIterator<Item = [Point<D>; 2]>) -> [Point<D>; 2] {
    let nothing = [[f64::INFINITY; D], [f64::NEG_INFINITY; D]];
    boxes.into_iter().fold(nothing, |[low, high], [least, most]| {
        [
            std::array::from_fn(|axis| f64::min(low[axis], least[axis])),
            std::array::from_fn(|axis| f64::max(high[axis], most[axis])),
        ]
    })
}

/// Whether two boxes are nearer than `reach` along every axis.
fn are_near<const D: usize>(a: &[Point<D>; 2], b: &[Point<D>; 2], reach: f64) -> bool {
    (0..D).all(|axis| a[0][axis] - reach <= b[1][axis] && b[0][axis] - reach <= a[1][axis])
}

/// Gets the watched elements of other ranks that are near watched ones here. Returns the numbers of the other
/// elements counted here that are near elements of other ranks.
fn find_near<const D: usize, const N: usize>(
    pieces: &mut RunPieces<D, N>,
    reach: f64,
    communicator: &dyn Communicator,
) -> BTreeSet<u32>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let rank = communicator.rank();
    pieces.elements.sort_unstable_by_key(|piece| piece.number);
    let all = &pieces.elements;
    let runs = all.chunks(all.len().div_ceil(BOXES).max(1));
    let fine: Vec<[Point<D>; 2]> = runs.map(|run| around(run.iter().map(ElementPiece::bounds))).collect();
    let whole = around(fine.iter().copied());
    let of_ranks: Vec<[Point<D>; 2]> =
        communicator.all_gather(&bytes_of(&whole)).iter().map(|bytes| value_of(bytes)).collect();
    let beside =
        (0..communicator.size()).filter(|&other| other != rank && are_near(&whole, &of_ranks[other], reach));
    let fine_of = exchange(communicator, beside.map(|other| (other, fine.clone())).collect());
    let mut hidden = BTreeSet::new();
    let mut offers: BTreeMap<usize, Vec<(u32, [Point<D>; 2])>> = BTreeMap::new();
    for (other, fine) in &fine_of {
        let offer = offers.entry(*other).or_default();
        for piece in all.iter().filter(|piece| piece.counted_by() as usize == rank) {
            let bounds = piece.bounds();
            if are_near(&bounds, &of_ranks[*other], reach)
                && fine.iter().any(|at| are_near(&bounds, at, reach))
            {
                if piece.watched {
                    offer.push((piece.number, bounds));
                } else {
                    hidden.insert(piece.number);
                }
            }
        }
    }
    let offered = exchange(communicator, offers);
    let place = |number: u32| all.binary_search_by_key(&number, |piece| piece.number).ok();
    let watched: Vec<[Point<D>; 2]> =
        all.iter().filter(|piece| piece.watched).map(ElementPiece::bounds).collect();
    let wanted = offered.into_iter().map(|(other, offer)| {
        let new: Vec<_> = offer.into_iter().filter(|(number, _)| place(*number).is_none()).collect();
        (other, nearest(&new, &watched, reach))
    });
    let wanted = exchange(communicator, wanted.collect::<BTreeMap<_, _>>());
    let answers = wanted.into_iter().map(|(other, numbers)| {
        let is_wanted = |number: &u32| numbers.binary_search(number).is_ok();
        let answer = RunPieces {
            elements: numbers.iter().filter_map(|&number| place(number)).map(|k| all[k].clone()).collect(),
            contacts: pieces.contacts.parted_at(is_wanted),
            ..RunPieces::default()
        };
        (other, answer)
    });
    for (_, more) in exchange(communicator, answers.collect()) {
        pieces.add(more);
    }
    pieces.contacts.sort_parted();
    hidden
}

/// The numbers of the boxes that are near any of the others.
fn nearest<const D: usize>(
    offered: &[(u32, [Point<D>; 2])],
    others: &[[Point<D>; 2]],
    reach: f64,
) -> Vec<u32> {
    let whole = around(offered.iter().map(|(_, bounds)| *bounds));
    let others = others.iter().filter(|bounds| are_near(bounds, &whole, reach));
    let boxes: Vec<[Point<D>; 2]> = offered.iter().map(|(_, bounds)| bounds).chain(others).copied().collect();
    let (min, max): (Vec<_>, Vec<_>) = boxes.iter().map(|[min, max]| (*min, *max)).unzip();
    let mut couples: Vec<Couple> = Vec::new();
    Boxes::boxes(&min, &max)
        .and_then(|boxes| boxes.with_tolerance(reach))
        .and_then(|boxes| Detector::new().couples(&boxes, &mut couples))
        .expect("boxes of elements are sound");
    let mut wanted: Vec<u32> = couples
        .into_iter()
        .filter(|couple| ((couple.i as usize) < offered.len()) != ((couple.j as usize) < offered.len()))
        .map(|couple| offered[couple.i.min(couple.j) as usize].0)
        .collect();
    once_each(&mut wanted);
    wanted
}

/// Informs the owners of corners which of them this rank has, and gets the joints there. Returns the codes of
/// corners of this rank that others have.
fn send_to_borrowers<const D: usize, const N: usize>(
    pieces: &mut RunPieces<D, N>,
    rank: usize,
    communicator: &dyn Communicator,
) -> BTreeMap<usize, Vec<u32>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    pieces.elements.sort_unstable_by_key(|piece| piece.number);
    pieces.elements.dedup_by_key(|piece| piece.number);
    let mut borrowed = BTreeMap::<usize, Vec<u32>>::new();
    for piece in &pieces.elements {
        for (k, corner) in (0..).zip(&piece.corners) {
            if corner.owner as usize != rank {
                borrowed.entry(corner.owner as usize).or_default().push(piece.number * N as u32 + k);
            }
        }
    }
    let lent: BTreeMap<usize, Vec<u32>> = exchange(communicator, borrowed).into_iter().collect();
    let of = |lent: &Vec<u32>| {
        let shared = pieces
            .joints
            .iter()
            .filter(|moving| lent.binary_search(&first_corner::<D, N>(moving.joint.facet)).is_ok());
        RunPieces::<D, N> { joints: shared.copied().collect(), ..RunPieces::default() }
    };
    let joints = lent.iter().map(|(&other, lent)| (other, of(lent))).collect();
    for (_, more) in exchange(communicator, joints) {
        pieces.add(more);
    }
    lent
}
