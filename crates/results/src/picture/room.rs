//! Check for enough memory before drawing, so that missing memory is an error and does not end the program.

use crate::network::Network;
use crate::picture::error::PictureError;

/// Bytes of a scene per element and per contact, including sorted copies.
const PER_ELEMENT: usize = 80;
const PER_CONTACT: usize = 152;

/// Bytes for the letters, the text of a drawing and its compression.
const REST: usize = 32 << 20;

/// Bytes per pixel of a drawing in 3D: samples with their depths, layers, pixels with and without opacity,
/// the file.
const PER_PIXEL: f64 = 30.0;

/// Largest size of the drawing of a network with its margins, in its own units.
pub(crate) const LARGEST_PAGE: [f64; 2] = [1320.0, 800.0];

/// Bytes of SVG per element and contact: 120 characters, in a string that grows.
const PER_SHAPE: usize = 360;

/// Bytes of the scene of a network.
pub(crate) fn of_scene<const D: usize>(network: &Network<'_, D>) -> usize {
    of_counts(network.space.centres.len(), network.couples.len())
}

/// Bytes of a scene with these numbers of elements and contacts.
pub(crate) fn of_counts(elements: usize, contacts: usize) -> usize {
    PER_ELEMENT * elements + PER_CONTACT * contacts
}

/// Bytes of a drawing of this size in its own units, with `scale` pixels per unit.
pub(crate) fn of_pixels([width, height]: [f64; 2], scale: f64) -> usize {
    REST + (PER_PIXEL * scale * scale * width * height) as usize
}

/// Bytes of an SVG with `count` shapes.
pub(crate) fn of_shapes(count: usize) -> usize {
    REST + PER_SHAPE * count
}

/// Checks that the process can allocate this number of bytes.
///
/// # Errors
/// [`PictureError::OutOfMemory`].
pub(crate) fn check(bytes: usize) -> Result<(), PictureError> {
    let mut room = Vec::<u8>::new();
    room.try_reserve_exact(bytes).map_err(|_| PictureError::OutOfMemory { bytes })?;
    // Keeps the compiler from removing the unused allocation.
    std::hint::black_box(&mut room);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_system_has_is_refused() {
        assert_eq!(check(1 << 20), Ok(()));
        let error = check(isize::MAX as usize).unwrap_err();
        assert!(error.to_string().starts_with("no memory for 9223372036854775807 bytes"), "{error}");
    }
}
