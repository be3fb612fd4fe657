//! The memory of a run on a device, counted before and taken.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use fdem_gpu::kernels::Kernel;
use fdem_gpu::{Device, DeviceSolid, GpuError, Host, HostBuild, memory_of};
use fdem_simulation::{
    Bedding, Element, FractureOptions, Insertion, Material, MaterialLaw, Mesh, Model, Simulation, Strength,
};

/// A grid of cells in simplices, with a joint on every inner face if it is to break.
fn grid<const D: usize, const N: usize>(cells: usize, joined: bool, damping: f64) -> Model<D, N> {
    let side = cells + 1;
    let nodes = (0..side.pow(D as u32))
        .map(|k| std::array::from_fn(|axis| (k / side.pow(axis as u32) % side) as f64))
        .collect();
    let ways: &[(&[usize], bool)] = match D {
        2 => &[(&[0, 1], false), (&[1, 0], true)],
        _ => &[
            (&[0, 1, 2], false),
            (&[1, 2, 0], false),
            (&[2, 0, 1], false),
            (&[0, 2, 1], true),
            (&[1, 0, 2], true),
            (&[2, 1, 0], true),
        ],
    };
    let mut elements = Vec::new();
    for cell in 0..cells.pow(D as u32) {
        let place = |axis: usize| cell / cells.pow(axis as u32) % cells * side.pow(axis as u32);
        let corner: usize = (0..D).map(place).sum();
        for (way, is_odd) in ways {
            let mut element = [corner as u32; N];
            let mut at = corner;
            for (k, &axis) in way.iter().enumerate() {
                at += side.pow(axis as u32);
                element[k + 1] = at as u32;
            }
            if *is_odd {
                element.swap(0, 1);
            }
            elements.push(element);
        }
    }
    let count = elements.len();
    let strength = Strength {
        tensile: 1e6,
        cohesion: 2e6,
        friction: 0.4,
        energy_i: 300.0,
        energy_ii: 900.0,
        weibull_modulus: None,
        seed: 5,
    };
    let material = Material {
        name: "rock".to_owned(),
        density: 2000.0,
        youngs_modulus: 1e9,
        poissons_ratio: 0.2,
        law: MaterialLaw::NeoHookean,
        damping,
        strength: joined.then_some(strength),
        friction: 0.5,
    };
    Model {
        mesh: Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] },
        materials: vec![material],
        fracture: FractureOptions { insertion: Insertion::Intrinsic, ..FractureOptions::default() },
        ..Model::default()
    }
}

/// The processor, which counts the bytes that are allocated on it, less those that are freed, and has a
/// number of them at most.
struct Counted(Host, Arc<AtomicUsize>, usize);

struct CountedMemory {
    memory: <Host as Device>::Memory,
    bytes: usize,
    held: Arc<AtomicUsize>,
}

