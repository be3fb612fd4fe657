//! Pictures of a packing and its contact network as SVG or PNG. They need no display and no graphics card,
//! and their bytes are the same in every run.
//!
//! ```text
//! Network ──> Scene ──┬─> discs, spheres, rods by pixel ─┐
//!                     ├─> discs and lines as SVG ────────┼─> SVG ──> PNG
//!                     └─> distributions ─────────────────┘
//! ```
//! [`svg`] and [`png()`] draw the elements and the contacts. [`plots_svg`] and [`plots_png`] draw the
//! distributions of contacts, overlaps, sizes and directions. [`mesh_svg`] and [`mesh_png`] draw meshed
//! bodies in a plane, [`bodies_svg`] and [`bodies_png`] bodies of any shape.

pub(crate) mod bodies;
pub(crate) mod camera;
mod capsule;
pub(crate) mod caption;
pub(crate) mod colour;
pub(crate) mod encode;
pub(crate) mod error;
pub(crate) mod flat;
pub(crate) mod furniture;
pub(crate) mod drawing;
pub(crate) mod letters;
pub(crate) mod mesh;
mod plots;
pub(crate) mod raster;
pub(crate) mod room;
pub(crate) mod scene;
pub(crate) mod svg;
pub(crate) mod text;
pub(crate) mod ticks;

use crate::network::Network;
use scene::Scene;

/// Draws elements and contacts as SVG.
///
/// In 2D the picture shows discs, white if they have no contact, and a line for each contact, coloured by its
/// overlap. In 3D it shows two views in parallel projection, turned by 30 degrees and tilted by 20 degrees:
/// the elements coloured by their number of contacts, and the contacts coloured by overlap. Larger overlaps
/// have wider lines. A contact across a face of the box is drawn as two halves. Points are drawn smaller than
/// their cut-off.
///
/// Texts are SVG text. Spheres, and more than 50,000 discs or contacts, which a browser would open slowly,
/// are an embedded image.
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
/// use fdem_contact::Couple;
/// use fdem_results::network::{Couples, Network, Sizes, Space};
/// use fdem_results::picture::{Caption, svg};
///
/// let centres = [[0.0, 0.0], [1.9, 0.0]];
/// let couples = Couples::Plain(vec![Couple::new(0, 1)]);
/// let space = Space { centres: &centres, cell: None };
/// let network = Network { space, sizes: Sizes::All(1.0), couples: &couples, forces: None };
/// let drawing = svg(&network, &Caption { title: "two discs", unit: Some("mm") })?;
/// assert_eq!(drawing.matches("<circle").count(), 2);
/// # Ok::<(), fdem_results::picture::PictureError>(())
/// ```
pub fn svg<const D: usize>(network: &Network<'_, D>, caption: &Caption<'_>) -> Result<String, PictureError> {
    room::check(room::of_scene(network))?;
    drawing::svg(&Scene::new(network, caption)?)
}

/// Like [`svg`], as a PNG file. `width`: 200 to 10,000 pixels, by default twice the width of the SVG.
///
/// # Errors
/// The errors of [`svg`], [`PictureError::Width`] and [`PictureError::Png`].
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

/// Draws the distributions of contacts, overlaps, sizes, directions of contacts and distances of centres as
/// SVG.
///
/// Each contact counts in both of its directions. In 2D, and for the azimuth in 3D, the radius of a sector is
/// its share of the contacts. For the inclination in 3D, it is this share over the share for isotropic
/// contacts, so that isotropy is a circle. Distances are shown by the radial distribution
/// [`crate::analysis::Radial`], up to 3 mean diameters.
///
/// # Errors
/// The errors of [`svg`].
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

/// Like [`plots_svg`], as a PNG file. `width`: as for [`png()`].
///
/// # Errors
/// The errors of [`png()`].
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
pub use caption::Caption;
pub use error::PictureError;
pub use mesh::{MeshDrawing, mesh_png, mesh_svg};

pub(crate) use drawing::preview;
pub(crate) use plots::{g_of_r, panels};
