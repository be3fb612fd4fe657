//! Writes the results of a run: frames, history and checkpoints during the run, plots, animation and report
//! at its end.

use std::collections::{BTreeSet, VecDeque};
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::sync::atomic::Ordering;

use fdem_results::{
    CoarseFields, CoarseGrid, Field, Fragments, History, HistoryWriter, Names, Plot, RANK_PLOTS, Row,
    fragment_sizes, plots, pvd, write_contacts_vtp, write_cracks_vtp, write_damaged_joints_vtp,
    write_intact_joints_vtp, write_sphere_contacts_vtp, write_spheres_vtp, write_vtu, write_walls_vtp,
};
use fdem_simulation::{Forces, Snapshot};

use crate::command::aside::Hold;
use crate::command::failure::{Failure, display_name};
use crate::command::progress::Position;
use crate::command::run::checkpoint::Checkpoint;
use crate::command::run::folder::{FRAGMENTS, Folder, HISTORY, MODEL, PLOTS, REPORT};
use crate::command::run::frame_files::FrameFile;
use crate::command::run::intact::{Intact, Problems};
use crate::command::run::manifest::{Checksum, FrameRecord, Hashed, Hashing, Manifest};
use crate::command::run::results::{DrawnRun, Results};
use fdem_model::{Prepared, columns};

/// Writes the results of a run into its folder.
pub(crate) struct Recorder<const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    folder: Folder,
    history: HistoryWriter<BufWriter<Hashing<File>>>,
    names: Names,
    outlines: <[[f64; D]; N] as Results<D, N>>::Outlines,
    /// Frames that have been written.
    frames: Vec<FrameRecord>,
    /// Whether the last of them shows the state of an interrupted run between two frames. Checkpoints leave
    /// it out, so that a resume removes it.
    between: bool,
    /// Tables that have been written since the run ended.
    tables: Vec<(String, Checksum)>,
    /// Copies of the files that the model names.
    inputs: Vec<Checksum>,
    /// Files of frames that are in place, and that the disk may not have yet.
    unsynced: VecDeque<String>,
    /// Number of frames that the collections name.
    collected: usize,
    /// `None` once nothing more is to be recorded.
    holds: Option<[Hold; 2]>,
    /// Most elements of a frame that the report shows completely, and number of triangles in the samples of
    /// larger frames.
    most: [usize; 2],
    /// The files of each frame.
    kinds: Vec<FrameFile>,
    coarse: Option<CoarseGrid>,
    /// Number of frames of the whole run, about.
    expected: usize,
}

