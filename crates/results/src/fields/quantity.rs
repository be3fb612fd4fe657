//! A row of the table of fields, and the values of its field.

use crate::fields::liquid::LiquidIn;
use crate::fields::place::Place;
use crate::fields::state::State;
use crate::picture::colour::Rgb;

/// A row of the table of fields: a quantity of the results, at each node, element, joint, contact, sphere or
/// wall.
///
/// Files for ParaView, pictures, pages, the Python package and the book take names, units and values from
/// here.
#[derive(Debug)]
#[non_exhaustive]
pub struct Quantity {
    /// Name in files, model files, options and programs. A key is unique among the quantities of a place.
    pub key: &'static str,
    /// Name in texts.
    pub name: &'static str,
    /// Description, without a capital letter and a full stop.
    pub about: &'static str,
    /// Definition and source, in sentences; empty if the description says all.
    pub definition: &'static str,
    /// Unit; empty if there is none.
    pub unit: &'static str,
    /// Sign convention; empty if the values have no sign.
    pub sign: &'static str,
    /// The values that are possible.
    pub span: Span,
    /// The part of a model that has a value.
    pub place: Place,
    /// Names of the components of a vector, tensor or couple; empty for one number.
    pub components: &'static [&'static str],
    /// The number of dimensions in which it exists; `None` for both.
    pub dimensions: Option<usize>,
    /// Whether files for ParaView have it.
    pub in_files: bool,
    /// The liquid without which a model does not have it; `None` if every model has it.
    pub liquid: Option<LiquidIn>,
    /// How elements are coloured by it; `None` if they are not.
    pub(crate) shown: Option<Shown>,
    pub(crate) value: Value,
}

/// The values that a quantity can have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Span {
    /// All numbers.
    Any,
    /// 0 and above.
    NotNegative,
    /// From the first number to the second.
    Between(f64, f64),
}

/// How elements are coloured by a quantity.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shown {
    /// By the value on a scale. An element has the mean over its nodes of a value of nodes, and of a vector
    /// its magnitude.
    Scale {
        /// Colours from the lowest value to the highest.
        ramp: &'static [Rgb; 17],
        ends: Ends,
        /// Name of the column with the largest value in the page's table of frames; `None` for no column.
        column: Option<&'static str>,
    },
    /// By a number that counts bodies, materials or fragments: each number has a colour, in turn.
    Number(Number),
}

/// Ends of a scale of colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ends {
    /// As far below 0 as above: the middle of the colours is 0.
    Symmetric,
    /// From 0 to the largest value.
    FromZero,
    /// The same in all runs.
    Fixed(f64, f64),
}

/// Numbers of elements and spheres that frames have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    /// Of the body of an element, or of the group of a sphere.
    Body,
    Material,
}

/// The value of a quantity in a state: of the node, element, joint or contact with the first number, the
/// component with the second.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Value {
    Real(fn(&dyn State, usize, usize) -> f64),
    /// A whole number, of 64 bits in files.
    Whole(fn(&dyn State, usize, usize) -> i64),
    /// A whole number, of 32 bits in files.
    Short(fn(&dyn State, usize, usize) -> i32),
}

/// All values of a quantity, component by component for each node, element, joint or contact.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum QuantityValues {
    /// Numbers in the unit of the quantity; NaN where there is no value.
    Real(Vec<f64>),
    /// Whole numbers.
    Whole(Vec<i64>),
}

impl Quantity {
    /// Returns the number of components, at least 1.
    pub fn width(&self) -> usize {
        self.components.len().max(1)
    }

    /// Whether it exists in `dimensions` dimensions.
    pub fn exists_in(&self, dimensions: usize) -> bool {
        self.dimensions.is_none_or(|only| only == dimensions)
    }

    /// Whether pictures, animations and pages can colour elements by it.
    pub fn is_drawn(&self) -> bool {
        self.shown.is_some()
    }

    /// Returns a component of the value of a node, element, joint or contact; that of a whole number as a
    /// number.
    pub(crate) fn value(&self, state: &dyn State, number: usize, component: usize) -> f64 {
        match self.value {
            Value::Real(of) => of(state, number, component),
            Value::Whole(of) => of(state, number, component) as f64,
            Value::Short(of) => f64::from(of(state, number, component)),
        }
    }

    /// Returns all values in a state.
    pub(crate) fn values(&self, state: &dyn State) -> QuantityValues {
        let width = self.width();
        let places = || (0..state.count(self.place)).flat_map(|k| (0..width).map(move |part| (k, part)));
        match self.value {
            Value::Real(of) => QuantityValues::Real(places().map(|(k, part)| of(state, k, part)).collect()),
            Value::Whole(of) => QuantityValues::Whole(places().map(|(k, part)| of(state, k, part)).collect()),
            Value::Short(of) => {
                QuantityValues::Whole(places().map(|(k, part)| of(state, k, part).into()).collect())
            }
        }
    }
}
