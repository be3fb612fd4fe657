//! Fields by which elements are coloured.

use fdem_simulation::Snapshot;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::picture::colour::{self, HEAT, Rgb, SEA};
use crate::run::stress::von_mises;

/// A quantity by which elements are coloured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Field {
    /// The largest principal stress, in two dimensions that in the plane, tension positive, Pa.
    MaxPrincipal,
    /// The smallest principal stress, in two dimensions that in the plane, tension positive, Pa.
    MinPrincipal,
    /// The von Mises equivalent stress, Pa.
    VonMises,
    /// The magnitude of the velocity, m/s.
    Velocity,
    /// The magnitude of the displacement, m.
    Displacement,
    /// The largest damage of the joints of the element, from 0 to 1.
    Damage,
    /// Number of the body.
    Body,
    /// Number of the material.
    Material,
}

/// Fields with a continuous scale, in the order of their arrays in a frame.
pub(crate) const SCALES: [Field; 6] = [
    Field::MaxPrincipal,
    Field::MinPrincipal,
    Field::VonMises,
    Field::Velocity,
    Field::Displacement,
    Field::Damage,
];

/// Colours of signed fields: blue for compression, red for tension, pale at zero. Colours at equal distance
/// from the middle are about equally light.
const SIGNED: [Rgb; 17] = [
    [9, 48, 112],
    [20, 70, 146],
    [36, 93, 176],
    [64, 118, 194],
    [99, 143, 208],
    [137, 170, 219],
    [175, 197, 229],
    [209, 220, 236],
    [235, 235, 235],
    [242, 218, 205],
    [243, 193, 170],
    [239, 163, 133],
    [229, 131, 100],
    [213, 97, 73],
    [189, 63, 54],
    [158, 32, 42],
    [117, 8, 32],
];

/// Colours of bodies and materials, used in turn.
pub(crate) const NUMBERED: [Rgb; 8] = [
    [127, 172, 214],
    [176, 157, 211],
    [126, 192, 153],
    [222, 180, 120],
    [150, 180, 188],
    [216, 143, 167],
    [184, 197, 118],
    [155, 165, 196],
];

/// Colour of elements without a value.
pub(crate) const NO_VALUE: Rgb = [203, 205, 208];

impl Field {
    /// All fields.
    pub const ALL: [Self; 8] = [
        Self::MaxPrincipal,
        Self::MinPrincipal,
        Self::VonMises,
        Self::Velocity,
        Self::Displacement,
        Self::Damage,
        Self::Body,
        Self::Material,
    ];

    /// Returns the name of the field in options, model files and reports.
    pub fn key(self) -> &'static str {
        match self {
            Self::MaxPrincipal => "max_principal",
            Self::MinPrincipal => "min_principal",
            Self::VonMises => "von_mises",
            Self::Velocity => "velocity",
            Self::Displacement => "displacement",
            Self::Damage => "damage",
            Self::Body => "body",
            Self::Material => "material",
        }
    }

    /// Returns the name of the field in texts.
    pub fn name(self) -> &'static str {
        match self {
            Self::MaxPrincipal => "largest principal stress",
            Self::MinPrincipal => "smallest principal stress",
            Self::VonMises => "von Mises stress",
            Self::Velocity => "velocity",
            Self::Displacement => "displacement",
            Self::Damage => "damage",
            Self::Body => "body",
            Self::Material => "material",
        }
    }

    /// Returns the unit of the values; empty if they have none.
    pub fn unit(self) -> &'static str {
        match self {
            Self::MaxPrincipal | Self::MinPrincipal | Self::VonMises => "Pa",
            Self::Velocity => "m/s",
            Self::Displacement => "m",
            Self::Damage | Self::Body | Self::Material => "",
        }
    }

    /// Returns the index of the field in [`SCALES`].
    pub(crate) fn scale(self) -> Option<usize> {
        SCALES.iter().position(|&other| other == self)
    }

    /// Whether the values have a sign. The colours of such a field are pale at 0.
    pub(crate) fn signed(self) -> bool {
        matches!(self, Self::MaxPrincipal | Self::MinPrincipal)
    }

    /// Returns the colours from the lowest value to the highest.
    pub(crate) fn ramp(self) -> &'static [Rgb; 17] {
        match self {
            Self::MaxPrincipal | Self::MinPrincipal => &SIGNED,
            Self::VonMises | Self::Damage => &HEAT,
            Self::Velocity | Self::Displacement | Self::Body | Self::Material => &SEA,
        }
    }

    /// Returns the values of all elements of a snapshot that has been checked.
    pub(crate) fn values<const D: usize, const N: usize>(self, snapshot: &Snapshot<D, N>) -> Vec<f64>
    where
        Snapshot<D, N>: Principal,
    {
        let mean = |vectors: &[[f64; D]]| -> Vec<f64> {
            let of = |nodes: &[u32; N]| {
                let sum = |axis: usize| nodes.iter().map(|&node| vectors[node as usize][axis]).sum::<f64>();
                (0..D).map(sum).fold(0.0, f64::hypot) / N as f64
            };
            snapshot.elements.iter().map(of).collect()
        };
        let principal = |k: usize| {
            let elements = 0..snapshot.elements.len();
            elements.map(|element| snapshot.principal(element)[k]).collect()
        };
        match self {
            Self::MaxPrincipal => principal(0),
            Self::MinPrincipal => principal(1),
            Self::VonMises => snapshot.stresses.iter().map(|&stress| von_mises(stress)).collect(),
            Self::Velocity => mean(&snapshot.velocities),
            Self::Displacement => mean(&snapshot.displacements),
            Self::Damage => snapshot.damage.clone(),
            Self::Body => snapshot.bodies.iter().map(|&body| f64::from(body)).collect(),
            Self::Material => snapshot.materials.iter().map(|&material| f64::from(material)).collect(),
        }
    }

    /// Returns the colour of a value on a scale with this range.
    pub(crate) fn colour(self, value: f64, range: Range) -> Rgb {
        if value.is_nan() {
            return NO_VALUE;
        }
        colour::at(self.ramp(), range.share(value))
    }
}

