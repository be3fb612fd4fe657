//! Images in NumPy files and archives.

use std::io::{Read, Seek};

use zip::ZipArchive;
use zip::result::ZipError;

use crate::excerpt;
use crate::labels::error::LabelError;
use crate::labels::image::{LabelImage, Planes};
use crate::labels::kind::kind_of;
use crate::npy_header::{Dtype, Header, Scalar};

/// The first bytes of a NumPy file.
pub(super) const NPY: &[u8] = b"\x93NUMPY";

/// Number of bytes of magic, version, and the longer of the two forms of length.
const PREFIX: usize = 12;
/// Upper bound on the length of the header of an array of numbers; NumPy itself accepts 10,000 characters.
const LONGEST_HEADER: u64 = 1 << 16;

/// Reads the header; `size` is the size of the file, if it is known.
pub(super) fn open(input: &mut dyn Read, size: Option<u64>) -> Result<LabelImage<'_>, LabelError> {
    let header = header(input)?;
    let shown = header.shown_shape();
    let dtype = || header.descr.clone();
    let scalar = match &header.dtype {
        Dtype::Plain(scalar) => scalar.clone(),
        Dtype::Record(_) => return Err(LabelError::Dtype { dtype: dtype(), shape: shown }),
    };
    let Some(kind) = kind_of(&scalar) else {
        return Err(LabelError::Dtype { dtype: dtype(), shape: shown });
    };
    if !(2..=3).contains(&header.shape.len()) {
        return Err(LabelError::Shape { shape: shown });
    }
    let shape: Result<Vec<usize>, _> = header.shape.iter().map(|&length| usize::try_from(length)).collect();
    let (Ok(mut shape), claim) = (shape, LabelError::Claim { shape: shown, dtype: dtype() }) else {
        return Err(LabelError::Claim { shape: header.shown_shape(), dtype: dtype() });
    };
    let Some(expected) = size_of_array(&shape, &scalar) else { return Err(claim) };
    if let Some(found) = size.map(|size| size.saturating_sub(header.data as u64)) {
        if found < expected {
            return Err(LabelError::CutOff { expected, found });
        }
        if found > expected {
            return Err(LabelError::Longer { expected });
        }
    }
    if header.fortran_order {
        shape.reverse();
    }
    let order = if header.fortran_order { ", in Fortran order" } else { "" };
    let format = format!("NumPy array of {}{order}", header.descr);
    let reversed = header.fortran_order;
    Ok(LabelImage { planes: Planes::Stream(input), scalar, kind, shape, reversed, format, position: 0 })
}

/// The number of bytes of an array, if such an array can exist.
fn size_of_array(shape: &[usize], scalar: &Scalar) -> Option<u64> {
    let squares = shape.iter().try_fold(1_usize, |squares, &length| squares.checked_mul(length))?;
    // A length of 0 must not hide an overflow of the other lengths.
    let planes = shape.iter().try_fold(1_usize, |squares, &length| squares.checked_mul(length.max(1)))?;
    planes.checked_mul(scalar.size)?;
    Some(squares as u64 * scalar.size as u64)
}

/// Reads exactly the bytes of the header.
fn header(input: &mut dyn Read) -> Result<Header, LabelError> {
    let problem = |problem: String| LabelError::Header { problem };
    let mut bytes = Vec::new();
    let mut read = |bytes: &mut Vec<u8>, up_to: usize| {
        let more = up_to.saturating_sub(bytes.len()) as u64;
        (&mut *input).take(more).read_to_end(bytes).map_err(LabelError::Read)
    };
    // In version 1 the length has two bytes, so the text starts two bytes earlier; it is never shorter than
    // that.
    read(&mut bytes, PREFIX)?;
    if !bytes.starts_with(NPY) {
        return Err(problem("it does not start with \\x93NUMPY".to_owned()));
    }
    let end = match bytes.get(NPY.len()..) {
        Some(&[1, _, low, high, _, _]) => 10 + u64::from(u16::from_le_bytes([low, high])),
        Some(&[_, _, a, b, c, d]) => PREFIX as u64 + u64::from(u32::from_le_bytes([a, b, c, d])),
        _ => 0,
    };
    if end > LONGEST_HEADER {
        return Err(problem(format!("it claims to be {end} bytes long: it is damaged")));
    }
    read(&mut bytes, end as usize)?;
    Header::parse(&bytes).map_err(problem)
}

/// Opens the array `member` of an archive, or its only array.
pub(super) fn visit_member<R: Read + Seek, T, E: From<LabelError>>(
    input: R,
    member: Option<&str>,
    visit: impl FnOnce(&mut LabelImage<'_>) -> Result<T, E>,
) -> Result<T, E> {
    let problem = |error: ZipError| LabelError::Archive { problem: error.to_string() };
    let mut archive = ZipArchive::new(input).map_err(problem)?;
    let name = |archive: &ZipArchive<R>, at| {
        let name = archive.name_for_index(at).and_then(Result::ok);
        name.map(|name| name.strip_suffix(".npy").unwrap_or(&name).to_owned())
    };
    let names: Vec<String> = (0..archive.len()).filter_map(|at| name(&archive, at)).collect();
    let wanted = member.map(|member| member.strip_suffix(".npy").unwrap_or(member));
    let chosen = match wanted {
        None if names.len() == 1 => names.first(),
        None => None,
        Some(wanted) => names.iter().find(|name| *name == wanted),
    };
    let Some(chosen) = chosen else {
        let present = names.iter().map(|name| excerpt::field(name.as_bytes())).collect();
        return Err(LabelError::Member { wanted: wanted.map(str::to_owned), present }.into());
    };
    let at = (0..archive.len()).find(|&at| name(&archive, at).as_ref() == Some(chosen)).unwrap_or(0);
    let mut file = archive.by_index(at).map_err(problem)?;
    let shown = excerpt::field(chosen.as_bytes());
    let mut image = open(&mut file, None)?;
    image.format = format!("{shown} in a NumPy archive, {}", image.format);
    visit(&mut image)
}
