//! Pictures of frames in three dimensions. All pictures of a series have the same view and the same colour
//! scale.

use std::collections::BTreeSet;
use std::fmt::Write;

use fdem_io::numbers::{brief, grouped};

use crate::fields::colours::{NO_VALUE, numbered_colour};
use crate::fields::field::Field;
use crate::fields::range::Range;
use crate::picture::colour::{Rgb, hex};
use crate::picture::encode::{self, Layer};
use crate::picture::furniture::{self, FOOT, HEAD};
use crate::picture::svg::{Anchor, INK, PALE, Svg};
use crate::picture::text::{OF_TITLES, fitting};
use crate::picture::{PictureError, drawing::scale, raster};
use crate::run::frame::FrameError;
use crate::run::grains::drawing::{GrainScene, elements_and_spheres};
use crate::run::pictures::{CRACKS, HOLDING, colour_bar, crack_colour, crack_legend, time_text};
use crate::run::unit::prefixed;
use crate::space::drawing::{self, CRACK, CrackFacet, Edge, Facet, SpaceCamera, SpaceScene, Tetrahedron};
use crate::space::frame::SpaceFrame;
use crate::space::opened::OpenedSpace;
use crate::space::section::Plane;
use crate::space::view::SpaceView;

const MARGIN: f64 = 24.0;
/// Greatest size and least width of the drawing area. With its margins, a picture is at most 900 wide.
const MOST: [f64; 2] = [852.0, 640.0];
const NARROWEST: f64 = 700.0;
/// Space around the drawing in its area, on each side.
const EDGE: f64 = 8.0;

/// The visible parts of pictures in three dimensions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Show {
    /// The surface of the bodies, coloured by the field. Broken joints are dark lines where they reach the
    /// surface.
    #[default]
    Solid,
    /// The broken joints, coloured by their mode of failure. The bodies are transparent.
    Cracks,
}

/// A plane that cuts the bodies. The part on the side of the eye is taken away, and the section through the
/// elements is drawn in their colours. If the frame does not have the elements inside, the surface is seen
/// open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Normal of the plane. Without a length, nothing is cut.
    pub normal: [f64; 3],
    /// Product of the normal and a point of the plane: for a normal of length 1 the distance of the plane
    /// from the origin, m.
    pub offset: f64,
}

impl Cut {
    /// Returns the plane at a coordinate on an axis: 0, 1 or 2 for x, y or z. Another axis cuts nothing.
    pub fn across(axis: usize, at: f64) -> Self {
        Self { normal: std::array::from_fn(|k| f64::from(u8::from(k == axis))), offset: at }
    }

    /// Returns the plane with its normal to the eye. A plane that is seen from its edge keeps its direction.
    fn plane(self, view: &SpaceView) -> Option<Plane> {
        let eye = view.eye();
        let along = |other: [f64; 3]| (0..3).fold(0.0, |sum, axis| sum + self.normal[axis] * other[axis]);
        let square = along(self.normal);
        let good = square > 0.0 && square.is_finite() && self.offset.is_finite();
        let sign = if along(eye) < 0.0 { -1.0 } else { 1.0 };
        good.then(|| Plane { normal: self.normal.map(|x| sign * x), offset: sign * self.offset })
    }
}

