//! Coarser meshes, drawn in place of meshes that have too many elements for a page.
//!
//! A grid is laid over the frame, and all corners of a body that lie in one cell move to one of these
//! corners. An element stays if its corners move to three different places; it is drawn as the triangle
//! between these. The other elements have become lines or points and are left out. The triangles that stay
//! cover the area of the mesh, up to the width of a cell. If no part of a body would stay in a cell, one of
//! its elements stays unchanged, so that fragments smaller than a cell are visible, too.

/// Bits of a key for the place of the cell on each axis. The other bits are for the body.
const AXIS: u32 = 20;

/// Number of attempts that keep bodies apart. Further attempts do not, because bodies cannot be kept apart if
/// there are more of them than triangles.
const APART: u32 = 4;

/// A part of the elements of a mesh, drawn in place of the mesh.
pub(super) struct Sample {
    /// Numbers of the elements that stay, ascending.
    pub(super) elements: Vec<u32>,
    /// Corners of these elements, after they have moved.
    pub(super) corners: Vec<[[f64; 2]; 3]>,
    grid: Grid,
}

#[derive(Clone, Copy)]
struct Grid {
    low: [f64; 2],
    high: [f64; 2],
    side: f64,
}

impl Grid {
    /// Returns the cell of a point; `None` outside of the frame.
    fn cell(&self, point: [f64; 2]) -> Option<u64> {
        let inside = |axis: usize| (self.low[axis]..=self.high[axis]).contains(&point[axis]);
        let place = |axis: usize| ((point[axis] - self.low[axis]) / self.side) as u64;
        (inside(0) && inside(1)).then(|| place(0) << AXIS | place(1))
    }
}

impl Sample {
    /// Makes a sample of at most `most` elements; 0 means 1.
    ///
    /// # Shapes
    /// `corners` and `bodies`: one entry for each element. `bounds`: the least and the greatest coordinate
    /// that is drawn, on each axis.
    pub(super) fn new(corners: &[[[f64; 2]; 3]], bodies: &[u32], bounds: [[f64; 2]; 2], most: usize) -> Self {
        let most = most.max(1);
        let extent = bounds.map(|[low, high]| high - low).into_iter().fold(f64::MIN_POSITIVE, f64::max);
        let [low, high] = [0, 1].map(|end| [bounds[0][end], bounds[1][end]]);
        let within = |point: &[f64; 2]| (0..2).all(|axis| (low[axis]..=high[axis]).contains(&point[axis]));
        let area: f64 = corners.iter().filter(|corners| corners.iter().all(within)).map(area).sum();
        // A cell has about two triangles.
        let mut side = (2.0 * area / most as f64).sqrt();
        let mut attempt = 0;
        loop {
            // The place of the last cell on an axis must fit into 20 bits.
            side = side.max(extent / f64::from((1 << AXIS) - 2));
            let grid = Grid { low, high, side };
            let sample = Self::on(grid, corners, bodies, attempt < APART);
            let found = sample.elements.len();
            if found <= most {
                return sample;
            }
            side *= (found as f64 / most as f64).sqrt().max(1.05);
            attempt += 1;
        }
    }

