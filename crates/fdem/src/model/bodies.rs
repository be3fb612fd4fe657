//! Bodies: one shape each, meshed and put together.

use std::collections::BTreeSet;

use std::collections::BTreeMap;

use fdem_scenes::random::Random;
use fdem_simulation::Mesh;

use crate::model::document::{Document, Table};
use crate::model::extent::{self, Filled, elements_of_discs, too_many};
use crate::model::fault::{self, Fault};
use crate::model::file::{Body, Hole, ModelFile, Outline, Packing, Voronoi};
use crate::model::materials;
use crate::model::mesh_file::{self, Problem};
use crate::model::mesher::mesh;
use crate::model::outline::{self, Domain};
use crate::model::packing;
use crate::model::piece::Piece;
use crate::model::shapes;
use crate::model::voronoi::{Grains, colours};
use crate::numbers::brief;

/// Gives the bytes of a file that a model names, or says why it cannot.
pub type Load<'l> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'l;

/// A meshed body, and its table in the model file.
#[derive(Debug)]
pub(crate) struct Placed {
    pub(crate) name: String,
    /// Its table in the file.
    pub(crate) table: usize,
    pub(crate) piece: Piece,
    /// The numbers of its first node and of its first element.
    pub(crate) first: [u32; 2],
}

/// The shapes that a body may have.
const SHAPES: [&str; 7] = ["mesh", "rectangle", "disc", "ring", "polygon", "voronoi", "packing"];

/// Checks bodies before they are meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    for (index, body) in file.body.iter().enumerate() {
        let table = Table::of("body", index);
        for (key, name) in names_of_materials(body) {
            if let Err(help) = materials::number(file, &name) {
                faults.push(materials::unknown(document.value(table, &key), &name, help));
            }
        }
        let given = given(body);
        match given[..] {
            [_] => {}
            [] => faults.push(
                Fault::at(document.key(table, "name"), format!("[[body]] \"{}\" has no shape", body.name))
                    .label("this body")
                    .help(format!("give it one of {}", SHAPES.join(", "))),
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
        if !from_file && body.mesh_size.is_none() && !given.is_empty() {
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
            ("only", body.only.is_some(), true),
            ("groups", !body.groups.is_empty(), true),
        ] {
            if is_given && of_files != from_file && !given.is_empty() {
                let what = if of_files { "for meshes from files" } else { "not for meshes from files" };
                faults.push(
                    Fault::at(document.key(table, key), format!("\"{key}\" is {what}")).label("take it out"),
                );
            }
        }
        if let Some(problem) = shapes::problem(body) {
            let span = document.value(table, &problem.key);
            faults.push(Fault::at(span, problem.message).label("this shape").maybe_help(problem.help));
        }
    }
}

/// The shapes that a body has.
fn given(body: &Body) -> Vec<&'static str> {
    let has = [
        body.mesh.is_some(),
        body.rectangle.is_some(),
        body.disc.is_some(),
        body.ring.is_some(),
        body.polygon.is_some(),
        body.voronoi.is_some(),
        body.packing.is_some(),
    ];
    SHAPES.into_iter().zip(has).filter(|(_, has)| *has).map(|(shape, _)| shape).collect()
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

