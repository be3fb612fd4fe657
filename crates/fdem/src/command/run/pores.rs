//! The liquid in the pores of a run: its volumes at the end, in the summary and in `run.json`.

use std::fmt::Write;

use fdem_io::numbers::brief;
use fdem_model::Prepared;
use fdem_simulation::Probe;
use serde_json::{Map, Value, json};

use crate::command::run::engine::Engine;
use crate::command::run::results::Results;

/// The liquid in the pores of a run at its end.
#[derive(Debug)]
pub(crate) struct RunPores {
    /// The values of [`Probe::Pores`], with their names.
    totals: Vec<(&'static str, f64)>,
    /// Volume that has come in through each surface of the last stage, m³.
    surfaces: Vec<(String, f64)>,
}

impl RunPores {
    /// The liquid of a run that has one, in its last stage.
    pub(crate) fn of<const D: usize, const N: usize>(
        run: &(impl Engine<D, N> + ?Sized),
        prepared: &Prepared<D, N>,
    ) -> Option<Self>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let surfaces = &prepared.model.pores.as_ref()?.surfaces;
        let mut probes: Vec<Probe<D, N>> = vec![Probe::Pores];
        probes.extend(surfaces.iter().map(|surface| Probe::PoreSurface(surface.name.clone())));
        let measured = run.measure(&probes);
        let names = Probe::<D, N>::Pores.columns().into_iter().map(|(name, _)| name);
        let inflow = |values: &Vec<f64>| values.first().copied().unwrap_or(f64::NAN);
        let inflows = measured[1..].iter().map(inflow);
        Some(Self {
            totals: names.zip(measured[0].iter().copied()).collect(),
            surfaces: surfaces.iter().map(|surface| surface.name.clone()).zip(inflows).collect(),
        })
    }

    /// The line of the summary.
    pub(crate) fn in_words(&self) -> String {
        let total = |name: &str| {
            let found = self.totals.iter().find(|(known, _)| *known == name);
            brief(found.map_or(f64::NAN, |(_, value)| *value))
        };
        let mut text = format!("{} m³ through surfaces, {} m³ stored", total("inflow"), total("stored"));
        for (name, inflow) in &self.surfaces {
            // Writing to a string does not fail.
            let _ = write!(text, "; {name}: {} m³", brief(*inflow));
        }
        text
    }

    /// The object in `run.json`.
    pub(crate) fn json(&self) -> Value {
        let totals: Map<String, Value> =
            self.totals.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
        let of = |(name, inflow): &(String, f64)| json!({ "name": name, "inflow": inflow });
        let mut object = Value::Object(totals);
        object["surfaces"] = self.surfaces.iter().map(of).collect();
        object
    }
}
