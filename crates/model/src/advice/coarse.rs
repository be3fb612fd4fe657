//! Bodies that are smaller than their elements would be.

use fdem_io::numbers::brief;
use fdem_mesh::bounds;

use crate::advice::ready::Ready;

/// `mesh_size` over the smallest width of a body from which this has no element across, in whole numbers.
const NONE: f64 = 2.0;

/// Warns of a `mesh_size` above twice the smallest width of a body, as where a length is in another unit. One
/// warning for each table of the file; bodies with places to refine have other sizes, and the elements of
/// rigid bodies have no stress.
pub(crate) fn warn<const D: usize, const N: usize>(ready: &Ready<'_, D, N>, warnings: &mut Vec<String>) {
    for (table, body) in ready.file.body.iter().enumerate() {
        let Some(size) = body.mesh_size.filter(|_| body.refine.is_empty() && !body.rigid.always()) else {
            continue;
        };
        let widths = ready.placed.iter().filter(|placed| placed.table == table).map(|placed| {
            let [low, high] = bounds(placed.piece.nodes.iter().copied());
            (0..D).map(|axis| high[axis] - low[axis]).fold(f64::INFINITY, f64::min)
        });
        // Of a packing, the largest piece.
        let Some(width) = widths.reduce(f64::max) else { continue };
        if size > NONE * width {
            let unit =
                if body.surface.is_some() { ", or see that scale is the unit of its file" } else { "" };
            warnings.push(format!(
                "[[body]] \"{}\": mesh_size = {} m is {} times its smallest width, {} m, which has fewer than one element; take a smaller one{unit}",
                body.name,
                brief(size),
                brief((10.0 * size / width).round() / 10.0),
                brief(width)
            ));
        }
    }
}
