//! The fluid of a run: its volumes and pressures at the end, in the summary and in `run.json`, and cracks
//! that grew too fast for a quasi-static fracture.

use std::fmt::Write;

use fdem_io::numbers::brief;
use fdem_results::History;
use fdem_simulation::{Material, Model, Probe};
use serde_json::{Value, json};

use crate::command::run::engine::Engine;
use crate::command::run::results::Results;
use fdem_model::Prepared;

/// Share of the speed of Rayleigh waves from which a fracture is dynamic.
const FAST: f64 = 0.1;

/// Share of the run over which the growth of cracks is averaged: cracks grow by whole facets.
const WINDOW: f64 = 0.2;

/// The fluid of a run at its end.
#[derive(Debug)]
pub(crate) struct RunFluid {
    /// The values of [`Probe::Fluid`], with their names.
    totals: Vec<(&'static str, f64)>,
    /// Pressure, Pa, rate, m³/s, and injected volume, m³, of each injection.
    injections: Vec<(String, [f64; 3])>,
    /// Unit of the length or the area of the joints.
    unit: &'static str,
    /// Fastest growth of the cracks, m/s, its time, s, and the speed of Rayleigh waves, m/s.
    growth: Option<[f64; 3]>,
}

impl RunFluid {
    /// The fluid of a run that has one, in its last stage.
    pub(crate) fn of<const D: usize, const N: usize>(
        run: &(impl Engine<D, N> + ?Sized),
        prepared: &Prepared<D, N>,
        history: &History,
    ) -> Option<Self>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let options = prepared.model.fluid.as_ref()?;
        let mut probes: Vec<Probe<D, N>> = vec![Probe::Fluid];
        probes.extend(options.sources.iter().map(|source| Probe::Injection(source.name.clone())));
        let measured = run.measure(&probes);
        let names = Probe::<D, N>::Fluid.columns().into_iter().map(|(name, _)| name);
        let state = |values: &Vec<f64>| values[..].try_into().unwrap_or([f64::NAN; 3]);
        let injections = options.sources.iter().zip(&measured[1..]);
        Some(Self {
            totals: names.zip(measured[0].iter().copied()).collect(),
            injections: injections.map(|(source, values)| (source.name.clone(), state(values))).collect(),
            unit: if D == 2 { "m" } else { "m²" },
            growth: growth(history, &prepared.model),
        })
    }

    /// The warning of cracks that ran faster than a quasi-static fracture does.
    pub(crate) fn warning(&self) -> Option<String> {
        let [speed, time, rayleigh] = self.growth?;
        (speed > FAST * rayleigh).then(|| {
            format!(
                "warning: the cracks grew by {} m/s at {} s, above {FAST} of the speed of Rayleigh waves, {} m/s: such a fracture is dynamic, and hydraulic fractures are not; \
                 inject more slowly, or look whether the rock broke all at once there",
                brief(speed),
                brief(time),
                brief(rayleigh)
            )
        })
    }

    fn total(&self, name: &str) -> f64 {
        self.totals.iter().find(|(known, _)| *known == name).map_or(f64::NAN, |(_, value)| *value)
    }

    /// The line of the summary.
    pub(crate) fn in_words(&self) -> String {
        let [injected, leaked, stored, missed] =
            ["injected", "leaked", "stored", "missed"].map(|name| self.total(name));
        let measure =
            ["wet_length", "wet_area"].map(|name| self.total(name)).into_iter().find(|x| !x.is_nan());
        let mut text = format!(
            "{} m³ injected, {} m³ leaked off, {} m³ stored in holes and {} {} of joints",
            brief(injected),
            brief(leaked),
            brief(stored),
            brief(measure.unwrap_or(f64::NAN)),
            self.unit
        );
        // Writing into a string cannot fail.
        if missed > 0.0 {
            let _ = write!(text, ", {} m³ that could not be taken out", brief(missed));
        }
        for (name, [pressure, ..]) in &self.injections {
            let _ = write!(text, "; {name}: {} Pa", brief(*pressure));
        }
        text
    }

    /// The object in `run.json`.
    pub(crate) fn json(&self) -> Value {
        let totals: serde_json::Map<String, Value> =
            self.totals.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
        let injections: Vec<Value> = self
            .injections
            .iter()
            .map(|(name, [pressure, rate, injected])| {
                json!({ "name": name, "pressure": pressure, "rate": rate, "injected": injected })
            })
            .collect();
        let mut object = Value::Object(totals);
        object["injections"] = injections.into();
        object["growth"] = self.growth.map_or(
            Value::Null,
            |[speed, time, rayleigh]| json!({ "speed": speed, "time": time, "rayleigh": rayleigh }),
        );
        object
    }
}

/// Fastest growth of the cracks, m/s, its time, s, and the speed of Rayleigh waves in the slowest rock that
/// can break, m/s, where the mass of the model is scaled as it is in the mean. A crack in the plane has two
/// ends, and one in space is a disc.
fn growth<const D: usize, const N: usize>(history: &History, model: &Model<D, N>) -> Option<[f64; 3]>
where
    [[f64; D]; N]: Results<D, N>,
{
    let column = |name: &str| history.column(name).unwrap_or_default();
    let (times, cracks) = (column("time"), column(if D == 2 { "crack_length" } else { "crack_area" }));
    let reach = |cracked: f64| if D == 2 { cracked / 2.0 } else { (cracked / std::f64::consts::PI).sqrt() };
    let window = WINDOW * times.last()?;
    let mut fastest = [0.0_f64; 2];
    for (first, time) in times.iter().enumerate() {
        let last = times.partition_point(|of| *of < time + window);
        if let (Some(end), Some(cracked)) = (times.get(last), cracks.get(last)) {
            let speed = (reach(*cracked) - reach(cracks[first])) / (end - time);
            if speed > fastest[0] {
                fastest = [speed, *time];
            }
        }
    }
    let rayleigh = |of: &Material| {
        let ratio = of.mean_poissons_ratio();
        // K. F. Graff, Wave Motion in Elastic Solids (1975), p. 326, after Viktorov.
        of.shear_speed() * (0.87 + 1.12 * ratio) / (1.0 + ratio)
    };
    let breaking = model.materials.iter().filter(|of| of.strength.is_some());
    let slowest = breaking.map(rayleigh).reduce(f64::min)?;
    let masses = model.true_masses();
    let scaled: f64 = masses.iter().zip(&model.mass_factors).map(|(mass, factor)| mass * factor).sum();
    let scale = if model.mass_factors.is_empty() { 1.0 } else { scaled / masses.iter().sum::<f64>() };
    Some([fastest[0], fastest[1], slowest / scale.sqrt()])
}
