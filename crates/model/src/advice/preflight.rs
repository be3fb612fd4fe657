//! Estimates of the cost of a run, before it starts.

use std::fmt;
use std::time::{Duration, Instant};

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::Quality;
use fdem_simulation::{CriticalStep, Forecast, Insertion, Model, Simulation};
use serde::Serialize;

use crate::advice::amounts::{YEAR, duration, size};
use crate::advice::clock::processor_time;
use crate::advice::compliance;
use crate::advice::deforming;
use crate::advice::device_forecast::DeviceForecast;
use crate::advice::fluid::FluidForecast;
use crate::advice::on_ranks::OnRanks;
use crate::advice::overlaps;
use crate::advice::pores::PoreForecast;
use crate::advice::scaling;
use crate::advice::slivers::Slivers;
use crate::bodies::dimensions::Dimensions;
use crate::prepared::{
    ComingSpheres, Joints, Prepared, PreparedRemoval, PreparedSpheres, Scaled, SphereGroup, counted, is_zero,
};
use crate::text::library::FromLibrary;

/// Costs of an element.
struct Cost {
    /// Time in a step on one core of the machine on which these were measured, s.
    seconds: f64,
    /// Memory while the run writes a frame or a checkpoint and others wait to be written, bytes.
    bytes: f64,
}

/// Costs of an element of a material that does not break.
const WHOLE: Cost = Cost { seconds: 40e-9, bytes: 900.0 };

/// Costs of an element with joints on its edges from the beginning.
const JOINED: Cost = Cost { seconds: 160e-9, bytes: 2800.0 };

/// Costs of an element of a material that breaks, as the mean over a run in which much of it breaks: joints
/// are inserted, fragments touch.
const BREAKING: Cost = Cost { seconds: 240e-9, bytes: 2000.0 };

/// Costs of a sphere with the contacts that it has in a packing, on average three.
const SPHERE: Cost = Cost { seconds: 250e-9, bytes: 1200.0 };

/// Share of the forces of elements in [`WHOLE`].
const BULK: f64 = 0.6;

/// Share of elements that deform below which the time of a step does not show how fast they are.
const FEW: f64 = 0.2;

/// The run time is measured over one in `MEASURED_SHARE` steps, within these limits of their number, and for
/// no longer than `PATIENCE`.
const MEASURED_SHARE: u64 = 100;
const MEASURED_LEAST: u64 = 10;
const MEASURED_MOST: u64 = 2000;
const PATIENCE: Duration = Duration::from_millis(250);

/// Times at which spheres that have come in are counted.
const TIMES: u32 = 64;

/// Memory of the program without a model, including its drawing code, bytes.
const PROGRAM: f64 = 28e6;

/// Memory for an element of each frame when the report is made, bytes.
const IN_REPORT: f64 = 16.0;

/// Time between results over the time step below which it is hardly meant.
const SHORT: f64 = 0.5;

/// Largest number of steps of a run: beyond it not every whole number is a floating-point number.
const MOST: f64 = 9e15;

/// Time step over the critical one from which a run is refused. With a shorter one that is not stable either,
/// a run stops soon and says where.
const LONGEST: f64 = 1000.0;

/// The largest stable time step, and the part that sets it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Critical {
    /// s.
    pub step: f64,
    /// The element that it belongs to, or the sphere.
    pub element: u32,
    /// The stiff part: "bulk", "joint" or "contact" of an element, or "sphere".
    pub cause: String,
}

impl From<CriticalStep> for Critical {
    fn from(critical: CriticalStep) -> Self {
        Self { step: critical.step, element: critical.element, cause: critical.cause.to_string() }
    }
}

/// The result of a rehearsal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rehearsed {
    /// No mesh is coarse enough, or the rehearsal took too long or stopped.
    Failed,
    /// It gave the run time.
    Done {
        /// Number of its elements.
        elements: usize,
        /// Time at which a condition or the last stage ended it before the end time, s.
        #[serde(skip_serializing_if = "Option::is_none")]
        ended: Option<f64>,
    },
}

