//! A page for a browser: the frames of a run to play, its plots and its summary, all in one file.
//!
//! It is made as the page of a contact network is ([`crate::report`]): it asks nothing of the network, its content security policy forbids all scripts
//! and styles but its own, and texts from outside are escaped besides.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

use crate::numbers::{brief, grouped};
use crate::picture::PictureError;
use crate::picture::svg::escape;
use crate::report::{SHARED, STYLE, filled, hash, rows};
use crate::results::field::{Field, NO_VALUE, NUMBERED, Range};
use crate::results::frame::Frame;
use crate::results::pictures::{CRACKS, FrameView, Pictures};
use crate::results::plots::Plot;
use crate::results::unit::prefixed;

/// Of more frames a part is shown.
pub const MOST_FRAMES: usize = 60;

/// Of more elements a browser would run out of memory.
const MOST_ELEMENTS: usize = 1_000_000;

/// What frames may take in the file, in bytes.
const MOST_BYTES: usize = 40 << 20;

const PAGE: &str = include_str!("report/page.html");
const STYLE_OF_RUNS: &str = include_str!("report/run.css");
const SCRIPTS: [&str; 3] =
    [include_str!("report/frames.js"), include_str!("report/view.js"), include_str!("report/main.js")];

/// What the page of a run is made of.
///
/// # Example
/// ```
/// use fdem::results::{Field, Frame, Report};
///
/// let frames = [Frame::new(&fdem_simulation::Snapshot::default())?];
/// let report = Report {
///     title: "nothing <happens>",
///     facts: &[("elements", "0")],
///     plots: &[],
///     frames: &frames,
///     field: Field::MaxPrincipal,
///     materials: &[],
/// };
/// assert!(report.html()?.contains("nothing &lt;happens&gt;"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// Heading.
    pub title: &'a str,
    /// The rows of the summary, a name and what it says; rows without a name go on with the one before.
    pub facts: &'a [(&'a str, &'a str)],
    /// Shown one after the other.
    pub plots: &'a [Plot],
    /// In the order of time. Of more than [`MOST_FRAMES`], or 40 MB, only some are in the page, the first and the last among them, and the page says so.
    pub frames: &'a [Frame],
    /// What elements are coloured by at first.
    pub field: Field,
    /// Names of the materials, by their numbers; others are shown as numbers.
    pub materials: &'a [&'a str],
}

