//! Summary of the contacts in a labelled image.

use std::fmt;

use serde::Serialize;

use crate::command::summary::{Seconds, brief, grouped, peak_bytes, write_end};

/// The summary, written as JSON by `--json` and as text to standard error. Axes are in the order x, y, z.
#[derive(Debug, Serialize)]
pub(crate) struct LabelSummary {
    pub(crate) file: String,
    pub(crate) format: String,
    /// Pixels or voxels along each axis.
    pub(crate) shape: Vec<usize>,
    pub(crate) spacing: Vec<f64>,
    /// Label of the background; absent if every number is a body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) background: Option<i128>,
    /// Number of different labels without the background.
    pub(crate) bodies: usize,
    pub(crate) neighbourhood: &'static str,
    /// Number of threads as given; 0 is one per processor.
    pub(crate) threads: usize,
    pub(crate) contacts: usize,
    pub(crate) mean_coordination: f64,
    /// Number of bodies without contact.
    pub(crate) without_contact: usize,
    /// Number of shared faces, as a sum over all contacts. `edges`, `vertices` and `area` are such sums too.
    pub(crate) faces: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) edges: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) vertices: Option<u64>,
    /// Area of the shared faces; in 2D the length of the shared sides.
    pub(crate) area: f64,
    pub(crate) seconds: Seconds,
    pub(crate) peak_bytes: Option<u64>,
}

impl LabelSummary {
    /// Records the peak memory of the process so far.
    pub(crate) fn measure_peak(&mut self) {
        self.peak_bytes = peak_bytes();
    }
}

impl fmt::Display for LabelSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |label: &str, text: String| writeln!(out, "{label:<16} {text}");
        let by = |parts: Vec<String>| parts.join(" x ");
        let is_2d = self.shape.len() == 2;
        line("file", format!("{}, {}", self.file, self.format))?;
        let shape = by(self.shape.iter().map(|&n| grouped(n as u64)).collect());
        let spacing = by(self.spacing.iter().map(|&edge| brief(edge)).collect());
        let (square, axes) = if is_2d { ("pixels", "x, y") } else { ("voxels", "x, y, z") };
        line("image", format!("{shape} {square} ({axes}) of {spacing}"))?;
        let background = match self.background {
            Some(label) => format!(", background {label}"),
            None => ", no background".to_owned(),
        };
        line("bodies", format!("{}{background}", grouped(self.bodies as u64)))?;
        line("neighbours", format!("share a {}", self.neighbours()))?;
        line("contacts", grouped(self.contacts as u64))?;
        line("coordination", format!("{:.4} contacts per body", self.mean_coordination))?;
        line("without contact", grouped(self.without_contact as u64))?;
        let measure = if is_2d { "length" } else { "area" };
        line("shared faces", format!("{}, {measure} {}", grouped(self.faces), brief(self.area)))?;
        if let Some(edges) = self.edges {
            line("shared edges", format!("{} without a shared face", grouped(edges)))?;
        }
        if let Some(vertices) = self.vertices {
            line("shared vertices", format!("{} without a shared face or edge", grouped(vertices)))?;
        }
        write_end(out, None, &self.seconds, self.peak_bytes)
    }
}

impl LabelSummary {
    /// Names the parts that neighbours may share.
    fn neighbours(&self) -> &'static str {
        match (self.neighbourhood, self.shape.len()) {
            ("face", _) => "face",
            ("edge", _) => "face or edge",
            (_, 2) => "face or vertex",
            _ => "face, edge or vertex",
        }
    }
}
