//! Report of a run as an HTML page in one file, which plays the frames and has the plots and the summary.
//!
//! Like the page of a contact network ([`crate::report`]), it loads nothing over the network. Its content security policy allows only its own script and
//! style. Texts from outside are escaped.

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
use crate::results::names::Names;
use crate::results::pictures::{CRACKS, FrameView, NARROWEST_OUTLINE, OUTLINE, OUTLINES, Pictures};
use crate::results::plots::Plot;
use crate::results::unit::prefixed;

/// Maximum number of frames in a page. If there are more, some are left out.
pub const MOST_FRAMES: usize = 121;

/// Maximum number of left-out frames that the page lists.
const MOST_NAMED: usize = 12;

/// Maximum number of elements of a frame in a page: with more, a browser would run out of memory. Larger meshes are shown by samples, [`Frame::sampled`].
pub const MOST_ELEMENTS: usize = 1_000_000;

/// Maximum number of triangles in the sample of a mesh with more than [`MOST_ELEMENTS`] elements: fine enough for a screen, and about ten frames fit in a
/// page.
pub const SAMPLE: usize = 250_000;

/// Maximum size of all frames in the file, bytes.
const MOST_BYTES: usize = 40 << 20;

const PAGE: &str = include_str!("report/page.html");
const STYLE_OF_RUNS: &str = include_str!("report/run.css");
const SCRIPTS: [&str; 3] =
    [include_str!("report/frames.js"), include_str!("report/view.js"), include_str!("report/main.js")];

/// Contents of the page of a run.
///
/// # Example
/// ```
/// use fdem::results::{Field, Frame, Names, Report};
///
/// let frames = [Frame::new(&fdem_simulation::Snapshot::default())?];
/// let report = Report {
///     title: "nothing <happens>",
///     facts: &[("elements", "0")],
///     plots: &[],
///     frames: &frames,
///     field: Field::MaxPrincipal,
///     names: &Names::default(),
/// };
/// assert!(report.html()?.contains("nothing &lt;happens&gt;"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// Heading.
    pub title: &'a str,
    /// Rows of the summary: name and text. A row without a name continues the row before.
    pub facts: &'a [(&'a str, &'a str)],
    /// Plots, in the order in which they are shown.
    pub plots: &'a [Plot],
    /// Frames in the order of time. If there are more than [`MOST_FRAMES`], or more than 40 MB, the page has only some of them, the first and the last among
    /// them, and says so.
    pub frames: &'a [Frame],
    /// Field by which elements are initially coloured.
    pub field: Field,
    /// Names of bodies and materials. Bodies and materials without a name are shown as numbers.
    pub names: &'a Names,
}

