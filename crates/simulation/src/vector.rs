//! Points and vectors of any dimension. Every operation rounds in a fixed order, so that results are the same
//! on every platform. Twin: `crates/gpu/kernels/laws.h`.

/// A point or vector.
pub(crate) type Point<const D: usize = 2> = [f64; D];

#[inline(always)]
pub(crate) fn minus<const D: usize>(a: Point<D>, b: Point<D>) -> Point<D> {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

#[inline(always)]
pub(crate) fn plus<const D: usize>(a: Point<D>, b: Point<D>) -> Point<D> {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

#[inline(always)]
pub(crate) fn dot<const D: usize>(a: Point<D>, b: Point<D>) -> f64 {
    let mut sum = a[0] * b[0];
    for axis in 1..D {
        sum += a[axis] * b[axis];
    }
    sum
}

/// Length of a vector, by a square root: it is the same on every platform, unlike `hypot`.
#[inline(always)]
pub(crate) fn length<const D: usize>(a: Point<D>) -> f64 {
    dot(a, a).sqrt()
}

/// The vector of unit length in the same direction.
#[inline(always)]
pub(crate) fn unit<const D: usize>(a: Point<D>) -> Point<D> {
    let long = length(a);
    a.map(|x| x / long)
}

#[inline(always)]
pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[inline(always)]
pub(crate) fn cross3(a: Point<3>, b: Point<3>) -> Point<3> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Adds a multiple of a vector.
#[inline(always)]
pub(crate) fn add<const D: usize>(to: &mut Point<D>, direction: Point<D>, factor: f64) {
    for axis in 0..D {
        to[axis] += direction[axis] * factor;
    }
}

/// The part along the facet of a vector, whose first component is the one across.
#[inline(always)]
pub(crate) fn along<const D: usize>(mut vector: [f64; D]) -> [f64; D] {
    vector[0] = 0.0;
    vector
}

/// A vector, shortened to `limit` if it is longer.
#[inline(always)]
pub(crate) fn at_most<const D: usize>(vector: [f64; D], limit: f64) -> [f64; D] {
    let size = length(vector);
    if size > limit { vector.map(|x| limit * (x / size)) } else { vector }
}

/// A matrix or tensor, by rows.
pub(crate) type Matrix<const D: usize = 2> = [[f64; D]; D];

/// The matrix with these entries.
#[inline(always)]
pub(crate) fn matrix<const D: usize>(entry: impl Fn(usize, usize) -> f64) -> Matrix<D> {
    std::array::from_fn(|i| std::array::from_fn(|k| entry(i, k)))
}

#[inline(always)]
pub(crate) fn transposed<const D: usize>(a: &Matrix<D>) -> Matrix<D> {
    matrix(|i, k| a[k][i])
}

/// `a b`.
#[inline(always)]
pub(crate) fn product<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> Matrix<D> {
    product_transposed(a, &transposed(b))
}

/// `a bᵀ`.
#[inline(always)]
pub(crate) fn product_transposed<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> Matrix<D> {
    matrix(|i, k| dot(a[i], b[k]))
}

/// `a v`.
#[inline(always)]
pub(crate) fn applied<const D: usize>(a: &Matrix<D>, v: Point<D>) -> Point<D> {
    std::array::from_fn(|i| dot(a[i], v))
}

/// `a:b`.
#[inline(always)]
pub(crate) fn contraction<const D: usize>(a: &Matrix<D>, b: &Matrix<D>) -> f64 {
    let mut products = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b);
    let first = products.next().unwrap_or_default();
    products.fold(first, |sum, product| sum + product)
}

/// `(a + aᵀ)/2`.
#[inline(always)]
pub(crate) fn symmetric<const D: usize>(a: &Matrix<D>) -> Matrix<D> {
    matrix(|i, k| if i == k { a[i][i] } else { 0.5 * (a[i.min(k)][i.max(k)] + a[i.max(k)][i.min(k)]) })
}

/// The lower triangular matrix `L` with `L Lᵀ = a`, which is symmetric and positive.
pub(crate) fn cholesky<const K: usize>(a: &Matrix<K>) -> Matrix<K> {
    let mut root = [[0.0; K]; K];
    for i in 0..K {
        for k in 0..=i {
            let rest = a[i][k] - (0..k).map(|m| root[i][m] * root[k][m]).sum::<f64>();
            root[i][k] = if i == k { rest.max(0.0).sqrt() } else { rest / root[k][k] };
        }
    }
    root
}
