//! Writes snapshots as files for ParaView.
//!
//! Numbers are in SI units. Every array that has a unit names it under the information key `UNITS_LABEL` of VTK.

use std::io::{self, Write};

use fdem_io::{Table, Values};
use fdem_simulation::{Crack, Forces, Mode, Snapshot};

use crate::results::names::Names;
use crate::results::stress::{principal, von_mises};
use crate::results::{SnapshotError, checked};

/// Names of the components of vectors in space.
const SPACE: [&str; 3] = ["x", "y", "z"];

/// Writes the deformed mesh as a `.vtu` file.
///
/// - Nodes: position, displacement, velocity, and reaction (the force of all boundaries on the node).
/// - Elements: stress (`xx`, `yy`, `xy`, `zz`), principal stresses in the plane (`max`, `min`), von Mises stress, damage, body, material and fragment.
/// - File: the time, and the numbers of bodies and materials by their names.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] with a [`SnapshotError`] within.
///
/// # Example
/// ```
/// use fdem::results::{Names, write_vtu};
/// use fdem_simulation::{Forces, Snapshot};
///
/// let mut file = Vec::new();
/// write_vtu(&mut file, &Snapshot::default(), &Forces::default(), &Names::default())?;
/// assert!(file.starts_with(b"<?xml"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_vtu<W: Write>(
    out: &mut W,
    snapshot: &Snapshot,
    forces: &Forces,
    names: &Names,
) -> io::Result<()> {
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
    let triangles = Table::new(snapshot.elements.len())
        .with_components(
            "nodes",
            &["a", "b", "c"],
            Values::i64(|k| i64::from(snapshot.elements[k / 3][k % 3])),
        )
        .with_components("stress", &["xx", "yy", "xy", "zz"], Values::f64(|k| stresses[k / 4][k % 4]))
        .in_unit("Pa")
        .with_components(
            "principal_stress",
            &["max", "min"],
            Values::f64(|k| principal(stresses[k / 2])[k % 2]),
        )
        .in_unit("Pa")
        .with("von_mises", Values::f64(|k| von_mises(stresses[k])))
        .in_unit("Pa")
        .with("damage", Values::f64(|k| snapshot.damage[k]))
        .with("body", Values::i64(|k| i64::from(snapshot.bodies[k])))
        .with("material", Values::i64(|k| i64::from(snapshot.materials[k])))
        .with("fragment", Values::i64(|k| i64::from(snapshot.fragments[k])));
    fdem_io::write_vtu(out, &points, &triangles, snapshot.time, &names.numbered())
}

/// Writes the broken joints as a `.vtp` file of lines: mode (0 tension, 1 shear, 2 mixed), `broken` (1 for all), damage, opening, sliding, time of
/// failure, length of the undeformed edge, and the two elements.
///
/// # Errors
/// The errors of `out`.
pub fn write_cracks_vtp<W: Write>(out: &mut W, snapshot: &Snapshot) -> io::Result<()> {
    write_joints(out, snapshot, true)
}

/// Writes the damaged joints, which soften but still hold, in the format of [`write_cracks_vtp`]: `broken` is 0, and the time of failure is NaN.
///
/// # Errors
/// The errors of `out`.
pub fn write_damaged_joints_vtp<W: Write>(out: &mut W, snapshot: &Snapshot) -> io::Result<()> {
    write_joints(out, snapshot, false)
}

fn write_joints<W: Write>(out: &mut W, snapshot: &Snapshot, broken: bool) -> io::Result<()> {
    let cracks: Vec<&Crack> = snapshot.cracks.iter().filter(|crack| crack.time.is_some() == broken).collect();
    let end = |k: usize| if k % 3 < 2 { cracks[k / 6].ends[k / 3 % 2][k % 3] } else { 0.0 };
    let points = Table::new(2 * cracks.len()).with_components("positions", &SPACE, Values::f64(end));
    let lines = Table::new(cracks.len())
        .with_components("ends", &["i", "j"], Values::i64(|k| k.cast_signed() as i64))
        .with("mode", Values::i32(|k| code(cracks[k].mode)))
        .with("broken", Values::i32(|k| i32::from(cracks[k].time.is_some())))
        .with("damage", Values::f64(|k| cracks[k].damage))
        .with("opening", Values::f64(|k| cracks[k].opening))
        .in_unit("m")
        .with("sliding", Values::f64(|k| cracks[k].sliding))
        .in_unit("m")
        .with("time_of_failure", Values::f64(|k| cracks[k].time.unwrap_or(f64::NAN)))
        .in_unit("s")
        .with("length", Values::f64(|k| cracks[k].length))
        .in_unit("m")
        .with_components(
            "elements",
            &["one", "other"],
            Values::i64(|k| i64::from(cracks[k / 2].elements[k % 2])),
        );
    fdem_io::write_poly_vtp(out, &points, Some(&lines), snapshot.time)
}

/// Writes the contact forces as a `.vtp` file of points, one for each couple of elements that press each other: the force on the first element, the
/// magnitudes of its normal and its tangential part, the two elements, their bodies and their fragments. The second element has the opposite force.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] with a [`SnapshotError`] within, also if a contact has an element that does not exist.
pub fn write_contacts_vtp<W: Write>(out: &mut W, snapshot: &Snapshot, forces: &Forces) -> io::Result<()> {
    checked(snapshot)?;
    let (contacts, elements) = (&forces.contacts, snapshot.elements.len());
    if let Some(&element) =
        contacts.iter().flat_map(|contact| &contact.elements).find(|&&element| element as usize >= elements)
    {
        return Err(SnapshotError::Contact { element, elements }.into());
    }
    let size = |[x, y]: [f64; 2]| x.hypot(y);
    let element = |k: usize| contacts[k / 2].elements[k % 2] as usize;
    let place = |k: usize| if k % 3 < 2 { contacts[k / 3].point[k % 3] } else { 0.0 };
    let force = |k: usize| if k % 3 < 2 { contacts[k / 3].force()[k % 3] } else { 0.0 };
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

/// Returns component `k % 3` of vector `k / 3` of the plane; the third component is 0.
fn in_space(vectors: &[[f64; 2]], k: usize) -> f64 {
    if k % 3 < 2 { vectors[k / 3][k % 3] } else { 0.0 }
}

/// Returns the number of a mode in files.
fn code(mode: Mode) -> i32 {
    match mode {
        Mode::Tension => 0,
        Mode::Shear => 1,
        Mode::Mixed => 2,
    }
}
