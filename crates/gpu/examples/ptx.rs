//! Writes the kernels in PTX, for a release to ship: `FDEM_PTX=FILE cargo build` takes them over. Needs the
//! library libnvrtc, and no device.

use std::io::Write;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = fdem_gpu::compile_to_ship()?;
    Ok(std::io::stdout().write_all(text.as_bytes())?)
}
