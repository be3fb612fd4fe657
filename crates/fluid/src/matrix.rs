//! Flow in the pores of elements: Darcy's law, storage, and the change of the volume of elements.
//!
//! Its parts import each other in this order: `material`, `state`, `assembly`; this file is above them.

mod assembly;
mod material;
mod state;

use serde::{Deserialize, Serialize};

use crate::error::{FluidError, check};
use crate::ldl::Ldl;
use crate::matrix::assembly::Assembly;
pub use crate::matrix::assembly::PorousElement;
pub use crate::matrix::material::PorousMaterial;
pub use crate::matrix::state::{MatrixState, PoreBalance};
use crate::source::Drive;

/// The liquid in pores, and its weight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub struct PoreLiquid<const D: usize> {
    /// Dynamic viscosity, Pa s.
    pub viscosity: f64,
    /// Density, kg/m³: that of its weight.
    pub density: f64,
    /// Gravity, m/s².
    pub gravity: [f64; D],
}

impl<const D: usize> PoreLiquid<D> {
    /// Water at 20 °C without weight.
    pub const WATER: Self = Self { viscosity: 1e-3, density: 998.0, gravity: [0.0; D] };

    fn check(&self) -> Result<(), FluidError> {
        check(self.viscosity > 0.0, "liquid", "viscosity", self.viscosity, "positive")?;
        check(self.density >= 0.0, "liquid", "density", self.density, "zero or positive")?;
        self.gravity.iter().try_for_each(|&value| check(true, "liquid", "gravity", value, "finite"))
    }
}

/// A part of the surface of the pores, or wells in them. The rest of the surface is sealed.
#[derive(Clone, Debug, PartialEq)]
pub struct PoreBoundary {
    /// Identity of the boundary: no other one has it.
    pub key: u64,
    /// Numbers of its vertices, each once.
    pub vertices: Vec<u32>,
    /// Factor of each vertex: of a prescribed pressure, or its share of a rate. The share of a vertex in a
    /// uniform flow is the sum of `A/D` over its facets of the area `A` with `D` corners, over the whole
    /// area.
    pub factors: Vec<f64>,
    /// Pressure, or rate of all vertices together, m³/s.
    pub drive: Drive,
}

/// Liquid in the pores of triangles or tetrahedra, and its flow.
///
/// The front page of the crate has the equations, and the order of calls in a coupled step.
///
/// # Cost
/// [`new`](Self::new) analyses the matrix, and the first [`advance`](Self::advance) computes its factors.
/// These serve until the length of the step or the vertices with a prescribed pressure change. A step then
/// takes two triangular solutions. The factors of `n` vertices have about `8 n log n` entries in the plane,
/// and about `n^(4/3)` with a large factor in space, where `n^2` operations compute them.
#[derive(Clone, Debug)]
pub struct PorousMatrix<const D: usize, const N: usize> {
    elements: Vec<PorousElement<N>>,
    materials: Vec<PorousMaterial<D>>,
    /// By their keys.
    boundaries: Vec<PoreBoundary>,
    /// The boundary that prescribes the pressure of each vertex, and its factor.
    holders: Vec<Option<(u32, f64)>>,
    assembly: Assembly,
    places: Vec<[f64; D]>,
    viscosity: f64,
    /// Pressure of a liquid at rest, Pa: density times gravity times the place.
    rest: Vec<f64>,
    /// Volume by which pores have grown with the body around each vertex, m³.
    growth: Vec<f64>,
    solver: Ldl,
    /// The length of the step of the factors.
    factored: Option<f64>,
    state: MatrixState,
}

