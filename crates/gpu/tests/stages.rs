//! Runs whose model changes from stage to stage stay on their device.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use fdem_gpu::kernels::Kernel;
use fdem_gpu::{Device, DeviceSolid, GpuError, Host, HostBuild};
use fdem_simulation::{
    Boundary, Change, FractureOptions, Insertion, Load, Material, MaterialLaw, Mesh, Model, Schedule,
    Simulation, Strength, Target,
};

/// The processor, which counts the kernels that it starts, and fails after a number of them. It has no memory
/// for arrays of a megabyte.
struct Counted(Host, Arc<AtomicUsize>, usize);

impl Device for Counted {
    type Memory = <Host as Device>::Memory;

    fn allocate(&self, bytes: usize) -> Result<Self::Memory, GpuError> {
        if bytes > 1_000_000 { Err(GpuError::OutOfMemory { bytes }) } else { self.0.allocate(bytes) }
    }

    fn address(&self, memory: &Self::Memory) -> u64 {
        self.0.address(memory)
    }

    fn bytes(&self, memory: &Self::Memory) -> usize {
        self.0.bytes(memory)
    }

    fn write(&self, to: &mut Self::Memory, bytes: &[u8]) -> Result<(), GpuError> {
        self.0.write(to, bytes)
    }

    fn read(&self, from: &Self::Memory, offset: usize, bytes: &mut [u8]) -> Result<(), GpuError> {
        self.0.read(from, offset, bytes)
    }

    fn launch(&self, kernel: Kernel, blocks: u32, arguments: &[u64]) -> Result<(), GpuError> {
        if self.1.fetch_add(1, Ordering::Relaxed) >= self.2 {
            return Err(GpuError::Driver {
                call: "cuLaunchKernel",
                message: "unspecified launch failure".to_owned(),
            });
        }
        self.0.launch(kernel, blocks, arguments)
    }
}

/// A square of rock under the stress of the ground, held all around.
fn ground(joined: bool, damping: f64) -> Model {
    ground_of(12, joined, damping)
}

fn ground_of(cells: u32, joined: bool, damping: f64) -> Model {
    let side = cells + 1;
    let place = |k: u32| f64::from(k) / f64::from(cells);
    let nodes: Vec<[f64; 2]> = (0..side * side).map(|k| [place(k % side), place(k / side)]).collect();
    let cell = |k: u32| {
        let corner = k % cells + k / cells * side;
        [[corner, corner + 1, corner + side + 1], [corner, corner + side + 1, corner + side]]
    };
    let elements: Vec<[u32; 3]> = (0..cells * cells).flat_map(cell).collect();
    let count = elements.len();
    let strength = Strength {
        tensile: 1e8,
        cohesion: 2e8,
        friction: 0.4,
        energy_i: 300.0,
        energy_ii: 900.0,
        weibull_modulus: None,
        seed: 5,
    };
    let around = (0..).zip(&nodes).filter(|(_, x)| x.iter().any(|x| *x < 1e-9 || *x > 1.0 - 1e-9));
    let around = around.map(|(node, _)| node).collect();
    Model {
        materials: vec![Material {
            name: "rock".to_owned(),
            density: 2600.0,
            youngs_modulus: 5e10,
            poissons_ratio: 0.25,
            law: MaterialLaw::NeoHookean,
            damping,
            strength: joined.then_some(strength),
            friction: 0.6,
        }],
        stresses: vec![[[-5e6, 1e6], [1e6, -8e6]]; count],
        boundaries: vec![Boundary {
            name: "around".to_owned(),
            target: Target::Nodes(around),
            load: Load::Velocity([Some(0.0); 2]),
            schedule: Schedule::Constant,
        }],
        mesh: Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] },
        fracture: FractureOptions { insertion: Insertion::Intrinsic, ..FractureOptions::default() },
        ..Model::default()
    }
}

/// The run that continues without the elements of a tunnel, whose faces are free from then on.
fn excavated(run: &Simulation, width: f64) -> Simulation {
    let model = run.model();
    let far = |nodes: &[u32; 3]| {
        let middle =
            |axis: usize| nodes.iter().map(|&node| model.mesh.nodes[node as usize][axis]).sum::<f64>() / 3.0;
        (0..2).any(|axis| (middle(axis) - 0.5).abs() > width)
    };
    let kept: Vec<bool> = model.mesh.elements.iter().map(far).collect();
    let change = Change::excavating(model, &kept, None).unwrap();
    let (model, state) = run.state().changed(model, change, 1).unwrap();
    Simulation::resume(model, state, 1).unwrap()
}

