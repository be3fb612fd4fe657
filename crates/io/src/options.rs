//! Options of reading a table of elements.

use crate::columns::Columns;

/// Options for reading a file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The roles of the columns; `None` derives them from the header, or from the number of columns.
    pub columns: Option<Columns>,
    /// Skips lines that cannot be read and lists them in [`Source::skipped`](crate::Source), instead of
    /// stopping at the first one. The elements keep the numbers of their rows in
    /// [`Packing::row_numbers`](crate::Packing::row_numbers).
    pub skip_bad_lines: bool,
    /// Ignores the id column, so that elements are numbered by row.
    pub ignore_ids: bool,
    /// The column that holds the body of each element, for [`Packing::bodies`](crate::Packing::bodies): its
    /// name in the header, or its number counted from 1. It has no other role. In a file without names, the
    /// other columns keep the roles that they would have without it.
    pub bodies: Option<String>,
    /// The column that holds the type of each element, for [`Packing::types`](crate::Packing::types); it has
    /// no other role. `None` reads no types.
    pub types: Option<TypeColumn>,
}

/// The column of types.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TypeColumn {
    /// The first of `element`, `species` and `type` that the file has, in any capitals.
    Usual,
    /// The column of this name in the header, or of this number counted from 1. In a file without names, the
    /// other columns keep the roles that they would have without it.
    Named(String),
}

impl TypeColumn {
    /// The names of [`TypeColumn::Usual`].
    pub(crate) const USUAL: [&str; 3] = ["element", "species", "type"];
}
