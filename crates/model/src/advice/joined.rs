//! Strengths of interfaces, and the facets of the mesh that they are for.

use std::collections::BTreeMap;

use fdem_io::numbers::grouped;
use fdem_mesh::{Corners, sorted_facets};
use fdem_simulation::Model;

/// Strengths that hold nothing together, and those of a material with itself.
pub(crate) fn warnings<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>)
where
    [[f64; D]; N]: Corners<D, N>,
{
    if model.interfaces.iter().all(|interface| interface.strength.is_none()) {
        return;
    }
    let facets = facets(model);
    let (facet, all) = if D == 2 { ("edge", "edges") } else { ("face", "faces") };
    for interface in model.interfaces.iter().filter(|interface| interface.strength.is_some()) {
        let [a, b] = interface.materials;
        let [first, second] = [a, b].map(|material| &model.materials[material as usize].name);
        let count = facets.get(&[a.min(b), a.max(b)]).copied().unwrap_or(0);
        if a == b {
            warnings.push(format!(
                "[[interface]] of \"{first}\" with itself: its strength is that of all {} {all} inside \"{first}\", in place of the strength of the material; \
                 it bonds no bodies to each other",
                grouped(count)
            ));
        } else if count == 0 {
            warnings.push(format!(
                "[[interface]] of \"{first}\" and \"{second}\" has a strength, but no {facet} of the mesh lies between the two: it holds nothing together; \
                 joints are inside bodies, as between the grains of one voronoi or the groups of one mesh file"
            ));
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
