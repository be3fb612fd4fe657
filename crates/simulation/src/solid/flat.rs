//! The columns of a solid as plain lists, for machines with a memory of their own.

use crate::accelerator::{BY_HOST, FlatBedding, HeldNode, SolidColumns, SolidState};
use crate::lanes::{LANES, set_tensor, tensor};
use crate::laws::AnyLaw;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::NONE;
use crate::vector::{Matrix, product};

impl<const D: usize, const N: usize> Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The columns that phases do not change. `holds`: the motions that boundaries prescribe, by the numbers
    /// of [`Solid::hold`].
    pub(crate) fn flat(&self, holds: &[HeldNode<D>]) -> SolidColumns<D, N> {
        let (nodes, elements) = (0..self.node_count(), 0..self.element_count());
        let mut held = Vec::new();
        let mut place = |node: usize| {
            if self.rigid.has_node(node) {
                return Some(BY_HOST);
            }
            let hold = holds.get(self.hold(node) as usize)?;
            held.push(HeldNode { node: node as u32, ..*hold });
            Some(held.len() as u32 - 1)
        };
        let places = nodes.clone().map(|node| place(node).unwrap_or(NONE)).collect();
        let law = |law: &AnyLaw<D>| match law {
            AnyLaw::NeoHookean(moduli) => {
                ([moduli.shear, moduli.bulk], FlatBedding { rest: [0.0; 5], normal: [0.0; D] })
            }
            AnyLaw::Bedded(bedded) => bedded.flat(),
        };
        let (moduli, beddings): (Vec<_>, Vec<_>) = self.constitutions.iter().map(|of| law(&of.law)).unzip();
        let material = |element: usize| self.elements[element].material;
        let viscosity = |(element, height): (usize, &f64)| {
            self.constitutions[material(element) as usize].viscosity * height
        };
        SolidColumns {
            origin: self.origin,
            masses: self.constants.iter().map(|of| of.mass).collect(),
            true_masses: self.true_masses.clone(),
            places,
            held,
            elements: self.corners.of_corner.clone(),
            corners: self.corners.list().to_vec(),
            ranges: nodes.map(|node| self.corners.range(node)).collect(),
            gradients: elements.clone().map(|element| self.inverse_edges(element)).collect(),
            volumes: elements.clone().map(|e| self.undeformed[e / LANES].volume.get(e % LANES)).collect(),
            moduli,
            beddings: if self.has_bedding() { beddings } else { Vec::new() },
            materials: elements.map(material).collect(),
            viscosities: self.heights.iter().enumerate().map(viscosity).collect(),
            initial: self.prestress.iter().map(|of| of.stress).collect(),
            stored: self.prestress.iter().map(|of| of.energy).collect(),
        }
    }

    /// The values that phases change.
    pub(crate) fn flat_state(&self) -> SolidState<D, N> {
        let elements = 0..self.element_count();
        let is_viscous = !self.heights.is_empty();
        let normal = |element: usize| {
            let mut memory = self.memory_of(element);
            std::array::from_fn(|_| memory.next().unwrap_or_default())
        };
        let normals = elements.clone().map(normal);
        SolidState {
            positions: self.positions.clone(),
            velocities: self.velocities.clone(),
            forces: self.forces.clone(),
            stresses: elements.clone().map(|element| self.stress(element)).collect(),
            energies: elements.map(|element| self.energy(element)).collect(),
            viscous: if is_viscous { self.viscous() } else { Vec::new() },
            dissipated: if is_viscous { self.dissipated() } else { Vec::new() },
            normals: if self.has_bedding() { normals.collect() } else { Vec::new() },
        }
    }

    /// Takes these values over.
    pub(crate) fn take_flat(&mut self, state: SolidState<D, N>) {
        for (number, energy) in state.energies.iter().enumerate() {
            self.deformed[number / LANES].energy.set(number % LANES, *energy);
        }
        for (number, viscous) in state.viscous.iter().enumerate() {
            set_tensor(&mut self.histories[number / LANES].viscous, number % LANES, viscous);
        }
        for (number, dissipated) in state.dissipated.iter().enumerate() {
            self.histories[number / LANES].dissipated.set(number % LANES, *dissipated);
        }
        for (number, normal) in state.normals.iter().enumerate() {
            self.histories[number / LANES].set_memory(number % LANES, normal);
        }
        for (number, stress) in state.stresses.iter().enumerate() {
            self.deformed[number / LANES].set_stress(number % LANES, stress);
        }
        (self.positions, self.velocities, self.forces) = (state.positions, state.velocities, state.forces);
    }

    /// The first element whose volume is not positive at the present positions, with its ratio of deformed to
    /// undeformed volume.
    pub(crate) fn first_inverted(&self) -> Option<(u32, f64)> {
        let ratio = |element: u32| {
            let batch = &self.undeformed[element as usize / LANES];
            let gradients: Matrix<D> = tensor(&batch.gradients, element as usize % LANES);
            let edges = <[[f64; D]; N]>::edges(&self.shape(element));
            <[[f64; D]; N]>::determinant(&product(&edges, &gradients))
        };
        let all = (0..self.element_count() as u32).map(|element| (element, ratio(element)));
        all.into_iter().find(|(_, ratio)| *ratio <= 0.0 || ratio.is_nan())
    }

    /// Whether a material has bedding.
    fn has_bedding(&self) -> bool {
        self.constitutions.iter().any(|of| matches!(of.law, AnyLaw::Bedded(_)))
    }
}
