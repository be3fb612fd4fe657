//! Times of several tasks, taken in turns.

use std::time::{Duration, Instant};

/// What is timed; its result is thrown away, an error ends the benchmark.
pub type Task<'a, E> = Box<dyn FnMut() -> Result<(), E> + 'a>;

/// How often each task is timed.
#[derive(Clone, Copy, Debug)]
pub struct Rounds {
    /// Times taken of each task.
    pub count: usize,
    /// Runs that each of them covers at least.
    pub runs: u32,
    /// Time that each of them covers at least: a short task runs more often.
    pub fill: Duration,
}

/// Times of one run of a task, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// Of the middle one of the rounds.
    pub median: f64,
    /// Of the fastest round: the least disturbed one, on a machine that is not quiet.
    pub best: f64,
}

/// Times every task, in turns.
///
/// The rounds go through all tasks one after the other, so that a machine that slows down for a while slows all of
/// them. Before each round a task runs once for the caches.
///
/// # Errors
/// The first error of a task.
pub fn times<E>(tasks: &mut [Task<'_, E>], rounds: Rounds) -> Result<Vec<Times>, E> {
    let mut runs = Vec::with_capacity(tasks.len());
    for task in &mut *tasks {
        task()?;
        let once = seconds(task, 1)?.max(1e-9);
        runs.push(rounds.runs.max((rounds.fill.as_secs_f64() / once) as u32 + 1));
    }
    let mut samples = vec![Vec::with_capacity(rounds.count); tasks.len()];
    for _ in 0..rounds.count {
        for ((task, samples), &runs) in tasks.iter_mut().zip(&mut samples).zip(&runs) {
            task()?;
            samples.push(seconds(task, runs)?);
        }
    }
    Ok(samples.into_iter().map(Times::of).collect())
}

/// Mean time of one run among `runs` in a row.
fn seconds<E>(task: &mut Task<'_, E>, runs: u32) -> Result<f64, E> {
    let start = Instant::now();
    for _ in 0..runs {
        task()?;
    }
    Ok(start.elapsed().as_secs_f64() / f64::from(runs))
}

impl Times {
    fn of(mut samples: Vec<f64>) -> Self {
        samples.sort_unstable_by(f64::total_cmp);
        let (low, high) = ((samples.len() - 1) / 2, samples.len() / 2);
        Self { median: f64::midpoint(samples[low], samples[high]), best: samples[0] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_and_the_best_the_least() {
        assert_eq!(Times::of(vec![5.0, 1.0, 3.0]), Times { median: 3.0, best: 1.0 });
        assert_eq!(Times::of(vec![4.0, 1.0, 2.0, 9.0]), Times { median: 3.0, best: 1.0 });
    }

    #[test]
    fn short_tasks_run_more_often_and_errors_come_out() {
        let mut done = 0;
        let rounds = Rounds { count: 3, runs: 5, fill: Duration::from_millis(1) };
        let mut tasks: [Task<'_, ()>; 1] = [Box::new(|| {
            done += 1;
            Ok(())
        })];
        assert!(times(&mut tasks, rounds).unwrap()[0].best < 1e-3);
        drop(tasks);
        assert!(done > 5 * 3);
        assert_eq!(times(&mut [Box::new(|| Err("no"))], rounds), Err("no"));
    }
}
