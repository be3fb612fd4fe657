//! Pictures of bodies of any shape and their contacts: meshes in 3D, spheres and walls, bodies of a labelled
//! image.

use crate::picture::caption::Caption;
use crate::picture::error::PictureError;
use crate::picture::plots;
use crate::picture::scene::{Bond, Joint, OverlapRange, Scene, Shapes};
use crate::picture::{drawing, encode, room};

/// Largest number of triangles in a picture or a report of bodies.
pub const MOST_FACETS: usize = 1_000_000;

/// Bodies and the contacts between them.
///
/// # Shapes
/// `centres` and `radii` have one entry per body. `facets` and `owners` have one entry per triangle: its
/// corners, as indices of `points`, and its body. In 2D, `z` is 0.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<'a> {
    /// Number of dimensions, 2 or 3.
    pub dimensions: usize,
    /// Centre of each body.
    pub centres: &'a [[f64; 3]],
    /// Radius of each body that is drawn as a disc or a sphere; 0 for those that are drawn as triangles.
    pub radii: &'a [f64],
    /// Corners of triangles.
    pub points: &'a [[f64; 3]],
    /// Triangles of the surfaces of the bodies; in 2D, of the bodies themselves.
    pub facets: &'a [[u32; 3]],
    /// Body of each triangle.
    pub owners: &'a [u32],
    /// Whether the triangles are walls, which are drawn transparently.
    pub walls: bool,
    /// The contacts.
    pub joints: &'a [BodyJoint],
    /// Name of the value by which contacts are coloured.
    pub value: &'a str,
}

/// Two bodies that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyJoint {
    /// Indices of the bodies.
    pub bodies: [u32; 2],
    /// Point of contact.
    pub point: [f64; 3],
    /// Direction from the first to the second body; zeros if it is undefined.
    pub normal: [f64; 3],
    /// Value that colours the contact. Larger values are drawn on top.
    pub value: f64,
}

/// Draws bodies and their contacts as SVG.
///
/// # Errors
/// The errors of [`svg`](crate::picture::svg), and [`PictureError::TooMany`] if there are more than
/// [`MOST_FACETS`] triangles.
///
/// # Panics
/// If an index of a contact or a triangle is out of range.
pub fn bodies_svg(bodies: &Bodies<'_>, caption: &Caption<'_>) -> Result<String, PictureError> {
    drawing::svg(&scene(bodies, caption)?)
}

/// Like [`bodies_svg`], as a PNG file. `width`: 200 to 10,000 pixels, by default twice the width of the SVG.
///
/// # Errors
/// The errors of [`bodies_svg`], [`PictureError::Width`] and [`PictureError::Png`].
///
/// # Panics
/// As [`bodies_svg`].
pub fn bodies_png(
    bodies: &Bodies<'_>,
    caption: &Caption<'_>,
    width: Option<u32>,
) -> Result<Vec<u8>, PictureError> {
    drawing::png(&scene(bodies, caption)?, width)
}

/// Draws the distributions of the contacts of bodies, their values and directions, and of the radii as SVG.
///
/// # Errors
/// The errors of [`bodies_svg`].
///
/// # Panics
/// As [`bodies_svg`].
pub fn bodies_plots_svg(bodies: &Bodies<'_>, caption: &Caption<'_>) -> Result<String, PictureError> {
    Ok(plots::svg(&scene(bodies, caption)?, &no_radial()))
}

/// Like [`bodies_plots_svg`], as a PNG file. `width`: as for [`bodies_png`].
///
/// # Errors
/// The errors of [`bodies_png`].
///
/// # Panics
/// As [`bodies_svg`].
pub fn bodies_plots_png(
    bodies: &Bodies<'_>,
    caption: &Caption<'_>,
    width: Option<u32>,
) -> Result<Vec<u8>, PictureError> {
    let scene = scene(bodies, caption)?;
    let scale = drawing::scale(width, plots::whole_size(&scene)[0])?;
    room::check(room::of_pixels(plots::whole_size(&scene), scale))?;
    encode::png(&plots::svg(&scene, &no_radial()), &[], scale)
}

/// The reason why bodies have no radial distribution.
pub(crate) fn no_radial() -> Result<crate::analysis::Radial, String> {
    Err("bodies have no radial distribution".to_owned())
}

