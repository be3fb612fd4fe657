//! Tests of the law of a joint.

use crate::cohesive::curve::{AREA, dissipated_at, softening};
use crate::cohesive::law::{JointLaw, JointPlane, TooLittle};
use crate::cohesive::memory::Memory;
use crate::model::{CriticalOpening, Strength};
use crate::random;
use crate::vector::unit;

pub(crate) const ROCK: Strength = Strength {
    tensile: 1e6,
    cohesion: 3e6,
    friction: 0.3,
    energy_i: 10.0,
    energy_ii: 50.0,
    weibull_modulus: None,
    seed: 0,
};

fn law(elastic: bool, opening: CriticalOpening) -> JointLaw {
    JointLaw::<2>::new(&ROCK, 1e13, opening, elastic, 1.0).expect("the energies are enough")
}

/// Work on a path of openings (`axis` 0) or slidings (`axis` 1), with the other component constant.
fn work(
    law: &JointLaw,
    memory: &mut Memory<2>,
    axis: usize,
    path: impl Iterator<Item = f64>,
    other: f64,
) -> f64 {
    let (mut sum, mut last) = (0.0, None);
    for value in path {
        let (opening, sliding) = if axis == 0 { (value, other) } else { (other, value) };
        let traction = memory.traction(law, [opening, sliding])[axis];
        if let Some((before, at)) = last {
            sum += 0.5 * (before + traction) * (value - at);
        }
        last = Some((traction, value));
    }
    sum
}

fn steps(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..=100_000).map(move |k| from + (to - from) * f64::from(k) / 100_000.0)
}

#[test]
fn the_curve_and_its_area() {
    assert!((softening(0.0) - 1.0).abs() < 1e-15);
    assert!((softening(0.1) - 0.878).abs() < 5e-4);
    assert!((softening(0.5) - 0.304).abs() < 5e-4);
    assert_eq!(softening(1.0), 0.0);
    let n = 1_000_000;
    let area: f64 = (0..n).map(|k| softening((f64::from(k) + 0.5) / f64::from(n)) / f64::from(n)).sum();
    assert!((area - AREA).abs() < 1e-12, "{area}");
    assert!((1..1000).all(|k| softening(f64::from(k) / 1000.0) < softening(f64::from(k - 1) / 1000.0)));
}

#[test]
fn opening_dissipates_the_fracture_energy() {
    for elastic in [true, false] {
        let law = law(elastic, CriticalOpening::Exact);
        let mut memory =
            if elastic { Memory::<2>::default() } else { Memory::under(&law, [law.tensile, 0.0]) };
        let dissipated = work(&law, &mut memory, 0, steps(0.0, 4e-5), 0.0);
        assert!((dissipated / ROCK.energy_i - 1.0).abs() < 1e-5, "{elastic} {dissipated}");
        assert_eq!(memory.damage(), 1.0);
    }
    let law = law(false, CriticalOpening::Customary);
    let mut memory = Memory::under(&law, [law.tensile, 0.0]);
    let dissipated = work(&law, &mut memory, 0, steps(0.0, 4e-5), 0.0);
    assert!((dissipated / ROCK.energy_i - 3.0 * AREA).abs() < 1e-5);
}

#[test]
fn sliding_peaks_at_cohesion_and_friction_and_ends_at_friction() {
    let law = law(true, CriticalOpening::Exact);
    let (pressure, mut memory) = (2e6, Memory::<2>::default());
    let closing = -pressure / law.penalty;
    let mut peak = 0.0_f64;
    for sliding in steps(0.0, 1e-4) {
        peak = peak.max(memory.traction(&law, [closing, sliding])[1]);
    }
    assert!((peak / (3e6 + 0.3 * pressure) - 1.0).abs() < 1e-3, "{peak}");
    let residual = memory.traction(&law, [closing, 1e-4])[1];
    assert!((residual / (0.3 * pressure) - 1.0).abs() < 1e-9, "{residual}");
    let mut memory = Memory::<2>::default();
    let all = work(&law, &mut memory, 1, steps(0.0, 1e-4), closing);
    // The work of friction and the energy stored at the end do not belong to the crack.
    let friction = 0.3 * pressure * (1e-4 - 0.5 * residual / law.penalty);
    assert!(((all - friction) / ROCK.energy_ii - 1.0).abs() < 5e-3, "{}", all - friction);
}

