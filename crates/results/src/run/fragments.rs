//! Fragments of broken bodies: a table of their masses, sizes and motion, and the distribution of their
//! sizes.

use std::f64::consts::PI;
use std::fmt::Write;

use fdem_mesh::Corners;
use fdem_simulation::{Model, Snapshot};

use crate::run::csv::{push_number, quoted};
use crate::run::names::Names;
use crate::run::snapshot::{SnapshotError, checked};

/// Areas or volumes and masses of the elements of a model, undeformed, and which of them count as parts of
/// fragments.
///
/// The elements of bodies that can break count: a body with a material that has a strength, or that takes
/// part in an interface with a strength. Platens, tools and floors without strength would hide the fragments
/// of the rock. If no body can break, all elements count. [`ElementMasses::counting`] chooses other bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementMasses {
    /// Area, m², or volume, m³, of each element.
    measures: Vec<f64>,
    /// Mass of each element, kg.
    masses: Vec<f64>,
    /// Body of each element.
    bodies: Vec<u32>,
    /// Whether each body counts.
    counted: Vec<bool>,
}

/// Number of fragments that count, and the largest of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FragmentCount {
    /// Number of fragments.
    pub number: u64,
    /// Share of the largest fragment in the mass of all, from 0 to 1; 0 without fragments.
    pub largest: f64,
}

impl FragmentCount {
    /// The count of fragments with these masses, kg.
    fn of(masses: impl Iterator<Item = f64>) -> Self {
        let (mut number, mut largest, mut all) = (0, 0.0_f64, 0.0);
        for mass in masses {
            number += 1;
            largest = largest.max(mass);
            all += mass;
        }
        Self { number, largest: if all > 0.0 { largest / all } else { 0.0 } }
    }
}

impl ElementMasses {
    /// The masses of a model. In two dimensions its thickness counts.
    ///
    /// # Errors
    /// [`SnapshotError::Length`] if the mesh has another number of bodies or materials than of elements;
    /// [`SnapshotError::Node`], [`SnapshotError::Material`] for an element whose node or material does not
    /// exist.
    pub fn of<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<Self, SnapshotError>
    where
        [[f64; D]; N]: Corners<D, N>,
    {
        let mesh = &model.mesh;
        let (elements, materials) = (mesh.elements.len(), model.materials.len());
        for (name, found) in [("bodies", mesh.bodies.len()), ("materials", mesh.materials.len())] {
            if found != elements {
                return Err(SnapshotError::Length { name, found, expected: elements });
            }
        }
        let breaks: Vec<bool> = (0..materials)
            .map(|number| {
                let interfaces = model.interfaces.iter().filter(|interface| interface.strength.is_some());
                let by_interface =
                    interfaces.flat_map(|interface| interface.materials).any(|one| one as usize == number);
                model.materials[number].strength.is_some() || by_interface
            })
            .collect();
        let bodies = mesh.bodies.iter().max().map_or(0, |&last| last as usize + 1);
        let (mut measures, mut masses) = (Vec::with_capacity(elements), Vec::with_capacity(elements));
        let mut can_break = vec![false; bodies];
        for element in 0..elements {
            let corner = |node: u32| {
                let missing = SnapshotError::Node { element, node, nodes: mesh.nodes.len() };
                mesh.nodes.get(node as usize).copied().ok_or(missing)
            };
            let mut corners = [[0.0; D]; N];
            for (place, &node) in corners.iter_mut().zip(&mesh.elements[element]) {
                *place = corner(node)?;
            }
            let material = mesh.materials[element];
            let Some(properties) = model.materials.get(material as usize) else {
                return Err(SnapshotError::Material { element, material, materials });
            };
            let measure = corners.measure();
            measures.push(measure);
            masses.push(properties.density * measure * model.thickness);
            let has_joints = model.joint_facets.get(element).is_some_and(|sets| *sets != [u32::MAX; N]);
            can_break[mesh.bodies[element] as usize] |= breaks[material as usize] || has_joints;
        }
        if !can_break.contains(&true) {
            can_break.fill(true);
        }
        Ok(Self { measures, masses, bodies: mesh.bodies.clone(), counted: can_break })
    }

    /// Counts the elements of these bodies and no others. Bodies that do not exist are ignored.
    #[must_use]
    pub fn counting(mut self, bodies: &[u32]) -> Self {
        self.counted.fill(false);
        for &body in bodies {
            if let Some(counted) = self.counted.get_mut(body as usize) {
                *counted = true;
            }
        }
        self
    }

