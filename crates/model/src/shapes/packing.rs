//! Bodies of one kind that do not overlap: circles and spheres at random places or from a file, and the
//! shapes in them.

use std::f64::consts::{PI, TAU};
use std::sync::atomic::AtomicU64;

use fdem_io::numbers::brief;
use fdem_io::{Centres, ReadOptions};
use fdem_mesh::Grading;
use fdem_scenes::random::Random;

use crate::shapes::outline::{Point, circle};
use crate::text::file::{Body, CopiesOf, Cylinder, Packing, PieceShape, Region, Vector};
use crate::text::schema::LARGEST;
use crate::text::values::length_of;

/// A centre and a radius, m.
pub(crate) type Ball<const D: usize> = ([f64; D], f64);

/// Places that are tried for each before there is no room for it.
const ATTEMPTS: u32 = 20_000;

/// Places that are tried in all before a packing is given up: about a minute.
const ALL_ATTEMPTS: u64 = 500_000_000;

/// Share of a region that discs, or spheres, of one size can fill at most; of several sizes a little more.
const DENSEST: [f64; 2] = [0.95, 0.8];

/// Corners of polygons and of polyhedra, if the file does not say.
const CORNERS: [[u32; 2]; 2] = [[5, 8], [8, 14]];

/// Points of which the one farthest from the corners so far becomes the next corner of a polyhedron: sharp
/// edges are rare.
const CANDIDATES: usize = 10;

/// The shape of the bodies of a packing that are no copies.
pub(crate) fn shape(packing: &Packing, dimensions: usize) -> PieceShape {
    packing.shape.unwrap_or(if dimensions == 2 { PieceShape::Disc } else { PieceShape::Sphere })
}

/// Smallest and largest number of corners.
pub(crate) fn corners(packing: &Packing, dimensions: usize) -> [u32; 2] {
    packing.corners.unwrap_or(CORNERS[dimensions - 2])
}

/// The dimensions of a packing; `None` if only its file determines them.
pub(crate) fn dimensions(packing: &Packing) -> Option<u8> {
    let of_shape = packing.shape.map(|shape| match shape {
        PieceShape::Disc | PieceShape::Polygon => 2,
        PieceShape::Sphere | PieceShape::Polyhedron => 3,
    });
    let of_copies = || packing.copies_of.as_ref()?.given().first().map(|(_, dimensions)| *dimensions);
    let of_region = || {
        let within = packing.within.as_ref()?;
        match (&within.cylinder, &within.min) {
            (Some(_), _) => Some(3),
            (None, min) => min.as_ref().map(|min| if min.0.len() == 3 { 3 } else { 2 }),
        }
    };
    of_shape.or_else(of_copies).or_else(of_region)
}

impl CopiesOf {
    /// The keys that are given, with their dimensions.
    pub(crate) fn given(&self) -> Vec<(&'static str, u8)> {
        let all = [
            ("rectangle", 2, self.rectangle.is_some()),
            ("ring", 2, self.ring.is_some()),
            ("polygon", 2, self.polygon.is_some()),
            ("box", 3, self.block.is_some()),
            ("cylinder", 3, self.cylinder.is_some()),
            ("tube", 3, self.tube.is_some()),
            ("polyhedron", 3, self.polyhedron.is_some()),
            ("surface", 3, self.surface.is_some()),
            ("extrusion", 3, self.extrusion.is_some()),
        ];
        all.into_iter().filter(|(.., given)| *given).map(|(key, dimensions, _)| (key, dimensions)).collect()
    }

    /// The body that is copied: that of the packing, with this shape instead.
    pub(crate) fn body(&self, of: &Body) -> Body {
        Body {
            rectangle: self.rectangle.clone(),
            ring: self.ring.clone(),
            polygon: self.polygon.clone(),
            block: self.block.clone(),
            cylinder: self.cylinder.clone(),
            tube: self.tube.clone(),
            polyhedron: self.polyhedron.clone(),
            surface: self.surface.clone(),
            extrusion: self.extrusion.clone(),
            packing: None,
            ..of.clone()
        }
    }
}

