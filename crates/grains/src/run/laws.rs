//! The laws of all pairs of materials.

use crate::error::GrainError;
use crate::law::PairLaw;
use crate::material::ForceLaw;
use crate::model::GrainModel;
use crate::run::balls::Ball;

/// A pair without a law.
const UNKNOWN: u16 = u16::MAX;

/// The law of each pair of materials.
#[derive(Clone, Debug)]
pub(crate) struct Laws {
    kinds: usize,
    of_pair: Vec<u16>,
    pub(crate) list: Vec<PairLaw>,
}

impl Laws {
    pub(crate) fn new(model: &GrainModel) -> Self {
        let kinds = model.materials.len();
        let mut laws = Self { kinds, of_pair: vec![UNKNOWN; kinds * kinds], list: Vec::new() };
        for surfaces in &model.surfaces {
            let [a, b] = surfaces.materials.map(|material| material as usize);
            let number = laws.list.len() as u16;
            (laws.of_pair[a * kinds + b], laws.of_pair[b * kinds + a]) = (number, number);
            laws.list.push(PairLaw::new(model.law, [&model.materials[a], &model.materials[b]], surfaces));
        }
        laws
    }

    /// No force between any of these materials.
    pub(crate) fn none(&self) -> Self {
        Self { kinds: self.kinds, of_pair: vec![0; self.of_pair.len()], list: vec![PairLaw::NONE] }
    }

    /// Whether none of them has a force.
    pub(crate) fn are_none(&self) -> bool {
        self.list.iter().all(|law| matches!(law.law, ForceLaw::Hooke { normal: 0.0, .. }))
    }

    /// Number of the law of all pairs of these spheres, if they have one only.
    pub(crate) fn lone(&self, balls: &[Ball]) -> Option<usize> {
        let material = balls.first()?.material;
        let is_lone = balls.iter().all(|ball| ball.material == material);
        if is_lone { self.number([material; 2]).ok() } else { None }
    }

    /// Number of the law of two materials.
    ///
    /// # Errors
    /// [`GrainError::UnknownSurfaces`] if they have none.
    #[inline]
    pub(crate) fn number(&self, materials: [u32; 2]) -> Result<usize, GrainError> {
        let number = self.of_pair[materials[0] as usize * self.kinds + materials[1] as usize];
        if number == UNKNOWN {
            return Err(GrainError::UnknownSurfaces { materials });
        }
        Ok(number as usize)
    }

    /// The law of two materials.
    ///
    /// # Errors
    /// [`GrainError::UnknownSurfaces`] if they have none.
    #[inline]
    pub(crate) fn of(&self, materials: [u32; 2]) -> Result<&PairLaw, GrainError> {
        Ok(&self.list[self.number(materials)?])
    }

    /// Largest distance at which two bodies with this reduced radius still touch once they did, m.
    pub(crate) fn reach(&self, radius: f64) -> f64 {
        self.list.iter().map(|law| law.reach(radius)).fold(0.0, f64::max)
    }

    /// Whether any contact has a spring against rolling or twisting.
    pub(crate) fn roll(&self) -> bool {
        self.list.iter().any(PairLaw::rolls)
    }
}
