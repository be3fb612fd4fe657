//! Pictures of frames: coloured elements, outlines, and cracks as lines. All pictures of a series have the
//! same view and the same colour scale.

use std::collections::BTreeMap;
use std::fmt::Write;

use fdem_io::numbers::{brief, grouped};

use crate::fields::colours::{NO_VALUE, numbered_colour};
use crate::fields::field::Field;
use crate::fields::range::Range;
use crate::picture::colour::{Rgb, hex, mix};
use crate::picture::encode::{self, Layer};
use crate::picture::flat::Flat;
use crate::picture::furniture::{self, BAR, FOOT, HEAD};
use crate::picture::svg::{Anchor, INK, PALE, Svg};
use crate::picture::text::{OF_TITLES, fitting};
use crate::picture::ticks::{tick_text, ticks};
use crate::picture::{PictureError, drawing};
use crate::run::frame::{CrackKind, Frame, FrameError, Opened};
use crate::run::grains::drawing::{GrainScene, WALL, elements_and_spheres};
use crate::run::outlines::{OF_BODIES, OF_GRAINS, edges};
use crate::run::unit::prefixed;

const MARGIN: f64 = 24.0;
/// Greatest size and least width of the drawing area. With its margins, a picture is at most 900 wide.
const MOST: [f64; 2] = [852.0, 700.0];
const NARROWEST: f64 = 620.0;

/// Maximum number of triangles that are drawn as vectors. More are drawn as an image, which browsers open
/// faster.
const MOST_VECTORS: usize = 20_000;

/// Names and colours of cracks in tension, in shear and in mixed mode, and of joints that are open from the
/// start, in the order of [`CrackKind::code`], of whole joints, and of joints that soften. No field has these
/// colours, and a white seam separates the cracks from the elements.
pub(crate) const CRACKS: [(&str, Rgb); 6] = [
    ("tension", [17, 24, 39]),
    ("shear", [200, 0, 170]),
    ("mixed", [232, 116, 0]),
    ("open", [110, 116, 124]),
    ("whole", [0, 122, 78]),
    ("softening", [118, 66, 200]),
];
/// Places of whole joints and of joints that soften in [`CRACKS`].
pub(crate) const HOLDING: [usize; 2] = [4, 5];
/// Widths of whole joints and of joints that soften. They have no seam.
const WIDTHS: [f64; 2] = [1.2, 1.8];

/// Samples along the side of a pixel.
const SAMPLES: usize = 2;

const CRACK: f64 = 2.0;
const SEAM: f64 = 4.0;

/// Colours and greatest widths of the outlines of bodies and of grains.
pub(crate) const OUTLINES: [(Rgb, f64); 2] = [([31, 41, 51], 1.3), ([84, 94, 104], 0.8)];
/// Greatest width of an outline, as a share of the size of the bodies or grains.
pub(crate) const OUTLINE: f64 = 0.06;
/// Outlines narrower than this are not drawn: they would only darken the colours.
pub(crate) const NARROWEST_OUTLINE: f64 = 0.12;

/// The part of the plane that all pictures of a series show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameView {
    low: [f64; 2],
    high: [f64; 2],
    /// The latest time of the frames, which determines the unit and the decimals of times.
    last: f64,
}

impl FrameView {
    /// Returns a view of all frames. It reaches beyond the first frame that has half of all spheres by at
    /// most half of the longer side of that frame. Fragments that fly farther leave the picture.
    pub fn of<'a>(frames: impl IntoIterator<Item = &'a Frame>) -> Self {
        let (mut last, mut bounds) = (0.0_f64, Vec::new());
        for (k, frame) in frames.into_iter().enumerate() {
            last = if k == 0 { frame.time } else { last.max(frame.time) };
            bounds.push((frame.extent(), frame.counts()));
        }
        let [x, y] = extent(bounds);
        Self { low: [x[0], y[0]], high: [x[1], y[1]], last }
    }

    /// Returns the centre, and the distances from the centre to the sides, m. At least one distance is above
    /// zero, even if the view has no extent.
    pub(crate) fn middle_and_half(&self) -> ([f64; 2], [f64; 2]) {
        let half = [0, 1].map(|axis| (self.high[axis] - self.low[axis]) / 2.0);
        let middle = [0, 1].map(|axis| self.low[axis] + half[axis]);
        let good = half[0].max(half[1]) > 0.0 && half.iter().chain(&middle).all(|x| x.is_finite());
        if good { (middle, half) } else { ([0.0; 2], [1.0; 2]) }
    }

    /// Returns a time as text, with the same unit and number of decimals for all frames.
    pub(crate) fn time(&self, time: f64) -> String {
        time_text(time, self.last)
    }
}

