//! Locks of folders of results: one process at a time writes into a folder.
//!
//! The lock is that of the system on a hidden file, `.fdem.lock`, which names the process that holds it. The
//! system releases it when the process ends, however it ends. The file stays in the folder: if it were
//! removed, two processes could hold locks on two files of one name.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::command::failure::{Failure, display_name};

const NAME: &str = ".fdem.lock";

/// Time between two attempts. A process that has just got the lock has written its name by then.
const PAUSE: Duration = Duration::from_millis(20);

/// A folder that this process uses. Other processes can use it once this is dropped.
#[derive(Debug)]
pub(crate) struct FolderLock {
    file: File,
    is_exclusive: bool,
}

impl FolderLock {
    /// Locks a folder for this process alone, before it changes anything in the folder. Waits for another
    /// process up to `patience`. A file system without locks is used unlocked.
    ///
    /// # Errors
    /// A folder that another process uses, or in which no file can be made.
    pub(crate) fn exclusive(folder: &Path, patience: Duration) -> Result<Self, Failure> {
        let path = folder.join(NAME);
        let failed = |error: io::Error| Failure::writing(&path, error);
        let mut options = OpenOptions::new();
        let mut file =
            options.read(true).write(true).create(true).truncate(false).open(&path).map_err(failed)?;
        wait(folder, patience, || file.try_lock())?;
        file.set_len(0).and_then(|()| file.write_all(holder().as_bytes())).map_err(failed)?;
        Ok(Self { file, is_exclusive: true })
    }

    /// Locks a folder against processes that write, while this process reads it; others may read it too.
    /// Waits for another process up to `patience`. A folder into which no process has written is left as it
    /// is: `None`.
    ///
    /// # Errors
    /// A folder that another process uses.
    pub(crate) fn shared(folder: &Path, patience: Duration) -> Result<Option<Self>, Failure> {
        let path = folder.join(NAME);
        let file = match File::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(Failure::reading(&display_name(&path), &error)),
        };
        wait(folder, patience, || file.try_lock_shared())?;
        Ok(Some(Self { file, is_exclusive: false }))
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        if self.is_exclusive {
            // The next holder writes its own name. Without this, a process that comes between its lock and
            // its name would blame this one.
            let _ = self.file.set_len(0);
        }
    }
}

/// Whether this is the name of the lock file of a folder.
pub(crate) fn is_lock(name: &str) -> bool {
    name == NAME
}

/// Tries to lock a file in `folder`, up to `patience`.
fn wait(
    folder: &Path,
    patience: Duration,
    mut lock: impl FnMut() -> Result<(), TryLockError>,
) -> Result<(), Failure> {
    let start = Instant::now();
    while matches!(lock(), Err(TryLockError::WouldBlock)) {
        let is_over = start.elapsed() >= patience;
        sleep(PAUSE);
        if is_over {
            return Err(in_use(folder));
        }
    }
    Ok(())
}

/// The failure for a folder that another process uses.
fn in_use(folder: &Path) -> Failure {
    let mut name = String::new();
    // Some systems do not let a locked file be read: then the process has no name.
    let read = File::open(folder.join(NAME)).and_then(|file| file.take(1000).read_to_string(&mut name));
    let name = name.trim();
    let named = read.is_ok() && !name.is_empty() && !name.contains(char::is_control);
    Failure::Unusable(format!(
        "another fdem process is using {}{}: wait until it ends, or choose another folder",
        display_name(folder),
        if named { format!(", {name}") } else { String::new() }
    ))
}

/// This process, as its lock file names it.
fn holder() -> String {
    // On a file system of many machines, the number of a process alone is not enough.
    let machine = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    match machine.trim() {
        "" => format!("process {}\n", std::process::id()),
        machine => format!("process {} on {machine}\n", std::process::id()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Duration = Duration::from_secs(3);

    /// A folder that another process has locked is waited for, but not for long; the message names both.
    #[test]
    fn a_locked_folder_is_waited_for() {
        let place = tempfile::tempdir().expect("a folder");
        let held = FolderLock::exclusive(place.path(), Duration::ZERO).expect("a lock");
        std::thread::scope(|scope| {
            scope.spawn(|| {
                sleep(Duration::from_millis(200));
                drop(held);
            });
            FolderLock::exclusive(place.path(), PATIENCE).expect("the other process has ended");
        });

        let _held = FolderLock::exclusive(place.path(), Duration::ZERO).expect("a lock");
        for again in [
            FolderLock::exclusive(place.path(), Duration::ZERO).map(drop),
            FolderLock::shared(place.path(), Duration::ZERO).map(drop),
        ] {
            let Err(Failure::Unusable(why)) = again else { panic!("the folder is in use") };
            let folder = display_name(place.path());
            assert!(why.starts_with(&format!("another fdem process is using {folder}")), "{why}");
            assert!(cfg!(windows) || why.contains(&format!("process {}", std::process::id())), "{why}");
        }
    }

    /// Many processes read a folder at once, and none writes meanwhile. Reading makes no file.
    #[test]
    fn a_folder_is_read_by_many() {
        let place = tempfile::tempdir().expect("a folder");
        assert!(FolderLock::shared(place.path(), Duration::ZERO).expect("no lock").is_none());
        assert_eq!(fs::read_dir(place.path()).expect("a folder").count(), 0);
        drop(FolderLock::exclusive(place.path(), Duration::ZERO).expect("a lock"));
        let read = || FolderLock::shared(place.path(), Duration::ZERO).expect("a lock");
        let readers = [read(), read()];
        assert!(readers.iter().all(Option::is_some));
        assert!(FolderLock::exclusive(place.path(), Duration::ZERO).is_err());
        drop(readers);
        FolderLock::exclusive(place.path(), Duration::ZERO).expect("nobody reads any more");
    }
}
