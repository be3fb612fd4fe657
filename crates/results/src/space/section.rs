//! Facets clipped by a plane, and the section through tetrahedra.

use crate::space::facets::WITHOUT;

/// A plane. The part on the side of its normal is taken away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    pub(crate) normal: [f64; 3],
    /// Product of the normal and a point of the plane.
    pub(crate) offset: f64,
}

/// A convex polygon with three or four corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Polygon<S> {
    corners: [[f64; 3]; 4],
    /// Kinds of the sides from corner `k` to the next corner.
    sides: [S; 4],
    count: usize,
}

impl<S: Copy> Polygon<S> {
    /// Makes a polygon of the first three or four corners and sides.
    fn new(corners: &[([f64; 3], S)]) -> Option<Self> {
        let &(first, side) = corners.first()?;
        let mut polygon = Self { corners: [first; 4], sides: [side; 4], count: corners.len() };
        for (k, &(corner, side)) in corners.iter().enumerate() {
            *polygon.corners.get_mut(k)? = corner;
            polygon.sides[k] = side;
        }
        Some(polygon)
    }

    /// Returns the corners.
    #[cfg(test)]
    pub(crate) fn corners(&self) -> &[[f64; 3]] {
        &self.corners[..self.count]
    }

    /// Returns triangles that are the polygon, with their sides. `within` is the side between two of them.
    pub(crate) fn triangles(self, within: S) -> impl Iterator<Item = ([[f64; 3]; 3], [S; 3])> {
        let ([a, b, c, d], sides) = (self.corners, self.sides);
        let whole = self.count == 3;
        let first = ([a, b, c], [sides[0], sides[1], if whole { sides[2] } else { within }]);
        [Some(first), (!whole).then_some(([a, c, d], [within, sides[2], sides[3]]))].into_iter().flatten()
    }
}

impl Plane {
    /// Returns how far a point is on the side that is taken away, in lengths of the normal.
    pub(crate) fn beyond(&self, point: [f64; 3]) -> f64 {
        self.normal[0] * point[0] + self.normal[1] * point[1] + self.normal[2] * point[2] - self.offset
    }

    /// Returns the part of a triangle that the plane leaves; `None` if nothing is left. `cut` is the new
    /// side, in the plane.
    pub(crate) fn clipped<S: Copy>(
        &self,
        corners: [[f64; 3]; 3],
        sides: [S; 3],
        cut: S,
    ) -> Option<Polygon<S>> {
        let beyond = corners.map(|corner| self.beyond(corner));
        if beyond.iter().all(|&beyond| beyond <= 0.0) {
            return Polygon::new(&[0, 1, 2].map(|k| (corners[k], sides[k])));
        }
        let mut kept = [(corners[0], cut); 4];
        let mut count = 0;
        let mut push = |corner: ([f64; 3], S)| {
            kept[count] = corner;
            count += 1;
        };
        for k in 0..3 {
            let next = (k + 1) % 3;
            match (beyond[k] <= 0.0, beyond[next] <= 0.0) {
                (true, true) => push((corners[k], sides[k])),
                (true, false) => {
                    push((corners[k], sides[k]));
                    push((crossing([corners[k], corners[next]], [beyond[k], beyond[next]]), cut));
                }
                (false, true) => {
                    push((crossing([corners[next], corners[k]], [beyond[next], beyond[k]]), sides[k]));
                }
                (false, false) => (),
            }
        }
        if count == 0 { None } else { Polygon::new(&kept[..count]) }
    }

