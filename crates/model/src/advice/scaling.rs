//! Mass scaling of a model: mass that is added for a longer time step, within a bound, and advice to add
//! some.

use fdem_io::numbers::brief;
use fdem_mesh::Corners;
use fdem_simulation::{CriticalStep, Element, Load, MassScaling, Model, ModelError};

use crate::advice::quasi_static::is_quasi_static;
use crate::advice::slivers::Slivers;
use crate::prepared::{Entered, Prepared, Scaled, counted};
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{ModelFile, TimeStep};

/// Added mass of the advice, as a share of that of the model.
const LITTLE: f64 = 0.01;

/// The advice is given if the time step with [`LITTLE`] more mass is at least this many times as long.
const WORTH: f64 = 1.5;

/// The advice proposes a step that is at most this many times as long.
const MOST: f64 = 20.0;

/// Factor of the mass of elements whose motion is so slow that it limits no time step.
const HEAVY: f64 = 1e30;

/// The mass scaling of all stages of a model.
struct Scaling {
    /// The scaling of each stage, with the numbers of its elements in the whole model; those of a model
    /// without stages are empty.
    stages: Vec<(MassScaling, Vec<u32>)>,
    /// True mass of each element of the whole model, kg.
    masses: Vec<f64>,
    /// The shortest critical time step of the stages, s.
    critical: f64,
    /// The shortest critical time step of the contacts of rigid bodies, s, which added mass does not make
    /// longer; infinite if there is no such body.
    rigid: f64,
}

impl Scaling {
    fn of<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Element<D, N> + Corners<D, N>,
    {
        let model = &prepared.model;
        let masses = model.true_masses();
        let mut all = Self { stages: Vec::new(), masses, critical: f64::INFINITY, rigid: f64::INFINITY };
        if prepared.stages.is_empty() {
            all.add(model, Vec::new())?;
        }
        for number in 0..prepared.stages.len() {
            let present = prepared.at(&Entered::alone(number), 0.0)?;
            all.add(&present.prepared.model, present.elements)?;
        }
        Ok(all)
    }

    fn add<const D: usize, const N: usize>(
        &mut self,
        model: &Model<D, N>,
        elements: Vec<u32>,
    ) -> Result<(), ModelError>
    where
        [[f64; D]; N]: Element<D, N>,
    {
        self.critical = self.critical.min(CriticalStep::of(model)?.step);
        if !model.rigid.is_empty() {
            // With elements so heavy, nothing but rigid bodies limits the step.
            let heavy = Model { mass_factors: vec![HEAVY; model.mesh.elements.len()], ..model.clone() };
            self.rigid = self.rigid.min(CriticalStep::of(&heavy)?.step);
        }
        self.stages.push((MassScaling::of(model)?, elements));
        Ok(())
    }

    /// Factors of the masses of all elements with which a step, s, is critical in no stage; empty if all
    /// are 1.
    fn factors(&self, step: f64) -> Vec<f64> {
        let mut all = Vec::new();
        for (scaling, elements) in &self.stages {
            let factors = scaling.factors(step);
            if factors.is_empty() {
                continue;
            }
            all.resize(self.masses.len(), 1.0_f64);
            for (number, factor) in factors.iter().enumerate() {
                let of_element = &mut all[elements.get(number).map_or(number, |&element| element as usize)];
                *of_element = of_element.max(*factor);
            }
        }
        all
    }

    fn mass(&self) -> f64 {
        self.masses.iter().sum()
    }

    /// The mass that factors add, kg.
    fn added(&self, factors: &[f64]) -> f64 {
        self.masses.iter().zip(factors).map(|(mass, factor)| (factor - 1.0) * mass).sum()
    }

