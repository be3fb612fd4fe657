//! The header of a NumPy file: magic bytes, version, length, and a Python dictionary as text.
//!
//! The parser takes time proportional to the header, whatever its bytes: it never goes back and limits the
//! nesting. The caller multiplies the shape with checked arithmetic.
//!
//! # Source
//! NumPy Enhancement Proposal 1, "A Simple File Format for NumPy Arrays", and `numpy.lib.format`,
//! versions 1.0 to 3.0.

use crate::excerpt;

/// A parsed header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) dtype: Dtype,
    /// The dtype as written in the file, without quotes; a long list is cut, and control characters are
    /// escaped.
    pub(crate) descr: String,
    pub(crate) fortran_order: bool,
    pub(crate) shape: Vec<u64>,
    /// Offset of the data.
    pub(crate) data: usize,
}

/// The type of one item of the array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Dtype {
    Plain(Scalar),
    Record(Vec<Field>),
}

/// A named part of an item.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) scalar: Scalar,
    /// The shape of a field that is itself an array; empty for most fields.
    pub(crate) shape: Vec<u64>,
}

/// A number, or an opaque type of known size.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Scalar {
    /// The letter of the dtype: `f`, `i`, `u`, …
    pub(crate) kind: char,
    /// Number of bytes.
    pub(crate) size: usize,
    pub(crate) big_endian: bool,
    /// The dtype as written in the file, such as `<f8`.
    pub(crate) descr: String,
}

impl Header {
    /// Parses the header of `bytes`, which is a whole file.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, String> {
        let cut = || "the file ends inside the header".to_owned();
        let version = bytes.get(6..8).ok_or_else(cut)?;
        let (length, start) = match version {
            [1, _] => {
                let length = bytes.get(8..10).ok_or_else(cut)?;
                (usize::from(u16::from_le_bytes([length[0], length[1]])), 10)
            }
            [2 | 3, _] => {
                let length = bytes.get(8..12).ok_or_else(cut)?;
                (u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize, 12)
            }
            _ => return Err(format!("version {}.{} is not 1.0, 2.0 or 3.0", version[0], version[1])),
        };
        let data = length.checked_add(start).ok_or_else(cut)?;
        let text = bytes.get(start..data).ok_or_else(cut)?;
        let text = match std::str::from_utf8(text) {
            Ok(text) => text.to_owned(),
            // Versions 1 and 2 are in Latin-1, whose bytes are the first 256 characters.
            Err(_) if version[0] < 3 => text.iter().copied().map(char::from).collect(),
            Err(_) => return Err("it is not UTF-8".into()),
        };
        let mut parser = Parser { text: &text, at: 0 };
        let entries = parser.dictionary()?;
        let entry = |key: &str| {
            let found = entries.iter().find(|(name, ..)| name == key);
            found.ok_or_else(|| format!("'{key}' is missing"))
        };
        let (_, descr, spelled) = entry("descr")?;
        let (_, Literal::Truth(fortran_order), _) = entry("fortran_order")? else {
            return Err("'fortran_order' is neither True nor False".into());
        };
        Ok(Self {
            dtype: dtype(descr)?,
            descr: excerpt::line(spelled.trim_matches(['\'', '"']).as_bytes()),
            fortran_order: *fortran_order,
            shape: shape(&entry("shape")?.1)?,
            data,
        })
    }

    /// The shape in Python notation.
    pub(crate) fn shown_shape(&self) -> String {
        match &self.shape[..] {
            [n] => format!("({n},)"),
            lengths => format!("({})", lengths.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
        }
    }
}

/// A header for an array in C order, padded so that the data start at a multiple of 64 bytes.
///
/// `descr` is the dtype in Python notation, including quotes and brackets.
pub(crate) fn header(descr: &str, shape: &str) -> Vec<u8> {
    /// Magic bytes, version, and length of the text.
    const PREFIX: usize = 10;
    /// The alignment of the data that NumPy itself uses.
    const ALIGNMENT: usize = 64;
    let mut text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}");
    let padded = (PREFIX + text.len() + 1).next_multiple_of(ALIGNMENT);
    text.extend(std::iter::repeat_n(' ', padded - PREFIX - text.len() - 1));
    text.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    // Our dtypes keep the text far below 64 KiB.
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

