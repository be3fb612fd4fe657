//! Runs that a program holds in memory: the interface for the Python package.
//!
//! A [`Ready`] is a model that has passed the checks of the command, with its messages. A [`Session`] is a
//! run of it: a [`Simulation`] that is advanced, read and set by the program, and that goes through the
//! stages, conditions and servos of its model as `fdem run` does. It has the text of its model, so that one
//! file holds everything that a run needs to continue. Such a file has the parts of a checkpoint and no
//! frames.

use std::path::Path;

use fdem_results::Field;
use fdem_simulation::{Boundary, Simulation, Snapshot, State};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::command::aside;
use crate::command::failure::{Failure, display_name};
use crate::command::memory;
use crate::command::model_file::{inputs_of, read_text, refusal};
use crate::command::run::beginning::Beginning;
use crate::command::run::checkpoint::Checkpoint;
use crate::command::run::course::{Course, Start};
use crate::command::run::folder::{Folder, MODEL};
use crate::command::run::intact::check_inputs;
use crate::command::run::results::Results;
use crate::state_hash::state_hash;
use fdem_model::{AnyPrepared, Drawing, Entered, Load, Prepared, Reached, prepare_any};

/// First line of a file of a run. It changes whenever the contents change.
const MAGIC: &[u8] = b"fdem session 5\n";

/// The text of a model, and the files that it names in their order.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Source {
    /// Name, for messages.
    pub name: String,
    /// The model file.
    pub text: String,
    /// Contents of the files that the model names.
    pub inputs: Vec<Vec<u8>>,
}

/// A model that has passed all checks, and is meshed.
#[derive(Clone, Debug)]
pub struct Ready {
    /// Text from which it was made.
    pub source: Source,
    /// The model.
    pub prepared: AnyPrepared,
}

impl Ready {
    /// Reads, checks and meshes a model file, as `fdem run` does.
    ///
    /// # Errors
    /// The message of the command.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = read_text(path).map_err(|failure| failure.to_string())?;
        Self::new(text, &display_name(path), path)
    }

    /// Checks and meshes the text of a model. `name`: its name in messages; `place`: the model file, or where
    /// it would be: the files that it names are beside it.
    ///
    /// # Errors
    /// The message of the command.
    pub fn new(text: String, name: &str, place: &Path) -> Result<Self, String> {
        let mut inputs = Vec::new();
        let mut read = inputs_of(place);
        let mut load = |file: &str| {
            let bytes = read(file)?;
            inputs.push(bytes.clone());
            Ok(bytes)
        };
        let prepared = prepared(&text, name, &mut load)?;
        Ok(Self { source: Source { name: name.to_owned(), text, inputs }, prepared })
    }

    /// Starts a run on `threads` threads; 0 for one per processor. `from`: a folder of `fdem run`, with whose
    /// end the run begins.
    ///
    /// # Errors
    /// Why the model cannot run.
    pub fn begin(&self, threads: usize, from: Option<&Path>) -> Result<AnySession, String> {
        Ok(match &self.prepared {
            AnyPrepared::Plane(prepared) => {
                AnySession::Plane(Box::new(Session::begin(&self.source, prepared, threads, from)?))
            }
            AnyPrepared::Space(prepared) => {
                AnySession::Space(Box::new(Session::begin(&self.source, prepared, threads, from)?))
            }
        })
    }
}

fn prepared(text: &str, name: &str, load: &mut Load<'_>) -> Result<AnyPrepared, String> {
    prepare_any(text, name, load, memory::free()).map_err(|errors| refusal(&errors, Drawing::Plain))
}

/// A run in two or three dimensions.
#[derive(Debug)]
pub enum AnySession {
    /// A run of triangles in the plane.
    Plane(Box<Session<2, 3>>),
    /// A run of tetrahedra in space.
    Space(Box<Session<3, 4>>),
}

/// A saved run before its parts are opened.
#[derive(Serialize, Deserialize)]
struct Saved {
    source: Source,
    /// Hash of the model, [`Prepared::hash`].
    model: String,
    /// Bytes of the [`SavedSession`].
    parts: Vec<u8>,
}

