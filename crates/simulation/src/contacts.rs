//! Contacts between bodies: couples that may touch, and their forces.
//!
//! A kind of bodies (`bodies.rs`) has parts that can touch. For each pair of kinds there are [`Couples`],
//! whose detection, sleep, histories, and resume are written once (`contacts/couples.rs`). Each pair adds its
//! forces (`contacts/pair.rs`) and a line to the functions of [`Contacts`]. The first pair is that of
//! elements with elements (`contacts/elements.rs`).

mod chunk;
mod couples;
mod elements;
mod flat;
mod law;
mod pair;
mod places;
mod saved;
mod surface;

pub(crate) use crate::contacts::couples::Touching;
pub use crate::contacts::elements::single::{ContactCase, press_tetrahedra, press_triangles};
pub(crate) use crate::contacts::law::{penalty_and_friction, stiffness};
pub(crate) use crate::contacts::saved::SavedContacts;
pub(crate) use crate::contacts::surface::Surface;

use crate::contacts::couples::Couples;
use crate::contacts::elements::{ElementPair, ElementPass};
use crate::contacts::law::ContactLaws;
use crate::contacts::pair::Overlap;
use crate::error::{ModelError, Stop};
use crate::faces::Faces;
use crate::forces::ContactForce;
use crate::joints::{JointState, Joints};
use crate::model::{InitialOverlap, Model};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::{Solid, corners_of};
use crate::team::Team;
use crate::topology::{NONE, Topology};
use crate::vector::Point;

impl InitialOverlap {
    /// The way in which couples begin whose bodies overlap.
    fn of_couples(self) -> Overlap {
        match self {
            Self::Push | Self::Error => Overlap::Counts,
            Self::Ignore => Overlap::Ignored,
            Self::Relax => Overlap::Relaxing,
        }
    }
}

/// Couples of all pairs of kinds of bodies.
#[derive(Clone, Debug)]
pub(crate) struct Contacts<const D: usize = 2, const N: usize = 3> {
    laws: ContactLaws<N>,
    /// Elements that can touch.
    pub(crate) surface: Surface,
    /// The way in which couples of new elements begin.
    initial_overlap: Overlap,
    /// Couples of two elements.
    elements: Couples<D, ElementPair<D, N>>,
}

