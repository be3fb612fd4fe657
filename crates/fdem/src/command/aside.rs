//! Partial files. Every file that is complete or absent is written here: under a temporary name beside its
//! place, synced, and renamed. Partial files are removed at the end or on a signal; those of a command that
//! was killed are removed by the next command that writes into the folder.
//!
//! A process that writes into a folder keeps a lock file there, `.fdem-NAME.lock`, open and locked; its
//! partial files are called `.fdem-NAME-….part`. The system releases the lock when the process ends, however
//! it ends. The next command that writes into the folder removes the partial files that no process holds.

use std::fs::{self, File, OpenOptions, Permissions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use tempfile::{Builder, NamedTempFile, TempPath};

const PREFIX: &str = ".fdem-";
const LOCK: &str = ".lock";
const PART: &str = ".part";

/// Marks the partial files of this process in a folder as in use, by a lock file. The lock file is removed on
/// drop.
#[derive(Debug)]
struct Claim {
    folder: PathBuf,
    /// Start of the names of the partial files.
    prefix: String,
    lock: NamedTempFile,
}

/// The partial files and the claims of this process, for the interrupt handler. The mutex also orders
/// "create" and "rename" against it.
static ASIDE: Mutex<Aside> = Mutex::new(Aside { parts: Vec::new(), claims: Vec::new() });

struct Aside {
    parts: Vec<PathBuf>,
    claims: Vec<Weak<Claim>>,
}

fn aside<R>(act: impl FnOnce(&mut Aside) -> R) -> R {
    act(&mut ASIDE.lock().unwrap_or_else(PoisonError::into_inner))
}

/// A file that is being written. It is removed on drop.
pub(crate) struct PartialFile {
    // Dropped, and so removed, before the claim.
    file: BufWriter<NamedTempFile>,
    target: PathBuf,
    claim: Arc<Claim>,
}

impl PartialFile {
    /// Creates a partial file beside `target`, which it will replace. Permissions: `None` for those of a new
    /// file.
    ///
    /// # Errors
    /// Only their kind, because the error of the system names the temporary file.
    pub(crate) fn beside(target: PathBuf, permissions: Option<Permissions>) -> io::Result<Self> {
        let create = |aside: &mut Aside| {
            let claim = aside.claim(folder(&target))?;
            let mut builder = Builder::new();
            builder.prefix(&claim.prefix).suffix(PART);
            if let Some(permissions) = permissions.or_else(of_a_new_file) {
                builder.permissions(permissions);
            }
            let file = builder.tempfile_in(&claim.folder)?;
            aside.parts.push(file.path().to_owned());
            Ok((BufWriter::new(file), claim))
        };
        let (file, claim) = aside(create).map_err(|error: io::Error| io::Error::from(error.kind()))?;
        Ok(Self { file, target, claim })
    }

    /// Path of the file while it is written.
    pub(crate) fn path(&self) -> &Path {
        self.file.get_ref().path()
    }

    /// Closes the file once the disk has all of it.
    pub(crate) fn close(self) -> io::Result<Complete> {
        self.close_with(File::sync_all)
    }

    /// Closes the file after `last` is done with it.
    fn close_with(self, last: impl FnOnce(&File) -> io::Result<()>) -> io::Result<Complete> {
        let file = self.file.into_inner().map_err(io::IntoInnerError::into_error)?;
        last(file.as_file())?;
        Ok(Complete { file: file.into_temp_path(), target: self.target, _claim: self.claim })
    }
}

impl Write for PartialFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// A file that is complete and closed, because there may be more of them than a process can have open files.
/// It is removed on drop unless it is put in place.
pub(crate) struct Complete {
    // Dropped, and so removed, before the claim.
    file: TempPath,
    target: PathBuf,
    _claim: Arc<Claim>,
}

impl Complete {
    /// Renames the file to its final name. Interrupts are handled before or after it.
    pub(crate) fn put_in_place(self) -> io::Result<()> {
        let Self { file, target, _claim } = self;
        aside(|aside| {
            aside.parts.retain(|path| **path != *file);
            file.persist(target).map_err(|error| error.error)
        })
    }
}

/// Replaces the file `target`, or makes it. After a power cut the disk has the old contents or the new ones.
pub(crate) fn replace(target: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut part = PartialFile::beside(target.to_owned(), None)?;
    part.write_all(bytes)?;
    part.close()?.put_in_place()?;
    sync_folder(folder(target))
}

/// Replaces the file `target`, or makes it, without a wait for the disk. Other processes see the old contents
/// or the new ones. After a power cut the file may be cut off or missing, unless [`sync`] and [`sync_folder`]
/// were called.
pub(crate) fn replace_unsynced(target: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut part = PartialFile::beside(target.to_owned(), None)?;
    part.write_all(bytes)?;
    part.close_with(|_| Ok(()))?.put_in_place()
}

/// Waits until the disk has the contents of a file.
///
/// # Errors
/// The error of the system. It may stem from an earlier attempt to write the contents to the disk.
pub(crate) fn sync(file: &Path) -> io::Result<()> {
    // Some systems sync only files that are open for writing.
    OpenOptions::new().write(true).open(file)?.sync_all()
}

/// Waits until the disk has the names of the files in a folder.
#[cfg_attr(
    not(unix),
    allow(clippy::unnecessary_wraps, unused_variables, reason = "elsewhere folders cannot be synced")
)]
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    #[cfg(unix)]
    File::open(folder)?.sync_all()?;
    Ok(())
}

