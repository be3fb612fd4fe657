//! Fields by which elements and spheres are coloured.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Value, json};

use crate::fields::colours::NO_VALUE;
use crate::fields::place::Place;
use crate::fields::quantity::{Ends, Number, Quantity, Shown, Span};
use crate::fields::range::{Range, Scale, SphereRanges};
use crate::fields::state::State;
use crate::fields::table::{QUANTITIES, SHOWN};
use crate::picture::colour::{self, Rgb, SEA};

/// A field by which elements and spheres are coloured: a [`Quantity`] that has colours. In model files and
/// options it is written as its key. Some fields exist for elements only, some for spheres only, and some for
/// both, such as the velocity.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Field {
    /// Index of its row in [`QUANTITIES`].
    row: usize,
}

/// Fields of elements with a continuous scale, in the order of their arrays in a frame.
pub(crate) const SCALES: [Field; count_of_scales()] = scales();

/// Fields of spheres with a continuous scale, in the order of their arrays in a frame.
pub(crate) const SPHERE_SCALES: [Field; 5] =
    [Field::VELOCITY, Field::of("spin"), Field::of("force"), Field::of("radius"), Field::of("coordination")];

impl Field {
    /// All fields, in the order of menus and lists.
    pub const ALL: [Self; SHOWN.len()] = {
        let mut all = [Self::of(SHOWN[0]); SHOWN.len()];
        let mut k = 1;
        while k < all.len() {
            all[k] = Self::of(SHOWN[k]);
            k += 1;
        }
        all
    };

    /// The largest principal stress, in two dimensions that in the plane.
    pub const MAX_PRINCIPAL: Self = Self::of("max_principal");
    /// The smallest principal stress, in two dimensions that in the plane.
    pub const MIN_PRINCIPAL: Self = Self::of("min_principal");
    /// The von Mises equivalent stress.
    pub const VON_MISES: Self = Self::of("von_mises");
    /// The magnitude of the velocity.
    pub const VELOCITY: Self = Self::of("velocity");
    /// The magnitude of the displacement.
    pub const DISPLACEMENT: Self = Self::of("displacement");
    /// The largest damage of the joints of the element.
    pub const DAMAGE: Self = Self::of("damage");
    /// Number of the body.
    pub const BODY: Self = Self::of("body");
    /// Number of the material.
    pub const MATERIAL: Self = Self::of("material");
    /// Number of the group of a sphere.
    pub const GROUP: Self = Self::of("group");
    /// Normal forces of the contacts of spheres, as lines.
    pub const FORCE_CHAINS: Self = Self::of("force_chains");

    /// Returns the field with this key. The compiler runs this: a key without a field is an error of
    /// compilation.
    const fn of(key: &str) -> Self {
        let mut k = 0;
        loop {
            assert!(k < QUANTITIES.len(), "no row of the table has this key and colours");
            if QUANTITIES[k].shown.is_some() && equal(QUANTITIES[k].key, key) {
                return Self { row: k };
            }
            k += 1;
        }
    }

