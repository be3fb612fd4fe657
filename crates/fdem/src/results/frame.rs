//! A snapshot made small.

use std::fmt;

use fdem_simulation::{Crack, Mode, Snapshot};

use crate::results::field::SCALES;
use crate::results::packed::{Packed, Unpacked};
use crate::results::{SnapshotError, checked};

/// Of a file, and the version of what follows.
const MAGIC: &[u8; 8] = b"fdemfrm1";

/// Arrays with a number for each element: six coordinates of corners, the scales, two halves of the body, the material.
const OF_ELEMENTS: usize = 6 + SCALES.len() + 3;
/// With one for each crack: four coordinates of ends, the mode.
const OF_CRACKS: usize = 5;

/// What pictures and reports show of a snapshot, in a few bytes for each element: coordinates and values as 16 bits between the least and the largest
/// of the frame, deflated. Cracks are those that are broken.
///
/// Elements without finite coordinates, or farther away than four times the extent of all but 2 % of them, are not drawn.
///
/// # Cost
/// Of 10,000 elements: some 10 ms and 100 to 200 kB.
///
/// # Example
/// ```
/// use fdem::results::Frame;
///
/// let frame = Frame::new(&fdem_simulation::Snapshot::default())?;
/// assert_eq!(Frame::from_bytes(&frame.to_bytes()).as_ref(), Ok(&frame));
/// # Ok::<(), fdem::results::SnapshotError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub(crate) step: u64,
    pub(crate) time: f64,
    pub(crate) elements: usize,
    pub(crate) cracks: usize,
    /// The least and the largest coordinate, on each axis.
    pub(crate) bounds: [[f64; 2]; 2],
    pub(crate) scales: [Scale; SCALES.len()],
    /// Of what is broken by tension, by shear, by both, m.
    pub(crate) lengths: [f64; 3],
    /// Of the arrays before they were deflated.
    pub(crate) size: usize,
    pub(crate) deflated: Vec<u8>,
}

/// What the values of a quantity are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// The least and the largest.
    pub(crate) ends: [f64; 2],
    /// What 1 % and 99 % do not exceed.
    pub(crate) usual: [f64; 2],
}

/// A frame as it is drawn.
pub(crate) struct Opened {
    /// Not numbers where an element is not drawn.
    pub(crate) corners: Vec<[[f64; 2]; 3]>,
    /// Of each of [`SCALES`].
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) bodies: Vec<u32>,
    pub(crate) materials: Vec<u32>,
    pub(crate) cracks: Vec<([[f64; 2]; 2], Mode)>,
}

/// Bytes that are no frame.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// They begin otherwise.
    NotAFrame,
    /// They end too early, or contradict themselves.
    Damaged,
}

impl fmt::Display for FrameError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::NotAFrame => "this is no frame of a run, or one of another version",
            Self::Damaged => "the frame is damaged",
        })
    }
}

impl std::error::Error for FrameError {}

impl Frame {
    /// Of a snapshot. Numbers that are not finite are kept as such.
    ///
    /// # Errors
    /// A snapshot that contradicts itself.
    pub fn new(snapshot: &Snapshot) -> Result<Self, SnapshotError> {
        checked(snapshot)?;
        let corners: [[Vec<f64>; 2]; 3] = [0, 1, 2].map(|corner| {
            [0, 1].map(|axis| {
                let place = |nodes: &[u32; 3]| snapshot.positions[nodes[corner] as usize][axis];
                snapshot.triangles.iter().map(place).collect()
            })
        });
        let bounds =
            [0, 1].map(|axis| bounds(corners.iter().flat_map(|corner| corner[axis].iter().copied())));

        let mut packed = Packed::default();
        for corner in &corners {
            for axis in 0..2 {
                packed.places(&corner[axis], bounds[axis]);
            }
        }
        let scales = SCALES.map(|field| {
            let values = field.values(snapshot);
            let scale = Scale::of(&values);
            packed.places(&values, scale.ends);
            scale
        });
        let halves = |numbers: &[u32], shift: u32| -> Vec<u16> {
            numbers.iter().map(|number| (number >> shift & 0xffff) as u16).collect()
        };
        packed.numbers(&halves(&snapshot.bodies, 16));
        packed.numbers(&halves(&snapshot.bodies, 0));
        packed.numbers(&halves(&snapshot.materials, 0));

        let broken: Vec<&Crack> = snapshot.cracks.iter().filter(|crack| crack.time.is_some()).collect();
        let mut lengths = [0.0; 3];
        for crack in &broken {
            lengths[usize::from(code(crack.mode))] += crack.length;
        }
        for end in 0..2 {
            for (axis, &[low, high]) in bounds.iter().enumerate() {
                // Half way between two elements may be a little outside of both.
                let inside = |crack: &&Crack| crack.ends[end][axis].clamp(low, high);
                packed.places(&broken.iter().map(inside).collect::<Vec<_>>(), [low, high]);
            }
        }
        packed.numbers(&broken.iter().map(|crack| code(crack.mode)).collect::<Vec<_>>());
        Ok(Self {
            step: snapshot.step,
            time: snapshot.time,
            elements: snapshot.triangles.len(),
            cracks: broken.len(),
            bounds,
            scales,
            lengths,
            size: packed.bytes.len(),
            deflated: miniz_oxide::deflate::compress_to_vec(&packed.bytes, 6),
        })
    }

    /// Steps done.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// What all but 1 % do not fall below, and what all but 1 % do not exceed.
    pub(crate) fn usual(&self, scale: usize) -> [f64; 2] {
        self.scales[scale].usual
    }

