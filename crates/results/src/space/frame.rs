//! Compressed snapshots of bodies of tetrahedra.

use std::fmt;

use fdem_simulation::{Crack, Snapshot};

use crate::fields::field::{Field, SCALES, line_of_keys};
use crate::fields::range::{Range, Scale};
use crate::fields::state::Instant;
use crate::run::frame::{CrackKind, FrameError, LEVEL, around, extent_with, holding, measures};
use crate::run::grains::frame::GrainFrame;
use crate::run::packed::{Packed, Unpacked, Words, bounds, low_halves};
use crate::run::snapshot::{SnapshotError, checked};
use crate::space::facets::{FACETS, Marks};
use crate::space::opened::{OpenedCrack, OpenedSpace};
use crate::space::shell::{Shell, VisibleParts};

/// First bytes of a file: its kind and its version. The keys of its fields follow.
const MAGIC: &[u8; 8] = b"fdemspc5";

/// Maximum number of elements of a mesh whose frames have the elements inside. Frames of larger meshes have
/// only the elements at the surface.
pub const MOST_INSIDE: usize = 300_000;

/// Number of arrays with an entry for each element: twelve coordinates of corners, the fields, two halves of
/// the number, of the body and of the fragment, the material, the marks.
const OF_ELEMENTS: usize = 12 + SCALES.len() + 8;
/// Number of arrays with an entry for each crack: two halves of both facets, the code, the opening.
const OF_CRACKS: usize = 6;
/// Number of arrays with an entry for each whole or softening joint: nine coordinates of corners, two halves
/// of the body and of the fragment.
const OF_HOLDING: usize = 13;

/// The part of a snapshot in three dimensions that pictures and pages show, in a few bytes per element: the
/// elements that have facets on the surface or on broken joints, and, if the mesh has at most [`MOST_INSIDE`]
/// elements, the others, so that a cut shows the inside. Coordinates and values have 16 bits between the
/// least and the greatest of the frame, and are deflated.
///
/// An element is not drawn if one of its coordinates is not finite, or is farther from the middle 98 % of all
/// coordinates on its axis than four times their extent. Facets beside it are then on the surface.
///
/// # Cost
/// About 30 bytes for each element in the frame. See `crates/results/examples/space_report.rs` for a whole
/// series.
///
/// # Example
/// ```
/// use fdem_results::{Shell, SpaceFrame};
///
/// let frame = SpaceFrame::new(&fdem_simulation::Snapshot::default(), &Shell::default())?;
/// assert_eq!(SpaceFrame::from_bytes(&frame.to_bytes()).as_ref(), Ok(&frame));
/// # Ok::<(), fdem_results::SnapshotError>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct SpaceFrame {
    pub(crate) step: u64,
    pub(crate) time: f64,
    /// Number of elements of the mesh.
    pub(crate) whole: usize,
    /// Number of elements in the frame that have facets that are seen.
    pub(crate) surface: usize,
    /// Number of elements in the frame that have none.
    pub(crate) inside: usize,
    /// Whether all elements that can be drawn are in the frame.
    pub(crate) solid: bool,
    /// Number of facets that are seen.
    pub(crate) facets: usize,
    /// Number of fragments.
    pub(crate) fragments: usize,
    pub(crate) cracks: usize,
    /// Number of whole joints.
    pub(crate) intact: usize,
    /// Number of joints that soften, where whole ones are shown.
    pub(crate) softening: usize,
    /// The least and the greatest coordinate on each axis.
    pub(crate) bounds: [[f64; 2]; 3],
    pub(crate) scales: [Scale; SCALES.len()],
    /// Total areas of the joints that broke in tension, in shear and in mixed mode, m².
    pub(crate) areas: [f64; 3],
    /// Total areas of the joints that are open from the start, and of those that are whole and that soften,
    /// m²: see [`holding`].
    pub(crate) others: [f64; 3],
    /// The least and the greatest opening of a crack, m.
    pub(crate) openings: [f64; 2],
    /// Spheres and walls.
    pub(crate) grains: GrainFrame,
    /// Sizes of the arrays of elements at the surface with the cracks, and of elements inside, before they
    /// were deflated, bytes.
    pub(crate) sizes: [usize; 2],
    pub(crate) deflated: [Vec<u8>; 2],
}

