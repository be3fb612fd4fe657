//! Clumps of `[[grains]]`.

use fdem_simulation::grains::{ClumpShape, random_turns};

use crate::text::file::{ClumpOrientation, Grains, ModelFile};

/// A clump: place of the origin of its shape, m, rotation, a vector whose length is the angle, rad, and
/// scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedClump {
    pub(crate) at: [f64; 3],
    pub(crate) turn: [f64; 3],
    pub(crate) scale: f64,
}

/// The shape of the clumps of a table; `None` for single spheres. `discs`: their thickness, m.
pub(crate) fn shape(grains: &Grains, discs: Option<f64>) -> Option<ClumpShape> {
    let clump = grains.clump.as_ref()?;
    let centres = clump.iter().map(|sphere| sphere.at.in_space()).collect();
    Some(ClumpShape::new(centres, clump.iter().map(|sphere| sphere.radius).collect(), discs))
}

/// Clumps whose spheres do not hang together.
pub(crate) fn in_pieces(file: &ModelFile, shapes: &[Option<ClumpShape>]) -> Vec<String> {
    let is_in_pieces = |shape: &Option<ClumpShape>| shape.as_ref().is_some_and(|shape| !shape.is_one_piece());
    let tables = file.grains.iter().zip(shapes).filter(|(_, shape)| is_in_pieces(shape));
    let words = |name: &str| {
        format!(
            "[[grains]] \"{name}\": the spheres of its clump do not all touch, and move together all the same"
        )
    };
    tables.map(|(grains, _)| words(&grains.name)).collect()
}

/// The rotations of the clumps of a table, rad.
pub(crate) fn turns(grains: &Grains, discs: bool, count: usize) -> Vec<[f64; 3]> {
    match grains.orientation {
        Some(ClumpOrientation::Plane(angle)) => vec![[0.0, 0.0, angle.to_radians()]; count],
        Some(ClumpOrientation::Space(vector)) => vec![vector.map(f64::to_radians); count],
        Some(ClumpOrientation::Random(_)) | None => random_turns(count, discs, grains.seed),
    }
}
