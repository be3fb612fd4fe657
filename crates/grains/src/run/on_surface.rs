//! The contacts of all spheres with one surface of facets: a wall's mesh, or the surface of bodies.
//!
//! Each sphere keeps a list of facets near it. The list holds while the sphere and the points of the surface
//! have moved by no more than its slack; then the tree of boxes finds a new one. Most spheres are far from
//! the surface: they are looked at only when all may have moved by a span. Results do not depend on the
//! lists. Spheres are computed in chunks on all threads; sums over spheres are in the order of their numbers,
//! and those over the points of a body in the order of the points and then of the spheres' numbers.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::error::GrainError;
use crate::facet::of_facet;
use crate::ridges::Ridges;
use crate::run::balls::Balls;
use crate::run::depth::Depth;
use crate::run::laws::Laws;
use crate::run::on_facet::{
    Encounter, FacetContact, FacetHistory, FacetScratch, SurfaceMotion, SurfaceTotals, Touches,
};
use crate::run::on_walls::Outer;
use crate::sheets::Facets;
use crate::tree::Tree;
use crate::vector::{Vector, dot, length, minus, plus};

/// Spheres that one thread computes at a time.
const CHUNK: usize = 512;

/// Movements for which a list of facets is made, as a share of the mean radius of the spheres.
const SKIN: f64 = 0.2;

/// Share of that which the points of a surface may use.
const POINTS: f64 = 0.4;

/// Skins up to which the distance of a sphere from the surface is measured.
const HORIZON: f64 = 20.0;

/// Skins by which spheres may move before all of them are looked at again, and steps in which they at least
/// may.
const SPAN: f64 = 2.0;
const SPAN_STEPS: f64 = 20.0;

/// The facets near a sphere.
#[derive(Clone, Debug)]
struct NearFacets {
    /// Number of the sphere.
    number: u32,
    /// Where the sphere was, m, and how far points had moved, when the list was made.
    reference: Vector,
    moved: f64,
    /// Movements, m, for which the list holds.
    slack: f64,
    /// The list and the histories; `None` for a sphere that is far from the surface.
    lists: Option<Box<FacetLists>>,
}

#[derive(Clone, Debug, Default)]
struct FacetLists {
    facets: Vec<u32>,
    histories: Vec<FacetHistory>,
}

/// Spheres that one thread computes, and their results.
#[derive(Clone, Debug, Default)]
struct Chunk {
    /// By places.
    near: Vec<NearFacets>,
    /// Those that are looked at in each step.
    active: Vec<u32>,
    scratch: FacetScratch,
    outer: Vec<Outer>,
    touches: Touches,
    /// Sums over the contacts of each sphere, by its number.
    totals: Vec<(u32, SurfaceTotals)>,
    deepest: Depth,
    wrong: Option<GrainError>,
}

/// A surface of facets, and the spheres near it.
#[derive(Clone, Debug, Default)]
pub(crate) struct OnSurface {
    pub(crate) points: Vec<Vector>,
    pub(crate) corners: Vec<[u32; 3]>,
    ridges: Ridges,
    is_one_sided: bool,
    tree: Tree,
    /// Points when the tree was made, and how far one of them has moved since, m.
    reference: Vec<Vector>,
    moved: f64,
    skin: f64,
    /// Whether spheres could touch it in the last step, too.
    pub(crate) was_there: bool,
    /// How far spheres and points may still move before all spheres are looked at, and how far points had
    /// moved then, m.
    spare: f64,
    moved_then: f64,
    chunks: Vec<Chunk>,
    /// Results of the last step: contacts by the numbers of their spheres, sums, and forces on the points of
    /// bodies, N.
    pub(crate) contacts: Vec<FacetContact>,
    pub(crate) totals: SurfaceTotals,
    pub(crate) on_points: Vec<(u32, Vector)>,
    /// Memory that is used again.
    by_sphere: Vec<(u32, SurfaceTotals)>,
    pushes: Vec<(u32, u32, Vector)>,
}

