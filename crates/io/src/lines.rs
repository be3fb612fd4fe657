//! The lines of a text.

use crate::row::content;

/// The start of a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Start {
    pub(crate) byte: usize,
    /// Number of lines before it.
    pub(crate) lines: u64,
}

/// The lines of a text with their numbers, counted from 1.
#[derive(Debug, Clone)]
pub(crate) struct Lines<'a> {
    bytes: &'a [u8],
    pub(crate) at: usize,
    pub(crate) number: u64,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, number: 0 }
    }

    /// The lines from the start of a frame up to the end of `bytes`, with their numbers in the whole file.
    pub(crate) fn of_frame(bytes: &'a [u8], start: Start) -> Self {
        Self { bytes, at: start.byte, number: start.lines }
    }

    /// The start of a frame that begins here.
    pub(crate) fn start(&self) -> Start {
        Start { byte: self.at, lines: self.number }
    }

    /// Whether anything other than blank lines follows.
    pub(crate) fn more(&self) -> bool {
        !self.rest().trim_ascii_start().is_empty()
    }

    /// Skips `lines` lines; returns false if there are fewer.
    pub(crate) fn pass(&mut self, lines: u64) -> bool {
        (0..lines).all(|_| self.next().is_some())
    }

    /// The next line that is not blank, trimmed.
    pub(crate) fn next_filled(&mut self) -> Option<(u64, &'a [u8])> {
        self.by_ref().map(|(number, line)| (number, line.trim_ascii())).find(|(_, line)| !line.is_empty())
    }

    pub(crate) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The next line that is neither blank nor a comment, without its comment.
    pub(crate) fn next_content(&mut self) -> Option<(u64, &'a [u8])> {
        self.by_ref().map(|(number, line)| (number, content(line))).find(|(_, line)| !line.is_empty())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u64, &'a [u8]);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let end = memchr::memchr(b'\n', rest);
        let line = &rest[..end.unwrap_or(rest.len())];
        self.at += end.map_or(rest.len(), |end| end + 1);
        self.number += 1;
        Some((self.number, line))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_count_from_one_and_the_last_needs_no_newline() {
        let mut lines = Lines::new(b"a\n\nb");
        assert_eq!(lines.next(), Some((1, b"a".as_slice())));
        assert_eq!(lines.next(), Some((2, b"".as_slice())));
        assert_eq!(lines.next(), Some((3, b"b".as_slice())));
        assert_eq!(lines.next(), None);
        assert_eq!(Lines::new(b"a\n").count(), 1);
    }
}
