//! Voids: the local void ratio of each element, and the sizes of the pores.

use serde::Serialize;

use crate::analysis::around::Around;
use crate::analysis::error::AnalysisError;
use crate::analysis::overlaps::Spread;
use crate::analysis::packing::{Region, ball};
use crate::analysis::placed::Placed;
use crate::analysis::polytope::Polytope;
use crate::arrays::each;

/// Voids between the elements.
///
/// # Units
/// The length unit of the centres.
///
/// # Source
/// Radical cells: B.J. Gellatly, J.L. Finney, J. Non-Cryst. Solids 50 (1982) 313–329. Pore sizes:
/// S. Torquato, B. Lu, J. Rubinstein, Phys. Rev. A 41 (1990) 2059–2075.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Voids {
    /// Local void ratios: volume of the radical Voronoi cell of an element without that of the element, over
    /// that of the element. The cell has the points whose power `|x - c|² - r²` is least for this element.
    /// `None` if no cell is complete.
    pub void_ratio: Option<Spread>,
    /// Number of elements that are left out because their cell ends at the border of an open domain.
    pub at_border: u64,
    /// Number of elements that are left out because they have no cell: others hide them.
    pub hidden: u64,
    /// Void ratio of each element; NaN for those that are left out. Not in the JSON.
    #[serde(skip)]
    pub of_each: Vec<f64>,
    /// Distances from points in the voids to the nearest surface: radii of the largest spheres around these
    /// points that fit between the elements. `None` if no sampled point is in a void.
    pub pores: Option<Spread>,
    /// Number of points that were sampled, uniformly in the region of the packing fraction.
    pub samples: u64,
    /// Part of the samples that is in voids.
    pub porosity: f64,
}

/// Number of samples for pores: the porosity has an error of at most some 0.0015, mostly much less.
const SAMPLES: usize = 100_000;

/// Returns the voids, or the reason why they cannot be given.
pub(crate) fn voids<const D: usize>(
    placed: &Placed<'_, D>,
    region: &Region<'_, D>,
) -> Result<Result<Voids, String>, AnalysisError> {
    let (network, frame) = (placed.network, &placed.frame);
    if !frame.along_axes && frame.periods.iter().any(Option::is_none) {
        return Ok(Err("the box is sheared and has an edge that is not periodic".to_owned()));
    }
    let radius = |element: u32| network.sizes.radius(element as usize);
    let around = Around::new(placed);
    let centres = around.centres();

    let limits = |centre: &[f64; D]| -> [[f64; 2]; D] {
        each(|axis| {
            if frame.periods[axis].is_some() {
                [-around.widest(), around.widest()]
            } else {
                [frame.domain[axis][0] - centre[axis], frame.domain[axis][1] - centre[axis]]
            }
        })
    };
    let limits: Vec<_> = centres.iter().map(limits).collect();
    let walls = each::<bool, D>(|axis| frame.periods[axis].is_none());
    let largest = frame.largest_radius;
    let cells = around.each(centres, |element, near| {
        // A plane is a prism of height 1.
        let (mut in_space, mut of_axis) = ([[-0.5, 0.5]; 3], [false; 3]);
        in_space[..D].copy_from_slice(&limits[element]);
        of_axis[..D].copy_from_slice(&walls);
        let mut cell = Polytope::new(in_space, of_axis);
        let own = radius(element as u32);
        // Distance of the radical plane of another element of this radius at this distance.
        let plane = |other: f64, distance: f64| 0.5 * (distance + (own - other) * (own + other) / distance);
        let mut reach = cell.reach();
        for neighbour in near.iter() {
            let distance = neighbour.distance;
            if distance == 0.0 {
                // The element itself, or another one in its place: the larger one has the cell, or the first.
                let other = radius(neighbour.element);
                let first = (-other, neighbour.element) < (-own, element as u32);
                if first {
                    return Some(None);
                }
                continue;
            }
            if plane(largest, distance) > reach {
                return Some(Some(cell));
            }
            let mut normal = [0.0; 3];
            for axis in 0..D {
                normal[axis] = (neighbour.centre[axis] - centres[element][axis]) / distance;
            }
            cell.cut(normal, plane(radius(neighbour.element), distance));
            reach = cell.reach();
            if reach == 0.0 {
                return Some(None);
            }
        }
        (near.are_all || plane(largest, near.known) > reach).then_some(Some(cell))
    })?;

    let (mut at_border, mut hidden) = (0, 0);
    let of_each: Vec<f64> = cells
        .into_iter()
        .enumerate()
        .map(|(element, cell)| match cell {
            None => {
                hidden += 1;
                f64::NAN
            }
            Some(cell) if cell.has_wall() => {
                at_border += 1;
                f64::NAN
            }
            Some(cell) => cell.volume() / ball::<D>(radius(element as u32)) - 1.0,
        })
        .collect();
    let measured: Vec<f64> = of_each.iter().copied().filter(|ratio| ratio.is_finite()).collect();

    let points: Vec<_> = (0..SAMPLES).map(|sample| region.point(unit_point(sample))).collect();
    let surfaces = around.each(&points, |_, near| {
        let mut surface = f64::INFINITY;
        for neighbour in near.iter() {
            if neighbour.distance - largest >= surface {
                return Some(surface);
            }
            surface = surface.min(neighbour.distance - radius(neighbour.element));
        }
        (near.are_all || near.known - largest >= surface).then_some(surface)
    })?;
    let in_voids: Vec<f64> = surfaces.into_iter().filter(|&surface| surface > 0.0).collect();
    Ok(Ok(Voids {
        void_ratio: Spread::of(&[&measured], Some),
        at_border,
        hidden,
        of_each,
        porosity: in_voids.len() as f64 / SAMPLES as f64,
        pores: Spread::of(&[&in_voids], Some),
        samples: SAMPLES as u64,
    }))
}

/// A point of a sequence that fills the unit square or cube evenly: multiples of powers of the root of
/// `x^(D + 1) = x + 1`, without their whole parts.
///
/// # Source
/// M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences" (2018).
fn unit_point<const D: usize>(sample: usize) -> [f64; D] {
    let root: f64 = if D == 2 { 1.324_717_957_244_746 } else { 1.220_744_084_605_759_5 };
    each(|axis| (0.5 + (sample + 1) as f64 / root.powf(axis as f64 + 1.0)).fract())
}
