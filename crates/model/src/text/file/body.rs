//! `[[body]]`: shapes and meshes.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::vector::{Spin, Vector};

/// A body, or several of one kind. It has exactly one shape: mesh, voronoi or packing; in two dimensions
/// rectangle, disc, ring or polygon; in three dimensions box, cylinder, tube, sphere, polyhedron, surface or
/// extrusion.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name of the body for boundaries, histories and results.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of the material of the body.
    pub material: String,
    /// Mean edge of the elements, m. Meshes from files have their own size and take no such key; geometries
    /// that Gmsh meshes take it as the longest edge.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub mesh_size: Option<f64>,
    /// Places near which elements are smaller than `mesh_size`: points, lines and boxes, in the coordinates
    /// of the shape, before `angle` and `translate`. Default: none.
    #[serde(default)]
    pub refine: Vec<Refine>,
    /// Seed of the mesh: another seed gives another mesh. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// Angle by which the body is turned about the middle of its bounding box, degrees, counter-clockwise.
    /// Default: 0.
    #[serde(default)]
    #[schemars(extend("x-unit" = "deg"))]
    pub angle: f64,
    /// In three dimensions: axis [x, y, z] about which the body is turned. Default: [0, 0, 1].
    #[serde(default)]
    #[schemars(extend("x-unit" = "1"))]
    pub axis: Option<[f64; 3]>,
    /// Translation [x, y] or [x, y, z] after the turn, m. Default: none.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub translate: Option<Vector>,
    /// Numbers of copies [nx, ny] or [nx, ny, nz] along the axes, the body itself included. Each copy is a
    /// separate body, `wall-1-1`, `wall-1-2`, …, numbered along x, y and z from 1. A name of a body without
    /// numbers means all copies. Default: no copies.
    #[serde(default)]
    #[schemars(length(min = 2, max = 3), inner(range(min = 1, max = 1_000_000)))]
    pub repeat: Option<Vec<u32>>,
    /// Distance [dx, dy] or [dx, dy, dz] between neighbouring copies, m. Default: the size of the bounding
    /// box of the body, with which copies touch.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub spacing: Option<Vector>,
    /// Velocity [x, y] or [x, y, z] at the start, m/s. Default: rest.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m/s"))]
    pub velocity: Option<Vector>,
    /// Angular velocity about the centroid at the start, degrees per second: one number in two dimensions,
    /// counter-clockwise; [x, y, z] in three. Default: none.
    #[serde(default)]
    #[schemars(extend("x-unit" = "deg/s"))]
    pub spin: Option<Spin>,
    /// Whether the body is rigid: it moves and turns as a whole, has no stress and no joints, does not
    /// break, and its waves do not limit the time step. Its mesh gives it mass, moments of inertia and
    /// shape. A boundary that holds or moves a part of it holds or moves all of it. Or `"until_overloaded"`:
    /// when the forces on it come near its strength, it gets their static stress, and deforms and breaks.
    #[serde(default)]
    pub rigid: Rigid,
    /// With `rigid = "until_overloaded"`: share of the strength of its material at which the body starts to
    /// deform. Its mean stress counts, half of the difference of the principal stresses as tension, and the
    /// largest contact pressure against the strength in compression. Default: 0.03.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub overload: Option<f64>,
    /// Whether a `mesh_size` below 1/500 of the width of the body is meant. Without, it is refused: it is
    /// more often a wrong unit.
    #[serde(default)]
    pub fine: bool,
    /// A file with a mesh of triangles or of tetrahedra: Gmsh .msh 2.2 or 4.1, VTU, or another format that
    /// `fdem contacts` reads. Its path is relative to the model file. Or a geometry (.geo, .step, .iges,
    /// .brep) with `mesh_size`, which is meshed by the program Gmsh where that is installed.
    #[serde(default)]
    pub mesh: Option<String>,
    /// Length in metres of the unit of `mesh`, `surface` or the `file` of a packing: "1 mm" for a file in
    /// millimetres. Not for STEP and IGES files, which say their unit. Default: 1, or the unit that the
    /// columns of a packing name.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub scale: Option<f64>,
    /// Physical groups of surfaces, or of volumes, to take from a mesh file. Default: the whole file.
    #[serde(default)]
    pub only: Option<Vec<String>>,
    /// Materials of physical groups of a mesh file, as { group = "material" }. Groups that are not named have
    /// the material of the body.
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
    /// A box along the axes.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box")]
    pub block: Option<Block>,
    /// A cylinder.
    #[serde(default)]
    pub cylinder: Option<Cylinder>,
    /// The volume between two cylinders with the same axis.
    #[serde(default)]
    pub tube: Option<Tube>,
    /// A sphere.
    #[serde(default)]
    pub sphere: Option<Sphere>,
    /// The smallest convex polyhedron around points.
    #[serde(default)]
    pub polyhedron: Option<Polyhedron>,
    /// A file with a closed surface of triangles, STL or OBJ, whose inside is meshed. Its path is relative to
    /// the model file.
    #[serde(default)]
    pub surface: Option<String>,
    /// Holes of `surface` up to this width are closed by triangles around their middle, m. Default: a surface
    /// with a hole is refused.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub close_holes: Option<f64>,
    /// Facets of `surface` that are finer than `mesh_size` are made larger, where the surface moves by no
    /// more than this, m. Default: facets are in the mesh as they are.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub surface_tolerance: Option<f64>,
    /// A flat outline drawn out along z.
    #[serde(default)]
    pub extrusion: Option<Extrusion>,
    /// Voronoi grains in an outline. Their boundaries are edges of the mesh.
    #[serde(default)]
    pub voronoi: Option<Voronoi>,
    /// Bodies of one kind that do not overlap: discs, polygons, spheres, polyhedra, or copies of a shape.
    /// Each is a separate body.
    #[serde(default)]
    pub packing: Option<Packing>,
}

