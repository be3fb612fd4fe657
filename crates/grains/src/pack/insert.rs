//! Spheres at random places, one after the other (random sequential addition, Widom 1966).

use fdem_scenes::random::Random;

use crate::pack::region::PackRegion;
use crate::vector::{Vector, dot, minus};

/// Places that are tried for a sphere.
const ATTEMPTS: u32 = 500;

/// Places that are tried for a centre inside the region where a sphere has no room.
const ATTEMPTS_INSIDE: u32 = 100_000;

/// Stream of a seed from which places are drawn.
const PLACES: u64 = 5;

/// Spheres of about one size, in cells that are as wide as the largest of them.
struct SizeClass {
    largest: f64,
    width: f64,
    low: Vector,
    counts: [usize; 3],
    members: Vec<Vec<u32>>,
}

impl SizeClass {
    /// Cells for spheres whose largest radius is `largest` and that keep apart by `gap`.
    fn new([low, high]: [Vector; 2], largest: f64, gap: f64, expected: usize) -> Self {
        let extents = [0, 1, 2].map(|axis| high[axis] - low[axis]);
        let mut width = 2.0 * largest + gap;
        let cells =
            |width: f64| -> f64 { extents.iter().map(|extent| (extent / width).floor() + 1.0).product() };
        // No more cells than there is use for.
        while cells(width) > 8.0 * expected as f64 + 64.0 {
            width *= 1.3;
        }
        let counts = extents.map(|extent| (extent / width) as usize + 1);
        Self { largest, width, low, counts, members: vec![Vec::new(); counts.iter().product()] }
    }

    fn place(&self, x: f64, axis: usize) -> usize {
        (((x - self.low[axis]) / self.width).max(0.0) as usize).min(self.counts[axis] - 1)
    }

    fn add(&mut self, point: Vector, member: u32) {
        let [x, y, z] = [0, 1, 2].map(|axis| self.place(point[axis], axis));
        let cell = (z * self.counts[1] + y) * self.counts[0] + x;
        self.members[cell].push(member);
    }

    /// Whether all members within `reach` of a point along each axis are clear.
    fn all_near(&self, point: Vector, reach: f64, clear: impl Fn(u32) -> bool) -> bool {
        let [from, to] = [-reach, reach].map(|by| [0, 1, 2].map(|axis| self.place(point[axis] + by, axis)));
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let cell = (z * self.counts[1] + y) * self.counts[0] + x;
                    if !self.members[cell].iter().all(|&member| clear(member)) {
                        return false;
                    }
                }
            }
        }
        true
    }
}

/// The wanted places.
pub(crate) struct Wanted<'a> {
    pub(crate) region: &'a PackRegion,
    pub(crate) discs: bool,
    /// Radii, m, descending.
    pub(crate) radii: &'a [f64],
    /// Factor of the radii.
    pub(crate) share: f64,
    pub(crate) gap: f64,
    pub(crate) seed: u64,
    /// Spheres that are there: centres and radii, m.
    pub(crate) others: &'a [(Vector, f64)],
}

/// Random places. Also returns whether all spheres have room: one that found none is at a random place of the
/// region.
pub(crate) fn insert(of: &Wanted<'_>) -> (Vec<Vector>, bool) {
    let mut random = Random::with_stream(of.seed, PLACES);
    let bounds = of.region.bounds();
    let all: Vec<f64> = of.radii.iter().map(|radius| of.share * radius).collect();
    let mut classes: Vec<SizeClass> = Vec::new();
    let mut places: Vec<(Vector, f64)> = Vec::with_capacity(of.others.len() + all.len());
    // The spheres that are there are sorted into classes, too, the largest first.
    let mut others: Vec<(Vector, f64)> = of.others.to_vec();
    others.sort_by(|a, b| b.1.total_cmp(&a.1));
    let add = |classes: &mut Vec<SizeClass>, places: &mut Vec<(Vector, f64)>, point: Vector, radius: f64| {
        let member = places.len() as u32;
        let expected = all.len() + of.others.len();
        let fits = |class: &SizeClass| radius <= class.largest && radius > 0.5 * class.largest;
        let class = classes.iter().position(fits).unwrap_or_else(|| {
            classes.push(SizeClass::new(bounds, radius, of.gap, expected));
            classes.len() - 1
        });
        classes[class].add(point, member);
        places.push((point, radius));
    };
    for (point, radius) in others {
        add(&mut classes, &mut places, point, radius);
    }
    let mut has_room = true;
    let mut found = Vec::with_capacity(all.len());
    for &radius in &all {
        let clear = |point: Vector| {
            of.region.contains(point, radius + of.gap, of.discs)
                && classes.iter().all(|class| {
                    let reach = radius + class.largest + of.gap;
                    class.all_near(point, reach, |member| {
                        let (centre, other) = places[member as usize];
                        let arm = minus(centre, point);
                        let least = radius + other + of.gap;
                        dot(arm, arm) >= least * least
                    })
                })
        };
        let mut any = |_| {
            let point = [0, 1, 2].map(|axis| random.between(bounds[0][axis], bounds[1][axis]));
            if of.discs { [point[0], point[1], 0.0] } else { point }
        };
        let free = if has_room { (0..ATTEMPTS).map(&mut any).find(|&point| clear(point)) } else { None };
        let point = free.unwrap_or_else(|| {
            has_room = false;
            let inside = |point: &Vector| of.region.contains(*point, 0.0, of.discs);
            let middle = [0, 1, 2].map(|axis| f64::midpoint(bounds[0][axis], bounds[1][axis]));
            (0..ATTEMPTS_INSIDE).map(&mut any).find(inside).unwrap_or(middle)
        });
        add(&mut classes, &mut places, point, radius);
        found.push(point);
    }
    (found, has_room)
}
