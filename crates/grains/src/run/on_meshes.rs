//! Contacts of spheres with walls that are meshes.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::columns::{GrainContact, GrainPartner};
use crate::error::GrainError;
use crate::facet::by_place;
use crate::run::depth::Depth;
use crate::run::on_facet::{SurfaceMotion, SurfaceTotals};
use crate::run::on_surface::{OnFacets, OnSurface, OnSurfacesOf};
use crate::run::on_walls::Outer;
use crate::servo::ServoMotion;
use crate::vector::{Vector, cross, minus};
use crate::wall::{Wall, WallShape};

/// Points that one thread moves at a time.
const CHUNK: usize = 512;

/// A wall that is a mesh.
#[derive(Debug)]
struct WallMesh {
    wall: usize,
    /// Points at the beginning, and now, m.
    first: Vec<Vector>,
    now: Vec<Vector>,
    corners: Vec<[u32; 3]>,
    moves: bool,
    on: OnSurface,
}

/// All walls that are meshes.
#[derive(Debug, Default)]
pub(crate) struct OnMeshes {
    list: Vec<WallMesh>,
}

/// A place as a key.
#[derive(Clone, Copy, Debug)]
struct PointKey(Vector);

impl Ord for PointKey {
    fn cmp(&self, other: &Self) -> Ordering {
        by_place(self.0, other.0)
    }
}

impl PartialOrd for PointKey {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for PointKey {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for PointKey {}

impl WallMesh {
    fn new(wall: usize, triangles: &[[Vector; 3]], moves: bool, radius: f64) -> Self {
        // Corners at one place are one; -0 is 0.
        let mut numbers: BTreeMap<PointKey, u32> = BTreeMap::new();
        let mut first = Vec::new();
        let mut corners = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            corners.push(triangle.map(|corner| {
                let place = corner.map(|x| x + 0.0);
                *numbers.entry(PointKey(place)).or_insert_with(|| {
                    first.push(place);
                    first.len() as u32 - 1
                })
            }));
        }
        let mut on = OnSurface::new(false, radius);
        on.place(&first, &corners);
        Self { wall, now: first.clone(), first, corners, moves, on }
    }

    /// Puts the points where the wall is at a time, s.
    fn place(&mut self, wall: &Wall, servo: &ServoMotion, time: f64) {
        let Self { first, now, corners, moves, on, .. } = self;
        if *moves {
            let placement = wall.placement(time, servo);
            now.par_iter_mut().zip(&*first).with_min_len(CHUNK).for_each(|(now, first)| {
                *now = placement.of(*first);
            });
        }
        on.place(now, corners);
    }
}

impl OnMeshes {
    /// `radius`: mean radius of the spheres, m.
    pub(crate) fn new(walls: &[Wall], radius: f64) -> Self {
        let mesh = |(number, wall): (usize, &Wall)| match &wall.shape {
            WallShape::Mesh { triangles } => Some(WallMesh::new(number, triangles, wall.moves(), radius)),
            _ => None,
        };
        Self { list: walls.iter().enumerate().filter_map(mesh).collect() }
    }

    /// Puts all meshes where they are at a time, s.
    pub(crate) fn place(&mut self, walls: &[Wall], servos: &[ServoMotion], time: f64) {
        for mesh in &mut self.list {
            mesh.place(&walls[mesh.wall], &servos[mesh.wall], time);
        }
    }

    /// Computes the contacts of a step with meshes in their places, and adds their actions to `outer`.
    /// `walls`: at the beginning, `placed`: where they are.
    ///
    /// # Errors
    /// [`GrainError::UnknownSurfaces`] if two materials touch that have no law.
    pub(crate) fn press(
        &mut self,
        of: OnSurfacesOf<'_>,
        (walls, placed): (&[Wall], &[Wall]),
        outer: &mut Vec<Outer>,
    ) -> Result<(), GrainError> {
        for mesh in &mut self.list {
            let wall = &walls[mesh.wall];
            let motion = SurfaceMotion::Wall(&placed[mesh.wall]);
            let direction = wall.servo.map(|servo| servo.unit());
            mesh.on.press(of, (motion, &[wall.material]), direction, outer)?;
        }
        Ok(())
    }

    /// The number of each wall that is a mesh, with the sums of its contacts in the last step.
    pub(crate) fn totals(&self) -> impl Iterator<Item = (usize, &SurfaceTotals)> {
        self.list.iter().map(|mesh| (mesh.wall, &mesh.on.totals))
    }

    /// Elastic energy of the contacts in the last step, J.
    pub(crate) fn elastic(&self) -> f64 {
        self.list.iter().map(|mesh| mesh.on.totals.elastic).sum()
    }

    /// Contacts in the last step; spheres by their numbers.
    pub(crate) fn contacts(&self) -> impl Iterator<Item = GrainContact> {
        self.list
            .iter()
            .flat_map(|mesh| mesh.on.contacts.iter().map(|of| of.named(GrainPartner::Wall(mesh.wall as u32))))
    }

    /// The deepest contact of the last step.
    pub(crate) fn deepest(&self) -> Depth {
        self.list.iter().map(|mesh| mesh.on.deepest()).fold(Depth::default(), Depth::or)
    }

    /// Puts the triangles of the meshes into walls that are in their places.
    pub(crate) fn fill(&self, walls: &mut [Wall]) {
        for mesh in &self.list {
            let triangles =
                mesh.corners.iter().map(|corners| corners.map(|p| mesh.now[p as usize])).collect();
            walls[mesh.wall].shape = WallShape::Mesh { triangles };
        }
    }

    /// Whether a sphere, by its centre, m, and its radius, m, touches no mesh in its place.
    pub(crate) fn is_clear(&self, centre: Vector, radius: f64) -> bool {
        self.list.iter().all(|mesh| mesh.on.is_clear(centre, radius))
    }

    /// The memory of all contacts, by meshes.
    pub(crate) fn saved(&self) -> Vec<OnFacets> {
        self.list.iter().map(|mesh| mesh.on.saved()).collect()
    }

    /// Takes the memory of a saved run over. Returns whether it has as many meshes.
    pub(crate) fn take(&mut self, saved: Vec<OnFacets>) -> bool {
        if saved.len() != self.list.len() {
            return false;
        }
        for (mesh, saved) in self.list.iter_mut().zip(saved) {
            mesh.on.take(saved);
        }
        true
    }
}

/// Force on a wall, N, and its moment about the axis of its rotation, or about the origin, N m.
pub(crate) fn force_and_moment(totals: &SurfaceTotals, wall: &Wall) -> [Vector; 2] {
    let centre = wall.rotation.map_or([0.0; 3], |rotation| rotation.through);
    [totals.force, minus(totals.moment, cross(centre, totals.force))]
}
