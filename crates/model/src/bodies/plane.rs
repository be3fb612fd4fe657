//! Bodies in the plane: how the shapes of a model file are meshed.

use std::f64::consts::TAU;

use fdem_io::numbers::brief;
use fdem_mesh::Grading;
use fdem_mesh::triangles::{Grains, OutlineError, colours};
use fdem_scenes::random::Random;

use crate::bodies::materials;
use crate::bodies::mesh_file::{self, materials_of_groups};
use crate::joints::lines::JointLines;
use crate::shapes::extent::{elements_of_discs, extent};
use crate::shapes::limits::too_many;
use crate::shapes::outline::{self, Domain};
use crate::shapes::packing::{self, Motion, Room};
use crate::shapes::piece::{Piece, with_notes};
use crate::shapes::refine::{self, grading};
use crate::text::fault::Problem;
use crate::text::file::{Body, Disc, Hole, ModelFile, Outline, Packing, Voronoi};
use crate::text::included::Load;

/// The meshed pieces of a body: one, unless it is a packing.
pub(crate) fn pieces(
    file: &ModelFile,
    body: &Body,
    joints: &JointLines<'_>,
    load: &mut Load<'_>,
) -> Result<Vec<Piece>, Problem> {
    // Checked before: names are known, and there is a size.
    let material = materials::number(file, &body.material).unwrap_or(0);
    let grading = grading::<2>(body);
    let size = grading.size;
    let shape = |key: &'static str| {
        move |message: String| Problem::new(key, format!("[[body]] \"{}\": {message}", body.name))
    };
    if let Some(name) = &body.mesh {
        let bytes = mesh_file::file_of(body, name, 2, load)?;
        let groups = materials_of_groups(file, body);
        let mut piece = mesh_file::read_flat(
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
    let uniform = |domain: &Domain, seed: u64, key: &'static str| {
        let (meshed, joints, lines) =
            joints.meshed(body, domain, &grading, seed, |error| refused(body, key, error))?;
        let materials = vec![material; meshed.elements.len()];
        Ok(Piece { joints, lines, ..Piece::new(meshed, materials).map_err(shape(key))? })
    };
    if let Some(packing) = &body.packing {
        let copied = packing.copies_of.as_ref().map(|of| of.body(body));
        let reach = copied.as_ref().and_then(outline::reach);
        let (circles, notes) =
            circles((body, packing), reach.map(|(_, radius)| radius), load).map_err(shape("packing"))?;
        let elements = elements_of_discs(circles.iter().map(|(_, radius)| *radius), size);
        if let Some(message) = too_many(0.0, elements, size, None) {
            return Err(shape("packing")(message));
        }
        let mut random = Random::with_stream(packing.seed, 3);
        let pieces: Result<Vec<Piece>, Problem> = (0..)
            .zip(circles)
            .map(|(number, circle)| {
                let loops = match (&copied, reach) {
                    (Some(copied), Some((about, radius))) => {
                        let (sine, cosine) = libm::sincos(TAU * random.uniform());
                        let turn = [[cosine, -sine], [sine, cosine]];
                        let motion = Motion { about, turn, scale: circle.1 / radius, to: circle.0 };
                        loops_of_copy(copied, &motion, &grading)
                    }
                    _ => vec![packing::outline(packing, circle, &grading, &mut random)],
                };
                let domain = Domain { loops, lines: Vec::new() };
                uniform(&domain, body.seed.wrapping_add(number), "packing")
            })
            .collect();
        return pieces.map(|pieces| with_notes(pieces, notes));
    }
    if let Some(voronoi) = &body.voronoi {
        let numbers: Vec<u32> =
            voronoi.materials.iter().map(|name| materials::number(file, name).unwrap_or(0)).collect();
        let mut domain = outline_domain(&voronoi.outline, &grading);
        let piece = grains((body, voronoi), &mut domain, joints, &grading, &numbers, material);
        return Ok(vec![piece?]);
    }
    let (key, domain) = if let Some(rectangle) = &body.rectangle {
        (
            "rectangle",
            with_holes(outline::rectangle(rectangle).unwrap_or_default(), &rectangle.holes, &grading),
        )
    } else if let Some(disc) = &body.disc {
        ("disc", with_holes(outline::disc(disc, &grading), &[], &grading))
    } else if let Some(ring) = &body.ring {
        let circles =
            [ring.radius, ring.inner_radius].map(|radius| outline::circle(ring.centre, radius, &grading));
        ("ring", Domain { loops: circles.into(), lines: Vec::new() })
    } else if let Some(polygon) = &body.polygon {
        ("polygon", with_holes(polygon.points.clone(), &polygon.holes, &grading))
    } else {
        return Err(Problem::new("name", "a body without shape"));
    };
    Ok(vec![uniform(&domain, body.seed, key)?])
}

