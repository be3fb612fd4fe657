//! Delaunay's tetrahedra of points in space, built point by point.
//!
//! The space outside of the points' convex hull is filled with ghosts: tetrahedra with a facet of the hull
//! and the corner [`GHOST`]. A new point takes away all tetrahedra whose spheres it is in, and is joined to
//! the facets around the gap. Ties (points on a common sphere) are broken as if each point were lifted a
//! little, the more the higher its number: no tetrahedron is ever flat, and the result does not depend on the
//! order of the insertions.
//!
//! # Sources
//! A. Bowyer, "Computing Dirichlet tessellations", and D. F. Watson, "Computing the n-dimensional Delaunay
//! tessellation", both Computer Journal 24 (1981); O. Devillers, M. Teillaud, "Perturbations for Delaunay and
//! weighted Delaunay 3D triangulations", Comput. Geom. 44 (2011), for the ties; O. Devillers, S. Pion, M.
//! Teillaud, "Walking in a triangulation", Int. J. Found. Comput. Sci. 13 (2002).

use super::predicates::{side, within};
use super::surface::OUTSIDE;
use super::vector::Point;

/// The corner of ghosts: the point at infinity.
pub(crate) const GHOST: u32 = u32::MAX;

/// No element.
pub(crate) const NONE: u32 = u32::MAX;

/// Corners of the facet opposite each corner, counter-clockwise seen from outside.
pub(crate) const FACETS: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Vertices around a gap for which places are looked up in a table.
const TABLE: usize = 128;

/// Steps of a walk from which on it is led by chance.
const LONG: u32 = 1000;

/// A facet around the gap of a new point.
#[derive(Clone, Copy)]
struct Border {
    /// Corners of the new tetrahedron; the new point takes the place `at`.
    corners: [u32; 4],
    at: u8,
    /// Whether the facet is locked.
    locked: bool,
    region: u32,
    /// The facet from outside: four times the element, plus the place of its opposite corner.
    outside: u32,
}

/// A Delaunay triangulation. The points are the caller's.
///
/// With [`insert_inside`](Self::insert_inside), it is one of the space that locked facets divide: a sphere
/// may hold points, if none of them is seen from inside the tetrahedron.
#[derive(Clone)]
pub(crate) struct Delaunay {
    /// Corners of each tetrahedron, of positive volume. Free places have [`NONE`] as their first two corners.
    pub(crate) corners: Vec<[u32; 4]>,
    /// Beyond the facet opposite each corner: four times the neighbour, plus the place of its opposite
    /// corner.
    pub(crate) across: Vec<[u32; 4]>,
    /// Region of each tetrahedron; new ones take it from those in whose place they are.
    pub(crate) regions: Vec<u32>,
    /// Bit `k` is set if the facet opposite corner `k` is locked.
    pub(crate) locked: Vec<u8>,
    /// Tetrahedra that the last insertion made.
    pub(crate) made: Vec<u32>,
    free: Vec<u32>,
    /// Number of the latest search that met a tetrahedron, times 2, plus 1 if the point was in its sphere.
    met: Vec<u32>,
    search: u32,
    gap: Vec<u32>,
    border: Vec<Border>,
    /// For each vertex: the search that met it, and its number in that search.
    local: Vec<[u32; 2]>,
    table: Vec<u32>,
    last: u32,
}

impl Delaunay {
    /// Delaunay's tetrahedra of the points `order`, inserted in that order; `None` if all points are in one
    /// plane. Points that are met twice are left out.
    ///
    /// # Cost
    /// About 4 µs for a point, if points that follow each other are near each other.
    pub(crate) fn new(points: &[Point], order: &[u32]) -> Option<Self> {
        let first = first_four(points, order)?;
        let room = 7 * points.len() + 16;
        let mut new = Self {
            corners: Vec::with_capacity(room),
            across: Vec::with_capacity(room),
            regions: Vec::with_capacity(room),
            locked: Vec::with_capacity(room),
            made: Vec::new(),
            free: Vec::new(),
            met: Vec::with_capacity(room),
            search: 0,
            gap: Vec::new(),
            border: Vec::new(),
            local: Vec::new(),
            table: vec![NONE; TABLE * TABLE],
            last: 0,
        };
        new.start(first);
        for &vertex in order.iter().filter(|vertex| !first.contains(vertex)) {
            new.insert(points, vertex);
        }
        Some(new)
    }

