//! The results of a run, before they become a report.

use fdem_bench::Times;
use fdem_bench::peers::sets::Set;

/// A search and how it was called.
#[derive(PartialEq)]
pub(crate) struct Called {
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) how: String,
}

/// The result for one set and one number of threads.
pub(crate) struct Outcome {
    pub(crate) set: &'static Set,
    pub(crate) threads: usize,
    pub(crate) n: usize,
    pub(crate) couples: usize,
    pub(crate) searches: Vec<Searched>,
}

pub(crate) struct Searched {
    pub(crate) name: String,
    pub(crate) ours: bool,
    /// The times, or the reason for their absence.
    pub(crate) times: Result<Option<Times>, String>,
    /// The number of pairs, if a program found a few more or fewer than ours.
    pub(crate) rounded: Option<u64>,
    /// Whether it found other couples than ours.
    pub(crate) wrong: bool,
    /// Bytes that it keeps, if known.
    pub(crate) bytes: Option<usize>,
}

impl Outcome {
    pub(crate) fn search(&self, name: &str) -> Option<&Searched> {
        self.searches.iter().find(|search| search.name == name)
    }

    pub(crate) fn times(&self, name: &str) -> Option<Times> {
        self.search(name)?.times.as_ref().ok().copied().flatten()
    }

    /// The times of the reference search.
    pub(crate) fn ours(&self) -> Option<Times> {
        self.times(&self.searches.first()?.name)
    }

    /// The peer with the smallest median.
    pub(crate) fn fastest_rival(&self) -> Option<(&str, Times)> {
        let rivals = self.searches.iter().filter(|search| !search.ours);
        rivals
            .filter_map(|search| Some((search.name.as_str(), self.times(&search.name)?)))
            .min_by(|a, b| a.1.median.total_cmp(&b.1.median))
    }
}

/// The times of `Rows` for counting the couples of some number of points.
pub(crate) struct Counted {
    pub(crate) n: usize,
    pub(crate) couples: u64,
    pub(crate) bytes: usize,
    /// One entry for each number of threads.
    pub(crate) times: Vec<Times>,
}