    /// The longest critical step up to `most`, s, with an added mass up to this share.
    fn longest(&self, share: f64, most: f64) -> f64 {
        let (mut low, mut high) = (self.critical, most.min(self.rigid));
        let bound = share * self.mass();
        while high > 1.001 * low {
            let middle = (low * high).sqrt();
            if self.added(&self.factors(middle)) <= bound {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// Checks `mass_scaling` before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let table = Table::one("model");
    if file.model.mass_scaling.is_some() && matches!(file.model.time_step, TimeStep::Seconds(_)) {
        faults.push(
            Fault::at(document.key(table, "time_step"), "\"mass_scaling\" has the time step of the run")
                .label("a second time step")
                .help("take one of the two out"),
        );
    }
}

/// Adds the mass for `mass_scaling`. A model that cannot be simulated stays unchanged.
pub(crate) fn scale<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    prepared: &mut Prepared<D, N>,
) -> Result<(), Fault>
where
    [[f64; D]; N]: Element<D, N> + Corners<D, N>,
{
    let Some(asked) = &file.model.mass_scaling else { return Ok(()) };
    // The preflight of such a model reports the problem.
    let Ok(scaling) = Scaling::of(prepared) else { return Ok(()) };
    let (step, safety) = (asked.time_step, prepared.model.time.safety);
    if step > safety * scaling.rigid {
        return Err(Fault::at(
            document.value(Table::one("model"), "mass_scaling.time_step"),
            format!(
                "a time step of {} s is too long for the contacts of rigid bodies, which take no added mass",
                brief(step)
            ),
        )
        .label("too long")
        .help(format!(
            "take at most {} s, or a lower penalty, or larger elements of rigid bodies",
            rounded_down(safety * scaling.rigid)
        )));
    }
    let factors = scaling.factors(step / safety);
    let (true_mass, added_mass) = (scaling.mass(), scaling.added(&factors));
    if added_mass > asked.added_mass * true_mass {
        let longest = scaling.longest(asked.added_mass, step / safety);
        return Err(Fault::at(
            document.value(Table::one("model"), "mass_scaling.time_step"),
            format!(
                "a time step of {} s needs {} % more mass; \"added_mass\" allows {} %",
                brief(step),
                brief(100.0 * added_mass / true_mass),
                brief(100.0 * asked.added_mass)
            ),
        )
        .label("too long")
        .help(format!(
            "steps of {} s are possible within this bound, and {} s without added mass; most mass for its size goes to {}",
            rounded_down(safety * longest),
            brief(safety * scaling.critical),
            heaviest(prepared, &factors)
        )));
    }
    prepared.mass_scaling = Some(Scaled {
        elements: factors.iter().filter(|factor| **factor > 1.0).count(),
        true_mass,
        added_mass,
        step,
        step_without: scaling.critical * safety,
        kinetic_bound: asked.kinetic_energy,
    });
    prepared.model.mass_factors = factors;
    prepared.model.time.step = Some(step);
    warn(prepared);
    Ok(())
}

/// The element with the largest factor, in words.
fn heaviest<const D: usize, const N: usize>(prepared: &Prepared<D, N>, factors: &[f64]) -> String {
    let largest = (0..factors.len()).max_by(|&a, &b| factors[a].total_cmp(&factors[b]).then(b.cmp(&a)));
    let element = largest.unwrap_or_default();
    let body = prepared.bodies.iter().find(|body| body.elements.contains(&(element as u32)));
    format!(
        "element {element} of \"{}\" at [{}], {} times its own",
        body.map_or("", |body| &body.name),
        prepared.model.mesh.centroid(element).map(brief).join(", "),
        brief(factors[element])
    )
}

/// Adds warnings of mass scaling that has no effect, or that distorts waves.
fn warn<const D: usize, const N: usize>(prepared: &mut Prepared<D, N>) {
    let Prepared { model, warnings, mass_scaling: Some(scaled), .. } = prepared else { return };
    if scaled.elements == 0 {
        warnings.push(format!(
            "[model] mass_scaling adds no mass: steps of {} s are stable without it",
            brief(scaled.step_without)
        ));
        return;
    }
    let dynamic = "mass scaling is for quasi-static runs";
    if let Some(boundary) = model.boundaries.iter().find(|boundary| boundary.load == Load::Absorbing) {
        warnings.push(format!(
            "[[boundary]] \"{}\" absorbs waves, and {dynamic}: elements with added mass reflect waves, and are too heavy for its dashpots",
            boundary.name
        ));
    }
    if !model.velocities.is_empty() {
        warnings.push(format!(
            "a body begins with a velocity, and {dynamic}: added mass adds to the energy of an impact"
        ));
    }
}

/// Advice to add a little mass where few elements alone set the time step of a quasi-static run. `step`: the
/// step of the run, s.
pub(crate) fn advice<const D: usize, const N: usize>(prepared: &Prepared<D, N>, step: f64) -> Option<String>
where
    [[f64; D]; N]: Element<D, N> + Corners<D, N>,
{
    let safety = prepared.model.time.safety;
    if prepared.mass_scaling.is_some() || !is_quasi_static(&prepared.model) {
        return None;
    }
    let scaling = Scaling::of(prepared).ok()?;
    // A step that was given may be shorter for other reasons.
    if step < 0.99 * safety * scaling.critical {
        return None;
    }
    let longer = rounded_down(safety * scaling.longest(LITTLE, MOST * scaling.critical));
    let factors = scaling.factors(longer.parse::<f64>().ok()? / safety);
    let times = longer.parse::<f64>().ok()? / step;
    // Rigid bodies take no more mass.
    (times >= WORTH && !factors.is_empty()).then(|| {
        format!(
            "few elements alone set the time step: with {} % more mass on {} it is {times:.1} times as long, and forces at rest are the same; \
             if inertia does not matter here, write mass_scaling = {{ time_step = {longer} }} in [model]; most mass for its size goes to {}",
            brief(100.0 * scaling.added(&factors) / scaling.mass()),
            counted(factors.iter().filter(|factor| **factor > 1.0).count()),
            heaviest(prepared, &factors)
        )
    })
}

/// How much longer a step may be if slivers alone were heavier, at most.
const UNBOUND: f64 = 1000.0;

/// How much longer the time step would be without slivers, at least, if they are worth a warning.
const FELT: f64 = 1.2;

/// Slivers with their share in the time step: a node has the mass of all of its elements, so that those
/// beside a sliver slow it down. `None` for slivers that hardly matter.
pub(crate) fn weighed<const D: usize, const N: usize>(
    mut slivers: Slivers,
    model: &Model<D, N>,
) -> Option<Slivers>
where
    [[f64; D]; N]: Element<D, N>,
{
    let scaling = MassScaling::of(model).ok()?;
    let critical = CriticalStep::of(model).ok()?.step;
    let is_sliver = |element: usize| slivers.elements.binary_search(&(element as u32)).is_ok();
    let [mut low, mut high] = [critical, UNBOUND * critical];
    while high > 1.01 * low {
        let middle = (low * high).sqrt();
        let factors = scaling.factors(middle);
        if factors.iter().enumerate().all(|(element, factor)| *factor == 1.0 || is_sliver(element)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    slivers.longer = slivers.longer.min(low / critical);
    (slivers.longer >= FELT).then_some(slivers)
}

/// A positive number with two digits that is not above it.
fn rounded_down(number: f64) -> String {
    let power = number.log10().floor() - 1.0;
    let unit = 10_f64.powf(power);
    format!("{:.1e}", (number / unit).floor() * unit)
}
