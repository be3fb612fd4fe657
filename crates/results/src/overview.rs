//! Pictures of a model before its run: bodies, joint sets, boundaries, histories at points, and a legend.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use fdem_io::numbers::grouped;
use fdem_mesh::{Corners, bounds, sorted, sorted_facets};
use fdem_simulation::Mesh;

use crate::picture::colour::{Rgb, hex};
use crate::picture::encode::{self, Layer};
use crate::picture::furniture::{self, FOOT, HEAD};
use crate::picture::mesh::{BODIES, MARGIN, MeshDrawing, MeshLayout};
use crate::picture::svg::{Anchor, INK, PALE, Svg};
use crate::picture::text::{OF_TITLES, fitting};
use crate::picture::{PictureError, drawing::scale, raster};
use crate::run::unit::prefixed;
use crate::space::drawing::{self, Edge, Facet, SpaceCamera, SpaceScene};
use crate::space::view::SpaceView;

/// Width of the legend, and the height of a row of it.
const LEGEND: f64 = 250.0;
const ROW: f64 = 19.0;
/// Most rows of one part of the legend: the others are counted.
const MOST_ROWS: usize = 14;
/// Most facets of the surface of a model in three dimensions.
const MOST_FACETS: usize = 2_000_000;

/// Colours of joint sets and boundaries in turn, which no body has.
const MARKS: [Rgb; 8] = [
    [200, 30, 60],
    [0, 110, 200],
    [0, 130, 80],
    [150, 40, 170],
    [215, 115, 0],
    [90, 80, 60],
    [0, 140, 150],
    [120, 130, 0],
];
/// Widths of joints, of the seam around them, and of boundaries.
const JOINT: f64 = 2.0;
const SEAM: f64 = 4.0;
const BOUNDARY: f64 = 4.5;
/// Radius of the nodes of a boundary that are not on facets of it, and of points.
const NODE: f64 = 1.6;
const POINT: f64 = 4.0;

/// Size of a picture in three dimensions.
const SPACE: [f64; 2] = [852.0, 640.0];
/// Free space around the bodies in three dimensions, on each side.
const EDGE: f64 = 12.0;

/// Bodies that have one colour and one row of the legend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BodyGroup {
    /// Name in the legend.
    pub name: String,
    /// Numbers of the bodies.
    pub bodies: Vec<u32>,
}

/// A joint set or a boundary of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelMark<const D: usize> {
    /// Name in the legend.
    pub name: String,
    /// The facets, by their nodes.
    pub facets: Vec<[u32; D]>,
    /// Its nodes, ascending, if it has no facets. Outer facets all of whose nodes are in the list are drawn
    /// as facets.
    pub nodes: Vec<u32>,
}

/// A history at points of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelPoint<const D: usize> {
    /// Name beside its first point.
    pub name: String,
    /// Its points, m, with a line between them.
    pub places: Vec<[f64; D]>,
}

/// A model before its run: its undeformed mesh, and marks on it.
///
/// # Example
/// ```
/// use fdem_results::{BodyGroup, ModelDrawing, ModelMark};
/// use fdem_simulation::Mesh;
///
/// let mesh = Mesh {
///     nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
///     elements: vec![[0, 1, 2]],
///     bodies: vec![0],
///     materials: vec![0],
/// };
/// let drawing = ModelDrawing {
///     title: "a triangle",
///     mesh: &mesh,
///     bodies: &[BodyGroup { name: "wedge".to_owned(), bodies: vec![0] }],
///     joints: &[],
///     boundaries: &[ModelMark { name: "floor".to_owned(), facets: vec![], nodes: vec![0, 1] }],
///     points: &[],
///     notes: &[],
/// };
/// assert!(drawing.svg()?.contains("floor"));
/// # Ok::<(), fdem_results::picture::PictureError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ModelDrawing<'a, const D: usize = 2, const N: usize = 3> {
    /// Title.
    pub title: &'a str,
    /// The mesh.
    pub mesh: &'a Mesh<D, N>,
    /// The bodies of the mesh, each in one group.
    pub bodies: &'a [BodyGroup],
    /// The joint sets.
    pub joints: &'a [ModelMark<D>],
    /// The boundaries.
    pub boundaries: &'a [ModelMark<D>],
    /// Histories at points.
    pub points: &'a [ModelPoint<D>],
    /// Lines about stages, below the legend.
    pub notes: &'a [String],
}

