//! What came out of a run, before it is a report.

use fdem_bench::Times;
use fdem_bench::peers::sets::Set;

/// A search and how it was called.
#[derive(PartialEq)]
pub(crate) struct Called {
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) how: String,
}

/// What came out for one set and one number of threads.
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
    /// The times, or why there are none.
    pub(crate) times: Result<Option<Times>, String>,
    /// Pairs, where a program found a few more or fewer than ours.
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

    /// The times of what all are compared with.
    pub(crate) fn ours(&self) -> Option<Times> {
        self.times(&self.searches.first()?.name)
    }

    /// The rival with the least median.
    pub(crate) fn fastest_rival(&self) -> Option<(&str, Times)> {
        let rivals = self.searches.iter().filter(|search| !search.ours);
        rivals
            .filter_map(|search| Some((search.name.as_str(), self.times(&search.name)?)))
            .min_by(|a, b| a.1.median.total_cmp(&b.1.median))
    }
}

/// What `Rows` took to count the couples of so many points.
pub(crate) struct Counted {
    pub(crate) n: usize,
    pub(crate) couples: u64,
    pub(crate) bytes: usize,
    /// For each number of threads.
    pub(crate) times: Vec<Times>,
}
