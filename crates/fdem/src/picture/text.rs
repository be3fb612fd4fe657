//! Fits texts into a given width, measured with the embedded fonts.

use resvg::usvg;

use crate::picture::encode;
use crate::picture::svg::{escape, shortened};

/// Upper bound of the width of a letter over its size. Texts that fit by this bound are not measured.
const WIDEST: f64 = 1.2;

/// Font size of titles, and the smallest size of long titles.
pub(crate) const OF_TITLES: [f64; 2] = [17.0, 11.0];

/// Width of a text at a font size.
pub(crate) fn width(text: &str, size: f64, bold: bool) -> f64 {
    const LARGE: f64 = 100.0;
    if text.trim().is_empty() {
        return 0.0;
    }
    let weight = if bold { "bold" } else { "normal" };
    let svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="1" height="1"><text y="{LARGE}" font-family="DejaVu Sans" font-size="{LARGE}" font-weight="{weight}">{}</text></svg>"#,
        escape(text)
    );
    match usvg::Tree::from_str(&svg, &encode::options()) {
        Ok(tree) => f64::from(tree.root().abs_bounding_box().width()) / LARGE * size,
        Err(_) => WIDEST * size * text.chars().count() as f64,
    }
}

/// Fits a text into the width `room`. Returns the text and its font size: a long text gets a smaller size, down to `least`, and beyond that loses its middle.
pub(crate) fn fitting(text: &str, room: f64, [size, least]: [f64; 2], bold: bool) -> (String, f64) {
    let count = text.chars().count();
    if WIDEST * size * count as f64 <= room {
        return (text.to_owned(), size);
    }
    let wide = width(text, 1.0, bold);
    if size * wide <= room {
        return (text.to_owned(), size);
    }
    if least * wide <= room {
        // Sizes are multiples of half a unit, so that few different sizes occur.
        return (text.to_owned(), ((2.0 * room / wide).floor() / 2.0).max(least));
    }
    let mut most = (count as f64 * room / (least * wide)) as usize;
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
    fn widths_are_those_of_the_letters() {
        // In DejaVu Sans, an "M" is 1767 of 2048 units wide and an "i" 569. The difference of ten letters does not depend on the gaps at the ends.
        for (letter, units) in [("M", 1767.0), ("i", 569.0)] {
            let ten = width(&letter.repeat(20), 20.0, false) - width(&letter.repeat(10), 20.0, false);
            assert!((ten / (10.0 * units / 2048.0 * 20.0) - 1.0).abs() < 0.01, "{letter}: {ten}");
        }
        assert!(width("MMMM", 20.0, true) > width("MMMM", 20.0, false));
        assert_eq!(width("", 20.0, false), 0.0);
    }

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
