//! Forecast of a run on many ranks: the share of each rank, its messages and its memory, found by one process
//! without a step.
//!
//! The division of nodes is that of `spread.rs`, by the same functions. Which elements, nodes and neighbours
//! a rank gets follows from it.

use fdem_contact::{Couple, Detector, Elements as Boxes, Search};
use fdem_distributed::curve::{owner, splitters_of_all};
use serde::Serialize;

use crate::bodies::Bodies;
use crate::compiled::compiled;
use crate::error::ModelError;
use crate::joints::saved::MovingJoint;
use crate::lists::once_each;
use crate::model::Model;
use crate::ranks::piece::{CommonData, ElementPiece};
use crate::ranks::spread::{curve_within, ends, reach, units};
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::vector::Point;

/// Elements, messages and memory of a run on a number of ranks, at its beginning or at any later step.
///
/// The shares and messages are those that [`Distributed::new`](crate::Distributed::new) gives the ranks,
/// exactly: elements that each rank computes because they act on its nodes, or because they are so near to
/// its own that they may touch them soon. They change when joints are inserted, when bodies move, and when
/// ranks get other elements because the work has become uneven.
///
/// # Cost
/// About that of a step, and of sorting the corners; memory of some 50 bytes for each element. There are no
/// messages and no threads.
///
/// # Example
/// ```
/// # use fdem_simulation::*;
/// # let mesh = Mesh { nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], elements: vec![[0, 1, 2], [2, 1, 3]], bodies: vec![0; 2], materials: vec![0; 2] };
/// # let material = Material { name: "rock".to_owned(), density: 2700.0, youngs_modulus: 50e9, poissons_ratio: 0.25, law: fdem_simulation::MaterialLaw::NeoHookean, damping: 0.0, strength: None, friction: 0.5 };
/// let model = Model { mesh, materials: vec![material], ..Model::default() };
/// let mut run = Simulation::new(model, 1)?;
/// let forecast = Forecast::of(&mut run, 2)?;
/// // Each triangle is counted once, and both act on nodes of both ranks.
/// assert_eq!(forecast.of_ranks.iter().map(|rank| rank.own).sum::<usize>(), 2);
/// assert_eq!(forecast.of_ranks[0].neighbours, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// Number of elements of the model.
    pub elements: usize,
    /// Number of nodes of the model: more than those of the mesh where it has come apart.
    pub nodes: usize,
    /// The share of each rank.
    pub of_ranks: Vec<RankForecast>,
    /// Memory for an element, by purpose.
    pub sizes: Sizes,
    /// Memory of rank 0 while it gives the other ranks their elements, bytes. It has the whole model then.
    pub memory_at_beginning: u64,
}

/// The share of one rank in a run on many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RankForecast {
    /// Elements that this rank counts.
    pub own: usize,
    /// Elements that it computes too because they act on its nodes, or are near its elements.
    pub halo: usize,
    /// Elements of `halo` that are only near.
    pub near: usize,
    /// Nodes that this rank moves.
    pub nodes: usize,
    /// Ranks with which it exchanges messages in each step.
    pub neighbours: usize,
    /// Nodes whose motions it sends in a step; a node that goes to two ranks counts twice.
    pub sent: usize,
    /// Nodes whose motions it receives in a step.
    pub received: usize,
    /// Bytes that it sends in a step.
    pub bytes: usize,
    /// Bytes of the largest of these messages.
    pub largest: usize,
    /// Work of its nodes, in the unit by which the division weighs elements, joints and contacts.
    pub weight: u64,
    /// Memory of its part of the run, bytes: its elements times [`Sizes::all`].
    pub memory: u64,
}

impl RankForecast {
    /// Number of elements that the rank computes.
    pub fn held(&self) -> usize {
        self.own + self.halo
    }
}

/// Memory for an element on a rank, bytes: the mean over the model, from the lists that the simulation has of
/// it. The program itself is not included, nor results that wait to be written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sizes {
    /// Mesh, initial velocities and stresses.
    pub model: f64,
    /// Vertices, facets, and numbers in the whole model.
    pub connectivity: f64,
    /// Nodes, shapes, stresses and forces of elements.
    pub solid: f64,
    /// Strengths of facets, and joints that are there now.
    pub joints: f64,
    /// Elements near free surfaces, and the couples of these that are so near that ranks exchange them: more
    /// than the search keeps.
    pub contacts: f64,
}

impl Sizes {
    /// The sum, bytes.
    pub fn all(&self) -> f64 {
        let Self { model, connectivity, solid, joints, contacts } = self;
        model + connectivity + solid + joints + contacts
    }
}

/// A network between ranks, for an estimate of the time that messages take.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Network {
    /// Time of a message without content, s.
    pub latency: f64,
    /// Bytes that a rank sends in a second.
    pub bandwidth: f64,
}

impl Default for Network {
    /// 2 µs and 10 GB/s: the interconnect of a cluster, not measured.
    fn default() -> Self {
        Self { latency: 2e-6, bandwidth: 10e9 }
    }
}