impl Body {
    /// Makes its mesh coarser, or finer: all sizes of elements times `factor`.
    pub(crate) fn scale_mesh(&mut self, factor: f64) {
        let sizes = self.mesh_size.iter_mut().chain(self.refine.iter_mut().map(|place| &mut place.size));
        sizes.for_each(|size| *size *= factor);
    }
}

/// A place near which elements are smaller: exactly one of point, line and box.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Refine {
    /// A point [x, y] or [x, y, z], m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub point: Option<Vector>,
    /// A chain of lines from point to point, such as [[0, 0], [1, 0]], m.
    #[serde(default)]
    #[schemars(length(min = 2))]
    #[schemars(extend("x-unit" = "m"))]
    pub line: Option<Vec<Vector>>,
    /// A box along the axes, [xmin, ymin, xmax, ymax] or [xmin, ymin, zmin, xmax, ymax, zmax], m. A flat one
    /// is a face.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box", length(min = 4, max = 6))]
    #[schemars(extend("x-unit" = "m"))]
    pub block: Option<Vec<f64>>,
    /// Mean edge of the elements there, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub size: f64,
    /// Distance from the place up to which elements have that size, m. Beyond, edges grow by 0.3 m per metre
    /// up to `mesh_size`. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub reach: f64,
}

/// A rectangle along the axes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Lower left corner, m.
    #[schemars(extend("x-unit" = "m"))]
    pub min: [f64; 2],
    /// Upper right corner, m.
    #[schemars(extend("x-unit" = "m"))]
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
    #[schemars(extend("x-unit" = "m"))]
    pub centre: [f64; 2],
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
}

/// The area between two circles with the same centre.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ring {
    /// Centre [x, y], m. Default: [0, 0].
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub centre: [f64; 2],
    /// Radius of the outer circle, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
    /// Radius of the inner circle, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub inner_radius: f64,
}

/// A box along the axes. Its faces are the groups "left" and "right" (x), "front" and "back" (y), "bottom"
/// and "top" (z).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Box")]
pub struct Block {
    /// Least corner [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub min: [f64; 3],
    /// Greatest corner [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub max: [f64; 3],
}

/// A cylinder. Its faces are the groups "bottom" (at `from`), "top" (at `to`) and "mantle".
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Centre of one end [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub from: [f64; 3],
    /// Centre of the other end [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub to: [f64; 3],
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
}

/// The volume between two cylinders with the same axis. Its faces are the groups "bottom" (at `from`), "top"
/// (at `to`), "mantle" and "inside".
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tube {
    /// Centre of one end [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub from: [f64; 3],
    /// Centre of the other end [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub to: [f64; 3],
    /// Outer radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
    /// Inner radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub inner_radius: f64,
}

