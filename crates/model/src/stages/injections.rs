//! Injections: the holes and joints where fluid enters, and how much of it.

use fdem_io::numbers::brief;
use fdem_mesh::{Corners, Mesh};
use fdem_simulation::fluid::{Drive, Schedule as FluidSchedule};
use fdem_simulation::{Boundary, FluidOptions, FluidSource, Schedule, Target};

use crate::bodies::dimensions::Dimensions;
use crate::joints::bonds::Bonds;
use crate::output::fluid_columns::FLUID;
use crate::shapes::placed::Placed;
use crate::stages::acting::Times;
use crate::stages::schedules::Factor;
use crate::stages::{cavities, fluid};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, suggestion};
use crate::text::file::{self, ModelFile};
use crate::text::included::Load;

/// Straight lines that stand for a ramp.
const LINES: u32 = 64;

/// Checks injections before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let taken = file.history.iter().position(|history| history.name == FLUID && file.fluid.is_some());
    if let Some(index) = taken {
        let message =
            format!("a history cannot have the name \"{FLUID}\": the history has columns of the fluid");
        let span = document.value(Table::of("history", index), "name");
        faults.push(Fault::at(span, message).label("again").help("give it another name"));
    }
    for (index, injection) in file.injection.iter().enumerate() {
        let table = Table::of("injection", index);
        let title = format!("[[injection]] \"{}\"", injection.name);
        let places = given([
            ("at", injection.at.is_some()),
            ("group", injection.group.is_some()),
            ("boundary", injection.boundary.is_some()),
        ]);
        match places[..] {
            [_] => {}
            [] => faults.push(
                Fault::at(document.key(table, "name"), format!("{title} has no place"))
                    .label("this injection")
                    .help("give it one of at, group and boundary"),
            ),
            [first, second, ..] => faults.push(
                Fault::at(
                    document.key(table, second),
                    format!("{title} is in two places, {first} and {second}"),
                )
                .label("a second place")
                .help("take one of at, group and boundary"),
            ),
        }
        let drives = given([("rate", injection.rate.is_some()), ("pressure", injection.pressure.is_some())]);
        if let [first, second] = drives[..] {
            faults.push(
                Fault::at(document.key(table, second), format!("{title} has both {first} and {second}"))
                    .label("take one of them"),
            );
        }
        let schedules = Factor::of_injection(injection, index).given();
        if let (Some(key), []) = (schedules.first(), &drives[..]) {
            faults.push(
                Fault::at(
                    document.key(table, key),
                    format!("{title}: \"{key}\" is the factor of a rate or a pressure, and it has none"),
                )
                .help("add a rate or a pressure, or take it out"),
            );
        }
        check_name(file, document, index, faults);
        let stages = Times { table, title: &title, stages: injection.stages.as_deref(), begin: "[fluid]" };
        stages.check(file, fluid::first_stage(file), document, faults);
    }
}

