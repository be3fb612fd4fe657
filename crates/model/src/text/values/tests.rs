use fdem_scenes::random::Random;

use super::expression::{Expression, Function, Operator};
use super::*;
use crate::text::schema;

fn value(text: &str) -> Result<Amount, Wrong> {
    expression::parse(text)?.value(&mut |name, at| match name {
        "radius" => Ok(Amount::plain(0.025)),
        "edge" => value("40 mm"),
        _ => Err(Wrong::new(at, format!("there is no {name}"))),
    })
}

#[test]
fn expressions_have_the_values_of_arithmetic() {
    for (text, expected) in [
        ("1 + 2*3", 7.0),
        ("(1 + 2)*3", 9.0),
        ("2 - 3 - 4", -5.0),
        ("16/4/2", 2.0),
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("2**3", 8.0),
        ("--2", 2.0),
        ("1_000.5e-1", 100.05),
        (".5", 0.5),
        ("2*radius", 0.05),
        ("sqrt(16)", 4.0),
        ("sin(90)", 1.0),
        ("cos(60 deg)", libm::cos(60_f64.to_radians())),
        ("tan(45)", libm::tan(45_f64.to_radians())),
        ("atan(1)", 45.0),
        ("abs(-3)", 3.0),
        ("min(3, 1, 2)", 1.0),
        ("max(3, 1, 2)", 3.0),
        ("exp(0) + log(1)", 1.0),
        ("pi", std::f64::consts::PI),
    ] {
        assert_eq!(value(text).map(Amount::number), Ok(expected), "{text}");
    }
}

/// A plain number fits any dimension, also with a ratio as a factor; a ratio alone does not.
#[test]
fn a_plain_number_with_a_ratio_is_plain() {
    for (text, expected) in
        [("9.81*sin(30)", None), ("9.81/(2 m / 1 m)", None), ("sin(30)", Some(Dimension::NONE))]
    {
        assert_eq!(value(text).unwrap().dimension(), expected, "{text}");
    }
    assert_eq!(value("2*sin(30)*3 m").unwrap().dimension(), value("1 m").unwrap().dimension());
}

/// Numbers with units, as users write them, are the same to the last bit as without the unit.
#[test]
fn units_shift_the_decimal_point() {
    for (text, expected, dimension) in [
        ("30 GPa", 30e9, "a stress"),
        ("25 mm", 0.025, "a length"),
        ("0.3mm", 0.0003, "a length"),
        ("9.7 um", 9.7e-6, "a length"),
        ("2.7 g/cm^3", 2700.0, "a density"),
        ("2.63 t/m3", 2630.0, "a density"),
        ("2700 kg/m³", 2700.0, "a density"),
        ("5 mm/s", 0.005, "a velocity"),
        ("10 kN", 1e4, "a force"),
        ("1 ms", 1e-3, "a time"),
        ("35 deg", 35.0, "an angle"),
        ("35°", 35.0, "an angle"),
        ("60 J/m^2", 60.0, "an energy per area"),
        ("60 N/m", 60.0, "an energy per area"),
        ("9.81 m/s^2", 9.81, "an acceleration"),
        ("-9.81 m/s²", -9.81, "an acceleration"),
        ("7 %", 0.07, "a number without a unit"),
        ("1 in", 0.0254, "a length"),
        ("2*edge", 0.08, "a length"),
        ("edge + 1 mm", 0.041, "a length"),
        ("edge + 0.01", 0.05, "a length"),
        ("sqrt(edge^2)", 0.04, "a length"),
        ("3*mm", 0.003, "a length"),
        ("(1 + 2) mm", 0.003, "a length"),
        ("max(1 cm, 2 mm)", 0.01, "a length"),
        ("edge/(2 s)", 0.02, "a velocity"),
        ("asin(1)", 90.0, "an angle"),
    ] {
        let found = value(text).map(|value| (value.number(), value.dimension().map(|of| of.to_string())));
        assert_eq!(found, Ok((expected, Some(dimension.to_owned()))), "{text}");
    }
    let half_turn = value("3.141592653589793 rad").map(Amount::number).unwrap();
    assert!((half_turn - 180.0).abs() < 1e-12, "{half_turn}");
}

