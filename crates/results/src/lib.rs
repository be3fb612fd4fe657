//! Looking at contact networks and at runs: analysis, pictures, plots, animations, files for ParaView, and
//! pages for a browser.
//!
//! [`detection`] finds the couples of a packing. [`network`] is the input of [`analysis`] and [`picture`];
//! the results of a run ([`Frame`], [`History`], [`Pictures`]) are made from snapshots of `fdem-simulation`.
//! [`page`] makes both into pages. This crate makes text and bytes, and knows no paths.
//!
//! # How it is built
//!
//! `analysis::analyse` describes a `network::Network`; each part is a file below `src/analysis` with its
//! definitions and sources.
//!
//! `picture` draws a `Network`. `Scene` turns any network into three dimensions. Discs become SVG or pixels;
//! spheres and rods become pixels with depth (`src/picture/raster.rs`). resvg draws the other shapes of a PNG
//! above the pixels, and `src/picture/letters.rs` gives the outlines of the letters above them. Each pixel
//! depends only on operations that IEEE 754 rounds, on one thread. `report` puts the same network into one
//! page as compressed arrays. The page's scripts (`src/page`) are our own;
//! `crates/fdem/tests/browser/test_report.py` runs them in a browser.
//!
//! `fields` is one table of all quantities of a run, [`QUANTITIES`]. Files for ParaView, frames, pictures,
//! pages, model files, options of the command, the Python package and the book take keys, names, units,
//! colours and values from it. A [`Field`] is a row that colours elements.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | cut-offs by pairs of types | `src/pair_cutoffs.rs`; the option: `crates/fdem/src/command/cutoff.rs` |
//! | detection of couples, their statistics, the check by brute force | `src/detection.rs`, `src/detection/request.rs`, `src/detection/verify.rs` |
//! | analysis of a network | `src/analysis.rs`, then its part: `src/analysis/fabric.rs`, `src/analysis/clusters.rs` and so on; its lines in the summary: `crates/fdem/src/command/analyse.rs` |
//! | pictures: layout, colours, texts | `src/picture/drawing.rs`, `src/picture/colour.rs`, `src/picture/furniture.rs` |
//! | spheres and discs by pixel, the distributions | `src/picture/raster.rs`, `src/picture/flat.rs`, `src/picture/plots.rs` |
//! | the report: its numbers, its page, its view | `src/page/network.rs`, `src/page/network/page.html`, `src/page/network/view.js` |
//! | pictures of meshes in a plane | `src/picture/mesh.rs` |
//! | pictures of models before a run | `src/overview.rs`; its marks: `crates/fdem/src/command/check/picture.rs` |
//! | pictures of bodies of meshes, walls and images | `src/picture/bodies.rs`, `crates/fdem/src/command/shapes.rs` |
//! | a field: key, name, unit, sign, colours, value | `src/fields/table.rs`; the input of its value: `src/fields/state.rs` |
//! | results, plots and pictures | `src/run/vtk.rs`, `src/run/history.rs`, `src/run/plots.rs`, `src/run/pictures.rs` |
//! | curves of one column of a history over another, peak and modulus | `src/run/curves.rs` |
//! | acoustic emission: events, magnitudes, b-value | `src/run/emission.rs` |
//! | fragments: masses, table, distribution of sizes | `src/run/fragments.rs`; which elements hang together: `crates/simulation/src/topology.rs` |
//! | spheres, force chains and walls: data of frames, shapes, colours, files | `src/run/grains.rs`, `src/run/grains/frame.rs`, `src/run/grains/walls.rs`, `src/run/grains/drawing.rs`, `src/run/grains/vtk.rs`; their part of a page: `src/page/run/grains.rs`, `src/page/run/grains.js` |
//! | coarse graining of spheres | `src/run/grains/coarse.rs` |
//! | outlines, load-displacement axes, samples of large meshes | `src/run/outlines.rs`, `src/run/loads.rs`, `src/run/sample.rs` |
//! | the share of inertia in a peak load | `src/run/inertia.rs` |
//! | the common parts of all pages | `src/page.rs`, `src/page/shell.html`, `src/page/shared.js` |
//! | the page of a run | both dimensions: `src/page/run.rs`, `src/page/run/main.js`; two: `src/page/run/flat.rs`; three: `src/page/run/space.rs`, `src/page/run/space/view.js` |
//! | the page of a sweep | `src/page/sweep.rs`, `src/page/sweep/main.js`, `src/page/sweep/plot.js` |
//! | compressed frames | in two dimensions `src/run/frame.rs`; in three `src/space/frame.rs`, the visible parts `src/space/shell.rs` |
//! | pictures in three dimensions: settings, light and lines, sections, pixels | `src/space/pictures.rs`, `src/space/drawing.rs`, `src/space/section.rs`, `src/picture/raster.rs` |

mod arrays;
mod pair_cutoffs;
pub mod network;
pub mod detection;
pub mod analysis;
pub mod picture;
mod fields;
mod run;
mod space;
mod overview;
pub mod page;

pub use fields::{Field, LiquidIn, Place, QUANTITIES, Quantity, QuantityValues, Range, Span};
pub use overview::{BodyGroup, ModelDrawing, ModelMark, ModelPoint};
pub use page::run::MOST_FRAMES;
pub use page::run::flat::{MOST_ELEMENTS, Report, SAMPLE};
pub use page::run::space::SpaceReport;
pub use run::*;
pub use space::{Cut, MOST_INSIDE, Shell, Show, SpaceFrame, SpacePictures, SpaceView};
