//! Elements that make the time step much shorter than all others would.

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::Corners;
use fdem_simulation::{Element, Model};

use crate::advice::deforming;

/// Share of the elements that may be slivers, and how many may be in any case.
const FEW: (f64, usize) = (0.005, 10);

/// How much shorter slivers make the time step, at least.
const SHORTER: f64 = 2.0;

/// Slivers of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slivers {
    /// The worst of them.
    pub(crate) element: u32,
    /// Centre of the element, m.
    pub(crate) at: Vec<f64>,
    /// Smallest height of the element, m.
    height: f64,
    /// All of them, ascending.
    pub(crate) elements: Vec<u32>,
    /// Smallest height of the other elements, m.
    others: f64,
    /// Time step without them over that with them, about.
    pub(crate) longer: f64,
}

impl Slivers {
    /// The few elements that a wave crosses in much less time than all others.
    pub(crate) fn of<const D: usize, const N: usize>(model: &Model<D, N>) -> Option<Self>
    where
        [[f64; D]; N]: Corners<D, N> + Element<D, N>,
    {
        let mut times: Vec<(f64, f64, u32)> = deforming::elements(model)
            .map(|element| {
                let nodes = model.mesh.elements[element as usize];
                let material = model.mesh.materials[element as usize];
                let height = nodes.map(|node| model.mesh.nodes[node as usize]).least_height();
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
        let at = model.mesh.centroid(element as usize).to_vec();
        let others = times[count..].iter().map(|time| time.1).fold(f64::INFINITY, f64::min);
        let mut elements: Vec<u32> = times[..count].iter().map(|time| time.2).collect();
        elements.sort_unstable();
        Some(Self { element, at, height, elements, others, longer })
    }

    /// Returns the warning. `with` and `without` are the times, in words, that the run takes with and without
    /// the slivers.
    pub(crate) fn told(&self, with: &str, without: &str) -> String {
        let at = self.at.iter().map(|x| brief(*x)).collect::<Vec<_>>().join(", ");
        let like = match self.elements.len() {
            1 => "it alone makes".to_owned(),
            count => format!("{} elements like it make", grouped(count as u64)),
        };
        format!(
            "element {} at [{at}] is a sliver, {} m high where others have {} m or more: {like} the time step {:.1} times shorter; \
             without, the run would take about {without} instead of {with}",
            self.element,
            brief(self.height),
            brief(self.others),
            self.longer
        )
    }
}

/// Speed of a wave of compression along the axis on which it is fastest, m/s.
pub(crate) fn speed<const D: usize, const N: usize>(model: &Model<D, N>, material: usize) -> f64
where
    [[f64; D]; N]: Element<D, N>,
{
    let along = |axis: usize| {
        let direction = std::array::from_fn(|k| f64::from(u8::from(k == axis)));
        let [compressional, _] = model.materials[material].wave_speeds::<D, N>(model.plane, direction);
        compressional
    };
    (0..D).map(along).fold(0.0, f64::max)
}