/// Makes the scene of bodies.
pub(crate) fn scene(bodies: &Bodies<'_>, caption: &Caption<'_>) -> Result<Scene, PictureError> {
    let Bodies { dimensions, centres, radii, points, facets, owners, walls, joints, value } = *bodies;
    assert_eq!(
        (centres.len(), facets.len()),
        (radii.len(), owners.len()),
        "one radius and one body for each"
    );
    if facets.len() > MOST_FACETS {
        return Err(PictureError::TooMany { what: "triangles", found: facets.len(), most: MOST_FACETS });
    }
    let shapes = 24 * points.len() + 16 * facets.len();
    room::check(room::of_counts(centres.len(), joints.len()) + shapes)?;
    let finite = |point: &[f64; 3]| point.iter().all(|x| x.is_finite());
    if let Some(index) = (0..centres.len()).find(|&k| !finite(&centres[k]) || !radii[k].is_finite()) {
        return Err(PictureError::NotFinite { index });
    }
    if let Some(index) = points.iter().position(|point| !finite(point)) {
        return Err(PictureError::NotFinite { index });
    }
    let mut coordination = vec![0_u32; centres.len()];
    let is_sphere = |body: u32| radii[body as usize] > 0.0;
    let bonds: Vec<Bond> = joints
        .iter()
        .map(|joint| {
            let [i, j] = joint.bodies;
            let mut ends = vec![i, j];
            ends.dedup();
            for &end in &ends {
                coordination[end as usize] += 1;
            }
            let [a, b] = [i, j].map(|body| centres[body as usize]);
            let distance = a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b)).sqrt();
            // The centre of a wall may be far from its contacts.
            let to = [i, j].map(|body| !walls || is_sphere(body));
            Bond {
                i,
                j,
                distance,
                overlap: joint.value,
                branch: joint.normal,
                leaves: false,
                joint: Some(Joint { point: joint.point, to }),
            }
        })
        .collect();
    let spheres = radii.iter().copied().filter(|&radius| radius > 0.0);
    let sizes = spheres.fold(None, |range: Option<[f64; 2]>, r| {
        Some(range.map_or([r, r], |[low, high]| [low.min(r), high.max(r)]))
    });
    Ok(Scene {
        dimensions,
        centres: centres.to_vec(),
        radii: radii.to_vec(),
        coordination,
        overlaps: OverlapRange::of(bonds.iter().map(|bond| bond.overlap).collect()),
        bonds,
        cell: None,
        are_points: false,
        of_forces: false,
        drawn: 1.0,
        sizes,
        shapes: Some(Shapes {
            value: value.to_owned(),
            points: points.to_vec(),
            facets: facets.to_vec(),
            owners: owners.to_vec(),
            walls,
        }),
        title: caption.title.to_owned(),
        unit: caption.unit.unwrap_or_default().to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 3]; 3] = [[-2.0, -2.0, -0.5], [3.0, -2.0, -0.5], [0.0, 4.0, -0.5]];
    const JOINTS: [BodyJoint; 2] = [
        BodyJoint { bodies: [0, 1], point: [0.5, 0.0, 0.0], normal: [1.0, 0.0, 0.0], value: 0.0 },
        BodyJoint { bodies: [0, 2], point: [0.0, 0.0, -0.5], normal: [0.0, 0.0, -1.0], value: 0.25 },
    ];

    fn floor(walls: bool) -> Bodies<'static> {
        Bodies {
            dimensions: 3,
            centres: &[[0.0; 3], [1.0, 0.0, 0.0], [0.3, 0.0, -0.5]],
            radii: &[0.5, 0.5, 0.0],
            points: &POINTS,
            facets: &[[0, 1, 2]],
            owners: &[2],
            walls,
            joints: &JOINTS,
            value: "depth",
        }
    }

    #[test]
    fn spheres_and_a_floor_are_drawn() {
        let caption = Caption { title: "floor", unit: Some("m") };
        for walls in [true, false] {
            let png = bodies_png(&floor(walls), &caption, Some(400)).unwrap();
            assert!(png.starts_with(b"\x89PNG"));
            let svg = bodies_svg(&floor(walls), &caption).unwrap();
            assert!(svg.contains("3 bodies, 2 contacts, 1.3333 per body") && svg.contains("depth"));
        }
        let plots = bodies_plots_svg(&floor(true), &caption).unwrap();
        assert!(plots.contains("contacts of a body") && plots.contains("bodies have no radial distribution"));
    }

    /// The line of a contact with a wall ends at the contact point; for any other body it ends at the centre.
    #[test]
    fn lines_end_at_walls() {
        let ends = |walls| {
            let scene = scene(&floor(walls), &Caption::default()).unwrap();
            drawing::lines(&scene, &scene.bonds[1]).into_iter().flatten().count()
        };
        assert_eq!((ends(true), ends(false)), (1, 2));
    }

    #[test]
    fn a_place_that_is_no_number_is_refused() {
        let mut bodies = floor(true);
        bodies.points = &[[0.0; 3], [f64::NAN; 3], [0.0; 3]];
        assert_eq!(bodies_svg(&bodies, &Caption::default()), Err(PictureError::NotFinite { index: 1 }));
    }
}