#[test]
fn what_has_no_value_is_told_with_its_place() {
    for (text, at, message) in [
        ("", "", "it is empty"),
        ("2*", "2*", "it ends where a value is expected"),
        ("2 radius", "radius", "\"radius\" is no unit"),
        ("30 Gpa", "Gpa", "\"Gpa\" is no unit"),
        ("(1 + 2", "(1 + 2", "a parenthesis is not closed"),
        ("0,25", ",", "a comma stands outside of a function"),
        ("1 $ 2", "$", "is not part of an expression"),
        ("1 + x", "x", "there is no x"),
        ("sinus(1)", "sinus", "there is no function \"sinus\""),
        ("sqrt(1, 2)", "sqrt", "takes one value, not 2"),
        ("min(1)", "min", "takes two values or more"),
        ("1/0", "/", "the quotient is not a finite number"),
        ("sqrt(-1)", "sqrt", "not a finite number"),
        ("edge + 1 s", "+", "a length and a time cannot be added"),
        ("edge - 1 s", "-", "a time cannot be taken from a length"),
        ("2^edge", "^", "a length cannot be an exponent"),
        ("exp(edge)", "exp", "a function of a length has no meaning"),
        ("max(edge, 2 s)", "max", "one value is a length, another a time"),
        ("2 mm^x", "x", "the power of a unit is a whole number"),
        ("1e999", "1e999", "is not a number"),
    ] {
        let wrong = value(text).unwrap_err();
        assert!(wrong.message.contains(message), "{text}: {}", wrong.message);
        assert_eq!(&text[wrong.at], at, "{text}");
    }
    let deep = "(".repeat(100_000);
    assert!(value(&deep).unwrap_err().message.contains("longer than"));
    for deep in ["(".repeat(1000), "-".repeat(1000), "2^".repeat(500), "sqrt(".repeat(300)] {
        assert!(value(&deep).unwrap_err().message.contains("inside each other"), "{deep}");
    }
}

/// The expression with all its parentheses.
fn printed(of: &Expression) -> String {
    match of {
        Expression::Number(number) => format!("{number:?}"),
        Expression::Name(name, _) => name.clone(),
        Expression::Scaled(inner, symbol, 1) => format!("(({}) {symbol})", printed(inner)),
        Expression::Scaled(inner, symbol, power) => format!("(({}) {symbol}^{power})", printed(inner)),
        Expression::Negative(inner) => format!("(-{})", printed(inner)),
        Expression::Binary(operator, both, _) => {
            let sign = match operator {
                Operator::Plus => "+",
                Operator::Minus => "-",
                Operator::Times => "*",
                Operator::Over => "/",
                Operator::Power => "^",
            };
            format!("({} {sign} {})", printed(&both[0]), printed(&both[1]))
        }
        Expression::Call(function, values, _) => {
            let (name, _) = Function::ALL.into_iter().find(|(_, known)| known == function).unwrap();
            format!("{name}({})", values.iter().map(printed).collect::<Vec<_>>().join(", "))
        }
    }
}

