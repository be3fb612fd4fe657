//! Spheres of `[[grains]]`: packings, places and files.

use std::ops::Range;

use fdem_io::numbers::brief;
use fdem_simulation::grains::{
    ClosedSurface, ClumpShape, PackAmount, PackError, PackRegion, PackRequest, SphereSizes, pack,
};

use crate::bodies::mesh_file;
use crate::grains::clumps::{PlacedClump, turns};
use crate::shapes::{holes, packing};
use crate::text::fault::{Fault, Problem};
use crate::text::file::{GrainRadius, GrainRegion, Grains, Spin, Vector};
use crate::text::included::Load;

/// Centres and radii of spheres, m. Discs have z = 0.
pub(crate) type Balls = Vec<([f64; 3], f64)>;

/// The spheres of a table.
pub(crate) struct PlacedSpheres {
    pub(crate) balls: Balls,
    /// Clumps, each of as many of the spheres as their shape has, in this order; none of single spheres.
    pub(crate) clumps: Vec<PlacedClump>,
    /// Share of their region that they fill; `None` without a region.
    pub(crate) fraction: Option<f64>,
    /// Notes on their file.
    pub(crate) notes: Vec<String>,
}

/// Radii as packings have them.
pub(crate) fn sizes(radius: &GrainRadius) -> SphereSizes {
    match radius {
        GrainRadius::Equal(radius) => SphereSizes::Equal(*radius),
        GrainRadius::Uniform(range) => SphereSizes::Uniform(*range),
        GrainRadius::Normal(of) => SphereSizes::Normal { mean: of.mean, deviation: of.deviation },
        GrainRadius::Grading(curve) => SphereSizes::Grading(curve.clone()),
    }
}

/// The same distribution of radii that are larger by a factor.
fn scaled(sizes: SphereSizes, factor: f64) -> SphereSizes {
    match sizes {
        SphereSizes::Equal(radius) => SphereSizes::Equal(factor * radius),
        SphereSizes::Uniform(range) => SphereSizes::Uniform(range.map(|radius| factor * radius)),
        SphereSizes::Normal { mean, deviation } => {
            SphereSizes::Normal { mean: factor * mean, deviation: factor * deviation }
        }
        SphereSizes::Grading(curve) => {
            SphereSizes::Grading(curve.into_iter().map(|[radius, share]| [factor * radius, share]).collect())
        }
    }
}

/// A vector in space; in two dimensions z is 0.
pub(crate) fn in_space(vector: &Vector) -> [f64; 3] {
    vector.in_space()
}

/// The spheres of a table whose places do not depend on others: those at points, and those of a file. `None`
/// for packings. `shape`: of clumps. The table has been checked.
pub(crate) fn given(
    grains: &Grains,
    (discs, shape): (bool, Option<&ClumpShape>),
    load: &mut Load<'_>,
) -> Result<Option<PlacedSpheres>, Problem> {
    let title = format!("[[grains]] \"{}\"", grains.name);
    if let (Some(at), Some(shape)) = (&grains.at, shape) {
        let own = SphereSizes::Equal(shape.equal_radius());
        let radii = grains.radius.as_ref().map_or(own, sizes).draw(at.len(), discs, grains.seed);
        let places = at.iter().zip(radii).zip(turns(grains, discs, at.len()));
        let clump = |((at, radius), turn): ((&Vector, f64), [f64; 3])| {
            let scale = radius / shape.equal_radius();
            PlacedClump { at: in_space(at), turn, scale }
        };
        return Ok(Some(of_clumps(shape, places.map(clump).collect(), None)));
    }
    if let (Some(at), Some(radius)) = (&grains.at, &grains.radius) {
        let radii = sizes(radius).draw(at.len(), discs, grains.seed);
        let balls = at.iter().map(in_space).zip(radii).collect();
        return Ok(Some(PlacedSpheres { balls, clumps: Vec::new(), fraction: None, notes: Vec::new() }));
    }
    let Some(name) = &grains.file else { return Ok(None) };
    let problem = |message: String| Problem::new("file", format!("{title}: {message}"));
    let bytes = load(name).map_err(|why| problem(format!("cannot read {name}: {why}")))?;
    let by = grains.translate.as_ref().map_or([0.0; 3], in_space);
    let moved = |centre: [f64; 3]| [0, 1, 2].map(|axis| centre[axis] + by[axis]);
    let (balls, notes): (Balls, Vec<String>) = if discs {
        let (balls, notes) = packing::read_flat(&bytes, name, grains.scale).map_err(problem)?;
        (balls.into_iter().map(|([x, y], radius)| (moved([x, y, 0.0]), radius)).collect(), notes)
    } else {
        let (balls, notes) = packing::read_space(&bytes, name, grains.scale).map_err(problem)?;
        (balls.into_iter().map(|(centre, radius)| (moved(centre), radius)).collect(), notes)
    };
    if balls.is_empty() {
        return Err(problem(format!("{name} has no spheres")));
    }
    let notes = notes.into_iter().map(|note| format!("{title}: {note}")).collect();
    Ok(Some(PlacedSpheres { balls, clumps: Vec::new(), fraction: None, notes }))
}

