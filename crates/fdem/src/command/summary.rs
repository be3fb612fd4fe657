//! Summary of a detection.

use std::fmt;

use fdem_results::analysis::Analysis;
use fdem_results::detection::{Detection, DetectionRequest};
use fdem_results::network::{Sizes, Space};
use serde::Serialize;

use crate::command::analyse::write_lines;
use crate::command::cutoff::PairCutoff;
use crate::command::input::{Input, id};

pub(crate) use fdem_io::numbers::{brief, grouped};

/// The summary, written as JSON by `--json` and as text to standard error.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) file: String,
    pub(crate) format: String,
    /// Number of the frame from 0, in a file of several frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) frame: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) step: Option<i64>,
    /// Time of the frame in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) time: Option<f64>,
    /// Columns that were read, as `role=name`.
    pub(crate) columns: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) unit: Option<String>,
    skipped_lines: u64,
    pub(crate) elements: usize,
    pub(crate) dimensions: usize,
    /// Elements of radius zero.
    points: usize,
    /// Number of bodies. Elements of the same body form no couple.
    #[serde(skip_serializing_if = "Option::is_none")]
    bodies: Option<usize>,
    /// Smallest and largest radius; absent without elements.
    radius: Option<[f64; 2]>,
    /// Whether the file has radii which `--radius` or `--cutoff` replaces; absent if not.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    unused_radii: bool,
    /// The box around all elements, `[min, max]` per axis; empty without elements.
    domain: Vec<[f64; 2]>,
    /// Distance at which points touch, in place of discs or spheres.
    #[serde(skip_serializing_if = "Option::is_none")]
    cutoff: Option<f64>,
    /// Distances at which points of these types touch.
    #[serde(skip_serializing_if = "Option::is_none")]
    cutoffs: Option<Vec<PairCutoff>>,
    tolerance: f64,
    /// Periodic box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) periodic: Option<Periodic>,
    /// A box of the file that does not repeat.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    still_box: Option<StillBox>,
    engine: &'static str,
    reason: String,
    cell_size: Option<f64>,
    cells: Option<Vec<u64>>,
    /// Number of threads as given; 0 is one per processor.
    threads: usize,
    pub(crate) couples: u64,
    /// Number of couples of an element with its own image; absent if there is none.
    #[serde(skip_serializing_if = "is_zero")]
    own_images: u64,
    /// Number of couples of an element with a periodic image of another one at the same place; absent if
    /// there is none.
    #[serde(skip_serializing_if = "is_zero")]
    repeated_images: u64,
    pub(crate) mean_coordination: f64,
    /// Elements without contact.
    pub(crate) rattlers: u64,
    pub(crate) max_overlap: Option<f64>,
    /// The two elements that overlap most.
    max_overlap_couple: Option<[i64; 2]>,
    /// Displacement of the second of them, in edges of the box.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_overlap_shift: Option<Vec<i32>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) verified: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    analysis: Option<Analysis>,
    pub(crate) seconds: Seconds,
    peak_bytes: Option<u64>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}

#[derive(Debug, Serialize)]
pub(crate) struct Periodic {
    /// Letters of the edges that repeat.
    pub(crate) axes: String,
    origin: Vec<f64>,
    edges: Vec<Vec<f64>>,
    /// `file` or `options`.
    pub(crate) from: &'static str,
}

#[derive(Debug, Serialize)]
struct StillBox {
    origin: Vec<f64>,
    edges: Vec<Vec<f64>>,
}

/// Wall-clock time of each phase.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) read: f64,
    pub(crate) detect: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) verify: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) analyse: Option<f64>,
    pub(crate) write: f64,
}

