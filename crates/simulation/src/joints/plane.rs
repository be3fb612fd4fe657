//! Tractions on edges and on planes near them, and the plane that a joint represents.
//!
//! Material fails on the plane that its stress uses most. An unstructured mesh has edges near that plane, not
//! on it. An edge that had to reach the strength by its own traction would fail later than the material: a
//! tension by 1/cos² of the angle between the two, a compression by more, because facets aslant to a shear
//! plane interlock. Therefore an edge fails as soon as a plane within [`REACH`] of it does, and its joint
//! represents that plane: it begins with the acting traction, which is then its strength, and its fracture
//! energy is that of its projection on the plane.
//!
//! In space a crack is a staircase of faces at any angle to its plane, because the four faces of a
//! tetrahedron seldom lie near it. The traction on such a face is along the tension, aslant to the face. A
//! law that took the part along the face for sliding would give it the energy of sliding, up to `G_II`:
//! cracks in free meshes dissipated 1.4 to 2.8 times the energy of a straight one. So where tension governs,
//! the mode is measured from the normal of the plane across the largest tension, whatever its angle to the
//! face.

use crate::cohesive::{JointPlane, across, use_of};
use crate::model::Strength;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::Facet;
use crate::vector::{Matrix, Point, matrix};

/// Largest angle between an edge and the plane that its joint represents. Six edges meet at a vertex on
/// average, so the nearest one is 15° off on average, and at most 30°. With a larger reach edges fail that
/// the crack does not take; `bench/NOTES.md` has the table.
pub(super) const REACH: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Least area of the projection of a facet on the plane across the largest tension, over its own. A facet
/// along the tension has this share, because without any strength it would slide freely beside the crack.
const LEAST_AREA: f64 = 0.25;

/// A reach that no plane is beyond.
const ANY: f64 = std::f64::consts::FRAC_PI_2;

/// Largest ratio of the uses of the strength on the plane and on the edge.
const MOST: f64 = 2.0;

/// The plane within reach of a facet on which a stress, Pa, uses the strength most.
pub(crate) fn plane_near<const D: usize, const N: usize>(
    facet: &[Point<D>; D],
    stress: &Matrix<D>,
    strength: &Strength,
) -> JointPlane<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let own = use_of(strength, <[[f64; D]; N]>::traction_on(facet, stress));
    let mut best = (own, 1.0);
    for (traction, cos) in <[[f64; D]; N]>::tractions_near(facet, stress, strength.friction, REACH) {
        let used = use_of(strength, traction);
        if used > best.0 {
            best = (used, cos);
        }
    }
    let (used, area) = best;
    let excess = if used < MOST * own { used / own } else { MOST };
    // No strength, or no stress.
    if used > own && used.is_finite() {
        JointPlane { excess, area, normal: across() }
    } else {
        JointPlane::own()
    }
}

/// The plane that a joint represents which is inserted on a facet under this stress, Pa: that across the
/// largest tension where tension governs, for facets of a staircase; else that of [`plane_near`].
///
/// Such a joint has the strength and the energy of its projection on the plane. If the stress is beyond the
/// strength already, it begins with the stress, so that no force jumps, and softens faster.
pub(crate) fn plane_of<const D: usize, const N: usize>(
    facet: &[Point<D>; D],
    stress: &Matrix<D>,
    strength: &Strength,
) -> JointPlane<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let own = || plane_near::<D, N>(facet, stress, strength);
    let Some((tension, normal)) = <[[f64; D]; N]>::tension_across(facet, stress) else { return own() };
    let (used, area) = (tension / strength.tensile, normal[0].max(LEAST_AREA));
    let shear = <[[f64; D]; N]>::tractions_near(facet, stress, strength.friction, ANY);
    let governs = shear[1..].iter().all(|(traction, _)| use_of(strength, *traction) <= used);
    if !(governs && used > 0.0 && used.is_finite()) {
        return own();
    }
    JointPlane { excess: 1.0 / (area * used.max(1.0)), area, normal }
}

/// Whether a use of the strength of an edge breaks it or a plane near it. `excess`: use of the strength on
/// that plane over that on the edge; it is computed only if it can decide. `most`: a number that it does not
/// exceed.
pub(crate) fn breaks(used: f64, most: impl FnOnce() -> f64, excess: impl FnOnce() -> f64) -> bool {
    used >= 1.0 || (MOST * used >= 1.0 && used * most() >= 1.0 && used * excess() >= 1.0)
}

/// Traction across a facet, tension positive, and along it, Pa, from the mean stress of its two elements.
pub(crate) fn traction<const D: usize, const N: usize>(solid: &Solid<D, N>, facet: &Facet<D>) -> [f64; D]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    <[[f64; D]; N]>::traction_on(&side(solid, facet), &mean_stress(solid, facet))
}

/// Mean stress of the two elements at a facet, Pa.
pub(crate) fn mean_stress<const D: usize, const N: usize>(solid: &Solid<D, N>, facet: &Facet<D>) -> Matrix<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    mean_stress_of(solid, facet.elements())
}

/// Mean stress of two elements, Pa.
pub(crate) fn mean_stress_of<const D: usize, const N: usize>(
    solid: &Solid<D, N>,
    elements: [u32; 2],
) -> Matrix<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let [one, two] = elements.map(|element| solid.stress(element as usize));
    matrix(|i, k| 0.5 * (one[i][k] + two[i][k]))
}

