//! Bodies in space: how the shapes of a model file are meshed.

use std::f64::consts::PI;

use fdem_mesh::tetrahedra::{MeshError, Size, Surface, Tetrahedra, graded};
use fdem_mesh::triangles::colours;
use fdem_mesh::{Grading, shapes};

use crate::model::bodies::Load;
use crate::model::file::{Block, Body, Extrusion, ModelFile, Outline, Voronoi};
use crate::model::materials;
use crate::model::mesh_file::{self, Problem, materials_of_groups};
use crate::model::outline::{self, area};
use crate::model::piece::Piece;
use crate::model::plane::outline_domain;
use crate::model::refine::grading;

/// Angle between the normals of two triangles of a surface from which they are of two faces, degrees.
const CREASE: f64 = 30.0;

/// Volume of a tetrahedron over the cube of the mean edge.
pub(crate) const VOLUME: f64 = 0.1;

/// The meshed pieces of a body: one, unless it is a packing.
pub(crate) fn pieces(
    file: &ModelFile,
    body: &Body,
    load: &mut Load<'_>,
) -> Result<Vec<Piece<3, 4>>, Problem> {
    // Checked before: names are known, and there is a size.
    let material = materials::number(file, &body.material).unwrap_or(0);
    if let Some(name) = &body.mesh {
        let bytes = mesh_file::file_of(body, name, 3, load)?;
        let groups = materials_of_groups(file, body);
        let mut piece = mesh_file::read_space(&bytes, name, body.only.as_deref(), &groups, material)?;
        piece.find_outline().map_err(|message| Problem::new("mesh", format!("{name}: {message}")))?;
        return Ok(vec![piece]);
    }
    let grading = grading::<3>(body);
    let (key, surface) = surface(body, &|place| grading.at(place), load)?;
    let problem = |error: MeshError| Problem::new(key, format!("[[body]] \"{}\": {error}", body.name));
    let Shape { surface, names } = surface.map_err(problem)?;
    let meshed = graded(&surface, &grading, body.seed).map_err(problem)?;
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
    let piece = piece(meshed, &names, materials, body.voronoi.is_some());
    Ok(vec![piece.map_err(|message| Problem::new(key, format!("[[body]] \"{}\": {message}", body.name)))?])
}

/// The surface of a body, and the names of the groups of its faces.
struct Shape {
    surface: Surface,
    /// Names of each face.
    names: Vec<Vec<String>>,
}

impl Shape {
    /// A shape whose faces have the names that its surface gives them.
    fn named(surface: Surface) -> Self {
        let names = surface.names.iter().map(|name| vec![name.clone()]).collect();
        Self { surface, names }
    }

    /// A shape whose faces are `face-1`, `face-2`, ….
    fn numbered(surface: Surface) -> Self {
        let count = surface.faces.iter().max().map_or(0, |most| most + 1);
        let names = (1..=count).map(|number| vec![format!("face-{number}")]).collect();
        Self { surface, names }
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
        let of = &voronoi.outline;
        let outline = if let Some(of) = &of.block {
            shapes::cuboid(of.min, of.max).map(Shape::named)
        } else {
            let points = of.polyhedron.as_ref().map_or(&[][..], |of| &of.points);
            shapes::hull(points).map(Shape::numbered)
        };
        let grains = outline.and_then(|shape| {
            let surface = shapes::grains(&shape.surface, voronoi.grains, voronoi.seed)?;
            Ok(Shape { surface, ..shape })
        });
        ("voronoi", grains)
    } else if let Some(name) = &body.surface {
        let triangles = mesh_file::triangles(load, name)?;
        ("surface", Surface::from_triangles(&triangles, CREASE).map(Shape::numbered))
    } else {
        return Err(Problem::new("name", "a body without shape"));
    })
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
    Ok(Shape { surface, names })
}

/// A mesh that was made here, with the groups of its faces.
fn piece(
    meshed: Tetrahedra,
    names: &[Vec<String>],
    materials: Vec<u32>,
    has_grains: bool,
) -> Result<Piece<3, 4>, String> {
    let Tetrahedra { nodes, elements, regions, facets, faces } = meshed;
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

/// Least and largest coordinates of a body, about; `None` if its shape does not tell.
pub(crate) fn bounds(body: &Body) -> Option<[[f64; 3]; 2]> {
    let around = |points: &[[f64; 3]], by: f64| {
        let [low, high] = fdem_mesh::bounds(points.iter().copied());
        [low.map(|x| x - by), high.map(|x| x + by)]
    };
    let of_block = |of: &Block| [of.min, of.max];
    Some(if let Some(of) = &body.block {
        of_block(of)
    } else if let Some(of) = &body.cylinder {
        around(&[of.from, of.to], of.radius)
    } else if let Some(of) = &body.tube {
        around(&[of.from, of.to], of.radius)
    } else if let Some(of) = &body.sphere {
        around(&[of.centre], of.radius)
    } else if let Some(of) = &body.polyhedron {
        around(&of.points, 0.0)
    } else if let Some(of) = &body.extrusion {
        let [low, high] = outline_domain(&of.outline, &Grading::even(f64::MAX)).bounds();
        [[low[0], low[1], of.from], [high[0], high[1], of.to]]
    } else {
        let of = &body.voronoi.as_ref()?.outline;
        match (&of.block, &of.polyhedron) {
            (Some(of), _) => of_block(of),
            (None, of) => around(&of.as_ref()?.points, 0.0),
        }
    })
}

/// The number of elements with edges of `size` that a body has, about; `None` if its shape does not tell.
pub(crate) fn elements(body: &Body, size: f64) -> Option<f64> {
    let distance = |a: [f64; 3], b: [f64; 3]| {
        let squared: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
        squared.sqrt()
    };
    let volume = if let Some(of) = &body.block {
        (0..3).map(|axis| of.max[axis] - of.min[axis]).product()
    } else if let Some(of) = &body.cylinder {
        PI * of.radius * of.radius * distance(of.from, of.to)
    } else if let Some(of) = &body.tube {
        PI * (of.radius * of.radius - of.inner_radius * of.inner_radius) * distance(of.from, of.to)
    } else if let Some(of) = &body.sphere {
        4.0 / 3.0 * PI * of.radius.powi(3)
    } else if let Some(of) = &body.extrusion {
        outline_area(&of.outline)? * (of.to - of.from)
    } else if let Some(Voronoi { outline: Outline { block: Some(of), .. }, .. }) = &body.voronoi {
        (0..3).map(|axis| of.max[axis] - of.min[axis]).product()
    } else {
        return None;
    };
    Some(volume.max(0.0) / (VOLUME * size.powi(3)))
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
