//! How much too stiff triangles and tetrahedra of constant strain are in bending, and where a model bends.
//!
//! Triangles were measured against beam theory (`tests/model/locking.rs`; the table is in the book),
//! tetrahedra against pure bending (the case "locking" of the ladder).

use std::ops::Range;

use fdem_io::numbers::brief;
use fdem_mesh::{Corners, bounds, edges};
use fdem_simulation::{Model, Plane, Target};

use crate::advice::deforming;
use crate::shapes::outline::{distance, twice_area};
use crate::shapes::placed::Placed;

/// Length of a member over its thickness from which it bends.
const SLENDER: f64 = 5.0;

/// Number of elements through a member that is enough for bending.
const ENOUGH: f64 = 8.0;

/// Share by which a member may be too stiff in bending.
const STIFF: f64 = 0.05;

/// Poisson's ratio in plane strain and in space from which elements lock.
const NEARLY_INCOMPRESSIBLE: f64 = 0.45;

/// Share of the length of a member that, when it is held or driven, does not let it bend.
const HELD: f64 = 0.5;

/// Poisson's ratios in plane strain of the rows of [`EXCESS`].
const RATIOS: [f64; 8] = [0.0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.495, 0.499];

/// Elements through the thickness of the columns of [`EXCESS`].
const ELEMENTS: [f64; 4] = [2.0, 4.0, 8.0, 16.0];

/// Measured stiffness of a cantilever over that of beam theory with shear, less 1, in percent: the means of
/// three meshes.
const EXCESS: [[f64; 4]; 8] = [
    [58.8, 11.6, 2.8, 0.7],
    [51.4, 9.8, 2.4, 0.6],
    [50.8, 9.3, 2.2, 0.6],
    [59.3, 10.3, 2.5, 0.6],
    [79.1, 13.5, 3.3, 0.8],
    [162.1, 31.5, 8.3, 2.1],
    [202.7, 43.7, 12.3, 3.2],
    [267.0, 72.7, 24.3, 7.6],
];

/// Stiffness of a member in bending over the true one, less 1, with this number of elements through its
/// thickness.
///
/// Logarithms are linear between the measured values: in the number of elements, and in the ratio of the two
/// moduli of the plane, to which 1/(1 - 2 nu) is proportional. Plane stress is plane strain with nu/(1 + nu).
pub(crate) fn excess(plane: Plane, poissons_ratio: f64, elements: f64) -> f64 {
    let nu = match plane {
        Plane::Stress => poissons_ratio / (1.0 + poissons_ratio),
        Plane::Strain => poissons_ratio,
    };
    let stiff = |nu: f64| -(1.0 - 2.0 * nu.clamp(0.0, RATIOS[7])).ln();
    let row = RATIOS.partition_point(|ratio| *ratio <= nu).clamp(1, 7) - 1;
    let down = (stiff(nu) - stiff(RATIOS[row])) / (stiff(RATIOS[row + 1]) - stiff(RATIOS[row]));
    let column = ELEMENTS.partition_point(|count| *count <= elements).clamp(1, 3) - 1;
    // Beyond the table the trend of the last two columns continues.
    let along = (elements.max(1.0) / ELEMENTS[column]).log2();
    let between = |row: &[f64; 4]| (1.0 - along) * row[column].ln() + along * row[column + 1].ln();
    let logarithm = (1.0 - down) * between(&EXCESS[row]) + down * between(&EXCESS[row + 1]);
    logarithm.exp() / 100.0
}

/// Poisson's ratios in space of the rows of [`EXCESS_IN_SPACE`].
pub const RATIOS_IN_SPACE: [f64; 6] = [0.0, 0.3, 0.4, 0.45, 0.49, 0.499];

/// Cells through the width of the columns of [`EXCESS_IN_SPACE`]. A mean edge is 1.25 cells.
pub const CELLS: [usize; 4] = [2, 4, 8, 12];

/// Measured stiffness of a prism of tetrahedra in bending over the true one, less 1: the means of two meshes.
pub const EXCESS_IN_SPACE: [[f64; 4]; 6] = [
    [0.578, 0.146, 0.037, 0.017],
    [0.477, 0.121, 0.031, 0.014],
    [0.479, 0.123, 0.032, 0.014],
    [0.491, 0.128, 0.033, 0.015],
    [0.524, 0.146, 0.040, 0.018],
    [0.616, 0.236, 0.084, 0.042],
];

/// Mean edge of a mesh of tetrahedra, in cells of [`CELLS`].
const EDGE: f64 = 1.25;

/// Like [`excess`], for a member of tetrahedra with this number of elements through its thickness.
fn excess_in_space(poissons_ratio: f64, elements: f64) -> f64 {
    let row = RATIOS_IN_SPACE.iter().rposition(|ratio| *ratio <= poissons_ratio).unwrap_or(0);
    let row = row + usize::from(row + 1 < RATIOS_IN_SPACE.len() && poissons_ratio > RATIOS_IN_SPACE[row]);
    let cells = (EDGE * elements).max(1.0);
    let column = CELLS.iter().rposition(|count| *count as f64 <= cells).unwrap_or(0).min(CELLS.len() - 2);
    let [from, to] = [column, column + 1].map(|k| ((CELLS[k] as f64).ln(), EXCESS_IN_SPACE[row][k].ln()));
    (from.1 + (to.1 - from.1) * (cells.ln() - from.0) / (to.0 - from.0)).exp()
}

