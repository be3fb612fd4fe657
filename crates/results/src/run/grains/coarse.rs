//! Coarse graining: density, velocity and stress of spheres as fields on a grid.

use std::io::{self, Write};

use fdem_io::{Table, Values};
use fdem_simulation::grains::{GrainPartner, SphereColumns};
use serde::Serialize;

use crate::arrays::each;
use crate::run::grains::columns::checked;
use crate::run::grains::frame::end_of;
use crate::run::grains::walls::{bounds_of, is_somewhere};
use crate::run::snapshot::SnapshotError;

/// Parts of a line over which the kernel is integrated, for each half of its reach.
const PARTS: usize = 2;

/// Places and weights of Gauss and Legendre with five points on the interval from 0 to 1.
const PLACES: [f64; 5] =
    [0.046_910_077_030_668, 0.230_765_344_947_158_46, 0.5, 0.769_234_655_052_841_5, 0.953_089_922_969_332];
const WEIGHTS: [f64; 5] = [
    0.118_463_442_528_094_54,
    0.239_314_335_249_683_23,
    0.284_444_444_444_444_44,
    0.239_314_335_249_683_23,
    0.118_463_442_528_094_54,
];

/// Most points of a grid.
const MOST_POINTS: usize = 50_000_000;

/// A grid and a width for [`CoarseFields`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CoarseGrid {
    /// Distance of neighbouring points, m.
    pub spacing: f64,
    /// Width of the kernel, m: half of its reach. One to three radii of the spheres show a continuum.
    pub width: f64,
    /// The lowest and the highest corner of the grid, m; in the plane without its third axis. `None` for a
    /// grid that reaches as far as the fields of all spheres.
    pub region: Option<[[f64; 3]; 2]>,
}

impl CoarseGrid {
    /// Numbers of points along the axes between two corners, m, as numbers that may be too large. Along axes
    /// from `axes` on there is one.
    fn counts(&self, [low, high]: [[f64; 3]; 2], axes: usize) -> [f64; 3] {
        let wide = |axis: usize| ((high[axis] - low[axis]) / self.spacing * (1.0 + 1e-12)).floor() + 1.0;
        each(|axis| if axis < axes { wide(axis) } else { 1.0 })
    }

    /// Whether a grid in this region has more points than fields can have. `axes`: 2 in the plane.
    pub fn is_too_fine(&self, axes: usize) -> bool {
        self.region
            .is_some_and(|region| self.counts(region, axes).iter().product::<f64>() > MOST_POINTS as f64)
    }
}

/// Fields of spheres on a regular grid, which satisfy the balances of mass and momentum of a continuum
/// exactly: sums over the spheres and their contacts, weighted with the kernel of Lucy, `φ(r) = 105/(16πc³)
/// (1 + 3r/c)(1 - r/c)³` in space and `5/(πc²)` of the same in the plane, up to its reach `c`, twice the
/// width.
///
/// ```text
/// ρ = Σ m φ      ρV = Σ m v φ      σ = -Σ m v'v' φ - ½ Σᵢⱼ fᵢⱼ rᵢⱼ ∫ φ along the line between the centres
/// ```
/// with `v' = v - V`, the force `fᵢⱼ` on `i` and `rᵢⱼ` from `j` to `i`. A contact with a wall or a body
/// counts once, along the line to its place.
///
/// # Shapes
/// One entry for each point: x first, then y, then z. Of discs the grid is in the plane, with one layer, and
/// the values are those of their thickness. In a periodic box the images of spheres count, too.
///
/// # Cost
/// Time proportional to the spheres and contacts, and to the points in the reach of each.
///
/// # Source
/// I. Goldhirsch, "Stress, stress asymmetry and couple stress: from discrete particles to continuous fields",
/// Granular Matter 12 (2010) 239-252; T. Weinhart, A.R. Thornton, S. Luding, O. Bokhove, "From discrete
/// particles to continuum fields near a boundary", Granular Matter 14 (2012) 289-294: walls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CoarseFields {
    /// The first point, m.
    pub origin: [f64; 3],
    /// Distance of neighbouring points, m.
    pub spacing: f64,
    /// Numbers of points along the axes.
    pub counts: [usize; 3],
    /// Density, kg/m³.
    pub density: Vec<f64>,
    /// Share of the volume that spheres fill.
    pub solid_fraction: Vec<f64>,
    /// Velocity, m/s; 0 where the density is 0.
    pub velocity: Vec<[f64; 3]>,
    /// Stress, `[xx, yy, zz, xy, yz, xz]` in Pa, tension positive; the symmetric part.
    pub stress: Vec<[f64; 6]>,
}