impl<const D: usize, const N: usize> Recorder<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// Starts the records of a new run. `inputs`: the files that its model names.
    pub(crate) fn new(
        folder: &Folder,
        prepared: &Prepared<D, N>,
        inputs: &[Vec<u8>],
    ) -> Result<Self, Failure> {
        let path = folder.path(HISTORY);
        let names = columns(&prepared.histories, &prepared.probes);
        let history = File::create(&path)
            .and_then(|file| HistoryWriter::new(BufWriter::new(Hashing::new(file)), D, &names))
            .map_err(|error| Failure::writing(&path, error))?;
        Self::with(
            folder,
            prepared,
            history,
            (Vec::new(), inputs.iter().map(|bytes| Checksum::of(bytes)).collect()),
        )
    }

    fn with(
        folder: &Folder,
        prepared: &Prepared<D, N>,
        history: HistoryWriter<BufWriter<Hashing<File>>>,
        (frames, inputs): (Vec<FrameRecord>, Vec<Checksum>),
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
            between: false,
            tables: Vec::new(),
            inputs,
            unsynced: VecDeque::new(),
            collected: 0,
            holds: Some(folder.hold()?),
            most: prepared.output.shown,
            kinds: FrameFile::of_run(prepared),
            coarse: prepared.output.coarse,
            expected: ((prepared.end_time / prepared.output.interval).ceil() as usize).saturating_add(1),
        })
    }

    /// Continues the records of a run from a checkpoint, whose results are intact. Later frames and rows are
    /// removed.
    pub(crate) fn going_on(
        folder: &Folder,
        prepared: &Prepared<D, N>,
        manifest: &Manifest,
        intact: &Intact,
    ) -> Result<Self, Failure> {
        let path = folder.path(HISTORY);
        let failed = |error| Failure::writing(&path, error);
        let names = columns(&prepared.histories, &prepared.probes);
        let mut head = Vec::new();
        HistoryWriter::new(&mut head, D, &names).map_err(failed)?;
        let is_same = Hashed::read(&path, head.len() as u64)
            .map_err(|error| Failure::reading(&display_name(&path), &error))?
            .checksum()
            == Checksum::of(&head);
        if !is_same {
            return Err(Failure::Unusable(format!(
                "{}: its columns are not those of the [[history]] tables in {}: restore these tables",
                display_name(&path),
                display_name(&folder.path(MODEL))
            )));
        }
        let history = OpenOptions::new()
            .append(true)
            .open(&path)
            .and_then(|file| file.set_len(manifest.history.length).map(|()| file))
            .map_err(failed)?;
        folder.remove_frames(manifest.frames.len())?;
        let history =
            HistoryWriter::going_on(BufWriter::new(intact.history.clone().then(history)), names.len());
        let files = (manifest.frames.clone(), manifest.inputs.clone());
        let mut recorder = Self::with(folder, prepared, history, files)?;
        recorder.collect()?;
        Ok(recorder)
    }

    /// Writes damaged files of the last frame again. `snapshot` and `forces`: those of the checkpoint.
    ///
    /// # Errors
    /// A file whose contents would be others than before: it shows a change between stages, or reactions of
    /// the last step, which a checkpoint does not have.
    pub(crate) fn repair(
        &mut self,
        damaged: &[String],
        snapshot: &Snapshot<D, N>,
        forces: &Forces<D>,
    ) -> Result<(), Failure> {
        let Some(record) = self.frames.last() else { return Ok(()) };
        let number = self.frames.len() - 1;
        let files = self.frame_files(number, snapshot, forces)?;
        for ((file, bytes), (_, checksum)) in files.iter().zip(&record.files) {
            let name = file.of(number);
            if damaged.contains(&name) {
                if Checksum::of(bytes) != *checksum {
                    let mut problems = Problems::default();
                    problems.add(&self.folder.path(&name), "its contents have changed");
                    return Err(problems.failure(&self.folder));
                }
                self.folder.write(&name, bytes)?;
            }
        }
        Ok(())
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
        let files = self.frame_files(number, snapshot, forces)?;
        let (step, time) = (snapshot.step, snapshot.time);
        let mut record = FrameRecord { step, time, files: Vec::new() };
        for (file, bytes) in files {
            let name = file.of(number);
            self.folder.write_unsynced(&name, &bytes)?;
            record.files.push((file, Checksum::of(&bytes)));
            self.unsynced.push_back(name);
        }
        self.frames.push(record);
        Ok(())
    }

    /// Writes the files of the last state of an interrupted run, as those of a frame. A resume removes them.
    pub(crate) fn last_state(
        &mut self,
        snapshot: &Snapshot<D, N>,
        forces: &Forces<D>,
    ) -> Result<(), Failure> {
        self.frame(snapshot, forces)?;
        self.between = true;
        Ok(())
    }

    /// The files of a frame, in the order of [`FrameFile::ALL`].
    fn frame_files(
        &self,
        number: usize,
        snapshot: &Snapshot<D, N>,
        forces: &Forces<D>,
    ) -> Result<Vec<(FrameFile, Vec<u8>)>, Failure> {
        let write = |file: FrameFile, out: &mut Vec<u8>| match file {
            FrameFile::Mesh => write_vtu(out, snapshot, forces, &self.names),
            FrameFile::Cracks => write_cracks_vtp(out, snapshot),
            FrameFile::DamagedJoints => write_damaged_joints_vtp(out, snapshot),
            FrameFile::Contacts => write_contacts_vtp(out, snapshot, forces),
            FrameFile::IntactJoints => write_intact_joints_vtp(out, snapshot),
            FrameFile::Spheres => write_spheres_vtp(out, snapshot),
            FrameFile::SphereContacts => write_sphere_contacts_vtp(out, snapshot),
            FrameFile::Walls => write_walls_vtp(out, snapshot),
            FrameFile::Coarse => self.coarse.map_or(Ok(()), |grid| {
                let fields = CoarseFields::new(&snapshot.spheres, grid).map_err(std::io::Error::other)?;
                fields.write_vti(out, snapshot.time)
            }),
            FrameFile::Packed => {
                *out = <[[f64; D]; N]>::frame(snapshot, &self.outlines, self.most, self.expected)?;
                Ok(())
            }
        };
        let written = |file: FrameFile| {
            let mut bytes = Vec::new();
            // Writing to memory does not fail. An inconsistent snapshot would be a bug.
            let fault = |error| Failure::writing(&self.folder.path(&file.of(number)), error);
            write(file, &mut bytes).map_err(fault)?;
            Ok((file, bytes))
        };
        self.kinds.iter().copied().map(written).collect()
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
        for file in &self.kinds {
            let Some(name) = file.collection() else { continue };
            let has = |(_, frame): &(usize, &FrameRecord)| frame.files.iter().any(|(of, _)| of == file);
            let entries = self.frames.iter().enumerate().filter(has);
            let entries: Vec<(f64, String)> =
                entries.map(|(number, frame)| (frame.time, file.of(number))).collect();
            let entries = entries.iter().map(|(time, file)| (*time, file.as_str()));
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

    /// Writes a checkpoint with the checksums of all results until now, which are on the disk before it.
    pub(crate) fn save(&mut self, state: &Checkpoint<D, N>) -> Result<(), Failure> {
        self.flush()?;
        self.tidy_up()?;
        let manifest = Manifest {
            step: state.state.step(),
            history: self.history.get_mut().get_ref().checksum(),
            frames: self.frames[..self.frames.len() - usize::from(self.between)].to_vec(),
            tables: self.tables.clone(),
            inputs: self.inputs.clone(),
        };
        self.folder.save(&manifest, state)
    }

    /// Writes a table of the run, which has ended.
    pub(crate) fn table(&mut self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        self.folder.write(name, bytes)?;
        self.tables.retain(|(other, _)| other != name);
        self.tables.push((name.to_owned(), Checksum::of(bytes)));
        Ok(())
    }

    /// Writes all rows so far to the disk.
    fn flush(&mut self) -> Result<(), Failure> {
        let out = self.history.get_mut();
        let done = out.flush().and_then(|()| out.get_ref().get_ref().sync_all());
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

    /// Step of the last frame that has been written.
    pub(crate) fn last_frame(&self) -> Option<u64> {
        self.frames.last().map(|frame| frame.step)
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
        self.table(FRAGMENTS, fragments.csv(&self.names).as_bytes())?;
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
        name_apart(&mut drawn);
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
            let name = FrameFile::Packed.of(number);
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

/// Gives plots that would have one file each its own: the second of a name ends in `-2`.
fn name_apart(plots: &mut [Plot]) {
    let mut taken = BTreeSet::new();
    for plot in plots {
        let (first, mut number) = (plot.name.clone(), 1);
        while !taken.insert(plot.name.clone()) {
            number += 1;
            plot.name = format!("{first}-{number}");
        }
    }
}