    /// Makes the sample of a grid. `apart`: whether bodies are kept apart.
    fn on(grid: Grid, corners: &[[[f64; 2]; 3]], bodies: &[u32], apart: bool) -> Self {
        // Keys and numbers of the corners, sorted by key. Corner k of element e has the number 3 e + k.
        let mut keys: Vec<(u64, u32)> = Vec::with_capacity(3 * corners.len());
        for (element, (points, &body)) in (0..).zip(corners.iter().zip(bodies)) {
            let [Some(a), Some(b), Some(c)] = points.map(|point| grid.cell(point)) else { continue };
            let body = if apart { u64::from(body) << (2 * AXIS) } else { 0 };
            keys.extend([a, b, c].into_iter().zip(3 * element..).map(|(cell, corner)| (body | cell, corner)));
        }
        keys.sort_unstable();
        // The first corner of the group of every corner; NOWHERE for elements that are not drawn.
        let mut first = vec![NOWHERE; 3 * corners.len()];
        for group in keys.chunk_by(|(one, _), (other, _)| one == other) {
            for &(_, corner) in group {
                first[corner as usize] = group[0].1;
            }
        }
        drop(keys);
        let of_element = |element: usize| [0, 1, 2].map(|corner| first[3 * element + corner]);
        let drawn = |[a, ..]: &[u32; 3]| *a != NOWHERE;

        // Several elements may have become the same triangle. The first of them stays.
        let mut triangles: Vec<([u32; 3], u32)> = (0..corners.len())
            .map(|element| (of_element(element), element as u32))
            .filter(|([a, b, c], _)| a != b && b != c && c != a)
            .map(|(mut triangle, element)| {
                triangle.sort_unstable();
                (triangle, element)
            })
            .collect();
        triangles.sort_unstable();
        triangles.dedup_by_key(|(triangle, _)| *triangle);
        let mut shown = vec![false; 3 * corners.len()];
        let place = |corner: u32| corners[corner as usize / 3][corner as usize % 3];
        let mut kept: Vec<(u32, [[f64; 2]; 3])> = Vec::with_capacity(triangles.len());
        for (triangle, element) in triangles {
            for corner in triangle {
                shown[corner as usize] = true;
            }
            kept.push((element, of_element(element as usize).map(place)));
        }
        for (element, points) in corners.iter().enumerate() {
            let group = of_element(element);
            if drawn(&group) && group.iter().all(|&corner| !shown[corner as usize]) {
                for corner in group {
                    shown[corner as usize] = true;
                }
                kept.push((element as u32, *points));
            }
        }
        kept.sort_unstable_by_key(|(element, _)| *element);
        let (elements, corners) = kept.into_iter().unzip();
        Self { elements, corners, grid }
    }

    /// Removes cracks that could not be distinguished: only the first crack of each mode in each cell stays.
    /// `ends` and `mode` are those of a crack.
    pub(super) fn cracks<T>(
        &self,
        cracks: &mut Vec<T>,
        ends: impl Fn(&T) -> [[f64; 2]; 2],
        mode: impl Fn(&T) -> u16,
    ) {
        let mut keys: Vec<((u64, u16), usize)> = Vec::with_capacity(cracks.len());
        for (number, crack) in cracks.iter().enumerate() {
            let [a, b] = ends(crack);
            let middle = [0, 1].map(|axis| f64::midpoint(a[axis], b[axis]));
            if let Some(cell) = self.grid.cell(middle) {
                keys.push(((cell, mode(crack)), number));
            }
        }
        keys.sort_unstable();
        keys.dedup_by_key(|(key, _)| *key);
        let mut stays = vec![false; cracks.len()];
        for (_, number) in keys {
            stays[number] = true;
        }
        let mut number = 0;
        cracks.retain(|_| {
            number += 1;
            stays[number - 1]
        });
    }
}

/// Stands for no group.
const NOWHERE: u32 = u32::MAX;

