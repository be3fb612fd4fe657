//! Faults of a model file, shown at their place in the text.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Message, Origin, Padding, Renderer, Snippet, Title};

use fdem_io::numbers::grouped;

/// A fault of a model file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Description of the fault.
    pub message: String,
    /// Place of the fault, in bytes of the file; `None` for the file as a whole.
    pub span: Option<Range<usize>>,
    /// Short label at the place.
    pub label: String,
    /// Advice.
    pub help: Option<String>,
}

impl Fault {
    /// A fault at a place.
    pub fn at(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { message: message.into(), span: Some(span), label: "here".to_owned(), help: None }
    }

    /// Sets the label.
    #[must_use]
    pub fn label(self, label: impl Into<String>) -> Self {
        Self { label: label.into(), ..self }
    }

    /// Sets the advice.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// Sets the advice, if there is any.
    #[must_use]
    pub fn maybe_help(self, help: Option<String>) -> Self {
        Self { help: help.or(self.help), ..self }
    }
}

/// All faults of a model file; at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelErrors {
    /// Name of the file, for messages.
    pub name: String,
    /// Its text, to point into, with those of the files that it includes.
    pub text: String,
    /// Names of the included files, and where in `text` they begin, in ascending order.
    pub included: Vec<(String, usize)>,
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

/// Columns of a drawing: lines of the file that are longer are cut around the pointer.
const WIDTH: usize = 110;

/// Columns after which messages and advice are broken: `error: ` or a line number and `= help: ` come before
/// them.
const TEXT_WIDTH: usize = WIDTH - 12;

/// Faults that are shown; the rest is counted.
const SHOWN: usize = 25;

/// Bytes of a line beyond which it is not drawn.
const LONGEST_LINE: usize = 500;

impl ModelErrors {
    /// The errors of a model. `name`: the name of the file, for messages; `text`: its text. Sorts the faults
    /// by their places.
    pub fn new(name: &str, text: &str, mut faults: Vec<Fault>) -> Self {
        faults.sort_by_key(|fault| fault.span.as_ref().map_or(usize::MAX, |span| span.start));
        faults.dedup();
        Self { name: name.to_owned(), text: text.to_owned(), included: Vec::new(), faults }
    }

    /// Adds the files that are included, with their paths relative to the folder of the model.
    pub(crate) fn with_included(self, included: Vec<(String, usize)>) -> Self {
        let folder = Path::new(&self.name).parent().unwrap_or(Path::new(""));
        let name = |path: String| folder.join(path).display().to_string();
        Self { included: included.into_iter().map(|(path, start)| (name(path), start)).collect(), ..self }
    }

    /// Name of the file that has a fault.
    pub fn file(&self, fault: &Fault) -> &str {
        self.source(fault).0
    }

    /// Name and text of the file that has a fault, and where in all texts it begins.
    fn source(&self, fault: &Fault) -> (&str, &str, usize) {
        let starts = || self.included.iter().map(|(_, start)| *start);
        let place = fault.span.as_ref().map_or(0, |span| span.start);
        let number = starts().take_while(|start| *start <= place).count();
        // A line break separates two texts.
        let end = starts().nth(number).map_or(self.text.len(), |start| start - 1);
        let (name, start) = match number.checked_sub(1) {
            Some(number) => (self.included[number].0.as_str(), self.included[number].1),
            None => (self.name.as_str(), 0),
        };
        (name, self.text.get(start..end).unwrap_or(""), start)
    }

    /// Each fault with its lines of the file and a pointer at the key.
    pub fn render(&self, drawing: Drawing) -> String {
        let renderer = match drawing {
            Drawing::Plain => Renderer::plain(),
            Drawing::Terminal => Renderer::styled().decor_style(DecorStyle::Unicode),
        };
        let renderer = renderer.term_width(WIDTH);
        let mut out = String::new();
        for fault in self.faults.iter().take(SHOWN) {
            out.extend([renderer.render(&[self.report(fault)]).as_str(), "\n\n"]);
        }
        match self.more() {
            Some(more) => out.push_str(&more),
            None => out.truncate(out.len().saturating_sub(2)),
        }
        out.push('\n');
        out
    }

