//! Pictures of meshed bodies in a plane and their contacts.

use std::fmt::Write;

use fdem_contact::discretised::BodyContact;
use fdem_io::numbers::{brief, grouped};

use crate::picture::caption::Caption;
use crate::picture::colour::{HEAT, Rgb, at, hex};
use crate::picture::error::PictureError;
use crate::picture::furniture::{self, FOOT, HEAD};
use crate::picture::scene::OverlapRange;
use crate::picture::svg::{Anchor, PALE, Svg};
use crate::picture::text::{OF_TITLES, fitting};
use crate::picture::{drawing, encode};

pub(crate) const MARGIN: f64 = 24.0;

/// Largest size of the drawing; `NARROWEST` is the width that the parts below it need.
const MOST: [f64; 2] = [900.0, 860.0];
const NARROWEST: f64 = 520.0;

/// Largest number of triangles: more could not be distinguished, nor opened by a browser.
const MOST_TRIANGLES: usize = 300_000;

/// Colours of the bodies in turn. They are pale so that contacts are prominent.
pub(crate) const BODIES: [Rgb; 8] = [
    [200, 220, 240],
    [222, 213, 238],
    [203, 230, 214],
    [240, 224, 200],
    [214, 226, 229],
    [238, 211, 220],
    [226, 232, 202],
    [208, 214, 226],
];
const EDGE: Rgb = [134, 149, 166];
/// Colour of the outlines of bodies, darker than the edges of triangles.
const OUTLINE: Rgb = [64, 78, 94];
const OUTLINE_WIDTH: f64 = 1.4;
/// Largest width of an outline over the size of the bodies.
const OUTLINE_SHARE: f64 = 0.06;

/// Meshed bodies in a plane and their contacts.
///
/// # Shapes
/// `triangles` and `bodies` have one entry per triangle: indices of `points`, and the number of a body.
#[derive(Clone, Copy, Debug)]
pub struct MeshDrawing<'a> {
    /// The nodes.
    pub points: &'a [[f64; 2]],
    /// The nodes of each triangle.
    pub triangles: &'a [[u32; 3]],
    /// The body of each triangle.
    pub bodies: &'a [u32],
    /// Contacts of the bodies.
    pub contacts: &'a [BodyContact<2>],
}

/// Draws meshed bodies as SVG: triangles coloured by body, and for each two bodies that touch a line from
/// centroid to centroid through the contact point. The lines are coloured by the area of overlap, or by the
/// length of the shared boundary if nothing overlaps.
///
/// # Errors
/// [`PictureError::NotFinite`] with the number of a node; [`PictureError::TooWide`];
/// [`PictureError::TooMany`] for more than 300,000 triangles.
///
/// # Panics
/// If a node of a triangle or a body of a contact is out of range.
///
/// # Cost
/// Time proportional to the triangles and contacts.
///
/// # Example
/// ```
/// use fdem_results::picture::{Caption, MeshDrawing, mesh_svg};
///
/// let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
/// let drawing = MeshDrawing { points: &points, triangles: &[[0, 1, 2]], bodies: &[0], contacts: &[] };
/// let svg = mesh_svg(&drawing, &Caption { title: "one triangle", unit: None })?;
/// assert_eq!(svg.matches("<polygon").count(), 1);
/// # Ok::<(), fdem_results::picture::PictureError>(())
/// ```
pub fn mesh_svg(drawing: &MeshDrawing<'_>, caption: &Caption<'_>) -> Result<String, PictureError> {
    let page = MeshLayout::new(drawing)?;
    Ok(page.svg(drawing, caption))
}

/// Like [`mesh_svg`], as a PNG file. `width`: 200 to 10,000 pixels, by default twice the width of the SVG.
///
/// # Errors
/// The errors of [`mesh_svg`], [`PictureError::Width`] and [`PictureError::Png`].
///
/// # Panics
/// As [`mesh_svg`].
pub fn mesh_png(
    drawing: &MeshDrawing<'_>,
    caption: &Caption<'_>,
    width: Option<u32>,
) -> Result<Vec<u8>, PictureError> {
    let page = MeshLayout::new(drawing)?;
    encode::png(&page.svg(drawing, caption), &[], drawing::scale(width, page.size[0])?)
}