/// Snapshots of triangles and of tetrahedra. The trait with which `Snapshot` has both is private to its
/// crate.
pub(crate) trait Principal {
    /// Largest and smallest principal stress of an element, Pa.
    fn principal(&self, element: usize) -> [f64; 2];
}

impl Principal for Snapshot {
    fn principal(&self, element: usize) -> [f64; 2] {
        self.principal_stresses(element)
    }
}

impl Principal for Snapshot<3, 4> {
    fn principal(&self, element: usize) -> [f64; 2] {
        self.principal_stresses(element)
    }
}

/// Returns the colour of a body or a material by its number. Consecutive numbers have different colours.
pub(crate) fn numbered_colour(number: u32) -> Rgb {
    NUMBERED[number as usize % NUMBERED.len()]
}

/// Range of the values of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// The least and the greatest finite value.
    pub(crate) ends: [f64; 2],
    /// The 1st and the 99th percentile.
    pub(crate) usual: [f64; 2],
}

/// The values at the two ends of a colour scale. Values beyond an end have the colour of that end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Value at the start.
    pub low: f64,
    /// Value at the end.
    pub high: f64,
}

impl Range {
    /// Returns the range of a series by the scales of its frames.
    pub(crate) fn covering<'a>(
        frames: impl Iterator<Item = &'a [Scale; SCALES.len()]>,
        field: Field,
    ) -> Self {
        let Some(scale) = field.scale().filter(|_| field != Field::Damage) else {
            return Self { low: 0.0, high: 1.0 };
        };
        let mut largest = 0.0_f64;
        for scales in frames {
            let [low, high] = scales[scale].usual;
            largest = largest.max(high);
            if field.signed() {
                largest = largest.max(-low);
            }
        }
        let high = if largest > 0.0 { largest } else { 1.0 };
        Self { low: if field.signed() { -high } else { 0.0 }, high }
    }

    /// Returns the position of a value between the two ends: 0 at the low end, 1 at the high end.
    pub(crate) fn share(self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn model_files_call_fields_by_their_keys() {
        for field in Field::ALL {
            assert_eq!(serde_json::json!(field), field.key());
        }
    }

    #[test]
    fn no_stress_is_pale_and_both_signs_are_as_dark() {
        let range = Range { low: -2.0, high: 2.0 };
        assert_eq!(Field::MaxPrincipal.colour(0.0, range), SIGNED[8]);
        assert_eq!(Field::MaxPrincipal.colour(9.0, range), SIGNED[16]);
        assert_eq!(Field::MaxPrincipal.colour(f64::NAN, range), NO_VALUE);
        let light = |[r, g, b]: Rgb| 2 * i32::from(r) + 5 * i32::from(g) + i32::from(b);
        for k in 0..8 {
            assert!(light(SIGNED[k]) < light(SIGNED[k + 1]) && light(SIGNED[16 - k]) < light(SIGNED[15 - k]));
        }
    }
}
