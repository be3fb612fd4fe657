//! Hertz contact: half a disc pressed on a rigid plane.
//!
//! By symmetry the half below the horizontal diameter is a disc between two planes. With P the load per
//! length, E* = E/(1 − ν²) and R the radius, the half-width of the contact is a = √(4 P R/(π E*)), the
//! greatest pressure √(P E*/(π R)), and the approach of the diameter to the plane (Johnson, 5.6)
//!
//! ```text
//! δ = P/(π E*) (2 ln(4 R/a) − 1).
//! ```
//!
//! The mesh is half a disc about 0, of rings that grow with their radius, mapped by w = i R (z − i)/(z + i):
//! conformal, it keeps the shape of small elements, it takes the straight side of the half disc to the lower
//! half of the circle with 0 at its lowest point, and the half circle to the diameter.

use std::f64::consts::PI;

use fdem_simulation::{
    Boundary, ContactOptions, CriticalStep, Load, Material, Mesh, Model, Plane, Schedule, Simulation, Target,
    TimeOptions,
};

use super::models::{advance, force, granite, moved, nodes_where, one_body, rectangle, start, together};
use super::{Outcome, Size};

/// Radius of the disc, m.
const RADIUS: f64 = 0.1;

/// Approximate half-width of the contact at the end over the radius. The largest strains are a quarter of
/// this.
const WIDTH: f64 = 0.02;

const POISSON: f64 = 0.25;

/// Shares of the final approach at which the load is compared.
const LEVELS: [f64; 3] = [0.3, 0.6, 1.0];

/// Penalty of the contact. It is stiff, because the theory knows no compliance of the contact itself.
const PENALTY: f64 = 10.0;

/// Plane strain modulus E/(1 − ν²), Pa.
fn modulus() -> f64 {
    granite().youngs_modulus / (1.0 - POISSON * POISSON)
}

/// Half-width of the contact, m, under a load in N/m.
fn half_width(load: f64) -> f64 {
    (4.0 * load * RADIUS / (PI * modulus())).sqrt()
}

/// Approach, m, under a load in N/m.
fn approach(load: f64) -> f64 {
    load / (PI * modulus()) * (2.0 * (4.0 * RADIUS / half_width(load)).ln() - 1.0)
}

