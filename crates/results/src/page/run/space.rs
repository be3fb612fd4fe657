//! Page of a run in three dimensions.

use fdem_io::numbers::{brief, grouped};
use serde_json::{Value, json};

use crate::fields::field::Field;
use crate::fields::place::Place;
use crate::fields::quantity::Quantity;
use crate::fields::range::Range;
use crate::fields::table::QUANTITIES;
use crate::page::run::grains::{GrainPart, about as about_grains, sampling};
use crate::page::run::{
    MOST_BYTES, RunPage, columns, even, finite, largest, of_elements, row, text, thinned, thinning,
};
use crate::picture::PictureError;
use crate::run::fragments::Fragments;
use crate::run::grains::drawing::elements_and_spheres;
use crate::run::names::Names;
use crate::run::pictures::{extent, time_text};
use crate::run::plots::Plot;
use crate::space::{MOST_INSIDE, SpaceFrame};

/// Maximum number of elements at the surface of a frame in a page: with more, a browser would be too slow.
const MOST_AT_SURFACE: usize = 1_000_000;

/// Maximum number of elements inside of all frames in a page together. If there are more, only some frames
/// have them.
const MOST_INSIDE_OF_ALL: usize = 600_000;

const SHOW: &str = include_str!("space/show.html");
const MORE: &str = include_str!("space/more.html");
const HELP: &str = include_str!("space/help.html");
const STYLE: &str = include_str!("space/space.css");
const SCRIPTS: [&str; 4] = [
    include_str!("space/frames.js"),
    include_str!("space/section.js"),
    include_str!("space/view.js"),
    include_str!("space/main.js"),
];
/// Columns of the table of frames before those with the largest values of fields.
const COLUMNS: [&str; 8] =
    ["frame", "step", "fragments", "time (s)", "cracks (m²)", "by tension", "by shear", "mixed"];

/// Contents of the page of a run in three dimensions.
///
/// # Example
/// ```
/// use fdem_results::{Field, Fragments, Names, Shell, SpaceFrame, SpaceReport};
///
/// let frames = [SpaceFrame::new(&fdem_simulation::Snapshot::default(), &Shell::default())?];
/// let report = SpaceReport {
///     title: "nothing <happens>",
///     facts: &[("elements", "0")],
///     plots: &[],
///     frames: &frames,
///     fragments: &Fragments::default(),
///     field: Field::MAX_PRINCIPAL,
///     names: &Names::default(),
/// };
/// assert!(report.html(None)?.contains("nothing &lt;happens&gt;"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SpaceReport<'a> {
    /// Heading.
    pub title: &'a str,
    /// Rows of the summary: name and text. A row without a name continues the row before.
    pub facts: &'a [(&'a str, &'a str)],
    /// Plots, in the order in which they are shown.
    pub plots: &'a [Plot],
    /// Frames in the order of time. If there are more than [`crate::MOST_FRAMES`], or more than 40 MB, the
    /// page has only some of them, the first and the last among them, and says so. If they have more than
    /// 600,000 elements inside together, only some frames have those, and the page says so, too.
    pub frames: &'a [SpaceFrame],
    /// Fragments at the end. The page has a table of the largest ones of the bodies that count.
    pub fragments: &'a Fragments<3>,
    /// Field by which elements are initially coloured.
    pub field: Field,
    /// Names of bodies and materials. Bodies and materials without a name are shown as numbers.
    pub names: &'a Names,
}

/// The frames that are in a page.
struct Kept {
    /// Places of the frames among all frames.
    places: Vec<usize>,
    /// Which of them have the elements inside, by their places among these.
    solid: Vec<usize>,
}

