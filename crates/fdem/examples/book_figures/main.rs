//! Draws the figures of "How detection works" in the book, from searches that run: see `book/src/how`.
//!
//! ```text
//! cargo run -p fdem --example book_figures -- book/src/figures
//! ```

mod cells;
mod nbs;
mod paper;
mod scenes;

use std::error::Error;
use std::fs;
use std::path::PathBuf;

/// Every figure, by its name in the folder.
pub(crate) fn figures() -> Result<Vec<(&'static str, String)>, Box<dyn Error>> {
    let steps = nbs::Steps::of_ten_bodies()?;
    Ok(vec![
        ("direct.svg", scenes::direct()?),
        ("nbs-steps.svg", steps.sequence()),
        ("nbs.svg", steps.animation()),
        ("rows.svg", scenes::rows()?),
        ("multilevel.svg", scenes::multilevel()?),
        ("cgrid.svg", scenes::cgrid()?),
    ])
}

#[allow(dead_code, reason = "the test that the figures are up to date includes this file too")]
fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: book_figures FOLDER")?);
    for (name, svg) in figures()? {
        fs::write(folder.join(name), svg)?;
    }
    Ok(())
}
