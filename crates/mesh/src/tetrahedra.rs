//! Unstructured meshes of tetrahedra, of even or graded size and good angles.
//!
//! [`tetrahedra`] meshes the inside of a [`Surface`]:
//! 1. The surface is checked, moved to the origin and scaled ([`Surface::check`]).
//! 2. Edges between faces are cut by the size; each face is meshed in its plane (`skin`).
//! 3. Delaunay's tetrahedra of these points are made. Where they lack a triangle of the skin, it is split
//!    (`recover`); the inside is found from facet to facet (`regions`).
//! 4. Points are inserted into spheres that are too large, then moved to where tetrahedra are even (`fill`).
//! 5. Thin tetrahedra are removed by flips, moves, and points that come and go (`improve`).
//!
//! [`add_polygons`] puts polygons, such as joints in rock, into a surface before it is meshed.
//!
//! Directions of edges are random, as cracks along facets need it. The same seed gives the same mesh on every
//! platform: decisions are exact, or use only operations that IEEE 754 defines.

mod check;
pub(crate) mod delaunay;
mod error;
mod fill;
mod improve;
mod mesh;
mod numbering;
pub(crate) mod order;
pub(crate) mod plane;
mod polygons;
mod predicates;
mod recover;
mod regions;
mod sharpest;
mod sizes;
mod skin;
mod surface;
pub(crate) mod vector;

pub(crate) use check::{finite, positive};
pub use error::{MeshError, THICK};
pub use mesh::Tetrahedra;
pub use polygons::{PolygonError, SNAP, add_polygons};
pub use sharpest::{SharpCorner, SharpEdge, sharpest_corner, sharpest_edge};
pub use surface::{INNER, OUTSIDE, Surface};
pub(crate) use vector::bounds;

use std::collections::BTreeMap;

use crate::Corners;
pub(crate) use crate::MOST_ELEMENTS as MOST;
use crate::grading::Grading;
use improve::body::Body;
use sizes::Sizes;
use skin::Skin;
use vector::{Point, minus, plus, times};

/// Volume of a tetrahedron over the cube of the mean edge, in a large mesh.
const VOLUME: f64 = 0.1;

/// Size over the mean thickness of a body from which the angles are below 8°: no mesh is made.
pub(crate) const FLAT: f64 = 12.0;

/// Smallest angle between facets of a mesh, degrees, below which it is made again from other random numbers,
/// also with polygons inside; how often at most; and by which share of the size it is finer each time.
const POOR: f64 = 8.0;
const POOR_WITHIN: f64 = 2.0;
const AGAIN: u64 = 6;

/// Elements in all meshes of a surface together, from which on it is not meshed again: it would take longer
/// than anyone waits.
const ENOUGH: usize = 1_000_000;
const FINER: f64 = 0.04;

/// Most rounds in which flat tetrahedra at the surface are left out.
const PEELS: usize = 8;

/// Length of edges at each place, in the unit of the coordinates.
pub type Size<'a> = dyn Fn([f64; 3]) -> f64 + Sync + 'a;

/// Meshes the inside of a surface with edges of the length `size`.
///
/// The mean edge is the size. Where `size` changes, it is made to grow by at most 0.3 times the distance, and
/// it is reduced near edges of the surface that are shorter. The surface of the mesh is that of the body; its
/// facets and edges are cut, and nothing else.
///
/// # Units
/// `size` is in the unit of the coordinates.
///
/// # Cost
/// About 15 s and 140 MB for a million elements, on one thread: two thirds of the time for six triangulations
/// of moved points, a quarter for the insertion of points.
///
/// # Errors
/// [`MeshError`]: surfaces that are not closed, are inside out or cross themselves; sizes that are not
/// positive or give more than [`MOST_ELEMENTS`](crate::MOST_ELEMENTS); [`MeshError::NotRecovered`] where
/// faces meet at very sharp angles.
///
/// # Source
/// The modules name the papers they follow. The whole is Delaunay refinement (J. R. Shewchuk, "Tetrahedral
/// mesh generation by Delaunay refinement", `SoCG` 1998) with the improvement of B. M. Klingner, J. R.
/// Shewchuk, "Aggressive tetrahedral mesh improvement", Proc. 16th Int. Meshing Roundtable (2007).
///
/// # Example
/// ```
/// use fdem_mesh::{shapes, tetrahedra::tetrahedra};
///
/// let cube = shapes::cuboid([0.0; 3], [1.0; 3])?;
/// let mesh = tetrahedra(&cube, &|_| 0.25, 1)?;
/// assert!(mesh.elements.len() > 300);
/// # Ok::<(), fdem_mesh::tetrahedra::MeshError>(())
/// ```
pub fn tetrahedra(surface: &Surface, size: &Size<'_>, seed: u64) -> Result<Tetrahedra, MeshError> {
    mesh_again(surface, size, false, seed, &|_| ())
}