/// Estimates of the cost of a run. Displays as lines of text.
#[derive(Debug, Clone, Serialize)]
pub struct Preflight {
    /// Title of the model; empty if it has none.
    pub title: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Names of the bodies; each piece of a packing has its own.
    pub names: Vec<String>,
    /// Sizes and shapes of elements.
    pub quality: Quality,
    /// Number of spheres.
    #[serde(skip_serializing_if = "is_zero")]
    pub spheres: usize,
    /// Number of spheres that come in until the end time.
    #[serde(skip_serializing_if = "is_zero")]
    pub spheres_to_come: usize,
    /// Number of walls.
    #[serde(skip_serializing_if = "is_zero")]
    pub walls: usize,
    /// The spheres of each `[[grains]]` table.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sphere_groups: Vec<SphereGroup>,
    /// The spheres of each `[[insertion]]` table.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub insertions: Vec<ComingSpheres>,
    /// The boxes of the `[[delete]]` tables.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub removals: Vec<PreparedRemoval>,
    /// Joints of each joint set in the mesh.
    pub joint_sets: Vec<Joints>,
    /// Lines about the mesh files of bodies, as [`Prepared::about_files`].
    pub about_files: Vec<String>,
    /// Materials that have keys from the library.
    pub from_library: Vec<FromLibrary>,
    /// The fluid, of a run in stages that of the first; `None` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<FluidForecast>,
    /// The liquid in pores, of a run in stages that of the first; `None` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pores: Option<PoreForecast>,
    /// Mass that has been added for a longer time step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_scaling: Option<Scaled>,
    /// The critical time step; of a run in stages, that of the first.
    pub critical: Critical,
    /// Whether a later stage has a shorter one, which sets the step.
    #[serde(skip)]
    is_of_later: bool,
    /// The time step that the run takes, s.
    pub step: f64,
    /// Number of steps until the end time.
    pub steps: u64,
    /// Run time on one core, s; of a model that can break, by the rehearsal, or else if much of it breaks.
    pub seconds: f64,
    /// The result of the rehearsal with a coarse mesh; none of a run that is short, or that has bodies that
    /// cannot break and are not rigid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rehearsal: Option<Rehearsed>,
    /// Whether a material can break.
    #[serde(skip)]
    pub breaks: bool,
    /// Run time on one core if nothing breaks, s.
    pub seconds_whole: f64,
    /// Memory that the run takes, bytes.
    pub memory: f64,
    /// Estimates for a run on many ranks, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_ranks: Option<OnRanks>,
    /// Estimates for a run on a graphics processor, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_device: Option<DeviceForecast>,
    /// Share by which joints that are there from the beginning make bodies softer, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub softer_by_joints: Option<f64>,
    /// Warnings about settings that may not be meant.
    pub warnings: Vec<String>,
    /// Hash of the model.
    pub hash: String,
}

impl Preflight {
    /// Estimates for a model that is ready to run. The run time is measured: the first steps are computed,
    /// for a quarter of a second at most, and forgotten.
    ///
    /// # Errors
    /// Says why the model cannot be run.
    pub fn of<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Result<Self, String>
    where
        [[f64; D]; N]: Dimensions<D, N>,
    {
        Self::with_ranks(prepared, None)
    }

