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
