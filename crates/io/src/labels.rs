//! Labelled images, read plane by plane.

mod error;
mod image;
mod kind;
mod npy;
mod tiff;
mod value;

use std::io::{self, Read, Seek, SeekFrom};

use image::PIECE;
use npy::NPY;

pub use error::LabelError;
pub use image::LabelImage;
pub use kind::LabelKind;
pub use value::LabelValue;

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
