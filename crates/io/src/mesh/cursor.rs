//! Reads the bytes of a file in sequence: lines, words, numbers, binary values.

use memchr::memchr;

use crate::excerpt;
use crate::mesh::error::{Fault, MeshProblem, malformed};
use crate::place::Place;

/// Order of the bytes of a binary number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Endian {
    Little,
    Big,
}

/// Kind of a binary or textual number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberKind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl NumberKind {
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(crate) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// The first bytes as a number; 0 if there are too few, which callers rule out.
    fn bits(self, bytes: &[u8], endian: Endian) -> u64 {
        let mut wide = [0; 8];
        let size = self.size().min(bytes.len());
        for (to, from) in wide.iter_mut().zip(&bytes[..size]) {
            *to = *from;
        }
        if endian == Endian::Big {
            wide[..size].reverse();
        }
        u64::from_le_bytes(wide)
    }

    pub(crate) fn float(self, bytes: &[u8], endian: Endian) -> f64 {
        match self {
            Self::F32 => f64::from(f32::from_bits(self.bits(bytes, endian) as u32)),
            Self::F64 => f64::from_bits(self.bits(bytes, endian)),
            Self::U64 => self.bits(bytes, endian) as f64,
            _ => self.integer(bytes, endian).map_or(0.0, |value| value as f64),
        }
    }

    /// The integer; `None` for floats and for integers beyond 63 bits.
    pub(crate) fn integer(self, bytes: &[u8], endian: Endian) -> Option<i64> {
        let bits = self.bits(bytes, endian);
        Some(match self {
            Self::I8 => i64::from((bits as u8).cast_signed()),
            Self::I16 => i64::from((bits as u16).cast_signed()),
            Self::I32 => i64::from((bits as u32).cast_signed()),
            Self::I64 => bits.cast_signed(),
            Self::U8 | Self::U16 | Self::U32 | Self::U64 => i64::try_from(bits).ok()?,
            Self::F32 | Self::F64 => return None,
        })
    }
}

/// The bytes of a file and the position of reading.
#[derive(Debug, Clone)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    /// Whether binary data have been read; lines are then meaningless.
    binary: bool,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, line: 1, binary: false }
    }

    pub(crate) fn place(&self) -> Place {
        if self.binary { Place::Byte(self.at as u64) } else { Place::Line(self.line) }
    }

    pub(crate) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// Skips bytes and counts the lines in them.
    pub(crate) fn advance(&mut self, bytes: usize) {
        let end = self.bytes.len().min(self.at.saturating_add(bytes));
        if !self.binary {
            self.line += memchr::memchr_iter(b'\n', &self.bytes[self.at..end]).count() as u64;
        }
        self.at = end;
    }

    /// A fault at the current position.
    pub(crate) fn fault<T>(&self, problem: MeshProblem) -> Result<T, Fault> {
        Err((self.place(), problem))
    }

    pub(crate) fn bad<T>(&self, problem: impl Into<String>) -> Result<T, Fault> {
        self.fault(malformed(problem))
    }

    pub(crate) fn cut_off<T>(&self, expected: impl Into<String>) -> Result<T, Fault> {
        self.fault(MeshProblem::CutOff { expected: expected.into() })
    }

    /// The next line, trimmed, with its place; `None` at the end of the file.
    pub(crate) fn line(&mut self) -> Option<(Place, &'a [u8])> {
        if self.at == self.bytes.len() {
            return None;
        }
        let (place, rest) = (self.place(), self.rest());
        let length = memchr(b'\n', rest).unwrap_or(rest.len());
        self.advance(length + 1);
        Some((place, rest[..length].trim_ascii()))
    }

    /// The next line that is not blank.
    pub(crate) fn filled_line(&mut self) -> Option<(Place, &'a [u8])> {
        loop {
            let (place, line) = self.line()?;
            if !line.is_empty() {
                return Some((place, line));
            }
        }
    }

    /// The next word. The cursor moves behind it, and the current place is that of the word.
    pub(crate) fn word(&mut self, expected: &str) -> Result<&'a [u8], Fault> {
        let blanks = self.rest().iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        self.advance(blanks);
        let rest = self.rest();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return self.cut_off(expected);
        }
        self.at += length;
        Ok(&rest[..length])
    }

    /// The next word, without moving the cursor.
    pub(crate) fn peek(&self) -> Option<&'a [u8]> {
        self.clone().word("").ok()
    }

    pub(crate) fn word_integer(&mut self, what: &str) -> Result<i64, Fault> {
        let word = self.word(what)?;
        integer(word).map_err(|problem| (self.place(), problem_in(what, &problem)))
    }

    pub(crate) fn word_float(&mut self, what: &str) -> Result<f64, Fault> {
        let word = self.word(what)?;
        float(word).map_err(|problem| (self.place(), problem_in(what, &problem)))
    }

    /// A number of items of at least one byte each. It cannot exceed the number of bytes that are left, so it
    /// limits the memory.
    pub(crate) fn word_count(&mut self, what: &str) -> Result<usize, Fault> {
        let count = self.word_integer(what)?;
        self.checked_count(count, 1, what)
    }

    /// Checks that `count` items of at least `size` bytes each can follow.
    pub(crate) fn checked_count(&self, count: i64, size: usize, what: &str) -> Result<usize, Fault> {
        let Ok(fits) = usize::try_from(count) else {
            return self.bad(format!("{what}: {count} is negative"));
        };
        if fits.checked_mul(size).is_none_or(|bytes| bytes > self.rest().len()) {
            return self.cut_off(format!("{what}: {count}, with {} to come", bytes_left(self.rest().len())));
        }
        Ok(fits)
    }

    /// The next bytes, unchanged.
    pub(crate) fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8], Fault> {
        self.binary = true;
        let rest = self.rest();
        if count > rest.len() {
            return self.cut_off(format!("{count} bytes of {what}, with {} to come", bytes_left(rest.len())));
        }
        self.at += count;
        Ok(&rest[..count])
    }

    pub(crate) fn integer(&mut self, kind: NumberKind, endian: Endian, what: &str) -> Result<i64, Fault> {
        let bytes = self.take(kind.size(), what)?;
        match kind.integer(bytes, endian) {
            Some(value) => Ok(value),
            None => self.bad(format!("{what} is no whole number of 63 bits")),
        }
    }

    pub(crate) fn float(&mut self, kind: NumberKind, endian: Endian, what: &str) -> Result<f64, Fault> {
        Ok(kind.float(self.take(kind.size(), what)?, endian))
    }
}

