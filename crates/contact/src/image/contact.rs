//! The contact of two bodies in an image.

use crate::error::Error;
use crate::image::row::{DIAGONALS, Direction, DirectionKind, Run};
use crate::image::{Label, Neighbourhood};

/// The edges of a grid square along each axis, the slowest first.
///
/// # Units
/// Any unit of length. Areas are in its square (in 2D, lengths, or areas of an image of unit thickness).
///
/// # Example
/// ```
/// use fdem_contact::image::Spacing;
///
/// let voxels = Spacing::new([2.0, 1.0, 1.0])?; // slices twice as far apart as pixels
/// assert_eq!(voxels.face(0), 1.0);
/// assert_eq!(voxels.face(1), 2.0);
/// assert!(Spacing::new([1.0, 0.0]).is_err());
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing<const D: usize>([f64; D]);

impl<const D: usize> Spacing<D> {
    /// Edges of length 1.
    pub const UNIT: Self = Self([1.0; D]);
    /// Shortest and longest accepted edge: products of edges, also with counts, stay in the range of floats.
    const LIMITS: [f64; 2] = [1e-60, 1e60];

    /// Makes a spacing from the edges, and checks them.
    ///
    /// # Errors
    /// [`Error::InvalidSpacing`].
    pub fn new(edges: [f64; D]) -> Result<Self, Error> {
        let [low, high] = Self::LIMITS;
        match edges.iter().position(|edge| !(low..=high).contains(edge)) {
            Some(axis) => Err(Error::InvalidSpacing { axis, value: edges[axis], limits: Self::LIMITS }),
            None => Ok(Self(edges)),
        }
    }

    /// The edges.
    pub fn edges(&self) -> [f64; D] {
        self.0
    }

    /// Area of a face across an axis: the product of the other edges.
    pub fn face(&self, axis: usize) -> f64 {
        self.0.iter().enumerate().filter(|(other, _)| *other != axis).map(|(_, edge)| edge).product()
    }
}

/// Two bodies in contact, with all counts.
///
/// The counts are integers; area, centroid and normal are computed from them for the [`Spacing`] of the
/// image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageContact<L, const D: usize> {
    labels: [L; 2],
    /// For each axis across which faces lie, the sums modulo 2^32: at half the size, more contacts fit into
    /// the caches.
    low: [FacesAcross<D>; D],
    /// Data that few contacts have, or that few searches request. `None` if it would be empty, so that equal
    /// contacts compare equal.
    more: Option<Box<More<D>>>,
}

/// The faces across one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FacesAcross<const D: usize> {
    /// Number of faces behind which the larger label is, and of those behind which the smaller is.
    faces: [u32; 2],
    /// The sum of the centres of the faces, in half grid squares.
    centres: [u32; D],
}

impl<const D: usize> FacesAcross<D> {
    const NONE: Self = Self { faces: [0; 2], centres: [0; D] };
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct More<const D: usize> {
    /// The sums of the faces divided by 2^32.
    high: [FacesAcross<D>; D],
    // Number of pairs that share an edge; below, of those that share a vertex.
    edges: u64,
    vertices: u64,
    /// For each direction: number of pairs with the larger label later in the array, minus number of pairs
    /// with the smaller one later.
    net: [i64; DIAGONALS],
    /// The sum of the midpoints, in half grid squares.
    midpoints: [u64; D],
}

impl<L: Label, const D: usize> ImageContact<L, D> {
    pub(super) fn new(labels: [L; 2]) -> Self {
        Self { labels, low: [FacesAcross::NONE; D], more: None }
    }

    /// Adds a run; `at` is the position of its later row along the other axes.
    #[inline]
    pub(super) fn add(&mut self, run: &Run<L>, at: &[u64], direction: &Direction<D>) {
        let count = (run.end - run.start) as u64;
        // The sum of the doubled indices of the later grid squares minus the step; `ImageContacts::new` has
        // bounded all of it.
        let sum = |axis: usize| {
            let doubled = if axis == D - 1 { (run.start + run.end - 1) as u64 } else { 2 * at[axis] };
            count * doubled.wrapping_add_signed(-i64::from(direction.step[axis]))
        };
        let backwards = run.later < run.earlier;
        match direction.kind {
            DirectionKind::Face { axis: across } => {
                let faces = if backwards { [0, count] } else { [count, 0] };
                self.add_faces(across, faces, std::array::from_fn(sum));
            }
            DirectionKind::Edge { number } | DirectionKind::Vertex { number } => {
                let more = self.more_mut();
                if matches!(direction.kind, DirectionKind::Edge { .. }) {
                    more.edges += count;
                } else {
                    more.vertices += count;
                }
                more.net[number] += if backwards { -count.cast_signed() } else { count.cast_signed() };
                for (axis, midpoint) in more.midpoints.iter_mut().enumerate() {
                    *midpoint += sum(axis);
                }
            }
        }
    }

