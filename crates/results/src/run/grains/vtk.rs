//! Writes spheres, their contacts and walls as files for ParaView.

use std::io::{self, Write};

use fdem_io::{Table, Values};
use fdem_simulation::grains::SphereColumns;
use fdem_simulation::{Element, Snapshot};

use crate::fields::place::Place;
use crate::fields::state::{Instant, in_space};
use crate::run::file_fields::{with_fields, with_fields_of};
use crate::run::grains::columns::checked;
use crate::run::grains::frame::end_of;
use crate::run::grains::walls::{Bounds, bounds_of, triangles, union};

const SPACE: [&str; 3] = ["x", "y", "z"];
const CORNERS: [&str; 3] = ["a", "b", "c"];

/// Writes the spheres as a `.vtp` file of points at their centres, with the fields of spheres of
/// [`QUANTITIES`](crate::QUANTITIES). In ParaView, *Point Gaussian* or *Glyph* by `radius` shows them.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] with a [`SnapshotError`](crate::SnapshotError)
/// within.
pub fn write_spheres_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    let spheres = &snapshot.spheres;
    checked(spheres)?;
    let state = Instant::of(snapshot);
    let place = |k: usize| spheres.positions[k / 3][k % 3];
    let points = Table::new(spheres.positions.len()).with_components("positions", &SPACE, Values::f64(place));
    let points = with_fields::<D>(points, Place::Sphere, &state);
    fdem_io::write_poly_vtp(out, &points, None, snapshot.time)
}

/// Writes the contacts of the spheres as a `.vtp` file of lines, from the centre of a sphere to that of the
/// other, or to the place of the contact with a wall or a body, with the fields of contacts of spheres of
/// [`QUANTITIES`](crate::QUANTITIES): the force chains. A contact through a periodic boundary leads to the
/// image of the other sphere.
///
/// # Errors
/// As [`write_spheres_vtp`].
pub fn write_sphere_contacts_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    let spheres = &snapshot.spheres;
    checked(spheres)?;
    let state = Instant::of(snapshot);
    let contacts = &spheres.contacts;
    let end = |k: usize| {
        let contact = &contacts[k / 6];
        match k / 3 % 2 {
            0 => spheres.positions[contact.sphere as usize][k % 3],
            _ => end_of(spheres, contact)[k % 3],
        }
    };
    let points = Table::new(2 * contacts.len()).with_components("positions", &SPACE, Values::f64(end));
    let lines = Table::new(contacts.len()).with_components("corners", &CORNERS[..2], Values::i64(whole));
    let lines = with_fields::<D>(lines, Place::SphereContact, &state);
    fdem_io::write_poly_vtp(out, &points, Some(&lines), snapshot.time)
}

/// Writes the walls as a `.vtp` file of triangles where they are, or of lines in two dimensions, with the
/// fields of walls of [`QUANTITIES`](crate::QUANTITIES). A plane is a rectangle that covers spheres and
/// bodies; a tube is as long.
///
/// # Errors
/// As [`write_spheres_vtp`].
pub fn write_walls_vtp<W: Write, const D: usize, const N: usize>(
    out: &mut W,
    snapshot: &Snapshot<D, N>,
) -> io::Result<()>
where
    [[f64; D]; N]: Element<D, N>,
{
    let spheres = &snapshot.spheres;
    checked(spheres)?;
    let state = Instant::of(snapshot);
    let walls = triangles(spheres, around(snapshot));
    let corners = if spheres.discs.is_some() { 2 } else { 3 };
    let place = |k: usize| walls[k / 3 / corners].corners[k / 3 % corners][k % 3];
    let points = Table::new(corners * walls.len()).with_components("positions", &SPACE, Values::f64(place));
    let cells = Table::new(walls.len()).with_components("corners", &CORNERS[..corners], Values::i64(whole));
    let owner = |cell: usize| walls[cell].wall as usize;
    let cells = with_fields_of::<D>(cells, Place::Wall, &state, &owner);
    fdem_io::write_poly_vtp(out, &points, Some(&cells), snapshot.time)
}

/// Returns the bounds of spheres and bodies.
fn around<const D: usize, const N: usize>(snapshot: &Snapshot<D, N>) -> Bounds {
    let SphereColumns { positions, radii, .. } = &snapshot.spheres;
    let of_spheres = positions
        .iter()
        .zip(radii)
        .flat_map(|(centre, radius)| [-radius, *radius].map(|by| centre.map(|x| x + by)));
    let finite = |point: &[f64; 3]| point.iter().all(|x| x.is_finite());
    let of_nodes = snapshot.positions.iter().map(|&node| in_space(node));
    union(bounds_of(of_spheres.filter(finite)), bounds_of(of_nodes.filter(finite)))
}

fn whole(number: usize) -> i64 {
    number.cast_signed() as i64
}
