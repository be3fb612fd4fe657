//! Bodies from mesh files: triangles in the plane, or tetrahedra, with physical groups.

use std::collections::BTreeMap;

use fdem_io::numbers::{exact, grouped};
use fdem_io::{Cells, MeshFile, MeshGroup};
use fdem_mesh::{Corners, sorted, sorted_facets};

use crate::bodies::{gmsh, materials};
use crate::shapes::outline::Point;
use crate::shapes::piece::{Piece, PieceGroup};
use crate::text::fault::{Problem, nearest, suggestion};
use crate::text::file::{Body, ModelFile};
use crate::text::included::Load;
use crate::text::schema::LARGEST;

/// The materials of the groups of a mesh file, by their numbers. Names have been checked.
pub(crate) fn materials_of_groups(file: &ModelFile, body: &Body) -> BTreeMap<String, u32> {
    let number = |name: &String| materials::number(file, name).unwrap_or(0);
    body.groups.iter().map(|(group, name)| (group.clone(), number(name))).collect()
}

/// Length of the unit of the file of a body, m.
pub(crate) fn scale_of(body: &Body) -> f64 {
    body.scale.unwrap_or(1.0)
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
        Some(size) => gmsh::mesh(&bytes, name, size / scale_of(body), dimensions),
        None => Ok(bytes),
    }
}

/// Reads a mesh: all of its triangles, or those of the groups `only`.
///
/// `scale`: the length of the unit of the file, m. `groups`: the material of the elements in each group;
/// other elements have the material `default`.
///
/// # Errors
/// Files without a mesh of triangles in the plane; groups that the file does not have.
pub(crate) fn read_flat(
    bytes: &[u8],
    (name, scale): (&str, f64),
    only: Option<&[String]>,
    (groups, default): (&BTreeMap<String, u32>, u32),
    load: &mut Load<'_>,
) -> Result<Piece, Problem> {
    let mesh = read(bytes, name, scale, load)?;
    check_flat(&mesh, name)?;
    let words = Words {
        group: "surface group",
        element: "triangle",
        elements: "triangles",
        measure: "area",
        facet: ["line", "lines"],
    };
    let parts = Parts {
        elements: &mesh.triangles,
        facets: &mesh.segments,
        elements_of: |group| &group.triangles,
        cells_of: |group| &group.segments,
        facets_of: |group| &group.edges,
        place: planar,
        words,
    };
    piece(&mesh, &parts, (name, only, groups, default))
}

/// Like [`read_flat`], for tetrahedra.
pub(crate) fn read_space(
    bytes: &[u8],
    (name, scale): (&str, f64),
    only: Option<&[String]>,
    (groups, default): (&BTreeMap<String, u32>, u32),
    load: &mut Load<'_>,
) -> Result<Piece<3, 4>, Problem> {
    let mesh = read(bytes, name, scale, load)?;
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
        elements: "tetrahedra",
        measure: "volume",
        facet: ["triangle", "triangles"],
    };
    let parts = Parts {
        elements: &mesh.tetrahedra,
        facets: &mesh.triangles,
        elements_of: |group| &group.tetrahedra,
        cells_of: |group| &group.triangles,
        facets_of: |group| &group.faces,
        place: |point| point,
        words,
    };
    piece(&mesh, &parts, (name, only, groups, default))
}

/// The triangles of a file that has a surface. `scale`: the length of its unit, m.
pub(crate) fn triangles(load: &mut Load<'_>, name: &str, scale: f64) -> Result<Vec<[[f64; 3]; 3]>, Problem> {
    let bytes = load(name).map_err(|why| Problem::new("surface", format!("cannot read {name}: {why}")))?;
    let mesh = read(&bytes, name, scale, load)
        .map_err(|problem| Problem { key: "surface".to_owned(), ..problem })?;
    if mesh.triangles.is_empty() {
        return Err(Problem::new("surface", format!("{name} has no triangles")));
    }
    let corners = |nodes: &[u32; 3]| nodes.map(|node| mesh.points[node as usize]);
    Ok(mesh.triangles.nodes.iter().map(corners).collect())
}

/// Whether a file has a mesh of tetrahedra, or a surface that is in no plane z = constant; `None` if it
/// cannot be read.
pub(crate) fn is_in_space(name: &str, load: &mut Load<'_>) -> Option<bool> {
    let bytes = load(name).ok()?;
    let mesh = read(&bytes, name, 1.0, load).ok()?;
    let is_flat = mesh.points.windows(2).all(|pair| pair[0][2] == pair[1][2]);
    Some(!mesh.tetrahedra.is_empty() || !mesh.triangles.is_empty() && !is_flat)
}

