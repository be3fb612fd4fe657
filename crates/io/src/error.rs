//! The errors of reading a packing.

use thiserror::Error;

use crate::columns::{MOST_COLUMNS, Role};
use crate::compression::Compression;
use crate::excerpt;
use crate::numbers;
use crate::options::TypeColumn;
use crate::packing_format::PackingFormat;
use crate::place::Place;

/// The reason why a file could not be read: the problem, its place, and the expected content.
///
/// The text contains neither the name of the file nor the number of the line. The caller that opened the file
/// prints `file:line: text`, with the line from [`ReadError::line`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file has no bytes.
    #[error("the file is empty: expected one element per row")]
    Empty,
    /// The file has only comments and blank lines.
    #[error("only comments and blank lines ({}): expected one element per row", excerpt::count(*lines, "line"))]
    NoRows {
        /// Number of lines.
        lines: u64,
    },
    /// The first bytes are those of another format.
    #[error("this is {format}, not a table of elements: {advice}")]
    Foreign {
        /// Name of the format.
        format: &'static str,
        /// Advice to the user.
        advice: &'static str,
    },
    /// The file contains bytes that are not text.
    #[error("not a text file: {found} at byte {offset}{advice}")]
    NotText {
        /// Line of the first such byte, counted from 1.
        line: u64,
        /// Offset of that byte in the file, counted from 0.
        offset: u64,
        /// Description of that byte.
        found: String,
        /// Advice to the user, after a colon; empty if there is none.
        advice: &'static str,
    },
    /// A row cannot be read.
    #[error("{problem}: {text}")]
    Malformed {
        /// Line, counted from 1.
        line: u64,
        /// The line, cut to about 80 characters, with control characters escaped.
        text: String,
        /// The problem.
        problem: String,
    },
    /// The first row has more columns than a table of elements can have.
    #[error("more than {MOST_COLUMNS} columns: expected one element per row, such as x, y, z, radius")]
    TooManyColumns {
        /// Line, counted from 1; `None` in an array.
        line: Option<u64>,
    },
    /// Bad lines may be skipped, but all lines are bad.
    #[error("{}: {problem}: {text}", all_bad(*count))]
    AllBad {
        /// Number of rows.
        count: u64,
        /// Line of the first row, counted from 1; `None` in an array.
        line: Option<u64>,
        /// The first row.
        text: String,
        /// The problem of the first row.
        problem: String,
    },
    /// The header has no column x, or no y.
    #[error(
        "no column for {role}; the columns are: {}. Say which it is with --columns{}",
        present.join(", "),
        if *title { "; or is this line a title? remove it or put # before it" } else { "" }
    )]
    MissingColumn {
        /// Line of the header, counted from 1; `None` in an array.
        line: Option<u64>,
        /// The missing role.
        role: Role,
        /// The columns of the file.
        present: Vec<String>,
        /// Whether no column at all has a role; then the line may be a title above the header.
        title: bool,
    },
    /// The chosen columns include one that the file does not have.
    #[error("no column '{wanted}'; the columns are: {}", present.join(", "))]
    UnknownColumn {
        /// Line of the header, or of the first row without one; `None` in an array.
        line: Option<u64>,
        /// The requested name or number.
        wanted: String,
        /// The columns of the file.
        present: Vec<String>,
    },
    /// The chosen columns include a name that fits several columns.
    #[error("'{wanted}' could be any of the columns {}: give its number", matches.join(", "))]
    AmbiguousColumn {
        /// Line of the header; `None` in an array.
        line: Option<u64>,
        /// The requested name.
        wanted: String,
        /// The columns it fits.
        matches: Vec<String>,
    },
    /// Two columns have the same role, or one is a radius and another a diameter.
    #[error("columns {first} ({first_role}) and {second} ({second_role}) clash: choose one with --columns")]
    ClashingColumns {
        /// Line of the header; `None` in an array.
        line: Option<u64>,
        /// Name of the first column.
        first: String,
        /// Role of the first column.
        first_role: Role,
        /// Name of the second column.
        second: String,
        /// Role of the second column.
        second_role: Role,
    },
    /// `--columns` gives one column two roles, under its name and its number or in two spellings.
    #[error("--columns makes column {column} both {first_role} and {second_role}: give one of them another")]
    TwoRoles {
        /// Line of the header, or of the first row without one; `None` in an array.
        line: Option<u64>,
        /// Name of the column.
        column: String,
        /// The role given first.
        first_role: Role,
        /// The role given second.
        second_role: Role,
    },
    /// The column of bodies already has another role.
    #[error(
        "--bodies {column}: this column is the {role} of the elements{}",
        if *role == Role::Id { ". If it is not, --ignore-ids leaves ids unread" } else { "" }
    )]
    BodiesColumn {
        /// Line of the header, or of the first row without one; `None` in an array.
        line: Option<u64>,
        /// Name of the column.
        column: String,
        /// The other role of the column.
        role: Role,
    },
    /// The column of types already has another role.
    #[error("the types cannot be those of column {column}: this column is the {role} of the elements")]
    TypesColumn {
        /// Line of the header, or of the first row without one; `None` in an array.
        line: Option<u64>,
        /// Name of the column.
        column: String,
        /// The other role of the column.
        role: Role,
    },
    /// No column has one of the usual names of types.
    #[error(
        "no column {} for the types of the elements; the columns are {}: --type-column NAME chooses one",
        TypeColumn::USUAL.join(", "),
        present.join(", ")
    )]
    NoTypes {
        /// Line of the header, or of the first row without one; `None` in an array.
        line: Option<u64>,
        /// The columns of the file.
        present: Vec<String>,
    },
    /// Two columns have different units.
    #[error("column {first} is in {first_unit}, column {second} in {second_unit}: convert to one unit first")]
    MixedUnits {
        /// Line of the header; `None` in an array.
        line: Option<u64>,
        /// Name of the first column.
        first: String,
        /// Unit of the first column.
        first_unit: String,
        /// Name of the second column.
        second: String,
        /// Unit of the second column.
        second_unit: String,
    },
    /// There is no header, and the number of columns does not determine their roles.
    #[error(
        "{} and no header (2 would be x y, 3 x y z, 4 x y z radius): {}. First row: {text}",
        excerpt::count(*found as u64, "column"),
        if *found < 2 {
            "expected x and y at least, separated by commas, semicolons, tabs or blanks"
        } else {
            "name them with --columns, for example --columns x,y,z,_,radius"
        }
    )]
    UnnamedColumns {
        /// Line of the first row, counted from 1; `None` in an array.
        line: Option<u64>,
        /// Number of columns.
        found: usize,
        /// The first row, or the shape of an array.
        text: String,
    },
    /// `--columns` lists more or fewer columns than the file has.
    #[error(
        "--columns lists {}, found {found}: use _ for columns to skip. First row: {text}",
        excerpt::count(*listed as u64, "column")
    )]
    ColumnCount {
        /// Line of the first row, counted from 1; `None` in an array.
        line: Option<u64>,
        /// Number of columns listed.
        listed: usize,
        /// Number of columns in the file.
        found: usize,
        /// The first row, or the shape of an array.
        text: String,
    },
    /// Two rows of a text file have the same id.
    #[error(
        "id {id} is on line {first} and again on line {second}: use row numbers instead with --ignore-ids"
    )]
    DuplicateId {
        /// The id.
        id: i64,
        /// Line where it occurs first.
        first: u64,
        /// Line where it occurs again.
        second: u64,
    },
    /// Two rows of an array have the same id.
    #[error("id {id} is in row {first} and again in row {second}: use row numbers instead with --ignore-ids")]
    DuplicateIdRow {
        /// The id.
        id: i64,
        /// Row where it occurs first, counted from 0.
        first: u64,
        /// Row where it occurs again, counted from 0.
        second: u64,
    },
    /// The header of a NumPy file cannot be read.
    #[error("NumPy header: {problem}")]
    NpyHeader {
        /// The problem.
        problem: String,
    },
    /// A NumPy array contains something other than numbers.
    #[error("{what} of shape {shape} is {dtype}: expected {wanted}")]
    NpyDtype {
        /// `the array`, or the name of the field.
        what: String,
        /// The dtype as written in the file.
        dtype: String,
        /// The shape as Python prints it.
        shape: String,
        /// The types that can be read there.
        wanted: &'static str,
    },
    /// A NumPy array does not have one row per element.
    #[error(
        "the array has shape {shape}, dtype {dtype}: expected (n, 2), (n, 3) or (n, 4) numbers, \
         or (n,) of a dtype with the fields x, y, z, radius"
    )]
    NpyShape {
        /// The shape as Python prints it.
        shape: String,
        /// The dtype as written in the file.
        dtype: String,
    },
    /// A NumPy file does not have the size that its header states.
    #[error(
        "the array should take {} (shape {shape}), found {found}: {}",
        excerpt::count(*expected, "byte"),
        if u128::from(*found) < *expected {
            "the file is cut off or damaged"
        } else {
            "the file continues after the array, perhaps with another one, or is damaged"
        }
    )]
    NpySize {
        /// Number of bytes according to shape and dtype.
        expected: u128,
        /// Number of bytes after the header.
        found: u64,
        /// The shape as Python prints it.
        shape: String,
    },
    /// There is no memory for the elements of the file.
    #[error("no memory for {elements} elements")]
    OutOfMemory {
        /// Number of rows.
        elements: usize,
    },
    /// There is no memory for the content of a compressed file.
    #[error("no memory for {bytes} bytes of decompressed content")]
    NoMemory {
        /// Lower bound on the number of bytes.
        bytes: u64,
    },
    /// The content of a compressed file exceeds a limit.
    #[error(
        "{compression}-compressed content of {} MB or more: the limit is {} MB",
        numbers::grouped(bytes.div_ceil(1_000_000)),
        numbers::grouped(limit / 1_000_000)
    )]
    TooLarge {
        /// The compression of the file.
        compression: Compression,
        /// Lower bound on the number of bytes, as the file states it or as far as it was decompressed.
        bytes: u64,
        /// Largest number of bytes that is accepted.
        limit: u64,
    },
    /// A compressed file cannot be unpacked.
    #[error(
        "{compression}-compressed data, damaged or cut off after {unpacked} decompressed bytes: {problem}"
    )]
    Packed {
        /// The compression of the file.
        compression: Compression,
        /// Number of bytes that were decompressed.
        unpacked: u64,
        /// The problem, in the words of the decoder.
        problem: String,
    },
    /// The content violates the format.
    #[error("{}{problem}", at_byte(*place))]
    Broken {
        /// The place.
        place: Place,
        /// The problem.
        problem: String,
    },
    /// One of several frames cannot be read.
    #[error("frame {frame} (counted from 0): {error}")]
    InFrame {
        /// The frame, counted from 0.
        frame: usize,
        /// The error of that frame.
        error: Box<ReadError>,
    },
    /// The requested frame does not exist.
    #[error("no frame {wanted}: the file has {}", frames_of(*frames))]
    NoFrame {
        /// The requested frame.
        wanted: usize,
        /// Number of frames.
        frames: usize,
    },
    /// The file has several frames, but one is expected.
    #[error("the file has {frames} frames, but one is expected")]
    SeveralFrames {
        /// Number of frames.
        frames: usize,
    },
    /// The name of the file promises a format that the content does not have, and no other format fits.
    #[error("the name stands for a {promised} file, but {expected}; read as a table: {error}")]
    NotPromised {
        /// The format that the name promises.
        promised: PackingFormat,
        /// Description of a file of that format.
        expected: &'static str,
        /// The reason why the file is not a table either.
        error: Box<ReadError>,
    },
    /// A row of an array cannot be read.
    #[error("{problem}: {text}")]
    BadRow {
        /// Row, counted from 0.
        row: u64,
        /// The values of the row.
        text: String,
        /// The problem, with the row and the column.
        problem: String,
    },
}