/// A sphere.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Centre [x, y, z], m. Default: [0, 0, 0].
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub centre: [f64; 3],
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
}

/// The smallest convex polyhedron around points. Its flat faces are the groups "face-1", "face-2", ….
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Polyhedron {
    /// Points [x, y, z], m. Points inside of the others are ignored.
    #[schemars(length(min = 4))]
    #[schemars(extend("x-unit" = "m"))]
    pub points: Vec<[f64; 3]>,
}

/// A flat outline drawn out along z. Its faces are the groups "bottom", "top", "outer" and "holes".
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Extrusion {
    /// The outline: { rectangle = … }, { disc = … } or { polygon = … }.
    pub outline: Outline,
    /// Least z, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub from: f64,
    /// Greatest z, m.
    #[schemars(extend("x-unit" = "m"))]
    pub to: f64,
}

/// A polygon, which may have holes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Polygon {
    /// Corners [x, y] in their order around the outline, either way round, m. The outline is closed
    /// automatically.
    #[schemars(length(min = 3))]
    #[schemars(extend("x-unit" = "m"))]
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
    Points(#[schemars(length(min = 3), extend("x-unit" = "m"))] Vec<[f64; 2]>),
    /// A circle.
    Disc(Disc),
}

/// Whether a body is rigid.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Rigid {
    /// For the whole run, or not at all.
    Always(bool),
    /// Until the forces on it come near its strength.
    Until(UntilWord),
}

impl Default for Rigid {
    fn default() -> Self {
        Self::Always(false)
    }
}

impl Rigid {
    /// Whether it is rigid at the beginning.
    pub(crate) fn at_first(self) -> bool {
        !matches!(self, Self::Always(false))
    }

    /// Whether it is rigid for the whole run.
    pub(crate) fn always(self) -> bool {
        matches!(self, Self::Always(true))
    }
}

/// The word `"until_overloaded"`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum UntilWord {
    /// Until it is overloaded.
    UntilOverloaded,
}

/// Voronoi cells of random points that were spread evenly.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Voronoi {
    /// Outline that the grains fill: { rectangle = … }, { disc = … } or { polygon = … }; in three dimensions
    /// { box = … }, { polyhedron = … }, { cylinder = … } or { sphere = … }.
    pub outline: Outline,
    /// Number of grains.
    #[schemars(range(min = 1, max = 100_000))]
    pub grains: usize,
    /// Seed of the grains: another seed gives other grains. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// In two dimensions: rounds in which each point moves to the middle of its cell (Lloyd's algorithm): the
    /// more, the more alike the grains. Default: 3.
    #[serde(default = "rounds")]
    #[schemars(range(max = 100))]
    pub rounds: u32,
    /// Materials of the grains. Neighbours get different ones where that is possible: with four or more
    /// materials nearly everywhere. An `[[interface]]` of two materials gives the strength between such
    /// neighbours. Default: the material of the body.
    #[serde(default)]
    pub materials: Vec<String>,
}

/// An outline; exactly one of the keys. The last four are for grains in three dimensions.
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
    /// A box along the axes.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box")]
    pub block: Option<Block>,
    /// A convex polyhedron.
    #[serde(default)]
    pub polyhedron: Option<Polyhedron>,
    /// A cylinder.
    #[serde(default)]
    pub cylinder: Option<Cylinder>,
    /// A sphere.
    #[serde(default)]
    pub sphere: Option<Sphere>,
}

impl Outline {
    /// The keys that are given, with their dimensions.
    pub(crate) fn given(&self) -> Vec<(&'static str, u8)> {
        let all = [
            ("rectangle", 2, self.rectangle.is_some()),
            ("disc", 2, self.disc.is_some()),
            ("polygon", 2, self.polygon.is_some()),
            ("box", 3, self.block.is_some()),
            ("polyhedron", 3, self.polyhedron.is_some()),
            ("cylinder", 3, self.cylinder.is_some()),
            ("sphere", 3, self.sphere.is_some()),
        ];
        all.into_iter().filter(|(.., given)| *given).map(|(key, dimensions, _)| (key, dimensions)).collect()
    }
}

