//! Plots of the history of a run.

use fdem_simulation::Energies;

use crate::picture::{PictureError, drawing, encode};
use crate::run::chart::{Axis, Chart, Curve, WIDTH};
use crate::run::fragments::SizeDistribution;
use crate::run::history::History;
use crate::run::loads::{Loading, loading};
use crate::run::noise::mean;
use crate::run::unit::split;

/// Maximum number of curves in a plot: more could not be distinguished.
const MOST_CURVES: usize = 8;

/// Energies that an initial stress stores from the beginning, and the names of the curves of their changes.
const STORED: [(&str, &str); 2] =
    [("strain", "strain (change)"), ("joint_elastic", "elastic, of joints (change)")];

/// If the first row has more than this share of the largest stored energy, there is an initial stress; less
/// is rounding.
const INITIAL: f64 = 1e-6;

/// A plot of a history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plot {
    /// Name for a file: letters, digits and underscores.
    pub name: String,
    /// The plot as SVG.
    pub svg: String,
}

impl Plot {
    /// Returns the plot as a PNG file, `width` pixels wide (200 to 10,000). Without a width it is twice as
    /// wide as the SVG.
    ///
    /// # Errors
    /// [`PictureError::Width`], [`PictureError::Png`].
    pub fn png(&self, width: Option<u32>) -> Result<Vec<u8>, PictureError> {
        encode::png(&self.svg, &[], drawing::scale(width, WIDTH)?)
    }
}

/// Plots a history: energies, the error of their balance, the growth of cracks, the number of fragments if it
/// changes, the user's columns over time by unit, and forces over displacements.
///
/// The last plot shows the force of each boundary over its own displacement. Both are along the axis on which
/// the force does most work, positive in the direction of motion. If no boundary with a force moves, the plot
/// shows the forces over the displacement of a node, along the axis of the largest force. A noisy force is
/// drawn pale, with its running mean over it.
///
/// # Cost
/// At most 1,600 points of a curve are drawn, however long the history is. Peaks are always drawn.
///
/// # Example
/// ```
/// use fdem_results::{History, HistoryWriter, Row, plots};
///
/// let mut text = Vec::new();
/// let columns = ["top fx [N]", "top fy [N]", "top ux [m]", "top uy [m]"].map(String::from);
/// let mut writer = HistoryWriter::new(&mut text, 2, &columns)?;
/// for step in 0..10_u8 {
///     let values = vec![0.0, -f64::from(step), 0.0, -1e-3 * f64::from(step)];
///     writer.row(&Row { time: f64::from(step), values, ..Row::default() })?;
/// }
/// let names: Vec<String> = plots(&History::read(&text)?).into_iter().map(|plot| plot.name).collect();
/// let own = ["energies", "energy_error", "crack_growth"];
/// assert_eq!(names[..3], own);
/// assert_eq!(names[3..], ["histories_forces", "histories_displacements", "load_displacement"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plots(history: &History) -> Vec<Plot> {
    let time = history.column("time").unwrap_or_default();
    let changed = STORED.map(|(column, name)| (column, name, change_of(history, column)));
    let over_time = |name: &'static str, up: Axis<'static>, curves: &[(&'static str, &'static str)]| {
        let curve = |(name, column): &(&'static str, &'static str)| match changed
            .iter()
            .find(|(stored, ..)| stored == column)
        {
            Some((_, name, Some(up))) => Some(Curve::plain(name, time, up)),
            _ => Some(Curve::plain(name, time, history.column(column)?)),
        };
        let curves: Vec<Curve<'_>> = curves.iter().filter_map(curve).collect();
        let description = described(&curves, "time");
        let across = Axis { name: "time", unit: "s" };
        Chart { name, description, across, up, logarithmic: false, whole: false, curves }.svg()
    };
    let plot = |name: &str, svg: String| Plot { name: name.to_owned(), svg };
    let cracked = match history.column("crack_area") {
        Some(_) => Axis { name: "area", unit: "m²" },
        None => Axis { name: "length", unit: "m" },
    };
    let mut energies: Vec<_> = Energies::default().changing().map(|term| (term.name, term.key)).collect();
    energies.push(("balance", "balance"));
    let mut plots = vec![
        plot("energies", over_time("Energies", Axis { name: "energy", unit: "J" }, &energies)),
        plot(
            "energy_error",
            over_time(
                "Error of the energy balance",
                Axis { name: "share of the energy exchanged", unit: "" },
                &[("error", "error")],
            ),
        ),
        plot(
            "crack_growth",
            over_time(
                "Crack growth",
                cracked,
                &[
                    ("all", "crack_length"),
                    ("tension", "crack_length_tension"),
                    ("shear", "crack_length_shear"),
                    ("mixed", "crack_length_mixed"),
                    ("all", "crack_area"),
                    ("tension", "crack_area_tension"),
                    ("shear", "crack_area_shear"),
                    ("mixed", "crack_area_mixed"),
                ],
            ),
        ),
    ];
    // A number that never changes is that of the bodies.
    if history.column("fragments").is_some_and(|numbers| numbers.windows(2).any(|two| two[0] != two[1])) {
        let up = Axis { name: "number of fragments", unit: "" };
        plots.push(plot("fragments", over_time("Fragments", up, &[("fragments", "fragments")])));
    }
    plots.extend(by_unit(history, time));
    plots.extend(load_displacement(history));
    plots
}

