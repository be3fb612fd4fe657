//! Cavities: the facets at which a pressure in a hole, or in open joints, begins.

use std::collections::BTreeMap;

use fdem_mesh::Mesh;
use fdem_simulation::{Boundary, Load};

use crate::bodies::dimensions::Dimensions;
use crate::shapes::placed::Placed;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, ModelFile};

/// Checks the keys of cavities before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    for (index, boundary) in file.boundary.iter().enumerate() {
        let table = Table::of("boundary", index);
        let title = format!("[[boundary]] \"{}\"", boundary.name);
        let mut wrong = |key: &str, message: String, help: &str| {
            faults.push(Fault::at(document.key(table, key), format!("{title}: {message}")).help(help));
        };
        if boundary.cavity && boundary.pressure.is_none() {
            wrong("cavity", "a cavity has no pressure".to_owned(), "give it the key pressure, Pa");
        }
        if !boundary.cavity {
            for (key, given) in
                [("at", boundary.at.is_some()), ("gas_exponent", boundary.gas_exponent.is_some())]
            {
                if given {
                    wrong(key, format!("\"{key}\" is for a cavity"), "add cavity = true, or take it out");
                }
            }
        }
        if boundary.gas_exponent.is_some() {
            if boundary.pressure.is_some_and(|pressure| pressure < 0.0) {
                wrong("pressure", "the pressure of a gas is not negative".to_owned(), "write it as positive");
            }
            for (key, given) in [
                ("ramp", boundary.ramp.is_some()),
                ("table", boundary.table.is_some()),
                ("table_file", boundary.table_file.is_some()),
                ("expression", boundary.expression.is_some()),
            ] {
                if given {
                    let help = "take one of the two out: the pressure of a gas follows from its volume";
                    wrong(key, format!("a gas has no \"{key}\""), help);
                }
            }
        }
    }
}

/// The load of a cavity; `None` for another boundary.
pub(crate) fn load<const D: usize>(boundary: &file::Boundary) -> Option<Load<D>> {
    let pressure = boundary.pressure.filter(|_| boundary.cavity)?;
    Some(Load::Cavity { pressure, gas: boundary.gas_exponent })
}

/// The facets of the smallest hole around a point. `outline`: facets among which holes are looked for.
pub(crate) fn hole_around<const D: usize, const N: usize>(
    point: [f64; D],
    outline: &[[u32; D]],
    mesh: &Mesh<D, N>,
) -> Option<Vec<[u32; D]>>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let place = |node: u32| -> [f64; D] { mesh.nodes[node as usize] };
    let seen = |facet: &[u32; D]| {
        <[[f64; D]; N]>::seen(facet.map(|node| std::array::from_fn(|k| place(node)[k] - point[k])))
    };
    // From within a hole its facets are seen from their outer sides, all around.
    let is_around = |facets: &Vec<[u32; D]>| facets.iter().map(seen).sum::<f64>() < -0.5;
    connected(outline).into_iter().filter(is_around).min_by_key(Vec::len)
}

/// The facets of the smallest hole around a point; if there is none, the facet of the nearest open joint, if
/// the point is on it. `outline`: facets among which holes are looked for.
pub(crate) fn at<const D: usize, const N: usize>(
    point: [f64; D],
    outline: &[[u32; D]],
    mesh: &Mesh<D, N>,
    file: &ModelFile,
    placed: &[Placed<D, N>],
) -> Vec<[u32; D]>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    if let Some(hole) = hole_around(point, outline, mesh) {
        return hole;
    }
    let place = |node: u32| -> [f64; D] { mesh.nodes[node as usize] };
    let distance = |a: [f64; D], b: [f64; D]| (0..D).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    let middle = |facet: &[u32; D]| -> [f64; D] {
        std::array::from_fn(|k| facet.iter().map(|&node| place(node)[k]).sum::<f64>() / D as f64)
    };
    let is_open = |set: u32| file.joint_set.get(set as usize).is_some_and(|set| set.open);
    let joints = placed.iter().flat_map(|Placed { piece, first, .. }| {
        let open = piece.joints.iter().filter(|joint| is_open(joint.set));
        open.map(|joint| joint.facet.map(|node| node + first[0]))
    });
    let nearest = joints.map(|facet| (distance(middle(&facet), point), facet));
    let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0));
    let is_on = |(gap, facet): &(f64, [u32; D])| {
        *gap <= facet.iter().map(|&node| distance(place(node), middle(facet))).fold(0.0, f64::max)
    };
    nearest.filter(is_on).map(|(_, facet)| facet).into_iter().collect()
}

/// Groups facets that are connected by common nodes.
fn connected<const D: usize>(facets: &[[u32; D]]) -> Vec<Vec<[u32; D]>> {
    let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (number, facet) in facets.iter().enumerate() {
        for &node in facet {
            at.entry(node).or_default().push(number);
        }
    }
    let mut taken = vec![false; facets.len()];
    let mut groups = Vec::new();
    for first in 0..facets.len() {
        let (mut group, mut waiting) = (Vec::new(), vec![first]);
        while let Some(number) = waiting.pop() {
            if std::mem::replace(&mut taken[number], true) {
                continue;
            }
            group.push(facets[number]);
            waiting.extend(facets[number].iter().filter_map(|node| at.get(node)).flatten());
        }
        if !group.is_empty() {
            groups.push(group);
        }
    }
    groups
}

/// Checks that a gas begins in a closed hole.
pub(crate) fn check_gas<const D: usize>(
    boundary: &Boundary<D>,
    (document, table): (&Document<'_>, Table),
    faults: &mut Vec<Fault>,
) {
    if !matches!(boundary.load, Load::Cavity { gas: Some(_), .. }) {
        return;
    }
    if !is_closed(boundary.target.facets()) {
        faults.push(
            Fault::at(
                document.key(table, "gas_exponent"),
                format!("[[boundary]] \"{}\": a gas begins in a closed hole", boundary.name),
            )
            .help("choose a hole by group or at; without gas_exponent the pressure follows the schedule"),
        );
    }
}

/// Whether each rim of facets, a node in the plane and an edge in space, belongs to two of them.
pub(crate) fn is_closed<const D: usize>(facets: &[[u32; D]]) -> bool {
    let mut rims: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
    for facet in facets {
        for without in facet {
            let mut rim: Vec<u32> = facet.iter().copied().filter(|node| node != without).collect();
            rim.sort_unstable();
            *rims.entry(rim).or_default() += 1;
        }
    }
    rims.values().all(|count| count % 2 == 0)
}
