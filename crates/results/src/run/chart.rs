//! Charts of curves, as SVG.

use std::borrow::Cow;
use std::fmt::Write;

use crate::picture::colour::{Rgb, hex};
use crate::picture::letters;
use crate::picture::svg::{Anchor, INK, PALE, Svg};
use crate::picture::text::fitting;
use crate::picture::ticks::{tick_text, ticks};
use crate::run::unit::prefixed;

/// Size of a chart with its axes and texts.
pub(crate) const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 360.0;

const LEFT: f64 = 66.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = 52.0;
/// Least and greatest width of the names of curves beside the chart.
const NAMES: [f64; 2] = [56.0, 230.0];
/// Font sizes of curve names, titles and axes: the usual size, and the smallest to which long texts shrink.
const OF_NAMES: [f64; 2] = [11.5, 9.0];
const OF_TITLES: [f64; 2] = [13.5, 10.0];
const OF_AXES: [f64; 2] = [12.0, 9.0];
const RIGHT: f64 = 20.0;

/// Maximum number of points drawn of a curve: about the number of pixels across a picture.
const MOST_POINTS: usize = 1600;

/// Colours of the curves, used in turn. They are distinct on white and on black; dashes distinguish the
/// curves, too.
const COLOURS: [Rgb; 8] = [
    [31, 119, 190],
    [226, 105, 30],
    [42, 155, 90],
    [150, 90, 190],
    [214, 58, 85],
    [140, 112, 62],
    [5, 142, 153],
    [112, 124, 138],
];
const DASHES: [&str; 3] = ["", "7 3", "2 3"];

/// Quantity and unit of an axis.
pub(crate) struct Axis<'a> {
    pub(crate) name: &'a str,
    pub(crate) unit: &'a str,
}

/// A curve. Values that are not finite leave gaps.
pub(crate) struct Curve<'a> {
    pub(crate) name: &'a str,
    pub(crate) across: Cow<'a, [f64]>,
    pub(crate) up: Cow<'a, [f64]>,
    /// Running mean, if the values are noisy. It is drawn over the values, which are pale.
    pub(crate) mean: Option<Mean>,
}

/// Running mean of a curve.
pub(crate) struct Mean {
    /// Number of rows that are averaged.
    pub(crate) rows: usize,
    pub(crate) across: Vec<f64>,
    pub(crate) up: Vec<f64>,
}

impl<'a> Curve<'a> {
    /// A curve without a mean.
    pub(crate) fn plain(name: &'a str, across: &'a [f64], up: &'a [f64]) -> Self {
        Self { name, across: Cow::Borrowed(across), up: Cow::Borrowed(up), mean: None }
    }
}

/// Curves with common axes.
pub(crate) struct Chart<'a> {
    pub(crate) name: &'a str,
    /// Description for screen readers.
    pub(crate) description: String,
    pub(crate) across: Axis<'a>,
    pub(crate) up: Axis<'a>,
    /// Whether the axis across is logarithmic. Values must be above 0 then; others leave gaps.
    pub(crate) logarithmic: bool,
    /// Whether the axis across counts: only whole numbers from 0 on are named.
    pub(crate) whole: bool,
    pub(crate) curves: Vec<Curve<'a>>,
}

/// Conversion of the numbers of an axis to positions in the chart.
struct AxisScale {
    /// Limits in the displayed unit; their decimal logarithms on a logarithmic axis.
    low: f64,
    high: f64,
    factor: f64,
    unit: String,
    logarithmic: bool,
}

