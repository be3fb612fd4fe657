//! The fluid in the output of `fdem check`: its cells, its steps, and the regime of a hydraulic fracture.
//!
//! A fracture at a constant rate is in the regime of toughness where breaking the rock takes most of the
//! energy, and in that of viscosity where the flow does. With `μ' = 12 μ`, `K' = 4 √(2/π) K_Ic`,
//! `K_Ic = √(E' G)` and the rate `Q`, per thickness in the plane,
//!
//! | | number | viscosity | toughness |
//! |---|---|---|---|
//! | straight (KGD) | `k = K'/(E'³ μ' Q)^(1/4)` | below 1 | above 4 |
//! | penny-shaped | `k = K' (t²/(μ'⁵ Q³ E'¹³))^(1/18)` | below 1 | above 3.5 |
//!
//! Source: E. Detournay, Annu. Rev. Fluid Mech. 48 (2016) 311-339; A. A. Savitski and E. Detournay, Int. J.
//! Solids Struct. 39 (2002) 6311-6337.

use std::f64::consts::PI;
use std::fmt;

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::Corners;
use fdem_simulation::fluid::{Connection, Drive, Scheme, StateEquation};
use fdem_simulation::{FluidSource, Model, Simulation};
use serde::Serialize;

use crate::advice::process_zone;
use crate::bodies::dimensions::Dimensions;

/// Times at which a rate is looked at.
const TIMES: u32 = 400;

/// Numbers up to which viscosity rules, and from which toughness rules, in the plane and in space.
const BOUNDS: [[f64; 2]; 2] = [[1.0, 4.0], [1.0, 3.5]];

/// Parts of an explicit step from which the implicit one is better.
const MANY_PARTS: f64 = 100.0;

/// The fluid of a model before the run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FluidForecast {
    /// Number of cells at the beginning.
    pub cells: usize,
    /// Step of the fluid, s.
    pub step: f64,
    /// Longest stable part of an explicit step at the beginning, s; `None` for the implicit scheme, and
    /// without flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explicit_bound: Option<f64>,
    /// The regime of each injection at a rate into rock that can break.
    pub regimes: Vec<FluidRegime>,
}

/// The regime of a hydraulic fracture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FluidRegime {
    /// Name of the injection.
    pub injection: String,
    /// K', Pa √m.
    pub toughness: f64,
    /// M' = 12 μ, Pa s.
    pub viscosity: f64,
    /// The dimensionless toughness; in space at the end of the run.
    pub number: f64,
    /// "toughness", "viscosity", or "between".
    pub regime: &'static str,
}

impl FluidForecast {
    /// The fluid of a run at its beginning; `None` without one. `end`: end of the run, s. Adds warnings.
    pub(crate) fn of<const D: usize, const N: usize>(
        run: &Simulation<D, N>,
        [step, end]: [f64; 2],
        warnings: &mut Vec<String>,
    ) -> Option<Self>
    where
        [[f64; D]; N]: Dimensions<D, N>,
    {
        let (model, network) = (run.model(), run.fluid()?);
        let options = model.fluid.as_ref()?;
        let step = step * f64::from(options.steps);
        let explicit = options.flow.scheme == Scheme::Explicit;
        let bound = network.explicit_bound().ok().filter(|bound| explicit && bound.is_finite());
        if let Some(bound) = bound.filter(|bound| step > MANY_PARTS * bound) {
            warnings.push(format!(
                "[fluid] scheme = \"explicit\": a step of {} s takes {} parts of at most {} s; take the implicit scheme",
                brief(step),
                grouped((step / (0.9 * bound)).ceil() as u64),
                brief(bound)
            ));
        }
        for source in &options.sources {
            warnings.extend(stiff_hole(model, source, step));
        }
        Some(Self {
            cells: run.fluid_joints().len(),
            step,
            explicit_bound: bound,
            regimes: options.sources.iter().filter_map(|source| regime(model, source, end)).collect(),
        })
    }
}

