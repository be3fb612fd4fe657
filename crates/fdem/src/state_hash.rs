//! The hash of the state of a run.

use fdem_simulation::{Energies, Snapshot};
use sha2::{Digest, Sha256};

/// SHA-256 of positions, velocities, stresses, cracks, spheres and energies in hexadecimal digits:
/// `state_hash` of `run.json`. It does not depend on the number of threads or on interruptions.
pub fn state_hash<const D: usize, const N: usize>(snapshot: &Snapshot<D, N>, energies: &Energies) -> String {
    let mut hash = Sha256::new();
    let mut add = |number: f64| hash.update(number.to_bits().to_le_bytes());
    snapshot.positions.iter().chain(&snapshot.velocities).flatten().for_each(|&number| add(number));
    snapshot.stresses.iter().flatten().chain(&snapshot.damage).for_each(|&number| add(number));
    for crack in &snapshot.cracks {
        [crack.damage, crack.opening, crack.sliding, crack.time.unwrap_or(f64::NAN)]
            .into_iter()
            .for_each(&mut add);
    }
    let spheres = &snapshot.spheres;
    let vectors = [&spheres.positions, &spheres.velocities, &spheres.spins, &spheres.wall_forces];
    vectors.into_iter().flatten().flatten().for_each(|&number| add(number));
    // The parts of the cohesive energy are not among these: they do not change the course of a run.
    let Energies { kinetic, strain, contact, friction, cohesive, damping, external, initial, stored, .. } =
        energies;
    [kinetic, strain, contact, friction, cohesive, damping, external, initial]
        .into_iter()
        .chain(stored.iter().flatten())
        .for_each(|&energy| add(energy));
    format!("{:x}", hash.finalize())
}
