//! Triangles drawn into pixels, the nearer ones over those behind, without a graphics card. The pixels are
//! the same on every machine, and in every order of the triangles.
//!
//! A pixel has 16 samples. A sample belongs to a triangle if it is inside its three edges, computed exactly
//! on a grid of 1/256 of a pixel; on an edge it belongs to one of the two neighbours. Of the triangles at a
//! sample the one nearest to the eye is kept; at equal depths the one with the smaller number of a colour.
//! The picture is drawn in bands of a few rows, so that the samples fit into a cache.

use crate::arrays::each;
use crate::picture::colour::Rgb;

/// Parts of a pixel in which corners are placed.
const PARTS: f64 = 256.0;

/// Samples in a pixel.
const SAMPLES: usize = 16;

/// Places of the samples, parts of a pixel from its upper left corner. No two are in one of 16 columns or in
/// one of 16 rows, and there is one in each of 4 × 4 squares, so that edges in all directions are smooth.
const PLACES: [[f64; SAMPLES]; 2] = {
    let mut places = [[0.0; SAMPLES]; 2];
    let mut k = 0;
    while k < SAMPLES {
        let (column, row) = (k / 4, k % 4);
        places[0][k] = (16 * (4 * column + row) + 8) as f64;
        places[1][k] = (16 * (4 * row + 3 - column) + 8) as f64;
        k += 1;
    }
    places
};

/// Rows of a band, pixels.
const BAND: usize = 16;

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

/// A colour, and how much it covers, from 0 to 255. In the first layer all colours cover fully.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Paint {
    pub(crate) cover: u8,
    pub(crate) colour: Rgb,
}

impl Paint {
    pub(crate) fn solid(colour: Rgb) -> Self {
        Self { cover: 255, colour }
    }

    fn packed(self) -> u32 {
        let [red, green, blue] = self.colour;
        u32::from_be_bytes([self.cover, red, green, blue])
    }
}

impl Stroke {
    pub(crate) const NONE: Self = Self { width: 0.0, paint: Paint { cover: 0, colour: [0; 3] } };
}

/// Draws layers of triangles on white. A later layer is drawn over an earlier one where it is nearer to the
/// eye, and only the nearest triangle of each layer is seen. Triangles with corners that are not finite are
/// not drawn.
///
/// # Returns
/// Red, green and blue of each pixel, row by row from the top.
///
/// # Cost
/// 132 bytes for each layer and each pixel of 16 rows, and 8 to 24 bytes for each triangle. Time proportional
/// to the triangles and to the pixels of the boxes around them.
pub(crate) fn draw([width, height]: [usize; 2], layers: &[Vec<Triangle>]) -> Vec<u8> {
    let mut pixels = Vec::with_capacity(3 * width * height);
    let mut sweeps: Vec<Sweep<'_>> =
        layers.iter().map(|triangles| Sweep::new(triangles, [width, height])).collect();
    let mut bands: Vec<Band> = layers.iter().map(|_| Band::new(width)).collect();
    for top in (0..height).step_by(BAND) {
        let rows = BAND.min(height - top);
        for (sweep, band) in sweeps.iter_mut().zip(&mut bands) {
            band.clear(top);
            sweep.draw(band, rows);
        }
        append(&mut pixels, &bands, rows * width);
    }
    pixels
}

/// The triangles of a layer in the order of their first rows.
struct Sweep<'a> {
    triangles: &'a [Triangle],
    size: [usize; 2],
    /// First row and number of the triangles that are in the picture.
    starts: Vec<(u32, u32)>,
    /// Number of triangles that have been started.
    started: usize,
    /// Triangles that reach below the last band, with the depth of their nearest corner.
    active: Vec<(f32, u32)>,
}

impl<'a> Sweep<'a> {
    fn new(triangles: &'a [Triangle], size: [usize; 2]) -> Self {
        let mut starts: Vec<(u32, u32)> = (0..)
            .zip(triangles)
            .filter_map(|(number, triangle)| Some((box_of(&triangle.corners, size)?[1][0] as u32, number)))
            .collect();
        starts.sort_unstable();
        Self { triangles, size, starts, started: 0, active: Vec::new() }
    }