/// Load, N/m, at an approach in m, by bisection.
fn load_at(distance: f64) -> f64 {
    let (mut low, mut high) = (0.0, modulus() * distance);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if approach(middle) < distance { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    // Number of elements over the half-width at the end.
    let fine = size.choose(6, 12);
    let load = PI * modulus() * WIDTH * WIDTH * RADIUS / 4.0;
    let end = approach(load);
    let disc = half_disc(fine);
    let contact = elements_at_contact(&disc);
    let (model, settling) = model(disc, end, fine as f64)?;
    let mut run = start(model)?;
    let mut outcomes = Vec::new();
    for share in LEVELS {
        advance(&mut run, settling)?;
        // Without friction the force on the diameter is the force on the plane.
        let found = -force(&run, 0)?[1];
        let expected = load_at(share * end);
        let name = format!("load at an approach of {:.3} µm", 1e6 * share * end);
        outcomes.push(Outcome::relative(name, expected, found, 0.01, "N/m"));
    }
    let (found, load) = (pressures(&run, &contact), load_at(end));
    let greatest = (load * modulus() / (PI * RADIUS)).sqrt();
    outcomes.extend([
        Outcome::relative("half-width at the end", half_width(load), found.half_width, 0.05, "m"),
        Outcome::relative("greatest pressure at the end", greatest, found.greatest, 0.05, "Pa"),
    ]);
    Ok(outcomes)
}

/// The model, and the number of steps in which it comes to rest at each level.
fn model(disc: Mesh, end: f64, fine: f64) -> Result<(Model, u64), String> {
    let wide = 2.0 * WIDTH * RADIUS;
    let plane = rectangle([-wide, -RADIUS - 0.25 * wide], [wide, -RADIUS], [8, 1]);
    let first = disc.nodes.len() as u32;
    let mut mesh = together(&[disc, plane]);
    let above = nodes_where(&mesh, |[_, y]| y > -1e-9 * RADIUS);
    let fixed = (first..mesh.nodes.len() as u32).collect();
    // Only the state of rest counts: large elements are made so light that their time step is that of the
    // small ones.
    let sizes: Vec<f64> = (0..mesh.elements.len()).map(|element| area(&mesh, element).sqrt()).collect();
    let least = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    for (material, size) in mesh.materials.iter_mut().zip(sizes) {
        *material = (2.0 * (size / least).log2()) as u32;
    }
    let count = mesh.materials.iter().copied().max().unwrap_or(0);
    let materials = (0..=count)
        .map(|class| Material {
            name: format!("size {class}"),
            density: 1000.0 * 0.5_f64.powi(class.cast_signed()),
            poissons_ratio: POISSON,
            ..granite()
        })
        .collect();
    let mut model = Model {
        mesh,
        materials,
        boundaries: vec![
            Boundary {
                name: "diameter".to_owned(),
                target: Target::Nodes(above),
                load: Load::Displacement([None, Some(-end)]),
                schedule: Schedule::Constant,
            },
            moved("plane", fixed, [Some(0.0); 2], Schedule::Constant),
            // Symmetry holds this node; nothing else holds the disc along x.
            moved("lowest node", vec![0], [Some(0.0), None], Schedule::Constant),
        ],
        plane: Plane::Strain,
        contact: ContactOptions { penalty: PENALTY, ..ContactOptions::default() },
        time: TimeOptions { local_damping: 0.7, ..TimeOptions::default() },
        ..Model::default()
    };
    let step = model.time.safety * CriticalStep::of(&model).map_err(|error| error.to_string())?.step;
    model.time.step = Some(step);
    // A wave passes a ring in a step or two, and there are some 8 rings for each element over the half-width.
    let settling = 1200 * fine as u64;
    let hold = |(level, share): (usize, f64)| {
        let at = |part: f64| step * settling as f64 * (level as f64 + part);
        [[at(0.3), share], [at(1.0), share]]
    };
    let rows: Vec<[f64; 2]> = LEVELS.into_iter().enumerate().flat_map(hold).collect();
    model.boundaries[0].schedule = Schedule::Table([vec![[0.0, 0.0]], rows].concat());
    Ok((model, settling))
}

/// The lower half of the disc, with elements of the half-width over `fine` at its lowest point.
fn half_disc(fine: usize) -> Mesh {
    // About 0 the map has a scale of 2 R.
    let rings = 3 * fine / 2;
    let inner = 1.5 * 0.5 * WIDTH;
    let sides = 3 * rings;
    let growing = ((1.0 / inner).ln() / (1.0 + PI / sides as f64).ln()).round();
    let mut nodes = vec![[0.0, 0.0]];
    let mut triangles = Vec::new();
    let mut arc = |radius: f64, sides: usize| {
        let first = nodes.len();
        nodes.extend((0..=sides).map(|k| {
            let (sin, cos) = (PI * k as f64 / sides as f64).sin_cos();
            // The ends lie on the straight side.
            [radius * cos, if k == 0 || k == sides { 0.0 } else { radius * sin }]
        }));
        first
    };
    let mut last = 0;
    for ring in 1..=rings {
        let first = arc(inner * ring as f64 / rings as f64, 3 * ring);
        for sector in 0..3 {
            for k in 0..ring {
                let (outer, within) = (first + sector * ring + k, last + sector * (ring - 1) + k);
                triangles.push([outer, outer + 1, within]);
                if k + 1 < ring {
                    triangles.push([within, outer + 1, within + 1]);
                }
            }
        }
        last = first;
    }
    for ring in 1..=growing as usize {
        let first = arc(inner.powf(1.0 - ring as f64 / growing), sides);
        for k in 0..sides {
            let [a, b, c, d] = [last + k, first + k, first + k + 1, last + k + 1];
            if (ring + k) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
        last = first;
    }
    let triangles = triangles.into_iter().map(|corners| corners.map(|node| node as u32)).collect();
    one_body(nodes.into_iter().map(mapped).collect(), triangles)
}

/// The map i R (z − i)/(z + i).
fn mapped([x, y]: [f64; 2]) -> [f64; 2] {
    let below = x * x + (y + 1.0) * (y + 1.0);
    [2.0 * RADIUS * x / below, RADIUS * (x * x + y * y - 1.0) / below]
}

fn area(mesh: &Mesh, element: usize) -> f64 {
    let [a, b, c] = mesh.elements[element].map(|node| mesh.nodes[node as usize]);
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

/// Elements with an edge on the circle, near its lowest point.
fn elements_at_contact(disc: &Mesh) -> Vec<usize> {
    let outer = |&&node: &&u32| {
        let [x, y] = disc.nodes[node as usize];
        (x.hypot(y) - RADIUS).abs() < 1e-9 * RADIUS && x.abs() < 1.5 * WIDTH * RADIUS
    };
    (0..disc.elements.len()).filter(|&e| disc.elements[e].iter().filter(outer).count() == 2).collect()
}

struct Pressures {
    half_width: f64,
    greatest: f64,
}

/// Half-width and greatest pressure from the pressures p of elements of equal width: a semi-ellipse has a² =
/// 4 Σ p x²/Σ p and p² = p₀² (1 − x²/a²), where p₀ follows by least squares.
fn pressures(run: &Simulation, elements: &[usize]) -> Pressures {
    let snapshot = run.snapshot();
    // x², p² and p.
    let points = elements.iter().map(|&element| {
        let x = snapshot.elements[element].map(|node| snapshot.positions[node as usize][0]);
        let (middle, p) = (x.iter().sum::<f64>() / 3.0, -snapshot.stresses[element][1].min(0.0));
        [middle * middle, p * p, p]
    });
    let (mut moment, mut sum) = (0.0, 0.0);
    for [square, _, p] in points.clone() {
        moment += p * square;
        sum += p;
    }
    // The ends are left out, because the pressure changes much within an element there.
    let inner: Vec<_> = points.filter(|[square, ..]| square.sqrt() < 0.8 * WIDTH * RADIUS).collect();
    let mean = |k: usize| inner.iter().map(|point| point[k]).sum::<f64>() / inner.len() as f64;
    let (x, p) = (mean(0), mean(1));
    let (mut both, mut one) = (0.0, 0.0);
    for [square, pressure, _] in &inner {
        both += (square - x) * (pressure - p);
        one += (square - x) * (square - x);
    }
    Pressures { half_width: (4.0 * moment / sum).sqrt(), greatest: (p - both / one * x).sqrt() }
}
