//! Triangles of a picture: the visible parts of facets, sections and cracks, their light and their lines.

use crate::arrays::each;
use crate::picture::PictureError;
use crate::picture::colour::{Rgb, mix};
use crate::picture::raster::{Bead, Beads, Paint, Rod, Stroke, Triangle};
use crate::run::grains::drawing::{GrainScene, WALL};
use crate::run::grains::walls::{EMPTY, WallTriangle, bounds_of, union};
use crate::space::section::Plane;
use crate::space::view::SpaceView;

/// Direction to the light: left, above and in front.
const LIGHT: [f64; 3] = [-0.42, 0.62, 0.662_4];

/// Colour of lines, and of lines of cracks.
pub(crate) const LINE: Rgb = [52, 62, 72];
pub(crate) const CRACK: Rgb = [17, 24, 39];
/// Colour of the inside of a surface that is cut open.
const INSIDE: Rgb = [120, 126, 132];
/// How much the light makes the colours of cracks paler, at most.
const PALER: f64 = 0.28;
/// Colour and cover of the solid around cracks.
const GLASS: Paint = Paint { cover: 30, colour: [120, 144, 168] };

/// A line between two facets. The later one is drawn if there are several reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Edge {
    /// Within a facet that is drawn in two parts.
    None,
    /// Between elements.
    Element,
    /// Between grains or materials.
    Grain,
    /// In the plane of a cut.
    Cut,
    /// Where the surface has an angle, and where it turns away from the eye.
    Feature,
    /// Where a crack is seen on the surface.
    Crack,
}

/// A facet of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Facet {
    /// Corners, m, counter-clockwise seen from outside.
    pub(crate) corners: [[f64; 3]; 3],
    pub(crate) colour: Rgb,
    /// Kinds of the edges from corner `k` to corner `k + 1`.
    pub(crate) edges: [Edge; 3],
    /// Whether it is a side of a broken joint.
    pub(crate) broken: bool,
}

/// An element that a plane may cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tetrahedron {
    pub(crate) corners: [[f64; 3]; 4],
    pub(crate) colour: Rgb,
    /// Kinds of its facets: of the lines in which a plane cuts them.
    pub(crate) facets: [Edge; 4],
}

/// A broken or whole joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CrackFacet {
    pub(crate) corners: [[f64; 3]; 3],
    pub(crate) colour: Rgb,
}

/// The contents of a picture, as plain lists.
#[derive(Clone, Debug, Default)]
pub(crate) struct SpaceScene {
    pub(crate) facets: Vec<Facet>,
    /// All elements, if there is a cut that shows the inside.
    pub(crate) tetrahedra: Vec<Tetrahedron>,
    pub(crate) cracks: Vec<CrackFacet>,
    /// Whether no facet can be seen from inside.
    pub(crate) closed: bool,
    /// Spheres, their contacts and walls.
    pub(crate) grains: GrainScene,
}

/// Projection of a scene onto pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpaceCamera {
    pub(crate) view: SpaceView,
    /// Point in the middle of the picture: to the right, upwards and to the eye, m.
    pub(crate) middle: [f64; 3],
    /// Pixels per metre.
    pub(crate) scale: f64,
    /// Size of the picture, pixels.
    pub(crate) size: [f64; 2],
    /// Pixels per unit of the drawing, in which widths of lines are given.
    pub(crate) zoom: f64,
}

impl SpaceCamera {
    /// A camera whose picture is at most `most` units of the drawing wide and high, and at least `narrowest`
    /// wide, with the visible parts at least `edge` from its sides.
    ///
    /// # Errors
    /// [`PictureError::TooWide`].
    pub(crate) fn fitting(
        view: SpaceView,
        most: [f64; 2],
        narrowest: f64,
        edge: f64,
    ) -> Result<Self, PictureError> {
        let ends = view.extent();
        let extent = ends.map(|[low, high]| high - low);
        if !extent.iter().all(|side| side.is_finite()) {
            return Err(PictureError::TooWide);
        }
        let fits = |axis: usize| {
            if extent[axis] > 0.0 { (most[axis] - 2.0 * edge) / extent[axis] } else { f64::INFINITY }
        };
        let scale = fits(0).min(fits(1));
        let scale = if scale.is_normal() { scale } else { 1.0 };
        let side = |axis: usize| (extent[axis] * scale + 2.0 * edge).min(most[axis]);
        let size = [side(0).max(narrowest).round(), side(1).round()];
        let middle = [0, 1, 2].map(|axis| ends[axis][0] + extent[axis] / 2.0);
        Ok(Self { view, middle, scale, size, zoom: 1.0 })
    }

    /// The same picture with this many pixels per unit of the drawing.
    pub(crate) fn zoomed(&self, zoom: f64) -> Self {
        Self { scale: self.scale * zoom, size: self.size.map(|side| side * zoom), zoom, ..*self }
    }

