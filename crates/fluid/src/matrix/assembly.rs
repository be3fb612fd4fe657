//! Storage of vertices and conductances between them, from the shapes of elements.

use crate::error::{FluidError, check};
use crate::matrix::material::PorousMaterial;

/// A triangle (`N` = 3) or a tetrahedron (`N` = 4) with pores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PorousElement<const N: usize> {
    /// Numbers of its vertices in the undeformed mesh: flow is continuous over equal numbers.
    pub vertices: [u32; N],
    /// Number of its material.
    pub material: u32,
}

/// Numbers of the undeformed mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Assembly {
    /// Volume of each element, m³.
    pub(super) volumes: Vec<f64>,
    /// Elements by their vertices: sums are in this order.
    pub(super) order: Vec<u32>,
    /// Liquid that a vertex takes for each Pa, m³/Pa; zero at vertices without pores.
    pub(super) storage: Vec<f64>,
    /// Pairs of vertices with a common element, the smaller number first, in rising order.
    pub(super) pairs: Vec<[u32; 2]>,
    /// Volume that flows between each pair for each Pa, m³/(s Pa).
    pub(super) conductances: Vec<f64>,
}

impl Assembly {
    /// `scale`: the thickness of a model in the plane, m, which is ignored in space, and the viscosity, Pa s.
    pub(super) fn of<const D: usize, const N: usize>(
        places: &[[f64; D]],
        elements: &[PorousElement<N>],
        materials: &[PorousMaterial<D>],
        [thickness, viscosity]: [f64; 2],
    ) -> Result<Self, FluidError> {
        let mut order: Vec<u32> = (0..elements.len() as u32).collect();
        let sorted = |element: u32| {
            let mut vertices = elements[element as usize].vertices;
            vertices.sort_unstable();
            vertices
        };
        order.sort_by_key(|element| sorted(*element));
        let mut new =
            Self { volumes: vec![0.0; elements.len()], storage: vec![0.0; places.len()], ..Self::default() };
        let mut links: Vec<([u32; 2], f64)> = Vec::new();
        for &element in &order {
            let of = &elements[element as usize];
            let place = || format!("element {element}");
            let Some(material) = materials.get(of.material as usize) else {
                let (what, range) = ("number of the material", "below the number of materials");
                let value = f64::from(of.material);
                return Err(FluidError::OutOfRange { place: place(), what, value, range });
            };
            for vertex in of.vertices {
                let is_there = (vertex as usize) < places.len();
                let range = "below the number of vertices";
                check(is_there, place(), "number of a vertex", f64::from(vertex), range)?;
            }
            let (volume, gradients) = gradients(of.vertices.map(|vertex| places[vertex as usize]));
            let volume = if D == 2 { volume * thickness } else { volume };
            check(volume > 0.0, place(), "volume", volume, "positive")?;
            new.volumes[element as usize] = volume;
            for vertex in of.vertices {
                new.storage[vertex as usize] += material.storage * volume / N as f64;
            }
            for (a, b) in (0..N).flat_map(|a| (a + 1..N).map(move |b| (a, b))) {
                let product = along(&gradients[a], &material.permeability, &gradients[b]);
                let ends = [of.vertices[a], of.vertices[b]];
                let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                check(ends[0] != ends[1], place(), "vertex", f64::from(ends[0]), "there once")?;
                links.push((ends, -volume * product / viscosity));
            }
        }
        new.order = order;
        // Equal pairs stay in the order of their elements.
        links.sort_by_key(|(ends, _)| *ends);
        for of_pair in links.chunk_by(|a, b| a.0 == b.0) {
            new.pairs.push(of_pair[0].0);
            new.conductances.push(of_pair.iter().fold(0.0, |sum, (_, conductance)| sum + conductance));
        }
        Ok(new)
    }
}

/// Darcy's flow `-k/μ ∇h` of an element with these heads at its corners, m/s.
pub(super) fn flow<const D: usize, const N: usize>(
    corners: [[f64; D]; N],
    heads: [f64; N],
    permeability: &[[f64; D]; D],
    viscosity: f64,
) -> [f64; D] {
    let (_, gradients) = gradients(corners);
    let of = |axis: usize| {
        let sum = |sum, corner: usize| {
            let along = (0..D).fold(0.0, |sum, k| sum + permeability[axis][k] * gradients[corner][k]);
            sum + along * heads[corner]
        };
        -(0..N).fold(0.0, sum) / viscosity
    };
    std::array::from_fn(of)
}

/// `a·k·b`
fn along<const D: usize>(a: &[f64; D], k: &[[f64; D]; D], b: &[f64; D]) -> f64 {
    (0..D).fold(0.0, |sum, row| (0..D).fold(sum, |sum, column| sum + a[row] * k[row][column] * b[column]))
}

/// The measure of a triangle or tetrahedron, and the gradient of the linear function that is 1 at a corner
/// and 0 at the others, for each corner. The measure is zero, and gradients are not numbers, if it is flat.
fn gradients<const D: usize, const N: usize>(corners: [[f64; D]; N]) -> (f64, [[f64; D]; N]) {
    const { assert!((D == 2 || D == 3) && N == D + 1, "elements are triangles or tetrahedra") };
    // The rows of the matrix are edges from corner 0; the columns of its inverse are the gradients.
    let mut rows: [[f64; D]; D] =
        std::array::from_fn(|k| std::array::from_fn(|axis| corners[k + 1][axis] - corners[0][axis]));
    let mut inverse: [[f64; D]; D] =
        std::array::from_fn(|k| std::array::from_fn(|column| f64::from(u8::from(k == column))));
    let mut measure = 1.0;
    for column in 0..D {
        let pivot = (column + 1..D).fold(column, |best, row| {
            if rows[row][column].abs() > rows[best][column].abs() { row } else { best }
        });
        rows.swap(column, pivot);
        inverse.swap(column, pivot);
        let scale = rows[column][column];
        measure *= scale / (column + 1) as f64;
        for value in rows[column].iter_mut().chain(&mut inverse[column]) {
            *value /= scale;
        }
        let (of_rows, of_inverse) = (rows[column], inverse[column]);
        for row in (0..D).filter(|row| *row != column) {
            let factor = rows[row][column];
            for axis in 0..D {
                rows[row][axis] -= factor * of_rows[axis];
                inverse[row][axis] -= factor * of_inverse[axis];
            }
        }
    }
    let mut gradients = [[0.0; D]; N];
    for k in 0..D {
        for axis in 0..D {
            gradients[k + 1][axis] = inverse[axis][k];
            gradients[0][axis] -= inverse[axis][k];
        }
    }
    (measure.abs(), gradients)
}
