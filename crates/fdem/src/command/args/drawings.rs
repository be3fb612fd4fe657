//! Options for drawings.

use std::path::{Path, PathBuf};

use clap::Args;

/// Options for pictures and reports.
#[derive(Clone, Debug, Args)]
pub(crate) struct DrawingArguments {
    /// Draw the elements and their contacts, coloured by overlap: discs in 2D, shaded spheres and a view of
    /// the contacts in 3D. A contact across a face of the box is drawn as two halves. For meshes in a plane,
    /// draw the triangles coloured by body, and the contacts of bodies. For meshes in 3D, for spheres and
    /// walls, and for images, draw the bodies, and lines between their centres through the contact points;
    /// bodies of images are discs or spheres of the same area or volume.
    #[arg(long, value_name = "FILE.svg|FILE.png", value_parser = drawing)]
    pub(crate) picture: Option<PathBuf>,

    /// Draw the distributions of contacts, overlaps, sizes and directions.
    #[arg(long, value_name = "FILE.svg|FILE.png", value_parser = drawing)]
    pub(crate) plots: Option<PathBuf>,

    /// Width of PNG pictures in pixels [default: twice the width of an SVG].
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(200..=10_000))]
    pub(crate) picture_width: Option<u32>,

    /// Write an HTML page in one file: the summary, the distributions, a 3D view in which elements can be
    /// selected, and a table of all elements.
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

    /// Whether any drawing is requested.
    pub(crate) fn any(&self) -> bool {
        self.files().iter().any(|(_, file)| file.is_some())
    }
}

/// The file of a picture, whose ending gives the format.
pub(crate) fn drawing(text: &str) -> Result<PathBuf, String> {
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

pub(crate) fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}
