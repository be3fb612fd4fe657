//! Packings in a periodic box: the box from the options or the file, and the check by brute force.

use fdem_contact::PeriodicBox;
use fdem_io::SimulationBox;

use crate::command::args::{Axes, PeriodicArguments};
use crate::command::failure::Failure;

/// Returns the periodic box, if there is one: the box of the options, or else `cell`, that of the file
/// `name`. The options, or else the file, say along which edges it repeats.
pub(crate) fn periodic_box<const D: usize>(
    arguments: &PeriodicArguments,
    name: &str,
    cell: Option<&SimulationBox>,
) -> Result<Option<PeriodicBox<f64, D>>, Failure> {
    if let Some(axis) = arguments.periodic.and_then(|axes| (D..3).find(|&axis| axes.0[axis])) {
        let axis = ["x", "y", "z"][axis];
        return Err(unusable("--periodic", &format!("a packing in {D}D has no {axis}")));
    }
    match (cell, arguments.periodic) {
        (Some(cell), None) => file_box(cell, Axes(cell.repeats), name),
        (Some(cell), Some(axes)) if takes_file_box(arguments) => file_box(cell, axes, name),
        (_, Some(axes)) => box_of_options(arguments, axes),
        (None, None) => Ok(None),
    }
}

fn unusable(option: &str, why: &str) -> Failure {
    Failure::Unusable(format!("{option}: {why}"))
}

fn box_of_options<const D: usize>(
    arguments: &PeriodicArguments,
    axes: Axes,
) -> Result<Option<PeriodicBox<f64, D>>, Failure> {
    if axes == Axes([false; 3]) {
        if takes_file_box(arguments) {
            return Ok(None);
        }
        return Err(unusable("--periodic none", "--box and --edges give a periodic box"));
    }
    let periodic = std::array::from_fn(|axis| axes.0[axis]);
    let count = |option: &str, numbers: &[f64], expected: usize, what: &str| {
        if numbers.len() == expected {
            return Ok(());
        }
        let found = numbers.len();
        Err(unusable(option, &format!("a packing in {D}D needs {expected} numbers, {what}, not {found}")))
    };
    let made = match (&arguments.limits, &arguments.edges) {
        (Some(limits), _) => {
            count("--box", &limits.0, 2 * D, "the limits of each axis")?;
            let side = |which: usize| std::array::from_fn(|axis| limits.0[2 * axis + which]);
            PeriodicBox::orthogonal(side(0), side(1), periodic)
                .map_err(|error| unusable("--box", &error.to_string()))
        }
        (None, Some(edges)) => {
            count("--edges", &edges.0, D * D, "the components of each edge")?;
            let origin = match &arguments.origin {
                Some(origin) => {
                    count("--origin", &origin.0, D, "a point")?;
                    std::array::from_fn(|axis| origin.0[axis])
                }
                None => [0.0; D],
            };
            let edges = std::array::from_fn(|edge| std::array::from_fn(|axis| edges.0[D * edge + axis]));
            PeriodicBox::triclinic(origin, edges, periodic)
                .map_err(|error| unusable("--edges", &error.to_string()))
        }
        (None, None) => Err(unusable("--periodic", "the box is missing: give --box or --edges")),
    };
    made.map(Some)
}

/// Whether the options leave the box to the file.
pub(crate) fn takes_file_box(arguments: &PeriodicArguments) -> bool {
    arguments.limits.is_none() && arguments.edges.is_none()
}

/// Returns the box of a file, periodic along the given axes; `None` if it is periodic along none.
fn file_box<const D: usize>(
    cell: &SimulationBox,
    Axes(axes): Axes,
    name: &str,
) -> Result<Option<PeriodicBox<f64, D>>, Failure> {
    if !axes[..D].contains(&true) {
        return Ok(None);
    }
    let unusable = |why: String| {
        let advice = "--periodic none ignores it, --box and --edges replace it";
        Failure::Unusable(format!("{name}: the box of the file: {why}. {advice}"))
    };
    if D == 2 && cell.edges[..2].iter().any(|edge| edge[2] != 0.0) {
        return Err(unusable("its edges leave the plane of the 2D elements".to_owned()));
    }
    let mut edges: [[f64; D]; D] =
        std::array::from_fn(|edge| std::array::from_fn(|axis| cell.edges[edge][axis]));
    let longest = edges.as_flattened().iter().fold(0.0_f64, |longest, x| longest.max(x.abs()));
    for edge in (0..D).filter(|&edge| !axes[edge]) {
        // The file need not give edges that do not repeat, but the box needs them.
        if edges[edge].iter().all(|x| *x == 0.0) {
            edges[edge][edge] = if longest > 0.0 { longest } else { 1.0 };
        }
    }
    let origin = std::array::from_fn(|axis| cell.origin[axis]);
    let periodic = std::array::from_fn(|axis| axes[axis]);
    PeriodicBox::triclinic(origin, edges, periodic).map(Some).map_err(|error| unusable(error.to_string()))
}
