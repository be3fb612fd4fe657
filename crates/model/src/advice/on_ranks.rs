//! Estimates of a run on many ranks, before it starts.

use std::fmt;

use fdem_io::numbers::{brief, grouped};
use fdem_simulation::{Forecast, Network, RankForecast};
use serde::Serialize;

use crate::advice::amounts::{duration, size};

/// Estimates of a run on many ranks, each on a separate core. Displays as lines of text.
#[derive(Debug, Clone, Serialize)]
pub struct OnRanks {
    /// The share of each rank at the beginning.
    pub forecast: Forecast,
    /// Work of the busiest rank over the mean.
    pub imbalance: f64,
    /// Elements in halos of all ranks over the elements of the model.
    pub halo_share: f64,
    /// The network that is assumed.
    pub network: Network,
    /// Time of a step in which the rank with most elements computes, while nothing breaks, s.
    pub computing: f64,
    /// Time of a step for messages, s.
    pub messages: f64,
    /// Run time, s; of a model that can break, if it breaks to pieces.
    pub seconds: f64,
    /// Run time if nothing breaks, s.
    pub seconds_whole: f64,
    /// Run time on one core over that on the ranks, if nothing breaks.
    pub speedup: f64,
    /// Largest memory of a rank during the steps, while nothing breaks, bytes.
    pub memory: f64,
    /// Memory of rank 0 while it gives the others their elements, bytes.
    pub memory_at_beginning: f64,
    /// Whether the model has spheres, which every rank moves: the times do not count them.
    pub has_spheres: bool,
}

impl OnRanks {
    /// Estimates from a forecast. `pace`: times of a step of the whole model on one core, while nothing
    /// breaks and if all breaks, s. `program`: memory of the program without a model, bytes.
    pub(crate) fn of(forecast: Forecast, pace: [f64; 2], steps: u64, program: f64) -> Self {
        let network = Network::default();
        let busiest = forecast.most(RankForecast::held) as f64 / forecast.elements as f64;
        let messages = forecast.message_seconds(&network);
        let [whole, breaking] = pace.map(|seconds| (seconds * busiest + messages) * steps as f64);
        let most = forecast.of_ranks.iter().map(|rank| rank.memory).max().unwrap_or_default();
        Self {
            imbalance: forecast.imbalance(),
            halo_share: forecast.halo_share(),
            network,
            computing: pace[0] * busiest,
            messages,
            seconds: breaking,
            seconds_whole: whole,
            speedup: pace[0] * steps as f64 / whole,
            memory: program + most as f64,
            memory_at_beginning: program + forecast.memory_at_beginning as f64,
            has_spheres: false,
            forecast,
        }
    }
}

/// Seconds as milliseconds.
fn milliseconds(seconds: f64) -> String {
    format!("{:.3} ms", 1e3 * seconds)
}

impl fmt::Display for OnRanks {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { forecast, network, .. } = self;
        let ranks = grouped(forecast.ranks() as u64);
        let count = |of: fn(&RankForecast) -> usize| {
            let mean = grouped(forecast.mean(of).round() as u64);
            format!("{mean} in the mean, at most {}", grouped(forecast.most(of) as u64))
        };
        writeln!(out, "ranks            {ranks}, each on a core of its own")?;
        if self.has_spheres {
            writeln!(
                out,
                "  spheres        every rank moves all of them: their time and memory are not in what follows"
            )?;
        }
        writeln!(
            out,
            "  own elements   {}; the busiest rank has {:.2} times the mean work",
            count(|rank| rank.own),
            self.imbalance
        )?;
        writeln!(
            out,
            "  halo elements  {}; together {:.1} % of the model",
            count(|rank| rank.halo),
            100.0 * self.halo_share
        )?;
        writeln!(out, "  neighbours     {}", count(|rank| rank.neighbours))?;
        writeln!(
            out,
            "  messages       {} sent in a step in the mean, at most {}; the largest message has {}",
            size(forecast.mean(|rank| rank.bytes)),
            size(forecast.most(|rank| rank.bytes) as f64),
            size(forecast.most(|rank| rank.largest) as f64)
        )?;
        writeln!(
            out,
            "  memory         at most {} on a rank if nothing breaks; {} on rank 0 at the beginning",
            size(self.memory),
            size(self.memory_at_beginning)
        )?;
        writeln!(
            out,
            "  step           about {}: {} to compute, {} for messages (assumed: {} µs and {} GB/s)",
            milliseconds(self.computing + self.messages),
            milliseconds(self.computing),
            milliseconds(self.messages),
            brief(1e6 * network.latency),
            brief(1e-9 * network.bandwidth)
        )?;
        let whole = if self.seconds_whole < self.seconds {
            format!(" if it breaks to pieces, {} if nothing breaks", duration(self.seconds_whole))
        } else {
            String::new()
        };
        writeln!(
            out,
            "  run time       about {}{whole}: {:.1} times as fast as one core",
            duration(self.seconds),
            self.speedup
        )
    }
}
