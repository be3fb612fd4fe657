//! Messages between ranks that share nodes.
//!
//! In each step, a rank moves the nodes at which other ranks have elements, starts to send their motions, and
//! moves its other nodes while these are under way. Where joints were inserted or broke, the owner of a
//! vertex also sends how it has come apart. Everything else is computed alike on every rank that needs it.

use std::time::Duration;

use fdem_distributed::wire;
use fdem_distributed::wire::{Wire, bytes_of, value_of};
use fdem_distributed::{Communicator, Halo, Message, Port};

use crate::error::Stop;
use crate::faces::BrokenSides;
use crate::joints::VertexSplit;
use crate::lists::once_each;
use crate::machine::{Columns, Machine};
use crate::peers::{Peers, StepReport, first_of_largest};
use crate::simplex::Simplex;
use crate::solid::{Node, Solid};
use crate::sum::{LIMBS, Sum};
use crate::team::Team;
use crate::timings::Clock;
use crate::topology::{NONE, Topology};

/// A rank with which this one shares nodes.
#[derive(Debug)]
pub(super) struct Neighbour {
    rank: usize,
    /// Corners of this rank that the other one has too, and corners of the other that this one has,
    /// ascending: their order is the same on both.
    lent: Vec<u32>,
    borrowed: Vec<u32>,
    /// The nodes of these corners, each once, in the order of their first corners.
    lent_nodes: Vec<u32>,
    borrowed_nodes: Vec<u32>,
}

impl Neighbour {
    pub(super) fn new(rank: usize, lent: Vec<u32>, borrowed: Vec<u32>) -> Self {
        Self { rank, lent, borrowed, lent_nodes: Vec::new(), borrowed_nodes: Vec::new() }
    }
}

/// The parting of a vertex, as its owner sends it to a neighbour.
struct VertexChange<const D: usize> {
    corners: Vec<CornerChange>,
    /// Tractions with which ends of joints begin, by the codes of their facets.
    begin: Vec<(u32, [f64; D])>,
    /// Whether nodes were split, and whether joints broke.
    split: bool,
    broken: bool,
}

wire!([const D: usize] VertexChange<D> { corners, begin, split, broken });

/// A corner, with its node and its group.
struct CornerChange {
    code: u32,
    /// Code of the first corner of its node.
    node: u32,
    /// See [`Solid::masses`].
    masses: [f64; 2],
    group: u32,
}

wire!([] CornerChange { code, node, masses, group });

/// The messages of a rank.
pub(crate) struct Links<'c> {
    pub(super) communicator: &'c dyn Communicator,
    pub(super) neighbours: Vec<Neighbour>,
    halo: Option<Box<dyn Halo + 'c>>,
    /// Whether the motion of each node is sent to a neighbour.
    lent: Vec<bool>,
    /// Whether each element is near elements that act on other ranks, which do not know it because it was not
    /// watched.
    hidden: Vec<bool>,
    /// Distance that nodes may travel before elements of other ranks may touch those of this one that do not
    /// know them, m, and distance that they have travelled.
    reach: f64,
    travelled: f64,
    /// Whether ranks must look for elements near theirs again before the next step.
    pub(super) stale: bool,
    /// Bytes of motions that this rank has sent, and messages.
    pub(super) sent: [u64; 2],
}

