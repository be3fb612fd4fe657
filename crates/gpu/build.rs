//! Compiles the kernels for the processor, for tests, and takes over compiled kernels that a release ships.

fn main() -> Result<(), String> {
    println!("cargo::rerun-if-changed=kernels");
    shipped()?;
    #[cfg(feature = "host")]
    {
        // Threads in both orders: a phase that reads a number which another thread writes in it has two
        // results. And with contraction, to see that the tests would find it.
        host("ascending", &["-ffp-contract=off"]);
        host("descending", &["-ffp-contract=off", "-DDESCENDING"]);
        let fused = std::env::var("CARGO_CFG_TARGET_ARCH").is_ok_and(|name| name == "x86_64");
        host("contracted", if fused { &["-ffp-contract=fast", "-mfma"] } else { &["-ffp-contract=fast"] });
    }
    Ok(())
}

/// Puts the file that `FDEM_PTX` names, as the example `ptx` writes it, where `src/cuda.rs` finds it.
fn shipped() -> Result<(), String> {
    println!("cargo::rerun-if-env-changed=FDEM_PTX");
    let mut text = String::new();
    if let Ok(file) = std::env::var("FDEM_PTX") {
        println!("cargo::rerun-if-changed={file}");
        text = std::fs::read_to_string(&file).map_err(|error| format!("FDEM_PTX={file}: {error}"))?;
    }
    let out = std::env::var("OUT_DIR").map_err(|error| format!("OUT_DIR: {error}"))?;
    let file = std::path::Path::new(&out).join("kernels.ptx");
    std::fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))
}

/// Compiles all kernels as a build with this name.
#[cfg(feature = "host")]
fn host(name: &str, options: &[&str]) {
    let mut build = cc::Build::new();
    build.cpp(true).std("c++17").opt_level(2).define("BUILD", name).file("kernels/all.cpp");
    for option in options {
        build.flag(option);
    }
    build.compile(&format!("fdem_kernels_{name}"));
}