/// Plots the distribution of the sizes of fragments: the share of the mass that passes a size, over the size
/// on a logarithmic axis. `None` if there are not two fragments.
pub fn fragment_sizes(sizes: &SizeDistribution) -> Option<Plot> {
    // The first point means no fragment.
    if sizes.sizes().len() < 3 {
        return None;
    }
    let (across, percent) = bent(sizes.sizes(), sizes.shares());
    let curves = vec![Curve::plain("passing", &across, &percent)];
    let chart = Chart {
        name: "Sizes of fragments at the end",
        description: described(&curves, "size"),
        across: Axis { name: "equivalent diameter", unit: "m" },
        up: Axis { name: "passing, share of the mass", unit: "%" },
        logarithmic: true,
        whole: false,
        curves,
    };
    Some(Plot { name: "fragment_sizes".to_owned(), svg: chart.svg() })
}

/// Names of the plots of [`rank_loads`].
pub const RANK_PLOTS: [&str; 2] = ["ranks_elements", "ranks_messages"];

/// A rank of a run on many ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RankLoad {
    /// Elements that it counts.
    pub own: f64,
    /// Elements that it computes too, because they act on its nodes or are near its elements.
    pub halo: f64,
    /// Bytes of motions of nodes that it sends in a step.
    pub bytes: f64,
}

/// Plots the elements of each rank at the end, and the bytes that it sends in a step.
pub fn rank_loads(ranks: &[RankLoad]) -> [Plot; 2] {
    // A level for each rank, around its number.
    let across: Vec<f64> = (0..ranks.len()).flat_map(|rank| [rank as f64 - 0.5, rank as f64 + 0.5]).collect();
    let levels =
        |of: fn(&RankLoad) -> f64| -> Vec<f64> { ranks.iter().flat_map(|rank| [of(rank); 2]).collect() };
    let [own, halo, bytes] = [levels(|rank| rank.own), levels(|rank| rank.halo), levels(|rank| rank.bytes)];
    let plot = |name: &str, title, up, curves: Vec<Curve<'_>>| {
        let description = described(&curves, "rank");
        let across = Axis { name: "rank", unit: "" };
        let chart = Chart { name: title, description, across, up, logarithmic: false, whole: true, curves };
        Plot { name: name.to_owned(), svg: chart.svg() }
    };
    let curve = |name, levels| Curve::plain(name, &across, levels);
    [
        plot(
            RANK_PLOTS[0],
            "Elements of each rank at the end",
            Axis { name: "elements", unit: "" },
            vec![curve("own", &own), curve("halo", &halo)],
        ),
        plot(
            RANK_PLOTS[1],
            "Bytes that each rank sends in a step, in the mean",
            Axis { name: "sent", unit: "B" },
            vec![curve("sent", &bytes)],
        ),
    ]
}

/// Sizes, m, and passing shares, %, of a curve that is linear between its points. Such a curve is bent on a
/// logarithmic axis: wide stretches get points in between.
fn bent(sizes: &[f64], shares: &[f64]) -> (Vec<f64>, Vec<f64>) {
    const STRETCHES: u8 = 32;
    const WIDE: f64 = 1.05;
    let (mut across, mut percent) = (Vec::new(), Vec::new());
    for k in 0..sizes.len() {
        if k > 0 && sizes[k] > WIDE * sizes[k - 1] {
            for stretch in 1..STRETCHES {
                let part = f64::from(stretch) / f64::from(STRETCHES);
                across.push(sizes[k - 1] + part * (sizes[k] - sizes[k - 1]));
                percent.push(100.0 * (shares[k - 1] + part * (shares[k] - shares[k - 1])));
            }
        }
        across.push(sizes[k]);
        percent.push(100.0 * shares[k]);
    }
    (across, percent)
}

/// Returns the change of a stored energy since the beginning, or `None` if the bodies begin without stress.
/// The energy of an initial stress would hide all other curves.
fn change_of(history: &History, column: &str) -> Option<Vec<f64>> {
    let stored = history.column(column)?;
    let most = stored.iter().copied().filter(|x| x.is_finite()).fold(0.0, f64::max);
    let first = *stored.first().filter(|&&first| first > INITIAL * most)?;
    Some(stored.iter().map(|now| now - first).collect())
}

