//! Results of a simulation: files for ParaView, pictures, an animation, a history with its plots, and a page
//! for a browser.
//!
//! ```text
//! Snapshot ──┬─> vtu, vtp ── ParaView
//!            ├─> Fragments ── fragments.csv, plot of sizes
//!            └─> Frame ──┬─> Pictures ── SVG, PNG, Animation (GIF)
//!                        └─> Report ──── one page
//! Row ── HistoryWriter ── history.csv ── History ── plots ── SVG, PNG, Report
//! ```
//! A [`Frame`] is a compressed snapshot with a few bytes for each element. It is kept in memory or in a file
//! until the series is complete and the range of its colours is known. This module makes text and bytes, and
//! knows no paths.

mod animation;
mod chart;
mod csv;
mod curves;
mod emission;
mod file_fields;
pub(crate) mod fragments;
pub(crate) mod frame;
pub(crate) mod grains;
mod history;
mod inertia;
mod loads;
pub(crate) mod names;
mod noise;
pub(crate) mod outlines;
pub(crate) mod packed;
pub(crate) mod pictures;
pub(crate) mod plots;
mod sample;
pub(crate) mod snapshot;
pub(crate) mod unit;
mod vtk;

pub use animation::{Animation, AnimationError, SpaceAnimation};
pub use curves::{CurveFigures, CurvePoint, HistoryCurve};
pub use emission::{
    BValue, Clustering, EmissionKind, EmittingJoint, Event, emitting_joints, events, events_csv,
    magnitude_frequency,
};
pub use fdem_io::pvd;
pub use fragments::{ElementMasses, Fragment, FragmentCount, Fragments, SizeDistribution};
pub use frame::{Frame, FrameError};
pub use grains::{
    CoarseError, CoarseFields, CoarseGrid, write_sphere_contacts_vtp, write_spheres_vtp, write_walls_vtp,
};
pub use history::{History, HistoryError, HistoryWriter, Row, history_columns};
pub use inertia::{Inertia, inertia};
pub use names::Names;
pub use outlines::Outlines;
pub use pictures::{FrameView, Pictures};
pub use plots::{Plot, RANK_PLOTS, RankLoad, fragment_sizes, plots, rank_loads};
pub use snapshot::SnapshotError;
pub use vtk::{
    write_contacts_vtp, write_cracks_vtp, write_damaged_joints_vtp, write_intact_joints_vtp, write_vtu,
};
