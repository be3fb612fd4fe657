//! Examples on many ranks, which are threads here: the results of one. `tests/mpirun.sh` runs the command on
//! processes.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::fs;
use std::path::{Path, PathBuf};

use fdem::model::{AnyPrepared, prepare_any};
use fdem_distributed::{Communicator, threads};
use fdem_simulation::{Leader, Simulation, follow};

/// Numbers of ranks, and threads of each.
const RANKS: [[usize; 2]; 2] = [[3, 2], [8, 1]];

/// Runs a model in one process and on ranks that one leads, and compares the states, the frames and the
/// records of a history.
macro_rules! same_on_ranks {
    ($name:expr, $model:expr, $steps:expr) => {{
        let nodes = [0, $model.mesh.nodes.len() as u32 / 2, u32::MAX];
        let mut whole = Simulation::new($model.clone(), 1).unwrap();
        whole.advance($steps / 2).unwrap();
        // Some models have no boundary, or one that absorbs waves.
        let set = whole.set_factor(0, Some(0.75)).is_ok();
        whole.advance($steps - $steps / 2).unwrap();
        let state = postcard::to_allocvec(&whole.state()).unwrap();
        for [ranks, threads_of_each] in RANKS {
            threads::run(ranks, |communicator: &dyn Communicator| {
                if communicator.rank() > 0 {
                    return follow(communicator, threads_of_each).unwrap();
                }
                let run = Simulation::new($model.clone(), 1).unwrap();
                let mut run = Leader::new(communicator, run, threads_of_each).unwrap();
                run.advance($steps / 2).unwrap();
                assert_eq!(run.set_factor(0, 0.75).is_ok(), set);
                run.advance($steps - $steps / 2).unwrap();
                let place = format!("{} on {ranks} ranks", $name);
                assert!(postcard::to_allocvec(&run.state()).unwrap() == state, "{place}");
                let (snapshot, forces) = run.frame();
                assert!(snapshot == whole.snapshot() && forces == whole.forces(), "{place}");
                assert_eq!(run.energies(), whole.energies(), "{place}");
                assert_eq!(run.nodes(&nodes), whole.nodes(&nodes), "{place}");
                assert_eq!(run.crack_lengths(), whole.crack_lengths(), "{place}");
                assert_eq!(run.fragments(), whole.fragments(), "{place}");
                assert_eq!(run.penetrated(), whole.penetrated(), "{place}");
                for boundary in 0..=$model.boundaries.len() {
                    assert_eq!(run.force(boundary), whole.force(boundary), "{place}");
                }
                assert_eq!(
                    run.traffic().iter().map(|rank| rank.own).sum::<usize>(),
                    run.elements(),
                    "{place}"
                );
            });
        }
    }};
}

/// All models in a folder.
fn models(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut models: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|extension| extension == "toml")).collect();
    models.sort();
    models
}

fn all_are_the_same(folder: &str, steps: u64) {
    for path in models(folder) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let text = fs::read_to_string(&path).unwrap();
        let load =
            &mut |file: &str| fs::read(path.parent().unwrap().join(file)).map_err(|error| error.to_string());
        match prepare_any(&text, &name, load, None).unwrap() {
            // Spheres alone are refused on ranks: another test asserts it.
            AnyPrepared::Plane(prepared) if prepared.model.mesh.elements.is_empty() => {}
            AnyPrepared::Space(prepared) if prepared.model.mesh.elements.is_empty() => {}
            // And so is liquid in pores.
            AnyPrepared::Plane(prepared) if prepared.model.pores.is_some() => {}
            AnyPrepared::Space(prepared) if prepared.model.pores.is_some() => {}
            AnyPrepared::Plane(prepared) => same_on_ranks!(name, prepared.model, steps),
            AnyPrepared::Space(prepared) => same_on_ranks!(name, prepared.model, steps),
        }
    }
}

#[test]
fn examples_in_the_plane_are_the_same() {
    all_are_the_same("examples", 300);
}

#[test]
fn examples_in_space_are_the_same() {
    all_are_the_same("examples/space", 40);
}