    /// Returns a point in pixels from the upper left corner, and towards the eye.
    pub(crate) fn place(&self, point: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.view.turned(point);
        [
            self.size[0] / 2.0 + (x - self.middle[0]) * self.scale,
            self.size[1] / 2.0 - (y - self.middle[1]) * self.scale,
            (z - self.middle[2]) * self.scale,
        ]
    }
}

/// Returns the layers of a picture of the solid.
pub(crate) fn solid(scene: &SpaceScene, camera: &SpaceCamera, cut: Option<Plane>) -> Vec<Vec<Triangle>> {
    let mut sheet = Sheet::new(camera);
    for facet in &scene.facets {
        let Some(normal) = facing(camera, facet.corners) else { continue };
        let front = normal[2] > 0.0;
        let colour = if front {
            // Less light comes between the sides of a crack.
            shaded(lit(facet.colour, normal), if facet.broken { 0.84 } else { 1.0 })
        } else if scene.closed {
            // Seen through gaps only, such as those of joints that soften.
            shaded(facet.colour, 0.4)
        } else {
            lit(mix(facet.colour, INSIDE, 0.5), normal.map(|x| -x))
        };
        let (side, size) = (if front { Side::Front } else { Side::Back }, size(facet.corners));
        for (corners, edges) in clipped(facet, cut) {
            sheet.add(corners, Paint::solid(colour), side, edges, size);
        }
    }
    if let Some(plane) = cut {
        for tetrahedron in &scene.tetrahedra {
            let outside = |facet: usize| tetrahedron.facets[facet] != Edge::Element;
            let Some(section) = plane.section(tetrahedron.corners, tetrahedron.facets, outside) else {
                continue;
            };
            let [a, b, c, d] = tetrahedron.corners;
            let size = size([a, b, c]).max(size([a, b, d])).max(size([a, c, d])).max(size([b, c, d]));
            for (corners, edges) in section.triangles(Edge::None) {
                // The colours of sections are those of the scale.
                sheet.add(corners, Paint::solid(tetrahedron.colour), Side::Front, edges, size);
            }
        }
    }
    vec![sheet.finish()]
}

/// Returns the layers of a picture of the cracks: the cracks and the far side of the solid, and its near
/// side, which is transparent.
pub(crate) fn cracks(scene: &SpaceScene, camera: &SpaceCamera, cut: Option<Plane>) -> Vec<Vec<Triangle>> {
    let (mut far, mut near) = (Sheet::new(camera), Sheet::new(camera));
    far.line = Some(Paint::solid([200, 208, 216]));
    near.line = Some(Paint { cover: 130, colour: LINE });
    for facet in &scene.facets {
        let Some(normal) = facing(camera, facet.corners) else { continue };
        let size = size(facet.corners);
        for (corners, edges) in clipped(facet, cut) {
            // Cracks are facets here.
            let drawn = [Edge::Feature, Edge::Cut];
            let edges = edges.map(|edge| if drawn.contains(&edge) { edge } else { Edge::None });
            let sides = match normal[2] > 0.0 {
                _ if facet.broken => [Side::Unseen; 2],
                true => [Side::Unseen, Side::Front],
                false => [Side::Front, Side::Unseen],
            };
            far.add(corners, Paint::solid([247, 249, 251]), sides[0], edges, size);
            near.add(corners, GLASS, sides[1], edges, size);
        }
    }
    let mut facets = Sheet::new(camera);
    facets.rims = true;
    for crack in &scene.cracks {
        let Some(normal) = facing(camera, crack.corners) else { continue };
        let normal = if normal[2] < 0.0 { normal.map(|x| -x) } else { normal };
        let facet = Facet { corners: crack.corners, colour: [0; 3], edges: [Edge::Element; 3], broken: true };
        // These colours are darker than those of fields: light makes them paler.
        let colour = mix(crack.colour, [255; 3], PALER * bright(normal));
        for (corners, edges) in clipped(&facet, cut) {
            facets.add(corners, Paint::solid(colour), Side::Front, edges, size(crack.corners));
        }
    }
    let mut first = far.finish();
    first.extend(facets.finish());
    vec![first, near.finish()]
}

/// Colour and cover of a wall that is before the middle of the picture, and of its lines.
const NEAR_WALL: [Paint; 2] =
    [Paint { cover: 26, colour: [120, 144, 168] }, Paint { cover: 150, colour: WALL }];
/// Colours of a wall behind the middle.
const FAR_WALL: [Rgb; 2] = [[236, 240, 244], [176, 186, 196]];

