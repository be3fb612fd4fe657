//! A disc that is pressed from above and below and splits: snapshots like those of a simulation, from
//! formulas.

use std::f64::consts::PI;

use fdem_simulation::{ContactForce, Crack, Energies, Forces, Mesh, Mode, Snapshot};

/// Radius of the disc, m.
pub(crate) const RADIUS: f64 = 0.025;
/// Duration, s.
pub(crate) const END: f64 = 2e-3;
/// Time at which the first edge breaks, as a share of the duration.
const BREAKS: f64 = 0.4;

/// A disc of rings of triangles in two halves, which share no nodes.
pub(crate) struct Disc {
    nodes: Vec<[f64; 2]>,
    elements: Vec<[u32; 3]>,
    /// Edges between the halves: left element, right element, ends, from the middle outwards.
    seam: Vec<([u32; 2], [[f64; 2]; 2])>,
}

impl Disc {
    /// A disc of `rings` rings with 6 rings² elements.
    pub(crate) fn new(rings: u32) -> Self {
        let place = |ring: u32, k: u32| {
            // Rings are turned against each other by parts of an edge, so that the seam is jagged.
            let edge = 2.0 * PI / f64::from(6 * ring).max(1.0);
            let angle = edge * (f64::from(k) + 0.3 * f64::from(ring * ring % 3));
            let radius = RADIUS * f64::from(ring) / f64::from(rings);
            [radius * angle.sin(), radius * angle.cos()]
        };
        let first = |ring: u32| if ring == 0 { 0 } else { 3 * ring * (ring - 1) + 1 };
        let node = |ring: u32, k: u32| first(ring) + if ring == 0 { 0 } else { k % (6 * ring) };
        let mut nodes = Vec::new();
        for ring in 0..=rings {
            nodes.extend((0..(6 * ring).max(1)).map(|k| place(ring, k)));
        }
        let mut elements = Vec::new();
        for ring in 1..=rings {
            let (mut inner, mut outer) = (0, 0);
            while inner < 6 * (ring - 1) || outer < 6 * ring {
                let (a, b) = (node(ring - 1, inner), node(ring, outer));
                let goes_out = outer * (ring - 1) <= inner * ring && outer < 6 * ring;
                let c = if goes_out { node(ring, outer + 1) } else { node(ring - 1, inner + 1) };
                if goes_out {
                    outer += 1;
                } else {
                    inner += 1;
                }
                let corners = [a, b, c].map(|k| nodes[k as usize]);
                elements.push(if doubled(corners) > 0.0 { [a, b, c] } else { [a, c, b] });
            }
        }
        Self::cut(&nodes, &elements)
    }

