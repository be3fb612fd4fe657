//! Page of a run in two dimensions.

use fdem_io::numbers::{brief, grouped};
use serde_json::{Value, json};

use crate::fields::field::Field;
use crate::fields::range::Range;
use crate::page::run::grains::{GrainPart, about as about_grains, sampling};
use crate::page::run::{RunPage, columns, finite, largest, of_elements, row, text, thinned, thinning};
use crate::picture::PictureError;
use crate::run::fragments::Fragments;
use crate::run::frame::Frame;
use crate::run::grains::drawing::elements_and_spheres;
use crate::run::names::Names;
use crate::run::pictures::{FrameView, Pictures};
use crate::run::plots::Plot;
use crate::run::unit::prefixed;

/// Maximum number of elements of a frame in a page: with more, a browser would run out of memory. Larger
/// meshes are shown by samples, [`Frame::sampled`].
pub const MOST_ELEMENTS: usize = 1_000_000;

/// Maximum number of triangles in the sample of a mesh with more than [`MOST_ELEMENTS`] elements: fine enough
/// for a screen, and about ten frames fit in a page.
pub const SAMPLE: usize = 250_000;

const SHOW: &str = include_str!("flat/show.html");
const HELP: &str = include_str!("flat/help.html");
const SCRIPTS: [&str; 3] =
    [include_str!("flat/frames.js"), include_str!("flat/view.js"), include_str!("flat/main.js")];
/// Columns of the table of frames before those with the largest values of fields.
const COLUMNS: [&str; 7] = ["frame", "step", "time (s)", "cracks (m)", "by tension", "by shear", "mixed"];

/// Contents of the page of a run.
///
/// # Example
/// ```
/// use fdem_results::{Field, Fragments, Frame, Names, Report};
///
/// let frames = [Frame::new(&fdem_simulation::Snapshot::default())?];
/// let report = Report {
///     title: "nothing <happens>",
///     facts: &[("elements", "0")],
///     plots: &[],
///     frames: &frames,
///     fragments: &Fragments::default(),
///     field: Field::MAX_PRINCIPAL,
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
    /// Frames in the order of time. If there are more than [`MOST_FRAMES`](crate::MOST_FRAMES), or more than
    /// 40 MB, the page has only some of them, the first and the last among them, and says so.
    pub frames: &'a [Frame],
    /// Fragments at the end. The page has a table of the largest ones of the bodies that count.
    pub fragments: &'a Fragments<2>,
    /// Field by which elements are initially coloured.
    pub field: Field,
    /// Names of bodies and materials. Bodies and materials without a name are shown as numbers.
    pub names: &'a Names,
}

