//! Checks that the lists of spheres agree with each other.

use fdem_simulation::grains::{GrainPartner, SphereColumns};

use crate::run::snapshot::SnapshotError;

/// Checks that every list has its length, and that the spheres and walls of all contacts exist.
pub(super) fn checked(spheres: &SphereColumns) -> Result<(), SnapshotError> {
    let (count, walls) = (spheres.positions.len(), spheres.walls.len());
    for (name, found, expected) in [
        ("numbers of spheres", spheres.numbers.len(), count),
        ("radii", spheres.radii.len(), count),
        ("velocities of spheres", spheres.velocities.len(), count),
        ("spins", spheres.spins.len(), count),
        ("forces on spheres", spheres.forces.len(), count),
        ("masses", spheres.masses.len(), count),
        ("materials of spheres", spheres.materials.len(), count),
        ("groups of spheres", spheres.groups.len(), count),
        ("forces on walls", spheres.wall_forces.len(), walls),
    ] {
        if found != expected {
            return Err(SnapshotError::Length { name, found, expected });
        }
    }
    for contact in &spheres.contacts {
        let (of_others, other, most) = match contact.other {
            GrainPartner::Sphere(other) => ("sphere", other, count),
            GrainPartner::Wall(other) => ("wall", other, walls),
            // The facets are not among the columns.
            GrainPartner::Facet(other) => ("facet", other, usize::MAX),
        };
        for (what, number, most) in [("sphere", contact.sphere, count), (of_others, other, most)] {
            if number as usize >= most {
                return Err(SnapshotError::Grain { what, number, most });
            }
        }
    }
    Ok(())
}