/// Returns the triangles of walls that are behind the middle of the visible parts, and those before it, which
/// are transparent.
pub(crate) fn walls(walls: &[WallTriangle], camera: &SpaceCamera, cut: Option<Plane>) -> [Vec<Triangle>; 2] {
    let (mut far, mut near) = (Sheet::new(camera), Sheet::new(camera));
    far.line = Some(Paint::solid(FAR_WALL[1]));
    near.line = Some(NEAR_WALL[1]);
    (far.rims, near.rims) = (true, true);
    let [middle, low] = [&camera.view.high, &camera.view.low];
    let middle: [f64; 3] = each(|axis| 0.5 * (middle[axis] + low[axis]));
    let middles = middles(walls);
    for wall in walls {
        let Some(normal) = facing(camera, wall.corners) else { continue };
        let edges = each(|k| if wall.lines >> k & 1 == 1 { Edge::Feature } else { Edge::None });
        let facet = Facet { corners: wall.corners, colour: [0; 3], edges, broken: false };
        // The side away from the middle of the wall is outside, or, of a flat wall, that away from the middle
        // of all. A wall is far if its outside is turned away from the eye.
        let along = |middle: [f64; 3]| {
            let away = camera.view.turned(each(|axis| wall.corners[0][axis] - middle[axis]));
            (0..3).fold(0.0, |sum, axis| sum + normal[axis] * away[axis])
        };
        let size = size(wall.corners);
        let own = along(middles[wall.wall as usize]);
        let outside = if own.abs() > 1e-6 * size { own } else { along(middle) };
        let is_far = outside * normal[2] < 0.0;
        for (corners, edges) in clipped(&facet, cut) {
            if is_far {
                let normal = if normal[2] < 0.0 { normal.map(|x| -x) } else { normal };
                let shade = 0.93 + 0.07 * bright(normal);
                far.add(corners, Paint::solid(shaded(FAR_WALL[0], shade)), Side::Front, edges, size);
            } else {
                near.add(corners, NEAR_WALL[0], Side::Front, edges, size);
            }
        }
    }
    [far.finish(), near.finish()]
}

/// Returns the middle of the box around each wall, by its number.
fn middles(walls: &[WallTriangle]) -> Vec<[f64; 3]> {
    let count = walls.iter().map(|wall| wall.wall as usize + 1).max().unwrap_or(0);
    let mut bounds = vec![EMPTY; count];
    for wall in walls {
        let own = &mut bounds[wall.wall as usize];
        *own = union(*own, bounds_of(wall.corners));
    }
    bounds.into_iter().map(|bounds| bounds.map(|[low, high]| 0.5 * (low + high))).collect()
}

/// Returns the spheres and the lines of contacts in pixels, but those whose middle is cut away.
pub(crate) fn beads(grains: &GrainScene, camera: &SpaceCamera, cut: Option<Plane>) -> Beads {
    let is_left = |point: [f64; 3]| {
        cut.is_none_or(|plane| {
            (0..3).fold(-plane.offset, |sum, axis| sum + plane.normal[axis] * point[axis]) <= 0.0
        })
    };
    let spheres = grains.spheres.iter().filter(|sphere| is_left(sphere.centre)).map(|sphere| Bead {
        centre: camera.place(sphere.centre),
        radius: sphere.radius * camera.scale,
        colour: sphere.colour,
    });
    let middle = |[a, b]: [[f64; 3]; 2]| each(|axis| 0.5 * (a[axis] + b[axis]));
    let rods = grains.chains.iter().filter(|chain| is_left(middle(chain.ends))).map(|chain| Rod {
        ends: chain.ends.map(|end| camera.place(end)),
        radius: chain.radius * camera.scale,
        colour: chain.colour,
    });
    // Spheres would hide the lines between them.
    let spheres = if grains.chains.is_empty() { spheres.collect() } else { Vec::new() };
    Beads { spheres, rods: rods.collect() }
}

/// Returns the parts of a facet that a cut leaves, with the kinds of their edges.
fn clipped(facet: &Facet, cut: Option<Plane>) -> impl Iterator<Item = ([[f64; 3]; 3], [Edge; 3])> {
    let left = cut.map(|plane| plane.clipped(facet.corners, facet.edges, Edge::Cut));
    let whole = left.is_none().then_some((facet.corners, facet.edges));
    let parts = left.flatten().map(|polygon| polygon.triangles(Edge::None));
    whole.into_iter().chain(parts.into_iter().flatten())
}

/// Returns the unit normal of a facet, to the right, upwards and to the eye; `None` if it has no area.
fn facing(camera: &SpaceCamera, corners: [[f64; 3]; 3]) -> Option<[f64; 3]> {
    let normal = camera.view.turned(normal(corners));
    let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
    (length > 0.0 && length.is_finite()).then(|| each(|axis| normal[axis] / length))
}

