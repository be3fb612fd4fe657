//! Geometries that Gmsh meshes, as a separate program. It ends when this program is interrupted ([`stop`]);
//! it continues if this program is killed (SIGKILL), until its mesh is made.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use fdem_io::numbers::brief;

use crate::text::fault::Problem;

/// Ends of the names of files that Gmsh meshes.
const GEOMETRIES: [&str; 6] = [".geo", ".step", ".stp", ".iges", ".igs", ".brep"];

/// Time after which Gmsh is stopped.
const PATIENCE: Duration = Duration::from_secs(600);

/// Time between two looks at whether Gmsh has ended.
const LOOK: Duration = Duration::from_millis(20);

/// Lines of the output of Gmsh that are shown.
const LINES: usize = 5;

/// The Gmsh that runs, for [`stop`].
static RUNNING: Mutex<Option<Running>> = Mutex::new(None);

struct Running {
    program: Child,
    /// The temporary folder of the program.
    folder: PathBuf,
}

fn running() -> MutexGuard<'static, Option<Running>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Stops Gmsh and removes its folder, if it runs. For programs that end next: no other Gmsh can be started
/// afterwards, and a thread that waits for this one waits for ever.
pub fn stop() {
    let mut guard = running();
    if let Some(Running { program, folder }) = &mut *guard {
        // A failure here can no longer be reported.
        let _ = program.kill();
        let _ = program.wait();
        let _ = fs::remove_dir_all(folder);
    }
    std::mem::forget(guard);
}

/// Whether a file has a geometry, not a mesh, by the end of its name.
pub(crate) fn is_geometry(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    GEOMETRIES.iter().any(|end| name.ends_with(end))
}

/// Size of elements that no geometry has: curves are cut only as much as they bend.
const HUGE: f64 = 1e22;

/// The box around the curves of a geometry, in metres as in [`mesh`]; `None` if Gmsh does not find them.
pub(crate) fn bounds(bytes: &[u8], name: &str) -> Option<[[f64; 3]; 2]> {
    let curves = mesh(bytes, name, HUGE, 1).ok()?;
    let points = fdem_io::read_mesh(&curves, "curves.msh").ok()?.points;
    (!points.is_empty()).then(|| fdem_mesh::bounds(points.into_iter()))
}

/// The mesh that Gmsh makes of a geometry with edges of `size` m at most, as a file. Lengths of STEP and IGES
/// files become metres, whatever their unit. With one dimension, it is a mesh of all curves.
///
/// Gmsh sees the file alone, in a separate folder: a file that includes others is not found there.
///
/// # Errors
/// Gmsh is not installed, is stopped, or fails; the message has its output.
pub(crate) fn mesh(bytes: &[u8], name: &str, size: f64, dimensions: usize) -> Result<Vec<u8>, Problem> {
    let problem = |message: String| Problem::new("mesh", message);
    if let Some((line, statement)) = other_file(bytes, name) {
        return Err(Problem {
            help: Some(
                "run gmsh on it in its folder, and give the .msh file; or name the other file itself"
                    .to_owned(),
            ),
            ..problem(format!("{name}:{line}: {statement} takes another file, which Gmsh does not see here"))
        });
    }
    let folder = tempfile::tempdir()
        .map_err(|error| problem(format!("cannot make a temporary folder for Gmsh: {error}")))?;
    let end = Path::new(name).extension().and_then(|end| end.to_str()).unwrap_or("geo").to_ascii_lowercase();
    let [geometry, meshed, said] = [format!("geometry.{end}"), "mesh.msh".to_owned(), "said.txt".to_owned()]
        .map(|file| folder.path().join(file));
    let output = fs::write(&geometry, bytes).and_then(|()| File::create(&said));
    let output = output.and_then(|output| Ok((output.try_clone()?, output)));
    let (output, errors) =
        output.map_err(|error| problem(format!("cannot write a temporary file for Gmsh: {error}")))?;
    // One thread: the mesh does not depend on the machine.
    let mut command = Command::new("gmsh");
    command
        .arg(format!("-{dimensions}"))
        .args(["-nt", "1", "-order", "1", "-format", "msh22", "-clmax", &size.to_string()])
        // Without this option they become millimetres.
        .args(["-setstring", "Geometry.OCCTargetUnit", "M", "-o"])
        .arg(&meshed)
        .arg(&geometry)
        .stdin(Stdio::null())
        .stdout(output)
        .stderr(errors);
    if dimensions == 1 {
        // Also the curves in no physical group.
        command.arg("-save_all");
    }
    // Ctrl-C is for this program alone, which then stops Gmsh.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let ended = run(&mut command, folder.path(), PATIENCE).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Problem {
            help: Some(
                "install Gmsh (gmsh.info), or mesh the file elsewhere and give the .msh file".to_owned(),
            ),
            ..problem(format!("{name} is a geometry, which Gmsh meshes, and there is no program \"gmsh\""))
        },
        _ => problem(format!("cannot run Gmsh for {name}: {error}")),
    })?;
    let Some(status) = ended else {
        return Err(Problem {
            help: Some("take a larger mesh_size, or mesh the file by hand and give the .msh file".to_owned()),
            ..problem(format!(
                "Gmsh was stopped: it meshed {name} for more than {} s",
                brief(PATIENCE.as_secs_f64())
            ))
        });
    };
    match fs::read(&meshed) {
        Ok(bytes) if status.success() => Ok(bytes),
        _ => {
            let said = fs::read(&said).unwrap_or_default();
            // Gmsh saw a copy; people know the file by its name.
            let said = told(&String::from_utf8_lossy(&said).replace(&*geometry.to_string_lossy(), name));
            Err(problem(format!("Gmsh made no mesh of {name} ({status}){said}")))
        }
    }
}