/// Places of a symmetric tensor.
const TENSOR: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]];

/// The reason why there are no fields.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CoarseError {
    /// A length is not above 0 and finite.
    Length {
        /// `spacing` or `width`.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// The grid has too many points.
    TooMany {
        /// The spacing, m.
        spacing: f64,
    },
    /// The spheres contradict themselves.
    Snapshot(SnapshotError),
}

impl std::fmt::Display for CoarseError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Length { name, value } => {
                write!(out, "the {name} of coarse graining is {value}: it must be above 0 and finite")
            }
            Self::TooMany { spacing } => {
                write!(
                    out,
                    "a grid with a spacing of {spacing} m has more than {MOST_POINTS} points around the spheres"
                )
            }
            Self::Snapshot(error) => error.fmt(out),
        }
    }
}

impl std::error::Error for CoarseError {}

impl CoarseFields {
    /// Computes the fields on a grid. Without spheres and without a region it has no points.
    ///
    /// # Errors
    /// [`CoarseError`].
    pub fn new(spheres: &SphereColumns, grid: CoarseGrid) -> Result<Self, CoarseError> {
        for (name, value) in [("spacing", grid.spacing), ("width", grid.width)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(CoarseError::Length { name, value });
            }
        }
        checked(spheres).map_err(CoarseError::Snapshot)?;
        let kernel = Kernel::new(2.0 * grid.width, spheres.discs, spheres.period);
        let ends = spheres.contacts.iter().map(|contact| end_of(spheres, contact));
        let bounds = bounds_of(spheres.positions.iter().copied().chain(ends));
        let around = is_somewhere(&bounds).then(|| {
            let on_grid = |x: f64, round: fn(f64) -> f64| round(x / grid.spacing) * grid.spacing;
            [
                each(|axis| on_grid(bounds[axis][0] - kernel.reach, f64::floor)),
                each(|axis| on_grid(bounds[axis][1] + kernel.reach, f64::ceil)),
            ]
        });
        let Some([low, high]) = grid.region.or(around) else { return Ok(Self::default()) };
        let origin: [f64; 3] = each(|axis| if axis < kernel.axes { low[axis] } else { 0.0 });
        let sizes = grid.counts([low, high], kernel.axes);
        if sizes.iter().product::<f64>() > MOST_POINTS as f64 {
            return Err(CoarseError::TooMany { spacing: grid.spacing });
        }
        let counts = sizes.map(|size| size as usize);
        let size = counts.iter().product();
        let mut fields = Self {
            origin,
            spacing: grid.spacing,
            counts,
            density: vec![0.0; size],
            solid_fraction: vec![0.0; size],
            velocity: vec![[0.0; 3]; size],
            stress: vec![[0.0; 6]; size],
        };
        fields.add_spheres(spheres, &kernel);
        fields.add_fluctuations(spheres, &kernel);
        fields.add_contacts(spheres, &kernel);
        Ok(fields)
    }

    /// Adds densities and velocities.
    fn add_spheres(&mut self, spheres: &SphereColumns, kernel: &Kernel) {
        for (k, &centre) in spheres.positions.iter().enumerate() {
            let (mass, volume, velocity) =
                (spheres.masses[k], kernel.volume(spheres.radii[k]), spheres.velocities[k]);
            self.near([centre; 2], kernel, |fields, point, at| {
                let weight = kernel.at(distance(at, centre));
                fields.density[point] += mass * weight;
                fields.solid_fraction[point] += volume * weight;
                for (sum, x) in fields.velocity[point].iter_mut().zip(velocity) {
                    *sum += mass * x * weight;
                }
            });
        }
        for (velocity, &density) in self.velocity.iter_mut().zip(&self.density) {
            *velocity = velocity.map(|x| if density > 0.0 { x / density } else { 0.0 });
        }
    }

    /// Adds the stress of the motion of spheres against the mean one.
    fn add_fluctuations(&mut self, spheres: &SphereColumns, kernel: &Kernel) {
        for (k, &centre) in spheres.positions.iter().enumerate() {
            let (mass, velocity) = (spheres.masses[k], spheres.velocities[k]);
            self.near([centre; 2], kernel, |fields, point, at| {
                let weight = kernel.at(distance(at, centre));
                let own: [f64; 3] = each(|axis| velocity[axis] - fields.velocity[point][axis]);
                for (sum, [i, j]) in fields.stress[point].iter_mut().zip(TENSOR) {
                    *sum -= mass * own[i] * own[j] * weight;
                }
            });
        }
    }

    /// Adds the stress of contacts.
    fn add_contacts(&mut self, spheres: &SphereColumns, kernel: &Kernel) {
        for contact in &spheres.contacts {
            let (from, to) = (spheres.positions[contact.sphere as usize], end_of(spheres, contact));
            let branch: [f64; 3] = each(|axis| from[axis] - to[axis]);
            // Each contact of two spheres is in the list once, so that half of the sum over both is all of
            // it.
            debug_assert!(!matches!(contact.other, GrainPartner::Sphere(other) if other == contact.sphere));
            let force = contact.force;
            let moment: [f64; 6] = TENSOR.map(|[i, j]| 0.5 * (force[i] * branch[j] + force[j] * branch[i]));
            self.near([from, to], kernel, |fields, point, at| {
                let weight = kernel.along(at, from, to);
                for (sum, moment) in fields.stress[point].iter_mut().zip(moment) {
                    *sum -= moment * weight;
                }
            });
        }
    }

    /// Calls `add` for each point in the reach of a line or of one of its images, with its place as seen from
    /// there.
    fn near(
        &mut self,
        ends: [[f64; 3]; 2],
        kernel: &Kernel,
        mut add: impl FnMut(&mut Self, usize, [f64; 3]),
    ) {
        for &shift in &kernel.images {
            self.near_one(ends, shift, kernel, &mut add);
        }
    }

    /// The same for one image, which is so far away, m.
    fn near_one(
        &mut self,
        ends: [[f64; 3]; 2],
        shift: [f64; 3],
        kernel: &Kernel,
        add: &mut impl FnMut(&mut Self, usize, [f64; 3]),
    ) {
        let (spacing, counts) = (self.spacing, self.counts);
        let origin: [f64; 3] = each(|axis| self.origin[axis] - shift[axis]);
        let range = |axis: usize| {
            if axis >= kernel.axes {
                return 0..1;
            }
            let [low, high] = [ends[0][axis].min(ends[1][axis]), ends[0][axis].max(ends[1][axis])];
            // A negative number is cast to 0.
            let first = ((low - kernel.reach - origin[axis]) / spacing).ceil() as usize;
            let last = ((high + kernel.reach - origin[axis]) / spacing).floor();
            first..if last < 0.0 { 0 } else { (last as usize + 1).min(counts[axis]) }
        };
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    let places = [i, j, k];
                    let at = each(|axis| origin[axis] + places[axis] as f64 * spacing);
                    add(self, (k * counts[1] + j) * counts[0] + i, at);
                }
            }
        }
    }

    /// Writes the fields as a `.vti` file for ParaView.
    ///
    /// # Errors
    /// The errors of `out`; [`io::ErrorKind::InvalidInput`] for a grid without points.
    pub fn write_vti<W: Write>(&self, out: &mut W, time: f64) -> io::Result<()> {
        let points = Table::new(self.density.len())
            .with("density", Values::f64(|k| self.density[k]))
            .in_unit("kg/m³")
            .with("solid_fraction", Values::f64(|k| self.solid_fraction[k]))
            .with_components("velocity", &["x", "y", "z"], Values::f64(|k| self.velocity[k / 3][k % 3]))
            .in_unit("m/s")
            .with_components(
                "stress",
                &["xx", "yy", "zz", "xy", "yz", "xz"],
                Values::f64(|k| self.stress[k / 6][k % 6]),
            )
            .in_unit("Pa");
        fdem_io::write_vti(out, self.origin, self.spacing, self.counts, &points, time)
    }
}

