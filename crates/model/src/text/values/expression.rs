//! Arithmetic in the values of a model file: `2*radius + 5 mm`.
//!
//! ```text
//! sum      = product { ("+" | "-") product }
//! product  = sign { ("*" | "/") sign }
//! sign     = ("-" | "+") sign | power
//! power    = scaled [ "^" sign ]
//! scaled   = primary [ unit [ "^" ["-"] digits ] ]        the unit only after a number or ")"
//! primary  = number | name | name "(" sum { "," sum } ")" | "(" sum ")"
//! ```
//! A unit binds tighter than the signs around it: `2.7 g/cm^3` is (2.7 g)/(cm^3), and a unit alone is one of
//! it.

use std::ops::Range;

use crate::text::fault::nearest;
use crate::text::values::quantity::{Amount, Mismatch};
use crate::text::values::units;

/// Longest expression, bytes.
const LONGEST: usize = 2000;

/// Most parentheses, signs and powers inside each other.
const DEEPEST: u32 = 50;

/// Gives the value of a parameter, with the place of its name in the expression.
pub(crate) type LookUp<'l> = dyn FnMut(&str, Range<usize>) -> Result<Amount, Wrong> + 'l;

/// The parsed form of an expression.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Expression {
    Number(f64),
    /// A parameter, a constant, or a unit without a number.
    Name(String, Range<usize>),
    /// An expression with a unit behind it, and the power of the unit.
    Scaled(Box<Self>, String, i32),
    Negative(Box<Self>),
    Binary(Operator, Box<[Self; 2]>, Range<usize>),
    Call(Function, Vec<Self>, Range<usize>),
}

/// The operator between two expressions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Operator {
    Plus,
    Minus,
    Times,
    Over,
    Power,
}

/// A function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Function {
    Sqrt,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Abs,
    Exp,
    Log,
    Min,
    Max,
}

impl Function {
    pub(crate) const ALL: [(&'static str, Self); 12] = [
        ("sqrt", Self::Sqrt),
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("asin", Self::Asin),
        ("acos", Self::Acos),
        ("atan", Self::Atan),
        ("abs", Self::Abs),
        ("exp", Self::Exp),
        ("log", Self::Log),
        ("min", Self::Min),
        ("max", Self::Max),
    ];

    fn of(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
    }

    /// Whether it takes two values or more, and not one.
    fn takes_several(self) -> bool {
        matches!(self, Self::Min | Self::Max)
    }
}

/// Why an expression has no value, and which bytes of it are to blame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Wrong {
    pub(crate) at: Range<usize>,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

impl Wrong {
    pub(crate) fn new(at: Range<usize>, message: impl Into<String>) -> Self {
        Self { at, message: message.into(), help: None }
    }

    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}

/// Whether a name means something in every expression, so that no parameter can have it.
pub(crate) fn meaning(name: &str) -> Option<&'static str> {
    match () {
        () if name == "pi" => Some("a constant"),
        () if Function::of(name).is_some() => Some("a function"),
        () if units::find(name).is_some() => Some("a unit"),
        () => None,
    }
}

/// Whether an expression can name a parameter so.
pub(crate) fn is_name(text: &str) -> bool {
    let mut characters = text.chars();
    characters.next().is_some_and(|c| c.is_alphabetic() || c == '_')
        && characters.all(|c| c.is_alphanumeric() || c == '_')
}

/// A piece of the text.
#[derive(Debug, Clone, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Sign(char),
}

/// Reads an expression.
///
/// # Errors
/// The text is not an expression, or is too long or too deep.
pub(crate) fn parse(text: &str) -> Result<Expression, Wrong> {
    if text.len() > LONGEST {
        return Err(Wrong::new(0..text.len(), format!("an expression is longer than {LONGEST} characters")));
    }
    let tokens = tokens(text)?;
    let mut parser = Parser { tokens: &tokens, next: 0, end: text.len(), depth: 0 };
    let expression = parser.sum()?;
    match parser.peek() {
        None => Ok(expression),
        Some((token, at)) => Err(unexpected(token, at.clone())),
    }
}

fn unexpected(token: &Token, at: Range<usize>) -> Wrong {
    match token {
        Token::Number(_) => Wrong::new(at, "a number stands where a sign is expected"),
        Token::Name(name) => Wrong::new(at, format!("\"{name}\" stands where a sign is expected"))
            .help("write a sign between two values, such as *"),
        Token::Sign(',') => Wrong::new(at, "a comma stands outside of a function")
            .help("numbers have a decimal point, not a comma"),
        Token::Sign(sign) => Wrong::new(at, format!("\"{sign}\" is out of place")),
    }
}

fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, Wrong> {
    let mut tokens = Vec::new();
    let mut start = 0;
    while let Some(c) = text[start..].chars().next() {
        let rest = &text[start..];
        let (token, length) = if c.is_whitespace() {
            start += c.len_utf8();
            continue;
        } else if c.is_ascii_digit() || c == '.' {
            let length = number_length(rest);
            let number =
                rest[..length].replace('_', "").parse().ok().filter(|number: &f64| number.is_finite());
            let number = number.ok_or_else(|| {
                Wrong::new(start..start + length, format!("\"{}\" is not a number", &rest[..length]))
            })?;
            (Token::Number(number), length)
        } else if c.is_alphabetic() || "_°%".contains(c) {
            let length =
                rest.find(|c: char| !(c.is_alphanumeric() || "_°%".contains(c))).unwrap_or(rest.len());
            (Token::Name(rest[..length].to_owned()), length)
        } else if rest.starts_with("**") {
            (Token::Sign('^'), 2)
        } else if let Some(sign) = "+-*/^(),".chars().find(|sign| *sign == c) {
            (Token::Sign(sign), 1)
        } else if let Some((_, sign)) =
            [('·', '*'), ('×', '*'), ('−', '-')].iter().find(|(other, _)| *other == c)
        {
            (Token::Sign(*sign), c.len_utf8())
        } else {
            let shown = if c.is_control() { '?' } else { c };
            return Err(Wrong::new(
                start..start + c.len_utf8(),
                format!("\"{shown}\" is not part of an expression"),
            ));
        };
        tokens.push((token, start..start + length));
        start += length;
    }
    Ok(tokens)
}

/// The length of the number with which a text starts: `1_000.5e-3`.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| {
        let bytes = text.as_bytes().get(from..).unwrap_or_default();
        bytes.iter().take_while(|byte| byte.is_ascii_digit() || **byte == b'_').count()
    };
    let mut length = digits(0);
    if text[length..].starts_with('.') {
        length += 1 + digits(length + 1);
    }
    let exponent =
        text[length..].strip_prefix(['e', 'E']).map(|rest| usize::from(rest.starts_with(['+', '-'])));
    if let Some(sign) = exponent {
        let found = digits(length + 1 + sign);
        if found > 0 {
            length += 1 + sign + found;
        }
    }
    length
}

struct Parser<'t> {
    tokens: &'t [(Token, Range<usize>)],
    next: usize,
    /// Length of the text.
    end: usize,
    depth: u32,
}