    /// Draws the triangles in a band with `rows` rows.
    fn draw(&mut self, band: &mut Band, rows: usize) {
        let end = band.top + rows;
        while let Some(&(_, number)) =
            self.starts.get(self.started).filter(|(first, _)| (*first as usize) < end)
        {
            self.active.push((nearest(&self.triangles[number as usize].corners), number));
            self.started += 1;
        }
        // The nearest first: most of the others are then hidden, which is quickly seen.
        self.active.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        self.active.retain(|&(_, number)| {
            let triangle = &self.triangles[number as usize];
            let Some(around) = box_of(&triangle.corners, self.size) else { return false };
            if let Some(setup) = Setup::new(triangle) {
                let first = around[1][0].max(band.top);
                setup.draw(band, around[0], [first, around[1][1].min(end)]);
            }
            around[1][1] > end
        });
    }
}

/// Returns the largest depth of a corner.
fn nearest(corners: &[[f64; 3]; 3]) -> f32 {
    corners[0][2].max(corners[1][2]).max(corners[2][2]) as f32
}

/// Returns the first and the end of the columns and of the rows of pixels that have parts of a triangle;
/// `None` if the triangle is outside.
fn box_of(corners: &[[f64; 3]; 3], size: [usize; 2]) -> Option<[[usize; 2]; 2]> {
    for corner in corners {
        if !(corner[0].is_finite() && corner[1].is_finite() && corner[2].is_finite()) {
            return None;
        }
    }
    let mut around = [[0; 2]; 2];
    for axis in 0..2 {
        let [a, b, c] = [corners[0][axis], corners[1][axis], corners[2][axis]];
        // One part more on each side, because corners are moved onto the grid. Negative numbers are cast
        // to 0.
        let first = (a.min(b).min(c) - 1.0 / PARTS) as usize;
        let end = ((a.max(b).max(c) + 1.0 / PARTS).ceil() as usize).min(size[axis]);
        if first >= end {
            return None;
        }
        around[axis] = [first, end];
    }
    Some(around)
}

/// Values that are computed once for a triangle.
struct Setup {
    /// Corner at which each edge begins, in parts of a pixel.
    begins: [[f64; 2]; 3],
    /// Change of the function of each edge, which is above 0 inside, along x and y.
    slopes: [[f64; 2]; 3],
    /// Its excess at the samples over its value at the upper left corner of the pixel, minus the amount that
    /// makes it negative at samples on edges of the neighbour.
    inner: [[i32; SAMPLES]; 3],
    /// Numbers that are not above and not below any of these.
    ends: [[f64; 2]; 3],
    /// Value of the function up to which the line on an edge reaches, and its colour; those with a line only,
    /// in the order in which they cover each other.
    lines: [Option<(usize, f64, u32)>; 3],
    /// Depth at the first corner, and its change along x and y.
    depth: f64,
    deeper: [f64; 2],
    /// Excess of the depth at the samples.
    depths: [f32; SAMPLES],
    /// The least and the greatest depth of a corner.
    range: [f32; 2],
    colour: u32,
}

/// Bound on the sum of the slopes of an edge, with which functions at the samples of a pixel that the edge
/// crosses have 31 bits: a triangle 16,000 pixels wide.
const STEEPEST: f64 = 4_194_304.0;