    /// One tetrahedron, and the ghosts on its facets.
    fn start(&mut self, first: [u32; 4]) {
        self.push(first);
        for facet in FACETS {
            let [a, b, c] = facet.map(|place| first[place]);
            self.push([a, b, c, GHOST]);
        }
        // The neighbour of tetrahedron t opposite its corner is the one that has all others.
        for t in 0..5_usize {
            for (place, facet) in FACETS.iter().enumerate() {
                let others = facet.map(|other| self.corners[t][other]);
                for u in (0..5_usize).filter(|&u| u != t) {
                    let opposite = (0..4).find(|&k| !others.contains(&self.corners[u][k]));
                    if others.iter().all(|corner| self.corners[u].contains(corner)) {
                        self.across[t][place] = (4 * u + opposite.unwrap_or(0)) as u32;
                    }
                }
            }
        }
    }

    fn push(&mut self, corners: [u32; 4]) {
        self.corners.push(corners);
        self.across.push([NONE; 4]);
        self.regions.push(0);
        self.locked.push(0);
        self.met.push(0);
    }

    /// Inserts a point. Returns `false` if there is one at its place.
    pub(crate) fn insert(&mut self, points: &[Point], vertex: u32) -> bool {
        let point = points[vertex as usize];
        let start = self.locate(points, point, self.last);
        let same = |&corner: &u32| corner != GHOST && points[corner as usize] == point;
        if self.corners[start as usize].iter().any(same) {
            return false;
        }
        self.find_gap(points, point, vertex, start, false);
        self.fill_gap(vertex);
        true
    }

    /// Inserts a point that is not [`OUTSIDE`] such that no locked facet is lost. Returns whether it is
    /// inserted.
    pub(crate) fn insert_inside(&mut self, points: &[Point], vertex: u32) -> bool {
        let point = points[vertex as usize];
        let start = self.locate(points, point, self.last);
        if self.regions[start as usize] == OUTSIDE || !self.find_gap_inside(points, point, vertex, start) {
            return false;
        }
        self.fill_gap(vertex);
        true
    }

    /// Whether a place is in use.
    #[inline]
    pub(crate) fn is_used(&self, t: usize) -> bool {
        self.corners[t][1] != NONE || self.corners[t][0] != NONE
    }

    /// Whether a place is in use by a tetrahedron that is no ghost.
    #[inline]
    pub(crate) fn is_solid(&self, t: usize) -> bool {
        !self.corners[t].contains(&GHOST)
    }

