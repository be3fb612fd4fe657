//! Draws curves over two logarithmic axes as an SVG file with real text.

use std::error::Error;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Colours that colour-blind readers can distinguish: M. Okabe, K. Ito, "Color Universal Design".
pub const COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// Points joined by a line and named at its right end.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Label next to the last point; may be empty.
    pub name: String,
    /// Index into [`COLOURS`].
    pub colour: usize,
    /// Whether to draw hollow marks on a thin line instead of filled ones.
    pub hollow: bool,
    /// Points, positive in both coordinates.
    pub points: Vec<(f64, f64)>,
}

/// A logarithmic axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub title: String,
    /// The lowest and the highest value.
    pub ends: (f64, f64),
    /// Positions of the grid lines.
    pub ticks: Vec<f64>,
}

impl Axis {
    /// An axis from the smallest to the largest of `values`, with a grid line at each of `ticks` in between.
    pub fn within(title: &str, ticks: &[f64], values: impl IntoIterator<Item = f64>) -> Self {
        let ends = ends(values);
        let ticks = ticks.iter().copied().filter(|&tick| ends.0 <= tick && tick <= ends.1).collect();
        Self { title: title.to_owned(), ends, ticks }
    }

    /// An axis from one grid line to another, `unit * base^k` for whole k, that contains `values`.
    pub fn covering(title: &str, base: f64, unit: f64, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = ends(values);
        let power = |value: f64| (value / unit).log(base);
        let (low, high) = (power(low).floor() as i32, power(high).ceil() as i32);
        let ticks: Vec<f64> = (low..=high.max(low + 1)).map(|k| unit * base.powi(k)).collect();
        Self { title: title.to_owned(), ends: ends(ticks.iter().copied()), ticks }
    }
}

fn ends(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, 0.0), |(low, high), value| (low.min(value), high.max(value)))
}

/// One diagram of a picture.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The title above the diagram.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The curves in drawing order.
    pub curves: Vec<Curve>,
}

const SIZE: (u32, u32) = (560, 460);
const FONT: &str = "sans-serif";
/// Width of the names of the curves.
const NAMES: i32 = 88;
/// Height of a name.
const LINE: i32 = 18;
/// Space between the frame and anything outside.
const MARGIN: i32 = 12;

/// Writes the panels side by side into the file `path`.
///
/// # Errors
/// An error if the file cannot be written.
pub fn write(path: &Path, panels: &[Panel]) -> Result<(), Box<dyn Error>> {
    let root = SVGBackend::new(path, (SIZE.0 * panels.len() as u32, SIZE.1)).into_drawing_area();
    root.fill(&WHITE)?;
    for (panel, area) in panels.iter().zip(root.split_evenly((1, panels.len()))) {
        draw(panel, &root, &area).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    root.present().map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(())
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn draw(panel: &Panel, root: &Area<'_>, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let ((left, right), (low, high)) = (panel.x.ends, panel.y.ends);
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, (FONT, 19))
        .margin(MARGIN)
        .margin_right(NAMES)
        .x_label_area_size(54)
        .y_label_area_size(76)
        .build_cartesian_2d(
            (left..right).log_scale().with_key_points(panel.x.ticks.clone()),
            (low..high).log_scale().with_key_points(panel.y.ticks.clone()),
        )?;
    chart
        .configure_mesh()
        .x_desc(&panel.x.title)
        .y_desc(&panel.y.title)
        .x_labels(panel.x.ticks.len())
        .y_labels(panel.y.ticks.len())
        .x_label_formatter(&|x| plain(*x))
        .y_label_formatter(&|y| plain(*y))
        .label_style((FONT, 16))
        .axis_desc_style((FONT, 18))
        .bold_line_style(RGBColor(215, 215, 215))
        .light_line_style(TRANSPARENT)
        .draw()?;

    let mut names = Vec::new();
    for curve in &panel.curves {
        let colour = COLOURS[curve.colour % COLOURS.len()];
        let (width, mark) = if curve.hollow { (1, WHITE.filled()) } else { (2, colour.filled()) };
        chart.draw_series(LineSeries::new(curve.points.iter().copied(), colour.stroke_width(width)))?;
        chart.draw_series(curve.points.iter().map(|&point| Circle::new(point, 4, mark)))?;
        chart.draw_series(curve.points.iter().map(|&point| Circle::new(point, 4, colour.stroke_width(1))))?;
        if let Some(last) = curve.points.last().filter(|_| !curve.name.is_empty()) {
            let (x, y) = chart.backend_coord(last);
            names.push(Name { x: x + 10, y, text: &curve.name, colour });
        }
    }
    set_apart(&mut names, chart.backend_coord(&(left, low)).1);
    for Name { x, y, text, colour } in names {
        let style = (FONT, 17).into_font().color(&colour).pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(text, (x, y), style))?;
    }
    Ok(())
}

/// The name of a curve and its position.
struct Name<'a> {
    x: i32,
    y: i32,
    text: &'a str,
    colour: RGBColor,
}

/// Moves names down, and at the bottom up again, until none overlaps another.
fn set_apart(names: &mut [Name<'_>], bottom: i32) {
    names.sort_by_key(|name| name.y);
    let mut free = i32::MIN;
    for name in &mut *names {
        name.y = name.y.max(free);
        free = name.y + LINE;
    }
    let mut free = bottom;
    for name in names.iter_mut().rev() {
        name.y = name.y.min(free);
        free = name.y - LINE;
    }
}

/// A tick as text.
fn plain(value: f64) -> String {
    if value >= 1.0 {
        crate::grouped(value.round() as u64)
    } else {
        format!("{}", (value * 1e9).round() / 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(axis: &Axis) -> Vec<String> {
        axis.ticks.iter().map(|&tick| plain(tick)).collect()
    }

    #[test]
    fn an_axis_reaches_its_values() {
        let axis = Axis::within("N", &[10.0, 100.0, 1000.0, 10_000.0], [100.0, 316.0, 3162.0]);
        assert_eq!(
            (axis.ends, written(&axis)),
            ((100.0, 3162.0), vec!["100".to_owned(), "1,000".to_owned()])
        );
        let axis = Axis::covering("t", 2.0, 0.01, [0.021, 0.05]);
        assert_eq!((axis.ends, written(&axis).join(" ")), ((0.02, 0.08), "0.02 0.04 0.08".to_owned()));
    }

    #[test]
    fn names_do_not_overlap() {
        let mut names = [95, 10, 96, 12].map(|y| Name { x: 0, y, text: "", colour: BLACK });
        set_apart(&mut names, 100);
        assert_eq!(names.map(|name| name.y), [10, 28, 82, 100]);
    }
}
