//! Arithmetic, units and parameters in the values of a model file.
//!
//! [`evaluate`] is the pass between the parser and the check against the schema: where the schema has a
//! number and the file a text, the text is an expression, which its value replaces. The place of the value
//! stays that of the text. Words that the schema knows, such as "auto", and all other texts stay as they are.
//!
//! A key of the schema has its unit in `x-unit`: one for all numbers of the key, or a list with one for each
//! entry of a short array. Keys without it take any dimension.

mod expression;
mod quantity;
pub(crate) mod units;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;

use fdem_io::numbers::exact;
use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::text::document::{Document, number};
use crate::text::fault::{Fault, suggestion};
use crate::text::schema::{branches, types, words};
use expression::{Wrong, is_name, meaning};
use quantity::Amount;
use units::Dimension;

/// The table of the parameters.
pub(crate) const PARAMETERS: &str = "parameters";

/// Parameters that may refer to each other in a chain. The chain is followed by recursion.
const LONGEST_CHAIN: usize = 100;

/// Whole numbers beyond this are not all floating-point numbers.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// The values of the expressions of a document.
#[derive(Debug)]
pub(crate) struct Evaluated {
    /// A TOML list of numbers.
    numbers: String,
    /// The place of the expression of each number.
    spans: Vec<Range<usize>>,
    /// The places of expressions without a value.
    wrong: Vec<Range<usize>>,
    /// Errors of the expressions.
    pub(crate) faults: Vec<Fault>,
    /// Parameters that nothing uses, with their places.
    pub(crate) unused: Vec<(String, Range<usize>)>,
    /// Dimensions of expressions whose keys have no unit, by their places.
    dimensions: BTreeMap<usize, Dimension>,
}

impl Evaluated {
    /// Whether an expression at this place has no value.
    pub(crate) fn is_wrong(&self, span: Option<&Range<usize>>) -> bool {
        span.is_some_and(|span| self.wrong.contains(span))
    }
}

/// Finds the values of the expressions of a document. [`replace`] puts them into it.
pub(crate) fn evaluate(document: &Document<'_>, text: &str, schema: &Value) -> Evaluated {
    let mut faults = Vec::new();
    let parameters = Parameters::read(document.root().get_ref(), text, &mut faults);
    let mut pass = Pass {
        schema,
        parameters: &parameters,
        numbers: Vec::new(),
        spans: Vec::new(),
        wrong: Vec::new(),
        faults,
        dimensions: BTreeMap::new(),
    };
    for (key, value) in document.root().get_ref() {
        let property = schema.get("properties").and_then(|keys| keys.get(key.get_ref().as_ref()));
        if let Some(property) = property.filter(|_| key.get_ref() != PARAMETERS) {
            pass.value(value, property, None, key.get_ref());
        }
    }
    let Pass { numbers, spans, wrong, mut faults, dimensions, .. } = pass;
    for name in parameters.entries.keys() {
        if let Err(Some(fault)) = parameters.of(name) {
            faults.push(fault);
        }
    }
    Evaluated {
        numbers: format!("[{}]", numbers.join(", ")),
        spans,
        wrong,
        faults,
        unused: parameters.unused(),
        dimensions,
    }
}

/// The document with values in the places of its expressions.
pub(crate) fn replace<'a>(mut document: Document<'a>, evaluated: &'a Evaluated) -> Document<'a> {
    let mut values = BTreeMap::new();
    if let Ok(numbers) = DeValue::parse(&evaluated.numbers)
        && let DeValue::Array(numbers) = numbers.into_inner()
    {
        values.extend(evaluated.spans.iter().map(|span| span.start).zip(numbers));
    }
    if !values.is_empty() {
        document.root_mut().get_mut().iter_mut().for_each(|(_, value)| put(value, &mut values));
    }
    document.set_dimensions(evaluated.dimensions.clone());
    document
}

