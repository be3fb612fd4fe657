//! Assigns roles to the columns of one file.

use crate::columns::{Choice, Columns, Name, Role};
use crate::error::ReadError;
use crate::excerpt;
use crate::options::{ReadOptions, TypeColumn};

/// The columns of one file before roles are assigned.
pub(crate) struct UnassignedColumns<'a> {
    /// The names in the header, or the numbers of the columns counted from 1.
    pub(crate) names: &'a [Name],
    /// Whether `names` come from a header.
    pub(crate) header: bool,
    /// The line of the names, for errors.
    pub(crate) line: Option<u64>,
    /// The first row, for errors.
    pub(crate) row: &'a str,
}

impl UnassignedColumns<'_> {
    /// Assigns a role to every column, by the user's choice, by name or by number, in this order.
    pub(crate) fn roles(&self, columns: Option<&Columns>) -> Result<Vec<Option<Role>>, ReadError> {
        match columns {
            Some(Columns(Choice::Places(places))) if places.len() == self.names.len() => Ok(places.clone()),
            Some(Columns(Choice::Places(places))) => Err(ReadError::ColumnCount {
                line: self.line,
                listed: places.len(),
                found: self.names.len(),
                text: self.row.to_owned(),
            }),
            Some(Columns(Choice::Names(names))) => self.roles_by_choice(names),
            None if self.header => self.roles_by_name(),
            None => self.roles_by_number(),
        }
    }

    /// The same without ids if they are ignored, and with the columns of bodies and types.
    pub(crate) fn all_roles(&self, options: &ReadOptions) -> Result<Vec<Option<Role>>, ReadError> {
        let columns = options.columns.as_ref();
        let body = options.bodies.as_ref().map(|wanted| self.place_of(wanted)).transpose()?;
        let types = options.types.as_ref().map(|wanted| self.place_of_types(wanted)).transpose()?;
        let mut roles = if columns.is_none() && !self.header {
            let is_other = |place: &usize| ![body, types].contains(&Some(*place));
            let others: Vec<usize> = (0..self.names.len()).filter(is_other).collect();
            let names: Vec<Name> = others.iter().map(|&place| self.names[place].clone()).collect();
            let mut roles = vec![None; self.names.len()];
            let usual = UnassignedColumns { names: &names, ..*self }.roles_by_number()?;
            others.into_iter().zip(usual).for_each(|(place, role)| roles[place] = role);
            roles
        } else {
            self.roles(columns)?
        };
        if options.ignore_ids {
            roles.iter_mut().filter(|role| **role == Some(Role::Id)).for_each(|role| *role = None);
        }
        if let Some(place) = body
            && let Some(role) = roles[place].replace(Role::Body)
        {
            return Err(ReadError::BodiesColumn { line: self.line, column: self.names[place].shown(), role });
        }
        if let Some(place) = types
            && let Some(role) = roles[place].replace(Role::Type)
        {
            return Err(ReadError::TypesColumn { line: self.line, column: self.names[place].shown(), role });
        }
        Ok(roles)
    }

    /// Finds the column of types. Its usual names are searched among the names as they are written: a
    /// property of an XYZ file that is no number has no plain name.
    fn place_of_types(&self, wanted: &TypeColumn) -> Result<usize, ReadError> {
        let usual = match wanted {
            TypeColumn::Named(name) => return self.place_of(name),
            TypeColumn::Usual => TypeColumn::USUAL,
        };
        let written: Vec<String> =
            self.names.iter().map(|name| Name::unsuffixed(&name.written).plain).collect();
        for known in usual {
            let found: Vec<usize> = (0..written.len()).filter(|&place| written[place] == known).collect();
            match found[..] {
                [] => {}
                [place] => return Ok(place),
                _ => return Err(self.ambiguous(known, &found)),
            }
        }
        Err(ReadError::NoTypes { line: self.line, present: self.present() })
    }

    fn roles_by_choice(&self, chosen: &[(Role, String)]) -> Result<Vec<Option<Role>>, ReadError> {
        let mut roles = vec![None; self.names.len()];
        for (role, wanted) in chosen {
            let place = self.place_of(wanted)?;
            if let Some(taken) = roles[place] {
                return Err(ReadError::TwoRoles {
                    line: self.line,
                    column: self.names[place].shown(),
                    first_role: taken,
                    second_role: *role,
                });
            }
            roles[place] = Some(*role);
        }
        Ok(roles)
    }

    /// Finds a column by its exact name in the header, otherwise by its number, otherwise by its name without
    /// unit and capitals.
    fn place_of(&self, wanted: &str) -> Result<usize, ReadError> {
        let plain = [Name::new(wanted).plain, Name::unsuffixed(wanted).plain];
        let places = |fits: &dyn Fn(&Name) -> bool| -> Vec<usize> {
            (0..self.names.len()).filter(|&place| fits(&self.names[place])).collect()
        };
        let mut found = places(&|name| name.written == wanted);
        if found.is_empty() {
            found.extend(
                wanted.parse().ok().filter(|number| (1..=self.names.len()).contains(number)).map(|n| n - 1),
            );
        }
        if found.is_empty() {
            found = places(&|name| !name.plain.is_empty() && plain.contains(&name.plain));
        }
        match found[..] {
            [place] => Ok(place),
            [] => Err(ReadError::UnknownColumn {
                line: self.line,
                wanted: excerpt::field(wanted.as_bytes()),
                present: self.present(),
            }),
            _ => Err(self.ambiguous(wanted, &found)),
        }
    }

    fn ambiguous(&self, wanted: &str, found: &[usize]) -> ReadError {
        ReadError::AmbiguousColumn {
            line: self.line,
            wanted: excerpt::field(wanted.as_bytes()),
            matches: found
                .iter()
                .map(|&place| format!("{} ({})", self.names[place].shown(), place + 1))
                .collect(),
        }
    }

    fn roles_by_name(&self) -> Result<Vec<Option<Role>>, ReadError> {
        let roles: Vec<_> = self.names.iter().map(Name::role).collect();
        for (second, role) in roles.iter().enumerate() {
            let Some(role) = *role else { continue };
            for (first, earlier) in roles[..second].iter().enumerate() {
                if let Some(earlier) = earlier.filter(|earlier| role.clashes(*earlier)) {
                    return Err(self.clash((first, earlier), (second, role)));
                }
            }
        }
        match [Role::X, Role::Y].into_iter().find(|role| !roles.contains(&Some(*role))) {
            Some(role) => Err(ReadError::MissingColumn {
                line: self.line,
                role,
                present: self.present(),
                title: self.line.is_some() && roles.iter().all(Option::is_none),
            }),
            None => Ok(roles),
        }
    }

    fn roles_by_number(&self) -> Result<Vec<Option<Role>>, ReadError> {
        let usual = [Role::X, Role::Y, Role::Z, Role::Radius].map(Some);
        match self.names.len() {
            found @ 2..=4 => Ok(usual[..found].to_vec()),
            found => Err(ReadError::UnnamedColumns { line: self.line, found, text: self.row.to_owned() }),
        }
    }

    /// The common unit of the columns that hold lengths; `None` if the header gives none.
    pub(crate) fn unit(&self, roles: &[Option<Role>]) -> Result<Option<String>, ReadError> {
        let mut lengths = self
            .names
            .iter()
            .zip(roles)
            .filter(|(_, role)| role.is_some_and(|role| !matches!(role, Role::Id | Role::Body | Role::Type)))
            .filter_map(|(name, _)| name.unit.as_ref().map(|unit| (name, unit)));
        let Some((first, first_unit)) = lengths.next() else { return Ok(None) };
        match lengths.find(|(_, unit)| *unit != first_unit) {
            Some((second, second_unit)) => Err(ReadError::MixedUnits {
                line: self.line,
                first: first.shown(),
                first_unit: excerpt::field(first_unit.as_bytes()),
                second: second.shown(),
                second_unit: excerpt::field(second_unit.as_bytes()),
            }),
            None => Ok(Some(excerpt::field(first_unit.as_bytes()))),
        }
    }

    fn present(&self) -> Vec<String> {
        /// Largest number of columns listed in a message; a table may have hundreds.
        const SHOWN: usize = 20;
        let mut present: Vec<_> = self.names.iter().take(SHOWN).map(Name::shown).collect();
        if self.names.len() > SHOWN {
            present.push(format!("… ({} in all)", self.names.len()));
        }
        present
    }

    fn clash(&self, first: (usize, Role), second: (usize, Role)) -> ReadError {
        ReadError::ClashingColumns {
            line: self.line,
            first: self.names[first.0].shown(),
            first_role: first.1,
            second: self.names[second.0].shown(),
            second_role: second.1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_a_column_unless_a_column_has_that_name() {
        let names = [Name::new("2"), Name::new("PosX[m]"), Name::new("PosX[mm]"), Name::new("b")];
        let table = UnassignedColumns { names: &names, header: true, line: Some(1), row: "" };
        assert_eq!(table.place_of("2"), Ok(0));
        assert_eq!(table.place_of("3"), Ok(2));
        assert_eq!(table.place_of("PosX[mm]"), Ok(2));
        assert_eq!(table.place_of("B"), Ok(3));
        assert!(matches!(table.place_of("posx"), Err(ReadError::AmbiguousColumn { .. })));
        assert!(matches!(table.place_of("5"), Err(ReadError::UnknownColumn { .. })));
        assert!(matches!(table.place_of("0"), Err(ReadError::UnknownColumn { .. })));
    }
}
