//! The formats of files of elements, and their names.

use std::fmt;
use std::str::FromStr;

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
}
