//! Pages of runs, which play the frames and have the plots and the summary. [`flat`] has the parts in two
//! dimensions and [`space`] those in three; this file has the common parts.
//!
//! Like the page of a contact network ([`crate::page::network`]), they load nothing over the network. Their
//! content security policy allows only their own script and style. Texts from outside are escaped.

pub(crate) mod flat;
mod grains;
pub(crate) mod space;

use std::cell::Cell;
use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fdem_io::numbers::{brief, grouped};
use serde_json::{Value, json};

use crate::fields::colours::{NO_VALUE, NUMBERED};
use crate::fields::field::{Field, SCALES};
use crate::fields::quantity::{Ends, Quantity};
use crate::fields::range::{Range, Scale};
use crate::page::run::grains::{GrainPart, SCRIPTS as GRAIN_SCRIPTS};
use crate::page::{PageParts, STYLE, rows};
use crate::picture::PictureError;
use crate::picture::svg::escape;
use crate::run::fragments::Fragments;
use crate::run::names::Names;
use crate::run::pictures::{CRACKS, NARROWEST_OUTLINE, OUTLINE, OUTLINES};
use crate::run::plots::Plot;

/// Maximum number of frames in a page. If there are more, some are left out.
pub const MOST_FRAMES: usize = 121;

/// Maximum number of fragments in the table of the page.
const MOST_FRAGMENTS: usize = 20;

/// Maximum number of left-out frames that the page lists.
const MOST_NAMED: usize = 12;

/// Maximum size of all frames in the file, bytes.
const MOST_BYTES: usize = 40 << 20;

const PAGE: &str = include_str!("run/page.html");
const STYLE_OF_RUNS: &str = include_str!("run/run.css");
const SCRIPTS: [&str; 3] =
    [include_str!("run/frames.js"), include_str!("run/view.js"), include_str!("run/main.js")];

/// A page of a run.
struct RunPage<'a> {
    title: &'a str,
    /// The line below the title.
    counts: String,
    facts: &'a [(&'a str, &'a str)],
    plots: &'a [Plot],
    names: &'a Names,
    /// Field by which elements are initially coloured.
    field: Field,
    /// Fields and their ranges.
    ranges: Vec<(Field, Range)>,
    /// Further fields with separate numbers.
    numbered: &'a [&'static Quantity],
    /// A picture of the last frame as PNG, for browsers that cannot show the view.
    preview: Option<Vec<u8>>,
    /// The text below the view.
    notes: String,
    /// Number of frames in the page.
    count: usize,
    /// Names of the columns of the table of frames, and its rows.
    columns: Vec<String>,
    rows: String,
    /// The section with the largest fragments; empty without fragments.
    fragments: String,
    /// Data for the scripts, beside those that all pages have.
    meta: Value,
    /// The part with the spheres and walls; `None` for a run without any.
    grains: Option<GrainPart>,
    /// The script elements with the frames.
    frames: String,
    /// Differences between two and three dimensions: checkboxes and fieldsets of the controls, effects of
    /// keys, style and scripts.
    show: &'a str,
    more: &'a str,
    help: &'a str,
    style: &'a str,
    scripts: &'a [&'a str],
}

