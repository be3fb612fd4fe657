//! Rival searches behind one trait; each is a Cargo feature of this package.
//!
//! The work is the same for all: raw `f64` coordinates in, every couple at most `cutoff` apart out, as numbers `i < j`,
//! whatever is built on the way included. Each rival is called in the fastest way that its documentation shows and
//! that could be found; memory is kept from call to call where it offers that.

#[cfg(feature = "broccoli")]
mod broccoli;
#[cfg(feature = "kiddo")]
mod kiddo;
#[cfg(feature = "molar")]
mod molar;
mod ours;
#[cfg(feature = "parry")]
mod parry;
#[cfg(feature = "rstar")]
mod rstar;
#[cfg(feature = "zelll")]
mod zelll;

use fdem_contact::{Couple, Simd};

pub use ours::Kind;

/// A search that is timed: one of ours or a rival.
pub trait Peer<const D: usize> {
    /// Name in the tables.
    fn name(&self) -> &'static str;

    /// The crate's version.
    fn version(&self) -> String;

    /// What is called, in a few words.
    fn how(&self) -> String;

    /// Writes every couple into `couples`, cleared first.
    ///
    /// # Errors
    /// Why this peer cannot search these points, in a few words.
    fn couples(&mut self, points: &[[f64; D]], cutoff: f64, couples: &mut Vec<Couple>) -> Result<(), String>;
}

/// Some peers for points of one dimension.
pub type Peers<const D: usize> = Vec<Box<dyn Peer<D>>>;

/// Our searches of these kinds.
///
/// # Errors
/// Vector instructions that this processor lacks.
pub fn ours<const D: usize>(kinds: &[Kind], simd: Simd) -> Result<Peers<D>, fdem_contact::Error> {
    kinds.iter().map(|&kind| Ok(Box::new(ours::Ours::new(kind, simd)?) as Box<dyn Peer<D>>)).collect()
}

/// The rivals that were compiled in and search in space; `threads` is how many they may use.
#[must_use]
pub fn rivals_3d(threads: usize) -> Peers<3> {
    let _ = threads;
    vec![
        #[cfg(feature = "molar")]
        Box::new(molar::Molar { threads }),
        #[cfg(feature = "zelll")]
        Box::new(zelll::Zelll::new(threads)),
        #[cfg(feature = "kiddo")]
        Box::new(kiddo::Kiddo { threads }),
        #[cfg(feature = "parry")]
        Box::new(parry::Parry::new()),
        #[cfg(feature = "rstar")]
        Box::new(rstar::Rstar { threads }),
    ]
}

/// The rivals that were compiled in and search in the plane; `threads` is how many they may use.
#[must_use]
pub fn rivals_2d(threads: usize) -> Peers<2> {
    let _ = threads;
    vec![
        #[cfg(feature = "zelll")]
        Box::new(zelll::Zelll::new(threads)),
        #[cfg(feature = "kiddo")]
        Box::new(kiddo::Kiddo { threads }),
        #[cfg(feature = "rstar")]
        Box::new(rstar::Rstar { threads }),
        #[cfg(feature = "broccoli")]
        Box::new(broccoli::Broccoli::new()),
    ]
}

/// Sets how many threads the rivals' shared pool has. Call it once, before anything else.
///
/// # Errors
/// A pool that is there already.
#[cfg(feature = "rayon")]
pub fn use_threads(threads: usize) -> Result<(), String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build_global().map_err(|error| error.to_string())
}

/// Without rivals that use it there is no pool.
///
/// # Errors
/// None.
#[cfg(not(feature = "rayon"))]
pub fn use_threads(_: usize) -> Result<(), String> {
    Ok(())
}

/// The closed comparison of this workspace.
#[cfg(any(feature = "zelll", feature = "parry", feature = "broccoli"))]
fn within<const D: usize>(a: &[f64; D], b: &[f64; D], cutoff_squared: f64) -> bool {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.reduce(|sum, square| sum + square).is_some_and(|sum| sum <= cutoff_squared)
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