/// Layout of the drawing.
pub(crate) struct MeshLayout {
    low: [f64; 2],
    high: [f64; 2],
    /// Units of the drawing per unit of length.
    pub(crate) scale: f64,
    /// Size of the drawing without the parts around it.
    pub(crate) area: [f64; 2],
    size: [f64; 2],
}

impl MeshLayout {
    pub(crate) fn new(drawing: &MeshDrawing<'_>) -> Result<Self, PictureError> {
        if drawing.triangles.len() > MOST_TRIANGLES {
            let found = drawing.triangles.len();
            return Err(PictureError::TooMany { what: "triangles", found, most: MOST_TRIANGLES });
        }
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for &node in drawing.triangles.as_flattened() {
            let point = drawing.points[node as usize];
            if !point.iter().all(|x| x.is_finite()) {
                return Err(PictureError::NotFinite { index: node as usize });
            }
            for axis in 0..2 {
                (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
            }
        }
        if drawing.triangles.is_empty() {
            (low, high) = ([0.0; 2], [1.0; 2]);
        }
        let extent = [high[0] - low[0], high[1] - low[1]];
        if !extent.iter().all(|side| side.is_finite()) {
            return Err(PictureError::TooWide);
        }
        let fits = |axis: usize| if extent[axis] > 0.0 { MOST[axis] / extent[axis] } else { f64::INFINITY };
        let scale = fits(0).min(fits(1));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let area = [(extent[0] * scale).max(NARROWEST), (extent[1] * scale).max(1.0)];
        Ok(Self { low, high, scale, area, size: [area[0] + 2.0 * MARGIN, HEAD + area[1] + FOOT] })
    }

    pub(crate) fn on_paper(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        // Centres a drawing that is narrower than its area.
        let gap = (self.area[0] - (self.high[0] - self.low[0]) * self.scale) / 2.0;
        [MARGIN + gap + (x - self.low[0]) * self.scale, HEAD + (self.high[1] - y) * self.scale]
    }

    fn svg(&self, drawing: &MeshDrawing<'_>, caption: &Caption<'_>) -> String {
        let [width, height] = self.size;
        let bodies = centroids(drawing);
        let text = format!(
            "{} triangles of {} {}, {} {}",
            grouped(drawing.triangles.len() as u64),
            grouped(bodies.iter().flatten().count() as u64),
            if bodies.iter().flatten().count() == 1 { "body" } else { "bodies" },
            grouped(drawing.contacts.len() as u64),
            if drawing.contacts.len() == 1 { "contact between them" } else { "contacts between them" },
        );
        let description = format!(
            "{text}. Triangles coloured by body, and a line through the contact of each two bodies that touch."
        );
        let mut svg = Svg::new(width, height, &format!("Contacts of {}", caption.title), &description);
        svg.background();
        self.triangles(drawing, &mut svg);
        self.outlines(drawing, &mut svg);
        let overlap = drawing.contacts.iter().any(|contact| contact.overlap > 0.0);
        let value = |contact: &BodyContact<2>| if overlap { contact.overlap } else { contact.shared };
        let values = OverlapRange::of(drawing.contacts.iter().map(value).collect());
        svg.put(format_args!(r#"<g fill="none" stroke-linecap="round" stroke-linejoin="round">"#));
        for contact in drawing.contacts {
            let colour = at(&HEAT, values.map_or(0.0, |values| values.share(value(contact))));
            let [a, b] = contact.bodies.map(|body| bodies[body as usize].unwrap_or(contact.point));
            let [a, p, b] = [a, contact.point, b].map(|point| self.on_paper(point));
            svg.put(format_args!(
                r#"<path d="M{:.2} {:.2}L{:.2} {:.2}L{:.2} {:.2}" stroke="{}" stroke-width="2"/>"#,
                a[0],
                a[1],
                p[0],
                p[1],
                b[0],
                b[1],
                hex(colour)
            ));
        }
        svg.put(format_args!("</g>"));
        let (title, size) = fitting(caption.title, self.area[0], OF_TITLES, true);
        svg.bold([MARGIN, 30.0], size, &title);
        svg.label([MARGIN, 51.0], 12.5, Anchor::Start, PALE, &text);
        let foot = HEAD + self.area[1] + 12.0;
        let unit = caption.unit.map(|unit| format!(" {unit}")).unwrap_or_default();
        furniture::scale_bar(&mut svg, &unit, [MARGIN, foot], self.scale);
        if let Some(values) = values.filter(|values| values.largest > 0.0) {
            let name = if overlap { "area that overlaps" } else { "length of shared boundary" };
            furniture::overlap_bar(&mut svg, name, values, [width - MARGIN - 6.0, foot]);
        } else if !drawing.contacts.is_empty() {
            let right = [width - MARGIN - 6.0, foot + 10.0];
            svg.label(right, 12.0, Anchor::End, PALE, &format!("point contacts: overlap {}", brief(0.0)));
        }
        svg.finish()
    }
}

impl MeshLayout {
    /// Draws the triangles in the colours of their bodies.
    pub(crate) fn triangles(&self, drawing: &MeshDrawing<'_>, svg: &mut Svg) {
        svg.put(format_args!(r#"<g stroke="{}" stroke-width="0.5" stroke-linejoin="round">"#, hex(EDGE)));
        for (nodes, &body) in drawing.triangles.iter().zip(drawing.bodies) {
            let [a, b, c] = nodes.map(|node| self.on_paper(drawing.points[node as usize]));
            svg.put(format_args!(
                r#"<polygon points="{:.2},{:.2} {:.2},{:.2} {:.2},{:.2}" fill="{}"/>"#,
                a[0],
                a[1],
                b[0],
                b[1],
                c[0],
                c[1],
                hex(BODIES[body as usize % BODIES.len()])
            ));
        }
        svg.put(format_args!("</g>"));
    }

    /// Draws the outlines of the bodies: edges that belong to only one triangle of a body.
    pub(crate) fn outlines(&self, drawing: &MeshDrawing<'_>, svg: &mut Svg) {
        let mut edges: Vec<(u32, [u32; 2])> = Vec::with_capacity(3 * drawing.triangles.len());
        let mut area = 0.0;
        for (nodes, &body) in drawing.triangles.iter().zip(drawing.bodies) {
            edges.extend([0, 1, 2].map(|k| {
                let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
                (body, [a.min(b), a.max(b)])
            }));
            let [a, b, c] = nodes.map(|node| self.on_paper(drawing.points[node as usize]));
            area += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() / 2.0;
        }
        edges.sort_unstable();
        let (mut path, mut length) = (String::new(), 0.0);
        for same in edges.chunk_by(|one, other| one == other) {
            let [(_, ends)] = same else { continue };
            let [a, b] = ends.map(|node| self.on_paper(drawing.points[node as usize]));
            length += (b[0] - a[0]).hypot(b[1] - a[1]);
            // Writing to a string does not fail.
            let _ = write!(path, "M{:.2} {:.2}L{:.2} {:.2}", a[0], a[1], b[0], b[1]);
        }
        // Four times the area over the circumference is the diameter for a disc.
        let width = OUTLINE_WIDTH.min(OUTLINE_SHARE * 4.0 * area / length.max(f64::MIN_POSITIVE));
        if !path.is_empty() && width > 0.0 {
            svg.put(format_args!(
                r#"<path class="bodies" d="{path}" fill="none" stroke="{}" stroke-width="{width:.2}" stroke-linecap="round"/>"#,
                hex(OUTLINE)
            ));
        }
    }
}

/// Centroid of each body that has triangles, weighted by area. Without any area, it is the mean of the
/// centroids of the triangles.
fn centroids(drawing: &MeshDrawing<'_>) -> Vec<Option<[f64; 2]>> {
    let count = drawing.bodies.iter().max().map_or(0, |&last| last as usize + 1);
    let mut sums = vec![[0.0; 3]; count];
    let mut means = vec![[0.0; 3]; count];
    for (nodes, &body) in drawing.triangles.iter().zip(drawing.bodies) {
        let [a, b, c] = nodes.map(|node| drawing.points[node as usize]);
        let area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        for axis in 0..2 {
            let middle = (a[axis] + b[axis] + c[axis]) / 3.0;
            sums[body as usize][axis] += area * middle;
            means[body as usize][axis] += middle;
        }
        sums[body as usize][2] += area;
        means[body as usize][2] += 1.0;
    }
    let divided = |[x, y, weight]: [f64; 3]| (weight > 0.0).then(|| [x / weight, y / weight]);
    sums.into_iter().zip(means).map(|(sum, mean)| divided(sum).or_else(|| divided(mean))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 2]; 6] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.9, 0.0], [2.0, 0.0], [2.0, 1.0]];

    fn drawn(contacts: &[BodyContact<2>], title: &str) -> String {
        let drawing =
            MeshDrawing { points: &POINTS, triangles: &[[0, 1, 2], [3, 4, 5]], bodies: &[0, 1], contacts };
        mesh_svg(&drawing, &Caption { title, unit: Some("mm") }).unwrap()
    }

    fn contact(overlap: f64, shared: f64) -> BodyContact<2> {
        BodyContact { bodies: [0, 1], couples: 1, overlap, shared, point: [0.95, 0.02], normal: [1.0, 0.0] }
    }

    #[test]
    fn bodies_and_their_contacts_are_drawn() {
        let svg = drawn(&[contact(0.01, 0.0)], "a <b>");
        assert_eq!(svg.matches("<polygon").count(), 2);
        assert!(svg.contains("area that overlaps") && svg.contains("a &lt;b&gt;") && svg.contains("mm"));
        assert!(svg.contains("2 triangles of 2 bodies, 1 contact between them"));
        assert!(drawn(&[contact(0.0, 0.5)], "").contains("length of shared boundary"));
        assert!(drawn(&[contact(0.0, 0.0)], "").contains("point contacts"));
        assert_eq!(drawn(&[], "").matches("<path").count(), 1, "outlines only");
    }

    #[test]
    fn bodies_have_outlines_without_the_edges_within() {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0]];
        let drawing = MeshDrawing {
            points: &points,
            triangles: &[[0, 1, 2], [0, 2, 3], [1, 4, 2]],
            bodies: &[0, 0, 1],
            contacts: &[],
        };
        let svg = mesh_svg(&drawing, &Caption::default()).unwrap();
        let path = svg.split("class=\"bodies\" d=\"").nth(1).unwrap().split('"').next().unwrap();
        // Four sides of the square and three of the triangle: the common side belongs to both outlines, the
        // diagonal to none.
        assert_eq!(path.matches('M').count(), 7, "{path}");
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let points = [[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]];
        let drawing = MeshDrawing { points: &points, triangles: &[[0, 1, 2]], bodies: &[0], contacts: &[] };
        assert_eq!(
            mesh_svg(&drawing, &Caption::default()),
            Err(PictureError::NotFinite { index: 1 }),
            "a node, not a triangle"
        );
        let empty = MeshDrawing { points: &[], triangles: &[], bodies: &[], contacts: &[] };
        assert!(mesh_svg(&empty, &Caption::default()).is_ok());
        assert!(mesh_png(&empty, &Caption::default(), Some(200)).unwrap().starts_with(b"\x89PNG"));
    }
}