/// The parts that a run needs to continue.
#[derive(Serialize, Deserialize)]
#[serde(bound(
    serialize = "State<D, N>: Serialize, Boundary<D>: Serialize, [f64; D]: Serialize",
    deserialize = "State<D, N>: Deserialize<'de>, Boundary<D>: Deserialize<'de>, [f64; D]: Deserialize<'de>"
))]
struct SavedSession<const D: usize, const N: usize> {
    /// Time between rows of the history, s: conditions look at these.
    interval: f64,
    /// The stages so far; none if the run is one.
    entered: Entered<D>,
    reached: Reached,
    /// When it has begun from another run.
    begun: Option<Beginning>,
    state: State<D, N>,
}

impl<const D: usize, const N: usize> From<Checkpoint<D, N>> for SavedSession<D, N> {
    fn from(checkpoint: Checkpoint<D, N>) -> Self {
        let Checkpoint { intervals, entered, reached, begun, state, .. } = checkpoint;
        Self { interval: intervals[1], entered, reached, begun, state }
    }
}

impl AnySession {
    /// Continues a run: of a file that [`Session::save`] wrote, or of the last checkpoint in a folder of
    /// `fdem run`. The folder is only read.
    ///
    /// # Errors
    /// A file or a folder that cannot be read, is damaged, or was made by another version.
    pub fn resume(path: &Path, threads: usize) -> Result<Self, String> {
        let text = |failure: Failure| failure.to_string();
        if path.is_dir() {
            let (folder, saved) = Folder::open_to_read(path).map_err(text)?;
            check_inputs(&folder, &saved.manifest).map_err(text)?;
            let model = folder.path(MODEL);
            let ready = Ready::of_folder(&folder, &model)?;
            return match &ready.prepared {
                AnyPrepared::Plane(prepared) => {
                    let checkpoint = saved.open::<2, 3>().map_err(text)?;
                    same(prepared, &checkpoint.model, &model)?;
                    Session::go_on(&ready.source, prepared, checkpoint.into(), threads).map(Self::Plane)
                }
                AnyPrepared::Space(prepared) => {
                    let checkpoint = saved.open::<3, 4>().map_err(text)?;
                    same(prepared, &checkpoint.model, &model)?;
                    Session::go_on(&ready.source, prepared, checkpoint.into(), threads).map(Self::Space)
                }
            };
        }
        let Saved { source, model, parts } = opened(path)?;
        let mut next = source.inputs.iter();
        let mut load = |_: &str| next.next().cloned().ok_or_else(|| "it is not in the saved run".to_owned());
        let damaged = |error: postcard::Error| format!("{} is damaged: {error}", display_name(path));
        match prepared(&source.text, &source.name, &mut load)? {
            AnyPrepared::Plane(prepared) => {
                same(&prepared, &model, path)?;
                let parts: SavedSession<2, 3> = postcard::from_bytes(&parts).map_err(damaged)?;
                Session::go_on(&source, &prepared, parts, threads).map(Self::Plane)
            }
            AnyPrepared::Space(prepared) => {
                same(&prepared, &model, path)?;
                let parts: SavedSession<3, 4> = postcard::from_bytes(&parts).map_err(damaged)?;
                Session::go_on(&source, &prepared, parts, threads).map(Self::Space)
            }
        }
    }
}

impl Ready {
    /// The model of a folder of results, with the files that the folder keeps.
    fn of_folder(folder: &Folder, path: &Path) -> Result<Self, String> {
        let text = read_text(path).map_err(|failure| failure.to_string())?;
        let prepared = folder.prepared(&text).map_err(|errors| refusal(&errors, Drawing::Plain));
        let (prepared, inputs) = prepared?;
        Ok(Self { source: Source { name: display_name(path), text, inputs }, prepared })
    }
}

/// Reads a file of [`Session::save`], and checks that it is whole.
fn opened(path: &Path) -> Result<Saved, String> {
    let name = display_name(path);
    let bytes = std::fs::read(path).map_err(|error| Failure::reading(&name, &error).to_string())?;
    let damaged = |why: &str| format!("{name} is damaged: {why}");
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Err(format!("{name} is no run that this version of fdem has saved"));
    };
    let Some((digest, payload)) = rest.split_at_checked(32) else { return Err(damaged("it is cut off")) };
    if Sha256::digest(payload).as_slice() != digest {
        return Err(damaged("its checksum is wrong"));
    }
    postcard::from_bytes(payload).map_err(|error| damaged(&error.to_string()))
}

