//! Writes snapshots as files for ParaView.
//!
//! Numbers are in SI units. Every array that has a unit names it under the information key `UNITS_LABEL` of
//! VTK.

use std::io::{self, Write};

use fdem_io::{Table, Values};
use fdem_simulation::{Crack, Element, Forces, Mode, Snapshot};

use crate::run::names::Names;
use crate::run::snapshot::{SnapshotError, checked};
use crate::run::stress::von_mises;

/// Names of the components of vectors in space.
const SPACE: [&str; 3] = ["x", "y", "z"];

/// Names of the corners of elements and facets.
const CORNERS: [&str; 4] = ["a", "b", "c", "d"];

/// Writes the deformed mesh as a `.vtu` file.
///
/// - Nodes: position, displacement, velocity, and reaction (the force of all boundaries on the node).
/// - Elements: stress (`xx`, `yy`, `zz`, `xy`, `yz`, `xz`), largest and smallest principal stress, in the
///   plane in two dimensions (`max`, `min`), von Mises stress, damage, body, material and fragment.
/// - File: the time, and the numbers of bodies and materials by their names.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] with a [`SnapshotError`] within.
///
/// # Example
/// ```
/// use fdem_results::{Names, write_vtu};
/// use fdem_simulation::{Forces, Snapshot};
///
/// let mut file = Vec::new();
/// write_vtu(&mut file, &Snapshot::<2, 3>::default(), &Forces::default(), &Names::default())?;
/// assert!(file.starts_with(b"<?xml"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_vtu<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
    forces: &Forces<D>,
    names: &Names,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    checked(snapshot)?;
    let (found, expected) = (forces.reactions.len(), snapshot.positions.len());
    if found != 0 && found != expected {
        return Err(SnapshotError::Length { name: "reactions", found, expected }.into());
    }
    let reactions = |k: usize| if found == 0 { 0.0 } else { in_space(&forces.reactions, k) };
    let points = Table::new(snapshot.positions.len())
        .with_components("positions", &SPACE, Values::f64(|k| in_space(&snapshot.positions, k)))
        .with_components("displacement", &SPACE, Values::f64(|k| in_space(&snapshot.displacements, k)))
        .in_unit("m")
        .with_components("velocity", &SPACE, Values::f64(|k| in_space(&snapshot.velocities, k)))
        .in_unit("m/s")
        .with_components("reaction", &SPACE, Values::f64(reactions))
        .in_unit("N");
    let stresses = &snapshot.stresses;
    let cells = Table::new(snapshot.elements.len())
        .with_components("nodes", &CORNERS[..N], Values::i64(|k| i64::from(snapshot.elements[k / N][k % N])))
        .with_components(
            "stress",
            &["xx", "yy", "zz", "xy", "yz", "xz"],
            Values::f64(|k| stresses[k / 6][k % 6]),
        )
        .in_unit("Pa")
        .with_components(
            "principal_stress",
            &["max", "min"],
            Values::f64(|k| snapshot.principal_stresses(k / 2)[k % 2]),
        )
        .in_unit("Pa")
        .with("von_mises", Values::f64(|k| von_mises(stresses[k])))
        .in_unit("Pa")
        .with("damage", Values::f64(|k| snapshot.damage[k]))
        .with("body", Values::i64(|k| i64::from(snapshot.bodies[k])))
        .with("material", Values::i64(|k| i64::from(snapshot.materials[k])))
        .with("fragment", Values::i64(|k| i64::from(snapshot.fragments[k])));
    fdem_io::write_vtu(out, &points, &cells, snapshot.time, &names.numbered())
}

/// Writes the broken joints as a `.vtp` file of lines, in three dimensions of triangles: mode (0 tension, 1
/// shear, 2 mixed), `broken` (1 for all), damage, opening, sliding, time of failure, `length` of the
/// undeformed edge or `area` of the undeformed face, and the two elements.
///
/// # Errors
/// The errors of `out`.
pub fn write_cracks_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
) -> io::Result<()> {
    write_joints(out, snapshot, true)
}

/// Writes the damaged joints, which soften but still hold, in the format of [`write_cracks_vtp`]: `broken` is
/// 0, and the time of failure is NaN.
///
/// # Errors
/// The errors of `out`.
pub fn write_damaged_joints_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
) -> io::Result<()> {
    write_joints(out, snapshot, false)
}

