//! The sets on which other search libraries were timed, in 3D.
//!
//! Densities reproduce the pair counts recorded with those timings: half of the volume is filled in [`poly`]
//! and [`lognormal`], a tenth inside the clusters of [`sparse`]. The recorded sets were drawn from other
//! random numbers, so counts agree statistically, not exactly.
//!
//! | set | `n` | pairs recorded |
//! |---|---|---|
//! | [`gas`] | 100,000 | 581,078 |
//! | [`gas`] | 1,000,000 | 5,904,992 |
//! | [`sparse`] | 1,000,000 | 373,064 |
//! | [`dense`] | 1,000,000 | 38,787,501 |
//! | [`poly`] | 400,000 | 269,942 |
//! | [`lognormal`] | 1,000,000 | 1,803,988 |
//!
//! [`unlike`] and [`boxes`] were added later.
//!
//! Every function returns the errors of the generator that it calls. With these parameters only
//! [`Error::OutOfMemory`] can occur, unless stated otherwise.

use crate::boxes::Boxes;
use crate::cloud::Cloud;
use crate::error::Error;
use crate::sizes::Sizes;

/// Diameter 1.
const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

/// Equal spheres, 12 neighbours each.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub fn gas(n: usize, seed: u64) -> Result<Cloud<3>, Error> {
    crate::gas(n, seed, 12.0, EQUAL)
}

/// Clusters of 1,000 equal spheres, 0.8 neighbours each, in a domain 10⁵ diameters wide.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub fn sparse(n: usize, seed: u64) -> Result<Cloud<3>, Error> {
    crate::clusters(n, seed, 1_000, 1e5, 0.8, EQUAL)
}

/// Equal spheres, 80 neighbours each, as in molecular dynamics.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub fn dense(n: usize, seed: u64) -> Result<Cloud<3>, Error> {
    crate::gas(n, seed, 80.0, EQUAL)
}

/// Radii from 1 to 50 by a power law with exponent −2.5, 1.4 neighbours each.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub fn poly(n: usize, seed: u64) -> Result<Cloud<3>, Error> {
    crate::gas(n, seed, 1.4, Sizes::PowerLaw { min: 1.0, max: 50.0, exponent: -2.5 })
}

/// Lognormal radii with median 0.5 and sigma 0.25, 3.648 neighbours each.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub fn lognormal(n: usize, seed: u64) -> Result<Cloud<3>, Error> {
    crate::gas(n, seed, 3.648, Sizes::Lognormal { median: 0.5, sigma: 0.25 })
}

/// Radii from 1 to `ratio` by a power law with exponent −2.5, 4 neighbours each: the number of couples per
/// sphere is the same for any ratio.
///
/// # Errors
/// [`Error::OutOfMemory`]; [`Error::MinAboveMax`], [`Error::OutOfRange`] for a `ratio` that is not at least 1
/// and finite.
pub fn unlike(n: usize, seed: u64, ratio: f64) -> Result<Cloud<3>, Error> {
    crate::gas(n, seed, 4.0, Sizes::PowerLaw { min: 1.0, max: ratio, exponent: -2.5 })
}

/// Boxes whose longest edge is 1 to 100 times the shortest, 12 neighbours each.
///
/// # Errors
/// [`Error::OutOfMemory`].
pub fn boxes(n: usize, seed: u64) -> Result<Boxes<3>, Error> {
    crate::boxes(n, seed, 12.0, 100.0)
}
