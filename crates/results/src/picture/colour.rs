//! Colours: two ramps with even steps of lightness, and colours outside the ramps.

use crate::arrays::each;

/// Red, green and blue.
pub(crate) type Rgb = [u8; 3];

/// Ramp for overlaps, pale to dark. Both ramps have equal steps of lightness and hue in OKLCH, so that equal
/// steps of a value look equal, also in grey.
pub(crate) const HEAT: [Rgb; 17] = [
    [242, 204, 122],
    [245, 185, 92],
    [248, 165, 65],
    [249, 143, 42],
    [249, 120, 32],
    [245, 97, 39],
    [237, 75, 54],
    [226, 53, 69],
    [212, 32, 83],
    [194, 12, 95],
    [174, 4, 104],
    [153, 0, 110],
    [131, 5, 112],
    [108, 12, 110],
    [87, 16, 105],
    [66, 18, 95],
    [48, 18, 83],
];

/// Ramp for counts and sizes, pale to dark.
pub(crate) const SEA: [Rgb; 17] = [
    [199, 229, 147],
    [170, 221, 141],
    [137, 214, 139],
    [98, 206, 141],
    [41, 197, 146],
    [1, 184, 153],
    [4, 170, 156],
    [13, 155, 156],
    [5, 142, 153],
    [4, 128, 150],
    [8, 115, 146],
    [2, 102, 143],
    [1, 88, 141],
    [1, 72, 144],
    [30, 58, 132],
    [40, 44, 115],
    [43, 32, 97],
];

/// Colour of elements without contact, which is in no ramp.
pub(crate) const ALONE: Rgb = [203, 205, 208];

/// Colour at a share from 0 to 1 of the ramp. Shares outside are clamped.
pub(crate) fn at(ramp: &[Rgb; 17], share: f64) -> Rgb {
    // NaN, such as 0/0, has the first colour.
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let place = share * (ramp.len() - 1) as f64;
    let stop = (place as usize).min(ramp.len() - 2);
    mix(ramp[stop], ramp[stop + 1], place - stop as f64)
}

/// Mixes two colours: `from` at a share of 0, `to` at 1.
pub(crate) fn mix(from: Rgb, to: Rgb, share: f64) -> Rgb {
    each(|channel| {
        let (from, to) = (f64::from(from[channel]), f64::from(to[channel]));
        (from + (to - from) * share).round() as u8
    })
}

/// Formats a colour as `#rrggbb`.
pub(crate) fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_run_from_pale_to_dark() {
        for ramp in [HEAT, SEA] {
            let lightness = |[r, g, b]: Rgb| 2 * u32::from(r) + 5 * u32::from(g) + u32::from(b);
            assert!(ramp.windows(2).all(|pair| lightness(pair[0]) > lightness(pair[1])));
        }
    }

    #[test]
    fn values_outside_get_the_colour_of_the_end() {
        assert_eq!(at(&HEAT, -1.0), HEAT[0]);
        assert_eq!(at(&HEAT, f64::NAN), HEAT[0]);
        assert_eq!(at(&HEAT, 7.0), HEAT[16]);
        assert_eq!(at(&HEAT, 1.0 / 16.0), HEAT[1]);
        assert_eq!(hex(at(&SEA, 1.0)), "#2b2061");
    }
}
