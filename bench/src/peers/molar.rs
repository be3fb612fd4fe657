//! `molar`, molecular analysis: its distance search on a grid, in `f64`. Its `f32` mode took the same time;
//! `f64` finds the same couples as the other peers.

use fdem_contact::Couple;
use molar::prelude::{DistanceSearchOutput, Float, Pos, distance_search_single};

use super::bodies::Bodies;
use super::peer::Peer;

pub(super) struct Molar;

/// The type of results requested from the search: the numbers, without the distance.
struct Found(Couple);

impl DistanceSearchOutput for Found {
    fn from_ijd(i: usize, j: usize, _: Float) -> Self {
        Self(Couple::new(i as u32, j as u32))
    }
}

impl Peer<3> for Molar {
    fn name(&self) -> &'static str {
        "molar"
    }

    fn version(&self) -> String {
        super::peer::locked("molar")
    }

    fn how(&self) -> String {
        "`distance_search_single`, in its f64 mode".to_owned()
    }

    fn couples(&mut self, bodies: Bodies<'_, 3>, couples: &mut Vec<Couple>) -> Result<(), String> {
        let (points, cutoff) = bodies.points()?;
        let positions: Vec<Pos> = points.iter().map(|point| Pos::from(*point)).collect();
        let found: Vec<Found> =
            distance_search_single(cutoff, &positions, 0..points.len()).map_err(|error| error.to_string())?;
        // Converted in place: the vector that molar returns is the result.
        *couples = found.into_iter().map(|found| found.0).collect();
        Ok(())
    }
}
