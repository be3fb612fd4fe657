//! The cases: spheres in a chute and in a tube.

use std::error::Error;
use std::f64::consts::PI;

use fdem_grains::{
    Domain, ForceLaw, GrainMaterial, GrainModel, GrainRun, Outside, Spheres, Surfaces, Wall, WallShape,
};

/// Stiffness of Hooke's law, N/m, and damping of a contact, 1/s: those of the chute that LAMMPS ships. All
/// units are those of LAMMPS' case: a diameter, a mass of a cube of that side, and the time in which weight
/// moves a sphere by half a diameter.
pub(crate) const STIFFNESS: f64 = 2000.0;
pub(crate) const DAMPING: f64 = 50.0;

/// Tangential stiffness over the normal one.
pub(crate) const TANGENTIAL: f64 = 2.0 / 7.0;

/// Coefficient of friction.
pub(crate) const FRICTION: f64 = 0.5;

/// Young's modulus and Poisson's ratio of Hertz's law: overlaps at the bottom of the chute are as with
/// Hooke's.
pub(crate) const YOUNG: f64 = 56_250.0;
pub(crate) const POISSON: f64 = 0.25;

/// Time step.
pub(crate) const STEP: f64 = 1e-4;

/// Angle of the chute, degrees.
pub(crate) const ANGLE: f64 = 26.0;

/// Sides of the chute, and its height while it is filled.
pub(crate) const CHUTE: [f64; 3] = [40.0, 20.0, 37.2];

/// Radius of the tube, and its height while it is filled.
pub(crate) const TUBE: [f64; 2] = [12.3, 60.0];

/// Steps in which spheres at random places push each other apart, and steps under weight after that.
const APART: u64 = 4000;
const SETTLING: u64 = 10_000;

/// Where the spheres are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Equal spheres flow over a rough floor, in a box that repeats along x and y.
    Chute,
    /// Spheres with diameters from 0.9 to 1.1 settle in a tube.
    Tube,
}

/// The law of the contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Law {
    Hooke,
    Hertz,
}

impl Place {
    pub(crate) fn named(name: &str) -> Option<Self> {
        [Self::Chute, Self::Tube].into_iter().find(|place| place.name() == name)
    }

    pub(crate) fn name(self) -> &'static str {
        if self == Self::Chute { "chute" } else { "tube" }
    }

    /// Number of spheres that the case has if none is given.
    pub(crate) fn usual(self) -> usize {
        if self == Self::Chute { 32_000 } else { 30_000 }
    }
}

impl Law {
    pub(crate) fn named(name: &str) -> Option<Self> {
        [Self::Hooke, Self::Hertz].into_iter().find(|law| law.name() == name)
    }

    pub(crate) fn name(self) -> &'static str {
        if self == Self::Hooke { "hooke" } else { "hertz" }
    }
}

/// Places, velocities and spins from which a case is timed.
///
/// # Errors
/// The error of the run.
pub(crate) fn prepared(place: Place, count: usize) -> Result<Spheres, Box<dyn Error>> {
    let mut run = GrainRun::new(filled(place, count), 0)?;
    run.advance(APART)?;
    let columns = run.columns();
    let held = columns.positions.iter().map(|at| place == Place::Chute && at[2] < 1.0).collect();
    let spheres = Spheres { positions: columns.positions, radii: columns.radii, held, ..Spheres::default() };
    let mut run = GrainRun::new(model(place, Law::Hooke, spheres.clone(), count), 0)?;
    run.advance(SETTLING)?;
    let columns = run.columns();
    Ok(Spheres {
        positions: columns.positions,
        velocities: columns.velocities,
        spins: columns.spins,
        ..spheres
    })
}

/// The model of a case.
pub(crate) fn model(place: Place, law: Law, spheres: Spheres, count: usize) -> GrainModel {
    let (sin, cos) = ANGLE.to_radians().sin_cos();
    // The damping ratio of two equal spheres, and the restitution that belongs to it.
    let mass = PI / 12.0;
    let ratio = 0.5 * DAMPING / (STIFFNESS / mass).sqrt();
    let restitution = (-2.0 * ratio * ratio.acos() / (1.0 - ratio * ratio).sqrt()).exp();
    let scale = stretch(place, count);
    let floor = Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0);
    GrainModel {
        spheres,
        walls: if place == Place::Chute { Vec::new() } else { vec![floor, tube(scale)] },
        materials: vec![GrainMaterial { density: 1.0, youngs_modulus: YOUNG, poissons_ratio: POISSON }],
        surfaces: vec![Surfaces { restitution, friction: FRICTION, ..Surfaces::smooth([0, 0]) }],
        law: match law {
            Law::Hooke => ForceLaw::Hooke { normal: STIFFNESS, tangential: TANGENTIAL },
            Law::Hertz => ForceLaw::HertzMindlin,
        },
        gravity: if place == Place::Chute { [sin, 0.0, -cos] } else { [0.0, 0.0, -1.0] },
        domain: (place == Place::Chute).then(|| chute(scale)),
        step: Some(STEP),
        ..GrainModel::default()
    }
}

/// Factor of the extents across the height, so that the height is the same for all numbers of spheres.
pub(crate) fn stretch(place: Place, count: usize) -> f64 {
    (count as f64 / place.usual() as f64).sqrt()
}

/// The box of the chute.
fn chute(scale: f64) -> Domain {
    Domain {
        low: [0.0, 0.0, -1.0],
        high: [scale * CHUTE[0], scale * CHUTE[1], 4.0 * CHUTE[2]],
        periodic: [true, true, false],
        strain_rates: [0.0; 3],
        strain_from: 0.0,
        servo: None,
        outside: Outside::Stop,
    }
}

fn tube(scale: f64) -> Wall {
    Wall {
        shape: WallShape::Tube { axis: [[0.0; 3], [0.0, 0.0, 1.0]], radius: scale * TUBE[0] },
        ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)
    }
}

/// Spheres at random places that overlap, without weight, below a lid: they push each other apart.
fn filled(place: Place, count: usize) -> GrainModel {
    let scale = stretch(place, count);
    let mut random = Random(1);
    let (mut positions, mut radii) = (Vec::with_capacity(count), Vec::with_capacity(count));
    while positions.len() < count {
        let [x, y, z] = [random.next(), random.next(), random.next()];
        if place == Place::Chute {
            positions.push([scale * CHUTE[0] * x, scale * CHUTE[1] * y, CHUTE[2] * z]);
            radii.push(0.5);
            continue;
        }
        let at = [2.0 * x - 1.0, 2.0 * y - 1.0].map(|x| scale * TUBE[0] * x);
        if at[0].hypot(at[1]) < scale * TUBE[0] - 0.5 {
            positions.push([at[0], at[1], 0.5 + (TUBE[1] - 1.0) * z]);
            radii.push(0.45 + 0.1 * random.next());
        }
    }
    let height = if place == Place::Chute { CHUTE[2] } else { TUBE[1] };
    let mut model = model(place, Law::Hooke, Spheres { positions, radii, ..Spheres::default() }, count);
    if place == Place::Chute {
        model.walls.push(Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0));
    }
    model.walls.push(Wall::plane([0.0, 0.0, height], [0.0, 0.0, -1.0], 0));
    model.surfaces[0] = Surfaces { restitution: 0.05, ..Surfaces::smooth([0, 0]) };
    (model.gravity, model.step) = ([0.0; 3], Some(20.0 * STEP));
    model
}

/// Random numbers that are the same on every machine (`SplitMix64`).
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
