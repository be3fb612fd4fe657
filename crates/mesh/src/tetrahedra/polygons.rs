//! Polygons inside of bodies, such as joints in rock, that become facets of the mesh.
//!
//! Polygons are cut where they cross each other and the faces of the surface, and parts outside are left out.
//! Parts that would give elements much smaller than the mesh size are moved by less than a share of it:
//! polygons that nearly coincide become one, planes that pass a corner or a crossing go through it, and
//! corners and edges of a polygon that are near another polygon or a face end on it. All stays flat: planes
//! are moved along their normals, and corners within their planes. Nodes of round faces are moved along
//! these, onto polygons.
//!
//! - `sheet`: flat pieces, and the segments that two of them have in common.
//! - `snap`: moves of planes and corners.
//! - `warp`: moves of the nodes of round faces.
//! - `arrange`: all segments are cut by each other; the areas between them are triangulated plane by plane.

mod arrange;
mod error;
mod sheet;
mod snap;
mod warp;

pub use error::{PolygonError, SNAP};

use super::check::finite;
use super::skin::{FlatFaces, flat_faces};
use super::surface::Surface;
use super::vector::bounds;
use super::vector::{Point, distance};
use crate::grading::Grading;
use arrange::Arrangement;
use error::MOST;
use fdem_scenes::random::Random;
use sheet::Sheet;
use snap::{Snapping, sheets_of};
use warp::RoundNodes;

/// Distance over the width of a body up to which points are the same.
const SAME: f64 = 1e-9;

/// Distance from the mean plane over the width of a polygon up to which it is flat.
const FLAT: f64 = 1e-3;

/// How often polygons that are too close to others are moved to another place, by up to [`SNAP`], before they
/// are refused.
const ATTEMPTS: usize = 30;

/// The square of the number of polygons times the attempts, at most, if there are more than three.
const WORK: usize = 500_000;

/// Puts polygons, by their corners in order, into a surface as facets with [`INNER`](super::INNER) on both
/// sides. Returns the face of the facets of the first polygon; those of the others follow. Where polygons
/// coincide, the facets are those of the first.
///
/// Polygons are moved by up to 0.35 of the mesh size onto each other, onto faces, and to corners and
/// crossings. Polygons that are still too close to be meshed are tried again at other places, up to 0.35 of
/// the mesh size from their own; these places are random, but reproducible. Faces that are cut are
/// triangulated again; others keep their facets, but nodes of round faces are moved along these, onto
/// polygons. Without a polygon inside, the surface stays unchanged.
///
/// # Units
/// `size` is in the unit of the coordinates.
///
/// # Cost
/// In proportion to the square of the number of segments in which polygons meet each other and faces, and of
/// the number of polygons; up to 30 times where polygons are too close.
///
/// # Errors
/// [`PolygonError`]: polygons that are not flat, or are closer than 0.03 of the mesh size, or meet at less
/// than 3 degrees, after all moves.
///
/// # Example
/// ```
/// use fdem_mesh::Grading;
/// use fdem_mesh::shapes::cuboid;
/// use fdem_mesh::tetrahedra::{add_polygons, graded};
///
/// let mut cube = cuboid([0.0; 3], [1.0; 3])?;
/// let size = Grading::even(0.25);
/// // From outside to outside: it cuts the cube in two.
/// let level = vec![[-1.0, -1.0, 0.5], [2.0, -1.0, 0.5], [2.0, 2.0, 0.5], [-1.0, 2.0, 0.5]];
/// let face = add_polygons(&mut cube, &[level], &size)?;
/// let mesh = graded(&cube, &size, 1)?;
/// assert!(mesh.inner.len() > 30 && mesh.inner_faces.iter().all(|&of| of == face));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn add_polygons(
    surface: &mut Surface,
    polygons: &[Vec<Point>],
    size: &Grading<3>,
) -> Result<u32, PolygonError> {
    surface.check().map_err(PolygonError::Surface)?;
    if polygons.len() > MOST {
        return Err(PolygonError::TooMany { polygons: polygons.len() });
    }
    let first = surface.faces.iter().max().map_or(0, |most| most + 1).max(surface.names.len() as u32);
    let (low, high) = bounds(&surface.nodes);
    let wide = distance(low, high);
    let same = (SAME * wide).min(1e-4 * size.least());
    // Beyond the body, with room for moves.
    let margin = size.size.min(wide);
    let around = [low.map(|x| x - margin), high.map(|x| x + margin)];
    let mut sheets = Vec::with_capacity(polygons.len());
    for (polygon, corners) in polygons.iter().enumerate() {
        finite(corners).map_err(|_| PolygonError::NotFinite { polygon })?;
        let (mut sheet, off) = Sheet::of_polygon(corners).ok_or(PolygonError::NoArea { polygon })?;
        let (least, most) = bounds(corners);
        if off > FLAT * distance(least, most) {
            return Err(PolygonError::NotFlat { polygon, distance: off });
        }
        if sheet.triangles.is_empty() {
            return Err(PolygonError::Crossed { polygon });
        }
        sheet.clip(around);
        sheets.push(sheet);
    }
    let faces = flat_faces(surface);
    let mut random = Random::new(1);
    let mut by = vec![0.0; sheets.len()];
    let attempts = ATTEMPTS.min(WORK / (sheets.len() * sheets.len() + 1)).max(3);
    for attempt in 0.. {
        let moved: Vec<Sheet> = sheets.iter().zip(&by).map(|(sheet, &by)| sheet.moved(by)).collect();
        let (found, faults) = put(surface, &faces, moved, size, same, first);
        let Some(fault) = faults.first() else {
            if let Some(found) = found {
                *surface = found;
            }
            break;
        };
        if attempt == attempts {
            return Err(fault.clone());
        }
        // A polygon that is too close to another may be farther from it elsewhere.
        for fault in &faults {
            if let PolygonError::Close { polygons, place } | PolygonError::Sharp { polygons, place, .. } =
                fault
            {
                let number = polygons[random.below(2) as usize];
                by[number] = SNAP * size.at(*place) * random.between(-1.0, 1.0);
            }
        }
    }
    Ok(first)
}

/// Puts polygons into a surface, once. Returns the surface, if any of them is inside, and the problem if
/// there is one.
fn put(
    surface: &Surface,
    faces: &FlatFaces,
    polygons: Vec<Sheet>,
    size: &Grading<3>,
    same: f64,
    first: u32,
) -> (Option<Surface>, Vec<PolygonError>) {
    let mut snapping = Snapping::new(surface, faces, polygons, size, same);
    snapping.planes();
    let warped = RoundNodes::new(surface, faces).warped(surface, &snapping.polygons, size);
    let new_faces = warped.as_ref().map(flat_faces);
    let (surface, faces) = (warped.as_ref().unwrap_or(surface), new_faces.as_ref().unwrap_or(faces));
    if warped.is_some() {
        snapping.faces = sheets_of(surface, faces);
    }
    snapping.corners();
    let Snapping { faces: flat, polygons, .. } = snapping;
    if polygons.iter().all(|sheet| sheet.triangles.is_empty()) {
        return (None, Vec::new());
    }
    Arrangement::new(surface, faces, flat, polygons, size, same).surface(first)
}
