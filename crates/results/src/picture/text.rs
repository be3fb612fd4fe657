//! Fits texts into a given width, measured with the embedded fonts.

use crate::picture::letters::width;
use crate::picture::svg::shortened;

/// Font size of titles, and the smallest size of long titles.
pub(crate) const OF_TITLES: [f64; 2] = [17.0, 11.0];

/// Fits a text into the width `room`. Returns the text and its font size: a long text gets a smaller size,
/// down to `least`, and beyond that loses its middle.
pub(crate) fn fitting(text: &str, room: f64, [size, least]: [f64; 2], bold: bool) -> (String, f64) {
    let wide = width(text, 1.0, bold);
    if size * wide <= room {
        return (text.to_owned(), size);
    }
    if least * wide <= room {
        // Sizes are multiples of half a unit, so that few different sizes occur.
        return (text.to_owned(), ((2.0 * room / wide).floor() / 2.0).max(least));
    }
    let mut most = (text.chars().count() as f64 * room / (least * wide)) as usize;
    loop {
        let short = shortened(text, most);
        if most <= 3 || width(&short, least, bold) <= room {
            return (short, least);
        }
        most -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_are_whole_while_there_is_room() {
        let title = "Impact of a sphere on a plate of glass, seen from the side";
        let wide = width(title, 17.0, true);
        assert_eq!(fitting(title, wide + 1.0, [17.0, 11.0], true), (title.to_owned(), 17.0));
        let (text, size) = fitting(title, 0.8 * wide, [17.0, 11.0], true);
        assert!(text == title && (13.0..=13.6).contains(&size), "{size}");
        let (text, size) = fitting(title, 0.3 * wide, [17.0, 11.0], true);
        assert!(text.contains('…') && size == 11.0 && text.starts_with("Imp") && text.ends_with("side"));
        let found = width(&text, 11.0, true);
        assert!(found <= 0.3 * wide && found > 0.25 * wide, "{found} of {}", 0.3 * wide);
    }
}