/// Present positions of a facet on its side 0, m.
pub(crate) fn side<const D: usize, const N: usize>(solid: &Solid<D, N>, facet: &Facet<D>) -> [Point<D>; D]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    facet.corners[0].map(|corner| solid.position_at(corner))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cohesive::tests::ROCK;

    fn edge(degrees: f64) -> [Point; 2] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [[0.0; 2], [2.0 * cos, 2.0 * sin]]
    }

    fn plane_near(edge: [Point; 2], stress: Matrix, strength: &Strength) -> JointPlane {
        super::plane_near::<2, 3>(&edge, &stress, strength)
    }

    fn traction_on(stress: Matrix, edge: [Point; 2]) -> [f64; 2] {
        <[[f64; 2]; 3]>::traction_on(&edge, &stress)
    }

    /// Under tension along y, edges along x and up to the reach beside it fail together; farther ones later.
    #[test]
    fn edges_near_the_plane_of_tension_fail_with_it() {
        let stress = [[0.0, 0.0], [0.0, 1e6]];
        for (degrees, expected) in [(0.0, 1.0), (7.0, 1.0), (-14.0, 1.0), (30.0, 0.95), (-45.0, 0.78)] {
            let plane = plane_near(edge(degrees), stress, &ROCK);
            let used = use_of(&ROCK, traction_on(stress, edge(degrees))) * plane.excess;
            assert!((used - expected).abs() < 0.04, "{degrees} {used}");
            assert!((plane.area - degrees.abs().min(15.0).to_radians().cos()).abs() < 1e-9, "{degrees}");
        }
    }

    /// In compression, edges near the plane of Mohr and Coulomb fail under its strength, 2 c cos φ/(1 - sin
    /// φ).
    #[test]
    fn edges_near_the_plane_of_shear_fail_with_it() {
        let angle = ROCK.friction.atan();
        let stress = [[0.0, 0.0], [0.0, -2.0 * ROCK.cohesion * angle.cos() / (1.0 - angle.sin())]];
        let steepest = 45.0 + 0.5 * angle.to_degrees();
        for off in [0.0, 10.0, -14.0] {
            for degrees in [steepest + off, -steepest - off] {
                let plane = plane_near(edge(degrees), stress, &ROCK);
                let used = use_of(&ROCK, traction_on(stress, edge(degrees))) * plane.excess;
                assert!((used - 1.0).abs() < 1e-9, "{degrees} {used}");
            }
        }
        let across = plane_near(edge(0.0), stress, &ROCK);
        assert!(use_of(&ROCK, traction_on(stress, edge(0.0))) * across.excess < 0.5);
    }

    #[test]
    fn without_stress_or_strength_a_joint_stands_for_itself() {
        assert_eq!(plane_near(edge(20.0), [[0.0; 2]; 2], &ROCK), JointPlane::own());
        let open = Strength { tensile: 0.0, cohesion: 0.0, ..ROCK };
        assert_eq!(plane_near(edge(20.0), [[1e6, 3e5], [3e5, -1e6]], &open), JointPlane::own());
    }

    /// A face with the normal at this angle to z, of unit size.
    fn face(degrees: f64) -> [Point<3>; 3] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (along, across) = ([cos, 0.0, -sin], [0.0, 1.0, 0.0]);
        [[0.0; 3], along, across]
    }

    fn plane_of(degrees: f64, stress: [f64; 3]) -> JointPlane<3> {
        let stress = matrix::<3>(|i, k| if i == k { stress[i] } else { 0.0 });
        super::plane_of::<3, 4>(&face(degrees), &stress, &ROCK)
    }

    /// Under tension a face represents the plane across it, with the strength of its projection; beyond its
    /// strength it begins with the traction that acts. A face along the tension has the least projection.
    #[test]
    fn a_face_at_an_angle_represents_the_plane_across_the_tension() {
        for (degrees, tension) in [(0.0_f64, 1e6), (40.0, 0.5e6), (70.0, 1e6), (70.0, 1.5e6), (-60.0, 2e6)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let JointPlane { excess, area, normal } = plane_of(degrees, [0.0, 0.0, tension]);
            assert!((area - cos).abs() < 1e-9, "{degrees} {area}");
            let used = (tension / ROCK.tensile).max(1.0);
            assert!((excess * cos * used - 1.0).abs() < 1e-9, "{degrees} {excess}");
            let along = normal[1].hypot(normal[2]);
            assert!(
                (normal[0] - cos).abs() < 1e-9 && (along - sin.abs()).abs() < 1e-9,
                "{degrees} {normal:?}"
            );
        }
        let steep = plane_of(85.0, [0.0, 0.0, 1e6]);
        assert_eq!((steep.area, steep.excess), (LEAST_AREA, 1.0 / LEAST_AREA));
        assert!((steep.normal[0] - 85.0_f64.to_radians().cos()).abs() < 1e-9);
    }

    /// Where shear governs, the mode is measured from the normal of the face, as in compression with a small
    /// tension aside.
    #[test]
    fn a_face_under_compression_keeps_its_normal() {
        for stress in [[0.0, 0.0, -9e6], [1e5, 0.0, -9e6]] {
            for degrees in [20.0, 60.0, 85.0] {
                assert_eq!(plane_of(degrees, stress).normal, across(), "{degrees} {stress:?}");
            }
        }
    }
}