/// The spheres of clumps. `fraction`: share of their region that the clumps fill.
fn of_clumps(shape: &ClumpShape, clumps: Vec<PlacedClump>, fraction: Option<f64>) -> PlacedSpheres {
    let balls = clumps.iter().flat_map(|of| shape.placed(of.at, of.turn, of.scale)).collect();
    PlacedSpheres { balls, clumps, fraction, notes: Vec::new() }
}

/// The spheres of a table at random places that the others leave free. Clumps are packed by the spheres
/// around them. The table has been checked.
pub(crate) fn packed(
    grains: &Grains,
    (discs, shape): (bool, Option<&ClumpShape>),
    others: &[([f64; 3], f64)],
    load: &mut Load<'_>,
) -> Result<PlacedSpheres, Problem> {
    let title = format!("[[grains]] \"{}\"", grains.name);
    let key = grains.amounts().first().copied().unwrap_or("name");
    let own = shape.map(|shape| SphereSizes::Equal(shape.equal_radius()));
    let (Some(within), Some(sizes)) = (&grains.within, grains.radius.as_ref().map(sizes).or(own)) else {
        return Err(Problem::new(key, format!("{title} has no region or no radius")));
    };
    let wider = shape.map_or(1.0, |shape| shape.outer_radius() / shape.equal_radius());
    // The volume of the spheres around clumps over that of the clumps.
    let fuller = wider.powi(if discs { 2 } else { 3 });
    let amount = match (grains.count, grains.fraction) {
        (Some(count), _) => PackAmount::Count(count),
        (None, fraction) => PackAmount::Fraction(fuller * fraction.unwrap_or(0.0)),
    };
    let region = region(within, grains, load)
        .map_err(|problem| Problem { message: format!("{title}: {}", problem.message), ..problem })?;
    let sizes = scaled(sizes, wider);
    let [least, _] = sizes.range();
    let request = PackRequest { region, discs, sizes, amount, gap: grains.gap, seed: grains.seed, others };
    match (pack(request, 0), shape) {
        (Ok(packed), None) => Ok(PlacedSpheres {
            balls: packed.positions.into_iter().zip(packed.radii).collect(),
            clumps: Vec::new(),
            fraction: Some(packed.fraction),
            notes: Vec::new(),
        }),
        (Ok(packed), Some(shape)) => {
            let turns = turns(grains, discs, packed.radii.len());
            let places = packed.positions.into_iter().zip(packed.radii).zip(turns);
            let clump = |((centre, radius), turn): (([f64; 3], f64), [f64; 3])| {
                let scale = radius / shape.outer_radius();
                PlacedClump { at: shape.origin(centre, turn, scale), turn, scale }
            };
            Ok(of_clumps(shape, places.map(clump).collect(), Some(packed.fraction / fuller)))
        }
        (Err(error), _) => {
            let noun = match (shape, discs) {
                (Some(_), _) => "clump",
                (None, true) => "disc",
                (None, false) => "sphere",
            };
            let error = match error {
                PackError::TooDense { fraction, reached } => {
                    PackError::TooDense { fraction: fraction / fuller, reached: reached / fuller }
                }
                other => other,
            };
            let (key, help) = match &error {
                PackError::TooDense { .. } if shape.is_some() => (
                    key,
                    format!(
                        "clumps are packed by the spheres around them, which are {} times as large as they are: take fewer, and let them settle",
                        brief((100.0 * fuller).round() / 100.0)
                    ),
                ),
                PackError::TooDense { .. } => {
                    (key, "take fewer or smaller ones, or a larger region".to_owned())
                }
                PackError::TooLarge { .. } if shape.is_some() => {
                    let key = if grains.radius.is_some() { "radius" } else { "clump" };
                    (
                        key,
                        "that is the sphere around a clump: take smaller ones, or a larger region".to_owned(),
                    )
                }
                PackError::TooMany { .. } => (key, format!("the smallest radius is {} m", brief(least))),
                PackError::TooLarge { .. } | PackError::Sizes(_) => {
                    ("radius", "take smaller ones, or a larger region".to_owned())
                }
                PackError::Empty => (key, format!("one {noun} fills more of the region than that")),
                PackError::NoRegion => ("within", "make the region larger".to_owned()),
                PackError::Search(_) => ("name", "make the region smaller, or the radii larger".to_owned()),
            };
            Err(Problem { help: Some(help), ..Problem::new(key, format!("{title}: {error}")) })
        }
    }
}