impl Network {
    /// Time in which a rank exchanges `messages` messages with `bytes` bytes together, s.
    pub fn exchange(&self, messages: f64, bytes: f64) -> f64 {
        messages * self.latency + bytes / self.bandwidth
    }

    /// Time in which `ranks` ranks find a largest value, s: to one rank and back along a tree.
    pub fn agreement(&self, ranks: usize) -> f64 {
        2.0 * (ranks as f64).log2().ceil() * self.latency
    }
}

/// The nodes that a rank sends to another: sender, receiver, node.
type SentNode = (u32, u32, u32);

impl Forecast {
    /// Predicts a run on the given number of ranks from its present state. The run is not changed, except
    /// that it looks for couples again in its next step.
    ///
    /// # Errors
    /// [`ModelError::Ranks`] if there are no ranks, or more than elements; [`ModelError::Pores`] for pores.
    pub fn of<const D: usize, const N: usize>(
        run: &mut Simulation<D, N>,
        ranks: usize,
    ) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        compiled!((run: change [Simulation<2, 3>, Simulation<3, 4>], ranks: as_is [usize, usize])
            -> [Result<Forecast, ModelError>, Result<Forecast, ModelError>] = Forecast::of_run)
    }

    fn of_run<const D: usize, const N: usize>(
        run: &mut Simulation<D, N>,
        ranks: usize,
    ) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let elements = run.solid().element_count();
        if ranks == 0 || ranks > elements {
            return Err(ModelError::Ranks { ranks, elements });
        }
        if run.model.pores.is_some() {
            return Err(ModelError::Pores("the run is on many ranks"));
        }
        run.watch();
        let run = &*run;
        let (owners, weights) = divided(run, ranks);
        let (near, couples) = near(run, &owners)?;
        let sizes = sizes(run, couples);
        let mut of_ranks: Vec<RankForecast> =
            weights.into_iter().map(|weight| RankForecast { weight, ..RankForecast::default() }).collect();
        let mut sent: Vec<SentNode> = Vec::new();
        let mut next = near.iter().peekable();
        for element in 0..elements {
            let of_corners = &owners[N * element..N * (element + 1)];
            let mut holders = of_corners.to_vec();
            once_each(&mut holders);
            while let Some(&(_, rank)) = next.next_if(|(other, _)| *other as usize == element) {
                of_ranks[rank as usize].near += 1;
                holders.push(rank);
            }
            of_ranks[of_corners[0] as usize].own += 1;
            for &holder in &holders {
                of_ranks[holder as usize].halo += usize::from(holder != of_corners[0]);
                let borrowed = (0..N).filter(|&k| of_corners[k] != holder);
                sent.extend(
                    borrowed.map(|k| (of_corners[k], holder, run.solid().nodes_of(element as u32)[k])),
                );
            }
        }
        for node in 0..run.solid().node_count() {
            of_ranks[owners[run.solid().corners(node)[0] as usize] as usize].nodes += 1;
        }
        once_each(&mut sent);
        add_messages::<D>(&mut of_ranks, &sent);
        for rank in &mut of_ranks {
            rank.memory = (rank.held() as f64 * sizes.all()).round() as u64;
        }
        // While rank 0 sorts out its messages, it has the run, each element and each joint once, and a copy
        // of the element for each rank that holds it.
        let held: usize = of_ranks.iter().map(RankForecast::held).sum();
        let moving = (elements + held) * size_of::<ElementPiece<D, N>>()
            + run.joints().all.len() * size_of::<MovingJoint<D>>();
        let memory_at_beginning = (elements as f64 * sizes.all()).round() as u64 + moving as u64;
        Ok(Self { elements, nodes: run.solid().node_count(), of_ranks, sizes, memory_at_beginning })
    }

    /// Number of ranks.
    pub fn ranks(&self) -> usize {
        self.of_ranks.len()
    }

    /// Work of the busiest rank over the mean: 1 if all have the same.
    pub fn imbalance(&self) -> f64 {
        let weights = self.of_ranks.iter().map(|rank| rank.weight as f64);
        weights.clone().fold(0.0, f64::max) * self.of_ranks.len() as f64 / weights.sum::<f64>()
    }

    /// Elements in halos of all ranks over the elements of the model: the share of the work that is done
    /// again.
    pub fn halo_share(&self) -> f64 {
        self.of_ranks.iter().map(|rank| rank.halo as f64).sum::<f64>() / self.elements as f64
    }

    /// Estimate of the time that messages take in a step, s: those of the rank for which they take longest,
    /// and the agreement of all ranks.
    pub fn message_seconds(&self, network: &Network) -> f64 {
        let of = |rank: &RankForecast| network.exchange(rank.neighbours as f64, rank.bytes as f64);
        self.of_ranks.iter().map(of).fold(0.0, f64::max) + network.agreement(self.of_ranks.len())
    }

    /// Mean over the ranks of a number of each.
    pub fn mean(&self, of: impl Fn(&RankForecast) -> usize) -> f64 {
        self.of_ranks.iter().map(|rank| of(rank) as f64).sum::<f64>() / self.of_ranks.len() as f64
    }

    /// Most of any rank.
    pub fn most(&self, of: impl Fn(&RankForecast) -> usize) -> usize {
        self.of_ranks.iter().map(of).max().unwrap_or_default()
    }
}

