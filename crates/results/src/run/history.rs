//! The history of a run: a text file that gets a row of numbers at regular intervals.

use std::fmt;
use std::io::{self, Write};

use fdem_simulation::{Crack, Energies};

use crate::run::csv::{push_number, quoted};
use crate::run::fragments::FragmentCount;
use crate::run::frame::code;

/// Columns of every history after step, time and the energies. Energies are in J, lengths in m, times in s;
/// the largest fragment has a share of the mass. In three dimensions cracks have an area, m².
const COLUMNS: [&str; 9] = [
    "balance",
    "error",
    "broken_joints",
    "crack_length",
    "crack_length_tension",
    "crack_length_shear",
    "crack_length_mixed",
    "fragments",
    "largest_fragment",
];

/// Names of the columns of every history, in the given number of dimensions.
pub fn history_columns(dimensions: usize) -> Vec<String> {
    let energies = Energies::default();
    let first = ["step", "time"].into_iter().chain(energies.changing().map(|term| term.key));
    let cracked = |name: &str| if dimensions == 3 { name.replace("length", "area") } else { name.to_owned() };
    first.map(String::from).chain(COLUMNS.map(cracked)).collect()
}

/// A row of a history: the state of a run at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Number of steps done.
    pub step: u64,
    /// Time, s.
    pub time: f64,
    /// Energies, J.
    pub energies: Energies,
    /// Number of joints that the run has broken; those of sets that are open from the start do not count.
    pub broken: u64,
    /// Total lengths, m, or areas, m², of the joints that broke in tension, in shear and in mixed mode.
    pub lengths: [f64; 3],
    /// Number of fragments, and share of the largest in their mass.
    pub fragments: FragmentCount,
    /// Values of the user's columns, in the order of their names.
    pub values: Vec<f64>,
}

impl Row {
    /// The numbers of the row, in the order of the columns: the columns of [`history_columns`], then those of
    /// the user.
    pub fn numbers(&self) -> Vec<f64> {
        let Self { energies, lengths: [tension, shear, mixed], fragments, .. } = self;
        let mut numbers = vec![self.step as f64, self.time];
        numbers.extend(energies.changing().map(|term| term.value));
        numbers.extend([energies.balance(), energies.error(), self.broken as f64]);
        numbers.extend([tension + shear + mixed, *tension, *shear, *mixed]);
        numbers.extend([fragments.number as f64, fragments.largest]);
        numbers.extend(&self.values);
        numbers
    }

    /// Returns the number of joints that the run has broken, and their total lengths in tension, in shear and
    /// in mixed mode, m: [`Row::broken`] and [`Row::lengths`].
    pub fn broken_joints<const D: usize>(cracks: &[Crack<D>]) -> (u64, [f64; 3]) {
        let (mut count, mut lengths) = (0, [0.0; 3]);
        for crack in cracks.iter().filter(|crack| crack.time.is_some() && !crack.open_from_start) {
            count += 1;
            lengths[usize::from(code(crack.mode))] += crack.measure;
        }
        (count, lengths)
    }
}

/// Writes a history as delimited text: one line of names, then the rows. Numbers have the shortest form that
/// reads back as the same number.
///
/// Names of the user's columns end with their unit in brackets: `load [N]`.
///
/// # Example
/// ```
/// use fdem_results::{History, HistoryWriter, Row};
///
/// let mut text = Vec::new();
/// let mut writer = HistoryWriter::new(&mut text, 2, &["load [N]".to_owned()])?;
/// writer.row(&Row { step: 10, time: 1e-6, values: vec![2.5], ..Row::default() })?;
/// let history = History::read(&text)?;
/// assert_eq!(history.column("load [N]"), Some(&[2.5][..]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct HistoryWriter<W> {
    out: W,
    width: usize,
    line: String,
}

