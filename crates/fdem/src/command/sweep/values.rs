//! The values of the runs of a sweep: combinations, rows of a table, Latin hypercubes.

use fdem_io::numbers::grouped;
use fdem_scenes::random::Random;
use sha2::{Digest, Sha256};

use fdem_model::Setting;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    Logarithmic,
}

/// The range of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) scale: Scale,
}

impl Axis {
    /// The value at a share of the range, with the same bits on every platform.
    fn at(self, share: f64) -> f64 {
        let Self { from, to, scale } = self;
        match scale {
            _ if share <= 0.0 => from,
            _ if share >= 1.0 => to,
            Scale::Linear => from + (to - from) * share,
            Scale::Logarithmic => {
                let (low, high) = (libm::log(from), libm::log(to));
                libm::exp(low + (high - low) * share)
            }
        }
    }

    /// Evenly spaced values with both ends. They have 15 digits: 0.3, and not 0.30000000000000004.
    pub(crate) fn spaced(self, count: u64) -> Vec<f64> {
        let rounded = |value: f64| format!("{value:.14e}").parse().unwrap_or(value);
        (0..count).map(|place| rounded(self.at(place as f64 / (count - 1).max(1) as f64))).collect()
    }
}

/// All combinations of the lists; the last list changes fastest.
pub(crate) fn product(lists: &[Vec<Setting>]) -> Vec<Vec<Setting>> {
    if lists.is_empty() {
        return Vec::new();
    }
    lists.iter().fold(vec![Vec::new()], |rows, list| {
        let longer = |row: &Vec<Setting>| -> Vec<Vec<Setting>> {
            list.iter().map(|value| [&row[..], std::slice::from_ref(value)].concat()).collect()
        };
        rows.iter().flat_map(longer).collect()
    })
}

/// Latin hypercube: each range is divided into as many equal parts as there are points, and has one point in
/// every part. The parts and the places in them are random; those of a parameter depend on the seed, the
/// number of points and its name alone.
///
/// # Source
/// M. D. `McKay`, R. J. Beckman, W. J. Conover, "A comparison of three methods for selecting values of input
/// variables in the analysis of output from a computer code", Technometrics 21 (1979) 239.
pub(crate) fn latin_hypercube(axes: &[(String, Axis)], count: u64, seed: u64) -> Vec<Vec<Setting>> {
    let column = |(name, axis): &(String, Axis)| -> Vec<f64> {
        let digest = Sha256::digest(name);
        let mut stream = [0; 8];
        stream.copy_from_slice(&digest[..8]);
        let mut random = Random::with_stream(seed, u64::from_le_bytes(stream));
        let mut parts: Vec<u64> = (0..count).collect();
        for place in (1..parts.len()).rev() {
            parts.swap(place, random.below(place as u64 + 1) as usize);
        }
        parts.into_iter().map(|part| axis.at((part as f64 + random.uniform()) / count as f64)).collect()
    };
    let columns: Vec<Vec<f64>> = axes.iter().map(column).collect();
    let row = |row: usize| columns.iter().map(|column| Setting::Number(column[row])).collect();
    (0..count as usize).map(row).collect()
}

/// Says why a row cannot be read. `columns`: number of names.
fn wrong(error: &csv::Error, columns: usize) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos: Some(place), len, .. } => {
            let values = if *len == 1 { "value" } else { "values" };
            format!("line {} has {len} {values}, and the first line has {columns} names", place.line())
        }
        csv::ErrorKind::Utf8 { pos: Some(place), .. } => format!("line {} is not UTF-8 text", place.line()),
        _ => error.to_string(),
    }
}

