//! What a run leaves behind: frames and history while it goes, plots, animation and report at its end.

use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};

use fdem_simulation::Simulation;

use crate::command::failure::{Failure, display_name};
use crate::command::run::folder::{Folder, HISTORY, PLOTS, cracks_file, mesh_file, packed_file};
use crate::model::{Prepared, Quantity};
use crate::results::{
    Animation, Field, Frame, FrameView, History, HistoryWriter, Pictures, Range, Report, Row, kept, plots,
    pvd, write_cracks_vtp, write_vtu,
};

/// Between two pictures of an animation, in hundredths of a second.
const DELAY: u16 = 8;

/// Records a run in its folder.
pub(crate) struct Recorder {
    folder: Folder,
    history: HistoryWriter<BufWriter<File>>,
    /// Step and time of those written.
    pub(crate) frames: Vec<(u64, f64)>,
}

impl Recorder {
    /// For a run from the beginning.
    pub(crate) fn new(folder: &Folder, prepared: &Prepared) -> Result<Self, Failure> {
        let path = folder.path(HISTORY);
        let names = names(prepared);
        let history = File::create(&path)
            .and_then(|file| HistoryWriter::new(BufWriter::new(file), &names))
            .map_err(|error| Failure::writing(&path, error))?;
        Ok(Self { folder: folder.clone(), history, frames: Vec::new() })
    }

    /// For a run that goes on after a checkpoint: what is later is removed, what was there before has to be there still.
    pub(crate) fn going_on(
        folder: &Folder,
        prepared: &Prepared,
        step: u64,
        frames: Vec<(u64, f64)>,
        length: u64,
    ) -> Result<Self, Failure> {
        let path = folder.path(HISTORY);
        let text = folder.read(HISTORY)?;
        let end =
            kept(&text, step).map_err(|error| Failure::Unusable(format!("{}: {error}", path.display())))?;
        if (end as u64) < length {
            return Err(Failure::Unusable(format!(
                "{}: rows before step {step} are missing: {} of {length} bytes are left",
                display_name(&path),
                text.len()
            )));
        }
        for number in 0..frames.len() {
            for name in [mesh_file(number), cracks_file(number)] {
                let path = folder.path(&name);
                fs::metadata(&path).map_err(|error| Failure::reading(&display_name(&path), &error))?;
            }
            let name = packed_file(number);
            Frame::from_bytes(&folder.read(&name)?).map_err(|error| {
                Failure::Unusable(format!("{}: {error}", display_name(&folder.path(&name))))
            })?;
        }
        let history = OpenOptions::new()
            .append(true)
            .open(&path)
            .and_then(|file| file.set_len(end as u64).map(|()| file))
            .map_err(|error| Failure::writing(&path, error))?;
        let mut later = frames.len();
        loop {
            let files = [mesh_file(later), cracks_file(later), packed_file(later)];
            let removed = files.iter().filter(|name| fs::remove_file(folder.path(name)).is_ok()).count();
            if removed == 0 {
                break;
            }
            later += 1;
        }
        let history = HistoryWriter::going_on(BufWriter::new(history), names(prepared).len());
        let recorder = Self { folder: folder.clone(), history, frames };
        recorder.collections()?;
        Ok(recorder)
    }

    /// A row of the history.
    pub(crate) fn row(&mut self, run: &Simulation, prepared: &Prepared) -> Result<(), Failure> {
        let mut values = Vec::new();
        for history in &prepared.histories {
            match history.quantity {
                Quantity::Node(node) => {
                    let (moved, velocity) = run.node(node).unwrap_or_default();
                    values.extend(moved.into_iter().chain(velocity));
                }
                Quantity::Force(boundary) => values.extend(run.force(boundary).unwrap_or_default()),
                Quantity::Energy | Quantity::CrackLength => {}
            }
        }
        let row = Row {
            step: run.steps(),
            time: run.time(),
            energies: run.energies(),
            broken: run.counts().broken as u64,
            lengths: run.crack_lengths(),
            values,
        };
        self.history.row(&row).map_err(|error| Failure::writing(&self.folder.path(HISTORY), error))
    }