    /// Adds faces across one axis. No sum of an image exceeds `i64::MAX`.
    #[inline]
    fn add_faces(&mut self, across: usize, faces: [u64; 2], centres: [u64; D]) {
        let low = &mut self.low[across];
        let mut carried = 0;
        let mut add = |low: &mut u32, n: u64| {
            let sum = u64::from(*low) + n;
            *low = sum as u32;
            carried |= sum >> u32::BITS;
            (sum >> u32::BITS) as u32
        };
        let high = FacesAcross {
            faces: std::array::from_fn(|side| add(&mut low.faces[side], faces[side])),
            centres: std::array::from_fn(|axis| add(&mut low.centres[axis], centres[axis])),
        };
        if carried != 0 {
            self.carry(across, high);
        }
    }

    #[cold]
    fn carry(&mut self, across: usize, carried: FacesAcross<D>) {
        let high = &mut self.more_mut().high[across];
        high.faces.iter_mut().zip(carried.faces).for_each(|(high, n)| *high += n);
        high.centres.iter_mut().zip(carried.centres).for_each(|(high, n)| *high += n);
    }

    fn more_mut(&mut self) -> &mut More<D> {
        self.more.get_or_insert_with(|| {
            Box::new(More {
                high: [FacesAcross::NONE; D],
                edges: 0,
                vertices: 0,
                net: [0; DIAGONALS],
                midpoints: [0; D],
            })
        })
    }

    /// The same contact with labels of a type that holds those of every image: code that comes after need not
    /// know the type of the image.
    pub fn widened(self) -> ImageContact<i128, D> {
        ImageContact { labels: self.labels.map(Into::into), low: self.low, more: self.more }
    }

    /// Adds the counts of the same contact in another part of the image.
    pub(super) fn merge(&mut self, other: &Self) {
        for across in 0..D {
            self.add_faces(across, other.sides(across), other.centres(across));
        }
        // The rest concerns diagonals; if the other part has none, none need be added.
        let Some(other) = other.more.as_ref().filter(|other| other.edges + other.vertices > 0) else {
            return;
        };
        let more = self.more_mut();
        more.edges += other.edges;
        more.vertices += other.vertices;
        more.net.iter_mut().zip(&other.net).for_each(|(into, n)| *into += n);
        more.midpoints.iter_mut().zip(&other.midpoints).for_each(|(into, n)| *into += n);
    }
}

impl<L: Copy, const D: usize> ImageContact<L, D> {
    /// Number of faces across an axis behind which the larger label is, and of those behind which the smaller
    /// is.
    fn sides(&self, across: usize) -> [u64; 2] {
        let high = self.high(across);
        std::array::from_fn(|side| whole(high.faces[side], self.low[across].faces[side]))
    }

    /// The sum of the centres of the faces across an axis, in half grid squares.
    fn centres(&self, across: usize) -> [u64; D] {
        let high = self.high(across);
        std::array::from_fn(|axis| whole(high.centres[axis], self.low[across].centres[axis]))
    }

    fn high(&self, across: usize) -> FacesAcross<D> {
        self.more.as_ref().map_or(FacesAcross::NONE, |more| more.high[across])
    }

    /// The two labels, the smaller first.
    pub fn labels(&self) -> [L; 2] {
        self.labels
    }

    /// Number of shared faces: the area, if a face has area 1.
    pub fn faces(&self) -> u64 {
        self.faces_along().iter().sum()
    }

    /// Number of shared faces across each axis.
    pub fn faces_along(&self) -> [u64; D] {
        std::array::from_fn(|across| self.sides(across).into_iter().sum())
    }

    /// Number of pairs of grid squares that share an edge but no face; 0 unless [`Neighbourhood::Edge`] or
    /// `Vertex` was requested.
    pub fn edges(&self) -> u64 {
        self.more.as_ref().map_or(0, |more| more.edges)
    }

    /// Number of pairs of grid squares that share only a vertex; 0 unless [`Neighbourhood::Vertex`] was
    /// requested.
    pub fn vertices(&self) -> u64 {
        self.more.as_ref().map_or(0, |more| more.vertices)
    }