/// Settings of the pictures of a series in three dimensions. The pictures need no display and no graphics
/// card, and their bytes are the same on every machine.
///
/// # Example
/// ```
/// use fdem_results::{Field, Range, Shell, Show, SpaceFrame, SpacePictures, SpaceView};
/// use fdem_simulation::{Mesh, Snapshot};
///
/// let mesh = Mesh {
///     nodes: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     elements: vec![[0, 1, 2, 3]],
///     bodies: vec![0],
///     materials: vec![0],
/// };
/// let snapshot = Snapshot {
///     positions: mesh.nodes.clone(),
///     displacements: vec![[0.0; 3]; 4],
///     velocities: vec![[0.0; 3]; 4],
///     elements: mesh.elements.clone(),
///     stresses: vec![[1e6, 0.0, 0.0, 0.0, 0.0, 0.0]],
///     damage: vec![0.0],
///     bodies: vec![0],
///     materials: vec![0],
///     fragments: vec![0],
///     ..Snapshot::default()
/// };
/// let frames = [SpaceFrame::new(&snapshot, &Shell::new(&mesh, &[]))?];
/// let field = Field::VON_MISES;
/// let pictures = SpacePictures {
///     title: "a tetrahedron",
///     field,
///     range: Range::of_space(&frames, field),
///     view: SpaceView::of(&frames).seen_from(20.0, 40.0),
///     show: Show::Solid,
///     cut: None,
/// };
/// assert!(pictures.svg(&frames[0])?.contains("von Mises stress (MPa)"));
/// assert!(pictures.png(&frames[0], Some(400))?.starts_with(b"\x89PNG"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SpacePictures<'a> {
    /// Title.
    pub title: &'a str,
    /// Field by which elements are coloured.
    pub field: Field,
    /// Values at the ends of the colour scale.
    pub range: Range,
    /// Part of space that is shown, and the direction from which it is seen.
    pub view: SpaceView,
    /// The parts that are shown.
    pub show: Show,
    /// Plane that cuts the bodies, if any.
    pub cut: Option<Cut>,
}