/// Returns the least and the greatest coordinate on each axis that a view of frames with these bounds shows:
/// beyond a first frame by at most half of its longest side. Spheres may come in, so that this is the first
/// frame with at least half of all elements and spheres that any of them has. Frames with neither do not
/// count. `frames`: the bounds of each, and its numbers of elements and of spheres.
pub(crate) fn extent<const D: usize>(
    frames: impl IntoIterator<Item = ([[f64; 2]; D], [usize; 2])>,
) -> [[f64; 2]; D] {
    let frames =
        frames.into_iter().map(|(bounds, [elements, spheres])| (bounds, elements.saturating_add(spheres)));
    let frames: Vec<([[f64; 2]; D], usize)> = frames.collect();
    let all = frames.iter().map(|(_, count)| *count).max().unwrap_or(0);
    let Some(&(first, _)) = frames.iter().find(|(_, count)| *count >= all.div_ceil(2)) else {
        return [[0.0, 1.0]; D];
    };
    let most = first.iter().map(|[low, high]| high - low).fold(0.0, f64::max) / 2.0;
    frames.into_iter().filter(|(_, count)| all == 0 || *count > 0).fold(first, |extent, (bounds, _)| {
        std::array::from_fn(|axis| {
            let ([low, high], [least, largest]) = (extent[axis], bounds[axis]);
            [low.min(least).max(first[axis][0] - most), high.max(largest).min(first[axis][1] + most)]
        })
    })
}

/// Returns a time as text, with a unit and a number of decimals for all times up to `last`.
pub(crate) fn time_text(time: f64, last: f64) -> String {
    let (factor, unit) = prefixed("s", last);
    let decimals = match last * factor {
        last if last >= 100.0 => 1,
        last if last >= 10.0 => 2,
        _ => 3,
    };
    format!("{:.decimals$} {unit}", time * factor)
}

/// Settings of the pictures of a series.
///
/// # Example
/// ```
/// use fdem_results::{Field, Frame, FrameView, Pictures, Range};
/// use fdem_simulation::Snapshot;
///
/// let snapshot = Snapshot {
///     positions: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
///     displacements: vec![[0.0; 2]; 3],
///     velocities: vec![[0.0; 2]; 3],
///     elements: vec![[0, 1, 2]],
///     stresses: vec![[1e6, 0.0, 0.0, 0.0, 0.0, 0.0]],
///     damage: vec![0.0],
///     bodies: vec![0],
///     materials: vec![0],
///     fragments: vec![0],
///     ..Snapshot::default()
/// };
/// let frames = [Frame::new(&snapshot)?];
/// let field = Field::VON_MISES;
/// let pictures =
///     Pictures { title: "a triangle", field, range: Range::of(&frames, field), view: FrameView::of(&frames) };
/// assert!(pictures.svg(&frames[0])?.contains("von Mises stress (MPa)"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Pictures<'a> {
    /// Title.
    pub title: &'a str,
    /// Field by which elements are coloured.
    pub field: Field,
    /// Values at the ends of the colour scale.
    pub range: Range,
    /// Part of the plane that is shown.
    pub view: FrameView,
}

