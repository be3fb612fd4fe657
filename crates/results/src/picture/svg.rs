//! Writer of SVG text.

use std::fmt::Write;

use crate::picture::colour::{Rgb, hex};

/// Colour of main texts and lines.
pub(crate) const INK: &str = "#1f2933";
/// Colour of secondary texts and lines.
pub(crate) const PALE: &str = "#64707d";

/// Part of a text that is placed at its point.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// An SVG drawing to which shapes are appended.
pub(crate) struct Svg {
    text: String,
}

impl Svg {
    /// Creates an empty drawing. Screen readers read `name` and `description`.
    pub(crate) fn new(width: f64, height: f64, name: &str, description: &str) -> Self {
        let mut svg = Self { text: String::new() };
        svg.put(format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.1} {height:.1}" width="{width:.1}" height="{height:.1}" role="img" font-family="DejaVu Sans, Verdana, sans-serif">"#
        ));
        svg.put(format_args!("<title>{}</title>", escape(name)));
        svg.put(format_args!("<desc>{}</desc>", escape(description)));
        svg
    }

    /// Appends a line of SVG.
    pub(crate) fn put(&mut self, arguments: std::fmt::Arguments<'_>) {
        // Writing to a string does not fail.
        let _ = self.text.write_fmt(arguments);
        self.text.push('\n');
    }

    pub(crate) fn background(&mut self) {
        self.put(format_args!(r#"<rect class="paper" width="100%" height="100%" fill="white"/>"#));
    }

    pub(crate) fn label(&mut self, at: [f64; 2], size: f64, anchor: Anchor, colour: &str, text: &str) {
        self.styled(at, size, anchor, colour, "", text);
    }

    pub(crate) fn bold(&mut self, at: [f64; 2], size: f64, text: &str) {
        self.styled(at, size, Anchor::Start, INK, r#" font-weight="bold""#, text);
    }

    fn styled(&mut self, [x, y]: [f64; 2], size: f64, anchor: Anchor, colour: &str, style: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => r#" text-anchor="middle""#,
            Anchor::End => r#" text-anchor="end""#,
        };
        let class = if colour == INK { "ink" } else { "pale" };
        self.put(format_args!(
            r#"<text class="{class}" x="{x:.1}" y="{y:.1}" font-size="{size}"{anchor}{style} fill="{colour}">{}</text>"#,
            escape(text)
        ));
    }

    pub(crate) fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], width: f64, colour: &str) {
        let class = if colour == INK { "ink-line" } else { "pale-line" };
        self.put(format_args!(
            r#"<line class="{class}" x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}" stroke="{colour}" stroke-width="{width}"/>"#
        ));
    }

    pub(crate) fn rect(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], fill: Rgb) {
        self.put(format_args!(
            r#"<rect x="{x:.2}" y="{y:.2}" width="{width:.2}" height="{height:.2}" fill="{}"/>"#,
            hex(fill)
        ));
    }

    /// Appends an image as an embedded PNG file.
    pub(crate) fn image(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], png: &[u8]) {
        use base64::Engine;
        let data = base64::engine::general_purpose::STANDARD.encode(png);
        self.put(format_args!(
            r#"<image x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}" preserveAspectRatio="none" href="data:image/png;base64,{data}"/>"#
        ));
    }

    pub(crate) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// Escapes a text for XML and HTML, inside or outside of quotes. Characters that are invalid in XML become
/// U+FFFD.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => escaped.push('\u{fffd}'),
            c if c.is_control() => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Shortens a text to `most` characters: longer texts keep their start and their end.
pub(crate) fn shortened(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    let start: String = text.chars().take(most / 3).collect();
    let end: String = text.chars().skip(count - (most - most / 3 - 1)).collect();
    format!("{start}…{end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_end_a_text_or_an_attribute() {
        assert_eq!(escape("<img onerror='\"&'>"), "&lt;img onerror=&#39;&quot;&amp;&#39;&gt;");
        assert_eq!(escape("a\u{0}b\u{1b}"), "a\u{fffd}b\u{fffd}");
    }

    #[test]
    fn long_names_keep_both_ends() {
        assert_eq!(shortened("packing.csv", 20), "packing.csv");
        let short = shortened("a/very/long/folder/name/packing.csv", 18);
        assert_eq!(short, "a/very…packing.csv");
        assert_eq!(short.chars().count(), 18);
    }
}
