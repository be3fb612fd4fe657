//! What is wrong with a model file, shown where it is.

use std::fmt;
use std::ops::Range;

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report};

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// What is wrong.
    pub message: String,
    /// Where: bytes of the file. `None`: of the file as a whole.
    pub span: Option<Range<usize>>,
    /// What stands there, in a word or two.
    pub label: String,
    /// What to do.
    pub help: Option<String>,
}

impl Fault {
    /// A fault at a place.
    pub(crate) fn at(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { message: message.into(), span: Some(span), label: "here".to_owned(), help: None }
    }

    /// With what stands there.
    pub(crate) fn label(self, label: impl Into<String>) -> Self {
        Self { label: label.into(), ..self }
    }

    /// With what to do.
    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// With what to do, if that is known.
    pub(crate) fn maybe_help(self, help: Option<String>) -> Self {
        Self { help: help.or(self.help), ..self }
    }
}

/// All that is wrong with a model file; at least one thing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelErrors {
    /// Name of the file, for messages.
    pub name: String,
    /// Its text, to point into.
    pub text: String,
    /// In the order of the file.
    pub faults: Vec<Fault>,
}

/// How errors are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawing {
    /// ASCII, no colours: for files and pipes.
    Plain,
    /// Lines and colours of a terminal.
    Terminal,
}

/// Columns after which text is broken.
const WIDTH: usize = 110;

impl ModelErrors {
    pub(crate) fn new(name: &str, text: &str, mut faults: Vec<Fault>) -> Self {
        faults.sort_by_key(|fault| fault.span.as_ref().map_or(usize::MAX, |span| span.start));
        faults.dedup();
        Self { name: name.to_owned(), text: text.to_owned(), faults }
    }

    /// Each fault with its lines of the file and a pointer at the key.
    pub fn render(&self, drawing: Drawing) -> String {
        let theme = match drawing {
            Drawing::Plain => GraphicalTheme::none(),
            Drawing::Terminal => GraphicalTheme::unicode(),
        };
        let handler = GraphicalReportHandler::new_themed(theme)
            .with_width(WIDTH)
            .with_links(false)
            .with_context_lines(1);
        let text = harmless(&self.text);
        let mut out = String::new();
        for fault in &self.faults {
            let mut diagnostic = MietteDiagnostic::new(harmless(&fault.message));
            if let Some(help) = &fault.help {
                diagnostic = diagnostic.with_help(harmless(help));
            }
            if let Some(span) = &fault.span {
                let span = span.start.min(text.len())..span.end.min(text.len());
                diagnostic =
                    diagnostic.with_label(LabeledSpan::new_with_span(Some(harmless(&fault.label)), span));
            }
            let report = Report::new(diagnostic).with_source_code(NamedSource::new(&self.name, text.clone()));
            if handler.render_report(&mut out, report.as_ref()).is_err() {
                out.push_str(&fault.message);
                out.push('\n');
            }
        }
        out
    }

    /// Line of a fault, counted from 1.
    pub fn line(&self, fault: &Fault) -> Option<usize> {
        let start = fault.span.as_ref()?.start;
        Some(self.text.get(..start).unwrap_or(&self.text).matches('\n').count() + 1)
    }
}

/// One line for each fault: `file:line: message; help`.
impl fmt::Display for ModelErrors {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, fault) in self.faults.iter().enumerate() {
            if place > 0 {
                out.write_str("\n")?;
            }
            write!(out, "{}", self.name)?;
            if let Some(line) = self.line(fault) {
                write!(out, ":{line}")?;
            }
            write!(out, ": {}", fault.message)?;
            if let Some(help) = &fault.help {
                write!(out, "; {help}")?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for ModelErrors {}

/// The same text, byte for byte as long, without what could write to a terminal.
fn harmless(text: &str) -> String {
    let bad = |c: char| c.is_control() && c != '\n' && c != '\t' && c != '\r';
    if !text.contains(bad) {
        return text.to_owned();
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if bad(c) {
            out.extend(std::iter::repeat_n('?', c.len_utf8()));
        } else {
            out.push(c);
        }
    }
    out
}

/// The same quantity by other names: what people write who come from papers and other programs.
const SYNONYMS: [(&str, &str); 24] = [
    ("center", "centre"),
    ("e", "youngs_modulus"),
    ("young", "youngs_modulus"),
    ("elastic_modulus", "youngs_modulus"),
    ("nu", "poissons_ratio"),
    ("poisson", "poissons_ratio"),
    ("rho", "density"),
    ("ft", "tensile_strength"),
    ("f_t", "tensile_strength"),
    ("c", "cohesion"),
    ("phi", "friction_angle"),
    ("mu", "friction"),
    ("gf", "fracture_energy_i"),
    ("g_f", "fracture_energy_i"),
    ("gi", "fracture_energy_i"),
    ("gii", "fracture_energy_ii"),
    ("fracture_energy", "fracture_energy_i"),
    ("fracture_energy_1", "fracture_energy_i"),
    ("fracture_energy_2", "fracture_energy_ii"),
    ("dt", "time_step"),
    ("step", "time_step"),
    ("circle", "disc"),
    ("h", "mesh_size"),
    ("duration", "end_time"),
];

/// The candidate that was probably meant.
pub(crate) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase().replace('-', "_");
    let meant = SYNONYMS.iter().find(|(other, _)| *other == word).map(|(_, name)| *name);
    let mut best: Option<(f64, &str)> = None;
    for candidate in candidates {
        if Some(candidate) == meant {
            return Some(candidate);
        }
        let lower = candidate.to_lowercase();
        let mut likeness = strsim::normalized_damerau_levenshtein(&word, &lower);
        // A piece of a longer name: "strength", "radius_inner".
        if word.len() >= 4 && (lower.contains(&word) || word.contains(&lower) && lower.len() >= 4) {
            likeness = likeness.max(0.6);
        }
        if likeness >= 0.55 && best.is_none_or(|(most, _)| likeness > most) {
            best = Some((likeness, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// The end of a message that offers the nearest of the names, or all of them if they are few.
pub(crate) fn suggestion(word: &str, names: &[&str], what: &str) -> Option<String> {
    match nearest(word, names.iter().copied()) {
        Some(name) => Some(format!("did you mean \"{name}\"?")),
        None if names.is_empty() => Some(format!("there is no {what}")),
        None if names.len() <= 12 => Some(format!("there is {}", names.join(", "))),
        None => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_and_none_where_nothing_is_near() {
        let keys = ["density", "youngs_modulus", "poissons_ratio", "tensile_strength", "friction_angle"];
        for (word, meant) in [
            ("densty", Some("density")),
            ("Density", Some("density")),
            ("E", Some("youngs_modulus")),
            ("young_modulus", Some("youngs_modulus")),
            ("poisson_ratio", Some("poissons_ratio")),
            ("strength", Some("tensile_strength")),
            ("friction-angle", Some("friction_angle")),
            ("colour", None),
        ] {
            assert_eq!(nearest(word, keys), meant, "{word}");
        }
    }

    #[test]
    fn what_could_write_to_a_terminal_is_replaced_in_place() {
        assert_eq!(harmless("a\u{1b}[31m\u{85}ü\n"), "a?[31m??ü\n");
    }
}