impl Summary {
    pub(crate) fn new<const D: usize>(
        input: &Input,
        space: &Space<'_, D>,
        box_of_file: bool,
        request: &DetectionRequest<'_>,
        found: &Detection<D>,
        verified: Option<usize>,
        seconds: Seconds,
    ) -> Self {
        let Input { name, packing, bodies, .. } = input;
        let centres = space.centres;
        let periodic = space.cell.map(|cell| Periodic {
            axes: "xyz"
                .chars()
                .zip(cell.periodic())
                .filter(|(_, repeats)| *repeats)
                .map(|(axis, _)| axis)
                .collect(),
            origin: cell.origin().to_vec(),
            edges: cell.edges().iter().map(|edge| edge.to_vec()).collect(),
            from: if box_of_file { "file" } else { "options" },
        });
        let still_box = packing.cell.filter(|_| periodic.is_none()).map(|cell| StillBox {
            origin: cell.origin[..D].to_vec(),
            edges: cell.edges[..D].iter().map(|edge| edge[..D].to_vec()).collect(),
        });
        let cutoff = if let Sizes::Cutoff(cutoff) = request.sizes { Some(cutoff) } else { None };
        let of_points = request.sizes.are_points();
        let extent = |index| if of_points { 0.0 } else { request.sizes.radius(index) };
        let mut radius: Option<[f64; 2]> = None;
        let mut domain = Vec::new();
        for (index, centre) in centres.iter().enumerate() {
            let r = extent(index);
            radius = Some(radius.map_or([r, r], |[min, max]| [min.min(r), max.max(r)]));
            domain.resize(D, [f64::INFINITY, f64::NEG_INFINITY]);
            for (side, x) in domain.iter_mut().zip(centre) {
                *side = [side[0].min(x - r), side[1].max(x + r)];
            }
        }
        let max_overlap = found.statistics.max_overlap;
        let columns = packing.source.columns.iter();
        Self {
            file: name.clone(),
            format: packing.source.format.to_string(),
            frame: None,
            step: packing.frame.step,
            time: packing.frame.time,
            columns: columns.filter_map(|column| Some(format!("{}={}", column.role?, column.name))).collect(),
            unit: packing.source.unit.clone(),
            skipped_lines: packing.source.skipped.count,
            elements: centres.len(),
            dimensions: D,
            points: (0..centres.len()).filter(|&index| extent(index) == 0.0).count(),
            bodies: bodies.as_ref().map(|bodies| bodies.count),
            radius: radius.filter(|_| !of_points),
            unused_radii: packing.radii.is_some()
                && matches!(request.sizes, Sizes::All(_) | Sizes::Cutoff(_)),
            domain,
            cutoff,
            cutoffs: None,
            tolerance: request.tolerance,
            engine: found.plan.engine.name(),
            reason: found.plan.reason.clone(),
            cell_size: found.plan.cell_size,
            cells: found.plan.cells.map(|cells| cells.to_vec()),
            threads: request.threads,
            couples: found.statistics.couples,
            own_images: found.statistics.own_images,
            repeated_images: found.statistics.repeated,
            mean_coordination: found.statistics.mean_coordination(),
            rattlers: found.statistics.rattlers(),
            max_overlap: max_overlap.map(|(overlap, _)| overlap),
            max_overlap_couple: max_overlap
                .map(|(_, couple)| [couple.i, couple.j].map(|k| id(packing, k as usize))),
            max_overlap_shift: max_overlap
                .filter(|_| periodic.is_some())
                .map(|(_, couple)| couple.shift.to_vec()),
            periodic,
            still_box,
            verified,
            analysis: None,
            seconds,
            peak_bytes: None,
        }
    }

    /// For a cut-off by pairs of types.
    pub(crate) fn with_cutoffs(mut self, pairs: Option<&[PairCutoff]>) -> Self {
        self.cutoffs = pairs.map(<[PairCutoff]>::to_vec);
        self
    }

    pub(crate) fn with_analysis(mut self, analysis: Option<Analysis>) -> Self {
        self.analysis = analysis;
        self
    }

    /// For couples that were not searched but taken from a file.
    pub(crate) fn with_couples_of(mut self, file: &str) -> Self {
        self.engine = "none";
        self.reason = format!("the couples are those of {file}");
        (self.cell_size, self.cells) = (None, None);
        self
    }