/// Work of a path of vectors of opening and sliding, J/m².
fn work_along(law: &JointLaw, memory: &mut Memory<2>, path: impl Iterator<Item = [f64; 2]>) -> f64 {
    let (mut sum, mut last) = (0.0, None::<([f64; 2], [f64; 2])>);
    for at in path {
        let traction = memory.traction(law, at);
        if let Some((before, from)) = last {
            sum += (0..2).map(|k| 0.5 * (before[k] + traction[k]) * (at[k] - from[k])).sum::<f64>();
        }
        last = Some((traction, at));
    }
    sum
}

/// A joint aslant to a crack that opens straight dissipates the energy of its area across the opening. In
/// every direction the strength is on the ellipse.
#[test]
fn a_vector_aslant_dissipates_the_energy_of_the_area_across_it() {
    let law = law(false, CriticalOpening::Exact);
    for degrees in [0.0_f64, 20.0, 40.0, 80.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let mut memory = Memory::<2>::default();
        let (mut peak, mut all) = (0.0_f64, Vec::new());
        for size in steps(0.0, 6e-5) {
            let [normal, tangential] = memory.traction(&law, [size * cos, size * sin]);
            peak = peak.max((normal / ROCK.tensile).hypot(tangential / ROCK.cohesion));
            all.push([normal, tangential]);
        }
        assert!((peak - 1.0).abs() < 1e-2, "{degrees} {peak}");
        assert!(all.iter().all(|[normal, tangential]| (normal * sin - tangential * cos).abs() < 1e-6));
        let path = steps(0.0, 6e-5).map(|size| [size * cos, size * sin]);
        let dissipated = work_along(&law, &mut Memory::<2>::default(), path);
        let expected = ROCK.energy_i * cos + ROCK.energy_ii * sin.powi(8);
        assert!((dissipated / expected - 1.0).abs() < 1e-2, "{degrees} {dissipated} {expected}");
        assert_eq!(memory.damage(), 1.0);
    }
}

/// A joint that represents a plane at 60° to it is loaded by a tension across that plane. It has the
/// strength of its projection and takes the energy of that, and the whole of its damage is by opening,
/// although its own sides slide more than they open.
#[test]
fn a_joint_of_a_plane_at_an_angle_has_the_law_of_its_projection() {
    let (sin, cos) = 60.0_f64.to_radians().sin_cos();
    let plane = JointPlane { excess: 1.0 / cos, area: cos, normal: [cos, sin] };
    let law = law(false, CriticalOpening::Exact).on(plane);
    let traction = [cos, sin].map(|part| cos * ROCK.tensile * part);
    let mut memory = Memory::under(&law, traction);
    let found = memory.traction(&law, [0.0; 2]);
    assert!((0..2).all(|axis| (found[axis] - traction[axis]).abs() < 1.0), "{found:?}");
    let path = steps(0.0, 6e-5).map(|size| [size * cos, size * sin]);
    let dissipated = work_along(&law, &mut memory, path);
    assert!((dissipated / (ROCK.energy_i * cos) - 1.0).abs() < 1e-3, "{dissipated}");
    let [opening, sliding] = memory.damages;
    assert!(memory.damage() == 1.0 && sliding < 1e-9 * opening, "{:?}", memory.damages);
}

