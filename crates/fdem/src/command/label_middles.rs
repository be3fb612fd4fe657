//! Centres and sizes of the bodies in an image, for drawings: integer sums over their pixels or voxels.

use std::collections::BTreeMap;

use fdem_contact::image::{ImageContact, Label, Spacing};
use fdem_io::{LabelValue, Table, Values};
use fdem_results::picture::{Bodies, BodyJoint};

use crate::command::label_axes::{AxisOrder, ImageStop};

/// Sums over the pixels or voxels of each body, while the image is read slab by slab.
pub(crate) struct Middles<L, const D: usize> {
    shape: [usize; D],
    background: Option<L>,
    /// Number of pixels or voxels added so far.
    added: usize,
    bodies: BTreeMap<L, Sum<D>>,
}

/// Sums over the pixels or voxels of a body.
#[derive(Clone, Copy)]
pub(crate) struct Sum<const D: usize> {
    count: u64,
    /// Sum of twice the positions along the axes of the array, because twice the middle of a run is an
    /// integer.
    twice: [u128; D],
}

impl<L: Label + LabelValue, const D: usize> Middles<L, D> {
    pub(crate) fn new(shape: [usize; D], background: Option<L>) -> Self {
        Self { shape, background, added: 0, bodies: BTreeMap::new() }
    }

    /// Adds the next planes.
    pub(crate) fn add(&mut self, slab: &[L]) {
        let width = self.shape[D - 1].max(1);
        for row in slab.chunks(width) {
            let mut at = self.added / width;
            let mut place = [0; D];
            for axis in (0..D - 1).rev() {
                place[axis] = at % self.shape[axis].max(1);
                at /= self.shape[axis].max(1);
            }
            let mut start = 0;
            for run in row.chunk_by(|a, b| a == b) {
                let (first, last) = (start, start + run.len() - 1);
                start += run.len();
                if Some(run[0]) == self.background {
                    continue;
                }
                let sum = self.bodies.entry(run[0]).or_insert(Sum { count: 0, twice: [0; D] });
                let count = run.len() as u64;
                sum.count += count;
                for (axis, total) in sum.twice.iter_mut().enumerate() {
                    let twice = if axis == D - 1 { first + last } else { 2 * place[axis] };
                    *total += u128::from(count) * twice as u128;
                }
            }
            self.added += row.len();
        }
    }

    /// The label of each body, in ascending order, and its sums.
    pub(crate) fn into_sums(self) -> Vec<(i128, Sum<D>)> {
        self.bodies.into_iter().map(|(label, sum)| (label.into(), sum)).collect()
    }
}

/// Bodies of an image as discs of the same area or spheres of the same volume.
#[derive(Debug, Default)]
pub(crate) struct DrawnBodies {
    dimensions: usize,
    ids: Vec<i64>,
    centres: Vec<[f64; 3]>,
    radii: Vec<f64>,
    sizes: Vec<f64>,
    coordination: Vec<i32>,
    joints: Vec<BodyJoint>,
    areas: Vec<f64>,
    faces: Vec<f64>,
}

impl DrawnBodies {
    /// Bodies, in ascending order of their labels, and their contacts.
    pub(crate) fn new<const D: usize>(
        sums: Vec<(i128, Sum<D>)>,
        contacts: &[ImageContact<i128, D>],
        spacing: &Spacing<D>,
        order: AxisOrder,
    ) -> Result<Self, ImageStop> {
        let edges = spacing.edges();
        let square: f64 = edges.iter().product();
        let in_three = |point: [f64; D]| std::array::from_fn(|axis| point.get(axis).copied().unwrap_or(0.0));
        let mut drawn = Self { dimensions: D, ..Self::default() };
        for (label, Sum { count, twice }) in sums {
            let id = i64::try_from(label).map_err(|_| {
                ImageStop::Option(format!("the label {label} needs more than 63 bits and cannot be drawn"))
            })?;
            let middle = std::array::from_fn(|axis| twice[axis] as f64 / (2.0 * count as f64) * edges[axis]);
            let size = count as f64 * square;
            let radius = if D == 2 {
                (size / std::f64::consts::PI).sqrt()
            } else {
                libm::cbrt(size * 0.75 / std::f64::consts::PI)
            };
            drawn.ids.push(id);
            drawn.centres.push(in_three(order.xyz(middle)));
            drawn.radii.push(radius);
            drawn.sizes.push(size);
            drawn.coordination.push(0);
        }
        for contact in contacts {
            let place = |label: &i128| drawn.ids.partition_point(|&id| i128::from(id) < *label);
            let [i, j] = contact.labels();
            let bodies = [place(&i), place(&j)];
            for &body in &bodies {
                drawn.coordination[body] += 1;
            }
            let area = contact.area(spacing);
            drawn.joints.push(BodyJoint {
                bodies: bodies.map(|body| body as u32),
                point: in_three(order.xyz(contact.centroid(spacing))),
                normal: in_three(order.xyz(contact.normal(spacing))),
                value: area,
            });
            drawn.areas.push(area);
            drawn.faces.push(contact.faces() as f64);
        }
        Ok(drawn)
    }

    pub(crate) fn ids(&self) -> &[i64] {
        &self.ids
    }

    /// Columns of the contacts: a name and a value per contact.
    pub(crate) fn columns(&self) -> [(&'static str, &[f64]); 2] {
        [(self.measure(), &self.areas), ("shared faces", &self.faces)]
    }

    fn measure(&self) -> &'static str {
        if self.dimensions == 2 { "shared length" } else { "shared area" }
    }

    pub(crate) fn bodies(&self) -> Bodies<'_> {
        Bodies {
            dimensions: self.dimensions,
            centres: &self.centres,
            radii: &self.radii,
            points: &[],
            facets: &[],
            owners: &[],
            walls: false,
            joints: &self.joints,
            value: self.measure(),
        }
    }

    /// Points for ParaView: the centres of the bodies.
    pub(crate) fn points(&self) -> Table<'_> {
        Table::new(self.ids.len())
            .with_components("positions", &["x", "y", "z"], Values::f64(|k| self.centres[k / 3][k % 3]))
            .with("label", Values::i64(|k| self.ids[k]))
            .with(if self.dimensions == 2 { "area" } else { "volume" }, Values::f64(|k| self.sizes[k]))
            .with("radius", Values::f64(|k| self.radii[k]))
            .with("coordination", Values::i32(|k| self.coordination[k]))
    }

    /// Lines for ParaView: between the centres of bodies that touch.
    pub(crate) fn lines<'a, const D: usize>(
        &'a self,
        contacts: &'a [ImageContact<i128, D>],
        spacing: &'a Spacing<D>,
        order: AxisOrder,
    ) -> Table<'a> {
        let at = |point: [f64; D], axis: usize| point.get(axis).copied().unwrap_or(0.0);
        Table::new(self.joints.len())
            .with_components(
                "ends",
                &["first", "second"],
                Values::i64(|k| self.joints[k / 2].bodies[k % 2].into()),
            )
            .with("faces", Values::u64(|k| contacts[k].faces()))
            .with(if D == 2 { "length" } else { "area" }, Values::f64(|k| self.areas[k]))
            .with_components(
                "centroid",
                &["x", "y", "z"],
                Values::f64(move |k| at(order.xyz(contacts[k / 3].centroid(spacing)), k % 3)),
            )
            .with_components(
                "normal",
                &["nx", "ny", "nz"],
                Values::f64(move |k| at(order.xyz(contacts[k / 3].normal(spacing)), k % 3)),
            )
    }
}
