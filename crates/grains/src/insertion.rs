//! Spheres that come in during a run, and boxes in which they are removed.

use serde::{Deserialize, Serialize};

use crate::vector::{Vector, dot, minus};
use crate::wall::Wall;

/// Random places that a sphere tries before it waits for the next time.
const TRIES: u64 = 64;

/// Spheres that come in one after the other, at rest or with a velocity, at random places of a box.
///
/// A sphere that finds no place waits, and so do those after it: no sphere is left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Insertion {
    /// Name, for messages; may be empty.
    pub name: String,
    /// Lowest and highest corner of the box in which the spheres appear as a whole, m.
    pub region: [[f64; 3]; 2],
    /// Radii in the order in which the spheres come, m.
    pub radii: Vec<f64>,
    /// Time at which the first one comes, s.
    pub from: f64,
    /// Spheres in a second, 1/s; infinite for all at once.
    pub rate: f64,
    /// Velocity with which they come, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity with which they come, rad/s.
    pub spin: [f64; 3],
    /// Number of their material.
    pub material: u32,
    /// Number of their group.
    pub group: u32,
    /// Seed of the random places.
    pub seed: u64,
}

/// A box in which spheres are removed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Removal {
    /// Name, for messages; may be empty.
    pub name: String,
    /// Its lowest and highest corner, m. A sphere is removed when its centre is in it.
    pub region: [[f64; 3]; 2],
    /// Times from and until which spheres are removed, s.
    pub times: [f64; 2],
}

impl Insertion {
    /// Number of spheres that are due at a time, s: this many have come in then if all have found a place.
    pub fn due(&self, time: f64) -> usize {
        if time < self.from {
            return 0;
        }
        if self.rate == f64::INFINITY {
            return self.radii.len();
        }
        // The conversion ends at the largest number.
        let due = ((time - self.from) * self.rate).floor() as usize;
        due.saturating_add(1).min(self.radii.len())
    }

    /// A random place of a sphere that touches nothing, or `None` after some tries. The places depend on the
    /// seed, the sphere and the step alone.
    pub(crate) fn place(&self, sphere: usize, step: u64, taken: &Taken<'_>) -> Option<Vector> {
        let radius = self.radii[sphere];
        let [low, high] = self.region;
        (0..TRIES)
            .map(|number| {
                let chance = Chance::new([self.seed, sphere as u64, step, number]);
                std::array::from_fn(|axis| {
                    let (least, most) = (low[axis] + radius, high[axis] - radius);
                    // A plane of discs has no extent across it.
                    if low[axis] == high[axis] {
                        low[axis]
                    } else {
                        least + chance.share(axis as u64) * (most - least)
                    }
                })
            })
            .find(|&place| taken.is_free(place, radius))
    }
}

impl Removal {
    /// Whether a sphere is removed at a time, s.
    pub(crate) fn takes(&self, centre: Vector, time: f64) -> bool {
        let [low, high] = &self.region;
        (self.times[0]..=self.times[1]).contains(&time)
            && (0..3).all(|axis| (low[axis]..=high[axis]).contains(&centre[axis]))
    }
}

/// Spheres and walls that are in a box already.
pub(crate) struct Taken<'a> {
    walls: &'a [Wall],
    /// Whether a sphere, by its centre, m, and radius, m, touches no triangle.
    is_clear: &'a dyn Fn(Vector, f64) -> bool,
    low: Vector,
    /// Width of cells, m: no sphere is wider.
    width: f64,
    cells: [usize; 3],
    /// Spheres of each cell: centres and radii.
    spheres: Vec<Vec<(Vector, f64)>>,
}

/// Cells along an axis at most.
const CELLS: usize = 64;

impl<'a> Taken<'a> {
    /// Spheres, by centres, m, and radii, m, that are in a box or reach into it, and walls in their places.
    /// `is_clear`: whether a sphere touches no triangle; `largest`: the largest radius of all spheres, m.
    pub(crate) fn new(
        [low, high]: [Vector; 2],
        largest: f64,
        spheres: impl Iterator<Item = (Vector, f64)>,
        (walls, is_clear): (&'a [Wall], &'a dyn Fn(Vector, f64) -> bool),
    ) -> Self {
        let extent = minus(high, low);
        let longest = extent.into_iter().fold(0.0, f64::max);
        let width = (2.0 * largest).max(longest / CELLS as f64).max(f64::MIN_POSITIVE);
        let cells = extent.map(|length| (length / width) as usize + 1);
        let mut taken =
            Self { walls, is_clear, low, width, cells, spheres: vec![Vec::new(); cells.iter().product()] };
        for (centre, radius) in spheres {
            let is_near =
                (0..3).all(|axis| centre[axis] + radius >= low[axis] && centre[axis] - radius <= high[axis]);
            if is_near {
                taken.add(centre, radius);
            }
        }
        taken
    }

