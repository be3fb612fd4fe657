//! The clumps of a model: mass and moments of inertia, and whether they can be simulated.

use crate::clump::ClumpInertia;
use crate::error::GrainError;
use crate::model::{GrainModel, Spheres, within};
use crate::rotation::inverse;

impl GrainModel {
    /// Mass, centre and moments of inertia of a clump.
    pub(crate) fn inertia_of(&self, clump: usize) -> ClumpInertia {
        let of = &self.clumps[clump];
        of.inertia.unwrap_or_else(|| {
            let members = || of.spheres.iter().map(|&sphere| sphere as usize);
            let centres: Vec<[f64; 3]> = members().map(|sphere| self.spheres.positions[sphere]).collect();
            let radii: Vec<f64> = members().map(|sphere| self.spheres.radii[sphere]).collect();
            let material = members().next().map_or(0, |sphere| self.material_of(sphere));
            let density = self.materials[material as usize].density;
            match self.discs {
                Some(thickness) => ClumpInertia::of_discs(&centres, &radii, density, thickness),
                None => ClumpInertia::of_spheres(&centres, &radii, density),
            }
        })
    }

    /// Checks all clumps.
    ///
    /// # Errors
    /// The first clump that is wrong.
    pub(crate) fn check_clumps(&self) -> Result<(), GrainError> {
        let Spheres { positions, velocities, spins, held, .. } = &self.spheres;
        let mut taken = vec![false; positions.len()];
        for (clump, of) in self.clumps.iter().enumerate() {
            let wrong = |why| Err(GrainError::Clump { clump, why });
            if of.spheres.is_empty() {
                return wrong("it has no spheres");
            }
            if !of.spheres.is_sorted_by(|a, b| a < b) {
                return wrong("the numbers of its spheres do not ascend");
            }
            let is_held = |sphere: u32| held.get(sphere as usize).copied().unwrap_or(false);
            let density = |sphere: u32| self.materials[self.material_of(sphere as usize) as usize].density;
            for &sphere in &of.spheres {
                let Some(taken) = taken.get_mut(sphere as usize) else {
                    return wrong("one of its spheres does not exist");
                };
                if std::mem::replace(taken, true) {
                    return wrong("one of its spheres belongs to another clump");
                }
                let moves = [velocities, spins].map(|list| list.get(sphere as usize).copied());
                if moves.into_iter().flatten().any(|given| given != [0.0; 3]) {
                    return wrong("one of its spheres has a velocity or a spin: give it to the clump");
                }
                if is_held(sphere) != is_held(of.spheres[0]) {
                    return wrong("some of its spheres are held, and others are not");
                }
                if of.inertia.is_none() && density(sphere) != density(of.spheres[0]) {
                    return wrong("its spheres have several densities: give its mass and moments of inertia");
                }
            }
            let place = || format!("clump {clump}");
            for &x in of.velocity.iter().chain(&of.spin) {
                within(place, "a velocity", x, true, "a number")?;
            }
            let ClumpInertia { mass, centre, moments } = self.inertia_of(clump);
            within(place, "mass", mass, mass > 0.0, "above 0")?;
            for &x in centre.iter().chain(moments.iter().flatten()) {
                within(place, "the centre or a moment of inertia", x, true, "a number")?;
            }
            if inverse(&moments).is_none() {
                return wrong("its moments of inertia are not those of a body");
            }
            if self.domain.is_some_and(|domain| domain.grows()) {
                return wrong("the box grows, and clumps cannot follow it");
            }
        }
        Ok(())
    }
}