    /// Like [`Preflight::of`], with the division of the run among `ranks` ranks.
    ///
    /// # Errors
    /// The model cannot be run, or not on this number of ranks.
    pub fn with_ranks<const D: usize, const N: usize>(
        prepared: &Prepared<D, N>,
        ranks: Option<usize>,
    ) -> Result<Self, String>
    where
        [[f64; D]; N]: Dimensions<D, N>,
    {
        let first;
        let is_in_stages = !prepared.stages.is_empty()
            && prepared.model.time.step.is_none()
            && prepared.mass_scaling.is_none();
        let prepared = if prepared.stages.is_empty() {
            prepared
        } else {
            first = prepared.clone().in_stages()?.1.prepared;
            &first
        };
        let model = &prepared.model;
        // All errors that a run would find are found here.
        let mut run = Simulation::new(model.clone(), 1).map_err(|error| error.to_string())?;
        let forecast = ranks.map(|ranks| Forecast::of(&mut run, ranks)).transpose();
        let forecast = forecast.map_err(|error| error.to_string())?;
        let critical = Critical::from(run.critical_step());
        let (step, steps) = steps(prepared, critical.step)?;
        let is_of_later = is_in_stages && step < 0.99 * model.time.safety * critical.step;
        let mut warnings = prepared.warnings.clone();
        let fluid = FluidForecast::of(&run, [step, prepared.end_time], &mut warnings);
        let pores = PoreForecast::of(&run, step, &mut warnings);
        let pace = Pace::of(run, steps, prepared);
        if step > critical.step {
            warnings.push(format!(
                "the time step {} s is above the critical one, {} s: the run will not be stable",
                brief(step),
                brief(critical.step)
            ));
        }
        let whole = pace.whole * steps as f64;
        if whole > YEAR {
            warnings.push(format!(
                "the run would take {}: look at units, at end_time, and at the reason for the time step of {} s",
                duration(whole),
                brief(step)
            ));
        }
        if step > prepared.end_time {
            warnings.push(format!(
                "the time step {} s is longer than end_time = {} s: the run has one step, and ends after it",
                brief(step),
                brief(prepared.end_time)
            ));
        }
        for (key, interval) in prepared.output.given.iter().filter(|(_, interval)| *interval < SHORT * step) {
            warnings.push(format!(
                "{key} gives one result every {} s, but a step takes {} s: there will be one each step",
                brief(*interval),
                brief(step)
            ));
        }
        warnings.extend(overlaps::relaxes_at_once(model, step));
        let seconds = pace.breaking * steps as f64;
        let slivers = Slivers::of(model).filter(|_| prepared.mass_scaling.is_none());
        if let Some(slivers) = slivers.and_then(|slivers| scaling::weighed(slivers, model)) {
            warnings.push(slivers.told(&duration(seconds), &duration(seconds / slivers.longer)));
        }
        warnings.extend(scaling::advice(prepared, step));
        let PreparedSpheres { groups: sphere_groups, insertions, removals, .. } =
            prepared.spheres.clone().unwrap_or_default();
        Ok(Self {
            title: prepared.title.clone(),
            bodies: prepared.bodies.len(),
            names: prepared.bodies.iter().map(|body| body.name.clone()).collect(),
            quality: prepared.quality.clone(),
            spheres: model.grains.as_ref().map_or(0, |grains| grains.spheres.positions.len()),
            walls: model.grains.as_ref().map_or(0, |grains| grains.walls.len()),
            spheres_to_come: insertions.iter().map(|of| of.by_end).sum(),
            sphere_groups,
            insertions,
            removals,
            joint_sets: prepared.joint_sets.clone(),
            softer_by_joints: compliance::softer(model),
            about_files: prepared.about_files.clone(),
            from_library: prepared.from_library.clone(),
            fluid,
            pores,
            mass_scaling: prepared.mass_scaling.clone(),
            critical,
            is_of_later,
            step,
            steps,
            seconds,
            rehearsal: None,
            breaks: deforming::breaks(model),
            seconds_whole: whole,
            on_ranks: forecast.map(|forecast| OnRanks {
                has_spheres: model.grains.is_some(),
                ..OnRanks::of(forecast, [pace.whole, pace.breaking], steps, PROGRAM)
            }),
            on_device: None,
            memory: PROGRAM
                + of_spheres(model, SPHERE.bytes)
                + sum(model, |cost| cost.bytes).max(in_report(prepared, steps)),
            warnings,
            hash: prepared.hash.clone(),
        })
    }
}

/// Finds all errors that a run would find before its first step.
///
/// # Errors
/// Says why the model cannot be run.
pub fn check<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Result<(), String>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let first;
    let prepared = if prepared.stages.is_empty() {
        prepared
    } else {
        first = prepared.clone().in_stages()?.1.prepared;
        &first
    };
    let run = Simulation::new(prepared.model.clone(), 1).map_err(|error| error.to_string())?;
    steps(prepared, run.critical_step().step).map(|_| ())
}

/// The time step of a run, s, and the number of steps until its end time.
///
/// # Errors
/// Says that there are more steps than can be counted, or that the time step is so long that the first steps
/// would spread the bodies beyond the memory.
pub fn steps<const D: usize, const N: usize>(
    prepared: &Prepared<D, N>,
    critical: f64,
) -> Result<(f64, u64), String> {
    let time = &prepared.model.time;
    let step = time.step.unwrap_or(critical * time.safety);
    if step > LONGEST * critical {
        return Err(format!(
            "its time step of {} s is {} times the critical one, {} s: no run is stable with it. Take time_step out, or make it shorter",
            brief(step),
            brief(step / critical),
            brief(critical)
        ));
    }
    if let Some(why) = uncountable(prepared.end_time, step) {
        return Err(format!("{why}: look at densities, moduli, penalties, damping and end time"));
    }
    Ok((step, (prepared.end_time / step).ceil() as u64))
}

