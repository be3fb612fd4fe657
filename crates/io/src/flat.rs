//! Flat packings: elements of a plane in a file that writes three coordinates.

use crate::packing::{Centres, Packing, SimulationBox};

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Coordinates along an axis are equal if they differ by no more than this share of the largest diameter: the
/// rounding of a file in single precision.
const SPREAD: f64 = 1e-6;

impl Packing {
    /// Turns a flat packing in space into one in the plane. Returns a remark for a person if the packing was
    /// flat.
    ///
    /// LAMMPS, among others, runs two dimensions in a thin box that is periodic along z. As spheres, its
    /// discs would touch their own images. A packing of at least two elements is flat if its box is periodic
    /// along just one axis along which all coordinates are equal within a millionth of `diameter` and whose
    /// period is at most `diameter`, and no edge is inclined to that axis. The other two axes are the plane,
    /// in their order.
    ///
    /// # Shapes
    /// `diameter`: the largest diameter and the tolerance, in the unit of the file.
    ///
    /// # Cost
    /// A pass over the centres if the box is thin, until two coordinates differ.
    ///
    /// # Source
    /// LAMMPS documentation, "2d simulations": the box is periodic along z, and all atoms have one z.
    ///
    /// # Example
    /// ```
    /// use std::sync::atomic::AtomicU64;
    ///
    /// let text = b"2\nLattice=\"9 0 0 0 9 0 0 0 1\" Properties=pos:R:3:radius:R:1\n1 1 0 0.5\n2 1 0 0.5\n";
    /// let mut packing = fdem_io::read_packing(text, "a.xyz", &Default::default(), &AtomicU64::new(0))?;
    /// assert_eq!(packing.centres.dimensions(), 3);
    /// assert!(packing.flatten(1.0).is_some());
    /// assert_eq!(packing.centres, fdem_io::Centres::Two(vec![[1.0, 1.0], [2.0, 1.0]]));
    /// # Ok::<(), fdem_io::ReadError>(())
    /// ```
    pub fn flatten(&mut self, diameter: f64) -> Option<String> {
        let axis = self.flat_axis(diameter)?;
        let (Centres::Three(centres), Some(cell)) = (&self.centres, &mut self.cell) else { return None };
        let first = centres[0];
        let (a, b) = ([1, 0, 0][axis], [2, 2, 1][axis]);
        let period = cell.edges[axis][axis].abs();
        let plane = centres.iter().map(|centre| [centre[a], centre[b]]).collect();
        cell.lay_down([a, b, axis]);
        self.centres = Centres::Two(plane);
        Some(format!(
            "read in 2D, with {} and {}: all elements have {along} = {}, and the box is periodic along {along} with \
             {period}, which is no more than their diameter",
            AXES[a],
            AXES[b],
            first[axis],
            along = AXES[axis],
        ))
    }
}

impl Packing {
    /// The axis that [`Packing::flatten`] leaves out; `None` if the packing is not flat.
    fn flat_axis(&self, diameter: f64) -> Option<usize> {
        let (Centres::Three(centres), Some(cell)) = (&self.centres, &self.cell) else { return None };
        let [first, _, ..] = centres[..] else { return None };
        let is_flat = |axis: &usize| {
            let is_equal = |centre: &[f64; 3]| (centre[*axis] - first[*axis]).abs() <= SPREAD * diameter;
            cell.is_thin(*axis, diameter) && centres.iter().all(is_equal)
        };
        let mut flat = (0..3).filter(is_flat);
        // In the cell of a crystal, one element stands for a lattice in space.
        let (Some(axis), None) = (flat.next(), flat.next()) else { return None };
        Some(axis)
    }

    /// A remark for a person if points are flat for a cut-off: they are searched in space, because they may
    /// be the layer of a crystal.
    pub fn layer(&self, cutoff: f64) -> Option<String> {
        let axis = self.flat_axis(cutoff)?;
        let plane = ["yz", "xz", "xy"][axis];
        let along = AXES[axis];
        Some(format!(
            "all points have one {along}, and the box is periodic along {along} with less than the cut-off: points touch \
             their own images; if this is a run in two dimensions, say --periodic {plane}"
        ))
    }
}

