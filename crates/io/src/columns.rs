//! The roles of columns: the names that select them, and the choice made with `--columns`.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::excerpt;

/// Largest number of columns. A table of elements does not have more, and their names might not fit in
/// memory.
pub(crate) const MOST_COLUMNS: usize = 10_000;

/// The meaning of a column of a packing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// First coordinate of the centre.
    X,
    /// Second coordinate of the centre.
    Y,
    /// Third coordinate of the centre; without it the packing is 2D.
    Z,
    /// Radius.
    Radius,
    /// Diameter, halved into the radius.
    Diameter,
    /// Id, a whole number.
    Id,
    /// The body that the element belongs to, a whole number. No column name selects it: see
    /// [`ReadOptions::bodies`](crate::ReadOptions).
    Body,
    /// The type of the element, a name. It is read only if [`ReadOptions::types`](crate::ReadOptions) asks
    /// for it.
    Type,
}

impl Role {
    /// The roles that column names select.
    const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::Radius, Self::Diameter, Self::Id];

    /// Whether a name selects this role. The name comes without unit, blanks and capitals.
    fn goes_by(self, plain: &str) -> bool {
        /// Names of an axis: `@` is its letter, `#` its number.
        const AXIS: [&str; 26] = [
            "@",
            "pos@",
            "p@",
            "@pos",
            "position@",
            "@position",
            "coord@",
            "@coord",
            "coordinate@",
            "@coordinate",
            "coordinates@",
            "c@",
            "@c",
            "center@",
            "@center",
            "centre@",
            "@centre",
            "points:#",
            "points#",
            "position:#",
            "positions:#",
            "pos:#",
            "coordinates:#",
            "center:#",
            "centre:#",
            "centroid@",
        ];
        let axis = |letter: &str, number: &str| {
            AXIS.iter().any(|pattern| match pattern.split_once(['@', '#']) {
                Some((before, after)) => {
                    let middle = if pattern.contains('@') { letter } else { number };
                    plain.strip_prefix(before).and_then(|rest| rest.strip_suffix(after)) == Some(middle)
                }
                None => false,
            })
        };
        match self {
            Self::X => axis("x", "0"),
            Self::Y => axis("y", "1"),
            Self::Z => axis("z", "2"),
            Self::Radius => matches!(plain, "radius" | "r" | "rad" | "radii" | "particleradius"),
            Self::Diameter => matches!(plain, "diameter" | "d" | "dia" | "diam" | "particlediameter"),
            Self::Id => matches!(plain, "id" | "ids" | "index" | "particleid" | "number" | "no"),
            Self::Body | Self::Type => false,
        }
    }

    /// Whether two columns of one file cannot have these roles.
    pub(crate) fn clashes(self, other: Self) -> bool {
        let size = |role| matches!(role, Self::Radius | Self::Diameter);
        self == other || (size(self) && size(other))
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Radius => "radius",
            Self::Diameter => "diameter",
            Self::Id => "id",
            Self::Body => "body",
            Self::Type => "type",
        })
    }
}

/// The name of a column, split into its parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Name {
    /// The spelling of the file.
    pub(crate) written: String,
    /// Without quotes, unit, blanks, `_`, `-` and capitals.
    pub(crate) plain: String,
    /// The unit in brackets, or one of [`SUFFIXES`] after `_` or a blank.
    pub(crate) unit: Option<String>,
}

/// Units that are recognised without brackets, as in `x_mm` and `x mm`; the second µ is the Greek letter.
const SUFFIXES: [&str; 10] = ["m", "mm", "cm", "um", "\u{b5}m", "\u{3bc}m", "km", "nm", "in", "ft"];

