//! Boxes.

use crate::tetrahedra::{MeshError, OUTSIDE, Surface, finite};

/// A box with edges along the axes.
///
/// Faces: `left`, `right`, `front`, `back`, `bottom`, `top`.
///
/// # Errors
/// [`MeshError::Flat`] if a corner of `low` is not below that of `high`; [`MeshError::NotFinite`].
pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Result<Surface, MeshError> {
    finite(&[low, high])?;
    if (0..3).any(|axis| low[axis] >= high[axis]) {
        return Err(MeshError::Flat);
    }
    let nodes = (0..8)
        .map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] }))
        .collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let facets = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let names = ["left", "right", "front", "back", "bottom", "top"].map(str::to_owned).to_vec();
    Ok(Surface {
        nodes,
        facets,
        faces: (0..12).map(|k| k / 2).collect(),
        sides: vec![[0, OUTSIDE]; 12],
        names,
    })
}
