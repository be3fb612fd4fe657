//! Sizes of elements that are smaller near some places.

/// Growth of the size over the distance: the largest that leaves good angles.
pub(crate) const GROWTH: f64 = 0.3;

/// Sizes over its own to which the region where a place makes elements smaller counts in
/// [`Grading::elements`].
const NEAR: f64 = 3.0;

/// Width of a body over the smallest size of its elements: of the 16 digits of a coordinate, 4 are left for
/// the shape of an element then.
const FINEST: f64 = 1e12;

/// The length of edges at each place: everywhere one size, and smaller near some places.
///
/// Within its reach of a place the size is that of the place. Beyond, it grows by 0.3 times the distance
/// until it is the size of the body. Where places meet, the smallest counts.
///
/// # Units
/// All lengths are in the unit of the coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grading<const D: usize> {
    /// Size far from all places; positive.
    pub size: f64,
    /// Where the size is smaller.
    pub near: Vec<Refinement<D>>,
}

/// A place near which elements are smaller.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement<const D: usize> {
    /// The place.
    pub place: Place<D>,
    /// Size at the place; positive.
    pub size: f64,
    /// Distance from the place up to which the size is that; not negative.
    pub reach: f64,
}

/// Points, lines and boxes.
#[derive(Clone, Debug, PartialEq)]
pub enum Place<const D: usize> {
    /// A point.
    Point([f64; D]),
    /// A chain of lines between points, two or more.
    Line(Vec<[f64; D]>),
    /// All that lies between a least and a greatest corner. A box may be flat.
    Box([[f64; D]; 2]),
}

impl<const D: usize> Grading<D> {
    /// One size everywhere.
    pub fn even(size: f64) -> Self {
        Self { size, near: Vec::new() }
    }

    /// The size at a point.
    pub fn at(&self, point: [f64; D]) -> f64 {
        self.near.iter().fold(self.size, |least, near| {
            let beyond = (near.place.distance(point) - near.reach).max(0.0);
            least.min(near.size + GROWTH * beyond)
        })
    }

    /// The smallest size anywhere.
    pub fn least(&self) -> f64 {
        self.near.iter().fold(self.size, |least, near| least.min(near.size))
    }

    /// Returns the sizes in coordinates about another origin.
    #[must_use]
    pub fn relative_to(&self, origin: [f64; D]) -> Self {
        let near = self.near.iter();
        let near = near.map(|near| Refinement { place: near.place.relative_to(origin), ..near.clone() });
        Self { size: self.size, near: near.collect() }
    }
}

impl<const D: usize> Refinement<D> {
    /// About how many cubes, or squares, of the size fit where it holds, within bounds `[low, high]`.
    /// Infinity for a size below 1e-12 of the width of the bounds: coordinates have too few digits for it.
    pub fn cubes(&self, [low, high]: [[f64; D]; 2]) -> f64 {
        if (0..D).any(|axis| high[axis] - low[axis] > FINEST * self.size) {
            return f64::INFINITY;
        }
        let wide = 2.0 * (self.reach + NEAR * self.size);
        let within = |a: [f64; D], b: [f64; D]| -> f64 {
            let along = |axis: usize| {
                let least = (a[axis].min(b[axis]) - 0.5 * wide).max(low[axis]);
                let most = (a[axis].max(b[axis]) + 0.5 * wide).min(high[axis]);
                ((most - least) / self.size).max(0.0)
            };
            (0..D).map(along).product()
        };
        match &self.place {
            Place::Point(point) => within(*point, *point),
            Place::Box([least, most]) => within(*least, *most),
            Place::Line(points) => {
                let across = std::iter::repeat_n(wide / self.size, D - 1).product::<f64>();
                let of = |ends: &[[f64; D]]| {
                    let long = (distance(ends[0], ends[1]) + wide) / self.size;
                    within(ends[0], ends[1]).min(long * across)
                };
                points.windows(2).map(of).sum()
            }
        }
    }
}

impl<const D: usize> Place<D> {
    /// Distance of a point from the place.
    fn distance(&self, point: [f64; D]) -> f64 {
        match self {
            Self::Point(place) => distance(*place, point),
            Self::Line(points) => points
                .windows(2)
                .map(|ends| distance(nearest(ends[0], ends[1], point), point))
                .fold(f64::INFINITY, f64::min),
            Self::Box([low, high]) => {
                let inside = std::array::from_fn(|axis| point[axis].max(low[axis]).min(high[axis]));
                distance(inside, point)
            }
        }
    }

    fn relative_to(&self, origin: [f64; D]) -> Self {
        let moved = |point: [f64; D]| std::array::from_fn(|axis| point[axis] - origin[axis]);
        match self {
            Self::Point(point) => Self::Point(moved(*point)),
            Self::Line(points) => Self::Line(points.iter().copied().map(moved).collect()),
            Self::Box(corners) => Self::Box(corners.map(moved)),
        }
    }
}