impl SpaceReport<'_> {
    /// Returns the page as HTML. `preview` is a picture of the last frame as PNG, for browsers that cannot
    /// show the view.
    ///
    /// # Errors
    /// [`PictureError::TooMany`] for a frame with more than 1,000,000 elements at the surface.
    ///
    /// # Cost
    /// The page has about 40 bytes for each element and frame that it shows, at most 40 MB.
    pub fn html(&self, preview: Option<&[u8]>) -> Result<String, PictureError> {
        let found = self.frames.iter().map(|frame| frame.surface).max().unwrap_or(0);
        if found > MOST_AT_SURFACE {
            return Err(PictureError::TooMany {
                what: "elements at the surface",
                found,
                most: MOST_AT_SURFACE,
            });
        }
        let kept = self.kept();
        let fields = of_elements(self.field, self.frames.iter().map(|frame| &frame.scales));
        let is_fragment = |row: &&Quantity| row.place == Place::Element && row.key == "fragment";
        let fragment: Vec<&Quantity> = QUANTITIES.iter().filter(is_fragment).collect();
        let (mut frames, mut rows) = (String::new(), String::new());
        for (k, &place) in kept.places.iter().enumerate() {
            let frame = &self.frames[place];
            frames += &text(k, &frame.deflated[0]);
            if kept.solid.contains(&k) {
                frames += &text(k, &frame.deflated[1]);
            }
            if !frame.grains.is_empty() {
                frames += &text(k, &frame.grains.deflated);
            }
            let fragments = [frame.fragments as u64];
            rows += &row(k, place, frame.step, frame.time, &fragments, frame.areas, &frame.scales);
        }
        RunPage {
            title: self.title,
            counts: self.counts(),
            facts: self.facts,
            plots: self.plots,
            names: self.names,
            field: self.field,
            ranges: fields.map(|field| (field, Range::of_space(self.frames, field))).collect(),
            numbered: &fragment,
            preview: preview.map(<[u8]>::to_vec),
            notes: thinning(self.frames.len(), &kept.places)
                + &self.opening(&kept)
                + &sampling(self.frames.iter().map(|frame| &frame.grains)),
            count: kept.places.len(),
            columns: columns(&COLUMNS),
            rows,
            fragments: largest(self.fragments, self.names),
            meta: self.meta(&kept),
            frames,
            grains: GrainPart::new(self.frames.iter().map(|frame| &frame.grains), self.field, |field| {
                Range::of_space(self.frames, field)
            }),
            show: SHOW,
            more: MORE,
            help: HELP,
            style: STYLE,
            scripts: &SCRIPTS,
        }
        .html()
    }

    /// Chooses the frames for which the page has room, and those that have the elements inside.
    fn kept(&self) -> Kept {
        let places = thinned(self.frames.len(), |place| {
            self.frames[place].deflated[0].len() + self.frames[place].grains.deflated.len()
        });
        let frames = || places.iter().map(|&place| &self.frames[place]);
        if !frames().all(|frame| frame.solid) {
            return Kept { places, solid: Vec::new() };
        }
        let surface: usize =
            frames().map(|frame| frame.deflated[0].len() + frame.grains.deflated.len()).sum();
        // Base64 takes four characters for three bytes.
        let room = (MOST_BYTES / 4 * 3).saturating_sub(surface);
        let most = |of: fn(&SpaceFrame) -> usize| frames().map(of).max().unwrap_or(0).max(1);
        let by_elements = MOST_INSIDE_OF_ALL / most(|frame| frame.inside);
        let by_bytes = room / most(|frame| frame.deflated[1].len());
        let solid = even(by_elements.min(by_bytes).min(places.len()), places.len());
        Kept { places, solid }
    }

    fn counts(&self) -> String {
        let Some(last) = self.frames.last() else { return "no frames".to_owned() };
        let mut text = format!(
            "{}, {}",
            elements_and_spheres(last.whole, &last.grains),
            time_text(last.time, self.last())
        );
        let cracks: f64 = last.areas.iter().sum();
        if cracks > 0.0 {
            let (factor, unit) = area(cracks);
            // Fragments of bodies that cannot break are among them: the page calls them pieces everywhere.
            let plural = if last.fragments == 1 { "" } else { "s" };
            text = format!(
                "{text}, {} {unit} of cracks, {} piece{plural}",
                brief((cracks * factor * 100.0).round() / 100.0),
                grouped(last.fragments as u64)
            );
        }
        text
    }

    /// The latest time of the frames, which determines the unit and the decimals of times.
    fn last(&self) -> f64 {
        self.frames.iter().map(|frame| frame.time).fold(0.0, f64::max)
    }

    /// Returns a sentence on frames that have only their surface; empty if all have the inside.
    fn opening(&self, kept: &Kept) -> String {
        let total = kept.places.len();
        let text = match kept.solid.len() {
            solid if solid == total => return String::new(),
            0 if self.frames.iter().any(|frame| !frame.solid) => format!(
                "The mesh has {} elements. The page has those at the surface: a cut shows the surface open. Frames of meshes with up to {} elements have the inside.",
                grouped(self.frames.iter().map(|frame| frame.whole).max().unwrap_or(0) as u64),
                grouped(MOST_INSIDE as u64)
            ),
            0 => "The page has no room for the elements inside: a cut shows the surface open.".to_owned(),
            solid => {
                let places: Vec<String> = kept.solid.iter().map(|&k| kept.places[k].to_string()).collect();
                let which = if solid == 1 {
                    format!("frame {}", places[0])
                } else {
                    format!("frames {}", places.join(", "))
                };
                format!("A cut shows the inside of {which}. The page has only the surface of the others.")
            }
        };
        format!("  <p class=\"hint help\" id=\"inside\">{text}</p>\n")
    }

    /// Returns the data for the scripts.
    fn meta(&self, kept: &Kept) -> Value {
        let about = |(k, &place): (usize, &usize)| {
            let frame = &self.frames[place];
            let solid = kept.solid.contains(&k);
            let of_grains = (!frame.grains.is_empty()).then_some(frame.grains.size);
            let sizes: Vec<usize> =
                frame.sizes[..if solid { 2 } else { 1 }].iter().copied().chain(of_grains).collect();
            json!({
                "step": frame.step,
                "time": finite(frame.time),
                "elements": frame.surface + if solid { frame.inside } else { 0 },
                "surface": frame.surface,
                "solid": solid,
                "facets": frame.facets,
                "fragments": frame.fragments,
                "cracks": frame.cracks,
                "holding": [frame.intact, frame.softening],
                "sizes": sizes,
                "grains": about_grains(&frame.grains),
                "bounds": frame.bounds,
                "scales": frame.scales.map(|scale| scale.ends),
                "usual": frame.scales.map(|scale| scale.usual),
                "openings": frame.openings,
                "broken": frame.areas.into_iter().chain(frame.others).map(finite).collect::<Vec<_>>(),
            })
        };
        let extent = extent(self.frames.iter().map(|frame| (frame.extent(), frame.counts())));
        let half = extent.map(|[low, high]| (high - low) / 2.0);
        let middle = [0, 1, 2].map(|axis| extent[axis][0] + half[axis]);
        let unit = half.iter().map(|half| half * half).sum::<f64>().sqrt();
        let good = unit > 0.0 && unit.is_finite() && middle.iter().all(|x| x.is_finite());
        let (middle, half, unit) = if good { (middle, half, unit) } else { ([0.0; 3], [1.0; 3], 1.0) };
        json!({
            "elements": self.frames.iter().map(|frame| frame.whole).max().unwrap_or(0),
            "measure": "m²",
            "missing": "in this frame: it is inside, or it is not drawn",
            "last": finite(self.frames.last().map_or(0.0, |frame| frame.time)),
            "view": { "middle": middle, "unit": unit, "half": half.map(|side| (side / unit).max(1e-6)) },
            "frames": kept.places.iter().enumerate().map(about).collect::<Vec<_>>(),
        })
    }
}

