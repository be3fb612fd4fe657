//! Compressed snapshots.

use std::fmt;

use fdem_simulation::{Crack, Mode, Snapshot};

use crate::arrays::each;
use crate::fields::field::{Field, SCALES, line_of_keys};
use crate::fields::quantity::Number;
use crate::fields::range::{Range, Scale};
use crate::fields::state::Instant;
use crate::run::grains::frame::GrainFrame;
use crate::run::grains::walls::{Bounds, EMPTY, union};
use crate::run::outlines::Outlines;
use crate::run::packed::{Packed, Unpacked, Words, bounds, low_halves};
use crate::run::sample::Sample;
use crate::run::snapshot::{SnapshotError, checked};

/// First bytes of a file: its kind and its version. The keys of its fields follow.
const MAGIC: &[u8; 8] = b"fdemfrm7";

/// Level at which frames are deflated: level 6 makes them 3 % smaller and takes three times as long.
pub(crate) const LEVEL: u8 = 1;

/// Number of arrays with an entry for each element: six coordinates of corners, the fields, two halves of the
/// body number, the material, the outlines.
const OF_ELEMENTS: usize = 6 + SCALES.len() + 4;
/// Number of additional arrays in a sample: two halves of the element number.
const OF_SAMPLES: usize = 2;
/// Number of arrays with an entry for each crack: four coordinates of ends, the kind.
const OF_CRACKS: usize = 5;
/// Number of arrays with an entry for each whole or softening joint: four coordinates of ends.
const OF_HOLDING: usize = 4;

/// The part of a snapshot that pictures and reports show, in a few bytes per element. Coordinates and values
/// have 16 bits between the least and the greatest of the frame, and are deflated. Only broken joints are
/// stored as cracks.
///
/// An element is not drawn if one of its coordinates is not finite, or is farther from the middle 98 % of all
/// coordinates on its axis than four times their extent.
///
/// # Cost
/// About 10 ms and 100 to 200 kB for 10,000 elements.
///
/// # Example
/// ```
/// use fdem_results::Frame;
///
/// let frame = Frame::new(&fdem_simulation::Snapshot::default())?;
/// assert_eq!(Frame::from_bytes(&frame.to_bytes()).as_ref(), Ok(&frame));
/// # Ok::<(), fdem_results::SnapshotError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub(crate) step: u64,
    pub(crate) time: f64,
    /// Number of elements of the mesh.
    pub(crate) whole: usize,
    /// Number of elements in the frame: all, or a sample.
    pub(crate) elements: usize,
    pub(crate) cracks: usize,
    /// Number of whole joints.
    pub(crate) intact: usize,
    /// Number of joints that soften, where whole ones are shown.
    pub(crate) softening: usize,
    /// The least and the greatest coordinate on each axis.
    pub(crate) bounds: [[f64; 2]; 2],
    pub(crate) scales: [Scale; SCALES.len()],
    /// Total lengths of the joints that broke in tension, in shear and in mixed mode, m.
    pub(crate) lengths: [f64; 3],
    /// Total lengths of the joints that are open from the start, and of those that are whole and that soften,
    /// m: see [`holding`].
    pub(crate) others: [f64; 3],
    /// Spheres and walls.
    pub(crate) grains: GrainFrame,
    /// Size of the arrays before they were deflated, bytes.
    pub(crate) size: usize,
    pub(crate) deflated: Vec<u8>,
}

/// A decompressed frame.
pub(crate) struct Opened {
    /// Corners of the elements. An element with a corner that is NaN is not drawn.
    pub(crate) corners: Vec<[[f64; 2]; 3]>,
    /// Values of each field of [`SCALES`].
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) bodies: Vec<u32>,
    pub(crate) materials: Vec<u32>,
    /// Bits of the edges of each element, as in [`Outlines`].
    pub(crate) outlines: Vec<u8>,
    pub(crate) cracks: Vec<([[f64; 2]; 2], CrackKind)>,
    /// Ends of the whole joints.
    pub(crate) intact: Vec<[[f64; 2]; 2]>,
    /// Ends of the joints that soften.
    pub(crate) softening: Vec<[[f64; 2]; 2]>,
}

impl Opened {
    /// Returns the numbers of the elements by which they are coloured.
    pub(crate) fn numbers_of(&self, number: Number) -> &[u32] {
        match number {
            Number::Body => &self.bodies,
            Number::Material => &self.materials,
        }
    }
}

/// The reason why bytes cannot be read as a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// The first bytes are not those of a frame.
    NotAFrame,
    /// The bytes end too early, or are inconsistent.
    Damaged,
}

