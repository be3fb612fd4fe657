//! Detections: the couples of a packing with their statistics, and their comparison with brute force.
//!
//! They are compiled in this crate for the plane and for space: a run over all couples must be optimised, and
//! the crate of the command is not.

mod device;
mod request;
mod verify;

use std::any::Any;
use std::sync::atomic::{AtomicU64, Ordering};

use fdem_contact::{
    Couple, Detector, Elements, Error, PeriodicBox, PeriodicCouple, PeriodicSearch, Plan, Search,
};

pub use crate::detection::device::{DeviceSearch, SearchOfDevice};
pub use crate::detection::request::DetectionRequest;
use crate::network::{Couples, Sizes, Space, unshifted};

/// Result of a detection.
#[derive(Debug)]
pub struct Detection<const D: usize> {
    /// Couples in ascending order; empty unless the request keeps them.
    pub couples: Couples<D>,
    /// Plan of the search. In a periodic box it is the plan for the wrapped elements without images.
    pub plan: Plan<D>,
    /// Statistics of the couples.
    pub statistics: Statistics<D>,
}

/// Statistics of the couples. They do not depend on the order of the couples.
#[derive(Debug, PartialEq)]
pub struct Statistics<const D: usize> {
    /// Number of couples.
    pub couples: u64,
    /// Number of couples of an element with its own image in a periodic box.
    pub own_images: u64,
    /// Number of couples of an element with a periodic image of another one at the same place: the packing
    /// lists an element and its image.
    pub repeated: u64,
    /// The first of them.
    pub first_repeated: Option<PeriodicCouple<D>>,
    /// Whether each element has a contact.
    touched: Vec<bool>,
    /// Largest overlap and its couple, the first one if several couples have it.
    pub max_overlap: Option<(f64, PeriodicCouple<D>)>,
}

impl<const D: usize> Statistics<D> {
    fn new(elements: usize) -> Self {
        Self {
            couples: 0,
            own_images: 0,
            repeated: 0,
            first_repeated: None,
            touched: vec![false; elements],
            max_overlap: None,
        }
    }

    fn add(&mut self, couple: PeriodicCouple<D>, overlap: f64) {
        self.couples += 1;
        self.own_images += u64::from(couple.i == couple.j);
        self.touched[couple.i as usize] = true;
        self.touched[couple.j as usize] = true;
        let larger = |&(largest, first): &(f64, PeriodicCouple<D>)| {
            overlap > largest || (overlap == largest && couple < first)
        };
        if self.max_overlap.as_ref().is_none_or(larger) {
            self.max_overlap = Some((overlap, couple));
        }
    }

    /// Counts an element and an image of another one at the same place.
    fn add_repeated(&mut self, couple: PeriodicCouple<D>) {
        self.repeated += 1;
        self.first_repeated = Some(self.first_repeated.map_or(couple, |first| first.min(couple)));
    }

    /// Elements without any contact.
    pub fn rattlers(&self) -> u64 {
        self.touched.iter().filter(|&&touched| !touched).count() as u64
    }

    /// Mean number of contacts of an element: two per couple.
    pub fn mean_coordination(&self) -> f64 {
        if self.touched.is_empty() { 0.0 } else { 2.0 * self.couples as f64 / self.touched.len() as f64 }
    }
}

/// Finds the couples. `position` counts them for the progress display.
///
/// # Errors
/// The errors of the search.
pub fn detect<const D: usize>(
    space: &Space<'_, D>,
    request: &DetectionRequest<'_>,
    position: &AtomicU64,
) -> Result<Detection<D>, Error> {
    fn plane(
        space: &Space<'_, 2>,
        request: &DetectionRequest<'_>,
        position: &AtomicU64,
    ) -> Result<Detection<2>, Error> {
        detect_in(space, request, position)
    }

    fn volume(
        space: &Space<'_, 3>,
        request: &DetectionRequest<'_>,
        position: &AtomicU64,
    ) -> Result<Detection<3>, Error> {
        detect_in(space, request, position)
    }

    match D {
        2 => same(plane(&of_dimension(space), request, position)),
        3 => same(volume(&of_dimension(space), request, position)),
        _ => detect_in(space, request, position),
    }
}

