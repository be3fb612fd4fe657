//! A sheet to draw on, as SVG: as few elements and colours as the figures need.

use std::fmt::{Display, Write};

pub(crate) const INK: &str = "#1f2937";
pub(crate) const FAINT: &str = "#c3ccd6";
pub(crate) const PAPER: &str = "#ffffff";
pub(crate) const BODY: &str = "#e5eaf0";
/// The element or cell that searches.
pub(crate) const CENTRAL: &str = "#f59e0b";
/// The elements or cells that are searched.
pub(crate) const NEIGHBOUR: &str = "#60a5fa";
pub(crate) const COUPLE: &str = "#c81e3a";

/// Marks on a sheet, in pixels, y downwards.
#[derive(Clone, Debug, Default)]
pub(crate) struct Paper {
    marks: String,
}

impl Paper {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Adds marks as they are written.
    pub(crate) fn raw(&mut self, marks: impl Display) {
        writeln!(self.marks, "{marks}").expect("writing to a string");
    }

    pub(crate) fn rect(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], style: &str) {
        self.raw(format_args!(
            r#"<rect x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}" {style}/>"#
        ));
    }

    pub(crate) fn circle(&mut self, [x, y]: [f64; 2], radius: f64, style: &str) {
        self.raw(format_args!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius:.1}" {style}/>"#));
    }

    pub(crate) fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], style: &str) {
        self.raw(format_args!(r#"<path d="M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}" {style}/>"#));
    }

    /// Text around a point.
    pub(crate) fn text(&mut self, [x, y]: [f64; 2], size: f64, anchor: &str, text: impl Display) {
        let y = y + 0.35 * size;
        self.raw(format_args!(
            r#"<text x="{x:.1}" y="{y:.1}" font-size="{size}" text-anchor="{anchor}">{text}</text>"#
        ));
    }

    /// The marks of another sheet, moved.
    pub(crate) fn place(&mut self, other: &Self, [x, y]: [f64; 2]) {
        self.raw(format_args!("<g transform=\"translate({x:.1} {y:.1})\">\n{}</g>", other.marks));
    }

    /// The whole file. `title` is the text for screen readers.
    pub(crate) fn svg(&self, [width, height]: [f64; 2], title: &str, style: &str) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" \
             role=\"img\" font-family=\"Inter, 'DejaVu Sans', Helvetica, Arial, sans-serif\" fill=\"{INK}\">\n<title>{title}</title>\n{style}\
             <rect width=\"100%\" height=\"100%\" rx=\"8\" fill=\"{PAPER}\"/>\n{}</svg>\n",
            self.marks
        )
    }
}
