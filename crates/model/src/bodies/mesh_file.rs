//! Bodies from mesh files: triangles in the plane, or tetrahedra, with physical groups.

use std::collections::BTreeMap;

use fdem_io::numbers::{exact, grouped};
use fdem_io::{Cells, MeshBody, MeshFile};
use fdem_mesh::{Corners, sorted, sorted_facets};

use crate::bodies::{gmsh, materials};
use crate::shapes::outline::Point;
use crate::shapes::piece::{Piece, PieceGroup};
use crate::text::fault::{Problem, nearest, suggestion};
use crate::text::file::{Body, ModelFile};
use crate::text::included::Load;
use crate::text::schema::LARGEST;

/// Advice on triangles in Gmsh.
const TRIANGLES: &str =
    "a body is a mesh of triangles; in Gmsh set Mesh.RecombineAll = 0 and take \"Recombine Surface\" out";

/// Advice on elements of first order in Gmsh.
const FIRST_ORDER: &str =
    "elements have nodes at their corners only; in Gmsh set Mesh.ElementOrder = 1, or run gmsh with -order 1";

/// The materials of the groups of a mesh file, by their numbers. Names have been checked.
pub(crate) fn materials_of_groups(file: &ModelFile, body: &Body) -> BTreeMap<String, u32> {
    let number = |name: &String| materials::number(file, name).unwrap_or(0);
    body.groups.iter().map(|(group, name)| (group.clone(), number(name))).collect()
}

/// The file of a mesh that a body names; that of the mesh that Gmsh makes if the body names a geometry.
pub(crate) fn file_of(
    body: &Body,
    name: &str,
    dimensions: usize,
    load: &mut Load<'_>,
) -> Result<Vec<u8>, Problem> {
    let bytes = load(name).map_err(|why| Problem::new("mesh", format!("cannot read {name}: {why}")))?;
    match body.mesh_size {
        // Checked before: a geometry has a size, and a mesh has none.
        Some(size) => gmsh::mesh(&bytes, name, size, dimensions),
        None => Ok(bytes),
    }
}

/// Reads a mesh: all of its triangles, or those of the groups `only`.
///
/// `groups`: the material of the elements in each group; other elements have the material `default`.
///
/// # Errors
/// Files without a mesh of triangles in the plane; groups that the file does not have.
pub(crate) fn read_flat(
    bytes: &[u8],
    name: &str,
    only: Option<&[String]>,
    groups: &BTreeMap<String, u32>,
    default: u32,
) -> Result<Piece, Problem> {
    let mesh = read(bytes, name)?;
    check_flat(&mesh, name)?;
    let words =
        Words { group: "surface group", element: "triangle", measure: "area", facet: ["line", "lines"] };
    piece(&mesh, &mesh.triangles, &mesh.segments, planar, &words, (name, only, groups, default))
}

/// Like [`read_flat`], for tetrahedra.
pub(crate) fn read_space(
    bytes: &[u8],
    name: &str,
    only: Option<&[String]>,
    groups: &BTreeMap<String, u32>,
    default: u32,
) -> Result<Piece<3, 4>, Problem> {
    let mesh = read(bytes, name)?;
    if mesh.tetrahedra.is_empty() {
        let found =
            if mesh.triangles.is_empty() { "has no elements" } else { "has triangles and no tetrahedra" };
        return Err(Problem {
            help: Some(format!("in three dimensions a body is a mesh of tetrahedra; {SURFACES}")),
            ..Problem::new("mesh", format!("{name} {found}"))
        });
    }
    let words = Words {
        group: "volume group",
        element: "tetrahedron",
        measure: "volume",
        facet: ["triangle", "triangles"],
    };
    piece(&mesh, &mesh.tetrahedra, &mesh.triangles, |point| point, &words, (name, only, groups, default))
}

