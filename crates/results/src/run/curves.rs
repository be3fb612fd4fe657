//! Curves of one column of a history over another: peak, modulus, and the stresses at which cracks initiate
//! and damage a specimen in compression.
//!
//! The definitions of the latter two are those of C. D. Martin and N. A. Chandler, The progressive fracture
//! of Lac du Bonnet granite, Int. J. Rock Mech. Min. Sci. Geomech. Abstr. 31 (1994) 643-659: cracks initiate
//! where the first ones grow, here where the first joints pass their strength; the crack-damage stress is
//! where the volumetric strain turns from contraction to dilation.

use crate::run::chart::{Axis, Chart, Curve};
use crate::run::history::History;
use crate::run::noise::mean;
use crate::run::plots::Plot;
use crate::run::unit::split;

/// Shares of the peak between which the modulus is the slope of a curve: below, bodies settle; above, they
/// yield.
const SLOPE: [f64; 2] = [0.1, 0.5];

/// Longest name of the file of a curve, bytes. File systems allow 255, with the extension and a number that
/// keeps equal names apart.
const LONGEST: usize = 200;

/// The request for a curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HistoryCurve {
    /// Name.
    pub name: String,
    /// Column across, with its unit: `axial strain [m/m]`.
    pub x: String,
    /// Column upwards, with its unit.
    pub y: String,
    /// Length by which a displacement across is divided, m: it becomes a strain.
    pub length: Option<f64>,
    /// Area by which a force upwards is divided, m²: it becomes a stress.
    pub area: Option<f64>,
    /// Column of the length or area of joints past their strength, with its unit.
    pub softening: Option<String>,
    /// Columns of the strains across the axis, with their units.
    pub lateral: Vec<String>,
    /// Whether the curve may be without values.
    pub optional: bool,
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Value across.
    pub x: f64,
    /// Value upwards.
    pub y: f64,
    /// Time, s.
    pub time: f64,
}

/// Figures of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveFigures {
    /// Name of the curve.
    pub name: String,
    /// The value upwards with the largest magnitude, with its sign.
    pub peak: f64,
    /// The value across there.
    pub at: f64,
    /// Time of the peak, s.
    pub time: f64,
    /// Slope of the straight line with the least squares through the rows between 10 % and 50 % of the peak,
    /// the first time that the curve rises through these. `None` if fewer than three rows are there, or if
    /// nothing changes across.
    pub modulus: Option<f64>,
    /// The first row in which more joints are past their strength than in the first row: crack initiation.
    /// `None` if no joint is, or if the curve has no such column.
    pub initiation: Option<CurvePoint>,
    /// The row up to the peak in which the volume is smallest, where contraction turns to dilation: crack
    /// damage. `None` if the volume shrinks up to the peak, or if the curve has no lateral strains.
    pub damage: Option<CurvePoint>,
    /// Units across and upwards.
    pub units: [String; 2],
}

impl CurveFigures {
    /// The unit of the modulus.
    pub fn modulus_unit(&self) -> String {
        match &self.units {
            [x, y] if x == "m/m" => y.clone(),
            [x, y] => format!("{y}/{x}"),
        }
    }
}

impl HistoryCurve {
    /// The values across and upwards, with their units. `None` if a history has no such columns.
    fn values(&self, history: &History) -> Option<[(Vec<f64>, String); 2]> {
        let column = |name: &str, over: Option<f64>, becomes: &str| -> Option<(Vec<f64>, String)> {
            let values = history.column(name)?;
            let unit = if over.is_some() { becomes } else { unit_of(name) };
            let over = over.unwrap_or(1.0);
            Some((values.iter().map(|value| value / over).collect(), unit.to_owned()))
        };
        Some([column(&self.x, self.length, "m/m")?, column(&self.y, self.area, "Pa")?])
    }

