//! Contact detection: finds which of N elements touch, in time and memory proportional to N at any packing
//! density.
//!
//! ```
//! let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [5.0, 5.0, 5.0]];
//! let radii = [0.5, 0.6, 0.5];
//! let couples = fdem_contact::couples(&centres, &radii)?; // touching counts, i < j, each couple once
//! assert_eq!(couples, [fdem_contact::Couple::new(0, 1)]);
//! # Ok::<(), fdem_contact::Error>(())
//! ```
//!
//! These are [`couples`] and [`couples_within`], the latter for points with a cut-off. Other tasks:
//!
//! | for | use |
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
//! - **Exact or an error.** Every couple that touches is reported, once; there is no limit on their number
//!   and no silent loss. Touching is defined to the last bit ([`Elements`]), and every engine takes the same
//!   decision.
//! - **Deterministic.** The order of the couples is a function of the input alone.
//! - **Checked.** NaN, infinity, negative radii, arrays of different lengths and domains that are too wide
//!   give an [`Error`] that names the element, before anything is computed.
//! - **Any dimension.** `[T; D]` for every `D` of at least 1, in `f32` and `f64`.
//!
//! This crate reads no files, prints nothing and contains no physics. It depends on robust, whose exact
//! predicates [`narrow`] uses, and behind the feature `rayon` (on by default) on rayon and, on Linux, rustix.
//! Without that feature a search runs on one thread, with the same results.
//!
//! # Unsafe code
//! Vector kernels, in `src/simd.rs` and the files below it, use vector instructions and pointers. Threads
//! write to one array in `src/search/rows/scatter.rs`, which `src/search/rows/layout.rs` uses, and to one
//! list in `src/ordered.rs`. Linux is advised to hold large arrays in huge pages in `src/memory/pages.rs`. No
//! other file has unsafe code, and no safe function relies on its caller. CI runs the kernels under valgrind,
//! and everything but the vector instructions and that advice under Miri.
//!
//! # How it is built
//!
//! **Input.** `Elements` borrows the caller's arrays, checks every number once, and defines "touch": which
//! floating-point operations, in which order, without fused multiply-add. A `Filter` says which elements see
//! each other. It is part of that definition, and engines that sort or copy elements sort and copy its
//! numbers too.
//!
//! **Grid.** `Grid` maps coordinates to cells, in `f64` for both float types. A cell is as wide as the
//! largest element plus a rounding step; the comment beside it proves that two touching elements are never
//! two cells apart. `Lists` holds the heads and next numbers of one axis. `CONTACT_MASK` has four entries of
//! data, which unfold to half of the 3^D - 1 neighbours.
//!
//! **Engines.** `Detector` picks an engine and gives the reason.
//!
//! - `Direct` compares all elements with each other. It is the oracle of the tests.
//! - `Nbs` is one recursion over the axes. For D = 2 and D = 3 it is the published procedure, and its
//!   comments mark the published steps.
//! - `Rows` is the default. It uses the same decomposition on contiguous memory: `Layout` sorts the elements
//!   into rows of cells and along the rows, and a kernel compares each row with itself and with the rows of
//!   the mask, one vector at a time. `Layout` first distributes the elements over blocks of rows and then
//!   sorts each block in cache; empty stretches of cells cost nothing. Where elements are few, cells are
//!   wider than the largest element, so that rows hold enough of them (`src/search/rows/sparse.rs`).
//! - `Multilevel` is for unlike sizes. It splits the elements into levels, each with a `Layout`, and scans
//!   the levels in pairs. A cost model chooses the levels, and which level of a pair searches in the other
//!   (`src/search/multilevel/levels.rs`). Spheres search one by one, each within its own reach, and less far
//!   along the rows that are farther away (`src/search/rows/reach.rs`).
//! - `CGrid` is for bodies that span many cells. They enter and leave singly connected lists by the ends of
//!   their boxes, axis by axis (`src/search/cgrid/lists.rs`). A couple is compared in the one cell where, on
//!   every axis, one body enters while the other is present. `src/search/cgrid/spans.rs` maps bodies to cells
//!   and proves that no couple is lost; `src/search/cgrid/levels.rs` moves large bodies to coarser cells.
//!   `Detector` takes `CGrid` only for long thin boxes, where it is predicted to be at least 6 times as fast
//!   as `Rows`. For spheres and compact boxes vectors on rows are faster (`bench/NOTES.md`, "Bodies that span
//!   cells").
//!
//! **Vectors.** The kernel compares four neighbouring elements together, in 32-bit coordinates relative to a
//! nearby point. Where such a distance is too close to decide, the exact comparison decides. The elements
//! that touch any of the four are first collected side by side, and their couples are read from there. The
//! head of `src/simd/cluster.rs` bounds the error and proves that no couple is lost or invented;
//! `tests/suite/doubt.rs` tests distances within 1e-16 of the limit.
//!
//! **Threads.** Every engine that sorts elements into rows produces `Scan`s (`src/search/rows/scan.rs`),
//! which threads run part by part. The parts do not depend on the number of threads; `src/pool.rs`
//! distributes them. All threads write one list, in the order of one thread: `src/ordered.rs` gives each part
//! its place as soon as the parts before it are done. Linux may wake a thread on the processor of the caller
//! while another processor is idle; `src/pool/spread.rs` moves it. A caller with its own pool shares it
//! (`Detector::on_pool`).
//!
//! **Two sets and points.** `Index` keeps a `Layout` whose cells follow the density. It sorts the other set,
//! or the points, into cells with the same faces, and runs the same kernels over rows of both.
//! `src/search/rows/reach.rs` finds the rows in reach and jumps over empty ones.
//!
//! **Periodic boxes.** `PeriodicSearch` wraps elements into a `PeriodicBox` and makes all images that may
//! touch them (`src/periodic/images.rs` has the margin and its proof). One `Detector` searches among the
//! elements, another among those near the faces and the images. Each couple is kept in one form, with its
//! shift.
//!
//! **Narrow phase.** `narrow` does not depend on searches. Constructors check shapes once; one function for
//! each pair of shapes returns a `Contact`: a point, a normal, and a gap, depth, length, area or volume.
//! Signs that decide topology are exact (`src/narrow/exact.rs`, the crate robust). The head of
//! `tests/suite/narrow.rs` lists the references of its tests.
//!
//! **Meshes.** `discretised::MeshSearch` combines both phases: a `Detector` finds couples of boxes, all
//! threads run the narrow phase on them, and `body_contacts` sums the results by body in the order of the
//! list (`src/discretised/bodies.rs`). Boxes of spheres against walls are enlarged by the rounding error of
//! the narrow phase (`src/discretised/spheres.rs`). `crates/fdem/src/command/meshes.rs` numbers the elements
//! and bodies of several files together.
//!
//! **Labelled images.** `image::ImageContacts` is separate: it compares each row of voxels with its neighbour
//! rows, one vector at a time (`src/image/row.rs`), and adds runs of equal pairs to a table of whole numbers
//! (`src/image/table.rs`), so that slabs and threads do not change the result. Areas, centroids and normals
//! follow at the end (`src/image/contact.rs`). `fdem-io` reads the planes (`crates/io/src/labels.rs`), and
//! `crates/fdem/src/command/labels.rs` connects the two.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | definition of contact, refused inputs | `src/elements.rs`, `src/geometry.rs`, `src/error.rs` |
//! | filters: bodies, groups, masks | `src/filter.rs` |
//! | periodic boxes: definition of contact, images | `src/periodic.rs`, `src/periodic/cell.rs`, `src/periodic/images.rs` |
//! | size of cells | `src/grid.rs`, `src/search/rows/sparse.rs` |
//! | the published algorithm | `src/search/nbs.rs`, `src/lists.rs`, `src/mask.rs` |
//! | the default engine: sorting, windows | `src/search/rows.rs`, `src/search/rows/layout.rs` |
//! | its input and order, for other devices | `src/search/rows/input.rs`, of two sets `src/index/input.rs` |
//! | levels for unlike sizes | `src/search/multilevel/levels.rs` |
//! | bodies that span cells: cells covered, order of lists | `src/search/cgrid.rs`, `src/search/cgrid/lists.rs` |
//! | running and joining the parts of a search | `src/search/rows/scan.rs`, `src/ordered.rs`, `src/pool.rs` |
//! | the threads of a search | `src/pool.rs`, `src/pool/others.rs`; under Miri `src/pool/miri.rs` |
//! | searches that are compiled with this crate | `src/compiled.rs` |
//! | vector instructions | `src/simd.rs`, `src/simd/task.rs`, `src/simd/vector.rs`, `src/simd/kernel.rs`; four elements at a time: `src/simd/cluster.rs` |
//! | the check of coordinates, the extremes of motions | `src/elements.rs`, `src/simd/extremes.rs` |
//! | the choice of an engine, a new engine | `src/detector.rs`, `src/engine.rs`, `src/search.rs` |
//! | the predictions of `explain` | `src/explain.rs` |
//! | two sets, elements around points, nearest elements | `src/index.rs`, `src/index/rows.rs`, `src/index/nearest.rs` |
//! | when moving elements are searched again | `src/buffer.rs`, in a periodic box `src/periodic/buffered.rs` |
//! | rows of neighbours from couples | `src/csr.rs` |
//! | the contact of two shapes | `src/narrow.rs`, then the shape: `src/narrow/sphere.rs`, `src/narrow/triangle.rs` and so on |
//! | contacts of a sphere on a mesh of triangles | `src/narrow/mesh.rs` |
//! | contacts of meshed bodies: overlap, shared boundary, point, normal | `src/discretised/bodies.rs` |
//! | elements of meshes, and their narrow phase | `src/discretised/element.rs` |
//! | contacts in a labelled image | `src/image.rs`, `src/image/contact.rs` |
//!
//! # Decisions, and departures from the book
//!
//! - The recursion of p. 128 serves all dimensions; 2D and 3D are not written out again.
//! - Boxes are mapped to cells by their minimum corner, not their centre: far from the origin the centre
//!   rounds by more than the box.
//! - "Old" is head + N as in (3.39), so readers decode; this limits NBS to 2^31 - 1 elements.
//! - Lists beyond the ends of an axis are empty by a bounds check; the heads are not padded, so the memory
//!   formula holds exactly.
//! - A new detection of `Buffered` does not start from the previous order: to gather the elements in it costs
//!   more than a better order saves, and so does keeping the rows and moving only the elements that have left
//!   them; both were built and measured (`bench/NOTES.md`, "From the previous order"). `Buffered` keeps only
//!   its memory.
//! - Elements without size (points with a cut-off of 0) have no natural cell; they get about one cell each.
//!
//! # Data flow
//! [`Elements`] → [`Grid`] (cells) → [`Lists`] → [`CONTACT_MASK`] → [`Search`] ([`Direct`], [`Nbs`],
//! [`Rows`], [`Multilevel`], [`CGrid`]) → [`Couple`].