/// Returns the factor and the unit with which areas are short.
fn area(largest: f64) -> (f64, &'static str) {
    match largest {
        x if x >= 1.0 => (1.0, "m²"),
        x if x >= 1e-4 => (1e4, "cm²"),
        _ => (1e6, "mm²"),
    }
}

#[cfg(test)]
mod tests {
    use fdem_simulation::{Mesh, Snapshot};

    use super::*;
    use crate::page::run::MOST_FRAMES;
    use crate::space::Shell;

    /// A frame of one tetrahedron that claims to have `inside` elements inside: pages of large frames take
    /// long to make.
    fn frame(inside: usize, solid: bool) -> SpaceFrame {
        let mesh = Mesh {
            nodes: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            elements: vec![[0, 1, 2, 3]],
            bodies: vec![0],
            materials: vec![0],
        };
        let snapshot = Snapshot {
            positions: mesh.nodes.clone(),
            displacements: vec![[0.0; 3]; 4],
            velocities: vec![[0.0; 3]; 4],
            elements: mesh.elements.clone(),
            stresses: vec![[0.0; 6]],
            damage: vec![0.0],
            bodies: vec![0],
            materials: vec![0],
            fragments: vec![0],
            ..Snapshot::default()
        };
        let mut frame = SpaceFrame::new(&snapshot, &Shell::new(&mesh, &[])).unwrap();
        (frame.inside, frame.solid, frame.whole) = (inside, solid, inside + 1);
        frame
    }