fn area([a, b, c]: &[[f64; 2]; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 2 n² triangles at `low`.
    fn square(n: u32, low: [f64; 2], side: f64) -> Vec<[[f64; 2]; 3]> {
        let at = |i: u32, j: u32| [i, j].map(|k| f64::from(k) / f64::from(n) * side);
        let mut triangles = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
                    .map(|[x, y]| [low[0] + x, low[1] + y]);
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        triangles
    }

    #[test]
    fn a_sample_covers_what_the_mesh_covers() {
        let corners = square(60, [3.0, -2.0], 1.0);
        let bodies = vec![0; corners.len()];
        let sample = Sample::new(&corners, &bodies, [[3.0, 4.0], [-2.0, -1.0]], 900);
        assert!((300..=900).contains(&sample.elements.len()), "{}", sample.elements.len());
        assert!(sample.elements.is_sorted());
        let covered: f64 = sample.corners.iter().map(area).sum();
        assert!((0.85..1.1).contains(&covered), "{covered}");
        // There is no hole: all points away from the outline are in a triangle.
        for i in 0..40 {
            for j in 0..40 {
                let point = [3.1 + 0.8 * f64::from(i) / 39.0, -1.9 + 0.8 * f64::from(j) / 39.0];
                assert!(sample.corners.iter().any(|triangle| contains(triangle, point)), "{point:?}");
            }
        }
    }

    #[test]
    fn bodies_stay_apart_and_small_ones_are_seen() {
        let mut corners = square(30, [0.0, 0.0], 1.0);
        let mut bodies = vec![0; corners.len()];
        // A body of two triangles inside one cell, and one far outside of the frame.
        corners.extend(square(1, [1.53, 1.53], 1e-4));
        bodies.extend([1, 1]);
        corners.extend(square(1, [50.0, 50.0], 1e-4));
        bodies.extend([2, 2]);
        let sample = Sample::new(&corners, &bodies, [[0.0, 1.6], [0.0, 1.6]], 200);
        assert!(sample.elements.len() <= 200);
        let shown =
            |body: u32| sample.elements.iter().filter(|&&element| bodies[element as usize] == body).count();
        assert_eq!([shown(1), shown(2)], [1, 0]);
        // Two bodies in the same place share no corner: each has its triangles.
        let both = [corners.clone(), corners].concat();
        let twice: Vec<u32> = bodies.iter().copied().chain(bodies.iter().map(|body| body + 3)).collect();
        let sample = Sample::new(&both, &twice, [[0.0, 1.6], [0.0, 1.6]], 400);
        let of_second = sample.elements.iter().filter(|&&element| twice[element as usize] >= 3).count();
        assert!(2 * of_second >= sample.elements.len() - 2, "{of_second} of {}", sample.elements.len());
    }

    #[test]
    fn more_bodies_than_triangles_are_no_trouble_nor_is_nothing() {
        let corners: Vec<_> = (0..500).flat_map(|k| square(1, [f64::from(k), 0.0], 0.5)).collect();
        let bodies: Vec<u32> = (0..1000).collect();
        for most in [1, 7, 100] {
            let found = Sample::new(&corners, &bodies, [[0.0, 500.0], [0.0, 0.5]], most).elements.len();
            assert!((1..=most).contains(&found), "{found}");
        }
        assert_eq!(Sample::new(&[], &[], [[0.0; 2]; 2], 10).elements.len(), 0);
        let nowhere = [[[f64::NAN; 2]; 3]; 20];
        assert_eq!(Sample::new(&nowhere, &[0; 20], [[0.0; 2]; 2], 10).elements.len(), 0);
        let one_place = [[[2.0, 3.0]; 3]; 20];
        assert_eq!(Sample::new(&one_place, &[0; 20], [[2.0; 2], [3.0; 2]], 10).elements.len(), 1);
    }

    #[test]
    fn one_crack_of_each_mode_stays_in_a_cell() {
        let corners = square(30, [0.0, 0.0], 1.0);
        let sample = Sample::new(&corners, &vec![0; corners.len()], [[0.0, 1.0]; 2], 100);
        let mut cracks: Vec<(f64, u16)> =
            (0..3000).map(|k| (f64::from(k) / 3000.0, (k % 3) as u16)).collect();
        sample.cracks(&mut cracks, |&(x, _)| [[x, 0.5], [x + 1e-5, 0.5]], |&(_, mode)| mode);
        assert!((3..=60).contains(&cracks.len()), "{}", cracks.len());
        assert!((0..3).all(|mode| cracks.iter().any(|crack| crack.1 == mode)));
    }

    fn contains([a, b, c]: &[[f64; 2]; 3], [x, y]: [f64; 2]) -> bool {
        let side = |p: &[f64; 2], q: &[f64; 2]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
        let sides = [side(a, b), side(b, c), side(c, a)];
        sides.iter().all(|&side| side >= -1e-12) || sides.iter().all(|&side| side <= 1e-12)
    }
}
