//! Runs on many ranks: the results of one.

use fdem_distributed::{Communicator, threads};
use fdem_simulation::*;
use serde::Serialize;

fn bytes(state: &impl Serialize) -> Vec<u8> {
    postcard::to_allocvec(state).expect("bytes")
}

/// Runs a model on ranks, and compares the states to the last bit after each number of steps, and what results show. Returns the counts at the end.
macro_rules! same_on_ranks {
    ($model:expr, $dimensions:literal, $corners:literal, $ranks:expr, $parts:expr) => {{
        let model: Model<$dimensions, $corners> = $model;
        let mut whole = Simulation::new(model.clone(), 1).expect("a model");
        let mut expected = Vec::new();
        for &steps in $parts {
            whole.advance(steps).expect("steps");
            let cracks = whole.crack_lengths();
            expected.push((
                bytes(&whole.state()),
                whole.snapshot(),
                whole.forces(),
                whole.counts(),
                cracks,
                format!("{:?}", whole.state()),
            ));
        }
        for &size in $ranks {
            let all = threads::run(size, |communicator: &dyn Communicator| {
                let root = communicator.rank() == 0;
                let run = root.then(|| Simulation::new(model.clone(), 1).expect("a model"));
                let mut run = Distributed::new(communicator, run, 1).expect("threads");
                let mut spreads = 0;
                for (steps, (state, snapshot, forces, counts, cracks, dbg)) in $parts.iter().zip(&expected) {
                    run.advance(*steps).expect("steps");
                    let step = run.steps();
                    let gathered = run.gathered();
                    let found = run.forces(gathered.as_ref());
                    let found_counts = run.counts();
                    assert_eq!(run.crack_lengths(), *cracks);
                    assert_eq!(
                        Counts { detections: 0, ..found_counts },
                        Counts { detections: 0, ..*counts },
                        "{size} ranks, step {step}"
                    );
                    if let Some(gathered) = gathered {
                        assert_eq!(gathered.snapshot(), *snapshot, "{size} ranks, step {step}");
                        assert_eq!(found.as_ref(), Some(forces), "{size} ranks, step {step}");
                        let debug = format!("{:?}", gathered.state());
                        if debug != *dbg {
                            let at = debug.bytes().zip(dbg.bytes()).position(|(a, b)| a != b).unwrap_or(0);
                            let a = at.saturating_sub(600);
                            println!(
                                "AT {at} of {} {}\n{}\n----\n{}",
                                debug.len(),
                                dbg.len(),
                                &debug[a..(at + 300).min(debug.len())],
                                &dbg[a..(at + 300).min(dbg.len())]
                            );
                        }
                        assert!(bytes(&gathered.state()) == *state, "{size} ranks, step {step}");
                    }
                    spreads = run.traffic().spreads;
                }
                spreads
            });
            println!("{size} ranks: {} spreads", all[0]);
        }
        whole.counts()
    }};
}

/// Everything that can happen in the plane: joints that are inserted, break and hand over; contacts, damping, weight, a floor.
#[test]
fn a_crash_in_the_plane_is_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crate::resume::crash(insertion);
        let counts = same_on_ranks!(model, 2, 3, &[1, 2, 3, 4, 8], &[1, 299, 700, 500]);
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
    }
}

#[test]
fn a_crash_in_space_is_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crate::space::crash(insertion);
        let counts = same_on_ranks!(model, 3, 4, &[1, 2, 3, 4, 8], &[1, 399, 400]);
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
    }
}