/// Keeps the lock file of this process in a folder. Without it, each file that is written makes the lock
/// file, looks for abandoned files, and removes the lock file.
#[derive(Debug)]
pub(crate) struct Hold {
    _claim: Arc<Claim>,
}

/// Makes the lock file of this process in a folder until the hold is dropped.
///
/// # Errors
/// Only their kind, because the error of the system names the lock file.
pub(crate) fn hold(folder: &Path) -> io::Result<Hold> {
    let claim = aside(|aside| aside.claim(folder)).map_err(|error| io::Error::from(error.kind()))?;
    Ok(Hold { _claim: claim })
}

/// Whether this is the name of a partial file, or of the lock file of a process that writes some.
pub(crate) fn is_aside(name: &str) -> bool {
    name.starts_with(PREFIX) && (name.ends_with(PART) || name.ends_with(LOCK))
}

/// Folder of a file.
pub(crate) fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Permissions of a new file before the umask. Temporary files are private by default.
#[cfg(unix)]
#[allow(clippy::unnecessary_wraps, reason = "elsewhere there is none")]
fn of_a_new_file() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn of_a_new_file() -> Option<Permissions> {
    None
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
    // A lock file exists before its first partial file is created and until the last one is removed: partial
    // files without a lock file are abandoned.
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

    /// Files of a process that has ended are removed; those of one that runs, and files of other names, are
    /// not.
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

        let make = |name: &str| PartialFile::beside(folder.path().join(name), None).unwrap();
        let part = make("one");
        let mine: Vec<_> = [part.file.get_ref().path(), part.claim.lock.path()]
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
        let second = make("two");
        assert!(Arc::ptr_eq(&part.claim, &second.claim), "one lock file for all parts of a process");
        drop((part, second));
        assert_eq!(names(folder.path()), kept);
    }

    /// Files that are written under a hold share its lock file, which goes with it.
    #[test]
    fn a_hold_keeps_one_lock_file() {
        let folder = tempfile::tempdir().unwrap();
        let held = hold(folder.path()).unwrap();
        let lock = names(folder.path());
        assert!(lock.len() == 1 && lock[0].ends_with(LOCK), "{lock:?}");
        replace_unsynced(&folder.path().join("one"), b"").unwrap();
        replace(&folder.path().join("two"), b"").unwrap();
        assert_eq!(names(folder.path()), [lock[0].as_str(), "one", "two"]);
        drop(held);
        assert_eq!(names(folder.path()), ["one", "two"]);
        assert!(hold(&folder.path().join("absent")).is_err());
    }

    /// A file has its old contents until the new ones are complete, and nothing else stays in the folder.
    #[test]
    fn a_file_is_replaced_as_a_whole() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("results");
        replace(&target, b"old").unwrap();
        let mut part = PartialFile::beside(target.clone(), None).unwrap();
        part.write_all(b"new").unwrap();
        assert!(names(folder.path()).iter().filter(|name| is_aside(name)).count() == 2);
        let complete = part.close().unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"old");
        complete.put_in_place().unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["results"]);
        replace_unsynced(&target, b"newest").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"newest");
        sync(&target).unwrap();
        sync_folder(folder.path()).unwrap();
        assert!(sync(&folder.path().join("absent")).is_err());
        assert_eq!(names(folder.path()), ["results"]);

        drop(PartialFile::beside(target.clone(), None).unwrap());
        assert!(replace(&folder.path().join("absent/results"), b"").is_err());
        // A folder of that name cannot be replaced, and the partial file is removed.
        fs::create_dir(folder.path().join("taken")).unwrap();
        assert!(replace(&folder.path().join("taken"), b"").is_err());
        assert_eq!(names(folder.path()), ["results", "taken"]);
    }
}
