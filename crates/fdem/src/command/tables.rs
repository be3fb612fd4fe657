//! Tables of couples and elements, written in the format given by the extension of the output.

use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::Ordering;

use fdem_io::{Packing, Table, Values};
use fdem_results::network::{Measures, Network, Sizes};

use crate::command::failure::Failure;
use crate::command::input::id;
use crate::command::output::{Output, TableFormat};
use crate::command::progress::Position;

const POINT: [&str; 3] = ["x", "y", "z"];
const SHIFT: [&str; 3] = ["sx", "sy", "sz"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// Names of the coordinates.
pub(crate) fn point<const D: usize>() -> &'static [&'static str] {
    &POINT[..D]
}

/// Names of the components of a direction.
pub(crate) fn normal<const D: usize>() -> &'static [&'static str] {
    &NORMAL[..D]
}

/// Writes a table in a format that holds any table.
pub(crate) fn write_table(
    output: &mut Output,
    format: TableFormat,
    table: &Table<'_>,
) -> Result<(), Failure> {
    output.write(|mut out| match format {
        TableFormat::Npy => fdem_io::write_npy(&mut out, table),
        TableFormat::Npz => fdem_io::write_npz(&mut out, &[table]),
        TableFormat::Parquet => fdem_io::write_parquet(&mut out, table),
        // Formats for networks have been refused before.
        _ => fdem_io::write_csv(&mut out, table),
    })
}

/// Writes the couples of a packing with more `columns`, and its elements if the format holds them. `position`
/// counts the couples.
pub(crate) fn write_network<const D: usize>(
    output: &mut Output,
    format: TableFormat,
    packing: &Packing,
    network: &Network<'_, D>,
    columns: &[(String, Vec<f64>)],
    position: &Position,
) -> Result<(), Failure> {
    let drawn = DrawnPacking { packing: Some(packing), ids: None, network, columns, position };
    output.write(|out| drawn.write(format, out))
}

/// Returns the bytes of a file with the couples of a network, and with its elements if the format holds them.
///
/// Ids of elements are their numbers from 0. The extension of `name` gives the format, as for the option
/// `--output` of the command.
///
/// # Errors
/// A message if the extension is not that of a format.
pub fn network_file<const D: usize>(network: &Network<'_, D>, name: &Path) -> Result<Vec<u8>, String> {
    let format = TableFormat::of(Some(name)).map_err(|error| error.to_string())?;
    let mut bytes = Vec::new();
    let drawn =
        DrawnPacking { packing: None, ids: None, network, columns: &[], position: &Position::default() };
    drawn.write(format, &mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes)
}

impl<const D: usize> DrawnPacking<'_, D> {
    fn write(&self, format: TableFormat, mut out: &mut (dyn Write + Send)) -> io::Result<()> {
        let Self { network, .. } = *self;
        match format {
            TableFormat::Csv => fdem_io::write_csv(&mut out, &self.couples()),
            TableFormat::Npy => fdem_io::write_npy(&mut out, &self.couples()),
            TableFormat::Parquet => fdem_io::write_parquet(&mut out, &self.couples()),
            TableFormat::Npz => {
                let (couples, elements, cell) = (self.couples_by_row(), self.elements_by_row(), self.cell());
                fdem_io::write_npz(&mut out, &[&couples, &elements, &cell])
            }
            TableFormat::Vtp => {
                let degrees = self.degrees();
                let across = self.across();
                fdem_io::write_vtp(&mut out, &self.points(&degrees, &across), &self.lines(&across))
            }
            TableFormat::GraphMl => {
                let degrees = self.degrees();
                fdem_io::write_graphml(&mut out, &self.nodes(&degrees), &self.couples())
            }
            TableFormat::Json => {
                let degrees = self.degrees();
                let several = network.space.cell.is_some();
                fdem_io::write_node_link(&mut out, &self.nodes(&degrees), &self.couples(), several)
            }
        }
    }
}

/// The number written where a frame has no time step.
const NO_STEP: i64 = -1;

