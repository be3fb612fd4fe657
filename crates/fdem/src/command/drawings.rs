//! Drawings of `fdem contacts`: `--picture`, `--plots`, `--report`.

use std::path::{Path, PathBuf};

use fdem_results::network::Network;
use fdem_results::page::network::{self as report, BodiesReport, NetworkReport};
use fdem_results::picture::{self, Bodies, Caption, MeshDrawing, PictureError};

use crate::command::args::{DrawingArguments, has_extension};
use crate::command::failure::Failure;
use crate::command::input::{Input, id};
use crate::command::output::Output;

/// Files of the drawings, opened before the search.
pub(crate) struct Drawings {
    picture: Option<(Form, Output)>,
    plots: Option<(Form, Output)>,
    report: Option<Output>,
    /// Width of PNG pictures, pixels.
    width: Option<u32>,
    /// Whether the picture has been drawn.
    is_drawn: bool,
}

/// Bodies of any shape with their contacts, as input of the drawings.
pub(crate) struct BodiesDrawing<'a> {
    /// Name of the file in messages.
    pub(crate) name: &'a str,
    pub(crate) bodies: Bodies<'a>,
    pub(crate) unit: Option<&'a str>,
    /// Ids of the bodies; `None` if they are numbered from 0.
    pub(crate) ids: Option<&'a [i64]>,
    /// Columns of the contacts: a name and a value per contact.
    pub(crate) columns: &'a [(&'a str, &'a [f64])],
    /// Summary of the command, in lines.
    pub(crate) summary: &'a str,
}

#[derive(Clone, Copy)]
enum Form {
    Svg,
    Png,
}

impl Drawings {
    pub(crate) fn open(arguments: &DrawingArguments) -> Result<Self, Failure> {
        let drawing = |path: &Option<PathBuf>| -> Result<_, Failure> {
            let Some(path) = path else { return Ok(None) };
            let form = if has_extension(path, "png") { Form::Png } else { Form::Svg };
            Ok(Some((form, Output::open(Some(path))?)))
        };
        Ok(Self {
            picture: drawing(&arguments.picture)?,
            plots: drawing(&arguments.plots)?,
            report: arguments.report.as_deref().map(|path| Output::open(Some(path))).transpose()?,
            width: arguments.picture_width,
            is_drawn: false,
        })
    }

    /// Draws the network. `summary` returns the summary of the command, in lines.
    pub(crate) fn write<const D: usize>(
        &mut self,
        input: &Input,
        network: &Network<'_, D>,
        summary: impl FnOnce() -> String,
    ) -> Result<(), Failure> {
        let title = title(&input.name);
        let caption = Caption { title: &title, unit: input.packing.source.unit.as_deref() };
        let wrong = |error: PictureError| failed(&input.name, &error);
        if let Some((form, output)) = &mut self.picture {
            let bytes = match form {
                Form::Svg => picture::svg(network, &caption).map(String::into_bytes),
                Form::Png => picture::png(network, &caption, self.width),
            };
            let bytes = bytes.map_err(wrong)?;
            output.write(|out| out.write_all(&bytes))?;
        }
        if let Some((form, output)) = &mut self.plots {
            let bytes = match form {
                Form::Svg => picture::plots_svg(network, &caption).map(String::into_bytes),
                Form::Png => picture::plots_png(network, &caption, self.width),
            };
            let bytes = bytes.map_err(wrong)?;
            output.write(|out| out.write_all(&bytes))?;
        }
        if let Some(output) = &mut self.report {
            let ids: Vec<i64> =
                (0..network.space.centres.len()).map(|index| id(&input.packing, index)).collect();
            let summary = summary();
            let facts = facts(&summary);
            let page =
                report::html(&NetworkReport { network: *network, caption, ids: Some(&ids), facts: &facts })
                    .map_err(wrong)?;
            output.write(|out| out.write_all(page.as_bytes()))?;
        }
        Ok(())
    }

    /// Draws bodies of any shape, except the picture if [`write_mesh`](Self::write_mesh) has drawn it.
    pub(crate) fn write_bodies(&mut self, drawing: &BodiesDrawing<'_>) -> Result<(), Failure> {
        let BodiesDrawing { name, bodies, unit, ids, columns, summary } = *drawing;
        let title = title(name);
        let caption = Caption { title: &title, unit };
        let wrong = |error: PictureError| failed(name, &error);
        if let Some((form, output)) = self.picture.as_mut().filter(|_| !self.is_drawn) {
            let bytes = match form {
                Form::Svg => picture::bodies_svg(&bodies, &caption).map(String::into_bytes),
                Form::Png => picture::bodies_png(&bodies, &caption, self.width),
            };
            let bytes = bytes.map_err(wrong)?;
            output.write(|out| out.write_all(&bytes))?;
        }
        if let Some((form, output)) = &mut self.plots {
            let bytes = match form {
                Form::Svg => picture::bodies_plots_svg(&bodies, &caption).map(String::into_bytes),
                Form::Png => picture::bodies_plots_png(&bodies, &caption, self.width),
            };
            let bytes = bytes.map_err(wrong)?;
            output.write(|out| out.write_all(&bytes))?;
        }
        if let Some(output) = &mut self.report {
            let facts = facts(summary);
            let report = BodiesReport { bodies, caption, ids, columns, facts: &facts };
            let page = report::bodies_html(&report).map_err(wrong)?;
            output.write(|out| out.write_all(page.as_bytes()))?;
        }
        Ok(())
    }

    /// Draws meshed bodies in a plane.
    pub(crate) fn write_mesh(&mut self, name: &str, drawing: &MeshDrawing<'_>) -> Result<(), Failure> {
        let Some((form, output)) = &mut self.picture else { return Ok(()) };
        self.is_drawn = true;
        let title = title(name);
        let caption = Caption { title: &title, unit: None };
        let bytes = match form {
            Form::Svg => picture::mesh_svg(drawing, &caption).map(String::into_bytes),
            Form::Png => picture::mesh_png(drawing, &caption, self.width),
        };
        let bytes = bytes.map_err(|error| failed(name, &error))?;
        output.write(|out| out.write_all(&bytes))
    }

    pub(crate) fn outputs(self) -> impl Iterator<Item = Output> {
        let drawings = [self.picture, self.plots].into_iter().flatten().map(|(_, output)| output);
        drawings.chain(self.report)
    }
}

/// File name without its folder.
fn title(name: &str) -> String {
    Path::new(name).file_name().map_or(name.to_owned(), |name| name.to_string_lossy().into())
}

/// Splits each line of a summary into its name and its text. Lines that differ from run to run are left out.
fn facts(summary: &str) -> Vec<(&str, &str)> {
    /// Width of a name and the blank after it.
    const NAMES: usize = 17;
    let lines = summary.lines().filter_map(|line| line.split_at_checked(NAMES));
    lines
        .map(|(name, text)| (name.trim(), text))
        .filter(|(name, _)| !matches!(*name, "time" | "peak memory"))
        .collect()
}

fn failed(name: &str, error: &PictureError) -> Failure {
    Failure::Unusable(format!("{name}: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_becomes_facts() {
        let summary =
            "file             a.csv, text\n                 2 of radius zero\ntime             read 1 s\n";
        assert_eq!(facts(summary), [("file", "a.csv, text"), ("", "2 of radius zero")]);
    }
}
