//! Times several tasks in turns.

use std::time::{Duration, Instant};

/// A task to be timed. Its result is discarded; an error ends the benchmark.
pub type Task<'a, E> = Box<dyn FnMut() -> Result<(), E> + 'a>;

/// How often each task is timed.
#[derive(Clone, Copy, Debug)]
pub struct Rounds {
    /// Number of times taken of each task.
    pub count: usize,
    /// Lower bound on the number of runs per time.
    pub runs: u32,
    /// Lower bound on the duration per time: a short task runs more often.
    pub fill: Duration,
}

/// Times of one run of a task, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// Median over the rounds.
    pub median: f64,
    /// The fastest round, which is the least disturbed one on a machine that is not quiet.
    pub best: f64,
}

/// Times all tasks in turns.
///
/// Each round runs all tasks one after the other, so that a temporary slowdown of the machine affects all of
/// them. Before each round every task runs once to fill the caches.
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

/// Mean time of a run among `runs` consecutive runs.
fn seconds<E>(task: &mut Task<'_, E>, runs: u32) -> Result<f64, E> {
    let start = Instant::now();
    for _ in 0..runs {
        task()?;
    }
    Ok(start.elapsed().as_secs_f64() / f64::from(runs))
}

/// A task that measures its own time, in seconds, because part of it must not be timed or runs elsewhere.
pub type Turn<'a, E> = Box<dyn FnMut() -> Result<f64, E> + 'a>;

/// If a run takes less than this, in seconds, the content of the caches affects it noticeably.
const SHORT: f64 = 0.3;

/// Pause before each turn: threads of the previous task may still spin while they wait for work. Threads of
/// OpenMP do so for some 10 ms.
const REST: Duration = Duration::from_millis(30);

/// Times tasks that measure their own time, in turns: `count` rounds, or fewer for a task whose times add up
/// to more than `budget` seconds.
///
/// A task that took less than 0.3 s in the previous round, or has not run yet, runs once uncounted before it
/// is timed. A task that fails is not run again.
pub fn turns<E>(tasks: &mut [Turn<'_, E>], count: usize, budget: f64) -> Vec<Result<Times, E>> {
    let mut samples: Vec<Result<Vec<f64>, E>> = tasks.iter().map(|_| Ok(Vec::with_capacity(count))).collect();
    for _ in 0..count {
        for (task, samples) in tasks.iter_mut().zip(&mut samples) {
            let Ok(taken) = samples else { continue };
            if taken.iter().sum::<f64>() > budget {
                continue;
            }
            std::thread::sleep(REST);
            let warm = taken.last().is_some_and(|&seconds| seconds >= SHORT);
            match if warm { task() } else { task().and_then(|_| task()) } {
                Ok(seconds) => taken.push(seconds),
                Err(error) => *samples = Err(error),
            }
        }
    }
    samples.into_iter().map(|samples| samples.map(Times::of)).collect()
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
    fn turns_end_with_the_budget_or_an_error() {
        let mut runs = [0, 0];
        let [long, wrong] = &mut runs;
        let mut tasks: [Turn<'_, &str>; 2] = [
            Box::new(|| {
                *long += 1;
                Ok(2.0)
            }),
            Box::new(|| {
                *wrong += 1;
                if *wrong == 4 { Err("no") } else { Ok(0.1) }
            }),
        ];
        let times = turns(&mut tasks, 7, 3.0);
        drop(tasks);
        assert_eq!(times, [Ok(Times { median: 2.0, best: 2.0 }), Err("no")]);
        // Three runs: one to warm up and two until the budget of 3 is exceeded. Four runs: two pairs, the
        // last of which failed.
        assert_eq!(runs, [3, 4]);
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
