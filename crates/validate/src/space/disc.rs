//! A thick disc under two opposite loads, as in the Brazilian test: the elastic stress in its middle.
//!
//! Two strips of the disc's surface, each seen from the axis under the angle `2 α`, carry the pressure `p`.
//! In plane stress the stress in the centre is `σ_x = 2 p/π (sin 2α - α)` across the loaded diameter and
//! `σ_y = -2 p/π (sin 2α + α)` along it (Hondros), which for narrow strips are `s = 2 P/(π D t)` and `-3 s`.
//!
//! A disc is not thin. The state of plane stress is exact in three dimensions, with faces that carry no
//! traction, if the stress varies through the thickness (Timoshenko and Goodier, 98): with `Θ = σ_x + σ_y`,
//! which is harmonic, and the place `z` from the middle, to `σ_x` is added
//!
//! ```text
//! - ν/(2 (1 + ν)) (z² - t²/12) ∂²Θ/∂y²,    and to σ_y the opposite, because ∂²Θ/∂x² = - ∂²Θ/∂y².
//! ```
//!
//! The mean over the thickness is that of the thin disc. Under the loads of a line, the sum of two radial
//! fields and an even tension, `Θ = 2 s - s D/2 (1/(R - y) + 1/(R + y))` on the loaded diameter, so that
//! `∂²Θ/∂y² = -32 s/D²` in the centre. With `sin 2α/(2 α)` for strips the tension across the diameter is
//! there
//!
//! ```text
//! σ_x/s = sin 2α/α - 1 + 16 ν/(1 + ν) (z² - t²/12)/D² sin 2α/(2 α):
//! ```
//!
//! for `t = D/2` and `ν = 1/4` it is 0.933 in the middle plane and 1.133 on the faces. Finite elements of
//! others gave `1 + 0.2621 t/D = 1.131` on the faces (Yu, Yin and Zhong, Int. J. Rock Mech. Min. Sci. 43
//! (2006) 623-627). The neglected part decays from the loads as `exp(-4.2 r/t)` and is a hundredth in the
//! centre.
//!
//! Near the axis of a thin disc `σ_x` falls by `4 (x/R)² s`, and by nothing along y.

use std::f64::consts::PI;

use fdem_simulation::{Load, Model, Schedule, TimeOptions};

use super::bodies::{Body, Point, advance, advance_to, centroid, cross, length, loaded, minus, start};
use crate::rocks::prepared_in_space;
use crate::{Outcome, Size};

/// Radius, thickness, m. The axis of the disc is y, and the load acts along z.
pub(super) const RADIUS: f64 = 0.025;
pub(super) const THICKNESS: f64 = 0.025;
const POISSON: f64 = 0.25;

/// The disc, of an unstructured mesh. `keys`: of the body and of the material, besides those that are always
/// there.
pub(super) fn disc(mesh_size: f64, keys: [&str; 2]) -> Result<Model<3, 4>, String> {
    let [body, rock] = keys;
    prepared_in_space(&format!(
        r#"
[model]
gravity = "none"
end_time = 1
[[body]]
name = "disc"
material = "rock"
cylinder = {{ from = [0, -{half}, 0], to = [0, {half}, 0], radius = {RADIUS} }}
mesh_size = {mesh_size}
{body}
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = {POISSON}
friction = 0.3
{rock}
"#,
        half = 0.5 * THICKNESS
    ))
}

