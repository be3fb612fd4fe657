//! `[pores]`, `[[pore_surface]]`, and the pores of a `[[material]]`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::boundary::Side;
use crate::text::file::vector::Vector;

/// A liquid in the pores of the materials that have `pores`: it flows by Darcy's law, and its pressure pushes
/// elements apart (Biot). Stresses of the model and of results are then effective ones, and strengths are
/// compared with them. The density of a material is that with the liquid. The gravity of the model acts on
/// the liquid, in full from the beginning. In plane strain and in three dimensions.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pores {
    /// Dynamic viscosity, Pa s. Default: that of `[fluid]`; without one 1e-3, water at 20 °C.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa*s"))]
    pub viscosity: Option<f64>,
    /// Density, kg/m³. Default: that of `[fluid]`; without one 998, water.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "kg/m³"))]
    pub density: Option<f64>,
    /// Bulk modulus, Pa, for materials with a `porosity`. Default: that of `[fluid]`; without one 2.2e9,
    /// water.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub bulk_modulus: Option<f64>,
    /// Pressure in all pores at the beginning, Pa. Default: 0.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub initial_pressure: Option<f64>,
    /// Height of a water level, m, in place of `initial_pressure`: the liquid is at rest at the beginning,
    /// with no pressure at this height. Heights are along gravity, upwards from the origin: y, or z in three
    /// dimensions, for the usual gravity. Above the level the pressure is negative, as all pores are full.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub water_level: Option<f64>,
    /// Number of steps of the solid in each step of the flow. Pressures follow the volumes of elements in
    /// each step of the solid. Default: 10.
    #[serde(default = "steps")]
    #[schemars(range(min = 1))]
    pub steps: u32,
    /// Name of the stage from which on pores have their liquid. Default: the first.
    #[serde(default)]
    pub from_stage: Option<String>,
}

/// Pores of a material. Exactly one of `biot_modulus` and `porosity`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "material_pores")]
pub struct MaterialPores {
    /// Permeability, m²: one number for all directions, [x, y] or [x, y, z] along the axes, or a symmetric
    /// tensor [xx, yy, xy] or [xx, yy, zz, xy, yz, xz]. It stays as the body turns.
    #[schemars(extend("x-unit" = "m²"))]
    pub permeability: Permeability,
    /// Biot's coefficient, above 0 and at most 1: 1 - K/Ks, with the bulk moduli of the dry material and of
    /// its grains.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub biot: f64,
    /// Biot's modulus, Pa: rise of the pressure for each unit of liquid that comes into a body of constant
    /// volume, over the volume of the body.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub biot_modulus: Option<f64>,
    /// Porosity, at most `biot`: the reciprocal of Biot's modulus is then porosity/Kf + (biot - porosity)/Ks,
    /// with the bulk moduli of the liquid and of the grains.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub porosity: Option<f64>,
    /// Bulk modulus Ks of the grains, Pa; goes with `porosity`. Default: K/(1 - biot), with the bulk modulus
    /// K = E/(3 - 6 ν) of the material; grains are rigid if `biot` is 1. A material with `anisotropy` needs
    /// it if `biot` is below 1.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub grain_modulus: Option<f64>,
}

/// A permeability.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Permeability {
    /// The same in all directions, m².
    Isotropic(#[schemars(extend("exclusiveMinimum" = 0))] f64),
    /// Along the axes, or all components of a tensor, m².
    Tensor(#[schemars(length(min = 2, max = 6))] Vec<f64>),
}

/// A part of the surface of bodies with pores at which the pressure is known, or through which a known flow
/// comes in; or a well. The rest of the surface is sealed. Where: `body` (default: all bodies with pores),
/// and at most one of side, sides, box, group, at. How: exactly one of `pressure` and `rate`. When: at most
/// one of ramp, table, `table_file` and expression (default: constant from the start).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoreSurface {
    /// Name of the surface, and of its column in the history.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of a body. Without side, sides, box, group and at it is the whole surface of the body.
    #[serde(default)]
    pub body: Option<String>,
    /// Side of the body, or of all bodies with pores together, as that of a `[[boundary]]`.
    #[serde(default)]
    pub side: Option<Side>,
    /// Several sides, in a list.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub sides: Option<Vec<Side>>,
    /// Box [xmin, ymin, xmax, ymax] or [xmin, ymin, zmin, xmax, ymax, zmax], m: the outer edges or faces
    /// inside.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box", length(min = 4, max = 6))]
    #[schemars(extend("x-unit" = "m"))]
    pub limits: Option<Vec<f64>>,
    /// Group of outer edges or faces, such as "outer", "holes", or a physical group of a mesh file.
    #[serde(default)]
    pub group: Option<String>,
    /// Point [x, y] or [x, y, z] in a body, m: a well at the nearest node.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub at: Option<Vector>,
    /// Pressure that is held, Pa: 0 for a drained surface. A node of two such surfaces has that of the first.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub pressure: Option<f64>,
    /// Volume that comes in through the whole of it, m³/s, spread evenly; in two dimensions through the whole
    /// thickness. Negative: liquid is taken out.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m³/s"))]
    pub rate: Option<f64>,
    /// Time within which the pressure or rate rises from 0 to its full value, as half a cosine, s.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub ramp: Option<f64>,
    /// Factor of the pressure or rate over time, [[time, factor], …], s: linear between the entries, constant
    /// before the first and after the last.
    #[serde(default)]
    #[schemars(length(min = 1))]
    #[schemars(extend("x-unit" = ["s", "1"]))]
    pub table: Option<Vec<[f64; 2]>>,
    /// CSV file with such a table: one row for each time, s, with its factor.
    #[serde(default)]
    pub table_file: Option<String>,
    /// Factor of the pressure or rate as an expression of the time `t` in seconds, such as "exp(-t/1ms)".
    /// Straight lines over 4000 intervals of the run stand for it.
    #[serde(default)]
    pub expression: Option<String>,
    /// Names of the stages in which it acts. In the others it is sealed. The times of ramp and table begin
    /// with the first of them. Default: all.
    #[serde(default)]
    pub stages: Option<Vec<String>>,
}

impl PoreSurface {
    /// The sides on which it lies.
    pub(crate) fn all_sides(&self) -> impl Iterator<Item = Side> {
        self.side.into_iter().chain(self.sides.iter().flatten().copied())
    }
}

fn steps() -> u32 {
    10
}