/// Plots the user's columns over time, grouped by unit.
fn by_unit(history: &History, time: &[f64]) -> Vec<Plot> {
    // Units are in the order of their first columns.
    let mut units: Vec<(&str, Vec<Curve<'_>>)> = Vec::new();
    for (name, up) in history.of_user() {
        if at_rest(history, name, up) {
            continue;
        }
        let (name, unit) = split(name);
        let mut curve = Curve::plain(name, time, up);
        if unit == "N" {
            curve.mean = mean(time, up);
        }
        match units.iter_mut().find(|(other, _)| *other == unit) {
            Some((_, curves)) => curves.push(curve),
            None => units.push((unit, vec![curve])),
        }
    }
    let mut plots: Vec<Plot> = Vec::new();
    for (unit, mut curves) in units {
        let (one, several) = quantity(unit);
        let parts = curves.len().div_ceil(MOST_CURVES);
        for part in 1..=parts {
            let rest = curves.split_off(curves.len().min(MOST_CURVES));
            let unit_of = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
            let mut title = match &curves[..] {
                [curve] if parts == 1 => format!("{} over time{unit_of}: {}", capital(one), curve.name),
                _ => format!("{} over time{unit_of}", capital(several)),
            };
            if parts > 1 {
                title = format!("{title}, {part} of {parts}");
            }
            let description = described(&curves, "time");
            let across = Axis { name: "time", unit: "s" };
            let up = Axis { name: one, unit };
            let svg =
                Chart { name: &title, description, across, up, logarithmic: false, whole: false, curves }
                    .svg();
            let name = format!("histories_{several}");
            // Several parts of a unit have the same name, and so have units of unknown quantities.
            let number = 1 + plots.iter().filter(|plot| plot.name.starts_with(&name)).count();
            plots.push(Plot { name: if number == 1 { name } else { format!("{name}_{number}") }, svg });
            curves = rest;
        }
    }
    plots
}

/// Whether a column is the displacement of a boundary that does not move. It is not plotted, because the plot
/// of the force suffices.
fn at_rest(history: &History, name: &str, values: &[f64]) -> bool {
    let boundary = [" ux [m]", " uy [m]", " uz [m]"].iter().find_map(|axis| name.strip_suffix(axis));
    let has_force = |boundary: &str| history.column(&format!("{boundary} fx [N]")).is_some();
    boundary.is_some_and(has_force) && values.iter().all(|&value| value == 0.0)
}

/// Plots forces over displacements.
fn load_displacement(history: &History) -> Option<Plot> {
    let Loading { across, mut loads } = loading(history)?;
    loads.truncate(MOST_CURVES);
    let curves = loads.iter().map(|load| Curve {
        mean: mean(&load.displacement, &load.force),
        ..Curve::plain(&load.name, &load.displacement, &load.force)
    });
    let curves: Vec<Curve<'_>> = curves.collect();
    let description = described(&curves, &across);
    let up = if let [one] = &loads[..] { format!("force, {}", one.name) } else { "force".to_owned() };
    let chart = Chart {
        name: "Load and displacement",
        description,
        across: Axis { name: &across, unit: "m" },
        up: Axis { name: &up, unit: "N" },
        logarithmic: false,
        whole: false,
        curves,
    };
    Some(Plot { name: "load_displacement".to_owned(), svg: chart.svg() })
}

/// Returns the name with a capital first letter.
fn capital(name: &str) -> String {
    let mut rest = name.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().chain(rest).collect())
}

/// Returns the quantity of a unit, as singular and plural.
fn quantity(unit: &str) -> (&'static str, &'static str) {
    match unit {
        "N" => ("force", "forces"),
        "m" => ("displacement", "displacements"),
        "m/s" => ("velocity", "velocities"),
        "Pa" => ("stress", "stresses"),
        "m/m" => ("strain", "strains"),
        "J" => ("energy", "energies"),
        "rad" => ("rotation", "rotations"),
        "rad/s" => ("spin", "spins"),
        "N m" => ("moment", "moments"),
        _ => ("value", "values"),
    }
}

/// Describes the curves in words.
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
    fn a_curve_of_sizes_goes_through_its_medians() {
        let (across, percent) = bent(&[1.0, 1.0, 1.01, 3.0], &[0.0, 0.2, 0.4, 0.6]);
        assert!(across.is_sorted() && percent.is_sorted() && across.len() == 4 + 31);
        assert_eq!(
            (across[..3].to_vec(), percent[..3].to_vec()),
            (vec![1.0, 1.0, 1.01], vec![0.0, 20.0, 40.0])
        );
        let half = percent.iter().position(|share| (share - 50.0).abs() < 1e-9).unwrap();
        assert!((across[half] - 2.005).abs() < 1e-12);
    }

    #[test]
    fn units_are_told_from_names() {
        assert_eq!(split("load [N]"), ("load", "N"));
        assert_eq!(split("a[1] [m/s]"), ("a[1]", "m/s"));
        assert_eq!(split("count"), ("count", ""));
        assert_eq!(split("]"), ("]", ""));
    }
}
