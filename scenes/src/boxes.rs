//! Axis-aligned boxes of mixed aspect.

use crate::cloud::require_axes;
use crate::error::{Error, positive, reserved};
use crate::gas::root;
use crate::random::{CENTRES, RADII, Random};

/// Axis-aligned boxes as two plain arrays.
///
/// # Shapes
/// `min` and `max` `[n][D]`: the corners, one entry per box, same order; `min <= max` along each axis.
///
/// # Units
/// The unit of the shortest edge.
///
/// # Example
/// ```
/// let boxes = fdem_scenes::boxes::<3>(100, 1, 12.0, 100.0)?;
/// assert_eq!((boxes.len(), boxes.is_empty()), (100, false));
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Boxes<const D: usize> {
    /// The corner with the smallest coordinates.
    pub min: Vec<[f64; D]>,
    /// The corner with the largest coordinates.
    pub max: Vec<[f64; D]>,
}

impl<const D: usize> Boxes<D> {
    /// Number of boxes.
    pub fn len(&self) -> usize {
        self.min.len()
    }

    /// Whether there are no boxes.
    pub fn is_empty(&self) -> bool {
        self.min.is_empty()
    }
}

/// Boxes with uniformly random centres in a cube, dense enough for `neighbours` overlaps per box; plates,
/// rods and cubes are mixed.
///
/// The logarithm of each edge is uniformly random between those of 1 and of `aspect`, so the longest edge of
/// a box is 1 to `aspect` times its shortest. The cube is `[0, L)^D` with `n V / L^D = neighbours`, where `V`
/// is the mean over all pairs `i ≠ j` of `Π_k (e_ik + e_jk)`, the volume in which the centre of `j` must be
/// for the boxes to touch. Boxes near the faces have fewer overlaps, as in [`gas`](crate::gas).
///
/// # Shapes
/// `n` boxes, in no spatial order.
///
/// # Units
/// The shortest edge that can be drawn is 1; `neighbours` and `aspect` are numbers.
///
/// # Cost
/// Time and memory proportional to `n`.
///
/// # Errors
/// [`Error::OutOfRange`] if `neighbours` is not positive, `aspect` is not at least 1 and finite, or `L` is
/// not finite; [`Error::OutOfMemory`].
///
/// # Example
/// ```
/// let boxes = fdem_scenes::boxes::<3>(1_000, 7, 12.0, 100.0)?;
/// let edge = |k: usize, axis: usize| boxes.max[k][axis] - boxes.min[k][axis];
/// assert!((0..1_000).all(|k| (0..3).all(|axis| (0.99..100.01).contains(&edge(k, axis)))));
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
pub fn boxes<const D: usize>(n: usize, seed: u64, neighbours: f64, aspect: f64) -> Result<Boxes<D>, Error> {
    require_axes::<D>();
    const { assert!(D <= 16, "2^D sums over all boxes give the size of the cube") }
    positive("number of neighbours", neighbours)?;
    if !(aspect >= 1.0 && aspect.is_finite()) {
        return Err(Error::OutOfRange { what: "aspect", value: aspect, limit: "at least 1, and finite" });
    }
    let log_aspect = libm::log(aspect);
    let mut random = Random::with_stream(seed, RADII);
    let mut draw = || libm::exp(log_aspect * random.uniform());
    let mut edges: Vec<[f64; D]> = reserved(n)?;
    edges.extend((0..n).map(|_| -> [f64; D] { std::array::from_fn(|_| draw()) }));
    let length = if n == 0 { 0.0 } else { cube(&edges, neighbours)? };

    let mut random = Random::with_stream(seed, CENTRES);
    let (mut min, mut max) = (reserved(n)?, reserved(n)?);
    for edges in edges {
        let centre: [f64; D] = std::array::from_fn(|_| length * random.uniform());
        min.push(std::array::from_fn(|axis| centre[axis] - 0.5 * edges[axis]));
        max.push(std::array::from_fn(|axis| centre[axis] + 0.5 * edges[axis]));
    }
    Ok(Boxes { min, max })
}