/// Everything that the contacts with surfaces of a step read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnSurfacesOf<'a> {
    pub(crate) balls: &'a Balls,
    pub(crate) laws: &'a Laws,
    /// Largest movement of a sphere since the step before, m; infinite if spheres have other places.
    pub(crate) moved: f64,
    /// s.
    pub(crate) step: f64,
}

/// Memory of contacts: numbers of spheres, ascending, each with its contacts.
pub(crate) type OnFacets = Vec<(u32, Vec<FacetHistory>)>;

impl OnSurface {
    /// A surface that no sphere has touched; `radius`: mean radius of the spheres, m.
    pub(crate) fn new(is_one_sided: bool, radius: f64) -> Self {
        Self { is_one_sided, skin: SKIN * radius, ..Self::default() }
    }

    /// The deepest contact of the last step.
    pub(crate) fn deepest(&self) -> Depth {
        self.chunks.iter().map(|chunk| chunk.deepest).fold(Depth::default(), Depth::or)
    }

    /// Sets the facets, if they are others, and where their points are now.
    pub(crate) fn place(&mut self, points: &[Vector], corners: &[[u32; 3]]) {
        let is_new = self.corners != corners || self.reference.len() != points.len();
        if is_new {
            self.corners.clear();
            self.corners.extend_from_slice(corners);
            self.ridges = Ridges::new(corners);
        } else if self.points == points {
            return;
        }
        self.points.clear();
        self.points.extend_from_slice(points);
        if !is_new {
            let moves = self.points.par_iter().zip(&self.reference).with_min_len(4 * CHUNK);
            let square = |(now, then): (&Vector, &Vector)| {
                let gone = minus(*now, *then);
                dot(gone, gone)
            };
            self.moved = moves.map(square).reduce(|| 0.0, f64::max).sqrt();
        }
        if is_new || self.moved > POINTS * self.skin {
            self.reference.clone_from(&self.points);
            self.moved = 0.0;
            self.tree = Tree::new(&self.corners, &self.points);
            for near in self.chunks.iter_mut().flat_map(|chunk| &mut chunk.near) {
                near.slack = -1.0;
            }
            self.spare = -1.0;
        }
    }

