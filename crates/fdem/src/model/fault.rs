//! Faults of a model file, shown at their place in the text.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report};

use crate::numbers::grouped;

/// A fault of a model file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Description of the fault.
    pub message: String,
    /// Place of the fault, in bytes of the file; `None` for the file as a whole.
    pub span: Option<Range<usize>>,
    /// Label at the place, in a word or two.
    pub label: String,
    /// Advice.
    pub help: Option<String>,
}

impl Fault {
    /// A fault at a place.
    pub(crate) fn at(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { message: message.into(), span: Some(span), label: "here".to_owned(), help: None }
    }

    /// Sets the label.
    pub(crate) fn label(self, label: impl Into<String>) -> Self {
        Self { label: label.into(), ..self }
    }

    /// Sets the advice.
    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// Sets the advice, if there is any.
    pub(crate) fn maybe_help(self, help: Option<String>) -> Self {
        Self { help: help.or(self.help), ..self }
    }
}

/// All faults of a model file; at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelErrors {
    /// Name of the file, for messages.
    pub name: String,
    /// Its text, to point into.
    pub text: String,
    /// Faults in the order of the file.
    pub faults: Vec<Fault>,
}

/// Style in which errors are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawing {
    /// ASCII, no colours: for files and pipes.
    Plain,
    /// Lines and colours of a terminal.
    Terminal,
}

/// Columns after which text is broken.
const WIDTH: usize = 110;

/// Faults that are shown; the rest is counted.
const SHOWN: usize = 25;

/// Bytes of a line beyond which it is not drawn.
const LONGEST_LINE: usize = 500;

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
        let text = Arc::new(harmless(&self.text));
        let mut out = String::new();
        for fault in self.faults.iter().take(SHOWN) {
            let mut diagnostic = MietteDiagnostic::new(harmless(&fault.message));
            if let Some(help) = &fault.help {
                diagnostic = diagnostic.with_help(harmless(help));
            }
            let span = fault.span.as_ref().map(|span| span.start.min(text.len())..span.end.min(text.len()));
            let drawn = span.filter(|span| is_drawn(&text, span));
            let report = if let Some(span) = drawn {
                let label = LabeledSpan::new_with_span(Some(harmless(&fault.label)), span);
                let source = NamedSource::new(&self.name, Arc::clone(&text));
                Report::new(diagnostic.with_label(label)).with_source_code(source)
            } else {
                diagnostic.message = match self.line(fault) {
                    Some(line) => format!("{}:{line}: {}", self.name, diagnostic.message),
                    None => format!("{}: {}", self.name, diagnostic.message),
                };
                Report::new(diagnostic)
            };
            if handler.render_report(&mut out, report.as_ref()).is_err() {
                out.push_str(&fault.message);
                out.push('\n');
            }
        }
        if let Some(more) = self.more() {
            out.extend(["  ", more.as_str(), "\n"]);
        }
        out
    }

    /// Describes how many faults are not shown.
    fn more(&self) -> Option<String> {
        let more = self.faults.len().checked_sub(SHOWN).filter(|more| *more > 0)?;
        Some(format!("and {} more", grouped(more as u64)))
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
        for (place, fault) in self.faults.iter().take(SHOWN).enumerate() {
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
        if let Some(more) = self.more() {
            write!(out, "\n{}: {more}", self.name)?;
        }
        Ok(())
    }
}

impl std::error::Error for ModelErrors {}

/// Whether the lines around a place are short enough to be drawn.
fn is_drawn(text: &str, span: &Range<usize>) -> bool {
    let before = text.as_bytes()[..span.start].rsplit(|&byte| byte == b'\n').take(2);
    let after = text.as_bytes()[span.start..].split(|&byte| byte == b'\n').take(2);
    let long: usize = before.chain(after).map(<[u8]>::len).sum();
    long <= LONGEST_LINE && span.len() <= LONGEST_LINE
}

/// Replaces control characters, which could act on a terminal, by as many question marks as they have bytes.
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

/// Other names of keys, from papers and other programs.
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

/// Names that are compared with one that is not there.
const CANDIDATES: usize = 500;

/// Returns the candidate that was probably meant.
pub(crate) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase().replace('-', "_");
    let meant = SYNONYMS.iter().find(|(other, _)| *other == word).map(|(_, name)| *name);
    let mut best: Option<(f64, &str)> = None;
    for candidate in candidates.into_iter().take(CANDIDATES) {
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

/// Advice that offers the nearest of the names, or all of them if they are few.
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