/// Stress near the axis, in the middle plane and at the faces.
pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut model = disc(size.choose(4e-3, 2.5e-3), ["", "damping = 0.5"])?;
    let mesh = &model.mesh;
    // Strips of about 15 degrees. Their edges follow the mesh: the angle is that of their area.
    let strip = |sign: f64| -> Vec<[u32; 3]> {
        let on = |p: Point| p[0].hypot(p[2]) > RADIUS * (1.0 - 1e-6);
        super::bodies::faces_where(mesh, on)
            .into_iter()
            .filter(|face| {
                let [a, b, c] = face.map(|node| mesh.nodes[node as usize]);
                let middle: Point = std::array::from_fn(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
                sign * middle[2] > RADIUS * 0.97 * f64::cos(0.13)
            })
            .collect()
    };
    let strips = [strip(-1.0), strip(1.0)];
    let forces =
        strips.each_ref().map(|faces| faces.iter().map(|face| area(mesh, face)[2]).sum::<f64>().abs());
    let angles = strips.each_ref().map(|faces| {
        faces.iter().map(|face| length(area(mesh, face))).sum::<f64>() / (2.0 * RADIUS * THICKNESS)
    });
    let angle = 0.5 * (angles[0] + angles[1]);
    // Both strips press alike.
    let pressure = 1e6;
    let pressures = [pressure, pressure * forces[0] / forces[1]];
    let [lower, upper] = strips;
    let ramp = 1e-4;
    model.boundaries = vec![
        loaded("lower", lower, Load::Pressure(pressures[0]), Schedule::Ramp(ramp)),
        loaded("upper", upper, Load::Pressure(pressures[1]), Schedule::Ramp(ramp)),
    ];
    model.time = TimeOptions { local_damping: 0.4, ..TimeOptions::default() };
    let total = pressures[0] * forces[0];
    let mut run = start(model)?;
    let unit = total / (PI * RADIUS * THICKNESS);
    let (deviator, correction) = ((2.0 * angle).sin() / angle, 16.0 * POISSON / (1.0 + POISSON));
    let expected = |[x, y, z]: Point| {
        let place = (y * y - THICKNESS * THICKNESS / 12.0) / (4.0 * RADIUS * RADIUS);
        let across = deviator - 1.0 + 0.5 * deviator * correction * place - 4.0 * (x / RADIUS).powi(2);
        let along = -deviator - 1.0 - 0.5 * deviator * correction * place + 8.0 * (x / RADIUS).powi(2)
            - 4.0 * (z / RADIUS).powi(2);
        [across, along]
    };
    advance_to(&mut run, 3.0 * ramp)?;
    // Means over the swing that is left.
    let (samples, mesh) = (20, run.model().mesh.clone());
    let mut outcomes = Vec::new();
    let layers = [("in the middle plane", 0.0, 0.12), ("at the faces", 0.38, 0.5)];
    let mut found = [[0.0; 2]; 2];
    let mut wanted = [[0.0; 2]; 2];
    for sample in 0..samples {
        advance(&mut run, 25)?;
        let stresses = run.snapshot().stresses;
        for (layer, &(_, from, to)) in layers.iter().enumerate() {
            let (mut sums, mut whole) = ([[0.0; 2]; 2], 0.0);
            for (element, stress) in stresses.iter().enumerate() {
                let middle = centroid(&mesh, element);
                let depth = middle[1].abs() / THICKNESS;
                if middle[0].hypot(middle[2]) > 0.16 * RADIUS || depth < from || depth > to {
                    continue;
                }
                let size =
                    super::bodies::volume(mesh.elements[element].map(|node| mesh.nodes[node as usize]));
                let exact = expected(middle);
                whole += size;
                for (k, stress) in [stress[0], stress[2]].into_iter().enumerate() {
                    sums[0][k] += size * stress / unit;
                    sums[1][k] += size * exact[k];
                }
            }
            for k in 0..2 {
                found[layer][k] += sums[0][k] / whole / f64::from(samples);
                if sample == 0 {
                    wanted[layer][k] = sums[1][k] / whole;
                }
            }
        }
    }
    for (layer, (name, ..)) in layers.into_iter().enumerate() {
        for (k, direction) in ["across the diameter", "along it"].into_iter().enumerate() {
            outcomes.push(Outcome::relative(
                format!("elastic stress {direction} {name}, over 2 P/(π D t)"),
                wanted[layer][k],
                found[layer][k],
                size.choose(0.06, 0.03),
                "",
            ));
        }
    }
    Ok(outcomes)
}

/// Outward normal of a face, as long as its area.
fn area(mesh: &Body, face: &[u32; 3]) -> Point {
    let [a, b, c] = face.map(|node| mesh.nodes[node as usize]);
    cross(minus(b, a), minus(c, a)).map(|x| 0.5 * x)
}
