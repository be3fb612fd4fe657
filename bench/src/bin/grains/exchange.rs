//! Spheres in the data files of LAMMPS, so that both programs begin with the same ones.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use fdem_grains::Spheres;

use crate::case::{CHUTE, Place, TUBE, stretch};

/// Writes the spheres as a data file of `atom_style sphere`. Held spheres have the type 2.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write(path: &Path, place: Place, spheres: &Spheres) -> Result<(), Box<dyn Error>> {
    let count = spheres.positions.len();
    let scale = stretch(place, count);
    let sides = match place {
        Place::Chute => [[0.0, scale * CHUTE[0]], [0.0, scale * CHUTE[1]], [-1.0, 4.0 * CHUTE[2]]],
        Place::Tube => {
            let half = scale * TUBE[0] + 1.0;
            [[-half, half], [-half, half], [-1.0, 2.0 * TUBE[1]]]
        }
    };
    let mut text = format!("Spheres of the benchmark\n\n{count} atoms\n2 atom types\n\n");
    for ([low, high], axis) in sides.into_iter().zip(["x", "y", "z"]) {
        writeln!(text, "{low:?} {high:?} {axis}lo {axis}hi")?;
    }
    // Number, type, diameter, density, centre.
    text.push_str("\nAtoms # sphere\n\n");
    for sphere in 0..count {
        let ([x, y, z], radius) = (spheres.positions[sphere], spheres.radii[sphere]);
        let kind = 1 + u8::from(spheres.held[sphere]);
        writeln!(text, "{} {kind} {:?} 1.0 {x:?} {y:?} {z:?}", sphere + 1, 2.0 * radius)?;
    }
    text.push_str("\nVelocities\n\n");
    for sphere in 0..count {
        let ([u, v, w], [p, q, r]) = (spheres.velocities[sphere], spheres.spins[sphere]);
        writeln!(text, "{} {u:?} {v:?} {w:?} {p:?} {q:?} {r:?}", sphere + 1)?;
    }
    Ok(std::fs::write(path, text)?)
}

/// Reads the spheres of a file that [`write()`] has written.
///
/// # Errors
/// The file cannot be read, or a line is not as `write` writes it.
pub(crate) fn read(path: &Path) -> Result<Spheres, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let mut spheres = Spheres::default();
    let mut part = "";
    for (number, line) in text.lines().enumerate() {
        if line.starts_with("Atoms") || line.starts_with("Velocities") {
            part = line;
            continue;
        }
        if line.is_empty() || part.is_empty() {
            continue;
        }
        let words: Option<Vec<f64>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
        match (part.starts_with("Atoms"), words.as_deref()) {
            (true, Some(&[_, kind, diameter, _, x, y, z])) => {
                spheres.positions.push([x, y, z]);
                spheres.radii.push(0.5 * diameter);
                spheres.held.push(kind > 1.5);
            }
            (false, Some(&[_, u, v, w, p, q, r])) => {
                spheres.velocities.push([u, v, w]);
                spheres.spins.push([p, q, r]);
            }
            _ => return Err(format!("{}, line {}: {line}", path.display(), number + 1).into()),
        }
    }
    Ok(spheres)
}