    /// The tetrahedron with a point in it, or a ghost beyond whose facet it is.
    ///
    /// The facet to leave by is the first of those that part the tetrahedron from the point. Where locked
    /// facets keep tetrahedra from being Delaunay's, such a walk could go round in circles: a long one starts
    /// with another facet each time.
    fn locate(&self, points: &[Point], point: Point, start: u32) -> u32 {
        let mut t = start as usize;
        if let Some(ghost) = self.corners[t].iter().position(|&corner| corner == GHOST) {
            t = (self.across[t][ghost] / 4) as usize;
        }
        let mut from = NONE;
        let mut steps = 0_u32;
        'walk: loop {
            let corners = self.corners[t];
            steps = steps.wrapping_add(1);
            let first = if steps < LONG { 0 } else { (steps.wrapping_mul(0x9e37_79b9) >> 30) as usize };
            for place in 0..4 {
                let place = (place + first) % 4;
                let facet = FACETS[place];
                let beyond = self.across[t][place];
                if beyond / 4 == from {
                    continue;
                }
                let [a, b, c] = facet.map(|k| points[corners[k] as usize]);
                if side(a, b, c, point) > 0.0 {
                    from = t as u32;
                    t = (beyond / 4) as usize;
                    if self.corners[t].contains(&GHOST) {
                        return t as u32;
                    }
                    continue 'walk;
                }
            }
            return t as u32;
        }
    }

    /// Whether a point is in the sphere around a tetrahedron, or beyond the facet of a ghost.
    #[inline]
    pub(crate) fn takes(&self, points: &[Point], t: usize, point: Point, vertex: u32) -> bool {
        let corners = self.corners[t];
        let Some(ghost) = corners.iter().position(|&corner| corner == GHOST) else {
            let [a, b, c, d] = corners.map(|corner| points[corner as usize]);
            let value = within(a, b, c, d, point);
            return value > 0.0 || value == 0.0 && tie(points, corners, point, vertex);
        };
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| if k == ghost { point } else { points[corners[k] as usize] });
        let value = side(a, b, c, d);
        if value == 0.0 {
            // In the plane of the facet, the sphere around the solid neighbour cuts out the circle around the
            // facet.
            return self.takes(points, (self.across[t][ghost] / 4) as usize, point, vertex);
        }
        value > 0.0
    }

    /// Finds the tetrahedra that `point`, number `vertex`, takes away and that no locked facet parts from
    /// `start`, which has to be one of them. Returns whether the point sees all facets around them from
    /// inside: only then may the gap be filled.
    pub(crate) fn find_gap_inside(
        &mut self,
        points: &[Point],
        point: Point,
        vertex: u32,
        start: u32,
    ) -> bool {
        self.find_gap(points, point, vertex, start, true);
        self.border.iter().all(|border| {
            let [a, b, c] = FACETS[border.at as usize].map(|k| points[border.corners[k] as usize]);
            side(a, b, c, point) < 0.0
        })
    }

    /// Finds the tetrahedra that `point`, number `vertex`, takes away: `start` has to be one of them. Locked
    /// facets may be `walls`, behind which nothing is taken.
    pub(crate) fn find_gap(&mut self, points: &[Point], point: Point, vertex: u32, start: u32, walls: bool) {
        if self.search >= u32::MAX / 2 - 1 {
            self.met.fill(0);
            self.local.fill([0; 2]);
            self.search = 0;
        }
        self.search += 1;
        let (out, taken) = (2 * self.search, 2 * self.search + 1);
        self.gap.clear();
        self.border.clear();
        self.gap.push(start);
        self.met[start as usize] = taken;
        let mut next = 0;
        while let Some(&t) = self.gap.get(next) {
            next += 1;
            let t = t as usize;
            for place in 0..4 {
                let outside = self.across[t][place];
                let u = (outside / 4) as usize;
                let locked = self.locked[t] >> place & 1 == 1;
                let wall = walls && locked;
                if !wall && self.met[u] < out {
                    let takes = self.takes(points, u, point, vertex);
                    self.met[u] = if takes { taken } else { out };
                    if takes {
                        self.gap.push(u as u32);
                    }
                }
                if wall || self.met[u] == out {
                    let corners = self.corners[t];
                    let region = self.regions[t];
                    self.border.push(Border { corners, at: place as u8, locked, region, outside });
                }
            }
        }
    }

    /// The locked facets around the gap.
    pub(crate) fn locked_around(&self) -> impl Iterator<Item = [u32; 3]> {
        let border = self.border.iter().filter(|border| border.locked);
        border.map(|border| FACETS[border.at as usize].map(|k| border.corners[k]))
    }

    /// Fills the gap that was found with tetrahedra around the new point.
    pub(crate) fn fill_gap(&mut self, vertex: u32) {
        for &t in &self.gap {
            self.corners[t as usize] = [NONE; 4];
        }
        self.free.append(&mut self.gap);
        self.made.clear();
        let border = std::mem::take(&mut self.border);
        let mut edges: Vec<(u64, u32)> = Vec::new();
        let mut numbers = 0;
        for facet in &border {
            let place = self.free.pop().unwrap_or_else(|| {
                self.push([NONE; 4]);
                self.corners.len() as u32 - 1
            });
            self.made.push(place);
            let (t, at) = (place as usize, facet.at as usize);
            self.corners[t] = facet.corners;
            self.corners[t][at] = vertex;
            self.regions[t] = facet.region;
            self.locked[t] = u8::from(facet.locked) << at;
            self.met[t] = 0;
            self.across[t][at] = facet.outside;
            self.across[(facet.outside / 4) as usize][(facet.outside % 4) as usize] =
                4 * place + u32::from(facet.at);
            let local = facet.corners.map(|corner| self.number(corner, &mut numbers));
            for other in (0..4).filter(|&other| other != at) {
                let code = 4 * place + other as u32;
                let [u, v] = REST[at][other];
                let [u, v] = [local[u].min(local[v]) as usize, local[u].max(local[v]) as usize];
                if v >= TABLE {
                    edges.push(((u as u64) << 32 | v as u64, code));
                    continue;
                }
                let known = std::mem::replace(&mut self.table[u * TABLE + v], code);
                if known != NONE {
                    self.table[u * TABLE + v] = NONE;
                    self.join(known, code);
                }
            }
        }
        edges.sort_unstable();
        for pair in edges.chunks_exact(2) {
            self.join(pair[0].1, pair[1].1);
        }
        self.border = border;
        self.last = self.made.last().copied().unwrap_or(self.last);
    }

    /// Makes two facets each other's neighbours.
    #[inline]
    fn join(&mut self, one: u32, other: u32) {
        self.across[(one / 4) as usize][(one % 4) as usize] = other;
        self.across[(other / 4) as usize][(other % 4) as usize] = one;
    }

    /// Number of a vertex in this search.
    #[inline]
    fn number(&mut self, vertex: u32, numbers: &mut u32) -> u32 {
        // The ghost comes first.
        let index = vertex.wrapping_add(1) as usize;
        if self.local.len() <= index {
            self.local.resize(index + 1 + index / 2, [0; 2]);
        }
        let local = &mut self.local[index];
        if local[0] != self.search {
            *local = [self.search, *numbers];
            *numbers += 1;
        }
        local[1]
    }
}

