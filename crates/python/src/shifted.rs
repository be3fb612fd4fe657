//! Couples with the shifts of those that have one.

use fdem_contact::{Couple, PeriodicCouple};

use crate::problem::Problem;

/// Couples, and the shifts of the last of them; all before have shift 0.
pub(crate) type ShiftedCouples<const D: usize> = (Vec<Couple>, Vec<[i32; D]>);

/// Couples without shift, then the others; and the shifts of these.
pub(crate) fn by_shift<const D: usize>(
    couples: Vec<PeriodicCouple<D>>,
) -> Result<ShiftedCouples<D>, Problem> {
    let (unshifted, shifted): (Vec<_>, Vec<_>) =
        couples.into_iter().partition(|couple| couple.shift == [0; D]);
    joined(unshifted.iter().map(|&PeriodicCouple { i, j, .. }| Couple { i, j }).collect(), shifted)
}

/// The couples of both lists, and the shifts of the second.
pub(crate) fn joined<const D: usize>(
    mut couples: Vec<Couple>,
    shifted: Vec<PeriodicCouple<D>>,
) -> Result<ShiftedCouples<D>, Problem> {
    couples.try_reserve(shifted.len()).map_err(|_| Problem::out_of_memory::<Couple>(shifted.len()))?;
    couples.extend(shifted.iter().map(|&PeriodicCouple { i, j, .. }| Couple { i, j }));
    Ok((couples, shifted.iter().map(|couple| couple.shift).collect()))
}