/// Compares the couples of `sample` elements with brute force. Returns the number of checked elements.
///
/// The sample is the same in every call, so that an error can be reproduced.
///
/// # Errors
/// A description of the mismatch.
///
/// # Panics
/// If these elements were not searched before.
pub fn check<const D: usize>(
    space: &Space<'_, D>,
    request: &DetectionRequest<'_>,
    couples: &Couples<D>,
    sample: usize,
) -> Result<usize, String> {
    fn plane(
        space: &Space<'_, 2>,
        request: &DetectionRequest<'_>,
        couples: &Couples<2>,
        sample: usize,
    ) -> Result<usize, String> {
        verify::check(space, request, couples, sample)
    }

    fn volume(
        space: &Space<'_, 3>,
        request: &DetectionRequest<'_>,
        couples: &Couples<3>,
        sample: usize,
    ) -> Result<usize, String> {
        verify::check(space, request, couples, sample)
    }

    match D {
        2 => plane(&of_dimension(space), request, same_reference(couples), sample),
        3 => volume(&of_dimension(space), request, same_reference(couples), sample),
        _ => verify::check(space, request, couples, sample),
    }
}

/// The same space, whose dimension the caller knows to be `E`.
fn of_dimension<'a, const D: usize, const E: usize>(space: &Space<'a, D>) -> Space<'a, E> {
    space.of_dimension().expect("the dimensions are equal")
}

/// The same value, whose type the caller knows to be `B`.
fn same<A: 'static, B: 'static>(value: A) -> B {
    let mut slot = Some(value);
    let same = (&mut slot as &mut dyn Any).downcast_mut::<Option<B>>().expect("the dimensions are equal");
    same.take().expect("the value was put there")
}

/// A reference to the same value, whose type the caller knows to be `B`.
fn same_reference<A: 'static, B: 'static>(value: &A) -> &B {
    (value as &dyn Any).downcast_ref().expect("the dimensions are equal")
}

/// [`detect`], compiled where it is called.
fn detect_in<const D: usize>(
    space: &Space<'_, D>,
    request: &DetectionRequest<'_>,
    position: &AtomicU64,
) -> Result<Detection<D>, Error> {
    let elements = request.elements(space.centres)?;
    let mut statistics = Statistics::new(elements.len());
    // Images of files with few digits differ by rounding.
    let near = space.cell.map_or(0.0, |cell| 1e-6 * cell.heights().into_iter().fold(f64::INFINITY, f64::min));
    let add = |couple: PeriodicCouple<D>| {
        statistics.add(couple, space.overlap(request.sizes, couple));
        if couple.shift != [0; D] && couple.i != couple.j && space.distance(couple) <= near {
            statistics.add_repeated(couple);
        }
        position.store(statistics.couples, Ordering::Relaxed);
    };
    let (couples, plan) = match &space.cell {
        None => detect_open(space, &elements, request, add),
        Some(cell) => detect_periodic(space, cell, &elements, request, add),
    }?;
    Ok(Detection { couples, plan, statistics })
}

fn detect_open<const D: usize>(
    space: &Space<'_, D>,
    elements: &Elements<'_, f64, D>,
    request: &DetectionRequest<'_>,
    mut add: impl FnMut(PeriodicCouple<D>),
) -> Result<(Couples<D>, Plan<D>), Error> {
    let mut detector = Detector::new().with_engine(request.engine).with_threads(request.threads)?;
    let plan = detector.plan(elements)?;
    let mut couples = Vec::new();
    if request.keep || request.device.is_some() {
        match request.device {
            None => detector.couples(elements, &mut couples)?,
            Some(device) => couples = on_device(space, device, request)?,
        }
        if let Sizes::Pairs(_) = request.sizes {
            couples.retain(|couple| request.keeps(space, unshifted(*couple)));
        }
        couples.sort_unstable();
        couples.iter().copied().map(unshifted).for_each(add);
    } else {
        detector.for_each(elements, |couple| {
            let couple = unshifted(couple);
            if request.keeps(space, couple) {
                add(couple);
            }
        })?;
    }
    Ok((Couples::Plain(couples), plan))
}

