//! Makes elements from arrays of numbers, one array per column.

use crate::column_values::ColumnValues;
use crate::columns::{Name, Role};
use crate::elements::Elements;
use crate::error::ReadError;
use crate::excerpt;
use crate::options::ReadOptions;
use crate::packing::{BadLine, Column, Format, Frame, Packing, Source};
use crate::row::{Row, SIZE, check_size};
use crate::table::UnassignedColumns;

/// Makes a packing of `rows` elements from columns with these names; only columns with a role are requested.
pub(super) fn packing(
    names: &[Name],
    rows: usize,
    mut column: impl FnMut(usize) -> Result<ColumnValues, ReadError>,
    format: Format,
    frame: Frame,
    options: &ReadOptions,
) -> Result<Packing, ReadError> {
    let shown =
        format!("{} of {}", excerpt::count(names.len() as u64, "column"), excerpt::count(rows as u64, "row"));
    let table = UnassignedColumns { names, header: true, line: None, row: &shown };
    let roles = table.all_roles(options)?;
    let unit = table.unit(&roles)?;
    let mut chosen = Vec::new();
    for (place, role) in roles.iter().enumerate() {
        if let Some(role) = *role {
            chosen.push((role, &names[place], column(place)?));
        }
    }
    let mut elements = Elements::new(&roles, rows)?;
    for at in 0..rows {
        match row(&chosen, at) {
            Ok(row) => elements.push(&row, at as u64),
            Err(problem) => {
                let values = chosen.iter().map(|(role, _, values)| format!("{role} {}", values.real(at)));
                let text = excerpt::line(values.collect::<Vec<_>>().join(", ").as_bytes());
                let problem = format!("row {at} (counted from 0): {problem}");
                elements.bad_row(BadLine { line: at as u64, text, problem }, options.skip_bad_lines)?;
            }
        }
    }
    elements.check(false)?;
    Ok(elements.into_packing(frame, |skipped| Source {
        format,
        columns: Column::all(names, &roles, true),
        unit,
        lines: rows as u64,
        skipped,
    }))
}

fn row(chosen: &[(Role, &Name, ColumnValues)], at: usize) -> Result<Row<'static>, String> {
    let mut row = Row::default();
    for (role, name, values) in chosen {
        let value = values.real(at);
        let place = match role {
            Role::Id | Role::Body | Role::Type => {
                let number = values.whole(at).ok_or_else(|| {
                    format!("the {role} in column {} is {value}, not a whole number up to 2^53", name.shown())
                })?;
                row.set_whole(*role, number);
                continue;
            }
            Role::X => 0,
            Role::Y => 1,
            Role::Z => 2,
            Role::Radius | Role::Diameter => SIZE,
        };
        if !value.is_finite() {
            return Err(format!("{role} (column {}) is {value}, not a finite number", name.shown()));
        }
        if let ColumnValues::Whole(values) = values
            && value as i128 != i128::from(values[at])
        {
            return Err(format!(
                "{role} (column {}) is {}, which a 64-bit float cannot hold exactly",
                name.shown(),
                values[at]
            ));
        }
        row.values[place] = value;
        if place == SIZE {
            check_size(value, *role, &name.shown())?;
        }
    }
    Ok(row)
}