fn random_expression(random: &mut Random, depth: u64) -> Expression {
    let leaf = depth == 0;
    let inner = |random: &mut Random| Box::new(random_expression(random, depth.saturating_sub(1)));
    match random.below(if leaf { 2 } else { 6 }) {
        0 => Expression::Number(random.between(0.0, 1e3)),
        1 => Expression::Name(["radius", "pi", "mm", "x_1"][random.below(4) as usize].to_owned(), 0..0),
        2 => Expression::Scaled(
            inner(random),
            ["kPa", "m", "deg"][random.below(3) as usize].to_owned(),
            3 - random.below(6) as i32,
        ),
        3 => Expression::Negative(inner(random)),
        4 => {
            use Operator::{Minus, Over, Plus, Power, Times};
            let operator = [Plus, Minus, Times, Over, Power][random.below(5) as usize];
            Expression::Binary(operator, Box::new([*inner(random), *inner(random)]), 0..0)
        }
        _ => {
            let (_, function) = Function::ALL[random.below(12) as usize];
            let count = if matches!(function, Function::Min | Function::Max) { 2 } else { 1 };
            Expression::Call(function, (0..count).map(|_| *inner(random)).collect(), 0..0)
        }
    }
}

#[test]
fn a_printed_expression_is_read_as_it_was() {
    let mut random = Random::new(1);
    for _ in 0..2000 {
        let depth = random.below(5);
        let text = printed(&random_expression(&mut random, depth));
        let read = expression::parse(&text).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"));
        assert_eq!(printed(&read), text);
    }
}

#[test]
fn no_text_makes_the_parser_panic() {
    const PIECES: [&str; 30] = [
        "1", "2.5", "e", "1e", "1e-", ".", "..", "_", "+", "-", "*", "/", "^", "(", ")", ",", " ", "mm",
        "m³", "°", "%", "sqrt", "min", "radius", "é", "岩", "\u{0}", "²", "·", "\"",
    ];
    let mut random = Random::new(2);
    let mut right = 0;
    for _ in 0..50_000 {
        let text: String =
            (0..random.below(12)).map(|_| PIECES[random.below(PIECES.len() as u64) as usize]).collect();
        match value(&text) {
            Ok(_) => right += 1,
            Err(wrong) => {
                assert!(text.get(wrong.at.clone()).is_some(), "{text:?} has no {:?}", wrong.at);
                assert!(!wrong.message.is_empty());
            }
        }
    }
    assert!(right > 500, "only {right} texts were right");
}

/// Every number of the schema says its unit, if it has always the same; a whole number is a count where it
/// says none.
#[test]
fn every_number_of_the_schema_has_a_unit() {
    fn look(
        root: &Value,
        schema: &Value,
        unit: Option<&Value>,
        path: &str,
        wrong: &mut Vec<String>,
        count: &mut usize,
    ) {
        let mut found = Vec::new();
        alternatives(root, schema, unit, &mut found);
        for (schema, unit) in found {
            if types(schema).contains(&"number") {
                *count += 1;
                let units = match unit {
                    Some(Value::String(unit)) => vec![unit.as_str()],
                    Some(Value::Array(units)) => units.iter().filter_map(Value::as_str).collect(),
                    _ => Vec::new(),
                };
                let is_si =
                    |unit: &&str| **unit == *"1" || value(unit).is_ok_and(|value| value.number() == 1.0);
                if units.is_empty() || !units.iter().all(is_si) {
                    wrong.push(path.to_owned());
                }
            }
            let rest = schema.get("additionalProperties").filter(|rest| rest.is_object());
            for inner in schema.get("items").into_iter().chain(rest) {
                look(root, inner, unit, path, wrong, count);
            }
            for (key, property) in schema.get("properties").and_then(Value::as_object).into_iter().flatten() {
                if key != PARAMETERS {
                    look(root, property, unit, &format!("{path}.{key}"), wrong, count);
                }
            }
        }
    }
    let (mut wrong, mut count) = (Vec::new(), 0);
    look(schema::evaluated(), schema::evaluated(), None, "", &mut wrong, &mut count);
    assert!(count > 100, "only {count} numbers");
    // These are in the unit of a column of the history.
    let of_columns = ["until.above", "until.below", "until.least_peak", "servo.target"];
    wrong.retain(|path| !of_columns.iter().any(|key| path.ends_with(key)));
    assert!(wrong.is_empty(), "these need an \"x-unit\" in SI units, or \"1\": {}", wrong.join(", "));
}
