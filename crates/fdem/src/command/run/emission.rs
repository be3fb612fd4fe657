//! Acoustic emission of a run: `events.csv`, a plot, and lines of the summary.

use fdem_io::numbers::{brief, grouped};
use fdem_results::{
    BValue, Clustering, EmissionKind, Plot, emitting_joints, events, events_csv, magnitude_frequency,
};
use fdem_simulation::Material;
use serde_json::{Value, json};

use crate::command::run::engine::Engine;
use crate::command::run::results::Results;
use fdem_model::Prepared;

/// The events of a run until now.
pub(crate) struct Emission {
    /// Number of events, and of the joints in them.
    counts: [usize; 2],
    /// The same of the events whose joints soften and hold.
    softening: [usize; 2],
    /// Distance, m, and window, s, of joints that are linked.
    limits: [f64; 2],
    value: Option<BValue>,
    pub(crate) csv: String,
    pub(crate) plot: Option<Plot>,
}

impl Emission {
    /// The events, if the model has acoustic emission. They follow from the joints that have broken or soften
    /// now, so that they are the same after a resume.
    pub(crate) fn of<const D: usize, const N: usize>(
        run: &dyn Engine<D, N>,
        prepared: &Prepared<D, N>,
    ) -> Option<Self>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let asked = prepared.output.emission?;
        let joints = emitting_joints(&prepared.model, &run.snapshot(), asked.softening.unwrap_or(true));
        let clustering = Clustering { distance: asked.distance, window: asked.window };
        let limits = clustering.limits(&joints, shear_wave(&prepared.model.materials));
        let found = events(&joints, limits);
        let softens = |kind: EmissionKind| kind == EmissionKind::Softening;
        let magnitudes: Vec<f64> = found.iter().filter_map(|event| event.magnitude).collect();
        Some(Self {
            counts: [found.len(), joints.len()],
            softening: [
                found.iter().filter(|event| softens(event.kind)).count(),
                joints.iter().filter(|joint| softens(joint.kind)).count(),
            ],
            limits,
            value: BValue::of(&magnitudes),
            csv: events_csv(&found),
            plot: magnitude_frequency(&found),
        })
    }

    /// The events in `run.json`.
    pub(crate) fn json(&self) -> Value {
        json!({
            "events": self.counts[0],
            "joints": self.counts[1],
            "softening_events": self.softening[0],
            "softening_joints": self.softening[1],
            "distance": self.limits[0],
            "window": self.limits[1],
            "b_value": self.value.map(|value| json!({
                "b": value.b,
                "error": value.error,
                "completeness": value.completeness,
                "events": value.count,
            })),
        })
    }

    /// The events in the summary.
    pub(crate) fn in_words(&self) -> String {
        let [events, joints] = self.counts.map(|count| grouped(count as u64));
        let mut found = format!("{events} events of {joints} joints");
        if self.softening[0] > 0 {
            let softening = grouped(self.softening[0] as u64);
            found = format!("{found}, {softening} of them of joints that soften and hold");
        }
        match self.value {
            Some(BValue { b, error, completeness, count }) => format!(
                "{found}; b = {b:.2} ± {error:.2} from the {} events of magnitude {} and more",
                grouped(count as u64),
                brief(completeness)
            ),
            None => format!("{found}; too few for a b-value"),
        }
    }
}

/// The speed of shear waves, m/s, √(G/ρ), in the slowest material that can break; in the slowest of all, if
/// no material has a strength.
fn shear_wave(materials: &[Material]) -> f64 {
    let speed = Material::shear_speed;
    let can_break = materials.iter().filter(|material| material.strength.is_some()).map(speed);
    let slowest = can_break.fold(f64::INFINITY, f64::min);
    if slowest.is_finite() { slowest } else { materials.iter().map(speed).fold(f64::INFINITY, f64::min) }
}