    /// Layout of an error: the message, the place and the advice.
    fn report(&self, fault: &Fault) -> Group<'static> {
        let title = Level::ERROR.primary_title(broken(&harmless(&fault.message)));
        let help = fault.help.as_ref().map(|help| Level::HELP.message(broken(&harmless(help))));
        let (name, text, begin) = self.source(fault);
        let name = harmless(name);
        let local = fault.span.as_ref().map(|span| span.start - begin..span.end.saturating_sub(begin));
        let Some(span) = local.map(|span| pointed(text, &span)) else {
            return without_lines(title, Origin::path(name), help);
        };
        if !is_drawn(text, &span) {
            let before = &text[..span.start];
            let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
            let place = Origin::path(name).line(line_of(before, before.len())).char_column(column);
            return without_lines(title, place, help);
        }
        let lines = lines_around(text, &span);
        let pointer = AnnotationKind::Primary.span(span.start - lines.start..span.end - lines.start);
        let first = line_of(text, lines.start);
        let mut source = harmless(&text[lines]);
        // A last line that is empty is drawn if something ends it.
        if span.start == text.len() {
            source.push('\n');
        }
        // Not folded: the lines around the pointer are shown, too.
        let snippet = Snippet::source(source).line_start(first).path(name).fold(false);
        title.element(snippet.annotation(pointer.label(harmless(&fault.label)))).elements(help)
    }

    /// Describes how many faults are not shown.
    fn more(&self) -> Option<String> {
        let more = self.faults.len().checked_sub(SHOWN).filter(|more| *more > 0)?;
        Some(format!("and {} more", grouped(more as u64)))
    }

    /// Line of a fault, counted from 1.
    pub fn line(&self, fault: &Fault) -> Option<usize> {
        let (_, text, begin) = self.source(fault);
        Some(line_of(text, fault.span.as_ref()?.start - begin))
    }
}

/// One line for each fault: `file:line: message; help`.
impl fmt::Display for ModelErrors {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, fault) in self.faults.iter().take(SHOWN).enumerate() {
            if place > 0 {
                out.write_str("\n")?;
            }
            write!(out, "{}", self.file(fault))?;
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

/// A fault whose lines are not drawn.
fn without_lines(
    title: Title<'static>,
    place: Origin<'static>,
    help: Option<Message<'static>>,
) -> Group<'static> {
    let report = title.element(place);
    match help {
        Some(help) => report.element(Padding).element(help),
        None => report,
    }
}

/// Whether the lines around a place are short enough to be drawn.
fn is_drawn(text: &str, span: &Range<usize>) -> bool {
    let before = text.as_bytes()[..span.start].rsplit(|&byte| byte == b'\n').take(2);
    let after = text.as_bytes()[span.start..].split(|&byte| byte == b'\n').take(2);
    let long: usize = before.chain(after).map(<[u8]>::len).sum();
    long <= LONGEST_LINE && span.len() <= LONGEST_LINE
}

/// Line of a byte of the text, counted from 1.
fn line_of(text: &str, byte: usize) -> usize {
    text.as_bytes()[..byte.min(text.len())].split(|&byte| byte == b'\n').count()
}

