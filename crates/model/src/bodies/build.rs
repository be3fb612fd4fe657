//! Bodies: one shape each, meshed and put together.

use std::collections::BTreeSet;

use fdem_mesh::{Mesh, bounds};
use fdem_simulation::{Model, ModelError, UntilOverloaded};

use crate::bodies::crowded::{self, Filled};
use crate::bodies::dimensions::Dimensions;
use crate::bodies::mesh_file::{self, SURFACES};
use crate::bodies::{gmsh, materials};
use crate::joints::lines::JointLines;
use crate::shapes::of_body::{self, given};
use crate::shapes::piece::Piece;
use crate::shapes::placed::Placed;
use crate::shapes::{distant, refine, repeat};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, Problem};
use crate::text::file::{Body, ModelFile, SHAPES};
use crate::text::included::Load;

/// Checks bodies before they are meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, dimensions: u8, faults: &mut Vec<Fault>) {
    let shapes = SHAPES.iter().filter(|(_, of)| of.contains(&dimensions)).map(|(shape, _)| *shape);
    let shapes = shapes.collect::<Vec<_>>().join(", ");
    for (index, body) in file.body.iter().enumerate() {
        let table = Table::of("body", index);
        for (key, name) in names_of_materials(body) {
            if let Err(help) = materials::number(file, &name) {
                faults.push(materials::unknown(document.value(table, &key), &name, help));
            }
        }
        let given = given(body);
        match given[..] {
            [shape] if SHAPES.iter().any(|(known, of)| *known == shape && of.contains(&dimensions)) => {}
            [shape] => faults.push(
                Fault::at(
                    document.key(table, shape),
                    format!("[[body]] \"{}\": a {shape} is no body in {dimensions} dimensions", body.name),
                )
                .label("not in this model")
                .help(format!("in {dimensions} dimensions a body is one of {shapes}")),
            ),
            [] => faults.push(
                Fault::at(document.key(table, "name"), format!("[[body]] \"{}\" has no shape", body.name))
                    .label("this body")
                    .help(format!("give it one of {shapes}")),
            ),
            [first, second, ..] => faults.push(
                Fault::at(
                    document.key(table, second),
                    format!("[[body]] \"{}\" has two shapes, {first} and {second}", body.name),
                )
                .label("a second shape")
                .help("a body has one shape; write a second [[body]]"),
            ),
        }
        let from_file = body.mesh.is_some();
        let meshed_here = body.mesh.as_ref().is_none_or(|name| gmsh::is_geometry(name));
        if meshed_here && body.mesh_size.is_none() && !given.is_empty() {
            faults.push(
                Fault::at(
                    document.key(table, given[0]),
                    format!(
                        "[[body]] \"{}\" lacks the key \"mesh_size\" (edge of its elements, m)",
                        body.name
                    ),
                )
                .label("needs mesh_size"),
            );
        }
        for (key, is_given, of_files) in [
            ("mesh_size", body.mesh_size.is_some(), false),
            ("refine", !body.refine.is_empty(), false),
            ("only", body.only.is_some(), true),
            ("groups", !body.groups.is_empty(), true),
        ] {
            let fits = if key == "mesh_size" { meshed_here } else { of_files == from_file };
            if is_given && !fits && !given.is_empty() {
                let what = if of_files { "for meshes from files" } else { "not for meshes from files" };
                let fault = Fault::at(document.key(table, key), format!("\"{key}\" is {what}"));
                let surface = key == "mesh_size" && body.mesh.as_deref().is_some_and(mesh_file::is_surface);
                faults.push(if surface { fault.help(SURFACES) } else { fault.label("take it out") });
            }
        }
        for problem in refine::problems(body, dimensions) {
            let span = document.value(table, &problem.key);
            faults.push(Fault::at(span, problem.message).label("this place").maybe_help(problem.help));
        }
        if let Some(problem) = repeat::problem(body) {
            faults.push(Fault::at(document.key(table, &problem.key), problem.message).label("this body"));
        }
        if let Some(problem) = of_body::problem(body, dimensions) {
            let span = document.value(table, &problem.key);
            faults.push(Fault::at(span, problem.message).label("this shape").maybe_help(problem.help));
        }
    }
}