    /// Finds the peak and the modulus. `None` if the history has no such columns or no values in them.
    ///
    /// # Example
    /// ```
    /// use fdem_results::{History, HistoryCurve, HistoryWriter, Row};
    ///
    /// let mut text = Vec::new();
    /// let mut writer = HistoryWriter::new(&mut text, 2, &["e [m/m]".to_owned(), "s [Pa]".to_owned()])?;
    /// for step in 0..=20_u8 {
    ///     let strain = 1e-4 * f64::from(step);
    ///     let stress = if step <= 15 { 5e9 * strain } else { 0.0 };
    ///     writer.row(&Row { time: f64::from(step), values: vec![-strain, -stress], ..Row::default() })?;
    /// }
    /// let curve = HistoryCurve { x: "e [m/m]".into(), y: "s [Pa]".into(), ..HistoryCurve::default() };
    /// let figures = curve.figures(&History::read(&text)?).unwrap();
    /// assert_eq!((figures.peak, figures.time), (-7.5e6, 15.0));
    /// assert!((figures.modulus.unwrap() / 5e9 - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn figures(&self, history: &History) -> Option<CurveFigures> {
        let [(across, x), (up, y)] = self.values(history)?;
        let time = history.column("time")?;
        let rows = || across.iter().zip(&up).enumerate().filter(|(_, (x, y))| x.is_finite() && y.is_finite());
        let mut peak: Option<(usize, f64)> = None;
        for (row, (_, y)) in rows() {
            // The first of equal peaks.
            if peak.is_none_or(|(_, most)| y.abs() > most) {
                peak = Some((row, y.abs()));
            }
        }
        let (row, most) = peak?;
        let sign = up[row].signum();
        let risen = rows().find(|(_, (_, y))| sign * **y > SLOPE[1] * most).map_or(row, |(row, _)| row);
        let branch: Vec<[f64; 2]> = rows()
            .filter(|(row, (_, y))| *row < risen && sign * **y >= SLOPE[0] * most)
            .map(|(_, (x, y))| [*x, *y])
            .collect();
        let point = |row: usize| CurvePoint {
            x: across[row],
            y: up[row],
            time: time.get(row).copied().unwrap_or(f64::NAN),
        };
        Some(CurveFigures {
            name: self.name.clone(),
            peak: up[row],
            at: across[row],
            time: point(row).time,
            modulus: slope(&branch),
            initiation: self.initiation(history).map(point),
            damage: self.smallest_volume(history, &across[..=row]).map(point),
            units: [x, y],
        })
    }

    /// Says why the curve has no figures: which of its columns have no values. `None` if it has figures.
    pub fn why_empty(&self, history: &History) -> Option<String> {
        if self.figures(history).is_some() {
            return None;
        }
        let has_values = |name: &str| {
            history.column(name).is_some_and(|values| values.iter().any(|value| value.is_finite()))
        };
        let empty: Vec<String> = [&self.x, &self.y]
            .into_iter()
            .filter(|name| !has_values(name))
            .map(|name| format!("\"{name}\""))
            .collect();
        Some(match &empty[..] {
            [] => format!("no row has values of both \"{}\" and \"{}\"", self.x, self.y),
            [one] => format!("{one} has no values"),
            both => format!("{} have no values", both.join(" and ")),
        })
    }

    /// The first row in which more joints are past their strength than in the first row.
    fn initiation(&self, history: &History) -> Option<usize> {
        let damaged = history.column(self.softening.as_ref()?)?;
        let first = damaged.first()?;
        damaged.iter().position(|length| length > first)
    }

    /// The row in which the volume is smallest, unless that is the last one. `across`: the axial strains up
    /// to the peak, of which the last one has the sign of a contraction.
    fn smallest_volume(&self, history: &History, across: &[f64]) -> Option<usize> {
        let lateral: Vec<_> = self.lateral.iter().map(|name| history.column(name)).collect::<Option<_>>()?;
        let last = across.len().checked_sub(1).filter(|_| !lateral.is_empty())?;
        let sign = across[last].signum();
        let mut smallest: Option<(usize, f64)> = None;
        for (row, axial) in across.iter().enumerate() {
            let contraction = sign * (axial + lateral.iter().map(|strain| strain[row]).sum::<f64>());
            if smallest.is_none_or(|(_, most)| contraction > most) {
                smallest = Some((row, contraction));
            }
        }
        smallest.map(|(row, _)| row).filter(|row| *row < last)
    }

    /// Plots the curve, positive at its peak: a test in compression rises to the right.
    pub fn plot(&self, history: &History) -> Option<Plot> {
        let figures = self.figures(history)?;
        let [(across, x), (up, y)] = self.values(history)?;
        let turned = |values: Vec<f64>, peak: f64| -> Vec<f64> {
            let sign = if peak < 0.0 { -1.0 } else { 1.0 };
            values.into_iter().map(|value| sign * value).collect()
        };
        let [across, up] = [turned(across, figures.at), turned(up, figures.peak)];
        let axis =
            |name: &str, value: f64| format!("{}{}", if value < 0.0 { "−" } else { "" }, split(name).0);
        let names = [axis(&self.x, figures.at), axis(&self.y, figures.peak)];
        let curve = Curve { mean: mean(&across, &up), ..Curve::plain(&self.name, &across, &up) };
        let chart = Chart {
            name: &self.name,
            description: format!(
                "{} over {}: a peak of {:.3e} {y} at {:.3e} {x}.",
                names[1],
                names[0],
                figures.peak.abs(),
                figures.at.abs()
            ),
            across: Axis { name: &names[0], unit: &x },
            up: Axis { name: &names[1], unit: &y },
            logarithmic: false,
            whole: false,
            curves: vec![curve],
        };
        let mut name = "curve_".to_owned();
        for c in self.name.chars() {
            let letter = if c.is_alphanumeric() { c.to_lowercase().next().unwrap_or(c) } else { '_' };
            if name.len() + letter.len_utf8() > LONGEST {
                break;
            }
            name.push(letter);
        }
        Some(Plot { name, svg: chart.svg() })
    }
}