/// The part of a span that is pointed at: whole characters of the text, without the end of the last line.
fn pointed(text: &str, span: &Range<usize>) -> Range<usize> {
    let whole =
        |byte: usize| (0..=byte.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
    let start = whole(span.start);
    let end = whole(span.end).max(start);
    start..start + text[start..end].trim_end_matches(['\r', '\n']).len()
}

/// The lines of a span with one line above and one below.
fn lines_around(text: &str, span: &Range<usize>) -> Range<usize> {
    let start_of_line = |byte: usize| text[..byte].rfind('\n').map_or(0, |end| end + 1);
    let end_of_line = |byte: usize| text[byte..].find('\n').map_or(text.len(), |end| byte + end + 1);
    start_of_line(start_of_line(span.start).saturating_sub(1))..end_of_line(end_of_line(span.end))
}

/// Breaks long lines of text between words.
fn broken(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split('\n') {
        let mut width = 0;
        for (place, word) in line.split(' ').enumerate() {
            let length = word.chars().count();
            if place > 0 {
                let fits = width + 1 + length <= TEXT_WIDTH;
                out.push(if fits { ' ' } else { '\n' });
                width = if fits { width + 1 } else { 0 };
            }
            out.push_str(word);
            width += length;
        }
        out.push('\n');
    }
    out.pop();
    out
}

/// Replaces control characters, which could act on a terminal, by a question mark for each of their bytes.
fn harmless(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut characters = text.chars().peekable();
    while let Some(c) = characters.next() {
        let ends_line = c == '\n' || c == '\r' && characters.peek() == Some(&'\n');
        if c.is_control() && c != '\t' && !ends_line {
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
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
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

/// Names that are listed; the rest is counted.
const LISTED: usize = 12;

/// Advice that offers the nearest of the names, or lists them.
pub(crate) fn suggestion(word: &str, names: &[&str], what: &str) -> String {
    match nearest(word, names.iter().copied()) {
        Some(name) => format!("did you mean \"{name}\"?"),
        None if names.is_empty() => format!("there is no {what}"),
        None => listed(names),
    }
}

/// A list of names, shortened if it is long.
fn listed(names: &[&str]) -> String {
    if names.len() <= LISTED {
        return format!("there is {}", names.join(", "));
    }
    let more = grouped((names.len() - LISTED) as u64);
    format!("there is {}, and {more} more", names[..LISTED].join(", "))
}

/// Advice that lists the names, the nearest first, and asks whether it is the one that was meant if it is
/// near.
pub(crate) fn nearest_first(word: &str, names: &[&str], what: &str) -> String {
    let likeness =
        |name: &str| strsim::normalized_damerau_levenshtein(&word.to_lowercase(), &name.to_lowercase());
    let near = nearest(word, names.iter().copied());
    // Equally near names stay in their order.
    let mut sorted: Vec<(bool, f64, &str)> =
        names.iter().map(|&name| (Some(name) != near, -likeness(name), name)).collect();
    sorted.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let sorted: Vec<&str> = sorted.into_iter().map(|(_, _, name)| name).collect();
    let meant = near.filter(|_| names.len() > 1).map(|name| format!("did you mean \"{name}\"? "));
    let listed = match (sorted.len(), near) {
        (0, _) | (1, Some(_)) => suggestion(word, &sorted, what),
        _ => listed(&sorted),
    };
    meant.unwrap_or_default() + &listed
}

/// A problem of a body, and the key that it belongs to.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) key: String,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

impl Problem {
    pub(crate) fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into(), help: None }
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
    fn names_are_listed_with_the_nearest_first() {
        let of = |word: &str, names: &[&str]| nearest_first(word, names, "column");
        let names = ["left ux", "left uy", "top fx", "top fy"];
        assert_eq!(
            of("top fz", &names),
            "did you mean \"top fx\"? there is top fx, top fy, left ux, left uy"
        );
        assert_eq!(of("zz", &["left ux", "row"]), "there is left ux, row");
        assert_eq!(of("top f", &["top fx"]), "did you mean \"top fx\"?");
        assert_eq!(of("a", &[]), "there is no column");
        let many: Vec<String> = (0..30).map(|k| format!("gauge {k} strain")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        let found = of("gauge 29 strains", &many);
        assert!(found.starts_with("did you mean \"gauge 29 strain\"? there is gauge 29 strain, "), "{found}");
        assert!(found.ends_with(", and 18 more"), "{found}");
    }

    #[test]
    fn what_could_write_to_a_terminal_is_replaced_in_place() {
        assert_eq!(harmless("a\u{1b}[31m\u{85}ü\r\r\n\tb\r"), "a?[31m??ü?\r\n\tb?");
    }

    /// A fault at a place of a text, drawn.
    fn drawn(text: &str, span: Range<usize>) -> String {
        let fault = Fault::at(span, "wrong").help("right");
        ModelErrors::new("m.toml", text, vec![fault]).render(Drawing::Plain)
    }

    #[test]
    fn a_fault_is_drawn_with_its_line_and_those_around_it() {
        let text = "[a]\nb = 1\n\tcd = 2\r\ne = 3\nf = 4";
        let expected = "\
error: wrong
 --> m.toml:3:2
  |
2 | b = 1
3 |     cd = 2
  |     ^^ here
4 | e = 3
  |
  = help: right
";
        assert_eq!(drawn(text, 11..13), expected);
        // The end of the file is a place, with a last line that is empty or not.
        assert!(drawn(text, text.len()..text.len()).contains("5 | f = 4\n  |      ^ here\n"));
        assert!(drawn("a = 1\n", 6..6).contains("1 | a = 1\n2 |\n  | ^ here\n"));
        assert!(drawn("", 0..0).contains(" --> m.toml:1:1\n  |\n1 |\n  | ^ here\n"));
    }

    #[test]
    fn a_fault_in_a_line_that_is_too_long_is_told_with_its_column() {
        let text = format!("a = 1\nb = \"{}\"\n", "é".repeat(300));
        let expected = "error: wrong\n--> m.toml:2:5\n |\n = help: right\n";
        assert_eq!(drawn(&text, 10..12), expected);
        let errors =
            ModelErrors::new("m.toml", &text, vec![Fault { span: None, ..Fault::at(0..0, "wrong") }]);
        assert_eq!(errors.render(Drawing::Plain), "error: wrong\n--> m.toml\n");
    }

    #[test]
    fn every_span_of_a_text_is_drawn_with_its_line() {
        let text = "a = 1\r\n\n\"岩石\" = \t\"é\u{1b}👩\u{200d}🔬\"\r\r\n[b]\n\n\nc = [\nü\n岩\n\n石\n]\n";
        for text in [text, text.trim_end()] {
            for start in 0..=text.len() + 1 {
                for end in start..=text.len() + 2 {
                    let drawn = drawn(text, start..end);
                    let place = format!("m.toml:{}:", line_of(text, start));
                    assert!(drawn.contains(&place) && drawn.contains("here"), "{start}..{end}:\n{drawn}");
                    let errors = ModelErrors::new("m.toml", text, vec![Fault::at(start..end, "wrong")]);
                    assert!(errors.render(Drawing::Terminal).contains("here"), "{start}..{end}");
                }
            }
        }
    }

    /// Wide characters, tabs and lines that are cut: the pointer starts where the key is.
    #[test]
    fn the_pointer_stands_below_the_key() {
        let width = |text: &str| -> usize { text.chars().map(|c| 1 + usize::from(c > '\u{2fff}')).sum() };
        for before in ["", "x = ", "\t", "\t岩 = \t", "\"岩石\" = ", &"岩 ".repeat(30), &"b ".repeat(120)]
        {
            for after in ["", " = 1", &" 岩".repeat(30)] {
                let text = format!("a = 1\n{before}KEY{after}\nc = 2\n");
                let start = 6 + before.len();
                let drawn = drawn(&text, start..start + 3);
                let lines: Vec<_> = drawn.lines().collect();
                let at = lines.iter().position(|line| line.contains("KEY")).unwrap();
                let (source, pointer) = (lines[at], lines[at + 1]);
                assert!(source.starts_with("2 | ") && pointer.ends_with("^^^ here"), "{drawn}");
                assert_eq!(
                    width(&source[..source.find("KEY").unwrap()]),
                    pointer.find('^').unwrap(),
                    "{drawn}"
                );
                assert!(width(source) <= WIDTH, "{drawn}");
            }
        }
    }

    #[test]
    fn long_messages_are_broken_between_words() {
        let text = format!("{}\nend", "word ".repeat(50).trim_end());
        let lines = broken(&text);
        assert_eq!(lines.replace('\n', " "), text.replace('\n', " "));
        assert_eq!(lines.lines().map(str::len).collect::<Vec<_>>(), [94, 94, 59, 3]);
    }
}
