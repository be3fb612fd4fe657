//! Networks that tests share.

use fdem_fluid::*;

/// A fluid of 1 mPa s and 1000 kg/m³ with a bulk modulus, Pa, that cavitates at zero.
pub(crate) fn liquid(bulk_modulus: f64) -> Fluid {
    let (density, reference_pressure, cavitation_pressure) = (1000.0, 0.0, 0.0);
    let state = StateEquation::Liquid { density, reference_pressure, bulk_modulus, cavitation_pressure };
    Fluid { viscosity: 1e-3, state }
}

/// A fluid whose density is the same at all pressures of the tests, to rounding.
pub(crate) fn stiff() -> Fluid {
    liquid(1e22)
}

/// A cell that is empty at first, and whose aperture is its opening.
pub(crate) fn cell<const D: usize>(key: u64, corners: [u32; D]) -> Cell<D> {
    let law = ApertureLaw { residual: 1e-9, ..ApertureLaw::default() };
    Cell { key, corners, law, leak_off: 0.0, initial_pressure: None }
}

/// A wet shape with rigid walls.
pub(crate) fn shape<const D: usize>(corners: [[f64; D]; D], opening: f64) -> Shape<D> {
    Shape { corners, opening, compression: 0.0, compliance: 0.0, is_wet: true }
}

/// Cells and their shapes.
#[derive(Clone)]
pub(crate) struct Mesh<const D: usize> {
    pub(crate) cells: Vec<Cell<D>>,
    pub(crate) shapes: Vec<Shape<D>>,
}

impl<const D: usize> Mesh<D> {
    pub(crate) fn network(&self, model: FlowModel<D>, sources: Vec<Source>) -> Network<D> {
        Network::new(model, sources, &self.cells, &self.shapes).expect("a network")
    }

    /// The same cells, full at a pressure.
    pub(crate) fn full(mut self, pressure: f64) -> Self {
        self.cells.iter_mut().for_each(|cell| cell.initial_pressure = Some(pressure));
        self
    }
}

/// A straight chain of cells along a direction: keys from 0.
pub(crate) fn chain(count: u32, cell_length: f64, opening: f64, [x, y]: [f64; 2]) -> Mesh<2> {
    let at = |k: u32| [x, y].map(|axis| axis * cell_length * f64::from(k));
    Mesh {
        cells: (0..count).map(|k| cell(u64::from(k), [k, k + 1])).collect(),
        shapes: (0..count).map(|k| shape([at(k), at(k + 1)], opening)).collect(),
    }
}

/// A number in [0, 1) that depends on `k` alone.
pub(crate) fn random(k: u32) -> f64 {
    let mut bits = u64::from(k).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A square of `k` by `k` squares of 1 cm in space, each of two triangles, whose vertices are moved by a part
/// of that at random.
pub(crate) fn sheet(k: u32, moved: f64, opening: f64) -> Mesh<3> {
    let vertex = |i: u32, j: u32| j * (k + 1) + i;
    let place = |number: u32| {
        let [i, j] = [number % (k + 1), number / (k + 1)].map(f64::from);
        let move_by = |axis: u32| moved * (random(2 * number + axis) - 0.5);
        [1e-2 * (i + move_by(0)), 1e-2 * (j + move_by(1)), 0.0]
    };
    let mut mesh = Mesh { cells: Vec::new(), shapes: Vec::new() };
    for (j, i) in (0..k).flat_map(|j| (0..k).map(move |i| (j, i))) {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        for corners in [[a, b, c], [a, c, d]] {
            mesh.cells.push(cell(mesh.cells.len() as u64, corners));
            mesh.shapes.push(shape(corners.map(place), opening));
        }
    }
    mesh
}

/// A source without a volume at some cells.
pub(crate) fn at(key: u64, cells: &[u64], drive: Drive) -> Source {
    Source { key, cells: cells.to_vec(), volume: 0.0, drive: Some(drive), initial_pressure: None }
}

pub(crate) fn held(key: u64, cells: &[u64], pressure: f64) -> Source {
    at(key, cells, Drive::Pressure(Schedule::constant(pressure)))
}

pub(crate) fn pumped(key: u64, cells: &[u64], rate: f64) -> Source {
    at(key, cells, Drive::Rate(Schedule::constant(rate)))
}

/// Asserts that two numbers agree to a part of the second one.
pub(crate) fn assert_close(found: f64, exact: f64, part: f64) {
    assert!((found - exact).abs() <= part * exact.abs(), "{found:e} instead of {exact:e}");
}

/// Takes equal steps.
pub(crate) fn advance<const D: usize>(network: &mut Network<D>, steps: u32, step: f64) {
    for _ in 0..steps {
        network.advance(step).expect("a step");
    }
}
