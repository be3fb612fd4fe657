//! Writes the results of a run: frames, history and checkpoints during the run, plots, animation and report
//! at its end.

use std::collections::VecDeque;
use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::sync::atomic::Ordering;

use fdem_results::{
    Field, Fragments, History, HistoryWriter, Names, Plot, RANK_PLOTS, Row, fragment_sizes, kept, plots, pvd,
    write_contacts_vtp, write_cracks_vtp, write_damaged_joints_vtp, write_vtu,
};
use fdem_simulation::{Forces, Snapshot};

use crate::command::aside::Hold;
use crate::command::failure::{Failure, display_name};
use crate::command::progress::Position;
use crate::command::run::checkpoint::{Checkpoint, Unsaved};
use crate::command::run::folder::{
    COLLECTIONS, FRAGMENTS, Folder, HISTORY, MODEL, PLOTS, REPORT, contacts_file, cracks_file, damaged_file,
    files_of, mesh_file, packed_file,
};
use crate::command::run::results::{DrawnRun, Results};
use fdem_model::{Prepared, columns};

/// Writes the results of a run into its folder.
pub(crate) struct Recorder<const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    folder: Folder,
    history: HistoryWriter<BufWriter<File>>,
    names: Names,
    outlines: <[[f64; D]; N] as Results<D, N>>::Outlines,
    /// Step and time, s, of each frame that has been written.
    frames: Vec<(u64, f64)>,
    /// Files of frames that are in place, and that the disk may not have yet.
    unsynced: VecDeque<String>,
    /// Number of frames that the collections name.
    collected: usize,
    /// `None` once nothing more is to be recorded.
    holds: Option<[Hold; 2]>,
    /// Most elements of a frame that the report shows completely, and number of triangles in the samples of
    /// larger frames.
    shown: [usize; 2],
    /// Number of frames of the whole run, about.
    expected: usize,
}

