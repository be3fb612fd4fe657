//! Meshes of triangles in a plane, or on a plane that repeats along x (an unrolled cylinder).
//!
//! Starting from any triangles of a polygon, edges are flipped until all are Delaunay's; then points are
//! inserted in circles that are too large, and moved to where triangles are even. Edges of the border stay.
//!
//! # Sources
//! C. L. Lawson, "Software for C1 surface interpolation", Mathematical Software III (1977), for the flips; J.
//! Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", J. Algorithms 18
//! (1995); L. Chen, J. Xu, "Optimal Delaunay triangulations", J. Comput. Math. 22 (2004), for the moves.

use std::collections::VecDeque;

use fdem_scenes::random::Random;

use super::delaunay::NONE;

/// A point in the plane.
pub(crate) type Point2 = [f64; 2];

/// A circle is too large if its radius is above this times the size; chosen such that the mean edge is the
/// size.
const COARSE: f64 = 0.72;

/// Largest distance of a new point from the centre of its circle, over the radius: centres of regular
/// patterns would lie in patterns themselves.
const JITTER: f64 = 0.2;

/// Rounds of moves.
const ROUNDS: usize = 6;

/// Triangles in a plane.
pub(crate) struct Plane {
    pub(crate) points: Vec<Point2>,
    /// Counter-clockwise.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Beyond the edge opposite each corner: three times the neighbour, plus the place of its opposite
    /// corner.
    across: Vec<[u32; 3]>,
    /// Length after which the plane repeats along x, or 0.
    period: f64,
}