    /// Returns the section through a tetrahedron. `sides`: of the lines in which its facets cross the plane.
    /// A facet that lies in the plane is a section of the element that is taken away, unless it is `outside`.
    pub(crate) fn section<S: Copy>(
        &self,
        corners: [[f64; 3]; 4],
        sides: [S; 4],
        outside: impl Fn(usize) -> bool,
    ) -> Option<Polygon<S>> {
        let beyond = corners.map(|corner| self.beyond(corner));
        let (mut kept, mut taken) = ([0; 4], [0; 4]);
        let (mut left, mut away) = (0, 0);
        for (k, &beyond) in beyond.iter().enumerate() {
            if beyond <= 0.0 {
                kept[left] = k;
                left += 1;
            } else if beyond > 0.0 {
                taken[away] = k;
                away += 1;
            }
        }
        // A corner that is not finite is on neither side.
        if left == 0 || left + away < 4 {
            return None;
        }
        // Only a corner, an edge or a facet touches the plane.
        let touches = kept[..left].iter().all(|&corner| beyond[corner] == 0.0);
        if touches && (left < 3 || outside(WITHOUT[taken[0]])) {
            return None;
        }
        let across = |a: usize, b: usize| crossing([corners[a], corners[b]], [beyond[a], beyond[b]]);
        // Two neighbouring corners of the section are on edges of one facet, which is without the fourth
        // corner of the element.
        let side = |missing: usize| sides[WITHOUT[missing]];
        match (&kept[..left], &taken[..away]) {
            (&[a], &[b, c, d]) => {
                Polygon::new(&[(across(a, b), side(d)), (across(a, c), side(b)), (across(a, d), side(c))])
            }
            (&[b, c, d], &[a]) => {
                Polygon::new(&[(across(b, a), side(d)), (across(c, a), side(b)), (across(d, a), side(c))])
            }
            (&[a, b], &[c, d]) => Polygon::new(&[
                (across(a, c), side(b)),
                (across(a, d), side(c)),
                (across(b, d), side(a)),
                (across(b, c), side(d)),
            ]),
            _ => None,
        }
    }
}

