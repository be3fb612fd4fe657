//! Means over spheres, and forces on walls.

use fdem_grains::{GrainPartner, GrainRun, SphereColumns};

use crate::probe::touching::TouchingSide;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::vector::{Point, minus};

/// Places in `[xx, yy, zz, xy, yz, xz]` of these components.
pub(super) const PLACES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]];

/// Names and units of the values of a wall.
pub(super) const WALL: [(&str, &str); 9] = [
    ("fx", "N"),
    ("fy", "N"),
    ("fz", "N"),
    ("mx", "N m"),
    ("my", "N m"),
    ("mz", "N m"),
    ("ux", "m"),
    ("uy", "m"),
    ("uz", "m"),
];

/// Names and units of the means over spheres.
pub(super) const SPHERES: [(&str, &str); 19] = [
    ("spheres", "1"),
    ("coordination", "1"),
    ("solid_fraction", "1"),
    ("kinetic", "J"),
    ("sxx", "Pa"),
    ("syy", "Pa"),
    ("szz", "Pa"),
    ("sxy", "Pa"),
    ("syz", "Pa"),
    ("sxz", "Pa"),
    ("fabric_xx", "1"),
    ("fabric_yy", "1"),
    ("fabric_zz", "1"),
    ("fabric_xy", "1"),
    ("fabric_yz", "1"),
    ("fabric_xz", "1"),
    ("lx", "m"),
    ("ly", "m"),
    ("lz", "m"),
];

/// Number of sums over spheres: number of spheres and of their contacts, volume of the spheres, kinetic
/// energy, stress times volume, sum of `n n` over the contacts, and sides of the region.
pub(super) const SUMS: usize = SPHERES.len();