impl<'c> Links<'c> {
    pub(super) fn new<const D: usize, const N: usize>(
        communicator: &'c dyn Communicator,
        neighbours: Vec<Neighbour>,
        hidden: Vec<bool>,
        reach: f64,
        solid: &Solid<D, N>,
    ) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut links = Self {
            communicator,
            neighbours,
            halo: None,
            lent: Vec::new(),
            hidden,
            reach,
            travelled: 0.0,
            stale: false,
            sent: [0; 2],
        };
        links.plan(solid);
        links
    }

    /// Finds the nodes whose motions are sent and received.
    fn plan<const D: usize, const N: usize>(&mut self, solid: &Solid<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut known = vec![NONE; solid.node_count()];
        for (number, neighbour) in (0..).zip(&mut self.neighbours) {
            let Neighbour { lent, borrowed, lent_nodes, borrowed_nodes, .. } = neighbour;
            for (corners, nodes) in [(lent, lent_nodes), (borrowed, borrowed_nodes)] {
                nodes.clear();
                for &corner in corners.iter() {
                    let node = solid.node_at(corner);
                    if known[node as usize] != number {
                        known[node as usize] = number;
                        nodes.push(node);
                    }
                }
            }
        }
        self.lent.clear();
        self.lent.resize(solid.node_count(), false);
        for &node in self.neighbours.iter().flat_map(|neighbour| &neighbour.lent_nodes) {
            self.lent[node as usize] = true;
        }
        let port = |rank: usize, nodes: &[u32]| Port { rank, bytes: nodes.len() * 2 * D * 8 };
        let send: Vec<Port> = self.neighbours.iter().map(|at| port(at.rank, &at.lent_nodes)).collect();
        let receive: Vec<Port> = self.neighbours.iter().map(|at| port(at.rank, &at.borrowed_nodes)).collect();
        self.halo = None;
        self.halo = Some(self.communicator.halo(&send, &receive));
    }

    /// Exchanges values with all neighbours: `of` makes that for a neighbour by its place.
    fn tell<T: Wire>(&self, of: impl Fn(&Neighbour) -> T) -> Vec<T> {
        let message =
            |neighbour: &Neighbour| Message { rank: neighbour.rank, bytes: bytes_of(&of(neighbour)) };
        let heard = self.communicator.exchange(self.neighbours.iter().map(message).collect());
        heard.into_iter().map(|message| value_of(&message.bytes)).collect()
    }

    /// Sends neighbours the new owners of the corners that they have from this rank, and receives the owners
    /// of the corners that it has from them. `owners`: of each corner.
    pub(super) fn tell_owners(&self, owners: &mut [u32]) {
        let heard = self.tell(|neighbour| {
            neighbour.lent.iter().map(|&corner| owners[corner as usize]).collect::<Vec<u32>>()
        });
        for (neighbour, new) in self.neighbours.iter().zip(heard) {
            for (&corner, owner) in neighbour.borrowed.iter().zip(new) {
                owners[corner as usize] = owner;
            }
        }
    }

    /// Asks for a new look at elements near those of this rank.
    pub(super) fn ask(&mut self) {
        self.stale = true;
    }

    /// Adds up sums over all ranks.
    pub(super) fn add_up(&self, sums: &mut [&mut Sum]) {
        let mut numbers: Vec<i64> = sums.iter().flat_map(|sum| sum.parts()).collect();
        self.communicator.all_sum(&mut numbers);
        for (sum, parts) in sums.iter_mut().zip(numbers.chunks(LIMBS + 1)) {
            **sum = Sum::of_parts(parts);
        }
    }

    /// The values of all ranks, in the order of the ranks.
    pub(super) fn all<T: Wire>(&self, value: &T) -> Vec<T> {
        self.communicator.all_gather(&bytes_of(value)).iter().map(|bytes| value_of(bytes)).collect()
    }
}