/// Replaces the texts in a value whose places have numbers.
fn put<'a>(value: &mut Spanned<DeValue<'a>>, numbers: &mut BTreeMap<usize, Spanned<DeValue<'a>>>) {
    let span = value.span();
    match value.get_mut() {
        DeValue::Table(table) => table.iter_mut().for_each(|(_, value)| put(value, numbers)),
        DeValue::Array(list) => list.iter_mut().for_each(|value| put(value, numbers)),
        DeValue::String(_) => {
            if let Some(number) = numbers.remove(&span.start) {
                *value = Spanned::new(span, number.into_inner());
            }
        }
        _ => {}
    }
}

/// Where a problem of an expression is in the text. `span`: the value with its quotes.
fn place(text: &str, span: &Range<usize>, expression: &str, at: &Range<usize>) -> Range<usize> {
    // Only a text without escapes has its bytes where the expression has them.
    let inside = span.start + 1..span.end.saturating_sub(1);
    if at.is_empty() || text.get(inside.clone()) != Some(expression) {
        return span.clone();
    }
    if at.len() == expression.len() { span.clone() } else { inside.start + at.start..inside.start + at.end }
}

fn fault(text: &str, span: &Range<usize>, expression: &str, wrong: Wrong) -> Fault {
    let message = format!("\"{expression}\" has no value: {}", wrong.message);
    let help = wrong.help.or_else(|| has_time(expression).then(|| TONNE.to_owned()));
    Fault::at(place(text, span, expression, &wrong.at), message).label("here").maybe_help(help)
}

/// Help for an expression that takes the time for a variable.
const TONNE: &str = "t is the tonne here, and no value depends on the time; a load over time is its largest value with a table, or with expression = \"exp(-t/1e-3)\", t in seconds";

/// Whether an expression has a unit `t` where a variable would be: after a sign, a parenthesis or nothing.
fn has_time(expression: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    expression.match_indices('t').any(|(at, _)| {
        let before = expression[..at].trim_end();
        let is_alone = !expression[..at].ends_with(is_word) && !expression[at + 1..].starts_with(is_word);
        is_alone && (before.is_empty() || before.ends_with(['+', '-', '*', '/', '^', '(', ',']))
    })
}

/// The text of a parameter.
enum ParameterText {
    Number(f64),
    Expression(String),
    /// Neither; the schema reports it.
    Other,
}

/// How far a parameter has been evaluated.
#[derive(Clone)]
enum State {
    New,
    /// Its value is being computed: a parameter that needs it now is part of a cycle.
    Open,
    /// It has a value, or has none.
    Done(Option<Amount>),
}

struct NamedValue {
    key: Range<usize>,
    value: Range<usize>,
    source: ParameterText,
    state: RefCell<State>,
    used: RefCell<bool>,
}

/// The parameters of a file.
struct Parameters<'t> {
    text: &'t str,
    entries: BTreeMap<String, NamedValue>,
    /// The parameters whose values are being found, each for the one before.
    chain: RefCell<Vec<String>>,
}

impl<'t> Parameters<'t> {
    fn read(root: &DeTable<'_>, text: &'t str, faults: &mut Vec<Fault>) -> Self {
        let mut entries = BTreeMap::new();
        let table = root.iter().find(|(key, _)| key.get_ref() == PARAMETERS);
        for (key, value) in table.and_then(|(_, table)| table.get_ref().as_table()).into_iter().flatten() {
            let name = key.get_ref().as_ref();
            if let Some(what) = meaning(name) {
                let help = format!("take another name, such as {name}_1");
                let message = format!("\"{name}\" is {what} and cannot be a parameter");
                faults.push(Fault::at(key.span(), message).label("has a meaning").help(help));
                continue;
            }
            if !is_name(name) {
                let message =
                    format!("\"{name}\" cannot be a parameter: a name has letters, digits and _ only");
                faults.push(Fault::at(key.span(), message).label("no name"));
                continue;
            }
            let source = match value.get_ref() {
                DeValue::String(expression) => ParameterText::Expression(expression.to_string()),
                other => number(other).map_or(ParameterText::Other, ParameterText::Number),
            };
            let parameter = NamedValue {
                key: key.span(),
                value: value.span(),
                source,
                state: RefCell::new(State::New),
                used: RefCell::new(false),
            };
            entries.insert(name.to_owned(), parameter);
        }
        Self { text, entries, chain: RefCell::new(Vec::new()) }
    }