/// Like [`tetrahedra`], with elements that are smaller near some places, however small these are.
///
/// # Errors
/// As [`tetrahedra`].
pub fn graded(surface: &Surface, grading: &Grading<3>, seed: u64) -> Result<Tetrahedra, MeshError> {
    moved(surface, grading, seed, &|_| ())
}

/// Like [`graded`], with nodes moved by `to`: a body of flat faces becomes one of round faces, if the moves
/// are small.
///
/// # Errors
/// As [`tetrahedra`].
pub fn moved(
    surface: &Surface,
    grading: &Grading<3>,
    seed: u64,
    to: &dyn Fn(&mut Tetrahedra),
) -> Result<Tetrahedra, MeshError> {
    let (low, high) = bounds(&surface.nodes);
    for near in &grading.near {
        let elements = near.cubes([low, high]) / VOLUME;
        if elements > MOST as f64 {
            return Err(MeshError::TooMany { elements });
        }
    }
    mesh_again(surface, &|place| grading.at(place), !grading.near.is_empty(), seed, to)
}

/// Meshes a surface, again if the angles are small.
fn mesh_again(
    surface: &Surface,
    size: &Size<'_>,
    varies: bool,
    seed: u64,
    to: &dyn Fn(&mut Tetrahedra),
) -> Result<Tetrahedra, MeshError> {
    surface.check()?;
    not_thin(surface, size)?;
    let mesh_once = |again: u64| -> Result<Tetrahedra, MeshError> {
        let finer = 1.0 - FINER * again as f64;
        let size = |place: Point| finer * size(place);
        let mut mesh = mesh_in_frame(surface, &size, varies, seed.wrapping_add(again << 32))?;
        to(&mut mesh);
        Ok(mesh)
    };
    let mesh = mesh_once(0)?;
    let mut best = (smallest_angle(&mesh), mesh);
    // Polygons meet at corners of any angle.
    let has_inner = surface.sides.iter().any(|sides| sides[0] == INNER);
    let enough = if has_inner { POOR_WITHIN } else { POOR };
    if best.0 >= enough || sharpest::of_surface(surface).is_some_and(|edge| edge.angle < enough) {
        return Ok(best.1);
    }
    let mut elements = best.1.elements.len();
    for again in 1..=AGAIN {
        if elements > ENOUGH {
            break;
        }
        let mesh = mesh_once(again)?;
        elements += mesh.elements.len();
        let angle = smallest_angle(&mesh);
        if angle > best.0 {
            best = (angle, mesh);
        }
        if best.0 >= enough {
            break;
        }
    }
    Ok(best.1)
}

/// The smallest angle between two facets of an element, degrees; 0 if an element is turned inside out.
fn smallest_angle(mesh: &Tetrahedra) -> f64 {
    let corners = |element: &[u32; 4]| element.map(|node| mesh.nodes[node as usize]);
    if mesh.elements.iter().any(|element| corners(element).measure() <= 0.0) {
        return 0.0;
    }
    mesh.elements.iter().flat_map(|element| corners(element).angles()).fold(180.0, f64::min)
}

/// Refuses regions that are much thinner than the size.
fn not_thin(surface: &Surface, size: &Size<'_>) -> Result<(), MeshError> {
    let origin = surface.nodes[0];
    let (low, high) = bounds(&surface.nodes);
    let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    // Six times the volume, twice the area, and the sum of the sizes weighted by that, of each region.
    let mut sums: BTreeMap<u32, [f64; 3]> = BTreeMap::new();
    for (facet, sides) in surface.sides.iter().enumerate() {
        let corners = surface.corners(facet);
        let middle = times(plus(plus(corners[0], corners[1]), corners[2]), 1.0 / 3.0);
        let [a, b, c] = corners.map(|corner| minus(corner, origin));
        let area = vector::length(vector::normal(a, b, c));
        let volume = vector::dot(a, vector::cross(b, c));
        for (&region, sign) in sides.iter().zip([1.0, -1.0]).filter(|(region, _)| **region < INNER) {
            let sum = sums.entry(region).or_default();
            *sum = [sum[0] + sign * volume, sum[1] + area, sum[2] + area * size(middle)];
        }
    }
    for (region, [volume, area, sizes]) in sums {
        // A plate has its volume over half of its surface as thickness.
        let thickness = 2.0 * volume / 3.0 / area;
        // No edge is longer than the body; a size that is NaN is reported later.
        let size = (sizes / area).min(longest);
        if sizes.is_finite() && size > FLAT * thickness {
            return Err(MeshError::Thin { region, thickness, size });
        }
    }
    Ok(())
}