/// The triangles of a file that has a surface.
pub(crate) fn triangles(load: &mut Load<'_>, name: &str) -> Result<Vec<[[f64; 3]; 3]>, Problem> {
    let bytes = load(name).map_err(|why| Problem::new("surface", format!("cannot read {name}: {why}")))?;
    let mesh = read(&bytes, name).map_err(|problem| Problem { key: "surface".to_owned(), ..problem })?;
    if mesh.triangles.is_empty() {
        return Err(Problem::new("surface", format!("{name} has no triangles")));
    }
    let corners = |nodes: &[u32; 3]| nodes.map(|node| mesh.points[node as usize]);
    Ok(mesh.triangles.nodes.iter().map(corners).collect())
}

/// Whether a file has a mesh of tetrahedra, or a surface that is in no plane z = constant; `None` if it
/// cannot be read.
pub(crate) fn is_in_space(bytes: &[u8], name: &str) -> Option<bool> {
    let mesh = read(bytes, name).ok()?;
    let is_flat = mesh.points.windows(2).all(|pair| pair[0][2] == pair[1][2]);
    Some(!mesh.tetrahedra.is_empty() || !mesh.triangles.is_empty() && !is_flat)
}

/// Whether the format of a file has surfaces only.
pub(crate) fn is_surface(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    [".stl", ".obj", ".stl.gz", ".obj.gz"].iter().any(|ending| name.ends_with(ending))
}

fn read(bytes: &[u8], name: &str) -> Result<MeshFile, Problem> {
    let (bytes, _) = fdem_io::unpack(bytes.into(), |_| true)
        .map_err(|error| Problem::new("mesh", format!("cannot read {name}: {error}")))?;
    let mesh = fdem_io::read_mesh(&bytes, name).map_err(|error| {
        let message = error.to_string();
        let help = message.contains("second order").then(|| FIRST_ORDER.to_owned());
        Problem { help, ..Problem::new("mesh", message) }
    })?;
    let too_large = |point: &[f64; 3]| point.iter().copied().find(|x| x.abs() > LARGEST);
    if let Some((number, x)) = (1_u64..).zip(&mesh.points).find_map(|(k, point)| Some((k, too_large(point)?)))
    {
        let message = format!(
            "{name}: node {} of the file has the coordinate {}: coordinates are in metres and from -{LARGEST:e} to {LARGEST:e}",
            grouped(number),
            exact(x)
        );
        return Err(Problem::new("mesh", message));
    }
    Ok(mesh)
}

/// Help for a file with a surface in place of a mesh.
pub(crate) const SURFACES: &str =
    "a closed surface of triangles is meshed with surface = \"…\" instead of mesh";

