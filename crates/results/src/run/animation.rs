//! Animations: the frames of a run as a GIF.

use std::borrow::Cow;
use std::fmt;

use crate::fields::colours::{NO_VALUE, NUMBERED, numbered_colour};
use crate::fields::field::Field;
use crate::picture::PictureError;
use crate::picture::colour::{self, Rgb};
use crate::run::frame::Frame;
use crate::run::pictures::{CRACKS, Pictures};
use crate::space::drawing::{CRACK, SHADES, shaded};
use crate::space::{Show, SpaceFrame, SpacePictures};

/// Shortest display time of the last picture, in hundredths of a second.
const LAST: u16 = 150;

/// A GIF animation to which frames are added one by one. All frames share one palette, and each frame stores
/// only the rectangle that changed.
///
/// # Cost
/// About 0.1 s for a frame 900 pixels wide. A frame takes 100 to 300 kB if the field changes everywhere.
#[derive(Debug)]
pub struct Animation<'a> {
    pictures: Pictures<'a>,
    width: Option<u32>,
    reel: Reel,
}

/// A GIF animation of frames in three dimensions, as [`Animation`].
///
/// # Cost
/// About 0.1 s for a frame 900 pixels wide, and 0.1 s for 100,000 facets.
#[derive(Debug)]
pub struct SpaceAnimation<'a> {
    pictures: SpacePictures<'a>,
    width: Option<u32>,
    reel: Reel,
}

/// The pictures of an animation.
#[derive(Debug)]
struct Reel {
    delay: u16,
    palette: Palette,
    film: Option<Film>,
}

/// State of an animation that has at least one frame.
struct Film {
    encoder: gif::Encoder<Vec<u8>>,
    size: [u16; 2],
    /// The picture after the last frame, as indices into the palette.
    shown: Vec<u8>,
    /// The last frame. It is not written yet, because the final frame is shown longer.
    waiting: gif::Frame<'static>,
}

impl fmt::Debug for Film {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Film").field("size", &self.size).finish_non_exhaustive()
    }
}

/// The reason why an animation cannot be made.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AnimationError {
    /// A frame cannot be drawn.
    Picture(PictureError),
    /// The pictures cannot be encoded.
    Gif {
        /// The reason, as a message.
        message: String,
    },
    /// There was no frame.
    Empty,
}

impl fmt::Display for AnimationError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Picture(error) => error.fmt(out),
            Self::Gif { message } => write!(out, "the GIF cannot be made: {message}"),
            Self::Empty => write!(out, "an animation needs at least one frame"),
        }
    }
}

impl std::error::Error for AnimationError {}

impl From<PictureError> for AnimationError {
    fn from(error: PictureError) -> Self {
        Self::Picture(error)
    }
}

impl From<gif::EncodingError> for AnimationError {
    fn from(error: gif::EncodingError) -> Self {
        Self::Gif { message: error.to_string() }
    }
}

impl<'a> Animation<'a> {
    /// Creates an animation without frames. `delay` is the time between two frames in hundredths of a second;
    /// `width` is as in [`Pictures::png`].
    pub fn new(pictures: Pictures<'a>, width: Option<u32>, delay: u16) -> Self {
        Self { pictures, width, reel: Reel::new(Palette::new(pictures.field), delay) }
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// The errors of [`Pictures::png`] and of the encoder.
    pub fn push(&mut self, frame: &Frame) -> Result<(), AnimationError> {
        let (size, pixels) = self.pictures.pixels(frame, self.width)?;
        self.reel.push(size, &pixels)
    }

    /// Returns the file. The animation repeats without end, and shows its last picture for at least 1.5 s.
    ///
    /// # Errors
    /// The errors of the encoder; [`AnimationError::Empty`] if there is no frame.
    pub fn finish(self) -> Result<Vec<u8>, AnimationError> {
        self.reel.finish()
    }
}

impl<'a> SpaceAnimation<'a> {
    /// Creates an animation without frames. `delay` is the time between two frames in hundredths of a second;
    /// `width` is as in [`SpacePictures::png`].
    pub fn new(pictures: SpacePictures<'a>, width: Option<u32>, delay: u16) -> Self {
        let palette = Palette::shaded(pictures.field, pictures.show);
        Self { pictures, width, reel: Reel::new(palette, delay) }
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// The errors of [`SpacePictures::png`] and of the encoder.
    pub fn push(&mut self, frame: &SpaceFrame) -> Result<(), AnimationError> {
        let (size, pixels) = self.pictures.pixels(frame, self.width)?;
        self.reel.push(size, &pixels)
    }

    /// Returns the file, as [`Animation::finish`].
    ///
    /// # Errors
    /// As [`Animation::finish`].
    pub fn finish(self) -> Result<Vec<u8>, AnimationError> {
        self.reel.finish()
    }
}

impl Reel {
    fn new(palette: Palette, delay: u16) -> Self {
        Self { delay, palette, film: None }
    }

