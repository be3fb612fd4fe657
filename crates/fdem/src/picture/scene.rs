//! What is drawn: a network of any dimension, in numbers that pictures need.

use crate::network::{Network, Sizes};
use crate::picture::{Caption, PictureError};

/// Points are drawn this much smaller than half the distance at which they touch: they have no size, and neighbours would hide each other.
const POINT: f64 = 0.35;

/// Of the overlaps this share is told apart by colour; a few larger ones would leave the others without.
const SHOWN: f64 = 0.99;

/// Elements and contacts in three dimensions; `z` is 0 in a plane.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) dimensions: usize,
    /// In the box, if there is one.
    pub(crate) centres: Vec<[f64; 3]>,
    /// As drawn.
    pub(crate) radii: Vec<f64>,
    /// Contacts of each element, both ends counted.
    pub(crate) coordination: Vec<u32>,
    pub(crate) bonds: Vec<Bond>,
    /// Overlaps at the two ends of the colours, and the largest of all.
    pub(crate) overlaps: Option<Overlaps>,
    /// Corner and edges of the box, those that repeat or not.
    pub(crate) cell: Option<([f64; 3], Vec<[f64; 3]>)>,
    /// Elements that are points have no size of their own.
    pub(crate) are_points: bool,
    /// Of a radius, what is drawn.
    pub(crate) drawn: f64,
    /// Smallest and largest size; without elements none.
    pub(crate) sizes: Option<[f64; 2]>,
    /// There if the elements are bodies: those of radius 0 are drawn as triangles.
    pub(crate) shapes: Option<Shapes>,
    pub(crate) title: String,
    pub(crate) unit: String,
}

/// A contact as a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bond {
    pub(crate) i: u32,
    pub(crate) j: u32,
    pub(crate) distance: f64,
    pub(crate) overlap: f64,
    /// From `i` to the image of `j`.
    pub(crate) branch: [f64; 3],
    /// Leads to an image, which is not drawn.
    pub(crate) leaves: bool,
    /// Of bodies: where they touch.
    pub(crate) joint: Option<Joint>,
}

/// The point of a contact of bodies, by way of which its line runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint {
    pub(crate) point: [f64; 3],
    /// Whether the line runs on to the middle of the first body, and of the second.
    pub(crate) to: [bool; 2],
}

/// Bodies that are no discs or spheres.
#[derive(Debug)]
pub(crate) struct Shapes {
    /// Name of the value by which contacts are coloured.
    pub(crate) value: String,
    pub(crate) points: Vec<[f64; 3]>,
    /// Triangles, by their corners in `points`.
    pub(crate) facets: Vec<[u32; 3]>,
    /// The body of each.
    pub(crate) owners: Vec<u32>,
    /// What is behind them is to be seen.
    pub(crate) walls: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlaps {
    pub(crate) low: f64,
    /// Where the colours end.
    pub(crate) high: f64,
    pub(crate) largest: f64,
}

impl Overlaps {
    /// `None` of none.
    pub(crate) fn of(mut values: Vec<f64>) -> Option<Self> {
        let last = values.len().checked_sub(1)?;
        let (_, &mut high, _) = values.select_nth_unstable_by((last as f64 * SHOWN) as usize, f64::total_cmp);
        let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
        // No overlap has a place of its own; gaps within a tolerance are beyond it. One step of rounding is no spread.
        let low = smallest.min(0.0);
        let high = if largest <= high * 1.25 { largest } else { high };
        Some(Self { low, high, largest })
    }

