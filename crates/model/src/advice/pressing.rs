//! Whether boundaries press on a model or pull at it.

use fdem_mesh::bounds;
use fdem_simulation::{Boundary, Load, LoadEffect, Model};

/// Whether a boundary acts on the model from outside, towards its middle.
pub(crate) fn presses<const D: usize, const N: usize>(boundary: &Boundary<D>, model: &Model<D, N>) -> bool {
    let [low, high] = bounds(model.mesh.nodes.iter().copied());
    let nodes = boundary.target.nodes();
    if nodes.is_empty() || boundary.load.summary().effect == LoadEffect::Support {
        return false;
    }
    let of_nodes = bounds(nodes.iter().map(|&node| model.mesh.nodes[node as usize]));
    let towards: [f64; D] = match &boundary.load {
        Load::Velocity(components) | Load::Displacement(components) => {
            components.map(Option::unwrap_or_default)
        }
        Load::Force(components) | Load::Traction(components) => *components,
        // Pressure in a hole opens it.
        Load::Pressure(pressure) => {
            return *pressure > 0.0
                && (0..D).any(|axis| of_nodes[0][axis] <= low[axis] || of_nodes[1][axis] >= high[axis]);
        }
        _ => return false,
    };
    (0..D).any(|axis| {
        let from_middle = of_nodes[0][axis] + of_nodes[1][axis] - low[axis] - high[axis];
        towards[axis] * from_middle < -1e-6 * towards[axis].abs() * (high[axis] - low[axis])
    })
}