/// The line of a `.geo` file that takes another file, with its first word.
fn other_file(bytes: &[u8], name: &str) -> Option<(usize, &'static str)> {
    if !name.to_ascii_lowercase().ends_with(".geo") {
        return None;
    }
    let text = String::from_utf8_lossy(bytes);
    let takes = |line: &str| {
        let line = line.trim_start();
        let statement = ["Merge", "Include", "#include", "ShapeFromFile"].into_iter().find(|word| {
            let rest = line.strip_prefix(word);
            rest.is_some_and(|rest| rest.trim_start().starts_with(['"', '<', '(', '\'']))
        });
        statement.or_else(|| line.contains("ShapeFromFile(").then_some("ShapeFromFile"))
    };
    (1..).zip(text.lines()).find_map(|(number, line)| Some((number, takes(line)?)))
}

/// Runs a program that works in a folder to its end; `None` if it had to be stopped after `patience`.
fn run(command: &mut Command, folder: &Path, patience: Duration) -> io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    {
        // Locked while it starts: it is stopped before or after.
        let mut running = running();
        *running = Some(Running { program: command.spawn()?, folder: folder.to_owned() });
    }
    loop {
        thread::sleep(LOOK);
        let mut guard = running();
        let Some(Running { program, .. }) = &mut *guard else { return Ok(None) };
        let ended = program.try_wait()?;
        if ended.is_none() && start.elapsed() <= patience {
            continue;
        }
        if ended.is_none() {
            program.kill()?;
            program.wait()?;
        }
        *guard = None;
        return Ok(ended);
    }
}

/// The errors that Gmsh printed, or else its last lines.
fn told(said: &str) -> String {
    let lines: Vec<&str> = said.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let errors: Vec<&str> = lines.iter().copied().filter(|line| line.starts_with("Error")).collect();
    let shown = if errors.is_empty() {
        &lines[lines.len().saturating_sub(LINES)..]
    } else {
        &errors[..errors.len().min(LINES)]
    };
    if shown.is_empty() { String::new() } else { format!(": {}", shown.join("; ")) }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_takes_too_long_is_stopped() {
        let folder = tempfile::tempdir().expect("a folder");
        let pid = folder.path().join("pid");
        let mut command = Command::new("sh");
        command.args(["-c", "echo $$ > \"$0\"; exec sleep 100"]).arg(&pid);
        let ended = run(&mut command, folder.path(), Duration::from_millis(500)).expect("a program");
        assert_eq!(ended, None);
        let pid = fs::read_to_string(&pid).expect("its number");
        let alive = Command::new("kill").args(["-0", pid.trim()]).stderr(Stdio::null()).status();
        assert!(!alive.expect("kill").success(), "it still runs");
        let ended = run(Command::new("sh").args(["-c", "exit 3"]), folder.path(), PATIENCE);
        assert_eq!(ended.expect("a program").and_then(|status| status.code()), Some(3));
    }
}