    /// Whether an element counts.
    fn counts(&self, element: usize) -> bool {
        self.counted[self.bodies[element] as usize]
    }

    /// Counts the fragments. `fragments`: number of the fragment of each element, as
    /// [`Simulation::fragments`](fdem_simulation::Simulation::fragments) returns them.
    ///
    /// # Cost
    /// Linear in the number of elements.
    pub fn count(&self, fragments: &[u32]) -> FragmentCount {
        let number = fragments.iter().max().map_or(0, |&last| last as usize + 1);
        let mut masses = vec![0.0; number];
        for (element, &fragment) in fragments.iter().enumerate().take(self.masses.len()) {
            if self.counts(element) {
                masses[fragment as usize] += self.masses[element];
            }
        }
        FragmentCount::of(masses.into_iter().filter(|&mass| mass > 0.0))
    }
}

/// A fragment: elements that hang together by facets that are not broken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment<const D: usize = 2> {
    /// Number of the fragment in [`Snapshot::fragments`].
    pub number: u32,
    /// Number of its body.
    pub body: u32,
    /// Whether the fragment counts: see [`ElementMasses`].
    pub counted: bool,
    /// Number of elements.
    pub elements: u64,
    /// Mass, kg.
    pub mass: f64,
    /// Undeformed area, m², or volume, m³.
    pub measure: f64,
    /// Diameter of the disc of this area, or of the sphere of this volume, m.
    pub diameter: f64,
    /// Centre of mass, m.
    pub centre: [f64; D],
    /// Velocity of the centre of mass, m/s.
    pub velocity: [f64; D],
    /// Kinetic energy, that of rotation and vibration included, J.
    pub kinetic: f64,
    /// Extent along each axis, m.
    pub size: [f64; D],
}

/// The fragments of a run at one instant.
///
/// Mass, area and volume refer to the undeformed mesh; position, motion and extent refer to the instant.
///
/// # Example
/// ```
/// # use fdem_results::{ElementMasses, Fragments, Names};
/// # use fdem_simulation::{Material, Mesh, Model, Simulation};
/// # let mesh = Mesh { nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], elements: vec![[0, 1, 2]], bodies: vec![0], materials: vec![0] };
/// # let material = Material { name: "rock".to_owned(), density: 2700.0, youngs_modulus: 50e9, poissons_ratio: 0.25, law: fdem_simulation::MaterialLaw::NeoHookean, damping: 0.0, strength: None, friction: 0.5 };
/// # let model = Model { mesh, materials: vec![material], ..Model::default() };
/// let masses = ElementMasses::of(&model)?;
/// let run = Simulation::new(model, 1)?;
/// let fragments = Fragments::of(&run.snapshot(), &masses)?;
/// assert_eq!(fragments.all()[0].mass, 2700.0 * 0.5);
/// print!("{}", fragments.csv(&Names::default()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fragments<const D: usize = 2> {
    all: Vec<Fragment<D>>,
}

/// Sums over the elements of a fragment.
#[derive(Clone, Copy)]
struct Sums<const D: usize> {
    body: u32,
    counted: bool,
    elements: u64,
    mass: f64,
    measure: f64,
    /// Mass times position, kg m, and momentum, kg m/s.
    moment: [f64; D],
    momentum: [f64; D],
    kinetic: f64,
    low: [f64; D],
    high: [f64; D],
}

