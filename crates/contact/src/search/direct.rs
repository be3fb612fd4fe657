//! Direct checking: every element against every other.

use crate::compiled::compiled;
use crate::couple::Couple;
use crate::elements::{Elements, Shape};
use crate::error::Error;
use crate::filter::Filter;
use crate::geometry::{Filtered, Geometry};
use crate::real::Real;
use crate::search::Search;
use crate::stop::Stop;

/// Direct checking: every element is tested against every other, in any dimension.
///
/// The reference that all tests compare with, and the fastest engine for a few dozen elements. Couples come
/// in ascending order.
///
/// # Cost
/// `(N² - N)/2` tests; no memory.
///
/// # Source
/// A. Munjiza, "The Combined Finite-Discrete Element Method", Wiley 2004, pp. 77-80, (3.9) and (3.69).
/// Departure: the comparison is closed (`<=`), by the book's own definition of contact as "touch or overlap".
#[derive(Clone, Copy, Debug, Default)]
pub struct Direct;

impl<T: Real, const D: usize> Search<T, D> for Direct {
    fn for_each(&mut self, elements: &Elements<'_, T, D>, visit: impl FnMut(Couple)) -> Result<(), Error> {
        DirectUntil::default().for_each(elements, visit)
    }
}

/// [`Direct`] until it is stopped.
#[derive(Clone, Debug, Default)]
pub(crate) struct DirectUntil(pub(crate) Stop);

impl<T: Real, const D: usize> Search<T, D> for DirectUntil {
    fn for_each(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(Couple),
    ) -> Result<(), Error> {
        search(self, elements, &mut visit)
    }
}

compiled!(fn search = DirectUntil, DirectUntil, DirectUntil: all(&mut dyn FnMut(Couple)));

impl DirectUntil {
    fn all<T: Real, const D: usize>(
        &mut self,
        elements: &Elements<'_, T, D>,
        visit: &mut dyn FnMut(Couple),
    ) -> Result<(), Error> {
        match elements.shape {
            Shape::Equal(equal) => self.filtered(equal, elements.filter(), visit),
            Shape::Spheres(spheres) => self.filtered(spheres, elements.filter(), visit),
            Shape::Boxes(boxes) => self.filtered(boxes, elements.filter(), visit),
        }
    }

    fn filtered(
        &self,
        geometry: impl Geometry,
        filter: Option<Filter<'_>>,
        visit: &mut dyn FnMut(Couple),
    ) -> Result<(), Error> {
        match filter {
            None => all_against_all(geometry, &self.0, visit),
            Some(filter) => all_against_all(Filtered { geometry, filter }, &self.0, visit),
        }
    }
}

fn all_against_all(geometry: impl Geometry, stop: &Stop, visit: &mut dyn FnMut(Couple)) -> Result<(), Error> {
    let n = geometry.len();
    for i in 0..n {
        stop.go_on()?;
        for j in i + 1..n {
            if geometry.touch(i, j) {
                visit(Couple { i: i as u32, j: j as u32 });
            }
        }
    }
    Ok(())
}
