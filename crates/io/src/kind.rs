//! Recognises the kind of a file: first by its content, then by its name.

use crate::error::ReadError;
use crate::foreign::BYTE_ORDER_MARK;
use crate::mesh::format::MeshFormat;
use crate::mesh::{vtk, vtk_xml};
use crate::packing_format::PackingFormat;
use crate::series::{dump, lammps_data, mercury, xyz};

/// The kind of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// Nodes and the elements between them: for [`read_mesh`](crate::read_mesh).
    Mesh(MeshFormat),
    /// Elements: for [`Series`](crate::Series).
    Packing(PackingFormat),
}

impl FileKind {
    /// The kind of a file, by its content or, if that is not conclusive, by its extension.
    ///
    /// VTK files are meshes if they have cells other than vertices; otherwise they are packings. A file of no
    /// other format is text.
    ///
    /// # Cost
    /// Reads the first lines only, and VTK files as far as the cells.
    ///
    /// # Errors
    /// [`ReadError::Foreign`] for UTF-16 and UTF-32, which cannot be read.
    ///
    /// # Example
    /// ```
    /// use fdem_io::{FileKind, MeshFormat, PackingFormat};
    ///
    /// assert_eq!(FileKind::of(b"x,y\n0,1\n", "a.csv")?, FileKind::Packing(PackingFormat::Text));
    /// assert_eq!(FileKind::of(b"1\n\nC 0 0 0\n", "a.txt")?, FileKind::Packing(PackingFormat::Xyz));
    /// assert_eq!(FileKind::of(b"solid wall\nendsolid wall\n", "a.stl")?, FileKind::Mesh(MeshFormat::Stl));
    /// # Ok::<(), fdem_io::ReadError>(())
    /// ```
    pub fn of(bytes: &[u8], name: &str) -> Result<Self, ReadError> {
        if let Some(format) = wide_text(bytes) {
            return Err(ReadError::Foreign { format, advice: "save it as UTF-8" });
        }
        let bare = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        if let Some(format) = by_content(bare) {
            return Ok(Self::Packing(format));
        }
        Ok(match MeshFormat::of(bytes, name) {
            // The reader of points reports the damage.
            Some(MeshFormat::Vtk) if !vtk::has_cells(bare).unwrap_or(false) => {
                Self::Packing(PackingFormat::Vtk)
            }
            Some(MeshFormat::VtkXml) if !vtk_xml::has_cells(bare).unwrap_or(false) => {
                Self::Packing(PackingFormat::VtkXml)
            }
            Some(format) => Self::Mesh(format),
            None => Self::Packing(PackingFormat::Text),
        })
    }
}

/// Formats whose first bytes are unique.
fn by_content(bytes: &[u8]) -> Option<PackingFormat> {
    Some(match bytes {
        _ if bytes.starts_with(b"\x93NUMPY") => PackingFormat::Npy,
        _ if bytes.starts_with(b"PK\x03\x04") && is_archive_of_arrays(bytes) => PackingFormat::Npz,
        _ if dump::is(bytes) => PackingFormat::LammpsDump,
        _ if lammps_data::is(bytes) => PackingFormat::LammpsData,
        _ if mercury::is(bytes) => PackingFormat::Mercury,
        _ if xyz::is(bytes) => PackingFormat::Xyz,
        _ => return None,
    })
}

/// Whether the first member of a zip archive is an array; spreadsheets are zip archives too.
fn is_archive_of_arrays(bytes: &[u8]) -> bool {
    let length =
        bytes.get(26..28).map_or(0, |length| usize::from(u16::from_le_bytes([length[0], length[1]])));
    bytes.get(30..30 + length).is_some_and(|name| name.ends_with(b".npy"))
}

/// Names the encoding if the text has two or four bytes per character: by its byte order mark or, without
/// one, if every second byte at the start is 0.
fn wide_text(bytes: &[u8]) -> Option<&'static str> {
    /// Number of characters needed to recognise it without a mark.
    const SURE: usize = 8;
    match bytes {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => return Some("UTF-32 text"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return Some("UTF-16 text"),
        _ => {}
    }
    let (pairs, _) = bytes.as_chunks::<2>();
    let pairs = &pairs[..pairs.len().min(64)];
    let is_text = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let all =
        |low: usize| pairs.len() >= SURE && pairs.iter().all(|pair| is_text(pair[low]) && pair[1 - low] == 0);
    (all(0) || all(1)).then_some("UTF-16 text")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_text_is_known_with_and_without_its_mark() {
        let wide = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
        let text = "x,y,radius\n0,0,1\n";
        assert_eq!(wide_text(&wide(text)), Some("UTF-16 text"));
        assert_eq!(wide_text(&wide(&format!("\u{feff}{text}"))), Some("UTF-16 text"));
        assert_eq!(wide_text(&wide(text)[1..]), Some("UTF-16 text"), "the other order");
        assert_eq!(wide_text(text.as_bytes()), None);
        assert_eq!(wide_text(b"\x01\x00\x02\x00"), None);
    }
}