    /// Place among the colours, 0 to 1.
    pub(crate) fn share(&self, overlap: f64) -> f64 {
        if self.high > self.low {
            ((overlap - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
        } else {
            0.5
        }
    }
}

impl Scene {
    pub(crate) fn new<const D: usize>(
        network: &Network<'_, D>,
        caption: &Caption<'_>,
    ) -> Result<Self, PictureError> {
        if D != 2 && D != 3 {
            return Err(PictureError::Dimensions { found: D });
        }
        let Network { space, sizes, couples } = *network;
        let in_three = |point: [f64; D]| std::array::from_fn(|axis| point.get(axis).copied().unwrap_or(0.0));
        let n = space.centres.len();
        let drawn = if matches!(sizes, Sizes::Cutoff(_)) { POINT } else { 1.0 };
        for (index, centre) in space.centres.iter().enumerate() {
            if !centre.iter().chain([&sizes.radius(index)]).all(|x| x.is_finite()) {
                return Err(PictureError::NotFinite { index });
            }
        }
        let place = |index: usize| match &space.cell {
            Some(cell) => space.wrapped(cell, index as u32).0,
            None => space.centres[index],
        };
        let centres: Vec<[f64; 3]> = (0..n).map(|index| in_three(place(index))).collect();
        let mut coordination = vec![0_u32; n];
        let bonds: Vec<Bond> = couples
            .iter()
            .map(|couple| {
                let (i, j) = (couple.i, couple.j);
                coordination[i as usize] += 1;
                coordination[j as usize] += 1;
                let [a, b] = space.ends(couple).map(in_three);
                Bond {
                    i,
                    j,
                    distance: space.distance(couple),
                    overlap: network.overlap(couple),
                    branch: std::array::from_fn(|axis| b[axis] - a[axis]),
                    leaves: space.cell.is_some() && b != centres[j as usize],
                    joint: None,
                }
            })
            .collect();
        let cell = space.cell.map(|cell| {
            let edges = cell.edges().iter().map(|&edge| in_three(edge)).collect();
            (in_three(cell.origin()), edges)
        });
        let range = (0..n).map(|index| sizes.radius(index)).fold(None, |range: Option<[f64; 2]>, r| {
            Some(range.map_or([r, r], |[low, high]| [low.min(r), high.max(r)]))
        });
        Ok(Self {
            dimensions: D,
            centres,
            radii: (0..n).map(|index| sizes.radius(index) * drawn).collect(),
            coordination,
            overlaps: Overlaps::of(bonds.iter().map(|bond| bond.overlap).collect()),
            bonds,
            cell,
            are_points: drawn < 1.0,
            drawn,
            sizes: range,
            shapes: None,
            title: caption.title.to_owned(),
            unit: caption.unit.unwrap_or_default().to_owned(),
        })
    }

    /// What the elements are, for people.
    pub(crate) fn noun(&self) -> &'static str {
        if self.shapes.is_some() {
            return if self.centres.len() == 1 { "body" } else { "bodies" };
        }
        match (self.are_points, self.dimensions, self.centres.len()) {
            (true, _, 1) => "point",
            (true, ..) => "points",
            (false, 2, 1) => "disc",
            (false, 2, _) => "discs",
            (false, _, 1) => "sphere",
            (false, ..) => "spheres",
        }
    }

    /// One of them, with its article; one, and several.
    pub(crate) fn nouns(&self) -> [&'static str; 3] {
        if self.shapes.is_some() {
            ["a body", "body", "bodies"]
        } else {
            ["an element", "element", "elements"]
        }
    }

    /// What contacts are coloured by.
    pub(crate) fn value(&self) -> &str {
        self.shapes.as_ref().map_or("overlap", |shapes| shapes.value.as_str())
    }

    /// The same with its unit. Values of bodies have units of their own.
    pub(crate) fn value_and_unit(&self) -> String {
        if self.shapes.is_some() { self.value().to_owned() } else { format!("overlap{}", self.after_name()) }
    }

    /// Whether an element is drawn as triangles.
    pub(crate) fn is_surface(&self, index: usize) -> bool {
        self.shapes.is_some() && self.radii[index] == 0.0
    }

    /// The corners of all triangles, each with its body.
    pub(crate) fn facets(&self) -> impl Iterator<Item = ([[f64; 3]; 3], u32)> + '_ {
        let shapes = self.shapes.iter();
        shapes.flat_map(|shapes| {
            let corners = |nodes: &[u32; 3]| nodes.map(|node| shapes.points[node as usize]);
            shapes.facets.iter().zip(&shapes.owners).map(move |(nodes, &owner)| (corners(nodes), owner))
        })
    }

    pub(crate) fn mean_coordination(&self) -> f64 {
        2.0 * self.bonds.len() as f64 / self.centres.len().max(1) as f64
    }

    /// Elements without contact.
    pub(crate) fn alone(&self) -> usize {
        self.coordination.iter().filter(|&&contacts| contacts == 0).count()
    }

    /// ` mm`, or nothing.
    pub(crate) fn after_number(&self) -> String {
        if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) }
    }

    /// ` (mm)`, or nothing.
    pub(crate) fn after_name(&self) -> String {
        if self.unit.is_empty() { String::new() } else { format!(" ({})", self.unit) }
    }
}
