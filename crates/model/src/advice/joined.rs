//! Strengths of interfaces, and the facets of the mesh that they are for.

use std::collections::BTreeMap;

use fdem_io::numbers::grouped;
use fdem_mesh::{Corners, sorted_facets};
use fdem_simulation::Model;

use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::ModelFile;

/// Warns of the strength of a material with itself. A strength that holds nothing together is a fault, unless
/// it is `optional`. The interfaces of the model are those of the file, in its order.
pub(crate) fn check<const D: usize, const N: usize>(
    (file, document): (&ModelFile, &Document<'_>),
    model: &Model<D, N>,
    warnings: &mut Vec<String>,
    faults: &mut Vec<Fault>,
) where
    [[f64; D]; N]: Corners<D, N>,
{
    if model.interfaces.iter().all(|interface| interface.strength.is_none()) {
        return;
    }
    let facets = facets(model);
    let (facet, all) = if D == 2 { ("edge", "edges") } else { ("face", "faces") };
    for (index, interface) in model.interfaces.iter().enumerate() {
        if interface.strength.is_none() {
            continue;
        }
        let [a, b] = interface.materials;
        let [first, second] = [a, b].map(|material| &model.materials[material as usize].name);
        let count = facets.get(&[a.min(b), a.max(b)]).copied().unwrap_or(0);
        if a == b {
            warnings.push(format!(
                "[[interface]] of \"{first}\" with itself: its strength is that of all {} {all} inside \"{first}\", in place of the strength of the material; \
                 it bonds no bodies to each other",
                grouped(count)
            ));
        } else if count == 0 && !file.interface[index].optional {
            let message = format!(
                "[[interface]] of \"{first}\" and \"{second}\" has a strength, but no {facet} of the mesh lies between the two: it holds nothing together"
            );
            let help = "joints are inside bodies, as between the grains of one voronoi or the groups of one mesh file; \
                        with optional = true such a strength is allowed";
            let span = document.value(Table::of("interface", index), "materials");
            faults.push(Fault::at(span, message).label("apart").help(help));
        }
    }
}

/// Facets inside bodies by the two materials at them.
fn facets<const D: usize, const N: usize>(model: &Model<D, N>) -> BTreeMap<[u32; 2], u64>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let mesh = &model.mesh;
    let mut facets = BTreeMap::new();
    for pair in sorted_facets::<D, N>(&mesh.elements).windows(2) {
        if pair[0].0 == pair[1].0 {
            let [one, other] = [pair[0].1, pair[1].1].map(|element| mesh.materials[element as usize]);
            *facets.entry([one.min(other), one.max(other)]).or_default() += 1;
        }
    }
    facets
}