/// The unit of a column. Columns of every history have no unit in their names.
fn unit_of(name: &str) -> &str {
    let energies = [
        "kinetic",
        "strain",
        "contact",
        "friction",
        "joint_elastic",
        "joint_dissipated",
        "damping",
        "external",
        "balance",
    ];
    match split(name).1 {
        "" if name == "time" => "s",
        "" if name.starts_with("crack_length") => "m",
        "" if name.starts_with("crack_area") => "m²",
        "" if energies.contains(&name) => "J",
        unit => unit,
    }
}

/// The slope of the straight line with the least squares. `None` for fewer than three points, or if they are
/// one above the other.
fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let count = points.len() as f64;
    let middle = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let [x, y] = [middle(0), middle(1)];
    let squares: f64 = points.iter().map(|point| (point[0] - x) * (point[0] - x)).sum();
    let products: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    (points.len() >= 3 && squares > 0.0).then(|| products / squares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::history::{HistoryWriter, Row};

    fn history(rows: &[[f64; 2]]) -> History {
        let mut text = Vec::new();
        let names = ["top uy [m]", "top fy [N]"].map(str::to_owned);
        let mut writer = HistoryWriter::new(&mut text, 2, &names).unwrap();
        for (step, row) in (0..).zip(rows) {
            let row = Row { step, time: 1e-3 * step as f64, values: row.to_vec(), ..Row::default() };
            writer.row(&row).unwrap();
        }
        History::read(&text).unwrap()
    }

    #[test]
    fn a_curve_without_values_says_which_column_lacks_them() {
        let nan = f64::NAN;
        let why = |rows: &[[f64; 2]]| curve().why_empty(&history(rows));
        assert_eq!(why(&[[0.0, 0.0], [1.0, 2.0]]), None);
        assert_eq!(why(&[[0.0, nan], [1.0, nan]]).unwrap(), "\"top fy [N]\" has no values");
        assert_eq!(why(&[]).unwrap(), "\"top uy [m]\" and \"top fy [N]\" have no values");
        assert!(why(&[[0.0, nan], [nan, 1.0]]).unwrap().starts_with("no row has values of both"));
    }

    fn curve() -> HistoryCurve {
        HistoryCurve {
            name: "Test 1: load".to_owned(),
            x: "top uy [m]".to_owned(),
            y: "top fy [N]".to_owned(),
            ..HistoryCurve::default()
        }
    }

    /// Settling at first, then a straight line, a peak, and softening through the same forces.
    fn specimen() -> Vec<[f64; 2]> {
        let force = |u: f64| match u {
            u if u < 10.0 => 0.5 * u,
            u if u < 100.0 => 5.0 + 2.0 * (u - 10.0),
            u => 185.0 - 3.0 * (u - 100.0),
        };
        (0..=150).map(|k| [-1e-6 * f64::from(k), -1e3 * force(f64::from(k))]).collect()
    }

    #[test]
    fn the_modulus_is_the_slope_before_half_of_the_peak() {
        let history = history(&specimen());
        let figures = curve().figures(&history).unwrap();
        assert_eq!((figures.peak, figures.at, figures.time), (-185e3, -1e-6 * 100.0, 0.1));
        assert!((figures.modulus.unwrap() / 2e9 - 1.0).abs() < 1e-9, "{figures:?}");
        assert_eq!(figures.modulus_unit(), "N/m");
        let stress = HistoryCurve { length: Some(0.1), area: Some(0.05), ..curve() };
        let figures = stress.figures(&history).unwrap();
        assert!((figures.peak / -3.7e6 - 1.0).abs() < 1e-12 && (figures.at / -1e-3 - 1.0).abs() < 1e-12);
        assert!((figures.modulus.unwrap() / 4e9 - 1.0).abs() < 1e-9);
        assert_eq!((figures.units[0].as_str(), figures.modulus_unit().as_str()), ("m/m", "Pa"));
        let plot = stress.plot(&history).unwrap();
        assert_eq!(plot.name, "curve_test_1__load");
        assert!(plot.svg.contains("MPa") && plot.svg.contains("−top fy"), "{}", plot.svg);
    }

    /// A test in compression: cracks initiate at 40 % of the peak, and the lateral strain, 0.2 of the axial
    /// one and then growing with the square of the excess, takes over at 75 %.
    #[test]
    fn cracks_initiate_and_damage_a_specimen() {
        let mut text = Vec::new();
        let names = ["a strain [m/m]", "s syy [Pa]", "l strain [m/m]", "c softening_length [m]"];
        let mut writer = HistoryWriter::new(&mut text, 2, &names.map(str::to_owned)).unwrap();
        let lateral = |load: f64| 0.2 * load + 0.8 / 70.0 * (load - 40.0).max(0.0).powi(2);
        for load in 0..=110_u8 {
            let load = f64::from(load);
            let stress = if load <= 100.0 { load } else { 200.0 - load };
            let damaged = 0.5 + if load >= 40.0 { load - 39.0 } else { 0.0 };
            let values = vec![-1e-5 * load, -1e6 * stress, 1e-5 * lateral(load), damaged];
            writer.row(&Row { time: 1e-3 * load, values, ..Row::default() }).unwrap();
        }
        let history = History::read(&text).unwrap();
        let curve = HistoryCurve {
            x: names[0].to_owned(),
            y: names[1].to_owned(),
            softening: Some(names[3].to_owned()),
            lateral: vec![names[2].to_owned()],
            ..curve()
        };
        let figures = curve.figures(&history).unwrap();
        assert_eq!(figures.peak, -100e6);
        assert_eq!(figures.initiation.unwrap(), CurvePoint { x: -1e-5 * 40.0, y: -40e6, time: 1e-3 * 40.0 });
        assert_eq!(figures.damage.map(|point| point.y), Some(-75e6));
        // A lateral strain that does not grow: the volume shrinks up to the peak.
        let elastic = HistoryCurve { lateral: vec!["step".to_owned()], ..curve.clone() };
        assert_eq!(elastic.figures(&history).unwrap().damage, None);
        let none = HistoryCurve { softening: None, lateral: Vec::new(), ..curve };
        let figures = none.figures(&history).unwrap();
        assert_eq!((figures.initiation, figures.damage), (None, None));
    }

    #[test]
    fn curves_without_a_rise_have_no_modulus() {
        let figures = |rows: &[[f64; 2]]| curve().figures(&history(rows));
        assert_eq!(figures(&[]), None);
        assert_eq!(figures(&[[0.0, 0.0], [1.0, 5.0]]).unwrap().modulus, None);
        let upright = [[1.0, 0.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0], [1.0, 9.0]];
        assert_eq!(figures(&upright).unwrap().modulus, None);
        let gap = figures(&[[0.0, 1.0], [1.0, f64::NAN], [2.0, 0.5]]).unwrap();
        assert_eq!((gap.peak, gap.at), (1.0, 0.0));
        let other = HistoryCurve { x: "time".to_owned(), ..curve() };
        assert_eq!(other.figures(&history(&specimen())).unwrap().modulus_unit(), "N/s");
        let none = HistoryCurve { x: "nothing".to_owned(), ..curve() };
        assert_eq!(none.figures(&history(&specimen())), None);
    }
}
