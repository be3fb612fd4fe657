//! Whether boundaries move so fast that inertia adds to the strength of a specimen.
//!
//! A specimen takes a time to fail that is proportional to the passage of a wave, and its load grows
//! meanwhile. The excess of strength therefore depends on the stress of the wave of the boundary, density
//! times wave speed times velocity, over the strength: it is the straight line that fits the measurements of
//! three tests. The book has their table ("Runs that are to be quasi-static").

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::bounds;
use fdem_simulation::{Boundary, Load, Material, Model, Strength};

use crate::advice::deforming;
use crate::advice::pressing::presses;

/// Excess of strength from which there is a warning, and that with the velocity that is proposed.
const EXCESS: f64 = 0.06;
const PROPOSED: f64 = 0.05;

/// Stress of a wave over the strength from which a number of the material is wrong, rather than the velocity.
const FAR: f64 = 1e5;

/// Share of the width of a body from which a load or a side is as wide as the body.
const WIDE: f64 = 0.8;

/// Part of the length of a body that is its end.
const END: f64 = 0.02;

/// The way in which a load breaks a body: it pulls at it, splits it, or presses on a whole side.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Failure {
    Pulled,
    Split,
    Crushed,
}

impl Failure {
    /// The strength that decides, Pa, with its name.
    fn strength(self, strength: &Strength) -> (f64, &'static str) {
        match self {
            Self::Pulled | Self::Split => (strength.tensile, "tensile strength"),
            // 2 c cos φ/(1 - sin φ), with the tangent of φ.
            Self::Crushed => {
                let tangent = strength.friction;
                (2.0 * strength.cohesion * (tangent + tangent.hypot(1.0)), "compressive strength")
            }
        }
    }

    /// The measured line: excess of strength over the stress of the wave as a share of the strength, and that
    /// share up to which there is none.
    fn line(self) -> [f64; 2] {
        match self {
            Self::Pulled => [0.06, 0.2],
            Self::Split => [0.29, 0.1],
            Self::Crushed => [1.3, 0.04],
        }
    }
}

/// Advice on the fastest of these boundaries if the excess of strength is more than about 5 %.
pub(crate) fn advice<'a, const D: usize, const N: usize>(
    model: &'a Model<D, N>,
    boundaries: impl Iterator<Item = &'a Boundary<D>>,
) -> Option<String> {
    let speed = |boundary: &Boundary<D>| velocity(boundary).iter().map(|v| v * v).sum::<f64>().sqrt();
    // The first of several that are as fast.
    let fastest = boundaries.reduce(|one, other| if speed(other) > speed(one) { other } else { one })?;
    let axis = (0..D).reduce(|most, axis| {
        if velocity(fastest)[axis].abs() > velocity(fastest)[most].abs() { axis } else { most }
    })?;
    // Each of two platens has half of the speed at which they approach each other; other parts rest.
    let along = model.boundaries.iter().filter(|boundary| matches!(boundary.load, Load::Velocity(_)));
    let [low, high] = along
        .map(|boundary| velocity(boundary)[axis])
        .fold([0.0_f64; 2], |[low, high], v| [low.min(v), high.max(v)]);
    let half = 0.5 * (high - low);
    let failure = if !presses(fastest, model) {
        Failure::Pulled
    } else if is_wide(model, fastest, axis) {
        Failure::Crushed
    } else {
        Failure::Split
    };
    let mut worst: Option<(f64, &Material, &'static str)> = None;
    let deforming = model.materials.iter().zip(deforming::materials(model)).filter(|(_, deforms)| *deforms);
    for (material, _) in deforming {
        let Some((size, name)) = material.strength.as_ref().map(|strength| failure.strength(strength)) else {
            continue;
        };
        let share = material.density * material.bar_speed() * half / size;
        if worst.is_none_or(|(most, ..)| share > most) {
            worst = Some((share, material, name));
        }
    }
    let (share, material, name) = worst?;
    let [slope, least] = failure.line();
    let excess = slope * (share - least);
    if excess <= EXCESS || excess.is_nan() {
        return None;
    }
    let expected = if excess > 1.0 {
        "more than twice".to_owned()
    } else {
        format!("about {:.0} % above", 100.0 * excess)
    };
    let of_strength = if share < FAR {
        format!("{share:.2} of")
    } else {
        format!("more than {} times", grouped(FAR as u64))
    };
    let slow = speed(fastest) * (least + PROPOSED / slope) / share;
    let remedy = if share < FAR {
        format!("take at most {} m/s, with which the excess is 5 %", brief_of_two(slow))
    } else {
        "see that the numbers of the material are in the right units".to_owned()
    };
    Some(format!(
        "[[boundary]] \"{}\" moves at {} m/s: the strength of \"{}\" will be {expected} that under a slow load, by inertia \
         (the stress of its wave, density times wave speed times velocity, is {of_strength} the {name}); if a slow load is meant, {remedy}",
        fastest.name,
        brief(speed(fastest)),
        material.name,
    ))
}

/// A number with two digits.
fn brief_of_two(number: f64) -> String {
    let digits = 10.0_f64.powi(1 - number.abs().log10().floor() as i32);
    brief((number * digits).floor() / digits)
}

fn velocity<const D: usize>(boundary: &Boundary<D>) -> [f64; D] {
    match boundary.load {
        Load::Velocity(components) => components.map(Option::unwrap_or_default),
        _ => [0.0; D],
    }
}

/// Whether a boundary is as wide as the bodies that break, and these are as wide at both ends as between, so
/// that the load presses on a whole side.
fn is_wide<const D: usize, const N: usize>(model: &Model<D, N>, boundary: &Boundary<D>, axis: usize) -> bool {
    let mesh = &model.mesh;
    let place = |node: u32| mesh.nodes[node as usize];
    let breaks = |material: u32| model.materials[material as usize].strength.is_some();
    let breaking = || {
        let elements = deforming::elements(model).filter(|&element| breaks(mesh.materials[element as usize]));
        elements.flat_map(|element| mesh.elements[element as usize].map(place))
    };
    let whole = bounds(breaking());
    let length = whole[1][axis] - whole[0][axis];
    let ends = [whole[0][axis] + END * length, whole[1][axis] - END * length];
    let parts = [
        bounds(breaking().filter(|at| at[axis] <= ends[0])),
        bounds(breaking().filter(|at| at[axis] >= ends[1])),
        bounds(boundary.target.nodes().into_iter().map(place)),
    ];
    parts.iter().all(|[low, high]| {
        (0..D)
            .filter(|&across| across != axis)
            .all(|across| high[across] - low[across] >= WIDE * (whole[1][across] - whole[0][across]))
    })
}