/// Whether the format of a file has surfaces only.
pub(crate) fn is_surface(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    [".stl", ".obj", ".stl.gz", ".obj.gz"].iter().any(|ending| name.ends_with(ending))
}

fn read(bytes: &[u8], name: &str, scale: f64, load: &mut Load<'_>) -> Result<MeshFile, Problem> {
    let (bytes, _) = fdem_io::unpack(bytes.into(), |_| true)
        .map_err(|error| Problem::new("mesh", format!("cannot read {name}: {error}")))?;
    let mut mesh = fdem_io::read_mesh_with(&bytes, name, load)
        .map_err(|error| Problem::new("mesh", error.to_string()))?;
    mesh.points.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
    let too_large = |point: &[f64; 3]| point.iter().copied().find(|x| x.abs() > LARGEST);
    if let Some((number, x)) = (1_u64..).zip(&mesh.points).find_map(|(k, point)| Some((k, too_large(point)?)))
    {
        let message = format!(
            "{name}: node {} of the file has the coordinate {}: coordinates are in metres, unless \"scale\" says otherwise, and from -{LARGEST:e} to {LARGEST:e}",
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
    elements: &'static str,
    measure: &'static str,
    /// A facet, and several.
    facet: [&'static str; 2],
}

/// The parts of a mesh that are the elements and the facets of a body of `D` dimensions.
struct Parts<'a, const D: usize, const N: usize> {
    elements: &'a Cells<N>,
    facets: &'a Cells<D>,
    /// The elements of a group.
    elements_of: fn(&MeshGroup) -> &[u32],
    /// The elements of a group that are facets of the body.
    cells_of: fn(&MeshGroup) -> &[u32],
    /// The facets of a group that are no elements of the file.
    facets_of: fn(&MeshGroup) -> &[[u32; D]],
    place: fn([f64; 3]) -> [f64; D],
    words: Words,
}

/// Checks that the file has the groups that a model names. `known`: the names of its groups.
fn check_wanted(
    (name, only, groups): (&str, Option<&[String]>, &BTreeMap<String, u32>),
    known: &[&str],
    words: &Words,
) -> Result<(), Problem> {
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
                help: Some(advice(wanted, known, words)),
            });
        }
    }
    Ok(())
}

