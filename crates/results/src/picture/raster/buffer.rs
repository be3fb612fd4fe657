//! The depth buffer: depths and colours of the samples of some rows of pixels.

use crate::picture::colour::Rgb;

/// Parts of a pixel in which corners of triangles and samples are placed.
pub(crate) const PARTS: f64 = 256.0;

/// Places of `S` samples, parts of a pixel from its upper left corner, along x and along y.
pub(crate) type Places<const S: usize> = [[f64; S]; 2];

/// A grid of 2 × 2 samples, row by row.
pub(crate) const GRID: Places<4> = [[64.0, 192.0, 64.0, 192.0], [64.0, 64.0, 192.0, 192.0]];

/// 16 samples. No two are in one of 16 columns or in one of 16 rows, and there is one in each of 4 × 4
/// squares, so that edges in all directions are smooth.
pub(crate) const SPREAD: Places<16> = {
    let mut places = [[0.0; 16]; 2];
    let mut k = 0;
    while k < 16 {
        let (column, row) = (k / 4, k % 4);
        places[0][k] = (16 * (4 * column + row) + 8) as f64;
        places[1][k] = (16 * (4 * row + 3 - column) + 8) as f64;
        k += 1;
    }
    places
};

/// A channel of a colour, rounded to the nearest from 0 to 255. Without instructions of SSE 4.1, `round`
/// would call a function for each.
#[inline]
pub(super) fn byte(channel: f32) -> u8 {
    (channel + 0.5) as u8
}

/// A colour, and how much it covers, from 0 to 255. In the first layer all colours cover fully.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Paint {
    pub(crate) cover: u8,
    pub(crate) colour: Rgb,
}

impl Paint {
    pub(crate) fn solid(colour: Rgb) -> Self {
        Self { cover: 255, colour }
    }

    pub(super) fn packed(self) -> u32 {
        let [red, green, blue] = self.colour;
        u32::from_be_bytes([self.cover, red, green, blue])
    }
}

/// Depths and colours of the `S` samples of each pixel, of all rows or of a band of them. Depths increase
/// towards the eye.
pub(crate) struct Raster<const S: usize> {
    pub(super) places: &'static Places<S>,
    pub(super) width: usize,
    /// First row and number of rows, pixels.
    pub(super) top: usize,
    pub(super) height: usize,
    pub(super) depths: Vec<[f32; S]>,
    pub(super) colours: Vec<[u32; S]>,
    /// A depth of each pixel that no sample of it is below: parts behind it are not seen.
    pub(super) hidden: Vec<f32>,
}

/// A sample where nothing is drawn. No colour of a triangle is less, so that nothing is drawn at samples that
/// are outside of it, whose depth is infinite.
pub(super) const NOTHING: u32 = 0;

impl<const S: usize> Raster<S> {
    /// Creates an empty image of the given size in pixels.
    pub(crate) fn new(places: &'static Places<S>, [width, height]: [usize; 2]) -> Self {
        let count = width * height;
        Self {
            places,
            width,
            top: 0,
            height,
            depths: vec![[f32::NEG_INFINITY; S]; count],
            colours: vec![[NOTHING; S]; count],
            hidden: vec![f32::NEG_INFINITY; count],
        }
    }

    /// Empties the image, which begins at row `top` from now on.
    pub(super) fn clear(&mut self, top: usize) {
        self.top = top;
        self.depths.fill([f32::NEG_INFINITY; S]);
        self.colours.fill([NOTHING; S]);
        self.hidden.fill(f32::NEG_INFINITY);
    }

    /// Returns red, green and blue of each pixel on white, row by row from the top.
    pub(crate) fn pixels(&self) -> Vec<u8> {
        let mut pixels = Vec::with_capacity(3 * self.hidden.len());
        append(&mut pixels, std::slice::from_ref(self), self.hidden.len());
        pixels
    }
}

/// Appends the first `count` pixels of layers that lie above each other, on white.
pub(super) fn append<const S: usize>(pixels: &mut Vec<u8>, layers: &[Raster<S>], count: usize) {
    let Some((first, above)) = layers.split_first() else {
        pixels.resize(pixels.len() + 3 * count, 255);
        return;
    };
    let white = Paint::solid([255; 3]).packed();
    for place in 0..count {
        let mut colours = first.colours[place];
        for colour in &mut colours {
            *colour = if *colour == NOTHING { white } else { *colour };
        }
        if !above.is_empty() {
            lay(&mut colours, &first.depths[place], above, place);
        }
        let one = colours[0];
        if colours.iter().fold(0, |differ, colour| differ | (colour ^ one)) == 0 {
            pixels.extend_from_slice(&one.to_be_bytes()[1..]);
            continue;
        }
        // Two channels are summed together: neither sum exceeds 16 bits.
        let (mut outer, mut middle) = (0_u32, 0_u32);
        for colour in colours {
            outer += colour & 0x00ff_00ff;
            middle += colour >> 8 & 0xff;
        }
        let mean = |sum: u32| ((sum + S as u32 / 2) / S as u32) as u8;
        pixels.extend_from_slice(&[mean(outer >> 16), mean(middle), mean(outer & 0xffff)]);
    }
}

/// Lays the samples of further layers over those of the first.
fn lay<const S: usize>(colours: &mut [u32; S], depths: &[f32; S], layers: &[Raster<S>], place: usize) {
    let mut depths = *depths;
    for layer in layers {
        let (over, nearer) = (&layer.colours[place], &layer.depths[place]);
        for k in 0..S {
            if over[k] != NOTHING && nearer[k] >= depths[k] {
                colours[k] = laid(colours[k], over[k]);
                depths[k] = nearer[k];
            }
        }
    }
}

/// Returns a colour with another over it.
fn laid(below: u32, above: u32) -> u32 {
    let ([_, r, g, b], [cover, red, green, blue]) = (below.to_be_bytes(), above.to_be_bytes());
    let cover = u32::from(cover);
    let mixed = |below: u8, above: u8| {
        ((u32::from(above) * cover + u32::from(below) * (255 - cover) + 127) / 255) as u8
    };
    u32::from_be_bytes([255, mixed(r, red), mixed(g, green), mixed(b, blue)])
}
