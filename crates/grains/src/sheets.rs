//! The contacts of one sphere with a surface.
//!
//! A sphere touches a surface where the distance from its centre has a minimum. Where two minima are joined
//! by a path that stays within the sphere, they are not independent: the contact with the greater distance
//! counts only as far as it lies below the lowest pass between them. With the distances `r` of the minima,
//! `p` of the pass of each, the radius `R` and the energy `E` of the overlap, the energy of all contacts is
//!
//! ```text
//! Σ E(R - r) - E(R - p)
//! ```
//! without the second term for the deepest minimum of each part of the surface that hangs together within
//! the sphere. This is the persistence of components in the sublevel sets of the distance. The energy is
//! continuous: a minimum begins and ends at its pass with nothing. The force is its gradient,
//! `Σ F(R - r) n - F(R - p) m`, with the directions `n` and `m` from the minimum and from the pass to the
//! centre. Triangles in one plane have one minimum, and so one contact.
//!
//! The distance to each facet is convex, so that minima belong to facets, and passes to the edges (or points,
//! in the plane) at which facets meet: facets are joined in the order of the distances of these ridges.
//!
//! Facets of bodies whose outer side looks away from the centre, such as the other side of a thin plate or of
//! a crack, have no minimum, but join others.

use std::cmp::Ordering;

use crate::facet::{Closest, by_place, of_facet, of_segment, sum_of_corners};
use crate::ridges::{NONE, Ridges};
use crate::vector::{Vector, length};

/// Facets with their points and ridges, at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facets<'a> {
    pub(crate) points: &'a [Vector],
    pub(crate) corners: &'a [[u32; 3]],
    pub(crate) ridges: &'a Ridges,
    /// Whether only their outer side is touched.
    pub(crate) is_one_sided: bool,
}

/// A minimum of the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Minimum {
    pub(crate) at: Closest,
    pub(crate) facet: u32,
    /// Where it is joined to a minimum that is closer, if the sphere reaches that pass.
    pub(crate) pass: Option<Closest>,
}

/// A facet within reach.
#[derive(Clone, Copy, Debug)]
struct Cell {
    at: Closest,
    facet: u32,
    /// Whether its outer side is touched.
    is_real: bool,
}

/// A ridge at which two facets within reach meet.
#[derive(Clone, Copy, Debug)]
struct Link {
    at: Closest,
    cells: [u32; 2],
}

/// Memory that is used again for each sphere.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheets {
    cells: Vec<Cell>,
    /// Ridges of the cells, each with its cell.
    sides: Vec<[u32; 2]>,
    links: Vec<Link>,
    /// For each cell another one of its part; the first of a part, its minimum, has itself.
    parents: Vec<u32>,
    /// The passes of minima that are not the deepest of their part.
    passes: Vec<Option<Closest>>,
    /// The minima, by distance and place.
    pub(crate) minima: Vec<Minimum>,
    /// The closest of all facets, also of those that look away.
    pub(crate) closest: Option<(Closest, u32)>,
}

/// Distances that differ by less, as a share of the coordinates, are equal but for rounding.
const ROUNDING: f64 = 1e-14;

impl Sheets {
    /// Finds the minima on some facets within a distance of a centre.
    pub(crate) fn find(&mut self, centre: Vector, reach: f64, near: &[u32], of: &Facets<'_>) {
        self.cells.clear();
        self.minima.clear();
        for &facet in near {
            let (at, is_outside) = of_facet(centre, of.corners[facet as usize], of.points);
            if at.distance < reach {
                self.cells.push(Cell { at, facet, is_real: is_outside || !of.is_one_sided });
            }
        }
        let closest = self.cells.iter().min_by(|a, b| of.order(a, b));
        self.closest = closest.map(|cell| (cell.at, cell.facet));
        match self.cells[..] {
            [] => {}
            [cell] => self.minima.extend(cell.is_real.then_some(cell.minimum(None))),
            _ => {
                let rounding = ROUNDING * (reach + length(centre));
                self.join(centre, reach, rounding, of);
            }
        }
    }

