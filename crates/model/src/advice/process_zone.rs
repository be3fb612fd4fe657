//! Whether elements resolve the process zone of a crack, in tension and in shear.
//!
//! The zone in which a crack softens is about E' G/f² long, with the energy and the strength of its mode: the
//! tensile strength and `G_I`, or the cohesion and `G_II`. With fewer than three elements in it, or four in
//! space, the strength depends on the mesh: it is too high. Cracks in shear decide where something presses on
//! the rock.

use fdem_io::numbers::brief;
use fdem_mesh::{bounds, edges};
use fdem_simulation::{MaterialLaw, Model, Plane, Strength};

use crate::advice::deforming;
use crate::advice::pressing::presses;

/// Elements in the fracture process zone that are needed for an objective result, and their share of it in
/// words.
#[derive(Clone, Copy)]
struct InZone {
    count: f64,
    in_words: &'static str,
    share: &'static str,
}

/// In the plane (Guo, 2016).
const IN_PLANE: InZone = InZone { count: 3.0, in_words: "three", share: "a third" };

/// In space: the surface of a crack in tension has facets in all directions. With three elements K of free
/// cracks was up to 1.5 times that of a straight one, with four up to 1.11 times (`bench/NOTES.md`).
const IN_SPACE: InZone = InZone { count: 4.0, in_words: "four", share: "a quarter" };

/// A tenth more than this share of the zone is the scatter of a mesh whose size is the limit.
const SCATTER: f64 = 1.1;

/// Largest ratio of the time of a run with the finer elements that are proposed to that with the present
/// ones.
const LONGEST: f64 = 1000.0;

/// Size of the elements over that which the zone needs, from which a number of the material is wrong.
const FAR: f64 = 1e6;

/// Elements, as a share of all, that may be larger than this share of the zone.
const FEW: f64 = 0.05;

/// A mode of failure.
struct Mode {
    /// Words between the zone and its length.
    place: &'static str,
    formula: &'static str,
    /// Key of the fracture energy.
    key: &'static str,
    energy: fn(&Strength) -> f64,
    strength: fn(&Strength) -> f64,
    result: &'static str,
    /// Whether its cracks open.
    opens: bool,
}

const TENSION: Mode = Mode {
    place: "",
    formula: "E' G/f²",
    key: "fracture_energy_i",
    energy: |strength| strength.energy_i,
    strength: |strength| strength.tensile,
    result: "strength",
    opens: true,
};

const SHEAR: Mode = Mode {
    place: " in shear",
    formula: "E' G_II/c²",
    key: "fracture_energy_ii",
    energy: |strength| strength.energy_ii,
    strength: |strength| strength.cohesion,
    result: "strength in compression",
    opens: false,
};

/// Adds a warning for each material and mode whose elements are too large for the zone.
pub(crate) fn warnings<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>) {
    // Mean edge of each element, m.
    let mut of_materials = vec![Vec::new(); model.materials.len()];
    for element in deforming::elements(model) {
        let nodes = model.mesh.elements[element as usize];
        let edges = edges(&nodes.map(|node| model.mesh.nodes[node as usize]));
        let material = model.mesh.materials[element as usize];
        of_materials[material as usize].push(edges.iter().sum::<f64>() / edges.len() as f64);
    }
    let is_loaded = model.boundaries.iter().any(|boundary| presses(boundary, model));
    for (material, mut edges) in of_materials.into_iter().enumerate() {
        edges.sort_by(f64::total_cmp);
        warnings.extend(warning(model, material, &edges, &TENSION));
        if is_loaded || is_pressed(model, material) {
            warnings.extend(warning(model, material, &edges, &SHEAR));
        }
    }
}

/// E' of a material, Pa.
pub(crate) fn plane_modulus<const D: usize, const N: usize>(model: &Model<D, N>, material: usize) -> f64 {
    let material = &model.materials[material];
    match model.plane {
        Plane::Stress if D == 2 => material.youngs_modulus,
        _ => material.youngs_modulus / (1.0 - material.poissons_ratio.powi(2)),
    }
}