/// Meshes all bodies but those that are known to be `wrong`. Tells what is wrong with their shapes, meshes and files, one fault for each body, and returns the tables
/// whose bodies are missing.
pub(crate) fn build(
    file: &ModelFile,
    document: &Document<'_>,
    load: &mut Load<'_>,
    wrong: &[bool],
    faults: &mut Vec<Fault>,
) -> (Mesh, Vec<Placed>, BTreeSet<usize>) {
    let mut placed: Vec<Placed> = Vec::new();
    let mut missing = BTreeSet::new();
    let mut names = BTreeSet::new();
    for (index, body) in file.body.iter().enumerate() {
        let table = Table::of("body", index);
        if wrong[index] {
            missing.insert(index);
            continue;
        }
        match pieces(file, body, load) {
            Ok(pieces) => {
                let several = body.packing.is_some();
                for (number, mut piece) in pieces.into_iter().enumerate() {
                    piece.place(body.angle, body.translate);
                    let name =
                        if several { format!("{}-{}", body.name, number + 1) } else { body.name.clone() };
                    if !names.insert(name.clone()) {
                        faults.push(
                            Fault::at(
                                document.value(table, "name"),
                                format!("there is a body \"{name}\" already: bodies of a packing have its name and a number"),
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
                faults.push(
                    Fault::at(document.value(table, &problem.key), problem.message)
                        .label("here")
                        .maybe_help(problem.help),
                );
            }
        }
    }
    let mut mesh = Mesh::default();
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

/// Bodies that lie in each other so much that their contacts would have no room.
pub(crate) fn crowded(document: &Document<'_>, placed: &[Placed]) -> Option<Fault> {
    let boxes: Vec<Filled> = placed
        .iter()
        .map(|body| {
            let piece = &body.piece;
            let mut size = [0.0; 2];
            for triangle in &piece.elements {
                let corners = triangle.map(|node| piece.nodes[node as usize]);
                let [low, high] = outline::bounds(corners.into_iter());
                for axis in 0..2 {
                    size[axis] += (high[axis] - low[axis]) / piece.elements.len() as f64;
                }
            }
            let bounds = outline::bounds(piece.nodes.iter().copied());
            Filled { bounds, elements: piece.elements.len() as f64, size }
        })
        .collect();
    let ([a, b], couples) = extent::crowded(&boxes)?;
    let [first, second] = [a.min(b), a.max(b)].map(|body| &placed[body]);
    let span = document.value(Table::of("body", second.table), "name");
    Some(extent::crowd(span, &first.name, &second.name, couples))
}

/// The meshed pieces of a body: one, unless it is a packing.
fn pieces(file: &ModelFile, body: &Body, load: &mut Load<'_>) -> Result<Vec<Piece>, Problem> {
    // Checked before: names are known, and there is a size.
    let material = materials::number(file, &body.material).unwrap_or(0);
    let size = body.mesh_size.unwrap_or(f64::MAX);
    let shape = |key: &'static str| {
        move |message: String| Problem::new(key, format!("[[body]] \"{}\": {message}", body.name))
    };
    if let Some(name) = &body.mesh {
        let bytes = load(name).map_err(|why| Problem::new("mesh", format!("cannot read {name}: {why}")))?;
        let groups: BTreeMap<String, u32> = body
            .groups
            .iter()
            .map(|(group, name)| (group.clone(), materials::number(file, name).unwrap_or(0)))
            .collect();
        let mut piece = mesh_file::read(&bytes, name, body.only.as_deref(), &groups, material)?;
        piece.find_outline().map_err(|message| Problem::new("mesh", format!("{name}: {message}")))?;
        return Ok(vec![piece]);
    }
    let uniform = |domain: &Domain, seed: u64, key: &'static str| {
        let meshed = mesh(domain, size, seed).map_err(shape(key))?;
        let materials = vec![material; meshed.elements.len()];
        Piece::new(meshed, materials).map_err(shape(key))
    };
    if let Some(packing) = &body.packing {
        let circles = circles(packing, load).map_err(shape("packing"))?;
        let elements = elements_of_discs(circles.iter().map(|(_, radius)| *radius), size);
        if let Some(message) = too_many(0.0, elements, size, None) {
            return Err(shape("packing")(message));
        }
        let mut random = Random::with_stream(packing.seed, 3);
        return (0..)
            .zip(circles)
            .map(|(number, circle)| {
                let outline = packing::outline(packing, circle, size, &mut random);
                let domain = Domain { loops: vec![outline], lines: Vec::new() };
                uniform(&domain, body.seed.wrapping_add(number), "packing")
            })
            .collect();
    }
    if let Some(voronoi) = &body.voronoi {
        let numbers: Vec<u32> =
            voronoi.materials.iter().map(|name| materials::number(file, name).unwrap_or(0)).collect();
        let mut domain = outline_domain(&voronoi.outline, size);
        let piece = grains(voronoi, &mut domain, size, body.seed, &numbers, material);
        return Ok(vec![piece.map_err(shape("voronoi"))?]);
    }
    let (key, domain) = if let Some(rectangle) = &body.rectangle {
        ("rectangle", with_holes(outline::rectangle(rectangle).unwrap_or_default(), &rectangle.holes, size))
    } else if let Some(disc) = &body.disc {
        ("disc", with_holes(outline::disc(disc, size), &[], size))
    } else if let Some(ring) = &body.ring {
        let circles =
            [ring.radius, ring.inner_radius].map(|radius| outline::circle(ring.centre, radius, size));
        ("ring", Domain { loops: circles.into(), lines: Vec::new() })
    } else if let Some(polygon) = &body.polygon {
        ("polygon", with_holes(polygon.points.clone(), &polygon.holes, size))
    } else {
        return Err(Problem::new("name", "a body without shape"));
    };
    Ok(vec![uniform(&domain, body.seed, key)?])
}

fn with_holes(outer: Vec<outline::Point>, holes: &[Hole], size: f64) -> Domain {
    let mut loops = vec![outer];
    loops.extend(holes.iter().map(|hole| outline::hole(hole, size)));
    Domain { loops, lines: Vec::new() }
}

fn outline_domain(of: &Outline, size: f64) -> Domain {
    if let Some(rectangle) = &of.rectangle {
        return with_holes(outline::rectangle(rectangle).unwrap_or_default(), &rectangle.holes, size);
    }
    if let Some(disc) = &of.disc {
        return with_holes(outline::disc(disc, size), &[], size);
    }
    of.polygon
        .as_ref()
        .map_or_else(Domain::default, |polygon| with_holes(polygon.points.clone(), &polygon.holes, size))
}

fn grains(
    voronoi: &Voronoi,
    domain: &mut Domain,
    size: f64,
    seed: u64,
    materials: &[u32],
    default: u32,
) -> Result<Piece, String> {
    let grains = Grains::new(domain, voronoi.grains, voronoi.seed, voronoi.rounds)?;
    let across = (domain.area() / voronoi.grains as f64).sqrt();
    grains.cut(domain, size)?;
    let meshed = mesh(domain, size, seed).map_err(|why| {
        // The borders of such grains come closer to each other than the nodes on them.
        if across >= size {
            return why;
        }
        format!(
            "the grains are too small for the mesh: their mean width of {} m is below the mesh size of {} m; take fewer grains or a smaller mesh_size",
            brief(across),
            brief(size)
        )
    })?;
    let grain = grains.of_elements(&meshed)?;
    let materials = if materials.is_empty() {
        vec![default; grain.len()]
    } else {
        let colours = colours(&meshed, &grain, materials.len());
        grain.iter().map(|&grain| materials[colours[grain as usize] as usize]).collect()
    };
    Ok(Piece { grains: grain, ..Piece::new(meshed, materials)? })
}

fn circles(packing: &Packing, load: &mut Load<'_>) -> Result<Vec<packing::Circle>, String> {
    if let Some(name) = &packing.file {
        let bytes = load(name).map_err(|why| format!("cannot read {name}: {why}"))?;
        return packing::read(&bytes, name);
    }
    match (packing.count, packing.radius, &packing.within) {
        (Some(count), Some(radius), Some(within)) => {
            packing::scatter(count, radius, [within.min, within.max], packing.gap, packing.seed)
                .map_err(|message| format!("{message}: take fewer or smaller ones, or a larger rectangle"))
        }
        _ => Ok(Vec::new()),
    }
}

/// The bodies that a name means: those of its table, or one piece of a packing.
pub(crate) fn named(placed: &[Placed], file: &ModelFile, name: &str) -> Vec<usize> {
    let of_table = |body: &&(usize, &Placed)| file.body[body.1.table].name == name || body.1.name == name;
    let all: Vec<(usize, &Placed)> = placed.iter().enumerate().collect();
    all.iter().filter(of_table).map(|(number, _)| *number).collect()
}

/// The body that was probably meant.
pub(crate) fn suggestion(file: &ModelFile, name: &str) -> Option<String> {
    let names: Vec<&str> = file.body.iter().map(|body| body.name.as_str()).collect();
    fault::suggestion(name, &names, "[[body]]")
}
