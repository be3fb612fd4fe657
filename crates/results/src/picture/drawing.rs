//! Drawing of elements and contacts: one area in 2D, two in 3D.

use std::ops::RangeInclusive;

use crate::picture::camera::{Camera, outline};
use crate::picture::colour::{HEAT, Rgb, at, hex};
use crate::picture::encode::{self, Layer};
use crate::picture::error::PictureError;
use crate::picture::flat::Flat;
use crate::picture::furniture::{self, Counts, FOOT, HEAD};
use crate::picture::raster::{GRID, Raster};
use crate::picture::room;
use crate::picture::scene::{Bond, Joint, Scene};
use crate::picture::svg::Svg;

/// Most discs or contacts that an SVG file has as shapes; more are an embedded image.
const MOST_SHAPES: usize = 50_000;

/// Default number of PNG pixels per unit of the drawing.
const SCALE: f64 = 2.0;

/// Widths of a PNG, pixels: a narrower one cannot be read, a wider one would need too much memory.
const WIDTHS: RangeInclusive<u32> = 200..=10_000;

const MARGIN: f64 = 24.0;

const TOUCHING: Rgb = [219, 228, 238];
const FREE: Rgb = [255, 255, 255];
const RIM: Rgb = [134, 149, 166];
const BOX: Rgb = [120, 130, 140];
/// Limits of the smallest radius at which elements are drawn, in pixels of the drawing, so that points and
/// tiny elements stay visible.
const DOTS: [f64; 2] = [0.6, 2.0];

/// Colour of elements in the view of the contacts.
const NODE: Rgb = [186, 193, 201];

pub(crate) fn svg(scene: &Scene) -> Result<String, PictureError> {
    let page = NetworkLayout::new(scene)?;
    let is_small = scene.centres.len().max(scene.bonds.len()) <= MOST_SHAPES;
    if scene.dimensions == 2 && is_small && scene.facets().next().is_none() {
        room::check(room::of_shapes(scene.centres.len() + 2 * scene.bonds.len()))?;
        return Ok(page.svg(|svg| page.shapes(svg)));
    }
    room::check(room::of_pixels(page.size, SCALE))?;
    let layers = page.layers(SCALE);
    let images = layers.iter().map(|layer| encode::file(layer.size.map(|n| n as u32), &layer.pixels));
    let images = images.collect::<Result<Vec<_>, _>>()?;
    Ok(page.svg(|svg| {
        svg.background();
        for (layer, image) in layers.iter().zip(&images) {
            svg.image(layer.at, page.camera.area, image);
        }
    }))
}

/// Draws a PNG, `width` pixels wide or twice as wide as the drawing.
pub(crate) fn png(scene: &Scene, width: Option<u32>) -> Result<Vec<u8>, PictureError> {
    let page = NetworkLayout::new(scene)?;
    let scale = scale(width, page.size[0])?;
    room::check(room::of_pixels(page.size, scale))?;
    page.png(scale)
}

/// Returns the number of pixels per unit of a drawing, for a width of a PNG.
pub(crate) fn scale(pixels: Option<u32>, width: f64) -> Result<f64, PictureError> {
    match pixels {
        None => Ok(SCALE),
        Some(pixels) if WIDTHS.contains(&pixels) => Ok(f64::from(pixels) / width),
        Some(found) => Err(PictureError::Width { found, least: *WIDTHS.start(), most: *WIDTHS.end() }),
    }
}

/// Draws a smaller PNG, for browsers that cannot show the 3D view.
pub(crate) fn preview(scene: &Scene) -> Result<Vec<u8>, PictureError> {
    NetworkLayout::new(scene)?.png(1.0)
}

/// Layout of a drawing.
struct NetworkLayout<'a> {
    scene: &'a Scene,
    camera: Camera,
    counts: Counts,
    /// Left edges of the areas.
    lefts: Vec<f64>,
    size: [f64; 2],
    /// Smallest radius of an element in pixels; larger if there are few elements.
    dot: f64,
}

