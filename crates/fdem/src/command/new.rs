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
    let template = template(arguments.template.as_deref(), arguments.space)?;
    let mut files = vec![(path.clone(), template.text.as_bytes())];
    files.extend(template.file.map(|(name, bytes)| (path.with_file_name(name), bytes)));
    if let Some((path, _)) =
        files.iter().find(|(path, _)| !arguments.force && path.symlink_metadata().is_ok())
    {
        return Err(Failure::writing(path, "it is there already; --force replaces it"));
    }
    let mut outputs = Vec::new();
    for (path, bytes) in &files {
        let mut output = Output::open(Some(path))?;
        output.write(|out| out.write_all(bytes))?;
        outputs.push(output);
    }
    for output in outputs {
        output.commit()?;
    }
    // The files are written: an error of standard error is ignored.
    let names: Vec<String> = files.iter().map(|(path, _)| display_name(path)).collect();
    let _ = writeln!(std::io::stderr(), "wrote {}; next: fdem check {}", names.join(" and "), names[0]);
    Ok(())
}

/// The template with this name, or that to start from. In `space`, the one with this name there.
fn template(name: Option<&str>, space: bool) -> Result<&'static Template, Failure> {
    let name = name.unwrap_or("starter");
    let plain = name.strip_suffix("_3d").unwrap_or(name);
    let wanted = if space { format!("{plain}_3d") } else { name.to_owned() };
    TEMPLATES.iter().find(|template| template.name == wanted).ok_or_else(|| {
        let in_space: Vec<&str> =
            TEMPLATES.iter().filter_map(|template| template.name.strip_suffix("_3d")).collect();
        Failure::Unusable(format!(
            "template \"{name}\" is in the plane; in space there are {}",
            in_space.join(", ")
        ))
    })
}
