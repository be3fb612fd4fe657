//! Summary of the contacts of meshes.

use std::fmt;

use serde::Serialize;

use crate::command::summary::{Seconds, brief, grouped, peak_bytes, write_end};

/// The summary, written as JSON by `--json` and as text to standard error.
#[derive(Debug, Serialize)]
pub(crate) struct MeshSummary {
    pub(crate) files: Vec<FileOf>,
    pub(crate) bodies_of_meshes: Vec<BodyOf>,
    pub(crate) dimensions: usize,
    pub(crate) elements: usize,
    pub(crate) bodies: usize,
    pub(crate) engine: &'static str,
    /// Number of threads as given; 0 is one per processor.
    pub(crate) threads: usize,
    pub(crate) couples: usize,
    pub(crate) couples_by_kind: Couples,
    /// Pairs of bodies that touch, and bodies that touch themselves.
    pub(crate) body_contacts: usize,
    /// Mean number of contacts of a body with other bodies.
    pub(crate) mean_coordination: f64,
    /// Number of bodies without contact.
    pub(crate) without_contact: usize,
    /// Overlap, as a sum over all contacts; `shared` is the sum of the shared boundaries.
    pub(crate) overlap: f64,
    pub(crate) shared: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) verified: Option<usize>,
    pub(crate) seconds: Seconds,
    pub(crate) peak_bytes: Option<u64>,
}

/// Number of couples of each kind.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Couples {
    pub(crate) meshes: usize,
    pub(crate) spheres: usize,
    pub(crate) spheres_and_meshes: usize,
}

/// A file and the elements taken from it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FileOf {
    pub(crate) file: String,
    pub(crate) format: String,
    pub(crate) elements: usize,
    /// Kind of the elements.
    pub(crate) kind: &'static str,
    pub(crate) bodies: u32,
    /// Number of the first body of this file.
    pub(crate) first_body: u32,
    pub(crate) bodies_from: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) left_out: Option<LeftOut>,
    /// Differences between the file and the elements, one sentence each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) notes: Vec<String>,
}

/// Elements of a mesh that are not compared.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct LeftOut {
    pub(crate) triangles: usize,
    pub(crate) segments: usize,
    pub(crate) points: u64,
    pub(crate) collapsed_facets: u64,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.triangles as u64, "triangles"),
            (self.segments as u64, "segments"),
            (self.points, "points"),
            (self.collapsed_facets, "facets without area"),
        ];
        let parts: Vec<_> = counts
            .iter()
            .filter(|(n, _)| *n > 0)
            .map(|(n, what)| format!("{} {what}", grouped(*n)))
            .collect();
        if parts.is_empty() { Ok(()) } else { write!(out, ", without {}", parts.join(", ")) }
    }
}

/// A body of a mesh.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct BodyOf {
    /// Number of the body in the tables.
    pub(crate) body: u32,
    /// Index of its file in `files`.
    pub(crate) file: usize,
    /// Number of the body in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) number: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) name: Option<String>,
    pub(crate) elements: usize,
}

impl MeshSummary {
    /// Records the peak memory of the process so far.
    pub(crate) fn measure_peak(&mut self) {
        self.peak_bytes = peak_bytes();
    }

    /// The overlap and the shared boundary in words. Files of meshes do not name their unit of length.
    fn measures(&self) -> [&'static str; 2] {
        let has = |kind: &str| self.files.iter().any(|file| file.kind == kind);
        match (self.dimensions, has("tetrahedra"), has("triangles")) {
            (2, ..) => ["an area, in units of the file squared", "a length, in units of the file"],
            (_, true, false) => {
                ["a volume, in units of the file cubed", "an area, in units of the file squared"]
            }
            (_, false, _) => [
                "length of the lines in which surfaces cross, in units of the file",
                "an area, in units of the file squared",
            ],
            (_, true, true) => [
                "volumes of tetrahedra and lengths of the lines in which surfaces cross, in units of the file",
                "an area, in units of the file squared",
            ],
        }
    }
}

impl fmt::Display for MeshSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |label: &str, text: String| writeln!(out, "{label:<16} {text}");
        for file in &self.files {
            let left_out = file.left_out.map(|left_out| left_out.to_string()).unwrap_or_default();
            line(
                "file",
                format!(
                    "{}, {}: {} {}{left_out}",
                    file.file,
                    file.format,
                    grouped(file.elements as u64),
                    file.kind
                ),
            )?;
            let (first, last) = (file.first_body, (file.first_body + file.bodies).saturating_sub(1));
            let numbers = match file.bodies {
                0 => "none".to_owned(),
                1 => format!("{first}"),
                _ => format!("{} to {}", grouped(first.into()), grouped(last.into())),
            };
            line("  bodies", format!("{numbers}: {}", file.bodies_from))?;
            file.notes.iter().try_for_each(|note| line("  note", note.clone()))?;
        }
        line("elements", format!("{} in {}D", grouped(self.elements as u64), self.dimensions))?;
        line("bodies", grouped(self.bodies as u64))?;
        let Couples { meshes, spheres, spheres_and_meshes } = self.couples_by_kind;
        line("couples", grouped(self.couples as u64))?;
        if spheres > 0 || spheres_and_meshes > 0 {
            let [a, b, c] = [spheres, spheres_and_meshes, meshes].map(|n| grouped(n as u64));
            line(
                "",
                format!("{a} between spheres, {b} between spheres and triangles, {c} between triangles"),
            )?;
        }
        line("body contacts", grouped(self.body_contacts as u64))?;
        line("coordination", format!("{:.4} contacts per body", self.mean_coordination))?;
        line("without contact", grouped(self.without_contact as u64))?;
        if spheres == 0 && spheres_and_meshes == 0 {
            let [overlap, shared] = self.measures();
            line("overlap", format!("{} ({overlap})", brief(self.overlap)))?;
            line("shared boundary", format!("{} ({shared})", brief(self.shared)))?;
        }
        write_end(out, self.verified, &self.seconds, self.peak_bytes)
    }
}