impl<W: Write> HistoryWriter<W> {
    /// Creates a writer of a run in two or three dimensions, and writes the names of the columns.
    ///
    /// # Errors
    /// The errors of `out`.
    pub fn new(mut out: W, dimensions: usize, names: &[String]) -> io::Result<Self> {
        let mut line = history_columns(dimensions).join(",");
        for name in names {
            line.push(',');
            line.push_str(&quoted(name));
        }
        line.push('\n');
        out.write_all(line.as_bytes())?;
        Ok(Self { out, width: names.len(), line })
    }

    /// Creates a writer that continues a text, without writing names. `width` is the number of the user's
    /// columns.
    pub fn going_on(out: W, width: usize) -> Self {
        Self { out, width, line: String::new() }
    }

    /// Writes a row in one piece.
    ///
    /// # Errors
    /// The errors of `out`; [`io::ErrorKind::InvalidInput`] if the number of values differs from that of the
    /// user's columns.
    pub fn row(&mut self, row: &Row) -> io::Result<()> {
        if row.values.len() != self.width {
            let problem = format!("the row has {} values for {} names", row.values.len(), self.width);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        self.line.clear();
        self.line.push_str(&row.step.to_string());
        for number in row.numbers().into_iter().skip(1) {
            push_number(&mut self.line, number);
        }
        self.line.push('\n');
        self.out.write_all(self.line.as_bytes())
    }

    /// Returns the underlying writer.
    pub fn get_mut(&mut self) -> &mut W {
        &mut self.out
    }
}

/// A history that has been read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

/// The reason why a text cannot be read as a history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryError {
    /// Number of the line, from 1.
    pub line: usize,
    /// Description of the error.
    pub problem: String,
}

impl fmt::Display for HistoryError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "line {} of the history: {}", self.line, self.problem)
    }
}

impl std::error::Error for HistoryError {}

impl History {
    /// Reads the text of a [`HistoryWriter`]. A last line without a line break is incomplete and is left out.
    ///
    /// # Errors
    /// [`HistoryError`] for the first line that is wrong.
    pub fn read(text: &[u8]) -> Result<Self, HistoryError> {
        let mut lines = whole_lines(text);
        let head = lines.next().ok_or_else(|| HistoryError::at(1, "there are no column names"))?;
        let names = fields(&utf8(head, 1)?);
        if ![2, 3].into_iter().any(|dimensions| names.starts_with(&history_columns(dimensions))) {
            return Err(HistoryError::at(1, "the column names are not those of a history"));
        }
        let mut columns = vec![Vec::new(); names.len()];
        for (k, line) in lines.enumerate() {
            let line_text = utf8(line, k + 2)?;
            let values: Vec<&str> = line_text.trim_end_matches('\r').split(',').collect();
            if values.len() != names.len() {
                let problem = format!("{} values for {} columns", values.len(), names.len());
                return Err(HistoryError::at(k + 2, problem));
            }
            for ((column, value), name) in columns.iter_mut().zip(values).zip(&names) {
                let number = value
                    .parse()
                    .map_err(|_| HistoryError::at(k + 2, format!("{name}: {value:?} is not a number")))?;
                column.push(number);
            }
        }
        Ok(Self { names, columns })
    }

    /// Returns the names of all columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the values of the first column with this name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let place = self.names.iter().position(|other| other == name)?;
        Some(&self.columns[place])
    }

    /// Returns the name and the values of each of the user's columns.
    pub fn of_user(&self) -> impl Iterator<Item = (&str, &[f64])> {
        let all = self.names.iter().zip(&self.columns).skip(history_columns(2).len());
        all.map(|(name, values)| (name.as_str(), values.as_slice()))
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
}

impl HistoryError {
    fn at(line: usize, problem: impl Into<String>) -> Self {
        Self { line, problem: problem.into() }
    }
}

/// Returns the complete lines, without their line breaks.
fn whole_lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let end = text.iter().rposition(|&byte| byte == b'\n').unwrap_or(0);
    text[..end].split(|&byte| byte == b'\n').filter(move |_| end > 0)
}