impl<const D: usize, const N: usize> PorousMatrix<D, N> {
    /// Pores of an undeformed body at time 0.
    ///
    /// # Shapes
    /// `places`: each vertex, m. `initial`: the pressure of each vertex, Pa; empty for zero.
    ///
    /// # Errors
    /// Numbers out of their ranges, elements without a volume, boundaries with the same key, and vertices
    /// whose pressure two boundaries prescribe.
    pub fn new(
        liquid: &PoreLiquid<D>,
        thickness: f64,
        places: &[[f64; D]],
        elements: Vec<PorousElement<N>>,
        materials: Vec<PorousMaterial<D>>,
        mut boundaries: Vec<PoreBoundary>,
        initial: &[f64],
    ) -> Result<Self, FluidError> {
        liquid.check()?;
        check(thickness > 0.0, "model", "thickness", thickness, "positive")?;
        (materials.iter().enumerate())
            .try_for_each(|(k, material)| material.check(&format!("porous material {k}")))?;
        if !(initial.is_empty() || initial.len() == places.len()) {
            let (found, expected) = (initial.len(), places.len());
            return Err(FluidError::Length { what: "initial pressures", found, expected });
        }
        for (k, &pressure) in initial.iter().enumerate() {
            check(true, format!("vertex {k}"), "initial pressure", pressure, "finite")?;
        }
        boundaries.sort_by_key(|boundary| boundary.key);
        let assembly = Assembly::of(places, &elements, &materials, [thickness, liquid.viscosity])?;
        let holders = holders(&boundaries, &assembly.storage)?;
        let of_initial = |k: usize| initial.get(k).copied().unwrap_or(0.0);
        let pressure: Vec<f64> =
            (0..places.len()).map(|k| if assembly.storage[k] > 0.0 { of_initial(k) } else { 0.0 }).collect();
        let content: Vec<f64> = assembly.storage.iter().zip(&pressure).map(|(s, p)| s * p).collect();
        let initial = sum(&content);
        let inflow = vec![0.0; boundaries.len()];
        let state = MatrixState { content, pressure, inflow, initial, ..MatrixState::default() };
        let weight =
            |place: &[f64; D]| (0..D).fold(0.0, |sum, axis| sum + liquid.gravity[axis] * place[axis]);
        Ok(Self {
            rest: places.iter().map(|place| liquid.density * weight(place)).collect(),
            places: places.to_vec(),
            viscosity: liquid.viscosity,
            growth: vec![0.0; places.len()],
            solver: Ldl::of(places.len(), &assembly.pairs),
            factored: None,
            elements,
            materials,
            boundaries,
            holders,
            assembly,
            state,
        })
    }

    /// Takes over how far elements have grown, m³: their present volumes less their undeformed ones. The
    /// liquid stays where it is, so pressures fall where elements grow.
    ///
    /// # Errors
    /// A list of another length.
    pub fn deform(&mut self, growth: &[f64]) -> Result<(), FluidError> {
        let (found, expected) = (growth.len(), self.elements.len());
        if found != expected {
            return Err(FluidError::Length { what: "volumes of elements", found, expected });
        }
        self.growth.fill(0.0);
        for &element in &self.assembly.order {
            let of = &self.elements[element as usize];
            let share = self.materials[of.material as usize].biot * growth[element as usize] / N as f64;
            of.vertices.iter().for_each(|vertex| self.growth[*vertex as usize] += share);
        }
        self.settle();
        Ok(())
    }

    /// Finds the pressures of the present contents.
    fn settle(&mut self) {
        for (k, &storage) in self.assembly.storage.iter().enumerate() {
            if storage > 0.0 {
                self.state.pressure[k] = (self.state.content[k] - self.growth[k]) / storage;
            }
        }
    }

    /// Advances by a step, s, in which the body stays as it is.
    ///
    /// # Errors
    /// [`FluidError::Pivot`], which names a vertex, and a step that is not positive. The state is unchanged
    /// then.
    pub fn advance(&mut self, step: f64) -> Result<(), FluidError> {
        let begin = self.state.time;
        let end = begin + step;
        check(step > 0.0 && end > begin, "pores", "step", step, "positive, and not lost beside the time")?;
        self.factor(step)?;
        let held: Vec<Option<f64>> = (0..self.holders.len()).map(|k| self.held(k, end)).collect();
        let (supplied, rates) = self.supplied(end);
        // The change of the pressure: where it vanishes, the flow is steady to rounding.
        let mut change = self.gains(&supplied, &self.state.pressure, step);
        for k in 0..change.len() {
            if let Some(pressure) = held[k] {
                change[k] = pressure - self.state.pressure[k];
            } else if self.assembly.storage[k] == 0.0 {
                change[k] = 0.0;
            }
        }
        for (&[a, b], conductance) in self.assembly.pairs.iter().zip(&self.assembly.conductances) {
            let [a, b] = [a as usize, b as usize];
            match [held[a].is_some(), held[b].is_some()] {
                [true, false] => change[b] += step * conductance * change[a],
                [false, true] => change[a] += step * conductance * change[b],
                _ => {}
            }
        }
        self.solver.solve(&mut change);
        let pressure: Vec<f64> =
            self.state.pressure.iter().zip(&change).map(|(before, change)| before + change).collect();
        let gains = self.gains(&supplied, &pressure, step);
        for (inflow, rate) in self.state.inflow.iter_mut().zip(rates) {
            *inflow += rate;
        }
        for (k, gain) in gains.into_iter().enumerate() {
            let Some(pressure) = held[k] else {
                self.state.content[k] += gain;
                self.state.moved += gain.abs() + supplied[k].abs();
                continue;
            };
            let content = self.assembly.storage[k] * pressure + self.growth[k];
            let inflow = (content - self.state.content[k]) - gain;
            self.state.content[k] = content;
            self.state.moved += gain.abs() + supplied[k].abs() + inflow.abs();
            if let Some((boundary, _)) = self.holders[k] {
                self.state.inflow[boundary as usize] += inflow;
            }
        }
        self.settle();
        for (k, held) in held.into_iter().enumerate() {
            self.state.pressure[k] = held.unwrap_or(self.state.pressure[k]);
        }
        self.state.time = end;
        Ok(())
    }