    /// The value of a parameter that exists; the fault only the first time.
    fn of(&self, name: &str) -> Result<Amount, Option<Fault>> {
        let Some(parameter) = self.entries.get(name) else { return Err(None) };
        let state = parameter.state.borrow().clone();
        match state {
            State::Done(value) => return value.ok_or(None),
            State::Open => return Err(None),
            State::New => {}
        }
        let expression = match &parameter.source {
            ParameterText::Number(number) => return Ok(Amount::plain(*number)),
            ParameterText::Other => return Err(None),
            ParameterText::Expression(expression) => expression,
        };
        *parameter.state.borrow_mut() = State::Open;
        self.chain.borrow_mut().push(name.to_owned());
        let value = self.value(expression, &parameter.value);
        self.chain.borrow_mut().pop();
        *parameter.state.borrow_mut() = State::Done(value.as_ref().ok().copied());
        value
    }

    /// The value of an expression at a place of the text. No error is reported twice.
    fn value(&self, expression: &str, span: &Range<usize>) -> Result<Amount, Option<Fault>> {
        let told = |wrong| Some(fault(self.text, span, expression, wrong));
        let parsed = expression::parse(expression).map_err(told)?;
        // The fault of a parameter that is named here and has none.
        let mut inner = None;
        let value = parsed.value(&mut |name, at| {
            self.look_up(name, at.clone()).map_err(|wrong| match wrong {
                Ok(wrong) => wrong,
                Err(fault) => {
                    inner = Some(fault);
                    Wrong::new(at, "")
                }
            })
        });
        value.map_err(|wrong| inner.take().unwrap_or_else(|| told(wrong)))
    }

    /// The value of a parameter in an expression; the error is the problem here, or the error of the
    /// parameter.
    fn look_up(&self, name: &str, at: Range<usize>) -> Result<Amount, Result<Wrong, Option<Fault>>> {
        let Some(parameter) = self.entries.get(name) else {
            let names: Vec<&str> = self.entries.keys().map(String::as_str).collect();
            let wrong = Wrong::new(at, format!("there is no parameter \"{name}\""));
            return Err(Ok(wrong.help(suggestion(name, &names, "[parameters] table"))));
        };
        let is_open = matches!(*parameter.state.borrow(), State::Open);
        if is_open {
            let chain = self.chain.borrow();
            let start = chain.iter().position(|other| other == name).unwrap_or(0);
            let cycle: Vec<&str> = chain[start..].iter().map(String::as_str).chain([name]).collect();
            let message = format!("parameters need each other in a circle: {}", cycle.join(" -> "));
            return Err(Ok(Wrong::new(at, message)));
        }
        *parameter.used.borrow_mut() = true;
        if self.chain.borrow().len() >= LONGEST_CHAIN {
            let message = format!("more than {LONGEST_CHAIN} parameters need each other in a chain");
            return Err(Ok(Wrong::new(at, message)));
        }
        self.of(name).map_err(Err)
    }

    fn unused(&self) -> Vec<(String, Range<usize>)> {
        let unused = self.entries.iter().filter(|(_, parameter)| !*parameter.used.borrow());
        unused.map(|(name, parameter)| (name.clone(), parameter.key.clone())).collect()
    }
}

/// Alternatives of a schema, without references, each with its unit.
fn alternatives<'s>(
    root: &'s Value,
    schema: &'s Value,
    unit: Option<&'s Value>,
    found: &mut Vec<(&'s Value, Option<&'s Value>)>,
) {
    let unit = schema.get("x-unit").or(unit);
    if let Some(name) = schema.get("$ref").and_then(Value::as_str) {
        let inner = name.strip_prefix("#/$defs/").and_then(|name| root.get("$defs")?.get(name));
        if let Some(inner) = inner {
            alternatives(root, inner, unit, found);
        }
    } else if let Some(branches) = branches(schema) {
        for branch in branches {
            alternatives(root, branch, unit, found);
        }
    } else {
        found.push((schema, unit));
    }
}

