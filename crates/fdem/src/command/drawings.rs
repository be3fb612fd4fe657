//! Drawings of `fdem contacts`: `--picture`, `--plots`, `--report`.

use std::path::{Path, PathBuf};

use clap::Args;
use fdem_results::network::Network;
use fdem_results::page::network::{self as report, BodiesReport, Report};
use fdem_results::picture::{self, Bodies, Caption, MeshDrawing, PictureError};

use crate::command::failure::Failure;
use crate::command::input::{Input, id};
use crate::command::output::Output;

/// Options for pictures and reports.
#[derive(Clone, Debug, Args)]
pub(crate) struct DrawingArguments {
    /// Draw the elements and their contacts, coloured by overlap: discs in 2D, shaded spheres and a view of the contacts in 3D. A contact across a face of
    /// the box is drawn as two halves. For meshes in a plane, draw the triangles coloured by body, and the contacts of bodies. For meshes in 3D, for spheres and walls,
    /// and for images, draw the bodies, and lines between their centres through the contact points; bodies of images are discs or spheres of the same area or volume.
    #[arg(long, value_name = "FILE.svg|FILE.png", value_parser = drawing)]
    pub(crate) picture: Option<PathBuf>,

    /// Draw the distributions of contacts, overlaps, sizes and directions.
    #[arg(long, value_name = "FILE.svg|FILE.png", value_parser = drawing)]
    pub(crate) plots: Option<PathBuf>,

    /// Width of PNG pictures in pixels [default: twice the width of an SVG].
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(200..=10_000))]
    pub(crate) picture_width: Option<u32>,

    /// Write an HTML page in one file: the summary, the distributions, a 3D view in which elements can be selected, and a table of all elements.
    #[arg(long, value_name = "FILE.html", value_parser = page)]
    pub(crate) report: Option<PathBuf>,
}

impl DrawingArguments {
    /// Each option and its file, if it is given.
    pub(crate) fn files(&self) -> [(&'static str, Option<&PathBuf>); 3] {
        [
            ("--picture", self.picture.as_ref()),
            ("--plots", self.plots.as_ref()),
            ("--report", self.report.as_ref()),
        ]
    }

    /// Whether any drawing is asked for.
    pub(crate) fn any(&self) -> bool {
        self.files().iter().any(|(_, file)| file.is_some())
    }

    /// Refuses a report of too many elements before the search.
    pub(crate) fn check(&self, elements: usize, name: &str) -> Result<(), Failure> {
        if self.report.is_some() && elements > report::MOST_ELEMENTS {
            let error =
                PictureError::TooMany { what: "elements", found: elements, most: report::MOST_ELEMENTS };
            return Err(failed(name, &error));
        }
        Ok(())
    }
}

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
            let page = report::html(&Report { network: *network, caption, ids: Some(&ids), facts: &facts })
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

fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

fn drawing(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if has_extension(&path, "svg") || has_extension(&path, "png") {
        return Ok(path);
    }
    Err(format!("'{text}' does not end in .svg or .png, the formats of pictures"))
}

fn page(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if has_extension(&path, "html") || has_extension(&path, "htm") {
        return Ok(path);
    }
    Err(format!("'{text}' does not end in .html, the format of reports"))
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
