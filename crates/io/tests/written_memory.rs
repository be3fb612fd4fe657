//! Writing a table stores no rows: every format takes blocks of the table, however long it is.

#![allow(clippy::cast_possible_wrap, reason = "tables of tests are short")]

use std::io;

use fdem_io::{
    Table, Values, write_csv, write_graphml, write_node_link, write_npy, write_npz, write_parquet, write_vtp,
};
use peak_alloc::PeakAlloc;

#[global_allocator]
static PEAK: PeakAlloc = PeakAlloc;

const ROWS: usize = 1_000_000;

/// Couples that would take 44 bytes per row in memory.
fn couples() -> Table<'static> {
    Table::new(ROWS)
        .with("i", Values::i64(|k| k as i64))
        .with("j", Values::i64(|k| 3 * k as i64))
        .with("distance", Values::f64(|k| (k as f64).sqrt()))
        .with("overlap", Values::f64(|k| (k as f64).sin()))
        .with_components("shift", &["sx", "sy", "sz"], Values::i32(|k| k as i32))
}

/// One test only, because the peak is that of the whole program.
#[test]
fn a_million_rows_take_blocks() {
    let points = Table::new(100).with_components("positions", &["x", "y", "z"], Values::f64(|k| k as f64));
    let lines = Table::new(ROWS)
        .with_components("ends", &["i", "j"], Values::i64(|k| k as i64 % 100))
        .with("overlap", Values::f64(|k| (k as f64).sin()));
    let nodes = Table::new(100).with("id", Values::i64(|k| k as i64));
    let mut writers: [(&str, &mut dyn FnMut() -> io::Result<()>); 7] = [
        ("csv", &mut || write_csv(&mut io::sink(), &couples())),
        ("npy", &mut || write_npy(&mut io::sink(), &couples())),
        ("npz", &mut || write_npz(&mut io::sink(), &[&couples()])),
        ("parquet", &mut || write_parquet(&mut io::sink(), &couples())),
        ("vtp", &mut || write_vtp(&mut io::sink(), &points, &lines)),
        ("graphml", &mut || write_graphml(&mut io::sink(), &nodes, &couples())),
        ("json", &mut || write_node_link(&mut io::sink(), &nodes, &couples(), false)),
    ];
    for (format, write) in &mut writers {
        PEAK.reset_peak_usage();
        let before = PEAK.current_usage();
        write().unwrap();
        let more = PEAK.peak_usage() - before;
        assert!(more < 24 << 20, "{format}: {more} bytes for {} of rows", 44 * ROWS);
    }
}
