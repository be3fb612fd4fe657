//! Models that several cases of spheres share.

use fdem_grains::{GrainMaterial, GrainModel, GrainRun, Spheres, Surfaces, Wall, WallShape};

/// m/s².
pub(super) const GRAVITY: f64 = 9.81;

pub(super) fn material(youngs_modulus: f64, poissons_ratio: f64, density: f64) -> GrainMaterial {
    GrainMaterial { density, youngs_modulus, poissons_ratio }
}

/// The material of a wall that does not deform.
pub(super) fn rigid() -> GrainMaterial {
    material(f64::INFINITY, 0.3, 1.0)
}

/// Begins a run on one thread.
pub(super) fn start(model: GrainModel) -> Result<GrainRun, String> {
    GrainRun::new(model, 1).map_err(|error| error.to_string())
}

/// Advances a run up to a time, s.
pub(super) fn advance_to(run: &mut GrainRun, time: f64) -> Result<(), String> {
    let steps = (time / run.time_step()).round() as u64;
    run.advance(steps.saturating_sub(run.steps())).map_err(|error| error.to_string())
}

/// One sphere that just touches the plane z = 0. Materials: of the sphere, and of the plane.
pub(super) fn on_plane(
    radius: f64,
    velocity: [f64; 3],
    spin: [f64; 3],
    of: [GrainMaterial; 2],
) -> GrainModel {
    GrainModel {
        spheres: Spheres {
            positions: vec![[0.0, 0.0, radius]],
            radii: vec![radius],
            velocities: vec![velocity],
            spins: vec![spin],
            ..Spheres::default()
        },
        walls: vec![Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 1)],
        materials: of.to_vec(),
        surfaces: vec![Surfaces::smooth([0, 1])],
        ..GrainModel::default()
    }
}

/// Reduced modulus of two materials, Pa.
pub(super) fn reduced_modulus(of: [GrainMaterial; 2]) -> f64 {
    1.0 / of.iter().map(|of| (1.0 - of.poissons_ratio * of.poissons_ratio) / of.youngs_modulus).sum::<f64>()
}

/// Mass of a sphere, kg.
pub(super) fn mass(radius: f64, of: GrainMaterial) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * of.density
}

/// Overlap at which Hertz's force is `force`, m. `radius` is the reduced one.
pub(super) fn hertz_depth(force: f64, modulus: f64, radius: f64) -> f64 {
    libm::pow(0.75 * force / (modulus * radius.sqrt()), 2.0 / 3.0)
}

/// Mean radius of the spheres, m; those of a packing differ by up to a fifth.
pub(super) const RADIUS: f64 = 2.5e-3;

/// A number between -1 and 1 of a place in a sequence, the same on all platforms.
pub(super) fn scatter(place: usize) -> f64 {
    let mut bits = (place as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// The inside of a tube around the z axis. `radius`: m.
pub(super) fn tube(radius: f64, material: u32) -> Wall {
    Wall {
        shape: WallShape::Tube { axis: [[0.0; 3], [0.0, 0.0, 1.0]], radius },
        ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], material)
    }
}

/// Spheres that fall in a tube on the plane z = 0. `across`: radius of the tube, and `high`: height of the
/// packing at rest, about, both over the mean radius of the spheres. `friction`: of spheres with each other
/// and with the plane, and with the tube.
pub(super) fn tube_of_spheres(across: f64, high: f64, friction: [f64; 2]) -> GrainModel {
    let pitch = 2.45 * RADIUS;
    let cells = (across * RADIUS / pitch).ceil() as i32;
    let places: Vec<[f64; 2]> = (-cells..=cells)
        .flat_map(|i| (-cells..=cells).map(move |j| [pitch * f64::from(i), pitch * f64::from(j)]))
        .filter(|[x, y]| x.hypot(*y) <= (across - 1.3) * RADIUS)
        .collect();
    let volume = 0.6 * across * across * high;
    let layers = (volume / (4.0 / 3.0 * places.len() as f64)).round() as i32;
    let mut spheres = Spheres::default();
    for layer in 0..layers {
        for [x, y] in &places {
            let k = spheres.radii.len();
            let jitter = |axis: usize| 0.05 * RADIUS * scatter(4 * k + axis);
            let z = pitch * (f64::from(layer) + 0.5);
            spheres.positions.push([x + jitter(0), y + jitter(1), z + jitter(2)]);
            spheres.radii.push(RADIUS * (1.0 + 0.2 * scatter(4 * k + 3)));
        }
    }
    let surfaces = |materials: [u32; 2], friction: f64| Surfaces {
        friction,
        restitution: 0.4,
        ..Surfaces::smooth(materials)
    };
    GrainModel {
        spheres,
        walls: vec![Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0), tube(across * RADIUS, 1)],
        materials: vec![material(SOFT, 0.25, 2500.0); 2],
        surfaces: vec![surfaces([0, 0], friction[0]), surfaces([0, 1], friction[1])],
        gravity: [0.0, 0.0, -GRAVITY],
        ..GrainModel::default()
    }
}

/// A run of spheres that have fallen and are at rest, nearly.
pub(super) fn settled(model: &GrainModel) -> Result<GrainRun, String> {
    let top = model.spheres.positions.last().map_or(0.0, |of| of[2]);
    let mut run = start(model.clone())?;
    advance_to(&mut run, 1.6 * (2.0 * top / GRAVITY).sqrt() + 0.05)?;
    Ok(run)
}

/// Modulus of spheres in packings, Pa: soft, so that the steps are long. Under their weight they overlap by a
/// hundredth of their radius.
const SOFT: f64 = 5e5;
