//! Contact detection: finds which of N elements touch, in time and memory proportional to N at any packing density.
//!
//! ```
//! let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [5.0, 5.0, 5.0]];
//! let radii = [0.5, 0.6, 0.5];
//! let couples = fdem_contact::couples(&centres, &radii)?; // touching counts, i < j, each couple once
//! assert_eq!(couples, [fdem_contact::Couple::new(0, 1)]);
//! # Ok::<(), fdem_contact::Error>(())
//! ```
//!
//! These are [`couples`] and [`couples_within`], the latter for points with a cut-off. For everything else:
//!
//! | you want | use |
//! |---|---|
//! | axis-aligned boxes, one radius for all, a gap that still counts | [`Elements`] |
//! | to search repeatedly in the same memory, without a list, or to count only | [`Detector`] and its [`Search`] methods |
//! | elements that move a little between searches | [`Buffered`] |
//! | the neighbours of each element, contiguous in memory, with a distance or another value | [`Csr`], [`Elements::distance_squared`] |
//! | no contacts within a body, or between certain groups | [`Filter`], [`Elements::with_filter`] |
//! | periodic boxes, rectangular or sheared | [`PeriodicBox`], [`PeriodicSearch`] |
//! | two sets, one of them sorted once: walls, boundaries | [`Index`], [`Index::couples_with`] |
//! | all elements within a distance of points, or the nearest `k` | [`Index::within`], [`Index::nearest`] |
//! | which engine will run, and why | [`Detector::plan`] |
//! | also the rows, the memory and the expected number of couples | [`Detector::explain`], [`PeriodicSearch::explain`] |
//! | only the fastest search | [`Rows`] |
//! | Munjiza-NBS as in the book, its memory law, its figures | [`Nbs`], [`Observer`] |
//! | elements that span many cells: the C-grid of Williams, Perkins and Cook | [`CGrid`] |
//! | a reference by brute force | [`Direct`] |
//! | which bodies touch in a labelled image: pixels, voxels | [`image::contacts`], [`image::ImageContacts`] |
//! | to check a couple list by brute force on a sample | [`verify()`] |
//! | whether two shapes touch, where and how deep: spheres, planes, segments, capsules, triangles, polygons, tetrahedra, boxes | [`narrow`] |
//! | which meshed bodies touch, element by element and body by body; spheres against walls | [`discretised`] |
//!
//! # Guarantees
//! - **Exact or an error.** Every couple that touches is reported, once; there is no limit on their number and no silent loss. Touching is
//!   defined to the last bit ([`Elements`]), and every engine takes the same decision.
//! - **Deterministic.** The order of the couples is a function of the input alone.
//! - **Checked.** NaN, infinity, negative radii, arrays of different lengths and domains that are too wide give an [`Error`] that names the
//!   element, before anything is computed.
//! - **Any dimension.** `[T; D]` for every `D` of at least 1, in `f32` and `f64`.
//!
//! This crate reads no files, prints nothing and contains no physics. It depends on robust, whose exact predicates [`narrow`] uses, and
//! behind the feature `rayon` (on by default) on rayon and, on Linux, rustix. Without that feature a search runs on one thread, with the
//! same results.
//!
//! # Unsafe code
//! Vector kernels, in `src/simd.rs` and the files below it, use vector instructions and pointers. Threads write to one array in `src/search/rows/scatter.rs`, which
//! `src/search/rows/layout.rs` uses, and to one list in `src/ordered.rs`. No other file has unsafe code, and no safe function relies on its caller. CI runs the kernels under valgrind, and everything
//! but the vector instructions under Miri.
//!
//! # Data flow
//! [`Elements`] → [`Grid`] (cells) → [`Lists`] → [`CONTACT_MASK`] → [`Search`] ([`Direct`], [`Nbs`], [`Rows`], [`Multilevel`], [`CGrid`]) → [`Couple`].

// In the order in which data flows.
mod memory;
mod real;
mod filter;
mod geometry;
mod elements;
mod grid;
mod lists;
mod mask;
mod search;
mod simd;
mod stop;
mod pool;
mod ordered;
mod engine;
mod explain;
mod detector;
mod buffer;
mod periodic;
mod index;
mod couple;
mod csr;
mod verify;
pub mod narrow;
pub mod discretised;
pub mod image;
mod error;

pub use buffer::{Buffered, Reason, Update};
pub use couple::{Couple, CrossCouple};
pub use csr::Csr;
pub use detector::Detector;
pub use elements::Elements;
pub use engine::{Engine, Plan};
pub use error::Error;
pub use explain::Explanation;
pub use filter::{Filter, GroupMatrix};
pub use grid::Grid;
pub use index::Index;
pub use lists::{Lists, NONE};
pub use mask::{CONTACT_MASK, Set, mask_cells};
pub use periodic::buffered::PeriodicBuffered;
pub use periodic::cell::PeriodicBox;
pub use periodic::{DEFAULT_MAX_IMAGES, PeriodicCouple, PeriodicSearch};
pub use real::Real;
pub use search::Search;
pub use search::cgrid::CGrid;
pub use search::direct::Direct;
pub use search::level::Level;
pub use search::multilevel::{Multilevel, Work};
pub use search::nbs::{DEFAULT_MAX_HEADS, Nbs, Observer};
pub use search::rows::Rows;
pub use simd::Simd;
pub use verify::{Mismatch, verify};

/// All couples among spheres (discs in 2D) that touch, in ascending order.
///
/// The engine is chosen from the elements; a [`Detector`] reuses its memory and says which engine and why.
///
/// # Shapes
/// `centres` `[n]` points `[T; D]`, `radii` `[n]`; result: `m` couples, `i < j`, each once, sorted by `i`, then `j`.
///
/// # Units
/// One length unit for both.
///
/// # Cost
/// Time proportional to `n`, plus the time to sort the couples.
///
/// # Errors
/// The errors of [`Elements::spheres_with_radii`] and of [`Search::for_each`].
///
/// # Example
/// ```
/// let discs = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]];
/// let couples = fdem_contact::couples(&discs, &[1.0, 2.0, 2.0])?;
/// assert_eq!(couples.len(), 2);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
pub fn couples<T: Real, const D: usize>(centres: &[[T; D]], radii: &[T]) -> Result<Vec<Couple>, Error> {
    sorted(&Elements::spheres_with_radii(centres, radii)?)
}

/// All couples of points that are at most `cutoff` apart, in ascending order.
///
/// # Shapes
/// `points` `[n]` points `[T; D]`; result: `m` couples, `i < j`, each once, sorted by `i`, then `j`.
///
/// # Units
/// One length unit for both.
///
/// # Cost
/// Time proportional to `n` plus the number of couples, plus the time to sort them.
///
/// # Errors
/// The errors of [`Elements::points`] and of [`Search::for_each`].
///
/// # Example
/// ```
/// let points = [[0.0_f32, 0.0], [1.0, 0.0], [5.0, 5.0]];
/// assert_eq!(fdem_contact::couples_within(&points, 1.0)?.len(), 1);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "neighbour list")]
pub fn couples_within<T: Real, const D: usize>(points: &[[T; D]], cutoff: T) -> Result<Vec<Couple>, Error> {
    sorted(&Elements::points(points, cutoff)?)
}

fn sorted<T: Real, const D: usize>(elements: &Elements<'_, T, D>) -> Result<Vec<Couple>, Error> {
    let mut couples = Vec::new();
    Detector::new().couples(elements, &mut couples)?;
    couples.sort_unstable();
    Ok(couples)
}