/// The couples that a device finds.
fn on_device<const D: usize>(
    space: &Space<'_, D>,
    device: &dyn DeviceSearch,
    request: &DetectionRequest<'_>,
) -> Result<Vec<Couple>, Error> {
    match D {
        2 => device.plane(&request.elements(of_dimension::<D, 2>(space).centres)?),
        3 => device.space(&request.elements(of_dimension::<D, 3>(space).centres)?),
        _ => Err(other_dimensions()),
    }
}

/// The couples that a device finds in a periodic box.
fn on_device_in_box<const D: usize>(
    space: &Space<'_, D>,
    device: &dyn DeviceSearch,
    request: &DetectionRequest<'_>,
) -> Result<Vec<PeriodicCouple<D>>, Error> {
    match D {
        2 => {
            let Space { centres, cell } = of_dimension::<D, 2>(space);
            let images = PeriodicSearch::new().with_threads(request.threads)?;
            device.plane_in_box(&request.elements(centres)?, &cell.expect(IN_BOX), images).map(same)
        }
        3 => {
            let Space { centres, cell } = of_dimension::<D, 3>(space);
            let images = PeriodicSearch::new().with_threads(request.threads)?;
            device.space_in_box(&request.elements(centres)?, &cell.expect(IN_BOX), images).map(same)
        }
        _ => Err(other_dimensions()),
    }
}

const IN_BOX: &str = "the elements are in a periodic box";

fn other_dimensions() -> Error {
    Error::Device { message: "a device searches in two and three dimensions".to_owned() }
}

fn detect_periodic<const D: usize>(
    space: &Space<'_, D>,
    cell: &PeriodicBox<f64, D>,
    elements: &Elements<'_, f64, D>,
    request: &DetectionRequest<'_>,
    mut add: impl FnMut(PeriodicCouple<D>),
) -> Result<(Couples<D>, Plan<D>), Error> {
    let mut search = PeriodicSearch::new().with_engine(request.engine).with_threads(request.threads)?;
    let mut couples = Vec::new();
    if request.keep || request.device.is_some() {
        match request.device {
            None => search.couples(elements, cell, &mut couples)?,
            Some(device) => couples = on_device_in_box(space, device, request)?,
        }
        if let Sizes::Pairs(_) = request.sizes {
            couples.retain(|couple| request.keeps(space, *couple));
        }
        couples.sort_unstable();
        couples.iter().copied().for_each(add);
    } else {
        search.for_each(elements, cell, |couple| {
            if request.keeps(space, couple) {
                add(couple);
            }
        })?;
    }
    drop(search);
    let plan = plan_of_wrapped(space, cell, request)?;
    Ok((Couples::Periodic(couples), plan))
}

/// The plan for the elements, wrapped into the box, without images.
fn plan_of_wrapped<const D: usize>(
    space: &Space<'_, D>,
    cell: &PeriodicBox<f64, D>,
    request: &DetectionRequest<'_>,
) -> Result<Plan<D>, Error> {
    let mut wrapped = Vec::new();
    let out_of_memory = |_| Error::OutOfMemory { bytes: size_of_val(space.centres) };
    wrapped.try_reserve_exact(space.centres.len()).map_err(out_of_memory)?;
    wrapped
        .extend(space.centres.iter().map(|&centre| cell.wrap(centre).map_or(centre, |(inside, _)| inside)));
    Detector::new().with_engine(request.engine).plan(&request.elements(&wrapped)?)
}

/// Checks the elements as a search does.
///
/// # Errors
/// Elements that a search would refuse.
pub fn check_elements<const D: usize>(
    space: &Space<'_, D>,
    request: &DetectionRequest<'_>,
) -> Result<(), Error> {
    checked_elements(space, request).map(|_| ())
}

fn checked_elements<'a, const D: usize>(
    space: &'a Space<'_, D>,
    request: &'a DetectionRequest<'_>,
) -> Result<Elements<'a, f64, D>, Error> {
    let elements = request.elements(space.centres)?;
    if let Some(cell) = &space.cell {
        check_wrapped(space.centres, cell)?;
    }
    Ok(elements)
}