/// Sliding under pressure, a whole joint of a plane at an angle holds at least its friction beside its
/// bond, and softens only beyond.
#[test]
fn pressure_adds_friction_to_a_joint_of_any_plane() {
    let (sin, cos) = 50.0_f64.to_radians().sin_cos();
    let plane = JointPlane { excess: 1.0 / cos, area: cos, normal: [cos, sin] };
    let law = law(false, CriticalOpening::Exact).on(plane);
    let (pressure, mut memory) = (2e6, Memory::<2>::default());
    let [strength, _] = law.in_direction([sin * sin, cos * cos]);
    let mut peak = 0.0_f64;
    for sliding in steps(0.0, 1e-6) {
        peak = peak.max(memory.traction(&law, [-pressure / law.penalty, sliding])[1]);
    }
    assert!((peak / (strength + 0.3 * pressure) - 1.0).abs() < 1e-3, "{peak} {strength}");
    assert!(memory.damage() > 0.0);
}

/// No path gives energy back that was not put in: the work on any path from the origin and back to no
/// traction is not negative.
#[test]
fn no_path_creates_energy() {
    for (seed, elastic) in (0..200).map(|k| (k, k % 2 == 0)) {
        let law = law(elastic, CriticalOpening::Exact);
        let (sin, cos) = (1.3 * crate::random::uniform(seed, 5000)).sin_cos();
        let aslant = JointPlane { excess: 1.0 / cos, area: cos, normal: [cos, sin] };
        let law = if seed % 3 == 0 { law.on(aslant) } else { law };
        let mut memory = Memory::<2>::default();
        let random = |k: u64| 2.0 * crate::random::uniform(seed, k) - 1.0;
        // From point to point, small and large, opening, closing and sliding both ways.
        let corners: Vec<[f64; 2]> = (0..60)
            .map(|k| {
                let size = 1e-5 * (0.5 + 0.5 * random(1000 + k)).powi(4);
                [size * random(2 * k).max(-0.01), size * random(2 * k + 1)]
            })
            .collect();
        let (mut sum, mut least) = (0.0, 0.0_f64);
        let mut from = [0.0; 2];
        for to in corners {
            let part = (0..=2000).map(|k| {
                let t = f64::from(k) / 2000.0;
                [0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis]))
            });
            sum += work_along(&law, &mut memory, part);
            least = least.min(sum);
            from = to;
        }
        assert!(least > -1e-6 * ROCK.energy_i, "{seed} {least}");
        assert!(sum > 0.0);
    }
}

/// A joint that closed again keeps its cohesion, and the crack faces rub beside it.
#[test]
fn friction_acts_beside_what_is_left_of_the_bond() {
    let law = law(false, CriticalOpening::Exact);
    let mut memory = Memory::<2>::default();
    let far = law.tensile / law.penalty + 0.3 * law.critical[0];
    memory.traction(&law, [far, 0.0]);
    let left = softening(memory.damage());
    let (mut peak, closing) = (0.0_f64, -1e6 / law.penalty);
    for sliding in steps(0.0, 1e-4) {
        peak = peak.max(memory.traction(&law, [closing, sliding])[1]);
    }
    let bond = peak - 0.3e6;
    assert!(bond > 0.5 * left * law.cohesion && bond < left * law.cohesion, "{bond} {left}");
    assert_eq!(memory.damage(), 1.0);
    let residual = memory.traction(&law, [closing, 1e-4])[1];
    assert!((residual / 0.3e6 - 1.0).abs() < 1e-9, "{residual}");
}

#[test]
fn the_dissipated_share_is_the_work_of_a_bond_that_opens_and_closes() {
    let law = law(false, CriticalOpening::Exact);
    let stored = 0.5 * law.tensile * law.tensile / law.penalty;
    for share in [0.05, 0.3, 0.7, 1.0] {
        let far = law.tensile / law.penalty + share * law.critical[0];
        let path = steps(0.0, far).chain(steps(far, 0.0)).map(|opening| [opening, 0.0]);
        let mut memory = Memory::<2>::default();
        let lost = work_along(&law, &mut memory, path);
        // Beside the work up to the strength, of which the bond gives back a share.
        let lost = lost - stored * (1.0 - softening(memory.damage()));
        let found = dissipated_at(memory.damage());
        assert!((lost / ROCK.energy_i - found).abs() < 1e-4, "{share}: {lost} {found}");
    }
    assert_eq!([0.0, 1.0].map(dissipated_at), [0.0, 1.0]);
}

