//! Blocks of rock near their strength and beyond, whose facets have scattered strengths.

use fdem_mesh::{Corners, sorted_facets};
use fdem_simulation::{Boundary, Element, Insertion, JointSet, Load, Mesh, Model, Schedule, Target};

use super::parts::of_rock;

/// Weibull modulus of the strengths. With more scatter the weakest facets would be far beyond their strength
/// at the beginning, and their joints would begin with a jump.
const WEIBULL: f64 = 20.0;

/// Rate at which a block that breaks expands, 1/s.
const EXPANSION: f64 = 50.0;

/// The state of a block near its strength, or beyond it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Failing {
    /// Compressed along its last axis at 0.9 of the load at which it would break: with scattered strengths
    /// that is 0.84 of the mean strength. A few facets have joints. It rings at up to [`RINGING`].
    Near,
    /// Drawn on all sides at 0.92 of the mean tensile strength, which is above that of a tenth of its facets.
    /// All facets have joints.
    Softening,
    /// Drawn on all sides at half of its tensile strength, and expanding, so that it comes to pieces.
    Breaking,
    /// Broken on all facets, its pieces flying at up to [`BLAST`] in waves, against each other and apart.
    Blown,
}

/// Speed of the pieces of a block after a blast, and of a block near its strength, m/s.
const BLAST: f64 = 10.0;
const RINGING: f64 = 0.01;

impl Failing {
    /// A block of this mesh, whose outer nodes are held or expand with it.
    pub(super) fn model<const D: usize, const N: usize>(self, mesh: Mesh<D, N>) -> Model<D, N>
    where
        [[f64; D]; N]: Element<D, N> + Corners<D, N>,
    {
        let insertion = if self == Self::Softening { Insertion::Intrinsic } else { Insertion::Adaptive };
        let ends: [[f64; 2]; D] = std::array::from_fn(|axis| {
            let along = mesh.nodes.iter().map(|node| node[axis]);
            [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
        });
        let rate = if self == Self::Breaking { EXPANSION } else { 0.0 };
        let ringing = match self {
            Self::Near => RINGING,
            Self::Blown => BLAST,
            Self::Softening | Self::Breaking => 0.0,
        };
        let speed = |node: &[f64; D]| -> [f64; D] {
            let waves = [300.0, 200.0, 250.0];
            std::array::from_fn(|axis| {
                ringing * (waves[axis] * node[axis]).sin()
                    + rate * (node[axis] - 0.5 * (ends[axis][0] + ends[axis][1]))
            })
        };
        let velocities = mesh.nodes.iter().map(speed).collect();
        let mut boundaries = Vec::new();
        for (axis, ends) in ends.iter().enumerate() {
            for end in ends {
                let nodes = (0..).zip(&mesh.nodes).filter(|(_, node)| node[axis] == *end);
                let mut velocity = [None; D];
                velocity[axis] = Some(rate * (end - 0.5 * (ends[0] + ends[1])));
                boundaries.push(Boundary {
                    name: format!("side at {end} along axis {axis}"),
                    target: Target::Nodes(nodes.map(|(number, _)| number).collect()),
                    load: Load::Velocity(velocity),
                    schedule: Schedule::Constant,
                });
            }
        }
        let mut model = Model { boundaries, ..of_rock(mesh, velocities, true, insertion) };
        let mut stress = [[0.0; D]; D];
        for strength in model.materials.iter_mut().filter_map(|material| material.strength.as_mut()) {
            strength.weibull_modulus = Some(WEIBULL);
            match self {
                Self::Near => {
                    // Mohr and Coulomb: 2 c cos φ / (1 - sin φ).
                    let angle = strength.friction.atan();
                    stress[D - 1][D - 1] =
                        -0.84 * 2.0 * strength.cohesion * angle.cos() / (1.0 - angle.sin());
                }
                Self::Softening | Self::Breaking => {
                    let share = if self == Self::Softening { 0.92 } else { 0.5 };
                    (0..D).for_each(|axis| stress[axis][axis] = share * strength.tensile);
                }
                Self::Blown => {}
            }
        }
        if self == Self::Blown {
            break_all(&mut model);
            return model;
        }
        model.stresses = vec![stress; model.mesh.elements.len()];
        model
    }
}

/// Puts an open joint on each facet between two elements.
fn break_all<const D: usize, const N: usize>(model: &mut Model<D, N>)
where
    [[f64; D]; N]: Element<D, N> + Corners<D, N>,
{
    let Some(strength) = model.materials.iter_mut().find_map(|material| material.strength.take()) else {
        return;
    };
    model.joint_sets = vec![JointSet {
        name: "pieces".to_owned(),
        strength,
        residual_friction: strength.friction,
        normal_stiffness: None,
        shear_stiffness: None,
        dilation: 0.0,
        dilation_slip: None,
        open: true,
    }];
    let facets: Vec<[u32; D]> =
        sorted_facets(&model.mesh.elements).into_iter().map(|(facet, _)| facet).collect();
    model.add_joints(0, &facets);
}
