//! Places in files, for messages.

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Line of text, counted from 1.
    Line(u64),
    /// Offset in bytes, counted from 0, in a file or a part of a file that is not text.
    Byte(u64),
    /// The file as a whole.
    File,
}
