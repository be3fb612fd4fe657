//! Geometries that Gmsh meshes: it is run as a program of its own.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use fdem_io::numbers::brief;

use crate::model::mesh_file::Problem;

/// Ends of the names of files that Gmsh meshes.
const GEOMETRIES: [&str; 6] = [".geo", ".step", ".stp", ".iges", ".igs", ".brep"];

/// Time after which Gmsh is stopped.
const PATIENCE: Duration = Duration::from_secs(600);

/// Time between two looks at whether Gmsh has ended.
const LOOK: Duration = Duration::from_millis(20);

/// Lines of what Gmsh says that are shown.
const LINES: usize = 5;

/// Whether a file has a geometry, not a mesh, by the end of its name.
pub(crate) fn is_geometry(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    GEOMETRIES.iter().any(|end| name.ends_with(end))
}

/// The mesh that Gmsh makes of a geometry with edges of `size` m at most, as a file.
///
/// Gmsh sees the file alone, in a folder of its own: a file that includes others is not found there.
///
/// # Errors
/// Says that Gmsh is not installed, is stopped, or fails, with what it says.
pub(crate) fn mesh(bytes: &[u8], name: &str, size: f64, dimensions: usize) -> Result<Vec<u8>, Problem> {
    let problem = |message: String| Problem::new("mesh", message);
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
    let started = Command::new("gmsh")
        .arg(format!("-{dimensions}"))
        .args(["-nt", "1", "-order", "1", "-format", "msh22", "-clmax", &size.to_string(), "-o"])
        .arg(&meshed)
        .arg(&geometry)
        .stdin(Stdio::null())
        .stdout(output)
        .stderr(errors)
        .spawn();
    let mut gmsh = started.map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Problem {
            help: Some(
                "install Gmsh (gmsh.info), or mesh the file elsewhere and give the .msh file".to_owned(),
            ),
            ..problem(format!("{name} is a geometry, which Gmsh meshes, and there is no program \"gmsh\""))
        },
        _ => problem(format!("cannot run Gmsh for {name}: {error}")),
    })?;
    let ended = wait(&mut gmsh).map_err(|error| problem(format!("cannot wait for Gmsh: {error}")))?;
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

/// Waits for the end of a program; `None` if it had to be stopped.
fn wait(program: &mut Child) -> io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    loop {
        if let Some(status) = program.try_wait()? {
            return Ok(Some(status));
        }
        if start.elapsed() > PATIENCE {
            program.kill()?;
            program.wait()?;
            return Ok(None);
        }
        thread::sleep(LOOK);
    }
}

/// The errors that Gmsh told, or else its last lines.
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
