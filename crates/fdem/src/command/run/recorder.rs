//! Writes the results of a run: frames and history during the run, plots, animation and report at its end.

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::sync::atomic::Ordering;

use fdem_simulation::{Simulation, Target};

use crate::command::failure::{Failure, display_name};
use crate::command::progress::Position;
use crate::command::run::folder::{
    COLLECTIONS, Folder, HISTORY, MODEL, PLOTS, REPORT, contacts_file, cracks_file, damaged_file, mesh_file,
    packed_file,
};
use crate::model::{History as Recorded, Prepared, Quantity};
use crate::results::{
    Animation, Field, Frame, FrameView, History, HistoryWriter, Names, Outlines, Pictures, Plot, Range,
    Report, Row, kept, plots, pvd, write_contacts_vtp, write_cracks_vtp, write_damaged_joints_vtp, write_vtu,
};

/// Time between two pictures of an animation, in hundredths of a second.
const DELAY: u16 = 8;

/// Writes the results of a run into its folder.
pub(crate) struct Recorder {
    folder: Folder,
    history: HistoryWriter<BufWriter<File>>,
    names: Names,
    outlines: Outlines,
    /// Nodes of the boundary of each history of a force; empty for other histories.
    targets: Vec<Vec<u32>>,
    /// Step and time, s, of each frame that has been written.
    pub(crate) frames: Vec<(u64, f64)>,
    /// Most elements of a frame that the report shows completely, and number of triangles in the samples of larger frames.
    shown: [usize; 2],
}

impl Recorder {
    /// Starts the records of a new run.
    pub(crate) fn new(folder: &Folder, prepared: &Prepared) -> Result<Self, Failure> {
        let path = folder.path(HISTORY);
        let names = columns(prepared);
        let history = File::create(&path)
            .and_then(|file| HistoryWriter::new(BufWriter::new(file), &names))
            .map_err(|error| Failure::writing(&path, error))?;
        Ok(Self::with(folder, prepared, history, Vec::new()))
    }

    fn with(
        folder: &Folder,
        prepared: &Prepared,
        history: HistoryWriter<BufWriter<File>>,
        frames: Vec<(u64, f64)>,
    ) -> Self {
        Self {
            folder: folder.clone(),
            history,
            names: Names {
                bodies: prepared.bodies.iter().map(|body| body.name.clone()).collect(),
                materials: prepared.model.materials.iter().map(|material| material.name.clone()).collect(),
            },
            outlines: Outlines::new(&prepared.model.mesh, &prepared.grains),
            targets: prepared.histories.iter().map(|history| target(history, prepared)).collect(),
            frames,
            shown: prepared.output.shown,
        }
    }

