//! Discs at rest and the uniform grid in which they are looked up.

use crate::error::{Error, reserved};

/// End of a list.
const NONE: usize = usize::MAX;

/// Discs at rest on the floor `y = 0` between the walls `x = 0` and `x = room`.
///
/// A disc is listed in every cell its box overlaps, so that a look-up visits only the cells of its own box
/// whatever the sizes. The cell edge is the root mean square diameter: then all lists together have at most
/// nine entries per disc.
pub(crate) struct Bed {
    pub(crate) centres: Vec<[f64; 2]>,
    pub(crate) radii: Vec<f64>,
    pub(crate) room: f64,
    cell: f64,
    columns: usize,
    /// First entry of each cell, row after row; rows are added as the bed grows.
    head: Vec<usize>,
    /// Disc and next entry.
    entries: Vec<(usize, usize)>,
}

impl Bed {
    /// An empty bed for discs of the given radii.
    pub(crate) fn new(radii: &[f64], room: f64) -> Result<Self, Error> {
        let n = radii.len().max(1) as f64;
        // Relative to the room, so that squares neither overflow nor vanish.
        let mean_square = radii.iter().map(|r| (2.0 * r / room) * (2.0 * r / room)).sum::<f64>() / n;
        // A wide room gets at most four columns per disc.
        let cell = room * mean_square.sqrt().max(0.25 / n);
        Ok(Self {
            centres: reserved(radii.len())?,
            radii: reserved(radii.len())?,
            room,
            cell,
            columns: (room / cell) as usize + 1,
            head: Vec::new(),
            entries: reserved(radii.len())?,
        })
    }

    /// Adds a disc at rest.
    pub(crate) fn add(&mut self, centre: [f64; 2], radius: f64) -> Result<(), Error> {
        let disc = self.radii.len();
        self.centres.push(centre);
        self.radii.push(radius);
        let (left, right) = (self.column(centre[0] - radius), self.column(centre[0] + radius));
        let (low, high) = (self.row(centre[1] - radius), self.row(centre[1] + radius));
        let n = (high + 1).saturating_mul(self.columns);
        if n > self.head.len() {
            self.head.try_reserve(n - self.head.len()).map_err(|_| Error::OutOfMemory { n })?;
            self.head.resize(n, NONE);
        }
        for row in low..=high {
            for column in left..=right {
                let head = &mut self.head[row * self.columns + column];
                self.entries.push((disc, *head));
                *head = self.entries.len() - 1;
            }
        }
        Ok(())
    }

    /// The height of the centre at which a disc falling from `from` first touches a disc below it, and that
    /// disc.
    ///
    /// Only discs whose centre is lower count: a disc that has just rolled off another at equal height falls
    /// freely.
    pub(crate) fn fall(&self, from: [f64; 2], radius: f64) -> Option<(f64, usize)> {
        let [x, y] = from;
        let (left, right) = (self.column(x - radius), self.column(x + radius));
        let mut first: Option<(f64, usize)> = None;
        let n_rows = (self.head.len() / self.columns).min(self.row(y).saturating_add(1));
        for row in (0..n_rows).rev() {
            // Discs in lower rows end below the top of this row.
            let reachable = (row + 1) as f64 * self.cell + radius;
            if first.is_some_and(|(height, _)| height >= reachable) {
                break;
            }
            self.visit(row, left, right, |disc| {
                let [cx, cy] = self.centres[disc];
                let reach = radius + self.radii[disc];
                if cy < y && (x - cx).abs() < reach {
                    let height = (cy + (reach * reach - (x - cx) * (x - cx)).sqrt()).min(y);
                    if first.is_none_or(|(best, _)| height > best) {
                        first = Some((height, disc));
                    }
                }
            });
        }
        first
    }

    /// Calls `meet` for the discs whose box may overlap the box from `min` to `max`, some of them repeatedly.
    pub(crate) fn meet(&self, min: [f64; 2], max: [f64; 2], mut meet: impl FnMut(usize)) {
        let (left, right) = (self.column(min[0]), self.column(max[0]));
        let n_rows = (self.head.len() / self.columns).min(self.row(max[1]).saturating_add(1));
        for row in self.row(min[1])..n_rows {
            self.visit(row, left, right, &mut meet);
        }
    }

    fn visit(&self, row: usize, left: usize, right: usize, mut meet: impl FnMut(usize)) {
        for &head in &self.head[row * self.columns + left..=row * self.columns + right] {
            let mut entry = head;
            while entry != NONE {
                let (disc, next) = self.entries[entry];
                meet(disc);
                entry = next;
            }
        }
    }

    /// Column of `x`; places beyond a wall belong to the column beside it.
    fn column(&self, x: f64) -> usize {
        ((x / self.cell) as usize).min(self.columns - 1)
    }

    /// Row of `y`; places below the floor belong to the lowest.
    fn row(&self, y: f64) -> usize {
        (y / self.cell) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Many discs of unlike sizes anywhere; overlaps do not matter here.
    fn scattered() -> Bed {
        let mut random = Random::new(1);
        let discs: Vec<([f64; 2], f64)> = (0..300)
            .map(|_| ([random.between(0.0, 40.0), random.between(0.0, 30.0)], random.between(0.05, 1.5)))
            .collect();
        let radii: Vec<f64> = discs.iter().map(|disc| disc.1).collect();
        let mut bed = Bed::new(&radii, 40.0).unwrap();
        for (centre, radius) in discs {
            bed.add(centre, radius).unwrap();
        }
        bed
    }

    #[test]
    fn fall_finds_what_all_discs_together_find() {
        let bed = scattered();
        let mut random = Random::new(2);
        let mut n_hits = 0;
        for trial in 0..2_000 {
            let from = [
                random.between(0.0, 40.0),
                if trial % 2 == 0 { f64::INFINITY } else { random.between(0.0, 30.0) },
            ];
            let radius = random.between(0.05, 3.0);
            let mut highest = f64::NEG_INFINITY;
            for (centre, other) in bed.centres.iter().zip(&bed.radii) {
                let (dx, reach) = (from[0] - centre[0], radius + other);
                if centre[1] < from[1] && dx.abs() < reach {
                    highest = highest.max((centre[1] + (reach * reach - dx * dx).sqrt()).min(from[1]));
                }
            }
            let found = bed.fall(from, radius).map_or(f64::NEG_INFINITY, |(height, _)| height);
            assert_eq!(found, highest, "from {from:?} with radius {radius}");
            n_hits += usize::from(highest.is_finite());
        }
        assert!(n_hits > 1_000);
    }

    #[test]
    fn meet_misses_no_overlapping_box() {
        let bed = scattered();
        let (min, max) = ([12.0, 3.0], [17.0, 9.5]);
        let mut met = Vec::new();
        bed.meet(min, max, |disc| met.push(disc));
        let mut n_expected = 0;
        for (disc, centre) in bed.centres.iter().enumerate() {
            let r = bed.radii[disc];
            if (0..2).all(|axis| centre[axis] + r >= min[axis] && centre[axis] - r <= max[axis]) {
                assert!(met.contains(&disc), "disc {disc}");
                n_expected += 1;
            }
        }
        assert!(n_expected > 5);
    }
}