impl fmt::Display for FrameError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::NotAFrame => "this is not a frame of a run, or it is from another version",
            Self::Damaged => "the frame is damaged",
        })
    }
}

impl std::error::Error for FrameError {}

impl Range {
    /// Returns the range of a whole series. It covers at least 98 % of the elements in every frame, so that a
    /// few extreme values do not use up the colours. Ranges of fields with a sign are symmetric about 0. All
    /// other ranges begin at 0, or are the same in all runs, as that of damage.
    pub fn of<'a>(frames: impl IntoIterator<Item = &'a Frame>, field: Field) -> Self {
        field.range(frames.into_iter().map(|frame| (&frame.scales, &frame.grains.ranges)))
    }
}

impl Frame {
    /// Makes a frame of a snapshot, without outlines. Values that are not finite become NaN.
    ///
    /// # Errors
    /// [`SnapshotError`] if the snapshot contradicts itself.
    pub fn new(snapshot: &Snapshot) -> Result<Self, SnapshotError> {
        Self::outlined(snapshot, &Outlines { bits: vec![0; snapshot.elements.len()] })
    }

    /// Makes a frame of a snapshot, with the outlines of its bodies and grains.
    ///
    /// # Errors
    /// [`SnapshotError`] if the snapshot contradicts itself, or if the outlines belong to another mesh.
    pub fn outlined(snapshot: &Snapshot, outlines: &Outlines) -> Result<Self, SnapshotError> {
        Self::sampled(snapshot, outlines, usize::MAX)
    }

    /// Makes a frame with at most `most` triangles. A mesh with more elements is shown by a sample: larger
    /// triangles that cover the same area, each with the values and the number of one element. The sample has
    /// one crack of each mode in each cell of a grid. Ranges of values and lengths of cracks are those of the
    /// whole mesh.
    ///
    /// # Errors
    /// [`SnapshotError`] if the snapshot contradicts itself, or if the outlines belong to another mesh.
    pub fn sampled(snapshot: &Snapshot, outlines: &Outlines, most: usize) -> Result<Self, SnapshotError> {
        checked(snapshot)?;
        let whole = snapshot.elements.len();
        let found = outlines.bits.len();
        if found != whole {
            return Err(SnapshotError::Length { name: "outlines", found, expected: whole });
        }
        let mut corners: Vec<[[f64; 2]; 3]> = snapshot
            .elements
            .iter()
            .map(|nodes| nodes.map(|node| snapshot.positions[node as usize]))
            .collect();
        let bounds = [0, 1].map(|axis| bounds(corners.iter().flatten().map(|corner| corner[axis])));
        let mut sample = (whole > most).then(|| Sample::new(&corners, &snapshot.bodies, bounds, most));
        if let Some(sample) = &mut sample {
            corners = std::mem::take(&mut sample.corners);
        }

        let mut packed = Packed::default();
        for corner in 0..3 {
            for (axis, &bounds) in bounds.iter().enumerate() {
                let along: Vec<f64> = corners.iter().map(|corners| corners[corner][axis]).collect();
                packed.places(&along, bounds);
            }
        }
        let elements = corners.len();
        drop(corners);
        let state = Instant::of(snapshot);
        let scales = SCALES.map(|field| {
            let values = field.values(&state);
            let scale = Scale::of(&values);
            packed.places(&of_sample(sample.as_ref(), values), scale.ends);
            scale
        });
        packed.halves(&of_sample(sample.as_ref(), snapshot.bodies.clone()));
        packed.numbers(&low_halves(&of_sample(sample.as_ref(), snapshot.materials.clone())));
        let bits = of_sample(sample.as_ref(), outlines.bits.clone());
        packed.numbers(&bits.into_iter().map(u16::from).collect::<Vec<_>>());
        if let Some(sample) = &sample {
            packed.halves(&sample.elements);
        }

        let mut broken: Vec<&Crack> = snapshot.cracks.iter().filter(|crack| crack.time.is_some()).collect();
        let mut holding = holding(snapshot);
        let (lengths, others) = measures(&broken, &holding);
        if let Some(sample) = &sample {
            sample.cracks(&mut broken, |crack| crack.corners, |crack| CrackKind::of(crack).code());
            for joints in &mut holding {
                sample.cracks(joints, |crack| crack.corners, |_| 0);
            }
        }
        pack_ends(&mut packed, &broken, &bounds);
        packed.numbers(&broken.iter().map(|crack| CrackKind::of(crack).code()).collect::<Vec<_>>());
        pack_ends(&mut packed, &holding.concat(), &bounds);
        Ok(Self {
            step: snapshot.step,
            time: snapshot.time,
            whole,
            elements,
            cracks: broken.len(),
            intact: holding[0].len(),
            softening: holding[1].len(),
            bounds,
            scales,
            lengths,
            others,
            grains: GrainFrame::new(&snapshot.spheres, around(elements, &bounds))?,
            size: packed.bytes.len(),
            deflated: miniz_oxide::deflate::compress_to_vec(&packed.bytes, LEVEL),
        })
    }