/// A turn and a scaling about a point, which then is moved.
pub(crate) struct Motion<const D: usize> {
    pub(crate) about: [f64; D],
    pub(crate) turn: [[f64; D]; D],
    pub(crate) scale: f64,
    pub(crate) to: [f64; D],
}

impl<const D: usize> Motion<D> {
    pub(crate) fn place(&self, point: [f64; D]) -> [f64; D] {
        let from: [f64; D] = std::array::from_fn(|axis| self.scale * (point[axis] - self.about[axis]));
        std::array::from_fn(|axis| (0..D).fold(self.to[axis], |sum, k| sum + self.turn[axis][k] * from[k]))
    }
}

/// Where the bodies of a packing may be.
pub(crate) struct Room<const D: usize> {
    /// Least and largest coordinates.
    pub(crate) bounds: [[f64; D]; 2],
    /// Area or volume.
    measure: f64,
    /// For a cylinder, which the bounds alone do not describe.
    axis: Option<Axis<D>>,
}

/// A cylinder: directions of unit length along it, and across it.
struct Axis<const D: usize> {
    from: [f64; D],
    along: [f64; D],
    across: [[f64; D]; 2],
    length: f64,
    radius: f64,
}

impl<const D: usize> Room<D> {
    /// The room of a region, whose keys have been checked; `None` if they are not all there.
    pub(crate) fn new(region: &Region) -> Option<Self> {
        if let Some(cylinder) = &region.cylinder {
            return Self::cylinder(cylinder);
        }
        let bounds = [region.min.as_ref()?, region.max.as_ref()?].map(Vector::components::<D>);
        let measure = (0..D).map(|axis| bounds[1][axis] - bounds[0][axis]).product();
        Some(Self { bounds, measure, axis: None })
    }

    fn cylinder(of: &Cylinder) -> Option<Self> {
        let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
        let length = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
        let unit = |a: [f64; 3]| a.map(|x| x / length(a));
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
        };
        let along = unit(minus(of.to, of.from));
        let least = (0..3).fold(0, |least, k| if along[k].abs() < along[least].abs() { k } else { least });
        let mut any = [0.0; 3];
        any[least] = 1.0;
        let one = unit(cross(along, any));
        let low = [0, 1, 2].map(|k| of.from[k].min(of.to[k]) - of.radius);
        let high = [0, 1, 2].map(|k| of.from[k].max(of.to[k]) + of.radius);
        let long = length(minus(of.to, of.from));
        // A cylinder exists in space only.
        let components = |of: [f64; 3]| <[f64; D]>::try_from(of.as_slice()).ok();
        Some(Self {
            bounds: [components(low)?, components(high)?],
            measure: PI * of.radius * of.radius * long,
            axis: Some(Axis {
                from: components(of.from)?,
                along: components(along)?,
                across: [components(one)?, components(cross(along, one))?],
                length: long,
                radius: of.radius,
            }),
        })
    }

    /// Whether there is a place as far as `wall` from all sides.
    fn has(&self, wall: f64) -> bool {
        let [low, high] = self.bounds;
        match &self.axis {
            Some(axis) => axis.length >= 2.0 * wall && axis.radius >= wall,
            None => (0..D).all(|axis| high[axis] - low[axis] >= 2.0 * wall),
        }
    }

    /// A random place as far as `wall` from all sides.
    fn at_random(&self, wall: f64, random: &mut Random) -> [f64; D] {
        let [low, high] = self.bounds;
        let Some(axis) = &self.axis else {
            return std::array::from_fn(|axis| random.between(low[axis] + wall, high[axis] - wall));
        };
        let far = random.between(wall, axis.length - wall);
        let [u, v] = loop {
            let [u, v] = [(); 2].map(|()| random.between(-1.0, 1.0));
            if u * u + v * v <= 1.0 {
                break [u, v].map(|x| x * (axis.radius - wall));
            }
        };
        std::array::from_fn(|k| {
            axis.from[k] + far * axis.along[k] + u * axis.across[0][k] + v * axis.across[1][k]
        })
    }

    /// Name of the region in messages.
    pub(crate) fn name(&self) -> &'static str {
        match (&self.axis, D) {
            (Some(_), _) => "cylinder",
            (None, 2) => "rectangle",
            (None, _) => "box",
        }
    }
}

