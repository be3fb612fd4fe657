//! The two sides between which a force acts.

/// One of the two between which a force acts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TouchingSide {
    /// The spheres of the group with this name.
    Spheres(String),
    /// Bodies with these numbers, ascending.
    Bodies(Vec<u32>),
}

impl TouchingSide {
    /// The name of spheres, or the numbers of bodies.
    pub(super) fn parts(&self) -> (String, Vec<u32>) {
        match self {
            Self::Spheres(name) => (name.clone(), Vec::new()),
            Self::Bodies(bodies) => (String::new(), bodies.clone()),
        }
    }

    pub(super) fn of_parts((name, bodies): (String, Vec<u32>)) -> Self {
        if name.is_empty() { Self::Bodies(bodies) } else { Self::Spheres(name) }
    }
}