/// A run of three stages on a device has all numbers of the run on the processor, in a smaller mesh each
/// time.
/// A run that goes to a device between two stages has them, too.
#[test]
fn stages_stay_on_the_device() {
    for (joined, damping) in [(false, 0.3), (true, 0.1), (true, 0.0)] {
        let model = ground(joined, damping);
        let [mut expected, mut run, mut late] = [(); 3].map(|()| Simulation::new(model.clone(), 1).unwrap());
        let launched = Arc::new(AtomicUsize::new(0));
        let device = || Arc::new(Counted(Host(HostBuild::Ascending), Arc::clone(&launched), usize::MAX));
        run.put_on(Box::new(DeviceSolid::new(device()))).unwrap();
        for (stage, width) in [0.1, 0.2, 0.3].into_iter().enumerate() {
            let before = launched.load(Ordering::Relaxed);
            for run in [&mut expected, &mut run, &mut late] {
                run.advance(40).unwrap();
            }
            let steps = launched.load(Ordering::Relaxed) - before;
            assert!(steps >= 40, "stage {stage} is computed elsewhere: {steps} kernels");
            for run in [&run, &late] {
                assert_eq!(run.snapshot(), expected.snapshot(), "stage {stage}");
                assert_eq!(run.energies(), expected.energies(), "stage {stage}");
            }
            for run in [&mut expected, &mut run, &mut late] {
                let next = excavated(run, width);
                run.replace(next).unwrap();
            }
            if stage == 0 {
                late.put_on(Box::new(DeviceSolid::new(device()))).unwrap();
            }
        }
        let moved =
            expected.snapshot().displacements.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(moved > 1e-7, "{moved}");
    }
}

/// A stage for which the device has no memory is an error; the run is on the processor then, and can
/// continue.
#[test]
fn a_stage_for_which_the_device_has_no_memory_is_an_error() {
    let mut run = Simulation::new(ground(false, 0.0), 1).unwrap();
    let launched = Arc::new(AtomicUsize::new(0));
    let device = Arc::new(Counted(Host(HostBuild::Ascending), Arc::clone(&launched), usize::MAX));
    run.put_on(Box::new(DeviceSolid::new(device))).unwrap();
    run.advance(3).unwrap();
    let error = run.replace(Simulation::new(ground_of(120, false, 0.0), 1).unwrap()).unwrap_err();
    assert!(error.to_string().starts_with("the device cannot give "), "{error}");
    let before = launched.load(Ordering::Relaxed);
    run.advance(3).unwrap();
    assert_eq!(launched.load(Ordering::Relaxed), before);
}

/// A device that is lost ends the run with an error, and the last saved state continues on the processor.
#[test]
fn a_lost_device_ends_the_run_and_no_saved_state() {
    let model = ground(true, 0.1);
    let mut expected = Simulation::new(model.clone(), 1).unwrap();
    expected.advance(60).unwrap();
    for more in [0, 1, 2, 3, 50] {
        let mut run = Simulation::new(model.clone(), 1).unwrap();
        let launched = Arc::new(AtomicUsize::new(0));
        let count = Counted(Host(HostBuild::Ascending), Arc::clone(&launched), usize::MAX);
        run.put_on(Box::new(DeviceSolid::new(Arc::new(count)))).unwrap();
        run.advance(20).unwrap();
        let saved = run.state();
        let fails = Counted(Host(HostBuild::Ascending), Arc::new(AtomicUsize::new(0)), more);
        run.take_back();
        run.put_on(Box::new(DeviceSolid::new(Arc::new(fails)))).unwrap();
        let stop = run.advance(40).unwrap_err();
        let words =
            "the device has failed: the driver reports an error (cuLaunchKernel): unspecified launch failure";
        assert_eq!(stop.to_string(), words);
        // It does not run on with numbers that are not there.
        assert_eq!(run.advance(1).unwrap_err().to_string(), words);
        let mut resumed = Simulation::resume(model.clone(), saved, 1).unwrap();
        resumed.advance(40).unwrap();
        assert_eq!(resumed.snapshot(), expected.snapshot());
        assert_eq!(resumed.energies(), expected.energies());
    }
}
