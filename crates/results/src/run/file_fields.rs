//! The fields of files for ParaView.

use fdem_io::{Table, Values};

use crate::fields::place::Place;
use crate::fields::quantity::{Quantity, Value};
use crate::fields::state::State;
use crate::fields::table::QUANTITIES;

/// Adds the fields of a place that files have. Row `k` of the table has the values of node, element and so on
/// `k`.
pub(crate) fn with_fields<'a, const D: usize>(
    table: Table<'a>,
    place: Place,
    state: &'a dyn State,
) -> Table<'a> {
    with_fields_of::<D>(table, place, state, &|k| k)
}

/// Adds the fields of a place that files have. Row `k` of the table has the values of `owner(k)`.
pub(crate) fn with_fields_of<'a, const D: usize>(
    table: Table<'a>,
    place: Place,
    state: &'a dyn State,
    owner: &'a dyn Fn(usize) -> usize,
) -> Table<'a> {
    let is_there = |row: &Quantity| row.liquid.is_none_or(|liquid| state.has_liquid(liquid));
    let has = |row: &&Quantity| row.in_files && row.exists_in(D) && is_there(row);
    let rows = QUANTITIES.iter().filter(|row| row.place == place).filter(has);
    rows.fold(table, |table, row| {
        let width = row.width();
        let values = match row.value {
            Value::Real(of) => Values::f64(move |k| of(state, owner(k / width), k % width)),
            Value::Whole(of) => Values::i64(move |k| of(state, owner(k / width), k % width)),
            Value::Short(of) => Values::i32(move |k| of(state, owner(k / width), k % width)),
        };
        table.with_components(row.key, row.components, values).in_unit(row.unit)
    })
}