impl fmt::Debug for SpaceFrame {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("SpaceFrame")
            .field("step", &self.step)
            .field("time", &self.time)
            .field("elements", &[self.surface, self.inside, self.whole])
            .field("cracks", &self.cracks)
            .finish_non_exhaustive()
    }
}

impl Range {
    /// Returns the range of a series in three dimensions, by the same rules.
    pub fn of_space<'a>(frames: impl IntoIterator<Item = &'a SpaceFrame>, field: Field) -> Self {
        field.range(frames.into_iter().map(|frame| (&frame.scales, &frame.grains.ranges)))
    }
}

impl SpaceFrame {
    /// Makes a frame of a snapshot. Values that are not finite become NaN.
    ///
    /// # Errors
    /// [`SnapshotError`] if the snapshot contradicts itself, or if the shell belongs to another mesh.
    ///
    /// # Cost
    /// Proportional to the elements of the mesh, most of it for the principal stresses, and to the elements
    /// in the frame, most of it for deflating them.
    pub fn new(snapshot: &Snapshot<3, 4>, shell: &Shell) -> Result<Self, SnapshotError> {
        Self::with_inside(snapshot, shell, MOST_INSIDE)
    }

    /// Makes a frame that has the elements inside if the mesh has at most `most` elements.
    ///
    /// # Errors
    /// Like [`Self::new`].
    pub fn with_inside(snapshot: &Snapshot<3, 4>, shell: &Shell, most: usize) -> Result<Self, SnapshotError> {
        checked(snapshot)?;
        let whole = snapshot.elements.len();
        let found = shell.elements();
        if found != whole {
            return Err(SnapshotError::Length { name: "elements in the shell", found, expected: whole });
        }
        let bounds = [0, 1, 2].map(|axis| bounds(snapshot.positions.iter().map(|position| position[axis])));
        let within = |&node: &u32| {
            let position = snapshot.positions[node as usize];
            (0..3).all(|axis| (bounds[axis][0]..=bounds[axis][1]).contains(&position[axis]))
        };
        let drawn: Vec<bool> = snapshot.elements.iter().map(|nodes| nodes.iter().all(within)).collect();
        let seen = shell.seen(snapshot, &drawn)?;

        // The elements in the frame: those of the surface, then those inside.
        let solid = whole <= most;
        let mut numbers: Vec<u32> =
            (0..).zip(&seen.marks).filter(|(_, marks)| marks.any_seen()).map(|(k, _)| k).collect();
        let surface = numbers.len();
        if solid {
            let hidden = |&k: &u32| drawn[k as usize] && !seen.marks[k as usize].any_seen();
            numbers.extend((0..whole as u32).filter(hidden));
        }

        let state = Instant::of(snapshot);
        let scales = SCALES.map(|field| {
            let values = field.values(&state);
            (Scale::of(&values), numbers.iter().map(|&k| values[k as usize]).collect::<Vec<_>>())
        });
        let pack = |places: std::ops::Range<usize>| {
            let mut packed = Packed::default();
            let numbers = &numbers[places.clone()];
            for corner in 0..4 {
                for (axis, &bounds) in bounds.iter().enumerate() {
                    let place =
                        |&k: &u32| snapshot.positions[snapshot.elements[k as usize][corner] as usize][axis];
                    packed.places(&numbers.iter().map(place).collect::<Vec<_>>(), bounds);
                }
            }
            for (scale, values) in &scales {
                packed.places(&values[places.clone()], scale.ends);
            }
            // Numbers ascend, and differences are easier to compress.
            let before = std::iter::once(&0).chain(numbers);
            packed.halves(
                &numbers.iter().zip(before).map(|(number, before)| number - before).collect::<Vec<_>>(),
            );
            let of = |all: &[u32]| -> Vec<u32> { numbers.iter().map(|&k| all[k as usize]).collect() };
            packed.halves(&of(&snapshot.bodies));
            packed.halves(&of(&snapshot.fragments));
            packed.numbers(&low_halves(&of(&snapshot.materials)));
            packed.numbers(&numbers.iter().map(|&k| seen.marks[k as usize].0).collect::<Vec<_>>());
            packed
        };
        let mut at_surface = pack(0..surface);
        let inside = pack(surface..numbers.len());

        let broken: Vec<&Crack<3>> = snapshot.cracks.iter().filter(|crack| crack.time.is_some()).collect();
        let mut holding = holding(snapshot);
        let (areas, others) = measures(&broken, &holding);
        for joints in &mut holding {
            joints.retain(|joint| joint.elements.iter().all(|&element| drawn[element as usize]));
        }
        let openings: Vec<f64> =
            seen.cracks.iter().map(|crack| snapshot.cracks[crack.place].opening).collect();
        let ends = Scale::of(&openings).ends;
        pack_cracks(&mut at_surface, snapshot, &seen, &numbers[..surface]);
        at_surface.places(&openings, ends);
        pack_holding(&mut at_surface, snapshot, &holding.concat(), &bounds);

        let packed = [at_surface.bytes, inside.bytes];
        Ok(Self {
            step: snapshot.step,
            time: snapshot.time,
            whole,
            surface,
            inside: numbers.len() - surface,
            solid,
            facets: seen.marks.iter().map(|marks| (marks.0 & 15).count_ones() as usize).sum(),
            fragments: snapshot.fragments.iter().max().map_or(0, |&last| last as usize + 1),
            cracks: seen.cracks.len(),
            intact: holding[0].len(),
            softening: holding[1].len(),
            bounds,
            scales: scales.map(|(scale, _)| scale),
            areas,
            others,
            openings: ends,
            grains: GrainFrame::new(&snapshot.spheres, around(whole, &bounds))?,
            sizes: [packed[0].len(), packed[1].len()],
            deflated: packed.map(|bytes| miniz_oxide::deflate::compress_to_vec(&bytes, LEVEL)),
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
    pub(crate) fn extent(&self) -> [[f64; 2]; 3] {
        extent_with(self.whole, self.bounds, &self.grains)
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
        let counts = [
            self.whole,
            self.surface,
            self.inside,
            usize::from(self.solid),
            self.facets,
            self.fragments,
            self.cracks,
            self.intact,
            self.softening,
        ];
        for number in counts.into_iter().chain(self.sizes).chain([self.deflated[0].len()]) {
            bytes.extend((number as u64).to_le_bytes());
        }
        let scales = self.scales.iter().flat_map(|scale| [scale.ends, scale.usual]).flatten();
        let numbers = self.bounds.into_iter().flatten().chain(scales).chain(self.areas);
        for number in numbers.chain(self.others).chain(self.openings) {
            bytes.extend(number.to_le_bytes());
        }
        self.grains.write(&mut bytes);
        bytes.extend(self.deflated.iter().flatten());
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
        let frame = (|| {
            let (step, time) = (words.u64()?, words.f64()?);
            let mut counts = [0; 12];
            for count in &mut counts {
                *count = usize::try_from(words.u64()?).ok()?;
            }
            let [whole, surface, inside, solid, facets, fragments, counts @ ..] = counts;
            let [cracks, intact, softening, outer, inner, first] = counts;
            let bounds = [words.pair()?, words.pair()?, words.pair()?];
            let (scales, areas) = (words.scales()?, [words.f64()?, words.f64()?, words.f64()?]);
            let (others, openings) = ([words.f64()?, words.f64()?, words.f64()?], words.pair()?);
            let grains = GrainFrame::read(&mut words)?;
            let (one, other) = words.bytes.split_at_checked(first)?;
            let deflated = [one.to_vec(), other.to_vec()];
            let (sizes, solid) = ([outer, inner], [false, true].get(solid).copied()?);
            Some(Self {
                step,
                time,
                whole,
                surface,
                inside,
                solid,
                facets,
                fragments,
                cracks,
                intact,
                softening,
                bounds,
                scales,
                areas,
                others,
                openings,
                grains,
                sizes,
                deflated,
            })
        })();
        let frame = frame.ok_or(FrameError::Damaged)?;
        frame.open()?;
        Ok(frame)
    }

    /// Decompresses the frame.
    pub(crate) fn open(&self) -> Result<OpenedSpace, FrameError> {
        self.try_open().ok_or(FrameError::Damaged)
    }

    fn try_open(&self) -> Option<OpenedSpace> {
        let elements = self.surface.checked_add(self.inside).filter(|&elements| elements <= self.whole)?;
        let holding = self.intact.checked_add(self.softening)?;
        let of_cracks =
            self.cracks.checked_mul(2 * OF_CRACKS)?.checked_add(holding.checked_mul(2 * OF_HOLDING)?)?;
        let expected = [
            self.surface.checked_mul(2 * OF_ELEMENTS)?.checked_add(of_cracks)?,
            self.inside.checked_mul(2 * OF_ELEMENTS)?,
        ];
        if expected != self.sizes || (self.inside > 0 && !self.solid) {
            return None;
        }
        let mut opened = OpenedSpace {
            surface: self.surface,
            solid: self.solid,
            numbers: Vec::with_capacity(elements),
            corners: Vec::with_capacity(elements),
            values: vec![Vec::with_capacity(elements); SCALES.len()],
            bodies: Vec::with_capacity(elements),
            materials: Vec::with_capacity(elements),
            fragments: Vec::with_capacity(elements),
            marks: Vec::with_capacity(elements),
            cracks: Vec::with_capacity(self.cracks),
            intact: Vec::new(),
            softening: Vec::new(),
        };
        for (part, count) in [self.surface, self.inside].into_iter().enumerate() {
            let size = self.sizes[part];
            let bytes =
                miniz_oxide::inflate::decompress_to_vec_with_limit(&self.deflated[part], size).ok()?;
            if bytes.len() != size {
                return None;
            }
            let mut arrays = Unpacked::new(&bytes);
            self.elements(&mut arrays, count, &mut opened)?;
            if part == 0 {
                self.opened_cracks(&mut arrays, &mut opened)?;
                self.opened_holding(&mut arrays, &mut opened)?;
            }
            if !arrays.is_empty() {
                return None;
            }
        }
        let seen = |marks: &Marks| (marks.0 & 15).count_ones() as usize;
        let facets: usize = opened.marks.iter().map(seen).sum();
        let split = |(place, marks): (usize, &Marks)| marks.any_seen() == (place < self.surface);
        (facets == self.facets && opened.marks.iter().enumerate().all(split)).then_some(opened)
    }

    /// Reads the elements of one part.
    fn elements(&self, arrays: &mut Unpacked<'_>, count: usize, opened: &mut OpenedSpace) -> Option<()> {
        let first = opened.corners.len();
        opened.corners.resize(first + count, [[f64::NAN; 3]; 4]);
        for corner in 0..4 {
            for (axis, &bounds) in self.bounds.iter().enumerate() {
                for (corners, x) in opened.corners[first..].iter_mut().zip(arrays.places(count, bounds)?) {
                    corners[corner][axis] = x;
                }
            }
        }
        if opened.corners[first..].iter().flatten().flatten().any(|x| !x.is_finite()) {
            return None;
        }
        for (values, scale) in opened.values.iter_mut().zip(&self.scales) {
            values.extend(arrays.places(count, scale.ends)?);
        }
        let mut number = 0_u32;
        for difference in arrays.halves(count)? {
            number = number.checked_add(difference).filter(|&number| (number as usize) < self.whole)?;
            opened.numbers.push(number);
        }
        opened.bodies.extend(arrays.halves(count)?);
        opened.fragments.extend(arrays.halves(count)?);
        opened.materials.extend(arrays.numbers(count)?.into_iter().map(u32::from));
        opened.marks.extend(arrays.numbers(count)?.into_iter().map(Marks));
        Some(())
    }

    /// Reads the joints that hold, after the cracks.
    fn opened_holding(&self, arrays: &mut Unpacked<'_>, opened: &mut OpenedSpace) -> Option<()> {
        let count = self.intact + self.softening;
        opened.intact.resize(count, [[f64::NAN; 3]; 3]);
        for corner in 0..3 {
            for (axis, &bounds) in self.bounds.iter().enumerate() {
                for (corners, x) in opened.intact.iter_mut().zip(arrays.places(count, bounds)?) {
                    corners[corner][axis] = x;
                }
            }
        }
        opened.softening = opened.intact.split_off(self.intact);
        // Pictures need neither their bodies nor their fragments.
        arrays.halves(count)?;
        arrays.halves(count)?;
        Some(())
    }

    /// Reads the cracks, after the elements of the surface.
    fn opened_cracks(&self, arrays: &mut Unpacked<'_>, opened: &mut OpenedSpace) -> Option<()> {
        let [one, other] = [arrays.halves(self.cracks)?, arrays.halves(self.cracks)?];
        let codes = arrays.numbers(self.cracks)?;
        let openings = arrays.places(self.cracks, self.openings)?;
        for (((one, other), code), opening) in one.into_iter().zip(other).zip(codes).zip(openings) {
            let facets = [one, other].map(|facet| (facet as usize / 4, facet as usize % 4));
            if facets
                .iter()
                .any(|&(element, facet)| opened.marks.get(element).is_none_or(|marks| !marks.seen(facet)))
            {
                return None;
            }
            let turn = usize::from(code >> 2 & 3);
            let at = |(element, _): (usize, usize), corner: usize| opened.corners[element][corner];
            let sides = [
                FACETS[facets[0].1].map(|corner| at(facets[0], corner)),
                [0, 1, 2].map(|k| at(facets[1], FACETS[facets[1].1][(turn + 3 - k) % 3])),
            ];
            let traces = [0, 3].map(|first| [0, 1, 2].map(|k| code >> (4 + first + k) & 1 == 1));
            opened.cracks.push(OpenedCrack {
                facets,
                sides,
                traces,
                kind: CrackKind::with_code(code & 3),
                opening,
            });
        }
        Some(())
    }
}

/// Appends the joints that hold: their corners, and the body and the fragment of the first of their elements.
fn pack_holding(
    packed: &mut Packed,
    snapshot: &Snapshot<3, 4>,
    joints: &[&Crack<3>],
    bounds: &[[f64; 2]; 3],
) {
    for corner in 0..3 {
        for (axis, &bounds) in bounds.iter().enumerate() {
            packed
                .places(&joints.iter().map(|joint| joint.corners[corner][axis]).collect::<Vec<_>>(), bounds);
        }
    }
    for of in [&snapshot.bodies, &snapshot.fragments] {
        packed.halves(&joints.iter().map(|joint| of[joint.elements[0] as usize]).collect::<Vec<_>>());
    }
}

/// Appends the cracks but their openings. The code of a crack has its kind in two bits; in the next two the
/// place, among the corners of the facet on side 1, of the vertex that is first on side 0 (the others follow
/// in the opposite order); then six bits of traces.
fn pack_cracks(packed: &mut Packed, snapshot: &Snapshot<3, 4>, seen: &VisibleParts, surface: &[u32]) {
    let place = |facet: u32| {
        // All elements at cracks are among those of the surface.
        let element = surface.binary_search(&(facet / 4)).unwrap_or_default();
        (4 * element) as u32 + facet % 4
    };
    for side in 0..2 {
        packed.halves(&seen.cracks.iter().map(|crack| place(crack.facets[side])).collect::<Vec<_>>());
    }
    let codes = seen.cracks.iter().map(|crack| {
        let corners = FACETS[crack.facets[1] as usize % 4];
        let turn = corners.iter().position(|&corner| corner == crack.corners[1][0]).unwrap_or(0);
        CrackKind::of(&snapshot.cracks[crack.place]).code() | (turn as u16) << 2 | crack.traces << 4
    });
    packed.numbers(&codes.collect::<Vec<_>>());
}