    /// Area of the shared faces; in 2D the length of the shared sides.
    ///
    /// # Units
    /// The unit of the spacing, squared; in 2D the unit of the spacing.
    pub fn area(&self, spacing: &Spacing<D>) -> f64 {
        let faces = self.faces_along();
        (0..D).map(|axis| spacing.face(axis) * faces[axis] as f64).sum()
    }

    /// The mean of the centres of the shared faces, weighted by their areas; without faces, the mean of the
    /// midpoints of the pairs.
    ///
    /// # Units
    /// The unit of the spacing; the centre of the first grid square of the image is at 0.
    pub fn centroid(&self, spacing: &Spacing<D>) -> [f64; D] {
        let mut sums = [0.0; D];
        let mut count = 0.0;
        if self.faces() > 0 {
            for (across, faces) in self.faces_along().into_iter().enumerate() {
                let face = spacing.face(across);
                count += face * faces as f64;
                for (sum, centre) in sums.iter_mut().zip(self.centres(across)) {
                    *sum += face * centre as f64;
                }
            }
        } else if let Some(more) = &self.more {
            count = (more.edges + more.vertices) as f64;
            sums = more.midpoints.map(|sum| sum as f64);
        }
        std::array::from_fn(|axis| sums[axis] / (2.0 * count) * spacing.0[axis])
    }

