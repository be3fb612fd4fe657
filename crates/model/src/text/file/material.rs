//! `[[material]]` and `[[interface]]`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::pores::MaterialPores;

/// An elastic material. It breaks if it has the five keys `tensile_strength`, `cohesion`, `friction_angle`,
/// `fracture_energy_i` and `fracture_energy_ii`, and does not break without them or if it is `unbreakable`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Name of the material for bodies and interfaces.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of a material of the library, which gives all keys that this table does not give: "granite", for
    /// instance. `fdem materials` lists them. Default: none, and `density`, `youngs_modulus` and
    /// `poissons_ratio` must be there.
    #[serde(default)]
    #[schemars(schema_with = "crate::text::library::names")]
    pub library: Option<String>,
    /// Whether the model may have no element of the material. Default: false, and that is an error, except
    /// for materials of included files.
    #[serde(default)]
    pub optional: bool,
    /// true: the material never breaks, has no strengths from the library, and can replace one that breaks in
    /// the `materials` of a stage: a core that is softened. Default: false.
    #[serde(default)]
    pub unbreakable: bool,
    /// Density, kg/m³.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "kg/m³"))]
    pub density: f64,
    /// Young's modulus, Pa.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub youngs_modulus: f64,
    /// Poisson's ratio, from above -1 to 0.5; in plane strain and in three dimensions below 0.5.
    #[schemars(extend("exclusiveMinimum" = -1, "maximum" = 0.5, "x-unit" = "1"))]
    pub poissons_ratio: f64,
    /// Bedding, foliation or fibres: elasticity that differs across a plane. `youngs_modulus`,
    /// `poissons_ratio` and strengths of the material are then those along the plane and across it: see
    /// there. Default: the material is alike in all directions.
    #[serde(default)]
    pub anisotropy: Option<Anisotropy>,
    /// Pores with the liquid of `[pores]`, such as
    /// `{ permeability = 1e-15, biot = 0.8, biot_modulus = "8 GPa" }`. Default: none, nothing flows through
    /// the material.
    #[serde(default)]
    pub pores: Option<MaterialPores>,
    /// Viscous damping, as a share of the critical damping of the fastest mode of an element. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 1000, "x-unit" = "1"))]
    pub damping: f64,
    /// Coefficient of friction of contacts, unless an `[[interface]]` says otherwise. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "1"))]
    pub friction: f64,
    /// Coefficient of restitution of contacts of spheres: speed after an impact along the normal over that
    /// before, above 0 and at most 1. Two materials have the lesser of theirs, unless an `[[interface]]` says
    /// otherwise. Default: none, and one of the two materials of a sphere and its partner has it.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub restitution: Option<f64>,
    /// Coefficient of rolling friction of spheres: largest moment against rolling over the reduced radius and
    /// the normal force. Two materials have the lesser of theirs, unless an `[[interface]]` says otherwise.
    /// Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "1"))]
    pub rolling_friction: f64,
    /// Tensile strength, Pa.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub tensile_strength: Option<f64>,
    /// Shear strength without normal stress, Pa.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub cohesion: Option<f64>,
    /// Angle of internal friction, degrees.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 90, "x-unit" = "deg"))]
    pub friction_angle: Option<f64>,
    /// Fracture energy of opening (mode I), J/m².
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_i: Option<f64>,
    /// Fracture energy of sliding (mode II), beyond friction, J/m².
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_ii: Option<f64>,
    /// Weibull modulus of the scatter of tensile strength and cohesion from edge to edge. The mean keeps its
    /// value. At least 1; rock has 2 to 30. Default: no scatter.
    #[serde(default)]
    #[schemars(extend("minimum" = 1, "x-unit" = "1"))]
    pub weibull_modulus: Option<f64>,
    /// Seed of that scatter. Default: 1.
    #[serde(default = "seed")]
    pub weibull_seed: u64,
}