    /// Returns the number of steps done.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Returns the time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the bounds of the elements, of the spheres and of the walls near them.
    pub(crate) fn extent(&self) -> [[f64; 2]; 2] {
        extent_with(self.elements, self.bounds, &self.grains)
    }

    /// Whether the frame shows a sample of the elements.
    pub(crate) fn is_sample(&self) -> bool {
        self.elements < self.whole
    }

    /// Returns the numbers of all elements and of all spheres.
    pub fn counts(&self) -> [usize; 2] {
        [self.whole, self.grains.whole]
    }

    /// Returns the frame as the bytes of a file. Equal frames have equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = [MAGIC, line_of_keys().as_bytes()].concat();
        bytes.extend(self.step.to_le_bytes());
        bytes.extend(self.time.to_le_bytes());
        let counts = [self.whole, self.elements, self.cracks, self.intact, self.softening, self.size];
        for number in counts {
            bytes.extend((number as u64).to_le_bytes());
        }
        let scales = self.scales.iter().flat_map(|scale| [scale.ends, scale.usual]).flatten();
        for number in self.bounds.into_iter().flatten().chain(scales).chain(self.lengths).chain(self.others) {
            bytes.extend(number.to_le_bytes());
        }
        self.grains.write(&mut bytes);
        bytes.extend(&self.deflated);
        bytes
    }

    /// Reads the bytes of [`Self::to_bytes`].
    ///
    /// # Errors
    /// [`FrameError`] if the bytes are not a frame, or a damaged one.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FrameError> {
        let rest = bytes.strip_prefix(MAGIC).and_then(|rest| rest.strip_prefix(line_of_keys().as_bytes()));
        let rest = rest.ok_or(FrameError::NotAFrame)?;
        let mut words = Words { bytes: rest };
        let damaged = FrameError::Damaged;
        let frame = (|| {
            Some(Self {
                step: words.u64()?,
                time: words.f64()?,
                whole: usize::try_from(words.u64()?).ok()?,
                elements: usize::try_from(words.u64()?).ok()?,
                cracks: usize::try_from(words.u64()?).ok()?,
                intact: usize::try_from(words.u64()?).ok()?,
                softening: usize::try_from(words.u64()?).ok()?,
                size: usize::try_from(words.u64()?).ok()?,
                bounds: [words.pair()?, words.pair()?],
                scales: words.scales()?,
                lengths: [words.f64()?, words.f64()?, words.f64()?],
                others: [words.f64()?, words.f64()?, words.f64()?],
                grains: GrainFrame::read(&mut words)?,
                deflated: words.bytes.to_vec(),
            })
        })();
        let frame = frame.ok_or(damaged)?;
        frame.open()?;
        Ok(frame)
    }

    /// Decompresses the frame.
    pub(crate) fn open(&self) -> Result<Opened, FrameError> {
        self.try_open().ok_or(FrameError::Damaged)
    }

    /// Reads `count` groups of `N` points. The arrays are: x of all first points, y of all first points, x of
    /// all second points, and so on.
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
        if self.elements > self.whole {
            return None;
        }
        let of_samples = if self.is_sample() { OF_SAMPLES } else { 0 };
        let of_elements = self.elements.checked_mul(2 * (OF_ELEMENTS + of_samples))?;
        let of_cracks = self.cracks.checked_mul(2 * OF_CRACKS)?;
        let holding = self.intact.checked_add(self.softening)?;
        let of_holding = holding.checked_mul(2 * OF_HOLDING)?;
        let expected = of_elements.checked_add(of_cracks)?.checked_add(of_holding)?;
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
        let bodies = arrays.halves(self.elements)?;
        let materials = arrays.numbers(self.elements)?.into_iter().map(u32::from).collect();
        let outlines = arrays.numbers(self.elements)?.into_iter().map(|bits| (bits & 0xff) as u8).collect();
        if self.is_sample() {
            // Pictures do not need the numbers of the elements.
            arrays.numbers(2 * self.elements)?;
        }
        let ends = self.points(&mut arrays, self.cracks)?;
        let kinds = arrays.numbers(self.cracks)?.into_iter().map(CrackKind::with_code);
        let cracks = ends.into_iter().zip(kinds).collect();
        let mut intact = self.points(&mut arrays, holding)?;
        let softening = intact.split_off(self.intact);
        let opened = Opened { corners, values, bodies, materials, outlines, cracks, intact, softening };
        arrays.is_empty().then_some(opened)
    }
}

