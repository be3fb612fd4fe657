//! Whether a run with mass scaling was quasi-static: its kinetic over its strain energy, in the summary and
//! in `run.json`.

use fdem_io::numbers::{brief, grouped};
use fdem_results::History;
use serde_json::{Value, json};

use fdem_model::{Prepared, Scaled};

/// Share of the largest strain energy from which a row of the history counts.
const COUNTS: f64 = 0.1;

/// The kinetic over the strain energy of a run with mass scaling.
#[derive(Debug)]
pub(crate) struct QuasiStatic {
    scaled: Scaled,
    /// The largest ratio, and its time, s; `None` without a row that counts.
    largest: Option<[f64; 2]>,
    /// Rows above the bound, and rows that count.
    rows: [usize; 2],
}

impl QuasiStatic {
    /// The ratios of a history, if the model has mass scaling.
    pub(crate) fn of<const D: usize, const N: usize>(
        prepared: &Prepared<D, N>,
        history: &History,
    ) -> Option<Self> {
        let scaled = prepared.mass_scaling.clone()?;
        let column = |name: &str| history.column(name).unwrap_or_default();
        let (strain, times) = (column("strain"), column("time"));
        let least = COUNTS * strain.iter().copied().fold(0.0, f64::max);
        let mut found = Self { scaled, largest: None, rows: [0, 0] };
        for ((kinetic, strain), time) in column("kinetic").iter().zip(strain).zip(times) {
            if *strain <= 0.0 || *strain < least {
                continue;
            }
            let ratio = kinetic / strain;
            found.rows[0] += usize::from(ratio > found.scaled.kinetic_bound);
            found.rows[1] += 1;
            if found.largest.is_none_or(|[most, _]| ratio > most) {
                found.largest = Some([ratio, *time]);
            }
        }
        Some(found)
    }

    /// The warning of a run that was not quasi-static.
    pub(crate) fn warning(&self) -> Option<String> {
        let [above, rows] = self.rows;
        let [ratio, time] = self.largest.filter(|_| above > 0)?;
        Some(format!(
            "warning: the run was not quasi-static: its kinetic energy was above {} times its strain energy in {} of {} rows of the history, most with {} times at {} s; \
             take {}a slower load or more damping, or look whether it broke there",
            brief(self.scaled.kinetic_bound),
            grouped(above as u64),
            grouped(rows as u64),
            brief(ratio),
            brief(time),
            if self.scaled.added_mass > 0.0 { "less added mass, " } else { "" }
        ))
    }

    /// The line of the summary.
    pub(crate) fn in_words(&self) -> String {
        let ratio = self.largest.map_or_else(
            || "no strain energy".to_owned(),
            |[ratio, time]| {
                format!("kinetic energy up to {} of the strain energy, at {} s", brief(ratio), brief(time))
            },
        );
        format!("{}; {ratio}", self.scaled.in_words())
    }

    /// The object in `run.json`.
    pub(crate) fn json(&self) -> Value {
        let Scaled { elements, true_mass, added_mass, step_without, kinetic_bound, .. } = self.scaled;
        json!({
            "elements": elements,
            "true_mass": true_mass,
            "added_mass": added_mass,
            "added_share": self.scaled.share(),
            "time_step_without": step_without,
            "kinetic_over_strain": {
                "bound": kinetic_bound,
                "largest": self.largest.map(|[ratio, _]| ratio),
                "time": self.largest.map(|[_, time]| time),
                "rows_above": self.rows[0],
                "rows": self.rows[1],
            },
        })
    }
}
