//! The liquid in pores in the output of `fdem check`: its nodes, its steps, and the time of consolidation.
//!
//! A pressure spreads with the hydraulic diffusivity `c = k/(μ S)`, where `S = 1/M + α²/K_v` is the storage
//! of a body that is compressed along one axis, with the modulus `K_v = E (1 - ν)/((1 + ν) (1 - 2 ν))`. It
//! reaches a distance `h` in about `h²/c`: then a layer of the thickness `h` that is drained on one side has
//! 93 % of its settlement.
//!
//! Source: A. H.-D. Cheng, Poroelasticity (2016), section 7.2.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt;

use fdem_io::numbers::{brief, grouped};
use fdem_simulation::fluid::{Drive, PorousMaterial};
use fdem_simulation::{Material, Model, Simulation};
use serde::Serialize;

use crate::bodies::dimensions::Dimensions;

/// Share of the time of consolidation from which a step of the flow is long.
const LONG: f64 = 0.02;

/// Permeability that no soil exceeds, m²: that of coarse gravel.
const GRAVEL: f64 = 1e-6;

/// The liquid in the pores of a model before the run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PoreForecast {
    /// Number of nodes with a pressure.
    pub nodes: usize,
    /// Step of the flow, s.
    pub step: f64,
    /// Name of each material with pores that elements have, and its hydraulic diffusivity in the direction in
    /// which it is most permeable, m²/s.
    pub diffusivities: Vec<(String, f64)>,
    /// Time in which pressures settle, s: `h²/c` for the node that is farthest from all surfaces with a
    /// pressure, along edges of elements. `None` without such a surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub consolidation: Option<f64>,
}

impl PoreForecast {
    /// The liquid of a run at its beginning; `None` without one. `step`: of the solid, s. Adds warnings.
    pub(crate) fn of<const D: usize, const N: usize>(
        run: &Simulation<D, N>,
        step: f64,
        warnings: &mut Vec<String>,
    ) -> Option<Self>
    where
        [[f64; D]; N]: Dimensions<D, N>,
    {
        let (model, matrix) = (run.model(), run.pores()?);
        let options = model.pores.as_ref()?;
        let viscosity = options.liquid.viscosity;
        let of_material = |(pores, material): (&Option<PorousMaterial<D>>, &Material)| {
            pores.as_ref().map(|pores| diffusivity(pores, material, viscosity))
        };
        let all: Vec<Option<f64>> = options.materials.iter().zip(&model.materials).map(of_material).collect();
        let is_there =
            |number: &usize| model.mesh.materials.iter().any(|material| *material as usize == *number);
        let named = |number: usize| Some((model.materials[number].name.clone(), all[number]?));
        let step = step * f64::from(options.steps);
        let consolidation = consolidation(model, run.pore_elements(), &all);
        if let Some(whole) = consolidation.filter(|whole| step > LONG * whole) {
            warnings.push(format!(
                "[pores]: a step of the flow of {} s is long beside {} s, in which pressures settle; take fewer steps",
                brief(step),
                brief(whole)
            ));
        }
        Some(Self {
            nodes: matrix.storages().iter().filter(|storage| **storage > 0.0).count(),
            step,
            diffusivities: (0..all.len()).filter(is_there).filter_map(named).collect(),
            consolidation,
        })
    }
}

/// Adds warnings of materials that are more permeable than any soil.
pub(crate) fn permeable<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>) {
    let of_materials = model.pores.iter().flat_map(|pores| &pores.materials).zip(&model.materials);
    for (pores, material) in of_materials {
        let most = pores.as_ref().map_or(0.0, most_permeable);
        if most > GRAVEL {
            warnings.push(format!(
                "[[material]] \"{}\": pores.permeability is up to {} m², and coarse gravel has {GRAVEL:e} m²: is it a hydraulic conductivity? \
                 For water, 1 m/s of that is 1e-7 m² of permeability",
                material.name,
                brief(most)
            ));
        }
    }
}

/// Permeability along the axis along which it is greatest, m².
fn most_permeable<const D: usize>(pores: &PorousMaterial<D>) -> f64 {
    (0..D).map(|axis| pores.permeability[axis][axis]).fold(0.0, f64::max)
}

/// Hydraulic diffusivity of a material, m²/s.
fn diffusivity<const D: usize>(pores: &PorousMaterial<D>, material: &Material, viscosity: f64) -> f64 {
    let (young, poisson) = (material.stiffest_modulus(), material.mean_poissons_ratio());
    let modulus = young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    most_permeable(pores) / (viscosity * (pores.storage + pores.biot * pores.biot / modulus))
}

/// Time in which pressures reach the node that is farthest from all that are prescribed, s. `diffusivities`:
/// of each material, m²/s.
fn consolidation<const D: usize, const N: usize>(
    model: &Model<D, N>,
    elements: &[u32],
    diffusivities: &[Option<f64>],
) -> Option<f64> {
    let surfaces = model.pores.iter().flat_map(|pores| &pores.surfaces);
    let held = surfaces.filter(|surface| matches!(surface.drive, Drive::Pressure(_)));
    let mesh = &model.mesh;
    let mut of_node: Vec<Vec<u32>> = vec![Vec::new(); mesh.nodes.len()];
    for &element in elements {
        for node in mesh.elements[element as usize] {
            of_node[node as usize].push(element);
        }
    }
    // The least sum of length/√c to a prescribed pressure (Dijkstra). The bits of positive numbers are in
    // the order of the numbers.
    let mut least = vec![f64::INFINITY; mesh.nodes.len()];
    let mut waiting = BinaryHeap::new();
    for node in held.flat_map(|surface| surface.target.nodes()) {
        least[node as usize] = 0.0;
        waiting.push(Reverse((0_u64, node)));
    }
    let mut most = None;
    while let Some(Reverse((bits, node))) = waiting.pop() {
        let so_far = f64::from_bits(bits);
        if so_far > least[node as usize] {
            continue;
        }
        most = Some(so_far);
        let place = mesh.nodes[node as usize];
        for &element in &of_node[node as usize] {
            let Some(speed) = diffusivities[mesh.materials[element as usize] as usize] else { continue };
            for other in mesh.elements[element as usize] {
                let there = mesh.nodes[other as usize];
                let square: f64 = (0..D).map(|axis| (there[axis] - place[axis]).powi(2)).sum();
                let reached = so_far + (square / speed).sqrt();
                if reached < least[other as usize] {
                    least[other as usize] = reached;
                    waiting.push(Reverse((reached.to_bits(), other)));
                }
            }
        }
    }
    most.map(|root| root * root)
}

impl fmt::Display for PoreForecast {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "pores            {} nodes with a pressure, steps of {} s",
            grouped(self.nodes as u64),
            brief(self.step)
        )?;
        for (name, diffusivity) in &self.diffusivities {
            writeln!(out, "                 {name}: hydraulic diffusivity c = {} m²/s", brief(*diffusivity))?;
        }
        match self.consolidation {
            Some(time) => {
                writeln!(out, "                 pressures settle in about h²/c = {} s", brief(time))
            }
            None => {
                writeln!(out, "                 no surface has a pressure: no liquid can flow off freely")
            }
        }
    }
}
