//! The result of one body of one size.

use std::fmt;

/// Begins the names of the runs on other vector instructions.
const ON: &str = "on:";

/// The name of the version before.
const BEFORE: &str = "before";

/// The result, printed as words in one line.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Outcome {
    pub(crate) elements: usize,
    /// Steps in each timing.
    pub(crate) steps: u64,
    /// Mean number of contacts at the ends of the timings: of this version and of the version before.
    pub(crate) contacts: [f64; 2],
    pub(crate) detections: u64,
    pub(crate) broken: usize,
    /// Peak memory in bytes per element, minus the memory of the process before.
    pub(crate) memory: f64,
    /// Shares of bulk, joints, detection, contact and integration, on one thread.
    pub(crate) shares: [f64; 5],
    /// Seconds of one step in each round: on one thread, and of everything that took turns with it.
    pub(crate) seconds: Vec<(Program, Vec<f64>)>,
}

/// A program or a setting that is timed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Program {
    /// This version on one thread.
    One,
    /// This version on several threads.
    Many,
    /// The version before on one thread.
    Before,
    /// This version on one thread and other vector instructions.
    On(String),
    /// Another program.
    Other(String),
}

impl fmt::Display for Program {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One => out.write_str("one"),
            Self::Many => out.write_str("many"),
            Self::Before => out.write_str(BEFORE),
            Self::On(level) => write!(out, "{ON}{level}"),
            Self::Other(name) => out.write_str(name),
        }
    }
}

impl From<&str> for Program {
    fn from(name: &str) -> Self {
        match name {
            "one" => Self::One,
            "many" => Self::Many,
            BEFORE => Self::Before,
            _ => match name.strip_prefix(ON) {
                Some(level) => Self::On(level.to_owned()),
                None => Self::Other(name.to_owned()),
            },
        }
    }
}

impl Outcome {
    /// Seconds of one step in each round; `None` if the program was not timed.
    pub(crate) fn samples(&self, program: &Program) -> Option<&[f64]> {
        self.seconds.iter().find(|(other, _)| other == program).map(|(_, samples)| samples.as_slice())
    }

    /// Element-steps per second, by the median over the rounds.
    pub(crate) fn rate(&self, program: &Program) -> Option<f64> {
        self.samples(program).map(|samples| self.elements as f64 / median(samples))
    }

    /// Element-steps per second on one thread.
    pub(crate) fn one(&self) -> f64 {
        self.rate(&Program::One).unwrap_or(f64::NAN)
    }

    /// The spread of the rounds: the longest without the shortest, over the median.
    pub(crate) fn spread(&self, program: &Program) -> Option<f64> {
        self.samples(program).map(|samples| {
            let [low, high] = range(samples);
            (high - low) / median(samples)
        })
    }

    /// Time of the earlier version over the time of this one: median, least and most of the rounds.
    pub(crate) fn faster(&self) -> Option<[f64; 3]> {
        let (ours, theirs) = (self.samples(&Program::One)?, self.samples(&Program::Before)?);
        let ratios: Vec<f64> = theirs.iter().zip(ours).map(|(theirs, ours)| theirs / ours).collect();
        let [low, high] = range(&ratios);
        Some([median(&ratios), low, high])
    }

    /// Names and element-steps per second of other programs.
    pub(crate) fn others(&self) -> impl Iterator<Item = (&str, f64)> {
        self.seconds.iter().filter_map(|(program, samples)| match program {
            Program::Other(name) => Some((name.as_str(), self.elements as f64 / median(samples))),
            _ => None,
        })
    }

    /// Names and element-steps per second of the vector instructions that were compared with those chosen, on
    /// one thread.
    pub(crate) fn levels(&self) -> impl Iterator<Item = (&str, f64)> {
        self.seconds.iter().filter_map(|(program, samples)| match program {
            Program::On(level) => Some((level.as_str(), self.elements as f64 / median(samples))),
            _ => None,
        })
    }

    /// Parses the line that [`fmt::Display`] writes.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let mut words = text.split_whitespace();
        let mut outcome = Self {
            elements: words.next()?.parse().ok()?,
            steps: words.next()?.parse().ok()?,
            contacts: [words.next()?.parse().ok()?, words.next()?.parse().ok()?],
            detections: words.next()?.parse().ok()?,
            broken: words.next()?.parse().ok()?,
            memory: words.next()?.parse().ok()?,
            ..Self::default()
        };
        for share in &mut outcome.shares {
            *share = words.next()?.parse().ok()?;
        }
        while let Some(name) = words.next() {
            let samples =
                words.next()?.split(',').map(|sample| sample.parse().ok()).collect::<Option<_>>()?;
            outcome.seconds.push((name.into(), samples));
        }
        outcome.samples(&Program::One).is_some().then_some(outcome)
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [ours, theirs] = self.contacts;
        write!(
            out,
            "{} {} {ours} {theirs} {} {} {}",
            self.elements, self.steps, self.detections, self.broken, self.memory
        )?;
        for share in self.shares {
            write!(out, " {share}")?;
        }
        for (program, samples) in &self.seconds {
            let samples: Vec<String> = samples.iter().map(ToString::to_string).collect();
            write!(out, " {program} {}", samples.join(","))?;
        }
        Ok(())
    }
}

/// The middle of the samples. There is at least one.
fn median(samples: &[f64]) -> f64 {
    let mut samples = samples.to_vec();
    samples.sort_unstable_by(f64::total_cmp);
    f64::midpoint(samples[(samples.len() - 1) / 2], samples[samples.len() / 2])
}

/// The least and the largest of the samples.
fn range(samples: &[f64]) -> [f64; 2] {
    let least = samples.iter().copied().fold(f64::INFINITY, f64::min);
    [least, samples.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome() -> Outcome {
        Outcome {
            elements: 100,
            steps: 7,
            contacts: [110.0, 110.5],
            detections: 3,
            broken: 2,
            memory: 352.25,
            shares: [0.5, 0.25, 0.125, 0.0625, 0.0625],
            seconds: vec![
                (Program::One, vec![2.0, 1.0, 4.0]),
                (Program::Before, vec![3.0, 2.0, 4.0]),
                (Program::On("avx2".to_owned()), vec![2.5; 3]),
                (Program::Other("akantu".to_owned()), vec![20.0; 3]),
            ],
        }
    }

    #[test]
    fn a_line_is_read_as_it_was_written() {
        assert_eq!(Outcome::read(&outcome().to_string()), Some(outcome()));
        assert_eq!(Outcome::read("100 7 1 1 3 2 352 0 0 0 0 0 many 1"), None, "nothing on one thread");
        assert_eq!(Outcome::read(""), None);
    }

    #[test]
    fn rates_are_those_of_the_median_and_ratios_are_taken_round_by_round() {
        let outcome = outcome();
        assert_eq!(outcome.one(), 50.0);
        assert_eq!(outcome.rate(&Program::Many), None);
        assert_eq!(outcome.spread(&Program::One), Some(1.5));
        assert_eq!(outcome.faster(), Some([1.5, 1.0, 2.0]));
        assert_eq!(outcome.levels().collect::<Vec<_>>(), [("avx2", 40.0)]);
        assert_eq!(outcome.others().collect::<Vec<_>>(), [("akantu", 5.0)]);
    }
}
