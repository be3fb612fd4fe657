//! Bodies in space: how the shapes of a model file are meshed.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::shapes::Prism;
use fdem_mesh::tetrahedra::{MeshError, Size, Surface, THICK, Tetrahedra, graded, moved};
use fdem_mesh::triangles::colours;
use fdem_mesh::{Grading, shapes};
use fdem_scenes::random::Random;

use crate::bodies::dimensions::Dimensions;
use crate::bodies::materials;
use crate::bodies::mesh_file::{self, materials_of_groups};
use crate::bodies::plane::outline_domain;
use crate::joints::lines::JointLines;
use crate::shapes::limits::{MOST, VOLUME, too_many};
use crate::shapes::outline::{self, area};
use crate::shapes::packing::{self, Ball, Motion, Room};
use crate::shapes::piece::{Piece, with_notes};
use crate::shapes::refine::{self, grading};
use crate::shapes::{coincident, distant, holes, inward};
use crate::text::fault::Problem;
use crate::text::file::{
    self, Block, Body, Cylinder, Extrusion, ModelFile, Outline, Packing, Sphere, Voronoi,
};
use crate::text::included::Load;

/// Angle between the normals of two triangles of a surface from which they are of two faces, degrees.
const CREASE: f64 = 30.0;

/// Width of a body over its mesh size from which its unit may be another one.
const WIDE: f64 = 1000.0;

/// The meshed pieces of a body: one, unless it is a packing.
pub(crate) fn pieces(
    file: &ModelFile,
    body: &Body,
    joints: &JointLines<'_>,
    load: &mut Load<'_>,
) -> Result<Vec<Piece<3, 4>>, Problem> {
    // Checked before: names are known, and there is a size.
    if let Some(name) = &body.mesh {
        let material = materials::number(file, &body.material).unwrap_or(0);
        let bytes = mesh_file::file_of(body, name, 3, load)?;
        let groups = materials_of_groups(file, body);
        let mut piece = mesh_file::read_space(
            &bytes,
            (name, mesh_file::scale_of(body)),
            body.only.as_deref(),
            (&groups, material),
            load,
        )?;
        piece.find_outline().map_err(|message| Problem::new("mesh", format!("{name}: {message}")))?;
        piece.joints = joints.of_groups(body, &piece)?;
        return Ok(vec![piece]);
    }
    let grading = grading::<3>(body);
    let Some(packing) = &body.packing else {
        let (key, shape) = surface(body, &|place| grading.at(place), load)?;
        return Ok(vec![coarsened(file, (body, joints), key, shape, &grading)?]);
    };
    // All copies are of one file, which is read once.
    let mut known = BTreeMap::new();
    let mut load = |name: &str| known.entry(name.to_owned()).or_insert_with(|| load(name)).clone();
    let SpherePacking { balls, copied, notes } = balls(body, packing, &mut load)?;
    let mut random = Random::with_stream(packing.seed, 3);
    let seeds = (0..).map(|number| body.seed.wrapping_add(number));
    let pieces: Result<Vec<Piece<3, 4>>, Problem> = balls
        .into_iter()
        .zip(seeds)
        .map(|(ball, seed)| {
            let one = Body { seed, ..body.clone() };
            let shape = match &copied {
                Some((of, middle, radius)) => {
                    let (angle, axis) = packing::turn(&mut random);
                    let turn = <[[f64; 3]; 4]>::turn(angle, Some(axis));
                    let motion = Motion { about: *middle, turn, scale: ball.1 / radius, to: ball.0 };
                    copy(&Body { seed, ..of.clone() }, &motion, &grading, &mut load)?
                }
                None if packing::shape(packing, 3) == file::PieceShape::Polyhedron => {
                    shapes::hull(&packing::polyhedron(packing, ball, &mut random)).map(Shape::numbered)
                }
                None => shapes::sphere(ball.0, ball.1, &|place| grading.at(place), seed).map(Shape::numbered),
            };
            meshed(file, (&one, joints), "packing", shape, &grading)
        })
        .collect();
    pieces.map(|pieces| with_notes(pieces, notes))
}

