//! The contacts of all spheres with one surface of facets: a wall's mesh, or the surface of bodies.
//!
//! Each sphere keeps a list of facets near it. The list holds while the sphere and the points of the surface
//! have moved by no more than its slack; then the tree of boxes finds a new one. Results do not depend on the
//! lists. Spheres are computed in chunks on all threads; sums over spheres are in the order of the spheres'
//! places, and those over the points of a body in the order of the points and then of the spheres' numbers.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::facet::of_facet;
use crate::law::PairLaw;
use crate::on_facet::{
    Ball, Encounter, FacetContact, FacetHistory, FacetScratch, SurfaceMotion, SurfaceTotals, Touches,
};
use crate::ridges::Ridges;
use crate::sheets::Facets;
use crate::tree::Tree;
use crate::vector::{Vector, length, minus, plus};

/// Spheres that one thread computes at a time.
const CHUNK: usize = 512;

/// Movements for which a list of facets is made, as a share of the mean radius of the spheres.
const SKIN: f64 = 0.2;

/// Share of that which the points of a surface may use.
const POINTS: f64 = 0.4;

/// Skins up to which the distance of a sphere from the surface is measured.
const HORIZON: f64 = 20.0;

/// All spheres.
pub(crate) trait Balls: Sync {
    fn count(&self) -> usize;
    fn number(&self, place: usize) -> u32;
    fn position(&self, place: usize) -> Vector;
    fn radius(&self, place: usize) -> f64;
    fn ball(&self, place: usize) -> Ball;
}

/// The facets near a sphere.
#[derive(Clone, Debug)]
struct NearFacets {
    /// Where the sphere was, m, and how far points had moved, when the list was made.
    reference: Vector,
    moved: f64,
    /// Movements, m, for which the list holds.
    slack: f64,
    /// The list and the histories; `None` for a sphere that is far from the surface.
    lists: Option<Box<Lists>>,
}

#[derive(Clone, Debug, Default)]
struct Lists {
    facets: Vec<u32>,
    histories: Vec<FacetHistory>,
}

/// Forces and moments on spheres: the place of the sphere, N and N m.
type OnSphere = (u32, [Vector; 2]);

/// Spheres that one thread computes, and their results.
#[derive(Clone, Debug, Default)]
struct Chunk {
    near: Vec<NearFacets>,
    scratch: FacetScratch,
    on_spheres: Vec<OnSphere>,
    touches: Touches,
    /// Sums over the contacts of each sphere, by its number.
    totals: Vec<(u32, SurfaceTotals)>,
    wrong: Option<[u32; 2]>,
}

/// A surface of facets, and the spheres near it.
#[derive(Clone, Debug, Default)]
pub(crate) struct OnSurface {
    points: Vec<Vector>,
    corners: Vec<[u32; 3]>,
    ridges: Ridges,
    is_one_sided: bool,
    tree: Tree,
    /// Points when the tree was made, and how far one of them has moved since, m.
    reference: Vec<Vector>,
    moved: f64,
    skin: f64,
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

/// Laws of all pairs of materials, their number, and the time step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Laws<'a> {
    pub(crate) pairs: &'a [Option<PairLaw>],
    pub(crate) kinds: usize,
    /// Whether spheres may touch beyond their radius.
    pub(crate) sticks: bool,
    /// s.
    pub(crate) step: f64,
}