    /// Files of the bodies and cracks as they are.
    pub(crate) fn frame(&mut self, run: &Simulation) -> Result<(), Failure> {
        let snapshot = run.snapshot();
        let number = self.frames.len();
        let (mut mesh, mut cracks) = (Vec::new(), Vec::new());
        // Memory does not refuse to be written to; a snapshot that contradicts itself would be a fault of ours.
        write_vtu(&mut mesh, &snapshot)
            .and_then(|()| write_cracks_vtp(&mut cracks, &snapshot))
            .map_err(|error| Failure::writing(&self.folder.path(&mesh_file(number)), error))?;
        let frame = Frame::new(&snapshot)
            .map_err(|error| Failure::writing(&self.folder.path(&packed_file(number)), error))?;
        self.folder.write(&mesh_file(number), &mesh)?;
        self.folder.write(&cracks_file(number), &cracks)?;
        self.folder.write(&packed_file(number), &frame.to_bytes())?;
        self.frames.push((run.steps(), run.time()));
        self.collections()
    }

    /// What ParaView opens.
    fn collections(&self) -> Result<(), Failure> {
        for (name, file_of) in
            [("results.pvd", mesh_file as fn(usize) -> String), ("cracks.pvd", cracks_file)]
        {
            let files: Vec<String> = (0..self.frames.len()).map(file_of).collect();
            let entries = self.frames.iter().zip(&files).map(|(&(_, time), file)| (time, file.as_str()));
            self.folder.write(name, pvd(entries).as_bytes())?;
        }
        Ok(())
    }

    /// Of the history as it is on the disk, bytes.
    pub(crate) fn length(&self) -> Result<u64, Failure> {
        let path = self.folder.path(HISTORY);
        fs::metadata(&path)
            .map(|metadata| metadata.len())
            .map_err(|error| Failure::reading(&display_name(&path), &error))
    }

    /// The rows so far are on the disk.
    pub(crate) fn flush(&mut self) -> Result<(), Failure> {
        let out = self.history.get_mut();
        let done = out.flush().and_then(|()| out.get_ref().sync_all());
        done.map_err(|error| Failure::writing(&self.folder.path(HISTORY), error))
    }

    /// Plots, pictures, animation and report of what has been recorded. `facts`: the rows of the summary.
    pub(crate) fn finish(&mut self, prepared: &Prepared, facts: &[(&str, &str)]) -> Result<(), Failure> {
        self.flush()?;
        let text = self.folder.read(HISTORY)?;
        let broken =
            |what: &str, error: &dyn std::fmt::Display| Failure::Unusable(format!("{what}: {error}"));
        let history = History::read(&text).map_err(|error| broken(HISTORY, &error))?;
        let drawn = plots(&history);
        self.folder.make(PLOTS)?;
        for plot in &drawn {
            let name = format!("{PLOTS}/{}", plot.name);
            self.folder.write(&format!("{name}.svg"), plot.svg.as_bytes())?;
            let png = plot.png(None).map_err(|error| broken(&name, &error))?;
            self.folder.write(&format!("{name}.png"), &png)?;
        }
        let frames = (0..self.frames.len())
            .map(|number| {
                let name = packed_file(number);
                let bytes = self.folder.read(&name)?;
                Frame::from_bytes(&bytes).map_err(|error| broken(&name, &error))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let title = if prepared.title.is_empty() { "fdem" } else { &prepared.title };
        let view = FrameView::of(&frames);
        let pictures = |field| Pictures { title, field, range: Range::of(&frames, field), view };
        let field = prepared.output.fields.first().copied().unwrap_or(Field::MaxPrincipal);
        if let Some(last) = frames.last() {
            let png = pictures(field).png(last, None).map_err(|error| broken("picture.png", &error))?;
            self.folder.write("picture.png", &png)?;
        }
        if let Some(asked) = prepared.output.animate {
            let mut animation = Animation::new(pictures(asked), None, DELAY);
            for frame in &frames {
                animation.push(frame).map_err(|error| broken("animation.gif", &error))?;
            }
            let gif = animation.finish().map_err(|error| broken("animation.gif", &error))?;
            self.folder.write("animation.gif", &gif)?;
        }
        let materials: Vec<&str> =
            prepared.model.materials.iter().map(|material| material.name.as_str()).collect();
        let report = Report { title, facts, plots: &drawn, frames: &frames, field, materials: &materials };
        let html = report.html().map_err(|error| broken("report.html", &error))?;
        self.folder.write("report.html", html.as_bytes())
    }
}

/// Columns of the histories that were asked for.
fn names(prepared: &Prepared) -> Vec<String> {
    let mut names = Vec::new();
    for history in &prepared.histories {
        let parts: &[&str] = match history.quantity {
            Quantity::Node(_) => &["ux [m]", "uy [m]", "vx [m/s]", "vy [m/s]"],
            Quantity::Force(_) => &["fx [N]", "fy [N]"],
            // These are there anyway.
            Quantity::Energy | Quantity::CrackLength => &[],
        };
        names.extend(parts.iter().map(|part| format!("{} {part}", history.name)));
    }
    names
}