/// An error of the mesher as a problem of this key, or of the place to refine that is its cause.
fn refused(body: &Body, key: &str, error: &OutlineError) -> Problem {
    let size = body.mesh_size.unwrap_or(f64::MAX);
    let elements = match *error {
        OutlineError::TooMany { elements } => Some(Some(elements)),
        OutlineError::SizeTooSmall | OutlineError::Coincide => Some(None),
        _ => None,
    };
    let even = || extent(body).map(|extent| extent.elements(size));
    elements
        .and_then(|elements| refine::blamed(body, even(), elements))
        .unwrap_or_else(|| Problem::new(key, format!("[[body]] \"{}\": {}", body.name, told(error, size))))
}

/// An error of the mesher in words; that of too many elements with the size that gives them.
fn told(error: &OutlineError, size: f64) -> String {
    let too_many = match *error {
        OutlineError::TooMany { elements } => too_many(0.0, elements, size, None),
        _ => None,
    };
    too_many.unwrap_or_else(|| error.to_string())
}

fn with_holes(outer: Vec<outline::Point>, holes: &[Hole], size: &Grading<2>) -> Domain {
    let mut loops = vec![outer];
    loops.extend(holes.iter().map(|hole| outline::hole(hole, size)));
    Domain { loops, lines: Vec::new() }
}

pub(crate) fn outline_domain(of: &Outline, size: &Grading<2>) -> Domain {
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
    (body, voronoi): (&Body, &Voronoi),
    domain: &mut Domain,
    joints: &JointLines<'_>,
    size: &Grading<2>,
    materials: &[u32],
    default: u32,
) -> Result<Piece, Problem> {
    let problem = |message: String| Problem::new("voronoi", format!("[[body]] \"{}\": {message}", body.name));
    let tell = |error: OutlineError| problem(told(&error, size.size));
    let grains = Grains::new(domain, voronoi.grains, voronoi.seed, voronoi.rounds).map_err(tell)?;
    let across = (domain.area() / voronoi.grains as f64).sqrt();
    grains.cut(domain, size.size).map_err(tell)?;
    let (meshed, joints, lines) = joints.meshed(body, domain, size, body.seed, |error| {
        // The borders of such grains come closer to each other than the nodes on them.
        if across >= size.size {
            return tell(error.clone());
        }
        problem(format!(
            "the grains are too small for the mesh: their mean width of {} m is below the mesh size of {} m; take fewer grains or a smaller mesh_size",
            brief(across),
            brief(size.size)
        ))
    })?;
    let grain = grains.of_elements(&meshed).map_err(tell)?;
    let materials = if materials.is_empty() {
        vec![default; grain.len()]
    } else {
        let colours = colours::<2, 3>(&meshed.elements, &grain, materials.len());
        grain.iter().map(|&grain| materials[colours[grain as usize] as usize]).collect()
    };
    Ok(Piece { grains: grain, joints, lines, ..Piece::new(meshed, materials).map_err(problem)? })
}

/// The circles of a packing, and notes on its file. `reach`: the radius of the shape that is copied, if one
/// is.
fn circles(
    (body, packing): (&Body, &Packing),
    reach: Option<f64>,
    load: &mut Load<'_>,
) -> Result<(Vec<packing::Ball<2>>, Vec<String>), String> {
    if let Some(name) = &packing.file {
        let bytes = load(name).map_err(|why| format!("cannot read {name}: {why}"))?;
        return packing::read_flat(&bytes, name, body.scale);
    }
    let radius = packing.radius.or(reach.map(|radius| [radius; 2]));
    match (packing.count, radius, packing.within.as_ref().and_then(Room::new)) {
        (Some(count), Some(radius), Some(room)) => {
            packing::scatter(count, radius, &room, packing.gap, packing.seed)
                .map(|circles| (circles, Vec::new()))
                .map_err(|message| format!("{message}: take fewer or smaller ones, or a larger rectangle"))
        }
        _ => Ok((Vec::new(), Vec::new())),
    }
}

/// The loops of a copy of a shape.
fn loops_of_copy(body: &Body, motion: &Motion<2>, size: &Grading<2>) -> Vec<Vec<outline::Point>> {
    let circle = |disc: &Disc| outline::circle(motion.place(disc.centre), motion.scale * disc.radius, size);
    let corners = |points: &[outline::Point]| points.iter().map(|&point| motion.place(point)).collect();
    if let Some(ring) = &body.ring {
        return [ring.radius, ring.inner_radius]
            .map(|radius| circle(&Disc { centre: ring.centre, radius }))
            .into();
    }
    let (outer, holes) = match (&body.rectangle, &body.polygon) {
        (Some(rectangle), _) => (outline::rectangle(rectangle).unwrap_or_default(), &rectangle.holes[..]),
        (None, polygon) => {
            polygon.as_ref().map_or((Vec::new(), &[][..]), |of| (of.points.clone(), &of.holes))
        }
    };
    let mut loops = vec![corners(&outer)];
    loops.extend(holes.iter().map(|hole| match hole {
        Hole::Points(points) => corners(points),
        Hole::Disc(disc) => circle(disc),
    }));
    loops
}