impl<'t> Parser<'t> {
    fn peek(&self) -> Option<&'t (Token, Range<usize>)> {
        self.tokens.get(self.next)
    }

    /// Takes the next token if it is one of these signs.
    fn take(&mut self, signs: &str) -> Option<(char, Range<usize>)> {
        match self.peek() {
            Some((Token::Sign(sign), at)) if signs.contains(*sign) => {
                self.next += 1;
                Some((*sign, at.clone()))
            }
            _ => None,
        }
    }

    fn deeper<T>(&mut self, inner: impl FnOnce(&mut Self) -> Result<T, Wrong>) -> Result<T, Wrong> {
        if self.depth == DEEPEST {
            let message =
                format!("an expression has more than {DEEPEST} parentheses or signs inside each other");
            return Err(Wrong::new(0..self.end, message));
        }
        self.depth += 1;
        let found = inner(self)?;
        self.depth -= 1;
        Ok(found)
    }

    fn sum(&mut self) -> Result<Expression, Wrong> {
        let mut left = self.product()?;
        while let Some((sign, at)) = self.take("+-") {
            let operator = if sign == '+' { Operator::Plus } else { Operator::Minus };
            left = Expression::Binary(operator, Box::new([left, self.product()?]), at);
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Expression, Wrong> {
        let mut left = self.sign()?;
        while let Some((sign, at)) = self.take("*/") {
            let operator = if sign == '*' { Operator::Times } else { Operator::Over };
            left = Expression::Binary(operator, Box::new([left, self.sign()?]), at);
        }
        Ok(left)
    }

    fn sign(&mut self) -> Result<Expression, Wrong> {
        match self.take("+-") {
            Some(('-', _)) => Ok(Expression::Negative(Box::new(self.deeper(Self::sign)?))),
            Some(_) => self.deeper(Self::sign),
            None => self.power(),
        }
    }

    fn power(&mut self) -> Result<Expression, Wrong> {
        let base = self.scaled()?;
        let Some((_, at)) = self.take("^") else { return Ok(base) };
        let exponent = self.deeper(Self::sign)?;
        Ok(Expression::Binary(Operator::Power, Box::new([base, exponent]), at))
    }

    fn scaled(&mut self) -> Result<Expression, Wrong> {
        let value = self.primary()?;
        let before = self.tokens.get(self.next.wrapping_sub(1));
        let may_have_unit = matches!(before, Some((Token::Number(_) | Token::Sign(')'), _)));
        let Some((Token::Name(symbol), at)) = self.peek().filter(|_| may_have_unit) else { return Ok(value) };
        let Some((_, written)) = units::find(symbol) else { return Err(no_unit(symbol, at.clone())) };
        self.next += 1;
        let mut power = 1;
        if written == 1 && self.take("^").is_some() {
            let negative = self.take("-").is_some();
            power = match self.peek() {
                Some((Token::Number(number), _)) if number.fract() == 0.0 && number.abs() <= 12.0 => {
                    *number as i32
                }
                Some((_, at)) => {
                    return Err(Wrong::new(at.clone(), "the power of a unit is a whole number up to 12"));
                }
                None => return Err(self.ended()),
            };
            self.next += 1;
            power *= if negative { -1 } else { 1 };
        }
        Ok(Expression::Scaled(Box::new(value), symbol.clone(), power))
    }

    fn primary(&mut self) -> Result<Expression, Wrong> {
        let Some((token, at)) = self.peek() else { return Err(self.ended()) };
        self.next += 1;
        match token {
            Token::Number(number) => Ok(Expression::Number(*number)),
            Token::Name(name) => match self.take("(") {
                Some(_) => self.call(name, at.clone()),
                None => Ok(Expression::Name(name.clone(), at.clone())),
            },
            Token::Sign('(') => {
                let inner = self.deeper(Self::sum)?;
                self.close()?;
                Ok(inner)
            }
            Token::Sign(sign) => {
                Err(Wrong::new(at.clone(), format!("\"{sign}\" stands where a value is expected")))
            }
        }
    }

    fn call(&mut self, name: &str, at: Range<usize>) -> Result<Expression, Wrong> {
        let Some(function) = Function::of(name) else {
            let names = Function::ALL.map(|(name, _)| name);
            let near = nearest(name, names).map(|near| format!("did you mean \"{near}\"?"));
            let help = near.unwrap_or_else(|| format!("there is {}", names.join(", ")));
            return Err(Wrong::new(at, format!("there is no function \"{name}\"")).help(help));
        };
        let mut values = vec![self.deeper(Self::sum)?];
        while self.take(",").is_some() {
            values.push(self.deeper(Self::sum)?);
        }
        self.close()?;
        match (function.takes_several(), values.len()) {
            (false, 1) | (true, 2..) => Ok(Expression::Call(function, values, at)),
            (false, count) => Err(Wrong::new(at, format!("{name} takes one value, not {count}"))),
            (true, _) => Err(Wrong::new(at, format!("{name} takes two values or more"))),
        }
    }

    fn close(&mut self) -> Result<(), Wrong> {
        match (self.take(")"), self.peek()) {
            (Some(_), _) => Ok(()),
            (None, Some((token, at))) => Err(unexpected(token, at.clone())),
            (None, None) => Err(Wrong::new(0..self.end, "a parenthesis is not closed")),
        }
    }

    fn ended(&self) -> Wrong {
        let message =
            if self.tokens.is_empty() { "it is empty" } else { "it ends where a value is expected" };
        Wrong::new(0..self.end, message)
    }
}

fn no_unit(symbol: &str, at: Range<usize>) -> Wrong {
    let alike = units::symbols().find(|known| known.eq_ignore_ascii_case(symbol));
    let near = alike.or_else(|| nearest(symbol, units::symbols()));
    let help = match near {
        Some(near) => format!("did you mean \"{near}\"?"),
        None => format!("if it is a parameter, write a sign before it, such as *{symbol}"),
    };
    Wrong::new(at, format!("\"{symbol}\" is no unit")).help(help)
}

impl Expression {
    /// Replaces a name that stands alone, also one that is a unit otherwise.
    pub(crate) fn rename(&mut self, from: &str, to: &str) {
        match self {
            Self::Number(_) => {}
            Self::Name(name, _) => {
                if name == from {
                    to.clone_into(name);
                }
            }
            Self::Scaled(inner, ..) | Self::Negative(inner) => inner.rename(from, to),
            Self::Binary(_, both, _) => both.iter_mut().for_each(|one| one.rename(from, to)),
            Self::Call(_, values, _) => values.iter_mut().for_each(|value| value.rename(from, to)),
        }
    }

    /// Whether a unit stands anywhere in it.
    pub(crate) fn has_unit(&self) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Name(name, _) => units::find(name).is_some(),
            Self::Scaled(..) => true,
            Self::Negative(inner) => inner.has_unit(),
            Self::Binary(_, both, _) => both.iter().any(Self::has_unit),
            Self::Call(_, values, _) => values.iter().any(Self::has_unit),
        }
    }

    /// The value. `look_up`: that of a parameter, if there is one of this name.
    ///
    /// # Errors
    /// Names that mean nothing, sums of unlike dimensions, and values that are not finite.
    pub(crate) fn value(&self, look_up: &mut LookUp<'_>) -> Result<Amount, Wrong> {
        let finite = |quantity: Amount, at: &Range<usize>, what: &str| {
            if quantity.number().is_finite() {
                Ok(quantity)
            } else {
                Err(Wrong::new(at.clone(), format!("{what} is not a finite number")))
            }
        };
        match self {
            Self::Number(number) => Ok(Amount::plain(*number)),
            Self::Name(name, _) if name == "pi" => Ok(Amount::plain(std::f64::consts::PI)),
            Self::Name(name, at) => match units::find(name) {
                Some((unit, power)) => Ok(Amount::unit(unit, power)),
                None => look_up(name, at.clone()),
            },
            Self::Scaled(inner, symbol, power) => {
                let Some((unit, written)) = units::find(symbol) else {
                    return Err(Wrong::new(0..0, format!("\"{symbol}\" is no unit")));
                };
                Ok(inner.value(look_up)?.in_units(unit, written * power))
            }
            Self::Negative(inner) => Ok(inner.value(look_up)?.negative()),
            Self::Binary(operator, both, at) => {
                let [one, other] = &**both;
                let (one, other) = (one.value(look_up)?, other.value(look_up)?);
                let (result, what) = match operator {
                    Operator::Plus => (one.plus(other), "the sum"),
                    Operator::Minus => (one.plus(other.negative()), "the difference"),
                    Operator::Times => (Ok(one.times(other)), "the product"),
                    Operator::Over => (Ok(one.over(other)), "the quotient"),
                    Operator::Power => (one.power(other), "the power"),
                };
                finite(result.map_err(|why| mismatch(*operator, &why, at.clone()))?, at, what)
            }
            Self::Call(function, values, at) => {
                let values: Result<Vec<Amount>, Wrong> =
                    values.iter().map(|value| value.value(look_up)).collect();
                let result = call(*function, &values?).map_err(|why| match why {
                    Mismatch::Two(one, other) => {
                        Wrong::new(at.clone(), format!("one value is {one}, another {other}"))
                    }
                    Mismatch::One(one) => {
                        Wrong::new(at.clone(), format!("a function of {one} has no meaning"))
                    }
                })?;
                finite(result, at, "the value of the function")
            }
        }
    }
}