/// Names and rows of a CSV file. `most`: largest number of rows.
///
/// # Errors
/// A file that is no table of values, with its line.
pub(crate) fn csv(bytes: &[u8], most: usize) -> Result<(Vec<String>, Vec<Vec<Setting>>), String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes);
    let names: Vec<String> =
        reader.headers().map_err(|error| error.to_string())?.iter().map(str::to_owned).collect();
    if names.is_empty() || names.iter().any(String::is_empty) {
        return Err("its first line has the names of the parameters, separated by commas".to_owned());
    }
    if let Some(name) = names.iter().enumerate().find(|(place, name)| names[..*place].contains(name)) {
        return Err(format!("it has two columns \"{}\"", name.1));
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| wrong(&error, names.len()))?;
        if rows.len() == most {
            return Err(format!("it has more than {} rows; --max-runs allows more", grouped(most as u64)));
        }
        let line = record.position().map_or(0, csv::Position::line);
        if let Some(place) = record.iter().position(str::is_empty) {
            return Err(format!("line {line} has no value of \"{}\"", names[place]));
        }
        rows.push(record.iter().map(Setting::parse).collect());
    }
    if rows.is_empty() {
        return Err("it has no rows below the names".to_owned());
    }
    Ok((names, rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINEAR: Axis = Axis { from: 2.0, to: 10.0, scale: Scale::Linear };

    #[test]
    fn ranges_have_both_ends() {
        assert_eq!(LINEAR.spaced(5), [2.0, 4.0, 6.0, 8.0, 10.0]);
        let decades = Axis { from: 1e-3, to: 10.0, scale: Scale::Logarithmic }.spaced(5);
        assert_eq!(decades, [1e-3, 1e-2, 0.1, 1.0, 10.0]);
        let tenths = Axis { from: 0.1, to: 0.5, scale: Scale::Linear }.spaced(5);
        assert_eq!(tenths, [0.1, 0.2, 0.3, 0.4, 0.5]);
    }

    #[test]
    fn the_last_list_changes_fastest() {
        let numbers = |list: &[f64]| list.iter().map(|number| Setting::Number(*number)).collect::<Vec<_>>();
        let rows = product(&[numbers(&[1.0, 2.0]), numbers(&[3.0, 4.0, 5.0])]);
        let found: Vec<Vec<f64>> =
            rows.iter().map(|row| row.iter().filter_map(Setting::number).collect()).collect();
        assert_eq!(found, [[1., 3.], [1., 4.], [1., 5.], [2., 3.], [2., 4.], [2., 5.]]);
        assert!(product(&[numbers(&[1.0]), Vec::new()]).is_empty());
    }

    /// Each part of each range has one point, and a parameter keeps its values when another is added.
    #[test]
    fn a_latin_hypercube_has_a_point_in_every_part() {
        let log = Axis { from: 1.0, to: 1e6, scale: Scale::Logarithmic };
        let axes = [("a".to_owned(), LINEAR), ("b".to_owned(), log)];
        let rows = latin_hypercube(&axes, 40, 7);
        let column = |rows: &[Vec<Setting>], column: usize| -> Vec<f64> {
            rows.iter().map(|row| row[column].number().unwrap()).collect()
        };
        let parts = |shares: Vec<f64>| {
            let mut parts: Vec<usize> = shares.iter().map(|share| (share * 40.0) as usize).collect();
            parts.sort_unstable();
            parts
        };
        assert_eq!(
            parts(column(&rows, 0).iter().map(|x| (x - 2.0) / 8.0).collect()),
            (0..40).collect::<Vec<_>>()
        );
        assert_eq!(
            parts(column(&rows, 1).iter().map(|x| x.log10() / 6.0).collect()),
            (0..40).collect::<Vec<_>>()
        );
        assert_eq!(column(&latin_hypercube(&axes[1..], 40, 7), 0), column(&rows, 1));
        assert_ne!(column(&latin_hypercube(&axes, 40, 8), 0), column(&rows, 0));
        // Published results depend on these bits.
        let first: Vec<u64> = column(&latin_hypercube(&axes, 3, 1), 0).iter().map(|x| x.to_bits()).collect();
        assert_eq!(first, PINNED);
    }

    const PINNED: [u64; 3] = [0x4010_ef79_454e_8f22, 0x4020_d719_7dae_5532, 0x4016_3001_ada8_50f2];

    #[test]
    fn tables_are_read_and_faults_told_with_their_line() {
        let (names, rows) = csv(b"a, material.rock.cohesion\n# note\n1, 6 MPa\ntrue,\"x, y\"\n", 9).unwrap();
        assert_eq!(names, ["a", "material.rock.cohesion"]);
        assert_eq!(rows[0], [Setting::Whole(1), Setting::Text("6 MPa".into())]);
        assert_eq!(rows[1], [Setting::Flag(true), Setting::Text("x, y".into())]);
        for (text, why) in [
            ("a,b\n1,2\n3\n", "line 3 has 1 value, and the first line has 2 names"),
            ("a,b\n1,\n", "line 2 has no value of \"b\""),
            ("a,a\n1,2\n", "two columns \"a\""),
            ("a,b\n", "no rows"),
            ("", "first line"),
            ("a\n1\n2\n3\n", "more than 2 rows"),
        ] {
            let error = csv(text.as_bytes(), 2).unwrap_err();
            assert!(error.contains(why), "{text}: {error}");
        }
    }
}
