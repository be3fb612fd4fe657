//! Tests of the library from outside, by hazard.
//!
//! - `oracle`: every search equals all-against-all, for every dimension, float, shape and scene.
//! - `degenerate`: no elements, one element, all in one place, far away, NaN, infinity, arrays of different
//!   lengths, domains that are too wide.
//! - `properties`: laws that hold for any input (proptest): renumbering, mirroring, translation, tolerance,
//!   no repeats.
//! - `determinism`: one order of couples for any number of threads and any vector instructions.
//! - `order`: the order of the couples that the documentation states, for other devices.
//! - `multilevel`: unlike sizes, from points to bodies that cover everything: every choice of levels equals
//!   all-against-all, in one order.
//! - `reuse`: a search that is used again gives the list of a new one, whatever it searched before.
//! - `buffer`: moving elements: the couples of every update equal all-against-all, also at the limit of the
//!   buffer; when a detection is due.
//! - `csr`: compressed rows equal a map of sets, in any order, with repeats, values and malformed couples.
//! - `periodic`: periodic boxes, sheared or not, against all images one by one.
//! - `explain`: the prediction of a search, against the search.
//! - `filter`: bodies, masks and groups: every search finds the result of filtering its list afterwards, in
//!   the same order.
//! - `unsafe_code`: unsafe code is only in the files that the documentation lists.
//! - `two_sets`: an index against another set: shapes, sizes, tolerances, places; every element with every
//!   element.
//! - `queries`: elements around points, and the nearest ones, against the distances to all elements.
//! - `against_all`: no tests; shared parts of the two before. `random`: shared random numbers.
//! - `numbers`: coordinates of 1e12, more couples than 32 bits count, domains of 10^15 cells.
//! - `doubt`: distances at the limit and next to it, where the kernels must not rely on 32 bits; lattices and
//!   crowds.
//! - `equal_radii`: radii that are all equal, against radii of which one differs in its last digit.
//! - `golden`: the numbers printed in the book.
//! - `boxes`: boxes most of which are much shorter than the longest.
//! - `cgrid`: long bodies that span many cells; memory and work are bounded.
//! - `narrow`: the exact contact of a pair, against exact arithmetic, `parry` and `geo`.
//! - `discretised`: bodies of triangles and tetrahedra.
//! - `image`: bodies in a labelled image.
//! - `stop`: searches that another thread stops.
//! - `kernels`: the vector kernels on short rows, with every set of instructions; also under valgrind.
//! - `miri`: the unsafe code on few elements; also under Miri, as a program of its own.
//! - `../memory.rs`, a separate program because it counts allocations: the memory law.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

/// Tests of `$scenes` for both float types: all numbers of dimensions are among them, and not each with both,
/// because each pair takes seconds to compile.
macro_rules! for_all_types {
    ($scenes:ident) => {
        for_all_types! { $scenes;
            f64_1d: f64, 1; f64_2d: f64, 2; f64_3d: f64, 3; f64_4d: f64, 4; f64_6d: f64, 6;
            f32_2d: f32, 2; f32_3d: f32, 3; f32_5d: f32, 5;
        }
    };
    ($scenes:ident; $($name:ident: $type:ty, $dimensions:literal;)*) => {
        $(
            #[test]
            fn $name() {
                $scenes::<$type, $dimensions>();
            }
        )*
    };
}

mod against_all;
mod boxes;
mod buffer;
mod cgrid;
mod csr;
mod degenerate;
mod determinism;
mod discretised;
mod doubt;
mod equal_radii;
mod explain;
mod filter;
mod golden;
mod image;
mod kernels;
mod miri;
mod multilevel;
mod narrow;
mod numbers;
mod oracle;
mod order;
mod periodic;
mod properties;
mod queries;
mod random;
mod reuse;
mod stop;
mod two_sets;
mod unsafe_code;

use fdem_contact::{Couple, Elements, Engine, Real, Search};

/// All engines, and the one that is chosen.
const ENGINES: [Option<Engine>; 6] = [
    None,
    Some(Engine::Direct),
    Some(Engine::Nbs),
    Some(Engine::Rows),
    Some(Engine::Multilevel),
    Some(Engine::CGrid),
];

/// Whether tests that sample take all of their samples: `just thorough` sets `FDEM_THOROUGH`.
fn thorough() -> bool {
    std::env::var_os("FDEM_THOROUGH").is_some()
}

/// A test of a property with that many cases if it is thorough, otherwise with an eighth.
fn cases(all: u32) -> proptest::test_runner::Config {
    let cases = if thorough() { all } else { all / 8 };
    proptest::test_runner::Config { cases, ..Default::default() }
}

/// The couples of a search in ascending order; a couple that was found twice appears twice.
fn ascending<T: Real, const D: usize>(
    mut search: impl Search<T, D>,
    elements: &Elements<'_, T, D>,
) -> Vec<Couple> {
    let mut couples = Vec::new();
    search.couples(elements, &mut couples).unwrap();
    assert_eq!(search.count(elements).unwrap(), couples.len() as u64, "a second search finds the same");
    couples.sort_unstable();
    couples
}
