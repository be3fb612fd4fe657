//! The elements of a file, and how the file was read.

use std::fmt;

use crate::columns::{Name, Role};
use crate::types::Types;

/// Centres of the elements, in 2D or 3D.
///
/// # Shapes
/// `n` centres `[f64; 2]` or `[f64; 3]`, in the order of the rows of the file.
///
/// # Units
/// The length unit of the file; see [`Source::unit`].
#[derive(Debug, Clone, PartialEq)]
pub enum Centres {
    /// The file has columns x and y only.
    Two(Vec<[f64; 2]>),
    /// The file has columns x, y and z.
    Three(Vec<[f64; 3]>),
}

impl Centres {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Self::Two(centres) => centres.len(),
            Self::Three(centres) => centres.len(),
        }
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The dimension: 2 or 3.
    pub fn dimensions(&self) -> usize {
        match self {
            Self::Two(_) => 2,
            Self::Three(_) => 3,
        }
    }
}

/// The elements of one file.
///
/// # Shapes
/// `centres`: `n`. `radii`, `ids`, `bodies`, `types` and `row_numbers`: `n` each if present, in the same
/// order.
///
/// # Units
/// `centres` and `radii` have the length unit of the file; nothing is converted.
#[derive(Debug, Clone, PartialEq)]
pub struct Packing {
    /// Centres; every coordinate is finite.
    pub centres: Centres,
    /// Radii, finite and not negative; values of a diameter column are halved. `None` without such a column.
    pub radii: Option<Vec<f64>>,
    /// Ids of the file, all different. `None` without an id column or if ids are ignored.
    pub ids: Option<Vec<i64>>,
    /// The body that each element belongs to, any numbers; `None` unless
    /// [`ReadOptions::bodies`](crate::ReadOptions) requests them.
    pub bodies: Option<Vec<i64>>,
    /// The type of each element; `None` unless [`ReadOptions::types`](crate::ReadOptions) requests them.
    pub types: Option<Types>,
    /// The row number of each element, increasing; `None` unless rows were skipped, because otherwise element
    /// `i` is row `i`.
    ///
    /// Rows are counted from 0. Skipped rows count; the header, comments and blank lines do not. Therefore an
    /// element without id keeps its number in the whole file.
    pub row_numbers: Option<Vec<u64>>,
    /// The box in the file, periodic or not; `None` if the file has none.
    pub cell: Option<SimulationBox>,
    /// The frame of the file that was read.
    pub frame: Frame,
    /// Format of the file, and the meaning of its columns.
    pub source: Source,
}

/// The box of a file, with edges of any lengths and directions.
///
/// # Shapes
/// Three edges of three components; in 2D the first two edges and components count.
///
/// # Units
/// The length unit of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationBox {
    /// The corner where the edges start.
    pub origin: [f64; 3],
    /// The edges; the edge along an axis without extent is 0.
    pub edges: [[f64; 3]; 3],
    /// Whether the box is periodic along each edge; false if the file does not say so.
    pub repeats: [bool; 3],
}

impl SimulationBox {
    /// A box with edges along the axes.
    pub(crate) fn orthogonal(low: [f64; 3], high: [f64; 3], repeats: [bool; 3]) -> Self {
        let edge = |axis: usize| {
            let mut edge = [0.0; 3];
            edge[axis] = high[axis] - low[axis];
            edge
        };
        Self { origin: low, edges: [edge(0), edge(1), edge(2)], repeats }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.origin.iter().chain(self.edges.as_flattened()).all(|value| value.is_finite())
    }
}

/// A frame of a file: the elements at one time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Frame {
    /// Its index among the frames of the file, counted from 0; 0 if there is only one.
    pub index: usize,
    /// The number of the time step, if the file has it.
    pub step: Option<i64>,
    /// The time in the unit of the file, if the file has it.
    pub time: Option<f64>,
}

/// How a file was interpreted, so that a person can see that the right columns were read.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The format.
    pub format: Format,
    /// All columns of the file in order; columns without a role were ignored.
    pub columns: Vec<Column>,
    /// The length unit in the names of the columns, such as `mm` in `PosX[mm]`.
    pub unit: Option<String>,
    /// Number of lines of a text file, including comments and blank lines (of this frame, if there are
    /// several), or of rows of an array.
    pub lines: u64,
    /// The lines that were skipped; see [`ReadOptions::skip_bad_lines`](crate::ReadOptions).
    pub skipped: Skipped,
}

impl Source {
    /// A remark for a person if the elements are in the plane, but a column without a role may be the third
    /// axis by its name, such as `zz` or `z1`.
    ///
    /// Columns such as `vz` beside `vx` belong to another vector.
    pub fn unused_axis(&self) -> Option<String> {
        let has_z = self.columns.iter().any(|column| column.role == Some(Role::Z));
        let plain = |column: &Column| Name::unsuffixed(&column.name).plain;
        let unused = || self.columns.iter().filter(|column| column.role.is_none());
        let is_axis = |column: &&Column| {
            let name = plain(column);
            let rest = name.replace("pos", "").replace("coord", "").replace("cent", "");
            let other = name.replace('z', "x");
            (name.starts_with('z') || name.ends_with('z'))
                && rest.chars().filter(|c| *c != 'z').count() <= 2
                && !unused().any(|column| plain(column) == other)
        };
        let column = unused().find(is_axis).filter(|_| !has_z)?;
        Some(format!("column {} is not used: is it z? If so, say --columns x=NAME,y=NAME,z={0}", column.name))
    }
}