/// Returns the normal of a facet, twice as long as its area.
fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v]: [[f64; 3]; 2] = each(|end| each(|axis| [b, c][end][axis] - a[axis]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Returns the side of a square with twice the area of a facet, m: about the length of its edges.
fn size(corners: [[f64; 3]; 3]) -> f64 {
    let [x, y, z] = normal(corners);
    (x * x + y * y + z * z).sqrt().sqrt()
}

/// Returns the share of light on a facet, from 0 to 1. It is soft: a facet has some of it unless it is turned
/// away from the light.
fn bright(normal: [f64; 3]) -> f64 {
    let along = normal[0] * LIGHT[0] + normal[1] * LIGHT[1] + normal[2] * LIGHT[2];
    (0.5 + 0.5 * along).clamp(0.0, 1.0)
}

/// Shades of a facet that is turned away from the light, and of one that is turned to it.
pub(crate) const SHADES: [f64; 2] = [0.64, 1.03];

/// Returns a colour in the light.
fn lit(colour: Rgb, normal: [f64; 3]) -> Rgb {
    shaded(colour, SHADES[0] + (SHADES[1] - SHADES[0]) * bright(normal))
}

/// Returns a colour that is darker or, above 1, brighter.
pub(crate) fn shaded(colour: Rgb, shade: f64) -> Rgb {
    each(|channel| (f64::from(colour[channel]) * shade + 0.5).min(255.0) as u8)
}

/// How a triangle takes part in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// It is drawn with lines.
    Front,
    /// It is drawn without lines.
    Back,
    /// It is not drawn, but shows where the surface turns away from the eye.
    Unseen,
}

/// The properties of a triangle before its lines are known.
#[derive(Clone, Copy)]
struct Piece {
    side: Side,
    edges: [Edge; 3],
    /// Size of its facet, units of the drawing.
    size: f64,
}

/// Triangles with their lines, in pixels.
struct Sheet<'a> {
    camera: &'a SpaceCamera,
    triangles: Vec<Triangle>,
    pieces: Vec<Piece>,
    /// Colour of all lines, if it is not that of their kind.
    line: Option<Paint>,
    /// Whether edges that belong to one triangle only are drawn.
    rims: bool,
}

impl<'a> Sheet<'a> {
    fn new(camera: &'a SpaceCamera) -> Self {
        Self { camera, triangles: Vec::new(), pieces: Vec::new(), line: None, rims: false }
    }

    fn add(&mut self, corners: [[f64; 3]; 3], paint: Paint, side: Side, edges: [Edge; 3], size: f64) {
        let corners = each(|k| self.camera.place(corners[k]));
        let size = size * self.camera.scale / self.camera.zoom;
        self.triangles.push(Triangle { corners, paint, lines: [Stroke::NONE; 3] });
        self.pieces.push(Piece { side, edges, size });
    }

    /// Adds the lines: of every edge half in each of its two triangles. Where only one of them is drawn with
    /// lines, the surface turns away from the eye or ends: this edge is always drawn, and the other half of
    /// its line lies beside the triangle.
    fn finish(self) -> Vec<Triangle> {
        let Self { camera, mut triangles, pieces, line, rims } = self;
        let front = keys(&triangles, |place| pieces[place].side == Side::Front);
        let alone: Vec<u64> =
            front.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0].0).collect();
        // Kinds of edges whose other triangle is seen from behind.
        let mut turning: Vec<Option<Edge>> = vec![None; alone.len()];
        for (key, place, k) in edges(&triangles, |place| pieces[place].side != Side::Front) {
            if let Ok(found) = alone.binary_search(&key) {
                turning[found] = turning[found].max(Some(pieces[place].edges[k]));
            }
        }
        let mut turning = turning.into_iter();
        let mut beside = Vec::new();
        for same in front.chunk_by(|a, b| a.0 == b.0) {
            let fronts = || same.iter().map(|&(_, edge)| (edge as usize / 3, edge as usize % 3));
            let mut edge = fronts().map(|(place, k)| pieces[place].edges[k]).max().unwrap_or(Edge::None);
            let mut turns = false;
            if same.len() == 1 {
                let other = turning.next().flatten();
                turns = rims || other.is_some();
                edge = edge.max(other.unwrap_or(Edge::None));
                if other.is_none() && edge == Edge::Feature && line.is_none() {
                    // The facet on the other side of an angle has an edge with these ends, that on the other
                    // side of a crack has not.
                    edge = Edge::Crack;
                }
                if turns {
                    edge = edge.max(Edge::Feature);
                }
            }
            for (place, k) in fronts() {
                let stroke = stroke(edge, pieces[place].size, triangles[place].paint, line, camera.zoom);
                triangles[place].lines[k] = stroke;
                if (turns || [Edge::Cut, Edge::Crack].contains(&edge)) && stroke.width > 0.0 {
                    beside.extend(outer(&triangles[place], k, camera.zoom));
                }
            }
        }
        if pieces.iter().any(|piece| piece.side == Side::Unseen) {
            let mut sides = pieces.iter().map(|piece| piece.side);
            triangles.retain(|_| sides.next() != Some(Side::Unseen));
        }
        triangles.extend(beside);
        triangles
    }
}

/// Returns the edges of some triangles: a number that is the same for edges with the same ends, and three
/// times the number of the triangle plus that of the edge. They are sorted.
fn keys(triangles: &[Triangle], of: impl Fn(usize) -> bool) -> Vec<(u64, u32)> {
    let mut keys: Vec<(u64, u32)> =
        edges(triangles, of).map(|(key, place, k)| (key, (3 * place + k) as u32)).collect();
    keys.sort_unstable();
    keys
}