/// Materials that a body names, with their keys.
fn names_of_materials(body: &Body) -> Vec<(String, String)> {
    let mut names = vec![("material".to_owned(), body.material.clone())];
    names.extend(body.groups.iter().map(|(group, material)| (format!("groups.{group}"), material.clone())));
    if let Some(voronoi) = &body.voronoi {
        names.extend(voronoi.materials.iter().map(|name| ("voronoi.materials".to_owned(), name.clone())));
    }
    names
}

/// Meshes all bodies but those that are known to be `wrong`. Reports errors of their shapes, meshes and
/// files, one for each body, and returns the tables whose bodies are missing. `joints`: the lines of joint
/// sets.
pub(crate) fn build<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    (joints, load): (&JointLines<'_>, &mut Load<'_>),
    wrong: &[bool],
    faults: &mut Vec<Fault>,
) -> (Mesh<D, N>, Vec<Placed<D, N>>, BTreeSet<usize>)
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mut placed: Vec<Placed<D, N>> = Vec::new();
    let mut missing = BTreeSet::new();
    let mut names = BTreeSet::new();
    for (index, body) in file.body.iter().enumerate() {
        let table = Table::of("body", index);
        if wrong[index] {
            missing.insert(index);
            continue;
        }
        let pieces = <[[f64; D]; N]>::pieces(file, body, joints, load);
        let pieces = pieces.and_then(|pieces| refine::beyond(body, &pieces).map_or(Ok(pieces), Err));
        let pieces = pieces.and_then(|pieces| named_pieces(body, pieces));
        match pieces {
            Ok(pieces) => {
                for (suffix, piece) in pieces {
                    let shape = given(body).first().copied().unwrap_or("name");
                    if let Some(problem) =
                        distant::problem(shape, &body.name, bounds(piece.nodes.iter().copied()))
                    {
                        missing.insert(index);
                        faults.push(
                            Fault::at(document.value(table, &problem.key), problem.message)
                                .label("too far away")
                                .maybe_help(problem.help),
                        );
                        break;
                    }
                    let name = format!("{}{suffix}", body.name);
                    if !names.insert(name.clone()) {
                        faults.push(
                            Fault::at(
                                document.value(table, "name"),
                                format!("there is a body \"{name}\" already: copies and bodies of a packing have a name with numbers"),
                            )
                            .label("again"),
                        );
                        break;
                    }
                    placed.push(Placed { name, table: index, piece, first: [0, 0] });
                }
            }
            Err(problem) => {
                missing.insert(index);
                // The group of a mesh file is a key, and its material is the value.
                let is_group = problem.key.starts_with("groups.");
                let span = if is_group {
                    document.key(table, &problem.key)
                } else {
                    document.value(table, &problem.key)
                };
                faults.push(Fault::at(span, problem.message).label("here").maybe_help(problem.help));
            }
        }
    }
    let mut mesh =
        Mesh { nodes: Vec::new(), elements: Vec::new(), bodies: Vec::new(), materials: Vec::new() };
    for (number, body) in (0..).zip(&mut placed) {
        body.first = [mesh.nodes.len() as u32, mesh.elements.len() as u32];
        let piece = &body.piece;
        mesh.nodes.extend_from_slice(&piece.nodes);
        mesh.elements.extend(piece.elements.iter().map(|nodes| nodes.map(|node| node + body.first[0])));
        mesh.bodies.extend(std::iter::repeat_n(number, piece.elements.len()));
        mesh.materials.extend_from_slice(&piece.materials);
    }
    (mesh, placed, missing)
}

/// Numbers of the bodies that are rigid, ascending.
pub(crate) fn rigid<const D: usize, const N: usize>(file: &ModelFile, placed: &[Placed<D, N>]) -> Vec<u32> {
    let rigid = (0..).zip(placed).filter(|(_, body)| file.body[body.table].rigid.at_first());
    rigid.map(|(number, _)| number).collect()
}

/// Share of its strength at which a body that is rigid at first starts to deform.
const OVERLOAD: f64 = 0.03;

/// The bodies that are rigid until they are overloaded.
pub(crate) fn until_overloaded<const D: usize, const N: usize>(
    file: &ModelFile,
    placed: &[Placed<D, N>],
) -> Vec<UntilOverloaded> {
    let until = |(number, placed): (u32, &Placed<D, N>)| {
        let body = &file.body[placed.table];
        let share = body.overload.unwrap_or(OVERLOAD);
        (body.rigid.at_first() && !body.rigid.always()).then_some(UntilOverloaded { body: number, share })
    };
    (0..).zip(placed).filter_map(until).collect()
}

