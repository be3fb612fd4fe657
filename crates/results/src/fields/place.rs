//! The parts of a model that have values of quantities.

/// The part of a model that has a value of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// A node.
    Node,
    /// An element.
    Element,
    /// A joint that softens or is broken.
    Joint,
    /// A couple of elements that press each other.
    Contact,
}

impl Place {
    /// Returns the word for the place.
    pub fn word(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::Element => "element",
            Self::Joint => "joint",
            Self::Contact => "contact",
        }
    }
}
