//! A network whose centres are wrapped into its box once, and not for every couple.

use std::ops::Range;

use fdem_contact::{PeriodicBox, PeriodicCouple};

use crate::analysis::domain_frame::DomainFrame;
use crate::analysis::parts::Team;
use crate::arrays::each;
use crate::network::{Network, Space};

/// A network, prepared for several passes over its couples.
pub(crate) struct Placed<'a, const D: usize> {
    pub(crate) network: &'a Network<'a, D>,
    pub(crate) frame: DomainFrame<D>,
    pub(crate) team: Team<'a>,
    /// `None` without a box.
    inside: Option<Inside<D>>,
}

impl<'a, const D: usize> Placed<'a, D> {
    pub(crate) fn of(network: &'a Network<'a, D>, team: Team<'a>) -> Self {
        let inside = network.space.cell.map(|cell| Inside::of(network.space, &cell, &team));
        Self { network, frame: DomainFrame::of(network), team, inside }
    }

    /// [`Space::ends`].
    #[inline]
    pub(crate) fn ends(&self, couple: PeriodicCouple<D>) -> [[f64; D]; 2] {
        match &self.inside {
            None => {
                let centres = self.network.space.centres;
                [centres[couple.i as usize], centres[couple.j as usize]]
            }
            Some(inside) => inside.ends(couple),
        }
    }

    /// The centres, inside of the box along periodic axes.
    pub(crate) fn wrapped(&self) -> Vec<[f64; D]> {
        match &self.inside {
            None => self.network.space.centres.to_vec(),
            Some(inside) => inside.centres.iter().map(|(centre, _)| *centre).collect(),
        }
    }

    /// The state of each part of the couples, in order, after all its couples were added to it.
    pub(crate) fn fold<S: Send>(
        &self,
        start: impl Fn() -> S + Sync,
        add: impl Fn(&mut S, PeriodicCouple<D>) + Sync,
    ) -> Vec<S> {
        let couples = self.network.couples;
        self.team.parts(couples.len(), |range| {
            let mut state = start();
            for k in range {
                add(&mut state, couples.get(k));
            }
            state
        })
    }
}

/// Centres in a periodic box.
pub(crate) struct Inside<const D: usize> {
    cell: PeriodicBox<f64, D>,
    /// The wrapped centres, and the periods by which they were outside.
    centres: Vec<([f64; D], [i32; D])>,
}

impl<const D: usize> Inside<D> {
    /// Wraps the centres of a space into its box.
    pub(crate) fn of(space: Space<'_, D>, cell: &PeriodicBox<f64, D>, team: &Team<'_>) -> Self {
        let part = |range: Range<usize>| -> Vec<_> {
            range.map(|element| space.wrapped(cell, element as u32)).collect()
        };
        Self { cell: *cell, centres: team.parts(space.centres.len(), part).concat() }
    }

    /// [`Space::ends`].
    #[inline]
    fn ends(&self, couple: PeriodicCouple<D>) -> [[f64; D]; 2] {
        let PeriodicCouple { i, j, shift } = couple;
        let ((a, of_a), (b, of_b)) = (self.centres[i as usize], self.centres[j as usize]);
        let shift: [i32; D] = each(|edge| shift[edge] - of_a[edge] + of_b[edge]);
        // Most couples: a displacement by no period changes no coordinate.
        if shift == [0; D] { [a, b] } else { [a, self.cell.displaced(&b, &shift)] }
    }

    /// [`Space::distance`].
    #[inline]
    pub(crate) fn distance(&self, couple: PeriodicCouple<D>) -> f64 {
        distance(self.ends(couple))
    }
}

/// [`Space::distance`] of the ends of a couple.
#[inline]
pub(crate) fn distance<const D: usize>([a, b]: [[f64; D]; 2]) -> f64 {
    let mut square = 0.0;
    for axis in 0..D {
        square += (a[axis] - b[axis]) * (a[axis] - b[axis]);
    }
    square.sqrt()
}
