//! The kernel in plain Rust: the definition of what the vector kernels do, for any processor.

use crate::couple::Couple;
use crate::real::Real;
use crate::simd::kernel::{Output, ROOM, Span, Task};

pub(crate) fn search<T: Real, const D: usize>(task: &Task<'_, T, D>, out: &mut Output<'_>) {
    let Task { coordinates, radii, reach_squared, tolerance, .. } = *task;
    scan(task, out, |row, k, other, j| {
        let mut sum = T::ZERO;
        for axis in 0..D {
            let at = |row: Span, k: usize| coordinates[D * row.start + axis * row.len + k];
            let difference = at(row, k) - at(other, j);
            sum = sum + difference * difference;
        }
        let limit = match (radii.get(row.start + k), radii.get(other.start + j)) {
            (Some(&a), Some(&b)) => {
                let reach = (a + b) + tolerance;
                reach * reach
            }
            _ => reach_squared,
        };
        sum <= limit
    });
}

/// The same with any test: `touch(row, k, other, j)` for element `k` of one row and `j` of another, or of the same.
pub(crate) fn scan<T: Real, const D: usize>(
    task: &Task<'_, T, D>,
    out: &mut Output<'_>,
    touch: impl Fn(Span, usize, Span, usize) -> bool,
) {
    let Task { coordinates, ids, row, long, reach, .. } = *task;
    let along = |row: Span| &coordinates[D * row.start + long * row.len..][..row.len];
    let mut neighbours = task.neighbours.to_vec();
    for k in task.from..task.to {
        let x = along(row)[k];
        let (low, high) = (x - reach, x + reach);
        let mut window = |other: Span, first: usize| {
            let inside = along(other)[first..].iter().take_while(|&&x| x <= high);
            for (j, _) in (first..).zip(inside).filter(|&(j, _)| touch(row, k, other, j)) {
                out.count += 1;
                if !out.count_only {
                    if out.couples.capacity() - out.couples.len() < ROOM {
                        (out.make_room)(out.couples);
                    }
                    out.couples.push(Couple::new(ids[row.start + k], ids[other.start + j]));
                }
            }
        };
        window(row, k + 1);
        for neighbour in &mut neighbours {
            let passed = along(neighbour.row)[neighbour.low..].iter().take_while(|&&x| x < low).count();
            neighbour.low += passed;
            window(neighbour.row, neighbour.low);
        }
    }
}