impl Report<'_> {
    /// Returns the page as HTML.
    ///
    /// # Errors
    /// [`PictureError::TooMany`] for a frame with more than [`MOST_ELEMENTS`] elements, which [`Frame::sampled`] avoids; the errors of [`Pictures::png`].
    ///
    /// # Cost
    /// The page has about 15 bytes for each element and frame, at most 40 MB. It takes about 1 s to make.
    pub fn html(&self) -> Result<String, PictureError> {
        let found = self.frames.iter().map(|frame| frame.elements).max().unwrap_or(0);
        if found > MOST_ELEMENTS {
            return Err(PictureError::TooMany { what: "elements", found, most: MOST_ELEMENTS });
        }
        let whole = self.frames.iter().map(|frame| frame.whole).max().unwrap_or(0);
        let places = thinned(self.frames);
        let frames: Vec<&Frame> = places.iter().map(|&place| &self.frames[place]).collect();
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
                "counts" => escape(&self.counts(whole, &view)),
                "preview" => preview.clone(),
                "fields" => self.options(),
                "last" => frames.len().saturating_sub(1).to_string(),
                "thinned" => self.thinning(&places),
                "sample" => self.sampling(),
                "facts" => rows(self.facts),
                "plots" => figures(self.plots),
                "rows" => table(&frames, &places),
                "version" => env!("CARGO_PKG_VERSION").to_owned(),
                "meta" => self.meta(&frames, whole, &view),
                "frames" => frames.iter().map(|frame| text(frame)).collect(),
                "script" => script.clone(),
                // The template has no other placeholders.
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

    /// Returns a sentence on the frames that are not in the page; empty if all are in it.
    fn thinning(&self, places: &[usize]) -> String {
        let total = self.frames.len();
        let left_out: Vec<String> = (0..total)
            .filter(|place| places.binary_search(place).is_err())
            .map(|place| place.to_string())
            .collect();
        let rest = match &left_out[..] {
            [] => return String::new(),
            [one] => format!("frame {one} is left out"),
            [first @ .., last] if left_out.len() <= MOST_NAMED => {
                format!("frames {} and {last} are left out", first.join(", "))
            }
            _ => "the others are in the folder of frames".to_owned(),
        };
        let shown = places.len();
        format!(
            "<p class=\"hint help\" id=\"thinned\">{shown} of {} frames are in this page; {rest}.</p>",
            grouped(total as u64)
        )
    }

    /// Returns a sentence that says that frames show a sample, and which files have all elements; empty if no frame shows a sample.
    fn sampling(&self) -> String {
        let Some(frame) =
            self.frames.iter().filter(|frame| frame.is_sample()).max_by_key(|frame| frame.elements)
        else {
            return String::new();
        };
        format!(
            "<p class=\"hint help\" id=\"sample\">The mesh has {} elements. The view shows a sample of them: at most {} larger triangles, each with the values of one element. The files for ParaView have all elements.</p>",
            grouped(frame.whole as u64),
            grouped(frame.elements as u64)
        )
    }

    /// Returns the data for the scripts as JSON that is safe in a script element.
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
                "elements": frame.elements,
                "sample": frame.is_sample(),
                "cracks": frame.cracks,
                "size": frame.size,
                "bounds": frame.bounds,
                "scales": frame.scales.map(|scale| scale.ends),
                "usual": frame.scales.map(|scale| scale.usual),
                "lengths": frame.lengths.map(finite),
            })
        };
        let outlines = [1, 0].map(|kind| {
            let (colour, most) = OUTLINES[kind];
            json!({ "colour": colour, "most": most, "share": OUTLINE, "least": NARROWEST_OUTLINE })
        });
        let (middle, half) = view.middle_and_half();
        let unit = half[0].max(half[1]);
        let meta = json!({
            "title": self.title,
            "elements": elements,
            "fields": fields,
            "numbered": NUMBERED,
            "none": NO_VALUE,
            "cracks": CRACKS.map(|(name, colour)| json!({ "name": name, "colour": colour })),
            "outlines": outlines,
            "bodies": self.names.bodies,
            "materials": self.names.materials,
            "last": finite(self.frames.last().map_or(0.0, |frame| frame.time)),
            "view": { "middle": middle, "unit": unit, "half": half.map(|side| (side / unit).max(1e-6)) },
            "frames": frames.iter().map(about).collect::<Vec<_>>(),
        });
        // A script element ends at "</script", so no "<" may remain.
        meta.to_string().replace('<', "\\u003c")
    }
}

/// Replaces numbers that JSON cannot represent by 0.
fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

/// Returns the indices of the frames for which the page has room, evenly spaced, with the first and the last. If there is room for one only, it is the last.
fn thinned(frames: &[Frame]) -> Vec<usize> {
    let mut count = frames.len().min(MOST_FRAMES);
    loop {
        let places: Vec<usize> = match count {
            0 => Vec::new(),
            1 => vec![frames.len() - 1],
            _ => (0..count).map(|k| k * (frames.len() - 1) / (count - 1)).collect(),
        };
        // Base64 takes four characters for three bytes.
        let bytes: usize = places.iter().map(|&place| frames[place].deflated.len().div_ceil(3) * 4).sum();
        if bytes <= MOST_BYTES || count <= 1 {
            return places;
        }
        count = (count * MOST_BYTES / bytes).clamp(1, count - 1);
    }
}

/// Returns the plots as HTML.
fn figures(plots: &[Plot]) -> String {
    let mut figures = String::new();
    for plot in plots {
        // Writing to a string does not fail.
        let _ = writeln!(figures, "<figure>{}</figure>", plot.svg);
    }
    figures
}

/// Returns a frame as a script element of the page.
fn text(frame: &Frame) -> String {
    format!("<script type=\"text/plain\" class=\"frame\">{}</script>\n", STANDARD.encode(&frame.deflated))
}

/// Returns the rows of the table of frames. Frames have the numbers of their files.
fn table(frames: &[&Frame], places: &[usize]) -> String {
    let largest = |frame: &Frame, field: Field| brief(frame.scales[field.scale().unwrap_or(0)].ends[1]);
    let mut rows = String::new();
    for (k, (frame, place)) in frames.iter().zip(places).enumerate() {
        let [tension, shear, mixed] = frame.lengths;
        // Writing to a string does not fail.
        let _ = write!(rows, "<tr><td><button type=\"button\" data-frame=\"{k}\">{place}</button></td>");
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
