//! Seeded clouds, packings and figures of the book, as plain arrays.
//!
//! | scene | content | for |
//! |---|---|---|
//! | [`gas`] | uniform random centres, with a given mean number of contacts | speed against `n` and density |
//! | [`clusters`] | gases far apart in a wide domain | searches that must not allocate the empty space |
//! | [`boxes`] | axis-aligned boxes of mixed aspect, uniform random | bounding boxes of any shape |
//! | [`lattice`], [`jittered_lattice`] | square or cubic grids | exact touching, cell faces |
//! | [`deposit`] | 2D discs dropped and rolled to rest | a bed whose discs support one another |
//! | [`book`] | packings A to D and the worked figures | the book's examples and curves |
//! | [`peers`] | the sets on which other libraries were timed | comparisons |
//!
//! A scene is a [`Cloud`] of centres and radii. [`Sizes`] defines how the radii are drawn.
//!
//! **The same seed gives the same bits on every platform.** The code uses only IEEE addition, subtraction,
//! multiplication, division and square root of `std`. Transcendental functions come from the portable crate
//! `libm`, and random bits from ChaCha8 through [`random::Random`]. Centres and radii come from separate
//! streams of the seed, so another size distribution does not change the random part of the centres. (Rust's
//! 32-bit x86 targets without SSE2 do not round as IEEE requires and are excluded.)
//!
//! ```
//! use fdem_scenes::{Sizes, gas};
//!
//! let cloud = gas::<3>(1_000, 42, 12.0, Sizes::Equal { radius: 0.5 })?;
//! assert_eq!(cloud.len(), 1_000);
//! assert_eq!(cloud, gas::<3>(1_000, 42, 12.0, Sizes::Equal { radius: 0.5 })?);
//! # Ok::<(), fdem_scenes::Error>(())
//! ```

mod bed;
pub mod book;
mod boxes;
mod cloud;
mod clusters;
mod deposit;
mod error;
mod gas;
mod lattice;
pub mod peers;
pub mod random;
mod sizes;

pub use boxes::{Boxes, boxes};
pub use cloud::Cloud;
pub use clusters::clusters;
pub use deposit::deposit;
pub use error::Error;
pub use gas::{gas, gas_edge};
pub use lattice::{jittered_lattice, lattice};
pub use sizes::Sizes;
