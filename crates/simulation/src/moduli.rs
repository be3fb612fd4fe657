//! The moduli of an isotropic material in plane stress, in plane strain and in space.

/// Moduli of a material, Pa: in the plane, or in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moduli {
    pub(crate) shear: f64,
    /// Mean stress over the relative change of area or volume.
    pub(crate) bulk: f64,
    /// P-wave modulus: stress over strain in a compressional wave.
    pub(crate) wave: f64,
    /// σzz over σxx + σyy in the plane.
    pub(crate) out_of_plane: f64,
}