    /// Computes the contacts of all spheres, and adds their actions to `outer`. `materials`: of each facet,
    /// or one for all; `direction`: of the servo.
    ///
    /// # Errors
    /// [`GrainError::UnknownSurfaces`] if two materials touch that have no law.
    pub(crate) fn press(
        &mut self,
        of: OnSurfacesOf<'_>,
        (motion, materials): (SurfaceMotion<'_>, &[u32]),
        direction: Option<Vector>,
        outer: &mut Vec<Outer>,
    ) -> Result<(), GrainError> {
        let OnSurfacesOf { balls, laws, step, .. } = of;
        self.spare -= of.moved;
        let points = (self.moved - self.moved_then).max(0.0);
        let is_full = self.spare <= points || !self.fits(balls);
        if is_full {
            self.arrange(balls);
            // A step may be longer than skins.
            let steps = if of.moved.is_finite() { SPAN_STEPS * of.moved } else { 0.0 };
            self.spare = (SPAN * self.skin).max(steps);
            self.moved_then = self.moved;
        }
        let relieves = self.is_one_sided && std::mem::replace(&mut self.was_there, true);
        let Self { points, corners, ridges, is_one_sided, chunks, tree, moved, skin, spare, .. } = self;
        let facets = Facets { points, corners, ridges, is_one_sided: *is_one_sided };
        let encounter =
            Encounter { facets, motion, materials, laws, share: balls.share, direction, relieves, step };
        let nearness = Nearness { tree, facets, moved: *moved, skin: *skin, span: *spare };
        chunks.par_iter_mut().enumerate().for_each(|(number, chunk)| {
            if is_full {
                chunk.activate(number * CHUNK, balls, &encounter, &nearness);
            }
            chunk.press(number * CHUNK, balls, &encounter, &nearness);
        });
        for chunk in &mut self.chunks {
            outer.extend_from_slice(&chunk.outer);
            if let Some(wrong) = chunk.wrong.take() {
                return Err(wrong);
            }
        }
        self.add_up();
        Ok(())
    }

    /// Whether a sphere, by its centre, m, and its radius, m, does not touch.
    pub(crate) fn is_clear(&self, centre: Vector, radius: f64) -> bool {
        let mut is_clear = true;
        self.tree.visit(centre, [radius + self.moved; 2], |facet| {
            is_clear &= of_facet(centre, self.corners[facet as usize], &self.points).0.distance >= radius;
        });
        is_clear
    }

    /// Forgets the contacts of the last step: no surface is there.
    pub(crate) fn leave(&mut self) {
        if !self.corners.is_empty() {
            *self = Self { is_one_sided: self.is_one_sided, skin: self.skin, ..Self::default() };
        }
    }

    /// The memory of the contacts of all spheres that touch.
    pub(crate) fn saved(&self) -> OnFacets {
        let all = self.chunks.iter().flat_map(|chunk| &chunk.near);
        let of = |near: &NearFacets| {
            let histories = &near.lists.as_ref()?.histories;
            (!histories.is_empty()).then(|| (near.number, histories.clone()))
        };
        let mut saved: OnFacets = all.filter_map(of).collect();
        saved.sort_by_key(|(sphere, _)| *sphere);
        saved
    }

    /// Takes the memory of a saved run over.
    pub(crate) fn take(&mut self, saved: OnFacets) {
        let unknown = |(number, histories): (u32, Vec<FacetHistory>)| NearFacets {
            lists: Some(Box::new(FacetLists { histories, ..FacetLists::default() })),
            ..NearFacets::unknown(number)
        };
        let near = saved.into_iter().map(unknown).collect();
        self.chunks = vec![Chunk { near, ..Chunk::default() }];
        self.spare = -1.0;
    }

    /// Whether the lists are those of the spheres at their places.
    fn fits(&self, balls: &Balls) -> bool {
        let near = self.chunks.iter().map(|chunk| chunk.near.len()).sum::<usize>();
        near == balls.list.len() && self.chunks.iter().all(|chunk| chunk.near.len() <= CHUNK)
    }

    /// Puts the lists to the places of their spheres.
    fn arrange(&mut self, balls: &Balls) {
        let numbers = balls.list.iter().map(|ball| ball.number);
        let near = self.chunks.iter().flat_map(|chunk| &chunk.near);
        if self.fits(balls) && near.map(|near| near.number).eq(numbers) {
            return;
        }
        let chunks = std::mem::take(&mut self.chunks);
        let near = chunks.into_iter().flat_map(|chunk| chunk.near);
        let mut known: BTreeMap<u32, NearFacets> = near
            .filter(|near| near.slack >= 0.0 || near.lists.is_some())
            .map(|near| (near.number, near))
            .collect();
        self.chunks = vec![Chunk::default(); balls.list.len().div_ceil(CHUNK)];
        for (place, ball) in balls.list.iter().enumerate() {
            let near = known.remove(&ball.number).unwrap_or_else(|| NearFacets::unknown(ball.number));
            self.chunks[place / CHUNK].near.push(near);
        }
    }

    /// Adds up by the numbers of the spheres, so that sums do not depend on their places.
    fn add_up(&mut self) {
        let Self { chunks, contacts, totals, on_points, by_sphere, pushes, .. } = self;
        contacts.clear();
        by_sphere.clear();
        pushes.clear();
        for chunk in &*chunks {
            contacts.extend_from_slice(&chunk.touches.contacts);
            by_sphere.extend_from_slice(&chunk.totals);
            pushes.extend_from_slice(&chunk.touches.on_points);
        }
        contacts.sort_by_key(|contact| contact.sphere);
        by_sphere.sort_by_key(|(sphere, _)| *sphere);
        pushes.sort_by_key(|&(point, sphere, _)| (point, sphere));
        *totals = SurfaceTotals::default();
        for (_, of_sphere) in &*by_sphere {
            totals.add(of_sphere);
        }
        on_points.clear();
        for &(point, _, force) in &*pushes {
            match on_points.last_mut() {
                Some((last, sum)) if *last == point => *sum = plus(*sum, force),
                _ => on_points.push((point, force)),
            }
        }
    }
}

/// Everything on which the list of facets near a sphere depends.
#[derive(Clone, Copy, Debug)]
struct Nearness<'a> {
    tree: &'a Tree,
    facets: Facets<'a>,
    moved: f64,
    skin: f64,
    /// Movements, m, for which a sphere that is far away needs no look.
    span: f64,
}

