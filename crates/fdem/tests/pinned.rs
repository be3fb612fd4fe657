//! Results of runs, pinned to the last bit: a change that is meant to change no result must change no hash
//! here.
//!
//! A hash covers positions, velocities, stresses, cracks and energies after some steps. Where a change is
//! meant to change results, its commit says which hashes change, and why.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::fs;
use std::path::Path;

use fdem::model::prepare;
use fdem_simulation::{Insertion, Model, Simulation};
use sha2::{Digest, Sha256};

/// Joints that a plate breaks, so that its hash covers cracks.
const BROKEN: usize = 10;

/// A plate with a notch that is torn apart within some thousand steps.
const TORN: &str = r#"
    [model]
    end_time = 1e-3
    gravity = "none"
    [[body]]
    name = "plate"
    material = "rock"
    polygon = { points = [[0, -0.03], [0.04, -0.03], [0.04, 0.03], [0, 0.03], [0, 0.001], [0.01, 0], [0, -0.001]] }
    mesh_size = 2e-3
    [[material]]
    name = "rock"
    density = 2700
    youngs_modulus = 30e9
    poissons_ratio = 0.2
    damping = 0.1
    friction = 0.5
    tensile_strength = 2.5e6
    cohesion = 7.5e6
    friction_angle = 30
    fracture_energy_i = 2.5
    fracture_energy_ii = 12.5
    weibull_modulus = 20
    [[boundary]]
    name = "lower end"
    body = "plate"
    side = "bottom"
    velocity = [0.2, -0.2]
    ramp = 2e-5
    [[boundary]]
    name = "upper end"
    body = "plate"
    side = "top"
    velocity = [-0.2, 0.2]
    ramp = 2e-5
"#;

fn model(text: &str, folder: &Path) -> Model {
    let load = &mut |name: &str| fs::read(folder.join(name)).map_err(|error| error.to_string());
    prepare(text, "pinned.toml", load).unwrap().model
}

/// The run after `steps` steps on `threads` threads.
fn advanced(model: Model, steps: u64, threads: usize) -> Simulation {
    let mut run = Simulation::new(model, threads).unwrap();
    run.advance(steps).unwrap();
    run
}

/// The first 16 digits of the SHA-256 of all that a run has computed.
fn hash(run: &Simulation) -> String {
    let now = run.snapshot();
    let energies = run.energies();
    let mut numbers: Vec<f64> =
        [&now.positions, &now.velocities].into_iter().flatten().flatten().copied().collect();
    numbers.extend(now.stresses.iter().flat_map(|&[xx, yy, zz, xy, ..]| [xx, yy, xy, zz]));
    for crack in &now.cracks {
        numbers.extend(crack.corners.as_flattened());
        numbers.extend([crack.damage, crack.opening, crack.sliding, crack.time.unwrap_or(-1.0)]);
    }
    numbers.extend([energies.kinetic, energies.strain, energies.contact, energies.friction]);
    numbers.extend([energies.cohesive, energies.damping, energies.external]);
    let digest = Sha256::digest(numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>());
    format!("{digest:x}")[..16].to_owned()
}

#[test]
fn examples_give_the_pinned_results() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let found = PINNED.map(|(name, _)| {
        let text = fs::read_to_string(folder.join(format!("{name}.toml"))).unwrap();
        (name, hash(&advanced(model(&text, &folder), 1000, 1)))
    });
    assert_eq!(found, PINNED.map(|(name, hash)| (name, hash.to_owned())));
}

#[test]
fn a_torn_plate_gives_the_pinned_result() {
    for (insertion, steps, pinned) in TORN_PINNED {
        let mut model = model(TORN, Path::new(""));
        model.fracture.insertion = insertion;
        let one = advanced(model.clone(), steps, 1);
        assert!(one.counts().broken >= BROKEN, "{insertion:?}: {} joints broke", one.counts().broken);
        assert_eq!(hash(&one), pinned, "{insertion:?}");
        assert_eq!(hash(&advanced(model, steps, 2)), pinned, "{insertion:?}, two threads");
    }
}

/// Examples after 1000 steps.
const PINNED: [(&str, &str); 9] = [
    ("bar_impact", "5a269dd6385e2ba3"),
    ("borehole", "f6756e4a35697d3a"),
    ("brazilian_disc", "7da8bcb3b1ec2469"),
    ("compression", "80f3a7443417e091"),
    ("falling_blocks", "c15c8b344f815802"),
    ("fragment_heap", "8f3155b87ba32c32"),
    ("rock_slope", "56924b6a6e85dcda"),
    ("sliding_block", "61d05dd33c9a6680"),
    ("three_point_bending", "e295b867c3372069"),
];

/// Hashes of the torn plate after the given numbers of steps.
const TORN_PINNED: [(Insertion, u64, &str); 2] =
    [(Insertion::Adaptive, 4000, "1a420aa6a9ee0b98"), (Insertion::Intrinsic, 4000, "5ed9106b13fe043b")];