    /// The mean direction of the contact, from the smaller label to the larger: a unit vector.
    ///
    /// With faces, its direction is the sum of their areas, each times its unit normal. Without faces, it is
    /// the sum of the unit vectors from centre to centre of the pairs. If the sum is zero, as for a body
    /// inside another one, there is no such direction, and the vector is all zeros.
    pub fn normal(&self, spacing: &Spacing<D>) -> [f64; D] {
        let mut sum = [0.0; D];
        if self.faces() > 0 {
            for (axis, sum) in sum.iter_mut().enumerate() {
                let [forwards, backwards] = self.sides(axis);
                *sum = (i128::from(forwards) - i128::from(backwards)) as f64 * spacing.face(axis);
            }
        } else if let Some(more) = &self.more {
            for Direction { step, kind } in Direction::<D>::all(Neighbourhood::Vertex) {
                let (DirectionKind::Edge { number } | DirectionKind::Vertex { number }) = kind else {
                    continue;
                };
                let from_centre_to_centre =
                    std::array::from_fn(|axis| f64::from(step[axis]) * spacing.0[axis]);
                let unit: [f64; D] = unit(from_centre_to_centre);
                for (sum, unit) in sum.iter_mut().zip(unit) {
                    *sum += more.net[number] as f64 * unit;
                }
            }
        }
        unit(sum)
    }
}

fn whole(high: u32, low: u32) -> u64 {
    u64::from(high) << u32::BITS | u64::from(low)
}

/// The vector divided by its length; a zero vector stays zero.
pub(crate) fn unit<const D: usize>(vector: [f64; D]) -> [f64; D] {
    let largest = vector.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    if largest == 0.0 {
        return [0.0; D];
    }
    // The squares of values within range may be out of range.
    let scaled = vector.map(|x| x / largest);
    let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Adding zero makes a component that vanishes positive.
    scaled.map(|x| x / length + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::contacts;

    #[test]
    fn areas_and_centroids_have_the_spacing() {
        // Label 1 is below label 2 over a step: one face across axis 0, one across axis 1.
        let found = contacts(&[1_u8, 1, 2, 1], [2, 1, 2], Neighbourhood::Face).unwrap();
        let [contact] = &found[..] else { panic!("{found:?}") };
        assert_eq!(contact.faces_along(), [1, 0, 1]);
        let spacing = Spacing::new([3.0, 1.0, 2.0]).unwrap();
        // A face of area 2 at (1.5, 0, 0), and a face of area 3 at (3, 0, 1).
        assert_eq!(contact.area(&spacing), 5.0);
        let [z, y, x] = contact.centroid(&spacing);
        assert!((z - (2.0 * 1.5 + 3.0 * 3.0) / 5.0).abs() < 1e-15 && y == 0.0 && x == 0.6, "{z} {y} {x}");
        let [z, y, x] = contact.normal(&spacing);
        assert_eq!(y, 0.0);
        assert!(
            (z - 2.0 / 13_f64.sqrt()).abs() < 1e-15 && (x + 3.0 / 13_f64.sqrt()).abs() < 1e-15,
            "{z} {x}"
        );
    }

    #[test]
    fn a_body_inside_another_has_no_normal() {
        let found = contacts(&[7_u8, 7, 7, 7, 3, 7, 7, 7, 7], [3, 3], Neighbourhood::Vertex).unwrap();
        assert_eq!((found[0].faces(), found[0].vertices()), (4, 4));
        assert_eq!(found[0].normal(&Spacing::UNIT), [0.0, 0.0]);
        assert_eq!(found[0].centroid(&Spacing::UNIT), [1.0, 1.0]);
        // The same with corners only.
        let found = contacts(&[7_u8, 0, 7, 0, 3, 0, 7, 0, 7], [3, 3], Neighbourhood::Vertex).unwrap();
        assert_eq!((found[0].faces(), found[0].vertices()), (0, 4));
        assert_eq!(found[0].normal(&Spacing::UNIT), [0.0, 0.0]);
        assert_eq!(found[0].centroid(&Spacing::UNIT), [1.0, 1.0]);
    }

    #[test]
    fn without_faces_midpoints_count() {
        let found = contacts(&[5_u8, 0, 0, 4], [2, 2], Neighbourhood::Vertex).unwrap();
        let spacing = Spacing::new([3.0, 4.0]).unwrap();
        assert_eq!(found[0].area(&spacing), 0.0);
        assert_eq!(found[0].centroid(&spacing), [1.5, 2.0]);
        let [y, x] = found[0].normal(&spacing);
        assert!((y + 0.6).abs() < 1e-15 && (x + 0.8).abs() < 1e-15, "from 4 to 5: {y} {x}");
    }

    #[test]
    fn sums_beyond_32_bits_are_whole() {
        // Five runs of 2^30 faces and two more runs, in rows far down a plane: in one sum, and in the sums of
        // two threads.
        let across: Vec<Direction<3>> = Direction::all(Neighbourhood::Face).collect();
        let (wide, at) = (1 << 30, [5, 70_000]);
        let run = |start, end| Run { earlier: 1_u8, later: 2, start, end };
        let mut parts: [_; 3] = std::array::from_fn(|_| ImageContact::<u8, 3>::new([1, 2]));
        let [one, both, other] = &mut parts;
        for number in 0..5 {
            one.add(&run(0, wide), &at, &across[1]);
            if number < 3 { &mut *both } else { &mut *other }.add(&run(0, wide), &at, &across[1]);
        }
        let mut few = ImageContact::new([1, 2]);
        for contact in [&mut *one, &mut few] {
            contact.add(&run(7, 9), &at, &across[1]);
        }
        assert!(few.more.is_none());
        few.merge(other);
        few.merge(both);
        assert_eq!(few, *one);
        let n = 5_u64 << 30;
        assert_eq!(one.faces_along(), [0, n + 2, 0]);
        // Twice z, y - 1/2 and x of each run.
        let along_x = n * ((1 << 30) - 1) + 14 + 16;
        assert_eq!(one.centres(1), [(n + 2) * 10, (n + 2) * 139_999, along_x]);
        let x = along_x as f64 / 2.0 / (n + 2) as f64;
        assert_eq!(one.centroid(&Spacing::UNIT)[..2], [5.0, 69_999.5]);
        assert!((one.centroid(&Spacing::UNIT)[2] / x - 1.0).abs() < 1e-15);
        assert_eq!(one.normal(&Spacing::UNIT), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn a_widened_contact_is_the_same_contact() {
        let found = contacts(&[-5_i64, 7, 0, -5], [2, 2], Neighbourhood::Vertex).unwrap();
        let wide = found[0].clone().widened();
        assert_eq!(wide.labels(), [-5, 7]);
        assert_eq!((wide.faces_along(), wide.vertices()), (found[0].faces_along(), found[0].vertices()));
        assert_eq!(wide.normal(&Spacing::UNIT), found[0].normal(&Spacing::UNIT));
        assert_eq!(
            contacts(&[1, u64::MAX], [1, 2], Neighbourhood::Face).unwrap()[0].clone().widened().labels()[1],
            i128::from(u64::MAX)
        );
    }

    #[test]
    fn spacings_that_are_no_lengths_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e61, 1e-61] {
            let error = Spacing::new([1.0, bad]).unwrap_err();
            assert!(matches!(error, Error::InvalidSpacing { axis: 1, .. }), "{error}");
        }
        let extreme = Spacing::new([1e60, 1e-60, 1e60]).unwrap();
        let found = contacts(&[1_u8, 2], [1, 1, 2], Neighbourhood::Face).unwrap();
        assert_eq!(found[0].normal(&extreme), [0.0, 0.0, 1.0]);
        assert!((found[0].centroid(&extreme)[2] / 1e60 - 0.5).abs() < 1e-15);
    }
}