/// Words of messages.
struct Words {
    group: &'static str,
    element: &'static str,
    measure: &'static str,
    /// A facet, and several.
    facet: [&'static str; 2],
}

/// The elements, facets and groups of a file as a body.
fn piece<const D: usize, const N: usize>(
    mesh: &MeshFile,
    elements: &Cells<N>,
    facets: &Cells<D>,
    place: impl Fn([f64; 3]) -> [f64; D],
    words: &Words,
    (name, only, groups, default): (&str, Option<&[String]>, &BTreeMap<String, u32>, u32),
) -> Result<Piece<D, N>, Problem>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let labels: Vec<String> = mesh.bodies.iter().map(label).collect();
    let known = names(&labels, &elements.bodies);
    for (key, wanted) in only
        .into_iter()
        .flatten()
        .map(|wanted| ("only".to_owned(), wanted))
        .chain(groups.keys().map(|wanted| (format!("groups.{wanted}"), wanted)))
    {
        if !known.contains(&wanted.as_str()) {
            return Err(Problem {
                key,
                message: format!("{name} has no {} \"{wanted}\"", words.group),
                help: Some(advice(wanted, &known, words)),
            });
        }
    }
    let mut piece = Piece::default();
    let mut turned = (0, 0);
    let mut numbers: Vec<Option<u32>> = vec![None; mesh.points.len()];
    let taken = |body: u32| only.is_none_or(|only| only.contains(&labels[body as usize]));
    for ((nodes, &body), &number) in elements.nodes.iter().zip(&elements.bodies).zip(&elements.numbers) {
        if !taken(body) {
            continue;
        }
        let corners = nodes.map(|node| place(mesh.points[node as usize]));
        let measure = corners.measure();
        let cube = std::iter::repeat_n(longest(&corners), D).product::<f64>();
        if 2.0 * measure.abs() <= 1e-9 * cube {
            let Words { element, measure, .. } = words;
            return Err(Problem::new(
                "mesh",
                format!("{name}: element {number} ({element}) has no {measure}"),
            ));
        }
        let mut nodes = nodes.map(|node| {
            *numbers[node as usize].get_or_insert_with(|| {
                piece.nodes.push(place(mesh.points[node as usize]));
                piece.nodes.len() as u32 - 1
            })
        });
        if measure < 0.0 {
            nodes.swap(N - 2, N - 1);
            turned = (turned.0 + 1, if turned.0 == 0 { number } else { turned.1 });
        }
        let label = &labels[body as usize];
        let element = piece.elements.len() as u32;
        piece.elements.push(nodes);
        piece.materials.push(groups.get(label).copied().unwrap_or(default));
        piece.groups.entry(label.clone()).or_default().elements.push(element);
    }
    // Triangles that are numbered the other way round are those of a surface that is seen from behind.
    if D == 3 && turned.0 > 0 {
        piece.notes.push(format!(
            "{name}: {} of its {} tetrahedra have a negative volume, the first is element {}: their nodes are taken in the other order",
            grouped(turned.0),
            grouped(piece.elements.len() as u64),
            turned.1
        ));
    }
    if only.is_none() {
        piece.notes.extend(loose(facets, elements, &labels, words).map(|note| format!("{name}: {note}")));
    }
    for (nodes, &body) in facets.nodes.iter().zip(&facets.bodies) {
        let own = nodes.map(|node| numbers[node as usize].unwrap_or(u32::MAX));
        // A facet of another body has nodes that this one has not.
        if !own.contains(&u32::MAX) {
            let group: &mut PieceGroup<D> = piece.groups.entry(labels[body as usize].clone()).or_default();
            group.facets.push(own);
        }
    }
    Ok(piece)
}

/// The group that was probably meant, and the groups that there are.
fn advice(wanted: &str, known: &[&str], words: &Words) -> String {
    let all = suggestion("", known, &format!("{} in it", words.group));
    match nearest(wanted, known.iter().copied()) {
        Some(name) => format!("did you mean \"{name}\"? {all}"),
        None => all,
    }
}

/// Reports facets that belong to no element: boundaries do not act on them.
fn loose<const D: usize, const N: usize>(
    facets: &Cells<D>,
    elements: &Cells<N>,
    labels: &[String],
    words: &Words,
) -> Option<String>
where
    [[f64; D]; N]: Corners<D, N>,
{
    if facets.is_empty() {
        return None;
    }
    let known = sorted_facets::<D, N>(&elements.nodes);
    let is_known = |facet: [u32; D]| known.binary_search_by_key(&sorted(facet), |(nodes, _)| *nodes).is_ok();
    let mut loose = (0..facets.nodes.len()).filter(|&k| !is_known(facets.nodes[k]));
    let first = loose.next()?;
    let count = loose.count() + 1;
    let Words { facet: [one, more], element, .. } = words;
    let label = &labels[facets.bodies[first] as usize];
    let number = facets.numbers[first];
    Some(if count == 1 {
        format!(
            "element {number} ({one} of the group \"{label}\") belongs to no {element}: boundaries do not act on it"
        )
    } else {
        format!(
            "{} {more} belong to no {element}, the first is element {number} of the group \"{label}\": boundaries do not act on them",
            grouped(count as u64)
        )
    })
}

/// The longest edge of an element.
fn longest<const D: usize, const N: usize>(corners: &[[f64; D]; N]) -> f64 {
    let mut longest = 0.0_f64;
    for (k, a) in corners.iter().enumerate() {
        for b in &corners[k + 1..] {
            let squared: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
            longest = longest.max(squared.sqrt());
        }
    }
    longest
}

fn check_flat(mesh: &MeshFile, name: &str) -> Result<(), Problem> {
    let refuse = |what: String, help: &str| {
        Err(Problem { help: Some(help.to_owned()), ..Problem::new("mesh", format!("{name} {what}")) })
    };
    let flat = "in two dimensions a body is a mesh of triangles in the plane z = 0";
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
