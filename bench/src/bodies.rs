//! Bodies of triangles and of tetrahedra for the benchmarks of the simulation.

mod failing;
mod meshed;
mod parts;
mod plane;
mod space;

pub use meshed::MeshedCube;
pub use plane::Plane;
pub use space::Space;

/// The body that is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// In two dimensions.
    Plane(Plane),
    /// In three dimensions.
    Space(Space),
}

impl Body {
    /// All bodies.
    pub fn all() -> impl Iterator<Item = Self> {
        Plane::ALL.into_iter().map(Self::Plane).chain(Space::ALL.into_iter().map(Self::Space))
    }

    /// The name, without spaces.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plane(body) => body.name(),
            Self::Space(body) => body.name(),
        }
    }

    /// A short description.
    pub fn what(self) -> &'static str {
        match self {
            Self::Plane(body) => body.what(),
            Self::Space(body) => body.what(),
        }
    }

    /// Steps of one timing with this number of elements: about half a second on one core. The number is
    /// fixed, so that all runs and all versions take the same steps.
    pub fn steps(self, elements: usize) -> u64 {
        let millions = match self {
            Self::Plane(Plane::Bar | Plane::Disc) => 27.0,
            Self::Plane(Plane::Adaptive) => 20.0,
            Self::Plane(Plane::Joined | Plane::Intrinsic) => 6.5,
            Self::Plane(Plane::Heap) => 0.9,
            Self::Space(Space::Cube) => 14.0,
            Self::Plane(Plane::Near) | Self::Space(Space::CubeAdaptive) => 10.0,
            Self::Space(Space::CubeJoined) => 2.0,
            Self::Plane(Plane::Blown) => 1.0,
            Self::Space(Space::Debris | Space::CubeBlown) => 0.3,
            Self::Plane(Plane::Softening) | Self::Space(Space::CubeNear) => 3.0,
            Self::Plane(Plane::Breaking) | Self::Space(Space::CubeSoftening) => 1.5,
            Self::Space(Space::CubeBreaking) => 0.8,
        };
        ((1e6 * millions / elements as f64) as u64).max(2)
    }
}
