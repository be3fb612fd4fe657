//! Excerpts of a file, made safe for a message.

/// Longest line shown in a message, in characters: about one line of a terminal.
const LINE: usize = 80;
/// Longest field shown in a message, in characters: enough for any number.
const FIELD: usize = 40;

/// A line for a message: cut, with control characters escaped.
pub(crate) fn line(bytes: &[u8]) -> String {
    shorten(bytes, LINE)
}

/// A field for a message: cut shorter than a line.
pub(crate) fn field(bytes: &[u8]) -> String {
    shorten(bytes, FIELD)
}

/// `1 row`, `2 rows`.
pub(crate) fn count(number: impl Into<u128>, noun: &str) -> String {
    let number = number.into();
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

fn shorten(bytes: &[u8], limit: usize) -> String {
    let bytes = bytes.trim_ascii();
    // A character has at most 4 bytes, so this prefix contains `limit` characters of a line of any length.
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * limit + 4)]);
    let mut shown = String::new();
    for (taken, c) in text.chars().enumerate() {
        if taken == limit {
            shown.push('…');
            break;
        }
        match c {
            '\t' => shown.push_str("\\t"),
            c if c.is_control() => shown.extend(c.escape_default()),
            c => shown.push(c),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_singular() {
        assert_eq!([0_u64, 1, 2].map(|n| count(n, "row")), ["0 rows", "1 row", "2 rows"]);
    }

    #[test]
    fn controls_are_escaped_and_length_is_bounded() {
        assert_eq!(line(b"1\t2\x1b[31m\r"), "1\\t2\\u{1b}[31m");
        assert_eq!(line("é".repeat(200).as_bytes()).chars().count(), LINE + 1);
        assert_eq!(line(&[0xff; 3]), "\u{fffd}\u{fffd}\u{fffd}");
        assert_eq!(field(&[b'7'; 40]), "7".repeat(40), "exactly the limit is not cut");
    }
}