/// Returns the bounds of elements, if there are any, in space.
pub(crate) fn around<const D: usize>(elements: usize, bounds: &[[f64; 2]; D]) -> Bounds {
    if elements == 0 {
        return EMPTY;
    }
    each(|axis| bounds.get(axis).copied().unwrap_or([0.0; 2]))
}

/// Returns bounds of elements, if there are any, with those of the spheres and of the walls near them.
pub(crate) fn extent_with<const D: usize>(
    elements: usize,
    bounds: [[f64; 2]; D],
    grains: &GrainFrame,
) -> [[f64; 2]; D] {
    if grains.is_empty() {
        return bounds;
    }
    let both = union(around(elements, &bounds), grains.extent());
    each(|axis| both[axis])
}

/// Returns the values of the elements in the sample; all values if there is no sample.
fn of_sample<T: Copy>(sample: Option<&Sample>, values: Vec<T>) -> Vec<T> {
    match sample {
        Some(sample) => sample.elements.iter().map(|&element| values[element as usize]).collect(),
        None => values,
    }
}

/// Returns the joints that hold, if the snapshot has its whole joints: these, and those that soften.
pub(crate) fn holding<const D: usize, const N: usize>(snapshot: &Snapshot<D, N>) -> [Vec<&Crack<D>>; 2] {
    let Some(intact) = &snapshot.intact else { return [Vec::new(), Vec::new()] };
    [intact.iter().collect(), snapshot.cracks.iter().filter(|crack| crack.time.is_none()).collect()]
}

/// Returns the total lengths or areas of the joints that broke in tension, in shear and in mixed mode, and of
/// those that are open from the start, that are whole and that soften.
pub(crate) fn measures<const D: usize>(
    broken: &[&Crack<D>],
    holding: &[Vec<&Crack<D>>; 2],
) -> ([f64; 3], [f64; 3]) {
    let (mut by_mode, mut open) = ([0.0; 3], 0.0);
    for crack in broken {
        match CrackKind::of(crack) {
            CrackKind::Broken(mode) => by_mode[usize::from(code(mode))] += crack.measure,
            CrackKind::Open => open += crack.measure,
        }
    }
    let [whole, softening] =
        [0, 1].map(|state: usize| holding[state].iter().map(|joint| joint.measure).sum());
    (by_mode, [open, whole, softening])
}

/// Appends the ends of joints. A joint beside an element that is not drawn may reach beyond the bounds.
fn pack_ends(packed: &mut Packed, joints: &[&Crack], bounds: &[[f64; 2]; 2]) {
    for end in 0..2 {
        for (axis, &[low, high]) in bounds.iter().enumerate() {
            let inside = |joint: &&Crack| joint.corners[end][axis].clamp(low, high);
            packed.places(&joints.iter().map(inside).collect::<Vec<_>>(), [low, high]);
        }
    }
}

/// Returns the number of a mode in frames.
pub(crate) fn code(mode: Mode) -> u16 {
    match mode {
        Mode::Tension => 0,
        Mode::Shear => 1,
        Mode::Mixed => 2,
    }
}

/// A broken joint as pictures show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CrackKind {
    /// The run has broken it, in this mode.
    Broken(Mode),
    /// It is of a joint set that is open from the beginning.
    Open,
}

impl CrackKind {
    pub(crate) fn of<const D: usize>(crack: &Crack<D>) -> Self {
        if crack.open_from_start { Self::Open } else { Self::Broken(crack.mode) }
    }

    /// Returns its number in frames.
    pub(crate) fn code(self) -> u16 {
        match self {
            Self::Broken(mode) => code(mode),
            Self::Open => 3,
        }
    }

    /// Returns the kind with this number in frames.
    pub(crate) fn with_code(code: u16) -> Self {
        match code {
            0 => Self::Broken(Mode::Tension),
            1 => Self::Broken(Mode::Shear),
            2 => Self::Broken(Mode::Mixed),
            _ => Self::Open,
        }
    }
}
