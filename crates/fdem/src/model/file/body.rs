//! `[[body]]`: shapes and meshes.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

/// A body, or several of one kind. It has exactly one of the keys mesh, rectangle, disc, ring, polygon, voronoi and packing.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// By which boundaries, histories and results call it.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of its material.
    pub material: String,
    /// Edge of its elements, m. Not for meshes from files, which have theirs.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mesh_size: Option<f64>,
    /// Another seed gives another mesh. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// Turned by this angle about the middle of its bounding box, degrees, counter-clockwise. Default: 0.
    #[serde(default)]
    pub angle: f64,
    /// Then moved by [x, y], m. Default: [0, 0].
    #[serde(default)]
    pub translate: [f64; 2],
    /// At the beginning, [x, y], m/s. Default: [0, 0].
    #[serde(default)]
    pub velocity: Option<[f64; 2]>,
    /// A file with a mesh of triangles: Gmsh .msh 2.2 or 4.1, or another format that `fdem contacts` reads. Its path is relative to the model file.
    #[serde(default)]
    pub mesh: Option<String>,
    /// Of a mesh from a file: take only these physical groups of surfaces. Default: all of the file.
    #[serde(default)]
    pub only: Option<Vec<String>>,
    /// Of a mesh from a file: material of a physical group, as { group = "material" }. Groups that are not named have the material of the body.
    #[serde(default)]
    pub groups: BTreeMap<String, String>,
    /// A rectangle along the axes.
    #[serde(default)]
    pub rectangle: Option<Rectangle>,
    /// A disc.
    #[serde(default)]
    pub disc: Option<Disc>,
    /// What is between two circles of one centre.
    #[serde(default)]
    pub ring: Option<Ring>,
    /// A polygon.
    #[serde(default)]
    pub polygon: Option<Polygon>,
    /// A body of Voronoi grains: their boundaries are edges of the mesh.
    #[serde(default)]
    pub voronoi: Option<Voronoi>,
    /// Discs or polygons that do not overlap, each a body of its own.
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
    /// What is cut out: { centre = [x, y], radius = r } or a list of points. Default: nothing.
    #[serde(default)]
    pub holes: Vec<Hole>,
}

/// A disc.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// m. Default: [0, 0].
    #[serde(default)]
    pub centre: [f64; 2],
    /// m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
}

/// What is between two circles of one centre.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ring {
    /// m. Default: [0, 0].
    #[serde(default)]
    pub centre: [f64; 2],
    /// Of the outer circle, m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
    /// Of the hole, m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inner_radius: f64,
}

/// A polygon, which may have holes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Polygon {
    /// Corners [x, y] in order, either way round, m.
    #[schemars(length(min = 3))]
    pub points: Vec<[f64; 2]>,
    /// What is cut out: { centre = [x, y], radius = r } or a list of points. Default: nothing.
    #[serde(default)]
    pub holes: Vec<Hole>,
}

/// What is cut out of a body.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Hole {
    /// Corners in order, m.
    Points(#[schemars(length(min = 3))] Vec<[f64; 2]>),
    /// A circle.
    Disc(Disc),
}

/// Grains: the cells of random points, evened out.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Voronoi {
    /// What the grains fill: { rectangle = … }, { disc = … } or { polygon = … }.
    pub outline: Outline,
    /// How many.
    #[schemars(range(min = 1, max = 100_000))]
    pub grains: usize,
    /// Another seed gives other grains. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// Rounds of moving each point to the middle of its cell: more of them make grains alike. Default: 3.
    #[serde(default = "rounds")]
    #[schemars(range(max = 100))]
    pub rounds: u32,
    /// Materials of the grains, spread so that neighbours differ where that is possible (with four or more they do nearly everywhere); an `[[interface]]` of two says
    /// how such neighbours hold together. Default: the material of the body.
    #[serde(default)]
    pub materials: Vec<String>,
}

/// What grains fill; exactly one of the keys.
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
    /// "disc" or "polygon". Default: "disc".
    #[serde(default)]
    pub shape: Piece,
    /// How many, at random places.
    #[serde(default)]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub count: Option<usize>,
    /// Smallest and largest radius, m; of polygons that of the circle around them.
    #[serde(default)]
    pub radius: Option<[f64; 2]>,
    /// The rectangle that they fill: { min = [x, y], max = [x, y] }.
    #[serde(default)]
    pub within: Option<Rectangle>,
    /// Least distance between two of them, and from the sides, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub gap: f64,
    /// Least and largest number of corners of polygons. Default: [5, 8].
    #[serde(default = "corners")]
    #[schemars(inner(range(min = 3, max = 100)))]
    pub corners: [u32; 2],
    /// Another seed gives another packing. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// A file with x, y and radius of each, m, instead of `count`, `radius` and `within`: any format that `fdem contacts` reads. Its path is relative to the model file.
    #[serde(default)]
    pub file: Option<String>,
}

/// What a packing is of.
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
