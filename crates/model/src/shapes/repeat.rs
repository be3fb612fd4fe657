//! Bodies that are repeated in rows and columns.

use fdem_io::numbers::grouped;
use fdem_mesh::bounds;

use crate::shapes::limits;
use crate::shapes::piece::Piece;
use crate::text::fault::Problem;
use crate::text::file::{Body, Vector};

/// Most copies of a body.
const MOST: f64 = 1e6;

/// The error of the keys `repeat` and `spacing` of a body.
pub(crate) fn problem(body: &Body) -> Option<Problem> {
    if body.repeat.is_none() {
        let message = "\"spacing\" goes with \"repeat\"";
        return body.spacing.is_some().then(|| Problem::new("spacing", message));
    }
    if body.packing.is_some() {
        let message = "a packing cannot be repeated: it has \"count\" bodies, or those of its file";
        return Some(Problem::new("repeat", message));
    }
    let count = count(body);
    (count > MOST).then(|| {
        let [count, most] = [count, MOST].map(|number| grouped(number as u64));
        let message = format!("\"repeat\" asks for {count} bodies: at most {most} are possible");
        Problem::new("repeat", message)
    })
}

/// Number of the copies of a body; 1 if it is not repeated.
pub(crate) fn count(body: &Body) -> f64 {
    body.repeat.iter().flatten().map(|count| f64::from(*count)).product()
}

/// The suffix of the name of each copy, and its displacement. `size`: that of the bounding box of the body,
/// which is the spacing unless the body has one.
///
/// The last axis is the fastest in the plane and in space: copies come in the order of their names.
pub(crate) fn places<const D: usize>(body: &Body, size: [f64; D]) -> Vec<(String, [f64; D])> {
    let Some(repeat) = &body.repeat else { return vec![(String::new(), [0.0; D])] };
    let spacing = body.spacing.as_ref().map_or(size, Vector::components);
    let counts: [u32; D] = std::array::from_fn(|axis| repeat.get(axis).copied().unwrap_or(1));
    let mut places = vec![(String::new(), [0.0; D])];
    for axis in 0..D {
        let along = |(name, by): (String, [f64; D])| {
            (0..counts[axis]).map(move |number| {
                let mut by = by;
                by[axis] = f64::from(number) * spacing[axis];
                (format!("{name}-{}", number + 1), by)
            })
        };
        places = places.into_iter().flat_map(along).collect();
    }
    places
}

/// The copies of a meshed body, each with the suffix of its name. The first lies where the body does.
///
/// # Errors
/// More elements than a model can have.
pub(crate) fn copies<const D: usize, const N: usize>(
    body: &Body,
    piece: &Piece<D, N>,
) -> Result<Vec<(String, Piece<D, N>)>, Problem> {
    let elements = count(body) * piece.elements.len() as f64;
    if elements > limits::MOST {
        let [elements, most] = [elements, limits::MOST].map(|number| grouped(number as u64));
        let message = format!("the copies have {elements} elements: at most {most} are possible");
        return Err(Problem::new("repeat", message));
    }
    let [low, high] = bounds(piece.nodes.iter().copied());
    let size = std::array::from_fn(|axis| high[axis] - low[axis]);
    let moved = |by: [f64; D]| {
        let mut copy = piece.clone();
        for node in &mut copy.nodes {
            *node = std::array::from_fn(|axis| node[axis] + by[axis]);
        }
        copy
    };
    let copies = places(body, size).into_iter().enumerate().map(|(number, (name, by))| {
        let mut copy = moved(by);
        if number > 0 {
            // Notes on the file of a mesh are reported once.
            copy.notes.clear();
            copy.about_file.clear();
        }
        (name, copy)
    });
    Ok(copies.collect())
}