    /// Returns the field with this key; `None` if there is none.
    pub fn named(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|field| field.key() == key)
    }

    /// Returns its row of the table.
    pub fn quantity(self) -> &'static Quantity {
        &QUANTITIES[self.row]
    }

    /// Returns the name of the field in options, model files and reports.
    pub fn key(self) -> &'static str {
        self.quantity().key
    }

    /// Returns the name of the field in texts.
    pub fn name(self) -> &'static str {
        self.quantity().name
    }

    /// Returns the unit of the values; empty if they have none.
    pub fn unit(self) -> &'static str {
        self.quantity().unit
    }

    /// Whether elements have values of the field.
    pub fn is_of_elements(self) -> bool {
        matches!(self.quantity().place, Place::Node | Place::Element)
    }

    /// Returns the row of the table with the values of spheres, of the same key; `None` if they have none.
    pub fn of_spheres(self) -> Option<&'static Quantity> {
        let is_same =
            |row: &&Quantity| row.place == Place::Sphere && row.shown.is_some() && row.key == self.key();
        QUANTITIES.iter().find(is_same)
    }

    /// Returns the field by which these numbers of elements and spheres are coloured where this one is asked
    /// for: the velocity, if only the spheres are there and have no values of this one.
    #[must_use]
    pub fn among(self, [elements, spheres]: [usize; 2]) -> Self {
        let is_of_spheres = self.of_spheres().is_some() || self == Self::FORCE_CHAINS;
        if elements == 0 && spheres > 0 && !is_of_spheres { Self::VELOCITY } else { self }
    }

    /// Returns the index of the field in [`SPHERE_SCALES`].
    pub(crate) fn sphere_scale(self) -> Option<usize> {
        SPHERE_SCALES.iter().position(|&other| other == self)
    }

    /// Whether colours show values on a scale, and not numbers that count something.
    pub(crate) fn is_continuous(self) -> bool {
        matches!(self.quantity().shown, Some(Shown::Scale { .. }))
    }

    /// Returns the index of the field in [`SCALES`].
    pub(crate) fn scale(self) -> Option<usize> {
        SCALES.iter().position(|&other| other == self)
    }

    /// Returns the ends of the scale; `None` if there is no scale.
    pub(crate) fn ends(self) -> Option<Ends> {
        match self.quantity().shown {
            Some(Shown::Scale { ends, .. }) => Some(ends),
            _ => None,
        }
    }

    /// Returns the number by which elements are coloured; `None` if there is a scale, or if elements have no
    /// such number.
    pub(crate) fn number(self) -> Option<Number> {
        match self.quantity().shown {
            Some(Shown::Number(number)) if self.is_of_elements() => Some(number),
            _ => None,
        }
    }

    /// Returns the name of the column with the largest value in the page's table of frames, with its unit;
    /// `None` if there is no such column.
    pub(crate) fn column(self) -> Option<String> {
        match self.quantity().shown {
            Some(Shown::Scale { column: Some(name), .. }) => Some(format!("{name} ({})", self.unit())),
            _ => None,
        }
    }

    /// Returns the colours from the lowest value to the highest.
    pub(crate) fn ramp(self) -> &'static [Rgb; 17] {
        match self.quantity().shown {
            Some(Shown::Scale { ramp, .. }) => ramp,
            _ => &SEA,
        }
    }

    /// Returns the values of all elements. The value of nodes is the mean over the nodes of the element, and
    /// of a vector its magnitude.
    pub(crate) fn values(self, state: &dyn State) -> Vec<f64> {
        let quantity = self.quantity();
        let of_element = |element: usize| match quantity.place {
            Place::Node => {
                let nodes = state.corners(element);
                let sum = |axis: usize| {
                    nodes.iter().map(|&node| quantity.value(state, node as usize, axis)).sum::<f64>()
                };
                let total = if quantity.components.is_empty() {
                    sum(0)
                } else {
                    (0..quantity.width()).map(sum).fold(0.0, f64::hypot)
                };
                total / nodes.len() as f64
            }
            _ => quantity.value(state, element, 0),
        };
        (0..state.count(Place::Element)).map(of_element).collect()
    }

    /// Returns the range of a series by the scales of the elements and of the spheres of its frames. It
    /// covers at least 98 % of the elements in every frame, so that a few extreme values do not use up the
    /// colours.
    pub(crate) fn range<'a>(
        self,
        frames: impl Iterator<Item = (&'a [Scale; SCALES.len()], &'a SphereRanges)>,
    ) -> Range {
        let signed = match self.ends() {
            Some(Ends::Fixed(low, high)) => return Range { low, high },
            Some(ends) => ends == Ends::Symmetric,
            None => return Range { low: 0.0, high: 1.0 },
        };
        let mut largest = 0.0_f64;
        for (scales, spheres) in frames {
            let of_elements = self.scale().map(|scale| scales[scale].usual);
            let of_spheres = self.sphere_scale().map(|scale| spheres.scales[scale].usual);
            let of_chains = (self == Self::FORCE_CHAINS).then_some(spheres.chains.usual);
            for [low, high] in of_elements.into_iter().chain(of_spheres).chain(of_chains) {
                largest = largest.max(high);
                if signed {
                    largest = largest.max(-low);
                }
            }
        }
        let high = if largest > 0.0 { largest } else { 1.0 };
        Range { low: if signed { -high } else { 0.0 }, high }
    }

    /// Returns the colour of a value on a scale with this range.
    pub(crate) fn colour(self, value: f64, range: Range) -> Rgb {
        if value.is_nan() {
            return NO_VALUE;
        }
        colour::at(self.ramp(), range.share(value))
    }

    /// Returns a sentence that describes the value of an element or a sphere.
    pub fn description(self) -> String {
        let &Quantity { about, name, sign, unit, span, place, components, .. } = self.quantity();
        let mut text = match place {
            Place::Node if !components.is_empty() => format!("the magnitude of the {name}"),
            Place::Sphere if !components.is_empty() => format!("the magnitude of {about}"),
            _ if sign.is_empty() => about.to_owned(),
            _ => format!("{about}, {sign}"),
        };
        if let Span::Between(low, high) = span {
            text = format!("{text}, from {low} to {high}");
        }
        if !unit.is_empty() {
            text = format!("{text}, {unit}");
        }
        text[..1].to_uppercase() + &text[1..] + "."
    }
}