/// The edge of the cube. `V` is exact: expanded, the product of sums is a sum over all ways to take each axis
/// from one of the two boxes.
fn cube<const D: usize>(edges: &[[f64; D]], neighbours: f64) -> Result<f64, Error> {
    let n = edges.len() as f64;
    // The product of the edges along the axes whose bit is set, summed over the boxes.
    let moment = |axes: usize| -> f64 {
        let product = |edges: &[f64; D]| -> f64 {
            edges
                .iter()
                .enumerate()
                .map(|(axis, edge)| if axes >> axis & 1 == 1 { *edge } else { 1.0 })
                .product()
        };
        edges.iter().map(product).sum()
    };
    let all = (1_usize << D) - 1;
    let ordered_pairs: f64 = (0..=all).map(|axes| moment(axes) * moment(all & !axes)).sum();
    let with_itself = (all + 1) as f64 * moment(all);
    let volume = if edges.len() < 2 { with_itself } else { (ordered_pairs - with_itself) / (n * (n - 1.0)) };
    let content = positive("content of the cube", n * volume / neighbours)?;
    positive("edge of the cube", root::<D>(content))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overlaps<const D: usize>(boxes: &Boxes<D>) -> usize {
        let touch = |i: usize, j: usize| {
            (0..D).all(|axis| {
                boxes.min[i][axis] <= boxes.max[j][axis] && boxes.min[j][axis] <= boxes.max[i][axis]
            })
        };
        (0..boxes.len()).map(|i| (0..i).filter(|&j| touch(i, j)).count()).sum()
    }

    #[test]
    fn there_are_as_many_overlaps_as_asked_for() {
        // The faces of the cube reduce the number by a few percent; its standard deviation is about its
        // square root.
        let n = 6_000;
        let found = overlaps(&boxes::<2>(n, 5, 6.0, 4.0).unwrap()) as f64 / n as f64;
        assert!((2.8..3.05).contains(&found), "{found}");
        let found = overlaps(&boxes::<3>(n, 5, 2.0, 10.0).unwrap()) as f64 / n as f64;
        assert!((0.85..1.02).contains(&found), "{found}");
    }

    #[test]
    fn the_cube_is_that_of_the_mean_over_all_pairs() {
        let edges = [[1.0, 2.0], [3.0, 0.5], [4.0, 7.0]];
        let pair = |i: usize, j: usize| (0..2).map(|axis| edges[i][axis] + edges[j][axis]).product::<f64>();
        let mean = (pair(0, 1) + pair(0, 2) + pair(1, 2)) / 3.0;
        assert!((cube(&edges, 2.0).unwrap() - (3.0 * mean / 2.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn aspects_are_mixed() {
        let boxes = boxes::<3>(10_000, 3, 12.0, 100.0).unwrap();
        let aspect = |k: usize| {
            let edges: [f64; 3] = std::array::from_fn(|axis| boxes.max[k][axis] - boxes.min[k][axis]);
            edges.iter().copied().fold(0.0, f64::max) / edges.iter().copied().fold(f64::INFINITY, f64::min)
        };
        let below = |bound: f64| (0..10_000).filter(|&k| aspect(k) < bound).count() as f64 / 1e4;
        // The range of three uniform random numbers is below r with probability 3 r^2 - 2 r^3.
        for r in [0.25, 0.5, 0.75] {
            let expected = 3.0 * r * r - 2.0 * r * r * r;
            assert!((below(100_f64.powf(r)) - expected).abs() < 0.025, "{r}");
        }
        assert_eq!(below(101.0), 1.0);
    }

    #[test]
    fn few_boxes_and_bad_parameters() {
        assert!(boxes::<3>(0, 1, 12.0, 100.0).unwrap().is_empty());
        assert_eq!(boxes::<1>(1, 1, 12.0, 1.0).unwrap().len(), 1);
        for aspect in [0.5, f64::NAN, f64::INFINITY] {
            assert!(boxes::<3>(9, 1, 12.0, aspect).is_err(), "{aspect}");
        }
        assert!(boxes::<3>(9, 1, 0.0, 2.0).is_err() && boxes::<3>(9, 1, 1.0, 1e300).is_err());
    }
}
