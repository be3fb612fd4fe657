//! Bodies: one shape each, meshed and put together.

use std::collections::BTreeSet;

use std::collections::BTreeMap;

use fdem_scenes::random::Random;
use fdem_simulation::Mesh;

use crate::model::document::{Document, Table};
use crate::model::fault::{self, Fault};
use crate::model::file::{Body, Hole, ModelFile, Outline, Packing, Voronoi};
use crate::model::materials;
use crate::model::mesh_file::{self, Problem};
use crate::model::mesher::mesh;
use crate::model::outline::{self, Domain, area};
use crate::model::packing;
use crate::model::piece::Piece;
use crate::model::voronoi::{Grains, colours};

/// Gives the bytes of a file that a model names, or says why it cannot.
pub type Load<'l> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'l;

/// A body of the mesh and where it comes from.
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

/// What can be said of bodies before they are meshed.
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
        if let Some(problem) = size_problem(body) {
            let span = document.value(table, &problem.key);
            faults.push(Fault::at(span, problem.message).label("no area").maybe_help(problem.help));
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

/// Shapes without area.
fn size_problem(body: &Body) -> Option<Problem> {
    let empty =
        |key: &str, what: &str| Some(Problem::new(key, format!("[[body]] \"{}\": {what}", body.name)));
    let inverted = "the rectangle has no area: max has to be above and to the right of min";
    if let Some(rectangle) = &body.rectangle
        && outline::rectangle(rectangle).is_none()
    {
        return empty("rectangle", inverted);
    }
    if let Some(ring) = &body.ring
        && ring.inner_radius >= ring.radius
    {
        return empty("ring.inner_radius", "the ring has no area: its inner radius is not below its radius");
    }
    if let Some(polygon) = &body.polygon
        && area(&polygon.points) == 0.0
    {
        return empty("polygon.points", "the polygon has no area");
    }
    if let Some(Voronoi { outline: of, .. }) = &body.voronoi {
        let shapes = [of.rectangle.is_some(), of.disc.is_some(), of.polygon.is_some()];
        if shapes.into_iter().filter(|given| *given).count() != 1 {
            return empty("voronoi.outline", "an outline is one of rectangle, disc, polygon");
        }
        if of.rectangle.as_ref().is_some_and(|rectangle| outline::rectangle(rectangle).is_none()) {
            return empty("voronoi.outline.rectangle", inverted);
        }
    }
    body.packing.as_ref().and_then(|packing| packing_problem(packing, &body.name))
}

fn packing_problem(packing: &Packing, name: &str) -> Option<Problem> {
    let problem = |key: &str, what: &str| Some(Problem::new(key, format!("[[body]] \"{name}\": {what}")));
    let random = [packing.count.is_some(), packing.radius.is_some(), packing.within.is_some()];
    match (&packing.file, random) {
        (None, [true, true, true]) => {}
        (None, _) => return problem("packing", "a packing has a file, or count, radius and within"),
        (Some(_), [false, false, false]) => return None,
        (Some(_), _) => {
            return problem("packing.file", "a packing from a file has no count, radius or within");
        }
    }
    if packing.radius.is_some_and(|[least, _]| least <= 0.0) {
        return problem("packing.radius", "the smallest radius is not above 0");
    }
    if packing.radius.is_some_and(|[least, most]| least > most) {
        return problem("packing.radius", "the smallest radius is above the largest");
    }
    if packing.corners[0] > packing.corners[1] {
        return problem("packing.corners", "the least number of corners is above the largest");
    }
    if packing.within.as_ref().is_some_and(|within| outline::rectangle(within).is_none()) {
        return problem(
            "packing.within",
            "the rectangle has no area: max has to be above and to the right of min",
        );
    }
    None
}

/// Meshes all bodies.
///
/// # Errors
/// What is wrong with their shapes, meshes and files: one fault for each body.
pub(crate) fn build(
    file: &ModelFile,
    document: &Document<'_>,
    load: &mut Load<'_>,
) -> Result<(Mesh, Vec<Placed>), Vec<Fault>> {
    let mut faults = Vec::new();
    let mut placed: Vec<Placed> = Vec::new();
    let mut names = BTreeSet::new();
    for (index, body) in file.body.iter().enumerate() {
        let table = Table::of("body", index);
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
            Err(problem) => faults.push(
                Fault::at(document.value(table, &problem.key), problem.message)
                    .label("here")
                    .maybe_help(problem.help),
            ),
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut mesh = Mesh::default();
    for (number, body) in (0..).zip(&mut placed) {
        body.first = [mesh.nodes.len() as u32, mesh.triangles.len() as u32];
        let piece = &body.piece;
        mesh.nodes.extend_from_slice(&piece.nodes);
        mesh.triangles.extend(piece.triangles.iter().map(|nodes| nodes.map(|node| node + body.first[0])));
        mesh.bodies.extend(std::iter::repeat_n(number, piece.triangles.len()));
        mesh.materials.extend_from_slice(&piece.materials);
    }
    Ok((mesh, placed))
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
        let materials = vec![material; meshed.triangles.len()];
        Piece::new(meshed, materials).map_err(shape(key))
    };
    if let Some(packing) = &body.packing {
        let circles = circles(packing, load).map_err(shape("packing"))?;
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
    grains.cut(domain, size)?;
    let meshed = mesh(domain, size, seed)?;
    let grain = grains.of_elements(&meshed)?;
    let materials = if materials.is_empty() {
        vec![default; grain.len()]
    } else {
        let colours = colours(&meshed, &grain, materials.len());
        grain.into_iter().map(|grain| materials[colours[grain as usize] as usize]).collect()
    };
    Piece::new(meshed, materials)
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