impl<const D: usize, const N: usize> Contacts<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// `edge`: mean length of the edges of the whole model, m.
    pub(crate) fn new(
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        faces: &Faces<D>,
        edge: f64,
        team: &Team,
    ) -> Result<Self, ModelError> {
        let mut surface = Surface::new(topology, faces);
        let initial_overlap = model.contact.initial_overlap.of_couples();
        if initial_overlap != Overlap::Counts {
            surface.begin();
        }
        Ok(Self {
            laws: ContactLaws::new(model),
            surface,
            initial_overlap,
            elements: Couples::new(model.contact.buffer * edge, team)?,
        })
    }

    /// Memory of the properties of elements, bytes; without couples and without the search.
    pub(crate) fn bytes(&self) -> usize {
        self.laws.bytes() + self.surface.bytes()
    }

    /// Updates the couples as far as motion and broken joints require.
    pub(crate) fn detect(
        &mut self,
        solid: &Solid<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Result<(), Stop> {
        self.watch_bare(joints, topology);
        let chooses = self.look(solid, joints, topology, team)?;
        self.renew(solid, joints, topology, chooses, team);
        Ok(())
    }

    /// Updates the search with the present positions of the watched elements, as far as motion requires.
    /// Returns whether couples are to be chosen. The bare elements must be watched before.
    pub(crate) fn look(
        &mut self,
        solid: &Solid<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Result<bool, Stop> {
        let Self { laws, surface, elements, .. } = self;
        elements.look(&ElementPass { solid, joints, topology, surface, laws }, team)
    }

    /// Chooses the couples anew if the search asks for it, and adds those of elements that have separated.
    pub(crate) fn renew(
        &mut self,
        solid: &Solid<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
        chooses: bool,
        team: &Team,
    ) {
        let Self { laws, surface, initial_overlap, elements } = self;
        let pass = ElementPass { solid, joints, topology, surface, laws };
        if chooses {
            elements.choose_near(&pass, team);
        }
        elements.add(pass.parted());
        if !surface.bared.is_empty() {
            elements.note_overlaps(Overlap::Credited, |pair| surface.has_bared(*pair));
        }
        if !surface.new.is_empty() {
            elements.note_overlaps(*initial_overlap, |pair| surface.has_new(*pair));
        }
        surface.parted.clear();
        surface.bared.clear();
        surface.new.clear();
    }

    /// Watches all bare elements, and those beside them.
    pub(crate) fn watch_bare(&mut self, joints: &Joints<D>, topology: &Topology<D, N>) {
        if self.surface.watch_bare(joints, topology) {
            self.elements.search_again();
        }
    }

    /// Whether [`Contacts::detect`] has anything to do.
    pub(crate) fn is_detection_due(&self) -> bool {
        self.surface.unwatched || self.is_renewed() || self.elements.is_due()
    }

    /// Whether couples change because elements have separated, become bare, or are new.
    pub(crate) fn is_renewed(&self) -> bool {
        let Surface { parted, bared, new, .. } = &self.surface;
        !(parted.is_empty() && bared.is_empty() && new.is_empty())
    }

    /// The elements whose positions the next [`Contacts::look`] reads, ascending.
    pub(crate) fn looked_at(&self) -> &[u32] {
        if self.elements.is_due() { &self.surface.list } else { &[] }
    }

    /// Whether any couple touches, or is not known to be apart.
    pub(crate) fn any_near(&self) -> bool {
        self.elements.any_near()
    }

    /// Adds the distance of the fastest point of a body in a step, m.
    pub(crate) fn note_motion(&mut self, distance: f64) {
        self.elements.note_motion(distance);
    }

    /// Number of detections so far.
    pub(crate) fn detections(&self) -> u64 {
        self.elements.detections
    }

    /// Continues to count detections.
    pub(crate) fn set_detections(&mut self, count: u64) {
        self.elements.detections = count;
    }

    /// Computes the forces of all couples, and adds them to those of bodies. `energy`: whether to compute the
    /// energy of the contacts.
    pub(crate) fn press(
        &mut self,
        solid: &mut Solid<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
        step: f64,
        energy: bool,
        team: &Team,
    ) -> Touching {
        let Self { laws, surface, elements, .. } = self;
        solid.with_forces(|solid, forces| {
            let pass = ElementPass { solid, joints, topology, surface, laws };
            elements.press(&pass, forces, step, solid.grains, energy, team)
        })
    }

    /// Forces of the couples that touch, at the points where their parts overlap now.
    pub(crate) fn forces(
        &self,
        solid: &Solid<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
    ) -> Vec<ContactForce<D>> {
        let Self { laws, surface, elements, .. } = self;
        elements.forces(&ElementPass { solid, joints, topology, surface, laws })
    }

    /// The elements that touch others, with repetitions.
    pub(crate) fn touching(&self, team: &Team) -> Vec<u32> {
        self.elements.touching_parts(team)
    }

    /// The elements that touch, with the force on the first of each couple, N.
    pub(crate) fn pushes(&self) -> impl Iterator<Item = ([u32; 2], Point<D>)> {
        self.elements.touching().map(|(elements, grip)| (elements, grip.push))
    }

    /// The elements that touch, with the time that each couple takes in a step, in the unit of
    /// `ranks/spread.rs`.
    pub(crate) fn costs(&self) -> impl Iterator<Item = ([u32; 2], u64)> {
        self.elements.costs()
    }

    /// State of the contacts for a saved run.
    pub(crate) fn save(&self) -> SavedContacts<D, N> {
        self.save_counted(|_| true)
    }

    /// State of the contacts for other ranks, as far as this rank counts it: `counts` says of which elements
    /// it counts the couples.
    pub(crate) fn save_counted(&self, counts: impl Fn(u32) -> bool) -> SavedContacts<D, N> {
        SavedContacts {
            grips: self.elements.touching().filter(|(elements, _)| counts(elements[0])).collect(),
            parted: self.surface.parted.clone(),
            bared: self.surface.bared.clone(),
            new: self.surface.new.clone(),
        }
    }

    /// Restores the saved contacts. The joints must be restored before.
    pub(crate) fn restore(
        &mut self,
        saved: SavedContacts<D, N>,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
    ) {
        let broken: Vec<u32> = (0..joints.all.len() as u32)
            .filter(|&joint| joints.all[joint as usize].state != JointState::Holding)
            .collect();
        self.surface.part(&broken, joints, topology, &Share::default());
        self.restore_couples(saved);
    }

    /// Restores the couples that touch, and the elements that have separated.
    pub(crate) fn restore_couples(&mut self, saved: SavedContacts<D, N>) {
        (self.surface.parted, self.surface.bared) = (saved.parted, saved.bared);
        self.surface.new = saved.new;
        self.surface.list_parted();
        self.surface.unwatched = true;
        self.elements.restore(saved.grips, NONE);
    }
}

/// Lengths of the facets of all elements, as edges, m.
pub(crate) fn edges<const D: usize, const N: usize>(model: &Model<D, N>) -> impl Iterator<Item = f64>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    (0..model.mesh.elements.len()).flat_map(|element| {
        let corners = corners_of(&model.mesh, element);
        debug_assert!(corners.measure() > 0.0);
        <[[f64; D]; N]>::FACETS.map(|facet| {
            let measure = <[[f64; D]; N]>::facet_measure(&facet.map(|corner| corners[corner]));
            <[[f64; D]; N]>::facet_length(measure)
        })
    })
}

/// Mean length of the facets of all elements, as edges, m.
pub(crate) fn mean_edge<const D: usize, const N: usize>(model: &Model<D, N>) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    edges(model).sum::<f64>() / (N * model.mesh.elements.len().max(1)) as f64
}
