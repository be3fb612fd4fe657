//! The errors of a distributed search. All ranks return the same one.

use std::fmt;

use crate::communicator::Communicator;

/// Why a distributed search was refused. Every rank returns the same error, so that all can stop together.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// A rank's elements, its box or its search were refused; if several were, this is the first rank.
    Refused {
        /// The rank.
        rank: usize,
        /// The id of the element that is the reason, if it is one.
        id: Option<u32>,
        /// The message of [`fdem_contact::Error`]; an element in it is named by its id.
        reason: String,
    },
    /// The ranks were given different kinds of elements, tolerances or boxes.
    Unlike {
        /// The first rank that differs from rank 0.
        rank: usize,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused { rank, reason, .. } => write!(out, "rank {rank}: {reason}"),
            Self::Unlike { rank } => {
                write!(
                    out,
                    "rank {rank} has another kind of elements, another tolerance or another box than rank 0"
                )
            }
        }
    }
}

impl std::error::Error for Error {}

/// Returns the value if all ranks have one, and otherwise the error of the first rank without. Collective.
/// The errors name elements by ids.
pub(crate) fn agree<V>(
    communicator: &dyn Communicator,
    result: Result<V, fdem_contact::Error>,
) -> Result<V, Error> {
    let mut told = Vec::new();
    if let Err(error) = &result {
        // One more than the id; 0 for none.
        let id = error.element().map_or(0, |id| id as u64 + 1);
        told.extend(id.to_le_bytes());
        told.extend(error.to_string().bytes());
    }
    let all = communicator.all_gather(&told);
    let first = all.iter().enumerate().find_map(|(rank, told)| Some((rank, told.split_first_chunk::<8>()?)));
    match (first, result) {
        (None, Ok(value)) => Ok(value),
        (Some((rank, (id, text))), _) => Err(Error::Refused {
            rank,
            id: u64::from_le_bytes(*id).checked_sub(1).map(|id| id as u32),
            reason: String::from_utf8_lossy(text).into_owned(),
        }),
        (None, Err(error)) => {
            Err(Error::Refused { rank: communicator.rank(), id: None, reason: error.to_string() })
        }
    }
}

/// Makes an error about an element name it by its id.
pub(crate) fn name_by_id(
    mut error: fdem_contact::Error,
    id_of: impl Fn(usize) -> usize,
) -> fdem_contact::Error {
    use fdem_contact::Error::{
        CoordinateTooLarge, DomainTooWide, InvalidRadius, InvertedBox, NonFiniteCoordinate, OutsideBox,
        OutsideDomain, TooFarFromBox,
    };
    match &mut error {
        NonFiniteCoordinate { index, .. }
        | CoordinateTooLarge { index, .. }
        | InvertedBox { index, .. }
        | OutsideDomain { index, .. }
        | OutsideBox { index, .. }
        | TooFarFromBox { index, .. }
        | InvalidRadius { index: Some(index), .. }
        | DomainTooWide { stretched_by: Some((index, _)), .. } => *index = id_of(*index),
        _ => {}
    }
    error
}