    /// Continues the records of a run from a checkpoint. Later frames and rows are removed; earlier ones must exist.
    pub(crate) fn going_on(
        folder: &Folder,
        prepared: &Prepared,
        step: u64,
        frames: Vec<(u64, f64)>,
        length: u64,
    ) -> Result<Self, Failure> {
        let path = folder.path(HISTORY);
        let text = folder.read(HISTORY)?;
        // The row of t = 0 is written after the first step. A run that goes on from step 0 writes it again, so an existing one is removed.
        let end = if step == 0 {
            usize::try_from(length).map_or(text.len(), |length| length.min(text.len()))
        } else {
            kept(&text, step).map_err(|error| Failure::Unusable(format!("{}: {error}", path.display())))?
        };
        let mut head = Vec::new();
        HistoryWriter::new(&mut head, &columns(prepared)).map_err(|error| Failure::writing(&path, error))?;
        if !text.starts_with(&head) {
            return Err(Failure::Unusable(format!(
                "{}: its columns are not those of the [[history]] tables in {}: restore these tables",
                display_name(&path),
                display_name(&folder.path(MODEL))
            )));
        }
        if (end as u64) < length {
            return Err(Failure::Unusable(format!(
                "{}: rows before step {step} are missing: {} of {length} bytes are left",
                display_name(&path),
                text.len()
            )));
        }
        for number in 0..frames.len() {
            for (_, file_of) in COLLECTIONS {
                let name = file_of(number);
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
            let files = COLLECTIONS.map(|(_, file_of)| file_of(later));
            let files = files.into_iter().chain([packed_file(later)]);
            let removed = files.filter(|name| fs::remove_file(folder.path(name)).is_ok()).count();
            if removed == 0 {
                break;
            }
            later += 1;
        }
        let history = HistoryWriter::going_on(BufWriter::new(history), columns(prepared).len());
        let recorder = Self::with(folder, prepared, history, frames);
        recorder.collections()?;
        Ok(recorder)
    }

    /// Returns the present values of each `[[history]]`.
    pub(crate) fn values(&self, run: &Simulation, prepared: &Prepared) -> Vec<Vec<f64>> {
        let values = |(history, target): (&Recorded, &Vec<u32>)| match history.quantity {
            Quantity::Node(node) => {
                let (moved, velocity) = run.node(node).unwrap_or_default();
                [moved, velocity].concat()
            }
            Quantity::Force(boundary) => {
                [run.force(boundary).unwrap_or_default(), mean_displacement(run, target)].concat()
            }
            Quantity::Energy | Quantity::CrackLength => Vec::new(),
        };
        prepared.histories.iter().zip(&self.targets).map(values).collect()
    }

    /// Writes the row of t = 0 after the first step. `values`: values before that step. Forces and energies are those at its beginning, known only after it.
    pub(crate) fn first_row(
        &mut self,
        run: &Simulation,
        prepared: &Prepared,
        mut values: Vec<Vec<f64>>,
    ) -> Result<(), Failure> {
        for (number, history) in prepared.histories.iter().enumerate() {
            if let Quantity::Force(boundary) = history.quantity {
                values[number][..2].copy_from_slice(&run.force(boundary).unwrap_or_default());
            }
        }
        self.write_row(&Row { energies: run.energies(), values: values.concat(), ..Row::default() })
    }

    /// Writes a row of the history.
    pub(crate) fn row(&mut self, run: &Simulation, prepared: &Prepared) -> Result<(), Failure> {
        self.write_row(&Row {
            step: run.steps(),
            time: run.time(),
            energies: run.energies(),
            broken: run.counts().broken as u64,
            lengths: run.crack_lengths(),
            values: self.values(run, prepared).concat(),
        })
    }

    fn write_row(&mut self, row: &Row) -> Result<(), Failure> {
        self.history.row(row).map_err(|error| Failure::writing(&self.folder.path(HISTORY), error))
    }

    /// Writes the files of a frame: bodies, cracks, damaged joints and contact forces.
    pub(crate) fn frame(&mut self, run: &Simulation) -> Result<(), Failure> {
        let (snapshot, forces) = (run.snapshot(), run.forces());
        let number = self.frames.len();
        // Writing to memory does not fail. An inconsistent snapshot would be a bug.
        let fault = |name: &str, error: std::io::Error| Failure::writing(&self.folder.path(name), error);
        let write = |name: String, write: &dyn Fn(&mut Vec<u8>) -> std::io::Result<()>| {
            let mut bytes = Vec::new();
            write(&mut bytes).map_err(|error| fault(&name, error))?;
            self.folder.write(&name, &bytes)
        };
        write(mesh_file(number), &|out| write_vtu(out, &snapshot, &forces, &self.names))?;
        write(cracks_file(number), &|out| write_cracks_vtp(out, &snapshot))?;
        write(damaged_file(number), &|out| write_damaged_joints_vtp(out, &snapshot))?;
        write(contacts_file(number), &|out| write_contacts_vtp(out, &snapshot, &forces))?;
        let name = packed_file(number);
        // The report shows a sample of a mesh that is too large for a page; files for ParaView are complete.
        let [most, sample] = self.shown;
        let most = if snapshot.elements.len() > most { sample } else { usize::MAX };
        let frame =
            Frame::sampled(&snapshot, &self.outlines, most).map_err(|error| fault(&name, error.into()))?;
        self.folder.write(&name, &frame.to_bytes())?;
        self.frames.push((run.steps(), run.time()));
        self.collections()
    }

    /// Writes the collections that ParaView opens.
    fn collections(&self) -> Result<(), Failure> {
        for (name, file_of) in COLLECTIONS {
            let files: Vec<String> = (0..self.frames.len()).map(file_of).collect();
            let entries = self.frames.iter().zip(&files).map(|(&(_, time), file)| (time, file.as_str()));
            self.folder.write(name, pvd(entries).as_bytes())?;
        }
        Ok(())
    }

    /// Length of the history on the disk, bytes.
    pub(crate) fn length(&self) -> Result<u64, Failure> {
        let path = self.folder.path(HISTORY);
        fs::metadata(&path)
            .map(|metadata| metadata.len())
            .map_err(|error| Failure::reading(&display_name(&path), &error))
    }

    /// Writes all rows so far to the disk.
    pub(crate) fn flush(&mut self) -> Result<(), Failure> {
        let out = self.history.get_mut();
        let done = out.flush().and_then(|()| out.get_ref().sync_all());
        done.map_err(|error| Failure::writing(&self.folder.path(HISTORY), error))
    }

    /// Draws plots, the picture, the animation and the report from the recorded results. `facts`: rows of the summary; `done`: number of frames read so far.
    ///
    /// # Errors
    /// The first error. If the history and the frames can be read, everything else is drawn all the same.
    pub(crate) fn finish(
        &mut self,
        prepared: &Prepared,
        facts: &[(&str, &str)],
        done: &Position,
    ) -> Result<(), Failure> {
        self.flush()?;
        let history = History::read(&self.folder.read(HISTORY)?).map_err(|error| broken(HISTORY, &error))?;
        let drawn = plots(&history);
        let frames = self.read_frames(done)?;
        let title = if prepared.title.is_empty() { "fdem" } else { &prepared.title };
        let view = FrameView::of(&frames);
        let pictures = |field| Pictures { title, field, range: Range::of(&frames, field), view };
        let field = prepared.output.fields.first().copied().unwrap_or(Field::MaxPrincipal);
        let report = Report { title, facts, plots: &drawn, frames: &frames, field, names: &self.names };
        [
            self.write_plots(&drawn),
            frames
                .last()
                .map_or(Ok(()), |last| self.write_drawn("picture.png", pictures(field).png(last, None))),
            prepared.output.animate.map_or(Ok(()), |asked| {
                let mut animation = Animation::new(pictures(asked), None, DELAY);
                let pushed = frames.iter().try_for_each(|frame| animation.push(frame));
                self.write_drawn("animation.gif", pushed.and_then(|()| animation.finish()))
            }),
            self.write_drawn(REPORT, report.html().map(String::into_bytes)),
        ]
        .into_iter()
        .collect()
    }

    /// Reads the frames for the report. Frames that are too large for a page are samples.
    fn read_frames(&self, done: &Position) -> Result<Vec<Frame>, Failure> {
        let read = |number: usize| {
            let name = packed_file(number);
            let bytes = self.folder.read(&name)?;
            done.fetch_add(1, Ordering::Relaxed);
            Frame::from_bytes(&bytes).map_err(|error| broken(&name, &error))
        };
        (0..self.frames.len()).map(read).collect()
    }

    fn write_plots(&self, drawn: &[Plot]) -> Result<(), Failure> {
        self.folder.make(PLOTS)?;
        drawn.iter().try_for_each(|plot| {
            let name = format!("{PLOTS}/{}", plot.name);
            self.folder.write(&format!("{name}.svg"), plot.svg.as_bytes())?;
            self.write_drawn(&format!("{name}.png"), plot.png(None))
        })
    }

    fn write_drawn<E: fmt::Display>(&self, name: &str, bytes: Result<Vec<u8>, E>) -> Result<(), Failure> {
        self.folder.write(name, &bytes.map_err(|error| broken(name, &error))?)
    }
}

fn broken(what: &str, error: &dyn fmt::Display) -> Failure {
    Failure::Unusable(format!("{what}: {error}"))
}

/// Returns the names of the columns of all `[[history]]` tables.
fn columns(prepared: &Prepared) -> Vec<String> {
    let mut names = Vec::new();
    for history in &prepared.histories {
        let parts: &[&str] = match history.quantity {
            Quantity::Node(_) => &["ux [m]", "uy [m]", "vx [m/s]", "vy [m/s]"],
            Quantity::Force(_) => &["fx [N]", "fy [N]", "ux [m]", "uy [m]"],
            // The history has these columns in any case.
            Quantity::Energy | Quantity::CrackLength => &[],
        };
        names.extend(parts.iter().map(|part| format!("{} {part}", history.name)));
    }
    names
}

/// The nodes of the boundary whose force a history records, each once.
fn target(history: &Recorded, prepared: &Prepared) -> Vec<u32> {
    let Quantity::Force(boundary) = history.quantity else { return Vec::new() };
    let mut nodes = match &prepared.model.boundaries[boundary].target {
        Target::Nodes(nodes) => nodes.clone(),
        Target::Facets(edges) => edges.as_flattened().to_vec(),
    };
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The mean displacement of some nodes, m.
fn mean_displacement(run: &Simulation, nodes: &[u32]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for &node in nodes {
        let (moved, _) = run.node(node).unwrap_or_default();
        sum = [sum[0] + moved[0], sum[1] + moved[1]];
    }
    sum.map(|sum| sum / nodes.len().max(1) as f64)
}