    /// Joins the facets over their ridges, and finds the pass of each minimum.
    fn join(&mut self, centre: Vector, reach: f64, rounding: f64, of: &Facets<'_>) {
        self.find_links(centre, reach, of);
        self.parents.clear();
        self.parents.extend(0..self.cells.len() as u32);
        self.passes.clear();
        self.passes.resize(self.cells.len(), None);
        for k in 0..self.links.len() {
            let Link { at, cells } = self.links[k];
            let [a, b] = cells.map(|cell| self.root(cell));
            if a == b {
                continue;
            }
            let [one, two] = [a, b].map(|cell| &self.cells[cell as usize]);
            let (elder, younger) = if of.order(one, two).is_lt() { (a, b) } else { (b, a) };
            self.parents[younger as usize] = elder;
            let ended = &mut self.cells[younger as usize];
            if at.distance - ended.at.distance <= rounding {
                ended.is_real = false;
            } else {
                self.passes[younger as usize] = Some(at);
            }
        }
        let minima = self.cells.iter().zip(&self.passes).filter(|(cell, _)| cell.is_real);
        self.minima.extend(minima.map(|(cell, pass)| cell.minimum(*pass)));
        if self.minima.len() > 1 {
            self.minima.sort_unstable_by(|a, b| a.at.order(&b.at));
        }
    }

    fn find_links(&mut self, centre: Vector, reach: f64, of: &Facets<'_>) {
        let Self { cells, sides, links, .. } = self;
        sides.clear();
        links.clear();
        for (number, cell) in cells.iter().enumerate() {
            let ridges = of.ridges.of_facet[cell.facet as usize].into_iter().filter(|&ridge| ridge != NONE);
            sides.extend(ridges.map(|ridge| [ridge, number as u32]));
        }
        sides.sort_unstable();
        for pair in sides.windows(2) {
            if pair[0][0] == pair[1][0] {
                let at = of_segment(centre, of.ridges.ends[pair[0][0] as usize], of.points);
                if at.distance < reach {
                    links.push(Link { at, cells: [pair[0][1], pair[1][1]] });
                }
            }
        }
        links.sort_by(|a, b| a.at.order(&b.at));
    }

    /// The minimum of the part of a cell.
    fn root(&mut self, cell: u32) -> u32 {
        let mut root = cell;
        while self.parents[root as usize] != root {
            root = self.parents[root as usize];
        }
        self.parents[cell as usize] = root;
        root
    }
}

impl Cell {
    fn minimum(&self, pass: Option<Closest>) -> Minimum {
        Minimum { at: self.at, facet: self.facet, pass }
    }
}