fn utf8(line: &[u8], number: usize) -> Result<String, HistoryError> {
    String::from_utf8(line.to_vec()).map_err(|_| HistoryError::at(number, "this is not UTF-8 text"))
}

/// Splits a line of delimited text into its fields.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut within = false;
    let mut characters = line.trim_end_matches('\r').chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if within && characters.peek() == Some(&'"') => {
                characters.next();
                if let Some(field) = fields.last_mut() {
                    field.push('"');
                }
            }
            '"' => within = !within,
            ',' if !within => fields.push(String::new()),
            c => {
                if let Some(field) = fields.last_mut() {
                    field.push(c);
                }
            }
        }
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(steps: &[u64]) -> Vec<u8> {
        let mut text = Vec::new();
        let names = ["load, \"upper\" [N]".to_owned(), "gap [m]".to_owned()];
        let mut writer = HistoryWriter::new(&mut text, 2, &names).unwrap();
        for &step in steps {
            let energies = Energies { kinetic: 0.1, external: 1.0 / 3.0, ..Energies::default() };
            let values = vec![-1e-300 * step as f64, f64::NAN];
            let fragments = FragmentCount { number: 3, largest: 0.625 };
            let lengths = [0.1, 0.2, 0.0];
            let row = Row { step, time: 1e-7 * step as f64, energies, broken: 2, lengths, fragments, values };
            writer.row(&row).unwrap();
        }
        text
    }

    #[test]
    fn numbers_read_back_as_they_were() {
        let text = history(&[0, 7]);
        let read = History::read(&text).unwrap();
        assert_eq!(read.rows(), 2);
        assert_eq!(read.column("time"), Some(&[0.0, 7.0 * 1e-7][..]));
        assert_eq!(read.column("external"), Some(&[1.0 / 3.0; 2][..]));
        assert_eq!(read.column("balance"), Some(&[0.1 - 1.0 / 3.0; 2][..]));
        assert_eq!(read.column("crack_length"), Some(&[0.1 + 0.2; 2][..]));
        assert_eq!(read.column("fragments"), Some(&[3.0; 2][..]));
        assert_eq!(read.column("largest_fragment"), Some(&[0.625; 2][..]));
        let user: Vec<(&str, &[f64])> = read.of_user().collect();
        assert_eq!(user[0].0, "load, \"upper\" [N]");
        assert_eq!(user[0].1[1], -1e-300 * 7.0);
        assert!(user[1].1[0].is_nan());
    }

    #[test]
    fn a_run_that_goes_on_keeps_what_it_had_done() {
        let text = history(&[0, 10, 20, 30]);
        assert_eq!(History::read(&text[..text.len() - 3]).unwrap().rows(), 3, "an incomplete line");
        let mut going_on = history(&[0, 10]);
        let mut writer = HistoryWriter::going_on(&mut going_on, 2);
        assert!(writer.row(&Row::default()).is_err(), "two values are expected");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let error = |text: &[u8]| History::read(text).unwrap_err().to_string();
        assert_eq!(error(b""), "line 1 of the history: there are no column names");
        assert_eq!(
            error(b"a,b\n1,2\n"),
            "line 1 of the history: the column names are not those of a history"
        );
        let mut text = history(&[0]);
        text.extend(b"1,2\n");
        assert_eq!(error(&text), "line 3 of the history: 2 values for 21 columns");
        let mut text = history(&[]);
        text.extend("0,".repeat(19).as_bytes());
        text.extend(b"1,x\n");
        assert_eq!(error(&text), "line 2 of the history: gap [m]: \"x\" is not a number");
        let mut text = history(&[0]);
        text.extend(b"1.5,\xff\n");
        assert_eq!(error(&text), "line 3 of the history: this is not UTF-8 text");
    }
}
