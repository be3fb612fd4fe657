//! Constants of a porous material.

use serde::{Deserialize, Serialize};

use crate::error::{FluidError, check};

/// A porous material that is full of a liquid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[[f64; D]; D]: Serialize", deserialize = "[[f64; D]; D]: Deserialize<'de>"))]
pub struct PorousMaterial<const D: usize> {
    /// Permeability, m²: a symmetric tensor without a negative value. Zero for pores without flow.
    pub permeability: [[f64; D]; D],
    /// Biot's coefficient `α`, from 0 to 1: the volume of liquid that leaves a drained body over the volume
    /// that the body loses.
    pub biot: f64,
    /// Storage `1/M`, 1/Pa: the volume of liquid that a body takes for each Pa while its own volume stays.
    pub storage: f64,
}

impl<const D: usize> PorousMaterial<D> {
    /// A material with the same permeability in all directions, m².
    pub fn isotropic(permeability: f64, biot: f64, storage: f64) -> Self {
        let row = |axis: usize| std::array::from_fn(|k| if k == axis { permeability } else { 0.0 });
        Self { permeability: std::array::from_fn(row), biot, storage }
    }

    /// Storage of a porosity `φ`, `1/M = φ/K_f + (α - φ)/K_s`, 1/Pa, with the bulk moduli of the liquid and
    /// of the grains, Pa.
    ///
    /// # Source
    /// M. A. Biot and D. G. Willis, "The elastic coefficients of the theory of consolidation", J. Appl. Mech.
    /// 24 (1957) 594-601.
    pub fn storage_of(porosity: f64, biot: f64, liquid: f64, grains: f64) -> f64 {
        porosity / liquid + (biot - porosity) / grains
    }

    /// Modulus that the liquid adds to the bulk modulus of the body while no liquid can flow, `α² M`, Pa.
    pub fn undrained_modulus(&self) -> f64 {
        self.biot * self.biot / self.storage
    }

    /// Refuses numbers out of their ranges. `place`: the name of the material in messages.
    ///
    /// # Errors
    /// The first such number.
    pub fn check(&self, place: &str) -> Result<(), FluidError> {
        check((0.0..=1.0).contains(&self.biot), place, "Biot's coefficient", self.biot, "from 0 to 1")?;
        check(self.storage > 0.0, place, "storage", self.storage, "positive")?;
        let k = &self.permeability;
        let range = "a symmetric tensor without a negative value";
        for row in 0..D {
            for column in 0..=row {
                let value = k[row][column];
                let is_inside = value == k[column][row] && k[row][row] >= 0.0;
                check(is_inside, place, "permeability", value, range)?;
                let minor = k[row][row] * k[column][column] - value * value;
                check(row == column || minor >= 0.0, place, "permeability", value, range)?;
            }
        }
        // All entries of one size, so that the product of three of them is a number.
        let most = k.as_flattened().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        if D == 3 && most > 0.0 {
            let at = |row: usize, column: usize| k[row][column] / most;
            let determinant = at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(1, 2))
                - at(0, 1) * (at(0, 1) * at(2, 2) - at(1, 2) * at(0, 2))
                + at(0, 2) * (at(0, 1) * at(1, 2) - at(1, 1) * at(0, 2));
            check(determinant >= -1e-12, place, "determinant of the permeability", determinant, range)?;
        }
        Ok(())
    }
}