/// A row of the legend.
enum LegendRow<'a> {
    Heading(&'static str),
    Body(Rgb, &'a str),
    Line(Rgb, f64, &'a str),
    Point(&'a str),
    Text(String),
}

impl ModelDrawing<'_> {
    /// Draws a model in a plane as SVG.
    ///
    /// # Errors
    /// [`PictureError::NotFinite`] with the number of a node; [`PictureError::TooWide`];
    /// [`PictureError::TooMany`] for more than 300,000 triangles.
    pub fn svg(&self) -> Result<String, PictureError> {
        Ok(self.drawn()?.0)
    }

    /// Draws a model in a plane as a PNG file. `width`: 200 to 10,000 pixels, by default twice the width of
    /// the SVG.
    ///
    /// # Errors
    /// The errors of [`Self::svg`]; [`PictureError::Width`], [`PictureError::Png`].
    pub fn png(&self, width: Option<u32>) -> Result<Vec<u8>, PictureError> {
        let (svg, wide) = self.drawn()?;
        encode::png(&svg, &[], scale(width, wide)?)
    }

    /// The picture and its width.
    fn drawn(&self) -> Result<(String, f64), PictureError> {
        let groups = self.group_of_body();
        let colours: Vec<u32> = self.mesh.bodies.iter().map(|&body| groups[&body]).collect();
        let mesh = MeshDrawing {
            points: &self.mesh.nodes,
            triangles: &self.mesh.elements,
            bodies: &self.mesh.bodies,
            contacts: &[],
        };
        let layout = MeshLayout::new(&mesh)?;
        let size = self.size(layout.area);
        let mut svg = self.sheet(size, layout.area, true);
        layout.triangles(&MeshDrawing { bodies: &colours, ..mesh }, &mut svg);
        layout.outlines(&mesh, &mut svg);
        let outer = if self.boundaries.is_empty() { OuterFacets::new() } else { self.outer_facets() };
        self.overlay(&mut svg, &outer, &|place| layout.on_paper(place));
        let (factor, unit) = prefixed("m", 150.0 / layout.scale);
        let foot = HEAD + layout.area[1] + 12.0;
        furniture::scale_bar(&mut svg, &format!(" {unit}"), [MARGIN, foot], layout.scale / factor);
        Ok((svg.finish(), size[0]))
    }
}

impl ModelDrawing<'_, 3, 4> {
    /// Draws a model in space as SVG: the surface of its bodies as an image. Joint sets are the outlines of
    /// their faces, drawn over the bodies as if these were of glass.
    ///
    /// # Errors
    /// [`PictureError::NotFinite`] with the number of a node; [`PictureError::TooWide`];
    /// [`PictureError::TooMany`] for more than 2,000,000 faces on the surface; [`PictureError::Png`].
    pub fn svg(&self) -> Result<String, PictureError> {
        let page = self.page()?;
        let layer = self.layer(&page, scale(None, page.size[0])?);
        let mut svg = self.sheet(page.size, page.camera.size, true);
        svg.image(
            layer.at,
            page.camera.size,
            &encode::file(layer.size.map(|side| side as u32), &layer.pixels)?,
        );
        self.above(&page, &mut svg);
        Ok(svg.finish())
    }

    /// Draws a model in space as a PNG file. `width`: 200 to 10,000 pixels, by default twice the width of the
    /// SVG.
    ///
    /// # Errors
    /// The errors of [`Self::svg`]; [`PictureError::Width`].
    pub fn png(&self, width: Option<u32>) -> Result<Vec<u8>, PictureError> {
        let page = self.page()?;
        let scale = scale(width, page.size[0])?;
        // The layer has the background.
        let mut svg = self.sheet(page.size, page.camera.size, false);
        self.above(&page, &mut svg);
        encode::png(&svg.finish(), &[self.layer(&page, scale)], scale)
    }

    fn page(&self) -> Result<SpacePage, PictureError> {
        let nodes = &self.mesh.nodes;
        if let Some(index) = nodes.iter().position(|node| !node.iter().all(|x| x.is_finite())) {
            return Err(PictureError::NotFinite { index });
        }
        let [low, high] = if nodes.is_empty() { [[0.0; 3], [1.0; 3]] } else { bounds(nodes.iter().copied()) };
        let view = SpaceView::between(low, high, 0.0);
        let camera = SpaceCamera::fitting(view, SPACE, SPACE[0], EDGE)?;
        let outer = self.outer_facets();
        if outer.len() > MOST_FACETS {
            let found = outer.len();
            return Err(PictureError::TooMany { what: "faces on the surface", found, most: MOST_FACETS });
        }
        Ok(SpacePage { camera, size: self.size(camera.size), outer })
    }

    /// The surface of the bodies, in the colours of bodies and boundaries.
    fn layer(&self, page: &SpacePage, zoom: f64) -> Layer {
        let groups = self.group_of_body();
        let mut marked: BTreeMap<[u32; 3], Rgb> = BTreeMap::new();
        for (boundary, colour) in self.coloured_boundaries() {
            let facets = Self::facets_of(boundary, &page.outer).0;
            marked.extend(facets.into_iter().map(|facet| (sorted(facet), colour)));
        }
        // An edge at which two facets of the surface with other directions or colours meet is a line.
        let mut facets = Vec::with_capacity(page.outer.len());
        let mut sides: BTreeMap<[u32; 2], Vec<([f64; 3], Rgb)>> = BTreeMap::new();
        for (&key, &(element, nodes)) in &page.outer {
            let body = self.mesh.bodies[element as usize];
            let own = BODIES[groups[&body] as usize % BODIES.len()];
            let colour = marked.get(&key).copied().unwrap_or(own);
            let corners = nodes.map(|node| self.mesh.nodes[node as usize]);
            for ends in edges_of(nodes) {
                sides.entry(ends).or_default().push((normal(corners), colour));
            }
            facets.push((nodes, corners, colour));
        }
        let is_line = |ends: [u32; 2]| match &sides[&ends][..] {
            [one, other] => one.1 != other.1 || (0..3).map(|k| one.0[k] * other.0[k]).sum::<f64>() < 0.9,
            _ => true,
        };
        let facet = |(nodes, corners, colour)| Facet {
            corners,
            colour,
            edges: edges_of(nodes).map(|ends| if is_line(ends) { Edge::Feature } else { Edge::Element }),
            broken: false,
        };
        let scene = SpaceScene {
            facets: facets.into_iter().map(facet).collect(),
            closed: true,
            ..SpaceScene::default()
        };
        let size = page.camera.size.map(|side| (side * zoom).round() as usize);
        let pixels = raster::draw(size, &drawing::solid(&scene, &page.camera.zoomed(zoom), None));
        Layer { at: [MARGIN, HEAD], size, pixels }
    }

    /// Draws all that is above the surface.
    fn above(&self, page: &SpacePage, svg: &mut Svg) {
        self.overlay(svg, &page.outer, &|point| {
            let [x, y, _] = page.camera.place(point);
            [x + MARGIN, y + HEAD]
        });
        let foot = HEAD + page.camera.size[1] + 12.0;
        furniture::axes(svg, [MARGIN + 36.0, foot + 30.0], &page.camera.view.triad());
        let (factor, unit) = prefixed("m", 150.0 / page.camera.scale);
        let at = [MARGIN + 90.0, foot];
        furniture::scale_bar(svg, &format!(" {unit}"), at, page.camera.scale / factor);
    }
}

/// Layout of a picture in three dimensions.
struct SpacePage {
    camera: SpaceCamera,
    size: [f64; 2],
    outer: OuterFacets<3>,
}

/// Facets of one element only, by their nodes, ascending: the element, and the nodes in its order.
type OuterFacets<const D: usize> = BTreeMap<[u32; D], (u32, [u32; D])>;

impl<const D: usize, const N: usize> ModelDrawing<'_, D, N>
where
    [[f64; D]; N]: Corners<D, N>,
{
    /// The group of each body.
    fn group_of_body(&self) -> BTreeMap<u32, u32> {
        let of_group = |(number, group): (u32, &BodyGroup)| {
            group.bodies.iter().map(move |&body| (body, number)).collect::<Vec<_>>()
        };
        let mut groups: BTreeMap<u32, u32> = (0..).zip(self.bodies).flat_map(of_group).collect();
        for &body in &self.mesh.bodies {
            groups.entry(body).or_insert(body);
        }
        groups
    }

    fn outer_facets(&self) -> OuterFacets<D> {
        let facets = sorted_facets::<D, N>(&self.mesh.elements);
        let alone = facets.chunk_by(|one, other| one.0 == other.0).filter_map(|same| match same {
            [alone] => Some(*alone),
            _ => None,
        });
        let placed = |(key, element): ([u32; D], u32)| {
            let nodes = self.mesh.elements[element as usize];
            let facets = <[[f64; D]; N]>::FACETS.map(|facet| facet.map(|corner| nodes[corner]));
            let facet = facets.into_iter().find(|facet| sorted(*facet) == key).unwrap_or(key);
            (key, (element, facet))
        };
        alone.map(placed).collect()
    }

    /// The facets of a boundary, and its nodes on the surface that are on none of these.
    fn facets_of(mark: &ModelMark<D>, outer: &OuterFacets<D>) -> (Vec<[u32; D]>, Vec<u32>) {
        if !mark.facets.is_empty() {
            return (mark.facets.clone(), Vec::new());
        }
        let has = |node: &u32| mark.nodes.binary_search(node).is_ok();
        let (mut facets, mut covered, mut seen) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
        for &(_, facet) in outer.values() {
            if facet.iter().all(has) {
                facets.push(facet);
                covered.extend(facet);
            }
            seen.extend(facet.into_iter().filter(has));
        }
        // Nodes inside are drawn only if there are no others.
        let inside = if seen.is_empty() { mark.nodes.clone() } else { Vec::new() };
        let rest = seen.into_iter().chain(inside).filter(|node| !covered.contains(node)).collect();
        (facets, rest)
    }

    /// Each joint set with its colour.
    fn coloured_joints(&self) -> impl Iterator<Item = (&ModelMark<D>, Rgb)> {
        self.joints.iter().zip(MARKS.into_iter().cycle())
    }

    /// Each boundary with its colour. They take the colours after those of the joint sets.
    fn coloured_boundaries(&self) -> impl Iterator<Item = (&ModelMark<D>, Rgb)> {
        self.boundaries.iter().zip(MARKS.into_iter().cycle().skip(self.joints.len()))
    }

    /// The size of a picture with its legend.
    fn size(&self, area: [f64; 2]) -> [f64; 2] {
        let legend = HEAD + ROW * (self.rows().len() + 1) as f64;
        [area[0] + 3.0 * MARGIN + LEGEND, (HEAD + area[1] + FOOT).max(legend)]
    }

    /// A sheet with its title and its legend. `paper`: whether it has a background.
    fn sheet(&self, size: [f64; 2], area: [f64; 2], paper: bool) -> Svg {
        let text = self.sentence();
        let mut svg = Svg::new(size[0], size[1], &format!("Model {}", self.title), &format!("{text}."));
        if paper {
            svg.background();
        }
        let (title, font) = fitting(self.title, size[0] - 2.0 * MARGIN, OF_TITLES, true);
        svg.bold([MARGIN, 30.0], font, &title);
        svg.label([MARGIN, 51.0], 12.5, Anchor::Start, PALE, &text);
        self.legend(&mut svg, [2.0 * MARGIN + area[0], HEAD]);
        svg
    }

    fn sentence(&self) -> String {
        let count = |count: usize, [one, many]: [&str; 2]| {
            format!("{} {}", grouped(count as u64), if count == 1 { one } else { many })
        };
        let bodies = self.bodies.iter().map(|group| group.bodies.len()).sum();
        [
            count(self.mesh.elements.len(), ["element", "elements"]),
            count(bodies, ["body", "bodies"]),
            count(self.joints.len(), ["joint set", "joint sets"]),
            count(self.boundaries.len(), ["boundary", "boundaries"]),
        ]
        .join(", ")
    }

    /// The rows of the legend.
    fn rows(&self) -> Vec<LegendRow<'_>> {
        let bodies = self.bodies.iter().enumerate();
        let bodies =
            bodies.map(|(k, group)| LegendRow::Body(BODIES[k % BODIES.len()], &group.name)).collect();
        let joints = self.coloured_joints().map(|(mark, colour)| LegendRow::Line(colour, JOINT, &mark.name));
        let boundaries =
            self.coloured_boundaries().map(|(mark, colour)| LegendRow::Line(colour, BOUNDARY, &mark.name));
        let points = self.points.iter().map(|point| LegendRow::Point(&point.name));
        let notes = self.notes.iter().map(|note| LegendRow::Text(note.clone()));
        let parts: [(&str, Vec<LegendRow<'_>>); 5] = [
            ("bodies", bodies),
            ("joint sets", joints.collect()),
            ("boundaries", boundaries.collect()),
            ("histories", points.collect()),
            ("stages", notes.collect()),
        ];
        let mut rows = Vec::new();
        for (heading, part) in parts.into_iter().filter(|(_, part)| !part.is_empty()) {
            rows.push(LegendRow::Heading(heading));
            let more = part.len().saturating_sub(MOST_ROWS);
            rows.extend(part.into_iter().take(MOST_ROWS));
            if more > 0 {
                rows.push(LegendRow::Text(format!("and {} more", grouped(more as u64))));
            }
        }
        rows
    }

    fn legend(&self, svg: &mut Svg, [x, y]: [f64; 2]) {
        for (row, y) in self.rows().iter().zip((1..).map(|k| y + ROW * f64::from(k))) {
            let name = |svg: &mut Svg, x: f64, text: &str| {
                let (text, size) = fitting(text, LEGEND - 30.0, [12.0, 9.5], false);
                svg.label([x, y], size, Anchor::Start, INK, &text);
            };
            match row {
                LegendRow::Heading(text) => svg.bold([x, y], 12.0, text),
                LegendRow::Body(colour, text) => {
                    svg.rect([x, y - 10.0], [20.0, 12.0], *colour);
                    name(svg, x + 28.0, text);
                }
                LegendRow::Line(colour, width, text) => {
                    svg.line([x, y - 4.0], [x + 20.0, y - 4.0], *width, &hex(*colour));
                    name(svg, x + 28.0, text);
                }
                LegendRow::Point(text) => {
                    point(svg, [x + 10.0, y - 4.0]);
                    name(svg, x + 28.0, text);
                }
                LegendRow::Text(text) => name(svg, x, text),
            }
        }
    }

    /// Draws boundaries, joint sets and points. `outer`: outer facets, not needed without boundaries;
    /// `place`: the place of a point, m, on the paper. Facets of boundaries in three dimensions are those of
    /// the surface below.
    fn overlay(&self, svg: &mut Svg, outer: &OuterFacets<D>, place: &dyn Fn([f64; D]) -> [f64; 2]) {
        let at = |node: u32| place(self.mesh.nodes[node as usize]);
        svg.put(format_args!(r#"<g fill="none" stroke-linecap="round">"#));
        for (boundary, colour) in self.coloured_boundaries() {
            let (facets, rest) = Self::facets_of(boundary, outer);
            let on_surface = |facet: &&[u32; D]| D == 2 || !outer.contains_key(&sorted(**facet));
            let facets: Vec<[u32; D]> = facets.iter().filter(on_surface).copied().collect();
            let path = path(&lines(&facets), at);
            svg.put(format_args!(
                r#"<path class="boundary" d="{path}" stroke="{}" stroke-width="{BOUNDARY}"/>"#,
                hex(colour)
            ));
            for [x, y] in rest.into_iter().map(at) {
                svg.put(format_args!(
                    r#"<circle cx="{x:.2}" cy="{y:.2}" r="{NODE}" fill="{}"/>"#,
                    hex(colour)
                ));
            }
        }
        let joints: Vec<(String, Rgb)> = self
            .coloured_joints()
            .map(|(joints, colour)| (path(&lines(&joints.facets), at), colour))
            .collect();
        for (path, _) in &joints {
            svg.put(format_args!(r#"<path d="{path}" stroke="white" stroke-width="{SEAM}"/>"#));
        }
        for (path, colour) in &joints {
            svg.put(format_args!(
                r#"<path class="joints" d="{path}" stroke="{}" stroke-width="{JOINT}"/>"#,
                hex(*colour)
            ));
        }
        svg.put(format_args!("</g>"));
        for ModelPoint { name, places } in self.points {
            let places: Vec<[f64; 2]> = places.iter().map(|&point| place(point)).collect();
            for ends in places.windows(2) {
                svg.line(ends[0], ends[1], 1.2, INK);
            }
            for &at in &places {
                point(svg, at);
            }
            if let Some([x, y]) = places.first() {
                svg.label([x + 7.0, y - 5.0], 11.0, Anchor::Start, INK, name);
            }
        }
    }
}

/// Draws the marker of a point.
fn point(svg: &mut Svg, [x, y]: [f64; 2]) {
    svg.put(format_args!(
        r#"<circle cx="{x:.2}" cy="{y:.2}" r="{POINT}" fill="white" stroke="{INK}" stroke-width="1.4"/>"#
    ));
}

/// Lines of facets: edges themselves; of faces the edges that belong to one of them only.
fn lines<const D: usize>(facets: &[[u32; D]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = facets
        .iter()
        .flat_map(|facet| {
            let count = if D == 2 { 1 } else { D };
            (0..count).map(|k| sorted([facet[k], facet[(k + 1) % D]]))
        })
        .collect();
    edges.sort_unstable();
    if D == 2 {
        edges.dedup();
        return edges;
    }
    edges.chunk_by(|one, other| one == other).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}

fn path(lines: &[[u32; 2]], at: impl Fn(u32) -> [f64; 2]) -> String {
    let mut path = String::new();
    for ends in lines {
        let [a, b] = ends.map(&at);
        // Writing to a string does not fail.
        let _ = write!(path, "M{:.2} {:.2}L{:.2} {:.2}", a[0], a[1], b[0], b[1]);
    }
    path
}

fn edges_of([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(sorted)
}

/// The normal of a face, of length 1; of length 0 if the face has no area.
fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let ([x, y, z], [u, v, w]) = (minus(b, a), minus(c, a));
    let normal = [y * w - z * v, z * u - x * w, x * v - y * u];
    let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
    normal.map(|x| if length > 0.0 { x / length } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tetrahedra on a common face.
    fn mesh() -> Mesh<3, 4> {
        let nodes = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
        Mesh { nodes, elements: vec![[0, 1, 2, 3], [1, 4, 2, 3]], bodies: vec![0, 1], materials: vec![0, 0] }
    }

    fn named(name: &str, facets: Vec<[u32; 3]>, nodes: Vec<u32>) -> ModelMark<3> {
        ModelMark { name: name.to_owned(), facets, nodes }
    }

    #[test]
    fn faces_of_a_boundary_are_those_of_its_nodes() {
        let mesh = mesh();
        let drawing = ModelDrawing {
            title: "",
            mesh: &mesh,
            bodies: &[],
            joints: &[],
            boundaries: &[],
            points: &[],
            notes: &[],
        };
        let outer = drawing.outer_facets();
        assert_eq!(outer.len(), 6, "the common face is inside");
        let found = ModelDrawing::facets_of(&named("", vec![], vec![0, 1, 2, 4]), &outer);
        let facets: Vec<[u32; 3]> = found.0.into_iter().map(sorted).collect();
        assert_eq!((facets, found.1), (vec![[0, 1, 2], [1, 2, 4]], vec![]));
        assert_eq!(ModelDrawing::facets_of(&named("", vec![], vec![0, 4]), &outer), (vec![], vec![0, 4]));
        // Two faces have the outline of a quadrilateral.
        assert_eq!(lines(&[[0, 1, 2], [1, 2, 4]]), [[0, 1], [0, 2], [1, 4], [2, 4]]);
        assert_eq!(lines(&[[3, 2], [2, 3], [0, 2]]), [[0, 2], [2, 3]]);
    }

    /// Whether there are pixels in the colour of the first boundary, in any light: bodies are pale blue.
    fn is_red(layer: &Layer) -> bool {
        let red =
            |pixel: &&[u8]| pixel[1..].iter().all(|&other| u32::from(pixel[0]) > 3 * u32::from(other) / 2);
        layer.pixels.chunks_exact(3).filter(red).count() > 100
    }

    #[test]
    fn the_faces_of_boundaries_have_their_colour() {
        let mesh = mesh();
        let boundary = named("front", vec![[0, 1, 3]], vec![]);
        let drawing = ModelDrawing {
            title: "two",
            mesh: &mesh,
            bodies: &[BodyGroup { name: "both".to_owned(), bodies: vec![0, 1] }],
            joints: &[],
            boundaries: std::slice::from_ref(&boundary),
            points: &[],
            notes: &[],
        };
        let drawn = |drawing: &ModelDrawing<'_, 3, 4>| drawing.layer(&drawing.page().unwrap(), 1.0);
        assert!(is_red(&drawn(&drawing)));
        assert!(!is_red(&drawn(&ModelDrawing { boundaries: &[], ..drawing })));
        let far = Mesh { nodes: vec![[f64::NAN; 3]; 5], ..mesh.clone() };
        let far = ModelDrawing { mesh: &far, ..drawing };
        assert_eq!(far.svg(), Err(PictureError::NotFinite { index: 0 }));
        assert!(matches!(drawing.png(Some(5)), Err(PictureError::Width { found: 5, .. })));
    }
}
