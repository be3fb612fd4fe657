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
mod peer;
#[cfg(feature = "parry")]
mod parry;
#[cfg(feature = "rstar")]
mod rstar;
pub mod sets;
#[cfg(feature = "zelll")]
mod zelll;

#[cfg(feature = "rayon")]
use fdem_contact::Couple;
use fdem_contact::Simd;

pub use bodies::Bodies;
pub use external::{Answer, Command, External};
pub use ours::EngineKind;
pub use peer::Peer;

/// Peers for one dimension.
pub type Peers<const D: usize> = Vec<Box<dyn Peer<D>>>;

/// Our searches of the given kinds, on `threads` threads if they can use them.
///
/// # Errors
/// An error if this processor lacks the vector instructions or the threads cannot be started.
pub fn ours<const D: usize>(
    kinds: &[EngineKind],
    simd: Simd,
    threads: usize,
) -> Result<Peers<D>, fdem_contact::Error> {
    let boxed = |&kind: &EngineKind| Ok(Box::new(ours::Ours::new(kind, simd, threads)?) as Box<dyn Peer<D>>);
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