    /// Adds a picture: red, green and blue of each pixel.
    fn push(&mut self, [width, height]: [u32; 2], pixels: &[u8]) -> Result<(), AnimationError> {
        let side = |pixels: u32| {
            u16::try_from(pixels).map_err(|_| AnimationError::Gif { message: "frame too large".to_owned() })
        };
        let size = [side(width)?, side(height)?];
        let places: Vec<u8> = pixels
            .chunks_exact(3)
            .map(|pixel| self.palette.nearest([pixel[0], pixel[1], pixel[2]]))
            .collect();
        let Some(film) = &mut self.film else {
            let mut encoder = gif::Encoder::new(Vec::new(), size[0], size[1], &self.palette.bytes())?;
            encoder.set_repeat(gif::Repeat::Infinite)?;
            let waiting = part(&places, [0, 0], size, size, self.delay);
            self.film = Some(Film { encoder, size, shown: places, waiting });
            return Ok(());
        };
        let (at, extent) = changed(&film.shown, &places, film.size);
        let next = part(&places, at, extent, film.size, self.delay);
        film.encoder.write_frame(&std::mem::replace(&mut film.waiting, next))?;
        film.shown = places;
        Ok(())
    }

    fn finish(self) -> Result<Vec<u8>, AnimationError> {
        let mut film = self.film.ok_or(AnimationError::Empty)?;
        film.waiting.delay = film.waiting.delay.max(LAST);
        film.encoder.write_frame(&film.waiting)?;
        film.encoder.into_inner().map_err(|error| AnimationError::Gif { message: error.to_string() })
    }
}

/// Returns the rectangle in which two pictures differ: its upper left corner and its extent, which is at
/// least one pixel.
fn changed(before: &[u8], now: &[u8], [width, height]: [u16; 2]) -> ([u16; 2], [u16; 2]) {
    let (mut low, mut high) = ([width, height], [0, 0]);
    let row = usize::from(width);
    for (y, (before, now)) in before.chunks_exact(row).zip(now.chunks_exact(row)).enumerate() {
        if before == now {
            continue;
        }
        let differs = |x: &usize| before[*x] != now[*x];
        let (first, last) = ((0..row).find(differs).unwrap_or(0), (0..row).rfind(differs).unwrap_or(0));
        low = [low[0].min(first as u16), low[1].min(y as u16)];
        high = [high[0].max(last as u16 + 1), y as u16 + 1];
    }
    if low[0] < high[0] { (low, [high[0] - low[0], high[1] - low[1]]) } else { ([0, 0], [1, 1]) }
}

/// Cuts a part out of a picture, as a frame that is drawn over the earlier frames.
fn part(places: &[u8], at: [u16; 2], extent: [u16; 2], size: [u16; 2], delay: u16) -> gif::Frame<'static> {
    let [left, top, width, height] = [at[0], at[1], extent[0], extent[1]].map(usize::from);
    let mut buffer = Vec::with_capacity(width * height);
    for row in places.chunks_exact(usize::from(size[0])).skip(top).take(height) {
        buffer.extend_from_slice(&row[left..left + width]);
    }
    gif::Frame {
        delay,
        left: at[0],
        top: at[1],
        width: extent[0],
        height: extent[1],
        dispose: gif::DisposalMethod::Keep,
        buffer: Cow::Owned(buffer),
        ..gif::Frame::default()
    }
}

/// At most 256 colours for all frames: the colours of the field, of text, outlines and cracks, and steps from
/// these to the white background.
#[derive(Debug)]
struct Palette {
    colours: Vec<Rgb>,
    /// Index of the nearest colour for each colour with six bits per channel; `None` until it is needed.
    nearest: Vec<Option<u8>>,
}

const BITS: usize = 6;

impl Palette {
    fn new(field: Field) -> Self {
        let (white, ink) = ([255; 3], [31, 41, 51]);
        let fading = |colour: Rgb, steps: usize| {
            (1..=steps).map(move |step| colour::mix(white, colour, step as f64 / steps as f64))
        };
        let mut colours = vec![white, NO_VALUE];
        colours.extend(fading(ink, 32));
        colours.extend(CRACKS.iter().flat_map(|(_, colour)| fading(*colour, 4)));
        if field.is_continuous() {
            colours.extend((0..128).map(|k| colour::at(field.ramp(), f64::from(k) / 127.0)));
            colours.extend(field.ramp().iter().flat_map(|&colour| fading(colour, 4).take(3)));
            // Spheres may have the colours of their groups.
            colours.extend(NUMBERED.iter().flat_map(|&colour| fading(colour, 2)));
        } else {
            colours.extend((0..8).flat_map(|number| fading(numbered_colour(number), 4)));
        }
        Self::of(colours)
    }

