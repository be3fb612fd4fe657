//! Written files have the documented bytes, and other readers accept them.

#![allow(clippy::cast_possible_wrap, reason = "tables of tests are short")]

use std::io::{self, Write};

use fdem_io::{
    Centres, Table, Values, read_mesh, write_csv, write_graphml, write_node_link, write_npy, write_npz,
    write_packing_csv, write_packing_npy, write_parquet, write_vtp,
};

fn distance(k: usize) -> f64 {
    0.1 * k as f64
}

fn overlap(k: usize) -> f64 {
    -1e-300 / (k as f64 + 3.0)
}

fn couples(n: usize) -> Table<'static> {
    Table::new(n)
        .with("i", Values::i64(|k| k as i64))
        .with("j", Values::i64(|k| -(k as i64) - 1))
        .with("distance", Values::f64(distance))
        .with("overlap", Values::f64(overlap))
}

/// A column of each type, and one of several components.
fn of_all_types(n: usize) -> Table<'static> {
    couples(n)
        .with("faces", Values::u64(|k| u64::MAX - k as u64))
        .with("kind", Values::text(6, |k| if k % 2 == 0 { "depth" } else { "volume" }))
        .with_components("shift", &["sx", "sy"], Values::i32(|k| [i32::MIN, 0, 7][k % 3]))
}