/// The detection of couples that are known, as those of a file: nothing is searched.
///
/// # Errors
/// Elements that a search would refuse.
///
/// # Panics
/// If a couple is not one of these elements.
pub fn given<const D: usize>(
    space: &Space<'_, D>,
    request: &DetectionRequest<'_>,
    couples: Couples<D>,
) -> Result<Detection<D>, Error> {
    let elements = checked_elements(space, request)?;
    let plan = match &space.cell {
        None => Detector::new().plan(&elements),
        Some(cell) => plan_of_wrapped(space, cell, request),
    }?;
    let mut statistics = Statistics::new(elements.len());
    for couple in couples.iter() {
        statistics.add(couple, space.overlap(request.sizes, couple));
    }
    Ok(Detection { couples, plan, statistics })
}

/// Refuses centres whose periods cannot be counted.
fn check_wrapped<const D: usize>(centres: &[[f64; D]], cell: &PeriodicBox<f64, D>) -> Result<(), Error> {
    /// The limit of [`PeriodicBox::wrap`].
    const LIMIT: f64 = (1_u32 << 28) as f64;
    let Some(index) = centres.iter().position(|&centre| cell.wrap(centre).is_none()) else { return Ok(()) };
    let (fractions, periodic) = (cell.fractions(&centres[index]), cell.periodic());
    let edge = (0..D).find(|&edge| periodic[edge] && fractions[edge].abs() > LIMIT).unwrap_or(0);
    Err(Error::TooFarFromBox { index, edge, periods: fractions[edge], limit: LIMIT })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdem_contact::{Couple, Engine, Rows};

    /// A device that searches as one does: with another search, and images from the processor.
    #[derive(Debug)]
    struct OtherRows;

    impl SearchOfDevice for OtherRows {
        type In<'d, const D: usize> = Rows<f64, D>;

        fn search<const D: usize>(&self) -> Rows<f64, D> {
            Rows::new()
        }
    }

    /// With and without a box and bodies, and if couples are not kept, a device has the same detection.
    #[test]
    fn a_device_has_the_detection_of_the_processor() {
        fn compare<const D: usize>(periodic: [bool; D]) -> u64 {
            let place = |k: usize| (k * k * 7 + k * 31) as f64 % 50.0 * 0.2;
            let centres: Vec<[f64; D]> =
                (0..400).map(|k| std::array::from_fn(|axis| place(k + 11 * axis) - 0.5)).collect();
            let radii: Vec<f64> = (0..400).map(|k| 0.2 + 0.01 * f64::from(k % 30)).collect();
            let bodies: Vec<u32> = (0..400).map(|k| k % 3).collect();
            let cell = PeriodicBox::orthogonal([0.0; D], [10.0; D], periodic).unwrap();
            let mut couples = 0;
            for (cell, bodies, keep) in
                [(None, None, true), (Some(cell), None, true), (Some(cell), Some(&bodies[..]), false)]
            {
                let space = Space { centres: &centres, cell };
                let on_processor = DetectionRequest {
                    sizes: Sizes::Each(&radii),
                    tolerance: 0.05,
                    bodies,
                    engine: Some(Engine::Rows),
                    device: None,
                    threads: 1,
                    keep: true,
                };
                let on_device = DetectionRequest { device: Some(&OtherRows), keep, ..on_processor };
                let [expected, found] = [on_processor, on_device]
                    .map(|request| detect(&space, &request, &AtomicU64::new(0)).unwrap());
                assert_eq!(found.statistics, expected.statistics);
                assert_eq!(found.couples, expected.couples);
                couples += found.statistics.couples;
            }
            couples
        }
        assert!(compare([true, true]) > 1000);
        assert!(compare([true, false, true]) > 100);
    }

    /// The largest overlap does not depend on the order of the couples.
    #[test]
    fn statistics_do_not_depend_on_order() {
        let couples = [(0, 1, 0.5), (1, 2, 0.75), (3, 4, 0.75), (0, 4, 0.25)];
        let mut forward = Statistics::<2>::new(6);
        let mut backward = Statistics::new(6);
        for &(i, j, overlap) in &couples {
            forward.add(unshifted(Couple { i, j }), overlap);
        }
        for &(i, j, overlap) in couples.iter().rev() {
            backward.add(unshifted(Couple { i, j }), overlap);
        }
        assert_eq!(forward, backward);
        assert_eq!(forward.max_overlap, Some((0.75, unshifted(Couple { i: 1, j: 2 }))));
        assert_eq!(forward.rattlers(), 1);
        assert_eq!(forward.mean_coordination(), 8.0 / 6.0);
    }
}