/// Returns the number for the ends of each edge of some triangles, with the numbers of the triangle and of
/// the edge.
fn edges(triangles: &[Triangle], of: impl Fn(usize) -> bool) -> impl Iterator<Item = (u64, usize, usize)> {
    triangles.iter().enumerate().filter(move |(place, _)| of(*place)).flat_map(|(place, triangle)| {
        let [a, b, c] = each(|k| key(triangle.corners[k]));
        let keys = [a.wrapping_add(b), b.wrapping_add(c), c.wrapping_add(a)];
        (0..3).map(move |k| (keys[k], place, k))
    })
}

/// Returns the line of an edge in a facet of this size, units of the drawing.
fn stroke(edge: Edge, size: f64, paint: Paint, line: Option<Paint>, zoom: f64) -> Stroke {
    // Half widths, units of the drawing.
    let (width, colour, share) = match edge {
        Edge::None => return Stroke::NONE,
        // Small elements have no lines, which would only darken the picture.
        Edge::Element => (0.3, LINE, 0.34 * ((size - 5.0) / 8.0).clamp(0.0, 1.0)),
        Edge::Grain => (0.4, LINE, 0.8),
        Edge::Cut | Edge::Feature => (0.6, LINE, 1.0),
        Edge::Crack => (1.0, CRACK, 1.0),
    };
    let width = f64::min(width, 0.12 * size);
    if width < 0.05 || share <= 0.0 {
        return Stroke::NONE;
    }
    let paint = line.unwrap_or_else(|| Paint { colour: mix(paint.colour, colour, share), ..paint });
    Stroke { width: width * zoom, paint }
}

/// How far behind its edge the outer half of a line lies, units of the drawing: a surface that continues
/// there hides it, also beyond a narrow gap.
const BEHIND: f64 = 2.0;

/// Returns the half of a line that lies beside the triangle.
fn outer(triangle: &Triangle, k: usize, zoom: f64) -> impl Iterator<Item = Triangle> {
    let stroke = triangle.lines[k];
    let [a, b, c] = [0, 1, 2].map(|next| triangle.corners[(k + next) % 3]);
    let (x, y) = (b[0] - a[0], b[1] - a[1]);
    let length = (x * x + y * y).sqrt();
    // To the side on which the triangle is not.
    let inside = x * (c[1] - a[1]) - y * (c[0] - a[0]);
    let share = if inside > 0.0 { stroke.width / length } else { -stroke.width / length };
    let out = [y * share, -x * share];
    let along = [x * stroke.width / length, y * stroke.width / length];
    let moved = |[x, y, z]: [f64; 3], beside: f64, by: f64| {
        [x + beside * out[0] + by * along[0], y + beside * out[1] + by * along[1], z - BEHIND * zoom]
    };
    // Beyond its ends the line reaches around corners.
    let quads = [
        [moved(a, 0.0, 0.0), moved(b, 0.0, 0.0), moved(b, 1.0, 0.0), moved(a, 1.0, 0.0)],
        [moved(a, 0.0, -1.0), moved(a, 0.0, 0.0), moved(a, 1.0, 0.0), moved(a, 1.0, -1.0)],
        [moved(b, 0.0, 0.0), moved(b, 0.0, 1.0), moved(b, 1.0, 1.0), moved(b, 1.0, 0.0)],
    ];
    let drawn = length > 0.0 && inside != 0.0;
    quads.into_iter().filter(move |_| drawn).flat_map(move |[a, b, c, d]| {
        [[a, b, c], [a, c, d]].map(|corners| Triangle {
            corners,
            paint: stroke.paint,
            lines: [Stroke::NONE; 3],
        })
    })
}

/// Returns a number that is different for different points, as far as 64 bits can distinguish them.
fn key(point: [f64; 3]) -> u64 {
    let mut key = 0x9e37_79b9_7f4a_7c15;
    for x in point {
        // Adding 0.0 makes both zeros one.
        let mixed = (key ^ (x + 0.0).to_bits()).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        key = (mixed ^ mixed >> 29).wrapping_mul(0x94d0_49bb_1331_11eb) ^ mixed >> 32;
    }
    key
}

#[cfg(test)]
mod tests {
    use fdem_simulation::Mode;

    use super::*;
    use crate::picture::raster::draw;
    use crate::run::frame::CrackKind;
    use crate::run::pictures::crack_colour;
    use crate::space::facets::FACETS;

    const SIZE: usize = 120;
    const BLUE: Rgb = [60, 120, 200];
    const RED: Rgb = [200, 60, 40];

