//! `[[grains]]`, `[[wall]]`, `[spheres]` and `[domain]`: spheres and walls.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::body::Cylinder;
use crate::text::file::boundary::{Rotation, Side};
use crate::text::file::vector::{Spin, Vector};

/// Spheres, in two dimensions discs, of one material: `count` or `fraction` of them at random places of the
/// region `within`, or those at the places `at`, or those of a `file`. They touch each other, walls and
/// bodies, and are there from the beginning to the end of a run, in all of its stages.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grains {
    /// Name of these spheres.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of their material.
    pub material: String,
    /// Number of spheres, at random places.
    #[serde(default)]
    #[schemars(range(min = 1, max = 20_000_000))]
    pub count: Option<usize>,
    /// Share of the region that the spheres fill, at random places: their volume over that of the region, for
    /// discs their area. Spheres of one size reach about 0.6, discs 0.8, in regions that are much larger than
    /// they are.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "x-unit" = "1"))]
    pub fraction: Option<f64>,
    /// Centres [x, y] or [x, y, z], m; of clumps, the places of the origin of their frame.
    #[serde(default)]
    #[schemars(length(min = 1))]
    #[schemars(extend("x-unit" = "m"))]
    pub at: Option<Vec<Vector>>,
    /// File with x, y, in three dimensions z, and radius of each sphere: any format that `fdem contacts`
    /// reads. It is in metres, unless its columns name a unit or `scale` says otherwise. Its path is relative
    /// to the model file.
    #[serde(default)]
    pub file: Option<String>,
    /// Length of the unit of `file`, or of the file of `within.surface`, m, such as "1 mm". Default: 1 m, or
    /// the unit that the columns name.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub scale: Option<f64>,
    /// Vector [x, y] or [x, y, z], m, by which the spheres of `file` are moved. Default: none.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub translate: Option<Vector>,
    /// Region that the spheres fill: { min = [x, y], max = [x, y] } or { disc = … } in two dimensions; { min
    /// = [x, y, z], max = [x, y, z] }, { cylinder = … }, { ball = … } or { surface = "….stl" } in three.
    #[serde(default)]
    pub within: Option<GrainRegion>,
    /// Radius, m: a number; [least, most], all equally frequent; { mean = …, deviation = … }, a normal
    /// distribution, cut off at 3 deviations from the mean; or a grading curve [[radius, share], …], with the
    /// share of the mass of all smaller spheres, which is linear between the entries and ends with 1. Of
    /// clumps: that of the sphere of the same volume, of clumps of discs that of the disc of the same area.
    /// Default of clumps: they are as large as `clump` says.
    #[serde(default)]
    pub radius: Option<GrainRadius>,
    /// Clumps instead of single spheres: spheres that may overlap and move together as one rigid body. Each
    /// is { at = [x, y, z], radius = r } in a frame of the clump, and all clumps have this shape. Mass and
    /// moments of inertia are those of the union of the spheres. `count` and `fraction` count clumps and
    /// their volume, and pack them by the spheres around them.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub clump: Option<Vec<ClumpSphere>>,
    /// Orientation of clumps: "random", a different one for each; or one for all, degrees: a number in two
    /// dimensions, counter-clockwise; [x, y, z] in three, about that axis. Default: "random".
    #[serde(default)]
    #[schemars(extend("x-unit" = "deg"))]
    pub orientation: Option<ClumpOrientation>,
    /// Least distance between two spheres, and between spheres and the sides of the region, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub gap: f64,
    /// Seed of places and radii: another seed gives other ones. Default: 1.
    #[serde(default = "seed")]
    pub seed: u64,
    /// Velocity [x, y] or [x, y, z] at the start, m/s. Default: rest.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m/s"))]
    pub velocity: Option<Vector>,
    /// Angular velocity at the start, degrees per second: a number in two dimensions, counter-clockwise; [x,
    /// y, z] in three, about that axis. Each sphere turns about its centre, each clump about its centre of
    /// mass. Default: none.
    #[serde(default)]
    #[schemars(extend("x-unit" = "deg/s"))]
    pub spin: Option<Spin>,
    /// true: the spheres keep their velocity and spin, whatever touches them; without these they stay where
    /// they are: a rough floor. Default: false.
    #[serde(default)]
    pub fixed: bool,
}

/// A sphere of a clump, in two dimensions a disc.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "clump_sphere")]
pub struct ClumpSphere {
    /// Centre [x, y] or [x, y, z] in the frame of the clump, m.
    #[schemars(extend("x-unit" = "m"))]
    pub at: Vector,
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
}