impl<'a> NetworkLayout<'a> {
    fn new(scene: &'a Scene) -> Result<Self, PictureError> {
        let (least, most, areas) = if scene.dimensions == 2 {
            ([520.0, 60.0], [900.0, 860.0], 1)
        } else {
            ([470.0, 120.0], [600.0, 640.0], 2)
        };
        let camera = Camera::new(scene, least, most).ok_or(PictureError::TooWide)?;
        let [width, height] = camera.area;
        let lefts: Vec<f64> = (0..areas).map(|k| MARGIN + f64::from(k) * (width + 2.0 * MARGIN)).collect();
        let right = lefts.last().map_or(0.0, |left| left + width);
        Ok(Self {
            scene,
            camera,
            counts: Counts::new(&scene.coordination),
            lefts,
            size: [right + MARGIN, HEAD + height + FOOT],
            dot: (0.3 * (width * height / scene.centres.len().max(1) as f64).sqrt()).clamp(DOTS[0], DOTS[1]),
        })
    }

    fn png(&self, scale: f64) -> Result<Vec<u8>, PictureError> {
        encode::png(&self.svg(|_| ()), &self.layers(scale), scale)
    }

    /// Draws the texts over the drawing of `draw`.
    fn svg(&self, draw: impl FnOnce(&mut Svg)) -> String {
        let Self { scene, camera, .. } = self;
        let [width, height] = self.size;
        let description = format!("{}. {} {}.", furniture::counts(scene), self.description(), scene.value());
        let mut svg = Svg::new(width, height, &format!("Contact network of {}", scene.title), &description);
        draw(&mut svg);
        furniture::title(&mut svg, scene, MARGIN, width - 2.0 * MARGIN);
        let foot = HEAD + camera.area[1] + 12.0;
        let right = |k: usize| self.lefts[k] + camera.area[0] - 6.0;
        furniture::scale_bar(&mut svg, &scene.after_number(), [self.lefts[0], foot], camera.scale);
        if self.lefts.len() > 1 {
            furniture::coordination_bar(&mut svg, scene.nouns()[0], self.counts, [right(0), foot]);
            furniture::axes(&mut svg, [self.lefts[1] + 36.0, foot + 34.0], &camera.axes());
        }
        if let Some(overlaps) = scene.overlaps {
            furniture::overlap_bar(
                &mut svg,
                &scene.value_and_unit(),
                overlaps,
                [right(self.lefts.len() - 1), foot],
            );
        }
        svg.finish()
    }

