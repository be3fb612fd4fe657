//! Formats that are recognised by their first bytes, but not read as tables.

use crate::error::ReadError;

/// The error for a file that starts like one of another format.
pub(crate) fn foreign(bytes: &[u8]) -> Option<ReadError> {
    recognised(bytes).map(|(format, advice)| ReadError::Foreign { format, advice })
}

/// Name of the other format that a file has, and advice.
pub(crate) fn recognised(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    let by_magic = FOREIGN.iter().find(|(magic, ..)| bytes.starts_with(magic));
    if let Some((_, format, advice)) = by_magic {
        return Some((format, advice));
    }
    let head = std::str::from_utf8(&bytes[..bytes.len().min(HEAD)]);
    let head =
        head.unwrap_or_else(|error| std::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or_default());
    let (_, format, advice) = TEXTS.iter().find(|(is, ..)| is(head))?;
    Some((format, advice))
}

/// Number of bytes at the start of a text that show its format.
const HEAD: usize = 4096;

/// Whether the start of a text is that of a format.
type IsFormat = fn(&str) -> bool;

/// Texts of other programs: how they are recognised, name, advice.
const TEXTS: [(IsFormat, &str, &str); 8] = [
    (is_off, "a mesh in the Object File Format (OFF)", AS_MESH),
    (is_gts, "a surface of GTS", "convert it to STL, for example with 'gts2stl'"),
    (is_medit, "a mesh of MEDIT", AS_MESH),
    (is_poscar, "a POSCAR file of VASP", AS_XYZ),
    (|text| has_line(text, |line| line.starts_with("_cell_length_a")), "a CIF file", AS_XYZ),
    (is_pdb, "a PDB file", AS_XYZ),
    (
        |text| has_line(text, |line| line == "FoamFile"),
        "a field of OpenFOAM",
        "write its positions as a table with columns x, y, z and radius",
    ),
    (
        |text| text.starts_with("---") && text.contains("creator: LAMMPS"),
        "a dump of LAMMPS in YAML",
        "write it with 'dump custom', or convert it to extended XYZ",
    ),
];

fn has_line(text: &str, is: impl Fn(&str) -> bool) -> bool {
    text.lines().any(|line| is(line.trim()))
}

/// The lines of a text without comments, which `#` starts, and without blank lines.
fn significant(text: &str) -> impl Iterator<Item = &str> + Clone {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or(line).trim());
    lines.filter(|line| !line.is_empty())
}

fn are_counts<'t>(mut words: impl Iterator<Item = &'t str>) -> bool {
    (0..3).all(|_| words.next().is_some_and(|word| word.parse::<u64>().is_ok()))
}

/// The word `OFF`, with letters before it for texture, colours and normals, and three counts.
///
/// # Source
/// Geomview, "OFF: object file format".
fn is_off(text: &str) -> bool {
    let mut words = significant(text).flat_map(str::split_whitespace);
    let kind = words.next().and_then(|word| word.strip_suffix("OFF"));
    let is_kind = kind.is_some_and(|letters| letters.chars().all(|letter| "STCN4n".contains(letter)));
    is_kind && (words.clone().next() == Some("BINARY") || are_counts(words))
}

/// Three counts and the names of the classes of the GNU Triangulated Surface Library.
///
/// # Source
/// GTS reference manual, `gts_surface_write`.
fn is_gts(text: &str) -> bool {
    let comment = |line: &&str| !line.starts_with('!');
    let first = significant(text).find(comment).unwrap_or_default();
    are_counts(first.split_whitespace()) && first.contains("GtsSurface")
}

/// The keyword with which these files begin.
///
/// # Source
/// P. J. Frey, "MEDIT: an interactive mesh visualization software", INRIA RT-0253 (2001).
fn is_medit(text: &str) -> bool {
    let first = significant(text).next().unwrap_or_default();
    first.split_whitespace().next() == Some("MeshVersionFormatted")
}

/// A title, a scale, and three edges of three numbers.
///
/// # Source
/// VASP wiki, "POSCAR".
fn is_poscar(text: &str) -> bool {
    let numbers = |line: &str| -> Option<usize> {
        line.split_whitespace()
            .map(|word| word.parse::<f64>().ok())
            .collect::<Option<Vec<_>>>()
            .map(|all| all.len())
    };
    let mut lines = text.lines().skip(1);
    let scale = lines.next().and_then(numbers);
    let edges = [lines.next(), lines.next(), lines.next()].map(|line| line.and_then(numbers));
    let kinds = lines.next().map(|line| line.split_whitespace().next().is_some() && numbers(line) != Some(3));
    matches!(scale, Some(1 | 3)) && edges == [Some(3); 3] && kinds == Some(true)
}

/// Records of six letters in fixed columns.
///
/// # Source
/// wwPDB, "Atomic Coordinate Entry Format Version 3.3".
fn is_pdb(text: &str) -> bool {
    const FIRST: [&str; 7] = ["CRYST1", "HEADER", "TITLE ", "COMPND", "REMARK", "ATOM  ", "HETATM"];
    FIRST.iter().any(|record| text.starts_with(record))
        && text.lines().any(|line| line.starts_with("ATOM  ") || line.starts_with("HETATM"))
}

/// The byte order mark that some programs write before text in UTF-8.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

const UNPACK: &str = "unpack it first";
const AS_UTF_8: &str = "save it as UTF-8";
const AS_TABLE: &str = "export the elements as a CSV table with columns x, y, z and radius";

const AS_MESH: &str = "convert it to STL, OBJ or VTK, for example with 'meshio convert'";

const AS_XYZ: &str = "convert it to extended XYZ, for example with 'ase convert'";

/// Other formats that users pass by mistake: first bytes, name, advice. The first match counts.
pub(crate) const FOREIGN: [(&[u8], &str, &str); 16] = [
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
    (b"\x89HDF", "an HDF5 file (perhaps H5MD)", AS_TABLE),
    (b"\xdf\x65\xdf\x65\xdf\x65\xdf\x65", "a GSD file", "convert it to extended XYZ, for example with OVITO"),
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