/// Length of the zone of a material, m, and its fracture energy, J/m². `None` if the material has no strength
/// in this mode.
fn zone<const D: usize, const N: usize>(
    model: &Model<D, N>,
    material: usize,
    mode: &Mode,
) -> Option<[f64; 2]> {
    let of = |modulus: f64, strength: &Strength| {
        let [energy, strength] = [(mode.energy)(strength), (mode.strength)(strength)];
        (strength > 0.0).then(|| [modulus * energy / (strength * strength), energy])
    };
    let strength = model.materials[material].strength?;
    let whole = of(plane_modulus(model, material), &strength);
    // A crack along the bedding opens against the stiffness across it.
    let on_bedding = match &model.materials[material].law {
        MaterialLaw::TransverselyIsotropic(bedding) => {
            of(bedding.youngs_modulus, &bedding.strength.unwrap_or(strength))
        }
        _ => None,
    };
    whole.into_iter().chain(on_bedding).min_by(|one, other| one[0].total_cmp(&other[0]))
}

/// The warning of a material and a mode. `sorted`: mean edges of its elements, m, ascending.
fn warning<const D: usize, const N: usize>(
    model: &Model<D, N>,
    material: usize,
    sorted: &[f64],
    mode: &Mode,
) -> Option<String> {
    let [zone, energy] = zone(model, material, mode)?;
    let needed = if D == 3 && mode.opens { IN_SPACE } else { IN_PLANE };
    let most = zone / needed.count;
    let large = sorted.len() - sorted.partition_point(|mean| *mean <= SCATTER * most);
    if large as f64 <= FEW * sorted.len() as f64 {
        return None;
    }
    let longest = *sorted.last()?;
    // The size, without the scatter, of the elements that are too large.
    let usual = sorted[((1.0 - FEW) * sorted.len() as f64) as usize] / SCATTER;
    // The number of elements grows with the power D of the ratio of sizes, that of steps with the ratio.
    let longer = (usual / most).powi(if D == 2 { 3 } else { 4 });
    let remedy = if longer <= LONGEST {
        format!("take elements of {} m", brief(most))
    } else if usual > FAR * most {
        format!("see that the strengths, {} and the modulus are in the right units", mode.key)
    } else {
        let factor = (100.0 * usual / most).ceil() / 100.0;
        format!(
            "elements of {} m would make the run some {longer:.0e} times as long, so multiply {} by {factor:.2} (to {} J/m²), with which the zone has {} elements, \
             or read the {} of the run as an upper bound",
            brief(most),
            mode.key,
            brief((factor * energy * 1e3).round() / 1e3),
            needed.in_words,
            mode.result
        )
    };
    Some(format!(
        "{large} of {} elements of \"{}\" are larger than {} of its fracture process zone{} ({} = {} m; the largest has a mean edge of {} m): \
         {} will depend on the mesh; {remedy}",
        sorted.len(),
        model.materials[material].name,
        needed.share,
        mode.place,
        mode.formula,
        brief(zone),
        brief(longest),
        mode.result,
    ))
}

/// Whether a material may fail under the stress in the ground or under weight, which are not small beside its
/// cohesion.
fn is_pressed<const D: usize, const N: usize>(model: &Model<D, N>, material: usize) -> bool {
    let Some(strength) = model.materials[material].strength else { return false };
    // A compression of this size crushes the wall of a hole.
    let least = strength.cohesion;
    let [low, high] = bounds(model.mesh.nodes.iter().copied());
    let weight: f64 = (0..D)
        .map(|axis| model.materials[material].density * model.gravity[axis].abs() * (high[axis] - low[axis]))
        .sum();
    let in_ground = model.stresses.iter().any(|stress| (0..D).any(|axis| stress[axis][axis] < -least));
    in_ground || weight > least
}