    /// The elements and the contacts, up to the name of their value.
    fn description(&self) -> &'static str {
        if self.scene.dimensions == 2 {
            "Discs, those without contact white, and a line for each contact, coloured by its"
        } else {
            "Left the elements, coloured by their number of contacts; right the contacts, coloured by their"
        }
    }

    /// Draws discs and lines in 2D as SVG.
    fn shapes(&self, svg: &mut Svg) {
        let Self { scene, .. } = self;
        svg.background();
        for ends in outline(scene) {
            let [a, b] = ends.map(|end| self.on_paper(end));
            svg.put(format_args!(
                r#"<line x1="{:.2}" y1="{:.2}" x2="{:.2}" y2="{:.2}" stroke="{}" stroke-dasharray="6 4"/>"#,
                a[0],
                a[1],
                b[0],
                b[1],
                hex(BOX)
            ));
        }
        for (free, fill) in [(false, TOUCHING), (true, FREE)] {
            svg.put(format_args!(r#"<g fill="{}" stroke="{}">"#, hex(fill), hex(RIM)));
            for (index, centre) in scene.centres.iter().enumerate() {
                if (scene.coordination[index] == 0) == free {
                    let ([x, y], r) = (self.on_paper(*centre), self.radius(index));
                    let rim = rim(r);
                    let dot = if r > self.dot { String::new() } else { format!(r#" fill="{}""#, hex(RIM)) };
                    svg.put(format_args!(
                        r#"<circle cx="{x:.2}" cy="{y:.2}" r="{:.2}" stroke-width="{rim:.2}"{dot}/>"#,
                        r - rim / 2.0
                    ));
                }
            }
            svg.put(format_args!("</g>"));
        }
        svg.put(format_args!(r#"<g stroke-linecap="round">"#));
        for bond in self.pale_to_dark() {
            let (colour, width) = (hex(self.colour(bond)), self.width(bond));
            for [a, b] in lines(scene, bond).into_iter().flatten() {
                let ([x1, y1], [x2, y2]) = (self.on_paper(a), self.on_paper(b));
                svg.put(format_args!(
                    r#"<path d="M{x1:.2} {y1:.2}L{x2:.2} {y2:.2}" stroke="{colour}" stroke-width="{width:.2}"/>"#
                ));
            }
        }
        svg.put(format_args!("</g>"));
    }

    fn layers(&self, scale: f64) -> Vec<Layer> {
        let size = self.camera.area.map(|side| (side * scale).round() as usize);
        let layer = |k: usize, pixels| Layer { at: [self.lefts[k], HEAD], size, pixels };
        if self.scene.dimensions == 2 {
            vec![layer(0, self.discs(size, scale))]
        } else {
            vec![layer(0, self.spheres(size, scale)), layer(1, self.rods(size, scale))]
        }
    }

    fn discs(&self, size: [usize; 2], zoom: f64) -> Vec<u8> {
        let Self { scene, camera, .. } = self;
        let mut flat = Flat::new(size, 1);
        let place = |point: [f64; 3]| {
            let [x, y, _] = camera.place(point);
            [x * zoom, y * zoom]
        };
        for [a, b] in outline(scene) {
            flat.line([place(a), place(b)], zoom, BOX);
        }
        for (corners, owner) in scene.facets() {
            let fill = if scene.coordination[owner as usize] == 0 { FREE } else { TOUCHING };
            let corners = corners.map(place);
            flat.triangle(corners, fill);
            for k in 0..3 {
                flat.line([corners[k], corners[(k + 1) % 3]], 0.4 * zoom, RIM);
            }
        }
        for (free, fill) in [(false, TOUCHING), (true, FREE)] {
            for (index, centre) in scene.centres.iter().enumerate() {
                if (scene.coordination[index] == 0) == free && !scene.is_surface(index) {
                    let r = self.radius(index);
                    let (rim, fill) = (rim(r), if r > self.dot { fill } else { RIM });
                    flat.disc(place(*centre), (r - rim / 2.0) * zoom, fill, RIM, rim * zoom);
                }
            }
        }
        for bond in self.pale_to_dark() {
            for [a, b] in lines(scene, bond).into_iter().flatten() {
                flat.line([place(a), place(b)], self.width(bond) * zoom, self.colour(bond));
            }
        }
        flat.into_pixels()
    }

    /// Draws the elements in 3D.
    fn spheres(&self, size: [usize; 2], zoom: f64) -> Vec<u8> {
        let mut raster = Raster::new(&GRID, size);
        self.draw_box(&mut raster, zoom);
        self.draw_facets(&mut raster, zoom, true);
        for (index, centre) in self.scene.centres.iter().enumerate() {
            if self.scene.is_surface(index) {
                continue;
            }
            let radius = self.radius(index) * zoom;
            let colour = self.counts.colour(self.scene.coordination[index]);
            raster.sphere(self.camera.place(*centre).map(|x| x * zoom), radius, colour);
        }
        raster.shade(self.typical_radius() * zoom, 0.12);
        raster.pixels()
    }

    /// Draws the contacts in 3D, with small spheres at the centres of elements.
    fn rods(&self, size: [usize; 2], zoom: f64) -> Vec<u8> {
        let Self { scene, camera, .. } = self;
        let mut raster = Raster::new(&GRID, size);
        self.draw_box(&mut raster, zoom);
        self.draw_facets(&mut raster, zoom, false);
        let place = |point: [f64; 3]| camera.place(point).map(|x| x * zoom);
        for (index, centre) in scene.centres.iter().enumerate() {
            if scene.is_surface(index) {
                continue;
            }
            let radius = (0.16 * self.radius(index)).max(self.dot / 2.0) * zoom;
            raster.sphere(place(*centre), radius, NODE);
        }
        for bond in &scene.bonds {
            for [a, b] in lines(scene, bond).into_iter().flatten() {
                raster.rod([place(a), place(b)], self.width(bond) / 2.0 * zoom, self.colour(bond));
            }
        }
        raster.shade(self.typical_radius() * zoom, 0.5);
        raster.pixels()
    }

    /// Draws surfaces. Only the edges of triangles are drawn for walls and unless `solid`.
    fn draw_facets(&self, raster: &mut Raster<4>, zoom: f64, solid: bool) {
        let Some(shapes) = &self.scene.shapes else { return };
        for (corners, owner) in self.scene.facets() {
            let corners = corners.map(|corner| self.camera.place(corner).map(|x| x * zoom));
            if solid && !shapes.walls {
                raster.facet(corners, self.counts.colour(self.scene.coordination[owner as usize]));
            } else {
                for k in 0..3 {
                    raster.rod([corners[k], corners[(k + 1) % 3]], 0.3 * zoom, NODE);
                }
            }
        }
    }

    fn draw_box(&self, raster: &mut Raster<4>, zoom: f64) {
        for ends in outline(self.scene) {
            raster.rod(ends.map(|end| self.camera.place(end).map(|x| x * zoom)), 0.7 * zoom, BOX);
        }
    }

    /// Mean radius of the elements that are not surfaces, in pixels of the drawing.
    fn typical_radius(&self) -> f64 {
        let drawn = || (0..self.scene.radii.len()).filter(|&index| !self.scene.is_surface(index));
        match drawn().count() {
            // Reach of the shadows of surfaces.
            0 => 12.0,
            count => drawn().map(|index| self.radius(index)).sum::<f64>() / count as f64,
        }
    }

    /// Radius of an element, in pixels of the drawing.
    fn radius(&self, index: usize) -> f64 {
        (self.scene.radii[index] * self.camera.scale).max(self.dot)
    }

    fn on_paper(&self, point: [f64; 3]) -> [f64; 2] {
        let [x, y, _] = self.camera.place(point);
        [x + self.lefts[0], y + HEAD]
    }

    /// Contacts in ascending order of their overlap, so that the largest are on top.
    fn pale_to_dark(&self) -> Vec<&'a Bond> {
        let mut bonds: Vec<&Bond> = self.scene.bonds.iter().collect();
        bonds.sort_by(|a, b| a.overlap.total_cmp(&b.overlap));
        bonds
    }

    fn share(&self, bond: &Bond) -> f64 {
        self.scene.overlaps.map_or(0.0, |overlaps| overlaps.share(bond.overlap))
    }

    fn colour(&self, bond: &Bond) -> Rgb {
        at(&HEAT, self.share(bond))
    }

    /// Width of the line of a contact in pixels of the drawing: a part of the smaller radius, so that lines
    /// do not hide the elements.
    fn width(&self, bond: &Bond) -> f64 {
        if self.scene.shapes.is_some() {
            return 1.2 + 1.8 * self.share(bond);
        }
        let smaller = self.scene.radii[bond.i as usize].min(self.scene.radii[bond.j as usize]);
        if self.scene.of_forces {
            // Force chains: the width grows with the force.
            let most = (1.2 * smaller * self.camera.scale).clamp(2.0, 8.0);
            return 0.5 + (most - 0.5) * self.share(bond);
        }
        let flat = self.scene.dimensions == 2;
        let least = if flat { 0.5 } else { 0.6 };
        let wide = if flat { 0.14 + 0.24 * self.share(bond) } else { 0.22 + 0.33 * self.share(bond) };
        (smaller * self.camera.scale * wide).clamp(least, 6.0)
    }
}

/// Width of the outline of a disc with the radius `r`.
fn rim(r: f64) -> f64 {
    (r * 0.12).min(0.8)
}

/// Line of a contact. It has two halves if it leads to an image or through a contact point.
pub(crate) fn lines(scene: &Scene, bond: &Bond) -> [Option<[[f64; 3]; 2]>; 2] {
    let [a, b] = [bond.i, bond.j].map(|k| scene.centres[k as usize]);
    if let Some(Joint { point, to }) = bond.joint {
        return [to[0].then_some([a, point]), to[1].then_some([point, b])];
    }
    if !bond.leaves {
        return [Some([a, b]), None];
    }
    let half =
        |from: [f64; 3], sign: f64| std::array::from_fn(|axis| from[axis] + sign * bond.branch[axis] / 2.0);
    [Some([a, half(a, 1.0)]), Some([b, half(b, -1.0)])]
}
