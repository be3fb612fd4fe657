//! No rank but the first holds anything of the length of the whole: the memory of a rank grows with its
//! share.
//!
//! A separate program, because it replaces the allocator by one that counts. The ranks are threads, so the
//! peak is that of all of them together; an array with four bytes for each element on each rank would
//! multiply with the number of ranks.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a failed unwrap is a failed test")]

use fdem_distributed::threads;
use fdem_simulation::{Distributed, Material, Model, Simulation, Strength};
use peak_alloc::PeakAlloc;

#[path = "suite/common.rs"]
#[allow(dead_code, reason = "the other tests use more of it")]
mod common;
use common::{granite, rectangle, rock};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// A strip, so long that the borders between ranks are as long on any number of them. It is drawn apart, and
/// breaks in many places in one step.
fn strip(length: usize) -> Model {
    let mesh = rectangle([0.0; 2], [4e-3, 1e-3 * length as f64], 4, length);
    let strength =
        Strength { tensile: 5e6, cohesion: 10e6, friction: 0.6, energy_i: 1.0, energy_ii: 4.0, ..rock() };
    let middle = 5e-4 * length as f64;
    let velocities = mesh.nodes.iter().map(|[_, y]| [0.0, 20.0 * (y / middle - 1.0) * length as f64 / 100.0]);
    Model {
        velocities: velocities.collect(),
        mesh,
        materials: vec![Material {
            strength: Some(strength),
            friction: 0.5,
            poissons_ratio: 0.25,
            ..granite()
        }],
        ..Model::default()
    }
}

/// Memory of all ranks together, with that of the model, in bytes per element: after they have advanced the
/// run and divided it again, and the peak meanwhile.
fn held(size: usize, length: usize) -> [f64; 2] {
    let model = strip(length);
    let elements = model.mesh.elements.len();
    let held = threads::run(size, |communicator| {
        let first = communicator.rank() == 0;
        let whole = first.then(|| Simulation::new(model.clone(), 1).unwrap());
        let mut run = Distributed::new(communicator, whole, 1).unwrap();
        communicator.barrier();
        if first {
            ALLOCATOR.reset_peak_usage();
        }
        communicator.barrier();
        for _ in 0..3 {
            run.advance(100).unwrap();
            run.rebalance();
        }
        assert!(run.counts().broken > 20, "{:?}", run.counts());
        assert!(run.traffic().spreads >= 2);
        run.crack_lengths();
        run.nodes(&[3]);
        communicator.barrier();
        let held = [ALLOCATOR.current_usage(), ALLOCATOR.peak_usage()];
        communicator.barrier();
        held
    });
    held[0].map(|bytes| bytes as f64 / elements as f64)
}

fn main() {
    // The same number of elements on each rank. A rank with four bytes for each element of the whole would
    // add 96 bytes for each element on 32 ranks, more than on 8. The channels of each pair of ranks add 20 to
    // 30. The most depends on the ranks that happen to be busy at once, so one of three runs must show it.
    let is_even = || {
        let [few, many] = [8, 32].map(|size| held(size, 400 * size));
        println!("{few:.0?} bytes for an element on 8 ranks, {many:.0?} on 32, and the most meanwhile");
        few.into_iter().zip(many).all(|(few, many)| many - few < 48.0)
    };
    assert!((0..3).any(|_| is_even()), "the memory of a rank has grown with the whole");
}