impl Report<'_> {
    /// The page.
    ///
    /// # Errors
    /// [`PictureError::TooMany`] for more than a million elements; those of [`Pictures::png`].
    ///
    /// # Cost
    /// For each frame some 15 bytes of an element, 40 MB at the most; about 1 s.
    pub fn html(&self) -> Result<String, PictureError> {
        let found = self.frames.iter().map(|frame| frame.elements).max().unwrap_or(0);
        if found > MOST_ELEMENTS {
            return Err(PictureError::TooMany { what: "elements", found, most: MOST_ELEMENTS });
        }
        let frames = thinned(self.frames);
        let view = FrameView::of(self.frames);
        let script = format!("(() => {{\n\"use strict\";\n{SHARED}\n{}\n}})();", SCRIPTS.concat());
        let style = format!("{STYLE}{STYLE_OF_RUNS}");
        let preview = match self.frames.last() {
            Some(last) => {
                let (field, range) = (self.field, Range::of(self.frames, self.field));
                STANDARD.encode(Pictures { title: self.title, field, range, view }.png(last, None)?)
            }
            None => String::new(),
        };
        filled(PAGE, |name| {
            Ok(match name {
                "policy" => format!(
                    "default-src 'none'; script-src '{}'; style-src '{}'; img-src data:; base-uri 'none'; form-action 'none'",
                    hash(&script),
                    hash(&style)
                ),
                "style" => style.clone(),
                "title" => escape(self.title),
                "counts" => escape(&self.counts(found, &view)),
                "preview" => preview.clone(),
                "fields" => self.options(),
                "last" => frames.len().saturating_sub(1).to_string(),
                "thinned" => self.thinning(frames.len()),
                "facts" => rows(self.facts),
                "plots" => figures(self.plots),
                "rows" => table(&frames),
                "version" => env!("CARGO_PKG_VERSION").to_owned(),
                "meta" => self.meta(&frames, found, &view),
                "frames" => frames.iter().map(|frame| text(frame)).collect(),
                "script" => script.clone(),
                // The page has no other places.
                _ => String::new(),
            })
        })
    }

    fn counts(&self, elements: usize, view: &FrameView) -> String {
        let Some(last) = self.frames.last() else { return "no frames".to_owned() };
        let mut text = format!("{} elements, {}", grouped(elements as u64), view.time(last.time));
        let cracks: f64 = last.lengths.iter().sum();
        if cracks > 0.0 {
            let (factor, unit) = prefixed("m", cracks);
            text = format!("{text}, {} {unit} of cracks", brief((cracks * factor * 100.0).round() / 100.0));
        }
        text
    }

    fn options(&self) -> String {
        let option = |field: &Field| {
            let selected = if *field == self.field { " selected" } else { "" };
            format!("<option value=\"{}\"{selected}>{}</option>", field.key(), field.name())
        };
        Field::ALL.iter().map(option).collect()
    }

    fn thinning(&self, shown: usize) -> String {
        if shown == self.frames.len() {
            return String::new();
        }
        format!("{shown} of {} frames are in this page.", grouped(self.frames.len() as u64))
    }

    /// What the scripts have to know, safe in a script element.
    fn meta(&self, frames: &[&Frame], elements: usize, view: &FrameView) -> String {
        let fields = Field::ALL.map(|field| {
            let Range { low, high } = Range::of(self.frames, field);
            json!({
                "key": field.key(),
                "name": field.name(),
                "unit": field.unit(),
                "signed": field.signed(),
                "scale": field.scale(),
                "range": [low, high],
                "ramp": field.ramp(),
            })
        });
        let about = |frame: &&Frame| {
            json!({
                "step": frame.step,
                "time": finite(frame.time),
                "cracks": frame.cracks,
                "size": frame.size,
                "bounds": frame.bounds,
                "scales": frame.scales.map(|scale| scale.ends),
                "usual": frame.scales.map(|scale| scale.usual),
                "lengths": frame.lengths.map(finite),
            })
        };
        let (middle, half) = view.middle_and_half();
        let unit = half[0].max(half[1]);
        let meta = json!({
            "title": self.title,
            "elements": elements,
            "fields": fields,
            "numbered": NUMBERED,
            "none": NO_VALUE,
            "cracks": CRACKS.map(|(name, colour)| json!({ "name": name, "colour": colour })),
            "materials": self.materials,
            "last": finite(self.frames.last().map_or(0.0, |frame| frame.time)),
            "view": { "middle": middle, "unit": unit, "half": half.map(|side| (side / unit).max(1e-6)) },
            "frames": frames.iter().map(about).collect::<Vec<_>>(),
        });
        // A text in a script element ends at "</script": no "<" is left in it.
        meta.to_string().replace('<', "\\u003c")
    }
}

/// JSON has no others.
fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

/// As many frames as the page has room for, evenly: the first and the last are among them.
fn thinned(frames: &[Frame]) -> Vec<&Frame> {
    let mut count = frames.len().min(MOST_FRAMES);
    loop {
        let shown: Vec<&Frame> = match count {
            0 => Vec::new(),
            1 => frames.last().into_iter().collect(),
            _ => (0..count).map(|k| &frames[k * (frames.len() - 1) / (count - 1)]).collect(),
        };
        // Four characters for three bytes.
        let bytes: usize = shown.iter().map(|frame| frame.deflated.len().div_ceil(3) * 4).sum();
        if bytes <= MOST_BYTES || count <= 1 {
            return shown;
        }
        count = (count * MOST_BYTES / bytes).clamp(1, count - 1);
    }
}

/// Plots one after the other.
fn figures(plots: &[Plot]) -> String {
    let mut figures = String::new();
    for plot in plots {
        // Writing to a string does not fail.
        let _ = writeln!(figures, "<figure>{}</figure>", plot.svg);
    }
    figures
}

/// A frame as an element of the page.
fn text(frame: &Frame) -> String {
    format!("<script type=\"text/plain\" class=\"frame\">{}</script>\n", STANDARD.encode(&frame.deflated))
}

/// The rows of the table of frames.
fn table(frames: &[&Frame]) -> String {
    let largest = |frame: &Frame, field: Field| brief(frame.scales[field.scale().unwrap_or(0)].ends[1]);
    let mut rows = String::new();
    for (k, frame) in frames.iter().enumerate() {
        let [tension, shear, mixed] = frame.lengths;
        // Writing to a string does not fail.
        let _ = write!(rows, "<tr><td><button type=\"button\" data-frame=\"{k}\">{}</button></td>", k + 1);
        let _ = write!(rows, "<td>{}</td>", grouped(frame.step));
        for number in [frame.time, tension + shear + mixed, tension, shear, mixed] {
            let _ = write!(rows, "<td>{}</td>", brief(number));
        }
        for field in [Field::MaxPrincipal, Field::VonMises, Field::Velocity] {
            let _ = write!(rows, "<td>{}</td>", largest(frame, field));
        }
        rows.push_str("</tr>\n");
    }
    rows
}