impl SimulationBox {
    /// Whether the box is periodic along an axis, with a period of at most `length`, and no edge is inclined
    /// to the axis.
    fn is_thin(&self, axis: usize, length: f64) -> bool {
        let period = self.edges[axis][axis].abs();
        let others = (0..3).filter(|&other| other != axis);
        let mut inclined = others.flat_map(|other| [self.edges[axis][other], self.edges[other][axis]]);
        self.repeats[axis] && 0.0 < period && period <= length && inclined.all(|x| x == 0.0)
    }

    /// Makes these axes the first, the second and the third.
    fn lay_down(&mut self, axes: [usize; 3]) {
        let of = *self;
        self.origin = axes.map(|axis| of.origin[axis]);
        self.edges = axes.map(|edge| axes.map(|axis| of.edges[edge][axis]));
        self.repeats = axes.map(|axis| of.repeats[axis]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packing::{Delimiter, Format, Frame, Skipped, Source};

    fn packing(centres: &[[f64; 3]], edges: [[f64; 3]; 3], repeats: [bool; 3]) -> Packing {
        Packing {
            centres: Centres::Three(centres.to_vec()),
            radii: None,
            ids: None,
            bodies: None,
            types: None,
            row_numbers: None,
            cell: Some(SimulationBox { origin: [1.0, 2.0, 3.0], edges, repeats }),
            frame: Frame::default(),
            source: Source {
                format: Format::Text { delimiter: Delimiter::Comma },
                columns: Vec::new(),
                unit: None,
                lines: 0,
                skipped: Skipped::default(),
            },
        }
    }

    #[test]
    fn a_flat_axis_is_left_out() {
        let edges = [[8.0, 0.0, 0.5], [0.0, 1.0, 0.0], [-2.0, 0.0, 9.0]];
        let mut flat = packing(&[[4.0, 7.0, 1.0], [5.0, 7.0, 2.0]], edges, [true, true, false]);
        let remark = flat.flatten(1.0).unwrap();
        assert!(remark.starts_with("read in 2D, with x and z: all elements have y = 7"), "{remark}");
        assert_eq!(flat.centres, Centres::Two(vec![[4.0, 1.0], [5.0, 2.0]]));
        let cell = flat.cell.unwrap();
        assert_eq!((cell.origin, cell.repeats), ([1.0, 3.0, 2.0], [true, false, true]));
        assert_eq!(cell.edges, [[8.0, 0.5, 0.0], [-2.0, 9.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(flat.flatten(1.0), None, "it is flat by now");
    }

    #[test]
    fn rounding_does_not_make_a_flat_packing_thick() {
        let edges = [[8.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 1.0]];
        let mut flat = packing(&[[4.0, 7.0, 0.0], [5.0, 6.0, 1e-9]], edges, [true; 3]);
        assert!(flat.flatten(1.0).is_some());
        assert_eq!(flat.centres, Centres::Two(vec![[4.0, 7.0], [5.0, 6.0]]));
    }

    #[test]
    fn other_packings_stay_in_space() {
        let edges = [[8.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 1.0]];
        let two = [[4.0, 7.0, 0.0], [5.0, 6.0, 0.0]];
        let all = [true; 3];
        let stays = |centres: &[[f64; 3]], edges, repeats, why: &str| {
            let mut packing = packing(centres, edges, repeats);
            assert_eq!(packing.flatten(1.0), None, "{why}");
            assert_eq!(packing.centres.dimensions(), 3, "{why}");
        };
        stays(&[two[0], [5.0, 6.0, 1e-5]], edges, all, "unlike coordinates");
        stays(&two, edges, [true, true, false], "not periodic");
        stays(&two, [edges[0], edges[1], [0.0, 0.0, 1.5]], all, "a thick box");
        stays(&two, [edges[0], edges[1], [0.1, 0.0, 1.0]], all, "an inclined edge");
        stays(&two, [edges[0], [0.0, 9.0, 0.1], edges[2]], all, "an inclined plane");
        let crystal = [[1.0, 0.0, 0.0], edges[1], edges[2]];
        stays(&[two[0], [4.0, 6.0, 0.0]], crystal, all, "the cell of a crystal");
        stays(&two[..1], edges, all, "one element");
        stays(&[], edges, all, "no elements");
    }
}