// In the order in which data flows.
mod compiled;
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
#[cfg(feature = "rayon")]
mod awake;
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

#[cfg(feature = "rayon")]
#[doc(hidden)]
pub use awake::keep_awake;
pub use buffer::{Buffered, Reason, Update};
pub use couple::{Couple, CrossCouple};
pub use csr::Csr;
pub use detector::Detector;
pub use elements::Elements;
pub use engine::{Engine, Plan};
pub use error::Error;
pub use explain::Explanation;
pub use filter::{Filter, FilterNumbers, GroupMatrix};
pub use grid::Grid;
pub use index::Index;
pub use index::input::{CrossInput, IndexInput};
pub use lists::{Lists, NONE};
pub use mask::{CONTACT_MASK, Set, mask_cells};
pub use periodic::buffered::PeriodicBuffered;
pub use periodic::cell::PeriodicBox;
pub use periodic::reduced::ReducedBox;
pub use periodic::{DEFAULT_MAX_IMAGES, PeriodicCouple, PeriodicSearch};
pub use real::Real;
pub use search::Search;
pub use search::cgrid::CGrid;
pub use search::direct::Direct;
pub use search::level::Level;
pub use search::multilevel::{Multilevel, Work};
pub use search::nbs::{DEFAULT_MAX_HEADS, Nbs, Observer};
pub use search::rows::Rows;
pub use search::rows::input::{RowCells, RowsExtremes, RowsInput};
pub use simd::Simd;
#[doc(hidden)] // For `fdem-simulation`.
pub use simd::prefetch::value as prefetch;
pub use verify::{Mismatch, verify};

/// All couples among spheres (discs in 2D) that touch, in ascending order.
///
/// The engine is chosen from the elements; a [`Detector`] reuses its memory and says which engine and why.
///
/// # Shapes
/// `centres` `[n]` points `[T; D]`, `radii` `[n]`; result: `m` couples, `i < j`, each once, sorted by `i`,
/// then `j`.
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
