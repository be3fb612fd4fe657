//! Conversion of SVG and pixels to PNG.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, fontdb};

use crate::picture::PictureError;

/// Pixels of an area of the drawing.
pub(crate) struct Layer {
    /// Upper left corner in the drawing.
    pub(crate) at: [f64; 2],
    /// Width and height, pixels.
    pub(crate) size: [usize; 2],
    /// Red, green and blue of each pixel, row by row.
    pub(crate) pixels: Vec<u8>,
}

/// Draws SVG over layers over a white background as a PNG file. `scale`: pixels per unit of the drawing.
pub(crate) fn png(svg: &str, layers: &[Layer], scale: f64) -> Result<Vec<u8>, PictureError> {
    let (size, pixels) = pixels(svg, layers, scale)?;
    file(size, &pixels)
}

/// As [`png`], but returns width and height and the red, green and blue of each pixel, row by row.
pub(crate) fn pixels(svg: &str, layers: &[Layer], scale: f64) -> Result<([u32; 2], Vec<u8>), PictureError> {
    let failed = |message: String| PictureError::Png { message };
    let tree = usvg::Tree::from_str(svg, &options()).map_err(|error| failed(error.to_string()))?;
    let round = |side: f32| (f64::from(side) * scale).round() as u32;
    let (width, height) = (round(tree.size().width()), round(tree.size().height()));
    let mut pixmap = Pixmap::new(width, height).ok_or_else(|| failed("it is too large".to_owned()))?;
    pixmap.fill(resvg::tiny_skia::Color::WHITE);
    for layer in layers {
        lay(&mut pixmap, layer, scale);
    }
    let zoom = scale as f32;
    resvg::render(&tree, Transform::from_scale(zoom, zoom), &mut pixmap.as_mut());
    let opaque = pixmap.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    Ok(([width, height], opaque))
}

/// Options for SVG text. Only the fonts embedded in this program are used.
pub(crate) fn options() -> usvg::Options<'static> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(dejavu::sans::regular().to_vec());
        fonts.load_font_data(dejavu::sans::bold().to_vec());
        fonts.set_sans_serif_family("DejaVu Sans");
        Arc::new(fonts)
    });
    usvg::Options { fontdb: Arc::clone(fonts), ..usvg::Options::default() }
}

/// Encodes red, green and blue of each pixel as a PNG file.
pub(crate) fn file([width, height]: [u32; 2], pixels: &[u8]) -> Result<Vec<u8>, PictureError> {
    let failed = |error: png::EncodingError| PictureError::Png { message: error.to_string() };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
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
    let data = pixmap.data_mut();
    for row in 0..rows {
        for column in 0..columns {
            let from = 3 * (row * layer.size[0] + column);
            let to = 4 * ((top + row) * width + left + column);
            data[to..to + 3].copy_from_slice(&layer.pixels[from..from + 3]);
        }
    }
}