impl Name {
    /// All the names of one file.
    ///
    /// `r_in` is more often an inner radius than a radius in inches, so it counts as inches only if a
    /// coordinate is in inches.
    pub(crate) fn all<'a>(written: impl IntoIterator<Item = &'a str>) -> Vec<Self> {
        let mut names: Vec<Self> = written.into_iter().map(Self::new).collect();
        let inches = |name: &Self| name.unit.as_deref() == Some("in");
        let coordinate = |name: &Self| matches!(name.role(), Some(Role::X | Role::Y | Role::Z));
        if !names.iter().any(|name| inches(name) && coordinate(name)) {
            for name in names.iter_mut().filter(|name| inches(name)) {
                *name = Self::unsuffixed(&name.written);
            }
        }
        names
    }

    pub(crate) fn new(written: &str) -> Self {
        let name = Self::unsuffixed(written);
        if name.unit.is_some() || name.role().is_some() {
            return name;
        }
        let Some((stem, unit)) = name.written.rsplit_once(|c: char| c == '_' || c.is_whitespace()) else {
            return name;
        };
        let Some(unit) = SUFFIXES.into_iter().find(|known| *known == unit.to_lowercase()) else {
            return name;
        };
        let plain = Self::unsuffixed(stem).plain;
        // An id has no unit, so `no_in` is not an id.
        if plain.is_empty() || Role::Id.goes_by(&plain) {
            return name;
        }
        Self { plain, unit: Some(unit.to_owned()), written: name.written }
    }

    /// The name, with a unit recognised in brackets only.
    pub(crate) fn unsuffixed(written: &str) -> Self {
        let written = written.trim_matches(|c: char| c.is_whitespace() || c == '"' || c == '\'');
        let (mut rest, mut unit) = (written.to_owned(), None);
        if let Some(open) = written.find(['[', '(']).filter(|&at| at > 0) {
            let inside = &written[open + 1..];
            let close = inside.find([']', ')']).unwrap_or(inside.len());
            unit = Some(inside[..close].trim().to_owned()).filter(|unit| !matches!(unit.as_str(), "" | "-"));
            rest = written[..open].to_owned() + inside.get(close + 1..).unwrap_or("");
        }
        rest.retain(|c| !(c.is_whitespace() || matches!(c, '_' | '-' | '"' | '\'')));
        Self { written: written.to_owned(), plain: rest.to_lowercase(), unit }
    }

    /// The name for a message. Control characters are escaped, because a file may contain any and a terminal
    /// obeys them.
    pub(crate) fn shown(&self) -> String {
        if self.written.is_empty() { "(no name)".into() } else { excerpt::field(self.written.as_bytes()) }
    }

    /// The role that the name selects, if any: `X (mm)`, `PosX[m]`, `x_mm`, `Points:0` and `pos_x` all select
    /// x.
    pub(crate) fn role(&self) -> Option<Role> {
        Role::ALL.into_iter().find(|role| role.goes_by(&self.plain))
    }
}

/// The columns of a file as chosen by the user, for files whose header is missing or misleading.
///
/// There are two notations, both with the roles `x y z radius diameter id` and the names that a header may
/// use for them:
/// - by place, `radius,x,y,z`: one entry for every column; `_` or `-` skips a column;
/// - by name, `x=PosX[m],y=PosY[m],radius=3`: the name of a column in the header, or its number counted
///   from 1.
///
/// # Errors
/// [`ColumnsError`] if the text cannot be parsed.
///
/// # Example
/// ```
/// use fdem_io::{Columns, ColumnsError, Role};
///
/// let by_place: Columns = "_,radius,x,y".parse()?;
/// let by_name: Columns = "x=3,y=4,radius=Rad [mm]".parse()?;
/// assert_ne!(by_place, by_name);
/// assert_eq!("x,y,x".parse::<Columns>(), Err(ColumnsError::Duplicate { role: Role::X }));
/// # Ok::<(), ColumnsError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns(pub(crate) Choice);

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Choice {
    /// For each column a role, or none.
    Places(Vec<Option<Role>>),
    /// For each role the name or number of its column.
    Names(Vec<(Role, String)>),
}

/// The reason why a choice of columns is invalid, whatever the file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ColumnsError {
    /// An entry is not a role.
    #[error("'{entry}' is not one of x, y, z, radius, diameter, id (or _ to skip a column)")]
    UnknownRole {
        /// The entry.
        entry: String,
    },
    /// A role has no column, as in `x=`.
    #[error("'{entry}' names no column: expected {role}=NAME or {role}=NUMBER")]
    NoName {
        /// The entry.
        entry: String,
        /// The role of the entry.
        role: Role,
    },
    /// Some entries are by place and others by name.
    #[error("'{entry}' does not fit the entries before it: use either x,y,... or x=NAME,y=NAME,...")]
    Mixed {
        /// The first entry that differs from the others.
        entry: String,
    },
    /// A role is given twice.
    #[error("{role} is given twice")]
    Duplicate {
        /// The role.
        role: Role,
    },
    /// Two roles are given the same column.
    #[error("column '{column}' is given as {first} and again as {second}")]
    TwoRoles {
        /// The name or number of the column.
        column: String,
        /// The first role.
        first: Role,
        /// The second role.
        second: Role,
    },
    /// Both radius and diameter are given.
    #[error("both radius and diameter are given: one follows from the other")]
    RadiusAndDiameter,
    /// x or y is missing.
    #[error("{role} is missing: x and y are needed at least")]
    Missing {
        /// The role.
        role: Role,
    },
}