#[inline]
fn minus(a: Point2, b: Point2) -> Point2 {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline]
fn cross(a: Point2, b: Point2) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[inline]
fn dot(a: Point2, b: Point2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Centre of the circle through the origin, `u` and `v`.
fn centre(u: Point2, v: Point2) -> Point2 {
    let (uu, vv, double) = (dot(u, u), dot(v, v), 2.0 * cross(u, v));
    [(v[1] * uu - u[1] * vv) / double, (u[0] * vv - v[0] * uu) / double]
}

impl Plane {
    /// Triangles that meet in edges, each of which has at most two.
    pub(crate) fn new(points: Vec<Point2>, triangles: Vec<[u32; 3]>, period: f64) -> Self {
        Self::with_walls(points, triangles, period, &[])
    }

    /// The same with edges inside that stay as those of the border do: pairs of ends in ascending order,
    /// sorted.
    pub(crate) fn with_walls(
        points: Vec<Point2>,
        triangles: Vec<[u32; 3]>,
        period: f64,
        walls: &[[u32; 2]],
    ) -> Self {
        let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
        for (t, triangle) in triangles.iter().enumerate() {
            for place in 0..3 {
                let (a, b) = (triangle[(place + 1) % 3], triangle[(place + 2) % 3]);
                edges.push(([a.min(b), a.max(b)], (3 * t + place) as u32));
            }
        }
        edges.sort_unstable();
        let mut across = vec![[NONE; 3]; triangles.len()];
        for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            if walls.binary_search(&pair[0].0).is_ok() {
                continue;
            }
            let [one, other] = [pair[0].1, pair[1].1];
            across[(one / 3) as usize][(one % 3) as usize] = other;
            across[(other / 3) as usize][(other % 3) as usize] = one;
        }
        Self { points, triangles, across, period }
    }

    /// From `base` to a point, the short way round.
    #[inline]
    fn from(&self, base: Point2, point: Point2) -> Point2 {
        let mut difference = minus(point, base);
        if self.period > 0.0 {
            difference[0] -= self.period * (difference[0] / self.period).round();
        }
        difference
    }

    /// The second and the third corner of a triangle, seen from the first.
    fn sides(&self, t: usize) -> [Point2; 2] {
        let [a, b, c] = self.triangles[t].map(|corner| self.points[corner as usize]);
        [self.from(a, b), self.from(a, c)]
    }

    /// Fills the inside with points such that edges are about as long as `size` says, and triangles are even.
    ///
    /// The first `fixed` points stay. In a periodic plane, no triangle may be wider than half of the period,
    /// nor its circle.
    pub(crate) fn fill(&mut self, fixed: usize, size: &dyn Fn(Point2) -> f64, random: &mut Random) {
        self.make_delaunay();
        self.refine(size, random);
        for _ in 0..ROUNDS {
            self.smooth(fixed, size);
            self.make_delaunay();
        }
    }

    /// Flips edges until each triangle's circle has no corner of a neighbour inside.
    pub(crate) fn make_delaunay(&mut self) {
        let mut open: Vec<[u32; 2]> =
            (0..self.triangles.len() as u32).flat_map(|t| [[t, 0], [t, 1], [t, 2]]).collect();
        self.flip_all(&mut open);
    }

    fn flip_all(&mut self, open: &mut Vec<[u32; 2]>) {
        // Ties are left as they are, so the flips end; the limit is for rounding that goes in circles. The
        // fans of a long strip take n²/8.
        let mut left = self.triangles.len().saturating_pow(2).saturating_add(1000);
        while let Some([t, place]) = open.pop() {
            if left == 0 {
                return;
            }
            if self.should_flip(t as usize, place as usize) {
                left -= 1;
                let u = self.flip(t as usize, place as usize) as u32;
                open.extend([[t, 0], [t, 2], [u, 0], [u, 1]]);
            }
        }
    }

    /// Whether the angles opposite an edge sum up to more than half a turn.
    fn should_flip(&self, t: usize, place: usize) -> bool {
        let other = self.across[t][place];
        if other == NONE {
            return false;
        }
        let d = self.points[self.triangles[(other / 3) as usize][(other % 3) as usize] as usize];
        let corner = |k: usize| self.points[self.triangles[t][(place + k) % 3] as usize];
        let (c, a, b) = (corner(0), corner(1), corner(2));
        let (ca, cb) = (self.from(c, a), self.from(c, b));
        let (da, db) = (self.from(d, a), self.from(d, b));
        let (one, two) = (dot(ca, cb) * cross(db, da), cross(ca, cb) * dot(da, db));
        let scale = (dot(ca, ca) * dot(cb, cb) * dot(da, da) * dot(db, db)).sqrt();
        one + two < -1e-12 * scale
    }

    /// Replaces an edge by the other diagonal; returns the other triangle. The new edge is opposite corner 1
    /// here and corner 2 there.
    fn flip(&mut self, t: usize, e: usize) -> usize {
        let other = self.across[t][e];
        let (u, f) = ((other / 3) as usize, (other % 3) as usize);
        let [c, a, b] = [0, 1, 2].map(|k| self.triangles[t][(e + k) % 3]);
        let d = self.triangles[u][f];
        let [ca, bc] = [self.across[t][(e + 2) % 3], self.across[t][(e + 1) % 3]];
        let [ad, db] = [self.across[u][(f + 1) % 3], self.across[u][(f + 2) % 3]];
        self.triangles[t] = [c, a, d];
        self.triangles[u] = [c, d, b];
        self.across[t] = [ad, (3 * u + 2) as u32, ca];
        self.across[u] = [db, bc, (3 * t + 1) as u32];
        for (code, back) in [(ad, 3 * t), (ca, 3 * t + 2), (db, 3 * u), (bc, 3 * u + 1)] {
            self.set_across(code, back as u32);
        }
        u
    }

    fn set_across(&mut self, code: u32, to: u32) {
        if code != NONE {
            self.across[(code / 3) as usize][(code % 3) as usize] = to;
        }
    }

    /// Inserts points into circles that are too large, first found first.
    fn refine(&mut self, size: &dyn Fn(Point2) -> f64, random: &mut Random) {
        let mut open: VecDeque<u32> = (0..self.triangles.len() as u32).collect();
        let mut flips = Vec::new();
        while let Some(t) = open.pop_front() {
            let [u, v] = self.sides(t as usize);
            let centre = centre(u, v);
            let square = dot(centre, centre);
            let base = self.points[self.triangles[t as usize][0] as usize];
            let middle = [base[0] + centre[0], base[1] + centre[1]];
            let largest = COARSE * size(middle);
            // A flat triangle has no centre.
            if cross(u, v) <= 0.0 || !square.is_finite() || square <= largest * largest {
                continue;
            }
            let reach = JITTER * square.sqrt();
            let point = loop {
                let [x, y] = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
                if x * x + y * y <= 1.0 {
                    break [middle[0] + reach * x, middle[1] + reach * y];
                }
            };
            let Some(place) =
                self.locate(t as usize, point).filter(|&place| !self.is_at_border(place, point))
            else {
                continue;
            };
            let vertex = self.points.len() as u32;
            self.points.push(point);
            self.insert(place, vertex, &mut flips);
            self.flip_all(&mut flips);
            let mut at = place;
            // All triangles around the new point: it is inside, so the way round is closed.
            loop {
                open.push_back(at as u32);
                let Some(k) = self.triangles[at].iter().position(|&corner| corner == vertex) else { break };
                let next = self.across[at][(k + 1) % 3];
                if next == NONE || (next / 3) as usize == place {
                    break;
                }
                at = (next / 3) as usize;
            }
        }
    }

    /// The triangle with a point in it; `None` if the way to it crosses the border.
    fn locate(&self, from: usize, point: Point2) -> Option<usize> {
        let mut t = from;
        for _ in 0..10_000 {
            let beyond = (0..3).find(|&place| {
                let a = self.points[self.triangles[t][(place + 1) % 3] as usize];
                let b = self.points[self.triangles[t][(place + 2) % 3] as usize];
                cross(self.from(a, b), self.from(a, point)) < 0.0
            });
            let Some(place) = beyond else { return Some(t) };
            if self.across[t][place] == NONE {
                return None;
            }
            t = (self.across[t][place] / 3) as usize;
        }
        None
    }

    /// Whether a point in a triangle is in the circle over an edge of the border near it.
    fn is_at_border(&self, t: usize, point: Point2) -> bool {
        let mut near = vec![t];
        for next in 0..10 {
            let Some(&t) = near.get(next) else { break };
            for place in 0..3 {
                let beyond = self.across[t][place];
                if beyond != NONE {
                    if !near.contains(&((beyond / 3) as usize)) {
                        near.push((beyond / 3) as usize);
                    }
                    continue;
                }
                let a = self.points[self.triangles[t][(place + 1) % 3] as usize];
                let b = self.points[self.triangles[t][(place + 2) % 3] as usize];
                if dot(self.from(point, a), self.from(point, b)) < 0.0 {
                    return true;
                }
            }
        }
        false
    }

    /// Splits a triangle into three; `flips` gets the edges that may have to be flipped.
    fn insert(&mut self, t: usize, vertex: u32, flips: &mut Vec<[u32; 2]>) {
        let [a, b, c] = self.triangles[t];
        let [bc, ca, ab] = self.across[t];
        let u = self.triangles.len();
        let v = u + 1;
        self.triangles[t] = [vertex, b, c];
        self.triangles.push([a, vertex, c]);
        self.triangles.push([a, b, vertex]);
        let code = |t: usize, place: usize| (3 * t + place) as u32;
        self.across[t] = [bc, code(u, 0), code(v, 0)];
        self.across.push([code(t, 1), ca, code(v, 1)]);
        self.across.push([code(t, 2), code(u, 2), ab]);
        self.set_across(bc, code(t, 0));
        self.set_across(ca, code(u, 1));
        self.set_across(ab, code(v, 2));
        flips.extend([[t as u32, 0], [u as u32, 1], [v as u32, 2]]);
    }

    /// Moves each point from `fixed` on to the mean of the centres of the circles around it, weighted by area
    /// over the square of the size there.
    fn smooth(&mut self, fixed: usize, size: &dyn Fn(Point2) -> f64) {
        let mut at = vec![NONE; self.points.len()];
        for (t, triangle) in (0..).zip(&self.triangles) {
            for &corner in triangle {
                at[corner as usize] = t;
            }
        }
        let mut star: Vec<[Point2; 2]> = Vec::new();
        for (vertex, &first) in at.iter().enumerate().skip(fixed) {
            let here = self.points[vertex];
            star.clear();
            let mut t = first as usize;
            while let Some(k) = self.triangles[t].iter().position(|&corner| corner as usize == vertex) {
                let [a, b] = [1, 2].map(|other| self.points[self.triangles[t][(k + other) % 3] as usize]);
                star.push([self.from(here, a), self.from(here, b)]);
                let next = self.across[t][(k + 1) % 3];
                if next == NONE || next / 3 == first {
                    break;
                }
                t = (next / 3) as usize;
            }
            let mut sum = [0.0; 3];
            for &[u, v] in &star {
                let third = [here[0] + (u[0] + v[0]) / 3.0, here[1] + (u[1] + v[1]) / 3.0];
                let weight = cross(u, v) / (size(third) * size(third));
                let centre = centre(u, v);
                sum = [sum[0] + weight * centre[0], sum[1] + weight * centre[1], sum[2] + weight];
            }
            let shift = [sum[0] / sum[2], sum[1] / sum[2]];
            let is_good = |shift: Point2| {
                star.iter().all(|&[u, v]| cross(minus(u, shift), minus(v, shift)) > 0.1 * cross(u, v))
            };
            let tried = [1.0, 0.5, 0.25].map(|part| [part * shift[0], part * shift[1]]);
            if let Some(shift) = tried.into_iter().find(|&shift| is_good(shift)) {
                self.points[vertex] = [here[0] + shift[0], here[1] + shift[1]];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edge lengths and the smallest angle, degrees.
    fn edges(plane: &Plane) -> (f64, f64) {
        let (mut sum, mut least) = (0.0, 180.0_f64);
        for t in 0..plane.triangles.len() {
            let [u, v] = plane.sides(t);
            let w = minus(v, u);
            sum += dot(u, u).sqrt() + dot(v, v).sqrt() + dot(w, w).sqrt();
            for (one, other) in [(u, v), (w, [-u[0], -u[1]]), ([-v[0], -v[1]], [-w[0], -w[1]])] {
                assert!(cross(one, other) > 0.0);
                least = least.min(cross(one, other).atan2(dot(one, other)).to_degrees());
            }
        }
        (sum / (3 * plane.triangles.len()) as f64, least)
    }

    #[test]
    fn a_square_has_even_triangles() {
        for seed in 0..10 {
            let n = 20;
            let side = |k: usize| k as f64 / n as f64;
            let mut points: Vec<Point2> = (0..n).map(|k| [side(k), 0.0]).collect();
            points.extend((0..n).map(|k| [1.0, side(k)]));
            points.extend((0..n).map(|k| [1.0 - side(k), 1.0]));
            points.extend((0..n).map(|k| [0.0, 1.0 - side(k)]));
            points.push([0.4, 0.6]);
            let all = 4 * n as u32;
            let triangles = (0..all).map(|k| [k, (k + 1) % all, all]).collect();
            let mut plane = Plane::new(points, triangles, 0.0);
            plane.fill(81, &|_| 0.05, &mut Random::new(seed));
            let (mean, least) = edges(&plane);
            assert!((mean / 0.05 - 1.0).abs() < 0.1 && least > 25.0, "{mean} {least}");
        }
    }

    #[test]
    fn a_strip_repeats() {
        let n = 20_u32;
        let ring = |row: u32| (0..n).map(move |k| [f64::from(k) / 20.0, f64::from(row) * 0.14]);
        let points: Vec<Point2> = [0, 5, 1, 2, 3, 4].into_iter().flat_map(ring).collect();
        let triangles = [[0, 2], [2, 3], [3, 4], [4, 5], [5, 1]].into_iter().flat_map(|[low, high]| {
            (0..n).flat_map(move |k| {
                let next = (k + 1) % n;
                [[low * n + k, low * n + next, high * n + k], [low * n + next, high * n + next, high * n + k]]
            })
        });
        let mut plane = Plane::new(points, triangles.collect(), 1.0);
        plane.fill(40, &|_| 0.05, &mut Random::new(1));
        let (mean, least) = edges(&plane);
        assert!((mean / 0.05 - 1.0).abs() < 0.1 && least > 25.0, "{mean} {least}");
        let sum: f64 = (0..plane.triangles.len()).map(|t| cross(plane.sides(t)[0], plane.sides(t)[1])).sum();
        assert!((sum / 2.0 - 0.7).abs() < 1e-12);
    }
}