fn dtype(descr: &Literal) -> Result<Dtype, String> {
    let fields = match descr {
        Literal::Text(text) => return scalar(text).map(Dtype::Plain),
        Literal::Sequence(fields) => fields,
        _ => return Err("'descr' is neither text nor a list of fields".into()),
    };
    let field = |field: &Literal| -> Result<Field, String> {
        let Literal::Sequence(parts) = field else {
            return Err("a field of 'descr' is not a tuple".into());
        };
        let (name, kind, lengths) = match &parts[..] {
            [name, kind] => (name, kind, Vec::new()),
            [name, kind, lengths] => (name, kind, shape(lengths)?),
            _ => return Err("a field of 'descr' is not (name, dtype)".into()),
        };
        let name = match name {
            Literal::Text(name) => name,
            // A field with a title is ((title, name), dtype).
            Literal::Sequence(names) => match &names[..] {
                [_, Literal::Text(name)] => name,
                _ => return Err("a field of 'descr' has no name".into()),
            },
            _ => return Err("a field of 'descr' has no name".into()),
        };
        let Literal::Text(kind) = kind else {
            return Err(format!(
                "the field '{}' has fields of its own, which are not read",
                excerpt::field(name.as_bytes())
            ));
        };
        Ok(Field { name: name.clone(), scalar: scalar(kind)?, shape: lengths })
    };
    fields.iter().map(field).collect::<Result<_, _>>().map(Dtype::Record)
}

/// A dtype such as `<f8`, `|S10`, `<M8[ns]`.
fn scalar(descr: &str) -> Result<Scalar, String> {
    let bad = || format!("'{}' is not a dtype that is read", excerpt::field(descr.as_bytes()));
    let (order, rest) = match descr.chars().next().ok_or_else(bad)? {
        order @ ('<' | '>' | '|' | '=') => (order, &descr[1..]),
        _ => ('=', descr),
    };
    let kind = rest.chars().next().filter(char::is_ascii_alphabetic).ok_or_else(bad)?;
    if kind == 'O' {
        return Err(format!(
            "the dtype '{}' holds Python objects, which are not read",
            excerpt::field(descr.as_bytes())
        ));
    }
    let digits = &rest[1..];
    let digits = &digits[..digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len())];
    let size = digits.parse::<usize>().map_err(|_| bad())?;
    // The size of text is given in characters of 4 bytes.
    let size = if kind == 'U' { size.checked_mul(4) } else { Some(size) };
    let big_endian = order == '>' || (order == '=' && cfg!(target_endian = "big"));
    Ok(Scalar { kind, size: size.ok_or_else(bad)?, big_endian, descr: excerpt::field(descr.as_bytes()) })
}

fn shape(literal: &Literal) -> Result<Vec<u64>, String> {
    let length = |literal: &Literal| match literal {
        Literal::Whole(length) => Ok(*length),
        _ => Err("the shape holds something other than whole numbers".to_owned()),
    };
    match literal {
        Literal::Sequence(lengths) => lengths.iter().map(length).collect(),
        literal => length(literal).map(|length| vec![length]),
    }
}

/// The kinds of Python values that a header consists of.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Literal {
    Text(String),
    Whole(u64),
    Truth(bool),
    /// A list or a tuple.
    Sequence(Vec<Literal>),
}

