//! Reports the package to install if the feature `mpi` is on and there is no MPI library. The message of the
//! crate that looks for it does not name the packages.

use std::env;
use std::process::{Command, Stdio, exit};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=MPICC");
    println!("cargo:rerun-if-env-changed=PATH");
    let is_named = ["MPI_PKG_CONFIG", "CRAY_MPICH_DIR"].iter().any(|name| env::var_os(name).is_some());
    if env::var_os("CARGO_FEATURE_MPI").is_none() || is_named || cfg!(windows) {
        return;
    }
    let compiler = env::var_os("MPICC").unwrap_or_else(|| "mpicc".into());
    let shown = Command::new(&compiler).arg("-show").stdout(Stdio::null()).stderr(Stdio::null()).status();
    // Without the wrapper, the library may still be found by pkg-config.
    let packaged = |name: &str| {
        let found = Command::new("pkg-config").arg("--exists").arg(name).stderr(Stdio::null()).status();
        found.is_ok_and(|status| status.success())
    };
    if !shown.is_ok_and(|status| status.success()) && !packaged("ompi") && !packaged("mpich") {
        eprintln!(
            "error: the feature `mpi` needs an MPI library, and `{}` cannot be run.\n\
             Install one and libclang, which reads its header:\n\
             \x20 Debian, Ubuntu   apt install libopenmpi-dev openmpi-bin libclang-dev\n\
             \x20 Fedora           dnf install openmpi-devel clang-devel, then module load mpi\n\
             \x20 macOS            brew install open-mpi llvm\n\
             \x20 a cluster        module load the MPI of the cluster\n\
             or set MPICC to the compiler wrapper of your MPI library. Without `--features mpi` nothing of this is needed.",
            compiler.to_string_lossy()
        );
        exit(1);
    }
}
