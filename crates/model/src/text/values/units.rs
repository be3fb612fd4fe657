//! Units: their symbols, their size in SI units, and their dimension.

use std::fmt::{self, Write};

/// Steps of an exponent: dimensions have exponents that are multiples of 1/12, such as the 1/2 of the square
/// root of a length.
pub(crate) const STEPS: i32 = 12;

/// Exponents of mass, length, time and angle, in steps of 1/12.
///
/// The angle is a separate dimension, whose unit is the degree, so that nobody takes radians for degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dimension(pub(crate) [i32; 4]);

impl Dimension {
    pub(crate) const NONE: Self = Self([0; 4]);
    pub(crate) const ANGLE: Self = Self::of([0, 0, 0, 1]);

    /// Whole exponents of mass, length, time and angle.
    const fn of([mass, length, time, angle]: [i32; 4]) -> Self {
        Self([mass * STEPS, length * STEPS, time * STEPS, angle * STEPS])
    }

    pub(crate) fn times(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k].saturating_add(other.0[k])))
    }

    pub(crate) fn over(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k].saturating_sub(other.0[k])))
    }

    /// The dimension of a power; `None` if its exponents are no multiples of 1/12, or out of range.
    pub(crate) fn power(self, exponent: f64) -> Option<Self> {
        let mut out = [0; 4];
        for (to, from) in out.iter_mut().zip(self.0) {
            let steps = f64::from(from) * exponent;
            let whole = steps.round();
            if (steps - whole).abs() > 1e-6 || whole.abs() > 1e4 {
                return None;
            }
            *to = whole as i32;
        }
        Some(Self(out))
    }
}

/// Dimensions that have a name.
const NAMES: [(&str, [i32; 4]); 21] = [
    ("a number without a unit", [0, 0, 0, 0]),
    ("a mass", [1, 0, 0, 0]),
    ("a length", [0, 1, 0, 0]),
    ("a time", [0, 0, 1, 0]),
    ("an angle", [0, 0, 0, 1]),
    ("an area", [0, 2, 0, 0]),
    ("a volume", [0, 3, 0, 0]),
    ("a velocity", [0, 1, -1, 0]),
    ("an acceleration", [0, 1, -2, 0]),
    ("a density", [1, -3, 0, 0]),
    ("a mass flow", [1, 0, -1, 0]),
    ("a force", [1, 1, -2, 0]),
    ("a stress", [1, -1, -2, 0]),
    ("a stress per length", [1, -2, -2, 0]),
    ("an energy", [1, 2, -2, 0]),
    ("an energy per area", [1, 0, -2, 0]),
    ("a power", [1, 2, -3, 0]),
    ("a viscosity", [1, -1, -1, 0]),
    ("a volume flow", [0, 3, -1, 0]),
    ("a frequency", [0, 0, -1, 0]),
    ("an angular velocity", [0, 0, -1, 1]),
];

/// The name of the dimension, or else its SI units.
impl fmt::Display for Dimension {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((name, _)) = NAMES.iter().find(|(_, exponents)| Self::of(*exponents) == *self) {
            return out.write_str(name);
        }
        out.write_str("in ")?;
        let mut first = true;
        for (unit, steps) in ["kg", "m", "s", "deg"].into_iter().zip(self.0).filter(|(_, steps)| *steps != 0)
        {
            if !first {
                out.write_char('·')?;
            }
            first = false;
            out.write_str(unit)?;
            match steps {
                STEPS => {}
                steps if steps % STEPS == 0 => write!(out, "^{}", steps / STEPS)?,
                steps => write!(out, "^({steps}/{STEPS})")?,
            }
        }
        Ok(())
    }
}

/// A unit: `factor · 10^tens` in SI units, angles in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    pub(crate) factor: f64,
    pub(crate) tens: i32,
    pub(crate) dimension: Dimension,
}

