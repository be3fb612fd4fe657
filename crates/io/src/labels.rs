//! Labelled images, read plane by plane.

mod npy;
mod tiff;
mod value;

use std::io::{self, Read, Seek, SeekFrom};

use crate::npy_header::Scalar;

pub use error::LabelError;
pub use value::LabelValue;

mod error;

/// The type of the labels of an image: the [`LabelValue`] to read them as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LabelKind {
    /// `u8`.
    U8,
    /// `u16`.
    U16,
    /// `u32`.
    U32,
    /// `u64`.
    U64,
    /// `i32`; shorter signed numbers are widened to it.
    I32,
    /// `i64`.
    I64,
}

/// A labelled image that is being read.
#[derive(Debug)]
pub struct LabelImage<'a> {
    planes: Planes<'a>,
    scalar: Scalar,
    kind: LabelKind,
    /// The axes in the order of the bytes: the slowest first.
    shape: Vec<usize>,
    reversed: bool,
    format: String,
    /// Number of planes read.
    position: usize,
}

/// The source of the planes.
enum Planes<'a> {
    /// Planes follow one another in a stream.
    Stream(&'a mut dyn Read),
    /// Each plane is a page.
    Pages(&'a mut dyn tiff::Pages),
}

impl std::fmt::Debug for Planes<'_> {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Stream(_) => "Stream",
            Self::Pages(_) => "Pages",
        })
    }
}

/// Number of bytes that are converted to labels at a time: few enough for a cache, many enough for a disk.
const PIECE: usize = 1 << 18;
/// The first bytes of a NumPy file.
const NPY: &[u8] = b"\x93NUMPY";
const ZIP: [&[u8]; 2] = [b"PK\x03\x04", b"PK\x05\x06"];
const TIFF: [&[u8]; 4] = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"];

