//! Outputs that are complete or absent: they are written to a partial file, which is renamed at the end.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Stdout, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::command::aside::{self, Complete, PartialFile, folder};
use crate::command::failure::{Failure, display_name};

/// Format of couples and packings, by the extension of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TableFormat {
    Csv,
    Npy,
    Npz,
    Parquet,
    /// Points and lines for ParaView.
    Vtp,
    GraphMl,
    /// A graph as nodes and edges.
    Json,
}

/// Formats that hold any table.
pub(crate) const TABLES: [TableFormat; 4] =
    [TableFormat::Csv, TableFormat::Npy, TableFormat::Npz, TableFormat::Parquet];

impl TableFormat {
    /// Returns the format of an output by its extension; CSV for standard output.
    pub(crate) fn of(path: Option<&Path>) -> Result<Self, Failure> {
        use TableFormat::{Csv, GraphMl, Json, Npy, Npz, Parquet, Vtp};
        let any = [Csv, Npy, Npz, Parquet, Vtp, GraphMl, Json];
        Self::among(&any, path)
    }

    /// Returns the format of an output by its extension, if it is among `formats`.
    pub(crate) fn among(formats: &[Self], path: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = path.filter(|path| !is_stdout(path)) else { return Ok(Self::Csv) };
        let extension = path.extension().map(OsStr::to_ascii_lowercase);
        let is_named = |format: &&Self| extension.as_deref() == Some(OsStr::new(format.extension()));
        if let Some(format) = formats.iter().find(is_named) {
            return Ok(*format);
        }
        // A device has neither an extension nor a format. A folder is refused later, with a better message.
        if is_device(path) || path.is_dir() {
            return Ok(Self::Csv);
        }
        let names: Vec<_> = formats.iter().map(|format| format!(".{}", format.extension())).collect();
        let names = match &names[..] {
            [names @ .., last] => format!("{} or {last}", names.join(", ")),
            [] => String::new(),
        };
        Err(Failure::writing(path, format!("its extension must be that of a format: {names}")))
    }

    /// Refuses formats that hold the network of a packing.
    pub(crate) fn is_table(self, what: &str) -> Result<Self, Failure> {
        match self {
            Self::Csv | Self::Npy | Self::Npz | Self::Parquet => Ok(self),
            Self::Vtp | Self::GraphMl | Self::Json => Err(Failure::Unusable(format!(
                "--output: .{} holds a packing and its couples, not {what}: end the name in .csv, .npy, .npz or .parquet",
                self.extension()
            ))),
        }
    }

    fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Npy => "npy",
            Self::Npz => "npz",
            Self::Parquet => "parquet",
            Self::Vtp => "vtp",
            Self::GraphMl => "graphml",
            Self::Json => "json",
        }
    }
}

/// An output. It is opened before the work starts, so that a wrong name is reported immediately.
pub(crate) struct Output {
    name: PathBuf,
    to: To,
}

enum To {
    Stdout(BufWriter<Stdout>),
    /// An existing pipe or device such as `/dev/null`, which cannot be replaced by a rename.
    Device(BufWriter<File>),
    Aside(PartialFile),
}

/// Whether the program was started without standard output, as by `>&-`: the standard library has opened
/// `/dev/null` in its place.
static NO_STDOUT: AtomicBool = AtomicBool::new(false);

/// Records that the program was started without standard output. Writing to it is an error from then on.
pub(crate) fn stdout_is_closed() {
    NO_STDOUT.store(true, Ordering::Relaxed);
}

/// Returns an error if standard output is closed.
pub(crate) fn check_stdout() -> io::Result<()> {
    if NO_STDOUT.load(Ordering::Relaxed) {
        return Err(io::Error::other("it is closed"));
    }
    Ok(())
}

impl Output {
    /// Opens `path`, or standard output for `None` and `-`.
    pub(crate) fn open(path: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = path.filter(|path| !is_stdout(path)) else {
            let name = PathBuf::from("standard output");
            return Ok(Self { name, to: To::Stdout(BufWriter::new(io::stdout())) });
        };
        let name = path.to_owned();
        if path.is_dir() {
            return Err(Failure::writing(path, "it is a directory"));
        }
        if is_device(path) {
            let file =
                File::options().write(true).open(path).map_err(|error| Failure::writing(path, error))?;
            return Ok(Self { name, to: To::Device(BufWriter::new(file)) });
        }
        let target = target(path)?;
        // A rename does not need the permission to write the file that it replaces. A protected file is
        // respected nevertheless.
        let permissions = if target.exists() {
            let file =
                File::options().write(true).open(&target).map_err(|error| Failure::writing(path, error))?;
            file.metadata().ok().map(|metadata| metadata.permissions())
        } else {
            None
        };
        let folder = folder(&target);
        if !folder.is_dir() {
            return Err(Failure::writing(path, format!("there is no folder {}", display_name(folder))));
        }
        let part = PartialFile::beside(target, permissions).map_err(|error| Failure::writing(path, error))?;
        Ok(Self { name, to: To::Aside(part) })
    }

