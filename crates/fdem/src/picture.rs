//! Pictures of a packing and its contact network, as SVG or PNG: no display, no graphics card, the same bytes at every run.
//!
//! ```text
//! Network ──> Scene ──┬─> discs, spheres, rods by pixel ─┐
//!                     ├─> discs and lines as SVG ────────┼─> SVG ──> PNG
//!                     └─> distributions ─────────────────┘
//! ```
//! [`svg`] and [`png()`] draw the elements and the contacts, [`plots_svg`] and [`plots_png`] how contacts, overlaps, sizes and directions
//! are distributed. [`mesh_svg`] and [`mesh_png`] draw meshed bodies in a plane.

pub(crate) mod bodies;
pub(crate) mod camera;
mod capsule;
pub(crate) mod colour;
pub(crate) mod encode;
mod flat;
pub(crate) mod furniture;
pub(crate) mod drawing;
mod mesh;
mod plots;
mod raster;
pub(crate) mod room;
pub(crate) mod scene;
pub(crate) mod svg;
pub(crate) mod text;
pub(crate) mod ticks;

use std::fmt;

use crate::network::Network;
use scene::Scene;

/// What a picture says of where its network is from.
#[derive(Clone, Copy, Debug, Default)]
pub struct Caption<'a> {
    /// In the first line: the file, for example.
    pub title: &'a str,
    /// The unit of length, if it is known.
    pub unit: Option<&'a str>,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PictureError {
    /// Only 2D and 3D can be drawn.
    Dimensions {
        /// Those of the network.
        found: usize,
    },
    /// An element is nowhere, or has no size.
    NotFinite {
        /// Its place among the elements.
        index: usize,
    },
    /// The domain is wider than the largest number.
    TooWide,
    /// A PNG cannot be so wide.
    Width {
        /// Pixels that were asked for.
        found: u32,
        /// The fewest there may be.
        least: u32,
        /// The most.
        most: u32,
    },
    /// A report of so many would not open in a browser.
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many can be shown.
        most: usize,
    },
    /// There is no memory for the drawing.
    OutOfMemory {
        /// What it may take.
        bytes: usize,
    },
    /// The drawing could not be made a PNG file.
    Png {
        /// In the words of the library that was to do it.
        message: String,
    },
}

impl fmt::Display for PictureError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dimensions { found } => write!(out, "{found}D cannot be drawn, 2D and 3D can"),
            Self::NotFinite { index } => {
                write!(out, "element {index} has a coordinate or a radius that is not finite")
            }
            Self::TooWide => write!(out, "the domain is too wide to be drawn"),
            Self::Width { found, least, most } => {
                write!(out, "a PNG of {found} pixels is not possible, {least} to {most} are")
            }
            Self::TooMany { what, found, most } => {
                write!(out, "{found} {what} are too many for a report, which shows up to {most}")
            }
            Self::OutOfMemory { bytes } => {
                write!(out, "no memory for {bytes} bytes, which the drawing may take")
            }
            Self::Png { message } => write!(out, "the picture cannot be made a PNG: {message}"),
        }
    }
}

impl std::error::Error for PictureError {}

/// Elements and contacts as SVG.
///
/// In 2D discs, those without contact white, and a line for each contact, coloured by its overlap. In 3D two views along parallel rays,
/// turned by 30 degrees and seen 20 degrees from above: the elements coloured by their contacts, and the contacts by overlap. Lines are the
/// wider the larger the overlap. A contact across a face of the box is drawn as two halves. Points are drawn smaller than they reach.
///
/// Text is text. Spheres, and more discs than a browser opens with ease (50,000), are an image within.
///
/// # Errors
/// [`PictureError::Dimensions`], [`PictureError::NotFinite`], [`PictureError::TooWide`].
///
/// # Panics
/// If a couple was not found among these elements.
///
/// # Cost
/// Time proportional to the elements, the couples, and the pixels that they cover.
///
/// # Example
/// ```
/// use fdem::contact::Couple;
/// use fdem::network::{Couples, Network, Sizes, Space};
/// use fdem::picture::{Caption, svg};
///
/// let centres = [[0.0, 0.0], [1.9, 0.0]];
/// let couples = Couples::Plain(vec![Couple::new(0, 1)]);
/// let space = Space { centres: &centres, cell: None };
/// let network = Network { space, sizes: Sizes::All(1.0), couples: &couples };
/// let drawing = svg(&network, &Caption { title: "two discs", unit: Some("mm") })?;
/// assert_eq!(drawing.matches("<circle").count(), 2);
/// # Ok::<(), fdem::picture::PictureError>(())
/// ```
pub fn svg<const D: usize>(network: &Network<'_, D>, caption: &Caption<'_>) -> Result<String, PictureError> {
    room::check(room::of_scene(network))?;
    drawing::svg(&Scene::new(network, caption)?)
}

/// As [`svg`], as a PNG file: `width` pixels wide, 200 to 10,000, or twice as many as the SVG.
///
/// # Errors
/// Those of [`svg`], [`PictureError::Width`] and [`PictureError::Png`].
///
/// # Panics
/// If a couple was not found among these elements.
pub fn png<const D: usize>(
    network: &Network<'_, D>,
    caption: &Caption<'_>,
    width: Option<u32>,
) -> Result<Vec<u8>, PictureError> {
    room::check(room::of_scene(network))?;
    drawing::png(&Scene::new(network, caption)?, width)
}

/// How contacts, overlaps, sizes, the directions of contacts and the distances of centres are distributed, as SVG.
///
/// Directions are axes: each contact counts both ways. In 2D and of the azimuth in 3D the radius of a sector is its share of the contacts; of the
/// inclination in 3D it is that share over the one of contacts that prefer no direction, so that a circle is isotropy. Distances are shown by the
/// radial distribution [`crate::analysis::Radial`], up to 3 mean diameters.
///
/// # Errors
/// Those of [`svg`].
///
/// # Panics
/// If a couple was not found among these elements.
pub fn plots_svg<const D: usize>(
    network: &Network<'_, D>,
    caption: &Caption<'_>,
) -> Result<String, PictureError> {
    room::check(room::of_scene(network) + room::of_shapes(0))?;
    Ok(plots::svg(&Scene::new(network, caption)?, &g_of_r(network)))
}

/// As [`plots_svg`], as a PNG file, wide as [`png()`] is.
///
/// # Errors
/// Those of [`png()`].
///
/// # Panics
/// If a couple was not found among these elements.
pub fn plots_png<const D: usize>(
    network: &Network<'_, D>,
    caption: &Caption<'_>,
    width: Option<u32>,
) -> Result<Vec<u8>, PictureError> {
    room::check(room::of_scene(network))?;
    let scene = Scene::new(network, caption)?;
    let scale = drawing::scale(width, plots::whole_size(&scene)[0])?;
    room::check(room::of_pixels(plots::whole_size(&scene), scale))?;
    encode::png(&plots::svg(&scene, &g_of_r(network)), &[], scale)
}

pub use bodies::{
    Bodies, BodyJoint, MOST_FACETS, bodies_plots_png, bodies_plots_svg, bodies_png, bodies_svg,
};
pub use mesh::{MeshDrawing, mesh_png, mesh_svg};

pub(crate) use drawing::preview;
pub(crate) use plots::{g_of_r, panels};
