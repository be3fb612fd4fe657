//! What a file of elements holds, and how it was read.

use std::fmt;

use crate::columns::{Name, Role};

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

    /// Whether there is no element at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// 2 or 3.
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
/// `centres`: `n`. `radii`, `ids`, `bodies` and `row_numbers`: `n` each where present, in the same order.
///
/// # Units
/// `centres` and `radii` share one length unit, the file's own; nothing is converted.
#[derive(Debug, Clone, PartialEq)]
pub struct Packing {
    /// Centres; every coordinate is finite.
    pub centres: Centres,
    /// Radii, finite and not negative. A diameter column is halved. `None` without such a column.
    pub radii: Option<Vec<f64>>,
    /// Ids from the file, no two alike. `None` without an id column or when ids are ignored.
    pub ids: Option<Vec<i64>>,
    /// The body that each element is a part of, any numbers; `None` unless [`ReadOptions::bodies`](crate::ReadOptions) asks for them.
    pub bodies: Option<Vec<i64>>,
    /// The number of the row that each element stands on, increasing; `None` unless rows were skipped, for
    /// then element `i` is row `i`.
    ///
    /// Rows are counted from 0. Skipped rows count; the header, comments and blank lines do not. So an element
    /// without id keeps the number it has in the whole file.
    pub row_numbers: Option<Vec<u64>>,
    /// The box that the file gives its elements, whether it repeats or not; `None` where the file has none.
    pub cell: Option<SimulationBox>,
    /// Which frame of the file this is.
    pub frame: Frame,
    /// How the file was understood.
    pub source: Source,
}

/// A box as a file has it, with edges of any lengths and directions.
///
/// # Shapes
/// Three edges of three components; in 2D the first two of each count.
///
/// # Units
/// The length unit of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationBox {
    /// The corner where the edges start.
    pub origin: [f64; 3],
    /// The edges, one after the other; that of an axis without extent is 0.
    pub edges: [[f64; 3]; 3],
    /// Along which of them the box repeats; false where the file does not say so.
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
    /// Its place among the frames of the file, counted from 0; 0 where there is only one.
    pub index: usize,
    /// The number of the time step, where the file has one.
    pub step: Option<i64>,
    /// The time, in the unit of the file, where the file has one.
    pub time: Option<f64>,
}

/// How a file was understood: what a person needs to see that the right columns were read.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The format.
    pub format: Format,
    /// Every column of the file in its order; those without a role were ignored.
    pub columns: Vec<Column>,
    /// The length unit written in the names of the columns, such as `mm` in `PosX[mm]`.
    pub unit: Option<String>,
    /// Lines of a text file, comments and blank lines included, of several frames those of this one; rows of an array.
    pub lines: u64,
    /// The lines left out, when asked for with [`ReadOptions::skip_bad_lines`](crate::ReadOptions).
    pub skipped: Skipped,
}

/// Kind of a file, with what was found in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Format {
    /// Rows of text.
    Text {
        /// What separates the fields of a row.
        delimiter: Delimiter,
    },
    /// A NumPy array as `numpy.save` writes it.
    Npy {
        /// The dtype as the file spells it, such as `<f8`; a long one is cut.
        dtype: String,
    },
    /// A NumPy archive as `numpy.savez` writes it.
    Npz,
    /// A dump of LAMMPS or LIGGGHTS.
    LammpsDump,
    /// A data file of LAMMPS or LIGGGHTS.
    LammpsData {
        /// The atom style that the file tells.
        style: Option<String>,
    },
    /// XYZ.
    Xyz {
        /// Whether the comment says what the columns are.
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
    /// What a place in such a file is called, for messages: `line` or `lines` of text, `row` or `rows` of an
    /// array. Lines are counted from 1, rows from 0; see [`BadLine::line`].
    pub fn noun(&self, count: u64) -> &'static str {
        match (self.has_lines(), count) {
            (true, 1) => "line",
            (true, _) => "lines",
            (false, 1) => "row",
            (false, _) => "rows",
        }
    }

    /// Whether places in such a file are lines of text, not rows of arrays.
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

/// What separates the fields of a row of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// A run of blanks, tabs, or both.
    Blank,
    /// One tab; blanks around a field do not count. Chosen when only it makes header and rows agree.
    Tab,
    /// A comma; blanks around a field do not count.
    Comma,
    /// A semicolon; blanks around a field do not count.
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
    /// What the column was read as; `None` when it was ignored.
    pub role: Option<Role>,
    /// Its name as the header spells it, cut to 40 characters and with control characters escaped;
    /// `column 1`, `column 2`, … where there is no header.
    pub name: String,
}

impl Column {
    /// The columns of a file, named by its header or else by their numbers.
    pub(crate) fn all(names: &[Name], roles: &[Option<Role>], header: bool) -> Vec<Self> {
        let name = |place: usize| if header { names[place].shown() } else { format!("column {}", place + 1) };
        roles.iter().enumerate().map(|(place, role)| Self { role: *role, name: name(place) }).collect()
    }
}

/// The lines left out of a packing.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Skipped {
    /// How many lines were left out.
    pub count: u64,
    /// The first [`Skipped::KEPT`] of them.
    pub first: Vec<BadLine>,
}

impl Skipped {
    /// How many bad lines are kept to be shown: a screenful; more only costs memory.
    pub const KEPT: usize = 20;

    pub(crate) fn push(&mut self, bad: BadLine) {
        self.count += 1;
        if self.first.len() < Self::KEPT {
            self.first.push(bad);
        }
    }
}

/// A line that could not be read, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadLine {
    /// Line counted from 1; in an array, row counted from 0 as in NumPy. [`Format::noun`] tells which.
    pub line: u64,
    /// The line, cut to about 80 characters, control characters escaped; in an array, the row's values.
    pub text: String,
    /// What is wrong with it, with the column's name; in an array, with the row's number as well.
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
