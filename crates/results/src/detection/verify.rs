//! Comparison of the couples of a sample of elements with brute force.

use fdem_contact::{Couple, PeriodicBox, PeriodicCouple, verify};

use crate::detection::request::DetectionRequest;
use crate::network::{Couples, Sizes, Space, unshifted};

/// [`check`](super::check), compiled where it is called.
pub(super) fn check<const D: usize>(
    space: &Space<'_, D>,
    request: &DetectionRequest<'_>,
    couples: &Couples<D>,
    sample: usize,
) -> Result<usize, String> {
    match (couples, &space.cell) {
        (Couples::Periodic(couples), Some(cell)) => check_periodic(space, cell, request, couples, sample),
        (Couples::Plain(couples), _) if matches!(request.sizes, Sizes::Pairs(_)) => {
            check_pairs(space, request, couples, sample)
        }
        (Couples::Plain(couples), _) => {
            let elements = request.elements(space.centres).expect("the elements have been searched before");
            verify(&elements, couples, sample, 0).map_err(|mismatch| mismatch.to_string())
        }
        (Couples::Periodic(_), None) => unreachable!("shifts come from a box"),
    }
}

/// Compares the couples of `sample` elements with all images of all elements. Returns the number of checked
/// elements, or a description of the mismatch.
///
/// `couples` must be in ascending order. The elements are divided into `sample` ranges, and one element of
/// each is picked, the same in every run.
fn check_periodic<const D: usize>(
    space: &Space<'_, D>,
    cell: &PeriodicBox<f64, D>,
    request: &DetectionRequest<'_>,
    couples: &[PeriodicCouple<D>],
    sample: usize,
) -> Result<usize, String> {
    let n = space.centres.len();
    // Skewed boxes are compared in the short edges in which they are searched.
    let reduced = cell.reduced();
    let cell = reduced.as_ref().map_or(cell, |reduced| &reduced.cell);
    let faulty = |couple: &&PeriodicCouple<D>| {
        couple.i > couple.j || couple.j as usize >= n || (couple.i == couple.j && couple.shift <= [0; D])
    };
    if let Some(PeriodicCouple { i, j, shift }) = couples.iter().find(faulty) {
        return Err(format!("({i}, {j}) with shift {shift:?} is not a couple"));
    }
    let picked = pick(n, sample);
    let is_picked = |element: u32| picked.binary_search(&element).is_ok();
    let listed = couples.iter().copied().filter(|couple| is_picked(couple.i) || is_picked(couple.j));

    let places: Vec<_> = (0..n as u32).map(|element| space.wrapped(cell, element)).collect();
    let fractions: Vec<_> = places.iter().map(|(point, _)| cell.fractions(point)).collect();
    let largest = (0..n).map(|index| request.sizes.radius(index)).fold(0.0, f64::max);
    // More than the largest distance of two elements in contact, by more than all rounding errors.
    let reach = (2.0 * largest + request.tolerance) * (1.0 + 1e-9);
    let margin = cell.heights().map(|height| reach / height + 1e-9);

    let mut touching = Vec::new();
    for &element in &picked {
        for other in (0..n as u32).filter(|&other| other >= element || !is_picked(other)) {
            let (i, j) = (element.min(other), element.max(other));
            let [(a, of_a), (b, of_b)] = [i, j].map(|k| places[k as usize]);
            let apart: [f64; D] =
                std::array::from_fn(|edge| fractions[i as usize][edge] - fractions[j as usize][edge]);
            for_each_shift(cell.periodic(), &apart, &margin, |image| {
                let shift = std::array::from_fn(|edge| image[edge] + of_a[edge] - of_b[edge]);
                let is_form = i < j || shift > [0; D];
                if is_form && touch(request, i, &a, j, &cell.displaced(&b, &image)) {
                    let shift = reduced.map_or(shift, |reduced| reduced.shift_of_couple([i, j], &shift));
                    touching.push(PeriodicCouple { i, j, shift });
                }
            });
        }
    }
    compare(listed, touching, picked.len())
}

