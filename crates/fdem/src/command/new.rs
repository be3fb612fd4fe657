//! `fdem new` writes a model to start from.

use std::io::Write;

use crate::command::args::NewArguments;
use crate::command::failure::{Failure, display_name};
use crate::command::output::{Output, print};
use crate::command::templates::{TEMPLATES, Template};

pub(crate) fn run(arguments: &NewArguments) -> Result<(), Failure> {
    if arguments.list {
        let line = |template: &Template| format!("{:20} {}\n", template.name, template.about());
        return print(&TEMPLATES.iter().map(line).collect::<String>());
    }
    let path = &arguments.name;
    if !arguments.force && path.symlink_metadata().is_ok() {
        return Err(Failure::writing(path, "it is there already; --force replaces it"));
    }
    let name =
        arguments.template.as_deref().unwrap_or(if arguments.space { "starter_3d" } else { "starter" });
    let text = TEMPLATES.iter().find(|template| template.name == name).map_or("", |template| template.text);
    let mut output = Output::open(Some(path))?;
    output.write(|out| out.write_all(text.as_bytes()))?;
    output.commit()?;
    // The file is written: an error of standard error is ignored.
    let name = display_name(path);
    let _ = writeln!(std::io::stderr(), "wrote {name}; next: fdem check {name}");
    Ok(())
}