impl SpacePictures<'_> {
    /// Returns a frame as SVG: an image with texts, legends and scales around it.
    ///
    /// # Errors
    /// [`PictureError::Png`], also for a damaged frame; [`PictureError::TooWide`].
    pub fn svg(&self, frame: &SpaceFrame) -> Result<String, PictureError> {
        let (page, scene) = (self.page()?, self.scene(frame)?);
        let mut svg = self.sheet(&page, frame);
        svg.background();
        let layer = self.layer(&page, &scene, scale(None, page.size[0])?);
        let png = encode::file(layer.size.map(|side| side as u32), &layer.pixels)?;
        svg.image([MARGIN, HEAD], page.camera.size, &png);
        self.surroundings(&page, frame, &mut svg);
        Ok(svg.finish())
    }

    /// Returns a frame as a PNG file, `width` pixels wide (200 to 10,000). Without a width it is as wide as
    /// the SVG (at most 900).
    ///
    /// # Errors
    /// The errors of [`Self::svg`]; [`PictureError::Width`].
    ///
    /// # Cost
    /// One core, without encoding: about 0.1 s for 1200 × 900 pixels, and 0.1 s for 100,000 facets.
    pub fn png(&self, frame: &SpaceFrame, width: Option<u32>) -> Result<Vec<u8>, PictureError> {
        let (size, pixels) = self.pixels(frame, width)?;
        encode::file(size, &pixels)
    }

    /// Returns the picture of [`Self::png`] as its width and height, and red, green and blue of each pixel,
    /// row by row.
    pub(crate) fn pixels(
        &self,
        frame: &SpaceFrame,
        width: Option<u32>,
    ) -> Result<([u32; 2], Vec<u8>), PictureError> {
        let page = self.page()?;
        let scale = if width.is_some() { scale(width, page.size[0])? } else { 1.0 };
        let scene = self.scene(frame)?;
        let mut svg = self.sheet(&page, frame);
        self.surroundings(&page, frame, &mut svg);
        encode::pixels(&svg.finish(), &[self.layer(&page, &scene, scale)], scale)
    }

    fn page(&self) -> Result<SpaceLayout, PictureError> {
        let camera = SpaceCamera::fitting(self.view, MOST, NARROWEST, EDGE)?;
        let [width, height] = camera.size;
        Ok(SpaceLayout { camera, size: [width + 2.0 * MARGIN, HEAD + height + FOOT] })
    }

    fn sheet(&self, page: &SpaceLayout, frame: &SpaceFrame) -> Svg {
        let name = format!("{} at {}", self.title, time_text(frame.time, self.view.last));
        let what = match self.show {
            Show::Solid => {
                let what = if frame.whole == 0 && !frame.grains.is_empty() { "Spheres" } else { "Elements" };
                format!("{what} coloured by {}", self.field.name())
            }
            Show::Cracks => "Broken joints coloured by their mode of failure".to_owned(),
        };
        let cut = if self.cut.is_some() { ", cut by a plane" } else { "" };
        Svg::new(page.size[0], page.size[1], &name, &format!("{what}{cut}; {}.", self.sentence(frame)))
    }

    /// Returns a sentence with the time, the step and the counts of a frame.
    fn sentence(&self, frame: &SpaceFrame) -> String {
        let mut text = format!(
            "t = {}, step {}, {}",
            time_text(frame.time, self.view.last),
            grouped(frame.step),
            elements_and_spheres(frame.whole, &frame.grains)
        );
        if frame.cracks > 0 {
            // All bodies, also those that no one counts among the fragments. Writing to a string does not
            // fail.
            let plural = if frame.fragments == 1 { "" } else { "s" };
            let _ = write!(text, ", {} piece{plural}", grouped(frame.fragments as u64));
            let broken: f64 = frame.areas.iter().sum();
            if broken > 0.0 {
                let _ = write!(text, ", {} of cracks", area_text(broken));
            }
        }
        text
    }

    /// Returns the colour of an element.
    fn colour(&self, opened: &OpenedSpace, element: usize) -> Rgb {
        match (self.field.scale(), self.field.number()) {
            (Some(scale), _) => self.field.colour(opened.values[scale][element], self.range),
            (None, Some(number)) => numbered_colour(opened.numbers_of(number)[element]),
            (None, None) => NO_VALUE,
        }
    }

    /// Decompresses a frame into plain lists.
    fn scene(&self, frame: &SpaceFrame) -> Result<SpaceScene, PictureError> {
        let damaged = |error: FrameError| PictureError::Png { message: error.to_string() };
        let opened = frame.open().map_err(damaged)?;
        let grains = GrainScene::new(&frame.grains, self.field, self.range);
        let grains = grains.ok_or_else(|| damaged(FrameError::Damaged))?;
        let broken: BTreeSet<(usize, usize)> = opened.cracks.iter().flat_map(|crack| crack.facets).collect();
        // Ends of the edges at which cracks reach the surface. Facets beside them have the same corners.
        let mut traces = BTreeSet::new();
        for crack in &opened.cracks {
            for (corners, ends) in crack.sides.iter().zip(crack.traces) {
                for k in (0..3).filter(|&k| ends[k]) {
                    traces.insert(ends_of(corners[k], corners[(k + 1) % 3]));
                }
            }
        }
        let facets = opened.facets().map(|facet| {
            let edge = |k: usize| {
                let ends = [facet.corners[k], facet.corners[(k + 1) % 3]];
                match () {
                    () if !traces.is_empty() && traces.contains(&ends_of(ends[0], ends[1])) => Edge::Crack,
                    () if facet.angular[k] => Edge::Feature,
                    () if facet.between[k] => Edge::Grain,
                    () => Edge::Element,
                }
            };
            Facet {
                corners: facet.corners,
                colour: self.colour(&opened, facet.element),
                edges: [0, 1, 2].map(edge),
                broken: broken.contains(&(facet.element, facet.facet)),
            }
        });
        let facets = facets.collect();
        let tetrahedra = if self.cut.is_some() && opened.solid && self.show == Show::Solid {
            let tetrahedron = |element: usize| Tetrahedron {
                corners: opened.corners[element],
                colour: self.colour(&opened, element),
                facets: [0, 1, 2, 3].map(|facet| match opened.marks[element].seen(facet) {
                    true if broken.contains(&(element, facet)) => Edge::Crack,
                    true => Edge::Cut,
                    false => Edge::Element,
                }),
            };
            (0..opened.corners.len()).map(tetrahedron).collect()
        } else {
            Vec::new()
        };
        let cracks = opened
            .cracks
            .iter()
            .map(|crack| CrackFacet { corners: crack.middle(), colour: crack_colour(crack.kind) });
        let holding = [&opened.intact, &opened.softening].into_iter().zip(HOLDING);
        let holding = holding.flat_map(|(joints, kind)| {
            joints.iter().map(move |&corners| CrackFacet { corners, colour: CRACKS[kind].1 })
        });
        Ok(SpaceScene {
            facets,
            tetrahedra,
            cracks: cracks.chain(holding).collect(),
            closed: self.cut.is_none() || opened.solid,
            grains,
        })
    }

    /// Draws a scene as pixels.
    fn layer(&self, page: &SpaceLayout, scene: &SpaceScene, scale: f64) -> Layer {
        let size = page.camera.size.map(|side| (side * scale).round() as usize);
        let camera = page.camera.zoomed(scale);
        let cut = self.cut.and_then(|cut| cut.plane(&self.view));
        let mut layers = match self.show {
            // Bodies would hide force chains.
            Show::Solid if self.field != Field::FORCE_CHAINS => drawing::solid(scene, &camera, cut),
            _ => drawing::cracks(scene, &camera, cut),
        };
        if !scene.grains.walls.is_empty() {
            let [far, near] = drawing::walls(&scene.grains.walls, &camera, cut);
            if let Some(first) = layers.first_mut() {
                first.extend(far);
            }
            layers.push(near);
        }
        let beads = drawing::beads(&scene.grains, &camera, cut);
        Layer { at: [MARGIN, HEAD], size, pixels: raster::draw_with(size, &layers, &beads) }
    }

    /// Draws the title, the axes, the scale bar, the legend of the cracks and the colour bar.
    fn surroundings(&self, page: &SpaceLayout, frame: &SpaceFrame, svg: &mut Svg) {
        let (title, size) = fitting(self.title, page.camera.size[0], OF_TITLES, true);
        svg.bold([MARGIN, 30.0], size, &title);
        svg.label([MARGIN, 51.0], 12.5, Anchor::Start, PALE, &self.sentence(frame));
        let (right, foot) = (page.size[0] - MARGIN - 6.0, HEAD + page.camera.size[1] + 12.0);
        furniture::axes(svg, [MARGIN + 36.0, foot + 30.0], &self.view.triad());
        let (factor, unit) = prefixed("m", 150.0 / page.camera.scale);
        furniture::scale_bar(svg, &format!(" {unit}"), [MARGIN + 90.0, foot], page.camera.scale / factor);
        let legend = [MARGIN + 262.0, foot];
        match self.show {
            Show::Cracks => crack_legend(svg, legend, frame.areas, frame.others),
            Show::Solid => {
                if frame.cracks > 0 {
                    let [x, y] = legend;
                    svg.put(format_args!(
                        r#"<line x1="{x}" y1="{0}" x2="{1}" y2="{0}" stroke="{2}" stroke-width="2"/>"#,
                        y + 20.0,
                        x + 20.0,
                        hex(CRACK)
                    ));
                    svg.label(
                        [x, y + 42.0],
                        12.0,
                        Anchor::Start,
                        INK,
                        if frame.areas == [0.0; 3] { "open joints" } else { "cracks" },
                    );
                }
                colour_bar(svg, self.field, self.range, [right, foot]);
            }
        }
    }
}

/// Layout of a picture.
struct SpaceLayout {
    /// The camera of a picture with one pixel per unit of the drawing.
    camera: SpaceCamera,
    size: [f64; 2],
}

/// Returns the two ends of an edge in an order that does not depend on its direction.
fn ends_of(a: [f64; 3], b: [f64; 3]) -> [[u64; 3]; 2] {
    let [a, b] = [a, b].map(|point| point.map(|x| (x + 0.0).to_bits()));
    [a.min(b), a.max(b)]
}

/// Returns an area as text with two decimals at most: in m², cm² or mm².
fn area_text(area: f64) -> String {
    let (factor, unit) = match area {
        area if area >= 0.1 => (1.0, "m²"),
        area if area >= 1e-5 => (1e4, "cm²"),
        _ => (1e6, "mm²"),
    };
    format!("{} {unit}", brief((area * factor * 100.0).round() / 100.0))
}