    /// Adds a sphere.
    pub(crate) fn add(&mut self, centre: Vector, radius: f64) {
        let cell = self.cell(centre);
        let place = self.place(cell);
        self.spheres[place].push((centre, radius));
    }

    fn cell(&self, centre: Vector) -> [usize; 3] {
        std::array::from_fn(|axis| {
            // Spheres beyond the box are in its outermost cells. The conversion ends at 0.
            (((centre[axis] - self.low[axis]) / self.width) as usize).min(self.cells[axis] - 1)
        })
    }

    fn place(&self, cell: [usize; 3]) -> usize {
        (cell[2] * self.cells[1] + cell[1]) * self.cells[0] + cell[0]
    }

    /// Whether a sphere touches nothing.
    pub(crate) fn is_free(&self, centre: Vector, radius: f64) -> bool {
        let cell = self.cell(centre);
        let around = |axis: usize| cell[axis].saturating_sub(1)..(cell[axis] + 2).min(self.cells[axis]);
        let mut cells =
            around(2).flat_map(|z| around(1).flat_map(move |y| around(0).map(move |x| [x, y, z])));
        (self.is_clear)(centre, radius)
            && self.walls.iter().all(|wall| wall.nearest(centre).1 >= radius)
            && cells.all(|cell| {
                self.spheres[self.place(cell)].iter().all(|&(other, size)| {
                    let apart = minus(centre, other);
                    dot(apart, apart) >= (radius + size) * (radius + size)
                })
            })
    }
}

/// Random numbers that follow from others: `splitmix64` (Steele, Lea and Flood 2014).
#[derive(Clone, Copy, Debug)]
struct Chance(u64);

impl Chance {
    fn new(numbers: [u64; 4]) -> Self {
        Self(numbers.into_iter().fold(0, |state, number| mixed(state ^ number)))
    }

    /// A number of at least 0 and below 1.
    fn share(self, number: u64) -> f64 {
        (mixed(self.0 ^ number) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn mixed(state: u64) -> u64 {
    let state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    state ^ (state >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rain(radii: Vec<f64>, rate: f64) -> Insertion {
        Insertion {
            name: "rain".to_owned(),
            region: [[0.0; 3], [1.0, 1.0, 0.2]],
            radii,
            from: 1.0,
            rate,
            velocity: [0.0; 3],
            spin: [0.0; 3],
            material: 0,
            group: 0,
            seed: 7,
        }
    }

    #[test]
    fn spheres_are_due_from_the_beginning_at_their_rate() {
        let rain = rain(vec![0.1; 5], 2.0);
        assert_eq!([0.9, 1.0, 1.4, 1.5, 2.0, 100.0].map(|time| rain.due(time)), [0, 1, 1, 2, 3, 5]);
        let at_once = super::tests::rain(vec![0.1; 5], f64::INFINITY);
        assert_eq!([0.9, 1.0, 1.1].map(|time| at_once.due(time)), [0, 5, 5]);
    }

    #[test]
    fn placed_spheres_are_in_their_box_and_touch_nothing() {
        let rain = rain((0..300).map(|k| 0.02 + 0.0001 * f64::from(k)).collect(), 1.0);
        let floor = [Wall::plane([0.0, 0.0, 0.03], [0.0, 0.0, 1.0], 0)];
        let stone = ([0.5, 0.5, -0.1], 0.25);
        let mut taken = Taken::new(rain.region, 0.25, [stone].into_iter(), (&floor, &|_, _| true));
        let mut placed = vec![stone];
        for (sphere, &radius) in rain.radii.iter().enumerate() {
            let Some(place) = rain.place(sphere, 3, &taken) else { continue };
            for (along, end) in place.into_iter().zip(rain.region[1]) {
                assert!(along - radius >= 0.0 && along + radius <= end);
            }
            assert!(place[2] - radius >= 0.03 - 1e-15);
            for &(other, size) in &placed {
                let apart = minus(place, other);
                assert!(dot(apart, apart).sqrt() >= radius + size - 1e-15);
            }
            placed.push((place, radius));
            taken.add(place, radius);
        }
        // Almost all of these find a place while there is room, and the box is full at the end.
        assert!((100..300).contains(&placed.len()), "{}", placed.len());
    }

    #[test]
    fn a_box_removes_within_its_times() {
        let hole = Removal { name: String::new(), region: [[0.0; 3], [1.0; 3]], times: [1.0, 2.0] };
        assert!(hole.takes([0.5; 3], 1.0) && hole.takes([1.0; 3], 2.0));
        assert!(!hole.takes([0.5; 3], 0.9) && !hole.takes([0.5, 0.5, 1.1], 1.5));
    }
}
