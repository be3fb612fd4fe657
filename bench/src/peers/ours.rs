//! Our own searches.

use fdem_contact::{Couple, Detector, Error, Nbs, Rows, Search, Simd};

use super::bodies::Bodies;
use super::peer::Peer;

/// The kinds of our searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngineKind {
    /// `Rows`, with memory kept from call to call.
    Rows,
    /// `Rows` limited to AVX2.
    RowsAvx2,
    /// `Rows`, with memory kept from call to call, but a new list of couples in every call.
    RowsFresh,
    /// `Rows`, with all memory, including that of the couples, allocated in every call.
    RowsCold,
    /// `Nbs`, with memory kept from call to call.
    Nbs,
    /// `Detector`, which chooses the engine, with memory kept from call to call.
    Auto,
}

impl EngineKind {
    /// All kinds.
    pub const ALL: [Self; 6] =
        [Self::Rows, Self::RowsAvx2, Self::RowsFresh, Self::RowsCold, Self::Nbs, Self::Auto];
    /// The kinds for points with one cut-off.
    pub const OF_POINTS: [Self; 5] = [Self::Rows, Self::RowsAvx2, Self::RowsFresh, Self::RowsCold, Self::Nbs];
    /// The kinds for unlike sizes and boxes: levels, and a grid of one level for comparison.
    pub const OF_UNLIKE: [Self; 2] = [Self::Auto, Self::Rows];

    /// Name in the tables and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rows => "rows",
            Self::RowsAvx2 => "rows-avx2",
            Self::RowsFresh => "rows-fresh",
            Self::RowsCold => "rows-cold",
            Self::Nbs => "nbs",
            Self::Auto => "auto",
        }
    }

    /// Whether this processor has the instructions.
    pub fn is_available(self) -> bool {
        self != Self::RowsAvx2 || Simd::Avx2.is_available()
    }
}

pub(super) struct Ours<const D: usize> {
    kind: EngineKind,
    simd: Simd,
    threads: usize,
    rows: Rows<f64, D>,
    nbs: Nbs<D>,
    detector: Detector<f64, D>,
}

impl<const D: usize> Ours<D> {
    pub(super) fn new(kind: EngineKind, simd: Simd, threads: usize) -> Result<Self, Error> {
        let simd = if kind == EngineKind::RowsAvx2 { Simd::Avx2 } else { simd };
        let rows = Rows::new().with_simd(simd)?.with_threads(threads)?;
        let detector = Detector::new().with_simd(simd)?.with_threads(threads)?;
        Ok(Self { kind, simd, threads, rows, nbs: Nbs::new(), detector })
    }

    fn search(
        &mut self,
        bodies: Bodies<'_, D>,
        couples: &mut Vec<Couple>,
    ) -> Result<(), fdem_contact::Error> {
        let elements = bodies.elements()?;
        match self.kind {
            EngineKind::Rows | EngineKind::RowsAvx2 => self.rows.couples(&elements, couples),
            EngineKind::RowsFresh => {
                *couples = Vec::new();
                self.rows.couples(&elements, couples)
            }
            EngineKind::RowsCold => {
                *couples = Vec::new();
                let mut rows = Rows::new().with_simd(self.simd)?.with_threads(self.threads)?;
                rows.couples(&elements, couples)
            }
            EngineKind::Nbs => self.nbs.couples(&elements, couples),
            EngineKind::Auto => self.detector.couples(&elements, couples),
        }
    }
}

impl<const D: usize> Peer<D> for Ours<D> {
    fn name(&self) -> &'static str {
        self.kind.name()
    }

    fn version(&self) -> String {
        super::peer::locked("fdem-contact")
    }

    fn how(&self) -> String {
        let simd = self.simd.name();
        match self.kind {
            EngineKind::Rows | EngineKind::RowsAvx2 => format!("`Rows::couples`, {simd}, memory reused"),
            EngineKind::RowsFresh => {
                format!("`Rows::couples`, {simd}, memory reused, the list new in every run")
            }
            EngineKind::RowsCold => {
                format!("`Rows::new().couples`, {simd}, memory and output new in every run")
            }
            EngineKind::Nbs => "`Nbs::couples`, memory reused; one thread".to_owned(),
            EngineKind::Auto => {
                format!("`Detector::couples`, {simd}, memory reused; levels for unlike sizes")
            }
        }
    }

    fn bytes(&self) -> Option<usize> {
        matches!(self.kind, EngineKind::Rows | EngineKind::RowsAvx2).then(|| self.rows.bytes())
    }

    fn couples(&mut self, bodies: Bodies<'_, D>, couples: &mut Vec<Couple>) -> Result<(), String> {
        self.search(bodies, couples).map_err(|error| match error {
            fdem_contact::Error::DomainTooWide { .. } => "domain too wide".to_owned(),
            error => error.to_string(),
        })
    }
}
