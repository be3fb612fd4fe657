//! Files of elements in any format, as one or several frames.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::ReadError;
use crate::foreign::{BYTE_ORDER_MARK, foreign};
use crate::kind::FileKind;
use crate::lines::{Lines, Start};
use crate::npy::read_npy;
use crate::options::ReadOptions;
use crate::packing::Packing;
use crate::packing_format::PackingFormat;
use crate::place::Place;
use crate::series::collection::{Collection, PieceFiles};
use crate::text::{check_text, read_text};

pub(crate) mod collection;
pub(crate) mod dump;
pub(crate) mod dump_local;
pub(crate) mod lammps_data;
pub(crate) mod mercury;
mod npz;
mod rows;
pub(crate) mod values;
mod vtk;
pub(crate) mod xyz;

/// The frames of a file; each is read when it is requested.
///
/// The formats are those of [`PackingFormat`]; see also [`Self::read`]. Dumps, XYZ and MercuryDPM files may
/// have many frames; all others have one.
///
/// # Example
/// ```
/// use std::sync::atomic::AtomicU64;
/// use fdem_io::{PackingFormat, ReadOptions, Series};
///
/// let text = b"1\nLattice=\"4 0 0 0 4 0 0 0 4\" Properties=species:S:1:pos:R:3:radius:R:1 step=10\nSi 1 2 3 0.5\n\
///              1\nLattice=\"4 0 0 0 4 0 0 0 4\" Properties=species:S:1:pos:R:3:radius:R:1 step=20\nSi 1 2 4 0.5\n";
/// let series = Series::open(text, "run.xyz", None)?;
/// assert_eq!((series.format(), series.frames()), (PackingFormat::Xyz, 2));
/// let packing = series.read(1, &ReadOptions::default(), &AtomicU64::new(0))?;
/// assert_eq!(packing.frame.step, Some(20));
/// assert_eq!(packing.radii, Some(vec![0.5]));
/// assert_eq!(packing.cell.map(|cell| cell.repeats), Some([true; 3]));
/// # Ok::<(), fdem_io::ReadError>(())
/// ```
#[derive(Debug)]
pub struct Series<'a> {
    bytes: &'a [u8],
    format: PackingFormat,
    /// The format that the name promises, if the content does not have it.
    promised: Option<(PackingFormat, &'static str)>,
    /// The start of each frame; one for formats without frames.
    starts: Arc<[Start]>,
    /// The frames of a collection, and the files that it lists.
    pieces: Option<(Collection, &'a dyn PieceFiles)>,
}

/// The format and the frames of a file without its bytes, for owners of the bytes.
///
/// # Example
/// ```
/// use std::sync::atomic::AtomicU64;
/// use fdem_io::{ReadOptions, Series};
///
/// let bytes = b"1\n\nC 0 1 2\n1\n\nC 3 4 5\n".to_vec();
/// let index = Series::open(&bytes, "run.xyz", None)?.index();
/// let series = Series::of_index(&bytes, index);
/// assert_eq!(series.read(1, &ReadOptions::default(), &AtomicU64::new(0))?.frame.index, 1);
/// # Ok::<(), fdem_io::ReadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FrameIndex {
    format: PackingFormat,
    promised: Option<(PackingFormat, &'static str)>,
    starts: Arc<[Start]>,
}

impl FrameIndex {
    /// Number of frames; at least one.
    pub fn frames(&self) -> usize {
        self.starts.len()
    }
}

impl<'a> Series<'a> {
    /// The places of the frames in the bytes, so that they need not be searched again.
    pub fn index(&self) -> FrameIndex {
        let Self { format, promised, ref starts, .. } = *self;
        FrameIndex { format, promised, starts: Arc::clone(starts) }
    }

    /// The frames of the bytes in which `index` was found.
    ///
    /// # Panics
    /// [`Self::read`] panics if the bytes are shorter than those.
    pub fn of_index(bytes: &'a [u8], index: FrameIndex) -> Self {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        let FrameIndex { format, promised, starts } = index;
        Self { bytes, format, promised, starts, pieces: None }
    }

    /// Recognises the format of a file and finds the starts of its frames.
    ///
    /// `name`: the name of the file without the extension of its compression. `format`: the format to use
    /// instead of the recognised one.
    ///
    /// # Cost
    /// For formats with several frames, a pass over the lines, and 16 bytes of memory per frame.
    ///
    /// # Errors
    /// [`ReadError::Empty`]; [`ReadError::Foreign`] and [`ReadError::NotText`] for bytes of no supported
    /// format. This function does not distinguish a mesh from a text table: see [`FileKind::of`]. Errors
    /// inside a frame are returned by [`Self::read`].
    pub fn open(bytes: &'a [u8], name: &str, format: Option<PackingFormat>) -> Result<Self, ReadError> {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        if bytes.is_empty() {
            return Err(ReadError::Empty);
        }
        let format = match format {
            Some(format) => format,
            None => match FileKind::of(bytes, name)? {
                FileKind::Packing(format) => format,
                FileKind::Mesh(_) => PackingFormat::Text,
            },
        };
        let promised = PackingFormat::promised_by(name)
            .filter(|&(promised, _)| format == PackingFormat::Text && promised != format);
        let next: Option<fn(&mut Lines<'_>) -> bool> = match format {
            PackingFormat::LammpsDump => Some(dump::pass),
            PackingFormat::Xyz => Some(xyz::pass),
            PackingFormat::Mercury => Some(mercury::pass),
            _ => None,
        };
        if next.is_some() || format == PackingFormat::LammpsData {
            check_text(bytes)?;
        }
        let starts = next.map_or_else(|| vec![Start::default()], |next| starts(bytes, next));
        Ok(Self { bytes, format, promised, starts: starts.into(), pieces: None })
    }

    /// Opens a collection of ParaView, a `.pvd`, `.pvtp`, `.pvtu` or `.vtm` file with the content `bytes`:
    /// its frames are the time steps of the `.pvd`, or there is one. `None` if the file is no collection.
    ///
    /// The files of a frame are joined, except points that are marked as ghosts. They are opened when the
    /// frame is read, and may be collections too.
    ///
    /// # Errors
    /// A list that cannot be read. [`Self::read`] returns the errors of the pieces, with the line of the
    /// piece in the list: a piece that cannot be opened, leads to itself, is no VTK file or has cells, or
    /// whose point data have other names than those of the first piece.
    pub fn of_collection(bytes: &'a [u8], files: &'a dyn PieceFiles) -> Result<Option<Self>, ReadError> {
        if !collection::is(bytes) {
            return Ok(None);
        }
        let collection = Collection::read(bytes)?;
        let starts = vec![Start::default(); collection.frames.len()].into();
        let pieces = Some((collection, files));
        Ok(Some(Self { bytes, format: PackingFormat::VtkXml, promised: None, starts, pieces }))
    }

    /// The format in which the frames are read.
    pub fn format(&self) -> PackingFormat {
        self.format
    }

    /// Number of frames; at least one, which may be damaged.
    pub fn frames(&self) -> usize {
        self.starts.len()
    }

    /// Reads a frame, counted from 0.
    ///
    /// - Text and NumPy arrays: see [`read`](crate::read). YADE's `#format x_y_z_r` names columns.
    /// - NumPy archives: a single array is read like a NumPy file. Otherwise `positions` (n, 2) or (n, 3), or
    ///   `x`, `y`, `z`, and `radii` or `diameters` and `ids`, under these and similar names, n each.
    /// - LAMMPS and LIGGGHTS dumps: `x y z`, or the scaled `xs ys zs`, the unwrapped `xu yu zu`, or
    ///   `xsu ysu zsu`; `radius` or `diameter`; `id`. The box in its three forms, periodic along edges marked
    ///   `pp`.
    /// - LAMMPS and LIGGGHTS data: columns by the atom style after `Atoms #`, or by [`ReadOptions::columns`].
    ///   These files do not say whether the box is periodic.
    /// - XYZ: the columns after `Properties=`, or a name and x y z; further columns are ignored. `Lattice=`
    ///   with `Origin=` is the box, periodic along the edges given by `pbc=`, or along all edges without it.
    /// - MercuryDPM: 14 columns in 3D, 8 in 2D; the limits are not periodic.
    /// - VTK: points, with the first of their data named radius, diameter and the like. `Scale` is a
    ///   diameter, as for the spheres of `ParaView`.
    ///
    /// # Shapes
    /// `progress`: the number of bytes of the file parsed so far; the end of the frame on success.
    ///
    /// # Units
    /// The units of the file.
    ///
    /// # Cost
    /// Time proportional to the bytes of the frame; for compressed VTK arrays and archives, to their
    /// decompressed content. Memory: the packing and, for VTK files and archives, the arrays.
    ///
    /// # Errors
    /// [`ReadError`], inside [`ReadError::InFrame`] if there are several frames.
    ///
    /// # Source
    /// LAMMPS documentation of `dump` and `read_data`; ASE, "Extended XYZ"; `MercuryDPM` documentation, "The
    /// data file"; VTK file formats.
    pub fn read(
        &self,
        frame: usize,
        options: &ReadOptions,
        progress: &AtomicU64,
    ) -> Result<Packing, ReadError> {
        let Some(&start) = self.starts.get(frame) else {
            return Err(ReadError::NoFrame { wanted: frame, frames: self.frames() });
        };
        let end = self.starts.get(frame + 1).map_or(self.bytes.len(), |next| next.byte);
        let lines = Lines::of_frame(&self.bytes[..end], start);
        progress.store(start.byte as u64, Ordering::Relaxed);
        let read = match self.format {
            PackingFormat::Text => self.read_text(options, progress),
            PackingFormat::Npy if !self.bytes.starts_with(b"\x93NUMPY") => {
                let problem = "NumPy header: it does not start with \\x93NUMPY".to_owned();
                Err(ReadError::Broken { place: Place::File, problem })
            }
            PackingFormat::Npy => read_npy(self.bytes, options, progress),
            PackingFormat::Npz => npz::read(self.bytes, options),
            PackingFormat::LammpsDump => dump::read(lines, options, progress),
            PackingFormat::LammpsData => lammps_data::read(lines, options, progress),
            PackingFormat::Xyz => xyz::read(lines, options, progress),
            PackingFormat::Mercury => mercury::read(lines, options, progress),
            PackingFormat::Vtk => vtk::read(self.bytes, options),
            PackingFormat::VtkXml => match &self.pieces {
                Some((collection, files)) => vtk::read_pieces(&collection.frames[frame], *files, options),
                None => vtk::read_xml(self.bytes, options),
            },
        };
        let mut packing = match read {
            Err(error) if self.frames() > 1 => {
                return Err(ReadError::InFrame { frame, error: Box::new(error) });
            }
            read => read?,
        };
        packing.frame.index = frame;
        progress.store(end as u64, Ordering::Relaxed);
        Ok(packing)
    }

    fn read_text(&self, options: &ReadOptions, progress: &AtomicU64) -> Result<Packing, ReadError> {
        let read = match foreign(self.bytes) {
            Some(error) => Err(error),
            None => read_text(self.bytes, options, progress),
        };
        match (read, self.promised) {
            (Err(error), Some((promised, expected))) => {
                Err(ReadError::NotPromised { promised, expected, error: Box::new(error) })
            }
            (read, _) => read,
        }
    }
}

