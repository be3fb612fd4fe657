//! Triangles with lines along their edges.
//!
//! A sample belongs to a triangle if it is inside its three edges, computed exactly on a grid of 1/256 of a
//! pixel; on an edge it belongs to one of the two neighbours.

use crate::arrays::each;
use crate::picture::raster::buffer::{PARTS, Paint, Places, Raster};

/// A triangle to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triangle {
    /// Corners in pixels: x to the right and y down from the upper left corner of the picture, z towards the
    /// eye.
    pub(crate) corners: [[f64; 3]; 3],
    pub(crate) paint: Paint,
    /// Lines along the edges from corner `k` to corner `k + 1`, inside the triangle.
    pub(crate) lines: [Stroke; 3],
}

/// A line along an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    /// Width of the part inside the triangle, pixels; 0 if there is no line.
    pub(crate) width: f64,
    pub(crate) paint: Paint,
}

impl Stroke {
    pub(crate) const NONE: Self = Self { width: 0.0, paint: Paint { cover: 0, colour: [0; 3] } };
}

/// Returns the largest depth of a corner.
pub(super) fn nearest(corners: &[[f64; 3]; 3]) -> f32 {
    corners[0][2].max(corners[1][2]).max(corners[2][2]) as f32
}

/// Returns the first and the end of the columns and of the rows of pixels that have parts of a triangle;
/// `None` if there are none.
pub(super) fn box_of(corners: &[[f64; 3]; 3], size: [usize; 2]) -> Option<[[usize; 2]; 2]> {
    for corner in corners {
        if !(corner[0].is_finite() && corner[1].is_finite() && corner[2].is_finite()) {
            return None;
        }
    }
    let mut around = [[0; 2]; 2];
    for axis in 0..2 {
        let [a, b, c] = [corners[0][axis], corners[1][axis], corners[2][axis]];
        // One part more on each side, because corners are moved onto the grid. A cast of a negative number
        // gives 0.
        let first = (a.min(b).min(c) - 1.0 / PARTS) as usize;
        let end = ((a.max(b).max(c) + 1.0 / PARTS).ceil() as usize).min(size[axis]);
        if first >= end {
            return None;
        }
        around[axis] = [first, end];
    }
    Some(around)
}

/// Numbers that are computed once for each triangle.
pub(super) struct Setup<const S: usize> {
    /// Corner at which each edge begins, in parts of a pixel.
    begins: [[f64; 2]; 3],
    /// Change of the function of each edge, which is above 0 inside, along x and y.
    slopes: [[f64; 2]; 3],
    /// Difference of the function at each sample from its value at the upper left corner of the pixel. On an
    /// edge that belongs to the neighbour it is reduced, so that the function is negative there.
    inner: [[i32; S]; 3],
    /// Numbers that are not above and not below any of these.
    ends: [[f64; 2]; 3],
    /// Value of the function up to which the line on an edge reaches, and its colour; those with a line only,
    /// in the order in which they cover each other.
    lines: [Option<(usize, f64, u32)>; 3],
    /// Depth at the first corner, and its change along x and y.
    depth: f64,
    deeper: [f64; 2],
    /// Difference of the depth at each sample from its value at the upper left corner of the pixel.
    depths: [f32; S],
    /// The least and the greatest depth of a corner.
    range: [f32; 2],
    colour: u32,
}

/// Bound on the sum of the slopes of an edge, with which functions at the samples of a pixel that the edge
/// crosses have 31 bits: a triangle 16,000 pixels wide.
const STEEPEST: f64 = 4_194_304.0;