    fn page(frames: &[SpaceFrame]) -> String {
        let hostile = r#"</script><img src=x onerror="alert(1)">'{{script}}"#;
        let names = Names { bodies: vec![hostile.to_owned()], materials: Vec::new() };
        let facts = [("model", hostile), (hostile, "1")];
        let report = SpaceReport {
            title: hostile,
            facts: &facts,
            plots: &[],
            frames,
            fragments: &Fragments::default(),
            field: Field::DAMAGE,
            names: &names,
        };
        report.html(Some(b"png")).unwrap()
    }

    #[test]
    fn the_page_is_whole_and_safe() {
        let page = page(&[frame(0, true), frame(0, true)]);
        assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
        assert!(!page.contains("<img src=x") && page.contains("<img src=\"data:image/png;base64,cG5n\""));
        // Two parts of each frame, the data and the script.
        assert_eq!(page.matches("</script>").count(), 2 * 2 + 2);
        for address in ["http://", "https://"] {
            assert!(page.split(address).skip(1).all(|rest| rest.starts_with("www.w3.org")), "{address}");
        }
        for handler in ["onclick=", "onload=", "javascript:", " style="] {
            assert!(!page.contains(handler), "{handler} would need a weaker policy");
        }
        assert!(!page.contains("id=\"inside\"") && !page.contains("id=\"thinned\""));
        assert!(
            page.contains("<option value=\"damage\" selected>")
                && page.contains("<option value=\"fragment\">")
        );
    }

    #[test]
    fn frames_without_the_inside_are_told() {
        // Two frames of three have room for their inside: the first and the last.
        let some = page(&vec![frame(MOST_INSIDE, true); 3]);
        assert!(
            some.contains(
                "A cut shows the inside of frames 0, 2. The page has only the surface of the others."
            )
        );
        assert_eq!(some.matches("class=\"frame\"").count(), 3 + 2);
        let none = page(&[frame(MOST_INSIDE + 1, false)]);
        assert!(none.contains("The mesh has 300,002 elements. The page has those at the surface"));
        assert_eq!(none.matches("class=\"frame\"").count(), 1);
        let many = page(&vec![frame(0, true); MOST_FRAMES + 1]);
        assert!(many.contains("121 of 122 frames are in this page; frame 120 is left out."));
        assert!(page(&[]).contains("no frames"));
    }
}
