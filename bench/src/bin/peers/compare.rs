//! Compares the searches: first their couples, then their times.

use std::error::Error;
use std::hint::black_box;
use std::panic::AssertUnwindSafe;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fdem_bench::peers::sets::{Made, Set};
use fdem_bench::peers::{self, Bodies, Command, External, Peer, Peers, Threads};
use fdem_bench::{Turn, grouped, significant, turns};
use fdem_contact::Couple;

use crate::outcome::{Called, Outcome, Searched};
use crate::plan::Plan;

const QUICK: usize = 10_000;

/// Largest difference of the number of pairs of a program, as a fraction: `f32` rounds distances near the
/// cut-off.
pub(crate) const ROUNDED: f64 = 1e-5;

/// The bodies of a set, and two smaller sets of the same kind.
pub(crate) struct Scenes<const D: usize> {
    all: Made<D>,
    smaller: Vec<Made<D>>,
    file: Option<BodyFile>,
}

impl<const D: usize> Scenes<D> {
    pub(crate) fn new(
        plan: &Plan,
        set: &Set,
        scene: fn(usize) -> Result<Made<D>, fdem_scenes::Error>,
    ) -> Result<Self, Box<dyn Error>> {
        let all = scene(if plan.quick { QUICK } else { set.n })?;
        let smaller = if plan.quick { Vec::new() } else { vec![scene(set.n / 100)?, scene(set.n / 10)?] };
        let file = (!plan.external.is_empty()).then(|| BodyFile::new(all.bodies())).transpose()?;
        Ok(Self { all, smaller, file })
    }
}

/// Bodies as little-endian `f64` in a temporary file, which is removed when dropped.
struct BodyFile(PathBuf);

impl BodyFile {
    fn new<const D: usize>(bodies: Bodies<'_, D>) -> std::io::Result<Self> {
        let file = Self(std::env::temp_dir().join(format!("fdem-peers-{}.f64", std::process::id())));
        let bytes: Vec<u8> = bodies.numbers().into_iter().flat_map(f64::to_le_bytes).collect();
        std::fs::write(&file.0, bytes)?;
        Ok(file)
    }
}

