//! `fdem new` writes a model to start from.

use std::io::Write;

use crate::command::args::NewArguments;
use crate::command::failure::{Failure, display_name};
use crate::command::output::Output;
use crate::model::{STARTER, STARTER_3D};

pub(crate) fn run(arguments: &NewArguments) -> Result<(), Failure> {
    let path = &arguments.name;
    if !arguments.force && path.symlink_metadata().is_ok() {
        return Err(Failure::writing(path, "it is there already; --force replaces it"));
    }
    let text = if arguments.space { STARTER_3D } else { STARTER };
    let mut output = Output::open(Some(path))?;
    output.write(|out| out.write_all(text.as_bytes()))?;
    output.commit()?;
    // The file is written: an error of standard error is ignored.
    let name = display_name(path);
    let _ = writeln!(std::io::stderr(), "wrote {name}; next: fdem check {name}");
    Ok(())
}
