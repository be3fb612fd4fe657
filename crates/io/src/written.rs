//! Tables for output: columns with names and types, whose values are computed when they are written.

mod csv;
mod graph;
mod npy;
mod npz;
mod parquet;
mod spool;
pub(crate) mod table;
mod vtp;

pub use csv::{write_csv, write_csv_header, write_csv_rows};
pub use graph::{write_graphml, write_node_link};
pub use npy::{write_npy, write_npy_header, write_npy_rows};
pub use npz::write_npz;
pub use parquet::write_parquet;
pub use spool::Spool;
pub use table::{Table, Values};
pub use vtp::write_vtp;