    /// Adds volumes to vertices with pores, m³: those that come out of cracks.
    pub(crate) fn gain(&mut self, gains: &[(u32, f64)]) {
        for &(vertex, volume) in gains {
            let vertex = vertex as usize;
            self.state.content[vertex] += volume;
            self.state.pressure[vertex] += volume / self.assembly.storage[vertex];
            self.state.exchanged += volume;
            self.state.moved += volume.abs();
        }
    }

    /// Computes the factors of the matrix for a length of the step, if they are not there.
    fn factor(&mut self, step: f64) -> Result<(), FluidError> {
        if self.factored == Some(step) {
            return Ok(());
        }
        self.factored = None;
        let is_free = |k: usize| self.holders[k].is_none() && self.assembly.storage[k] > 0.0;
        let storage = |(k, &storage): (usize, &f64)| if is_free(k) { storage } else { 1.0 };
        let mut diagonal: Vec<f64> = self.assembly.storage.iter().enumerate().map(storage).collect();
        let (mut sums, mut entries) = (diagonal.clone(), Vec::with_capacity(self.assembly.pairs.len()));
        for (ends, conductance) in self.assembly.pairs.iter().zip(&self.assembly.conductances) {
            let ends = ends.map(|end| end as usize);
            let weight = step * conductance;
            let is_inside = ends.into_iter().all(is_free);
            for k in ends.into_iter().filter(|k| is_free(*k)) {
                diagonal[k] += weight;
                sums[k] += if is_inside { 0.0 } else { weight };
            }
            entries.push(if is_inside { -weight } else { 0.0 });
        }
        // Opposite to obtuse angles, conductances are negative.
        let sums = self.assembly.conductances.iter().all(|of| *of >= 0.0).then_some(&sums[..]);
        let pivot = |k: usize| FluidError::Pivot { what: "vertex", key: k as u64 };
        self.solver.factor(&diagonal, &entries, sums).map_err(pivot)?;
        self.factored = Some(step);
        Ok(())
    }

    /// The prescribed pressure of a vertex at a time, Pa.
    fn held(&self, vertex: usize, time: f64) -> Option<f64> {
        let (boundary, factor) = self.holders[vertex]?;
        match &self.boundaries[boundary as usize].drive {
            Drive::Pressure(pressure) => Some(factor * pressure.at(time)),
            Drive::Rate(_) => None,
        }
    }

    /// Volume that rates supply until a time, m³: to each vertex, and of each boundary.
    fn supplied(&self, end: f64) -> (Vec<f64>, Vec<f64>) {
        let mut supplied = vec![0.0; self.holders.len()];
        let mut rates = vec![0.0; self.boundaries.len()];
        for (boundary, sum) in self.boundaries.iter().zip(&mut rates) {
            let Drive::Rate(rate) = &boundary.drive else { continue };
            let volume = rate.integral(self.state.time, end);
            for (&vertex, factor) in boundary.vertices.iter().zip(&boundary.factors) {
                supplied[vertex as usize] += factor * volume;
                *sum += factor * volume;
            }
        }
        (supplied, rates)
    }

    /// Volume that each vertex gains in a step of a length, s, by supply and by the flow of these pressures,
    /// m³: each flow leaves one vertex and reaches another.
    fn gains(&self, supplied: &[f64], pressure: &[f64], step: f64) -> Vec<f64> {
        let mut gains = supplied.to_vec();
        for (&[a, b], conductance) in self.assembly.pairs.iter().zip(&self.assembly.conductances) {
            let [a, b] = [a as usize, b as usize];
            let drop = (pressure[a] - pressure[b]) - (self.rest[a] - self.rest[b]);
            let volume = step * conductance * drop;
            gains[a] -= volume;
            gains[b] += volume;
        }
        gains
    }

    /// The state, to save it.
    pub fn state(&self) -> &MatrixState {
        &self.state
    }

