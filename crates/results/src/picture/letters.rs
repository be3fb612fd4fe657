//! Outlines and widths of letters in the embedded fonts.

use std::sync::OnceLock;

use resvg::tiny_skia::{Path, PathBuilder, Transform};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::picture::svg::Anchor;

/// Units of the fonts per font size.
const EM: f64 = 2048.0;

/// Width of a text at a font size, from its start to the place of a next letter.
pub(crate) fn width(text: &str, size: f64, bold: bool) -> f64 {
    lay(text, bold, |_, _, _| ()) / EM * size
}

/// Returns the outlines of the letters of a text, to be filled by the nonzero rule, or `None` for a text
/// without letters. `x` and `y` are the place of its anchor on the base line, `y` downwards.
///
/// Letters are placed from left to right, one glyph for each character: scripts that run to the left, and
/// marks that combine, are not shaped. A character that the font lacks is drawn as an empty box.
pub(crate) fn outline(text: &str, [x, y]: [f64; 2], anchor: Anchor, size: f64, bold: bool) -> Option<Path> {
    let mut pen = Pen { path: PathBuilder::new(), left: 0.0 };
    let width = lay(text, bold, |face, glyph, left| {
        pen.left = left as f32;
        // A space has no outline.
        let _ = face.outline_glyph(glyph, &mut pen);
    });
    let unit = size / EM;
    let before = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => width * unit / 2.0,
        Anchor::End => width * unit,
    };
    let unit = unit as f32;
    // The vertical axis of fonts points upwards.
    pen.path.finish()?.transform(Transform::from_row(unit, 0.0, 0.0, -unit, (x - before) as f32, y as f32))
}

/// Calls `put` for the glyph of each character, with its left end in units of the font. Returns the right end
/// of the last.
fn lay(text: &str, bold: bool, mut put: impl FnMut(&Face<'_>, GlyphId, f64)) -> f64 {
    let face = &faces()[usize::from(bold)];
    let (mut x, mut last) = (0.0, None);
    for character in text.chars() {
        // Glyph 0 is the empty box.
        let glyph = face.glyph_index(character).unwrap_or(GlyphId(0));
        x += last.map_or(0.0, |last| kerning(face, last, glyph));
        put(face, glyph, x);
        x += face.glyph_hor_advance(glyph).map_or(0.0, f64::from);
        last = Some(glyph);
    }
    x
}

/// Change of the distance of two letters that follow each other.
fn kerning(face: &Face<'_>, left: GlyphId, right: GlyphId) -> f64 {
    let mut tables =
        face.tables().kern.iter().flat_map(|kern| kern.subtables).filter(|table| table.horizontal);
    tables.find_map(|table| table.glyphs_kerning(left, right)).map_or(0.0, f64::from)
}

/// The regular and the bold font.
fn faces() -> &'static [Face<'static>; 2] {
    static FACES: OnceLock<[Face<'static>; 2]> = OnceLock::new();
    FACES.get_or_init(|| {
        [dejavu::sans::regular(), dejavu::sans::bold()]
            .map(|font| Face::parse(font, 0).expect("the embedded fonts are whole"))
    })
}

/// Appends the outlines of glyphs to a path.
struct Pen {
    path: PathBuilder,
    /// Left end of the glyph.
    left: f32,
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.left + x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.left + x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.path.quad_to(self.left + x1, y1, self.left + x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.path.cubic_to(self.left + x1, y1, self.left + x2, y2, self.left + x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_letters() {
        // In DejaVu Sans, an "M" is 1767 of 2048 units wide and an "i" 569.
        for (letter, units) in [("M", 1767.0), ("i", 569.0)] {
            assert_eq!(width(&letter.repeat(10), 2048.0, false), 10.0 * units, "{letter}");
        }
        assert_eq!(width("M", 1024.0, false), 1767.0 / 2.0);
        assert!(width("MMMM", 20.0, true) > width("MMMM", 20.0, false));
        assert_eq!(width("", 20.0, false), 0.0);
    }

    #[test]
    fn slanted_letters_stand_closer() {
        for bold in [false, true] {
            let alone = width("A", 20.0, bold) + width("V", 20.0, bold);
            let pair = width("AV", 20.0, bold);
            assert!(pair < 0.98 * alone && pair > 0.8 * alone, "{pair} of {alone}");
        }
    }

    #[test]
    fn outlines_are_where_the_text_is() {
        let text = "Contacts of 8 beds";
        let wide = width(text, 20.0, false) as f32;
        for (anchor, left) in
            [(Anchor::Start, 300.0), (Anchor::Middle, 300.0 - wide / 2.0), (Anchor::End, 300.0 - wide)]
        {
            let ink = outline(text, [300.0, 50.0], anchor, 20.0, false).unwrap().bounds();
            // A letter has a gap of at most a tenth of its size on each side.
            assert!((0.0..2.0).contains(&(ink.left() - left)), "{ink:?}");
            assert!((0.0..2.0).contains(&(left + wide - ink.right())), "{ink:?}");
            // Letters are about three quarters of their size high, and these do not reach below the base line
            // by more than their curves do.
            assert!((33.0..37.0).contains(&ink.top()) && (50.0..51.0).contains(&ink.bottom()), "{ink:?}");
        }
        let below = outline("p", [0.0, 50.0], Anchor::Start, 20.0, false).unwrap().bounds();
        assert!(below.bottom() > 53.0 && below.top() > 37.0, "{below:?}");
        assert!(outline(" ", [0.0, 50.0], Anchor::Start, 20.0, false).is_none());
    }

    #[test]
    fn a_character_without_a_glyph_is_a_box() {
        // No font has this noncharacter.
        for bold in [false, true] {
            let ink = outline("\u{10ffff}", [0.0, 50.0], Anchor::Start, 20.0, bold).unwrap().bounds();
            assert!(ink.height() > 10.0 && ink.width() > 5.0, "{ink:?}");
        }
    }
}
