//! Convex pieces of a triangle, by barycentric coordinates.

use crate::vector::cross;

/// Most corners of a piece: of a triangle that was cut by seven lines.
const MOST: usize = 10;

/// A point, by its barycentric coordinates.
pub(super) type Place = [f64; 3];

/// A convex piece of a triangle.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    places: [Place; MOST],
    count: usize,
}

impl Piece {
    pub(super) const WHOLE: Self = {
        let mut places = [[0.0; 3]; MOST];
        places[0][0] = 1.0;
        places[1][1] = 1.0;
        places[2][2] = 1.0;
        Self { places, count: 3 }
    };

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Calls `each` with the triangles of a fan over the piece.
    #[inline]
    pub(super) fn fan(&self, mut each: impl FnMut([Place; 3])) {
        let Some((first, rest)) = self.places[..self.count].split_first() else { return };
        for pair in rest.windows(2) {
            each([*first, pair[0], pair[1]]);
        }
    }

    /// Keeps the part where a linear function with these values at the corners of the face is not negative.
    #[inline]
    pub(super) fn cut(&mut self, values: [f64; 3]) {
        let mut at_corners = [0.0; MOST];
        let (mut any, mut all) = (false, true);
        for (at, place) in at_corners.iter_mut().zip(&self.places[..self.count]) {
            *at = place[0] * values[0] + place[1] * values[1] + place[2] * values[2];
            any |= *at >= 0.0;
            all &= *at >= 0.0;
        }
        if !any {
            self.count = 0;
        }
        if all || !any {
            return;
        }
        let before = self.places;
        let count = std::mem::take(&mut self.count);
        let (mut last, mut at_last) = (before[count - 1], at_corners[count - 1]);
        for (place, at) in before[..count].iter().zip(at_corners) {
            if (at_last < 0.0) != (at < 0.0) {
                let share = at_last / (at_last - at);
                self.push(std::array::from_fn(|k| last[k] + share * (place[k] - last[k])));
            }
            if at >= 0.0 {
                self.push(*place);
            }
            (last, at_last) = (*place, at);
        }
    }

    fn push(&mut self, place: Place) {
        // A convex piece gains at most one corner by a cut; rounding could make it gain more, on corners that coincide.
        if self.count < MOST {
            self.places[self.count] = place;
            self.count += 1;
        }
    }
}

/// Area of a triangle over the area of that on which it lies.
#[inline]
pub(super) fn share_of([a, b, c]: &[Place; 3]) -> f64 {
    cross([b[1] - a[1], b[2] - a[2]], [c[1] - a[1], c[2] - a[2]])
}