type Writer = fn(&mut Vec<u8>, &Table<'_>) -> io::Result<()>;

const WRITERS: [Writer; 4] = [
    |out, table| write_csv(out, table),
    |out, table| write_npy(out, table),
    |out, table| write_npz(out, &[table]),
    |out, table| write_parquet(out, table),
];

#[test]
fn couples_as_text() {
    let mut out = Vec::new();
    write_csv(&mut out, &couples(3)).unwrap();
    let text = String::from_utf8(out).unwrap();
    let expected = "i,j,distance,overlap\n\
        0,-1,0.0,-3.3333333333333334e-301\n1,-2,0.1,-2.5e-301\n2,-3,0.2,-2e-301\n";
    assert_eq!(text, expected);

    let mut out = Vec::new();
    write_csv(&mut out, &couples(0)).unwrap();
    assert_eq!(out, b"i,j,distance,overlap\n");
}

#[test]
fn all_types_as_text() {
    let mut out = Vec::new();
    write_csv(&mut out, &of_all_types(2)).unwrap();
    let expected = "i,j,distance,overlap,faces,kind,sx,sy\n\
        0,-1,0.0,-3.3333333333333334e-301,18446744073709551615,depth,-2147483648,0\n\
        1,-2,0.1,-2.5e-301,18446744073709551614,volume,7,-2147483648\n";
    assert_eq!(String::from_utf8(out).unwrap(), expected);
}

#[test]
fn all_types_as_records() {
    let mut out = Vec::new();
    write_npy(&mut out, &of_all_types(3)).unwrap();
    let mut data = out.as_slice();
    let header = npyz::NpyHeader::from_reader(&mut data).unwrap();
    assert_eq!(
        header.dtype().descr(),
        "[('i', '<i8'), ('j', '<i8'), ('distance', '<f8'), ('overlap', '<f8'), ('faces', '<u8'), ('kind', '|S6'), \
         ('sx', '<i4'), ('sy', '<i4'), ]"
    );
    assert_eq!(data.len(), 3 * 54);
    assert_eq!(&data[40..46], b"depth\0");
    assert_eq!(&data[54 + 40..54 + 46], b"volume");
    assert_eq!(i32::from_le_bytes(data[50..54].try_into().unwrap()), 0);
}

/// More rows than one chunk holds: no row is lost or repeated where chunks meet.
#[test]
fn couples_in_many_chunks() {
    const N: usize = 50_000;
    let mut out = Vec::new();
    write_csv(&mut out, &couples(N)).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert_eq!(text.lines().count(), N + 1);
    for (k, line) in text.lines().skip(1).enumerate() {
        let fields: Vec<_> = line.split(',').collect();
        assert_eq!(fields[0].parse(), Ok(k));
        assert_eq!(fields[1].parse(), Ok(-(k as i64) - 1));
        assert_eq!(fields[2].parse(), Ok(distance(k)));
        assert_eq!(fields[3].parse(), Ok(overlap(k)));
    }
}

#[test]
fn couples_as_an_array() {
    const N: usize = 50_000;
    let mut out = Vec::new();
    write_npy(&mut out, &couples(N)).unwrap();
    let mut data = out.as_slice();
    let header = npyz::NpyHeader::from_reader(&mut data).unwrap();
    assert_eq!(header.shape(), [50_000]);
    assert_eq!(
        header.dtype().descr(),
        "[('i', '<i8'), ('j', '<i8'), ('distance', '<f8'), ('overlap', '<f8'), ]"
    );
    assert_eq!((out.len() - data.len()) % 64, 0, "the data are aligned");
    assert_eq!(data.len(), 32 * N);
    for (k, bytes) in data.chunks_exact(32).enumerate() {
        let word = |k: usize| <[u8; 8]>::try_from(&bytes[8 * k..8 * k + 8]).unwrap();
        assert_eq!(i64::from_le_bytes(word(0)), k as i64);
        assert_eq!(i64::from_le_bytes(word(1)), -(k as i64) - 1);
        assert_eq!(f64::from_le_bytes(word(2)), distance(k));
        assert_eq!(f64::from_le_bytes(word(3)), overlap(k));
    }
}

/// Reads the arrays of an archive with the crates zip and npyz.
#[test]
fn columns_as_an_archive() {
    const N: usize = 50_000;
    let points = Table::new(3).with_components("positions", &["x", "y"], Values::f64(|k| k as f64));
    let mut out = Vec::new();
    write_npz(&mut out, &[&couples(N), &points]).unwrap();
    let mut archive = zip::ZipArchive::new(io::Cursor::new(out)).unwrap();
    assert_eq!(archive.len(), 5);
    let mut floats = |name: &str| {
        let file = npyz::NpyFile::new(archive.by_name(name).unwrap()).unwrap();
        (file.shape().to_vec(), file.into_vec::<f64>().unwrap())
    };
    assert_eq!(floats("overlap.npy"), (vec![N as u64], (0..N).map(overlap).collect()));
    assert_eq!(floats("positions.npy"), (vec![3, 2], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));

    let twice = write_npz(&mut Vec::new(), &[&couples(1), &couples(1)]).unwrap_err();
    assert_eq!(
        (twice.kind(), twice.to_string().as_str()),
        (io::ErrorKind::InvalidInput, "two arrays are called distance")
    );
}

/// Reads the file with the crate that wrote it; `python/test_written.py` reads it with pyarrow and polars.
#[test]
fn columns_as_parquet() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    // More than one group of rows.
    const N: usize = (1 << 20) + 5;
    let mut out = Vec::new();
    write_parquet(&mut out, &of_all_types(N)).unwrap();
    let reader = SerializedFileReader::new(bytes::Bytes::from(out)).unwrap();
    assert_eq!(reader.metadata().num_row_groups(), 2);
    let mut rows = 0;
    for (k, row) in reader.get_row_iter(None).unwrap().enumerate() {
        let row = row.unwrap();
        let fields: Vec<_> = row.get_column_iter().map(|(_, field)| field.clone()).collect();
        rows += 1;
        if k % 1013 != 0 && k + 10 < N {
            continue;
        }
        let expected = [
            Field::Long(k as i64),
            Field::Long(-(k as i64) - 1),
            Field::Double(distance(k)),
            Field::Double(overlap(k)),
            Field::ULong(u64::MAX - k as u64),
            Field::Str(if k % 2 == 0 { "depth" } else { "volume" }.to_owned()),
            Field::Int([i32::MIN, 0, 7][2 * k % 3]),
            Field::Int([i32::MIN, 0, 7][(2 * k + 1) % 3]),
        ];
        assert_eq!(fields, expected, "{k}");
    }
    assert_eq!(rows, N);
}