/// A material that is alike in all directions of a plane, its bedding, and different across it: transversely
/// isotropic elasticity. `youngs_modulus` E and `poissons_ratio` ν of the material are those of a stress
/// along the bedding.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Anisotropy {
    /// Young's modulus E' across the bedding, Pa.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub youngs_modulus: f64,
    /// Poisson's ratio ν' of a stress across the bedding: contraction along it over extension across. For a
    /// positive energy, 2 ν'² E/E' is below 1 - ν.
    #[schemars(extend("x-unit" = "1"))]
    pub poissons_ratio: f64,
    /// Shear modulus G' of sliding along the bedding, Pa. That in the plane of the bedding is E/(2 + 2 ν).
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub shear_modulus: f64,
    /// In two dimensions: angle of the bedding to the x axis, degrees; bedding with a positive angle rises to
    /// the right. In three: angle at which it dips below the horizontal (x and y), 0 to 90 degrees. The
    /// bedding turns with the elements.
    #[schemars(extend("minimum" = -90, "maximum" = 90, "x-unit" = "deg"))]
    pub dip: f64,
    /// In three dimensions: direction in which the bedding dips, clockwise from y (north) seen from above, so
    /// that 90 is x (east), degrees. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 360, "x-unit" = "deg"))]
    pub dip_direction: Option<f64>,
    /// Tensile strength of the bedding, Pa; needs `cohesion`. Strengths grow linearly with the angle between
    /// an edge or face and the bedding, up to those of the material at 90 degrees. Default: the same in all
    /// directions.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub tensile_strength: Option<f64>,
    /// Cohesion of the bedding, Pa; needs `tensile_strength`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub cohesion: Option<f64>,
    /// Fracture energy of opening (mode I) of the bedding, J/m². Default: that of the material.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_i: Option<f64>,
    /// Fracture energy of sliding (mode II) of the bedding, J/m². Default: that of the material.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_ii: Option<f64>,
}

/// Contacts between two materials, and the joints between their elements inside one body. Different bodies
/// touch; no interface bonds them.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Interface {
    /// Names of the two. For a material with itself: its contacts with other bodies of it, and all joints
    /// inside of it, in place of the strength of the material.
    pub materials: [String; 2],
    /// Whether its strength may hold nothing together. Default: false, and that is an error.
    #[serde(default)]
    pub optional: bool,
    /// Coefficient of friction of contacts. Default: that of the material with less friction.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "1"))]
    pub friction: Option<f64>,
    /// Coefficient of restitution of spheres that touch. Default: that of the material with the lesser one.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub restitution: Option<f64>,
    /// Coefficient of rolling friction of spheres that touch. Default: that of the material with the lesser
    /// one.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "1"))]
    pub rolling_friction: Option<f64>,
    /// Damping of rolling of spheres that has not reached its friction, as a share of the critical damping.
    /// Default: 0.3 where there is rolling friction.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "1"))]
    pub rolling_damping: Option<f64>,
    /// Coefficient of twisting friction of spheres: largest moment against spinning about the normal over the
    /// reduced radius and the normal force. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "1"))]
    pub twisting_friction: Option<f64>,
    /// Work of adhesion of spheres that touch, J/m², with the law "hertz", which then is that of Johnson,
    /// Kendall and Roberts. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "J/m²"))]
    pub adhesion: Option<f64>,
    /// Penalty of contacts, Pa. Default: from the `penalty` of `[contact]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub penalty: Option<f64>,
    /// Tensile strength of joints between the two, inside bodies, Pa; needs the four keys below. With 0 here
    /// and for `cohesion` the joint is open and has friction only; then it needs no fracture energies.
    /// Default: the strength of the weaker material.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "Pa"))]
    pub tensile_strength: Option<f64>,
    /// Shear strength of these joints without normal stress, Pa; may be 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "Pa"))]
    pub cohesion: Option<f64>,
    /// Angle of friction of these joints, degrees.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 90, "x-unit" = "deg"))]
    pub friction_angle: Option<f64>,
    /// Fracture energy of opening (mode I), J/m². Not needed where the tensile strength is 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_i: Option<f64>,
    /// Fracture energy of sliding (mode II), beyond friction, J/m². Not needed where the cohesion is 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_ii: Option<f64>,
    /// Weibull modulus of the scatter of tensile strength and cohesion from edge to edge. The mean keeps its
    /// value. At least 1; rock has 2 to 30. Default: no scatter.
    #[serde(default)]
    #[schemars(extend("minimum" = 1, "x-unit" = "1"))]
    pub weibull_modulus: Option<f64>,
    /// Seed of that scatter. Default: 1.
    #[serde(default = "seed")]
    pub weibull_seed: u64,
}

fn seed() -> u64 {
    1
}