/// Deepest nesting: list of fields, field, its shape or titled name, and one more.
const DEEPEST: usize = 4;

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn skip_blanks(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start().len();
    }

    /// Skips `symbol` and the blanks around it, if it comes next.
    fn takes(&mut self, symbol: char) -> bool {
        self.skip_blanks();
        let found = self.rest().starts_with(symbol);
        self.at += if found { symbol.len_utf8() } else { 0 };
        found
    }

    fn expect(&mut self, symbol: char) -> Result<(), String> {
        if self.takes(symbol) { Ok(()) } else { Err(format!("expected '{symbol}' at character {}", self.at)) }
    }

    /// All keys with their values, and the values as text.
    fn dictionary(&mut self) -> Result<Vec<(String, Literal, &'a str)>, String> {
        let mut entries = Vec::new();
        self.expect('{')?;
        while !self.takes('}') {
            let Literal::Text(key) = self.literal(0)? else {
                return Err(format!("the key before character {} is no text", self.at));
            };
            self.expect(':')?;
            self.skip_blanks();
            let start = self.at;
            let value = self.literal(0)?;
            entries.push((key, value, &self.text[start..self.at]));
            if !self.takes(',') {
                self.expect('}')?;
                break;
            }
        }
        Ok(entries)
    }

    fn literal(&mut self, depth: usize) -> Result<Literal, String> {
        self.skip_blanks();
        let rest = self.rest();
        for (word, truth) in [("True", true), ("False", false)] {
            if rest.starts_with(word) {
                self.at += word.len();
                return Ok(Literal::Truth(truth));
            }
        }
        match rest.chars().next() {
            Some(quote @ ('\'' | '"')) => self.quoted(quote),
            Some('0'..='9') => self.whole(),
            Some('(') => self.sequence('(', ')', depth),
            Some('[') => self.sequence('[', ']', depth),
            _ => {
                Err(format!("expected text, a whole number, True, False or a list at character {}", self.at))
            }
        }
    }

    fn quoted(&mut self, quote: char) -> Result<Literal, String> {
        let mut text = String::new();
        let mut characters = self.rest().char_indices().skip(1);
        while let Some((offset, c)) = characters.next() {
            match c {
                c if c == quote => {
                    self.at += offset + c.len_utf8();
                    return Ok(Literal::Text(text));
                }
                '\\' => text.extend(characters.next().map(|(_, escaped)| escaped)),
                c => text.push(c),
            }
        }
        Err(format!("the text from character {} on has no end", self.at))
    }

    fn whole(&mut self) -> Result<Literal, String> {
        let rest = self.rest();
        let digits = &rest[..rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len())];
        let number =
            digits.parse().map_err(|_| format!("a number at character {} exceeds 64 bits", self.at))?;
        self.at += digits.len();
        // Python 2 wrote long integers as 5L.
        self.takes('L');
        Ok(Literal::Whole(number))
    }

    fn sequence(&mut self, open: char, close: char, depth: usize) -> Result<Literal, String> {
        if depth == DEEPEST {
            return Err(format!("brackets are nested more than {DEEPEST} deep at character {}", self.at));
        }
        self.expect(open)?;
        let mut values = Vec::new();
        while !self.takes(close) {
            values.push(self.literal(depth + 1)?);
            if !self.takes(',') {
                self.expect(close)?;
                break;
            }
        }
        Ok(Literal::Sequence(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u8, text: &str) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY".to_vec();
        bytes.extend([version, 0]);
        match version {
            1 => bytes.extend((text.len() as u16).to_le_bytes()),
            _ => bytes.extend((text.len() as u32).to_le_bytes()),
        }
        bytes.extend(text.as_bytes());
        bytes
    }

    #[test]
    fn what_numpy_writes_is_read() {
        let text = "{'descr': '<f8', 'fortran_order': False, 'shape': (5, 3), }   \n";
        for version in [1, 2, 3] {
            let header = Header::parse(&file(version, text)).unwrap();
            assert_eq!(header.shape, [5, 3]);
            assert_eq!(header.descr, "<f8");
            assert_eq!(header.shown_shape(), "(5, 3)");
            assert!(!header.fortran_order);
            assert_eq!(header.data, file(version, text).len());
        }
        let text = r#"{"shape": (7L,), 'fortran_order': True, 'descr': [('it\'s', '>f4'), (('t', 'p'), '<U3', (3,)), ('', '|V4')]}"#;
        let header = Header::parse(&file(1, text)).unwrap();
        let Dtype::Record(fields) = &header.dtype else { panic!("not a record") };
        assert_eq!(fields[0].name, "it's");
        assert!(fields[0].scalar.big_endian);
        assert_eq!(
            (fields[1].name.as_str(), fields[1].scalar.size, &fields[1].shape[..]),
            ("p", 12, &[3][..])
        );
        assert_eq!((fields[2].scalar.kind, fields[2].scalar.size), ('V', 4));
        assert_eq!(header.shown_shape(), "(7,)");
        assert!(header.fortran_order);
    }

    #[test]
    fn what_is_written_is_read_and_aligned() {
        for shape in ["(0, 3)", "(123456789012, 4)", "(7,)"] {
            let bytes = header("[('i', '<i8'), ('j', '<i8')]", shape);
            assert_eq!(bytes.len() % 64, 0);
            assert_eq!(bytes.last(), Some(&b'\n'));
            assert_eq!(Header::parse(&bytes).unwrap().shown_shape(), shape);
        }
    }

    #[test]
    fn damage_is_named() {
        for (text, problem) in [
            ("", "expected '{'"),
            ("{'descr': '<f8', 'fortran_order': False, 'shape': (5, 3), ", "expected text"),
            ("{'descr': '<f8', 'fortran_order': False}", "'shape' is missing"),
            ("{'descr': '<f8', 'fortran_order': 0, 'shape': (5,)}", "neither True nor False"),
            ("{'descr': 'float', 'fortran_order': False, 'shape': (5,)}", "'float' is not a dtype"),
            ("{'descr': '|O', 'fortran_order': False, 'shape': (5,)}", "'|O' holds Python objects"),
            ("{'descr': '<f8', 'fortran_order': False, 'shape': (-5,)}", "expected text"),
            ("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999,)}", "exceeds 64 bits"),
            (
                "{'descr': [('a', [('b', '<f8')])], 'fortran_order': False, 'shape': (5,)}",
                "fields of its own",
            ),
            ("{'descr", "has no end"),
        ] {
            let error = Header::parse(&file(1, text)).unwrap_err();
            assert!(error.contains(problem), "{text}: {error}");
        }
        assert!(Header::parse(&file(4, "{}")).unwrap_err().contains("version 4.0"));
        assert!(Header::parse(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{}").unwrap_err().contains("ends inside"));
        assert!(Header::parse(b"\x93NUMPY").unwrap_err().contains("ends inside"));
    }

    #[test]
    fn deep_nesting_is_refused_at_once() {
        let error = Header::parse(&file(2, &("{'descr': ".to_owned() + &"[".repeat(1_000_000)))).unwrap_err();
        assert!(error.contains("nested"), "{error}");
    }
}