/// Returns where a line crosses the plane, from the end that is left to the end that is taken away:
/// neighbours find the same point.
fn crossing([from, to]: [[f64; 3]; 2], [before, beyond]: [f64; 2]) -> [f64; 3] {
    let share = before / (before - beyond);
    [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::facets::FACETS;

    const UNIT: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    /// The normal of a polygon, as long as its area.
    fn area(corners: &[[f64; 3]]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for k in 1..corners.len() - 1 {
            let [u, v] =
                [corners[k], corners[k + 1]].map(|p| [0, 1, 2].map(|axis| p[axis] - corners[0][axis]));
            for (axis, sum) in sum.iter_mut().enumerate() {
                let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
                *sum += (u[y] * v[z] - u[z] * v[y]) / 2.0;
            }
        }
        sum
    }

    fn length(vector: [f64; 3]) -> f64 {
        vector.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// The unit cube as six tetrahedra around its diagonal.
    fn cube() -> Vec<[[f64; 3]; 4]> {
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];
        let element = |order: [usize; 3]| {
            let mut element = [[0.0; 3]; 4];
            for (corner, axis) in (1..).zip(order) {
                element[corner] = element[corner - 1];
                element[corner][axis] = 1.0;
            }
            element
        };
        orders.map(element).to_vec()
    }

    fn corners_of(element: [[f64; 3]; 4], facet: usize) -> [[f64; 3]; 3] {
        FACETS[facet].map(|corner| element[corner])
    }

    fn is_outside(corners: [[f64; 3]; 3]) -> bool {
        (0..3).any(|axis| [0.0, 1.0].iter().any(|&at| corners.iter().all(|corner| corner[axis] == at)))
    }

    /// Sections of the cube: their areas, and the lengths of their lines on the sides of the cube.
    #[test]
    fn sections_of_a_cube_are_the_known_polygons() {
        let (root_2, root_3) = (2.0_f64.sqrt(), 3.0_f64.sqrt());
        for (normal, offset, whole, around) in [
            ([1.0, 0.0, 0.0], 0.3, 1.0, 4.0),
            ([0.0, 0.0, -1.0], -0.25, 1.0, 4.0),
            // A regular hexagon, and a triangle.
            ([1.0, 1.0, 1.0], 1.5, 0.75 * root_3, 3.0 * root_2),
            ([1.0, 1.0, 1.0], 0.5, 0.125 * root_3, 1.5 * root_2),
            // Through four edges, and through two.
            ([1.0, 1.0, 0.0], 1.0, root_2, 2.0 + 2.0 * root_2),
            ([1.0, -1.0, 0.0], 0.0, root_2, 2.0 + 2.0 * root_2),
            ([1.0, 0.0, 0.0], 1.5, 0.0, 0.0),
            ([1.0, 0.0, 0.0], -0.5, 0.0, 0.0),
            // Only a side of the cube is in the plane.
            ([1.0, 0.0, 0.0], 1.0, 0.0, 0.0),
            ([1.0, 0.0, 0.0], 0.0, 0.0, 0.0),
        ] {
            let plane = Plane { normal, offset };
            let (mut found, mut rim) = (0.0, 0.0);
            for element in cube() {
                let outside = [0, 1, 2, 3].map(|facet| is_outside(corners_of(element, facet)));
                let Some(section) = plane.section(element, [0, 1, 2, 3], |facet| outside[facet]) else {
                    continue;
                };
                assert!(section.corners().iter().all(|&corner| plane.beyond(corner).abs() < 1e-15));
                found += length(area(section.corners()));
                let corners = section.corners();
                for k in 0..corners.len() {
                    let (a, b, facet) = (corners[k], corners[(k + 1) % corners.len()], section.sides[k]);
                    let step = [0, 1, 2].map(|axis| b[axis] - a[axis]);
                    // The side lies in its facet.
                    let [p, q, r] = corners_of(element, facet);
                    for end in [a, b] {
                        let parts = [[p, q, end], [q, r, end], [r, p, end]].map(|part| length(area(&part)));
                        assert!((parts.iter().sum::<f64>() - length(area(&[p, q, r]))).abs() < 1e-14);
                    }
                    if outside[facet] {
                        rim += length(step);
                    }
                }
            }
            assert!((found - whole).abs() < 1e-14, "{normal:?} {offset}: {found} {whole}");
            assert!((rim - around).abs() < 1e-14, "{normal:?} {offset}: {rim} {around}");
        }
    }

    /// The surface that is left and the section close: the sum of their normals is zero.
    #[test]
    fn what_is_left_of_a_tetrahedron_is_closed() {
        let mut numbers = (1..).map(|k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 65_536.0 - 0.5);
        let mut point = || [0; 3].map(|_| numbers.next().unwrap());
        let mut shapes = [0; 5];
        for _ in 0..500 {
            let (element, normal, through) = ([point(), point(), point(), point()], point(), point());
            let offset = (0..3).map(|axis| normal[axis] * through[axis]).sum();
            let plane = Plane { normal, offset };
            let mut sum = [0.0; 3];
            for facet in 0..4 {
                if let Some(left) = plane.clipped(corners_of(element, facet), [false; 3], true) {
                    let normal = area(left.corners());
                    (0..3).for_each(|axis| sum[axis] += normal[axis]);
                    assert!(left.corners().iter().all(|&corner| plane.beyond(corner) < 1e-14));
                    // Both ends of a new side are in the plane.
                    for k in (0..left.count).filter(|&k| left.sides[k]) {
                        let ends = [left.corners[k], left.corners[(k + 1) % left.count]];
                        assert!(ends.iter().all(|&end| plane.beyond(end).abs() < 1e-14));
                    }
                }
            }
            let section = plane.section(element, [(); 4], |_| false);
            let normal = section.map_or([0.0; 3], |section| area(section.corners()));
            assert!((length(normal) - length(sum)).abs() < 1e-13, "{normal:?} {sum:?}");
            shapes[section.map_or(0, |section| section.count)] += 1;
            // The triangles of a polygon are the polygon.
            if let Some(section) = section {
                let parts: f64 = section.triangles(()).map(|(corners, _)| length(area(&corners))).sum();
                assert!((parts - length(normal)).abs() < 1e-14);
            }
        }
        assert!(shapes[0] > 50 && shapes[3] > 50 && shapes[4] > 50, "{shapes:?}");
    }

    #[test]
    fn a_facet_in_the_plane_is_a_section_unless_it_is_outside() {
        let plane = Plane { normal: [0.0, 0.0, 1.0], offset: 0.0 };
        let bottom = |facet: usize| FACETS[facet].iter().all(|&corner| UNIT[corner][2] == 0.0);
        let section = plane.section(UNIT, [(); 4], |_| false).unwrap();
        assert_eq!(length(area(section.corners())), 0.5);
        assert_eq!(plane.section(UNIT, [(); 4], bottom), None);
        let turned = Plane { normal: [0.0, 0.0, -1.0], offset: 0.0 };
        assert_eq!(turned.section(UNIT, [(); 4], |_| false), None, "nothing is taken away");
        assert_eq!(turned.clipped(corners_of(UNIT, 0), [0; 3], 1).unwrap().corners(), corners_of(UNIT, 0));
    }

    #[test]
    fn places_that_are_no_numbers_have_no_section() {
        let mut element = UNIT;
        element[2][1] = f64::NAN;
        let plane = Plane { normal: [1.0, 1.0, 1.0], offset: 0.5 };
        assert_eq!(plane.section(element, [(); 4], |_| false), None);
    }
}
