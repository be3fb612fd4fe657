//! Colours of fields.

use crate::picture::colour::Rgb;

/// Colours of signed fields: blue for compression, red for tension, pale at zero. Colours at equal distance
/// from the middle are about equally light.
pub(crate) const SIGNED: [Rgb; 17] = [
    [9, 48, 112],
    [20, 70, 146],
    [36, 93, 176],
    [64, 118, 194],
    [99, 143, 208],
    [137, 170, 219],
    [175, 197, 229],
    [209, 220, 236],
    [235, 235, 235],
    [242, 218, 205],
    [243, 193, 170],
    [239, 163, 133],
    [229, 131, 100],
    [213, 97, 73],
    [189, 63, 54],
    [158, 32, 42],
    [117, 8, 32],
];

/// Colours of bodies and materials, used in turn.
pub(crate) const NUMBERED: [Rgb; 8] = [
    [127, 172, 214],
    [176, 157, 211],
    [126, 192, 153],
    [222, 180, 120],
    [150, 180, 188],
    [216, 143, 167],
    [184, 197, 118],
    [155, 165, 196],
];

/// Colour of elements without a value.
pub(crate) const NO_VALUE: Rgb = [203, 205, 208];

/// Returns the colour of a body or a material by its number. Consecutive numbers have different colours.
pub(crate) fn numbered_colour(number: u32) -> Rgb {
    NUMBERED[number as usize % NUMBERED.len()]
}