impl FromStr for Columns {
    type Err = ColumnsError;

    fn from_str(text: &str) -> Result<Self, ColumnsError> {
        let by_name = text.split(',').next().is_some_and(|entry| entry.contains('='));
        let (mut places, mut names) = (Vec::new(), Vec::new());
        for entry in text.split(',').map(str::trim) {
            let unknown = || ColumnsError::UnknownRole { entry: entry.to_owned() };
            match entry.split_once('=') {
                Some((role, name)) if by_name => {
                    let role = Name::new(role).role().ok_or_else(unknown)?;
                    let name = name.trim().trim_matches('"');
                    if name.is_empty() {
                        return Err(ColumnsError::NoName { entry: entry.to_owned(), role });
                    }
                    names.push((role, name.to_owned()));
                }
                None if !by_name => places.push(match entry {
                    "_" | "-" => None,
                    _ => Some(Name::new(entry).role().ok_or_else(unknown)?),
                }),
                _ => return Err(ColumnsError::Mixed { entry: entry.to_owned() }),
            }
        }
        let choice = if by_name { Choice::Names(names) } else { Choice::Places(places) };
        check_roles(&choice)?;
        Ok(Self(choice))
    }
}

fn check_roles(choice: &Choice) -> Result<(), ColumnsError> {
    let mut roles: Vec<Role> = match choice {
        Choice::Places(places) => places.iter().flatten().copied().collect(),
        Choice::Names(names) => names.iter().map(|(role, _)| *role).collect(),
    };
    roles.sort_unstable();
    if let Some(twice) = roles.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(ColumnsError::Duplicate { role: twice[0] });
    }
    if roles.contains(&Role::Radius) && roles.contains(&Role::Diameter) {
        return Err(ColumnsError::RadiusAndDiameter);
    }
    if let Some(role) = [Role::X, Role::Y].into_iter().find(|role| !roles.contains(role)) {
        return Err(ColumnsError::Missing { role });
    }
    let Choice::Names(names) = choice else { return Ok(()) };
    for (place, (second, column)) in names.iter().enumerate() {
        if let Some((first, _)) = names[..place].iter().find(|(_, earlier)| earlier == column) {
            return Err(ColumnsError::TwoRoles { column: column.clone(), first: *first, second: *second });
        }
    }
    Ok(())
}

impl Columns {
    /// Whether these columns are found by number alone, without looking at names.
    pub(crate) fn by_number(&self) -> bool {
        match &self.0 {
            Choice::Places(_) => true,
            Choice::Names(names) => names.iter().all(|(_, name)| name.parse::<usize>().is_ok()),
        }
    }

