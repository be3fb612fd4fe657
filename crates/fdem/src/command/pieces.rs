//! Files that a collection lists, found from its path.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use fdem_io::{PieceFile, PieceFiles, unpack_within};

use crate::command::memory;

/// The files that a collection of ParaView lists: each is relative to the folder of the file that lists it.
#[derive(Debug)]
pub struct FilesBeside {
    collection: PathBuf,
    max_memory: Option<u64>,
}

impl FilesBeside {
    /// The files that this collection lists; those in the working directory if its path is empty, as that of
    /// standard input. `max_memory`: most bytes of the content of one file, by default three quarters of the
    /// memory.
    pub fn new(collection: &Path, max_memory: Option<u64>) -> Self {
        Self { collection: collection.to_owned(), max_memory }
    }
}

impl PieceFiles for FilesBeside {
    fn open(&self, chain: &[String]) -> Result<PieceFile, String> {
        let beside = |path: PathBuf, name: &String| path.parent().unwrap_or(Path::new("")).join(name);
        let path = chain.iter().fold(self.collection.clone(), beside);
        if path.as_os_str().is_empty() {
            return Ok(PieceFile { place: String::new(), bytes: Vec::new() });
        }
        let failed = |error: &io::Error| format!("cannot read {}: {error}", path.display());
        let place = fs::canonicalize(&path).map_err(|error| failed(&error))?.display().to_string();
        if chain.is_empty() {
            return Ok(PieceFile { place, bytes: Vec::new() });
        }
        let limit = self.max_memory.or_else(memory::default_limit).unwrap_or(u64::MAX);
        let size = fs::metadata(&path).map_err(|error| failed(&error))?.len();
        if size > limit {
            return Err(format!("{} has {size} bytes, and {limit} are allowed for reading", path.display()));
        }
        let bytes = fs::read(&path).map_err(|error| failed(&error))?;
        let (bytes, _) = unpack_within(bytes.into(), limit, |_| true).map_err(|error| error.to_string())?;
        Ok(PieceFile { place, bytes: bytes.into_owned() })
    }
}
