//! Messages between ranks that share nodes.
//!
//! In each step, a rank moves the nodes at which other ranks have elements, starts to send their motions, and moves its other nodes while these are under way. Where joints were inserted or
//! broke, the owner of a vertex also sends how it has come apart. Everything else is computed alike on every rank that needs it.

use fdem_distributed::{Communicator, Halo, Message, Port};

use crate::contacts::Contacts;
use crate::joints::Joints;
use crate::ranks::once_each;
use crate::ranks::wire::{Wire, bytes_of, value_of, wire};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::{LIMBS, Sum};
use crate::topology::{NONE, Topology};

/// A rank with which this one shares nodes.
#[derive(Debug)]
pub(super) struct Neighbour {
    rank: usize,
    /// Corners of this rank that the other one has too, and corners of the other that this one has, ascending: their order is the same on both.
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

/// The parting of a vertex, as its owner tells it to a neighbour.
struct Change<const D: usize> {
    corners: Vec<Changed>,
    /// Tractions with which ends of joints begin, by the codes of their facets.
    begin: Vec<(u32, [f64; D])>,
    /// Whether nodes were split, and whether joints broke.
    split: bool,
    broken: bool,
}

wire!([const D: usize] Change<D> { corners, begin, split, broken });

/// A corner, with its node and its group.
struct Changed {
    code: u32,
    /// Code of the first corner of its node.
    node: u32,
    /// See [`Solid::masses`].
    masses: [f64; 2],
    group: u32,
}

wire!([] Changed { code, node, masses, group });

/// A vertex whose nodes were split, with the tractions with which ends of joints begin there, by their facets.
pub(crate) type Split<const D: usize> = (u32, Vec<(u32, [f64; D])>);

/// A rank's report of a step. Of each number, the largest of all ranks counts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Told {
    /// Speed of the fastest node, m/s.
    pub(crate) fastest: f64,
    /// Whether joints are to be inserted, or broke.
    pub(crate) parts: bool,
    /// Whether the step could not be done, and whether a node is too fast.
    pub(crate) fails: bool,
    pub(crate) runs_away: bool,
}

