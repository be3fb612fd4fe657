//! The scene: a network in 2D or 3D, prepared for drawing.

use crate::network::Network;
use crate::picture::caption::Caption;
use crate::picture::error::PictureError;

/// Radius at which points are drawn, over half of their cut-off. At half of the cut-off, neighbours would
/// hide each other.
const POINT: f64 = 0.35;

/// Share of the overlaps that the colours cover, because a few larger overlaps would leave the others with
/// nearly one colour.
const SHOWN: f64 = 0.99;

/// Elements and contacts in three dimensions; in 2D, `z` is 0.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) dimensions: usize,
    /// Centres, wrapped into the box if there is one.
    pub(crate) centres: Vec<[f64; 3]>,
    /// Radii as drawn.
    pub(crate) radii: Vec<f64>,
    /// Number of contacts of each element. A contact of an element with its own image counts twice, a contact
    /// of a body with itself once.
    pub(crate) coordination: Vec<u32>,
    pub(crate) bonds: Vec<Bond>,
    /// Range of the overlaps; `None` without contacts.
    pub(crate) overlaps: Option<OverlapRange>,
    /// Corner and edges of the box, including edges that are not periodic.
    pub(crate) cell: Option<([f64; 3], Vec<[f64; 3]>)>,
    /// Whether the elements are points, which have no size.
    pub(crate) are_points: bool,
    /// Whether the values of the contacts are forces in place of overlaps.
    pub(crate) of_forces: bool,
    /// Radius as drawn over radius.
    pub(crate) drawn: f64,
    /// Smallest and largest radius; `None` without elements.
    pub(crate) sizes: Option<[f64; 2]>,
    /// Triangles, if the elements are bodies. Bodies with the radius 0 are drawn by them.
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
    /// The value by which the contact is coloured: overlap, force, or that of [`Shapes::value`].
    pub(crate) overlap: f64,
    /// Vector from `i` to the image of `j`.
    pub(crate) branch: [f64; 3],
    /// Whether the contact leads to an image, which is not drawn.
    pub(crate) leaves: bool,
    /// Contact point, for bodies.
    pub(crate) joint: Option<Joint>,
}

/// Contact point of two bodies. The line of the contact leads through it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint {
    pub(crate) point: [f64; 3],
    /// Whether the line leads to the centre of the first body, and of the second.
    pub(crate) to: [bool; 2],
}

/// Bodies other than discs and spheres.
#[derive(Debug)]
pub(crate) struct Shapes {
    /// Name of the value by which contacts are coloured.
    pub(crate) value: String,
    pub(crate) points: Vec<[f64; 3]>,
    /// Corners of the triangles, as indices of `points`.
    pub(crate) facets: Vec<[u32; 3]>,
    /// Body of each triangle.
    pub(crate) owners: Vec<u32>,
    /// Whether the triangles are walls, which are drawn transparently.
    pub(crate) walls: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OverlapRange {
    pub(crate) low: f64,
    /// Upper end of the colours.
    pub(crate) high: f64,
    pub(crate) largest: f64,
}

impl OverlapRange {
    /// Returns the range of overlaps; `None` without any.
    pub(crate) fn of(mut values: Vec<f64>) -> Option<Self> {
        let last = values.len().checked_sub(1)?;
        let (_, &mut high, _) = values.select_nth_unstable_by((last as f64 * SHOWN) as usize, f64::total_cmp);
        let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
        // The colours start at 0, or at the largest gap within a tolerance. They end at the largest overlap,
        // unless it is far above the others.
        let low = smallest.min(0.0);
        let high = if largest <= high * 1.25 { largest } else { high };
        Some(Self { low, high, largest })
    }

    /// Returns the range of forces, from 0 to the largest one, so that lines show how much larger it is;
    /// `None` without any.
    fn of_forces(forces: &[f64]) -> Option<Self> {
        let largest = forces.iter().copied().reduce(f64::max)?;
        Some(Self { low: 0.0, high: largest, largest })
    }

    /// Position of an overlap in the colours, from 0 to 1.
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
        let Network { space, sizes, couples, forces } = *network;
        let magnitudes = network.magnitudes();
        let in_three = |point: [f64; D]| std::array::from_fn(|axis| point.get(axis).copied().unwrap_or(0.0));
        let n = space.centres.len();
        let drawn = if sizes.are_points() { POINT } else { 1.0 };
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
            .enumerate()
            .map(|(k, couple)| {
                let (i, j) = (couple.i, couple.j);
                coordination[i as usize] += 1;
                coordination[j as usize] += 1;
                let [a, b] = space.ends(couple).map(in_three);
                Bond {
                    i,
                    j,
                    distance: space.distance(couple),
                    overlap: magnitudes
                        .as_ref()
                        .map_or_else(|| network.overlap(couple), |magnitudes| magnitudes[k]),
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
            overlaps: match &magnitudes {
                Some(forces) => OverlapRange::of_forces(forces),
                None => OverlapRange::of(bonds.iter().map(|bond| bond.overlap).collect()),
            },
            bonds,
            cell,
            are_points: drawn < 1.0,
            of_forces: forces.is_some(),
            drawn,
            sizes: range,
            shapes: None,
            title: caption.title.to_owned(),
            unit: caption.unit.unwrap_or_default().to_owned(),
        })
    }

    /// Name of the elements, in the singular for one element.
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

    /// Name of an element with its article, without it, and in the plural.
    pub(crate) fn nouns(&self) -> [&'static str; 3] {
        if self.shapes.is_some() {
            ["a body", "body", "bodies"]
        } else {
            ["an element", "element", "elements"]
        }
    }

    /// Name of the value that colours the contacts.
    pub(crate) fn value(&self) -> &str {
        let name = if self.of_forces { "force" } else { "overlap" };
        self.shapes.as_ref().map_or(name, |shapes| shapes.value.as_str())
    }

    /// Whether the value that colours the contacts is a length. The unit of others is not known.
    pub(crate) fn value_is_length(&self) -> bool {
        self.shapes.is_none() && !self.of_forces
    }

    /// Name of the value that colours the contacts, with its unit if it is a length.
    pub(crate) fn value_and_unit(&self) -> String {
        if self.value_is_length() { format!("overlap{}", self.after_name()) } else { self.value().to_owned() }
    }

    /// Whether an element is drawn as triangles.
    pub(crate) fn is_surface(&self, index: usize) -> bool {
        self.shapes.is_some() && self.radii[index] == 0.0
    }

    /// Corners and body of each triangle.
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

    /// Number of elements without contact.
    pub(crate) fn alone(&self) -> usize {
        self.coordination.iter().filter(|&&contacts| contacts == 0).count()
    }

    /// Unit after a number, as in ` mm`; empty if it is not known.
    pub(crate) fn after_number(&self) -> String {
        if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) }
    }

    /// Unit after a name, as in ` (mm)`; empty if it is not known.
    pub(crate) fn after_name(&self) -> String {
        if self.unit.is_empty() { String::new() } else { format!(" ({})", self.unit) }
    }
}