/// The point of the line from `a` to `b` that is nearest to `point`.
fn nearest<const D: usize>(a: [f64; D], b: [f64; D], point: [f64; D]) -> [f64; D] {
    let (mut along, mut square) = (0.0, 0.0);
    for axis in 0..D {
        let edge = b[axis] - a[axis];
        along += edge * (point[axis] - a[axis]);
        square += edge * edge;
    }
    let part = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    std::array::from_fn(|axis| a[axis] + part * (b[axis] - a[axis]))
}

fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (0..D).map(|axis| (a[axis] - b[axis]) * (a[axis] - b[axis])).sum::<f64>().sqrt()
}

/// Places from 0 to 1 that cut a curve into pieces as long as `size` says there; without the two ends.
///
/// `length` is the length of the curve; `size` grows by no more than [`GROWTH`] times the distance. `round`
/// makes a number of pieces, 1 or more, of the length over the size.
pub(crate) fn stations(length: f64, size: &dyn Fn(f64) -> f64, round: &dyn Fn(f64) -> usize) -> Vec<f64> {
    /// Share of the size by which the number of pieces is summed up.
    const STEP: f64 = 0.25;
    let mut sums = vec![(0.0, 0.0)];
    let (mut at, mut sum) = (0.0, 0.0);
    while at < 1.0 {
        // However small the size is, the sum comes to its end.
        let step = (STEP * size(at) / length).max(f64::EPSILON).min(1.0 - at);
        // Near the end no step may be lost in rounding.
        let next = if 1.0 - at - step < 0.01 * step { 1.0 } else { at + step };
        sum += (next - at) * length / size(0.5 * (at + next));
        at = next;
        sums.push((at, sum));
    }
    let pieces = round(sum);
    let mut interval = 0;
    (1..pieces)
        .map(|piece| {
            let wanted = sum * piece as f64 / pieces as f64;
            while interval + 2 < sums.len() && sums[interval + 1].1 < wanted {
                interval += 1;
            }
            let ((from, before), (to, after)) = (sums[interval], sums[interval + 1]);
            from + (to - from) * (wanted - before) / (after - before)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_of_places_and_grow_with_the_distance() {
        let near = |place| Refinement { place, size: 0.1, reach: 1.0 };
        for (place, inside, outside) in [
            (Place::Point([0.0, 0.0]), [0.6, 0.8], [3.0, 0.0]),
            (Place::Line(vec![[-1.0, 0.0], [0.0, 0.0], [0.0, -9.0]]), [1.0, -5.0], [3.0, -4.0]),
            (Place::Box([[-2.0, -2.0], [0.0, 0.0]]), [-1.0, 1.0], [3.0, -1.0]),
        ] {
            let grading = Grading { size: 1.0, near: vec![near(place)] };
            assert!((grading.at(inside) - 0.1).abs() < 1e-12);
            assert!((grading.at(outside) - 0.7).abs() < 1e-12);
            assert_eq!(grading.at([50.0, 50.0]), 1.0);
            let moved = grading.relative_to([7.0, -8.0]);
            assert!((moved.at([outside[0] - 7.0, outside[1] + 8.0]) - 0.7).abs() < 1e-12);
        }
    }

    #[test]
    fn stations_are_as_far_from_each_other_as_the_size() {
        let round = |pieces: f64| pieces.round() as usize;
        let even = stations(1.0, &|_| 0.25, &round);
        assert_eq!(even.len(), 3);
        assert!(even.iter().zip([0.25, 0.5, 0.75]).all(|(found, right)| (found - right).abs() < 1e-12));
        let size = |t: f64| 0.01 + 0.3 * t;
        let graded = stations(1.0, &size, &round);
        for pair in graded.windows(2) {
            let ratio = (pair[1] - pair[0]) / size(0.5 * (pair[0] + pair[1]));
            assert!((ratio - 1.0).abs() < 0.1, "{ratio} at {}", pair[0]);
        }
        assert_eq!(stations(1.0, &|_| 5.0, &|_| 3).len(), 2);
        // A size that rounding would lose near the end.
        let lost = |t: f64| 1e-20 + 0.3 * (1.0 - t);
        assert_eq!(stations(1.0, &lost, &|_| 2).len(), 1);
    }

    #[test]
    fn a_size_without_digits_has_no_number_of_elements() {
        let of = |size: f64| Refinement { place: Place::Point([0.0; 2]), size, reach: 0.0 };
        let bounds = [[0.0; 2], [2.0, 1.0]];
        assert_eq!(of(1e-13).cubes(bounds), f64::INFINITY);
        assert!((of(1e-11).cubes(bounds) - 9.0).abs() < 1e-9);
    }
}