/// Orientation of clumps.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ClumpOrientation {
    /// Each has a random one.
    Random(RandomWord),
    /// All are turned by this angle, counter-clockwise in the plane.
    Plane(f64),
    /// All are turned about this axis, by its length.
    Space([f64; 3]),
}

/// The word "random".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RandomWord {
    /// Random ones.
    Random,
}

/// A region that spheres fill: `min` and `max`, or one of the other keys.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "grains_within")]
pub struct GrainRegion {
    /// Least corner [x, y] or [x, y, z] of a rectangle or a box, m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub min: Option<Vector>,
    /// Greatest corner [x, y] or [x, y, z], m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub max: Option<Vector>,
    /// In two dimensions: a disc { centre = [x, y], radius = r }.
    #[serde(default)]
    pub disc: Option<RoundRegion>,
    /// In three dimensions: a cylinder.
    #[serde(default)]
    pub cylinder: Option<Cylinder>,
    /// In three dimensions: a ball { centre = [x, y, z], radius = r }.
    #[serde(default)]
    pub ball: Option<RoundRegion>,
    /// In three dimensions: file with a closed surface of triangles, such as an STL. Spheres fill its inside.
    #[serde(default)]
    pub surface: Option<String>,
}

/// A disc or a ball that spheres fill.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "round_region")]
pub struct RoundRegion {
    /// Centre [x, y] or [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub centre: Vector,
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
}

