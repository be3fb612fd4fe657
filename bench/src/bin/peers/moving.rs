//! Elements that move, and coordinates in 32 bits.

use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

use fdem_bench::peers::sets::{self, CUTOFF};
use fdem_bench::{grouped, machine, significant};
use fdem_contact::{Buffered, Detector, Elements, Rows, Search, Simd};

use crate::plan::Plan;

const SIZES: [usize; 2] = [100_000, 1_000_000];

/// The buffer, in cut-offs.
const BUFFER: f64 = 0.1;

/// Times taken of each, in turns.
const ROUNDS: usize = 11;

/// Times updates of moving points, and searches in 64 and in 32 bits; returns tables in Markdown.
pub(crate) fn moving(plan: &Plan) -> Result<String, Box<dyn Error>> {
    let mut report = format!(
        "# Moving points, and 32 bits\n\n{}.\n\nGas with 12 neighbours on one thread; medians of {ROUNDS} rounds in turns; the quartiles in % of the median. \
         The buffer is {BUFFER} cut-offs. *First* is the update of a new `Buffered`, with all its memory; *again* detects in the same memory, after every point has moved; \
         *kept* moves by less than the buffer covers and gives the candidates. Each includes the check of the coordinates.\n\n\
         | points | instructions | candidates | first [ms] | again [ms] | again / first | kept [ms] | kept / first | list in 64 bits [ms] | list in 32 bits [ms] | 64 / 32 |\n\
         |--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
        machine(&[1]),
    );
    for n in SIZES {
        let points = sets::gas(n)?;
        let moved = |by: f64| -> Vec<[f64; 3]> {
            points
                .iter()
                .enumerate()
                .map(|(k, point)| point.map(|x| x + if k % 2 == 0 { by } else { -by }))
                .collect()
        };
        let (little, far) = (moved(0.1 * BUFFER), moved(2.0 * BUFFER));
        let short: Vec<[f32; 3]> = points.iter().map(|point| point.map(|x| x as f32)).collect();
        for simd in [plan.simd, Simd::Avx2] {
            if !simd.is_available() {
                continue;
            }
            let mut samples = vec![Vec::new(); 5];
            let detector = || Detector::new().with_simd(simd);
            let mut buffered = Buffered::with_search(detector()?, BUFFER)?;
            let mut rows = Rows::new().with_simd(simd)?;
            let mut short_rows = Rows::new().with_simd(simd)?;
            let (mut list, mut candidates) = (Vec::new(), 0);
            for round in 0..=ROUNDS {
                let mut taken = [0.0; 5];
                let start = Instant::now();
                let mut first = Buffered::with_search(detector()?, BUFFER)?;
                candidates = first.update(&Elements::points(black_box(&points), CUTOFF)?)?.candidates().len();
                taken[0] = start.elapsed().as_secs_f64();
                drop(first);
                let _ = buffered.update(&Elements::points(&points, CUTOFF)?)?;
                let start = Instant::now();
                let update = buffered.update(&Elements::points(black_box(&far), CUTOFF)?)?;
                taken[1] = start.elapsed().as_secs_f64();
                assert!(update.redetected());
                let _ = buffered.update(&Elements::points(&points, CUTOFF)?)?;
                let start = Instant::now();
                let update = buffered.update(&Elements::points(black_box(&little), CUTOFF)?)?;
                taken[2] = start.elapsed().as_secs_f64();
                assert!(!update.redetected());
                for _ in 0..2 {
                    let start = Instant::now();
                    rows.couples(&Elements::points(black_box(&points), CUTOFF)?, &mut list)?;
                    taken[3] = start.elapsed().as_secs_f64();
                }
                for _ in 0..2 {
                    let start = Instant::now();
                    short_rows.couples(&Elements::points(black_box(&short), CUTOFF as f32)?, &mut list)?;
                    taken[4] = start.elapsed().as_secs_f64();
                }
                if round > 0 {
                    samples.iter_mut().zip(taken).for_each(|(samples, seconds)| samples.push(seconds));
                }
            }
            let mut medians = [0.0; 5];
            let mut cells = Vec::new();
            for (median, samples) in medians.iter_mut().zip(&mut samples) {
                samples.sort_unstable_by(f64::total_cmp);
                let at = |quarter: usize| samples[(samples.len() - 1) * quarter / 4];
                *median = at(2);
                let percent = |x: f64| 100.0 * (x / at(2) - 1.0);
                let (low, high) = (percent(at(1)), percent(at(3)));
                cells.push(format!("{} ({low:.0} to +{high:.0} %)", significant(at(2) * 1e3)));
            }
            let ratio = |a: usize, b: usize| format!("{:.3}", medians[a] / medians[b]);
            writeln!(
                report,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                grouped(n as u64),
                simd.name(),
                grouped(candidates as u64),
                cells[0],
                cells[1],
                ratio(1, 0),
                cells[2],
                ratio(2, 0),
                cells[3],
                cells[4],
                ratio(3, 4)
            )?;
            eprintln!("moving, {n}, {}", simd.name());
        }
    }
    Ok(report)
}
