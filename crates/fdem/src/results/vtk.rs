//! A snapshot as files for ParaView.

use std::io::{self, Write};

use fdem_io::{Table, Values};
use fdem_simulation::{Mode, Snapshot};

use crate::results::checked;
use crate::results::stress::{principal, von_mises};

/// Writes the deformed mesh as a `.vtu` file: positions, displacements and velocities of the nodes; stress (`xx`, `yy`, `xy`, `zz`), principal stresses in
/// the plane (`max`, `min`), von Mises' stress, damage, body and material of the elements; and the time, all in SI units.
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] with a [`SnapshotError`](super::SnapshotError) within.
///
/// # Example
/// ```
/// use fdem::results::write_vtu;
///
/// let mut file = Vec::new();
/// write_vtu(&mut file, &fdem_simulation::Snapshot::default())?;
/// assert!(file.starts_with(b"<?xml"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_vtu<W: Write>(out: &mut W, snapshot: &Snapshot) -> io::Result<()> {
    checked(snapshot)?;
    let in_space = |vectors: &'_ [[f64; 2]], k: usize| if k % 3 < 2 { vectors[k / 3][k % 3] } else { 0.0 };
    let points = Table::new(snapshot.positions.len())
        .with_components("positions", &["x", "y", "z"], Values::f64(|k| in_space(&snapshot.positions, k)))
        .with_components(
            "displacement",
            &["x", "y", "z"],
            Values::f64(|k| in_space(&snapshot.displacements, k)),
        )
        .with_components("velocity", &["x", "y", "z"], Values::f64(|k| in_space(&snapshot.velocities, k)));
    let stresses = &snapshot.stresses;
    let triangles = Table::new(snapshot.triangles.len())
        .with_components(
            "nodes",
            &["a", "b", "c"],
            Values::i64(|k| i64::from(snapshot.triangles[k / 3][k % 3])),
        )
        .with_components("stress", &["xx", "yy", "xy", "zz"], Values::f64(|k| stresses[k / 4][k % 4]))
        .with_components(
            "principal_stress",
            &["max", "min"],
            Values::f64(|k| principal(stresses[k / 2])[k % 2]),
        )
        .with("von_mises", Values::f64(|k| von_mises(stresses[k])))
        .with("damage", Values::f64(|k| snapshot.damage[k]))
        .with("body", Values::i64(|k| i64::from(snapshot.bodies[k])))
        .with("material", Values::i64(|k| i64::from(snapshot.materials[k])));
    fdem_io::write_vtu(out, &points, &triangles, snapshot.time)
}

/// Writes the joints that soften or are broken as a `.vtp` file of lines: mode (0 tension, 1 shear, 2 mixed), damage, opening, sliding, time of failure
/// (not a number while they hold), length of the undeformed edge, and the two elements, all in SI units.
///
/// # Errors
/// Those of `out`.
pub fn write_cracks_vtp<W: Write>(out: &mut W, snapshot: &Snapshot) -> io::Result<()> {
    let cracks = &snapshot.cracks;
    let end = |k: usize| if k % 3 < 2 { cracks[k / 6].ends[k / 3 % 2][k % 3] } else { 0.0 };
    let points =
        Table::new(2 * cracks.len()).with_components("positions", &["x", "y", "z"], Values::f64(end));
    let lines = Table::new(cracks.len())
        .with_components("ends", &["i", "j"], Values::i64(|k| k.cast_signed() as i64))
        .with("mode", Values::i32(|k| code(cracks[k].mode)))
        .with("damage", Values::f64(|k| cracks[k].damage))
        .with("opening", Values::f64(|k| cracks[k].opening))
        .with("sliding", Values::f64(|k| cracks[k].sliding))
        .with("time_of_failure", Values::f64(|k| cracks[k].time.unwrap_or(f64::NAN)))
        .with("length", Values::f64(|k| cracks[k].length))
        .with_components(
            "elements",
            &["one", "other"],
            Values::i64(|k| i64::from(cracks[k / 2].elements[k % 2])),
        );
    fdem_io::write_vtp(out, &points, &lines)
}

/// How files number it.
fn code(mode: Mode) -> i32 {
    match mode {
        Mode::Tension => 0,
        Mode::Shear => 1,
        Mode::Mixed => 2,
    }
}
