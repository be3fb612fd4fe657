//! The part of a page with the spheres and walls of a run.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::fields::field::{Field, SPHERE_SCALES};
use crate::fields::range::{Range, Scale};
use crate::picture::svg::escape;
use crate::run::grains::drawing::{PULLING, WALL, WIDEST};
use crate::run::grains::frame::GrainFrame;

/// Scripts of pages with spheres.
pub(super) const SCRIPTS: [&str; 1] = [include_str!("grains.js")];

const CONTROLS: &str = include_str!("grains.html");

/// The controls of spheres, and the data for the scripts.
pub(super) struct GrainPart {
    pub(super) controls: String,
    pub(super) meta: Value,
}

impl GrainPart {
    /// Returns the part for a series of frames; `None` if no frame has spheres or walls. `field`: by which
    /// spheres are initially coloured if they have values of it; `range`: the range of a field.
    pub(super) fn new<'a>(
        frames: impl Iterator<Item = &'a GrainFrame>,
        field: Field,
        range: impl Fn(Field) -> Range,
    ) -> Option<Self> {
        let last = frames.filter(|frame| !frame.is_empty()).last()?;
        let [one, many] = if last.discs { ["disc", "discs"] } else { ["sphere", "spheres"] };
        let first = if field.of_spheres().is_some() { field } else { Field::VELOCITY };
        let fields = || Field::ALL.into_iter().filter(|field| field.of_spheres().is_some());
        let mut options = String::new();
        for field in fields() {
            let selected = if field == first { " selected" } else { "" };
            let _ = write!(options, "<option value=\"{}\"{selected}>{}</option>", field.key(), name(field));
        }
        let controls = CONTROLS
            .replace("{{many}}", if last.discs { "Discs" } else { "Spheres" })
            .replace("{{lower}}", many)
            .replace("{{chains}}", if field == Field::FORCE_CHAINS { " checked" } else { "" })
            .replace("{{options}}", &options);
        let chains = Field::FORCE_CHAINS;
        let about = |field: Field| {
            let Range { low, high } = range(field);
            json!({
                "key": field.key(),
                "name": name(field),
                "unit": field.of_spheres().map_or(field.unit(), |row| row.unit),
                "scale": field.sphere_scale(),
                "range": [low, high],
                "ramp": field.ramp(),
            })
        };
        let radius = SPHERE_SCALES.iter().position(|field| field.key() == "radius");
        let mut of_chains = about(chains);
        of_chains["widest"] = json!(WIDEST);
        let meta = json!({
            "one": one,
            "many": many,
            "fields": fields().map(about).collect::<Vec<_>>(),
            "radius": radius,
            "chains": of_chains,
            "wall": WALL,
            "pulling": PULLING,
            "groups": last.names.groups,
            "walls": last.names.walls,
        });
        Some(Self { controls, meta })
    }
}

/// Returns the name of a field of spheres.
fn name(field: Field) -> &'static str {
    field.of_spheres().map_or(field.name(), |row| row.name)
}

/// Returns the data of a frame for the scripts; null if it has neither spheres nor walls.
pub(super) fn about(frame: &GrainFrame) -> Value {
    if frame.is_empty() {
        return Value::Null;
    }
    let ends = |scale: &Scale| scale.ends;
    let usual = |scale: &Scale| scale.usual;
    json!({
        "spheres": frame.spheres,
        "whole": frame.whole,
        "contacts": frame.contacts,
        "chains": frame.chains,
        "loose": frame.loose,
        "triangles": frame.triangles,
        "bounds": frame.bounds,
        "scales": frame.ranges.scales.iter().map(ends).collect::<Vec<_>>(),
        "usual": frame.ranges.scales.iter().map(usual).collect::<Vec<_>>(),
        "chainsEnds": frame.ranges.chains.ends,
        "chainsUsual": frame.ranges.chains.usual,
    })
}

/// Returns sentences on spheres and contacts that are not in the frames; empty if all are.
pub(super) fn sampling<'a>(frames: impl Iterator<Item = &'a GrainFrame>) -> String {
    let (mut spheres, mut contacts) = (None, None);
    for frame in frames {
        if frame.spheres < frame.whole {
            spheres = Some((frame.spheres, frame.whole));
        }
        if frame.chains < frame.contacts {
            contacts = Some((frame.chains, frame.contacts));
        }
    }
    let grouped = |number: usize| fdem_io::numbers::grouped(number as u64);
    let line = |id: &str, text: String| {
        format!(
            "  <p class=\"hint help\" id=\"{id}\">{} The files for ParaView have all.</p>\n",
            escape(&text)
        )
    };
    let spheres = spheres.map(|(shown, all)| {
        line("spheres-sample", format!("The view shows {} of {} spheres.", grouped(shown), grouped(all)))
    });
    let contacts = contacts.map(|(shown, all)| {
        line(
            "chains-sample",
            format!("Of {} contacts it shows the {} strongest.", grouped(all), grouped(shown)),
        )
    });
    spheres.into_iter().chain(contacts).collect()
}