    /// Writes the output by `write`. An error names the output.
    ///
    /// It is no error if the reader of standard output ends early (`| head`).
    pub(crate) fn write(
        &mut self,
        write: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let (writer, is_stdout): (&mut (dyn Write + Send), _) = match &mut self.to {
            To::Stdout(writer) => (writer, true),
            To::Device(writer) => (writer, false),
            To::Aside(part) => (part, false),
        };
        let open = if is_stdout { check_stdout() } else { Ok(()) };
        match open.and_then(|()| write(writer)).and_then(|()| writer.flush()) {
            Err(error) if is_stdout && error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
            done => done.map_err(|error| Failure::writing(&self.name, error)),
        }
    }

    /// Name of the file in messages; `None` for standard output.
    pub(crate) fn file_name(&self) -> Option<String> {
        (!matches!(self.to, To::Stdout(_))).then(|| display_name(&self.name))
    }

    /// The partial file, if the output is a file.
    pub(crate) fn partial(&self) -> Option<&Path> {
        match &self.to {
            To::Aside(part) => Some(part.path()),
            To::Stdout(_) | To::Device(_) => None,
        }
    }

    /// Makes the output appear under its name. Without this call, the partial file is removed on drop.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        self.close()?.commit()
    }

    /// Closes the output. A partial file must still be renamed by [`Written::commit`].
    pub(crate) fn close(self) -> Result<Written, Failure> {
        let Self { name, to } = self;
        let To::Aside(part) = to else { return Ok(Written { name, part: None }) };
        let part = part.close().map_err(|error| Failure::writing(&name, error))?;
        Ok(Written { name, part: Some(part) })
    }
}

/// An output that is written and closed. Without [`Self::commit`], the partial file is removed on drop.
pub(crate) struct Written {
    name: PathBuf,
    part: Option<Complete>,
}

impl Written {
    /// Makes the output appear under its name.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        let Self { name, part } = self;
        part.map_or(Ok(()), Complete::put_in_place).map_err(|error| Failure::writing(&name, error))
    }
}

/// Watches for Ctrl-C and other interrupting signals, removes partial files and exits with 128 plus the
/// number of the signal.
pub(crate) fn remove_partial_output_when_interrupted() -> Result<(), Failure> {
    watch_for_interrupts(end).map_err(|error| {
        Failure::Unusable(format!(
            "cannot watch for interrupts: {error}; is there too little memory, or no thread left?"
        ))
    })
}

/// Stops Gmsh, removes partial files, and ends the program.
pub(crate) fn end(code: i32) {
    fdem_model::stop_gmsh();
    aside::remove_all_and_exit(code);
}

#[cfg(unix)]
fn watch_for_interrupts(clean_up: impl Fn(i32) + Send + 'static) -> Result<(), io::Error> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP, SIGQUIT])?;
    let watch = move || signals.forever().for_each(|signal| clean_up(128 + signal));
    crate::command::threads::start("signals", watch).map(drop)
}

#[cfg(not(unix))]
fn watch_for_interrupts(clean_up: impl Fn(i32) + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || clean_up(130))
}

/// Refuses outputs that would replace the input or another output.
///
/// `files`: a description of each file for the message, and its path if it is given. The first is the input.
pub(crate) fn refuse_to_overwrite(files: &[(&str, Option<&PathBuf>)]) -> Result<(), Failure> {
    for (k, (option, path)) in files.iter().enumerate().skip(1) {
        let Some(path) = path else { continue };
        for (other, taken) in &files[..k] {
            if taken.is_some_and(|taken| same_file(path, taken)) {
                return Err(Failure::Unusable(format!(
                    "{option} {} is the same file as {other}",
                    display_name(path)
                )));
            }
        }
    }
    Ok(())
}

/// Whether both paths lead to the same file, which may not exist yet.
fn same_file(a: &Path, b: &Path) -> bool {
    if is_stdout(a) || is_device(a) {
        return false;
    }
    let place = |path: &Path| {
        let path = fs::canonicalize(path).or_else(|_| target(path).map_err(|_| io::ErrorKind::Other)).ok()?;
        Some((fs::canonicalize(folder(&path)).ok()?, path.file_name()?.to_owned()))
    };
    a == b || place(a).is_some_and(|a| Some(a) == place(b))
}

/// Follows links to the file itself, which may not exist yet.
fn target(path: &Path) -> Result<PathBuf, Failure> {
    /// Most links that are followed, as by Linux.
    const MOST_LINKS: usize = 40;
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&target) {
            Ok(link) => target = folder(&target).join(link),
            Err(_) => return Ok(target),
        }
    }
    Err(Failure::writing(path, "its links form a loop"))
}

/// Prints a text on standard output. It is no error if its reader ends early (`| head`).
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut output = Output::open(None)?;
    output.write(|out| out.write_all(text.as_bytes()))
}

pub(crate) fn is_stdout(path: &Path) -> bool {
    path == Path::new("-")
}

/// Whether a path exists and is neither a file nor a folder.
pub(crate) fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}