/// The keys that are given.
pub(crate) fn given<const K: usize>(all: [(&'static str, bool); K]) -> Vec<&'static str> {
    all.into_iter().filter(|(_, given)| *given).map(|(key, _)| key).collect()
}

/// Reports a name that would give two columns of the history the same name.
fn check_name(file: &ModelFile, document: &Document<'_>, index: usize, faults: &mut Vec<Fault>) {
    let injection = &file.injection[index];
    let message = if injection.name == FLUID {
        format!("an injection cannot have the name \"{FLUID}\": the history has columns of the fluid")
    } else if file.history.iter().any(|history| history.name == injection.name) {
        format!("there is a [[history]] \"{}\": an injection has columns with its name", injection.name)
    } else {
        return;
    };
    let span = document.value(Table::of("injection", index), "name");
    faults.push(Fault::at(span, message).label("again").help("give it another name"));
}

/// The meshed parts of a model in which injections are looked for.
pub(crate) struct InjectionPlaces<'a, const D: usize, const N: usize> {
    file: &'a ModelFile,
    document: &'a Document<'a>,
    mesh: &'a Mesh<D, N>,
    placed: &'a [Placed<D, N>],
    boundaries: &'a [Boundary<D>],
    /// Joints between bodies: the number of the set, and the nodes of one of the two bodies.
    bonds: Vec<(u32, [u32; D])>,
}

/// A fault of an injection: its key, a message, and advice.
type InjectionFault = (&'static str, String, String);

impl<'a, const D: usize, const N: usize> InjectionPlaces<'a, D, N>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    /// The bodies, the mesh and the boundaries of a file.
    pub(crate) fn of(
        (file, document): (&'a ModelFile, &'a Document<'a>),
        (mesh, placed): (&'a Mesh<D, N>, &'a [Placed<D, N>]),
        boundaries: &'a [Boundary<D>],
        bonds: &Bonds<D>,
    ) -> Self {
        Self { file, document, mesh, placed, boundaries, bonds: bonds.facets() }
    }

    /// The fluid, with its sources if the file `is_right` so far; `None` if the file has no fluid.
    pub(crate) fn fluid(
        &self,
        gravity: [f64; D],
        is_right: bool,
        load: &mut Load<'_>,
        faults: &mut Vec<Fault>,
    ) -> Option<FluidOptions<D>> {
        let mut options = fluid::options(self.file, gravity)?;
        if is_right {
            options.sources = self.sources(load, faults);
        }
        Some(options)
    }

    /// The sources of the fluid, in the order of the file. There is a fluid.
    fn sources(&self, load: &mut Load<'_>, faults: &mut Vec<Fault>) -> Vec<FluidSource<D>> {
        let Some(fluid) = &self.file.fluid else { return Vec::new() };
        let lowest = fluid::state(fluid).lowest_pressure();
        let mut sources = Vec::new();
        for (index, injection) in self.file.injection.iter().enumerate() {
            let table = Table::of("injection", index);
            let title = format!("[[injection]] \"{}\"", injection.name);
            let factor = Factor::of_injection(injection, index);
            let schedule = factor.schedule(self.file.model.end_time, self.document, load, faults);
            let rate = injection.rate.map(|rate| Drive::Rate(times(&schedule, rate)));
            let pressure = injection.pressure.map(|value| Drive::Pressure(times(&schedule, value)));
            let is_low = |value: f64| value < lowest;
            let low = pressure.as_ref().and(lowest_of(&schedule, injection.pressure)).filter(|p| is_low(*p));
            let initial = injection.initial_pressure.filter(|pressure| is_low(*pressure));
            for (key, value) in [("pressure", low), ("initial_pressure", initial)] {
                if let Some(value) = value {
                    let message = format!(
                        "{title}: a pressure of {value} Pa is below the lowest one of the fluid, {lowest} Pa"
                    );
                    faults.push(Fault::at(self.document.value(table, key), message).label("too low"));
                }
            }
            match self.facets(injection) {
                Ok(facets) => sources.push(FluidSource {
                    name: injection.name.clone(),
                    facets,
                    drive: rate.or(pressure),
                    initial_pressure: injection.initial_pressure,
                }),
                Err((key, message, help)) => faults.push(
                    Fault::at(self.document.value(table, key), format!("{title}: {message}")).help(help),
                ),
            }
        }
        sources
    }

    /// The facets of a hole, or the facet of a joint.
    fn facets(&self, injection: &file::Injection) -> Result<Vec<[u32; D]>, InjectionFault> {
        if let Some(at) = &injection.at {
            let point = at.components();
            let outline = self.placed.iter().flat_map(|Placed { piece, first, .. }| {
                piece.outline.iter().map(move |facet| facet.map(|node| node + first[0]))
            });
            return match cavities::hole_around(point, &outline.collect::<Vec<_>>(), self.mesh) {
                Some(hole) => Ok(hole),
                None if injection.initial_pressure.is_some() => {
                    let message = "there is no hole at its point, and \"initial_pressure\" is that of a hole";
                    let help = "joints have the initial_pressure of [fluid]";
                    Err(("initial_pressure", message.to_owned(), help.to_owned()))
                }
                None => Ok(vec![self.joint(point)?]),
            };
        }
        let (key, facets) = match (&injection.group, &injection.boundary) {
            (Some(group), _) => ("group", self.of_group(group)?),
            (None, name) => ("boundary", self.of_boundary(name.as_deref().unwrap_or_default())?),
        };
        if !cavities::is_closed(&facets) || self.volume(&facets) <= 0.0 {
            let message = "its edges or faces do not enclose a hole".to_owned();
            let help = "take the group of a hole, or a point in it by at";
            return Err((key, message, help.to_owned()));
        }
        Ok(facets)
    }

    fn of_group(&self, name: &str) -> Result<Vec<[u32; D]>, InjectionFault> {
        let mut facets = Vec::new();
        for Placed { piece, first, .. } in self.placed {
            let group = piece.groups.get(name).map(|group| piece.facets_of(group)).unwrap_or_default();
            facets.extend(group.into_iter().map(|facet| facet.map(|node| node + first[0])));
        }
        if facets.is_empty() {
            let mut names: Vec<&str> =
                self.placed.iter().flat_map(|body| body.piece.groups.keys()).map(String::as_str).collect();
            names.sort_unstable();
            names.dedup();
            let message = format!("no body has a group \"{name}\" of outer edges or faces");
            return Err(("group", message, suggestion(name, &names, "group")));
        }
        Ok(facets)
    }

    fn of_boundary(&self, name: &str) -> Result<Vec<[u32; D]>, InjectionFault> {
        let on_facets = |of: &&Boundary<D>| matches!(of.target, Target::Facets(_));
        let all: Vec<&Boundary<D>> = self.boundaries.iter().filter(on_facets).collect();
        let found = all.iter().find(|of| of.name == name).map(|of| of.target.facets().to_vec());
        found.ok_or_else(|| {
            let names: Vec<&str> = all.iter().map(|of| of.name.as_str()).collect();
            let message = format!("there is no boundary \"{name}\" with a load on edges or faces");
            ("boundary", message, suggestion(name, &names, "boundary"))
        })
    }

    /// The facet at a point of a joint that fluid can enter from the beginning.
    fn joint(&self, point: [f64; D]) -> Result<[u32; D], InjectionFault> {
        let of_pieces = self.placed.iter().flat_map(|Placed { piece, first, .. }| {
            piece.joints.iter().map(|joint| (joint.set, joint.facet.map(|node| node + first[0])))
        });
        let all = of_pieces.chain(self.bonds.iter().copied());
        let gaps: Vec<(f64, u32, [u32; D])> =
            all.map(|(set, facet)| (self.gap(point, &facet), set, facet)).collect();
        let nearest = |wet: bool| {
            let of_kind = gaps.iter().filter(|(_, set, _)| !wet || self.is_wet(*set));
            of_kind.min_by(|a, b| a.0.total_cmp(&b.0)).copied()
        };
        let is_on = |(gap, _, facet): &(f64, u32, [u32; D])| *gap <= self.size(facet);
        if let Some((_, _, facet)) = nearest(true).filter(is_on) {
            return Ok(facet);
        }
        let message = format!("at {point:?} there is no hole, and no joint that fluid can enter");
        let name = |set: u32| &self.file.joint_set[set as usize].name;
        let help = match (nearest(false), nearest(true)) {
            (Some((.., set, _)), _) if nearest(false).as_ref().is_some_and(is_on) => format!(
                "the joint there is of [[joint_set]] \"{}\", which is closed: give the set an aperture, or open = true",
                name(set)
            ),
            (_, Some((gap, set, facet))) => format!(
                "the nearest is of [[joint_set]] \"{}\" at {:?}, {} m away",
                name(set),
                self.middle(&facet).map(brief),
                brief(gap)
            ),
            (Some((gap, set, _)), None) => format!(
                "the nearest joint, {} m away, is of [[joint_set]] \"{}\", which is closed: give the set an aperture, or open = true",
                brief(gap),
                name(set)
            ),
            (None, None) => {
                "the bodies have no joints: give them a hole, or a [[joint_set]] with open = true".to_owned()
            }
        };
        Err(("at", message, help))
    }

    /// Whether fluid can enter the joints of a set from the beginning.
    fn is_wet(&self, set: u32) -> bool {
        let set = &self.file.joint_set[set as usize];
        let law = self.file.fluid.as_ref().map(|fluid| fluid::aperture_of_set(fluid, set));
        set.open || law.is_some_and(|law| law.initial > 0.0)
    }

    fn places(&self, facet: &[u32; D]) -> [[f64; D]; D] {
        facet.map(|node| self.mesh.nodes[node as usize])
    }

    fn middle(&self, facet: &[u32; D]) -> [f64; D] {
        let places = self.places(facet);
        std::array::from_fn(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / D as f64)
    }

    /// Distance of a point from the middle of a facet, m.
    fn gap(&self, point: [f64; D], facet: &[u32; D]) -> f64 {
        distance(point, self.middle(facet))
    }

    /// Distance of the farthest corner of a facet from its middle, m.
    fn size(&self, facet: &[u32; D]) -> f64 {
        let middle = self.middle(facet);
        self.places(facet).into_iter().map(|corner| distance(corner, middle)).fold(0.0, f64::max)
    }

    /// Volume that facets enclose from outside, m³ (in two dimensions m²).
    fn volume(&self, facets: &[[u32; D]]) -> f64 {
        let apex = facets.first().map_or([0.0; D], |facet| self.middle(facet));
        let of = |facet: &[u32; D]| {
            let places = self.places(facet);
            let corners: [[f64; D]; N] = std::array::from_fn(|k| places.get(k).copied().unwrap_or(apex));
            corners.measure()
        };
        // Edges go around their bodies, and faces are counter-clockwise from outside.
        let sign = if D == 2 { -1.0 } else { 1.0 };
        sign * facets.iter().map(of).sum::<f64>()
    }
}

fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (0..D).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

/// A value times a factor in time.
pub(crate) fn times(schedule: &Schedule, value: f64) -> FluidSchedule {
    let rows = rows(schedule);
    let values = rows.iter().map(|[_, factor]| value * factor).collect();
    FluidSchedule::table(rows.iter().map(|[time, _]| *time).collect(), values)
}

/// The factor as a table.
fn rows(schedule: &Schedule) -> Vec<[f64; 2]> {
    match schedule {
        Schedule::Table(rows) => rows.clone(),
        Schedule::Ramp(time) => {
            let at = |k: u32| time * f64::from(k) / f64::from(LINES);
            (0..=LINES).map(|k| [at(k), schedule.factor(at(k))]).collect()
        }
        Schedule::Constant | Schedule::From(..) => vec![[0.0, 1.0]],
    }
}

/// The lowest value of a quantity over the time.
fn lowest_of(schedule: &Schedule, value: Option<f64>) -> Option<f64> {
    let value = value?;
    Some(rows(schedule).iter().map(|[_, factor]| value * factor).fold(f64::INFINITY, f64::min))
}