/// Circles or spheres with radii between two, the largest placed first, none nearer to another or to the
/// sides than `gap`.
///
/// # Source
/// Random sequential addition: B. Widom, "Random sequential addition of hard spheres to a volume", J. Chem.
/// Phys. 44 (1966).
///
/// # Errors
/// A message with the number of circles that found room.
pub(crate) fn scatter<const D: usize>(
    count: usize,
    [least, most]: [f64; 2],
    room: &Room<D>,
    gap: f64,
    seed: u64,
) -> Result<Vec<Ball<D>>, String> {
    let (words, whole, mean) = if D == 2 {
        (
            ["discs cover", "cover little more than half"],
            PI,
            (least * least + least * most + most * most) / 3.0,
        )
    } else {
        let mean = (least + most) * (least * least + most * most) / 4.0;
        (["spheres fill", "fill about a third"], 4.0 / 3.0 * PI, mean)
    };
    let covered = count as f64 * whole * mean / room.measure;
    if covered.is_nan() || covered > DENSEST[D - 2] {
        return Err(format!(
            "{count} {} {} times the {}; at random places they {}",
            words[0],
            brief(covered),
            room.name(),
            words[1]
        ));
    }
    let mut random = Random::with_stream(seed, 2);
    let mut radii: Vec<f64> = (0..count).map(|_| random.between(least, most)).collect();
    radii.sort_by(|a, b| b.total_cmp(a));
    let mut left = ALL_ATTEMPTS;
    let mut cells = Cells::new(room.bounds, 2.0 * most + gap, count);
    let mut placed: Vec<Ball<D>> = Vec::with_capacity(count);
    for radius in radii {
        let wall = radius + gap;
        let free = (0..if room.has(wall) { ATTEMPTS } else { 0 }).find_map(|_| {
            left = left.checked_sub(1)?;
            let point = room.at_random(wall, &mut random);
            let clear = cells.near(point, |other| {
                let (centre, other): Ball<D> = placed[other];
                let apart = (0..D).fold(0.0, |sum: f64, axis| sum.hypot(centre[axis] - point[axis]));
                apart >= radius + other + gap
            });
            clear.then_some(point)
        });
        let Some(point) = free else {
            return Err(format!("only {} of {count} found room", placed.len()));
        };
        cells.add(point, placed.len());
        placed.push((point, radius));
    }
    Ok(placed)
}

/// Cells at least as wide as the largest body, with the bodies in each.
struct Cells<const D: usize> {
    low: [f64; D],
    edges: [f64; D],
    counts: [usize; D],
    members: Vec<Vec<usize>>,
}

impl<const D: usize> Cells<D> {
    fn new([low, high]: [[f64; D]; 2], width: f64, count: usize) -> Self {
        let counts: [f64; D] =
            std::array::from_fn(|axis| ((high[axis] - low[axis]) / width).floor().clamp(1.0, 1e6));
        // No more cells than there is use for.
        let ratio = counts.iter().product::<f64>() / (4.0 * count as f64);
        let wider = if D == 2 { ratio.sqrt() } else { libm::cbrt(ratio) }.max(1.0);
        let counts = counts.map(|cells| (cells / wider).floor().max(1.0) as usize);
        let edges = std::array::from_fn(|axis| (high[axis] - low[axis]) / counts[axis] as f64);
        Self { low, edges, counts, members: vec![Vec::new(); counts.iter().product()] }
    }

    fn cell(&self, point: [f64; D]) -> [usize; D] {
        std::array::from_fn(|axis| {
            (((point[axis] - self.low[axis]) / self.edges[axis]) as usize).min(self.counts[axis] - 1)
        })
    }

