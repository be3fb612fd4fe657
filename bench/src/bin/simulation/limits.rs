//! Measures the limits of this machine: bytes moved and arithmetic operations per second.

use std::hint::black_box;
use std::thread;
use std::time::Instant;

/// Numbers in each of three arrays: far more than the caches can hold.
const NUMBERS: usize = 1 << 24;

/// The limits of one thread and of all threads together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Bytes read and written per second, on one thread and on all.
    pub(crate) bytes: [f64; 2],
    /// Additions and multiplications per second.
    pub(crate) operations: [f64; 2],
}

/// Measures on one thread, and on `threads` threads.
pub(crate) fn measure(threads: usize) -> Result<Limits, Box<dyn std::error::Error>> {
    let best = |task: fn() -> f64, threads: usize| -> Result<f64, Box<dyn std::error::Error>> {
        let mut best = 0.0_f64;
        for _ in 0..3 {
            let rates = thread::scope(|scope| {
                let all: Vec<_> = (0..threads).map(|_| scope.spawn(task)).collect();
                all.into_iter()
                    .map(|one| one.join().map_err(|_| "a thread failed"))
                    .collect::<Result<Vec<f64>, _>>()
            })?;
            best = best.max(rates.into_iter().sum());
        }
        Ok(best)
    };
    Ok(Limits {
        bytes: [best(triad, 1)?, best(triad, threads)?],
        operations: [best(arithmetic, 1)?, best(arithmetic, threads)?],
    })
}

/// `a = b + s c` through memory (the triad of the STREAM benchmark): 24 bytes per number.
fn triad() -> f64 {
    let (mut a, b, c) = (vec![0.0_f64; NUMBERS], vec![1.0_f64; NUMBERS], vec![2.0_f64; NUMBERS]);
    let mut best = 0.0_f64;
    for _ in 0..5 {
        let start = Instant::now();
        for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
            *a = b + 3.0 * c;
        }
        black_box(&a);
        best = best.max(24.0 * NUMBERS as f64 / start.elapsed().as_secs_f64());
    }
    best
}

/// Independent additions and multiplications, with the instructions that every processor of this architecture
/// has, like our build.
fn arithmetic() -> f64 {
    const LANES: usize = 24;
    const TURNS: usize = 5_000_000;
    let mut sums: [f64; LANES] = black_box([1.0; LANES]);
    let (factor, term) = black_box((0.999_999_9, 1e-9));
    let start = Instant::now();
    for _ in 0..TURNS {
        for sum in &mut sums {
            *sum = *sum * factor + term;
        }
    }
    black_box(sums);
    (2 * LANES * TURNS) as f64 / start.elapsed().as_secs_f64()
}
