//! The option `--cutoff`: one distance, or a distance for each pair of types.

use std::fmt;
use std::str::FromStr;

use fdem_io::Types;
use fdem_results::network::PairCutoffs;
use serde::Serialize;

use crate::command::lengths::length;

/// Distances at which points touch.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cutoff {
    /// One for all.
    All(f64),
    /// One for each of these pairs of types, each listed once.
    Pairs(Vec<PairCutoff>),
}

/// The distance at which points of two types touch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct PairCutoff {
    types: [String; 2],
    cutoff: f64,
}

impl fmt::Display for PairCutoff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = &self.types;
        write!(f, "{a}-{b}={}", self.cutoff)
    }
}

impl FromStr for Cutoff {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if !text.contains('=') {
            return length(text).map(Self::All);
        }
        let mut pairs: Vec<PairCutoff> = Vec::new();
        for entry in text.split(',') {
            let pair: PairCutoff = entry.trim().parse()?;
            match pairs.iter().find(|earlier| earlier.is_of(&pair.types)) {
                None => pairs.push(pair),
                Some(earlier) if earlier.cutoff == pair.cutoff => {}
                Some(earlier) => return Err(format!("{earlier} and {pair} are of the same pair")),
            }
        }
        Ok(Self::Pairs(pairs))
    }
}

impl FromStr for PairCutoff {
    type Err = String;

    fn from_str(entry: &str) -> Result<Self, String> {
        let wrong = || format!("'{entry}' is not TYPE-TYPE=D, such as H-C=1.3");
        let (pair, cutoff) = entry.rsplit_once('=').ok_or_else(wrong)?;
        let (a, b) = pair.split_once('-').ok_or_else(wrong)?;
        if b.contains('-') {
            return Err(format!(
                "'{entry}' has more than one '-' before '=': which one separates the types?"
            ));
        }
        let types = [a, b].map(|name| name.trim().to_owned());
        if types.iter().any(String::is_empty) {
            return Err(wrong());
        }
        Ok(Self { types, cutoff: length(cutoff.trim()).map_err(|problem| format!("{entry}: {problem}"))? })
    }
}

impl Cutoff {
    /// The largest distance.
    pub(crate) fn largest(&self) -> f64 {
        match self {
            Self::All(cutoff) => *cutoff,
            Self::Pairs(pairs) => pairs.iter().map(|pair| pair.cutoff).fold(0.0, f64::max),
        }
    }

    /// The distances by pairs of types.
    pub(crate) fn pairs(&self) -> Option<&[PairCutoff]> {
        match self {
            Self::All(_) => None,
            Self::Pairs(pairs) => Some(pairs),
        }
    }
}

impl PairCutoff {
    /// Whether these are the two types, in either order.
    fn is_of(&self, [a, b]: &[String; 2]) -> bool {
        let [c, d] = &self.types;
        (a == c && b == d) || (a == d && b == c)
    }
}

/// The cut-off of each two elements with these types. `column` is the column of the types.
///
/// # Errors
/// A type that no element has, unless there are no elements.
pub(crate) fn of_types(pairs: &[PairCutoff], types: &Types, column: &str) -> Result<PairCutoffs, String> {
    let mut numbered = Vec::new();
    if !types.of.is_empty() {
        for pair in pairs {
            let [a, b] = pair.types.each_ref().map(|name| {
                let number = types.names.iter().position(|known| known == name);
                number.ok_or_else(|| unknown(pair, name, types, column))
            });
            numbered.push(([a? as u32, b? as u32], pair.cutoff));
        }
    }
    PairCutoffs::new(&types.of, &numbered).map_err(|error| format!("--cutoff: {error}"))
}

fn unknown(pair: &PairCutoff, name: &str, types: &Types, column: &str) -> String {
    /// Largest number of types listed in a message: another column may have one for each element.
    const SHOWN: usize = 20;
    let mut known: Vec<String> = types.names.iter().map(|name| name.escape_debug().to_string()).collect();
    known.sort_unstable();
    if known.len() > SHOWN {
        let all = known.len();
        known.truncate(SHOWN);
        known.push(format!("… ({all} in all)"));
    }
    format!(
        "--cutoff {pair}: no element has the type {name}. The types in column {column} are {}",
        known.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cutoff_is_a_number_or_pairs() {
        let pair = |a: &str, b: &str, cutoff| PairCutoff { types: [a, b].map(str::to_owned), cutoff };
        assert_eq!("1.5".parse(), Ok(Cutoff::All(1.5)));
        let pairs = vec![pair("H", "C", 1.3), pair("1", "1", 2.0)];
        assert_eq!(" H - C=1.3, 1-1=2,C-H=1.30".parse(), Ok(Cutoff::Pairs(pairs)));
        for (text, problem) in [
            ("H-C", "'H-C' is not a number"),
            ("-1", "negative"),
            ("H-C=-1", "H-C=-1: '-1' is negative"),
            ("H-C=nan", "not a finite number"),
            ("H-C=1,3", "'3' is not TYPE-TYPE=D"),
            ("HC=1", "'HC=1' is not TYPE-TYPE=D"),
            ("-C=1", "'-C=1' is not TYPE-TYPE=D"),
            ("H-C=1,", "'' is not TYPE-TYPE=D"),
            ("H-C-O=1", "more than one '-'"),
            ("H-C=1,C-H=2", "H-C=1 and C-H=2 are of the same pair"),
        ] {
            let error = text.parse::<Cutoff>().unwrap_err();
            assert!(error.contains(problem), "{text}: {error}");
        }
    }
}
