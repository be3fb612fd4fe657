//! `[[body]]`: shapes and meshes.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

/// A body, or several of one kind. It has exactly one shape: mesh, rectangle, disc, ring, polygon, voronoi or packing.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name of the body for boundaries, histories and results.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of the material of the body.
    pub material: String,
    /// Mean edge of the elements, m. Meshes from files have their own size and take no such key.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mesh_size: Option<f64>,
    /// Seed of the mesh: another seed gives another mesh. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// Angle by which the body is turned about the middle of its bounding box, degrees, counter-clockwise. Default: 0.
    #[serde(default)]
    pub angle: f64,
    /// Translation [x, y] after the turn, m. Default: [0, 0].
    #[serde(default)]
    pub translate: [f64; 2],
    /// Velocity [x, y] at the start, m/s. Default: [0, 0].
    #[serde(default)]
    pub velocity: Option<[f64; 2]>,
    /// A file with a mesh of triangles: Gmsh .msh 2.2 or 4.1, or another format that `fdem contacts` reads. Its path is relative to the model file.
    #[serde(default)]
    pub mesh: Option<String>,
    /// Physical groups of surfaces to take from a mesh file. Default: the whole file.
    #[serde(default)]
    pub only: Option<Vec<String>>,
    /// Materials of physical groups of a mesh file, as { group = "material" }. Groups that are not named have the material of the body.
    #[serde(default)]
    pub groups: BTreeMap<String, String>,
    /// A rectangle along the axes.
    #[serde(default)]
    pub rectangle: Option<Rectangle>,
    /// A disc.
    #[serde(default)]
    pub disc: Option<Disc>,
    /// The area between two circles with the same centre.
    #[serde(default)]
    pub ring: Option<Ring>,
    /// A polygon.
    #[serde(default)]
    pub polygon: Option<Polygon>,
    /// Voronoi grains in an outline. Their boundaries are edges of the mesh.
    #[serde(default)]
    pub voronoi: Option<Voronoi>,
    /// Discs or polygons that do not overlap. Each is a body of its own.
    #[serde(default)]
    pub packing: Option<Packing>,
}

/// A rectangle along the axes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Lower left corner, m.
    pub min: [f64; 2],
    /// Upper right corner, m.
    pub max: [f64; 2],
    /// Holes: each { centre = [x, y], radius = r } or a list of points. Default: none.
    #[serde(default)]
    pub holes: Vec<Hole>,
}

/// A disc.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Centre [x, y], m. Default: [0, 0].
    #[serde(default)]
    pub centre: [f64; 2],
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
}

/// The area between two circles with the same centre.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ring {
    /// Centre [x, y], m. Default: [0, 0].
    #[serde(default)]
    pub centre: [f64; 2],
    /// Radius of the outer circle, m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
    /// Radius of the inner circle, m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inner_radius: f64,
}

/// A polygon, which may have holes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Polygon {
    /// Corners [x, y] in their order around the outline, either way round, m. The outline closes by itself.
    #[schemars(length(min = 3))]
    pub points: Vec<[f64; 2]>,
    /// Holes: each { centre = [x, y], radius = r } or a list of points. Default: none.
    #[serde(default)]
    pub holes: Vec<Hole>,
}

/// A hole in a body.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Hole {
    /// Corners in their order around the hole, m.
    Points(#[schemars(length(min = 3))] Vec<[f64; 2]>),
    /// A circle.
    Disc(Disc),
}

/// Voronoi cells of random points that were spread evenly.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Voronoi {
    /// Outline that the grains fill: { rectangle = … }, { disc = … } or { polygon = … }.
    pub outline: Outline,
    /// Number of grains.
    #[schemars(range(min = 1, max = 100_000))]
    pub grains: usize,
    /// Seed of the grains: another seed gives other grains. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// Rounds in which each point moves to the middle of its cell (Lloyd's algorithm): the more, the more alike the grains. Default: 3.
    #[serde(default = "rounds")]
    #[schemars(range(max = 100))]
    pub rounds: u32,
    /// Materials of the grains. Neighbours get different ones where that is possible: with four or more materials nearly everywhere. An `[[interface]]` of two
    /// materials gives the strength between such neighbours. Default: the material of the body.
    #[serde(default)]
    pub materials: Vec<String>,
}

/// Outline of grains; exactly one of the keys.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Outline {
    /// A rectangle along the axes.
    #[serde(default)]
    pub rectangle: Option<Rectangle>,
    /// A disc.
    #[serde(default)]
    pub disc: Option<Disc>,
    /// A polygon.
    #[serde(default)]
    pub polygon: Option<Polygon>,
}

/// Bodies of one kind that do not overlap, at random places or from a file.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Packing {
    /// Shape of the bodies: "disc" or "polygon". Default: "disc".
    #[serde(default)]
    pub shape: Piece,
    /// Number of bodies, at random places.
    #[serde(default)]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub count: Option<usize>,
    /// Smallest and largest radius, m; for polygons, that of the circle around them.
    #[serde(default)]
    pub radius: Option<[f64; 2]>,
    /// Rectangle that the bodies fill: { min = [x, y], max = [x, y] }.
    #[serde(default)]
    pub within: Option<Rectangle>,
    /// Least distance between two bodies, and between a body and the sides of the rectangle, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub gap: f64,
    /// Smallest and largest number of corners of polygons. Default: [5, 8].
    #[serde(default = "corners")]
    #[schemars(inner(range(min = 3, max = 100)))]
    pub corners: [u32; 2],
    /// Seed of the packing: another seed gives another packing. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// File with x, y and radius of each body, m, instead of `count`, `radius` and `within`: any format that `fdem contacts` reads. Its path is relative to the model file.
    #[serde(default)]
    pub file: Option<String>,
}

/// Shape of the bodies of a packing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Piece {
    /// Discs.
    #[default]
    Disc,
    /// Convex polygons with corners on a circle.
    Polygon,
}

fn seed() -> u64 {
    1
}

fn rounds() -> u32 {
    3
}

fn corners() -> [u32; 2] {
    [5, 8]
}