impl RunPage<'_> {
    fn html(self) -> Result<String, PictureError> {
        let controls = self.grains.as_ref().map_or("", |grains| grains.controls.as_str());
        let more = controls.to_owned() + self.more;
        let main = [("{{show}}", self.show), ("{{more}}", more.as_str()), ("{{help}}", self.help)]
            .into_iter()
            .fold(PAGE.to_owned(), |main, (name, part)| main.replace(name, part));
        let parts = PageParts {
            kind: "run",
            command: "fdem run",
            skip: ["summary", "Skip to the summary"],
            main: &main,
            data: "{{frames}}",
            style: format!("{STYLE}{STYLE_OF_RUNS}{}", self.style),
            scripts: &[
                &SCRIPTS[..],
                if self.grains.is_some() { &GRAIN_SCRIPTS[..] } else { &[] },
                self.scripts,
            ]
            .concat(),
        };
        let meta = self.meta();
        let frames = Cell::new(self.frames);
        parts.page(|name| {
            Ok(match name {
                "title" => escape(self.title),
                "counts" => escape(&self.counts),
                "picture" => picture(self.preview.as_deref(), self.title, &self.counts),
                "fields" => {
                    let fields = self.ranges.iter().map(|(field, _)| field.quantity());
                    options(self.field, fields.chain(self.numbered.iter().copied()))
                }
                "last" => self.count.saturating_sub(1).to_string(),
                "notes" => self.notes.clone(),
                "facts" => rows(self.facts),
                "plots" => figures(self.plots),
                "columns" => headings(self.columns.iter().map(String::as_str)),
                "rows" => self.rows.clone(),
                "fragments" => self.fragments.clone(),
                "meta" => meta.clone(),
                // The frames are by far the largest part. They occur once, so they are moved.
                "frames" => frames.take(),
                // The template has no other placeholders.
                _ => String::new(),
            })
        })
    }

    /// Returns the data for the scripts as JSON that is safe in a script element.
    fn meta(&self) -> String {
        let mut fields: Vec<Value> =
            self.ranges.iter().map(|&(field, range)| about_field(field, range)).collect();
        fields.extend(self.numbered.iter().map(|Quantity { key, name, .. }| {
            json!({ "key": key, "name": name, "unit": "", "signed": false, "scale": null, "range": [0, 1], "ramp": [] })
        }));
        let outlines = [1, 0].map(|kind| {
            let (colour, most) = OUTLINES[kind];
            json!({ "colour": colour, "most": most, "share": OUTLINE, "least": NARROWEST_OUTLINE })
        });
        let mut meta = json!({
            "title": self.title,
            "fields": fields,
            "numbered": NUMBERED,
            "none": NO_VALUE,
            "cracks": CRACKS.map(|(name, colour)| json!({ "name": name, "colour": colour })),
            "outlines": outlines,
            "bodies": self.names.bodies,
            "materials": self.names.materials,
            "spheres": self.grains.as_ref().map(|grains| &grains.meta),
        });
        if let (Some(meta), Value::Object(more)) = (meta.as_object_mut(), &self.meta) {
            meta.extend(more.clone());
        }
        // A script element ends at "</script", so no "<" may remain.
        meta.to_string().replace('<', "\\u003c")
    }
}

fn about_field(field: Field, Range { low, high }: Range) -> Value {
    json!({
        "key": field.key(),
        "name": field.name(),
        "unit": field.unit(),
        "signed": field.ends() == Some(Ends::Symmetric),
        "fixed": matches!(field.ends(), Some(Ends::Fixed(..))),
        "scale": field.scale(),
        "range": [low, high],
        "ramp": field.ramp(),
    })
}

/// Returns the fields of elements, in the order of menus: those of a liquid only if a frame has values
/// of them, or if they are the `selected` one. `scales`: those of each frame.
fn of_elements<'a>(
    selected: Field,
    scales: impl Iterator<Item = &'a [Scale; SCALES.len()]> + Clone,
) -> impl Iterator<Item = Field> {
    let has = move |field: Field| {
        let values = |scales: &[Scale; SCALES.len()]| field.scale().is_some_and(|k| scales[k] != Scale::NONE);
        field.quantity().liquid.is_none() || field == selected || scales.clone().any(values)
    };
    Field::ALL.into_iter().filter(move |&field| field.is_of_elements() && has(field))
}

/// Returns the picture for browsers that cannot show the view; empty if the page has none.
fn picture(preview: Option<&[u8]>, title: &str, counts: &str) -> String {
    preview.map_or_else(String::new, |png| {
        let (png, title, counts) = (STANDARD.encode(png), escape(title), escape(counts));
        format!("<img src=\"data:image/png;base64,{png}\" alt=\"The last frame of {title}: {counts}\">")
    })
}

fn options(selected: Field, quantities: impl Iterator<Item = &'static Quantity>) -> String {
    let mut options = String::new();
    for Quantity { key, name, .. } in quantities {
        let selected = if *key == selected.key() { " selected" } else { "" };
        // Writing to a string does not fail.
        let _ = write!(options, "<option value=\"{key}\"{selected}>{name}</option>");
    }
    options
}

fn headings<'a>(columns: impl IntoIterator<Item = &'a str>) -> String {
    columns.into_iter().map(|name| ["<th scope=\"col\">", name, "</th>"].concat()).collect()
}

/// Returns the names of the columns of the table of frames: these, and those with the largest values of
/// fields.
fn columns(first: &[&str]) -> Vec<String> {
    let largest = Field::ALL.into_iter().filter_map(Field::column);
    first.iter().copied().map(str::to_owned).chain(largest).collect()
}

/// Returns a sentence on the frames that are not in the page; empty if all are in it.
fn thinning(total: usize, places: &[usize]) -> String {
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
        "  <p class=\"hint help\" id=\"thinned\">{shown} of {} frames are in this page; {rest}.</p>\n",
        grouped(total as u64)
    )
}

