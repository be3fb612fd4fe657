//! Bodies that are meshed, and their names.

use crate::shapes::piece::Piece;
use crate::text::fault;
use crate::text::file::ModelFile;

/// A meshed body, and its table in the model file.
#[derive(Debug)]
pub(crate) struct Placed<const D: usize = 2, const N: usize = 3> {
    pub(crate) name: String,
    /// Number of the table in the file.
    pub(crate) table: usize,
    pub(crate) piece: Piece<D, N>,
    /// The numbers of its first node and of its first element.
    pub(crate) first: [u32; 2],
}

/// The bodies that a name means: those of its table, or one piece of a packing, or one copy.
pub(crate) fn named<const D: usize, const N: usize>(
    placed: &[Placed<D, N>],
    file: &ModelFile,
    name: &str,
) -> Vec<usize> {
    let of_table =
        |body: &&(usize, &Placed<D, N>)| file.body[body.1.table].name == name || body.1.name == name;
    let all: Vec<(usize, &Placed<D, N>)> = placed.iter().enumerate().collect();
    all.iter().filter(of_table).map(|(number, _)| *number).collect()
}

/// Whether a name fits a pattern, in which `*` stands for any text, also none.
pub(crate) fn fits(pattern: &str, name: &str) -> bool {
    let Some((start, rest)) = pattern.split_once('*') else { return pattern == name };
    let Some(mut name) = name.strip_prefix(start) else { return false };
    let (middle, end) = rest.rsplit_once('*').unwrap_or(("", rest));
    for part in middle.split('*') {
        let Some(at) = name.find(part) else { return false };
        name = &name[at + part.len()..];
    }
    name.ends_with(end)
}

/// The bodies that a name means, or all whose name or table fits a pattern.
pub(crate) fn fitting<const D: usize, const N: usize>(
    placed: &[Placed<D, N>],
    file: &ModelFile,
    pattern: &str,
) -> Vec<usize> {
    if !pattern.contains('*') {
        return named(placed, file, pattern);
    }
    let fits_body =
        |body: &Placed<D, N>| fits(pattern, &file.body[body.table].name) || fits(pattern, &body.name);
    (0..placed.len()).filter(|&body| fits_body(&placed[body])).collect()
}

/// Whether a name or a pattern is that of a body, or may be that of a piece of a packing or a copy.
pub(crate) fn may_fit_body(file: &ModelFile, pattern: &str) -> bool {
    let of_pieces = |body: &str| {
        pattern.strip_prefix(body).is_some_and(|rest| rest.starts_with('-') && rest.contains('*'))
    };
    is_body(file, pattern) || file.body.iter().any(|body| fits(pattern, &body.name) || of_pieces(&body.name))
}

/// The body that was probably meant.
pub(crate) fn suggestion(file: &ModelFile, name: &str) -> String {
    let names: Vec<&str> = file.body.iter().map(|body| body.name.as_str()).collect();
    fault::suggestion(name, &names, "[[body]]")
}

/// Whether a name is the name of a body, or may be the name of a piece of a packing.
pub(crate) fn is_body(file: &ModelFile, name: &str) -> bool {
    file.body.iter().any(|body| body.name == name || is_piece(&body.name, name))
}

/// Whether a name is that of a piece of a packing, `heap-12`.
/// Whether a name is that of a piece of a packing, `heap-12`, or of a copy, `wall-1-2`.
pub(crate) fn is_piece(body: &str, name: &str) -> bool {
    name.strip_prefix(body).and_then(|rest| rest.strip_prefix('-')).is_some_and(|rest| {
        rest.split('-').count() <= 3 && rest.split('-').all(|part| part.parse::<u32>().is_ok())
    })
}

#[cfg(test)]
mod tests {
    use super::fits;

    #[test]
    fn patterns_fit_names() {
        for (pattern, name) in [
            ("poly*", "poly12"),
            ("poly*", "poly"),
            ("*", "a"),
            ("*-1", "heap-1"),
            ("a*c*e", "abcde"),
            ("a", "a"),
        ] {
            assert!(fits(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [
            ("poly*", "pol"),
            ("poly*", "a-poly1"),
            ("a*a", "a"),
            ("a*c*e", "aec"),
            ("a", "ab"),
            ("*-1", "heap-12"),
        ] {
            assert!(!fits(pattern, name), "{pattern} {name}");
        }
    }
}