#[test]
fn unloading_goes_to_the_origin_and_back() {
    let law = law(true, CriticalOpening::Exact);
    let mut memory = Memory::<2>::default();
    let far = law.tensile / law.penalty + 0.3 * law.critical[0];
    let at_far = memory.traction(&law, [far, 0.0])[0];
    let damage = memory.damage();
    assert!((memory.traction(&law, [far / 2.0, 0.0])[0] / at_far - 0.5).abs() < 1e-12);
    assert_eq!(memory.traction(&law, [0.0, 0.0])[0], 0.0);
    assert_eq!(memory.traction(&law, [-1e-7, 0.0])[0], -1e-7 * law.penalty);
    assert_eq!(memory.traction(&law, [far, 0.0])[0], at_far);
    assert_eq!(memory.damage(), damage);
}

#[test]
fn a_joint_put_in_under_load_begins_with_that_load() {
    let law = law(false, CriticalOpening::Exact);
    for traction in [[1e6, 0.0], [-4e6, 4.2e6], [0.5e6, -2.5e6]] {
        let found = Memory::under(&law, traction).traction(&law, [0.0, 0.0]);
        for axis in 0..2 {
            assert!((found[axis] - traction[axis]).abs() < 1.0, "{traction:?} {found:?}");
        }
    }
}

#[test]
fn an_open_joint_has_friction_and_nothing_else() {
    let open = Strength { tensile: 0.0, cohesion: 0.0, energy_i: 0.0, energy_ii: 0.0, ..ROCK };
    let law = JointLaw::<2>::new(&open, 1e13, CriticalOpening::Exact, false, 0.1).expect("needs no energy");
    let mut memory = Memory::under(&law, [0.0; 2]);
    assert_eq!(memory.traction(&law, [1e-5, 1e-5]), [0.0; 2]);
    assert_eq!(memory.damage(), 1.0);
    let [pressure, shear] = memory.traction(&law, [-1e-6, 2e-5]);
    assert_eq!(pressure, -1e7);
    assert!((shear - 0.3e7).abs() < 1e-6, "{shear}");
}

/// A joint without tensile strength still has its cohesion, and the other way round. Breaking in one mode
/// breaks it in both.
#[test]
fn one_strength_may_be_zero() {
    let cohesive = Strength { tensile: 0.0, energy_i: 0.0, ..ROCK };
    let law =
        JointLaw::<2>::new(&cohesive, 1e13, CriticalOpening::Exact, false, 0.1).expect("needs no energy");
    let mut memory = Memory::under(&law, [0.0; 2]);
    assert_eq!(memory.traction(&law, [0.0, 2e-7]), [0.0, 2e6]);
    assert_eq!(memory.traction(&law, [1e-7, 2e-7])[0], 0.0);
    assert!(memory.damage() > 0.0);
    memory.traction(&law, [1e-3, 0.0]);
    assert_eq!(memory.damage(), 1.0);
    let tensile = Strength { cohesion: 0.0, energy_ii: 0.0, ..ROCK };
    let law = JointLaw::<2>::new(&tensile, 1e13, CriticalOpening::Exact, true, 0.1).expect("needs no energy");
    let mut memory = Memory::<2>::default();
    assert_eq!(memory.traction(&law, [0.5e-7, 0.0]), [0.5e6, 0.0]);
    assert_eq!(memory.traction(&law, [0.5e-7, 1e-8])[1], 0.0);
}

