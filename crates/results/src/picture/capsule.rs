//! Pixels of a thick line with round ends, row by row, so that the cost is that of the covered pixels and not
//! of the bounding box.

/// All points within `radius` of the line from `a` to `b`.
pub(crate) struct Capsule {
    a: [f64; 2],
    b: [f64; 2],
    radius: f64,
    length: f64,
}

impl Capsule {
    pub(crate) fn new([a, b]: [[f64; 2]; 2], radius: f64) -> Self {
        let [x, y] = [b[0] - a[0], b[1] - a[1]];
        Self { a, b, radius, length: (x * x + y * y).sqrt() }
    }

    /// Rows whose middle may be covered, among `height` rows.
    pub(crate) fn rows(&self, height: usize) -> std::ops::Range<usize> {
        let low = self.a[1].min(self.b[1]) - self.radius;
        let high = self.a[1].max(self.b[1]) + self.radius;
        clipped(low, high, height)
    }

    /// Columns of a row whose middle may be covered, among `width` columns: all that are covered, and a few
    /// others.
    pub(crate) fn columns(&self, row: usize, width: usize) -> std::ops::Range<usize> {
        let v = row as f64 + 0.5;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut include = |from: f64, to: f64| {
            low = low.min(from);
            high = high.max(to);
        };
        for [x, y] in [self.a, self.b] {
            let rest = self.radius * self.radius - (v - y) * (v - y);
            if rest >= 0.0 {
                include(x - rest.sqrt(), x + rest.sqrt());
            }
        }
        if let Some([from, to]) = self.between(v) {
            include(from, to);
        }
        if low > high {
            return 0..0;
        }
        // Allows for rounding errors if the ends are far away.
        let margin = 1e-9 * (self.length + self.a[0].abs() + self.b[0].abs());
        clipped(low - margin, high + margin, width)
    }

    /// Range in which the row at `v` crosses the rectangle between the ends.
    fn between(&self, v: f64) -> Option<[f64; 2]> {
        if self.length.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let [x, y] = [(self.b[0] - self.a[0]) / self.length, (self.b[1] - self.a[1]) / self.length];
        let v = v - self.a[1];
        // At u relative to `a`, the position along the line is u x + v y, and the distance from it u y - v x.
        let along = within(x, v * y, [0.0, self.length])?;
        let across = within(y, -v * x, [-self.radius, self.radius])?;
        let (from, to) = (along[0].max(across[0]), along[1].min(across[1]));
        (from <= to).then(|| [self.a[0] + from, self.a[0] + to])
    }
}

/// Range of u for which `factor u + constant` lies between the limits.
fn within(factor: f64, constant: f64, [low, high]: [f64; 2]) -> Option<[f64; 2]> {
    if factor.abs() < 1e-12 {
        let slack = 1e-9 * (high - low);
        let inside = (low - slack..=high + slack).contains(&constant);
        return inside.then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let ends = [(low - constant) / factor, (high - constant) / factor];
    Some([ends[0].min(ends[1]), ends[0].max(ends[1])])
}

/// Integers from `low` to `high`, with one more at each end, between 0 and `end`.
fn clipped(low: f64, high: f64, end: usize) -> std::ops::Range<usize> {
    ((low - 1.0).max(0.0) as usize).min(end)..((high + 2.0).max(0.0) as usize).min(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ranges contain every pixel that the line covers, for any direction, and few others.
    #[test]
    fn ranges_hold_the_line_and_little_else() {
        const SIDE: usize = 120;
        let ends = [
            [[10.0, 20.0], [100.0, 90.0]],
            [[100.0, 20.0], [10.0, 21.0]],
            [[60.2, 110.0], [60.2, 3.0]],
            [[5.0, 60.4], [110.0, 60.4]],
            [[50.0, 50.0], [50.0, 50.0]],
            [[-1e9, 10.0], [1e9, 90.0]],
            [[60.0, -1e7], [61.0, 1e7]],
            [[-500.0, -400.0], [40.0, 70.0]],
            [[3.0, 3.0], [4.0, 90.0]],
        ];
        for (ends, radius) in ends.into_iter().flat_map(|ends| [0.3, 2.0, 17.5].map(|radius| (ends, radius)))
        {
            let capsule = Capsule::new(ends, radius);
            let [a, b] = ends;
            let along = [b[0] - a[0], b[1] - a[1]];
            let squared: f64 = along.iter().map(|x| x * x).sum();
            let (mut covered, mut visited) = (0, 0);
            for row in 0..SIDE {
                let columns =
                    if capsule.rows(SIDE).contains(&row) { capsule.columns(row, SIDE) } else { 0..0 };
                visited += columns.len();
                for column in 0..SIDE {
                    let [u, v] = [column as f64 + 0.5 - a[0], row as f64 + 0.5 - a[1]];
                    let share = if squared > 0.0 {
                        ((u * along[0] + v * along[1]) / squared).clamp(0.0, 1.0)
                    } else {
                        0.0
                    };
                    let distance = (u - share * along[0]).hypot(v - share * along[1]);
                    if distance < radius * (1.0 - 1e-9) - 1e-6 {
                        covered += 1;
                        assert!(
                            columns.contains(&column),
                            "{ends:?} {radius}: {column}, {row} not in {columns:?}"
                        );
                    }
                }
            }
            assert!(visited <= covered + 12 * SIDE, "{ends:?} {radius}: {visited} for {covered}");
        }
    }
}