impl ReadError {
    /// The line that the error is about, counted from 1; `None` for the file as a whole and for arrays.
    pub fn line(&self) -> Option<u64> {
        match self {
            Self::NotText { line, .. }
            | Self::Malformed { line, .. }
            | Self::DuplicateId { second: line, .. }
            | Self::Broken { place: Place::Line(line), .. } => Some(*line),
            Self::InFrame { error, .. } | Self::NotPromised { error, .. } => error.line(),
            Self::AllBad { line, .. }
            | Self::TooManyColumns { line }
            | Self::MissingColumn { line, .. }
            | Self::UnknownColumn { line, .. }
            | Self::AmbiguousColumn { line, .. }
            | Self::ClashingColumns { line, .. }
            | Self::TwoRoles { line, .. }
            | Self::BodiesColumn { line, .. }
            | Self::TypesColumn { line, .. }
            | Self::NoTypes { line, .. }
            | Self::MixedUnits { line, .. }
            | Self::UnnamedColumns { line, .. }
            | Self::ColumnCount { line, .. } => *line,
            Self::Empty
            | Self::NoRows { .. }
            | Self::Foreign { .. }
            | Self::DuplicateIdRow { .. }
            | Self::NpyHeader { .. }
            | Self::NpyDtype { .. }
            | Self::NpyShape { .. }
            | Self::NpySize { .. }
            | Self::OutOfMemory { .. }
            | Self::NoMemory { .. }
            | Self::TooLarge { .. }
            | Self::Packed { .. }
            | Self::Broken { .. }
            | Self::NoFrame { .. }
            | Self::SeveralFrames { .. }
            | Self::BadRow { .. } => None,
        }
    }
}

/// Prefix for a place in bytes. Lines are printed before the message by the caller.
fn at_byte(place: Place) -> String {
    match place {
        Place::Byte(byte) => format!("at byte {byte}: "),
        Place::Line(_) | Place::File => String::new(),
    }
}

fn frames_of(frames: usize) -> String {
    match frames {
        1 => "1 frame, which is frame 0".into(),
        frames => format!("{frames} frames, counted from 0"),
    }
}

fn all_bad(count: u64) -> String {
    match count {
        1 => "none of the rows can be read; the only one".into(),
        count => format!("none of the {count} rows can be read; the first"),
    }
}