    /// As it may be kept in a file. The same frame is the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(self.step.to_le_bytes());
        bytes.extend(self.time.to_le_bytes());
        for number in [self.elements, self.cracks, self.size] {
            bytes.extend((number as u64).to_le_bytes());
        }
        let scales = self.scales.iter().flat_map(|scale| [scale.ends, scale.usual]).flatten();
        for number in self.bounds.into_iter().flatten().chain(scales).chain(self.lengths) {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(&self.deflated);
        bytes
    }

    /// What [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// Bytes that are no frame, or a damaged one.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FrameError> {
        let rest = bytes.strip_prefix(MAGIC).ok_or(FrameError::NotAFrame)?;
        let mut words = Words { bytes: rest };
        let damaged = FrameError::Damaged;
        let frame = (|| {
            Some(Self {
                step: words.u64()?,
                time: words.f64()?,
                elements: usize::try_from(words.u64()?).ok()?,
                cracks: usize::try_from(words.u64()?).ok()?,
                size: usize::try_from(words.u64()?).ok()?,
                bounds: [words.pair()?, words.pair()?],
                scales: words.scales()?,
                lengths: [words.f64()?, words.f64()?, words.f64()?],
                deflated: words.bytes.to_vec(),
            })
        })();
        let frame = frame.ok_or(damaged)?;
        frame.open()?;
        Ok(frame)
    }

    /// All numbers.
    pub(crate) fn open(&self) -> Result<Opened, FrameError> {
        self.try_open().ok_or(FrameError::Damaged)
    }

    /// As many times `N` points: all first ones, x and then y, all second ones and so on.
    fn points<const N: usize>(&self, arrays: &mut Unpacked<'_>, count: usize) -> Option<Vec<[[f64; 2]; N]>> {
        let mut points = vec![[[f64::NAN; 2]; N]; count];
        for corner in 0..N {
            for (axis, &bounds) in self.bounds.iter().enumerate() {
                for (point, value) in points.iter_mut().zip(arrays.places(count, bounds)?) {
                    point[corner][axis] = value;
                }
            }
        }
        Some(points)
    }

    fn try_open(&self) -> Option<Opened> {
        let of_elements = self.elements.checked_mul(2 * OF_ELEMENTS)?;
        let expected = of_elements.checked_add(self.cracks.checked_mul(2 * OF_CRACKS)?)?;
        let bytes = miniz_oxide::inflate::decompress_to_vec_with_limit(&self.deflated, self.size).ok()?;
        if expected != self.size || bytes.len() != expected {
            return None;
        }
        let mut arrays = Unpacked::new(&bytes);
        let corners = self.points(&mut arrays, self.elements)?;
        let mut values = Vec::with_capacity(SCALES.len());
        for scale in &self.scales {
            values.push(arrays.places(self.elements, scale.ends)?);
        }
        let (upper, lower) = (arrays.numbers(self.elements)?, arrays.numbers(self.elements)?);
        let bodies = upper
            .iter()
            .zip(&lower)
            .map(|(&upper, &lower)| u32::from(upper) << 16 | u32::from(lower))
            .collect();
        let materials = arrays.numbers(self.elements)?.into_iter().map(u32::from).collect();
        let ends = self.points(&mut arrays, self.cracks)?;
        let modes = arrays.numbers(self.cracks)?.into_iter().map(|code| match code {
            0 => Mode::Tension,
            1 => Mode::Shear,
            _ => Mode::Mixed,
        });
        let cracks = ends.into_iter().zip(modes).collect();
        arrays.is_empty().then_some(Opened { corners, values, bodies, materials, cracks })
    }
}

/// How frames number it.
pub(crate) fn code(mode: Mode) -> u16 {
    match mode {
        Mode::Tension => 0,
        Mode::Shear => 1,
        Mode::Mixed => 2,
    }
}

impl Scale {
    fn of(values: &[f64]) -> Self {
        let mut finite: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
        let Some(last) = finite.len().checked_sub(1) else { return Self { ends: [0.0; 2], usual: [0.0; 2] } };
        let ends = finite
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)]);
        Self { ends, usual: [quantile(&mut finite, last / 100), quantile(&mut finite, last - last / 100)] }
    }
}

fn quantile(values: &mut [f64], place: usize) -> f64 {
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// The least and the largest coordinate of those that are drawn.
fn bounds(coordinates: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut finite: Vec<f64> = coordinates.filter(|x| x.is_finite()).collect();
    let Some(last) = finite.len().checked_sub(1) else { return [0.0; 2] };
    let [low, high] = [quantile(&mut finite, last / 100), quantile(&mut finite, last - last / 100)];
    let reach = if high > low { 4.0 * (high - low) } else { f64::INFINITY };
    let near = finite.iter().filter(|&&x| x >= low - reach && x <= high + reach);
    near.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)])
}

/// Numbers of eight bytes.
struct Words<'a> {
    bytes: &'a [u8],
}

impl Words<'_> {
    fn u64(&mut self) -> Option<u64> {
        let (word, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(u64::from_le_bytes(*word))
    }

    fn f64(&mut self) -> Option<f64> {
        self.u64().map(f64::from_bits)
    }

    fn pair(&mut self) -> Option<[f64; 2]> {
        Some([self.f64()?, self.f64()?])
    }

    fn scales(&mut self) -> Option<[Scale; SCALES.len()]> {
        let mut scales = [Scale { ends: [0.0; 2], usual: [0.0; 2] }; SCALES.len()];
        for scale in &mut scales {
            *scale = Scale { ends: self.pair()?, usual: self.pair()? };
        }
        Some(scales)
    }
}