/// Replaces numbers that JSON cannot represent by 0.
fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

/// Returns `count` places below `total`, evenly spaced, with the first and the last. One place is the last.
fn even(count: usize, total: usize) -> Vec<usize> {
    match count {
        0 => Vec::new(),
        1 => vec![total - 1],
        _ => (0..count).map(|k| k * (total - 1) / (count - 1)).collect(),
    }
}

/// Returns the indices of the frames for which the page has room, evenly spaced, with the first and the last.
/// If there is room for one only, it is the last.
fn thinned(total: usize, bytes: impl Fn(usize) -> usize) -> Vec<usize> {
    let mut count = total.min(MOST_FRAMES);
    loop {
        let places = even(count, total);
        // Base64 takes four characters for three bytes.
        let bytes: usize = places.iter().map(|&place| bytes(place).div_ceil(3) * 4).sum();
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

/// Returns the section with the largest fragments of the bodies that count; empty without fragments.
fn largest<const D: usize>(fragments: &Fragments<D>, names: &Names) -> String {
    let counted: Vec<_> = fragments.all().iter().filter(|fragment| fragment.counted).collect();
    if counted.is_empty() {
        return String::new();
    }
    let measure = if D == 2 { "area (m²)" } else { "volume (m³)" };
    let columns =
        ["fragment", "body", "elements", "mass (kg)", "share (%)", measure, "diameter (m)", "speed (m/s)"];
    let all: f64 = counted.iter().map(|fragment| fragment.mass).sum();
    let mut rows = String::new();
    for one in counted.iter().take(MOST_FRAGMENTS) {
        let body = names.bodies.get(one.body as usize).cloned().unwrap_or_else(|| one.body.to_string());
        let speed = one.velocity.iter().map(|x| x * x).sum::<f64>().sqrt();
        let numbers = [one.mass, 100.0 * one.mass / all, one.measure, one.diameter, speed];
        let cells = [one.number.to_string(), escape(&body), grouped(one.elements)];
        rows += "<tr>";
        for cell in cells.into_iter().chain(numbers.map(brief)) {
            rows += &["<td>", &cell, "</td>"].concat();
        }
        rows += "</tr>\n";
    }
    let text = match counted.len() {
        1 => "The bodies that can break are one fragment.".to_owned(),
        number if number <= MOST_FRAGMENTS => {
            format!("The {number} fragments at the end, the heaviest first.")
        }
        number => format!(
            "The {MOST_FRAGMENTS} heaviest of {} fragments at the end. The others are in <code>fragments.csv</code>.",
            grouped(number as u64)
        ),
    };
    format!(
        "<section aria-labelledby=\"fragments-heading\" id=\"fragments-table\">\n  <h2 id=\"fragments-heading\">Fragments</h2>\n  <p class=\"hint\">{text} The diameter is that of a {} of the same {}.</p>\n  <div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"fragments-heading\">\n    <table class=\"numbers\">\n      <thead><tr>{}</tr></thead>\n      <tbody>\n{rows}</tbody>\n    </table>\n  </div>\n</section>\n",
        if D == 2 { "disc" } else { "sphere" },
        if D == 2 { "area" } else { "volume" },
        headings(columns)
    )
}

/// Returns a part of frame `k` as a script element of the page.
fn text(k: usize, deflated: &[u8]) -> String {
    format!(
        "<script type=\"text/plain\" class=\"frame\" data-frame=\"{k}\">{}</script>\n",
        STANDARD.encode(deflated)
    )
}

/// Returns a row of the table of frames. Frames have the numbers of their files. `counts` come after the
/// number and the step, `numbers` after the time.
fn row(
    k: usize,
    place: usize,
    step: u64,
    time: f64,
    counts: &[u64],
    broken: [f64; 3],
    scales: &[Scale; SCALES.len()],
) -> String {
    let mut row = format!("<tr><td><button type=\"button\" data-frame=\"{k}\">{place}</button></td>");
    let [tension, shear, mixed] = broken;
    let numbers = [time, tension + shear + mixed, tension, shear, mixed];
    let shown = SCALES.iter().zip(scales).filter(|(field, _)| field.column().is_some());
    let values = shown.map(|(_, scale)| scale.ends[1]);
    let counts = std::iter::once(&step).chain(counts).map(|&count| grouped(count));
    for cell in counts.chain(numbers.into_iter().chain(values).map(brief)) {
        // Writing to a string does not fail.
        let _ = write!(row, "<td>{cell}</td>");
    }
    row + "</tr>\n"
}
