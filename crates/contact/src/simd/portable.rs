//! The kernel in plain Rust, for any processor; it defines the results of the vector kernels.

use crate::couple::Couple;
use crate::real::Real;
use crate::simd::task::{Arrays, Looks, Output, ROOM, Span, Task};

pub(crate) fn search<T: Real, const D: usize>(task: &Task<'_, T>, out: &mut Output<'_>) {
    let Task { own, other, reach_squared, tolerance, .. } = *task;
    scan::<T, D>(task, out, |row, k, their_row, j| {
        let at =
            |numbers: &[T], row: Span, axis: usize, k: usize| numbers[D * row.start + axis * row.len + k];
        let touch = if own.far.is_empty() {
            let mut sum = T::ZERO;
            for axis in 0..D {
                let difference =
                    at(own.coordinates, row, axis, k) - at(other.coordinates, their_row, axis, j);
                sum = sum + difference * difference;
            }
            let limit = match (own.radii.get(row.start + k), other.radii.get(their_row.start + j)) {
                (Some(&a), Some(&b)) => {
                    let reach = (a + b) + tolerance;
                    reach * reach
                }
                _ => reach_squared,
            };
            sum <= limit
        } else {
            (0..D).all(|axis| {
                at(own.coordinates, row, axis, k) <= at(other.far, their_row, axis, j)
                    && at(other.coordinates, their_row, axis, j) <= at(own.far, row, axis, k)
            })
        };
        let see_each_other = match (own.filter, other.filter) {
            (Some(filter), Some(others)) => {
                filter.filter().admits_of(row.start + k, others.filter(), their_row.start + j)
            }
            _ => true,
        };
        touch && see_each_other
    });
}

/// Calls `touch(row, k, other, j)` for element `k` of the row and each element `j` in reach along it, of a
/// neighbour row or of the same row.
fn scan<'a, T: Real, const D: usize>(
    task: &Task<'a, T>,
    out: &mut Output<'_>,
    touch: impl Fn(Span, usize, Span, usize) -> bool,
) {
    let Task { own, other, two_sets, one_numbering, row, long, reach, .. } = *task;
    let along = |set: Arrays<'a, T>, row: Span| &set.coordinates[D * row.start + long * row.len..][..row.len];
    let mut neighbours = task.neighbours.to_vec();
    for k in task.from..task.to {
        let x = along(own, row)[k];
        let mut window = |set: Arrays<'a, T>, their_row: Span, first: usize, reach: T| {
            let high = x + reach;
            let inside = along(set, their_row)[first..].iter().take_while(|&&x| x <= high);
            for (j, _) in (first..).zip(inside).filter(|&(j, _)| touch(row, k, their_row, j)) {
                out.count += 1;
                if !out.count_only {
                    if out.couples.capacity() - out.couples.len() < ROOM {
                        (out.make_room)(out.couples);
                    }
                    let (i, j) = (own.ids[row.start + k], set.ids[their_row.start + j]);
                    out.couples.push(if one_numbering { Couple::new(i, j) } else { Couple { i, j } });
                }
            }
        };
        if !two_sets {
            window(own, row, k + 1, reach);
        }
        for neighbour in &mut neighbours {
            let is_passed = |&&other: &&T| match neighbour.looks {
                Looks::Back => other < x - neighbour.reach,
                Looks::Ahead => other < x,
                Looks::Beyond => other <= x,
            };
            let passed = along(other, neighbour.row)[neighbour.low..].iter().take_while(is_passed).count();
            neighbour.low += passed;
            window(other, neighbour.row, neighbour.low, neighbour.reach);
        }
    }
}