impl<const D: usize> Fragments<D> {
    /// Finds the fragments of a snapshot, the heaviest first.
    ///
    /// # Cost
    /// Linear in the number of elements, and n log n in the number of fragments, which are sorted.
    ///
    /// # Errors
    /// [`SnapshotError`] if the snapshot contradicts itself, or has another number of elements than the model
    /// of `masses`.
    pub fn of<const N: usize>(
        snapshot: &Snapshot<D, N>,
        masses: &ElementMasses,
    ) -> Result<Self, SnapshotError> {
        checked(snapshot)?;
        let (found, expected) = (masses.masses.len(), snapshot.elements.len());
        if found != expected {
            return Err(SnapshotError::Length { name: "masses", found, expected });
        }
        let number = snapshot.fragments.iter().max().map_or(0, |&last| last as usize + 1);
        let mut sums: Vec<Option<Sums<D>>> = vec![None; number];
        for (element, corners) in snapshot.elements.iter().enumerate() {
            let sum = sums[snapshot.fragments[element] as usize].get_or_insert(Sums {
                body: snapshot.bodies[element],
                counted: masses.counts(element),
                elements: 0,
                mass: 0.0,
                measure: 0.0,
                moment: [0.0; D],
                momentum: [0.0; D],
                kinetic: 0.0,
                low: [f64::INFINITY; D],
                high: [f64::NEG_INFINITY; D],
            });
            sum.elements += 1;
            sum.mass += masses.masses[element];
            sum.measure += masses.measures[element];
            // The mass of an element is lumped at its corners, as in the simulation.
            let mass = masses.masses[element] / N as f64;
            for &node in corners {
                let (at, velocity) = (snapshot.positions[node as usize], snapshot.velocities[node as usize]);
                for axis in 0..D {
                    sum.moment[axis] += mass * at[axis];
                    sum.momentum[axis] += mass * velocity[axis];
                    sum.kinetic += 0.5 * mass * velocity[axis] * velocity[axis];
                    sum.low[axis] = sum.low[axis].min(at[axis]);
                    sum.high[axis] = sum.high[axis].max(at[axis]);
                }
            }
        }
        let fragment = |(number, sum): (usize, Option<Sums<D>>)| sum.map(|sum| sum.fragment(number as u32));
        let mut all: Vec<Fragment<D>> = sums.into_iter().enumerate().filter_map(fragment).collect();
        all.sort_by(|a, b| b.mass.total_cmp(&a.mass).then(a.number.cmp(&b.number)));
        Ok(Self { all })
    }

    /// Returns all fragments, the heaviest first.
    pub fn all(&self) -> &[Fragment<D>] {
        &self.all
    }

    /// Counts the fragments of the bodies that count.
    pub fn count(&self) -> FragmentCount {
        FragmentCount::of(self.counted().map(|fragment| fragment.mass))
    }

    /// The distribution of the sizes of fragments of the bodies that count.
    pub fn sizes(&self) -> SizeDistribution {
        SizeDistribution::of(self.counted().map(|fragment| [fragment.diameter, fragment.mass]).collect())
    }

    fn counted(&self) -> impl Iterator<Item = &Fragment<D>> {
        self.all.iter().filter(|fragment| fragment.counted)
    }

    /// Writes the fragments as delimited text: a line of names, then one line for each fragment, the heaviest
    /// first. Numbers read back as the same.
    pub fn csv(&self, names: &Names) -> String {
        let axes = ["x", "y", "z"].into_iter().take(D);
        let measure = if D == 2 { "area" } else { "volume" };
        let mut head = ["fragment", "body", "counted", "elements", "mass", measure, "diameter"]
            .map(String::from)
            .to_vec();
        head.extend(axes.clone().map(String::from));
        head.extend(axes.clone().map(|axis| format!("v{axis}")));
        head.push("kinetic".to_owned());
        head.extend(axes.map(|axis| format!("size_{axis}")));
        head.push("body_name".to_owned());
        let mut text = head.join(",") + "\n";
        for one in &self.all {
            // Writing to a string does not fail.
            let _ = write!(text, "{},{},{},{}", one.number, one.body, u8::from(one.counted), one.elements);
            let numbers = [one.mass, one.measure, one.diameter].into_iter();
            let motion = one.centre.into_iter().chain(one.velocity).chain([one.kinetic]);
            for number in numbers.chain(motion).chain(one.size) {
                push_number(&mut text, number);
            }
            let name = names.bodies.get(one.body as usize).map_or("", String::as_str);
            let _ = writeln!(text, ",{}", quoted(name));
        }
        text
    }
}

impl<const D: usize> Sums<D> {
    fn fragment(self, number: u32) -> Fragment<D> {
        // An element without area has no mass: there is no centre, but no division by 0 either.
        let mass = self.mass.max(f64::MIN_POSITIVE);
        Fragment {
            number,
            body: self.body,
            counted: self.counted,
            elements: self.elements,
            mass: self.mass,
            measure: self.measure,
            diameter: equivalent_diameter(D, self.measure),
            centre: self.moment.map(|moment| moment / mass),
            velocity: self.momentum.map(|momentum| momentum / mass),
            kinetic: self.kinetic,
            size: std::array::from_fn(|axis| self.high[axis] - self.low[axis]),
        }
    }
}

