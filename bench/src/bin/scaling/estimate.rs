//! A model of the time of a step on many ranks, each on one core.
//!
//! A rank with `n` own elements computes `n + h n^⅔` elements: the halo is a layer on the surface of its
//! part. It exchanges `k` messages with `b` bytes for each element of the halo, and takes part in one
//! agreement of all ranks. `h`, `k` and `b` are those of the rank with most, from a mesh that has been
//! divided.

use fdem_simulation::{Forecast, Network, RankForecast};

/// Constants of the model, for one kind of element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    /// Time of an element in a step, s.
    pub(crate) seconds: f64,
    /// Elements of the halo over `n^⅔`.
    pub(crate) halo: f64,
    pub(crate) neighbours: f64,
    /// Bytes that a rank sends for each element of its halo.
    pub(crate) bytes: f64,
    pub(crate) network: Network,
    /// Memory for an element on a rank, and on rank 0 at the beginning, bytes.
    pub(crate) memory: [f64; 2],
}

/// Time of a step, s, in parts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Elements of the rank's own.
    pub(crate) own: f64,
    /// Elements that other ranks compute too.
    pub(crate) halo: f64,
    /// Messages with neighbours.
    pub(crate) messages: f64,
    /// The agreement of all ranks.
    pub(crate) agreement: f64,
}

impl Step {
    fn all(&self) -> f64 {
        self.own + self.halo + self.messages + self.agreement
    }

    /// Share of the time in which a rank works on its own elements: the speed over the speed of the same
    /// number of cores without other ranks.
    pub(crate) fn efficiency(&self) -> f64 {
        self.own / self.all()
    }

    /// The parts over the whole.
    pub(crate) fn shares(&self) -> [f64; 4] {
        [self.own, self.halo, self.messages, self.agreement].map(|part| part / self.all())
    }
}

impl Estimate {
    pub(crate) fn of(forecast: &Forecast, seconds: f64, network: Network) -> Self {
        let own = forecast.elements as f64 / forecast.ranks() as f64;
        let beyond = forecast.most(RankForecast::held) as f64 - own;
        Self {
            seconds,
            halo: beyond / own.powf(2.0 / 3.0),
            neighbours: forecast.most(|rank| rank.neighbours) as f64,
            bytes: forecast.most(|rank| rank.bytes) as f64 / beyond,
            network,
            memory: [forecast.sizes.all(), forecast.memory_at_beginning as f64 / forecast.elements as f64],
        }
    }

    /// Number of elements of other ranks that the busiest rank computes, if each rank has `own` elements.
    pub(crate) fn halo(&self, own: f64) -> f64 {
        self.halo * own.powf(2.0 / 3.0)
    }

    /// A step with `own` elements on each rank.
    pub(crate) fn step(&self, own: f64, ranks: usize) -> Step {
        let alone = ranks == 1;
        let halo = if alone { 0.0 } else { self.halo(own) };
        let neighbours = self.neighbours.min(ranks as f64 - 1.0);
        Step {
            own: own * self.seconds,
            halo: halo * self.seconds,
            messages: self.network.exchange(neighbours, halo * self.bytes),
            agreement: self.network.agreement(ranks),
        }
    }

    /// Elements on each rank at which the efficiency on `ranks` ranks has the given value.
    pub(crate) fn elements_at(&self, efficiency: f64, ranks: usize) -> f64 {
        let (mut low, mut high) = (1.0_f64, 1e12_f64);
        for _ in 0..100 {
            let middle = (low * high).sqrt();
            if self.step(middle, ranks).efficiency() < efficiency { low = middle } else { high = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ESTIMATE: Estimate = Estimate {
        seconds: 40e-9,
        halo: 8.0,
        neighbours: 20.0,
        bytes: 10.0,
        network: Network { latency: 2e-6, bandwidth: 10e9 },
        memory: [600.0, 2000.0],
    };

    #[test]
    fn one_rank_alone_loses_nothing() {
        assert!((ESTIMATE.step(1e5, 1).efficiency() - 1.0).abs() < 1e-12);
        assert!(ESTIMATE.step(1e5, 100).efficiency() < 0.9);
    }

    #[test]
    fn the_efficiency_is_found_again() {
        for efficiency in [0.5, 0.8] {
            let own = ESTIMATE.elements_at(efficiency, 1000);
            assert!((ESTIMATE.step(own, 1000).efficiency() - efficiency).abs() < 1e-6, "{own}");
        }
    }
}
