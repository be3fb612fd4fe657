//! XYZ, and extended XYZ with columns and box in the comment.

use std::sync::atomic::AtomicU64;

use crate::columns::{MOST_COLUMNS, Name, Role};
use crate::error::ReadError;
use crate::excerpt;
use crate::lines::Lines;
use crate::mesh::cursor::words;
use crate::options::ReadOptions;
use crate::packing::{Format, Frame, Packing, SimulationBox};
use crate::series::rows::{RowTable, at_end, broken, expect, number, whole};

/// Whether the content is such a file; no table starts with a line of a single integer.
pub(crate) fn is(bytes: &[u8]) -> bool {
    /// Number of bytes that contain any integer.
    const HEAD: usize = 64;
    Lines::new(&bytes[..bytes.len().min(HEAD)])
        .next_filled()
        .is_some_and(|(_, line)| whole::<usize>(line).is_some())
}

/// Skips a frame; returns false if it is damaged or followed by anything other than another frame.
pub(crate) fn pass(lines: &mut Lines<'_>) -> bool {
    let count: Option<u64> = lines.next_filled().and_then(|(_, line)| whole(line));
    let passed = count.is_some_and(|count| lines.next().is_some() && lines.pass(count));
    passed && lines.clone().next_filled().is_none_or(|(_, line)| whole::<usize>(line).is_some())
}

pub(crate) fn read(
    mut lines: Lines<'_>,
    options: &ReadOptions,
    progress: &AtomicU64,
) -> Result<Packing, ReadError> {
    let before = lines.number;
    let (line, text) = expect(&mut lines, "the number of elements")?;
    let Some(count) = whole::<usize>(text) else {
        return broken(line, format!("expected the number of elements, found '{}'", excerpt::field(text)));
    };
    let Some((line, comment)) = lines.next() else {
        return broken(line, "the file ends here: expected a comment, which may be blank");
    };
    let comment = Comment::parse(line, comment);
    let properties = comment.value("properties");
    let first = lines.clone().next().map_or(&b""[..], |(_, row)| row);
    let names = match properties {
        Some(properties) => names(line, properties)?,
        None => plain_names(words(first).take(MOST_COLUMNS + 1).count()),
    };
    let (at, shown) = match properties {
        Some(properties) => (line, properties.as_bytes()),
        None => (line + 1, first),
    };
    let table = RowTable::new(&names, at, shown, options)?;
    let elements = table.read(&mut lines, count, options, progress)?;
    at_end(&mut lines, count, "the number of elements of the next frame or the end of the file")?;
    let frame = Frame {
        index: 0,
        step: ["step", "timestep"].iter().find_map(|key| whole(comment.value(key)?.as_bytes())),
        time: comment.value("time").and_then(|time| time.parse().ok()).filter(|time: &f64| time.is_finite()),
    };
    let format = Format::Xyz { extended: properties.is_some() };
    Ok(table.packing(elements, format, lines.number - before, comment.cell()?, frame))
}

/// A name, then x y z, then any other columns. If there are fewer columns, they are named in the same way, so
/// that the message says which one is missing.
fn plain_names(found: usize) -> Vec<Name> {
    let usual = ["element", "x", "y", "z"];
    // Columns of a plain file have no names; those after z are unknown.
    let name = |place: usize| match usual.get(place) {
        Some(name) => Name::unsuffixed(name),
        None => Name::unsuffixed(&(place + 1).to_string()),
    };
    (0..found.max(usual.len())).map(name).collect()
}

/// The columns in `Properties=`: `name:type:count`, repeated.
fn names(line: u64, properties: &str) -> Result<Vec<Name>, ReadError> {
    let parts: Vec<&str> = properties.split(':').collect();
    let (triples, rest) = parts.as_chunks::<3>();
    let shown = || excerpt::line(properties.as_bytes());
    if !rest.is_empty() {
        return broken(
            line,
            format!("Properties should be name:type:count, one after the other: {}", shown()),
        );
    }
    let mut names = Vec::new();
    for &[label, kind, count] in triples {
        let known = matches!(kind, "S" | "R" | "I" | "L");
        let Some(count) =
            whole::<usize>(count.as_bytes()).filter(|count| known && (1..=MOST_COLUMNS).contains(count))
        else {
            let label = excerpt::field(label.as_bytes());
            return broken(
                line,
                format!("property '{label}' is not name:type:count with S, R, I or L: {}", shown()),
            );
        };
        if names.len() + count > MOST_COLUMNS {
            return Err(ReadError::TooManyColumns { line: Some(line) });
        }
        let is_position = matches!(label.to_ascii_lowercase().as_str(), "pos" | "positions" | "position");
        for place in 0..count {
            let mut name = match count {
                1 => Name::unsuffixed(label),
                _ => Name::unsuffixed(&format!("{label}:{place}")),
            };
            if is_position && (2..=3).contains(&count) {
                ["x", "y", "z"][place].clone_into(&mut name.plain);
            } else if count > 1
                || !matches!(kind, "R" | "I")
                || matches!(name.role(), Some(Role::X | Role::Y | Role::Z))
            {
                // The property is not a number, or is part of another vector.
                name.plain = format!("property {}", name.written);
            }
            names.push(name);
        }
    }
    Ok(names)
}

/// The second line of a frame.
struct Comment {
    line: u64,
    /// Keys in lower case, with their values.
    pairs: Vec<(String, String)>,
}

