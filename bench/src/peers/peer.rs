//! The trait of a peer, and code that several of them use.

use fdem_contact::Couple;

use super::bodies::Bodies;

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

/// Runs `search` on `items`, in pieces if there is more than one thread, and joins the couples of all pieces.
#[cfg(any(feature = "kiddo", feature = "rstar"))]
pub(super) fn in_pieces<T: Sync>(
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
pub(super) fn locked(package: &str) -> String {
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
