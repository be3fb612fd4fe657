//! Recognises the kind of a file: first by its content, then by its name.

use std::fmt;
use std::str::FromStr;

use crate::error::ReadError;
use crate::mesh::{self, MeshFormat};
use crate::read::BYTE_ORDER_MARK;
use crate::series::{dump, lammps_data, mercury, xyz};

/// Format of a file of elements.
///
/// # Example
/// ```
/// use fdem_io::PackingFormat;
///
/// assert_eq!("xyz".parse(), Ok(PackingFormat::Xyz));
/// assert_eq!(PackingFormat::LammpsDump.to_string(), "LAMMPS dump");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PackingFormat {
    /// Delimited text, including the tables that YADE writes.
    Text,
    /// A NumPy array.
    Npy,
    /// A NumPy archive.
    Npz,
    /// A dump of LAMMPS or LIGGGHTS, text.
    LammpsDump,
    /// A data file of LAMMPS or LIGGGHTS.
    LammpsData,
    /// XYZ and extended XYZ.
    Xyz,
    /// A `.data` file of MercuryDPM.
    Mercury,
    /// Points of a legacy VTK file.
    Vtk,
    /// Points of a VTU or VTP file.
    VtkXml,
}

impl PackingFormat {
    /// All formats.
    pub const ALL: [Self; 9] = [
        Self::Text,
        Self::Npy,
        Self::Npz,
        Self::LammpsDump,
        Self::LammpsData,
        Self::Xyz,
        Self::Mercury,
        Self::Vtk,
        Self::VtkXml,
    ];

    /// The name on a command line; [`FromStr`] accepts it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Npy => "npy",
            Self::Npz => "npz",
            Self::LammpsDump => "lammps-dump",
            Self::LammpsData => "lammps-data",
            Self::Xyz => "xyz",
            Self::Mercury => "mercury",
            Self::Vtk => "vtk",
            Self::VtkXml => "vtk-xml",
        }
    }

    /// Whether a file of this format may have several frames.
    pub fn has_frames(self) -> bool {
        matches!(self, Self::LammpsDump | Self::Xyz | Self::Mercury)
    }

    /// The format for the extension of this name, and a description of such a file. Extensions that are used
    /// for tables of any kind give `None`.
    pub(crate) fn promised_by(name: &str) -> Option<(Self, &'static str)> {
        let (_, extension) = name.rsplit_once('.')?;
        Some(match extension.to_ascii_lowercase().as_str() {
            "npy" => (Self::Npy, "it does not start with \\x93NUMPY"),
            "npz" => (Self::Npz, "it is no zip archive"),
            "dump" | "lammpstrj" | "liggghts" => (Self::LammpsDump, "it does not start with 'ITEM:'"),
            "lmp" | "lammps" => (Self::LammpsData, "no line such as '100 atoms' stands at its start"),
            "xyz" | "extxyz" => (Self::Xyz, "its first line is not the number of elements"),
            "data" => (
                Self::LammpsData,
                "neither a line such as '100 atoms' of LAMMPS stands at its start nor '100 0.5' and the limits of a box, as in MercuryDPM",
            ),
            _ => return None,
        })
    }
}

impl fmt::Display for PackingFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Text => "text",
            Self::Npy => "NumPy array",
            Self::Npz => "NumPy archive",
            Self::LammpsDump => "LAMMPS dump",
            Self::LammpsData => "LAMMPS data",
            Self::Xyz => "XYZ",
            Self::Mercury => "MercuryDPM data",
            Self::Vtk => "VTK",
            Self::VtkXml => "XML VTK",
        })
    }
}

impl FromStr for PackingFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|format| format.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("'{text}' is none of {names}")
        })
    }
}

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
            Some(MeshFormat::Vtk) if !mesh::vtk_points::is_mesh(bare) => Self::Packing(PackingFormat::Vtk),
            Some(MeshFormat::VtkXml) if !mesh::vtk_points::is_xml_mesh(bare) => {
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
    fn names_are_read_back() {
        for format in PackingFormat::ALL {
            assert_eq!(format.name().parse(), Ok(format));
        }
        assert!("stl".parse::<PackingFormat>().unwrap_err().contains("lammps-dump"));
    }

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