impl<const D: usize, const N: usize> Recorder<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// Starts the records of a new run.
    pub(crate) fn new(folder: &Folder, prepared: &Prepared<D, N>) -> Result<Self, Failure> {
        let path = folder.path(HISTORY);
        let names = columns(&prepared.histories, &prepared.probes);
        let history = File::create(&path)
            .and_then(|file| HistoryWriter::new(BufWriter::new(file), D, &names))
            .map_err(|error| Failure::writing(&path, error))?;
        Self::with(folder, prepared, history, Vec::new())
    }

    fn with(
        folder: &Folder,
        prepared: &Prepared<D, N>,
        history: HistoryWriter<BufWriter<File>>,
        frames: Vec<(u64, f64)>,
    ) -> Result<Self, Failure> {
        Ok(Self {
            folder: folder.clone(),
            history,
            names: Names {
                bodies: prepared.bodies.iter().map(|body| body.name.clone()).collect(),
                materials: prepared.model.materials.iter().map(|material| material.name.clone()).collect(),
            },
            outlines: <[[f64; D]; N]>::outlines(prepared),
            frames,
            unsynced: VecDeque::new(),
            collected: 0,
            holds: Some(folder.hold()?),
            shown: prepared.output.shown,
            expected: (prepared.end_time / prepared.output.interval).ceil() as usize + 1,
        })
    }

    /// Continues the records of a run from a checkpoint. Later frames and rows are removed; earlier ones must
    /// exist.
    pub(crate) fn going_on(
        folder: &Folder,
        prepared: &Prepared<D, N>,
        step: u64,
        frames: Vec<(u64, f64)>,
        length: u64,
    ) -> Result<Self, Failure> {
        let path = folder.path(HISTORY);
        let text = folder.read(HISTORY)?;
        // The row of t = 0 is written after the first step. A run that continues from step 0 writes it again,
        // so an existing one is removed.
        let end = if step == 0 {
            usize::try_from(length).map_or(text.len(), |length| length.min(text.len()))
        } else {
            kept(&text, step).map_err(|error| Failure::Unusable(format!("{}: {error}", path.display())))?
        };
        let mut head = Vec::new();
        HistoryWriter::new(&mut head, D, &columns(&prepared.histories, &prepared.probes))
            .map_err(|error| Failure::writing(&path, error))?;
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
            <[[f64; D]; N]>::opened(&folder.read(&name)?).map_err(|error| {
                Failure::Unusable(format!("{}: {error}", display_name(&folder.path(&name))))
            })?;
        }
        let history = OpenOptions::new()
            .append(true)
            .open(&path)
            .and_then(|file| file.set_len(end as u64).map(|()| file))
            .map_err(|error| Failure::writing(&path, error))?;
        folder.remove_frames(frames.len())?;
        let history = HistoryWriter::going_on(
            BufWriter::new(history),
            columns(&prepared.histories, &prepared.probes).len(),
        );
        let mut recorder = Self::with(folder, prepared, history, frames)?;
        recorder.collect()?;
        Ok(recorder)
    }

    /// Draws the frames from now on with the outlines of another mesh.
    pub(crate) fn outline(&mut self, outlines: <[[f64; D]; N] as Results<D, N>>::Outlines) {
        self.outlines = outlines;
    }

    /// Writes rows of the history.
    pub(crate) fn rows(&mut self, rows: &[Row]) -> Result<(), Failure> {
        let written = rows.iter().try_for_each(|row| self.history.row(row));
        written.map_err(|error| Failure::writing(&self.folder.path(HISTORY), error))
    }

    /// Writes the files of a frame: bodies, cracks, damaged joints and contact forces. They are synced and
    /// put into the collections by [`Self::tidy`].
    pub(crate) fn frame(&mut self, snapshot: &Snapshot<D, N>, forces: &Forces<D>) -> Result<(), Failure> {
        let number = self.frames.len();
        // Writing to memory does not fail. An inconsistent snapshot would be a bug.
        let fault = |name: &str, error: std::io::Error| Failure::writing(&self.folder.path(name), error);
        let write = |name: String, write: &dyn Fn(&mut Vec<u8>) -> std::io::Result<()>| {
            let mut bytes = Vec::new();
            write(&mut bytes).map_err(|error| fault(&name, error))?;
            self.folder.write_unsynced(&name, &bytes)
        };
        write(mesh_file(number), &|out| write_vtu(out, snapshot, forces, &self.names))?;
        write(cracks_file(number), &|out| write_cracks_vtp(out, snapshot))?;
        write(damaged_file(number), &|out| write_damaged_joints_vtp(out, snapshot))?;
        write(contacts_file(number), &|out| write_contacts_vtp(out, snapshot, forces))?;
        let name = packed_file(number);
        let frame = <[[f64; D]; N]>::frame(snapshot, &self.outlines, self.shown, self.expected)
            .map_err(|error| fault(&name, error.into()))?;
        self.folder.write_unsynced(&name, &frame)?;
        self.frames.push((snapshot.step, snapshot.time));
        self.unsynced.extend(files_of(number));
        Ok(())
    }

    /// Does a part of the remaining work for the frames that have been written: syncs a file, or puts all
    /// frames into the collections once their files are synced. Returns whether there was anything to do.
    ///
    /// The parts are short, so that a frame or a checkpoint that comes meanwhile does not wait long. Where
    /// frames come faster than they are synced, all of this is done before the next checkpoint, and the
    /// collections are written once for many frames.
    pub(crate) fn tidy(&mut self) -> Result<bool, Failure> {
        if let Some(name) = self.unsynced.pop_front() {
            return self.folder.sync(&name).map(|()| true);
        }
        let left = self.collected < self.frames.len();
        if left {
            self.folder.sync_frames()?;
            self.collect()?;
        }
        Ok(left)
    }

    /// Writes the collections that ParaView opens. The disk has the files that they name.
    fn collect(&mut self) -> Result<(), Failure> {
        self.collected = self.frames.len();
        for (name, file_of) in COLLECTIONS {
            let files: Vec<String> = (0..self.frames.len()).map(file_of).collect();
            let entries = self.frames.iter().zip(&files).map(|(&(_, time), file)| (time, file.as_str()));
            self.folder.write(name, pvd(entries).as_bytes())?;
        }
        Ok(())
    }

    /// Does all that is left to do for the frames.
    pub(crate) fn tidy_up(&mut self) -> Result<(), Failure> {
        while self.tidy()? {}
        Ok(())
    }

    /// Releases the lock files once all is recorded.
    pub(crate) fn release(&mut self) {
        self.holds = None;
    }

    /// Writes a checkpoint. It has the frames and the history until now, which are on the disk before it.
    pub(crate) fn save(&mut self, state: Unsaved<D, N>) -> Result<(), Failure> {
        self.flush()?;
        self.tidy_up()?;
        let Unsaved { model, intervals, entered, account, reached, begun, state } = state;
        let history = self.length()?;
        self.folder.save(&Checkpoint {
            model,
            frames: self.frames.clone(),
            history,
            intervals,
            entered,
            reached,
            begun,
            account,
            state,
        })
    }

    /// Length of the history on the disk, bytes.
    fn length(&self) -> Result<u64, Failure> {
        let path = self.folder.path(HISTORY);
        fs::metadata(&path)
            .map(|metadata| metadata.len())
            .map_err(|error| Failure::reading(&display_name(&path), &error))
    }

    /// Writes all rows so far to the disk.
    fn flush(&mut self) -> Result<(), Failure> {
        let out = self.history.get_mut();
        let done = out.flush().and_then(|()| out.get_ref().sync_all());
        done.map_err(|error| Failure::writing(&self.folder.path(HISTORY), error))
    }

    /// Reads the history that has been recorded.
    pub(crate) fn history(&mut self) -> Result<History, Failure> {
        self.flush()?;
        History::read(&self.folder.read(HISTORY)?).map_err(|error| broken(HISTORY, &error))
    }

    /// Number of frames that have been written.
    pub(crate) fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Draws plots, the picture, the animation and the report from the recorded results, and writes the table
    /// of fragments. `facts`: rows of the summary; `emitted`, `more`: plots beside those of the history, of
    /// acoustic emission and of ranks; `done`: number of frames read so far.
    ///
    /// # Errors
    /// The first error. If the history and the frames can be read, everything else is drawn nevertheless.
    pub(crate) fn finish(
        &mut self,
        prepared: &Prepared<D, N>,
        facts: &[(&str, &str)],
        (emitted, more): (Option<Plot>, Vec<Plot>),
        fragments: &Fragments<D>,
        done: &Position,
    ) -> Result<(), Failure> {
        self.folder.write(FRAGMENTS, fragments.csv(&self.names).as_bytes())?;
        let history = self.history()?;
        let mut drawn = plots(&history);
        // Beside the number of fragments, or before the user's columns.
        let place =
            drawn.iter().position(|plot| plot.name == "fragments").map_or(drawn.len().min(3), |at| at + 1);
        drawn.splice(place..place, fragment_sizes(&fragments.sizes()));
        if more.is_empty() {
            // An earlier part of the run may have been on ranks.
            self.folder.remove_plots(&RANK_PLOTS)?;
        }
        drawn.extend(emitted);
        drawn.extend(prepared.curves.iter().filter_map(|curve| curve.plot(&history)));
        drawn.extend(more);
        let frames = self.read_frames(done)?;
        let drawings = <[[f64; D]; N]>::draw(
            &DrawnRun {
                title: if prepared.title.is_empty() { "fdem" } else { &prepared.title },
                facts,
                plots: &drawn,
                fragments,
                field: prepared.output.fields.first().copied().unwrap_or(Field::MAX_PRINCIPAL),
                animate: prepared.output.animate,
                names: &self.names,
            },
            &frames,
        );
        [
            self.write_plots(&drawn),
            drawings.picture.map_or(Ok(()), |picture| self.write_drawn("picture.png", picture)),
            drawings.animation.map_or(Ok(()), |animation| self.write_drawn("animation.gif", animation)),
            self.write_drawn(REPORT, drawings.report.map(String::into_bytes)),
        ]
        .into_iter()
        .collect()
    }

    /// Reads the frames for the report. Frames that are too large for a page are samples.
    fn read_frames(&self, done: &Position) -> Result<Vec<<[[f64; D]; N] as Results<D, N>>::Frame>, Failure> {
        let read = |number: usize| {
            let name = packed_file(number);
            let bytes = self.folder.read(&name)?;
            done.fetch_add(1, Ordering::Relaxed);
            <[[f64; D]; N]>::opened(&bytes).map_err(|error| broken(&name, &error))
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

pub(crate) fn broken(what: &str, error: &dyn fmt::Display) -> Failure {
    Failure::Unusable(format!("{what}: {error}"))
}
