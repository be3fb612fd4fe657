//! Elements that make the time step much shorter than all others would.

use fdem_simulation::{Model, Plane};

use crate::model::outline::{Point, distance, twice_area};
use crate::numbers::{brief, grouped};

/// Share of the elements that may be slivers, and how many may be in any case.
const FEW: (f64, usize) = (0.005, 10);

/// How much shorter slivers make the time step, at least.
const SHORTER: f64 = 2.0;

/// Slivers of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slivers {
    /// The worst of them.
    pub(crate) element: u32,
    /// Its centre, m.
    pub(crate) at: Point,
    /// Its smallest height, m.
    height: f64,
    /// Number of slivers.
    count: usize,
    /// Smallest height of the other elements, m.
    others: f64,
    /// Time step without them over that with them, about.
    pub(crate) longer: f64,
}

impl Slivers {
    /// The few elements that a wave crosses in much less time than all others.
    pub(crate) fn of(model: &Model) -> Option<Self> {
        let mut times: Vec<(f64, f64, u32)> = (0..)
            .zip(model.mesh.elements.iter().zip(&model.mesh.materials))
            .map(|(element, (nodes, &material))| {
                let [a, b, c] = nodes.map(|node| model.mesh.nodes[node as usize]);
                let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
                let height = twice_area(a, b, c) / longest;
                (height / speed(model, material as usize), height, element)
            })
            .collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let few = ((FEW.0 * times.len() as f64) as usize).max(FEW.1).min(times.len() / 4);
        // Where the time jumps most among the first few.
        let jump = |k: usize| times[k].0 / times[k - 1].0;
        let first = |a: &usize, b: &usize| jump(*a).total_cmp(&jump(*b)).then(b.cmp(a));
        let count = (1..=few).max_by(first)?;
        let (shortest, height, element) = times[0];
        let longer = times[count].0 / shortest;
        if jump(count) < SHORTER {
            return None;
        }
        let corners = model.mesh.elements[element as usize].map(|node| model.mesh.nodes[node as usize]);
        let at = [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        let others = times[count..].iter().map(|time| time.1).fold(f64::INFINITY, f64::min);
        Some(Self { element, at, height, count, others, longer })
    }

    /// Returns the warning. `with` and `without` are the times, in words, that the run takes with and without the slivers.
    pub(crate) fn told(&self, with: &str, without: &str) -> String {
        let [x, y] = self.at.map(brief);
        let like = match self.count {
            1 => "it alone makes".to_owned(),
            count => format!("{} elements like it make", grouped(count as u64)),
        };
        format!(
            "element {} at [{x}, {y}] is a sliver, {} m high where others have {} m or more: {like} the time step {:.1} times shorter; \
             without, the run would take about {without} instead of {with}",
            self.element,
            brief(self.height),
            brief(self.others),
            self.longer
        )
    }
}

/// Speed of a wave of compression, m/s.
fn speed(model: &Model, material: usize) -> f64 {
    let material = &model.materials[material];
    let nu = material.poissons_ratio;
    let modulus = match model.plane {
        Plane::Stress => material.youngs_modulus / (1.0 - nu * nu),
        Plane::Strain => material.youngs_modulus * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)),
    };
    (modulus / material.density).sqrt()
}
