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

/// What takes its own time, in seconds, because part of what it does is not to be timed or runs elsewhere.
pub type Turn<'a, E> = Box<dyn FnMut() -> Result<f64, E> + 'a>;

/// Below this time of one run, in seconds, what is left in the caches can be seen in it.
const SHORT: f64 = 0.3;

/// Before each turn: threads of the task before may still spin, waiting for more work. Those of OpenMP do so for some 10 ms.
const REST: Duration = Duration::from_millis(30);

/// Times tasks that take their own time, in turns: `count` rounds, fewer of a task whose times add up to more than `budget` seconds.
///
/// What ran for less than 0.3 s in the round before, or has not run, runs once uncounted before it is timed. A task that fails takes no
/// further part.
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
        // Twice over the budget of 3, once to warm up; two pairs of runs, the last of which failed.
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
