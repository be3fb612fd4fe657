//! Conversion of SVG and pixels to PNG. Texts are drawn from the outlines of their letters.

use resvg::tiny_skia::{Color, FillRule, Paint, Path, Pixmap, Transform};
use resvg::usvg::{self, roxmltree};

use crate::picture::error::PictureError;
use crate::picture::letters;
use crate::picture::svg::Anchor;

/// Pixels of an area of the drawing.
pub(crate) struct Layer {
    /// Upper left corner in the drawing.
    pub(crate) at: [f64; 2],
    /// Width and height, pixels.
    pub(crate) size: [usize; 2],
    /// Red, green and blue of each pixel, row by row.
    pub(crate) pixels: Vec<u8>,
}

/// Draws SVG over layers over a white background as a PNG file. Its texts are above everything else. `scale`:
/// pixels per unit of the drawing.
pub(crate) fn png(svg: &str, layers: &[Layer], scale: f64) -> Result<Vec<u8>, PictureError> {
    let (size, pixels) = pixels(svg, layers, scale)?;
    file(size, &pixels)
}

/// Like [`png`], but returns width and height and the red, green and blue of each pixel, row by row.
pub(crate) fn pixels(svg: &str, layers: &[Layer], scale: f64) -> Result<([u32; 2], Vec<u8>), PictureError> {
    let failed = |message: String| PictureError::Png { message };
    let (tree, labels) = parsed(svg).map_err(|error| failed(error.to_string()))?;
    let round = |side: f32| (f64::from(side) * scale).round() as u32;
    let (width, height) = (round(tree.size().width()), round(tree.size().height()));
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| failed("it is too large".to_owned()))?;
    pixmap.fill(Color::WHITE);
    for layer in layers {
        lay(&mut pixmap, layer, scale);
    }
    let zoom = Transform::from_scale(scale as f32, scale as f32);
    resvg::render(&tree, zoom, &mut pixmap.as_mut());
    for (path, colour) in labels {
        let mut paint = Paint::default();
        paint.set_color(colour);
        pixmap.fill_path(&path, &paint, FillRule::Winding, zoom, None);
    }
    let (pixels, _) = pixmap.data().as_chunks();
    let opaque: Vec<[u8; 3]> = pixels.iter().map(|&[red, green, blue, _]| [red, green, blue]).collect();
    Ok(([width, height], opaque.into_flattened()))
}

/// Returns the shapes of a drawing, and its texts as outlines with their colours.
fn parsed(svg: &str) -> Result<(usvg::Tree, Vec<(Path, Color)>), usvg::Error> {
    let document = roxmltree::Document::parse(svg)?;
    // Without its feature "text", usvg skips texts.
    let tree = usvg::Tree::from_xmltree(&document, &usvg::Options::default())?;
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    Ok((tree, texts.filter_map(label).collect()))
}

/// Returns the outline and the colour of a text as `Svg` writes it: other attributes have no effect.
fn label(text: roxmltree::Node<'_, '_>) -> Option<(Path, Color)> {
    let number = |name: &str| text.attribute(name)?.parse::<f64>().ok();
    let anchor = match text.attribute("text-anchor") {
        Some("middle") => Anchor::Middle,
        Some("end") => Anchor::End,
        _ => Anchor::Start,
    };
    let bold = text.attribute("font-weight") == Some("bold");
    let path =
        letters::outline(text.text()?, [number("x")?, number("y")?], anchor, number("font-size")?, bold)?;
    let [_, red, green, blue] =
        u32::from_str_radix(text.attribute("fill")?.strip_prefix('#')?, 16).ok()?.to_be_bytes();
    Some((path, Color::from_rgba8(red, green, blue, 255)))
}

/// Encodes red, green and blue of each pixel as a PNG file.
pub(crate) fn file([width, height]: [u32; 2], pixels: &[u8]) -> Result<Vec<u8>, PictureError> {
    let failed = |error: png::EncodingError| PictureError::Png { message: error.to_string() };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // Higher compression takes several times as long for files that are hardly smaller.
    encoder.set_compression(png::Compression::Balanced);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(pixels).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

fn lay(pixmap: &mut Pixmap, layer: &Layer, scale: f64) {
    let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
    let [left, top] = layer.at.map(|x| (x * scale).round() as usize);
    let [columns, rows] =
        [layer.size[0].min(width.saturating_sub(left)), layer.size[1].min(height.saturating_sub(top))];
    let (pixels, _) = pixmap.data_mut().as_chunks_mut::<4>();
    let (colours, _) = layer.pixels.as_chunks();
    for row in 0..rows {
        let to = &mut pixels[(top + row) * width + left..][..columns];
        for ([red, green, blue, _], &colour) in to.iter_mut().zip(&colours[row * layer.size[0]..]) {
            [*red, *green, *blue] = colour;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::svg::{INK, PALE, Svg};

    /// Draws a label and returns the picture, 200 pixels wide and 100 high.
    fn drawn(draw: impl FnOnce(&mut Svg)) -> Vec<u8> {
        let mut svg = Svg::new(100.0, 50.0, "", "");
        draw(&mut svg);
        let (size, pixels) = pixels(&svg.finish(), &[], 2.0).unwrap();
        assert_eq!(size, [200, 100]);
        pixels
    }

    /// Left, top, right and bottom of the pixels that are not white.
    fn ink(pixels: &[u8]) -> [usize; 4] {
        let places: Vec<[usize; 2]> =
            (0..pixels.len() / 3).filter(|k| pixels[3 * k] < 200).map(|k| [k % 200, k / 200]).collect();
        let (across, up) = (places.iter().map(|at| at[0]), places.iter().map(|at| at[1]));
        [across.clone().min(), up.clone().min(), across.max(), up.max()].map(|end| end.expect("no ink"))
    }

    #[test]
    fn labels_are_drawn_where_they_are() {
        // An "L" reaches from 201 to 1130 of 2048 units to the right, and is 1493 high. A unit is 0.02
        // pixels.
        let letter = drawn(|svg| svg.label([10.0, 40.0], 20.48, Anchor::Start, INK, "L"));
        assert_eq!(ink(&letter), [24, 50, 42, 79]);
        let at = |x: usize, y: usize| letter[3 * (200 * y + x)];
        assert_eq!([at(25, 60), at(35, 78), at(35, 60)], [0x1f, 0x1f, 255]);
        let right = ink(&drawn(|svg| svg.label([90.0, 40.0], 20.48, Anchor::End, PALE, "L")));
        assert!((177..=180).contains(&right[2]), "{right:?}");
    }

    #[test]
    fn letters_have_holes_and_bold_ones_are_wider() {
        let letter = drawn(|svg| svg.bold([10.0, 40.0], 40.0, "o"));
        let [left, top, right, bottom] = ink(&letter);
        assert_eq!(letter[3 * (200 * usize::midpoint(top, bottom) + usize::midpoint(left, right))], 255);
        let plain = ink(&drawn(|svg| svg.label([10.0, 40.0], 40.0, Anchor::Start, INK, "o")));
        assert!(right > plain[2] + 2, "{right}, {plain:?}");
    }

    #[test]
    fn escaped_letters_are_drawn_too() {
        let [left, _, right, _] =
            ink(&drawn(|svg| svg.label([5.0, 40.0], 20.0, Anchor::Start, INK, "M<&\"M")));
        let wide = 2.0 * letters::width("M<&\"M", 20.0, false);
        assert!(((right - left) as f64 - wide).abs() < 10.0, "{left} {right} {wide}");
    }
}
