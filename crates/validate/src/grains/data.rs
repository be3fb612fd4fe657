//! Published data beside the project, at `../shared/data`. They are no part of it: cases without them say so.

use std::path::PathBuf;

/// Why a quantity is not compared.
pub(crate) const ABSENT: &str = "../shared/data is absent";

/// A curve of Chung and Ooi's test 4 over the angle of the impact, degrees.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Curve {
    TangentialRestitution,
    /// rad/s.
    AngularVelocity,
}

impl Curve {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::TangentialRestitution => "tangential restitution",
            Self::AngularVelocity => "angular velocity",
        }
    }

    fn file(self) -> &'static str {
        match self {
            Self::TangentialRestitution => "chung_ooi/test4_tangential_restitution.csv",
            Self::AngularVelocity => "chung_ooi/test4_final_angular_velocity.csv",
        }
    }
}

/// Looks for a file in `shared/data` beside the current folder, and beside the folders above it.
fn find(file: &str) -> Option<PathBuf> {
    let folder = std::env::current_dir().ok()?;
    folder.ancestors().map(|above| above.join("shared/data").join(file)).find(|path| path.is_file())
}

fn read(file: &str) -> Result<Option<String>, String> {
    let Some(path) = find(file) else { return Ok(None) };
    std::fs::read_to_string(&path).map(Some).map_err(|error| format!("{file}: {error}"))
}

/// Points of a curve; `None` without the data.
pub(super) fn curve(of: Curve, material: &str) -> Result<Option<Vec<[f64; 2]>>, String> {
    let Some(text) = read(of.file())? else { return Ok(None) };
    let mut points = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let Some(numbers) = line.strip_prefix(material) else { continue };
        points.push(numbers_of(numbers.trim_start_matches(',').split(','), of.file())?);
    }
    if points.is_empty() { Err(format!("{}: no points of {material}", of.file())) } else { Ok(Some(points)) }
}

/// Spheres of the round robin: radius and centre, m; `None` without the data. The last line of its bed is
/// malformed and is left out.
pub(super) fn spheres(file: &str) -> Result<Option<Vec<[f64; 4]>>, String> {
    let Some(text) = read(file)? else { return Ok(None) };
    let rows = text.lines().skip(1).filter(|line| line.split_whitespace().count() == 4);
    rows.map(|line| numbers_of(line.split_whitespace(), file)).collect::<Result<_, _>>().map(Some)
}

fn numbers_of<'a, const N: usize>(
    words: impl Iterator<Item = &'a str>,
    file: &str,
) -> Result<[f64; N], String> {
    let numbers: Result<Vec<f64>, _> = words.map(|word| word.trim().parse::<f64>()).collect();
    let wrong = || format!("{file}: a line without {N} numbers");
    numbers.map_err(|_| wrong())?.try_into().map_err(|_| wrong())
}
