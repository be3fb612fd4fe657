//! Spheres as a continuum: the grid of `[output] coarse`.

use fdem_results::CoarseGrid;

use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{Coarse, ModelFile};

/// Number of components of the box, and the number that a model in `d` dimensions has.
pub(crate) fn length(file: &ModelFile, d: usize) -> Option<(Table, &'static str, usize, usize)> {
    let coarse = file.output.coarse.as_ref()?;
    Some((Table::one("output"), "coarse.box", coarse.limits.len(), 2 * d))
}

/// Checks the grid before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let Some(coarse) = &file.output.coarse else { return };
    let table = Table::one("output");
    if !file.has_spheres() {
        faults.push(
            Fault::at(document.key(table, "coarse"), "\"coarse\" is for spheres, and there are none")
                .label("no effect"),
        );
    }
    let (low, high) = coarse.limits.split_at(coarse.limits.len() / 2);
    if low.iter().zip(high).any(|(low, high)| high < low) {
        faults.push(
            Fault::at(document.value(table, "coarse.box"), "the box of coarse is turned inside out").help(
                "a box is [xmin, ymin, xmax, ymax], in three dimensions [xmin, ymin, zmin, xmax, ymax, zmax]",
            ),
        );
    } else if grid(coarse).is_too_fine(low.len()) {
        faults.push(
            Fault::at(
                document.value(table, "coarse.spacing"),
                "the grid of coarse has more than 50,000,000 points",
            )
            .label("too fine for its box")
            .help("take a longer spacing, or a smaller box"),
        );
    }
}

/// The grid. Without a third axis it is in the plane z = 0.
pub(crate) fn grid(coarse: &Coarse) -> CoarseGrid {
    let (low, high) = coarse.limits.split_at(coarse.limits.len() / 2);
    let corner = |of: &[f64]| [0, 1, 2].map(|axis| of.get(axis).copied().unwrap_or(0.0));
    CoarseGrid { spacing: coarse.spacing, width: coarse.width, region: Some([corner(low), corner(high)]) }
}
