//! Surfaces of pores: finds their edges or faces, or the nodes of wells, and their pressures or rates.

use std::collections::BTreeSet;

use fdem_io::numbers::brief;
use fdem_mesh::{Mesh, sorted};
use fdem_simulation::fluid::Drive;
use fdem_simulation::{MaterialPoint, PoreOptions, PoreSurface, Target};

use crate::bodies::dimensions::Dimensions;
use crate::output::fluid_columns::{FLUID, PORES};
use crate::shapes::placed::{self, Placed};
use crate::stages::acting::Times;
use crate::stages::boundaries::act_together;
use crate::stages::injections::{given, times};
use crate::stages::places::{Place, PlaceKeys};
use crate::stages::pores;
use crate::stages::schedules::Factor;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, ModelFile};
use crate::text::included::Load;

/// Checks surfaces of pores before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let taken = file.history.iter().position(|history| history.name == PORES && file.pores.is_some());
    if let Some(index) = taken {
        let message = format!(
            "a history cannot have the name \"{PORES}\": the history has columns of the liquid in pores"
        );
        let span = document.value(Table::of("history", index), "name");
        faults.push(Fault::at(span, message).label("again").help("give it another name"));
    }
    for (index, surface) in file.pore_surface.iter().enumerate() {
        let table = Table::of("pore_surface", index);
        let title = format!("[[pore_surface]] \"{}\"", surface.name);
        match places(surface)[..] {
            [_] => {}
            [] if surface.body.is_some() => {}
            [] => faults.push(
                Fault::at(document.key(table, "name"), format!("{title} has no place"))
                    .label("this surface")
                    .help("give it a body, or one of side, sides, box, group and at"),
            ),
            [first, second, ..] => faults.push(
                Fault::at(
                    document.key(table, second),
                    format!("{title} is in two places, {first} and {second}"),
                )
                .label("a second place")
                .help("take one of side, sides, box, group and at"),
            ),
        }
        match given([("pressure", surface.pressure.is_some()), ("rate", surface.rate.is_some())])[..] {
            [first, second, ..] => faults.push(
                Fault::at(document.key(table, second), format!("{title} has both {first} and {second}"))
                    .label("take one of them"),
            ),
            [] => faults.push(
                Fault::at(document.key(table, "name"), format!("{title} has no pressure and no rate"))
                    .label("this surface")
                    .help("give it one of them: pressure = 0 for a drained surface"),
            ),
            [_] => {}
        }
        let inverted = |limits: &Vec<f64>| {
            let (least, most) = limits.split_at(limits.len() / 2);
            least.iter().zip(most).any(|(least, most)| most < least)
        };
        if surface.limits.as_ref().is_some_and(inverted) {
            let message = format!("{title}: its box is turned inside out");
            faults.push(Fault::at(document.value(table, "box"), message).label("from most to least"));
        }
        check_name(file, document, index, faults);
        let stages = Times { table, title: &title, stages: surface.stages.as_deref(), begin: "[pores]" };
        stages.check(file, pores::first_stage(file), document, faults);
    }
}

/// The keys of places that are given.
fn places(surface: &file::PoreSurface) -> Vec<&'static str> {
    given([
        ("side", surface.side.is_some()),
        ("sides", surface.sides.is_some()),
        ("box", surface.limits.is_some()),
        ("group", surface.group.is_some()),
        ("at", surface.at.is_some()),
    ])
}

/// Reports a name that would give two histories the same name.
fn check_name(file: &ModelFile, document: &Document<'_>, index: usize, faults: &mut Vec<Fault>) {
    let name = &file.pore_surface[index].name;
    let message = if name == FLUID || name == PORES {
        format!("a surface of pores cannot have the name \"{name}\": the history has columns of it")
    } else if file.history.iter().any(|history| history.name == *name) {
        format!("there is a [[history]] \"{name}\": a surface of pores has a column with its name")
    } else if file.injection.iter().any(|injection| injection.name == *name) {
        format!("there is an [[injection]] \"{name}\": both have columns with their names")
    } else {
        return;
    };
    let span = document.value(Table::of("pore_surface", index), "name");
    faults.push(Fault::at(span, message).label("again").help("give it another name"));
}

/// The meshed bodies in which surfaces of pores are looked for.
pub(crate) struct PorePlaces<'a, const D: usize, const N: usize> {
    pub(crate) file: &'a ModelFile,
    pub(crate) document: &'a Document<'a>,
    pub(crate) mesh: &'a Mesh<D, N>,
    pub(crate) placed: &'a [Placed<D, N>],
}

