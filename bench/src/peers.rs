//! Rival searches behind one trait, each a Cargo feature of this package; those in other languages are programs ([`External`]).
//!
//! The work is the same for all: raw `f64` coordinates in ([`Bodies`]), every couple that touches out, as numbers `i < j`,
//! whatever is built on the way included. Each rival is called in the fastest way that its documentation shows and
//! that could be found; memory is kept from call to call where it offers that.

mod bodies;
#[cfg(feature = "broccoli")]
mod broccoli;
mod external;
#[cfg(feature = "kiddo")]
mod kiddo;
#[cfg(feature = "molar")]
mod molar;
mod ours;
#[cfg(feature = "parry")]
mod parry;
#[cfg(feature = "rstar")]
mod rstar;
pub mod sets;
#[cfg(feature = "zelll")]
mod zelll;

use fdem_contact::{Couple, Simd};

pub use bodies::Bodies;
pub use external::{Answer, Command, External};
pub use ours::Kind;

/// A search that is timed: one of ours or a rival.
pub trait Peer<const D: usize> {
    /// Name in the tables.
    fn name(&self) -> &'static str;

    /// The crate's version.
    fn version(&self) -> String;

    /// What is called, in a few words.
    fn how(&self) -> String;

    /// Bytes that it keeps between two searches, if that is known.
    fn bytes(&self) -> Option<usize> {
        None
    }

    /// Writes every couple into `couples`, cleared first.
    ///
    /// # Errors
    /// Why this peer cannot search these bodies, in a few words.
    fn couples(&mut self, bodies: Bodies<'_, D>, couples: &mut Vec<Couple>) -> Result<(), String>;
}

/// Some peers for points of one dimension.
pub type Peers<const D: usize> = Vec<Box<dyn Peer<D>>>;

/// Our searches of these kinds, on `threads` threads where they can.
///
/// # Errors
/// Vector instructions that this processor lacks, or threads that cannot be had.
pub fn ours<const D: usize>(
    kinds: &[Kind],
    simd: Simd,
    threads: usize,
) -> Result<Peers<D>, fdem_contact::Error> {
    let boxed = |&kind: &Kind| Ok(Box::new(ours::Ours::new(kind, simd, threads)?) as Box<dyn Peer<D>>);
    kinds.iter().map(boxed).collect()
}

/// The rivals that were compiled in and search in space.
#[must_use]
pub fn rivals_3d(threads: &Threads) -> Peers<3> {
    let _ = threads;
    vec![
        #[cfg(feature = "molar")]
        threads.boxed(molar::Molar),
        #[cfg(feature = "zelll")]
        threads.boxed(zelll::Zelll::new(threads.count)),
        #[cfg(feature = "kiddo")]
        threads.boxed(kiddo::Kiddo { threads: threads.count }),
        #[cfg(feature = "parry")]
        Box::new(parry::Parry::new()),
        #[cfg(feature = "rstar")]
        threads.boxed(rstar::Rstar { threads: threads.count }),
    ]
}

/// The rivals that were compiled in and search in the plane.
#[must_use]
pub fn rivals_2d(threads: &Threads) -> Peers<2> {
    let _ = threads;
    vec![
        #[cfg(feature = "zelll")]
        threads.boxed(zelll::Zelll::new(threads.count)),
        #[cfg(feature = "kiddo")]
        threads.boxed(kiddo::Kiddo { threads: threads.count }),
        #[cfg(feature = "rstar")]
        threads.boxed(rstar::Rstar { threads: threads.count }),
        #[cfg(feature = "broccoli")]
        Box::new(broccoli::Broccoli::new()),
    ]
}

/// The threads that the rivals share; ours and the external ones have their own.
pub struct Threads {
    count: usize,
    #[cfg(feature = "rayon")]
    pool: std::sync::Arc<rayon::ThreadPool>,
}

impl Threads {
    /// So many threads.
    ///
    /// # Errors
    /// Threads that cannot be had.
    pub fn new(count: usize) -> Result<Self, String> {
        #[cfg(feature = "rayon")]
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        Ok(Self {
            count,
            #[cfg(feature = "rayon")]
            pool: pool.map_err(|error| error.to_string())?.into(),
        })
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.count
    }

    #[cfg(feature = "rayon")]
    fn boxed<const D: usize>(&self, peer: impl Peer<D> + Send + 'static) -> Box<dyn Peer<D>> {
        Box::new(Pooled { peer, pool: self.pool.clone() })
    }
}

/// A rival that takes its threads from the pool around it.
#[cfg(feature = "rayon")]
struct Pooled<P> {
    peer: P,
    pool: std::sync::Arc<rayon::ThreadPool>,
}

#[cfg(feature = "rayon")]
impl<const D: usize, P: Peer<D> + Send> Peer<D> for Pooled<P> {
    fn name(&self) -> &'static str {
        self.peer.name()
    }

    fn version(&self) -> String {
        self.peer.version()
    }

    fn how(&self) -> String {
        self.peer.how()
    }

    fn couples(&mut self, bodies: Bodies<'_, D>, couples: &mut Vec<Couple>) -> Result<(), String> {
        let peer = &mut self.peer;
        self.pool.install(|| peer.couples(bodies, couples))
    }
}

/// Runs `search` on `items`, in pieces if there is more than one thread, and puts the couples of all pieces together.
#[cfg(any(feature = "kiddo", feature = "rstar"))]
fn in_pieces<T: Sync>(
    items: &[T],
    threads: usize,
    couples: &mut Vec<Couple>,
    search: impl Fn(&[T], &mut Vec<Couple>) + Sync,
) {
    use rayon::prelude::*;

    if threads == 1 {
        return search(items, couples);
    }
    let pieces = items.par_chunks(items.len().div_ceil(8 * threads).max(1)).map(|piece| {
        let mut found = Vec::new();
        search(piece, &mut found);
        found
    });
    for piece in pieces.collect::<Vec<_>>() {
        couples.extend_from_slice(&piece);
    }
}

/// The version of a package in the lock file of this workspace; the newest if there are several.
fn locked(package: &str) -> String {
    let lock = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.lock"));
    let mut found = "unknown";
    let mut inside = false;
    for line in lock.lines() {
        if let Some(name) = line.strip_prefix("name = ") {
            inside = name.trim_matches('"') == package;
        } else if let Some(version) = line.strip_prefix("version = ")
            && inside
        {
            found = version.trim_matches('"');
        }
    }
    found.to_owned()
}
