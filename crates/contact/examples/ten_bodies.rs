//! The ten-body example of the book, pp. 103-110, step by step: prints the lists of Figs 3.41 to 3.44, and
//! the following steps.
//!
//! ```text
//! cargo run -p fdem-contact --example ten_bodies
//! ```
//!
//! Everything is in the numbering of the book: bodies, rows and columns from 1, and -1 for an empty list.

use std::fmt;

use fdem_contact::{Couple, Elements, Error, Lists, NONE, Nbs, Observer, Set};

/// The output of one detection in 2D, as the book prints it.
#[derive(Debug, Default)]
pub(crate) struct Figures {
    /// Fig. 3.41: the bodies of each y-list, in list order; row `i` at `y_lists[i - 1]`.
    pub(crate) y_lists: Vec<Vec<i64>>,
    /// Fig. 3.42: heads of the y-lists.
    pub(crate) b: Vec<i64>,
    /// Fig. 3.42: next body on the same y-list.
    pub(crate) y: Vec<i64>,
    /// Fig. 3.44, for each central row in the order of the visit.
    pub(crate) rows: Vec<Row>,
    /// Central cells `(i_x, i_y)` in the order of the visit.
    pub(crate) central_cells: Vec<(u32, u32)>,
    /// Couples in the same or in adjacent cells, smaller number first, ascending.
    pub(crate) candidates: Vec<(u32, u32)>,
}

/// The x-lists of one central row.
#[derive(Debug)]
pub(crate) struct Row {
    /// The row, `i_y`.
    pub(crate) i_y: u32,
    /// Heads of the x-lists: of the central row, and of the row below.
    pub(crate) a: [Vec<i64>; 2],
    /// Next body on the same x-list. Entries of bodies in other rows are stale.
    pub(crate) x: Vec<i64>,
}

impl Figures {
    /// Runs Munjiza-NBS on `centres` of diameter 1 in 10 by 10 cells, and records its steps.
    pub(crate) fn draw(centres: &[[f64; 2]]) -> Result<Self, Error> {
        let mut figures = Self::default();
        let elements = Elements::points(centres, 1.0)?;
        Nbs::new().with_domain([[0.0, 10.0]; 2]).observe(&elements, &mut figures, |_| {})?;
        figures.candidates.sort_unstable();
        Ok(figures)
    }
}

impl Observer<2> for Figures {
    fn lists(&mut self, axis: usize, cell: &[u32; 2], lists: &Lists) {
        let heads = |set| in_the_books_numbers(lists.heads(set));
        if axis == 1 {
            let rows = 0..lists.heads(Set::Central).len() as u32;
            self.y_lists = rows
                .map(|row| lists.iter(Set::Central, row).map(|body| i64::from(body) + 1).collect())
                .collect();
            self.b = heads(Set::Central);
            self.y = in_the_books_numbers(lists.next());
        } else {
            let a = [heads(Set::Central), heads(Set::Neighbours)];
            self.rows.push(Row { i_y: cell[1] + 1, a, x: in_the_books_numbers(lists.next()) });
        }
    }

    fn central_cell(&mut self, cell: &[u32; 2]) {
        self.central_cells.push((cell[0] + 1, cell[1] + 1));
    }

    fn candidate(&mut self, couple: Couple) {
        self.candidates.push((couple.i + 1, couple.j + 1));
    }
}

/// Numbers from 1, and -1 for none.
pub(crate) fn in_the_books_numbers(integers: &[u32]) -> Vec<i64> {
    integers.iter().map(|&k| if k == NONE { -1 } else { i64::from(k) + 1 }).collect()
}

impl fmt::Display for Figures {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "y-lists (Fig. 3.41)")?;
        for (row, list) in self.y_lists.iter().enumerate().rev() {
            writeln!(out, "  y{:<2} {}", row + 1, numbers(list))?;
        }
        writeln!(out, "\nB = {}   heads of the y-lists (Fig. 3.42)", numbers(&self.b))?;
        writeln!(out, "Y = {}   next body on the same y-list", numbers(&self.y))?;
        for Row { i_y: row, a: [central, below], x } in &self.rows {
            writeln!(out, "\nrow {row}{}", if *row == 7 { " (Figs 3.43 and 3.44)" } else { "" })?;
            writeln!(out, "  A = {}   heads of the x-lists of row {row}", numbers(central))?;
            writeln!(out, "      {}   and of row {}, below it", numbers(below), row - 1)?;
            writeln!(out, "  X = {}   next body on the same x-list", numbers(x))?;
            let cells = self.central_cells.iter().filter(|cell| cell.1 == *row);
            writeln!(out, "  central cells (i_x, i_y): {}", pairs(cells, |(x, y)| format!("({x}, {y})")))?;
        }
        writeln!(out, "\n{} candidate couples (same or adjacent cell)", self.candidates.len())?;
        writeln!(out, "  {}", pairs(self.candidates.iter(), |(i, j)| format!("{i}-{j}")))
    }
}

fn numbers(integers: &[i64]) -> String {
    integers.iter().map(|k| format!("{k:>2}")).collect::<Vec<_>>().join(" ")
}

fn pairs<'a>(pairs: impl Iterator<Item = &'a (u32, u32)>, show: impl Fn(&(u32, u32)) -> String) -> String {
    pairs.map(show).collect::<Vec<_>>().join(" ")
}

#[allow(
    dead_code,
    clippy::print_stdout,
    reason = "printing is what the example is for; the golden tests include it too"
)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{}", Figures::draw(&fdem_scenes::book::ten_bodies().centres)?);
    Ok(())
}