impl<const D: usize, const N: usize> Peers<D, N> for Links<'_>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn is_stale(&self) -> bool {
        self.stale
    }

    fn awaited(&self) -> &[bool] {
        &self.lent
    }

    fn start_motion(&mut self, machine: &dyn Machine<D, N>) {
        let Some(halo) = &mut self.halo else { return };
        for (port, neighbour) in self.neighbours.iter().enumerate() {
            let mut places = halo.outgoing(port).as_chunks_mut::<8>().0.iter_mut();
            machine.read_nodes(&neighbour.lent_nodes, &mut |node| {
                for (number, place) in node.position.iter().chain(&node.velocity).zip(&mut places) {
                    *place = number.to_le_bytes();
                }
            });
            self.sent[0] += (neighbour.lent_nodes.len() * 2 * D * 8) as u64;
            self.sent[1] += 1;
        }
        halo.start();
    }

    fn finish_motion(
        &mut self,
        machine: &mut dyn Machine<D, N>,
        step: f64,
        report: StepReport,
        waiting: &mut Duration,
    ) -> StepReport {
        let Some(halo) = &mut self.halo else { return report };
        let mut clock = Clock::new();
        let flag = |flag: bool| f64::from(u8::from(flag));
        let mut numbers = [report.fastest, flag(report.parts), flag(report.fails), flag(report.runs_away)];
        self.communicator.all_max(&mut numbers);
        let report = StepReport {
            fastest: numbers[0],
            parts: numbers[1] > 0.0,
            fails: numbers[2] > 0.0,
            runs_away: numbers[3] > 0.0,
        };
        halo.finish();
        for (port, neighbour) in self.neighbours.iter().enumerate() {
            let mut places = halo.incoming(port).as_chunks::<8>().0.iter();
            let mut number = || places.next().map_or(f64::NAN, |place| f64::from_le_bytes(*place));
            machine.write_nodes(&neighbour.borrowed_nodes, &mut || Node {
                position: std::array::from_fn(|_| number()),
                velocity: std::array::from_fn(|_| number()),
            });
        }
        self.travelled += step * report.fastest;
        self.stale |= 2.0 * self.travelled > self.reach;
        clock.read(waiting);
        report
    }

    fn add_failing(&self, failing: &mut Vec<u32>, topology: &Topology<D, N>) {
        let codes: Vec<u32> = failing.iter().map(|&facet| topology.code(facet)).collect();
        for heard in self.tell(|_| codes.clone()) {
            failing.extend(heard.into_iter().filter_map(|code| topology.facet_with(code)));
        }
        once_each(failing);
    }

    fn exchange_splits(
        &mut self,
        split: &[VertexSplit<D>],
        broken: &[u32],
        columns: &mut Columns<D, N>,
        topology: &Topology<D, N>,
    ) {
        let Columns { solid, contacts, .. } = &*columns;
        let begun = |vertex: u32| split.iter().find(|(at, _)| *at == vertex).map(|(_, begin)| begin);
        let mut vertices: Vec<u32> =
            split.iter().map(|(vertex, _)| *vertex).chain(broken.iter().copied()).collect();
        once_each(&mut vertices);
        let changes = |neighbour: &Neighbour| -> Vec<VertexChange<D>> {
            let at = |&vertex: &u32| {
                let shared = |corner: &&u32| neighbour.lent.binary_search(corner).is_ok();
                let corners = topology.corners_of(vertex).iter().filter(shared).map(|&corner| {
                    let node = solid.node_at(corner);
                    CornerChange {
                        code: topology.code_of_corner(corner),
                        node: solid.code_of_node(node, topology),
                        masses: solid.masses(node as usize),
                        group: contacts.surface.groups[corner as usize],
                    }
                });
                let corners: Vec<CornerChange> = corners.collect();
                let begin = begun(vertex);
                let tractions = begin.into_iter().flatten();
                (!corners.is_empty()).then(|| VertexChange {
                    corners,
                    begin: tractions.map(|&(facet, traction)| (topology.code(facet), traction)).collect(),
                    split: begin.is_some(),
                    broken: broken.binary_search(&vertex).is_ok(),
                })
            };
            vertices.iter().filter_map(at).collect()
        };
        for change in self.tell(changes).into_iter().flatten() {
            follow(&change, columns, topology);
        }
        columns.contacts.surface.list_parted();
        self.plan(&columns.solid);
    }

    fn note_bared(&mut self, bared: &[u32]) {
        let hidden = bared.iter().any(|&element| self.hidden[element as usize]);
        let mut any = [f64::from(u8::from(hidden))];
        self.communicator.all_max(&mut any);
        if any[0] > 0.0 {
            self.ask();
        }
    }

    fn all_broken(&self, own: Vec<BrokenSides<D>>) -> Vec<BrokenSides<D>> {
        self.all(&own).concat()
    }

    fn add_up(&self, sums: &mut [&mut Sum]) {
        Links::add_up(self, sums);
    }

    fn largest(&self, numbers: &mut [f64]) {
        self.communicator.all_max(numbers);
    }

    fn rank(&self) -> usize {
        self.communicator.rank()
    }

    fn are_none(&self) -> bool {
        false
    }

    fn all_bytes(&self, own: &[u8]) -> Vec<Vec<u8>> {
        self.communicator.all_gather(own)
    }

    fn first_stop(&self, own: Option<Stop>) -> Option<Stop> {
        let rank = self.communicator.rank();
        let all = self.all(&own.map(|stop| stop.on_rank(rank)));
        all.into_iter().flatten().min_by_key(Stop::element)
    }

    fn first_of_largest(&self, own: Option<(f64, u32)>) -> Option<(f64, u32)> {
        self.all(&own).into_iter().flatten().reduce(first_of_largest)
    }
}

/// Repeats the changes that the owner of a vertex has made there.
fn follow<const D: usize, const N: usize>(
    change: &VertexChange<D>,
    columns: &mut Columns<D, N>,
    topology: &Topology<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let Columns { solid, joints, contacts } = columns;
    let here = |changed: &CornerChange| topology.corner(changed.code);
    let corners: Vec<u32> = change.corners.iter().filter_map(here).collect();
    let Some(&first) = corners.first() else { return };
    let vertex = topology.vertices[first as usize];
    if change.split {
        let node = |place: usize| change.corners[place].node;
        let leader = |place: usize| (0..=place).find(|&first| node(first) == node(place)).unwrap_or(place);
        let groups: Vec<u32> = (0..corners.len()).map(|place| leader(place) as u32).collect();
        solid.split(&corners, &groups);
        for (&corner, changed) in corners.iter().zip(&change.corners) {
            solid.set_mass(corner, changed.masses);
            let node = solid.node_at(corner) as usize;
            solid.set_code(node, changed.node);
        }
        let begun = |&(code, traction): &(u32, [f64; D])| Some((topology.facet_with(code)?, traction));
        let begin: Vec<_> = change.begin.iter().filter_map(begun).collect();
        joints.open_at(vertex, &corners, &begin, solid, topology, &Team::ALONE);
        solid.wake_around(vertex, topology);
    }
    if change.broken {
        let groups: Vec<_> =
            corners.iter().zip(&change.corners).map(|(&corner, at)| (corner, at.group)).collect();
        contacts.surface.divide(vertex, &groups, topology);
    }
}