/// Refuses the state of another model.
fn same<const D: usize, const N: usize>(
    prepared: &Prepared<D, N>,
    hash: &str,
    path: &Path,
) -> Result<(), String> {
    if prepared.hash == hash {
        return Ok(());
    }
    Err(format!(
        "{}: the model is another one than that of the saved state: it has changed, or this version of fdem meshes it in another way",
        display_name(path)
    ))
}

/// A run that a program holds.
pub struct Session<const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// Text from which its model was made.
    pub source: Source,
    course: Course<Simulation<D, N>, D, N>,
    told: Vec<String>,
}

impl<const D: usize, const N: usize> std::fmt::Debug for Session<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Session of {} after step {}", self.source.name, self.course.run.steps())
    }
}

impl<const D: usize, const N: usize> Session<D, N>
where
    [[f64; D]; N]: Results<D, N>,
    State<D, N>: Serialize,
    Boundary<D>: Serialize,
    [f64; D]: Serialize,
{
    fn begin(
        source: &Source,
        prepared: &Prepared<D, N>,
        threads: usize,
        from: Option<&Path>,
    ) -> Result<Self, String> {
        let start = Start::new(prepared.clone(), from);
        let mut start = start.map_err(|error| error.of(&source.name).to_string())?;
        let (run, told) =
            start.simulation(threads).map_err(|why| format!("{} cannot run: {why}", source.name))?;
        let interval = prepared.output.history_interval;
        let mut session = Self::of(source, start, run, interval, Reached::default())?;
        session.told = told;
        Ok(session)
    }

    fn go_on(
        source: &Source,
        prepared: &Prepared<D, N>,
        parts: SavedSession<D, N>,
        threads: usize,
    ) -> Result<Box<Self>, String> {
        let SavedSession { interval, entered, reached, begun, state } = parts;
        let wrong = |why: String| format!("{} cannot continue: {why}", source.name);
        let start = Start::again(prepared.clone(), begun, entered).map_err(wrong)?;
        let run = start.resumed(state, threads).map_err(|error| wrong(error.to_string()))?;
        Self::of(source, start, run, interval, reached).map(Box::new)
    }

    fn of(
        source: &Source,
        start: Start<D, N>,
        run: Simulation<D, N>,
        interval: f64,
        reached: Reached,
    ) -> Result<Self, String> {
        let course = Course::new(start, Box::new(run), interval, reached, false);
        let course = course.map_err(|failure| failure.to_string())?;
        Ok(Self { source: source.clone(), course, told: Vec::new() })
    }

    /// Its model with names and output settings: that of the present stage.
    pub fn prepared(&self) -> &Prepared<D, N> {
        &self.course.prepared
    }

    /// The run.
    pub fn run(&self) -> &Simulation<D, N> {
        &self.course.run
    }

    /// The run, to be set between steps.
    pub fn run_mut(&mut self) -> &mut Simulation<D, N> {
        &mut self.course.run
    }

    /// Takes the given number of steps, or fewer if the run is over before. Stages, conditions and servos of
    /// the model act as in `fdem run`, and the energy balance is checked at the end of the run.
    ///
    /// # Errors
    /// The reason why the run cannot continue.
    pub fn advance(&mut self, steps: u64) -> Result<(), String> {
        let end = self.run().steps().saturating_add(steps);
        while self.run().steps() < end && !self.is_over() {
            // A program may continue after the end time.
            let before_end = !self.course.is_over();
            let limit = if before_end { end.min(self.total()) } else { end };
            let passed = self.course.advance(limit).map_err(|stop| stop.to_string())?;
            let turned = self.course.turn(&passed).map_err(|failure| failure.to_string())?;
            self.told.extend(turned.told);
            // As at the end of `fdem run`.
            if before_end && self.course.is_over() {
                self.run().check_balance().map_err(|stop| stop.to_string())?;
            }
        }
        // All that a program may read.
        self.run().settle().map_err(|stop| stop.to_string())
    }

    /// Whether the run is over before its end time: its condition is met, or its last stage has ended.
    pub fn is_over(&self) -> bool {
        self.course.reached.over
    }

    /// Name of the present stage; `None` if the run is one.
    pub fn stage(&self) -> Option<&str> {
        self.course.stages.as_ref().map(|stages| stages.now().name.as_str())
    }

    /// Lines that `fdem run` writes to its log: an earlier run that this one begins with, ends of stages, the
    /// end of the run. A resumed run begins with none.
    pub fn told(&self) -> &[String] {
        &self.told
    }

    /// Writes a file from which [`AnySession::resume`] continues the run with the same bits. The file is
    /// whole or absent.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        let failed = |error: &dyn std::fmt::Display| Failure::writing(path, error).to_string();
        let parts = SavedSession {
            interval: self.course.interval,
            entered: self.course.entered(),
            reached: self.course.reached,
            begun: self.course.begun.clone(),
            state: self.run().state(),
        };
        let parts = postcard::to_allocvec(&parts).map_err(|error| failed(&error))?;
        let saved = Saved { source: self.source.clone(), model: self.prepared().hash.clone(), parts };
        let payload = postcard::to_allocvec(&saved).map_err(|error| failed(&error))?;
        let bytes = [MAGIC, Sha256::digest(&payload).as_slice(), &payload].concat();
        aside::replace(path, &bytes).map_err(|error| failed(&error))
    }

    /// Steps of the whole run, from the beginning to the `end_time` of the model.
    pub fn total(&self) -> u64 {
        self.course.total()
    }

    /// The hash of the state: `state_hash` of `run.json`, if the last step was the last of a call of
    /// [`Simulation::advance`].
    pub fn state_hash(&self) -> String {
        state_hash(&self.run().snapshot(), &self.run().energies())
    }

    /// The run now, with displacements that count from the last stage that has set them back.
    pub fn snapshot(&self) -> Snapshot<D, N> {
        self.course.counted(self.run().snapshot())
    }

    /// Draws the run now, as PNG: the picture of a run's report. `width`: in pixels.
    ///
    /// # Errors
    /// A picture that is too wide, or a run that cannot be drawn.
    pub fn picture(&self, field: Field, width: Option<u32>) -> Result<Vec<u8>, String> {
        let title = if self.prepared().title.is_empty() { "fdem" } else { &self.prepared().title };
        let outlines = <[[f64; D]; N]>::outlines(self.prepared());
        let snapshot = self.course.with_joints(self.snapshot());
        <[[f64; D]; N]>::picture(&snapshot, &outlines, title, field, width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdem_model::STARTER;

    /// Two squares that overlap, with a time step at which their energy grows.
    const UNBALANCED: &str = include_str!("../../tests/command/unbalanced.toml");

    /// As `fdem run`, a program that takes the last step learns that the energy balance is off.
    #[test]
    fn the_last_step_checks_the_energy_balance() {
        let ready = Ready::new(UNBALANCED.to_owned(), "model.toml", Path::new("")).expect("a model");
        let AnySession::Plane(mut run) = ready.begin(1, None).expect("a run") else { panic!("of triangles") };
        run.advance(24).expect("steps before the last");
        let error = run.advance(1).expect_err("the last step");
        assert!(error.starts_with("step 24: the energy balance is off by 6."), "{error}");
        run.advance(1).expect("a step after the end time, which is not checked");
    }

    /// A run that is saved continues with the same bits, in a separate file.
    #[test]
    fn a_session_is_saved_and_resumed() {
        let place = tempfile::tempdir().expect("a folder");
        let ready = Ready::new(STARTER.to_owned(), "starter.toml", place.path()).expect("a model");
        let AnySession::Plane(mut whole) = ready.begin(1, None).expect("a run") else {
            panic!("of triangles")
        };
        whole.advance(20).expect("steps");
        let file = place.path().join("half");
        whole.save(&file).expect("a file");
        let AnySession::Plane(mut resumed) = AnySession::resume(&file, 2).expect("a run") else {
            panic!("of triangles")
        };
        assert_eq!(resumed.state_hash(), whole.state_hash());
        whole.advance(30).expect("steps");
        resumed.advance(30).expect("steps");
        assert_eq!(resumed.state_hash(), whole.state_hash());

        let mut bytes = std::fs::read(&file).expect("the file");
        *bytes.last_mut().expect("bytes") ^= 1;
        std::fs::write(&file, &bytes).expect("a file");
        let error = AnySession::resume(&file, 1).expect_err("a damaged file");
        assert!(error.ends_with("is damaged: its checksum is wrong"), "{error}");
        std::fs::write(&file, "text").expect("a file");
        let error = AnySession::resume(&file, 1).expect_err("another file");
        assert!(error.ends_with("is no run that this version of fdem has saved"), "{error}");
    }
}
