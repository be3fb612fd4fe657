//! Numbers of contacts of spheres.

use fdem_simulation::grains::{GrainPartner, SphereColumns};

/// Returns the number of contacts of each sphere: with spheres, walls and bodies. Contacts with several
/// facets of a body count one by one.
pub(crate) fn coordination(spheres: &SphereColumns) -> Vec<u32> {
    let mut counts = vec![0; spheres.positions.len()];
    for contact in &spheres.contacts {
        let other = match contact.other {
            GrainPartner::Sphere(other) => Some(other),
            GrainPartner::Wall(_) | GrainPartner::Facet(_) => None,
        };
        for sphere in std::iter::once(contact.sphere).chain(other) {
            if let Some(count) = counts.get_mut(sphere as usize) {
                *count += 1;
            }
        }
    }
    counts
}