    fn number(&self, cell: [usize; D]) -> usize {
        (0..D).rev().fold(0, |number, axis| number * self.counts[axis] + cell[axis])
    }

    fn add(&mut self, point: [f64; D], member: usize) {
        let number = self.number(self.cell(point));
        self.members[number].push(member);
    }

    /// Whether all members of the cell of a point and of its neighbours are `clear`.
    fn near(&self, point: [f64; D], clear: impl Fn(usize) -> bool) -> bool {
        let cell = self.cell(point);
        (0..3_usize.pow(D as u32)).all(|step| {
            let mut rest = step;
            let mut neighbour = cell;
            for axis in 0..D {
                let moved = (cell[axis] + rest % 3).checked_sub(1);
                rest /= 3;
                match moved {
                    Some(moved) if moved < self.counts[axis] => neighbour[axis] = moved,
                    _ => return true,
                }
            }
            self.members[self.number(neighbour)].iter().all(|&member| clear(member))
        })
    }
}

/// The circles of a file, and notes on how it was read. `scale`: the length of its unit, m, if the model says
/// it.
///
/// # Errors
/// Messages of [`fdem_io::read_packing`], and about spheres, points and radii of zero.
pub(crate) fn read_flat(
    bytes: &[u8],
    name: &str,
    scale: Option<f64>,
) -> Result<(Vec<Ball<2>>, Vec<String>), String> {
    let (centres, radii, notes) = read(bytes, name, scale)?;
    let Centres::Two(centres) = centres else {
        return Err(format!("{name} has z: a packing of discs has x, y and radius"));
    };
    Ok((centres.into_iter().zip(radii).collect(), notes))
}

/// The spheres of a file; see [`read_flat`].
///
/// # Errors
/// Messages of [`fdem_io::read_packing`], and about circles, points and radii of zero.
pub(crate) fn read_space(
    bytes: &[u8],
    name: &str,
    scale: Option<f64>,
) -> Result<(Vec<Ball<3>>, Vec<String>), String> {
    let (centres, radii, notes) = read(bytes, name, scale)?;
    let Centres::Three(centres) = centres else {
        return Err(format!("{name} has no z: a packing of spheres has x, y, z and radius"));
    };
    Ok((centres.into_iter().zip(radii).collect(), notes))
}

/// Centres and radii of a file, m, and notes on how it was read.
fn read(bytes: &[u8], name: &str, scale: Option<f64>) -> Result<(Centres, Vec<f64>, Vec<String>), String> {
    let mut packing = fdem_io::read_packing(bytes, name, &ReadOptions::default(), &AtomicU64::new(0))
        .map_err(|error| format!("{name}: {error}"))?;
    let mut radii = packing.radii.take().ok_or_else(|| format!("{name} has no radii"))?;
    if let Some(row) = radii.iter().position(|&radius| radius <= 0.0) {
        return Err(format!("{name}: the radius of row {row} is 0"));
    }
    let mut notes: Vec<String> = packing.source.unused_axis().into_iter().collect();
    notes.extend(packing.flatten(2.0 * radii.iter().copied().fold(0.0, f64::max)));
    if packing.cell.is_some_and(|cell| cell.repeats.contains(&true)) {
        notes.push("its periodic box is not used: the bodies have no images".to_owned());
    }
    let scale = match (scale, packing.source.unit.as_deref()) {
        (Some(scale), _) => scale,
        (None, None) => 1.0,
        (None, Some(unit)) => length_of_unit(unit, &mut notes)?,
    };
    let coordinates = match &mut packing.centres {
        Centres::Two(centres) => centres.as_flattened_mut(),
        Centres::Three(centres) => centres.as_flattened_mut(),
    };
    coordinates.iter_mut().chain(&mut radii).for_each(|x| *x *= scale);
    let most = |ball: &[f64], radius: f64| ball.iter().fold(radius, |most, x| most.max(x.abs()));
    let most_of_row = |row: usize| match &packing.centres {
        Centres::Two(centres) => most(&centres[row], radii[row]),
        Centres::Three(centres) => most(&centres[row], radii[row]),
    };
    if let Some(row) = (0..radii.len()).find(|&row| most_of_row(row) > LARGEST) {
        return Err(format!(
            "{name}: row {row} has a number of {:e}: numbers are in metres, unless \"scale\" says otherwise, and from -{LARGEST:e} to {LARGEST:e}",
            most_of_row(row)
        ));
    }
    let notes = notes.into_iter().map(|note| format!("{name}: {note}")).collect();
    Ok((packing.centres, radii, notes))
}

