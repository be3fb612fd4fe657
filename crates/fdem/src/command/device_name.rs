//! The names of devices.

use std::str::FromStr;

/// A device by its name: `cpu`, `gpu`, or `gpu:N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceName {
    /// The processor.
    Cpu,
    /// The graphics processor with this number.
    Gpu(usize),
}

impl FromStr for DeviceName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = match text {
            "cpu" => return Ok(Self::Cpu),
            "gpu" => Some(0),
            _ => text.strip_prefix("gpu:").and_then(|number| number.parse().ok()),
        };
        number
            .map(Self::Gpu)
            .ok_or_else(|| "give cpu, gpu, or gpu:N with a number of fdem devices".to_owned())
    }
}