    /// Returns the colours of pictures in three dimensions: those of the field or of the cracks in steps of
    /// light, of lines, and steps from lines to white.
    fn shaded(field: Field, show: Show) -> Self {
        let fading = |colour: Rgb, steps: usize| {
            (1..=steps).map(move |step| colour::mix([255; 3], colour, step as f64 / steps as f64))
        };
        let mut colours = vec![[255; 3]];
        colours.extend(fading(CRACK, 24));
        let shades = |count: usize| {
            (0..count).map(move |k| {
                let share = k as f64 / (count - 1) as f64;
                // The darkest are seldom seen: they are turned away from the light.
                let [low, high] = [0.66, SHADES[1]];
                low + (high - low) * share
            })
        };
        if show == Show::Cracks {
            // The solid is bluish grey, and the cracks become paler in the light.
            colours.extend(fading([190, 201, 214], 24));
            colours.extend(fading([120, 144, 168], 12));
            let steps = (256 - colours.len()) / CRACKS.len();
            for (_, crack) in CRACKS {
                colours.extend((0..steps).map(|k| colour::mix(crack, [255; 3], k as f64 / steps as f64)));
            }
        } else {
            let of_field: Vec<Rgb> = if field.is_continuous() {
                (0..34).map(|k| colour::at(field.ramp(), f64::from(k) / 33.0)).collect()
            } else {
                NUMBERED.to_vec()
            };
            let steps = 204 / of_field.len();
            let all = of_field.iter().copied().chain([NO_VALUE]);
            colours.extend(all.flat_map(|colour| shades(steps).map(move |shade| shaded(colour, shade))));
            if field.of_spheres().is_none() && field.is_continuous() {
                // Spheres have the colours of their groups.
                colours.extend(
                    NUMBERED.iter().flat_map(|&colour| shades(2).map(move |shade| shaded(colour, shade))),
                );
            }
        }
        Self::of(colours)
    }

    fn of(colours: Vec<Rgb>) -> Self {
        debug_assert!(colours.len() <= 256, "a GIF has at most 256 colours");
        Self { colours, nearest: vec![None; 1 << (3 * BITS)] }
    }

    fn bytes(&self) -> Vec<u8> {
        self.colours.as_flattened().to_vec()
    }

    fn nearest(&mut self, colour: Rgb) -> u8 {
        let cell =
            colour.iter().fold(0, |cell, &channel| (cell << BITS) | usize::from(channel >> (8 - BITS)));
        if let Some(place) = self.nearest[cell] {
            return place;
        }
        // All colours of a cell are replaced by one, so that the result does not depend on the order of the
        // pixels.
        let middle = colour.map(|channel| i32::from(channel >> (8 - BITS)) * 255 / ((1 << BITS) - 1));
        let distance = |other: &Rgb| -> i32 {
            (0..3).map(|channel| (middle[channel] - i32::from(other[channel])).pow(2)).sum()
        };
        let place = (0..self.colours.len()).min_by_key(|&k| distance(&self.colours[k])).unwrap_or(0) as u8;
        self.nearest[cell] = Some(place);
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_palette_fits_and_has_white_and_what_the_field_has() {
        for field in Field::ALL {
            let mut palette = Palette::new(field);
            assert!(palette.colours.len() <= 256, "{field:?}: {}", palette.colours.len());
            assert_eq!(palette.nearest([255; 3]), 0);
            for &colour in field.ramp().iter().filter(|_| field.is_continuous()) {
                let place = palette.nearest(colour);
                let found = palette.colours[usize::from(place)];
                let off = (0..3).map(|k| colour[k].abs_diff(found[k])).max().unwrap();
                assert!(off <= 6, "{field:?} {colour:?} {found:?}");
            }
        }
    }

    #[test]
    fn only_what_differs_is_written() {
        let before = vec![0; 12];
        let mut now = before.clone();
        (now[5], now[10]) = (1, 2);
        assert_eq!(changed(&before, &now, [4, 3]), ([1, 1], [2, 2]));
        assert_eq!(changed(&before, &before, [4, 3]), ([0, 0], [1, 1]));
        let frame = part(&now, [1, 1], [2, 2], [4, 3], 7);
        assert_eq!((frame.left, frame.top, &frame.buffer[..]), (1, 1, &[1, 0, 0, 2][..]));
    }
}
