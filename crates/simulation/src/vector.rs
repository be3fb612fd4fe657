//! Points and vectors of any dimension. Every operation rounds in a fixed order, so that results are the same on every platform.

/// A point or vector.
pub(crate) type Point<const D: usize = 2> = [f64; D];

#[inline]
pub(crate) fn minus<const D: usize>(a: Point<D>, b: Point<D>) -> Point<D> {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

#[inline]
pub(crate) fn dot<const D: usize>(a: Point<D>, b: Point<D>) -> f64 {
    let mut sum = a[0] * b[0];
    for axis in 1..D {
        sum += a[axis] * b[axis];
    }
    sum
}

/// Length of a vector, by a square root: it is the same on every platform, unlike `hypot`.
#[inline]
pub(crate) fn length<const D: usize>(a: Point<D>) -> f64 {
    dot(a, a).sqrt()
}

#[inline]
pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Adds a multiple of a vector.
#[inline]
pub(crate) fn add<const D: usize>(to: &mut Point<D>, direction: Point<D>, factor: f64) {
    for axis in 0..D {
        to[axis] += direction[axis] * factor;
    }
}

/// A matrix or tensor, by rows.
pub(crate) type Matrix<const D: usize = 2> = [[f64; D]; D];

/// The matrix with these entries.
#[inline]
pub(crate) fn matrix<const D: usize>(entry: impl Fn(usize, usize) -> f64) -> Matrix<D> {
    std::array::from_fn(|i| std::array::from_fn(|k| entry(i, k)))
}

#[inline]
pub(crate) fn transposed<const D: usize>(a: &Matrix<D>) -> Matrix<D> {
    matrix(|i, k| a[k][i])
}

/// `a b`.
#[inline]
pub(crate) fn product<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> Matrix<D> {
    product_transposed(a, &transposed(b))
}

/// `a bᵀ`.
#[inline]
pub(crate) fn product_transposed<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> Matrix<D> {
    matrix(|i, k| dot(a[i], b[k]))
}

/// `a v`.
#[inline]
pub(crate) fn applied<const D: usize>(a: &Matrix<D>, v: Point<D>) -> Point<D> {
    std::array::from_fn(|i| dot(a[i], v))
}

/// `a:b`.
#[inline]
pub(crate) fn contraction<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> f64 {
    let mut products = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b);
    let first = products.next().unwrap_or_default();
    products.fold(first, |sum, product| sum + product)
}

/// `(a + aᵀ)/2`.
#[inline]
pub(crate) fn symmetric<const D: usize>(a: &Matrix<D>) -> Matrix<D> {
    matrix(|i, k| if i == k { a[i][i] } else { 0.5 * (a[i.min(k)][i.max(k)] + a[i.max(k)][i.min(k)]) })
}