fn write_joints<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
    broken: bool,
) -> io::Result<()> {
    let cracks: Vec<&Crack<D>> =
        snapshot.cracks.iter().filter(|crack| crack.time.is_some() == broken).collect();
    let corner = |k: usize| match (k / 3, k % 3) {
        (corner, axis) if axis < D => cracks[corner / D].corners[corner % D][axis],
        _ => 0.0,
    };
    let points = Table::new(D * cracks.len()).with_components("positions", &SPACE, Values::f64(corner));
    let (measure, unit) = if D == 2 { ("length", "m") } else { ("area", "m²") };
    let lines = Table::new(cracks.len())
        .with_components("corners", &CORNERS[..D], Values::i64(|k| k.cast_signed() as i64))
        .with("mode", Values::i32(|k| code(cracks[k].mode)))
        .with("broken", Values::i32(|k| i32::from(cracks[k].time.is_some())))
        .with("damage", Values::f64(|k| cracks[k].damage))
        .with("opening", Values::f64(|k| cracks[k].opening))
        .in_unit("m")
        .with("sliding", Values::f64(|k| cracks[k].sliding))
        .in_unit("m")
        .with("time_of_failure", Values::f64(|k| cracks[k].time.unwrap_or(f64::NAN)))
        .in_unit("s")
        .with(measure, Values::f64(|k| cracks[k].measure))
        .in_unit(unit)
        .with_components(
            "elements",
            &["one", "other"],
            Values::i64(|k| i64::from(cracks[k / 2].elements[k % 2])),
        );
    fdem_io::write_poly_vtp(out, &points, Some(&lines), snapshot.time)
}

/// Writes the contact forces as a `.vtp` file of points, one for each couple of elements that press each
/// other: the force on the first element, the magnitudes of its normal and its tangential part, the two
/// elements, their bodies and their fragments. The second element has the opposite force.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] with a [`SnapshotError`] within, also if a contact
/// has an element that does not exist.
pub fn write_contacts_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
    forces: &Forces<D>,
) -> io::Result<()> {
    checked(snapshot)?;
    let (contacts, elements) = (&forces.contacts, snapshot.elements.len());
    if let Some(&element) =
        contacts.iter().flat_map(|contact| &contact.elements).find(|&&element| element as usize >= elements)
    {
        return Err(SnapshotError::Contact { element, elements }.into());
    }
    let size = |vector: [f64; D]| match vector[..] {
        [x, y] => x.hypot(y),
        _ => vector.iter().map(|x| x * x).sum::<f64>().sqrt(),
    };
    let element = |k: usize| contacts[k / 2].elements[k % 2] as usize;
    let place = |k: usize| if k % 3 < D { contacts[k / 3].point[k % 3] } else { 0.0 };
    let force = |k: usize| if k % 3 < D { contacts[k / 3].force()[k % 3] } else { 0.0 };
    let points = Table::new(contacts.len())
        .with_components("positions", &SPACE, Values::f64(place))
        .with_components("force", &SPACE, Values::f64(force))
        .in_unit("N")
        .with("normal_force", Values::f64(|k| size(contacts[k].normal)))
        .in_unit("N")
        .with("tangential_force", Values::f64(|k| size(contacts[k].tangential)))
        .in_unit("N")
        .with_components("elements", &["one", "other"], Values::i64(|k| element(k).cast_signed() as i64))
        .with_components("bodies", &["one", "other"], Values::i64(|k| i64::from(snapshot.bodies[element(k)])))
        .with_components(
            "fragments",
            &["one", "other"],
            Values::i64(|k| i64::from(snapshot.fragments[element(k)])),
        );
    fdem_io::write_poly_vtp(out, &points, None, snapshot.time)
}

/// Returns component `k % 3` of vector `k / 3`; the third component of a vector of the plane is 0.
fn in_space<const D: usize>(vectors: &[[f64; D]], k: usize) -> f64 {
    if k % 3 < D { vectors[k / 3][k % 3] } else { 0.0 }
}

/// Returns the number of a mode in files.
fn code(mode: Mode) -> i32 {
    match mode {
        Mode::Tension => 0,
        Mode::Shear => 1,
        Mode::Mixed => 2,
    }
}