impl Comment {
    /// Parses `key=value` pairs separated by blanks; values with blanks are in quotes or brackets. Other
    /// words are comments.
    fn parse(line: u64, text: &[u8]) -> Self {
        let text = String::from_utf8_lossy(text);
        let mut rest = text.trim();
        let mut pairs = Vec::new();
        while let Some(at) = rest.find(|c: char| c == '=' || c.is_whitespace()) {
            let (key, after) = rest.split_at(at);
            let Some(value) = after.strip_prefix('=') else {
                rest = after.trim_start();
                continue;
            };
            let close = match value.chars().next() {
                Some(quote @ ('"' | '\'')) => Some(quote),
                Some('{') => Some('}'),
                Some('[') => Some(']'),
                _ => None,
            };
            let (value, after) = match close {
                Some(close) => {
                    let inside = &value[1..];
                    let end = end_of_value(inside, close);
                    (&inside[..end], inside.get(end + 1..).unwrap_or(""))
                }
                None => value.split_at(value.find(char::is_whitespace).unwrap_or(value.len())),
            };
            pairs.push((key.trim_matches('"').to_ascii_lowercase(), value.to_owned()));
            rest = after.trim_start();
        }
        Self { line, pairs }
    }

    fn value(&self, key: &str) -> Option<&str> {
        self.pairs.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }

    /// The box of `Lattice`, with `Origin` and `pbc`.
    fn cell(&self) -> Result<Option<SimulationBox>, ReadError> {
        let Some(lattice) = self.value("lattice") else { return Ok(None) };
        let edges = self.numbers::<9>(lattice, "Lattice should be nine numbers, three for each edge")?;
        let edges = [0, 1, 2].map(|edge| [0, 1, 2].map(|axis| edges[3 * edge + axis]));
        let origin = match self.value("origin") {
            Some(origin) => self.numbers(origin, "Origin should be three numbers")?,
            None => [0.0; 3],
        };
        let repeats = match self.value("pbc") {
            Some(flags) => self.flags(flags)?,
            None => [true; 3],
        };
        Ok(Some(SimulationBox { origin, edges, repeats }))
    }

    fn numbers<const N: usize>(&self, text: &str, what: &str) -> Result<[f64; N], ReadError> {
        let fields: Vec<&str> = fields(text).collect();
        if fields.len() != N {
            return broken(self.line, format!("{what}, found '{}'", excerpt::line(text.as_bytes())));
        }
        let mut numbers = [0.0; N];
        for (number_, field) in numbers.iter_mut().zip(fields) {
            *number_ = number(self.line, field.as_bytes(), what)?;
        }
        Ok(numbers)
    }

    fn flags(&self, text: &str) -> Result<[bool; 3], ReadError> {
        let flag = |field: &str| match field.to_ascii_lowercase().as_str() {
            "t" | "true" | "1" => Some(true),
            "f" | "false" | "0" => Some(false),
            _ => None,
        };
        let found: Option<Vec<bool>> = fields(text).map(flag).collect();
        match found.as_deref() {
            Some(&[x, y, z]) => Ok([x, y, z]),
            _ => broken(
                self.line,
                format!("pbc should be three of T and F, found '{}'", excerpt::field(text.as_bytes())),
            ),
        }
    }
}

/// The place of the character that closes a value; brackets may be nested, as in `[[1, 0], [0, 1]]`.
fn end_of_value(inside: &str, close: char) -> usize {
    let opens = match close {
        ']' => Some('['),
        '}' => Some('{'),
        _ => None,
    };
    let mut depth = 0_usize;
    let end = inside.char_indices().find(|&(_, c)| {
        if Some(c) == opens {
            depth += 1;
        } else if c == close {
            if depth == 0 {
                return true;
            }
            depth -= 1;
        }
        false
    });
    end.map_or(inside.len(), |(at, _)| at)
}

/// Values separated by blanks or commas, with or without brackets.
fn fields(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']')).filter(|field| !field.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_taken_apart() {
        let comment = Comment::parse(
            2,
            b"a Lattice=\"1 0 0 0 2 0 0 0 3\" note='x y' pbc=[T, F, T] Time=0.5 b {c d} e=",
        );
        assert_eq!(comment.value("note"), Some("x y"));
        assert_eq!(comment.value("time"), Some("0.5"));
        assert_eq!(comment.value("e"), Some(""));
        assert_eq!(comment.value("a"), None);
        let nested = Comment::parse(2, b"Lattice=[[6, 0, 0], [0, 7, 0], [0, 0, 8]] pbc=[T, T, F]");
        let cell = nested.cell().unwrap().unwrap();
        assert_eq!(cell.edges, [[6.0, 0.0, 0.0], [0.0, 7.0, 0.0], [0.0, 0.0, 8.0]]);
        assert_eq!(cell.repeats, [true, true, false]);
        let cell = comment.cell().unwrap().unwrap();
        assert_eq!(cell.edges, [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]);
        assert_eq!(cell.repeats, [true, false, true]);
        assert!(Comment::parse(2, b"lattice=\"1 2").cell().is_err());
        assert!(Comment::parse(2, b"").pairs.is_empty());
    }

    #[test]
    fn properties_are_columns() {
        let found = names(2, "species:S:1:pos:R:3:Diameter:R:1:center:R:3:id:I:1").unwrap();
        let roles: Vec<_> = found.iter().map(Name::role).collect();
        let [x, y, z] = [Role::X, Role::Y, Role::Z].map(Some);
        assert_eq!(roles, [None, x, y, z, Some(Role::Diameter), None, None, None, Some(Role::Id)]);
        for bad in ["", "pos:R", "pos:R:x", "pos:Q:3", "pos:R:0", "pos:R:99999", "a:R:9999:b:R:9999"] {
            assert!(names(2, bad).is_err(), "{bad}");
        }
    }
}