/// Diameter of the disc of an area, or of the sphere of a volume.
fn equivalent_diameter(dimensions: usize, measure: f64) -> f64 {
    if dimensions == 2 { (4.0 * measure / PI).sqrt() } else { (6.0 * measure / PI).cbrt() }
}

/// The distribution of sizes by mass: how much of the mass passes a size.
///
/// The size of a fragment is its equivalent diameter. A point of the curve is the size of a fragment and the
/// share of the mass that it and all smaller ones have: the cumulative undersize distribution by mass, `Q₃`.
/// Between points the curve is linear; it rises from 0 at the smallest size, so that fragments of one size
/// have one `d50`, which is that size.
///
/// # Source
/// `Q₃`: ISO 9276-1:1998, "Representation of results of particle size analysis, part 1: graphical
/// representation". `d80` as the measure of crushed rock: F. C. Bond, "The third theory of comminution",
/// Trans. AIME 193 (1952) 484-494; `d50` as that of blasted rock: F. Ouchterlony, "The Swebrec function:
/// linking fragmentation by blasting and crushing", Mining Technology 114 (2005) A29-A44.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SizeDistribution {
    /// Sizes, m, ascending.
    sizes: Vec<f64>,
    /// Share of the mass that passes each size, ascending from 0 to 1.
    shares: Vec<f64>,
}

impl SizeDistribution {
    /// The distribution of fragments with these sizes, m, and masses, kg.
    fn of(mut fragments: Vec<[f64; 2]>) -> Self {
        fragments.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let all: f64 = fragments.iter().map(|[_, mass]| mass).sum();
        let Some(&[smallest, _]) = fragments.first().filter(|_| all > 0.0) else { return Self::default() };
        let (mut sizes, mut shares, mut sum) = (vec![smallest], vec![0.0], 0.0);
        for [size, mass] in fragments {
            sum += mass;
            sizes.push(size);
            shares.push(sum / all);
        }
        Self { sizes, shares }
    }

    /// Sizes of the points of the curve, m, ascending. The first point is that of the smallest size and a
    /// share of 0.
    pub fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// Share of the mass that passes each of the sizes, ascending from 0 to 1.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// Returns the size, m, that a share of the mass passes: `d20`, `d50` and `d80` for 0.2, 0.5 and 0.8.
    /// `None` if there are no fragments.
    pub fn size(&self, share: f64) -> Option<f64> {
        let (&last, after) = (self.sizes.last()?, self.shares.partition_point(|&other| other < share));
        if after == 0 || after == self.shares.len() {
            return Some(if after == 0 { self.sizes[0] } else { last });
        }
        let [low, high] = [after - 1, after].map(|k| [self.sizes[k], self.shares[k]]);
        let part = (share - low[1]) / (high[1] - low[1]);
        Some(low[0] + part * (high[0] - low[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_between_fragments_are_interpolated() {
        let sizes = SizeDistribution::of(vec![[4.0, 5.0], [1.0, 2.0], [2.0, 3.0]]);
        assert_eq!(sizes.sizes(), [1.0, 1.0, 2.0, 4.0]);
        assert_eq!(sizes.shares(), [0.0, 0.2, 0.5, 1.0]);
        for (share, size) in
            [(0.0, 1.0), (0.1, 1.0), (0.2, 1.0), (0.35, 1.5), (0.5, 2.0), (0.75, 3.0), (1.0, 4.0)]
        {
            let found = sizes.size(share).unwrap();
            assert!((found - size).abs() < 1e-12, "{share}: {found}");
        }
        assert_eq!(sizes.size(2.0), Some(4.0));
        let equal = SizeDistribution::of(vec![[3.0, 1.0]; 7]);
        assert_eq!([0.2, 0.5, 0.8].map(|share| equal.size(share)), [Some(3.0); 3]);
        assert_eq!(SizeDistribution::of(Vec::new()).size(0.5), None);
    }

    #[test]
    fn equivalent_diameters_are_those_of_discs_and_spheres() {
        assert!((equivalent_diameter(2, PI) - 2.0).abs() < 1e-15);
        assert!((equivalent_diameter(3, 4.0 / 3.0 * PI) - 2.0).abs() < 1e-15);
    }
}
