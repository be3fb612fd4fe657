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
    /// A sphere or a disc.
    Sphere,
    /// A contact of a sphere with another one, a wall or a body.
    SphereContact,
    /// A wall.
    Wall,
}

impl Place {
    /// Returns the word for the place.
    pub fn word(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::Element => "element",
            Self::Joint => "joint",
            Self::Contact => "contact",
            Self::Sphere => "sphere",
            Self::SphereContact => "sphere contact",
            Self::Wall => "wall",
        }
    }
}
