//! The share of inertia in the peak of the load of a run.

use crate::run::history::History;
use crate::run::loads::loading;

/// The share of inertia in the peak load of a run.
///
/// In tests of a specimen between platens, a kinetic energy of 1 % of the strain energy at the peak means a
/// strength that is some 5 % too high: the book has the measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Inertia {
    /// Name of the boundary and of the direction of its force.
    pub load: String,
    /// The peak, N.
    pub peak: f64,
    /// Kinetic energy over the strain energy since the beginning, both at the peak.
    pub share: f64,
}

/// The share of inertia at the peak of the largest force of a boundary over its own displacement; `None` if
/// no force of a moved boundary is recorded, or if nothing is strained.
pub fn inertia(history: &History) -> Option<Inertia> {
    let [kinetic, strain] = [history.column("kinetic")?, history.column("strain")?];
    let peaks = loading(history)?.loads.into_iter().filter_map(|load| {
        let largest = |one: usize, other: usize| load.force[one].abs().total_cmp(&load.force[other].abs());
        let row = (0..load.force.len())
            .filter(|&row| load.force[row].is_finite())
            .max_by(|&a, &b| largest(a, b))?;
        Some((load.name, load.force[row].abs(), row))
    });
    let (load, peak, row) = peaks.max_by(|one, other| one.1.total_cmp(&other.1))?;
    let strained = strain.get(row)? - strain.first()?;
    let share = kinetic.get(row)? / strained;
    (peak > 0.0 && strained > 0.0 && share.is_finite()).then_some(Inertia { load, peak, share })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::history::{HistoryWriter, Row};
    use fdem_simulation::Energies;

    fn history(rows: &[[f64; 4]]) -> History {
        let mut text = Vec::new();
        let names = ["top fx [N]", "top fy [N]", "top ux [m]", "top uy [m]"].map(str::to_owned);
        let mut writer = HistoryWriter::new(&mut text, 2, &names).unwrap();
        for &[moved, force, kinetic, strain] in rows {
            let energies = Energies { kinetic, strain, ..Energies::default() };
            let row = Row { energies, values: vec![0.0, force, 0.0, moved], ..Row::default() };
            writer.row(&row).unwrap();
        }
        History::read(&text).unwrap()
    }

    #[test]
    fn inertia_is_measured_at_the_peak_and_without_the_initial_energy() {
        let rows =
            [[0.0, 0.0, 0.0, 5.0], [-1e-3, -4.0, 0.1, 6.0], [-2e-3, -9.0, 0.2, 9.0], [-3e-3, -1.0, 3.0, 6.0]];
        let found = inertia(&history(&rows)).unwrap();
        assert_eq!((found.load.as_str(), found.peak), ("top along −y", 9.0));
        assert!((found.share - 0.05).abs() < 1e-12, "{found:?}");
        assert_eq!(inertia(&history(&[[0.0; 4], [0.0; 4]])), None);
    }
}