/// The messages of a rank.
pub(crate) struct Links<'c> {
    pub(super) communicator: &'c dyn Communicator,
    pub(super) neighbours: Vec<Neighbour>,
    halo: Option<Box<dyn Halo + 'c>>,
    /// Whether the motion of each node is sent to a neighbour.
    lent: Vec<bool>,
    /// Distance that nodes may travel before elements of other ranks may touch those of this one that do not know them, m, and distance that they have travelled.
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
        let mut known = vec![NONE; solid.nodes.len()];
        for (number, neighbour) in (0..).zip(&mut self.neighbours) {
            let Neighbour { lent, borrowed, lent_nodes, borrowed_nodes, .. } = neighbour;
            for (corners, nodes) in [(lent, lent_nodes), (borrowed, borrowed_nodes)] {
                nodes.clear();
                for &corner in corners.iter() {
                    let node = solid.corners.node_at(corner);
                    if known[node as usize] != number {
                        known[node as usize] = number;
                        nodes.push(node);
                    }
                }
            }
        }
        self.lent.clear();
        self.lent.resize(solid.nodes.len(), false);
        for &node in self.neighbours.iter().flat_map(|neighbour| &neighbour.lent_nodes) {
            self.lent[node as usize] = true;
        }
        let port = |rank: usize, nodes: &[u32]| Port { rank, bytes: nodes.len() * 2 * D * 8 };
        let send: Vec<Port> = self.neighbours.iter().map(|at| port(at.rank, &at.lent_nodes)).collect();
        let receive: Vec<Port> = self.neighbours.iter().map(|at| port(at.rank, &at.borrowed_nodes)).collect();
        self.halo = None;
        self.halo = Some(self.communicator.halo(&send, &receive));
    }

    /// Whether the motion of each node is sent to a neighbour.
    pub(crate) fn lent(&self) -> &[bool] {
        &self.lent
    }

    /// Starts to send the motions of nodes that neighbours have too.
    pub(crate) fn start_motion<const D: usize, const N: usize>(&mut self, solid: &Solid<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Some(halo) = &mut self.halo else { return };
        for (port, neighbour) in self.neighbours.iter().enumerate() {
            let places = halo.outgoing(port).as_chunks_mut::<8>().0.chunks_exact_mut(2 * D);
            for (&node, places) in neighbour.lent_nodes.iter().zip(places) {
                let node = &solid.nodes[node as usize];
                for (place, number) in places.iter_mut().zip(node.position.iter().chain(&node.velocity)) {
                    *place = number.to_le_bytes();
                }
            }
            self.sent[0] += (neighbour.lent_nodes.len() * 2 * D * 8) as u64;
            self.sent[1] += 1;
        }
        halo.start();
    }

    /// Gets the motions of nodes that neighbours have sent, and exchanges what ranks say about the step.
    pub(crate) fn finish_motion<const D: usize, const N: usize>(
        &mut self,
        solid: &mut Solid<D, N>,
        step: f64,
        told: &mut Told,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Some(halo) = &mut self.halo else { return };
        let flag = |flag: bool| f64::from(u8::from(flag));
        let mut numbers = [told.fastest, flag(told.parts), flag(told.fails), flag(told.runs_away)];
        self.communicator.all_max(&mut numbers);
        *told = Told {
            fastest: numbers[0],
            parts: numbers[1] > 0.0,
            fails: numbers[2] > 0.0,
            runs_away: numbers[3] > 0.0,
        };
        halo.finish();
        for (port, neighbour) in self.neighbours.iter().enumerate() {
            let places = halo.incoming(port).as_chunks::<8>().0.chunks_exact(2 * D);
            for (&node, places) in neighbour.borrowed_nodes.iter().zip(places) {
                let node = &mut solid.nodes[node as usize];
                let numbers = node.position.iter_mut().chain(&mut node.velocity);
                numbers.zip(places).for_each(|(number, place)| *number = f64::from_le_bytes(*place));
            }
        }
        self.travelled += step * told.fastest;
        self.stale |= 2.0 * self.travelled > self.reach;
    }

    /// Exchanges values with all neighbours: `of` makes that for a neighbour by its place.
    fn tell<T: Wire>(&self, of: impl Fn(&Neighbour) -> T) -> Vec<T> {
        let message =
            |neighbour: &Neighbour| Message { rank: neighbour.rank, bytes: bytes_of(&of(neighbour)) };
        let heard = self.communicator.exchange(self.neighbours.iter().map(message).collect());
        heard.into_iter().map(|message| value_of(&message.bytes)).collect()
    }

    /// Adds the facets that fail on neighbours to those that fail here.
    pub(crate) fn share_failing<const D: usize, const N: usize>(
        &self,
        failing: &mut Vec<u32>,
        topology: &Topology<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let codes: Vec<u32> = failing.iter().map(|&facet| topology.code(facet)).collect();
        for heard in self.tell(|_| codes.clone()) {
            failing.extend(heard.into_iter().filter_map(|code| topology.facet_with(code)));
        }
        once_each(failing);
    }

    /// Tells neighbours how vertices came apart here, and follows what they tell. `broken`: vertices at which joints broke.
    pub(crate) fn exchange_changes<const D: usize, const N: usize>(
        &mut self,
        split: &[Split<D>],
        broken: &[u32],
        solid: &mut Solid<D, N>,
        joints: &mut Joints<D>,
        contacts: &mut Contacts<D, N>,
        topology: &Topology<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let begun = |vertex: u32| split.iter().find(|(at, _)| *at == vertex).map(|(_, begin)| begin);
        let mut vertices: Vec<u32> =
            split.iter().map(|(vertex, _)| *vertex).chain(broken.iter().copied()).collect();
        once_each(&mut vertices);
        let changes = |neighbour: &Neighbour| -> Vec<Change<D>> {
            let at = |&vertex: &u32| {
                let shared = |corner: &&u32| neighbour.lent.binary_search(corner).is_ok();
                let corners = topology.corners_of(vertex).iter().filter(shared).map(|&corner| {
                    let node = solid.corners.node_at(corner);
                    Changed {
                        code: topology.code_of_corner(corner),
                        node: solid.code_of_node(node, topology),
                        masses: solid.masses(node as usize),
                        group: contacts.groups[corner as usize],
                    }
                });
                let corners: Vec<Changed> = corners.collect();
                let begin = begun(vertex);
                let tractions = begin.into_iter().flatten();
                (!corners.is_empty()).then(|| Change {
                    corners,
                    begin: tractions.map(|&(facet, traction)| (topology.code(facet), traction)).collect(),
                    split: begin.is_some(),
                    broken: broken.binary_search(&vertex).is_ok(),
                })
            };
            vertices.iter().filter_map(at).collect()
        };
        for change in self.tell(changes).into_iter().flatten() {
            follow(&change, solid, joints, contacts, topology);
        }
        contacts.list_parted();
        self.plan(solid);
    }

    /// Tells neighbours the new owners of the corners that they have from this rank, and learns those of the corners that it has from them. `owners`: of each corner.
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

    /// Whether ranks must look for elements near theirs before the next step.
    pub(crate) fn is_stale(&self) -> bool {
        self.stale
    }

    /// Whether this holds on any rank.
    pub(crate) fn any(&self, holds: bool) -> bool {
        let mut numbers = [f64::from(u8::from(holds))];
        self.communicator.all_max(&mut numbers);
        numbers[0] > 0.0
    }

    /// The largest of numbers over all ranks.
    pub(crate) fn most(&self, numbers: &mut [f64]) {
        self.communicator.all_max(numbers);
    }

    /// Asks for a new look at elements near those of this rank.
    pub(crate) fn ask(&mut self) {
        self.stale = true;
    }

    /// Adds up sums over all ranks.
    pub(crate) fn add_up(&self, sums: &mut [&mut Sum]) {
        let mut numbers: Vec<i64> = sums.iter().flat_map(|sum| sum.parts()).collect();
        self.communicator.all_sum(&mut numbers);
        for (sum, parts) in sums.iter_mut().zip(numbers.chunks(LIMBS + 1)) {
            **sum = Sum::of_parts(parts);
        }
    }

    /// The values of all ranks, in the order of the ranks.
    pub(crate) fn all<T: Wire>(&self, value: &T) -> Vec<T> {
        self.communicator.all_gather(&bytes_of(value)).iter().map(|bytes| value_of(bytes)).collect()
    }

    pub(crate) fn rank(&self) -> usize {
        self.communicator.rank()
    }
}

/// Does what the owner of a vertex has done there.
fn follow<const D: usize, const N: usize>(
    change: &Change<D>,
    solid: &mut Solid<D, N>,
    joints: &mut Joints<D>,
    contacts: &mut Contacts<D, N>,
    topology: &Topology<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let here = |changed: &Changed| topology.corner(changed.code);
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
            let node = solid.corners.node_at(corner) as usize;
            solid.share.codes[node] = changed.node;
        }
        let begun = |&(code, traction): &(u32, [f64; D])| Some((topology.facet_with(code)?, traction));
        let begin: Vec<_> = change.begin.iter().filter_map(begun).collect();
        joints.open_at(vertex, &corners, &begin, solid, topology);
    }
    if change.broken {
        let groups: Vec<_> =
            corners.iter().zip(&change.corners).map(|(&corner, at)| (corner, at.group)).collect();
        contacts.divide(vertex, &groups, topology);
    }
}
