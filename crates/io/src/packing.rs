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
    /// How the file was understood.
    pub source: Source,
}

/// How a file was understood: what a person needs to see that the right columns were read.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Text with its delimiter, or NumPy array with its dtype.
    pub format: Format,
    /// Every column of the file in its order; those without a role were ignored.
    pub columns: Vec<Column>,
    /// The length unit written in the names of the columns, such as `mm` in `PosX[mm]`.
    pub unit: Option<String>,
    /// Lines of a text file, comments and blank lines included; rows of an array.
    pub lines: u64,
    /// The lines left out, when asked for with [`ReadOptions::skip_bad_lines`](crate::ReadOptions).
    pub skipped: Skipped,
}

/// Kind of a file, told from its content.
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
}

impl Format {
    /// What a place in such a file is called, for messages: `line` or `lines` of text, `row` or `rows` of an
    /// array. Lines are counted from 1, rows from 0; see [`BadLine::line`].
    pub fn noun(&self, count: u64) -> &'static str {
        match (self, count) {
            (Self::Text { .. }, 1) => "line",
            (Self::Text { .. }, _) => "lines",
            (Self::Npy { .. }, 1) => "row",
            (Self::Npy { .. }, _) => "rows",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text { delimiter } => write!(f, "{delimiter}-separated text"),
            Self::Npy { dtype } => write!(f, "NumPy array of {dtype}"),
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