impl NearFacets {
    fn unknown(number: u32) -> Self {
        Self { number, reference: [0.0; 3], moved: 0.0, slack: -1.0, lists: None }
    }

    /// Movements, m, for which the list still holds.
    fn rest(&self, centre: Vector, of: &Nearness<'_>) -> f64 {
        self.slack - length(minus(centre, self.reference)) - of.moved - self.moved
    }

    /// Makes the list of a sphere anew.
    fn find(&mut self, centre: Vector, reach: f64, of: &Nearness<'_>) {
        let mut facets =
            self.lists.as_mut().map(|lists| std::mem::take(&mut lists.facets)).unwrap_or_default();
        facets.clear();
        let wide = reach + of.skin;
        let mut least = f64::INFINITY;
        let beyond = [wide + of.moved, reach + HORIZON * of.skin];
        let rest = of.tree.visit(centre, beyond, |facet| {
            let (at, _) = of_facet(centre, of.facets.corners[facet as usize], of.facets.points);
            if at.distance < wide {
                facets.push(facet);
            } else {
                least = least.min(at.distance);
            }
        });
        (self.reference, self.moved) = (centre, of.moved);
        self.slack = if facets.is_empty() { least.min(rest - of.moved) - reach } else { of.skin };
        match &mut self.lists {
            Some(lists) if facets.is_empty() && lists.histories.is_empty() => self.lists = None,
            Some(lists) => lists.facets = facets,
            None if facets.is_empty() => {}
            None => self.lists = Some(Box::new(FacetLists { facets, histories: Vec::new() })),
        }
    }
}

impl Chunk {
    /// Finds the spheres that are looked at in each step.
    fn activate(&mut self, first: usize, balls: &Balls, encounter: &Encounter<'_>, of: &Nearness<'_>) {
        self.active.clear();
        for (k, near) in self.near.iter_mut().enumerate() {
            let ball = &balls.list[first + k];
            if near.lists.is_none() && near.rest(ball.position, of) < of.span {
                near.find(ball.position, ball.radius + encounter.laws.reach(ball.radius), of);
            }
            if near.lists.is_some() || near.rest(ball.position, of) < of.span {
                self.active.push(k as u32);
            }
        }
    }

    /// Computes the contacts of the spheres of this chunk, the first of which has a place.
    fn press(&mut self, first: usize, balls: &Balls, encounter: &Encounter<'_>, nearness: &Nearness<'_>) {
        let Self { near, active, scratch, outer, touches, totals, deepest, wrong } = self;
        *deepest = Depth::default();
        outer.clear();
        totals.clear();
        touches.contacts.clear();
        touches.on_points.clear();
        for &k in &*active {
            let (place, near) = (first + k as usize, &mut near[k as usize]);
            let ball = &balls.list[place];
            if near.rest(ball.position, nearness) < 0.0 {
                near.find(ball.position, ball.radius + encounter.laws.reach(ball.radius), nearness);
            }
            let Some(lists) = &mut near.lists else { continue };
            let (touched, first_contact) = (!lists.histories.is_empty(), touches.contacts.len());
            touches.totals = SurfaceTotals::default();
            match encounter.press(ball, &lists.facets, &mut lists.histories, scratch, touches) {
                Ok([force, moment]) if touched || !lists.histories.is_empty() => {
                    let SurfaceTotals { dissipated, work, .. } = touches.totals;
                    let place = place as u32;
                    outer.push(Outer { place, force, moment, dissipated, external: -work });
                    totals.push((ball.number, touches.totals));
                }
                Ok(_) => {}
                Err(error) => *wrong = Some(error),
            }
            for contact in &touches.contacts[first_contact..] {
                *deepest = deepest.or(Depth::of(contact.overlap, ball));
            }
        }
    }
}