/// Opens a labelled image and passes it to `visit`, which reads it.
///
/// The format is recognised by the content, never by a name: a NumPy array (`.npy`) in C or Fortran order; an
/// array in a NumPy archive (`.npz`, stored or deflated); or a greyscale TIFF file of 8, 16, 32 or 64 bits,
/// one page (2D) or more (3D), also `BigTIFF`, uncompressed or compressed with `PackBits`, LZW or deflate.
/// Labels are integers of at most 64 bits.
///
/// # Shapes
/// Two or three axes. `member` is the name of an array in an archive, with or without `.npy`; `None` takes
/// the only one.
///
/// # Cost
/// Memory does not depend on the size that a header claims: planes grow as their bytes arrive. A page of a
/// TIFF file takes the memory of its labels; it is refused if the whole file could not contain as much.
///
/// # Errors
/// [`LabelError`] if the format is unknown, there is no labelled image, the file is damaged, or the member
/// does not exist.
///
/// # Example
/// ```
/// use fdem_io::{LabelKind, with_label_image};
///
/// let mut file = b"\x93NUMPY\x01\x00\x46\x00".to_vec();
/// file.extend(format!("{:<69}\n", "{'descr': '<u2', 'fortran_order': False, 'shape': (2, 2), }").bytes());
/// file.extend([1, 0, 1, 0, 2, 0, 0, 0]);
/// let labels = with_label_image(std::io::Cursor::new(file), None, |image| {
///     assert_eq!((image.kind(), image.shape()), (LabelKind::U16, &[2, 2][..]));
///     let mut labels = Vec::<u16>::new();
///     image.read_planes(2, &mut labels)?;
///     Ok::<_, fdem_io::LabelError>(labels)
/// })?;
/// assert_eq!(labels, [1, 1, 2, 0]);
/// # Ok::<(), fdem_io::LabelError>(())
/// ```
pub fn with_label_image<R: Read + Seek, T, E: From<LabelError>>(
    mut input: R,
    member: Option<&str>,
    visit: impl FnOnce(&mut LabelImage<'_>) -> Result<T, E>,
) -> Result<T, E> {
    let mut start = Vec::new();
    let read = input.by_ref().take(8).read_to_end(&mut start).and_then(|_| input.seek(SeekFrom::End(0)));
    let size = read.map_err(LabelError::Read)?;
    input.rewind().map_err(LabelError::Read)?;
    let is_archive = ZIP.iter().any(|magic| start.starts_with(magic));
    if let (Some(member), false) = (member, is_archive) {
        return Err(LabelError::NoArchive { member: member.to_owned() }.into());
    }
    if start.starts_with(NPY) {
        return visit(&mut npy::open(&mut io::BufReader::with_capacity(PIECE, input), Some(size))?);
    }
    if is_archive {
        return npy::visit_member(input, member, visit);
    }
    if TIFF.iter().any(|magic| start.starts_with(magic)) {
        let (mut pages, described) = tiff::open(io::BufReader::new(input), size)?;
        return visit(&mut described.image(&mut pages));
    }
    Err(LabelError::unknown(&start).into())
}

impl LabelImage<'_> {
    /// The type to read the labels as.
    pub fn kind(&self) -> LabelKind {
        self.kind
    }

    /// Number of grid squares along each axis, in the order of the bytes, the slowest first: two or three
    /// axes.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Whether the axes of the array are in the opposite order, as in Fortran order.
    pub fn reversed(&self) -> bool {
        self.reversed
    }

    /// Description of the file for people: `NumPy array of <u2`.
    pub fn format(&self) -> &str {
        &self.format
    }

    /// Reads up to `most` planes of the slowest axis, fewer at the end of the image, and returns their
    /// number. The content of `into` is replaced.
    ///
    /// In 2D a plane is a row. A TIFF file in 2D has no separate rows, so all rows are read together.
    ///
    /// The end of the file is checked together with the last plane.
    ///
    /// # Errors
    /// [`LabelError::Kind`] if the labels have another type; [`LabelError::CutOff`], [`LabelError::Longer`],
    /// [`LabelError::Read`] or [`LabelError::Page`] if the file is damaged; [`LabelError::NoMemory`].
    pub fn read_planes<L: LabelValue>(
        &mut self,
        most: usize,
        into: &mut Vec<L>,
    ) -> Result<usize, LabelError> {
        into.clear();
        if L::KIND != self.kind {
            return Err(LabelError::Kind { found: self.kind, asked: L::KIND });
        }
        let rest = self.shape[0] - self.position;
        let single_page = matches!(self.planes, Planes::Pages(_)) && self.shape.len() == 2;
        let planes = if single_page { rest } else { most.min(rest) };
        if planes == 0 && self.shape[0] > 0 {
            return Ok(0);
        }
        let squares: usize = self.shape[1..].iter().product();
        let scalar = &self.scalar;
        let mut take = |bytes: &[u8]| -> Result<(), LabelError> {
            let more = bytes.len() / scalar.size;
            into.try_reserve(more).map_err(|_| LabelError::NoMemory { bytes: more * size_of::<L>() })?;
            L::extend(into, bytes, scalar);
            Ok(())
        };
        match &mut self.planes {
            Planes::Pages(pages) if single_page => take(pages.read(0)?)?,
            Planes::Pages(pages) => {
                for page in self.position..self.position + planes {
                    take(pages.read(page)?)?;
                }
            }
            Planes::Stream(input) => {
                let claimed = (self.shape[0] * squares) as u64 * scalar.size as u64;
                let mut rest = planes * squares * scalar.size;
                let mut done = (self.position * squares * scalar.size) as u64;
                let mut piece = vec![0; PIECE.min(rest)];
                while rest > 0 {
                    let part = piece.len().min(rest);
                    let read = fill(input, &mut piece[..part]).map_err(LabelError::Read)?;
                    done += read as u64;
                    if read < part {
                        return Err(LabelError::CutOff { expected: claimed, found: done });
                    }
                    take(&piece[..part])?;
                    rest -= part;
                }
                // This also verifies the checksum of a member of an archive.
                if self.position + planes == self.shape[0]
                    && fill(input, &mut [0]).map_err(LabelError::Read)? > 0
                {
                    return Err(LabelError::Longer { expected: claimed });
                }
            }
        }
        self.position += planes;
        Ok(planes)
    }
}

/// Reads until `into` is full or the input ends.
fn fill(input: &mut dyn Read, into: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < into.len() {
        match input.read(&mut into[filled..]) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// The type of labels for numbers of this dtype, if they can be labels.
fn kind_of(scalar: &Scalar) -> Option<LabelKind> {
    Some(match (scalar.kind, scalar.size) {
        ('u', 1) => LabelKind::U8,
        ('u', 2) => LabelKind::U16,
        ('u', 4) => LabelKind::U32,
        ('u', 8) => LabelKind::U64,
        ('i', 1 | 2 | 4) => LabelKind::I32,
        ('i', 8) => LabelKind::I64,
        _ => return None,
    })
}

/// The number of bytes of an array, if such an array can exist.
fn size_of_array(shape: &[usize], scalar: &Scalar) -> Option<u64> {
    let squares = shape.iter().try_fold(1_usize, |squares, &length| squares.checked_mul(length))?;
    // A length of 0 must not hide an overflow of the other lengths.
    let planes = shape.iter().try_fold(1_usize, |squares, &length| squares.checked_mul(length.max(1)))?;
    planes.checked_mul(scalar.size)?;
    Some(squares as u64 * scalar.size as u64)
}