impl OnSurface {
    /// A surface that no sphere has touched; `radius`: mean radius of the spheres, m.
    pub(crate) fn new(is_one_sided: bool, radius: f64) -> Self {
        Self { is_one_sided, skin: SKIN * radius, ..Self::default() }
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
                crate::vector::dot(gone, gone)
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
        }
    }

    /// Computes the contacts of all spheres.
    ///
    /// # Errors
    /// Two materials that touch and have no law.
    pub(crate) fn press(
        &mut self,
        balls: &impl Balls,
        materials: &[u32],
        motion: SurfaceMotion<'_>,
        direction: Option<Vector>,
        laws: Laws<'_>,
    ) -> Result<(), [u32; 2]> {
        self.resize(balls.count());
        let Self { points, corners, ridges, is_one_sided, chunks, tree, moved, skin, .. } = self;
        let Laws { pairs: laws, kinds, step, .. } = laws;
        let facets = Facets { points, corners, ridges, is_one_sided: *is_one_sided };
        let encounter = Encounter { facets, motion, materials, laws, kinds, direction, step };
        let nearness = Nearness { tree, facets, moved: *moved, skin: *skin };
        chunks.par_iter_mut().enumerate().for_each(|(number, chunk)| {
            chunk.press(number * CHUNK, balls, &encounter, &nearness);
        });
        self.add_up();
        match self.chunks.iter().find_map(|chunk| chunk.wrong) {
            Some(materials) => Err(materials),
            None => Ok(()),
        }
    }

    /// Forgets the contacts of the last step: no surface is there.
    pub(crate) fn leave(&mut self) {
        if !self.corners.is_empty() {
            *self = Self { is_one_sided: self.is_one_sided, skin: self.skin, ..Self::default() };
        }
    }

    /// Force, N, and moment, N m, on spheres in the last step, in ascending order of their places.
    pub(crate) fn on_spheres(&self) -> impl Iterator<Item = OnSphere> {
        self.chunks.iter().flat_map(|chunk| chunk.on_spheres.iter().copied())
    }

    /// Elastic energy of the contacts, J, with the points of the surface at other places, m.
    pub(crate) fn elastic(
        &self,
        balls: &impl Balls,
        points: &[Vector],
        materials: &[u32],
        laws: Laws<'_>,
    ) -> f64 {
        let Laws { pairs: laws, kinds, step, .. } = laws;
        let facets =
            Facets { points, corners: &self.corners, ridges: &self.ridges, is_one_sided: self.is_one_sided };
        let motion = SurfaceMotion::Points(&[]);
        let encounter = Encounter { facets, motion, materials, laws, kinds, direction: None, step };
        let mut scratch = FacetScratch::default();
        let near = self.chunks.iter().flat_map(|chunk| &chunk.near).enumerate();
        let touching = near.filter_map(|(place, near)| Some((place, near.lists.as_ref()?)));
        let mut energies: Vec<(u32, f64)> = Vec::new();
        for (place, lists) in touching.filter(|(_, lists)| !lists.histories.is_empty()) {
            let ball = balls.ball(place);
            let energy = encounter.elastic(&ball, &lists.facets, &lists.histories, &mut scratch);
            energies.push((ball.number, energy));
        }
        energies.sort_by_key(|(sphere, _)| *sphere);
        energies.iter().map(|(_, energy)| energy).sum()
    }

    /// The memory of the contacts of each sphere that touches, by its number.
    pub(crate) fn state(&self, balls: &impl Balls) -> Vec<(u32, Vec<FacetHistory>)> {
        let all = self.chunks.iter().flat_map(|chunk| &chunk.near).enumerate();
        let of = |(place, near): (usize, &NearFacets)| {
            let histories = &near.lists.as_ref()?.histories;
            (!histories.is_empty()).then(|| (balls.number(place), histories.clone()))
        };
        let mut state: Vec<_> = all.filter_map(of).collect();
        state.sort_by_key(|(sphere, _)| *sphere);
        state
    }

    /// Continues the contacts of a state.
    pub(crate) fn restore(&mut self, state: Vec<(u32, Vec<FacetHistory>)>, balls: &impl Balls) {
        self.chunks.clear();
        self.resize(balls.count());
        let state: BTreeMap<u32, Vec<FacetHistory>> = state.into_iter().collect();
        for place in 0..balls.count() {
            if let Some(histories) = state.get(&balls.number(place)) {
                let near = &mut self.chunks[place / CHUNK].near[place % CHUNK];
                near.lists = Some(Box::new(Lists { histories: histories.clone(), ..Lists::default() }));
            }
        }
    }

    fn resize(&mut self, count: usize) {
        if self.chunks.iter().map(|chunk| chunk.near.len()).sum::<usize>() == count {
            return;
        }
        self.chunks.resize_with(count.div_ceil(CHUNK), Chunk::default);
        for (number, chunk) in self.chunks.iter_mut().enumerate() {
            chunk.near.resize(CHUNK.min(count - number * CHUNK), NearFacets::UNKNOWN);
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
}

impl NearFacets {
    const UNKNOWN: Self = Self { reference: [0.0; 3], moved: 0.0, slack: -1.0, lists: None };

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
            None => self.lists = Some(Box::new(Lists { facets, histories: Vec::new() })),
        }
    }
}

impl Chunk {
    /// Computes the contacts of the spheres of this chunk, the first of which has a place.
    fn press(
        &mut self,
        first: usize,
        balls: &impl Balls,
        encounter: &Encounter<'_>,
        nearness: &Nearness<'_>,
    ) {
        let Self { near, scratch, on_spheres, touches, totals, wrong } = self;
        on_spheres.clear();
        totals.clear();
        touches.contacts.clear();
        touches.on_points.clear();
        *wrong = None;
        for (k, near) in near.iter_mut().enumerate() {
            let place = first + k;
            let centre = balls.position(place);
            let gone = length(minus(centre, near.reference));
            if gone + nearness.moved + near.moved > near.slack {
                let radius = balls.radius(place);
                near.find(centre, radius + encounter.stickiness(radius), nearness);
            }
            let Some(lists) = &mut near.lists else { continue };
            let (ball, touched) = (balls.ball(place), !lists.histories.is_empty());
            touches.totals = SurfaceTotals::default();
            match encounter.press(&ball, &lists.facets, &mut lists.histories, scratch, touches) {
                Ok(on_sphere) if !lists.histories.is_empty() => on_spheres.push((place as u32, on_sphere)),
                Ok(_) => {}
                Err(materials) => *wrong = wrong.or(Some(materials)),
            }
            if touched || !lists.histories.is_empty() {
                totals.push((ball.number, touches.totals));
            }
        }
    }
}
