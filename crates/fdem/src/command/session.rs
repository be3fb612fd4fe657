//! Runs that a program holds in memory: what the Python package calls.
//!
//! A [`Ready`] is a model that has passed the checks of the command, with its messages. A [`Session`] is a run of it: a [`Simulation`] that is advanced, read and set
//! by the program, with the text of its model, so that one file holds all that a run needs to go on. Such a file has the parts of a checkpoint and no frames.

use std::path::Path;

use fdem_results::Field;
use fdem_simulation::{Simulation, State};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::command::aside;
use crate::command::check::{inputs_of, read_text, refusal};
use crate::command::failure::{Failure, display_name};
use crate::command::memory;
use crate::command::run::checkpoint::Checkpoint;
use crate::command::run::folder::{Folder, MODEL};
use crate::command::run::results::Results;
use crate::model::{AnyPrepared, Drawing, Load, Prepared, prepare_any};
use crate::state_hash::state_hash;

/// First line of a file of a run. It changes whenever the contents change.
const MAGIC: &[u8] = b"fdem session 1\n";

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

    /// Checks and meshes the text of a model. `name`: its name in messages; `place`: the model file, or where it would be: the files that it names are beside it.
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

    /// Starts a run on so many threads; 0 for one per processor.
    ///
    /// # Errors
    /// Why the model cannot run.
    pub fn begin(&self, threads: usize) -> Result<AnySession, String> {
        Ok(match &self.prepared {
            AnyPrepared::Plane(prepared) => {
                AnySession::Plane(Box::new(Session::begin(&self.source, prepared, threads)?))
            }
            AnyPrepared::Space(prepared) => {
                AnySession::Space(Box::new(Session::begin(&self.source, prepared, threads)?))
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

/// A saved run before its state is opened.
#[derive(Serialize, Deserialize)]
struct Saved {
    source: Source,
    /// Hash of the model, [`Prepared::hash`].
    model: String,
    /// Bytes of the [`State`].
    state: Vec<u8>,
}

impl AnySession {
    /// Continues a run: of a file that [`Session::save`] wrote, or of the last checkpoint in a folder of `fdem run`. The folder is only read.
    ///
    /// # Errors
    /// A file or a folder that cannot be read, is damaged, or was made by another version.
    pub fn resume(path: &Path, threads: usize) -> Result<Self, String> {
        let text = |failure: Failure| failure.to_string();
        if path.is_dir() {
            let (folder, saved) = Folder::open(path).map_err(text)?;
            let model = folder.path(MODEL);
            let ready = Ready::of_folder(&folder, &model)?;
            return match &ready.prepared {
                AnyPrepared::Plane(prepared) => {
                    let Checkpoint { model: hash, state, .. } = saved.open::<2, 3>().map_err(text)?;
                    same(prepared, &hash, &model)?;
                    Session::go_on(&ready.source, prepared, state, threads).map(Box::new).map(Self::Plane)
                }
                AnyPrepared::Space(prepared) => {
                    let Checkpoint { model: hash, state, .. } = saved.open::<3, 4>().map_err(text)?;
                    same(prepared, &hash, &model)?;
                    Session::go_on(&ready.source, prepared, state, threads).map(Box::new).map(Self::Space)
                }
            };
        }
        let Saved { source, model, state } = opened(path)?;
        let mut next = source.inputs.iter();
        let mut load = |_: &str| next.next().cloned().ok_or_else(|| "it is not in the saved run".to_owned());
        let damaged = |error: postcard::Error| format!("{} is damaged: {error}", display_name(path));
        match prepared(&source.text, &source.name, &mut load)? {
            AnyPrepared::Plane(prepared) => {
                same(&prepared, &model, path)?;
                let state: State<2, 3> = postcard::from_bytes(&state).map_err(damaged)?;
                Session::go_on(&source, &prepared, state, threads).map(Box::new).map(Self::Plane)
            }
            AnyPrepared::Space(prepared) => {
                same(&prepared, &model, path)?;
                let state: State<3, 4> = postcard::from_bytes(&state).map_err(damaged)?;
                Session::go_on(&source, &prepared, state, threads).map(Box::new).map(Self::Space)
            }
        }
    }
}

impl Ready {
    /// The model of a folder of results, with the files that the folder keeps.
    fn of_folder(folder: &Folder, path: &Path) -> Result<Self, String> {
        let text = read_text(path).map_err(|failure| failure.to_string())?;
        let name = display_name(path);
        let mut inputs = Vec::new();
        let mut load = |_: &str| {
            let bytes = folder.input(inputs.len()).map_err(|error| error.to_string())?;
            inputs.push(bytes.clone());
            Ok(bytes)
        };
        let prepared = prepared(&text, &name, &mut load)?;
        Ok(Self { source: Source { name, text, inputs }, prepared })
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
#[derive(Debug)]
pub struct Session<const D: usize, const N: usize> {
    /// Text from which its model was made.
    pub source: Source,
    /// Its model, with names and output settings.
    pub prepared: Prepared<D, N>,
    /// The run.
    pub run: Simulation<D, N>,
}

/// Refuses a model that changes in the run: a program changes its run itself.
fn unchanging<const D: usize, const N: usize>(
    source: &Source,
    prepared: &Prepared<D, N>,
) -> Result<(), String> {
    let only = if !prepared.stages.is_empty() {
        "goes through the stages of a model"
    } else if !prepared.servos.is_empty() {
        "moves servos; a program sets the factor of a boundary"
    } else if prepared.until.is_some() {
        "ends at an `until`; a program looks at the history itself"
    } else {
        return Ok(());
    };
    Err(format!("{} cannot run here: only `fdem run` {only}", source.name))
}

impl<const D: usize, const N: usize> Session<D, N>
where
    [[f64; D]; N]: Results<D, N>,
    State<D, N>: Serialize,
{
    fn begin(source: &Source, prepared: &Prepared<D, N>, threads: usize) -> Result<Self, String> {
        unchanging(source, prepared)?;
        let run = Simulation::new(prepared.model.clone(), threads)
            .map_err(|error| format!("{} cannot run: {error}", source.name))?;
        Ok(Self { source: source.clone(), prepared: prepared.clone(), run })
    }

    fn go_on(
        source: &Source,
        prepared: &Prepared<D, N>,
        state: State<D, N>,
        threads: usize,
    ) -> Result<Self, String> {
        unchanging(source, prepared)?;
        let run = Simulation::resume(prepared.model.clone(), state, threads)
            .map_err(|error| format!("{} cannot go on: {error}", source.name))?;
        Ok(Self { source: source.clone(), prepared: prepared.clone(), run })
    }

    /// Writes a file from which [`AnySession::resume`] continues the run with the same bits. The file is whole or absent.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        let failed = |error: &dyn std::fmt::Display| Failure::writing(path, error).to_string();
        let state = postcard::to_allocvec(&self.run.state()).map_err(|error| failed(&error))?;
        let saved = Saved { source: self.source.clone(), model: self.prepared.hash.clone(), state };
        let payload = postcard::to_allocvec(&saved).map_err(|error| failed(&error))?;
        let bytes = [MAGIC, Sha256::digest(&payload).as_slice(), &payload].concat();
        aside::replace(path, &bytes).map_err(|error| failed(&error))
    }

    /// Steps of the whole run, from the beginning to the `end_time` of the model.
    pub fn total(&self) -> u64 {
        ((self.prepared.end_time / self.run.time_step()).ceil() as u64).max(1)
    }

    /// The hash of the state: `state_hash` of `run.json`, if the last step was the last of a call of [`Simulation::advance`].
    pub fn state_hash(&self) -> String {
        state_hash(&self.run.snapshot(), &self.run.energies())
    }

    /// Draws the run now, as PNG: the picture of a run's report. `width`: in pixels.
    ///
    /// # Errors
    /// A picture that is too wide, or a run that cannot be drawn.
    pub fn picture(&self, field: Field, width: Option<u32>) -> Result<Vec<u8>, String> {
        let title = if self.prepared.title.is_empty() { "fdem" } else { &self.prepared.title };
        let outlines = <[[f64; D]; N]>::outlines(&self.prepared);
        <[[f64; D]; N]>::picture(&self.run.snapshot(), &outlines, title, field, width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::STARTER;

    /// A run that is saved goes on with the same bits, in a file of its own.
    #[test]
    fn a_session_is_saved_and_resumed() {
        let place = tempfile::tempdir().expect("a folder");
        let ready = Ready::new(STARTER.to_owned(), "starter.toml", place.path()).expect("a model");
        let AnySession::Plane(mut whole) = ready.begin(1).expect("a run") else { panic!("of triangles") };
        whole.run.advance(20).expect("steps");
        let file = place.path().join("half");
        whole.save(&file).expect("a file");
        let AnySession::Plane(mut resumed) = AnySession::resume(&file, 2).expect("a run") else {
            panic!("of triangles")
        };
        assert_eq!(resumed.state_hash(), whole.state_hash());
        whole.run.advance(30).expect("steps");
        resumed.run.advance(30).expect("steps");
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