/// The warning of a hole whose fluid is too stiff for its step: `2 D K Δt²/(R ρ h)` is above 1, with the
/// radius `R`, and elements of the size `h`.
fn stiff_hole<const D: usize, const N: usize>(
    model: &Model<D, N>,
    source: &FluidSource<D>,
    step: f64,
) -> Option<String>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let element = element_at(model, source)?;
    let is_hole = source.facets.len() > D;
    let places = |facet: &[u32; D]| facet.map(|node| model.mesh.nodes[node as usize]);
    let areas: Vec<f64> =
        source.facets.iter().map(|facet| <[[f64; D]; N]>::facet_measure(&places(facet))).collect();
    let area: f64 = areas.iter().sum();
    let apex = places(source.facets.first()?)[0];
    let cone = |facet: &[u32; D]| {
        let corners = places(facet);
        let cone: [[f64; D]; N] = std::array::from_fn(|k| corners.get(k).copied().unwrap_or(apex));
        cone.measure()
    };
    let radius = D as f64 * source.facets.iter().map(cone).sum::<f64>().abs() / area;
    let least = areas.iter().copied().fold(f64::INFINITY, f64::min);
    // The edge of an even triangle.
    let size = if D == 2 { least } else { (4.0 / 3_f64.sqrt() * least).sqrt() };
    let modulus = match model.fluid.as_ref()?.flow.fluid.state {
        StateEquation::Liquid { bulk_modulus, .. } => bulk_modulus,
        // A gas is as stiff as its pressure.
        StateEquation::Gas { reference_pressure, exponent, .. } => exponent * reference_pressure,
    };
    let factor = model.mass_factors.get(element as usize).copied().unwrap_or(1.0);
    let density = factor * model.materials[model.mesh.materials[element as usize] as usize].density;
    let number = 2.0 * D as f64 * modulus * step * step / (radius * density * size);
    (is_hole && number > 1.0).then(|| {
        format!(
            "[[injection]] \"{}\": the fluid in its hole is too stiff for a step of {} s: {} K Δt²/(R ρ h) is {}, and has to be below 1; take fewer steps in [fluid], a shorter time_step or a larger hole",
            source.name,
            brief(step),
            2 * D,
            brief(number)
        )
    })
}

/// An element at the first facet of a source.
fn element_at<const D: usize, const N: usize>(model: &Model<D, N>, source: &FluidSource<D>) -> Option<u32> {
    let facet = source.facets.first()?;
    let has = |nodes: &[u32; N]| facet.iter().all(|node| nodes.contains(node));
    model.mesh.elements.iter().position(has).map(|element| element as u32)
}

/// The regime of the fracture of a source; `None` if it injects at no rate, or if its rock cannot break.
fn regime<const D: usize, const N: usize>(
    model: &Model<D, N>,
    source: &FluidSource<D>,
    end: f64,
) -> Option<FluidRegime> {
    let flow = &model.fluid.as_ref()?.flow;
    if flow.connection == Connection::Cavities {
        return None;
    }
    let Some(Drive::Rate(rate)) = &source.drive else { return None };
    let times = (0..=TIMES).map(|k| rate.at(end * f64::from(k) / f64::from(TIMES)));
    let rate = times.fold(0.0, f64::max) / if D == 2 { model.thickness } else { 1.0 };
    let material = model.mesh.materials[element_at(model, source)? as usize] as usize;
    let energy = model.materials[material].strength?.energy_i;
    if rate <= 0.0 || energy <= 0.0 {
        return None;
    }
    let modulus = process_zone::plane_modulus(model, material);
    let toughness = 4.0 * (2.0 / PI).sqrt() * (modulus * energy).sqrt();
    let viscosity = 12.0 * flow.fluid.viscosity;
    let number = if D == 2 {
        toughness / (modulus.powi(3) * viscosity * rate).powf(0.25)
    } else {
        // In logarithms: powers of moduli leave the range of numbers.
        let power = 2.0 * end.ln() - 5.0 * viscosity.ln() - 3.0 * rate.ln() - 13.0 * modulus.ln();
        toughness * (power / 18.0).exp()
    };
    let [low, high] = BOUNDS[D - 2];
    let regime = match number {
        _ if number <= low => "viscosity",
        _ if number >= high => "toughness",
        _ => "between",
    };
    Some(FluidRegime { injection: source.name.clone(), toughness, viscosity, number, regime })
}

impl fmt::Display for FluidForecast {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.cells == 1 { "" } else { "s" };
        write!(
            out,
            "fluid            {} cell{plural} at the beginning, steps of {} s",
            grouped(self.cells as u64),
            brief(self.step)
        )?;
        match self.explicit_bound {
            Some(bound) => writeln!(out, ", explicit, stable up to {} s", brief(bound))?,
            None => writeln!(out)?,
        }
        for FluidRegime { injection, toughness, viscosity, number, regime } in &self.regimes {
            let ruled = match *regime {
                "between" => "between the regimes of toughness and viscosity".to_owned(),
                regime => format!("in the regime of {regime}"),
            };
            writeln!(
                out,
                "                 {injection}: a fracture {ruled}, k = {} (K' {} Pa √m, M' {} Pa s)",
                brief(*number),
                brief(*toughness),
                brief(*viscosity)
            )?;
        }
        Ok(())
    }
}