    /// Continues from a saved state of the same pores. [`deform`](Self::deform) follows it.
    ///
    /// # Errors
    /// A state with columns of other lengths or bad numbers.
    pub fn restore(&mut self, state: &MatrixState) -> Result<(), FluidError> {
        if !state.is_sound(self.holders.len(), self.boundaries.len()) {
            let why = "the state of the pores has columns of other lengths or bad numbers";
            return Err(FluidError::State(why.to_owned()));
        }
        self.state = state.clone();
        Ok(())
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Pressure of each vertex, Pa; zero without pores.
    pub fn pressures(&self) -> &[f64] {
        &self.state.pressure
    }

    /// Mean pressure of an element, Pa, with which its pores push its corners.
    pub fn pressure_in(&self, element: usize) -> f64 {
        let vertices = &self.elements[element].vertices;
        vertices.iter().fold(0.0, |sum, vertex| sum + self.state.pressure[*vertex as usize]) / N as f64
    }

    /// Darcy's flow in each element, m/s: volume through an area across it.
    pub fn flows(&self) -> Vec<[f64; D]> {
        let head = |vertex: u32| self.state.pressure[vertex as usize] - self.rest[vertex as usize];
        let of = |element: &PorousElement<N>| {
            let permeability = &self.materials[element.material as usize].permeability;
            let places = element.vertices.map(|vertex| self.places[vertex as usize]);
            assembly::flow(places, element.vertices.map(head), permeability, self.viscosity)
        };
        self.elements.iter().map(of).collect()
    }

    /// Storage of each vertex, m³/Pa.
    pub fn storages(&self) -> &[f64] {
        &self.assembly.storage
    }

    /// Volume by which the pores around each vertex have grown with the body, m³.
    pub fn growths(&self) -> &[f64] {
        &self.growth
    }

    /// Number of entries of the matrix beside its diagonal, and of its factor.
    pub fn entries(&self) -> [usize; 2] {
        [self.assembly.pairs.len(), self.solver.fill()]
    }

    /// Volume that has come in through a boundary, m³.
    ///
    /// # Errors
    /// A boundary that does not exist.
    pub fn inflow(&self, key: u64) -> Result<f64, FluidError> {
        let unknown = |_| FluidError::State(format!("there is no boundary {key} of the pores"));
        let at = self.boundaries.binary_search_by_key(&key, |boundary| boundary.key).map_err(unknown)?;
        Ok(self.state.inflow[at])
    }

    /// Balance of the liquid since the beginning. Sums are in the order of vertices and keys.
    pub fn balance(&self) -> PoreBalance {
        let state = &self.state;
        let (inflow, stored) = (sum(&state.inflow), sum(&state.content));
        let MatrixState { initial, exchanged, moved, .. } = *state;
        PoreBalance { initial, inflow, exchanged, stored, moved }
    }
}

fn sum(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |sum, value| sum + value)
}

/// The boundary that prescribes the pressure of each vertex, and its factor. `storage`: positive at vertices
/// with pores.
fn holders(boundaries: &[PoreBoundary], storage: &[f64]) -> Result<Vec<Option<(u32, f64)>>, FluidError> {
    if let Some(pair) = boundaries.windows(2).find(|pair| pair[0].key == pair[1].key) {
        return Err(FluidError::SameKey { what: "boundary", key: pair[0].key });
    }
    let mut holders: Vec<Option<(u32, f64)>> = vec![None; storage.len()];
    for (number, boundary) in (0..).zip(boundaries) {
        let place = format!("boundary {}", boundary.key);
        boundary.drive.check(&place, f64::NEG_INFINITY)?;
        let (found, expected) = (boundary.factors.len(), boundary.vertices.len());
        if found != expected {
            return Err(FluidError::Length { what: "factors of a boundary", found, expected });
        }
        for (&vertex, &factor) in boundary.vertices.iter().zip(&boundary.factors) {
            let has_pores = storage.get(vertex as usize).is_some_and(|storage| *storage > 0.0);
            let range = "that of a vertex with pores";
            check(has_pores, &place, "number of a vertex", f64::from(vertex), range)?;
            check(true, &place, "factor of a vertex", factor, "finite")?;
            let Drive::Pressure(_) = boundary.drive else { continue };
            match holders[vertex as usize] {
                None => holders[vertex as usize] = Some((number, factor)),
                // The corner of two surfaces with the same pressure belongs to the first one.
                Some((other, of)) if of == factor && boundaries[other as usize].drive == boundary.drive => {}
                Some((other, _)) => {
                    let sources = [boundaries[other as usize].key, boundary.key];
                    return Err(FluidError::SharedVertex { vertex, sources });
                }
            }
        }
    }
    Ok(holders)
}