/// Reads a file with one frame; [`Series`] reads files with more.
///
/// # Shapes
/// `name`: the name of the file. `progress`: see [`Series::read`].
///
/// # Errors
/// The errors of [`Series::open`] and [`Series::read`]; [`ReadError::SeveralFrames`].
///
/// # Example
/// ```
/// use std::sync::atomic::AtomicU64;
///
/// let packing = fdem_io::read_packing(b"1\n\nC 0 1 2\n", "a.xyz", &Default::default(), &AtomicU64::new(0))?;
/// assert_eq!(packing.centres, fdem_io::Centres::Three(vec![[0.0, 1.0, 2.0]]));
/// # Ok::<(), fdem_io::ReadError>(())
/// ```
pub fn read_packing(
    bytes: &[u8],
    name: &str,
    options: &ReadOptions,
    progress: &AtomicU64,
) -> Result<Packing, ReadError> {
    let (bytes, _) = crate::unpack::unpack(Cow::Borrowed(bytes), |_| true)?;
    let series = Series::open(&bytes, name, None)?;
    match series.frames() {
        1 => series.read(0, options, progress),
        frames => Err(ReadError::SeveralFrames { frames }),
    }
}

/// The starts of frames, up to one that cannot be skipped or to the end.
fn starts(bytes: &[u8], pass: fn(&mut Lines<'_>) -> bool) -> Vec<Start> {
    let mut lines = Lines::new(bytes);
    let mut starts = Vec::new();
    loop {
        starts.push(lines.start());
        if !pass(&mut lines) || !lines.more() {
            return starts;
        }
    }
}
