//! Checksums of the results that are finished. A checkpoint has them in its own file, so that they always
//! belong to its state.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::command::run::frame_files::FrameFile;

/// Length and SHA-256 of a file, or of its beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Checksum {
    /// Bytes.
    pub(crate) length: u64,
    sha256: [u8; 32],
}

impl Checksum {
    pub(crate) fn of(bytes: &[u8]) -> Self {
        Self { length: bytes.len() as u64, sha256: Sha256::digest(bytes).into() }
    }
}

/// The finished results of a run at a checkpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Manifest {
    /// Step of the checkpoint.
    pub(crate) step: u64,
    /// The rows of the history up to this step. Later rows may follow in its file.
    pub(crate) history: Checksum,
    /// Frames that have been written.
    pub(crate) frames: Vec<FrameRecord>,
    /// Names of the tables that were written at the end of the run, if it has ended.
    pub(crate) tables: Vec<(String, Checksum)>,
    /// Copies of the files that the model names, in their order.
    pub(crate) inputs: Vec<Checksum>,
}

/// A frame that has been written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FrameRecord {
    pub(crate) step: u64,
    /// Time, s.
    pub(crate) time: f64,
    pub(crate) files: Vec<(FrameFile, Checksum)>,
}

/// A writer that computes the checksum of all bytes that pass.
#[derive(Debug)]
pub(crate) struct Hashing<W> {
    out: W,
    hash: Sha256,
    length: u64,
}

impl<W> Hashing<W> {
    pub(crate) fn new(out: W) -> Self {
        Self { out, hash: Sha256::new(), length: 0 }
    }

    /// The checksum of all bytes until now, with those that [`Hashed::then`] continues.
    pub(crate) fn checksum(&self) -> Checksum {
        Checksum { length: self.length, sha256: self.hash.clone().finalize().into() }
    }

    pub(crate) fn get_ref(&self) -> &W {
        &self.out
    }
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hash.update(&bytes[..written]);
        self.length += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// The beginning of a file that has been read, with the state of its hash.
#[derive(Clone, Debug)]
pub(crate) struct Hashed {
    hash: Sha256,
    length: u64,
}

impl Hashed {
    /// Reads a file up to `most` bytes.
    pub(crate) fn read(path: &Path, most: u64) -> io::Result<Self> {
        let mut file = File::open(path)?.take(most);
        let (mut hash, mut length) = (Sha256::new(), 0);
        let mut piece = vec![0; 1 << 16];
        loop {
            match file.read(&mut piece) {
                Ok(0) => return Ok(Self { hash, length }),
                Ok(count) => {
                    hash.update(&piece[..count]);
                    length += count as u64;
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    pub(crate) fn checksum(&self) -> Checksum {
        Checksum { length: self.length, sha256: self.hash.clone().finalize().into() }
    }

    /// A writer that continues the file, whose checksum is that of the whole file.
    pub(crate) fn then<W>(self, out: W) -> Hashing<W> {
        Hashing { out, hash: self.hash, length: self.length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that is written in parts, and continued after it was read, has the checksum of the whole.
    #[test]
    fn a_checksum_is_that_of_all_bytes() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("file");
        let mut first = Hashing::new(File::create(&path).expect("a file"));
        first.write_all(b"one,").and_then(|()| first.write_all(b"two")).expect("bytes");
        assert_eq!(first.checksum(), Checksum::of(b"one,two"));
        let read = Hashed::read(&path, 4).expect("the file");
        assert_eq!(read.checksum(), Checksum::of(b"one,"));
        let mut more = read.then(Vec::new());
        more.write_all(b"three").expect("bytes");
        assert_eq!(more.checksum(), Checksum::of(b"one,three"));
        assert_eq!(more.get_ref(), b"three");
        assert_ne!(Hashed::read(&path, 100).expect("the file").checksum(), Checksum::of(b"one,twp"));
    }
}
