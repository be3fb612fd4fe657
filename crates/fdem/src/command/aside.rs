//! Partial files. Outputs are written under temporary names until they are complete. Partial files are removed at the end or on a signal; those of a command
//! that was killed are removed by the next command that writes into the folder.
//!
//! A process that writes into a folder keeps a lock file there, `.fdem-NAME.lock`, open and locked; its partial files are called `.fdem-NAME-….part`.
//! The system releases the lock when the process ends, however it ends. The next command that writes into the folder removes the partial files
//! that no process holds.

use std::fs::{self, File, Permissions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use tempfile::{Builder, NamedTempFile};

const PREFIX: &str = ".fdem-";
const LOCK: &str = ".lock";
const PART: &str = ".part";

/// Marks the partial files of this process in a folder as in use, by a lock file. The lock file is removed on drop.
#[derive(Debug)]
pub(crate) struct Claim {
    folder: PathBuf,
    /// Start of the names of the partial files.
    prefix: String,
    lock: NamedTempFile,
}

/// The partial files and the claims of this process, for the interrupt handler. The mutex also orders "create" and "rename" against it.
static ASIDE: Mutex<Aside> = Mutex::new(Aside { parts: Vec::new(), claims: Vec::new() });

struct Aside {
    parts: Vec<PathBuf>,
    claims: Vec<Weak<Claim>>,
}

fn aside<R>(act: impl FnOnce(&mut Aside) -> R) -> R {
    act(&mut ASIDE.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Creates a partial file in `folder`. The claim must be kept as long as the file.
pub(crate) fn create(
    folder: &Path,
    permissions: Option<Permissions>,
) -> io::Result<(NamedTempFile, Arc<Claim>)> {
    aside(|aside| {
        let claim = aside.claim(folder)?;
        let mut builder = Builder::new();
        builder.prefix(&claim.prefix).suffix(PART);
        if let Some(permissions) = permissions {
            builder.permissions(permissions);
        }
        let file = builder.tempfile_in(folder)?;
        aside.parts.push(file.path().to_owned());
        Ok((file, claim))
    })
}

/// Calls `rename`, which moves a partial file to its final name. Interrupts are handled before or after it.
pub(crate) fn put_in_place<R>(part: &Path, rename: impl FnOnce() -> R) -> R {
    aside(|aside| {
        aside.parts.retain(|path| path != part);
        rename()
    })
}

/// Removes the partial files of this process and ends the process.
pub(crate) fn remove_all_and_exit(code: i32) {
    aside(|aside| {
        let locks = aside.claims.iter().filter_map(Weak::upgrade);
        for path in aside.parts.drain(..).chain(locks.map(|claim| claim.lock.path().to_owned())) {
            // The file may have been removed already, and an error could not be reported any more.
            let _ = fs::remove_file(path);
        }
        std::process::exit(code);
    });
}

impl Aside {
    /// The claim of this process on a folder, made on first use.
    fn claim(&mut self, folder: &Path) -> io::Result<Arc<Claim>> {
        self.claims.retain(|claim| claim.strong_count() > 0);
        let known = self.claims.iter().filter_map(Weak::upgrade).find(|claim| claim.folder == folder);
        if let Some(claim) = known {
            return Ok(claim);
        }
        remove_abandoned(folder);
        let claim = Arc::new(Claim::new(folder)?);
        self.claims.push(Arc::downgrade(&claim));
        Ok(claim)
    }
}

impl Claim {
    fn new(folder: &Path) -> io::Result<Self> {
        loop {
            let lock = Builder::new().prefix(PREFIX).suffix(LOCK).tempfile_in(folder)?;
            let locked = lock.as_file().try_lock();
            // Another process may have found the file before it was locked, and removed it.
            let lost = matches!(locked, Err(TryLockError::WouldBlock)) || !lock.path().exists();
            let name = lock.path().file_name().map(|name| name.to_string_lossy().into_owned());
            if let (Some(name), false) = (name, lost) {
                // On a file system without locks, no other process can lock the file to remove it.
                let stem = name.strip_suffix(LOCK).unwrap_or(&name);
                return Ok(Self { folder: folder.to_owned(), prefix: format!("{stem}-"), lock });
            }
        }
    }
}

/// Removes the partial files in `folder` whose process has ended.
fn remove_abandoned(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with(PREFIX))
        .collect();
    let is_file = |path: &Path| fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file());
    for stem in names.iter().filter_map(|name| name.strip_suffix(LOCK)) {
        let path = folder.join(format!("{stem}{LOCK}"));
        // A file that cannot be opened belongs to somebody else.
        let Some(file) = Some(&path).filter(|path| is_file(path)).and_then(|path| File::open(path).ok())
        else {
            continue;
        };
        if file.try_lock().is_ok() {
            let parts = names.iter().filter(|name| is_part_of(name, stem));
            parts.for_each(|part| _ = fs::remove_file(folder.join(part)));
            let _ = fs::remove_file(path);
        }
    }
    // A lock file exists before its first partial file is created and until the last one is removed: partial files without a lock file are abandoned.
    for name in names.iter().filter(|name| name.ends_with(PART)) {
        let stem = name.strip_suffix(PART).and_then(|name| name.rsplit_once('-')).map(|(stem, _)| stem);
        let path = folder.join(name);
        if stem
            .is_some_and(|stem| stem.len() > PREFIX.len() && !folder.join(format!("{stem}{LOCK}")).exists())
            && is_file(&path)
        {
            let _ = fs::remove_file(path);
        }
    }
}

fn is_part_of(name: &str, stem: &str) -> bool {
    name.strip_prefix(stem).is_some_and(|rest| rest.starts_with('-') && rest.ends_with(PART))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Files of a process that has ended are removed; those of one that runs, and files of other names, are not.
    #[test]
    fn abandoned_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| fs::write(folder.path().join(name), "x").unwrap();
        for name in [".fdem-dead12.lock", ".fdem-dead12-abc123.part", ".fdem-dead12-def456.part"] {
            write(name);
        }
        for name in
            [".fdem-orphan-abc123.part", ".fdem-abc123.part", "fdem.part", ".fdem-notes", ".other.lock"]
        {
            write(name);
        }
        write(".fdem-alive1.lock");
        write(".fdem-alive1-abc123.part");
        let alive = File::open(folder.path().join(".fdem-alive1.lock")).unwrap();
        alive.lock().unwrap();

        let (part, claim) = create(folder.path(), None).unwrap();
        let mine: Vec<_> = [part.path(), claim.lock.path()]
            .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
            .to_vec();
        let others: Vec<_> = names(folder.path()).into_iter().filter(|name| !mine.contains(name)).collect();
        let kept = [
            ".fdem-abc123.part",
            ".fdem-alive1-abc123.part",
            ".fdem-alive1.lock",
            ".fdem-notes",
            ".other.lock",
            "fdem.part",
        ];
        assert_eq!(others, kept);
        let (second, same) = create(folder.path(), None).unwrap();
        assert!(Arc::ptr_eq(&claim, &same), "one lock file for all parts of a process");
        drop((part, second, claim, same));
        assert_eq!(names(folder.path()), kept);
    }
}