/// The two places that are neither.
const REST: [[[usize; 2]; 4]; 4] = [
    [[0, 0], [2, 3], [1, 3], [1, 2]],
    [[2, 3], [0, 0], [0, 3], [0, 2]],
    [[1, 3], [0, 3], [0, 0], [0, 1]],
    [[1, 2], [0, 2], [0, 1], [0, 0]],
];

/// Whether a point on the sphere around a tetrahedron counts as inside.
///
/// Every point is lifted by a tiny amount, and that of a higher number by far more: the highest whose lift
/// changes anything decides. Lifting the new point itself moves it out; lifting a corner moves it in if it is
/// on the same side of the other three as the corner.
#[cold]
fn tie(points: &[Point], corners: [u32; 4], point: Point, vertex: u32) -> bool {
    let mut order = [0, 1, 2, 3];
    order.sort_unstable_by_key(|&k: &usize| std::cmp::Reverse(corners[k]));
    for k in order {
        if vertex > corners[k] {
            return false;
        }
        let [a, b, c, d] =
            [0, 1, 2, 3].map(|other| if other == k { point } else { points[corners[other] as usize] });
        let value = side(a, b, c, d);
        if value != 0.0 {
            return value > 0.0;
        }
    }
    false
}

/// The first four points that are not in a plane, as a tetrahedron of positive volume.
fn first_four(points: &[Point], order: &[u32]) -> Option<[u32; 4]> {
    let at = |vertex: u32| points[vertex as usize];
    let &one = order.first()?;
    let &two = order.iter().find(|&&vertex| at(vertex) != at(one))?;
    let &three = order.iter().find(|&&vertex| !in_line(at(one), at(two), at(vertex)))?;
    let &four = order.iter().find(|&&vertex| side(at(one), at(two), at(three), at(vertex)) != 0.0)?;
    let positive = side(at(one), at(two), at(three), at(four)) > 0.0;
    Some(if positive { [one, two, three, four] } else { [one, three, two, four] })
}

/// Whether three points are in a line: exactly.
pub(crate) fn in_line(a: Point, b: Point, c: Point) -> bool {
    [[0, 1], [1, 2], [2, 0]].iter().all(|&[x, y]| {
        let [a, b, c] = [a, b, c].map(|point| robust::Coord { x: point[x], y: point[y] });
        robust::orient2d(a, b, c) == 0.0
    })
}

