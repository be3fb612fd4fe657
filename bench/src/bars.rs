//! Draws horizontal bars over a logarithmic axis as an SVG file with real text.

use std::error::Error;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::picture::COLOURS;
use crate::significant;

/// A bar and its labels.
#[derive(Clone, Debug)]
pub struct Bar {
    /// The name, on its left.
    pub name: String,
    /// Its length, positive; also written on its right.
    pub value: f64,
    /// A remark after the value.
    pub remark: String,
    /// Whether it has the first of [`COLOURS`] instead of grey.
    pub bold: bool,
}

/// One diagram of a picture.
#[derive(Clone, Debug)]
pub struct Bars {
    /// The title above the diagram.
    pub title: String,
    /// The bars from top to bottom.
    pub bars: Vec<Bar>,
}

const FONT: &str = "sans-serif";
/// Height of a bar with the space below it.
const LINE: i32 = 24;
/// Height of the title, and of the axis.
const TITLE: i32 = 40;
const AXIS: i32 = 30;
/// Widths of the names, of a full bar, and of the labels on its right.
const NAMES: i32 = 124;
const LENGTH: i32 = 230;
const REMARK: i32 = 116;
/// Number of diagrams side by side.
const COLUMNS: usize = 2;

/// Writes the diagrams, two side by side, into the file `path`; all have the same scale.
///
/// # Errors
/// An error if the file cannot be written.
pub fn write(path: &Path, diagrams: &[Bars]) -> Result<(), Box<dyn Error>> {
    let lines = diagrams.iter().map(lines).max().unwrap_or(0);
    let (width, height) = (NAMES + LENGTH + REMARK, TITLE + lines * LINE + AXIS);
    let columns = diagrams.len().clamp(1, COLUMNS);
    let rows = diagrams.len().div_ceil(columns).max(1);
    let size = (width as u32 * columns as u32, height as u32 * rows as u32);
    let values = || diagrams.iter().flat_map(|diagram| &diagram.bars).map(|bar| bar.value.log10());
    let low = values().fold(f64::INFINITY, f64::min).floor();
    let high = values().fold(low + 1.0, f64::max).ceil();

    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    for (diagram, area) in diagrams.iter().zip(root.split_evenly((rows, columns))) {
        draw(diagram, (low, high), &area).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    root.present().map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(())
}

fn lines(diagram: &Bars) -> i32 {
    i32::try_from(diagram.bars.len()).unwrap_or(i32::MAX / (2 * LINE))
}

fn draw(
    diagram: &Bars,
    (low, high): (f64, f64),
    area: &DrawingArea<SVGBackend<'_>, Shift>,
) -> Result<(), Box<dyn Error>> {
    let style = |size: i32, horizontal: HPos| {
        (FONT, size).into_font().color(&BLACK).pos(Pos::new(horizontal, VPos::Center))
    };
    let across = |power: f64| NAMES + (f64::from(LENGTH) * (power - low) / (high - low)).round() as i32;
    let bottom = TITLE + lines(diagram) * LINE;
    area.draw(&Text::new(diagram.title.clone(), (NAMES, TITLE / 2), style(16, HPos::Left)))?;
    for power in low as i32..=high as i32 {
        let x = across(f64::from(power));
        let line = vec![(x, TITLE - 4), (x, bottom)];
        area.draw(&PathElement::new(line, RGBColor(215, 215, 215)))?;
        let tick = significant(10_f64.powi(power)).trim_end_matches(".00").to_owned();
        area.draw(&Text::new(tick, (x, bottom + 12), style(13, HPos::Center)))?;
    }
    for (top, bar) in (TITLE..).step_by(LINE as usize).zip(&diagram.bars) {
        let middle = top + LINE / 2 - 2;
        let end = across(bar.value.log10());
        let colour = if bar.bold { COLOURS[0] } else { RGBColor(160, 160, 160) };
        area.draw(&Rectangle::new([(NAMES, top + 1), (end, top + LINE - 5)], colour.filled()))?;
        area.draw(&Text::new(bar.name.clone(), (NAMES - 8, middle), style(14, HPos::Right)))?;
        let value = format!("{} {}", significant(bar.value), bar.remark);
        area.draw(&Text::new(value, (end + 6, middle), style(13, HPos::Left)))?;
    }
    Ok(())
}