struct Pass<'a> {
    schema: &'a Value,
    parameters: &'a Parameters<'a>,
    /// Values of expressions, and the places of these.
    numbers: Vec<String>,
    spans: Vec<Range<usize>>,
    wrong: Vec<Range<usize>>,
    faults: Vec<Fault>,
    /// Dimensions of expressions whose keys have no unit, by their places.
    dimensions: BTreeMap<usize, Dimension>,
}

impl<'a> Pass<'a> {
    /// Goes through a value with its schema. `unit`: that of the table or the list around it.
    fn value(&mut self, value: &Spanned<DeValue<'_>>, schema: &'a Value, unit: Option<&'a Value>, key: &str) {
        let mut found = Vec::new();
        alternatives(self.schema, schema, unit, &mut found);
        let of = |kind: &str| found.iter().copied().find(|(schema, _)| types(schema).contains(&kind));
        let span = value.span();
        match value.get_ref() {
            DeValue::Table(table) => {
                let Some((schema, unit)) = of("object") else { return };
                for (key, value) in table {
                    let word = key.get_ref().as_ref();
                    let rest = || schema.get("additionalProperties").filter(|rest| rest.is_object());
                    let property = schema.get("properties").and_then(|keys| keys.get(word)).or_else(rest);
                    if let Some(property) = property {
                        self.value(value, property, unit, word);
                    }
                }
            }
            DeValue::Array(list) => {
                // Of a list of numbers and a list of lists, the one that is there.
                let has_lists = list.first().is_some_and(|item| item.get_ref().is_array());
                let is_alike = |(schema, _): &(&Value, Option<&Value>)| {
                    let items = schema.get("items").map(types).unwrap_or_default();
                    types(schema).contains(&"array") && items.contains(&"array") == has_lists
                };
                let alike = found.iter().copied().find(is_alike);
                let Some((schema, unit)) = alike.or_else(|| of("array")) else { return };
                let Some(items) = schema.get("items") else { return };
                let is_innermost = items.get("type").and_then(Value::as_str) == Some("number");
                let units = unit.and_then(Value::as_array).filter(|_| is_innermost);
                for (place, item) in list.iter().enumerate() {
                    let unit = units.map_or(unit, |units| units.get(place));
                    self.value(item, items, unit, key);
                }
            }
            DeValue::String(expression) => {
                let is_text = |schema: &Value| types(schema).contains(&"string") && words(schema).is_none();
                let known: Vec<&str> =
                    found.iter().filter_map(|(schema, _)| words(schema)).flatten().collect();
                let Some((schema, unit)) = of("number").or_else(|| of("integer")) else { return };
                if found.iter().any(|(schema, _)| is_text(schema)) || known.contains(&expression.as_ref()) {
                    return;
                }
                // A misspelt word, which the schema reports.
                let is_word = is_name(expression)
                    && !self.parameters.entries.contains_key(expression.as_ref())
                    && meaning(expression).is_none();
                if is_word && !known.is_empty() {
                    return;
                }
                let is_whole = !types(schema).contains(&"number");
                match self.number(expression, &span, unit, is_whole, key) {
                    Ok(number) => {
                        self.numbers.push(number);
                        self.spans.push(span);
                    }
                    Err(fault) => {
                        self.wrong.push(span);
                        self.faults.extend(fault);
                    }
                }
            }
            _ => {}
        }
    }

