//! Formats that are recognised by their first bytes, but not read as tables.

use crate::error::ReadError;

/// The error for a file that starts like one of another format.
pub(crate) fn foreign(bytes: &[u8]) -> Option<ReadError> {
    let (_, format, advice) = FOREIGN.iter().find(|(magic, ..)| bytes.starts_with(magic))?;
    Some(ReadError::Foreign { format, advice })
}

/// The byte order mark that some programs write before text in UTF-8.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

const UNPACK: &str = "unpack it first";
const AS_UTF_8: &str = "save it as UTF-8";
const AS_TABLE: &str = "export the elements as a CSV table with columns x, y, z and radius";

/// Other formats that users pass by mistake: first bytes, name, advice. The first match counts.
pub(crate) const FOREIGN: [(&[u8], &str, &str); 15] = [
    (b"\x1f\x8b", "gzip-compressed data", UNPACK),
    (b"\x28\xb5\x2f\xfd", "zstd-compressed data", UNPACK),
    (b"\xfd7zXZ\x00", "xz-compressed data", UNPACK),
    (b"BZh", "bzip2-compressed data", UNPACK),
    (
        b"PK\x03\x04",
        "a zip archive (perhaps .npz or .xlsx)",
        "save one array with numpy.save, or a CSV table",
    ),
    (b"%PDF", "a PDF document", AS_TABLE),
    (b"\x89HDF", "an HDF5 file", AS_TABLE),
    (b"# vtk DataFile", "a VTK file", AS_TABLE),
    (b"<VTKFile", "a VTK file", AS_TABLE),
    (b"<?xml", "an XML file", AS_TABLE),
    (
        b"ITEM: TIMESTEP",
        "a LAMMPS dump",
        "keep the rows of one time step, under a line with the column names",
    ),
    // Must come before UTF-16, because its mark starts with that of UTF-16.
    (b"\xff\xfe\x00\x00", "UTF-32 text", AS_UTF_8),
    (b"\xff\xfe", "UTF-16 text", AS_UTF_8),
    (b"\xfe\xff", "UTF-16 text", AS_UTF_8),
    (b"\x00\x00\xfe\xff", "UTF-32 text", AS_UTF_8),
];
