//! Points and vectors of three numbers.

/// A point or a vector.
pub(crate) type Point = [f64; 3];

#[inline]
pub(crate) fn plus(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(crate) fn times(a: Point, factor: f64) -> Point {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

#[inline]
pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(crate) fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub(crate) fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

#[inline]
pub(crate) fn distance(a: Point, b: Point) -> f64 {
    length(minus(a, b))
}

/// The vector of length 1 along `a`; zero if `a` is zero.
pub(crate) fn unit(a: Point) -> Point {
    let length = length(a);
    if length > 0.0 { times(a, 1.0 / length) } else { a }
}

/// Twice the area of a triangle, along its normal: the corners are counter-clockwise seen from its tip.
#[inline]
pub(crate) fn normal(a: Point, b: Point, c: Point) -> Point {
    cross(minus(b, a), minus(c, a))
}

/// Centre of the circle around a triangle, and the square of its radius; `None` if the corners are in a line.
pub(crate) fn circle(a: Point, b: Point, c: Point) -> Option<(Point, f64)> {
    let (u, v) = (minus(b, a), minus(c, a));
    let n = cross(u, v);
    let square = dot(n, n);
    if square <= 0.0 {
        return None;
    }
    let offset = cross(minus(times(v, dot(u, u)), times(u, dot(v, v))), n);
    let offset = times(offset, 0.5 / square);
    Some((plus(a, offset), dot(offset, offset)))
}

/// Centre of the sphere around a tetrahedron, and the square of its radius; `None` if the corners are in a
/// plane.
#[inline]
pub(crate) fn sphere(a: Point, b: Point, c: Point, d: Point) -> Option<(Point, f64)> {
    let (u, v, w) = (minus(b, a), minus(c, a), minus(d, a));
    let vw = cross(v, w);
    let determinant = dot(u, vw);
    let sum = plus(plus(times(vw, dot(u, u)), times(cross(w, u), dot(v, v))), times(cross(u, v), dot(w, w)));
    let offset = times(sum, 0.5 / determinant);
    let square = dot(offset, offset);
    (determinant != 0.0 && square.is_finite()).then(|| (plus(a, offset), square))
}

/// A random point in the ball of radius 1 around the origin; no sine is needed, which differs from platform
/// to platform.
pub(crate) fn in_ball(random: &mut fdem_scenes::random::Random) -> Point {
    loop {
        let point = [(); 3].map(|()| random.between(-1.0, 1.0));
        if dot(point, point) <= 1.0 {
            return point;
        }
    }
}

/// The corners of the box around points.
pub(crate) fn bounds(nodes: &[Point]) -> (Point, Point) {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for node in nodes {
        for axis in 0..3 {
            low[axis] = low[axis].min(node[axis]);
            high[axis] = high[axis].max(node[axis]);
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centres_have_one_distance_from_all_corners() {
        let points = [[0.1, 0.2, 0.3], [1.0, 0.1, 0.2], [0.3, 1.5, 0.1], [0.2, 0.4, 0.9]];
        let (centre, square) = sphere(points[0], points[1], points[2], points[3]).unwrap();
        for point in points {
            assert!((distance(point, centre) - square.sqrt()).abs() < 1e-12);
        }
        let (centre, square) = circle(points[0], points[1], points[2]).unwrap();
        for &point in &points[..3] {
            assert!((distance(point, centre) - square.sqrt()).abs() < 1e-12);
        }
        assert!(circle([0.0; 3], [1.0; 3], [2.0; 3]).is_none());
    }
}