fn bytes_left(count: usize) -> String {
    excerpt::count(count as u64, "byte")
}

fn problem_in(what: &str, problem: &str) -> MeshProblem {
    malformed(format!("{what}: {problem}"))
}

/// A whole number as text.
pub(crate) fn integer(word: &[u8]) -> Result<i64, String> {
    let number = str::from_utf8(word).ok().and_then(|text| text.parse().ok());
    number.ok_or_else(|| format!("expected a whole number, found '{}'", excerpt::field(word)))
}

/// A number as text. It may be infinite or NaN, which callers refuse for coordinates.
pub(crate) fn float(word: &[u8]) -> Result<f64, String> {
    fast_float2::parse(word).map_err(|_| format!("expected a number, found '{}'", excerpt::field(word)))
}

/// The words of a line.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// Text for a name: invalid UTF-8 is replaced, control characters are escaped, surrounding blanks are
/// removed, and the length is limited.
pub(crate) fn name(bytes: &[u8]) -> String {
    excerpt::line(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_know_their_line() {
        let mut cursor = Cursor::new(b"a\n\n b c\n");
        assert_eq!((cursor.word("").unwrap(), cursor.place()), (&b"a"[..], Place::Line(1)));
        assert_eq!((cursor.word("").unwrap(), cursor.place()), (&b"b"[..], Place::Line(3)));
        assert_eq!(cursor.line(), Some((Place::Line(3), &b"c"[..])));
        assert!(cursor.word("more").is_err());
        assert_eq!(cursor.line(), None);
    }

    #[test]
    fn binary_numbers_in_both_orders() {
        for (kind, bytes, expected) in [
            (NumberKind::I8, &[0xff][..], -1),
            (NumberKind::U8, &[0xff], 255),
            (NumberKind::I16, &[0xfe, 0xff], -2),
            (NumberKind::U32, &[1, 0, 0, 0x80], 0x8000_0001),
            (NumberKind::I64, &[0xff; 8], -1),
        ] {
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(kind.integer(bytes, Endian::Little), Some(expected));
            assert_eq!(kind.integer(&reversed, Endian::Big), Some(expected));
        }
        assert_eq!(NumberKind::U64.integer(&[0xff; 8], Endian::Little), None);
        assert_eq!(NumberKind::F32.float(&0.1_f32.to_be_bytes(), Endian::Big), f64::from(0.1_f32));
        assert_eq!(NumberKind::F64.float(&0.1_f64.to_le_bytes(), Endian::Little), 0.1);
    }

    #[test]
    fn counts_do_not_exceed_the_file() {
        let cursor = Cursor::new(b"1234");
        assert_eq!(cursor.checked_count(2, 2, "nodes"), Ok(2));
        assert!(cursor.checked_count(3, 2, "nodes").is_err());
        assert!(cursor.checked_count(i64::MAX, 50, "nodes").is_err());
        assert!(cursor.checked_count(-1, 1, "nodes").is_err());
    }
}