/// The rank that owns each corner, and the weight of each rank.
fn divided<const D: usize, const N: usize>(run: &Simulation<D, N>, ranks: usize) -> (Vec<u32>, Vec<u64>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let units = units(run, &curve_within(&ends(run)));
    let keys: Vec<u64> = units.iter().map(|unit| unit.key).collect();
    let of_units: Vec<u64> = units.iter().map(|unit| unit.weight).collect();
    let splitters = splitters_of_all(ranks, &keys, &of_units);
    let mut owners = vec![0; N * run.solid().element_count()];
    let mut weights = vec![0; ranks];
    for unit in units {
        let rank = owner(&splitters, unit.key);
        weights[rank] += unit.weight;
        for corner in unit.corners {
            owners[corner as usize] = rank as u32;
        }
    }
    (owners, weights)
}

/// Elements with the ranks that hold them only because they are near elements that act on nodes of the rank,
/// ascending, and the number of couples of watched elements that are so near.
fn near<const D: usize, const N: usize>(
    run: &Simulation<D, N>,
    owners: &[u32],
) -> Result<(Vec<(u32, u32)>, u64), ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let reach = reach(&CommonData::of(run), !run.model.stresses.is_empty());
    let all = 0..run.solid().element_count() as u32;
    let watched: Vec<u32> = all.filter(|&element| run.contacts().surface.watched[element as usize]).collect();
    let bounds = watched.iter().map(|&element| run.solid().bounds(element));
    let (min, max): (Vec<_>, Vec<_>) = bounds.map(|[min, max]| (min, max)).unzip();
    let owners_of = |element: u32| &owners[N * element as usize..N * (element as usize + 1)];
    let (mut near, mut couples) = (Vec::new(), 0);
    let visit = |Couple { i, j, .. }: Couple| {
        couples += 1;
        let [a, b] = [i, j].map(|place| watched[place as usize]);
        for (one, other) in [(a, b), (b, a)] {
            let theirs = owners_of(other);
            near.extend(theirs.iter().filter(|rank| !owners_of(one).contains(rank)).map(|&rank| (one, rank)));
        }
    };
    Boxes::boxes(&min, &max)
        .and_then(|boxes| boxes.with_tolerance(reach))
        .and_then(|boxes| Detector::new().for_each(&boxes, visit))
        .map_err(|error| ModelError::Detection { message: error.to_string() })?;
    once_each(&mut near);
    Ok((near, couples))
}

/// Adds the messages that each rank sends and receives. `sent`: ascending, without repetition.
fn add_messages<const D: usize>(of_ranks: &mut [RankForecast], sent: &[SentNode]) {
    let bytes_of_node = 2 * D * size_of::<f64>();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for message in sent.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (from, to, _) = message[0];
        let sender = &mut of_ranks[from as usize];
        sender.sent += message.len();
        sender.bytes += message.len() * bytes_of_node;
        sender.largest = sender.largest.max(message.len() * bytes_of_node);
        of_ranks[to as usize].received += message.len();
        pairs.extend([[from, to], [to, from]]);
    }
    once_each(&mut pairs);
    for [rank, _] in pairs {
        of_ranks[rank as usize].neighbours += 1;
    }
}

/// Memory for an element on a rank. `couples`: number of couples of watched elements.
fn sizes<const D: usize, const N: usize>(run: &Simulation<D, N>, couples: u64) -> Sizes
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let elements = run.solid().element_count() as f64;
    let each = |bytes: usize| bytes as f64 / elements;
    let Model { mesh, velocities, stresses, joint_facets, .. } = &run.model;
    let model = size_of_val(&*mesh.nodes)
        + size_of_val(&*mesh.elements)
        + size_of_val(&*mesh.bodies)
        + size_of_val(&*mesh.materials)
        + size_of_val(&**velocities)
        + size_of_val(&**stresses)
        + size_of_val(&**joint_facets);
    // On a rank: the number of each element, which of its facets are outer, the owner of each corner and
    // whether it is this rank; three numbers for each vertex.
    let number = size_of::<u32>();
    let of_part = (number + N + N * (number + 1) + 1) as f64 + each(3 * number * mesh.nodes.len());
    let watched = run.contacts().surface.watched.iter().filter(|watched| **watched).count();
    let boxes = watched * 2 * size_of::<Point<D>>() + couples as usize * size_of::<Couple>();
    Sizes {
        model: each(model),
        connectivity: each(run.topology.bytes()) + of_part,
        solid: each(run.solid().bytes()),
        joints: each(run.joints().bytes()),
        contacts: each(run.contacts().bytes() + boxes),
    }
}