/// Says how many steps there are, if they are more than can be counted.
pub(crate) fn uncountable(end_time: f64, step: f64) -> Option<String> {
    let steps = (end_time / step).ceil();
    (!(1.0..=MOST).contains(&steps)).then(|| {
        let count = if steps.is_finite() { about(steps) } else { "endlessly many".to_owned() };
        format!("the run would take {count} steps of {} s", brief(step))
    })
}

/// Number of first steps of a run, in which nothing breaks, that are measured.
pub(crate) fn measured(steps: u64) -> u64 {
    (steps / MEASURED_SHARE).clamp(MEASURED_LEAST, MEASURED_MOST)
}

/// Time of a step on one core of this machine, s.
struct Pace {
    /// While nothing breaks.
    whole: f64,
    /// Mean over a run in which all breaks that can.
    breaking: f64,
}

impl Pace {
    /// Computes the first of the `steps` of a run. Contacts and boundaries have their cost from the first
    /// step on; the cost of breaking is estimated.
    fn of<const D: usize, const N: usize>(
        mut run: Simulation<D, N>,
        steps: u64,
        prepared: &Prepared<D, N>,
    ) -> Self
    where
        [[f64; D]; N]: Dimensions<D, N>,
    {
        let model = &prepared.model;
        let expected = sum(model, |_| WHOLE.seconds);
        let more = match model.fracture.insertion {
            Insertion::Adaptive => sum(model, |cost| cost.seconds) - expected,
            Insertion::Intrinsic => 0.0,
        };
        let wanted = measured(steps);
        let at_first = run.counts().spheres;
        // The first step detects couples; few others do. A model that fails in the first step has no later
        // step either.
        let mut times = Vec::new();
        let mut elements = Duration::ZERO;
        if run.advance(1).is_ok() {
            let start = Instant::now();
            let before = run.timings();
            while (times.len() as u64) < wanted && (times.is_empty() || start.elapsed() < PATIENCE) {
                let begin = processor_time();
                if run.advance(1).is_err() {
                    break;
                }
                times.push(processor_time() - begin);
            }
            elements = run.timings().bulk.saturating_sub(before.bulk);
        }
        if times.is_empty() {
            let seconds = sum(model, |cost| cost.seconds) + seconds_of_spheres(model);
            return Self { whole: seconds - more, breaking: seconds };
        }
        // Elements of rigid bodies take no time, and do not show how fast the machine is.
        let rigid = (0..).zip(&model.mesh.bodies).filter(|(element, _)| model.is_rigid(*element)).count();
        let moving = 1.0 - rigid as f64 / model.mesh.elements.len().max(1) as f64;
        // Nor do few elements among many spheres.
        let is_seldom = expected < FEW * (expected + seconds_of_spheres(model));
        let slower = if moving < FEW || is_seldom {
            1.0
        } else {
            elements.as_secs_f64() / times.len() as f64 / (moving * expected * BULK)
        };
        // Other work of the machine makes some steps longer, so their mean is not the one to take.
        times.sort_unstable_by(f64::total_cmp);
        let later = to_come(prepared) - run.counts().spheres.saturating_sub(at_first) as f64;
        // Spheres that do not touch yet take less time than they will.
        let packed = (at_first as f64 + to_come(prepared)) * SPHERE.seconds;
        let whole = (times[times.len() / 2] + later.max(0.0) * SPHERE.seconds).max(packed);
        Self { whole, breaking: whole + slower * more }
    }
}

/// A cost, added up over the elements.
fn sum<const D: usize, const N: usize>(model: &Model<D, N>, cost: impl Fn(&Cost) -> f64) -> f64 {
    let of = |(element, material): (u32, &u32)| {
        let breaks = model.materials[*material as usize].strength.is_some()
            && deforming::deforms(model, model.mesh.bodies[element as usize]);
        cost(match model.fracture.insertion {
            _ if !breaks => &WHOLE,
            Insertion::Adaptive => &BREAKING,
            Insertion::Intrinsic => &JOINED,
        })
    };
    (0..).zip(&model.mesh.materials).map(of).sum()
}