impl Setup {
    /// Returns `None` for a triangle without area.
    fn new(triangle: &Triangle) -> Option<Self> {
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
        let mut inner = [[0; SAMPLES]; 3];
        let mut ends = [[0.0; 2]; 3];
        for edge in 0..3 {
            let [x, y] = slopes[edge];
            // An edge has opposite directions in its two triangles: one of them has the samples on it. All
            // numbers are integers.
            let strict = if x < 0.0 || (x == 0.0 && y > 0.0) { 0.0 } else { 1.0 };
            inner[edge] = each(|k| (x * PLACES[0][k] + y * PLACES[1][k] - strict) as i32);
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
            depths: each(|k| (deeper[0] * PLACES[0][k] + deeper[1] * PLACES[1][k]) as f32),
            range: [a[2].min(b[2]).min(c[2]) as f32, a[2].max(b[2]).max(c[2]) as f32],
            colour: triangle.paint.packed(),
        })
    }

    /// Draws the part in these columns and rows.
    fn draw(&self, band: &mut Band, columns: [usize; 2], rows: [usize; 2]) {
        for row in rows[0]..rows[1] {
            for column in columns[0]..columns[1] {
                let place = (row - band.top) * band.width + column;
                if self.range[1] < band.hidden[place] {
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
                band.hidden[place] =
                    self.pixel(at, depth as f32, &mut band.depths[place], &mut band.colours[place]);
            }
        }
    }

    /// Draws one pixel. `at`: functions of the edges at its upper left corner. Returns the least depth of the
    /// samples.
    #[inline]
    fn pixel(
        &self,
        at: [f64; 3],
        depth: f32,
        depths: &mut [f32; SAMPLES],
        colours: &mut [u32; SAMPLES],
    ) -> f32 {
        let [least, most] = self.range;
        let mut new: [f32; SAMPLES] = each(|k| {
            let depth = depth + self.depths[k];
            let depth = if depth < least { least } else { depth };
            if depth > most { most } else { depth }
        });
        // Negative at samples outside.
        let mut signs = [0; SAMPLES];
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
        let mut colour = [self.colour; SAMPLES];
        for &(k, reach, paint) in self.lines.iter().flatten() {
            if at[k] + self.ends[k][0] < reach {
                let (rest, inner) = ((reach - at[k]) as f32, &self.inner[k]);
                colour = each(|k| if (inner[k] as f32) < rest { paint } else { colour[k] });
            }
        }
        for k in 0..SAMPLES {
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

/// Depths and colours of the samples of some rows.
struct Band {
    width: usize,
    /// First row.
    top: usize,
    depths: Vec<[f32; SAMPLES]>,
    colours: Vec<[u32; SAMPLES]>,
    /// The least depth of the samples of each pixel.
    hidden: Vec<f32>,
}

/// A sample where nothing is drawn. No colour of a triangle is less, so that nothing is drawn at samples that
/// are outside of it, whose depth is infinite.
const NOTHING: u32 = 0;

impl Band {
    fn new(width: usize) -> Self {
        let count = width * BAND;
        Self {
            width,
            top: 0,
            depths: vec![[f32::NEG_INFINITY; SAMPLES]; count],
            colours: vec![[NOTHING; SAMPLES]; count],
            hidden: vec![f32::NEG_INFINITY; count],
        }
    }

    fn clear(&mut self, top: usize) {
        self.top = top;
        self.depths.fill([f32::NEG_INFINITY; SAMPLES]);
        self.colours.fill([NOTHING; SAMPLES]);
        self.hidden.fill(f32::NEG_INFINITY);
    }
}

/// Appends the pixels of layers that lie above each other.
fn append(pixels: &mut Vec<u8>, layers: &[Band], count: usize) {
    let Some((first, above)) = layers.split_first() else {
        pixels.resize(pixels.len() + 3 * count, 255);
        return;
    };
    let white = Paint::solid([255; 3]).packed();
    for place in 0..count {
        let mut colours = first.colours[place];
        for colour in &mut colours {
            *colour = if *colour == NOTHING { white } else { *colour };
        }
        if !above.is_empty() {
            lay(&mut colours, &first.depths[place], above, place);
        }
        let [one, ..] = colours;
        if colours.iter().fold(0, |differ, colour| differ | (colour ^ one)) == 0 {
            pixels.extend_from_slice(&one.to_be_bytes()[1..]);
            continue;
        }
        // Two channels are summed together: neither sum exceeds 16 bits.
        let (mut outer, mut middle) = (0_u32, 0_u32);
        for colour in colours {
            outer += colour & 0x00ff_00ff;
            middle += colour >> 8 & 0xff;
        }
        let mean = |sum: u32| ((sum + SAMPLES as u32 / 2) / SAMPLES as u32) as u8;
        pixels.extend_from_slice(&[mean(outer >> 16), mean(middle), mean(outer & 0xffff)]);
    }
}

/// Lays the samples of further layers over those of the first.
fn lay(colours: &mut [u32; SAMPLES], depths: &[f32; SAMPLES], layers: &[Band], place: usize) {
    let mut depths = *depths;
    for layer in layers {
        let (over, nearer) = (&layer.colours[place], &layer.depths[place]);
        for k in 0..SAMPLES {
            if over[k] != NOTHING && nearer[k] >= depths[k] {
                colours[k] = laid(colours[k], over[k]);
                depths[k] = nearer[k];
            }
        }
    }
}

/// Returns a colour with another over it.
fn laid(below: u32, above: u32) -> u32 {
    let ([_, r, g, b], [cover, red, green, blue]) = (below.to_be_bytes(), above.to_be_bytes());
    let cover = u32::from(cover);
    let mixed = |below: u8, above: u8| {
        ((u32::from(above) * cover + u32::from(below) * (255 - cover) + 127) / 255) as u8
    };
    u32::from_be_bytes([255, mixed(r, red), mixed(g, green), mixed(b, blue)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = [200, 0, 0];
    const GREEN: Rgb = [0, 200, 0];

    fn flat(corners: [[f64; 3]; 3], colour: Rgb) -> Triangle {
        Triangle { corners, paint: Paint::solid(colour), lines: [Stroke::NONE; 3] }
    }

    /// Two triangles that are a rectangle.
    fn rectangle([left, top]: [f64; 2], [right, bottom]: [f64; 2], z: f64, colour: Rgb) -> [Triangle; 2] {
        let [a, b, c, d] = [[left, top, z], [right, top, z], [right, bottom, z], [left, bottom, z]];
        [flat([a, b, c], colour), flat([a, c, d], colour)]
    }

    fn at(pixels: &[u8], width: usize, [column, row]: [usize; 2]) -> Rgb {
        let place = 3 * (row * width + column);
        [pixels[place], pixels[place + 1], pixels[place + 2]]
    }

    #[test]
    fn samples_are_in_all_columns_rows_and_squares() {
        for places in PLACES {
            let mut found = places.map(|x| x as usize / 16);
            found.sort_unstable();
            assert!(found.iter().enumerate().all(|(k, &x)| k == x), "{found:?}");
        }
        let mut squares: Vec<_> =
            (0..SAMPLES).map(|k| [PLACES[0][k] as usize / 64, PLACES[1][k] as usize / 64]).collect();
        squares.sort_unstable();
        squares.dedup();
        assert_eq!(squares.len(), SAMPLES);
    }

    #[test]
    fn a_rectangle_fills_its_pixels_and_its_share_of_those_at_its_edge() {
        let pixels = draw([20, 40], &[rectangle([3.0, 5.0], [12.5, 30.25], 0.0, RED).to_vec()]);
        for row in 0..40 {
            for column in 0..20 {
                let across = [0.0, 1.0, 0.5][usize::from(column >= 3) * (1 + usize::from(column == 12))];
                let across = if column > 12 { 0.0 } else { across };
                let down = if (5..30).contains(&row) { 1.0 } else { 0.25 * f64::from(u8::from(row == 30)) };
                let expected = 255.0 - 255.0 * across * down;
                let found = f64::from(at(&pixels, 20, [column, row])[1]);
                // The corner pixel has 16 samples for an eighth of its area.
                assert!((found - expected).abs() <= 16.0, "{column} {row}: {found} {expected}");
                if across * down == 1.0 {
                    assert_eq!(at(&pixels, 20, [column, row]), RED);
                }
            }
        }
    }

    /// Triangles around a point, with corners anywhere: each sample belongs to exactly one.
    #[test]
    fn neighbours_leave_no_gap_and_do_not_overlap() {
        let rim = [[-3.3, 4.1], [20.2, -7.7], [61.9, 3.0], [50.0, 55.5], [31.0, 31.0], [7.0, 66.0]];
        let middle = [30.17, 28.93];
        let mut covered = vec![0_u32; 64 * 64 * SAMPLES];
        for k in 0..rim.len() {
            let corners = [middle, rim[k], rim[(k + 1) % rim.len()]].map(|[x, y]| [x, y, 0.0]);
            let mut band = Band::new(64 * 64 / BAND);
            band.width = 64;
            Setup::new(&flat(corners, RED)).unwrap().draw(&mut band, [0, 64], [0, 64]);
            for (count, colour) in covered.iter_mut().zip(band.colours.as_flattened()) {
                *count += u32::from(*colour != NOTHING);
            }
        }
        assert!(covered.iter().all(|&count| count <= 1), "no sample has two owners");
        let inside = |column: usize, row: usize| (10..30).contains(&column) && (10..30).contains(&row);
        let all = (0..64 * 64).filter(|k| inside(k % 64, k / 64));
        assert!(all.flat_map(|k| &covered[k * SAMPLES..(k + 1) * SAMPLES]).all(|&count| count == 1));
    }

    #[test]
    fn the_nearer_triangle_is_seen_wherever_it_comes_in_the_list() {
        let behind = rectangle([2.0, 2.0], [30.0, 30.0], 1.0, RED);
        let before = rectangle([10.0, 10.0], [20.0, 20.0], 5.0, GREEN);
        let list = [behind, before].concat();
        let pixels = draw([32, 32], std::slice::from_ref(&list));
        assert_eq!([[5, 5], [15, 15], [1, 1]].map(|place| at(&pixels, 32, place)), [RED, GREEN, [255; 3]]);
        let reversed: Vec<Triangle> = list.into_iter().rev().collect();
        assert_eq!(draw([32, 32], &[reversed]), pixels);
    }

    /// Two planes that cross: the line between them is where they have one depth.
    #[test]
    fn planes_cross_where_their_depths_are_equal() {
        let sloping = [[0.0, 0.0, 0.0], [40.0, 0.0, 40.0], [40.0, 40.0, 40.0], [0.0, 40.0, 0.0]];
        let mut list = rectangle([0.0, 0.0], [40.0, 40.0], 10.0, RED).to_vec();
        list.push(flat([sloping[0], sloping[1], sloping[2]], GREEN));
        list.push(flat([sloping[0], sloping[2], sloping[3]], GREEN));
        let pixels = draw([40, 40], &[list]);
        for row in 0..40 {
            assert_eq!([9, 10].map(|column| at(&pixels, 40, [column, row])), [RED, GREEN], "{row}");
        }
    }

    #[test]
    fn equal_depths_do_not_depend_on_the_order() {
        let mut list = rectangle([1.0, 1.0], [9.0, 9.0], 3.0, RED).to_vec();
        list.extend(rectangle([3.0, 3.0], [12.0, 12.0], 3.0, GREEN));
        let pixels = draw([16, 16], std::slice::from_ref(&list));
        assert_eq!(at(&pixels, 16, [5, 5]), GREEN, "the smaller number");
        list.reverse();
        assert_eq!(draw([16, 16], &[list]), pixels);
    }

    #[test]
    fn lines_lie_inside_their_edges() {
        let [mut one, two] = rectangle([4.0, 4.0], [28.0, 28.0], 0.0, RED);
        one.lines[0] = Stroke { width: 2.0, paint: Paint::solid([0; 3]) };
        for corners in [one.corners, [one.corners[0], one.corners[2], one.corners[1]]] {
            let mut line = Triangle { corners, ..one };
            if corners != one.corners {
                line.lines.reverse();
            }
            let pixels = draw([32, 32], &[vec![line, two]]);
            assert_eq!(
                [[20, 3], [20, 4], [20, 5], [20, 6], [5, 20]].map(|place| at(&pixels, 32, place)),
                [[255; 3], [0; 3], [0; 3], RED, RED]
            );
        }
    }

    #[test]
    fn a_second_layer_is_seen_through_where_it_is_nearer() {
        let below = rectangle([0.0, 0.0], [16.0, 16.0], 5.0, [0; 3]).to_vec();
        let glass = |z| {
            let mut list = rectangle([8.0, 0.0], [24.0, 16.0], z, [255; 3]).to_vec();
            for triangle in &mut list {
                triangle.paint.cover = 51;
            }
            list
        };
        let found = |z| {
            let pixels = draw([32, 16], &[below.clone(), glass(z)]);
            [4, 12, 20].map(|column| at(&pixels, 32, [column, 8])[0])
        };
        assert_eq!(found(9.0), [0, 51, 255]);
        assert_eq!(found(1.0), [0, 0, 255]);
    }

    #[test]
    fn what_is_nowhere_or_far_away_is_not_drawn() {
        let corners = [
            [[1.0; 3]; 3],
            [[1.0, 1.0, 0.0], [5.0, 5.0, 0.0], [9.0, 9.0, 0.0]],
            [[f64::NAN, 0.0, 0.0], [9.0, 0.0, 0.0], [9.0, 9.0, 0.0]],
            [[0.0, 0.0, 0.0], [9.0, 0.0, f64::INFINITY], [9.0, 9.0, 0.0]],
            [[-9.0, -9.0, 0.0], [-1.0, -9.0, 0.0], [-1.0, -1.0, 0.0]],
            [[1e300, 0.0, 0.0], [1e300, 1e300, 0.0], [2e300, 1e300, 0.0]],
            [[-1e300, 0.0, 0.0], [1e300, 1e300, 0.0], [2e300, -1e300, 0.0]],
        ];
        let list: Vec<Triangle> = corners.into_iter().map(|corners| flat(corners, RED)).collect();
        assert!(draw([12, 12], &[list]).iter().all(|&byte| byte == 255));
        assert!(draw([12, 12], &[]).iter().all(|&byte| byte == 255));
        assert!(draw([0, 0], &[Vec::new()]).is_empty());
        for far in [9e4, 9e7, 9e11, 9e100] {
            let larger = flat([[-far, -far, 0.0], [far, -far, 0.0], [0.0, far, 0.0]], RED);
            assert!(draw([12, 12], &[vec![larger]]).chunks(3).all(|pixel| pixel == RED), "{far}");
        }
    }
}
