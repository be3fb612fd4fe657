//! Ours.

use fdem_contact::{Couple, Elements, Error, Nbs, Rows, Search, Simd};

use super::Peer;

/// Which of our searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `Rows`, memory kept from call to call.
    Rows,
    /// `Rows` limited to AVX2.
    RowsAvx2,
    /// `Rows` with memory, that of the couples too, from the allocator in every call.
    RowsCold,
    /// `Nbs`, memory kept from call to call.
    Nbs,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Rows, Self::RowsAvx2, Self::RowsCold, Self::Nbs];

    /// Name in the tables and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rows => "rows",
            Self::RowsAvx2 => "rows-avx2",
            Self::RowsCold => "rows-cold",
            Self::Nbs => "nbs",
        }
    }

    /// Those that this processor can run.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|&kind| kind != Self::RowsAvx2 || Simd::Avx2.is_available()).collect()
    }
}

pub(super) struct Ours<const D: usize> {
    kind: Kind,
    simd: Simd,
    threads: usize,
    rows: Rows<f64, D>,
    nbs: Nbs<D>,
}

impl<const D: usize> Ours<D> {
    pub(super) fn new(kind: Kind, simd: Simd, threads: usize) -> Result<Self, Error> {
        let simd = if kind == Kind::RowsAvx2 { Simd::Avx2 } else { simd };
        let rows = Rows::new().with_simd(simd)?.with_threads(threads)?;
        Ok(Self { kind, simd, threads, rows, nbs: Nbs::new() })
    }

    fn search(
        &mut self,
        points: &[[f64; D]],
        cutoff: f64,
        couples: &mut Vec<Couple>,
    ) -> Result<(), fdem_contact::Error> {
        let elements = Elements::points(points, cutoff)?;
        match self.kind {
            Kind::Rows | Kind::RowsAvx2 => self.rows.couples(&elements, couples),
            Kind::RowsCold => {
                *couples = Vec::new();
                let mut rows = Rows::new().with_simd(self.simd)?.with_threads(self.threads)?;
                rows.couples(&elements, couples)
            }
            Kind::Nbs => self.nbs.couples(&elements, couples),
        }
    }
}

impl<const D: usize> Peer<D> for Ours<D> {
    fn name(&self) -> &'static str {
        self.kind.name()
    }

    fn version(&self) -> String {
        super::locked("fdem-contact")
    }

    fn how(&self) -> String {
        let simd = self.simd.name();
        match self.kind {
            Kind::Rows | Kind::RowsAvx2 => format!("`Rows::couples`, {simd}, memory reused"),
            Kind::RowsCold => format!("`Rows::new().couples`, {simd}, memory and output new in every run"),
            Kind::Nbs => "`Nbs::couples`, memory reused; one thread".to_owned(),
        }
    }

    fn bytes(&self) -> Option<usize> {
        matches!(self.kind, Kind::Rows | Kind::RowsAvx2).then(|| self.rows.bytes())
    }

    fn couples(&mut self, points: &[[f64; D]], cutoff: f64, couples: &mut Vec<Couple>) -> Result<(), String> {
        self.search(points, cutoff, couples).map_err(|error| match error {
            fdem_contact::Error::DomainTooWide { .. } => "domain too wide".to_owned(),
            error => error.to_string(),
        })
    }
}