/// Members of tetrahedra that are too stiff in bending, and materials that lock.
pub(crate) fn warnings_in_space(model: &Model<3, 4>, placed: &[Placed<3, 4>], warnings: &mut Vec<String>) {
    let bends = !model.boundaries.is_empty() || model.gravity != [0.0; 3];
    let error = |member: &Member| {
        excess_in_space(model.materials[member.material].mean_poissons_ratio(), member.elements)
    };
    let coarse: Vec<Member> = (0..if bends { placed.len() } else { 0 })
        .filter(|&body| deforming::deforms(model, body as u32))
        .filter_map(|body| member_in_space(model, placed, body))
        .filter(|member| error(member) > STIFF)
        .collect();
    if let Some(worst) = coarse.iter().max_by(|a, b| error(a).total_cmp(&error(b))) {
        let nu = model.materials[worst.material].mean_poissons_ratio();
        let needed =
            (1..100).map(f64::from).find(|count| excess_in_space(nu, *count) <= STIFF).unwrap_or(100.0);
        too_stiff(&placed[worst.body].name, worst, error(worst), needed, coarse.len(), warnings);
    }
    for (number, material) in (0..).zip(&model.materials) {
        let nu = material.mean_poissons_ratio();
        if nu <= NEARLY_INCOMPRESSIBLE || !is_in_use(model, number) {
            continue;
        }
        let row = RATIOS_IN_SPACE.iter().position(|ratio| *ratio >= nu).unwrap_or(RATIOS_IN_SPACE.len() - 1);
        let at_least = if nu > RATIOS_IN_SPACE[row] { "more than" } else { "up to" };
        warnings.push(format!(
            "[[material]] \"{}\": elements lock where Poisson's ratio is {}: a member with {:.0} elements through its thickness is {at_least} {:.0} % too stiff in bending, one with {:.0} {at_least} {:.0} %",
            material.name,
            brief(nu),
            CELLS[1] as f64 / EDGE,
            100.0 * EXCESS_IN_SPACE[row][1],
            CELLS[2] as f64 / EDGE,
            100.0 * EXCESS_IN_SPACE[row][2],
        ));
    }
}

/// A body that bends.
struct Member {
    /// Number of the body.
    body: usize,
    /// m.
    thickness: f64,
    /// Elements through its thickness.
    elements: f64,
    /// Number of its material.
    material: usize,
}

/// Members that are too stiff, and materials that lock.
pub(crate) fn warnings(model: &Model, placed: &[Placed], warnings: &mut Vec<String>) {
    // Where nothing is held, loaded or heavy, bodies fly and hit each other: that need not bend them.
    let bends = !model.boundaries.is_empty() || model.gravity != [0.0; 2];
    let error = |member: &Member| {
        excess(model.plane, model.materials[member.material].mean_poissons_ratio(), member.elements)
    };
    let coarse: Vec<Member> = (0..if bends { placed.len() } else { 0 })
        .filter(|&body| deforming::deforms(model, body as u32))
        .filter_map(|body| member(model, placed, body))
        .filter(|member| member.elements < ENOUGH - 0.5)
        .filter(|member| error(member) > STIFF)
        .collect();
    if let Some(worst) = coarse.iter().max_by(|a, b| error(a).total_cmp(&error(b))) {
        let needed = needed(model.plane, model.materials[worst.material].mean_poissons_ratio());
        too_stiff(&placed[worst.body].name, worst, error(worst), needed, coarse.len(), warnings);
    }
    for (number, material) in model.materials.iter().enumerate() {
        let nu = material.mean_poissons_ratio();
        let in_use = is_in_use(model, number as u32);
        if matches!(model.plane, Plane::Strain) && nu > NEARLY_INCOMPRESSIBLE && in_use {
            warnings.push(format!(
                "[[material]] \"{}\": elements lock where Poisson's ratio is {} in plane strain: a member with {ENOUGH} elements through its thickness is about {:.0} % too stiff in bending, \
                 one with 16 about {:.0} %",
                material.name,
                brief(nu),
                100.0 * excess(model.plane, nu, ENOUGH),
                100.0 * excess(model.plane, nu, 2.0 * ENOUGH),
            ));
        }
    }
}

/// Whether a body that deforms has a material.
fn is_in_use<const D: usize, const N: usize>(model: &Model<D, N>, material: u32) -> bool {
    deforming::elements(model).any(|element| model.mesh.materials[element as usize] == material)
}