impl<const S: usize> Setup<S> {
    /// Returns `None` for a triangle without area.
    pub(super) fn new(triangle: &Triangle, places: &Places<S>) -> Option<Self> {
        let [a, mut b, mut c] = each(|k| {
            let [x, y, z] = triangle.corners[k];
            [on_grid(x), on_grid(y), z]
        });
        let doubled =
            |b: [f64; 3], c: [f64; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let mut lines = triangle.lines;
        if doubled(b, c) < 0.0 {
            (b, c) = (c, b);
            lines.reverse();
        }
        let area = doubled(b, c);
        // Also if it is not a number, because of corners far outside.
        if !(area > 0.0 && area.is_finite()) {
            return None;
        }
        let (begins, finishes) = ([a, b, c], [b, c, a]);
        let slopes: [[f64; 2]; 3] = each(|k| {
            let [x, y] = [begins[k][1] - finishes[k][1], finishes[k][0] - begins[k][0]];
            // Functions of larger triangles are not exact.
            let share = (STEEPEST / (x.abs() + y.abs())).min(1.0);
            [x * share, y * share]
        });
        let mut inner = [[0; S]; 3];
        let mut ends = [[0.0; 2]; 3];
        for edge in 0..3 {
            let [x, y] = slopes[edge];
            // An edge has opposite directions in its two triangles: one of them has the samples on it. All
            // numbers are integers.
            let strict = if x < 0.0 || (x == 0.0 && y > 0.0) { 0.0 } else { 1.0 };
            inner[edge] = each(|k| (x * places[0][k] + y * places[1][k] - strict) as i32);
            ends[edge] = [(x.min(0.0) + y.min(0.0)) * PARTS - 1.0, (x.max(0.0) + y.max(0.0)) * PARTS];
        }
        let mut order = [0, 1, 2];
        // The widest line is above the others.
        order.sort_by(|&one, &other| {
            lines[one].width.total_cmp(&lines[other].width).then(lines[one].paint.cmp(&lines[other].paint))
        });
        let lines = each(|place| {
            let k = order[place];
            let [x, y] = slopes[k];
            let reach = lines[k].width * PARTS * (x * x + y * y).sqrt();
            (reach > 0.0).then(|| (k, reach, lines[k].paint.packed()))
        });
        let (up, over) = (b[2] - a[2], c[2] - a[2]);
        let deeper = [
            (up * (c[1] - a[1]) - over * (b[1] - a[1])) / area,
            (over * (b[0] - a[0]) - up * (c[0] - a[0])) / area,
        ];
        Some(Self {
            begins: each(|k| [begins[k][0], begins[k][1]]),
            slopes,
            inner,
            ends,
            lines,
            depth: a[2],
            deeper,
            depths: each(|k| (deeper[0] * places[0][k] + deeper[1] * places[1][k]) as f32),
            range: [a[2].min(b[2]).min(c[2]) as f32, a[2].max(b[2]).max(c[2]) as f32],
            colour: triangle.paint.packed(),
        })
    }

    /// Draws the part in these columns and rows.
    pub(super) fn draw(&self, raster: &mut Raster<S>, columns: [usize; 2], rows: [usize; 2]) {
        for row in rows[0]..rows[1] {
            for column in columns[0]..columns[1] {
                let place = (row - raster.top) * raster.width + column;
                if self.range[1] < raster.hidden[place] {
                    continue;
                }
                let [x, y] = [column as f64 * PARTS, row as f64 * PARTS];
                let at: [f64; 3] = each(|k| {
                    (x - self.begins[k][0]) * self.slopes[k][0] + (y - self.begins[k][1]) * self.slopes[k][1]
                });
                if (0..3).any(|k| at[k] + self.ends[k][1] < 0.0) {
                    continue;
                }
                let depth = self.depth
                    + (x - self.begins[0][0]) * self.deeper[0]
                    + (y - self.begins[0][1]) * self.deeper[1];
                raster.hidden[place] =
                    self.pixel(at, depth as f32, &mut raster.depths[place], &mut raster.colours[place]);
            }
        }
    }

    /// Draws one pixel. `at`: functions of the edges at its upper left corner. Returns the least depth of the
    /// samples.
    #[inline]
    fn pixel(&self, at: [f64; 3], depth: f32, depths: &mut [f32; S], colours: &mut [u32; S]) -> f32 {
        let [least, most] = self.range;
        let mut new: [f32; S] = each(|k| {
            let depth = depth + self.depths[k];
            let depth = if depth < least { least } else { depth };
            if depth > most { most } else { depth }
        });
        // Negative at samples outside.
        let mut signs = [0; S];
        let mut crossed = false;
        for edge in 0..3 {
            if at[edge] + self.ends[edge][0] < 0.0 {
                crossed = true;
                let (at, inner) = (at[edge] as i32, &self.inner[edge]);
                signs = each(|k| signs[k] | (at + inner[k]));
            }
        }
        if crossed {
            new = each(|k| if signs[k] < 0 { f32::NEG_INFINITY } else { new[k] });
        }
        let mut colour = [self.colour; S];
        for &(k, reach, paint) in self.lines.iter().flatten() {
            if at[k] + self.ends[k][0] < reach {
                let (rest, inner) = ((reach - at[k]) as f32, &self.inner[k]);
                colour = each(|k| if (inner[k] as f32) < rest { paint } else { colour[k] });
            }
        }
        for k in 0..S {
            let nearer = new[k] > depths[k] || (new[k] == depths[k] && colour[k] < colours[k]);
            depths[k] = if nearer { new[k] } else { depths[k] };
            colours[k] = if nearer { colour[k] } else { colours[k] };
        }
        depths.iter().fold(f32::INFINITY, |least, &depth| if depth < least { depth } else { least })
    }
}

/// Returns the nearest number of parts.
fn on_grid(x: f64) -> f64 {
    (x * PARTS + 0.5).floor()
}

impl<const S: usize> Raster<S> {
    /// Draws a triangle.
    pub(crate) fn triangle(&mut self, triangle: &Triangle) {
        let size = [self.width, self.top + self.height];
        if let Some([columns, [first, end]]) = box_of(&triangle.corners, size)
            && let Some(setup) = Setup::new(triangle, self.places)
        {
            setup.draw(self, columns, [first.max(self.top), end]);
        }
    }
}