    /// Whether the column at this place, counted from 0, is given a role by its number.
    pub(crate) fn takes(&self, place: usize) -> bool {
        match &self.0 {
            Choice::Places(places) => places.get(place).is_some_and(Option::is_some),
            Choice::Names(names) => names.iter().any(|(_, name)| name.parse() == Ok(place + 1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_field_are_known() {
        for (role, names) in [
            (
                Role::X,
                "x|X|PosX[m]|px|position X|x_pos|CoordX|x_coordinate|cx|xc|center_x|Points:0|Points_0|X (mm)",
            ),
            (Role::Y, "y|posy[mm]|y-pos|Y_Coord|centrey|points:1|position:1|\"Y\""),
            (Role::Z, "z|PosZ|zc|Points:2"),
            (Role::Radius, "radius|R|Rad|radii|Particle_Radius|radius[m]"),
            (Role::Diameter, "d|D|dia|diam|Diameter(mm)"),
            (Role::Id, "id|IDs|index|ParticleID|particle_id|number|No"),
        ] {
            for name in names.split('|') {
                assert_eq!(Name::new(name).role(), Some(role), "{name}");
            }
        }
        for name in ["", "vx", "xx", "w", "points:3", "mass", "(x)", "x0", "r2", "points:", "density"] {
            assert_eq!(Name::new(name).role(), None, "{name}");
        }
    }

    #[test]
    fn a_unit_is_what_stands_in_brackets() {
        let unit = |name: &str| Name::new(name).unit;
        assert_eq!(unit("PosX[m]").as_deref(), Some("m"));
        assert_eq!(unit("X ( mm )").as_deref(), Some("mm"));
        assert_eq!(unit("X [mm").as_deref(), Some("mm"), "a bracket left open ends with the name");
        assert_eq!(unit("X[-]"), None);
        assert_eq!(unit("X[]"), None);
        assert_eq!(unit("(m)"), None, "a bracket alone is a name");
    }

    #[test]
    fn a_unit_may_follow_the_name() {
        for (name, role, unit) in [
            ("x_mm", Role::X, "mm"),
            ("X mm", Role::X, "mm"),
            ("pos_x_M", Role::X, "m"),
            ("center y cm", Role::Y, "cm"),
            ("radius_\u{b5}m", Role::Radius, "\u{b5}m"),
            ("radius_\u{3bc}m", Role::Radius, "\u{3bc}m"),
            ("d_um", Role::Diameter, "um"),
            ("\"z_km\"", Role::Z, "km"),
            ("r nm", Role::Radius, "nm"),
            ("x_ft", Role::X, "ft"),
        ] {
            let name = Name::new(name);
            assert_eq!((name.role(), name.unit.as_deref()), (Some(role), Some(unit)), "{}", name.written);
        }
        for name in ["xmm", "x_s", "x_kg", "x_dm", "mm", "_mm", "no_in", "id_m", "x_mm_s"] {
            let name = Name::new(name);
            assert_eq!((name.role(), name.unit.as_deref()), (None, None), "{}", name.written);
        }
        let inches =
            |names: [&str; 3]| Name::all(names).into_iter().map(|name| name.role()).collect::<Vec<_>>();
        assert_eq!(inches(["x_in", "y_in", "r_in"]), [Role::X, Role::Y, Role::Radius].map(Some));
        assert_eq!(inches(["x", "y", "r_in"]), [Some(Role::X), Some(Role::Y), None], "an inner radius");
    }

    #[test]
    fn choices_that_make_no_sense_are_refused() {
        let parse = |text: &str| text.parse::<Columns>();
        assert_eq!(parse("x,y,X"), Err(ColumnsError::Duplicate { role: Role::X }));
        assert_eq!(parse("x=1,y=2,x=3"), Err(ColumnsError::Duplicate { role: Role::X }));
        assert_eq!(parse("x,y,d,r"), Err(ColumnsError::RadiusAndDiameter));
        assert_eq!(parse("x,z"), Err(ColumnsError::Missing { role: Role::Y }));
        assert_eq!(parse("y=2"), Err(ColumnsError::Missing { role: Role::X }));
        assert_eq!(parse("x,y,mass"), Err(ColumnsError::UnknownRole { entry: "mass".into() }));
        assert_eq!(parse(""), Err(ColumnsError::UnknownRole { entry: String::new() }));
        assert_eq!(parse("x,y,"), Err(ColumnsError::UnknownRole { entry: String::new() }));
        assert_eq!(parse("x=1,y"), Err(ColumnsError::Mixed { entry: "y".into() }));
        assert_eq!(parse("x,y=2"), Err(ColumnsError::Mixed { entry: "y=2".into() }));
        assert_eq!(parse("x=1,y="), Err(ColumnsError::NoName { entry: "y=".into(), role: Role::Y }));
        let twice = ColumnsError::TwoRoles { column: "x".into(), first: Role::X, second: Role::Y };
        assert_eq!(parse("x=x, y=x"), Err(twice.clone()));
        assert_eq!(twice.to_string(), "column 'x' is given as x and again as y");
        assert!(parse("x=a,y=A").is_ok(), "two columns may differ by case");
        assert!(parse(" Radius , PosX ,_,-, y").is_ok());
    }
}