/// Reports a member that is by `error` too stiff, the worst of `count`; with `needed` elements through it
/// that is [`STIFF`].
fn too_stiff(name: &str, member: &Member, error: f64, needed: f64, count: usize, warnings: &mut Vec<String>) {
    let more = match count {
        1 => String::new(),
        count => format!(" ({count} bodies are like it, this one most)"),
    };
    warnings.push(format!(
        "\"{name}\" has {:.1} elements through its thickness of {} m{more}: if it bends, it is about {:.0} % too stiff; {needed:.0} elements, of {} m, make it {:.0} %",
        member.elements,
        rough(member.thickness),
        100.0 * error,
        rough(member.thickness / needed),
        100.0 * STIFF
    ));
}

/// Three digits of a number.
fn rough(x: f64) -> String {
    brief(format!("{x:.2e}").parse().unwrap_or(x))
}

/// Elements through the thickness with which a member is [`STIFF`] too stiff.
fn needed(plane: Plane, poissons_ratio: f64) -> f64 {
    let mut elements = 1.0;
    while excess(plane, poissons_ratio, elements) > STIFF {
        elements += 1.0;
    }
    elements
}

/// A body that is slender, and not held or driven along most of its length.
fn member(model: &Model, placed: &[Placed], body: usize) -> Option<Member> {
    let Placed { piece, first, .. } = &placed[body];
    let point = |node: u32| piece.nodes[node as usize];
    let area: f64 =
        piece.elements.iter().map(|t| twice_area(point(t[0]), point(t[1]), point(t[2])) / 2.0).sum();
    let around: f64 = piece.outline.iter().map(|&[a, b]| distance(point(a), point(b))).sum();
    // The rectangle of this area and circumference.
    let root = around * around / 4.0 - 4.0 * area;
    let thickness = (around / 2.0 - root.max(0.0).sqrt()) / 2.0;
    let length = area / thickness;
    if !(root > 0.0 && length > SLENDER * thickness) {
        return None;
    }
    for held in held_nodes(model, first[0]..first[0] + piece.nodes.len() as u32) {
        let [low, high] = bounds(held.into_iter());
        if (high[0] - low[0]).max(high[1] - low[1]) > HELD * length {
            return None;
        }
    }
    let mean = piece
        .elements
        .iter()
        .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
        .map(|[a, b]| distance(point(a), point(b)))
        .sum::<f64>()
        / (3 * piece.elements.len()) as f64;
    let material = *piece.materials.first()? as usize;
    Some(Member { body, thickness, elements: thickness / mean, material })
}

/// Like [`member`], in space: a bar, or a plate, which may be turned.
fn member_in_space(model: &Model<3, 4>, placed: &[Placed<3, 4>], body: usize) -> Option<Member> {
    let Placed { piece, first, .. } = &placed[body];
    let point = |node: &u32| piece.nodes[*node as usize];
    let volume: f64 = piece.elements.iter().map(|element| element.each_ref().map(point).measure()).sum();
    let surface: f64 =
        piece.outline.iter().map(|facet| <[[f64; 3]; 4]>::facet_measure(&facet.each_ref().map(point))).sum();
    let span = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let farthest =
        |from: [f64; 3]| piece.nodes.iter().copied().max_by(|a, b| span(*a, from).total_cmp(&span(*b, from)));
    let end = farthest(*piece.nodes.first()?)?;
    let length = span(end, farthest(end)?);
    // The rectangle of this cross-section, and of this circumference.
    let section = volume / length;
    let around = (surface - 2.0 * section) / length;
    let root = (around * around / 4.0 - 4.0 * section).max(0.0).sqrt();
    let thickness = (around / 2.0 - root) / 2.0;
    if length <= SLENDER * thickness {
        return None;
    }
    let width = middle_width(piece.nodes.iter().copied());
    // Nodes held along the length, by all boundaries that hold at least this share of it.
    let mut long: Vec<[f64; 3]> = Vec::new();
    for held in held_nodes(model, first[0]..first[0] + piece.nodes.len() as u32) {
        let [low, high] = bounds(held.iter().copied());
        if span(low, high) > HELD * length {
            long.extend(held);
        }
    }
    // A plate that is held along one edge bends nevertheless.
    if middle_width(long.into_iter()) > HELD * width {
        return None;
    }
    let edges = piece.elements.iter().flat_map(|element| edges(&element.each_ref().map(point)));
    let mean = edges.sum::<f64>() / (6 * piece.elements.len()) as f64;
    let material = *piece.materials.first()? as usize;
    Some(Member { body, thickness, elements: thickness / mean, material })
}

/// The nodes among `own` that each boundary holds or drives, m.
fn held_nodes<const D: usize, const N: usize>(
    model: &Model<D, N>,
    own: Range<u32>,
) -> impl Iterator<Item = Vec<[f64; D]>> {
    model.boundaries.iter().filter_map(move |boundary| {
        let Target::Nodes(nodes) = &boundary.target else { return None };
        if !boundary.load.moves_nodes() {
            return None;
        }
        let held = nodes.iter().filter(|node| own.contains(node));
        Some(held.map(|&node| model.mesh.nodes[node as usize]).collect())
    })
}

/// The middle one of the widths, m, of the box around points.
fn middle_width(points: impl Iterator<Item = [f64; 3]>) -> f64 {
    let [low, high] = bounds(points);
    let mut widths = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    widths.sort_unstable_by(f64::total_cmp);
    widths[1]
}