/// Table of the couples of a frame, with its number, its step and `shifts` columns of shifts, which are zero
/// without a periodic box.
pub(crate) fn frame_table<'a, const D: usize>(
    packing: &'a Packing,
    network: &'a Network<'a, D>,
    shifts: usize,
    position: &'a Position,
) -> Table<'a> {
    let drawn = DrawnPacking { packing: Some(packing), ids: None, network, columns: &[], position };
    let (number, step) = (packing.frame.index, packing.frame.step.unwrap_or(NO_STEP));
    let table = Table::new(network.couples.len())
        .with("frame", Values::i64(move |_| number.cast_signed() as i64))
        .with("step", Values::i64(move |_| step));
    let table = drawn.measures(drawn.ids(table));
    match (shifts, network.space.cell.is_some()) {
        (0, _) => table,
        (_, true) => drawn.shifts(table),
        (_, false) => table.with_components("shift", &SHIFT[..shifts], Values::i32(|_| 0)),
    }
}

/// A packing and its couples, with the ids of its file.
struct DrawnPacking<'a, const D: usize> {
    /// `None`: the ids of elements are their numbers.
    packing: Option<&'a Packing>,
    /// Ids of the elements, in place of those of the packing.
    ids: Option<&'a [i64]>,
    network: &'a Network<'a, D>,
    /// More columns of the couples, as those of a file.
    columns: &'a [(String, Vec<f64>)],
    position: &'a Position,
}

fn id_of(packing: Option<&Packing>, index: usize) -> i64 {
    packing.map_or(index.cast_signed() as i64, |packing| id(packing, index))
}

/// Table of the couples of elements that have these ids, as [`write_network`] writes it.
pub(crate) fn couples_with_ids<'a, const D: usize>(
    network: &'a Network<'a, D>,
    ids: &'a [i64],
    position: &'a Position,
) -> Table<'a> {
    DrawnPacking { packing: None, ids: Some(ids), network, columns: &[], position }.couples()
}

