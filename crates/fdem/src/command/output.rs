//! Outputs that are whole or not there: written aside, then renamed.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Stdout, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

use crate::command::failure::Failure;

/// Format of couples and packings, by the extension of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Table {
    Csv,
    Npy,
}

impl Table {
    /// Standard output gets CSV.
    pub(crate) fn of(path: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = path else { return Ok(Self::Csv) };
        match path.extension().map(OsStr::to_ascii_lowercase) {
            Some(extension) if extension == "csv" => Ok(Self::Csv),
            Some(extension) if extension == "npy" => Ok(Self::Npy),
            // A device has no extension and no format of its own; what is wrong with a folder is not its name.
            _ if is_device(path) || path.is_dir() => Ok(Self::Csv),
            _ => Err(Failure::Unusable(format!(
                "cannot tell the format of {} from its name: end it in .csv or .npy",
                path.display()
            ))),
        }
    }
}

/// One output, opened before the work starts so that a wrong name is told at once.
pub(crate) struct Output {
    name: PathBuf,
    to: To,
}

enum To {
    Stdout(BufWriter<Stdout>),
    /// An existing pipe or device such as `/dev/null`: cannot be replaced by a rename.
    Device(BufWriter<File>),
    Aside {
        file: BufWriter<NamedTempFile>,
        target: PathBuf,
    },
}

impl Output {
    /// Opens `path`, or standard output for `None`.
    pub(crate) fn open(path: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = path else {
            return Ok(Self { name: "standard output".into(), to: To::Stdout(BufWriter::new(io::stdout())) });
        };
        let failed = |error: &io::Error| Failure::writing(path, error);
        if path.is_dir() {
            return Err(Failure::Unusable(format!("cannot write {}: it is a directory", path.display())));
        }
        let name = path.to_owned();
        if is_device(path) {
            let file = File::options().write(true).open(path).map_err(|error| failed(&error))?;
            return Ok(Self { name, to: To::Device(BufWriter::new(file)) });
        }
        // A link is followed: the file behind it is what gets replaced.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let permissions = fs::metadata(&target).ok().map(|metadata| metadata.permissions());
        if permissions.as_ref().is_some_and(fs::Permissions::readonly) {
            return Err(Failure::Unusable(format!("cannot write {}: it is read-only", path.display())));
        }
        let folder = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".fdem-").suffix(".part");
        if let Some(permissions) = permissions.or_else(default_permissions) {
            builder.permissions(permissions);
        }
        let file = partial_outputs(|partial| {
            let file = builder.tempfile_in(folder)?;
            partial.push(file.path().to_owned());
            Ok(file)
        });
        let file = file.map_err(|error: io::Error| match error.kind() {
            io::ErrorKind::NotFound => {
                Failure::Unusable(format!("cannot write {}: no folder {}", path.display(), folder.display()))
            }
            kind => failed(&io::Error::from(kind)),
        })?;
        Ok(Self { name, to: To::Aside { file: BufWriter::new(file), target } })
    }

    /// Writes through `write`; an error names the output.
    pub(crate) fn write(
        &mut self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let writer: &mut dyn Write = match &mut self.to {
            To::Stdout(writer) => writer,
            To::Device(writer) => writer,
            To::Aside { file, .. } => file,
        };
        write(writer).and_then(|()| writer.flush()).map_err(|error| Failure::writing(&self.name, &error))
    }

    /// Makes the output appear under its name. Dropped without this, a file written aside is removed.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        let To::Aside { file, target } = self.to else { return Ok(()) };
        let failed = |error: &io::Error| Failure::writing(&self.name, error);
        let file = file.into_inner().map_err(|error| failed(error.error()))?;
        file.as_file().sync_all().map_err(|error| failed(&error))?;
        partial_outputs(|partial| {
            partial.retain(|path| path != file.path());
            file.persist(target)
        })
        .map_err(|error| failed(&error.error))?;
        Ok(())
    }
}

/// Files written aside at this moment, for the interrupt handler. The lock also orders "create" and "rename" against it.
static PARTIAL_OUTPUTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn partial_outputs<R>(act: impl FnOnce(&mut Vec<PathBuf>) -> R) -> R {
    act(&mut PARTIAL_OUTPUTS.lock().unwrap_or_else(PoisonError::into_inner))
}

/// On Ctrl-C, SIGTERM or SIGHUP: removes what has been written aside, and ends with the customary exit code 130.
pub(crate) fn remove_partial_output_when_interrupted() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        partial_outputs(|partial| {
            for path in partial.iter() {
                // It may be gone already; there is nobody left to tell.
                let _ = fs::remove_file(path);
            }
            std::process::exit(130);
        });
    })
    .map_err(|error| Failure::Unusable(format!("cannot watch for interrupts: {error}")))
}

fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// What a new file gets, before the umask; a temporary file would be private otherwise.
#[cfg(unix)]
#[allow(clippy::unnecessary_wraps, reason = "elsewhere there is none")]
fn default_permissions() -> Option<fs::Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(fs::Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn default_permissions() -> Option<fs::Permissions> {
    None
}
