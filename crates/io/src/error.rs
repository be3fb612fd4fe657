//! Everything that can be wrong with a file.

use thiserror::Error;

use crate::columns::Role;
use crate::excerpt;
use crate::kind::PackingFormat;
use crate::mesh::error::Place;
use crate::table::MOST_COLUMNS;
use crate::unpack::Compression;

/// Why a file could not be read: what is wrong, where, and what would be right.
///
/// The text carries neither the file's name nor the line's number: who opened the file prints
/// `file:line: text`, with the line from [`ReadError::line`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file has no bytes.
    #[error("the file is empty: expected one element per row")]
    Empty,
    /// The file has no line other than comments and blank lines.
    #[error("only comments and blank lines ({}): expected one element per row", excerpt::count(*lines, "line"))]
    NoRows {
        /// How many lines there are.
        lines: u64,
    },
    /// The first bytes are those of some other format.
    #[error("this is {format}, not a table of elements: {advice}")]
    Foreign {
        /// The format's name.
        format: &'static str,
        /// What to do about it.
        advice: &'static str,
    },
    /// The file holds bytes that no text holds.
    #[error("not a text file: {found} at byte {offset}{advice}")]
    NotText {
        /// Line of the first such byte, counted from 1.
        line: u64,
        /// Its offset in the file, counted from 0.
        offset: u64,
        /// What was found there.
        found: String,
        /// What to do about it, after a colon; empty where nothing helps.
        advice: &'static str,
    },
    /// A row cannot be read.
    #[error("{problem}: {text}")]
    Malformed {
        /// Line, counted from 1.
        line: u64,
        /// The line, cut to about 80 characters, control characters escaped.
        text: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The first row has more columns than any table of elements.
    #[error("more than {MOST_COLUMNS} columns: expected one element per row, such as x, y, z, radius")]
    TooManyColumns {
        /// Line, counted from 1; `None` in an array.
        line: Option<u64>,
    },
    /// Bad lines may be skipped, but there is no good one.
    #[error("{}: {problem}: {text}", all_bad(*count))]
    AllBad {
        /// How many rows there are.
        count: u64,
        /// Line of the first, counted from 1; `None` in an array.
        line: Option<u64>,
        /// The first row.
        text: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The header names no x, or no y.
    #[error(
        "no column for {role}; the columns are: {}. Say which it is with --columns{}",
        present.join(", "),
        if *title { "; or is this line a title? remove it or put # before it" } else { "" }
    )]
    MissingColumn {
        /// Line of the header, counted from 1; `None` in an array.
        line: Option<u64>,
        /// What is missing.
        role: Role,
        /// The columns that are there.
        present: Vec<String>,
        /// Whether no column at all has a role, so that the line may be a title above the header.
        title: bool,
    },
    /// The chosen columns name one that is not there.
    #[error("no column '{wanted}'; the columns are: {}", present.join(", "))]
    UnknownColumn {
        /// Line of the header, or of the first row without one; `None` in an array.
        line: Option<u64>,
        /// The name or number asked for.
        wanted: String,
        /// The columns that are there.
        present: Vec<String>,
    },
    /// The chosen columns name one that several columns could be.
    #[error("'{wanted}' could be any of the columns {}: give its number", matches.join(", "))]
    AmbiguousColumn {
        /// Line of the header; `None` in an array.
        line: Option<u64>,
        /// The name asked for.
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
        /// Its role.
        first_role: Role,
        /// Name of the second column.
        second: String,
        /// Its role.
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
    /// The column of bodies has a role already.
    #[error(
        "--bodies {column}: this column is the {role} of the elements{}",
        if *role == Role::Id { ". If it is not, --ignore-ids leaves ids unread" } else { "" }
    )]
    BodiesColumn {
        /// Line of the header, or of the first row without one; `None` in an array.
        line: Option<u64>,
        /// Name of the column.
        column: String,
        /// Its other role.
        role: Role,
    },
    /// Two columns are in different units.
    #[error("column {first} is in {first_unit}, column {second} in {second_unit}: convert to one unit first")]
    MixedUnits {
        /// Line of the header; `None` in an array.
        line: Option<u64>,
        /// Name of the first column.
        first: String,
        /// Its unit.
        first_unit: String,
        /// Name of the second column.
        second: String,
        /// Its unit.
        second_unit: String,
    },
    /// There is no header and the number of columns does not say what they are.
    #[error(
        "{} and no header (2 would be x y, 3 x y z, 4 x y z radius): {}. First row: {text}",
        excerpt::count(*found as u64, "column"),
        if *found < 2 {
            "expected x and y at least, separated by commas, semicolons, tabs or blanks"
        } else {
            "say what they are with --columns, for example --columns x,y,z,_,radius"
        }
    )]
    UnnamedColumns {
        /// Line of the first row, counted from 1; `None` in an array.
        line: Option<u64>,
        /// How many columns there are.
        found: usize,
        /// The first row; the shape of an array.
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
        /// Columns listed.
        listed: usize,
        /// Columns in the file.
        found: usize,
        /// The first row; the shape of an array.
        text: String,
    },
    /// Two rows of a text file have the same id.
    #[error(
        "id {id} is on line {first} and again on line {second}: use row numbers instead with --ignore-ids"
    )]
    DuplicateId {
        /// The id.
        id: i64,
        /// Line of its first row.
        first: u64,
        /// Line of its second row.
        second: u64,
    },
    /// Two rows of an array have the same id.
    #[error("id {id} is in row {first} and again in row {second}: use row numbers instead with --ignore-ids")]
    DuplicateIdRow {
        /// The id.
        id: i64,
        /// Its first row, counted from 0.
        first: u64,
        /// Its second row, counted from 0.
        second: u64,
    },
    /// The header of a NumPy file cannot be read.
    #[error("NumPy header: {problem}")]
    NpyHeader {
        /// What is wrong with it.
        problem: String,
    },
    /// A NumPy array holds something other than numbers.
    #[error("{what} of shape {shape} is {dtype}: expected {wanted}")]
    NpyDtype {
        /// `the array`, or the field.
        what: String,
        /// The dtype as the file spells it.
        dtype: String,
        /// The shape as Python prints it.
        shape: String,
        /// What can be read there.
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
        /// The dtype as the file spells it.
        dtype: String,
    },
    /// A NumPy file does not have the size its header claims.
    #[error(
        "the array should take {} (shape {shape}), found {found}: {}",
        excerpt::count(*expected, "byte"),
        if u128::from(*found) < *expected {
            "the file is cut off or damaged"
        } else {
            "the file goes on after the array, perhaps with another one, or is damaged"
        }
    )]
    NpySize {
        /// Bytes that shape and dtype ask for.
        expected: u128,
        /// Bytes after the header.
        found: u64,
        /// The shape as Python prints it.
        shape: String,
    },
    /// There is no memory for the elements of the file.
    #[error("no memory for {elements} elements")]
    OutOfMemory {
        /// How many rows there are.
        elements: usize,
    },
    /// There is no memory for the content of a compressed file.
    #[error("no memory for {bytes} bytes of unpacked content")]
    NoMemory {
        /// How many bytes, at least.
        bytes: u64,
    },
    /// A compressed file cannot be unpacked.
    #[error("{compression}-compressed data, damaged or cut off after {unpacked} unpacked bytes: {problem}")]
    Packed {
        /// How it is compressed.
        compression: Compression,
        /// Bytes that could be unpacked.
        unpacked: u64,
        /// What is wrong, in the words of the decoder.
        problem: String,
    },
    /// The content does not keep to the format.
    #[error("{}{problem}", at_byte(*place))]
    Broken {
        /// Where.
        place: Place,
        /// What is wrong.
        problem: String,
    },
    /// A frame of several cannot be read.
    #[error("frame {frame} (counted from 0): {error}")]
    InFrame {
        /// The frame, counted from 0.
        frame: usize,
        /// What is wrong with it.
        error: Box<ReadError>,
    },
    /// There is no such frame.
    #[error("no frame {wanted}: the file has {}", frames_of(*frames))]
    NoFrame {
        /// The frame asked for.
        wanted: usize,
        /// How many there are.
        frames: usize,
    },
    /// There are several frames where one is wanted.
    #[error("the file has {frames} frames: one is wanted")]
    SeveralFrames {
        /// How many there are.
        frames: usize,
    },
    /// The content is that of no format, though the name promises one.
    #[error("the name promises a {promised} file, but {expected}; and read as a table: {error}")]
    NotPromised {
        /// The format that goes by such names.
        promised: PackingFormat,
        /// What such a file looks like.
        expected: &'static str,
        /// Why it is no table either.
        error: Box<ReadError>,
    },
    /// A row of an array cannot be read.
    #[error("{problem}: {text}")]
    BadRow {
        /// Row, counted from 0.
        row: u64,
        /// The values of the row.
        text: String,
        /// What is wrong with them; names the row and the column.
        problem: String,
    },
}

impl ReadError {
    /// The line the error is about, counted from 1; `None` for the file as a whole and for arrays.
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
            | Self::Packed { .. }
            | Self::Broken { .. }
            | Self::NoFrame { .. }
            | Self::SeveralFrames { .. }
            | Self::BadRow { .. } => None,
        }
    }
}

/// Lines stand before the message, bytes in it.
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