/// Time of a step for all spheres with those to come, s.
pub(crate) fn seconds_of_spheres<const D: usize, const N: usize>(model: &Model<D, N>) -> f64 {
    of_spheres(model, SPHERE.seconds)
}

/// A cost of a sphere, times the number of spheres with those to come.
fn of_spheres<const D: usize, const N: usize>(model: &Model<D, N>, cost: f64) -> f64 {
    let Some(grains) = &model.grains else { return 0.0 };
    let coming: usize = grains.insertions.iter().map(|of| of.radii.len()).sum();
    cost * (grains.spheres.positions.len() + coming) as f64
}

/// Number of spheres that have come in, as the mean over the time of a run.
fn to_come<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> f64 {
    let insertions = prepared.model.grains.iter().flat_map(|grains| &grains.insertions);
    let mean = |number: u32| {
        let time = (f64::from(number) + 0.5) / f64::from(TIMES) * prepared.end_time;
        insertions.clone().map(|of| of.due(time) as f64).sum::<f64>()
    };
    (0..TIMES).map(mean).sum::<f64>() / f64::from(TIMES)
}

/// Memory for the report beside the simulation of `steps` steps, bytes: all frames, of which those of large
/// meshes are samples. There is one frame a step at most.
fn in_report<const D: usize, const N: usize>(prepared: &Prepared<D, N>, steps: u64) -> f64 {
    let [most, sample] = prepared.output.shown;
    let elements = prepared.quality.elements;
    let shown = if elements > most { sample } else { elements };
    let frames = (prepared.end_time / prepared.output.interval).ceil().min(steps as f64) + 1.0;
    sum(&prepared.model, |cost| cost.bytes) / 2.0 + frames * shown as f64 * IN_REPORT
}

/// Names beyond which the rest is counted.
const NAMES: usize = 6;

/// A number with two digits: a coarse mesh knows no more.
fn about(number: f64) -> String {
    let digits = format!("{number:.1e}");
    digits.parse().map_or(digits, brief)
}

impl fmt::Display for Preflight {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quality = &self.quality;
        if !self.title.is_empty() {
            writeln!(out, "title            {}", self.title)?;
        }
        if self.spheres + self.walls + self.insertions.len() > 0 {
            self.write_spheres(out)?;
        }
        if quality.elements > 0 {
            self.write_mesh(out)?;
        }
        writeln!(
            out,
            "critical step    {} s, set by {}",
            brief(self.critical.step),
            if self.critical.cause == "sphere" {
                self.sphere_in_words(self.critical.element)
            } else {
                format!("the {} of element {}", self.critical.cause, self.critical.element)
            }
        )?;
        if self.is_of_later {
            writeln!(
                out,
                "                 of the first stage; a later one has a shorter one, which sets the step"
            )?;
        }
        if let Some(fluid) = &self.fluid {
            write!(out, "{fluid}")?;
        }
        if let Some(pores) = &self.pores {
            write!(out, "{pores}")?;
        }
        if let Some(scaled) = &self.mass_scaling {
            writeln!(out, "mass scaling     {}", scaled.in_words())?;
        }
        writeln!(out, "steps            {} of {} s", grouped(self.steps), brief(self.step))?;
        self.write_cost(out)?;
        if let Some(on_ranks) = &self.on_ranks {
            write!(out, "{on_ranks}")?;
        }
        if let Some(on_device) = &self.on_device {
            write!(out, "{on_device}")?;
        }
        writeln!(out, "model            {}", &self.hash[..self.hash.len().min(16)])?;
        for warning in &self.warnings {
            writeln!(out, "warning          {warning}")?;
        }
        Ok(())
    }
}

/// `1 wall` and `2 walls`.
fn in_plural((number, noun): (usize, &str)) -> String {
    format!("{} {noun}{}", grouped(number as u64), if number == 1 { "" } else { "s" })
}