/// Like [`check_periodic`], for points in open space with cut-offs by pairs of types.
fn check_pairs<const D: usize>(
    space: &Space<'_, D>,
    request: &DetectionRequest<'_>,
    couples: &[Couple],
    sample: usize,
) -> Result<usize, String> {
    let n = space.centres.len();
    let picked = pick(n, sample);
    let is_picked = |element: u32| picked.binary_search(&element).is_ok();
    let mut touching = Vec::new();
    for &element in &picked {
        for other in (0..n as u32).filter(|&other| other > element || (other < element && !is_picked(other)))
        {
            let (i, j) = (element.min(other), element.max(other));
            if touch(request, i, &space.centres[i as usize], j, &space.centres[j as usize]) {
                touching.push(unshifted::<D>(Couple { i, j }));
            }
        }
    }
    let listed = couples.iter().filter(|couple| is_picked(couple.i) || is_picked(couple.j));
    compare(listed.copied().map(unshifted::<D>), touching, picked.len())
}

/// Compares the couples of a list, in ascending order, with those that touch. Returns the number of checked
/// elements, or a description of the mismatch.
fn compare<const D: usize>(
    listed: impl Iterator<Item = PeriodicCouple<D>>,
    mut touching: Vec<PeriodicCouple<D>>,
    checked: usize,
) -> Result<usize, String> {
    touching.sort_unstable();
    let mut touching = touching.into_iter().peekable();
    for couple in listed {
        let PeriodicCouple { i, j, shift } = couple;
        if touching.next_if_eq(&couple).is_none() {
            return match touching.peek() {
                Some(missing) if *missing < couple => Err(missing_couple(*missing)),
                _ => Err(format!(
                    "elements {i} and {j} with shift {shift:?} are listed too often, or do not touch"
                )),
            };
        }
    }
    touching.next().map_or(Ok(checked), |missing| Err(missing_couple(missing)))
}

fn missing_couple<const D: usize>(couple: PeriodicCouple<D>) -> String {
    let PeriodicCouple { i, j, shift } = couple;
    format!("elements {i} and {j} touch with shift {shift:?} but are not listed")
}

/// Whether two elements touch at the given points, by the library's own comparison.
fn touch<const D: usize>(request: &DetectionRequest<'_>, i: u32, a: &[f64; D], j: u32, b: &[f64; D]) -> bool {
    let radii = [i, j].map(|element| request.sizes.radius(element as usize));
    let sizes = match request.sizes {
        Sizes::Each(_) => Sizes::Each(&radii),
        Sizes::All(radius) => Sizes::All(radius),
        Sizes::Cutoff(cutoff) => Sizes::Cutoff(cutoff),
        Sizes::Pairs(cutoffs) => match cutoffs.of(i, j) {
            Some(cutoff) => Sizes::Cutoff(cutoff),
            None => return false,
        },
    };
    let bodies = request.bodies.map(|bodies| [i, j].map(|element| bodies[element as usize]));
    let pair = [*a, *b];
    let request = DetectionRequest { sizes, bodies: bodies.as_ref().map(<[u32; 2]>::as_slice), ..*request };
    request.elements(&pair).is_ok_and(|elements| elements.touch(0, 1))
}

/// Visits all integer vectors `s` with `|apart - s| <= margin` along periodic edges and 0 along the others.
fn for_each_shift<const D: usize>(
    periodic: [bool; D],
    apart: &[f64; D],
    margin: &[f64; D],
    mut visit: impl FnMut([i32; D]),
) {
    let (mut low, mut high) = ([0; D], [0; D]);
    for edge in (0..D).filter(|&edge| periodic[edge]) {
        low[edge] = (apart[edge] - margin[edge]).ceil() as i32;
        high[edge] = (apart[edge] + margin[edge]).floor() as i32;
        if low[edge] > high[edge] {
            return;
        }
    }
    let mut shift = low;
    loop {
        visit(shift);
        // The next shift, counted like an odometer.
        let Some(edge) = (0..D).find(|&edge| shift[edge] < high[edge]) else { return };
        shift[edge] += 1;
        shift[..edge].copy_from_slice(&low[..edge]);
    }
}