/// Symbols with their factor, their power of ten, and their exponents of mass, length, time and angle. The
/// foot is left out: `ft` is the usual name of a tensile strength.
///
/// # Source
/// The International System of Units, 9th edition (2019); pound-force and inch: B.N. Taylor, A. Thompson,
/// "The International System of Units", NIST SP 330 (2008), and A. Thompson, B.N. Taylor, NIST SP 811 (2008),
/// appendix B.
const UNITS: [(&str, f64, i32, [i32; 4]); 44] = [
    ("m", 1.0, 0, [0, 1, 0, 0]),
    ("km", 1.0, 3, [0, 1, 0, 0]),
    ("dm", 1.0, -1, [0, 1, 0, 0]),
    ("cm", 1.0, -2, [0, 1, 0, 0]),
    ("mm", 1.0, -3, [0, 1, 0, 0]),
    ("um", 1.0, -6, [0, 1, 0, 0]),
    ("nm", 1.0, -9, [0, 1, 0, 0]),
    ("in", 2.54, -2, [0, 1, 0, 0]),
    ("s", 1.0, 0, [0, 0, 1, 0]),
    ("ms", 1.0, -3, [0, 0, 1, 0]),
    ("us", 1.0, -6, [0, 0, 1, 0]),
    ("ns", 1.0, -9, [0, 0, 1, 0]),
    ("kg", 1.0, 0, [1, 0, 0, 0]),
    ("g", 1.0, -3, [1, 0, 0, 0]),
    ("mg", 1.0, -6, [1, 0, 0, 0]),
    ("t", 1.0, 3, [1, 0, 0, 0]),
    ("N", 1.0, 0, [1, 1, -2, 0]),
    ("kN", 1.0, 3, [1, 1, -2, 0]),
    ("MN", 1.0, 6, [1, 1, -2, 0]),
    ("mN", 1.0, -3, [1, 1, -2, 0]),
    ("Pa", 1.0, 0, [1, -1, -2, 0]),
    ("hPa", 1.0, 2, [1, -1, -2, 0]),
    ("kPa", 1.0, 3, [1, -1, -2, 0]),
    ("MPa", 1.0, 6, [1, -1, -2, 0]),
    ("GPa", 1.0, 9, [1, -1, -2, 0]),
    ("bar", 1.0, 5, [1, -1, -2, 0]),
    ("psi", 6.894_757_293_168_361, 3, [1, -1, -2, 0]),
    ("ksi", 6.894_757_293_168_361, 6, [1, -1, -2, 0]),
    ("cP", 1.0, -3, [1, -1, -1, 0]),
    // A darcy is the permeability for 1 cm/s of a liquid of 1 cP under 1 atm/cm.
    ("mD", 1e5 / 101_325.0, -15, [0, 2, 0, 0]),
    ("J", 1.0, 0, [1, 2, -2, 0]),
    ("kJ", 1.0, 3, [1, 2, -2, 0]),
    ("MJ", 1.0, 6, [1, 2, -2, 0]),
    ("mJ", 1.0, -3, [1, 2, -2, 0]),
    ("W", 1.0, 0, [1, 2, -3, 0]),
    ("Hz", 1.0, 0, [0, 0, -1, 0]),
    ("kHz", 1.0, 3, [0, 0, -1, 0]),
    ("MHz", 1.0, 6, [0, 0, -1, 0]),
    ("deg", 1.0, 0, [0, 0, 0, 1]),
    ("rad", 180.0 / std::f64::consts::PI, 0, [0, 0, 0, 1]),
    ("mrad", 180.0 / std::f64::consts::PI, -3, [0, 0, 0, 1]),
    ("rev", 360.0, 0, [0, 0, 0, 1]),
    ("rpm", 6.0, 0, [0, 0, -1, 1]),
    ("%", 1.0, -2, [0, 0, 0, 0]),
];

/// Other ways to write a unit.
const SPELLINGS: [(&str, &str); 7] = [
    ("°", "deg"),
    ("µm", "um"),
    ("μm", "um"),
    ("µs", "us"),
    ("μs", "us"),
    ("degree", "deg"),
    ("degrees", "deg"),
];

/// The symbols of all units.
pub(crate) fn symbols() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|(symbol, ..)| *symbol)
}

/// The unit of a symbol, and the power that is written with it: 3 for `cm3` and `cm³`, 1 for `cm`.
pub(crate) fn find(symbol: &str) -> Option<(Unit, i32)> {
    let symbol = SPELLINGS.iter().find(|(other, _)| *other == symbol).map_or(symbol, |(_, usual)| usual);
    if let Some((_, factor, tens, exponents)) = UNITS.iter().find(|(known, ..)| *known == symbol) {
        return Some((Unit { factor: *factor, tens: *tens, dimension: Dimension::of(*exponents) }, 1));
    }
    let digit = symbol.chars().next_back()?;
    let (power, raised) = match digit {
        '²' => (2, true),
        '³' => (3, true),
        '2'..='4' => (digit as i32 - '0' as i32, false),
        _ => return None,
    };
    let (unit, _) = find(&symbol[..symbol.len() - digit.len_utf8()]).filter(|(_, power)| *power == 1)?;
    // Plain digits only where they are customary, so that names such as `t2` and `N4` are free.
    let is_length = unit.dimension == Dimension::of([0, 1, 0, 0]);
    let is_customary = is_length || symbol == "s2";
    (raised || is_customary).then_some((unit, power))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_are_found_with_their_powers_and_near_misses_are_not() {
        for (symbol, tens, power) in
            [("mm", -3, 1), ("cm3", -2, 3), ("cm³", -2, 3), ("s²", 0, 2), ("°", 0, 1)]
        {
            assert_eq!(find(symbol).map(|(unit, power)| (unit.tens, power)), Some((tens, power)), "{symbol}");
        }
        for symbol in ["", "2", "²", "Gpa", "mm22", "m²²", "t2", "m5", "h", "radius"] {
            assert_eq!(find(symbol), None, "{symbol}");
        }
    }

    #[test]
    fn dimensions_have_names() {
        let [length, time] = ["m", "s"].map(|symbol| find(symbol).unwrap().0.dimension);
        assert_eq!(length.to_string(), "a length");
        assert_eq!(length.over(time).to_string(), "a velocity");
        assert_eq!(length.power(0.5).unwrap().to_string(), "in m^(6/12)");
        assert_eq!(length.power(2.0).unwrap().times(time).to_string(), "in m^2·s");
        assert_eq!(length.power(0.3), None);
    }
}