#[test]
fn too_little_fracture_energy_is_refused() {
    let brittle = Strength { energy_i: 0.04, ..ROCK };
    let refused = JointLaw::<2>::new(&brittle, 1e13, CriticalOpening::Exact, true, 1.0);
    assert_eq!(refused, Err(TooLittle { least: 0.05, sliding: false }));
    assert!(JointLaw::<2>::new(&brittle, 1e13, CriticalOpening::Exact, false, 1.0).is_ok());
    let brittle = Strength { energy_ii: 0.4, ..ROCK };
    let refused = JointLaw::<2>::new(&brittle, 1e13, CriticalOpening::Exact, true, 1.0);
    assert_eq!(refused, Err(TooLittle { least: 0.45, sliding: true }));
}

/// The mode without a strength has no energy, and is not the one to name.
#[test]
fn too_little_energy_is_that_of_the_mode_that_has_a_strength() {
    let of = |strength: Strength| JointLaw::<2>::new(&strength, 1e13, CriticalOpening::Exact, true, 1.0);
    let sliding = Strength { tensile: 0.0, energy_i: 0.0, energy_ii: 0.4, ..ROCK };
    assert_eq!(of(sliding), Err(TooLittle { least: 0.45, sliding: true }));
    let opening = Strength { cohesion: 0.0, energy_ii: 0.0, energy_i: 0.04, ..ROCK };
    assert_eq!(of(opening), Err(TooLittle { least: 0.05, sliding: false }));
}

/// A bond that is found to rest has the same history and traction as one that is loaded.
fn bond_that_rests<const D: usize>() {
    let mut count = 0;
    let mut next = || {
        count += 1;
        random::uniform(11, count)
    };
    let (mut resting, mut damaged, mut pure) = (0, 0, 0);
    for round in 0..400 {
        let ratio = 0.5 + 9.5 * next();
        let strength = Strength {
            cohesion: ratio * ROCK.tensile,
            energy_ii: ROCK.energy_i * (0.5 + 20.0 * next()),
            friction: next(),
            ..ROCK
        };
        let law = JointLaw::<D>::new(&strength, 1e13, CriticalOpening::Exact, false, 1.0);
        let mut law = law.expect("energies that are enough");
        // Half of the joints represent a plane at an angle.
        if round % 2 == 0 {
            let normal = unit(std::array::from_fn(|axis| if axis == 0 { 1.0 } else { next() - 0.5 }));
            law = law.on(JointPlane { normal, ..JointPlane::own() });
        }
        let (mut memory, mut left) = (Memory::<D>::default(), 0.0);
        let mut gap = [0.0; D];
        let mut goal = gap;
        for step in 0..400 {
            if step % 20 == 0 {
                // Sometimes in one mode only, and sometimes back to where it began.
                let mode = (5.0 * next()) as usize;
                let size = law.critical[0] * next() * next();
                goal = std::array::from_fn(|axis| match mode {
                    0 if axis > 0 => 0.0,
                    1 if axis != 1 => -0.1 * size,
                    2 => 0.0,
                    _ => size * (2.0 * next() - 0.7),
                });
            }
            gap = std::array::from_fn(|axis| gap[axis] + 0.1 * (goal[axis] - gap[axis]));
            let mut other = memory;
            let rests = memory.rests(&law, gap, left);
            if rests {
                resting += 1;
                let is_damaged = memory.stiffness < 1.0 && memory.stiffness > 0.0;
                damaged += u32::from(is_damaged);
                pure += u32::from(is_damaged && gap[1..] == [0.0; D][1..]);
                let traction = other.of_common(&law, gap, true, &mut left.clone());
                let whole = memory.of_common(&law, gap, false, &mut left.clone());
                assert_eq!(other, memory, "{law:?} at {gap:?}");
                assert_eq!(traction, whole, "{law:?} at {gap:?}");
            } else {
                memory.of_common(&law, gap, false, &mut left);
            }
            if left > 0.0 {
                assert_eq!(left, softening(memory.damage()));
            }
        }
    }
    assert!(resting > 40_000 && damaged > 20_000 && pure > 100, "{resting} {damaged} {pure}");
}

#[test]
fn bonds_that_rest_need_no_load() {
    bond_that_rests::<2>();
    bond_that_rests::<3>();
}