/// The kernel of Lucy.
struct Kernel {
    /// Number of axes: 2 for discs.
    axes: usize,
    /// Distance from which on it is 0, m.
    reach: f64,
    /// Its value at 0 over the thickness of discs, 1/m³.
    top: f64,
    thickness: Option<f64>,
    /// The distances of a sphere from itself and its images that may reach into the box, m.
    images: Vec<[f64; 3]>,
}

/// The distances of a sphere from itself and its images in a periodic box that may reach into the box, m.
/// `period`: lengths of the box, m, infinite along axes that do not repeat.
fn images(reach: f64, period: [f64; 3]) -> Vec<[f64; 3]> {
    let along = |axis: usize| {
        let most = (2.0 * reach / period[axis]).ceil() as i32;
        let step = move |number: i32| if number == 0 { 0.0 } else { f64::from(number) * period[axis] };
        (-most..=most).map(step)
    };
    let in_plane = |z: f64| along(1).flat_map(move |y| along(0).map(move |x| [x, y, z]));
    along(2).flat_map(in_plane).collect()
}

impl Kernel {
    fn new(reach: f64, discs: Option<f64>, period: Option<[[f64; 3]; 2]>) -> Self {
        let pi = std::f64::consts::PI;
        let (axes, top) = match discs {
            Some(thickness) => (2, 5.0 / (pi * reach * reach * thickness)),
            None => (3, 105.0 / (16.0 * pi * reach * reach * reach)),
        };
        let images = images(reach, period.map_or([f64::INFINITY; 3], |[_, lengths]| lengths));
        Self { axes, reach, top, thickness: discs, images }
    }

