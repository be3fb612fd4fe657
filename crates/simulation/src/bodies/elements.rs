//! Bodies that deform: their elements can touch.

use crate::bodies::{Bodies, PartProperties};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::vector::Point;

impl<const D: usize, const N: usize> Bodies<D> for Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Barycentric coordinates without the first, which is 1 less the others.
    type Place = [f64; D];

    fn bounds(&self, element: u32) -> [Point<D>; 2] {
        let [first, rest @ ..] = &self.shape(element)[..] else { return [[0.0; D]; 2] };
        let (mut least, mut most) = (*first, *first);
        for corner in rest {
            for axis in 0..D {
                least[axis] = least[axis].min(corner[axis]);
                most[axis] = most[axis].max(corner[axis]);
            }
        }
        [least, most]
    }

    fn velocity_on(&self, element: u32, place: &[f64; D]) -> Point<D> {
        let velocities = self.nodes_of(element).map(|node| self.velocity(node as usize));
        velocity_at(&velocities, &completed::<D, N>(place))
    }

    #[inline]
    fn properties(&self, element: u32) -> PartProperties {
        let element = self.element(element as usize);
        PartProperties { material: element.material, length: element.length, mass: element.mass }
    }

    #[inline]
    fn acts(&self, element: u32) -> bool {
        self.share().acts(element)
    }

    #[inline]
    fn counts(&self, element: u32) -> bool {
        self.share().element(element)
    }
}

/// Barycentric coordinates, from all but the first.
#[inline(always)]
pub(crate) fn completed<const D: usize, const N: usize>(rest: &[f64; D]) -> [f64; N] {
    let mut first = 1.0;
    for k in 0..D {
        first -= rest[k];
    }
    std::array::from_fn(|k| if k == 0 { first } else { rest[k - 1] })
}

/// Velocity, m/s, of an element at the point with these barycentric coordinates.
#[inline(always)]
pub(crate) fn velocity_at<const D: usize, const N: usize>(
    velocities: &[Point<D>; N],
    shares: &[f64; N],
) -> Point<D> {
    let mut velocity = [0.0; D];
    for corner in 0..N {
        for axis in 0..D {
            velocity[axis] += shares[corner] * velocities[corner][axis];
        }
    }
    velocity
}