    /// Separates the two halves, which get separate nodes.
    fn cut(nodes: &[[f64; 2]], elements: &[[u32; 3]]) -> Self {
        let left = |nodes_of: &[u32; 3]| nodes_of.iter().map(|&k| nodes[k as usize][0]).sum::<f64>() < 0.0;
        let mut edges = std::collections::BTreeMap::new();
        let mut seam = Vec::new();
        for (element, corners) in elements.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                if let Some(other) = edges.insert((a.min(b), a.max(b)), element)
                    && left(&elements[other]) != left(corners)
                {
                    let pair = if left(corners) { [element, other] } else { [other, element] };
                    seam.push((pair.map(|k| k as u32), [a, b].map(|k| nodes[k as usize])));
                }
            }
        }
        let far = |ends: &[[f64; 2]; 2]| (ends[0][1] + ends[1][1]).abs();
        seam.sort_by(|a, b| far(&a.1).total_cmp(&far(&b.1)).then(a.0.cmp(&b.0)));
        let count = nodes.len() as u32;
        let elements = elements
            .iter()
            .map(|corners| if left(corners) { *corners } else { corners.map(|k| k + count) })
            .collect();
        Self { nodes: nodes.repeat(2), elements, seam }
    }

    /// The undeformed mesh: two bodies.
    pub(crate) fn mesh(&self) -> Mesh {
        let half = self.nodes.len() as u32 / 2;
        Mesh {
            nodes: self.nodes.clone(),
            elements: self.elements.clone(),
            bodies: self.elements.iter().map(|nodes| u32::from(nodes[0] >= half)).collect(),
            materials: vec![0; self.elements.len()],
        }
    }

    /// Forces between the elements beside the seam.
    pub(crate) fn forces(snapshot: &Snapshot) -> Forces {
        let contact = |crack: &Crack| ContactForce {
            elements: crack.elements,
            point: crack.corners[0],
            normal: [-1e3 * crack.measure, 0.0],
            tangential: [0.0, 1e2 * crack.sliding],
        };
        let reactions = snapshot.positions.iter().map(|[_, y]| [0.0, if *y > 0.02 { -3.0 } else { 0.0 }]);
        Forces { contacts: snapshot.cracks.iter().map(contact).collect(), reactions: reactions.collect() }
    }

    /// The snapshot at a share of the duration.
    pub(crate) fn snapshot(&self, share: f64) -> Snapshot {
        let n = self.nodes.len();
        let load =
            10e6 * if share < BREAKS { share / BREAKS } else { (1.0 - 3.0 * (share - BREAKS)).max(0.05) };
        let apart = (share - BREAKS).max(0.0);
        let time = share * END;
        let side = |k: usize| if k < n / 2 { -1.0 } else { 1.0 };
        let mut snapshot = Snapshot { step: (share * 1e5).round() as u64, time, ..Snapshot::default() };
        for (k, &[x, y]) in self.nodes.iter().enumerate() {
            // The halves turn about their lower ends when they part.
            let opening = side(k) * 0.12 * apart * (y + 1.2 * RADIUS);
            let moved = [opening + 2e-10 * load * x, -6e-10 * load * y];
            snapshot.positions.push([x + moved[0], y + moved[1]]);
            snapshot.displacements.push(moved);
            let speed = if apart > 0.0 { side(k) * 0.12 * (y + 1.2 * RADIUS) / END } else { 0.0 };
            snapshot.velocities.push([speed, -6e-10 * y * 10e6 / (BREAKS * END)]);
        }
        let broken = ((apart * 2.5).min(1.0) * self.seam.len() as f64).round() as usize;
        let mut damage = vec![0.0; self.elements.len()];
        for (k, (elements, ends)) in self.seam.iter().enumerate() {
            let ahead = k as f64 - broken as f64;
            let share_of_damage = if ahead < 0.0 {
                1.0
            } else {
                (1.0 - (ahead + 1.0) / 6.0) * f64::from(u8::from(apart > 0.0))
            };
            if share_of_damage <= 0.0 {
                continue;
            }
            for &element in elements {
                damage[element as usize] = f64::max(damage[element as usize], share_of_damage);
            }
            let middle = f64::midpoint(ends[0][1], ends[1][1]);
            let mode = match middle.abs() / RADIUS {
                far if far > 0.92 => Mode::Shear,
                far if far > 0.84 => Mode::Mixed,
                _ => Mode::Tension,
            };
            snapshot.cracks.push(Crack {
                corners: ends.map(|[x, y]| [x, y * (1.0 - 6e-10 * load)]),
                elements: *elements,
                damage: share_of_damage,
                mode,
                opening: 0.24 * apart * (middle + 1.2 * RADIUS),
                sliding: 1e-7 * middle / RADIUS,
                time: (ahead < 0.0).then(|| END * (BREAKS + k as f64 / self.seam.len() as f64 / 2.5)),
                measure: (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]),
                open_from_start: false,
                softens: None,
                dissipated: 1.0,
            });
        }
        for corners in &self.elements {
            let middle: [f64; 2] =
                [0, 1].map(|axis| corners.iter().map(|&k| self.nodes[k as usize][axis]).sum::<f64>() / 3.0);
            snapshot.stresses.push(stress(middle, load));
        }
        snapshot.elements.clone_from(&self.elements);
        snapshot.damage = damage;
        snapshot.bodies =
            self.elements.iter().map(|corners| u32::from(corners[0] as usize >= n / 2)).collect();
        snapshot.materials = vec![0; self.elements.len()];
        snapshot.fragments =
            if broken < self.seam.len() { vec![0; self.elements.len()] } else { snapshot.bodies.clone() };
        snapshot
    }

    /// Energies at a share of the duration, J.
    pub(crate) fn energies(share: f64) -> Energies {
        let strain =
            0.5 * (share.min(BREAKS) / BREAKS).powi(2) * (1.0 - 1.8 * (share - BREAKS).clamp(0.0, 0.5));
        let cohesive = 0.08 * ((share - BREAKS).max(0.0) * 2.5).min(1.0);
        let damping = 0.05 * share;
        let kinetic = 0.004 + 0.3 * (share - BREAKS).clamp(0.0, 0.4);
        let external = strain + cohesive + damping + kinetic - 1e-4 * share;
        Energies { kinetic, strain, cohesive, damping, external, exchanged: external, ..Energies::default() }
    }
}

/// Stress in a disc under two opposite point loads (Hondros' solution, bounded near the loads); `centre` is
/// the stress `xx` at the centre.
fn stress([x, y]: [f64; 2], centre: f64) -> [f64; 6] {
    let (r, p) = (RADIUS, -centre * RADIUS);
    let of = |dy: f64| {
        let square = (x * x + dy * dy).max(0.01 * r * r);
        [x * x * dy / square.powi(2), dy.powi(3) / square.powi(2), x * dy * dy / square.powi(2)]
    };
    let ([ax, ay, axy], [bx, by, bxy]) = (of(r - y), of(r + y));
    let half = 1.0 / (2.0 * r);
    [2.0 * p * (ax + bx - half), 2.0 * p * (ay + by - half), 0.0, -2.0 * p * (axy - bxy), 0.0, 0.0]
}

/// Twice the area, positive counter-clockwise.
fn doubled([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
