//! The round robin of Dosta et al. (2024), with its data beside the project.

use super::data;
use crate::outcome::{Outcome, Size};

pub(crate) fn run(_: Size) -> Result<Vec<Outcome>, String> {
    Ok(vec![Outcome::skipped("round robin", data::ABSENT)])
}
