//! A case of the ladder, and its results: quantities with their errors and bounds.

/// Size of the models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Smallest models for which the theory holds: all cases take some minutes.
    Reduced,
    /// Finer models and more variants: all cases take an hour or more.
    Full,
}

impl Size {
    pub(crate) fn choose<T>(self, reduced: T, full: T) -> T {
        match self {
            Self::Reduced => reduced,
            Self::Full => full,
        }
    }
}

/// Unit of an error and its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// A share of the expected value.
    Relative,
    /// The unit of the quantity.
    Absolute,
    /// Nothing was compared, because published data are absent.
    Skipped,
}

/// A quantity: its expected value and the value that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Name of the quantity.
    pub quantity: String,
    /// Value by theory.
    pub expected: f64,
    /// Value by the simulation.
    pub found: f64,
    /// Unit of both values; empty for a number.
    pub unit: &'static str,
    /// Found value less the expected one, as `measure` says.
    pub error: f64,
    /// Largest size of the error that passes.
    pub bound: f64,
    /// Unit of the error and the bound.
    pub measure: Measure,
}

impl Outcome {
    /// An outcome whose error is a share of the expected value.
    pub fn relative(
        quantity: impl Into<String>,
        expected: f64,
        found: f64,
        bound: f64,
        unit: &'static str,
    ) -> Self {
        let error = found / expected - 1.0;
        Self { quantity: quantity.into(), expected, found, unit, error, bound, measure: Measure::Relative }
    }

    /// An outcome whose error has the unit of the quantity.
    pub fn absolute(
        quantity: impl Into<String>,
        expected: f64,
        found: f64,
        bound: f64,
        unit: &'static str,
    ) -> Self {
        let error = found - expected;
        Self { quantity: quantity.into(), expected, found, unit, error, bound, measure: Measure::Absolute }
    }

    /// A quantity that cannot be compared, for a reason: published data that are absent. It passes.
    pub fn skipped(quantity: impl Into<String>, why: &str) -> Self {
        let quantity = format!("{}: {why}", quantity.into());
        let [expected, found, error, bound] = [0.0; 4];
        Self { quantity, expected, found, unit: "", error, bound, measure: Measure::Skipped }
    }

    /// Whether the error is within its bound. An error that is not a number is not.
    pub fn passed(&self) -> bool {
        self.error.abs() <= self.bound
    }
}

/// A case with a known answer.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Number in the ladder. Cases of one kind may share it.
    pub number: u32,
    /// Short name.
    pub name: &'static str,
    /// The model and the theory that it is compared with, in a few sentences.
    pub what: &'static str,
    /// Source of the answer.
    pub source: &'static str,
    /// Runs the models and compares the results. The error says why a run did not reach its end.
    pub run: fn(Size) -> Result<Vec<Outcome>, String>,
}

impl Case {
    /// Runs the case.
    pub fn report(&'static self, size: Size) -> CaseReport {
        CaseReport { case: self, result: (self.run)(size) }
    }
}

/// Result of a case.
#[derive(Clone, Debug)]
pub struct CaseReport {
    /// The case.
    pub case: &'static Case,
    /// The comparisons, or the reason why a run did not reach its end.
    pub result: Result<Vec<Outcome>, String>,
}

impl CaseReport {
    /// Whether the case ran, compared at least one quantity, and found all of them within their bounds.
    pub fn passed(&self) -> bool {
        matches!(&self.result, Ok(outcomes) if !outcomes.is_empty() && outcomes.iter().all(Outcome::passed))
    }
}