/// Returns `sample` numbers below `n` in ascending order, a random one from each of `sample` equal ranges;
/// all numbers if `n` is not above `sample`.
fn pick(n: usize, sample: usize) -> Vec<u32> {
    let sample = sample.min(n);
    let mut state = 0_u64;
    let one_of = |k: usize| {
        let (from, to) =
            (k as u128 * n as u128 / sample as u128, (k as u128 + 1) * n as u128 / sample as u128);
        // Knuth's linear congruential generator is random enough to avoid patterns in the order of the
        // elements.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (from + u128::from(state >> 33) % (to - from)) as u32
    };
    (0..sample).map(one_of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shifts(apart: [f64; 2], margin: f64, periodic: [bool; 2]) -> Vec<[i32; 2]> {
        let mut shifts = Vec::new();
        for_each_shift(periodic, &apart, &[margin; 2], |shift| shifts.push(shift));
        shifts
    }

    #[test]
    fn shifts_are_all_within_the_margin() {
        assert_eq!(shifts([0.9, 0.0], 0.2, [true; 2]), [[1, 0]]);
        assert_eq!(shifts([0.5, 0.0], 0.2, [true; 2]), [[0; 2]; 0]);
        assert_eq!(shifts([0.5, 0.0], 0.2, [false, true]), [[0, 0]]);
        assert_eq!(shifts([0.5, -0.5], 0.6, [true; 2]), [[0, -1], [1, -1], [0, 0], [1, 0]]);
    }

    #[test]
    fn a_sample_is_spread_over_all_elements() {
        assert_eq!(pick(3, 9), [0, 1, 2]);
        assert_eq!(pick(0, 9), [0; 0]);
        let picked = pick(1000, 10);
        assert!(picked.iter().zip(0..).all(|(&element, k)| element / 100 == k), "{picked:?}");
    }

    /// Every kind of mistake is found among four points in a periodic square, each at a distance of 1 from
    /// its neighbours.
    #[test]
    fn mistakes_are_found() {
        let centres = [[0.5, 0.5], [1.5, 0.5], [0.5, 3.5], [1.5, -0.5]];
        let cell = PeriodicBox::orthogonal([0.0, 0.0], [2.0, 2.0], [true, true]).unwrap();
        let space = Space { centres: &centres, cell: Some(cell) };
        let request = DetectionRequest {
            sizes: Sizes::Cutoff(1.0),
            tolerance: 0.0,
            bodies: None,
            engine: None,
            device: None,
            threads: 1,
            keep: true,
        };
        let couple = |i, j, shift| PeriodicCouple { i, j, shift };
        // Element 2 lies above the square, element 3 below it.
        let mut right = vec![
            couple(0, 1, [0, 0]),
            couple(0, 1, [-1, 0]),
            couple(0, 2, [0, -2]),
            couple(0, 2, [0, -1]),
            couple(1, 3, [0, 0]),
            couple(1, 3, [0, 1]),
            couple(2, 3, [0, 2]),
            couple(2, 3, [-1, 2]),
        ];
        right.sort_unstable();
        let checked = |couples: &[PeriodicCouple<2>]| check_periodic(&space, &cell, &request, couples, 9);
        assert_eq!(checked(&right), Ok(4));
        for k in 0..right.len() {
            assert_eq!(space.distance(right[k]), 1.0);
            let (mut fewer, mut twice) = (right.clone(), right.clone());
            fewer.remove(k);
            twice.insert(k, right[k]);
            assert!(checked(&fewer).unwrap_err().contains("not listed"), "{k}");
            assert!(checked(&twice).unwrap_err().contains("too often"), "{k}");
        }
        let with = |wrong| {
            let mut couples = right.clone();
            couples.push(wrong);
            couples.sort_unstable();
            checked(&couples).unwrap_err()
        };
        assert!(with(couple(0, 1, [0, 1])).contains("too often"));
        assert!(with(couple(1, 1, [-1, 0])).contains("not a couple"));
        assert!(with(couple(2, 1, [0, 0])).contains("not a couple"));
        assert!(with(couple(2, 4, [0, 0])).contains("not a couple"));
    }
}
