//! Vectors as arrays.

#[inline]
pub(super) fn sub<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|k| a[k] - b[k])
}

#[inline]
pub(super) fn add<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|k| a[k] + b[k])
}

#[inline]
pub(super) fn scale<const D: usize>(a: [f64; D], factor: f64) -> [f64; D] {
    a.map(|x| x * factor)
}

#[inline]
pub(super) fn neg<const D: usize>(a: [f64; D]) -> [f64; D] {
    a.map(|x| -x)
}

/// `a + t (b - a)`, exact at both ends.
#[inline]
pub(super) fn between<const D: usize>(a: [f64; D], b: [f64; D], t: f64) -> [f64; D] {
    if t >= 1.0 { b } else { std::array::from_fn(|k| a[k] + t * (b[k] - a[k])) }
}

#[inline]
pub(super) fn middle<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|k| 0.5 * a[k] + 0.5 * b[k])
}

/// `((a_0 b_0) + a_1 b_1) + …`, in this order.
#[inline]
pub(super) fn dot<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    let mut sum = a[0] * b[0];
    for k in 1..D {
        sum += a[k] * b[k];
    }
    sum
}

#[inline]
pub(super) fn distance_squared<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    let d = sub(a, b);
    dot(d, d)
}

#[inline]
pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The direction of a vector; `None` for zero. The vector is scaled first, because squares of products of
/// four lengths may overflow.
#[inline]
pub(super) fn unit<const D: usize>(a: [f64; D]) -> Option<[f64; D]> {
    let largest = a.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let a = a.map(|x| x / largest);
    let length = dot(a, a).sqrt();
    Some(a.map(|x| x / length))
}

/// The x axis: the normal if the geometry gives no direction.
#[inline]
pub(super) fn x_axis<const D: usize>() -> [f64; D] {
    std::array::from_fn(|k| if k == 0 { 1.0 } else { 0.0 })
}

/// A unit vector perpendicular to a vector: the cross product with the axis along which the vector is
/// shortest; x for zero.
pub(super) fn perpendicular(a: [f64; 3]) -> [f64; 3] {
    let mut shortest = 0;
    for k in 1..3 {
        if a[k].abs() < a[shortest].abs() {
            shortest = k;
        }
    }
    let axis = std::array::from_fn(|k| if k == shortest { 1.0 } else { 0.0 });
    unit(cross(a, axis)).unwrap_or_else(x_axis)
}

/// The first of two points, ordered by their first coordinate, then the second, and so on.
#[inline]
pub(super) fn before<const D: usize>(a: [f64; D], b: [f64; D]) -> bool {
    for k in 0..D {
        if a[k] != b[k] {
            return a[k] < b[k];
        }
    }
    false
}