impl AxisScale {
    fn of(values: impl Iterator<Item = f64>, unit: &str) -> Self {
        let (mut low, mut high) = (0.0_f64, 0.0_f64);
        for value in values.filter(|value| value.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        let (factor, unit) = prefixed(unit, high.max(-low));
        let (mut low, mut high) = (low * factor, high * factor);
        if low == high || !(high - low).is_finite() {
            (low, high) = (0.0, 1.0);
        }
        // There is a margin beyond the curves, except at a lower limit of 0.
        let gap = 0.04 * (high - low);
        Self {
            low: if low < 0.0 { low - gap } else { 0.0 },
            high: high + gap,
            factor,
            unit,
            logarithmic: false,
        }
    }

    /// A logarithmic axis, with a margin beyond the least and the greatest value. Its ticks are at 1, 2 and 5
    /// times powers of ten; it has at least two of them.
    fn logarithmic(values: impl Iterator<Item = f64>, unit: &str) -> Self {
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        for value in values.filter(|&value| value > 0.0 && value.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        let (factor, unit) = prefixed(unit, high);
        let (mut low, mut high) = ((low * factor).log10(), (high * factor).log10());
        if !(low.is_finite() && high.is_finite()) {
            (low, high) = (0.0, 1.0);
        }
        let gap = (0.04 * (high - low)).max(0.5 * (0.8 - (high - low)));
        Self { low: low - gap, high: high + gap, factor, unit, logarithmic: true }
    }

    fn share(&self, value: f64) -> f64 {
        let value = value * self.factor;
        ((if self.logarithmic { value.log10() } else { value }) - self.low) / (self.high - self.low)
    }

    /// Round numbers on the axis, in the displayed unit: about `count`.
    fn ticks(&self, count: usize) -> Vec<f64> {
        if !self.logarithmic {
            return ticks(self.low, self.high, count);
        }
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let digits: &[u8] = if self.high - self.low > 3.0 { &[1] } else { &[1, 2, 5] };
        // The numbers are parsed from their digits: computed powers of ten are not exactly rounded.
        let tick = |(power, digit): (i32, &u8)| format!("{digit}e{power}").parse::<f64>().ok();
        let all = decades.flat_map(|power| digits.iter().map(move |digit| (power, digit))).filter_map(tick);
        all.filter(|tick| (self.low..=self.high).contains(&tick.log10())).collect()
    }

    fn label(&self, name: &str) -> String {
        if self.unit.is_empty() { name.to_owned() } else { format!("{name} ({})", self.unit) }
    }
}

impl Chart<'_> {
    pub(crate) fn svg(&self) -> String {
        let mut svg = Svg::new(WIDTH, HEIGHT, self.name, &self.description);
        svg.background();
        let (title, size) = fitting(self.name, WIDTH - 16.0, OF_TITLES, false);
        svg.label([8.0, 20.0], size, Anchor::Start, INK, &title);
        let wide = |curve: &Curve<'_>| letters::width(curve.name, OF_NAMES[0], false);
        let names = self.curves.iter().map(wide).fold(NAMES[0], f64::max).min(NAMES[1]);
        let legend = if self.curves.len() > 1 { 46.0 + names } else { 0.0 };
        let (width, height) = (WIDTH - LEFT - RIGHT - legend, HEIGHT - TOP - BOTTOM);
        let values = self.curves.iter().flat_map(|curve| curve.across.iter().copied());
        let scale = if self.logarithmic { AxisScale::logarithmic } else { AxisScale::of };
        let across = scale(values, self.across.unit);
        let up = AxisScale::of(self.curves.iter().flat_map(|curve| curve.up.iter().copied()), self.up.unit);
        let place = |[x, y]: [f64; 2]| [LEFT + across.share(x) * width, TOP + (1.0 - up.share(y)) * height];

        for tick in up.ticks(5) {
            let [_, y] = place([0.0, tick / up.factor]);
            svg.put(format_args!(
                r##"<line class="grid" x1="{LEFT:.1}" y1="{y:.1}" x2="{:.1}" y2="{y:.1}" stroke="#e3e7eb" stroke-width="1"/>"##,
                LEFT + width
            ));
            svg.label([LEFT - 7.0, y + 4.0], 11.0, Anchor::End, INK, &tick_text(tick));
        }
        let named = |tick: &f64| !self.whole || (*tick >= 0.0 && tick.fract() == 0.0);
        for tick in across.ticks(6).into_iter().filter(named) {
            let [x, _] = place([tick / across.factor, 0.0]);
            if self.logarithmic {
                svg.put(format_args!(
                    r##"<line class="grid" x1="{x:.1}" y1="{TOP:.1}" x2="{x:.1}" y2="{:.1}" stroke="#e3e7eb" stroke-width="1"/>"##,
                    TOP + height
                ));
            }
            svg.line([x, TOP + height], [x, TOP + height + 4.0], 1.0, INK);
            svg.label([x, TOP + height + 17.0], 11.0, Anchor::Middle, INK, &tick_text(tick));
        }
        svg.line([LEFT, TOP + height], [LEFT + width, TOP + height], 1.2, INK);
        if up.low < 0.0 {
            let [_, zero] = place([0.0, 0.0]);
            svg.line([LEFT, zero], [LEFT + width, zero], 0.8, PALE);
        }
        if let Some(Mean { rows, .. }) = self.curves.iter().find_map(|curve| curve.mean.as_ref()) {
            let note = format!("pale: recorded; bold: running mean of {rows} rows");
            svg.label([WIDTH - RIGHT, TOP - 12.0], 10.5, Anchor::End, PALE, &note);
        }
        let (name, size) = fitting(&up.label(self.up.name), WIDTH / 2.0, OF_AXES, false);
        svg.label([LEFT - 58.0, TOP - 12.0], size, Anchor::Start, PALE, &name);
        let middle = LEFT + width / 2.0;
        let (name, size) = fitting(&across.label(self.across.name), WIDTH - 2.0 * LEFT, OF_AXES, false);
        svg.label([middle, HEIGHT - 12.0], size, Anchor::Middle, PALE, &name);

        if self.across.unit == "s" {
            // Pages move it to the time of the frame that they show, and make it visible: x is that of 0 s,
            // and `data-rate` the way in a second.
            let [[zero, _], [one, _]] = [0.0, 1.0].map(|time| place([time, 0.0]));
            svg.put(format_args!(
                r#"<line class="cursor" x1="{zero:.1}" y1="{TOP:.1}" x2="{zero:.1}" y2="{:.1}" stroke="{}" stroke-width="1" visibility="hidden" data-zero="{zero}" data-rate="{}"/>"#,
                TOP + height,
                hex(COLOURS[0]),
                one - zero
            ));
        }
        for (k, curve) in self.curves.iter().enumerate() {
            let colour = hex(COLOURS[k % COLOURS.len()]);
            let dash = match DASHES[k % DASHES.len()] {
                "" => String::new(),
                dash => format!(r#" stroke-dasharray="{dash}""#),
            };
            let mut values = (&curve.across[..], &curve.up[..]);
            if let Some(mean) = &curve.mean {
                svg.put(format_args!(
                    r#"<path class="recorded" d="{}" fill="none" stroke="{colour}" stroke-width="1" stroke-opacity="0.35" stroke-linejoin="round"/>"#,
                    path(values.0, values.1, place)
                ));
                values = (&mean.across[..], &mean.up[..]);
            }
            svg.put(format_args!(
                r#"<path class="curve" d="{}" fill="none" stroke="{colour}" stroke-width="1.7" stroke-linejoin="round"{dash}/>"#,
                path(values.0, values.1, place)
            ));
            if legend > 0.0 {
                let (x, y) = (LEFT + width + 14.0, TOP + 8.0 + 19.0 * k as f64);
                svg.put(format_args!(
                    r#"<line x1="{x:.1}" y1="{y:.1}" x2="{:.1}" y2="{y:.1}" stroke="{colour}" stroke-width="2"{dash}/>"#,
                    x + 20.0
                ));
                let (name, size) = fitting(curve.name, names, OF_NAMES, false);
                svg.label([x + 26.0, y + 4.0], size, Anchor::Start, INK, &name);
            }
        }
        svg.finish()
    }
}

/// Returns an SVG path of lines between consecutive points. Points that are not finite leave a gap.
fn path(across: &[f64], up: &[f64], place: impl Fn([f64; 2]) -> [f64; 2]) -> String {
    let mut path = String::new();
    let mut drawing = false;
    for k in shown(up) {
        let [x, y] = place([across[k], up[k]]);
        if x.is_finite() && y.is_finite() {
            // Writing to a string does not fail.
            let _ = write!(path, "{}{x:.1} {y:.1}", if drawing { 'L' } else { 'M' });
        }
        drawing = x.is_finite() && y.is_finite();
    }
    path
}

/// Returns the indices of the points of a curve that are drawn. A long curve is divided into stretches. The
/// first, the last, the least and the greatest value of each stretch are drawn, so that no peak is lost.
fn shown(values: &[f64]) -> Vec<usize> {
    if values.len() <= MOST_POINTS {
        return (0..values.len()).collect();
    }
    let stretch = values.len().div_ceil(MOST_POINTS / 4);
    let mut places = Vec::with_capacity(MOST_POINTS);
    for start in (0..values.len()).step_by(stretch) {
        let all = start..values.len().min(start + stretch);
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let finite = || all.clone().filter(|&k| values[k].is_finite());
        let mut four = vec![all.start, all.end - 1];
        four.extend(finite().min_by(by_value));
        four.extend(finite().max_by(by_value));
        four.sort_unstable();
        four.dedup();
        places.extend(four);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_peak_among_many_points_is_drawn() {
        let mut values = vec![0.0; 100_000];
        values[54_321] = 3.0;
        values[10] = f64::NAN;
        let places = shown(&values);
        assert!(places.len() <= MOST_POINTS && places.is_sorted());
        assert!(places.contains(&54_321) && places.contains(&0) && places.contains(&99_999));
    }

    #[test]
    fn a_logarithmic_axis_has_round_ticks_and_equal_decades() {
        let scale = AxisScale::logarithmic([2e-3, 0.0, f64::NAN, 0.15].into_iter(), "m");
        assert_eq!((scale.ticks(6), scale.unit.as_str()), (vec![2.0, 5.0, 10.0, 20.0, 50.0, 100.0], "mm"));
        let apart = [[1e-3, 1e-2], [1e-2, 1e-1]].map(|[a, b]| scale.share(b) - scale.share(a));
        assert!((apart[0] - apart[1]).abs() < 1e-12 && apart[0] > 0.0, "{apart:?}");
        assert!(!scale.share(0.0).is_finite());
        let wide = AxisScale::logarithmic([1e-6, 1.0].into_iter(), "m");
        assert_eq!(wide.ticks(6), [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0]);
        let one = AxisScale::logarithmic([0.03].into_iter(), "m");
        assert!(one.ticks(6).len() >= 2, "{:?}", one.ticks(6));
        assert!((one.share(0.03) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn gaps_stay_gaps_and_constants_have_an_axis() {
        let across = [0.0, 1.0, 2.0, 3.0];
        let up = [1.0, f64::NAN, 2.0, f64::INFINITY];
        assert_eq!(path(&across, &up, |point| point), "M0.0 1.0M2.0 2.0");
        let scale = AxisScale::of([f64::NAN, 0.0].into_iter(), "J");
        assert_eq!((scale.low, scale.high), (0.0, 1.04));
        let scale = AxisScale::of([-2e3, 0.0].into_iter(), "J");
        assert_eq!((scale.share(0.0) > 0.9, scale.label("energy").as_str()), (true, "energy (kJ)"));
    }
}
