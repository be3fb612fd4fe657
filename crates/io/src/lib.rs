//! Packings and meshes in and contact couples out, in the formats of the discrete element field.
//!
//! The crate knows bytes, not paths: [`unpack`] undoes compression, [`Series`] turns the content of a file of any format, frame by frame, into
//! [`Packing`]s, [`read`] that of a table into one, and
//! [`write_csv`], [`write_npz`], [`write_parquet`], [`write_vtp`], [`write_graphml`] and their likes send a [`Table`] to any
//! [`std::io::Write`]. [`read_mesh`] does the same for nodes and elements. Who opens the file adds its name to the errors.
//!
//! ```text
//! bytes ── Series ──┬─ read: delimited text, NumPy array ───────┬─> Packing ── (contact detection) ──> couples ── Table ── write_csv, …
//!                   └─ LAMMPS, XYZ, MercuryDPM, VTK, NumPy archive ┘
//! bytes ── read_mesh ── Gmsh, STL, OBJ, PLY, VTK, Abaqus ──> Mesh
//! ```
//!
//! Labelled images are read plane by plane: [`with_label_image`]. What is written is a [`Table`], whatever it is of.
//!
//! # Example
//! ```
//! use std::sync::atomic::AtomicU64;
//! use fdem_io::{Centres, ReadOptions, read};
//!
//! let text = b"Radius[m] PosX[m] PosY[m]\n 0.5 0 0\n 0.5 1 0\n";
//! let packing = read(text, &ReadOptions::default(), &AtomicU64::new(0))?;
//! assert_eq!(packing.centres, Centres::Two(vec![[0.0, 0.0], [1.0, 0.0]]));
//! assert_eq!(packing.radii, Some(vec![0.5, 0.5]));
//! assert_eq!(packing.source.unit.as_deref(), Some("m"));
//! # Ok::<(), fdem_io::ReadError>(())
//! ```

mod packing;
mod read;
mod series;
mod kind;
mod unpack;

mod columns;
mod elements;
mod lines;
mod npy;
mod npy_header;
mod row;
mod table;
mod text;

mod mesh;
mod labels;

mod written;
mod results;
mod error;
mod excerpt;
mod write_packing;

pub use columns::{Columns, ColumnsError, Role};
pub use error::ReadError;
pub use kind::{FileKind, PackingFormat};
pub use labels::{LabelError, LabelImage, LabelKind, LabelValue, with_label_image};
pub use mesh::error::{MeshError, MeshProblem, Place};
pub use mesh::{BodiesFrom, Cells, Mesh, MeshBody, MeshFormat, MeshSource, read_mesh};
pub use packing::{
    BadLine, Centres, Column, Delimiter, Format, Frame, Packing, SimulationBox, Skipped, Source,
};
pub use read::{ReadOptions, read};
pub use results::{pvd, write_vtu};
pub use series::{Series, read_packing};
pub use unpack::{Compression, unpack};
pub use write_packing::{write_packing_csv, write_packing_npy};
pub use written::{
    Table, Values, write_csv, write_csv_rows, write_graphml, write_node_link, write_npy, write_npy_header,
    write_npy_rows, write_npz, write_parquet, write_vtp,
};
