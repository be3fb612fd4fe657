//! What happened in a run, as curves.

use crate::picture::{PictureError, drawing, encode};
use crate::results::chart::{Axis, Chart, Curve, WIDTH};
use crate::results::history::History;

/// More curves are not told apart.
const MOST_CURVES: usize = 8;

/// A plot of a history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plot {
    /// For a file: letters, digits and underscores.
    pub name: String,
    /// As text.
    pub svg: String,
}

impl Plot {
    /// As a PNG file: `width` pixels wide, 200 to 10,000, or twice as many as the SVG.
    ///
    /// # Errors
    /// [`PictureError::Width`], [`PictureError::Png`].
    pub fn png(&self, width: Option<u32>) -> Result<Vec<u8>, PictureError> {
        encode::png(&self.svg, &[], drawing::scale(width, WIDTH)?)
    }
}

/// Energies, the error of their balance, the growth of cracks, and what the user asked for: columns of one unit together over time, and loads (N) over the
/// first displacement (m) if there are both.
///
/// # Cost
/// Of a history of any length, 1,600 points of a curve are drawn, the peaks among them.
///
/// # Example
/// ```
/// use fdem::results::{History, HistoryWriter, Row, plots};
///
/// let mut text = Vec::new();
/// let mut writer = HistoryWriter::new(&mut text, &["load [N]".to_owned(), "opening [m]".to_owned()])?;
/// for step in 0..10_u8 {
///     let values = vec![f64::from(step), 1e-3 * f64::from(step)];
///     writer.row(&Row { time: f64::from(step), values, ..Row::default() })?;
/// }
/// let names: Vec<String> = plots(&History::read(&text)?).into_iter().map(|plot| plot.name).collect();
/// let all = ["energies", "energy_error", "crack_growth", "histories", "histories_2", "load_displacement"];
/// assert_eq!(names, all);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plots(history: &History) -> Vec<Plot> {
    let time = history.column("time").unwrap_or_default();
    let over_time = |name: &'static str, up: Axis<'static>, curves: &[(&'static str, &'static str)]| {
        let curves = curves
            .iter()
            .filter_map(|(name, column)| Some(Curve { name, across: time, up: history.column(column)? }));
        let curves: Vec<Curve<'_>> = curves.collect();
        let description = described(&curves, "time");
        Chart { name, description, across: Axis { name: "time", unit: "s" }, up, curves }.svg()
    };
    let plot = |name: &str, svg: String| Plot { name: name.to_owned(), svg };
    let mut plots = vec![
        plot(
            "energies",
            over_time(
                "Energies",
                Axis { name: "energy", unit: "J" },
                &[
                    ("kinetic", "kinetic"),
                    ("strain", "strain"),
                    ("contact", "contact"),
                    ("friction", "friction"),
                    ("fracture", "cohesive"),
                    ("damping", "damping"),
                    ("external work", "external"),
                    ("balance", "balance"),
                ],
            ),
        ),
        plot(
            "energy_error",
            over_time(
                "Error of the energy balance",
                Axis { name: "share of the energy in the system", unit: "" },
                &[("error", "error")],
            ),
        ),
        plot(
            "crack_growth",
            over_time(
                "Crack growth",
                Axis { name: "length", unit: "m" },
                &[
                    ("all", "crack_length"),
                    ("tension", "crack_length_tension"),
                    ("shear", "crack_length_shear"),
                    ("mixed", "crack_length_mixed"),
                ],
            ),
        ),
    ];
    plots.extend(of_user(history, time));
    plots
}

/// What the user asked for.
fn of_user(history: &History, time: &[f64]) -> Vec<Plot> {
    // Units in the order in which they come first.
    let mut units: Vec<(&str, Vec<Curve<'_>>)> = Vec::new();
    for (name, up) in history.of_user() {
        let (name, unit) = split(name);
        let curve = Curve { name, across: time, up };
        match units.iter_mut().find(|(other, _)| *other == unit) {
            Some((_, curves)) => curves.push(curve),
            None => units.push((unit, vec![curve])),
        }
    }
    let curves_of = |wanted: &str| units.iter().find(|(unit, _)| *unit == wanted).map(|(_, curves)| curves);
    let mut load = None;
    if let (Some(loads), Some([displacement, ..])) = (curves_of("N"), curves_of("m").map(Vec::as_slice)) {
        let across = displacement.up;
        let curves: Vec<Curve<'_>> = loads
            .iter()
            .take(MOST_CURVES)
            .map(|load| Curve { name: load.name, across, up: load.up })
            .collect();
        let description = described(&curves, displacement.name);
        let across = Axis { name: displacement.name, unit: "m" };
        let up = Axis { name: if let [one] = &curves[..] { one.name } else { "force" }, unit: "N" };
        let svg = Chart { name: "Load and displacement", description, across, up, curves }.svg();
        load = Some(Plot { name: "load_displacement".to_owned(), svg });
    }
    let mut plots = Vec::new();
    for (unit, mut curves) in units {
        while !curves.is_empty() {
            let rest = curves.split_off(curves.len().min(MOST_CURVES));
            let description = described(&curves, "time");
            let quantity = quantity(unit);
            let up = Axis { name: if let [one] = &curves[..] { one.name } else { quantity }, unit };
            let title = capital(up.name) + " over time";
            let svg =
                Chart { name: &title, description, across: Axis { name: "time", unit: "s" }, up, curves }
                    .svg();
            let number = if plots.is_empty() { String::new() } else { format!("_{}", plots.len() + 1) };
            plots.push(Plot { name: format!("histories{number}"), svg });
            curves = rest;
        }
    }
    plots.extend(load);
    plots
}

/// `load [N]` as `load` and `N`.
fn split(name: &str) -> (&str, &str) {
    let parts = name.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    parts.map_or((name, ""), |(name, unit)| (name.trim_end(), unit))
}

/// With a capital letter.
fn capital(name: &str) -> String {
    let mut rest = name.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().chain(rest).collect())
}

/// What has the unit.
fn quantity(unit: &str) -> &'static str {
    match unit {
        "N" => "force",
        "m" => "length",
        "m/s" => "velocity",
        "Pa" => "stress",
        "J" => "energy",
        _ => "value",
    }
}

/// In words.
fn described(curves: &[Curve<'_>], over: &str) -> String {
    let mut text = format!("Curves over {over}: ");
    for (k, curve) in curves.iter().enumerate() {
        let finite = || curve.up.iter().copied().filter(|x| x.is_finite());
        let (low, high) =
            (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        let between =
            if low <= high { format!("from {low:.3e} to {high:.3e}") } else { "without values".to_owned() };
        let gap = if k > 0 { "; " } else { "" };
        text = format!("{text}{gap}{} {between}", curve.name);
    }
    text + "."
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_told_from_names() {
        assert_eq!(split("load [N]"), ("load", "N"));
        assert_eq!(split("a[1] [m/s]"), ("a[1]", "m/s"));
        assert_eq!(split("count"), ("count", ""));
        assert_eq!(split("]"), ("]", ""));
    }
}