impl Pictures<'_> {
    /// Returns a frame as SVG. More than 20,000 elements are embedded as an image.
    ///
    /// # Errors
    /// [`PictureError::Png`], also for a damaged frame; [`PictureError::TooWide`].
    pub fn svg(&self, frame: &Frame) -> Result<String, PictureError> {
        let (page, opened, grains) = (self.page()?, opened(frame)?, self.grains(frame)?);
        let mut svg = self.sheet(&page, frame);
        svg.background();
        let shapes = frame.elements + grains.spheres.len() + grains.chains.len() + grains.walls.len();
        if shapes > MOST_VECTORS {
            let scale = drawing::scale(None, page.size[0])?;
            let layer = self.layer(&page, (&opened, &grains), scale);
            let png = encode::file(layer.size.map(|side| side as u32), &layer.pixels)?;
            svg.image([MARGIN, HEAD], page.area, &png);
        } else {
            self.vectors(&page, &opened, &mut svg);
            grain_vectors(&page, &grains, &mut svg);
        }
        self.surroundings(&page, frame, &mut svg);
        Ok(svg.finish())
    }

    /// Returns a frame as a PNG file, `width` pixels wide (200 to 10,000). Without a width it is as wide as
    /// the SVG (at most 900).
    ///
    /// # Errors
    /// The errors of [`Self::svg`]; [`PictureError::Width`].
    pub fn png(&self, frame: &Frame, width: Option<u32>) -> Result<Vec<u8>, PictureError> {
        let (size, pixels) = self.pixels(frame, width)?;
        encode::file(size, &pixels)
    }

    /// Returns the picture of [`Self::png`] as its width and height, and red, green and blue of each pixel,
    /// row by row.
    pub(crate) fn pixels(
        &self,
        frame: &Frame,
        width: Option<u32>,
    ) -> Result<([u32; 2], Vec<u8>), PictureError> {
        let (page, opened, grains) = (self.page()?, opened(frame)?, self.grains(frame)?);
        let scale = if width.is_some() { drawing::scale(width, page.size[0])? } else { 1.0 };
        let mut svg = self.sheet(&page, frame);
        self.surroundings(&page, frame, &mut svg);
        encode::pixels(&svg.finish(), &[self.layer(&page, (&opened, &grains), scale)], scale)
    }

    fn page(&self) -> Result<FrameLayout, PictureError> {
        let FrameView { low, high, .. } = self.view;
        let extent = [high[0] - low[0], high[1] - low[1]];
        if !extent.iter().all(|side| side.is_finite()) {
            return Err(PictureError::TooWide);
        }
        // The drawing has a margin of four units on each side.
        let fits =
            |axis: usize| if extent[axis] > 0.0 { (MOST[axis] - 8.0) / extent[axis] } else { f64::INFINITY };
        let scale = fits(0).min(fits(1));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let area = [(extent[0] * scale + 8.0).max(NARROWEST).round(), (extent[1] * scale + 8.0).round()];
        let middle = [low[0] + extent[0] / 2.0, low[1] + extent[1] / 2.0];
        Ok(FrameLayout { middle, scale, area, size: [area[0] + 2.0 * MARGIN, HEAD + area[1] + FOOT] })
    }

    fn sheet(&self, page: &FrameLayout, frame: &Frame) -> Svg {
        let name = format!("{} at {}", self.title, self.view.time(frame.time));
        let what = if frame.whole == 0 && !frame.grains.is_empty() { "Discs" } else { "Elements" };
        let description = format!("{what} coloured by {}; {}.", self.field.name(), self.sentence(frame));
        Svg::new(page.size[0], page.size[1], &name, &description)
    }

    /// Returns a sentence with the time, the step and the counts of a frame.
    fn sentence(&self, frame: &Frame) -> String {
        let mut text = format!(
            "t = {}, step {}, {}",
            self.view.time(frame.time),
            grouped(frame.step),
            elements_and_spheres(frame.whole, &frame.grains)
        );
        let total: f64 = frame.lengths.iter().sum();
        if total > 0.0 {
            let (factor, unit) = prefixed("m", total);
            // Writing to a string does not fail.
            let _ = write!(text, ", {} {unit} of cracks", brief((total * factor * 100.0).round() / 100.0));
        }
        text
    }

    fn colour(&self, opened: &Opened, element: usize) -> Rgb {
        match (self.field.scale(), self.field.number()) {
            (Some(scale), _) => self.field.colour(opened.values[scale][element], self.range),
            (None, Some(number)) => numbered_colour(opened.numbers_of(number)[element]),
            (None, None) => NO_VALUE,
        }
    }

    /// Returns the outlines of bodies (`kind` 0) or grains (1) as lines in units of the drawing, and their
    /// width.
    fn outlines(page: &FrameLayout, opened: &Opened, kind: usize) -> (Vec<[[f64; 2]; 2]>, f64) {
        let mask = [OF_BODIES, OF_GRAINS][kind];
        let line = |(element, corner): (usize, usize)| {
            let corners = opened.corners[element];
            [corners[corner], corners[(corner + 1) % 3]].map(|end| page.place(end))
        };
        let lines: Vec<[[f64; 2]; 2]> = edges(&opened.outlines, mask)
            .map(line)
            .filter(|line| line.as_flattened().iter().all(|x| x.is_finite()))
            .collect();
        // Four times the area over the circumference is the diameter of a disc.
        let double =
            |[a, b, c]: [[f64; 2]; 3]| ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        let area =
            opened.corners.iter().map(|&corners| 0.5 * double(corners)).filter(|area| area.is_finite());
        let area = area.sum::<f64>() * page.scale * page.scale;
        let length: f64 = lines.iter().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum();
        let size = 4.0 * area / length.max(f64::MIN_POSITIVE);
        (lines, OUTLINES[kind].1.min(OUTLINE * size))
    }

    /// Draws elements, outlines and cracks as pixels.
    fn layer(&self, page: &FrameLayout, (opened, grains): (&Opened, &GrainScene), scale: f64) -> Layer {
        let size = page.area.map(|side| (side * scale).round() as usize);
        let mut fill = Flat::new(size, SAMPLES);
        let scaled = |[x, y]: [f64; 2]| [x * scale, y * scale];
        let pixel = |point: [f64; 2]| scaled(page.place(point));
        for (element, [a, b, c]) in opened.corners.iter().enumerate() {
            fill.triangle([pixel(*a), pixel(*b), pixel(*c)], self.colour(opened, element));
        }
        // Grains come first, so that outlines of bodies lie above them.
        for kind in [1, 0] {
            let (lines, width) = Self::outlines(page, opened, kind);
            if width < NARROWEST_OUTLINE {
                continue;
            }
            for [a, b] in lines {
                // A line narrower than a sample would have holes.
                fill.square_line([scaled(a), scaled(b)], (width * scale).max(0.5), OUTLINES[kind].0);
            }
        }
        for ((joints, width), kind) in
            [&opened.intact, &opened.softening].into_iter().zip(WIDTHS).zip(HOLDING)
        {
            for ends in joints {
                fill.square_line(ends.map(pixel), width * scale, CRACKS[kind].1);
            }
        }
        for (ends, _) in &opened.cracks {
            fill.square_line(ends.map(pixel), SEAM * scale, [255; 3]);
        }
        for (ends, kind) in &opened.cracks {
            fill.square_line(ends.map(pixel), CRACK * scale, crack_colour(*kind));
        }
        draw_grains(&mut fill, page, grains, scale);
        Layer { at: [MARGIN, HEAD], size, pixels: fill.into_pixels() }
    }

    /// Decompresses the spheres and walls.
    fn grains(&self, frame: &Frame) -> Result<GrainScene, PictureError> {
        let scene = GrainScene::new(&frame.grains, self.field, self.range);
        scene.ok_or_else(|| PictureError::Png { message: FrameError::Damaged.to_string() })
    }

    /// Draws elements, outlines and cracks as paths, one for each colour.
    fn vectors(&self, page: &FrameLayout, opened: &Opened, svg: &mut Svg) {
        let mut paths: BTreeMap<Rgb, String> = BTreeMap::new();
        for (element, corners) in opened.corners.iter().enumerate() {
            let [a, b, c] = corners.map(|corner| page.place(corner));
            if [a, b, c].iter().flatten().all(|x| x.is_finite()) {
                let path = paths.entry(self.colour(opened, element)).or_default();
                // Writing to a string does not fail.
                let _ =
                    write!(path, "M{:.2} {:.2}L{:.2} {:.2}L{:.2} {:.2}Z", a[0], a[1], b[0], b[1], c[0], c[1]);
            }
        }
        svg.put(format_args!(
            r#"<svg x="{MARGIN}" y="{HEAD}" width="{0}" height="{1}" viewBox="0 0 {0} {1}"><g stroke-width="0.4" stroke-linejoin="round">"#,
            page.area[0], page.area[1]
        ));
        for (colour, path) in paths {
            let colour = hex(colour);
            svg.put(format_args!(r#"<path class="elements" fill="{colour}" stroke="{colour}" d="{path}"/>"#));
        }
        svg.put(format_args!(r#"</g><g fill="none" stroke-linecap="round">"#));
        for (kind, class) in [(1, "grains"), (0, "bodies")] {
            let (all, width) = Self::outlines(page, opened, kind);
            if width >= NARROWEST_OUTLINE && !all.is_empty() {
                let mut path = String::new();
                for [a, b] in all {
                    let _ = write!(path, "M{:.2} {:.2}L{:.2} {:.2}", a[0], a[1], b[0], b[1]);
                }
                svg.put(format_args!(
                    r#"<path class="{class}" d="{path}" stroke="{}" stroke-width="{width:.2}"/>"#,
                    hex(OUTLINES[kind].0)
                ));
            }
        }
        let mut lines: [String; CRACKS.len()] = Default::default();
        let kinds = opened.cracks.iter().map(|(ends, kind)| (ends, usize::from(kind.code())));
        let holding = [&opened.intact, &opened.softening].into_iter().zip(HOLDING);
        let holding = holding.flat_map(|(joints, kind)| joints.iter().map(move |ends| (ends, kind)));
        for (ends, kind) in kinds.chain(holding) {
            let [a, b] = ends.map(|end| page.place(end));
            if [a, b].iter().flatten().all(|x| x.is_finite()) {
                let _ = write!(lines[kind], "M{:.2} {:.2}L{:.2} {:.2}", a[0], a[1], b[0], b[1]);
            }
        }
        for (kind, width) in HOLDING.into_iter().zip(WIDTHS) {
            let (name, colour) = CRACKS[kind];
            let line = std::mem::take(&mut lines[kind]);
            if !line.is_empty() {
                svg.put(format_args!(
                    r#"<path class="{name}" d="{line}" stroke="{}" stroke-width="{width}"/>"#,
                    hex(colour)
                ));
            }
        }
        let all = lines.concat();
        if !all.is_empty() {
            svg.put(format_args!(r#"<path d="{all}" stroke="white" stroke-width="{SEAM}"/>"#));
        }
        for ((name, colour), line) in CRACKS.iter().zip(&lines).filter(|(_, line)| !line.is_empty()) {
            svg.put(format_args!(
                r#"<path class="{name}" d="{line}" stroke="{}" stroke-width="{CRACK}"/>"#,
                hex(*colour)
            ));
        }
        svg.put(format_args!("</g></svg>"));
    }

    /// Draws the title, the scale bar, the colour bar and the legend of the cracks.
    fn surroundings(&self, page: &FrameLayout, frame: &Frame, svg: &mut Svg) {
        let (title, size) = fitting(self.title, page.area[0], OF_TITLES, true);
        svg.bold([MARGIN, 30.0], size, &title);
        svg.label([MARGIN, 51.0], 12.5, Anchor::Start, PALE, &self.sentence(frame));
        let (right, foot) = (page.size[0] - MARGIN - 6.0, HEAD + page.area[1] + 12.0);
        let (factor, unit) = prefixed("m", 150.0 / page.scale);
        furniture::scale_bar(svg, &format!(" {unit}"), [MARGIN, foot], page.scale / factor);
        crack_legend(svg, [MARGIN + 215.0, foot], frame.lengths, frame.others);
        colour_bar(svg, self.field, self.range, [right, foot]);
    }
}

/// Greatest width of the outline of a disc, and its share of the radius.
const RIM: [f64; 2] = [0.8, 0.12];
/// Width of walls.
const WALL_WIDTH: f64 = 1.6;

/// Returns the width of the outline of a disc with this radius, units of the drawing.
fn rim(radius: f64) -> f64 {
    RIM[0].min(RIM[1] * radius)
}

/// Draws discs, walls and force chains as pixels.
fn draw_grains(fill: &mut Flat, page: &FrameLayout, grains: &GrainScene, scale: f64) {
    let pixel = |[x, y, _]: [f64; 3]| page.place([x, y]).map(|x| x * scale);
    for disc in &grains.spheres {
        let radius = disc.radius * page.scale;
        fill.disc(pixel(disc.centre), radius * scale, disc.colour, shaded(disc.colour), rim(radius) * scale);
    }
    for wall in &grains.walls {
        fill.line([pixel(wall.corners[0]), pixel(wall.corners[1])], WALL_WIDTH * scale, WALL);
    }
    for chain in &grains.chains {
        fill.line(chain.ends.map(pixel), 2.0 * chain.radius * page.scale * scale, chain.colour);
    }
}

/// Draws discs, walls and force chains as circles and lines.
fn grain_vectors(page: &FrameLayout, grains: &GrainScene, svg: &mut Svg) {
    if grains.spheres.is_empty() && grains.walls.is_empty() {
        return;
    }
    let at = |[x, y, _]: [f64; 3]| page.place([x, y]);
    svg.put(format_args!(
        r#"<svg x="{MARGIN}" y="{HEAD}" width="{0}" height="{1}" viewBox="0 0 {0} {1}"><g class="discs">"#,
        page.area[0], page.area[1]
    ));
    for disc in &grains.spheres {
        let ([x, y], radius) = (at(disc.centre), disc.radius * page.scale);
        svg.put(format_args!(
            r#"<circle cx="{x:.2}" cy="{y:.2}" r="{radius:.2}" fill="{}" stroke="{}" stroke-width="{:.2}"/>"#,
            hex(disc.colour),
            hex(shaded(disc.colour)),
            rim(radius)
        ));
    }
    svg.put(format_args!(r#"</g><g fill="none" stroke-linecap="round">"#));
    let mut path = String::new();
    for wall in &grains.walls {
        let [a, b] = [at(wall.corners[0]), at(wall.corners[1])];
        // Writing to a string does not fail.
        let _ = write!(path, "M{:.2} {:.2}L{:.2} {:.2}", a[0], a[1], b[0], b[1]);
    }
    if !path.is_empty() {
        svg.put(format_args!(
            r#"<path class="walls" d="{path}" stroke="{}" stroke-width="{WALL_WIDTH}"/>"#,
            hex(WALL)
        ));
    }
    for chain in &grains.chains {
        let [a, b] = chain.ends.map(at);
        svg.put(format_args!(
            r#"<path d="M{:.2} {:.2}L{:.2} {:.2}" stroke="{}" stroke-width="{:.2}"/>"#,
            a[0],
            a[1],
            b[0],
            b[1],
            hex(chain.colour),
            2.0 * chain.radius * page.scale
        ));
    }
    svg.put(format_args!("</g></svg>"));
}

/// Returns the colour of the outline of a disc.
fn shaded(colour: Rgb) -> Rgb {
    mix(colour, [0; 3], 0.42)
}

/// Draws a line and the name of each mode of cracks, of joints that are open from the start, that are whole
/// and that soften, if their total length or area is above 0.
pub(crate) fn crack_legend(svg: &mut Svg, [x, y]: [f64; 2], cracks: [f64; 3], others: [f64; 3]) {
    let totals = CRACKS.iter().zip(cracks.into_iter().chain(others));
    let shown: Vec<_> = totals.filter(|(_, total)| *total > 0.0).map(|(kind, _)| kind).collect();
    for (place, (name, colour)) in shown.iter().enumerate() {
        // Three names fit beside each other; more are in rows.
        let (line, text) = if shown.len() > 3 {
            let at = [x + 78.0 * (place / 3) as f64, y + 12.0 + 16.0 * (place % 3) as f64];
            (at, [at[0] + 25.0, at[1] + 4.0])
        } else {
            let x = x + 64.0 * place as f64;
            ([x, y + 20.0], [x, y + 42.0])
        };
        svg.put(format_args!(
            r#"<line x1="{0}" y1="{1}" x2="{2}" y2="{1}" stroke="{3}" stroke-width="3"/>"#,
            line[0],
            line[1],
            line[0] + 20.0,
            hex(*colour)
        ));
        svg.label(text, 12.0, Anchor::Start, INK, name);
    }
}

/// Draws the colour bar of a field, right-aligned.
pub(crate) fn colour_bar(svg: &mut Svg, field: Field, range: Range, [right, y]: [f64; 2]) {
    let (Range { low, high }, x) = (range, right - BAR);
    if !field.is_continuous() {
        svg.label([right, y + 10.0], 12.0, Anchor::End, INK, &format!("coloured by {}", field.name()));
        return;
    }
    let (factor, unit) = prefixed(field.unit(), high.abs().max(low.abs()));
    let unit = if unit.is_empty() { unit } else { format!(" ({unit})") };
    svg.label([x, y + 10.0], 12.0, Anchor::Start, INK, &format!("{}{unit}", field.name()));
    furniture::strips(svg, [x, y], |share| field.colour(low + share * (high - low), range));
    for tick in ticks(low * factor, high * factor, 4) {
        let at = x + (tick - low * factor) / ((high - low) * factor) * BAR;
        svg.line([at, y + 31.0], [at, y + 35.0], 1.0, INK);
        svg.label([at, y + 47.0], 11.5, Anchor::Middle, INK, &tick_text(tick));
    }
}

pub(crate) fn crack_colour(kind: CrackKind) -> Rgb {
    CRACKS[usize::from(kind.code())].1
}

fn opened(frame: &Frame) -> Result<Opened, PictureError> {
    frame.open().map_err(|error| PictureError::Png { message: error.to_string() })
}

/// Layout of a picture.
struct FrameLayout {
    /// The point in the middle of the area, m.
    middle: [f64; 2],
    /// Units of the drawing per metre.
    scale: f64,
    area: [f64; 2],
    size: [f64; 2],
}

impl FrameLayout {
    /// Returns the position of a point, from the upper left of the area.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.area[0] / 2.0 + (x - self.middle[0]) * self.scale,
            self.area[1] / 2.0 - (y - self.middle[1]) * self.scale,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::extent;

    #[test]
    fn spheres_that_come_in_set_the_view() {
        let still = [([[0.0, 2.0], [0.0, 1.0]], [5, 0]), ([[-9.0, 2.5], [0.0, 1.0]], [5, 0])];
        assert_eq!(extent(still), [[-1.0, 2.5], [0.0, 1.0]], "the first frame, and half of its side");
        // Without spheres a plane reaches far, and one of them is small.
        let poured = [
            ([[-50.0, 50.0], [-50.0, 50.0]], [0, 0]),
            ([[0.0, 0.01], [0.9, 0.91]], [0, 1]),
            ([[0.0, 1.0], [0.0, 1.0]], [0, 80]),
            ([[0.0, 1.0], [0.0, 1.2]], [0, 100]),
        ];
        assert_eq!(extent(poured), [[0.0, 1.0], [0.0, 1.2]]);
        assert_eq!(extent([([[-5.0, 5.0]], [0, 0])]), [[-5.0, 5.0]], "walls alone");
        assert_eq!(extent::<1>([]), [[0.0, 1.0]]);
    }
}