impl Report<'_> {
    /// Returns the page as HTML.
    ///
    /// # Errors
    /// [`PictureError::TooMany`] for a frame with more than [`MOST_ELEMENTS`] elements, which
    /// [`Frame::sampled`] avoids; the errors of [`Pictures::png`].
    ///
    /// # Cost
    /// The page has about 15 bytes for each element and frame, at most 40 MB. It takes about 1 s to make.
    pub fn html(&self) -> Result<String, PictureError> {
        let found = self.frames.iter().map(|frame| frame.elements).max().unwrap_or(0);
        if found > MOST_ELEMENTS {
            return Err(PictureError::TooMany { what: "elements", found, most: MOST_ELEMENTS });
        }
        let whole = self.frames.iter().map(|frame| frame.whole).max().unwrap_or(0);
        let places = thinned(self.frames.len(), |place| {
            self.frames[place].deflated.len() + self.frames[place].grains.deflated.len()
        });
        let view = FrameView::of(self.frames);
        let fields = of_elements(self.field, self.frames.iter().map(|frame| &frame.scales));
        let ranges = fields.map(|field| (field, Range::of(self.frames, field))).collect();
        let preview = self.frames.last().map(|last| {
            let (field, range) = (self.field, Range::of(self.frames, self.field));
            Pictures { title: self.title, field, range, view }.png(last, None)
        });
        let (mut frames, mut rows) = (String::new(), String::new());
        for (k, &place) in places.iter().enumerate() {
            let frame = &self.frames[place];
            frames += &text(k, &frame.deflated);
            if !frame.grains.is_empty() {
                frames += &text(k, &frame.grains.deflated);
            }
            rows += &row(k, place, frame.step, frame.time, &[], frame.lengths, &frame.scales);
        }
        RunPage {
            title: self.title,
            counts: self.counts(whole, &view),
            facts: self.facts,
            plots: self.plots,
            names: self.names,
            field: self.field,
            ranges,
            numbered: &[],
            preview: preview.transpose()?,
            notes: thinning(self.frames.len(), &places)
                + &self.sampling()
                + &sampling(self.frames.iter().map(|frame| &frame.grains)),
            count: places.len(),
            columns: columns(&COLUMNS),
            rows,
            fragments: largest(self.fragments, self.names),
            meta: self.meta(&places, whole, &view),
            frames,
            grains: GrainPart::new(self.frames.iter().map(|frame| &frame.grains), self.field, |field| {
                Range::of(self.frames, field)
            }),
            show: SHOW,
            more: "",
            help: HELP,
            style: "",
            scripts: &SCRIPTS,
        }
        .html()
    }

    fn counts(&self, elements: usize, view: &FrameView) -> String {
        let Some(last) = self.frames.last() else { return "no frames".to_owned() };
        let mut text = format!("{}, {}", elements_and_spheres(elements, &last.grains), view.time(last.time));
        let cracks: f64 = last.lengths.iter().sum();
        if cracks > 0.0 {
            let (factor, unit) = prefixed("m", cracks);
            text = format!("{text}, {} {unit} of cracks", brief((cracks * factor * 100.0).round() / 100.0));
        }
        text
    }

    /// Returns a sentence that says that frames show a sample, and which files have all elements; empty if no
    /// frame shows a sample.
    fn sampling(&self) -> String {
        let Some(frame) =
            self.frames.iter().filter(|frame| frame.is_sample()).max_by_key(|frame| frame.elements)
        else {
            return String::new();
        };
        format!(
            "  <p class=\"hint help\" id=\"sample\">The mesh has {} elements. The view shows a sample of them: at most {} larger triangles, each with the values of one element. The files for ParaView have all elements.</p>\n",
            grouped(frame.whole as u64),
            grouped(frame.elements as u64)
        )
    }

    /// Returns the data for the scripts.
    fn meta(&self, places: &[usize], elements: usize, view: &FrameView) -> Value {
        let about = |&place: &usize| {
            let frame = &self.frames[place];
            let of_grains = (!frame.grains.is_empty()).then_some(frame.grains.size);
            let sizes: Vec<usize> = std::iter::once(frame.size).chain(of_grains).collect();
            json!({
                "step": frame.step,
                "time": finite(frame.time),
                "elements": frame.elements,
                "sample": frame.is_sample(),
                "cracks": frame.cracks,
                "holding": [frame.intact, frame.softening],
                "sizes": sizes,
                "grains": about_grains(&frame.grains),
                "bounds": frame.bounds,
                "scales": frame.scales.map(|scale| scale.ends),
                "usual": frame.scales.map(|scale| scale.usual),
                "broken": frame.lengths.into_iter().chain(frame.others).map(finite).collect::<Vec<_>>(),
            })
        };
        let (middle, half) = view.middle_and_half();
        let unit = half[0].max(half[1]);
        json!({
            "elements": elements,
            "measure": "m",
            "missing": "in the sample that this frame shows",
            "last": finite(self.frames.last().map_or(0.0, |frame| frame.time)),
            "view": { "middle": middle, "unit": unit, "half": half.map(|side| (side / unit).max(1e-6)) },
            "frames": places.iter().map(about).collect::<Vec<_>>(),
        })
    }
}