/// Bodies of one kind that do not overlap, at random places or from a file. Each lies within its own circle
/// or sphere.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Packing {
    /// Shape of the bodies: "disc" or "polygon" in two dimensions, "sphere" or "polyhedron" in three.
    /// Default: "disc" or "sphere".
    #[serde(default)]
    pub shape: Option<PieceShape>,
    /// Instead of `shape`: the shape whose copies the bodies are, such as { box = … }. Each copy is turned at
    /// random.
    #[serde(default)]
    pub copies_of: Option<CopiesOf>,
    /// Number of bodies, at random places.
    #[serde(default)]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub count: Option<usize>,
    /// Smallest and largest radius of the circles or spheres around the bodies, m. By default copies have the
    /// radius of their shape; with a radius they are scaled to it.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub radius: Option<[f64; 2]>,
    /// Region that the bodies fill: { min = [x, y], max = [x, y] }, { min = [x, y, z], max = [x, y, z] } or {
    /// cylinder = … }.
    #[serde(default)]
    pub within: Option<Region>,
    /// Least distance between the circles or spheres around two bodies, and between these and the sides of
    /// the region, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub gap: f64,
    /// Smallest and largest number of corners of polygons and polyhedra. Default: [5, 8] for polygons, [8,
    /// 14] for polyhedra.
    #[serde(default)]
    #[schemars(inner(range(min = 3, max = 100)))]
    pub corners: Option<[u32; 2]>,
    /// Seed of the packing: another seed gives another packing. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// File with x, y, in three dimensions z, and radius of each body, instead of `count`, `radius` and
    /// `within`: any format that `fdem contacts` reads. It is in metres, unless its columns name a unit or
    /// `scale` of the body says otherwise. Its path is relative to the model file.
    #[serde(default)]
    pub file: Option<String>,
}

/// Region that a packing fills: `min` and `max`, or a cylinder.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Least corner [x, y] or [x, y, z] of a rectangle or a box, m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub min: Option<Vector>,
    /// Greatest corner [x, y] or [x, y, z], m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub max: Option<Vector>,
    /// In three dimensions: a cylinder.
    #[serde(default)]
    pub cylinder: Option<Cylinder>,
}

/// The shape whose copies the bodies of a packing are; exactly one of the keys. Where it lies does not
/// matter.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "copies_of")]
pub struct CopiesOf {
    /// A rectangle.
    #[serde(default)]
    pub rectangle: Option<Rectangle>,
    /// A ring.
    #[serde(default)]
    pub ring: Option<Ring>,
    /// A polygon.
    #[serde(default)]
    pub polygon: Option<Polygon>,
    /// A box.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box")]
    pub block: Option<Block>,
    /// A cylinder.
    #[serde(default)]
    pub cylinder: Option<Cylinder>,
    /// The volume between two cylinders with the same axis.
    #[serde(default)]
    pub tube: Option<Tube>,
    /// The smallest convex polyhedron around points.
    #[serde(default)]
    pub polyhedron: Option<Polyhedron>,
    /// A file with a closed surface of triangles, STL or OBJ.
    #[serde(default)]
    pub surface: Option<String>,
    /// Holes of `surface` up to this width are closed by triangles around their middle, m. Default: a surface
    /// with a hole is refused.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub close_holes: Option<f64>,
    /// A flat outline drawn out along z.
    #[serde(default)]
    pub extrusion: Option<Extrusion>,
}

/// Shape of the bodies of a packing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "Piece")]
pub enum PieceShape {
    /// Discs.
    Disc,
    /// Convex polygons with corners on a circle.
    Polygon,
    /// Spheres.
    Sphere,
    /// Convex polyhedra with corners on a sphere.
    Polyhedron,
}

fn seed() -> u64 {
    1
}

fn rounds() -> u32 {
    3
}

/// The shapes that a body may have, and the dimensions in which it may have them.
pub(crate) const SHAPES: [(&str, &[u8]); 14] = [
    ("mesh", &[2, 3]),
    ("rectangle", &[2]),
    ("disc", &[2]),
    ("ring", &[2]),
    ("polygon", &[2]),
    ("box", &[3]),
    ("cylinder", &[3]),
    ("tube", &[3]),
    ("sphere", &[3]),
    ("polyhedron", &[3]),
    ("surface", &[3]),
    ("extrusion", &[3]),
    ("voronoi", &[2, 3]),
    ("packing", &[2, 3]),
];
