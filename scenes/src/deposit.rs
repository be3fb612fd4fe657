//! Discs that are dropped one after another and roll to rest.

use crate::bed::Bed;
use crate::cloud::Cloud;
use crate::error::{Error, positive};
use crate::random::{CENTRES, Random};
use crate::sizes::Sizes;

/// Largest number of free falls and changes of support of a disc before it is dropped again.
const MAX_MOVES: usize = 10_000;
/// Number of places at which a disc is dropped before the scene is given up.
const MAX_DROPS: usize = 100;
/// Sine of the angle by which rounding may place a touching disc behind a rolling one. Where circles graze
/// each other, rounding errors grow to their square root, about 1e-8.
const BEHIND: f64 = 1e-7;
/// Largest overlap of discs at rest through rounding, before compression, as a fraction of the sum of their
/// radii.
const OVERLAP: f64 = 1e-9;

/// A bed of discs under gravity: each disc falls at a random place, rolls down over others, and comes to
/// rest.
///
/// A disc rests on the floor, or on two supports, one on either side of it: discs or a wall. Discs are placed
/// one at a time and never move again, so each has about four contacts. Every position follows in closed form
/// from touching circles. Without compression, contacts are exact up to rounding (no overlap above 1e-9 of
/// the sum of the radii). With compression, all centres are scaled by `1 − compression`, so touching discs
/// overlap by that fraction of the sum of their radii, and floor and walls overlap the discs that touch them
/// in the same way: the box `0 <= x <= width`, `y >= 0` is the box after compression.
///
/// # Shapes
/// `n` centres and radii in the order of dropping: every disc is supported by earlier ones.
///
/// # Units
/// `width` shares the unit of `sizes`; `compression` is a number, 1e-3 for a bed under light load.
///
/// # Cost
/// Time proportional to `n`, about a microsecond per disc; memory for the arrays and a look-up grid, some 200
/// bytes per disc.
///
/// # Errors
/// [`Error::OutOfRange`] if `width` is not positive or `compression` is not in `[0, 1)`; [`Error::TooNarrow`]
/// if a disc is wider than the box; the errors of [`Sizes::radii`]; [`Error::OutOfMemory`]; [`Error::NoRest`]
/// if a disc dropped at a hundred places never came to rest without overlap, which has not been observed.
///
/// # Source
/// W. M. Visscher, M. Bolsterli, "Random packing of equal and unequal spheres in two and three dimensions",
/// Nature 239 (1972) 504–507. Departures: walls instead of periodic sides; a disc takes the first place it
/// finds, not the lowest of several.
///
/// # Example
/// ```
/// use fdem_scenes::{Sizes, deposit};
///
/// let bed = deposit(200, 3, Sizes::Lognormal { median: 0.5, sigma: 0.3 }, 15.0, 1e-3)?;
/// assert!(bed.centres.iter().all(|c| c[1] > 0.0 && (0.0..15.0).contains(&c[0])));
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
pub fn deposit(n: usize, seed: u64, sizes: Sizes, width: f64, compression: f64) -> Result<Cloud<2>, Error> {
    positive("width", width)?;
    if !(0.0..1.0).contains(&compression) {
        return Err(Error::OutOfRange { what: "compression", value: compression, limit: "in [0, 1)" });
    }
    let scale = 1.0 - compression;
    let room = positive("width before compression", width / scale)?;
    let radii = sizes.radii(n, seed)?;
    for radius in &radii {
        if 2.0 * radius > room {
            return Err(Error::TooNarrow { what: "a disc", required: 2.0 * radius, room });
        }
    }
    let mut random = Random::with_stream(seed, CENTRES);
    let mut bed = Bed::new(&radii, room)?;
    for (index, &radius) in radii.iter().enumerate() {
        let rest = (0..MAX_DROPS).find_map(|_| {
            let x = random.between(radius, room - radius);
            settle(&bed, x, radius).filter(|&place| is_free(&bed, place, radius))
        });
        bed.add(rest.ok_or(Error::NoRest { index })?, radius)?;
    }
    let mut centres = bed.centres;
    for centre in &mut centres {
        *centre = centre.map(|x| x * scale);
    }
    Ok(Cloud { centres, radii })
}

