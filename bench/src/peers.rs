//! Other search libraries behind one trait, each a Cargo feature of this package; libraries in other
//! languages are programs ([`External`]).
//!
//! The work is the same for all: raw `f64` coordinates in ([`Bodies`]), every touching couple out as numbers
//! `i < j`, including everything that is built on the way. Each library is called in the fastest documented
//! way that we could find. Its memory is kept from call to call if it offers that.

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

/// A search that is timed: one of ours or another library.
pub trait Peer<const D: usize> {
    /// Name in the tables.
    fn name(&self) -> &'static str;

    /// The version of the crate.
    fn version(&self) -> String;

    /// A short description of the call.
    fn how(&self) -> String;

    /// Bytes that it keeps between two searches, if known.
    fn bytes(&self) -> Option<usize> {
        None
    }

    /// Writes every couple into `couples`, which is cleared first.
    ///
    /// # Errors
    /// The reason why this peer cannot search these bodies, in a few words.
    fn couples(&mut self, bodies: Bodies<'_, D>, couples: &mut Vec<Couple>) -> Result<(), String>;
}

/// Peers for one dimension.
pub type Peers<const D: usize> = Vec<Box<dyn Peer<D>>>;

/// Our searches of the given kinds, on `threads` threads if they can use them.
///
/// # Errors
/// An error if this processor lacks the vector instructions or the threads cannot be started.
pub fn ours<const D: usize>(
    kinds: &[Kind],
    simd: Simd,
    threads: usize,
) -> Result<Peers<D>, fdem_contact::Error> {
    let boxed = |&kind: &Kind| Ok(Box::new(ours::Ours::new(kind, simd, threads)?) as Box<dyn Peer<D>>);
    kinds.iter().map(boxed).collect()
}

/// The compiled-in libraries that search in 3D.
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

/// The compiled-in libraries that search in 2D.
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

/// The threads that the libraries share. Our searches and external programs have their own.
pub struct Threads {
    count: usize,
    #[cfg(feature = "rayon")]
    pool: std::sync::Arc<rayon::ThreadPool>,
}

impl Threads {
    /// Starts `count` threads.
    ///
    /// # Errors
    /// An error if the threads cannot be started.
    pub fn new(count: usize) -> Result<Self, String> {
        #[cfg(feature = "rayon")]
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        Ok(Self {
            count,
            #[cfg(feature = "rayon")]
            pool: pool.map_err(|error| error.to_string())?.into(),
        })
    }

    /// Number of threads.
    pub fn count(&self) -> usize {
        self.count
    }

    #[cfg(feature = "rayon")]
    fn boxed<const D: usize>(&self, peer: impl Peer<D> + Send + 'static) -> Box<dyn Peer<D>> {
        Box::new(Pooled { peer, pool: self.pool.clone() })
    }
}

/// A library that uses the threads of the pool that calls it.
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

/// Runs `search` on `items`, in pieces if there is more than one thread, and joins the couples of all pieces.
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

/// The version of a package in the lock file of this workspace; the newest one if there are several.
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