/// Returns the keys of the fields of [`SCALES`], in one line. Frames begin with it, so that a frame with
/// other fields is not read.
pub(crate) fn line_of_keys() -> String {
    SCALES.map(Field::key).join(",") + "\n"
}

/// Whether two texts are equal. The compiler cannot run the operator.
const fn equal(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut k = 0;
    while k < one.len() && k < other.len() && one[k] == other[k] {
        k += 1;
    }
    k == one.len() && k == other.len()
}

/// Whether elements have values of a field on a scale.
const fn has_scale(field: Field) -> bool {
    let row = &QUANTITIES[field.row];
    matches!(row.place, Place::Node | Place::Element) && matches!(row.shown, Some(Shown::Scale { .. }))
}

const fn count_of_scales() -> usize {
    let (mut count, mut k) = (0, 0);
    while k < Field::ALL.len() {
        if has_scale(Field::ALL[k]) {
            count += 1;
        }
        k += 1;
    }
    count
}

const fn scales() -> [Field; count_of_scales()] {
    let mut scales = [Field::ALL[0]; count_of_scales()];
    let (mut count, mut k) = (0, 0);
    while k < Field::ALL.len() {
        if has_scale(Field::ALL[k]) {
            scales[count] = Field::ALL[k];
            count += 1;
        }
        k += 1;
    }
    scales
}

impl fmt::Debug for Field {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.key())
    }
}

impl Serialize for Field {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

impl<'de> Deserialize<'de> for Field {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = Cow::<str>::deserialize(deserializer)?;
        Self::named(&key).ok_or_else(|| serde::de::Error::unknown_variant(&key, &SHOWN))
    }
}

/// One word of a list, each with its description.
impl JsonSchema for Field {
    fn schema_name() -> Cow<'static, str> {
        "Field".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let word = |field: Self| {
            let (key, description) = (field.key(), field.description());
            json!({ "description": description, "type": "string", "const": key })
        };
        let words: Vec<Value> = Self::ALL.into_iter().map(word).collect();
        let mut schema = Schema::default();
        schema.insert(
            "description".to_owned(),
            "A quantity by which elements and spheres are coloured.".into(),
        );
        schema.insert("oneOf".to_owned(), words.into());
        schema
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fields::colours::SIGNED;

    #[test]
    fn no_stress_is_pale_and_both_signs_are_as_dark() {
        let range = Range { low: -2.0, high: 2.0 };
        assert_eq!(Field::MAX_PRINCIPAL.colour(0.0, range), SIGNED[8]);
        assert_eq!(Field::MAX_PRINCIPAL.colour(9.0, range), SIGNED[16]);
        assert_eq!(Field::MAX_PRINCIPAL.colour(f64::NAN, range), NO_VALUE);
        let light = |[r, g, b]: Rgb| 2 * i32::from(r) + 5 * i32::from(g) + i32::from(b);
        for k in 0..8 {
            assert!(light(SIGNED[k]) < light(SIGNED[k + 1]) && light(SIGNED[16 - k]) < light(SIGNED[15 - k]));
        }
    }
}
