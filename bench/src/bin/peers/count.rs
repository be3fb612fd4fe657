//! Counting couples without a list.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use fdem_bench::peers::sets::{self, CUTOFF};
use fdem_bench::{Turn, turns};
use fdem_contact::{Elements, Rows, Search};

use crate::outcome::Counted;
use crate::plan::Plan;

/// Counts the couples of the gas with `Rows`, for all numbers of points and threads in turns.
pub(crate) fn count(plan: &Plan) -> Result<Vec<Counted>, Box<dyn Error>> {
    let sets: Vec<_> = plan.counts.iter().map(|&n| sets::gas(n)).collect::<Result<_, _>>()?;
    let mut counted = Vec::new();
    for points in &sets {
        eprintln!("counting {}", points.len());
        let mut rows = Rows::new().with_simd(plan.simd)?;
        let couples = rows.count(&Elements::points(points, CUTOFF)?)?;
        counted.push(Counted { n: points.len(), couples, bytes: rows.bytes(), times: Vec::new() });
    }
    let mut tasks = Vec::new();
    for (points, counted) in sets.iter().zip(&counted) {
        for &threads in &plan.threads {
            let mut rows = Rows::new().with_simd(plan.simd)?.with_threads(threads)?;
            let expected = counted.couples;
            let task: Turn<'_, String> = Box::new(move || {
                let start = Instant::now();
                let elements =
                    Elements::points(black_box(points), CUTOFF).map_err(|error| error.to_string())?;
                let found = rows.count(&elements).map_err(|error| error.to_string())?;
                let seconds = start.elapsed().as_secs_f64();
                if found == expected {
                    Ok(seconds)
                } else {
                    Err(format!("{found} couples instead of {expected}"))
                }
            });
            tasks.push(task);
        }
    }
    let times = turns(&mut tasks, plan.rounds, f64::INFINITY).into_iter().collect::<Result<Vec<_>, _>>()?;
    drop(tasks);
    for (counted, times) in counted.iter_mut().zip(times.chunks(plan.threads.len())) {
        counted.times = times.to_vec();
    }
    Ok(counted)
}
