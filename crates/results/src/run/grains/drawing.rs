//! Spheres, force chains and walls as pictures show them.

use crate::fields::colours::numbered_colour;
use crate::fields::field::Field;
use crate::fields::range::Range;
use crate::picture::colour::Rgb;
use crate::run::grains::frame::{GrainFrame, OpenedGrains};
use crate::run::grains::walls::WallTriangle;

/// Colour of spheres among force chains, of walls, and of contacts that pull.
pub(crate) const PALE_SPHERE: Rgb = [228, 232, 236];
pub(crate) const WALL: Rgb = [70, 84, 98];
pub(crate) const PULLING: Rgb = [36, 93, 176];

/// Half the width of the line of a contact at the upper end of the colours, over the radius of the spheres.
pub(crate) const WIDEST: f64 = 0.45;
/// Least and greatest share of that.
const SHARES: [f64; 2] = [0.04, 1.6];

/// Spheres, lines of contacts and walls, m, with their colours.
#[derive(Clone, Debug, Default)]
pub(crate) struct GrainScene {
    pub(crate) spheres: Vec<DrawnSphere>,
    pub(crate) chains: Vec<DrawnChain>,
    pub(crate) walls: Vec<WallTriangle>,
}

/// A sphere or a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DrawnSphere {
    pub(crate) centre: [f64; 3],
    pub(crate) radius: f64,
    pub(crate) colour: Rgb,
}

/// The line of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DrawnChain {
    pub(crate) ends: [[f64; 3]; 2],
    /// Half of its width.
    pub(crate) radius: f64,
    pub(crate) colour: Rgb,
}

impl GrainScene {
    /// Returns the scene of a frame, coloured by a field with this range; `None` if the frame is damaged.
    /// Spheres without values of the field have the colours of their groups.
    pub(crate) fn new(frame: &GrainFrame, field: Field, range: Range) -> Option<Self> {
        let opened = frame.open()?;
        let spheres = (0..opened.centres.len()).map(|k| DrawnSphere {
            centre: opened.centres[k],
            radius: opened.radii[k],
            colour: colour(&opened, k, field, range),
        });
        let spheres = spheres.collect();
        let chains = if field == Field::FORCE_CHAINS { chains(&opened, range) } else { Vec::new() };
        Some(Self { spheres, chains, walls: opened.walls })
    }
}

/// Returns the colour of a sphere.
fn colour(opened: &OpenedGrains, sphere: usize, field: Field, range: Range) -> Rgb {
    match field.sphere_scale() {
        Some(scale) => field.colour(opened.values[scale][sphere], range),
        None if field == Field::FORCE_CHAINS => PALE_SPHERE,
        None if field == Field::MATERIAL => numbered_colour(opened.materials[sphere]),
        None => numbered_colour(opened.groups[sphere]),
    }
}

/// Returns the lines of the contacts, the strongest last. Their widths are proportional to the normal force.
fn chains(opened: &OpenedGrains, range: Range) -> Vec<DrawnChain> {
    let radius = opened.radii.iter().sum::<f64>() / opened.radii.len().max(1) as f64;
    let mut order: Vec<usize> =
        (0..opened.chains.len()).filter(|&k| !opened.chains[k].normal.is_nan()).collect();
    order.sort_by(|&one, &other| {
        opened.chains[one].normal.abs().total_cmp(&opened.chains[other].normal.abs()).then(one.cmp(&other))
    });
    let line = |k: usize| {
        let chain = &opened.chains[k];
        let share = (chain.normal.abs() / range.high).clamp(SHARES[0], SHARES[1]);
        let colour =
            if chain.normal < 0.0 { PULLING } else { Field::FORCE_CHAINS.colour(chain.normal, range) };
        DrawnChain { ends: chain.ends, radius: WIDEST * radius * share, colour }
    };
    order.into_iter().map(line).collect()
}

/// Returns the number of spheres or discs as text, after a separator; empty without any.
fn counted(frame: &GrainFrame, separator: &str) -> String {
    if frame.whole == 0 {
        return String::new();
    }
    let noun = match (frame.discs, frame.whole) {
        (true, 1) => "disc",
        (true, _) => "discs",
        (false, 1) => "sphere",
        (false, _) => "spheres",
    };
    format!("{separator}{} {noun}", fdem_io::numbers::grouped(frame.whole as u64))
}

/// Returns the numbers of elements and of spheres as text. Without spheres the elements are named even if
/// there are none.
pub(crate) fn elements_and_spheres(elements: usize, frame: &GrainFrame) -> String {
    if elements == 0 && frame.whole > 0 {
        return counted(frame, "");
    }
    format!("{} elements{}", fdem_io::numbers::grouped(elements as u64), counted(frame, ", "))
}
