//! The shapes of the narrow phase. Their constructors check all numbers.

use super::error::ShapeError;
use super::exact::{MAX_MAGNITUDE, MIN_MAGNITUDE};
use super::vector::unit;

/// A sphere, or a disc in 2D. A sphere of radius 0 is a point.
///
/// # Example
/// ```
/// use fdem_contact::narrow::Sphere;
///
/// assert!(Sphere::new([0.0, 0.0], 1.0).is_ok());
/// assert!(Sphere::new([0.0, f64::NAN], 1.0).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere<const D: usize> {
    pub(super) centre: [f64; D],
    pub(super) radius: f64,
}

impl<const D: usize> Sphere<D> {
    /// Makes a sphere from its centre and radius.
    ///
    /// # Errors
    /// [`ShapeError::Coordinate`], [`ShapeError::Radius`].
    pub fn new(centre: [f64; D], radius: f64) -> Result<Self, ShapeError> {
        check(0, centre)?;
        check_radius(radius)?;
        Ok(Self { centre, radius })
    }
}

/// A plane (a line in 2D) without thickness, whose two sides are equivalent.
///
/// # Example
/// ```
/// use fdem_contact::narrow::Plane;
///
/// assert!(Plane::new([0.0, 0.0, 1.0], [0.0, 0.0, 2.0]).is_ok());
/// assert!(Plane::new([0.0, 0.0, 1.0], [0.0, 0.0, 0.0]).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<const D: usize> {
    pub(super) point: [f64; D],
    pub(super) normal: [f64; D],
}

impl<const D: usize> Plane<D> {
    /// Makes a plane through a point, perpendicular to a vector of any length.
    ///
    /// # Errors
    /// [`ShapeError::Coordinate`], [`ShapeError::NoNormal`].
    pub fn new(point: [f64; D], normal: [f64; D]) -> Result<Self, ShapeError> {
        check(0, point)?;
        check(1, normal)?;
        Ok(Self { point, normal: unit(normal).ok_or(ShapeError::NoNormal)? })
    }
}

/// A segment in 3D. If its ends coincide, it is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    pub(super) ends: [[f64; 3]; 2],
}

impl Segment {
    /// Makes a segment from its two ends.
    ///
    /// # Errors
    /// [`ShapeError::Coordinate`].
    pub fn new(ends: [[f64; 3]; 2]) -> Result<Self, ShapeError> {
        check_all(&ends)?;
        Ok(Self { ends })
    }
}

/// A capsule: all points within a radius of a segment, its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    pub(super) axis: Segment,
    pub(super) radius: f64,
}

impl Capsule {
    /// Makes a capsule from the two ends of its axis and its radius.
    ///
    /// # Errors
    /// [`ShapeError::Coordinate`], [`ShapeError::Radius`].
    pub fn new(ends: [[f64; 3]; 2], radius: f64) -> Result<Self, ShapeError> {
        check_radius(radius)?;
        Ok(Self { axis: Segment::new(ends)?, radius })
    }
}

/// A triangle in 2D or 3D, in either orientation. Without area it is the segment or point that its vertices
/// span.
///
/// # Example
/// ```
/// use fdem_contact::narrow::Triangle;
///
/// let a = Triangle::new([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])?;
/// let b = Triangle::new([[0.5, 0.5], [1.0, 0.5], [1.0, 1.0]])?;
/// assert!(a.touches(&b)); // in one point
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle<const D: usize> {
    pub(crate) vertices: [[f64; D]; 3],
}

impl<const D: usize> Triangle<D> {
    /// Makes a triangle from its vertices.
    ///
    /// # Errors
    /// [`ShapeError::Coordinate`].
    pub fn new(vertices: [[f64; D]; 3]) -> Result<Self, ShapeError> {
        check_all(&vertices)?;
        Ok(Self { vertices })
    }

    /// The vertices in the given order.
    pub fn vertices(&self) -> [[f64; D]; 3] {
        self.vertices
    }
}

/// A tetrahedron with its vertices in any order. Without volume it is the flat piece, segment or point that
/// its vertices span.
///
/// # Example
/// ```
/// use fdem_contact::narrow::Tetrahedron;
///
/// let a = Tetrahedron::new([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])?;
/// let b = Tetrahedron::new([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [2.0, 0.0, 1.0]])?;
/// assert!(a.touches(&b)); // in a vertex
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tetrahedron {
    pub(crate) vertices: [[f64; 3]; 4],
}

impl Tetrahedron {
    /// Makes a tetrahedron from its vertices.
    ///
    /// # Errors
    /// [`ShapeError::Coordinate`].
    pub fn new(vertices: [[f64; 3]; 4]) -> Result<Self, ShapeError> {
        check_all(&vertices)?;
        Ok(Self { vertices })
    }
}

pub(super) fn check_all<const D: usize>(vertices: &[[f64; D]]) -> Result<(), ShapeError> {
    vertices.iter().enumerate().try_for_each(|(vertex, &p)| check(vertex, p))
}

pub(super) fn check<const D: usize>(vertex: usize, p: [f64; D]) -> Result<(), ShapeError> {
    match p.iter().position(|&x| !in_range(x.abs())) {
        Some(axis) => Err(ShapeError::Coordinate { vertex, axis, value: p[axis] }),
        None => Ok(()),
    }
}

fn check_radius(value: f64) -> Result<(), ShapeError> {
    if in_range(value) { Ok(()) } else { Err(ShapeError::Radius { value }) }
}

fn in_range(x: f64) -> bool {
    x == 0.0 || (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_numbers_are_named() {
        let error = Triangle::new([[0.0, 0.0], [1.0, f64::INFINITY], [0.0, 1.0]]).unwrap_err();
        assert_eq!(error, ShapeError::Coordinate { vertex: 1, axis: 1, value: f64::INFINITY });
        for bad in [f64::NAN, 2.0 * MAX_MAGNITUDE, 0.5 * MIN_MAGNITUDE, -5e-324] {
            let error = Tetrahedron::new([[0.0; 3], [0.0; 3], [0.0; 3], [0.0, 0.0, bad]]).unwrap_err();
            assert!(matches!(error, ShapeError::Coordinate { vertex: 3, axis: 2, .. }), "{bad}");
            assert!(error.to_string().starts_with("vertex 3, axis 2: "), "{error}");
        }
        for bad in [f64::NAN, -1.0, f64::INFINITY, 1e-300] {
            assert!(matches!(Sphere::new([0.0; 2], bad), Err(ShapeError::Radius { .. })));
        }
        assert_eq!(Plane::new([0.0; 3], [0.0, -0.0, 0.0]), Err(ShapeError::NoNormal));
    }

    #[test]
    fn the_range_is_closed() {
        assert!(Segment::new([[MAX_MAGNITUDE, -MIN_MAGNITUDE, -0.0], [0.0; 3]]).is_ok());
    }
}
