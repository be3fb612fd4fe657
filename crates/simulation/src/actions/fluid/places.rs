//! The places of sources: walls of holes, and joints.

use std::collections::BTreeSet;

use crate::action::Scene;
use crate::actions::cavity::face::{Face, Rim, enclosed, increase, rims};
use crate::actions::fluid::cells::FluidCell;
use crate::actions::fluid::saved::SharedPlace;
use crate::error::ModelError;
use crate::model::{FluidOptions, Model};
use crate::outer_side::outer_side;
use crate::simplex::Simplex;
use crate::sum::Sum;
use crate::topology::{Topology, corners_of_facet};

/// The place of a source.
#[derive(Debug)]
pub(super) struct SourcePlace<const D: usize> {
    pub(super) name: String,
    /// Codes of the sides that are the wall of its hole; empty for joints.
    walls: Vec<u32>,
    /// The corners of those of them whose elements are here.
    pub(super) here: Vec<[u32; D]>,
    /// Rims of the wall: cells that have one of them are connected with the hole.
    rims: BTreeSet<Rim>,
    /// Facets with joints, by ascending vertices.
    joints: BTreeSet<[u32; D]>,
    /// Volume of the undeformed hole, and its last volume, m³.
    pub(super) enclosed: f64,
    pub(super) volume: f64,
}

impl<const D: usize> SourcePlace<D> {
    pub(super) fn is_hole(&self) -> bool {
        !self.walls.is_empty()
    }

    /// Finds the wall among the elements here.
    pub(super) fn locate<const N: usize>(&mut self, topology: &Topology<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let corners = |code: &u32| {
            let element = topology.element(code / N as u32)?;
            Some(corners_of_facet::<D, N>(element as usize, *code as usize % N))
        };
        self.here = self.walls.iter().filter_map(corners).collect();
    }

    /// The volume by which the part of the wall that this rank counts has moved outwards, m³.
    pub(super) fn increase<const N: usize>(&self, scene: &Scene<'_, D, N>) -> Sum
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let is_counted = |corners: &&[u32; D]| scene.solid().share().element(corners[0] / N as u32);
        let faces: Vec<Face<D>> =
            self.here.iter().filter(is_counted).map(|corners| Face::new(*corners, scene.solid())).collect();
        increase(&faces, scene)
    }

    /// Keys of the cells that the source is connected with.
    pub(super) fn keys(&self, cells: &[FluidCell<D>]) -> Vec<u64> {
        let is_of = |cell: &&FluidCell<D>| {
            let mut vertices = cell.vertices;
            vertices.sort_unstable();
            self.joints.contains(&vertices) || rims(vertices).any(|rim| self.rims.contains(&rim))
        };
        cells.iter().filter(is_of).map(FluidCell::key).collect()
    }

    /// The place for other ranks.
    pub(super) fn shared(&self) -> SharedPlace<D> {
        SharedPlace {
            name: self.name.clone(),
            walls: self.walls.clone(),
            rims: self.rims.iter().copied().collect(),
            joints: self.joints.iter().copied().collect(),
            volumes: [self.enclosed, self.volume],
        }
    }

    pub(super) fn of_shared(shared: SharedPlace<D>) -> Self {
        let SharedPlace { name, walls, rims, joints, volumes: [enclosed, volume] } = shared;
        let (rims, joints) = (rims.into_iter().collect(), joints.into_iter().collect());
        Self { name, walls, here: Vec::new(), rims, joints, enclosed, volume }
    }
}

/// The places of the sources of a whole model.
pub(super) fn places_of<const D: usize, const N: usize>(
    options: &FluidOptions<D>,
    model: &Model<D, N>,
    scene: &Scene<'_, D, N>,
) -> Result<Vec<SourcePlace<D>>, ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut places: Vec<SourcePlace<D>> = Vec::new();
    for source in &options.sources {
        let needs = "facets, and a name that no other source of the fluid has";
        let is_known = places.iter().any(|place| place.name == source.name);
        if source.facets.is_empty() || is_known {
            return Err(ModelError::Target { boundary: source.name.clone(), needs });
        }
        let (mut faces, mut rims_of, mut joints) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
        let mut walls = Vec::new();
        for &facet in &source.facets {
            if let Some(&index) = facet.iter().find(|node| **node as usize >= model.mesh.nodes.len()) {
                let place = format!("source of fluid '{}'", source.name);
                return Err(ModelError::Missing { what: "node", index, place });
            }
            match outer_side(model, scene.topology, facet, &source.name) {
                Ok(side) => {
                    walls.push(scene.topology.code_of_side(&side.corners));
                    faces.push(Face::new(side.corners, scene.solid()));
                    rims_of.extend(rims(facet));
                }
                Err(_) if scene.topology.has_facet(&facet) => {
                    let mut vertices = facet;
                    vertices.sort_unstable();
                    joints.insert(vertices);
                }
                Err(error) => return Err(error),
            }
        }
        let value = enclosed(&faces, scene);
        if !walls.is_empty() && value <= 0.0 {
            let place = format!("source of fluid '{}'", source.name);
            let range = "above 0: the facets of its hole enclose it";
            return Err(ModelError::OutOfRange { place, what: "the volume", value, range });
        }
        let name = source.name.clone();
        let here = Vec::new();
        places.push(SourcePlace { name, walls, here, rims: rims_of, joints, enclosed: value, volume: 0.0 });
    }
    Ok(places)
}