/// Points on a line, and lines from each to the next.
fn chain(n: usize) -> (Table<'static>, Table<'static>) {
    let points = Table::new(n)
        .with_components(
            "positions",
            &["x", "y", "z"],
            Values::f64(|k| if k % 3 == 0 { k as f64 } else { 0.5 }),
        )
        .with("id", Values::i64(|k| 10 + k as i64));
    let lines = Table::new(n.saturating_sub(1))
        .with_components("ends", &["i", "j"], Values::i64(|k| (k / 2 + k % 2) as i64))
        .with("overlap", Values::f64(overlap));
    (points, lines)
}

/// Reads the file with our own reader of VTP files; `python/test_written.py` reads it with VTK. Several
/// blocks, some of them full.
#[test]
fn lines_for_paraview() {
    for n in [0, 1, 2, 1000, 131_073, 200_000] {
        let (points, lines) = chain(n);
        let mut out = Vec::new();
        write_vtp(&mut out, &points, &lines).unwrap();
        assert!(out.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
        if n < 2 {
            continue;
        }
        let mesh = read_mesh(&out, "chain.vtp").unwrap();
        assert_eq!(mesh.points.len(), n);
        assert!(mesh.points.iter().enumerate().all(|(k, point)| *point == [3.0 * k as f64, 0.5, 0.5]), "{n}");
        assert_eq!(mesh.segments.nodes.len(), n - 1);
        assert!(mesh.segments.nodes.iter().zip(0..).all(|(&ends, k)| ends == [k, k + 1]), "{n}");
    }
}

#[test]
fn what_is_no_line_is_refused() {
    let (points, lines) = chain(3);
    for (points, lines) in [
        (&points, &points),
        (&lines, &lines),
        (&Table::new(0), &lines),
        (&points, &chain(3).1.with("kind", Values::text(3, |_| "gap"))),
    ] {
        let error = write_vtp(&mut Vec::new(), points, lines).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    }
}

#[test]
fn graphs() {
    let elements = Table::new(2)
        .with("id", Values::i64(|k| [7, -2][k]))
        .with_components("positions", &["x", "y"], Values::f64(|k| k as f64))
        .with("radius", Values::f64(|_| f64::INFINITY));
    let couples = Table::new(1)
        .with("i", Values::i64(|_| 7))
        .with("j", Values::i64(|_| -2))
        .with("kind", Values::text(3, |_| "gap"))
        .with("count", Values::u64(|_| 1));
    let mut out = Vec::new();
    write_node_link(&mut out, &elements, &couples, true).unwrap();
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "{\"directed\":false,\"multigraph\":true,\"graph\":{},\"nodes\":[\n\
         {\"id\":7,\"x\":0.0,\"y\":1.0,\"radius\":null},\n{\"id\":-2,\"x\":2.0,\"y\":3.0,\"radius\":null}],\
         \"edges\":[\n{\"source\":7,\"target\":-2,\"kind\":\"gap\",\"count\":1}]}\n"
    );
    let mut out = Vec::new();
    write_graphml(&mut out, &elements, &couples).unwrap();
    let text = String::from_utf8(out).unwrap();
    for part in [
        "<key id=\"n2\" for=\"node\" attr.name=\"radius\" attr.type=\"double\"/>",
        "<key id=\"e0\" for=\"edge\" attr.name=\"kind\" attr.type=\"string\"/>",
        "<node id=\"-2\"><data key=\"n0\">2.0</data>",
        "<edge source=\"7\" target=\"-2\"><data key=\"e0\">gap</data><data key=\"e1\">1</data></edge>",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let nameless = Table::new(1);
    assert!(write_graphml(&mut Vec::new(), &nameless, &couples).is_err());
    assert!(write_node_link(&mut Vec::new(), &elements, &nameless, false).is_err());
}

#[test]
fn packings_as_text() {
    let mut out = Vec::new();
    let centres = Centres::Three(vec![[1.0, -2.5, 1e-7]]);
    write_packing_csv(&mut out, &centres, None).unwrap();
    write_packing_csv(&mut out, &centres, Some(&[0.5])).unwrap();
    write_packing_csv(&mut out, &Centres::Two(vec![]), Some(&[])).unwrap();
    let expected = "x,y,z\n1.0,-2.5,1e-7\nx,y,z,radius\n1.0,-2.5,1e-7,0.5\nx,y,radius\n";
    assert_eq!(String::from_utf8(out).unwrap(), expected);
}

#[test]
fn packings_as_arrays() {
    let shape = |centres: &Centres, radii: Option<&[f64]>| {
        let mut out = Vec::new();
        write_packing_npy(&mut out, centres, radii).unwrap();
        let file = npyz::NpyFile::new(out.as_slice()).unwrap();
        let (shape, descr) = (file.shape().to_vec(), file.dtype().descr());
        (shape, descr, file.into_vec::<f64>().ok())
    };
    let flat = Centres::Two(vec![[1.0, 2.0], [3.0, 4.0]]);
    let solid = Centres::Three(vec![[1.0, 2.0, 3.0]]);
    assert_eq!(shape(&flat, None), (vec![2, 2], "'<f8'".into(), Some(vec![1.0, 2.0, 3.0, 4.0])));
    assert_eq!(shape(&solid, None), (vec![1, 3], "'<f8'".into(), Some(vec![1.0, 2.0, 3.0])));
    assert_eq!(shape(&solid, Some(&[9.0])), (vec![1, 4], "'<f8'".into(), Some(vec![1.0, 2.0, 3.0, 9.0])));
    let fields = "[('x', '<f8'), ('y', '<f8'), ('radius', '<f8'), ]";
    assert_eq!(shape(&flat, Some(&[8.0, 9.0])), (vec![2], fields.into(), None));
}

#[test]
fn lengths_that_disagree_are_refused() {
    let centres = Centres::Two(vec![[0.0, 0.0]]);
    let kind = |result: io::Result<()>| result.map_err(|error| error.kind());
    assert_eq!(
        kind(write_packing_csv(&mut Vec::new(), &centres, Some(&[]))),
        Err(io::ErrorKind::InvalidInput)
    );
    assert_eq!(
        kind(write_packing_npy(&mut Vec::new(), &centres, Some(&[]))),
        Err(io::ErrorKind::InvalidInput)
    );
}

#[test]
fn a_full_disk_is_reported() {
    struct Full(usize);
    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    for room in [0, 300_000] {
        let (points, lines) = chain(200_000);
        let full = [
            write_csv(&mut Full(room), &couples(50_000)),
            write_npy(&mut Full(room), &couples(50_000)),
            write_npz(&mut Full(room), &[&couples(50_000)]),
            write_parquet(&mut Full(room), &couples(50_000)),
            write_vtp(&mut Full(room), &points, &lines),
            write_graphml(&mut Full(room), &couples(50_000), &couples(50_000)),
            write_node_link(&mut Full(room), &couples(50_000), &couples(50_000), false),
        ];
        for (k, result) in full.into_iter().enumerate() {
            assert_eq!(result.unwrap_err().kind(), io::ErrorKind::StorageFull, "writer {k}, room for {room}");
        }
    }
}

#[test]
fn the_same_table_gives_the_same_bytes() {
    for writer in WRITERS {
        let [mut once, mut again] = [Vec::new(), Vec::new()];
        writer(&mut once, &of_all_types(1000)).unwrap();
        writer(&mut again, &of_all_types(1000)).unwrap();
        assert!(once == again);
    }
}
