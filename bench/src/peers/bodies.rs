//! The bodies that are searched.

use fdem_contact::{Elements, Error};

/// Bodies in arrays of the caller.
#[derive(Clone, Copy, Debug)]
pub enum Bodies<'a, const D: usize> {
    /// Points: two form a couple if they are at most the cut-off apart.
    Points {
        /// The points.
        points: &'a [[f64; D]],
        /// The cut-off.
        cutoff: f64,
    },
    /// Spheres of unlike sizes: two form a couple if their centres are at most the sum of their radii apart.
    Spheres {
        /// The centres.
        centres: &'a [[f64; D]],
        /// The radii.
        radii: &'a [f64],
    },
    /// Axis-aligned boxes, closed.
    Boxes {
        /// The corners with the smallest coordinates.
        min: &'a [[f64; D]],
        /// The corners with the largest coordinates.
        max: &'a [[f64; D]],
    },
}

impl<'a, const D: usize> Bodies<'a, D> {
    /// The points and the cut-off, for searches that support only these.
    ///
    /// # Errors
    /// An error if the bodies are not points.
    pub fn points(self) -> Result<(&'a [[f64; D]], f64), String> {
        match self {
            Self::Points { points, cutoff } => Ok((points, cutoff)),
            Self::Spheres { .. } => Err("one distance for all".to_owned()),
            Self::Boxes { .. } => Err("points only".to_owned()),
        }
    }

    /// The bodies as elements of our searches.
    ///
    /// # Errors
    /// The errors of the constructors of [`Elements`].
    pub fn elements(self) -> Result<Elements<'a, f64, D>, Error> {
        match self {
            Self::Points { points, cutoff } => Elements::points(points, cutoff),
            Self::Spheres { centres, radii } => Elements::spheres_with_radii(centres, radii),
            Self::Boxes { min, max } => Elements::boxes(min, max),
        }
    }

    /// Whether two bodies touch, for libraries that return candidates: the closed comparisons of this
    /// workspace.
    #[must_use]
    pub fn touch(self, i: u32, j: u32) -> bool {
        let (i, j) = (i as usize, j as usize);
        match self {
            Self::Points { points, cutoff } => within(&points[i], &points[j], cutoff),
            Self::Spheres { centres, radii } => within(&centres[i], &centres[j], radii[i] + radii[j]),
            Self::Boxes { min, max } => {
                (0..D).all(|axis| min[i][axis] <= max[j][axis] && min[j][axis] <= max[i][axis])
            }
        }
    }

    /// The bounding box of a body.
    #[must_use]
    pub fn bounds(self, i: usize) -> [[f64; D]; 2] {
        match self {
            Self::Points { points, cutoff } => around(&points[i], 0.5 * cutoff),
            Self::Spheres { centres, radii } => around(&centres[i], radii[i]),
            Self::Boxes { min, max } => [min[i], max[i]],
        }
    }

    /// Number of bodies.
    #[must_use]
    pub fn len(self) -> usize {
        match self {
            Self::Points { points, .. } => points.len(),
            Self::Spheres { centres, .. } => centres.len(),
            Self::Boxes { min, .. } => min.len(),
        }
    }

    /// Whether there are no bodies.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The third argument of external programs (`bench/external/README.md`).
    #[must_use]
    pub fn argument(self) -> String {
        match self {
            Self::Points { cutoff, .. } => cutoff.to_string(),
            Self::Spheres { .. } => "radii".to_owned(),
            Self::Boxes { .. } => "boxes".to_owned(),
        }
    }

    /// The content of the file for external programs, body by body.
    #[must_use]
    pub fn numbers(self) -> Vec<f64> {
        let mut numbers = Vec::new();
        for i in 0..self.len() {
            match self {
                Self::Points { points, .. } => numbers.extend(points[i]),
                Self::Spheres { centres, radii } => {
                    numbers.extend(centres[i]);
                    numbers.push(radii[i]);
                }
                Self::Boxes { min, max } => {
                    numbers.extend(min[i]);
                    numbers.extend(max[i]);
                }
            }
        }
        numbers
    }
}

/// The closed comparison of this workspace.
pub(super) fn within<const D: usize>(a: &[f64; D], b: &[f64; D], distance: f64) -> bool {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.reduce(|sum, square| sum + square).is_some_and(|sum| sum <= distance * distance)
}

fn around<const D: usize>(centre: &[f64; D], radius: f64) -> [[f64; D]; 2] {
    [centre.map(|x| x - radius), centre.map(|x| x + radius)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_touches_is_what_elements_say() {
        let (centres, radii) = ([[0.0, 0.0], [3.0, 4.0], [3.1, 4.0]], [2.0, 3.0, 0.5]);
        let (min, max) = ([[0.0, 0.0], [1.0, 1.0], [1.0, 1.1]], [[1.0, 1.0], [2.0, 2.0], [1.0, 1.1]]);
        let all = [
            Bodies::Points { points: &centres, cutoff: 5.0 },
            Bodies::Spheres { centres: &centres, radii: &radii },
            Bodies::Boxes { min: &min, max: &max },
        ];
        for bodies in all {
            let elements = bodies.elements().unwrap();
            let pairs = [(0, 1), (0, 2), (1, 2)];
            let touching = pairs.map(|(i, j)| bodies.touch(i, j));
            assert_eq!(touching, [true, false, true], "{bodies:?}");
            assert_eq!(touching, pairs.map(|(i, j)| elements.touch(i as usize, j as usize)), "{bodies:?}");
        }
        assert_eq!(all.map(Bodies::argument), ["5", "radii", "boxes"]);
        assert_eq!(all[1].numbers(), [0.0, 0.0, 2.0, 3.0, 4.0, 3.0, 3.1, 4.0, 0.5]);
        assert_eq!(all[2].numbers()[..6], [0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!((all[1].bounds(1), all[2].bounds(2)), ([[0.0, 1.0], [6.0, 7.0]], [[1.0, 1.1]; 2]));
    }
}