#[cfg(test)]
mod tests {
    use fdem_scenes::random::Random;

    use super::super::order;
    use super::*;

    /// Checks neighbours, volumes and Delaunay's property by comparing all with all; returns the volume of
    /// the hull.
    fn check(points: &[Point]) -> f64 {
        let order = order::rounds(&order::along_curve(points));
        let mesh = Delaunay::new(points, &order).unwrap();
        let mut sum = 0.0;
        for t in (0..mesh.corners.len()).filter(|&t| mesh.is_used(t)) {
            for (place, facet) in FACETS.iter().enumerate() {
                let beyond = mesh.across[t][place];
                let (u, opposite) = ((beyond / 4) as usize, (beyond % 4) as usize);
                assert_eq!(mesh.across[u][opposite], (4 * t + place) as u32);
                let mut one = facet.map(|k| mesh.corners[t][k]);
                let mut other = FACETS[opposite].map(|k| mesh.corners[u][k]);
                one.sort_unstable();
                other.sort_unstable();
                assert_eq!(one, other);
            }
            for (vertex, &point) in (0..).zip(points) {
                let same = |&corner: &u32| corner != GHOST && points[corner as usize] == point;
                assert!(mesh.corners[t].iter().any(same) || !mesh.takes(points, t, point, vertex));
            }
            if mesh.is_solid(t) {
                let [a, b, c, d] = mesh.corners[t].map(|corner| points[corner as usize]);
                assert!(side(a, b, c, d) > 0.0);
                sum += side(a, b, c, d) / 6.0;
            }
        }
        sum
    }

    #[test]
    fn random_points_are_delaunay() {
        for seed in 0..20 {
            let mut random = Random::new(seed);
            let mut points: Vec<Point> = (0..100).map(|_| [(); 3].map(|()| random.uniform())).collect();
            points.extend((0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(f64::from)));
            assert!((check(&points) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn points_of_a_grid_and_on_a_sphere_are_no_trouble() {
        let grid: Vec<Point> = (0..125).map(|k| [k % 5, k / 5 % 5, k / 25].map(f64::from)).collect();
        assert!((check(&grid) - 64.0).abs() < 1e-12);
        let twice: Vec<Point> = grid.iter().chain(&grid).copied().collect();
        assert!((check(&twice) - 64.0).abs() < 1e-12);
        // 26 of the points at the distance 3: permutations and signs of (3, 0, 0) and (2, 2, 1).
        let sphere: Vec<Point> = (0..343)
            .map(|k| [k % 7 - 3, k / 7 % 7 - 3, k / 49 - 3].map(f64::from))
            .filter(|p| p.iter().map(|x| x * x).sum::<f64>() == 9.0)
            .collect();
        assert_eq!(sphere.len(), 30);
        assert!(check(&sphere) > 50.0);
    }

    #[test]
    fn the_order_of_insertion_does_not_matter() {
        let grid: Vec<Point> = (0..64).map(|k| [k % 4, k / 4 % 4, k / 16].map(f64::from)).collect();
        let sorted = |order: &[u32]| {
            let mesh = Delaunay::new(&grid, order).unwrap();
            let mut all: Vec<[u32; 4]> =
                (0..mesh.corners.len()).filter(|&t| mesh.is_used(t)).map(|t| mesh.corners[t]).collect();
            for corners in &mut all {
                corners.sort_unstable();
            }
            all.sort_unstable();
            all
        };
        let forward: Vec<u32> = (0..64).collect();
        let backward: Vec<u32> = (0..64).rev().collect();
        assert_eq!(sorted(&forward), sorted(&backward));
    }

    #[test]
    fn flat_points_have_no_tetrahedra() {
        let flat: Vec<Point> = (0..9).map(|k| [f64::from(k % 3), f64::from(k / 3), 0.3]).collect();
        let all: Vec<u32> = (0..9).collect();
        assert!(Delaunay::new(&flat, &all).is_none());
        assert!(Delaunay::new(&flat, &[]).is_none());
        assert!(Delaunay::new(&flat, &[1, 1, 1, 1, 1]).is_none());
    }
}
