//! Places near which the elements of a body are smaller.

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::{Grading, Place, Refinement};

use crate::shapes::limits::{MOST, per_cube};
use crate::shapes::piece::Piece;
use crate::text::fault::Problem;
use crate::text::file::{Body, Refine, Vector};

/// The size of the elements of a body. Its keys have been checked.
pub(crate) fn grading<const D: usize>(body: &Body) -> Grading<D> {
    Grading { size: body.mesh_size.unwrap_or(f64::MAX), near: body.refine.iter().map(refinement).collect() }
}

fn refinement<const D: usize>(of: &Refine) -> Refinement<D> {
    let place = if let Some(point) = &of.point {
        Place::Point(point.components())
    } else if let Some(line) = &of.line {
        Place::Line(line.iter().map(Vector::components).collect())
    } else {
        let limits = of.block.as_deref().unwrap_or_default();
        let corner =
            |first: usize| std::array::from_fn(|axis| limits.get(first + axis).copied().unwrap_or(0.0));
        Place::Box([corner(0), corner(D)])
    };
    Refinement { place, size: of.size, reach: of.reach }
}

/// The problems of the places near which a body has smaller elements.
pub(crate) fn problems(body: &Body, dimensions: u8) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (number, of) in (1..).zip(&body.refine) {
        let found = problem(of, usize::from(dimensions), body.mesh_size);
        problems.extend(found.map(|(message, help)| Problem {
            key: format!("refine.{}", number - 1),
            message: format!("[[body]] \"{}\": place {number} to refine: {message}", body.name),
            help: Some(help),
        }));
    }
    problems
}

/// The error of a place, and the remedy.
fn problem(of: &Refine, dimensions: usize, mesh_size: Option<f64>) -> Option<(String, String)> {
    let given = [of.point.is_some(), of.line.is_some(), of.block.is_some()];
    if given.iter().filter(|given| **given).count() != 1 {
        return Some((
            "it has to be exactly one of point, line and box".to_owned(),
            "write { point = …, size = … }, { line = …, size = … } or { box = …, size = … }".to_owned(),
        ));
    }
    let vectors = of.point.iter().chain(of.line.iter().flatten());
    for vector in vectors.map(|vector| &vector.0) {
        if vector.len() != dimensions {
            return Some((
                format!(
                    "a point has {} numbers, where a model in {dimensions} dimensions has {dimensions}",
                    vector.len()
                ),
                format!("write {}", if dimensions == 2 { "[x, y]" } else { "[x, y, z]" }),
            ));
        }
    }
    if let Some(limits) = &of.block {
        let form =
            if dimensions == 2 { "[xmin, ymin, xmax, ymax]" } else { "[xmin, ymin, zmin, xmax, ymax, zmax]" };
        if limits.len() != 2 * dimensions {
            let wanted = 2 * dimensions;
            return Some((
                format!(
                    "the box has {} numbers, where a model in {dimensions} dimensions has {wanted}",
                    limits.len()
                ),
                format!("write {form}"),
            ));
        }
        if (0..dimensions).any(|axis| limits[axis] > limits[axis + dimensions]) {
            return Some(("the box is inside out".to_owned(), format!("write {form}")));
        }
    }
    let size = mesh_size.filter(|size| of.size >= *size)?;
    Some((
        format!("its size of {} m is not below mesh_size = {} m", brief(of.size), brief(size)),
        "mesh_size is the largest size; near places it may be smaller".to_owned(),
    ))
}

/// The place to refine that is so far from all of a body that no element is smaller, as a problem. `pieces`
/// lie as their shapes say, before they are turned and moved.
pub(crate) fn beyond<const D: usize, const N: usize>(body: &Body, pieces: &[Piece<D, N>]) -> Option<Problem> {
    let size = body.mesh_size?;
    (1..).zip(&body.refine).find_map(|(number, of)| {
        let one = Grading { size, near: vec![refinement::<D>(of)] };
        let mut nodes = pieces.iter().flat_map(|piece| &piece.nodes);
        (!nodes.any(|&node| one.at(node) < size)).then(|| Problem {
            help: Some("places have the coordinates of the shape, before angle and translate".to_owned()),
            ..Problem::new(
                format!("refine.{}", number - 1),
                format!(
                    "[[body]] \"{}\": place {number} to refine changes nothing: it is too far from the body",
                    body.name
                ),
            )
        })
    })
}

/// The place to refine that gives too many elements in a body within `bounds`, as a problem; else how many
/// all of them give, about.
pub(crate) fn elements<const D: usize>(body: &Body, bounds: [[f64; D]; 2]) -> Result<f64, Problem> {
    let mut all = 0.0;
    for (number, of) in (1..).zip(&body.refine) {
        let elements = per_cube::<D>() * refinement::<D>(of).cubes(bounds);
        if elements.is_nan() || elements > MOST {
            return Err(Problem {
                help: Some("take a larger size, or a shorter reach".to_owned()),
                ..Problem::new(
                    format!("refine.{}.size", number - 1),
                    format!(
                        "[[body]] \"{}\": place {number} to refine: a size of {} m {}",
                        body.name,
                        brief(of.size),
                        gives(elements)
                    ),
                )
            });
        }
        all += elements;
    }
    Ok(all)
}

/// The reason why a size is refused that gives too many elements, or more than can be counted.
fn gives(elements: f64) -> String {
    if elements.is_finite() {
        format!("gives about {} elements; the most are {}", brief(elements), grouped(MOST as u64))
    } else {
        "is too small for this body".to_owned()
    }
}

/// The smallest size of the places to refine as a problem, if a body has too many elements because of it and
/// not of its mesh size. `even`: about how many elements the mesh size alone gives; `elements`: how many
/// there are; `None` where that is not known.
pub(crate) fn blamed(body: &Body, even: Option<f64>, elements: Option<f64>) -> Option<Problem> {
    let (place, of) = body.refine.iter().enumerate().min_by(|a, b| a.1.size.total_cmp(&b.1.size))?;
    // The mesh size alone gives more than half of the limit.
    if even.is_some_and(|even| even > 0.5 * MOST) {
        return None;
    }
    let what = gives(elements.unwrap_or(f64::INFINITY));
    Some(Problem {
        help: Some("take a larger size there".to_owned()),
        ..Problem::new(
            format!("refine.{place}.size"),
            format!(
                "[[body]] \"{}\": place {} to refine: a size of {} m {what}",
                body.name,
                place + 1,
                brief(of.size)
            ),
        )
    })
}
