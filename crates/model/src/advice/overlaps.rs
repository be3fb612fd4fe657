//! Bodies, and parts of the mesh of a body, that overlap at the beginning.

use std::collections::BTreeMap;

use fdem_contact::discretised::{self, MeshView};
use fdem_contact::narrow::Measure;
use fdem_io::numbers::{brief, grouped};
use fdem_mesh::Corners;
use fdem_simulation::{InitialOverlap, Model};

use crate::advice::parts;
use crate::advice::quasi_static;
use crate::advice::ready::Ready;
use crate::advice::warnings::place;
use crate::bodies::dimensions::Dimensions;
use crate::stages::resolve::lifetime;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;

/// Share of the size of the smaller element up to which an overlap of two is the rounding of a common face.
const LEAST: f64 = 1e-4;

/// Overlap of two bodies, or of parts of one.
struct Overlap {
    /// Sum over all couples of elements, m² or m³.
    common: f64,
    /// Number of these couples.
    couples: u64,
    /// The two elements that overlap most, and their overlap.
    elements: [u32; 2],
    largest: f64,
}

/// Warns of overlaps at the beginning, or refuses them where the model asks for that.
pub(crate) fn check<const D: usize, const N: usize>(
    ready: &Ready<'_, D, N>,
    document: &Document<'_>,
    warnings: &mut Vec<String>,
    faults: &mut Vec<Fault>,
) where
    [[f64; D]; N]: Dimensions<D, N> + discretised::MeshElement<D>,
{
    let contact = &ready.model.contact;
    if contact.overlap_time.is_some() && contact.initial_overlap != InitialOverlap::Relax {
        let span = document.value(Table::one("contact"), "overlap_time");
        faults.push(
            Fault::at(span, "only an initial overlap that relaxes takes a time")
                .label("has no effect")
                .help("add `initial_overlap = \"relax\"`, or take this key out"),
        );
    }
    let pairs = overlaps(ready);
    let (inside, between): (Vec<_>, Vec<_>) = pairs.iter().partition(|([a, b], _)| a == b);
    let effect = match contact.initial_overlap {
        InitialOverlap::Push | InitialOverlap::Error => {
            "they will be driven apart at once; [contact] initial_overlap = \"ignore\" or \"relax\" prevents that"
        }
        InitialOverlap::Ignore => {
            "this overlap gives no force, as [contact] has initial_overlap = \"ignore\""
        }
        InitialOverlap::Relax => {
            "they will be pressed apart slowly, as [contact] has initial_overlap = \"relax\""
        }
    };
    let file = ready.file;
    let when = |pair: &[u32; 2]| {
        let first = pair.map(|body| lifetime(file, &ready.bodies[body as usize].name).start);
        match first[0].max(first[1]) {
            0 => "at the beginning".to_owned(),
            stage => format!("at the beginning of stage \"{}\"", file.stage[stage].name),
        }
    };
    let unit = if D == 2 { "m²" } else { "m³" };
    let name = |body: u32| &ready.bodies[body as usize].name;
    let extent = |overlap: &Overlap| {
        let couples = match overlap.couples {
            1 => "1 couple of elements".to_owned(),
            count => format!("{} couples of elements", grouped(count)),
        };
        let [one, other] = overlap.elements;
        let at = place(&ready.model.mesh.centroid(one as usize));
        format!(
            "in {couples}, most of all elements {one} and {other} near {at} by {} {unit}",
            brief(overlap.largest)
        )
    };
    let mut found = Vec::new();
    for (pair, overlap) in inside {
        found.push(format!(
            "[[body]] \"{}\": parts of its mesh that share no nodes overlap by {} {unit} {}, {}",
            name(pair[0]),
            brief(overlap.common),
            when(pair),
            extent(overlap)
        ));
    }
    let most = between.iter().max_by(|a, b| a.1.common.total_cmp(&b.1.common).then(b.0.cmp(a.0)));
    if let Some((pair, overlap)) = most {
        let more = match between.len() {
            1 => String::new(),
            count => {
                let couples = between.iter().map(|(_, overlap)| overlap.couples).sum();
                format!(
                    " ({count} pairs of bodies do, in {} couples of elements, these most)",
                    grouped(couples)
                )
            }
        };
        found.push(format!(
            "\"{}\" and \"{}\" overlap by {} {unit} {}{more}, {}",
            name(pair[0]),
            name(pair[1]),
            brief(overlap.common),
            when(pair),
            extent(overlap)
        ));
    }
    if contact.initial_overlap == InitialOverlap::Error {
        let span = document.value(Table::one("contact"), "initial_overlap");
        let help = "move the bodies apart, or take \"ignore\" or \"relax\"";
        let fault = |message| Fault::at(span.clone(), message).label("refused by this").help(help);
        faults.extend(found.into_iter().map(fault));
    } else {
        warnings.extend(found.into_iter().map(|found| format!("{found}: {effect}")));
    }
}

