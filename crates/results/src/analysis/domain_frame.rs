//! The axes of the domain of a network.

use crate::arrays::each;
use crate::network::Network;

/// Coordinates whose axes are at right angles to the faces of the domain: the coordinates of the centres, or
/// in a sheared box the distances from its faces.
#[derive(Clone)]
pub(crate) struct DomainFrame<const D: usize> {
    /// Period along each periodic axis.
    pub(crate) periods: [Option<f64>; D],
    /// Limits of the box along periodic axes, and of the box around all elements with their radii along the
    /// others; empty without elements.
    pub(crate) domain: [[f64; 2]; D],
    pub(crate) largest_radius: f64,
    /// Whether the coordinates are those of the centres.
    pub(crate) along_axes: bool,
    /// Volume of the box over the product of its heights; 1 unless the box is sheared.
    stretch: f64,
}

impl<const D: usize> DomainFrame<D> {
    pub(crate) fn of(network: &Network<'_, D>) -> Self {
        let n = network.space.centres.len();
        let mut frame = Self {
            periods: [None; D],
            domain: [[f64::INFINITY, f64::NEG_INFINITY]; D],
            largest_radius: (0..n).map(|k| network.sizes.radius(k)).fold(0.0, f64::max),
            along_axes: true,
            stretch: 1.0,
        };
        if let Some(cell) = &network.space.cell {
            let (edges, heights) = (cell.edges(), cell.heights());
            frame.along_axes = (0..D).all(|edge| {
                (0..D)
                    .all(|axis| if edge == axis { edges[edge][axis] > 0.0 } else { edges[edge][axis] == 0.0 })
            });
            for axis in (0..D).filter(|&axis| cell.periodic()[axis]) {
                let (start, length) = if frame.along_axes {
                    (cell.origin()[axis], edges[axis][axis])
                } else {
                    (0.0, heights[axis])
                };
                frame.periods[axis] = Some(length);
                frame.domain[axis] = [start, start + length];
            }
            if !frame.along_axes {
                frame.stretch = determinant(&edges).abs() / heights.iter().product::<f64>();
            }
        }
        for element in 0..n {
            let (x, r) = (frame.coordinates(network, element), network.sizes.radius(element));
            for axis in (0..D).filter(|&axis| frame.periods[axis].is_none()) {
                let [low, high] = &mut frame.domain[axis];
                (*low, *high) = (low.min(x[axis] - r), high.max(x[axis] + r));
            }
        }
        frame
    }

    pub(crate) fn coordinates(&self, network: &Network<'_, D>, element: usize) -> [f64; D] {
        self.transformed(network, network.space.centres[element])
    }

    pub(crate) fn transformed(&self, network: &Network<'_, D>, point: [f64; D]) -> [f64; D] {
        match &network.space.cell {
            Some(cell) if !self.along_axes => {
                let (fractions, heights) = (cell.fractions(&point), cell.heights());
                each(|axis| fractions[axis] * heights[axis])
            }
            _ => point,
        }
    }

    /// Area or volume of a region.
    pub(crate) fn measure(&self, limits: &[[f64; 2]; D]) -> f64 {
        limits.iter().fold(self.stretch, |product, [low, high]| product * (high - low))
    }
}

/// Determinant of two or three edges.
fn determinant<const D: usize>(edges: &[[f64; D]; D]) -> f64 {
    let minor = |row: usize, other: usize, a: usize, b: usize| {
        edges[row][a] * edges[other][b] - edges[row][b] * edges[other][a]
    };
    if D == 2 {
        return minor(0, 1, 0, 1);
    }
    edges[0][0] * minor(1, 2, 1, 2) - edges[0][1] * minor(1, 2, 0, 2) + edges[0][2] * minor(1, 2, 0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn determinants() {
        assert_eq!(determinant(&[[2.0, 0.5], [1.0, 3.0]]), 5.5);
        assert_eq!(determinant(&[[2.0, 0.0, 0.0], [1.0, 3.0, 0.0], [4.0, 5.0, 0.5]]), 3.0);
        assert_eq!(determinant(&[[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), 1.0);
    }
}