    /// The value of an expression as TOML has it. An error without a fault has been reported.
    fn number(
        &mut self,
        expression: &str,
        span: &Range<usize>,
        unit: Option<&Value>,
        is_whole: bool,
        key: &str,
    ) -> Result<String, Option<Fault>> {
        let value = self.parameters.value(expression, span)?;
        // Numbers of things have no unit.
        let unit = unit.and_then(Value::as_str).or(is_whole.then_some("1"));
        if let (Some(unit), Some(dimension)) = (unit, value.dimension()) {
            let expected = dimension_of(unit);
            if expected.is_some_and(|expected| expected != dimension) {
                let wanted =
                    if unit == "1" { "a number without a unit".to_owned() } else { format!("in {unit}") };
                let message = format!("\"{expression}\" is {dimension}, but {key} is {wanted}");
                return Err(Some(Fault::at(span.clone(), message).label(format!("expected {wanted}"))));
            }
        } else if let Some(dimension) = value.dimension() {
            self.dimensions.insert(span.start, dimension);
        }
        let number = value.number();
        if !is_whole {
            return Ok(format!("{number:?}"));
        }
        if number.fract() != 0.0 || number.abs() > WHOLE {
            let message = format!("\"{expression}\" is {}, but {key} is a whole number", exact(number));
            return Err(Some(Fault::at(span.clone(), message).label("not whole")));
        }
        Ok(format!("{number:.0}"))
    }
}

/// The number of an expression that names no parameters, and its dimension in words; `None` for one that fits
/// any.
///
/// # Errors
/// Says why it has none.
pub fn constant(text: &str) -> Result<(f64, Option<String>), String> {
    let value = expression::parse(text).and_then(|parsed| {
        parsed.value(&mut |name, at| Err(Wrong::new(at, format!("\"{name}\" is no unit and no function"))))
    });
    let value = value.map_err(|wrong| format!("\"{text}\" has no value: {}", wrong.message))?;
    Ok((value.number(), value.dimension().map(|dimension| dimension.to_string())))
}

/// The name of the time inside an expression: not one that a file can have.
const TIME: &str = "the time";

/// The values of a factor that is an expression of the time `t`, s: each time with its value. The time is a
/// number without a unit, as in `exp(-t/1e-3)`, or one with a unit, as in `exp(-t/1ms)`.
///
/// # Errors
/// Says why it has none.
pub(crate) fn of_time(text: &str, times: impl Iterator<Item = f64>) -> Result<Vec<[f64; 2]>, String> {
    let wrong = |wrong: Wrong| format!("\"{text}\" has no value: {}", wrong.message);
    let mut parsed = expression::parse(text).map_err(wrong)?;
    // Alone, `t` would be a tonne.
    parsed.rename("t", TIME);
    let factor = |time: Amount| {
        let value = parsed.value(&mut |name, at| match name {
            TIME => Ok(time),
            _ => Err(Wrong::new(at, format!("\"{name}\" is not the time t, a unit or a function"))),
        })?;
        match value.dimension() {
            None | Some(Dimension::NONE) => Ok(value.number()),
            Some(other) => Err(Wrong::new(
                0..text.len(),
                format!("it is {other}, and a factor is a number without a unit"),
            )),
        }
    };
    let second = units::find("s").map(|(unit, power)| Amount::unit(unit, power));
    let value = |time: f64| {
        let plain = Amount::plain(time);
        let with_unit = second.map_or(plain, |second| plain.times(second));
        let found = factor(plain).or_else(|why| factor(with_unit).map_err(|_| why));
        found.map(|value| [time, value]).map_err(|why| {
            let form =
                "; all its times have a unit, as in \"exp(-t/1ms)\", or none has, as in \"exp(-t/1e-3)\"";
            wrong(why) + if parsed.has_unit() { form } else { "" }
        })
    };
    times.map(value).collect()
}

/// The dimension of a unit of the schema or of a column; none for "1".
pub(crate) fn dimension_of(unit: &str) -> Option<Dimension> {
    if unit == "1" {
        return Some(Dimension::NONE);
    }
    let parsed = expression::parse(unit).ok()?;
    parsed.value(&mut |name, at| Err(Wrong::new(at, name))).ok()?.dimension()
}

/// Length of a unit, m; `None` for other names and for units of other quantities.
pub(crate) fn length_of(unit: &str) -> Option<f64> {
    let (found, power) = units::find(unit)?;
    let is_length = power == 1 && Some(found.dimension) == dimension_of("m");
    is_length.then(|| format!("{}e{}", found.factor, found.tens).parse().ok()).flatten()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]
mod tests;
