//! Memory for a drawing, asked for before the work: where the system refuses it, an error says so instead of the end of the program.

use crate::network::Network;
use crate::picture::PictureError;

/// Bytes of a scene for each element and for each contact, with those of the sorted lists that are made of it.
const PER_ELEMENT: usize = 80;
const PER_CONTACT: usize = 152;

/// Bytes of the fonts, of the text of a drawing and of its compression.
const REST: usize = 32 << 20;

/// Bytes for each pixel of a drawing in space: samples with their depths, layers, the pixels with and without opacity, the file.
const PER_PIXEL: f64 = 26.0;

/// The largest drawing of a network with all that stands around it, in its own units.
pub(crate) const LARGEST_PAGE: [f64; 2] = [1320.0, 800.0];

/// Bytes of SVG for each element and contact: lines, or discs, of 120 characters, in a text that grows.
const PER_SHAPE: usize = 360;

/// The scene of a network.
pub(crate) fn of_scene<const D: usize>(network: &Network<'_, D>) -> usize {
    of_counts(network.space.centres.len(), network.couples.len())
}

/// The scene of so many elements and contacts.
pub(crate) fn of_counts(elements: usize, contacts: usize) -> usize {
    PER_ELEMENT * elements + PER_CONTACT * contacts
}

/// A drawing of this size in its own units, with so many pixels for each of them.
pub(crate) fn of_pixels([width, height]: [f64; 2], scale: f64) -> usize {
    REST + (PER_PIXEL * scale * scale * width * height) as usize
}

/// A drawing of so many shapes as SVG.
pub(crate) fn of_shapes(count: usize) -> usize {
    REST + PER_SHAPE * count
}

/// Whether the system has so many bytes left for this process.
///
/// # Errors
/// [`PictureError::OutOfMemory`].
pub(crate) fn check(bytes: usize) -> Result<(), PictureError> {
    let mut room = Vec::<u8>::new();
    room.try_reserve_exact(bytes).map_err(|_| PictureError::OutOfMemory { bytes })?;
    // Memory that nobody uses is not asked for otherwise.
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