impl Drop for CountedMemory {
    fn drop(&mut self) {
        self.held.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Device for Counted {
    type Memory = CountedMemory;

    fn allocate(&self, bytes: usize) -> Result<CountedMemory, GpuError> {
        if self.1.load(Ordering::Relaxed) + bytes > self.2 {
            return Err(GpuError::OutOfMemory { bytes });
        }
        let memory = self.0.allocate(bytes)?;
        self.1.fetch_add(bytes, Ordering::Relaxed);
        Ok(CountedMemory { memory, bytes, held: Arc::clone(&self.1) })
    }

    fn address(&self, memory: &CountedMemory) -> u64 {
        self.0.address(&memory.memory)
    }

    fn bytes(&self, memory: &CountedMemory) -> usize {
        self.0.bytes(&memory.memory)
    }

    fn write(&self, to: &mut CountedMemory, bytes: &[u8]) -> Result<(), GpuError> {
        self.0.write(&mut to.memory, bytes)
    }

    fn read(&self, from: &CountedMemory, offset: usize, bytes: &mut [u8]) -> Result<(), GpuError> {
        self.0.read(&from.memory, offset, bytes)
    }

    fn launch(&self, kernel: Kernel, blocks: u32, arguments: &[u64]) -> Result<(), GpuError> {
        self.0.launch(kernel, blocks, arguments)
    }
}

/// The memory of a model is the one counted before, when it is put on a device and in its steps. Returns
/// the bytes for each element.
fn is_foretold<const D: usize, const N: usize>(model: &Model<D, N>) -> f64
where
    [[f64; D]; N]: Element<D, N>,
{
    let new = || Simulation::new(model.clone(), 1).unwrap();
    let foretold = memory_of(&mut new()).unwrap();
    let held = Arc::new(AtomicUsize::new(0));
    let mut run = new();
    let device = Counted(Host(HostBuild::Ascending), Arc::clone(&held), usize::MAX);
    run.put_on(Box::new(DeviceSolid::new(Arc::new(device)))).unwrap();
    assert_eq!(held.load(Ordering::Relaxed), foretold);
    run.advance(2).unwrap();
    let later = held.load(Ordering::Relaxed);
    // Steps need short lists beside the columns.
    assert!(later >= foretold && later - foretold < foretold / 10, "{foretold} bytes, later {later}");
    run.take_back();
    assert_eq!(held.load(Ordering::Relaxed), 0, "all of it is free again");
    foretold as f64 / model.mesh.elements.len() as f64
}

/// Memory of the driver, which the page counts, too: a guess, bytes.
const DRIVER: f64 = 0.6e9;

/// The line of the page for a body with this memory an element, and the elements that fit into cards.
fn line(body: &str, bytes: f64) -> String {
    let fits = [8e9, 24e9, 80e9, 141e9].map(|memory| {
        let millions = (memory - DRIVER) / bytes / 1e6;
        format!("{millions:.0} M")
    });
    format!("| {body} | {bytes:.0} | {} |", fits.join(" | "))
}

#[test]
fn the_memory_of_a_run_is_foretold() {
    let lines = [
        line("triangles", is_foretold(&grid::<2, 3>(60, false, 0.0))),
        line("triangles, a joint on every face", is_foretold(&grid::<2, 3>(60, true, 0.0))),
        line("tetrahedra", is_foretold(&grid::<3, 4>(14, false, 0.0))),
        line("tetrahedra, a joint on every face", is_foretold(&grid::<3, 4>(14, true, 0.0))),
    ];
    let page = include_str!("../../../book/src/gpu.md");
    assert!(page.contains(&lines.join("\n")), "the page lacks these lines:\n{}", lines.join("\n"));
    // Viscous stresses, and the energy that they dissipate.
    let viscous = is_foretold(&grid::<3, 4>(14, false, 0.1)) - is_foretold(&grid::<3, 4>(14, false, 0.0));
    assert!((viscous - 88.0).abs() < 0.1, "{viscous}");
}

/// A material with bedding takes the present normal of each element.
#[test]
fn the_memory_of_a_run_with_bedding_is_foretold() {
    let mut model = grid::<2, 3>(60, false, 0.0);
    let plain = is_foretold(&model);
    let youngs_modulus = 0.8 * model.materials[0].youngs_modulus;
    model.materials[0].law = MaterialLaw::TransverselyIsotropic(Bedding {
        normal: [0.0, 1.0, 0.0],
        youngs_modulus,
        poissons_ratio: 0.1,
        shear_modulus: 0.3 * youngs_modulus,
        strength: None,
    });
    let more = is_foretold(&model) - plain;
    assert!((more - 16.0).abs() < 0.1, "{more}");
}

/// A device with too little memory refuses a run, frees all that it took, and the run continues on the
/// processor.
#[test]
fn too_little_memory_is_an_error_and_the_run_stays() {
    let model = grid::<2, 3>(9, true, 0.0);
    let mut expected = Simulation::new(model.clone(), 1).unwrap();
    let mut run = Simulation::new(model, 1).unwrap();
    let needed = memory_of(&mut run).unwrap();
    let held = Arc::new(AtomicUsize::new(0));
    for most in [needed - 1, needed / 2, 1000] {
        let device = Counted(Host(HostBuild::Ascending), Arc::clone(&held), most);
        let error = run.put_on(Box::new(DeviceSolid::new(Arc::new(device)))).unwrap_err();
        assert!(error.to_string().starts_with("the device cannot give "), "{error}");
        assert_eq!(held.load(Ordering::Relaxed), 0);
    }
    let device = Counted(Host(HostBuild::Ascending), Arc::clone(&held), needed);
    run.put_on(Box::new(DeviceSolid::new(Arc::new(device)))).unwrap();
    run.take_back();
    for run in [&mut run, &mut expected] {
        run.advance(20).unwrap();
    }
    assert_eq!(run.snapshot(), expected.snapshot());
}