/// The means over spheres from their sums.
pub(super) fn means(sums: &[f64]) -> Vec<f64> {
    let [count, contacts, volume, kinetic, .., x, y, z] = *sums else { return Vec::new() };
    let region = x * y * z;
    let stress = sums[4..10].iter().map(|sum| sum / region);
    let fabric = sums[10..16].iter().map(|sum| sum / contacts);
    let first = [count, contacts / count, volume / region, kinetic];
    first.into_iter().chain(stress).chain(fabric).chain([x, y, z]).collect()
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The spheres on the rank that counts them.
    fn counted_spheres(&self) -> Option<&GrainRun> {
        self.actions.spheres.run().filter(|_| self.scene().counts_common())
    }

    /// Visits the values of a wall, and 1 for the wall itself.
    pub(super) fn visit_wall(&self, wall: u32, mut visit: impl FnMut(&[f64; 10])) {
        let number = wall as usize;
        let Some(run) = self.counted_spheres().filter(|run| number < run.walls().len()) else { return };
        let [fx, fy, fz] = run.wall_force(number);
        let [mx, my, mz] = run.wall_moment(number);
        let [ux, uy, uz] = run.wall_displacement(number);
        visit(&[fx, fy, fz, mx, my, mz, ux, uy, uz, 1.0]);
    }

    /// Visits the force of each contact of spheres between two sides, N: with its sign, that of the first
    /// side on the second.
    pub(super) fn visit_forces_of_spheres(
        &self,
        [by, on]: &[TouchingSide; 2],
        mut visit: impl FnMut([f64; 3], f64),
    ) {
        let Some(run) = self.counted_spheres() else { return };
        let columns = run.columns();
        let bodies = self.actions.spheres.bodies_of_facets();
        let is_sphere = |side: &TouchingSide, sphere: u32| match side {
            TouchingSide::Spheres(name) => {
                columns.group_names.get(columns.groups[sphere as usize] as usize) == Some(name)
            }
            TouchingSide::Bodies(_) => false,
        };
        let is_other = |side: &TouchingSide, other: &GrainPartner| match (side, other) {
            (_, GrainPartner::Sphere(sphere)) => is_sphere(side, *sphere),
            (TouchingSide::Bodies(list), GrainPartner::Facet(facet)) => {
                bodies.get(*facet as usize).is_some_and(|body| list.binary_search(body).is_ok())
            }
            _ => false,
        };
        for contact in &columns.contacts {
            // The force is that on the sphere.
            if is_sphere(on, contact.sphere) && is_other(by, &contact.other) {
                visit(contact.force, 1.0);
            } else if is_sphere(by, contact.sphere) && is_other(on, &contact.other) {
                visit(contact.force, -1.0);
            }
        }
    }

    /// Visits sums over the spheres whose centres are in a region, a box by its lowest and its highest
    /// corner, m; `None` for the box around all spheres, and along axes that repeat for their period.
    pub(super) fn visit_spheres(&self, region: Option<[Point<3>; 2]>, mut visit: impl FnMut(&[f64; SUMS])) {
        let Some(run) = self.counted_spheres() else { return };
        let columns = run.columns();
        let [low, high] = region.unwrap_or_else(|| around(&columns));
        let axes = 0..if columns.discs.is_some() { 2 } else { 3 };
        let mut sums = [0.0; SUMS];
        for axis in 0..3 {
            let side = if axes.contains(&axis) { Some(high[axis] - low[axis]) } else { columns.discs };
            sums[SUMS - 3 + axis] = side.unwrap_or(1.0);
        }
        visit(&sums);
        let inside: Vec<bool> = columns
            .positions
            .iter()
            .map(|centre| axes.clone().all(|axis| low[axis] <= centre[axis] && centre[axis] <= high[axis]))
            .collect();
        let numbers = || (0..columns.numbers.len()).filter(|&sphere| inside[sphere]);
        for sphere in numbers() {
            let (radius, mass) = (columns.radii[sphere], columns.masses[sphere]);
            let volume = match columns.discs {
                Some(thickness) => std::f64::consts::PI * radius * radius * thickness,
                None => 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius,
            };
            let square = |vector: Point<3>| vector.iter().map(|x| x * x).sum::<f64>();
            let shape = if columns.discs.is_some() { 0.5 } else { 0.4 };
            let turning = shape * radius * radius * square(columns.spins[sphere]);
            let mut sums = [0.0; SUMS];
            (sums[0], sums[2]) = (1.0, volume);
            sums[3] = 0.5 * mass * (square(columns.velocities[sphere]) + turning);
            visit(&sums);
        }
        for contact in &columns.contacts {
            let ends = match contact.other {
                GrainPartner::Sphere(other) => [Some((contact.sphere, 1.0)), Some((other, -1.0))],
                GrainPartner::Wall(_) | GrainPartner::Facet(_) => [Some((contact.sphere, 1.0)), None],
            };
            for (sphere, sign) in ends.into_iter().flatten().filter(|of| inside[of.0 as usize]) {
                let arm = columns.shortest(minus(contact.place, columns.positions[sphere as usize]));
                let force = contact.force.map(|f| sign * f);
                let size = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
                let mut sums = [0.0; SUMS];
                sums[1] = 1.0;
                for (k, [i, j]) in PLACES.into_iter().enumerate() {
                    sums[4 + k] = 0.5 * (arm[i] * force[j] + arm[j] * force[i]);
                    sums[10 + k] = if size > 0.0 { arm[i] * arm[j] / (size * size) } else { 0.0 };
                }
                visit(&sums);
            }
        }
    }
}

/// The box around all spheres, m.
fn around(columns: &SphereColumns) -> [Point<3>; 2] {
    let mut corners = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for (centre, radius) in columns.positions.iter().zip(&columns.radii) {
        for axis in 0..3 {
            corners[0][axis] = corners[0][axis].min(centre[axis] - radius);
            corners[1][axis] = corners[1][axis].max(centre[axis] + radius);
        }
    }
    let [low, lengths] = columns.period.unwrap_or([[0.0; 3], [f64::INFINITY; 3]]);
    for axis in (0..3).filter(|&axis| lengths[axis].is_finite()) {
        (corners[0][axis], corners[1][axis]) = (low[axis], low[axis] + lengths[axis]);
    }
    corners
}