fn mismatch(operator: Operator, why: &Mismatch, at: Range<usize>) -> Wrong {
    let message = match (operator, why) {
        (Operator::Plus, Mismatch::Two(one, other)) => format!("{one} and {other} cannot be added"),
        (Operator::Minus, Mismatch::Two(one, other)) => format!("{other} cannot be taken from {one}"),
        (_, Mismatch::Two(one, other)) => format!("{one} and {other} do not go together"),
        (_, Mismatch::One(one)) => format!("{one} cannot be an exponent, or be raised to this one"),
    };
    Wrong::new(at, message)
}

/// The value of a function. Angles are in degrees.
fn call(function: Function, values: &[Amount]) -> Result<Amount, Mismatch> {
    let [first, rest @ ..] = values else { return Ok(Amount::plain(f64::NAN)) };
    let of_angle = |f: fn(f64) -> f64| first.angle().map(|angle| Amount::ratio(f(angle.to_radians())));
    let to_angle = |f: fn(f64) -> f64| first.pure().map(|ratio| Amount::degrees(f(ratio).to_degrees()));
    match function {
        Function::Sqrt => first.power(Amount::plain(0.5)),
        Function::Sin => of_angle(libm::sin),
        Function::Cos => of_angle(libm::cos),
        Function::Tan => of_angle(libm::tan),
        Function::Asin => to_angle(libm::asin),
        Function::Acos => to_angle(libm::acos),
        Function::Atan => to_angle(libm::atan),
        Function::Abs => Ok(if first.number() < 0.0 { first.negative() } else { *first }),
        Function::Exp => first.pure().map(|ratio| Amount::plain(libm::exp(ratio))),
        Function::Log => first.pure().map(|ratio| Amount::plain(libm::log(ratio))),
        Function::Min => rest.iter().try_fold(*first, |least, other| least.least(*other)),
        Function::Max => {
            let negative =
                rest.iter().try_fold(first.negative(), |least, other| least.least(other.negative()));
            negative.map(Amount::negative)
        }
    }
}
