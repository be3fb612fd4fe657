//! Strengths of interfaces, and the edges of the mesh that they are for.

use std::collections::BTreeMap;

use fdem_simulation::Model;

use crate::numbers::grouped;

/// Strengths that hold nothing together, and those of a material with itself.
pub(crate) fn warnings(model: &Model, warnings: &mut Vec<String>) {
    if model.interfaces.iter().all(|interface| interface.strength.is_none()) {
        return;
    }
    let edges = edges(model);
    for interface in model.interfaces.iter().filter(|interface| interface.strength.is_some()) {
        let [a, b] = interface.materials;
        let [first, second] = [a, b].map(|material| &model.materials[material as usize].name);
        let count = edges.get(&[a.min(b), a.max(b)]).copied().unwrap_or(0);
        if a == b {
            warnings.push(format!(
                "[[interface]] of \"{first}\" with itself: its strength is that of all {} edges inside \"{first}\", in place of the strength of the material; \
                 it bonds no bodies to each other",
                grouped(count)
            ));
        } else if count == 0 {
            warnings.push(format!(
                "[[interface]] of \"{first}\" and \"{second}\" has a strength, but no edge of the mesh lies between the two: it holds nothing together; \
                 joints are inside bodies, as between the grains of one voronoi or the groups of one mesh file"
            ));
        }
    }
}

/// Edges inside bodies by the two materials at them.
fn edges(model: &Model) -> BTreeMap<[u32; 2], u64> {
    let mesh = &model.mesh;
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * mesh.elements.len());
    for (&[a, b, c], &material) in mesh.elements.iter().zip(&mesh.materials) {
        sides.extend([[a, b], [b, c], [c, a]].map(|[a, b]| ([a.min(b), a.max(b)], material)));
    }
    sides.sort_unstable();
    let mut edges = BTreeMap::new();
    for pair in sides.windows(2) {
        if pair[0].0 == pair[1].0 {
            // Sorted, so that the lesser material comes first.
            *edges.entry([pair[0].1, pair[1].1]).or_default() += 1;
        }
    }
    edges
}
