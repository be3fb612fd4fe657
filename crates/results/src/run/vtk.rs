//! Writes snapshots as files for ParaView.
//!
//! Numbers are in SI units. Every array that has a unit names it under the information key `UNITS_LABEL` of
//! VTK.

use std::io::{self, Write};

use fdem_io::{Table, Values};
use fdem_simulation::{Element, Forces, Snapshot};

use crate::fields::place::Place;
use crate::fields::state::{Instant, JointState, in_space};
use crate::run::file_fields::with_fields;
use crate::run::names::Names;
use crate::run::snapshot::{checked, checked_contacts, checked_reactions};

/// Names of the components of vectors in space.
const SPACE: [&str; 3] = ["x", "y", "z"];

/// Names of the corners of elements and facets.
const CORNERS: [&str; 4] = ["a", "b", "c", "d"];

/// Writes the deformed mesh as a `.vtu` file.
///
/// - Nodes and elements: the position, and the fields that [`QUANTITIES`](crate::QUANTITIES) has for files.
/// - File: the time, and the numbers of bodies and materials by their names.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] with a [`SnapshotError`](crate::SnapshotError)
/// within.
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
    checked_reactions(snapshot, forces)?;
    let state = Instant::of(snapshot).with_forces(forces);
    let position = |k: usize| in_space(snapshot.positions[k / 3])[k % 3];
    let points =
        Table::new(snapshot.positions.len()).with_components("positions", &SPACE, Values::f64(position));
    let node = |k: usize| i64::from(snapshot.elements[k / N][k % N]);
    let cells =
        Table::new(snapshot.elements.len()).with_components("nodes", &CORNERS[..N], Values::i64(node));
    let points = with_fields::<D>(points, Place::Node, &state);
    let cells = with_fields::<D>(cells, Place::Element, &state);
    fdem_io::write_vtu(out, &points, &cells, snapshot.time, &names.numbered())
}

/// Writes the broken joints as a `.vtp` file of lines, in three dimensions of triangles, with the fields of
/// joints of [`QUANTITIES`](crate::QUANTITIES).
///
/// # Errors
/// The errors of `out`.
pub fn write_cracks_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    write_joints(out, snapshot, JointState::Broken)
}

/// Writes the damaged joints, which soften and still hold, in the format of [`write_cracks_vtp`]: `broken` is
/// 0, and the time of failure is NaN.
///
/// # Errors
/// The errors of `out`.
pub fn write_damaged_joints_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    write_joints(out, snapshot, JointState::Damaged)
}

/// Writes [`Snapshot::intact`], the joints that are whole, in the format of [`write_cracks_vtp`]. Their
/// `broken`, `mode` and `damage` are 0.
///
/// # Errors
/// The errors of `out`.
pub fn write_intact_joints_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    write_joints(out, snapshot, JointState::Intact)
}

fn write_joints<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
    joints: JointState,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    let state = Instant::of(snapshot).with_joints(joints);
    let joints = state.joints();
    let corner = |k: usize| in_space(joints[k / 3 / D].corners[k / 3 % D])[k % 3];
    let points = Table::new(D * joints.len()).with_components("positions", &SPACE, Values::f64(corner));
    let lines = Table::new(joints.len()).with_components(
        "corners",
        &CORNERS[..D],
        Values::i64(|k| k.cast_signed() as i64),
    );
    let lines = with_fields::<D>(lines, Place::Joint, &state);
    fdem_io::write_poly_vtp(out, &points, Some(&lines), snapshot.time)
}

/// Writes the contact forces as a `.vtp` file of points, one for each couple of elements that press each
/// other, with the fields of contacts of [`QUANTITIES`](crate::QUANTITIES).
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] with a [`SnapshotError`](crate::SnapshotError)
/// within, also if a contact has an element that does not exist.
pub fn write_contacts_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
    forces: &Forces<D>,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    checked(snapshot)?;
    checked_contacts(snapshot, forces)?;
    let state = Instant::of(snapshot).with_forces(forces);
    let place = |k: usize| in_space(forces.contacts[k / 3].point)[k % 3];
    let points = Table::new(forces.contacts.len()).with_components("positions", &SPACE, Values::f64(place));
    let points = with_fields::<D>(points, Place::Contact, &state);
    fdem_io::write_poly_vtp(out, &points, None, snapshot.time)
}
