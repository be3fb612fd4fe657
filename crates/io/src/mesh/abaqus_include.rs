//! Files that an Abaqus file takes in, `*INCLUDE, INPUT=FILE`.

use crate::excerpt;
use crate::mesh::error::{MeshProblem, malformed, unsupported};
use crate::place::Place;

/// Gives the bytes of a file that a mesh file names, or says why it cannot.
pub type MeshLoad<'l> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'l;

/// Most files that include each other in a chain.
const DEEPEST: usize = 20;

/// Most included files: a few short files may include each other any number of times.
const MOST: usize = 1000;

/// The files that are open, and how others are read.
pub(crate) struct Includes<'a, 'l> {
    load: &'a mut MeshLoad<'l>,
    /// Paths of the open files; the first one is the mesh file itself.
    chain: Vec<String>,
    /// Number of files that were included.
    count: usize,
}

impl<'a, 'l> Includes<'a, 'l> {
    pub(crate) fn new(name: &str, load: &'a mut MeshLoad<'l>) -> Self {
        Self { load, chain: vec![name.to_owned()], count: 0 }
    }

    /// Whether the open file is an included one.
    pub(crate) fn is_included(&self) -> bool {
        self.chain.len() > 1
    }

    /// Opens a file, whose path is relative to that of the open file. Returns its bytes.
    ///
    /// # Errors
    /// A file that cannot be read, or that is open already; too many files.
    pub(crate) fn open(&mut self, keyword: &str, path: &str) -> Result<Vec<u8>, MeshProblem> {
        let what = || format!("*{keyword}, INPUT=: the file {}", excerpt::field(path.as_bytes()));
        let whole = relative(&path.replace('\\', "/"), &self.chain[self.chain.len() - 1]);
        if self.chain.contains(&whole) {
            return Err(malformed(format!("{} includes itself", what())));
        }
        self.count += 1;
        if self.chain.len() > DEEPEST || self.count > MOST {
            return Err(unsupported(
                what(),
                format!("more than {MOST} included files, or more than {DEEPEST} in a chain"),
            ));
        }
        let bytes = (self.load)(&whole).map_err(|why| unsupported(what(), why))?;
        self.chain.push(whole);
        Ok(bytes)
    }

    pub(crate) fn close(&mut self) {
        self.chain.pop();
    }

    /// A problem at a place of the open file, which is named if it is an included one.
    pub(crate) fn located(&self, (place, problem): (Place, MeshProblem)) -> (Place, MeshProblem) {
        if !self.is_included() {
            return (place, problem);
        }
        let line = match place {
            Place::Line(line) => line,
            Place::Byte(_) | Place::File => 0,
        };
        let file = excerpt::line(self.chain[self.chain.len() - 1].as_bytes());
        (Place::File, MeshProblem::Included { file, line, problem: Box::new(problem) })
    }
}

/// A path relative to the folder of the file that has it. `..` takes a folder away, so that a file has one
/// path.
fn relative(path: &str, file: &str) -> String {
    let is_absolute = path.starts_with('/') || path.get(1..3) == Some(":/");
    let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut parts: Vec<&str> = Vec::new();
    let joined =
        if is_absolute || !file.contains('/') { path.to_owned() } else { format!("{folder}/{path}") };
    for part in joined.split('/') {
        match part {
            "." => {}
            ".." if parts.last().is_some_and(|last| !["", ".."].contains(last)) => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::relative;

    #[test]
    fn paths_are_relative_to_the_file_that_has_them() {
        for (path, file, whole) in [
            ("b.inp", "a.inp", "b.inp"),
            ("b.inp", "../a.inp", "../b.inp"),
            ("../b.inp", "/m/x/a.inp", "/m/b.inp"),
            ("./p/../b.inp", "m/a.inp", "m/b.inp"),
            ("../../b.inp", "m/a.inp", "../b.inp"),
            ("/c/b.inp", "m/a.inp", "/c/b.inp"),
            ("C:/b.inp", "m/a.inp", "C:/b.inp"),
        ] {
            assert_eq!(relative(path, file), whole, "{path} in {file}");
        }
    }
}