/// Checks `overload`, which belongs to bodies that are rigid until they are overloaded.
pub(crate) fn check_overload(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    for (index, body) in file.body.iter().enumerate() {
        if body.overload.is_some() && (body.rigid.always() || !body.rigid.at_first()) {
            let at = document.key(Table::of("body", index), "overload");
            let message = format!("[[body]] \"{}\": overload has no effect", body.name);
            let help = "write rigid = \"until_overloaded\", or take overload out";
            faults.push(Fault::at(at, message).label("no effect").help(help));
        }
    }
}

/// The fault of a body that cannot be rigid until it is overloaded. `tables`: the table of each body.
pub(crate) fn overloaded_fault<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    model: &Model<D, N>,
    tables: &[usize],
) -> Result<(), Fault> {
    let (body, why) = match (model.check_until_overloaded(), model.until_overloaded.first()) {
        (Err(ModelError::UntilOverloaded { body, why }), _) => (body, why),
        (_, Some(first)) if file.model.mass_scaling.is_some() => (first.body, "masses are scaled"),
        _ => return Ok(()),
    };
    let table = tables[body as usize];
    let name = &file.body[table].name;
    let message = format!("[[body]] \"{name}\" cannot be rigid until it is overloaded: {why}");
    let at = document.key(Table::of("body", table), "rigid");
    Err(Fault::at(at, message).label("here").help("write rigid = true, or take it out"))
}

/// The pieces of a body in their places: bodies of a packing and copies, each with the suffix of its name.
fn named_pieces<const D: usize, const N: usize>(
    body: &Body,
    pieces: Vec<Piece<D, N>>,
) -> Result<Vec<(String, Piece<D, N>)>, Problem>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mut named = Vec::with_capacity(pieces.len());
    for (number, mut piece) in pieces.into_iter().enumerate() {
        place(&mut piece, body);
        match (&body.packing, &body.repeat) {
            (Some(_), _) => named.push((format!("-{}", number + 1), piece)),
            (None, Some(_)) => named.extend(repeat::copies(body, &piece)?),
            (None, None) => named.push((String::new(), piece)),
        }
    }
    Ok(named)
}

/// Turns the body about the middle of its bounding box, then moves it.
fn place<const D: usize, const N: usize>(piece: &mut Piece<D, N>, body: &Body)
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    if body.angle != 0.0 {
        let [low, high] = bounds(piece.nodes.iter().copied());
        let middle: [f64; D] = std::array::from_fn(|axis| f64::midpoint(low[axis], high[axis]));
        let turn = <[[f64; D]; N]>::turn(body.angle, body.axis);
        for node in &mut piece.nodes {
            let from: [f64; D] = std::array::from_fn(|axis| node[axis] - middle[axis]);
            *node = std::array::from_fn(|axis| {
                (0..D).fold(middle[axis], |sum, other| sum + turn[axis][other] * from[other])
            });
        }
    }
    if let Some(by) = &body.translate {
        let by = by.components::<D>();
        for node in &mut piece.nodes {
            *node = std::array::from_fn(|axis| node[axis] + by[axis]);
        }
    }
}

/// Bodies that lie in each other so much that their contacts would have no room.
pub(crate) fn crowded<const D: usize, const N: usize>(
    document: &Document<'_>,
    placed: &[Placed<D, N>],
) -> Option<Fault>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let boxes: Vec<Filled<D>> = placed
        .iter()
        .map(|body| {
            let piece = &body.piece;
            let mut size = [0.0; D];
            for element in &piece.elements {
                let [low, high] = bounds(piece.corners(element).into_iter());
                for axis in 0..D {
                    size[axis] += (high[axis] - low[axis]) / piece.elements.len() as f64;
                }
            }
            let bounds = bounds(piece.nodes.iter().copied());
            Filled { bounds, elements: piece.elements.len() as f64, size }
        })
        .collect();
    let ([a, b], couples) = crowded::crowded(&boxes)?;
    let [first, second] = [a.min(b), a.max(b)].map(|body| &placed[body]);
    let span = document.value(Table::of("body", second.table), "name");
    Some(crowded::crowd(span, &first.name, &second.name, couples))
}