/// The event that ends the roll of one disc over another.
#[derive(Clone, Copy)]
enum End {
    /// The rolling disc loses contact at the height of its support and falls.
    Fall,
    /// It reaches the floor or a wall and rests.
    Rest,
    /// It touches a further disc.
    Meet(usize),
}

/// The position where a disc dropped at `x` comes to rest, if there is one.
fn settle(bed: &Bed, x: f64, radius: f64) -> Option<[f64; 2]> {
    let mut place = [x, f64::INFINITY];
    let mut support = None;
    for _ in 0..MAX_MOVES {
        let (pivot, side) = match support {
            Some(support) => support,
            None => match bed.fall(place, radius) {
                Some((height, pivot)) if height > radius => {
                    place[1] = height;
                    (pivot, if place[0] < bed.centres[pivot][0] { -1.0 } else { 1.0 })
                }
                _ => return Some([place[0], radius]),
            },
        };
        let (next, end) = roll(bed, place, radius, pivot, side);
        place = next;
        support = match end {
            End::Rest => return Some(place),
            End::Fall => None,
            // A disc rests between two supports. A disc behind the rolling one becomes its new pivot.
            End::Meet(disc) if side * (bed.centres[disc][0] - place[0]) >= 0.0 => return Some(place),
            End::Meet(disc) => Some((disc, side)),
        };
    }
    None
}

/// Rolls a disc at `place` down over `pivot`, to the right if `side` is 1 and to the left if it is −1.
///
/// The centre moves on a circle around the pivot, from `place` down to at most the height of the pivot.
/// Points of that quarter circle are measured from the pivot. `progress`, the squared distance of the centres
/// times the sine of the angle rolled, shows which of several events comes first.
fn roll(bed: &Bed, place: [f64; 2], radius: f64, pivot: usize, side: f64) -> ([f64; 2], End) {
    let [cx, cy] = bed.centres[pivot];
    let reach = radius + bed.radii[pivot];
    let start = [place[0] - cx, place[1] - cy];
    let progress = |to: [f64; 2]| side * (start[1] * to[0] - start[0] * to[1]);
    let on_circle = |leg: f64| (reach * reach - leg * leg).max(0.0).sqrt();

    let level = [side * reach, 0.0];
    let mut first = (progress(level), level, End::Fall);
    let mut offer = |to: [f64; 2], end: End| {
        let after = progress(to);
        if after < first.0 && after >= -BEHIND * reach * reach {
            first = (after, to, end);
        }
    };
    let to_floor = radius - cy;
    if to_floor > 0.0 {
        offer([side * on_circle(to_floor), to_floor], End::Rest);
    }
    let to_wall = if side > 0.0 { bed.room - radius - cx } else { radius - cx };
    if side * to_wall < reach {
        offer([to_wall, on_circle(to_wall)], End::Rest);
    }
    let far = cx + side * reach;
    let min = [far.min(place[0]) - radius, cy - radius];
    let max = [far.max(place[0]) + radius, place[1] + radius];
    bed.meet(min, max, |disc| {
        let other = bed.centres[disc];
        let between = [other[0] - cx, other[1] - cy];
        let square = between[0] * between[0] + between[1] * between[1];
        if disc == pivot || square == 0.0 {
            return;
        }
        // The circles around both discs cross where `along` of the line between their centres meets `across`.
        let touch = radius + bed.radii[disc];
        let along = 0.5 * (square + (reach - touch) * (reach + touch)) / square;
        let across_square = reach * reach / square - along * along;
        if across_square < 0.0 {
            return;
        }
        let across = across_square.sqrt();
        for across in [across, -across] {
            let to = [along * between[0] - across * between[1], along * between[1] + across * between[0]];
            // One of the two crossings leads into the disc, the other out of it.
            let heading = [side * to[1], -side * to[0]];
            let into = heading[0] * (between[0] - to[0]) + heading[1] * (between[1] - to[1]) > 0.0;
            if into && to[1] >= 0.0 {
                offer(to, End::Meet(disc));
            }
        }
    });
    let (_, to, end) = first;
    let mut place = [cx + to[0], cy + to[1]];
    // The coordinate at floor and walls is known without rounding.
    match end {
        End::Fall => place[1] = cy,
        End::Rest if to[1] == to_floor => place[1] = radius,
        End::Rest => place[0] = if side > 0.0 { bed.room - radius } else { radius },
        End::Meet(_) => {}
    }
    (place, end)
}