/// Meshes a good surface, moved to the origin and scaled.
fn mesh_in_frame(
    surface: &Surface,
    size: &Size<'_>,
    varies: bool,
    seed: u64,
) -> Result<Tetrahedra, MeshError> {
    let frame = BodyFrame::around(&surface.nodes);
    let nodes = surface.nodes.iter().map(|&node| frame.inward(node)).collect();
    let inner = Surface { nodes, names: Vec::new(), ..surface.clone() };
    let mesh = mesh(&inner, &|place| size(frame.outward(place)) * frame.factor, varies, seed);
    let (body, skin) = mesh.map_err(|error| error.placed(|place| frame.outward(place)))?;
    let mut mesh = numbering::number(&body, &skin);
    frame.restore(&mut mesh.nodes, &inner.nodes, &surface.nodes);
    Ok(mesh)
}

/// Meshes a surface around the origin.
fn mesh(
    surface: &Surface,
    size: &dyn Fn(Point) -> f64,
    varies: bool,
    seed: u64,
) -> Result<(Body, Skin), MeshError> {
    let (low, high) = bounds(&surface.nodes);
    let mut sizes =
        Sizes::new(size, low, high, &surface.nodes, varies).map_err(|place| MeshError::Size { place })?;
    expect(surface, &sizes)?;
    skin::limit(surface, &mut sizes, low, high);
    let mut skin = Skin::new(surface, &sizes, seed);
    let (mut mesh, mut hits) = recover::recover(&mut skin)?;
    regions::classify(&mut mesh, &skin, &hits)?;
    for _ in 0..PEELS {
        if !regions::peel(&mesh, &mut skin, &hits) {
            break;
        }
        (hits, _) = recover::lock(&mut mesh, &skin);
        regions::classify(&mut mesh, &skin, &hits)?;
    }
    let bare = mesh.clone();
    let mut points = skin.points.clone();
    fill::fill(&mut mesh, &mut points, &sizes, seed)?;
    let (mesh, hits) = fill::smooth(mesh, &bare, &skin, &mut points, &sizes)?;
    drop(bare);
    let mut body = Body::new(&mesh, &skin, &hits, points);
    drop(mesh);
    improve::improve(&mut body, seed);
    Ok((body, skin))
}

/// Refuses meshes that would be too large.
fn expect(surface: &Surface, sizes: &Sizes<'_>) -> Result<(), MeshError> {
    let (mut volume, mut triangles) = (0.0, 0.0);
    for facet in 0..surface.facets.len() {
        let [a, b, c] = surface.corners(facet);
        let least = [a, b, c].map(|corner| sizes.at(corner)).into_iter().fold(f64::INFINITY, f64::min);
        if let Sizes::Even(_) = sizes {
            let sign =
                f64::from(surface.sides[facet][0] != OUTSIDE) - f64::from(surface.sides[facet][1] != OUTSIDE);
            volume += sign * vector::dot(a, vector::cross(b, c)) / 6.0;
        }
        triangles += vector::length(vector::normal(a, b, c)) / (least * least);
    }
    let elements = if let Sizes::Even(size) = sizes { volume / (VOLUME * size * size * size) } else { 0.0 };
    let elements = elements.max(triangles);
    if elements > MOST as f64 { Err(MeshError::TooMany { elements }) } else { Ok(()) }
}

/// Coordinates in which a body is around the origin and about 1 large.
struct BodyFrame {
    middle: Point,
    /// A power of 2.
    factor: f64,
}

impl BodyFrame {
    fn around(nodes: &[Point]) -> Self {
        let (low, high) = bounds(nodes);
        let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let mut factor = 1.0;
        while longest * factor > 1.0 {
            factor *= 0.5;
        }
        while longest > 0.0 && longest * factor < 0.5 {
            factor *= 2.0;
        }
        Self { middle: [0, 1, 2].map(|axis| low[axis] + 0.5 * (high[axis] - low[axis])), factor }
    }

    fn inward(&self, place: Point) -> Point {
        times(minus(place, self.middle), self.factor)
    }

    fn outward(&self, place: Point) -> Point {
        plus(times(place, 1.0 / self.factor), self.middle)
    }

    /// Puts points back in place. A coordinate that equals one of a node of the surface is mapped to exactly
    /// the coordinate of that node: points in planes along the axes stay in them.
    fn restore(&self, points: &mut [Point], inner: &[Point], outer: &[Point]) {
        for axis in 0..3 {
            let mut known: Vec<(f64, f64)> =
                inner.iter().zip(outer).map(|(inner, outer)| (inner[axis] + 0.0, outer[axis])).collect();
            known.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
            known.dedup_by_key(|pair| pair.0);
            for point in points.iter_mut() {
                let found = known.binary_search_by(|pair| pair.0.total_cmp(&(point[axis] + 0.0)));
                point[axis] = match found {
                    Ok(place) => known[place].1,
                    Err(_) => point[axis] / self.factor + self.middle[axis],
                };
            }
        }
    }
}