    /// Value at a distance, 1/m³.
    fn at(&self, distance: f64) -> f64 {
        let share = distance / self.reach;
        if share >= 1.0 {
            return 0.0;
        }
        let rest = 1.0 - share;
        self.top * (1.0 + 3.0 * share) * rest * rest * rest
    }

    /// Mean of the values at a point along a line, 1/m³.
    fn along(&self, at: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
        let parts = ((distance(from, to) / self.reach * 2.0).ceil() as usize).max(1) * PARTS;
        let share = 1.0 / parts as f64;
        let mut sum = 0.0;
        for part in 0..parts {
            for (place, weight) in PLACES.iter().zip(WEIGHTS) {
                let along = (part as f64 + place) * share;
                let on = each(|axis| from[axis] + along * (to[axis] - from[axis]));
                sum += weight * share * self.at(distance(at, on));
            }
        }
        sum
    }

    /// Volume of a sphere or a disc with this radius, m³.
    fn volume(&self, radius: f64) -> f64 {
        let pi = std::f64::consts::PI;
        match self.thickness {
            Some(thickness) => pi * radius * radius * thickness,
            None => 4.0 / 3.0 * pi * radius * radius * radius,
        }
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y, z]: [f64; 3] = each(|axis| a[axis] - b[axis]);
    (x * x + y * y + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use fdem_simulation::grains::{GrainContact, Wall};

    use super::*;

    /// Two spheres that press each other, and the floor.
    fn pair(discs: Option<f64>) -> SphereColumns {
        let (up, force) = ([0.3, 0.9, if discs.is_some() { 0.0 } else { 0.1 }], [-30.0, -90.0, 0.0]);
        SphereColumns {
            numbers: vec![0, 1],
            positions: vec![[0.0; 3], up],
            radii: vec![0.5; 2],
            velocities: vec![[1.0, 0.0, 0.0], [-1.0, 2.0, 0.0]],
            spins: vec![[0.0; 3]; 2],
            forces: vec![[0.0; 3]; 2],
            masses: vec![3.0, 5.0],
            materials: vec![0; 2],
            groups: vec![0; 2],
            contacts: vec![
                GrainContact {
                    sphere: 0,
                    other: GrainPartner::Sphere(1),
                    place: up.map(|x| 0.5 * x),
                    force,
                    normal: 94.0,
                    overlap: 0.01,
                },
                GrainContact {
                    sphere: 0,
                    other: GrainPartner::Wall(0),
                    place: [0.0, -0.48, 0.0],
                    force: [0.0, 90.0, 0.0],
                    normal: 90.0,
                    overlap: 0.02,
                },
            ],
            walls: vec![Wall::plane([0.0, -0.48, 0.0], [0.0, 1.0, 0.0], 0)],
            wall_forces: vec![[0.0, -90.0, 0.0]],
            discs,
            ..SphereColumns::default()
        }
    }

    /// The sums over the grid are those of the spheres: mass, volume, momentum, and the moments of all forces
    /// with the kinetic part.
    #[test]
    fn integrals_over_space_are_sums_over_spheres() {
        for discs in [None, Some(0.25)] {
            let spheres = pair(discs);
            let fields =
                CoarseFields::new(&spheres, CoarseGrid { spacing: 0.05, width: 0.4, region: None }).unwrap();
            let cell = discs.map_or(0.05_f64.powi(3), |thickness| 0.05 * 0.05 * thickness);
            let sum = |values: &mut dyn Iterator<Item = f64>| cell * values.sum::<f64>();
            let near = |found: f64, expected: f64, scale: f64| {
                assert!((found - expected).abs() < 2e-3 * scale, "{found} {expected} {discs:?}");
            };
            near(sum(&mut fields.density.iter().copied()), 8.0, 8.0);
            let pi = std::f64::consts::PI;
            let volume = discs.map_or(pi / 3.0, |thickness| pi / 2.0 * thickness);
            near(sum(&mut fields.solid_fraction.iter().copied()), volume, volume);
            let momentum = |axis: usize| {
                sum(&mut fields.velocity.iter().zip(&fields.density).map(|(v, density)| v[axis] * density))
            };
            near(momentum(0), 3.0 - 5.0, 8.0);
            near(momentum(1), 10.0, 8.0);
            // Kinetic energy of the mean motion and of the fluctuations are that of the spheres.
            let mean = sum(&mut fields
                .velocity
                .iter()
                .zip(&fields.density)
                .map(|(v, density)| v[1] * v[1] * density));
            let contacts = -(-90.0 * -0.9 + 90.0 * 0.48);
            near(sum(&mut fields.stress.iter().map(|stress| stress[1])), contacts - (20.0 - mean), 100.0);
            // The shear of the contacts: half of f_x b_y + f_y b_x, with the branch from the other to the
            // first.
            let shear = -0.5 * (-30.0 * -0.9 + -90.0 * -0.3);
            let mean = sum(&mut fields
                .velocity
                .iter()
                .zip(&fields.density)
                .map(|(v, density)| v[0] * v[1] * density));
            near(sum(&mut fields.stress.iter().map(|stress| stress[3])), shear - (-10.0 - mean), 100.0);
        }
    }

    #[test]
    fn a_crystal_has_its_density_and_pressure_inside() {
        // A cubic lattice with an edge of 1 whose neighbours press with 2 N: the pressure is 2 Pa.
        let side = 8_usize;
        let mut spheres = SphereColumns::default();
        for k in 0..side * side * side {
            let at = [k % side, k / side % side, k / side / side];
            spheres.numbers.push(k as u32);
            spheres.positions.push(at.map(|x| x as f64));
            for (axis, step) in [1, side, side * side].into_iter().enumerate() {
                if at[axis] + 1 < side {
                    let mut force = [0.0; 3];
                    force[axis] = -2.0;
                    spheres.contacts.push(GrainContact {
                        sphere: k as u32,
                        other: GrainPartner::Sphere((k + step) as u32),
                        place: [0.0; 3],
                        force,
                        normal: 2.0,
                        overlap: 0.0,
                    });
                }
            }
        }
        let count = spheres.positions.len();
        spheres.radii = vec![0.5; count];
        spheres.masses = vec![7.0; count];
        (spheres.velocities, spheres.spins) = (vec![[0.0, 0.0, 3.0]; count], vec![[0.0; 3]; count]);
        spheres.forces = vec![[0.0; 3]; count];
        (spheres.materials, spheres.groups) = (vec![0; count], vec![0; count]);
        let fields =
            CoarseFields::new(&spheres, CoarseGrid { spacing: 0.5, width: 1.25, region: None }).unwrap();
        let place = [0, 1, 2].map(|axis| ((3.5 - fields.origin[axis]) / 0.5).round() as usize);
        let point = (place[2] * fields.counts[1] + place[1]) * fields.counts[0] + place[0];
        assert!((fields.density[point] / 7.0 - 1.0).abs() < 0.01, "{}", fields.density[point]);
        let [xx, yy, zz, shears @ ..] = fields.stress[point];
        for pressure in [xx, yy, zz] {
            assert!((pressure + 2.0).abs() < 0.02, "{:?}", fields.stress[point]);
        }
        assert!(shears.iter().all(|shear| shear.abs() < 1e-12));
        assert!((fields.velocity[point][2] - 3.0).abs() < 1e-12);
        let mut file = Vec::new();
        fields.write_vti(&mut file, 0.5).unwrap();
        assert!(file.starts_with(b"<?xml") && String::from_utf8_lossy(&file).contains("solid_fraction"));
    }

    /// In a periodic box the sums over the grid of the box are those of the spheres, with a contact across
    /// its corner and images that reach over it.
    #[test]
    fn images_fill_a_periodic_box() {
        let mut spheres = pair(None);
        spheres.period = Some([[0.0; 3], [2.0; 3]]);
        spheres.positions = vec![[0.1; 3], [1.8, 1.2, 0.0]];
        spheres.contacts.truncate(1);
        spheres.contacts[0].place = [-0.05, -0.35, 0.05];
        let region = Some([[0.0; 3], [1.95; 3]]);
        let fields = CoarseFields::new(&spheres, CoarseGrid { spacing: 0.05, width: 0.4, region }).unwrap();
        assert_eq!(fields.counts, [40; 3]);
        let sum = |of: &dyn Fn(usize) -> f64| (0..64_000).map(of).sum::<f64>() * 0.05_f64.powi(3);
        let mass = sum(&|point| fields.density[point]);
        assert!((mass / 8.0 - 1.0).abs() < 1e-4, "{mass}");
        // The branch leads from the image of the second sphere to the first.
        let branch = [0.3, 0.9, 0.1];
        let mean = |axis: usize| sum(&|k| fields.density[k] * fields.velocity[k][axis].powi(2));
        for (axis, kinetic) in [8.0, 20.0].into_iter().enumerate() {
            let expected = -spheres.contacts[0].force[axis] * branch[axis] - (kinetic - mean(axis));
            let found = sum(&|point| fields.stress[point][axis]);
            assert!((found - expected).abs() < 0.01, "{axis}: {found} {expected}");
        }
    }

    #[test]
    fn wrong_lengths_and_huge_grids_are_refused() {
        let spheres = pair(None);
        let error = |spacing, width| {
            CoarseFields::new(&spheres, CoarseGrid { spacing, width, region: None }).unwrap_err().to_string()
        };
        assert_eq!(error(0.0, 1.0), "the spacing of coarse graining is 0: it must be above 0 and finite");
        assert!(error(1.0, f64::NAN).starts_with("the width of coarse graining is NaN"));
        assert!(error(1e-6, 1.0).contains("more than 50000000 points"));
        let none = CoarseFields::new(
            &SphereColumns::default(),
            CoarseGrid { spacing: 1.0, width: 1.0, region: None },
        )
        .unwrap();
        assert!(none.density.is_empty());
    }
}