impl<'a, const D: usize> DrawnPacking<'a, D> {
    /// Couples with the ids of the file, and with shifts in a periodic box.
    fn couples(&self) -> Table<'a> {
        let table = self.measures(self.ids(Table::new(self.network.couples.len())));
        if self.network.space.cell.is_some() { self.shifts(table) } else { table }
    }

    fn ids(&self, table: Table<'a>) -> Table<'a> {
        let Self { packing, ids, network, .. } = *self;
        let couples = network.couples;
        let id_of = move |element: u32| match ids {
            Some(ids) => ids[element as usize],
            None => id_of(packing, element as usize),
        };
        table
            .with("i", self.counted(move |k| id_of(couples.get(k).i)))
            .with("j", Values::i64(move |k| id_of(couples.get(k).j)))
    }

    /// Couples with the row numbers of the elements, always with shifts.
    fn couples_by_row(&self) -> Table<'a> {
        let couples = self.network.couples;
        let table = Table::new(couples.len())
            .with("i", self.counted(move |k| i64::from(couples.get(k).i)))
            .with("j", Values::i64(move |k| i64::from(couples.get(k).j)));
        self.shifts(self.measures(table))
    }

    fn counted(&self, at: impl Fn(usize) -> i64 + 'a) -> Values<'a> {
        let position = self.position;
        Values::i64(move |k| {
            position.store(k as u64, Ordering::Relaxed);
            at(k)
        })
    }

    fn measures(&self, table: Table<'a>) -> Table<'a> {
        let network = self.network;
        let couples = network.couples;
        let table = match Measures::of(network) {
            None => table
                .with("distance", Values::f64(move |k| network.space.distance(couples.get(k))))
                .with("overlap", Values::f64(move |k| network.overlap(couples.get(k)))),
            Some(measures) => table
                .with("distance", Values::f64(move |k| measures.distance(k)))
                .with("overlap", Values::f64(move |k| measures.overlap(k))),
        };
        let columns = self.columns.iter();
        columns.fold(table, |table, (name, values)| table.with(name, Values::f64(move |k| values[k])))
    }

    fn shifts(&self, table: Table<'a>) -> Table<'a> {
        let couples = self.network.couples;
        let at = Values::i32(move |k| couples.get(k / D).shift[k % D]);
        table.with_components("shift", &SHIFT[..D], at)
    }

    /// Positions of the elements, their radii unless they are points, and the ids of the file, if it has any.
    fn elements_by_row(&self) -> Table<'a> {
        let Self { packing, network, .. } = *self;
        let centres = network.space.centres;
        let mut table = Table::new(centres.len()).with_components(
            "positions",
            point::<D>(),
            Values::f64(move |k| centres[k / D][k % D]),
        );
        if !network.sizes.are_points() {
            table = table.with("radii", Values::f64(move |k| network.sizes.radius(k)));
        }
        if packing.is_some_and(|packing| packing.ids.is_some() || packing.row_numbers.is_some()) {
            table = table.with("ids", Values::i64(move |k| id_of(packing, k)));
        }
        table
    }

    /// Periodic box, one row per edge; without columns if there is none.
    fn cell(&self) -> Table<'a> {
        let table = Table::new(D);
        let Some(cell) = self.network.space.cell else { return table };
        let (edges, origin, periodic) = (cell.edges(), cell.origin(), cell.periodic());
        table
            .with_components("edges", point::<D>(), Values::f64(move |k| edges[k / D][k % D]))
            .with("origin", Values::f64(move |k| origin[k]))
            .with("periodic", Values::i32(move |k| i32::from(periodic[k])))
    }

    /// Nodes of a graph.
    fn nodes(&self, degrees: &'a [u32]) -> Table<'a> {
        let Self { packing, network, .. } = *self;
        let centres = network.space.centres;
        let table = Table::new(centres.len())
            .with("id", Values::i64(move |k| id_of(packing, k)))
            .with_components("positions", point::<D>(), Values::f64(move |k| centres[k / D][k % D]));
        self.described(table, degrees, |k| k)
    }

    /// Adds columns for radius and coordination. `element` returns the element of a row.
    fn described(
        &self,
        table: Table<'a>,
        degrees: &'a [u32],
        element: impl Fn(usize) -> usize + Copy + 'a,
    ) -> Table<'a> {
        let network = self.network;
        let table = match network.sizes {
            Sizes::Cutoff(_) | Sizes::Pairs(_) => table,
            sizes => table.with("radius", Values::f64(move |k| sizes.radius(element(k)))),
        };
        table.with("coordination", Values::i32(move |k| degrees[element(k)].cast_signed()))
    }

    /// Number of contacts of each element.
    fn degrees(&self) -> Vec<u32> {
        let mut degrees = vec![0; self.network.space.centres.len()];
        for couple in self.network.couples.iter() {
            degrees[couple.i as usize] += 1;
            degrees[couple.j as usize] += 1;
        }
        degrees
    }

    /// Couples across a face of the box, in ascending order. Their lines end at extra points.
    fn across(&self) -> Vec<usize> {
        let couples = self.network.couples;
        (0..couples.len()).filter(|&k| couples.get(k).shift != [0; D]).collect()
    }

    /// Elements at their positions in the file, then the images at which lines across a face end.
    fn points(&self, degrees: &'a [u32], across: &'a [usize]) -> Table<'a> {
        let Self { packing, network, .. } = *self;
        let (space, couples) = (network.space, network.couples);
        let n = space.centres.len();
        let element = move |k: usize| if k < n { k } else { couples.get(across[k - n]).j as usize };
        let position = move |k: usize| {
            let centre = space.centres[element(k)];
            match &space.cell {
                Some(cell) if k >= n => cell.displaced(&centre, &couples.get(across[k - n]).shift),
                _ => centre,
            }
        };
        let at = move |k: usize| if k % 3 < D { position(k / 3)[k % 3] } else { 0.0 };
        let table = Table::new(n + across.len())
            .with_components("positions", &POINT, Values::f64(at))
            .with("id", Values::i64(move |k| id_of(packing, element(k))));
        self.described(table, degrees, element).with("image", Values::i32(move |k| i32::from(k >= n)))
    }

    /// Table with a line per couple.
    fn lines(&self, across: &'a [usize]) -> Table<'a> {
        let (couples, n) = (self.network.couples, self.network.space.centres.len());
        let end = move |k: usize| {
            let couple = couples.get(k / 2);
            match (k % 2, couple.shift == [0; D]) {
                (0, _) => i64::from(couple.i),
                (_, true) => i64::from(couple.j),
                (_, false) => (n + across.partition_point(|&earlier| earlier < k / 2)).cast_signed() as i64,
            }
        };
        let table = Table::new(couples.len()).with_components("ends", &["first", "second"], Values::i64(end));
        let shift = move |k: usize| if k % 3 < D { couples.get(k / 3).shift[k % 3] } else { 0 };
        self.measures(table).with_components("shift", &SHIFT, Values::i32(shift))
    }
}
