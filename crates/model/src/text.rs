//! The text of a model file: from TOML to keys with values, and errors with their places.

pub(crate) mod fault;
pub(crate) mod document;
pub mod file;
pub(crate) mod included;
pub(crate) mod library;
pub(crate) mod partial;
pub(crate) mod schema;
pub(crate) mod set;
pub(crate) mod values;
