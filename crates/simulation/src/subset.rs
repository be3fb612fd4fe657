//! A part of a model: some of its elements, with all that acts on them.

use std::collections::BTreeSet;

use fdem_mesh::Mesh;

use crate::compiled::compiled;
use crate::error::ModelError;
use crate::faces::Faces;
use crate::model::{Load, Model, Target};
use crate::simplex::Simplex;
use crate::topology::{NONE, Topology};

/// A part of a model: see [`Model::keeping`].
#[derive(Clone, Debug)]
pub struct Subset<const D: usize = 2, const N: usize = 3> {
    /// The part.
    pub model: Model<D, N>,
    /// Number in the whole model of each of its elements, ascending.
    pub elements: Vec<u32>,
    /// Number in the part of each node of the whole model; `None` for one that is not in it.
    pub nodes: Vec<Option<u32>>,
}

impl<const D: usize, const N: usize> Model<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The part of this model with the elements that `keep` has. Boundaries act on the remaining nodes and
    /// facets, and boundaries without remaining ones are left out. Bodies and materials keep their numbers.
    ///
    /// # Errors
    /// The errors of the mesh: see [`ModelError`]. [`ModelError::Length`] if `keep` has not an entry for each
    /// element.
    pub fn keeping(&self, keep: &[bool]) -> Result<Subset<D, N>, ModelError> {
        let model = self;
        compiled!((model: reference [Model<2, 3>, Model<3, 4>], keep: as_is [&[bool], &[bool]])
            -> [Result<Subset<2, 3>, ModelError>, Result<Subset<3, 4>, ModelError>] = Model::part)
    }

    fn part(&self, keep: &[bool]) -> Result<Subset<D, N>, ModelError> {
        let mesh = &self.mesh;
        let expected = mesh.elements.len();
        if keep.len() != expected {
            return Err(ModelError::Length { what: "kept elements", found: keep.len(), expected });
        }
        let elements: Vec<u32> =
            (0..).zip(keep).filter(|(_, keep)| **keep).map(|(element, _)| element).collect();
        let mut used = vec![false; mesh.nodes.len()];
        for &node in elements.iter().flat_map(|&element| &mesh.elements[element as usize]) {
            used[node as usize] = true;
        }
        let mut count = 0;
        let nodes: Vec<Option<u32>> = used
            .iter()
            .map(|used| {
                let number = used.then_some(count);
                count += u32::from(*used);
                number
            })
            .collect();
        let number = |node: u32| nodes[node as usize].unwrap_or(NONE);
        let of_elements = |element: &u32| *element as usize;
        let part = Mesh {
            nodes: mesh.nodes.iter().zip(&used).filter(|(_, used)| **used).map(|(node, _)| *node).collect(),
            elements: elements
                .iter()
                .map(|element| mesh.elements[of_elements(element)].map(number))
                .collect(),
            bodies: elements.iter().map(|element| mesh.bodies[of_elements(element)]).collect(),
            materials: elements.iter().map(|element| mesh.materials[of_elements(element)]).collect(),
        };
        // The surface of the part, if a boundary acts on facets.
        let mut surface = BTreeSet::new();
        if self.boundaries.iter().any(|boundary| !boundary.target.facets().is_empty()) {
            let topology = Topology::<D, N>::of(&part)?;
            surface.extend(Faces::new(&topology).outer.into_iter().map(|side| {
                let mut vertices = side.map(|corner| topology.vertices[corner as usize]);
                vertices.sort_unstable();
                vertices
            }));
        }
        let outer = |facet: &[u32; D]| {
            let mut facet = facet.map(number);
            facet.sort_unstable();
            surface.contains(&facet)
        };
        let velocities =
            self.velocities.iter().zip(&used).filter(|(_, used)| **used).map(|(v, _)| *v).collect();
        let stresses = part_of(&self.stresses, &elements);
        let joint_facets = part_of(&self.joint_facets, &elements);
        let mass_factors = part_of(&self.mass_factors, &elements);
        let mut rigid = self.rigid.clone();
        if !rigid.is_empty() {
            let left: BTreeSet<u32> = part.bodies.iter().copied().collect();
            rigid.retain(|body| left.contains(body));
        }
        let mut until_overloaded = self.until_overloaded.clone();
        until_overloaded.retain(|of| rigid.binary_search(&of.body).is_ok());
        let mut model = Self {
            mesh: part,
            velocities,
            stresses,
            joint_facets,
            mass_factors,
            rigid,
            until_overloaded,
            ..self.clone()
        };
        let renumber = |facets: &mut Vec<[u32; D]>| {
            for facet in facets {
                *facet = facet.map(number);
            }
        };
        for boundary in &mut model.boundaries {
            match &mut boundary.target {
                Target::Nodes(all) => *all = all.iter().filter_map(|&node| nodes[node as usize]).collect(),
                // A cavity may begin with open joints, which are facets between elements.
                Target::Facets(facets) if matches!(boundary.load, Load::Cavity { .. }) => {
                    facets.retain(|facet| facet.iter().all(|&node| nodes[node as usize].is_some()));
                    renumber(facets);
                }
                Target::Facets(facets) => {
                    facets.retain(outer);
                    renumber(facets);
                }
                Target::Held(facets, forces) => {
                    let is_left: Vec<bool> = facets.iter().map(outer).collect();
                    let mut left = is_left.iter();
                    forces.retain(|_| left.next().copied().unwrap_or_default());
                    facets.retain(outer);
                    renumber(facets);
                }
            }
        }
        model.fluid = model.fluid.map(|fluid| fluid.on_part(&nodes));
        model.pores = model.pores.map(|pores| pores.on_part(&nodes));
        model.boundaries.retain(|boundary| !boundary.target.is_empty());
        Ok(Subset { model, elements, nodes })
    }
}

/// The values of some elements in a column that may be empty.
fn part_of<T: Copy>(column: &[T], elements: &[u32]) -> Vec<T> {
    elements.iter().filter_map(|&element| column.get(element as usize).copied()).collect()
}