/// The elements, facets and groups of a file as a body.
fn piece<const D: usize, const N: usize>(
    mesh: &MeshFile,
    parts: &Parts<'_, D, N>,
    (name, only, groups, default): (&str, Option<&[String]>, &BTreeMap<String, u32>, u32),
) -> Result<Piece<D, N>, Problem>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let &Parts { elements, facets, place, ref words, .. } = parts;
    check_rest(mesh, name)?;
    let labels: Vec<String> = mesh.bodies.iter().map(|body| label(body.name.as_ref(), body.number)).collect();
    let further: Vec<(String, &MeshGroup)> =
        mesh.groups.iter().map(|group| (label(group.name.as_ref(), group.number), group)).collect();
    let mut known = names(&labels, &elements.bodies);
    let with_elements = further.iter().filter(|(_, group)| !(parts.elements_of)(group).is_empty());
    known.extend(with_elements.map(|(label, _)| label.as_str()));
    known.sort_unstable();
    known.dedup();
    check_wanted((name, only, groups), &known, words)?;
    let (taken, given) = chosen(parts, (&labels, &further), (name, only, groups))?;
    let mut piece = Piece::default();
    let mut turned = (0, 0);
    let mut numbers: Vec<Option<u32>> = vec![None; mesh.points.len()];
    // For each element of the file, that of the body.
    let mut own = vec![u32::MAX; elements.len()];
    for (at, ((nodes, &body), &number)) in
        elements.nodes.iter().zip(&elements.bodies).zip(&elements.numbers).enumerate()
    {
        if !taken[at] {
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
        piece.materials.push(given[at].and_then(|group| groups.get(group)).copied().unwrap_or(default));
        own[at] = element;
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
    let within = |nodes: &[u32; D]| {
        let own = nodes.map(|node| numbers[node as usize].unwrap_or(u32::MAX));
        // A facet of another body has nodes that this one has not.
        (!own.contains(&u32::MAX)).then_some(own)
    };
    for (nodes, &body) in facets.nodes.iter().zip(&facets.bodies) {
        if let Some(facet) = within(nodes) {
            piece.groups.entry(labels[body as usize].clone()).or_default().facets.push(facet);
        }
    }
    for (label, group) in &further {
        let into: &mut PieceGroup<D> = piece.groups.entry(label.clone()).or_default();
        let of_body = |&element: &u32| Some(own[element as usize]).filter(|own| *own != u32::MAX);
        into.elements.extend((parts.elements_of)(group).iter().filter_map(of_body));
        into.nodes.extend(group.nodes.iter().filter_map(|&node| numbers[node as usize]));
        let cells = (parts.cells_of)(group).iter().map(|&cell| &facets.nodes[cell as usize]);
        into.facets.extend(cells.chain((parts.facets_of)(group)).filter_map(within));
    }
    // The elements of a body and of a set of its name are one group.
    for group in piece.groups.values_mut() {
        group.elements.sort_unstable();
        group.elements.dedup();
        group.facets.sort_by_key(|&facet| sorted(facet));
        group.facets.dedup_by_key(|facet| sorted(*facet));
    }
    piece
        .groups
        .retain(|_, group| !(group.elements.is_empty() && group.nodes.is_empty() && group.facets.is_empty()));
    piece.about_file = about(mesh, name, &piece, words);
    Ok(piece)
}

/// For each element, whether it is taken, and the group that gives its material.
///
/// # Errors
/// An element in two groups that have two materials.
fn chosen<'a, const D: usize, const N: usize>(
    parts: &Parts<'_, D, N>,
    (labels, further): (&'a [String], &'a [(String, &MeshGroup)]),
    (name, only, groups): (&str, Option<&[String]>, &BTreeMap<String, u32>),
) -> Result<(Vec<bool>, Vec<Option<&'a str>>), Problem> {
    let elements = parts.elements;
    let mut taken = vec![only.is_none(); elements.len()];
    let mut given: Vec<Option<&'a str>> = vec![None; elements.len()];
    let of_bodies = (0..).zip(&elements.bodies).map(|(element, &body)| (element, &labels[body as usize]));
    let of_groups = further.iter().flat_map(|(label, group)| {
        (parts.elements_of)(group).iter().map(move |&element| (element as usize, label))
    });
    for (element, label) in of_bodies.chain(of_groups) {
        taken[element] |= only.is_some_and(|only| only.contains(label));
        let Some(material) = groups.get(label) else { continue };
        match given[element].replace(label) {
            Some(first) if groups.get(first) != Some(material) => {
                return Err(Problem {
                    help: Some(
                        "give a material to one of the two, or change the sets of the file".to_owned(),
                    ),
                    ..Problem::new(
                        format!("groups.{label}"),
                        format!(
                            "{name}: element {} ({}) is in the groups \"{first}\" and \"{label}\", which have two materials",
                            elements.numbers[element], parts.words.element
                        ),
                    )
                });
            }
            _ => {}
        }
    }
    Ok((taken, given))
}

/// Describes the file of a mesh: its groups as the body has them, and the parts that are left out or cut.
fn about<const D: usize, const N: usize>(
    mesh: &MeshFile,
    name: &str,
    piece: &Piece<D, N>,
    words: &Words,
) -> Vec<String> {
    let mut lines = vec![format!("{name}: groups are {}", mesh.source.bodies_from)];
    lines.extend(piece.groups.iter().map(|(label, group)| {
        let Words { element, elements, facet: [facet, facets], .. } = words;
        let counts = [
            (group.elements.len(), *element, *elements),
            (group.facets.len(), *facet, *facets),
            (group.nodes.len(), "node", "nodes"),
        ];
        let counts = counts.into_iter().filter(|(count, ..)| *count > 0);
        let counts: Vec<String> = counts
            .map(|(count, one, more)| {
                format!("{} {}", grouped(count as u64), if count == 1 { one } else { more })
            })
            .collect();
        format!("  {label}: {}", counts.join(", "))
    }));
    lines.extend(mesh.source.notes().into_iter().map(|note| format!("  {note}")));
    lines
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

/// Name of the elements that are in no group.
const REST: &str = "rest";

/// Refuses a group that has the name of the elements without a group, if there are such elements.
fn check_rest(mesh: &MeshFile, name: &str) -> Result<(), Problem> {
    let names =
        || mesh.bodies.iter().map(|body| &body.name).chain(mesh.groups.iter().map(|group| &group.name));
    let has_rest = mesh.bodies.iter().any(|body| body.name.is_none() && body.number.is_none());
    if has_rest && names().flatten().any(|name| name == REST) {
        let message =
            format!("{name} has a group \"{REST}\", and elements in no group, which go by that name");
        return Err(Problem { help: Some("rename the group".to_owned()), ..Problem::new("mesh", message) });
    }
    Ok(())
}

/// The name of a group in model files: its name in the mesh file, or its number.
fn label(name: Option<&String>, number: Option<i64>) -> String {
    match (name, number) {
        (Some(name), _) => name.clone(),
        (None, Some(number)) => number.to_string(),
        (None, None) => REST.to_owned(),
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