/// The region of a packing.
fn region(within: &GrainRegion, grains: &Grains, load: &mut Load<'_>) -> Result<PackRegion, Problem> {
    if let Some(of) = within.disc.as_ref().or(within.ball.as_ref()) {
        return Ok(PackRegion::Ball { centre: in_space(&of.centre), radius: of.radius });
    }
    if let Some(of) = &within.cylinder {
        return Ok(PackRegion::Cylinder { from: of.from, to: of.to, radius: of.radius });
    }
    if let Some(name) = &within.surface {
        let key = "within.surface";
        let triangles = mesh_file::triangles(load, name, grains.scale.unwrap_or(1.0))
            .map_err(|problem| Problem { key: key.to_owned(), ..problem })?;
        if holes::words(&triangles).is_some() {
            let help = "close its holes in the program that made it".to_owned();
            let message = format!("{name} is no closed surface, and has no inside");
            return Err(Problem { help: Some(help), ..Problem::new(key, message) });
        }
        return Ok(PackRegion::Inside(Box::new(ClosedSurface::new(triangles))));
    }
    let [low, high] = [&within.min, &within.max].map(|corner| corner.as_ref().map_or([0.0; 3], in_space));
    Ok(PackRegion::Box { low, high })
}

/// The fault of radii that are impossible. `title`: of their table.
pub(crate) fn radius_fault(radius: &GrainRadius, title: &str, span: Range<usize>) -> Option<Fault> {
    let why = sizes(radius).fault()?;
    let fault = Fault::at(span, format!("{title}: {why}")).label("these radii");
    Some(match radius {
        GrainRadius::Grading(_) => fault
            .help("a grading curve is [[radius, share], …], such as [[0.005, 0], [0.01, 0.4], [0.02, 1]]"),
        _ => fault,
    })
}

/// The fault of a spin whose form does not fit the dimensions.
pub(crate) fn spin_fault(spin: Spin, dimensions: u8, span: Range<usize>) -> Option<Fault> {
    if matches!(spin, Spin::Plane(_)) == (dimensions == 2) {
        return None;
    }
    let help = if dimensions == 2 {
        "write one number: degrees per second, counter-clockwise"
    } else {
        "write [x, y, z]: the axis, as long as the degrees per second about it"
    };
    let message = format!("\"spin\" of spheres in {dimensions} dimensions");
    Some(Fault::at(span, message).label("is not of this form").help(help))
}

/// A place in messages.
pub(crate) fn place(at: [f64; 3], discs: bool) -> String {
    let axes = if discs { 2 } else { 3 };
    let numbers: Vec<String> = at[..axes].iter().map(|x| brief(*x)).collect();
    format!("[{}]", numbers.join(", "))
}