/// A fault of a surface: its key, a message, and advice.
type SurfaceFault = (&'static str, String, Option<String>);

impl<const D: usize, const N: usize> PorePlaces<'_, D, N>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    /// The liquid in pores, with its surfaces if the file `is_right` so far; `None` if the file has none.
    pub(crate) fn pores(
        &self,
        gravity: [f64; D],
        is_right: bool,
        load: &mut Load<'_>,
        faults: &mut Vec<Fault>,
    ) -> Option<PoreOptions<D>> {
        let mut options = pores::options(self.file, self.mesh, gravity)?;
        if is_right {
            options.surfaces = self.surfaces(load, faults);
        }
        Some(options)
    }

    /// The surfaces in the order of the file.
    fn surfaces(&self, load: &mut Load<'_>, faults: &mut Vec<Fault>) -> Vec<PoreSurface<D>> {
        let mut surfaces: Vec<PoreSurface<D>> = Vec::new();
        for (index, surface) in self.file.pore_surface.iter().enumerate() {
            let table = Table::of("pore_surface", index);
            let factor = Factor::of_pore_surface(surface, index);
            let schedule = factor.schedule(self.file.model.end_time, self.document, load, faults);
            let rate = surface.rate.map(|rate| Drive::Rate(times(&schedule, rate)));
            let drive = rate.or(surface.pressure.map(|value| Drive::Pressure(times(&schedule, value))));
            let found = self.target(surface).and_then(|target| {
                self.check_overlap(surface, &target, &surfaces)?;
                Ok(target)
            });
            match (found, drive) {
                (Ok(target), Some(drive)) => {
                    surfaces.push(PoreSurface { name: surface.name.clone(), target, drive });
                }
                (Err((key, message, help)), _) => faults.push(
                    Fault::at(
                        self.document.value(table, key),
                        format!("[[pore_surface]] \"{}\": {message}", surface.name),
                    )
                    .label("this place")
                    .maybe_help(help),
                ),
                // A surface without a drive is a fault that has been found before.
                (Ok(_), None) => {}
            }
        }
        surfaces
    }

    fn has_pores(&self, element: usize) -> bool {
        self.file.material[self.mesh.materials[element] as usize].pores.is_some()
    }

    /// Whether a body has an element with pores.
    fn is_porous(&self, body: usize) -> bool {
        let Placed { piece, first, .. } = &self.placed[body];
        let first = first[1] as usize;
        (first..first + piece.elements.len()).any(|element| self.has_pores(element))
    }

    /// The facets or the node of a surface.
    fn target(&self, surface: &file::PoreSurface) -> Result<Target<D>, SurfaceFault> {
        let all = match &surface.body {
            None => (0..self.placed.len()).collect(),
            Some(name) => placed::named(self.placed, self.file, name),
        };
        if let (Some(name), []) = (&surface.body, &all[..]) {
            let help = placed::suggestion(self.file, name);
            return Err(("body", format!("there is no body \"{name}\""), Some(help)));
        }
        let bodies: Vec<usize> = all.into_iter().filter(|body| self.is_porous(*body)).collect();
        if let (Some(name), []) = (&surface.body, &bodies[..]) {
            let help = "give its [[material]] \"pores\", or take another body";
            return Err(("body", format!("the body \"{name}\" has no pores"), Some(help.to_owned())));
        }
        if let Some(at) = &surface.at {
            return Ok(Target::Nodes(vec![self.well(&bodies, at.components())?]));
        }
        let keys = PlaceKeys {
            sides: surface.all_sides().collect(),
            limits: surface.limits.as_deref(),
            group: surface.group.as_deref(),
        };
        let place = Place { keys, mesh: self.mesh, placed: self.placed, bodies: &bodies };
        if let Err(help) = place.check_group() {
            let group = surface.group.as_deref().unwrap_or_default();
            return Err(("group", format!("no body with pores has a group \"{group}\""), Some(help)));
        }
        let mut facets = place.facets();
        pores::keep_outer(self.mesh, |element| self.has_pores(element), &mut facets);
        if facets.is_empty() {
            let key = places(surface).first().copied().unwrap_or("body");
            let message =
                format!("in its place there is no {} of a body with pores", <[[f64; D]; N]>::OUTER_FACET);
            return Err((key, message, None));
        }
        Ok(Target::Facets(facets))
    }

    /// The node of a well.
    fn well(&self, bodies: &[usize], point: [f64; D]) -> Result<u32, SurfaceFault> {
        let is_near = |element: u32| {
            let body = self.mesh.bodies[element as usize] as usize;
            bodies.binary_search(&body).is_ok() && self.has_pores(element as usize)
        };
        let distance = |node: &u32| {
            let place = self.mesh.nodes[*node as usize];
            (0..D).map(|axis| (place[axis] - point[axis]).powi(2)).sum::<f64>().sqrt()
        };
        let elements = (0..).zip(&self.mesh.elements).filter(|(element, _)| is_near(*element));
        let nearest = elements
            .flat_map(|(_, nodes)| *nodes)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
        let is_inside = MaterialPoint::at(self.mesh, point, is_near).is_some();
        nearest.filter(|_| is_inside).ok_or_else(|| {
            let help = nearest.map(|node| {
                let place = self.mesh.nodes[node as usize].map(brief).join(", ");
                format!("the nearest node with pores is at [{place}], {} m away", brief(distance(&node)))
            });
            ("at", format!("the point {point:?} is in no body with pores"), help)
        })
    }

    /// Reports facets that another surface has, and a pressure all of whose nodes have another one.
    fn check_overlap(
        &self,
        surface: &file::PoreSurface,
        target: &Target<D>,
        before: &[PoreSurface<D>],
    ) -> Result<(), SurfaceFault> {
        let key = places(surface).first().copied().unwrap_or("body");
        let own: BTreeSet<[u32; D]> = target.facets().iter().map(|facet| sorted(*facet)).collect();
        let mut held: BTreeSet<u32> = BTreeSet::new();
        for other in before {
            let of_file = self.file.pore_surface.iter().find(|of_file| of_file.name == other.name);
            let stages = of_file.and_then(|other| other.stages.as_deref());
            if !act_together(surface.stages.as_deref(), stages) {
                continue;
            }
            if other.target.facets().iter().any(|facet| own.contains(&sorted(*facet))) {
                let what = <[[f64; D]; N]>::OUTER_FACET;
                let message = format!("an {what} of it is of [[pore_surface]] \"{}\", too", other.name);
                let help =
                    "take two places without a common edge or face, or stages in which one of them acts";
                return Err((key, message, Some(help.to_owned())));
            }
            if matches!(other.drive, Drive::Pressure(_)) {
                held.extend(other.target.nodes());
            }
        }
        if surface.pressure.is_some() && target.nodes().iter().all(|node| held.contains(node)) {
            let message = "surfaces before it prescribe the pressure of all of its nodes".to_owned();
            return Err((key, message, Some("take another place".to_owned())));
        }
        Ok(())
    }
}
