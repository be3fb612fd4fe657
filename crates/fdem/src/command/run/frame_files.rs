//! The files of a frame: their names, and the collections of them that ParaView opens.

use fdem_model::Prepared;
use serde::{Deserialize, Serialize};

/// The folder of frames.
pub(crate) const FRAMES: &str = "frames";

/// A file of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum FrameFile {
    Mesh,
    Cracks,
    DamagedJoints,
    Contacts,
    IntactJoints,
    Spheres,
    SphereContacts,
    Walls,
    Coarse,
    /// For the report.
    Packed,
}

impl FrameFile {
    /// All of them, in the order in which a frame writes them.
    pub(crate) const ALL: [Self; 10] = [
        Self::Mesh,
        Self::Cracks,
        Self::DamagedJoints,
        Self::Contacts,
        Self::IntactJoints,
        Self::Spheres,
        Self::SphereContacts,
        Self::Walls,
        Self::Coarse,
        Self::Packed,
    ];

    /// The name of its collection, if it has one, and the end of its own name.
    const fn names(self) -> (Option<&'static str>, &'static str) {
        match self {
            Self::Mesh => (Some("results.pvd"), ".vtu"),
            Self::Cracks => (Some("cracks.pvd"), "_cracks.vtp"),
            Self::DamagedJoints => (Some("damaged_joints.pvd"), "_damaged_joints.vtp"),
            Self::Contacts => (Some("contacts.pvd"), "_contacts.vtp"),
            Self::IntactJoints => (Some("intact_joints.pvd"), "_intact_joints.vtp"),
            Self::Spheres => (Some("spheres.pvd"), "_spheres.vtp"),
            Self::SphereContacts => (Some("sphere_contacts.pvd"), "_sphere_contacts.vtp"),
            Self::Walls => (Some("walls.pvd"), "_walls.vtp"),
            Self::Coarse => (Some("coarse.pvd"), "_coarse.vti"),
            Self::Packed => (None, ".frame"),
        }
    }

    /// The collection of this file of all frames.
    pub(crate) fn collection(self) -> Option<&'static str> {
        self.names().0
    }

    /// The name of this file of a frame.
    pub(crate) fn of(self, number: usize) -> String {
        format!("{FRAMES}/{number:05}{}", self.names().1)
    }

    /// The files of each frame of a run.
    pub(crate) fn of_run<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Vec<Self> {
        let spheres = prepared.model.grains.is_some();
        let bodies = !prepared.model.mesh.elements.is_empty() || !spheres;
        let is_in = |file: &Self| match file {
            Self::Mesh | Self::Cracks | Self::DamagedJoints | Self::Contacts => bodies,
            Self::IntactJoints => prepared.output.intact_joints,
            Self::Spheres | Self::SphereContacts | Self::Walls => spheres,
            Self::Coarse => prepared.output.coarse.is_some(),
            Self::Packed => true,
        };
        Self::ALL.into_iter().filter(is_in).collect()
    }
}