impl Drop for BodyFile {
    fn drop(&mut self) {
        // The file may have been removed already.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A search that takes part in turns.
enum Rival<const D: usize> {
    Inside(Box<dyn Peer<D>>),
    Program(External),
}

/// Compares the couples of all searches with those of the first, then times those that agree.
pub(crate) fn compare<const D: usize>(
    plan: &Plan,
    set: &'static Set,
    scenes: &Scenes<D>,
    threads: &Threads,
    rivals: Peers<D>,
    called: &mut Vec<Called>,
) -> Result<Outcome, Box<dyn Error>> {
    eprintln!("{}, threads: {}", set.name, threads.count());
    let mut outcome = Outcome {
        set,
        threads: threads.count(),
        n: scenes.all.bodies().len(),
        couples: 0,
        searches: Vec::new(),
    };
    let mut note = |name: &str, (version, how): (String, String)| {
        let call = Called { name: name.to_owned(), version, how };
        if !called.contains(&call) {
            called.push(call);
        }
    };
    let mut agreeing = Vec::new();
    let mut reference = Vec::new();
    let mut found = Vec::new();
    let engines = plan.engines(set);
    let bodies = scenes.all.bodies();
    let ours = peers::ours(&engines, plan.simd, threads.count())?;
    for (number, mut search) in ours.into_iter().chain(rivals).enumerate() {
        note(search.name(), (search.version(), search.how()));
        // The first search is the reference for the others, however long it takes.
        let smaller = if number == 0 { &[] } else { &scenes.smaller[..] };
        let answer = caught(|| {
            let seconds = forecast(search.as_mut(), smaller, &mut found)?;
            if seconds > plan.patience {
                return Err(format!("would take about {} s", significant(seconds)));
            }
            search.couples(bodies, &mut found)
        });
        let differing = answer.map(|()| {
            if number == 0 {
                reference.clone_from(&found);
                outcome.couples = reference.len();
            }
            differing(&mut reference, &mut found)
        });
        if let (0, Err(reason)) = (number, &differing) {
            return Err(format!("{}: {}: {reason}", set.name, search.name()).into());
        }
        let of = grouped(reference.len() as u64);
        outcome.searches.push(Searched {
            name: search.name().to_owned(),
            ours: number < engines.len(),
            wrong: differing.as_ref().is_ok_and(|&couples| couples > 0),
            rounded: None,
            bytes: search.bytes(),
            times: differing.and_then(|couples| match couples {
                0 => Ok(None),
                _ => Err(format!("differs in {} of {of} couples", grouped(couples as u64))),
            }),
        });
        agreeing.push(Some(Rival::Inside(search)));
    }
    drop((reference, found));
    for command in scenes.file.iter().flat_map(|_| &plan.external) {
        let (searched, program) = ask(plan, command, scenes, &outcome);
        if let Some(program) = &program {
            note(&command.name, program.about.clone());
        }
        outcome.searches.push(searched);
        agreeing.push(program.map(Rival::Program));
    }
    for search in &outcome.searches {
        eprintln!("  {}: {}", search.name, search.times.as_ref().err().map_or("agrees", String::as_str));
    }
    if !plan.quick {
        take_times(plan, bodies, agreeing, &mut outcome.searches);
    }
    Ok(outcome)
}

/// A peer that panics is left out, like one that returns an error.
fn caught(search: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    std::panic::catch_unwind(AssertUnwindSafe(search)).unwrap_or_else(|_| Err("panics".to_owned()))
}

/// Starts a program and compares its number of pairs.
fn ask<const D: usize>(
    plan: &Plan,
    command: &Command,
    scenes: &Scenes<D>,
    outcome: &Outcome,
) -> (Searched, Option<External>) {
    let mut searched = Searched {
        name: command.name.clone(),
        ours: false,
        times: Ok(None),
        rounded: None,
        wrong: false,
        bytes: None,
    };
    let file = scenes.file.as_ref().map_or(Path::new(""), |file| &file.0);
    let kind = scenes.all.bodies().argument();
    let patience = Duration::from_secs_f64(plan.patience);
    let started = External::start(command, (file, D), &kind, outcome.threads, patience);
    let answer = started.and_then(|mut program| Ok((program.round()?, program)));
    match answer {
        Err(reason) => {
            searched.times = Err(reason);
            (searched, None)
        }
        Ok((answer, program)) => {
            let apart = answer.pairs.abs_diff(outcome.couples as u64);
            searched.wrong = apart as f64 > ROUNDED * outcome.couples as f64;
            searched.rounded = (apart > 0).then_some(answer.pairs);
            if searched.wrong {
                let (found, of) = (grouped(answer.pairs), grouped(outcome.couples as u64));
                searched.times = Err(format!("finds {found} couples instead of {of}"));
            }
            (searched, Some(program))
        }
    }
}

/// The predicted time in seconds of a search for ten times the number of bodies of the larger of two sets,
/// extrapolated from these; 0 without sets.
fn forecast<const D: usize>(
    search: &mut dyn Peer<D>,
    smaller: &[Made<D>],
    found: &mut Vec<Couple>,
) -> Result<f64, String> {
    let mut seconds = Vec::new();
    for made in smaller {
        let start = Instant::now();
        search.couples(made.bodies(), found)?;
        seconds.push(start.elapsed().as_secs_f64().max(1e-5));
    }
    Ok(if let [first, second] = seconds[..] { second * (second / first).max(1.0) } else { 0.0 })
}

/// Number of couples that are in only one of two lists, in any order; lists that differ are sorted.
fn differing(a: &mut [Couple], b: &mut [Couple]) -> usize {
    // Compares sums over scrambled couples, because sorting tens of millions for each search would take most
    // of the run.
    if a.len() == b.len() && scrambled(a) == scrambled(b) {
        return 0;
    }
    a.sort_unstable();
    b.sort_unstable();
    let (mut i, mut j, mut common) = (0, 0, 0);
    while i < a.len() && j < b.len() {
        common += usize::from(a[i] == b[j]);
        let (next_i, next_j) = (a[i] <= b[j], b[j] <= a[i]);
        i += usize::from(next_i);
        j += usize::from(next_j);
    }
    a.len() + b.len() - 2 * common
}

/// A sum over the couples that does not depend on their order.
fn scrambled(couples: &[Couple]) -> u64 {
    let scramble = |couple: &Couple| {
        let mut bits = u64::from(couple.i) << 32 | u64::from(couple.j);
        for _ in 0..2 {
            bits = (bits ^ bits >> 29).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        }
        bits ^ bits >> 32
    };
    couples.iter().map(scramble).fold(0, u64::wrapping_add)
}

/// Times the searches that agree, in turns, each with its own memory.
fn take_times<const D: usize>(
    plan: &Plan,
    bodies: Bodies<'_, D>,
    mut searches: Vec<Option<Rival<D>>>,
    outcomes: &mut [Searched],
) {
    let (mut tasks, mut timed) = (Vec::new(), Vec::new());
    for (search, outcome) in searches.iter_mut().zip(outcomes) {
        let (Some(search), Ok(_)) = (search, &outcome.times) else { continue };
        let task: Turn<'_, String> = match search {
            Rival::Program(program) => Box::new(|| program.round().map(|answer| answer.seconds)),
            Rival::Inside(search) => {
                let mut couples = Vec::new();
                Box::new(move || {
                    let start = Instant::now();
                    search.couples(black_box(bodies), &mut couples)?;
                    black_box(&couples);
                    Ok(start.elapsed().as_secs_f64())
                })
            }
        };
        tasks.push(task);
        timed.push(outcome);
    }
    for (outcome, times) in timed.into_iter().zip(turns(&mut tasks, plan.rounds, plan.budget)) {
        outcome.times = times.map(Some);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn couples_in_only_one_list_are_counted() {
        let couples = |js: &[u32]| js.iter().map(|&j| Couple::new(0, j)).collect::<Vec<_>>();
        let apart = |a: &[u32], b: &[u32]| differing(&mut couples(a), &mut couples(b));
        assert_eq!(apart(&[1, 2, 3], &[3, 1, 2]), 0);
        assert_eq!(apart(&[1, 3, 5], &[3, 2]), 3);
        assert_eq!(apart(&[1, 3, 5], &[1, 5, 4]), 2);
        assert_eq!(apart(&[], &[2, 3]), 2);
    }
}
