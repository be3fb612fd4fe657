//! Summary of a series of frames: a line per frame, and totals.

use std::fmt;

use crate::command::summary::{Seconds, Summary, brief, grouped, peak_bytes, write_end};

/// Summaries of the frames. In JSON they are an array.
pub(crate) struct SeriesSummary {
    pub(crate) frames: Vec<Summary>,
    /// Number of frames in the file.
    of: usize,
    seconds: Seconds,
    peak_bytes: Option<u64>,
}

const HEADER: [&str; 8] =
    ["frame", "step", "time", "elements", "couples", "coordination", "without contact", "largest overlap"];

impl SeriesSummary {
    /// Creates an empty summary. `of`: the number of frames in the file; `opening`: the time to open it, s.
    pub(crate) fn new(of: usize, opening: f64) -> Self {
        let seconds = Seconds { read: opening, ..Seconds::default() };
        Self { frames: Vec::new(), of, seconds, peak_bytes: None }
    }

    pub(crate) fn push(&mut self, frame: Summary) {
        let Seconds { read, detect, verify, analyse, write } = frame.seconds;
        self.seconds.read += read;
        self.seconds.detect += detect;
        self.seconds.write += write;
        if let Some(verify) = verify {
            *self.seconds.verify.get_or_insert(0.0) += verify;
        }
        if let Some(analyse) = analyse {
            *self.seconds.analyse.get_or_insert(0.0) += analyse;
        }
        self.frames.push(frame);
    }

    /// Records the peak memory of the process so far.
    pub(crate) fn measure_peak(&mut self) {
        self.peak_bytes = peak_bytes();
    }
}

fn cells(frame: &Summary) -> [String; 8] {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    [
        or_dash(frame.frame.map(|frame| frame.to_string())),
        or_dash(frame.step.map(|step| step.to_string())),
        or_dash(frame.time.map(brief)),
        grouped(frame.elements as u64),
        grouped(frame.couples),
        format!("{:.4}", frame.mean_coordination),
        grouped(frame.rattlers),
        or_dash(frame.max_overlap.map(brief)),
    ]
}

impl fmt::Display for SeriesSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(first) = self.frames.first() else { return Ok(()) };
        let line =
            |out: &mut fmt::Formatter<'_>, label: &str, text: String| writeln!(out, "{label:<16} {text}");
        line(out, "file", format!("{}, {}: {}", first.file, first.format, first.columns.join(", ")))?;
        let of = if self.of == self.frames.len() {
            String::new()
        } else {
            format!(" of {}", grouped(self.of as u64))
        };
        line(out, "frames", format!("{}{of}", grouped(self.frames.len() as u64)))?;
        if let Some(periodic) = &first.periodic {
            let whose =
                if periodic.from == "file" { "each frame in its own box" } else { "all in the box given" };
            line(out, "periodic", format!("along {}, {whose}", periodic.axes))?;
        }
        let rows: Vec<[String; 8]> =
            std::iter::once(HEADER.map(str::to_owned)).chain(self.frames.iter().map(cells)).collect();
        let widths: [usize; 8] =
            std::array::from_fn(|column| rows.iter().map(|row| row[column].len()).max().unwrap_or(0));
        for row in &rows {
            let cells: Vec<_> =
                row.iter().zip(widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
            writeln!(out, "{}", cells.join("  "))?;
        }
        let sum = |count: fn(&Summary) -> u64| grouped(self.frames.iter().map(count).sum());
        let (elements, couples) = (sum(|frame| frame.elements as u64), sum(|frame| frame.couples));
        line(out, "in all", format!("{elements} elements, {couples} couples"))?;
        let verified = self.frames.iter().map(|frame| frame.verified).sum();
        write_end(out, verified, &self.seconds, self.peak_bytes)
    }
}