    /// The unit cube as six tetrahedra around its diagonal, moved.
    fn cube(by: [f64; 3]) -> Vec<[[f64; 3]; 4]> {
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];
        let element = |(k, order): (usize, [usize; 3])| {
            let mut element = [by; 4];
            for (corner, axis) in (1..).zip(order) {
                element[corner] = element[corner - 1];
                element[corner][axis] += 1.0;
            }
            if k > 2 {
                element.swap(0, 1);
            }
            element
        };
        orders.into_iter().enumerate().map(element).collect()
    }

    /// Whether a facet is on a side of a cube.
    fn outside(facet: [[f64; 3]; 3], by: [f64; 3]) -> bool {
        let on = |axis: usize, at: f64| facet.iter().all(|corner| corner[axis] == at);
        (0..3).any(|axis| on(axis, by[axis]) || on(axis, by[axis] + 1.0))
    }

    /// The scene of a cube: all its lines are those of features or of elements.
    fn scene(by: [f64; 3], colour: Rgb) -> SpaceScene {
        let mut scene = SpaceScene { closed: true, ..SpaceScene::default() };
        for corners in cube(by) {
            let facets = FACETS.map(|facet| facet.map(|corner| corners[corner]));
            let out = facets.map(|facet| outside(facet, by));
            for (corners, _) in facets.into_iter().zip(out).filter(|(_, out)| *out) {
                // The edges of the cube are parallel to an axis.
                let edge = |k: usize| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    let axes = (0..3).filter(|&axis| a[axis] != b[axis]).count();
                    if axes == 1 { Edge::Feature } else { Edge::Element }
                };
                scene.facets.push(Facet { corners, colour, edges: [0, 1, 2].map(edge), broken: false });
            }
            let facets = out.map(|out| if out { Edge::Cut } else { Edge::Element });
            scene.tetrahedra.push(Tetrahedron { corners, colour, facets });
        }
        scene
    }

    /// Two scenes as one.
    fn both(mut one: SpaceScene, other: SpaceScene) -> SpaceScene {
        one.facets.extend(other.facets);
        one.tetrahedra.extend(other.tetrahedra);
        one.cracks.extend(other.cracks);
        one
    }

    /// Looks at the point (0.5, 0.5, 0.5) with 80 pixels per metre.
    fn camera(azimuth: f64, elevation: f64) -> SpaceCamera {
        let view = SpaceView::between([0.0; 3], [1.0; 3], 0.0).seen_from(azimuth, elevation);
        let size = [SIZE as f64; 2];
        SpaceCamera { view, middle: view.turned([0.5; 3]), scale: 80.0, size, zoom: 1.0 }
    }

    fn at(pixels: &[u8], [column, row]: [usize; 2]) -> Rgb {
        let place = 3 * (row * SIZE + column);
        [pixels[place], pixels[place + 1], pixels[place + 2]]
    }

    fn seen(scene: &SpaceScene, camera: &SpaceCamera, cut: Option<Plane>) -> Vec<u8> {
        draw([SIZE; 2], &solid(scene, camera, cut))
    }

    /// Number of pixels that are not white.
    fn painted(pixels: &[u8]) -> usize {
        pixels.chunks(3).filter(|pixel| *pixel != [255; 3]).count()
    }

    #[test]
    fn a_cube_along_an_axis_is_a_square_with_an_outline() {
        let directions = [
            ([0.0, 0.0], [0.0, -1.0, 0.0]),
            ([90.0, 0.0], [1.0, 0.0, 0.0]),
            ([0.0, 90.0], [0.0, 0.0, 1.0]),
            ([180.0, 0.0], [0.0, 1.0, 0.0]),
            ([0.0, -90.0], [0.0, 0.0, -1.0]),
        ];
        for ([azimuth, elevation], eye) in directions {
            let camera = camera(azimuth, elevation);
            assert_eq!(camera.view.eye().map(|x| x + 0.0), eye);
            let pixels = seen(&scene([0.0; 3], BLUE), &camera, None);
            let face = lit(BLUE, [0.0, 0.0, 1.0]);
            // The square reaches from 20 to 100; its diagonals are lines of elements.
            assert_eq!([[60, 30], [25, 40], [95, 70]].map(|place| at(&pixels, place)), [face; 3], "{eye:?}");
            assert_eq!(
                [[60, 18], [10, 60], [102, 60], [60, 110]].map(|place| at(&pixels, place)),
                [[255; 3]; 4]
            );
            for place in [[20, 45], [99, 75], [45, 20], [75, 99]] {
                let found = at(&pixels, place);
                assert!(
                    found.iter().zip(face).all(|(&line, face)| line < face),
                    "{eye:?} {place:?} {found:?}"
                );
            }
        }
    }

    #[test]
    fn the_side_to_the_light_is_brightest() {
        let pixels = seen(&scene([0.0; 3], [200; 3]), &camera(30.0, 25.0), None);
        // The top, the left and the right side.
        let [top, left, right] = [[60, 24], [35, 70], [90, 70]].map(|place| at(&pixels, place)[0]);
        assert!(top > left && left > right && right > 140, "{top} {left} {right}");
    }

    #[test]
    fn a_cube_hides_the_one_behind_it() {
        let (front, behind) = ([0.0; 3], [0.25, 1.5, 0.0]);
        let both = both(scene(front, BLUE), scene(behind, RED));
        let pixels = seen(&both, &camera(0.0, 0.0), None);
        let [blue, red] = [BLUE, RED].map(|colour| lit(colour, [0.0, 0.0, 1.0]));
        assert_eq!([[60, 30], [95, 60], [110, 60]].map(|place| at(&pixels, place)), [blue, blue, red]);
        let pixels = seen(&both, &camera(180.0, 0.0), None);
        assert_eq!([[60, 30], [20 + 2, 45], [95, 60]].map(|place| at(&pixels, place)), [red, red, blue]);
    }

    #[test]
    fn the_order_of_the_facets_changes_nothing() {
        let mut scene = both(scene([0.0; 3], BLUE), scene([0.5, 0.75, 0.125], RED));
        let colour = crack_colour(CrackKind::Broken(Mode::Shear));
        scene.cracks =
            scene.facets.iter().map(|facet| CrackFacet { corners: facet.corners, colour }).collect();
        let camera = camera(30.0, 25.0);
        let cut = Some(Plane { normal: [1.0, -1.0, 0.5], offset: 0.4 });
        let pixels = |scene: &SpaceScene| {
            [solid(scene, &camera, None), solid(scene, &camera, cut), cracks(scene, &camera, cut)]
                .map(|layers| draw([SIZE; 2], &layers))
        };
        let before = pixels(&scene);
        assert!(before.iter().all(|pixels| painted(pixels) > 2000) && before[0] != before[1]);
        assert!(pixels(&scene) == before, "the same again");
        scene.facets.reverse();
        scene.tetrahedra.rotate_left(5);
        scene.cracks.rotate_left(7);
        assert!(pixels(&scene) == before);
    }

    #[test]
    fn a_cut_takes_away_what_is_before_it_and_shows_the_section() {
        let camera = camera(0.0, 0.0);
        let scene = both(scene([0.0; 3], BLUE), scene([0.0, 1.5, 0.0], RED));
        for (y, colour) in [(0.25, BLUE), (0.75, BLUE), (1.75, RED)] {
            let pixels = seen(&scene, &camera, Some(Plane { normal: [0.0, -1.0, 0.0], offset: -y }));
            // The colour is that of the element, without light.
            assert_eq!([[30, 45], [90, 75]].map(|place| at(&pixels, place)), [colour; 2], "{y}");
        }
        let all = seen(&scene, &camera, Some(Plane { normal: [0.0, -1.0, 0.0], offset: -3.0 }));
        assert_eq!(painted(&all), 0);
    }

    /// Half of a cube: the eye sees the section, a rectangle in a direction aslant.
    #[test]
    fn the_section_of_a_cube_is_the_exact_polygon() {
        let camera = camera(0.0, 0.0);
        let scene = scene([0.0; 3], BLUE);
        // The plane z = 1 - y: the section covers the whole square, and nothing is seen of the top.
        let pixels = seen(&scene, &camera, Some(Plane { normal: [0.0, -1.0, 1.0], offset: 0.0 }));
        assert_eq!([[60, 30], [30, 60], [90, 80]].map(|place| at(&pixels, place)), [BLUE; 3]);
        // x = z from the front: a triangle of the front side is left.
        let pixels = seen(&scene, &camera, Some(Plane { normal: [1.0, 0.0, 1.0], offset: 1.0 }));
        let face = lit(BLUE, [0.0, 0.0, 1.0]);
        for row in 22..98_usize {
            // The line is 0.6 wide on both sides.
            let end = row;
            assert_eq!(at(&pixels, [end + 2, row]), [255; 3], "{row}");
            if end > 24 && row.abs_diff(120 - end) > 3 {
                assert_eq!(at(&pixels, [end - 3, row]), face, "{row}");
            }
        }
    }

    #[test]
    fn an_open_surface_shows_its_inside() {
        let mut scene = scene([0.0; 3], BLUE);
        scene.tetrahedra.clear();
        scene.closed = false;
        let cut = Some(Plane { normal: [0.0, -1.0, 0.0], offset: -0.5 });
        let pixels = seen(&scene, &camera(0.0, 0.0), cut);
        assert_eq!(at(&pixels, [60, 45]), lit(mix(BLUE, INSIDE, 0.5), [0.0, 0.0, 1.0]));
    }

    #[test]
    fn lines_of_elements_are_seen_if_there_is_room_for_them() {
        let camera = camera(0.0, 0.0);
        let coarse = seen(&scene([0.0; 3], BLUE), &camera, None);
        let face = lit(BLUE, [0.0, 0.0, 1.0]);
        let diagonal = |pixels: &[u8]| (30..90).filter(|&k| at(pixels, [k, 119 - k]) != face).count();
        let other = |pixels: &[u8]| (30..90).filter(|&k| at(pixels, [k, k]) != face).count();
        assert!(diagonal(&coarse).max(other(&coarse)) == 60);
        let small = SpaceCamera { scale: 4.0, ..camera };
        let Some(triangle) = solid(&scene([0.0; 3], BLUE), &small, None)[0]
            .iter()
            .find(|triangle| triangle.paint == Paint::solid(face))
            .copied()
        else {
            panic!("nothing is drawn")
        };
        // The elements are four pixels wide: only the lines of features are drawn.
        assert_eq!(triangle.lines.iter().filter(|line| line.width > 0.0).count(), 2);
    }

    #[test]
    fn cracks_are_seen_through_the_solid_in_the_colour_of_their_mode() {
        let mut scene = scene([0.0; 3], BLUE);
        let corners = [[0.1, 0.5, 0.1], [0.9, 0.5, 0.1], [0.5, 0.5, 0.9]];
        let mut found = Vec::new();
        for mode in [Mode::Tension, Mode::Shear, Mode::Mixed] {
            scene.cracks = vec![CrackFacet { corners, colour: crack_colour(CrackKind::Broken(mode)) }];
            let pixels = draw([SIZE; 2], &cracks(&scene, &camera(0.0, 0.0), None));
            found.push(at(&pixels, [60, 70]));
            assert!(painted(&pixels) > 6000, "the solid is seen");
            assert!(at(&pixels, [30, 40]).iter().all(|&channel| channel > 200), "and pale");
            // From behind.
            let pixels = draw([SIZE; 2], &cracks(&scene, &camera(180.0, 0.0), None));
            assert!(at(&pixels, [60, 70]) != at(&pixels, [30, 40]));
        }
        let [tension, shear, mixed] = found[..] else { panic!("three modes") };
        assert!(tension.iter().all(|&channel| channel < 130), "dark: {tension:?}");
        assert!(shear[0] > 150 && shear[2] > 130 && shear[1] < 110, "magenta: {shear:?}");
        assert!(mixed[0] > 180 && mixed[2] < 110, "orange: {mixed:?}");
        // Parts before a cut are removed, and the crack with them.
        let cut = Some(Plane { normal: [0.0, -1.0, 0.0], offset: -0.75 });
        let pixels = draw([SIZE; 2], &cracks(&scene, &camera(0.0, 0.0), cut));
        assert!(at(&pixels, [60, 70]).iter().all(|&channel| channel > 200));
    }

    #[test]
    fn edges_of_cracks_are_darker_than_other_lines() {
        let mut scene = scene([0.0; 3], BLUE);
        for facet in &mut scene.facets {
            facet.edges = facet.edges.map(|edge| if edge == Edge::Element { Edge::Crack } else { edge });
        }
        let pixels = seen(&scene, &camera(0.0, 0.0), None);
        let dark = (30..90).filter(|&k| at(&pixels, [k, 119 - k]) == CRACK || at(&pixels, [k, k]) == CRACK);
        assert_eq!(dark.count(), 60, "the diagonal");
    }

    #[test]
    fn what_has_no_place_or_no_size_is_not_drawn() {
        let blue = scene([0.0; 3], BLUE);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            let corners = [[0.0, -1.0, 0.0], [bad, -1.0, 0.0], [0.0, -1.0, bad]];
            let mut scene = both(blue.clone(), SpaceScene::default());
            let edges = [Edge::Crack; 3];
            scene.facets.push(Facet { corners, colour: RED, edges, broken: true });
            scene.cracks.push(CrackFacet { corners, colour: crack_colour(CrackKind::Open) });
            let tetrahedron = [[0.0; 3], corners[0], corners[1], corners[2]];
            scene.tetrahedra.push(Tetrahedron { corners: tetrahedron, colour: RED, facets: [Edge::Cut; 4] });
            let camera = camera(0.0, 0.0);
            assert!(seen(&scene, &camera, None) == seen(&blue, &camera, None), "{bad}");
            let cut = Some(Plane { normal: [0.1, -1.0, 0.2], offset: -0.4 });
            assert!(seen(&scene, &camera, cut) == seen(&blue, &camera, cut), "{bad}");
            let drawn = |scene: &SpaceScene| draw([SIZE; 2], &cracks(scene, &camera, cut));
            assert!(drawn(&scene) == drawn(&blue), "{bad}");
        }
        let camera = camera(0.0, 0.0);
        let mut point = both(SpaceScene::default(), SpaceScene::default());
        let edges = [Edge::Feature; 3];
        point.facets.push(Facet { corners: [[0.5; 3]; 3], colour: RED, edges, broken: false });
        point.cracks.push(CrackFacet {
            corners: [[0.5; 3]; 3],
            colour: crack_colour(CrackKind::Broken(Mode::Shear)),
        });
        for scene in [point, SpaceScene::default()] {
            assert_eq!(painted(&seen(&scene, &camera, None)), 0);
            assert_eq!(painted(&draw([SIZE; 2], &cracks(&scene, &camera, None))), 0);
        }
    }
}