/// Radii of spheres.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum GrainRadius {
    /// All have the same, m.
    Equal(#[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))] f64),
    /// The least and the largest, m.
    Uniform(#[schemars(extend("x-unit" = "m"))] [f64; 2]),
    /// A normal distribution.
    Normal(NormalRadius),
    /// Radii, m, and shares of the mass.
    Grading(#[schemars(length(min = 1), extend("x-unit" = ["m", "1"]))] Vec<[f64; 2]>),
}

/// A normal distribution of radii, cut off at 3 deviations from the mean.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "normal_radius")]
pub struct NormalRadius {
    /// Mean, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub mean: f64,
    /// Standard deviation, m; below a third of the mean.
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub deviation: f64,
}

/// A wall that spheres touch. It has no mass: it stays, moves in a given way, or keeps up a force by a
/// `servo`. It has exactly one shape: plane, box or corners; in two dimensions also circle; in three also
/// tube, cone, disc or mesh. Bodies do not touch walls. It is there in all stages of a run.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name of the wall for histories.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of its material.
    pub material: String,
    /// A plane without ends, in two dimensions a line.
    #[serde(default)]
    pub plane: Option<WallPlane>,
    /// The inside of a tube without ends, in three dimensions.
    #[serde(default)]
    pub tube: Option<WallTube>,
    /// The inside of a circle, in two dimensions.
    #[serde(default)]
    pub circle: Option<WallCircle>,
    /// A cone that is cut off at two points of its axis, from both sides, in three dimensions.
    #[serde(default)]
    pub cone: Option<WallCone>,
    /// A flat disc, from both sides, in three dimensions.
    #[serde(default)]
    pub disc: Option<WallDisc>,
    /// The sides of a box along the axes, in two dimensions of a rectangle, from both sides.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box")]
    pub block: Option<WallBox>,
    /// Corners [x, y] or [x, y, z], m: in two dimensions a chain of lines from corner to corner, in three a
    /// flat convex polygon. From both sides.
    #[serde(default)]
    #[schemars(length(min = 2))]
    #[schemars(extend("x-unit" = "m"))]
    pub corners: Option<Vec<Vector>>,
    /// File with triangles, in three dimensions: STL, OBJ or any other mesh that bodies are read from. From
    /// both sides. Its path is relative to the model file.
    #[serde(default)]
    pub mesh: Option<String>,
    /// Length of the unit of `mesh`, m, such as "1 mm". Default: 1 m.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub scale: Option<f64>,
    /// Vector [x, y, z], m, by which `mesh` is moved. Default: none.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub translate: Option<Vector>,
    /// Velocity [x, y] or [x, y, z], m/s. Default: none.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m/s"))]
    pub velocity: Option<Vector>,
    /// Rotation about an axis, which moves along with the wall.
    #[serde(default)]
    pub rotation: Option<Rotation>,
    /// Displacement [x, y] or [x, y, z] from the start, m, whose factor over time is the `table`.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub displacement: Option<Vector>,
    /// Factor of the displacement over time, [[time, factor], …], s: linear between the entries, constant
    /// before the first and after the last.
    #[serde(default)]
    #[schemars(length(min = 1))]
    #[schemars(extend("x-unit" = ["s", "1"]))]
    pub table: Option<Vec<[f64; 2]>>,
    /// Force or pressure that the wall keeps up by its own motion. Default: none.
    #[serde(default)]
    pub servo: Option<WallServo>,
}

/// A plane without ends.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "wall_plane")]
pub struct WallPlane {
    /// A point [x, y] or [x, y, z] on it, m.
    #[schemars(extend("x-unit" = "m"))]
    pub point: Vector,
    /// Direction [x, y] or [x, y, z] to the side where the spheres are, of any length.
    #[schemars(extend("x-unit" = "1"))]
    pub normal: Vector,
}

/// A tube without ends.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "wall_tube")]
pub struct WallTube {
    /// A point [x, y, z] on its axis, m.
    #[schemars(extend("x-unit" = "m"))]
    pub from: [f64; 3],
    /// Another point [x, y, z] on its axis, m.
    #[schemars(extend("x-unit" = "m"))]
    pub to: [f64; 3],
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
}

/// A circle.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "wall_circle")]
pub struct WallCircle {
    /// Centre [x, y], m. Default: [0, 0].
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub centre: [f64; 2],
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
}

/// A cone between two points of its axis.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "wall_cone")]
pub struct WallCone {
    /// Centre [x, y, z] of one end, m.
    #[schemars(extend("x-unit" = "m"))]
    pub from: [f64; 3],
    /// Centre [x, y, z] of the other end, m.
    #[schemars(extend("x-unit" = "m"))]
    pub to: [f64; 3],
    /// Radii at `from` and at `to`, m: at least 0, and one of them above 0.
    #[schemars(extend("x-unit" = "m"))]
    pub radii: [f64; 2],
}

/// A flat disc.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "wall_disc")]
pub struct WallDisc {
    /// Centre [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub centre: [f64; 3],
    /// Direction [x, y, z] across the disc, of any length.
    #[schemars(extend("x-unit" = "1"))]
    pub normal: [f64; 3],
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub radius: f64,
}

/// The sides of a box along the axes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "wall_box")]
pub struct WallBox {
    /// Least corner [x, y] or [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub min: Vector,
    /// Greatest corner [x, y] or [x, y, z], m.
    #[schemars(extend("x-unit" = "m"))]
    pub max: Vector,
    /// Sides that are missing, such as `["top"]`. Default: none.
    #[serde(default)]
    pub open: Vec<Side>,
}

/// A force that a wall keeps up: it moves along a direction so that the spheres press on it with this force.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "wall_servo")]
pub struct WallServo {
    /// Direction [x, y] or [x, y, z] in which the wall presses, of any length.
    #[schemars(extend("x-unit" = "1"))]
    pub direction: Vector,
    /// Force with which it presses, N.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "N"))]
    pub force: Option<f64>,
    /// Instead of `force`, of a disc, a mesh or corners: the force over the area of the wall as seen along
    /// the direction, Pa.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "Pa"))]
    pub pressure: Option<f64>,
    /// Largest speed of the wall, m/s.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m/s"))]
    pub speed: f64,
}

/// The law of the contacts of spheres.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereOptions {
    /// Law of contacts: "hertz" (Hertz along the normal, Mindlin across it, from the moduli of the materials)
    /// or "hooke" (linear springs). Default: "hertz".
    #[serde(default)]
    pub law: SphereLaw,
    /// For "hooke", which needs it: stiffness along the normal, N/m.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "N/m"))]
    pub stiffness: Option<f64>,
    /// For "hooke": stiffness across the normal over that along it. Default: 2/7, with which a sphere swings
    /// along and across the normal at the same frequency.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "1"))]
    pub tangential_ratio: Option<f64>,
}

/// A law of contacts of spheres.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SphereLaw {
    /// Hertz and Mindlin.
    #[default]
    Hertz,
    /// Linear springs.
    Hooke,
}

/// The box in which the spheres are.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// The box [xmin, ymin, xmax, ymax] or [xmin, ymin, zmin, xmax, ymax, zmax], m.
    #[serde(rename = "box")]
    #[schemars(rename = "box", length(min = 4, max = 6))]
    #[schemars(extend("x-unit" = "m"))]
    pub limits: Vec<f64>,
    /// Axes along which it repeats, such as `["x", "y"]`: a sphere that leaves it on one side comes in on the
    /// other, and spheres touch across these sides. Only without bodies. Default: none.
    #[serde(default)]
    pub periodic: Vec<DomainAxis>,
    /// Rates [x, y] or [x, y, z] at which the sides of the box grow along axes that repeat, 1/s, relative to
    /// their lengths; negative to compress. The spheres move along. Default: none.
    #[serde(default)]
    #[schemars(extend("x-unit" = "1/s"))]
    pub strain_rate: Option<Vector>,
    /// Time from which the sides grow at `strain_rate`, s. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "s"))]
    pub strain_from: f64,
    /// Pressures that the spheres keep up along axes that repeat: the box grows and shrinks for that. The
    /// spheres move along. Default: none.
    #[serde(default)]
    pub servo: Option<DomainServo>,
    /// The fate of a sphere whose centre leaves the box along other axes: "stop" ends the run with an
    /// error that names it, "delete" removes it. Default: "stop".
    #[serde(default)]
    pub outside: OutsideWord,
}