/// Warns of an overlap that relaxes within the time in which a wave passes through the model, so that it
/// drives bodies apart as a blow does. `step`: time step, s.
pub(crate) fn relaxes_at_once<const D: usize, const N: usize>(
    model: &Model<D, N>,
    step: f64,
) -> Option<String> {
    if model.contact.initial_overlap != InitialOverlap::Relax {
        return None;
    }
    let time = model.contact.relaxing_time(step);
    let passage = quasi_static::passage(model);
    let given = if model.contact.overlap_time.is_some() { "" } else { ", by default," };
    (time < passage).then(|| {
        format!(
            "[contact] overlap_time is{given} {} s, and a wave takes {} s through the model: the overlap will drive the bodies apart as a blow does; an overlap_time of {} s or more presses them apart slowly",
            brief(time),
            brief(passage),
            brief(3.0 * passage)
        )
    })
}

/// The overlap of each pair of bodies that exist together; of a body with itself, that of its parts.
fn overlaps<const D: usize, const N: usize>(ready: &Ready<'_, D, N>) -> BTreeMap<[u32; 2], Overlap>
where
    [[f64; D]; N]: Dimensions<D, N> + discretised::MeshElement<D>,
{
    let mut pairs = BTreeMap::new();
    let mesh = &ready.model.mesh;
    let parts = parts_of(ready);
    if parts.iter().all(|part| *part == 0) {
        return pairs;
    }
    let found =
        MeshView::new(&mesh.nodes, &mesh.elements, &parts).and_then(|mesh| discretised::contacts(&mesh));
    // A model whose contacts cannot be detected cannot run; its preflight reports that.
    let Ok(found) = found else { return pairs };
    let size =
        |element: u32| mesh.elements[element as usize].map(|node| mesh.nodes[node as usize]).measure().abs();
    for contact in found {
        // Where tetrahedra touch in a face, the area of that is no overlap.
        let common = match contact.contact.measure {
            Measure::Area(area) if D == 2 => area,
            Measure::Volume(volume) => volume,
            _ => continue,
        };
        let elements = [contact.i, contact.j];
        if common > LEAST * size(contact.i).min(size(contact.j)) {
            let pair = elements.map(|element| mesh.bodies[element as usize]);
            let none = Overlap { common: 0.0, couples: 0, elements, largest: 0.0 };
            let of_pair = pairs.entry(pair).or_insert(none);
            of_pair.common += common;
            of_pair.couples += 1;
            if common > of_pair.largest {
                (of_pair.elements, of_pair.largest) = (elements, common);
            }
        }
    }
    if !ready.file.stage.is_empty() {
        pairs.retain(|pair, _| {
            let [a, b] = pair.map(|body| lifetime(ready.file, &ready.bodies[body as usize].name));
            a.start.max(b.start) < a.end.min(b.end)
        });
    }
    pairs
}

/// The number of the body of each element; where a mesh comes from a file, parts that share no facet have
/// separate numbers. All are 0 where there is nothing to overlap.
fn parts_of<const D: usize, const N: usize>(ready: &Ready<'_, D, N>) -> Vec<u32>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mut numbers = Vec::with_capacity(ready.model.mesh.elements.len());
    let mut next = 0;
    for body in ready.placed {
        let elements = &body.piece.elements;
        if ready.file.body[body.table].mesh.is_none() {
            numbers.extend(std::iter::repeat_n(next, elements.len()));
            next += 1;
            continue;
        }
        // The least element of a part comes first.
        let parts = parts::parts(elements);
        let mut number_of = vec![0; elements.len()];
        for (element, &part) in parts.iter().enumerate() {
            if part as usize == element {
                number_of[element] = next;
                next += 1;
            }
            numbers.push(number_of[part as usize]);
        }
    }
    numbers
}
