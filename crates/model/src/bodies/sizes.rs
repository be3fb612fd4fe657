//! Whether the mesh sizes of the bodies are possible, before anything is cut.

use crate::bodies::crowded::{Filled, crowd, crowded};
use crate::bodies::space;
use crate::shapes::extent::{Extent, extent};
use crate::shapes::limits::{MOST, too_many};
use crate::shapes::outline::Point;
use crate::shapes::{distant, of_body, refine, repeat};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, Problem};
use crate::text::file::{Body, ModelFile, Vector};

/// Number of elements of all bodies that are cut here, about. Refuses sizes that give too many, or more than
/// `memory` (bytes) has room for, and bodies that lie in each other so much that their contacts have no room.
pub(crate) fn check(
    file: &ModelFile,
    document: &Document<'_>,
    memory: Option<f64>,
    faults: &mut Vec<Fault>,
) -> f64 {
    let mut all = 0.0;
    let mut boxes = Vec::new();
    let mut tables = Vec::new();
    for (index, body) in file.body.iter().enumerate() {
        let Some(size) = body.mesh_size else { continue };
        let flat = extent(body);
        let mut refuse = |problem: Problem, label: &str| {
            let span = document.value(Table::of("body", index), &problem.key);
            faults.push(Fault::at(span, problem.message).label(label).maybe_help(problem.help));
        };
        let around = if flat.is_none() { space::bounds(body) } else { None };
        if let Some(problem) = too_far(body, flat.as_ref(), around) {
            refuse(problem, "too far away");
            continue;
        }
        let refined = match (&flat, around) {
            (Some(extent), _) => refine::elements(body, extent.bounds),
            (None, Some(bounds)) => refine::elements(body, bounds),
            (None, None) => Ok(0.0),
        };
        let refined = match refined {
            Ok(elements) => elements,
            Err(problem) => {
                refuse(problem, "too small");
                return all;
            }
        };
        let Some(elements) = flat.map(|extent| extent.elements(size)).or_else(|| space::elements(body, size))
        else {
            continue;
        };
        let copies = repeat::count(body);
        let [elements, refined] = [copies * (elements + refined), copies * refined];
        let before = all;
        all += elements;
        if let Some(message) = too_many(before, elements, size, memory) {
            if elements > MOST
                && let Some(problem) = refine::blamed(body, Some(elements - refined), Some(elements))
            {
                refuse(problem, "too small");
                return all;
            }
            if copies > 1.0 && elements / copies <= MOST {
                // Too many copies are reported already.
                if repeat::problem(body).is_none() {
                    let message = format!("[[body]] \"{}\", {copies} times: {message}", body.name);
                    let span = document.value(Table::of("body", index), "repeat");
                    let help = "repeat it fewer times, or take a larger mesh_size";
                    faults.push(Fault::at(span, message).label("many").help(help));
                }
                return all;
            }
            let span = document.value(Table::of("body", index), "mesh_size");
            let message = format!("[[body]] \"{}\": {message}", body.name);
            faults.push(Fault::at(span, message).label("too small").help("take a larger mesh_size"));
            return all;
        }
        if let Some(extent) = flat {
            let [low, high] = placed(extent.bounds, body);
            let spacing = [0, 1].map(|axis| high[axis] - low[axis]);
            for (_, by) in repeat::places(body, spacing) {
                let bounds = [low, high].map(|corner| [0, 1].map(|axis| corner[axis] + by[axis]));
                boxes.push(Filled { bounds, elements: elements / copies, size: [size; 2] });
                tables.push(index);
            }
        }
    }
    if let Some(([a, b], couples)) = crowded(&boxes) {
        let [a, b] = [tables[a.min(b)], tables[a.max(b)]];
        let [first, second] = [a, b].map(|index| &file.body[index].name);
        faults.push(crowd(document.value(Table::of("body", b), "name"), first, second, couples));
    }
    all
}

/// The problem of a body that is too far from the origin: where its shape puts it, or where `translate` moves
/// it.
fn too_far(body: &Body, flat: Option<&Extent>, around: Option<[[f64; 3]; 2]>) -> Option<Problem> {
    fn of<const D: usize>(body: &Body, bounds: [[f64; D]; 2]) -> Option<Problem> {
        let shape = of_body::given(body).first().copied()?;
        distant::problem(shape, &body.name, bounds).or_else(|| {
            distant::moved("translate", &body.name, bounds, body.translate.as_ref()?.components())
        })
    }
    match flat {
        Some(extent) => of(body, extent.bounds),
        None => of(body, around?),
    }
}

/// The bounding box of a body that is turned and moved.
fn placed([low, high]: [Point; 2], body: &Body) -> [Point; 2] {
    let (sine, cosine) = libm::sincos(body.angle.to_radians());
    let [x, y] = [0, 1].map(|axis| 0.5 * (high[axis] - low[axis]));
    let half = [x * cosine.abs() + y * sine.abs(), x * sine.abs() + y * cosine.abs()];
    let by = body.translate.as_ref().map_or([0.0; 2], Vector::components);
    let middle = [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]) + by[axis]);
    [-1.0, 1.0].map(|sign| [0, 1].map(|axis| middle[axis] + sign * half[axis]))
}