    /// Records the peak memory of the process so far.
    pub(crate) fn measure_peak(&mut self) {
        self.peak_bytes = peak_bytes();
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |label: &str, text: String| writeln!(out, "{label:<16} {text}");
        let unit = self.unit.as_deref().map(|unit| format!(" {unit}")).unwrap_or_default();
        let shape = match (self.cutoff.is_some() || self.cutoffs.is_some(), self.dimensions) {
            (true, _) => "point",
            (false, 2) => "disc",
            (false, _) => "sphere",
        };

        line("file", format!("{}, {}: {}", self.file, self.format, self.columns.join(", ")))?;
        let radius = match self.radius {
            None => String::new(),
            Some([min, max]) if min == max => format!(", radius {}{unit}", brief(min)),
            Some([min, max]) => format!(", radius {} to {}{unit}", brief(min), brief(max)),
        };
        if let Some(frame) = told_frame(self.frame, self.step, self.time) {
            line("frame", frame)?;
        }
        let plural = if self.elements == 1 { "" } else { "s" };
        line(
            "elements",
            format!("{} {shape}{plural} in {}D{radius}", grouped(self.elements as u64), self.dimensions),
        )?;
        if self.unused_radii {
            line("", "the radii of the file are not used: an option replaces them".to_owned())?;
        }
        if let Some(cutoffs) = &self.cutoffs {
            let cutoffs: Vec<String> = cutoffs.iter().map(PairCutoff::to_string).collect();
            line("cut-off", format!("{}{unit}", cutoffs.join(", ")))?;
        } else if let Some(cutoff) = self.cutoff {
            line("cut-off", format!("{}{unit}", brief(cutoff)))?;
        } else if self.points > 0 {
            line("", format!("{} of radius zero: points", grouped(self.points as u64)))?;
        }
        if let Some(bodies) = self.bodies {
            line("bodies", format!("{}, without couples within a body", grouped(bodies as u64)))?;
        }
        if self.skipped_lines > 0 {
            let plural = if self.skipped_lines == 1 { "" } else { "s" };
            line("skipped", format!("{} bad line{plural}", grouped(self.skipped_lines)))?;
        }
        if !self.domain.is_empty() {
            let sides: Vec<_> =
                self.domain.iter().map(|[min, max]| format!("[{}, {}]", brief(*min), brief(*max))).collect();
            line("domain", format!("{}{unit}", sides.join(" x ")))?;
        }
        if self.tolerance > 0.0 {
            line("tolerance", format!("{}{unit}", self.tolerance))?;
        }
        let point = |point: &Vec<f64>| {
            let numbers: Vec<_> = point.iter().map(|&x| brief(x)).collect();
            format!("[{}]", numbers.join(", "))
        };
        let edges_of = |edges: &[Vec<f64>]| edges.iter().map(point).collect::<Vec<_>>().join(", ");
        if let Some(Periodic { axes, origin, edges, from }) = &self.periodic {
            let from = if *from == "file" { ", the box of the file" } else { "" };
            let (origin, edges) = (point(origin), edges_of(edges));
            line("periodic", format!("along {axes}: edges {edges}{unit} from {origin}{from}"))?;
        }
        if let Some(StillBox { origin, edges }) = &self.still_box {
            let (origin, edges) = (point(origin), edges_of(edges));
            line("box", format!("edges {edges}{unit} from {origin}, the box of the file: not periodic"))?;
        }
        line("engine", format!("{}: {}", self.engine, self.reason))?;
        if let (Some(size), Some(cells)) = (self.cell_size, &self.cells) {
            let cells: Vec<_> = cells.iter().map(|&n| grouped(n)).collect();
            line("cell edge", format!("{}{unit}, {} cells", brief(size), cells.join(" x ")))?;
        }
        line("couples", grouped(self.couples))?;
        if self.own_images > 0 {
            let own = grouped(self.own_images);
            line(
                "own images",
                format!("{own} of them: an element touches its own image, across the whole box"),
            )?;
        }
        line("coordination", format!("{:.4} contacts per element", self.mean_coordination))?;
        line("without contact", grouped(self.rattlers))?;
        if let (Some(overlap), Some([i, j])) = (self.max_overlap, self.max_overlap_couple) {
            let across = match &self.max_overlap_shift {
                Some(shift) if shift.iter().any(|&edges| edges != 0) => format!(", shift {shift:?}"),
                _ => String::new(),
            };
            line("largest overlap", format!("{}{unit} between {i} and {j}{across}", brief(overlap)))?;
        }
        if let Some(analysis) = &self.analysis {
            write_lines(out, analysis, &unit)?;
        }
        write_end(out, self.verified, &self.seconds, self.peak_bytes)
    }
}

/// Number, time step and time of a frame, as far as they are known; `None` if none is.
fn told_frame(frame: Option<usize>, step: Option<i64>, time: Option<f64>) -> Option<String> {
    let parts = [
        frame.map(|frame| frame.to_string()),
        step.map(|step| format!("time step {step}")),
        time.map(|time| format!("time {}", brief(time))),
    ];
    let parts: Vec<_> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// Writes the last lines of every summary: the number of verified elements, if there is one, times and peak
/// memory.
pub(crate) fn write_end(
    out: &mut fmt::Formatter<'_>,
    verified: Option<usize>,
    seconds: &Seconds,
    peak_bytes: Option<u64>,
) -> fmt::Result {
    let mut line = |label: &str, text: String| writeln!(out, "{label:<16} {text}");
    if let Some(verified) = verified {
        line("verified", format!("{} elements by brute force: no difference", grouped(verified as u64)))?;
    }
    let Seconds { read, detect, verify, analyse, write } = seconds;
    let verify = verify.map(|verify| format!(", verify {verify:.3} s")).unwrap_or_default();
    let analyse = analyse.map(|analyse| format!(", analyse {analyse:.3} s")).unwrap_or_default();
    line("time", format!("read {read:.3} s, detect {detect:.3} s{verify}{analyse}, write {write:.3} s"))?;
    if let Some(bytes) = peak_bytes {
        line("peak memory", format!("{:.1} MB", bytes as f64 / 1e6))?;
    }
    Ok(())
}

/// Peak resident memory of this process, bytes, on systems that report it.
///
/// `getrusage` is not used here, because its value survives the start of a program: under `cargo run` it
/// would include cargo.
#[cfg(target_os = "linux")]
pub(crate) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(peak.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// Peak resident memory of this process, bytes.
#[cfg(all(unix, not(target_os = "linux")))]
pub(crate) fn peak_bytes() -> Option<u64> {
    use nix::sys::resource::{UsageWho, getrusage};
    let usage = getrusage(UsageWho::RUSAGE_SELF).ok()?;
    // macOS counts bytes, the BSDs kilobytes.
    let unit = if cfg!(target_os = "macos") { 1 } else { 1024 };
    u64::try_from(usage.max_rss()).ok().map(|peak| peak * unit)
}

#[cfg(not(unix))]
pub(crate) fn peak_bytes() -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn peak_memory_is_in_bytes() {
        let ballast = std::hint::black_box(vec![1_u8; 64 << 20]);
        let peak = peak_bytes().unwrap();
        assert!(peak > ballast.len() as u64 && peak < 64 << 30, "{peak}");
    }
}