impl Preflight {
    /// A sphere by its number, with its group.
    fn sphere_in_words(&self, sphere: u32) -> String {
        let mut before = 0;
        let groups = self.sphere_groups.iter().map(|of| (&of.name, of.count));
        let coming = self.insertions.iter().map(|of| (&of.name, of.count));
        let group = groups.chain(coming).find(|(_, count)| {
            before += count;
            (sphere as usize) < before
        });
        match group {
            // It has no number before it comes in.
            Some((name, _)) if sphere as usize >= self.spheres => format!("a sphere of {name}, to come"),
            Some((name, _)) => format!("sphere {sphere} of {name}"),
            None => format!("sphere {sphere}"),
        }
    }

    /// Writes the lines about spheres and walls.
    fn write_spheres(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [spheres, walls] = [(self.spheres, "sphere"), (self.walls, "wall")].map(in_plural);
        let coming = match self.spheres_to_come {
            0 => String::new(),
            count => format!(", {} to come", grouped(count as u64)),
        };
        writeln!(out, "grains           {spheres}{coming}, {walls}")?;
        self.sphere_groups.iter().try_for_each(|group| writeln!(out, "                 {group}"))?;
        self.insertions.iter().try_for_each(|of| writeln!(out, "                 {of}"))?;
        self.removals.iter().try_for_each(|of| writeln!(out, "                 {of}"))
    }

    /// Writes the lines about bodies and their mesh.
    fn write_mesh(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quality = &self.quality;
        let mut names = self.names[..self.names.len().min(NAMES)].join(", ");
        if self.names.len() > NAMES {
            names.push_str(", …");
        }
        writeln!(out, "bodies           {}: {names}", grouped(self.bodies as u64))?;
        writeln!(
            out,
            "mesh             {}, {} nodes",
            counted(quality.elements),
            grouped(quality.nodes as u64)
        )?;
        let [least, mean, most] = quality.edges.map(brief);
        writeln!(out, "edges            {least} to {most} m, mean {mean} m")?;
        self.joint_sets.iter().try_for_each(|set| writeln!(out, "joints           {set}"))?;
        if let Some(share) = self.softer_by_joints {
            writeln!(
                out,
                "joints           on all facets: they make bodies softer by {:.1} %; a higher joint_penalty makes it less, and the time step shorter",
                100.0 * share
            )?;
        }
        self.about_files.iter().try_for_each(|line| writeln!(out, "mesh file        {line}"))?;
        let from_library = self.from_library.iter();
        from_library
            .map(FromLibrary::in_words)
            .try_for_each(|text| writeln!(out, "library          {text}"))?;
        let at = quality.worst_at.iter().map(|x| brief(*x)).collect::<Vec<_>>().join(", ");
        writeln!(
            out,
            "quality          smallest {} {:.1} degrees (element {} at [{at}]), in the mean {:.1}; below 25 degrees: {:.2} %",
            if quality.worst_at.len() == 3 { "angle between faces" } else { "angle" },
            quality.smallest_angle[0],
            quality.worst,
            quality.smallest_angle[1],
            100.0 * quality.below_25
        )
    }

    /// Writes the lines about run time and memory.
    fn write_cost(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let most = duration(self.seconds);
        let whole = duration(self.seconds_whole);
        if let Some(Rehearsed::Done { elements, ended }) = self.rehearsal {
            let end = ended.map_or_else(
                || "to end_time".to_owned(),
                |time| format!("that ended at about {} s", about(time)),
            );
            let to_end = if ended.is_some() { " to end_time" } else { "" };
            let pace = if self.breaks { "if nothing breaks" } else { "at the pace of the first steps" };
            writeln!(
                out,
                "run time         about {most} on one core, by a rehearsal with {} {end}; {whole}{to_end} {pace}",
                counted(elements)
            )?;
        } else if self.seconds_whole < self.seconds {
            writeln!(
                out,
                "run time         about {most} on one core if much of it breaks, {whole} if nothing breaks"
            )?;
            if self.rehearsal == Some(Rehearsed::Failed) {
                writeln!(
                    out,
                    "                 no rehearsal: no mesh is coarse enough, or it took too long or stopped; so it is not known how much breaks"
                )?;
            }
        } else {
            writeln!(out, "run time         about {most} on one core")?;
        }
        writeln!(out, "memory           about {}", size(self.memory))
    }
}
