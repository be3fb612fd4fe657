//! Bodies from mesh files: triangles in the plane, with physical groups.

use std::collections::BTreeMap;

use fdem_io::{Mesh, MeshBody};

use crate::model::fault::suggestion;
use crate::model::outline::{Point, distance, twice_area};
use crate::model::piece::{Group, Piece};
use crate::numbers::grouped;

/// Advice on triangles in Gmsh.
const TRIANGLES: &str =
    "a body is a mesh of triangles; in Gmsh set Mesh.RecombineAll = 0 and take \"Recombine Surface\" out";

/// Advice on elements of first order in Gmsh.
const FIRST_ORDER: &str =
    "elements have nodes at their corners only; in Gmsh set Mesh.ElementOrder = 1, or run gmsh with -order 1";

/// A problem of a body, and the key that it belongs to.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) key: String,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

impl Problem {
    pub(crate) fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into(), help: None }
    }
}

/// Reads a mesh: all of its triangles, or those of the groups `only`.
///
/// `material` is a material for each name in `groups`, by position; [`Piece::materials`] are those, or `default`.
///
/// # Errors
/// Files without a mesh of triangles in the plane; groups that the file does not have.
pub(crate) fn read(
    bytes: &[u8],
    name: &str,
    only: Option<&[String]>,
    groups: &BTreeMap<String, u32>,
    default: u32,
) -> Result<Piece, Problem> {
    let (bytes, _) = fdem_io::unpack(bytes.into(), |_| true)
        .map_err(|error| Problem::new("mesh", format!("cannot read {name}: {error}")))?;
    let mesh = fdem_io::read_mesh(&bytes, name).map_err(|error| {
        let message = error.to_string();
        let help = message.contains("second order").then(|| FIRST_ORDER.to_owned());
        Problem { help, ..Problem::new("mesh", message) }
    })?;
    check_kind(&mesh, name)?;
    let labels: Vec<String> = mesh.bodies.iter().map(label).collect();
    let surfaces = names(&labels, &mesh.triangles.bodies);
    for (key, wanted) in only
        .into_iter()
        .flatten()
        .map(|wanted| ("only".to_owned(), wanted))
        .chain(groups.keys().map(|wanted| (format!("groups.{wanted}"), wanted)))
    {
        if !surfaces.contains(&wanted.as_str()) {
            return Err(Problem {
                key,
                message: format!("{name} has no surface group \"{wanted}\""),
                help: suggestion(wanted, &surfaces, "surface group in it"),
            });
        }
    }
    let mut piece = Piece::default();
    let mut numbers: Vec<Option<u32>> = vec![None; mesh.points.len()];
    let taken = |body: u32| only.is_none_or(|only| only.contains(&labels[body as usize]));
    for ((nodes, &body), &number) in
        mesh.triangles.nodes.iter().zip(&mesh.triangles.bodies).zip(&mesh.triangles.numbers)
    {
        if !taken(body) {
            continue;
        }
        let [a, b, c] = nodes.map(|node| planar(mesh.points[node as usize]));
        let area = twice_area(a, b, c);
        let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
        if area.abs() <= 1e-9 * longest * longest {
            return Err(Problem::new("mesh", format!("{name}: element {number} (triangle) has no area")));
        }
        let triangle = nodes.map(|node| {
            *numbers[node as usize].get_or_insert_with(|| {
                piece.nodes.push(planar(mesh.points[node as usize]));
                piece.nodes.len() as u32 - 1
            })
        });
        let triangle = if area > 0.0 { triangle } else { [triangle[0], triangle[2], triangle[1]] };
        let label = &labels[body as usize];
        let element = piece.elements.len() as u32;
        piece.elements.push(triangle);
        piece.materials.push(groups.get(label).copied().unwrap_or(default));
        piece.groups.entry(label.clone()).or_default().elements.push(element);
    }
    for (nodes, &body) in mesh.segments.nodes.iter().zip(&mesh.segments.bodies) {
        // A curve of another body has nodes that this one has not.
        if let [Some(a), Some(b)] = nodes.map(|node| numbers[node as usize]) {
            let group: &mut Group = piece.groups.entry(labels[body as usize].clone()).or_default();
            group.curve.push([a, b]);
        }
    }
    piece.curves = names(&labels, &mesh.segments.bodies).into_iter().map(str::to_owned).collect();
    Ok(piece)
}

fn check_kind(mesh: &Mesh, name: &str) -> Result<(), Problem> {
    let refuse = |what: String, help: &str| {
        Err(Problem { help: Some(help.to_owned()), ..Problem::new("mesh", format!("{name} {what}")) })
    };
    let flat = "a body is a mesh of triangles in the plane z = 0";
    let several = |count: u64, one: &str, more: &str| {
        format!("has {} {}", grouped(count), if count == 1 { one } else { more })
    };
    if !mesh.tetrahedra.is_empty() {
        let count = mesh.tetrahedra.len() as u64;
        return refuse(several(count, "tetrahedron", "tetrahedra"), flat);
    }
    if mesh.source.quadrilaterals > 0 {
        return refuse(several(mesh.source.quadrilaterals, "quadrilateral", "quadrilaterals"), TRIANGLES);
    }
    if mesh.dimensions == 3 {
        return refuse("is not flat: it has z that are not 0".to_owned(), flat);
    }
    if mesh.triangles.is_empty() {
        return refuse("has no triangles".to_owned(), flat);
    }
    Ok(())
}

fn planar([x, y, _]: [f64; 3]) -> Point {
    [x, y]
}

/// The name of a group in model files: its name in the mesh file, or its number.
fn label(body: &MeshBody) -> String {
    match (&body.name, body.number) {
        (Some(name), _) => name.clone(),
        (None, Some(number)) => number.to_string(),
        (None, None) => "rest".to_owned(),
    }
}

/// The labels of those bodies that have elements of a kind.
fn names<'a>(labels: &'a [String], bodies: &[u32]) -> Vec<&'a str> {
    let mut used = vec![false; labels.len()];
    for &body in bodies {
        used[body as usize] = true;
    }
    labels.iter().zip(used).filter(|(_, used)| *used).map(|(label, _)| label.as_str()).collect()
}