/// Pressures that a box keeps up. The pressure along an axis is force times distance of the centres along it,
/// summed over all contacts of spheres, over the volume of the box.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "domain_servo")]
pub struct DomainServo {
    /// Pressure along x, Pa; without it the box keeps its length. An axis with a `strain_rate` keeps its
    /// pressure up until `strain_from`.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "Pa"))]
    pub x: Option<f64>,
    /// Pressure along y, Pa.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "Pa"))]
    pub y: Option<f64>,
    /// Pressure along z, Pa.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "Pa"))]
    pub z: Option<f64>,
    /// Largest rate at which a side grows or shrinks, 1/s, relative to its length.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1/s"))]
    pub rate: f64,
}

impl DomainServo {
    /// The pressures along the axes, Pa.
    pub(crate) fn pressures(&self) -> [Option<f64>; 3] {
        [self.x, self.y, self.z]
    }
}

/// An axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DomainAxis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// The fate of a sphere that leaves the domain.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OutsideWord {
    /// The run stops.
    #[default]
    Stop,
    /// The sphere is removed.
    Delete,
}

impl Grains {
    /// The keys that say how many spheres there are, of which there is one.
    pub(crate) fn amounts(&self) -> Vec<&'static str> {
        let all = [
            ("count", self.count.is_some()),
            ("fraction", self.fraction.is_some()),
            ("at", self.at.is_some()),
            ("file", self.file.is_some()),
        ];
        all.into_iter().filter(|(_, given)| *given).map(|(key, _)| key).collect()
    }
}

impl Grains {
    /// The dimensions that a table determines, if it does.
    pub(crate) fn dimensions(&self) -> Option<u8> {
        let of_point = |point: &Vector| if point.0.len() == 3 { 3 } else { 2 };
        let of_region = |within: &GrainRegion| {
            let (_, of) = within.given().into_iter().find(|(_, of)| *of != 0).unwrap_or_default();
            let of_corner = || within.min.as_ref().or(within.max.as_ref()).map(of_point);
            if of == 0 { of_corner() } else { Some(of) }
        };
        let of_places = || self.at.as_ref()?.first().map(of_point);
        let of_clumps = || self.clump.as_ref()?.first().map(|of| of_point(&of.at));
        self.within.as_ref().and_then(of_region).or_else(of_places).or_else(of_clumps)
    }
}

impl GrainRegion {
    /// The keys that are given, with the dimensions in which they may be, 0 for both.
    pub(crate) fn given(&self) -> Vec<(&'static str, u8)> {
        let all = [
            ("min", 0, self.min.is_some() || self.max.is_some()),
            ("disc", 2, self.disc.is_some()),
            ("cylinder", 3, self.cylinder.is_some()),
            ("ball", 3, self.ball.is_some()),
            ("surface", 3, self.surface.is_some()),
        ];
        all.into_iter().filter(|(.., given)| *given).map(|(key, of, _)| (key, of)).collect()
    }
}

impl Wall {
    /// The dimensions that its shape determines, if it does.
    pub(crate) fn dimensions(&self) -> Option<u8> {
        let (_, of) = self.shapes().first().copied()?;
        let points = [self.plane.as_ref().map(|of| &of.point), self.block.as_ref().map(|of| &of.min)];
        let point = points.into_iter().flatten().chain(self.corners.iter().flatten()).next();
        let of_point = || point.map(|point| if point.0.len() == 3 { 3 } else { 2 });
        if of == 0 { of_point() } else { Some(of) }
    }

    /// The shapes that are given, with the dimensions in which they may be, 0 for both.
    pub(crate) fn shapes(&self) -> Vec<(&'static str, u8)> {
        let all = [
            ("plane", 0, self.plane.is_some()),
            ("tube", 3, self.tube.is_some()),
            ("circle", 2, self.circle.is_some()),
            ("cone", 3, self.cone.is_some()),
            ("disc", 3, self.disc.is_some()),
            ("box", 0, self.block.is_some()),
            ("corners", 0, self.corners.is_some()),
            ("mesh", 3, self.mesh.is_some()),
        ];
        all.into_iter().filter(|(.., given)| *given).map(|(key, of, _)| (key, of)).collect()
    }
}

fn seed() -> u64 {
    1
}