impl Facets<'_> {
    /// Facets that are touched before others, the closest first. Facets that share their closest point are
    /// in the order of their middles.
    fn order(&self, a: &Cell, b: &Cell) -> Ordering {
        let middle = |cell: &Cell| sum_of_corners(self.corners[cell.facet as usize], self.points);
        let order = b.is_real.cmp(&a.is_real).then_with(|| a.at.order(&b.at));
        order.then_with(|| by_place(middle(a), middle(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{dot, minus, plus, times};

    fn minima(centre: Vector, points: &[Vector], corners: &[[u32; 3]], is_one_sided: bool) -> Vec<Minimum> {
        let ridges = Ridges::new(corners);
        let near: Vec<u32> = (0..corners.len() as u32).collect();
        let mut sheets = Sheets::default();
        sheets.find(centre, 1.0, &near, &Facets { points, corners, ridges: &ridges, is_one_sided });
        sheets.minima.clone()
    }

    /// A strip of four triangles: two halves with a fold between them at x = 0, whose ends are at a height.
    fn folded(height: f64) -> (Vec<Vector>, Vec<[u32; 3]>) {
        let points = vec![
            [-2.0, -2.0, height],
            [0.0, -2.0, 0.0],
            [2.0, -2.0, height],
            [-2.0, 2.0, height],
            [0.0, 2.0, 0.0],
            [2.0, 2.0, height],
        ];
        (points, vec![[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 5, 4]])
    }

    #[test]
    fn facets_of_one_plane_have_one_minimum() {
        let (points, corners) = folded(0.0);
        for x in [-0.5, -0.1, 0.0, 0.1, 0.7] {
            for y in [-0.5, 0.0, 0.02, 0.5] {
                let found = minima([x, y, 0.9], &points, &corners, true);
                assert_eq!(found.len(), 1, "{x} {y}");
                assert!(length(minus(found[0].at.place, [x, y, 0.0])) < 1e-15);
                assert!((found[0].at.distance - 0.9).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_groove_has_two_minima_and_a_pass_between_them() {
        let (points, corners) = folded(0.5);
        let found = minima([0.1, 0.0, 0.8], &points, &corners, true);
        assert_eq!(found.len(), 2);
        assert!(found[0].at.place[0] > 0.0 && found[0].pass.is_none());
        let pass = found[1].pass.expect("a pass");
        assert!(found[1].at.place[0] < 0.0 && length(minus(pass.place, [0.0; 3])) < 1e-15);
        // Where the pass is out of reach, the two minima are independent.
        let found = minima([0.1, 0.0, 1.001], &points, &corners, true);
        assert!(found.len() == 2 && found.iter().all(|of| of.pass.is_none()));
    }

    #[test]
    fn a_ridge_has_one_minimum() {
        let (points, corners) = folded(-0.5);
        let found = minima([0.0, 0.1, 0.8], &points, &corners, true);
        assert_eq!(found.len(), 1);
        assert!(length(minus(found[0].at.place, [0.0, 0.1, 0.0])) < 1e-15);
    }

    #[test]
    fn only_the_outer_side_of_bodies_is_touched() {
        let (points, corners) = folded(0.0);
        assert!(minima([0.1, 0.0, -0.8], &points, &corners, true).is_empty());
        assert_eq!(minima([0.1, 0.0, -0.8], &points, &corners, false).len(), 1);
    }

    /// The energy of linear springs is continuous along a path over a rough surface, and the force is its
    /// gradient.
    #[test]
    fn the_force_is_the_gradient_of_the_energy() {
        let side = 8;
        let mut points = Vec::new();
        for i in 0..=side {
            for j in 0..=side {
                let height = 0.15 * libm::sin(f64::from(i * i * 5 + j * 3) + f64::from(j * i));
                points.push([f64::from(i) * 0.4, f64::from(j) * 0.4, height]);
            }
        }
        let mut corners = Vec::new();
        for i in 0..side {
            for j in 0..side {
                let at = |i: i32, j: i32| (i * (side + 1) + j) as u32;
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                corners.extend([[a, b, c], [a, c, d]]);
            }
        }
        let energy = |found: &[Minimum]| {
            let of = |at: &Closest| 0.5 * (1.0 - at.distance).powi(2);
            found.iter().map(|one| of(&one.at) - one.pass.as_ref().map_or(0.0, of)).sum::<f64>()
        };
        let force = |found: &[Minimum]| {
            let of = |at: &Closest| times(1.0 - at.distance, at.normal);
            found.iter().fold([0.0; 3], |sum, one| {
                plus(sum, minus(of(&one.at), one.pass.as_ref().map_or([0.0; 3], of)))
            })
        };
        let (mut work, mut most) = (0.0, 0);
        let at = |k: u32| {
            let s = f64::from(k) / 10_000.0;
            [0.8 + 1.5 * s, 1.1 + 0.9 * s, 0.95 + 0.1 * libm::sin(20.0 * s)]
        };
        let mut before = minima(at(0), &points, &corners, true);
        let first = energy(&before);
        let mut force_before = force(&before);
        for k in 1..=10_000 {
            let found = minima(at(k), &points, &corners, true);
            let step = minus(at(k), at(k - 1));
            let force_now = force(&found);
            work += dot(times(0.5, plus(force_before, force_now)), step);
            let error = energy(&found) + work - first;
            assert!(error.abs() < 1e-4, "{k} {error}");
            most = most.max(found.len());
            (before, force_before) = (found, force_now);
        }
        assert!(most >= 3 && energy(&before) > 0.0, "{most}");
    }
}
