//! No rank but the first holds anything of the length of the whole: the memory of a rank grows with its share.
//!
//! A program of its own, because it replaces the allocator by one that counts. The ranks are threads, so the peak is that of all of them together; an array with four bytes for each element
//! on each rank would multiply with the number of ranks.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a failed unwrap is a failed test")]

use std::sync::Mutex;

use fdem_distributed::threads;
use fdem_simulation::{Distributed, Insertion, Material, Mesh, Model, Simulation, Strength};

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// A strip, so long that the borders between ranks are as long on any number of them. It is drawn apart, and breaks.
fn strip(length: u32) -> Model {
    let height = 4;
    let node = |x: u32, y: u32| x * (height + 1) + y;
    let places = (0..=length).flat_map(|x| (0..=height).map(move |y| [f64::from(x), f64::from(y)]));
    let nodes: Vec<[f64; 2]> = places.map(|place| place.map(|x| 1e-3 * x)).collect();
    let squares = (0..length).flat_map(|x| (0..height).map(move |y| (x, y)));
    let halves = squares.flat_map(|(x, y)| {
        let [a, b, c, d] = [node(x, y), node(x + 1, y), node(x + 1, y + 1), node(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    let elements: Vec<[u32; 3]> = halves.collect();
    let material = Material {
        name: "rock".to_owned(),
        density: 2700.0,
        youngs_modulus: 50e9,
        poissons_ratio: 0.25,
        damping: 0.0,
        strength: Some(Strength {
            tensile: 5e6,
            cohesion: 10e6,
            friction: 0.6,
            energy_i: 1.0,
            energy_ii: 4.0,
            weibull_modulus: None,
            seed: 0,
        }),
        friction: 0.5,
    };
    let (count, middle) = (elements.len(), 5e-4 * f64::from(length));
    let velocities = nodes.iter().map(|[x, _]| [20.0 * (x / middle - 1.0) * f64::from(length) / 100.0, 0.0]);
    let mut model = Model {
        velocities: velocities.collect(),
        mesh: Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] },
        materials: vec![material],
        ..Model::default()
    };
    model.fracture.insertion = Insertion::Adaptive;
    model
}

/// Memory of all ranks together, in bytes per element: what they hold after they have advanced the run and divided it anew, and the most that they held meanwhile.
fn held(size: usize, length: u32) -> [f64; 2] {
    let model = strip(length);
    let elements = model.mesh.elements.len();
    let profiler = Mutex::new(None);
    let held = threads::run(size, |communicator| {
        let first = communicator.rank() == 0;
        let whole = first.then(|| Simulation::new(model.clone(), 1).unwrap());
        let mut run = Distributed::new(communicator, whole, 1).unwrap();
        communicator.barrier();
        if first {
            *profiler.lock().unwrap() = Some(dhat::Profiler::builder().testing().build());
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
        let held = dhat::HeapStats::get();
        communicator.barrier();
        [held.curr_bytes, held.max_bytes]
    });
    drop(profiler);
    held[0].map(|bytes| bytes as f64 / elements as f64)
}

fn main() {
    // The same number of elements on each rank. A rank with four bytes for each element of the whole would add 96 bytes for each element on 32 ranks, more than on 8.
    let [few, many] = [8, 32].map(|size| held(size, 150 * size as u32));
    println!("{few:.0?} bytes for an element on 8 ranks, {many:.0?} on 32, and the most meanwhile");
    for (few, many) in few.into_iter().zip(many) {
        assert!(many - few < 48.0, "the memory of a rank has grown with the whole");
    }
}
