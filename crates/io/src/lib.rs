//! Reads packings and meshes and writes tables of contact couples, in the formats used in discrete element
//! modelling.
//!
//! The crate works with bytes, not paths. [`unpack`] decompresses. [`Series`] turns the content of a file of
//! any format, frame by frame, into [`Packing`]s; [`read`] does the same for a table; [`read_mesh`] reads
//! nodes and elements. [`write_csv`], [`write_npz`], [`write_parquet`], [`write_vtp`], [`write_graphml`] and
//! similar functions write a [`Table`] to any [`std::io::Write`]. The caller that opens a file adds its name
//! to the errors.
//!
//! ```text
//! bytes ── Series ──┬─ read: delimited text, NumPy array ───────┬─> Packing ── (contact detection) ──> couples ── Table ── write_csv, …
//!                   └─ LAMMPS, XYZ, MercuryDPM, VTK, NumPy archive ┘
//! bytes ── read_mesh ── Gmsh, STL, OBJ, PLY, VTK, Abaqus ──> MeshFile
//! ```
//!
//! [`with_label_image`] reads labelled images plane by plane. Everything that is written is a [`Table`].
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
//!
//! # How it is built
//!
//! Everything that is written is a `Table` (`src/written/table.rs`): named, typed columns whose values are
//! computed while they are written. Nothing is stored, and every format can write every table. Columnar
//! formats request column by column, the others row by row. `crates/fdem/src/command/tables.rs` makes the
//! tables of couples and elements.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | formats of labelled images | `src/labels.rs`, `src/labels/npy.rs`, `src/labels/tiff.rs` |
//! | collections of ParaView | `src/series/collection.rs` |
//! | couples with values from files | `src/series/dump_local.rs` |
//! | types of elements | `src/types.rs`, the choice of their column: `src/table.rs` |
//! | formats of text and arrays | `src/text.rs`, `src/columns.rs`, `src/npy.rs` |
//! | formats with frames, recognition of a file | `src/series.rs`, `src/kind.rs`, `src/packing_format.rs`; a format: its file in `src/series`; compression: `src/unpack.rs` |
//! | comparison with how other libraries read the same files | `tests/python/test_formats.py` |
//! | formats of meshes; nodes, elements and bodies from files | `src/mesh/file.rs`, `src/mesh/recognise.rs`; a format: its file in `src/mesh`; rules for all formats: `src/mesh/build.rs` |
//! | the column that holds the body of an element | `src/table.rs`, `crates/fdem/src/command/input.rs` |

mod packing;
mod types;
mod flat;
mod options;
mod read;
mod series;
mod kind;
mod packing_format;
mod foreign;
mod compression;
mod unpack;

mod column_values;
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
pub mod numbers;

mod written;
mod results;
mod error;
mod place;
mod excerpt;
mod write_packing;

pub use columns::{Columns, ColumnsError, Role};
pub use compression::Compression;
pub use error::ReadError;
pub use kind::FileKind;
pub use labels::{LabelError, LabelImage, LabelKind, LabelValue, with_label_image};
pub use mesh::abaqus_include::MeshLoad;
pub use mesh::error::{MeshError, MeshProblem};
pub use mesh::file::{BodiesFrom, Cells, MeshBody, MeshFile, MeshGroup, MeshSource};
pub use mesh::format::MeshFormat;
pub use mesh::{read_mesh, read_mesh_with};
pub use npy::NpyRows;
pub use options::{ReadOptions, TypeColumn};
pub use packing::{
    BadLine, Centres, Column, Delimiter, Format, Frame, Packing, SimulationBox, Skipped, Source,
};
pub use packing_format::PackingFormat;
pub use place::Place;
pub use read::read;
pub use results::{pvd, write_poly_vtp, write_vti, write_vtu};
pub use series::collection::{PieceFile, PieceFiles};
pub use series::dump_local::{CoupleColumns, FileCouples, read_couples};
pub use series::{FrameIndex, Series, read_packing};
pub use types::Types;
pub use unpack::{unpack, unpack_within};
pub use write_packing::{write_packing_csv, write_packing_npy};
pub use written::{
    Spool, Table, Values, write_csv, write_csv_header, write_csv_rows, write_graphml, write_node_link,
    write_npy, write_npy_header, write_npy_rows, write_npz, write_parquet, write_vtp,
};