/// Format of a file, with details found in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Format {
    /// Rows of text.
    Text {
        /// The separator of the fields of a row.
        delimiter: Delimiter,
    },
    /// A NumPy array as `numpy.save` writes it.
    Npy {
        /// The dtype as written in the file, such as `<f8`; a long one is cut.
        dtype: String,
    },
    /// A NumPy archive as `numpy.savez` writes it.
    Npz,
    /// A dump of LAMMPS or LIGGGHTS.
    LammpsDump,
    /// A data file of LAMMPS or LIGGGHTS.
    LammpsData {
        /// The atom style given in the file.
        style: Option<String>,
    },
    /// XYZ.
    Xyz {
        /// Whether the comment describes the columns.
        extended: bool,
    },
    /// A `.data` file of MercuryDPM.
    Mercury,
    /// Points of a legacy VTK file.
    Vtk,
    /// Points of a VTU or VTP file.
    VtkXml,
}

impl Format {
    /// The word for places in such a file, for messages: `line` or `lines` of text, `row` or `rows` of an
    /// array. Lines are counted from 1, rows from 0; see [`BadLine::line`].
    pub fn noun(&self, count: u64) -> &'static str {
        match (self.has_lines(), count) {
            (true, 1) => "line",
            (true, _) => "lines",
            (false, 1) => "row",
            (false, _) => "rows",
        }
    }

    /// Whether places in such a file are lines of text rather than rows of arrays.
    pub fn has_lines(&self) -> bool {
        !matches!(self, Self::Npy { .. } | Self::Npz | Self::Vtk | Self::VtkXml)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text { delimiter } => write!(f, "{delimiter}-separated text"),
            Self::Npy { dtype } => write!(f, "NumPy array of {dtype}"),
            Self::Npz => f.write_str("NumPy archive"),
            Self::LammpsDump => f.write_str("LAMMPS dump"),
            Self::LammpsData { style: None } => f.write_str("LAMMPS data"),
            Self::LammpsData { style: Some(style) } => write!(f, "LAMMPS data, atom style {style}"),
            Self::Xyz { extended: false } => f.write_str("XYZ"),
            Self::Xyz { extended: true } => f.write_str("extended XYZ"),
            Self::Mercury => f.write_str("MercuryDPM data"),
            Self::Vtk => f.write_str("VTK points"),
            Self::VtkXml => f.write_str("XML VTK points"),
        }
    }
}

/// The separator of the fields of a row of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// A run of blanks, tabs, or both.
    Blank,
    /// One tab; blanks around a field are ignored. Chosen only if it makes header and rows agree and nothing
    /// else does.
    Tab,
    /// A comma; blanks around a field are ignored.
    Comma,
    /// A semicolon; blanks around a field are ignored.
    Semicolon,
}

impl fmt::Display for Delimiter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Blank => "blank",
            Self::Tab => "tab",
            Self::Comma => "comma",
            Self::Semicolon => "semicolon",
        })
    }
}

/// One column of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The role of the column; `None` if it was ignored.
    pub role: Option<Role>,
    /// Its name in the header, cut to 40 characters, with control characters escaped; `column 1`, `column 2`,
    /// … without a header.
    pub name: String,
}

impl Column {
    /// The columns of a file, named by its header or by their numbers.
    pub(crate) fn all(names: &[Name], roles: &[Option<Role>], header: bool) -> Vec<Self> {
        let name = |place: usize| if header { names[place].shown() } else { format!("column {}", place + 1) };
        roles.iter().enumerate().map(|(place, role)| Self { role: *role, name: name(place) }).collect()
    }
}

/// The lines of a file that were skipped.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Skipped {
    /// Number of lines skipped.
    pub count: u64,
    /// The first of them, at most [`Skipped::KEPT`].
    pub first: Vec<BadLine>,
}

impl Skipped {
    /// Number of bad lines kept for display, about a screenful.
    pub const KEPT: usize = 20;

    pub(crate) fn push(&mut self, bad: BadLine) {
        self.count += 1;
        if self.first.len() < Self::KEPT {
            self.first.push(bad);
        }
    }
}

/// A line that could not be read, and the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadLine {
    /// Line counted from 1; in an array, row counted from 0 as in NumPy. [`Format::noun`] returns the word.
    pub line: u64,
    /// The line, cut to about 80 characters, with control characters escaped; in an array, the values of the
    /// row.
    pub text: String,
    /// The problem, with the name of the column; in an array, also with the number of the row.
    pub problem: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_first_bad_lines_are_kept_but_all_are_counted() {
        let mut skipped = Skipped::default();
        for line in 1..=50 {
            skipped.push(BadLine { line, text: String::new(), problem: String::new() });
        }
        assert_eq!(skipped.count, 50);
        assert_eq!(skipped.first.len(), Skipped::KEPT);
        assert_eq!(skipped.first.last().map(|bad| bad.line), Some(20));
    }
}