/// Length in metres of the unit that the names of columns have, with a note unless it is the metre.
fn length_of_unit(unit: &str, notes: &mut Vec<String>) -> Result<f64, String> {
    let length = length_of(unit).or_else(|| length_of(&unit.to_lowercase())).ok_or_else(|| {
        format!(
            "its columns are in {unit}, which is no length known here: say scale, such as scale = \"1 mm\""
        )
    })?;
    if length != 1.0 {
        notes.push(format!("its columns are in {unit}, which is taken as {} m", brief(length)));
    }
    Ok(length)
}

/// The number of corners of a polygon or a polyhedron.
fn any_number([least, most]: [u32; 2], random: &mut Random) -> u64 {
    u64::from(least) + random.below(u64::from(most.saturating_sub(least)) + 1)
}

/// The outline of a disc or a polygon.
pub(crate) fn outline(
    packing: &Packing,
    (centre, radius): Ball<2>,
    size: &Grading<2>,
    random: &mut Random,
) -> Vec<Point> {
    if shape(packing, 2) != PieceShape::Polygon {
        return circle(centre, radius, size);
    }
    let corners = any_number(corners(packing, 2), random);
    let start = random.uniform();
    (0..corners)
        .map(|corner| {
            // Never two in one place: each stays within a third of its share.
            let turn = (corner as f64 + start + 0.6 * (random.uniform() - 0.5)) / corners as f64;
            let (sine, cosine) = libm::sincos(TAU * turn);
            [centre[0] + radius * cosine, centre[1] + radius * sine]
        })
        .collect()
}

/// The corners of a polyhedron on a sphere.
pub(crate) fn polyhedron(packing: &Packing, (centre, radius): Ball<3>, random: &mut Random) -> Vec<[f64; 3]> {
    let squared = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>();
    let mut corners: Vec<[f64; 3]> = Vec::new();
    for _ in 0..any_number(self::corners(packing, 3), random) {
        let candidates: [[f64; 3]; CANDIDATES] = std::array::from_fn(|_| direction(random));
        let apart = |point: [f64; 3]| {
            corners.iter().map(|&corner| squared(corner, point)).fold(f64::INFINITY, f64::min)
        };
        let [first, others @ ..] = candidates;
        let next = others
            .into_iter()
            .fold(first, |best, other| if apart(other) > apart(best) { other } else { best });
        corners.push(next);
    }
    corners.into_iter().map(|corner| [0, 1, 2].map(|k| centre[k] + radius * corner[k])).collect()
}

/// A point on the sphere of radius 1.
fn direction(random: &mut Random) -> [f64; 3] {
    loop {
        let point = [(); 3].map(|()| random.between(-1.0, 1.0));
        let square: f64 = point.iter().map(|x| x * x).sum();
        if (0.01..=1.0).contains(&square) {
            return point.map(|x| x / square.sqrt());
        }
    }
}

/// A random turn in space, all equally likely: an angle, degrees, and the axis.
///
/// # Source
/// K. Shoemake, "Uniform random rotations", Graphics Gems III (1992): quaternions on the sphere in four
/// dimensions.
pub(crate) fn turn(random: &mut Random) -> (f64, [f64; 3]) {
    loop {
        let [w, x, y, z] = [(); 4].map(|()| random.between(-1.0, 1.0));
        let across = x * x + y * y + z * z;
        if across > 1e-6 && across + w * w <= 1.0 {
            return (2.0 * libm::atan2(across.sqrt(), w).to_degrees(), [x, y, z]);
        }
    }
}