/// A shape, meshed. If the body allows it, with larger facets where these are finer than the mesh; if the
/// mesher refuses these, with the facets as they are.
fn coarsened(
    file: &ModelFile,
    (body, joints): (&Body, &JointLines<'_>),
    key: &'static str,
    shape: Result<Shape, MeshError>,
    grading: &Grading<3>,
) -> Result<Piece<3, 4>, Problem> {
    let Some(tolerance) = body.surface_tolerance else {
        return meshed(file, (body, joints), key, shape, grading);
    };
    let mut shape = shape.map_err(|error| told(body, key, &error, None))?;
    // A surface that is refused as it is has the words of the mesher on its own facets.
    let coarse = shape
        .surface
        .check()
        .ok()
        .and_then(|()| shape.surface.coarsened(&|place| grading.at(place), tolerance));
    let Some(coarse) = coarse else { return meshed(file, (body, joints), key, Ok(shape), grading) };
    let [before, after] = [&shape.surface, &coarse.surface].map(|surface| surface.facets.len() as u64);
    let of = body.surface.as_deref().unwrap_or_default();
    let note = format!(
        "{of}: coarsened {} facets to {}, at most {} m off",
        grouped(before),
        grouped(after),
        brief(coarse.distance)
    );
    let notes = [shape.notes.clone(), vec![note]].concat();
    let larger = Shape { surface: coarse.surface, notes, ..shape.clone() };
    meshed(file, (body, joints), key, Ok(larger), grading).or_else(|problem| {
        let refused = "its facets are as they are, because the mesher refuses larger ones";
        shape.notes.push(format!("{of}: {refused}: {}", problem.message));
        meshed(file, (body, joints), key, Ok(shape), grading)
    })
}

/// A shape, meshed.
fn meshed(
    file: &ModelFile,
    (body, joints): (&Body, &JointLines<'_>),
    key: &'static str,
    shape: Result<Shape, MeshError>,
    grading: &Grading<3>,
) -> Result<Piece<3, 4>, Problem> {
    let material = materials::number(file, &body.material).unwrap_or(0);
    let Shape { mut surface, names, round, notes } = shape.map_err(|error| told(body, key, &error, None))?;
    if let Some(problem) = distant::problem(key, &body.name, fdem_mesh::bounds(surface.nodes.iter().copied()))
    {
        return Err(problem);
    }
    let edges = surface.facets.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let edges = edges.map(|edge| edge.map(|node| node as usize));
    let corners = format!("[[body]] \"{}\": its corners", body.name);
    if let Some(problem) = coincident::problem(key, &corners, &surface.nodes, edges) {
        return Err(problem);
    }
    let turn = <[[f64; 3]; 4]>::turn(body.angle, body.axis);
    let joints = joints.put_into((body, turn), &mut surface, grading)?;
    let meshed = match round {
        Some(Round::Cylinder(prism)) => moved(&surface, grading, body.seed, &|mesh| prism.round(mesh)),
        Some(Round::Sphere(of)) => {
            moved(&surface, grading, body.seed, &|mesh| shapes::onto_sphere(mesh, of.centre, of.radius))
        }
        None => graded(&surface, grading, body.seed),
    };
    let meshed = meshed.map_err(|error| told(body, key, &error, Some(&surface)))?;
    let materials = match &body.voronoi {
        Some(voronoi) if !voronoi.materials.is_empty() => {
            let count = voronoi.materials.len();
            let colours = colours::<3, 4>(&meshed.elements, &meshed.regions, count);
            let number = |name: &String| materials::number(file, name).unwrap_or(0);
            let numbers: Vec<u32> = voronoi.materials.iter().map(number).collect();
            meshed.regions.iter().map(|&grain| numbers[colours[grain as usize] as usize]).collect()
        }
        _ => vec![material; meshed.elements.len()],
    };
    let facets = joints.facets(&meshed);
    let piece = piece(meshed, &names, materials, body.voronoi.is_some());
    let polygons = joints.polygons(&facets);
    let piece = piece.map(|piece| Piece { joints: facets, polygons, notes, ..piece });
    piece.map_err(|message| Problem::new(key, format!("[[body]] \"{}\": {message}", body.name)))
}

/// An error of the mesher in words, with units. Too many elements are a matter of the mesh size, of a place
/// to refine, or of the unit of a file.
fn told(body: &Body, key: &str, error: &MeshError, surface: Option<&Surface>) -> Problem {
    let size = body.mesh_size.unwrap_or(f64::MAX);
    let elements = match *error {
        MeshError::TooMany { elements } => elements,
        MeshError::Thin { thickness, size, .. } => {
            let (what, other) = match &body.voronoi {
                Some(_) => ("a grain", "fewer grains"),
                None => ("it", "a thicker body"),
            };
            let message = format!(
                "[[body]] \"{}\": {what} is {} m thick in the mean, and a mesh size of {} m would make flat elements",
                body.name,
                brief(thickness),
                brief(size)
            );
            let help = format!("take a mesh_size of {} m at most, or {other}", brief(THICK * thickness));
            return Problem { help: Some(help), ..Problem::new(key, message) };
        }
        MeshError::Slender { radius, length, elements } => {
            let message = format!(
                "[[body]] \"{}\": a radius of {} m along a length of {} m would take about {} elements, of at most {}: elements are not longer than wide",
                body.name,
                brief(radius),
                brief(length),
                brief(elements),
                grouped(MOST as u64)
            );
            return Problem { help: Some("take a larger radius".to_owned()), ..Problem::new(key, message) };
        }
        MeshError::Open { .. } if body.surface.is_some() => {
            let corners = |surface: &Surface| -> Vec<[[f64; 3]; 3]> {
                let places = |facet: &[u32; 3]| facet.map(|node| surface.nodes[node as usize]);
                surface.facets.iter().map(places).collect()
            };
            let open = surface.and_then(|surface| holes::words(&corners(surface)));
            let help = open.unwrap_or_else(|| "close it in the program that made it".to_owned());
            return Problem {
                help: Some(help),
                ..Problem::new(key, format!("[[body]] \"{}\": {error}", body.name))
            };
        }
        MeshError::Inverted { .. } | MeshError::Orientation { .. } if body.surface.is_some() => {
            let help = "in the program that made it, turn the normals of all triangles outward";
            return Problem {
                help: Some(help.to_owned()),
                ..Problem::new(key, format!("[[body]] \"{}\": {error}", body.name))
            };
        }
        _ => return Problem::new(key, format!("[[body]] \"{}\": {error}", body.name)),
    };
    if let Some(problem) = refine::blamed(body, self::elements(body, size), Some(elements)) {
        return problem;
    }
    let message = too_many(0.0, elements, size, None).unwrap_or_else(|| error.to_string());
    let [low, high] =
        fdem_mesh::bounds(surface.into_iter().flat_map(|surface| surface.nodes.iter().copied()));
    let width = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let help = if body.surface.is_some() && width > WIDE * size {
        format!(
            "the body is {} m wide, {} times mesh_size: if its file is in millimetres, say scale = \"1 mm\"",
            brief(width),
            brief((width / size).round())
        )
    } else {
        "take a larger mesh_size".to_owned()
    };
    Problem {
        help: Some(help),
        ..Problem::new("mesh_size", format!("[[body]] \"{}\": {message}", body.name))
    }
}

/// A shape that is copied, with the centre and the radius of a sphere around it.
type Copied = (Body, [f64; 3], f64);

/// The spheres of a packing, and the shape that is copied into them, if one is.
struct SpherePacking {
    balls: Vec<Ball<3>>,
    copied: Option<Copied>,
    /// Notes on the file of the packing.
    notes: Vec<String>,
}

fn balls(body: &Body, packing: &Packing, load: &mut Load<'_>) -> Result<SpherePacking, Problem> {
    let problem = |message: String| Problem::new("packing", format!("[[body]] \"{}\": {message}", body.name));
    let copied = match &packing.copies_of {
        Some(of) => {
            let of = of.body(body);
            let (middle, radius) = reach(&of, load)?;
            Some((of, middle, radius))
        }
        None => None,
    };
    if let Some(name) = &packing.file {
        let bytes = load(name).map_err(|why| problem(format!("cannot read {name}: {why}")))?;
        let (balls, notes) = packing::read_space(&bytes, name, body.scale).map_err(problem)?;
        let size = body.mesh_size.unwrap_or(f64::MAX);
        let elements = balls.iter().map(|(_, radius)| ball_volume(*radius) / (VOLUME * size.powi(3))).sum();
        return match too_many(0.0, elements, size, None) {
            Some(message) => Err(problem(message)),
            None => Ok(SpherePacking { balls, copied, notes }),
        };
    }
    let radius = packing.radius.or(copied.as_ref().map(|(.., radius)| [*radius; 2]));
    let balls = match (packing.count, radius, packing.within.as_ref().and_then(Room::new)) {
        (Some(count), Some(radius), Some(room)) => {
            packing::scatter(count, radius, &room, packing.gap, packing.seed).map_err(|message| {
                problem(format!("{message}: take fewer or smaller ones, or a larger {}", room.name()))
            })?
        }
        _ => Vec::new(),
    };
    Ok(SpherePacking { balls, copied, notes: Vec::new() })
}

/// A copy of a shape: turned, scaled and moved.
fn copy(
    of: &Body,
    motion: &Motion<3>,
    grading: &Grading<3>,
    load: &mut Load<'_>,
) -> Result<Result<Shape, MeshError>, Problem> {
    let (_, shape) = surface(of, &|place| grading.at(motion.place(place)) / motion.scale, load)
        .map_err(|problem| Problem { key: format!("packing.copies_of.{}", problem.key), ..problem })?;
    Ok(shape.map(|mut shape| {
        for node in &mut shape.surface.nodes {
            *node = motion.place(*node);
        }
        shape
    }))
}

/// The centre and the radius of a sphere around a shape.
fn reach(of: &Body, load: &mut Load<'_>) -> Result<([f64; 3], f64), Problem> {
    if let Some(known) = reach_of_round(of) {
        return Ok(known);
    }
    let (key, shape) = surface(of, &|_| f64::MAX, load)
        .map_err(|problem| Problem { key: format!("packing.copies_of.{}", problem.key), ..problem })?;
    let shape = shape.map_err(|error| {
        Problem::new(format!("packing.copies_of.{key}"), format!("[[body]] \"{}\": {error}", of.name))
    })?;
    let nodes = &shape.surface.nodes;
    let [low, high] = fdem_mesh::bounds(nodes.iter().copied());
    let middle = [0, 1, 2].map(|axis| f64::midpoint(low[axis], high[axis]));
    Ok((middle, nodes.iter().map(|&node| distance(node, middle)).fold(0.0, f64::max)))
}

/// Reach of cylinders, tubes and extruded discs, whose nodes depend on the size of the mesh.
fn reach_of_round(of: &Body) -> Option<([f64; 3], f64)> {
    let ends = |from: [f64; 3], to: [f64; 3], radius: f64| {
        let middle = [0, 1, 2].map(|axis| f64::midpoint(from[axis], to[axis]));
        (middle, radius.hypot(0.5 * distance(from, to)))
    };
    if let Some(of) = &of.cylinder {
        return Some(ends(of.from, of.to, of.radius));
    }
    if let Some(of) = &of.tube {
        return Some(ends(of.from, of.to, of.radius));
    }
    let extrusion = of.extrusion.as_ref()?;
    let disc = extrusion.outline.disc.as_ref()?;
    let end = |z: f64| [disc.centre[0], disc.centre[1], z];
    Some(ends(end(extrusion.from), end(extrusion.to), disc.radius))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn ball_volume(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

/// The surface of a body, and the names of the groups of its faces.
#[derive(Clone)]
struct Shape {
    surface: Surface,
    /// Names of each face.
    names: Vec<Vec<String>>,
    /// How a mesh with grains is made round.
    round: Option<Round>,
    /// Notes on the file of a surface.
    notes: Vec<String>,
}

/// The round shape that replaces the prism of a mesh with grains.
#[derive(Clone)]
enum Round {
    /// A cylinder, for which a prism is meshed.
    Cylinder(Prism),
    /// A sphere, whose surface has its nodes but for those that the mesher adds.
    Sphere(Sphere),
}

impl Shape {
    /// A shape whose faces have the names that its surface gives them.
    fn named(surface: Surface) -> Self {
        let names = surface.names.iter().map(|name| vec![name.clone()]).collect();
        Self { surface, names, round: None, notes: Vec::new() }
    }

    /// A shape whose faces are `face-1`, `face-2`, ….
    fn numbered(surface: Surface) -> Self {
        let count = surface.faces.iter().max().map_or(0, |most| most + 1);
        let names = (1..=count).map(|number| vec![format!("face-{number}")]).collect();
        Self { surface, names, round: None, notes: Vec::new() }
    }
}

/// The shape of a body with the key that gives it.
fn surface(
    body: &Body,
    size: &Size<'_>,
    load: &mut Load<'_>,
) -> Result<(&'static str, Result<Shape, MeshError>), Problem> {
    let seed = body.seed;
    Ok(if let Some(of) = &body.block {
        ("box", shapes::cuboid(of.min, of.max).map(Shape::named))
    } else if let Some(of) = &body.cylinder {
        ("cylinder", shapes::cylinder(of.from, of.to, of.radius, size, seed).map(Shape::named))
    } else if let Some(of) = &body.tube {
        let tube = shapes::tube(of.from, of.to, of.inner_radius, of.radius, size, seed);
        let mut shape = tube.map(Shape::named);
        if let Ok(shape) = &mut shape {
            let names = shape.names.iter_mut().flatten();
            names.filter(|name| *name == "inner mantle").for_each(|name| "inside".clone_into(name));
        }
        ("tube", shape)
    } else if let Some(of) = &body.sphere {
        ("sphere", shapes::sphere(of.centre, of.radius, size, seed).map(Shape::numbered))
    } else if let Some(of) = &body.polyhedron {
        ("polyhedron", shapes::hull(&of.points).map(Shape::numbered))
    } else if let Some(of) = &body.extrusion {
        ("extrusion", extrusion(of, body.mesh_size.unwrap_or(f64::MAX)))
    } else if let Some(voronoi) = &body.voronoi {
        let shape = grains(voronoi, size);
        ("voronoi", shape)
    } else if let Some(name) = &body.surface {
        let mut triangles = mesh_file::triangles(load, name, mesh_file::scale_of(body))?;
        let closed = body.close_holes.and_then(|width| holes::close(&mut triangles, width));
        let turned = inward::turn_outward(&mut triangles);
        let notes: Vec<String> =
            closed.into_iter().chain(turned).map(|note| format!("{name}: {note}")).collect();
        let shape = Surface::from_triangles(&triangles, CREASE);
        ("surface", shape.map(|surface| Shape { notes, ..Shape::numbered(surface) }))
    } else {
        return Err(Problem::new("name", "a body without shape"));
    })
}

/// Grains of an outline.
fn grains(voronoi: &Voronoi, size: &Size<'_>) -> Result<Shape, MeshError> {
    let (of, count, seed) = (&voronoi.outline, voronoi.grains, voronoi.seed);
    if let Some(of) = &of.sphere {
        let surface = shapes::grains_of_sphere(of.centre, of.radius, count, size, seed)?;
        // The faces between grains have no names.
        return Ok(Shape {
            surface,
            names: vec![vec!["face-1".to_owned()]],
            round: Some(Round::Sphere(of.clone())),
            notes: Vec::new(),
        });
    }
    let shape = if let Some(of) = &of.block {
        Shape::named(shapes::cuboid(of.min, of.max)?)
    } else if let Some(of) = &of.cylinder {
        let prism = Prism::of_cylinder(of.from, of.to, of.radius)?;
        Shape { round: Some(Round::Cylinder(prism)), ..Shape::named(prism.surface()) }
    } else {
        let points = of.polyhedron.as_ref().map_or(&[][..], |of| &of.points);
        Shape::numbered(shapes::hull(points)?)
    };
    let surface = shapes::grains(&shape.surface, count, seed)?;
    Ok(Shape { surface, ..shape })
}

fn extrusion(of: &Extrusion, size: f64) -> Result<Shape, MeshError> {
    let loops = outline_domain(&of.outline, &Grading::even(size)).loops;
    let surface = shapes::extrusion(&loops, of.from, of.to)?;
    let mut names = vec![vec!["bottom".to_owned()], vec!["top".to_owned()]];
    for (number, corners) in loops.iter().enumerate() {
        let name = match number {
            0 => vec!["outer".to_owned()],
            hole => vec!["holes".to_owned(), format!("hole-{hole}")],
        };
        names.extend(std::iter::repeat_n(name, corners.len()));
    }
    Ok(Shape { surface, names, round: None, notes: Vec::new() })
}

/// A mesh that was made here, with the groups of its faces.
fn piece(
    meshed: Tetrahedra,
    names: &[Vec<String>],
    materials: Vec<u32>,
    has_grains: bool,
) -> Result<Piece<3, 4>, String> {
    let Tetrahedra { nodes, elements, regions, facets, faces, .. } = meshed;
    let grains = if has_grains { regions } else { Vec::new() };
    let mut piece = Piece { nodes, elements, materials, grains, ..Piece::default() };
    piece.find_outline()?;
    for (facet, face) in facets.into_iter().zip(faces) {
        for name in names.get(face as usize).into_iter().flatten() {
            piece.groups.entry(name.clone()).or_default().facets.push(facet);
        }
    }
    Ok(piece)
}

/// Least and largest coordinates of a cylinder.
fn bounds_of_cylinder([from, to]: [[f64; 3]; 2], radius: f64) -> [[f64; 3]; 2] {
    let along: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
    let squared: f64 = along.iter().map(|x| x * x).sum();
    // Half of the width of a disc across the axis.
    let half = along.map(|x| radius * (1.0 - x * x / squared).max(0.0).sqrt());
    [
        std::array::from_fn(|axis| from[axis].min(to[axis]) - half[axis]),
        std::array::from_fn(|axis| from[axis].max(to[axis]) + half[axis]),
    ]
}

/// Approximate least and largest coordinates of a body; `None` if its shape does not determine them.
pub(crate) fn bounds(body: &Body) -> Option<[[f64; 3]; 2]> {
    let around = |points: &[[f64; 3]], by: f64| {
        let [low, high] = fdem_mesh::bounds(points.iter().copied());
        [low.map(|x| x - by), high.map(|x| x + by)]
    };
    let of_block = |of: &Block| [of.min, of.max];
    Some(if let Some(of) = &body.block {
        of_block(of)
    } else if let Some(of) = &body.cylinder {
        bounds_of_cylinder([of.from, of.to], of.radius)
    } else if let Some(of) = &body.tube {
        bounds_of_cylinder([of.from, of.to], of.radius)
    } else if let Some(of) = &body.sphere {
        around(&[of.centre], of.radius)
    } else if let Some(of) = &body.polyhedron {
        around(&of.points, 0.0)
    } else if let Some(of) = &body.extrusion {
        let [low, high] = outline_domain(&of.outline, &Grading::even(f64::MAX)).bounds();
        [[low[0], low[1], of.from], [high[0], high[1], of.to]]
    } else if let Some(packing) = &body.packing {
        Room::<3>::new(packing.within.as_ref()?)?.bounds
    } else {
        let of = &body.voronoi.as_ref()?.outline;
        match (&of.block, &of.cylinder, &of.sphere) {
            (Some(of), ..) => of_block(of),
            (_, Some(of), _) => bounds_of_cylinder([of.from, of.to], of.radius),
            (.., Some(of)) => around(&[of.centre], of.radius),
            _ => around(&of.polyhedron.as_ref()?.points, 0.0),
        }
    })
}

/// Approximate number of elements with edges of `size` that a body has; `None` if its shape does not
/// determine it.
pub(crate) fn elements(body: &Body, size: f64) -> Option<f64> {
    Some(volume(body)?.max(0.0) / (VOLUME * size.powi(3)))
}

/// Approximate volume of a body, m³; `None` if its shape does not determine it.
fn volume(body: &Body) -> Option<f64> {
    let of_block = |of: &Block| (0..3).map(|axis| of.max[axis] - of.min[axis]).product();
    let of_cylinder = |of: &Cylinder| PI * of.radius * of.radius * distance(of.from, of.to);
    Some(if let Some(of) = &body.block {
        of_block(of)
    } else if let Some(of) = &body.cylinder {
        of_cylinder(of)
    } else if let Some(of) = &body.tube {
        PI * (of.radius * of.radius - of.inner_radius * of.inner_radius) * distance(of.from, of.to)
    } else if let Some(of) = &body.sphere {
        ball_volume(of.radius)
    } else if let Some(of) = &body.extrusion {
        outline_area(&of.outline)? * (of.to - of.from)
    } else if let Some(of) = &body.polyhedron {
        hull_volume(&of.points)?
    } else if let Some(packing) = &body.packing {
        volume_of_packing(body, packing)?
    } else {
        let of = &body.voronoi.as_ref()?.outline;
        match (&of.block, &of.cylinder, &of.sphere) {
            (Some(of), ..) => of_block(of),
            (_, Some(of), _) => of_cylinder(of),
            (.., Some(of)) => ball_volume(of.radius),
            _ => hull_volume(&of.polyhedron.as_ref()?.points)?,
        }
    })
}

/// Volume of the convex polyhedron around points; `None` if there is none.
fn hull_volume(points: &[[f64; 3]]) -> Option<f64> {
    let hull = shapes::hull(points).ok()?;
    let origin = *hull.nodes.first()?;
    let of = |facet: &[u32; 3]| {
        let [a, b, c] = facet.map(|node| {
            let node = hull.nodes[node as usize];
            [0, 1, 2].map(|axis| node[axis] - origin[axis])
        });
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        (a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)) / 6.0
    };
    Some(hull.facets.iter().map(of).sum::<f64>().abs())
}

/// Volume of the bodies of a packing at random places.
fn volume_of_packing(body: &Body, packing: &Packing) -> Option<f64> {
    let copied = packing.copies_of.as_ref().map(|of| of.body(body));
    let (share, radius) = match &copied {
        Some(of) => {
            let (_, radius) = reach(of, &mut |_| Err(String::new())).ok()?;
            (volume(of)? / ball_volume(radius), Some([radius; 2]))
        }
        None => (1.0, None),
    };
    // All radii between the least and the largest are equally likely.
    let [least, most] = packing.radius.or(radius)?;
    let cube = (least + most) * (least * least + most * most) / 4.0;
    Some(packing.count? as f64 * share * ball_volume(1.0) * cube)
}

/// Area of an outline without its holes, m².
fn outline_area(of: &Outline) -> Option<f64> {
    if let Some(rectangle) = &of.rectangle {
        return outline::rectangle(rectangle).map(|corners| area(&corners).abs());
    }
    if let Some(disc) = &of.disc {
        return Some(PI * disc.radius * disc.radius);
    }
    of.polygon.as_ref().map(|polygon| area(&polygon.points).abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_of_a_cylinder_ends_at_its_ends() {
        let found = bounds_of_cylinder([[0.0, 0.0, 0.1], [0.0; 3]], 0.025);
        assert_eq!(found, [[-0.025, -0.025, 0.0], [0.025, 0.025, 0.1]]);
        let found = bounds_of_cylinder([[1.0, 1.0, 0.0], [4.0, 5.0, 0.0]], 1.0);
        let right = [[0.2, 0.4, -1.0], [4.8, 5.6, 1.0]];
        let near = found.iter().flatten().zip(right.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near, "{found:?}");
    }
}
