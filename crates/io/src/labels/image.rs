//! A labelled image that is read plane by plane.

use std::io::{self, Read};

use crate::labels::error::LabelError;
use crate::labels::kind::LabelKind;
use crate::labels::value::LabelValue;
use crate::npy_header::Scalar;

/// A labelled image that is being read.
#[derive(Debug)]
pub struct LabelImage<'a> {
    pub(super) planes: Planes<'a>,
    pub(super) scalar: Scalar,
    pub(super) kind: LabelKind,
    /// The axes in the order of the bytes: the slowest first.
    pub(super) shape: Vec<usize>,
    pub(super) reversed: bool,
    pub(super) format: String,
    /// Number of planes read.
    pub(super) position: usize,
}

/// The source of the planes.
pub(super) enum Planes<'a> {
    /// Planes follow one another in a stream.
    Stream(&'a mut dyn Read),
    /// Each plane is a page.
    Pages(&'a mut dyn Pages),
}

impl std::fmt::Debug for Planes<'_> {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Stream(_) => "Stream",
            Self::Pages(_) => "Pages",
        })
    }
}

/// The pages of a file, each a plane.
pub(super) trait Pages {
    /// The bytes of a page in native byte order; pages must be requested in order.
    fn read(&mut self, page: usize) -> Result<&[u8], LabelError>;
}

/// Number of bytes that are converted to labels at a time: few enough for a cache, many enough for a disk.
pub(super) const PIECE: usize = 1 << 18;

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
