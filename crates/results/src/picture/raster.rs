//! Triangles, spheres and rods drawn into pixels, the nearer ones over those behind, without a graphics card.
//! The pixels are the same on every machine.
//!
//! A [`Raster`] has the depth and the colour of each sample of its pixels. Spheres and rods are drawn one by
//! one into the raster of a whole picture, with a grid of four samples in each pixel, which [`Raster::shade`]
//! darkens in hollows. Meshes have more edges than these: [`draw`] has 16 samples and draws bands of a few
//! rows, so that they fit into a cache.
//!
//! Of the triangles at a sample the one nearest to the eye is kept; at equal depths that with the smaller
//! number of a colour, so that their order does not matter.

mod beads;
mod buffer;
mod shade;
mod solids;
mod triangle;

use beads::BeadSweep;
use buffer::{SPREAD, append};
use triangle::{Setup, box_of, nearest};

pub(crate) use beads::{Bead, Beads, Rod};
pub(crate) use buffer::{GRID, Paint, Raster};
pub(crate) use triangle::{Stroke, Triangle};

/// Rows of a band, pixels.
const BAND: usize = 16;

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
pub(crate) fn draw(size: [usize; 2], layers: &[Vec<Triangle>]) -> Vec<u8> {
    draw_with(size, layers, &Beads::default())
}

/// Draws layers of triangles as [`draw`], with spheres and rods among the triangles of the first layer, of
/// which there must be one if there are any.
pub(crate) fn draw_with([width, height]: [usize; 2], layers: &[Vec<Triangle>], beads: &Beads) -> Vec<u8> {
    let mut beads = BeadSweep::new(beads, [width, height]);
    let mut pixels = Vec::with_capacity(3 * width * height);
    let mut sweeps: Vec<Sweep<'_>> =
        layers.iter().map(|triangles| Sweep::new(triangles, [width, height])).collect();
    let mut bands: Vec<Raster<16>> = layers.iter().map(|_| Raster::new(&SPREAD, [width, BAND])).collect();
    for top in (0..height).step_by(BAND) {
        let rows = BAND.min(height - top);
        for (sweep, band) in sweeps.iter_mut().zip(&mut bands) {
            band.clear(top);
            sweep.draw(band, rows);
        }
        if let Some(first) = bands.first_mut() {
            beads.draw(first, rows);
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

    /// Draws the triangles in the first `rows` rows of a band.
    fn draw(&mut self, band: &mut Raster<16>, rows: usize) {
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
            if let Some(setup) = Setup::new(triangle, &SPREAD) {
                let first = around[1][0].max(band.top);
                setup.draw(band, around[0], [first, around[1][1].min(end)]);
            }
            around[1][1] > end
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::colour::Rgb;

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
        for places in SPREAD {
            let mut found = places.map(|x| x as usize / 16);
            found.sort_unstable();
            assert!(found.iter().enumerate().all(|(k, &x)| k == x), "{found:?}");
        }
        let mut squares: Vec<_> =
            (0..16).map(|k| [SPREAD[0][k] as usize / 64, SPREAD[1][k] as usize / 64]).collect();
        squares.sort_unstable();
        squares.dedup();
        assert_eq!(squares.len(), 16);
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
        let mut covered = vec![0_u32; 64 * 64 * 16];
        for k in 0..rim.len() {
            let corners = [middle, rim[k], rim[(k + 1) % rim.len()]].map(|[x, y]| [x, y, 0.0]);
            let mut band = Raster::new(&SPREAD, [64, 64]);
            band.triangle(&flat(corners, RED));
            for (count, colour) in covered.iter_mut().zip(band.colours.as_flattened()) {
                *count += u32::from(*colour != buffer::NOTHING);
            }
        }
        assert!(covered.iter().all(|&count| count <= 1), "no sample has two owners");
        let inside = |column: usize, row: usize| (10..30).contains(&column) && (10..30).contains(&row);
        let all = (0..64 * 64).filter(|k| inside(k % 64, k / 64));
        assert!(all.flat_map(|k| &covered[k * 16..(k + 1) * 16]).all(|&count| count == 1));
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