/// Whether a disc may rest at `place`: inside the box and clear of all others, up to rounding.
fn is_free(bed: &Bed, place: [f64; 2], radius: f64) -> bool {
    let slack = OVERLAP * radius;
    let inside =
        place[0] >= radius - slack && place[0] <= bed.room - radius + slack && place[1] >= radius - slack;
    let mut free = inside;
    bed.meet(place.map(|x| x - radius), place.map(|x| x + radius), |disc| {
        let [x, y] = bed.centres[disc];
        let least = (radius + bed.radii[disc]) * (1.0 - OVERLAP);
        let square = (place[0] - x) * (place[0] - x) + (place[1] - y) * (place[1] - y);
        free &= square >= least * least;
    });
    free
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: [Sizes; 3] = [
        Sizes::Equal { radius: 0.5 },
        Sizes::Lognormal { median: 0.5, sigma: 0.3 },
        Sizes::PowerLaw { min: 0.2, max: 4.0, exponent: -2.5 },
    ];

    fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    /// Discs of radius 1, dropped next to or onto resting discs, in a box of width 20; right triangles give
    /// the expected positions.
    #[test]
    fn single_discs_settle_where_geometry_says() {
        let settled = |resting: &[([f64; 2], f64)], x: f64| {
            let radii: Vec<f64> = resting.iter().map(|disc| disc.1).collect();
            let mut bed = Bed::new(&radii, 20.0).unwrap();
            for &(centre, radius) in resting {
                bed.add(centre, radius).unwrap();
            }
            settle(&bed, x, 1.0).unwrap()
        };
        let close = |found: [f64; 2], expected: [f64; 2]| {
            assert!(distance(found, expected) < 1e-14, "{found:?} for {expected:?}");
        };
        // Nothing is below: the disc reaches the floor.
        close(settled(&[([5.0, 1.0], 1.0)], 9.0), [9.0, 1.0]);
        // Over a smaller disc down to the floor: 1.25² = 1² + 0.75².
        close(settled(&[([5.0, 0.25], 0.25)], 5.5), [6.0, 1.0]);
        close(settled(&[([5.0, 0.25], 0.25)], 4.5), [4.0, 1.0]);
        // Over a larger disc to its height, then down: the centre stays 2 + 1 beside it.
        close(settled(&[([5.0, 2.0], 2.0)], 5.5), [8.0, 1.0]);
        // Between a disc and a wall: 2.5² = 2² + 1.5².
        close(settled(&[([3.0, 1.5], 1.5)], 2.9), [1.0, 3.0]);
        close(settled(&[([17.0, 1.5], 1.5)], 17.1), [19.0, 3.0]);
        // Between two discs whose centres are 3 apart: 2.5² = 1.5² + 2².
        close(settled(&[([5.0, 1.5], 1.5), ([8.0, 1.5], 1.5)], 5.1), [6.5, 3.5]);
        // From disc to disc down a slope to the floor: 2² = 1.6² + 1.2² on the lower one, then free fall
        // beside it.
        close(settled(&[([8.0, 1.0], 1.0), ([6.8, 2.6], 1.0)], 6.9), [10.0, 1.0]);
    }

    #[test]
    fn every_disc_rests_on_the_floor_or_between_two_supports() {
        let (width, compression) = (25.0, 1e-3);
        let touches = 1.0 - compression * (1.0 - 1e-5);
        for sizes in SIZES {
            let bed = deposit(800, 41, sizes, width, compression).unwrap();
            for (i, &[x, y]) in bed.centres.iter().enumerate() {
                let r = bed.radii[i];
                if y <= r * touches {
                    continue;
                }
                let (mut left, mut right) = (x <= r * touches, width - x <= r * touches);
                for j in 0..i {
                    if distance([x, y], bed.centres[j]) <= (r + bed.radii[j]) * touches {
                        left |= bed.centres[j][0] <= x;
                        right |= bed.centres[j][0] >= x;
                    }
                }
                assert!(left && right, "{sizes:?}: disc {i} at {x}, {y} of radius {r}");
            }
        }
    }

    #[test]
    fn overlaps_are_bounded_by_the_compression() {
        let width = 25.0;
        for (sizes, compression) in SIZES.into_iter().zip([1e-3, 0.0, 1e-2]) {
            let bed = deposit(800, 42, sizes, width, compression).unwrap();
            let least = (1.0 - compression) * (1.0 - 2e-9);
            for (i, &[x, y]) in bed.centres.iter().enumerate() {
                let r = bed.radii[i];
                assert!(x >= r * least && width - x >= r * least - 1e-12 && y >= r * least, "{sizes:?}: {i}");
                for j in 0..i {
                    let reach = r + bed.radii[j];
                    assert!(distance([x, y], bed.centres[j]) >= reach * least, "{sizes:?}: {i} and {j}");
                }
            }
        }
    }

    #[test]
    fn discs_touch_about_four_others() {
        for sizes in SIZES {
            let n = 1_500;
            let bed = deposit(n, 43, sizes, 40.0, 1e-3).unwrap();
            let mut contacts = 0;
            for i in 0..n {
                for j in 0..i {
                    let reach = bed.radii[i] + bed.radii[j];
                    contacts +=
                        usize::from(distance(bed.centres[i], bed.centres[j]) <= reach * (1.0 - 0.999e-3));
                }
            }
            let mean = 2.0 * contacts as f64 / n as f64;
            // Walls and floor reduce the number; symmetric positions of equal discs increase it.
            assert!((3.7..=4.2).contains(&mean), "{sizes:?}: {mean}");
        }
    }

    #[test]
    fn bed_is_dense() {
        let (n, width) = (2_000, 30.0);
        let bed = deposit(n, 44, SIZES[1], width, 1e-3).unwrap();
        // The area of discs and parts of discs below a height well under the surface, compared with the box
        // below that height.
        let level = 40.0;
        let filled: f64 = (0..n)
            .filter(|&i| bed.centres[i][1] < level)
            .map(|i| std::f64::consts::PI * bed.radii[i] * bed.radii[i])
            .sum();
        let top = bed.centres.iter().map(|c| c[1]).fold(0.0, f64::max);
        assert!(top > level + 5.0, "{top}");
        let fraction = filled / (level * width);
        assert!((0.74..0.86).contains(&fraction), "{fraction}");
    }

    #[test]
    fn a_tower_stands_in_a_box_one_disc_wide() {
        let bed = deposit(5, 1, Sizes::Equal { radius: 0.5 }, 1.0, 0.0).unwrap();
        for (i, centre) in bed.centres.iter().enumerate() {
            assert_eq!(*centre, [0.5, i as f64 + 0.5]);
        }
    }

    #[test]
    fn a_wide_box_holds_a_single_layer() {
        let bed = deposit(50, 2, Sizes::Equal { radius: 0.5 }, 1e9, 0.0).unwrap();
        assert!(bed.centres.iter().all(|c| c[1] == 0.5));
    }

    #[test]
    fn none_and_one_are_fine() {
        assert!(deposit(0, 1, SIZES[0], 10.0, 1e-3).unwrap().is_empty());
        assert_eq!(deposit(1, 1, SIZES[0], 10.0, 0.0).unwrap().centres[0][1], 0.5);
    }

    #[test]
    fn bad_parameters_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(deposit(9, 1, SIZES[0], bad, 1e-3).is_err(), "{bad}");
        }
        for bad in [-1e-3, 1.0, f64::NAN, f64::INFINITY] {
            assert!(deposit(9, 1, SIZES[0], 10.0, bad).is_err(), "{bad}");
        }
        let refused = deposit(9, 1, SIZES[0], 0.9, 0.0);
        assert_eq!(refused, Err(Error::TooNarrow { what: "a disc", required: 1.0, room: 0.9 }));
    }
}
